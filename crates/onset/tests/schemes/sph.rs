//! Smoothed particle hydrodynamics: common properties and differences of its forms, and Swegle's criterion.

use crate::battery::{
    assert_long_waves_are_those_of_the_material, assert_scheme, assert_translations_are_free,
    assert_waves_are_those_of_a_patch,
};
use crate::random::Random;
use nalgebra::{Matrix3, SMatrix, SVector};
use onset::approximation::Approximation;
use onset::bloch::{Stability, WaveSystem, ZoneSearch, dynamical_matrix, growth_rate};
use onset::kernel::Kernel;
use onset::kinematics::DeformationGradient;
use onset::lattice::{BravaisLattice, Crystal, LatticeKind};
use onset::material::{Hyperelastic, Law, MaterialError, ModifiedMooneyRivlin};
use onset::measures::spurious_modes;
use onset::method::{KernelMethodChoices, Method, MethodError, SupportSize};
use onset::quadrature::Quadrature;
use onset::scheme::Discretization;
use onset::scheme::kernel::{CrystalQuadrature, KernelChoices, KernelScheme};
use onset::scheme::sph::{
    DensityEvolution, MomentumForm, ShearForces, TotalLagrangianChoices, TotalLagrangianSph,
    UpdatedSph, UpdatedSphChoices,
};
use onset::scheme::stabilization::ArtificialStress;
use onset::verdict::{Survey, WEAK_WAVE_RATIO, speed_squared};
use std::f64::consts::PI;

const FORMS: [MomentumForm; 3] = [
    MomentumForm::Symmetric,
    MomentumForm::Mean,
    MomentumForm::Difference,
];
const DENSITIES: [DensityEvolution; 2] =
    [DensityEvolution::Summation, DensityEvolution::Continuity];

pub fn crystal<const D: usize>(kind: LatticeKind) -> Crystal<D> {
    Crystal::of_lattice(kind.lattice(1.0).expect("a lattice"))
}

pub fn stretched(stretches: [f64; 3]) -> DeformationGradient {
    DeformationGradient::from_stretches(stretches).expect("a deformation")
}

fn sheared() -> DeformationGradient {
    DeformationGradient::plane_strain([[1.1, 0.2], [0.0, 0.95]], 1.0).expect("a deformation")
}

fn total<const D: usize>(
    crystal: Crystal<D>,
    choices: TotalLagrangianChoices,
) -> TotalLagrangianSph<D> {
    TotalLagrangianSph::new(crystal, choices).expect("a scheme")
}

pub fn updated<const D: usize>(crystal: Crystal<D>, choices: UpdatedSphChoices) -> UpdatedSph<D> {
    UpdatedSph::new(crystal, choices).expect("a scheme")
}

pub fn waves<const D: usize>(
    scheme: &dyn Discretization<D>,
    f: &DeformationGradient,
) -> WaveSystem<D> {
    scheme
        .waves(&ModifiedMooneyRivlin::default(), f)
        .expect("a state")
}

/// All forms with all density evolutions, with and without the correction.
fn all_updated(radius: f64) -> Vec<UpdatedSphChoices> {
    let mut all = Vec::new();
    for momentum in FORMS {
        for density_evolution in DENSITIES {
            for corrected in [false, true] {
                all.push(UpdatedSphChoices {
                    density: 1.3,
                    radius,
                    momentum,
                    density_evolution,
                    corrected,
                    ..UpdatedSphChoices::default()
                });
            }
        }
    }
    all
}

#[test]
fn total_lagrangian_sph_passes_the_scheme_checks() {
    let material = ModifiedMooneyRivlin::default();
    let pairs = ShearForces::Pairs { coefficient: 1.07 };
    for corrected in [false, true] {
        for (penalty, shear) in [
            (0.0, ShearForces::Stress),
            (10.0, ShearForces::Stress),
            (0.0, pairs),
        ] {
            let choices = TotalLagrangianChoices {
                corrected,
                penalty,
                shear,
                radius: 1.6,
                ..TotalLagrangianChoices::default()
            };
            let f = stretched([1.1, 0.9, 1.05]);
            assert_scheme(
                &total(crystal::<1>(LatticeKind::Chain), choices.clone()),
                &material,
                &f,
            );
            let square = crystal::<2>(LatticeKind::Square);
            assert_scheme(&total(square, choices.clone()), &material, &sheared());
            let cubic = BravaisLattice::new(Matrix3::identity()).expect("a lattice");
            assert_scheme(&total(Crystal::of_lattice(cubic), choices), &material, &f);
        }
    }
}

#[test]
fn pairwise_shear_gives_transverse_waves_the_laplacian_of_the_kernel() {
    // Expected: omega^2 = 2 zeta mu / rho sum_J V_J |W'|/r (1 - cos k.X_J), because at k = (pi, 0) and (pi, pi) the stress of a particle with corrected gradients vanishes.
    let (mu, zeta, radius) = (0.8, 1.07, 2.6);
    let law = Law::named("saint-venant-kirchhoff").expect("a law of the library");
    let law = law
        .build(&[("lambda", 1.7), ("mu", mu)])
        .expect("constants");
    let choices = TotalLagrangianChoices {
        kernel: Kernel::WendlandC2,
        shear: ShearForces::Pairs { coefficient: zeta },
        radius,
        ..TotalLagrangianChoices::default()
    };
    let sph = total(crystal::<2>(LatticeKind::Square), choices);
    let system = sph
        .waves(&*law, &DeformationGradient::identity())
        .expect("an evaluable state");
    for k in [SVector::from([PI, 0.0]), SVector::from([PI, PI])] {
        let mut sum = 0.0;
        for x in -2_i32..=2 {
            for y in -2_i32..=2 {
                let bond = SVector::from([f64::from(x), f64::from(y)]);
                let q = bond.norm() / radius;
                if q > 0.0 && q < 1.0 {
                    // W = 7/(pi R^2) (1 - q)^4 (1 + 4 q), hence W' = -140/(pi R^3) q (1 - q)^3.
                    let slope = 140.0 / (PI * radius.powi(3)) * q * (1.0 - q).powi(3);
                    sum += slope / bond.norm() * (1.0 - k.dot(&bond).cos());
                }
            }
        }
        for found in system.omega_squared(&k) {
            let expected = 2.0 * zeta * mu * sum;
            assert!(
                (found.re / expected - 1.0).abs() < 1e-10,
                "{found} {expected}"
            );
        }
    }
}

#[test]
fn pairwise_shear_leaves_no_zero_energy_mode() {
    let count = |shear| {
        let choices = TotalLagrangianChoices {
            shear,
            ..TotalLagrangianChoices::default()
        };
        let sph = total(crystal::<2>(LatticeKind::Square), choices);
        let material = ModifiedMooneyRivlin::default();
        let survey = Survey::new(&sph, &material).expect("a survey");
        let found = spurious_modes(&survey, WEAK_WAVE_RATIO).expect("modes");
        found.modes.iter().filter(|mode| mode.is_zero()).count()
    };
    assert!(count(ShearForces::Stress) > 0);
    assert_eq!(count(ShearForces::Pairs { coefficient: 1.07 }), 0);
}

#[test]
fn every_form_of_updated_sph_passes_the_scheme_checks() {
    let material = ModifiedMooneyRivlin::default();
    for choices in all_updated(2.3) {
        let f = stretched([1.1, 0.9, 1.05]);
        assert_scheme(
            &updated(crystal::<1>(LatticeKind::Chain), choices),
            &material,
            &f,
        );
    }
    for choices in all_updated(1.3) {
        let hexagonal = crystal::<2>(LatticeKind::Hexagonal);
        assert_scheme(&updated(hexagonal, choices), &material, &sheared());
    }
    let cubic = BravaisLattice::new(Matrix3::identity()).expect("a lattice");
    let choices = UpdatedSphChoices {
        radius: 1.3,
        support_size: SupportSize::Convected,
        density_evolution: DensityEvolution::Summation,
        ..UpdatedSphChoices::default()
    };
    let f = stretched([1.1, 0.9, 1.05]);
    assert_scheme(&updated(Crystal::of_lattice(cubic), choices), &material, &f);
}

#[test]
fn waves_of_particles_with_different_volumes_agree_with_a_patch() {
    let material = ModifiedMooneyRivlin::default();
    let square = crystal::<2>(LatticeKind::Square);
    let irregular = square
        .supercell([3, 1])
        .and_then(|large| large.perturbed(0.15, 4));
    let irregular = irregular.expect("a crystal");
    assert!((irregular.volumes()[0] - irregular.volumes()[1]).abs() > 0.01);
    let choices = TotalLagrangianChoices {
        penalty: 3.0,
        radius: 1.7,
        ..TotalLagrangianChoices::default()
    };
    let scheme = total(irregular.clone(), choices);
    assert_waves_are_those_of_a_patch(&scheme, &material, &sheared());
    assert_translations_are_free(&scheme, &material, &sheared());
    for choices in all_updated(1.7) {
        let is_conservative = choices.momentum != MomentumForm::Difference;
        let scheme = updated(irregular.clone(), choices);
        assert_waves_are_those_of_a_patch(&scheme, &material, &sheared());
        if is_conservative {
            assert_translations_are_free(&scheme, &material, &sheared());
        }
    }
}

#[track_caller]
fn assert_same<const D: usize>(
    one: impl Fn(&SVector<f64, D>) -> nalgebra::DMatrix<onset::algebra::Complex>,
    other: impl Fn(&SVector<f64, D>) -> nalgebra::DMatrix<onset::algebra::Complex>,
) {
    let mut random = Random::new(2);
    for _ in 0..5 {
        let k = SVector::<f64, D>::from_fn(|_, _| 4.0 * random.number());
        let (one, other) = (one(&k), other(&k));
        let scale = one.map(|z| z.norm()).max();
        let apart = (&one - &other).map(|z| z.norm()).max();
        assert!(apart < 1e-12 * scale, "{one} {other}");
    }
}

#[test]
fn uncorrected_total_lagrangian_sph_equals_nodal_integration_of_raw_kernels() {
    for kind in [LatticeKind::Square, LatticeKind::Hexagonal] {
        let discretization = KernelMethodChoices {
            lattice: kind,
            approximation: Approximation::Raw,
            quadrature: Quadrature::Nodal,
            support: 2.3,
            ..KernelMethodChoices::default()
        };
        let method = Method::<2>::new(discretization).expect("a method");
        let material = ModifiedMooneyRivlin::default();
        let closed = dynamical_matrix(&method, &material, &sheared()).expect("a state");
        let choices = TotalLagrangianChoices {
            corrected: false,
            radius: 2.3,
            ..TotalLagrangianChoices::default()
        };
        let system = waves(&total(crystal::<2>(kind), choices), &sheared());
        assert_same::<2>(
            |k| system.dynamical_matrix_at(k),
            |k| {
                let matrix = closed.at(k);
                nalgebra::DMatrix::from_fn(2, 2, |i, j| matrix[(i, j)])
            },
        );
    }
}

#[test]
fn long_waves_of_corrected_total_lagrangian_sph_agree_with_the_material_for_any_penalty() {
    let material = ModifiedMooneyRivlin::default();
    for penalty in [0.0, 50.0] {
        let choices = TotalLagrangianChoices {
            penalty,
            ..TotalLagrangianChoices::default()
        };
        let f = sheared();
        let hexagonal = total(crystal::<2>(LatticeKind::Hexagonal), choices.clone());
        assert_long_waves_are_those_of_the_material(&hexagonal, &material, &f, 1e-10);
        let chain = total(crystal::<1>(LatticeKind::Chain), choices);
        let f = stretched([0.9, 1.0, 1.0]);
        assert_long_waves_are_those_of_the_material(&chain, &material, &f, 1e-10);
    }
}

/// The penalty scales with Young's modulus, `9 kappa mu / (3 kappa + mu)`, which is undefined for a fluid.
#[test]
fn a_penalty_for_a_fluid_is_rejected_with_the_reason() {
    let law = Law::named("murnaghan").expect("a law of the library");
    let fluid = law.build(&[("mu", 0.0)]).expect("a fluid");
    let choices = TotalLagrangianChoices {
        penalty: 0.2,
        ..TotalLagrangianChoices::default()
    };
    let scheme = total(crystal::<2>(LatticeKind::Hexagonal), choices);
    let error = scheme.waves(&*fluid, &stretched([0.99, 1.0, 1.0]));
    assert!(matches!(
        error,
        Err(MethodError::Material(MaterialError::NoYoungsModulus))
    ));
}

#[test]
fn all_forms_are_equal_without_stress() {
    // Without stress the motion of the kernels has no effect, and the divergence of the stress is the same in all forms.
    let rest = DeformationGradient::identity();
    let reference = TotalLagrangianChoices {
        corrected: false,
        ..TotalLagrangianChoices::default()
    };
    let square = crystal::<2>(LatticeKind::Square);
    let reference = waves(&total(square.clone(), reference), &rest);
    for momentum in FORMS {
        let choices = UpdatedSphChoices {
            momentum,
            ..UpdatedSphChoices::default()
        };
        let system = waves(&updated(square.clone(), choices), &rest);
        assert_same::<2>(
            |k| system.dynamical_matrix_at(k),
            |k| reference.dynamical_matrix_at(k),
        );
    }
}

/// In the reference state the matrix is real and as symmetric as the lattice, so that the eigenvalue iteration does not converge by itself.
#[test]
fn a_supercell_in_the_reference_state_has_the_frequencies_of_the_folded_waves() {
    let choices = UpdatedSphChoices {
        radius: 2.92,
        corrected: true,
        momentum: MomentumForm::Symmetric,
        density_evolution: DensityEvolution::Continuity,
        support_size: SupportSize::Scaled,
        ..UpdatedSphChoices::default()
    };
    let law = Law::named("ogden")
        .expect("a law")
        .build(&[])
        .expect("its defaults");
    let f = stretched([1.207, 0.709, 1.0]);
    let hexagonal = crystal::<2>(LatticeKind::Hexagonal);
    let large = hexagonal.supercell([3, 3]).expect("a crystal");
    let rest = updated(large.clone(), choices.clone())
        .waves(&*law, &f)
        .expect("waves");
    let found = rest.omega_squared(&SVector::zeros());
    let alone = updated(hexagonal, choices).waves(&*law, &f).expect("waves");
    let mut expected: Vec<f64> = (0..9)
        .flat_map(|n| {
            let number = SVector::<f64, 2>::new(f64::from(n % 3), f64::from(n / 3));
            let k = large.lattice().reciprocal() * number;
            alone.omega_squared(&k).into_iter().map(|own| own.re)
        })
        .collect();
    expected.sort_by(f64::total_cmp);
    assert_eq!(found.len(), expected.len());
    for (own, expected) in found.iter().zip(expected) {
        assert!((own.re - expected).abs() < 1e-9, "{own} {expected}");
        assert!(own.im.abs() < 1e-6, "{own}");
    }
}

/// Second derivative `W''` of the normalized kernel at a distance in one dimension.
fn curvature(kernel: Kernel, radius: f64, distance: f64) -> f64 {
    let x = SVector::<f64, 1>::new(distance);
    let weight = kernel.weight(&x, radius, &SMatrix::identity());
    weight.map_or(0.0, |w| w.hessian[(0, 0)]) / kernel.integral::<1>(radius)
}

#[test]
fn alternating_particles_obey_swegles_criterion() {
    // Strain and density do not change, only the kernel moves: omega^2 = -8 sigma a / rho sum over odd n of W''(n a).
    // With the nearest neighbors alone -8 sigma a W''(a) / rho: unstable if W'' sigma > 0.
    let material = ModifiedMooneyRivlin::default();
    let kernel = Kernel::QuarticSpline;
    for (radius, stretch) in [
        (1.5, 1.05),
        (1.5, 0.93),
        (2.6, 1.05),
        (2.6, 0.93),
        (3.4, 1.1),
    ] {
        let f = stretched([stretch, 1.0, 1.0]);
        let stress = material.response(&f).expect("a state").cauchy()[(0, 0)];
        let density = 1.3 / stretch;
        let curvatures = [1.0, 3.0].map(|n| curvature(kernel, radius, n * stretch));
        let expected = -8.0 * stress * stretch / density * curvatures.iter().sum::<f64>();
        let at_the_end = |scheme: &dyn Discretization<1>| {
            waves(scheme, &f).omega_squared(&SVector::from_element(PI))[0].re
        };
        for density_evolution in DENSITIES {
            for (momentum, factor) in FORMS.into_iter().zip([1.0, 1.0, 0.0]) {
                let choices = UpdatedSphChoices {
                    density: 1.3,
                    kernel,
                    radius,
                    momentum,
                    density_evolution,
                    ..UpdatedSphChoices::default()
                };
                let found = at_the_end(&updated(crystal::<1>(LatticeKind::Chain), choices));
                // With density summation the density is the sum.
                let ratio = match density_evolution {
                    DensityEvolution::Continuity => 1.0,
                    DensityEvolution::Summation => density / summed_density(radius, stretch),
                };
                let expected = factor * expected * ratio * ratio;
                let difference = (found - expected).abs();
                assert!(
                    difference < 1e-10 * (1.0 + expected.abs()),
                    "{momentum:?} {found} {expected}"
                );
            }
        }
        // In Galerkin integration the stress of a particle exerts no force on that particle; in SPH this term is half of the force.
        let choices = KernelChoices {
            density: 1.3,
            kernel,
            radius,
            approximation: Approximation::Raw,
            frame: onset::method::Frame::Eulerian,
            ..KernelChoices::default()
        };
        let chain = crystal::<1>(LatticeKind::Chain);
        let galerkin = KernelScheme::new(chain, CrystalQuadrature::Nodal, choices);
        let found = at_the_end(&galerkin.expect("a scheme"));
        assert!((found - 0.5 * expected).abs() < 1e-10 * (1.0 + expected.abs()));
    }
}

fn summed_density(radius: f64, stretch: f64) -> f64 {
    let kernel = Kernel::QuarticSpline;
    let weight = |n: i32| {
        let x = SVector::<f64, 1>::new(f64::from(n) * stretch);
        let weight = kernel.weight(&x, radius, &SMatrix::identity());
        weight.map_or(0.0, |w| w.value) / kernel.integral::<1>(radius)
    };
    1.3 * (-4..=4).map(weight).sum::<f64>()
}

#[test]
fn alternating_particles_are_unstable_in_tension_at_any_support_and_stable_in_compression() {
    // This includes supports for which the nearest neighbors are closer than the inflection, a third of the radius: the others outweigh them.
    for radius in [1.2, 1.7, 2.4, 2.9, 3.3, 3.9, 4.5] {
        let choices = UpdatedSphChoices {
            radius,
            ..UpdatedSphChoices::default()
        };
        let chain = updated(crystal::<1>(LatticeKind::Chain), choices);
        for (stretch, is_stable) in [(1.02, false), (0.98, true)] {
            let system = waves(&chain, &stretched([stretch, 1.0, 1.0]));
            let found = system.omega_squared(&SVector::from_element(PI))[0].re;
            assert_eq!(
                found > 0.0,
                is_stable,
                "radius {radius}, stretch {stretch}: {found}"
            );
        }
    }
}

#[test]
fn artificial_stress_is_rejected_for_the_difference_form() {
    let choices = UpdatedSphChoices {
        momentum: MomentumForm::Difference,
        artificial_stress: Some(ArtificialStress::default()),
        ..UpdatedSphChoices::default()
    };
    let refused = UpdatedSph::new(crystal::<1>(LatticeKind::Chain), choices);
    assert!(matches!(refused, Err(MethodError::Incompatible { .. })));
    let choices = TotalLagrangianChoices {
        penalty: -1.0,
        ..TotalLagrangianChoices::default()
    };
    let refused = TotalLagrangianSph::new(crystal::<1>(LatticeKind::Chain), choices);
    assert!(matches!(
        refused,
        Err(MethodError::Setting {
            name: "penalty",
            ..
        })
    ));
}

#[cfg(feature = "serde")]
/// Branches of one particle per cell that meet along lines in 3D are complex in tubes around these lines, with a diameter of 1e-4 of the zone.
#[test]
fn flutter_in_pockets_between_grid_points_in_3d_is_found() {
    let choices = UpdatedSphChoices {
        kernel: Kernel::QuinticSpline,
        radius: 2.2306216109299988,
        support_size: SupportSize::Scaled,
        momentum: MomentumForm::Difference,
        density_evolution: DensityEvolution::Continuity,
        corrected: true,
        ..UpdatedSphChoices::default()
    };
    let lattice = Crystal::of(LatticeKind::BodyCenteredCubic, 1.0).expect("a crystal");
    let law = Law::named("holzapfel-gasser-ogden").expect("a law");
    let f = DeformationGradient::new([
        [
            1.1933209001219391,
            -0.07347162517949492,
            0.11996933928583392,
        ],
        [0.14096499390293407, 0.7467591961536217, 0.04684407076513501],
        [
            0.08699654559338789,
            -0.10033809663305861,
            0.8849123279646329,
        ],
    ]);
    let system = updated::<3>(lattice, choices)
        .waves(&*law.build(&[]).expect("a material"), &f.expect("a state"))
        .expect("waves");
    let known = SVector::from([5.441398092702652, 5.448219273883147, 0.7841637658523025]);
    let growth = |k: &SVector<f64, 3>| {
        let rates = system.omega_squared(k).into_iter().map(growth_rate);
        rates.fold(0.0, f64::max)
    };
    assert!(growth(&known) > 7e-4);
    let search = ZoneSearch::of_lattice(*system.crystal().lattice(), 108.0);
    let summary = search.summary_of(&system);
    assert_eq!(summary.stability(), Stability::Flutter);
    let found = growth(&summary.fastest_growing.wave_vector);
    assert!(found > 1e-4 && (found - summary.growth_rate()).abs() < 1e-9 * found.max(1.0));
}

/// Two pockets of flutter are half of a grid step apart, in a state close to the stress-free state.
#[test]
fn the_faster_of_two_adjacent_pockets_of_flutter_is_found() {
    let choices = UpdatedSphChoices {
        radius: 2.04,
        corrected: true,
        corrected_forces: true,
        momentum: MomentumForm::Mean,
        density_evolution: DensityEvolution::Summation,
        support_size: SupportSize::Scaled,
        ..UpdatedSphChoices::default()
    };
    let particles = crystal::<2>(LatticeKind::Square)
        .supercell([2, 2])
        .and_then(|cell| cell.perturbed(0.05, 64))
        .expect("a crystal");
    let law = Law::named("ogden")
        .expect("a law")
        .build(&[])
        .expect("its defaults");
    let scheme = updated(particles, choices);
    let speed = speed_squared(&scheme, &*law).expect("a speed");
    let system = scheme
        .waves(
            &*law,
            &stretched([1.00001, 1.0 - 0.49793e-5, 1.0 - 0.49793e-5]),
        )
        .expect("waves");
    let growth = |k: &SVector<f64, 2>| {
        let rates = system.omega_squared(k).into_iter().map(growth_rate);
        rates.fold(0.0, f64::max)
    };
    let known = growth(&SVector::from([0.7078815496568147, -0.09631763122771264]));
    assert!(known > 3.4e-6, "{known}");
    let search = ZoneSearch::of_lattice(*system.crystal().lattice(), speed);
    let found = search.summary_of(&system).growth_rate();
    assert!(found > 0.99 * known, "{found} {known}");
}

#[test]
fn choices_are_serialized_with_the_documented_names() {
    let choices = UpdatedSphChoices {
        momentum: MomentumForm::Difference,
        density_evolution: DensityEvolution::Summation,
        artificial_stress: Some(ArtificialStress::default()),
        ..UpdatedSphChoices::default()
    };
    let written = serde_json::to_value(&choices).expect("a value");
    assert_eq!(written["momentum"], "difference");
    assert_eq!(written["density-evolution"], "summation");
    assert_eq!(written["artificial-stress"]["exponent"], 4.0);
    assert_eq!(written["velocity-smoothing"], 0.0);
    let read: UpdatedSphChoices = serde_json::from_value(written).expect("choices");
    assert_eq!(read, choices);
    let unknown = serde_json::json!({ "penality": 1.0 });
    assert!(serde_json::from_value::<TotalLagrangianChoices>(unknown).is_err());
    let short = serde_json::json!({ "penalty": 2.0, "corrected": false });
    let read: TotalLagrangianChoices = serde_json::from_value(short).expect("choices");
    assert_eq!(
        (read.penalty, read.corrected, read.radius),
        (2.0, false, 2.0)
    );
}
