//! A method and a material in any number of dimensions: the questions that programs ask, without a number of dimensions in their types.
//!
//! Everything below this room is written for a lattice of `D` dimensions. Here, and only here, `D` becomes a number of the run: of a
//! [`MethodChoices`] and a material [`analysis`] makes an [`Analysis`]. Its answers are those of the other rooms for `D = 3`, in which
//! vectors of a line or a plane have zeros beyond their dimensions; reference wave vectors that are asked for are slices of
//! [`Analysis::dimension`] components.

mod body;
mod in_space;

use crate::algebra::Complex;
use crate::bloch::{IsEnded, SpectrumSummary};
use crate::certificate::Certificate;
use crate::continuum::AcousticMinimum;
use crate::kinematics::{DeformationGradient, DeformationPath};
use crate::lattice::LatticeKind;
use crate::material::{Hyperelastic, MaterialError};
use crate::measures::{DispersionError, Fidelity, Load, OnsetPair, SpuriousModes, StateWindow};
use crate::method::MethodError;
use crate::motion::{BodyError, BodyMotion, BodyParticles, Contact, Grip, PatchMotion};
use crate::scheme::MethodChoices;
use crate::time_step::{Integrator, WaveParts};
use crate::verdict::{
    Assessment, Judged, PathError, PathScan, Probe, SurveyedState, probe_material, scan_material,
};
use body::{Body, acoustic_eigenvalues, acoustic_minimum};
use nalgebra::{DMatrix, SMatrix, SVector};
use std::sync::Arc;

/// A discretization and a material, ready to be asked.
pub trait Analysis: Send + Sync {
    /// The number of space dimensions.
    fn dimension(&self) -> usize;

    /// The distance of the particles; length.
    fn spacing(&self) -> f64;

    /// The particles of a cell.
    fn sites(&self) -> usize;

    /// See [`Discretization::neighbors`](crate::scheme::Discretization::neighbors).
    fn neighbors(&self) -> f64;

    /// Whether particles that have not moved stand for deformed ones.
    fn is_regular(&self) -> bool;

    /// The scale `c^2` of wave speeds. Length^2/time^2.
    ///
    /// # Errors
    /// [`MethodError`] when the material in the reference state cannot be evaluated, or carries no waves.
    fn speed_squared(&self) -> Result<f64, MethodError>;

    /// The same, prepared for many states; see [`Survey::for_many_states`](crate::verdict::Survey::for_many_states).
    ///
    /// # Errors
    /// [`MethodError`] when the method cannot be evaluated.
    fn for_many_states(self: Box<Self>) -> Result<Box<dyn Analysis>, MethodError>;

    /// The verdict on a state with its evidence.
    ///
    /// # Errors
    /// [`MethodError`] when material or method cannot be evaluated there.
    fn assess(&self, f: &DeformationGradient) -> Result<Assessment<3>, MethodError> {
        self.assess_unless(f, &|| false)
    }

    /// The same, given up as soon as nobody waits for it any more.
    ///
    /// # Errors
    /// [`MethodError::GivenUp`] then, and as [`Analysis::assess`].
    fn assess_unless(
        &self,
        f: &DeformationGradient,
        is_ended: IsEnded<'_>,
    ) -> Result<Assessment<3>, MethodError>;

    /// The verdict on a state and how perturbations develop, several times faster; given the witnesses of the states beside it, where these are
    /// known: see [`Survey::judge_beside`](crate::verdict::Survey::judge_beside).
    ///
    /// # Errors
    /// [`MethodError`] when material or method cannot be evaluated there.
    fn judge(
        &self,
        f: &DeformationGradient,
        beside: Option<&[SVector<f64, 3>]>,
    ) -> Result<Judged<3>, MethodError>;

    /// What a map shows of states, each as it would be computed alone.
    fn states(&self, states: &[DeformationGradient]) -> Vec<Result<SurveyedState<3>, MethodError>>;

    /// The phase of the particles.
    ///
    /// # Errors
    /// [`MethodError`] when the state cannot be evaluated for another reason than its support or the law's domain.
    fn probe(&self, f: &DeformationGradient) -> Result<Probe, MethodError>;

    /// The smallest acoustic eigenvalue of the material for waves in the dimensions of the method.
    ///
    /// # Errors
    /// [`MaterialError`] when the material cannot be evaluated there.
    fn acoustic_minimum(
        &self,
        f: &DeformationGradient,
    ) -> Result<AcousticMinimum<3>, MaterialError>;

    /// All losses and returns of the stability of the particles along a path.
    ///
    /// # Errors
    /// [`PathError`] when a state cannot be evaluated.
    fn scan(&self, path: &dyn DeformationPath) -> Result<PathScan, PathError>;

    /// What is proved of a state. Waves of a method whose force constants are not enclosed in intervals are undecided.
    ///
    /// # Errors
    /// [`MethodError`] when the material cannot be evaluated there, or a method of which waves are proved.
    fn certify(
        &self,
        f: &DeformationGradient,
        tolerance: f64,
    ) -> Result<Certificate<3>, MethodError>;

    /// The extremes of the spectrum at a state.
    ///
    /// # Errors
    /// [`MethodError`] when material or method cannot be evaluated there.
    fn spectrum(&self, f: &DeformationGradient) -> Result<SpectrumSummary<3>, MethodError>;

    /// The plane waves of a state.
    ///
    /// # Errors
    /// [`MethodError`] when material or method cannot be evaluated there.
    fn waves(&self, f: &DeformationGradient) -> Result<Box<dyn PlaneWaves>, MethodError>;

    /// `D(k)` by what codes integrate of it: positions, and the stress and the density that particles carry along; see
    /// [`Discretization::carried`](crate::scheme::Discretization::carried). All of it follows the positions where the method tells no parts apart. 1/time^2.
    ///
    /// # Errors
    /// [`MethodError`] when material or method cannot be evaluated there.
    fn parts(&self, f: &DeformationGradient, k: &[f64]) -> Result<WaveParts, MethodError>;

    /// The squared norm of the discrete gradient of a wave over that of the exact one, where the method tells it.
    ///
    /// # Errors
    /// [`MethodError`] when the method cannot be evaluated there.
    fn gradient_norm(&self, f: &DeformationGradient, k: &[f64])
    -> Result<Option<f64>, MethodError>;

    /// A reference wave vector in the deformed lattice, `F^-T k`; of a regular lattice `k` itself.
    fn spatial(&self, f: &DeformationGradient, k: &SVector<f64, 3>) -> SVector<f64, 3>;

    /// The reciprocal vectors of the reference lattice, as many as there are dimensions. 1/length.
    fn reciprocal(&self) -> Vec<SVector<f64, 3>>;

    /// A wave vector in units of the reciprocal vectors.
    fn fractional(&self, k: &SVector<f64, 3>) -> Vec<f64>;

    /// The rotations and reflections that map the reference lattice onto itself, the identity first; see
    /// [`BravaisLattice::holohedry`](crate::lattice::BravaisLattice::holohedry).
    fn holohedry(&self) -> Vec<SMatrix<f64, 3, 3>>;

    /// The usual path through a zone: names and reference wave vectors of its corners; without a name of the zone, of the named lattice that the
    /// particles are on, however it is described. 1/length.
    fn zone_path(&self, zone: Option<LatticeKind>) -> Vec<(&'static str, Vec<f64>)>;

    /// Whether forces depend on velocities.
    fn is_damped(&self) -> bool;

    /// Whether the method has a step of its own, whatever the integrator; see
    /// [`Discretization::transferred`](crate::scheme::Discretization::transferred).
    fn is_transferred(&self) -> bool;

    /// The waves of a state in steps of time, where the method has a step of its own.
    ///
    /// # Errors
    /// [`MethodError`] when material or method cannot be evaluated there.
    fn transferred(
        &self,
        f: &DeformationGradient,
    ) -> Result<Option<Box<dyn SteppedWaves>>, MethodError>;

    /// The largest stable time steps of the integrators at a state, where damping makes them differ; none otherwise. Time. They are given up as
    /// soon as nobody waits for them any more.
    ///
    /// # Errors
    /// [`MethodError::GivenUp`] then, others when material or method cannot be evaluated there.
    fn damped_time_steps_unless(
        &self,
        f: &DeformationGradient,
        is_ended: IsEnded<'_>,
    ) -> Result<Vec<(Integrator, f64)>, MethodError>;

    /// The largest stable time step of an integrator at a state, damping included; of a method with a step of its own that of it. Time.
    ///
    /// # Errors
    /// [`MethodError`] when material or method cannot be evaluated there.
    fn critical_time_step(
        &self,
        f: &DeformationGradient,
        integrator: Integrator,
    ) -> Result<f64, MethodError>;

    /// The waves of the reference configuration that the method does not resist, or too little.
    ///
    /// # Errors
    /// [`MethodError`] when material or method cannot be evaluated.
    fn spurious_modes(&self, threshold: f64) -> Result<SpuriousModes<3>, MethodError>;

    /// The masses of the particles of a cell, those of consistent mass matrices summed by rows; mass (per unit of the dimensions that are left out).
    ///
    /// # Errors
    /// [`MethodError`] when material or method cannot be evaluated there.
    fn masses(&self, f: &DeformationGradient) -> Result<Vec<f64>, MethodError>;

    /// The particles of a periodic patch with so many cells along each primitive vector.
    fn patch(&self, cells: usize) -> Vec<PatchParticle>;

    /// Does something with the motion of a periodic patch about a homogeneous state; `cells` along each primitive vector, at least as many
    /// numbers as dimensions.
    ///
    /// # Errors
    /// [`MethodError`] when material or method cannot be evaluated there.
    fn with_motion(
        &self,
        f: &DeformationGradient,
        cells: &[usize],
        work: &mut dyn FnMut(&mut dyn PatchMotion),
    ) -> Result<(), MethodError>;

    /// Does something with a body of particles of the method, between the pieces of which there can be a contact.
    ///
    /// # Errors
    /// [`BodyError`] when the method has no bodies, and when particles or grips cannot be.
    fn with_body(
        &self,
        particles: &BodyParticles,
        grips: &[Grip],
        contact: Option<Contact>,
        work: &mut dyn FnMut(&mut dyn BodyMotion),
    ) -> Result<(), BodyError>;

    /// A time step of central differences for all finite bodies at a state, given that of the infinite lattice; `None` where nothing is known of them.
    ///
    /// # Errors
    /// [`MethodError`] when material or method cannot be evaluated there.
    fn finite_bodies(
        &self,
        f: &DeformationGradient,
        lattice: f64,
    ) -> Result<Option<FiniteBodyStep>, MethodError>;

    /// The errors of frequencies at wavelengths in particle spacings.
    ///
    /// # Errors
    /// [`MethodError`] when material or method cannot be evaluated.
    fn dispersion_errors(&self, wavelengths: &[f64]) -> Result<Vec<DispersionError>, MethodError>;

    /// The error of the stiffness that long waves feel.
    ///
    /// # Errors
    /// [`MethodError`] when material or method cannot be evaluated.
    fn long_wave_error(&self) -> Result<f64, MethodError>;

    /// The first instability of material and method along a loading up to a stretch.
    ///
    /// # Errors
    /// [`MethodError`] when a state cannot be evaluated for another reason than its support or the law's domain.
    fn onset(&self, load: Load, end: f64) -> Result<OnsetPair, MethodError>;

    /// Shares of a window of states on which method and material differ.
    ///
    /// # Errors
    /// [`MethodError`] when a state cannot be evaluated for another reason than its support or the law's domain.
    fn fidelity(&self, window: &StateWindow) -> Result<Fidelity, MethodError>;
}

/// The plane waves of a state. Wave vectors are reference ones, with as many components as there are dimensions; 1/length.
pub trait PlaneWaves: Send + Sync {
    /// `D(k)`; 1/time^2.
    fn dynamical_matrix_at(&self, k: &[f64]) -> DMatrix<Complex>;

    /// All `omega^2` without damping, by increasing real part; 1/time^2.
    fn omega_squared(&self, k: &[f64]) -> Vec<Complex>;

    /// All `omega`, damping included; 1/time.
    fn frequencies(&self, k: &[f64]) -> Vec<Complex>;

    /// The wave vector of the searched zone that has the same waves: `k` itself where `D(k)` is periodic, otherwise the equivalent one of
    /// the first zone; 1/length.
    fn folded(&self, k: &[f64]) -> Vec<f64>;

    /// How many times a wave vector fits into the searched zone; infinite for zero.
    fn reach(&self, k: &[f64]) -> f64;

    /// Those of the continuum, the eigenvalues of `Q(k) / rho0`; 1/time^2.
    fn continuum_omega_squared(&self, k: &[f64]) -> Vec<f64>;
}

/// The plane waves of a state in steps of time, of a method with a step of its own; see
/// [`TransferredWaves`](crate::time_step::TransferredWaves). Wave vectors as those of [`PlaneWaves`].
pub trait SteppedWaves: Send + Sync {
    /// The rates `s = ln(z)/dt` of all solutions `exp(s t)` at whole steps, by increasing real part of `omega^2`; 1/time.
    fn rates(&self, k: &[f64], step: f64) -> Vec<Complex>;

    /// The rate with the largest real part over the zone with its wave vector; zero where no wave grows. 1/time, 1/length.
    fn fastest(&self, step: f64, is_ended: IsEnded<'_>) -> (Complex, Vec<f64>);

    /// The largest stable step; infinite where nothing oscillates. Time.
    fn critical_time_step(&self, is_ended: IsEnded<'_>) -> f64;

    /// The largest stable step of an isolated, unstressed material point; none of laws with stress in the reference state. Time.
    fn isolated_point(&self) -> Option<f64>;
}

/// A particle of a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchParticle {
    /// Its number in its cell.
    pub site: usize,
    /// Where it is in the reference state; length.
    pub position: SVector<f64, 3>,
}

/// A time step with which finite bodies of a lattice are stable under central differences.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FiniteBodyStep {
    /// Time.
    pub time_step: f64,
    /// Why it suffices.
    pub ground: FiniteBodyGround,
}

/// Why a time step suffices for finite bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FiniteBodyGround {
    /// Proved for any body: single elements or material points bound it, and a body of one attains it.
    Parts,
    /// Proved for any body: it has the positive semidefinite interactions of the lattice, and not all of them.
    Lattice,
    /// Found: the smallest of free blocks from three particles thick on.
    Blocks,
}

/// Calls a function that is generic in the dimension.
macro_rules! in_dimension {
    ($dimension:expr, $function:ident($($argument:expr),*)) => {
        match $dimension {
            1 => $function::<1>($($argument),*),
            2 => $function::<2>($($argument),*),
            _ => $function::<3>($($argument),*),
        }
    };
}

/// A method with a material.
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
/// [`MethodError`] when the method cannot be set up.
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

/// Like [`analysis`], in the cell that the choices describe, of which patches are made.
///
/// # Errors
/// [`MethodError`] when the method cannot be set up.
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

/// Numbers of particles of a described cell and of its primitive cell, in which questions are answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ReducedCell {
    /// Particles of the cell that the choices describe.
    pub described: usize,
    /// Particles of the primitive cell.
    pub primitive: usize,
}

/// The reduction of the cell of a method. `None` if the described cell is primitive, and for methods that cannot be set up.
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

/// Whether a method can be set up, whatever the material.
///
/// # Errors
/// [`MethodError`] when it cannot.
pub fn check_method(method: &MethodChoices) -> Result<(), MethodError> {
    fn of<const D: usize>(method: &MethodChoices) -> Result<(), MethodError> {
        method.discretization::<D>().map(drop)
    }
    in_dimension!(method.dimension(), of(method))
}

/// Whether waves of a material grow at a state, for perturbations in so many dimensions; see [`probe_material`].
///
/// # Errors
/// [`MaterialError`] when the response is not finite.
pub fn probe_material_in(
    dimension: usize,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
) -> Result<Probe, MaterialError> {
    in_dimension!(dimension, probe_material(material, f))
}

/// All losses and returns of strong ellipticity along a path, for perturbations in so many dimensions; see [`scan_material`].
///
/// # Errors
/// [`PathError`] when a state of the path cannot be evaluated.
pub fn scan_material_in(
    dimension: usize,
    material: &dyn Hyperelastic,
    path: &dyn DeformationPath,
) -> Result<PathScan, PathError> {
    in_dimension!(dimension, scan_material(material, path))
}

/// The smallest acoustic eigenvalue of a material for perturbations in so many dimensions.
///
/// # Errors
/// [`MaterialError`] when the response is not finite.
pub fn acoustic_minimum_in(
    dimension: usize,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
) -> Result<AcousticMinimum<3>, MaterialError> {
    in_dimension!(dimension, acoustic_minimum(material, f))
}

/// The eigenvalues of the acoustic tensor of a material, the smallest first, in some directions of so many dimensions; stress.
///
/// # Errors
/// [`MaterialError`] when the response is not finite.
pub fn acoustic_eigenvalues_in(
    dimension: usize,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
    directions: &[SVector<f64, 3>],
) -> Result<Vec<Vec<f64>>, MaterialError> {
    in_dimension!(dimension, acoustic_eigenvalues(material, f, directions))
}
