//! `onset modes`.

use super::{Scratch, document, number, numbers, onset, onset_line};

#[test]
fn nodal_integration_on_squares_has_three_zero_energy_modes_and_stress_points_have_weak_modes() {
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
    let stress_points = document("modes --weak 0.5 set lattice=hexagonal");
    assert!(number(&stress_points, "/weakest") > 0.0);
    let first = &stress_points["modes"][0];
    assert_eq!(
        number(first, "/relative_frequency"),
        number(&stress_points, "/weakest")
    );
}

#[test]
fn kinds_in_the_table_of_modes_are_words_without_numbers() {
    for (line, kind) in [
        ("modes set lattice=hexagonal", "weakly controlled"),
        (
            "modes set lattice=square set quadrature=nodal",
            "zero energy",
        ),
    ] {
        let table = onset_line(&format!("{line} --format csv")).stdout;
        let mut rows = table.lines();
        assert!(rows.next().is_some_and(|head| head.ends_with(",kind")));
        let kinds: Vec<_> = rows.filter_map(|row| row.rsplit(',').next()).collect();
        assert!(
            kinds.len() >= 3 && kinds.iter().all(|own| *own == kind),
            "{table}"
        );
    }
}

#[test]
fn a_single_mode_of_a_chain_is_not_reported_as_a_line() {
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
        answer.stdout.contains("wrote 38 files"),
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
fn states_report_the_resistance_to_alternating_neighbors() {
    // Bonds along one axis are stretched, and those along the other axis are not.
    let bonds = "state --stretch 1.05,1 set method=pd set lattice=square set horizon=1";
    let text = onset_line(bonds).stdout;
    assert!(
        text.contains("resists some of these waves, and no force resists the others"),
        "{text}"
    );
    let text = onset_line(&bonds.replace("1.05,1 ", "1.05,1.02 ")).stdout;
    assert!(
        text.contains("Only the stress of this state resists"),
        "{text}"
    );
}

#[test]
fn a_weak_mode_of_a_larger_cell_is_reported_with_its_actual_wave_vector() {
    let line = "set method=tlsph set lattice=square set penalty=0.02";
    // Particle offsets too small to be displayed prevent the reduction to the primitive cell.
    let text = onset_line(&format!("modes {line} set cells=2 set perturbation=1e-9")).stdout;
    assert!(
        text.contains("1.9 % of the material's frequency, as the wave (1, 0)"),
        "{text}"
    );
    let one = onset_line(&format!("modes {line}")).stdout;
    assert!(
        one.contains("1.9 %") && !one.contains("as the wave"),
        "{one}"
    );
    // States agree, for all cells and at all stretches.
    for stretch in ["1,1", "1.1,0.95"] {
        for cells in ["1", "2 set perturbation=1e-9", "3"] {
            let text = onset_line(&format!(
                "state --stretch {stretch} {line} set cells={cells}"
            ))
            .stdout;
            let told = "a wave (wavelength 2 along (1, 0)) has 1.94567 % of the frequency";
            assert!(text.contains(told), "{text}");
        }
    }
    // Tuning is suggested only if a coefficient can be tuned.
    let next = |cells: &str| {
        let line = format!("state --stretch 1.2,1 set frame=eulerian set cells={cells}");
        onset_line(&line).stdout.contains("onset tune")
    };
    assert!(next("1") && next("2") && !next("2 set perturbation=0.01"));
}

/// JSON answer without settings and notes, which describe the cell.
fn without_cell(line: &str) -> serde_json::Value {
    let mut value = document(line);
    for own in ["settings", "notes", "next", "reduced_cell"] {
        value.as_object_mut().expect("an object").remove(own);
    }
    if let Some(own) = value.get_mut("discretization") {
        own.as_object_mut()
            .expect("an object")
            .remove("reduced_cell");
    }
    value
}

/// Returns true if two values agree to rounding.
fn is_alike(a: &serde_json::Value, b: &serde_json::Value) -> bool {
    use serde_json::Value::{Array, Number, Object};
    match (a, b) {
        (Number(a), Number(b)) => {
            let [a, b] = [a, b].map(|own| own.as_f64().unwrap_or(f64::NAN));
            (a - b).abs() <= 1e-7 * (1.0 + a.abs())
        }
        (Array(a), Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| is_alike(a, b)),
        (Object(a), Object(b)) => {
            a.len() == b.len()
                && a.iter()
                    .all(|(key, a)| b.get(key).is_some_and(|b| is_alike(a, b)))
        }
        _ => a == b,
    }
}

#[test]
fn answers_do_not_depend_on_the_cell_that_describes_a_crystal() {
    for (line, [verdict, mechanism], k) in [
        (
            "--stretch 1.1,0.95 --set material.model=blatz-ko set method=updated-sph set support=1.6 set lattice=square",
            ["numerical", "tensile"],
            [std::f64::consts::PI, 0.0],
        ),
        (
            "--stretch 0.92,0.84 set method=updated-sph set support=1.65 set lattice=hexagonal",
            ["numerical", "long-wave"],
            [2.759_165_1, 0.0],
        ),
        (
            "--stretch 1.1,0.95 --set material.model=blatz-ko set method=tlsph set support=1.8 set penalty=0.1 set lattice=square",
            ["stable", ""],
            [std::f64::consts::PI, 0.0],
        ),
        (
            "--stretch 1.1,0.95 --set material.model=blatz-ko set method=tlsph set support=1.8 set lattice=square",
            ["zero-energy", ""],
            [std::f64::consts::PI, 0.0],
        ),
    ] {
        let one = without_cell(&format!("state {line}"));
        assert_eq!(one["verdict"], verdict, "{line}");
        assert_eq!(one["mechanism"].as_str().unwrap_or(""), mechanism, "{line}");
        let wave = &one["discretization"]["wave_vector"];
        for i in 0..2 {
            assert!(
                (wave[i].as_f64().expect("a number") - k[i]).abs() < 1e-6,
                "{line} {wave}"
            );
        }
        let several = format!("state {line} set cells=2");
        assert!(is_alike(&one, &without_cell(&several)), "{line}");
        let text = onset_line(&several).stdout;
        assert!(
            text.contains(
                "note: the cell of 4 particles is not primitive: it repeats a cell of 1 particle"
            ),
            "{text}"
        );
    }
    // Other cells and bases of the square lattice give the same answer.
    let square = without_cell("state --stretch 1.1,0.95 set method=updated-sph set lattice=square");
    for cell in [
        "set lattice=oblique set vectors=2,0,0,1 set basis=0.5,0",
        "set lattice=oblique set vectors=1,1,1,-1 set basis=0.5,0.5",
        "set lattice=oblique set vectors=1,3,0,1",
    ] {
        let own = without_cell(&format!(
            "state --stretch 1.1,0.95 set method=updated-sph {cell}"
        ));
        assert!(is_alike(&square, &own), "{cell}");
    }
    // A honeycomb defined by lattice and basis has the same spacing, which is the unit of horizons.
    let bonds = "--stretch 1.1,0.95 set method=peridynamics set horizon=2.1";
    let honeycomb = without_cell(&format!("state {bonds} set lattice=honeycomb"));
    let vectors = "1.7320508075688772,0,0.8660254037844386,1.5";
    let own = format!(
        "state {bonds} set lattice=oblique set vectors={vectors} set basis=0.3333333333333333,0.3333333333333333"
    );
    assert!(is_alike(&honeycomb, &without_cell(&own)));
    // Modes and bands agree too.
    for line in [
        "modes set method=tlsph set lattice=square",
        "dispersion --stretch 1.1,1 --wave-vector 1,0.3 set method=updated-sph set lattice=square",
    ] {
        assert!(
            is_alike(
                &without_cell(line),
                &without_cell(&format!("{line} set cells=2"))
            ),
            "{line}"
        );
    }
}

#[test]
fn a_displacement_field_that_jumps_at_the_patch_boundary_is_reported_with_a_fitting_patch() {
    let folder = Scratch::new("misfit");
    let out = folder.display().to_string();
    let line = format!(
        "modes --cells 3 set method=peridynamics set bonds=correspondence set horizon=2 set lattice=square --out {out}"
    );
    let answer = onset_line(&line);
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    let text = &answer.stdout;
    let fact = "fields that do not fit 3 cells jump at the periodic boundary: modes 5, 6, 9 fit 2 cells; mode 1 nearly fits 13 cells, as (0, 5/13) with";
    assert!(text.contains(fact), "{text}");
    assert_eq!(text.matches("periodic boundary").count(), 1, "{text}");
    let vtk = std::fs::read_to_string(folder.join("mode-1.vtk")).expect("a file");
    assert!(vtk.contains("does not fit 3 cells"), "{vtk}");
    for mode in document(&line)["modes"].as_array().expect("modes") {
        let fractional = mode["fractional"].as_array().expect("a wave");
        let cells = mode["fit"]["cells"].as_f64().expect("a number");
        let fits = fractional.iter().all(|x| {
            let turns = x.as_f64().expect("a number") * cells;
            (turns - turns.round()).abs() < 1e-5
        });
        assert_eq!(mode["fits"], false);
        assert_eq!(fits, mode["fit"]["error"] == 0.0, "{mode}");
    }
    let even = onset_line(&line.replace("--cells 3", "--cells 4")).stdout;
    assert!(!even.contains(" 2 cells"), "{even}");
}

#[test]
fn invalid_options_of_modes_are_refused() {
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
            "a number from 0 to 1e6",
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

#[test]
fn state_modes_and_tune_report_the_same_weakest_wave_and_limit() {
    let hexagons = "set method=peridynamics set lattice=hexagonal set bonds=correspondence set control=penalty \
                    set control-coefficient=0.1 set horizon=2 --set material.model=blatz-ko";
    let modes = document(&format!("modes {hexagons}"));
    let state = document(&format!("state --stretch 1,1 {hexagons}"));
    let weakest = number(&modes, "/weakest");
    assert!((weakest - 0.092_460_7).abs() < 1e-6, "{weakest}");
    let own = "/discretization/weakest_mode/relative_frequency";
    assert_eq!(number(&state, own), weakest);
    assert_eq!(number(&state, "/discretization/weakest_mode/weak"), 0.1);
    let sentence = |line: &str| {
        document(line)["sentence"]
            .as_str()
            .expect("a text")
            .to_owned()
    };
    let usual = sentence(&format!("state --stretch 1,1 {hexagons}"));
    assert!(usual.contains("Weakly controlled"), "{usual}");
    let lower = sentence(&format!("state --stretch 1,1 --weak 0.09 {hexagons}"));
    assert!(!lower.contains("Weakly controlled"), "{lower}");
    // The tuned value is sufficient in a state, too.
    let points = "set support=1.7 set approximation=mls --set material.model=blatz-ko";
    let tuned = document(&format!(
        "tune discretization.stress-point-weight --range 0.05,0.95 {points}"
    ));
    let value = number(&tuned, "/recommended");
    assert!((value - 0.305_17).abs() < 5e-5, "{value}");
    let state = document(&format!(
        "state --stretch 1,1 {points} set stress-point-weight={value}"
    ));
    assert!(number(&state, own) >= 0.1, "{state}");
}

#[test]
fn the_remedy_for_zero_energy_modes_of_material_points_removes_them() {
    let points =
        "state --stretch 1.02,0.99 set method=mpm set lattice=square set unknowns=particles";
    for (given, remedy) in [
        ("set transfer=flip", "flip-share=0.99 or transfer=apic"),
        (
            "set transfer=flip set points-per-side=1",
            "transfer=apic and points-per-side=2",
        ),
    ] {
        let answer = document(&format!("{points} {given}"));
        assert_eq!(answer["verdict"], "zero-energy", "{given}");
        let sentence = answer["sentence"].as_str().expect("a text");
        let names = remedy.replace(" or ", " or discretization.");
        let names = names.replace(" and ", " and discretization.");
        let expected = format!("With discretization.{names} no wave");
        assert!(sentence.contains(&expected), "{sentence}");
        assert!(
            sentence.contains("FLIP codes run with these modes"),
            "{sentence}"
        );
        for choice in remedy.split(" or ") {
            let set = choice.replace(" and ", " set ");
            let changed = document(&format!("{points} {given} set {set}"));
            assert_eq!(changed["verdict"], "stable", "{set}");
        }
    }
}
