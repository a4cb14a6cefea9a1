//! Contact of pieces whose particles are not neighbors of each other.

use super::{at_rest, block, choices, law, method, twice};
use onset::algebra::uniform;
use onset::kinematics::DeformationGradient;
use onset::lattice::LatticeKind;
use onset::motion::{BodyError, BodyMotion, BodyParticles, Contact, Grip, Ground, Start};
use onset::scheme::stabilization::PenaltyForm;

const HARD: Option<Contact> = Some(Contact { stiffness: 0.7 });

fn touching<T>(
    kind: LatticeKind,
    particles: &BodyParticles,
    grips: &[Grip],
    contact: Option<Contact>,
    work: impl Fn(&mut dyn BodyMotion) -> T,
) -> Result<T, BodyError> {
    let method = method(kind, &choices(2.1, 0.0, PenaltyForm::Published));
    let mut answer = None;
    method.with_body(particles, grips, contact, &mut |body| {
        answer = Some(work(body))
    })?;
    Ok(answer.expect("a body"))
}

/// Compares accelerations and energy with and without contact: the differences must equal sums over all pairs.
fn assert_forces_are_those_of_all_pairs<const D: usize>(kind: LatticeKind) {
    let size = [5.0; D];
    // The blocks are far apart in the reference configuration and are moved together.
    let particles = twice(&size, 30.0);
    let evaluated = |contact: Option<Contact>| {
        let of = |body: &mut dyn BodyMotion| {
            let places = body.positions();
            let mut random = 5;
            let u: Vec<f64> = places
                .iter()
                .flat_map(|x| {
                    let moved = if x[0] > 15.0 { -25.3 } else { 0.0 };
                    let noise: [f64; D] =
                        std::array::from_fn(|_| 0.06 * (uniform(&mut random) - 0.5));
                    let mut u = noise;
                    u[0] += moved;
                    u
                })
                .collect();
            body.put(&at_rest(u.clone()), &DeformationGradient::identity());
            let accelerations = body.accelerations().expect("forces");
            let strain = body.quantities(0.0).expect("forces").strain;
            (places, u, accelerations, strain)
        };
        touching(kind, &particles, &[], contact, of).expect("a body")
    };
    let (places, u, with, energy) = evaluated(HARD);
    let (_, _, without, rest) = evaluated(None);
    let modulus = {
        let response = law().response(&DeformationGradient::identity());
        response.expect("a response").tangent[(0, 0, 0, 0)]
    };
    let at = |n: usize| -> [f64; D] { std::array::from_fn(|i| places[n][i] + u[n * D + i]) };
    let mut expected = vec![0.0; with.len()];
    let (mut potential, mut count) = (0.0, 0);
    for a in 0..places.len() {
        for b in 0..places.len() {
            let is_other = (places[a][0] > 15.0) != (places[b][0] > 15.0);
            let (x, y) = (at(a), at(b));
            let distance = (0..D).map(|i| (x[i] - y[i]).powi(2)).sum::<f64>().sqrt();
            if is_other && distance < 1.0 {
                count += 1;
                potential += 0.5 * 0.7 * modulus * (1.0 - distance).powi(2) / 2.0;
                for i in 0..D {
                    // The spacing and the volume are one, the density is 1.3.
                    expected[a * D + i] +=
                        0.7 * modulus * (1.0 - distance) * (x[i] - y[i]) / distance / 1.3;
                }
            }
        }
    }
    assert!(count >= 2, "{count}");
    let size = expected
        .iter()
        .fold(0.0_f64, |most, own| most.max(own.abs()));
    for (n, own) in expected.iter().enumerate() {
        assert!(
            (with[n] - without[n] - own).abs() < 1e-11 * size,
            "{n}: {} {own}",
            with[n] - without[n]
        );
    }
    assert!((energy - rest - potential).abs() < 1e-11 * potential);
}

#[test]
fn contact_forces_and_energy_equal_sums_over_all_pairs_of_two_pieces() {
    assert_forces_are_those_of_all_pairs::<1>(LatticeKind::Chain);
    assert_forces_are_those_of_all_pairs::<2>(LatticeKind::Square);
    assert_forces_are_those_of_all_pairs::<3>(LatticeKind::SimpleCubic);
}

fn undeformed() -> Start {
    Start {
        f: DeformationGradient::identity(),
        noise: 0.0,
        seed: 1,
    }
}

/// Calls a function with two blocks that move toward each other.
fn thrown<T>(speed: f64, contact: Option<Contact>, work: impl Fn(&mut dyn BodyMotion) -> T) -> T {
    let grip = |low: f64, high: f64, speed: f64| Grip {
        low: vec![low, -1.0],
        high: vec![high, 20.0],
        velocity: vec![speed, 0.0],
        ramp: 0.0,
        until: 0.0,
    };
    let grips = [grip(-1.0, 9.0, speed), grip(9.0, 30.0, -speed)];
    let blocks = twice(&[6.0, 5.0], 12.0);
    touching(LatticeKind::Square, &blocks, &grips, contact, work).expect("a body")
}

/// Collision of two blocks: the largest change of the energy, and the final velocity of the first block.
fn collision(fraction: f64, contact: Option<Contact>) -> (f64, f64, [f64; 2]) {
    let run = |body: &mut dyn BodyMotion| {
        let start = undeformed();
        body.start(&start, 0.0).expect("a start");
        let step = fraction * body.critical_time_step().expect("a step");
        body.start(&start, step).expect("a start");
        let first = body.quantities(step).expect("energies");
        let kept = |body: &mut dyn BodyMotion| {
            let own = body.quantities(step).expect("energies");
            (own.kinetic + own.strain, own.momentum, own.angular_momentum)
        };
        let begin = kept(body);
        let mut drift = 0.0_f64;
        let mut turned = 0.0_f64;
        for _ in 0..(200.0 / step) as usize {
            body.advance(step).expect("a step");
            let own = kept(body);
            drift = drift.max((own.0 - begin.0).abs() / first.kinetic);
            for i in 0..3 {
                turned = turned.max((own.1[i] - begin.1[i]).abs());
                turned = turned.max((own.2[i] - begin.2[i]).abs() / 10.0);
            }
        }
        let (places, state) = (body.positions(), body.state());
        let mean = |is_own: &dyn Fn(f64) -> bool| {
            let own: Vec<f64> = (0..places.len())
                .filter(|n| is_own(places[*n][0]))
                .map(|n| state.velocities[2 * n])
                .collect();
            own.iter().sum::<f64>() / own.len() as f64
        };
        (drift, turned, [mean(&|x| x < 9.0), mean(&|x| x > 9.0)])
    };
    thrown(0.05, contact, run)
}

#[test]
fn colliding_blocks_rebound_and_conserve_energy_and_momentum() {
    let (coarse, turned, after) = collision(0.4, HARD);
    let (fine, _, _) = collision(0.2, HARD);
    assert!(turned < 1e-13, "{turned}");
    // The force has a kink at the onset of contact: the error decreases slightly more slowly than with the square of the step.
    assert!(coarse < 0.02 && fine < 0.35 * coarse, "{coarse} {fine}");
    // Part of the energy becomes sound.
    assert!(after[0] < -0.02 && after[1] > 0.02, "{after:?}");
    let (_, _, through) = collision(0.4, None);
    assert!(through[0] > 0.049 && through[1] < -0.049, "{through:?}");
}

#[test]
fn pieces_that_would_pass_through_each_other_end_the_motion() {
    let fault = thrown(3.0, HARD, |body| {
        body.start(&undeformed(), 0.02).expect("a start");
        (0..500).find_map(|_| body.advance(0.02).err())
    })
    .expect("a fault");
    assert_eq!(fault.ground, Ground::Overlapping);
    assert!(fault.to_string().contains("too soft"), "{fault}");
}

#[test]
fn a_contact_without_effect_is_refused() {
    let one = touching(LatticeKind::Square, &block(&[8.0, 4.0]), &[], HARD, |_| ());
    assert!(matches!(one, Err(BodyError::NoContact(why)) if why.contains("one piece")));
    let near = touching(
        LatticeKind::Square,
        &twice(&[4.0, 4.0], 5.0),
        &[],
        HARD,
        |_| (),
    );
    assert!(matches!(near, Err(BodyError::NoContact(why)) if why.contains("one piece")));
    let soft = Some(Contact { stiffness: 0.0 });
    let none = touching(
        LatticeKind::Square,
        &twice(&[4.0, 4.0], 9.0),
        &[],
        soft,
        |_| (),
    );
    assert!(matches!(none, Err(BodyError::Number { .. })));
}
