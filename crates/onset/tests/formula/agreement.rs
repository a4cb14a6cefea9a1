//! Formulas of built-in laws agree with these laws.

use crate::states::Random;
use onset::formula::{Formula, FormulaLaw};
use onset::kinematics::DeformationGradient;
use onset::material::{BlatzKo, Hyperelastic, ModifiedMooneyRivlin, Response};
use onset::real::Interval;

/// Built-in law with its formula, in several notations if possible.
struct Pair {
    name: &'static str,
    built_in: Box<dyn Hyperelastic>,
    typed: FormulaLaw,
}

fn pair(
    name: &'static str,
    built_in: impl Hyperelastic + 'static,
    formula: &str,
    values: &[(&str, f64)],
) -> Pair {
    let formula = Formula::parse(formula).unwrap_or_else(|error| panic!("{name}: {error}"));
    Pair {
        name,
        built_in: Box::new(built_in),
        typed: formula
            .with(values)
            .unwrap_or_else(|error| panic!("{name}: {error}")),
    }
}

const MOONEY: &[(&str, f64)] = &[("c1", 0.1256), ("c2", 0.01012), ("lambda", 10.12)];

fn pairs() -> Vec<Pair> {
    let mooney = ModifiedMooneyRivlin::default();
    let foam = BlatzKo::default();
    let mu = [("mu", 32.0)];
    vec![
        pair(
            "equation (5)",
            mooney,
            "c1/2*I1 + c2/2*I2 - 3/2*c1*I3^(1/3) - 3/2*c2*I3^(2/3) + lambda/4*ln(I3)^2",
            MOONEY,
        ),
        pair(
            "equation (5), in J and with helpers",
            mooney,
            "let root = cbrt(I3); let log = ln(J);\n\
             (c1*I1 + c2*I2 - 3*c1*root - 3*c2*root^2)/2 + lambda*log^2",
            MOONEY,
        ),
        pair(
            "equation (5), isochoric",
            mooney,
            "c1/2*(I1bar*J^(2/3)) + c2/2*I2bar*pow(J, 4/3) - 1.5*c1*J^(2/3) - 1.5*c2*J^(4/3) + lambda*ln(J)*ln(J)",
            MOONEY,
        ),
        pair(
            "equation (5), in components of C",
            mooney,
            "let i1 = C11 + C22 + C33;\n\
             let i2 = C11*C22 - C12*C21 + C11*C33 - C13*C31 + C22*C33 - C23*C32;\n\
             let i3 = C11*(C22*C33 - C23^2) - C12*(C12*C33 - C23*C13) + C13*(C12*C23 - C22*C13);\n\
             c1/2*i1 + c2/2*i2 - 3/2*c1*i3^(1/3) - 3/2*c2*i3^(2/3) + lambda/4*ln(i3)^2",
            MOONEY,
        ),
        pair("Blatz-Ko", foam, "mu/2*(I2/I3 + 2*sqrt(I3) - 5)", &mu),
        pair("Blatz-Ko, in J", foam, "mu/2*(I2/J^2 + 2*J - 5)", &mu),
        pair(
            "Blatz-Ko, in components of E",
            foam,
            "let c11 = 1 + 2*E11; let c22 = 1 + 2*E22; let c33 = 1 + 2*E33;\n\
             let i2 = c11*c22 + c11*c33 + c22*c33 - 4*(E12*E21 + E13*E31 + E23*E32);\n\
             mu/2*(i2/J^2 + 2*J - 5)",
            &mu,
        ),
        pair(
            "Blatz-Ko, in components of F",
            foam,
            "let j = F11*(F22*F33 - F23*F32) - F12*(F21*F33 - F23*F31) + F13*(F21*F32 - F22*F31);\n\
             mu/2*(I2/j^2 + 2*j - 5)",
            &mu,
        ),
    ]
}

/// Largest differences of energy, stress and tangent, relative to the largest component of each.
pub fn difference(a: &Response, b: &Response, energy_scale: f64) -> f64 {
    let energy = (a.energy - b.energy).abs() / energy_scale;
    let stress = (a.first_piola - b.first_piola).amax() / b.first_piola.amax();
    let indices = || (0..81).map(|n| (n / 27, n / 9 % 3, n / 3 % 3, n % 3));
    let largest = indices().map(|n| b.tangent[n].abs()).fold(0.0, f64::max);
    let tangent = indices()
        .map(|n| (a.tangent[n] - b.tangent[n]).abs())
        .fold(0.0, f64::max);
    energy.max(stress).max(tangent / largest)
}

#[test]
fn a_formula_of_a_built_in_law_has_its_energy_stress_and_tangent() {
    for pair in pairs() {
        let mut random = Random::new(11);
        for _ in 0..100 {
            let f = random.state();
            let built_in = pair.built_in.response(&f).expect("finite");
            let typed = pair.typed.response(&f).expect("finite");
            let scale = built_in.tangent[(0, 0, 0, 0)].abs().max(built_in.energy);
            let error = difference(&typed, &built_in, scale);
            assert!(error < 1e-12, "{}: off by {error:e} at {f:?}", pair.name);
        }
    }
}

#[test]
fn the_in_plane_tangent_equals_the_tangent_of_the_built_in_law() {
    for pair in pairs() {
        let mut random = Random::new(12);
        for _ in 0..50 {
            let f = random.state();
            let built_in = pair.built_in.plane_tangent(&f).expect("finite");
            let typed = pair.typed.plane_tangent(&f).expect("finite");
            let largest = built_in
                .as_flattened()
                .iter()
                .fold(0.0_f64, |a, b| a.max(b.abs()));
            for (a, b) in typed.as_flattened().iter().zip(built_in.as_flattened()) {
                assert!(
                    (a - b).abs() < 1e-12 * largest,
                    "{}: {a} and {b}",
                    pair.name
                );
            }
        }
    }
}

#[test]
fn enclosures_of_a_formula_contain_the_response_of_the_built_in_law() {
    for pair in pairs() {
        let mut random = Random::new(13);
        for width in [0.0, 1e-6, 1e-3] {
            for _ in 0..10 {
                let f = random.state();
                let wide = f
                    .components()
                    .map(|row| row.map(|x| Interval::new(x - width, x + width)));
                let bounds = pair
                    .typed
                    .enclosure(&DeformationGradient::from_components(wide));
                for _ in 0..4 {
                    let inside = f
                        .components()
                        .map(|row| row.map(|x| x + width * random.number()));
                    let inside = DeformationGradient::new(inside).expect("a state");
                    let response = pair.built_in.response(&inside).expect("finite");
                    // Error of the floating-point response itself.
                    let rounding =
                        1e-12 * response.tangent[(0, 0, 0, 0)].abs().max(response.energy);
                    let holds = |bound: Interval, x: f64| {
                        bound.is_finite()
                            && (bound + Interval::new(-rounding, rounding)).contains(x)
                    };
                    assert!(holds(bounds.energy, response.energy), "{}", pair.name);
                    for n in 0..81 {
                        let (i, j, k, l) = (n / 27, n / 9 % 3, n / 3 % 3, n % 3);
                        assert!(holds(
                            bounds.first_piola[i][j],
                            response.first_piola[(i, j)]
                        ));
                        let tangent = response.tangent[(i, j, k, l)];
                        assert!(holds(bounds.tangent[i][j][k][l], tangent), "{}", pair.name);
                    }
                }
            }
        }
    }
}

#[test]
fn enclosures_of_a_formula_are_as_tight_as_for_the_built_in_law() {
    for pair in pairs().into_iter().filter(|pair| pair.name.len() < 13) {
        let mut random = Random::new(14);
        for _ in 0..20 {
            let f = random.state();
            let wide = f
                .components()
                .map(|row| row.map(|x| Interval::new(x - 1e-4, x + 1e-4)));
            let wide = DeformationGradient::from_components(wide);
            let width = |law: &dyn Hyperelastic| {
                let bounds = law.enclosure(&wide).tangent;
                let widths = bounds.as_flattened().as_flattened().as_flattened().iter();
                widths.map(|bound| bound.width()).fold(0.0, f64::max)
            };
            let (typed, built_in) = (width(&pair.typed), width(pair.built_in.as_ref()));
            assert!(
                typed < 1.5 * built_in,
                "{}: {typed} and {built_in}",
                pair.name
            );
        }
    }
}
