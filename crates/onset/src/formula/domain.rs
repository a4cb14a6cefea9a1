//! Where a formula has a value, and where it has a stress.
//!
//! The operations are run with intervals, so that rounding is counted. On the edge of where a part is defined it has no derivative, so
//! that it counts as not defined there. A part that is not defined spoils what is made of it, but not a
//! branch that does not take it. Where a test does not tell its side, the formula is looked at with each: values that certainly
//! differ are a jump, first derivatives that do a kink. Nothing that is not defined on both sides has a derivative there.

use super::error::Trouble;
use super::graph::Leaf;
use super::tape::{Observer, Tape};
use crate::real::{Interval, Jet, Real, Side};
use std::ops::{Add, Div, Mul, Neg, Range, Sub};

/// Tests that are undecided together of which all sides are tried; of more, each apart.
const TOGETHER: usize = 6;

/// What keeps a formula from having a stress at a state, with the place in the text.
///
/// `value` are bounds of the leaves, `jet` the same with derivatives by the deformation gradient.
pub(super) fn trouble(
    tape: &Tape,
    value: impl Fn(Leaf) -> Interval,
    jet: impl Fn(Leaf) -> Jet<9, Interval>,
) -> Option<(Trouble, Range<usize>)> {
    let fault = examined(tape, value)?;
    if fault.is_undefined {
        return Some((Trouble::Undefined, tape.range(fault.step)));
    }
    let (trouble, step) = disagreement(tape, jet)?;
    Some((trouble, tape.range(step)))
}

/// Whether a formula is certainly defined and its stress continuous at all states of some intervals.
pub(super) fn is_smooth(tape: &Tape, value: impl Fn(Leaf) -> Interval) -> bool {
    examined(tape, value).is_none()
}

/// What is not known of a number.
#[derive(Clone, Copy, Debug)]
struct Fault {
    /// Whether it may not exist; otherwise it is not known to be smooth.
    is_undefined: bool,
    /// The step from which it stems.
    step: usize,
}

fn examined(tape: &Tape, value: impl Fn(Leaf) -> Interval) -> Option<Fault> {
    let guarded = |leaf: Leaf| Guarded {
        bounds: value(leaf),
        fault: None,
    };
    tape.observed(guarded, &mut Examiner { tape, next: 0 })
        .fault
}

/// The side on which all of an interval certainly is; at zero itself it is on neither.
fn certain_side(test: Interval) -> Option<Side> {
    if test.high < 0.0 {
        Some(Side::Below)
    } else if test.low > 0.0 {
        Some(Side::Above)
    } else {
        None
    }
}

/// Marks results at the steps from which faults stem.
struct Examiner<'a> {
    tape: &'a Tape,
    /// The branch that comes next.
    next: usize,
}

/// A step that is not known yet.
const NOW: usize = usize::MAX;

impl Observer<Guarded> for Examiner<'_> {
    fn side(&mut self, _step: usize, test: &Guarded) -> Option<Side> {
        let is_undefined = test.fault.is_some_and(|fault| fault.is_undefined);
        certain_side(test.bounds).filter(|_| !is_undefined)
    }

    fn seen(&mut self, step: usize, result: &mut Guarded) {
        let branch = self.tape.branches().get(self.next);
        let branch = branch.filter(|branch| branch.step == step);
        self.next += usize::from(branch.is_some());
        let Some(fault) = result.fault.as_mut().filter(|fault| fault.step == NOW) else {
            return;
        };
        fault.step = step;
        if !fault.is_undefined && branch.is_some_and(|branch| branch.is_smooth) {
            result.fault = None;
        }
    }
}

/// Bounds of a number that know whether every operation behind them is defined on all of its operands.
#[derive(Clone, Copy, Debug)]
struct Guarded {
    bounds: Interval,
    fault: Option<Fault>,
}

/// Of two faults the graver one.
fn graver(a: Option<Fault>, b: Option<Fault>) -> Option<Fault> {
    match (a, b) {
        (Some(a), Some(b)) if b.is_undefined && !a.is_undefined => Some(b),
        (Some(a), _) => Some(a),
        (None, b) => b,
    }
}

impl Guarded {
    fn with(self, bounds: Interval, is_defined: bool) -> Self {
        let new = (!is_defined).then_some(Fault {
            is_undefined: true,
            step: NOW,
        });
        Self {
            bounds,
            fault: graver(self.fault, new),
        }
    }

    fn pair(self, other: Self, bounds: Interval) -> Self {
        Self {
            bounds,
            fault: graver(self.fault, other.fault),
        }
    }

    fn is_not_zero(self) -> bool {
        self.bounds.low > 0.0 || self.bounds.high < 0.0
    }
}

macro_rules! operators {
    ($($operator:ident $method:ident),*) => {
        $(
            impl $operator for Guarded {
                type Output = Self;
                fn $method(self, other: Self) -> Self {
                    self.pair(other, self.bounds.$method(other.bounds))
                }
            }
            impl $operator<f64> for Guarded {
                type Output = Self;
                fn $method(self, other: f64) -> Self {
                    self.with(self.bounds.$method(other), true)
                }
            }
        )*
    };
}
operators!(Add add, Sub sub, Mul mul);

impl Div for Guarded {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let quotient = self.pair(other, self.bounds / other.bounds);
        quotient.with(quotient.bounds, other.is_not_zero())
    }
}

impl Div<f64> for Guarded {
    type Output = Self;
    fn div(self, divisor: f64) -> Self {
        self.with(self.bounds / divisor, divisor != 0.0)
    }
}

impl Neg for Guarded {
    type Output = Self;
    fn neg(self) -> Self {
        self.with(-self.bounds, true)
    }
}

macro_rules! everywhere {
    ($($function:ident),*) => {
        $(
            fn $function(self) -> Self {
                self.with(self.bounds.$function(), true)
            }
        )*
    };
}

impl Real for Guarded {
    fn constant(value: f64) -> Self {
        Self {
            bounds: Interval::point(value),
            fault: None,
        }
    }
    fn value(self) -> f64 {
        self.bounds.value()
    }
    fn number(self) -> Option<f64> {
        None
    }
    fn blended(self, _threshold: f64, below: Self, above: Self) -> Self {
        let undecided = Fault {
            is_undefined: false,
            step: NOW,
        };
        let fault = graver(graver(self.fault, below.fault), above.fault);
        Self {
            bounds: below.bounds.hull(above.bounds),
            fault: graver(fault, Some(undecided)),
        }
    }
    fn recip(self) -> Self {
        self.with(self.bounds.recip(), self.is_not_zero())
    }
    fn sqrt(self) -> Self {
        self.with(self.bounds.sqrt(), self.bounds.low > 0.0)
    }
    fn ln(self) -> Self {
        self.with(self.bounds.ln(), self.bounds.low > 0.0)
    }
    everywhere!(exp, sin, cos, sinh, cosh, tanh);
    fn powi(self, exponent: i32) -> Self {
        let is_defined = exponent >= 0 || self.is_not_zero();
        self.with(self.bounds.powi(exponent), is_defined)
    }
    fn powf(self, exponent: f64) -> Self {
        self.with(self.bounds.powf(exponent), self.bounds.low > 0.0)
    }
}

/// Takes the sides that it is told where tests are undecided, and keeps in mind which were.
struct Chooser<'a> {
    tape: &'a Tape,
    next: usize,
    /// The first branches of tests that are alike, and whether the lower side is taken.
    choices: Vec<(usize, bool)>,
}

impl Observer<Jet<9, Interval>> for Chooser<'_> {
    fn side(&mut self, step: usize, test: &Jet<9, Interval>) -> Option<Side> {
        let branches = self.tape.branches();
        while branches.get(self.next).is_some_and(|b| b.step < step) {
            self.next += 1;
        }
        let decided = certain_side(test.value);
        let Some(&(first, factor)) = branches.get(self.next).map(|branch| &branch.alike) else {
            return decided;
        };
        decided.or_else(|| {
            let known = self.choices.iter().find(|(choice, _)| *choice == first);
            let is_below = known.is_some_and(|(_, is_below)| *is_below);
            if known.is_none() {
                self.choices.push((first, false));
            }
            Some(if is_below == (factor > 0.0) {
                Side::Below
            } else {
                Side::Above
            })
        })
    }
}

/// A jump or a kink of which bounds of value and stress on two sides are proof, with the branch that makes it.
fn disagreement(tape: &Tape, jet: impl Fn(Leaf) -> Jet<9, Interval>) -> Option<(Trouble, usize)> {
    let run = |choices: Vec<(usize, bool)>| {
        let mut chooser = Chooser {
            tape,
            next: 0,
            choices,
        };
        let energy = tape.observed(&jet, &mut chooser);
        (energy, chooser.choices)
    };
    let (base, mut choices) = run(Vec::new());
    let mut seen = 0;
    while seen < choices.len() {
        // Another side can lead to tests that were not met before.
        seen = choices.len();
        let count = if seen <= TOGETHER {
            1 << seen
        } else {
            seen + 1
        };
        for number in 1..count {
            let is_below = |n: usize| match seen <= TOGETHER {
                true => number >> n & 1 == 1,
                false => n + 1 == number,
            };
            let tried = (0..seen).map(|n| (choices[n].0, is_below(n))).collect();
            let (other, met) = run(tried);
            if let Some(trouble) = differs(&base, &other) {
                let changed = (0..seen).find(|n| is_below(*n)).unwrap_or(0);
                return Some((trouble, tape.branches()[choices[changed].0].step));
            }
            for new in met {
                if !choices.iter().any(|(known, _)| *known == new.0) {
                    choices.push((new.0, false));
                }
            }
        }
    }
    None
}

fn differs(a: &Jet<9, Interval>, b: &Jet<9, Interval>) -> Option<Trouble> {
    let apart = |a: &Interval, b: &Interval| a.high < b.low || b.high < a.low;
    if apart(&a.value, &b.value) {
        return Some(Trouble::Jump);
    }
    // A slope without bound has no tangent either.
    let mut slopes = a.gradient.iter().zip(&b.gradient);
    slopes
        .any(|(a, b)| apart(a, b) || !(a.is_finite() && b.is_finite()))
        .then_some(Trouble::Kink)
}
