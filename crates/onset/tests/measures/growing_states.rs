//! Time steps of states that are themselves unstable.

use nalgebra::{DMatrix, SVector};
use onset::algebra::Complex;
use onset::bloch::WaveSystem;
use onset::kinematics::DeformationGradient;
use onset::lattice::{BravaisLattice, Crystal, LatticeKind};
use onset::material::ModifiedMooneyRivlin;
use onset::scheme::Discretization;
use onset::scheme::sph::{UpdatedSph, UpdatedSphChoices};
use onset::scheme::stabilization::ArtificialViscosity;
use onset::time_step::{Amplification, Integrator};
use onset::verdict::Survey;

fn moduli(matrix: DMatrix<Complex>) -> Vec<f64> {
    let values = matrix.schur().eigenvalues().expect("eigenvalues");
    values.iter().map(|z| z.norm()).collect()
}

/// Number of growing solutions of the equations of a wave, and of an integrator, which may add a small part of the growth of the state.
fn growing(
    waves: &WaveSystem<2>,
    integrator: Integrator,
    (step, growth): (f64, f64),
    k: &SVector<f64, 2>,
) -> (usize, usize) {
    let exact = waves.frequencies(k).into_iter();
    let exact = exact.filter(|omega| omega.im > 1e-7).count();
    let matrix = Amplification::new(waves, k).matrix(integrator, step);
    let discrete = moduli(matrix).into_iter();
    let most = 1.0 + 1e-6 + 0.01 * growth * step;
    (exact, discrete.filter(|z| *z > most).count())
}

fn viscous() -> (BravaisLattice<2>, UpdatedSph<2>) {
    let lattice = LatticeKind::Hexagonal.lattice::<2>(1.0).expect("a lattice");
    let choices = UpdatedSphChoices {
        viscosity: Some(ArtificialViscosity {
            alpha: 0.5,
            ..ArtificialViscosity::default()
        }),
        ..UpdatedSphChoices::default()
    };
    let crystal = Crystal::of_lattice(lattice);
    (
        lattice,
        UpdatedSph::new(crystal, choices).expect("a method"),
    )
}

/// Between growing and decaying waves an integrator makes some waves grow very slowly at any step.
#[test]
fn slowly_decaying_waves_near_growing_waves_do_not_limit_the_step() {
    let (_, sph) = viscous();
    let law = ModifiedMooneyRivlin::default();
    let survey = Survey::new(&sph, &law).expect("a survey");
    for n in 0..12 {
        let stretch = 1.1 + 0.02 * f64::from(n);
        let state = DeformationGradient::from_stretches([stretch, 1.0, 1.0]).expect("a state");
        let undamped = 2.0 / survey.spectrum(&state).expect("a spectrum").maximum_omega;
        for integrator in [Integrator::CentralDifferences, Integrator::KickDriftKick] {
            let step = survey.critical_time_step(&state, integrator);
            let share = step.expect("a step") / undamped;
            assert!(share > 0.8, "{integrator:?} at {stretch}: {share}");
        }
    }
}

#[test]
fn the_damped_step_of_a_growing_state_is_the_step_of_its_waves_that_do_not_grow() {
    let (lattice, sph) = viscous();
    let law = ModifiedMooneyRivlin::default();
    let survey = Survey::new(&sph, &law).expect("a survey");
    let state = DeformationGradient::from_stretches([1.1, 0.95, 1.0]).expect("a state");
    let growth = survey.spectrum(&state).expect("a spectrum").growth_rate();
    assert!(growth > 0.0);
    let waves = sph.waves(&law, &state).expect("waves");
    let grid: Vec<SVector<f64, 2>> = (0..41 * 41)
        .map(|n| {
            let place = [f64::from(n / 41) / 41.0, f64::from(n % 41) / 41.0 + 0.003];
            lattice.reciprocal() * SVector::from(place)
        })
        .collect();
    for integrator in Integrator::ALL {
        let step = survey
            .critical_time_step(&state, integrator)
            .expect("a step");
        let least = match integrator {
            Integrator::CentralDifferences
            | Integrator::KickDriftKick
            | Integrator::PredictorCorrector => 0.1,
            _ => 0.01,
        };
        assert!(step > least, "{integrator:?}: {step}");
        // Slightly below the step no wave has a growing solution; clearly above it some waves do.
        let gained = |step: f64| {
            let counts = grid
                .iter()
                .map(|k| growing(&waves, integrator, (step, growth), k));
            counts.filter(|(exact, discrete)| discrete > exact).count()
        };
        assert_eq!(gained(0.99 * step), 0, "{integrator:?} at {step}");
        assert!(gained(1.05 * step) > 0, "{integrator:?} at {step}");
    }
}
