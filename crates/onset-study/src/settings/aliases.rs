//! Names that people type, and what they are called here: for hints.

use super::Value;

/// A key, a word that is often typed for one of its values, and what to say.
const WORDS: &[(&str, &str, &str)] = &[
    (
        "discretization.method",
        "sph",
        "`updated-sph`, or `total-lagrangian-sph` for kernels of material coordinates",
    ),
    ("discretization.method", "wcsph", "`updated-sph`"),
    ("discretization.method", "ulsph", "`updated-sph`"),
    ("discretization.method", "tlsph", "`total-lagrangian-sph`"),
    ("discretization.method", "tl-sph", "`total-lagrangian-sph`"),
    ("discretization.method", "mpm", "`material-points`"),
    (
        "discretization.method",
        "material-point",
        "`material-points`",
    ),
    ("discretization.method", "fem", "`finite-elements`"),
    ("discretization.method", "fe", "`finite-elements`"),
    (
        "discretization.method",
        "rkpm",
        "`kernel` with discretization.approximation = mls, the linear reproducing kernel",
    ),
    (
        "discretization.method",
        "efg",
        "`kernel` with discretization.approximation = mls and discretization.quadrature = gauss",
    ),
    ("discretization.method", "scni", "`conforming`"),
    ("discretization.method", "pd", "`peridynamics`"),
    (
        "discretization.approximation",
        "rk",
        "`mls`, the linear reproducing kernel",
    ),
    (
        "discretization.approximation",
        "rkpm",
        "`mls`, the linear reproducing kernel",
    ),
    ("discretization.bonds", "state-based", "`correspondence`"),
    ("discretization.bonds", "nosb", "`correspondence`"),
    ("discretization.arrangement", "fcc", "`face-centered-cubic`"),
    ("discretization.arrangement", "bcc", "`body-centered-cubic`"),
    (
        "discretization.arrangement",
        "hcp",
        "`hexagonal-close-packed`",
    ),
    ("discretization.arrangement", "sc", "`simple-cubic`"),
    ("discretization.arrangement", "cubic", "`simple-cubic`"),
    ("discretization.arrangement", "triangular", "`hexagonal`"),
    ("discretization.arrangement", "line", "`chain`"),
    ("discretization.kernel", "cubic", "`cubic-spline`"),
    ("discretization.kernel", "quintic", "`quintic-spline`"),
    (
        "discretization.kernel",
        "wendland",
        "`wendland-c2`, `wendland-c4` or `wendland-c6`",
    ),
    ("discretization.mesh", "q4", "`quadrilaterals`"),
    ("discretization.mesh", "quads", "`quadrilaterals`"),
    ("discretization.mesh", "t3", "`triangles`"),
    ("discretization.mesh", "h8", "`bricks`"),
    ("discretization.mesh", "hexahedra", "`bricks`"),
    ("discretization.mesh", "tet4", "`tetrahedra`"),
    ("discretization.integration", "reduced", "`one-point`"),
    ("material.model", "neo-hookean", "`neo-hooke`"),
    ("material.model", "neohookean", "`neo-hooke`"),
    ("material.model", "svk", "`saint-venant-kirchhoff`"),
];

/// A key that is often typed, and what to say.
const KEYS: &[(&str, &str)] = &[
    (
        "smoothing-length",
        "set discretization.support, the support radius over the spacing: for a spline of support 2 h it is 2 h/dx",
    ),
    (
        "h",
        "set discretization.support, the support radius over the spacing",
    ),
    ("dx", "set discretization.spacing"),
    ("rho", "set discretization.density"),
    ("lattice-type", "set discretization.arrangement"),
    (
        "young",
        "give the moduli of the law: mu = E/(2 (1 + nu)) and lambda = E nu/((1 + nu) (1 - 2 nu)), where it has these",
    ),
    (
        "poisson",
        "give the moduli of the law: mu = E/(2 (1 + nu)) and lambda = E nu/((1 + nu) (1 - 2 nu)), where it has these",
    ),
];

/// What a word that is often typed is called here.
pub(super) fn word(key: &str, value: &Value) -> Option<&'static str> {
    let Value::Word(typed) = value else {
        return None;
    };
    let typed = typed.to_ascii_lowercase();
    let mut known = WORDS.iter();
    let found = known.find(|(of, word, _)| *of == key && *word == typed)?;
    Some(found.2)
}

/// What to say about a key that is often typed.
pub(super) fn key(name: &str) -> Option<&'static str> {
    let own = name.rsplit('.').next()?;
    let mut known = KEYS.iter();
    Some(known.find(|(typed, _)| *typed == own)?.1)
}

#[cfg(test)]
mod tests {
    use super::{WORDS, word};
    use crate::settings::{Key, Value};

    #[test]
    fn what_is_said_for_a_word_is_a_word_of_the_key() {
        for (key, typed, told) in WORDS {
            let words = Key::named(key).expect("a key").words();
            assert!(!words.contains(typed), "{key} = {typed} is known");
            let named = told.split('`').nth(1).expect("a word");
            assert!(words.contains(&named), "{key} has no {named}");
            assert_eq!(word(key, &Value::Word(typed.to_uppercase())), Some(*told));
        }
    }
}
