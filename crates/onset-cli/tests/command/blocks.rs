//! Decks of other programs in place of a study, in every command.

use crate::{Scratch, Written, document, onset, onset_line};

const RUBBER: &str = "*MATERIAL, NAME=RUBBER\n*HYPERELASTIC, NEO HOOKE\n0.5, 0.02\n";

/// Two rubbers, the first with properties that are not read.
const TWO: &str = "*MATERIAL, NAME=RUBBER_A\n*HYPERELASTIC, NEO HOOKE\n0.5, 0.02\n*VISCOELASTIC, TIME=PRONY\n0.2, 0., 0.1\n\
                   *MULLINS EFFECT\n1.5, 0.1, 0.1\n*DENSITY\n1.1e-9\n*MATERIAL, NAME=RUBBER_B\n*HYPERELASTIC, MOONEY-RIVLIN\n0.4, 0.1, 0.02\n";

#[test]
fn every_command_about_a_law_or_a_method_takes_a_deck() {
    let file = Written::new("rubber.inp", RUBBER);
    for line in [
        format!("state {file} --stretch 1.1,1"),
        format!("state {file} --from abaqus --stretch 1.1,1"),
        format!("dispersion {file} --stretch 1.1,1 --wave-vector 1,0.2"),
        format!("path {file} --from 1,1 --to 1.1,1"),
        format!("path {file} --mode uniaxial --to 1.1 --read-as abaqus"),
        format!("criteria {file} --mode uniaxial"),
        format!("card {file} --mode uniaxial"),
        format!("limit {file} --time-step 0.01 --vary discretization.spacing"),
        format!("tune discretization.support {file} --range 1.9,2.1"),
        format!("modes {file} set lattice=chain"),
        format!("audit {file}"),
        format!("check {file}"),
        format!(
            "compare {file} --vary discretization.support=1.9,2.1 set lattice=chain --set compare.states=2 --quiet"
        ),
        format!(
            "recommend {file} --dimension 1 --set compare.states=2 --stretches 0.9,1.1 --quiet"
        ),
        format!("simulate {file} --stretch 1.1,1 --cells 4 --steps 32 --quiet"),
    ] {
        let answer = onset_line(&line);
        assert!(
            answer.code.is_some_and(|code| code != 2),
            "{line}: {}",
            answer.stderr
        );
        let note = "read as yeoh from *HYPERELASTIC, NEO HOOKE of Abaqus, material RUBBER";
        let words = answer.stdout.split_whitespace().collect::<Vec<_>>();
        let is_noted = line.contains("--quiet") || words.join(" ").contains(note);
        assert!(is_noted, "{line}: {}", answer.stdout);
    }
    let read = document(&format!("state {file} --stretch 1.2,0.9"));
    let law = "--set material.model=yeoh --set material.c10=0.5 --set material.c20=0 --set material.c30=0 --set material.kappa=100";
    let set = document(&format!("state {law} --stretch 1.2,0.9"));
    assert_eq!(read["discretization"], set["discretization"]);
    assert_eq!(read["material"], set["material"]);
}

#[test]
fn terms_with_a_zero_coefficient_are_omitted() {
    let rubber = Written::new("neo.inp", RUBBER);
    let ogden = Written::new(
        "ogden.inp",
        "*HYPERELASTIC, OGDEN, N=2\n0.4, 1.3, 0.003, 5.0, 0.02\n",
    );
    for (file, present, absent) in [
        (&rubber, "c10", ["c20", "c30"]),
        (&ogden, "mu2", ["mu3", "alpha3"]),
    ] {
        for line in [
            format!("state {file} --stretch 1.1,1 --settings"),
            format!("state {file} --stretch 1.1,1 --all"),
            format!("criteria {file} --mode uniaxial --all"),
            format!("card {file} --mode uniaxial"),
        ] {
            // A command needs the values of all terms.
            let text = onset_line(&line).stdout;
            let lines = text.lines().filter(|line| !line.contains("--set "));
            let text = lines.collect::<Vec<_>>().join("\n");
            assert!(text.contains(present), "{line}: {text}");
            assert!(
                !absent.iter().any(|name| text.contains(name)),
                "{line}: {text}"
            );
        }
    }
}

#[test]
fn notes_on_a_deck_are_printed_in_full_after_the_answer() {
    let file = Written::new("two.inp", TWO);
    let line = ["criteria", &file, "--mode", "uniaxial"];
    let text = onset(&line).stdout;
    assert!(!text.contains("more: --all"), "{text}");
    let place = |words: &str| {
        text.find(words)
            .unwrap_or_else(|| panic!("{words}: {text}"))
    };
    assert!(
        place("uniaxial, lateral faces free  ") < place("note: "),
        "{text}"
    );
    let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    for note in [
        "note: read as yeoh from *HYPERELASTIC, NEO HOOKE of Abaqus and *VISCOELASTIC, material RUBBER_A (1 of 2; --material RUBBER_B)",
        "note: not read: *MULLINS EFFECT (line 6), *DENSITY (line 8)",
        "note: the constants are long-term moduli with a Prony series of 1 term",
    ] {
        assert!(words.contains(note), "{note}: {text}");
    }
    assert!(
        text.lines().all(|line| line.chars().count() <= 100),
        "{text}"
    );
    // A command stays on one line, with the settings.
    let same = "\nnote: the same law in other commands: --set material.model=";
    let settings = onset(&[&line[..], &["--settings"]].concat()).stdout;
    assert!(
        !text.contains(same) && settings.contains(same),
        "{settings}"
    );
    let second = onset_line(&format!(
        "criteria {file} --material rubber_b --mode uniaxial"
    ));
    assert!(
        second.stdout.contains("material RUBBER_B (2 of 2;"),
        "{}",
        second.stdout
    );
    let none = onset_line(&format!("criteria {file} --material C"));
    assert_eq!(none.code, Some(2));
    assert!(
        none.stderr.contains("RUBBER_A, RUBBER_B"),
        "{}",
        none.stderr
    );
    let file = Written::new(
        "quoted.inp",
        TWO.replace("RUBBER_A", "\"RUBBER, A\"")
            .replace("RUBBER_B", "\"RUBBER, B\""),
    );
    let none = onset(&["criteria", &file, "--material", "C"]).stderr;
    assert!(
        none.contains("with a law: \"RUBBER, A\", \"RUBBER, B\""),
        "{none}"
    );
}

#[test]
fn commands_that_need_axes_give_the_study_to_write() {
    let file = Written::new("rubber.inp", RUBBER);
    for line in [
        format!("map {file}"),
        format!("map {file} --from abaqus"),
        format!("boundary {file}"),
    ] {
        let answer = onset_line(&line);
        assert_eq!(answer.code, Some(2), "{line}: {}", answer.stdout);
        assert!(
            answer.stderr.contains("is an Abaqus deck"),
            "{}",
            answer.stderr
        );
        let study = answer
            .stderr
            .split("for example\n")
            .nth(1)
            .expect("a study");
        let study = study.replace("\n    ", "\n");
        let written = Written::new("deck.toml", study.trim());
        let checked = onset_line(&format!("check {written}"));
        assert_eq!(checked.code, Some(0), "{}: {study}", checked.stderr);
        assert!(
            checked.stdout.contains("c10 0.5, kappa 100"),
            "{}",
            checked.stdout
        );
    }
}

#[test]
fn the_program_of_a_deck_is_named_where_it_is_not_recognized() {
    let plain = Written::new("plain.txt", "one line\n");
    let refused = onset_line(&format!("state {plain} --material A --stretch 1,1"));
    assert_eq!(refused.code, Some(2));
    for fact in ["not recognized as a deck", "--from abaqus"] {
        assert!(refused.stderr.contains(fact), "{}", refused.stderr);
    }
    // CalculiX has the keywords of Abaqus, but no incompressible law.
    let file = Written::new("zero.inp", "*HYPERELASTIC, NEO HOOKE\n0.5, 0.0\n");
    let path = onset_line(&format!(
        "path {file} --read-as calculix --mode uniaxial --to 1.1"
    ));
    assert!(path.stdout.contains("CalculiX replaces"), "{}", path.stdout);
    let start = onset_line(&format!("path {file} --from abaqus --to 1.1,1"));
    assert_eq!(start.code, Some(2));
    assert!(
        start.stderr.contains("--read-as abaqus"),
        "{}",
        start.stderr
    );
}

#[test]
fn poissons_ratio_in_addition_to_the_constants_of_a_foam_is_refused() {
    let foam = "*MATERIAL, NAME=FOAM\n*HYPERFOAM, N=2, POISSON=0.1, MODULI=INSTANTANEOUS\n0.2, 8.0, 0.1, -4.0\n";
    let file = Written::new("foam.inp", foam);
    for command in ["criteria", "card", "state --stretch 1.1,1"] {
        let answer = onset_line(&format!("{command} {file} --from abaqus"));
        assert_eq!(answer.code, Some(2), "{}", answer.stdout);
        for fact in [":2:1: ", "POISSON=0.1", "TEST DATA INPUT", "nu1"] {
            assert!(answer.stderr.contains(fact), "{}", answer.stderr);
        }
    }
}

#[test]
fn the_criteria_are_listed_with_formula_and_source() {
    let list = onset_line("list criteria");
    assert_eq!(list.code, Some(0), "{}", list.stderr);
    for fact in [
        "ordered-forces",
        "hill-rotation-free",
        "A_iJkL g_i N_J g_k N_L > 0",
        "source: Ball, Arch. Ration. Mech. Anal. 63 (1977) 337",
    ] {
        assert!(list.stdout.contains(fact), "{fact}: {}", list.stdout);
    }
    let asked = document("criteria --set material.model=neo-hooke --mode uniaxial");
    let listed = document("list criteria");
    let entries = listed[0]["entries"].as_array().expect("entries");
    for criterion in asked["loadings"][0]["criteria"]
        .as_array()
        .expect("criteria")
    {
        let known = entries
            .iter()
            .any(|entry| entry["name"] == criterion["criterion"]);
        assert!(known, "{criterion}");
    }
}

#[test]
fn the_kernels_are_drawn_and_other_topics_have_no_figure() {
    let folder = Scratch::new("kernels");
    let out = folder.join("kernels.svg").display().to_string();
    let answer = onset(&["list", "kernels", "--out", &out]);
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    let svg = std::fs::read_to_string(&out).expect("a file");
    for name in ["quartic-spline", "laguerre-gauss", "distance r/h (−)"] {
        assert!(svg.contains(name), "{name}");
    }
    let refused = onset(&["list", "lattices", "--out", &out]);
    assert_eq!(refused.code, Some(2));
    assert!(
        refused
            .stderr
            .contains("`onset list lattices` has no figure"),
        "{}",
        refused.stderr
    );
}

#[test]
fn the_law_of_a_deck_and_its_unread_keywords_are_never_hidden() {
    let deck = "TB,HYPER,1,1,2,MOONEY\nTBDATA,1,0.4,0.1,0.02\nTB,PRONY,1,1,1,SHEAR\nTBDATA,1,0.3,0.1\n\
                TB,HYPER,2,1,3,YEOH\nTBDATA,1,0.5,-0.01,0.001,0.02,0,0\nMP,DENS,1,1.1E-9\n";
    let file = Written::new("two.txt", deck);
    for line in [
        format!("criteria {file}"),
        format!("card {file}"),
        format!("state {file} --stretch 1.1,1"),
    ] {
        let answer = onset_line(&line);
        let words = answer
            .stdout
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" ");
        for note in [
            "read as mooney-rivlin-isochoric from TB,HYPER with MOONEY of ANSYS and TB,PRONY, material 1 (1 of 2; --material 2)",
            "not read: TB,HYPER,2 (line 5), MP,DENS (line 7)",
        ] {
            assert!(
                words.contains(note),
                "{line}: {} {}",
                answer.stdout,
                answer.stderr
            );
        }
    }
    // Every command names the place of a constant that the law does not admit.
    let file = Written::new("wrong.txt", deck.replace("0.3,0.1", "1.3,0.1"));
    for line in [
        format!("criteria {file}"),
        format!("state {file} --stretch 1.1,1"),
        format!("map {file} --out map"),
        format!("localize {file}"),
        format!("compare {file}"),
    ] {
        let answer = onset_line(&line);
        assert_eq!(answer.code, Some(2), "{line}: {}", answer.stdout);
        let place = format!("{file}:3:1: TB,PRONY: a fraction g is 1.3");
        assert!(answer.stderr.contains(&place), "{line}: {}", answer.stderr);
    }
}
