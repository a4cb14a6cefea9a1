//! Spurious modes of a discretization: zero-energy modes and weakly controlled ones.

use super::degenerate::{DEGENERATE, most_symmetric};
use super::zero_energy::{Extent, ZeroMode, ZeroModes};
use crate::algebra::{Complex, Each, is_well, settled, settled_along, sort_by_value};
use crate::bloch::WaveSystem;
use crate::lattice::BrillouinZone;
use crate::method::MethodError;
use crate::verdict::{Displacements, Slowest, Survey, Unfolding, per_particle};
use nalgebra::{DMatrix, DVector, SMatrix, SVector};

/// Points of the grid of wave vectors along a reciprocal vector: halves, thirds, quarters and their parts are among them, but for the largest cells.
const GRID: [usize; 3] = [96, 24, 12];
/// The fewest of them with several particles in a cell.
const FEWEST: usize = 6;
/// Wave vectors nearer than this, in units of the reciprocal vectors, are the same.
const SAME: f64 = 1e-4;
/// How many of the deepest wells are followed to their bottom, weak or not.
const DEEPEST: usize = 4;
/// Distance from a face, in steps of the grid, at which a descent may be stuck.
const STUCK: f64 = 0.1;
/// Faces that are told from each other there, at most.
const MOST_FACES: usize = 8;

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
    let zone = BrillouinZone::new(*crystal.lattice());
    let strain = survey.discretization().strain()?;
    let zero = ZeroModes::new(crystal, &strain, |k| zone.folded(k));
    let weak = Weak {
        system: survey.reference()?,
        zone: &zone,
        unfolding: survey.unfolding()?,
    };
    let (weak_modes, slowest) = weak.modes(threshold, &zero);
    let mut modes: Vec<SpuriousMode<D>> = zero.modes.iter().map(|m| shown(m, &zone)).collect();
    let weakest = match modes.is_empty() {
        true => slowest.is_finite().then(|| slowest.clamp(0.0, 1.0).sqrt()),
        false => Some(0.0),
    };
    modes.extend(weak_modes);
    Ok(SpuriousModes {
        modes,
        zero_extent: zero.extent(),
        is_complete: zero.is_complete,
        weakest,
    })
}

/// A zero-energy mode with a wave vector of the first zone.
fn shown<const D: usize>(mode: &ZeroMode<D>, zone: &BrillouinZone<D>) -> SpuriousMode<D> {
    SpuriousMode {
        wave_vector: zone.folded(&mode.wave_vector),
        wave: zone.folded(&mode.wave_vector),
        relative_frequency: 0.0,
        nullity: mode.nullity,
        extent: mode.extent,
        displacements: most_symmetric(&mode.span, &zone.folded(&mode.wave_vector)),
    }
}

/// The search for weakly controlled modes.
struct Weak<'a, const D: usize> {
    system: &'a WaveSystem<D>,
    zone: &'a BrillouinZone<D>,
    unfolding: Unfolding<'a, D>,
}

impl<const D: usize> Weak<'_, D> {
    fn ratio(&self, k: &SVector<f64, D>) -> f64 {
        self.unfolding.slowest(k).ratio
    }

    /// The distance from the nearest reciprocal vector, in units of these.
    fn distance_to_zero(&self, k: &SVector<f64, D>) -> f64 {
        let fractional = self.zone.lattice().fractional(k);
        (fractional - fractional.map(f64::round)).amax()
    }

    /// Points of the grid along a reciprocal vector, about as dense with several particles in a cell, whose zone is smaller.
    fn points(&self) -> usize {
        let mut points = GRID[D - 1];
        let mut sites = self.system.size() / D;
        while points > FEWEST && sites >= 1 << D {
            points /= 2;
            sites >>= D;
        }
        points
    }

    /// The weakly controlled modes, and the lowest ratio anywhere.
    fn modes(&self, threshold: f64, zero: &ZeroModes<D>) -> (Vec<SpuriousMode<D>>, f64) {
        let n = self.points();
        let reciprocal = self.zone.lattice().reciprocal();
        let count = n.pow(D as u32);
        // Of k and -k one is enough.
        let half = (n / 2 + 1) * (count / n);
        let wave_vector = |index: usize| {
            let mut rest = index;
            let mut fractional = SVector::<f64, D>::zeros();
            for i in (0..D).rev() {
                fractional[i] = (rest % n) as f64 / n as f64;
                rest /= n;
            }
            reciprocal * fractional
        };
        let values: Vec<f64> = (0..half)
            .map(|index| self.ratio(&wave_vector(index)))
            .collect();
        let steps = reciprocal / n as f64;
        let mut wells: Vec<usize> = (0..half)
            .filter(|index| is_well::<D>(&values, *index, n))
            .filter(|index| !self.is_zero(&wave_vector(*index), zero))
            .collect();
        sort_by_value(&mut wells, |n| values[*n]);
        let limit = threshold * threshold;
        let mut bottoms: Vec<(f64, SVector<f64, D>)> = wells
            .into_iter()
            .enumerate()
            .filter(|(order, index)| *order < DEEPEST || values[*index] < 1.5 * limit)
            .map(|(_, index)| self.bottom((values[index], wave_vector(index)), &steps))
            .collect();
        sort_by_value(&mut bottoms, |item| item.0);
        let lowest = values.iter().chain(bottoms.iter().map(|(ratio, _)| ratio));
        let lowest = lowest.copied().fold(f64::INFINITY, f64::min);

        let mut modes: Vec<SpuriousMode<D>> = Vec::new();
        for (ratio, k) in bottoms {
            let k = self.zone.folded(&k);
            let slowest = self.unfolding.slowest(&k);
            // A well at k = 0 is no wave: the stiffness of all long waves is too low.
            let is_long = self.zone.lattice().fractional(&slowest.wave).amax() < 1.0 / n as f64;
            let is_known = || {
                modes
                    .iter()
                    .any(|known| self.is_same(&known.wave_vector, &k))
            };
            if ratio < limit && !is_long && !self.is_zero(&k, zero) && !is_known() {
                modes.push(self.mode(&k, ratio, &slowest));
            }
        }
        (modes, lowest)
    }

    /// The bottom of a well in the closed zone. The ratio has kinks where the shortest wave with a wave vector changes: on the faces of
    /// the zone, so that minima lie in it, on its faces, their edges, or at corners, and each of those is searched for itself.
    fn bottom(
        &self,
        start: (f64, SVector<f64, D>),
        steps: &SMatrix<f64, D, D>,
    ) -> (f64, SVector<f64, D>) {
        let at = |k: &SVector<f64, D>| self.ratio(k);
        let size = steps.column_iter().map(|step| step.norm());
        let size = size.fold(0.0, f64::max);
        let inside = settled(&at, start, steps);
        let least = self.unfolding.slowest(&inside.1);
        let wave = least.wave;
        let distance = |g: &SVector<f64, D>| 0.5 * g.norm() - wave.dot(g) / g.norm();
        // A descent that is stuck at a kink is on it.
        let is_near = |g: &&SVector<f64, D>| distance(g) < STUCK * size;
        let near = least.from_others.iter().filter(is_near);
        let near: Vec<SVector<f64, D>> = near.take(MOST_FACES).copied().collect();
        let mut best = inside;
        for which in 1_usize..1 << near.len() {
            let chosen: Vec<SVector<f64, D>> = (0..near.len())
                .filter(|i| which >> i & 1 == 1)
                .map(|i| near[i])
                .collect();
            let Some((place, tangents)) = stratum(&wave, &chosen) else {
                continue;
            };
            let tangents: Vec<SVector<f64, D>> = tangents.iter().map(|t| t * size).collect();
            let found = settled_along(&at, (at(&place), place), &tangents);
            if found.0 < best.0 {
                best = found;
            }
        }
        best
    }

    fn mode(&self, k: &SVector<f64, D>, ratio: f64, slowest: &Slowest<D>) -> SpuriousMode<D> {
        let modes = &self.system.modes(k)[slowest.branch..];
        let size = modes
            .iter()
            .map(|(value, _)| value.norm())
            .fold(0.0, f64::max);
        let first = modes.first().map_or(0.0, |(value, _)| value.re);
        let lowest: Vec<Displacements<D>> = modes
            .iter()
            .filter(|(value, _)| (value.re - first).abs() <= DEGENERATE * size)
            .map(|(_, displacements)| per_particle(displacements))
            .collect();
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
    fn is_zero(&self, k: &SVector<f64, D>, zero: &ZeroModes<D>) -> bool {
        zero.has(&self.zone.folded(k), |other| {
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

/// Where several faces of the zone meet, `k.G = |G|^2/2`: the point nearest to a wave vector, and unit tangents. `None` where one
/// of the faces is no further restriction.
fn stratum<const D: usize>(
    k: &SVector<f64, D>,
    faces: &[SVector<f64, D>],
) -> Option<(SVector<f64, D>, Vec<SVector<f64, D>>)> {
    if faces.len() > D {
        return None;
    }
    let normals = DMatrix::from_fn(faces.len(), D, |row, i| faces[row][i] / faces[row].norm());
    let short = DVector::from_fn(faces.len(), |row, _| {
        0.5 * faces[row].norm() - k.dot(&faces[row]) / faces[row].norm()
    });
    // Rows of zeros make the decomposition show the tangents too.
    let square = normals.clone().resize(D, D, 0.0);
    let svd = square.try_svd(true, true, f64::EPSILON, 1000)?;
    let right = svd.v_t.as_ref()?;
    let is_normal = |n: &usize| svd.singular_values[*n] > 1e-6;
    if (0..D).filter(is_normal).count() < faces.len() {
        return None;
    }
    let step = svd.solve(&short.resize_vertically(D, 0.0), 1e-6).ok()?;
    let place = k + SVector::from_fn(|i, _| step[i]);
    let tangents = (0..D)
        .filter(|n| !is_normal(n))
        .map(|n| SVector::from_fn(|i, _| right[(n, i)]));
    Some((place, tangents.collect()))
}
