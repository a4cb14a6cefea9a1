//! Is a material what its author believes? Stress against energy, tangent against stress, frames against each other.
//!
//! Nothing is taken from the material but values: every derivative is a difference of stresses or energies. See
//! [`Convention`] for the tangents that are told from each other, and [`Reading`] for the usual slips.

mod checks;
mod convention;
mod difference;
mod reading;
mod report;
mod states;
mod subject;
mod tangent;

pub use checks::{Check, Outcome};
pub use convention::{Convention, StressChange};
pub use reading::{Delivery, Match, Order, Reading, Shear, Volume, matches};
pub use states::{State, states};
pub use subject::{Sample, Subject};
pub use tangent::{Misfit, Partial, TangentFinding};

use crate::settings::{MaterialSettings, Value};
use checks::Measured;
use onset::kinematics::{DeformationGradient, KinematicsError};
use onset::material::MaterialError;
use onset_umat::Umat;
use serde::Serialize;
use thiserror::Error;

/// Why an audit came to no end.
#[derive(Debug, Error)]
pub enum AuditError {
    /// The material failed at a state.
    #[error("{source}{}", hint(source))]
    Material {
        /// How.
        #[from]
        source: MaterialError,
    },
    /// A user material delivers in one convention only.
    #[error(
        "a UMAT delivers its tangent as {}; --as is for laws of onset's own",
        Convention::JaumannKirchhoff.name()
    )]
    Convention,
    /// A law whose tangent is not the derivative of its stress along paths from the reference.
    #[error(
        "{0} is in rate form: its tangent is that of rates that go on (of a metal, of continued flow), and not the derivative of the stress by the end of the path\n  hint: an audit is for laws with an energy \
         and for UMATs, whose last increment is compared"
    )]
    Flow(&'static str),
    /// A state near one of those asked for is none.
    #[error("{source}\n  hint: choose smaller strains")]
    Kinematics {
        /// What is wrong.
        #[from]
        source: KinematicsError,
    },
}

fn hint(error: &MaterialError) -> &'static str {
    match error {
        MaterialError::NotFinite { .. } => "\n  hint: choose smaller strains, --strain=0.05",
        _ => "",
    }
}

/// Relative errors above this are findings; differences are known to about 1e-10.
pub const TOLERANCE: f64 = 1e-6;

/// The result of an audit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Audit {
    /// What was audited.
    pub material: String,
    /// Whether all that must hold does; `false` also where a check is undetermined.
    pub consistent: bool,
    /// In a sentence.
    pub verdict: String,
    /// The number of states; the undeformed one is always among them.
    pub states: usize,
    /// What was checked.
    pub checks: Vec<Check>,
    /// The tangent.
    pub tangent: TangentFinding,
}

impl Audit {
    /// Audits a material as set. The tangent of a law is taken as delivered in the convention, `dP/dF` unless named.
    ///
    /// # Errors
    /// [`AuditError`] when the material cannot be made, or fails at a state or near it.
    pub fn of_material(
        settings: &MaterialSettings,
        convention: Option<Convention>,
        states: &[DeformationGradient],
    ) -> Result<Self, AuditError> {
        let name = description(settings);
        // Rotations and strains across a plane are part of what is checked.
        let settings = &settings.clone().in_space();
        match (settings.umat_permitted()?, convention) {
            (Some(_), Some(_)) => Err(AuditError::Convention),
            (Some(umat), None) => {
                let umat = Umat::new(umat).map_err(MaterialError::from)?;
                Self::new(&name, &Subject::User(&umat), states)
            }
            (None, _) if settings.model.is_in_rate_form() => {
                Err(AuditError::Flow(settings.model.name()))
            }
            (None, convention) => {
                let law = settings.build()?;
                let convention = convention.unwrap_or(Convention::FirstPiola);
                Self::new(&name, &Subject::Law(law.as_ref(), convention), states)
            }
        }
    }

    /// Audits a material in the undeformed state and at states.
    ///
    /// # Errors
    /// [`AuditError`] when it fails at one of them, or near it.
    pub fn new(
        material: &str,
        subject: &Subject<'_>,
        states: &[DeformationGradient],
    ) -> Result<Self, AuditError> {
        let reference = Measured::new(subject, &DeformationGradient::identity())?;
        let mut measured = vec![reference.clone()];
        for f in states
            .iter()
            .filter(|f| **f != DeformationGradient::identity())
        {
            measured.push(Measured::new(subject, f)?);
        }
        let tangent = TangentFinding::new(subject, &reference, &measured)?;
        let mut checks = checks::all(subject, &reference, &measured)?;
        checks.push(tangent.check(subject, &measured));
        let is_open =
            |check: &Check| matches!(check.outcome, Outcome::Failed | Outcome::Undetermined);
        let consistent = !checks.iter().any(is_open);
        Ok(Self {
            material: material.to_owned(),
            consistent,
            verdict: report::verdict(consistent, &checks, &tangent),
            states: measured.len(),
            checks,
            tangent,
        })
    }
}

/// The material with its parameters.
fn description(settings: &MaterialSettings) -> String {
    let entries = settings.entries();
    let entry = |(name, value): &(&str, Value)| format!("{name} = {value}");
    let list: Vec<String> = entries.iter().map(entry).collect();
    match list.is_empty() {
        true => settings.model.name().to_owned(),
        false => format!("{} ({})", settings.model.name(), list.join(", ")),
    }
}

/// Differences that are known no better than this tell no convention from another.
const UNKNOWN: f64 = 1e-4;
