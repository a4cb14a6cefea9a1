//! Words that figures share: captions with settings and states, and labels of axes.

use crate::number::{told, vector};
use crate::settings::{Effective, Units};

/// Two texts: a law with its constants, and the constants that are defaults. A law that was chosen has all its constants in the first text, because
/// constants of a deck can be equal to defaults.
pub(crate) fn law(effective: &Effective) -> (String, String) {
    let (chosen, defaults) = effective.material();
    match chosen.contains(" (default)") || defaults.is_empty() {
        true => (chosen, defaults),
        false => (with_constants(&chosen, &defaults), String::new()),
    }
}

/// A law with further constants.
fn with_constants(law: &str, constants: &str) -> String {
    match (constants.is_empty(), law.contains(": ")) {
        (true, _) => law.to_owned(),
        (false, true) => format!("{law}, {constants}"),
        (false, false) => format!("{law}: {constants}"),
    }
}

/// Settings for the caption of a figure: the material with its constants, and the method without its defaults.
pub(crate) fn settings(effective: &Effective) -> String {
    let (chosen, constants) = effective.material();
    let material = with_constants(&chosen.replace(" (default)", ""), &constants);
    let (method, _) = effective.discretization();
    let method = method.replace(" (default)", "");
    let parts = [("Material", material), ("Method", method)];
    let parts = parts.into_iter().filter(|(_, text)| !text.is_empty());
    let parts: Vec<String> = parts
        .map(|(name, text)| format!("{name}: {text}."))
        .collect();
    parts.join(" ").replace("kg/m^3", "kg/m³")
}

/// Formats a deformation gradient as stretches of a number of dimensions, or as rows if it is not diagonal.
pub(crate) fn state(f: &[[f64; 3]; 3], dimension: usize) -> String {
    let is_diagonal = (0..3).all(|i| (0..3).all(|j| i == j || f[i][j] == 0.0));
    // Directions beyond the dimensions of the particles are shown if they are stretched.
    let count = (dimension..3).filter(|i| f[*i][*i] != 1.0).max();
    let count = count.map_or(dimension, |last| last + 1).clamp(1, 3);
    match is_diagonal {
        true => {
            let stretches: Vec<f64> = (0..count).map(|i| f[i][i]).collect();
            match stretches[..] {
                [only] => format!("stretch {}", told(only)),
                _ => format!("stretches {}", together(&stretches)),
            }
        }
        false => format!("F = [{}]", f.map(|row| together(&row)).join(", ")),
    }
}

/// Names a state like [`state`], and the reference configuration as such.
pub(crate) fn configuration(f: &[[f64; 3]; 3], dimension: usize) -> String {
    match *f == std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j)))) {
        true => "the reference configuration".to_owned(),
        false => state(f, dimension),
    }
}

/// Formats a vector that is not divided between lines.
fn together(components: &[f64]) -> String {
    vector(components).replace(", ", ",\u{a0}")
}

/// Label of an axis: a quantity with its unit, or alone if the numbers have no units.
pub(crate) fn label(units: Units, what: &str, dimension: &'static str) -> String {
    match (units, dimension) {
        (Units::Own, "1" | "deg" | "rad") | (Units::Si, _) => units.label(what, dimension),
        (Units::Own, _) => what.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;

    #[test]
    fn captions_have_the_constants_of_the_law_and_no_defaults_of_the_method() {
        let own = Settings::from_assignments(&[
            "material.model=neo-hooke",
            "material.mu=2",
            "discretization.method=total-lagrangian-sph",
            "discretization.penalty=0.5",
        ]);
        let text = settings(&own.expect("settings").effective());
        assert!(
            text.contains("mu 2") && text.contains("penalty 0.5"),
            "{text}"
        );
        assert!(!text.contains("default"), "{text}");
    }

    #[test]
    fn a_law_that_was_chosen_has_all_its_constants() {
        let keys = [
            "material.model=yeoh",
            "material.c10=0.5",
            "material.kappa=3",
        ];
        let own = Settings::from_assignments(&keys)
            .expect("settings")
            .effective();
        let (told, defaults) = law(&own);
        assert!(
            told.contains("c10 0.5") && told.contains("kappa 3"),
            "{told}"
        );
        assert_eq!(defaults, "");
    }

    #[test]
    fn states_are_written_as_stretches_or_as_a_matrix() {
        let mut f = [[1.2, 0.0, 0.0], [0.0, 0.9, 0.0], [0.0, 0.0, 1.0]];
        assert_eq!(state(&f, 2), "stretches (1.2,\u{a0}0.9)");
        f[2][2] = 0.8;
        assert_eq!(state(&f, 2), "stretches (1.2,\u{a0}0.9,\u{a0}0.8)");
        f[0][1] = 0.5;
        assert!(state(&f, 2).starts_with("F = [(1.2,\u{a0}0.5,\u{a0}0)"));
    }

    #[test]
    fn labels_of_axes_name_no_unit_without_units() {
        assert_eq!(label(Units::Own, "amplitude", "length"), "amplitude");
        assert_eq!(label(Units::Si, "amplitude", "length"), "amplitude (m)");
        assert_eq!(label(Units::Own, "stretch", "1"), "stretch (−)");
    }
}
