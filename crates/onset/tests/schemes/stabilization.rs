//! Effects of each stabilization on plane waves.

use crate::battery::assert_scheme;
use crate::sph::{crystal, stretched, updated, waves};
use nalgebra::{Matrix2, SMatrix, SVector, Vector2};
use onset::bloch::ZoneSearch;
use onset::continuum::Stiffness;
use onset::kernel::Kernel;
use onset::kinematics::DeformationGradient;
use onset::lattice::{BravaisLattice, Crystal, LatticeKind};
use onset::material::{Hyperelastic, Law, ModifiedMooneyRivlin};
use onset::scheme::Discretization;
use onset::scheme::sph::{
    MomentumForm, TotalLagrangianChoices, TotalLagrangianSph, UpdatedSph, UpdatedSphChoices,
};
use onset::scheme::stabilization::{ArtificialStress, ArtificialViscosity, ViscositySwitch};
use std::f64::consts::PI;

const KERNEL: Kernel = Kernel::QuarticSpline;

/// Values `W`, `W'`, `W''` of the normalized kernel at a distance in one dimension.
fn kernel(radius: f64, distance: f64) -> [f64; 3] {
    let x = SVector::<f64, 1>::new(distance);
    let weight = KERNEL.weight(&x, radius, &SMatrix::identity());
    let integral = KERNEL.integral::<1>(radius);
    weight.map_or([0.0; 3], |w| {
        [w.value, w.gradient[0], w.hessian[(0, 0)]].map(|x| x / integral)
    })
}

fn rest() -> DeformationGradient {
    DeformationGradient::identity()
}

fn total<const D: usize>(
    kind: LatticeKind,
    choices: TotalLagrangianChoices,
) -> TotalLagrangianSph<D> {
    TotalLagrangianSph::new(crystal(kind), choices).expect("a scheme")
}

fn young_modulus(material: &dyn Hyperelastic) -> f64 {
    // Young's modulus of an isotropic law: mu (3 lambda + 2 mu) / (lambda + mu).
    let tangent = material.response(&rest()).expect("a state").tangent;
    let (lambda, mu) = (tangent[(0, 0, 1, 1)], tangent[(0, 1, 0, 1)]);
    mu * (3.0 * lambda + 2.0 * mu) / (lambda + mu)
}

#[test]
fn the_penalty_lifts_alternating_particles_in_proportion_to_its_coefficient() {
    // Alternating particles cause no strain, so that the penalty acts on the whole bond: omega^2 = 4 alpha E a / rho sum over odd n of W(n a) / (n
    // a)^2.
    let modulus = young_modulus(&ModifiedMooneyRivlin::default());
    for (radius, alpha) in [(1.5, 1.0), (1.5, 20.0), (3.4, 20.0)] {
        let choices = TotalLagrangianChoices {
            penalty: alpha,
            radius,
            density: 1.3,
            ..TotalLagrangianChoices::default()
        };
        let scheme = total::<1>(LatticeKind::Chain, choices);
        let found = waves(&scheme, &rest()).omega_squared(&SVector::from_element(PI))[0].re;
        let sum = kernel(radius, 1.0)[0] + kernel(radius, 3.0)[0] / 9.0;
        let expected = 4.0 * alpha * modulus / 1.3 * sum;
        assert!(
            (found - expected).abs() < 1e-10 * expected,
            "{found} {expected}"
        );
    }
}

#[test]
fn the_penalty_lifts_the_zero_energy_modes_of_the_square_and_the_hexagonal_lattice() {
    let corners = [
        (LatticeKind::Square, Vector2::new(PI, PI)),
        (LatticeKind::Square, Vector2::new(PI, 0.0)),
        (
            LatticeKind::Hexagonal,
            Vector2::new(0.0, 2.0 * PI / 3.0_f64.sqrt()),
        ),
    ];
    for (kind, k) in corners {
        let lowest = |penalty: f64| {
            let choices = TotalLagrangianChoices {
                penalty,
                ..TotalLagrangianChoices::default()
            };
            waves(&total::<2>(kind, choices), &rest()).omega_squared(&k)[0].re
        };
        assert!(lowest(0.0).abs() < 1e-10);
        let unit = lowest(1.0);
        assert!(unit > 1e-3, "{kind:?}: {unit}");
        for alpha in [0.1, 50.0] {
            assert!((lowest(alpha) - alpha * unit).abs() < 1e-10 * alpha.max(1.0));
        }
    }
}

/// Lamina whose fibers are at the given angle to the first axis (degrees).
fn lamina(angle: f64) -> Box<dyn Hyperelastic> {
    let law = Law::named("saint-venant-orthotropic").expect("a law of the library");
    law.build(&[("angle", angle)]).expect("a material")
}

/// Young's modulus of the lamina at an angle to its fibers (radians), from its engineering constants (Lekhnitskii 1963).
fn young_modulus_at(angle: f64) -> f64 {
    let (e1, e2, nu, g) = (140.0, 10.0, 0.3, 5.0);
    let (s, c) = angle.sin_cos();
    (c.powi(4) / e1 + s.powi(4) / e2 + (s * c).powi(2) * (1.0 / g - 2.0 * nu / e1)).recip()
}

#[test]
fn the_penalty_uses_youngs_modulus_along_each_bond_from_the_full_compliance() {
    // Alternating particles cause no strain: rho omega^2 = sum over bonds between opposite particles of 2 alpha E W / |X|^2 n (x) n.
    assert!((young_modulus_at(PI / 6.0) - 21.29).abs() < 5e-3);
    let radius = 2.3;
    for degrees in [0.0_f64, 30.0, 77.0] {
        let choices = TotalLagrangianChoices {
            penalty: 0.9,
            radius,
            ..TotalLagrangianChoices::default()
        };
        let square = total::<2>(LatticeKind::Square, choices);
        let waves = square.waves(&*lamina(degrees), &rest()).expect("waves");
        for k in [[1, 0], [0, 1], [1, 1]] {
            let mut expected = Matrix2::zeros();
            for a in -2..=2_i32 {
                for b in -2..=2_i32 {
                    let x = Vector2::new(f64::from(a), f64::from(b));
                    let weight = KERNEL.weight(&x, radius, &Matrix2::identity());
                    let Some(weight) = weight.filter(|_| (a * k[0] + b * k[1]) % 2 != 0) else {
                        continue;
                    };
                    let along = x[1].atan2(x[0]) - degrees.to_radians();
                    let weight = weight.value / KERNEL.integral::<2>(radius);
                    let spring = 2.0 * 0.9 * young_modulus_at(along) * weight / x.norm_squared();
                    expected += x.normalize() * x.normalize().transpose() * spring;
                }
            }
            let k = Vector2::from_fn(|i, _| PI * f64::from(k[i]));
            let found = waves.dynamical_matrix_at(&k);
            for i in 0..2 {
                for j in 0..2 {
                    assert!(
                        (found[(i, j)].re - expected[(i, j)]).abs() < 1e-10 * expected.amax(),
                        "{degrees}: {found} {expected}"
                    );
                }
            }
        }
    }
}

#[test]
fn the_penalty_is_invariant_under_a_rotation_of_law_and_lattice() {
    let at = |angle: f64, degrees: f64, k: Vector2<f64>| {
        let (sine, cosine) = angle.sin_cos();
        let turn = Matrix2::new(cosine, -sine, sine, cosine);
        let vectors = turn * Matrix2::new(1.0, 0.3, 0.0, 0.9);
        let crystal = Crystal::of_lattice(BravaisLattice::new(vectors).expect("a lattice"));
        let choices = TotalLagrangianChoices {
            penalty: 1.7,
            radius: 1.8,
            ..TotalLagrangianChoices::default()
        };
        let scheme = TotalLagrangianSph::new(crystal, choices).expect("a scheme");
        let material = lamina(degrees + angle.to_degrees());
        let waves = scheme.waves(&*material, &rest()).expect("waves");
        waves.omega_squared(&(turn * k))
    };
    for k in [[0.4, 0.9], [2.5, -1.3], [3.0, 2.8]].map(Vector2::from) {
        let plain = at(0.0, 20.0, k);
        for angle in [0.3, 1.1, 2.0] {
            for (a, b) in plain.iter().zip(at(angle, 20.0, k)) {
                assert!((a - b).norm() < 1e-10 * plain[1].re, "{a} {b}");
            }
        }
    }
}

fn with_artificial_stress(radius: f64, epsilon: f64) -> UpdatedSphChoices {
    UpdatedSphChoices {
        radius,
        artificial_stress: Some(ArtificialStress {
            epsilon,
            ..ArtificialStress::default()
        }),
        ..UpdatedSphChoices::default()
    }
}

#[test]
fn methods_with_artificial_stress_pass_the_scheme_checks() {
    let material = ModifiedMooneyRivlin::default();
    for momentum in [MomentumForm::Symmetric, MomentumForm::Mean] {
        let choices = UpdatedSphChoices {
            momentum,
            ..with_artificial_stress(1.7, 0.3)
        };
        // The stress is tension along one axis and compression along the other.
        let f = DeformationGradient::plane_strain([[1.1, 0.1], [-0.1, 0.9]], 1.0).expect("a state");
        let principal = material.response(&f).expect("a state").cauchy();
        assert!(principal.fixed_view::<2, 2>(0, 0).determinant() < 0.0);
        let square = updated(crystal::<2>(LatticeKind::Square), choices.clone());
        assert_scheme(&square, &material, &f);
        let chain = updated(crystal::<1>(LatticeKind::Chain), choices);
        assert_scheme(&chain, &material, &stretched([1.1, 1.0, 1.0]));
    }
}

#[test]
fn sufficient_artificial_stress_reverses_swegles_criterion() {
    // With f = W / W(spacing): omega^2 = -8 sigma a / rho ((1 - epsilon f^n) W'' - epsilon n f^n W'^2 / W).
    let radius = 1.5;
    let material = ModifiedMooneyRivlin::default();
    let at_the_end = |epsilon: f64, stretch: f64| {
        let chain = updated(
            crystal::<1>(LatticeKind::Chain),
            with_artificial_stress(radius, epsilon),
        );
        let system = waves(&chain, &stretched([stretch, 1.0, 1.0]));
        system.omega_squared(&SVector::from_element(PI))[0].re
    };
    for (epsilon, stretch) in [(0.0, 1.05), (0.1, 1.05), (0.3, 1.1), (0.3, 0.9)] {
        let stress = material
            .response(&stretched([stretch, 1.0, 1.0]))
            .expect("a state")
            .cauchy()[(0, 0)];
        let [w, slope, curvature] = kernel(radius, stretch);
        let factor = if stress > 0.0 { epsilon } else { 0.0 };
        let factor = factor * (w / kernel(radius, 1.0)[0]).powi(4);
        let kernels = (1.0 - factor) * curvature - 4.0 * factor * slope * slope / w;
        let expected = -8.0 * stress * stretch * stretch * kernels;
        let found = at_the_end(epsilon, stretch);
        assert!(
            (found - expected).abs() < 1e-10 * (1.0 + expected.abs()),
            "{found} {expected}"
        );
    }
    // Near the reference state the smallest sufficient coefficient is W'' / (W'' + n W'^2 / W).
    let [w, slope, curvature] = kernel(radius, 1.0);
    let critical = curvature / (curvature + 4.0 * slope * slope / w);
    assert!((critical - 9.0 / 73.0).abs() < 1e-12, "{critical}");
    let slightly = 1.0 + 1e-6;
    assert!(at_the_end(critical - 1e-3, slightly) < 0.0);
    assert!(at_the_end(critical + 1e-3, slightly) > 0.0);
}

fn search(kind: LatticeKind) -> ZoneSearch<2> {
    let undeformed =
        Stiffness::<2>::at(&ModifiedMooneyRivlin::default(), &rest()).expect("a tangent");
    let lattice = kind.lattice(1.0).expect("a lattice");
    ZoneSearch::of_lattice(lattice, undeformed.maximum_eigenvalue())
}

#[test]
fn the_published_artificial_stress_shifts_the_tensile_onset_without_removing_it() {
    let search = search(LatticeKind::Hexagonal);
    let is_stable = |radius: f64, epsilon: f64, stretch: f64| {
        let choices = with_artificial_stress(radius, epsilon);
        let hexagonal = updated(crystal::<2>(LatticeKind::Hexagonal), choices);
        let f = stretched([stretch, stretch, 1.0]);
        search.summary_of(&waves(&hexagonal, &f)).is_stable()
    };
    // Equibiaxial tension: support radius and onset with epsilon = 0.3 and n = 4. The kernel ratio decreases as the particles separate.
    for (radius, stable, unstable) in [(1.3, 1.02, 1.05), (1.6, 1.05, 1.1), (2.0, 1.1, 1.2)] {
        assert!(!is_stable(radius, 0.0, 1.001), "radius {radius}");
        assert!(is_stable(radius, 0.3, 1.001), "radius {radius}");
        assert!(is_stable(radius, 0.3, stable), "radius {radius}");
        assert!(!is_stable(radius, 0.3, unstable), "radius {radius}");
    }
    // Too large a coefficient causes a different instability.
    assert!(is_stable(2.6, 0.3, 1.001) && !is_stable(2.6, 0.5, 1.001));
}

#[test]
fn the_published_artificial_stress_works_on_chains_and_hexagonal_lattices_and_not_on_squares() {
    // The published choice: cubic spline with h = 1.3 spacings, epsilon = 0.3, n = 4.
    let choices = |epsilon: f64| UpdatedSphChoices {
        kernel: Kernel::CubicSpline,
        ..with_artificial_stress(2.6, epsilon)
    };
    let material = ModifiedMooneyRivlin::default();
    let stiffness = Stiffness::<1>::at(&material, &rest()).expect("a tangent");
    let lattice = LatticeKind::Chain.lattice(1.0).expect("a lattice");
    let along = ZoneSearch::<1>::of_lattice(lattice, stiffness.maximum_eigenvalue());
    let chain_is_stable = |epsilon: f64, stretch: f64| {
        let chain = updated(crystal::<1>(LatticeKind::Chain), choices(epsilon));
        let system = waves(&chain, &stretched([stretch, 1.0, 1.0]));
        along.summary_of(&system).is_stable()
    };
    // W'' / (W'' + n W'^2 / W) = 0.0521 is sufficient near the reference state, over the whole zone.
    assert!(!chain_is_stable(0.0515, 1.0001) && chain_is_stable(0.0527, 1.0001));
    assert!(chain_is_stable(0.3, 1.1) && !chain_is_stable(0.3, 1.2));
    let plane_is_stable = |kind: LatticeKind, epsilon: f64, stretch: f64| {
        let plane = updated(crystal::<2>(kind), choices(epsilon));
        let system = waves(&plane, &stretched([stretch, stretch, 1.0]));
        search(kind).summary_of(&system).is_stable()
    };
    let hexagonal = LatticeKind::Hexagonal;
    assert!(!plane_is_stable(hexagonal, 0.0, 1.001));
    assert!(plane_is_stable(hexagonal, 0.3, 1.001) && plane_is_stable(hexagonal, 0.3, 1.1));
    assert!(!plane_is_stable(hexagonal, 0.3, 1.2));
    for epsilon in [0.0, 0.1, 0.2, 0.3, 0.5] {
        assert!(
            !plane_is_stable(LatticeKind::Square, epsilon, 1.001),
            "{epsilon}"
        );
    }
}

#[test]
fn artificial_stress_does_not_change_compression() {
    let at = |epsilon: f64| {
        let hexagonal = updated(
            crystal::<2>(LatticeKind::Hexagonal),
            with_artificial_stress(2.0, epsilon),
        );
        let system = waves(&hexagonal, &stretched([0.98, 0.98, 1.0]));
        search(LatticeKind::Hexagonal).summary_of(&system)
    };
    let (without, with) = (at(0.0), at(0.3));
    assert!(!without.is_stable());
    assert!((without.softest.scaled - with.softest.scaled).abs() < 1e-14);
}

#[test]
fn velocity_smoothing_scales_every_frequency_of_a_chain_and_lowers_the_largest() {
    let smoothed = |epsilon: f64| {
        let choices = UpdatedSphChoices {
            radius: 2.6,
            velocity_smoothing: epsilon,
            ..UpdatedSphChoices::default()
        };
        waves(&updated(crystal::<1>(LatticeKind::Chain), choices), &rest())
    };
    let (plain, smooth) = (smoothed(0.0), smoothed(0.5));
    for k in [0.3, 1.7, 2.9] {
        // The transfer of a wave is T = 1 - epsilon sum V W (1 - cos k x).
        let sum: f64 = [1.0, 2.0]
            .iter()
            .map(|x| 2.0 * kernel(2.6, *x)[0] * (1.0 - (k * x).cos()))
            .sum();
        let k = SVector::from_element(k);
        let (plain, smooth) = (
            plain.omega_squared(&k)[0].re,
            smooth.omega_squared(&k)[0].re,
        );
        assert!((smooth - (1.0 - 0.5 * sum) * plain).abs() < 1e-12 * plain.abs());
    }
    let lattice = LatticeKind::Chain.lattice(1.0).expect("a lattice");
    let search = ZoneSearch::<1>::of_lattice(lattice, 1.0);
    let largest = [&plain, &smooth].map(|system| search.summary_of(system).maximum_omega);
    assert!(largest[1] < 0.95 * largest[0], "{largest:?}");
}

#[test]
fn velocity_smoothing_with_one_particle_per_cell_is_a_sum_over_the_lattice() {
    let choices = UpdatedSphChoices {
        velocity_smoothing: 0.5,
        ..UpdatedSphChoices::default()
    };
    let system = waves(
        &updated(crystal::<2>(LatticeKind::Hexagonal), choices),
        &stretched([1.1, 0.95, 1.0]),
    );
    let single = system.single().expect("one particle in a cell");
    for k in [
        Vector2::new(0.3, -1.2),
        Vector2::new(2.1, 0.7),
        Vector2::new(-3.0, 2.2),
    ] {
        let (one, whole) = (single.at(&k), system.dynamical_matrix_at(&k));
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            assert!((one[(i, j)] - whole[(i, j)]).norm() < 1e-12 * whole.norm());
        }
    }
}

fn viscous(alpha: f64, switch: ViscositySwitch) -> UpdatedSphChoices {
    UpdatedSphChoices {
        density: 1.3,
        radius: 2.6,
        viscosity: Some(ArtificialViscosity {
            alpha,
            switch,
            ..ArtificialViscosity::default()
        }),
        ..UpdatedSphChoices::default()
    }
}

#[test]
fn viscosity_damps_a_chain_by_the_sum_over_its_bonds() {
    let material = ModifiedMooneyRivlin::default();
    let modulus = Stiffness::<1>::at(&material, &rest())
        .expect("a tangent")
        .maximum_eigenvalue();
    let speed = (modulus / 1.3).sqrt();
    let length = 1.3;
    for (switch, share) in [
        (ViscositySwitch::Always, 1.0),
        (ViscositySwitch::Averaged, 0.5),
    ] {
        let system = waves(
            &updated(crystal::<1>(LatticeKind::Chain), viscous(0.7, switch)),
            &rest(),
        );
        let total = total::<1>(
            LatticeKind::Chain,
            TotalLagrangianChoices {
                density: 1.3,
                radius: 2.6,
                viscosity: viscous(0.7, switch).viscosity,
                ..TotalLagrangianChoices::default()
            },
        );
        let k = 1.1;
        let bond = |x: f64| {
            let [_, slope, _] = kernel(2.6, x);
            2.0 * (1.0 - (k * x).cos()) * x * -slope / (x * x + 0.01 * length * length)
        };
        let expected = share * 0.7 * speed * length * 1.3 * (bond(1.0) + bond(2.0));
        for system in [system, waves(&total, &rest())] {
            let damping = system
                .damping()
                .expect("a damping")
                .at(&SVector::from_element(k));
            assert!((damping[(0, 0)].re - expected).abs() < 1e-12 * expected);
        }
    }
}

#[test]
fn viscosity_damps_every_wave_of_a_stable_state_without_shifting_the_onset() {
    let plain = UpdatedSphChoices {
        viscosity: None,
        ..viscous(0.0, ViscositySwitch::Always)
    };
    let viscous = viscous(0.5, ViscositySwitch::Always);
    let of = |choices: &UpdatedSphChoices| -> UpdatedSph<2> {
        updated(crystal::<2>(LatticeKind::Hexagonal), choices.clone())
    };
    let (plain, viscous) = (of(&plain), of(&viscous));
    for stretch in [0.96, 0.99, 1.01, 1.05] {
        let f = stretched([stretch, stretch, 1.0]);
        let (plain, viscous) = (waves(&plain, &f), waves(&viscous, &f));
        for k in [[0.7, 0.2], [2.0, 2.5], [0.0, 3.6]].map(SVector::from) {
            let is_stable = plain.omega_squared(&k).iter().all(|z| z.re > 0.0);
            let fastest = viscous.frequencies(&k)[0].im;
            assert_eq!(
                fastest < 0.0,
                is_stable,
                "stretch {stretch}, k {k}: {fastest}"
            );
        }
    }
}

#[test]
fn methods_with_viscosity_and_velocity_smoothing_pass_the_scheme_checks() {
    let material = ModifiedMooneyRivlin::default();
    let chain = updated(
        crystal::<1>(LatticeKind::Chain),
        viscous(0.7, ViscositySwitch::Averaged),
    );
    assert_scheme(&chain, &material, &stretched([1.1, 1.0, 1.0]));
    assert!((chain.neighbors() - 5.0).abs() < 1e-15);
}
