//! Domain of a formula: the states with an energy, and the states with a stress.
//!
//! The operations are evaluated with intervals, so that rounding is included. At the boundary of its domain a function has no derivative and counts
//! as undefined. An undefined part invalidates everything computed from it, unless it is in a branch that is not taken. If the sign of a test is
//! uncertain, the formula is evaluated on both sides. If the values certainly differ, the energy has a jump; if the first derivatives differ, it has
//! a kink. A part that is undefined on one of the sides has no derivative there.

use super::Trouble;
use super::graph::Leaf;
use super::tape::{Observer, Tape};
use crate::real::{Interval, Jet, Real, Side};
use std::ops::{Add, Div, Mul, Neg, Range, Sub};

/// Largest number of uncertain tests for which all combinations of sides are tried. Beyond it the tests are varied one at a time.
const MAX_COMBINED_TESTS: usize = 6;

/// Returns the reason why a formula has no stress at a state, with its position in the text.
///
/// `value` gives bounds of the leaves, and `jet` these bounds with derivatives with respect to the deformation gradient.
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

/// Returns true if a formula is certainly defined, with continuous stress, at all states of some intervals.
pub(super) fn is_smooth(tape: &Tape, value: impl Fn(Leaf) -> Interval) -> bool {
    examined(tape, value).is_none()
}

/// Possible defect of a number.
#[derive(Clone, Copy, Debug)]
struct Fault {
    /// Whether the number may be undefined; otherwise it may not be smooth.
    is_undefined: bool,
    /// Step that causes the defect.
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

/// Side of zero that certainly contains an interval; `None` if the interval contains zero.
fn certain_side(test: Interval) -> Option<Side> {
    if test.high < 0.0 {
        Some(Side::Below)
    } else if test.low > 0.0 {
        Some(Side::Above)
    } else {
        None
    }
}

/// Observer that marks results at the steps that cause defects.
struct Examiner<'a> {
    tape: &'a Tape,
    /// Index of the next branch.
    next: usize,
}

/// Placeholder for a step that is not yet known.
const PENDING_STEP: usize = usize::MAX;

impl Observer<Guarded> for Examiner<'_> {
    fn side(&mut self, _step: usize, test: &Guarded) -> Option<Side> {
        let is_undefined = test.fault.is_some_and(|fault| fault.is_undefined);
        certain_side(test.bounds).filter(|_| !is_undefined)
    }

    fn seen(&mut self, step: usize, result: &mut Guarded) {
        let branch = self.tape.branches().get(self.next);
        let branch = branch.filter(|branch| branch.step == step);
        self.next += usize::from(branch.is_some());
        let Some(fault) = result
            .fault
            .as_mut()
            .filter(|fault| fault.step == PENDING_STEP)
        else {
            return;
        };
        fault.step = step;
        if !fault.is_undefined && branch.is_some_and(|branch| branch.is_smooth) {
            result.fault = None;
        }
    }
}

/// Bounds of a computed number, with the defects of its operations.
#[derive(Clone, Copy, Debug)]
struct Guarded {
    bounds: Interval,
    fault: Option<Fault>,
}

/// The more serious of two defects: undefined is more serious than not smooth.
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
            step: PENDING_STEP,
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
            step: PENDING_STEP,
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

/// Observer that takes prescribed sides where tests are uncertain, and records these tests.
struct Chooser<'a> {
    tape: &'a Tape,
    next: usize,
    /// First branch of each group of equivalent tests, and whether the lower side is taken.
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

/// Jump or kink proved by disjoint bounds of value or stress on two sides, with the branch that causes it.
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
        // Another side can lead to tests that were not reached before.
        seen = choices.len();
        let count = if seen <= MAX_COMBINED_TESTS {
            1 << seen
        } else {
            seen + 1
        };
        for number in 1..count {
            let is_below = |n: usize| match seen <= MAX_COMBINED_TESTS {
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
    // An unbounded slope has no tangent either.
    let mut slopes = a.gradient.iter().zip(&b.gradient);
    slopes
        .any(|(a, b)| apart(a, b) || !(a.is_finite() && b.is_finite()))
        .then_some(Trouble::Kink)
}
