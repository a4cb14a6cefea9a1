//! Eigenvalues of small matrices and minima of trigonometric polynomials, with bounded loops.

mod cholesky;
mod decomposition;
mod deviator;
mod directions;
mod eigen;
mod gauss;
mod jacobi;
mod lowest;
mod pack;
mod parts;
mod random;
mod schur;
mod sort;
mod symmetric;
mod trigonometric;
mod turn;
mod unit;
mod zeros;

pub(crate) use cholesky::{cholesky_factor, factorize};
pub(crate) use decomposition::{
    Decomposition, any_eigenvalues, hermitian_eigen, hermitian_eigenvalues,
};
pub(crate) use deviator::Deviator;
pub(crate) use directions::directions;
pub(crate) use eigen::{MAXIMUM_ITERATIONS, normalized, without_rounding};
pub use eigen::{eigenvalues, eigenvector, left_eigenvector};
pub(crate) use gauss::unit_interval;
pub(crate) use jacobi::{Pair, ROTATED_ROWS, diagonalize};
pub(crate) use lowest::lowest_between;
pub(crate) use pack::{LARGEST_LANES, Mask, Pack};
pub(crate) use parts::Parts;
pub use random::uniform;
pub(crate) use schur::{Eigenvectors, times, triangular};
pub(crate) use sort::sort_by_value;
pub(crate) use symmetric::{is_positive_definite, symmetric_eigen};
pub use trigonometric::TrigonometricPolynomial;
pub(crate) use turn::sines_and_cosines;
pub(crate) use unit::moderate_unit;
pub(crate) use zeros::Zeros;

pub(crate) use crate::real::{Each, array_of};

/// Complex number type of the whole crate.
pub type Complex = nalgebra::Complex<f64>;
