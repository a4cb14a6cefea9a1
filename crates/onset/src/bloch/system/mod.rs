//! Plane waves of discretizations with several particles in a cell, consistent masses, damping or smoothed velocities.
//!
//! The linearized discrete equations are `M dv/dt = -K u - C v`, `du/dt = T v`. Usually `T = 1`; if velocities are smoothed before they move the
//! particles (XSPH), `T` is a sum over neighbors. A wave `exp(i (k.X - omega t))` then satisfies `(omega^2 M + i omega C - K T) v = 0`. Without
//! damping, this is the eigenproblem of `D(k) = M^-1 K T`.

mod expansion;
mod long_wave;
mod sampled;
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

/// Smallest eigenvalue of the mass matrix, relative to the mass of a cell, that counts as nonzero; smaller values are rounding errors.
const VANISHING_MASS_FRACTION: f64 = 1e-9;

/// Linearized equations of motion of a discretization at a homogeneous state.
#[derive(Clone, Debug)]
pub struct WaveSystem<const D: usize> {
    crystal: Crystal<D>,
    /// Stiffness `K`: the negative derivative of the forces with respect to the displacements. Force/length.
    stiffness: BlochSum<D>,
    mass: Mass<D>,
    /// Damping `C`: the negative derivative of the forces with respect to the velocities. Force/velocity.
    damping: Option<BlochSum<D>>,
    /// Smoothing `T` of the velocities, `du/dt = T v`.
    drift: Option<BlochSum<D>>,
    is_hermitian: bool,
    /// System with fewer unknowns and the same nonzero `omega^2`.
    reduced: Option<Box<WaveSystem<D>>>,
}

/// Masses of a discretization.
#[derive(Clone, Debug, PartialEq)]
pub enum Mass<const D: usize> {
    /// One mass for each particle of a cell.
    Lumped(Vec<f64>),
    /// Mass matrix, as for consistent finite elements.
    Consistent(BlochSum<D>),
}

impl<const D: usize> Mass<D> {
    /// Masses of the particles of a cell; the row sums of a consistent mass matrix.
    pub(crate) fn of_particles(&self) -> Cow<'_, [f64]> {
        match self {
            Self::Lumped(masses) => Cow::Borrowed(masses),
            Self::Consistent(sum) => sum.row_sums().iter().map(|block| block[(0, 0)]).collect(),
        }
    }
}

impl<const D: usize> WaveSystem<D> {
    /// Creates a system without damping and without smoothed velocities.
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

    /// Returns the system with damping.
    #[must_use]
    pub fn with_damping(mut self, damping: BlochSum<D>) -> Self {
        self.damping = (damping.magnitude() > 0.0).then_some(damping);
        self
    }

    /// Returns the system with velocities that are smoothed before they move the particles, `du/dt = T v`.
    #[must_use]
    pub fn with_drift(mut self, drift: BlochSum<D>) -> Self {
        self.drift = Some(drift);
        self.is_hermitian = false;
        // The reduced system belongs to the unsmoothed equations.
        self.reduced = None;
        self
    }

    /// Attaches a system with fewer unknowns on the same lattice, which has all nonzero `omega^2` at every wave vector.
    ///
    /// If `D = A B` and `A` has more rows than columns, this is `B A`; displacements in the null space of `B` cause no force.
    #[must_use]
    pub fn with_reduced(mut self, reduced: Self) -> Self {
        self.reduced = Some(Box::new(reduced));
        self
    }

    /// Returns the system with fewer unknowns, if it exists.
    pub fn reduced(&self) -> Option<&Self> {
        self.reduced.as_deref()
    }

    /// Lattice of the particles in the reference state.
    pub fn crystal(&self) -> &Crystal<D> {
        &self.crystal
    }

    /// Stiffness `K`. Force/length.
    pub fn stiffness(&self) -> &BlochSum<D> {
        &self.stiffness
    }

    /// Masses `M` of the particles.
    pub fn mass(&self) -> &Mass<D> {
        &self.mass
    }

    /// Masses of the particles of a cell; the row sums of a consistent mass matrix.
    pub(crate) fn particle_masses(&self) -> Cow<'_, [f64]> {
        self.mass.of_particles()
    }

    /// Damping `C`, if forces depend on velocities. Force/velocity.
    pub fn damping(&self) -> Option<&BlochSum<D>> {
        self.damping.as_ref()
    }

    /// Smoothing `T` of the velocities, if they are smoothed. Dimensionless.
    pub fn drift(&self) -> Option<&BlochSum<D>> {
        self.drift.as_ref()
    }

    /// Number of degrees of freedom of a cell, `D n`.
    pub fn size(&self) -> usize {
        self.stiffness.size()
    }

    /// Number of particles in a cell.
    pub(super) fn sites(&self) -> usize {
        self.crystal.sites().len()
    }

    /// Returns true if the forces, apart from damping, derive from an energy; then all `omega^2` are real.
    pub fn is_hermitian(&self) -> bool {
        self.is_hermitian
    }

    /// Returns true if all entries are finite.
    pub fn is_finite(&self) -> bool {
        self.stiffness.magnitude().is_finite()
    }

    /// Checks that a consistent mass matrix is regular for waves in which neighboring particles move in opposite directions. With one quadrature
    /// point in the middle of a cell it is singular there.
    ///
    /// # Errors
    /// [`MethodError::SingularMass`] if the mass vanishes: such waves have no equation of motion, and frequencies are unbounded.
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
            if least <= VANISHING_MASS_FRACTION * self.cell_mass() {
                return Err(MethodError::SingularMass {
                    phases: phases.to_vec(),
                });
            }
        }
        Ok(())
    }

    /// Mass matrix `M(k)` at a wave vector.
    pub fn mass_at(&self, k: &SVector<f64, D>) -> DMatrix<Complex> {
        match &self.mass {
            Mass::Consistent(sum) => sum.at(k),
            Mass::Lumped(masses) => DMatrix::from_fn(self.size(), self.size(), |i, j| {
                let mass = if i == j { masses[i / D] } else { 0.0 };
                Complex::new(mass, 0.0)
            }),
        }
    }

    /// Returns `M^-1` times a matrix at a wave vector; NaN if the mass matrix is singular.
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

    /// Dynamical matrix `D(k) = M^-1 K T`, with the undamped `omega^2` as eigenvalues.
    ///
    /// Shape `(D n) x (D n)`. Unit 1/time^2.
    pub fn dynamical_matrix_at(&self, k: &SVector<f64, D>) -> DMatrix<Complex> {
        self.divided_by_mass(k, self.moved_stiffness_at(k))
    }

    /// Stiffness against the velocities of a wave, `K(k) T(k)` with the drift `T`. Force/length.
    pub(super) fn moved_stiffness_at(&self, k: &SVector<f64, D>) -> DMatrix<Complex> {
        let stiffness = self.stiffness.at(k);
        match &self.drift {
            Some(drift) => stiffness * drift.at(k),
            None => stiffness,
        }
    }

    /// Damping matrix `M^-1 C(k)` of viscous forces; `None` without damping. 1/time.
    pub fn damping_at(&self, k: &SVector<f64, D>) -> Option<DMatrix<Complex>> {
        let damping = self.damping.as_ref()?;
        Some(self.divided_by_mass(k, damping.at(k)))
    }

    /// Returns the system in units in which stiffness and mass have moderate magnitudes, and the unit of `omega^2`; `None` if this is already so.
    pub(super) fn in_moderate_units(&self) -> Option<(Self, f64)> {
        let [force, mass] = [self.stiffness.magnitude(), self.cell_mass()].map(moderate_unit);
        ([force, mass] != [1.0; 2]).then(|| (self.over(force, mass), force / mass))
    }

    /// Returns the system with stiffness and mass divided by the given units, and damping by the unit of force over velocity.
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

    /// Returns coordinates in which the forces have the same range in all directions, if the reference lattice is too oblique for them.
    pub(super) fn short_range(&self) -> Option<ShortRange<D>> {
        let place = |particle: &Particle<D>| self.crystal.place(particle);
        let force = |(from, to, block): (usize, &Particle<D>, &SMatrix<f64, D, D>)| {
            (place(to) - place(&Particle::home(from)), block.amax())
        };
        let forces: Vec<(SVector<f64, D>, f64)> = self.stiffness.blocks().map(force).collect();
        ShortRange::of(self.crystal.lattice(), &forces)
    }

    /// Returns the system in the coordinates of `range`.
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

    /// Returns the dynamical matrix of a system with one particle in a cell and lumped mass, without damping; otherwise `None`.
    ///
    /// Smoothed velocities turn `K` into `K T`, which is again a lattice sum. It is Hermitian if both factors are isotropic.
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
