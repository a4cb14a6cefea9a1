//! Spurious modes of a discretization: zero-energy modes and weakly controlled modes.

use super::degenerate::most_symmetric;
use crate::algebra::{Complex, Each};
use crate::method::MethodError;
use crate::verdict::{Bottom, Slowest, Survey, WeakestSearch};
use crate::zero_energy::{Extent, ZeroMode, ZeroModes};
use nalgebra::SVector;

/// Largest distance between wave vectors that count as equal, in units of the reciprocal vectors.
const WAVE_VECTOR_TOLERANCE: f64 = 1e-4;

/// Spurious mode of the reference configuration: a zero-energy or weakly controlled mode.
#[derive(Clone, Debug, PartialEq)]
pub struct SpuriousMode<const D: usize> {
    /// Wave vector of the mode; 1/length.
    pub wave_vector: SVector<f64, D>,
    /// Wave vector of the material wave; 1/length.
    ///
    /// The modes of a cell with several particles determine it only up to reciprocal vectors. It is then the wave vector of the longest wave with a
    /// large amplitude in the mode.
    pub wave: SVector<f64, D>,
    /// Frequency divided by the frequency of the slowest material wave with the wave vector `wave`; zero for a zero-energy mode.
    pub relative_frequency: f64,
    /// Number of independent zero-energy modes at this wave vector, without translations. Their displacements strain no point, for any material.
    pub nullity: usize,
    /// Extent of the set of zero-energy modes at this wave vector; a single point for weakly controlled modes.
    pub extent: Extent,
    /// Displacement of each particle of the cell at the origin, in the mode with the lowest frequency.
    ///
    /// Among degenerate modes, the most symmetric mode is given, which is along the wave vector if they contain such a wave.
    pub displacements: Vec<SVector<Complex, D>>,
}

impl<const D: usize> SpuriousMode<D> {
    /// Returns true for a zero-energy mode.
    pub fn is_zero(&self) -> bool {
        self.nullity > 0
    }
}

/// Spurious modes of a discretization.
#[derive(Clone, Debug, PartialEq)]
pub struct SpuriousModes<const D: usize> {
    /// Spurious modes: zero-energy modes, single wave vectors before lines and surfaces, then weakly controlled modes by frequency.
    ///
    /// Only one of `k` and `-k`, and only one wave vector of each line or surface, is listed.
    pub modes: Vec<SpuriousMode<D>>,
    /// Largest extent of a set of zero-energy modes; `None` without zero-energy modes.
    pub zero_extent: Option<Extent>,
    /// Whether the whole zone has been searched, so that all zero-energy modes are known. The search of large cells ends early if too many wave
    /// vectors have little strain.
    pub is_complete: bool,
    /// Lowest relative frequency in the zone, long waves included: 0 with zero-energy modes, 1 if no wave is slower than in the material.
    ///
    /// `None` if the slowest waves of the material have frequency zero, like shear waves of fluids.
    pub weakest: Option<f64>,
}

/// Finds the zero-energy modes, and the minima of the relative frequency below `threshold`, over the whole zone in the reference configuration.
///
/// Zero-energy modes depend only on the discretization.
///
/// # Errors
/// [`MethodError`] when the material or the discretization cannot be evaluated.
pub fn spurious_modes<const D: usize>(
    survey: &Survey<'_, D>,
    threshold: f64,
) -> Result<SpuriousModes<D>, MethodError> {
    let search = survey.weakest_search()?;
    let zero = search.strains.modes();
    let shown = |mode| shown(mode, &search);
    let mut modes: Vec<SpuriousMode<D>> = zero.modes.iter().map(shown).collect();
    let weakest = match modes.is_empty() {
        true => survey.weakest().map(|mode| mode.relative_frequency()),
        false => Some(0.0),
    };
    let ZeroModes { is_complete, .. } = *zero;
    let zero_extent = zero.extent();
    modes.extend(Weak { search }.modes(threshold));
    Ok(SpuriousModes {
        modes,
        zero_extent,
        is_complete,
        weakest,
    })
}

/// Converts a zero-energy mode, with its wave vector folded into the first zone.
fn shown<const D: usize>(mode: &ZeroMode<D>, search: &WeakestSearch<'_, D>) -> SpuriousMode<D> {
    let k = search.zone.folded(&mode.wave_vector);
    SpuriousMode {
        wave_vector: k,
        wave: search.unfolding.wave_of(&k, &mode.span),
        relative_frequency: 0.0,
        nullity: mode.nullity,
        extent: mode.extent,
        displacements: most_symmetric(&mode.span, &k),
    }
}

/// Weakly controlled modes from the search for the weakest waves.
struct Weak<'a, const D: usize> {
    search: WeakestSearch<'a, D>,
}

impl<const D: usize> Weak<'_, D> {
    /// Distance from the nearest reciprocal vector, in units of the reciprocal vectors.
    fn distance_to_zero(&self, k: &SVector<f64, D>) -> f64 {
        let fractional = self.search.zone.lattice().fractional(k);
        (fractional - fractional.map(f64::round)).amax()
    }

    /// Weakly controlled modes below a threshold of the relative frequency.
    fn modes(&self, threshold: f64) -> Vec<SpuriousMode<D>> {
        let limit = threshold * threshold;
        let mut modes: Vec<SpuriousMode<D>> = Vec::new();
        for Bottom { ratio, wave_vector } in self.search.bottoms(limit) {
            let slowest = self.search.unfolding.slowest(&wave_vector);
            // A minimum at k = 0 is not a mode: the stiffness of all long waves is too low.
            let long = 1.0 / self.search.points() as f64;
            let is_long = self.search.zone.lattice().fractional(&slowest.wave).amax() < long;
            let is_known = || {
                let mut known = modes.iter();
                known.any(|known| self.is_same(&known.wave_vector, &wave_vector))
            };
            if ratio < limit && !is_long && !self.is_zero(&wave_vector) && !is_known() {
                modes.push(self.mode(&wave_vector, ratio, &slowest));
            }
        }
        modes
    }

    fn mode(&self, k: &SVector<f64, D>, ratio: f64, slowest: &Slowest<D>) -> SpuriousMode<D> {
        let lowest = self.search.unfolding.modes_with(k, slowest.branch);
        SpuriousMode {
            wave_vector: *k,
            wave: slowest.wave,
            relative_frequency: ratio.max(0.0).sqrt(),
            nullity: 0,
            extent: Extent::Point,
            displacements: most_symmetric(&lowest, k),
        }
    }

    /// Returns true if a wave vector has a zero-energy mode.
    fn is_zero(&self, k: &SVector<f64, D>) -> bool {
        self.search.strains.has_mode_at(k, |other| {
            let either = [k - other, k + other];
            let distances = either.each(|way| self.distance_to_zero(&way));
            distances[0].min(distances[1])
        })
    }

    /// Returns true if two wave vectors are equal or opposite, up to reciprocal vectors.
    fn is_same(&self, a: &SVector<f64, D>, b: &SVector<f64, D>) -> bool {
        self.distance_to_zero(&(a - b)) < WAVE_VECTOR_TOLERANCE
            || self.distance_to_zero(&(a + b)) < WAVE_VECTOR_TOLERANCE
    }
}
