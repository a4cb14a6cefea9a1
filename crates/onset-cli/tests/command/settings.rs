//! Every setting is read or refused, and reported; one study file serves every command.

use crate::{Scratch, Written, command, document, onset, onset_line};
use serde_json::Value;
use std::io::Write;
use std::process::Stdio;

const AXES: &str = "[[axes]]\nquantity = \"stretch-1\"\nrange = [0.9, 1.1]\nstates = 4\n\
                    [[axes]]\nquantity = \"discretization.density\"\nrange = [1.0, 2.0]\nstates = 4\n";
const CHAIN: &str = "title = \"a chain\"\n[material]\nmodel = \"blatz-ko\"\nmu = 2\n\
                     [discretization]\nlattice = \"chain\"\nmethod = \"total-lagrangian-sph\"\nsupport = 2.2\n\
                     [compare]\nstates = 2\n";

/// File with a text.
fn file(text: &str) -> Written {
    Written::new("study.toml", text)
}

#[test]
fn a_key_that_the_method_does_not_read_is_refused_by_every_command() {
    let study = file(&format!("[discretization]\nsupport = 2.1\n{AXES}"));
    let unread = "set penalty=0.5";
    for line in [
        format!("state --stretch 1.2,0.9 {unread}"),
        format!("dispersion --stretch 1.2,0.9 --wave-vector 1,1 {unread}"),
        format!("dispersion --stretch 1.2,0.9 --path {unread}"),
        format!("path --from 1,1 --to 1.2,1 {unread}"),
        format!("modes {unread}"),
        format!("tune discretization.support {unread}"),
        format!("limit --vary discretization.support --time-step 0.1 {unread}"),
        format!("check {study} {unread}"),
        format!("map {study} --out {study}.zarr {unread}"),
        format!("boundary {study} --out {study}.out {unread}"),
        format!("state {study} --stretch 1.2,0.9 set density=1 {unread}"),
    ] {
        let answer = onset_line(&line);
        assert_eq!(answer.code, Some(2), "{line}: {}", answer.stderr);
        for fact in [
            "`discretization.penalty` has no effect: discretization.method is kernel",
            "discretization.method = total-lagrangian-sph",
        ] {
            assert!(answer.stderr.contains(fact), "{line}: {}", answer.stderr);
        }
        assert_eq!(answer.stdout, "", "{line}");
    }
    // Commands about the law alone read no key of a method.
    for line in ["criteria", "card", "audit"] {
        let answer = onset_line(&format!("{line} set support=2"));
        assert_eq!(answer.code, Some(2), "{line}: {}", answer.stderr);
        assert!(
            answer.stderr.contains("this command uses only the law"),
            "{}",
            answer.stderr
        );
    }
}

#[test]
fn a_key_without_effect_in_a_file_is_reported_with_its_position() {
    for (text, facts) in [
        (
            "[discretization]\nmethod = \"updated-sph\"\nquadrature = \"nodal\"\n",
            vec![
                ":3:14: `discretization.quadrature` has no effect",
                "updated-sph",
            ],
        ),
        (
            "[discretization]\nmethod = \"finite-elements\"\nlattice = \"face-centered-cubic\"\n",
            vec![
                ":3:11: `discretization.lattice` has no effect",
                "finite-elements",
            ],
        ),
        (
            "[discretization]\nmethod = \"material-points\"\nlattice = \"hexagonal\"\n",
            vec![":3:11: material points have a square grid"],
        ),
        (
            "[discretization]\ncells = 2\nframe = \"eulerian\"\ncurrent-lattice = \"regular\"\n",
            vec![
                ":4:19: `discretization.current-lattice` has no effect: discretization.cells is 2",
            ],
        ),
    ] {
        let study = file(&format!("{text}{AXES}"));
        for line in [
            format!("check {study}"),
            format!("map {study} --out {study}.zarr"),
            format!("state {study} --stretch 1.1,1 set density=1"),
            format!("modes {study} set density=1"),
        ] {
            let answer = onset_line(&line);
            assert_eq!(answer.code, Some(2), "{line}: {}", answer.stdout);
            for fact in &facts {
                assert!(answer.stderr.contains(fact), "{line}: {}", answer.stderr);
            }
        }
    }
}

#[test]
fn exactly_the_choices_in_effect_are_listed() {
    for (settings, told, not_told) in [
        (
            "set method=updated-sph set artificial-stress=0.3",
            vec![
                "artificial-stress",
                "artificial-stress-exponent",
                "kernel",
                "support",
                "momentum",
            ],
            vec![
                "quadrature",
                "approximation",
                "frame",
                "horizon",
                "penalty-form",
            ],
        ),
        (
            "set method=peridynamics set bonds=correspondence set control=penalty set control-coefficient=0.5",
            vec![
                "horizon",
                "influence",
                "control",
                "control-coefficient",
                "bonds",
            ],
            vec!["quadrature", "kernel", "support", "calibration"],
        ),
        (
            "set method=material-points set unknowns=updated",
            vec!["grid-functions", "points-per-side", "grid-mass", "lattice"],
            vec!["quadrature", "kernel", "support"],
        ),
        (
            "set method=finite-elements",
            vec!["mesh", "integration", "mass"],
            vec!["lattice", "kernel", "hourglass-stiffness"],
        ),
    ] {
        let line = format!("state --stretch 1.02,0.99 {settings}");
        let text = onset_line(&line).stdout;
        let lines = text
            .lines()
            .skip_while(|line| !line.starts_with("discretization"));
        let block: String = lines.take(2).collect::<Vec<_>>().join(" ");
        let state = document(&line);
        let settings = state["settings"].as_object().expect("settings");
        for name in told {
            assert!(
                block.contains(&format!(" {name} ")),
                "{line}: no {name} in {block}"
            );
            let choice = &settings[&format!("discretization.{name}")];
            assert!(
                choice["default"].is_boolean() && !choice["value"].is_null(),
                "{name}"
            );
        }
        for name in not_told {
            assert!(
                !block.contains(&format!(" {name} ")),
                "{line}: {name} in {block}"
            );
            assert!(
                !settings.contains_key(&format!("discretization.{name}")),
                "{name}"
            );
        }
    }
    let points = onset_line("state --stretch 1.02,0.99 set method=material-points").stdout;
    assert!(points.contains("lattice square"), "{points}");
    let waves = document("dispersion --stretch 1.1,1 --wave-vector 1,1 set support=1.8");
    assert_eq!(
        waves["settings"]["discretization.support"]["default"],
        false
    );
    assert_eq!(waves["settings"]["discretization.kernel"]["default"], true);
}

#[test]
fn one_study_file_serves_every_command() {
    let study = file(&format!("{CHAIN}{AXES}"));
    let place = Scratch::new("answers");
    let out = place.display().to_string();
    for line in [
        format!("state {study} --stretch 1.1 set density=1"),
        format!("path {study} --from 1 --to 1.2 set density=1"),
        format!("dispersion {study} --stretch 1.1 --wave-vector 1 set density=1"),
        format!("dispersion {study} --stretch 1.1 --path --out {out} set density=1"),
        format!("modes {study} set density=1"),
        format!("tune discretization.penalty {study} --quiet set density=1"),
        format!("audit {study}"),
        format!("criteria {study} --mode uniaxial"),
        format!("card {study} --out {out}"),
        format!("compare {study} --quiet --out {out} set density=1"),
        format!("check {study}"),
    ] {
        let answer = onset_line(&line);
        assert_eq!(answer.code, Some(0), "{line}: {}", answer.stderr);
    }
    let state = document(&format!("state {study} --stretch 1.1 set density=1"));
    assert_eq!(state["material"]["model"], "blatz-ko");
    assert_eq!(state["settings"]["material.mu"]["value"], 2.0);
    let of_method = |name: &str| state["settings"][format!("discretization.{name}")].clone();
    assert_eq!(of_method("method")["value"], "total-lagrangian-sph");
    assert_eq!(of_method("support")["value"], 2.2);
    // --set takes precedence over the file.
    let other = document(&format!(
        "state {study} --stretch 1.1 set density=1 set support=1.7"
    ));
    assert_eq!(other["settings"]["discretization.support"]["value"], 1.7);
    // A key varied by an axis needs a value.
    let open = onset_line(&format!("state {study} --stretch 1.1"));
    assert_eq!(open.code, Some(2));
    assert!(
        open.stderr.contains("--set discretization.density=1"),
        "{}",
        open.stderr
    );
    // The method of the study is compared with the built-in ones, with its material and particles.
    let csv = std::fs::read_to_string(format!("{out}/compare.csv")).expect("a table");
    assert!(csv.contains("\nthe study's own method,"), "{csv}");
    assert!(csv.lines().count() > 10);
}

#[test]
fn a_study_is_read_from_standard_input() {
    let mut child = command(&["state", "-", "--stretch", "1.1", "--json"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the command starts");
    let mut input = child.stdin.take().expect("standard input");
    input.write_all(CHAIN.as_bytes()).expect("written");
    drop(input);
    let output = child.wait_with_output().expect("an answer");
    let state: Value = serde_json::from_slice(&output.stdout).expect("one JSON document");
    assert_eq!(state["settings"]["discretization.support"]["value"], 2.2);
    let mut child = command(&["check", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the command starts");
    let mut input = child.stdin.take().expect("standard input");
    input.write_all(b"[map]\ntile = 1\n").expect("written");
    drop(input);
    let output = child.wait_with_output().expect("an answer");
    let told = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(2));
    assert!(told.contains("standard input:2:8: `map.tile`"), "{told}");
}

/// Numbers of a text.
fn numbers(text: &str) -> Vec<&str> {
    text.split(|c: char| c.is_whitespace() || "(),;[]=".contains(c))
        .filter(|word| word.parse::<f64>().is_ok())
        .collect()
}

#[test]
fn numbers_have_six_significant_digits_in_any_system_of_units() {
    let steel = "--set material.model=neo-hooke --set material.mu=80e9 --set material.lambda=120e9 set density=7850";
    for spacing in ["1", "1e-3", "1e-5", "1e-9"] {
        let law = format!("{steel} set spacing={spacing}");
        for line in [
            format!("state --stretch 1.02,0.99 {law}"),
            format!("state --stretch 1.02,0.99 --certify {law}"),
            format!("state --stretch 1,1 {law}"),
            format!("dispersion --stretch 1.02,0.99 --wave-vector 2,1.1 {law}"),
            format!("path --from 1,1 --to 0.9,1 {law}"),
        ] {
            let answer = onset_line(&line);
            assert_eq!(answer.code, Some(0), "{line}: {}", answer.stderr);
            for number in numbers(&answer.stdout) {
                let mantissa = number.split(['e', 'E']).next().expect("a mantissa");
                let digits = mantissa
                    .trim_start_matches(['-', '+', '0', '.'])
                    .replace('.', "");
                let digits = digits.trim_end_matches('0');
                assert!(digits.len() <= 6, "{line}: {number}");
                // No number is truncated to zero, and no number is rounding noise.
                assert!(
                    !mantissa.starts_with("0.0000") && !mantissa.starts_with("-0.0000"),
                    "{line}: {number}"
                );
            }
        }
    }
    let text = onset_line(&format!(
        "state --stretch 1.02,0.99 {steel} set spacing=1e-3"
    ))
    .stdout;
    let state = document(&format!(
        "state --stretch 1.02,0.99 {steel} set spacing=1e-3"
    ));
    let step = crate::number(&state, "/discretization/critical_time_step");
    let (_, told) = text.split_once("time step below ").expect("a time step");
    let told: f64 = told
        .split_whitespace()
        .next()
        .and_then(|word| word.parse().ok())
        .expect("a number");
    crate::assert_close(told, step, 1e-5);
    // In the reference configuration the stress is zero in any unit.
    let rest = onset_line(&format!("state --stretch 1,1 {steel}")).stdout;
    assert!(rest.contains("s11 0, s22 0, s12 0, s33 0"), "{rest}");
    assert!(rest.contains("growth rate           0\n"), "{rest}");
}

#[test]
fn a_stressed_reference_configuration_is_reported_in_every_answer() {
    let law = ["--energy", "mu/2*(I1-3)", "--set", "material.mu=2"];
    let told = |arguments: &[&str]| {
        let answer = onset(&[arguments, &law].concat());
        format!("{}{}", answer.stdout, answer.stderr)
    };
    let place = Scratch::new("stressed");
    let out = place.display().to_string();
    for arguments in [
        vec!["state", "--stretch", "1,1", "--all"],
        vec!["dispersion", "--stretch", "1,1", "--wave-vector", "1,1"],
        vec!["path", "--from", "1,1", "--to", "1.1,1", "--all"],
        vec!["modes", "--all"],
        vec![
            "tune",
            "discretization.stress-point-weight",
            "--set",
            "discretization.lattice=chain",
            "--range",
            "0.4,0.6",
            "--all",
        ],
        vec!["criteria", "--mode", "simple-shear", "--all"],
        vec!["card", "--out", &out],
    ] {
        let text = told(&arguments);
        assert!(
            text.contains("stress at F = 1 (s11 = 2, s22 = 2, s33 = 2)")
                && text.contains("The term - 2 ln J in the energy would remove it")
                && !text.contains("not finite"),
            "{arguments:?}: {text}"
        );
    }
    let answer = onset(&["state", "--stretch", "1,1"]);
    assert!(!answer.stdout.contains("note:"), "{}", answer.stdout);
}

#[test]
fn bond_based_methods_note_that_only_a_modulus_of_the_law_is_used() {
    for line in [
        "state --stretch 1.01",
        "dispersion --stretch 1 --wave-vector 1",
        "path --from 1 --to 1.05",
        "modes",
    ] {
        let bonds = onset_line(&format!("{line} set lattice=chain set method=peridynamics"));
        assert!(
            bonds.stdout.contains("bulk modulus of the law at F = 1"),
            "{line}: {}",
            bonds.stdout
        );
        let families = onset_line(&format!(
            "{line} set lattice=chain set method=peridynamics set bonds=correspondence"
        ));
        assert!(
            !families.stdout.contains("bulk modulus of the law at F = 1"),
            "{line}: {}",
            families.stdout
        );
    }
}

#[test]
fn the_verdict_names_the_method_in_use() {
    for (settings, culprit) in [
        ("set frame=eulerian", "of the kernel"),
        ("set method=updated-sph", "of the kernel"),
        (
            "set method=material-points set unknowns=particles",
            "of the material points",
        ),
    ] {
        let answer = onset_line(&format!("state --stretch 1.3,1.1 {settings}"));
        let sentence = answer.stdout.lines().next().unwrap_or_default();
        if answer.stdout.contains("verdict                 numerical") {
            assert!(sentence.contains(culprit), "{sentence}");
        } else {
            assert!(!sentence.contains("kernel"), "{sentence}");
        }
    }
}

#[test]
fn the_next_command_printed_after_a_verdict_runs() {
    for line in [
        "state --stretch 1.2,1 set frame=eulerian --set material.model=blatz-ko --set material.mu=3",
        "state --stretch 1.01,1 set quadrature=nodal",
        "state --stretch 1.2,1.1 set method=updated-sph set support=1.8",
    ] {
        let state = document(line);
        let next = state["next"].as_array().expect("commands");
        assert!(!next.is_empty(), "{line}");
        let text = onset_line(line).stdout;
        for command in next {
            let command = command.as_str().expect("a command");
            assert!(text.contains(command), "{text}");
            if let Some(command) = command.strip_prefix("onset modes") {
                let answer = onset_line(&format!("modes{command}"));
                assert_eq!(answer.code, Some(0), "{command}: {}", answer.stderr);
            }
        }
        // The settings in use: the same discretization.
        let modes = next
            .iter()
            .filter_map(Value::as_str)
            .find(|next| next.contains(" modes"));
        let modes = modes.expect("modes").trim_start_matches("onset ");
        assert_eq!(document(modes)["settings"], state["settings"], "{line}");
    }
    assert_eq!(
        document("state --stretch 1.01,1")["next"],
        Value::Array(Vec::new())
    );
}

#[test]
fn keys_and_laws_of_other_commands_get_a_hint_to_the_command() {
    let horizon = onset_line(
        "state --stretch 1,1,1 --set discretization.method=peridynamics --set discretization.lattice=simple-cubic --set discretization.support=4",
    );
    assert_eq!(horizon.code, Some(2));
    assert!(
        horizon
            .stderr
            .contains("did you mean `discretization.horizon`?"),
        "{}",
        horizon.stderr
    );
}

#[test]
fn defaults_in_lists_are_whole_numbers_without_a_point() {
    let told = onset_line("list method material-points").stdout;
    assert!(
        told.contains("discretization.spacing [default: 1]"),
        "{told}"
    );
    assert!(!told.contains(".0]"), "{told}");
}
