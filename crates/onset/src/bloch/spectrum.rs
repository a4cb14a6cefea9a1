//! Results of a search over the Brillouin zone.

use super::growth_rate;
use crate::algebra::Complex;
use crate::continuum::AcousticMinimum;
use nalgebra::SVector;

/// A plane-wave mode of the discretization.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode<const D: usize> {
    /// Reference wave vector; in the long-wave limit its unit direction. 1/length.
    pub wave_vector: SVector<f64, D>,
    /// True in the limit `k -> 0`.
    pub is_long_wave: bool,
    /// `omega^2`; zero in the long-wave limit. 1/time^2.
    pub omega_squared: Complex,
    /// Scaled measure `Re omega^2 / (c^2 |k|_h^2)`: dimensionless, and finite in the long-wave limit.
    pub scaled: f64,
    /// Unit polarization `g`; its largest component is real and positive.
    pub polarization: SVector<Complex, D>,
}

/// The extremes of the spectrum over the zone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectrumSummary<const D: usize> {
    /// Mode with the smallest scaled measure `mu`.
    ///
    /// If a mode grows at `k = 0`, `mu` has no minimum, because `|k|_h` vanishes there. This happens when a translation strains the body (raw weights
    /// on a distorted lattice), or when the particles of a cell move apart. The field is then the mode with the smallest `Re omega^2`, scaled with
    /// the largest `c^2 |k|_h^2` of all wave vectors.
    pub softest: Mode<D>,
    /// Softest mode of the long-wave limit.
    pub long_wave: Mode<D>,
    /// Mode with the smallest `Re omega^2`; the translation `k = 0` if no `Re omega^2` is negative.
    pub lowest: Mode<D>,
    /// Mode with the largest growth rate; equal to `lowest` unless `omega^2` is complex for some wave vector.
    pub fastest_growing: Mode<D>,
    /// Largest frequency `max sqrt(Re omega^2)`. 1/time.
    pub maximum_omega: f64,
    /// Scaled measures with a magnitude below this tolerance are zero to rounding.
    pub tolerance: f64,
    /// Lower bound of the scaled measure over all wave vectors and the long-wave limit; minus infinity if no bound was computed.
    ///
    /// If `D(k)` is not Hermitian, it bounds the Hermitian part of `D(k)`, and `softest` is a sampled minimum.
    pub bound: f64,
    /// True if modes with complex `omega^2` grow.
    pub flutters: bool,
    /// True if modes with complex `omega^2` grow in the long-wave limit.
    pub long_waves_flutter: bool,
}

/// Kind of stability of a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stability {
    /// No mode of the discretization grows.
    Stable,
    /// Some modes oscillate with growing amplitude: `omega^2` is complex, and its real part is nonnegative for all waves.
    Flutter,
    /// Some modes have `Re omega^2 < 0`.
    Divergence,
}

/// Stability of a state, reduced to the quantities that determine a verdict.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Judgment<const D: usize> {
    pub(crate) stability: Stability,
    /// Scaled measure whose sign decides stability if the spectrum is real: the measure of the softest wave, or of a witness of instability.
    pub(crate) measure: f64,
    /// Wave vector of a wave with `Re omega^2 < 0`; `None` if the long-wave limit already proves divergence.
    pub(crate) witness: Option<SVector<f64, D>>,
    /// Softest mode of a stable state, if its scaled measure is at most the requested limit.
    pub(crate) softest: Option<Mode<D>>,
}

impl<const D: usize> Mode<D> {
    /// Returns the mode with `omega^2` multiplied by `unit`.
    pub(super) fn in_units(self, unit: f64) -> Self {
        Self {
            omega_squared: self.omega_squared * unit,
            ..self
        }
    }
}

impl<const D: usize> SpectrumSummary<D> {
    /// Returns the summary with every `omega^2` multiplied by `unit`.
    pub(super) fn in_units(self, unit: f64) -> Self {
        Self {
            softest: self.softest.in_units(unit),
            long_wave: self.long_wave.in_units(unit),
            lowest: self.lowest.in_units(unit),
            fastest_growing: self.fastest_growing.in_units(unit),
            maximum_omega: self.maximum_omega * unit.sqrt(),
            ..self
        }
    }

    /// Returns whether a mode grows, and its mechanism.
    pub fn stability(&self) -> Stability {
        if self.softest.scaled < -self.tolerance || self.lowest.omega_squared.re < 0.0 {
            Stability::Divergence
        } else if self.flutters {
            Stability::Flutter
        } else {
            Stability::Stable
        }
    }

    /// Returns true if modes grow in the long-wave limit. Flutter counts only if the waves of the material also grow by flutter alone.
    pub fn long_waves_grow(&self, material: &AcousticMinimum<D>) -> bool {
        self.long_wave.scaled < -self.tolerance
            || (material.only_flutters() && self.long_waves_flutter)
    }

    /// Returns true if no mode grows.
    pub fn is_stable(&self) -> bool {
        self.stability() == Stability::Stable
    }

    /// Growth rate of the fastest growing mode; zero for a stable state. 1/time.
    pub fn growth_rate(&self) -> f64 {
        if self.is_stable() {
            0.0
        } else {
            growth_rate(self.fastest_growing.omega_squared)
        }
    }

    /// Critical time step of central differences without damping, `2 / omega_max`. Time.
    pub fn critical_time_step(&self) -> f64 {
        2.0 / self.maximum_omega
    }
}
