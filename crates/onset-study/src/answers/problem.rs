//! A problem: settings made into a material and a method, and deformations made from numbers.

use super::finite_body::hint_on_body;
use crate::methods::{hint, method};
use crate::number::counted;
use crate::settings::{Plane, SettingError, Settings};
use onset::analysis::{Analysis, analysis, described_analysis};
use onset::kinematics::{DeformationGradient, KinematicsError};
use onset::material::Hyperelastic;
use onset::method::MethodError;
use onset::motion::{BodyError, Fault};
use onset::verdict::PathError;
use std::sync::Arc;
use thiserror::Error;

/// Why a question cannot be answered. Always the input's fault, and said so.
#[derive(Debug, Error)]
pub enum ProblemError {
    /// A setting.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// The numbers of a deformation.
    #[error("{what} has {}; expected {expected}{}", counted(*given, "number"), hint_lines(hint))]
    Numbers {
        /// Which argument.
        what: &'static str,
        /// How many there are.
        given: usize,
        /// How many are expected, in words.
        expected: String,
        /// What may have been meant; empty where there is nothing to say.
        hint: String,
    },
    /// A number that is none.
    #[error(
        "{what}: `{text}` is not a number; expected numbers separated by commas, for example 1.2,0.9"
    )]
    NotANumber {
        /// Which argument.
        what: &'static str,
        /// What was typed.
        text: String,
    },
    /// A patch that is too large to be drawn and exported.
    #[error(
        "the patch has {particles:.1e} particles; at most {admitted:.0e} are admitted\n  hint: choose fewer --cells"
    )]
    Patch {
        /// Particles of the patch.
        particles: f64,
        /// How many are admitted.
        admitted: f64,
    },
    /// A range of a coefficient in which nothing can be evaluated.
    #[error(
        "no value of {key} from {low} to {high} can be evaluated; at {low}: {}\n  hint: name the values to look at with --range LOW,HIGH",
        first_line(source)
    )]
    Range {
        /// The coefficient.
        key: &'static str,
        /// The smallest value.
        low: f64,
        /// The largest value.
        high: f64,
        /// What is wrong at the smallest value.
        source: Box<ProblemError>,
    },
    /// A wave vector of which double precision cannot tell the phase.
    #[error(
        "the wave vector is too large: |k| times the spacing is {value:.1e}; at most 1e6 is admitted"
    )]
    WaveVector {
        /// `|k|` times the spacing.
        value: f64,
    },
    /// A point of the zone that has no such name.
    #[error(
        "--path: no point of the zone is called `{label}`\n  hint: this state has {}; others are given in units of the reciprocal \
         vectors, for example --path=\"0,0; 0.5,0\"; a study file goes before --path", known.join(", ")
    )]
    ZonePoint {
        /// What was typed.
        label: String,
        /// The names of this state.
        known: Vec<String>,
    },
    /// A question that was given a time.
    #[error("there was not enough time")]
    OutOfTime,
    /// A number that is not finite.
    #[error("{what} holds {value}; all its numbers must be finite")]
    NotFinite {
        /// Which argument.
        what: &'static str,
        /// The number.
        value: f64,
    },
    /// The deformation.
    #[error(transparent)]
    Kinematics(#[from] KinematicsError),
    /// The method or the material at the state.
    #[error("{source}{}", hint(source))]
    Method {
        /// What is wrong.
        source: MethodError,
    },
    /// The body of the study.
    #[error("{source}\n  hint: {}", hint_on_body(source))]
    Body {
        /// Why it cannot be.
        #[from]
        source: BodyError,
    },
    /// A state at which the body has no forces.
    #[error("{0}\n  hint: choose a state at which the law is defined")]
    Fault(#[from] Box<Fault>),
    /// A loading that cannot be followed from one imposed stretch to another.
    #[error(
        "{title}, from {imposes} {from} to {to}: {reason}{}",
        note_lines(notes)
    )]
    Loading {
        /// The loading in a few words.
        title: &'static str,
        /// What is imposed: a stretch, or the amount of shear.
        imposes: &'static str,
        /// Its first value.
        from: f64,
        /// Its last value.
        to: f64,
        /// What is wrong.
        reason: String,
        /// What is known of the law that may be why.
        notes: Vec<String>,
    },
    /// A path.
    #[error("{source}{}", path_hint(source))]
    Path {
        /// What is wrong.
        #[from]
        source: PathError,
    },
}

impl From<MethodError> for ProblemError {
    fn from(source: MethodError) -> Self {
        match source {
            MethodError::GivenUp => Self::OutOfTime,
            source => Self::Method { source },
        }
    }
}

impl ProblemError {
    /// The error of a method with these settings, at the place of the setting that it is about.
    pub(crate) fn of(settings: &Settings, error: MethodError) -> Self {
        match settings.blamed(&error) {
            Some(setting) => setting.into(),
            None => error.into(),
        }
    }
}

/// A hint as it follows a message.
fn hint_lines(hint: &str) -> String {
    match hint {
        "" => String::new(),
        hint => format!("\n  hint: {hint}"),
    }
}

/// What may have been meant by a number of numbers that is not the expected one: commas in the place of decimal points, or a stretch along one axis
/// alone.
fn meant(what: &str, text: &str, admitted: impl Fn(usize) -> bool, is_stretch: bool) -> String {
    let items: Vec<&str> = text.split(',').map(str::trim).collect();
    let is_whole = |item: &&str| {
        let digits = item.trim_start_matches('-');
        !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit())
    };
    if items.len().is_multiple_of(2) && admitted(items.len() / 2) && items.iter().all(is_whole) {
        let pairs: Vec<String> = items.chunks(2).map(|pair| pair.join(".")).collect();
        return format!(
            "numbers have a decimal point, and commas between them: {what} {}",
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

/// Notes as they follow a message.
fn note_lines(notes: &[String]) -> String {
    notes
        .iter()
        .map(|note| format!("\n  note: {note}"))
        .collect()
}

/// A message without its hint, which is about one value alone.
fn first_line(error: &ProblemError) -> String {
    let told = error.to_string();
    told.lines().next().unwrap_or_default().to_owned()
}

fn path_hint(error: &PathError) -> &'static str {
    match error {
        PathError::Method { source, .. } => hint(source),
        PathError::Kinematics { .. } => "",
    }
}

/// In how many dimensions a state is given, and whether components beyond them can be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extent {
    /// The number of dimensions of the lattice.
    pub dimension: usize,
    /// What a body of one or two dimensions has beyond them.
    pub plane: Plane,
}

/// So many dimensions, components beyond being given.
impl From<usize> for Extent {
    fn from(dimension: usize) -> Self {
        Self {
            dimension,
            plane: Plane::Strain,
        }
    }
}

impl Extent {
    /// Returns true if components beyond the dimensions cannot be given: they are found, or there are none.
    pub(super) fn leaves_none_beyond(self) -> bool {
        self.plane != Plane::Strain
    }

    /// Refuses numbers for what is found.
    fn check(self, what: &'static str, given: usize, own: usize) -> Result<(), ProblemError> {
        match self.leaves_none_beyond() && given != own {
            true => Err(self.refused(what, given, own)),
            false => Ok(()),
        }
    }

    fn refused(self, what: &'static str, given: usize, own: usize) -> ProblemError {
        let found = match (self.dimension, self.plane) {
            (_, Plane::Membrane) => {
                "a law of the plane (material.plane = membrane) has no third direction"
            }
            (1, _) => "in uniaxial stress the lateral stretches are found",
            _ => "in plane stress the stretch across the sheet is found",
        };
        ProblemError::Numbers {
            what,
            given,
            expected: format!("{own}: {found}"),
            hint: "leave out what is beyond; or set material.plane=strain to give it".to_owned(),
        }
    }
}

/// A deformation as typed, and whether stretches or components beyond the dimensions of the lattice were typed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strain(pub DeformationGradient, bool);

impl From<DeformationGradient> for Strain {
    fn from(f: DeformationGradient) -> Self {
        Self(f, false)
    }
}

impl Strain {
    /// None: the reference configuration, `F = 1`.
    pub fn reference() -> Self {
        DeformationGradient::identity().into()
    }

    /// Returns true if stretches or components beyond the dimensions of the lattice were given.
    pub(super) fn is_of_space(&self) -> bool {
        self.1
    }

    /// Principal stretches along the axes: as many as the lattice has dimensions, and optionally those
    /// out of them (1 unless given).
    ///
    /// # Errors
    /// [`ProblemError`] when the numbers are too few, too many, or no stretches, and when those beyond are found.
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

    /// The components of `F`: 1 in one dimension, `F11,F12,F21,F22` in two, or all nine; in three dimensions all nine.
    ///
    /// # Errors
    /// [`ProblemError`] when their number is another, or `det F` is not positive.
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

    /// Stretches, or the four components of `F`: the end of a path.
    ///
    /// # Errors
    /// As for the two other constructors.
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
    /// In how many dimensions states are given.
    pub fn extent(&self) -> Extent {
        Extent {
            dimension: self.dimension(),
            plane: self.material.plane(),
        }
    }
}

/// A list of finite numbers separated by commas; `what` is the argument, for messages.
///
/// # Errors
/// [`ProblemError`] for what is no finite number.
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

/// A material with a discretization.
pub struct Problem {
    /// As set.
    pub settings: Settings,
    /// The law.
    pub material: Arc<dyn Hyperelastic>,
    /// Both together, ready to be asked.
    pub analysis: Box<dyn Analysis>,
}

impl Problem {
    /// Builds the material and the method.
    ///
    /// # Errors
    /// [`ProblemError`] when one of them is not admissible.
    pub fn new(settings: Settings) -> Result<Self, ProblemError> {
        match settings.law() {
            Ok(material) => Self::with_law(settings, material),
            Err(error) => Err(ProblemError::of(&settings, error.into())),
        }
    }

    /// Builds the method for a material that may be shared.
    ///
    /// # Errors
    /// [`ProblemError`] when the method is not admissible.
    pub(crate) fn with_law(
        settings: Settings,
        material: Arc<dyn Hyperelastic>,
    ) -> Result<Self, ProblemError> {
        let built = method(&settings).and_then(|method| analysis(&method, Arc::clone(&material)));
        let analysis = built.map_err(|error| ProblemError::of(&settings, error))?;
        Ok(Self {
            analysis,
            settings,
            material,
        })
    }

    /// The same particles in the cell that the settings describe, of which patches are made.
    ///
    /// # Errors
    /// [`ProblemError`] when the method is not admissible.
    pub fn described(&self) -> Result<Self, ProblemError> {
        let method = method(&self.settings)?;
        Ok(Self {
            analysis: described_analysis(&method, Arc::clone(&self.material))?,
            settings: self.settings.clone(),
            material: Arc::clone(&self.material),
        })
    }

    /// The number of space dimensions.
    pub fn dimension(&self) -> usize {
        self.analysis.dimension()
    }

    /// A state with what a sheet in plane stress, or a bar in uniaxial stress, finds across it; the state as it is given elsewhere, and where there is none.
    pub fn found(&self, f: &DeformationGradient) -> DeformationGradient {
        match self.material.dimension() {
            3 => *f,
            _ => self
                .material
                .response(f)
                .map_or(*f, |found| found.deformation),
        }
    }

    /// A state that was given by all components, unless some of them are found.
    ///
    /// # Errors
    /// [`ProblemError::Numbers`] where components across a sheet or bar are not those of the reference.
    pub fn given(&self, f: DeformationGradient) -> Result<DeformationGradient, ProblemError> {
        let extent = self.extent();
        let dimension = extent.dimension;
        match extent.leaves_none_beyond() && f != f.given_in(dimension) {
            true => Err(extent.refused("F", 9, dimension * dimension)),
            false => Ok(f),
        }
    }

    /// In how many dimensions its states are given.
    pub fn extent(&self) -> Extent {
        self.settings.extent()
    }
}
