//! Kernel Galerkin methods on crystals, compared with the closed forms on Bravais lattices, and on crystals without closed forms.

use crate::battery::{
    assert_equilibrium, assert_long_waves_are_those_of_the_material, assert_scheme,
    assert_translations_are_free, assert_waves_are_those_of_a_patch,
};
use crate::random::Random;
use nalgebra::SVector;
use onset::approximation::Approximation;
use onset::bloch::dynamical_matrix;
use onset::kernel::Kernel;
use onset::kinematics::DeformationGradient;
use onset::lattice::{BravaisLattice, Crystal, LatticeKind};
use onset::material::ModifiedMooneyRivlin;
use onset::method::{Frame, KernelMethodChoices, Method, SupportSize};
use onset::quadrature::Quadrature;
use onset::scheme::Discretization;
use onset::scheme::kernel::{CrystalQuadrature, KernelChoices, KernelScheme};

fn lattice<const D: usize>(kind: LatticeKind) -> BravaisLattice<D> {
    kind.lattice(1.0).expect("a lattice")
}

fn plane(f: [[f64; 2]; 2]) -> DeformationGradient {
    DeformationGradient::plane_strain(f, 1.0).expect("a deformation")
}

fn rest() -> DeformationGradient {
    DeformationGradient::identity()
}

fn nodal<const D: usize>(crystal: Crystal<D>, choices: KernelChoices) -> KernelScheme<D> {
    KernelScheme::new(crystal, CrystalQuadrature::Nodal, choices).expect("a scheme")
}

/// Scheme of a method on the crystal of its lattice.
fn scheme_of<const D: usize>(method: &Method<D>) -> KernelScheme<D> {
    let discretization = method.choices();
    let points = method.quadrature_points().iter();
    let points = points.map(|point| (point.place, point.volume)).collect();
    let choices = KernelChoices {
        density: discretization.density,
        kernel: discretization.kernel,
        radius: method.support_radius(),
        approximation: discretization.approximation,
        frame: discretization.frame,
        support_size: discretization.support_size,
    };
    let crystal = Crystal::of_lattice(*method.lattice());
    KernelScheme::new(crystal, CrystalQuadrature::Points(points), choices).expect("a scheme")
}

#[track_caller]
fn assert_same_waves<const D: usize>(discretization: KernelMethodChoices, f: &DeformationGradient) {
    let material = ModifiedMooneyRivlin::default();
    let method = Method::<D>::new(discretization.clone()).expect("a method");
    let closed = dynamical_matrix(&method, &material, f).expect("a state");
    let system = scheme_of(&method).waves(&material, f).expect("a state");
    let scale = system.stiffness().magnitude() / method.particle_mass();
    let mut random = Random::new(11);
    for _ in 0..4 {
        let k = SVector::<f64, D>::from_fn(|_, _| 4.0 * random.number());
        let (expected, found) = (closed.at(&k), system.dynamical_matrix_at(&k));
        let apart = (found - expected).map(|z| z.norm()).amax();
        assert!(
            apart < 1e-11 * scale,
            "{discretization:?}: {apart:e} of {scale}"
        );
    }
}

fn discretizations(kind: LatticeKind) -> Vec<KernelMethodChoices> {
    let mut all = Vec::new();
    for approximation in Approximation::ALL {
        for quadrature in [
            Quadrature::Nodal,
            Quadrature::StressPoints,
            Quadrature::StressPointsOnly,
        ] {
            let layouts = [
                (Frame::Lagrangian, SupportSize::Fixed),
                (Frame::Eulerian, SupportSize::Fixed),
                (Frame::Eulerian, SupportSize::Scaled),
                (Frame::Eulerian, SupportSize::Convected),
            ];
            for (frame, support_size) in layouts {
                all.push(KernelMethodChoices {
                    lattice: kind,
                    support: if approximation.degree() > Some(1) {
                        3.4
                    } else {
                        2.3
                    },
                    density: 1.7,
                    approximation,
                    quadrature,
                    frame,
                    support_size,
                    ..KernelMethodChoices::default()
                });
            }
        }
    }
    all
}

#[test]
fn on_bravais_lattices_dual_numbers_and_closed_forms_give_the_same_waves() {
    for f in [[[1.15, 0.2], [-0.1, 0.9]], [[0.8, 0.0], [0.1, 1.3]]] {
        for kind in [LatticeKind::Square, LatticeKind::Hexagonal] {
            for discretization in discretizations(kind) {
                assert_same_waves::<2>(discretization, &plane(f));
            }
        }
    }
    let stretched = DeformationGradient::from_stretches([1.2, 0.9, 1.05]).expect("a state");
    for discretization in discretizations(LatticeKind::Chain) {
        assert_same_waves::<1>(discretization, &stretched);
    }
}

#[test]
fn dual_numbers_and_closed_forms_give_the_same_waves_for_every_kernel() {
    for kernel in Kernel::ALL {
        let discretization = KernelMethodChoices {
            kernel,
            support: 2.3,
            frame: Frame::Eulerian,
            ..KernelMethodChoices::default()
        };
        assert_same_waves::<2>(discretization, &plane([[1.15, 0.2], [-0.1, 0.9]]));
    }
}

#[test]
fn kernel_methods_on_bravais_lattices_pass_the_scheme_checks() {
    let material = ModifiedMooneyRivlin::default();
    let cubic = BravaisLattice::<3>::new(nalgebra::Matrix3::identity()).expect("a lattice");
    let f = DeformationGradient::from_stretches([1.1, 0.9, 1.05]).expect("a state");
    let sheared = plane([[1.1, 0.2], [0.0, 0.95]]);
    for frame in [Frame::Lagrangian, Frame::Eulerian] {
        for approximation in Approximation::ALL {
            let is_of_high_degree = approximation.degree() > Some(1);
            let choices = KernelChoices {
                radius: if is_of_high_degree { 3.1 } else { 1.6 },
                approximation,
                frame,
                support_size: SupportSize::Scaled,
                ..KernelChoices::default()
            };
            let chain = Crystal::of_lattice(lattice::<1>(LatticeKind::Chain));
            assert_scheme(&nodal(chain, choices.clone()), &material, &f);
            if is_of_high_degree {
                continue;
            }
            let square = Crystal::of_lattice(lattice::<2>(LatticeKind::Square));
            assert_scheme(&nodal(square, choices.clone()), &material, &sheared);
            if approximation == Approximation::Mls {
                assert_scheme(&nodal(Crystal::of_lattice(cubic), choices), &material, &f);
            }
        }
    }
}

#[test]
fn kernel_methods_on_the_honeycomb_pass_the_scheme_checks_in_equilibrium() {
    let material = ModifiedMooneyRivlin::default();
    let points = vec![
        (SVector::from([0.0, 0.0]), 0.5),
        (SVector::from([1.0 / 3.0, 1.0 / 3.0]), 0.5),
        (SVector::from([2.0 / 3.0, 2.0 / 3.0]), 1.0),
    ];
    for frame in [Frame::Lagrangian, Frame::Eulerian] {
        for quadrature in [
            CrystalQuadrature::Nodal,
            CrystalQuadrature::Points(points.clone()),
        ] {
            let choices = KernelChoices {
                radius: 2.1,
                frame,
                ..KernelChoices::default()
            };
            let honeycomb = Crystal::<2>::of(LatticeKind::Honeycomb, 1.0).expect("a crystal");
            let scheme = KernelScheme::new(honeycomb, quadrature, choices).expect("a scheme");
            // All particles have three-fold axes: an equibiaxial stress causes no force.
            assert_equilibrium(&scheme, &material, &plane([[1.1, 0.0], [0.0, 1.1]]));
            let sheared = plane([[1.1, 0.2], [0.0, 0.95]]);
            assert_waves_are_those_of_a_patch(&scheme, &material, &sheared);
            assert_translations_are_free(&scheme, &material, &sheared);
        }
    }
}

/// Eigenvalues at all wave vectors of the primitive cell that a supercell folds onto one wave vector.
fn folded<const D: usize>(
    scheme: &dyn Discretization<D>,
    f: &DeformationGradient,
    k: &SVector<f64, D>,
) -> Vec<f64> {
    let system = scheme
        .waves(&ModifiedMooneyRivlin::default(), f)
        .expect("a state");
    let reciprocal = scheme.crystal().lattice().reciprocal();
    let halves = 1 << D;
    let mut values: Vec<f64> = (0..halves)
        .flat_map(|n| {
            let half = SVector::<f64, D>::from_fn(|i, _| 0.5 * f64::from((n >> i) & 1));
            system.omega_squared(&(k + reciprocal * half))
        })
        .map(|z| z.re)
        .collect();
    values.sort_by(f64::total_cmp);
    values
}

#[test]
fn a_supercell_has_the_folded_spectrum_of_the_primitive_cell() {
    let f = plane([[1.1, 0.15], [0.0, 0.95]]);
    let k = SVector::from([0.7, -0.4]);
    for frame in [Frame::Lagrangian, Frame::Eulerian] {
        let choices = KernelChoices {
            frame,
            radius: 2.2,
            ..KernelChoices::default()
        };
        let square = Crystal::of_lattice(lattice::<2>(LatticeKind::Square));
        let large = square.supercell([2, 2]).expect("a crystal");
        let expected = folded(&nodal(square, choices.clone()), &f, &k);
        let system = nodal(large, choices)
            .waves(&ModifiedMooneyRivlin::default(), &f)
            .expect("a state");
        let found = system.omega_squared(&k);
        assert_eq!((found.len(), expected.len()), (8, 8));
        let scale = expected[7];
        for (found, expected) in found.iter().zip(&expected) {
            assert!(
                (found.re - expected).abs() < 1e-9 * scale,
                "{found} {expected}"
            );
        }
    }
}

#[test]
fn a_supercell_of_a_cubic_lattice_has_its_folded_spectrum() {
    let f = DeformationGradient::from_stretches([1.1, 0.9, 1.05]).expect("a state");
    let k = SVector::from([0.7, -0.4, 0.2]);
    let choices = KernelChoices {
        frame: Frame::Eulerian,
        radius: 1.5,
        ..KernelChoices::default()
    };
    let cubic = BravaisLattice::<3>::new(nalgebra::Matrix3::identity()).expect("a lattice");
    let cubic = Crystal::of_lattice(cubic);
    let expected = folded(&nodal(cubic.clone(), choices.clone()), &f, &k);
    let large = nodal(cubic.supercell([2, 2, 2]).expect("a crystal"), choices);
    let system = large
        .waves(&ModifiedMooneyRivlin::default(), &f)
        .expect("a state");
    for (found, expected) in system.omega_squared(&k).iter().zip(&expected) {
        assert!(
            (found.re - expected).abs() < 1e-9 * expected.abs().max(1.0),
            "{found} {expected}"
        );
    }
}

#[test]
fn long_waves_of_linearly_complete_functions_on_bravais_lattices_agree_with_the_material() {
    let choices = KernelChoices {
        approximation: Approximation::Mls,
        ..KernelChoices::default()
    };
    let hexagonal = Crystal::of_lattice(lattice::<2>(LatticeKind::Hexagonal));
    let scheme = nodal(hexagonal, choices);
    let f = plane([[1.1, 0.2], [0.0, 0.95]]);
    let material = ModifiedMooneyRivlin::default();
    assert_long_waves_are_those_of_the_material(&scheme, &material, &f, 1e-10);
}

#[test]
fn omega_squared_of_zero_energy_modes_of_nodal_integration_is_quadratic_in_the_perturbation() {
    let square = Crystal::of_lattice(lattice::<2>(LatticeKind::Square));
    let large = square.supercell([2, 2]).expect("a crystal");
    let choices = KernelChoices {
        approximation: Approximation::Mls,
        radius: 1.6,
        ..KernelChoices::default()
    };
    let spectrum = |amplitude: f64| {
        let irregular = large.perturbed(amplitude, 3).expect("a crystal");
        let scheme = nodal(irregular, choices.clone());
        let system = scheme
            .waves(&ModifiedMooneyRivlin::default(), &rest())
            .expect("a state");
        let values = system.omega_squared(&SVector::zeros());
        values.iter().map(|z| z.re).collect::<Vec<_>>()
    };
    // Modes at the origin of the folded zone: two translations, and the modes of the three corners.
    let regular = spectrum(0.0);
    assert!(
        regular
            .iter()
            .all(|omega_squared| omega_squared.abs() < 1e-10)
    );
    let (small, twice) = (spectrum(0.001), spectrum(0.002));
    assert!(
        small[..2]
            .iter()
            .all(|omega_squared| omega_squared.abs() < 1e-10)
    );
    for (small, twice) in small[2..].iter().zip(&twice[2..]) {
        assert!(
            *small > 0.0 && (twice / small - 4.0).abs() < 0.1,
            "{small} {twice}"
        );
    }
    // With offsets of up to a tenth of the spacing, omega^2 of the softest mode is still less than a hundredth of omega^2 of a shear wave
    // of its length, mu pi^2 / rho.
    let shear = 2.0 * (0.1256 + 0.01012) * std::f64::consts::PI.powi(2);
    let softest = spectrum(0.1)[2];
    assert!(
        softest > 1e-6 && softest < 0.01 * shear,
        "{softest} of {shear}"
    );
}

#[test]
fn in_three_dimensions_dual_numbers_and_closed_forms_give_the_same_waves() {
    let sheared = [[1.1, 0.12, -0.05], [0.04, 0.93, 0.08], [0.07, -0.03, 1.06]];
    let sheared = DeformationGradient::new(sheared).expect("a deformation");
    for approximation in [Approximation::Shepard, Approximation::Mls] {
        let discretization = KernelMethodChoices {
            lattice: LatticeKind::FaceCenteredCubic,
            support: 1.6,
            approximation,
            quadrature: Quadrature::Nodal,
            frame: Frame::Eulerian,
            ..KernelMethodChoices::default()
        };
        assert_same_waves::<3>(discretization, &sheared);
    }
}

#[test]
fn waves_of_closest_packing_and_diamond_agree_with_a_patch() {
    let material = ModifiedMooneyRivlin::default();
    let packed = Crystal::<3>::of(LatticeKind::HexagonalClosePacked, 1.0).expect("a crystal");
    let diamond = Crystal::<3>::of(LatticeKind::Diamond, 1.0).expect("a crystal");
    let equal = DeformationGradient::from_stretches([1.05; 3]).expect("a state");
    let sheared = [[1.1, 0.1, 0.0], [0.0, 0.95, 0.05], [0.0, 0.0, 1.0]];
    let sheared = DeformationGradient::new(sheared).expect("a state");
    for (crystal, radius) in [(packed, 1.2), (diamond, 1.2)] {
        let choices = KernelChoices {
            radius,
            frame: Frame::Eulerian,
            support_size: SupportSize::Convected,
            ..KernelChoices::default()
        };
        let scheme = nodal(crystal, choices);
        // An equitriaxial stress exerts no force on a particle with three-fold axes.
        assert_equilibrium(&scheme, &material, &equal);
        assert_waves_are_those_of_a_patch(&scheme, &material, &sheared);
        assert_translations_are_free(&scheme, &material, &sheared);
    }
}
