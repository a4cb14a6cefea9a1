//! Analysis of a method and a material in any number of dimensions, without the dimension as a type parameter.
//!
//! The modules below are generic over a lattice of `D` dimensions. Only this module converts `D` to a run-time number: [`analysis`] creates an
//! [`Analysis`] from [`MethodChoices`] and a material. Its results have the types of the other modules for `D = 3`, in which vectors of a line or a
//! plane are padded with zeros. Reference wave vectors are passed as slices of [`Analysis::dimension`] components.

mod body;
mod in_space;

use crate::algebra::Complex;
use crate::bloch::SpectrumSummary;
use crate::certificate::Certificate;
use crate::continuum::AcousticMinimum;
use crate::kinematics::{DeformationGradient, DeformationPath};
use crate::lattice::LatticeKind;
use crate::material::{Hyperelastic, MaterialError, Viscoelastic};
use crate::measures::{DispersionError, Fidelity, Load, OnsetPair, SpuriousModes, StateWindow};
use crate::method::MethodError;
use crate::motion::{
    ActualBody, ActualModes, BodyError, BodyMode, BodyMotion, BodyParticles, Contact, Grip,
    PatchMotion, PlacedParticle, fastest_mode, lowest_modes,
};
use crate::scheme::MethodChoices;
use crate::time_step::{Integrator, Oscillation, Stepping, WaveParts};
use crate::verdict::{
    Assessment, Judged, PathError, PathScan, Probe, SurveyedState, WeakestMode, probe_material,
    scan_material,
};
use body::{Body, acoustic_eigenvalues, acoustic_minimum};
use nalgebra::{DMatrix, SMatrix, SVector};
use std::sync::Arc;

/// A discretization with a material, ready for analysis.
pub trait Analysis: Send + Sync {
    /// Number of space dimensions.
    fn dimension(&self) -> usize;

    /// Particle spacing of the reference configuration; length.
    fn spacing(&self) -> f64;

    /// Number of particles of a cell.
    fn sites(&self) -> usize;

    /// Number of neighbors of a particle; from [`Discretization::neighbors`](crate::scheme::Discretization::neighbors).
    fn neighbors(&self) -> f64;

    /// Returns true if an undeformed lattice represents the deformed state.
    fn is_regular(&self) -> bool;

    /// Squared wave speed `c^2` that scales the measures. Length^2/time^2.
    ///
    /// # Errors
    /// [`MethodError`] if the material in the reference state cannot be evaluated, or has no waves there.
    fn speed_squared(&self) -> Result<f64, MethodError>;

    /// Prepares the analysis for many states, with [`Survey::for_many_states`](crate::verdict::Survey::for_many_states).
    ///
    /// # Errors
    /// [`MethodError`] if the method cannot be evaluated.
    fn for_many_states(self: Box<Self>) -> Result<Box<dyn Analysis>, MethodError>;

    /// Returns the verdict on a state with its evidence.
    ///
    /// # Errors
    /// [`MethodError`] if material or method cannot be evaluated there.
    fn assess(&self, f: &DeformationGradient) -> Result<Assessment<3>, MethodError>;

    /// Returns the verdict on a state and the type of instability, several times faster than [`Analysis::assess`].
    ///
    /// Witnesses of neighboring states can be given if they are known, as for [`Survey::judge_beside`](crate::verdict::Survey::judge_beside).
    ///
    /// # Errors
    /// [`MethodError`] if material or method cannot be evaluated there.
    fn judge(
        &self,
        f: &DeformationGradient,
        beside: Option<&[SVector<f64, 3>]>,
    ) -> Result<Judged<3>, MethodError>;

    /// Returns the data of a map at many states. Each result is independent of the other states.
    fn states(&self, states: &[DeformationGradient]) -> Vec<Result<SurveyedState<3>, MethodError>>;

    /// Returns the data of a map at many states from `count` wave vectors along each reciprocal vector, without a search between them; see
    /// [`Survey::sampled`](crate::verdict::Survey::sampled).
    fn sampled_states(
        &self,
        states: &[DeformationGradient],
        count: usize,
    ) -> Vec<Result<SurveyedState<3>, MethodError>>;

    /// Returns the phase of the particles at a state (stable, divergence, flutter or undefined), with its measure.
    ///
    /// # Errors
    /// [`MethodError`] if the state cannot be evaluated for a reason other than its support or the domain of the law.
    fn probe(&self, f: &DeformationGradient) -> Result<Probe, MethodError>;

    /// Returns the smallest acoustic eigenvalue of the material for waves in the dimensions of the method.
    ///
    /// # Errors
    /// [`MaterialError`] if the material cannot be evaluated there.
    fn acoustic_minimum(
        &self,
        f: &DeformationGradient,
    ) -> Result<AcousticMinimum<3>, MaterialError>;

    /// Returns all losses and recoveries of the stability of the particles along a path.
    ///
    /// # Errors
    /// [`PathError`] if a state cannot be evaluated.
    fn scan(&self, path: &dyn DeformationPath) -> Result<PathScan, PathError>;

    /// Returns the certificate of a state. The waves of a method are undecided if its force constants have no interval enclosure.
    ///
    /// # Errors
    /// [`MethodError`] if the material, or a method with enclosed force constants, cannot be evaluated there.
    fn certify(
        &self,
        f: &DeformationGradient,
        tolerance: f64,
    ) -> Result<Certificate<3>, MethodError>;

    /// Returns the extremes of the spectrum at a state.
    ///
    /// # Errors
    /// [`MethodError`] if material or method cannot be evaluated there.
    fn spectrum(&self, f: &DeformationGradient) -> Result<SpectrumSummary<3>, MethodError>;

    /// Returns the plane waves of a state.
    ///
    /// # Errors
    /// [`MethodError`] if material or method cannot be evaluated there.
    fn waves(&self, f: &DeformationGradient) -> Result<Box<dyn PlaneWaves>, MethodError>;

    /// Splits `D(k)` of each wave vector into the contributions of positions, and of the stress and the density that particles carry and codes integrate
    /// (1/time^2), with its damping (1/time).
    ///
    /// Everything is assigned to the positions if the method does not distinguish these parts
    /// ([`Discretization::carried`](crate::scheme::Discretization::carried)).
    ///
    /// # Errors
    /// [`MethodError`] if material or method cannot be evaluated there.
    fn parts(
        &self,
        f: &DeformationGradient,
        waves: &[Vec<f64>],
    ) -> Result<Vec<WaveParts>, MethodError>;

    /// Returns the ratio of the squared norms of the discrete and the exact gradient of a wave; `None` if the method does not provide it.
    ///
    /// # Errors
    /// [`MethodError`] if the method cannot be evaluated there.
    fn gradient_norm(&self, f: &DeformationGradient, k: &[f64])
    -> Result<Option<f64>, MethodError>;

    /// Returns true if a wave exists at this wave vector whose strain is zero at every quadrature point, for any law.
    ///
    /// # Errors
    /// [`MethodError`] if the method cannot be evaluated there.
    fn has_unstrained_wave(&self, f: &DeformationGradient, k: &[f64]) -> Result<bool, MethodError>;

    /// Wave vector `F^-T k` in the deformed lattice of a reference wave vector; for a regular lattice `k` itself.
    fn spatial(&self, f: &DeformationGradient, k: &SVector<f64, 3>) -> SVector<f64, 3>;

    /// Reciprocal vectors of the reference lattice, one per dimension. 1/length.
    fn reciprocal(&self) -> Vec<SVector<f64, 3>>;

    /// Coordinates of a wave vector in units of the reciprocal vectors.
    fn fractional(&self, k: &SVector<f64, 3>) -> Vec<f64>;

    /// Rotations and reflections that map the reference lattice onto itself, the identity first; from
    /// [`BravaisLattice::holohedry`](crate::lattice::BravaisLattice::holohedry).
    fn holohedry(&self) -> Vec<SMatrix<f64, 3, 3>>;

    /// Standard path through a zone: names and reference wave vectors of its corners. 1/length.
    ///
    /// Without the name of a zone, the zone of the particles' named lattice is used, for any choice of their cell.
    fn zone_path(&self, zone: Option<LatticeKind>) -> Vec<(&'static str, Vec<f64>)>;

    /// Returns true if forces depend on velocities.
    fn is_damped(&self) -> bool;

    /// Returns true if the method defines a time step, independent of the integrator
    /// ([`Discretization::transferred`](crate::scheme::Discretization::transferred)).
    fn is_transferred(&self) -> bool;

    /// Returns the waves of a state in discrete time; `None` unless the method defines a time step.
    ///
    /// # Errors
    /// [`MethodError`] if material or method cannot be evaluated there.
    fn transferred(
        &self,
        f: &DeformationGradient,
    ) -> Result<Option<Box<dyn SteppedWaves>>, MethodError>;

    /// Returns the waves of a relaxed state of a viscoelastic law, whose long-term law is the material of this analysis.
    ///
    /// # Errors
    /// [`MethodError`] if material or method cannot be evaluated there.
    fn relaxing(
        &self,
        f: &DeformationGradient,
        law: &Viscoelastic,
    ) -> Result<Box<dyn Relaxing>, MethodError>;

    /// Returns the largest stable time steps of the integrators at a state. Time.
    ///
    /// The result is empty unless damping makes the time steps differ.
    ///
    /// # Errors
    /// [`MethodError`] if material or method cannot be evaluated there.
    fn damped_time_steps(
        &self,
        f: &DeformationGradient,
    ) -> Result<Vec<(Integrator, f64)>, MethodError>;

    /// Returns the largest stable time step of an integrator at a state, including damping. Time.
    ///
    /// For a method that defines a time step, it is the largest stable value of this step.
    ///
    /// # Errors
    /// [`MethodError`] if material or method cannot be evaluated there.
    fn critical_time_step(
        &self,
        f: &DeformationGradient,
        integrator: Integrator,
    ) -> Result<f64, MethodError>;

    /// Returns the weakest wave of the reference configuration; see [`Survey::weakest`](crate::verdict::Survey::weakest).
    ///
    /// # Errors
    /// [`MethodError`] if material or method cannot be evaluated.
    fn weakest(&self) -> Result<Option<WeakestMode<3>>, MethodError>;

    /// Returns the zero-energy and weakly controlled modes of the reference configuration.
    ///
    /// # Errors
    /// [`MethodError`] if material or method cannot be evaluated.
    fn spurious_modes(&self, threshold: f64) -> Result<SpuriousModes<3>, MethodError>;

    /// Returns the masses of the particles of a cell, for consistent mass matrices the row sums; mass (in 2D per unit thickness, in 1D
    /// per unit cross-section).
    ///
    /// # Errors
    /// [`MethodError`] if material or method cannot be evaluated there.
    fn masses(&self, f: &DeformationGradient) -> Result<Vec<f64>, MethodError>;

    /// Returns the particles of a periodic patch with `cells` cells along each primitive vector.
    fn patch(&self, cells: usize) -> Vec<PatchParticle>;

    /// Calls `work` with the motion of a periodic patch about a homogeneous state.
    ///
    /// The patch has `cells` cells along each primitive vector; at least one number per dimension is needed.
    ///
    /// # Errors
    /// [`MethodError`] if material or method cannot be evaluated there.
    fn with_motion(
        &self,
        f: &DeformationGradient,
        cells: &[usize],
        work: &mut dyn FnMut(&mut dyn PatchMotion),
    ) -> Result<(), MethodError>;

    /// Calls `work` with a body of particles of the method. Contact between the pieces of the body is optional.
    ///
    /// # Errors
    /// [`BodyError`] if the method does not support bodies, or if particles or grips are not admissible.
    fn with_body(
        &self,
        particles: &BodyParticles,
        grips: &[Grip],
        contact: Option<Contact>,
        work: &mut dyn FnMut(&mut dyn BodyMotion),
    ) -> Result<(), BodyError>;

    /// Returns the fastest oscillations of finite bodies at a state, which give the time step that is stable for all of them.
    ///
    /// # Errors
    /// [`MethodError`] if material or method cannot be evaluated there.
    fn finite_bodies(&self, f: &DeformationGradient)
    -> Result<FiniteBodyOscillations, MethodError>;

    /// Returns the frequency errors at wavelengths given in particle spacings.
    ///
    /// # Errors
    /// [`MethodError`] if material or method cannot be evaluated.
    fn dispersion_errors(&self, wavelengths: &[f64]) -> Result<Vec<DispersionError>, MethodError>;

    /// Returns the consistency error of the long-wavelength modulus.
    ///
    /// # Errors
    /// [`MethodError`] if material or method cannot be evaluated.
    fn long_wave_error(&self) -> Result<f64, MethodError>;

    /// Returns the first instabilities of material and method along a loading up to the imposed stretch `end`.
    ///
    /// # Errors
    /// [`MethodError`] if a state cannot be evaluated for a reason other than its support or the domain of the law.
    fn onset(&self, load: Load, end: f64) -> Result<OnsetPair, MethodError>;

    /// Returns the fractions of a window of states in which method and material disagree.
    ///
    /// # Errors
    /// [`MethodError`] if a state cannot be evaluated for a reason other than its support or the domain of the law.
    fn fidelity(&self, window: &StateWindow) -> Result<Fidelity, MethodError>;
}

/// Plane waves of a state. Wave vectors are reference wave vectors with one component per dimension; 1/length.
pub trait PlaneWaves: Send + Sync {
    /// Dynamical matrix `D(k)`; 1/time^2.
    fn dynamical_matrix_at(&self, k: &[f64]) -> DMatrix<Complex>;

    /// All `omega^2` without damping, sorted by real part; 1/time^2.
    fn omega_squared(&self, k: &[f64]) -> Vec<Complex>;

    /// All frequencies `omega`, including damping; 1/time.
    fn frequencies(&self, k: &[f64]) -> Vec<Complex>;

    /// Equivalent wave vector of the searched zone: `k` itself if `D(k)` is periodic, otherwise its equivalent in the first zone; 1/length.
    fn folded(&self, k: &[f64]) -> Vec<f64>;

    /// Largest factor that keeps a multiple of the wave vector within the searched zone; infinite for zero.
    fn reach(&self, k: &[f64]) -> f64;

    /// Squared frequencies of the continuum, the eigenvalues of `Q(k) / rho0`; 1/time^2.
    fn continuum_omega_squared(&self, k: &[f64]) -> Vec<f64>;
}

/// Plane waves of a state in discrete time, for a method that defines a time step.
///
/// They are computed by [`TransferredWaves`](crate::time_step::TransferredWaves). Wave vectors are as in [`PlaneWaves`].
pub trait SteppedWaves: Send + Sync {
    /// Rates `s = ln(z)/dt` of all solutions `exp(s t)` at whole steps, sorted by the real part of `omega^2`; 1/time.
    fn rates(&self, k: &[f64], step: f64) -> Vec<Complex>;

    /// Rate with the largest real part over the zone, with its wave vector; zero if no wave grows. 1/time, 1/length.
    fn fastest(&self, step: f64) -> (Complex, Vec<f64>);

    /// Largest stable step; infinite if nothing oscillates. Time.
    fn critical_time_step(&self) -> f64;

    /// Largest stable step of an isolated, unstressed material point; `None` for laws with stress in the reference state. Time.
    fn isolated_point(&self) -> Option<f64>;
}

/// Plane waves of a relaxed state of a viscoelastic law.
///
/// They are computed by [`RelaxingWaves`](crate::bloch::RelaxingWaves). Wave vectors are as in [`PlaneWaves`].
pub trait Relaxing: Send + Sync {
    /// Rates `s` of all solutions `exp(s t)`, largest real part first; 1/time.
    fn rates(&self, k: &[f64]) -> Vec<Complex>;

    /// Largest growth rate over the zone, with its wave vector; zero if no wave grows. 1/time, 1/length.
    fn fastest(&self) -> (f64, Vec<f64>);
}

/// Particle of a periodic patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchParticle {
    /// Index of the particle in its cell.
    pub site: usize,
    /// Position in the reference state; length.
    pub position: SVector<f64, 3>,
}

/// Fastest oscillations of finite bodies of a lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FiniteBodyOscillations {
    /// Bounds of the oscillations of the single parts or of the blocks. `None` if they are unknown, or if the waves of the lattice bound them.
    pub(crate) fastest: Option<Oscillation>,
    /// Reason why the bounds hold.
    pub(crate) ground: FiniteBodyGround,
}

impl FiniteBodyOscillations {
    /// Returns the stable time step of an integrator for all finite bodies, given its step of the infinite lattice; `None` if no step is known or stable.
    pub fn step(&self, integrator: Integrator, lattice: f64) -> Option<FiniteBodyStep> {
        let own = self.fastest.map(|own| own.critical_time_step(integrator));
        let time_step = match self.ground {
            FiniteBodyGround::Lattice => Some(lattice),
            FiniteBodyGround::Parts => own?,
            // The waves of the lattice travel inside a large body.
            FiniteBodyGround::Blocks => own?.map(|step| step.min(lattice)),
        };
        let ground = self.ground;
        let time_step = time_step.filter(|step| *step > 0.0 && step.is_finite());
        time_step.map(|time_step| FiniteBodyStep { time_step, ground })
    }
}

/// Stable time step of an integrator for finite bodies of a lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FiniteBodyStep {
    /// Largest time step that is known to be stable; time.
    pub time_step: f64,
    /// Reason why the step is known to be stable.
    pub ground: FiniteBodyGround,
}

/// Reason why a time step is stable for finite bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FiniteBodyGround {
    /// Proved for any body: the critical step of a single element or material point is a lower bound, attained by a body of one element or point.
    Parts,
    /// Proved for any body: the interactions in a body are a subset of the interactions of the lattice, which are positive semidefinite.
    Lattice,
    /// Computed: the smallest step of free blocks that are at least three particles thick.
    Blocks,
}

/// Calls a function that is generic in the dimension, for a dimension known at run time.
macro_rules! in_dimension {
    ($dimension:expr, $function:ident($($argument:expr),*)) => {
        match $dimension {
            1 => $function::<1>($($argument),*),
            2 => $function::<2>($($argument),*),
            _ => $function::<3>($($argument),*),
        }
    };
}

/// Creates the analysis of a method with a material.
///
/// ```
/// use onset::analysis::analysis;
/// use onset::kinematics::DeformationGradient;
/// use onset::material::ModifiedMooneyRivlin;
/// use onset::scheme::{MethodChoices, element::ElementChoices};
/// use onset::verdict::Verdict;
/// let elements = MethodChoices::FiniteElements(ElementChoices::default());
/// let analysis = analysis(&elements, std::sync::Arc::new(ModifiedMooneyRivlin::default()))?;
/// let f = DeformationGradient::from_stretches([1.2, 0.9, 1.0])?;
/// assert_eq!(analysis.assess(&f)?.verdict, Verdict::Stable);
/// assert_eq!(analysis.waves(&f)?.omega_squared(&[1.0, 0.5]).len(), 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`MethodError`] if the method cannot be set up.
pub fn analysis(
    method: &MethodChoices,
    material: Arc<dyn Hyperelastic>,
) -> Result<Box<dyn Analysis>, MethodError> {
    fn of<const D: usize>(
        method: &MethodChoices,
        material: Arc<dyn Hyperelastic>,
    ) -> Result<Box<dyn Analysis>, MethodError> {
        Ok(Box::new(Body::<D>::new(method.discretization()?, material)))
    }
    in_dimension!(method.dimension(), of(method, material))
}

/// Like [`analysis`], in the cell that the choices describe instead of the primitive cell; patches use it.
///
/// # Errors
/// [`MethodError`] if the method cannot be set up.
pub fn described_analysis(
    method: &MethodChoices,
    material: Arc<dyn Hyperelastic>,
) -> Result<Box<dyn Analysis>, MethodError> {
    fn of<const D: usize>(
        method: &MethodChoices,
        material: Arc<dyn Hyperelastic>,
    ) -> Result<Box<dyn Analysis>, MethodError> {
        Ok(Box::new(Body::<D>::new(method.described()?, material)))
    }
    in_dimension!(method.dimension(), of(method, material))
}

/// Numbers of particles of a described cell and of the primitive cell used by the analysis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ReducedCell {
    /// Particles of the cell that the choices describe.
    pub described: usize,
    /// Particles of the primitive cell.
    pub primitive: usize,
}

/// Returns the reduction of the cell of a method; `None` if the described cell is primitive or if the method cannot be set up.
pub fn reduced_cell(method: &MethodChoices) -> Option<ReducedCell> {
    fn of<const D: usize>(method: &MethodChoices) -> Option<ReducedCell> {
        let [described, primitive] = method.sites::<D>()?;
        (primitive != described).then_some(ReducedCell {
            described,
            primitive,
        })
    }
    in_dimension!(method.dimension(), of(method))
}

/// Returns the mode of a free body in a homogeneous state that limits the time step of a scheme; `None` for methods whose particles have no forces at
/// arbitrary positions. Particles marked in `held` do not move.
///
/// # Errors
/// [`BodyError`] if the method or the material cannot be evaluated for these particles.
pub fn body_mode(
    method: &MethodChoices,
    material: &dyn Hyperelastic,
    particles: &[PlacedParticle],
    held: &[bool],
    f: &DeformationGradient,
    stepping: Stepping,
) -> Result<Option<BodyMode>, BodyError> {
    in_dimension!(
        method.dimension(),
        fastest_mode(method, material, particles, held, f, stepping)
    )
}

/// Returns the `count` lowest modes of a body in an actual state, without rigid motions: `K u = omega^2 M u` with the tangent `K` of the forces
/// on its particles.
///
/// # Errors
/// [`BodyError`] if method or law have no tangent there, or if the body is too large.
pub fn actual_modes(
    method: &MethodChoices,
    material: &dyn Hyperelastic,
    body: &ActualBody<'_>,
    count: usize,
) -> Result<ActualModes, BodyError> {
    in_dimension!(
        method.dimension(),
        lowest_modes(method, material, body, count)
    )
}

/// Checks that a method can be set up, independent of the material.
///
/// # Errors
/// [`MethodError`] if the method cannot be set up.
pub fn check_method(method: &MethodChoices) -> Result<(), MethodError> {
    fn of<const D: usize>(method: &MethodChoices) -> Result<(), MethodError> {
        method.discretization::<D>().map(drop)
    }
    in_dimension!(method.dimension(), of(method))
}

/// Returns whether waves of a material grow at a state, for perturbations in `dimension` dimensions, with [`probe_material`].
///
/// # Errors
/// [`MaterialError`] if the response is not finite.
pub fn probe_material_in(
    dimension: usize,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
) -> Result<Probe, MaterialError> {
    in_dimension!(dimension, probe_material(material, f))
}

/// Returns all losses and recoveries of strong ellipticity along a path, for perturbations in `dimension` dimensions, with [`scan_material`].
///
/// # Errors
/// [`PathError`] if a state of the path cannot be evaluated.
pub fn scan_material_in(
    dimension: usize,
    material: &dyn Hyperelastic,
    path: &dyn DeformationPath,
) -> Result<PathScan, PathError> {
    in_dimension!(dimension, scan_material(material, path))
}

/// Returns the smallest acoustic eigenvalue of a material for perturbations in `dimension` dimensions.
///
/// # Errors
/// [`MaterialError`] if the response is not finite.
pub fn acoustic_minimum_in(
    dimension: usize,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
) -> Result<AcousticMinimum<3>, MaterialError> {
    in_dimension!(dimension, acoustic_minimum(material, f))
}

/// Returns the eigenvalues of the acoustic tensor of a material in the given directions of `dimension` dimensions, sorted; units of stress.
///
/// # Errors
/// [`MaterialError`] if the response is not finite.
pub fn acoustic_eigenvalues_in(
    dimension: usize,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
    directions: &[SVector<f64, 3>],
) -> Result<Vec<Vec<f64>>, MaterialError> {
    in_dimension!(dimension, acoustic_eigenvalues(material, f, directions))
}
