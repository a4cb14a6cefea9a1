//! Chains of springs with textbook frequencies, as a test of the engine itself.

use crate::battery::assert_scheme;
use nalgebra::{SMatrix, SVector};
use onset::algebra::Complex;
use onset::bloch::{BlochBlocks, Mass, WaveSystem, ZoneSearch};
use onset::kinematics::DeformationGradient;
use onset::lattice::{BravaisLattice, Crystal, LatticeKind, Particle};
use onset::material::{Hyperelastic, ModifiedMooneyRivlin};
use onset::method::MethodError;
use onset::real::Real;
use onset::scheme::{
    Assembled, Discretization, Interaction, Motion, PatchForces, PeriodicPatch, SeenForm,
    StrainOperator, linearized, lumped_masses,
};
use std::f64::consts::PI;

/// Linear springs between neighbors, with parallel dashpots.
#[derive(Clone, Debug)]
struct Spring {
    particles: [Particle<1>; 2],
    stiffness: f64,
    viscosity: f64,
}

impl Interaction<1> for Spring {
    fn particles(&self) -> &[Particle<1>] {
        &self.particles
    }

    fn forces<R: Real>(&self, motion: Motion<'_, R, 1>) -> Vec<[R; 1]> {
        let [a, b] = [motion.displacements[0][0], motion.displacements[1][0]];
        let [v, w] = [motion.velocities[0][0], motion.velocities[1][0]];
        let force = (b - a) * self.stiffness + (w - v) * self.viscosity;
        vec![[force], [-force]]
    }

    fn is_viscous(&self) -> bool {
        self.viscosity != 0.0
    }
}

#[derive(Clone, Debug)]
struct Chain {
    crystal: Crystal<1>,
    springs: Vec<Spring>,
    masses: Vec<f64>,
}

impl Chain {
    /// Chain with two alternating masses and two alternating springs.
    fn of_two(masses: [f64; 2], stiffness: [f64; 2], viscosity: f64) -> Self {
        let lattice = BravaisLattice::new(SMatrix::<f64, 1, 1>::new(2.0)).expect("a lattice");
        let sites = [0.0, 0.5].map(SVector::from_element).to_vec();
        let (first, second) = (Particle::home(0), Particle::home(1));
        let spring = |particles, stiffness| Spring {
            particles,
            stiffness,
            viscosity,
        };
        Self {
            crystal: Crystal::new(lattice, sites).expect("a crystal"),
            springs: vec![
                spring([first, second], stiffness[0]),
                spring([second, first.moved(&[1])], stiffness[1]),
            ],
            masses: masses.to_vec(),
        }
    }
}

impl Discretization<1> for Chain {
    fn crystal(&self) -> &Crystal<1> {
        &self.crystal
    }

    fn density(&self) -> f64 {
        self.masses.iter().sum::<f64>() / 2.0
    }

    fn waves(
        &self,
        _: &dyn Hyperelastic,
        _: &DeformationGradient,
    ) -> Result<WaveSystem<1>, MethodError> {
        linearized(
            &self.crystal,
            Mass::Lumped(self.masses.clone()),
            &self.springs,
        )
    }

    fn strain(&self) -> Result<StrainOperator<1>, MethodError> {
        let mut strain = StrainOperator::new();
        for spring in &self.springs {
            let elongation = [-1.0, 1.0].map(SVector::<f64, 1>::new).to_vec();
            strain.add(
                spring.particles.to_vec(),
                vec![SeenForm::Control(elongation)],
            );
        }
        Ok(strain)
    }

    fn with_forces(
        &self,
        _: &dyn Hyperelastic,
        _: &DeformationGradient,
        patch: &PeriodicPatch<1>,
        work: &mut dyn FnMut(&dyn PatchForces<1>),
    ) -> Result<(), MethodError> {
        work(&Assembled::new(patch, &self.springs));
        Ok(())
    }

    fn neighbors(&self) -> f64 {
        3.0
    }
}

fn waves(chain: &Chain) -> WaveSystem<1> {
    chain
        .waves(
            &ModifiedMooneyRivlin::default(),
            &DeformationGradient::identity(),
        )
        .expect("finite")
}

#[test]
fn a_chain_of_two_masses_has_the_two_branches_of_the_textbook() {
    let (m, c) = ([1.0, 3.0], [2.0, 0.7]);
    let system = waves(&Chain::of_two(m, c, 0.0));
    for k in [0.1, 0.7, PI / 2.0] {
        // Both branches: omega^2 = S +- sqrt(S^2 - 4 c1 c2 sin^2(k a / 2) / (m1 m2)), S = (c1 + c2) (1/m1 + 1/m2) / 2, a = 2.
        let s = 0.5 * (c[0] + c[1]) * (1.0 / m[0] + 1.0 / m[1]);
        let product = 4.0 * c[0] * c[1] * k.sin().powi(2) / (m[0] * m[1]);
        let root = (s * s - product).sqrt();
        let found = system.omega_squared(&SVector::from_element(k));
        assert!((found[0].re - (s - root)).abs() < 1e-13);
        assert!((found[1].re - (s + root)).abs() < 1e-13);
    }
}

#[test]
fn long_waves_have_the_stiffness_of_two_springs_in_series() {
    let system = waves(&Chain::of_two([1.0, 3.0], [2.0, 0.7], 0.0));
    let modulus = 2.0 / (1.0 / 2.0 + 1.0 / 0.7);
    let found = system
        .long_wave_stiffness()
        .acoustic_tensor(&SVector::from_element(1.0))[(0, 0)];
    assert!((found - modulus / 2.0).abs() < 1e-13, "{found}");
}

#[test]
fn springs_pass_the_scheme_checks() {
    let chain = Chain::of_two([1.0, 3.0], [2.0, 0.7], 0.0);
    assert_scheme(
        &chain,
        &ModifiedMooneyRivlin::default(),
        &DeformationGradient::identity(),
    );
}

#[test]
fn a_cell_of_two_equal_masses_has_the_extreme_frequencies_of_the_chain_with_one_mass() {
    let system = waves(&Chain::of_two([1.0; 2], [1.0; 2], 0.0));
    let search = ZoneSearch::of_lattice(*system.crystal().lattice(), 1.0);
    let summary = search.summary_of(&system);
    assert!((summary.maximum_omega - 2.0).abs() < 1e-10);
    assert!(summary.is_stable());
    assert!((summary.long_wave.scaled - 1.0).abs() < 1e-12);
}

#[test]
fn dashpots_parallel_to_springs_damp_every_wave_like_an_oscillator() {
    let (stiffness, viscosity) = (1.3, 0.4);
    let system = waves(&Chain::of_two([1.0; 2], [stiffness; 2], viscosity));
    let k = SVector::from_element(0.9);
    // Each branch satisfies omega^2 + i omega c s - k s = 0 with the eigenvalue s of the unit chain.
    let mut expected: Vec<Complex> = system
        .omega_squared(&k)
        .iter()
        .flat_map(|omega_squared| {
            let s = omega_squared.re / stiffness;
            let half = 0.5 * viscosity * s;
            let root = Complex::new(stiffness * s - half * half, 0.0).sqrt();
            [root, -root].map(|root| root - Complex::new(0.0, half))
        })
        .collect();
    expected.sort_by(|a, b| b.im.total_cmp(&a.im).then(a.re.total_cmp(&b.re)));
    for found in system.frequencies(&k) {
        let nearest = expected.iter().map(|z| (z - found).norm());
        assert!(nearest.fold(f64::INFINITY, f64::min) < 1e-12, "{found}");
    }
}

#[test]
fn the_largest_frequency_of_bars_with_consistent_masses_is_the_root_of_twelve() {
    let lattice = LatticeKind::Chain.lattice::<1>(1.0).expect("a lattice");
    let crystal = Crystal::of_lattice(lattice);
    let number = SMatrix::<f64, 1, 1>::from_element;
    let (home, next) = (Particle::home(0), Particle::home(0).moved(&[1]));
    let (mut stiffness, mut mass) = (BlochBlocks::new(), BlochBlocks::new());
    for (from, to, k, m) in [
        (home, home, 2.0, 2.0 / 3.0),
        (home, next, -1.0, 1.0 / 6.0),
        (next, home, -1.0, 1.0 / 6.0),
    ] {
        stiffness.add(&from, &to, &number(k));
        mass.add(&from, &to, &number(m));
    }
    let (stiffness, mass) = (stiffness.sum(&crystal), mass.sum(&crystal));
    assert_eq!(lumped_masses(&crystal, 1.0), [1.0]);
    let consistent = WaveSystem::new(crystal.clone(), stiffness.clone(), Mass::Consistent(mass));
    let lumped = WaveSystem::new(crystal, stiffness, Mass::Lumped(vec![1.0]));
    let search = ZoneSearch::of_lattice(lattice, 1.0);
    for (system, largest) in [(consistent, 12.0_f64.sqrt()), (lumped, 2.0)] {
        let summary = search.summary_of(&system);
        assert!((summary.maximum_omega - largest).abs() < 1e-10);
        assert!((summary.long_wave.scaled - 1.0).abs() < 1e-12);
    }
}
