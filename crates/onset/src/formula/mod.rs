//! Strain energies as formulas in text form.
//!
//! [`Formula::parse`] reads a formula and [`Formula::with`] assigns values to its parameters. The result is a law like any other, with exact stress
//! and tangent, and interval enclosures:
//!
//! ```
//! use onset::formula::Formula;
//! use onset::kinematics::DeformationGradient;
//! use onset::material::{BlatzKo, Hyperelastic};
//! let law = Formula::parse("mu/2*(I2/I3 + 2*sqrt(I3) - 5)")?.with(&[("mu", 32.0)])?;
//! let f = DeformationGradient::from_stretches([1.2, 0.9, 1.0])?;
//! let (typed, built_in) = (law.response(&f)?, BlatzKo::default().response(&f)?);
//! assert!((typed.first_piola - built_in.first_piola).amax() < 1e-12 * built_in.first_piola.amax());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The language has numbers, `+ - * / ^`, parentheses, the [`VARIABLES`] and [`FUNCTIONS`], `pi`, helpers (`let a = I1 - 3; mu/2*a + k*a^2`) and
//! conditions (`if(J < 1, ..., ...)`, joined by `and`, `or`, `not`). Any other name is a parameter. The text is compiled once: equal parts are
//! shared, constants are folded, and one list of operations serves floating-point numbers, jets and intervals.

mod contact;
mod domain;
mod error;
mod graph;
mod lexer;
mod one;
mod parser;
mod stretches;
mod tape;
mod words;

pub use crate::material::{Place, StateError, Trouble};
pub use error::{FormulaError, Problem};
pub use one::FunctionOfOne;
pub use words::{FIBER_ANGLES, FUNCTIONS, FunctionWord, VARIABLES, VariableGroup, VariableKind};

use crate::algebra::{Each, array_of};
use crate::kinematics::DeformationGradient;
use crate::material::{LaneStress, MaterialError, StrainEnergy, energy_of_stretches};
use crate::real::{Interval, Jet, Lanes, Real};
use graph::{Graph, Id, Leaf};
use std::ops::Range;
use stretches::StretchTape;
use tape::Tape;

/// Formula that has been read, without values for its parameters.
///
/// ```
/// use onset::formula::Formula;
/// let formula = Formula::parse("let a = I1bar - 3; c10*a + c20*a^2 + k/2*(J - 1)^2")?;
/// assert!(formula.parameters().eq(["c10", "c20", "k"]));
/// assert!(formula.is_isotropic());
/// # Ok::<(), onset::formula::FormulaError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Formula {
    text: String,
    graph: Graph,
    result: usize,
    parameters: Vec<(String, Range<usize>)>,
    variables: Vec<&'static str>,
    helpers: Vec<String>,
}

impl Formula {
    /// Reads a formula in three dimensions.
    ///
    /// # Errors
    /// [`FormulaError`] with the place where the text is not a valid formula.
    pub fn parse(text: &str) -> Result<Self, FormulaError> {
        Self::parse_in(text, 3)
    }

    /// Reads an energy of two dimensions, for a [`Membrane`](crate::material::Membrane).
    ///
    /// `I1` and `I2` are invariants of the 2 x 2 tensor `C`, and `I1bar = I1/J`.
    ///
    /// # Errors
    /// [`FormulaError`] under the conditions of [`Formula::parse`].
    pub fn parse_in_plane(text: &str) -> Result<Self, FormulaError> {
        Self::parse_in(text, 2)
    }

    fn parse_in(text: &str, dimension: usize) -> Result<Self, FormulaError> {
        let parsed = parser::parse(text, dimension)?;
        Ok(Self {
            text: text.to_owned(),
            graph: parsed.graph,
            result: parsed.result,
            parameters: parsed.parameters,
            variables: parsed.variables,
            helpers: parsed.helpers.into_iter().map(|(name, _)| name).collect(),
        })
    }

    /// Text of the formula.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Names that need a value, in the order of their first use. They include the [`FIBER_ANGLES`] of fiber invariants.
    pub fn parameters(&self) -> impl Iterator<Item = &str> {
        self.parameters.iter().map(|(name, _)| name.as_str())
    }

    /// Variables of the formula, in the order of their first use.
    pub fn variables(&self) -> &[&'static str] {
        &self.variables
    }

    /// Returns true if components of `F` are used. Such a law need not be objective.
    pub fn uses_components(&self) -> bool {
        self.uses(VariableKind::Component)
    }

    /// Returns true if all variables are invariant under rotations of space and of the material, so that the law is objective and isotropic.
    pub fn is_isotropic(&self) -> bool {
        !self.uses(VariableKind::Component) && !self.uses(VariableKind::Objective)
    }

    fn uses(&self, kind: VariableKind) -> bool {
        let is_of_kind =
            |name: &&str| words::variable(name).is_some_and(|(group, _)| group.kind == kind);
        self.variables.iter().any(is_of_kind)
    }

    /// Creates the law with values for its parameters.
    ///
    /// # Errors
    /// [`FormulaError`] in these cases:
    ///
    /// - a name has no value, or a value has no name
    /// - a value is not finite
    /// - a part is not a finite number at any state
    /// - the energy does not depend on the deformation
    pub fn with(&self, values: &[(&str, f64)]) -> Result<FormulaLaw, FormulaError> {
        self.check_names(values)?;
        let value = |(name, range): &(String, Range<usize>)| {
            let given = values.iter().find(|(known, _)| known == name);
            given
                .map(|(_, value)| *value)
                .ok_or_else(|| self.error(range.clone(), self.without_value(name, values)))
        };
        let numbers: Vec<f64> = self
            .parameters
            .iter()
            .map(value)
            .collect::<Result<_, _>>()?;
        let (graph, result) = self.graph.with_parameters(self.result, &numbers);
        let needed = graph.needed_by(result);
        for id in (0..graph.len()).filter(|id| needed[*id]) {
            if let Some(value) = graph.value(id)
                && !value.is_finite()
            {
                let range = graph.range_of(id);
                return Err(self.error(range, Problem::ConstantNotFinite { value }));
            }
        }
        if graph.value(result).is_some() {
            return Err(self.error(0..self.text.len(), Problem::Constant));
        }
        self.law(graph, result)
    }

    /// Separates the terms in principal stretches from all other terms.
    fn law(&self, mut graph: Graph, result: Id) -> Result<FormulaLaw, FormulaError> {
        let is_stretch = |leaf: Leaf| matches!(leaf, Leaf::Stretch(_));
        if !graph.leaves_of(result).any(is_stretch) {
            return Ok(FormulaLaw {
                text: self.text.clone(),
                stretches: None,
                rest: Some(Tape::new(&graph, result)),
            });
        }
        let [stretches, rest] = graph.split(result, is_stretch);
        let stretches = stretches
            .map(|id| StretchTape::new(&graph, id))
            .transpose()
            .map_err(|(range, problem)| self.error(range, problem))?;
        let rest = rest.map(|id| Tape::new(&graph, id));
        Ok(FormulaLaw {
            text: self.text.clone(),
            stretches,
            rest,
        })
    }

    /// Checks that every value is finite and belongs to a parameter.
    fn check_names(&self, values: &[(&str, f64)]) -> Result<(), FormulaError> {
        for (name, value) in values {
            let problem = if self.parameters().any(|known| known == *name) {
                if value.is_finite() {
                    continue;
                }
                Problem::ParameterNotFinite {
                    name: (*name).to_owned(),
                    value: *value,
                }
            } else {
                self.not_a_parameter(name)
            };
            return Err(FormulaError {
                problem,
                place: None,
            });
        }
        Ok(())
    }

    fn not_a_parameter(&self, name: &str) -> Problem {
        let is_helper = self.helpers.iter().any(|helper| helper == name);
        let what = if is_helper {
            Some("a helper of the formula")
        } else {
            words::meaning(name)
        };
        let name = name.to_owned();
        match what {
            Some(what) => Problem::NotAParameter { name, what },
            None => Problem::UnusedParameter {
                name,
                parameters: self.parameters().map(str::to_owned).collect(),
            },
        }
    }

    fn without_value(&self, name: &str, values: &[(&str, f64)]) -> Problem {
        if let Some(angle) = FIBER_ANGLES.into_iter().find(|angle| *angle == name) {
            return Problem::NoFiberAngle { angle };
        }
        let variables = VARIABLES
            .iter()
            .flat_map(|group| group.names.iter().copied());
        let given = values.iter().map(|(name, _)| *name);
        let helpers = self.helpers.iter().map(String::as_str);
        let known = variables.chain(helpers).chain(given).chain([words::PI]);
        Problem::UnknownName {
            name: name.to_owned(),
            meant: words::nearest(name, known).map(str::to_owned),
        }
    }

    fn error(&self, range: Range<usize>, problem: Problem) -> FormulaError {
        FormulaError {
            problem,
            place: Some(Place::of(&self.text, range)),
        }
    }
}

/// Law given by a formula with numbers for its parameters, created by [`Formula::with`]. Units follow from the formula.
#[derive(Clone, Debug, PartialEq)]
pub struct FormulaLaw {
    /// Text of the formula.
    text: String,
    /// Terms in the principal stretches.
    stretches: Option<StretchTape>,
    /// Terms without principal stretches.
    rest: Option<Tape>,
}

/// Value of a leaf at a deformation gradient, for terms without principal stretches.
fn leaf<R: Real>(f: &DeformationGradient<R>, leaf: Leaf) -> R {
    let components = f.components();
    match leaf {
        Leaf::Component(i, j) => components[i][j],
        Leaf::CauchyGreen(i, j) => {
            let product = |k: usize| components[k][i] * components[k][j];
            product(0) + product(1) + product(2)
        }
        Leaf::Jacobian => f.determinant(),
        // Terms with stretches are in the other tape, and an energy has no argument.
        Leaf::Stretch(_) | Leaf::Argument => R::constant(f64::NAN),
    }
}

impl FormulaLaw {
    /// Terms without stretches, unless their stress is continuous at every admissible state.
    fn delicate(&self) -> Option<&Tape> {
        self.rest.as_ref().filter(|tape| !tape.is_plain())
    }
}

impl StrainEnergy for FormulaLaw {
    fn energy<R: Real>(&self, f: &DeformationGradient<R>) -> R {
        let rest = |tape: &Tape| tape.evaluate(|part| leaf(f, part));
        match (&self.stretches, &self.rest) {
            (None, None) => R::constant(0.0),
            (None, Some(tape)) => rest(tape),
            (Some(stretches), None) => energy_of_stretches(stretches, f),
            (Some(stretches), Some(tape)) => energy_of_stretches(stretches, f) + rest(tape),
        }
    }

    fn admits(&self, f: &DeformationGradient) -> Result<(), MaterialError> {
        let components = f.components().each(|row| row.map(Interval::point));
        let of_stretches = || {
            let stretches = f.principal_stretches().each(|x| Interval::around(x, 8));
            self.stretches.as_ref()?.trouble(stretches)
        };
        let of_rest = || {
            let exact = DeformationGradient::from_components(components);
            let variables = Jet::variables(array_of(|n| components[n / 3][n % 3]));
            let jets = DeformationGradient::from_components(array_of(|i| {
                array_of(|j| variables[3 * i + j])
            }));
            domain::trouble(
                self.delicate()?,
                |part| leaf(&exact, part),
                |part| leaf(&jets, part),
            )
        };
        match of_stretches().or_else(of_rest) {
            Some((trouble, range)) => Err(StateError {
                trouble,
                place: Place::of(&self.text, range),
            }
            .into()),
            None => Ok(()),
        }
    }

    fn lane_stress(&self, states: &DeformationGradient<Lanes>, dimension: usize) -> LaneStress {
        match self.stretches {
            Some(_) => LaneStress::one_by_one(self, states, dimension),
            None => LaneStress::of_components(self, states, dimension),
        }
    }

    fn is_smooth(&self, f: &DeformationGradient<Interval>) -> bool {
        let is_smooth = |tape: &Tape| domain::is_smooth(tape, |part| leaf(f, part));
        self.delicate().is_none_or(is_smooth)
    }
}
