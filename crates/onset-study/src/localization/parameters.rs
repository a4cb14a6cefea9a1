//! Parameters of plastic laws and loading paths, each defined once.

use super::LocalizationError;
use crate::settings::{
    Key, Kind, MaterialSettings, Origin, SettingError, Settings, Units, Value, units, unknown_key,
};
use onset::material::Admitted::{Any, Between, Fraction, NotNegative, Positive, Within};
use onset::material::MaterialError;
use onset::plasticity::{
    Bands, CamClay, DeformationTheory, DruckerPrager, Elasticity, EllipticCap, FlowLaw, Gurson,
    Hardening, HillOrthotropic, IncrementalLaw, Kinematic, Load, Loading, LoadingPath, MohrCoulomb,
    PlasticityError, ScalarDamage, Strains,
};
use onset_umat::Umat;
use serde::de::DeserializeOwned;

/// Definition of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Dotted name of the parameter.
    pub name: &'static str,
    /// Kind of value that the parameter accepts.
    pub kind: Kind,
    /// Default value, as the user would type it.
    pub default: &'static str,
    /// Meaning, with formula or options.
    pub meaning: &'static str,
    /// Condition for an effect: another parameter and its admissible values; `None` without a condition.
    pub only_with: Option<(&'static str, &'static [&'static str])>,
}

const fn parameter(
    name: &'static str,
    kind: Kind,
    default: &'static str,
    meaning: &'static str,
) -> Parameter {
    Parameter {
        name,
        kind,
        default,
        meaning,
        only_with: None,
    }
}

impl Parameter {
    const fn only_with(mut self, name: &'static str, words: &'static [&'static str]) -> Self {
        self.only_with = Some((name, words));
        self
    }

    fn default_value(&self) -> Value {
        Value::typed(self.default, Some(self.kind))
    }

    /// Converts the parameter to a key of settings, so that it accepts units.
    fn key(&self) -> Key {
        Key {
            name: self.name,
            kind: self.kind,
            meaning: self.meaning,
            read_with: &[],
        }
    }

    /// SI unit of the parameter, if it has a dimension.
    fn si_unit(&self) -> Option<&'static str> {
        self.key().unit().and_then(units::si)
    }

    fn words(&self) -> &'static [&'static str] {
        match self.kind {
            Kind::Words(words) => words,
            _ => &[],
        }
    }
}

const CONFINEMENT: &str = "plasticity.confinement";
const MODEL: &str = "plasticity.model";
const HARDENING: &str = "plasticity.hardening";
/// Model names of user routines, which are specified by keys of `[material]`. First yield is determined from their tangent; differences of the stress
/// of a VUMAT do not resolve it.
const ROUTINES: &[&str] = &["umat", "library"];

pub(crate) const MODELS: &[&str] = &[
    "drucker-prager",
    "j2",
    "mohr-coulomb",
    "hill-1948",
    "kinematic",
    "gurson",
    "cam-clay",
    "cap",
    "damage",
    "deformation-theory",
    "umat",
    "library",
];
/// Models with isotropic elasticity.
const WITH_ELASTICITY: &[&str] = MODELS.split_at(MODELS.len() - ROUTINES.len()).0;
/// Models whose strength follows `plasticity.hardening`.
const HARDENING_WITH_SLIP: &[&str] = &[
    "drucker-prager",
    "j2",
    "mohr-coulomb",
    "hill-1948",
    "kinematic",
    "gurson",
    "damage",
    "deformation-theory",
];
/// Models that use `plasticity.strength`.
const WITH_STRENGTH: &[&str] = &[
    "drucker-prager",
    "j2",
    "mohr-coulomb",
    "hill-1948",
    "kinematic",
    "gurson",
    "cap",
    "damage",
    "deformation-theory",
];

/// All parameters, in the order of the documentation.
pub const PARAMETERS: &[Parameter] = &[
    parameter(
        MODEL,
        Kind::Words(MODELS),
        "drucker-prager",
        "yield surface and flow rule",
    ),
    parameter(
        "plasticity.shear-modulus",
        Kind::Number("stress", Positive),
        "10000",
        "elastic shear modulus G",
    )
    .only_with(MODEL, WITH_ELASTICITY),
    parameter(
        "plasticity.poisson-ratio",
        Kind::Number("1", Between(-1.0, 0.5)),
        "0.2",
        "Poisson's ratio",
    )
    .only_with(MODEL, WITH_ELASTICITY),
    parameter(
        "plasticity.friction",
        Kind::Number("1", NotNegative),
        "0.6",
        "pressure coefficient mu of the yield surface",
    )
    .only_with(MODEL, &["drucker-prager"]),
    parameter(
        "plasticity.dilatancy",
        Kind::Number("1", Any),
        "0.2",
        "dilatancy beta of the flow; equal to the friction for associated flow",
    )
    .only_with(MODEL, &["drucker-prager"]),
    parameter(
        "plasticity.friction-angle",
        Kind::Number("1", Within(0.0, 90.0)),
        "30",
        "angle of friction phi in degrees",
    )
    .only_with(MODEL, &["mohr-coulomb"]),
    parameter(
        "plasticity.dilation-angle",
        Kind::Number("1", Between(-90.0, 90.0)),
        "10",
        "dilation angle psi in degrees; equal to the friction angle for associated flow",
    )
    .only_with(MODEL, &["mohr-coulomb"]),
    parameter(
        "plasticity.r0",
        Kind::Number("1", Positive),
        "1",
        "ratio of widthwise to thickness strain in tension along axis 1 (3 is normal to the sheet)",
    )
    .only_with(MODEL, &["hill-1948"]),
    parameter(
        "plasticity.r90",
        Kind::Number("1", Positive),
        "1",
        "ratio of widthwise to thickness strain in tension along axis 2",
    )
    .only_with(MODEL, &["hill-1948"]),
    parameter(
        "plasticity.kinematic-modulus",
        Kind::Number("stress", Any),
        "200",
        "modulus c of the back stress: its slope in shear, in addition to hardening of the strength",
    )
    .only_with(MODEL, &["kinematic"]),
    parameter(
        "plasticity.recovery",
        Kind::Number("1", NotNegative),
        "0",
        "recovery b of the back stress, which tends to c/b in shear; 0: no recovery",
    )
    .only_with(MODEL, &["kinematic"]),
    parameter(
        "plasticity.voids",
        Kind::Number("1", Fraction),
        "0.01",
        "volume fraction of voids at first yield",
    )
    .only_with(MODEL, &["gurson"]),
    parameter(
        "plasticity.q1",
        Kind::Number("1", Positive),
        "1.5",
        "Tvergaard's constant q1; 1 for Gurson's law as published",
    )
    .only_with(MODEL, &["gurson"]),
    parameter(
        "plasticity.q2",
        Kind::Number("1", Positive),
        "1",
        "Tvergaard's constant q2",
    )
    .only_with(MODEL, &["gurson"]),
    parameter(
        "plasticity.critical-slope",
        Kind::Number("1", Positive),
        "1",
        "slope M of the critical state line, q = M p",
    )
    .only_with(MODEL, &["cam-clay"]),
    parameter(
        "plasticity.cap-start",
        Kind::Number("stress", NotNegative),
        "20",
        "pressure L at which the cap begins",
    )
    .only_with(MODEL, &["cap"]),
    parameter(
        "plasticity.preconsolidation",
        Kind::Number("stress", Positive),
        "100",
        "pressure at which the material yields without shear; it grows with compaction",
    )
    .only_with(MODEL, &["cam-clay", "cap"]),
    parameter(
        "plasticity.compressibility",
        Kind::Number("1", Positive),
        "0.05",
        "plastic compaction over which plasticity.preconsolidation grows by the factor e; (lambda - kappa)/(1 + e) of soil mechanics",
    )
    .only_with(MODEL, &["cam-clay", "cap"]),
    parameter(
        HARDENING,
        Kind::Words(&["linear", "voce", "power", "peak"]),
        "peak",
        "how the strength changes with plastic shear strain",
    )
    .only_with(MODEL, HARDENING_WITH_SLIP),
    parameter(
        "plasticity.strength",
        Kind::Number("stress", Positive),
        "20",
        "yield stress in pure shear at first yield: for j2 1/sqrt(3) of the tensile yield stress, for mohr-coulomb c cos(phi), for gurson of the matrix",
    )
    .only_with(MODEL, WITH_STRENGTH),
    parameter(
        "plasticity.hardening-modulus",
        Kind::Number("stress", Any),
        "2000",
        "plastic modulus h, the slope in shear (for j2 a third of the slope in tension); for peak the slope that decays",
    )
    .only_with(HARDENING, &["linear", "peak"]),
    parameter(
        "plasticity.saturation",
        Kind::Number("stress", NotNegative),
        "10",
        "strength after large slip; below the strength for softening",
    )
    .only_with(HARDENING, &["voce"]),
    parameter(
        "plasticity.residual",
        Kind::Number("stress", NotNegative),
        "10",
        "strength after large slip",
    )
    .only_with(HARDENING, &["peak"]),
    parameter(
        "plasticity.reference-slip",
        Kind::Number("1", Positive),
        "0.05",
        "plastic shear strain over which hardening decays to 1/e; for power, the unit of plastic strain",
    )
    .only_with(HARDENING, &["voce", "power", "peak"]),
    parameter(
        "plasticity.exponent",
        Kind::Number("1", Within(-100.0, 1.0)),
        "0.1",
        "exponent of the power law; negative for softening",
    )
    .only_with(HARDENING, &["power"]),
    parameter(
        "plasticity.path",
        Kind::Words(&[
            "uniaxial-stress",
            "uniaxial-strain",
            "plane-strain",
            "pure-shear",
            "triaxial-compression",
            "sheet-stretch",
        ]),
        "plane-strain",
        "loading path",
    ),
    parameter(
        "plasticity.strain-ratio",
        Kind::Number("1", Within(-1.0, 1.0)),
        "0",
        "ratio of the strain along axis 2 to the strain along axis 1, above -1 and at most 1",
    )
    .only_with("plasticity.path", &["sheet-stretch"]),
    parameter(
        "plasticity.load",
        Kind::Words(&["tension", "compression"]),
        "compression",
        "sense of the strain along axis 1",
    )
    .only_with(
        "plasticity.path",
        &[
            "uniaxial-stress",
            "uniaxial-strain",
            "plane-strain",
            "pure-shear",
            "sheet-stretch",
        ],
    ),
    parameter(
        "plasticity.strains",
        Kind::Words(&["small", "finite"]),
        "small",
        "small strain, or finite strain with logarithmic stretches",
    ),
    parameter(
        "plasticity.bands",
        Kind::Words(&["bulk", "sheet"]),
        "bulk",
        "bands of any orientation, or necks across a thin sheet normal to axis 3",
    ),
    parameter(
        CONFINEMENT,
        Kind::Number("stress", NotNegative),
        "0",
        "initial pressure, kept by constant lateral stresses; with cam-clay half of plasticity.preconsolidation unless it is set",
    ),
    parameter(
        "plasticity.slip",
        Kind::Number("1", Within(1e-9, 1e3)),
        "0.2",
        "plastic shear strain at the end of the path",
    ),
    parameter(
        "plasticity.increments",
        Kind::Whole(2, 10_000),
        "200",
        "number of increments of a user material along the path; they are shorter near first yield",
    )
    .only_with(MODEL, ROUTINES),
];

/// Plastic law and loading path as given by the user.
#[derive(Clone, Debug, PartialEq)]
pub struct PlasticSettings {
    /// One value for each of [`PARAMETERS`].
    values: Vec<Value>,
    /// Origin of each value that was set; `None` for defaults.
    origins: Vec<Option<Origin>>,
    /// Whether each value was given with a unit; it is then in SI.
    with_units: Vec<bool>,
    /// User material, if the model is a routine.
    routine: Option<MaterialSettings>,
}

/// Plastic law, by the way in which it is evaluated.
pub enum PlasticLaw {
    /// Law in rate form, with yield surface and flow rule.
    Flow(Box<dyn FlowLaw>),
    /// Law of finite increments, with the number of increments.
    Increments(Box<dyn IncrementalLaw>, usize),
}

impl Default for PlasticSettings {
    fn default() -> Self {
        Self {
            values: PARAMETERS.iter().map(Parameter::default_value).collect(),
            origins: vec![None; PARAMETERS.len()],
            with_units: vec![false; PARAMETERS.len()],
            routine: None,
        }
    }
}

impl PlasticSettings {
    /// Applies assignments such as `plasticity.friction=0.7` to the defaults, in order. A law can also be given by its keys of `[material]`, as for other
    /// commands.
    ///
    /// ```
    /// use onset_study::localization::PlasticSettings;
    /// let error = PlasticSettings::from_assignments(&["plasticity.model=j2", "plasticity.friction=0.3"]);
    /// assert!(error.unwrap_err().to_string().contains("only with plasticity.model = drucker-prager"));
    /// ```
    ///
    /// # Errors
    /// [`SettingError`] for an unknown parameter, a value of the wrong kind, or a parameter that has no effect.
    pub fn from_assignments<S: AsRef<str>>(assignments: &[S]) -> Result<Self, SettingError> {
        let mut settings = Self::default();
        let mut of_material = Vec::new();
        for assignment in assignments {
            let assignment = assignment.as_ref();
            if assignment.trim_start().starts_with("material.") {
                of_material.push(assignment);
                continue;
            }
            let origin = Origin::CommandLine(format!("--set {assignment}"));
            let Some((name, text)) = assignment.split_once('=') else {
                return Err(SettingError::new(
                    origin,
                    format!("`{assignment}` is not an assignment"),
                )
                .hint("write --set key=value, for example --set plasticity.friction=0.7"));
            };
            settings.set(name.trim(), text.trim(), origin)?;
        }
        let model = of_material.iter().find_map(|own| {
            let (key, model) = own.split_once('=')?;
            (key.trim() == "material.model").then(|| model.trim())
        });
        match model {
            Some(model) if ROUTINES.contains(&model) => {
                let origin = Origin::CommandLine(format!("--set material.model={model}"));
                settings.set(MODEL, model, origin)?;
            }
            Some(model) => {
                let material = MaterialSettings::of_file("", "", &of_material)?;
                let values = Self::values_of(&material)?;
                if settings.is_set(MODEL) && !settings.is(MODEL, model) {
                    let message = format!("material.model = {model} and {MODEL} are two laws");
                    return Err(
                        SettingError::new(Origin::Combination, message).hint("omit one of them")
                    );
                }
                for (name, value) in values {
                    if !settings.is_set(name) {
                        let origin = Origin::CommandLine("the law of [material]".to_owned());
                        settings.set(name, &value, origin)?;
                    }
                }
                of_material.clear();
            }
            None => {}
        }
        settings.confine();
        settings.check()?;
        settings.choose_routine(&of_material)?;
        Ok(settings)
    }

    /// Names and values of the parameters that describe the law of a material.
    ///
    /// # Errors
    /// [`SettingError`] if the law does not flow, or its hardening has no counterpart here.
    pub fn values_of(
        material: &MaterialSettings,
    ) -> Result<Vec<(&'static str, String)>, SettingError> {
        let model = material.model.name();
        let entries = material.entries();
        let number = |wanted: &str| {
            let mut found = entries.iter().filter(|(name, _)| *name == wanted);
            found.find_map(|(_, value)| value.number())
        };
        let refused = |hint: String| {
            let message = format!("the law is {model}, which `onset localize` cannot follow");
            SettingError::new(Origin::Combination, message).hint(hint)
        };
        if number("angle").is_some_and(|angle| angle != 0.0) {
            return Err(refused(
                "set material.angle=0: the axes of the material must be the axes of the path"
                    .to_owned(),
            ));
        }
        let no_flow = || {
            refused(format!(
                "expected a law that flows: {}",
                WITH_ELASTICITY.join(", ")
            ))
        };
        let (Some(shear), Some(bulk)) = (number("mu"), number("kappa")) else {
            return Err(no_flow());
        };
        let elasticity = Elasticity { shear, bulk };
        let mut given = vec![
            ("shear-modulus", shear),
            ("poisson-ratio", elasticity.poisson_ratio()),
        ];
        let mut hardening = None;
        let metal = [
            "yield-stress",
            "hardening-modulus",
            "saturation-stress",
            "saturation-rate",
        ];
        let metal: Vec<f64> = metal.into_iter().filter_map(number).collect();
        if let [first, modulus, gained, rate] = metal[..] {
            // The flow stress in tension is sqrt(3) times the strength in shear, and the slip in shear is sqrt(3) times the plastic strain in tension.
            let root = 3.0_f64.sqrt();
            given.push(("strength", first / root));
            if gained * rate == 0.0 {
                hardening = Some("linear");
                given.push(("hardening-modulus", modulus / 3.0));
            } else if modulus == 0.0 {
                hardening = Some("voce");
                given.push(("saturation", (first + gained) / root));
                given.push(("reference-slip", root / rate));
            } else {
                return Err(refused(
                    "set material.saturation-stress=0 for linear hardening, or material.hardening-modulus=0 for hardening that saturates"
                        .to_owned(),
                ));
            }
            given.extend(
                ["r0", "r90"]
                    .into_iter()
                    .filter_map(|own| Some((own, number(own)?))),
            );
        } else {
            let others = entries
                .iter()
                .filter_map(|(name, value)| Some((*name, value.number()?)));
            given.extend(others.filter(|(name, _)| !["mu", "kappa"].contains(name)));
        }
        let parameter = |name: &str| {
            let mut all = PARAMETERS.iter();
            all.find(|own| own.name.strip_prefix("plasticity.") == Some(name))
        };
        let known = given
            .iter()
            .map(|(name, value)| Some((parameter(name)?, value)));
        let known: Option<Vec<_>> = known.collect();
        let Some(known) = known.filter(|_| WITH_ELASTICITY.contains(&model)) else {
            return Err(no_flow());
        };
        let numbers = known.into_iter().map(|(parameter, value)| {
            let unit = parameter.si_unit().filter(|_| material.units().are_si());
            (parameter.name, format!("{value}{}", unit.unwrap_or("")))
        });
        let words = [(MODEL, Some(model)), (HARDENING, hardening)];
        let words = words.map(|(name, word)| Some((name, word?.to_owned())));
        Ok(words.into_iter().flatten().chain(numbers).collect())
    }

    /// Reads the user material of `plasticity.model = umat` (or `library`) from keys of `[material]`.
    fn choose_routine(&mut self, assignments: &[&str]) -> Result<(), SettingError> {
        let Some(name) = ROUTINES.iter().find(|name| self.is(MODEL, name)) else {
            return match assignments.first() {
                None => Ok(()),
                Some(first) => Err(SettingError::new(
                    Origin::CommandLine(format!("--set {first}")),
                    "keys of [material] have no effect here".to_owned(),
                )
                .hint(format!(
                    "set material.model too, or the law by {MODEL} and its keys; the keys of a user material are used only with {MODEL} = {}",
                    ROUTINES.join(" | ")
                ))),
            };
        };
        let counts = |one: &&&str| one.trim_start().starts_with("material.increments");
        if let Some(one) = assignments.iter().find(counts) {
            let origin = Origin::CommandLine(format!("--set {one}"));
            let message = "`material.increments` has no effect here".to_owned();
            return Err(SettingError::new(origin, message)
                .hint("plasticity.increments is the number of increments along the path"));
        }
        let sheet = |one: &&&str| one.trim_start().starts_with("material.plane");
        if let Some(one) = assignments.iter().find(sheet) {
            let origin = Origin::CommandLine(format!("--set {one}"));
            let message = "`material.plane` has no effect here".to_owned();
            return Err(SettingError::new(origin, message)
                .hint("plasticity.path determines which strains and stresses are prescribed"));
        }
        let model = [format!("material.model={name}")];
        let all = model.iter().map(String::as_str);
        let all: Vec<&str> = all.chain(assignments.iter().copied()).collect();
        let material = Settings::from_assignments(&all)?.material;
        if !material.is_library() {
            let origin = Origin::CommandLine(format!("--set {}", assignments.join(" --set ")));
            return Err(SettingError::new(
                origin,
                format!("{MODEL} = {name} is a separate user material"),
            )
            .hint(
                "omit material.model, and name the library: --set material.library=./my_umat.so",
            ));
        }
        self.routine = Some(material);
        Ok(())
    }

    /// Sets one parameter. [`PlasticSettings::from_assignments`] checks afterwards whether it has an effect.
    fn set(&mut self, name: &str, text: &str, origin: Origin) -> Result<(), SettingError> {
        let names = PARAMETERS.iter().map(|parameter| parameter.name);
        let Some(place) = names.clone().position(|known| known == name) else {
            return Err(unknown_key(name, names, origin));
        };
        let parameter = &PARAMETERS[place];
        let typed = Value::typed(text, Some(parameter.kind));
        let measured = units::converted(&parameter.key(), &typed, &origin)?;
        let has_unit = measured.is_some();
        let value = measured.unwrap_or(typed);
        if !parameter.kind.accepts(&value) {
            let (expects, meaning) = (parameter.kind.expects(), parameter.meaning);
            return Err(
                SettingError::new(origin, format!("`{name}` cannot be {value}"))
                    .hint(format!("expected {expects} ({meaning})"))
                    .nearest_word(name, &value, parameter.words()),
            );
        }
        self.values[place] = value;
        self.origins[place] = Some(origin);
        self.with_units[place] = has_unit;
        Ok(())
    }

    /// Sets the default confinement of Cam-clay, which has no strength without pressure: half of the preconsolidation pressure, in the middle of the
    /// yield surface.
    fn confine(&mut self) {
        let place = |name: &str| PARAMETERS.iter().position(|known| known.name == name);
        let places = (place(CONFINEMENT), place("plasticity.preconsolidation"));
        let (Some(own), Some(of)) = places else {
            return;
        };
        if self.is(MODEL, "cam-clay") && self.origins[own].is_none() {
            let pressure = self.values[of].number().unwrap_or_default();
            self.values[own] = Value::Number(0.5 * pressure);
            self.with_units[own] = self.with_units[of];
        }
    }

    /// Refuses parameters that were set and have no effect.
    fn check(&self) -> Result<(), SettingError> {
        for (parameter, origin) in PARAMETERS.iter().zip(&self.origins) {
            let (Some(origin), false) = (origin, self.has_effect(parameter)) else {
                continue;
            };
            let Some((needed, words)) = parameter.only_with else {
                continue;
            };
            return Err(SettingError::new(
                origin.clone(),
                format!("`{}` has no effect here", parameter.name),
            )
            .hint(format!(
                "it is used only with {needed} = {}",
                words.join(" or ")
            )));
        }
        self.check_units()
    }

    /// Checks that either all values with dimensions in effect have units, or none.
    fn check_units(&self) -> Result<(), SettingError> {
        let states = PARAMETERS.iter().zip(&self.values);
        let states = states.zip(self.with_units.iter().zip(&self.origins));
        let measures = states
            .filter(|((parameter, _), _)| {
                self.has_effect(parameter) && parameter.si_unit().is_some()
            })
            .filter_map(|((parameter, value), (has_unit, origin))| {
                let value = Some(value.number()?);
                Some((parameter.key(), value, *has_unit, origin.as_ref()))
            });
        units::check(measures).map(drop)
    }

    /// Returns the units of answers.
    pub fn units(&self) -> Units {
        match self.with_units.contains(&true) {
            true => Units::Si,
            false => Units::Own,
        }
    }

    fn has_effect(&self, parameter: &Parameter) -> bool {
        parameter.only_with.is_none_or(|(needed, words)| {
            let mut owners = PARAMETERS.iter().filter(|known| known.name == needed);
            owners.all(|owner| self.has_effect(owner))
                && matches!(self.value(needed), Value::Word(word) if words.contains(&word.as_str()))
        })
    }

    /// Parameters in effect as a text: names with values, and units if there is a dimension.
    pub fn told(&self) -> String {
        let units = self.units();
        let one = |(parameter, value): (&'static Parameter, &Value)| {
            let name = parameter.name.trim_start_matches("plasticity.");
            match (value, parameter.key().unit().and_then(units::si)) {
                (Value::Number(number), Some(unit)) => {
                    format!("{name} {}", units.of(crate::number::exact(*number), unit))
                }
                (Value::Number(number), None) => {
                    format!("{name} {}", crate::number::exact(*number))
                }
                (Value::Word(word), _) => format!("{name} {word}"),
                (other, _) => format!("{name} {other}"),
            }
        };
        let own = self.values().map(one);
        let routine = self.routine_entries();
        let routine = routine
            .iter()
            .map(|(name, value)| format!("{name} {value}"));
        own.chain(routine).collect::<Vec<_>>().join(", ")
    }

    /// Keys of the user material, with their values.
    pub fn routine_entries(&self) -> Vec<(&'static str, Value)> {
        let entries = self.routine.as_ref().map(MaterialSettings::entries);
        entries.unwrap_or_default()
    }

    /// Parameters in effect, with their values.
    pub fn values(&self) -> impl Iterator<Item = (&'static Parameter, &Value)> {
        PARAMETERS
            .iter()
            .zip(&self.values)
            .filter(|(parameter, _)| self.has_effect(parameter))
    }

    fn is_set(&self, name: &str) -> bool {
        let mut all = PARAMETERS.iter().zip(&self.origins);
        all.any(|(known, origin)| known.name == name && origin.is_some())
    }

    fn value(&self, name: &str) -> &Value {
        const NONE: &Value = &Value::Switch(false);
        let place = PARAMETERS.iter().position(|known| known.name == name);
        place.map_or(NONE, |place| &self.values[place])
    }

    fn number(&self, name: &str) -> f64 {
        self.value(name).number().unwrap_or(f64::NAN)
    }

    fn word<T: DeserializeOwned + Default>(&self, name: &str) -> T {
        self.value(name).word().unwrap_or_default()
    }

    fn is(&self, name: &str, word: &str) -> bool {
        matches!(self.value(name), Value::Word(set) if set == word)
    }

    /// Builds the plastic law.
    ///
    /// # Errors
    /// [`LocalizationError::Plasticity`] when the parameters are invalid.
    pub fn law(&self) -> Result<PlasticLaw, LocalizationError> {
        match &self.routine {
            Some(routine) => self.routine_law(routine),
            None => self.flow_law().map(PlasticLaw::Flow),
        }
    }

    fn routine_law(&self, routine: &MaterialSettings) -> Result<PlasticLaw, LocalizationError> {
        let of_law = |error: MaterialError| LocalizationError::from(PlasticityError::from(error));
        let settings = routine.umat_permitted().map_err(of_law)?;
        let settings = settings.ok_or_else(|| {
            of_law(MaterialError::External {
                message: "material.library is missing".to_owned(),
            })
        })?;
        let umat = Umat::new(settings).map_err(|error| of_law(error.into()))?;
        let count = self.number("plasticity.increments") as usize;
        Ok(PlasticLaw::Increments(Box::new(umat), count))
    }

    fn flow_law(&self) -> Result<Box<dyn FlowLaw>, LocalizationError> {
        let number = |name: &str| self.number(&format!("plasticity.{name}"));
        let (shear, poisson) = (number("shear-modulus"), number("poisson-ratio"));
        let elasticity = Elasticity::new(shear, poisson)?;
        let hardening = self.hardening();
        let word = match self.value(MODEL) {
            Value::Word(word) => word.as_str(),
            _ => "",
        };
        fn boxed<L: FlowLaw + 'static>(
            law: Result<L, PlasticityError>,
        ) -> Result<Box<dyn FlowLaw>, LocalizationError> {
            Ok(Box::new(law?))
        }
        match word {
            "mohr-coulomb" => boxed(MohrCoulomb::new(
                elasticity,
                number("friction-angle"),
                number("dilation-angle"),
                hardening,
            )),
            "hill-1948" => boxed(HillOrthotropic::new(
                elasticity,
                number("r0"),
                number("r90"),
                hardening,
            )),
            "kinematic" => boxed(Kinematic::new(
                elasticity,
                number("kinematic-modulus"),
                number("recovery"),
                hardening,
            )),
            "gurson" => boxed(Gurson::new(
                elasticity,
                number("voids"),
                [number("q1"), number("q2")],
                hardening,
            )),
            "cam-clay" => boxed(CamClay::new(
                elasticity,
                number("critical-slope"),
                number("preconsolidation"),
                number("compressibility"),
            )),
            "cap" => boxed(EllipticCap::new(
                elasticity,
                number("strength"),
                [number("cap-start"), number("preconsolidation")],
                number("compressibility"),
            )),
            "damage" => boxed(ScalarDamage::new(elasticity, hardening)),
            "deformation-theory" => boxed(DeformationTheory::new(elasticity, hardening)),
            "j2" => boxed(DruckerPrager::von_mises(shear, poisson, hardening)),
            _ => boxed(DruckerPrager::new(
                shear,
                poisson,
                number("friction"),
                number("dilatancy"),
                hardening,
            )),
        }
    }

    /// Hardening curve of the strength.
    fn hardening(&self) -> Hardening {
        let initial = self.number("plasticity.strength");
        let modulus = self.number("plasticity.hardening-modulus");
        let reference = self.number("plasticity.reference-slip");
        if self.is(HARDENING, "linear") {
            Hardening::Linear { initial, modulus }
        } else if self.is(HARDENING, "voce") {
            Hardening::Voce {
                initial,
                saturation: self.number("plasticity.saturation"),
                reference,
            }
        } else if self.is(HARDENING, "power") {
            Hardening::Power {
                initial,
                reference,
                exponent: self.number("plasticity.exponent"),
            }
        } else {
            Hardening::Peak {
                initial,
                residual: self.number("plasticity.residual"),
                modulus,
                reference,
            }
        }
    }

    /// Returns the loading path.
    pub fn loading(&self) -> Loading {
        Loading {
            path: self.word::<LoadingPath>("plasticity.path"),
            load: self.word::<Load>("plasticity.load"),
            strains: self.word::<Strains>("plasticity.strains"),
            bands: self.word::<Bands>("plasticity.bands"),
            confinement: self.number(CONFINEMENT),
            strain_ratio: self.number("plasticity.strain-ratio"),
            slip: self.number("plasticity.slip"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::word_of;

    #[test]
    fn default_parameters_are_valid_and_define_a_law() {
        for parameter in PARAMETERS {
            assert!(
                parameter.kind.accepts(&parameter.default_value()),
                "{}",
                parameter.name
            );
        }
        PlasticSettings::default().law().expect("a law");
    }

    #[test]
    fn every_word_is_the_name_that_serialization_uses() {
        for parameter in PARAMETERS {
            for word in parameter.words() {
                let mut set = vec![format!("{}={word}", parameter.name)];
                if ROUTINES.contains(word) {
                    set.push("material.library=a.so".to_owned());
                }
                let settings = PlasticSettings::from_assignments(&set).expect("valid");
                let loading = settings.loading();
                let told = match parameter.name {
                    "plasticity.path" => word_of(&loading.path),
                    "plasticity.load" => word_of(&loading.load),
                    "plasticity.strains" => word_of(&loading.strains),
                    "plasticity.bands" => word_of(&loading.bands),
                    _ => continue,
                };
                assert_eq!(told, *word);
            }
        }
    }

    #[test]
    fn invalid_settings_are_refused_with_a_hint() {
        let error = |assignment: &str| {
            PlasticSettings::from_assignments(&[assignment])
                .expect_err("a wrong assignment")
                .to_string()
        };
        assert!(error("plasticity.fricton=1").contains("did you mean `plasticity.friction`?"));
        assert!(error("friction=1").contains("did you mean `plasticity.friction`?"));
        assert!(error("plasticity.path=planestrain").contains("did you mean `plane-strain`?"));
        assert!(
            error("plasticity.exponent=0.2").contains("only with plasticity.hardening = power")
        );
        assert!(
            error("plasticity.strength=-1")
                .contains("expected a positive number from 1e-20 to 1e20 (stress)")
        );
        assert!(error("plasticity.strength").contains("not an assignment"));
        assert!(error("plasticity.model=umat").contains("material.library"));
        assert!(error("material.library=a.so").contains("only with plasticity.model = umat"));
        assert!(error("plasticity.increments=10").contains("only with plasticity.model = umat"));
    }

    #[test]
    fn cam_clay_is_confined_within_its_yield_surface_unless_a_pressure_is_set() {
        let confinement = |more: &[&str]| {
            let all = [&["plasticity.model=cam-clay"], more].concat();
            let settings = PlasticSettings::from_assignments(&all).expect("valid");
            settings.loading().confinement
        };
        assert_eq!(confinement(&[]), 50.0);
        assert_eq!(confinement(&["plasticity.preconsolidation=80"]), 40.0);
        assert_eq!(confinement(&["plasticity.confinement=10"]), 10.0);
        let other = PlasticSettings::from_assignments(&["plasticity.model=cap"]);
        assert_eq!(other.expect("valid").loading().confinement, 0.0);
    }

    #[test]
    fn either_all_stresses_have_units_or_none() {
        let all = [
            "plasticity.shear-modulus=80 GPa",
            "plasticity.strength=200MPa",
            "plasticity.hardening-modulus=1 GPa",
            "plasticity.residual=150 MPa",
        ];
        let settings = PlasticSettings::from_assignments(&all).expect("valid");
        assert_eq!(settings.units(), Units::Si);
        assert_eq!(settings.number("plasticity.shear-modulus"), 80e9);
        assert!(settings.told().contains("shear-modulus 8e10 Pa"));
        let some = PlasticSettings::from_assignments(&all[..3]).expect_err("one without a unit");
        let some = some.to_string();
        assert!(
            some.contains("plasticity.residual = 10 (the default) has none"),
            "{some}"
        );
        for (wrong, fact) in [
            ("plasticity.strength=1mm", "`mm` is a unit of a length"),
            ("plasticity.friction=1MPa", "has no dimension"),
        ] {
            let error = PlasticSettings::from_assignments(&[wrong]).expect_err("no such unit");
            assert!(error.to_string().contains(fact), "{error}");
        }
        assert_eq!(PlasticSettings::default().units(), Units::Own);
    }
}
