//! Shape functions: what they reproduce, and their derivatives against differences.

use nalgebra::{SMatrix, SVector};
use onset::approximation::{Approximation, Order, ShapeFunctions};
use onset::kernel::Kernel;

const ALL: [Approximation; 3] = [
    Approximation::Raw,
    Approximation::Shepard,
    Approximation::Mls,
];
const RADIUS: f64 = 1.9;
const RAW_FACTOR: f64 = 0.4;

/// Particles around the origin in no order of any kind.
fn scattered<const D: usize>() -> Vec<SVector<f64, D>> {
    let side: usize = if D == 3 { 3 } else { 5 };
    (0..side.pow(D as u32))
        .map(|n| {
            SVector::from_fn(|i, _| {
                let cell = n / side.pow(i as u32) % side;
                let jitter = (12.9898 * (n * D + i) as f64 + 1.0).sin() * 0.17;
                cell as f64 - (side - 1) as f64 / 2.0 + jitter
            })
        })
        .collect()
}

/// The shape functions at `x` of all particles, those out of reach with zeros.
struct Evaluated<const D: usize> {
    values: Vec<f64>,
    gradients: Vec<SVector<f64, D>>,
    hessians: Vec<SMatrix<f64, D, D>>,
    shape: ShapeFunctions<D>,
    seen: Vec<usize>,
}

fn evaluated<const D: usize>(
    approximation: Approximation,
    particles: &[SVector<f64, D>],
    x: &SVector<f64, D>,
) -> Evaluated<D> {
    let metric = SMatrix::<f64, D, D>::identity();
    let (mut seen, mut positions, mut weights) = (Vec::new(), Vec::new(), Vec::new());
    for (n, particle) in particles.iter().enumerate() {
        if let Some(weight) = Kernel::QuarticSpline.weight(&(particle - x), RADIUS, &metric) {
            seen.push(n);
            positions.push(particle - x);
            weights.push(weight);
        }
    }
    let shape = approximation
        .shape_functions(
            &positions,
            &weights,
            RAW_FACTOR,
            RADIUS,
            Order::Sensitivities,
        )
        .expect("enough neighbors");
    let mut all = Evaluated {
        values: vec![0.0; particles.len()],
        gradients: vec![SVector::zeros(); particles.len()],
        hessians: vec![SMatrix::zeros(); particles.len()],
        shape: shape.clone(),
        seen: seen.clone(),
    };
    for (k, &n) in seen.iter().enumerate() {
        all.values[n] = shape.values[k];
        all.gradients[n] = shape.gradients[k];
        all.hessians[n] = shape.hessians[k];
    }
    all
}

fn point<const D: usize>() -> SVector<f64, D> {
    SVector::from_fn(|i, _| 0.23 - 0.31 * i as f64)
}

fn unit<const D: usize>(axis: usize) -> SVector<f64, D> {
    SVector::from_fn(|i, _| if i == axis { 1.0 } else { 0.0 })
}

fn check_reproduction<const D: usize>() {
    let particles = scattered::<D>();
    for approximation in [Approximation::Shepard, Approximation::Mls] {
        let at = evaluated(approximation, &particles, &point());
        assert!(
            (at.values.iter().sum::<f64>() - 1.0).abs() < 1e-13,
            "a partition of unity"
        );
        assert!(at.gradients.iter().sum::<SVector<f64, D>>().amax() < 1e-12);
        assert!(at.hessians.iter().sum::<SMatrix<f64, D, D>>().amax() < 1e-11);
        // sum x_K phi_K = x and sum x_K (x) grad phi_K = 1.
        let place: SVector<f64, D> = particles
            .iter()
            .zip(&at.values)
            .map(|(x, phi)| x * *phi)
            .sum();
        let moment: SMatrix<f64, D, D> = particles
            .iter()
            .zip(&at.gradients)
            .map(|(x, gradient)| x * gradient.transpose())
            .sum();
        let error = (place - point())
            .amax()
            .max((moment - SMatrix::identity()).amax());
        match approximation {
            Approximation::Mls => assert!(error < 1e-12, "linear completeness: {error:e}"),
            _ => assert!(
                error > 1e-3,
                "weights without a linear basis are not linearly complete"
            ),
        }
    }
    let raw: f64 = evaluated(Approximation::Raw, &particles, &point())
        .values
        .iter()
        .sum();
    assert!(
        (raw - 1.0).abs() > 1e-3,
        "raw weights are no partition of unity"
    );
}

#[test]
fn shepard_and_least_squares_reproduce_constants_but_only_least_squares_linear_fields() {
    check_reproduction::<1>();
    check_reproduction::<2>();
    check_reproduction::<3>();
}

fn check_derivatives<const D: usize>() {
    let particles = scattered::<D>();
    let x = point::<D>();
    let h = 1e-5;
    for approximation in ALL {
        let center = evaluated(approximation, &particles, &x);
        for axis in 0..D {
            let step = unit::<D>(axis) * h;
            let ahead = evaluated(approximation, &particles, &(x + step));
            let behind = evaluated(approximation, &particles, &(x - step));
            for n in 0..particles.len() {
                let first = (ahead.values[n] - behind.values[n]) / (2.0 * h);
                assert!(
                    (center.gradients[n][axis] - first).abs() < 1e-7,
                    "{approximation:?}, {D}D"
                );
                let second = (ahead.gradients[n] - behind.gradients[n]) / (2.0 * h);
                let error = (center.hessians[n].column(axis) - second).amax();
                assert!(error < 1e-6, "{approximation:?}, {D}D: {error:e}");
            }
        }
    }
}

#[test]
fn gradients_and_hessians_are_those_that_differences_show() {
    check_derivatives::<1>();
    check_derivatives::<2>();
    check_derivatives::<3>();
}

fn check_sensitivities<const D: usize>() {
    let particles = scattered::<D>();
    let x = point::<D>();
    let h = 1e-5;
    for approximation in ALL {
        let center = evaluated(approximation, &particles, &x);
        for (k, &moved) in center.seen.iter().enumerate() {
            for axis in 0..D {
                let gradients = |t: f64| {
                    let mut particles = particles.clone();
                    particles[moved] += unit::<D>(axis) * t;
                    evaluated(approximation, &particles, &x).gradients
                };
                let (ahead, behind) = (gradients(h), gradients(-h));
                for (i, &of) in center.seen.iter().enumerate() {
                    let difference = (ahead[of] - behind[of]) / (2.0 * h);
                    let error = (center.shape.sensitivity(i, k).column(axis) - difference).amax();
                    assert!(
                        error < 1e-6,
                        "{approximation:?}, {D}D, {i} by {k}: {error:e}"
                    );
                }
            }
        }
        // Moving all particles is moving the point the other way.
        for i in 0..center.seen.len() {
            let all: SMatrix<f64, D, D> = (0..center.seen.len())
                .map(|k| center.shape.sensitivity(i, k))
                .sum();
            assert!(
                (all + center.shape.hessians[i]).amax() < 1e-11,
                "{approximation:?}, {D}D"
            );
        }
    }
}

#[test]
fn sensitivities_to_the_motion_of_particles_are_those_that_differences_show() {
    check_sensitivities::<1>();
    check_sensitivities::<2>();
    check_sensitivities::<3>();
}

#[test]
fn frozen_second_derivatives_hold_the_normalization() {
    let particles = scattered::<2>();
    let metric = SMatrix::<f64, 2, 2>::identity();
    let shepard = evaluated(Approximation::Shepard, &particles, &point());
    let weight = |n: usize| {
        Kernel::QuarticSpline
            .weight(&(particles[n] - point()), RADIUS, &metric)
            .expect("seen")
    };
    let sum: f64 = shepard.seen.iter().map(|&n| weight(n).value).sum();
    for (k, &n) in shepard.seen.iter().enumerate() {
        assert!((shepard.shape.frozen_hessians[k] - weight(n).hessian / sum).amax() < 1e-13);
    }
    let raw = evaluated(Approximation::Raw, &particles, &point());
    assert_eq!(
        raw.shape.frozen_hessians, raw.shape.hessians,
        "raw weights have no normalization"
    );
}
