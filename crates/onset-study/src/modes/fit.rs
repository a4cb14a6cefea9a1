//! Fit of waves into patches: numbers of cells that contain whole wavelengths.

use serde::Serialize;

/// Maximum number of cells along a primitive vector.
pub(super) const MAX_CELLS: usize = 512;
/// Maximum number of cells for an incommensurate wave, the denominator of its approximate fraction.
const MAX_DENOMINATOR: usize = 16;
/// Largest deviation from a whole number of wavelengths for a wave that fits.
const WHOLE_NUMBER_TOLERANCE: f64 = 1e-6;

/// Patch with equal numbers of cells along the primitive vectors, and the wave that fits into it and is closest to a given wave.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fit {
    /// Number of cells along each primitive vector.
    pub cells: usize,
    /// Wave vector of the wave that fits, in units of the reciprocal vectors.
    pub fractional: Vec<f64>,
    /// Largest deviation of a component from the given wave vector, in the same units; zero if the wave fits.
    pub error: f64,
}

impl Fit {
    /// Wave closest to the given wave for a number of cells.
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
            error: if error * count <= WHOLE_NUMBER_TOLERANCE {
                0.0
            } else {
                error
            },
            fractional: nearest,
        }
    }

    /// Returns true if a wave fits into a patch.
    pub(super) fn is_whole(fractional: &[f64], cells: usize) -> bool {
        Self::of(fractional, cells).error == 0.0
    }

    /// Smallest patch that a wave fits into. For an incommensurate wave, the small patch with the closest wave.
    pub(super) fn smallest(fractional: &[f64]) -> Self {
        let whole = (1..=MAX_CELLS).map(|cells| Self::of(fractional, cells));
        whole
            .into_iter()
            .find(|fit| fit.error == 0.0)
            .unwrap_or_else(|| {
                let small = (2..=MAX_DENOMINATOR).map(|cells| Self::of(fractional, cells));
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
        // No patch fits 0.20983...; 3/14 is the closest small fraction.
        let fit = Fit::smallest(&[0.209_834_1, 0.5]);
        assert_eq!((fit.cells, fit.fractional[1]), (14, 0.5));
        assert!((fit.error - (3.0 / 14.0 - 0.209_834_1)).abs() < 1e-12);
    }
}
