//! Bodies: the engine is compared with the forces of the method, the continuum, and the conservation laws of mechanics.

mod bands;
mod contact;
mod modes;
mod oscillations;
#[path = "../shared/random.rs"]
#[allow(dead_code, reason = "shared with tests that turn things")]
mod random;
mod steps;
mod updated;

use nalgebra::{DVector, SMatrix, SVector};
use onset::analysis::{Analysis, analysis};
use onset::kinematics::DeformationGradient;
use onset::lattice::{BravaisLattice, Crystal, LatticeKind};
use onset::material::{Hyperelastic, Law};
use onset::method::KernelMethodChoices;
use onset::motion::{
    BodyError, BodyMotion, BodyParticles, BodyQuantities, Grip, Ground, Notch, PatchState,
    PlacedParticle, Shape, Start,
};
use onset::scheme::sph::{TotalLagrangianChoices, TotalLagrangianSph};
use onset::scheme::stabilization::PenaltyForm;
use onset::scheme::{Discretization, MethodChoices, PeriodicPatch};
use onset::time_step::Integrator;
use random::Random;
use std::f64::consts::PI;
use std::sync::Arc;

fn law() -> Arc<dyn Hyperelastic> {
    Arc::from(
        Law::named("neo-hooke")
            .expect("a law")
            .build(&[])
            .expect("a material"),
    )
}

fn choices(radius: f64, penalty: f64, penalty_form: PenaltyForm) -> TotalLagrangianChoices {
    TotalLagrangianChoices {
        density: 1.3,
        radius,
        penalty,
        penalty_form,
        ..TotalLagrangianChoices::default()
    }
}

fn method(lattice: LatticeKind, choices: &TotalLagrangianChoices) -> Box<dyn Analysis> {
    let particles = KernelMethodChoices {
        lattice,
        ..KernelMethodChoices::default()
    };
    let method = MethodChoices::TotalLagrangianSph(Box::new(particles), choices.clone());
    analysis(&method, law()).expect("a method")
}

fn with<T>(
    method: &dyn Analysis,
    particles: &BodyParticles,
    grips: &[Grip],
    work: impl Fn(&mut dyn BodyMotion) -> T,
) -> Result<T, BodyError> {
    let mut answer = None;
    method.with_body(particles, grips, None, &mut |body| {
        answer = Some(work(body))
    })?;
    Ok(answer.expect("a body"))
}

fn block(size: &[f64]) -> BodyParticles {
    BodyParticles::Cut(Shape::Block {
        size: size.to_vec(),
        hole: None,
        notch: None,
    })
}

/// Two copies of a block with an offset along the first axis.
fn twice(size: &[f64], offset: f64) -> BodyParticles {
    let BodyParticles::Cut(shape) = block(size) else {
        unreachable!("blocks are cut")
    };
    let mut moved = vec![0.0; size.len()];
    moved[0] = offset;
    BodyParticles::Cut(Shape::Twice {
        shape: Box::new(shape),
        offset: moved,
    })
}

fn at_rest(displacements: Vec<f64>) -> PatchState {
    PatchState {
        velocities: vec![0.0; displacements.len()],
        displacements,
        ..PatchState::default()
    }
}

/// Forces of a body by the general method: a crystal whose cell contains only the body, surrounded by empty space.
fn general<const D: usize>(
    positions: &[[f64; 3]],
    volumes: Vec<f64>,
    choices: &TotalLagrangianChoices,
    displacements: &[f64],
) -> Vec<f64> {
    let room = 1000.0;
    let lattice = BravaisLattice::new(SMatrix::<f64, D, D>::identity() * room).expect("a lattice");
    let sites = positions
        .iter()
        .map(|x| SVector::from_fn(|i, _| x[i] / room));
    let crystal = Crystal::with_volumes(lattice, sites.collect(), volumes).expect("a crystal");
    let scheme = TotalLagrangianSph::new(crystal, choices.clone()).expect("a scheme");
    let patch = PeriodicPatch::new(scheme.crystal(), [1; D]);
    let u: Vec<_> = displacements
        .chunks_exact(D)
        .map(SVector::<f64, D>::from_column_slice)
        .collect();
    let forces = scheme
        .forces(&*law(), &DeformationGradient::identity(), &patch, &u)
        .expect("forces");
    forces.iter().flat_map(|f| f.iter().copied()).collect()
}

fn assert_forces_are_general<const D: usize>(
    lattice: LatticeKind,
    particles: &BodyParticles,
    choices: &TotalLagrangianChoices,
) {
    let method = method(lattice, choices);
    let crystal: Crystal<D> = Crystal::of(lattice, 1.0).expect("a crystal");
    let volume = |n: usize| match particles {
        BodyParticles::Given(given) => given[n].volume,
        // All lattices of these tests have particles of equal volume.
        BodyParticles::Cut(_) => crystal.volumes()[0],
    };
    with(&*method, particles, &[], |body| {
        let positions = body.positions();
        let mut random = Random::new(7);
        let displacements: Vec<f64> = (0..D * positions.len())
            .map(|_| 0.05 * random.number())
            .collect();
        body.put(
            &at_rest(displacements.clone()),
            &DeformationGradient::identity(),
        );
        let volumes: Vec<f64> = (0..positions.len()).map(volume).collect();
        let accelerations = body.accelerations().expect("forces");
        let own: Vec<f64> = accelerations
            .iter()
            .enumerate()
            .map(|(n, a)| a * choices.density * volumes[n / D])
            .collect();
        let general = general::<D>(&positions, volumes, choices, &displacements);
        let own = DVector::from_vec(own);
        let general = DVector::from_vec(general);
        let apart = (&own - &general).amax() / general.amax();
        assert!(general.amax() > 1e-3);
        assert!(
            apart < 1e-12,
            "{lattice:?}, {} particles: forces differ by {apart:e}",
            positions.len()
        );
    })
    .expect("a body");
}

fn notched() -> BodyParticles {
    BodyParticles::Cut(Shape::Block {
        size: vec![12.0, 7.0],
        hole: Some(1.2),
        notch: Some(Notch {
            depth: 2.0,
            width: 1.5,
        }),
    })
}

#[test]
fn forces_of_bodies_with_free_surfaces_equal_the_forces_of_the_method() {
    let ring = BodyParticles::Cut(Shape::Ring {
        radius: 6.0,
        inner: 2.5,
        height: None,
    });
    for form in [PenaltyForm::Published, PenaltyForm::Smd] {
        for penalty in [0.0, 0.7] {
            let plane = choices(2.4, penalty, form);
            assert_forces_are_general::<2>(LatticeKind::Square, &notched(), &plane);
            assert_forces_are_general::<2>(LatticeKind::Hexagonal, &notched(), &plane);
            assert_forces_are_general::<2>(LatticeKind::Honeycomb, &ring, &plane);
            let space = choices(2.01, penalty, form);
            assert_forces_are_general::<3>(
                LatticeKind::SimpleCubic,
                &block(&[11.0, 4.0, 3.0]),
                &space,
            );
            let line = choices(2.2, penalty, form);
            assert_forces_are_general::<1>(LatticeKind::Chain, &block(&[30.0]), &line);
        }
    }
    let uncorrected = TotalLagrangianChoices {
        corrected: false,
        ..choices(2.4, 0.3, PenaltyForm::Published)
    };
    assert_forces_are_general::<2>(LatticeKind::Square, &notched(), &uncorrected);
}

/// Particles off a lattice, with different volumes.
fn scattered() -> BodyParticles {
    let mut random = Random::new(3);
    let mut given = Vec::new();
    for i in 0..9 {
        for j in 0..6 {
            let near = |n: i32, random: &mut Random| f64::from(n) + 0.15 * random.number();
            given.push(PlacedParticle {
                position: [near(i, &mut random), near(j, &mut random), 0.0],
                volume: 1.0 + 0.2 * random.number(),
            });
        }
    }
    BodyParticles::Given(given)
}

#[test]
fn forces_of_given_particles_equal_the_forces_of_the_method() {
    for penalty in [0.0, 0.7] {
        let choices = choices(2.4, penalty, PenaltyForm::Smd);
        assert_forces_are_general::<2>(LatticeKind::Square, &scattered(), &choices);
    }
}

#[test]
fn a_uniform_deformation_causes_no_force_inside() {
    let method = method(
        LatticeKind::SimpleCubic,
        &choices(2.01, 0.5, PenaltyForm::Published),
    );
    let f = DeformationGradient::new([[1.2, 0.1, 0.0], [-0.05, 0.9, 0.2], [0.0, 0.1, 1.1]])
        .expect("a deformation");
    with(&*method, &block(&[12.0, 11.0, 10.0]), &[], |body| {
        let start = Start {
            f,
            noise: 0.0,
            seed: 1,
        };
        body.start(&start, 1e-3).expect("forces");
        let accelerations = body.accelerations().expect("forces");
        // The gradients are exact up to the surface.
        for own in body.deformations() {
            for i in 0..3 {
                for j in 0..3 {
                    assert!((own[i][j] - f.components()[i][j]).abs() < 1e-13);
                }
            }
        }
        let mut inside = 0;
        let mut surface = 0.0_f64;
        for (x, a) in body.positions().iter().zip(accelerations.chunks_exact(3)) {
            let largest = a.iter().fold(0.0_f64, |most, a| most.max(a.abs()));
            let sides = [12.0, 11.0, 10.0];
            // The correction differs for particles within one support of the surface, and these act on particles within another support.
            match (0..3).all(|i| (4.1..sides[i] - 4.1).contains(&x[i])) {
                true => {
                    inside += 1;
                    assert!(largest < 1e-13, "{x:?}: {a:?}");
                }
                false => surface = surface.max(largest),
            }
        }
        assert!(inside > 10);
        assert!(surface > 0.01);
    })
    .expect("a body");
}

fn moving(body: &mut dyn BodyMotion, step: f64, steps: usize) -> Vec<BodyQuantities> {
    (0..steps)
        .map(|_| {
            let own = body.quantities(step).expect("energies");
            body.advance(step).expect("a step");
            own
        })
        .collect()
}

#[test]
fn without_grips_momentum_and_angular_momentum_are_conserved() {
    let method = method(
        LatticeKind::Square,
        &choices(2.4, 0.5, PenaltyForm::Published),
    );
    with(&*method, &notched(), &[], |body| {
        let mut random = Random::new(5);
        let count = 2 * body.positions().len();
        let mut state = at_rest((0..count).map(|_| 0.02 * random.number()).collect());
        state.velocities = (0..count).map(|_| 0.2 + 0.3 * random.number()).collect();
        body.put(&state, &DeformationGradient::identity());
        let step = 0.3 * body.critical_time_step().expect("a step");
        let history = moving(body, step, 400);
        let first = history[0];
        let last = history[399];
        assert!(first.momentum[0].abs() > 1.0 && first.angular_momentum[2].abs() > 1.0);
        for i in 0..3 {
            assert!((last.momentum[i] - first.momentum[i]).abs() < 1e-11 * first.momentum[0].abs());
            let turned = last.angular_momentum[i] - first.angular_momentum[i];
            assert!(turned.abs() < 1e-11 * first.angular_momentum[2].abs());
        }
    })
    .expect("a body");
}

/// Largest change of the energy in a run, relative to its initial value.
fn energy_error(history: &[BodyQuantities]) -> f64 {
    let energy = |own: &BodyQuantities| own.kinetic + own.strain;
    let first = energy(&history[0]);
    let errors = history
        .iter()
        .map(|own| (energy(own) - first).abs() / first);
    errors.fold(0.0, f64::max)
}

/// Checks that halving the step reduces the error to a quarter.
fn assert_second_order(coarse: f64, fine: f64) {
    let order = (coarse / fine).log2();
    assert!(coarse < 0.02, "{coarse}");
    assert!(
        (1.7..2.3).contains(&order),
        "order {order}: {coarse} {fine}"
    );
}

#[test]
fn the_energy_error_of_the_leapfrog_scales_with_the_square_of_the_step() {
    let method = method(
        LatticeKind::Square,
        &choices(2.4, 0.0, PenaltyForm::Published),
    );
    let swing = |share: f64| {
        with(&*method, &block(&[10.0, 6.0]), &[], |body| {
            let critical = body.critical_time_step().expect("a step");
            let start = Start {
                f: DeformationGradient::from_stretches([1.15, 0.95, 1.0]).expect("stretches"),
                noise: 0.0,
                seed: 1,
            };
            let step = share * critical;
            body.start(&start, step).expect("forces");
            let history = moving(body, step, (40.0 / share) as usize);
            energy_error(&history)
        })
        .expect("a body")
    };
    assert_second_order(swing(0.2), swing(0.1));
}

#[test]
fn the_work_of_grips_equals_the_energy_gain_of_the_body() {
    let method = method(
        LatticeKind::Square,
        &choices(2.4, 0.0, PenaltyForm::Published),
    );
    let grip = |low: [f64; 2], high: [f64; 2], speed: f64| Grip {
        low: low.to_vec(),
        high: high.to_vec(),
        velocity: vec![speed, 0.0],
        ramp: 3.0,
        ..Grip::default()
    };
    let grips = [
        grip([0.0, 0.0], [1.0, 6.0], 0.0),
        grip([9.0, 0.0], [10.0, 6.0], 0.2),
    ];
    let missed = |share: f64| {
        with(&*method, &block(&[10.0, 6.0]), &grips, |body| {
            let step = share * body.critical_time_step().expect("a step");
            let start = Start {
                f: DeformationGradient::identity(),
                noise: 0.0,
                seed: 1,
            };
            body.start(&start, step).expect("forces");
            let last = moving(body, step, (6.0 / step) as usize)
                .pop()
                .expect("a step");
            assert!(last.work > 0.01 && last.strain > 0.01, "{last:?}");
            (last.kinetic + last.strain - last.work).abs() / last.work
        })
        .expect("a body")
    };
    let (coarse, fine) = (missed(0.4), missed(0.2));
    assert!(coarse < 0.02 && fine < 0.4 * coarse, "{coarse} {fine}");
}

/// Frequency of the first longitudinal vibration of a free bar in one dimension, from a quarter of its period.
fn measured_frequency(particles: usize) -> (f64, f64) {
    let method = method(
        LatticeKind::Chain,
        &choices(2.2, 0.2, PenaltyForm::Published),
    );
    let length = particles as f64;
    with(&*method, &block(&[length]), &[], |body| {
        let shape: Vec<f64> = body
            .positions()
            .iter()
            .map(|x| (PI * x[0] / length).cos())
            .collect();
        let displaced = shape.iter().map(|own| 1e-6 * own).collect();
        let identity = DeformationGradient::identity();
        body.put(&at_rest(displaced), &identity);
        let step = 0.1 * body.critical_time_step().expect("a step");
        let amplitude = |body: &dyn BodyMotion| {
            let u = body.state().displacements;
            u.iter().zip(&shape).map(|(u, own)| u * own).sum::<f64>()
        };
        // Runs until the amplitude passes zero, for a quarter of a period.
        let (mut before, mut time) = (amplitude(body), 0.0);
        loop {
            body.advance(step).expect("a step");
            time += step;
            let now = amplitude(body);
            if now <= 0.0 {
                // The initial velocities belong to the time half a step before.
                let quarter = time - step * now / (now - before) + 0.5 * step;
                let stiffness =
                    law().response(&identity).expect("a response").tangent[(0, 0, 0, 0)];
                let exact = PI / length * (stiffness / 1.3).sqrt();
                return (0.5 * PI / quarter, exact);
            }
            before = now;
        }
    })
    .expect("a body")
}

#[test]
fn the_first_frequency_of_a_bar_converges_to_the_continuum_frequency() {
    let error = |particles| {
        let (measured, exact) = measured_frequency(particles);
        (measured / exact - 1.0).abs()
    };
    let (coarse, fine) = (error(20), error(80));
    assert!(coarse < 0.05, "{coarse}");
    assert!(fine < 0.4 * coarse, "{coarse} {fine}");
}

#[test]
fn motion_is_bounded_at_the_critical_step_and_unbounded_at_twice_the_step() {
    let method = method(
        LatticeKind::Square,
        &choices(2.4, 0.4, PenaltyForm::Published),
    );
    let largest = |share: f64| {
        with(&*method, &block(&[9.0, 8.0]), &[], |body| {
            let step = share * body.critical_time_step().expect("a step");
            let start = Start {
                f: DeformationGradient::identity(),
                noise: 1e-9,
                seed: 4,
            };
            body.start(&start, step).expect("forces");
            for _ in 0..600 {
                if body.advance(step).is_err() {
                    return f64::INFINITY;
                }
            }
            body.quantities(step)
                .map_or(f64::INFINITY, |own| own.largest)
        })
        .expect("a body")
    };
    assert!(largest(1.0) < 1e-6);
    assert!(largest(1.3) > 1e-3);
    // Free surfaces do not reduce the step far below the step of the waves.
    let waves = method
        .critical_time_step(
            &DeformationGradient::identity(),
            Integrator::CentralDifferences,
        )
        .expect("a step");
    let body = with(&*method, &block(&[9.0, 8.0]), &[], |body| {
        body.critical_time_step().expect("a step")
    })
    .expect("a body");
    assert!((0.5..1.02).contains(&(body / waves)), "{body} {waves}");
}

#[test]
fn a_resumed_run_of_a_body_is_bitwise_identical() {
    let method = method(
        LatticeKind::SimpleCubic,
        &choices(2.01, 0.5, PenaltyForm::Smd),
    );
    let start = Start {
        f: DeformationGradient::from_stretches([1.1, 1.0, 1.0]).expect("stretches"),
        noise: 1e-3,
        seed: 9,
    };
    let ends = |stop: usize| {
        with(&*method, &block(&[13.0, 5.0, 4.0]), &[], |body| {
            let step = 0.4 * body.critical_time_step().expect("a step");
            body.start(&start, step).expect("forces");
            for n in 0..30 {
                if n == stop {
                    let state = body.state();
                    body.put(&state, &start.f);
                    body.quantities(step).expect("energies");
                }
                body.advance(step).expect("a step");
            }
            body.state()
        })
        .expect("a body")
    };
    assert_eq!(ends(17), ends(30));
}

/// Checks that runs on one core and on several cores have bitwise equal results.
#[cfg(feature = "rayon")]
fn assert_same_on_any_cores(run: impl Fn() -> PatchState + Sync) {
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads").install(&run)
    };
    let one = on(1);
    for threads in [2, 3, 5] {
        assert_eq!(on(threads), one, "{threads}");
    }
}

#[cfg(feature = "rayon")]
#[test]
fn runs_on_any_number_of_cores_are_bitwise_identical() {
    assert_same_on_any_cores(|| {
        let choices = choices(2.01, 0.5, PenaltyForm::Smd);
        let method = method(LatticeKind::SimpleCubic, &choices);
        with(&*method, &block(&[30.0, 9.0, 8.0]), &[], |body| {
            let start = Start {
                f: DeformationGradient::from_stretches([1.1, 1.0, 1.0]).expect("stretches"),
                noise: 1e-3,
                seed: 9,
            };
            body.start(&start, 0.1).expect("forces");
            (0..10).for_each(|_| body.advance(0.1).expect("a step"));
            body.state()
        })
        .expect("a body")
    });
}

#[test]
fn inverted_particles_and_overflow_are_reported() {
    let method = method(
        LatticeKind::Square,
        &choices(2.4, 0.0, PenaltyForm::Published),
    );
    with(&*method, &block(&[8.0, 8.0]), &[], |body| {
        let mut state = at_rest(vec![0.0; 2 * body.positions().len()]);
        // One row of particles is moved beyond the next.
        for (n, x) in body.positions().iter().enumerate() {
            state.displacements[2 * n] = if x[0] > 4.0 { -3.0 } else { 0.0 };
        }
        body.put(&state, &DeformationGradient::identity());
        let fault = body.advance(1e-3).expect_err("inverted");
        assert_eq!(fault.ground, Ground::Inverted);
        assert!(fault.to_string().contains("inverted"), "{fault}");
        state.displacements[31] = f64::NAN;
        body.put(&state, &DeformationGradient::identity());
        let fault = body.advance(1e-3).expect_err("not finite");
        assert_eq!((fault.ground, fault.particle), (Ground::NotFinite, 15));
    })
    .expect("a body");
}

#[test]
fn invalid_bodies_are_rejected_with_the_reason() {
    let method = method(
        LatticeKind::Square,
        &choices(2.4, 0.0, PenaltyForm::Published),
    );
    let refused = |particles: &BodyParticles, grips: &[Grip]| {
        with(&*method, particles, grips, |_| ()).expect_err("refused")
    };
    let grip = Grip {
        low: vec![20.0, 0.0],
        high: vec![21.0, 5.0],
        velocity: vec![1.0, 0.0],
        ramp: 0.0,
        ..Grip::default()
    };
    assert!(matches!(
        refused(&block(&[8.0, 8.0]), &[grip]),
        BodyError::EmptyGrip { grip: 1, .. }
    ));
    let everything = Grip {
        low: vec![-1.0, -1.0],
        high: vec![9.0, 9.0],
        velocity: vec![0.0; 2],
        ramp: 0.0,
        ..Grip::default()
    };
    assert!(matches!(
        refused(&block(&[8.0, 8.0]), &[everything.clone(), everything]),
        BodyError::HeldTwice {
            first: 1,
            second: 2,
            ..
        }
    ));
    assert!(matches!(
        refused(&block(&[8.0, 1.0]), &[]),
        BodyError::Lonely { .. }
    ));
    assert!(matches!(
        refused(&block(&[0.5, 0.2]), &[]),
        BodyError::Empty
    ));
    let particle = PlacedParticle {
        position: [1.0, 2.0, 0.0],
        volume: 1.0,
    };
    assert!(matches!(
        refused(&BodyParticles::Given(vec![particle; 2]), &[]),
        BodyError::Coincident {
            first: 0,
            second: 1,
            ..
        }
    ));
    // Positions beyond the numbers of cells, and particles at such positions in a file, also lead to error messages.
    for far in [-1e10, 1e10, 1e300] {
        assert!(matches!(
            refused(&twice(&[8.0, 8.0], far), &[]),
            BodyError::Number { .. }
        ));
        let there = PlacedParticle {
            position: [far, 2.0, 0.0],
            volume: 1.0,
        };
        let given = BodyParticles::Given(vec![particle, there]);
        assert!(matches!(refused(&given, &[]), BodyError::Lonely { .. }));
    }
    assert!(matches!(
        refused(&block(&[1e6, 1e-3]), &[]),
        BodyError::Empty | BodyError::Number { .. }
    ));
    let updated = MethodChoices::Kernel(Box::default());
    let updated = analysis(&updated, law()).expect("a method");
    let none = with(&*updated, &block(&[8.0, 8.0]), &[], |_| ());
    assert_eq!(none, Err(BodyError::NoBodies));
}

#[test]
fn shear_bands_follow_the_direction_in_which_ellipticity_is_lost() {
    // Waves whose acoustic tensor has a negative eigenvalue grow: `delta F = g (x) N`, with both signs of one component of `N` by symmetry.
    let material: Arc<dyn Hyperelastic> = Arc::from(
        Law::named("blatz-ko")
            .expect("a law")
            .build(&[])
            .expect("a material"),
    );
    let particles = KernelMethodChoices {
        lattice: LatticeKind::Square,
        ..KernelMethodChoices::default()
    };
    let choices = choices(2.4, 0.5, PenaltyForm::Published);
    let method = MethodChoices::TotalLagrangianSph(Box::new(particles), choices);
    let method = analysis(&method, material).expect("a method");
    let f = DeformationGradient::from_stretches([0.25, 1.0, 1.0]).expect("stretches");
    let predicted = method.acoustic_minimum(&f).expect("a minimum");
    assert!(predicted.eigenvalue.re < 0.0);
    // The edges are held, because the free surface would become unstable first.
    let (length, height) = (72.0, 20.0);
    let rim = |low: [f64; 2], high: [f64; 2]| Grip {
        low: low.to_vec(),
        high: high.to_vec(),
        velocity: vec![0.0; 2],
        ramp: 0.0,
        ..Grip::default()
    };
    let grips = [
        rim([0.0, 0.0], [3.0, height]),
        rim([length - 3.0, 0.0], [length, height]),
        rim([3.1, 0.0], [length - 3.1, 3.0]),
        rim([3.1, height - 3.0], [length - 3.1, height]),
    ];
    let normal = with(&*method, &block(&[length, height]), &grips, |body| {
        let start = Start {
            f,
            noise: 1e-7,
            seed: 2,
        };
        body.start(&start, 0.0).expect("forces");
        let step = 0.5 * body.critical_time_step().expect("a step");
        body.start(&start, step).expect("forces");
        for _ in 0..(3.0 / step) as usize {
            body.advance(step).expect("a step");
        }
        let mut grown = [0.0; 2];
        let mut largest = 0.0_f64;
        for own in body.deformations() {
            for i in 0..2 {
                for j in 0..2 {
                    let change = own[i][j] - f.components()[i][j];
                    grown[j] += change * change;
                    largest = largest.max(change.abs());
                }
            }
        }
        assert!((1e-6..0.05).contains(&largest), "{largest:e}");
        grown.map(f64::sqrt)
    })
    .expect("a body");
    let angle = |x: f64, y: f64| (y.abs() / x.abs()).atan().to_degrees();
    let direction = predicted.direction;
    // The current normal is F^-T N.
    let seen = angle(normal[0] / 0.25, normal[1]);
    let told = angle(direction[0] / 0.25, direction[1]);
    assert!(
        (seen - told).abs() < 2.0,
        "{seen} degrees, predicted {told}"
    );
}

#[test]
fn separated_pieces_count_separately_and_overlaps_once() {
    let method = method(
        LatticeKind::Square,
        &choices(2.4, 0.0, PenaltyForm::Published),
    );
    let count = |offset: f64| {
        with(&*method, &twice(&[6.0, 5.0], offset), &[], |body| {
            body.positions().len()
        })
    };
    assert_eq!([2.0, 6.0, 1e5].map(count), [Ok(40), Ok(60), Ok(60)]);
    assert!(matches!(count(1e8), Err(BodyError::Number { .. })));
}
