//! Problem: material and method built from settings, and deformations built from numbers.

use super::finite_body::hint_on_body;
use crate::methods::{hint, method};
use crate::number::counted;
use crate::settings::{Plane, SettingError, Settings};
use onset::analysis::{Analysis, analysis, described_analysis};
use onset::kinematics::{DeformationGradient, KinematicsError};
use onset::material::{Hyperelastic, Linearized};
use onset::method::MethodError;
use onset::motion::{BodyError, Fault};
use onset::plasticity::Unloading;
use onset::verdict::PathError;
use std::sync::Arc;
use thiserror::Error;

/// Reason why a problem cannot be set up or evaluated; all reasons are errors in the input.
#[derive(Debug, Error)]
pub enum ProblemError {
    /// A setting is invalid.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// A deformation has a wrong number of components.
    #[error("{what} has {}; expected {expected}{}", counted(*given, "number"), hint_lines(hint))]
    Numbers {
        /// Argument with the numbers.
        what: &'static str,
        /// Number of components that were given.
        given: usize,
        /// Description of the expected number of components.
        expected: String,
        /// Suggestion, or an empty string.
        hint: String,
    },
    /// A text is not a number.
    #[error(
        "{what}: `{text}` is not a number; expected numbers separated by commas, for example 1.2,0.9"
    )]
    NotANumber {
        /// Argument with the text.
        what: &'static str,
        /// Text that was typed.
        text: String,
    },
    /// The patch is too large to be drawn and exported.
    #[error(
        "the patch has {particles:.1e} particles; at most {admitted:.0e} are admitted\n  hint: choose fewer --cells"
    )]
    Patch {
        /// Number of particles of the patch.
        particles: f64,
        /// Maximum number of particles.
        admitted: f64,
    },
    /// No value in the range of a coefficient can be evaluated.
    #[error(
        "no value of {key} from {low} to {high} can be evaluated; at {low}: {}\n  hint: set the range of values with --range LOW,HIGH",
        first_line(source)
    )]
    Range {
        /// Key of the coefficient.
        key: &'static str,
        /// Smallest value of the range.
        low: f64,
        /// Largest value of the range.
        high: f64,
        /// Error at the smallest value.
        source: Box<ProblemError>,
    },
    /// The wave vector is so large that double precision cannot represent its phase.
    #[error(
        "the wave vector is too large: |k| times the spacing is {value:.1e}; at most 1e6 is admitted"
    )]
    WaveVector {
        /// `|k|` times the spacing.
        value: f64,
    },
    /// The zone has no point with this name.
    #[error(
        "--path: no point of the zone is called `{label}`\n  hint: this state has {}; others are given in units of the reciprocal \
         vectors, for example --path=\"0,0; 0.5,0\"; a study file goes before --path", known.join(", ")
    )]
    ZonePoint {
        /// Name that was typed.
        label: String,
        /// Names of the points of this state.
        known: Vec<String>,
    },
    /// A number is not finite.
    #[error("{what} contains {value}; all its numbers must be finite")]
    NotFinite {
        /// Argument with the number.
        what: &'static str,
        /// Value of the number.
        value: f64,
    },
    /// The numbers do not form a deformation gradient.
    #[error("{source}{}", hint_on_state(source))]
    Kinematics {
        /// Cause of the failure.
        #[from]
        source: KinematicsError,
    },
    /// The method or the material cannot be evaluated at the state.
    #[error("{source}{}", hint(source))]
    Method {
        /// Cause of the failure.
        source: MethodError,
    },
    /// The body of the study cannot be built.
    #[error("{source}\n  hint: {}", hint_on_body(source))]
    Body {
        /// Cause of the failure.
        #[from]
        source: BodyError,
    },
    /// The body has no forces at this state.
    #[error("{0}\n  hint: choose a state at which the law is defined")]
    Fault(#[from] Box<Fault>),
    /// A loading cannot be followed from one imposed stretch to another.
    #[error(
        "{title}, from {imposes} {from} to {to}: {reason}{}",
        note_lines(notes)
    )]
    Loading {
        /// Short name of the loading.
        title: &'static str,
        /// Name of the imposed quantity: a stretch, or the amount of shear.
        imposes: &'static str,
        /// First value of the imposed quantity.
        from: f64,
        /// Last value of the imposed quantity.
        to: f64,
        /// Cause of the failure.
        reason: String,
        /// Notes on the law that may explain the failure.
        notes: Vec<String>,
    },
    /// A path cannot be followed.
    #[error("{source}{}", path_hint(source))]
    Path {
        /// Cause of the failure.
        #[from]
        source: PathError,
    },
}

impl From<MethodError> for ProblemError {
    fn from(source: MethodError) -> Self {
        Self::Method { source }
    }
}

impl ProblemError {
    /// Attributes an error of a method to the setting that causes it, if any.
    pub(crate) fn of(settings: &Settings, error: MethodError) -> Self {
        match settings.blamed(&error) {
            Some(setting) => setting.into(),
            None => error.into(),
        }
    }
}

/// Appends a hint to a message.
fn hint_lines(hint: &str) -> String {
    match hint {
        "" => String::new(),
        hint => format!("\n  hint: {hint}"),
    }
}

/// Suggestion for a wrong number of components: decimal commas, or a single stretch along one axis.
fn meant(what: &str, text: &str, admitted: impl Fn(usize) -> bool, is_stretch: bool) -> String {
    let items: Vec<&str> = text.split(',').map(str::trim).collect();
    let is_whole = |item: &&str| {
        let digits = item.trim_start_matches('-');
        !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit())
    };
    if items.len().is_multiple_of(2) && admitted(items.len() / 2) && items.iter().all(is_whole) {
        let pairs: Vec<String> = items.chunks(2).map(|pair| pair.join(".")).collect();
        return format!(
            "use points as decimal separators, and commas between numbers: {what} {}",
            pairs.join(",")
        );
    }
    match (is_stretch, &items[..]) {
        (true, [only]) => {
            let ones = |count: usize| ",1".repeat(count - 1);
            let all = (2..=3).find(|count| admitted(*count)).unwrap_or(2);
            format!(
                "{what} {only}{} stretches along axis 1 and keeps the other lengths; with free faces it is `onset path --mode uniaxial --to {only}`",
                ones(all)
            )
        }
        _ => String::new(),
    }
}

/// Appends notes to a message, one per line.
fn note_lines(notes: &[String]) -> String {
    notes
        .iter()
        .map(|note| format!("\n  note: {note}"))
        .collect()
}

/// The hint of the message concerns a single value and is dropped.
fn first_line(error: &ProblemError) -> String {
    let told = error.to_string();
    told.lines().next().unwrap_or_default().to_owned()
}

impl ProblemError {
    /// Imposed stretch or amount of shear at which a loading has no state with free faces, if this is the error.
    pub(super) fn missing_state(&self) -> Option<f64> {
        match self {
            Self::Kinematics {
                source: KinematicsError::NoState { stretch },
            }
            | Self::Path {
                source:
                    PathError::Kinematics {
                        source: KinematicsError::NoState { stretch },
                        ..
                    },
            } => Some(*stretch),
            _ => None,
        }
    }
}

/// Hint on a state that no law has.
fn hint_on_state(error: &KinematicsError) -> &'static str {
    match error {
        KinematicsError::JacobianNotPositive { jacobian } if *jacobian < 0.0 => {
            "\n  hint: the laws are defined for det F > 0 only, so that an inverted element has no Hessian; `onset criteria --all` lists where the Hessian \
             becomes indefinite before that (hill)"
        }
        _ => "",
    }
}

fn path_hint(error: &PathError) -> &'static str {
    match error {
        PathError::Method { source, .. } => hint(source),
        PathError::Kinematics { .. } => "",
    }
}

/// Number of dimensions of states, and the condition in the remaining directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extent {
    /// Number of dimensions of the lattice.
    pub dimension: usize,
    /// Condition on the directions beyond the dimensions of the lattice.
    pub plane: Plane,
}

/// Extent in which components beyond the dimensions can be given.
impl From<usize> for Extent {
    fn from(dimension: usize) -> Self {
        Self {
            dimension,
            plane: Plane::Strain,
        }
    }
}

impl Extent {
    /// Returns true if components beyond the dimensions cannot be given, because they follow from equilibrium or do not exist.
    pub(super) fn leaves_none_beyond(self) -> bool {
        self.plane != Plane::Strain
    }

    /// Refuses numbers for components that follow from equilibrium.
    fn check(self, what: &'static str, given: usize, own: usize) -> Result<(), ProblemError> {
        match self.leaves_none_beyond() && given != own {
            true => Err(self.refused(what, given, own)),
            false => Ok(()),
        }
    }

    fn refused(self, what: &'static str, given: usize, own: usize) -> ProblemError {
        let found = match (self.dimension, self.plane) {
            (_, Plane::Membrane) => {
                "a two-dimensional law (material.plane = membrane) has no third direction"
            }
            (1, _) => "in uniaxial stress the lateral stretches are computed",
            _ => "in plane stress the stretch across the sheet is computed",
        };
        ProblemError::Numbers {
            what,
            given,
            expected: format!("{own}: {found}"),
            hint: "omit the other components, or set material.plane=strain to prescribe them"
                .to_owned(),
        }
    }
}

/// A deformation as given by the user, and whether it includes stretches or components beyond the dimensions of the lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strain(pub DeformationGradient, bool);

impl From<DeformationGradient> for Strain {
    fn from(f: DeformationGradient) -> Self {
        Self(f, false)
    }
}

impl Strain {
    /// The reference configuration, `F = 1`.
    pub fn reference() -> Self {
        DeformationGradient::identity().into()
    }

    /// Returns true if stretches or components beyond the dimensions of the lattice were given.
    pub(super) fn is_of_space(&self) -> bool {
        self.1
    }

    /// Reads stretches along the axes, one for each dimension of the lattice and optionally for the others (1 unless given).
    ///
    /// # Errors
    /// [`ProblemError`] when the numbers are too few, too many or invalid stretches, or set components that follow from equilibrium.
    pub fn of_stretches(
        what: &'static str,
        text: &str,
        extent: impl Into<Extent>,
    ) -> Result<Self, ProblemError> {
        let extent = extent.into();
        let dimension = extent.dimension;
        let numbers = numbers(what, text)?;
        let admitted = |count: usize| (dimension..=3).contains(&count);
        if !admitted(numbers.len()) {
            return Err(ProblemError::Numbers {
                what,
                given: numbers.len(),
                hint: meant(what, text, admitted, true),
                expected: match dimension {
                    3 => "3 (one for each dimension of the lattice)".to_owned(),
                    _ => format!("{dimension} (one for each dimension of the lattice) to 3"),
                },
            });
        }
        extent.check(what, numbers.len(), dimension)?;
        let mut stretches = [1.0; 3];
        stretches[..numbers.len()].copy_from_slice(&numbers);
        let is_of_space = numbers.len() > dimension;
        Ok(Self(
            DeformationGradient::from_stretches(stretches)?,
            is_of_space,
        ))
    }

    /// Reads the components of `F`: one in one dimension, `F11,F12,F21,F22` in two dimensions, nine in three; all nine may be given in any dimension.
    ///
    /// # Errors
    /// [`ProblemError`] for a different number of components, or when `det F` is not positive.
    pub fn of_components(
        what: &'static str,
        text: &str,
        extent: impl Into<Extent>,
    ) -> Result<Self, ProblemError> {
        let extent = extent.into();
        let dimension = extent.dimension;
        let numbers = numbers(what, text)?;
        let side = match numbers.len() {
            9 => 3,
            count if count == dimension * dimension => dimension,
            given => {
                let expected = match dimension {
                    2 => "4 (F11,F12,F21,F22) or 9".to_owned(),
                    3 => "9 (F11,F12,F13,F21,...)".to_owned(),
                    other => format!("{} or 9", other * other),
                };
                let admitted = |count: usize| count == 9 || count == dimension * dimension;
                return Err(ProblemError::Numbers {
                    what,
                    given,
                    expected,
                    hint: meant(what, text, admitted, false),
                });
            }
        };
        extent.check(what, numbers.len(), dimension * dimension)?;
        let mut components = *DeformationGradient::identity().components();
        for (index, value) in numbers.into_iter().enumerate() {
            components[index / side][index % side] = value;
        }
        Ok(Self(
            DeformationGradient::new(components)?,
            side > dimension,
        ))
    }

    /// Reads stretches, or the four components of `F`, as the end of a path.
    ///
    /// # Errors
    /// Fails like [`Strain::of_stretches`] and [`Strain::of_components`].
    pub fn of_either(
        what: &'static str,
        text: &str,
        extent: impl Into<Extent>,
    ) -> Result<Self, ProblemError> {
        if text.split(',').count() > 3 {
            Self::of_components(what, text, extent)
        } else {
            Self::of_stretches(what, text, extent)
        }
    }
}

impl Settings {
    /// Returns the number of dimensions and the plane condition (strain, stress, membrane), which determine how many numbers a state has.
    pub fn extent(&self) -> Extent {
        Extent {
            dimension: self.dimension(),
            plane: self.material.plane(),
        }
    }
}

/// Reads finite numbers separated by commas; `what` is the name of the argument in messages.
///
/// # Errors
/// [`ProblemError`] when an item is not a finite number.
pub fn numbers(what: &'static str, text: &str) -> Result<Vec<f64>, ProblemError> {
    let number = |item: &str| {
        let value: f64 = item.trim().parse().map_err(|_| ProblemError::NotANumber {
            what,
            text: item.trim().to_owned(),
        })?;
        if value.is_finite() {
            Ok(value)
        } else {
            Err(ProblemError::NotFinite { what, value })
        }
    };
    text.split(',').map(number).collect()
}

/// Material with a discretization.
pub struct Problem {
    /// Settings of material and discretization.
    pub settings: Settings,
    /// Material law, which may be shared.
    pub material: Arc<dyn Hyperelastic>,
    /// Analysis of the discretization with this material.
    pub analysis: Box<dyn Analysis>,
}

impl Problem {
    /// Builds the material and the method.
    ///
    /// # Errors
    /// [`ProblemError`] when material or method are invalid.
    pub fn new(settings: Settings) -> Result<Self, ProblemError> {
        match settings.law() {
            Ok(material) => Self::with_law(settings, material),
            Err(error) => Err(ProblemError::of(&settings, error.into())),
        }
    }

    /// Builds the method for a material that may be shared.
    ///
    /// # Errors
    /// [`ProblemError`] when the method is invalid.
    pub(crate) fn with_law(
        settings: Settings,
        material: Arc<dyn Hyperelastic>,
    ) -> Result<Self, ProblemError> {
        let built = analysis(&method(&settings), Arc::clone(&material));
        let analysis = built.map_err(|error| ProblemError::of(&settings, error))?;
        Ok(Self {
            analysis,
            settings,
            material,
        })
    }

    /// Returns the problem for stiffer increments of the states: unloading of a law that flows, or increments that are faster than the relaxation of a
    /// viscoelastic law. Their waves limit the time step.
    ///
    /// # Errors
    /// [`ProblemError`] when the method is invalid.
    pub(crate) fn stiffer(&self) -> Result<Self, ProblemError> {
        let fast = self.settings.fast_law().map_err(MethodError::from)?;
        let law = fast.unwrap_or_else(|| Arc::new(Unloading(Arc::clone(&self.material))));
        Self::with_law(self.settings.clone(), law)
    }

    /// Like [`Problem::stiffer`], for one state, about which the law is linear, so that bodies can be run with it; `None` if no increments of the state
    /// are stiffer than its tangent.
    ///
    /// # Errors
    /// [`ProblemError`] when the method is invalid, or the material cannot be evaluated there.
    pub(crate) fn stiffer_at(&self, f: &DeformationGradient) -> Result<Option<Self>, ProblemError> {
        let flows = self
            .material
            .unloading_tangent(f)
            .map_err(MethodError::from)?;
        if !self.settings.material.is_relaxed() && flows.is_none() {
            return Ok(None);
        }
        let law = Linearized::about(&*self.stiffer()?.material, f).map_err(MethodError::from)?;
        Self::with_law(self.settings.clone(), Arc::new(law)).map(Some)
    }

    /// Returns the problem with the cell of the settings instead of the primitive cell, for patches.
    ///
    /// # Errors
    /// [`ProblemError`] when the method is invalid.
    pub fn described(&self) -> Result<Self, ProblemError> {
        let method = method(&self.settings);
        Ok(Self {
            analysis: described_analysis(&method, Arc::clone(&self.material))?,
            settings: self.settings.clone(),
            material: Arc::clone(&self.material),
        })
    }

    /// Returns the number of space dimensions.
    pub fn dimension(&self) -> usize {
        self.analysis.dimension()
    }

    /// Computes the components across a sheet in plane stress or a bar in uniaxial stress. Other states, and states without a solution, are returned
    /// unchanged.
    pub fn found(&self, f: &DeformationGradient) -> DeformationGradient {
        match self.material.dimension() {
            3 => *f,
            _ => self
                .material
                .response(f)
                .map_or(*f, |found| found.deformation),
        }
    }

    /// Checks a state given by all components, even if some of them follow from equilibrium.
    ///
    /// # Errors
    /// [`ProblemError::Numbers`] when components across a sheet or bar differ from the reference configuration.
    pub fn given(&self, f: DeformationGradient) -> Result<DeformationGradient, ProblemError> {
        let extent = self.extent();
        let dimension = extent.dimension;
        match extent.leaves_none_beyond() && f != f.given_in(dimension) {
            true => Err(extent.refused("F", 9, dimension * dimension)),
            false => Ok(f),
        }
    }

    /// Returns the number of dimensions and the plane condition (strain, stress, membrane), which determine how many numbers a state has.
    pub fn extent(&self) -> Extent {
        self.settings.extent()
    }
}
