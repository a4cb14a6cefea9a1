//! Modes as they are reported.

use super::Sweep;
use crate::algebra::Complex;
use crate::bloch::{Mode, growth_rate};
use nalgebra::{DVector, SVector};

impl<const D: usize> Sweep<'_, D> {
    /// Mode with the lowest `Re omega^2` at a wave vector.
    pub(super) fn mode(&self, k: &SVector<f64, D>) -> Mode<D> {
        let k = self.search.folded(k);
        self.shown(&k, |values| (!values.is_empty()).then_some(0))
    }

    /// Fastest growing mode with complex `omega^2` at a wave vector.
    pub(super) fn fluttering(&self, k: &SVector<f64, D>) -> Mode<D> {
        let k = self.search.folded(k);
        self.shown(&k, |values| {
            let complex = (0..values.len()).filter(|n| values[*n].im != 0.0);
            complex.max_by(|a, b| growth_rate(values[*a]).total_cmp(&growth_rate(values[*b])))
        })
    }

    /// Mode at a wave vector that `chosen` selects from the values of `omega^2`.
    pub(super) fn shown(
        &self,
        k: &SVector<f64, D>,
        chosen: impl Fn(&[Complex]) -> Option<usize>,
    ) -> Mode<D> {
        let modes = self
            .system
            .modes_of(k, |values| chosen(values).into_iter().collect());
        let mode = modes.into_iter().next();
        let (omega_squared, displacements) = mode.unwrap_or_else(|| no_mode(self.system.size()));
        Mode {
            wave_vector: *k,
            is_long_wave: false,
            omega_squared,
            scaled: self.scaled(k, omega_squared.re),
            polarization: largest_of_particles(&displacements),
        }
    }
}

/// Displacement of the particle with the largest amplitude, scaled to unit length.
pub(super) fn largest_of_particles<const D: usize>(
    displacements: &DVector<Complex>,
) -> SVector<Complex, D> {
    let mut best = SVector::<Complex, D>::zeros();
    for start in (0..displacements.len()).step_by(D) {
        let own = SVector::<Complex, D>::from_fn(|i, _| displacements[start + i]);
        if own.norm() > best.norm() * (1.0 + 1e-9) {
            best = own;
        }
    }
    best.try_normalize(0.0).unwrap_or(best)
}

/// Mode of NaN values for an eigenvalue iteration that has not converged.
fn no_mode(size: usize) -> (Complex, DVector<Complex>) {
    let nan = Complex::new(f64::NAN, f64::NAN);
    (nan, DVector::repeat(size, nan))
}
