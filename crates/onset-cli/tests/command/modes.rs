//! `onset modes`.

use super::{Scratch, document, number, numbers, onset, onset_line};

#[test]
fn nodal_integration_on_squares_has_three_modes_and_stress_points_have_weak_ones() {
    let nodal = document("modes set lattice=square set quadrature=nodal");
    let modes = nodal["modes"].as_array().expect("modes");
    assert_eq!(modes.len(), 3);
    for mode in modes {
        for component in numbers(mode, "/fractional") {
            assert!((2.0 * component - (2.0 * component).round()).abs() < 1e-12);
        }
        assert_eq!(mode["nullity"], 2);
    }
    assert_eq!(number(&nodal, "/weakest"), 0.0);
    assert_eq!(nodal["zero_extent"], "point");
    assert_eq!(nodal["complete"], true);
    let stress_points = document("modes set lattice=hexagonal");
    assert!(number(&stress_points, "/weakest") > 0.0);
    let first = &stress_points["modes"][0];
    assert_eq!(
        number(first, "/relative_frequency"),
        number(&stress_points, "/weakest")
    );
}

#[test]
fn a_single_mode_of_a_chain_is_no_line_of_them() {
    let answer = onset_line("modes set lattice=chain set quadrature=nodal");
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    assert!(answer.stdout.contains("(1/2)") || answer.stdout.contains("(-1/2)"));
    assert!(!answer.stdout.contains("along a line"), "{}", answer.stdout);
}

#[test]
fn modes_are_exported_to_seed_a_simulation() {
    let folder = Scratch::new("modes");
    let out = folder.display().to_string();
    let arguments = [
        "modes",
        "--set",
        "discretization.quadrature=nodal",
        "--set",
        "discretization.lattice=simple-cubic",
        "--cells",
        "4",
        "--out",
        &out,
    ];
    let answer = onset(&arguments);
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    assert!(
        answer.stdout.contains("wrote 37 files"),
        "{}",
        answer.stdout
    );
    let csv = std::fs::read_to_string(folder.join("mode-7.csv")).expect("a file");
    assert_eq!(csv.lines().count(), 65);
    let vtk = std::fs::read_to_string(folder.join("mode-1.vtk")).expect("a file");
    assert!(vtk.contains("POINTS 64 double") && vtk.contains("VECTORS displacement double"));
    let page = std::fs::read_to_string(folder.join("modes.html")).expect("a file");
    assert_eq!(page.matches("<figure>").count(), 17);
}

#[test]
fn questions_that_are_wrong_are_refused() {
    for (line, fact) in [
        ("modes --weak 0", "above 0 and at most 1"),
        ("modes --weak nan", "above 0 and at most 1"),
        ("modes --amplitude 2", "above 0 and at most 1"),
        ("modes --cells 0", "1..=512"),
        (
            "modes --cells 512 set lattice=simple-cubic",
            "choose fewer --cells",
        ),
        (
            "modes set method=peridynamics set horizon=0.5",
            "a particle has 0 bond(s) within the horizon 0.5",
        ),
        (
            "modes set method=peridynamics set horizon=400",
            "reduce discretization.horizon",
        ),
        (
            "modes set method=total-lagrangian-sph set penalty=-1",
            "zero or a positive",
        ),
        ("modes set method=spectral", "kernel | total-lagrangian-sph"),
        (
            "modes set method=finite-elements set mesh=hexagons",
            "quadrilaterals",
        ),
    ] {
        let answer = onset_line(line);
        assert_eq!(answer.code, Some(2), "{line}: {}", answer.stderr);
        assert_eq!(answer.stdout, "", "{line}");
        assert!(answer.stderr.contains(fact), "{line}: {}", answer.stderr);
    }
}
