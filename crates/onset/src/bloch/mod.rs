//! Plane waves on the lattice: the dynamical matrix and its spectrum over the Brillouin zone.
//!
//! This is the only module in which the material and the discretization meet. A wave `u_K = g exp(i k.X_K)` of the linearized discrete equations
//! satisfies `D(k) g = omega^2 g`. Wave vectors `k` belong to the reference lattice, and phases are computed from relative positions.
//!
//! - [`dynamical_matrix()`] and [`WaveSystem`] set up `D(k)`, for one or several particles in a cell.
//! - [`ZoneSearch`] finds the extremes of `omega^2` over the zone by samples and Newton descents. For Hermitian, periodic `D(k)` it also computes a
//!   lower bound of the scaled measure `omega^2 / (c^2 |k|_h^2)` by branch and bound; all other results are sampled.
//! - [`GradientMoments`] computes sampled extremes for all states of a map with one planar Lagrangian kernel method.

mod assembly;
mod bound;
mod branches;
mod dynamical_matrix;
mod mirror;
mod moments;
mod planar;
mod pocket;
mod powers;
mod relaxing;
mod representative;
mod search;
mod short_range;
mod spatial;
mod spectrum;
mod system;
mod transferred;

pub(crate) use assembly::Local;
use assembly::moment_matrix;
pub use assembly::{dynamical_matrix, gradient_norm};
pub use dynamical_matrix::{DynamicalMatrix, Expansion};
pub use moments::{GradientMoments, MomentExtremes};
pub use relaxing::RelaxingWaves;
pub(crate) use representative::StateWave;
pub use search::ZoneSearch;
pub(crate) use search::{is_well, settled, settled_along};
pub(crate) use spectrum::Judgment;
pub use spectrum::{Mode, SpectrumSummary, Stability};
pub use system::{BlochBlocks, BlochSum, Mass, WaveSystem};
pub(crate) use transferred::ZERO_FREQUENCY_NOISE_FACTOR;
pub use transferred::{TransferredWaves, VelocityFilter};

use crate::algebra::Complex;
use nalgebra::SVector;

/// Largest squared gradient norm of a zero-energy mode, in units of `|k|^2`. Well above its rounding error, about 1e-16.
pub(crate) const ZERO_ENERGY: f64 = 1e-10;

/// Returns true if `-k` is reported in place of `k`. Both have the same waves; the wave vector with a positive leading component is reported.
pub(crate) fn is_shown_reversed<const D: usize>(k: &SVector<f64, D>) -> bool {
    let leading = k.iter().find(|x| x.abs() > 1e-9 * k.amax());
    leading.is_some_and(|x| *x < 0.0)
}

/// Growth rate of a mode: `-Im omega` of the growing root, `sqrt((|w| - Re w) / 2)` for `w = omega^2`.
///
/// It is `sqrt(-omega^2)` for a negative and zero for a positive real `omega^2`. Unit 1/time.
///
/// ```
/// use onset::bloch::growth_rate;
/// use onset::algebra::Complex;
/// assert_eq!(growth_rate(Complex::new(-4.0, 0.0)), 2.0);
/// assert_eq!(growth_rate(Complex::new(4.0, 0.0)), 0.0);
/// assert!((growth_rate(Complex::new(3.0, 4.0)) - 1.0).abs() < 1e-15);
/// ```
pub fn growth_rate(omega_squared: Complex) -> f64 {
    (0.5 * (omega_squared.norm() - omega_squared.re))
        .max(0.0)
        .sqrt()
}
