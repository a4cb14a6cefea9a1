//! Comparison with dense scans of the sphere, which do not use bounds.

use crate::forms::{Random, acoustic, choi, quadratic, raised, scale, turned};
use nalgebra::{Matrix3, Vector3};
use onset::continuum::Stiffness;
use onset::material::FourthOrder;

/// Smallest real part of a zero of the characteristic polynomial, in closed form.
fn smallest(q: &Matrix3<f64>) -> f64 {
    let mean = q.trace() / 3.0;
    let b = q - Matrix3::identity() * mean;
    // The characteristic polynomial is x^3 - 3 p x - 2 h.
    let (p, h) = ((b * b).trace() / 6.0, 0.5 * b.determinant());
    if h * h <= p * p * p {
        let angle = (h / (p * p.sqrt())).clamp(-1.0, 1.0).acos() / 3.0;
        return if p > 0.0 {
            mean + 2.0 * p.sqrt() * (angle + std::f64::consts::TAU / 3.0).cos()
        } else {
            mean
        };
    }
    let root = (h * h - p * p * p).sqrt();
    let real = (h + root).cbrt() + (h - root).cbrt();
    // The roots add up to zero, so the real parts of the complex pair are minus half of the real root.
    mean + real.min(-0.5 * real)
}

fn at(polar: f64, around: f64) -> Vector3<f64> {
    Vector3::new(
        polar.sin() * around.cos(),
        polar.sin() * around.sin(),
        polar.cos(),
    )
}

/// Entries of the acoustic tensors as quadratic forms, fast enough for millions of directions.
struct Fast([[f64; 6]; 9]);

impl Fast {
    fn new(t: &FourthOrder) -> Self {
        Self(std::array::from_fn(|e| {
            let (i, k) = (e / 3, e % 3);
            let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
            pairs.map(|(j, l)| match j == l {
                true => t[(i, j, k, l)],
                false => t[(i, j, k, l)] + t[(i, l, k, j)],
            })
        }))
    }

    fn acoustic(&self, n: &Vector3<f64>) -> Matrix3<f64> {
        let [x, y, z] = [n[0], n[1], n[2]];
        let powers = [x * x, y * y, z * z, x * y, x * z, y * z];
        let entry = |e: usize| (0..6).map(|m| self.0[e][m] * powers[m]).sum::<f64>();
        Matrix3::from_fn(|i, k| entry(3 * i + k))
    }

    fn smallest(&self, n: &Vector3<f64>) -> f64 {
        smallest(&self.acoustic(n))
    }
}

/// Best direction of a grid over half the sphere, refined by descents with decreasing steps.
fn scanned(t: &FourthOrder, rows: u32, columns: u32) -> f64 {
    let fast = Fast::new(t);
    let mut best = (f64::INFINITY, 0.0, 0.0);
    for row in 0..rows {
        let polar = std::f64::consts::FRAC_PI_2 * (f64::from(row) + 0.5) / f64::from(rows);
        for column in 0..columns {
            let around = std::f64::consts::TAU * f64::from(column) / f64::from(columns);
            let value = fast.smallest(&at(polar, around));
            if value < best.0 {
                best = (value, polar, around);
            }
        }
    }
    let mut step = 0.02;
    while step > 1e-10 {
        let before = best.0;
        for turn in 0..16 {
            let (sine, cosine) = (std::f64::consts::TAU * f64::from(turn) / 16.0).sin_cos();
            let (polar, around) = (
                best.1 + step * cosine,
                best.2 + step * sine / best.1.sin().abs().max(1e-3),
            );
            let value = fast.smallest(&at(polar, around));
            if value < best.0 {
                best = (value, polar, around);
            }
        }
        if best.0 == before {
            step *= 0.5;
        }
    }
    best.0
}

#[track_caller]
fn assert_minimum(t: &FourthOrder, grid: (u32, u32), gap: f64) {
    let scan = scanned(t, grid.0, grid.1);
    let minimum = Stiffness::<3>::from_tangent(t).minimum();
    let (value, scale) = (minimum.eigenvalue.re, scale(t));
    assert!(
        value <= scan + 1e-12 * scale,
        "{value} above the scan's {scan}"
    );
    assert!(
        minimum.bound <= scan + 1e-13 * scale,
        "{} no bound of {scan}",
        minimum.bound
    );
    assert!(minimum.bound <= value);
    assert!(
        value - minimum.bound < gap * scale,
        "gap {:e}",
        (value - minimum.bound) / scale
    );
    // The direction attains the eigenvalue, so the value is not below the true minimum either.
    let n = minimum.direction;
    assert!((n.norm() - 1.0).abs() < 1e-14);
    let there = smallest(&acoustic(t, &n));
    assert!((there - value).abs() < 3e-8 * scale, "{there} {value}");
}

#[test]
fn neither_minimum_nor_bound_exceeds_a_dense_scan() {
    let mut random = Random::new(1);
    for _ in 0..60 {
        assert_minimum(&random.symmetric(), (60, 240), 1.1e-10);
    }
}

#[test]
fn the_minimum_is_at_most_the_minimum_over_four_million_directions() {
    let mut random = Random::new(2);
    assert_minimum(&random.symmetric(), (2000, 2000), 1.1e-10);
}

#[test]
fn without_major_symmetry_the_smallest_real_part_agrees_with_a_dense_scan() {
    let mut random = Random::new(3);
    for n in 0..12 {
        let (full, half) = (random.asymmetric(), random.symmetric());
        // The stiffnesses range from symmetric to fully asymmetric.
        let share = f64::from(n) / 11.0;
        let t = FourthOrder::from_fn(|i, j, k, l| half[(i, j, k, l)] + share * full[(i, j, k, l)]);
        assert_minimum(&t, (60, 240), 1.1e-8);
    }
}

/// Largest imaginary part of an eigenvalue.
fn imaginary(q: &Matrix3<f64>) -> f64 {
    let values = q.complex_eigenvalues();
    values.iter().fold(0.0, |most, value| most.max(value.im))
}

#[test]
fn without_major_symmetry_complex_eigenvalues_agree_with_a_dense_scan() {
    let mut random = Random::new(31);
    let (mut with, mut without) = (0, 0);
    for asymmetry in [0.02, 0.1, 0.5] {
        for _ in 0..12 {
            let (symmetric, other) = (random.symmetric(), random.symmetric());
            // The first part of the sum has major symmetry, the second is antisymmetric.
            let t = FourthOrder::from_fn(|i, j, k, l| {
                let apart = other[(i, j, k, l)] * (i as f64 - k as f64);
                symmetric[(i, j, k, l)] + asymmetry * apart
            });
            let fast = Fast::new(&t);
            let directions = (0..120 * 240).map(|n| {
                let (row, column) = (f64::from(n / 240), f64::from(n % 240));
                let polar = std::f64::consts::FRAC_PI_2 * (row + 0.5) / 120.0;
                at(polar, std::f64::consts::TAU * column / 240.0)
            });
            let scan = directions
                .map(|n| imaginary(&fast.acoustic(&n)))
                .fold(0.0, f64::max);
            let stiffness = Stiffness::<3>::from_tangent(&t);
            let found = stiffness.flutter().map_or(0.0, |flutter| {
                let own = imaginary(&fast.acoustic(&flutter.direction));
                assert!((own - flutter.eigenvalue.im).abs() < 1e-9);
                flutter.eigenvalue.im
            });
            assert!(found > 0.98 * scan, "{asymmetry}: {found} {scan}");
            with += usize::from(found > 0.0);
            without += usize::from(found == 0.0);
        }
    }
    assert!(with > 20, "{with} {without}");
    let symmetric = Stiffness::<3>::from_tangent(&random.symmetric());
    assert_eq!(symmetric.flutter(), None);
}

#[test]
fn rotating_the_tensor_keeps_the_minimum() {
    let mut random = Random::new(4);
    let special = [
        choi(),
        quadratic(&[(12, 12, 1.0), (33, 33, 0.5), (11, 22, -1.0)]),
    ];
    let tensors: Vec<_> = (0..40).map(|_| random.symmetric()).chain(special).collect();
    for t in tensors {
        let minimum = |t: &FourthOrder| Stiffness::<3>::from_tangent(t).minimum().eigenvalue.re;
        let difference = minimum(&turned(&t, &random.rotation())) - minimum(&t);
        assert!(difference.abs() < 1e-10 * scale(&t), "{difference:e}");
    }
}

#[test]
fn strong_ellipticity_agrees_with_the_sign_of_the_minimum() {
    let mut random = Random::new(5);
    let mut seen = [0, 0];
    for n in 0..120 {
        let symmetric = random.symmetric();
        let t = if n % 10 == 0 {
            random.asymmetric()
        } else {
            symmetric
        };
        let t = raised(&t, 1.5 + random.number());
        let stiffness = Stiffness::<3>::from_tangent(&t);
        let minimum = stiffness.symmetric_part().minimum().eigenvalue.re;
        assert!(minimum <= stiffness.minimum().eigenvalue.re + 1e-12);
        assert_eq!(stiffness.is_strongly_elliptic(), minimum > 0.0, "{minimum}");
        seen[usize::from(minimum > 0.0)] += 1;
        // The minimum is moved as close to zero as can be resolved.
        for distance in [1e-9, -1e-9] {
            let near = Stiffness::<3>::from_tangent(&raised(&t, distance - minimum));
            assert_eq!(near.is_strongly_elliptic(), distance > 0.0);
        }
    }
    assert!(seen[0] > 20 && seen[1] > 20, "{seen:?}");
}

#[test]
fn a_form_that_no_null_lagrangian_makes_convex_is_bounded_by_dividing_the_sphere() {
    let mut random = Random::new(6);
    for level in [0.0, 0.01, 1.0] {
        let t = turned(&raised(&choi(), level), &random.rotation());
        let minimum = Stiffness::<3>::from_tangent(&t).minimum();
        assert!(
            (minimum.eigenvalue.re - level).abs() < 1e-12,
            "{:?}",
            minimum.eigenvalue
        );
        assert!(minimum.bound > level - 1e-3, "{}", minimum.bound);
        assert!(minimum.bound <= level + 1e-14);
    }
}

#[test]
fn a_minimum_with_a_double_eigenvalue_and_a_kink_is_found() {
    // g = (g1, g2, 0) and N near the third axis: the lower of N1^2 + N2^2 and 4 N1^2 + N2^2 / 4.
    let t = quadratic(&[
        (11, 11, 1.0),
        (12, 12, 1.0),
        (21, 21, 4.0),
        (22, 22, 0.25),
        (31, 31, 1.0),
        (32, 32, 1.0),
        (33, 33, 1.0),
    ]);
    let mut random = Random::new(7);
    for _ in 0..10 {
        let r = random.rotation();
        let minimum = Stiffness::<3>::from_tangent(&turned(&t, &r)).minimum();
        assert!(minimum.eigenvalue.re.abs() < 1e-14);
        assert!(minimum.bound > -1e-9);
        let axis = r * Vector3::z();
        assert!(minimum.direction.dot(&axis).abs() > 1.0 - 1e-12);
    }
}

#[test]
fn units_only_scale_the_result() {
    let t = Random::new(8).symmetric();
    let one = Stiffness::<3>::from_tangent(&t).minimum();
    for factor in [1e-200, 1e150] {
        let scaled = FourthOrder::from_fn(|i, j, k, l| factor * t[(i, j, k, l)]);
        let other = Stiffness::<3>::from_tangent(&scaled).minimum();
        assert!((other.eigenvalue.re / factor - one.eigenvalue.re).abs() < 1e-14);
        assert!((other.bound / factor - one.bound).abs() < 1e-9);
    }
}
