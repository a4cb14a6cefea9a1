//! Published laws.

use crate::forms::Random;
use onset::continuum::Stiffness;
use onset::kinematics::DeformationGradient;
use onset::material::{BlatzKo, Hyperelastic, ModifiedMooneyRivlin};

fn stiffness<const D: usize>(law: &dyn Hyperelastic, stretches: [f64; 3]) -> Stiffness<D> {
    let f = DeformationGradient::from_stretches(stretches).expect("a state");
    Stiffness::of(&law.response(&f).expect("finite"))
}

/// Parameter of a path at which the smallest eigenvalue in three dimensions becomes negative.
fn lost(
    law: &dyn Hyperelastic,
    path: impl Fn(f64) -> [f64; 3],
    mut inside: f64,
    mut outside: f64,
) -> f64 {
    for _ in 0..60 {
        let middle = 0.5 * (inside + outside);
        if stiffness::<3>(law, path(middle)).minimum().eigenvalue.re > 0.0 {
            inside = middle;
        } else {
            outside = middle;
        }
    }
    0.5 * (inside + outside)
}

/// Principal stretches along a path.
type Path<'a> = &'a dyn Fn(f64) -> [f64; 3];

#[test]
fn the_special_blatz_ko_law_loses_ellipticity_at_the_knowles_sternberg_ratio() {
    // J. K. Knowles and E. Sternberg, J. Elasticity 5 (1975) 341: 2 - sqrt 3 < lambda_i / lambda_j < 2 + sqrt 3.
    let law = BlatzKo::new(1.0).expect("a modulus");
    let limit = 2.0 + 3.0_f64.sqrt();
    let uniaxial = |x: f64| [x, 1.0, 1.0];
    let equibiaxial = |x: f64| [x, x, 1.0];
    let pure_shear = |x: f64| [x, 1.0, 1.0 / x];
    let confined = |x: f64| [1.0, x, 1.5];
    let cases: [(Path<'_>, f64, f64); 7] = [
        (&uniaxial, 5.0, limit),
        (&uniaxial, 0.1, 1.0 / limit),
        (&equibiaxial, 5.0, limit),
        (&equibiaxial, 0.1, 1.0 / limit),
        (&pure_shear, 2.5, limit.sqrt()),
        // The third stretch is intermediate: different pairs are critical in tension and in compression.
        (&confined, 5.0, limit),
        (&confined, 0.1, 1.5 / limit),
    ];
    for (path, outside, expected) in cases {
        let found = lost(&law, path, 1.0, outside);
        assert!((found / expected - 1.0).abs() < 1e-10, "{found} {expected}");
    }
}

#[test]
fn two_and_three_dimensional_minima_agree_if_the_softest_wave_is_in_plane() {
    let laws: [Box<dyn Hyperelastic>; 2] = [
        Box::new(ModifiedMooneyRivlin::default()),
        Box::new(BlatzKo::new(2.0).expect("a modulus")),
    ];
    let mut random = Random::new(21);
    let mut seen = [0, 0];
    for law in &laws {
        for _ in 0..150 {
            let stretches = [
                1.6 + 1.2 * random.number(),
                1.6 + 1.2 * random.number(),
                1.0,
            ];
            let space = stiffness::<3>(&**law, stretches).minimum();
            let plane = stiffness::<2>(&**law, stretches).minimum();
            let scale = stiffness::<3>(&**law, stretches).maximum_eigenvalue();
            let difference = plane.eigenvalue.re - space.eigenvalue.re;
            assert!(difference > -1e-12 * scale, "the plane is part of space");
            let is_planar = space.direction[2].abs() < 1e-9 && space.polarization[2].abs() < 1e-9;
            if is_planar {
                assert!(difference.abs() < 1e-12 * scale, "{difference:e}");
            }
            seen[usize::from(is_planar)] += 1;
        }
    }
    assert!(seen[0] > 20 && seen[1] > 20, "{seen:?}");
}

#[test]
fn rotating_the_state_leaves_the_minimum_unchanged() {
    let laws: [Box<dyn Hyperelastic>; 2] = [
        Box::new(ModifiedMooneyRivlin::default()),
        Box::new(BlatzKo::new(2.0).expect("a modulus")),
    ];
    let mut random = Random::new(22);
    for law in &laws {
        for _ in 0..40 {
            let stretches = std::array::from_fn(|_| 1.2 + 0.7 * random.number());
            let f = DeformationGradient::from_stretches(stretches).expect("a state");
            let turned = random.rotation() * f.matrix() * random.rotation();
            let components = std::array::from_fn(|i| std::array::from_fn(|j| turned[(i, j)]));
            let turned = DeformationGradient::new(components).expect("a state");
            let [one, other] = [f, turned]
                .map(|f| Stiffness::<3>::of(&law.response(&f).expect("finite")).minimum());
            let largest = stiffness::<3>(&**law, stretches).maximum_eigenvalue();
            let scale = largest.max(one.eigenvalue.re.abs());
            let difference = one.eigenvalue.re - other.eigenvalue.re;
            assert!(difference.abs() < 1e-10 * scale, "{difference:e}");
            // The bound depends on the axes if the minimum is flat and the sphere has to be divided.
            for minimum in [one, other] {
                let gap = minimum.eigenvalue.re - minimum.bound;
                assert!((0.0..1e-2 * scale).contains(&gap), "{gap:e} of {scale:e}");
            }
        }
    }
}
