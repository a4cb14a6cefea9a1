//! Meaning of the words of the language, compared with their definitions.

use crate::states::Random;
use nalgebra::{Matrix3, Vector3};
use onset::formula::{FUNCTIONS, Formula, VARIABLES};
use onset::kinematics::DeformationGradient;
use onset::material::Hyperelastic;

fn energy(text: &str, values: &[(&str, f64)], f: &DeformationGradient) -> f64 {
    let formula = Formula::parse(text).unwrap_or_else(|error| panic!("{error}"));
    let law = formula
        .with(values)
        .unwrap_or_else(|error| panic!("{error}"));
    law.response(f)
        .unwrap_or_else(|error| panic!("{text}: {error}"))
        .energy
}

#[track_caller]
fn assert_close(computed: f64, expected: f64, what: &str) {
    let error = (computed - expected).abs();
    assert!(
        error <= 2e-14 * expected.abs().max(1.0),
        "{what}: {computed}, not {expected}"
    );
}

#[test]
fn every_variable_equals_its_definition() {
    let mut random = Random::new(1);
    for _ in 0..20 {
        let f = random.state();
        let (m, j) = (f.matrix(), f.jacobian());
        let c = m.transpose() * m;
        let e = (c - Matrix3::identity()) / 2.0;
        let i1 = c.trace();
        let i2 = 0.5 * (i1 * i1 - (c * c).trace());
        let angles = [37.0, -20.0];
        let fibers = angles.map(|angle: f64| {
            let angle = angle.to_radians();
            Vector3::new(angle.cos(), angle.sin(), 0.0)
        });
        let along =
            |family: usize, tensor: &Matrix3<f64>| fibers[family].dot(&(tensor * fibers[family]));
        let expected = |name: &str| match name {
            "I1" => i1,
            "I2" => i2,
            "I3" => c.determinant(),
            "J" => j,
            "I1bar" => i1 * j.powf(-2.0 / 3.0),
            "I2bar" => i2 * j.powf(-4.0 / 3.0),
            "I4" => along(0, &c),
            "I5" => along(0, &(c * c)),
            "I6" => along(1, &c),
            "I7" => along(1, &(c * c)),
            component => {
                let digits: Vec<usize> = component[1..]
                    .chars()
                    .map(|digit| digit as usize - '1' as usize)
                    .collect();
                let tensor = match &component[..1] {
                    "F" => &m,
                    "C" => &c,
                    _ => &e,
                };
                tensor[(digits[0], digits[1])]
            }
        };
        for name in VARIABLES.iter().flat_map(|group| group.names) {
            // Symmetric formulas in the stretches are tested with the library.
            if name.starts_with("lambda") {
                continue;
            }
            let values: &[(&str, f64)] = match *name {
                "I4" | "I5" => &[("fiber1-angle", 37.0)],
                "I6" | "I7" => &[("fiber2-angle", -20.0)],
                _ => &[],
            };
            assert_close(energy(name, values, &f), expected(name), name);
        }
    }
}

#[test]
fn every_function_equals_its_definition() {
    type Expected = fn(f64) -> f64;
    let functions: &[(&str, &str, Expected)] = &[
        ("if", "if(F11 < 1, 2*F11, 3*F11)", |x| {
            if x < 1.0 { 2.0 * x } else { 3.0 * x }
        }),
        ("sqrt", "sqrt(F11)", f64::sqrt),
        ("cbrt", "cbrt(F11)", f64::cbrt),
        ("exp", "exp(F11)", f64::exp),
        ("ln", "ln(F11)", f64::ln),
        ("log10", "log10(F11)", f64::log10),
        ("sin", "sin(F11)", f64::sin),
        ("cos", "cos(F11)", f64::cos),
        ("tan", "tan(F11)", f64::tan),
        ("sinh", "sinh(F11)", f64::sinh),
        ("cosh", "cosh(F11)", f64::cosh),
        ("tanh", "tanh(F11)", f64::tanh),
        ("abs", "abs(F11 - 1)", |x| (x - 1.0).abs()),
        ("macaulay", "macaulay(F11 - 1)", |x| (x - 1.0).max(0.0)),
        ("ramp", "ramp(1 - F11)", |x| (1.0 - x).max(0.0)),
        ("heaviside", "heaviside(F11 - 1)*F11", |x| {
            if x < 1.0 { 0.0 } else { x }
        }),
        ("min", "min(F11, 1.2, 2 - F11)", |x| x.min(1.2).min(2.0 - x)),
        ("max", "max(F11, 2 - F11)", |x| x.max(2.0 - x)),
        ("pow", "pow(F11, F11)", |x| x.powf(x)),
    ];
    let named: Vec<&str> = functions.iter().map(|(name, _, _)| *name).collect();
    let known: Vec<&str> = FUNCTIONS.iter().map(|function| function.name).collect();
    assert_eq!(named, known);
    for (_, text, expected) in functions {
        let law = Formula::parse(text)
            .and_then(|formula| formula.with(&[]))
            .expect("a law");
        for x in [0.3, 0.8, 1.1, 1.4, 2.2] {
            let at = |x: f64| {
                let f = DeformationGradient::from_stretches([x, 1.0, 1.0]).expect("a state");
                law.response(&f).expect("finite")
            };
            let response = at(x);
            assert_close(response.energy, expected(x), text);
            let differentiated = |h: f64, f: &dyn Fn(f64) -> f64| {
                (8.0 * (f(x + h) - f(x - h)) - (f(x + 2.0 * h) - f(x - 2.0 * h))) / (12.0 * h)
            };
            let slope = differentiated(2e-4, expected);
            let error = (response.first_piola[(0, 0)] - slope).abs();
            assert!(
                error < 1e-9 * slope.abs().max(1.0),
                "{text} at {x}: slope off by {error:e}"
            );
            let curvature = differentiated(2e-4, &|x| at(x).first_piola[(0, 0)]);
            let error = (response.tangent[(0, 0, 0, 0)] - curvature).abs();
            assert!(
                error < 1e-8 * curvature.abs().max(1.0),
                "{text} at {x}: curvature off by {error:e}"
            );
        }
    }
}

#[test]
fn operators_have_the_usual_precedence() {
    let state = DeformationGradient::identity();
    for (text, expected) in [
        ("2 + 3*4", 14.0),
        ("2*3 + 4", 10.0),
        ("7 - 4 - 2", 1.0),
        ("16/4/2", 2.0),
        ("2/3*6", 4.0),
        ("2^3^2", 512.0),
        ("-2^2", -4.0),
        ("(-2)^2", 4.0),
        ("2^-2", 0.25),
        ("2^-2^2", 0.0625),
        ("-2*-3", 6.0),
        ("2--3", 5.0),
        ("+2 - +3", -1.0),
        ("2*3^2", 18.0),
        (".5 + 2. + 1e1 + 1.5E-1 + 2e+0", 14.65),
        ("2*pi", std::f64::consts::TAU),
        ("let a = 2; let b = a^2; a*b + 1", 9.0),
        ("let a = 2;\n let b = a + 1;\n b;\n", 3.0),
        ("max(1, min(5, 3), 2)", 3.0),
        ("sqrt(2^4)", 4.0),
    ] {
        // Both with variables, which are not folded, and with constants.
        let helpers = text
            .rfind(';')
            .filter(|at| !text[at + 1..].trim().is_empty());
        let (before, value) = text.split_at(helpers.map_or(0, |at| at + 1));
        let value = value.trim().trim_end_matches(';');
        if !text.ends_with('\n') {
            assert_close(
                energy(&format!("{before} J*({value})"), &[], &state),
                expected,
                text,
            );
        }
        let in_variables = text
            .replace("pi", "(pi*J)")
            .replace("2", "(2*J)")
            .replace("3", "(3*J)");
        if !text.contains(['e', 'E', '.', '(']) || text.contains("let") {
            assert_close(energy(&in_variables, &[], &state), expected, text);
        }
    }
}

#[test]
fn unreserved_names_are_parameters() {
    let formula = Formula::parse("c_10*(I1bar - 3) + Kappa2*(J - 1)^2 + x*I4").expect("a formula");
    assert!(
        formula
            .parameters()
            .eq(["c_10", "Kappa2", "x", "fiber1-angle"])
    );
    assert_eq!(formula.variables(), ["I1bar", "J", "I4"]);
    assert_eq!(formula.text(), "c_10*(I1bar - 3) + Kappa2*(J - 1)^2 + x*I4");
}

#[test]
fn a_formula_reports_whether_it_is_isotropic_and_uses_components() {
    for (text, components, isotropic) in [
        ("I1 + I2bar*J", false, true),
        ("I1 + I4", false, false),
        ("C11 + E22", false, false),
        ("I1 + F12", true, false),
        ("let a = F21; J", true, false),
    ] {
        let formula = Formula::parse(text).expect("a formula");
        assert_eq!(formula.uses_components(), components, "{text}");
        assert_eq!(formula.is_isotropic(), isotropic, "{text}");
    }
}

#[test]
fn fibers_rotate_with_their_angle() {
    // Rotating the fibers by an angle is equivalent to rotating the load against the material.
    let text = "k1/(2*k2)*(exp(k2*(I4 - 1)^2) - 1) + mu/2*(I1 - 3) + c*(I5 - I6*I7) - mu*ln(J)";
    let formula = Formula::parse(text).expect("a formula");
    let law = |turn: f64| {
        let values = [("k1", 2.0), ("k2", 0.5), ("mu", 1.0), ("c", 0.1)];
        let angles = [
            ("fiber1-angle", 20.0 + turn),
            ("fiber2-angle", -50.0 + turn),
        ];
        let values: Vec<_> = values.into_iter().chain(angles).collect();
        formula.with(&values).expect("values for all")
    };
    let mut random = Random::new(3);
    for turn in [0.0, 17.0, 90.0, -133.0] {
        let state = random.state().matrix();
        let rotation =
            *nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), f64::to_radians(turn))
                .matrix();
        let plain = law(0.0)
            .response(&crate::states::of(&state))
            .expect("finite");
        let turned = crate::states::of(&(state * rotation.transpose()));
        let turned = law(turn).response(&turned).expect("finite");
        assert_close(turned.energy, plain.energy, "the energy");
        let stress = turned.first_piola * rotation;
        assert!((stress - plain.first_piola).amax() < 1e-12 * plain.first_piola.amax());
    }
}
