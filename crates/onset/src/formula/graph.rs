//! Operations of a formula as a directed acyclic graph. Equal parts are shared and constants are folded during construction.

use crate::algebra::Each;
use std::collections::HashMap;
use std::ops::Range;

/// Index of a node. Operands have smaller indices.
pub(super) type Id = usize;

/// Floating-point constant that can be compared and hashed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Bits(u64);

impl Bits {
    pub(super) fn of(value: f64) -> Self {
        Self(value.to_bits())
    }

    pub(super) fn value(self) -> f64 {
        f64::from_bits(self.0)
    }
}

/// Function of one number provided by [`Real`](crate::real::Real). Roots and reciprocals are powers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Function {
    Exponential,
    Logarithm,
    Sine,
    Cosine,
    HyperbolicSine,
    HyperbolicCosine,
    HyperbolicTangent,
}

impl Function {
    pub(super) fn of<R: crate::real::Real>(self, x: R) -> R {
        match self {
            Self::Exponential => x.exp(),
            Self::Logarithm => x.ln(),
            Self::Sine => x.sin(),
            Self::Cosine => x.cos(),
            Self::HyperbolicSine => x.sinh(),
            Self::HyperbolicCosine => x.cosh(),
            Self::HyperbolicTangent => x.tanh(),
        }
    }
}

/// Variable input of a formula.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Leaf {
    /// Component `F_iJ` of the deformation gradient.
    Component(usize, usize),
    /// Component `C_IJ`, `I <= J`, of the right Cauchy-Green tensor.
    CauchyGreen(usize, usize),
    /// Ratio of volumes `J = det F`.
    Jacobian,
    /// Principal stretch, counted from zero.
    Stretch(usize),
    /// Variable of a function of one number.
    Argument,
}

/// One operation of the graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Node {
    Constant(Bits),
    /// Number whose value is supplied later.
    Parameter(usize),
    Leaf(Leaf),
    Apply(Function, Id),
    Negate(Id),
    Add(Id, Id),
    Subtract(Id, Id),
    Multiply(Id, Id),
    Divide(Id, Id),
    Power(Id, Id),
    /// Selection: the second node if the first is negative, otherwise the third.
    Select(Id, Id, Id),
}

impl Node {
    /// Operands of the node.
    pub(super) fn operands(self) -> impl Iterator<Item = Id> {
        let all = match self {
            Self::Constant(_) | Self::Parameter(_) | Self::Leaf(_) => [None; 3],
            Self::Apply(_, a) | Self::Negate(a) => [Some(a), None, None],
            Self::Add(a, b)
            | Self::Subtract(a, b)
            | Self::Multiply(a, b)
            | Self::Divide(a, b)
            | Self::Power(a, b) => [Some(a), Some(b), None],
            Self::Select(a, b, c) => [Some(a), Some(b), Some(c)],
        };
        all.into_iter().flatten()
    }
}

/// Known sign of a node at every admissible state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Sign {
    Any,
    NotNegative,
    Positive,
}

/// Nodes in the order of evaluation.
#[derive(Clone, Default)]
pub(super) struct Graph {
    nodes: Vec<Node>,
    /// Range of the text where each node first appears.
    ranges: Vec<Range<usize>>,
    known: HashMap<Node, Id>,
    /// Known signs of the nodes, derived from their form alone.
    signs: Vec<Sign>,
    /// Whether each node is defined at every admissible state, derived from its form alone.
    total: Vec<bool>,
    /// Range of the text of the nodes to be added next.
    pub(super) range: Range<usize>,
}

impl std::fmt::Debug for Graph {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_list().entries(&self.nodes).finish()
    }
}

impl Graph {
    pub(super) fn len(&self) -> usize {
        self.nodes.len()
    }

    pub(super) fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Range of bytes where a node first appears in the text.
    pub(super) fn range_of(&self, id: Id) -> Range<usize> {
        self.ranges[id].clone()
    }

    /// Value of a node, if it is a constant.
    pub(super) fn value(&self, id: Id) -> Option<f64> {
        match self.nodes[id] {
            Node::Constant(bits) => Some(bits.value()),
            _ => None,
        }
    }

    /// Flags of the nodes that a result needs, including the result.
    pub(super) fn needed_by(&self, result: Id) -> Vec<bool> {
        let mut needed = vec![false; self.nodes.len()];
        needed[result] = true;
        for id in (0..self.nodes.len()).rev() {
            if needed[id] {
                self.nodes[id].operands().for_each(|a| needed[a] = true);
            }
        }
        needed
    }

    fn node(&mut self, node: Node) -> Id {
        if let Some(&id) = self.known.get(&node) {
            return id;
        }
        let id = self.nodes.len();
        self.signs.push(self.sign_of(node));
        self.total.push(self.is_total_node(node));
        self.nodes.push(node);
        self.ranges.push(self.range.clone());
        self.known.insert(node, id);
        id
    }

    fn sign_of(&self, node: Node) -> Sign {
        let sign = |id: Id| self.signs[id];
        let is_whole = |x: f64, divisor: f64| (x / divisor).fract() == 0.0;
        match node {
            Node::Constant(bits) if bits.value() > 0.0 => Sign::Positive,
            Node::Constant(bits) if bits.value() == 0.0 => Sign::NotNegative,
            Node::Leaf(Leaf::Jacobian | Leaf::Stretch(_)) => Sign::Positive,
            Node::Leaf(Leaf::CauchyGreen(i, j)) if i == j => Sign::Positive,
            Node::Apply(Function::Exponential | Function::HyperbolicCosine, _) => Sign::Positive,
            Node::Add(a, b) => match (sign(a), sign(b)) {
                (Sign::Any, _) | (_, Sign::Any) => Sign::Any,
                (a, b) => a.max(b),
            },
            Node::Multiply(a, b) => sign(a).min(sign(b)),
            Node::Divide(a, b) if sign(b) == Sign::Positive => sign(a),
            Node::Power(a, b) => match (sign(a), self.value(b)) {
                (Sign::Positive, _) => Sign::Positive,
                (_, Some(exponent)) if is_whole(exponent, 2.0) => Sign::NotNegative,
                (sign, Some(exponent)) if is_whole(exponent, 1.0) => sign,
                _ => Sign::NotNegative,
            },
            Node::Select(_, below, above) => sign(below).min(sign(above)),
            _ => Sign::Any,
        }
    }

    fn is_total_node(&self, node: Node) -> bool {
        let is_positive = |id: Id| self.signs[id] == Sign::Positive;
        let has_domain = match node {
            Node::Apply(Function::Logarithm, a) => is_positive(a),
            Node::Divide(_, b) => is_positive(b) || self.value(b).is_some_and(|b| b != 0.0),
            Node::Power(a, b) => {
                let is_count = |b: f64| b >= 0.0 && b.fract() == 0.0;
                is_positive(a) || self.value(b).is_some_and(is_count)
            }
            _ => true,
        };
        has_domain && node.operands().all(|id| self.total[id])
    }

    /// Returns true if a node is defined at every admissible state, according to its form alone.
    pub(super) fn is_total(&self, id: Id) -> bool {
        self.total[id]
    }

    /// Restricts a value to the domain of another node. A part that cancels in the value still restricts its domain.
    fn demanding(&mut self, needed: Id, value: Id) -> Id {
        if self.total[needed] {
            return value;
        }
        let zero = self.constant(0.0);
        let nothing = self.node(Node::Multiply(needed.min(zero), needed.max(zero)));
        if self.value(value) == Some(0.0) {
            nothing
        } else {
            self.node(Node::Add(value.min(nothing), value.max(nothing)))
        }
    }

    /// Returns the factor, 1 or -1, if two nodes are equal or opposite.
    pub(super) fn multiple(&self, a: Id, b: Id) -> Option<f64> {
        let is_opposite = |a: Id, b: Id| match (self.nodes[a], self.nodes[b]) {
            (Node::Negate(x), _) if x == b => true,
            (Node::Subtract(p, q), Node::Subtract(r, s)) => p == s && q == r,
            _ => false,
        };
        if a == b {
            Some(1.0)
        } else {
            (is_opposite(a, b) || is_opposite(b, a)).then_some(-1.0)
        }
    }

    pub(super) fn constant(&mut self, value: f64) -> Id {
        self.node(Node::Constant(Bits::of(value)))
    }

    pub(super) fn parameter(&mut self, number: usize) -> Id {
        self.node(Node::Parameter(number))
    }

    pub(super) fn leaf(&mut self, leaf: Leaf) -> Id {
        self.node(Node::Leaf(leaf))
    }

    pub(super) fn cauchy_green(&mut self, i: usize, j: usize) -> Id {
        self.leaf(Leaf::CauchyGreen(i.min(j), i.max(j)))
    }

    /// Folds an operation on constants. If an operand is not finite, it is returned instead, so that the first cause is reported.
    fn folded<const N: usize>(
        &mut self,
        operands: [Id; N],
        operation: impl FnOnce([f64; N]) -> f64,
    ) -> Option<Id> {
        let values = operands.each(|id| self.value(id));
        let broken = |value: &Option<f64>| value.is_some_and(|value| !value.is_finite());
        if let Some(at) = values.iter().position(broken) {
            return Some(operands[at]);
        }
        if values.iter().any(Option::is_none) {
            return None;
        }
        let result = operation(values.map(Option::unwrap_or_default));
        Some(self.constant(result))
    }

    pub(super) fn apply(&mut self, function: Function, x: Id) -> Id {
        if let Some(id) = self.folded([x], |[x]| function.of(x)) {
            return id;
        }
        match (function, self.nodes[x]) {
            // ln J^n = n ln J, since J is positive.
            (Function::Logarithm, Node::Power(base, exponent))
                if self.nodes[base] == Node::Leaf(Leaf::Jacobian) =>
            {
                let logarithm = self.apply(function, base);
                self.multiply(logarithm, exponent)
            }
            _ => self.node(Node::Apply(function, x)),
        }
    }

    pub(super) fn negate(&mut self, x: Id) -> Id {
        if let Some(id) = self.folded([x], |[x]| -x) {
            return id;
        }
        match self.nodes[x] {
            Node::Negate(inner) => inner,
            _ => self.node(Node::Negate(x)),
        }
    }

    pub(super) fn add(&mut self, a: Id, b: Id) -> Id {
        if let Some(id) = self.folded([a, b], |[a, b]| a + b) {
            return id;
        }
        match (self.value(a), self.value(b)) {
            (Some(0.0), _) => b,
            (_, Some(0.0)) => a,
            _ => self.node(Node::Add(a.min(b), a.max(b))),
        }
    }

    pub(super) fn subtract(&mut self, a: Id, b: Id) -> Id {
        if let Some(id) = self.folded([a, b], |[a, b]| a - b) {
            return id;
        }
        match (self.value(a), self.value(b)) {
            (Some(0.0), _) => self.negate(b),
            (_, Some(0.0)) => a,
            _ => self.node(Node::Subtract(a, b)),
        }
    }

    pub(super) fn multiply(&mut self, a: Id, b: Id) -> Id {
        if let Some(id) = self.folded([a, b], |[a, b]| a * b) {
            return id;
        }
        match (self.value(a), self.value(b)) {
            (Some(factor), None) => self.scale(b, factor, a),
            (None, Some(factor)) => self.scale(a, factor, b),
            // The square of an interval is never negative, but its product with itself may be.
            _ if a == b => {
                let two = self.constant(2.0);
                self.power(a, two)
            }
            _ => self.node(Node::Multiply(a.min(b), a.max(b))),
        }
    }

    /// Multiplies a node by a constant, whose node is `constant`.
    fn scale(&mut self, x: Id, factor: f64, constant: Id) -> Id {
        if factor == 0.0 {
            return self.demanding(x, constant);
        }
        if factor == 1.0 {
            return x;
        }
        if factor == -1.0 {
            return self.negate(x);
        }
        match self.scaled(x) {
            Some((inner, earlier)) => {
                let both = self.constant(earlier * factor);
                self.multiply(inner, both)
            }
            None => self.node(Node::Multiply(x.min(constant), x.max(constant))),
        }
    }

    /// Splits a product with a constant into the node and the constant.
    fn scaled(&self, x: Id) -> Option<(Id, f64)> {
        match self.nodes[x] {
            Node::Multiply(a, b) => match (self.value(a), self.value(b)) {
                (Some(factor), None) => Some((b, factor)),
                (None, Some(factor)) => Some((a, factor)),
                _ => None,
            },
            _ => None,
        }
    }

    pub(super) fn divide(&mut self, a: Id, b: Id) -> Id {
        if let Some(id) = self.folded([a, b], |[a, b]| a / b) {
            return id;
        }
        let scaled = self.scaled(a);
        match (self.value(b), scaled) {
            (Some(1.0), _) => a,
            // Undefined at every state, independent of the dividend.
            (Some(0.0), _) => self.constant(f64::NAN),
            (Some(divisor), Some((inner, factor))) => {
                let quotient = self.constant(factor / divisor);
                self.multiply(inner, quotient)
            }
            _ => self.node(Node::Divide(a, b)),
        }
    }

    pub(super) fn power(&mut self, base: Id, exponent: Id) -> Id {
        if let Some(id) = self.folded([base, exponent], |[base, exponent]| base.powf(exponent)) {
            return id;
        }
        match (self.value(base), self.value(exponent), self.nodes[base]) {
            (_, Some(0.0), _) => {
                let one = self.constant(1.0);
                self.demanding(base, one)
            }
            (_, Some(1.0), _) => base,
            // (J^m)^n = J^(m n), since J is positive.
            (_, _, Node::Power(inner, earlier))
                if self.nodes[inner] == Node::Leaf(Leaf::Jacobian) =>
            {
                let product = self.multiply(earlier, exponent);
                self.power(inner, product)
            }
            // A power of a constant is c^y = exp(y ln c).
            (Some(_), None, _) => {
                let logarithm = self.apply(Function::Logarithm, base);
                let product = self.multiply(exponent, logarithm);
                self.apply(Function::Exponential, product)
            }
            _ => self.node(Node::Power(base, exponent)),
        }
    }

    /// Selects `below` if `test` is negative, otherwise `above`.
    pub(super) fn select(&mut self, test: Id, below: Id, above: Id) -> Id {
        match self.value(test) {
            Some(value) if !value.is_finite() => test,
            Some(value) if value < 0.0 => below,
            Some(_) => above,
            None if below == above => self.demanding(test, below),
            None => self.node(Node::Select(test, below, above)),
        }
    }

    /// Sum of the given nodes.
    pub(super) fn sum(&mut self, terms: &[Id]) -> Id {
        let mut total = terms[0];
        for &term in &terms[1..] {
            total = self.add(total, term);
        }
        total
    }

    /// Graph of the result with numbers in place of the parameters.
    pub(super) fn with_parameters(&self, result: Id, values: &[f64]) -> (Self, Id) {
        self.replaced(result, |graph, number| graph.constant(values[number]))
    }

    /// Graph of the result with the argument in place of every parameter.
    pub(super) fn of_argument(&self, result: Id) -> (Self, Id) {
        self.replaced(result, |graph, _| graph.leaf(Leaf::Argument))
    }

    /// Graph of the result with replacements for the parameters.
    fn replaced(&self, result: Id, parameter: impl Fn(&mut Self, usize) -> Id) -> (Self, Id) {
        let needed = self.needed_by(result);
        let mut graph = Self::default();
        let mut place: Vec<Id> = Vec::with_capacity(self.nodes.len());
        for (id, node) in self.nodes.iter().enumerate() {
            if !needed[id] {
                place.push(0);
                continue;
            }
            graph.range = self.ranges[id].clone();
            place.push(match *node {
                Node::Parameter(number) => parameter(&mut graph, number),
                Node::Constant(_) | Node::Leaf(_) => graph.node(*node),
                Node::Apply(function, x) => graph.apply(function, place[x]),
                Node::Negate(x) => graph.negate(place[x]),
                Node::Add(a, b) => graph.add(place[a], place[b]),
                Node::Subtract(a, b) => graph.subtract(place[a], place[b]),
                Node::Multiply(a, b) => graph.multiply(place[a], place[b]),
                Node::Divide(a, b) => graph.divide(place[a], place[b]),
                Node::Power(a, b) => graph.power(place[a], place[b]),
                Node::Select(test, below, above) => {
                    graph.select(place[test], place[below], place[above])
                }
            });
        }
        (graph, place[result])
    }

    /// Splits the result into a sum of two parts: the terms that need a leaf of the given kind, and all other terms. A part without terms is `None`.
    pub(super) fn split(
        &mut self,
        result: Id,
        is_of_kind: impl Fn(Leaf) -> bool,
    ) -> [Option<Id>; 2] {
        let mut depends = vec![false; result + 1];
        for id in 0..=result {
            depends[id] = match self.nodes[id] {
                Node::Leaf(leaf) => is_of_kind(leaf),
                node => node.operands().any(|a| depends[a]),
            };
        }
        // Sums are split from the end, so that a part that occurs twice is one term.
        let mut factors = vec![None; result + 1];
        factors[result] = Some(1.0);
        let add = |sum: &mut Option<f64>, factor: f64| *sum = Some(sum.unwrap_or(0.0) + factor);
        let mut sums = [None; 2];
        for id in (0..=result).rev() {
            let Some(factor) = factors[id] else {
                continue;
            };
            match (self.nodes[id], self.scaled(id)) {
                (Node::Add(a, b), _) if depends[id] => {
                    add(&mut factors[a], factor);
                    add(&mut factors[b], factor);
                }
                (Node::Subtract(a, b), _) if depends[id] => {
                    add(&mut factors[a], factor);
                    add(&mut factors[b], -factor);
                }
                (Node::Negate(a), _) if depends[id] => add(&mut factors[a], -factor),
                (_, Some((a, inner))) if depends[id] => add(&mut factors[a], inner * factor),
                (Node::Divide(a, b), _) if depends[id] && self.value(b).is_some() => {
                    add(&mut factors[a], factor / self.value(b).unwrap_or(1.0));
                }
                _ => {
                    self.range = self.range_of(id);
                    let factor = self.constant(factor);
                    let term = self.multiply(id, factor);
                    if self.value(term) == Some(0.0) {
                        continue;
                    }
                    let sum = sums[usize::from(!depends[id])];
                    sums[usize::from(!depends[id])] = Some(match sum {
                        Some(sum) => self.add(sum, term),
                        None => term,
                    });
                }
            }
        }
        sums
    }

    /// Leaves that a result needs.
    pub(super) fn leaves_of(&self, result: Id) -> impl Iterator<Item = Leaf> + '_ {
        let needed = self.needed_by(result);
        let leaf = move |(id, node): (Id, &Node)| match node {
            Node::Leaf(leaf) if needed[id] => Some(*leaf),
            _ => None,
        };
        self.nodes.iter().enumerate().filter_map(leaf)
    }
}
