//! Total-Lagrangian SPH with deformation gradients from the bonds of a particle.

use crate::battery::{assert_long_waves_are_those_of_the_material, assert_scheme};
use crate::random::Random;
use crate::sph::{crystal, stretched};
use crate::states::saint_venant_kirchhoff;
use nalgebra::{DMatrix, SMatrix, SVector};
use onset::algebra::Complex;
use onset::kernel::Kernel;
use onset::kinematics::DeformationGradient;
use onset::lattice::{Fractional, LatticeKind, Particle};
use onset::material::{Hyperelastic, ModifiedMooneyRivlin};
use onset::measures::spurious_modes;
use onset::scheme::sph::{
    ParticleGradient, ShearForces, TotalLagrangianChoices, TotalLagrangianSph,
};
use onset::scheme::{Discretization, PeriodicPatch, SeenForm, StrainOperator};
use onset::verdict::{Survey, WEAK_WAVE_RATIO};
use std::f64::consts::TAU;

const LAMBDA: f64 = 1.7;
const MU: f64 = 0.8;
const RHO: f64 = 1.3;

fn solid() -> Box<dyn Hyperelastic> {
    saint_venant_kirchhoff(LAMBDA, MU)
}

fn choices(radius: f64, gradient: ParticleGradient) -> TotalLagrangianChoices {
    TotalLagrangianChoices {
        density: RHO,
        radius,
        gradient,
        ..TotalLagrangianChoices::default()
    }
}

fn of_bonds<const D: usize>(kind: LatticeKind, radius: f64) -> TotalLagrangianSph<D> {
    let choices = choices(radius, ParticleGradient::Bonds);
    TotalLagrangianSph::new(crystal(kind), choices).expect("a scheme")
}

/// Neighbors of the particles of a Bravais lattice, with weights and corrected gradients computed here.
struct Neighbors<const D: usize> {
    volume: f64,
    /// Weight of the particle itself.
    own: f64,
    /// Vector, weight and gradient of each neighbor.
    others: Vec<(SVector<f64, D>, f64, SVector<f64, D>)>,
}

fn neighbors<const D: usize>(kind: LatticeKind, radius: f64) -> Neighbors<D> {
    let lattice = kind.lattice::<D>(1.0).expect("a lattice");
    let (kernel, one) = (Kernel::QuarticSpline, SMatrix::<f64, D, D>::identity());
    let volume = lattice.cell_volume();
    let digits = (0..9_usize.pow(D as u32))
        .map(|n| SVector::<f64, D>::from_fn(|i, _| (n / 9_usize.pow(i as u32) % 9) as f64 - 4.0));
    let bonds = digits.map(|n| lattice.vectors() * n);
    let weighed = |x: SVector<f64, D>| {
        let weight = kernel.weight(&x, radius, &one)?;
        Some((x, weight.value, -weight.gradient * volume))
    };
    let (itself, mut others): (Vec<_>, Vec<_>) = bonds
        .filter_map(weighed)
        .partition(|(x, _, _)| x.norm() == 0.0);
    let moment: SMatrix<f64, D, D> = others.iter().map(|(x, _, g)| x * g.transpose()).sum();
    let inverse = moment.try_inverse().expect("neighbors in all directions");
    for (_, _, g) in &mut others {
        *g = inverse.transpose() * *g;
    }
    Neighbors {
        volume,
        own: itself[0].1,
        others,
    }
}

/// Vector between the current positions of two particles, given by the number of the first and the reference vector to the second, and the number of the
/// second.
type Apart<'a, const D: usize> = dyn Fn(usize, &SVector<f64, D>) -> (SVector<f64, D>, usize) + 'a;

/// Deformation gradients of the particles of a periodic patch, as means over the bonds written out.
fn means<const D: usize>(
    near: &Neighbors<D>,
    count: usize,
    apart: &Apart<'_, D>,
) -> Vec<SMatrix<f64, D, D>> {
    let of_particle = |i: usize| -> SMatrix<f64, D, D> {
        let each = near.others.iter();
        each.map(|(x, _, g)| apart(i, x).0 * g.transpose()).sum()
    };
    let own: Vec<_> = (0..count).map(of_particle).collect();
    let mean = |i: usize| {
        let (mut sum, mut weights) = (own[i] * near.own, near.own);
        for (x, weight, _) in &near.others {
            let (current, j) = apart(i, x);
            let both = (own[i] + own[j]) * 0.5;
            let bond = both + (current - both * x) * x.transpose() / x.norm_squared();
            sum += bond * *weight;
            weights += weight;
        }
        sum / weights
    };
    (0..count).map(mean).collect()
}

fn energy<const D: usize>(f: &SMatrix<f64, D, D>) -> f64 {
    let strain = (f.transpose() * f - SMatrix::identity()) * 0.5;
    0.5 * LAMBDA * strain.trace().powi(2) + MU * strain.norm_squared()
}

fn random_state<const D: usize>(random: &mut Random) -> SMatrix<f64, D, D> {
    SMatrix::from_fn(|i, j| f64::from(u8::from(i == j)) + 0.15 * random.number())
}

/// Compares the forces of a patch of displaced particles with differences of its energy, and checks that their sum vanishes.
fn assert_forces_follow_from_the_energy<const D: usize>(kind: LatticeKind, radius: f64, seed: u64) {
    let mut random = Random::new(seed);
    let (own, near) = (crystal::<D>(kind), neighbors::<D>(kind, radius));
    let side = 7_usize;
    let patch = PeriodicPatch::new(&own, [side; D]);
    let f = random_state::<D>(&mut random);
    let mut draw = || SVector::<f64, D>::from_fn(|_, _| 0.1 * random.number());
    let displacements: Vec<_> = (0..patch.len()).map(|_| draw()).collect();
    let lattice = own.lattice();
    let number = |i: usize, x: &SVector<f64, D>| {
        let to = own.position(&patch.particles()[i]) + x;
        let cell = lattice.reciprocal().transpose() / TAU * to;
        patch.number(&Particle {
            site: 0,
            cell: cell
                .map(|c| (c.round() as i32).rem_euclid(side as i32))
                .into(),
        })
    };
    let total = |u: &[SVector<f64, D>]| -> f64 {
        let apart = |i: usize, x: &SVector<f64, D>| {
            let j = number(i, x);
            (f * x + u[j] - u[i], j)
        };
        let means = means(&near, patch.len(), &apart);
        near.volume * means.iter().map(energy).sum::<f64>()
    };
    let state = DeformationGradient::identity().with_leading(&f);
    let sph = of_bonds::<D>(kind, radius);
    let forces = sph
        .forces(&*solid(), &state, &patch, &displacements)
        .expect("forces");
    let scale = forces.iter().map(|force| force.norm()).fold(0.0, f64::max);
    for particle in [0, patch.len() / 2 + 1] {
        for axis in 0..D {
            let at = |size: f64| {
                let mut moved = displacements.clone();
                moved[particle][axis] += size;
                total(&moved)
            };
            let h = 1e-3;
            let slope = ((at(h) - at(-h)) * 8.0 - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
            let found = forces[particle][axis];
            assert!(
                (found + slope).abs() < 1e-8 * scale,
                "{kind:?}: {found} {slope}, scale {scale}"
            );
        }
    }
    let sum: SVector<f64, D> = forces.iter().sum();
    assert!(sum.norm() < 1e-11 * scale, "{sum}");
}

#[test]
fn forces_are_the_negative_derivatives_of_the_energy_of_mean_gradients() {
    for seed in 1..4 {
        assert_forces_follow_from_the_energy::<1>(LatticeKind::Chain, 2.3, seed);
        assert_forces_follow_from_the_energy::<2>(LatticeKind::Square, 2.3, seed);
        assert_forces_follow_from_the_energy::<2>(LatticeKind::Hexagonal, 2.1, seed);
    }
    assert_forces_follow_from_the_energy::<3>(LatticeKind::FaceCenteredCubic, 1.2, 4);
}

/// Compares spectra of random states and waves with the matrix `V A : conj(G) (x) G / m`, where a wave has the deformation gradient `u (x) G`.
fn assert_spectra<const D: usize>(kind: LatticeKind, radius: f64, states: usize) {
    let mut random = Random::new(17);
    let near = neighbors::<D>(kind, radius);
    let sph = of_bonds::<D>(kind, radius);
    let material = solid();
    let complex = |x: &SVector<f64, D>| x.map(Complex::from);
    for _ in 0..states {
        let f = random_state::<D>(&mut random);
        let state = DeformationGradient::identity().with_leading(&f);
        let k = SVector::<f64, D>::from_fn(|_, _| 3.0 * random.number());
        let turn = |x: &SVector<f64, D>| Complex::new(k.dot(x).cos(), k.dot(x).sin());
        let one = Complex::new(1.0, 0.0);
        let of_particle: SVector<Complex, D> = near
            .others
            .iter()
            .map(|(x, _, g)| complex(g) * (turn(x) - one))
            .sum();
        let (mut gradient, mut weights) = (of_particle * Complex::from(near.own), near.own);
        for (x, weight, _) in &near.others {
            let mean = of_particle * ((one + turn(x)) * 0.5);
            let along = (0..D).map(|i| mean[i] * x[i]).sum::<Complex>();
            let missed = (turn(x) - one - along) / Complex::from(x.norm_squared());
            gradient += (mean + complex(x) * missed) * Complex::from(*weight);
            weights += weight;
        }
        gradient /= Complex::from(weights);
        let response = material.response(&state).expect("a state");
        let matrix = DMatrix::from_fn(D, D, |i, l| {
            let pairs = (0..D).flat_map(|j| (0..D).map(move |m| (j, m)));
            let term = |(j, m): (usize, usize)| {
                gradient[j].conj() * gradient[m] * Complex::from(response.tangent[(i, j, l, m)])
            };
            pairs.map(term).sum::<Complex>() / Complex::from(RHO)
        });
        let mut expected: Vec<f64> = matrix.symmetric_eigenvalues().iter().copied().collect();
        expected.sort_by(f64::total_cmp);
        let system = sph.waves(&*material, &state).expect("a state");
        let scale = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        for (found, expected) in system.omega_squared(&k).iter().zip(&expected) {
            assert!(
                (found - Complex::from(*expected)).norm() < 1e-10 * scale,
                "{kind:?}: {found} {expected}"
            );
        }
    }
}

#[test]
fn spectra_of_random_states_follow_from_the_mean_gradient_of_a_wave() {
    assert_spectra::<1>(LatticeKind::Chain, 2.3, 10);
    assert_spectra::<2>(LatticeKind::Square, 2.6, 15);
    assert_spectra::<2>(LatticeKind::Hexagonal, 2.1, 15);
    assert_spectra::<3>(LatticeKind::SimpleCubic, 1.6, 5);
    assert_spectra::<3>(LatticeKind::BodyCenteredCubic, 1.4, 5);
}

#[test]
fn gradients_of_bonds_pass_the_scheme_checks_with_all_other_choices() {
    let material = ModifiedMooneyRivlin::default();
    let f = stretched([1.1, 0.9, 1.05]);
    let pairs = ShearForces::Pairs { coefficient: 1.07 };
    for (corrected, penalty, shear) in [
        (true, 0.0, ShearForces::Stress),
        (true, 5.0, ShearForces::Stress),
        (false, 0.0, ShearForces::Stress),
        (true, 0.0, pairs),
    ] {
        let choices = TotalLagrangianChoices {
            corrected,
            penalty,
            shear,
            ..choices(2.1, ParticleGradient::Bonds)
        };
        let chain = TotalLagrangianSph::new(crystal::<1>(LatticeKind::Chain), choices.clone());
        assert_scheme(&chain.expect("a scheme"), &material, &f);
        let honeycomb = crystal::<2>(LatticeKind::Honeycomb);
        let honeycomb = TotalLagrangianSph::new(honeycomb, choices).expect("a scheme");
        assert_scheme(&honeycomb, &material, &f);
    }
    assert_scheme(&of_bonds::<3>(LatticeKind::SimpleCubic, 1.2), &material, &f);
}

#[test]
fn long_waves_of_gradients_of_bonds_agree_with_the_material() {
    let (material, f) = (ModifiedMooneyRivlin::default(), stretched([1.2, 0.9, 1.0]));
    for kind in [LatticeKind::Square, LatticeKind::Hexagonal] {
        let sph = of_bonds::<2>(kind, 2.3);
        assert_long_waves_are_those_of_the_material(&sph, &material, &f, 1e-10);
    }
    let sph = of_bonds::<3>(LatticeKind::FaceCenteredCubic, 1.3);
    assert_long_waves_are_those_of_the_material(&sph, &material, &f, 1e-10);
}

/// Particles and gradients of the strains of an operator.
fn gradients<const D: usize>(
    strain: &StrainOperator<D>,
) -> impl Iterator<Item = (&[Particle<D>], &[SVector<f64, D>])> {
    strain.points().iter().map(|point| {
        let SeenForm::Strain(gradients) = &point.forms[0] else {
            panic!("a strain")
        };
        (&point.particles[..], &gradients[..])
    })
}

#[test]
fn linear_fields_are_exact_at_the_faces_of_a_block_and_between_irregular_particles() {
    let square = crystal::<2>(LatticeKind::Square);
    let irregular = square
        .supercell([3, 3])
        .and_then(|large| large.perturbed(0.15, 4))
        .expect("a crystal");
    for own in [square, irregular] {
        let sph = TotalLagrangianSph::new(own, choices(2.3, ParticleGradient::Bonds));
        let sph = sph.expect("a scheme");
        let block = sph.on_block([6, 5], &Fractional::zeros()).expect("a block");
        let block = block.expect("particles of a block");
        for scheme in [&sph as &dyn Discretization<2>, &*block] {
            let strain = scheme.strain().expect("gradients");
            for (particles, gradients) in gradients(&strain) {
                let positions = particles.iter().map(|p| scheme.crystal().position(p));
                let moment: SMatrix<f64, 2, 2> = positions
                    .zip(gradients)
                    .map(|(x, g)| x * g.transpose())
                    .sum();
                assert!((moment - SMatrix::identity()).amax() < 1e-11, "{moment}");
                let sum: SVector<f64, 2> = gradients.iter().sum();
                assert!(sum.amax() < 1e-12, "{sum}");
            }
        }
    }
}

fn zero_energy_modes<const D: usize>(
    kind: LatticeKind,
    radius: f64,
    gradient: ParticleGradient,
) -> usize {
    let material = ModifiedMooneyRivlin::default();
    let sph = TotalLagrangianSph::new(crystal::<D>(kind), choices(radius, gradient));
    let sph = sph.expect("a scheme");
    let survey = Survey::new(&sph, &material).expect("a survey");
    let found = spurious_modes(&survey, WEAK_WAVE_RATIO).expect("modes");
    found.modes.iter().filter(|mode| mode.is_zero()).count()
}

#[test]
fn waves_that_alternate_about_a_center_of_inversion_strain_no_mean_over_bonds() {
    // At half of a reciprocal vector opposite neighbors move alike, and opposite bonds have opposite gradients.
    let material = ModifiedMooneyRivlin::default();
    let f = stretched([1.1, 0.9, 1.0]);
    for kind in [LatticeKind::Square, LatticeKind::Hexagonal] {
        let sph = of_bonds::<2>(kind, 2.3);
        let system = sph.waves(&material, &f).expect("a state");
        for halves in [[0.5, 0.0], [0.0, 0.5], [0.5, 0.5]] {
            let k = sph.crystal().lattice().reciprocal() * SVector::from(halves);
            let stiffness = system.stiffness().at(&k).norm();
            assert!(stiffness < 1e-13 * system.stiffness().magnitude());
        }
    }
}

#[test]
fn a_mean_over_bonds_removes_zero_energy_modes_of_wide_supports_except_at_centers_of_inversion() {
    fn counts<const D: usize>(kind: LatticeKind, radius: f64) -> [usize; 2] {
        [ParticleGradient::Kernel, ParticleGradient::Bonds]
            .map(|gradient| zero_energy_modes::<D>(kind, radius, gradient))
    }
    // With narrow supports only the modes at points of high symmetry exist.
    assert_eq!(counts::<2>(LatticeKind::Square, 2.0), [3, 3]);
    assert_eq!(counts::<2>(LatticeKind::Square, 2.6), [7, 3]);
    assert_eq!(counts::<2>(LatticeKind::Hexagonal, 2.0), [4, 4]);
    assert_eq!(counts::<2>(LatticeKind::Hexagonal, 2.6), [10, 4]);
    assert_eq!(counts::<3>(LatticeKind::SimpleCubic, 1.9), [17, 7]);
    assert_eq!(counts::<3>(LatticeKind::FaceCenteredCubic, 1.6), [16, 16]);
}
