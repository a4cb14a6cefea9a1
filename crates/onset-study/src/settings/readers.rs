//! Checks of every key for every method: it changes an answer, or it is refused, and refused keys would not change anything.

use super::{KEYS, Key, Kind, Origin, Settings, Value};
use crate::answers::Problem;
use onset::kinematics::DeformationGradient;

/// Methods by their families, each with settings under which more of its keys have an effect.
const METHODS: &[(&str, &[&[&str]])] = &[
    (
        "kernel",
        &[
            &[],
            &["frame=eulerian"],
            &["frame=eulerian", "current-lattice=regular"],
            &["quadrature=gauss"],
            &["quadrature=points", "points=0.3,0,1"],
            &["cells=2", "perturbation=0.05", "quadrature=nodal"],
            &["frame=eulerian", "cells=2", "perturbation=0.05"],
            &["lattice=rectangular", "aspect=1.1"],
            &["lattice=oblique", "vectors=1,0,0.2,1.1"],
            &["lattice=honeycomb", "support=3"],
        ],
    ),
    (
        "total-lagrangian-sph",
        &[
            &[],
            &["penalty=0.4"],
            &["viscosity=0.5"],
            &["upwinding=linear"],
            &["cells=2", "perturbation=0.05"],
            &["lattice=rectangular", "aspect=1.1"],
            &["lattice=oblique", "vectors=1,0,0.2,1.1"],
        ],
    ),
    (
        "updated-sph",
        &[
            &[],
            &["viscosity=0.5"],
            &["artificial-stress=0.3"],
            &["velocity-smoothing=0.3"],
            &["cells=2", "perturbation=0.05"],
            &["lattice=rectangular", "aspect=1.1"],
            &["lattice=oblique", "vectors=1,0,0.2,1.1"],
        ],
    ),
    (
        "finite-elements",
        &[
            &[],
            &["integration=one-point"],
            &[
                "mesh=bricks",
                "integration=one-point",
                "hourglass-stiffness=0.1",
            ],
            &["mesh=triangles"],
            &["mesh=bars"],
            &["element-order=quadratic", "mass=consistent"],
            &["cells=2", "perturbation=0.05"],
        ],
    ),
    (
        "conforming",
        &[
            &["approximation=mls"],
            &["cells=2", "perturbation=0.05"],
            &["lattice=rectangular", "aspect=1.1"],
            &["lattice=oblique", "vectors=1,0,0.2,1.1"],
        ],
    ),
    (
        "peridynamics",
        &[
            &[],
            &["bonds=correspondence"],
            &["bonds=correspondence", "influence=parabolic"],
            &[
                "bonds=correspondence",
                "control=penalty",
                "control-coefficient=0.5",
            ],
            &["bonds=correspondence", "cells=2", "perturbation=0.05"],
            &["lattice=rectangular", "aspect=1.1"],
            &["lattice=oblique", "vectors=1,0,0.2,1.1"],
        ],
    ),
    (
        "material-points",
        &[
            &[],
            &["unknowns=total-lagrangian"],
            &["unknowns=particles"],
            &["points-per-side=1"],
            &["grid-functions=gimp"],
            &["unknowns=particles", "transfer=flip"],
            &["unknowns=particles", "transfer=fmpm"],
            &["unknowns=particles", "transfer=apic", "time-step=0.1"],
        ],
    ),
];

/// Values of a key other than its default and the value of a method.
fn values(key: &Key) -> Vec<String> {
    let numbers: &[&str] = match key.kind {
        Kind::Words(words) | Kind::WordsOr(words, _) => words,
        Kind::Switch => &["true", "false"],
        Kind::Whole(..) => &["2", "3"],
        Kind::Numbers(..) => match key.name {
            "discretization.vectors" => &["1,0.1,0,1"],
            "discretization.basis" => &["0.4,0.45"],
            _ => &["0.2,0.1,1"],
        },
        _ => match key.name {
            "discretization.support" => &["2.3"],
            "discretization.horizon" => &["2.4"],
            "discretization.perturbation" => &["0.1"],
            _ => &["0.35", "0.7"],
        },
    };
    numbers.iter().map(|value| (*value).to_owned()).collect()
}

/// Frequencies of some waves at some states, without and with damping, and rates in discrete time.
fn answers(settings: &Settings) -> Result<Vec<f64>, String> {
    let told = |error: &dyn std::fmt::Display| error.to_string();
    let problem = Problem::new(settings.clone()).map_err(|error| told(&error))?;
    let mut all = Vec::new();
    for stretches in [[1.07, 0.96, 1.0], [0.94, 1.03, 1.0]] {
        let f = DeformationGradient::from_stretches(stretches).map_err(|error| told(&error))?;
        let waves = problem.analysis.waves(&f).map_err(|error| told(&error))?;
        for k in [[0.7, 0.4, 0.2], [2.1, -1.3, 0.6]] {
            let values = [waves.omega_squared(&k), waves.frequencies(&k)].concat();
            all.extend(values.iter().flat_map(|z| [z.re, z.im]));
            let stepped = problem.analysis.transferred(&f);
            if let Some(stepped) = stepped.map_err(|error| told(&error))? {
                let largest = stepped.critical_time_step();
                let step = settings.method.step_of_rates(Some(largest));
                let rates = step.map_or_else(Vec::new, |step| stepped.rates(&k, step));
                all.extend(rates.iter().flat_map(|s| [s.re, s.im]));
            }
        }
    }
    Ok(all)
}

fn differ(a: &[f64], b: &[f64]) -> bool {
    let size = a
        .iter()
        .chain(b)
        .fold(0.0, |most: f64, x| most.max(x.abs()));
    a.len() != b.len() || a.iter().zip(b).any(|(a, b)| (a - b).abs() > 1e-9 * size)
}

#[test]
fn every_key_changes_an_answer_or_is_refused_by_the_method() {
    let keys = || KEYS.iter().filter(|key| key.parts().0 == "discretization");
    for (family, choices) in METHODS {
        let bases: Vec<(Vec<String>, Vec<f64>)> = choices
            .iter()
            .map(|choices| {
                let method = std::iter::once(format!("method={family}"));
                let all = method.chain(choices.iter().map(|choice| (*choice).to_owned()));
                let all: Vec<String> = all.map(|own| format!("discretization.{own}")).collect();
                let settings = Settings::from_assignments(&all).expect("a method");
                (all, answers(&settings).expect("answers"))
            })
            .collect();
        // Cells without disorder are reduced to one cell, which affects only the size of patches.
        let others = ["discretization.method", "discretization.cells"];
        for key in keys().filter(|key| !others.contains(&key.name)) {
            for value in values(key) {
                let (mut accepted, mut changes) = (false, false);
                for (base, known) in &bases {
                    let is_chosen = base
                        .iter()
                        .any(|own| own.starts_with(&format!("{}=", key.name)));
                    let assignment = format!("{}={value}", key.name);
                    let all: Vec<String> =
                        base.iter().cloned().chain([assignment.clone()]).collect();
                    let asked = Settings::from_assignments(&all);
                    // Bypasses the table of keys, to test whether the method would use the key.
                    let mut forced = Settings::default();
                    for own in &all {
                        forced.assign(own).expect("known keys");
                    }
                    let found = answers(&forced);
                    match asked {
                        Ok(settings) => {
                            let default = settings.default_of(key);
                            let is_default = settings.value(key.name) == default || is_chosen;
                            let refused = found.is_err();
                            accepted |= !refused && !is_default;
                            changes |=
                                !is_default && found.is_ok_and(|found| differ(&found, known));
                        }
                        Err(error) if error.message.contains("has no effect") => {
                            let hint = error.hint.as_deref().unwrap_or_default();
                            assert!(hint.contains("it is used only with"), "{error}");
                            // An error about another key is not the result of this assignment.
                            let is_about_key = error.message.contains(key.name);
                            let own = matches!(&error.origin, Origin::CommandLine(text) if text.ends_with(&assignment));
                            if let (true, true, Ok(found)) = (is_about_key, own, &found) {
                                assert!(
                                    !differ(found, known),
                                    "{base:?}: {assignment} is refused, but changes the answers"
                                );
                            }
                        }
                        Err(_) => {}
                    }
                }
                assert!(
                    changes || !accepted,
                    "{family}: {} = {value} is accepted but changes nothing",
                    key.name
                );
            }
        }
    }
}

#[test]
fn exactly_the_settings_that_the_method_uses_are_in_effect() {
    for (family, choices) in METHODS {
        for choices in *choices {
            let all: Vec<String> = std::iter::once(format!("discretization.method={family}"))
                .chain(choices.iter().map(|own| format!("discretization.{own}")))
                .collect();
            let settings = Settings::from_assignments(&all).expect("a method");
            let effective = settings.effective();
            let json = serde_json::to_value(&effective).expect("a document");
            let text = effective.to_string();
            for key in KEYS.iter().filter(|key| key.parts().0 == "discretization") {
                let own = key.parts().1;
                let is_set = all
                    .iter()
                    .any(|set| set.starts_with(&format!("{}=", key.name)));
                match (effective.get(key.name), settings.unmet(key)) {
                    (Some(_), Some(_)) => panic!("{family} does not read {own}"),
                    (Some(choice), None) => {
                        assert_eq!(json[key.name]["default"], choice.default);
                        if is_set && key.name != "discretization.method" {
                            assert!(!choice.default, "{own}");
                        }
                        let is_empty = choice.value == Value::Numbers(Vec::new());
                        assert!(
                            is_empty || text.contains(own) || own == "method",
                            "{own} in {text}"
                        );
                    }
                    (None, None) => {
                        assert!(["stress-point-weight", "shear-coefficient"].contains(&own));
                    }
                    (None, Some(_)) => assert!(!is_set, "{own}"),
                }
            }
        }
    }
    // Other methods show no settings of kernel methods, and methods with a grid show a square lattice.
    let points = Settings::from_assignments(&["discretization.method=material-points"]);
    let effective = points.expect("material points").effective();
    assert_eq!(effective.get("discretization.quadrature"), None);
    let kind = effective.get("discretization.lattice").expect("a grid");
    assert_eq!(kind.value, Value::Word("square".to_owned()));
    assert!(kind.default);
}

#[test]
fn an_unsupported_lattice_is_refused() {
    let told = |assignments: &[&str]| {
        let assignments: Vec<String> = assignments
            .iter()
            .map(|own| format!("discretization.{own}"))
            .collect();
        Settings::from_assignments(&assignments)
            .expect_err("another lattice")
            .to_string()
    };
    let elements = told(&["method=finite-elements", "lattice=face-centered-cubic"]);
    assert!(
        elements.contains("`discretization.lattice` has no effect"),
        "{elements}"
    );
    let points = told(&["method=material-points", "lattice=hexagonal"]);
    assert!(points.contains("square grid"), "{points}");
    let several = told(&["frame=eulerian", "cells=2", "current-lattice=regular"]);
    assert!(several.contains("discretization.cells is 2"), "{several}");
}
