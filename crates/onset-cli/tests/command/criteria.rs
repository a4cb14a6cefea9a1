//! `onset criteria` and `onset card`.

use super::{assert_close, document, fresh_place, number, onset};
use serde_json::Value;

const BLATZ_KO: &str = "--set material.model=blatz-ko";

fn criterion<'a>(loading: &'a Value, name: &str) -> &'a Value {
    let criteria = loading["criteria"].as_array().expect("a list");
    let found = criteria.iter().find(|answer| answer["criterion"] == name);
    found.unwrap_or_else(|| panic!("no criterion {name}"))
}

#[test]
fn criteria_of_a_bar_are_told_with_their_limits_and_waves() {
    let answer = document(&format!("criteria {BLATZ_KO} --mode uniaxial"));
    assert_eq!(answer["loadings"].as_array().expect("a list").len(), 3);
    let bar = &answer["loadings"][0];
    assert_eq!(bar["lateral"], "free");
    let load = number(criterion(bar, "load-maximum"), "/tension/limit");
    assert_close(load, 6.0_f64.powf(0.4), 1e-10);
    let waves = criterion(bar, "strong-ellipticity");
    assert_close(
        number(waves, "/tension/limit"),
        (2.0 + 3.0_f64.sqrt()).powf(0.8),
        1e-10,
    );
    assert_eq!(waves["tension"]["changes"][0]["witness"]["kind"], "wave");
    assert!(criterion(bar, "drucker")["tension"]["limit"].is_null());
    assert_eq!(answer["polyconvexity"]["knowledge"], "not-polyconvex");
    let sentences = answer["disagreements"].to_string();
    assert!(
        sentences
            .contains("uniaxial, lateral faces free, tension from 2.047673 (waves to 2.867861)"),
        "{sentences}"
    );
    assert!(
        sentences.contains(
            "Drucker's criterion still holds where ellipticity is lost: uniaxial, lateral"
        ),
        "{sentences}"
    );
}

#[test]
fn criteria_draw_a_figure_where_it_is_asked_for() {
    let folder = fresh_place("criteria");
    let place = folder.display().to_string();
    let answer = onset(&[
        "criteria",
        "--set",
        "material.model=blatz-ko",
        "--mode",
        "hydrostatic",
        "--out",
        &place,
    ]);
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    assert!(answer.stdout.contains("criteria.svg"), "{}", answer.stdout);
    let svg = std::fs::read_to_string(folder.join("criteria.svg")).expect("a figure");
    assert!(svg.contains("hydrostatic") && svg.contains("load-maximum"));
    assert!(folder.join("criteria.png").is_file());
}

#[test]
fn a_card_is_one_page_without_references_to_anything_else() {
    let folder = fresh_place("card");
    let place = folder.display().to_string();
    let answer = document(&format!("card {BLATZ_KO} --out {place}"));
    let ratio = 2.0 + 3.0_f64.sqrt();
    assert_close(number(&answer, "/symmetric_box/high"), ratio.sqrt(), 1e-9);
    let widest = number(&answer, "/widest_box/high") / number(&answer, "/widest_box/low");
    assert_close(widest, ratio, 1e-9);
    let page = std::fs::read_to_string(folder.join("card.html")).expect("a page");
    for reference in ["src=", "href=\"http", "@import", "url("] {
        assert!(!page.contains(reference), "{reference}");
    }
    assert!(page.contains("<svg") && page.contains("1.931852"), "{page}");
    for name in ["card.json", "card.svg", "card.png"] {
        assert!(folder.join(name).is_file(), "{name}");
    }
    let stored = std::fs::read_to_string(folder.join("card.json")).expect("a document");
    let stored: Value = serde_json::from_str(&stored).expect("JSON");
    assert_eq!(stored, answer);
}

#[test]
fn wrong_ranges_modes_and_laws_are_refused() {
    for (arguments, fact) in [
        (vec!["criteria", "--range", "2,3"], "around 1"),
        (vec!["criteria", "--range", "2"], "0.1,10"),
        (vec!["card", "--range", "0.1,1e9"], "around 1"),
        (vec!["criteria", "--mode", "torsion"], "simple-shear"),
        (
            vec!["criteria", "--set", "material.modl=blatz-ko"],
            "did you mean",
        ),
        (vec!["card", "nowhere.toml"], "cannot read nowhere.toml"),
    ] {
        let answer = onset(&arguments);
        assert_eq!(answer.code, Some(2), "{arguments:?}");
        assert!(
            answer.stderr.contains(fact),
            "{arguments:?}: {}",
            answer.stderr
        );
    }
}
