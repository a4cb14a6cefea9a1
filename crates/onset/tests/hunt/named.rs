//! States that an incomplete search reports as stable, or whose deepest well lies between the points of a coarse grid.
//!
//! Such a search assumes real spectra in one dimension, an inversion center, or one particle in a cell.

use crate::dense::Waves;
use nalgebra::{SMatrix, SVector};
use onset::approximation::Approximation;
use onset::bloch::{BlochBlocks, Mass, SpectrumSummary, WaveSystem, ZoneSearch};
use onset::kinematics::DeformationGradient;
use onset::lattice::{BravaisLattice, Crystal, LatticeKind, Particle};
use onset::material::{Hyperelastic, Law};
use onset::method::Frame;
use onset::scheme::conforming::{ConformingChoices, ConformingIntegration};
use onset::scheme::kernel::{CrystalQuadrature, KernelChoices, KernelScheme};
use onset::scheme::sph::{
    MomentumForm, TotalLagrangianChoices, TotalLagrangianSph, UpdatedSph, UpdatedSphChoices,
};
use onset::scheme::{
    BondModel, Discretization, GridFunctions, Influence, MaterialPointChoices, MaterialPoints,
    PartialVolumes, Peridynamics, PeridynamicsChoices, ZeroEnergyControl,
};
use onset::verdict::Survey;

fn law(name: &str) -> Box<dyn Hyperelastic> {
    let law = Law::named(name).expect("a law of the library");
    law.build(&[]).expect("its defaults")
}

fn stretched(stretches: [f64; 3]) -> DeformationGradient {
    DeformationGradient::from_stretches(stretches).expect("positive")
}

/// Summary of the search, and the waves computed from their definition.
fn answer<const D: usize>(
    scheme: &dyn Discretization<D>,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
) -> (SpectrumSummary<D>, Waves<D>) {
    let survey = Survey::new(scheme, material).expect("a survey");
    let system = scheme.waves(material, f).expect("waves");
    let spectrum = survey.spectrum(f).expect("a spectrum");
    (spectrum, Waves::of_system(&system))
}

#[track_caller]
fn assert_grows_as<const D: usize>(spectrum: &SpectrumSummary<D>, waves: &Waves<D>, least: f64) {
    assert!(!spectrum.is_stable());
    let found = waves.searched([256, 64, 16][D - 1], 20);
    let said = spectrum.growth_rate();
    assert!(found.growth.0 > least, "{found:?}");
    assert!(
        said > found.growth.0 * (1.0 - 1e-4),
        "{said}, found {found:?}"
    );
    let own = waves.growth(&spectrum.fastest_growing.wave_vector);
    assert!((own - said).abs() < 1e-6 * said, "{own}, said {said}");
}

#[test]
fn material_points_off_the_cell_centers_of_a_chain_flutter() {
    let points = MaterialPoints::<1>::new(MaterialPointChoices {
        offset: [0.08; 3],
        functions: GridFunctions::Gimp,
        ..MaterialPointChoices::default()
    });
    let material = law("neo-hooke");
    let (spectrum, waves) = answer(
        &points.expect("points"),
        &*material,
        &stretched([1.3, 1.0, 1.0]),
    );
    assert!(spectrum.flutters);
    assert_grows_as(&spectrum, &waves, 1e-3);
}

#[test]
fn material_points_in_the_plane_flutter_without_an_inversion_center() {
    let points = MaterialPoints::<2>::new(MaterialPointChoices {
        offset: [-0.0926; 3],
        ..MaterialPointChoices::default()
    });
    let material = law("neo-hooke-isochoric");
    let f = stretched([1.2256, 1.2179, 1.0]);
    let (spectrum, waves) = answer(&points.expect("points"), &*material, &f);
    assert_grows_as(&spectrum, &waves, 0.1);
}

#[test]
fn sph_on_a_honeycomb_flutters_in_a_small_pocket() {
    let crystal = Crystal::<2>::of(LatticeKind::Honeycomb, 1.0).expect("a crystal");
    let choices = UpdatedSphChoices {
        radius: 1.9339693506539979,
        ..UpdatedSphChoices::default()
    };
    let sph = UpdatedSph::new(crystal, choices).expect("sph");
    let f = stretched([0.9264274044048921, 0.940846567666055, 1.0]);
    let (spectrum, waves) = answer(&sph, &*law("neo-hooke"), &f);
    assert_grows_as(&spectrum, &waves, 1e-3);
}

/// A fiber stiffens one wave, and relative motion of the particles of a cell costs little energy. All four branches have strong curvature and cross
/// within a third of a grid step.
#[test]
fn soft_branches_that_bend_within_a_grid_step_flutter_where_they_meet() {
    let crystal = Crystal::<2>::of(LatticeKind::Honeycomb, 1.0).expect("a crystal");
    let choices = TotalLagrangianChoices {
        kernel: onset::kernel::Kernel::QuarticSpline,
        radius: 1.6530310890461073,
        penalty: 0.1,
        velocity_smoothing: 0.5,
        ..TotalLagrangianChoices::default()
    };
    let sph = TotalLagrangianSph::new(crystal, choices).expect("sph");
    let f = stretched([1.420927117556759, 1.3202986606213392, 1.0]);
    let (spectrum, waves) = answer(&sph, &*law("standard-reinforcing"), &f);
    assert_grows_as(&spectrum, &waves, 1e-3);
}

#[test]
fn growth_and_scaled_minimum_of_two_particles_in_a_cell_agree_with_a_dense_search() {
    let lattice = LatticeKind::Square.lattice::<2>(1.0).expect("a lattice");
    let second = SVector::from([0.4322781157294936, 0.5146418018764464]);
    let crystal = Crystal::new(lattice, vec![SVector::zeros(), second]).expect("a crystal");
    let choices = UpdatedSphChoices {
        momentum: MomentumForm::Difference,
        radius: 1.395038333560147,
        ..UpdatedSphChoices::default()
    };
    let sph = UpdatedSph::new(crystal, choices).expect("sph");
    let f = stretched([0.9757721656652725, 0.9903580109492636, 1.0]);
    let material = law("blatz-ko");
    let (spectrum, waves) = answer(&sph, &*material, &f);
    assert_grows_as(&spectrum, &waves, 1e-3);
    let survey = Survey::new(&sph, &*material).expect("a survey");
    let found = waves.searched(64, 20).scaled.0 / survey.speed_squared();
    assert!(
        spectrum.softest.scaled <= found + 1e-9,
        "{spectrum:?}, found {found}"
    );
}

/// Cell of two particles in the plane: the first particles form a square lattice of unit springs, and each second particle is attached to a first
/// particle by a spring of the given stiffness.
fn sprung(ground: f64) -> WaveSystem<2> {
    let lattice = BravaisLattice::new(SMatrix::<f64, 2, 2>::identity()).expect("a lattice");
    let sites = vec![SVector::zeros(), SVector::from([0.5, 0.5])];
    let crystal = Crystal::new(lattice, sites).expect("a crystal");
    let mut blocks = BlochBlocks::new();
    let mut spring = |a: Particle<2>, b: Particle<2>, stiffness: f64| {
        let block = SMatrix::<f64, 2, 2>::identity() * stiffness;
        for (from, to) in [(a, b), (b, a)] {
            blocks.add(&from, &from, &block);
            blocks.add(&from, &to, &-block);
        }
    };
    let home = [0, 1].map(Particle::home);
    for cell in [[1, 0], [0, 1]] {
        spring(home[0], home[0].moved(&cell), 1.0);
    }
    // With a negative stiffness, the internal displacement is unstable at `k = 0`.
    spring(home[0], home[1], ground);
    WaveSystem::new(
        crystal.clone(),
        blocks.sum(&crystal),
        Mass::Lumped(vec![1.0, 1.0]),
    )
}

#[test]
fn if_a_mode_grows_at_gamma_the_scaled_minimum_is_the_lowest_divided_by_the_largest_laplacian() {
    let system = sprung(-0.3);
    let search = ZoneSearch::of_lattice(*system.crystal().lattice(), 2.0);
    let summary = search.summary_of(&system);
    assert!(!summary.is_stable());
    // `c^2 = 2`, and `|k|_h^2 = 4 + 4` at the corner of the zone.
    let expected = summary.lowest.omega_squared.re / (2.0 * 8.0);
    assert!((summary.softest.scaled - expected).abs() < 1e-14);
    assert!(summary.lowest.omega_squared.re < -0.6 + 1e-9);
}

/// Returns the same operator with a consistent mass matrix, so that the search for several particles in a cell is used.
fn with_matrix_of_masses<const D: usize>(system: &WaveSystem<D>) -> WaveSystem<D> {
    let Mass::Lumped(masses) = system.mass() else {
        return system.clone();
    };
    let mut blocks = BlochBlocks::new();
    for (site, mass) in masses.iter().enumerate() {
        let home = Particle::home(site);
        blocks.add(&home, &home, &(SMatrix::identity() * *mass));
    }
    let crystal = system.crystal();
    let mass = Mass::Consistent(blocks.sum(crystal));
    WaveSystem::new(crystal.clone(), system.stiffness().clone(), mass)
}

#[test]
fn the_searches_for_one_and_for_several_particles_in_a_cell_agree() {
    let material = law("neo-hooke");
    for (offset, stretches) in [
        (0.0, [1.2, 0.9, 1.0]),
        (0.11, [1.2, 0.9, 1.0]),
        (-0.0926, [1.2256, 1.2179, 1.0]),
        (0.08, [0.9, 1.05, 1.0]),
    ] {
        for functions in [GridFunctions::Linear, GridFunctions::Gimp] {
            let points = MaterialPoints::<2>::new(MaterialPointChoices {
                offset: [offset; 3],
                functions,
                ..MaterialPointChoices::default()
            });
            let f = stretched(stretches);
            let system = points
                .expect("points")
                .waves(&*material, &f)
                .expect("waves");
            assert!(system.single().is_some());
            let search = ZoneSearch::of_lattice(*system.crystal().lattice(), 1.0);
            let one = search.summary_of(&system);
            let any = search.summary_of(&with_matrix_of_masses(&system));
            assert_eq!(
                one.stability(),
                any.stability(),
                "{offset}: {one:?} {any:?}"
            );
            let near = |a: f64, b: f64| (a - b).abs() <= 1e-7 * (1.0 + a.abs());
            assert!(
                near(one.softest.scaled, any.softest.scaled),
                "{one:?} {any:?}"
            );
            assert!(
                near(one.growth_rate(), any.growth_rate()),
                "{one:?} {any:?}"
            );
            assert!(
                near(one.maximum_omega, any.maximum_omega),
                "{one:?} {any:?}"
            );
        }
    }
}

/// At `k = 0` the four eigenvalues are two zeros and an unstable pair. An iteration that compares with diagonal entries does not terminate.
#[test]
fn relative_motion_of_the_particles_of_a_cell_has_a_finite_growth_rate() {
    let honeycomb = Crystal::<2>::of(LatticeKind::Honeycomb, 1.0).expect("a crystal");
    let choices = UpdatedSphChoices {
        kernel: onset::kernel::Kernel::WendlandC6,
        radius: 2.522442815530998,
        momentum: MomentumForm::Mean,
        density_evolution: onset::scheme::sph::DensityEvolution::Summation,
        support_size: onset::method::SupportSize::Fixed,
        ..UpdatedSphChoices::default()
    };
    let scheme = UpdatedSph::new(honeycomb, choices).expect("a method");
    let f = stretched([1.3485364741063428, 1.0755666960085821, 1.0]);
    let (spectrum, waves) = answer::<2>(&scheme, &*law("neo-hooke-quadratic"), &f);
    assert!(spectrum.growth_rate().is_finite());
    assert_grows_as(&spectrum, &waves, 1.0);
}

/// The two particles of a cell are mirror images with respect to each other's neighbors, so that both have the gradient `F = G + s b^T` of a uniform
/// gradient `G` and a relative shift `s`.
///
/// If `s` is opposite to `a`, waves `a N^T` along `N = b` cause no strain, for any material.
#[test]
fn long_waves_of_two_particles_with_one_gradient_have_no_stiffness_along_one_direction() {
    let cell = 2.0_f64.sqrt();
    let lattice = BravaisLattice::new(SMatrix::<f64, 2, 2>::identity() * cell).expect("a lattice");
    let second = SVector::from([0.6327610244503956, 0.47530746619751374]);
    let crystal = Crystal::new(lattice, vec![SVector::zeros(), second]).expect("a crystal");
    let choices = PeridynamicsChoices {
        horizon: 2.259834990769473,
        influence: Influence::Gaussian,
        partial_volumes: PartialVolumes::Tapered,
        model: BondModel::Correspondence {
            control: ZeroEnergyControl::None,
        },
        ..PeridynamicsChoices::default()
    };
    let scheme = Peridynamics::new(crystal, choices).expect("a method");
    let f = stretched([1.0201461683179034, 1.039459395937052, 1.0]);
    let (spectrum, waves) = answer(&scheme, &*law("saint-venant-kirchhoff"), &f);
    assert!(spectrum.softest.is_long_wave);
    assert!(spectrum.softest.scaled.abs() < 1e-7, "{spectrum:?}");
    assert!(spectrum.is_stable(), "{spectrum:?}");
    // Finite waves along the softest direction have energy of higher order.
    let along = spectrum.softest.wave_vector;
    let of_length = |k: f64| {
        let values = waves.omega_squared(&(along * k)).into_iter();
        values.map(|z| z.re).fold(f64::INFINITY, f64::min)
    };
    assert!(of_length(0.1) > 0.0 && of_length(0.1) < 0.1 * 0.01);
}

/// If weights do not add up to one, translations cause strain.
///
/// Here the mean displacement of two particles causes strain, and their relative displacement is free. The long-wave limit is not the limit of
/// translations.
#[test]
fn no_long_wave_grows_if_translations_cost_energy_and_an_internal_displacement_is_free() {
    let cell = 2.0_f64.sqrt();
    let lattice = BravaisLattice::new(SMatrix::<f64, 2, 2>::identity() * cell).expect("a lattice");
    let second = SVector::from([0.5663173018375012, 0.5094942008969261]);
    let crystal = Crystal::new(lattice, vec![SVector::zeros(), second]).expect("a crystal");
    let choices = ConformingChoices {
        radius: 2.1745312819925546,
        approximation: Approximation::Raw,
        kernel: onset::kernel::Kernel::QuarticSpline,
        modification: 0.0,
        ..ConformingChoices::default()
    };
    let scheme = ConformingIntegration::new(crystal, &choices).expect("a method");
    let material = law("hencky");
    let f = stretched([1.0104, 0.9983, 1.0]);
    let system = scheme.waves(&*material, &f).expect("waves");
    assert!(
        system.rigid_translation().amax() > 1e-7,
        "{}",
        system.rigid_translation()
    );
    let (spectrum, waves) = answer(&scheme, &*material, &f);
    let at_rest = waves.omega_squared(&SVector::zeros());
    assert!(at_rest.iter().all(|z| z.re > -1e-12));
    assert!(at_rest.iter().any(|z| z.re.abs() < 1e-12));
    assert!(spectrum.is_stable(), "{spectrum:?}");
    assert!(waves.searched(64, 20).growth.0 < 1e-6);
}

/// Two quadrature points for four particles: the particles of a cell relax almost without forces, and rounding makes the long-wave limit negative, by
/// 6.5e-7 of the squared wave speed. No wave grows.
#[test]
fn a_negative_long_wave_limit_without_growing_waves_is_rounding() {
    let lattice = BravaisLattice::new(SMatrix::<f64, 2, 2>::identity() * 2.0).expect("a lattice");
    let sites = [
        [0.0, 0.0],
        [0.5699547893770911, 0.1843027565603983],
        [0.1842922065877658, 0.6888147090421167],
        [0.5668248921264699, 0.7657363614602734],
    ];
    let crystal = Crystal::new(lattice, sites.map(SVector::from).to_vec()).expect("a crystal");
    let points = [
        [0.4872909473410941, 0.8114120299308681],
        [0.34095627920814586, 0.4268790009312542],
    ];
    let points = points.map(|point| (SVector::from(point), 2.0)).to_vec();
    let choices = KernelChoices {
        kernel: onset::kernel::Kernel::QuinticSpline,
        radius: 1.9181209161080375,
        approximation: Approximation::Mls3,
        frame: Frame::Lagrangian,
        ..KernelChoices::default()
    };
    let scheme = KernelScheme::new(crystal, CrystalQuadrature::Points(points), choices);
    let f = DeformationGradient::from_components([
        [1.01718368169553, 0.0047966816168252754, 0.0],
        [0.0028199731434057607, 1.0173906242538622, 0.0],
        [0.0, 0.0, 1.0],
    ]);
    let (spectrum, waves) = answer(&scheme.expect("a method"), &*law("hencky"), &f);
    assert!(spectrum.is_stable(), "{spectrum:?}");
    assert!(waves.searched(64, 20).growth.0 < 1e-6);
}

/// Two particles that barely resist relative motion: they relax only in waves of thousands of spacings, which grow; shorter waves do not. The
/// reported growth rate belongs to such a long wave.
#[test]
fn waves_longer_than_the_grid_resolves_have_a_positive_growth_rate() {
    let cell = 2.0_f64.sqrt();
    let lattice = BravaisLattice::new(SMatrix::<f64, 2, 2>::identity() * cell).expect("a lattice");
    let second = SVector::from([0.7529480832740633, 0.47485021702222896]);
    let crystal = Crystal::new(lattice, vec![SVector::zeros(), second]).expect("a crystal");
    let choices = KernelChoices {
        kernel: onset::kernel::Kernel::QuarticSpline,
        radius: 1.6035639012576168,
        approximation: Approximation::Mls,
        frame: Frame::Lagrangian,
        ..KernelChoices::default()
    };
    let scheme = KernelScheme::new(crystal, CrystalQuadrature::Nodal, choices);
    let f = DeformationGradient::from_components([
        [-0.5581874915063255, 0.8347972787432606, 0.0],
        [-0.8217802735697843, -0.5678977367696438, 0.0],
        [0.0, 0.0, 1.0],
    ]);
    let (spectrum, waves) = answer(&scheme.expect("a method"), &*law("fung"), &f);
    assert!(!spectrum.is_stable(), "{spectrum:?}");
    let mode = &spectrum.fastest_growing;
    assert!(mode.wave_vector.norm() < 0.01, "{spectrum:?}");
    let (said, own) = (
        spectrum.growth_rate(),
        waves.growth_with_rounding(&mode.wave_vector),
    );
    assert!(
        said > 0.0 && (own - said).abs() < 1e-2 * said,
        "{said} {own}"
    );
}
