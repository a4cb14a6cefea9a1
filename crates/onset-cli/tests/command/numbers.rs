//! Reference values, as the command prints them.

use crate::{assert_close, document, number, numbers, onset_line};

fn omega_squared(line: &str) -> [f64; 2] {
    let waves = document(line);
    [0, 1].map(|i| {
        assert_eq!(number(&waves, &format!("/omega_squared/{i}/im")), 0.0);
        number(&waves, &format!("/omega_squared/{i}/re"))
    })
}

#[test]
fn the_material_loses_ellipticity_at_the_reference_value() {
    let uniaxial = document("path --from 1,1 --to 1,3");
    assert_close(
        number(&uniaxial, "/material_onset/stretch/1"),
        2.754613297216,
        1e-10,
    );
    let equal = document("path --from 1,1 --to 3,3");
    for axis in 0..2 {
        assert_close(
            number(&equal, &format!("/material_onset/stretch/{axis}")),
            1.669770460567,
            1e-10,
        );
    }
}

#[test]
fn lagrangian_particles_become_unstable_with_the_material_for_any_support() {
    for support in ["1.6", "2.0", "2.5", "3.0"] {
        let path = document(&format!("path --from 1,1 --to 1,3 set support={support}"));
        let material = number(&path, "/material_onset/stretch/1");
        assert_close(material, 2.754613297216, 1e-10);
        let particles = number(&path, "/discretization_onset/stretch/1");
        assert_close(particles, material, 1e-8);
    }
}

#[test]
fn waves_without_a_state_are_waves_of_the_reference_configuration() {
    for waves in ["--wave-vector 1,0", "--path G-M"] {
        let told = onset_line(&format!("dispersion {waves}")).stdout;
        assert!(told.contains("the reference configuration"), "{told}");
        let same = onset_line(&format!("dispersion {waves} --stretch 1,1")).stdout;
        assert_eq!(told, same);
        let other = onset_line(&format!("dispersion {waves} --stretch 1.2,1")).stdout;
        assert!(other.contains("stretches (1.2,"), "{other}");
    }
}

#[test]
fn a_long_path_lists_the_return_to_stability() {
    let path = document("path --from 1,1 --to 12,12");
    for crossings in ["material_crossings", "discretization_crossings"] {
        assert_eq!(path[crossings].as_array().map(Vec::len), Some(2));
        assert_eq!(path[crossings][1]["to"], "stable");
        for axis in 0..2 {
            let place = format!("/{crossings}/1/stretch/{axis}");
            assert_close(number(&path, &place), 8.720585648, 1e-9);
        }
    }
}

#[test]
fn waves_of_the_default_method_agree_with_the_reference() {
    let [soft, stiff] = omega_squared("dispersion --stretch 1.2,0.9 --wave-vector 2.0,1.1");
    assert_close(soft, 0.0962355954645, 1e-11);
    assert_close(stiff, 10.9844782757, 1e-11);
}

#[test]
fn waves_of_the_eulerian_kernel_agree_with_the_reference() {
    // The reference gives the spatial wave vector (2.0, 1.1); the command uses the reference wave vector, F^T times it.
    let [soft, stiff] = omega_squared(
        "dispersion --stretch 1.2,0.9 --wave-vector 2.4,0.99 set frame=eulerian set current-lattice=convected \
         set linearization=exact",
    );
    assert_close(soft, 0.1245420641, 1e-9);
    assert_close(stiff, 12.9706992388, 1e-9);
}

#[test]
fn the_tensile_instability_of_the_eulerian_kernel_agrees_with_the_reference() {
    let state = document(
        "state --stretch 1.2,1.0 set frame=eulerian set support=1.6 set support-size=fixed \
         set current-lattice=convected set linearization=exact",
    );
    assert_eq!(state["verdict"], "numerical");
    assert_close(
        number(&state, "/discretization/minimum_omega_squared/re"),
        -0.8210988005,
        1e-9,
    );
}

#[test]
fn a_rotation_of_the_state_changes_no_frequency() {
    // The state is rotated by a quarter turn after the deformation, before it (with the wave, on a lattice with this symmetry), or both.
    for frame in ["lagrangian", "eulerian"] {
        let waves = |f: &str, k: &str| {
            omega_squared(&format!(
                "dispersion --deformation-gradient={f} --wave-vector={k} set lattice=square set frame={frame}"
            ))
        };
        let expected = waves("1.2,0.1,0,0.9", "2.0,1.1");
        for (f, k) in [
            ("0,-0.9,1.2,0.1", "2.0,1.1"),
            ("-0.1,1.2,-0.9,0", "-1.1,2.0"),
            ("0.9,0,-0.1,1.2", "-1.1,2.0"),
        ] {
            for (rotated, expected) in waves(f, k).into_iter().zip(expected) {
                assert_close(rotated, expected, 1e-11);
            }
        }
    }
}

#[test]
fn nodal_integration_has_zero_energy_modes_in_compression() {
    for kind in ["square", "hexagonal"] {
        for stretches in ["0.8,0.9", "0.6,0.6", "1,0.7"] {
            let line =
                format!("state --stretch {stretches} set quadrature=nodal set lattice={kind}");
            assert_eq!(document(&line)["verdict"], "zero-energy", "{line}");
        }
    }
}

#[test]
fn stretches_and_a_diagonal_deformation_gradient_are_the_same_state() {
    for settings in [
        "",
        "set frame=eulerian",
        "set lattice=square set background=interpolated",
    ] {
        for (stretches, components) in [
            ("1.2,0.9", "1.2,0,0,0.9"),
            ("0.7,1.1", "0.7,0,0,1.1"),
            ("1.2,0.9,1.05", "1.2,0,0,0,0.9,0,0,0,1.05"),
        ] {
            assert_eq!(
                document(&format!("state --stretch {stretches} {settings}")),
                document(&format!(
                    "state --deformation-gradient {components} {settings}"
                )),
            );
        }
    }
}

#[test]
fn spaces_around_numbers_and_repeated_settings_are_accepted() {
    let spaced = crate::onset(&["state", "--stretch", " 1.2 , 0.9 ", "--json"]);
    assert_eq!(
        spaced.stdout,
        onset_line("state --stretch 1.2,0.9 --json").stdout
    );
    assert_eq!(
        document("state --stretch 1.2,0.9 set support=3 set support=1.6"),
        document("state --stretch 1.2,0.9 set support=1.6"),
    );
}

#[test]
fn answers_do_not_depend_on_units() {
    let reference = document("state --stretch 1.2,0.9");
    for settings in ["set spacing=1e-6", "set spacing=1e3", "set density=7850"] {
        let state = document(&format!("state --stretch 1.2,0.9 {settings}"));
        assert_eq!(state["verdict"], reference["verdict"]);
        let scaled = "/discretization/minimum_scaled";
        assert_close(number(&state, scaled), number(&reference, scaled), 1e-9);
    }
}

#[test]
fn the_softest_direction_does_not_depend_on_the_unit_of_stress() {
    let state = |mu: &str| {
        document(&format!(
            "state --stretch 1.2,0.9 --set material.model=blatz-ko --set material.mu={mu}"
        ))
    };
    let reference = state("1");
    for mu in ["1e7", "1e20", "1e-7", "1e-20"] {
        let scaled = state(mu);
        assert_eq!(scaled["verdict"], reference["verdict"], "{mu}");
        assert_close(
            number(&scaled, "/material/minimum_acoustic_eigenvalue")
                / mu.parse::<f64>().expect("a number"),
            number(&reference, "/material/minimum_acoustic_eigenvalue"),
            1e-9,
        );
    }
}

#[test]
fn particles_without_neighbors_along_an_axis_have_zero_energy_modes() {
    // Columns of particles 25 apart with a support of 2: no wave across them has any energy.
    let line = "--stretch 50,0.02 set frame=eulerian";
    let [soft, stiff] = omega_squared(&format!("dispersion {line} --wave-vector 1.1,0"));
    assert!(soft.abs().max(stiff.abs()) < 1e-20, "{soft}, {stiff}");
    let state = document(&format!("state {line}"));
    assert_eq!(state["verdict"], "zero-energy");
}

#[test]
fn lagrangian_kernels_never_miss_an_instability() {
    for stretches in ["1e-10,1", "1e10,1e10", "1e-10,1e-10", "1e50,1"] {
        let answer = onset_line(&format!("state --stretch {stretches}"));
        assert!(!answer.stdout.contains("Stable although"), "{stretches}");
    }
}

#[test]
fn stretches_of_a_rotated_path_are_principal_stretches() {
    let path = document("path --from=0,1,-1,0 --to=0,3,-3,0");
    for axis in numbers(&path, "/material_onset/stretch") {
        assert_close(axis, 1.669770460567, 1e-10);
    }
}

#[test]
fn long_waves_of_complete_functions_agree_with_the_continuum_on_both_lattices() {
    for lattice in ["convected", "regular"] {
        let answer = document(&format!(
            "dispersion --stretch 0.7,0.8 --wave-vector 0.01,0.004 --set material.model=blatz-ko \
             --set discretization.frame=eulerian --set discretization.approximation=mls \
             --set discretization.support=2.3 --set discretization.support-size=convected \
             --set discretization.current-lattice={lattice}"
        ));
        for branch in 0..2 {
            let particles = answer["omega_squared"][branch]["re"]
                .as_f64()
                .expect("a number");
            let continuum = answer["continuum_omega_squared"][branch]
                .as_f64()
                .expect("a number");
            assert!(
                (particles / continuum - 1.0).abs() < 1e-3,
                "{lattice}: {particles} {continuum}"
            );
        }
    }
}
