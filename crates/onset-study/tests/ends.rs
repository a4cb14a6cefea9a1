//! Checks that no number given for a key leads to a panic or to an answer with NaN or infinity: it is either answered, or refused with the key and
//! its range.

use onset_study::answers::{Problem, StateAnswer, Strain};
use onset_study::localization::{LocalizationAnswer, PARAMETERS, PlasticSettings};
use onset_study::settings::{
    KEYS, Key, Kind, MAP_KEYS, Model, Need, STATE_KEYS, Settings, Study, Value,
};
use std::fmt::Display;

const METHOD: &str = "discretization.method";

/// Ends of a range, numbers next to them, and the largest and smallest doubles.
fn numbers([low, high]: [f64; 2]) -> Vec<f64> {
    let margin = |end: f64| 1e-3 * end.abs().max(1e-30);
    let mut all = vec![low, high, low - margin(low), high + margin(high)];
    all.extend([0.0, -1.0, 5e-324, 1e308, -1e308]);
    all.extend([f64::NAN, f64::INFINITY, f64::NEG_INFINITY]);
    all
}

/// Asserts that a text contains only finite numbers.
fn assert_finite(text: &str, what: &str) {
    let is_no_number = |word: &str| ["NaN", "nan", "inf"].contains(&word);
    let mut words = text.split(|c: char| !c.is_alphanumeric());
    assert!(!words.any(is_no_number), "{what}:\n{text}");
}

/// Asserts that a `value` outside its limits is refused with its name and range, and that any other value is answered or refused without NaN.
fn assert_ended<E: Display>(
    what: &str,
    (name, expected): (&str, &str),
    is_admitted: bool,
    answer: Result<(String, String), E>,
) {
    match answer {
        Ok((text, document)) => {
            assert!(is_admitted, "{what} is answered");
            assert_finite(&text, what);
            assert_finite(&document, what);
        }
        Err(error) => {
            let told = error.to_string();
            let names = is_admitted || (told.contains(name) && told.contains(expected));
            assert!(names, "{what}: no `{expected}` in\n{told}");
            if is_admitted {
                assert_finite(&told, what);
            }
        }
    }
}

/// The answer to a state of a problem, as a text and a document.
fn state(assignments: &[String]) -> Result<(String, String), String> {
    let settings = Settings::from_assignments(assignments).map_err(|error| error.to_string())?;
    let problem = Problem::new(settings).map_err(|error| error.to_string())?;
    let stretches = if problem.dimension() == 1 {
        "1.1"
    } else {
        "1.1,1"
    };
    let strain = Strain::of_stretches("--stretch", stretches, problem.extent());
    let answer = strain.and_then(|strain| StateAnswer::new(&problem, &strain));
    let answer = answer.map_err(|error| error.to_string())?;
    let document = serde_json::to_string(&answer).expect("a document");
    Ok((answer.to_string(), document))
}

/// Assignments that satisfy a condition, and the conditions of these assignments.
fn chosen(need: &Need) -> String {
    let key = Key::named(need.key).expect("a key");
    let is_other = |word: &&&str| !need.values.contains(*word);
    let word = match need.one_of {
        true => need.values.first().copied(),
        false => key.words().iter().find(is_other).copied(),
    };
    format!("{}={}", need.key, word.unwrap_or("0.3"))
}

/// Numbers that are tried for a key, as text.
fn typed(key: &Key) -> Vec<(String, f64)> {
    let beside = match key.name {
        "discretization.vectors" => "1,0,0.3,",
        "discretization.points" => "0.2,0.1,",
        _ => "",
    };
    let tried = key.kind.limits().map(numbers).unwrap_or_default();
    let typed = |number: f64| (format!("{}={beside}{number:?}", key.name), number);
    tried.into_iter().map(typed).collect()
}

/// Returns true if a key accepts a number, alone or in a list.
fn admits(kind: Kind, number: f64) -> bool {
    kind.accepts(&Value::Number(number)) || kind.accepts(&Value::Numbers(vec![number]))
}

#[test]
fn every_number_of_every_method_is_answered_or_refused_with_its_range() {
    let method = Key::named(METHOD).expect("a key");
    let mut tried = 0;
    for word in method.words() {
        let set = format!("{METHOD}={word}");
        let settings = Settings::from_assignments(std::slice::from_ref(&set)).expect("a method");
        let own = KEYS
            .iter()
            .filter(|key| key.parts().0 == "discretization" && key.kind.limits().is_some());
        for key in own {
            let Some(lacking) = key.lacking(METHOD, &|name| settings.value(name)) else {
                continue;
            };
            let mut base = vec![set.clone()];
            base.extend(lacking.iter().map(chosen));
            if ["discretization.perturbation", "discretization.seed"].contains(&key.name) {
                base.push("discretization.cells=2".to_owned());
            }
            // Chains take a fraction of the time of lattices.
            let of_plane = ["vectors", "points", "aspect"].contains(&key.parts().1);
            let place = match *word {
                "finite-elements" => ("discretization.mesh", "bars"),
                _ => ("discretization.lattice", "chain"),
            };
            let is_chosen = base.iter().any(|own| own.starts_with(place.0));
            let is_multilinear = base.iter().any(|own| own.contains("integration"));
            if !of_plane && !is_chosen && !is_multilinear {
                base.push(format!("{}={}", place.0, place.1));
            }
            for (assignment, number) in typed(key) {
                let is_admitted = admits(key.kind, number);
                // Admitted counts are skipped, because cells with thousands of particles take too long.
                if is_admitted && key.kind.takes() == Some("whole") {
                    continue;
                }
                let mut all = base.clone();
                all.push(assignment.clone());
                let what = all.join(" ");
                assert_ended(&what, (key.name, &key.expects()), is_admitted, state(&all));
                tried += 1;
            }
        }
    }
    assert!(tried > 700, "{tried}");
}

#[test]
fn every_number_of_every_law_is_answered_or_refused_with_its_range() {
    let mut tried = 0;
    for model in Model::all() {
        for parameter in model.parameters() {
            for number in numbers(parameter.admitted.limits(parameter.unit)) {
                let all = [
                    format!("material.model={}", model.name()),
                    format!("material.{}={number:?}", parameter.name),
                    "discretization.lattice=chain".to_owned(),
                ];
                // A number outside the ranges of all laws is refused with the common range.
                let is_typed = number.abs() <= 1e30;
                let expected = if is_typed {
                    parameter.expected()
                } else {
                    Key::named(&format!("material.{}", parameter.name))
                        .expect("a key")
                        .expects()
                };
                let is_admitted = parameter.holds(number);
                let what = all.join(" ");
                assert_ended(&what, (parameter.name, &expected), is_admitted, state(&all));
                tried += 1;
            }
        }
    }
    for (name, other) in [
        ("young", "poisson=0.3"),
        ("poisson", "young=2"),
        ("bulk", "shear=1"),
        ("shear", "poisson=0.3"),
    ] {
        let key = Key::named(&format!("material.{name}")).expect("a key");
        for (assignment, number) in typed(key) {
            let all = [
                "material.model=neo-hooke".to_owned(),
                format!("material.{other}"),
                assignment,
                "discretization.lattice=chain".to_owned(),
            ];
            let expected = key.expects();
            let expected = expected.split(" (").next().unwrap_or_default();
            let is_admitted = admits(key.kind, number);
            assert_ended(&all.join(" "), (name, expected), is_admitted, state(&all));
            tried += 1;
        }
    }
    assert!(tried > 1500, "{tried}");
}

#[test]
fn every_number_of_a_study_and_of_a_plastic_law_is_accepted_or_refused_with_its_range() {
    let axis = |quantity: &str, range: &str| {
        format!("[[axes]]\nquantity = \"{quantity}\"\nrange = {range}\nstates = 2\n")
    };
    let text = axis("discretization.support", "[2, 3]") + &axis("discretization.density", "[1, 2]");
    let study = Study::parse("s.toml", &text).expect("a study");
    for key in STATE_KEYS.iter().chain(MAP_KEYS) {
        for (assignment, number) in typed(key) {
            let set = ["map.certify=true", "map.adaptive=true", "map.tile=1024"];
            let mut all: Vec<String> = set.into_iter().map(str::to_owned).collect();
            all.retain(|own| !own.starts_with(key.name));
            all.push(assignment.clone());
            let taken = study.clone().override_with(&all);
            let answer = taken.map(|_| (String::new(), String::new()));
            let is_admitted = admits(key.kind, number);
            assert_ended(&assignment, (key.name, &key.expects()), is_admitted, answer);
        }
    }
    for parameter in PARAMETERS {
        let mut base = Vec::new();
        let mut needed = parameter.only_with;
        while let Some((name, words)) = needed {
            base.push(format!("{name}={}", words[0]));
            let other = PARAMETERS.iter().find(|other| other.name == name);
            needed = other.and_then(|other| other.only_with);
        }
        if base.iter().any(|own| own.ends_with("=umat")) {
            continue;
        }
        for number in parameter.kind.limits().map(numbers).unwrap_or_default() {
            let mut all = base.clone();
            all.push(format!("{}={number:?}", parameter.name));
            let settings = PlasticSettings::from_assignments(&all);
            let answer = settings.map_err(|error| error.to_string()).and_then(|set| {
                let answer = LocalizationAnswer::new(&set).map_err(|error| error.to_string())?;
                let document = serde_json::to_string(&answer).expect("a document");
                Ok((answer.to_string(), document))
            });
            let expected = parameter.kind.expects();
            let is_admitted = admits(parameter.kind, number);
            let what = all.join(" ");
            assert_ended(&what, (parameter.name, &expected), is_admitted, answer);
        }
    }
}
