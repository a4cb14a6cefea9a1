//! `onset tune`.

use super::{Scratch, document, number, onset, onset_line, words};

const PENALTY: &str = "set method=total-lagrangian-sph set lattice=square";

#[test]
fn the_penalty_is_tuned_between_too_little_and_too_much() {
    let answer = document(&format!("tune discretization.penalty {PENALTY} --quiet"));
    let value = number(&answer, "/recommended");
    assert_eq!(answer["is_ever_sufficient"], true);
    // Direct evaluation: the value itself is sufficient, and a slightly smaller value is not.
    let weakest = |value: f64| {
        let line = format!("modes {PENALTY} set penalty={value}");
        number(&document(&line), "/weakest")
    };
    assert!(weakest(value) >= 0.1, "{}", weakest(value));
    assert!(weakest(0.99 * value) < 0.1, "{}", weakest(0.99 * value));
    let tried = answer["tried"].as_array().expect("values");
    let values: Vec<f64> = tried.iter().map(|one| number(one, "/value")).collect();
    assert!(values.windows(2).all(|pair| pair[0] <= pair[1]));
    assert_eq!((values[0], values[values.len() - 1]), (0.0, 1.0));
    assert_eq!(tried[0]["measured"]["zero_modes"], 3);
}

#[test]
fn values_that_a_method_refuses_are_reported_with_the_reason() {
    let line = "tune discretization.stress-point-weight set lattice=square --range 0.5,1";
    let answer = onset_line(line);
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    assert!(
        answer
            .stdout
            .contains("stress-point-weight` cannot be 1; expected a number above 0"),
        "{}",
        answer.stdout
    );
}

#[test]
fn a_tuned_coefficient_is_drawn_and_listed() {
    let folder = Scratch::new("tune");
    let out = folder.display().to_string();
    let mut words = super::words(&format!("tune discretization.penalty {PENALTY} --quiet"));
    words.extend(["--out".to_owned(), out]);
    let answer = onset(&words.iter().map(String::as_str).collect::<Vec<_>>());
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    let csv = std::fs::read_to_string(folder.join("tune.csv")).expect("a file");
    let columns = csv.lines().next().expect("a head").split(',').count();
    assert!(
        csv.lines().all(|line| line.split(',').count() == columns),
        "{csv}"
    );
    for file in ["tune.svg", "tune.png"] {
        assert!(folder.join(file).is_file(), "{file}");
    }
}

#[test]
fn invalid_coefficients_are_refused() {
    for (line, fact) in [
        ("tune discretization.kernel", "is not a coefficient"),
        ("tune discretization.cells", "is not a coefficient"),
        ("tune material.mu", "is not a coefficient of the method"),
        (
            "tune discretization.penalti",
            "did you mean `discretization.penalty`",
        ),
        ("tune penalty", "did you mean `discretization.penalty`"),
        (
            "tune discretization.penalty",
            "`discretization.penalty` has no effect: discretization.method is kernel",
        ),
        (
            "tune discretization.hourglass-stiffness set method=finite-elements",
            "discretization.integration is full",
        ),
        (
            "tune discretization.penalty --range 1,0",
            "the smaller one first",
        ),
        (
            "tune discretization.penalty --range 0,inf",
            "the smaller one first",
        ),
        (
            "tune discretization.penalty --stretches -1,2",
            "two positive stretches",
        ),
        (
            "tune discretization.penalty --stretches 1.5,0.7",
            "two positive stretches",
        ),
        (
            "tune discretization.penalty set method=total-lagrangian-sph --range -2,-1 --quiet",
            "a number from 0 to 1e6",
        ),
    ] {
        let answer = onset_line(line);
        assert_eq!(answer.code, Some(2), "{line}: {}", answer.stderr);
        assert_eq!(answer.stdout, "", "{line}");
        assert!(answer.stderr.contains(fact), "{line}: {}", answer.stderr);
    }
}

#[test]
#[cfg(all(target_os = "linux", target_env = "gnu"))]
fn a_limited_address_space_costs_no_time() {
    let question = "tune --all discretization.penalty --set discretization.method=tlsph";
    let free = onset_line(question);
    let limited = std::process::Command::new("sh")
        .args([
            "-c",
            "ulimit -v 150000; ulimit -t 40; exec \"$@\"",
            "sh",
            env!("CARGO_BIN_EXE_onset"),
        ])
        .args(words(question))
        .output()
        .expect("sh");
    assert_eq!(String::from_utf8_lossy(&limited.stdout), free.stdout);
}

#[test]
fn tuning_a_viscosity_reports_that_it_has_no_stiffness() {
    let text = onset_line(&format!("tune discretization.viscosity {PENALTY}")).stdout;
    for fact in [
        "discretization.viscosity is a damping without stiffness",
        "discretization.penalty is a stiffness that can be tuned",
    ] {
        assert!(text.contains(fact), "{text}");
    }
    let text = onset(&[
        "tune",
        "discretization.viscosity",
        "--set",
        "discretization.method=updated-sph",
    ])
    .stdout;
    assert!(text.contains("a damping without stiffness"), "{text}");
    let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let fact = "discretization.penalty is a stiffness that can be tuned";
    assert!(words.contains(fact), "{text}");
    assert!(text.lines().count() <= 7, "{text}");
    let refused = onset_line("tune discretization.kernel set method=updated-sph");
    assert_eq!(refused.code, Some(2));
    let hint = "`onset compare --vary discretization.kernel` compares its values";
    assert!(refused.stderr.contains(hint), "{}", refused.stderr);
}
