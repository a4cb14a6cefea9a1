//! Commands for metals beyond yield, crystals and fluids.

use crate::fortran::library;
use crate::{Scratch, assert_close, document, number, onset_line};
use std::time::{Duration, Instant};

/// Steel in GPa with the given slope of the flow stress.
fn steel(modulus: f64) -> String {
    format!(
        "--set material.model=j2 --set material.mu=80 --set material.kappa=170 --set material.yield-stress=0.4 --set material.saturation-stress=0 \
         --set material.hardening-modulus={modulus}"
    )
}

#[test]
fn a_yielding_metal_has_the_stress_of_its_path_and_the_tangent_of_continued_flow() {
    let method = "set method=total-lagrangian-sph";
    let hardening = document(&format!(
        "state --stretch 1.1,0.909090909090909 {}",
        steel(1.0)
    ));
    // Isochoric stretch in plane strain: s1 - s2 = 2/sqrt(3) times the flow stress, e = 2/sqrt(3) ln 1.1 minus the elastic part.
    let cauchy = |i: usize| number(&hardening, &format!("/material/cauchy/{i}/{i}"));
    let root = 2.0 / 3.0_f64.sqrt();
    let slip = (3.0 * 80.0 * root * 1.1_f64.ln() - 0.4) / (3.0 * 80.0 + 1.0);
    assert_close(cauchy(0) - cauchy(1), root * (0.4 + slip), 1e-9);
    let notes = hardening["notes"].to_string();
    assert!(
        notes.contains("elastic-plastic") && notes.contains("tangent of continued loading"),
        "{notes}"
    );
    assert_eq!(hardening["material"]["elliptic"], true);
    let softening = document(&format!(
        "state --stretch 1.1,0.909090909090909 {}",
        steel(-1.0)
    ));
    assert_eq!(
        softening["material"]["elliptic"], false,
        "{}",
        softening["material"]
    );
    let of_particles = onset_line(&format!(
        "state --stretch 1.1,0.909090909090909 {} {method}",
        steel(-1.0)
    ));
    assert_eq!(of_particles.code, Some(0), "{}", of_particles.stderr);
}

#[test]
fn a_map_of_rolled_sheet_can_be_computed() {
    let folder = Scratch::new("rolled");
    std::fs::create_dir_all(&folder).expect("a folder");
    let study = folder.join("sheet.toml");
    let text = "title = \"rolled sheet\"\n[material]\nmodel = \"hill-1948\"\nangle = 20.0\n[discretization]\nmethod = \"total-lagrangian-sph\"\n\
                [[axes]]\nquantity = \"stretch-1\"\nrange = [0.95, 1.05]\nstates = 3\n\
                [[axes]]\nquantity = \"stretch-2\"\nrange = [0.95, 1.05]\nstates = 3\n";
    std::fs::write(&study, text).expect("a study");
    let store = folder.join("map.zarr");
    let line = format!("map {} --out {}", study.display(), store.display());
    let answer = onset_line(&line);
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    assert!(store.join("zarr.json").is_file(), "{}", answer.stdout);
}

/// Beyond yield, the tangent of continued flow is not the derivative of the stress over states that are each reached along a separate path.
#[test]
fn tension_of_a_rolled_sheet_with_free_faces_is_followed_to_the_end_and_has_a_card() {
    let sheet = "--set material.model=hill-1948";
    let answer = document(&format!("path --mode uniaxial --to 1.2 {sheet}"));
    assert_close(number(&answer, "/loading/to"), 1.2, 1e-12);
    assert!(
        answer["loading"]["ends_early"].is_null(),
        "{}",
        answer["loading"]
    );
    let strain = |axis: usize| number(&answer, &format!("/to/{axis}/{axis}")).ln();
    // The ratio of the strains is Lankford's ratio, up to the elastic strain.
    assert_close(strain(1) / strain(2), 1.8, 0.02);
    let begin = Instant::now();
    let card = document(&format!("card --range 0.8,1.25 {sheet}"));
    assert!(card["symmetric_box"]["high"].as_f64() > Some(1.0));
    let notes = card["material"]["notes"].to_string();
    assert!(notes.contains("simple shear is omitted"), "{notes}");
    assert!(begin.elapsed() < Duration::from_secs(90));
}

/// The elastically stored energy of a metal is not a potential of its stress, even if it is a potential at small strains, before yield.
#[test]
fn criteria_of_a_metal_omit_finite_jumps() {
    let sheet = "criteria --mode uniaxial --range 0.9,1.2 --set material.model=hill-1948 --set material.mu=1";
    for yields in ["", " --set material.yield-stress=10"] {
        let answer = document(&format!("{sheet}{yields}"));
        assert_eq!(answer["material"]["isotropic"], false, "{yields}");
        for loading in answer["loadings"].as_array().expect("loadings") {
            let criteria = loading["criteria"].as_array().expect("criteria");
            let jumps = criteria
                .iter()
                .find(|one| one["criterion"] == "rank-one-convexity");
            assert_eq!(jumps.expect("it")["defined"], false, "{yields}");
        }
    }
}

#[test]
fn criteria_of_a_rotated_sheet_are_refused_without_delay() {
    for line in [
        "criteria --set material.model=hill-1948 --set material.angle=20",
        "card --set material.model=hill-1948 --set material.angle=-0.5",
        "criteria --mode simple-shear --set material.model=hill-1948",
    ] {
        let answer = onset_line(line);
        assert_eq!(answer.code, Some(2), "{line}");
        assert!(
            answer.stderr.contains("hint: `onset path --mode uniaxial`"),
            "{}",
            answer.stderr
        );
    }
    let across = onset_line(
        "criteria --mode hydrostatic --range 0.99,1.01 --set material.model=hill-1948 --set material.angle=90",
    );
    assert_eq!(across.code, Some(0), "{}", across.stderr);
}

/// The tangent of a routine belongs to its last increment.
#[test]
fn tension_of_a_metal_umat_with_free_faces_is_followed_to_the_end() {
    let routine = library(&["fortran/j2_plasticity.f90"]);
    for increments in [1, 8] {
        let answer = document(&format!(
            "path --mode uniaxial --to 1.2 --set material.model=umat --set material.library={} --set material.state-variables=1 \
             --set material.properties=200e3,0.3,250,2e3 --set material.increments={increments}",
            routine.display()
        ));
        assert_close(number(&answer, "/loading/to"), 1.2, 1e-12);
        let strain = |axis: usize| number(&answer, &format!("/to/{axis}/{axis}")).ln();
        // Flow preserves the volume: s = y + H (e - s/E), and the lateral strain is -e/2 up to its elastic part.
        let stress = (250.0 + 2e3 * strain(0)) / (1.0 + 2e3 / 200e3);
        let lateral = -0.5 * strain(0) + stress / 200e3 * (0.5 - 0.3);
        for axis in [1, 2] {
            assert_close(strain(axis), lateral, 1e-6);
        }
    }
}

#[test]
fn methods_for_a_fluid_are_sorted_by_cost() {
    let answer =
        onset_line("recommend --dimension 1 --set material.model=tait --set material.mu=0");
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    assert!(!answer.stdout.contains("score inf"), "{}", answer.stdout);
    let at_rest = onset_line(
        "state --stretch 1,1 --set material.model=tait --set material.mu=0 set method=updated-sph",
    );
    assert!(
        !at_rest.stdout.contains("Only the stress of this state"),
        "{}",
        at_rest.stdout
    );
}

#[test]
fn modes_of_a_fluid_are_not_compared_with_shear_waves() {
    for kappa in ["99", "100"] {
        let answer = onset_line(&format!(
            "modes --set material.model=tait --set material.mu=0 --set material.kappa={kappa}"
        ));
        assert!(
            answer.stdout.starts_with(
                "No zero-energy modes. Weak modes are undefined, because the frequency of the material's slowest waves is zero"
            ),
            "{}",
            answer.stdout
        );
    }
}

#[test]
fn the_audit_of_a_fluid_does_not_report_its_missing_shear_modulus_as_a_fault() {
    for law in [
        "--energy (J-1)^2",
        "--set material.model=tait --set material.mu=0",
    ] {
        let answer = onset_line(&format!("audit {law}"));
        assert_eq!(answer.code, Some(0), "{}{}", answer.stdout, answer.stderr);
        assert!(
            answer.stdout.contains("shear modulus 0,") && answer.stdout.contains("as in a fluid"),
            "{}",
            answer.stdout
        );
    }
    // A nearly incompressible law is not a fluid, and neither is a law without a bulk modulus.
    let stiff = "--set material.model=neo-hooke --set material.mu=1 --set material.lambda=1e9";
    for question in ["audit", "state --stretch 1.1,0.95"] {
        let told = onset_line(&format!("{question} {stiff}"));
        assert_eq!(told.code, Some(0), "{}", told.stderr);
        assert!(!told.stdout.contains("fluid"), "{}", told.stdout);
    }
    let soft = onset_line("audit --energy 0.5*(I1/J^(2/3)-3)+0*J");
    assert!(soft.stdout.contains("semidefinite"), "{}", soft.stdout);
    assert!(!soft.stdout.contains("fluid"), "{}", soft.stdout);
    // A negative shear modulus is a fault.
    let negative = onset_line("audit --energy (J-1)^2-(I1-3)");
    assert!(
        negative.stdout.contains("not positive definite"),
        "{}",
        negative.stdout
    );
}

#[test]
fn the_path_of_a_fluid_does_not_contradict_its_note() {
    let fluid = "--set material.model=tait --set material.mu=0";
    let answer = onset_line(&format!(
        "path --mode hydrostatic --from 0.99 --to 0.9 {fluid} set method=updated-sph"
    ));
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    assert!(
        answer.stdout.contains("not strongly elliptic in any state")
            && !answer.stdout.contains("llipticity is not lost"),
        "{}",
        answer.stdout
    );
    let free = onset_line(&format!("path --mode uniaxial --to 1.1 {fluid}"));
    assert_eq!(free.code, Some(2), "{}", free.stdout);
    assert!(free.stderr.contains("--lateral held"), "{}", free.stderr);
}

#[test]
fn laws_without_an_energy_are_not_audited_and_the_answer_gives_the_reason() {
    let answer = onset_line("audit --set material.model=hill-1948");
    assert_eq!(answer.code, Some(2), "{}", answer.stdout);
    assert!(
        answer.stderr.contains("continued flow"),
        "{}",
        answer.stderr
    );
}

#[test]
fn a_fluid_is_reported_as_a_fluid() {
    let fluid = "--set material.model=murnaghan --set material.mu=0 --set material.kappa=2.2";
    let answer = document(&format!(
        "state --stretch 0.97,0.97 {fluid} set method=updated-sph"
    ));
    assert!(
        answer["notes"].to_string().contains("a fluid"),
        "{}",
        answer["notes"]
    );
    assert_eq!(
        answer["material"]["elliptic"], false,
        "{}",
        answer["material"]
    );
    let pressure = -number(&answer, "/material/cauchy/0/0");
    let jacobian = 0.97_f64 * 0.97;
    assert_close(pressure, 2.2 / 7.0 * (jacobian.powi(-7) - 1.0), 1e-12);
    // Water under tension, as in codes of smoothed particle hydrodynamics.
    let named = document(&format!(
        "state --stretch 0.97,0.97 {} set method=updated-sph",
        fluid.replace("murnaghan", "mie-gruneisen")
    ));
    assert!(named["notes"].to_string().contains("a fluid"));
}

#[test]
fn a_negative_poisson_ratio_is_reported_and_a_nearly_incompressible_law_is_not_a_fluid() {
    // Poisson's ratio is (3 K - 2 G) / (6 K + 2 G) = -1.7 / 2.6.
    let law =
        "--set material.model=neo-hooke-isochoric --set material.shear=1 --set material.bulk=0.1";
    for question in [
        "state --stretch 1.01,1",
        "state --stretch 1.01,1 --set material.plane=stress",
        "state --stretch 1.01 --set material.plane=stress set lattice=chain",
        "criteria --mode uniaxial",
        "card --mode uniaxial",
    ] {
        let answer = onset_line(&format!("{question} {law}"));
        assert!(
            answer
                .stdout
                .contains("auxetic: Poisson's ratio at F = 1 is -0.653846"),
            "{question}: {}{}",
            answer.stdout,
            answer.stderr
        );
    }
    let usual = onset_line("state --stretch 1.01,1 --set material.model=neo-hooke");
    assert!(!usual.stdout.contains("auxetic"), "{}", usual.stdout);
    // As the bulk modulus grows, the smallest eigenvalue tends to the smallest eigenvalue of isochoric waves.
    let eigenvalue = |bulk: &str| {
        let state = document(&format!(
            "state --stretch 1.2,0.9 --set material.model=hencky --set material.kappa={bulk}"
        ));
        assert!(!state["notes"].to_string().contains("fluid"), "{state}");
        assert_eq!(state["material"]["elliptic"], true, "{bulk}");
        let below = number(&state, "/material_3d/bound");
        assert!(below > 0.1, "{bulk}: {below}");
        number(&state, "/material/minimum_acoustic_eigenvalue")
    };
    let expected = eigenvalue("1e6");
    for bulk in ["1e9", "1e12"] {
        assert!((eigenvalue(bulk) / expected - 1.0).abs() < 1e-2, "{bulk}");
    }
}

#[test]
fn a_script_of_felupe_gives_the_same_law() {
    let folder = Scratch::new("felupe");
    std::fs::create_dir_all(&folder).expect("a folder");
    let file = folder.join("fit.py");
    let text = "umat = fem.Hyperelastic(fem.yeoh, C10=0.5, C20=-0.05, C30=0.02) & fem.Volumetric(bulk=50)\n";
    std::fs::write(&file, text).expect("a script");
    let answer = onset_line(&format!(
        "criteria {} --from felupe --mode uniaxial --range 0.9,1.1",
        file.display()
    ));
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    for fact in [
        "yeoh of felupe",
        "--set material.c10=0.5",
        "--set material.kappa=50",
        "shear modulus 1",
    ] {
        assert!(answer.stdout.contains(fact), "{fact}: {}", answer.stdout);
    }
}

/// A law that softens has no length: the bands of particles have the normal of the lost ellipticity of the material, a width proportional to the
/// spacing and a growth rate inversely proportional to it.
#[test]
fn bands_of_softening_metals_follow_the_spacing_and_grow_as_predicted() {
    let law = steel(-20.0);
    for method in ["total-lagrangian-sph", "updated-sph", "material-points"] {
        let mut known: Option<[f64; 2]> = None;
        for spacing in [1.0, 0.5, 0.25] {
            let line = format!(
                "--stretch 1.01,0.99 {law} --set discretization.method={method} --set discretization.spacing={spacing}"
            );
            let state = document(&format!("state {line}"));
            assert_eq!(state["verdict"], "physical", "{method}");
            let sentence = state["sentence"].to_string();
            assert!(
                sentence.contains("bands with the normal")
                    && sentence
                        .contains("45.1 degrees from the axis of the largest principal stress")
                    && sentence.contains("do not converge under refinement"),
                "{sentence}"
            );
            let wave = [0, 1].map(|i| number(&state, &format!("/discretization/wave_vector/{i}")));
            let length = wave[0].hypot(wave[1]);
            let angle = wave[1].atan2(wave[0]).to_degrees();
            assert!((angle - 45.0).abs() < 1.0, "{method} {angle}");
            let run = document(&format!("simulate {line}"));
            let [measured, predicted] =
                ["measured/rate", "predicted"].map(|own| number(&run, &format!("/{own}/growth")));
            assert_close(measured / predicted, 1.0, 1e-6);
            let own = [length * spacing, measured * spacing];
            for (own, first) in own.iter().zip(known.get_or_insert(own).iter()) {
                assert_close(own / first, 1.0, 1e-6);
            }
        }
    }
}
