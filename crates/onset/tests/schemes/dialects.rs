//! Formulas as used in codes, compared with the same formulas applied to the particles of a patch.

use crate::battery::assert_scheme;
use crate::random::Random;
use crate::sph::{crystal, stretched, updated, waves};
use crate::states::saint_venant_kirchhoff;
use nalgebra::{Matrix2, SMatrix, SVector, Vector2, Vector3};
use onset::bloch::ZoneSearch;
use onset::continuum::Stiffness;
use onset::kernel::Kernel;
use onset::kinematics::DeformationGradient;
use onset::lattice::{BravaisLattice, LatticeKind};
use onset::material::{Hyperelastic, ModifiedMooneyRivlin};
use onset::method::MethodError;
use onset::scheme::Discretization;
use onset::scheme::element::{
    ElementChoices, ElementMass, ElementMesh, FiniteElements, Formulation, HourglassScale,
    Integration, Mesh,
};
use onset::scheme::sph::{
    DensityEvolution, MomentumForm, TotalLagrangianChoices, TotalLagrangianSph, UpdatedSphChoices,
};
use onset::scheme::stabilization::{
    ArtificialViscosity, PenaltyForm, SmoothedMotion, ViscositySwitch,
};
use std::f64::consts::PI;

const DENSITY: f64 = 1.3;
const RADIUS: f64 = 2.6;

/// Normalized quartic spline in the plane, with its derivative.
fn kernel(distance: f64) -> [f64; 2] {
    let q = distance / RADIUS;
    if q >= 1.0 {
        return [0.0; 2];
    }
    let factor = 5.0 / (PI * RADIUS * RADIUS);
    let value = 1.0 - 6.0 * q * q + 8.0 * q.powi(3) - 3.0 * q.powi(4);
    let slope = -12.0 * q + 24.0 * q * q - 12.0 * q.powi(3);
    [factor * value, factor * slope / RADIUS]
}

/// Periodic square of particles in a homogeneous state, with the variables that a code in rate form stores for each.
struct Patch {
    side: usize,
    f: Matrix2<f64>,
    material: ModifiedMooneyRivlin,
}

/// Positions, and the deformation gradients that particles carry.
#[derive(Clone)]
struct State {
    x: Vec<Vector2<f64>>,
    f: Vec<Matrix2<f64>>,
}

impl Patch {
    fn new(f: Matrix2<f64>) -> Self {
        Self {
            side: 8,
            f,
            material: ModifiedMooneyRivlin::default(),
        }
    }

    fn references(&self) -> Vec<Vector2<f64>> {
        let place = |n: usize| Vector2::new((n % self.side) as f64, (n / self.side) as f64);
        (0..self.side * self.side).map(place).collect()
    }

    fn rest(&self) -> State {
        let references = self.references();
        State {
            x: references.iter().map(|x| self.f * x).collect(),
            f: vec![self.f; references.len()],
        }
    }

    /// Vector to the nearest image of another particle.
    fn apart(&self, x: &[Vector2<f64>], i: usize, j: usize) -> Vector2<f64> {
        let side = self.side as f64;
        let inverse = self.f.try_inverse().expect("a deformation");
        let plain = x[j] - x[i];
        plain - self.f * (inverse * plain / side).map(f64::round) * side
    }

    fn pairs(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let count = self.side * self.side;
        (0..count).flat_map(move |i| (0..count).filter(move |j| *j != i).map(move |j| (i, j)))
    }

    fn density(f: &Matrix2<f64>) -> f64 {
        DENSITY / f.determinant()
    }

    /// Smoothed velocities `v_I + epsilon sum_J m_J / rho_IJ (v_J - v_I) W_IJ`.
    fn smoothed(&self, state: &State, v: &[Vector2<f64>], epsilon: f64) -> Vec<Vector2<f64>> {
        let mut smoothed = v.to_vec();
        for (i, j) in self.pairs() {
            let [weight, _] = kernel(self.apart(&state.x, i, j).norm());
            let density = 0.5 * (Self::density(&state.f[i]) + Self::density(&state.f[j]));
            smoothed[i] += (v[j] - v[i]) * (epsilon * DENSITY / density * weight);
        }
        smoothed
    }

    /// Strain rates `L_I F_I` with the uncorrected velocity gradient.
    fn strain_rates(&self, state: &State, v: &[Vector2<f64>]) -> Vec<Matrix2<f64>> {
        let mut gradients = vec![Matrix2::zeros(); v.len()];
        for (i, j) in self.pairs() {
            let x = self.apart(&state.x, i, j);
            let [_, slope] = kernel(x.norm());
            let gradient = -x * (slope / x.norm());
            gradients[i] +=
                (v[j] - v[i]) * gradient.transpose() * (DENSITY / Self::density(&state.f[j]));
        }
        let both = gradients.iter().zip(&state.f);
        both.map(|(l, f)| l * f).collect()
    }

    /// Accelerations in the symmetric form.
    fn accelerations(&self, state: &State) -> Vec<Vector2<f64>> {
        let over_square: Vec<Matrix2<f64>> = state
            .f
            .iter()
            .map(|f| {
                let entries = [[f[(0, 0)], f[(0, 1)]], [f[(1, 0)], f[(1, 1)]]];
                let whole = DeformationGradient::plane_strain(entries, 1.0).expect("a state");
                let stress = self.material.response(&whole).expect("a stress").cauchy();
                Matrix2::from_fn(|i, j| stress[(i, j)]) / Self::density(f).powi(2)
            })
            .collect();
        let mut accelerations = vec![Vector2::zeros(); state.x.len()];
        for (i, j) in self.pairs() {
            let x = self.apart(&state.x, i, j);
            let [_, slope] = kernel(x.norm());
            let gradient = -x * (slope / x.norm());
            accelerations[i] += (over_square[i] + over_square[j]) * gradient * DENSITY;
        }
        accelerations
    }

    /// Product `omega^2 v` for the particle at the origin, for the velocities `v cos(k.X)`: the negative change of its acceleration while particles
    /// move for a short time. Positions and deformations follow the smoothed or the unsmoothed velocities.
    fn squared_frequency(
        &self,
        k: &Vector2<f64>,
        v: &Vector2<f64>,
        epsilon: f64,
        motion: SmoothedMotion,
    ) -> Vector2<f64> {
        let references = self.references();
        let velocities: Vec<_> = references.iter().map(|x| v * k.dot(x).cos()).collect();
        let rest = self.rest();
        let smoothed = self.smoothed(&rest, &velocities, epsilon);
        let straining = match motion {
            SmoothedMotion::Everything => &smoothed,
            SmoothedMotion::Positions => &velocities,
        };
        let rates = self.strain_rates(&rest, straining);
        let after = |time: f64| {
            let mut state = rest.clone();
            for n in 0..references.len() {
                state.x[n] += smoothed[n] * time;
                state.f[n] += rates[n] * time;
            }
            self.accelerations(&state)[0]
        };
        let time = 1e-5;
        (after(-time) - after(time)) / (2.0 * time)
    }
}

fn smoothing(epsilon: f64, smoothed_motion: SmoothedMotion) -> UpdatedSphChoices {
    UpdatedSphChoices {
        density: DENSITY,
        radius: RADIUS,
        velocity_smoothing: epsilon,
        smoothed_motion,
        ..UpdatedSphChoices::default()
    }
}

#[test]
fn smoothed_velocities_change_waves_as_they_change_a_patch() {
    let sheared = Matrix2::new(1.06, 0.05, -0.03, 0.97);
    let patch = Patch::new(sheared);
    let f = DeformationGradient::plane_strain([[1.06, 0.05], [-0.03, 0.97]], 1.0).expect("a state");
    for motion in [SmoothedMotion::Everything, SmoothedMotion::Positions] {
        let square = updated(crystal::<2>(LatticeKind::Square), smoothing(0.5, motion));
        let system = waves(&square, &f);
        for (m, n) in [(4, 0), (4, 4), (3, 1), (1, 2)] {
            let k = Vector2::new(f64::from(m), f64::from(n)) * (2.0 * PI / 8.0);
            let matrix = system.dynamical_matrix_at(&k);
            for v in [Vector2::x(), Vector2::y()] {
                let expected = patch.squared_frequency(&k, &v, 0.5, motion);
                let found =
                    Vector2::from_fn(|i, _| (0..2).map(|j| matrix[(i, j)].re * v[j]).sum::<f64>());
                assert!(
                    (found - expected).amax() < 1e-6 * (1.0 + expected.amax()),
                    "{motion:?}, {k}: {found} by the program, {expected} by the patch"
                );
            }
        }
    }
}

#[test]
fn smoothing_only_positions_changes_no_wave_and_no_time_step_in_the_reference_state() {
    let rest = DeformationGradient::identity();
    let search = ZoneSearch::<2>::of_lattice(
        LatticeKind::Square.lattice(1.0).expect("a lattice"),
        Stiffness::<2>::at(&ModifiedMooneyRivlin::default(), &rest)
            .expect("a tangent")
            .maximum_eigenvalue()
            / DENSITY,
    );
    let largest = |choices: UpdatedSphChoices, f: &DeformationGradient| {
        let system = waves(&updated(crystal::<2>(LatticeKind::Square), choices), f);
        search.summary_of(&system).maximum_omega
    };
    for density_evolution in [DensityEvolution::Continuity, DensityEvolution::Summation] {
        let at = |epsilon, motion, f: &DeformationGradient| {
            let choices = UpdatedSphChoices {
                density_evolution,
                ..smoothing(epsilon, motion)
            };
            largest(choices, f)
        };
        let plain = at(0.0, SmoothedMotion::Positions, &rest);
        let positions = at(0.5, SmoothedMotion::Positions, &rest);
        let everything = at(0.5, SmoothedMotion::Everything, &rest);
        assert!(
            (positions - plain).abs() < 1e-9 * plain,
            "{positions} {plain}"
        );
        assert!(everything < 0.95 * plain, "{everything} {plain}");
        // Under stress the kernels move with the positions.
        let tense = stretched([1.05, 1.05, 1.0]);
        let difference =
            at(0.5, SmoothedMotion::Positions, &tense) - at(0.0, SmoothedMotion::Positions, &tense);
        assert!(difference.abs() > 1e-6 * plain, "{difference}");
    }
}

#[test]
fn methods_with_smoothed_positions_pass_the_scheme_checks() {
    let material = ModifiedMooneyRivlin::default();
    for momentum in [MomentumForm::Symmetric, MomentumForm::Mean] {
        for density_evolution in [DensityEvolution::Continuity, DensityEvolution::Summation] {
            let choices = UpdatedSphChoices {
                radius: 1.6,
                momentum,
                density_evolution,
                ..smoothing(0.4, SmoothedMotion::Positions)
            };
            let chain = updated(crystal::<1>(LatticeKind::Chain), choices.clone());
            assert_scheme(&chain, &material, &stretched([1.1, 1.0, 1.0]));
            if momentum == MomentumForm::Symmetric {
                let square = updated(crystal::<2>(LatticeKind::Square), choices);
                assert_scheme(&square, &material, &stretched([1.1, 0.95, 1.0]));
            }
        }
    }
}

/// Viscous force of LAMMPS' SMD on the particle at the origin, for the velocities `v cos(k.X)`. The total-Lagrangian code uses kernels of reference
/// distances, the updated code kernels of current distances.
fn force_of_smd(
    f: &Matrix2<f64>,
    k: &Vector2<f64>,
    v: &Vector2<f64>,
    is_total: bool,
) -> Vector2<f64> {
    let speed = speed_of_sound(&ModifiedMooneyRivlin::default());
    let density = if is_total {
        DENSITY
    } else {
        DENSITY / f.determinant()
    };
    let (h, alpha) = (RADIUS, 0.7);
    let mut force = Vector2::zeros();
    for a in -3..=3_i32 {
        for b in -3..=3_i32 {
            if (a, b) == (0, 0) {
                continue;
            }
            let reference = Vector2::new(f64::from(a), f64::from(b));
            let dx = f * reference;
            let dv = v * (k.dot(&reference).cos() - 1.0);
            let r = dx.norm();
            let [_, slope] = kernel(if is_total { reference.norm() } else { r });
            let along = if is_total {
                dx / (r + 0.01 * h)
            } else {
                dx / r
            };
            let mu = h * dx.dot(&dv) / (r + 0.1 * h) / (r + 0.1 * h);
            force += along * (DENSITY * DENSITY * -alpha * speed * mu / density * slope);
        }
    }
    force
}

fn speed_of_sound(material: &dyn Hyperelastic) -> f64 {
    let modulus = Stiffness::<2>::at(material, &DeformationGradient::identity())
        .expect("a tangent")
        .maximum_eigenvalue();
    (modulus / DENSITY).sqrt()
}

fn viscosity(switch: ViscositySwitch) -> Option<ArtificialViscosity> {
    Some(ArtificialViscosity {
        alpha: 0.7,
        switch,
        ..ArtificialViscosity::default()
    })
}

#[test]
fn the_viscosity_of_smd_damps_waves_as_its_forces_predict() {
    let entries = [[1.08, 0.1], [-0.04, 0.95]];
    let f = DeformationGradient::plane_strain(entries, 1.0).expect("a state");
    let map = Matrix2::new(1.08, 0.1, -0.04, 0.95);
    let switch = ViscositySwitch::Smd;
    let total = TotalLagrangianSph::new(
        crystal::<2>(LatticeKind::Square),
        TotalLagrangianChoices {
            density: DENSITY,
            radius: RADIUS,
            viscosity: viscosity(switch),
            ..TotalLagrangianChoices::default()
        },
    )
    .expect("a scheme");
    let moving = updated(
        crystal::<2>(LatticeKind::Square),
        UpdatedSphChoices {
            viscosity: viscosity(switch),
            ..smoothing(0.0, SmoothedMotion::Everything)
        },
    );
    let systems = [(true, waves(&total, &f)), (false, waves(&moving, &f))];
    let mut random = Random::new(4);
    for (is_total, system) in systems {
        for _ in 0..6 {
            let k = Vector2::from_fn(|_, _| 3.0 * random.number());
            let damping = system.damping().expect("a damping").at(&k);
            for v in [Vector2::x(), Vector2::y()] {
                let expected = -force_of_smd(&map, &k, &v, is_total);
                let found =
                    Vector2::from_fn(|i, _| (0..2).map(|j| damping[(i, j)].re * v[j]).sum::<f64>());
                assert!(
                    (found - expected).amax() < 1e-11 * (1.0 + expected.amax()),
                    "{found} {expected}"
                );
            }
        }
    }
}

#[test]
fn viscosity_scales_with_the_smoothing_length_of_the_kernel() {
    let material = ModifiedMooneyRivlin::default();
    let modulus = Stiffness::<1>::at(&material, &DeformationGradient::identity())
        .expect("a tangent")
        .maximum_eigenvalue();
    let speed = (modulus / DENSITY).sqrt();
    for (kernel, radii) in [
        (Kernel::CubicSpline, 2.0),
        (Kernel::WendlandC2, 2.0),
        (Kernel::QuarticBSpline, 2.5),
        (Kernel::QuinticSpline, 3.0),
        (Kernel::Gaussian, 3.0),
    ] {
        let (radius, k) = (3.4, 1.1_f64);
        let h = radius / radii;
        let chain = updated(
            crystal::<1>(LatticeKind::Chain),
            UpdatedSphChoices {
                kernel,
                radius,
                viscosity: viscosity(ViscositySwitch::Always),
                ..smoothing(0.0, SmoothedMotion::Everything)
            },
        );
        let damping = waves(&chain, &DeformationGradient::identity());
        let damping = damping.damping().expect("a damping");
        let found = damping.at(&SVector::from_element(k))[(0, 0)].re;
        let bond = |x: f64| {
            let weight = kernel
                .weight(&SVector::<f64, 1>::new(x), radius, &SMatrix::identity())
                .expect("within the support");
            let slope = weight.gradient[0] / kernel.integral::<1>(radius);
            2.0 * (1.0 - (k * x).cos()) * x * -slope / (x * x + 0.01 * h * h)
        };
        let expected = 0.7 * speed * h * DENSITY * (1..4).map(|n| bond(f64::from(n))).sum::<f64>();
        assert!(
            (found - expected).abs() < 1e-11 * expected,
            "{}: {found} {expected}",
            kernel.name()
        );
    }
}

fn radioss(hourglass_stiffness: f64, hourglass_viscosity: f64) -> Formulation {
    Formulation {
        integration: Integration::OnePoint,
        hourglass_stiffness,
        hourglass_viscosity,
        hourglass_scale: HourglassScale::Radioss,
        mass: ElementMass::Lumped,
    }
}

/// Sum over the bricks around the origin of Flanagan and Belytschko's control in a code: `-Gamma_a coefficient sum_b Gamma_b u_b`
/// for the four modes of parallelepipeds, whose `Gamma` need no correction; for `u cos(k.X)`.
fn resistance_of_bricks(vectors: &SMatrix<f64, 3, 3>, k: &Vector3<f64>) -> f64 {
    let corner = |n: usize| Vector3::from_fn(|i, _| f64::from(u8::from(n >> i & 1 == 1)));
    let sign = |n: usize, i: usize| if n >> i & 1 == 1 { 1.0 } else { -1.0 };
    let modes: [&[usize]; 4] = [&[1, 2], &[2, 0], &[0, 1], &[0, 1, 2]];
    let mut sum = 0.0;
    for own in 0..8 {
        for axes in modes {
            let gamma = |n: usize| axes.iter().map(|i| sign(n, *i)).product::<f64>();
            let amplitude: f64 = (0..8)
                .map(|n| gamma(n) * k.dot(&(vectors * (corner(n) - corner(own)))).cos())
                .sum();
            sum += gamma(own) * amplitude;
        }
    }
    sum
}

#[test]
fn hourglass_control_of_radioss_agrees_with_its_formulas() {
    let material = saint_venant_kirchhoff(0.7, 1.0);
    let modulus: f64 = 2.7;
    let speed = (modulus / DENSITY).sqrt();
    let mut random = Random::new(12);
    let vectors =
        SMatrix::<f64, 3, 3>::identity() * 0.8 + SMatrix::from_fn(|_, _| 0.15 * random.number());
    let volume = vectors.determinant().abs();
    let lattice = BravaisLattice::new(vectors).expect("a lattice");
    let rest = DeformationGradient::identity();
    let system = |formulation: Formulation| {
        let mesh = Mesh::parallelepipeds(lattice);
        let bricks = FiniteElements::on(mesh, DENSITY, formulation).expect("elements");
        bricks.waves(&*material, &rest).expect("waves")
    };
    let (plain, controlled) = (system(radioss(0.0, 0.0)), system(radioss(0.1, 0.2)));
    for _ in 0..6 {
        let k = Vector3::from_fn(|_, _| 4.0 * random.number());
        let resistance = resistance_of_bricks(&vectors, &k);
        let stiffness = controlled.stiffness().at(&k) - plain.stiffness().at(&k);
        let damping = controlled.damping().expect("a damping").at(&k);
        let expected = [
            0.038 * 0.1 * modulus * volume.cbrt() * resistance,
            0.25 * 0.2 * DENSITY * speed * volume.cbrt().powi(2) * resistance,
        ];
        for (found, expected) in [stiffness, damping].iter().zip(expected) {
            for i in 0..3 {
                for j in 0..3 {
                    let expected = if i == j { expected } else { 0.0 };
                    assert!(
                        (found[(i, j)].re - expected).abs() < 1e-10,
                        "{found} {expected}"
                    );
                }
            }
        }
    }
    // Alternating bricks: each of eight elements resists eight amplitudes.
    let cubes = FiniteElements::<3>::new(&ElementChoices {
        mesh: ElementMesh::Bricks,
        spacing: 0.8,
        density: DENSITY,
        formulation: radioss(0.1, 0.0),
        ..ElementChoices::default()
    })
    .expect("elements");
    let lowest = cubes.waves(&*material, &rest).expect("waves");
    let lowest = lowest.omega_squared(&Vector3::repeat(PI / 0.8))[0].re;
    let expected = 64.0 * 0.0038 * modulus / (DENSITY * 0.64);
    assert!((lowest - expected).abs() < 1e-10, "{lowest} {expected}");
}

#[test]
fn hourglass_control_of_radioss_is_viscous_in_the_plane() {
    let material = saint_venant_kirchhoff(0.7, 1.0);
    let speed = (2.7 / DENSITY).sqrt();
    let squares = |formulation| {
        FiniteElements::<2>::new(&ElementChoices {
            mesh: ElementMesh::Quadrilaterals,
            spacing: 0.8,
            density: DENSITY,
            formulation,
            ..ElementChoices::default()
        })
    };
    let system = squares(radioss(0.0, 0.2)).expect("elements");
    let system = system
        .waves(&*material, &DeformationGradient::identity())
        .expect("waves");
    let damping = system
        .damping()
        .expect("a damping")
        .at(&Vector2::repeat(PI / 0.8));
    // Each of four squares resists four amplitudes with h/2 rho c sqrt(A).
    let expected = 16.0 * 0.5 * 0.2 * DENSITY * speed * 0.8;
    assert!(
        (damping[(0, 0)].re - expected).abs() < 1e-10,
        "{damping} {expected}"
    );
    let refused = squares(radioss(0.1, 0.0)).expect_err("no stiffness in the plane");
    assert!(
        matches!(refused, MethodError::Incompatible { .. }),
        "{refused}"
    );
}

#[test]
fn the_penalty_of_smd_has_regularized_denominators() {
    // Particles that alternate in sign cause no strain, so that only the penalty acts. Each bond between opposite particles changes by 2 u, counted
    // once for either end.
    let (hourglass, young, poisson) = (1.7, 2.1, 0.3);
    let material = saint_venant_kirchhoff(
        young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)),
        0.5 * young / (1.0 + poisson),
    );
    let scheme = TotalLagrangianSph::new(
        crystal::<2>(LatticeKind::Square),
        TotalLagrangianChoices {
            density: DENSITY,
            radius: RADIUS,
            penalty: hourglass,
            penalty_form: PenaltyForm::Smd,
            ..TotalLagrangianChoices::default()
        },
    )
    .expect("a scheme");
    let state = DeformationGradient::identity();
    let system = scheme.waves(&*material, &state).expect("a state");
    let mut expected = 0.0;
    for (x, y) in (-2..=2).flat_map(|x| (-2..=2).map(move |y| (f64::from(x), f64::from(y)))) {
        let r = x.hypot(y);
        if (x + y) % 2.0 != 0.0 && r < RADIUS {
            let h = RADIUS;
            let denominators = (r * r + 0.01 * h * h) * (r + 0.1 * h) * (r + 0.01 * h);
            expected += hourglass * young * kernel(r)[0] / denominators * x * x;
        }
    }
    let matrix = system.dynamical_matrix_at(&Vector2::new(PI, PI));
    assert!(
        (matrix[(0, 0)].re / (expected / DENSITY) - 1.0).abs() < 1e-12,
        "{matrix}"
    );
    // The quantity that particles carry along is the stress, which does not change.
    let carried = scheme
        .carried(&*material, &state)
        .expect("a state")
        .expect("told apart")
        .all;
    assert!(carried.dynamical_matrix_at(&Vector2::new(PI, PI)).camax() < 1e-12);
    let k = Vector2::new(0.7, -1.3);
    let penalized = system.dynamical_matrix_at(&k) - carried.dynamical_matrix_at(&k);
    assert!(penalized.camax() > 1e-3);
}

#[test]
fn the_part_of_waves_that_follows_positions_is_the_stress_on_moving_kernels() {
    let entries = [[1.08, 0.1], [-0.04, 0.95]];
    let f = DeformationGradient::plane_strain(entries, 1.0).expect("a state");
    let map = Matrix2::new(1.08, 0.1, -0.04, 0.95);
    let material = ModifiedMooneyRivlin::default();
    let scheme = updated(
        crystal::<2>(LatticeKind::Square),
        UpdatedSphChoices {
            density: DENSITY,
            radius: RADIUS,
            momentum: MomentumForm::Mean,
            density_evolution: DensityEvolution::Continuity,
            ..UpdatedSphChoices::default()
        },
    );
    let stress = material.response(&f).expect("a state").cauchy();
    let stress = Matrix2::new(
        stress[(0, 0)],
        stress[(0, 1)],
        stress[(1, 0)],
        stress[(1, 1)],
    );
    let current = DENSITY / map.determinant();
    let carried = scheme
        .carried(&material, &f)
        .expect("a state")
        .expect("told apart")
        .all;
    let whole = waves(&scheme, &f);
    for k in [
        Vector2::new(0.7, -1.3),
        Vector2::new(PI, 0.0),
        Vector2::new(2.1, 2.6),
    ] {
        // Expected matrix: -2 m/rho^2 s sum (1 - cos k.X) grad grad W, with constant densities and stresses s.
        let mut positions = Matrix2::zeros();
        for (x, y) in (-4..=4).flat_map(|x| (-4..=4).map(move |y| (f64::from(x), f64::from(y)))) {
            let reference = Vector2::new(x, y);
            let vector = map * reference;
            let r = vector.norm();
            if r == 0.0 || r >= RADIUS {
                continue;
            }
            let (step, along) = (1e-5, vector / r);
            let second = (kernel(r + step)[1] - kernel(r - step)[1]) / (2.0 * step);
            let plane = along * along.transpose();
            let hessian = plane * second + (Matrix2::identity() - plane) * (kernel(r)[1] / r);
            positions += hessian * (1.0 - k.dot(&reference).cos());
        }
        let expected = stress * positions * (-2.0 * DENSITY / (current * current));
        let found = whole.dynamical_matrix_at(&k) - carried.dynamical_matrix_at(&k);
        for i in 0..2 {
            for j in 0..2 {
                let error = (found[(i, j)].re - expected[(i, j)]).abs();
                assert!(error < 1e-7 * (1.0 + expected.amax()), "{found} {expected}");
            }
        }
    }
}
