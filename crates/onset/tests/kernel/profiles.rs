//! Values and derivatives of kernels.

use super::kernels;
use nalgebra::{SMatrix, SVector};
use onset::kernel::Kernel;
use onset::real::{Interval, Jet, Real};

/// Distances that are not close to breaks.
const PLACES: [f64; 11] = [
    1e-4, 0.05, 0.17, 0.23, 0.31, 0.37, 0.49, 0.53, 0.71, 0.88, 0.997,
];

/// Value `W` and its first four derivatives, by differentiation of the value alone.
fn orders<const D: usize>(kernel: Kernel, q: f64) -> [f64; 5] {
    let [inner] = Jet::<1>::variables([q]);
    let [outer] = Jet::variables([inner]);
    let jet = kernel.profile::<D, Jet<1, Jet<1>>>(outer).value;
    let second = jet.hessian[0][0];
    [
        jet.value.value,
        jet.gradient[0].value,
        second.value,
        second.gradient[0],
        second.hessian[0][0],
    ]
}

fn slopes_are_derivatives<const D: usize>() {
    for kernel in kernels() {
        for q in PLACES {
            let [value, slope, curvature, ..] = orders::<D>(kernel, q);
            let profile = kernel.profile::<D, f64>(q);
            let close = |a: f64, b: f64| {
                assert!(
                    (a - b).abs() < 1e-9 * (1.0 + b.abs()) / q,
                    "{kernel} {D}D q = {q}: {a} {b}"
                )
            };
            close(profile.value, value);
            close(profile.slope_over_q, slope / q);
            close(profile.curvature_over_q, (curvature - slope / q) / q);
        }
    }
}

#[test]
fn slope_and_curvature_are_derivatives_of_the_value() {
    slopes_are_derivatives::<1>();
    slopes_are_derivatives::<2>();
    slopes_are_derivatives::<3>();
}

#[test]
fn every_kernel_decreases_from_one_at_the_origin_to_zero_at_the_rim() {
    for kernel in kernels() {
        let origin = kernel.profile::<2, f64>(0.0);
        assert!((origin.value - 1.0).abs() < 1e-14, "{kernel}");
        assert!(origin.slope_over_q.is_finite() && origin.curvature_over_q.is_finite());
        assert!(
            kernel.profile::<2, f64>(1.0).value.abs() < 1e-14,
            "{kernel}"
        );
        let values: Vec<f64> = (0..=1000)
            .map(|n| kernel.profile::<3, f64>(f64::from(n) / 1000.0).value)
            .collect();
        assert!(
            values.windows(2).all(|pair| pair[1] < pair[0] + 1e-15),
            "{kernel} is not monotone"
        );
    }
}

/// Checks that derivatives vanish at the rim up to the stated order, and that the next derivative does not.
fn assert_smoothness_at_the_rim<const D: usize>() {
    for kernel in kernels() {
        let rim = kernel.smoothness::<D>().rim.expect("no kernel is analytic");
        for (order, derivative) in orders::<D>(kernel, 1.0).into_iter().enumerate() {
            let vanishes = derivative.abs() < 1e-7;
            if order as u32 <= rim {
                assert!(
                    vanishes,
                    "{kernel} {D}D: derivative {order} is {derivative}"
                );
            } else if order as u32 == rim + 1 {
                assert!(!vanishes, "{kernel} {D}D: derivative {order} vanishes");
            }
        }
    }
}

/// Checks that odd derivatives vanish at the origin up to the stated order.
fn assert_smoothness_at_the_origin<const D: usize>() {
    for kernel in kernels() {
        let told = kernel.smoothness::<D>().origin;
        // At a smaller distance the value would be the mean over the cusp region.
        let orders = orders::<D>(kernel, 1e-9);
        for order in [1, 3] {
            let vanishes = orders[order].abs() < 1e-5;
            match told {
                Some(told) if order as u32 == told + 1 => {
                    assert!(!vanishes, "{kernel} {D}D {orders:?}")
                }
                Some(told) if order as u32 > told => {}
                _ => assert!(vanishes, "{kernel} {D}D {orders:?}"),
            }
        }
    }
}

#[test]
fn derivatives_at_the_rim_have_the_stated_smoothness() {
    assert_smoothness_at_the_rim::<1>();
    assert_smoothness_at_the_rim::<2>();
    assert_smoothness_at_the_rim::<3>();
}

#[test]
fn derivatives_at_the_origin_have_the_stated_smoothness() {
    assert_smoothness_at_the_origin::<1>();
    assert_smoothness_at_the_origin::<2>();
    assert_smoothness_at_the_origin::<3>();
}

#[test]
fn joints_of_pieces_have_the_stated_smoothness() {
    let breaks = [
        (Kernel::CubicSpline, 0.5),
        (Kernel::QuarticBSpline, 0.2),
        (Kernel::QuarticBSpline, 0.6),
        (Kernel::QuinticSpline, 1.0 / 3.0),
        (Kernel::QuinticSpline, 2.0 / 3.0),
        (Kernel::Hyperbolic, 0.5),
    ];
    for (kernel, place) in breaks {
        let inside = kernel.smoothness::<2>().inside.expect("pieces");
        let [below, above] = [-1e-12, 1e-12].map(|step| orders::<2>(kernel, place + step));
        for order in 0..=inside as usize {
            assert!(
                (below[order] - above[order]).abs() < 1e-7,
                "{kernel} {order}"
            );
        }
        if inside < 4 {
            let next = inside as usize + 1;
            assert!((below[next] - above[next]).abs() > 1.0, "{kernel} {next}");
        }
    }
}

#[test]
fn gradients_and_hessians_agree_with_differences_for_any_metric() {
    let metric = SMatrix::<f64, 3, 3>::new(0.9, 0.2, 0.1, -0.1, 1.2, 0.0, 0.05, 0.1, 1.1);
    let x = SVector::<f64, 3>::new(0.7, -0.4, 0.3);
    let h = 1e-5;
    for kernel in kernels() {
        let at = |x: SVector<f64, 3>| kernel.weight(&x, 2.0, &metric).expect("inside");
        for j in 0..3 {
            let mut step = SVector::zeros();
            step[j] = h;
            let (plus, minus) = (at(x + step), at(x - step));
            assert!(((plus.value - minus.value) / (2.0 * h) - at(x).gradient[j]).abs() < 1e-8);
            let second = (plus.gradient - minus.gradient) / (2.0 * h);
            assert!((second - at(x).hessian.column(j)).amax() < 1e-7, "{kernel}");
        }
    }
}

#[test]
fn a_particle_exerts_no_force_on_itself() {
    for kernel in kernels() {
        let weight = kernel
            .weight(&SVector::<f64, 2>::zeros(), 1.5, &SMatrix::identity())
            .expect("inside");
        assert_eq!(weight.gradient.amax(), 0.0, "{kernel}");
        assert!(weight.hessian.iter().all(|x| x.is_finite()), "{kernel}");
    }
}

#[test]
fn intervals_contain_the_profile_at_all_distances() {
    for kernel in kernels() {
        for (low, high) in [
            (0.0, 1e-6),
            (0.0, 0.01),
            (0.15, 0.25),
            (0.3, 0.35),
            (0.45, 0.55),
            (0.7, 0.7001),
            (0.9, 1.0),
        ] {
            let held = kernel.profile::<2, Interval>(Interval::new(low, high));
            for n in 0..=50 {
                let q = low + (high - low) * f64::from(n) / 50.0;
                let profile = kernel.profile::<2, f64>(q);
                let holds = |interval: Interval, x: f64| {
                    let slack = 1e-9 * (1.0 + x.abs());
                    assert!(
                        interval.low - slack <= x && x <= interval.high + slack,
                        "{kernel} at {q}: {x} not in {interval:?}"
                    );
                };
                holds(held.value, profile.value);
                holds(held.slope_over_q, profile.slope_over_q);
                holds(held.curvature_over_q, profile.curvature_over_q);
            }
        }
        let narrow = kernel.profile::<2, Interval>(Interval::constant(0.77));
        assert!(narrow.curvature_over_q.width() < 1e-9, "{kernel}");
    }
}
