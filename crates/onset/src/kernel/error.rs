//! Why a text is no kernel.

use crate::formula::{FormulaError, Problem};
use thiserror::Error;

/// Why a text is neither the name of a kernel nor a formula of one.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum KernelError {
    /// A word that no kernel is called.
    #[error("there is no kernel `{name}`; expected {} or a formula of q", names())]
    UnknownName {
        /// As typed.
        name: String,
    },
    /// The formula cannot be read.
    #[error("{}", read(.0))]
    Formula(FormulaError),
    /// The profile is not a number somewhere.
    #[error(
        "the kernel is not finite at q = {q}\n  hint: it must be defined for 0 <= q <= 1, q = |x| / R0"
    )]
    NotFinite {
        /// Where; distance over support radius.
        q: f64,
    },
    /// The profile is not positive at the origin.
    #[error("the kernel is {value} at q = 0; it must be positive there")]
    NotPositive {
        /// The value at the origin.
        value: f64,
    },
    /// The profile does not end at the rim.
    #[error(
        "the kernel is {value} at q = 1; it must vanish there, for neighbors enter and leave at the rim\n  \
         hint: multiply by (1 - q)^3, so that slope and curvature vanish as well"
    )]
    NotZeroAtRim {
        /// The value at the rim.
        value: f64,
    },
    /// The profile or its slope jumps within the support.
    #[error(
        "the kernel or its slope jumps at q = {q}\n  hint: join the parts with equal value and slope"
    )]
    Jump {
        /// Where; distance over support radius.
        q: f64,
    },
    /// The integral over space is not positive.
    #[error("the integral of the kernel over {dimension}D space is {value}; it must be positive")]
    IntegralNotPositive {
        /// Number of space dimensions.
        dimension: usize,
        /// The integral for a support radius of one.
        value: f64,
    },
}

fn names() -> String {
    super::Kernel::ALL.map(super::Kernel::name).join(", ")
}

/// What is wrong with a formula, where, and what to do.
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
