//! Laws of the library written as formulas, and formulas in principal stretches.

use crate::agreement::difference;
use crate::states::{Random, of};
use nalgebra::{Matrix3, Vector3};
use onset::formula::{Formula, FormulaLaw, Problem};
use onset::kinematics::DeformationGradient;
use onset::material::{Hyperelastic, Law};

const VOLUME: &str = "kappa/2*((J^2 - 1)/2 - ln(J))";
const LOGARITHMS: &str = "let h1 = ln(lambda1); let h2 = ln(lambda2); let h3 = ln(lambda3); let t = h1 + h2 + h3; \
                          let dev = (h1 - t/3)^2 + (h2 - t/3)^2 + (h3 - t/3)^2;";
const FIBERS: &str = "let x = J^(-2/3)*I4 - 1; let y = J^(-2/3)*I6 - 1;";

/// Parameters of a law that a formula uses, with its defaults; the fibers lie at plus and minus `angle`.
fn typed(law: &Law, text: &str) -> FormulaLaw {
    let formula = Formula::parse(text).unwrap_or_else(|error| panic!("{}: {error}", law.name));
    let value = |name: &str| {
        let (name, sign) = match name {
            "fiber1-angle" => ("angle", 1.0),
            "fiber2-angle" => ("angle", -1.0),
            name => (name, 1.0),
        };
        let parameter = law.parameter(name);
        sign * parameter
            .unwrap_or_else(|| panic!("{}: {name}", law.name))
            .default
    };
    let values: Vec<(&str, f64)> = formula
        .parameters()
        .map(|name| (name, value(name)))
        .collect();
    formula
        .with(&values)
        .unwrap_or_else(|error| panic!("{}: {error}", law.name))
}

#[test]
fn a_formula_of_a_law_of_the_library_has_its_energy_stress_and_tangent() {
    let strain =
        "lambda/2*(E11 + E22 + E33)^2 + mu*(E11^2 + E22^2 + E33^2 + 2*(E12^2 + E13^2 + E23^2))";
    let rubber = "mu/2*(I1 - 3) - mu*ln(J)";
    let laws = [
        ("saint-venant-kirchhoff", strain.to_owned()),
        ("neo-hooke", format!("{rubber} + lambda/2*ln(J)^2")),
        ("neo-hooke-quadratic", format!("{rubber} + lambda/2*(J - 1)^2")),
        ("neo-hooke-polyconvex", format!("{rubber} + lambda/2*((J^2 - 1)/2 - ln(J))")),
        ("neo-hooke-isochoric", format!("mu/2*(I1bar - 3) + {VOLUME}")),
        ("mooney-rivlin", "c10*(I1 - 3) + c01*(I2 - 3) - 2*(c10 + 2*c01)*ln(J) + lambda/2*ln(J)^2".to_owned()),
        ("mooney-rivlin-isochoric", "c10*(I1bar - 3) + c01*(I2bar - 3) + kappa/2*(J - 1)^2".to_owned()),
        ("yeoh", "let x = I1bar - 3; c10*x + c20*x^2 + c30*x^3 + kappa/2*(J - 1)^2".to_owned()),
        ("gent", format!("-mu*jm/2*ln(1 - (I1bar - 3)/jm) + {VOLUME}")),
        ("fung-isotropic", format!("mu/(2*b)*(exp(b*(I1bar - 3)) - 1) + {VOLUME}")),
        (
            "generalized-blatz-ko",
            "let b = nu/(1 - 2*nu); mu/2*f*(I1 - 3 + (J^(-2*b) - 1)/b) + mu/2*(1 - f)*(I2/I3 - 3 + (J^(2*b) - 1)/b)"
                .to_owned(),
        ),
        ("hencky", format!("{LOGARITHMS} mu*dev + kappa/2*t^2")),
        (
            "exponentiated-hencky",
            format!("{LOGARITHMS} mu/k*(exp(k*dev) - 1) + kappa/(2*khat)*(exp(khat*t^2) - 1)"),
        ),
        (
            "standard-reinforcing",
            format!("{rubber} + lambda/2*ln(J)^2 + mu*gamma/2*(I4 - 1)^2"),
        ),
        (
            "holzapfel-gasser-ogden",
            format!("{FIBERS} mu/2*(I1bar - 3) + k1/(2*k2)*(exp(k2*x^2) + exp(k2*y^2) - 2) + {VOLUME}"),
        ),
        (
            "holzapfel-gasser-ogden-switch",
            format!(
                "{FIBERS} mu/2*(I1bar - 3) + k1/(2*k2)*(exp(k2*ramp(x)^2) + exp(k2*ramp(y)^2) - 2) + {VOLUME}"
            ),
        ),
    ];
    for (name, text) in laws {
        let law = Law::named(name).unwrap_or_else(|| panic!("no law {name}"));
        let (built_in, typed) = (law.build(&[]).expect("defaults"), typed(law, &text));
        let mut random = Random::new(21);
        for _ in 0..40 {
            let f = random.state();
            // States at which a law is undefined are skipped.
            let (Ok(built_in), Ok(typed)) = (built_in.response(&f), typed.response(&f)) else {
                continue;
            };
            let largest = (0..81)
                .map(|n| built_in.tangent[(n / 27, n / 9 % 3, n / 3 % 3, n % 3)].abs())
                .fold(built_in.energy.abs(), f64::max);
            let error = difference(&typed, &built_in, largest);
            assert!(error < 1e-11, "{name}: off by {error:e} at {f:?}");
        }
    }
}

fn law(text: &str, values: &[(&str, f64)]) -> FormulaLaw {
    let formula = Formula::parse(text).unwrap_or_else(|error| panic!("{error}"));
    formula
        .with(values)
        .unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn invariants_written_in_stretches_give_the_same_law_even_for_equal_stretches() {
    let angle = [("fiber1-angle", 25.0)];
    let fibers = "0.3*(I4 - 1)^2 + 0.1*I1*I5";
    let one = law(
        &format!("0.7*(I1 - 3) + 0.2*I2*J - ln(J) + {fibers}"),
        &angle,
    );
    let squares = "lambda1^2 + lambda2^2 + lambda3^2";
    let products = "((lambda1*lambda2)^2 + (lambda1*lambda3)^2 + (lambda2*lambda3)^2)";
    let text =
        format!("0.7*({squares} - 3 + {products}*J*2/7) - ln(lambda1*lambda2*lambda3) + {fibers}");
    let other = law(&text, &angle);
    let mut random = Random::new(22);
    for stretches in [
        [1.0, 1.0, 1.0],
        [1.3, 1.3, 0.8],
        [1.3, 1.3 + 1e-9, 0.8],
        [1.3, 1.301, 1.302],
        [1.6, 0.7, 1.1],
    ] {
        let stretches = Matrix3::from_diagonal(&Vector3::from(stretches));
        let f = of(&(random.rotation() * stretches * random.rotation()));
        let [one, other] = [&one, &other].map(|law| law.response(&f).expect("finite"));
        let scale = one.tangent[(0, 0, 0, 0)].abs();
        let error = difference(&other, &one, scale);
        assert!(error < 1e-11, "off by {error:e} at {f:?}");
    }
}

#[test]
fn asymmetric_functions_of_the_stretches_are_rejected() {
    let refused = |text: &str| {
        let formula = Formula::parse(text).expect("a formula");
        let error = formula.with(&[]).expect_err(text);
        assert!(
            error.place.is_some() && error.problem.hint().is_some(),
            "{error}"
        );
        error.problem
    };
    for text in [
        "lambda1^2 + lambda2^2",
        "lambda1*lambda2/lambda3 + I1",
        "lambda2",
    ] {
        assert!(
            matches!(refused(text), Problem::NotSymmetric { .. }),
            "{text}"
        );
    }
    let mixed = refused("(lambda1 + lambda2 + lambda3)*I1");
    assert!(matches!(mixed, Problem::StretchesMixed));
    let branched = refused("ramp(lambda1 - 1) + ramp(lambda2 - 1) + ramp(lambda3 - 1)");
    assert!(matches!(branched, Problem::StretchesBranch));
    // A condition in a separate term is not a condition on the stretches.
    law("lambda1 + lambda2 + lambda3 + ramp(J - 1)^2", &[]);
}

#[test]
fn exponentially_growing_sums_are_split_quickly() {
    let doubled: String = (1..90)
        .map(|n| format!("let a{n} = a{0} + a{0}; ", n - 1))
        .collect();
    let text = format!("let a0 = lambda1 + lambda2 + lambda3 + I1; {doubled} a89/2^89");
    let energy = law(&text, &[]).response(&DeformationGradient::identity());
    assert_eq!(energy.map(|response| response.energy), Ok(6.0));
}
