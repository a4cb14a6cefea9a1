//! Properties of every scheme.

use crate::random::Random;
use nalgebra::{DVector, SVector};
use onset::algebra::Complex;
use onset::kinematics::DeformationGradient;
use onset::lattice::Particle;
use onset::material::Hyperelastic;
use onset::scheme::{Discretization, PatchForces, PeriodicPatch};

/// Checks a scheme in a state: derivatives of the forces of a patch against the stiffness, and the effect of a translation.
#[track_caller]
pub fn assert_scheme<const D: usize>(
    scheme: &dyn Discretization<D>,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
) {
    assert_waves_are_those_of_a_patch(scheme, material, f);
    assert_damping_is_that_of_a_patch(scheme, material, f);
    assert_translations_are_free(scheme, material, f);
    assert_equilibrium(scheme, material, f);
}

/// Displaces a patch of particles by plane waves that fit into it and compares central differences of its forces with `K(k)`.
#[track_caller]
pub fn assert_waves_are_those_of_a_patch<const D: usize>(
    scheme: &dyn Discretization<D>,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
) {
    let system = scheme.waves(material, f).expect("an evaluable state");
    let crystal = scheme.crystal();
    // The patch is so large that no particle interacts with its image.
    let side = 2 * system.stiffness().reach() + 3;
    let patch = PeriodicPatch::new(crystal, [side; D]);
    let mut random = Random::new(3);
    for wave in 0..3 {
        let fractional = SVector::<f64, D>::from_fn(|i, _| ((wave + 2 * i + 1) % side) as f64);
        let k = crystal.lattice().reciprocal() * fractional / side as f64;
        let amplitudes = DVector::from_fn(system.size(), |_, _| {
            Complex::new(random.number(), random.number())
        });
        let displaced = |factor: Complex| -> Vec<SVector<f64, D>> {
            let of = |particle: &Particle<D>| {
                let phase = k.dot(&crystal.position(particle));
                let turn = Complex::new(phase.cos(), phase.sin()) * factor;
                SVector::from_fn(|i, _| (amplitudes[D * particle.site + i] * turn).re)
            };
            patch.particles().iter().map(of).collect()
        };
        let h = 1e-5 * crystal.nearest_distance();
        let forces = |factor: Complex| {
            let at = |sign: f64| {
                let moved = displaced(factor * (sign * h));
                scheme.forces(material, f, &patch, &moved).expect("forces")
            };
            let (plus, minus) = (at(1.0), at(-1.0));
            let slope = |(a, b): (&SVector<f64, D>, &SVector<f64, D>)| (a - b) / (2.0 * h);
            plus.iter().zip(&minus).map(slope).collect::<Vec<_>>()
        };
        // Forces on the particles of the cell at the origin, for the real and the imaginary part of the wave.
        let (real, imaginary) = (
            forces(Complex::new(1.0, 0.0)),
            forces(Complex::new(0.0, -1.0)),
        );
        let expected = -(system.stiffness().at(&k) * &amplitudes);
        let scale = system.stiffness().magnitude();
        for site in 0..crystal.sites().len() {
            let particle = Particle::home(site);
            let phase = k.dot(&crystal.position(&particle));
            let turn = Complex::new(phase.cos(), -phase.sin());
            let number = patch.number(&particle);
            for i in 0..D {
                let measured = Complex::new(real[number][i], imaginary[number][i]) * turn;
                let difference = (measured - expected[D * site + i]).norm();
                assert!(
                    difference < 1e-7 * scale,
                    "site {site}, component {i}: {measured} by differences, {} by the wave system; scale {scale}, k = {k}",
                    expected[D * site + i]
                );
            }
        }
    }
}

/// Compares the forces of a patch whose particles move by a plane wave, by central differences, with `C(k)`.
#[track_caller]
pub fn assert_damping_is_that_of_a_patch<const D: usize>(
    scheme: &dyn Discretization<D>,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
) {
    let system = scheme.waves(material, f).expect("an evaluable state");
    let Some(damping) = system.damping() else {
        return;
    };
    let crystal = scheme.crystal();
    let side = 2 * damping.reach() + 3;
    let patch = PeriodicPatch::new(crystal, [side; D]);
    let fractional = SVector::<f64, D>::from_fn(|i, _| (i + 1) as f64 / side as f64);
    let k = crystal.lattice().reciprocal() * fractional;
    let mut random = Random::new(7);
    let amplitudes = DVector::from_fn(system.size(), |_, _| {
        Complex::new(random.number(), random.number())
    });
    let at_rest = vec![SVector::zeros(); patch.len()];
    let h = 1e-6 * crystal.nearest_distance();
    let forces = |factor: Complex| {
        let moving = |sign: f64| -> Vec<SVector<f64, D>> {
            let of = |particle: &Particle<D>| {
                let phase = k.dot(&crystal.position(particle));
                let turn = Complex::new(phase.cos(), phase.sin()) * factor * (sign * h);
                SVector::from_fn(|i, _| (amplitudes[D * particle.site + i] * turn).re)
            };
            patch.particles().iter().map(of).collect()
        };
        let mut slopes = Vec::new();
        let work = &mut |own: &dyn PatchForces<D>| {
            let at = |sign| own.at(&at_rest, &moving(sign)).expect("forces");
            let pairs = at(1.0).into_iter().zip(at(-1.0));
            slopes = pairs.map(|(a, b)| (a - b) / (2.0 * h)).collect();
        };
        let prepared = scheme.with_forces(material, f, &patch, work);
        prepared.expect("an evaluable state");
        slopes
    };
    let (real, imaginary) = (
        forces(Complex::new(1.0, 0.0)),
        forces(Complex::new(0.0, -1.0)),
    );
    let expected = -(damping.at(&k) * &amplitudes);
    for site in 0..crystal.sites().len() {
        let particle = Particle::home(site);
        let phase = k.dot(&crystal.position(&particle));
        let turn = Complex::new(phase.cos(), -phase.sin());
        let number = patch.number(&particle);
        for i in 0..D {
            let measured = Complex::new(real[number][i], imaginary[number][i]) * turn;
            let difference = (measured - expected[D * site + i]).norm();
            assert!(
                difference < 1e-4 * damping.magnitude(),
                "site {site}: {difference}"
            );
        }
    }
}

/// Checks that a rigid translation causes no force, and that the sum of all forces is zero.
#[track_caller]
pub fn assert_translations_are_free<const D: usize>(
    scheme: &dyn Discretization<D>,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
) {
    let system = scheme.waves(material, f).expect("an evaluable state");
    let scale = system.stiffness().magnitude();
    let k = system.stiffness().at(&SVector::zeros());
    for i in 0..D {
        let translation = DVector::from_fn(system.size(), |row, _| {
            Complex::new(f64::from(u8::from(row % D == i)), 0.0)
        });
        assert!(
            (&k * &translation).norm() < 1e-10 * scale,
            "a translation strains the body: {}",
            (&k * &translation)
        );
        assert!(
            (k.transpose() * &translation).norm() < 1e-10 * scale,
            "the forces do not add up to zero"
        );
    }
}

/// Checks that no force acts on a particle of the homogeneous state.
#[track_caller]
pub fn assert_equilibrium<const D: usize>(
    scheme: &dyn Discretization<D>,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
) {
    let system = scheme.waves(material, f).expect("an evaluable state");
    let side = 2 * system.stiffness().reach() + 3;
    let patch = PeriodicPatch::new(scheme.crystal(), [side; D]);
    let at_rest = vec![SVector::zeros(); patch.len()];
    let forces = scheme
        .forces(material, f, &patch, &at_rest)
        .expect("forces");
    let scale = system.stiffness().magnitude() * scheme.crystal().nearest_distance();
    for force in forces {
        assert!(force.amax() < 1e-10 * scale, "a force of {force} at rest");
    }
}

/// Checks that the acoustic tensor of long waves equals the acoustic tensor of the material divided by the density, to a relative tolerance.
#[track_caller]
pub fn assert_long_waves_are_those_of_the_material<const D: usize>(
    scheme: &dyn Discretization<D>,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
    tolerance: f64,
) {
    let discrete = scheme
        .waves(material, f)
        .expect("an evaluable state")
        .long_wave_stiffness();
    let exact = onset::continuum::Stiffness::<D>::at(material, f).expect("a tangent");
    let scale = exact.maximum_eigenvalue() / scheme.density();
    let mut random = Random::new(5);
    for _ in 0..8 {
        let rotation = random.rotation();
        let direction = SVector::<f64, D>::from_fn(|i, _| rotation[(i, 0)]).normalize();
        let found = discrete.acoustic_tensor(&direction);
        let expected = exact.acoustic_tensor(&direction) / scheme.density();
        assert!(
            (found - expected).amax() < tolerance * scale,
            "long waves along {direction}: {found}, the material {expected}"
        );
    }
}
