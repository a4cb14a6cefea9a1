//! Chains of kernel methods, whose alternating wave is computed by hand.

use crate::states::saint_venant_kirchhoff;
use nalgebra::SVector;
use onset::kinematics::DeformationGradient;
use onset::lattice::LatticeKind;
use onset::method::{KernelMethodChoices, Method};
use onset::quadrature::Quadrature;
use onset::scheme::Discretization;
use std::f64::consts::PI;

/// Squared frequency `omega^2` of the wave of alternating particles, with `E = rho = spacing = 1`, Shepard functions and the quartic spline.
fn alternating(quadrature: Quadrature, support: f64) -> f64 {
    let method = Method::<1>::new(KernelMethodChoices {
        lattice: LatticeKind::Chain,
        quadrature,
        support,
        ..KernelMethodChoices::default()
    })
    .expect("a method");
    // The modulus is lambda + 2 mu = 1.
    let material = saint_venant_kirchhoff(0.5, 0.25);
    let waves = method
        .waves(&*material, &DeformationGradient::identity())
        .expect("waves");
    waves.omega_squared(&SVector::from_element(PI))[0].re
}

/// Squared frequency `omega^2` in closed form: half of the volume is at the midpoints, with the gradient `sum_K (-1)^K phi_K'`; the gradient at the
/// particles is zero.
fn by_hand(support: f64) -> f64 {
    let weight = |x: f64| {
        let q = x.abs() / support;
        if q < 1.0 {
            let value = (1.0 - q).powi(3) * (1.0 + 3.0 * q);
            let slope = -12.0 * q * (1.0 - q).powi(2) * x.signum() / support;
            (value, slope)
        } else {
            (0.0, 0.0)
        }
    };
    let particles = (-6..6).map(|n| (f64::from(n), weight(0.5 - f64::from(n))));
    let (mut sum, mut slopes, mut seen, mut seen_slopes) = (0.0, 0.0, 0.0, 0.0);
    for (place, (value, slope)) in particles {
        let sign = (PI * place).cos();
        sum += value;
        slopes += slope;
        seen += sign * value;
        seen_slopes += sign * slope;
    }
    let gradient = (seen_slopes - seen * slopes / sum) / sum;
    0.5 * gradient * gradient
}

#[test]
fn alternating_particles_have_zero_energy_with_nodal_integration_and_little_with_stress_points() {
    let published = [
        (1.5, 2.0),
        (2.0, 0.254093),
        (2.5, 0.011834),
        (3.0, 0.001077),
    ];
    for (support, expected) in published {
        let nodal = alternating(Quadrature::Nodal, support);
        assert!(nodal.abs() < 1e-14, "{nodal} at {support}");
        let found = alternating(Quadrature::StressPoints, support);
        assert!((found - expected).abs() < 6e-7, "{found} at {support}");
        assert!(
            (found - by_hand(support)).abs() < 1e-13,
            "{found} at {support}"
        );
    }
}
