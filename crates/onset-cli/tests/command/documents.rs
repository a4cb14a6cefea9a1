//! Output of `--json`: one document with documented keys, and numbers with the digits that read back exactly.

use crate::{document, number, numbers, onset_line};
use serde_json::Value;

const STATE: &str = "state --stretch 1.2,0.9 set frame=eulerian";
const WAVES: &str = "dispersion --stretch 1.2,0.9 --wave-vector 2.0,1.1";
const PATH: &str = "path --from 1,1 --to 12,12";

#[test]
fn a_state_has_its_documented_keys() {
    let state = document(STATE);
    assert_eq!(state["verdict"], "numerical");
    assert!(state["sentence"].as_str().is_some_and(|s| s.ends_with('.')));
    let material = &state["material"];
    for tensor in ["cauchy", "first_piola"] {
        for row in 0..3 {
            assert_eq!(numbers(material, &format!("/{tensor}/{row}")).len(), 3);
        }
    }
    for i in 0..3 {
        for j in 0..3 {
            for k in 0..3 {
                assert_eq!(numbers(material, &format!("/tangent/{i}/{j}/{k}")).len(), 3);
            }
        }
    }
    assert_eq!(material["elliptic"], true);
    assert!(number(material, "/minimum_acoustic_eigenvalue") > 0.0);
    assert_eq!(numbers(material, "/direction").len(), 2);
    assert_eq!(numbers(material, "/polarization").len(), 2);

    let discretization = &state["discretization"];
    assert!(number(discretization, "/minimum_omega_squared/re") < 0.0);
    number(discretization, "/minimum_omega_squared/im");
    assert!(number(discretization, "/minimum_scaled") < 0.0);
    assert_eq!(numbers(discretization, "/wave_vector").len(), 2);
    assert_eq!(numbers(discretization, "/polarization").len(), 2);
    assert!(number(discretization, "/growth_rate") > 0.0);
    let (omega, step) = (
        number(discretization, "/maximum_omega"),
        number(discretization, "/critical_time_step"),
    );
    crate::assert_close(omega * step, 2.0, 1e-14);
    let settings = &state["settings"];
    for (name, value, default) in [
        ("frame", "eulerian", false),
        ("support-size", "fixed", true),
    ] {
        let choice = &settings[format!("discretization.{name}")];
        assert_eq!(
            (&choice["value"], &choice["default"]),
            (&value.into(), &default.into())
        );
    }
}

#[test]
fn cauchy_and_first_piola_stress_of_a_state_are_consistent() {
    // P_iJ = J sigma_ij F^-T_jJ; the growth rate belongs to the mode with the smallest omega^2.
    let state = document(STATE);
    let f = [1.2, 0.9, 1.0];
    for i in 0..3 {
        let cauchy = number(&state, &format!("/material/cauchy/{i}/{i}"));
        let first_piola = number(&state, &format!("/material/first_piola/{i}/{i}"));
        crate::assert_close(1.2 * 0.9 * cauchy / f[i], first_piola, 1e-14);
    }
    let growth = number(&state, "/discretization/growth_rate");
    let lowest = number(&state, "/discretization/minimum_omega_squared/re");
    crate::assert_close(growth * growth, -lowest, 1e-9);
}

#[test]
fn the_growing_mode_is_reproduced_at_its_wave_vector() {
    let state = document(STATE);
    let k = numbers(&state, "/discretization/wave_vector");
    let line = format!(
        "dispersion --stretch 1.2,0.9 set frame=eulerian --wave-vector={:e},{:e}",
        k[0], k[1]
    );
    let lowest = number(&state, "/discretization/minimum_omega_squared/re");
    crate::assert_close(
        number(&document(&line), "/omega_squared/0/re"),
        lowest,
        1e-9,
    );
}

#[test]
fn waves_have_their_documented_keys() {
    let waves = document(WAVES);
    assert_eq!(waves["omega_squared"].as_array().map(Vec::len), Some(2));
    let trace: f64 = (0..2)
        .map(|i| {
            number(&waves, &format!("/omega_squared/{i}/im"));
            number(&waves, &format!("/omega_squared/{i}/re"))
        })
        .sum();
    for i in 0..2 {
        for j in 0..2 {
            number(&waves, &format!("/dynamical_matrix/{i}/{j}/re"));
            number(&waves, &format!("/dynamical_matrix/{i}/{j}/im"));
        }
    }
    let diagonal: f64 = (0..2)
        .map(|i| number(&waves, &format!("/dynamical_matrix/{i}/{i}/re")))
        .sum();
    crate::assert_close(trace, diagonal, 1e-14);
}

#[test]
fn a_path_has_its_documented_keys() {
    let path = document(PATH);
    for onset in ["material_onset", "discretization_onset"] {
        let onset = &path[onset];
        assert_eq!(numbers(onset, "/stretch").len(), 2);
        assert_eq!(numbers(onset, "/cauchy/0").len(), 3);
        assert!((0.0..1e-9).contains(&number(onset, "/tolerance")));
        assert_eq!(numbers(onset, "/direction").len(), 2);
        assert_eq!(numbers(onset, "/polarization").len(), 2);
    }
    assert_eq!(numbers(&path, "/discretization_onset/wave_vector").len(), 2);
    for crossings in ["material_crossings", "discretization_crossings"] {
        let crossings = path[crossings].as_array().expect("a list");
        let phases: Vec<_> = crossings
            .iter()
            .map(|crossing| (crossing["from"].as_str(), crossing["to"].as_str()))
            .collect();
        let (stable, unstable) = (Some("stable"), Some("unstable"));
        assert_eq!(phases, [(stable, unstable), (unstable, stable)]);
        for crossing in crossings {
            number(crossing, "/tolerance");
            assert_eq!(numbers(crossing, "/stretch").len(), 2);
        }
    }
}

#[test]
fn onsets_that_do_not_exist_are_null() {
    let path = document("path --from 1,1 --to 1,1.2");
    assert_eq!(path["material_onset"], Value::Null);
    assert_eq!(path["discretization_onset"], Value::Null);
    assert_eq!(path["material_crossings"], Value::Array(Vec::new()));
}

#[test]
fn numbers_have_the_fewest_digits_that_read_back() {
    for line in [STATE, WAVES, PATH] {
        let text = onset_line(&format!("{line} --json")).stdout;
        let mut numbers = 0;
        for item in text.lines().map(|line| {
            let value = line.rsplit(": ").next().unwrap_or(line);
            value.trim().trim_end_matches(',')
        }) {
            let is_count = item.bytes().all(|c| c.is_ascii_digit());
            if is_count || !item.starts_with(|c: char| c == '-' || c.is_ascii_digit()) {
                continue;
            }
            numbers += 1;
            // Rust writes the fewest digits that are read back as the same number.
            let digits = |text: &str| {
                let mantissa = text.split('e').next().unwrap_or(text);
                let own: String = mantissa.chars().filter(char::is_ascii_digit).collect();
                own.trim_matches('0').to_owned()
            };
            let number: f64 = item.parse().expect("a number");
            assert_eq!(digits(item), digits(&format!("{number:e}")), "{item}");
        }
        assert!(numbers > 10, "{line}: {numbers} numbers");
    }
}

#[test]
fn text_and_document_agree() {
    let text = onset_line(STATE).stdout;
    let state = document(STATE);
    let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(words(&text).starts_with(state["sentence"].as_str().expect("a sentence")));
    let verdict = state["verdict"].as_str().expect("a verdict");
    let line = text.lines().find(|line| line.starts_with("verdict"));
    assert_eq!(
        line.and_then(|l| l.split_whitespace().nth(1)),
        Some(verdict)
    );
}

#[test]
fn every_verdict_states_its_evidence() {
    let stable =
        "--set discretization.method=total-lagrangian-sph --set discretization.penalty=0.5";
    for (line, evidence) in [
        (format!("state --stretch 1.1,1 {stable}"), "bounded"),
        (
            "state --stretch 1.1,1 --certify --set discretization.support=2.2".to_owned(),
            "proved",
        ),
        (PATH.to_owned(), "searched"),
        (format!("modes {stable}"), "bounded"),
        (
            "criteria --set material.model=blatz-ko --mode hydrostatic".to_owned(),
            "searched",
        ),
        (
            "card --set material.model=blatz-ko --mode hydrostatic".to_owned(),
            "searched",
        ),
        (
            format!("limit --time-step 0.1 --vary material.c1 {stable}"),
            "searched",
        ),
    ] {
        assert_eq!(document(&line)["evidence"], evidence, "{line}");
        let has_short_form = ["state", "criteria", "limit"]
            .iter()
            .any(|word| line.starts_with(word));
        let all = if has_short_form { " --all" } else { "" };
        let text = onset_line(&format!("{line}{all}")).stdout;
        let told = format!("{:<24}{evidence} ", "evidence");
        assert!(text.contains(&told), "{line}: {text}");
    }
}
