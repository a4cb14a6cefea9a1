//! What is wrong with a formula, and where in it.

use super::words;
use std::ops::Range;
use thiserror::Error;

/// A place within a formula, with the line that it stands in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// Line within the formula, counted from 1.
    pub line: usize,
    /// Column within the line in characters, counted from 1.
    pub column: usize,
    /// Number of characters pointed at, at least 1.
    pub length: usize,
    /// Whether the formula has several lines.
    pub is_one_of_several_lines: bool,
    /// The line, or the part of a long one around the place.
    excerpt: String,
    /// Characters of the excerpt before the place.
    before: usize,
}

/// Characters of a long line that are shown on either side of a place.
const MARGIN: usize = 60;

impl Place {
    /// The place of a range of bytes.
    pub(super) fn of(text: &str, range: Range<usize>) -> Self {
        let (start, end) = (range.start, range.end);
        let line_start = text[..start].rfind('\n').map_or(0, |at| at + 1);
        let line_end = text[start..].find('\n').map_or(text.len(), |at| start + at);
        let characters: Vec<char> = text[line_start..line_end].chars().collect();
        let column = text[line_start..start].chars().count();
        let length = text[start..end.min(line_end)].chars().count().max(1);
        let first = column.saturating_sub(MARGIN);
        let last = characters.len().min(column + MARGIN);
        let shown = characters[first..last].iter();
        // Tabs and escape sequences would misplace the caret, or worse.
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

    /// The line of the formula with a caret under the place; two lines.
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

/// Why a formula that could be taken has no stress at a state.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum Trouble {
    /// A part that is needed is not defined there: the root of a negative number, a division by zero.
    #[error("is not defined")]
    Undefined,
    /// Two sides of a condition meet with different energies.
    #[error("jumps")]
    Jump,
    /// Two sides of a condition, a ramp or an extreme meet with different stresses.
    #[error("has a kink")]
    Kink,
}

/// A formula without a stress at a state: why, and by which part of it. Rounding is counted: a state that may be one of these is one.
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
    /// Why.
    pub trouble: Trouble,
    /// The part.
    pub place: Place,
}

impl std::error::Error for StateError {}

impl std::fmt::Display for StateError {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (why, hint) = match self.trouble {
            Trouble::Undefined => (
                "",
                "roots, logarithms and real powers need positive numbers, quotients a divisor that is not zero; only a side that \
                 if(condition, value, otherwise) does not take may be undefined",
            ),
            Trouble::Jump => (
                ": the energies of its two sides differ",
                "there is no stress; ask for a state beside this one",
            ),
            Trouble::Kink => (
                ": the stresses of its two sides differ",
                "there is no tangent, and a layering of both sides can have less energy; ask for a state beside this one",
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

/// A formula that cannot be taken: what is wrong, where, and what to do.
///
/// ```
/// use onset::formula::Formula;
/// let error = Formula::parse("mu*(I1 - 3").expect_err("not closed");
/// assert_eq!(error.place.as_ref().map(|place| place.column), Some(4));
/// assert!(error.to_string().contains("mu*(I1 - 3\n       ^"));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct FormulaError {
    /// What is wrong.
    pub problem: Problem,
    /// Where; `None` when it is about a parameter that the formula does not mention.
    pub place: Option<Place>,
}

impl std::error::Error for FormulaError {}

impl std::fmt::Display for FormulaError {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.place {
            Some(place) => write!(
                formatter,
                "energy, {place}: {}\n{}",
                self.problem,
                place.marked()
            )?,
            None => write!(formatter, "{}", self.problem)?,
        }
        match self.problem.hint() {
            Some(hint) => write!(formatter, "\n  hint: {hint}"),
            None => Ok(()),
        }
    }
}

/// What can be wrong with a formula.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Problem {
    /// There is nothing.
    #[error("the formula is empty")]
    Empty,
    /// The text is too long.
    #[error("the formula has {characters} characters; admitted are {limit}")]
    TooLong {
        /// How long it is.
        characters: usize,
        /// How long it may be.
        limit: usize,
    },
    /// Too many parentheses, signs, powers or calls within each other.
    #[error("more than {limit} levels of parentheses, calls, signs or powers within each other")]
    TooDeep {
        /// How many there may be.
        limit: usize,
    },
    /// Too many different operations.
    #[error("the formula needs more than {limit} operations")]
    TooManyOperations {
        /// How many there may be.
        limit: usize,
    },
    /// A character that has no meaning in a formula.
    #[error("`{}` has no meaning in a formula", .character.escape_debug())]
    Character {
        /// The character.
        character: char,
    },
    /// A number that cannot be read.
    #[error("`{text}` is not a number")]
    Number {
        /// As typed.
        text: String,
    },
    /// Something else was expected.
    #[error("expected {expected}, found {found}")]
    Expected {
        /// What would do.
        expected: &'static str,
        /// What is there.
        found: String,
        /// What to do.
        hint: Option<&'static str>,
    },
    /// A parenthesis without its partner.
    #[error("this parenthesis is not closed")]
    NotClosed,
    /// A function that does not exist.
    #[error("there is no function `{name}`")]
    UnknownFunction {
        /// As typed.
        name: String,
        /// The function that may be meant.
        meant: Option<&'static str>,
    },
    /// Parentheses after a name that is no function.
    #[error("`{name}` is {what}, not a function")]
    NotAFunction {
        /// The name.
        name: String,
        /// What it is.
        what: &'static str,
    },
    /// A function without arguments.
    #[error("`{function}` is a function and takes {expected} in parentheses")]
    NoArguments {
        /// The function.
        function: &'static str,
        /// What it takes.
        expected: &'static str,
    },
    /// Too few or too many arguments.
    #[error("`{function}` takes {expected}, here are {found}")]
    Arguments {
        /// The function.
        function: &'static str,
        /// What it takes.
        expected: &'static str,
        /// How many were given.
        found: usize,
    },
    /// A condition where a number is needed.
    #[error("a condition stands where a number is needed")]
    ConditionAsNumber,
    /// A number where a condition is needed.
    #[error("a number stands where a condition is needed")]
    NumberAsCondition,
    /// Comparisons in a row.
    #[error("a comparison of a comparison")]
    ChainedComparison,
    /// The name of a helper is in use.
    #[error("`{name}` is already {what}")]
    Taken {
        /// The name.
        name: String,
        /// What it is.
        what: &'static str,
    },
    /// A name that is neither known nor given a value.
    #[error("`{name}` has no value")]
    UnknownName {
        /// As typed.
        name: String,
        /// A known name that may be meant.
        meant: Option<String>,
    },
    /// Another name than that of the one variable.
    #[error("`{name}` has no meaning here; the variable is `{variable}`")]
    NotTheVariable {
        /// As typed.
        name: String,
        /// The variable.
        variable: &'static str,
    },
    /// A fiber invariant without the direction of its fibers.
    #[error("the direction of the fibers is not set: `{angle}` has no value")]
    NoFiberAngle {
        /// The parameter that gives it.
        angle: &'static str,
    },
    /// A value for a name that the formula does not use.
    #[error("the formula has no parameter `{name}`")]
    UnusedParameter {
        /// The name.
        name: String,
        /// The parameters that the formula has.
        parameters: Vec<String>,
    },
    /// A value for a name with a meaning of its own.
    #[error("`{name}` is {what} and takes no value")]
    NotAParameter {
        /// The name.
        name: String,
        /// What it is.
        what: &'static str,
    },
    /// A parameter that is infinite or not a number.
    #[error("parameter {name} is {value:?}; expected a finite number")]
    ParameterNotFinite {
        /// The name.
        name: String,
        /// Its value.
        value: f64,
    },
    /// A part without variables that is not a finite number.
    #[error("this is {value:?} at every state, not a finite number")]
    ConstantNotFinite {
        /// Its value.
        value: f64,
    },
    /// The formula does not depend on the deformation.
    #[error("the energy does not depend on the deformation")]
    Constant,
    /// The value changes when principal stretches are exchanged, whose order means nothing.
    #[error(
        "the formula is not symmetric in the principal stretches: {value} at {stretches:?}, {exchanged} in another order"
    )]
    NotSymmetric {
        /// Three stretches.
        stretches: [f64; 3],
        /// The value for them.
        value: f64,
        /// The value for the same in another order.
        exchanged: f64,
    },
    /// Principal stretches together with what is not a function of them.
    #[error("principal stretches are multiplied with invariants or components")]
    StretchesMixed,
    /// Principal stretches in a term with a condition.
    #[error("principal stretches stand in a term with a condition, a ramp or an extreme")]
    StretchesBranch,
}

impl Problem {
    /// What to do about it.
    pub fn hint(&self) -> Option<String> {
        let fixed = |text: &str| Some(text.to_owned());
        match self {
            Self::Empty => fixed("for example mu/2*(I2/I3 + 2*sqrt(I3) - 5)"),
            Self::TooLong { .. } | Self::TooManyOperations { .. } | Self::TooDeep { .. } => {
                fixed("name parts that occur again: let a = ...; let b = ...; a*b")
            }
            Self::Character { character } => fixed(words::instead_of(*character)),
            Self::Number { text } if text.contains(|c: char| c.is_ascii_alphabetic()) => {
                fixed("write products with `*`: 2*mu; exponents as in 1.5e-3")
            }
            Self::Number { .. } => fixed("numbers are written 2, 0.5, 1.5e-3"),
            Self::Expected { hint, .. } => hint.map(str::to_owned),
            Self::NotClosed => fixed("add the missing `)`"),
            Self::UnknownFunction { name, meant } => Some(match (words::advice(name), meant) {
                (Some(advice), _) => advice.to_owned(),
                (None, Some(meant)) => format!("did you mean `{meant}`? Products need a `*`"),
                (None, None) => format!(
                    "products need a `*`; functions are {}",
                    words::function_names().collect::<Vec<_>>().join(", ")
                ),
            }),
            Self::NotAFunction { name, .. } => Some(format!("products need a `*`: {name}*(...)")),
            Self::NoArguments { function, .. } => Some(format!("write {function}(...)")),
            Self::Arguments { .. } => {
                fixed("arguments are separated by commas, decimals by points")
            }
            Self::ConditionAsNumber => {
                fixed("conditions stand first in if(condition, value, otherwise)")
            }
            Self::NumberAsCondition => fixed("compare with <, <=, > or >=: if(J < 1, a, b)"),
            Self::ChainedComparison => fixed("write a < b and b < c"),
            Self::Taken { .. } => fixed("choose another name for the helper"),
            Self::UnknownName { name, meant } => Some(match (words::advice(name), meant) {
                (Some(advice), _) => advice.to_owned(),
                (None, Some(meant)) => {
                    format!("did you mean `{meant}`? Or give the parameter a value: {name} = ...")
                }
                (None, None) => format!(
                    "give the parameter a value: {name} = ...; variables are {}",
                    words::variable_names()
                ),
            }),
            Self::NotTheVariable { .. } => fixed("write numbers in place of other names"),
            Self::NoFiberAngle { angle } => Some(format!(
                "set {angle}, in degrees from the first axis within the plane"
            )),
            Self::UnusedParameter { parameters, .. } if parameters.is_empty() => {
                fixed("the formula has no parameters")
            }
            Self::UnusedParameter { name, parameters } => {
                let known = parameters.iter().map(String::as_str);
                let meant = words::nearest(name, known)
                    .map_or(String::new(), |meant| format!("; did you mean `{meant}`?"));
                Some(format!(
                    "its parameters are {}{meant}",
                    parameters.join(", ")
                ))
            }
            Self::NotAParameter { .. } => fixed("choose another name for the parameter"),
            Self::ParameterNotFinite { .. } => None,
            Self::ConstantNotFinite { .. } => {
                fixed("a division by zero, a logarithm or a root of a negative number?")
            }
            Self::Constant => Some(format!("variables are {}", words::variable_names())),
            Self::NotSymmetric { .. } => {
                fixed("write all three alike: lambda1^a + lambda2^a + lambda3^a")
            }
            Self::StretchesMixed => fixed(
                "within a product write I1 as lambda1^2 + lambda2^2 + lambda3^2; J can be used as it is",
            ),
            Self::StretchesBranch => {
                fixed("write the condition, in invariants, into a term of its own")
            }
        }
    }
}
