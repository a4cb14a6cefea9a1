//! `onset compare` and `onset recommend`.

use super::{Scratch, Written, document, number, onset};
use serde_json::Value;

/// Built-in comparison of methods in 2D, on a few states.
const PLANE: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../../comparisons/methods-2d.toml"
);

/// Comparison written to a separate file, with the command's answer.
fn compared(text: &str, more: &[&str]) -> (super::Answer, Scratch) {
    let folder = Scratch::new("compare");
    std::fs::create_dir_all(&folder).expect("a folder");
    let file = folder.join("methods.toml");
    std::fs::write(&file, text).expect("a file");
    let (file, out) = (file.display().to_string(), folder.display().to_string());
    let mut arguments = vec!["compare", file.as_str(), "--out", out.as_str()];
    arguments.extend(more);
    (onset(&arguments), folder)
}

#[track_caller]
fn assert_refused(text: &str, facts: &[&str]) {
    let (answer, folder) = compared(text, &[]);
    let told = &answer.stderr;
    assert_eq!(answer.code, Some(2), "{text}: {told}");
    assert_eq!(answer.stdout, "", "{text}");
    assert!(told.starts_with("error: "), "{text}: {told}");
    assert!(!told.contains("panicked"), "{text}: {told}");
    for fact in facts {
        assert!(told.contains(fact), "{text}: no `{fact}` in: {told}");
    }
    assert!(!folder.join("compare.csv").exists(), "nothing is written");
}

#[test]
fn a_key_without_values_varies_all_its_words() {
    let table = document(
        "compare set method=updated-sph set lattice=chain --set compare.states=2 --vary discretization.kernel",
    );
    let rows = table["rows"].as_array().expect("rows");
    for kernel in ["cubic-spline", "wendland-c2", "gaussian", "quintic-spline"] {
        let name = format!("kernel {kernel}");
        assert!(
            rows.iter().any(|row| row["name"] == name.as_str()),
            "{name}"
        );
    }
}

#[test]
fn twenty_methods_are_compared_in_one_table() {
    let folder = Scratch::new("twenty");
    let out = folder.display().to_string();
    let arguments = [
        "compare",
        PLANE,
        "--all",
        "--set",
        "compare.states=2",
        "--out",
        &out,
    ];
    let answer = onset(&arguments);
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    let csv = std::fs::read_to_string(folder.join("compare.csv")).expect("a file");
    assert_eq!(csv.lines().count(), 21);
    for line in csv.lines().skip(1) {
        let name = line.trim_start_matches('"');
        let first = name.split([',', '"']).next().expect("a name");
        assert!(answer.stdout.contains(first), "{first}");
    }
    for file in ["compare.html", "compare.svg", "compare.png"] {
        assert!(folder.join(file).is_file(), "{file}");
    }
    let page = std::fs::read_to_string(folder.join("compare.html")).expect("a file");
    assert_eq!(page.matches("<tr>").count(), 21);
}

/// Each method has values for three solids. The fractions of stable states are not compared, because they need more states.
#[test]
fn the_methods_side_by_side_have_the_values_of_the_book() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    let page = std::fs::read_to_string(format!("{root}/book/src/how-to/side-by-side.md"));
    let page = page.expect("a page");
    let of_book: Vec<Vec<&str>> = page
        .lines()
        .filter(|line| line.starts_with("| ") && !line.starts_with("| method"))
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect();
    let laws = ["modified-mooney-rivlin", "j2", "blatz-ko"];
    for (number_of_law, law) in laws.into_iter().enumerate() {
        let answer = onset(&[
            "compare",
            &format!("{root}/comparisons/table-2d.toml"),
            "--json",
            "--set",
            &format!("material.model={law}"),
            "--set",
            "compare.states=2",
        ]);
        assert_eq!(answer.code, Some(0), "{}", answer.stderr);
        let document: Value = serde_json::from_str(&answer.stdout).expect("a document");
        let rows = document["rows"].as_array().expect("rows");
        assert_eq!(rows.len(), of_book.len());
        for (row, told) in rows.iter().zip(&of_book) {
            let name = told[0];
            assert_eq!(row["name"], name);
            let row = &row["measured"];
            let of_law = |column: usize| told[column].split(", ").nth(number_of_law);
            let of_law = |column: usize| of_law(column).expect("three values");
            if row.is_null() {
                let own = [of_law(2), of_law(3), of_law(4), of_law(5)];
                assert_eq!(own, ["refused"; 4], "{name}: {law}");
                assert!(law != "j2" || told[6] == "refused", "{name}");
                continue;
            }
            let value = |key: &str| row[key].as_f64().expect("a number");
            assert_eq!(
                format!("{}", value("zero_modes")),
                told[1].trim_matches('*'),
                "{name}"
            );
            assert_eq!(format!("{:.2}", value("weakest")), of_law(2), "{name}");
            let error = 100.0 * number(row, "/dispersion/1/error");
            let printed: f64 = of_law(3).parse().expect("a number");
            assert!((error - printed).abs() <= 0.5, "{name}: {error}");
            let onset = &row["onsets"][0]["method"];
            let onset = match onset["at"].as_f64() {
                Some(at) if at < 1.002 => "**1**".to_owned(),
                Some(at) => format!("{at:.2}"),
                None if onset == "at-rest" => "**1**".to_owned(),
                None => "-".to_owned(),
            };
            assert_eq!(onset, of_law(4), "{name}");
            let neighbors: f64 = told[7].parse().expect("a number");
            assert!((value("neighbors") - neighbors).abs() < 0.05, "{name}");
            if law == "j2" {
                assert_eq!(format!("{:.2}", value("courant")), told[6], "{name}");
            }
        }
    }
}

#[test]
fn variants_of_a_method_are_compared_without_a_file() {
    let of = |more: &[&str]| {
        let mut arguments = vec!["compare", "--json", "--set", "compare.states=2"];
        arguments.extend(more);
        onset(&arguments)
    };
    let names = |answer: &super::Answer| -> Vec<String> {
        assert_eq!(answer.code, Some(0), "{}", answer.stderr);
        let document: Value = serde_json::from_str(&answer.stdout).expect("a document");
        let rows = document["rows"].as_array().expect("rows").iter();
        rows.map(|row| row["name"].as_str().expect("a name").to_owned())
            .collect()
    };
    let sph = ["--set", "discretization.method=total-lagrangian-sph"];
    let penalties = of(&[&sph[..], &["--vary", "discretization.penalty=0,0.5"]].concat());
    assert_eq!(names(&penalties), ["penalty 0", "penalty 0.5"]);
    let document: Value = serde_json::from_str(&penalties.stdout).expect("a document");
    assert_eq!(number(&document, "/rows/0/measured/weakest"), 0.0);
    assert!(number(&document, "/rows/1/measured/weakest") > 0.05);
    let both = of(&[
        "--vary",
        "discretization.kernel=cubic-spline,wendland-c2",
        "--vary",
        "discretization.support=1.6,2",
    ]);
    assert_eq!(
        names(&both),
        [
            "kernel cubic-spline, support 1.6",
            "kernel cubic-spline, support 2",
            "kernel wendland-c2, support 1.6",
            "kernel wendland-c2, support 2"
        ]
    );
    // The smoothing length replaces the support of the settings.
    let lengths = [
        "--set",
        "discretization.support=2",
        "--vary",
        "discretization.smoothing-length=0.9,1.1",
    ];
    assert_eq!(
        names(&of(&lengths)),
        ["smoothing-length 0.9", "smoothing-length 1.1"]
    );
    let codes = "discretization.method=lammps-smd-tlsph,sphinxsys-tl";
    assert_eq!(
        names(&of(&["--vary", codes])),
        ["lammps-smd-tlsph", "sphinxsys-tl"]
    );
    for (vary, fact) in [
        ("discretization.penalty", "has no values"),
        ("discretization.support=1.6,,2", "has an empty value"),
        ("discretization.support=1.6,1.6", "is listed twice"),
        ("discretization.penalty=0,0.5", "discretization.penalty"),
        ("discretization.suport=1.6", "discretization.support"),
        ("discretization.support=x", "discretization.support"),
        ("discretization.nonsense", "unknown key"),
        ("discretization.nonsense=1,2", "unknown key"),
        ("discretization.preset", "--vary discretization.method="),
        ("material.mu=1,2", "is the same for all methods"),
        ("compare.states=2,3", "is the same for all methods"),
    ] {
        let answer = of(&["--vary", vary]);
        assert_eq!(answer.code, Some(2), "{vary}: {}", answer.stdout);
        assert!(answer.stderr.contains(fact), "{vary}: {}", answer.stderr);
    }
    let neither = of(&[]);
    assert_eq!(neither.code, Some(2));
    assert!(
        neither.stderr.contains("--vary discretization.kernel"),
        "{}",
        neither.stderr
    );
    assert!(
        neither.stderr.contains("comparisons/"),
        "{}",
        neither.stderr
    );
    let many: Vec<String> = (0..201).map(|n| format!("1.{n:03}")).collect();
    let many = format!("discretization.support={}", many.join(","));
    assert!(of(&["--vary", &many]).stderr.contains("at most 200"));
}

#[test]
fn the_row_of_a_method_that_cannot_be_evaluated_gives_the_reason() {
    let text = "[[methods]]\nname = 'good'\n[[methods]]\nname = 'lonely, \"far\"'\nsupport = 0.5\n";
    let (answer, folder) = compared(text, &["--json"]);
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    let document: Value = serde_json::from_str(&answer.stdout).expect("one JSON document");
    assert!(number(&document, "/rows/0/measured/courant") > 0.0);
    assert!(document["rows"][0]["note"].is_null());
    assert!(document["rows"][1]["measured"].is_null());
    let note = document["rows"][1]["note"].as_str().expect("why");
    assert!(note.contains("within the support radius 0.5"), "{note}");
    let csv = std::fs::read_to_string(folder.join("compare.csv")).expect("a file");
    assert!(csv.contains("\n\"lonely, \"\"far\"\"\",,"), "{csv}");
    assert!(csv.contains("within the support radius 0.5"), "{csv}");
}

#[test]
fn a_comparison_without_any_method_that_can_be_evaluated_is_refused() {
    assert_refused(
        "[[methods]]\nname = 'lonely'\nsupport = 0.5\n",
        &[
            "none of the methods",
            "\"lonely\"",
            "support radius 0.5",
            "hint",
        ],
    );
}

#[test]
fn invalid_comparisons_are_refused_with_the_position_of_the_error() {
    let one = |more: &str| format!("[[methods]]\nname = 'a'\n{more}\n");
    for (text, facts) in [
        (
            String::new(),
            vec![
                "1:1",
                "no methods",
                "[[methods]]",
                "method = \"updated-sph\"",
            ],
        ),
        (
            "[[methods]]\n[[methods]]\n".to_owned(),
            vec!["2:1", "two methods are called \"kernel\""],
        ),
        ("methods = 3\n".to_owned(), vec!["`methods` cannot be 3"]),
        (
            "[[method]]\n".to_owned(),
            vec!["1:3", "did you mean `methods`"],
        ),
        (one("suport = 2"), vec!["3:1", "did you mean `support`"]),
        (one("frame = 'euler'"), vec!["3:9", "lagrangian | eulerian"]),
        (
            one("[[methods]]\nname = 'a'"),
            vec!["two methods are called \"a\""],
        ),
        (
            one("[[methods]]\nname = 'b'\nlattice = 'chain'"),
            vec!["3:1", "\"b\" has 1 dimension"],
        ),
        (
            one("penalty = 0.5"),
            vec!["3:1", "no effect", "total-lagrangian-sph"],
        ),
        (
            one("method = 'peridynamics'\nquadrature = 'nodal'"),
            vec![
                "4:1",
                "`discretization.quadrature` has no effect",
                "peridynamics",
            ],
        ),
        (
            one("integration = 'one-point'\nmesh = 'bricks'"),
            vec!["no effect", "finite-elements"],
        ),
        (
            one("[compare]\nstretches = [0.7, 1.0, 1.5]"),
            vec!["4:13", "two positive numbers, the smaller one first"],
        ),
        (
            one("[compare]\nstretches = [1.5, 0.7]"),
            vec!["two positive numbers"],
        ),
        (
            one("[compare]\nstates = 1"),
            vec!["a whole number from 2 to 256"],
        ),
        (
            one("[compare]\nstats = 3"),
            vec!["did you mean `compare.states`"],
        ),
        (one("[compare]\nweak = -1"), vec!["a positive number"]),
    ] {
        assert_refused(&text, &facts);
    }
}

#[test]
fn a_misspelled_key_in_an_assignment_to_a_comparison_gets_a_suggestion() {
    for (assignment, fact) in [
        ("compare.stats=3", "did you mean `compare.states`"),
        ("compare.stretches=2,1", "two positive numbers"),
        ("compare.tension=0.5", "a number above 1 and below 1e6"),
    ] {
        let answer = onset(&["compare", PLANE, "--set", assignment]);
        assert_eq!(answer.code, Some(2), "{assignment}");
        assert!(
            answer.stderr.contains(fact),
            "{assignment}: {}",
            answer.stderr
        );
    }
}

#[test]
fn keys_that_a_family_of_methods_reads_are_accepted() {
    let text = "[discretization]\nquadrature = 'nodal'\n[[methods]]\nname = 'c'\n\
                [[methods]]\nname = 'a'\nmethod = 'updated-sph'\nsupport-size = 'scaled'\n\
                [[methods]]\nname = 'b'\nmethod = 'finite-elements'\nintegration = 'one-point'\nhourglass-stiffness = 0.1\n";
    let (answer, _folder) = compared(text, &["--quiet"]);
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    assert_eq!((answer.stdout.as_str(), answer.stderr.as_str()), ("", ""));
}

#[test]
fn the_recommended_method_has_no_spurious_modes() {
    let answer = onset(&[
        "recommend",
        "--stretches",
        "0.9,1.2",
        "--set",
        "compare.states=2",
        "--json",
    ]);
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    let document: Value = serde_json::from_str(&answer.stdout).expect("one JSON document");
    let best = &document["ranking"][0];
    assert!(best["excluded"].is_null(), "{best}");
    let rows = document["table"]["rows"].as_array().expect("rows");
    let row = rows
        .iter()
        .find(|row| row["name"] == best["name"])
        .expect("its row");
    assert_eq!(row["measured"]["zero_modes"], 0);
    assert!(number(row, "/measured/weakest") >= 0.1);
    // Nodal integration is excluded for its zero-energy modes.
    let ranking = document["ranking"].as_array().expect("a ranking");
    let nodal = ranking
        .iter()
        .find(|one| one["name"] == "Lagrangian Shepard, nodal");
    assert_eq!(nodal.expect("nodal")["excluded"][0], 2);
}

#[test]
fn invalid_windows_are_refused() {
    for window in ["2,1", "0.8", "-1,2", "0,1", "a,b"] {
        let answer = onset(&["recommend", "--stretches", window]);
        assert_eq!(answer.code, Some(2), "{window}");
        assert!(
            answer.stderr.contains("two positive stretches"),
            "{}",
            answer.stderr
        );
    }
}

#[test]
fn a_method_without_axes_and_a_body_are_compared_and_ranked() {
    let pmb = "[material]\nmodel = 'neo-hooke'\nyoung = 3e9\npoisson = 0.25\n[discretization]\nmethod = 'peridynamics'\n\
               lattice = 'simple-cubic'\nhorizon = 3.0427\ndensity = 1200\nspacing = 6.5737e-4\n[compare]\nstates = 2\n";
    let block = "[material]\nmodel = 'neo-hooke'\nyoung = 1.0\npoisson = 0.45\n[discretization]\nmethod = 'total-lagrangian-sph'\n\
                 lattice = 'square'\nkernel = 'cubic-spline'\nsupport = 2.6\ncorrected = true\npenalty = 0.1\n[body]\nshape = 'block'\n\
                 size = [20, 20]\n[compare]\nstates = 2\n";
    let (pmb, block) = (
        Written::new("pmb.toml", pmb),
        Written::new("block.toml", block),
    );
    let answer = |command: &str, file: &str| -> Value {
        let window = [
            "--set",
            "compare.tension=1.1",
            "--set",
            "compare.compression=0.9",
        ];
        let answer = onset(&[&[command, file, "--json"], &window[..]].concat());
        assert_eq!(answer.code, Some(0), "{}", answer.stderr);
        serde_json::from_str(&answer.stdout).expect("a document")
    };
    let own = |table: &Value| -> Value {
        let row = table["rows"][0].clone();
        assert_eq!(row["name"], "the study's own method");
        row["measured"].clone()
    };
    let error = own(&answer("compare", &pmb))["long_wave_error"].as_f64();
    // The horizon contains 123 whole volumes.
    assert!(
        (error.expect("a number") - 0.0502).abs() < 5e-5,
        "{error:?}"
    );
    let measured = own(&answer("recommend", &block)["table"]);
    // The largest eigenvalue of the stiffness of the free block, assembled elsewhere: omega = 2.97690025.
    let step = measured["body"]["time_step"].as_f64().expect("a step");
    assert!((step * 2.976_900_25 / 2.0 - 1.0).abs() < 1e-6, "{step}");
    let of_lattice = measured["critical_time_step"].as_f64().expect("a step");
    assert!((of_lattice - 1.25763).abs() < 1e-5, "{of_lattice}");
}
