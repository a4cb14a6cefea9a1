//! Eigenvalues of small matrices and minima of trigonometric polynomials, with bounded loops.

mod eigen;
mod golden;
mod pack;
mod symmetric;
mod trigonometric;
mod unit;
mod well;

pub(crate) use eigen::MAXIMUM_ITERATIONS;
pub use eigen::{eigenvalues, eigenvector, left_eigenvector};
pub(crate) use golden::GoldenSection;
pub(crate) use pack::{Mask, Pack, WIDEST};
pub(crate) use symmetric::{is_positive_definite, symmetric_eigen};
pub use trigonometric::TrigonometricPolynomial;
pub(crate) use unit::moderate_unit;
pub(crate) use well::{is_well, settled, settled_along};

/// Complex numbers of the whole crate.
pub type Complex = nalgebra::Complex<f64>;
