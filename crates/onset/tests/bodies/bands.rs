//! Shear bands that grow from noise have the direction of lost ellipticity, in methods of different kinds.

use super::choices;
use onset::analysis::{Analysis, analysis};
use onset::kinematics::DeformationGradient;
use onset::lattice::LatticeKind;
use onset::material::{Hyperelastic, Law};
use onset::method::KernelMethodChoices;
use onset::motion::{PatchMotion, PatchState, Stepper};
use onset::scheme::MethodChoices;
use onset::scheme::conforming::ConformingChoices;
use onset::scheme::stabilization::PenaltyForm;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Number of cells of the patch, which is compressed along the first axis.
const CELLS: [usize; 2] = [100, 36];
const STRETCH: f64 = 0.25;

fn methods() -> Vec<(&'static str, MethodChoices)> {
    let particles = || {
        Box::new(KernelMethodChoices {
            lattice: LatticeKind::Square,
            support: 2.4,
            ..KernelMethodChoices::default()
        })
    };
    let total = choices(2.4, 0.5, PenaltyForm::Published);
    vec![
        ("kernel", MethodChoices::Kernel(particles())),
        (
            "total-lagrangian-sph",
            MethodChoices::TotalLagrangianSph(particles(), total),
        ),
        (
            "conforming",
            MethodChoices::Conforming(particles(), ConformingChoices::default()),
        ),
    ]
}

/// Angle between the first axis and the current wave vectors, averaged over all waves of the displacements with their energies as weights; degrees.
fn angle(places: &[[f64; 3]], state: &PatchState) -> f64 {
    let mut sum = [0.0; 2];
    // `k` and `-k` have equal waves, so that one of them is sufficient.
    for n in 0..=CELLS[0] / 2 {
        for m in 0..CELLS[1] {
            let m = m as f64
                - if 2 * m > CELLS[1] {
                    CELLS[1] as f64
                } else {
                    0.0
                };
            let k = [n as f64 * TAU / CELLS[0] as f64, m * TAU / CELLS[1] as f64];
            let mut amplitude = [0.0; 4];
            for (x, u) in places.iter().zip(state.displacements.chunks_exact(2)) {
                let (sin, cos) = (k[0] * x[0] + k[1] * x[1]).sin_cos();
                for i in 0..2 {
                    amplitude[2 * i] += u[i] * cos;
                    amplitude[2 * i + 1] += u[i] * sin;
                }
            }
            let energy: f64 = amplitude.iter().map(|own| own * own).sum();
            sum[0] += energy * (k[0] / STRETCH).powi(2);
            sum[1] += energy * k[1].powi(2);
        }
    }
    sum[1].sqrt().atan2(sum[0].sqrt()).to_degrees()
}

#[test]
fn waves_grow_from_noise_in_the_direction_of_lost_ellipticity_in_three_methods() {
    let law = Law::named("blatz-ko").expect("a law");
    let material: Arc<dyn Hyperelastic> = Arc::from(law.build(&[]).expect("a material"));
    let f = DeformationGradient::from_stretches([STRETCH, 1.0, 1.0]).expect("stretches");
    for (name, method) in methods() {
        let method: Box<dyn Analysis> = analysis(&method, Arc::clone(&material)).expect("a method");
        let predicted = method.acoustic_minimum(&f).expect("a minimum");
        assert!(predicted.eigenvalue.re < 0.0);
        let direction = predicted.direction;
        let told = direction[1]
            .abs()
            .atan2(direction[0].abs() / STRETCH)
            .to_degrees();
        let mut seen = 0.0;
        method
            .with_motion(&f, &CELLS, &mut |patch: &mut dyn PatchMotion| {
                let stepper = Stepper::KICK_DRIFT_KICK;
                let places = patch.positions();
                let mut random = super::Random::new(7);
                let displacements = (0..2 * places.len())
                    .map(|_| 1e-9 * random.number())
                    .collect::<Vec<_>>();
                let fastest = patch.waves().iter().map(|wave| wave.omega_squared.re);
                let rate = (-fastest.fold(0.0, f64::min)).sqrt();
                let step = 0.5 * patch.critical_time_step(stepper);
                patch.put(&PatchState {
                    velocities: vec![0.0; displacements.len()],
                    displacements,
                    ..PatchState::default()
                });
                for _ in 0..(16.0 / (rate * step)) as usize {
                    patch.advance(stepper, step).expect("a step");
                }
                seen = angle(&places, &patch.state());
            })
            .expect("a patch");
        eprintln!("{name}: {seen:.2} degrees, predicted {told:.2}");
        assert!(
            (seen - told).abs() < 2.0,
            "{name}: {seen} degrees, predicted {told}"
        );
    }
}
