//! Loadings: the imposed stretch, the traction-free faces and the states that result.

use super::incompressible::{is_shape_separable, of_shape, pressurized, swollen};
use super::root::bracket_zero;
use super::{Kink, State};
use crate::algebra::array_of;
use crate::kinematics::{DeformationGradient, DeformationPath, KinematicsError};
use crate::material::{Hyperelastic, MaterialError, Response, huge_bulk_modulus};
use nalgebra::{Matrix2x3, Matrix3, Vector2, Vector3};
use std::sync::OnceLock;
use thiserror::Error;

/// Mode of loading of a specimen, with one imposed stretch `lambda`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Mode {
    /// One direction is stretched: `F11 = lambda`.
    Uniaxial,
    /// Two directions are stretched equally: `F11 = F22 = lambda`.
    Equibiaxial,
    /// One direction is stretched and a second direction is held, as in a wide strip ("pure shear").
    Planar,
    /// Simple shear, `F12 = gamma = lambda - 1/lambda`; `lambda` is the larger principal stretch.
    SimpleShear,
    /// All directions are stretched equally.
    Hydrostatic,
}

/// Constraint on the directions that are not loaded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Lateral {
    /// The directions keep their length.
    Held,
    /// The third direction keeps its length.
    PlaneStrain,
    /// The third direction is free: its faces are traction-free.
    PlaneStress,
    /// All faces that are not loaded are traction-free.
    Free,
}

/// Mode of loading with the constraint on the other directions.
///
/// | mode | `held` | `plane-strain` | `plane-stress` | `free` |
/// |---|---|---|---|---|
/// | `uniaxial` | `(l, 1, 1)` | `(l, *, 1)` | | `(l, *, *)` |
/// | `equibiaxial` | | `(l, l, 1)` | `(l, l, *)` | |
/// | `planar` | | `(l, 1/l, 1)` | `(l, 1, *)` | |
/// | `simple-shear` | | `(1, 1, 1)` | `(1, 1, *)` | `(1, *, *)` |
/// | `hydrostatic` | `(l, l, l)` | | | |
///
/// Stars mark components that are solved for: the diagonal components of `F` for which the normal tractions `P_22`, `P_33` vanish. Off-diagonal
/// components remain zero, so for laws with fibers that are not along the axes the faces carry shear.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Loading {
    /// Mode of loading: which stretch is imposed.
    pub mode: Mode,
    /// Constraint on the other directions.
    pub lateral: Lateral,
}

impl Mode {
    /// All modes of loading.
    pub const ALL: [Self; 5] = [
        Self::Uniaxial,
        Self::Equibiaxial,
        Self::Planar,
        Self::SimpleShear,
        Self::Hydrostatic,
    ];

    /// Name of the mode in files and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Uniaxial => "uniaxial",
            Self::Equibiaxial => "equibiaxial",
            Self::Planar => "planar",
            Self::SimpleShear => "simple-shear",
            Self::Hydrostatic => "hydrostatic",
        }
    }

    /// Name of the imposed quantity: a stretch, or in simple shear the amount of shear `gamma`.
    pub fn imposes(self) -> &'static str {
        match self {
            Self::SimpleShear => "amount of shear",
            _ => "stretch",
        }
    }

    /// Imposed stretch or amount of shear at `s = ln lambda`.
    ///
    /// ```
    /// use onset::criteria::Mode;
    /// // The larger principal stretch of simple shear by 1.5 is 2.
    /// assert!((Mode::SimpleShear.imposed(2.0_f64.ln()) - 1.5).abs() < 1e-15);
    /// assert!((Mode::SimpleShear.parameter(1.5) - 2.0_f64.ln()).abs() < 1e-15);
    /// ```
    pub fn imposed(self, s: f64) -> f64 {
        match self {
            Self::SimpleShear => 2.0 * s.sinh(),
            _ => s.exp(),
        }
    }

    /// Path parameter `s = ln lambda` at an imposed stretch or amount of shear.
    pub fn parameter(self, imposed: f64) -> f64 {
        match self {
            Self::SimpleShear => (0.5 * imposed).asinh(),
            _ => imposed.ln(),
        }
    }
}

impl Lateral {
    /// Name of the constraint in files and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Held => "held",
            Self::PlaneStrain => "plane-strain",
            Self::PlaneStress => "plane-stress",
            Self::Free => "free",
        }
    }
}

impl Loading {
    /// All loadings, in the order of tables.
    pub const ALL: [Self; 11] = {
        use Lateral::{Free, Held, PlaneStrain, PlaneStress};
        use Mode::{Equibiaxial, Hydrostatic, Planar, SimpleShear, Uniaxial};
        [
            Self::new(Uniaxial, Free),
            Self::new(Uniaxial, PlaneStrain),
            Self::new(Uniaxial, Held),
            Self::new(Equibiaxial, PlaneStress),
            Self::new(Equibiaxial, PlaneStrain),
            Self::new(Planar, PlaneStress),
            Self::new(Planar, PlaneStrain),
            Self::new(SimpleShear, Free),
            Self::new(SimpleShear, PlaneStress),
            Self::new(SimpleShear, PlaneStrain),
            Self::new(Hydrostatic, Held),
        ]
    };

    const fn new(mode: Mode, lateral: Lateral) -> Self {
        Self { mode, lateral }
    }

    /// Short description of the loading.
    pub fn title(self) -> &'static str {
        match (self.mode, self.lateral) {
            (Mode::Uniaxial, Lateral::Free) => "uniaxial, lateral faces free",
            (Mode::Uniaxial, Lateral::PlaneStrain) => "planar tension, axis 3 held",
            (Mode::Uniaxial, _) => "uniaxial strain",
            (Mode::Equibiaxial, Lateral::PlaneStress | Lateral::Free) => {
                "equibiaxial, plane stress"
            }
            (Mode::Equibiaxial, _) => "equibiaxial, plane strain",
            (Mode::Planar, Lateral::PlaneStress | Lateral::Free) => "planar tension (pure shear)",
            (Mode::Planar, _) => "planar, isochoric",
            (Mode::SimpleShear, Lateral::Free) => "simple shear, faces free",
            (Mode::SimpleShear, Lateral::PlaneStress) => "simple shear, plane stress",
            (Mode::SimpleShear, _) => "simple shear, plane strain",
            (Mode::Hydrostatic, _) => "hydrostatic",
        }
    }

    /// All loadings of a two-dimensional law, in the order of tables.
    pub const IN_PLANE: [Self; 5] = {
        use Lateral::{Held, PlaneStrain};
        [
            Self::new(Mode::Uniaxial, PlaneStrain),
            Self::new(Mode::Uniaxial, Held),
            Self::new(Mode::Equibiaxial, PlaneStrain),
            Self::new(Mode::Planar, PlaneStrain),
            Self::new(Mode::SimpleShear, PlaneStrain),
        ]
    };

    /// Short description of the loading for a two-dimensional law.
    pub fn title_in_plane(self) -> &'static str {
        match (self.mode, self.lateral) {
            (Mode::Uniaxial, Lateral::Held) => "uniaxial, edges held",
            (Mode::Uniaxial, _) => "uniaxial, edges free",
            (Mode::Equibiaxial, _) => "equibiaxial",
            (Mode::Planar, _) => "pure shear, area kept",
            (Mode::SimpleShear, _) => "simple shear",
            (Mode::Hydrostatic, _) => "hydrostatic",
        }
    }

    /// Returns true for uniaxial loading in plane strain. For an isotropic law it is planar tension with axes 2 and 3 exchanged.
    pub fn is_planar_tension_of_axis_2(self) -> bool {
        (self.mode, self.lateral) == (Mode::Uniaxial, Lateral::PlaneStrain)
    }

    /// Principal directions (0, 1, 2) whose stretch is solved for.
    fn free(self) -> &'static [usize] {
        match (self.mode, self.lateral) {
            (Mode::Uniaxial | Mode::SimpleShear, Lateral::Free) => &[1, 2],
            (Mode::Uniaxial, Lateral::PlaneStrain) => &[1],
            (Mode::Hydrostatic, _) => &[],
            (_, Lateral::PlaneStress | Lateral::Free) => &[2],
            _ => &[],
        }
    }

    /// Returns true if the faces normal to a direction (0, 1, 2) are traction-free, so that its stretch is solved for.
    ///
    /// ```
    /// use onset::criteria::{Lateral, Loading, Mode};
    /// let tension = Loading { mode: Mode::Uniaxial, lateral: Lateral::Free };
    /// assert!(tension.leaves_free(2) && !tension.leaves_free(0));
    /// ```
    pub fn leaves_free(self, axis: usize) -> bool {
        self.free().contains(&axis)
    }

    /// Free directions that remain to be solved for; the law of a sheet in plane stress computes the third stretch itself.
    fn free_of(self, material: &dyn Hyperelastic) -> &'static [usize] {
        let free = self.free();
        let own = free.partition_point(|axis| *axis < material.dimension());
        &free[..own]
    }

    /// Imposed part of `F` at `s = ln lambda`, with its derivative with respect to `s`. Free directions have length 1.
    pub(super) fn imposed(self, s: f64) -> (Matrix3<f64>, Matrix3<f64>) {
        let stretch = s.exp();
        let (mut f, mut rate) = (Matrix3::identity(), Matrix3::zeros());
        let mut stretched = |axis: usize, sign: f64| {
            f[(axis, axis)] = (sign * s).exp();
            rate[(axis, axis)] = sign * (sign * s).exp();
        };
        match (self.mode, self.lateral) {
            (Mode::Uniaxial, _) => stretched(0, 1.0),
            (Mode::Planar, Lateral::PlaneStress | Lateral::Free) => stretched(0, 1.0),
            (Mode::Planar, _) => {
                stretched(0, 1.0);
                stretched(1, -1.0);
            }
            (Mode::Equibiaxial, _) => (0..2).for_each(|axis| stretched(axis, 1.0)),
            (Mode::Hydrostatic, _) => (0..3).for_each(|axis| stretched(axis, 1.0)),
            (Mode::SimpleShear, _) => {
                f[(0, 1)] = stretch - stretch.recip();
                rate[(0, 1)] = stretch + stretch.recip();
            }
        }
        (f, rate)
    }
}

/// Range of stretches around 1 that a loading covers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    low: f64,
    high: f64,
}

/// Error of a range of stretches that is not admissible.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[error(
    "the range of stretches is {low:?} to {high:?}; expected a number below 1 and a number above 1 between {} and {}, for example 0.1,10",
    Range::LIMITS.0,
    Range::LIMITS.1
)]
pub struct RangeError {
    /// First number of the range.
    pub low: f64,
    /// Second number of the range.
    pub high: f64,
}

impl Default for Range {
    /// Returns the range from 0.1 to 10, which codes that fit laws to tests commonly check.
    fn default() -> Self {
        Self {
            low: 0.1,
            high: 10.0,
        }
    }
}

impl Range {
    /// Smallest and largest stretch that a range may contain.
    const LIMITS: (f64, f64) = (1e-3, 1e3);

    /// Creates the range from `low` below 1 to `high` above 1.
    ///
    /// # Errors
    /// [`RangeError`] if 1 is not between them, or if one of them is outside 1/1000 to 1000.
    pub fn new(low: f64, high: f64) -> Result<Self, RangeError> {
        let admitted = Self::LIMITS.0 <= low && low < 1.0 && 1.0 < high && high <= Self::LIMITS.1;
        match admitted {
            true => Ok(Self { low, high }),
            false => Err(RangeError { low, high }),
        }
    }

    /// Smallest stretch of the range.
    pub fn low(&self) -> f64 {
        self.low
    }

    /// Largest stretch of the range.
    pub fn high(&self) -> f64 {
        self.high
    }
}

/// State along a loading path.
#[derive(Clone, Debug)]
pub struct PathState {
    /// Path parameter `s = ln lambda` of the state.
    pub parameter: f64,
    /// Energy, stress and tangent, with the deformation gradient.
    pub response: Response,
    /// Rate `dF` along the loading toward larger `s`, including free directions, with respect to the arc length in `s` and the logarithms of the free
    /// stretches.
    pub rate: Matrix3<f64>,
    /// Logarithms of the free stretches, in the order of the axes.
    lateral: Vector2<f64>,
    /// Unit tangent of the branch, pointing away from the reference configuration, in the space of the logarithms of the free stretches and `s`.
    tangent: Vector3<f64>,
    /// Derivatives of the tractions, if they cost more than a response: neighboring states are then solved for with them.
    slopes: Option<Slopes>,
}

impl PathState {
    /// Logarithms of the free stretches, and `s`.
    fn place(&self) -> Vector3<f64> {
        self.lateral.push(self.parameter)
    }

    /// Change of `s` for a unit arc length of [`PathState::rate`].
    pub(super) fn pace(&self) -> f64 {
        self.tangent.z.abs()
    }

    /// Returns true if the chord to another state is nearly parallel to the branch at both ends, so that neither another branch nor a fold lies
    /// between them.
    fn leads_to(&self, other: &Self) -> bool {
        let chord = other.place() - self.place();
        let along = |tangent: &Vector3<f64>| chord.dot(tangent) >= ALONG * chord.norm();
        along(&self.tangent) && along(&other.tangent)
    }
}

/// Reason why a loading path ends in one direction.
#[derive(Clone, Debug, PartialEq)]
pub enum PathEnd {
    /// The path has reached the end of the range.
    Range,
    /// The law is not defined, or has no finite response, beyond the stretch.
    Law {
        /// Last stretch with a state.
        stretch: f64,
        /// Error of the law beyond the stretch.
        source: MaterialError,
    },
    /// The branch of states with free faces that starts at the reference configuration turns back, and no equilibrium exists nearby beyond it. At a limit
    /// point the tangent of the free faces is singular; at a kink of the stress the tangent jumps past this state.
    Fold {
        /// Stretch of the limit point, which is the last state.
        stretch: f64,
    },
    /// No state with free faces is found beyond the stretch.
    NoState {
        /// Last stretch with a state.
        stretch: f64,
    },
    /// The states change so rapidly with the stretch that the path was abandoned.
    GivenUp {
        /// Last stretch with a state.
        stretch: f64,
        /// Number of steps tried.
        trials: usize,
    },
}

/// Treatment of the volume in the response of a law.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Volume {
    Changes,
    Kept,
    /// Nearly incompressible response: the volume changes by the pressure divided by the bulk modulus.
    HardlyChanges {
        bulk: f64,
    },
}

/// Law under a loading, whose states are solved for.
#[derive(Clone, Copy)]
struct Problem<'a> {
    material: &'a dyn Hyperelastic,
    loading: Loading,
    volume: Volume,
    resolutions: Resolutions,
}

/// Resolutions of states, in logarithmic stretch.
#[derive(Clone, Copy)]
struct Resolutions {
    /// Whether the law integrates the path to a state: states are costly, and the tangent is not the derivative of the stress.
    integrated: bool,
    /// Smallest distance at which the end of a path, changes of criteria and kinks are resolved; zero for the resolution of the search.
    place: f64,
    /// Smallest distance from a fold or a minimum, in units of the interval around it: values there differ by the square of the distance.
    flat: f64,
    /// Accuracy of the free stretches.
    free: f64,
    /// Largest number of iterations for the free stretches.
    iterations: usize,
}

impl Resolutions {
    fn of(material: &dyn Hyperelastic) -> Self {
        match material.is_path_dependent() {
            true => Self {
                integrated: true,
                place: INTEGRATED,
                flat: INTEGRATED.sqrt(),
                free: 0.1 * INTEGRATED,
                // Iterations converge in less than ten steps.
                iterations: 20,
            },
            false => Self {
                integrated: false,
                place: 0.0,
                flat: f64::EPSILON,
                free: 4.0 * f64::EPSILON,
                iterations: ITERATIONS,
            },
        }
    }
}

impl Problem<'_> {
    /// Free directions that are solved for.
    fn free(&self) -> &'static [usize] {
        self.loading.free_of(self.material)
    }

    /// Returns true if the states depend on stretches that are solved for. For incompressible response this is only the case for a sheared cell with
    /// two free faces.
    fn solves_for_states(&self) -> bool {
        match self.volume {
            Volume::Changes => !self.free().is_empty(),
            _ => (self.loading.mode, self.loading.lateral) == (Mode::SimpleShear, Lateral::Free),
        }
    }
}

/// States of a loading in tension and in compression, followed from the reference configuration.
pub struct LoadingPath<'a> {
    problem: Problem<'a>,
    isotropic: bool,
    /// Loading that is followed.
    pub loading: Loading,
    /// States at increasing stretch, starting at the reference configuration.
    pub tension: Vec<PathState>,
    /// States at decreasing stretch, starting at the reference configuration.
    pub compression: Vec<PathState>,
    /// Reason why the path ends in tension.
    pub tension_end: PathEnd,
    /// Reason why the path ends in compression.
    pub compression_end: PathEnd,
    /// Whether criteria on increments of constant volume are evaluated for the shape alone.
    separates_shape: bool,
    /// Kinks of the law along the loading, computed on first use.
    pub(super) kinks: OnceLock<Vec<Kink>>,
}

/// Number of steps from the reference configuration to an end of the range.
const PATH_STEPS: usize = 192;
/// Number of trial steps along one side of a path before it is abandoned. A law with very large powers of its stretches permits only very short
/// steps.
const TRIALS: usize = 16 * PATH_STEPS;
/// Number of halvings of a step after which the path counts as ended.
const HALVINGS: i32 = 44;
/// Cosine of the largest angle between the branch at a state and the chord to the next state.
const ALONG: f64 = 0.9;
/// Step length; in shorter steps the branch may turn by any angle, as at a kink of the stress.
const KINKED: f64 = 1e-7;
/// Smallest jump of the derivatives of the tractions that counts as a kink, relative to their terms.
const SLOPE_JUMP: f64 = 1e-3;
/// Largest jump of the tractions that counts as none, relative to the change by a kink over a short step.
const TRACTION_JUMP: f64 = 0.1;
/// Longest step along a branch that does not reach the next parameter of the path.
const LONGEST: f64 = 0.05;
/// Distance from a fold, in `ln lambda`, within which the rounding error of the free stretches equals the distance.
const AT_FOLD: f64 = 1e-13;
/// Distance, in `ln lambda`, from the end of the domain of a law within which no states are kept.
const BEFORE_END: f64 = 1e-6;
/// Distance before a jump of the law at which a state is computed, since none can be computed at the jump itself; in steps of the path.
const BESIDE_JUMP: f64 = 1e-9;
/// Largest number of Newton iterations for the free stretches.
const ITERATIONS: usize = 40;
/// Distance of states, in `ln lambda`, at which the errors of a law that integrates the path to a state hide their difference.
const INTEGRATED: f64 = 1e-11;
/// Largest distance of the next state on a branch from its guess, in units of the step.
const STRAYED: f64 = 2.0;

/// Reason why a loading cannot be followed.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum LoadingError {
    /// The law has no response in the reference configuration.
    #[error("{0}")]
    Law(#[from] MaterialError),
    /// No state with free faces was found near the reference configuration.
    #[error(
        "at stretch 1 no lateral stretches with traction-free faces were found; expected a law that \
         is without stress at F = 1, or near it"
    )]
    NoReference,
    /// The loading changes the volume or has no traction-free face, so that the pressure of the incompressible response is undetermined.
    #[error(
        "the incompressible response needs a traction-free face, which determines the pressure; expected uniaxial, equibiaxial, planar or simple-shear loading with a free face"
    )]
    ChangesVolume,
}

/// Reason why a state does not exist.
enum Missing {
    Law(MaterialError),
    Equilibrium,
}

impl<'a> LoadingPath<'a> {
    /// Follows a loading over a range.
    ///
    /// An isotropic law whose bulk modulus exceeds 5e7 shear moduli is replaced by its incompressible response if the loading can preserve the
    /// volume. Otherwise rounding would hide the change of volume that carries the pressure. If the loading imposes all stretches, criteria on increments
    /// of constant volume are evaluated for the shape alone, where the law is the sum of an energy of the shape and an energy of the volume.
    ///
    /// # Errors
    /// [`LoadingError`] if no state exists in the reference configuration, `lambda = 1`.
    pub fn new(
        material: &'a dyn Hyperelastic,
        isotropic: bool,
        loading: Loading,
        range: &Range,
    ) -> Result<Self, LoadingError> {
        let keeps = isotropic && loading.isochoric(0.0).is_some();
        let volume = match keeps.then(|| huge_bulk_modulus(material)).flatten() {
            Some(bulk) => Volume::HardlyChanges { bulk },
            None => Volume::Changes,
        };
        Self::with(material, isotropic, loading, range, volume)
    }

    /// Follows a loading of the incompressible response of an isotropic law: `J = 1`, with the pressure for which the free face is traction-free.
    ///
    /// The volumetric part of the law has no effect. The loading must be one of [`Loading::INCOMPRESSIBLE`].
    ///
    /// ```
    /// use onset::criteria::{Criterion, Loading, LoadingPath, Range, follow};
    /// use onset::material::Law;
    /// // Biot (1963): in equibiaxial compression the surface of a neo-Hookean solid wrinkles at lambda^3 = 0.2956.
    /// let law = Law::named("neo-hooke").ok_or("no such law")?.build(&[])?;
    /// let path = LoadingPath::incompressible(&*law, Loading::INCOMPRESSIBLE[1], &Range::default())?;
    /// let limit = follow(&path, Criterion::Surface, false).and_then(|track| track.limit());
    /// assert!((limit.unwrap_or(0.0) - 0.666_142).abs() < 1e-6);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`LoadingError`] if the law has no state in the reference configuration, [`LoadingError::ChangesVolume`] for any other loading.
    pub fn incompressible(
        material: &'a dyn Hyperelastic,
        loading: Loading,
        range: &Range,
    ) -> Result<Self, LoadingError> {
        if !Loading::INCOMPRESSIBLE.contains(&loading) {
            return Err(LoadingError::ChangesVolume);
        }
        Self::with(material, true, loading, range, Volume::Kept)
    }

    fn with(
        material: &'a dyn Hyperelastic,
        isotropic: bool,
        loading: Loading,
        range: &Range,
        volume: Volume,
    ) -> Result<Self, LoadingError> {
        let problem = Problem {
            material,
            loading,
            volume,
            resolutions: Resolutions::of(material),
        };
        let start = solve(&problem, &Start::at(Vector3::zeros()));
        let reference = start.map_err(|missing| match missing {
            // The law is defined at F = 1 but not at the stretches that would make the faces traction-free.
            Missing::Law(_) if respond(material, &Matrix3::identity()).is_ok() => {
                LoadingError::NoReference
            }
            Missing::Law(error) => LoadingError::Law(error),
            Missing::Equilibrium => LoadingError::NoReference,
        })?;
        let side = |end: f64| branch(&problem, &reference, end.ln());
        let (tension, tension_end) = side(range.high);
        let (compression, compression_end) = side(range.low);
        Ok(Self {
            problem,
            isotropic,
            loading,
            tension,
            compression,
            tension_end,
            compression_end,
            separates_shape: isotropic
                && volume == Volume::Changes
                && problem.free().is_empty()
                && is_shape_separable(material),
            kinks: OnceLock::new(),
        })
    }

    /// Law whose loading is followed.
    pub fn material(&self) -> &'a dyn Hyperelastic {
        self.problem.material
    }

    /// Returns true if the law is isotropic.
    pub fn is_isotropic(&self) -> bool {
        self.isotropic
    }

    /// Returns true if the law is incompressible. A law with a huge bulk modulus keeps its volume along the path to rounding, while jumps may change it.
    pub(super) fn keeps_volume(&self) -> bool {
        self.problem.volume == Volume::Kept
    }

    /// Returns true if the response is incompressible.
    pub fn is_incompressible(&self) -> bool {
        self.problem.volume != Volume::Changes
    }

    /// Returns true if the path ends in a fold, in tension or in compression.
    pub fn ends_in_fold(&self, tension: bool) -> bool {
        let end = match tension {
            true => &self.tension_end,
            false => &self.compression_end,
        };
        matches!(end, PathEnd::Fold { .. })
    }

    /// Resolution of a place along the path, in `ln lambda`; `rounding` is the resolution for a law whose response is exact to rounding.
    pub(super) fn resolved(&self, rounding: f64) -> f64 {
        rounding.max(self.problem.resolutions.place)
    }

    /// Resolution of the place of a minimum, in units of the interval around it; `rounding` as in [`Self::resolved`].
    pub(super) fn flat_to(&self, rounding: f64) -> f64 {
        rounding.max(self.problem.resolutions.flat)
    }

    /// Returns true if the path ends at `s = ln lambda` in a fold.
    pub(super) fn is_fold(&self, s: f64) -> bool {
        let last = self.side(s >= 0.0).last();
        self.ends_in_fold(s >= 0.0) && last.is_some_and(|last| last.parameter == s)
    }

    /// States in tension or in compression.
    pub(super) fn side(&self, tension: bool) -> &[PathState] {
        match tension {
            true => &self.tension,
            false => &self.compression,
        }
    }

    /// State at `s = ln lambda` on the branch that was followed; `None` beyond its ends.
    pub fn at(&self, s: f64) -> Option<PathState> {
        let states = self.side(s >= 0.0);
        let last = states.last()?;
        // The end is reported as a stretch, whose logarithm equals the parameter only to rounding.
        let near = match self.ends_in_fold(s >= 0.0) {
            true => AT_FOLD,
            false => 2.0 * f64::EPSILON,
        };
        if (s - last.parameter).abs() <= near {
            return Some(last.clone());
        }
        let beyond = states.partition_point(|state| state.parameter.abs() < s.abs());
        let after = states.get(beyond)?;
        if after.parameter == s {
            return Some(after.clone());
        }
        let before = states.get(beyond.checked_sub(1)?)?;
        let guess = between(before, after, s);
        let chord = (after.place() - before.place()).norm();
        let reach = 1e-9 + 0.3 * chord;
        let is_nearer = (s - before.parameter).abs() < (after.parameter - s).abs();
        let beside = if is_nearer { before } else { after };
        let start = Start::at(guess).beside(beside, reach);
        let state = solve(&self.problem, &start);
        state
            .ok()
            .filter(|state| (state.place() - guess).norm() <= reach)
    }

    /// States displaced from the path by the rounding error of the free stretches, in several directions.
    ///
    /// This error is large where the branch of free stretches bifurcates, since the equations are nearly singular there.
    pub(super) fn undetermined(&self, state: &PathState) -> Vec<State> {
        let free = self.problem.free();
        if free.is_empty() || self.is_incompressible() {
            return Vec::new();
        }
        let (imposed, rate) = self.loading.imposed(state.parameter);
        let linear = Linear::of(&state.response, free, &rate);
        let noise = 4.0 * f64::EPSILON * linear.magnitude;
        let senses = [
            Vector2::new(1.0, 0.0),
            Vector2::new(0.0, 1.0),
            Vector2::new(1.0, 1.0),
            Vector2::new(1.0, -1.0),
        ];
        let mut off = Vec::new();
        for sense in senses {
            if free.len() == 1 && sense != senses[0] {
                continue;
            }
            // Error of the free stretches for a residual at the rounding level. If the matrix is nearly singular, the quadratic terms bound the
            // error.
            let most = f64::EPSILON.sqrt();
            let open = linear
                .solve(&Vector3::z(), &(sense * noise).push(0.0))
                .map_or(sense * most, |open| open.xy());
            let open = open * (most / open.amax()).min(1.0);
            for sign in [1.0, -1.0] {
                let lateral = state.lateral + open * sign;
                let f = with_free(imposed, free, &lateral);
                let Ok(response) = respond(self.material(), &f) else {
                    continue;
                };
                off.push(self.ask(&PathState {
                    response,
                    ..state.clone()
                }));
            }
        }
        off
    }

    /// Response of the law at a deformation; `None` if it is not defined.
    pub(super) fn respond(&self, f: &Matrix3<f64>) -> Option<Response> {
        respond(self.material(), f).ok()
    }

    /// State at `s` in the form in which criteria are evaluated; `None` if the path has no state there.
    pub fn state(&self, s: f64) -> Option<State> {
        self.at(s).map(|state| self.ask(&state))
    }

    /// Evaluates the state of this path at `s` in the form in which criteria are evaluated.
    pub fn ask(&self, state: &PathState) -> State {
        let asked =
            State::of_response(state.response.clone(), self.isotropic).with_rate(state.rate);
        let asked = match self.material().dimension() {
            2 => asked.in_plane(),
            _ => asked,
        };
        match self.problem.volume {
            Volume::Changes => {
                let shape = self.separates_shape.then_some(&state.response.deformation);
                match shape.and_then(|f| of_shape(self.material(), f)) {
                    Some(shape) => asked.with_shape(shape),
                    None => asked,
                }
            }
            _ => asked.incompressible(self.loading.free_faces()),
        }
    }

    /// Deformation gradients of other states with free faces at a parameter.
    ///
    /// They are found by a search from a grid of free stretches, so an empty result is not a proof of uniqueness.
    pub fn other_states(&self, s: f64) -> Vec<DeformationGradient> {
        if self.is_incompressible() {
            return Vec::new();
        }
        let count = self.problem.free().len();
        let Some(own) = self.at(s).filter(|_| count > 0) else {
            return Vec::new();
        };
        let mut found: Vec<PathState> = vec![own];
        let starts = [-1.6, -0.8, -0.4, 0.0, 0.4, 0.8, 1.6];
        let mirrors = self.is_isotropic() && self.loading.mode == Mode::Uniaxial && count == 2;
        // Each state of a law that integrates the path to it is costly, and its mirror image is known.
        let mirrors = mirrors && self.problem.resolutions.integrated;
        for first in starts {
            let seconds: &[f64] = if count == 2 { &starts } else { &[0.0] };
            for second in seconds {
                if mirrors && *second > first {
                    continue;
                }
                let start = Start::at(Vector2::new(first, *second).push(s));
                let Ok(state) = solve(&self.problem, &start) else {
                    continue;
                };
                let is_new = |found: &[PathState], lateral: Vector2<f64>| {
                    let differs = |other: &PathState| (other.lateral - lateral).amax() > 1e-6;
                    found.iter().all(differs)
                };
                if !is_new(&found, state.lateral) {
                    continue;
                }
                let image = Vector2::new(state.lateral.y, state.lateral.x);
                found.push(state);
                if mirrors && is_new(&found, image) {
                    let start = Start::at(image.push(s));
                    let image = solve(&self.problem, &start);
                    found.extend(image);
                }
            }
        }
        found
            .drain(1..)
            .map(|state| state.response.deformation)
            .collect()
    }
}

/// Part of a loading between two imposed stretches or amounts of shear, as a deformation path.
///
/// The imposed stretch is linear in the path parameter, and states with free faces are on the branch that begins at the reference configuration.
///
/// ```
/// use onset::kinematics::DeformationPath;
/// use onset::material::Law;
/// use onset::criteria::{Lateral, Loading, LoadingPath, LoadingSection, Mode, Range};
/// let law = Law::named("neo-hooke").ok_or("no such law")?.build(&[])?;
/// let loading = Loading { mode: Mode::Uniaxial, lateral: Lateral::Free };
/// let path = LoadingPath::new(&*law, true, loading, &Range::new(0.5, 2.0)?)?;
/// let halfway = LoadingSection::new(&path, 1.0, 2.0)?.at(0.5)?;
/// let f = halfway.components();
/// assert!(f[0][0] == 1.5 && f[1][1] < 1.0 && (f[1][1] - f[2][2]).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct LoadingSection<'p, 'a> {
    path: &'p LoadingPath<'a>,
    from: f64,
    to: f64,
}

impl<'p, 'a> LoadingSection<'p, 'a> {
    /// Creates the section between two imposed stretches or amounts of shear.
    ///
    /// # Errors
    /// [`KinematicsError::EmptyPath`] if both are equal, [`KinematicsError::NoState`] if the loading does not reach one of them.
    pub fn new(path: &'p LoadingPath<'a>, from: f64, to: f64) -> Result<Self, KinematicsError> {
        if from == to {
            return Err(KinematicsError::EmptyPath);
        }
        let section = Self { path, from, to };
        [0.0, 1.0]
            .into_iter()
            .try_for_each(|s| section.at(s).map(drop))?;
        Ok(section)
    }

    /// Imposed stretch or amount of shear at a path parameter.
    pub fn imposed(&self, s: f64) -> f64 {
        match s {
            1.0 => self.to,
            _ => self.from + (self.to - self.from) * s,
        }
    }
}

impl DeformationPath for LoadingSection<'_, '_> {
    fn at(&self, s: f64) -> Result<DeformationGradient, KinematicsError> {
        let imposed = self.imposed(s);
        let dimension = self.path.material().dimension();
        let state = self.path.at(self.path.loading.mode.parameter(imposed));
        state
            .map(|state| state.response.deformation.given_in(dimension))
            .ok_or(KinematicsError::NoState { stretch: imposed })
    }
}

/// Follows the branch from the reference configuration to `end`. Returns its states and the reason why it ends.
///
/// A step leads to the next parameter of the path. Where the branch curves away from its tangent, shorter steps are taken along the tangent. They
/// reach a fold and detect that the branch turns back there.
fn branch(problem: &Problem<'_>, reference: &PathState, end: f64) -> (Vec<PathState>, PathEnd) {
    let step = end / PATH_STEPS as f64;
    let mut here = reference.clone();
    here.tangent *= step.signum();
    let mut states = vec![here.clone()];
    let (mut length, mut trials) = (f64::INFINITY, 0);
    for n in 1..=PATH_STEPS {
        let mut target = if n == PATH_STEPS {
            end
        } else {
            step * n as f64
        };
        while (target - here.parameter) * step > 0.0 {
            let stretch = here.parameter.exp();
            trials += 1;
            if trials > TRIALS {
                let trials = TRIALS;
                return (states, PathEnd::GivenUp { stretch, trials });
            }
            let whole = (target - here.parameter) / here.tangent.z;
            let reaches = whole <= length;
            let tried = if reaches { whole } else { length.min(LONGEST) };
            // A response that is integrated along a path is worth a better guess.
            let bend = match problem.resolutions.integrated {
                true => bend(&states, tried),
                false => Vector3::zeros(),
            };
            let mut guess = here.place() + (here.tangent + bend) * tried;
            let start = if reaches {
                guess.z = target;
                Start::at(guess)
            } else {
                Start::along(guess, here.tangent)
            };
            let start = start.beside(&here, STRAYED * tried);
            let found = solve(problem, &start);
            let found = found.map(|state| state.differenced(problem, &start.normal));
            let on_branch = |state: &PathState| {
                let turned_back = state.tangent.dot(&here.tangent) > 0.0
                    && state.tangent.z * step <= 0.0
                    && !reaches;
                let near = (state.place() - guess).norm() <= tried;
                let goes_on = (state.parameter - here.parameter) * step > 0.0 || turned_back;
                goes_on && (here.leads_to(state) || tried < KINKED && near)
            };
            let missing = match found.map(|state| state.toward(&here)) {
                Ok(state) if on_branch(&state) && state.tangent.z * step > 0.0 => {
                    states.push(state.clone());
                    here = state;
                    length = 2.0 * tried;
                    continue;
                }
                // Where nothing is solved for, the law has states arbitrarily close to the jump.
                Err(Missing::Law(source))
                    if source.is_of_a_jump() && !problem.solves_for_states() =>
                {
                    target -= BESIDE_JUMP * step;
                    length = f64::INFINITY;
                    continue;
                }
                Ok(state) if on_branch(&state) => {
                    let fold = fold(problem, &here, (tried, &state));
                    let stretch = fold.parameter.exp();
                    states.push(fold);
                    return (states, PathEnd::Fold { stretch });
                }
                Ok(_) => Missing::Equilibrium,
                Err(missing) => missing,
            };
            length = 0.5 * tried;
            let smallest = step.abs() * 0.5_f64.powi(HALVINGS);
            let smallest = smallest.max(problem.resolutions.place);
            if length * here.tangent.z.abs() <= smallest
                || here.place() + here.tangent * length == here.place()
            {
                let end = match missing {
                    // A sheet in plane stress detects the fold of its thickness itself.
                    Missing::Law(MaterialError::PlaneStressEnds { .. }) => {
                        PathEnd::Fold { stretch }
                    }
                    Missing::Law(source) if !source.is_of_a_jump() => {
                        // Next to a point where the response grows without bound, states are rounding errors.
                        let end = here.parameter;
                        states.retain(|state| {
                            state.parameter == 0.0 || (state.parameter - end).abs() > BEFORE_END
                        });
                        PathEnd::Law { stretch, source }
                    }
                    _ if folds_at_kink(problem, &states, step) => PathEnd::Fold { stretch },
                    _ => PathEnd::NoState { stretch },
                };
                return (states, end);
            }
        }
    }
    (states, PathEnd::Range)
}

/// Returns true if the tangent of the law jumps beyond the last state so that the branch turns back there, with a corner in place of a limit point.
///
/// The branch crosses a surface at which the derivatives of the tractions jump by `c (x) n`. It continues along the vector `t` with `t . n > 0`
/// in the null space of the derivatives beyond the surface, and turns back if the stretch decreases along `t`.
fn folds_at_kink(problem: &Problem<'_>, states: &[PathState], step: f64) -> bool {
    let Some((last, others)) = states.split_last() else {
        return false;
    };
    // The last states may lie beyond the surface to rounding.
    let is_apart = |state: &&PathState| (state.place() - last.place()).norm() > KINKED;
    let Some(before) = others.iter().rev().find(is_apart) else {
        return false;
    };
    if problem.resolutions.integrated || problem.volume != Volume::Changes {
        return false;
    }
    let along = before.tangent * KINKED;
    let sides = [-along, along].map(|change| linearized(problem, &(last.place() + change)));
    let [Some(near), Some(beyond)] = sides else {
        return false;
    };
    let jump = beyond.slopes - near.slopes;
    let rows = [jump.row(0), jump.row(1)].map(|row| row.transpose());
    let [row, other] = rows;
    let larger = if row.norm() >= other.norm() {
        row
    } else {
        other
    };
    let normal = larger * larger.dot(&along).signum();
    let is_kink = jump.norm() > SLOPE_JUMP * beyond.magnitude;
    let is_continuous =
        (beyond.traction - beyond.slopes * along).norm() <= TRACTION_JUMP * jump.norm() * KINKED;
    let turns_back = || {
        beyond
            .direction(&normal)
            .is_some_and(|onward| onward.z * step < 0.0)
    };
    is_kink && is_continuous && turns_back()
}

/// Change of the tangent of a branch over half a step of length `tried` beyond its last state, extrapolated from the last two states.
fn bend(states: &[PathState], tried: f64) -> Vector3<f64> {
    let [.., before, last] = states else {
        return Vector3::zeros();
    };
    let chord = (last.place() - before.place()).norm();
    (last.tangent - before.tangent) * (0.5 * tried / chord)
}

/// Fold between a state and another state along its tangent, where the branch already leads back.
fn fold(
    problem: &Problem<'_>,
    before: &PathState,
    (length, behind): (f64, &PathState),
) -> PathState {
    let at = |length: f64| {
        let guess = before.place() + before.tangent * length;
        let start = Start::along(guess, before.tangent).beside(before, STRAYED * length);
        let state = solve(problem, &start).ok()?;
        let state = state.differenced(problem, &start.normal);
        Some(state.toward(before))
    };
    let outward = before.tangent.z.signum();
    let ends = [(0.0, before), (length, behind)]
        .map(|(length, state)| (length, outward * state.tangent.z));
    let mut slope = |length: f64| Some(outward * at(length)?.tangent.z);
    let resolution = problem.resolutions.flat * length;
    let (low, high) = bracket_zero(&mut slope, ends[0], ends[1], resolution);
    at(0.5 * (low + high)).unwrap_or_else(|| before.clone())
}

/// Cubic interpolation, with the tangents of a branch, of the free stretches and `s` between two states, at a given `s`.
fn between(before: &PathState, after: &PathState, s: f64) -> Vector3<f64> {
    let (start, end) = (before.place(), after.place());
    let chord = (end - start).norm();
    let at = |t: f64| {
        let (a, b) = (t * t * (3.0 - 2.0 * t), t * (1.0 - t));
        start + (end - start) * a + (before.tangent * (1.0 - t) - after.tangent * t) * (b * chord)
    };
    let distance = |t: f64| (at(t).z - s) * (end.z - start.z).signum();
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        match distance(middle) < 0.0 {
            true => low = middle,
            false => high = middle,
        }
    }
    let mut found = at(high);
    found.z = s;
    found
}

impl PathState {
    /// Orients the tangent of the branch like the tangent of another state.
    fn toward(mut self, other: &Self) -> Self {
        self.tangent *= self.tangent.dot(&other.tangent).signum();
        self
    }

    /// Replaces the tangent of the branch of a law whose tangent is not the derivative of its stress, and the derivatives of the tractions, by finite
    /// differences.
    fn differenced(self, problem: &Problem<'_>, normal: &Vector3<f64>) -> Self {
        let free = problem.free();
        if !problem.resolutions.integrated || free.is_empty() {
            return self;
        }
        let (s, lateral) = (self.parameter, self.lateral);
        let linear = Linear::of(&self.response, free, &problem.loading.imposed(s).1);
        let mut linear = linear.differenced(problem, s, &lateral);
        let imposed = linear.imposed_difference(problem, s, &lateral);
        linear.slopes.set_column(2, &imposed);
        let tangent = linear.direction(normal).unwrap_or(self.tangent);
        Self {
            tangent: match linear.has_equal_faces(&lateral) {
                true => equalized(tangent),
                false => tangent,
            },
            slopes: Some(linear.slopes),
            ..self
        }
    }
}

/// Start of a search for a state with free faces.
struct Start<'a> {
    /// Logarithms of the free stretches, and `s`.
    guess: Vector3<f64>,
    /// Normal of the plane through the guess in which the state lies; with the axis of `s`, `s` stays fixed.
    normal: Vector3<f64>,
    /// State nearby on the same branch, and the largest distance of the solution from the guess.
    beside: Option<(&'a PathState, f64)>,
}

impl<'a> Start<'a> {
    fn at(guess: Vector3<f64>) -> Self {
        Self::along(guess, Vector3::z())
    }

    fn along(guess: Vector3<f64>, normal: Vector3<f64>) -> Self {
        Self {
            guess,
            normal,
            beside: None,
        }
    }

    fn beside(self, state: &'a PathState, reach: f64) -> Self {
        Self {
            beside: Some((state, reach)),
            ..self
        }
    }
}

/// Solves `tau_kk = P_kk F_kk = 0` for all free directions `k` by Newton's method, to rounding.
///
/// The unknowns are the logarithms of the free stretches and `s`. A law whose tangent is not the derivative of its stress is solved by Broyden's method
/// (*Math. Comput.* 19 (1965) 577), with the derivatives of the state near the start or from finite differences.
fn solve(problem: &Problem<'_>, start: &Start<'_>) -> Result<PathState, Missing> {
    let Problem {
        material,
        loading,
        volume,
        resolutions,
    } = *problem;
    let Start {
        guess,
        normal,
        beside,
    } = start;
    if volume != Volume::Changes {
        return isochoric(problem, guess.z, guess.xy());
    }
    let free = problem.free();
    let differs = resolutions.integrated;
    let mut place = *guess;
    if differs && free.len() == 2 && (place.x - place.y).abs() <= resolutions.free {
        place.x = place.y;
    }
    let mut last = f64::INFINITY;
    let mut known = beside.and_then(|(state, _)| state.slopes);
    let mut before: Option<(Vector3<f64>, Vector2<f64>)> = None;
    for _ in 0..resolutions.iterations {
        let (s, lateral) = (place.z, place.xy());
        let (imposed, imposed_rate) = loading.imposed(s);
        let f = with_free(imposed, free, &lateral);
        let response = respond(material, &f)?;
        let tangent = Linear::of(&response, free, &imposed_rate);
        let linear = match (differs, known) {
            (false, _) => tangent,
            (true, Some(slopes)) => Linear {
                slopes: before.map_or(slopes, |(at, traction)| {
                    updated(slopes, &(place - at), &(tangent.traction - traction))
                }),
                ..tangent
            },
            (true, None) => tangent.differenced(problem, s, &lateral),
        };
        known = differs.then_some(linear.slopes);
        before = Some((place, linear.traction));
        let Some(mut correction) = linear.solve(normal, &(-linear.traction).push(0.0)) else {
            return Err(Missing::Equilibrium);
        };
        if differs && linear.has_equal_faces(&lateral) {
            correction = equalized(correction);
        }
        let size = correction.amax();
        // In a converged iteration the corrections and the tractions are rounding, and the corrections no longer decrease.
        let settled = size < 1e-8 && size >= 0.5 * last && linear.is_balanced();
        if size <= resolutions.free || settled {
            let mut branch = linear.direction(normal).ok_or(Missing::Equilibrium)?;
            if differs && linear.has_equal_faces(&lateral) {
                branch = equalized(branch);
            }
            // Criteria refer to loading that continues from this state, and the tangent belongs to this loading.
            let on = match differs {
                true => tangent.direction(&branch).ok_or(Missing::Equilibrium)?,
                false => branch,
            };
            // Toward larger stretches, on both sides of the reference configuration.
            let on = if on.z < 0.0 { -on } else { on };
            let mut rate = imposed_rate * on.z;
            for (n, axis) in free.iter().enumerate() {
                rate[(*axis, *axis)] = on[n] * f[(*axis, *axis)];
            }
            return Ok(PathState {
                parameter: s,
                response,
                rate,
                lateral,
                tangent: branch,
                slopes: known,
            });
        }
        if size > LEADS_ON * last {
            known = None;
        }
        last = size;
        place += correction * (0.5 / size).min(1.0);
        if differs && beside.is_some_and(|(_, reach)| (place - guess).norm() > reach) {
            return Err(Missing::Equilibrium);
        }
    }
    Err(Missing::Equilibrium)
}

/// State of incompressible response. The stretch alone determines it, except for the thickness of a free sheet in simple shear.
fn isochoric(problem: &Problem<'_>, s: f64, guess: Vector2<f64>) -> Result<PathState, Missing> {
    let Problem {
        material,
        loading,
        volume,
        ..
    } = *problem;
    let (f, rate) = loading.isochoric(s).ok_or(Missing::Equilibrium)?;
    let respond = |f: &Matrix3<f64>| {
        let response = material.isochoric_response(&checked(f)?);
        response.map_err(Missing::Law)
    };
    let face = loading.free_faces().first().copied();
    let settled = |response: Response| {
        let Some(face) = face else { return response };
        let stress = response.first_piola;
        let pressurized = pressurized(response, face);
        match volume {
            Volume::HardlyChanges { bulk } => swollen(material, pressurized, &stress, bulk),
            _ => pressurized,
        }
    };
    let mut state = PathState {
        parameter: s,
        response: respond(&f)?,
        rate,
        lateral: Vector2::zeros(),
        tangent: Vector3::z(),
        slopes: None,
    };
    if (loading.mode, loading.lateral) == (Mode::SimpleShear, Lateral::Free) {
        // Solves tau_22 = tau_33 along the rate diag(0, 1, -1).
        let opposite = Matrix3::from_diagonal(&Vector3::new(0.0, 1.0, -1.0));
        let mut own = guess[0];
        let mut last = f64::INFINITY;
        for _ in 0..ITERATIONS {
            let f = with_free(f, &[1, 2], &Vector2::new(own, -own));
            let response = respond(&f)?;
            let along = opposite * f;
            let derivative = |rate: &Matrix3<f64>| {
                let bent = response.first_piola.dot(&(opposite * rate));
                bent + components()
                    .map(|at @ (i, j, k, l)| along[(i, j)] * response.tangent[at] * rate[(k, l)])
                    .sum::<f64>()
            };
            let correction = -response.first_piola.dot(&along) / derivative(&along);
            let slope = -derivative(&rate) / derivative(&along);
            if !correction.is_finite() {
                break;
            }
            let size = correction.abs();
            if size <= 4.0 * f64::EPSILON || (size < 1e-8 && size >= 0.5 * last) {
                state.response = settled(response);
                state.lateral = Vector2::new(own, -own);
                state.tangent = Vector3::new(slope, -slope, 1.0).normalize();
                state.rate = (rate + along * slope) * state.tangent.z;
                return Ok(state);
            }
            last = size;
            own += correction * (0.5 / size).min(1.0);
        }
        return Err(Missing::Equilibrium);
    }
    state.response = settled(state.response);
    Ok(state)
}

fn components() -> impl Iterator<Item = (usize, usize, usize, usize)> {
    (0..81).map(|n| (n / 27, n / 9 % 3, n / 3 % 3, n % 3))
}

fn respond(material: &dyn Hyperelastic, f: &Matrix3<f64>) -> Result<Response, Missing> {
    material.response(&checked(f)?).map_err(Missing::Law)
}

fn checked(f: &Matrix3<f64>) -> Result<DeformationGradient, Missing> {
    let components = array_of(|i| array_of(|j| f[(i, j)]));
    DeformationGradient::new(components).map_err(|error| {
        Missing::Law(MaterialError::NotFinite {
            jacobian: match error {
                KinematicsError::JacobianNotPositive { jacobian } => jacobian,
                _ => f.determinant(),
            },
        })
    })
}

/// Tractions `tau_kk` on the free faces.
fn traction(problem: &Problem<'_>, s: f64, lateral: &Vector2<f64>) -> Option<Vector2<f64>> {
    linearized(problem, &lateral.push(s)).map(|linear| linear.traction)
}

/// Linearized tractions at a place; `None` if the law is not defined there.
fn linearized(problem: &Problem<'_>, place: &Vector3<f64>) -> Option<Linear> {
    let (imposed, rate) = problem.loading.imposed(place.z);
    let free = problem.free();
    let f = with_free(imposed, free, &place.xy());
    let response = respond(problem.material, &f).ok()?;
    Some(Linear::of(&response, free, &rate))
}

/// Scales the free axes of `F` by stretches given by their logarithms.
fn with_free(mut f: Matrix3<f64>, free: &[usize], lateral: &Vector2<f64>) -> Matrix3<f64> {
    for (n, axis) in free.iter().enumerate() {
        f[(*axis, *axis)] = lateral[n].exp();
    }
    f
}

/// Derivatives `dtau_kk / dln F_mm` of the tractions on free faces, and `dtau_kk / ds` by the imposed part in the last column.
type Slopes = Matrix2x3<f64>;

/// Derivatives that fit a step and the change of the tractions on it, and are otherwise unchanged.
fn updated(slopes: Slopes, step: &Vector3<f64>, change: &Vector2<f64>) -> Slopes {
    let length = step.norm_squared();
    match length > 0.0 {
        true => slopes + (change - slopes * step) * step.transpose() / length,
        false => slopes,
    }
}

/// Change of a place at which two free faces remain equal, without its rounding.
fn equalized(change: Vector3<f64>) -> Vector3<f64> {
    let mean = 0.5 * (change.x + change.y);
    Vector3::new(mean, mean, change.z)
}

/// Linearization of the tractions on free faces in the logarithms of the free stretches.
#[derive(Clone, Copy)]
struct Linear {
    count: usize,
    /// Tractions `tau_kk` on the free faces.
    traction: Vector2<f64>,
    slopes: Slopes,
    /// Magnitude of the terms that cancel in the tractions.
    magnitude: f64,
}

/// Largest ratio of successive corrections for which derivatives from an earlier iteration are reused.
const LEADS_ON: f64 = 0.3;
/// Finite-difference step in logarithmic stretch. Rounding of the stress and curvature of a flow stress are both less than 1e-3 of the difference,
/// which Newton's method and the guess of the next state tolerate.
const DIFFERENCE: f64 = 1e-6;
/// Largest traction that is a rounding error, as a fraction of the terms that cancel in it.
const BALANCED: f64 = 1e-12;

impl Linear {
    fn of(response: &Response, free: &[usize], imposed_rate: &Matrix3<f64>) -> Self {
        let f = response.deformation.components();
        let mut linear = Self {
            count: free.len(),
            traction: Vector2::zeros(),
            slopes: Slopes::zeros(),
            magnitude: 0.0,
        };
        let mut largest: f64 = 0.0;
        for (a, &k) in free.iter().enumerate() {
            linear.traction[a] = response.first_piola[(k, k)] * f[k][k];
            for (b, &m) in free.iter().enumerate() {
                let stiffness = f[k][k] * response.tangent[(k, k, m, m)] * f[m][m];
                let geometric = if k == m { linear.traction[a] } else { 0.0 };
                linear.slopes[(a, b)] = stiffness + geometric;
            }
            for (i, j) in (0..9).map(|n| (n / 3, n % 3)) {
                largest = largest.max((f[k][k] * response.tangent[(k, k, i, j)] * f[i][j]).abs());
                linear.slopes[(a, 2)] +=
                    f[k][k] * response.tangent[(k, k, i, j)] * imposed_rate[(i, j)];
            }
        }
        linear.magnitude = largest + response.first_piola.amax() * f[0][0].max(f[1][1]);
        linear
    }

    /// Replaces the derivatives with respect to the free stretches by finite differences, for a law whose tangent is not the derivative of its stress.
    ///
    /// The tangent is kept where a neighboring state does not exist, as at the end of the domain of the law.
    fn differenced(mut self, problem: &Problem<'_>, s: f64, lateral: &Vector2<f64>) -> Self {
        let senses = match self.has_equal_faces(lateral) {
            // The faces remain equal, and the derivative along their difference does not count.
            true => [Some(Vector2::new(1.0, 1.0)), None],
            false => [Vector2::x(), Vector2::y()].map(Some),
        };
        for sense in senses.into_iter().flatten().take(self.count) {
            if let Some(there) = traction(problem, s, &(lateral + sense * DIFFERENCE)) {
                let change = (there - self.traction) / DIFFERENCE;
                self.slopes = updated(self.slopes, &sense.push(0.0), &change);
            }
        }
        self
    }

    /// Finite-difference derivative with respect to `s`, one-sided toward the reference configuration, where the law has a state.
    fn imposed_difference(
        &self,
        problem: &Problem<'_>,
        s: f64,
        lateral: &Vector2<f64>,
    ) -> Vector2<f64> {
        let step = if s > 0.0 { -DIFFERENCE } else { DIFFERENCE };
        let there = match self.count {
            0 => None,
            _ => traction(problem, s + step, lateral),
        };
        there.map_or(self.slopes.column(2).into_owned(), |there| {
            (there - self.traction) / step
        })
    }

    /// Returns true if two free faces have equal stretches and tractions. They remain equal on the branch, and the states of an isotropic law that flows are
    /// several times cheaper where stretches are equal: the direction of its flow is then constant, and elsewhere it limits the steps of the integration.
    fn has_equal_faces(&self, lateral: &Vector2<f64>) -> bool {
        let traction = (self.traction.x - self.traction.y).abs();
        self.count == 2 && lateral.x == lateral.y && traction <= BALANCED * self.magnitude
    }

    /// Returns true if the tractions vanish to rounding.
    fn is_balanced(&self) -> bool {
        self.traction.amax() <= BALANCED * self.magnitude
    }

    /// Solves for the logarithms of the free stretches and `s`, given the changes of the tractions and the component along a normal. `None` if the
    /// system is singular.
    fn solve(&self, normal: &Vector3<f64>, right: &Vector3<f64>) -> Option<Vector3<f64>> {
        let mut rows = Matrix3::identity();
        for a in 0..self.count {
            rows.set_row(a, &self.slopes.row(a));
        }
        rows.set_row(2, &normal.transpose());
        let solution = rows.lu().solve(right)?;
        solution.iter().all(|x| x.is_finite()).then_some(solution)
    }

    /// Unit vector along which the tractions do not change, on the side of a normal.
    fn direction(&self, normal: &Vector3<f64>) -> Option<Vector3<f64>> {
        self.solve(normal, &Vector3::z())?.try_normalize(0.0)
    }
}
