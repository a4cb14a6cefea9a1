//! Identification of the delivered tangent.

use super::checks::{Check, Measured, Outcome};
use super::convention::{Convention, StressChange};
use super::reading::{Delivery, Match, Reading, matches, relative_to};
use super::states::State;
use super::subject::Subject;
use super::{AuditError, TOLERANCE};
use nalgebra::{SymmetricEigen, Vector6};
use onset_umat::VOIGT;
use serde::Serialize;

/// Errors of a delivered tangent against each convention, and the conventions that it may follow.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TangentFinding {
    /// Convention that the tangent should follow.
    pub expected: Convention,
    /// Largest relative error against the expected convention.
    pub expected_error: f64,
    /// Reading that fits at all states; `null` if no reading does.
    pub identified: Option<Match>,
    /// Other readings that fit equally well at the tested states, with the same number of mistakes.
    pub indistinguishable: Vec<Match>,
    /// Reading that fits at some of the states; `null` if a reading fits at all states, or each reading at too few of them.
    pub in_part: Option<Partial>,
    /// Largest `|sigma_ij delta_kl|`, which the tangent of a small-strain update lacks, relative to the expected tangent; `null` for other tangents.
    pub small_strain_update: Option<f64>,
    /// Largest relative error of stress = tangent : logarithmic strain, if the tangent is a secant stiffness; `null` for other tangents.
    pub secant: Option<f64>,
    /// Closest reading, if no reading fits and it is clearly closer than the expected reading; otherwise `null`.
    pub nearest: Option<Match>,
    /// Errors of every convention without mistakes.
    pub conventions: Vec<Match>,
    /// Relative uncertainty of the differences.
    pub uncertainty: f64,
}

/// Reading that fits at more states than the other readings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Partial {
    /// Convention and mistakes, with the error.
    #[serde(flatten)]
    pub reading: Match,
    /// Number of states at which the reading fits, among the states with accurate differences.
    pub fits: usize,
    /// Number of states with accurate differences.
    pub of: usize,
    /// States at which the reading does not fit, worst first.
    pub fails: Vec<Misfit>,
}

/// State at which a reading does not fit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Misfit {
    /// Description of the state.
    #[serde(flatten)]
    pub state: State,
    /// Relative error at the state.
    pub error: f64,
}

/// Largest ratio of the error of a reading to the error of the expected one for which it is clearly closer.
const DISTINCTION_RATIO: f64 = 0.1;

/// A fit at no more than this fraction of the states is considered a coincidence.
const COINCIDENCE: f64 = 0.25;

/// Number of misfits that are listed in a sentence.
const MAX_LISTED_STATES: usize = 3;

impl TangentFinding {
    /// Identifies the tangent from the measured states.
    ///
    /// # Errors
    /// [`AuditError`] when the material fails on a path.
    pub(super) fn new(
        subject: &Subject<'_>,
        reference: &Measured,
        measured: &[Measured],
    ) -> Result<Self, AuditError> {
        let changes: Vec<StressChange> =
            measured.iter().map(|state| state.change.clone()).collect();
        let deliveries: Vec<Delivery> = measured
            .iter()
            .map(|state| state.sample.delivery.clone())
            .collect();
        let mut all = matches(&changes, &deliveries, &reference.change.gradient);
        let known: Vec<usize> = (0..measured.len())
            .filter(|at| measured[*at].is_known())
            .collect();
        for candidate in all.iter_mut().filter(|_| !known.is_empty()) {
            candidate.error = known
                .iter()
                .map(|at| candidate.errors[*at])
                .fold(0.0, f64::max);
        }
        let fits = |candidate: &Match| {
            let fits = |at: &&usize| candidate.errors[**at] <= measured[**at].tolerance();
            known.iter().filter(fits).count()
        };
        let expected = Reading::plain(subject.convention());
        // Order: fits at most states, then fewest mistakes, then the expected convention.
        let mut ranked: Vec<(usize, &Match)> = all
            .iter()
            .map(|candidate| (fits(candidate), candidate))
            .collect();
        ranked.sort_by_key(|(fits, candidate)| {
            let slips = candidate.reading.slips().len();
            (usize::MAX - fits, slips, candidate.reading != expected)
        });
        let of_expected = all.iter().find(|candidate| candidate.reading == expected);
        let expected_error = of_expected.map_or(f64::INFINITY, |candidate| candidate.error);
        let best = ranked.first().copied().filter(|_| !known.is_empty());
        let identified = best
            .filter(|(fits, _)| *fits == known.len())
            .map(|(_, best)| best.clone());
        let in_part = best
            // A reading that fits at all states identifies the tangent completely.
            .filter(|(fits, _)| {
                *fits < known.len() && *fits as f64 > COINCIDENCE * known.len() as f64
            })
            .map(|(fits, best)| Partial::new(best, fits, &known, measured));
        let indistinguishable: Vec<Match> = identified
            .iter()
            .flat_map(|best| {
                ranked.iter().skip(1).filter(|(fits, other)| {
                    *fits == known.len()
                        && other.reading.slips().len() == best.reading.slips().len()
                })
            })
            .map(|(_, other)| (*other).clone())
            .collect();
        let secant = match (&identified, &in_part) {
            (None, None) => secant_error(known.iter().map(|at| &measured[*at])),
            _ => None,
        };
        let nearest = all
            .iter()
            .min_by(|a, b| a.error.total_cmp(&b.error))
            .filter(|nearest| nearest.error <= DISTINCTION_RATIO * expected_error)
            .filter(|_| identified.is_none() && in_part.is_none() && secant.is_none());
        Ok(Self {
            expected: subject.convention(),
            expected_error,
            small_strain_update: small_strain_update(
                subject,
                &identified,
                &indistinguishable,
                measured,
            )?,
            indistinguishable,
            identified,
            in_part,
            secant,
            nearest: nearest.cloned(),
            conventions: all
                .iter()
                .filter(|candidate| candidate.reading.slips().is_empty())
                .cloned()
                .collect(),
            uncertainty: super::checks::uncertainty(measured),
        })
    }

    /// The check of the tangent that follows from the finding.
    pub(super) fn check(&self, subject: &Subject<'_>, measured: &[Measured]) -> Check {
        let name = subject.tangent_name();
        let of_expected = self
            .conventions
            .iter()
            .find(|candidate| candidate.reading.convention == self.expected);
        let errors = of_expected.map_or(&[][..], |candidate| &candidate.errors);
        let worst = |is_known: bool| {
            measured
                .iter()
                .zip(errors)
                .filter(|(state, error)| {
                    state.is_known() == is_known && **error > state.tolerance_of_kink()
                })
                .max_by(|a, b| a.1.total_cmp(b.1))
        };
        let (known, unknown) = (worst(true), worst(false));
        Check {
            name: "tangent",
            outcome: match (known, unknown, self.small_strain_update) {
                (Some(_), None, Some(_)) => Outcome::Noted,
                (Some(_), Some(_), Some(_)) => Outcome::Undetermined,
                (Some(_), ..) => Outcome::Failed,
                (None, Some(_), _) => Outcome::Undetermined,
                (None, None, _) => Outcome::Passed,
            },
            error: Some(self.expected_error),
            state: known.or(unknown).map(|(state, _)| state.state()),
            finding: match (known.is_some(), unknown.is_some()) {
                (true, is_open) if !(is_open && self.small_strain_update.is_some()) => {
                    self.misfit(name)
                }
                (_, true) => format!(
                    "The stress is not smooth enough at these states to identify {name}: its differences are accurate only to {:.0e}",
                    self.uncertainty
                ),
                (_, false) => format!("{name} is {}, as expected", self.expected.meaning()),
            },
        }
    }

    /// Describes how the tangent differs from the expected one.
    fn misfit(&self, name: &str) -> String {
        let expected = self.expected.meaning();
        if let Some(lacking) = self.small_strain_update {
            return format!(
                "{name} is the tangent of a small-strain update, the Cauchy stress per strain increment: against {expected} it lacks sigma_ij delta_kl, up to {lacking:.1e} of it at \
                 these states. That is usual, and matters for ellipticity where the stress is not small against the moduli"
            );
        }
        match (&self.identified, &self.in_part, self.secant, &self.nearest) {
            (Some(found), ..) => format!("{name} is not {expected}; it is {}", found.sentence),
            (_, Some(in_part), ..) => {
                let fits = match in_part.reading.reading == Reading::plain(self.expected) {
                    true => format!(
                        "{name} is {expected}, as expected, at {} of {} states",
                        in_part.fits, in_part.of
                    ),
                    false => format!(
                        "{name} is not {expected}; it is {} at {} of {} states",
                        in_part.reading.sentence, in_part.fits, in_part.of
                    ),
                };
                let told = in_part.fails.iter().take(MAX_LISTED_STATES);
                let told: Vec<String> = told
                    .map(|misfit| {
                        format!("{}, error {:.1e}", misfit.state.sentence(), misfit.error)
                    })
                    .collect();
                let more = match in_part.fails.len().saturating_sub(MAX_LISTED_STATES) {
                    0 => String::new(),
                    more => format!("; and {more} more"),
                };
                format!("{fits}, but not at these: {}{more}", told.join("; "))
            }
            (.., Some(error), _) => format!(
                "{name} is not {expected}; it is the secant stiffness: the stress is {name} times the logarithmic strain (error {error:.1e})"
            ),
            (.., Some(nearest)) => format!(
                "{name} is not {expected}, nor any other tested convention; the nearest is {} with error {:.1e}",
                nearest.sentence, nearest.error
            ),
            _ => format!(
                "{name} is not {expected}, and no other tested convention fits clearly better"
            ),
        }
    }
}

impl Partial {
    fn new(reading: &Match, fits: usize, known: &[usize], measured: &[Measured]) -> Self {
        let mut fails: Vec<Misfit> = known
            .iter()
            .filter(|at| reading.errors[**at] > measured[**at].tolerance())
            .map(|at| Misfit {
                state: measured[*at].state(),
                error: reading.errors[*at],
            })
            .collect();
        fails.sort_by(|a, b| b.error.total_cmp(&a.error));
        Self {
            reading: reading.clone(),
            fits,
            of: known.len(),
            fails,
        }
    }
}

/// Relative error of the secant relation, stress = delivered matrix : logarithmic strain; `None` unless it is clearly smaller than with the tangent
/// of the stress.
fn secant_error<'a>(states: impl Iterator<Item = &'a Measured>) -> Option<f64> {
    let (mut secant, mut tangent): (f64, f64) = (0.0, 0.0);
    for state in states {
        let Delivery::Matrix(delivered) = &state.sample.delivery else {
            return None;
        };
        let f = state.sample.deformation.matrix();
        let left = SymmetricEigen::try_new(f * f.transpose(), f64::EPSILON, 500)?;
        let logarithms = left.eigenvalues.map(|square| 0.5 * square.ln());
        let strain = left.eigenvectors
            * nalgebra::Matrix3::from_diagonal(&logarithms)
            * left.eigenvectors.transpose();
        let engineering = Vector6::from_fn(|a, _| strain[VOIGT[a]] * if a < 3 { 1.0 } else { 2.0 });
        let stress = Vector6::from_fn(|a, _| state.sample.cauchy[VOIGT[a]]);
        let full = Convention::JaumannKirchhoff.tangent(&state.change, &state.change.gradient);
        // Without strain there is no secant.
        let least = TOLERANCE * delivered.norm();
        let error = |matrix: &nalgebra::Matrix6<f64>| {
            relative_to((matrix * engineering).as_slice(), stress.as_slice(), least)
        };
        secant = secant.max(error(delivered));
        tangent = tangent.max(error(&onset_umat::voigt_of_tensor(&full)));
    }
    (secant <= DISTINCTION_RATIO * tangent).then_some(secant)
}

/// Term that the tangent of a small-strain update lacks; `None` if the stress does not depend on the path.
///
/// A stress that is integrated from strain increments depends on the path. The tangent is wrong for a law of the whole deformation.
fn small_strain_update(
    subject: &Subject<'_>,
    identified: &Option<Match>,
    indistinguishable: &[Match],
    measured: &[Measured],
) -> Result<Option<f64>, AuditError> {
    let update = Reading::plain(Convention::LogarithmicStrain);
    let is_update = |found: &Match| found.reading == update;
    if !subject.is_umat() || !identified.iter().chain(indistinguishable).any(is_update) {
        return Ok(None);
    }
    let states: Vec<_> = measured
        .iter()
        .map(|state| state.sample.deformation)
        .collect();
    let others = subject.samples_by_way_of_others(&states)?;
    let mut by_the_way = others.iter().zip(measured);
    let depends = by_the_way
        .any(|(other, state)| state.stress_error(&other.cauchy, &state.sample.cauchy) > TOLERANCE);
    let lacking = measured.iter().map(|state| {
        let full = Convention::JaumannKirchhoff.tangent(&state.change, &state.change.gradient);
        // The missing term is `sigma_ij delta_kl`, with the norm `sqrt(3) |sigma|`.
        3.0_f64.sqrt() * state.sample.cauchy.norm() / onset_umat::voigt_of_tensor(&full).norm()
    });
    Ok(depends.then(|| lacking.fold(0.0, f64::max)))
}
