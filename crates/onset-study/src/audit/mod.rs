//! Audit of a material: stress against energy, tangent against stress, and objectivity.
//!
//! The audit uses only values of the material: every derivative is a difference of stresses or energies. [`Convention`] lists the tangents that are
//! distinguished, and [`Reading`] the usual mistakes.

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

use crate::csv::Table;
use crate::settings::{MaterialSettings, Units, Value, is_of_an_absent_term};
use checks::Measured;
use onset::kinematics::{DeformationGradient, KinematicsError};
use onset::material::MaterialError;
use onset_umat::Umat;
use serde::Serialize;
use thiserror::Error;

/// Reasons why an audit fails.
#[derive(Debug, Error)]
pub enum AuditError {
    /// The material failed at a state.
    #[error("{source}{}", hint(source))]
    Material {
        /// Cause of the failure.
        #[from]
        source: MaterialError,
    },
    /// A convention was requested for a user material, which can deliver only one.
    #[error(
        "a UMAT delivers its tangent as {}; --as is for built-in laws",
        Convention::JaumannKirchhoff.name()
    )]
    Convention,
    /// The law is in rate form, so that its tangent is not the derivative of its stress along paths from the reference configuration.
    #[error(
        "{0} is in rate form: its tangent describes continued loading (for a metal, continued flow), not the derivative of the stress at the end of the path\n  hint: an audit is for laws with an energy \
         and for UMATs, whose last increment is compared"
    )]
    Flow(&'static str),
    /// A state near a requested state has no valid deformation gradient.
    #[error("{source}\n  hint: choose smaller strains")]
    Kinematics {
        /// Cause of the failure.
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

/// Largest relative error that is accepted; differences are accurate to about 1e-10.
pub const TOLERANCE: f64 = 1e-6;

/// Verdict on the consistency of a material, with the checks behind it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Audit {
    /// Material with its parameters.
    pub material: String,
    /// Whether every requirement holds; `false` also if a check is undetermined.
    pub consistent: bool,
    /// Summary of the audit, in a sentence or two.
    pub verdict: String,
    /// Number of audited states, including the reference configuration.
    pub states: usize,
    /// Smallest and largest principal stretch of the states; nothing is tested beyond them.
    pub stretches: [f64; 2],
    /// Smallest and largest Jacobian of the states.
    pub jacobians: [f64; 2],
    /// Results of the checks.
    pub checks: Vec<Check>,
    /// Identification of the tangent.
    pub tangent: TangentFinding,
    /// Notes on the deck of another program that defines the law.
    pub notes: Vec<String>,
}

impl Audit {
    /// The checks as CSV, one row for each.
    pub fn csv(&self) -> String {
        Table::new(&self.checks, Units::Own)
            .with("check", "1", |own| own.name)
            .with("outcome", "1", |own| own.outcome.name())
            .with("error", "1", |own| own.error)
            .with("finding", "1", |own| own.finding.as_str())
            .to_string()
    }

    /// Audits a material as set. The tangent of a law is delivered in the given convention, or as `dP/dF`.
    ///
    /// # Errors
    /// [`AuditError`] when the material cannot be built, or fails at a state or near it.
    pub fn of_material(
        settings: &MaterialSettings,
        convention: Option<Convention>,
        states: &[DeformationGradient],
    ) -> Result<Self, AuditError> {
        let name = description(settings);
        // The checks include rotations and strains out of the plane.
        let settings = &settings.clone().in_space();
        let audit = match (settings.umat_permitted()?, convention) {
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
        };
        audit.map(|audit| Self {
            notes: settings.notes().to_vec(),
            ..audit
        })
    }

    /// Audits a material in the reference configuration and at the given states.
    ///
    /// # Errors
    /// [`AuditError`] when the material fails at a state or near it.
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
        let is_update = tangent.small_strain_update.is_some();
        let mut checks = checks::all(subject, &reference, &measured, is_update)?;
        checks.push(tangent.check(subject, &measured));
        let deformations = || measured.iter().map(|own| own.sample.deformation);
        let is_open =
            |check: &Check| matches!(check.outcome, Outcome::Failed | Outcome::Undetermined);
        let consistent = !checks.iter().any(is_open);
        Ok(Self {
            material: material.to_owned(),
            consistent,
            verdict: report::verdict(consistent, &checks, &tangent),
            states: measured.len(),
            stretches: range(deformations().flat_map(|f| f.principal_stretches())),
            jacobians: range(deformations().map(|f| f.jacobian())),
            checks,
            tangent,
            notes: Vec::new(),
        })
    }
}

/// Smallest and largest of some values.
fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let unknown = [f64::INFINITY, f64::NEG_INFINITY];
    values.fold(unknown, |[low, high], value| {
        [low.min(value), high.max(value)]
    })
}

fn description(settings: &MaterialSettings) -> String {
    let entries = settings.entries();
    let number = |name: &str| {
        let mut known = entries.iter().filter(|(other, _)| *other == name);
        known.next()?.1.number()
    };
    let present = entries
        .iter()
        .filter(|(name, _)| !is_of_an_absent_term(name, number));
    let entry = |(name, value): &(&str, Value)| format!("{name} = {value}");
    let list: Vec<String> = present.map(entry).collect();
    match list.is_empty() {
        true => settings.model.name().to_owned(),
        false => format!("{} ({})", settings.model.name(), list.join(", ")),
    }
}

/// Largest uncertainty of the differences for which conventions can be distinguished.
const DISTINCTION_UNCERTAINTY: f64 = 1e-4;
