//! Laws of rubber and foam fitted to test data, subject to stability where they are used.
//!
//! A law is fitted by least squares to tests with known stretches. Stability is a constraint of the fit: at every state of a [`Range`] Drucker's
//! inequality and strong ellipticity hold with a margin. Both are linear in the moduli of a law, so that for laws without other constants the problem
//! is convex and its optimum is global. The range has infinitely many states. The fit is therefore solved for a few states, the worst state of the
//! result is added, and the fit is repeated. Finally, interval arithmetic proves that no state of the range was missed.
//!
//! - [`Family`]: the laws that can be fitted, as functions of the principal stretches and of their constants.
//! - [`Test`]: measured points of a specimen.
//! - [`Range`], [`Criterion`]: states at which the law must be stable, and the sense of stability.
//! - [`fit()`]: the fit.
//!
//! The crate neither reads files nor prints; its callers do.

mod family;
mod fit;
mod moduli;
mod proof;
mod range;
mod solve;
mod sums;
mod tests_of_specimens;
mod uncertainty;

pub use family::{Constant, Family, Model};
pub use fit::{Fit, FitError, Fitted, Options, Weights, fit};
pub use moduli::Criterion;
pub use proof::Proof;
pub use range::{Mode, Range, Worst, limits};
pub use tests_of_specimens::{Misfit, Point, Test};
pub use uncertainty::Uncertainty;
