//! The keys of studies and of the command line, each defined once: kind of value, meaning, and conditions.

use super::declared::words;
use super::method::{
    APPROXIMATED, CRYSTAL, KERNEL_METHOD, LATTICE, METHOD_KEYS, MethodSettings, NODES_OR_PARTICLES,
    WEIGHTED,
};
use super::moduli::{MODULI, is_modulus};
use super::needs::{Cases, is, is_not};
use super::relaxation::{self, RELAXATION_KEYS};
use super::renamed;
use super::softening::{is_of_softening, softening_keys};
use super::time::TIME_KEYS;
use super::{
    MapSettings, Model, OUTPUTS, Plane, RunStep, StateSettings, TimeIntegrator, Units, Value,
    aliases, word_of,
};
use onset::approximation::Approximation;
use onset::kinematics::STRETCHES;
use onset::lattice::LatticeKind;
use onset::material::Admitted::{self, Any, Between, Positive, Within};
use onset::material::Parameter;
use onset::method::{
    Background, CurrentLattice, Frame, KernelMethodChoices, Linearization, SupportSize,
};
use onset::quadrature::Quadrature;
use std::collections::BTreeMap;
use std::sync::{LazyLock, Mutex, PoisonError};

/// Kind of value that a key accepts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// One word of a list.
    Words(&'static [&'static str]),
    /// One word of a list, or a text of another kind.
    WordsOr(&'static [&'static str], &'static str),
    /// A number in a unit, within limits.
    Number(&'static str, Admitted),
    /// A whole number between two limits.
    Whole(u32, u32),
    /// A power of two between two limits.
    PowerOfTwo(u32, u32),
    /// A Boolean, `true` or `false`.
    Switch,
    /// An arbitrary text, such as a formula.
    Text,
    /// A list of numbers in a unit, each within limits.
    Numbers(&'static str, Admitted),
    /// A list of some of these words.
    Subset(&'static [&'static str]),
}

impl Kind {
    /// Description of the expected value.
    pub fn expects(self) -> String {
        let with_unit = |what: &str, unit: &str| match unit {
            "1" => what.to_owned(),
            unit => format!("{what} ({unit})"),
        };
        match self {
            Self::Words(words) => words.join(" | "),
            Self::WordsOr(words, other) => format!("{} | {other}", words.join(" | ")),
            Self::Number(unit, admitted) => with_unit(&admitted.expected(unit), unit),
            Self::Whole(least, most) => format!("a whole number from {least} to {most}"),
            Self::PowerOfTwo(least, most) => format!("a power of two from {least} to {most}"),
            Self::Switch => "true | false".to_owned(),
            Self::Text => "a string".to_owned(),
            Self::Numbers(unit, admitted) => {
                let numbers = admitted.expected(unit).replacen("number", "numbers", 1);
                with_unit(
                    &format!("a list of{}", numbers.trim_start_matches('a')),
                    unit,
                )
            }
            Self::Subset(words) => {
                format!("a list of any of {}, each at most once", words.join(", "))
            }
        }
    }

    /// Kind of the value other than a word: `number`, `whole`, `switch` or `text`; `None` if only words are accepted.
    pub fn takes(self) -> Option<&'static str> {
        match self {
            Self::Words(_) => None,
            Self::Number(..) => Some("number"),
            Self::Whole(..) | Self::PowerOfTwo(..) => Some("whole"),
            Self::Switch => Some("switch"),
            Self::WordsOr(..) | Self::Text | Self::Numbers(..) | Self::Subset(_) => Some("text"),
        }
    }

    /// Smallest and largest number; `None` if the key takes no number.
    pub fn limits(self) -> Option<[f64; 2]> {
        match self {
            Self::Whole(least, most) | Self::PowerOfTwo(least, most) => {
                Some([least, most].map(f64::from))
            }
            Self::Number(unit, admitted) | Self::Numbers(unit, admitted) => {
                Some(admitted.limits(unit))
            }
            _ => None,
        }
    }

    /// Returns true if the value is of this kind.
    pub fn accepts(self, value: &Value) -> bool {
        let whole = |number: f64, least: u32, most: u32| {
            number.fract() == 0.0 && (f64::from(least)..=f64::from(most)).contains(&number)
        };
        match (self, value) {
            (Self::Words(words), Value::Word(word)) => words.contains(&word.as_str()),
            (Self::Switch, Value::Switch(_)) | (Self::Text | Self::WordsOr(..), Value::Word(_)) => {
                true
            }
            (Self::Subset(words), Value::Words(chosen)) => {
                let is_new = |n: usize| !chosen[..n].contains(&chosen[n]);
                let is_known = |n: usize| words.contains(&chosen[n].as_str());
                (0..chosen.len()).all(|n| is_known(n) && is_new(n))
            }
            (Self::Numbers(unit, admitted), Value::Numbers(numbers)) => {
                numbers.iter().all(|number| admitted.holds(*number, unit))
            }
            (kind, Value::Number(number)) => match kind {
                Self::Number(unit, admitted) => admitted.holds(*number, unit),
                Self::Whole(least, most) => whole(*number, least, most),
                Self::PowerOfTwo(least, most) => {
                    whole(*number, least, most) && (*number as u32).is_power_of_two()
                }
                Self::Words(_)
                | Self::WordsOr(..)
                | Self::Switch
                | Self::Text
                | Self::Numbers(..)
                | Self::Subset(_) => false,
            },
            _ => false,
        }
    }
}

/// Definition of a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key {
    /// Dotted name of the key.
    pub name: &'static str,
    /// Kind of value that the key accepts.
    pub kind: Kind,
    /// Meaning of the key, as documentation and schema show it.
    pub meaning: &'static str,
    /// Conditions under which the key has an effect.
    pub read_with: Cases,
}

pub(super) const fn key(name: &'static str, kind: Kind, meaning: &'static str) -> Key {
    Key {
        name,
        kind,
        meaning,
        read_with: &[],
    }
}

const EULERIAN: Cases = &[&[is("discretization.frame", &["eulerian"])]];
/// Kernel methods in current coordinates with one particle per cell.
const EULERIAN_ALONE: Cases = &[&[
    is("discretization.frame", &["eulerian"]),
    is_not(
        "discretization.lattice",
        &["honeycomb", "hexagonal-close-packed", "diamond"],
    ),
    is("discretization.basis", &["[]"]),
    is("discretization.cells", &["1"]),
]];
const DISORDERED: Cases = &[&[is_not("discretization.perturbation", &["0"])]];
const SUPPORT_SIZE: Cases = &[
    &[is("discretization.frame", &["eulerian"])],
    &[is("discretization.method", &["updated-sph"])],
];

/// All keys of material and discretization, in the order of the documentation. The keys of materials follow from the library of laws.
pub static KEYS: LazyLock<Vec<Key>> = LazyLock::new(|| {
    let models: Vec<&'static str> = Model::all().map(Model::name).collect();
    let mut keys = vec![
        key("material.model", Kind::Words(models.leak()), "the law"),
        key(
            "material.plane",
            Kind::Words(words::<Plane>()),
            "in two dimensions plane strain, plane stress (a thin sheet whose thickness is computed) or membrane (a two-dimensional law, as for cloth); in one dimension, uniaxial strain or uniaxial stress",
        ),
    ];
    keys.extend(RELAXATION_KEYS);
    keys.extend(softening_keys());
    keys.extend(parameter_keys());
    for key in Model::all().flat_map(Model::keys) {
        // Models may share keys.
        if keys.iter().all(|known| known.name != key.name) {
            keys.push(*key);
        }
    }
    keys.extend(discretization_keys());
    keys.extend(METHOD_KEYS.iter().copied());
    keys.extend(TIME_KEYS);
    keys
});

/// One key for each parameter name of any law.
fn parameter_keys() -> Vec<Key> {
    let mut keys: Vec<Key> = Vec::new();
    for parameter in Model::all().flat_map(Model::parameters) {
        let name = format!("material.{}", parameter.name);
        if keys.iter().any(|key| key.name == name) {
            continue;
        }
        let of_name = || {
            Model::all().filter_map(|model| {
                let mut own = model.parameters().iter();
                Some((model, own.find(|own| own.name == parameter.name)?))
            })
        };
        let kind = Kind::Number(parameter.unit, hull(of_name().map(|(_, own)| own)));
        keys.push(key(name.leak(), kind, meaning(of_name()).leak()));
    }
    for (name, unit, admitted, meaning) in MODULI {
        let name = format!("material.{name}").leak();
        keys.push(key(name, Kind::Number(unit, admitted), meaning));
    }
    keys
}

/// Union of the ranges of a parameter in all laws. The law itself restricts the number further, and a user-defined model may use the name for another
/// parameter.
fn hull(parameters: impl Iterator<Item = &'static Parameter>) -> Admitted {
    let mut all = parameters.map(|own| (own.admitted, own.admitted.limits(own.unit)));
    let Some((first, [mut low, mut high])) = all.next() else {
        return Any;
    };
    let mut is_one = true;
    for (other, limits) in all {
        is_one &= other == first;
        (low, high) = (low.min(limits[0]), high.max(limits[1]));
    }
    if is_one { first } else { Within(low, high) }
}

/// Range of positive ratios.
const RATIO: Admitted = Within(1e-3, 1e3);
/// Range of principal stretches.
pub(super) const STRETCH: Admitted = Within(STRETCHES.0, STRETCHES.1);
/// Range of support radii and horizons in spacings.
pub(super) const IN_SPACINGS: Admitted = Within(1e-3, 1e4);
/// Range of the parameters of a user-defined model.
pub(super) const ANY_DIMENSION: Admitted = Within(-1e30, 1e30);

/// Key that sets the support in smoothing lengths; the support is the setting in effect.
static SMOOTHING_LENGTH: Key = key(
    aliases::SMOOTHING_LENGTH,
    Kind::Number("1", Positive),
    "smoothing length divided by the spacing, h/dx: sets discretization.support to h/dx times R0/h, the ratio of support radius to smoothing length of the kernel (2 for the cubic spline)",
)
.only_with(WEIGHTED);

/// Meaning of a parameter; laws with the same meaning are listed together.
fn meaning(of_name: impl Iterator<Item = (Model, &'static Parameter)>) -> String {
    let mut meanings: Vec<(&str, Vec<&str>)> = Vec::new();
    for (model, parameter) in of_name {
        match meanings
            .iter_mut()
            .find(|(meaning, _)| *meaning == parameter.meaning)
        {
            Some((_, models)) => models.push(model.name()),
            None => meanings.push((parameter.meaning, vec![model.name()])),
        }
    }
    let told: Vec<String> = meanings
        .into_iter()
        .map(|(meaning, models)| format!("{meaning} of {}", models.join(", ")))
        .collect();
    told.join("; ")
}

/// The names of the kernels, as in [`Kernel::ALL`](onset::kernel::Kernel::ALL).
const KERNELS: &[&str] = &[
    "quartic-spline",
    "cubic-spline",
    "quartic-b-spline",
    "quintic-spline",
    "wendland-c2",
    "wendland-c4",
    "wendland-c6",
    "gaussian",
    "hyperbolic",
    "laguerre-gauss",
];

fn discretization_keys() -> Vec<Key> {
    vec![
    key(
        "discretization.lattice",
        Kind::Words(words::<LatticeKind>()),
        "lattice of the particles",
    )
    .only_with(LATTICE),
    key(
        "discretization.aspect",
        Kind::Number("1", RATIO),
        "rectangular lattice: side ratio b/a, of the second to the first side",
    )
    .only_with(const { &[&[is("discretization.lattice", &["rectangular"])]] }),
    key(
        "discretization.vectors",
        Kind::Numbers("1", Any),
        "oblique and triclinic lattice: components of the primitive vectors in spacings, one vector after the other; finite elements: images of the unit vectors, which shear the mesh",
    )
    .only_with(const { &[
        &[is("discretization.lattice", &["oblique", "triclinic"])],
        &[is("discretization.method", &["finite-elements"])],
    ] }),
    key(
        "discretization.basis",
        Kind::Numbers("1", Any),
        "lattice coordinates of further particles in the cell, one particle after the other; the first particle is at the origin",
    )
    .only_with(CRYSTAL),
    key(
        "discretization.cells",
        Kind::Whole(1, 16),
        "cells along each primitive vector that form one larger cell, so that their particles can differ",
    )
    .only_with(NODES_OR_PARTICLES),
    key(
        "discretization.perturbation",
        Kind::Number("1", Within(0.0, 0.5)),
        "largest random offset of a particle or node along each axis, in spacings",
    )
    .only_with(NODES_OR_PARTICLES),
    key(
        "discretization.seed",
        Kind::Whole(0, 1_000_000_000),
        "seed of the random offsets",
    )
    .only_with(DISORDERED),
    key(
        "discretization.spacing",
        Kind::Number("length", Positive),
        "distance between nearest particles or nodes (for material points, the side of a grid cell); the unit of vectors and support",
    ),
    key(
        "discretization.density",
        Kind::Number("mass/volume", Positive),
        "reference density",
    ),
    key(
        "discretization.kernel",
        Kind::WordsOr(KERNELS, "a formula of q = r / R0"),
        "weight function",
    )
    .only_with(WEIGHTED),
    key(
        "discretization.support",
        Kind::Number("1", IN_SPACINGS),
        "support radius, D_mx, in units of discretization.spacing",
    )
    .only_with(WEIGHTED),
    key(
        "discretization.approximation",
        Kind::Words(words::<Approximation>()),
        "correction of the weights",
    )
    .only_with(APPROXIMATED),
    key(
        "discretization.quadrature",
        Kind::Words(words::<Quadrature>()),
        "quadrature points",
    )
    .only_with(KERNEL_METHOD),
    key(
        "discretization.stress-point-weight",
        Kind::Number("1", Between(0.0, 1.0)),
        "fraction of the cell's volume at the stress points, below 1; Voronoi volumes by default",
    )
    .only_with(const { &[&[is("discretization.quadrature", &["stress-points"])]] }),
    key(
        "discretization.gauss-points",
        Kind::Whole(1, 4),
        "Gauss points per direction",
    )
    .only_with(const { &[&[is("discretization.quadrature", &["gauss"])]] }),
    key(
        "discretization.points",
        Kind::Numbers("1", Any),
        "the lattice coordinates of each point and its fraction of the cell's volume, in one list; \
         the fractions add up to 1",
    )
    .only_with(const { &[&[is("discretization.quadrature", &["points"])]] }),
    key(
        "discretization.frame",
        Kind::Words(words::<Frame>()),
        "coordinates of the kernel",
    )
    .only_with(KERNEL_METHOD),
    key(
        "discretization.background",
        Kind::Words(words::<Background>()),
        "deformation that the quadrature points carry",
    )
    .only_with(KERNEL_METHOD),
    key(
        "discretization.current-lattice",
        Kind::Words(words::<CurrentLattice>()),
        "Eulerian kernels: lattice in the deformed state",
    )
    .only_with(EULERIAN_ALONE),
    key(
        "discretization.support-size",
        Kind::Words(words::<SupportSize>()),
        "Eulerian kernels and updated SPH: change of the support with the deformation",
    )
    .only_with(SUPPORT_SIZE),
    key(
        "discretization.linearization",
        Kind::Words(words::<Linearization>()),
        "Eulerian kernels: quantities that the linearization varies",
    )
    .only_with(EULERIAN),
]
}

/// The keys of a study for the deformation that no axis varies.
pub const STATE_KEYS: &[Key] = &[
    key(
        "state.stretch-1",
        Kind::Number("1", STRETCH),
        "first stretch, if no axis varies it",
    ),
    key(
        "state.stretch-2",
        Kind::Number("1", STRETCH),
        "second stretch, if no axis varies it",
    ),
    key(
        "state.stretch-3",
        Kind::Number("1", STRETCH),
        "third stretch (in two dimensions out of the plane), if no axis varies it",
    ),
    key(
        "state.shear",
        Kind::Number("1", Any),
        "amount of shear, if no axis varies it",
    ),
    key(
        "state.rotation",
        Kind::Number("rad", Any),
        "angle from the load to the lattice, about the third axis, if no axis varies it",
    ),
];

/// The keys of a study for its map.
pub const MAP_KEYS: &[Key] = &[
    key(
        "map.adaptive",
        Kind::Switch,
        "refine only where the verdict changes",
    ),
    key(
        "map.refine-from",
        Kind::PowerOfTwo(2, 1024),
        "coarsest stride of the refinement, in states; at most the edge of a tile",
    )
    .only_with(&[&[is("map.adaptive", &["true"])]]),
    key(
        "map.certify",
        Kind::Switch,
        "prove stability and instability",
    ),
    key(
        "map.tolerance",
        Kind::Number("1", Within(1e-9, 1.0)),
        "largest distance from the boundary at which a certified state may remain undecided",
    )
    .only_with(&[&[is("map.certify", &["true"])]]),
    key(
        "map.tile",
        Kind::Whole(8, 1024),
        "states along an edge of a tile, the unit of work and of storage",
    ),
    key(
        "map.outputs",
        Kind::Subset(OUTPUTS),
        "numbers stored for each state in addition to verdict and stability",
    ),
];

/// Key of the smoothing length, which is not in the tables because the support is the setting in effect.
pub(super) fn smoothing_length() -> &'static Key {
    &SMOOTHING_LENGTH
}

/// Every key that a study can set, in the order of the documentation, except axes and title.
pub fn study_keys() -> impl Iterator<Item = &'static Key> + Clone {
    KEYS.iter().chain(STATE_KEYS).chain(MAP_KEYS)
}

/// Key for a parameter that no law has, but a user-defined model may have. Returns the same key for the same name.
fn free_parameter(name: &str) -> &'static Key {
    static FREE_KEYS: Mutex<BTreeMap<String, &'static Key>> = Mutex::new(BTreeMap::new());
    let mut known = FREE_KEYS.lock().unwrap_or_else(PoisonError::into_inner);
    known.entry(name.to_owned()).or_insert_with(|| {
        let name: &'static str = name.to_owned().leak();
        let meaning = "a user-defined parameter";
        Box::leak(Box::new(key(
            name,
            Kind::Number("1", ANY_DIMENSION),
            meaning,
        )))
    })
}

impl Key {
    /// Returns the key with the given name, or `None`: one of [`study_keys`], or `material.` with a parameter name of a user-defined model (letters, digits and `_`, a
    /// letter first).
    pub fn named(name: &str) -> Option<&'static Self> {
        let name = aliases::of_key(name);
        if name == SMOOTHING_LENGTH.name {
            return Some(&SMOOTHING_LENGTH);
        }
        let is_name = |text: &str| {
            text.starts_with(|first: char| first.is_ascii_alphabetic())
                && text
                    .chars()
                    .all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-'))
        };
        study_keys().find(|key| key.name == name).or_else(|| {
            let is_free = name.strip_prefix("material.").is_some_and(is_name);
            is_free.then(|| free_parameter(name))
        })
    }

    /// Returns the key with a name that is about to be set. An unknown name is a user-defined parameter only if its value is a number.
    pub(super) fn for_setting(name: &str, is_number: bool) -> Option<&'static Self> {
        let name = renamed::key(name);
        Self::named(name).filter(|key| is_number || !key.is_free())
    }

    /// Returns true for a user-defined parameter, which is not in the tables.
    pub(crate) fn is_free(&self) -> bool {
        self.parts().0 == "material" && study_keys().all(|known| known.name != self.name)
    }

    /// Returns true for a number of material or discretization that an axis can vary.
    pub fn is_varied(&self) -> bool {
        self.unit().is_some() && matches!(self.parts().0, "material" | "discretization")
    }

    /// Returns true for a modulus that can be set instead of parameters of a law.
    pub(super) fn is_modulus(&self) -> bool {
        self.parts().0 == "material" && is_modulus(self.parts().1)
    }

    /// Returns true for a parameter of a law.
    pub fn is_parameter(&self) -> bool {
        let (section, name) = self.parts();
        section == "material" && self.unit().is_some() && !is_of_softening(name)
    }

    pub(super) const fn only_with(mut self, cases: Cases) -> Self {
        self.read_with = cases;
        self
    }

    /// Description of the expected value.
    pub fn expects(&self) -> String {
        self.kind.expects()
    }

    /// Words that the key accepts; empty if it accepts a number.
    pub fn words(&self) -> &'static [&'static str] {
        match self.kind {
            Kind::Words(words) | Kind::WordsOr(words, _) => words,
            _ => &[],
        }
    }

    /// Section, and name within the section.
    pub fn parts(&self) -> (&'static str, &'static str) {
        self.name.split_once('.').unwrap_or(("", self.name))
    }

    /// Name of the quantity in a figure: the beginning of the meaning, up to the first remark. Symbol of a parameter whose meaning depends on the law.
    ///
    /// ```
    /// use onset_study::settings::Key;
    /// let title = |name| Key::named(name).map(|key| key.title());
    /// assert_eq!(title("material.young"), Some("Young's modulus"));
    /// assert_eq!(title("discretization.artificial-stress"), Some("coefficient of artificial stress"));
    /// assert_eq!(title("material.mu"), Some("mu"));
    /// ```
    pub fn title(&self) -> &'static str {
        let (section, name) = self.parts();
        let meaning = if section == "material" && !is_modulus(name) {
            let mut parameters = Model::all()
                .flat_map(Model::parameters)
                .filter(|parameter| parameter.name == name);
            match parameters.next() {
                Some(first) if parameters.all(|other| other.meaning == first.meaning) => {
                    first.meaning
                }
                _ => name,
            }
        } else {
            self.meaning
        };
        // The methods that read a key are named before a colon.
        let meaning = match meaning.split_once(": ") {
            Some((methods, rest)) if !methods.contains([',', ';', '(']) => rest,
            _ => meaning,
        };
        let end = [", ", "; ", ": ", " ("]
            .into_iter()
            .filter_map(|mark| meaning.find(mark))
            .min();
        &meaning[..end.unwrap_or(meaning.len())]
    }

    /// Label of an axis over the values of the key: its title with the unit.
    pub fn label(&self, units: Units) -> String {
        units.label(self.title(), self.unit().unwrap_or("1"))
    }

    /// Unit or dimension of a key that takes a number, `1` if dimensionless; `None` for other keys.
    pub fn unit(&self) -> Option<&'static str> {
        match self.kind {
            Kind::Number(unit, _) => Some(unit),
            _ => None,
        }
    }

    /// Default value; for a parameter of several laws, `null` unless their defaults agree.
    pub fn default_json(&self) -> serde_json::Value {
        let field = |value: Result<serde_json::Value, serde_json::Error>, name: &str| {
            value.map_or(serde_json::Value::Null, |defaults| defaults[name].clone())
        };
        match self.parts() {
            ("material", "model") => Model::default().name().into(),
            ("material", "plane") => word_of(&Plane::default()).into(),
            ("material", name) if relaxation::is_of_relaxation(name) => {
                relaxation::default_of(name).into()
            }
            ("material", name) => {
                let mut defaults = Model::all().flat_map(Model::parameters);
                let first = defaults.find(|parameter| parameter.name == name);
                let mut others = defaults.filter(|parameter| parameter.name == name);
                match first {
                    Some(first) if others.all(|other| other.default == first.default) => {
                        first.default.into()
                    }
                    _ => serde_json::Value::Null,
                }
            }
            ("state", name) => field(serde_json::to_value(StateSettings::default()), name),
            ("map", name) => field(serde_json::to_value(MapSettings::default()), name),
            ("body" | "grips", _) => serde_json::Value::Null,
            ("time", "step") => RunStep::default().step.into(),
            ("time", "stepping") => RunStep::default().stepping.name().into(),
            ("time", _) => TimeIntegrator::default().name().into(),
            (_, name) => match field(serde_json::to_value(KernelMethodChoices::default()), name) {
                serde_json::Value::Null => {
                    field(serde_json::to_value(MethodSettings::default()), name)
                }
                default => default,
            },
        }
    }

    /// Default value as it would be typed on the command line.
    pub fn default_value(&self) -> String {
        match self.default_json() {
            serde_json::Value::String(word) => word,
            serde_json::Value::Null => String::new(),
            serde_json::Value::Array(words) => {
                let words: Vec<&str> = words.iter().filter_map(|word| word.as_str()).collect();
                words.join(",")
            }
            serde_json::Value::Number(number) => number
                .as_f64()
                .map_or_else(|| number.to_string(), crate::number::exact),
            other => other.to_string(),
        }
    }
}
