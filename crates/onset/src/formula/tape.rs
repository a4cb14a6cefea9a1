//! Formula as a linear list of operations on a few registers, for numbers of every kind.

use super::contact::is_smooth_across;
use super::graph::{Function, Graph, Id, Leaf, Node};
use crate::real::{Real, Side};
use std::ops::Range;

/// Index of a register for an intermediate result.
type Register = u16;

/// Operation on registers and constants.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Operation {
    Constant(f64),
    Leaf(Leaf),
    Apply(Function, Register),
    Negate(Register),
    Add(Register, Register),
    /// Sum `x + c` with a constant.
    Shift(Register, f64),
    Subtract(Register, Register),
    /// Difference `c - x` from a constant.
    From(f64, Register),
    Multiply(Register, Register),
    /// Product `c x` with a constant.
    Scale(Register, f64),
    Divide(Register, Register),
    /// Quotient `x / c` by a constant.
    Over(Register, f64),
    /// Quotient `c / x` of a constant.
    Quotient(f64, Register),
    SquareRoot(Register),
    IntegerPower(Register, i32),
    RealPower(Register, f64),
    /// Power `x^y = exp(y ln x)` of two registers.
    Power(Register, Register),
    Select(Register, Register, Register),
}

/// Operations in order, each with the register of its result.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tape {
    steps: Vec<(Operation, Register)>,
    registers: usize,
    result: Register,
    /// Range of the text of each step.
    ranges: Vec<Range<usize>>,
    branches: Vec<Branch>,
    is_total: bool,
}

/// Step that selects one of two sides.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Branch {
    pub(super) step: usize,
    /// Whether the stress of the whole formula is certainly continuous where the sides meet.
    pub(super) is_smooth: bool,
    /// First branch with an equivalent test, and the factor between the two tests, 1 or -1.
    pub(super) alike: (usize, f64),
}

/// Observer of the evaluation of a tape.
pub(super) trait Observer<R> {
    /// Side selected by a step; `None` for both sides if it is uncertain.
    fn side(&mut self, step: usize, test: &R) -> Option<Side>;

    /// Called with the result of a step, which it may change.
    fn seen(&mut self, _step: usize, _result: &mut R) {}
}

/// Observer that selects the side given by the sign of the number and ignores results.
struct Plain;

impl<R: Real> Observer<R> for Plain {
    #[inline(always)]
    fn side(&mut self, _step: usize, test: &R) -> Option<Side> {
        test.side(0.0)
    }
}

/// Largest exponent of a power that is evaluated by multiplication.
const LARGEST_EXPONENT: f64 = 1024.0;

impl Tape {
    /// Compiles the operations that a result needs. Parameters must be replaced by numbers; a remaining parameter counts as zero.
    pub(super) fn new(graph: &Graph, result: Id) -> Self {
        let needed = graph.needed_by(result);
        let mut writer = Writer::new(graph, &needed, result);
        for (id, is_needed) in needed.iter().enumerate() {
            if *is_needed && !matches!(graph.nodes()[id], Node::Constant(_)) {
                writer.write(id);
            }
        }
        let place = writer.operand(result);
        let tests: Vec<(usize, Id)> = writer.tests;
        let alike = |n: usize| {
            let earlier = (0..=n).find_map(|first| {
                let factor = graph.multiple(tests[n].1, tests[first].1)?;
                Some((first, factor))
            });
            earlier.unwrap_or((n, 1.0))
        };
        let mut branches: Vec<Branch> = Vec::with_capacity(tests.len());
        for (n, &(step, test)) in tests.iter().enumerate() {
            let alike = alike(n);
            let is_smooth = match branches.get(alike.0) {
                Some(first) => first.is_smooth,
                None => is_smooth_across(graph, &needed, test, result),
            };
            branches.push(Branch {
                step,
                is_smooth,
                alike,
            });
        }
        Self {
            steps: writer.steps,
            registers: writer.count,
            result: place,
            ranges: writer.ranges,
            branches,
            is_total: graph.is_total(result),
        }
    }

    /// Range of the text of a step.
    pub(super) fn range(&self, step: usize) -> Range<usize> {
        self.ranges[step].clone()
    }

    /// Steps that select one of two sides, in order.
    pub(super) fn branches(&self) -> &[Branch] {
        &self.branches
    }

    /// Returns true if the formula is defined, with continuous stress, at every admissible state.
    pub(super) fn is_plain(&self) -> bool {
        self.is_total && self.branches.iter().all(|branch| branch.is_smooth)
    }

    /// Evaluates the result for given leaves. Registers are on the stack if there are few of them.
    pub(super) fn evaluate<R: Real>(&self, value: impl Fn(Leaf) -> R) -> R {
        self.observed(value, &mut Plain)
    }

    /// Evaluates the result with an observer.
    pub(super) fn observed<R: Real>(
        &self,
        value: impl Fn(Leaf) -> R,
        observer: &mut impl Observer<R>,
    ) -> R {
        let zero = R::constant(0.0);
        match self.registers {
            0..=4 => self.run(value, observer, &mut [zero; 4]),
            5..=8 => self.run(value, observer, &mut [zero; 8]),
            9..=16 => self.run(value, observer, &mut [zero; 16]),
            17..=32 => self.run(value, observer, &mut [zero; 32]),
            many => self.run(value, observer, &mut vec![zero; many]),
        }
    }

    fn run<R: Real>(
        &self,
        value: impl Fn(Leaf) -> R,
        observer: &mut impl Observer<R>,
        registers: &mut [R],
    ) -> R {
        for (step, &(operation, target)) in self.steps.iter().enumerate() {
            let at = |register: Register| registers[usize::from(register)];
            let mut result = match operation {
                Operation::Constant(number) => R::constant(number),
                Operation::Leaf(leaf) => value(leaf),
                Operation::Apply(function, a) => function.of(at(a)),
                Operation::Negate(a) => -at(a),
                Operation::Add(a, b) => at(a) + at(b),
                Operation::Shift(a, constant) => at(a) + constant,
                Operation::Subtract(a, b) => at(a) - at(b),
                Operation::From(constant, a) => -at(a) + constant,
                Operation::Multiply(a, b) => at(a) * at(b),
                Operation::Scale(a, factor) => at(a) * factor,
                Operation::Divide(a, b) => at(a) / at(b),
                Operation::Over(a, divisor) => at(a) / divisor,
                Operation::Quotient(factor, a) => at(a).recip() * factor,
                Operation::SquareRoot(a) => at(a).sqrt(),
                Operation::IntegerPower(a, exponent) => at(a).powi(exponent),
                Operation::RealPower(a, exponent) => at(a).powf(exponent),
                Operation::Power(a, b) => (at(a).ln() * at(b)).exp(),
                Operation::Select(test, below, above) => {
                    match observer.side(step, &registers[usize::from(test)]) {
                        Some(Side::Below) => at(below),
                        Some(Side::Above) => at(above),
                        None => at(test).blended(0.0, at(below), at(above)),
                    }
                }
            };
            observer.seen(step, &mut result);
            registers[usize::from(target)] = result;
        }
        registers[usize::from(self.result)]
    }
}

/// Compiler of a tape. Registers are reused after the last use of their value.
struct Writer<'a> {
    graph: &'a Graph,
    steps: Vec<(Operation, Register)>,
    ranges: Vec<Range<usize>>,
    /// Steps that select one of two sides, with the nodes that they test.
    tests: Vec<(usize, Id)>,
    /// Register of each node that has been written.
    place: Vec<Option<Register>>,
    /// Number of remaining uses of each node.
    uses: Vec<usize>,
    free: Vec<Register>,
    count: usize,
}

impl<'a> Writer<'a> {
    fn new(graph: &'a Graph, needed: &[bool], result: Id) -> Self {
        let mut uses = vec![0; graph.len()];
        for (id, node) in graph.nodes().iter().enumerate() {
            if needed[id] {
                node.operands().for_each(|a| uses[a] += 1);
            }
        }
        uses[result] += 1;
        Self {
            graph,
            steps: Vec::new(),
            ranges: Vec::new(),
            tests: Vec::new(),
            place: vec![None; graph.len()],
            uses,
            free: Vec::new(),
            count: 0,
        }
    }

    fn write(&mut self, id: Id) {
        let node = self.graph.nodes()[id];
        let operation = self.operation(node);
        // Release registers only now, so that no constant overwrites an operand.
        for operand in node.operands() {
            self.uses[operand] -= 1;
            if self.uses[operand] == 0
                && let Some(register) = self.place[operand]
            {
                self.free.push(register);
            }
        }
        let target = self.register();
        self.place[id] = Some(target);
        if let Node::Select(test, ..) = node {
            self.tests.push((self.steps.len(), test));
        }
        self.push(id, operation, target);
    }

    fn push(&mut self, id: Id, operation: Operation, target: Register) {
        self.steps.push((operation, target));
        self.ranges.push(self.graph.range_of(id));
    }

    /// Returns an unused register.
    fn register(&mut self) -> Register {
        self.free.pop().unwrap_or_else(|| {
            self.count += 1;
            (self.count - 1) as Register
        })
    }

    /// Returns the register of an operand. A constant is written when it is needed.
    fn operand(&mut self, id: Id) -> Register {
        if let Some(register) = self.place[id] {
            return register;
        }
        let register = self.register();
        let value = self.graph.value(id).unwrap_or(0.0);
        self.push(id, Operation::Constant(value), register);
        self.place[id] = Some(register);
        register
    }

    fn operation(&mut self, node: Node) -> Operation {
        let constant = |id: Id| self.graph.value(id);
        match node {
            Node::Constant(bits) => Operation::Constant(bits.value()),
            Node::Parameter(_) => Operation::Constant(0.0),
            Node::Leaf(leaf) => Operation::Leaf(leaf),
            Node::Apply(function, a) => Operation::Apply(function, self.operand(a)),
            Node::Negate(a) => Operation::Negate(self.operand(a)),
            Node::Add(a, b) => match (constant(a), constant(b)) {
                (Some(value), _) => Operation::Shift(self.operand(b), value),
                (_, Some(value)) => Operation::Shift(self.operand(a), value),
                _ => Operation::Add(self.operand(a), self.operand(b)),
            },
            Node::Subtract(a, b) => match (constant(a), constant(b)) {
                (Some(value), _) => Operation::From(value, self.operand(b)),
                (_, Some(value)) => Operation::Shift(self.operand(a), -value),
                _ => Operation::Subtract(self.operand(a), self.operand(b)),
            },
            Node::Multiply(a, b) => match (constant(a), constant(b)) {
                (Some(factor), _) => Operation::Scale(self.operand(b), factor),
                (_, Some(factor)) => Operation::Scale(self.operand(a), factor),
                _ => Operation::Multiply(self.operand(a), self.operand(b)),
            },
            Node::Divide(a, b) => match (constant(a), constant(b)) {
                (Some(factor), _) => Operation::Quotient(factor, self.operand(b)),
                (_, Some(divisor)) => Operation::Over(self.operand(a), divisor),
                _ => Operation::Divide(self.operand(a), self.operand(b)),
            },
            Node::Power(a, b) => match constant(b) {
                Some(exponent) => self.power(a, exponent),
                None => Operation::Power(self.operand(a), self.operand(b)),
            },
            Node::Select(test, below, above) => {
                Operation::Select(self.operand(test), self.operand(below), self.operand(above))
            }
        }
    }

    fn power(&mut self, base: Id, exponent: f64) -> Operation {
        let base = self.operand(base);
        if exponent == 0.5 {
            Operation::SquareRoot(base)
        } else if exponent == -1.0 {
            Operation::Quotient(1.0, base)
        } else if exponent.fract() == 0.0 && exponent.abs() <= LARGEST_EXPONENT {
            Operation::IntegerPower(base, exponent as i32)
        } else {
            Operation::RealPower(base, exponent)
        }
    }
}
