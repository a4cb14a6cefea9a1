//! User-defined laws: they give the answers of built-in laws with the same energy, and errors are shown in the formula.

use crate::{Scratch, assert_close, number, onset};
use serde_json::Value;

/// Output of `onset` as JSON.
fn answer(arguments: &[&str]) -> Value {
    let answer = onset(&[arguments, &["--json"]].concat());
    assert_eq!(answer.code, Some(0), "{arguments:?}: {}", answer.stderr);
    serde_json::from_str(&answer.stdout).expect("one JSON document")
}

/// Error message of `onset`.
fn refusal(arguments: &[&str]) -> String {
    let answer = onset(arguments);
    assert_eq!(
        answer.code,
        Some(2),
        "{arguments:?}: {}{}",
        answer.stdout,
        answer.stderr
    );
    answer.stderr
}

const STATES: [&[&str]; 2] = [
    &["state", "--stretch", "1.2,0.9"],
    &["state", "--deformation-gradient", "1.1,0.3,-0.1,0.9"],
];

#[test]
fn a_formula_gives_the_answers_of_the_built_in_law_with_its_energy() {
    let mooney =
        "material.energy=c1/2*I1 + c2/2*I2 - 3/2*c1*I3^(1/3) - 3/2*c2*I3^(2/3) + lambda/4*ln(I3)^2";
    let cases: [(&[&str], &[&str]); 2] = [
        (
            &[
                "--set",
                "material.model=blatz-ko",
                "--set",
                "material.mu=32",
            ],
            &[
                "--energy",
                "mu/2*(I2/I3 + 2*sqrt(I3) - 5)",
                "--set",
                "material.mu=32",
            ],
        ),
        (
            &[],
            &[
                "--set",
                "material.model=formula",
                "--set",
                mooney,
                "--set",
                "material.c1=0.1256",
                "--set",
                "material.c2=0.01012",
                "--set",
                "material.lambda=10.12",
            ],
        ),
    ];
    for state in STATES {
        for (built_in, typed) in cases {
            let [built_in, typed] = [built_in, typed].map(|law| answer(&[state, law].concat()));
            assert_eq!(typed["material"]["model"], "formula");
            assert_same(&built_in, &typed, "");
        }
    }
}

/// Checks that all numbers of two documents agree, except for names of the law.
fn assert_same(built_in: &Value, typed: &Value, place: &str) {
    let names_the_law = [
        "/material/model",
        "/material/parameters",
        "/settings",
        "/next",
    ]
    .contains(&place);
    // All directions are minimal for equation (5) in its domain, so that rounding decides which direction is printed.
    let is_free = ["direction", "polarization"]
        .iter()
        .any(|name| place.ends_with(name));
    if names_the_law || is_free {
        return;
    }
    match (built_in, typed) {
        (Value::Number(a), Value::Number(b)) => {
            let [a, b] = [a, b].map(|number| number.as_f64().expect("a double"));
            let error = (a - b).abs();
            assert!(error <= 1e-9 * a.abs().max(1e-3), "{place}: {a} and {b}");
        }
        (Value::Array(a), Value::Array(b)) => {
            assert_eq!(a.len(), b.len(), "{place}");
            for (n, (a, b)) in a.iter().zip(b).enumerate() {
                assert_same(a, b, &format!("{place}/{n}"));
            }
        }
        (Value::Object(a), Value::Object(b)) => {
            assert!(a.keys().eq(b.keys()), "{place}");
            for (name, value) in a {
                assert_same(value, &b[name], &format!("{place}/{name}"));
            }
        }
        _ => assert_eq!(built_in, typed, "{place}"),
    }
}

#[test]
fn a_map_can_vary_a_parameter_of_a_formula() {
    let place = Scratch::new("formula");
    std::fs::create_dir(&place).expect("a folder");
    let study = place.join("study.toml");
    let text = "[material]\nmodel = \"formula\"\nenergy = \"\"\"\nlet log = ln(J);\n\
                mu/2*(I1 - 3 - 2*log) + stiffness/2*log^2\n\"\"\"\nmu = 1.0\n\n\
                [[axes]]\nquantity = \"stretch-1\"\nrange = [0.6, 3.0]\nstates = 8\n\n\
                [[axes]]\nquantity = \"material.stiffness\"\nrange = [0.5, 4.0]\nstates = 8\n";
    std::fs::write(&study, text).expect("a study");
    let study = study.display().to_string();
    let summary = answer(&["check", &study]);
    assert_eq!(summary[0]["valid"], true, "{summary}");
    let wrong = refusal(&["check", &study, "--set", "material.mu2=1"]);
    assert!(wrong.contains("no parameter `mu2`"), "{wrong}");
}

#[test]
fn a_mistake_is_shown_with_file_line_and_column_in_the_formula() {
    let place = Scratch::new("wrong-formula");
    std::fs::create_dir(&place).expect("a folder");
    let study = place.join("study.toml");
    let axes = "[[axes]]\nquantity = \"stretch-1\"\nrange = [0.8, 1.2]\nstates = 4\n\n\
                [[axes]]\nquantity = \"stretch-2\"\nrange = [0.8, 1.2]\nstates = 4\n";
    let name = study.display().to_string();
    for (energy, parts) in [
        (
            "mu*(I1 - 3",
            [
                "column 4: this parenthesis is not closed",
                "       ^",
                "hint: add",
            ],
        ),
        (
            "mu*(i1 - 3)",
            [
                "column 5: `i1` has no value",
                "        ^^",
                "did you mean `I1`",
            ],
        ),
        ("I1 - 3", ["no parameter `mu`", "", "has no parameters"]),
    ] {
        let text =
            format!("[material]\nmodel = \"formula\"\nenergy = \"{energy}\"\nmu = 1.0\n\n{axes}");
        std::fs::write(&study, text).expect("a study");
        let message = refusal(&["check", &name]);
        let line = if energy.starts_with("I1") { 4 } else { 3 };
        assert!(
            message.contains(&format!("study.toml:{line}:")),
            "{message}"
        );
        for part in parts {
            assert!(message.contains(part), "{message}");
        }
    }
}

#[test]
fn a_mistake_on_the_command_line_is_shown_with_its_column() {
    let state = ["state", "--stretch", "1.1,0.9", "--energy"];
    for (energy, part) in [
        ("mu*(I1 - 3", "column 4: this parenthesis is not closed"),
        ("J < 1 ? I1 : I2", "column 7: `?` has no meaning"),
        ("I1 + kappa*J", "column 6: `kappa` has no value"),
    ] {
        let message = refusal(&[&state[..], &[energy]].concat());
        assert!(
            message.contains(part) && message.contains("hint: "),
            "{message}"
        );
    }
    let parentheses = format!("{}I1{}", "(".repeat(50_000), ")".repeat(50_000));
    assert!(refusal(&[&state[..], &[&parentheses]].concat()).contains("100002 characters"));
}

#[test]
fn an_energy_needs_its_model() {
    let energy = "material.energy=I1";
    let message = refusal(&["state", "--stretch", "1.1,0.9", "--set", energy]);
    assert!(message.contains("energy"), "{message}");
}

/// Beginnings of all commands about a law.
const OF_A_LAW: [&[&str]; 6] = [
    &["state", "--stretch", "1.1,0.9"],
    &["dispersion", "--stretch", "1.1,0.9", "--wave-vector=1,1"],
    &["path", "--from", "1,1", "--to", "1.1,1.1"],
    &["audit", "--stretch", "1.1,0.9"],
    &["criteria", "--mode", "uniaxial"],
    &["card", "--out", "/nowhere"],
];

#[test]
fn every_command_about_a_law_accepts_an_energy() {
    for command in OF_A_LAW {
        let message = refusal(&[command, &["--energy", "(("]].concat());
        assert!(
            message.contains("the end of the formula"),
            "{command:?}: {message}"
        );
    }
    let energy = [
        "--energy",
        "mu/2*(I1 - 3 - 2*ln(J))",
        "--set",
        "material.mu=2",
    ];
    for command in ["audit --stretch 1.1,0.9", "criteria --mode uniaxial"] {
        let command: Vec<&str> = command.split(' ').collect();
        let told = answer(&[&command[..], &energy].concat()).to_string();
        assert!(told.contains("formula"), "{command:?}: {told}");
    }
}

#[test]
fn two_laws_for_one_problem_are_refused() {
    let energy = "mu/2*(I1 - 3 - 2*ln(J))";
    let one = ["--energy", energy, "--set", "material.mu=2"];
    for other in ["material.energy=I1", "material.model=blatz-ko"] {
        for command in OF_A_LAW {
            let message = refusal(&[command, &one, &["--set", other]].concat());
            assert!(message.contains("two laws"), "{command:?}: {message}");
        }
    }
    let twice = ["--set", "material.model=formula"];
    answer(&[OF_A_LAW[0], &one, &twice].concat());
}

#[test]
fn the_language_of_formulas_is_listed() {
    let answer = onset(&["list", "formula"]);
    assert_eq!(answer.code, Some(0));
    for word in [
        "I1bar",
        "fiber1-angle",
        "F33",
        "macaulay",
        "if(condition",
        "let ",
        "log10",
    ] {
        assert!(answer.stdout.contains(word), "{word}: {}", answer.stdout);
    }
}

#[test]
fn a_conditional_law_has_the_onset_of_its_active_branch() {
    // Fibers that are stiff in tension only: the law differs between tension and compression along them.
    let energy = "mu/2*(I1 - 3 - 2*ln(J)) + lambda/2*ln(J)^2 + k/2*macaulay(I4 - 1)^2";
    let law = [
        "--energy",
        energy,
        "--set",
        "material.mu=1",
        "--set",
        "material.lambda=1.5",
        "--set",
        "material.k=2",
        "--set",
        "material.fiber1-angle=0",
    ];
    let stress = |stretch: &str| {
        let state = ["state", "--stretch", stretch];
        number(
            &answer(&[&state[..], &law[..]].concat()),
            "/material/cauchy/0/0",
        )
    };
    // Expected stress: sigma_11 = (mu (l^2 - 1) + lambda ln l)/l + 2 k l (l^2 - 1) in tension, at F = diag(l, 1, 1).
    let matrix = |l: f64| (l * l - 1.0 + 1.5 * l.ln()) / l;
    assert_close(stress("1.2,1"), matrix(1.2) + 2.0 * 2.0 * 1.2 * 0.44, 1e-12);
    assert_close(stress("0.8,1"), matrix(0.8), 1e-12);
}

#[test]
fn an_undefined_term_is_refused_in_any_order_and_undefined_in_maps() {
    let rubber = "mu/2*(I1 - 3 - 2*ln(J))";
    for part in [
        "max(0, sqrt(X - I1))",
        "max(sqrt(X - I1), 0)",
        "0*sqrt(X - I1)",
    ] {
        let energy = |limit: &str| format!("{rubber} + 0.1*({})", part.replace('X', limit));
        let law = ["--set", "material.mu=1", "--energy"];
        for limit in ["3", "3.2"] {
            let question = ["state", "--stretch", "1.3,1.2"];
            let message = refusal(&[&question[..], &law, &[&energy(limit)]].concat());
            let root = format!("sqrt({limit} - I1)");
            assert!(
                message.contains("not defined") && message.contains(&root),
                "{message}"
            );
        }
        // The root of zero in the reference configuration has no slope; with the limit 3.2 the law is defined there and at this state.
        let question = ["state", "--stretch", "0.9,0.8"];
        answer(&[&question[..], &law, &[&energy("3.2")]].concat());
    }
    let energy = "min(-10*(I1 - 3), E23^E23) + 50*(I1 - 3 - 2*ln(J))";
    for certify in [&[][..], &["--certify"][..]] {
        let message = refusal(
            &[
                &["state", "--stretch", "1.2,0.9", "--energy", energy],
                certify,
            ]
            .concat(),
        );
        assert!(message.contains("E23^E23"), "{message}");
    }
}

#[test]
fn a_state_on_a_kink_is_refused_and_its_neighbors_are_answered() {
    for part in ["- 5*abs(J-1)", "+ 5*min(J,2-J)", "+ heaviside(1-J)"] {
        let energy = format!("10*(I1-3-2*ln(J)) {part}");
        for certify in [&[][..], &["--certify"][..]] {
            let on = ["state", "--stretch", "2,0.5", "--energy", &energy];
            let message = refusal(&[&on[..], certify].concat());
            let word = if part.contains("heaviside") {
                "jumps"
            } else {
                "kink"
            };
            assert!(message.contains(word), "{message}");
            let beside = ["state", "--stretch", "2,0.51", "--energy", &energy];
            assert_eq!(
                answer(&[&beside[..], certify].concat())["verdict"],
                "stable"
            );
        }
    }
    // Along this path one state has no answer, and nothing else changes.
    let energy = "10*(I1-3-2*ln(J)) - 5*abs(J-1)";
    let path = answer(&[
        "path", "--from", "2,0.45", "--to", "2,0.55", "--energy", energy,
    ]);
    let crossings = path["material_crossings"].as_array().expect("a list");
    let words = |crossing: &Value| format!("{} {}", crossing["from"], crossing["to"]);
    assert_eq!(crossings.len(), 2);
    for crossing in crossings {
        assert!(words(crossing).contains("undefined"), "{crossing}");
        assert_close(number(crossing, "/stretch/1"), 0.5, 1e-12);
    }
}

#[test]
fn a_fluid_is_not_strongly_elliptic_and_not_unstable() {
    for (energy, state) in [
        ("50*(J-1)^2", "1.2,0.9"),
        ("50*(J-1)^2", "1,1"),
        ("3*J^2", "1.1,0.9"),
        ("20*(J - 1 - ln(J))", "0.8,1.1"),
    ] {
        let document = answer(&["state", "--stretch", state, "--energy", energy]);
        let material = &document["material"];
        assert_eq!(material["elliptic"], false, "{energy}");
        assert_eq!(material["elliptic_3d"], false, "{energy}");
        assert_eq!(material["ellipticity"], "undecided", "{energy}");
        assert_eq!(
            number(&document, "/material/minimum_acoustic_eigenvalue"),
            0.0
        );
        assert_eq!(
            number(&document, "/material_3d/minimum_acoustic_eigenvalue"),
            0.0
        );
        assert_eq!(document["verdict"], "stable", "{energy}");
        let text = onset(&["state", "--stretch", state, "--energy", energy]).stdout;
        assert!(
            text.contains("zero to rounding") && !text.contains("is strongly elliptic"),
            "{text}"
        );
        let certified = answer(&["state", "--certify", "--stretch", state, "--energy", energy]);
        assert_eq!(
            certified["certificate"]["material"]["certainty"],
            "undecided"
        );
    }
}

#[test]
fn cases_within_rounding_are_reported_as_undecided() {
    let state = [
        "state",
        "--stretch",
        "1.5,0.6667",
        "--set",
        "material.model=neo-hooke-isochoric",
    ];
    for (kappa, word) in [
        ("1e3", "elliptic"),
        ("1e8", "elliptic"),
        ("1e20", "undecided"),
    ] {
        let kappa = format!("material.kappa={kappa}");
        let document = answer(&[&state[..], &["--set", &kappa]].concat());
        assert_eq!(document["material_3d"]["ellipticity"], word, "{kappa}");
        let number = number(&document, "/material_3d/minimum_acoustic_eigenvalue");
        assert_eq!(number > 0.0, word == "elliptic", "{kappa}: {number}");
    }
    let gent = [
        "state",
        "--stretch",
        "1.1,0.9",
        "--set",
        "material.model=gent",
        "--set",
        "material.kappa=1e20",
    ];
    let message = onset(&[&gent[..], &["--set", "discretization.lattice=honeycomb"]].concat());
    assert!(!message.stdout.contains("NaN"), "{}", message.stdout);
}
