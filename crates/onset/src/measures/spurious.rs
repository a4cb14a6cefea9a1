//! Spurious modes of a discretization: zero-energy modes and weakly controlled ones.

use super::degenerate::most_symmetric;
use super::zero_energy::{Extent, ZeroMode, ZeroModes};
use crate::algebra::{Complex, Each};
use crate::method::MethodError;
use crate::verdict::{Bottom, Slowest, Survey, WeakestSearch};
use nalgebra::SVector;

/// Wave vectors nearer than this, in units of the reciprocal vectors, are the same.
const SAME: f64 = 1e-4;

/// A spurious mode of the reference configuration: one with too little energy.
#[derive(Clone, Debug, PartialEq)]
pub struct SpuriousMode<const D: usize> {
    /// Its wave vector; 1/length.
    pub wave_vector: SVector<f64, D>,
    /// The wave vector of the material's wave that it is; 1/length. With several particles in a cell that is known up to reciprocal vectors only, and the
    /// wave is taken that the mode holds most of. For a zero-energy mode `wave_vector` itself.
    pub wave: SVector<f64, D>,
    /// Its frequency over that of the material's slowest wave with that wave vector: zero for a zero-energy mode.
    pub relative_frequency: f64,
    /// How many independent zero-energy modes there are at this wave vector, translations not counted: displacements that strain no
    /// point, whatever the law.
    pub nullity: usize,
    /// How far zero-energy modes extend from it; a single point for weakly controlled ones.
    pub extent: Extent,
    /// Displacement of each particle of the cell at the origin, of the mode with the lowest frequency. Where several have it, of one that is
    /// as symmetric as the wave vector: along it, if they hold such a wave.
    pub displacements: Vec<SVector<Complex, D>>,
}

impl<const D: usize> SpuriousMode<D> {
    /// Whether it is a zero-energy mode.
    pub fn is_zero(&self) -> bool {
        self.nullity > 0
    }
}

/// The spurious modes of a discretization.
#[derive(Clone, Debug, PartialEq)]
pub struct SpuriousModes<const D: usize> {
    /// Zero-energy modes first, single wave vectors before lines and surfaces; then the weakly controlled ones by their frequency. Of `k` and `-k`
    /// one, of a line or surface one.
    pub modes: Vec<SpuriousMode<D>>,
    /// How far zero-energy modes extend at most; `None` where there are none.
    pub zero_extent: Option<Extent>,
    /// Whether all zero-energy modes have been found: the whole zone has been searched. Not so for large cells that have too many wave
    /// vectors with little strain.
    pub is_complete: bool,
    /// The lowest relative frequency anywhere, long waves included: 0 with zero-energy modes, 1 where no wave is slower than the
    /// material's. `None` where nothing can be compared: the slowest waves of the material have no energy, as the shear waves of a fluid.
    pub weakest: Option<f64>,
}

/// All wave vectors with zero-energy modes, which depend on the discretization alone, and those at which the relative frequency has a
/// minimum below `threshold`; in the reference configuration, over the whole zone.
///
/// # Errors
/// [`MethodError`] when the material or the discretization cannot be evaluated.
pub fn spurious_modes<const D: usize>(
    survey: &Survey<'_, D>,
    threshold: f64,
) -> Result<SpuriousModes<D>, MethodError> {
    let crystal = survey.discretization().crystal();
    let search = survey.weakest_search()?;
    let zero = ZeroModes::new(crystal, search.rows, |k| search.zone.folded(k));
    let shown = |mode| shown(mode, &search);
    let mut modes: Vec<SpuriousMode<D>> = zero.modes.iter().map(shown).collect();
    let weakest = match modes.is_empty() {
        true => survey.weakest().map(|mode| mode.relative_frequency()),
        false => Some(0.0),
    };
    let weak = Weak {
        search,
        zero: &zero,
    };
    modes.extend(weak.modes(threshold));
    Ok(SpuriousModes {
        modes,
        zero_extent: zero.extent(),
        is_complete: zero.is_complete,
        weakest,
    })
}

/// A zero-energy mode with a wave vector of the first zone.
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
    zero: &'a ZeroModes<'a, D>,
}

impl<const D: usize> Weak<'_, D> {
    /// The distance from the nearest reciprocal vector, in units of these.
    fn distance_to_zero(&self, k: &SVector<f64, D>) -> f64 {
        let fractional = self.search.zone.lattice().fractional(k);
        (fractional - fractional.map(f64::round)).amax()
    }

    /// The weakly controlled modes.
    fn modes(&self, threshold: f64) -> Vec<SpuriousMode<D>> {
        let limit = threshold * threshold;
        let mut modes: Vec<SpuriousMode<D>> = Vec::new();
        for Bottom { ratio, wave_vector } in self.search.bottoms(limit) {
            let slowest = self.search.unfolding.slowest(&wave_vector);
            // A well at k = 0 is no wave: the stiffness of all long waves is too low.
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

    /// Whether a wave vector has a zero-energy mode.
    fn is_zero(&self, k: &SVector<f64, D>) -> bool {
        self.zero.has(k, |other| {
            let either = [k - other, k + other];
            let distances = either.each(|way| self.distance_to_zero(&way));
            distances[0].min(distances[1])
        })
    }

    /// Whether two wave vectors are the same, or opposite, up to reciprocal vectors.
    fn is_same(&self, a: &SVector<f64, D>, b: &SVector<f64, D>) -> bool {
        self.distance_to_zero(&(a - b)) < SAME || self.distance_to_zero(&(a + b)) < SAME
    }
}
