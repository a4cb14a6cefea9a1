//! Time steps of damped chains and oscillators in closed form.

use crate::random::Random;
use nalgebra::{Complex, Matrix3, SMatrix, SVector};
use onset::bloch::{BlochBlocks, Mass, WaveSystem, ZoneSearch};
use onset::kinematics::DeformationGradient;
use onset::lattice::{Crystal, LatticeKind, Particle};
use onset::material::ModifiedMooneyRivlin;
use onset::scheme::Discretization;
use onset::scheme::sph::{TotalLagrangianChoices, TotalLagrangianSph};
use onset::scheme::stabilization::{ArtificialViscosity, Upwinding};
use onset::time_step::{
    Amplification, ImplicitIntegrator, Integrator, critical_time_step, critical_time_step_at,
};
use std::f64::consts::PI;

/// Chain of unit masses and springs with dashpots `c` parallel to the springs, or with damping proportional to the masses (`mass`).
fn chain(between: f64, mass: f64) -> WaveSystem<1> {
    let lattice = LatticeKind::Chain.lattice::<1>(1.0).expect("a lattice");
    let crystal = Crystal::of_lattice(lattice);
    let home = Particle::home(0);
    let next = home.moved(&[1]);
    let number = SMatrix::<f64, 1, 1>::from_element;
    let (mut stiffness, mut damping) = (BlochBlocks::new(), BlochBlocks::new());
    for (from, to, factor) in [(home, home, 2.0), (home, next, -1.0), (next, home, -1.0)] {
        stiffness.add(&from, &to, &number(factor));
        damping.add(&from, &to, &number(between * factor));
    }
    damping.add(&home, &home, &number(mass));
    let stiffness = stiffness.sum(&crystal);
    let damping = damping.sum(&crystal);
    WaveSystem::new(crystal, stiffness, Mass::Lumped(vec![1.0])).with_damping(damping)
}

#[test]
fn without_damping_the_largest_frequency_bounds_the_step_of_every_integrator() {
    let system = chain(0.0, 0.0);
    let wave = Amplification::new(&system, &SVector::from_element(PI));
    for integrator in Integrator::ALL {
        let expected = 0.5 * integrator.undamped_reach();
        let radius = |share: f64| wave.spectral_radius(integrator, share * expected);
        assert!(expected == 0.0 || radius(0.999) < 1.0 + 1e-12);
        assert!(expected == 0.0 || radius(1.001) > 1.0 + 1e-4);
        let search = ZoneSearch::of_lattice(*system.crystal().lattice(), 1.0);
        let step = critical_time_step(&system, integrator, &search);
        assert!((step - expected).abs() < 1e-10, "{step} of {integrator:?}");
    }
    let unstable = [Integrator::ForwardEuler, Integrator::Heun];
    for integrator in unstable {
        assert_eq!(integrator.undamped_reach(), 0.0);
        assert!(wave.spectral_radius(integrator, 0.1) > 1.0);
    }
}

#[test]
fn names_of_integrators_are_unique_and_can_be_parsed() {
    for integrator in Integrator::ALL {
        assert_eq!(Integrator::named(integrator.name()), Some(integrator));
    }
    let symplectic = Integrator::named("symplectic-euler");
    assert_eq!(symplectic, Some(Integrator::CentralDifferences));
}

#[test]
fn the_spectral_radius_of_a_damped_wave_exceeds_one_beyond_its_limit() {
    let k = SVector::from_element(PI);
    for ratio in [0.05, 0.3, 0.45, 0.5, 0.6, 0.9, 2.0] {
        let system = chain(ratio, 0.0);
        let wave = Amplification::new(&system, &k);
        for integrator in Integrator::ALL {
            let step = critical_time_step_at(&system, integrator, &k);
            let below = [0.2, 0.7, 0.999].map(|part| wave.spectral_radius(integrator, part * step));
            assert!(
                below.iter().all(|radius| *radius < 1.0 + 1e-9),
                "{integrator:?} {ratio} {step}: {below:?}"
            );
            let above = wave.spectral_radius(integrator, 1.001 * step);
            assert!(above > 1.0 + 1e-6, "{integrator:?} {ratio} {step}: {above}");
        }
    }
}

#[test]
fn large_damping_increases_the_stable_step_of_kick_drift_kick() {
    // From the trace and the determinant of a step, y = omega dt is at most 2/xi beyond xi = 0.5263; here omega = 2.
    let k = SVector::from_element(PI);
    for ratio in [0.53, 0.6, 0.8] {
        let step = critical_time_step_at(&chain(ratio, 0.0), Integrator::KickDriftKick, &k);
        assert!((step - 1.0 / ratio).abs() < 1e-4, "{step} for {ratio}");
    }
    // Here waves inside the zone are decisive: the damping of longer waves is below this limit.
    for ratio in [0.53, 0.6, 0.8] {
        let system = chain(ratio, 0.0);
        let search = ZoneSearch::of_lattice(*system.crystal().lattice(), 1.0);
        for integrator in Integrator::ALL {
            let step = critical_time_step(&system, integrator, &search);
            let at = |n: u32| SVector::from_element(PI * f64::from(n) / 4000.0);
            let each = (40..=4000).map(|n| critical_time_step_at(&system, integrator, &at(n)));
            let dense = each.fold(f64::INFINITY, f64::min);
            assert!(
                (step / dense - 1.0).abs() < 1e-5,
                "{integrator:?} {ratio}: {step} {dense}"
            );
        }
    }
}

#[test]
fn lagged_damping_reduces_the_step_of_central_differences_as_published_by_belytschko() {
    // Published limit: dt = 2/omega (sqrt(1 + xi^2) - xi) for the damping ratio xi, omega = 2 (Belytschko, Liu, Moran 2000, Nonlinear Finite
    // Elements for Continua and Structures).
    for ratio in [0.05, 0.3, 0.9] {
        let system = chain(ratio, 0.0);
        let k = SVector::from_element(PI);
        let step = critical_time_step_at(&system, Integrator::CentralDifferences, &k);
        let expected = (1.0 + ratio * ratio).sqrt() - ratio;
        assert!((step - expected).abs() < 1e-4, "{step} for {expected}");
    }
}

#[test]
fn damping_reduces_the_step_of_the_other_integrators() {
    // From the trace and the determinant of a step, with y = omega dt, omega = 2. Predictor-corrector: y^2/4 + xi y (1 - xi y) = 1.
    // Kick-drift-kick: y^2/4 (2 - xi y) = 1 + (1 - xi y)^2.
    let k = SVector::from_element(PI);
    for ratio in [0.01, 0.1, 0.3, 0.45] {
        let system = chain(ratio, 0.0);
        let of = |integrator| 2.0 * critical_time_step_at(&system, integrator, &k);
        let expected =
            2.0 * ((1.0 - 3.0 * ratio * ratio).sqrt() - ratio) / (1.0 - 4.0 * ratio * ratio);
        let found = of(Integrator::PredictorCorrector);
        assert!((found - expected).abs() < 1e-4, "{found} for {expected}");
        let y = of(Integrator::KickDriftKick);
        let damped = 1.0 - ratio * y;
        let residual = 0.25 * y * y * (1.0 + damped) - 1.0 - damped * damped;
        assert!(residual.abs() < 3e-4, "{residual} at {y}");
    }
}

/// Two oscillators without neighbors on a square lattice, with stiffness and damping along the axes.
fn held(stiffness: [f64; 2], damping: [f64; 2]) -> WaveSystem<2> {
    let lattice = LatticeKind::Square.lattice::<2>(1.0).expect("a lattice");
    let crystal = Crystal::of_lattice(lattice);
    let home = Particle::home(0);
    let sum = |along: [f64; 2]| {
        let mut blocks = BlochBlocks::new();
        blocks.add(&home, &home, &SMatrix::from_diagonal(&along.into()));
        blocks.sum(&crystal)
    };
    let (stiffness, damping) = (sum(stiffness), sum(damping));
    WaveSystem::new(crystal, stiffness, Mass::Lumped(vec![1.0])).with_damping(damping)
}

#[test]
fn only_stable_waves_bound_the_step() {
    let k = SVector::from([1.0, 2.0]);
    // An oscillation with omega = 2 and a wave that grows at any rate: the limit is the closed form of lagged damping for the oscillation.
    for ratio in [0.02, 0.3] {
        for negative in [-1e-3, -0.5, -400.0] {
            let system = held([negative, 4.0], [0.2, 4.0 * ratio]);
            let expected = (1.0 + ratio * ratio).sqrt() - ratio;
            let step = critical_time_step_at(&system, Integrator::CentralDifferences, &k);
            assert!((step - expected).abs() < 1e-4, "{step} for {expected}");
        }
    }
    // If all waves grow, only the decaying solutions limit the step.
    let system = held([-1.0, -2.0], [0.3, 0.3]);
    for integrator in Integrator::ALL {
        assert!(critical_time_step_at(&system, integrator, &k) > 1.0);
    }
}

/// Waves whose stiffness and damping do not commute, from weak to overcritical damping.
#[test]
fn a_factor_leaves_the_unit_circle_at_the_largest_stable_step_of_damped_waves() {
    let material = ModifiedMooneyRivlin::default();
    let rest = DeformationGradient::identity();
    let mut random = Random::new(5);
    for alpha in [0.0, 0.3, 3.0, 30.0] {
        let viscosity = ArtificialViscosity {
            alpha,
            ..ArtificialViscosity::default()
        };
        let choices = TotalLagrangianChoices {
            viscosity: Some(viscosity),
            upwinding: Upwinding::Constant,
            ..TotalLagrangianChoices::default()
        };
        let irregular =
            Crystal::of_lattice(LatticeKind::Square.lattice::<2>(1.0).expect("a lattice"))
                .supercell([2, 1])
                .and_then(|large| large.perturbed(0.1, 3));
        let scheme = TotalLagrangianSph::new(irregular.expect("a crystal"), choices);
        let system = scheme.expect("a scheme").waves(&material, &rest);
        let system = system.expect("a state");
        for integrator in [Integrator::CentralDifferences, Integrator::KickDriftKick] {
            for _ in 0..4 {
                let k = SVector::from([2.0, 3.0]).map(|most: f64| most * random.number());
                let step = critical_time_step_at(&system, integrator, &k);
                let wave = Amplification::new(&system, &k);
                let radius = |share: f64| wave.spectral_radius(integrator, share * step);
                for share in [0.1, 0.5, 0.9, 0.9999] {
                    assert!(
                        radius(share) < 1.0 + 1e-7,
                        "{integrator:?}, {alpha}, {share}"
                    );
                }
                assert!(radius(1.0001) > 1.0 + 1e-6, "{integrator:?}, {alpha}");
            }
        }
    }
}

#[test]
fn zero_energy_and_strongly_damped_waves_do_not_change_the_step_of_other_waves() {
    let k = SVector::from([1.0, 2.0]);
    // One squared frequency is rounding; the other wave is an oscillation whose limit in forward Euler is c / omega^2.
    let system = held([1e-17, 20.0], [1e-10, 1e-3]);
    let step = critical_time_step_at(&system, Integrator::ForwardEuler, &k);
    assert!((step - 5e-5).abs() < 1e-10, "{step}");
    // Without stiffness a step of kick-drift-kick multiplies the velocity by (1 - c dt/2)^2, up to c dt = 4.
    let system = held([1e-12; 2], [1e4; 2]);
    let step = critical_time_step_at(&system, Integrator::KickDriftKick, &k);
    assert!((step - 4e-4).abs() < 1e-8, "{step}");
}

#[test]
fn the_shortest_wave_determines_the_step_of_a_damped_chain() {
    let system = chain(0.3, 0.0);
    let search = ZoneSearch::of_lattice(*system.crystal().lattice(), 1.0);
    for integrator in Integrator::ALL {
        let at_end = critical_time_step_at(&system, integrator, &SVector::from_element(PI));
        let step = critical_time_step(&system, integrator, &search);
        assert!((step - at_end).abs() < 1e-9);
    }
}

#[test]
fn a_step_of_kick_drift_kick_agrees_with_the_damped_oscillator() {
    // Trace and determinant of one step of u'' = -omega^2 u - c u', computed by hand.
    let (omega_squared, c, dt) = (4.0, 0.7, 0.3);
    let system = chain(0.0, c);
    let wave = Amplification::new(&system, &SVector::from_element(PI));
    let g = wave.matrix(Integrator::KickDriftKick, dt);
    let h = 0.5 * dt;
    let damped = 1.0 - h * c;
    let half = [-h * omega_squared, damped];
    let u = [1.0 + dt * half[0], dt * half[1]];
    let v = [0, 1].map(|i| damped * half[i] - h * omega_squared * u[i]);
    for (row, expected) in [u, v].iter().enumerate() {
        for column in 0..2 {
            assert!((g[(row, column)].re - expected[column]).abs() < 1e-14);
        }
    }
}

/// Amplification factors of the generalized-alpha method, or of backward Euler without parameters, for `a + w u = 0` and `dt = 1`.
fn implicit_factors(parameters: Option<[f64; 2]>, w: f64) -> Vec<Complex<f64>> {
    // All equations of a step, A y' = B y with y = (u, v, a), solved directly.
    let (left, right) = match parameters {
        Some([alpha_m, alpha_f]) => {
            let gamma = 0.5 - alpha_m + alpha_f;
            let beta = 0.25 * (0.5 + gamma).powi(2);
            (
                Matrix3::new(
                    1.0,
                    0.0,
                    -beta,
                    0.0,
                    1.0,
                    -gamma,
                    w * (1.0 - alpha_f),
                    0.0,
                    1.0 - alpha_m,
                ),
                Matrix3::new(
                    1.0,
                    1.0,
                    0.5 - beta,
                    0.0,
                    1.0,
                    1.0 - gamma,
                    -w * alpha_f,
                    0.0,
                    -alpha_m,
                ),
            )
        }
        None => (
            Matrix3::new(1.0, -1.0, 0.0, w, 1.0, 0.0, 0.0, 0.0, 1.0),
            Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0),
        ),
    };
    let step = left.try_inverse().expect("a step") * right;
    step.complex_eigenvalues().iter().copied().collect()
}

#[test]
fn implicit_steps_reach_a_singular_matrix_and_mask_growth_where_stated() {
    for (integrator, parameters, at_infinity) in [
        (ImplicitIntegrator::Newmark, Some([0.0, 0.0]), 1.0),
        (ImplicitIntegrator::HhtAlpha, Some([0.0, 0.05]), 0.95 / 1.05),
        (
            ImplicitIntegrator::GeneralizedAlpha,
            Some([0.0, 1.0 / 3.0]),
            0.5,
        ),
        (ImplicitIntegrator::BackwardEuler, None, 0.0),
    ] {
        let radius = |w: f64| {
            let factors = implicit_factors(parameters, w).into_iter();
            factors.map(|z| z.norm()).fold(0.0, f64::max)
        };
        // The factors of the library, which has eliminated the acceleration.
        for phase in [0.1_f64, 0.7, 3.0, 40.0] {
            let sizes = |mut factors: Vec<Complex<f64>>| {
                factors.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
                factors
                    .into_iter()
                    .map(|z| z.norm())
                    .filter(|size| *size > 1e-9)
                    .collect::<Vec<_>>()
            };
            let own = sizes(integrator.factors(phase));
            let expected = sizes(implicit_factors(parameters, phase * phase));
            assert_eq!(
                own.len(),
                expected.len(),
                "{integrator:?} {own:?} {expected:?}"
            );
            for (a, b) in own.iter().zip(&expected) {
                assert!((a - b).abs() < 1e-9, "{integrator:?} {own:?} {expected:?}");
            }
        }
        // Unconditionally stable for oscillations, with the spectral radius of the literature for fast ones.
        for power in -20..=40 {
            assert!(radius(2.0_f64.powi(power)) < 1.0 + 1e-7, "{integrator:?}");
        }
        assert!((radius(1e12) - at_infinity).abs() < 1e-4, "{integrator:?}");
        assert!((integrator.spectral_radius_at_infinity() - at_infinity).abs() < 1e-12);
        // The period from the angle of the factor in the upper half plane; the third factor is real.
        for phase in [0.1_f64, std::f64::consts::TAU / 20.0, 0.75, 2.0] {
            let factors = implicit_factors(parameters, phase * phase).into_iter();
            let upper = factors.max_by(|a, b| a.im.total_cmp(&b.im));
            let expected = phase / upper.expect("factors").arg() - 1.0;
            let found = integrator.period_error(phase);
            assert!(
                found > 0.0 && (found - expected).abs() < 1e-9,
                "{integrator:?} {found}"
            );
        }
        // Beyond the largest definite step a growing wave alternates, because its matrix is negative.
        let (omega_squared, rate) = (-0.49, 0.7);
        let definite = integrator.largest_definite_step(omega_squared);
        let fastest = |step: f64| {
            let factors = implicit_factors(parameters, omega_squared * step * step);
            let largest = factors
                .into_iter()
                .max_by(|a, b| a.norm().total_cmp(&b.norm()));
            largest.expect("factors").re
        };
        assert!(fastest(0.999 * definite) > 100.0, "{integrator:?}");
        assert!(fastest(1.001 * definite) < -100.0, "{integrator:?}");
        let hiding = integrator.largest_growing_step(rate);
        match hiding.is_finite() {
            true => {
                assert!(fastest(0.999 * hiding) < -1.0, "{integrator:?}");
                assert!(radius(omega_squared * (1.001 * hiding).powi(2)) < 1.0);
            }
            false => assert!(radius(omega_squared * 1e8) > 1.0),
        }
        assert_eq!(integrator.largest_definite_step(0.49), f64::INFINITY);
        assert_eq!(integrator.largest_growing_step(0.0), f64::INFINITY);
    }
}
