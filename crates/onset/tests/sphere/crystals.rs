//! Linear elasticity whose minimum, or its sign, is known in closed form.

use crate::forms::{Random, acoustic, delta, isotropic, turned};
use nalgebra::{Matrix3, Vector3};
use onset::continuum::Stiffness;
use onset::material::FourthOrder;

#[test]
fn isotropic_elasticity_has_the_lower_of_both_wave_moduli_in_every_direction() {
    let mut random = Random::new(11);
    for (lambda, mu) in [
        (3.0, 1.0),
        (0.0, 2.0),
        (-1.5, 1.0),
        (-2.5, 1.0),
        (4.0, -0.5),
        (-1.0, 1.0),
    ] {
        let t = turned(&isotropic(lambda, mu), &random.rotation());
        let minimum = Stiffness::<3>::from_tangent(&t).minimum();
        let lowest = f64::min(mu, lambda + 2.0 * mu);
        assert!((minimum.eigenvalue.re - lowest).abs() < 2e-15 * 8.0);
        assert!(
            minimum.bound > lowest - 1e-9,
            "{lambda} {mu}: {}",
            minimum.bound
        );
        for _ in 0..20 {
            let n = Vector3::from_fn(|_, _| random.number()).normalize();
            let least = acoustic(&t, &n).symmetric_eigenvalues().min();
            assert!((least - lowest).abs() < 1e-14);
        }
    }
}

#[test]
fn two_negative_eigenvalues_with_positive_determinant_are_detected() {
    let mut random = Random::new(12);
    let t = turned(&isotropic(4.0, -1e-6), &random.rotation());
    for _ in 0..1000 {
        let n = Vector3::from_fn(|_, _| random.number()).normalize();
        assert!(acoustic(&t, &n).determinant() > 0.0);
    }
    assert!(!Stiffness::<3>::from_tangent(&t).is_strongly_elliptic());
    // Repeated without major symmetry.
    let twist = [[0.0, 0.3, -0.2], [-0.3, 0.0, 0.1], [0.2, -0.1, 0.0]];
    let twisted = FourthOrder::from_fn(|i, j, k, l| t[(i, j, k, l)] + twist[i][k] * delta(j, l));
    assert!(acoustic(&twisted, &Vector3::x()).determinant() > 0.0);
    let flipped =
        FourthOrder::from_fn(|i, j, k, l| twisted[(i, j, k, l)] - 0.1 * delta(i, k) * delta(j, l));
    assert!(!Stiffness::<3>::from_tangent(&flipped).is_strongly_elliptic());
}

fn cubic(c11: f64, c12: f64, c44: f64) -> FourthOrder {
    let rest = c11 - c12 - 2.0 * c44;
    let base = isotropic(c12, c44);
    FourthOrder::from_fn(|i, j, k, l| {
        let is_same = i == j && j == k && k == l;
        base[(i, j, k, l)] + if is_same { rest } else { 0.0 }
    })
}

#[test]
fn the_minimum_of_a_cubic_crystal_lies_at_axes_or_diagonals() {
    // The form is g . Q g = C44 + e sum x^2 + d (sum x)^2 with x = g_i N_i, e = C11 - C12 - 2 C44, d = C12 + C44. It is lowest at x = 0 or on
    // sum |x| = 1, at (1, 0, 0), at (1, -1, 0) / 2 or at (1, 1, 1) / 3.
    let mut random = Random::new(13);
    let mut seen = [0; 4];
    for n in 0..200 {
        let [c11, c12, c44] = [
            2.0 * random.number() + 1.0,
            2.0 * random.number(),
            random.number() + 0.5,
        ];
        let candidates = [
            c44,
            c11,
            0.5 * (c11 - c12),
            (c11 + 2.0 * c12 + 4.0 * c44) / 3.0,
        ];
        let closed = candidates.iter().copied().fold(f64::INFINITY, f64::min);
        let t = cubic(c11, c12, c44);
        let t = if n % 2 == 0 {
            t
        } else {
            turned(&t, &random.rotation())
        };
        let minimum = Stiffness::<3>::from_tangent(&t).minimum();
        assert!(
            (minimum.eigenvalue.re - closed).abs() < 1e-13,
            "{c11} {c12} {c44}: {} {closed}",
            minimum.eigenvalue.re
        );
        assert!(
            minimum.bound > closed - 2e-2,
            "{c11} {c12} {c44}: {:e}",
            closed - minimum.bound
        );
        for (count, candidate) in seen.iter_mut().zip(candidates) {
            *count += usize::from(candidate == closed);
        }
    }
    assert!(seen.iter().all(|count| *count > 5), "{seen:?}");
}

#[test]
fn strong_ellipticity_of_hexagonal_crystals_agrees_with_the_closed_form() {
    // Shear waves in the plane of isotropy: C44, C66 > 0. In planes that contain the axis: C11, C33 > 0
    // and |C13 + C44| < C44 + sqrt(C11 C33).
    let mut random = Random::new(14);
    let mut seen = [0, 0];
    for _ in 0..300 {
        let positive = |random: &mut Random| 1.1 + random.number();
        let [c11, c33, c44, c66] = std::array::from_fn(|_| positive(&mut random) - 0.15);
        let c13 = 3.0 * random.number();
        let voigt = [
            [c11, c11 - 2.0 * c66, c13, 0.0, 0.0, 0.0],
            [c11 - 2.0 * c66, c11, c13, 0.0, 0.0, 0.0],
            [c13, c13, c33, 0.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, c44, 0.0, 0.0],
            [0.0, 0.0, 0.0, 0.0, c44, 0.0],
            [0.0, 0.0, 0.0, 0.0, 0.0, c66],
        ];
        let place = |i: usize, j: usize| if i == j { i } else { 6 - i - j };
        let t = FourthOrder::from_fn(|i, j, k, l| voigt[place(i, j)][place(k, l)]);
        let root = if c11 > 0.0 && c33 > 0.0 {
            (c11 * c33).sqrt()
        } else {
            f64::NAN
        };
        let margin = [c11, c33, c44, c66, c44 + root - (c13 + c44).abs()]
            .into_iter()
            .fold(f64::INFINITY, f64::min);
        let margin = if root.is_nan() {
            margin.min(c11).min(c33)
        } else {
            margin
        };
        if margin.abs() < 1e-6 {
            continue;
        }
        for r in [Matrix3::identity(), random.rotation()] {
            let stiffness = Stiffness::<3>::from_tangent(&turned(&t, &r));
            assert_eq!(stiffness.is_strongly_elliptic(), margin > 0.0, "{voigt:?}");
        }
        seen[usize::from(margin > 0.0)] += 1;
    }
    assert!(seen[0] > 50 && seen[1] > 50, "{seen:?}");
}
