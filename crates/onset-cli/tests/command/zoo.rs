//! `onset zoo`: reported instabilities.

use crate::{Scratch, document, onset_line};

#[test]
fn the_zoo_lists_each_report_on_one_line() {
    let list = onset_line("zoo");
    assert_eq!(list.code, Some(0), "{}", list.stderr);
    let all = document("zoo");
    let reports = all["reports"].as_array().expect("a list");
    assert_eq!(reports.len(), 18);
    for report in reports {
        let name = report["name"].as_str().expect("a name");
        let mut lines = list.stdout.lines();
        let line = lines.find(|line| line.split_whitespace().next() == Some(name));
        let verdict = report["verdict"].as_str().expect("a verdict");
        assert!(line.expect("a line").contains(verdict), "{name}");
    }
    let wide = list.stdout.lines().find(|line| line.chars().count() > 100);
    assert_eq!(wide, None);
}

#[test]
fn a_report_writes_a_study_with_the_answer_of_the_report() {
    let folder = Scratch::new("zoo");
    let place = folder.join("beam.toml").display().to_string();
    let told = onset_line(&format!("zoo trixi-371-cubic --out {place}"));
    assert_eq!(told.code, Some(0), "{}", told.stderr);
    for fact in [
        "https://github.com/trixi-framework/TrixiParticles.jl/pull/371",
        "--set discretization.penalty=0.3",
        "[discretization]",
    ] {
        assert!(told.stdout.contains(fact), "{fact}: {}", told.stdout);
    }
    let report = document("zoo trixi-371-cubic");
    let study = document(&format!("state {place} --stretch 1,1"));
    assert_eq!(report["answer"]["discretization"], study["discretization"]);
    assert_eq!(report["remedy_answer"]["verdict"], "stable");
}

#[test]
fn an_entry_of_the_zoo_as_a_study_leads_to_the_command() {
    let file = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../zoo/trixi-371-cubic.toml"
    );
    for line in [
        format!("state {file} --stretch 1,1"),
        format!("check {file}"),
        format!("map {file}"),
    ] {
        let refused = onset_line(&line);
        assert_eq!(refused.code, Some(2), "{}", refused.stdout);
        let hint = "`onset zoo trixi-371-cubic`";
        assert!(refused.stderr.contains(hint), "{}", refused.stderr);
    }
    let unknown = onset_line("zoo trixi-371-cubik");
    assert_eq!(unknown.code, Some(2));
    let meant = "did you mean `trixi-371-cubic`?";
    assert!(unknown.stderr.contains(meant), "{}", unknown.stderr);
}
