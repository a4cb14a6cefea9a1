//! Shape functions: reproduction of polynomials, and derivatives compared with finite differences.

use nalgebra::{SMatrix, SVector};
use onset::approximation::{Approximation, Order, ShapeFunctions};
use onset::kernel::Kernel;

/// Support that contains enough neighbors for a cubic basis around a point that is not a particle.
fn radius(approximation: Approximation) -> f64 {
    match approximation {
        Approximation::Mls2 => 2.6,
        Approximation::Mls3 => 3.1,
        _ => 1.9,
    }
}
const RAW_FACTOR: f64 = 0.4;

/// Particles around the origin in an irregular arrangement.
fn scattered<const D: usize>() -> Vec<SVector<f64, D>> {
    let side: usize = if D == 3 { 4 } else { 6 };
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

/// Shape functions at `x` of all particles, with zeros for particles beyond the support.
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
        let radius = radius(approximation);
        if let Some(weight) = Kernel::QuarticSpline.weight(&(particle - x), radius, &metric) {
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
            radius(approximation),
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

/// All monomials of a degree about the evaluation point, by their exponents.
fn exponents<const D: usize>(degree: i32) -> Vec<[i32; D]> {
    let all = (0..(degree + 1).pow(D as u32))
        .map(|n| std::array::from_fn(|i| n / (degree + 1).pow(i as u32) % (degree + 1)));
    all.filter(|e: &[i32; D]| e.iter().sum::<i32>() == degree)
        .collect()
}

/// Largest errors of values and of gradients for the monomials of a degree.
fn reproduction_errors<const D: usize>(at: &Evaluated<D>, degree: i32) -> [f64; 2] {
    let particles = scattered::<D>();
    let (mut of_values, mut of_gradients) = (0.0_f64, 0.0_f64);
    for e in exponents::<D>(degree) {
        let monomial = |x: &SVector<f64, D>| (0..D).map(|i| x[i].powi(e[i])).product::<f64>();
        let relative: Vec<f64> = particles.iter().map(|x| monomial(&(x - point()))).collect();
        let value: f64 = relative
            .iter()
            .zip(&at.values)
            .map(|(q, phi)| q * phi)
            .sum();
        let gradient: SVector<f64, D> = relative
            .iter()
            .zip(&at.gradients)
            .map(|(q, gradient)| gradient * *q)
            .sum();
        // At the center of the expansion only constants have a value, and only linear monomials a gradient.
        let exact = f64::from(u8::from(degree == 0));
        let slope = SVector::from_fn(|i, _| f64::from(u8::from(degree == 1 && e[i] == 1)));
        of_values = of_values.max((value - exact).abs());
        of_gradients = of_gradients.max((gradient - slope).amax());
    }
    [of_values, of_gradients]
}

fn check_reproduction<const D: usize>() {
    for approximation in Approximation::ALL {
        let at = evaluated(approximation, &scattered::<D>(), &point());
        let promised = [approximation.degree(), approximation.degree_of_gradients()];
        for (which, promised) in promised.into_iter().enumerate() {
            let first_missed = promised.map_or(0, |degree| degree + 1) as i32;
            for degree in 0..first_missed {
                let error = reproduction_errors(&at, degree)[which];
                assert!(
                    error < 1e-9,
                    "{approximation:?}, {D}D, degree {degree}: {error:e}"
                );
            }
            let error = reproduction_errors(&at, first_missed)[which];
            assert!(
                error > 1e-4,
                "{approximation:?}, {D}D, degree {first_missed} is not promised: {error:e}"
            );
        }
        // Second derivatives of a partition of unity add up to zero.
        if approximation.degree().is_some() {
            assert!(at.hessians.iter().sum::<SMatrix<f64, D, D>>().amax() < 1e-8);
        }
    }
}

#[test]
fn polynomials_are_reproduced_exactly_up_to_the_stated_degree() {
    check_reproduction::<1>();
    check_reproduction::<2>();
    check_reproduction::<3>();
}

/// Returns true if gradients are the derivatives of the values.
fn is_integrable(approximation: Approximation) -> bool {
    approximation.degree() == approximation.degree_of_gradients()
}

fn check_derivatives<const D: usize>() {
    let particles = scattered::<D>();
    let x = point::<D>();
    let h = 1e-5;
    for approximation in Approximation::ALL {
        let center = evaluated(approximation, &particles, &x);
        let mut largest = 0.0_f64;
        for axis in 0..D {
            let step = unit::<D>(axis) * h;
            let ahead = evaluated(approximation, &particles, &(x + step));
            let behind = evaluated(approximation, &particles, &(x - step));
            for n in 0..particles.len() {
                let first = (ahead.values[n] - behind.values[n]) / (2.0 * h);
                largest = largest.max((center.gradients[n][axis] - first).abs());
                let second = (ahead.gradients[n] - behind.gradients[n]) / (2.0 * h);
                let scale = 1.0 + second.amax();
                let error = (center.hessians[n].column(axis) - second).amax();
                assert!(error < 1e-6 * scale, "{approximation:?}, {D}D: {error:e}");
            }
        }
        match is_integrable(approximation) {
            true => assert!(largest < 1e-7, "{approximation:?}, {D}D: {largest:e}"),
            false => assert!(largest > 1e-3, "{approximation:?}, {D}D are corrected"),
        }
    }
}

#[test]
fn gradients_and_hessians_agree_with_finite_differences() {
    check_derivatives::<1>();
    check_derivatives::<2>();
    check_derivatives::<3>();
}

fn check_sensitivities<const D: usize>() {
    let particles = scattered::<D>();
    let x = point::<D>();
    let h = 1e-5;
    for approximation in Approximation::ALL {
        let center = evaluated(approximation, &particles, &x);
        for (k, &moved) in center
            .seen
            .iter()
            .enumerate()
            .step_by(if D == 3 { 5 } else { 1 })
        {
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
                        error < 1e-6 * (1.0 + difference.amax()),
                        "{approximation:?}, {D}D, {i} by {k}: {error:e}"
                    );
                }
            }
        }
        // Moving all particles is equivalent to moving the point in the opposite direction.
        for i in 0..center.seen.len() {
            let all: SMatrix<f64, D, D> = (0..center.seen.len())
                .map(|k| center.shape.sensitivity(i, k))
                .sum();
            let error = (all + center.shape.hessians[i]).amax();
            assert!(error < 1e-8, "{approximation:?}, {D}D: {error:e}");
        }
    }
}

#[test]
fn sensitivities_to_the_motion_of_particles_agree_with_finite_differences() {
    check_sensitivities::<1>();
    check_sensitivities::<2>();
    check_sensitivities::<3>();
}

/// Checks the relations that distinguish the two corrections.
fn check_corrections<const D: usize>() {
    use Approximation::{KrongauzBelytschko, RandlesLibersky};
    let particles = scattered::<D>();
    let gradients =
        |approximation, x: &SVector<f64, D>| evaluated(approximation, &particles, x).gradients;
    let apart = |x: &SVector<f64, D>| {
        let both = [RandlesLibersky, KrongauzBelytschko].map(|a| gradients(a, x));
        let pairs = both[0].iter().zip(&both[1]);
        pairs.map(|(a, b)| (a - b).amax()).fold(0.0, f64::max)
    };
    assert!(
        apart(&point()) < 1e-13,
        "away from particles they are the same"
    );
    let middle = particles[particles.len() / 2];
    assert!(
        apart(&middle) > 1e-3,
        "at a particle the one takes differences to its own value"
    );
    // There the particle itself has the weight that balances all others, although its kernel has zero slope.
    let at = gradients(RandlesLibersky, &middle);
    assert!(
        at.iter().sum::<SVector<f64, D>>().amax() < 1e-12 && at[particles.len() / 2].amax() > 1e-3
    );
}

#[test]
fn the_two_corrected_derivatives_differ_only_at_particles() {
    check_corrections::<1>();
    check_corrections::<2>();
    check_corrections::<3>();
}

#[test]
fn frozen_second_derivatives_hold_the_normalization() {
    let particles = scattered::<2>();
    let metric = SMatrix::<f64, 2, 2>::identity();
    let shepard = evaluated(Approximation::Shepard, &particles, &point());
    let weight = |n: usize| {
        Kernel::QuarticSpline
            .weight(
                &(particles[n] - point()),
                radius(Approximation::Shepard),
                &metric,
            )
            .expect("seen")
    };
    let sum: f64 = shepard.seen.iter().map(|&n| weight(n).value).sum();
    for (k, &n) in shepard.seen.iter().enumerate() {
        assert!((shepard.shape.frozen_hessians[k] - weight(n).hessian / sum).amax() < 1e-13);
    }
    // For a corrected gradient only the second derivative of the weight remains, mapped by the same matrix.
    let corrected = evaluated(Approximation::KrongauzBelytschko, &particles, &point());
    let slopes: Vec<SVector<f64, 2>> = corrected
        .seen
        .iter()
        .map(|&n| -weight(n).gradient)
        .collect();
    let total: SVector<f64, 2> = slopes.iter().sum();
    let moment: SMatrix<f64, 2, 2> = corrected
        .seen
        .iter()
        .zip(&slopes)
        .map(|(&n, g)| (particles[n] - point()) * (g - total * (weight(n).value / sum)).transpose())
        .sum();
    let inverse = moment.try_inverse().expect("a regular moment");
    for (k, &n) in corrected.seen.iter().enumerate() {
        let expected = inverse.transpose() * weight(n).hessian;
        assert!((corrected.shape.frozen_hessians[k] - expected).amax() < 1e-12);
    }
    let raw = evaluated(Approximation::Raw, &particles, &point());
    assert_eq!(
        raw.shape.frozen_hessians, raw.shape.hessians,
        "raw weights have no normalization"
    );
}
