//! Smallest eigenvalue of the acoustic tensor over all directions, compared with scans.

use crate::table::{Random, laws, of};
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use onset::continuum::Stiffness;
use onset::kinematics::DeformationGradient;
use onset::material::FourthOrder;

/// Smallest real part of an eigenvalue of a real 2 x 2 matrix.
fn smallest(q: &Matrix2<f64>) -> f64 {
    let (half_trace, determinant) = (0.5 * q.trace(), q.determinant());
    half_trace - (half_trace * half_trace - determinant).max(0.0).sqrt()
}

fn acoustic<const D: usize>(t: &FourthOrder, n: [f64; D]) -> nalgebra::SMatrix<f64, D, D> {
    nalgebra::SMatrix::from_fn(|i, k| {
        (0..D * D)
            .map(|m| t[(i, m / D, k, m % D)] * n[m / D] * n[m % D])
            .sum()
    })
}

/// Scan of the half circle; each of its local minima is refined by repeated subdivision.
fn scanned(t: &FourthOrder) -> f64 {
    let at = |angle: f64| smallest(&acoustic(t, [angle.cos(), angle.sin()]));
    let count = 360;
    let step = std::f64::consts::PI / f64::from(count);
    let samples: Vec<f64> = (0..count).map(|n| at(f64::from(n) * step)).collect();
    let mut lowest = f64::INFINITY;
    for n in 0..samples.len() {
        let before = samples[(n + samples.len() - 1) % samples.len()];
        let behind = samples[(n + 1) % samples.len()];
        if samples[n] <= before && samples[n] <= behind {
            let (mut center, mut width) = (n as f64 * step, step);
            for _ in 0..14 {
                let nearby = (-10..=10).map(|m| center + width * 0.1 * f64::from(m));
                center = nearby
                    .min_by(|a, b| at(*a).total_cmp(&at(*b)))
                    .unwrap_or(center);
                width *= 0.2;
            }
            lowest = lowest.min(at(center));
        }
    }
    lowest
}

#[track_caller]
fn assert_minimum(t: &FourthOrder, scale: f64) {
    let minimum = Stiffness::<2>::from_tangent(t).minimum();
    let difference = minimum.eigenvalue.re - scanned(t);
    // The minimum is found in any direction: neither above the scan nor, to its resolution, below it.
    assert!(
        difference.abs() < 1e-9 * scale,
        "off by {difference:e} of {scale:e}"
    );
    let at = smallest(&acoustic(t, [minimum.direction[0], minimum.direction[1]]));
    assert!(
        (minimum.eigenvalue.re - at).abs() < 1e-12 * scale,
        "the direction has the eigenvalue"
    );
}

#[test]
fn the_in_plane_minimum_agrees_with_a_dense_scan() {
    for entry in laws() {
        let mut random = Random::new(21);
        for _ in 0..150 {
            let response = entry
                .law
                .response(&random.planar_state(4.0))
                .expect("finite");
            let scale = (0..16)
                .map(|n| response.tangent[(n / 8, n / 4 % 2, n / 2 % 2, n % 2)].abs())
                .fold(0.0, f64::max);
            assert_minimum(&response.tangent, scale);
        }
    }
}

#[test]
fn the_minimum_without_major_symmetry_agrees_with_a_dense_scan() {
    let mut random = Random::new(22);
    for _ in 0..400 {
        let numbers: Vec<f64> = (0..81).map(|_| random.number()).collect();
        let shift = random.number();
        let t = FourthOrder::from_fn(|i, j, k, l| {
            numbers[27 * i + 9 * j + 3 * k + l] + if i == k && j == l { shift } else { 0.0 }
        });
        assert_minimum(&t, 1.0);
        let stiffness = Stiffness::<2>::from_tangent(&t);
        let minimum = stiffness.minimum();
        assert_eq!(
            minimum.ellipticity().is_elliptic(),
            minimum.eigenvalue.re > 0.0
        );

        let directions =
            (0..4_000).map(|n| (f64::from(n) * std::f64::consts::PI / 4_000.0).sin_cos());
        let tensors: Vec<Matrix2<f64>> = directions.map(|(s, c)| acoustic(&t, [c, s])).collect();
        // Strong ellipticity concerns the symmetric part, whose smallest eigenvalue is smaller.
        let forms = tensors
            .iter()
            .map(|q| smallest(&((q + q.transpose()) * 0.5)));
        let form = forms.fold(f64::INFINITY, f64::min);
        if form.abs() > 1e-4 {
            assert_eq!(stiffness.is_strongly_elliptic(), form > 0.0, "{form}");
        }
        let imaginary = |q: &Matrix2<f64>| {
            let half = 0.5 * (q[(0, 0)] - q[(1, 1)]);
            (-half * half - q[(0, 1)] * q[(1, 0)]).max(0.0).sqrt()
        };
        let scan = tensors.iter().map(imaginary).fold(0.0, f64::max);
        let found = minimum.flutter.map_or(0.0, |flutter| {
            let q = acoustic(&t, [flutter.direction[0], flutter.direction[1]]);
            assert!((imaginary(&q) - flutter.eigenvalue.im).abs() < 1e-9);
            flutter.eigenvalue.im
        });
        assert!((-1e-9..1e-3).contains(&(found - scan)), "{found} {scan}");
    }
}

#[test]
fn eigenpairs_of_the_minimum_satisfy_their_equation() {
    for entry in laws() {
        let mut random = Random::new(23);
        for _ in 0..100 {
            let response = entry
                .law
                .response(&random.planar_state(3.0))
                .expect("finite");
            let minimum = Stiffness::<2>::of(&response).minimum();
            let q = acoustic(
                &response.tangent,
                [minimum.direction[0], minimum.direction[1]],
            );
            let residual = q * minimum.polarization - minimum.polarization * minimum.eigenvalue.re;
            assert!(residual.amax() < 1e-10 * q.amax());
            assert!((minimum.direction.norm() - 1.0).abs() < 1e-14);
            assert!((minimum.polarization.norm() - 1.0).abs() < 1e-14);
        }
    }
}

#[test]
fn rotating_state_and_directions_keeps_the_eigenvalues() {
    for entry in laws() {
        let mut random = Random::new(24);
        for _ in 0..60 {
            let f = random.planar_state(3.0);
            let (after, before) = (random.planar_rotation(), random.planar_rotation());
            let rotated = of(&(after * f.matrix() * before.transpose()));
            let [one, other] = [f, rotated].map(|f| entry.law.response(&f).expect("finite"));
            // The acoustic tensors of each direction are related by Q'(R N) = A Q(N) A^T.
            let angle = 3.0 * random.number();
            let n = Vector3::new(angle.cos(), angle.sin(), 0.0);
            let turned = before * n;
            let q = acoustic(&one.tangent, [n[0], n[1]]);
            let q_turned = acoustic(&other.tangent, [turned[0], turned[1]]);
            let block = after.fixed_view::<2, 2>(0, 0);
            assert!((q_turned - block * q * block.transpose()).amax() < 1e-11 * q.amax());
            // The minima over all directions agree, too.
            let [a, b] = [one, other].map(|r| Stiffness::<2>::of(&r).minimum());
            assert!(
                (a.eigenvalue.re - b.eigenvalue.re).abs()
                    < 1e-10 * q.amax().max(a.eigenvalue.re.abs())
            );
        }
    }
}

#[test]
fn the_three_dimensional_minimum_is_at_most_a_dense_scan_and_rotates_with_the_state() {
    for entry in laws() {
        let mut random = Random::new(25);
        for _ in 0..12 {
            let f = random.state();
            let response = entry.law.response(&f).expect("finite");
            let minimum = Stiffness::<3>::of(&response).minimum().eigenvalue.re;
            let mut scan = f64::INFINITY;
            for row in 0..40 {
                for column in 0..80 {
                    let (polar, around) = (
                        std::f64::consts::PI * (f64::from(row) + 0.5) / 80.0,
                        std::f64::consts::TAU * f64::from(column) / 80.0,
                    );
                    let n = [
                        polar.sin() * around.cos(),
                        polar.sin() * around.sin(),
                        polar.cos(),
                    ];
                    let q: Matrix3<f64> = acoustic(&response.tangent, n);
                    scan = scan.min(q.symmetric_eigenvalues().min());
                }
            }
            let scale = response.tangent[(0, 0, 0, 0)].abs();
            assert!(
                minimum <= scan + 1e-9 * scale,
                "{minimum} above the scan's {scan}"
            );
            assert!(
                minimum > scan - 0.05 * scale,
                "{minimum} far below the scan's {scan}"
            );
            let rotated = of(&(random.rotation() * f.matrix() * random.rotation()));
            let turned =
                Stiffness::<3>::of(&entry.law.response(&rotated).expect("finite")).minimum();
            assert!((turned.eigenvalue.re - minimum).abs() < 1e-7 * scale);
        }
    }
}

#[test]
fn minima_between_samples_every_ten_degrees_are_found() {
    // Just beyond the onset only directions near the critical one lose ellipticity. Rotated by five degrees from the samples, all of them are missed
    // by sampling.
    let tilt =
        *nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), 5.0_f64.to_radians()).matrix();
    let onset =
        DeformationGradient::from_stretches([1.0, 2.754613297216 * 1.00001, 1.0]).expect("a state");
    let state = of(&(tilt * onset.matrix() * tilt.transpose()));
    let response = laws()[0].law.response(&state).expect("finite");
    for n in 0..18 {
        let angle = f64::from(10 * n).to_radians();
        assert!(
            smallest(&acoustic(&response.tangent, [angle.cos(), angle.sin()])) > 0.0,
            "{n}0 degrees"
        );
    }
    let stiffness = Stiffness::<2>::of(&response);
    assert!(!stiffness.is_strongly_elliptic());
    let minimum = stiffness.minimum();
    assert!(minimum.eigenvalue.re < 0.0);
    // The critical normal lies along the smaller stretch.
    let critical = Vector2::new(tilt[(0, 0)], tilt[(1, 0)]);
    assert!(
        minimum.direction.dot(&critical).abs() > 1.0 - 1e-6,
        "{:?}",
        minimum.direction
    );
}

#[test]
fn the_largest_eigenvalue_belongs_to_the_fastest_wave() {
    for entry in laws() {
        let response = entry
            .law
            .response(&DeformationGradient::identity())
            .expect("finite");
        // The fastest waves are longitudinal, with the modulus K + 4/3 mu.
        let fastest = entry.bulk_modulus + 4.0 / 3.0 * entry.shear_modulus;
        let computed = [
            Stiffness::<1>::of(&response).maximum_eigenvalue(),
            Stiffness::<2>::of(&response).maximum_eigenvalue(),
            Stiffness::<3>::of(&response).maximum_eigenvalue(),
        ];
        for value in computed {
            assert!(
                (value - fastest).abs() < 1e-12 * fastest,
                "{}: {value} against {fastest}",
                entry.name
            );
        }
    }
}
