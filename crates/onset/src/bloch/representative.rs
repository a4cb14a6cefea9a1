//! Choice of one wave among all waves of equal measure.
//!
//! In a symmetric lattice several wave vectors share an extreme value, and a search can end at any of them. The reported mode follows from a rule
//! that does not depend on the search:
//!
//! 1. The long-wave limit comes before all waves that are as soft.
//! 2. Halves of reciprocal vectors come before other wave vectors, and short wave vectors before long ones, also among all zero-energy modes, and on
//!    lines and planes of equal waves. Relative motions of the particles of a cell, at `k = 0`, come last.
//! 3. Among wave vectors of equal length, the first in the order of Cartesian components is taken, with the largest component first.
//! 4. Among equal frequencies at this wave vector, the mode with the largest share along the wave is taken.

use super::search::LONG_WAVE_FRACTION;
use super::{Mode, SpectrumSummary, ZoneSearch, growth_rate};
use crate::algebra::{Complex, MAXIMUM_ITERATIONS, eigenvalues, normalized};
use crate::continuum::{ACOUSTIC_ROUNDING, Stiffness};
use crate::lattice::{Equivalence, shorter_first};
use nalgebra::{DMatrix, DVector, SMatrix, SVector};

/// Relative rounding error of measures, and rounding error of squared frequencies relative to the largest.
pub(super) const MEASURE_ROUNDING: f64 = 1e-9;
/// Accuracy of wave vectors and measures found by a search, relative to a reciprocal vector and to the measure.
const SEARCH_ACCURACY: f64 = 1e-6;
/// Largest wave number, as a fraction of a reciprocal vector, of a wave that can represent the long-wave limit.
const LIMIT_WAVE_FRACTION: f64 = 0.02;
/// Largest number of degrees of freedom of a cell for which symmetric images are computed; larger cells have no symmetry.
const IMAGED_CELL_SIZE: usize = 48;
/// Smallest component of a unit vector in the space of equal modes that determines a polarization.
const POLARIZATION_SHARE: f64 = 1e-3;

/// Waves of a state, as functions of the wave vector.
pub(crate) struct StateWave<'a, const D: usize> {
    pub(crate) omega_squared: &'a dyn Fn(&SVector<f64, D>) -> Vec<Complex>,
    pub(crate) matrix: &'a dyn Fn(&SVector<f64, D>) -> DMatrix<Complex>,
    pub(crate) long_waves: &'a dyn Fn() -> Stiffness<D>,
    /// Number of degrees of freedom of a cell.
    pub(crate) size: usize,
    /// Map from reference wave vectors to wave vectors of the deformed lattice.
    pub(crate) to_spatial: SMatrix<f64, D, D>,
    /// Wave vectors that represent all zero-energy modes, if a wave is one of them; otherwise none.
    pub(crate) zero_modes: &'a dyn Fn(&SVector<f64, D>) -> Vec<SVector<f64, D>>,
}

/// Measure that is equal for all candidates.
#[derive(Clone, Copy, PartialEq)]
enum Measure {
    Scaled,
    Lowest,
    Growth,
}

impl<const D: usize> ZoneSearch<D> {
    /// Replaces the modes of a summary by the representatives of all modes with the same measure.
    pub(crate) fn represented(
        &self,
        waves: &StateWave<'_, D>,
        found: SpectrumSummary<D>,
    ) -> SpectrumSummary<D> {
        let fastest = found.maximum_omega.powi(2);
        let finite = |mode: Mode<D>, measure| {
            self.representative(waves, mode, measure, fastest, found.tolerance)
        };
        let shown = |mode: Mode<D>| {
            let is_at_rest = mode.wave_vector.norm() == 0.0;
            let over = self.speed_squared() * self.reference().laplacian(&mode.wave_vector);
            let is_scaled = is_at_rest
                || (mode.omega_squared.re / over - mode.scaled).abs()
                    <= SEARCH_ACCURACY * mode.scaled.abs() + found.tolerance;
            match (mode.is_long_wave, is_scaled) {
                (true, _) => self.representative_of_long(waves, mode),
                (false, true) => finite(mode, Measure::Scaled),
                // If a mode grows at `k = 0`, the softest mode has the lowest frequency.
                (false, false) => finite(mode, Measure::Lowest),
            }
        };
        let softest = (found.softest.scaled, &found.softest.wave_vector);
        let is_limit = !found.softest.is_long_wave
            && self.is_limit(softest, found.long_wave.scaled, found.tolerance);
        let lowest = finite(found.lowest, Measure::Lowest);
        let long_wave = self.representative_of_long(waves, found.long_wave);
        let softest = match is_limit {
            true => long_wave,
            false => shown(found.softest),
        };
        SpectrumSummary {
            softest,
            bound: found.bound.min(softest.scaled),
            long_wave,
            lowest,
            fastest_growing: match found.fastest_growing == found.lowest {
                true => lowest,
                false => finite(found.fastest_growing, Measure::Growth),
            },
            ..found
        }
    }

    /// Returns true if a wave is as soft as the long-wave limit up to rounding, or, if it is long, up to the accuracy of the search.
    pub(super) fn is_limit(
        &self,
        (softest, k): (f64, &SVector<f64, D>),
        limit: f64,
        tolerance: f64,
    ) -> bool {
        let is_long = self.reference().fractional(k).amax() < LIMIT_WAVE_FRACTION;
        let accuracy = if is_long {
            SEARCH_ACCURACY
        } else {
            MEASURE_ROUNDING
        };
        // Without a limit both sides would be infinite.
        limit.is_finite() && (softest - limit).abs() <= accuracy * limit.abs() + tolerance
    }

    fn representative(
        &self,
        waves: &StateWave<'_, D>,
        mode: Mode<D>,
        measure: Measure,
        fastest: f64,
        tolerance: f64,
    ) -> Mode<D> {
        if !self.is_periodic() || waves.size > IMAGED_CELL_SIZE {
            return mode;
        }
        let value = |k: &SVector<f64, D>| {
            let all = (waves.omega_squared)(k);
            let lowest = all.iter().map(|own| own.re).fold(f64::INFINITY, f64::min);
            match measure {
                Measure::Scaled => lowest / (self.speed_squared() * self.reference().laplacian(k)),
                Measure::Lowest => lowest,
                Measure::Growth => -all.iter().map(|own| growth_rate(*own)).fold(0.0, f64::max),
            }
        };
        let is_at_rest = mode.wave_vector.norm() == 0.0;
        let own = match is_at_rest {
            true => mode.scaled,
            false => value(&mode.wave_vector),
        };
        let rounding = match measure {
            Measure::Scaled => MEASURE_ROUNDING * own.abs() + tolerance,
            Measure::Lowest => {
                let noise = ACOUSTIC_ROUNDING * fastest;
                (MEASURE_ROUNDING * fastest).min(noise.max(SEARCH_ACCURACY * own.abs()))
            }
            Measure::Growth => (MEASURE_ROUNDING * fastest.sqrt()).min(SEARCH_ACCURACY * own.abs()),
        };
        let is_zero = measure != Measure::Growth && own.abs() <= rounding;
        // Other waves equal a motion with `k = 0` only if its frequency vanishes.
        if is_at_rest && !(is_zero && measure == Measure::Scaled) {
            return mode;
        }
        let zero_modes = || match is_zero {
            true => (waves.zero_modes)(&mode.wave_vector),
            false => Vec::new(),
        };
        // The scaled measure of waves that no search finds, because they are long, is a quotient of rounding errors.
        let is_rounding = |k: &SVector<f64, D>| {
            measure == Measure::Scaled && self.is_longer(k, 0.5 * LONG_WAVE_FRACTION)
        };
        let is_equal = |k: &SVector<f64, D>| !is_rounding(k) && value(k) <= own + rounding;
        let k = self.chosen(&mode.wave_vector, zero_modes, is_equal);
        if k.norm() == 0.0 {
            return mode;
        }
        self.shown_at(waves, k, mode, measure, fastest)
    }

    /// Wave vector that represents all wave vectors with an equal measure. `zero_modes` returns the wave vectors of other zero-energy modes.
    pub(super) fn chosen(
        &self,
        found: &SVector<f64, D>,
        zero_modes: impl FnOnce() -> Vec<SVector<f64, D>>,
        is_equal: impl Fn(&SVector<f64, D>) -> bool,
    ) -> SVector<f64, D> {
        let equivalence = self.equivalence();
        let Equivalence {
            zone, halves, maps, ..
        } = equivalence;
        let halves = halves.iter().filter(|k| is_equal(k));
        let mut equal: Vec<SVector<f64, D>> = halves.copied().collect();
        if equal.is_empty() {
            let mut alike: Vec<SVector<f64, D>> = zero_modes();
            alike.retain(|k| k.norm() > 0.0 && is_equal(k));
            if alike.is_empty() {
                alike = equivalence.shorter(found, &is_equal);
                alike.push(*found);
            }
            // The waves themselves and their images with the same measure.
            for k in alike {
                let images = maps.iter().map(|map| zone.folded(&(map * k)));
                equal.push(zone.folded(&k));
                equal.extend(images.filter(|k| is_equal(k)));
            }
        }
        let size = self.reference().reciprocal().column(0).norm();
        let candidates = equal.iter().flat_map(|k| {
            let shortest = zone.as_short(k);
            shortest.into_iter().flat_map(|k| [k, -k])
        });
        let first = candidates.reduce(|best, other| {
            match shorter_first(&other, &best, SEARCH_ACCURACY * size).is_lt() {
                true => other,
                false => best,
            }
        });
        let is_rounding = |x: f64| x.abs() <= MEASURE_ROUNDING * size;
        let first = first.unwrap_or(*found);
        first.map(|x| if is_rounding(x) { 0.0 } else { x })
    }

    /// Direction that represents all directions of long waves with an equal measure.
    pub(super) fn chosen_direction(
        &self,
        found: &SVector<f64, D>,
        is_equal: impl Fn(&SVector<f64, D>) -> bool,
    ) -> SVector<f64, D> {
        let Equivalence {
            maps, directions, ..
        } = self.equivalence();
        let along = directions.iter().filter(|n| is_equal(n));
        let mut equal: Vec<SVector<f64, D>> = along.copied().collect();
        if equal.is_empty() {
            let images = maps.iter().map(|map| (map * found).normalize());
            equal.extend(images.filter(|n| is_equal(n)));
        }
        let both = equal.into_iter().flat_map(|n| [n, -n]);
        let first = both.reduce(|best, other| {
            match shorter_first(&other, &best, SEARCH_ACCURACY).is_lt() {
                true => other,
                false => best,
            }
        });
        let first = first.unwrap_or(*found);
        first.map(|x| if x.abs() > MEASURE_ROUNDING { x } else { 0.0 })
    }

    /// Mode at an equivalent wave vector.
    fn shown_at(
        &self,
        waves: &StateWave<'_, D>,
        k: SVector<f64, D>,
        mode: Mode<D>,
        measure: Measure,
        fastest: f64,
    ) -> Mode<D> {
        let all = (waves.omega_squared)(&k);
        let apart = |own: &Complex| (own - mode.omega_squared).norm();
        let lowest = all.iter().min_by(|a, b| a.re.total_cmp(&b.re));
        // A search can end above the wave that represents its end.
        let known = mode.omega_squared.re;
        let rounding = MEASURE_ROUNDING * known.abs() + ACOUSTIC_ROUNDING * fastest;
        let lower = lowest.filter(|own| own.re < known - rounding);
        let nearest = match (measure, lower) {
            // Opposite waves have conjugate frequencies, and both can grow.
            (Measure::Growth, _) => all
                .iter()
                .max_by(|a, b| growth_rate(**a).total_cmp(&growth_rate(**b))),
            (_, Some(lower)) => Some(lower),
            _ => all.iter().min_by(|a, b| apart(a).total_cmp(&apart(b))),
        };
        let Some(value) = nearest.copied() else {
            return mode;
        };
        let along = waves.to_spatial * k;
        Mode {
            wave_vector: k,
            omega_squared: match (measure, lower) {
                (Measure::Growth, _) | (_, Some(_)) => value,
                _ => mode.omega_squared,
            },
            scaled: match (measure, lower) {
                (Measure::Scaled, Some(lower)) => {
                    lower.re / (self.speed_squared() * self.reference().laplacian(&k))
                }
                _ => mode.scaled,
            },
            polarization: polarized(&(waves.matrix)(&k), value, &along, fastest)
                .unwrap_or(mode.polarization),
            ..mode
        }
    }

    /// Representative of equally soft long waves; directions along short lattice vectors are preferred.
    fn representative_of_long(&self, waves: &StateWave<'_, D>, mode: Mode<D>) -> Mode<D> {
        if D == 1 || !mode.scaled.is_finite() {
            return mode;
        }
        let stiffness = (waves.long_waves)();
        let metric = self.reference().long_wave_metric();
        let tensor = |n: &SVector<f64, D>| stiffness.acoustic_tensor(n).map(Complex::from);
        let lowest = |n: &SVector<f64, D>| {
            let values = eigenvalues(&tensor(n), 0.0);
            values
                .into_iter()
                .reduce(|a, b| if b.re < a.re { b } else { a })
        };
        let value = |n: &SVector<f64, D>| {
            let scale = self.speed_squared() * n.dot(&(metric * n));
            lowest(n).map_or(f64::INFINITY, |own| own.re / scale)
        };
        let own = value(&mode.wave_vector);
        let size = stiffness.maximum_eigenvalue() / self.speed_squared();
        let is_equal = |n: &SVector<f64, D>| value(n) <= own + MEASURE_ROUNDING * size;
        let n = self.chosen_direction(&mode.wave_vector, is_equal);
        let matrix = tensor(&n);
        let matrix = DMatrix::from_fn(D, D, |i, j| matrix[(i, j)]);
        let along = waves.to_spatial * n;
        let polarization = lowest(&n)
            .and_then(|value| polarized(&matrix, value, &along, size * self.speed_squared()));
        Mode {
            wave_vector: n,
            polarization: polarization.unwrap_or(mode.polarization),
            ..mode
        }
    }
}

/// Polarization of the mode with the given eigenvalue, of the particle with the largest amplitude.
///
/// In an eigenspace, the mode with the largest component along the wave is used. `largest` is the largest eigenvalue.
fn polarized<const D: usize>(
    matrix: &DMatrix<Complex>,
    value: Complex,
    along: &SVector<f64, D>,
    largest: f64,
) -> Option<SVector<Complex, D>> {
    let size = matrix.nrows();
    let shifted = matrix - DMatrix::identity(size, size) * value;
    let svd = shifted.try_svd(false, true, f64::EPSILON, MAXIMUM_ITERATIONS * size)?;
    let rows = svd.v_t?;
    let rounding = MEASURE_ROUNDING * largest;
    let least = svd.singular_values.min();
    let is_null = |n: &usize| svd.singular_values[*n] <= rounding.max(least);
    let null: Vec<DVector<Complex>> = (0..size)
        .filter(is_null)
        .map(|n| rows.row(n).adjoint())
        .collect();
    let projected = |vector: DVector<Complex>| {
        let parts = null.iter().map(|own| own * own.dotc(&vector));
        parts.fold(DVector::zeros(size), |sum, part| sum + part)
    };
    // Starting vectors: all particles along the wave, then along each axis, then each component alone.
    let together = |direction: SVector<f64, D>| {
        let scale = (size as f64 / D as f64).sqrt() * direction.norm();
        DVector::from_fn(size, |i, _| Complex::from(direction[i % D] / scale))
    };
    let axis = |i: usize| SVector::from_fn(|j, _| f64::from(u8::from(i == j)));
    let alone = (0..size)
        .map(|i| DVector::from_fn(size, |j, _| Complex::from(f64::from(u8::from(i == j)))));
    let starts = std::iter::once(*along)
        .chain((0..D).map(axis))
        .map(together);
    let mode = match &null[..] {
        [only] => only.clone(),
        _ => starts
            .chain(alone)
            .map(projected)
            .find(|mode| mode.norm() > POLARIZATION_SHARE)?,
    };
    let particles = (0..size / D).map(|n| SVector::from_fn(|i, _| mode[D * n + i]));
    let most = particles.reduce(|best: SVector<Complex, D>, own| {
        match own.norm() > best.norm() * (1.0 + MEASURE_ROUNDING) {
            true => own,
            false => best,
        }
    })?;
    Some(normalized(most))
}
