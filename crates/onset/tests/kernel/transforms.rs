//! Fourier transforms of kernels, and the pairing of particles.

use super::kernels;
use onset::kernel::Kernel;

fn assert_expansion_in_moments<const D: usize>() {
    for kernel in kernels() {
        let radius = 1.3;
        let transform = |k: f64| kernel.fourier_transform::<D>(radius, k);
        let integral = kernel.integral::<D>(radius);
        assert!(
            (transform(0.0) / integral - 1.0).abs() < 1e-13,
            "{kernel} {D}D"
        );
        // The expansion is 1 - k^2 sigma^2/2 + k^4 <x_1^4>/24, with <x_1^4> = 3 <r^4> / (D (D + 2)).
        let k = 0.05;
        let variance = kernel.standard_deviation::<D>(radius).powi(2);
        let d = D as f64;
        let fourth = 3.0 * kernel.moment::<D>(radius, 4) / integral / (d * (d + 2.0));
        let expansion = 1.0 - k * k * variance / 2.0 + k.powi(4) * fourth / 24.0;
        assert!(
            (transform(k) / integral - expansion).abs() < 1e-10,
            "{kernel} {D}D"
        );
        assert_eq!(transform(k), transform(-k));
    }
}

#[test]
fn the_transform_of_long_waves_follows_from_integral_and_moments() {
    assert_expansion_in_moments::<1>();
    assert_expansion_in_moments::<2>();
    assert_expansion_in_moments::<3>();
}

#[test]
fn the_transforms_of_one_and_three_dimensions_are_related_by_a_derivative() {
    // The transforms F1 and F3 in one and three dimensions satisfy F3(k) = -2 pi F1'(k) / k.
    for kernel in kernels() {
        // These functions differ between one and three dimensions.
        if matches!(
            kernel,
            Kernel::WendlandC2 | Kernel::WendlandC4 | Kernel::WendlandC6
        ) {
            continue;
        }
        let one = |k: f64| kernel.fourier_transform::<1>(1.0, k);
        for k in [0.7, 3.0, 9.0, 25.0] {
            let h = 1e-3;
            let slope = (8.0 * (one(k + h) - one(k - h)) - (one(k + 2.0 * h) - one(k - 2.0 * h)))
                / (12.0 * h);
            let three = kernel.fourier_transform::<3>(1.0, k);
            assert!(
                (three + std::f64::consts::TAU * slope / k).abs() < 1e-9,
                "{kernel} {k}"
            );
        }
    }
}

#[test]
fn the_transform_of_the_plane_is_the_projection_along_one_direction() {
    // The transform in the plane is F2(k) = int cos(k x) (int W dy) dx, on a grid of the square.
    let n = 400;
    for kernel in [Kernel::QuinticSpline, Kernel::WendlandC4, Kernel::Gaussian] {
        let k = 7.0;
        let mut sum = 0.0;
        for i in 0..n {
            for j in 0..n {
                let [x, y] = [i, j].map(|i| (f64::from(i) + 0.5) / f64::from(n));
                let q = x.hypot(y);
                if q < 1.0 {
                    sum += kernel.profile::<2, f64>(q).value * (k * x).cos();
                }
            }
        }
        let brute = 4.0 * sum / f64::from(n * n);
        let transform = kernel.fourier_transform::<2>(1.0, k);
        assert!(
            (brute - transform).abs() < 1e-6,
            "{kernel}: {brute} {transform}"
        );
    }
}

#[test]
fn b_splines_of_one_dimension_are_powers_of_a_sinc() {
    for (kernel, n) in [
        (Kernel::CubicSpline, 4),
        (Kernel::QuarticBSpline, 5),
        (Kernel::QuinticSpline, 6),
    ] {
        for k in [0.5, 4.0, 11.0, 40.0] {
            // The spline is a convolution of n boxes of the width 2/n.
            let x = k / f64::from(n);
            let closed = kernel.integral::<1>(1.0) * (x.sin() / x).powi(n);
            assert!((kernel.fourier_transform::<1>(1.0, k) - closed).abs() < 1e-14);
        }
    }
}

/// Smallest value of the transform relative to its long-wave value.
fn least<const D: usize>(kernel: Kernel) -> f64 {
    let transforms = (0..600).map(|n| kernel.fourier_transform::<D>(1.0, 0.1 * f64::from(n)));
    transforms.fold(f64::INFINITY, f64::min) / kernel.integral::<D>(1.0)
}

#[test]
fn only_wendlands_functions_prevent_pairing() {
    // Dehnen and Aly (2012), section 2.5: the transforms of the B-splines are negative for some waves. The transforms of Wendland's functions are
    // positive for all waves in the dimension for which the functions are defined.
    for kernel in [Kernel::WendlandC2, Kernel::WendlandC4, Kernel::WendlandC6] {
        for least in [least::<1>(kernel), least::<2>(kernel), least::<3>(kernel)] {
            assert!(least > -1e-15, "{kernel}: {least}");
        }
    }
    for kernel in [
        Kernel::CubicSpline,
        Kernel::QuarticBSpline,
        Kernel::QuinticSpline,
    ] {
        assert!(least::<2>(kernel) < -1e-5, "{kernel}");
        assert!(least::<3>(kernel) < -1e-5, "{kernel}");
    }
    // Even powers of a sinc are positive: in one dimension only M5 is negative for some waves.
    assert!(least::<1>(Kernel::CubicSpline) > -1e-15);
    assert!(least::<1>(Kernel::QuinticSpline) > -1e-15);
    assert!(least::<1>(Kernel::QuarticBSpline) < -1e-4);
}

#[test]
fn wendlands_function_of_one_dimension_allows_pairing_in_three() {
    assert!(least::<1>(Kernel::QuarticSpline) > -1e-15);
    assert!(least::<3>(Kernel::QuarticSpline) < -1e-4);
}
