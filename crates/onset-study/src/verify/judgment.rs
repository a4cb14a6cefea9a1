//! Comparison of measured with predicted rates.

use super::{CASE_FILE, Case, Fit, Projector, Rate, Record, VerifyError, fitted, named};
use crate::csv::Table;
use crate::input;
use crate::number::{exact, told, vector};
use crate::settings::Units;
use onset::algebra::Complex;
use serde::Serialize;
use std::fmt;
use std::path::{Path, PathBuf};

/// Outcome of a comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// The rates agree within the tolerance, and the uncertainty does not exceed the tolerance.
    Agrees,
    /// The rates differ by more than the uncertainty.
    Differs,
    /// The record is not sufficient for a decision.
    Undecided,
}

impl Outcome {
    /// Name of the outcome.
    pub fn name(self) -> &'static str {
        match self {
            Self::Agrees => "agrees",
            Self::Differs => "differs",
            Self::Undecided => "undecided",
        }
    }

    /// Exit code: 0, 1, 3.
    pub fn code(self) -> u8 {
        match self {
            Self::Agrees => 0,
            Self::Differs => 1,
            Self::Undecided => 3,
        }
    }
}

/// Comparison of the measured with the predicted rate of a wave.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Judgment {
    /// Outcome of the comparison.
    pub outcome: Outcome,
    /// Reason if undecided; empty otherwise.
    pub reason: String,
    /// Name of the code.
    pub code: String,
    /// Identifier of the case.
    pub case: String,
    /// Reference wave vector; 1/length.
    pub wave_vector: Vec<f64>,
    /// Direction of the displacements.
    pub polarization: Vec<f64>,
    /// Stretches of the state.
    pub stretches: [f64; 3],
    /// `omega^2` of the linearized equations; 1/time^2.
    pub omega_squared: f64,
    /// `omega^2` of the measured rate, corrected for the effect of the time step; 1/time^2.
    pub measured_omega_squared: f64,
    /// Time step of the run; time.
    pub time_step: f64,
    /// Predicted rate in discrete time; 1/time.
    pub predicted: Rate,
    /// Rate of the record; 1/time.
    pub measured: Rate,
    /// Difference of the two rates, relative to the predicted rate.
    pub difference: f64,
    /// Uncertainty of the measured rate, relative to the predicted rate.
    pub uncertainty: f64,
    /// Largest relative difference that counts as agreement.
    pub tolerance: f64,
    /// Root mean square of the residual, divided by the largest amplitude of the record.
    pub residual: f64,
    /// Number of frames read.
    pub frames: usize,
    /// Number of frames of a complete output.
    pub expected_frames: usize,
}

/// Largest relative residual of a record that counts as a single wave.
const MAX_RESIDUAL: f64 = 0.02;
/// Factor on the uncertainty within which a difference is undecided. An uncertainty estimated from a fraction of a period is itself uncertain.
const UNDECIDED_UNCERTAINTY_FACTOR: f64 = 4.0;

/// Reads an output and compares it with the prediction.
///
/// `path` is the output, or the folder of the deck. The case file is read from the same folder unless `case` names another file.
///
/// # Errors
/// [`VerifyError`] for a file that cannot be read, or does not belong to the case.
pub fn read(path: &Path, case: Option<&Path>) -> Result<Judgment, VerifyError> {
    let folder = match path.is_dir() {
        true => path.to_owned(),
        false => path.parent().map_or_else(PathBuf::new, Path::to_owned),
    };
    let case = Case::of_file(case.unwrap_or(&folder.join(CASE_FILE)))?;
    let code = named(&case.code)?;
    let path = match path.is_dir() {
        true => path.join(code.output()),
        false => path.to_owned(),
    };
    let bytes =
        input::bytes(&path, input::MOST_OUTPUT).map_err(|source| VerifyError::Unreadable {
            path: path.clone(),
            source,
        })?;
    let projector = Projector::new(&case, &path);
    let text = input::decoded(bytes).map_err(|error| {
        projector.wrong(0, error.to_string(), "give the output that the deck writes")
    })?;
    let record = code.read(&path, &text, projector)?;
    judge(&case, &record)
}

/// Compares a record with the prediction.
///
/// # Errors
/// [`VerifyError::Fit`] for a record without a wave.
pub fn judge(case: &Case, record: &Record) -> Result<Judgment, VerifyError> {
    let predicted = case.rate();
    let others = case.prediction.others.iter().copied();
    let others: Vec<Complex> = others.map(Complex::from).collect();
    let expected = case.prediction.rates.map(Complex::from);
    let fit = fitted(&record.samples, expected, &others).map_err(|source| VerifyError::Fit {
        path: record.path.clone(),
        source,
    })?;
    let difference = (fit.rate - predicted).norm() / predicted.norm();
    let uncertainty = fit.uncertainty / predicted.norm();
    let (outcome, reason) = outcome(case, record, &fit, difference, uncertainty);
    // To first order in the difference of the rates, the time step has the same effect on both.
    let root = Complex::new(-case.prediction.omega_squared, 0.0).sqrt();
    let corrected = root * (fit.rate / predicted);
    Ok(Judgment {
        outcome,
        reason,
        code: case.code.clone(),
        case: case.id.clone(),
        wave_vector: case.wave_vector.clone(),
        polarization: case.prediction.polarization.clone(),
        stretches: case.stretches,
        omega_squared: case.prediction.omega_squared,
        measured_omega_squared: -(corrected * corrected).re,
        time_step: case.time_step,
        predicted: predicted.into(),
        measured: fit.rate.into(),
        difference,
        uncertainty,
        tolerance: case.tolerance,
        residual: fit.residual,
        frames: record.samples.len(),
        expected_frames: case.frames(),
    })
}

fn outcome(
    case: &Case,
    record: &Record,
    fit: &Fit,
    difference: f64,
    uncertainty: f64,
) -> (Outcome, String) {
    let end = record.samples.last().map_or(0.0, |(time, _)| *time);
    let whole = case.time_step * (case.steps / case.every * case.every) as f64;
    if record.is_cut || end < whole * (1.0 - 1e-9) {
        let cut = if record.is_cut {
            ", within a frame"
        } else {
            ""
        };
        return (
            Outcome::Undecided,
            format!(
                "the output ends at time {}{cut}; the run of the deck ends at {}",
                told(end),
                told(whole)
            ),
        );
    }
    compared(fit.residual, difference, uncertainty, case.tolerance)
}

/// Outcome of a fit from its relative residual, its relative difference from the prediction, and its relative uncertainty.
pub(crate) fn compared(
    residual: f64,
    difference: f64,
    uncertainty: f64,
    tolerance: f64,
) -> (Outcome, String) {
    if residual > MAX_RESIDUAL {
        return (
            Outcome::Undecided,
            format!(
                "the record is not a single wave: {:.1} % of it remains unexplained",
                100.0 * residual
            ),
        );
    }
    if difference > tolerance + UNDECIDED_UNCERTAINTY_FACTOR * uncertainty {
        return (Outcome::Differs, String::new());
    }
    if uncertainty > tolerance {
        return (
            Outcome::Undecided,
            format!(
                "the rate is uncertain by {uncertainty:.1e}, more than the tolerance {tolerance:.1e}"
            ),
        );
    }
    match difference <= tolerance {
        true => (Outcome::Agrees, String::new()),
        false => (
            Outcome::Undecided,
            "the difference exceeds the tolerance, but not four times the uncertainty".to_owned(),
        ),
    }
}

impl Judgment {
    /// Predicted and measured rate as CSV, in one row.
    pub fn csv(&self) -> String {
        Table::new(std::slice::from_ref(self), Units::Own)
            .with("outcome", "1", |own| own.outcome.name())
            .with("code", "1", |own| own.code.as_str())
            .with("case", "1", |own| own.case.as_str())
            .each("stretch", 3, "1", |own, n| own.stretches[n])
            .each(
                "wave_vector",
                self.wave_vector.len(),
                "1/length",
                |own, n| own.wave_vector[n],
            )
            .with("time_step", "time", |own| own.time_step)
            .with("predicted_growth", "1/time", |own| own.predicted.growth)
            .with("predicted_frequency", "1/time", |own| {
                own.predicted.frequency
            })
            .with("measured_growth", "1/time", |own| own.measured.growth)
            .with("measured_frequency", "1/time", |own| own.measured.frequency)
            .with("difference", "1", |own| own.difference)
            .with("uncertainty", "1", |own| own.uncertainty)
            .to_string()
    }
}

impl fmt::Display for Judgment {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rate = |rate: &Rate| match rate.is_growth() {
            true => format!("growth rate {:.9}", rate.growth),
            false => format!(
                "frequency {:.9}, growth rate {:+.3e}",
                rate.frequency, rate.growth
            ),
        };
        writeln!(formatter, "outcome      {}", self.outcome.name())?;
        if !self.reason.is_empty() {
            writeln!(formatter, "             {}", self.reason)?;
        }
        writeln!(formatter, "code         {}, case {}", self.code, self.case)?;
        writeln!(
            formatter,
            "wave         k = {}, polarization {}, stretches {}",
            vector(&self.wave_vector),
            vector(&self.polarization),
            vector(&self.stretches)
        )?;
        writeln!(
            formatter,
            "omega^2      {:.9} predicted, {:.9} measured",
            self.omega_squared, self.measured_omega_squared
        )?;
        writeln!(
            formatter,
            "predicted    {}, in discrete time with step {}",
            rate(&self.predicted),
            exact(self.time_step)
        )?;
        writeln!(formatter, "measured     {}", rate(&self.measured))?;
        writeln!(
            formatter,
            "difference   {:.1e} of the rate, uncertain by {:.1e}; tolerance {:.1e}",
            self.difference, self.uncertainty, self.tolerance
        )?;
        write!(
            formatter,
            "record       {} of {} frames, {:.1e} of the amplitude left unexplained",
            self.frames, self.expected_frames, self.residual
        )
    }
}
