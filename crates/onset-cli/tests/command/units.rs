//! Units in values, and answers in SI.

use super::{assert_close, document, fresh_place, number, onset_line};

const STEEL: &str = "--set material.model=neo-hooke --set material.mu=80GPa --set material.lambda=120GPa set density=7850kg/m^3 set spacing=1mm";
const PLAIN: &str = "--set material.model=neo-hooke --set material.mu=80e9 --set material.lambda=120e9 set density=7850 set spacing=1e-3";

#[test]
fn values_with_units_are_the_same_numbers_in_si() {
    let state = |what: &str| document(&format!("state --stretch 1.02,0.99 {what}"));
    let (with, without) = (state(STEEL), state(PLAIN));
    // Words tell units; numbers are the same.
    let numbers = |state: &serde_json::Value| {
        let mut numbers = state["discretization"].clone();
        numbers["mode"].take();
        numbers
    };
    assert_eq!(numbers(&with), numbers(&without));
    assert_eq!(with["material"]["cauchy"], without["material"]["cauchy"]);
    assert_eq!(with["settings"]["material.mu"]["unit"], "Pa");
    assert!(without["settings"]["material.mu"].get("unit").is_none());
    let moduli = "--set material.model=neo-hooke --set material.young=210GPa --set material.poisson=0.3 set density=7.85g/cm^3 set spacing=1mm";
    assert_close(
        number(&state(moduli), "/settings/material.mu/value"),
        210e9 / 2.6,
        1e-14,
    );
}

#[test]
fn texts_tell_si_units_where_values_have_units_and_none_where_they_have_none() {
    let line = |what: &str| onset_line(&format!("state --stretch 1.02,0.99 {what}"));
    let text = line(STEEL).stdout;
    for fact in [
        "mu 8e10 Pa",
        "spacing 0.001 m",
        "density 7850 kg/m^3",
        " s\n",
        " 1/s",
        " 1/m",
        "(Pa)",
    ] {
        assert!(text.contains(fact), "{fact}: {text}");
    }
    let text = line(PLAIN).stdout;
    for fact in [" Pa", " s\n", "kg/m"] {
        assert!(!text.contains(fact), "{fact}: {text}");
    }
    // The next command says the same again.
    let text = line(&format!("{STEEL} set quadrature=nodal")).stdout;
    assert!(text.contains("--set material.mu=80000000000Pa"), "{text}");
}

#[test]
fn units_in_some_values_alone_are_refused_with_those_that_have_none() {
    for (line, facts) in [
        (
            "state --stretch 1,1 --set material.model=neo-hooke --set material.mu=80GPa",
            vec![
                "material.lambda = 1 (the default)",
                "discretization.spacing = 1 (the default)",
                "have none",
            ],
        ),
        (
            "criteria --set material.model=neo-hooke --set material.mu=80GPa --set material.lambda=3",
            vec!["material.lambda = 3 has none"],
        ),
        (
            "state --stretch 1,1 set support=2mm",
            vec!["has no dimension"],
        ),
        (
            "state --stretch 1,1 set spacing=2GPa",
            vec!["is a length; `GPa` is a unit of a stress"],
        ),
        (
            "state --stretch 1,1 set spacing=2parsec",
            vec!["`parsec` is no unit that is known"],
        ),
        ("state --stretch 1,1 set spacing=-2mm", vec!["spacing"]),
    ] {
        let answer = onset_line(line);
        assert_eq!(answer.code, Some(2), "{line}: {}", answer.stdout);
        for fact in facts {
            assert!(answer.stderr.contains(fact), "{line}: {}", answer.stderr);
        }
    }
    // A question about the law alone has no spacing.
    let law =
        "card --set material.model=neo-hooke --set material.mu=80GPa --set material.lambda=120GPa";
    assert_eq!(onset_line(law).code, Some(0));
}

#[test]
fn a_study_with_units_is_written_out_and_read_back_with_them() {
    let place = fresh_place("study.toml");
    let text = "[material]\nmodel = \"neo-hooke\"\nlambda = \"120 GPa\"\n[discretization]\nspacing = \"1 mm\"\ndensity = \"7850 kg/m^3\"\n\
                [[axes]]\nquantity = \"stretch-1\"\nrange = [0.9, 1.1]\nstates = 3\n\
                [[axes]]\nquantity = \"material.mu\"\nrange = [\"70 GPa\", \"90 GPa\"]\nstates = 3\n";
    std::fs::write(&place, text).expect("a file");
    let file = place.display().to_string();
    let checked = document(&format!("check {file}"));
    assert_eq!(checked[0]["axes"][1]["range"][1], 90e9);
    // An override writes the study out in full; a map that is resumed reads it back.
    let store = fresh_place("map.zarr");
    let map = format!("map {file} --out {} set support=1.9", store.display());
    let first = document(&map);
    assert_eq!(number(&first, "/tiles_computed"), 1.0);
    let again = document(&format!("{map} --resume"));
    assert_eq!(number(&again, "/tiles_found"), 1.0);
    std::fs::write(&place, text.replace("\"1 mm\"", "1e-3")).expect("a file");
    let refused = onset_line(&format!("check {file}"));
    assert_eq!(refused.code, Some(2));
    assert!(
        refused
            .stderr
            .contains("discretization.spacing = 0.001 has none"),
        "{}",
        refused.stderr
    );
    std::fs::remove_file(place).expect("removed");
    std::fs::remove_dir_all(store).expect("removed");
}
