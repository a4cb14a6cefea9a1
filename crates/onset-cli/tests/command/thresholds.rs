//! Limits for recommending methods and tuning coefficients.

use super::{document, number, onset, onset_line};

#[test]
fn limits_are_options_and_their_effect_is_reported() {
    let line = "recommend --dimension 1 --set compare.states=2";
    let usual = document(line);
    assert_eq!(number(&usual, "/table/thresholds/weak"), 0.1);
    let names = |document: &serde_json::Value| -> Vec<String> {
        let ranking = document["ranking"].as_array().expect("a ranking").clone();
        let good = ranking.iter().filter(|one| one["excluded"].is_null());
        good.map(|one| one["name"].as_str().expect("a name").to_owned())
            .collect()
    };
    // The predicted effect of another limit is its actual effect.
    for one in usual["dependence"].as_array().expect("a list") {
        let (option, value) = (
            one["threshold"].as_str().expect("a name"),
            number(one, "/value"),
        );
        let other = names(&document(&format!("{line} --{option} {value}")));
        assert_eq!(
            one["best"].as_str(),
            other.first().map(String::as_str),
            "{option} {value}"
        );
        let own = names(&usual);
        let more: Vec<&String> = other.iter().filter(|name| !own.contains(name)).collect();
        let told: Vec<&str> = one["more"]
            .as_array()
            .expect("a list")
            .iter()
            .filter_map(|name| name.as_str())
            .collect();
        assert_eq!(told, more, "{option} {value}");
    }
    let text = onset_line(&format!("{line} --weak 0.37 --long-waves 0.2")).stdout;
    for fact in [
        "slower than 37 %",
        "wrong by more than 20 %",
        "with other limits",
        "--weak 0.74",
    ] {
        assert!(text.contains(fact), "{fact}: {text}");
    }
    let csv = onset_line(&format!("{line} --format csv")).stdout;
    assert!(
        csv.starts_with("place,method,score,cost,rule,why\n1,"),
        "{csv}"
    );
}

#[test]
fn every_command_that_marks_weakly_controlled_waves_takes_their_limit() {
    let compared = |more: &str| {
        let line = format!(
            "compare --vary discretization.penalty=0.05,0.5 --set discretization.method=tlsph --set discretization.lattice=square --set compare.states=2 {more}"
        );
        let words: Vec<&str> = line.split_whitespace().collect();
        onset(&words).stdout.matches("zero-energy").count()
    };
    assert!(compared("--weak 0.9") > compared("--weak 0.001"));
    let marked = |more: &str| {
        let line = format!("dispersion --stretch 1,1 --path {more}");
        number(&document(&line), "/weak")
    };
    assert_eq!([marked(""), marked("--weak 0.3")], [0.1, 0.3]);
    let idle = onset_line("dispersion --stretch 1,1 --wave-vector 1,0 --weak 0.3");
    assert_eq!(idle.code, Some(2));
    assert!(
        idle.stderr.contains("--weak has no effect"),
        "{}",
        idle.stderr
    );
    let screened = onset_line("screen --help").stdout;
    assert!(screened.contains("--weak <SHARE>"), "{screened}");
}

#[test]
fn a_stricter_limit_gives_a_larger_coefficient() {
    let line = "tune discretization.penalty set method=tlsph set lattice=square";
    let value = |more: &str| number(&document(&format!("{line} {more}")), "/recommended");
    assert!(value("--weak 0.11") > value("--weak 0.05"));
    let text = onset_line(line).stdout;
    for fact in [
        "(--weak)",
        "(--wrong)",
        "(--later)",
        "with other limits",
        "--weak 0.2: ",
    ] {
        assert!(text.contains(fact), "{fact}: {text}");
    }
    for wrong in ["--weak 0", "--weak 2", "--wrong x", "--later -1"] {
        assert_eq!(
            onset_line(&format!("{line} {wrong}")).code,
            Some(2),
            "{wrong}"
        );
    }
}
