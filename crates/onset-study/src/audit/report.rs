//! Text output of an audit.

use super::checks::{Check, Outcome};
use super::{Audit, TangentFinding};
use crate::number::told_with;
use std::fmt::{self, Display, Formatter};

/// Summary of the audit, in a sentence or two.
pub fn verdict(consistent: bool, checks: &[Check], tangent: &TangentFinding) -> String {
    let of_tangent = checks.iter().find(|check| check.name == "tangent");

    let of = |outcome: Outcome| -> Vec<&Check> {
        checks
            .iter()
            .filter(|check| check.outcome == outcome)
            .collect()
    };
    let (failed, open) = (of(Outcome::Failed), of(Outcome::Undetermined));
    if let (true, Some(_), Some(check)) = (consistent, tangent.small_strain_update, of_tangent) {
        return format!(
            "Consistent with its small-strain update. {}.",
            check.finding
        );
    }
    if consistent {
        return format!(
            "Consistent: all checks passed, and the tangent is {} (largest error {:.1e}).",
            tangent.expected.meaning(),
            tangent.expected_error
        );
    }
    if failed.is_empty() {
        let names: Vec<&str> = open.iter().map(|check| check.name).collect();
        return format!(
            "Undetermined: {}. The stress has kinks near these states, and its differences are accurate only to {:.0e}; nothing else failed. \
             Repeat the audit at states further from yield (--strain).",
            names.join(", "),
            tangent.uncertainty
        );
    }
    let findings: Vec<String> = failed
        .iter()
        .map(|check| capitalized(&check.finding))
        .collect();
    format!("Not consistent. {}.", findings.join(". "))
}

fn capitalized(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().chain(letters).collect()
    })
}

impl Display for Audit {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}\n", self.verdict)?;
        writeln!(f, "material   {}", self.material)?;
        let [low, high] = self.stretches.map(|value| told_with(value, 4));
        let [smaller, larger] = self.jacobians.map(|value| told_with(value, 4));
        writeln!(
            f,
            "states     {}, principal stretches {low} to {high}, J {smaller} to {larger}; not tested beyond (--strain)",
            self.states
        )?;
        for note in &self.notes {
            writeln!(f, "note       {note}")?;
        }
        writeln!(f)?;
        for check in &self.checks {
            let mark = match check.outcome {
                Outcome::Passed => "passed",
                Outcome::Failed => "FAILED",
                Outcome::Undetermined => "unknown",
                Outcome::Noted => "noted",
            };
            let error = check
                .error
                .map_or_else(|| "-".to_owned(), |error| format!("{error:.1e}"));
            writeln!(
                f,
                "{mark:<7} {:<24} {error:>8}  {}",
                check.name, check.finding
            )?;
        }
        writeln!(
            f,
            "\nTangent compared with differences of the stress (accurate to {:.0e}):",
            self.tangent.uncertainty
        )?;
        for candidate in &self.tangent.conventions {
            let convention = candidate.reading.convention;
            let mark = match (&self.tangent.identified, convention) {
                (Some(found), convention) if found.reading.convention == convention => "->",
                _ => "",
            };
            let expected = match convention == self.tangent.expected {
                true => " (expected)",
                false => "",
            };
            writeln!(
                f,
                "{mark:<2} {:<23} {:>8.1e}  {}{expected}",
                convention.name(),
                candidate.error,
                convention.meaning()
            )?;
        }
        if let Some(found) = &self.tangent.identified {
            if !found.reading.slips().is_empty() {
                writeln!(f, "It is {} (error {:.1e}).", found.sentence, found.error)?;
            }
            for other in &self.tangent.indistinguishable {
                writeln!(
                    f,
                    "At these states it cannot be distinguished from: {} (error {:.1e}).",
                    other.sentence, other.error
                )?;
            }
        }
        Ok(())
    }
}
