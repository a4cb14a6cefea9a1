//! Parser of formulas: operator precedence, helpers and conditions. Operations are added directly to a [`Graph`].
//!
//! From the weakest to the strongest: `or`, `and`, `not`, comparisons, `+ -`, `* /`, signs, `^`. Powers associate to the right, all other operators
//! to the left; `-x^2` is `-(x^2)`, and `2^-x` is allowed.

use super::Place;
use super::error::{FormulaError, Problem};
use super::graph::{Function, Graph, Id, Leaf};
use super::lexer::{Token, tokens};
use super::words::{self, Arity, FIBER_ANGLES, FunctionWord};
use crate::algebra::Each;
use std::ops::Range;

/// Largest number of characters of a formula.
pub(super) const LONGEST: usize = 20_000;

/// Largest nesting depth of parentheses, calls, signs and powers.
pub(super) const MAX_DEPTH: usize = 100;

/// Largest number of operations of a formula.
pub(super) const MAX_OPERATIONS: usize = 5_000;

/// Binding strength of operators.
const OR: u8 = 1;
const AND: u8 = 2;
const NOT: u8 = 3;
const COMPARISON: u8 = 4;
const SUM: u8 = 5;
const PRODUCT: u8 = 6;
const SIGN: u8 = 7;
const POWER: u8 = 8;

/// Formula in parsed form.
pub(super) struct Parsed {
    pub(super) graph: Graph,
    pub(super) result: Id,
    /// Parameters with the position of their first use, by their index in the graph.
    pub(super) parameters: Vec<(String, Range<usize>)>,
    /// Variables of the formula.
    pub(super) variables: Vec<&'static str>,
    /// Helpers with their names.
    pub(super) helpers: Vec<(String, Id)>,
}

/// Parses a formula, with invariants in three or two dimensions.
pub(super) fn parse(text: &str, dimension: usize) -> Result<Parsed, FormulaError> {
    let characters = text.chars().count();
    if characters > LONGEST {
        return Err(FormulaError {
            problem: Problem::TooLong {
                characters,
                limit: LONGEST,
            },
            place: None,
        });
    }
    if text.trim().is_empty() {
        return Err(FormulaError {
            problem: Problem::Empty,
            place: None,
        });
    }
    let mut parser = Parser {
        text,
        dimension,
        tokens: tokens(text)?,
        next: 0,
        depth: 0,
        graph: Graph::default(),
        parameters: Vec::new(),
        variables: Vec::new(),
        helpers: Vec::new(),
    };
    let result = parser.formula()?;
    Ok(Parsed {
        graph: parser.graph,
        result,
        parameters: parser.parameters,
        variables: parser.variables,
        helpers: parser.helpers,
    })
}

/// A number, or a condition.
#[derive(Clone, Copy)]
enum Value {
    Number(Id),
    /// Condition that holds where the node is negative; with `false`, where it is not negative.
    Comparison(Id, bool),
    /// Condition that holds where the node is one; the node is zero elsewhere.
    Indicator(Id),
}

/// Value with its range of bytes.
type Ranged = (Value, Range<usize>);

struct Parser<'a> {
    text: &'a str,
    /// Dimension of the tensors whose invariants are used.
    dimension: usize,
    tokens: Vec<(Token<'a>, Range<usize>)>,
    next: usize,
    depth: usize,
    graph: Graph,
    parameters: Vec<(String, Range<usize>)>,
    variables: Vec<&'static str>,
    helpers: Vec<(String, Id)>,
}

impl<'a> Parser<'a> {
    fn token(&self) -> Token<'a> {
        self.tokens[self.next].0
    }

    fn range(&self) -> Range<usize> {
        self.tokens[self.next].1.clone()
    }

    fn advance(&mut self) {
        self.next = (self.next + 1).min(self.tokens.len() - 1);
    }

    /// Consumes a symbol if it is the next token.
    fn takes(&mut self, sign: &str) -> bool {
        let is_next = matches!(self.token(), Token::Sign(next) if next == sign);
        if is_next {
            self.advance();
        }
        is_next
    }

    fn error(&self, range: Range<usize>, problem: Problem) -> FormulaError {
        FormulaError {
            problem,
            place: Some(Place::of(self.text, range)),
        }
    }

    /// Error for an unexpected token.
    fn expected(&self, expected: &'static str) -> FormulaError {
        let (token, range) = (self.token(), self.range());
        let hint = match token {
            Token::Sign("**") => Some("write powers with ^"),
            Token::Sign("==" | "!=") => {
                Some("an equality holds on no open set of states; compare with <, <=, > or >=")
            }
            Token::Sign("=") => {
                Some("name a part with let name = ...; compare with <, <=, > or >=")
            }
            Token::Sign("&&") => Some("write and"),
            Token::Sign("||") => {
                Some("write `or` for alternatives, abs(...) for an absolute value")
            }
            Token::Sign(",") => {
                Some("arguments belong in the parentheses of a function; decimals use a point")
            }
            Token::Sign(")") => Some("remove it, or open it earlier"),
            Token::Sign("(") => Some("products need a `*`"),
            Token::Number(_) => Some("products need a `*`"),
            Token::Name("let") => {
                Some("helpers come first and end with a semicolon: let a = ...; let b = ...; a*b")
            }
            Token::Name(_) => Some("products need a `*`"),
            _ => None,
        };
        let found = token.found(&self.text[range.clone()]);
        self.error(
            range,
            Problem::Expected {
                expected,
                found,
                hint,
            },
        )
    }

    /// Parses a whole formula, `let name = value; ... value`.
    fn formula(&mut self) -> Result<Id, FormulaError> {
        while self.token() == Token::Name("let") {
            self.advance();
            self.helper()?;
        }
        let result = self.number()?;
        if self.token() == Token::Sign(";") {
            self.advance();
            return match self.token() {
                Token::End => Ok(result),
                _ => {
                    Err(self
                        .expected("the end of the formula: a part with a name begins with `let`"))
                }
            };
        }
        match self.token() {
            Token::End => Ok(result),
            _ => Err(self.expected("an operator or the end of the formula")),
        }
    }

    /// Parses the helper `name = value;`.
    fn helper(&mut self) -> Result<(), FormulaError> {
        let (token, range) = (self.token(), self.range());
        let Token::Name(name) = token else {
            return Err(self.expected("a name after `let`"));
        };
        let parameter = self.parameters.iter().any(|(known, _)| known == name);
        let helper = self.helpers.iter().any(|(known, _)| known == name);
        let taken = match words::meaning(name) {
            None if parameter => Some("in use as a parameter"),
            None if helper => Some("the name of a helper"),
            known => known,
        };
        if let Some(what) = taken {
            let name = name.to_owned();
            return Err(self.error(range, Problem::Taken { name, what }));
        }
        self.advance();
        if !self.takes("=") {
            return Err(self.expected("`=` after the name of a helper"));
        }
        let value = self.number()?;
        if !self.takes(";") {
            return Err(self.expected("an operator, or `;` at the end of a helper"));
        }
        self.helpers.push((name.to_owned(), value));
        Ok(())
    }

    /// Parses an expression that must be a number.
    fn number(&mut self) -> Result<Id, FormulaError> {
        let value = self.expression(0)?;
        self.as_number(value)
    }

    fn as_number(&self, (value, range): Ranged) -> Result<Id, FormulaError> {
        match value {
            Value::Number(id) => Ok(id),
            _ => Err(self.error(range, Problem::ConditionAsNumber)),
        }
    }

    fn as_condition(&self, (value, range): Ranged) -> Result<Value, FormulaError> {
        match value {
            Value::Number(_) => Err(self.error(range, Problem::NumberAsCondition)),
            condition => Ok(condition),
        }
    }

    /// Parses operands and operators that bind at least as strongly as `least`.
    fn expression(&mut self, least: u8) -> Result<Ranged, FormulaError> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(self.error(self.range(), Problem::TooDeep { limit: MAX_DEPTH }));
        }
        let mut left = self.operand()?;
        while let Some((operator, strength)) = binary(self.token())
            && strength >= least
        {
            self.advance();
            // A power associates to the right: its exponent may be a power, or have a sign.
            let right = match operator {
                "^" => self.expression(SIGN)?,
                _ => self.expression(strength + 1)?,
            };
            left = self.combined(operator, left, right)?;
        }
        self.depth -= 1;
        Ok(left)
    }

    /// Parses a number, a name, a call or a group, optionally after a sign or `not`.
    fn operand(&mut self) -> Result<Ranged, FormulaError> {
        let (token, range) = (self.token(), self.range());
        match token {
            Token::Number(value) => {
                self.advance();
                self.graph.range = range.clone();
                Ok((Value::Number(self.graph.constant(value)), range))
            }
            Token::Sign(sign @ ("-" | "+")) => {
                self.advance();
                let operand = self.expression(SIGN)?;
                let range = range.start..operand.1.end;
                let number = self.as_number(operand)?;
                self.graph.range = range.clone();
                let number = if sign == "-" {
                    self.graph.negate(number)
                } else {
                    number
                };
                Ok((Value::Number(number), range))
            }
            Token::Sign("(") => {
                self.advance();
                let (value, _) = self.expression(0)?;
                let end = self.closed(&range, "an operator or `)`")?;
                Ok((value, range.start..end))
            }
            Token::Name("not") => {
                self.advance();
                let operand = self.expression(NOT)?;
                let range = range.start..operand.1.end;
                let condition = self.as_condition(operand)?;
                self.graph.range = range.clone();
                Ok((self.opposite(condition), range))
            }
            Token::Name("and" | "or" | "let") => Err(self.expected("a number, a name or `(`")),
            Token::Name(name) => {
                self.advance();
                if self.token() == Token::Sign("(") {
                    self.call(name, range)
                } else {
                    let id = self.named(name, &range)?;
                    Ok((Value::Number(id), range))
                }
            }
            _ => Err(self.expected("a number, a name or `(`")),
        }
    }

    /// Consumes the parenthesis that closes `open`. Returns the end of its range.
    fn closed(
        &mut self,
        open: &Range<usize>,
        expected: &'static str,
    ) -> Result<usize, FormulaError> {
        let range = self.range();
        if self.takes(")") {
            Ok(range.end)
        } else if matches!(self.token(), Token::End | Token::Sign(";")) {
            Err(self.error(open.clone(), Problem::NotClosed))
        } else {
            Err(self.expected(expected))
        }
    }

    /// Value of a binary operation.
    fn combined(
        &mut self,
        operator: &'static str,
        left: Ranged,
        right: Ranged,
    ) -> Result<Ranged, FormulaError> {
        let range = left.1.start..right.1.end;
        let is_comparison = matches!(operator, "<" | "<=" | ">" | ">=");
        if is_comparison && !matches!((left.0, right.0), (Value::Number(_), Value::Number(_))) {
            return Err(self.error(range, Problem::ChainedComparison));
        }
        let value = match operator {
            "and" | "or" => {
                let (a, b) = (self.as_condition(left)?, self.as_condition(right)?);
                self.graph.range = range.clone();
                let other = self.indicator(b);
                let certain = self.graph.constant(f64::from(u8::from(operator == "or")));
                let both = match operator {
                    "and" => self.choice(a, other, certain),
                    _ => self.choice(a, certain, other),
                };
                Value::Indicator(both)
            }
            _ => {
                let (a, b) = (self.as_number(left)?, self.as_number(right)?);
                self.graph.range = range.clone();
                match operator {
                    "+" => Value::Number(self.graph.add(a, b)),
                    "-" => Value::Number(self.graph.subtract(a, b)),
                    "*" => Value::Number(self.graph.multiply(a, b)),
                    "/" => Value::Number(self.graph.divide(a, b)),
                    "^" => Value::Number(self.graph.power(a, b)),
                    "<" => Value::Comparison(self.graph.subtract(a, b), true),
                    ">=" => Value::Comparison(self.graph.subtract(a, b), false),
                    ">" => Value::Comparison(self.graph.subtract(b, a), true),
                    _ => Value::Comparison(self.graph.subtract(b, a), false),
                }
            }
        };
        self.check_size(&range)?;
        Ok((value, range))
    }

    fn check_size(&self, range: &Range<usize>) -> Result<(), FormulaError> {
        if self.graph.len() > MAX_OPERATIONS {
            Err(self.error(
                range.clone(),
                Problem::TooManyOperations {
                    limit: MAX_OPERATIONS,
                },
            ))
        } else {
            Ok(())
        }
    }

    /// Selects one number where a condition holds, and another elsewhere.
    fn choice(&mut self, condition: Value, holds: Id, fails: Id) -> Id {
        match condition {
            Value::Comparison(test, true) => self.graph.select(test, holds, fails),
            Value::Comparison(test, false) => self.graph.select(test, fails, holds),
            Value::Indicator(indicator) | Value::Number(indicator) => {
                let half = self.graph.constant(0.5);
                let test = self.graph.subtract(indicator, half);
                self.graph.select(test, fails, holds)
            }
        }
    }

    /// Converts a condition to one where it holds and zero elsewhere.
    fn indicator(&mut self, condition: Value) -> Id {
        match condition {
            Value::Indicator(indicator) => indicator,
            _ => {
                let (one, zero) = (self.graph.constant(1.0), self.graph.constant(0.0));
                self.choice(condition, one, zero)
            }
        }
    }

    fn opposite(&mut self, condition: Value) -> Value {
        match condition {
            Value::Comparison(test, holds_below) => Value::Comparison(test, !holds_below),
            Value::Indicator(indicator) | Value::Number(indicator) => {
                let one = self.graph.constant(1.0);
                Value::Indicator(self.graph.subtract(one, indicator))
            }
        }
    }

    /// Parses a name that represents a number.
    fn named(&mut self, name: &'a str, range: &Range<usize>) -> Result<Id, FormulaError> {
        self.graph.range = range.clone();
        if name == words::PI {
            return Ok(self.graph.constant(std::f64::consts::PI));
        }
        if let Some(function) = words::function(name) {
            let problem = Problem::NoArguments {
                function: function.name,
                expected: function.arity.expected(),
            };
            return Err(self.error(range.clone(), problem));
        }
        if let Some((_, id)) = self.helpers.iter().find(|(known, _)| known == name) {
            return Ok(*id);
        }
        if let Some((_, variable)) = words::variable(name) {
            if !self.variables.contains(&variable) {
                self.variables.push(variable);
            }
            return Ok(self.variable(variable, range));
        }
        Ok(self.parameter(name, range))
    }

    fn parameter(&mut self, name: &str, range: &Range<usize>) -> Id {
        let known = self.parameters.iter().position(|(known, _)| known == name);
        let number = known.unwrap_or_else(|| {
            self.parameters.push((name.to_owned(), range.clone()));
            self.parameters.len() - 1
        });
        self.graph.parameter(number)
    }

    /// Expands a variable by its definition.
    fn variable(&mut self, name: &'static str, range: &Range<usize>) -> Id {
        match name {
            "J" => self.graph.leaf(Leaf::Jacobian),
            "lambda1" => self.graph.leaf(Leaf::Stretch(0)),
            "lambda2" => self.graph.leaf(Leaf::Stretch(1)),
            "lambda3" => self.graph.leaf(Leaf::Stretch(2)),
            "I1" => self.first_invariant(),
            "I2" => self.second_invariant(),
            "I3" => self.jacobian_power(2.0),
            "I1bar" => {
                let exponent = -2.0 / self.dimension as f64;
                let (invariant, factor) = (self.first_invariant(), self.jacobian_power(exponent));
                self.graph.multiply(invariant, factor)
            }
            "I2bar" => {
                let exponent = -4.0 / self.dimension as f64;
                let (invariant, factor) = (self.second_invariant(), self.jacobian_power(exponent));
                self.graph.multiply(invariant, factor)
            }
            "I4" => self.fiber_invariant(FIBER_ANGLES[0], false, range),
            "I5" => self.fiber_invariant(FIBER_ANGLES[0], true, range),
            "I6" => self.fiber_invariant(FIBER_ANGLES[1], false, range),
            "I7" => self.fiber_invariant(FIBER_ANGLES[1], true, range),
            component => {
                let bytes = component.as_bytes();
                self.component(bytes[0], index(bytes[1]), index(bytes[2]))
            }
        }
    }

    fn component(&mut self, tensor: u8, i: usize, j: usize) -> Id {
        match tensor {
            b'F' => self.graph.leaf(Leaf::Component(i, j)),
            b'C' => self.graph.cauchy_green(i, j),
            // Green's strain E = (C - 1) / 2.
            _ => {
                let c = self.graph.cauchy_green(i, j);
                let one = self.graph.constant(f64::from(u8::from(i == j)));
                let half = self.graph.constant(0.5);
                let difference = self.graph.subtract(c, one);
                self.graph.multiply(difference, half)
            }
        }
    }

    fn first_invariant(&mut self) -> Id {
        let axes = 0..self.dimension;
        let diagonal: Vec<Id> = axes.map(|i| self.graph.cauchy_green(i, i)).collect();
        self.graph.sum(&diagonal)
    }

    /// Sum of the principal minors of `C`.
    fn second_invariant(&mut self) -> Id {
        let pairs = [(0, 1), (0, 2), (1, 2)].into_iter();
        let within = pairs.filter(|(_, j)| *j < self.dimension);
        let within: Vec<(usize, usize)> = within.collect();
        let minors: Vec<Id> = within
            .into_iter()
            .map(|(i, j)| {
                let [a, b, c] =
                    [(i, i), (j, j), (i, j)].each(|(i, j)| self.graph.cauchy_green(i, j));
                let (product, square) = (self.graph.multiply(a, b), self.graph.multiply(c, c));
                self.graph.subtract(product, square)
            })
            .collect();
        self.graph.sum(&minors)
    }

    fn jacobian_power(&mut self, exponent: f64) -> Id {
        let (jacobian, exponent) = (
            self.graph.leaf(Leaf::Jacobian),
            self.graph.constant(exponent),
        );
        self.graph.power(jacobian, exponent)
    }

    /// Fiber invariant `a . C a` or `a . C^2 a = |C a|^2` of fibers at an angle within the plane.
    fn fiber_invariant(
        &mut self,
        angle: &'static str,
        of_square: bool,
        range: &Range<usize>,
    ) -> Id {
        let degrees = self.parameter(angle, range);
        let degree = self.graph.constant(std::f64::consts::PI / 180.0);
        let radians = self.graph.multiply(degrees, degree);
        let fiber =
            [Function::Cosine, Function::Sine].each(|function| self.graph.apply(function, radians));
        // Components of C a: two within the plane, one out of the plane.
        let image = [0, 1, 2].each(|i| {
            let products = [0, 1].each(|j| {
                let c = self.graph.cauchy_green(i, j);
                self.graph.multiply(c, fiber[j])
            });
            self.graph.sum(&products)
        });
        let terms: Vec<Id> = if of_square {
            image.each(|c| self.graph.multiply(c, c)).to_vec()
        } else {
            let along = |(a, c): (&Id, &Id)| self.graph.multiply(*a, *c);
            fiber.iter().zip(&image).map(along).collect()
        };
        self.graph.sum(&terms)
    }

    /// Parses a function call, starting at the opening parenthesis.
    fn call(&mut self, name: &'a str, range: Range<usize>) -> Result<Ranged, FormulaError> {
        let Some(function) = words::function(name) else {
            return Err(self.error(range, self.not_a_function(name)));
        };
        let open = self.range();
        self.advance();
        let mut arguments = Vec::new();
        if self.token() != Token::Sign(")") {
            loop {
                arguments.push(self.expression(0)?);
                if !self.takes(",") {
                    break;
                }
            }
        }
        let end = self.closed(&open, "an operator, `,` or `)`")?;
        let range = range.start..end;
        if !function.arity.admits(arguments.len()) {
            let problem = Problem::Arguments {
                function: function.name,
                expected: function.arity.expected(),
                found: arguments.len(),
            };
            return Err(self.error(range, problem));
        }
        let value = self.applied(function, arguments, &range)?;
        self.check_size(&range)?;
        Ok((Value::Number(value), range))
    }

    fn not_a_function(&self, name: &str) -> Problem {
        let is_helper = self.helpers.iter().any(|(known, _)| known == name);
        let is_parameter = self.parameters.iter().any(|(known, _)| known == name);
        let what = match words::meaning(name) {
            None if is_helper => Some("a helper"),
            None if is_parameter => Some("a parameter"),
            known => known,
        };
        let name = name.to_owned();
        match what {
            Some(what) => Problem::NotAFunction { name, what },
            None => {
                let meant = words::nearest(&name, words::function_names());
                Problem::UnknownFunction { name, meant }
            }
        }
    }

    /// Applies a function to a valid number of arguments.
    fn applied(
        &mut self,
        function: &FunctionWord,
        arguments: Vec<Ranged>,
        range: &Range<usize>,
    ) -> Result<Id, FormulaError> {
        let mut arguments = arguments.into_iter();
        let condition = match function.arity {
            Arity::Condition => arguments.next().map(|first| self.as_condition(first)),
            _ => None,
        }
        .transpose()?;
        let numbers = arguments
            .map(|argument| self.as_number(argument))
            .collect::<Result<Vec<Id>, _>>()?;
        self.graph.range = range.clone();
        Ok(match (condition, numbers.as_slice()) {
            (Some(condition), [holds, fails]) => self.choice(condition, *holds, *fails),
            (_, [x]) => self.function_of_one(function.name, *x),
            (_, [x, y]) if function.name == "pow" => self.graph.power(*x, *y),
            (_, all) => {
                let mut extreme = all[0];
                for &other in &all[1..] {
                    let difference = self.graph.subtract(extreme, other);
                    extreme = match function.name {
                        "min" => self.graph.select(difference, extreme, other),
                        _ => self.graph.select(difference, other, extreme),
                    };
                }
                extreme
            }
        })
    }

    fn function_of_one(&mut self, name: &str, x: Id) -> Id {
        let graph = &mut self.graph;
        match name {
            "sqrt" | "cbrt" => {
                let exponent = if name == "sqrt" { 0.5 } else { 1.0 / 3.0 };
                let exponent = graph.constant(exponent);
                graph.power(x, exponent)
            }
            "exp" => graph.apply(Function::Exponential, x),
            "ln" => graph.apply(Function::Logarithm, x),
            "log10" => {
                let logarithm = graph.apply(Function::Logarithm, x);
                let ten = graph.constant(std::f64::consts::LN_10);
                graph.divide(logarithm, ten)
            }
            "sin" => graph.apply(Function::Sine, x),
            "cos" => graph.apply(Function::Cosine, x),
            "tan" => {
                let [sine, cosine] =
                    [Function::Sine, Function::Cosine].each(|function| graph.apply(function, x));
                graph.divide(sine, cosine)
            }
            "sinh" => graph.apply(Function::HyperbolicSine, x),
            "cosh" => graph.apply(Function::HyperbolicCosine, x),
            "tanh" => graph.apply(Function::HyperbolicTangent, x),
            "abs" => {
                let opposite = graph.negate(x);
                graph.select(x, opposite, x)
            }
            "heaviside" => {
                let (zero, one) = (graph.constant(0.0), graph.constant(1.0));
                graph.select(x, zero, one)
            }
            // The remaining functions are macaulay and ramp.
            _ => {
                let zero = graph.constant(0.0);
                graph.select(x, zero, x)
            }
        }
    }
}

/// Binary operator of a token, with its strength.
fn binary(token: Token<'_>) -> Option<(&'static str, u8)> {
    Some(match token {
        Token::Name("or") => ("or", OR),
        Token::Name("and") => ("and", AND),
        Token::Sign(sign @ ("<" | "<=" | ">" | ">=")) => (sign, COMPARISON),
        Token::Sign(sign @ ("+" | "-")) => (sign, SUM),
        Token::Sign(sign @ ("*" | "/")) => (sign, PRODUCT),
        Token::Sign("^") => ("^", POWER),
        _ => return None,
    })
}

/// Index of a component, counted from zero.
fn index(digit: u8) -> usize {
    usize::from(digit - b'1')
}
