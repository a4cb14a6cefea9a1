//! Nodal integration with smoothed gradients: the general scheme checks, exactness for linear fields, and zero-energy modes.

use crate::battery::{assert_long_waves_are_those_of_the_material, assert_scheme};
use crate::random::Random;
use crate::states::{saint_venant_kirchhoff, sheared, turned};
use nalgebra::{SMatrix, SVector, Vector1};
use onset::approximation::Approximation;
use onset::bloch::WaveSystem;
use onset::continuum::Stiffness;
use onset::kernel::Kernel;
use onset::kinematics::DeformationGradient;
use onset::lattice::{BravaisLattice, Crystal, LatticeKind, Particle, WaveGrids};
use onset::material::{Hyperelastic, Law};
use onset::method::MethodError;
use onset::scheme::conforming::{ConformingChoices, ConformingIntegration, SmoothingDomain};
use onset::scheme::{Discretization, LagrangianPoint};
use onset::verdict::Survey;
use std::collections::BTreeMap;
use std::f64::consts::PI;

fn material() -> Box<dyn Hyperelastic> {
    saint_venant_kirchhoff(0.7, 1.0)
}

fn choices() -> ConformingChoices {
    ConformingChoices {
        density: 1.3,
        radius: 1.7,
        ..ConformingChoices::default()
    }
}

fn modified(modification: f64) -> ConformingChoices {
    ConformingChoices {
        modification,
        ..choices()
    }
}

fn chain() -> Crystal<1> {
    Crystal::of_lattice(LatticeKind::Chain.lattice(0.9).expect("a lattice"))
}

fn square() -> Crystal<2> {
    Crystal::of_lattice(LatticeKind::Square.lattice(0.9).expect("a lattice"))
}

fn hexagonal() -> Crystal<2> {
    Crystal::of_lattice(LatticeKind::Hexagonal.lattice(0.9).expect("a lattice"))
}

fn irregular() -> Crystal<2> {
    let large = square().supercell([2, 3]).expect("a crystal");
    large.perturbed(0.15, 4).expect("a crystal")
}

/// Simple cubic (1, 0), body-centered (-1, 1) and face-centered (0, 1) cubic lattices.
fn cubic(diagonal: f64, rest: f64) -> Crystal<3> {
    let vectors = SMatrix::<f64, 3, 3>::from_fn(|i, j| if i == j { diagonal } else { rest });
    Crystal::of_lattice(BravaisLattice::new(vectors).expect("a lattice"))
}

fn scheme<const D: usize>(
    crystal: Crystal<D>,
    choices: &ConformingChoices,
) -> ConformingIntegration<D> {
    ConformingIntegration::new(crystal, choices).expect("a method")
}

fn at_rest<const D: usize>(scheme: &ConformingIntegration<D>) -> WaveSystem<D> {
    scheme
        .waves(&*material(), &DeformationGradient::identity())
        .expect("waves")
}

fn assert_conforming<const D: usize>(crystal: &Crystal<D>, choices: &ConformingChoices) {
    let scheme = scheme(crystal.clone(), choices);
    let (material, state) = (material(), sheared::<D>());
    assert_scheme(&scheme, &*material, &state);
    assert_long_waves_are_those_of_the_material(&scheme, &*material, &state, 1e-9);
}

#[test]
fn methods_with_smoothed_gradients_pass_the_checks_and_agree_with_the_material_for_long_waves() {
    for modification in [0.0, 0.4, 1.0] {
        let choices = modified(modification);
        assert_conforming(&chain(), &choices);
        assert_conforming(&square(), &choices);
        assert_conforming(&hexagonal(), &choices);
        assert_conforming(&irregular(), &choices);
    }
    let quadratic = ConformingChoices {
        approximation: Approximation::Mls2,
        radius: 2.6,
        ..modified(0.4)
    };
    assert_conforming(&hexagonal(), &quadratic);
    assert_conforming(&irregular(), &quadratic);
    let honeycomb = Crystal::<2>::of(LatticeKind::Honeycomb, 1.0).expect("a crystal");
    assert_conforming(&honeycomb, &modified(0.4));
    let boxes = ConformingChoices {
        domain: SmoothingDomain::Boxes,
        ..modified(0.4)
    };
    assert_conforming(&hexagonal(), &boxes);
}

#[test]
fn methods_with_smoothed_gradients_in_3d_pass_the_checks_and_agree_with_the_material_for_long_waves()
 {
    let small = ConformingChoices {
        radius: 1.6,
        boundary_points: 1,
        ..modified(0.4)
    };
    assert_conforming(&cubic(1.0, 0.0), &small);
    assert_conforming(&cubic(0.0, 1.0), &modified(0.0));
    let boxes = ConformingChoices {
        domain: SmoothingDomain::Boxes,
        ..modified(0.0)
    };
    assert_conforming(&cubic(-1.0, 1.0), &boxes);
}

/// Moment matrix `sum_K X_K (x) b_K`.
fn moment<const D: usize>(
    scheme: &ConformingIntegration<D>,
    point: &LagrangianPoint<D>,
) -> SMatrix<f64, D, D> {
    let terms = point.particles().iter().zip(point.gradients());
    let product = |(particle, b): (&Particle<D>, &SVector<f64, D>)| {
        scheme.crystal().position(particle) * b.transpose()
    };
    terms.map(product).sum()
}

#[test]
fn long_waves_of_shepard_functions_agree_with_the_material_if_all_cells_are_equal() {
    // Opposite faces of the cells of a lattice have the same values, so that the errors for linear fields cancel.
    for modification in [0.0, 1.0] {
        let choices = ConformingChoices {
            approximation: Approximation::Shepard,
            ..modified(modification)
        };
        for crystal in [square(), hexagonal()] {
            let scheme = scheme(crystal, &choices);
            let errors = scheme
                .points()
                .iter()
                .map(|point| (moment(&scheme, point) - SMatrix::identity()).amax());
            let is_exact = errors.fold(0.0, f64::max) < 1e-13;
            // The pyramids have no opposite faces.
            assert_eq!(is_exact, modification == 0.0);
        }
    }
    let choices = ConformingChoices {
        approximation: Approximation::Shepard,
        ..choices()
    };
    assert_conforming(&square(), &choices);
    assert_conforming(&hexagonal(), &choices);
    assert_conforming(&cubic(1.0, 0.0), &choices);
}

#[test]
fn linear_fields_are_integrated_exactly_on_irregular_particles() {
    for modification in [0.0, 0.5] {
        let scheme = scheme(irregular(), &modified(modification));
        let crystal = scheme.crystal();
        let mut sums: BTreeMap<usize, SVector<f64, 2>> = BTreeMap::new();
        for point in scheme.points() {
            let mut sum = SVector::<f64, 2>::zeros();
            for (particle, b) in point.particles().iter().zip(point.gradients()) {
                sum += b;
                // The sum over all images of a particle is the integral of its gradient over the plane.
                *sums.entry(particle.site).or_default() += b * point.volume();
            }
            // Small pyramids divide rounding errors by their volumes.
            let tolerance = 1e-13 / point.volume();
            assert!(sum.amax() < tolerance);
            assert!((moment(&scheme, point) - SMatrix::identity()).amax() < tolerance);
        }
        assert_eq!(sums.len(), 6);
        assert!(sums.values().all(|sum| sum.amax() < 1e-12));
        let volume: f64 = scheme.points().iter().map(|point| point.volume()).sum();
        assert!((volume - crystal.lattice().cell_volume()).abs() < 1e-12);
    }
}

#[test]
fn boxes_on_irregular_particles_cause_forces_in_the_homogeneous_state() {
    let boxes = ConformingChoices {
        domain: SmoothingDomain::Boxes,
        ..choices()
    };
    let scheme = scheme(irregular(), &boxes);
    let mut sums: BTreeMap<usize, SVector<f64, 2>> = BTreeMap::new();
    for point in scheme.points() {
        for (particle, b) in point.particles().iter().zip(point.gradients()) {
            *sums.entry(particle.site).or_default() += b * point.volume();
        }
    }
    assert!(sums.values().any(|sum| sum.amax() > 1e-3));
}

#[test]
fn boxes_equal_voronoi_cells_on_the_square_lattice() {
    let boxes = ConformingChoices {
        domain: SmoothingDomain::Boxes,
        ..choices()
    };
    let (conforming, boxes) = (scheme(square(), &choices()), scheme(square(), &boxes));
    let (a, b) = (&conforming.points()[0], &boxes.points()[0]);
    assert_eq!(a.particles(), b.particles());
    for (a, b) in a.gradients().iter().zip(b.gradients()) {
        assert!((a - b).amax() < 1e-14);
    }
}

/// Number of modes with zero stiffness at the halves of reciprocal vectors.
fn nullity<const D: usize>(crystal: &Crystal<D>, choices: &ConformingChoices) -> usize {
    let waves = at_rest(&scheme(crystal.clone(), choices));
    let scale = waves.stiffness().magnitude();
    let halves = (1..1_usize << D).map(|bits| {
        let half = SVector::from_fn(|i, _| 0.5 * (bits >> i & 1) as f64);
        crystal.lattice().reciprocal() * half
    });
    let zeros = halves.map(|k| {
        let values = waves.omega_squared(&k).into_iter();
        values.filter(|value| value.norm() < 1e-10 * scale).count()
    });
    zeros.sum()
}

#[test]
fn waves_of_half_a_reciprocal_vector_have_zero_energy_without_the_modification() {
    // Such a wave is even about every node: the mean gradient of a cell with this center vanishes.
    for domain in [SmoothingDomain::Voronoi, SmoothingDomain::Boxes] {
        for boundary_points in [1, 3] {
            let with = |modification| ConformingChoices {
                domain,
                boundary_points,
                ..modified(modification)
            };
            let (plain, stabilized) = (with(0.0), with(0.05));
            assert_eq!(nullity(&chain(), &plain), 1);
            assert_eq!(nullity(&square(), &plain), 6);
            assert_eq!(nullity(&hexagonal(), &plain), 6);
            assert_eq!(nullity(&chain(), &stabilized), 0);
            assert_eq!(nullity(&square(), &stabilized), 0);
            assert_eq!(nullity(&hexagonal(), &stabilized), 0);
        }
    }
    // The corners K of the hexagonal zone, by its threefold axes.
    for (modification, zeros) in [(0.0, 2), (0.05, 0)] {
        let waves = at_rest(&scheme(hexagonal(), &modified(modification)));
        let corner = hexagonal().lattice().reciprocal() * SVector::<f64, 2>::new(2.0, 1.0) / 3.0;
        let values = waves.omega_squared(&corner).into_iter();
        assert_eq!(values.filter(|value| value.norm() < 1e-10).count(), zeros);
    }
    assert_eq!(nullity(&cubic(1.0, 0.0), &modified(0.0)), 21);
    assert_eq!(nullity(&cubic(1.0, 0.0), &modified(0.05)), 0);
}

#[test]
fn smoothing_on_a_chain_with_two_neighbors_at_the_midpoints_is_the_central_difference() {
    let (radius, c) = (1.2 * 0.9, 0.3);
    let weight = |q: f64| {
        let weight = Kernel::QuarticSpline.weight(&Vector1::new(q), radius, &SMatrix::identity());
        weight.map_or(0.0, |weight| weight.value)
    };
    let of = |modification| {
        at_rest(&scheme(
            chain(),
            &ConformingChoices {
                radius,
                approximation: Approximation::Shepard,
                ..modified(modification)
            },
        ))
    };
    // Unit of omega^2: E / (rho h^2).
    let unit = 2.7 / (1.3 * 0.9 * 0.9);
    let plain = of(0.0);
    for angle in [0.2_f64, 1.0, PI / 2.0, 2.8] {
        let found = plain.omega_squared(&Vector1::new(angle / 0.9))[0].re;
        assert!((found - unit * angle.sin().powi(2)).abs() < 1e-12);
    }
    // Gradient of the shortest wave in half of a cell: from the value at the node to zero, over h/2.
    let w = weight(0.9) / weight(0.0);
    let slope = 2.0 * (1.0 - 2.0 * w) / (1.0 + 2.0 * w);
    let found = of(c).omega_squared(&Vector1::new(PI / 0.9))[0].re;
    assert!((found - c * unit * slope * slope).abs() < 1e-12);
}

#[test]
fn frequencies_are_invariant_under_rotations_of_the_setup_and_of_the_body() {
    let turn = turned::<2>();
    let state = sheared::<2>();
    let turned_state = state.with_leading(&(turn * state.leading::<2>() * turn.transpose()));
    let superposed = state.with_leading(&(turn * state.leading::<2>()));
    let straight = irregular();
    let lattice = straight.lattice().mapped(&turn).expect("a lattice");
    let oblique = Crystal::new(lattice, straight.sites().to_vec()).expect("a crystal");
    let choices = modified(0.3);
    let waves = |crystal: &Crystal<2>, f| {
        let scheme = scheme(crystal.clone(), &choices);
        scheme.waves(&*material(), f).expect("waves")
    };
    let expected = waves(&straight, &state);
    let (oblique, superposed) = (
        waves(&oblique, &turned_state),
        waves(&straight, &superposed),
    );
    let mut random = Random::new(4);
    for _ in 0..4 {
        let k = SVector::<f64, 2>::from_fn(|_, _| 2.0 * random.number());
        let expected = expected.omega_squared(&k);
        for found in [
            oblique.omega_squared(&(turn * k)),
            superposed.omega_squared(&k),
        ] {
            for (a, b) in expected.iter().zip(found) {
                assert!((a - b).norm() < 1e-10, "{a} turned is {b}");
            }
        }
    }
}

fn assert_stable_where_elliptic<const D: usize>(crystal: &Crystal<D>) {
    let material = material();
    let grid = WaveGrids::new(*crystal.lattice()).grid(12);
    for stretch in [0.45, 0.56, 0.58, 0.8, 1.3] {
        let state = DeformationGradient::from_stretches([stretch, 1.0, 1.0]).expect("a state");
        let elliptic = Stiffness::<D>::at(&*material, &state).expect("a tangent");
        for modification in [0.0, 0.3, 1.0] {
            let scheme = scheme(crystal.clone(), &modified(modification));
            let waves = scheme.waves(&*material, &state).expect("waves");
            let longest = waves.long_wave_stiffness().minimum().eigenvalue.re;
            let grows = |k: &SVector<f64, D>| waves.omega_squared(k)[0].re < -1e-10;
            let is_stable = longest > -1e-10 && !grid.wave_vectors().any(|k| grows(&k));
            assert_eq!(is_stable, elliptic.is_strongly_elliptic(), "at {stretch}");
        }
    }
}

#[test]
fn on_lattices_the_modification_neither_masks_nor_adds_instabilities() {
    assert_stable_where_elliptic(&chain());
    assert_stable_where_elliptic(&square());
    assert_stable_where_elliptic(&hexagonal());
}

/// The relative motion of the two particles of a cell is nearly free: the stiffness of relaxed long waves is a small difference of large numbers.
#[test]
fn the_long_wave_limit_is_accurate_for_nearly_free_relaxation() {
    let lattice = LatticeKind::Square
        .lattice(2.0_f64.sqrt())
        .expect("a lattice");
    let places = [[0.0, 0.0], [0.23209757466993863, 0.5023586723232352]].map(SVector::from);
    let crystal = Crystal::new(lattice, places.to_vec()).expect("a crystal");
    let choices = ConformingChoices {
        density: 1.0,
        radius: 2.234375528257272,
        approximation: Approximation::Mls,
        domain: SmoothingDomain::Boxes,
        ..ConformingChoices::default()
    };
    let hencky = Law::named("hencky")
        .expect("a law")
        .build(&[])
        .expect("a material");
    let f = DeformationGradient::from_stretches([1.0715596417701576, 0.9556007704863001, 1.0]);
    let system = scheme(crystal, &choices)
        .waves(&*hencky, &f.expect("a state"))
        .expect("waves");
    let stiffness = system.long_wave_stiffness();
    for direction in [[1.0, 0.0], [0.991, 0.133], [0.6, -0.8]].map(SVector::from) {
        // At this wavelength the waves are slower than the relative motion of the particles of a cell.
        let k: SVector<f64, 2> = direction * 2e-5;
        let along = system.omega_squared(&k)[0].re / k.norm_squared();
        let tensor = stiffness.acoustic_tensor(&direction) / direction.norm_squared();
        let limit = tensor.symmetric_eigenvalues().min();
        // Waves of this length are slightly softer than the limit.
        let apart = (limit - along).abs();
        assert!(apart < 1e-5 + 5e-3 * limit.abs(), "{limit} {along}");
    }
}

#[test]
fn choices_out_of_range_are_rejected() {
    let refused = |choices: ConformingChoices| {
        ConformingIntegration::new(square(), &choices).expect_err("out of range")
    };
    let out_of_range = |error| matches!(error, MethodError::Setting { .. });
    assert!(out_of_range(refused(modified(-0.1))));
    assert!(out_of_range(refused(modified(1.1))));
    assert!(out_of_range(refused(modified(f64::NAN))));
    let points = |boundary_points| ConformingChoices {
        boundary_points,
        ..choices()
    };
    assert!(out_of_range(refused(points(0))));
    assert!(out_of_range(refused(points(100))));
    let radius = |radius| ConformingChoices {
        radius,
        ..choices()
    };
    assert!(refused(radius(0.4)).is_about_support());
    assert!(refused(radius(1e6)).is_about_support());
    assert!(matches!(
        refused(radius(-1.0)),
        MethodError::Setting {
            name: "support",
            ..
        }
    ));
}

/// The bound is within 4e-7 of the reported minimum, and smaller minima are also reported.
#[test]
fn a_minimum_smaller_than_the_gap_to_its_bound_is_found() {
    let packed = Crystal::<3>::of(LatticeKind::HexagonalClosePacked, 1.0).expect("a crystal");
    let choices = ConformingChoices {
        kernel: Kernel::WendlandC4,
        approximation: Approximation::Shepard,
        radius: 1.892,
        ..ConformingChoices::default()
    };
    let crystal = packed.perturbed(0.1, 573).expect("a crystal");
    let scheme = ConformingIntegration::new(crystal, &choices).expect("a scheme");
    let law = Law::named("mooney-rivlin").expect("a law");
    let material = law.build(&[]).expect("parameters");
    let f = DeformationGradient::new([
        [0.79002, 0.0, 0.0],
        [0.16003, 1.17899, 0.0],
        [0.19115, 0.0, 1.23348],
    ])
    .expect("a state");
    let survey = Survey::new(&scheme, &*material).expect("a survey");
    let spectrum = survey.assess(&f).expect("an answer").spectrum;
    assert!(spectrum.bound.is_finite() && spectrum.bound <= spectrum.softest.scaled);
    assert!(
        spectrum.softest.scaled < 1e-7,
        "{}",
        spectrum.softest.scaled
    );
}
