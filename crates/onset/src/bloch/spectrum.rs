//! The answers of a search over the zone.

use super::growth_rate;
use crate::algebra::Complex;
use crate::continuum::AcousticMinimum;
use nalgebra::SVector;

/// A plane-wave mode of the discretization.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode<const D: usize> {
    /// Reference wave vector; in the long-wave limit its unit direction. 1/length.
    pub wave_vector: SVector<f64, D>,
    /// Whether this is the limit of long waves.
    pub is_long_wave: bool,
    /// `omega^2`; zero in the long-wave limit. 1/time^2.
    pub omega_squared: Complex,
    /// `Re omega^2 / (c^2 |k|_h^2)`, dimensionless, finite also in the long-wave limit.
    pub scaled: f64,
    /// Unit polarization `g`; its largest component is real and positive.
    pub polarization: SVector<Complex, D>,
}

/// The extremes of the spectrum over the zone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectrumSummary<const D: usize> {
    /// The mode with the smallest scaled measure `mu`: the softest one. Where a mode grows at `k = 0` (a translation that strains the
    /// body, with raw weights on a distorted lattice, or particles of a cell that part) `mu` has no minimum. Then this is the mode
    /// with the smallest `Re omega^2`, scaled with the largest `c^2 |k|_h^2` of all wave vectors.
    pub softest: Mode<D>,
    /// The softest mode of the long-wave limit.
    pub long_wave: Mode<D>,
    /// The mode with the smallest `Re omega^2`; the translation `k = 0` when none is below zero.
    pub lowest: Mode<D>,
    /// The mode that grows fastest; the same as `lowest` unless `omega^2` is complex somewhere.
    pub fastest_growing: Mode<D>,
    /// `max sqrt(Re omega^2)`. 1/time.
    pub maximum_omega: f64,
    /// `|scaled|` below this is zero to rounding.
    pub tolerance: f64,
    /// No scaled measure of any wave vector, nor of the limit of long waves, is below this; minus infinity where nothing
    /// bounds them. Of equations that are not Hermitian it is the bound of their Hermitian part, and `softest` the softest mode that a search has found.
    pub bound: f64,
    /// Whether modes grow with a complex `omega^2`.
    pub flutters: bool,
    /// Whether they do so in the limit of long waves.
    pub long_waves_flutter: bool,
}

/// How perturbations develop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stability {
    /// None grows.
    Stable,
    /// Some oscillate with growing amplitude: `omega^2` is complex, its real part nowhere negative.
    Flutter,
    /// Some have `Re omega^2 < 0`.
    Divergence,
}

/// How perturbations develop, as far as a verdict asks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Judgment<const D: usize> {
    pub(crate) stability: Stability,
    /// Where the spectrum is real, its sign tells stability: the scaled measure of the softest wave, of an unstable state that of a witness.
    pub(crate) measure: f64,
    /// The wave vector of a wave with `Re omega^2 < 0`, unless long waves tell that some have it.
    pub(crate) witness: Option<SVector<f64, D>>,
    /// The softest mode of a stable state that is no stiffer than was asked about.
    pub(crate) softest: Option<Mode<D>>,
}

impl<const D: usize> Mode<D> {
    /// The same with `omega^2` multiplied by a unit.
    pub(super) fn in_units(self, unit: f64) -> Self {
        Self {
            omega_squared: self.omega_squared * unit,
            ..self
        }
    }
}

impl<const D: usize> SpectrumSummary<D> {
    /// The same with `omega^2` multiplied by a unit.
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

    /// Whether a mode grows, and how.
    pub fn stability(&self) -> Stability {
        if self.softest.scaled < -self.tolerance || self.lowest.omega_squared.re < 0.0 {
            Stability::Divergence
        } else if self.flutters {
            Stability::Flutter
        } else {
            Stability::Stable
        }
    }

    /// Whether modes grow in the limit of long waves, by flutter only where that is how waves of the material grow.
    pub fn long_waves_grow(&self, material: &AcousticMinimum<D>) -> bool {
        self.long_wave.scaled < -self.tolerance
            || (material.only_flutters() && self.long_waves_flutter)
    }

    /// Whether no mode grows.
    pub fn is_stable(&self) -> bool {
        self.stability() == Stability::Stable
    }

    /// The growth rate of the fastest growing mode, zero when stable. 1/time.
    pub fn growth_rate(&self) -> f64 {
        if self.is_stable() {
            0.0
        } else {
            growth_rate(self.fastest_growing.omega_squared)
        }
    }

    /// The critical time step of central differences without damping, `2 / omega_max`.
    pub fn critical_time_step(&self) -> f64 {
        2.0 / self.maximum_omega
    }
}
