//! Weakest waves: minima of the relative frequency over the zone, in the reference configuration.
//!
//! The relative frequency is the frequency of a mode divided by the frequency of the material's slowest wave with the same wave vector. It depends
//! only on method and law, not on the state.

use super::unfolding::slower;
use super::{Slowest, Unfolding, WeakestMode};
use crate::algebra::sort_by_value;
use crate::bloch::{is_well, settled, settled_along};
use crate::lattice::BrillouinZone;
use crate::zero_energy::Strains;
use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use std::collections::VecDeque;
use std::sync::OnceLock;

/// Number of grid points along a reciprocal vector; except for the largest cells they include halves, thirds, quarters and finer fractions.
const GRID: [usize; 3] = [96, 24, 12];
/// Smallest number of grid points with several particles in a cell.
const MIN_GRID: usize = 6;
/// Number of the deepest wells that are followed to their bottom, weakly controlled or not. Further wells are followed if their values differ: wells
/// with equal values are images under a symmetry.
const FOLLOWED_WELLS: usize = 4;
/// Number of different values of wells that are followed.
const FOLLOWED_VALUES: usize = 8;
/// Number of the lowest points without a minimum on the grid at which descents start. A narrow well near the minimum of a kink need not have a minimum on
/// the grid.
const LOWEST_VALUES: usize = 12;
/// Smallest relative depth of the end of such a descent below all known bottoms.
const LOWER_BOTTOM: f64 = 1e-6;
/// Largest relative difference of the values of images.
const EQUAL_VALUES: f64 = 1e-9;
/// Largest distance from a kink, in grid steps: for a grid minimum, and for the end of a descent.
const KINK_DISTANCES: [f64; 2] = [1.0, 0.1];
/// Largest number of kinks near a well that are combined.
const MAX_FACES: usize = 6;
/// Largest squared relative frequency at which a zero-energy mode is searched for.
const SMALL_RATIO: f64 = 1e-4;

/// A minimum of the relative frequency.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bottom<const D: usize> {
    /// Squared relative frequency; zero for a zero-energy mode.
    pub(crate) ratio: f64,
    /// Wave vector in the zone; 1/length.
    pub(crate) wave_vector: SVector<f64, D>,
}

/// Squared relative frequency at a wave vector.
type Well<const D: usize> = (f64, SVector<f64, D>);

/// Starts of descents on the grid of wave vectors, the lowest first.
#[derive(Clone, Debug)]
pub(super) struct Starts<const D: usize> {
    /// Minima on the grid.
    wells: Vec<Well<D>>,
    /// Other points with the lowest values, one of each value.
    others: Vec<Well<D>>,
}

/// Search for the weakest waves.
pub(crate) struct WeakestSearch<'a, const D: usize> {
    pub(crate) unfolding: Unfolding<'a, D>,
    pub(crate) zone: BrillouinZone<D>,
    pub(crate) strains: &'a Strains<D>,
    /// Starts of descents, which take most of the time.
    pub(super) starts: &'a OnceLock<Starts<D>>,
}

impl<const D: usize> WeakestSearch<'_, D> {
    fn ratio(&self, k: &SVector<f64, D>) -> f64 {
        self.unfolding.slowest(k).ratio
    }

    /// Number of grid points along a reciprocal vector. It is smaller for cells with several particles, whose zone is smaller, so that the density of
    /// points is similar.
    pub(crate) fn points(&self) -> usize {
        let mut points = GRID[D - 1];
        let mut sites = self.unfolding.sites();
        while points > MIN_GRID && sites >= 1 << D {
            points /= 2;
            sites >>= D;
        }
        points
    }

    fn starts(&self) -> Starts<D> {
        let n = self.points();
        let reciprocal = self.zone.lattice().reciprocal();
        let count = n.pow(D as u32);
        // Half of the grid suffices: k and -k are equivalent.
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
        let mut sorted: Vec<usize> = (0..half).collect();
        sort_by_value(&mut sorted, |index| values[*index]);
        let own = |index: usize| (values[index], wave_vector(index));
        let (wells, others): (Vec<usize>, Vec<usize>) =
            (sorted.into_iter()).partition(|index| is_well::<D>(&values, *index, n));
        let mut others: Vec<Well<D>> = others.into_iter().map(own).collect();
        others.dedup_by(|b, a| b.0 <= a.0 * (1.0 + EQUAL_VALUES));
        // Cells with several particles have many kinks, and their waves take long.
        others.truncate(match self.unfolding.sites() {
            1 => LOWEST_VALUES,
            _ => 0,
        });
        Starts {
            wells: wells.into_iter().map(own).collect(),
            others,
        }
    }

    /// Minima of the relative frequency, the lowest first: the deepest minima, and all minima whose squared ratio may be below `limit`.
    pub(crate) fn bottoms(&self, limit: f64) -> Vec<Bottom<D>> {
        let steps = self.zone.lattice().reciprocal() / self.points() as f64;
        let alternating = self.strains.alternating.iter().map(|k| Bottom {
            ratio: 0.0,
            wave_vector: self.zone.folded(k),
        });
        let mut bottoms: Vec<Bottom<D>> = alternating.collect();
        let (mut followed, mut values, mut last) = (0, 0, 0.0);
        let starts = self.starts.get_or_init(|| self.starts());
        for &(value, k) in &starts.wells {
            if let Some(zero) = self.zero(value, &k) {
                bottoms.push(zero);
                continue;
            }
            let is_new = value > last * (1.0 + EQUAL_VALUES);
            let is_followed = followed < FOLLOWED_WELLS || value < 1.5 * limit;
            if is_followed || (is_new && values < FOLLOWED_VALUES) {
                followed += 1;
                values += usize::from(is_new);
                last = value;
                bottoms.push(self.bottom_of((value, k), &steps));
            }
        }
        sort_by_value(&mut bottoms, |bottom| bottom.ratio);
        let all_at = |all: &[SVector<f64, D>]| all.iter().map(|k| self.ratio(k)).collect();
        for &start in &starts.others {
            let lowest = bottoms.first().map_or(f64::INFINITY, |bottom| bottom.ratio);
            if lowest == 0.0 {
                break;
            }
            let end = settled(&all_at, start, &steps);
            if end.0 < lowest * (1.0 - LOWER_BOTTOM) {
                bottoms.insert(0, self.bottom_of(end, &steps));
            }
        }
        bottoms
    }

    /// Bottom of a well; a zero-energy mode if it is one.
    fn bottom_of(&self, start: Well<D>, steps: &SMatrix<f64, D, D>) -> Bottom<D> {
        let (ratio, k) = self.bottom(start, steps);
        self.zero(ratio, &k).unwrap_or(Bottom {
            ratio,
            wave_vector: self.zone.folded(&k),
        })
    }

    /// Zero-energy mode at a wave vector with a small squared ratio, or close to it.
    fn zero(&self, ratio: f64, k: &SVector<f64, D>) -> Option<Bottom<D>> {
        if ratio.abs() > SMALL_RATIO {
            return None;
        }
        let wave_vector = self.zone.folded(k);
        let known = |wave_vector| Bottom {
            ratio: 0.0,
            wave_vector,
        };
        let rows = &self.strains.rows;
        if wave_vector.norm() * rows.spacing < SMALL_RATIO {
            let rest = SVector::zeros();
            return rows.has_zero_mode_at(&rest).then(|| known(rest));
        }
        let root = rows.zero_mode_near(&wave_vector)?;
        Some(known(self.zone.folded(&root)))
    }

    /// Bottom of a well in the closed zone. The ratio has kinks where the shortest equivalent wave vector changes, for example on the faces of the
    /// zone. Minima lie between kinks, on one kink, or where several meet, and each of these sets is searched separately.
    fn bottom(&self, start: Well<D>, steps: &SMatrix<f64, D, D>) -> Well<D> {
        let at = |k: &SVector<f64, D>| self.ratio(k);
        let size = steps.column_iter().map(|step| step.norm());
        let size = size.fold(0.0, f64::max);
        let all_at = |all: &[SVector<f64, D>]| all.iter().map(at).collect();
        let inside = settled(&all_at, start, steps);
        let mut best = inside;
        // Cells with several particles have many kinks: the search covers only the kinks at the end of the descent.
        let skipped = usize::from(self.unfolding.sites() > 1);
        let [far, close] = KINK_DISTANCES;
        let ends = [(start.1, far), (inside.1, close)];
        let mut ends: VecDeque<_> = ends.into_iter().skip(skipped).collect();
        while let Some((k, near)) = ends.pop_front() {
            let before = best.0;
            let Slowest {
                wave, from_others, ..
            } = self.unfolding.slowest(&k);
            let kinks = kinks(&wave, &from_others, near * size);
            for which in 1_usize..1 << kinks.len() {
                let chosen: Vec<Kink<D>> = (0..kinks.len())
                    .filter(|i| which >> i & 1 == 1)
                    .map(|i| kinks[i])
                    .collect();
                let Some((place, tangents)) = stratum(&wave, &chosen) else {
                    continue;
                };
                let tangents: Vec<SVector<f64, D>> = tangents.iter().map(|t| t * size).collect();
                let found = settled_along(&all_at, (at(&place), place), &tangents);
                if found.0 < best.0 {
                    best = found;
                }
            }
            // A descent along some kinks can end at others.
            if best.0 < before - EQUAL_VALUES * before.abs() {
                ends.push_back((best.1, close));
            }
        }
        best
    }

    /// Weakest wave: the lowest of the minima.
    ///
    /// Zero-energy modes are equally weak. As among the waves of a state, alternating neighbors come first, then all other zero-energy modes.
    pub(super) fn weakest(&self, limit: f64) -> Option<WeakestMode<D>> {
        let mut bottoms = self.bottoms(limit);
        let known = &self.strains.alternating;
        let zero: Vec<SVector<f64, D>> = match bottoms.first().is_some_and(|own| own.ratio == 0.0) {
            true if known.is_empty() => {
                let modes = self.strains.modes().modes.iter();
                modes.map(|mode| mode.wave_vector).collect()
            }
            true => known.clone(),
            false => Vec::new(),
        };
        if !zero.is_empty() {
            let bottom = |k: SVector<f64, D>| Bottom {
                ratio: 0.0,
                wave_vector: self.zone.folded(&k),
            };
            bottoms = zero.into_iter().map(bottom).collect();
        }
        bottoms
            .iter()
            .map(|bottom| self.mode(bottom))
            .reduce(slower)
    }

    /// Material wave of a bottom, with its squared ratio.
    fn mode(&self, bottom: &Bottom<D>) -> WeakestMode<D> {
        let wave = match self.unfolding.sites() {
            1 => self.unfolding.first_image(&bottom.wave_vector),
            _ => self.unfolding.slowest(&bottom.wave_vector).forward(),
        };
        WeakestMode {
            wave_vector: wave,
            relative_frequency_squared: bottom.ratio,
        }
    }
}

/// Plane of wave vectors whose length equals the length of an equivalent wave vector: its unit normal, and its distance from `k = 0`.
type Kink<const D: usize> = (SVector<f64, D>, f64);

/// Kinks nearer to a wave than a given distance, the nearest first.
///
/// A wave vector and its image `k - G` have equal lengths on `k.G = |G|^2/2`. Where three of them have equal lengths, a third plane begins, where
/// the two images have equal lengths: the edges of a corner do not all lie on the faces of one zone.
fn kinks<const D: usize>(
    wave: &SVector<f64, D>,
    from_others: &[SVector<f64, D>],
    most: f64,
) -> Vec<Kink<D>> {
    let kink = |g: SVector<f64, D>, offset: f64| (g / g.norm(), offset / g.norm());
    let distance = |(normal, offset): &Kink<D>| (offset - normal.dot(wave)).abs();
    let nearest = |mut kinks: Vec<Kink<D>>, count: usize| {
        kinks.retain(|own| distance(own) < most);
        sort_by_value(&mut kinks, distance);
        kinks.truncate(count);
        kinks
    };
    let of_wave = |g: &SVector<f64, D>| kink(*g, 0.5 * g.norm_squared());
    let mut faces = from_others.to_vec();
    faces.retain(|g| distance(&of_wave(g)) < most);
    let mut kinks = nearest(faces.iter().map(of_wave).collect(), MAX_FACES);
    let pairs = (1..faces.len()).flat_map(|n| (0..n).map(move |m| (n, m)));
    let between = pairs.map(|(n, m)| {
        let apart = faces[n].norm_squared() - faces[m].norm_squared();
        kink(faces[n] - faces[m], 0.5 * apart)
    });
    let room = MAX_FACES - kinks.len();
    kinks.extend(nearest(between.collect(), room));
    kinks
}

/// Intersection of several kinks: its point nearest to a wave vector, and unit tangents.
///
/// Returns `None` if a kink contains the intersection of the others, or if they do not intersect.
fn stratum<const D: usize>(
    k: &SVector<f64, D>,
    kinks: &[Kink<D>],
) -> Option<(SVector<f64, D>, Vec<SVector<f64, D>>)> {
    if kinks.len() > D {
        return None;
    }
    let normals = DMatrix::from_fn(kinks.len(), D, |row, i| kinks[row].0[i]);
    let short = DVector::from_fn(kinks.len(), |row, _| kinks[row].1 - k.dot(&kinks[row].0));
    // Rows of zeros make the matrix square, so that the decomposition also gives the directions tangent to all kinks.
    let square = normals.clone().resize(D, D, 0.0);
    let svd = square.try_svd(true, true, f64::EPSILON, 1000)?;
    let right = svd.v_t.as_ref()?;
    let is_normal = |n: &usize| svd.singular_values[*n] > 1e-6;
    if (0..D).filter(is_normal).count() < kinks.len() {
        return None;
    }
    let step = svd.solve(&short.resize_vertically(D, 0.0), 1e-6).ok()?;
    let place = k + SVector::from_fn(|i, _| step[i]);
    let tangents = (0..D)
        .filter(|n| !is_normal(n))
        .map(|n| SVector::from_fn(|i, _| right[(n, i)]));
    Some((place, tangents.collect()))
}
