//! Integrals against closed forms and published tables.

use super::kernels;
use onset::kernel::Kernel;
use std::f64::consts::PI;

/// Midpoint rule on a fine grid, independent of the crate's quadrature.
fn brute<const D: usize>(kernel: Kernel, order: i32) -> f64 {
    let n = 20_000;
    let sphere = [2.0, 2.0 * PI, 4.0 * PI][D - 1];
    let sum: f64 = (0..n)
        .map(|i| {
            let q = (f64::from(i) + 0.5) / f64::from(n);
            kernel.profile::<D, f64>(q).value * q.powi(D as i32 - 1 + order)
        })
        .sum();
    sphere * sum / f64::from(n)
}

fn integrals_are_quadratures<const D: usize>() {
    for kernel in kernels() {
        let integral = kernel.integral::<D>(1.0);
        assert!(
            (integral - brute::<D>(kernel, 0)).abs() < 5e-9,
            "{kernel} {D}D"
        );
        let by_rule = kernel.moment::<D>(1.0, 0);
        assert!(
            (integral - by_rule).abs() < 1e-14 * 10.0,
            "{kernel} {D}D: {integral} {by_rule}"
        );
        assert!((kernel.moment::<D>(1.0, 2) - brute::<D>(kernel, 2)).abs() < 5e-9);
        let scale = 2.5_f64.powi(D as i32);
        assert!((kernel.integral::<D>(2.5) / integral / scale - 1.0).abs() < 1e-14);
        assert!((kernel.normalization::<D>(2.5) * integral * scale - 1.0).abs() < 1e-14);
    }
}

#[test]
fn integrals_and_moments_agree_with_brute_force_quadrature() {
    integrals_are_quadratures::<1>();
    integrals_are_quadratures::<2>();
    integrals_are_quadratures::<3>();
}

#[test]
fn normalizations_and_ratios_agree_with_dehnen_and_aly() {
    // Table 1: the value at the origin of the published form, its normalization, and H/h, whose last printed decimal is off by up to two.
    let table = [
        (
            Kernel::CubicSpline,
            0.5,
            [8.0 / 3.0, 80.0 / (7.0 * PI), 16.0 / PI],
            [1.732051, 1.778002, 1.825742],
        ),
        (
            Kernel::QuarticBSpline,
            46.0 / 125.0,
            [
                3125.0 / 768.0,
                46875.0 / (2398.0 * PI),
                15625.0 / (512.0 * PI),
            ],
            [1.936492, 1.977173, 2.018932],
        ),
        (
            Kernel::QuinticSpline,
            22.0 / 81.0,
            [243.0 / 40.0, 15309.0 / (478.0 * PI), 2187.0 / (40.0 * PI)],
            [2.121321, 2.158131, 2.195775],
        ),
        (
            Kernel::WendlandC2,
            1.0,
            [5.0 / 4.0, 7.0 / PI, 21.0 / (2.0 * PI)],
            [1.620185, 1.897367, 1.936492],
        ),
        (
            Kernel::WendlandC4,
            1.0,
            [1.5, 9.0 / PI, 495.0 / (32.0 * PI)],
            [1.936492, 2.171239, 2.207940],
        ),
        (
            Kernel::WendlandC6,
            1.0,
            [55.0 / 32.0, 78.0 / (7.0 * PI), 1365.0 / (64.0 * PI)],
            [2.207940, 2.415230, 2.449490],
        ),
    ];
    for (kernel, peak, norms, ratios) in table {
        let own = [
            kernel.normalization::<1>(1.0),
            kernel.normalization::<2>(1.0),
            kernel.normalization::<3>(1.0),
        ];
        let measured = [
            kernel.support_over_smoothing_length::<1>(),
            kernel.support_over_smoothing_length::<2>(),
            kernel.support_over_smoothing_length::<3>(),
        ];
        for i in 0..3 {
            assert!(
                (own[i] / (norms[i] * peak) - 1.0).abs() < 1e-14,
                "{kernel} {i}"
            );
            assert!(
                (measured[i] - ratios[i]).abs() < 2e-6,
                "{kernel} {i}: {}",
                measured[i]
            );
        }
    }
}

#[test]
fn the_ratio_of_the_c4_function_in_the_plane_has_a_closed_form() {
    // sigma^2 = 7/132 from beta functions; the table prints 2.171239.
    let ratio = Kernel::WendlandC4.support_over_smoothing_length::<2>();
    assert!((ratio - (33.0_f64 / 7.0).sqrt()).abs() < 1e-14);
}

#[test]
fn the_hyperbolic_kernel_has_its_published_normalization() {
    // The published normalizations are 1/(7 h), 1/(3 pi h^2), 15/(62 pi h^3) for a kernel that is 6 at the origin and ends at 2 h.
    let own = [
        Kernel::Hyperbolic.normalization::<1>(2.0),
        Kernel::Hyperbolic.normalization::<2>(2.0),
        Kernel::Hyperbolic.normalization::<3>(2.0),
    ];
    let published = [1.0 / 7.0, 1.0 / (3.0 * PI), 15.0 / (62.0 * PI)];
    for (own, published) in own.into_iter().zip(published) {
        assert!((own / (6.0 * published) - 1.0).abs() < 1e-14);
    }
}

#[test]
fn smooth_truncation_changes_the_gaussian_by_less_than_one_percent() {
    for n in 0..=100 {
        let q = f64::from(n) / 100.0;
        let plain = (-9.0 * q * q).exp();
        let difference = Kernel::Gaussian.profile::<2, f64>(q).value - plain;
        assert!(difference.abs() < 0.007, "{q}: {difference}");
    }
}

#[test]
fn the_radius_for_a_smoothing_length_reproduces_this_length() {
    for kernel in kernels() {
        let radius = kernel.radius_of::<3>(0.7);
        let sigma = kernel.standard_deviation::<3>(radius);
        assert!((2.0 * sigma - 0.7).abs() < 1e-13, "{kernel}");
    }
}

#[test]
fn the_papers_quartic_is_wendlands_function_of_one_dimension() {
    let (paper, wendland) = (Kernel::QuarticSpline, Kernel::WendlandC2);
    for n in 0..=20 {
        let q = f64::from(n) / 20.0;
        let printed = 1.0 - 6.0 * q.powi(2) + 8.0 * q.powi(3) - 3.0 * q.powi(4);
        assert!((paper.profile::<3, f64>(q).value - printed).abs() < 1e-14);
        assert_eq!(paper.profile::<1, f64>(q), wendland.profile::<1, f64>(q));
    }
}
