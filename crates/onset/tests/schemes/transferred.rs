//! Waves whose velocities pass through a grid: factors of a step, stable steps and growth in closed form.

use nalgebra::{Matrix2, SMatrix, SVector};
use onset::algebra::Complex;
use onset::bloch::{BlochBlocks, Mass, WaveSystem};
use onset::lattice::{Crystal, LatticeKind, Particle};
use onset::time_step::{TransferredWaves, VelocityFilter};
use std::f64::consts::PI;

/// Chain of unit masses and springs whose velocities are averaged with the velocities of the neighbors.
fn chain(share: f64, flip: f64) -> TransferredWaves<1> {
    chain_of(1.0, share, flip)
}

/// Chain with springs of a given stiffness, which are repulsive if it is negative.
fn chain_of(stiffness: f64, share: f64, flip: f64) -> TransferredWaves<1> {
    let lattice = LatticeKind::Chain.lattice::<1>(1.0).expect("a lattice");
    let crystal = Crystal::of_lattice(lattice);
    let home = Particle::home(0);
    let number = SMatrix::<f64, 1, 1>::from_element;
    let (mut springs, mut kept) = (BlochBlocks::new(), BlochBlocks::new());
    for (cell, spring, part) in [
        (0, 2.0, 1.0 - 2.0 * share),
        (1, -1.0, share),
        (-1, -1.0, share),
    ] {
        springs.add(&home, &home.moved(&[cell]), &number(stiffness * spring));
        kept.add(&home, &home.moved(&[cell]), &number(part));
    }
    let kept = kept.sum(&crystal);
    let stiffness = springs.sum(&crystal);
    let system = WaveSystem::new(crystal, stiffness, Mass::Lumped(vec![1.0]));
    TransferredWaves::new(system, &kept, VelocityFilter::Blended { flip })
}

#[test]
fn factors_are_the_eigenvalues_of_an_explicit_step_matrix() {
    for (share, flip, k, dt) in [
        (0.1, 0.0, 1.1, 0.4),
        (0.2, 1.0, 2.9, 0.7),
        (0.15, 0.95, PI, 1.3),
    ] {
        let waves = chain(share, flip);
        let square = 2.0 - 2.0 * f64::cos(k);
        let t = 1.0 - 2.0 * share * (1.0 - f64::cos(k));
        let r = flip * (1.0 - t);
        // A step maps (u, s) to (u', s'), with u' = u + dt w, s' = T w + R s, w = s - dt omega^2 u.
        let [w_u, w_s] = [-dt * square, 1.0];
        let step = Matrix2::new(1.0 + dt * w_u, dt * w_s, t * w_u, t * w_s + r);
        let expected = step.complex_eigenvalues();
        let found = waves.factors(&SVector::from([k]), dt)[0];
        for z in expected.iter() {
            let apart = |own: &Complex| (own - z).norm();
            assert!(found.iter().map(apart).fold(1.0, f64::min) < 1e-13);
        }
    }
}

#[test]
fn zero_energy_waves_and_translations_neither_grow_nor_decay() {
    for flip in [0.0, 0.5, 1.0] {
        let waves = chain(0.2, flip);
        let factors = waves.factors(&SVector::zeros(), 0.3);
        assert_eq!(factors[0].map(|z| (z.re, z.im)), [(1.0, 0.0); 2]);
    }
}

#[test]
fn the_spectral_radius_exceeds_one_beyond_the_largest_stable_step() {
    for (share, flip) in [(0.2, 0.0), (0.2, 1.0), (0.24, 0.9), (0.05, 0.0)] {
        let waves = chain(share, flip);
        let step = waves.critical_time_step();
        let radius = |step: f64| {
            let of = |n: u32| {
                let k = SVector::from([PI * f64::from(n) / 200.0]);
                waves.factors(&k, step)[0][0].norm()
            };
            (0..=200).map(of).fold(0.0, f64::max)
        };
        assert!(radius(step * (1.0 - 1e-6)) < 1.0 + 1e-12);
        assert!(radius(step * (1.0 + 1e-4)) > 1.0 + 1e-6);
        // A scan from below finds no smaller unstable step.
        for n in 1..50 {
            assert!(radius(step * f64::from(n) / 50.0) < 1.0 + 1e-12);
        }
        assert_eq!(waves.fastest(0.9 * step).0, Complex::new(0.0, 0.0));
        assert!(waves.fastest(1.1 * step).0.re > 0.0);
    }
}

#[test]
fn growth_is_reported_for_short_and_long_steps() {
    // Repulsive springs: omega^2 = -4 at the edge of the zone, where the filter keeps half of the velocity.
    let waves = chain_of(-1.0, 0.125, 1.0);
    // With flip = 1 points move with a fraction T of the grid velocities: T |omega^2| remains for short steps.
    for step in [1e-14, 1e-10, 1e-6] {
        let growth = waves.fastest(step).0.re;
        assert!((growth - 2.0_f64.sqrt()).abs() < 1e-5, "{step}: {growth}");
    }
    for step in [1e10, 1e30, 1e100] {
        // The larger factor is z = -omega^2 dt^2 = 4 dt^2 to leading order, and only this factor grows.
        let growth = waves.fastest(step).0.re * step;
        let expected = 2.0 * (2.0 * step).ln();
        assert!(
            (growth / expected - 1.0).abs() < 1e-2,
            "{step}: {growth} {expected}"
        );
    }
}
