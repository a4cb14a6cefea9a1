//! Plane waves of discretizations with any number of particles in a cell, with consistent masses, damping and smoothed
//! velocities.
//!
//! The linearized discrete equations are `M dv/dt = -K u - C v`, `du/dt = T v`. Usually `T = 1`; velocities that are smoothed
//! before they move the particles (XSPH) make it a sum over neighbors. A wave `exp(i (k.X - omega t))` then obeys
//! `(omega^2 M + i omega C - K T) v = 0`, without damping the eigenproblem of `D(k) = M^-1 K T`.

mod expansion;
mod long_wave;
mod spectrum;
mod sum;
mod zone;

pub(super) use expansion::MatrixExpansion;
pub use sum::{BlochBlocks, BlochSum};

use super::short_range::ShortRange;
use super::{DynamicalMatrix, dynamical_matrix::ForceConstants};
use crate::algebra::{Complex, Each, array_of, hermitian_eigen, moderate_unit};
use crate::lattice::{Crystal, Particle, Reduced};
use crate::method::MethodError;
use nalgebra::{DMatrix, SMatrix, SVector};
use std::borrow::Cow;

/// A mass below this fraction of that of a cell vanishes.
const MASSLESS: f64 = 1e-9;

/// The linearized equations of motion of a discretization at a homogeneous state.
#[derive(Clone, Debug)]
pub struct WaveSystem<const D: usize> {
    crystal: Crystal<D>,
    /// `K`: minus the derivative of the forces by the displacements; force/length.
    stiffness: BlochSum<D>,
    mass: Mass<D>,
    /// `C`: minus the derivative of the forces by the velocities.
    damping: Option<BlochSum<D>>,
    /// `T`, where velocities are smoothed.
    drift: Option<BlochSum<D>>,
    is_hermitian: bool,
    /// A system of fewer unknowns with the same `omega^2` other than zero.
    reduced: Option<Box<WaveSystem<D>>>,
}

/// The masses of a discretization.
#[derive(Clone, Debug, PartialEq)]
pub enum Mass<const D: usize> {
    /// One number for each particle of a cell.
    Lumped(Vec<f64>),
    /// A mass matrix, as consistent finite elements have.
    Consistent(BlochSum<D>),
}

impl<const D: usize> WaveSystem<D> {
    /// The system without damping and with unsmoothed velocities.
    pub fn new(crystal: Crystal<D>, stiffness: BlochSum<D>, mass: Mass<D>) -> Self {
        let is_hermitian = stiffness.is_hermitian();
        Self {
            crystal,
            stiffness,
            mass,
            damping: None,
            drift: None,
            is_hermitian,
            reduced: None,
        }
    }

    /// The same with damping.
    #[must_use]
    pub fn with_damping(mut self, damping: BlochSum<D>) -> Self {
        self.damping = (damping.magnitude() > 0.0).then_some(damping);
        self
    }

    /// The same with velocities that are smoothed before they move the particles, `du/dt = T v`.
    #[must_use]
    pub fn with_drift(mut self, drift: BlochSum<D>) -> Self {
        self.drift = Some(drift);
        self.is_hermitian = false;
        // It is that of other equations.
        self.reduced = None;
        self
    }

    /// The same with a system of fewer unknowns on the same lattice that has all of its `omega^2` but zeros, at every wave vector. With
    /// `D = A B`, `A` of more rows than columns, that is `B A`; what is in the null space of `B` meets no force.
    #[must_use]
    pub fn with_reduced(mut self, reduced: Self) -> Self {
        self.reduced = Some(Box::new(reduced));
        self
    }

    /// The system of fewer unknowns, where there is one.
    pub fn reduced(&self) -> Option<&Self> {
        self.reduced.as_deref()
    }

    /// The lattice of the particles in the reference state.
    pub fn crystal(&self) -> &Crystal<D> {
        &self.crystal
    }

    /// `K`; force/length.
    pub fn stiffness(&self) -> &BlochSum<D> {
        &self.stiffness
    }

    /// `M`.
    pub fn mass(&self) -> &Mass<D> {
        &self.mass
    }

    /// The masses of the particles of a cell; of a consistent mass matrix the sums of its rows.
    pub(crate) fn particle_masses(&self) -> Cow<'_, [f64]> {
        match &self.mass {
            Mass::Lumped(masses) => Cow::Borrowed(masses),
            Mass::Consistent(sum) => sum.row_sums().iter().map(|block| block[(0, 0)]).collect(),
        }
    }

    /// `C`, where forces depend on velocities; force/velocity.
    pub fn damping(&self) -> Option<&BlochSum<D>> {
        self.damping.as_ref()
    }

    /// `T`, where velocities are smoothed; dimensionless.
    pub fn drift(&self) -> Option<&BlochSum<D>> {
        self.drift.as_ref()
    }

    /// The number of degrees of freedom of a cell, `D n`.
    pub fn size(&self) -> usize {
        self.stiffness.size()
    }

    /// The number of particles in a cell.
    pub(super) fn sites(&self) -> usize {
        self.crystal.sites().len()
    }

    /// Whether, damping apart, the forces derive from an energy, so that all `omega^2` are real.
    pub fn is_hermitian(&self) -> bool {
        self.is_hermitian
    }

    /// Whether all numbers are finite.
    pub fn is_finite(&self) -> bool {
        self.stiffness.magnitude().is_finite()
    }

    /// That a consistent mass does not vanish where particles alternate in sign, as it does with one point in the middle of a cell.
    ///
    /// # Errors
    /// [`MethodError::SingularMass`] when it does: there is no equation of motion for such waves, and frequencies have no bound.
    pub fn check_mass(&self) -> Result<(), MethodError> {
        let Mass::Consistent(mass) = &self.mass else {
            return Ok(());
        };
        let reciprocal = self.crystal.lattice().reciprocal();
        for corner in 1..1_usize << D {
            let phases: [u8; D] = array_of(|i| (corner >> i & 1) as u8);
            let k = reciprocal * SVector::from(phases.each(|phase| 0.5 * f64::from(phase)));
            let values = hermitian_eigen(mass.at(&k));
            let least = values.map_or(f64::NAN, |eigen| eigen.eigenvalues.min());
            if least <= MASSLESS * self.cell_mass() {
                return Err(MethodError::SingularMass {
                    phases: phases.to_vec(),
                });
            }
        }
        Ok(())
    }

    /// The mass matrix `M(k)`.
    pub fn mass_at(&self, k: &SVector<f64, D>) -> DMatrix<Complex> {
        match &self.mass {
            Mass::Consistent(sum) => sum.at(k),
            Mass::Lumped(masses) => DMatrix::from_fn(self.size(), self.size(), |i, j| {
                let mass = if i == j { masses[i / D] } else { 0.0 };
                Complex::new(mass, 0.0)
            }),
        }
    }

    /// `M^-1` times a matrix at a wave vector; not a number where the mass matrix is singular.
    fn divided_by_mass(&self, k: &SVector<f64, D>, matrix: DMatrix<Complex>) -> DMatrix<Complex> {
        match &self.mass {
            Mass::Lumped(masses) => {
                let mut matrix = matrix;
                for (i, mut row) in matrix.row_iter_mut().enumerate() {
                    row /= Complex::new(masses[i / D], 0.0);
                }
                matrix
            }
            Mass::Consistent(mass) => {
                let nan = Complex::new(f64::NAN, f64::NAN);
                let (rows, columns) = matrix.shape();
                let solved = mass.at(k).lu().solve(&matrix);
                solved.unwrap_or_else(|| DMatrix::repeat(rows, columns, nan))
            }
        }
    }

    /// `D(k) = M^-1 K T`, whose eigenvalues are `omega^2` without damping. Shape `(D n) x (D n)`, units 1/time^2.
    pub fn dynamical_matrix_at(&self, k: &SVector<f64, D>) -> DMatrix<Complex> {
        let stiffness = self.stiffness.at(k);
        let moved = match &self.drift {
            Some(drift) => stiffness * drift.at(k),
            None => stiffness,
        };
        self.divided_by_mass(k, moved)
    }

    /// The same with stiffness and mass in units in which neither is very large or small, and the unit of `omega^2`; none where
    /// they are neither.
    pub(super) fn in_moderate_units(&self) -> Option<(Self, f64)> {
        let [force, mass] = [self.stiffness.magnitude(), self.cell_mass()].map(moderate_unit);
        ([force, mass] != [1.0; 2]).then(|| (self.over(force, mass), force / mass))
    }

    /// The same with stiffness and mass divided by units, and damping by that of force over velocity.
    fn over(&self, force: f64, mass: f64) -> Self {
        Self {
            crystal: self.crystal.clone(),
            stiffness: self.stiffness.over(force),
            mass: match &self.mass {
                Mass::Lumped(masses) => Mass::Lumped(masses.iter().map(|m| m / mass).collect()),
                Mass::Consistent(sum) => Mass::Consistent(sum.over(mass)),
            },
            damping: self
                .damping
                .as_ref()
                .map(|damping| damping.over(force.sqrt() * mass.sqrt())),
            drift: self.drift.clone(),
            is_hermitian: self.is_hermitian,
            reduced: self
                .reduced
                .as_ref()
                .map(|reduced| Box::new(reduced.over(force, mass))),
        }
    }

    /// Coordinates in which the forces reach equally far in all directions, where the reference lattice is too oblique for
    /// them.
    pub(super) fn short_range(&self) -> Option<ShortRange<D>> {
        let place = |particle: &Particle<D>| self.crystal.place(particle);
        let force = |(from, to, block): (usize, &Particle<D>, &SMatrix<f64, D, D>)| {
            (place(to) - place(&Particle::home(from)), block.amax())
        };
        let forces: Vec<(SVector<f64, D>, f64)> = self.stiffness.blocks().map(force).collect();
        ShortRange::of(self.crystal.lattice(), &forces)
    }

    /// The same in such coordinates.
    pub(super) fn in_short_range(&self, range: &ShortRange<D>) -> Option<Self> {
        let lattice = range.lattice(self.crystal.lattice())?;
        let sites = self.crystal.sites().iter();
        let sites = sites.map(|place| range.inverse * place).collect();
        let volumes = self.crystal.volumes().to_vec();
        let crystal = Crystal::with_volumes(lattice, sites, volumes).ok()?;
        let moved = |sum: &BlochSum<D>| sum.relabeled(&range.inverse, &crystal);
        let reduced = match &self.reduced {
            Some(reduced) => Some(Box::new(reduced.in_short_range(range)?)),
            None => None,
        };
        Some(Self {
            reduced,
            stiffness: moved(&self.stiffness),
            mass: match &self.mass {
                Mass::Lumped(masses) => Mass::Lumped(masses.clone()),
                Mass::Consistent(sum) => Mass::Consistent(moved(sum)),
            },
            damping: self.damping.as_ref().map(moved),
            drift: self.drift.as_ref().map(moved),
            is_hermitian: self.is_hermitian,
            crystal: crystal.clone(),
        })
    }

    /// The dynamical matrix as a sum with one particle in a cell, where that is all there is and no mass is consistent; damping left
    /// out. Smoothed velocities make `K T` of it, which is a sum too, and Hermitian where both are isotropic.
    pub fn single(&self) -> Option<DynamicalMatrix<D>> {
        let Mass::Lumped(masses) = &self.mass else {
            return None;
        };
        let [mass] = masses[..] else {
            return None;
        };
        let drift_reach = self.drift.as_ref().map_or(0, BlochSum::reach);
        let mut constants = ForceConstants::new(
            Reduced::given(self.crystal.lattice().vectors()),
            (self.stiffness.reach() + drift_reach) as i32,
        );
        for (_, to, block) in self.stiffness.blocks() {
            let block = block / mass;
            match &self.drift {
                None => constants.add_to(&to.cell, &block),
                Some(drift) => {
                    for (_, beyond, smoothed) in drift.blocks() {
                        let cell = array_of(|i| to.cell[i] + beyond.cell[i]);
                        constants.add_to(&cell, &(block * smoothed));
                    }
                }
            }
        }
        Some(constants.finish(self.crystal.lattice(), false))
    }
}
