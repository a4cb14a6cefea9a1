//! Waves that need no search: the limit of long waves, and the modes at `k = 0`.

use super::{ROUNDING_FACTOR, Sweep};
use crate::algebra::{Complex, Each, lowest_between};
use crate::bloch::Mode;
use nalgebra::SVector;
use std::convert::Infallible;

/// Tolerance, in octaves, of the wave number of the fastest growing long wave.
const PEAK_TOLERANCE_OCTAVES: f64 = 1e-5;
/// Number of wave numbers tested for growth, two octaves apart.
const TESTED_WAVE_NUMBERS: i32 = 5;
/// Noise factor: at the smallest wave number tested for growth, the long-wave limit predicts this multiple of the rounding error.
const LONG_WAVE_NOISE_FACTOR: f64 = 8.0;

/// Results that need no search: the long-wave limit and `k = 0`.
pub(super) struct LongWaves<const D: usize> {
    pub(super) mode: Mode<D>,
    pub(super) rest: Mode<D>,
    /// Tolerance of scaled measures at finite wave vectors; smaller magnitudes are zero to rounding.
    pub(super) tolerance: f64,
    /// Tolerance of scaled measures in the long-wave limit, which includes the relaxation of the particles of a cell.
    pub(super) of_limit: f64,
}

impl<const D: usize> Sweep<'_, D> {
    pub(super) fn long_waves(&self) -> LongWaves<D> {
        let mut mode = self.search.long_wave_mode(&self.stiffness);
        let at_gamma = self.at_gamma.iter().map(|value| value.re);
        let least = at_gamma.fold(f64::INFINITY, f64::min);
        let strains = self.system.rigid_translation().amax() > 0.0;
        if strains && least >= -ROUNDING_FACTOR * self.system.noise() {
            // A translation that raises the energy excludes long waves of vanishing frequency. Free modes near it are found at finite wave vectors.
            mode.scaled = f64::INFINITY;
        }
        let [tolerance, mut of_limit] = self
            .long_wave_noise
            .each(|noise| self.search.measure_of_noise(noise));
        if mode.scaled < -of_limit && !self.is_followed(&mode) {
            of_limit = -mode.scaled;
        }
        LongWaves {
            mode,
            rest: self.rest(mode.scaled),
            tolerance,
            of_limit,
        }
    }

    /// Smallest wave number, along the direction of a negative long-wave limit, at which growth exceeds rounding; and the lowest `Re omega^2` as a
    /// function of octaves above this wave number.
    fn smallest_tested(&self, limit: &Mode<D>) -> (f64, impl Fn(f64) -> f64) {
        let stiffness = -limit.scaled * self.search.speed_squared();
        let longest =
            (LONG_WAVE_NOISE_FACTOR * ROUNDING_FACTOR * self.system.noise() / stiffness).sqrt();
        let direction = limit.wave_vector.normalize();
        let lowest = move |octaves: f64| {
            let k = direction * (longest * octaves.exp2());
            let values = self.system.omega_squared(&k).into_iter();
            values.map(|value| value.re).fold(f64::INFINITY, f64::min)
        };
        (longest, lowest)
    }

    /// Returns true if finite waves grow along a direction of negative long-wave stiffness.
    fn is_followed(&self, limit: &Mode<D>) -> bool {
        let (_, lowest) = self.smallest_tested(limit);
        let noise = ROUNDING_FACTOR * self.system.noise();
        (0..TESTED_WAVE_NUMBERS).any(|n| lowest(f64::from(2 * n)) < -noise)
    }

    /// Fastest growing wave along a direction of negative long-wave stiffness, among waves longer than the grid resolves. Particles of a cell that
    /// barely resist relative motion relax only in such long waves.
    pub(super) fn growing_long_wave(&self, limit: &Mode<D>) -> Option<Mode<D>> {
        let (longest, lowest) = self.smallest_tested(limit);
        let step = self.search.reference().reciprocal().column(0).norm();
        let octaves = (step / self.waves.resolution() as f64 / longest).log2();
        let values = (0..=octaves as usize).map(|n| (lowest(n as f64), n as f64));
        let (value, best) = values.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let at = |octaves: f64| Ok::<f64, Infallible>(lowest(octaves));
        let Ok((octaves, _)) = lowest_between(
            at,
            [best - 1.0, best, best + 1.0],
            value,
            PEAK_TOLERANCE_OCTAVES,
        );
        let k = limit.wave_vector.normalize() * (longest * octaves.exp2());
        let mode = self.mode(&k);
        (mode.omega_squared.re < -ROUNDING_FACTOR * self.system.noise()).then_some(mode)
    }

    /// Mode with the lowest `Re omega^2` at `k = 0`. This is the translation, with the given scaled measure, unless a mode grows there.
    pub(super) fn rest(&self, scaled: f64) -> Mode<D> {
        let lowest = self.at_gamma.iter().map(|value| value.re);
        let lowest = lowest.fold(f64::INFINITY, f64::min);
        let threshold = self.search.flutter_threshold(self.system.sites()).powi(2);
        if lowest < -threshold.max(ROUNDING_FACTOR * self.system.noise()) {
            return self
                .search
                .over_largest_laplacian(self.mode(&SVector::zeros()));
        }
        Mode {
            wave_vector: SVector::zeros(),
            is_long_wave: false,
            omega_squared: Complex::new(0.0, 0.0),
            scaled,
            polarization: SVector::from_fn(|i, _| Complex::new(f64::from(u8::from(i == 0)), 0.0)),
        }
    }
}
