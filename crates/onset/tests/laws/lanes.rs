//! Tangents of many states, and at states with mirror axes, compared with the tangents of individual states.

use crate::table::{Random, laws};
use onset::kinematics::DeformationGradient;
use onset::material::{Hyperelastic, PlaneTangent, StrainEnergy, library};
use onset::real::{LANES, Lanes, Mirrored, Real};

fn stretched(random: &mut Random) -> DeformationGradient {
    let stretches = [
        random.stretch(2.5),
        random.stretch(2.5),
        random.stretch(1.5),
    ];
    DeformationGradient::from_stretches(stretches).expect("positive stretches")
}

/// In-plane tangent from the full response.
fn expected(law: &dyn Hyperelastic, f: &DeformationGradient) -> PlaneTangent {
    let tangent = law.response(f).expect("finite").tangent;
    std::array::from_fn(|a| std::array::from_fn(|b| tangent[(a / 2, a % 2, b / 2, b % 2)]))
}

fn assert_close(found: &PlaneTangent, expected: &PlaneTangent, name: &str) {
    let magnitude = expected
        .as_flattened()
        .iter()
        .fold(0.0, |m: f64, x| m.max(x.abs()));
    for (x, y) in found.as_flattened().iter().zip(expected.as_flattened()) {
        assert!(
            (x - y).abs() <= 1e-12 * magnitude,
            "{name}: {x} instead of {y}"
        );
    }
}

#[test]
fn tangents_at_states_with_mirror_axes_equal_the_full_response() {
    let mut random = Random::new(31);
    for entry in laws() {
        for _ in 0..50 {
            let f = stretched(&mut random);
            let tangent = entry.law.plane_tangent(&f).expect("finite");
            assert_close(&tangent, &expected(&*entry.law, &f), entry.name);
        }
    }
}

#[test]
fn tangents_are_bitwise_independent_of_the_other_states() {
    let mut random = Random::new(32);
    for entry in laws() {
        let mut states: Vec<_> = (0..19).map(|_| stretched(&mut random)).collect();
        states.extend((0..11).map(|_| random.planar_state(1.5)));
        states.push(stretched(&mut random));
        for (f, together) in states.iter().zip(entry.law.plane_tangents(&states)) {
            let alone = entry.law.plane_tangent(f);
            assert_eq!(
                together.expect("finite"),
                alone.expect("finite"),
                "{}",
                entry.name
            );
        }
    }
}

#[test]
fn every_law_gives_equal_results_for_one_and_many_states() {
    let mut random = Random::new(34);
    for law in library() {
        let built = law.build(&[]).expect("defaults");
        let mut states: Vec<_> = (0..11)
            .map(|_| {
                let stretches = [0; 3].map(|_| random.stretch(1.6));
                DeformationGradient::from_stretches(stretches).expect("positive stretches")
            })
            .collect();
        states.extend((0..9).map(|_| random.planar_state(1.3)));
        let tangents = built.plane_tangents(&states);
        assert_eq!(tangents.len(), states.len());
        for (f, together) in states.iter().zip(tangents) {
            assert_eq!(together, built.plane_tangent(f), "{}", law.name);
            // A state that a law rejects is rejected alone, without affecting the others.
            let full = built.response(f);
            assert_eq!(together.is_ok(), full.is_ok(), "{}", law.name);
            if let Ok(tangent) = together {
                assert_close(&tangent, &expected(&*built, f), law.name);
            }
        }
    }
}

fn together(states: &[DeformationGradient; LANES]) -> DeformationGradient<Lanes> {
    DeformationGradient::from_components(std::array::from_fn(|i| {
        std::array::from_fn(|j| Lanes(states.map(|f| f.components()[i][j])))
    }))
}

#[test]
fn stresses_of_many_states_equal_the_individual_stresses() {
    let mut random = Random::new(35);
    for law in library() {
        let built = law.build(&[]).expect("defaults");
        for dimension in [2, 3] {
            for round in 0..8 {
                let mut states: [DeformationGradient; LANES] =
                    std::array::from_fn(|_| match dimension {
                        2 => random.planar_state(1.3),
                        _ => random.state(),
                    });
                // An inverted state has no stress and does not affect the others.
                let mirror = [[-1.0, 0.2, 0.0], [0.0, 1.1, 0.0], [0.0, 0.0, 1.0]];
                states[round] = DeformationGradient::from_components(mirror);
                let all = built.lane_stress(&together(&states), dimension);
                let same = built.lane_stress(&together(&[states[7 - round]; LANES]), dimension);
                for (lane, f) in states.iter().enumerate() {
                    if lane == 7 - round && lane != round {
                        assert_eq!(all.energy.0[lane], same.energy.0[0], "{}", law.name);
                        for (own, alone) in all.first_piola.iter().zip(&same.first_piola) {
                            assert_eq!(
                                own.map(|p| p.0[lane]),
                                alone.map(|p| p.0[0]),
                                "{}",
                                law.name
                            );
                        }
                    }
                    let own = (lane != round).then(|| built.energy_and_stress(f).ok());
                    let Some((energy, stress)) = own.flatten() else {
                        assert!(all.energy.0[lane].is_nan(), "{}", law.name);
                        continue;
                    };
                    let scale = stress.amax().max(energy.abs()).max(1.0);
                    let tolerance = 1e-11 * scale;
                    assert!((all.energy.0[lane] - energy).abs() <= tolerance);
                    for i in 0..dimension {
                        for j in 0..dimension {
                            let found = all.first_piola[i][j].0[lane];
                            assert!(
                                (found - stress[(i, j)]).abs() <= tolerance,
                                "{}: {found} instead of {}",
                                law.name,
                                stress[(i, j)]
                            );
                        }
                    }
                }
            }
        }
    }
}

/// Tension-only fibers at an angle to the first axis: a law with a branch, and without the mirror symmetry of an isotropic law unless the fibers lie
/// along an axis.
struct Fibers {
    angle: f64,
}

impl StrainEnergy for Fibers {
    fn energy<R: Real>(&self, f: &DeformationGradient<R>) -> R {
        let (sine, cosine) = self.angle.sin_cos();
        let c = f.right_cauchy_green();
        let square =
            c[0][0] * (cosine * cosine) + c[0][1] * (2.0 * sine * cosine) + c[1][1] * (sine * sine);
        let pull = square.switch(1.0, || R::constant(0.0), || (square - 1.0) * (square - 1.0));
        pull + (c[0][0] + c[1][1]) * 0.5 + f.determinant().ln()
    }
}

#[test]
fn laws_with_branches_or_without_mirror_symmetry_are_correct() {
    let mut random = Random::new(33);
    for angle in [0.0, 0.4, 1.1] {
        let law = Fibers { angle };
        let states: Vec<_> = (0..40).map(|_| stretched(&mut random)).collect();
        for (f, tangent) in states.iter().zip(law.plane_tangents(&states)) {
            assert_close(&tangent.expect("finite"), &expected(&law, f), "fibers");
            assert_close(
                &law.plane_tangent(f).expect("finite"),
                &expected(&law, f),
                "fibers",
            );
        }
    }
}

#[test]
fn sums_of_even_and_odd_numbers_have_no_hessian() {
    let [f11, f12, ..] = Mirrored::variables(1.3, 0.8);
    assert_eq!(f11 + f12, Mirrored::Neither);
    assert_eq!((f11 + f12) * f11, Mirrored::Neither);
    assert!(f12.hessian().is_none());
    assert!((f12 * f12 * f11).hessian().is_some());
    // To second order a cube vanishes.
    assert_eq!(f12.powi(3), Mirrored::Zero);
}

#[test]
fn lanes_that_differ_have_no_common_value() {
    assert_eq!(Lanes::constant(2.5).value(), 2.5);
    assert!(
        Lanes([1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 2.0])
            .value()
            .is_nan()
    );
}
