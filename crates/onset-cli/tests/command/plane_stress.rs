//! Plane stress: answers for a sheet, compared with plane strain and reduced constants, and refusals.

use super::{Scratch, assert_close, document, number, numbers, onset_line};
use serde_json::Value;

/// Lamé constants in 3D.
const MU: f64 = 1.0;
const LAMBDA: f64 = 6.0;

/// The Saint-Venant-Kirchhoff law in plane stress.
fn sheet() -> String {
    format!(
        "--set material.model=saint-venant-kirchhoff --set material.mu={MU} --set material.lambda={LAMBDA} --set material.plane=stress"
    )
}

/// The same sheet in plane strain. In 2D the law keeps its form with `2 lambda mu / (lambda + 2 mu)`, so that both agree except for out-of-plane
/// components.
fn by_hand() -> String {
    let lambda = 2.0 * LAMBDA * MU / (LAMBDA + 2.0 * MU);
    format!(
        "--set material.model=saint-venant-kirchhoff --set material.mu={MU} --set material.lambda={lambda}"
    )
}

fn ask(command: &str, law: &str) -> Value {
    document(&format!("{command} {law}"))
}

fn assert_same(one: &Value, other: &Value, pointer: &str) {
    let (one, other) = (number(one, pointer), number(other, pointer));
    let scale = one.abs().max(other.abs()).max(1e-6);
    assert!(
        (one - other).abs() <= 1e-9 * scale,
        "{pointer}: {one} {other}"
    );
}

const METHODS: [&str; 5] = [
    "set method=total-lagrangian-sph set lattice=square",
    "set frame=eulerian set support=1.6",
    "set method=updated-sph",
    "set method=finite-elements",
    "set method=material-points",
];

#[test]
fn states_of_a_sheet_equal_states_in_plane_strain_with_reduced_constants() {
    for method in METHODS {
        for state in ["1,1", "1.1,0.95", "0.8,1"] {
            let state = format!("state --stretch {state} {method}");
            let (own, expected) = (ask(&state, &sheet()), ask(&state, &by_hand()));
            assert_eq!(own["verdict"], expected["verdict"], "{state}");
            for pointer in [
                "/discretization/maximum_omega",
                "/discretization/critical_time_step",
                "/discretization/minimum_omega_squared/re",
                "/discretization/growth_rate",
                "/discretization/long_wave_minimum_scaled",
                "/material/minimum_acoustic_eigenvalue",
                "/material/first_piola/0/0",
                "/material/tangent/0/0/1/1",
                "/material/tangent/0/1/0/1",
            ] {
                assert_same(&own, &expected, pointer);
            }
            assert_eq!(own["settings"]["material.plane"]["value"], "stress");
            assert!(own.get("material_3d").is_none() && expected.get("material_3d").is_some());
            // Expected strain: E33 = -lambda/(lambda + 2 mu) (E11 + E22), and zero out-of-plane stress.
            let f = |i: usize| numbers(&own, &format!("/deformation_gradient/{i}"))[i];
            let strain = |i: usize| 0.5 * (f(i) * f(i) - 1.0);
            let expected = -LAMBDA / (LAMBDA + 2.0 * MU) * (strain(0) + strain(1));
            assert!((strain(2) - expected).abs() < 1e-13, "{state}");
            assert_eq!(number(&own, "/material/cauchy/2/2"), 0.0);
        }
    }
}

#[test]
fn paths_dispersion_and_motions_of_a_sheet_agree_with_plane_strain_for_reduced_constants() {
    let elements = "set method=finite-elements";
    let path = format!("path --from 1,1 --to 0.5,1 {elements}");
    let (own, expected) = (ask(&path, &sheet()), ask(&path, &by_hand()));
    for pointer in [
        "/material_onset/parameter",
        "/discretization_onset/parameter",
    ] {
        let (own, expected) = (number(&own, pointer), number(&expected, pointer));
        assert!((own - expected).abs() < 1e-7, "{pointer}: {own} {expected}");
    }
    let waves = format!("dispersion --stretch 1.1,0.9 --wave-vector 1.1,0.4 {elements}");
    let (own, expected) = (ask(&waves, &sheet()), ask(&waves, &by_hand()));
    for pointer in ["/omega_squared/0/re", "/omega_squared/1/re"] {
        assert_same(&own, &expected, pointer);
    }
    // Forces on a patch, integrated in time without any tangent.
    let run = "simulate --stretch 0.72,1 --cells 8 set method=total-lagrangian-sph set lattice=square \
               set penalty=0";
    let (own, expected) = (ask(run, &sheet()), ask(run, &by_hand()));
    assert_eq!(own["outcome"], expected["outcome"]);
    for pointer in ["/predicted/rate", "/measured/rate"] {
        if own.pointer(pointer).is_some_and(Value::is_number) {
            let (own, expected) = (number(&own, pointer), number(&expected, pointer));
            assert_close(own, expected, 1e-6);
        }
    }
}

#[test]
fn a_compressed_sheet_gives_a_note_on_buckling() {
    // Shear alone compresses along a diagonal.
    for (state, is_compressed) in [
        ("--stretch 1.1,1.05", false),
        ("--stretch 1.1,0.8", true),
        ("--deformation-gradient 1,0.1,0.1,1", true),
        ("--stretch 1,1", false),
    ] {
        let answer = onset_line(&format!("state {state} {}", sheet()));
        let is_said = answer.stdout.contains("the sheet is compressed");
        assert_eq!(is_said, is_compressed, "{state}: {}", answer.stdout);
    }
}

#[test]
fn sentences_about_a_sheet_mention_plane_stress() {
    let answer = onset_line(&format!("state --stretch 1.1,1 {}", sheet()));
    assert!(answer.stdout.contains("plane stress"), "{}", answer.stdout);
    assert!(
        answer.stdout.contains("thickness stretch     F33 0.91"),
        "{}",
        answer.stdout
    );
    assert!(!answer.stdout.contains("in 3D"), "{}", answer.stdout);
    let certified = onset_line(&format!("state --stretch 1.1,1 --certify {}", sheet()));
    assert!(
        certified
            .stdout
            .contains("material              proved-stable"),
        "{}",
        certified.stdout
    );
    assert!(!certified.stdout.contains("in 3D"), "{}", certified.stdout);
    // Beyond the loss of ellipticity in compression the next command concerns the law in 3D.
    let lost = onset_line(&format!(
        "state --stretch 0.5,1 {} set method=finite-elements",
        sheet()
    ));
    let next = lost
        .stdout
        .lines()
        .find(|line| line.contains("onset criteria"));
    assert!(
        next.is_some_and(|line| !line.contains("plane")),
        "{}",
        lost.stdout
    );
}

#[test]
fn bars_are_in_uniaxial_stress() {
    let bar = format!(
        "{} set method=total-lagrangian-sph set lattice=chain",
        sheet()
    );
    let state = ask("state --stretch 1.2", &bar);
    assert_eq!(state["notes"].as_array().map(Vec::len), Some(0));
    // Expected stress: P = E lambda (lambda^2 - 1)/2 with Young's modulus E.
    let young = MU * (3.0 * LAMBDA + 2.0 * MU) / (LAMBDA + MU);
    assert_close(
        number(&state, "/material/first_piola/0/0"),
        young * 1.2 * 0.22,
        1e-12,
    );
    let f = |i: usize| numbers(&state, &format!("/deformation_gradient/{i}"))[i];
    let poisson = 0.5 * LAMBDA / (LAMBDA + MU);
    assert_close(f(1), (1.0 - 2.0 * poisson * 0.22_f64).sqrt(), 1e-12);
    assert_close(f(1), f(2), 1e-13);
    // Sound speed of a bar, sqrt(E/rho), for long waves.
    let waves = ask("dispersion --stretch 1 --wave-vector 1e-3", &bar);
    assert_close(number(&waves, "/omega_squared/0/re"), young * 1e-6, 1e-4);
    let text = onset_line(&format!("state --stretch 1.2 {bar}"));
    assert!(text.stdout.contains("uniaxial stress"), "{}", text.stdout);
}

#[test]
fn loadings_with_a_free_third_face_are_followed_in_the_plane() {
    let law = "--set material.model=neo-hooke --set material.mu=1 --set material.lambda=5 set method=finite-elements";
    for loading in [
        "--mode uniaxial",
        "--mode equibiaxial",
        "--mode planar",
        "--mode simple-shear",
    ] {
        let line = format!("path {loading} --to 1.4 {law}");
        let (space, sheet) = (ask(&line, ""), ask(&line, "--set material.plane=stress"));
        assert_eq!(space["loading"], sheet["loading"]);
        for row in 0..3 {
            let pointer = format!("/to/{row}");
            let (own, expected) = (numbers(&sheet, &pointer), numbers(&space, &pointer));
            for (own, expected) in own.iter().zip(expected) {
                assert!((own - expected).abs() < 1e-10, "{line}: {own} {expected}");
            }
        }
    }
}

#[test]
fn settings_that_contradict_plane_stress_are_refused_with_a_hint() {
    let neo = "--set material.model=neo-hooke --set material.plane=stress";
    let three = "set lattice=simple-cubic set support=1.65";
    for (line, fact) in [
        (
            format!("state --stretch 1,1,1 {neo}"),
            "in plane stress the stretch across the sheet is computed",
        ),
        (
            format!("state --stretch 1,1,0.9 {neo}"),
            "set material.plane=strain",
        ),
        (
            format!("state --deformation-gradient 1,0,0,0,1,0,0,0,0.9 {neo}"),
            "expected 4: in plane stress",
        ),
        (
            format!("path --from 1,1 --to 1,1.2,0.9 {neo}"),
            "in plane stress",
        ),
        (
            format!("state --stretch 1,1,1 {three} {neo}"),
            "has three dimensions",
        ),
        (
            "state --stretch 1.1,1 --set material.model=hypoelastic-jaumann --set material.plane=stress".to_owned(),
            "not supported with hypoelastic-jaumann",
        ),
        (
            "state --stretch 1.1,1 --energy K*(J-ln(J)) --set material.K=2 --set material.plane=stress".to_owned(),
            "as for a fluid",
        ),
        (
            format!("state --stretch 1.1,1 {neo} --set material.plane=bending"),
            "expected strain | stress",
        ),
        (
            format!("path --mode uniaxial --lateral plane-strain --to 1.2 {neo}"),
            "a sheet in plane stress",
        ),
        (
            format!("path --mode hydrostatic --to 1.2 {neo}"),
            "set material.plane=strain",
        ),
        (
            format!("path --mode equibiaxial --to 1.2 {neo} set lattice=chain"),
            "--mode uniaxial",
        ),
        (
            format!("criteria {neo}"),
            "evaluates the law in three dimensions",
        ),
        (format!("card {neo}"), "evaluates the law in three dimensions"),
        (format!("audit {neo}"), "evaluates the law in three dimensions"),
        (
            "state --stretch 2,2 --set material.model=saint-venant-kirchhoff --set material.plane=stress".to_owned(),
            "there is no state of plane stress",
        ),
        (
            format!(
                "verify deck --code lammps-smd-tlsph --stretch 1,1 --wave-vector 1,0 --out {} {neo}",
                Scratch::new("deck").display()
            ),
            "plane strain",
        ),
    ] {
        let answer = onset_line(&line);
        assert_eq!(answer.code, Some(2), "{line}: {}", answer.stderr);
        assert!(answer.stderr.contains(fact), "{line}: {}", answer.stderr);
        assert!(answer.stderr.contains("hint"), "{line}: {}", answer.stderr);
    }
}

#[test]
fn a_study_of_a_sheet_cannot_set_the_third_stretch() {
    let place = Scratch::new("sheet");
    std::fs::create_dir_all(&place).expect("a folder");
    let study = |third: &str, axis: &str| {
        let file = place.join("study.toml");
        let text = format!(
            "[material]\nmodel = 'neo-hooke'\nplane = 'stress'\n[discretization]\nmethod = 'finite-elements'\n{third}\
             [[axes]]\nquantity = 'stretch-1'\nrange = [0.9, 1.1]\nstates = 4\n\
             [[axes]]\nquantity = '{axis}'\nrange = [0.9, 1.1]\nstates = 4\n"
        );
        std::fs::write(&file, text).expect("a file");
        onset_line(&format!("check {}", file.display()))
    };
    let good = study("", "stretch-2");
    assert_eq!(good.code, Some(0), "{}", good.stderr);
    assert!(good.stdout.contains("plane stress"), "{}", good.stdout);
    for refused in [
        study("[state]\nstretch-3 = 1.0\n", "stretch-2"),
        study("", "stretch-3"),
    ] {
        assert_eq!(refused.code, Some(2));
        assert!(
            refused.stderr.contains("stretch-3 is given"),
            "{}",
            refused.stderr
        );
    }
}

#[test]
fn a_metal_sheet_has_traction_free_faces_and_equals_the_metal_with_its_thickness_stretch() {
    for metal in ["j2", "hill-1948"] {
        let sheet = document(&format!(
            "state --stretch 1.1,0.95 --set material.model={metal} --set material.plane=stress"
        ));
        let thickness = numbers(&sheet, "/deformation_gradient/2")[2];
        let space = document(&format!(
            "state --stretch 1.1,0.95,{thickness} --set material.model={metal}"
        ));
        let stress = |answer, i: usize| numbers(answer, &format!("/material/cauchy/{i}"))[i];
        for i in 0..2 {
            assert_close(stress(&sheet, i), stress(&space, i), 1e-9);
        }
        assert!(stress(&space, 2).abs() < 1e-9);
    }
}

/// `mu/2 (I1 - 3) + lam/2 (J - 1 - mu/lam)^2` of the two-by-two `F`.
///
/// The smallest eigenvalue of its four-by-four Hessian at `s 1` in tension belongs to shears: `mu - lam (J - 1 - mu/lam)`, which is zero at `J = 1 +
/// 2 mu/lam`.
const CLOTH: &str = "--energy mu/2*(I1-3)+lam/2*(J-1-mu/lam)^2 --set material.mu=1 --set material.lam=5 --set material.plane=membrane";

#[test]
fn a_two_dimensional_law_has_a_two_dimensional_hessian() {
    let answer = document(&format!(
        "criteria --mode equibiaxial --range 0.5,2 {CLOTH}"
    ));
    let loadings = answer["loadings"].as_array().expect("loadings");
    assert_eq!(loadings.len(), 1);
    let limit = |name: &str| {
        let criteria = loadings[0]["criteria"].as_array().expect("criteria");
        let own = criteria
            .iter()
            .find(|one| one["criterion"] == name)
            .expect("a criterion");
        own["tension"]["limit"].as_f64().expect("a limit")
    };
    assert_close(limit("hill"), 1.4_f64.sqrt(), 1e-9);
    assert_close(limit("hill-rotation-free"), 1.4_f64.sqrt(), 1e-9);
    let card = onset_line(&format!("card --mode equibiaxial --range 0.5,2 {CLOTH}"));
    assert_eq!(card.code, Some(0), "{}", card.stderr);
    assert!(card.stdout.contains("1.18322"), "{}", card.stdout);
    let state = document(&format!("state --stretch 1.2,1.1 {CLOTH}"));
    // Expected stress: P11 = mu F11 + lam (J - 1 - mu/lam) F22.
    let first = numbers(&state, "/material/first_piola/0")[0];
    assert_close(first, 1.2 + 5.0 * (1.32 - 1.2) * 1.1, 1e-13);
    let audit = onset_line(&format!("audit {CLOTH}"));
    assert_eq!(audit.code, Some(0), "{}{}", audit.stdout, audit.stderr);
    // Invariants are two-dimensional: the derivative of I1 squared contains I1 = 2 in the reference configuration.
    let squared = "state --stretch 1.1,1 --energy I1^2/8-ln(J) --set material.plane=membrane";
    let first = numbers(&document(squared), "/material/first_piola/0")[0];
    assert_close(first, (1.21 + 1.0) * 1.1 / 2.0 - 1.0 / 1.1, 1e-13);
    for (line, fact) in [
        (
            format!("state --stretch 1.1,1,1.2 {CLOTH}"),
            "no third direction",
        ),
        (
            format!(
                "state --stretch 1.1,1,1 {CLOTH} --set discretization.lattice=face-centered-cubic"
            ),
            "3 dimensions",
        ),
    ] {
        let refused = onset_line(&line);
        assert_eq!(refused.code, Some(2), "{}", refused.stdout);
        assert!(refused.stderr.contains(fact), "{}", refused.stderr);
    }
}
