//! `onset screen`: causes of runs of patches, and refusals.

use super::{Scratch, number, onset};
use serde_json::Value;

/// Runs a patch with noise, screens its fields, and returns the answer.
fn screened(settings: &str, stretch: &str, time: &str) -> Value {
    let folder = Scratch::new("patch");
    let sets = || settings.split(' ').flat_map(|set| ["--set", set]);
    let out = folder.to_str().expect("UTF-8");
    let mut words = vec![
        "simulate",
        "--stretch",
        stretch,
        "--time",
        time,
        "--out",
        out,
    ];
    words.extend([
        "--mode",
        "noise",
        "--amplitude",
        "1e-4",
        "--cells",
        "12",
        "--fields",
        "31",
    ]);
    words.extend(sets());
    let run = onset(&words);
    // A run that breaks down has written its fields.
    assert!(folder.join("fields.pvd").exists(), "{}", run.stderr);
    let fields = folder.join("fields.pvd");
    let mut words = vec!["screen", fields.to_str().expect("UTF-8"), "--json"];
    words.extend(sets());
    let answer = onset(&words);
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    serde_json::from_str(&answer.stdout).expect("a document")
}

const NEO_HOOKE: &str = "material.model=neo-hooke material.young=1 material.poisson=0.3";
const BLATZ_KO: &str = "material.model=blatz-ko material.mu=1";

#[test]
fn patches_have_the_cause_of_their_state() {
    let cases = [
        (
            NEO_HOOKE,
            "method=total-lagrangian-sph penalty=0.3",
            "1.1,1",
            "40",
            "none",
        ),
        (NEO_HOOKE, "method=peridynamics", "0.9,1", "40", "none"),
        (NEO_HOOKE, "method=finite-elements", "1.3,0.9", "40", "none"),
        (NEO_HOOKE, "frame=lagrangian", "0.9,0.9", "40", "none"),
        (NEO_HOOKE, "method=updated-sph", "1.1,1", "16", "numerical"),
        (
            NEO_HOOKE,
            "method=updated-sph artificial-stress=0.3",
            "1.3,0.9",
            "44",
            "numerical",
        ),
        (BLATZ_KO, "method=updated-sph", "0.9,1", "62", "numerical"),
        (
            BLATZ_KO,
            "method=updated-sph artificial-stress=0.3",
            "3.2,0.7",
            "2.4",
            "physical",
        ),
        (
            BLATZ_KO,
            "method=finite-elements",
            "3.2,0.7",
            "20",
            "physical",
        ),
    ];
    for (law, method, stretch, time, cause) in cases {
        let method = method
            .split(' ')
            .map(|set| format!(" discretization.{set}"));
        let settings = format!("{law}{}", method.collect::<String>());
        let answer = screened(&settings, stretch, time);
        assert_eq!(answer["cause"], cause, "{settings} {stretch}: {answer}");
        let observed = &answer["observed"];
        match cause {
            "none" => assert!(observed.is_null()),
            "numerical" => {
                let (expected, observed) =
                    (number(&answer, "/expected"), number(observed, "/time"));
                assert!(
                    (expected / observed - 1.0).abs() < 0.35,
                    "{expected} {observed}"
                );
            }
            _ => {}
        }
    }
}

/// Arguments of the run of a notched plate.
fn notched<'a>(more: &[&'a str]) -> Vec<&'a str> {
    let file = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../runs/notched-plate.dump.gz"
    );
    let study = concat!(env!("CARGO_MANIFEST_DIR"), "/../../runs/notched-plate.toml");
    let mut words = vec!["screen", file, study];
    words.extend(more);
    words
}

const STEP: [&str; 4] = ["--time-step", "0.72", "--stepping", "extrapolated-stress"];

#[test]
fn a_run_is_checked_before_it_is_screened() {
    let answer = onset(&notched(&[&STEP[..], &["--check"]].concat()));
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    for fact in [
        "LAMMPS dump",
        "634 particles",
        "x=x,y",
        "F=c_F[1]",
        "type 2, which moves rigidly",
    ] {
        assert!(
            answer.stdout.contains(fact),
            "no `{fact}` in {}",
            answer.stdout
        );
    }
}

#[test]
fn files_and_exit_code_follow_the_cause() {
    let folder = Scratch::new("screened");
    let out = folder.to_str().expect("UTF-8");
    let more = [
        "--frames",
        "0:12",
        "--out",
        out,
        "--fail-on",
        "numerical,time-step",
        "--actual",
        "21",
    ];
    let answer = onset(&notched(&[&STEP[..], &more].concat()));
    assert_eq!(answer.code, Some(3), "{}", answer.stderr);
    assert!(
        answer.stdout.starts_with("First cause: the time step."),
        "{}",
        answer.stdout
    );
    assert!(answer.stdout.lines().count() <= 15, "{}", answer.stdout);
    for name in [
        "screen.pvd",
        "screen-000000.vtu",
        "screen.json",
        "screen.csv",
        "screen.svg",
        "screen.png",
        "first.toml",
        "modes.vtu",
    ] {
        assert!(folder.join(name).exists(), "{name}");
    }
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).expect("a file");
    let modes = read("modes.vtu");
    assert!(modes.contains("Name=\"mode_1\" NumberOfComponents=\"3\""));
    let document: Value = serde_json::from_str(&read("screen.json")).expect("a document");
    let actual = &document["actual"];
    assert_eq!(number(&document, "/actual/asked"), 21.0);
    assert_eq!(actual["modes"].as_array().map(Vec::len), Some(6));
    assert!(
        answer.stdout.contains("the frame nearest to 21"),
        "{}",
        answer.stdout
    );
    // The fields can be read again, as a run.
    let fields = folder.join("screen.pvd");
    let study = concat!(env!("CARGO_MANIFEST_DIR"), "/../../runs/notched-plate.toml");
    let again = onset(&["screen", fields.to_str().expect("UTF-8"), study, "--check"]);
    assert!(
        again.stdout.contains("634 particles"),
        "{} {}",
        again.stdout,
        again.stderr
    );
}

#[test]
fn faults_are_refused_with_a_hint() {
    for (more, expected) in [
        (vec![], "--time-step"),
        (
            vec!["--time-step", "0.72", "--held", "grip"],
            "held particles `grip` are unknown",
        ),
        (
            vec!["--time-step", "0.72", "--held", "7"],
            "the types are 1, 2",
        ),
        (
            vec!["--time-step", "0.72", "--region", "0,0:-1,1"],
            "is not a box",
        ),
        (
            vec!["--time-step", "0.72", "--region", "90,90:91,91"],
            "no particle is left to be judged",
        ),
        (
            vec!["--time-step", "0.72", "--frames", "3:4"],
            "growth needs at least two",
        ),
        (
            vec!["--time-step", "0.72", "--columns", "x=a,b"],
            "no column a",
        ),
        (
            vec!["--time-step", "0.72", "--set", "discretization.spacing=3"],
            "set discretization.spacing=1",
        ),
        (
            vec!["--time-step", "0.72", "--stepping", "euler"],
            "velocity-verlet",
        ),
        (
            vec!["--time-step", "0.72", "--fail-on", "breakage"],
            "causes:",
        ),
        (
            vec!["--time-step", "0.72", "--reference", "missing.dump"],
            "missing.dump",
        ),
    ] {
        let answer = onset(&notched(&more));
        assert_eq!(answer.code, Some(2), "{more:?}: {}", answer.stdout);
        assert!(
            answer.stderr.contains(expected),
            "{more:?}: {}",
            answer.stderr
        );
    }
}
