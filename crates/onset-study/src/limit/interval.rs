//! Intervals of values of a setting in which a condition holds: runs of a grid of values whose ends are refined.

use crate::answers::ProblemError;
use crate::range::middle;
use serde::Serialize;

/// Maximum number of evaluations for the refinement of an end.
const REFINEMENTS: usize = 60;
/// Maximum number of halvings toward values that cannot be evaluated.
const HALVINGS: usize = 12;

/// Kind of an end of an admissible interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum EndKind {
    /// Beyond the end the step is too large, or a state is unstable.
    Limit,
    /// End of the range of values.
    Range,
    /// Values beyond the end cannot be evaluated.
    Undefined,
}

/// End of an interval of admitted values.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct End {
    /// Outermost value of the interval, which is still admitted.
    pub value: f64,
    /// Reason why the interval ends.
    pub kind: EndKind,
    /// Nearest value found that cannot be evaluated; `None` if all values can be evaluated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub undefined_at: Option<f64>,
    /// Reason why the value `undefined_at` cannot be evaluated; `null` without such a value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

/// Interval of admitted values.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Admitted {
    /// Smallest value of the interval.
    pub from: End,
    /// Largest value of the interval.
    pub to: End,
}

/// Result for a value of the setting.
pub(super) trait Trial: Clone {
    /// Relative accuracy of the ends of intervals: their width as a fraction of the larger of the value and the cell of the grid. Smaller margins count as
    /// zero.
    const TOLERANCE: f64;

    fn value(&self) -> f64;

    /// Reason why the value cannot be evaluated; `None` if it can be evaluated.
    fn note(&self) -> Option<&str>;

    /// Nonnegative if the value is admitted; NaN if it cannot be evaluated. The end of an interval is near the zero of its interpolation.
    fn margin(&self) -> f64;

    /// Marks a value between values of the grid.
    fn refined(self) -> Self;

    fn is_refined(&self) -> bool;

    fn is_admitted(&self) -> bool {
        self.margin() >= 0.0
    }
}

/// Refuses a grid without a value that can be evaluated, with the reason at the present value or at the beginning of the range.
pub(super) fn refuse_undefined<T: Trial>(
    grid: &[T],
    key: &'static str,
    present: Option<f64>,
    measured: &dyn Fn(f64) -> Result<T, ProblemError>,
) -> Result<(), ProblemError> {
    let (Some(first), Some(last)) = (grid.first(), grid.last()) else {
        return Ok(());
    };
    if grid.iter().any(|one| one.note().is_none()) {
        return Ok(());
    }
    // If the present value fails too, the reason is another setting and not the range.
    if let Some(present) = present {
        measured(present)?;
    }
    let (low, high) = (first.value(), last.value());
    measured(low)
        .map(|_| ())
        .map_err(|source| ProblemError::Range {
            key,
            low,
            high,
            source: Box::new(source),
        })
}

/// Intervals of admitted values of a grid in increasing order, with refined ends; and all values that were evaluated, in increasing order.
pub(super) fn admitted<T: Trial>(
    grid: Vec<T>,
    trial: &dyn Fn(f64) -> T,
) -> (Vec<Admitted>, Vec<T>) {
    let mut all = grid.clone();
    let admitted = grid
        .chunk_by(|a, b| a.is_admitted() == b.is_admitted())
        .filter(|run| run[0].is_admitted())
        .map(|run| {
            // Neighbors are found by position, because a run is part of the grid.
            let first = grid.partition_point(|one| one.value() < run[0].value());
            let mut end = |own: &T, beyond: Option<&T>| match beyond {
                Some(beyond) => refined(own, beyond, trial, &mut all),
                None => End {
                    value: own.value(),
                    kind: EndKind::Range,
                    undefined_at: None,
                    note: None,
                },
            };
            let before = first.checked_sub(1).map(|n| &grid[n]);
            Admitted {
                from: end(&run[0], before),
                to: end(&run[run.len() - 1], grid.get(first + run.len())),
            }
        })
        .collect();
    all.sort_by(|a, b| a.value().total_cmp(&b.value()));
    (admitted, all)
}

/// Refines the end between an admitted value and a neighbor that is not admitted.
fn refined<T: Trial>(inside: &T, outside: &T, trial: &dyn Fn(f64) -> T, all: &mut Vec<T>) -> End {
    let (mut inside, mut outside) = (inside.clone(), outside.clone());
    // For an end at zero the width is relative to the cell of the grid.
    let cell = (outside.value() - inside.value()).abs();
    for n in 0..REFINEMENTS {
        let width = (outside.value() - inside.value()).abs();
        let size = inside.value().abs().max(outside.value().abs());
        let is_close = width <= T::TOLERANCE * size.max(cell);
        let is_of_domain = outside.note().is_some() && n >= HALVINGS;
        if is_close || is_of_domain || inside.margin() <= T::TOLERANCE {
            break;
        }
        // Two secant steps, then one bisection, so that both ends of the interval move.
        let halved = middle(inside.value(), outside.value());
        let value = match n % 3 {
            2 => halved,
            _ => secant(&inside, &outside).unwrap_or(halved),
        };
        let between = trial(value).refined();
        all.push(between.clone());
        match between.is_admitted() {
            true => inside = between,
            false => outside = between,
        }
    }
    let note = outside.note().map(str::to_owned);
    End {
        value: inside.value(),
        kind: match note {
            Some(_) => EndKind::Undefined,
            None => EndKind::Limit,
        },
        undefined_at: note.as_ref().map(|_| outside.value()),
        note,
    }
}

/// Zero of the margin by linear interpolation between two values, logarithmic if both are positive.
fn secant<T: Trial>(inside: &T, outside: &T) -> Option<f64> {
    let (a, b) = (inside.margin(), outside.margin());
    let (from, to) = (inside.value(), outside.value());
    let share = a / (a - b);
    let value = match from > 0.0 && to > 0.0 {
        true => from * (to / from).powf(share),
        false => from + share * (to - from),
    };
    let is_between = (value - from) * (value - to) < 0.0;
    is_between.then_some(value)
}
