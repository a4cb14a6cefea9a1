//! Formula of one variable, such as a radial profile.

use super::Place;
use super::error::{FormulaError, Problem};
use super::graph::{Leaf, Node};
use super::parser;
use super::tape::Tape;
use crate::real::Real;

/// Formula with a single variable. Only this variable, functions and helpers may occur in it.
///
/// ```
/// use onset::formula::FunctionOfOne;
/// use onset::real::Jet;
/// let bump = FunctionOfOne::parse("let p = 1 - q; p^3*(1 + 3*q)", "q")?;
/// assert_eq!(bump.at(0.5), 0.3125);
/// let [q] = Jet::variables([0.5]);
/// assert_eq!(bump.at(q).gradient, [-1.5]);
/// # Ok::<(), onset::formula::FormulaError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct FunctionOfOne {
    tape: Tape,
    has_branch: bool,
}

impl FunctionOfOne {
    /// Reads a formula with the given name of the variable.
    ///
    /// # Errors
    /// [`FormulaError`] if the text is not a valid formula, uses another name, or contains a part that is never finite.
    pub fn parse(text: &str, variable: &'static str) -> Result<Self, FormulaError> {
        let parsed = parser::parse(text, 3)?;
        let error = |range, problem| FormulaError {
            problem,
            place: Some(Place::of(text, range)),
        };
        let stranger = |name: &str| Problem::NotTheVariable {
            name: name.to_owned(),
            variable,
        };
        if let Some(name) = parsed.variables.first() {
            let at = text.find(name).unwrap_or(0);
            return Err(error(at..at + name.len(), stranger(name)));
        }
        let other = |(name, _): &&(String, _)| name != variable;
        if let Some((name, range)) = parsed.parameters.iter().find(other) {
            return Err(error(range.clone(), stranger(name)));
        }
        let (graph, result) = parsed.graph.of_argument(parsed.result);
        let needed = graph.needed_by(result);
        let mut has_branch = false;
        for id in (0..graph.len()).filter(|id| needed[*id]) {
            has_branch |= matches!(graph.nodes()[id], Node::Select(..));
            if let Some(value) = graph.value(id)
                && !value.is_finite()
            {
                return Err(error(
                    graph.range_of(id),
                    Problem::ConstantNotFinite { value },
                ));
            }
        }
        Ok(Self {
            tape: Tape::new(&graph, result),
            has_branch,
        })
    }

    /// Value at a value of the variable.
    pub fn at<R: Real>(&self, x: R) -> R {
        self.tape.evaluate(|leaf| match leaf {
            Leaf::Argument => x,
            // No other variable is admitted.
            Leaf::Component(..) | Leaf::CauchyGreen(..) | Leaf::Jacobian | Leaf::Stretch(_) => {
                R::constant(f64::NAN)
            }
        })
    }

    /// Returns true if the formula contains a condition, a ramp or an extreme, where derivatives can jump.
    pub fn has_branch(&self) -> bool {
        self.has_branch
    }
}
