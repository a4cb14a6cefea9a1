//! Waves and patches: which numbers of cells hold whole wavelengths.

use serde::Serialize;

/// The most cells along a primitive vector.
pub(super) const MOST: usize = 512;
/// The largest denominator of a fraction that stands for an incommensurate wave.
const SMALL: usize = 16;
/// A wave fits if it misses a whole number of wavelengths by this share of one.
const WHOLE: f64 = 1e-6;

/// A patch of as many cells along each primitive vector, and the wave nearest to a given one that fits into it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fit {
    /// Cells along each primitive vector.
    pub cells: usize,
    /// The wave vector of the wave that fits, in units of the reciprocal vectors.
    pub fractional: Vec<f64>,
    /// The largest difference of a component from that of the wave itself; zero if the wave fits.
    pub error: f64,
}

impl Fit {
    /// The nearest wave in a patch.
    fn of(fractional: &[f64], cells: usize) -> Self {
        let count = cells as f64;
        let nearest: Vec<f64> = fractional
            .iter()
            .map(|x| (x * count).round() / count + 0.0)
            .collect();
        let apart = fractional.iter().zip(&nearest).map(|(x, y)| (x - y).abs());
        let error = apart.fold(0.0, f64::max);
        Self {
            cells,
            error: if error * count <= WHOLE { 0.0 } else { error },
            fractional: nearest,
        }
    }

    /// Whether a wave fits into a patch.
    pub(super) fn is_whole(fractional: &[f64], cells: usize) -> bool {
        Self::of(fractional, cells).error == 0.0
    }

    /// The smallest patch that a wave fits into. For a wave that fits into none, the small patch with the nearest wave.
    pub(super) fn smallest(fractional: &[f64]) -> Self {
        let whole = (1..=MOST).map(|cells| Self::of(fractional, cells));
        whole
            .into_iter()
            .find(|fit| fit.error == 0.0)
            .unwrap_or_else(|| {
                let small = (2..=SMALL).map(|cells| Self::of(fractional, cells));
                small
                    .reduce(|best, fit| if fit.error < best.error { fit } else { best })
                    .unwrap_or_else(|| Self::of(fractional, 1))
            })
    }
}

#[cfg(test)]
mod tests {
    use super::Fit;

    #[test]
    fn the_smallest_patch_holds_whole_wavelengths() {
        for (fractional, cells) in [
            (vec![0.0, 0.0], 1),
            (vec![0.5, 0.0], 2),
            (vec![1.0 / 3.0, -0.5], 6),
            (vec![2.0 / 7.0, 0.25], 28),
        ] {
            let fit = Fit::smallest(&fractional);
            assert_eq!((fit.cells, fit.error), (cells, 0.0), "{fractional:?}");
            assert!(
                Fit::is_whole(&fractional, 3 * cells) && !Fit::is_whole(&fractional, 3 * cells + 1)
                    || cells == 1
            );
        }
        // No patch holds 0.20983...; three fourteenths are nearest among small fractions.
        let fit = Fit::smallest(&[0.209_834_1, 0.5]);
        assert_eq!((fit.cells, fit.fractional[1]), (14, 0.5));
        assert!((fit.error - (3.0 / 14.0 - 0.209_834_1)).abs() < 1e-12);
    }
}
