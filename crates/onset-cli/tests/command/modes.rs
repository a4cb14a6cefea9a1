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
fn states_say_what_resists_alternating_neighbors_whatever_cell_they_are_told_of() {
    let lagrangian = "state --stretch 1.4,0.8 set method=tlsph set lattice=square";
    for cells in [2, 4] {
        let text = onset_line(&format!("{lagrangian} set cells={cells}")).stdout;
        assert!(
            text.contains("where neighbors alternate. Nothing resists that"),
            "{text}"
        );
    }
    // Bonds along one axis are stretched, those along the other are not.
    let bonds = "state --stretch 1.05,1 set method=pd set lattice=square set horizon=1";
    let text = onset_line(bonds).stdout;
    assert!(
        text.contains("resists some of these waves, and nothing the others"),
        "{text}"
    );
    let text = onset_line(&bonds.replace("1.05,1 ", "1.05,1.02 ")).stdout;
    assert!(
        text.contains("Only the stress of this state resists"),
        "{text}"
    );
}

#[test]
fn a_weak_mode_of_a_larger_cell_is_told_as_the_wave_that_it_is() {
    let line = "set method=tlsph set lattice=square set penalty=0.02";
    let text = onset_line(&format!("modes {line} set cells=2")).stdout;
    assert!(
        text.contains("1.9 % of the material's frequency, as the wave (1, 0)"),
        "{text}"
    );
    let one = onset_line(&format!("modes {line}")).stdout;
    assert!(
        one.contains("1.9 %") && !one.contains("as the wave"),
        "{one}"
    );
    // States tell the same, of all cells and at all stretches.
    for stretch in ["1,1", "1.1,0.95"] {
        for cells in 1..=3 {
            let text = onset_line(&format!(
                "state --stretch {stretch} {line} set cells={cells}"
            ))
            .stdout;
            let told = "a wave, wavelength 2 along (1, 0), has 0.0194567 times the frequency";
            assert!(text.contains(told), "{text}");
        }
    }
    // What cannot be tuned is not recommended to be.
    let next = |cells: u32| {
        let line = format!("state --stretch 1.2,1 set frame=eulerian set cells={cells}");
        onset_line(&line).stdout.contains("onset tune")
    };
    assert!(next(1) && !next(2));
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
