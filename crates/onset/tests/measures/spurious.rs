//! Spurious modes of a discretization.

use crate::{method, nodal, on_crystal};
use nalgebra::SVector;
use onset::approximation::Approximation;
use onset::continuum::Stiffness;
use onset::kinematics::DeformationGradient;
use onset::lattice::{BrillouinZone, Crystal, LatticeKind};
use onset::material::{Hyperelastic, Law, ModifiedMooneyRivlin};
use onset::measures::{Extent, SpuriousMode, SpuriousModes, spurious_modes};
use onset::method::KernelMethodChoices;
use onset::quadrature::Quadrature;
use onset::scheme::sph::{TotalLagrangianChoices, TotalLagrangianSph};
use onset::scheme::{
    BondModel, Discretization, MethodChoices, Peridynamics, PeridynamicsChoices, ZeroEnergyControl,
};
use onset::verdict::Survey;
use std::f64::consts::TAU;

fn found<const D: usize>(scheme: &dyn Discretization<D>, threshold: f64) -> SpuriousModes<D> {
    let material = ModifiedMooneyRivlin::default();
    let survey = Survey::new(scheme, &material).expect("a survey");
    spurious_modes(&survey, threshold).expect("modes")
}

/// Wave vectors of zero-energy modes in units of the reciprocal vectors, with coordinates from 0 to 1; of `k` and `-k` only the first is returned.
fn zeros<const D: usize>(
    scheme: &dyn Discretization<D>,
    modes: &SpuriousModes<D>,
) -> Vec<[f64; D]> {
    let vectors = scheme.crystal().lattice().vectors();
    let fractional = |k: SVector<f64, D>| -> [f64; D] {
        let x = vectors.transpose() * k / TAU;
        std::array::from_fn(|i| {
            let rest = (x[i] - x[i].floor()) % 1.0;
            if 1.0 - rest < 1e-6 {
                0.0
            } else {
                (rest * 1e6).round() / 1e6
            }
        })
    };
    let of = |mode: &SpuriousMode<D>| {
        let (plus, minus) = (fractional(mode.wave_vector), fractional(-mode.wave_vector));
        if plus < minus { plus } else { minus }
    };
    let mut all: Vec<_> = modes.modes.iter().filter(|m| m.is_zero()).map(of).collect();
    all.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
    all
}

#[test]
fn nodal_integration_on_squares_has_three_zero_energy_wave_vectors() {
    let method = method::<2>(nodal(LatticeKind::Square));
    let modes = found(&method, 0.5);
    assert_eq!(zeros(&method, &modes), [[0.0, 0.5], [0.5, 0.0], [0.5, 0.5]]);
    assert!(modes.modes.iter().all(|mode| mode.nullity <= 2));
    assert_eq!(modes.weakest, Some(0.0));
    assert_eq!(modes.zero_extent, Some(Extent::Point));
}

#[test]
fn nodal_integration_on_the_hexagonal_lattice_has_zero_energy_modes_at_m_and_k() {
    // The sum of the odd gradients vanishes at the three points M by inversion, and at K by the threefold axis. No minimum lies between these points.
    let method = method::<2>(nodal(LatticeKind::Hexagonal));
    let modes = found(&method, 0.5);
    let third = 0.333333;
    let expected = [[0.0, 0.5], [third, 2.0 * third], [0.5, 0.0], [0.5, 0.5]];
    assert_eq!(modes.modes.len(), 4, "{modes:?}");
    for (found, expected) in zeros(&method, &modes).iter().zip(expected) {
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 2e-6, "{found} for {expected}");
        }
    }
}

#[test]
fn nodal_integration_has_seventeen_zero_energy_wave_vectors_on_cubes_and_one_on_a_chain() {
    // The gradient vanishes where sin x (w1 + 2 w2 (b + c) + 4 w3 b c) = 0 and its cyclic permutations hold. Here a, b, c are the cosines, and
    // w1, w2, w3 the values of W'/q at the three distances. With all sines zero there are 7 wave vectors. With one sine zero (cosine -1) there are 6, at
    // a = b = -0.786. With no sine zero there are 4, at a = b = c = -0.898.
    let cubes = method::<3>(nodal(LatticeKind::SimpleCubic));
    let modes = found(&cubes, 0.5);
    assert_eq!(zeros(&cubes, &modes).len(), 17);
    assert!(modes.modes.iter().all(|mode| mode.nullity == 3));
    let chain = method::<1>(nodal(LatticeKind::Chain));
    let modes = found(&chain, 0.5);
    assert_eq!(zeros(&chain, &modes), [[0.5]]);
    assert_eq!(modes.zero_extent, Some(Extent::Point));
}

#[test]
fn stress_points_leave_weakly_controlled_modes_but_no_zero_energy_modes() {
    let method = method::<2>(KernelMethodChoices {
        quadrature: Quadrature::StressPoints,
        ..nodal(LatticeKind::Hexagonal)
    });
    let modes = found(&method, 0.5);
    assert!(!modes.modes.is_empty());
    assert!(modes.modes.iter().all(|mode| !mode.is_zero()));
    // Brute force on a grid that shares no point with the grid of the search.
    let material = ModifiedMooneyRivlin::default();
    let survey = Survey::new(&method, &material).expect("a survey");
    let stiffness = Stiffness::<2>::at(&material, &DeformationGradient::identity());
    let stiffness = stiffness.expect("a stiffness");
    let mut least = f64::INFINITY;
    for i in 0..97 {
        for j in 0..97 {
            let at = |n: i32| (f64::from(n) + 0.5) / 97.0;
            let k = method.lattice().reciprocal() * SVector::<f64, 2>::new(at(i), at(j));
            let k = survey.search().folded(&k);
            let exact = stiffness.acoustic_tensor(&k).symmetric_eigenvalues().min();
            let found =
                survey.reference().expect("waves").omega_squared(&k)[0].re * method.density();
            least = least.min((found / exact).sqrt());
        }
    }
    let lowest = modes.weakest.expect("a wave");
    assert!(lowest <= least + 1e-12, "{lowest} {least}");
    assert!(lowest > 0.98 * least, "{lowest} {least}");
}

#[test]
fn minima_are_listed_once_and_are_minima() {
    for kind in [LatticeKind::Hexagonal, LatticeKind::Square] {
        let method = method::<2>(KernelMethodChoices {
            quadrature: Quadrature::StressPoints,
            ..nodal(kind)
        });
        let material = ModifiedMooneyRivlin::default();
        let survey = Survey::new(&method, &material).expect("a survey");
        let stiffness = Stiffness::<2>::at(&material, &DeformationGradient::identity());
        let stiffness = stiffness.expect("a stiffness");
        let ratio = |k: SVector<f64, 2>| {
            let k = survey.search().folded(&k);
            let exact = stiffness.acoustic_tensor(&k).symmetric_eigenvalues().min();
            survey.reference().expect("waves").omega_squared(&k)[0].re * method.density() / exact
        };
        let modes = spurious_modes(&survey, 0.9).expect("modes").modes;
        assert!(!modes.is_empty());
        for (n, mode) in modes.iter().enumerate() {
            let own = mode.relative_frequency * mode.relative_frequency;
            for step in 0..12 {
                let (sine, cosine) = (TAU * f64::from(step) / 12.0).sin_cos();
                let beside = mode.wave_vector + SVector::<f64, 2>::new(cosine, sine) * 1e-3;
                assert!(ratio(beside) >= own * (1.0 - 1e-7), "{kind:?} {mode:?}");
            }
            for other in &modes[..n] {
                let apart = (mode.wave_vector - other.wave_vector).norm();
                let opposite = (mode.wave_vector + other.wave_vector).norm();
                assert!(apart.min(opposite) > 1e-3, "{mode:?} {other:?}");
            }
        }
    }
}

#[test]
fn a_larger_cell_has_the_same_modes_in_the_reference_configuration() {
    // Two by two squares: the three wave vectors with two modes each are folded to k = 0, where no displacement has energy.
    let cell = on_crystal::<2>(&KernelMethodChoices {
        cells: 2,
        ..nodal(LatticeKind::Square)
    });
    let modes = found(&cell, 0.05).modes;
    assert_eq!(modes.len(), 1);
    assert_eq!(modes[0].wave_vector.norm(), 0.0);
    assert_eq!(modes[0].nullity, 6);
    assert_eq!(modes[0].relative_frequency, 0.0);
    let total: SVector<_, 2> = modes[0].displacements.iter().sum();
    assert!(total.iter().all(|z| z.norm() < 1e-9), "no translation");
}

/// The wave of alternating neighbors has `k = 0` if the neighbors lie in one cell. There the lowest frequencies belong to translations.
#[test]
fn weakly_controlled_modes_are_also_found_in_the_reference_configuration() {
    let material = ModifiedMooneyRivlin::default();
    let of_cell = |penalty: f64, cells: usize| {
        let square = Crystal::of(LatticeKind::Square, 1.0).expect("a crystal");
        let crystal = square.supercell([cells; 2]).expect("a supercell");
        let choices = TotalLagrangianChoices {
            penalty,
            ..TotalLagrangianChoices::default()
        };
        let scheme = TotalLagrangianSph::<2>::new(crystal, choices).expect("a method");
        let survey = Survey::new(&scheme, &material).expect("a survey");
        spurious_modes(&survey, 0.05).expect("modes")
    };
    for penalty in [1e-6, 1e-4, 0.02] {
        let one = of_cell(penalty, 1).weakest.expect("a wave");
        assert!(0.0 < one && one < 0.05, "{one}");
        // With more cells the same wave has another wave vector.
        for cells in [2, 3, 4] {
            let found = of_cell(penalty, cells);
            let difference = found.weakest.expect("a wave") / one - 1.0;
            assert!(difference.abs() < 1e-6, "{penalty} {cells} {difference}");
        }
        let four = of_cell(penalty, 2);
        let at_rest = &four.modes[0];
        assert!(at_rest.wave_vector.norm() < 1e-9 && !at_rest.is_zero());
        assert_eq!(Some(at_rest.relative_frequency), four.weakest);
        let total: SVector<_, 2> = at_rest.displacements.iter().sum();
        assert!(total.iter().all(|z| z.norm() < 1e-6), "no translation");
    }
    // A sufficient penalty leaves no weak modes, in the larger cell either.
    assert!(of_cell(0.3, 1).modes.is_empty() && of_cell(0.3, 2).modes.is_empty());
}

/// Weakest wave of a survey, with its ratio of frequencies.
fn weakest<const D: usize>(
    scheme: &dyn Discretization<D>,
    material: &dyn Hyperelastic,
) -> Option<(f64, SVector<f64, D>)> {
    let survey = Survey::new(scheme, material).expect("a survey");
    let mode = survey.weakest()?;
    let ratio = mode.relative_frequency_squared.max(0.0).sqrt();
    Some((ratio, mode.wave_vector))
}

#[test]
fn the_weakest_wave_of_a_survey_is_the_weakest_mode_in_all_cells() {
    let material = ModifiedMooneyRivlin::default();
    for cells in [1, 2, 3, 4] {
        let square = Crystal::of(LatticeKind::Square, 1.0).expect("a crystal");
        let crystal = square.supercell([cells; 2]).expect("a supercell");
        let choices = TotalLagrangianChoices {
            penalty: 0.02,
            ..TotalLagrangianChoices::default()
        };
        let scheme = TotalLagrangianSph::<2>::new(crystal, choices).expect("a method");
        let survey = Survey::new(&scheme, &material).expect("a survey");
        let searched = spurious_modes(&survey, 0.05).expect("modes");
        let lowest = searched.weakest.expect("a wave");
        let (ratio, wave) = weakest(&scheme, &material).expect("a mode");
        assert_eq!(ratio, lowest, "{cells}");
        // Neighbors alternate along one axis, by choice the first.
        let shape = wave / TAU;
        let expected = SVector::from([0.5, 0.0]);
        assert!((shape - expected).amax() < 1e-9, "{cells}: {shape}");
        // The search reports the same wave.
        let wave = searched.modes[0].wave.map(|k| k.abs() / TAU);
        assert!(
            (wave.max() - 0.5).abs() < 1e-9 && wave.min() < 1e-9,
            "{cells}: {wave}"
        );
    }
}

/// With stress points on hexagons the weakest wave is not a wave of alternating neighbors.
#[test]
fn the_weakest_wave_of_a_survey_is_followed_to_its_bottom() {
    for cells in [1, 2, 3] {
        let choices = KernelMethodChoices {
            support: 1.6,
            cells,
            quadrature: Quadrature::StressPoints,
            ..KernelMethodChoices::default()
        };
        let choices = MethodChoices::Kernel(Box::new(choices));
        let scheme = choices.discretization::<2>().expect("a method");
        let searched = found(&*scheme, 0.5).weakest.expect("a wave");
        let material = ModifiedMooneyRivlin::default();
        let (ratio, _) = weakest(&*scheme, &material).expect("a mode");
        assert!(
            (ratio / searched - 1.0).abs() < 1e-4,
            "{cells}: {ratio} {searched}"
        );
    }
}

/// For forces without an energy all modes of a small cell are evaluated: the weakest mode is not the lowest mode above the translations.
#[test]
fn the_weakest_zero_energy_mode_is_the_mode_of_the_undisturbed_lattice() {
    let material = ModifiedMooneyRivlin::default();
    let of_cell = |cells: usize, perturbation: f64| {
        let square = Crystal::of(LatticeKind::Square, 1.0).expect("a crystal");
        let crystal = square.supercell([cells; 2]).expect("a supercell");
        let crystal = crystal.perturbed(perturbation, 1).expect("a crystal");
        let choices = PeridynamicsChoices {
            model: BondModel::Correspondence {
                control: ZeroEnergyControl::Penalty { coefficient: 0.02 },
            },
            // No particle lies on the horizon, and no particle leaves it by the offsets.
            horizon: 2.5,
            ..PeridynamicsChoices::default()
        };
        let scheme = Peridynamics::<2>::new(crystal, choices).expect("a method");
        weakest(&scheme, &material).expect("a mode").0
    };
    let one = of_cell(1, 0.0);
    for perturbation in [0.0, 1e-5] {
        let ratio = of_cell(2, perturbation) / one;
        assert!((ratio - 1.0).abs() < 1e-3, "{perturbation}: {ratio}");
    }
}

/// At `k = 0` translations also have the frequency of zero-energy modes, and an eigenvalue solver mixes them.
#[test]
fn zero_energy_modes_are_the_weakest_apart_from_translations() {
    let material = ModifiedMooneyRivlin::default();
    for cells in [1, 2] {
        let choices = KernelMethodChoices {
            cells,
            ..nodal(LatticeKind::Square)
        };
        let scheme = on_crystal::<2>(&choices);
        let (ratio, wave) = weakest(&scheme, &material).expect("a mode");
        assert!(ratio < 1e-6, "{cells}: {ratio}");
        let shape = wave.map(|k| k.abs() / TAU);
        assert!((shape.max() - 0.5).abs() < 1e-9, "{cells}: {shape}");
    }
}

/// Only one polarization is free: particles that move across the bonds to their nearest neighbors.
#[test]
fn zero_energy_modes_of_one_polarization_are_the_weakest_apart_from_translations() {
    fn ratio<const D: usize>(kind: LatticeKind, cells: usize) -> f64 {
        let crystal = Crystal::of(kind, 1.0).expect("a crystal");
        let crystal = crystal.supercell([cells; D]).expect("a supercell");
        let choices = PeridynamicsChoices {
            horizon: 1.0,
            ..PeridynamicsChoices::default()
        };
        let scheme = Peridynamics::<D>::new(crystal, choices).expect("a method");
        let material = ModifiedMooneyRivlin::default();
        weakest(&scheme, &material).expect("a mode").0
    }
    for cells in [1, 2] {
        assert!(ratio::<2>(LatticeKind::Square, cells) < 1e-6, "{cells}");
        assert!(
            ratio::<3>(LatticeKind::SimpleCubic, cells) < 1e-6,
            "{cells}"
        );
    }
}

/// A translation of disordered particles resembles a short wave, which is a translation on the lattice.
#[test]
fn translations_of_disordered_cells_are_not_short_waves() {
    let material = ModifiedMooneyRivlin::default();
    for perturbation in [0.01, 0.1, 0.25] {
        let square = Crystal::of(LatticeKind::Square, 1.0).expect("a crystal");
        let crystal = square.supercell([3; 2]).expect("a supercell");
        let crystal = crystal.perturbed(perturbation, 1).expect("a crystal");
        let choices = TotalLagrangianChoices {
            penalty: 0.3,
            ..TotalLagrangianChoices::default()
        };
        let scheme = TotalLagrangianSph::<2>::new(crystal, choices).expect("a method");
        let searched = found(&scheme, 0.5).weakest.expect("a wave");
        let (ratio, _) = weakest(&scheme, &material).expect("a mode");
        assert!(
            searched > 0.03 && ratio > 0.03,
            "{perturbation}: {searched} {ratio}"
        );
    }
}

/// Shear waves of a fluid have frequency zero, so that no mode is compared with their rounding errors.
#[test]
fn modes_are_not_compared_with_waves_of_zero_energy() {
    let choices = KernelMethodChoices::default();
    let scheme = method::<2>(choices);
    for kappa in [3.0, 99.0, 100.0] {
        let fluid = law("tait", &[("mu", 0.0), ("kappa", kappa)]);
        assert_eq!(weakest(&scheme, &*fluid), None);
        let survey = Survey::new(&scheme, &*fluid).expect("a survey");
        let modes = spurious_modes(&survey, 0.5).expect("modes");
        let is_weak = |mode: &SpuriousMode<2>| !mode.is_zero();
        assert!(!modes.modes.iter().any(is_weak), "{kappa}");
        assert_eq!(modes.weakest, None);
    }
}

/// Waves along the short side of a long cell are much shorter than those across it.
#[test]
fn short_waves_of_elongated_cells_are_found() {
    let of_cell = |aspect: f64, cells: u32| {
        let choices = KernelMethodChoices {
            lattice: LatticeKind::Rectangular,
            aspect,
            cells,
            ..KernelMethodChoices::default()
        };
        let crystal = choices.crystal::<2>().expect("a crystal");
        let choices = TotalLagrangianChoices {
            radius: 1.2 * aspect.max(1.0),
            penalty: 0.01,
            ..TotalLagrangianChoices::default()
        };
        let scheme = TotalLagrangianSph::new(crystal, choices).expect("a method");
        found(&scheme, 0.5).weakest.expect("a wave")
    };
    for (aspect, largest) in [(3.0, 3), (10.0, 2), (0.4, 2)] {
        let one = of_cell(aspect, 1);
        for cells in 2..=largest {
            let difference = of_cell(aspect, cells) / one - 1.0;
            assert!(difference.abs() < 1e-4, "{aspect} {cells}: {difference}");
        }
    }
}

/// Gauss points belong to the cells between particles, for any number of cells in a supercell.
#[test]
fn a_quadrature_rule_gives_the_same_modes_in_a_larger_cell() {
    let of_cells = |cells: u32| KernelMethodChoices {
        quadrature: Quadrature::Gauss,
        approximation: Approximation::Mls,
        cells,
        ..nodal(LatticeKind::Square)
    };
    let one = found(&method::<2>(of_cells(1)), 0.5);
    for cells in [2, 3] {
        let several = MethodChoices::Kernel(Box::new(of_cells(cells)));
        let several = several.discretization::<2>().expect("a method");
        let several = found(&*several, 0.5);
        assert_eq!(several.zero_extent, one.zero_extent);
        let [several, one] = [several.weakest, one.weakest].map(|own| own.expect("a wave"));
        let difference = several / one - 1.0;
        assert!(difference.abs() < 1e-6, "{cells}: {difference}");
    }
}

#[test]
fn relative_motion_of_two_particles_in_a_cell_can_have_zero_energy() {
    // Nodal integration on a honeycomb: the three neighbors of a particle have threefold symmetry, and their gradients cancel.
    let honeycomb = on_crystal::<2>(&nodal(LatticeKind::Honeycomb));
    let modes = found(&honeycomb, 0.5).modes;
    assert_eq!(zeros(&honeycomb, &found(&honeycomb, 0.5)), [[0.0, 0.0]]);
    assert_eq!(modes[0].nullity, 2);
    let [first, second] = &modes[0].displacements[..] else {
        panic!("two particles");
    };
    assert!((first + second).iter().all(|z| z.norm() < 1e-9));
    // Slow long waves are not a separate mode.
    let close = modes.iter().filter(|mode| mode.wave_vector.norm() < 0.1);
    assert_eq!(close.count(), 1);
}

fn law(name: &str, parameters: &[(&str, f64)]) -> Box<dyn Hyperelastic> {
    let law = Law::named(name).expect("a law of the library");
    law.build(parameters).expect("admissible parameters")
}

/// Lowest relative frequency of a dense search over the closed zone: in its interior, and along each of its edges, where opposite edges are different
/// waves of the material.
fn densely<const D: usize>(survey: &Survey<'_, D>, steps: usize) -> f64 {
    let lattice = *survey.discretization().crystal().lattice();
    let zone = BrillouinZone::new(lattice);
    let stiffness = Stiffness::<D>::at(survey.material(), &DeformationGradient::identity());
    let stiffness = stiffness.expect("a stiffness");
    let ratio = |k: &SVector<f64, D>| {
        let tensor = stiffness.acoustic_tensor(k);
        let tensor = nalgebra::DMatrix::from_fn(D, D, |i, j| tensor[(i, j)]);
        let exact = tensor.symmetric_eigenvalues().min();
        let found = survey.reference().expect("waves").omega_squared(k)[0].re
            * survey.discretization().density();
        (found / exact).max(0.0).sqrt()
    };
    let mut least = f64::INFINITY;
    for index in 0..steps.pow(D as u32) {
        let mut rest = index;
        let place = SVector::<f64, D>::from_fn(|_, _| {
            let n = rest % steps;
            rest /= steps;
            (n as f64 + 0.37) / steps as f64
        });
        let k = zone.folded(&(lattice.reciprocal() * place));
        least = least.min(ratio(&k));
    }
    let corners = zone.corners();
    for (n, from) in corners.iter().enumerate() {
        let to = &corners[(n + 1) % corners.len()];
        for step in 0..40 * steps {
            let share = step as f64 / (40 * steps) as f64;
            least = least.min(ratio(&(from + (to - from) * share)));
        }
    }
    least
}

#[test]
fn the_weakest_wave_agrees_with_a_dense_search_of_the_closed_zone() {
    let stabilized = |kind| KernelMethodChoices {
        quadrature: Quadrature::NodalStabilized,
        approximation: Approximation::Mls,
        ..nodal(kind)
    };
    let angle = [("angle", 30.0)];
    let cases = [
        (
            "blatz-ko",
            &[][..],
            stabilized(LatticeKind::Hexagonal),
            Some(0.060_910_6),
        ),
        ("blatz-ko", &[], stabilized(LatticeKind::Square), None),
        (
            "saint-venant-orthotropic",
            &angle,
            stabilized(LatticeKind::Hexagonal),
            None,
        ),
        (
            "saint-venant-orthotropic",
            &angle,
            KernelMethodChoices {
                quadrature: Quadrature::StressPoints,
                ..nodal(LatticeKind::Square)
            },
            None,
        ),
    ];
    for (name, parameters, discretization, expected) in cases {
        let material = law(name, parameters);
        let method = method::<2>(discretization);
        let survey = Survey::new(&method, &*material).expect("a survey");
        let weakest = spurious_modes(&survey, 0.5)
            .expect("modes")
            .weakest
            .expect("a wave");
        let least = densely(&survey, 160);
        assert!(
            weakest <= least * (1.0 + 1e-9),
            "{name}: {weakest} above {least}"
        );
        assert!(
            weakest >= least * (1.0 - 1e-3),
            "{name}: {weakest} below {least}"
        );
        if let Some(expected) = expected {
            assert!(
                (weakest - expected).abs() < 1e-7,
                "{weakest} for {expected}"
            );
        }
    }
}

/// With stress points on hexagons the weakest wave lies on a face of the zone, where two images have the same length.
#[test]
fn the_weakest_wave_on_a_face_of_the_zone_is_found() {
    let material = law("blatz-ko", &[]);
    let choices = KernelMethodChoices {
        support: 1.7,
        approximation: Approximation::Mls,
        quadrature: Quadrature::StressPoints,
        stress_point_weight: Some(0.303_232),
        ..nodal(LatticeKind::Hexagonal)
    };
    let method = method::<2>(choices);
    let (ratio, _) = weakest(&method, &*material).expect("a wave");
    assert!((ratio - 0.099_693_2).abs() < 1e-5, "{ratio}");
    let survey = Survey::new(&method, &*material).expect("a survey");
    let modes = spurious_modes(&survey, 0.1).expect("modes");
    assert_eq!(modes.weakest, Some(ratio));
}

/// In correspondence peridynamics on the hexagonal lattice the weakest wave is at the corners of the zone, where neighbors do not simply alternate.
#[test]
fn the_weakest_wave_of_the_hexagonal_lattice_is_at_the_zone_corners() {
    let hexagonal = Crystal::of(LatticeKind::Hexagonal, 1.0).expect("a crystal");
    let choices = PeridynamicsChoices {
        model: BondModel::Correspondence {
            control: ZeroEnergyControl::Penalty { coefficient: 0.1 },
        },
        horizon: 2.0,
        ..PeridynamicsChoices::default()
    };
    let scheme = Peridynamics::<2>::new(hexagonal, choices).expect("a method");
    let (ratio, wave) = weakest(&scheme, &*law("blatz-ko", &[])).expect("a wave");
    assert!((ratio - 0.092_460_7).abs() < 1e-6, "{ratio}");
    assert!((wave.norm() - 2.0 * TAU / 3.0).abs() < 1e-5, "{wave}");
}
