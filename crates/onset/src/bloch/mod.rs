//! Plane waves on the lattice: the dynamical matrix and its spectrum over the Brillouin zone.
//!
//! Here, and only here, physics and discretization meet. A wave `u_K = g exp(i k.X_K)` of the linearized
//! discrete equations obeys `D(k) g = omega^2 g`; wave vectors `k` are reference wave vectors and phases
//! are those of relative positions.

mod assembly;
mod bound;
mod branches;
mod dynamical_matrix;
mod mirror;
mod moments;
mod planar;
mod pocket;
mod powers;
mod representative;
mod search;
mod short_range;
mod spatial;
mod spectrum;
mod system;

pub(crate) use assembly::Local;
use assembly::moment_matrix;
pub use assembly::{dynamical_matrix, gradient_norm};
pub use dynamical_matrix::{DynamicalMatrix, Expansion};
pub use moments::{GradientMoments, MomentExtremes};
pub(crate) use representative::StateWave;
pub use search::ZoneSearch;
pub(crate) use spectrum::Judgment;
pub use spectrum::{Mode, SpectrumSummary, Stability};
pub use system::{BlochBlocks, BlochSum, Mass, WaveSystem};

use crate::algebra::Complex;
use nalgebra::SVector;

/// A squared gradient norm (in units of `|k|^2`) below which a mode counts as free of energy.
pub(crate) const ZERO_ENERGY: f64 = 1e-10;

/// Whether nobody waits for an answer any more, asked again and again while it is sought; once it is so it stays so. What a search returns
/// then is not an answer.
pub type IsEnded<'a> = &'a (dyn Fn() -> bool + Sync);

/// Whether `-k` stands for a wave vector and its opposite, which have the same waves: the one with a positive leading component.
fn is_shown_reversed<const D: usize>(k: &SVector<f64, D>) -> bool {
    let leading = k.iter().find(|x| x.abs() > 1e-9 * k.amax());
    leading.is_some_and(|x| *x < 0.0)
}

/// The growth rate of a mode, `-Im omega` of the growing root: `sqrt((|w| - Re w) / 2)` for `w = omega^2`.
/// It is `sqrt(-omega^2)` for a negative and zero for a positive real `omega^2`. 1/time.
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
