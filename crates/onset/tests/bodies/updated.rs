//! Bodies of updated SPH, compared with sums over all pairs, the forces of the method, free motion, and the waves of the method.

use super::random::Random;
use super::{assert_second_order, at_rest, block, energy_error, law, moving, twice, with};
use nalgebra::{DMatrix, SMatrix, SVector};
use onset::analysis::{Analysis, analysis};
use onset::kinematics::DeformationGradient;
use onset::lattice::{BravaisLattice, Crystal, LatticeKind};
use onset::material::Law;
use onset::method::KernelMethodChoices;
use onset::motion::{BodyMotion, BodyParticles, Grip, Ground, PatchState, PlacedParticle, Start};
use onset::scheme::sph::{DensityEvolution, MomentumForm, UpdatedSph, UpdatedSphChoices};
use onset::scheme::stabilization::{
    ArtificialStress, ArtificialViscosity, SmoothedMotion, ViscositySwitch,
};
use onset::scheme::{Discretization, MethodChoices, PeriodicPatch};
use std::f64::consts::PI;
use std::sync::Arc;

const DENSITY: f64 = 1.3;

fn choices(radius: f64) -> UpdatedSphChoices {
    UpdatedSphChoices {
        density: DENSITY,
        radius,
        ..UpdatedSphChoices::default()
    }
}

fn method(lattice: LatticeKind, choices: &UpdatedSphChoices) -> Box<dyn Analysis> {
    let particles = KernelMethodChoices {
        lattice,
        ..KernelMethodChoices::default()
    };
    let method = MethodChoices::UpdatedSph(Box::new(particles), choices.clone());
    analysis(&method, law()).expect("a method")
}

fn start(stretches: [f64; 3], noise: f64) -> Start {
    Start {
        f: DeformationGradient::from_stretches(stretches).expect("stretches"),
        noise,
        seed: 11,
    }
}

fn dynamic<const D: usize>(matrix: &SMatrix<f64, D, D>) -> DMatrix<f64> {
    DMatrix::from_fn(D, D, |a, b| matrix[(a, b)])
}

/// Equations of motion as sums over all particles, with the quartic spline and its integral written out.
pub(super) struct Sums<'a, const D: usize> {
    choices: &'a UpdatedSphChoices,
    pub(super) x: Vec<SVector<f64, D>>,
    pub(super) f: Vec<SMatrix<f64, D, D>>,
    pub(super) v: Vec<SVector<f64, D>>,
    masses: Vec<f64>,
}

impl<const D: usize> Sums<'_, D> {
    /// Values of `W` and `dW/dr`.
    fn weight(&self, distance: f64) -> [f64; 2] {
        let radius = self.choices.radius;
        let (q, size) = (distance / radius, radius.powi(D as i32));
        let factor = match D {
            1 => 1.25,
            2 => 5.0 / PI,
            _ => 105.0 / (16.0 * PI),
        };
        match q < 1.0 {
            true => [
                factor / size * (1.0 - q * q * (6.0 - q * (8.0 - 3.0 * q))),
                -12.0 * factor / size / radius * q * (1.0 - q) * (1.0 - q),
            ],
            false => [0.0, 0.0],
        }
    }

    /// Gradient `grad W_IJ` with respect to `x_I`.
    fn gradient(&self, i: usize, j: usize) -> SVector<f64, D> {
        let apart = self.x[i] - self.x[j];
        match apart.norm() {
            0.0 => SVector::zeros(),
            distance => apart * (self.weight(distance)[1] / distance),
        }
    }

    fn density(&self, i: usize) -> f64 {
        match self.choices.density_evolution {
            DensityEvolution::Continuity => {
                self.choices.density / dynamic(&self.f[i]).determinant()
            }
            DensityEvolution::Summation => (0..self.x.len())
                .map(|j| self.masses[j] * self.weight((self.x[i] - self.x[j]).norm())[0])
                .sum(),
        }
    }

    fn stress(&self, i: usize) -> SMatrix<f64, D, D> {
        let mut f = [[0.0; 3]; 3];
        for (n, row) in f.iter_mut().enumerate() {
            row[n] = 1.0;
        }
        for a in 0..D {
            for b in 0..D {
                f[a][b] = self.f[i][(a, b)];
            }
        }
        let state = DeformationGradient::new(f).expect("a deformation");
        let piola = law().response(&state).expect("a stress").first_piola;
        let piola = SMatrix::<f64, D, D>::from_fn(|a, b| piola[(a, b)]);
        piola * self.f[i].transpose() / dynamic(&self.f[i]).determinant()
    }

    /// Stress along corrected gradients, if forces are corrected, minus the artificial stress of a pair.
    fn lessened(&self, i: usize, j: usize) -> SMatrix<f64, D, D> {
        let stress = self.stress(i);
        let along = match self.choices.corrected_forces {
            true => stress * self.correction(i).transpose(),
            false => stress,
        };
        let Some(artificial) = &self.choices.artificial_stress else {
            return along;
        };
        let weights = [(self.x[i] - self.x[j]).norm(), artificial.spacing];
        let [own, at_spacing] = weights.map(|distance| self.weight(distance)[0]);
        let factor = artificial.epsilon * (own / at_spacing).powf(artificial.exponent);
        let eigen = dynamic(&stress).symmetric_eigen();
        let tensile = SMatrix::<f64, D, D>::from_fn(|a, b| {
            (0..D)
                .map(|n| {
                    let axis = eigen.eigenvectors.column(n);
                    eigen.eigenvalues[n].max(0.0) * axis[a] * axis[b]
                })
                .sum()
        });
        along - tensile * factor
    }

    fn viscous(&self, i: usize, j: usize) -> SVector<f64, D> {
        let Some(viscosity) = &self.choices.viscosity else {
            return SVector::zeros();
        };
        assert_eq!(viscosity.switch, ViscositySwitch::Always);
        let h = self
            .choices
            .kernel
            .nominal_smoothing_length(self.choices.radius);
        let stiffness = law()
            .response(&DeformationGradient::identity())
            .expect("a response")
            .tangent[(0, 0, 0, 0)];
        let speed = (stiffness / self.choices.density).sqrt();
        let (x, v) = (self.x[i] - self.x[j], self.v[i] - self.v[j]);
        let mu = h * v.dot(&x) / (x.norm_squared() + 0.01 * h * h);
        let pi = -mu * (viscosity.alpha * speed + viscosity.beta * mu.abs());
        let density = 0.5 * (self.density(i) + self.density(j));
        -self.gradient(i, j) * (self.masses[i] * self.masses[j] * pi / density)
    }

    pub(super) fn accelerations(&self) -> Vec<f64> {
        let of = |i: usize| {
            let mut force = SVector::<f64, D>::zeros();
            for j in (0..self.x.len()).filter(|j| *j != i) {
                let [own, other] = [self.density(i), self.density(j)];
                let stress = match self.choices.momentum {
                    MomentumForm::Symmetric => {
                        self.lessened(i, j) / (own * own) + self.lessened(j, i) / (other * other)
                    }
                    MomentumForm::Mean => {
                        (self.lessened(i, j) + self.lessened(j, i)) / (own * other)
                    }
                    MomentumForm::Difference => {
                        (self.lessened(j, i) - self.lessened(i, j)) / (own * other)
                    }
                };
                force += stress * self.gradient(i, j) * (self.masses[i] * self.masses[j]);
                force += self.viscous(i, j);
            }
            force / self.masses[i]
        };
        let all: Vec<SVector<f64, D>> = (0..self.x.len()).map(of).collect();
        all.iter().flat_map(|a| a.iter().copied()).collect()
    }

    /// Velocity gradient `sum_J V_J (w_J - w_I) (x) grad W_IJ K_I^-1`.
    pub(super) fn gradient_of(&self, i: usize, w: &[SVector<f64, D>]) -> SMatrix<f64, D, D> {
        let mut sum = SMatrix::zeros();
        for j in 0..self.x.len() {
            let along = self.gradient(i, j).transpose() * (self.masses[j] / self.density(j));
            sum += (w[j] - w[i]) * along;
        }
        match self.choices.corrected {
            true => sum * self.correction(i),
            false => sum,
        }
    }

    /// Correction matrix `K_I^-1`.
    fn correction(&self, i: usize) -> SMatrix<f64, D, D> {
        let mut moment = SMatrix::<f64, D, D>::zeros();
        for j in 0..self.x.len() {
            let along = self.gradient(i, j).transpose() * (self.masses[j] / self.density(j));
            moment += (self.x[j] - self.x[i]) * along;
        }
        let inverse = dynamic(&moment).try_inverse().expect("neighbors enough");
        SMatrix::<f64, D, D>::from_fn(|a, b| inverse[(a, b)])
    }

    /// State for a body, from positions in the reference configuration.
    fn state(&self, positions: &[[f64; 3]]) -> PatchState {
        let places = self.x.iter().zip(positions);
        PatchState {
            displacements: places
                .flat_map(|(x, reference)| (0..D).map(|i| x[i] - reference[i]).collect::<Vec<_>>())
                .collect(),
            velocities: self.v.iter().flat_map(|v| v.iter().copied()).collect(),
            deformations: self
                .f
                .iter()
                .flat_map(|f| f.transpose().iter().copied().collect::<Vec<_>>())
                .collect(),
            ..PatchState::default()
        }
    }
}

/// Disordered particles of different volumes with displacements, strains and velocities, so that all neighborhoods differ from the reference
/// configuration.
pub(super) fn disordered<const D: usize>(
    choices: &UpdatedSphChoices,
    count: usize,
) -> (BodyParticles, Sums<'_, D>) {
    let mut random = Random::new(21);
    let side = (count as f64).powf(1.0 / D as f64).round() as usize;
    let mut given = Vec::new();
    for n in 0..side.pow(D as u32) {
        let cell = |i: usize| (n / side.pow(i as u32) % side) as f64;
        given.push(PlacedParticle {
            position: std::array::from_fn(|i| if i < D { cell(i) } else { 0.0 }),
            volume: 1.0 + 0.2 * random.number(),
        });
    }
    let mut vector = |size: f64| SVector::<f64, D>::from_fn(|_, _| size * random.number());
    // The displacements are large enough to move particles into the support from outside.
    let places = given.iter().map(|own| {
        let x = SVector::<f64, D>::from_fn(|i, _| own.position[i]);
        x * 0.9 + vector(0.45)
    });
    let x: Vec<_> = places.collect();
    let sums = Sums {
        choices,
        v: x.iter().map(|_| vector(0.3)).collect(),
        f: x.iter()
            .map(|_| {
                let mut f = SMatrix::<f64, D, D>::identity();
                for a in 0..D {
                    f.set_column(a, &(f.column(a) + vector(0.15)));
                }
                f
            })
            .collect(),
        masses: given.iter().map(|own| DENSITY * own.volume).collect(),
        x,
    };
    (BodyParticles::Given(given), sums)
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    let size = b.iter().fold(0.0_f64, |most, b| most.max(b.abs()));
    assert!(size > 1e-3, "{size}");
    let both = a.iter().zip(b);
    both.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs())) / size
}

/// All combinations of choices.
pub(super) fn all_choices(radius: f64) -> Vec<UpdatedSphChoices> {
    let plain = choices(radius);
    let mut all = Vec::new();
    for momentum in [
        MomentumForm::Symmetric,
        MomentumForm::Mean,
        MomentumForm::Difference,
    ] {
        for density_evolution in [DensityEvolution::Continuity, DensityEvolution::Summation] {
            all.push(UpdatedSphChoices {
                momentum,
                density_evolution,
                ..plain.clone()
            });
        }
    }
    all.push(UpdatedSphChoices {
        corrected: true,
        ..plain.clone()
    });
    all.push(UpdatedSphChoices {
        corrected: true,
        density_evolution: DensityEvolution::Summation,
        ..plain.clone()
    });
    for momentum in [MomentumForm::Symmetric, MomentumForm::Mean] {
        for density_evolution in [DensityEvolution::Continuity, DensityEvolution::Summation] {
            all.push(UpdatedSphChoices {
                corrected: true,
                corrected_forces: true,
                momentum,
                density_evolution,
                ..plain.clone()
            });
        }
    }
    all.push(UpdatedSphChoices {
        corrected: true,
        corrected_forces: true,
        artificial_stress: Some(ArtificialStress::default()),
        ..plain.clone()
    });
    all.push(UpdatedSphChoices {
        artificial_stress: Some(ArtificialStress::default()),
        momentum: MomentumForm::Mean,
        ..plain.clone()
    });
    all.push(UpdatedSphChoices {
        viscosity: Some(ArtificialViscosity {
            alpha: 0.7,
            beta: 1.5,
            switch: ViscositySwitch::Always,
        }),
        artificial_stress: Some(ArtificialStress::default()),
        ..plain
    });
    all
}

fn assert_sums<const D: usize>(lattice: LatticeKind, count: usize, radius: f64) {
    for choices in all_choices(radius) {
        let (particles, sums) = disordered::<D>(&choices, count);
        let method = method(lattice, &choices);
        with(&*method, &particles, &[], |body| {
            let state = sums.state(&body.positions());
            body.put(&state, &DeformationGradient::identity());
            let own = body.accelerations().expect("forces");
            let far = apart(&own, &sums.accelerations());
            assert!(far < 1e-12, "{D} dimensions, {choices:?}: {far:e}");
            // The step is short enough to give a derivative.
            let step = 1e-7;
            let velocities: Vec<f64> = state
                .velocities
                .iter()
                .zip(&own)
                .map(|(v, a)| v + step * a)
                .collect();
            body.advance(step).expect("a step");
            let next = body.state();
            assert!(apart(&next.velocities, &velocities) < 1e-14);
            let rates: Vec<f64> = (0..sums.x.len())
                .flat_map(|i| {
                    let rate = sums.gradient_of(i, &sums.v) * sums.f[i];
                    rate.transpose().iter().copied().collect::<Vec<_>>()
                })
                .collect();
            let both = next.deformations.iter().zip(&state.deformations);
            let own: Vec<f64> = both.map(|(a, b)| (a - b) / step).collect();
            let far = apart(&own, &rates);
            assert!(far < 1e-5, "{D} dimensions, {choices:?}: {far:e}");
        })
        .expect("a body");
    }
}

#[test]
fn forces_and_rates_equal_sums_over_all_pairs_at_any_positions() {
    assert_sums::<1>(LatticeKind::Chain, 30, 2.6);
    assert_sums::<2>(LatticeKind::Square, 49, 2.4);
    assert_sums::<3>(LatticeKind::SimpleCubic, 64, 2.1);
}

/// Compares a single body in a large cell of a lattice, near a homogeneous state, with the forces of the method.
fn assert_general<const D: usize>(lattice: LatticeKind, size: &[f64], radius: f64) {
    let mut f = DeformationGradient::from_stretches([1.04, 0.98, 1.0]).expect("stretches");
    if D > 1 {
        let mut components = *f.components();
        components[0][1] = 0.03;
        f = DeformationGradient::new(components).expect("a deformation");
    }
    let map = SMatrix::<f64, D, D>::from_fn(|i, j| f.components()[i][j]);
    for choices in all_choices(radius) {
        let method = method(lattice, &choices);
        with(&*method, &block(size), &[], |body| {
            let positions = body.positions();
            let room = 1000.0;
            let cell = BravaisLattice::new(SMatrix::<f64, D, D>::identity() * room);
            let sites = positions
                .iter()
                .map(|x| SVector::<f64, D>::from_fn(|i, _| x[i] / room));
            let count = positions.len();
            let crystal =
                Crystal::with_volumes(cell.expect("a lattice"), sites.collect(), vec![1.0; count])
                    .expect("a crystal");
            let scheme = UpdatedSph::new(crystal, choices.clone()).expect("a scheme");
            let patch = PeriodicPatch::new(scheme.crystal(), [1; D]);
            let mut random = Random::new(5);
            // The forces of a patch keep the densities in the viscosity fixed. Viscosity is therefore tested with velocities in the homogeneous state itself.
            let shifted = if choices.viscosity.is_some() {
                0.0
            } else {
                0.02
            };
            let mut vector = |size: f64| SVector::<f64, D>::from_fn(|_, _| size * random.number());
            let u: Vec<_> = (0..count).map(|_| vector(shifted)).collect();
            let v: Vec<_> = (0..count).map(|_| vector(0.2)).collect();
            let mut forces = Vec::new();
            scheme
                .with_forces(&*law(), &f, &patch, &mut |own| {
                    forces = own.at(&u, &v).expect("forces");
                })
                .expect("forces");
            // Deformation of the particles at the displacements, by the gradients of the homogeneous state.
            let mut sums = Sums {
                choices: &choices,
                x: positions
                    .iter()
                    .map(|x| map * SVector::<f64, D>::from_fn(|i, _| x[i]))
                    .collect(),
                f: vec![map; count],
                v,
                masses: vec![DENSITY; count],
            };
            let carried = |i| (SMatrix::identity() + sums.gradient_of(i, &u)) * map;
            sums.f = (0..count).map(carried).collect();
            for (x, u) in sums.x.iter_mut().zip(&u) {
                *x += u;
            }
            body.put(&sums.state(&positions), &f);
            let own: Vec<f64> = body.accelerations().expect("forces");
            let general: Vec<f64> = forces
                .iter()
                .flat_map(|force| force.iter().map(|own| own / DENSITY).collect::<Vec<_>>())
                .collect();
            let far = apart(&own, &general);
            assert!(far < 1e-12, "{D} dimensions, {choices:?}: {far:e}");
        })
        .expect("a body");
    }
}

#[test]
fn forces_near_a_homogeneous_state_equal_the_forces_of_the_method() {
    // No neighbor enters or leaves the support.
    assert_general::<1>(LatticeKind::Chain, &[20.0], 2.5);
    assert_general::<2>(LatticeKind::Square, &[7.0, 5.0], 1.75);
    assert_general::<3>(LatticeKind::SimpleCubic, &[4.0, 4.0, 3.0], 1.6);
}

#[test]
fn forces_rotate_with_the_body() {
    let choices = UpdatedSphChoices {
        artificial_stress: Some(ArtificialStress::default()),
        ..choices(2.4)
    };
    let (particles, sums) = disordered::<2>(&choices, 49);
    let method = method(LatticeKind::Square, &choices);
    let (sine, cosine) = 0.7_f64.sin_cos();
    let turn = SMatrix::<f64, 2, 2>::new(cosine, -sine, sine, cosine);
    let turned = Sums {
        choices: &choices,
        x: sums.x.iter().map(|x| turn * x).collect(),
        f: sums.f.iter().map(|f| turn * f).collect(),
        v: sums.v.iter().map(|v| turn * v).collect(),
        masses: sums.masses.clone(),
    };
    with(&*method, &particles, &[], |body| {
        let of = |sums: &Sums<'_, 2>, body: &mut dyn BodyMotion| {
            body.put(
                &sums.state(&body.positions()),
                &DeformationGradient::identity(),
            );
            let all = body.accelerations().expect("forces");
            all.chunks_exact(2)
                .map(SVector::<f64, 2>::from_column_slice)
                .collect::<Vec<_>>()
        };
        let before = of(&sums, body);
        let after = of(&turned, body);
        let flat = |all: &[SVector<f64, 2>]| -> Vec<f64> {
            all.iter().flat_map(|a| a.iter().copied()).collect()
        };
        let expected: Vec<_> = before.iter().map(|a| turn * a).collect();
        assert!(apart(&flat(&after), &flat(&expected)) < 1e-12);
    })
    .expect("a body");
}

#[test]
fn free_particles_keep_the_gradient_of_their_motion_through_changes_of_neighbors() {
    // The law is so soft that the particles move freely: x = (1 + A t) X.
    let soft = Law::named("neo-hooke").expect("a law");
    let soft = soft
        .build(&[("mu", 1e-20), ("lambda", 1e-20)])
        .expect("a material");
    let particles = KernelMethodChoices {
        lattice: LatticeKind::Square,
        ..KernelMethodChoices::default()
    };
    let corrected = UpdatedSphChoices {
        corrected: true,
        ..choices(3.2)
    };
    let method = MethodChoices::UpdatedSph(Box::new(particles), corrected);
    let method = analysis(&method, Arc::from(soft)).expect("a method");
    let a = SMatrix::<f64, 2, 2>::new(0.5, 0.35, -0.3, -0.1);
    with(&*method, &block(&[12.0, 9.0]), &[], |body| {
        let positions = body.positions();
        let mut state = at_rest(vec![0.0; 2 * positions.len()]);
        state.velocities = positions
            .iter()
            .flat_map(|x| {
                let v = a * SVector::<f64, 2>::new(x[0], x[1]);
                [v[0], v[1]]
            })
            .collect();
        body.put(&state, &DeformationGradient::identity());
        for _ in 0..40 {
            body.advance(0.025).expect("a step");
        }
        let expected = SMatrix::<f64, 2, 2>::identity() + a;
        for own in body.deformations() {
            for i in 0..2 {
                for j in 0..2 {
                    let missed = own[i][j] - expected[(i, j)];
                    assert!(missed.abs() < 1e-12, "{own:?}");
                }
            }
        }
    })
    .expect("a body");
}

/// Predicted and measured `omega^2` of a wave in the middle of a large body, from three leapfrog amplitudes,
/// `a(t + dt) + a(t - dt) = (2 - omega^2 dt^2) a(t)`, before the surface has an effect.
fn growth(
    lattice: LatticeKind,
    size: &[f64],
    choices: &UpdatedSphChoices,
    stretch: f64,
) -> [f64; 2] {
    let method = method(lattice, choices);
    let start = start([stretch, 1.0, 1.0], 0.0);
    let mut k = vec![0.0; size.len()];
    k[0] = PI;
    let waves = method.waves(&start.f).expect("waves");
    let omega_squared = waves.omega_squared(&k);
    let predicted = omega_squared
        .iter()
        .map(|own| own.re)
        .fold(f64::INFINITY, f64::min);
    let measured = with(&*method, &block(size), &[], |body| {
        let step = 0.2;
        body.start(&start, step).expect("forces");
        let positions = body.positions();
        let dimension = size.len();
        let sign = |x: &[f64; 3]| if (x[0] as i64) % 2 == 0 { 1.0 } else { -1.0 };
        let mut state = body.state();
        let rest = state.displacements.clone();
        for (n, x) in positions.iter().enumerate() {
            state.velocities[dimension * n] += 1e-6 * sign(x);
        }
        body.put(&state, &start.f);
        let mut amplitudes = vec![0.0];
        for _ in 0..8 {
            body.advance(step).expect("a step");
            let now = body.state().displacements;
            let mut sum = [0.0, 0.0];
            for (n, x) in positions.iter().enumerate() {
                let is_inside = (0..dimension).all(|i| (x[i] - 0.5 * size[i]).abs() < 1.1);
                if is_inside {
                    sum[0] += sign(x) * (now[dimension * n] - rest[dimension * n]);
                    sum[1] += 1.0;
                }
            }
            amplitudes.push(sum[0] / sum[1]);
        }
        let last = amplitudes.len() - 1;
        let [before, own, after] = [2, 1, 0].map(|back| amplitudes[last - back]);
        assert!(after.abs() < 1e-4);
        (2.0 - (before + after) / own) / (step * step)
    })
    .expect("a body");
    [measured, predicted]
}

#[test]
fn tensile_instability_in_a_body_grows_at_the_predicted_rate() {
    let mut grown = 0;
    for choices in [
        choices(2.2),
        UpdatedSphChoices {
            density_evolution: DensityEvolution::Summation,
            ..choices(2.2)
        },
        UpdatedSphChoices {
            artificial_stress: Some(ArtificialStress::default()),
            ..choices(2.2)
        },
        UpdatedSphChoices {
            corrected: true,
            velocity_smoothing: 0.4,
            ..choices(2.2)
        },
        UpdatedSphChoices {
            velocity_smoothing: 0.4,
            smoothed_motion: SmoothedMotion::Positions,
            ..choices(2.2)
        },
    ] {
        for (lattice, size) in [
            (LatticeKind::Chain, &[80.0][..]),
            (LatticeKind::Square, &[70.0, 70.0][..]),
        ] {
            let [measured, predicted] = growth(lattice, size, &choices, 1.08);
            let missed = (measured - predicted).abs();
            assert!(
                missed < 2e-6,
                "{lattice:?}, {choices:?}: {measured} {predicted}"
            );
            grown += usize::from(predicted < -0.01);
        }
    }
    assert!(grown > 3, "{grown}");
}

/// Two blocks that approach each other and interact only through their kernels.
fn meeting() -> [Grip; 2] {
    [(0.0, 6.9, 0.15), (7.1, 15.0, -0.15)].map(|(low, high, speed)| Grip {
        low: vec![low, -1.0],
        high: vec![high, 9.0],
        velocity: vec![speed, 0.02],
        until: 0.0,
        ..Grip::default()
    })
}

#[test]
fn bodies_in_collision_interact_and_conserve_momentum() {
    for momentum in [MomentumForm::Symmetric, MomentumForm::Mean] {
        let choices = UpdatedSphChoices {
            momentum,
            viscosity: Some(ArtificialViscosity::default()),
            ..choices(2.2)
        };
        let method = method(LatticeKind::Square, &choices);
        with(&*method, &twice(&[6.0, 5.0], 9.0), &meeting(), |body| {
            let start = start([1.0; 3], 0.0);
            body.start(&start, 0.0).expect("forces");
            let step = 0.4 * body.critical_time_step().expect("a step");
            body.start(&start, step).expect("forces");
            let history = moving(body, step, (30.0 / step) as usize);
            let (first, last) = (history[0], history[history.len() - 1]);
            // Initial kinetic energy of the two blocks, which have reversed their motion at the end.
            let kinetic = 0.5 * DENSITY * 60.0 * (0.15 * 0.15 + 0.02 * 0.02);
            assert!((first.kinetic - kinetic).abs() < 1e-12);
            assert_eq!(first.work, 0.0);
            assert!(last.kinetic < 0.9 * first.kinetic);
            let v = body.state().velocities;
            let side = |of: &dyn Fn(f64) -> bool| {
                let all = body.positions();
                let own = all.iter().zip(v.chunks_exact(2)).filter(|(x, _)| of(x[0]));
                own.map(|(_, v)| v[0]).sum::<f64>()
            };
            assert!(side(&|x| x < 7.0) < 0.0 && side(&|x| x > 7.0) > 0.0);
            for i in 0..2 {
                let size = DENSITY * 60.0 * 0.15;
                assert!((last.momentum[i] - first.momentum[i]).abs() < 1e-12 * size);
            }
        })
        .expect("a body");
    }
}

#[test]
fn the_mean_form_with_continuity_conserves_energy() {
    let choices = UpdatedSphChoices {
        momentum: MomentumForm::Mean,
        ..choices(2.2)
    };
    let method = method(LatticeKind::Square, &choices);
    let swing = |share: f64| {
        with(&*method, &twice(&[6.0, 5.0], 9.0), &meeting(), |body| {
            let step = share;
            body.start(&start([0.97, 0.98, 1.0], 0.0), step)
                .expect("forces");
            let history = moving(body, step, (24.0 / step) as usize);
            energy_error(&history)
        })
        .expect("a body")
    };
    assert_second_order(swing(0.1), swing(0.05));
}

#[test]
fn the_work_of_grips_equals_the_energy_gain_of_a_conservative_body() {
    let choices = UpdatedSphChoices {
        momentum: MomentumForm::Mean,
        ..choices(2.2)
    };
    let method = method(LatticeKind::Square, &choices);
    let grip = |low: f64, high: f64, speed: f64| Grip {
        low: vec![low, 0.0],
        high: vec![high, 6.0],
        velocity: vec![speed, 0.0],
        ramp: 3.0,
        until: 5.0,
    };
    let grips = [grip(0.0, 1.0, 0.0), grip(9.0, 10.0, -0.1)];
    let missed = |step: f64| {
        with(&*method, &block(&[10.0, 6.0]), &grips, |body| {
            body.start(&start([1.0; 3], 0.0), step).expect("forces");
            let history = moving(body, step, (8.0 / step) as usize);
            let last = history[history.len() - 1];
            assert!(last.work > 0.01 && last.strain > 0.001, "{last:?}");
            // The grips do no work after their release.
            let after = history[(5.5 / step) as usize];
            assert!((after.work - last.work).abs() < 1e-14);
            (last.kinetic + last.strain - last.work).abs() / last.work
        })
        .expect("a body")
    };
    let (coarse, fine) = (missed(0.1), missed(0.05));
    assert!(coarse < 0.02 && fine < 0.6 * coarse, "{coarse} {fine}");
}

#[test]
fn a_resumed_run_is_bitwise_identical_for_any_time_of_the_neighbor_search() {
    let choices = UpdatedSphChoices {
        viscosity: Some(ArtificialViscosity::default()),
        artificial_stress: Some(ArtificialStress::default()),
        velocity_smoothing: 0.3,
        ..choices(2.2)
    };
    let method = method(LatticeKind::Square, &choices);
    let start = start([1.0; 3], 1e-2);
    let ends = |stop: usize| {
        with(&*method, &twice(&[6.0, 5.0], 9.0), &meeting(), |body| {
            let step = 0.1;
            body.start(&start, step).expect("forces");
            for n in 0..150 {
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
    let whole = ends(150);
    for stop in [1, 60, 97] {
        assert_eq!(ends(stop), whole);
    }
}

#[cfg(feature = "rayon")]
#[test]
fn runs_on_any_number_of_cores_are_bitwise_identical() {
    for corrected in [false, true] {
        super::assert_same_on_any_cores(|| {
            let choices = UpdatedSphChoices {
                corrected,
                viscosity: Some(ArtificialViscosity::default()),
                artificial_stress: Some(ArtificialStress::default()),
                velocity_smoothing: 0.3,
                ..choices(2.2)
            };
            let method = method(LatticeKind::Square, &choices);
            with(&*method, &twice(&[6.0, 65.0], 9.0), &[], |body| {
                body.start(&start([1.02, 1.0, 1.0], 1e-2), 0.1)
                    .expect("forces");
                (0..40).for_each(|_| body.advance(0.1).expect("a step"));
                body.state()
            })
            .expect("a body")
        });
    }
}

#[test]
fn motion_is_bounded_at_the_critical_step_and_unbounded_at_a_longer_step() {
    for viscosity in [0.0, 1.5] {
        let choices = UpdatedSphChoices {
            viscosity: Some(ArtificialViscosity {
                alpha: viscosity,
                beta: 0.0,
                switch: ViscositySwitch::Always,
            }),
            ..choices(2.2)
        };
        let method = method(LatticeKind::Square, &choices);
        let largest = |share: f64| {
            with(&*method, &block(&[9.0, 8.0]), &[], |body| {
                let start = start([1.0; 3], 1e-9);
                body.start(&start, 0.0).expect("forces");
                let step = share * body.critical_time_step().expect("a step");
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
        assert!(largest(1.0) < 1e-5, "{viscosity}: {}", largest(1.0));
        assert!(largest(1.4) > 1e-3, "{viscosity}: {}", largest(1.4));
    }
}

#[test]
fn faults_are_reported_with_particle_and_state() {
    let corrected = UpdatedSphChoices {
        corrected: true,
        ..choices(2.2)
    };
    let fault = |choices: &UpdatedSphChoices, change: &dyn Fn(&mut PatchState)| {
        let method = method(LatticeKind::Square, choices);
        with(&*method, &block(&[8.0, 8.0]), &[], |body| {
            let identity = DeformationGradient::identity();
            body.put(&at_rest(vec![0.0; 128]), &identity);
            let mut state = body.state();
            change(&mut state);
            body.put(&state, &identity);
            body.advance(1e-3).expect_err("a fault")
        })
        .expect("a body")
    };
    let inverted = fault(&choices(2.2), &|state| state.deformations[4 * 17] = -0.5);
    assert_eq!((inverted.ground, inverted.particle), (Ground::Inverted, 17));
    assert_eq!(inverted.deformation, [-0.5, 0.0, 0.0, 1.0]);
    let lost = fault(&choices(2.2), &|state| state.displacements[31] = f64::NAN);
    assert_eq!((lost.ground, lost.particle), (Ground::NotFinite, 15));
    // A particle far from all others has no velocity gradient to correct.
    let alone = fault(&corrected, &|state| state.displacements[40] = 100.0);
    assert!(matches!(alone.ground, Ground::Method(_)), "{alone}");
    assert_eq!(alone.particle, 20);
    let method = method(LatticeKind::Square, &choices(2.2));
    let free = with(&*method, &block(&[8.0, 8.0]), &[], |body| {
        let mut state = at_rest(vec![0.0; 128]);
        state.displacements[40] = 100.0;
        state.velocities[40] = 3.0;
        body.put(&state, &DeformationGradient::identity());
        body.advance(1e-3).expect("a step");
        body.state().displacements[40]
    })
    .expect("a body");
    assert!((free - 100.003).abs() < 1e-12);
}
