//! Proofs over all directions in three dimensions are correct, and true statements are proved.

use crate::forms::{Quadratic, Random, choi, delta, raised, scale, turned};
use onset::certificate::{Certainty, Reason, SpaceCertificate, certify_3d};
use onset::continuum::Stiffness;
use onset::kinematics::DeformationGradient;
use onset::material::{
    BlatzKo, FourthOrder, Hyperelastic, MaterialError, ModifiedMooneyRivlin, Response,
};
use onset::real::Interval;

fn proof(t: &FourthOrder) -> SpaceCertificate {
    let exact = DeformationGradient::from_components(
        DeformationGradient::identity()
            .components()
            .map(|row| row.map(Interval::point)),
    );
    SpaceCertificate::of(&Quadratic(t.clone()).enclosure(&exact), 1.0, 1e-6)
}

#[test]
fn proofs_agree_with_the_sign_of_the_minimum_beyond_rounding() {
    let mut random = Random::new(31);
    for _ in 0..40 {
        let t = random.symmetric();
        let lowest = Stiffness::<3>::from_tangent(&t).minimum().eigenvalue.re;
        for level in [1.0, 1e-6, -1e-6, -1.0] {
            let t = raised(&t, level - lowest);
            match proof(&t).certainty {
                Certainty::Stable { bound } => {
                    assert!(
                        level > 0.0 && bound <= level * (1.0 + 1e-6) && bound >= 0.99 * level,
                        "{bound} {level}"
                    );
                }
                Certainty::Unstable { witness } => {
                    assert!(level < 0.0 && witness.measure.high < 0.0);
                    assert!(
                        witness.measure.contains(level)
                            || (witness.measure.midpoint() - level).abs() < 1e-8
                    );
                }
                other => panic!("{other:?} at {level}"),
            }
        }
    }
}

#[test]
fn a_witness_has_a_negative_energy() {
    let mut random = Random::new(32);
    for _ in 0..20 {
        let t = random.symmetric();
        let proof = proof(&t);
        let Certainty::Unstable { witness } = proof.certainty else {
            panic!("random tensors are not elliptic");
        };
        let (n, g) = (
            witness.wave_vector,
            proof.polarization.expect("a polarization"),
        );
        let energy: f64 = (0..81)
            .map(|m| {
                let [i, j, k, l] = [m / 27, m / 9 % 3, m / 3 % 3, m % 3];
                t[(i, j, k, l)] * g[i] * n[j] * g[k] * n[l]
            })
            .sum();
        assert!(energy < 0.0);
        assert!((energy - witness.measure.high).abs() < 1e-9 * scale(&t));
    }
}

#[test]
fn a_form_that_no_null_lagrangian_makes_convex_is_proved_by_triangles() {
    let mut random = Random::new(33);
    for level in [0.02, 0.5] {
        let t = turned(&raised(&choi(), level), &random.rotation());
        let certainty = proof(&t).certainty;
        assert!(
            matches!(certainty, Certainty::Stable { bound } if bound > 0.4 * level && bound <= level),
            "{certainty:?}"
        );
    }
}

#[test]
fn both_sides_of_the_knowles_sternberg_limit_are_proved_within_a_billionth() {
    let law = BlatzKo::new(1.0).expect("a modulus");
    let limit = 2.0 + 3.0_f64.sqrt();
    let state =
        |ratio: f64| DeformationGradient::from_stretches([1.0, ratio, 1.3]).expect("a state");
    let before = certify_3d(&law, &state(limit * (1.0 - 1e-9)), 1e-12).expect("a law");
    assert_eq!(before.certainty.name(), "proved-stable");
    let after = certify_3d(&law, &state(limit * (1.0 + 1e-9)), 1e-12).expect("a law");
    assert_eq!(after.certainty.name(), "proved-unstable");
    let at = certify_3d(&law, &state(limit), 1e-6).expect("a law");
    if let Certainty::Undecided { reason, .. } = at.certainty {
        assert_eq!(reason, Reason::WithinTolerance);
    }
}

#[test]
fn a_box_of_states_is_proved_as_a_whole() {
    let law = ModifiedMooneyRivlin::default();
    let enclosure = |width: f64| {
        law.enclosure(&DeformationGradient::from_components(std::array::from_fn(
            |i| std::array::from_fn(|j| Interval::new(delta(i, j) - width, delta(i, j) + width)),
        )))
    };
    let certainty = |width: f64| SpaceCertificate::of(&enclosure(width), 1.0, 1e-6).certainty;
    assert!(matches!(certainty(1e-5), Certainty::Stable { bound } if bound > 0.01));
    // A large box contains too much for a proof.
    assert!(!certainty(0.5).is_decided());
}

/// Law without bounds of its response.
struct Foreign;

impl Hyperelastic for Foreign {
    fn response(&self, f: &DeformationGradient) -> Result<Response, MaterialError> {
        ModifiedMooneyRivlin::default().response(f)
    }
}

#[test]
fn no_proof_is_given_for_a_law_without_bounds() {
    let f = DeformationGradient::identity();
    let proof = certify_3d(&Foreign, &f, 1e-6).expect("a law");
    assert!(matches!(
        proof.certainty,
        Certainty::Undecided { reason: Reason::NotFinite, measure } if measure.is_nan()
    ));
}
