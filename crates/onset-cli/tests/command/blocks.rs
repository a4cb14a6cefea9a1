//! Blocks of other programs in place of a study, in every command.

use crate::{Scratch, Written, document, onset, onset_line};

const RUBBER: &str = "*MATERIAL, NAME=RUBBER\n*HYPERELASTIC, NEO HOOKE\n0.5, 0.02\n";

#[test]
fn every_command_about_a_law_or_a_method_takes_a_block() {
    let file = Written::new("rubber.inp", RUBBER);
    for line in [
        format!("state {file} --from abaqus --stretch 1.1,1"),
        format!("dispersion {file} --from abaqus --stretch 1.1,1 --wave-vector 1,0.2"),
        format!("path {file} --from abaqus --from 1,1 --to 1.1,1"),
        format!("path {file} --mode uniaxial --to 1.1 --from abaqus"),
        format!("criteria {file} --from abaqus --mode uniaxial"),
        format!("card {file} --from abaqus --mode uniaxial"),
        format!("limit {file} --from abaqus --time-step 0.01 --vary discretization.spacing"),
        format!("tune discretization.support {file} --from abaqus --range 1.9,2.1"),
        format!("modes {file} --from abaqus set lattice=chain"),
        format!("audit {file} --from abaqus"),
        format!(
            "recommend {file} --from abaqus --dimension 1 --set compare.states=2 --stretches 0.9,1.1 --quiet"
        ),
        format!("simulate {file} --from abaqus --stretch 1.1,1 --cells 4 --steps 32 --quiet"),
    ] {
        let answer = onset_line(&line);
        assert!(
            answer.code.is_some_and(|code| code != 2),
            "{line}: {}",
            answer.stderr
        );
        // The shear modulus of the block is twice c10.
        let law = answer.stdout.contains("c10 0.5") || answer.stdout.contains("c10 = 0.5");
        let is_told = line.contains("--quiet") || answer.stdout.contains("material.c10=0.5");
        assert!(law || is_told, "{line}: {}", answer.stdout);
    }
    let read = document(&format!("state {file} --from abaqus --stretch 1.2,0.9"));
    let law = "--set material.model=yeoh --set material.c10=0.5 --set material.c20=0 --set material.c30=0 --set material.kappa=100";
    let set = document(&format!("state {law} --stretch 1.2,0.9"));
    assert_eq!(read["discretization"], set["discretization"]);
    assert_eq!(read["material"], set["material"]);
    let notes = read["notes"].to_string();
    assert!(notes.contains("read from *HYPERELASTIC"), "{notes}");
}

#[test]
fn commands_that_need_axes_explain_why_they_refuse_a_block() {
    let file = Written::new("rubber.inp", RUBBER);
    for line in [
        format!("map {file}"),
        format!("map {file} --from abaqus"),
        format!("boundary {file} --from abaqus"),
        format!("check {file}"),
        format!("check {file} --from abaqus"),
    ] {
        let answer = onset_line(&line);
        assert_eq!(answer.code, Some(2), "{line}: {}", answer.stdout);
        for fact in ["is an input block of abaqus", "[[axes]]", "onset criteria"] {
            assert!(answer.stderr.contains(fact), "{line}: {}", answer.stderr);
        }
    }
    for line in [
        "state",
        "modes",
        "limit --time-step 1 --vary discretization.spacing",
        "recommend",
    ] {
        let answer = onset_line(&format!("{line} {file}"));
        assert_eq!(answer.code, Some(2), "{line}: {}", answer.stdout);
        let hint = "hint: add --from abaqus";
        assert!(answer.stderr.contains(hint), "{line}: {}", answer.stderr);
    }
    let started = onset_line(&format!("path {file} --from abaqus --to 1.1,1"));
    assert_eq!(started.code, Some(2));
    assert!(started.stderr.contains("no start"), "{}", started.stderr);
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
