//! `onset fit`: laws fitted to tables of test data, files for other commands and programs, and rejection of invalid tables.

use super::{Scratch, Written, assert_close, number, numbers, onset};
use serde_json::Value;

/// Tables of Treloar's tests.
fn tables(tests: &[&str]) -> Vec<String> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../rubber");
    let path = |test: &&str| format!("{folder}/treloar-{test}.csv");
    tests.iter().map(path).collect()
}

const ALL: [&str; 3] = ["uniaxial", "equibiaxial", "planar"];

/// Fit of a law to tests, with additional arguments; the text, or the error.
#[track_caller]
fn fitted(tests: &[&str], line: &str, code: i32) -> String {
    let files = tables(tests);
    let words = files.iter().map(String::as_str);
    let words: Vec<&str> = ["fit"]
        .into_iter()
        .chain(words)
        .chain(line.split(' '))
        .collect();
    let answer = onset(&words);
    assert_eq!(answer.code, Some(code), "{line}: {}", answer.stderr);
    match code {
        2 => answer.stderr,
        _ => answer.stdout,
    }
}

#[track_caller]
fn fitted_json(tests: &[&str], line: &str) -> Value {
    let text = fitted(tests, &format!("{line} --json"), 0);
    serde_json::from_str(&text).expect("one JSON document")
}

/// Text on one line.
fn unwrapped(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn the_stability_constraint_costs_nothing_if_the_best_fit_is_stable() {
    let text = unwrapped(&fitted(&ALL, "--law yeoh", 0));
    for fact in [
        "yeoh fits the 3 tests within 12.2 %",
        "stable at all states up to stretch 9.5 (proved)",
        "stable without the constraint, which therefore costs nothing",
        "equibiaxial 15.8 % at 1.027 to 4.45",
        "without a volumetric test",
        "onset criteria --incompressible --set material.model=yeoh",
    ] {
        assert!(text.contains(fact), "no `{fact}` in {text}");
    }
    let answer = fitted_json(&ALL, "--law yeoh");
    // Reference values: least squares of relative errors by QR decomposition of the 53 x 3 matrix.
    assert_close(number(&answer, "/laws/0/loss"), 0.794_655_374_338_3, 1e-10);
    assert_close(number(&answer, "/laws/0/error"), 0.122_447_938_4, 1e-9);
    assert_close(
        number(&answer, "/laws/0/constants/0/value"),
        0.193_086_290_65,
        1e-9,
    );
    assert_eq!(answer["laws"][0]["is_global"], true);
    assert_eq!(answer["laws"][0]["needs_no_demand"], true);
    assert_eq!(answer["laws"][0]["proof"]["kind"], "proved");
    assert_eq!(answer["tests"].as_array().map(Vec::len), Some(3));
    assert_eq!(numbers(&answer, "/laws/0/tests/0/stresses").len(), 24);
}

#[test]
fn the_cost_of_stability_is_in_the_answer() {
    let text = unwrapped(&fitted(&ALL, "--law polynomial-2", 0));
    for fact in [
        "polynomial-2 fits the 3 tests within 17.8 %",
        "Without the stability constraint it would fit within 14.6 %",
        "strong ellipticity at stretch 2.934 in equibiaxial tension (inside the equibiaxial data, 1.027 to 4.45)",
        "Drucker's criterion at stretch 3.268",
    ] {
        assert!(text.contains(fact), "no `{fact}` in {text}");
    }
    let free = fitted(&ALL, "--law polynomial-2 --stable none", 0);
    assert!(unwrapped(&free).contains(
        "within 14.6 % (root mean square of relative errors); stability was not required"
    ));
    let wide = fitted_json(&ALL, "--law polynomial-2");
    let near = fitted_json(&ALL, "--law polynomial-2 --stable data=1");
    let loadings = fitted_json(&ALL, "--law polynomial-2 --stable loadings=0.6,3");
    let within = fitted_json(&ALL, "--law yeoh --stable box=0.3,4");
    let [wide, near, loadings] = [wide, near, loadings].map(|own| number(&own, "/laws/0/loss"));
    assert!(loadings <= near && near <= wide, "{loadings} {near} {wide}");
    let stretches = numbers(&within, "/stretches");
    assert_close(stretches[0], 0.3, 1e-12);
    assert_close(stretches[1], 4.0, 1e-12);
}

/// Table of one of Treloar's tests with each row changed, without its name for the stress.
fn changed(test: &str, header: &str, mut row: impl FnMut([f64; 2]) -> [f64; 2]) -> String {
    let [path] = &tables(&[test])[..] else {
        unreachable!("one path")
    };
    let text = std::fs::read_to_string(path).expect("the table");
    let rows = text.lines().filter_map(|line| {
        let (stretch, stress) = line.split_once(',')?;
        Some(row([stretch.parse().ok()?, stress.parse().ok()?]))
    });
    let rows: Vec<String> = rows.map(|[a, b]| format!("{a},{b}")).collect();
    format!("# mode: {test}\n{header}\n{}\n", rows.join("\n"))
}

#[test]
fn a_true_stress_given_as_nominal_stress_leads_to_a_question() {
    let others = |test: &str| -> Vec<String> {
        let all = ALL.into_iter().filter(|own| *own != test);
        tables(&all.collect::<Vec<_>>())
    };
    for (test, header, is_true, fact) in [
        (
            "planar",
            "stretch,nominal_stress",
            true,
            "name the column true_stress",
        ),
        (
            "uniaxial",
            "stretch,stress",
            true,
            "refer to the deformed area",
        ),
        // A nominal stress in a column of true stresses.
        (
            "planar",
            "stretch,true_stress",
            false,
            "name the column nominal_stress",
        ),
    ] {
        let text = changed(test, header, |[a, b]| [a, if is_true { a * b } else { b }]);
        let file = Written::new(&format!("{test}.csv"), text);
        let others = others(test);
        let words = [
            &["fit", &file, "--law", "yeoh,biderman"][..],
            &[&others[0], &others[1]],
        ];
        let text = unwrapped(&onset(&words.concat()).stdout);
        assert!(
            text.contains(&format!("question {test} (")) && text.contains(fact),
            "{test}: {text}"
        );
    }
    // Measured stresses, also with errors of 5 %, lead to no question.
    let questions = |files: &[&str]| {
        let answer = onset(
            &[
                &["fit", "--law", "yeoh", "--stable", "none", "--json"],
                files,
            ]
            .concat(),
        );
        let answer: Value = serde_json::from_str(&answer.stdout).expect("one JSON document");
        answer["questions"].as_array().expect("a list").len()
    };
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../rubber");
    let mut state = 1_u64;
    let mut noise = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        // The sum of four uniform numbers is nearly normal.
        let parts = (0..4).map(|n| (state >> (8 * n + 24) & 0xff) as f64 / 255.0 - 0.5);
        0.05 * parts.sum::<f64>() * 3.0_f64.sqrt()
    };
    for material in ["treloar", "meunier"] {
        let files: Vec<String> = ALL
            .map(|own| format!("{folder}/{material}-{own}.csv"))
            .to_vec();
        let words: Vec<&str> = files.iter().map(String::as_str).collect();
        for pair in [&words[..], &words[..2], &words[1..]] {
            assert_eq!(questions(pair), 0, "{pair:?}");
        }
    }
    for _ in 0..4 {
        let noisy: Vec<Written> = ALL
            .map(|own| {
                let text = changed(own, "stretch,nominal_stress", |[a, b]| {
                    [a, b * (1.0 + noise())]
                });
                Written::new(&format!("{own}.csv"), text)
            })
            .into();
        let words: Vec<&str> = noisy.iter().map(|own| &**own).collect();
        assert_eq!(questions(&words), 0);
    }
}

#[test]
fn the_cost_has_the_measure_that_was_minimized() {
    let text = unwrapped(&fitted(
        &ALL,
        "--law polynomial-3 --weights absolute --unit MPa",
        0,
    ));
    for fact in [
        "within 0.0728 MPa (root mean square of errors)",
        "it would fit within 0.0718 MPa",
    ] {
        assert!(text.contains(fact), "no `{fact}` in {text}");
    }
    let answer = fitted_json(&ALL, "--law polynomial-3 --weights absolute");
    let [loss, error] = ["loss", "minimized"].map(|key| number(&answer, &format!("/laws/0/{key}")));
    assert_close(error, (loss / 53.0).sqrt(), 1e-12);
    let weighted = unwrapped(&fitted(&ALL, "--law yeoh --weights by-test", 0));
    assert!(
        weighted.contains("(root mean square of weighted relative errors)"),
        "{weighted}"
    );
}

#[test]
fn data_beyond_the_range_are_noted_by_test() {
    let text = unwrapped(&fitted(&ALL, "--law yeoh --stable box=0.3,4", 0));
    for fact in [
        "the data reach beyond the range of the stability constraint",
        "equibiaxial 1.68 (the data reach 4.45)",
        "uniaxial 3.57 (the data reach 7.6)",
    ] {
        assert!(text.contains(fact), "no `{fact}` in {text}");
    }
    for line in [
        "--stable box=0.01,10",
        "--stable data=1",
        "--stable loadings=0.1,10",
    ] {
        let text = fitted(&ALL, &format!("--law yeoh {line}"), 0);
        assert!(!text.contains("reach beyond"), "{line}: {text}");
    }
}

#[test]
fn a_ranking_has_the_best_three_laws_and_the_constants_of_the_first() {
    let text = fitted(
        &ALL,
        "--law ogden-3,yeoh,biderman,gent,arruda-boyce,neo-hooke",
        0,
    );
    assert!(text.lines().count() <= 12, "{text}");
    for fact in [
        "ogden-3  ",
        "biderman  ",
        "yeoh  ",
        "constants   mu1",
        "note: ",
    ] {
        assert!(text.contains(&format!("\n{fact}")), "no `{fact}` in {text}");
    }
}

#[test]
fn programs_without_a_block_are_named() {
    let scratch = Scratch::new("fit");
    let out = scratch.to_string_lossy().into_owned();
    let text = unwrapped(&fitted(&ALL, &format!("--law polynomial-2 --out {out}"), 0));
    assert!(
        text.contains("no block for felupe: without the law polynomial-2"),
        "{text}"
    );
    let all = unwrapped(&fitted(
        &ALL,
        &format!("--law fung-isotropic --out {out}"),
        0,
    ));
    assert!(
        all.contains("no block for Abaqus, ANSYS, CalculiX, FEBio, felupe, LS-DYNA, Radioss"),
        "{all}"
    );
    let free = fitted(&ALL, &format!("--law yeoh --out {out}"), 0);
    assert!(!free.contains("no block"), "{free}");
}

#[test]
fn tests_have_weights() {
    let error = |line: &str| {
        let answer = fitted_json(&ALL, &format!("--law yeoh --stable none {line}"));
        number(&answer, "/laws/0/tests/1/relative")
    };
    let [none, one, heavy] = [
        "--weights relative",
        "--weight equibiaxial=1",
        "--weight equibiaxial=30",
    ]
    .map(error);
    assert_close(none, one, 1e-12);
    assert!(heavy < 0.8 * none, "{heavy} {none}");
    for (line, fact) in [
        (
            "--weight biaxial=3",
            "the tests are uniaxial, equibiaxial, planar",
        ),
        ("--weight equibiaxial=0", "positive number"),
        ("--weight equibiaxial", "TEST=NUMBER"),
    ] {
        let refused = unwrapped(&fitted(&ALL, &format!("--law yeoh {line}"), 2));
        assert!(refused.contains(fact), "{line}: {refused}");
    }
    let text = unwrapped(&fitted(&ALL, "--law yeoh --weight equibiaxial=3 --all", 0));
    assert!(text.contains("from 1.027 to 4.45, weight 3"), "{text}");
    // The same weight in a list of tests.
    let files = tables(&ALL);
    let list = files.iter().map(|file| {
        let weight = if file.contains("equibiaxial") {
            "weight = 30\n"
        } else {
            ""
        };
        format!("[[tests]]\nfile = {file:?}\n{weight}")
    });
    let list = Written::new("tests.toml", list.collect::<String>());
    let words = ["fit", &list, "--law", "yeoh", "--stable", "none", "--json"];
    let answer: Value = serde_json::from_str(&onset(&words).stdout).expect("one JSON document");
    assert_close(number(&answer, "/laws/0/tests/1/relative"), heavy, 1e-12);
}

#[test]
fn compression_given_as_positive_numbers_leads_to_a_question() {
    let pull = "0.05,.08 0.1,.17 0.2,.4 0.3,.7 0.4,1.2 0.5,1.9";
    let lines: Vec<&str> = pull.split(' ').collect();
    let text = rows("strain,nominal_stress", &lines);
    let file = Written::new("uniaxial.csv", text);
    let asked = unwrapped(&onset(&["fit", &file, "--law", "neo-hooke"]).stdout);
    assert!(
        asked.contains("was the specimen compressed?") && asked.contains("negative numbers"),
        "{asked}"
    );
    // Tension of rubber, and a curve that stiffens from the beginning.
    let stiff: Vec<String> = (1..8)
        .map(|n| f64::from(n) * 0.1)
        .map(|own| format!("{own},{}", 0.1 * ((6.0 * own).exp() - 1.0)))
        .collect();
    let stiff: Vec<&str> = stiff.iter().map(String::as_str).collect();
    let soft = table(HEADER, |own| own);
    for text in [rows("strain,nominal_stress", &stiff), soft] {
        let file = Written::new("uniaxial.csv", text);
        let text = onset(&["fit", &file, "--law", "yeoh", "--stable", "none"]).stdout;
        assert!(!text.contains("compressed?"), "{text}");
    }
}

#[test]
fn materials_that_cannot_be_fitted_are_refused_with_the_reason() {
    for (law, reason) in [
        ("j2", "it is not hyperelastic"),
        ("marlow", "a formula, table or routine"),
        ("holzapfel-gasser-ogden", "it is anisotropic"),
        ("ogdn-3", "did you mean `ogden-3`"),
    ] {
        let refused = fitted(&ALL, &format!("--law {law}"), 2);
        assert!(refused.contains(reason), "{law}: {refused}");
    }
}

#[test]
fn headers_without_the_expected_columns_get_a_hint() {
    for (header, hint) in [
        ("displacement [mm],force [N]", "gauge length"),
        ("Specimen: S1", "lines before the header with #"),
        ("lambda,sigma_eng (kPa)", "`lambda`, `sigma_eng (kPa)`"),
    ] {
        let text = rows(header, &["1.1,.1", "1.2,.2", "1.5,.4"]);
        assert_refused("uniaxial.csv", text, "", &["line 1", hint]);
    }
    let text = rows("strain,stress", &["%,MPa", "10,.1", "20,.2", "50,.4"]);
    assert_refused(
        "uniaxial.csv",
        text,
        "",
        &["line 2", "units into the header"],
    );
}

#[test]
fn laws_of_foam_are_fitted_to_specimens_that_change_their_volume() {
    // Uniaxial response of a foam with the exponent 8 and without lateral strain.
    let stretches = [0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 1.05, 1.1, 1.2, 1.3];
    let row = |own: &f64| format!("{own},1,{}", 0.25 * (own.powf(7.0) - own.recip()));
    let lines: Vec<String> = stretches.iter().map(row).collect();
    let text = format!(
        "stretch,lateral_stretch,nominal_stress\n{}\n",
        lines.join("\n")
    );
    let file = Written::new("uniaxial.csv", text);
    let answer = onset(&["fit", &file]);
    let text = unwrapped(&answer.stdout);
    assert!(
        text.starts_with("hyperfoam-2 fits the test within"),
        "{text}"
    );
    let all = onset(&["fit", &file, "--all"]).stdout;
    assert_eq!(
        all.matches("laws of rubber, which keep the volume, are not tried")
            .count(),
        1
    );
    for law in ["yeoh", "ogden-1", "neo-hooke"] {
        assert!(!all.contains(law), "{law}: {all}");
    }
}

#[test]
fn unstable_laws_end_with_exit_code_3() {
    fitted(&ALL, "--law polynomial-2 --fail-on unstable", 0);
    // Hencky's law loses ellipticity at large stretches for any modulus.
    fitted(&ALL, "--law hencky --fail-on unstable", 3);
    fitted(&ALL, "--law hencky", 2);
    fitted(&ALL, "--law yeoh --fail-on unstable --stable none", 2);
}

/// Limits of all criteria along all loadings, as `onset criteria` finds them.
#[track_caller]
fn limits(words: &[&str]) -> Vec<Option<f64>> {
    let answer = onset(&[&["criteria", "--incompressible", "--json"], words].concat());
    assert_eq!(answer.code, Some(0), "{words:?}: {}", answer.stderr);
    let answer: Value = serde_json::from_str(&answer.stdout).expect("one JSON document");
    let list = |own: &Value, name: &str| own[name].as_array().cloned().unwrap_or_default();
    let loadings = list(&answer, "loadings").into_iter();
    let criteria = loadings.flat_map(|own| list(&own, "criteria"));
    let limits: Vec<Option<f64>> = criteria
        .flat_map(|own| ["compression", "tension"].map(|side| own[side]["limit"].as_f64()))
        .collect();
    assert!(limits.len() >= 20, "{words:?}: {}", limits.len());
    limits
}

#[track_caller]
fn assert_same(limits: &[Option<f64>], expected: &[Option<f64>], file: &str) {
    assert_eq!(limits.len(), expected.len(), "{file}");
    for (own, expected) in limits.iter().zip(expected) {
        match (own, expected) {
            (Some(own), Some(expected)) => assert_close(*own, *expected, 1e-9),
            _ => assert_eq!(own, expected, "{file}"),
        }
    }
}

#[test]
fn written_files_are_read_by_other_commands_with_the_same_limits() {
    for (law, missing) in [
        ("yeoh", &[][..]),
        ("polynomial-2", &["felupe.py"][..]),
        ("ogden-2", &[][..]),
    ] {
        let folder = Scratch::new("fit");
        let out = folder.to_str().expect("UTF-8");
        fitted(&ALL, &format!("--law {law} --stable none --out {out}"), 0);
        let path = |name: &str| format!("{out}/{name}");
        let of_study = limits(&[&path("fit.toml")]);
        let state = onset(&["state", &path("fit.toml"), "--stretch", "1.2,1"]);
        assert_eq!(state.code, Some(0), "{}", state.stderr);
        for (program, name) in [
            ("abaqus", "abaqus.inp"),
            ("ansys", "ansys.dat"),
            ("calculix", "calculix.inp"),
            ("febio", "febio.feb"),
            ("felupe", "felupe.py"),
            ("ls-dyna", "lsdyna.k"),
            ("radioss", "radioss.rad"),
        ] {
            let file = path(name);
            let exists = std::path::Path::new(&file).exists();
            assert_eq!(exists, !missing.contains(&name), "{law}: {name}");
            if exists {
                assert_same(
                    &limits(&["--from", program, &file]),
                    &of_study,
                    &format!("{law}: {name}"),
                );
            }
        }
        for name in ["fit.json", "fit.csv", "fit.svg", "fit.png"] {
            assert!(folder.join(name).is_file(), "{law}: {name}");
        }
        let table = std::fs::read_to_string(path("fit.csv")).expect("a table");
        assert_eq!(table.lines().count(), 1 + 53);
        assert!(!table.contains("NaN"), "{table}");
    }
}

const HEADER: &str = "stretch,nominal_stress";

/// Points of a uniaxial test.
const POINTS: [[f64; 2]; 5] = [[1.1, 0.1], [1.3, 0.25], [1.6, 0.4], [2.0, 0.6], [2.5, 0.8]];

/// Table with changed points.
fn table(header: &str, point: impl Fn([f64; 2]) -> [f64; 2]) -> String {
    let rows = POINTS.map(|own| point(own).map(|value| value.to_string()).join(","));
    format!("{header}\n{}\n", rows.join("\n"))
}

/// Table with the given rows, unchanged.
fn rows(header: &str, rows: &[&str]) -> String {
    format!("{header}\n{}\n", rows.join("\n"))
}

fn fit_of(name: &str, text: impl AsRef<[u8]>, line: &str) -> (crate::Answer, String) {
    let file = Written::new(name, text);
    let mut words = vec!["fit", &file, "--law", "yeoh"];
    words.extend(line.split_whitespace());
    (onset(&words), file.to_string())
}

/// Checks that a table is refused with its name, the line and the facts.
#[track_caller]
fn assert_refused(name: &str, text: impl AsRef<[u8]>, line: &str, facts: &[&str]) {
    let (answer, file) = fit_of(name, text, line);
    let told = unwrapped(&answer.stderr);
    assert_eq!(answer.code, Some(2), "{facts:?}: {told}{}", answer.stdout);
    assert_eq!(answer.stdout, "", "{facts:?}");
    assert!(told.starts_with("error: "), "{facts:?}: {told}");
    assert!(
        told.contains(&file),
        "{facts:?}: no name of the file in {told}"
    );
    assert!(!told.contains("panicked"), "{facts:?}: {told}");
    for fact in facts {
        assert!(told.contains(fact), "no `{fact}` in {told}");
    }
}

#[test]
fn strains_and_stretches_that_are_mixed_up_are_refused() {
    let name = "uniaxial.csv";
    let percent = |[stretch, stress]: [f64; 2]| [100.0 * (stretch - 1.0), stress];
    let strain = |[stretch, stress]: [f64; 2]| [stretch - 1.0, stress];
    for (text, facts) in [
        (
            table(HEADER, percent),
            ["line 3", "the largest accepted value is", "strain [%]"],
        ),
        (
            table("strain,nominal_stress", percent),
            ["line 3", "the largest accepted value is", "strain [%]"],
        ),
        (
            rows("strain,stress", &["0,0", "5,.1", "8,.15", "15,.25"]),
            ["line 3", "the strains begin with 5", "strain [%]"],
        ),
        (
            table(HEADER, strain),
            [
                "line 2",
                "different signs: 0.1 at the stretch 0.1",
                "name it strain",
            ],
        ),
        (
            rows(HEADER, &["0,0", "0.5,0.3", "1,0.5", "2,0.9"]),
            ["line 2", "the stretch is 0", "name it strain"],
        ),
        (
            table("strain,nominal_stress", |own| own),
            [
                "line 2",
                "the strains begin with 1.1",
                "if they are stretches, stretch",
            ],
        ),
        (
            rows("strain,stress", &["1,0", "1.1,.1", "1.3,.25", "2,.6"]),
            [
                "line 2",
                "the strains begin with 1,",
                "if they are stretches, stretch",
            ],
        ),
        (
            table("strain [mm],nominal_stress", strain),
            ["line 1", "has the unit mm", "strains have no unit, or %"],
        ),
        (
            table("stretch [%],nominal_stress", percent),
            ["line 1", "has the unit %", "stretches have no unit"],
        ),
        (
            rows("strain [%],stress", &["1e-5,1", "2e-5,2", "3e-5,3"]),
            [
                "line 2",
                "the largest strain of the table is 3e-7",
                "remove [%]",
            ],
        ),
        (
            rows(
                "stretch,strain,stress",
                &["1.1,0.1,.1", "1.3,0.6,.25", "2,1,.6"],
            ),
            ["line 3", "`stretch` and `strain` contradict", "keep one"],
        ),
    ] {
        assert_refused(name, text, "", &facts);
    }
    let text = rows("gamma,shear_stress", &["2,.1", "30,.2", "100,.5"]);
    assert_refused(
        "simple-shear.csv",
        text,
        "",
        &["line 3", "amount of shear is 30", "gamma [%]"],
    );
}

#[test]
fn points_that_contradict_an_elastic_law_are_refused() {
    let name = "uniaxial.csv";
    let back: Vec<String> = (0..5)
        .chain((0..4).rev())
        .map(|n| POINTS[n].map(|own| own.to_string()).join(","))
        .collect();
    let back: Vec<&str> = back.iter().map(String::as_str).collect();
    for (text, facts) in [
        (
            table(HEADER, |[a, b]| [a, -b]),
            ["line 2", "different signs: -0.1", "positive in tension"],
        ),
        (
            rows(HEADER, &["0.9,.1", "0.8,.2", "0.7,.4"]),
            ["line 2", "different signs", "positive in tension"],
        ),
        (
            rows(HEADER, &["1.02,-.01", "1.1,.1", "1.3,.25", "2,.6"]),
            ["line 2", "different signs", "offset"],
        ),
        (
            rows(HEADER, &["1,.2", "1.1,.3", "1.3,.45", "2,.8"]),
            ["line 2", "without strain", "offset"],
        ),
        (
            rows(HEADER, &["1.05,0", "1.1,.1", "1.3,.25", "2,.6"]),
            ["line 2", "the stress is 0", "remove the row"],
        ),
        (
            rows(HEADER, &back),
            [
                "line 7",
                "loading is followed by unloading",
                "keep one branch",
            ],
        ),
        (
            rows(HEADER, &["1.6,.4", "1.1,.1", "2.5,.8", "1.3,.25", "2,.6"]),
            ["line 4", "not sorted", "sort the rows"],
        ),
        (
            table(HEADER, |[a, b]| [a, 1e300 * b]),
            ["line 2", "the largest stress", "another unit"],
        ),
        (
            table(HEADER, |[a, b]| [a, 1e-300 * b]),
            ["line 2", "the largest stress", "another unit"],
        ),
        (
            rows(HEADER, &["1.1,.1", "1.3,.25", "25,9"]),
            [
                "line 4",
                "the stretch is 25",
                "the largest accepted value is",
            ],
        ),
        (
            rows(HEADER, &["-0.5,-1", "1.1,.1", "1.3,.25"]),
            ["line 2", "the stretch is -0.5", "positive"],
        ),
    ] {
        assert_refused(name, text, "", &facts);
    }
    let text = rows("volume_ratio,pressure", &[".99,-1", ".98,-2", ".97,-3"]);
    assert_refused(
        "volumetric.csv",
        text,
        "",
        &[
            "line 2",
            "-1 at the volume ratio 0.99",
            "positive in compression",
        ],
    );
}

#[test]
fn broken_cells_and_headers_are_refused() {
    let name = "uniaxial.csv";
    let broken = |row: &str| rows(HEADER, &["1.1,.1", "1.3,.25", row, "2,.6", "2.5,.8"]);
    for (text, facts) in [
        (
            broken("1.5,NaN"),
            [
                "line 4",
                "`NaN` of the column `nominal_stress`",
                "write numbers",
            ],
        ),
        (
            broken("1.5,inf"),
            ["line 4", "`inf` of the column", "not a finite number"],
        ),
        (
            broken("1.5,1e999"),
            ["line 4", "`1e999`", "not a finite number"],
        ),
        (
            broken("1.5,slipped"),
            ["line 4", "`slipped`", "not a finite number"],
        ),
        (
            broken("1.5,"),
            [
                "line 4",
                "a cell of the column `nominal_stress` is empty",
                "write numbers",
            ],
        ),
        (
            broken("1.5"),
            [
                "line 4",
                "the row has 1 cell where the header has 2",
                "every column",
            ],
        ),
        (
            broken("1.5,.3,7"),
            ["line 4", "the row has 3 cells", "every column"],
        ),
        (
            rows(HEADER, &["1,1,0,1", "1,3,0,25", "1,6,0,4"]),
            ["line 2", "4 cells", "decimal points"],
        ),
        (
            rows("stretch,stress,nominal_stress", &["1.1,.1,.1"]),
            ["line 1", "two columns mean `nominal_stress`", "keep one"],
        ),
        (
            rows("stretch,stress,stress", &["1.1,.1,.1"]),
            ["line 1", "two columns mean `stress`", "keep one"],
        ),
        (
            table("time,reading", |own| own),
            [
                "line 1",
                "the header has 2 columns",
                "expected stretch or strain",
            ],
        ),
        (
            table("1.05,0.05", |own| own),
            ["line 1", "numbers where the names", "add a header"],
        ),
        (
            String::new(),
            ["it has no rows", "expected a header", "rows of numbers"],
        ),
        (
            rows(HEADER, &[]),
            ["0 strains", "expected at least 3", "add points"],
        ),
        (
            rows(HEADER, &["1,0", "1.1,.1", "1.3,.25"]),
            [
                "2 strains",
                "expected at least 3",
                "other than the reference configuration",
            ],
        ),
        (
            rows(HEADER, &["1.5,.3"; 6]),
            ["1 strain ", "expected at least 3", "add points"],
        ),
        (
            table("stretch,stress [kg/cm2]", |own| own),
            ["line 1", "`kg/cm2` is not known", "expected Pa, kPa, MPa"],
        ),
        (
            table("stretch,force [N]", |own| own),
            ["line 1", "without the area", "undeformed area"],
        ),
        (
            rows(HEADER, &["1.1,.1", "1.2,.2", "1.3,300", "1.4,.4"]),
            [
                "line 4",
                "changes by the factor",
                "check the units of the rows",
            ],
        ),
        (
            table("stretch,force [MPa]", |own| own),
            ["line 1", "the unit of a stress", "nominal_stress"],
        ),
        (
            rows(
                "# mode: planar\nstretch,stress",
                &["1.1,.1", "1.3,.25", "2,.6"],
            ),
            [
                "comment gives the loading planar",
                "file name uniaxial",
                "--planar",
            ],
        ),
        (
            rows(
                "# mode: torsion\nstretch,stress",
                &["1.1,.1", "1.3,.25", "2,.6"],
            ),
            [
                "line 1",
                "`torsion`, which is not known",
                "expected uniaxial",
            ],
        ),
    ] {
        assert_refused(name, text, "", &facts);
    }
    let good = table(HEADER, |own| own);
    assert_refused(
        "probe.csv",
        &good,
        "",
        &["the loading is not known", "--uniaxial"],
    );
    assert_refused(
        "simple-shear.csv",
        &good,
        "",
        &["line 1", "amount of shear", "gamma"],
    );
    assert_refused(
        name,
        &good,
        "--range 5,6",
        &["0 strains in the range", "widen the range"],
    );
    assert_refused(
        name,
        [0xff, 0xfe, b's', 0, b't', 0],
        "",
        &["UTF-16", "save it as UTF-8"],
    );
    assert_refused(
        name,
        (1..=255).collect::<Vec<u8>>(),
        "",
        &["is not UTF-8 text"],
    );
    let missing = onset(&["fit", "--uniaxial", "no-such-table.csv"]);
    assert_eq!(missing.code, Some(2));
    assert!(
        missing.stderr.contains("no-such-table.csv: "),
        "{}",
        missing.stderr
    );
    let units = Written::new("planar.csv", table("stretch,stress [MPa]", |own| own));
    let plain = Written::new("uniaxial.csv", &good);
    let mixed = onset(&["fit", &units, &plain, "--law", "yeoh"]);
    assert_eq!(mixed.code, Some(2));
    assert!(
        mixed
            .stderr
            .contains("names a unit of stress, and the other does not")
    );
}

#[cfg(unix)]
#[test]
fn named_pipes_are_refused_as_tables() {
    let pipe = Scratch::new("uniaxial.csv");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    assert!(made.is_ok_and(|own| own.success()));
    let answer = onset(&["fit", pipe.to_str().expect("UTF-8")]);
    assert_eq!(answer.code, Some(2));
    assert!(answer.stderr.contains("it is a pipe"), "{}", answer.stderr);
}

#[test]
fn broken_decks_are_refused() {
    let deck = |rows: &[&str]| {
        format!(
            "*MATERIAL, NAME=R\n*HYPERELASTIC, TEST DATA INPUT, YEOH\n*UNIAXIAL TEST DATA\n{}\n",
            rows.join("\n")
        )
    };
    for (text, facts) in [
        (
            deck(&["0.1, 0.1", "0.3; 0.4", "0.6, 1."]),
            ["line 5", "`0.3;` where a stress", "nominal strain"],
        ),
        (
            deck(&["0.1, 0.1", "0.3, x", "0.6, 1."]),
            ["line 5", "`0.3,`", "nominal strain"],
        ),
        (
            deck(&["0.1, 0.1", "0.3", "0.6, 1."]),
            ["line 5", "`0.3`", "nominal strain"],
        ),
        (
            deck(&["0.1, 10.", "0.3, 30.", "0.6, 100."]),
            ["line 5", "the stretch is 31", "not percentages"],
        ),
        (
            deck(&["0., 1.", "0.1, 1.1", "0.6, 2."]),
            ["line 4", "the strains begin with 1,", "or stretches"],
        ),
        (
            deck(&[]),
            ["0 strains", "expected at least 3", "add points"],
        ),
        (
            "*MATERIAL, NAME=R\n*HYPERELASTIC, YEOH\n1, 2, 3\n".to_owned(),
            ["line 1", "`*MATERIAL,`", "contains no test data"],
        ),
    ] {
        assert_refused("rubber.inp", text, "", &facts);
    }
}

/// Test data of two materials as decks of Abaqus and of Ansys, the latter with files of strains and stresses.
#[test]
fn one_material_of_a_deck_is_chosen() {
    let strains = |factor: f64| table("", |[a, b]| [factor * (a - 1.0), b]);
    let abaqus = |name: &str, factor: f64| {
        let rows = table("*UNIAXIAL TEST DATA", |[a, b]| [b, factor * (a - 1.0)]);
        format!("*MATERIAL, NAME={name}\n*HYPERELASTIC, YEOH\n{rows}")
    };
    let deck = Written::new("two.inp", abaqus("Soft", 1.0) + &abaqus("Hard", 0.5));
    let folder = Scratch::new("ansys");
    std::fs::create_dir_all(&folder).expect("a folder");
    let write = |name: &str, text: String| std::fs::write(folder.join(name), text).expect("a file");
    write("soft.exp", strains(1.0).trim_start().replace(',', " "));
    write("hard.exp", strains(0.5).trim_start().to_owned());
    write(
        "deck.dat",
        "/PREP7\nTBFT,EADD,1,UNIA,soft.exp\ntbft,eadd,2,,hard,exp ! comment\n".to_owned(),
    );
    let ansys = folder.join("deck.dat");
    let ansys = ansys.to_str().expect("UTF-8");
    let (plain, _) = fit_of("uniaxial.csv", table(HEADER, |own| own), "--json");
    let first = |text: &str| {
        let answer: Value = serde_json::from_str(text).expect("JSON");
        number(&answer, "/laws/0/constants/0/value")
    };
    let expected = first(&plain.stdout);
    for (file, names) in [(&*deck, ["Soft", "Hard"]), (ansys, ["1", "2"])] {
        let both = onset(&["fit", file, "--law", "yeoh"]);
        assert_eq!(both.code, Some(2));
        for fact in ["tests of 2 materials", &names.join(", "), "--material"] {
            assert!(both.stderr.contains(fact), "{}", both.stderr);
        }
        let own = onset(&[
            "fit",
            file,
            "--law",
            "yeoh",
            "--material",
            names[0],
            "--json",
        ]);
        assert_eq!(own.code, Some(0), "{}", own.stderr);
        assert_close(first(&own.stdout), expected, 1e-9);
        let none = onset(&["fit", file, "--law", "yeoh", "--material", "x"]);
        assert!(
            none.stderr.contains("no tests of the material `x`"),
            "{}",
            none.stderr
        );
    }
    write("deck.dat", "TBFT,EADD,1,UNIA,none.exp\n".to_owned());
    let missing = onset(&["fit", ansys, "--law", "yeoh"]);
    assert_eq!(missing.code, Some(2));
    for fact in ["line 1", "none.exp cannot be read", "folder of the deck"] {
        assert!(missing.stderr.contains(fact), "{}", missing.stderr);
    }
}

#[test]
fn uninformative_fits_are_refused_or_get_a_note() {
    let pull = Written::new("uniaxial.csv", table(HEADER, |own| own));
    let twice = onset(&["fit", &pull, &pull, "--law", "yeoh"]);
    assert_eq!(twice.code, Some(2));
    assert!(
        twice
            .stderr
            .contains("the same points as the uniaxial test"),
        "{}",
        twice.stderr
    );
    let squeeze = rows("volume_ratio,pressure", &["0.99,20", "0.98,41", "0.97,64"]);
    let squeeze = Written::new("volumetric.csv", squeeze);
    let alone = onset(&["fit", &squeeze, "--law", "yeoh"]);
    assert_eq!(alone.code, Some(2));
    assert!(
        alone.stderr.contains("volumetric tests alone"),
        "{}",
        alone.stderr
    );
    let shear = rows(
        "gamma,shear_stress",
        &[".2,.2", ".5,.5", ".9,.8", "1.2,1.1"],
    );
    let shear = Written::new("simple-shear.csv", shear);
    let shear = onset(&["fit", &shear, "--law", "mooney-rivlin"]);
    assert!(
        shear.stderr.contains("both invariants are equal"),
        "{}",
        shear.stderr
    );
    let (exact, _) = fit_of(
        "uniaxial.csv",
        rows(HEADER, &["1.2,.2", "1.5,.4", "2,.7"]),
        "",
    );
    assert!(
        unwrapped(&exact.stdout).contains("the number of points equals the number of constants"),
        "{}",
        exact.stdout
    );
    let locked = unwrapped(&fitted(&ALL, "--law gent --bound jm=1,60", 0));
    for fact in [
        "gent: jm is at its bound",
        "its chains are fully extended from stretch 5.61",
    ] {
        assert!(locked.contains(fact), "no `{fact}` in {locked}");
    }
}

#[test]
fn equivalent_tables_give_the_same_constants() {
    let constant = |name: &str, text: String, line: &str| {
        let (answer, _) = fit_of(name, text, &format!("{line} --json"));
        assert_eq!(answer.code, Some(0), "{}", answer.stderr);
        let answer: Value = serde_json::from_str(&answer.stdout).expect("JSON");
        number(&answer, "/laws/0/constants/0/value")
    };
    let expected = constant("uniaxial.csv", table(HEADER, |own| own), "");
    let strains = |factor: f64| move |[a, b]: [f64; 2]| [factor * (a - 1.0), b];
    for (name, text, line) in [
        ("tension.csv", table("strain,stress", strains(1.0)), ""),
        (
            "tension.csv",
            table("strain [%],stress", strains(100.0)),
            "",
        ),
        (
            "tension.csv",
            table("true strain;stress", |[a, b]| [a.ln(), b]).replace(',', ";"),
            "",
        ),
        (
            "tension.csv",
            table("stretch,true_stress", |[a, b]| [a, a * b]),
            "",
        ),
        (
            "tension.csv",
            table("stretch,force [N]", |[a, b]| [a, 20.0 * b]),
            "--area 20",
        ),
        (
            "tension.csv",
            table("stretch,force [kN]", |[a, b]| [a, 0.02 * b]),
            "--area 20 --unit MPa",
        ),
        (
            "probe.csv",
            format!("# mode: uniaxial\n{}", table(HEADER, |own| own)),
            "",
        ),
        (
            "tension.csv",
            table(HEADER, |own| own).replace('\n', "\r\n"),
            "",
        ),
        (
            "tension.csv",
            table(HEADER, |own| own).replace('\n', "\r"),
            "",
        ),
        (
            "tension.csv",
            format!("\u{feff}{}", table(HEADER, |own| own)),
            "",
        ),
        (
            "tension.csv",
            table(HEADER, |own| own).replace(',', ";").replace('.', ","),
            "",
        ),
        (
            "rubber.inp",
            table("*UNIAXIAL TEST DATA", |[a, b]| [b, a - 1.0]),
            "",
        ),
    ] {
        assert_close(constant(name, text, line), expected, 1e-9);
    }
}

#[test]
fn tests_listed_in_toml_give_the_constants_of_their_tables() {
    let pull = Written::new(
        "uniaxial.csv",
        table("stretch,nominal_stress [MPa]", |own| own),
    );
    let planar = rows(
        "strain [%],nominal_stress [kPa]",
        &["10,130", "30,310", "60,480"],
    );
    let planar = Written::new("planar.csv", planar);
    let list = format!(
        "[[tests]]\nfile = \"{pull}\"\n\n[[tests]]\nmode = \"pure shear\"\n\"strain [%]\" = [10, 30, 60]\n\"nominal_stress [kPa]\" = [130, 310, 480.0]\n"
    );
    let list = Written::new("tests.toml", list);
    let constants = |files: &[&str]| -> Vec<f64> {
        let words = [&["fit", "--law", "yeoh", "--json"], files].concat();
        let answer = onset(&words);
        assert_eq!(answer.code, Some(0), "{}", answer.stderr);
        let answer: Value = serde_json::from_str(&answer.stdout).expect("JSON");
        let value = |n| number(&answer, &format!("/laws/0/constants/{n}/value"));
        (0..3).map(value).collect()
    };
    let listed = constants(&[&list]);
    for (own, expected) in listed.iter().zip(constants(&[&pull, &planar])) {
        assert_close(*own, expected, 1e-12);
    }
    for (list, facts) in [
        ("", ["line 1", "missing field `tests`"]),
        ("tests = []", ["line 1", "the list has no tests"]),
        (
            "\n[[tests]]\nfile = \"absent.csv\"",
            ["line 2: test 1: cannot read", "absent.csv"],
        ),
        ("[material]\nmu = 1", ["line 1", "unknown field `material`"]),
        (
            "\n[[tests]]\nstretch = [1.1]",
            ["line 2", "neither a file nor a loading"],
        ),
        (
            "[[tests]]\nmode = \"torsion\"",
            ["line 1", "the loading `torsion` is not known"],
        ),
        (
            "[[tests]]\nfile = \"a.csv\"\nstretch = [1]",
            ["line 1", "exclude each other"],
        ),
        (
            "[[tests]]\nmode = \"planar\"\nstretch = 1",
            ["line 1", "`stretch` is not a list of numbers"],
        ),
        (
            "[[tests]]\nmode = \"planar\"\nstress = [1, 2]\nstretch = [1.1]",
            [
                "line 1",
                "`stretch` has 1 numbers, and the column before it 2",
            ],
        ),
        (
            "[[tests]]\nmode = \"planar\"\nstress = [0.1, 0.2, 0.3]\nstrain = [10, 20, 30]",
            ["test 1, point 1", "strain [%]"],
        ),
        (
            "[[tests]]\nmode = \"planar\"\nwidth = [1]",
            [
                "test 1: the header has 1 column",
                "expected stretch or strain",
            ],
        ),
    ] {
        assert_refused("tests.toml", list, "", &facts);
    }
}

#[test]
fn names_of_columns_that_leave_the_stress_open_get_a_note() {
    for (header, fact) in [
        ("stretch,stress", Some("`stress` is read as nominal stress")),
        (
            "stretch,sigma [MPa]",
            Some("`sigma` is read as true stress"),
        ),
        (
            "strain,true_stress",
            Some("`strain` is read as nominal strain"),
        ),
        ("stretch,nominal_stress", None),
        ("stretch,true_stress", None),
    ] {
        let strain = f64::from(u8::from(header.starts_with("strain")));
        let text = table(header, |[a, b]| [a - strain, b]);
        let (answer, _) = fit_of("uniaxial.csv", text, "--all");
        assert_eq!(answer.code, Some(0), "{}", answer.stderr);
        let told = unwrapped(&answer.stdout);
        match fact {
            Some(fact) => assert!(told.contains(fact), "no `{fact}` in {told}"),
            None => assert!(!told.contains("is read as"), "{told}"),
        }
    }
}

#[test]
fn a_volumetric_test_gives_the_bulk_modulus_with_an_error() {
    let pull = Written::new("uniaxial.csv", table(HEADER, |own| own));
    let squeeze = rows("volume_ratio,pressure", &["0.99,20", "0.98,41", "0.97,64"]);
    let squeeze = Written::new("volumetric.csv", squeeze);
    let answer = onset(&["fit", &pull, &squeeze, "--law", "yeoh", "--json"]);
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    let answer: Value = serde_json::from_str(&answer.stdout).expect("JSON");
    let pressures = numbers(&answer, "/laws/0/tests/1/stresses");
    let kappa = number(&answer, "/laws/0/kappa");
    // The tolerance covers the differences between usual volumetric energies at small changes of volume.
    assert_close(pressures[0], 0.01 * kappa, 0.03);
    assert_close(pressures[2], 64.0, 0.03);
    assert!(number(&answer, "/laws/0/tests/1/relative") > 1e-4);
}

/// Nominal stress of neo-Hooke's law with the modulus 0.4 at a strain in percent.
fn stress_at(percent: f64) -> f64 {
    let stretch = 1.0 + 0.01 * percent;
    0.4 * (stretch - stretch.powi(-2))
}

#[test]
fn percentages_given_as_strains_are_refused() {
    let table = |strains: &[f64], factor: f64, header: &str| {
        let row = |strain: &f64| format!("{},{}", strain * factor, stress_at(*strain));
        let rows: Vec<String> = strains.iter().map(row).collect();
        format!("{header}\n{}\n", rows.join("\n"))
    };
    let strain = "strain,nominal_stress";
    for strains in [
        &[0.5, 1.0, 2.0, 3.0, 5.0, 7.0, 10.0, 12.0, 15.0][..],
        &[0.1, 0.2, 0.3, 0.5, 0.8, 1.0, 1.2, 1.5][..],
    ] {
        let last = format!("line {}", strains.len() + 1);
        let facts = [
            last.as_str(),
            "neo-Hooke's law fits them",
            "name the column strain [%]",
        ];
        assert_refused("uniaxial.csv", table(strains, 1.0, strain), "", &facts);
        // The same strains as fractions, or with their unit, are accepted.
        for text in [
            table(strains, 0.01, strain),
            table(strains, 1.0, "strain [%],nominal_stress"),
        ] {
            let (answer, _) = fit_of("uniaxial.csv", text, "");
            assert_eq!(answer.code, Some(0), "{}", answer.stderr);
        }
    }
    let fractions = table(
        &[
            2.0, 10.0, 20.0, 30.0, 50.0, 80.0, 100.0, 140.0, 180.0, 200.0,
        ],
        0.01,
        "strain [%],nominal_stress",
    );
    let facts = ["line 11", "the strain is 2 %", "remove [%]"];
    assert_refused("uniaxial.csv", fractions, "", &facts);
    let shear = rows("gamma,shear_stress", &["0.5,.2", "2,.8", "7,2.8"]);
    let facts = ["line 4", "amount of shear is 7", "gamma [%]"];
    assert_refused("simple-shear.csv", shear, "", &facts);
}

#[test]
fn tables_that_contradict_their_options_are_refused() {
    let text = format!("# mode: planar\n{}", table(HEADER, |own| own));
    let file = Written::new("test.csv", text);
    let answer = onset(&["fit", "--uniaxial", &file, "--law", "yeoh"]);
    assert_eq!(answer.code, Some(2), "{}", answer.stdout);
    assert!(
        unwrapped(&answer.stderr)
            .contains("the comment gives the loading planar, the option uniaxial")
    );
    let volume = rows("volume_ratio,pressure", &["0.01,5", "0.02,10", "0.03,15"]);
    let facts = ["line 2", "the volume ratio is 0.01", "replace them by J"];
    assert_refused("volumetric.csv", volume, "", &facts);
    let file = Written::new("uniaxial.csv", table(HEADER, |own| own));
    let answer = onset(&[
        "fit", &file, "--law", "yeoh", "--fix", "c10=1", "--fix", "c10=2",
    ]);
    assert_eq!(answer.code, Some(2), "{}", answer.stdout);
    assert!(
        answer
            .stderr
            .contains("--fix gives c10 two values: 1 and 2"),
        "{}",
        answer.stderr
    );
    let answer = onset(&["fit", &file, "--area", "-25"]);
    assert!(answer.stderr.contains("--area"), "{}", answer.stderr);
    assert!(
        !answer.stderr.contains("unexpected argument"),
        "{}",
        answer.stderr
    );
}

#[test]
fn quoted_numbers_and_kilogram_forces_are_read() {
    let quoted = |[stretch, stress]: [f64; 2]| format!("\"{stretch}\",\"{stress}\"");
    let text = POINTS.map(quoted).join("\n");
    let (answer, _) = fit_of(
        "uniaxial.csv",
        format!("\"stretch\",\"stress [kgf/cm^2]\"\n{text}\n"),
        "",
    );
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    assert!(answer.stdout.contains("kgf/cm^2"), "{}", answer.stdout);
}

#[test]
fn suspicious_points_are_noted() {
    let stretches = [1.02, 1.1, 1.2, 1.3, 1.5, 1.8, 2.0, 2.4, 2.8, 3.0];
    let noted = |change: &dyn Fn(usize, f64) -> f64| {
        let row = |(n, stretch): (usize, &f64)| {
            format!(
                "{stretch},{}",
                change(n, stress_at(100.0 * (stretch - 1.0)))
            )
        };
        let text: Vec<String> = stretches.iter().enumerate().map(row).collect();
        let text = format!("{HEADER}\n{}\n", text.join("\n"));
        let file = Written::new("uniaxial.csv", text);
        let answer = onset(&["fit", &file, "--law", "neo-hooke", "--all"]);
        assert_eq!(answer.code, Some(0), "{}", answer.stderr);
        unwrapped(&answer.stdout)
    };
    assert!(noted(&|_, stress| stress + 0.3).contains("check the zero point"));
    assert!(
        noted(&|n, stress| if n == 6 { 10.0 * stress } else { stress })
            .contains("the point at 2 with")
    );
    let plain = noted(&|_, stress| stress);
    for word in ["zero point", "the point at", "decreases"] {
        assert!(!plain.contains(word), "{word}: {plain}");
    }
}

#[test]
fn the_full_answer_has_deviations_and_correlations_of_all_laws() {
    let text = fitted(&ALL, "--law ogden-2,yeoh --stable none --all", 0);
    // One exponent of `ogden-2` is at its bound.
    assert_eq!(text.matches(" ± ").count(), 3 + 3, "{text}");
    assert!(text.contains("correlated: "), "{text}");
    assert_eq!(text.matches("by test: ").count(), 2, "{text}");
    let short = fitted(&ALL, "--law ogden-2,yeoh --stable none", 0);
    assert!(
        short.contains("constants   ") && short.contains(" ± "),
        "{short}"
    );
    let fixed = fitted(&ALL, "--law ogden-1 --fix alpha1=2 --stable none", 0);
    assert!(fixed.contains("alpha1 2 (fixed)"), "{fixed}");
    let bounded = fitted(&ALL, "--law ogden-1 --bound alpha1=1,1.5 --stable none", 0);
    assert!(bounded.contains("(at its bound)"), "{bounded}");
}

/// Strongly correlated moduli nearly cancel, so that few digits give other stresses.
#[test]
fn the_printed_constants_give_the_printed_error() {
    let points = "1.02,0.0235325 1.1,0.109421 1.2,0.202222 1.3,0.283314 1.5,0.422222 1.8,0.5 2,0.5 2.4,0.5 2.8,0.5 3,0.5";
    let lines: Vec<&str> = points.split(' ').collect();
    let file = Written::new("uniaxial.csv", rows(HEADER, &lines));
    let text = onset(&["fit", &file, "--law", "ogden-2", "--stable", "none"]).stdout;
    let text = unwrapped(&text);
    let value = |name: &str| -> f64 {
        let (_, rest) = text.split_once(&format!("{name} ")).expect("the constant");
        rest.split([' ', ','])
            .next()
            .and_then(|own| own.parse().ok())
            .expect("a number")
    };
    let terms = [1, 2].map(|n| [value(&format!("mu{n}")), value(&format!("alpha{n}"))]);
    let squares = lines.iter().map(|line| {
        let (stretch, stress) = line.split_once(',').expect("two numbers");
        let [stretch, stress] = [stretch, stress].map(|own| own.parse::<f64>().expect("a number"));
        let fitted: f64 = terms
            .iter()
            .map(|[mu, alpha]| mu * (stretch.powf(alpha - 1.0) - stretch.powf(-0.5 * alpha - 1.0)))
            .sum();
        (fitted / stress - 1.0).powi(2)
    });
    let error = 100.0 * (squares.sum::<f64>() / lines.len() as f64).sqrt();
    let (_, told) = text.split_once("fits the test within ").expect("the error");
    let told: f64 = told
        .split(' ')
        .next()
        .and_then(|own| own.parse().ok())
        .expect("a number");
    assert!((error / told - 1.0).abs() < 0.01, "{error} {told}");
}
