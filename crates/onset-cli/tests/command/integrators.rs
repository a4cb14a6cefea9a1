//! The time integrator of a study in all commands that compute or take time steps.

use crate::{Scratch, document, number, onset_line};
use serde_json::Value;
use std::fs;

const SPH: &str = "--set material.model=neo-hooke --set material.mu=1 --set material.lambda=2 --set discretization.method=total-lagrangian-sph \
                   --set discretization.lattice=square";

fn state(more: &str) -> Value {
    document(&format!(
        "state --stretch 1.05,0.98 {SPH} --set discretization.penalty=0.3 {more}"
    ))
}

#[test]
fn a_state_has_the_step_of_the_chosen_integrator() {
    let plain = state("");
    let step = |own: &Value| number(own, "/discretization/critical_time_step");
    let bodies = |own: &Value| number(own, "/discretization/finite_bodies/time_step");
    assert_eq!(plain["discretization"]["integrator"], "kick-drift-kick");
    let text = onset_line(&format!("state --stretch 1.05,0.98 {SPH}")).stdout;
    assert!(
        text.contains("kick-drift-kick needs a time step below"),
        "{text}"
    );
    // Limits of omega dt relative to central differences.
    for (name, ratio) in [
        ("leapfrog", 1.0),
        ("velocity-verlet", 1.0),
        ("rk3", 0.75_f64.sqrt()),
        ("rk4", 2.0_f64.sqrt()),
    ] {
        let own = state(&format!("--set time.integrator={name}"));
        assert!((step(&own) / step(&plain) - ratio).abs() < 1e-9, "{name}");
        assert!(
            (bodies(&own) / bodies(&plain) - ratio).abs() < 1e-9,
            "{name}"
        );
        assert!(own["discretization"]["implicit"].is_null(), "{name}");
    }
    let heun = state("--set time.integrator=heun");
    assert_eq!(step(&heun), 0.0);
    assert!(heun["discretization"]["finite_bodies"].is_null());
    let line = format!("state --stretch 1.05,0.98 {SPH} --set time.integrator=heun");
    let text = onset_line(&line).stdout;
    assert!(
        text.contains("heun is unstable for every time step"),
        "{text}"
    );
}

#[test]
fn an_implicit_integrator_has_no_step_in_a_state_and_is_refused_where_a_step_is_needed() {
    let own = state("--set time.integrator=newmark");
    let part = &own["discretization"];
    assert!(part["critical_time_step"].is_null() && part["finite_bodies"].is_null());
    assert_eq!(part["implicit"]["tangent"], "positive");
    let unstable = "state --stretch 1.3,1 --set discretization.method=updated-sph --set time.integrator=backward-euler";
    let limits = document(unstable)["discretization"]["implicit"]["largest_steps"].clone();
    let names: Vec<&String> = limits.as_object().expect("steps").keys().collect();
    assert_eq!(names, ["backward-euler"]);
    for line in [
        format!("limit --vary material.mu --time-step 0.1 {SPH} --integrator newmark"),
        format!("simulate --stretch 1.1,1 --steps 3 {SPH} --set time.integrator=newmark"),
        format!(
            "compare --vary discretization.penalty=0.1,0.3 {SPH} --set time.integrator=newmark"
        ),
    ] {
        let answer = onset_line(&line);
        assert_eq!(answer.code, Some(2), "{line}");
        assert!(
            answer.stderr.contains("newmark is implicit"),
            "{}",
            answer.stderr
        );
    }
}

#[test]
fn a_transfer_of_material_points_accepts_no_integrator() {
    let points = "--set discretization.method=mls-mpm --set discretization.lattice=square";
    for line in [
        format!("state --stretch 1,1 {points} --set time.integrator=rk4"),
        format!("limit --vary material.mu --time-step 0.1 {points} --integrator rk4"),
    ] {
        let answer = onset_line(&line);
        assert_eq!(answer.code, Some(2), "{line}: {}", answer.stdout);
        assert!(
            answer.stderr.contains("discretization.transfer"),
            "{}",
            answer.stderr
        );
    }
}

#[test]
fn limit_simulate_and_compare_use_the_integrator_of_the_settings() {
    let limit = |more: &str| {
        document(&format!(
            "limit --vary material.mu --time-step 0.5 {SPH} {more}"
        ))
    };
    let (set, option) = (
        limit("--set time.integrator=rk4"),
        limit("--integrator rk4"),
    );
    assert_eq!(set["integrator"], "rk4");
    assert_eq!(set["admitted"], option["admitted"]);
    // Three steps are too few for a comparison of rates.
    let run = onset_line(&format!(
        "simulate --stretch 1.1,1 --steps 3 {SPH} --set time.integrator=rk4 --json"
    ));
    let run: Value = serde_json::from_str(&run.stdout).expect("a document");
    assert_eq!(run["integrator"], "rk4");
    let steps = document(&format!(
        "compare --vary time.integrator=kick-drift-kick,rk4 {SPH} --set discretization.penalty=0.3"
    ));
    let step = |n: usize| number(&steps, &format!("/rows/{n}/measured/critical_time_step"));
    assert!((step(1) / step(0) - 2.0_f64.sqrt()).abs() < 1e-9);
}

#[test]
fn a_study_has_a_section_for_time_and_still_reads_earlier_keys() {
    let axes = "[[axes]]\nquantity = 'stretch-1'\nrange = [0.9, 1.1]\nstates = 8\n\
                [[axes]]\nquantity = 'stretch-2'\nrange = [0.9, 1.1]\nstates = 8\n";
    let folder = Scratch::new("integrator");
    fs::create_dir_all(&folder).expect("a folder");
    let written = |text: &str| {
        let file = folder.join("study.toml");
        fs::write(&file, format!("{text}\n{axes}")).expect("a file");
        onset_line(&format!("check {}", file.display()))
    };
    let now = written("[time]\nintegrator = 'rk4'");
    assert_eq!(now.code, Some(0), "{}", now.stderr);
    let earlier = written("[map]\nintegrator = 'rk4'");
    assert_eq!(earlier.code, Some(0), "{}", earlier.stderr);
    assert!(
        earlier
            .stderr
            .contains("`map.integrator` is now called `time.integrator`"),
        "{}",
        earlier.stderr
    );
    let wrong = written("[time]\nintegrator = 'rk5'");
    assert_eq!(wrong.code, Some(2));
    assert!(wrong.stderr.contains("did you mean"), "{}", wrong.stderr);
    let implicit = written("[time]\nintegrator = 'newmark'");
    assert_eq!(implicit.code, Some(2), "{}", implicit.stdout);
}
