//! Errors of user-defined formulas, with their positions in the text.

use super::words;
use crate::material::Place;
use crate::real::plain;
use thiserror::Error;

/// Error of an invalid formula: the problem, its position, and a hint.
///
/// ```
/// use onset::formula::Formula;
/// let error = Formula::parse("mu*(I1 - 3").expect_err("not closed");
/// assert_eq!(error.place.as_ref().map(|place| place.column), Some(4));
/// assert!(error.to_string().contains("mu*(I1 - 3\n       ^"));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct FormulaError {
    /// Problem with the formula.
    pub problem: Problem,
    /// Position of the problem; `None` for a parameter that the formula does not contain.
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

/// Problem with a formula.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Problem {
    /// The formula is empty.
    #[error("the formula is empty")]
    Empty,
    /// The text is too long.
    #[error("the formula has {characters} characters; at most {limit} are allowed")]
    TooLong {
        /// Length of the text in characters.
        characters: usize,
        /// Largest admissible length in characters.
        limit: usize,
    },
    /// Parentheses, signs, powers or calls are nested too deeply.
    #[error("more than {limit} levels of nested parentheses, calls, signs or powers")]
    TooDeep {
        /// Largest admissible depth of nesting.
        limit: usize,
    },
    /// The formula has too many distinct operations.
    #[error("the formula needs more than {limit} operations")]
    TooManyOperations {
        /// Largest admissible number of operations.
        limit: usize,
    },
    /// A character has no meaning in a formula.
    #[error("`{}` has no meaning in a formula", .character.escape_debug())]
    Character {
        /// Character without a meaning.
        character: char,
    },
    /// A number cannot be read.
    #[error("`{text}` is not a number")]
    Number {
        /// Text of the number.
        text: String,
    },
    /// A different token was expected.
    #[error("expected {expected}, found {found}")]
    Expected {
        /// Tokens that are valid here.
        expected: &'static str,
        /// Token that was found.
        found: String,
        /// Hint to the user.
        hint: Option<&'static str>,
    },
    /// A parenthesis is not closed or not opened.
    #[error("this parenthesis is not closed")]
    NotClosed,
    /// A function does not exist.
    #[error("there is no function `{name}`")]
    UnknownFunction {
        /// Name in the text.
        name: String,
        /// Function with a similar name.
        meant: Option<&'static str>,
    },
    /// A name that is not a function is followed by parentheses.
    #[error("`{name}` is {what}, not a function")]
    NotAFunction {
        /// Name in the text.
        name: String,
        /// Description of the meaning of the name.
        what: &'static str,
    },
    /// A function has no arguments.
    #[error("`{function}` is a function and takes {expected} in parentheses")]
    NoArguments {
        /// Name of the function.
        function: &'static str,
        /// Arguments that the function takes.
        expected: &'static str,
    },
    /// A function has too few or too many arguments.
    #[error("`{function}` takes {expected}, here are {found}")]
    Arguments {
        /// Name of the function.
        function: &'static str,
        /// Arguments that the function takes.
        expected: &'static str,
        /// Number of arguments given.
        found: usize,
    },
    /// A condition appears where a number is needed.
    #[error("there is a condition where a number is needed")]
    ConditionAsNumber,
    /// A number appears where a condition is needed.
    #[error("there is a number where a condition is needed")]
    NumberAsCondition,
    /// Comparisons are chained, as in `a < b < c`.
    #[error("a comparison of a comparison")]
    ChainedComparison,
    /// A helper has a name that is already in use.
    #[error("`{name}` is already {what}")]
    Taken {
        /// Name of the helper.
        name: String,
        /// Existing meaning of the name.
        what: &'static str,
    },
    /// A name is neither known nor assigned a value.
    #[error("`{name}` has no value")]
    UnknownName {
        /// Name in the text.
        name: String,
        /// Known name that is similar.
        meant: Option<String>,
    },
    /// A name differs from the name of the single variable.
    #[error("`{name}` has no meaning here; the variable is `{variable}`")]
    NotTheVariable {
        /// Name in the text.
        name: String,
        /// Name of the single variable.
        variable: &'static str,
    },
    /// A fiber invariant is used without the direction of its fibers.
    #[error("the direction of the fibers is not set: `{angle}` has no value")]
    NoFiberAngle {
        /// Parameter for the fiber direction.
        angle: &'static str,
    },
    /// A value is given for a name that the formula does not use.
    #[error("the formula has no parameter `{name}`")]
    UnusedParameter {
        /// Name of the unused parameter.
        name: String,
        /// Parameters of the formula.
        parameters: Vec<String>,
    },
    /// A value is given for a name with a fixed meaning.
    #[error("`{name}` is {what} and takes no value")]
    NotAParameter {
        /// Name in the list of values.
        name: String,
        /// Fixed meaning of the name.
        what: &'static str,
    },
    /// A parameter is infinite or not a number.
    #[error("parameter {name} is {}; expected a finite number", plain(*value))]
    ParameterNotFinite {
        /// Name of the parameter.
        name: String,
        /// Value of the parameter.
        value: f64,
    },
    /// A part without variables is not a finite number.
    #[error("this is {} at every state, not a finite number", plain(*value))]
    ConstantNotFinite {
        /// Value of the part.
        value: f64,
    },
    /// The formula does not depend on the deformation.
    #[error("the energy does not depend on the deformation")]
    Constant,
    /// The value changes when principal stretches are exchanged, although their order has no meaning.
    #[error(
        "the formula is not symmetric in the principal stretches: {value} at {stretches:?}, {exchanged} in another order"
    )]
    NotSymmetric {
        /// Principal stretches of the test.
        stretches: [f64; 3],
        /// Energy at these stretches.
        value: f64,
        /// Energy at these stretches in another order.
        exchanged: f64,
    },
    /// Principal stretches are combined with variables that are not functions of them.
    #[error("principal stretches are multiplied with invariants or components")]
    StretchesMixed,
    /// Principal stretches appear in a term with a condition.
    #[error("principal stretches appear in a term with a condition, a ramp or an extreme")]
    StretchesBranch,
}

impl Problem {
    /// Returns a hint to the user, if available.
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
                fixed("a condition is the first argument of if(condition, value, otherwise)")
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
                fixed("write the condition, in invariants, as a separate term")
            }
        }
    }
}
