//! Common other names of keys and words: accepted if they are unambiguous, explained if not.

use super::error::nearest;
use super::presets::{METHOD, PRESETS, Preset};
use super::time::INTEGRATOR;
use super::{Key, Kind, Origin, SettingError, TimeIntegrator, Value};
use std::borrow::Cow;

/// Meaning of a common other name for a word.
#[derive(Clone, Copy, Debug)]
enum Meaning {
    /// Word of the key.
    Is(&'static str),
    /// Word of the key, and values of other keys that apply unless the user sets these keys.
    With(&'static str, &'static [(&'static str, &'static str)]),
    /// Several words with explanations, for the user to choose from.
    OneOf(&'static [(&'static str, &'static str)]),
}

use Meaning::{Is, OneOf, With};

/// Key, other name for one of its words, and the meaning.
const WORDS: &[(&str, &str, Meaning)] = &[
    (
        "discretization.method",
        "sph",
        OneOf(&[
            ("total-lagrangian-sph", "kernels in material coordinates"),
            ("updated-sph", "kernels in current coordinates"),
        ]),
    ),
    ("discretization.method", "wcsph", Is("updated-sph")),
    ("discretization.method", "ulsph", Is("updated-sph")),
    ("discretization.method", "ul-sph", Is("updated-sph")),
    (
        "discretization.method",
        "updated-lagrangian-sph",
        Is("updated-sph"),
    ),
    ("discretization.method", "tlsph", Is("total-lagrangian-sph")),
    (
        "discretization.method",
        "tl-sph",
        Is("total-lagrangian-sph"),
    ),
    ("discretization.method", "mpm", Is("material-points")),
    (
        "discretization.method",
        "material-point",
        Is("material-points"),
    ),
    (
        "discretization.method",
        "material-point-method",
        Is("material-points"),
    ),
    (
        "discretization.method",
        "mls-mpm",
        With(
            "material-points",
            &[
                ("discretization.unknowns", "particles"),
                ("discretization.transfer", "apic"),
                ("discretization.grid-functions", "quadratic-spline"),
                ("discretization.grid-gradients", "moments"),
            ],
        ),
    ),
    ("discretization.method", "fem", Is("finite-elements")),
    ("discretization.method", "fe", Is("finite-elements")),
    (
        "discretization.method",
        "finite-element",
        Is("finite-elements"),
    ),
    (
        "discretization.method",
        "rkpm",
        With("kernel", &[("discretization.approximation", "mls")]),
    ),
    (
        "discretization.method",
        "efg",
        With(
            "kernel",
            &[
                ("discretization.approximation", "mls"),
                ("discretization.quadrature", "gauss"),
            ],
        ),
    ),
    ("discretization.method", "scni", Is("conforming")),
    ("discretization.method", "pd", Is("peridynamics")),
    ("discretization.approximation", "rk", Is("mls")),
    ("discretization.approximation", "rkpm", Is("mls")),
    ("discretization.bonds", "bond", Is("bond-based")),
    (
        "discretization.bonds",
        "state-based",
        OneOf(&[
            ("ordinary", "the linear peridynamic solid"),
            (
                "correspondence",
                "one deformation gradient per family, with the law of the material",
            ),
        ]),
    ),
    ("discretization.bonds", "lps", Is("ordinary")),
    ("discretization.bonds", "osb", Is("ordinary")),
    ("discretization.bonds", "nosb", Is("correspondence")),
    ("discretization.lattice", "fcc", Is("face-centered-cubic")),
    ("discretization.lattice", "bcc", Is("body-centered-cubic")),
    (
        "discretization.lattice",
        "hcp",
        Is("hexagonal-close-packed"),
    ),
    ("discretization.lattice", "sc", Is("simple-cubic")),
    ("discretization.lattice", "cubic", Is("simple-cubic")),
    ("discretization.lattice", "triangular", Is("hexagonal")),
    ("discretization.lattice", "hex", Is("hexagonal")),
    ("discretization.lattice", "line", Is("chain")),
    ("discretization.kernel", "cubic", Is("cubic-spline")),
    (
        "discretization.kernel",
        "cubic-b-spline",
        Is("cubic-spline"),
    ),
    ("discretization.kernel", "quintic", Is("quintic-spline")),
    (
        "discretization.kernel",
        "quartic",
        OneOf(&[
            (
                "quartic-spline",
                "the polynomial of degree four in the paper",
            ),
            ("quartic-b-spline", "the B-spline of degree four"),
        ]),
    ),
    (
        "discretization.kernel",
        "wendland",
        OneOf(&[
            ("wendland-c2", "two continuous derivatives"),
            ("wendland-c4", "four"),
            ("wendland-c6", "six"),
        ]),
    ),
    ("discretization.mesh", "q4", Is("quadrilaterals")),
    ("discretization.mesh", "quads", Is("quadrilaterals")),
    ("discretization.mesh", "t3", Is("triangles")),
    ("discretization.mesh", "h8", Is("bricks")),
    ("discretization.mesh", "hexahedra", Is("bricks")),
    ("discretization.mesh", "tet4", Is("tetrahedra")),
    ("discretization.integration", "reduced", Is("one-point")),
    ("material.plane", "plane-stress", Is("stress")),
    ("material.plane", "plane-strain", Is("strain")),
    ("material.model", "neo-hookean", Is("neo-hooke")),
    ("material.model", "neohookean", Is("neo-hooke")),
    ("material.model", "mie-gruneisen", Is("mie-grueneisen")),
    ("material.model", "gruneisen", Is("mie-grueneisen")),
    ("material.model", "cole", Is("murnaghan")),
    ("material.model", "von-mises", Is("j2")),
    ("material.model", "jaumann", Is("hypoelastic-jaumann")),
    (
        "material.model",
        "green-naghdi",
        Is("hypoelastic-green-naghdi"),
    ),
    ("material.model", "hypoelastic", Is("hypoelastic-jaumann")),
    ("material.model", "hill48", Is("hill-1948")),
    ("material.model", "hill", Is("hill-1948")),
    ("material.model", "tait-murnaghan", Is("murnaghan")),
    ("material.model", "tammann-tait", Is("tait")),
    ("material.model", "svk", Is("saint-venant-kirchhoff")),
    ("material.model", "stvk", Is("saint-venant-kirchhoff")),
    ("material.model", "hgo", Is("holzapfel-gasser-ogden")),
];

/// Other names of keys, with the key.
const KEYS: &[(&str, &str)] = &[
    ("discretization.dx", "discretization.spacing"),
    ("discretization.dp", "discretization.spacing"),
    ("discretization.rho", "discretization.density"),
    ("discretization.rho0", "discretization.density"),
    ("discretization.integrator", INTEGRATOR),
];

/// Names that are not accepted as keys, with a hint.
const HINTS: &[(&str, &str)] = &[
    (
        "h",
        "set discretization.smoothing-length, the smoothing length divided by the spacing, or discretization.spacing itself",
    ),
    ("dx", "set discretization.spacing"),
    ("rho", "set discretization.density"),
    ("lattice-type", "set discretization.lattice"),
    ("material.type", "did you mean `material.model`?"),
    ("material.law", "did you mean `material.model`?"),
    ("material.name", "did you mean `material.model`?"),
    ("youngs-modulus", "did you mean `material.young`?"),
    ("E", "did you mean `material.young`?"),
    ("nu", "did you mean `material.poisson`?"),
    ("poissons-ratio", "did you mean `material.poisson`?"),
    ("bulk-modulus", "did you mean `material.bulk`?"),
    ("K", "did you mean `material.bulk`?"),
    ("shear-modulus", "did you mean `material.shear`?"),
    ("G", "did you mean `material.shear`?"),
    ("young", "did you mean `material.young`?"),
    ("poisson", "did you mean `material.poisson`?"),
    (
        "smoothing-length",
        "did you mean `discretization.smoothing-length`, the smoothing length divided by the spacing?",
    ),
];

/// Key of the smoothing length divided by the spacing, another way to set the support.
///
/// `support = smoothing-length * R0/h` with the ratio of support radius
/// `R0` to smoothing length `h` of the kernel, 2 for the cubic spline.
pub(super) const SMOOTHING_LENGTH: &str = "discretization.smoothing-length";

/// Replaces a word by the spelling of the key: `FCC` by `face-centered-cubic`, `neo_hooke` by `neo-hooke`.
///
/// # Errors
/// [`SettingError`] with the possible meanings if the word is ambiguous.
pub(super) fn meant<'v>(
    key: &Key,
    value: &'v Value,
    origin: &Origin,
) -> Result<Cow<'v, Value>, SettingError> {
    let (Value::Word(typed), Kind::Words(_) | Kind::WordsOr(..)) = (value, key.kind) else {
        return Ok(Cow::Borrowed(value));
    };
    if key.words().contains(&typed.as_str()) {
        return Ok(Cow::Borrowed(value));
    }
    let owned = |word: &str| Ok(Cow::Owned(Value::Word(word.to_owned())));
    let plain = plain(typed);
    match known(key, typed) {
        Some(Is(word) | With(word, _)) => owned(word),
        Some(OneOf(words)) => {
            let told: Vec<String> = words
                .iter()
                .map(|(word, what)| format!("`{word}` ({what})"))
                .collect();
            let message = format!("`{}`: \"{typed}\" can be {}", key.name, told.join(" or "));
            let (first, _) = words[0];
            Err(SettingError::new(origin.clone(), message)
                .hint(format!("say which, for example {}={first}", key.name)))
        }
        None if key.words().contains(&plain.as_str()) => owned(&plain),
        None => Ok(Cow::Borrowed(value)),
    }
}

/// Values of other keys that an alias implies, unless the user sets these keys.
pub(super) fn companions(key: &Key, value: &Value) -> &'static [(&'static str, &'static str)] {
    match value {
        Value::Word(typed) => match known(key, typed) {
            Some(With(_, others)) => others,
            _ => &[],
        },
        _ => &[],
    }
}

fn known(key: &Key, typed: &str) -> Option<Meaning> {
    let typed = plain(typed);
    if key.name == INTEGRATOR {
        return TimeIntegrator::named(&typed).map(|own| Is(own.name()));
    }
    let mut words = other_names();
    let found = words.find(|(of, word, _)| *of == key.name && *word == typed)?;
    Some(found.2)
}

/// Other names of words, and the presets as further words of the method.
fn other_names() -> impl Iterator<Item = (&'static str, &'static str, Meaning)> {
    let preset = |own: &'static Preset| (METHOD, own.name, With(own.method, own.keys));
    WORDS.iter().copied().chain(PRESETS.iter().map(preset))
}

/// A word in lower case with hyphens.
fn plain(word: &str) -> String {
    word.trim().to_ascii_lowercase().replace(['_', ' '], "-")
}

/// Word of the key that is most similar to a wrong word; other names are compared too.
pub(super) fn nearest_word(key: &str, typed: &str, words: &[&'static str]) -> Option<&'static str> {
    let typed = plain(typed);
    let mut names: Vec<(&str, &'static str)> = words.iter().map(|word| (*word, *word)).collect();
    names.extend(
        other_names().filter_map(|(of, word, meaning)| match meaning {
            Is(own) | With(own, _) if of == key => Some((word, own)),
            _ => None,
        }),
    );
    let found = nearest(&typed, names.iter().map(|(name, _)| *name))?;
    names
        .iter()
        .find(|(name, _)| *name == found)
        .map(|(_, own)| *own)
}

/// The key with this name or other name.
pub(super) fn of_key(name: &str) -> &str {
    let mut known = KEYS.iter();
    known
        .find(|(typed, _)| *typed == name)
        .map_or(name, |(_, own)| own)
}

/// Key of a method for the quantity that another key sets for other methods.
pub(super) fn counterpart(key: &str, method: &str) -> Option<&'static str> {
    match (key, method) {
        ("discretization.support", "peridynamics") => Some("discretization.horizon"),
        ("discretization.horizon", "kernel" | "total-lagrangian-sph" | "updated-sph") => {
            Some("discretization.support")
        }
        _ => None,
    }
}

/// Returns true if a word of the method is a preset.
pub fn is_preset(name: &str) -> bool {
    PRESETS.iter().any(|own| own.name == name)
}

/// Hint for a name that is not accepted.
pub(super) fn hint(name: &str) -> Option<&'static str> {
    let own = name.rsplit('.').next()?;
    let mut known = HINTS.iter();
    Some(known.find(|(typed, _)| [own, name].contains(typed))?.1)
}

/// All unambiguous other names of words: key, other name, and meaning.
pub(crate) fn all() -> impl Iterator<Item = (&'static str, &'static str, String)> {
    WORDS.iter().filter_map(|(key, typed, meaning)| {
        let stands_for = match meaning {
            Is(word) => (*word).to_owned(),
            With(word, others) => {
                let others: Vec<String> = others
                    .iter()
                    .map(|(other, value)| format!("{other} = {value}"))
                    .collect();
                format!("{word} with {}", others.join(" and "))
            }
            OneOf(_) => return None,
        };
        Some((*key, *typed, stands_for))
    })
}

#[cfg(test)]
mod tests {
    use super::{KEYS, Meaning, other_names};
    use crate::settings::{Key, Settings};

    #[test]
    fn every_alias_means_a_valid_word_of_its_key_and_is_accepted() {
        for (key, typed, meaning) in other_names() {
            let words = Key::named(key).expect("a key").words();
            assert!(!words.contains(&typed), "{key} = {typed} is known");
            let mut settings = Settings::default();
            let set = settings.assign(&format!("{key}={}", typed.to_uppercase()));
            match meaning {
                Meaning::Is(word) | Meaning::With(word, _) => {
                    assert!(words.contains(&word), "{key} has no {word}");
                    set.expect("an alias");
                    let mut own = Settings::default();
                    own.assign(&format!("{key}={word}")).expect("a word");
                    assert_eq!(settings.value(key), own.value(key));
                }
                Meaning::OneOf(several) => {
                    let told = set.expect_err("ambiguous").to_string();
                    for (word, _) in several {
                        assert!(words.contains(word), "{key} has no {word}");
                        assert!(told.contains(&format!("`{word}`")), "{told}");
                    }
                }
            }
        }
        for (typed, own) in KEYS {
            assert!(Key::named(own).is_some(), "{typed}");
        }
    }

    #[test]
    fn explicit_settings_override_the_settings_implied_by_an_alias() {
        for assignments in [
            [
                "discretization.method=rkpm",
                "discretization.approximation=mls-2",
            ],
            [
                "discretization.approximation=mls-2",
                "discretization.method=RKPM",
            ],
        ] {
            let settings = Settings::from_assignments(&assignments).expect("valid");
            let value = settings
                .value("discretization.approximation")
                .map(|value| value.to_string());
            assert_eq!(value.as_deref(), Some("\"mls-2\""), "{assignments:?}");
        }
        let settings = Settings::from_assignments(&["discretization.method=rkpm"]).expect("valid");
        let value = settings
            .value("discretization.approximation")
            .map(|value| value.to_string());
        assert_eq!(value.as_deref(), Some("\"mls\""));
    }
}
