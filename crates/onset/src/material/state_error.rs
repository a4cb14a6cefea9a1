//! States at which a law given as a formula has no stress, with the position in its text.

use std::ops::Range;
use thiserror::Error;

/// Position within a formula, with the line of text around it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// Line within the formula, counted from 1.
    pub line: usize,
    /// Column within the line in characters, counted from 1.
    pub column: usize,
    /// Number of marked characters, at least 1.
    pub length: usize,
    /// Whether the formula has several lines.
    pub is_one_of_several_lines: bool,
    /// Line around the position, shortened if it is long.
    excerpt: String,
    /// Number of characters of the excerpt before the position.
    before: usize,
}

/// Number of characters of a long line that are shown on either side of a position.
const MARGIN: usize = 60;

impl Place {
    /// Computes the position of a range of bytes.
    pub(crate) fn of(text: &str, range: Range<usize>) -> Self {
        let (start, end) = (range.start, range.end);
        let line_start = text[..start].rfind('\n').map_or(0, |at| at + 1);
        let line_end = text[start..].find('\n').map_or(text.len(), |at| start + at);
        let characters: Vec<char> = text[line_start..line_end].chars().collect();
        let column = text[line_start..start].chars().count();
        let length = text[start..end.min(line_end)].chars().count().max(1);
        let first = column.saturating_sub(MARGIN);
        let last = characters.len().min(column + MARGIN);
        let shown = characters[first..last].iter();
        // Tabs would misplace the caret, and escape sequences would reach the terminal.
        let plain = |c: &char| if c.is_control() { ' ' } else { *c };
        let dots = |is_cut: bool| if is_cut { "..." } else { "" };
        Self {
            line: text[..start].matches('\n').count() + 1,
            column: column + 1,
            length: length.min(last.saturating_sub(column).max(1)),
            is_one_of_several_lines: text.trim().contains('\n'),
            excerpt: format!(
                "{}{}{}",
                dots(first > 0),
                shown.map(plain).collect::<String>(),
                dots(last < characters.len())
            ),
            before: column - first + dots(first > 0).len(),
        }
    }

    /// Returns the line of the formula with a caret under the position, as two lines of text.
    pub fn marked(&self) -> String {
        format!(
            "    {}\n    {}{}",
            self.excerpt,
            " ".repeat(self.before),
            "^".repeat(self.length)
        )
    }
}

impl std::fmt::Display for Place {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.is_one_of_several_lines {
            write!(formatter, "line {}, ", self.line)?;
        }
        write!(formatter, "column {}", self.column)
    }
}

/// Reason why a valid formula has no stress at a state.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum Trouble {
    /// A required part is undefined, for example the root of a negative number or a division by zero.
    #[error("is not defined")]
    Undefined,
    /// The energies on the two sides of a condition differ.
    #[error("jumps")]
    Jump,
    /// The stresses on the two sides of a condition, a ramp or an extreme differ.
    #[error("has a kink")]
    Kink,
}

/// Error of a formula without a stress at a state, with the part that causes it.
///
/// Rounding is included: a state that may lack a stress is reported.
///
/// ```
/// use onset::formula::{Formula, Trouble};
/// use onset::kinematics::DeformationGradient;
/// use onset::material::{Hyperelastic, MaterialError};
/// let law = Formula::parse("I1 - 2*ln(J) - abs(J - 1)")?.with(&[])?;
/// let f = DeformationGradient::from_stretches([2.0, 0.5, 1.0])?;
/// let Err(MaterialError::Formula(error)) = law.response(&f) else { panic!("not differentiable") };
/// assert_eq!((error.trouble, error.place.column), (Trouble::Kink, 16));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct StateError {
    /// Reason for the failure.
    pub trouble: Trouble,
    /// Part of the formula that causes the error.
    pub place: Place,
}

impl std::error::Error for StateError {}

impl std::fmt::Display for StateError {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (why, hint) = match self.trouble {
            Trouble::Undefined => (
                "",
                "roots, logarithms and real powers need positive numbers, quotients a nonzero divisor; only a side that \
                 if(condition, value, otherwise) does not select may be undefined",
            ),
            Trouble::Jump => (
                ": the energies of its two sides differ",
                "there is no stress; choose a nearby state",
            ),
            Trouble::Kink => (
                ": the stresses of its two sides differ",
                "there is no tangent, and a laminate of states on both sides can have less energy; choose a nearby state",
            ),
        };
        write!(
            formatter,
            "energy, {}: to rounding, this {} at this deformation{why}\n{}\n  hint: {hint}",
            self.place,
            self.trouble,
            self.place.marked(),
        )
    }
}
