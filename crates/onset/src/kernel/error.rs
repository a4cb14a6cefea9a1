//! Errors of kernels that are given as text.

use crate::formula::{FormulaError, Problem};
use thiserror::Error;

/// Error for a string that is neither the name of a kernel nor a valid formula.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum KernelError {
    /// The name does not belong to any kernel.
    #[error("there is no kernel `{name}`; expected {} or a formula of q", names())]
    UnknownName {
        /// Name as entered by the user.
        name: String,
    },
    /// The formula cannot be parsed.
    #[error("{}", read(.0))]
    Formula(FormulaError),
    /// The profile is not finite at some distance.
    #[error(
        "the kernel is not finite at q = {q}\n  hint: the formula must be defined for 0 <= q <= 1, q = |x| / R0"
    )]
    NotFinite {
        /// Distance at which it is not finite, in units of the support radius.
        q: f64,
    },
    /// The profile is not positive at the origin.
    #[error("the kernel is {value} at q = 0; it must be positive there")]
    NotPositive {
        /// Value of the profile at the origin.
        value: f64,
    },
    /// The profile does not vanish at the rim.
    #[error(
        "the kernel is {value} at q = 1; it must vanish there, because neighbors enter and leave at the rim\n  \
         hint: multiply by (1 - q)^3, so that slope and curvature vanish as well"
    )]
    NotZeroAtRim {
        /// Value of the profile at the rim.
        value: f64,
    },
    /// The profile or its slope jumps within the support.
    #[error(
        "the kernel or its slope jumps at q = {q}\n  hint: join the parts with equal value and slope"
    )]
    Jump {
        /// Distance of the jump, in units of the support radius.
        q: f64,
    },
    /// The integral over space is not positive.
    #[error("the integral of the kernel over {dimension}D space is {value}; it must be positive")]
    IntegralNotPositive {
        /// Number of space dimensions.
        dimension: usize,
        /// Integral for a support radius of one.
        value: f64,
    },
}

fn names() -> String {
    super::Kernel::ALL.map(super::Kernel::name).join(", ")
}

/// Message for an invalid formula: the problem, its position, and a remedy.
fn read(error: &FormulaError) -> String {
    let place = match &error.place {
        Some(place) => format!("kernel, {place}: {}\n{}", error.problem, place.marked()),
        None => format!("kernel: {}", error.problem),
    };
    match error.problem {
        Problem::Empty => format!("{place}\n  hint: for example (1 - q)^4*(1 + 4*q)"),
        _ => match error.problem.hint() {
            Some(hint) => format!("{place}\n  hint: {hint}"),
            None => place,
        },
    }
}
