//! Non-hourglass formulations of updated SPH: a penalty on the motion that velocity gradients do not predict, and shear between pairs.

use crate::battery::assert_scheme;
use crate::random::Random;
use crate::sph::{crystal, updated};
use crate::states::saint_venant_kirchhoff;
use nalgebra::{DMatrix, Matrix3, SMatrix, SVector};
use onset::algebra::Complex;
use onset::kernel::Kernel;
use onset::kinematics::DeformationGradient;
use onset::lattice::{Crystal, LatticeKind};
use onset::material::{Hyperelastic, Law, MaterialError};
use onset::measures::spurious_modes;
use onset::method::MethodError;
use onset::scheme::Discretization;
use onset::scheme::sph::{
    DensityEvolution, MomentumForm, ShearForces, UpdatedSph, UpdatedSphChoices,
};
use onset::verdict::{Survey, WEAK_WAVE_RATIO};
use std::f64::consts::PI;

const LAMBDA: f64 = 1.7;
const MU: f64 = 0.8;
const RHO: f64 = 1.3;

fn solid() -> Box<dyn Hyperelastic> {
    saint_venant_kirchhoff(LAMBDA, MU)
}

fn choices(radius: f64, penalty: f64, shear: ShearForces) -> UpdatedSphChoices {
    UpdatedSphChoices {
        density: RHO,
        kernel: Kernel::WendlandC2,
        radius,
        momentum: MomentumForm::Mean,
        corrected: true,
        penalty,
        shear,
        ..UpdatedSphChoices::default()
    }
}

fn pairs<const D: usize>() -> ShearForces {
    ShearForces::Pairs {
        coefficient: UpdatedSphChoices::published_shear_coefficient(D),
    }
}

/// Both formulations.
fn both<const D: usize>(radius: f64) -> [UpdatedSphChoices; 2] {
    [
        choices(radius, 4.0, ShearForces::Stress),
        choices(radius, 0.0, pairs::<D>()),
    ]
}

/// Slope `W'(r)` of the normalized Wendland kernel.
fn slope<const D: usize>(radius: f64, r: f64) -> f64 {
    let integral = match D {
        2 => PI * radius.powi(2) / 7.0,
        _ => 2.0 * PI * radius.powi(3) / 21.0,
    };
    let q = r / radius;
    match q < 1.0 {
        true => -20.0 * q * (1.0 - q).powi(3) / (integral * radius),
        false => 0.0,
    }
}

fn determinant<const D: usize>(matrix: &SMatrix<f64, D, D>) -> f64 {
    DMatrix::from_fn(D, D, |i, j| matrix[(i, j)]).determinant()
}

/// Particles of a periodic body, which are moved step by step as in the code: velocity gradients, densities and accelerations are integrated in time.
struct Body<const D: usize> {
    cells: usize,
    count: usize,
    /// Reference vectors of all particles.
    places: Vec<SVector<f64, D>>,
    /// Particle, neighbor, and the reference vector between them.
    pairs: Vec<(usize, usize, SVector<f64, D>)>,
    volume: f64,
    f: SMatrix<f64, D, D>,
    choices: UpdatedSphChoices,
}

impl<const D: usize> Body<D> {
    fn new(basis: SMatrix<f64, D, D>, f: SMatrix<f64, D, D>, choices: UpdatedSphChoices) -> Self {
        // No particle is a neighbor of another particle twice.
        let cells = 7_usize;
        let count = cells.pow(D as u32);
        let digits =
            |n: usize| SVector::<f64, D>::from_fn(|i, _| (n / cells.pow(i as u32) % cells) as f64);
        let places: Vec<_> = (0..count).map(|n| basis * digits(n)).collect();
        let mut pairs = Vec::new();
        for i in 0..count {
            for j in 0..count {
                let folded = (digits(j) - digits(i)).map(|n| {
                    let half = (cells / 2) as f64;
                    (n + half).rem_euclid(cells as f64) - half
                });
                let x = basis * folded;
                if i != j && (f * x).norm() < 1.02 * choices.radius {
                    pairs.push((i, j, x));
                }
            }
        }
        Self {
            cells,
            count,
            places,
            pairs,
            volume: determinant(&basis).abs(),
            f,
            choices,
        }
    }

    /// Cauchy stress that acts at a deformation gradient: of Saint Venant and Kirchhoff's law in plane strain, or its mean.
    fn stress(&self, f: &SMatrix<f64, D, D>) -> SMatrix<f64, D, D> {
        let one = SMatrix::<f64, D, D>::identity();
        let strain = (f.transpose() * f - one) * 0.5;
        let second = one * (LAMBDA * strain.trace()) + strain * (2.0 * MU);
        let jacobian = determinant(f);
        let stress = f * second * f.transpose() / jacobian;
        if self.choices.shear == ShearForces::Stress {
            return stress;
        }
        let across = (3 - D) as f64 * LAMBDA * strain.trace() / jacobian;
        one * ((stress.trace() + across) / 3.0)
    }

    /// Forces after the particles have moved with constant velocities for a unit of time, in a few steps.
    fn forces(&self, v: &[SVector<f64, D>]) -> Vec<SVector<f64, D>> {
        const STEPS: usize = 3;
        let dt = 1.0 / STEPS as f64;
        let (coefficient, is_predicted) = match self.choices.shear {
            ShearForces::Stress => (self.choices.penalty, 1.0),
            ShearForces::Pairs { coefficient } => (2.0 * coefficient, 0.0),
        };
        let radius = self.choices.radius;
        let mut f = vec![self.f; self.count];
        let mut accumulated = vec![SVector::<f64, D>::zeros(); self.count];
        let volumes = |f: &[SMatrix<f64, D, D>]| -> Vec<f64> {
            f.iter().map(|f| self.volume * determinant(f)).collect()
        };
        for step in 0..STEPS {
            let time = step as f64 * dt;
            let volume = volumes(&f);
            let apart =
                |(i, j, x): &(usize, usize, SVector<f64, D>)| self.f * x + (v[*j] - v[*i]) * time;
            let mut moments = vec![SMatrix::<f64, D, D>::zeros(); self.count];
            let mut sums = moments.clone();
            for pair in &self.pairs {
                let (i, j, _) = *pair;
                let x = apart(pair);
                // Gradient with respect to the first particle.
                let gradient = -x * (slope::<D>(radius, x.norm()) / x.norm());
                moments[i] += x * gradient.transpose() * volume[j];
                sums[i] += (v[j] - v[i]) * gradient.transpose() * volume[j];
            }
            let both = sums.iter().zip(&moments);
            let rates: Vec<SMatrix<f64, D, D>> = both
                .map(|(sum, moment)| sum * moment.try_inverse().expect("a regular moment"))
                .collect();
            let mut grown = vec![SVector::<f64, D>::zeros(); self.count];
            for pair in &self.pairs {
                let (i, j, _) = *pair;
                let apart = -apart(pair);
                let r = apart.norm();
                let e = apart / r;
                let predicted = (rates[i] + rates[j]) * apart * (0.5 * is_predicted);
                let missed = (v[i] - v[j] - predicted).dot(&e);
                let density = RHO / determinant(&f[i]);
                let factor = coefficient * MU / density * volume[j] * slope::<D>(radius, r) / r;
                grown[i] += e * (factor * missed);
            }
            for i in 0..self.count {
                let spin = (rates[i] - rates[i].transpose()) * (0.5 * dt);
                let turned = spin * accumulated[i];
                accumulated[i] += turned + grown[i] * dt;
                let stretched = rates[i] * f[i];
                f[i] += stretched * dt;
            }
        }
        let volume = volumes(&f);
        let stresses: Vec<_> = f.iter().map(|f| self.stress(f)).collect();
        let mass = RHO * self.volume;
        let mut forces: Vec<SVector<f64, D>> = accumulated.iter().map(|a| a * mass).collect();
        for (i, j, x) in &self.pairs {
            let x = self.f * x + v[*j] - v[*i];
            let gradient = -x * (slope::<D>(radius, x.norm()) / x.norm());
            forces[*i] += (stresses[*i] + stresses[*j]) * gradient * (volume[*i] * volume[*j]);
        }
        forces
    }

    /// Matrix of `omega^2` at a wave vector that fits into the body, by differences of the forces.
    fn dynamical_matrix(&self, k: &SVector<f64, D>) -> SMatrix<Complex, D, D> {
        let h = 1e-3;
        let slopes = |turn: f64, axis: usize| {
            let at = |size: f64| {
                let of = |x: &SVector<f64, D>| {
                    let mut v = SVector::<f64, D>::zeros();
                    v[axis] = size * h * (k.dot(x) - turn).cos();
                    v
                };
                self.forces(&self.places.iter().map(of).collect::<Vec<_>>())[0]
            };
            ((at(1.0) - at(-1.0)) * 8.0 - (at(2.0) - at(-2.0))) / (12.0 * h)
        };
        let mut matrix = SMatrix::zeros();
        for axis in 0..D {
            let (real, imaginary) = (slopes(0.0, axis), slopes(0.5 * PI, axis));
            for i in 0..D {
                let force = Complex::new(real[i], imaginary[i]);
                matrix[(i, axis)] = -force / (RHO * self.volume);
            }
        }
        matrix
    }
}

fn random_state<const D: usize>(random: &mut Random) -> SMatrix<f64, D, D> {
    let turn = random.rotation();
    let rotation = match D {
        2 => *nalgebra::Rotation3::new(nalgebra::Vector3::z() * random.number()).matrix(),
        _ => turn,
    };
    let stretch = SMatrix::<f64, D, D>::from_fn(|i, j| match i == j {
        true => 1.0 + 0.08 * random.number(),
        false => 0.06 * random.number(),
    });
    SMatrix::<f64, D, D>::from_fn(|i, j| rotation[(i, j)]) * stretch
}

fn assert_matrices_are_those_of_a_body<const D: usize>(kind: LatticeKind, radius: f64, seed: u64) {
    let mut random = Random::new(seed);
    let lattice = kind.lattice::<D>(1.0).expect("a lattice");
    let material = solid();
    for choices in both::<D>(radius) {
        let f = random_state::<D>(&mut random);
        let body = Body::new(*lattice.vectors(), f, choices.clone());
        let state = DeformationGradient::identity().with_leading(&f);
        let sph = updated(Crystal::of_lattice(lattice), choices);
        let system = sph.waves(&*material, &state).expect("a state");
        for wave in 0..2_usize {
            let numbers = SVector::<f64, D>::from_fn(|i, _| {
                ((1 + wave + (2 + wave) * i) % body.cells) as f64 / body.cells as f64
            });
            let k = lattice.reciprocal() * numbers;
            let (found, expected) = (system.dynamical_matrix_at(&k), body.dynamical_matrix(&k));
            let scale = expected.map(|z| z.norm()).max();
            for i in 0..D {
                for j in 0..D {
                    let apart = (found[(i, j)] - expected[(i, j)]).norm();
                    assert!(apart < 1e-8 * scale, "{kind:?}: {found} {expected}");
                }
            }
        }
    }
}

#[test]
fn waves_equal_the_motion_of_particles_moved_step_by_step() {
    for seed in 1..4 {
        assert_matrices_are_those_of_a_body::<2>(LatticeKind::Square, 2.6, seed);
        assert_matrices_are_those_of_a_body::<2>(LatticeKind::Hexagonal, 2.3, seed);
    }
    assert_matrices_are_those_of_a_body::<3>(LatticeKind::SimpleCubic, 1.7, 4);
    assert_matrices_are_those_of_a_body::<3>(LatticeKind::FaceCenteredCubic, 1.6, 5);
}

#[test]
fn both_formulations_pass_the_battery_with_all_forms() {
    let material = solid();
    let f = DeformationGradient::plane_strain([[1.1, 0.2], [0.0, 0.95]], 1.0).expect("a state");
    let square = crystal::<2>(LatticeKind::Square);
    for momentum in [MomentumForm::Symmetric, MomentumForm::Mean] {
        for density_evolution in [DensityEvolution::Summation, DensityEvolution::Continuity] {
            for choices in both::<2>(2.3) {
                let choices = UpdatedSphChoices {
                    momentum,
                    density_evolution,
                    ..choices
                };
                assert_scheme(&updated(square.clone(), choices), &*material, &f);
            }
        }
    }
    let stretched = DeformationGradient::from_stretches([1.1, 0.9, 1.05]).expect("a state");
    for choices in both::<3>(1.6) {
        let cubic = crystal::<3>(LatticeKind::SimpleCubic);
        assert_scheme(&updated(cubic, choices), &*material, &stretched);
    }
    let chain = crystal::<1>(LatticeKind::Chain);
    let [penalty, _] = both::<1>(2.3);
    assert_scheme(&updated(chain, penalty), &*material, &stretched);
}

#[test]
fn the_penalty_leaves_long_waves_unchanged() {
    let mut random = Random::new(8);
    let material = solid();
    for kind in [LatticeKind::Square, LatticeKind::Hexagonal] {
        let f = DeformationGradient::identity().with_leading(&random_state::<2>(&mut random));
        let long = |penalty| {
            let choices = choices(2.6, penalty, ShearForces::Stress);
            let system = updated(crystal::<2>(kind), choices).waves(&*material, &f);
            system.expect("a state").long_wave_stiffness()
        };
        let (plain, penalized) = (long(0.0), long(4.0));
        for n in 0..6 {
            let angle = 0.5 * f64::from(n);
            let along = SVector::from([angle.cos(), angle.sin()]);
            let plain = plain.acoustic_tensor(&along);
            let apart = (penalized.acoustic_tensor(&along) - plain).amax();
            assert!(apart < 1e-12 * plain.amax(), "{kind:?}: {apart}");
        }
    }
}

/// Sums of `V |W'| r` times the given power of the direction, over the neighbors of a square lattice.
fn square_sum(radius: f64, factor: impl Fn(&SVector<f64, 2>) -> f64) -> f64 {
    let reach = radius as i32;
    let mut sum = 0.0;
    for i in -reach..=reach {
        for j in -reach..=reach {
            let x = SVector::from([f64::from(i), f64::from(j)]);
            let r = x.norm();
            if r > 0.0 {
                sum -= slope::<2>(radius, r) * r * factor(&(x / r));
            }
        }
    }
    sum
}

#[test]
fn long_waves_of_shear_between_pairs_follow_from_springs_and_the_mean_stress() {
    // Expected: rho omega^2/k^2 = K s n n + zeta mu sum V |W'| r (e.n)^2 e e, s = sum V |W'| r / 2: the gradients of the forces are not corrected.
    let (radius, zeta) = (2.6, 3.5);
    let bulk = LAMBDA + MU / 1.5;
    let choices = choices(radius, 0.0, pairs::<2>());
    let sph = updated(crystal::<2>(LatticeKind::Square), choices);
    let system = sph.waves(&*solid(), &DeformationGradient::identity());
    let long = system.expect("a state").long_wave_stiffness();
    let pressure = bulk * square_sum(radius, |_| 0.5);
    let mut transverse = Vec::new();
    for angle in [0.0_f64, 0.25 * PI, 0.4] {
        let n = SVector::from([angle.cos(), angle.sin()]);
        let found = long.acoustic_tensor(&n) * RHO;
        for i in 0..2 {
            for j in 0..2 {
                let pairs = square_sum(radius, |e| e.dot(&n).powi(2) * e[i] * e[j]);
                let expected = pressure * n[i] * n[j] + zeta * MU * pairs;
                assert!((found[(i, j)] - expected).abs() < 1e-12, "{found}");
            }
        }
        let t = SVector::from([-n[1], n[0]]);
        transverse.push(t.dot(&(found * t)) / MU);
    }
    // Shear modulus of the lattice over mu, along an axis and a diagonal.
    assert!((transverse[0] - 0.7075).abs() < 1e-4, "{transverse:?}");
    assert!((transverse[1] - 0.9969).abs() < 1e-4, "{transverse:?}");
}

#[test]
fn both_formulations_have_no_zero_energy_modes_where_updated_sph_has_them() {
    let material = solid();
    let modes = |choices| {
        let sph = updated(crystal::<2>(LatticeKind::Square), choices);
        let survey = Survey::new(&sph, &*material).expect("a survey");
        let found = spurious_modes(&survey, WEAK_WAVE_RATIO).expect("modes");
        let zero = found.modes.iter().filter(|mode| mode.is_zero()).count();
        (zero, found.weakest.unwrap_or(f64::INFINITY))
    };
    let (plain, _) = modes(choices(2.6, 0.0, ShearForces::Stress));
    assert!(plain > 0);
    let mut weakest = Vec::new();
    for choices in [choices(2.6, 2.0, ShearForces::Stress)]
        .into_iter()
        .chain(both::<2>(2.6))
    {
        let (zero, weak) = modes(choices);
        assert_eq!(zero, 0);
        weakest.push(weak);
    }
    // Least frequency divided by the frequency of the material: coefficients 2 and 4 of the penalty, and pairs.
    for (found, expected) in weakest.into_iter().zip([0.2801, 0.3961, 0.5240]) {
        assert!((found - expected).abs() < 1e-4, "{found}, {expected}");
    }
}

/// Between nearest neighbors alone pairs do not resist a shear of a square lattice, and the mean stress does not either.
#[test]
fn shear_between_nearest_neighbors_leaves_the_shears_of_a_square_lattice_free() {
    let sph = updated(
        crystal::<2>(LatticeKind::Square),
        choices(1.3, 0.0, pairs::<2>()),
    );
    let system = sph.waves(&*solid(), &DeformationGradient::identity());
    let system = system.expect("a state");
    let k = SVector::from([0.0, 1.3]);
    assert!(system.omega_squared(&k)[0].norm() < 1e-14);
    let material = solid();
    let survey = Survey::new(&sph, &*material).expect("a survey");
    let found = spurious_modes(&survey, WEAK_WAVE_RATIO).expect("modes");
    assert_eq!(found.weakest, Some(0.0));
}

#[test]
fn accumulated_accelerations_follow_velocities_and_not_densities() {
    let material = solid();
    let f = DeformationGradient::from_stretches([1.05, 0.97, 1.0]).expect("a state");
    let k = SVector::from([1.1, 0.4]);
    let parts = |penalty| {
        let sph = updated(
            crystal::<2>(LatticeKind::Hexagonal),
            choices(2.3, penalty, ShearForces::Stress),
        );
        let carried = sph.carried(&*material, &f).expect("a state");
        let carried = carried.expect("carried quantities");
        let density = carried.density.expect("a part of the density");
        let whole = sph.waves(&*material, &f).expect("a state");
        [whole, carried.all, density].map(|system| system.dynamical_matrix_at(&k))
    };
    let (plain, penalized) = (parts(0.0), parts(4.0));
    let [whole, all, density] = [0, 1, 2].map(|n| &penalized[n] - &plain[n]);
    assert!(whole.norm() > 0.1);
    assert!((&whole - &all).norm() < 1e-13);
    assert!(density.norm() == 0.0);
}

fn refused<const D: usize>(kind: LatticeKind, choices: UpdatedSphChoices) -> MethodError {
    UpdatedSph::new(crystal::<D>(kind), choices).expect_err("excluded choices")
}

#[test]
fn choices_without_meaning_are_refused() {
    let both = choices(2.3, 1.0, pairs::<2>());
    let chain = choices(2.3, 0.0, pairs::<1>());
    for error in [
        refused::<2>(LatticeKind::Square, both),
        refused::<1>(LatticeKind::Chain, chain),
    ] {
        assert!(matches!(error, MethodError::Incompatible { .. }), "{error}");
    }
    let law = Law::named("murnaghan").expect("a law of the library");
    let fluid = law.build(&[("mu", 0.0)]).expect("a fluid");
    let metals = onset::plasticity::library();
    let metal = metals.iter().find(|law| law.name == "j2");
    let metal = metal.expect("a metal").build(&[]).expect("constants");
    let rest = DeformationGradient::identity();
    for choices in self::both::<2>(2.3) {
        let sph = updated(crystal::<2>(LatticeKind::Square), choices.clone());
        assert_eq!(
            sph.waves(&*fluid, &rest).err(),
            Some(MethodError::Material(MaterialError::NoShearModulus))
        );
        // The limiter of the penalty has no linear form, but pairs would not flow.
        assert_eq!(
            sph.waves(&*metal, &rest).is_ok(),
            choices.shear == ShearForces::Stress
        );
    }
}

/// Jaumann's rate in the plane: the mean stress of its pairs is the pressure, and its waves do not depend on the shear stress of the state.
#[test]
fn shear_between_pairs_takes_laws_in_rate_form() {
    let library = onset::plasticity::library();
    let law = library
        .iter()
        .find(|law| law.name == "hypoelastic-jaumann")
        .expect("a law");
    let law = law.build(&[]).expect("constants");
    let sph = updated(
        crystal::<2>(LatticeKind::Square),
        choices(2.6, 0.0, pairs::<2>()),
    );
    let shear = |amount: f64| {
        let f = Matrix3::new(1.0, amount, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
        let f = DeformationGradient::new(f.transpose().into()).expect("a state");
        sph.waves(&*law, &f).expect("a state")
    };
    assert_scheme(
        &sph,
        &*law,
        &DeformationGradient::from_stretches([1.02, 0.99, 1.0]).expect("a state"),
    );
    assert!(shear(0.2).is_finite());
}
