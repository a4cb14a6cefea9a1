//! Units of horizons, wavelengths and time steps.

use crate::random::Random;
use nalgebra::{SMatrix, SVector};
use onset::kinematics::DeformationGradient;
use onset::lattice::{BravaisLattice, Crystal, LatticeKind, Particle};
use onset::material::ModifiedMooneyRivlin;
use onset::measures::dispersion_errors;
use onset::method::KernelMethodChoices;
use onset::scheme::element::ElementMesh;
use onset::scheme::{
    BondModel, Calibration, Discretization, Influence, PartialVolumes, Peridynamics,
    PeridynamicsChoices, ZeroEnergyControl,
};
use onset::verdict::Survey;
use std::f64::consts::TAU;

fn family(horizon: f64) -> PeridynamicsChoices {
    PeridynamicsChoices {
        horizon,
        model: BondModel::Correspondence {
            control: ZeroEnergyControl::None,
        },
        ..PeridynamicsChoices::default()
    }
}

fn crystal<const D: usize>(discretization: &KernelMethodChoices) -> Crystal<D> {
    discretization.crystal().expect("a crystal")
}

/// Mean number of particles within a distance of a particle, itself included, counted in a block.
fn counted<const D: usize>(crystal: &Crystal<D>, distance: f64) -> f64 {
    let reach = 12;
    let block: Vec<Particle<D>> = (0..(2 * reach + 1_i32).pow(D as u32))
        .flat_map(|n| {
            let along = |i: usize| n / (2 * reach + 1).pow(i as u32) % (2 * reach + 1) - reach;
            let cell = std::array::from_fn(along);
            (0..crystal.sites().len()).map(move |site| Particle { site, cell })
        })
        .collect();
    let near = |site: usize| {
        let own = crystal.position(&Particle::home(site));
        let apart = |particle: &&Particle<D>| {
            (crystal.position(particle) - own).norm() <= distance * (1.0 + 1e-9)
        };
        block.iter().filter(apart).count()
    };
    let sites = crystal.sites().len();
    (0..sites).map(near).sum::<usize>() as f64 / sites as f64
}

fn disordered(cells: u32, amplitude: f64, seed: u32) -> KernelMethodChoices {
    KernelMethodChoices {
        lattice: LatticeKind::Square,
        cells,
        perturbation: amplitude,
        seed,
        spacing: 0.7,
        ..KernelMethodChoices::default()
    }
}

#[test]
fn the_spacing_of_every_lattice_is_the_distance_of_its_neighbors() {
    fn checked<const D: usize>(kind: LatticeKind, spacing: f64) {
        let discretization = KernelMethodChoices {
            lattice: kind,
            spacing,
            vectors: vec![1.0, 0.1, 0.0, -0.2, 1.3, 0.1, 0.3, 0.2, 1.1][..D * D].to_vec(),
            aspect: 0.6,
            ..KernelMethodChoices::default()
        };
        let crystal = crystal::<D>(&discretization);
        let nearest = crystal.nearest_distance();
        assert!(
            (crystal.spacing() / nearest - 1.0).abs() < 1e-12,
            "{kind:?}"
        );
        let larger = crystal.supercell([2; D]).expect("a crystal");
        assert_eq!(larger.spacing(), crystal.spacing(), "{kind:?}");
    }
    for kind in LatticeKind::ALL {
        match kind.dimension() {
            1 => checked::<1>(kind, 1.7),
            2 => checked::<2>(kind, 1.7),
            _ => checked::<3>(kind, 1.7),
        }
    }
    for mesh in ElementMesh::ALL {
        let [spacing, nearest] = match mesh.dimension() {
            1 => lengths(mesh.mesh::<1>(1.7).expect("a mesh").crystal()),
            2 => lengths(mesh.mesh::<2>(1.7).expect("a mesh").crystal()),
            _ => lengths(mesh.mesh::<3>(1.7).expect("a mesh").crystal()),
        };
        assert!((spacing / 1.7 - 1.0).abs() < 1e-12, "{mesh:?}: {spacing}");
        assert!((nearest / 1.7 - 1.0).abs() < 1e-12, "{mesh:?}: {nearest}");
    }
}

fn lengths<const D: usize>(crystal: &Crystal<D>) -> [f64; 2] {
    [crystal.spacing(), crystal.nearest_distance()]
}

#[test]
fn oblique_primitive_vectors_do_not_change_the_spacing_of_a_lattice() {
    let mut random = Random::new(7);
    for _ in 0..50 {
        let vectors =
            SMatrix::<f64, 3, 3>::identity() + SMatrix::from_fn(|_, _| 0.4 * random.number());
        let lattice = BravaisLattice::new(vectors).expect("a lattice");
        let mut sheared = vectors;
        sheared.set_column(
            2,
            &(vectors.column(2) + vectors.column(0) * 5.0 - vectors.column(1) * 3.0),
        );
        sheared.set_column(1, &(sheared.column(1) + sheared.column(0) * 4.0));
        let leaning = BravaisLattice::new(sheared).expect("a lattice");
        let [plain, leaning] =
            [lattice, leaning].map(|lattice| Crystal::of_lattice(lattice).spacing());
        assert!((plain / leaning - 1.0).abs() < 1e-12, "{plain} {leaning}");
    }
}

#[test]
fn disorder_preserves_the_horizon_and_the_mean_size_of_families() {
    for (seed, amplitude) in [(1, 0.1), (2, 0.2), (3, 0.35)] {
        let square = crystal::<2>(&disordered(8, amplitude, seed));
        let body = Peridynamics::new(square.clone(), family(2.5)).expect("a body");
        assert_eq!(body.horizon(), 2.5 * 0.7);
        assert_eq!(body.neighbors(), counted(&square, 2.5 * 0.7));
        assert!(
            (body.neighbors() / 21.0 - 1.0).abs() < 0.1,
            "{}",
            body.neighbors()
        );
    }
    let regular = crystal::<2>(&disordered(8, 0.0, 1));
    let body = Peridynamics::new(regular, family(2.5)).expect("a body");
    assert_eq!(body.neighbors(), 21.0);
}

#[test]
fn a_supercell_given_as_a_basis_has_the_spacing_of_its_lattice() {
    let moved = crystal::<2>(&disordered(3, 0.2, 5));
    // The same particles, starting with the first, as a basis of the large cell.
    let first = moved.sites()[0];
    let basis = moved.sites()[1..].iter().flat_map(|place| {
        let from = place - first;
        [from[0], from[1]]
    });
    let told = crystal::<2>(&KernelMethodChoices {
        lattice: LatticeKind::Square,
        spacing: 2.1,
        basis: basis.collect(),
        ..KernelMethodChoices::default()
    });
    assert!((told.spacing() - 0.7).abs() < 1e-12, "{}", told.spacing());
    let size = |crystal| {
        Peridynamics::new(crystal, family(2.5))
            .expect("a body")
            .neighbors()
    };
    assert_eq!(size(told), size(moved));
    // For square and cubic cells the spacing is the root of the particle volume.
    let centered = crystal::<3>(&KernelMethodChoices {
        lattice: LatticeKind::SimpleCubic,
        basis: vec![0.45, 0.5, 0.52],
        ..KernelMethodChoices::default()
    });
    assert!((centered.spacing() - 0.5_f64.cbrt()).abs() < 1e-12);
}

/// Cells are counted in 32 bits, and 1e19 has no digits after the decimal point, so that such distant particles were mistaken for neighbors.
#[test]
fn particles_far_from_their_cell_are_rejected() {
    let with = |place: f64| KernelMethodChoices {
        basis: vec![0.4, place],
        ..KernelMethodChoices::default()
    };
    for place in [1e19, -2.7e29, f64::INFINITY] {
        let error = with(place).crystal::<2>().expect_err("far away");
        assert!(error.to_string().contains("basis"), "{error}");
    }
    let (near, far) = (crystal::<2>(&with(0.45)), crystal::<2>(&with(1024.45)));
    let apart = near.nearest_distance() - far.nearest_distance();
    assert!(apart.abs() < 1e-12, "{apart}");
}

#[test]
fn wavelengths_of_disordered_particles_are_in_units_of_the_regular_spacing() {
    let chain = crystal::<1>(&KernelMethodChoices {
        lattice: LatticeKind::Chain,
        cells: 5,
        perturbation: 0.2,
        spacing: 0.7,
        ..KernelMethodChoices::default()
    });
    assert!(chain.nearest_distance() < 0.6);
    // Bonds have no zero-energy modes, whose branches would be lower.
    let choices = PeridynamicsChoices {
        model: BondModel::BondBased {
            calibration: Calibration::Discrete,
        },
        ..family(2.0)
    };
    let scheme = Peridynamics::new(chain, choices).expect("a scheme");
    let material = ModifiedMooneyRivlin::default();
    let survey = Survey::new(&scheme, &material).expect("a survey");
    let [found] = dispersion_errors(&survey, &[12.0]).expect("errors")[..] else {
        panic!("one wavelength");
    };
    // The longest wave of the folded zone is the acoustic wave.
    let k = SVector::<f64, 1>::from_element(TAU / (12.0 * 0.7));
    let waves = scheme
        .waves(&material, &DeformationGradient::identity())
        .expect("waves");
    let exact = survey.speed_squared() * k.norm_squared();
    let expected = (waves.omega_squared(&k)[0].re / exact).sqrt() - 1.0;
    assert!(
        (found.error - expected.abs()).abs() < 1e-9,
        "{} {expected}",
        found.error
    );
}

#[test]
fn springs_at_the_horizon_act_even_if_their_weight_vanishes() {
    // At half of a reciprocal vector the strain of a family is zero, and z = u_J - u_I. Therefore omega^2 rho = 4 gamma c sum e (x) e / r V over the neighbors
    // that move in the opposite direction.
    let gamma = 0.8;
    let square = Crystal::of_lattice(LatticeKind::Square.lattice::<2>(1.0).expect("a lattice"));
    let material = ModifiedMooneyRivlin::default();
    let body = |influence| {
        let choices = PeridynamicsChoices {
            influence,
            partial_volumes: PartialVolumes::Whole,
            model: BondModel::Correspondence {
                control: ZeroEnergyControl::Hourglass { coefficient: gamma },
            },
            ..family(3.0)
        };
        Peridynamics::new(square.clone(), choices).expect("a body")
    };
    let micromodulus = body(Influence::Constant)
        .micromodulus(&material, Calibration::Continuum)
        .expect("a modulus");
    for influence in [Influence::Constant, Influence::Conical] {
        let body = body(influence);
        assert_eq!(body.neighbors(), 29.0, "{influence:?}");
        let waves = body
            .waves(&material, &DeformationGradient::identity())
            .expect("waves");
        for k in [[1, 0], [0, 1], [1, 1]] {
            let mut expected = SMatrix::<f64, 2, 2>::zeros();
            for a in -3..=3_i32 {
                for b in -3..=3_i32 {
                    let vector = SVector::<f64, 2>::new(f64::from(a), f64::from(b));
                    let is_opposite = (a * k[0] + b * k[1]) % 2 != 0;
                    if is_opposite && a * a + b * b <= 9 {
                        let direction = vector.normalize();
                        expected += direction * direction.transpose() / vector.norm();
                    }
                }
            }
            expected *= 4.0 * gamma * micromodulus;
            let k = SVector::<f64, 2>::from_fn(|i, _| f64::from(k[i]) * TAU / 2.0);
            let found = waves.dynamical_matrix_at(&k);
            for i in 0..2 {
                for j in 0..2 {
                    assert!(
                        (found[(i, j)].re - expected[(i, j)]).abs() < 1e-9 * expected.amax(),
                        "{influence:?}: {found} {expected}"
                    );
                }
            }
        }
    }
}
