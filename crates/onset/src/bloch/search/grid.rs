//! Spectrum on a grid over the zone, and the wells of the grid.

use super::well::{CROSSING_RATIO, is_near_crossing, neighbors};
use super::{Candidate, Objective, Sample, ZoneSearch};
use crate::algebra::{Complex, Zeros, sort_by_value};
use crate::bloch::DynamicalMatrix;
use crate::bloch::growth_rate;
use crate::bloch::planar::PlanarEntries;
use crate::bloch::pocket::can_beat;
use crate::bloch::spatial::SpatialSpectrum;
use crate::lattice::{WaveGrid, Wedge, grid_coordinates, opposite};
use nalgebra::SVector;
use pulp::{Arch, NullaryFnOnce};
use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

/// Maximum number of grid points along an axis that predict pockets in three dimensions without a discriminant.
const POCKET_POINTS_PER_AXIS: usize = 24;

/// Objectives on a periodic grid over the zone.
pub(super) struct Grid<const D: usize> {
    pub(super) waves: Arc<WaveGrid<D>>,
    /// Classes of symmetric grid points with the same spectrum, if known.
    wedge: Option<Arc<Wedge>>,
    spectrum: GridSpectrum,
    /// Direction of the softest long wave.
    pub(super) soft_direction: SVector<f64, D>,
    /// Wave vectors in pockets of complex `omega^2` between the grid points, computed when first needed.
    pub(super) pockets: OnceLock<Vec<SVector<f64, D>>>,
    /// Wave vectors along the direction in which the longest waves flutter, computed when first needed.
    pub(super) opening: OnceLock<Vec<SVector<f64, D>>>,
    /// Spectra along the edges of a zone of a matrix that is not periodic, computed when first needed.
    pub(super) edges: OnceLock<Vec<Vec<Sample<D>>>>,
}

/// Grid point that is lower than its neighbors.
pub(super) struct Well<const D: usize> {
    pub(super) start: Candidate<D>,
    /// Height of the highest neighbor above the point. The bottom of a quadratic well is below the point by at most a quarter of this height.
    pub(super) relief: f64,
}

/// Values at half of the grid points, and at the neighbors that wells need beyond this half. The remaining values follow from `D(-k) = conj D(k)`.
struct GridSpectrum {
    /// Number of points in the half.
    half: usize,
    /// `Re omega^2 / (c^2 |k|_h^2)` of the lowest branch; infinite at `k = 0`.
    scaled: Zeros,
    lowest: Zeros,
    highest: Zeros,
    discriminant: Zeros,
    /// Negative growth rate of complex branches. Empty for a real `D` in the plane, where it follows from the other values.
    slowness: Zeros,
    /// Squared norm of the antisymmetric part, for a real `D` in three dimensions.
    asymmetry: Zeros,
}

impl GridSpectrum {
    fn zeros(count: usize, half: usize) -> Self {
        let zeros = || Zeros::new(count);
        Self {
            half,
            scaled: zeros(),
            lowest: zeros(),
            highest: zeros(),
            discriminant: zeros(),
            slowness: Zeros::default(),
            asymmetry: Zeros::default(),
        }
    }

    /// Values of an objective at half of the points, which include all distinct values.
    fn known(&self, objective: Objective) -> &[f64] {
        &self.with_neighbors(objective)[..self.half]
    }

    /// Values of an objective at half of the points and at their neighbors; zero elsewhere.
    fn with_neighbors(&self, objective: Objective) -> &[f64] {
        match objective {
            Objective::Scaled => &self.scaled,
            Objective::Lowest => &self.lowest,
            Objective::Highest => &self.highest,
            // A branch is complex, and can grow, where the discriminant is negative.
            Objective::Discriminant | Objective::Growth => &self.discriminant,
        }
    }

    /// Negative growth rates of complex branches; in the plane, `omega^2` is `Re omega^2 +- i sqrt(-p)`.
    fn slowness(&self) -> Cow<'_, [f64]> {
        if !self.slowness.is_empty() {
            return Cow::Borrowed(&self.slowness);
        }
        let pairs = self.discriminant.iter().zip(self.lowest.iter());
        let slowness = |(p, re): (&f64, &f64)| match *p < 0.0 {
            true => -growth_rate(Complex::new(*re, (-p).sqrt())),
            false => 0.0,
        };
        pairs.map(slowness).collect()
    }

    /// Measure of the separation of branches. In three dimensions, the discriminant divided by the sixth power of the distance of the outer branches,
    /// which can vary by orders of magnitude over the zone.
    fn relative_discriminants<const D: usize>(&self) -> Cow<'_, [f64]> {
        let known = self.known(Objective::Discriminant);
        if D < 3 {
            return Cow::Borrowed(known);
        }
        let outer = self.lowest.iter().zip(self.highest.iter());
        let distances = outer.map(|(lowest, highest)| -highest - lowest);
        known
            .iter()
            .zip(distances)
            .map(|(discriminant, distance)| discriminant / distance.powi(6))
            .collect()
    }

    /// Computes the values from the real entries of `D` at half of the grid.
    #[inline(always)]
    fn of_planar(entries: &PlanarEntries, laplacian: &[f64], speed_squared: f64) -> Self {
        let [a, b, c, d] = entries;
        let half = a.len();
        let mut spectrum = Self::zeros(laplacian.len(), half);
        let (lowest, highest) = (&mut spectrum.lowest[..half], &mut spectrum.highest[..half]);
        let (scaled, discriminant) = (
            &mut spectrum.scaled[..half],
            &mut spectrum.discriminant[..half],
        );
        let (b, c, d, laplacian) = (&b[..half], &c[..half], &d[..half], &laplacian[..half]);
        for n in 0..half {
            let mean = 0.5 * (a[n] + d[n]);
            let difference = 0.5 * (a[n] - d[n]);
            let p = difference * difference + b[n] * c[n];
            let root = if p > 0.0 { p } else { 0.0 }.sqrt();
            lowest[n] = mean - root;
            // Negated, because objectives are minimized.
            highest[n] = -(mean + root);
            discriminant[n] = p;
            scaled[n] = (mean - root) / (speed_squared * laplacian[n]);
        }
        spectrum
    }

    /// Computes the values of a real matrix in three dimensions at one point of each symmetry class.
    fn of_spatial<const D: usize>(
        matrix: &DynamicalMatrix<D>,
        waves: &WaveGrid<D>,
        wedge: &Wedge,
        speed_squared: f64,
    ) -> Self {
        let half = wedge.first.len();
        let mut spectrum = Self::zeros(waves.count(), half);
        spectrum.slowness = Zeros::new(waves.count());
        spectrum.asymmetry = Zeros::new(half);
        matrix.spatial_spectra(waves, wedge, &mut |n, there: SpatialSpectrum| {
            spectrum.lowest[n] = there.lowest;
            spectrum.highest[n] = -there.highest;
            spectrum.discriminant[n] = there.discriminant;
            spectrum.asymmetry[n] = there.asymmetry;
            if there.discriminant < 0.0 {
                let pair = Complex::new(there.pair, there.imaginary_squared.sqrt());
                spectrum.slowness[n] = -growth_rate(pair);
            }
        });
        for values in [
            &mut spectrum.lowest,
            &mut spectrum.highest,
            &mut spectrum.discriminant,
            &mut spectrum.asymmetry,
            &mut spectrum.slowness,
        ] {
            wedge.spread(values);
        }
        let known = spectrum.lowest.iter().zip(waves.laplacian());
        for (scaled, (lowest, laplacian)) in spectrum.scaled[..half].iter_mut().zip(known) {
            *scaled = lowest / (speed_squared * laplacian);
        }
        spectrum
    }

    /// Copies values from `k` to `-k`, `D(-k) = conj D(k)`, at the neighbors of points of the known half.
    fn mirrored<const D: usize>(&mut self, n: usize) {
        let lines = if D == 1 {
            (n / 2 + 1..n).collect()
        } else {
            vec![n / 2 + 1, n - 1]
        };
        let width = self.lowest.len() / n;
        let all = [
            &mut self.scaled,
            &mut self.lowest,
            &mut self.highest,
            &mut self.discriminant,
            &mut self.slowness,
        ];
        for values in all.into_iter().filter(|values| !values.is_empty()) {
            for index in lines
                .iter()
                .flat_map(|line| line * width..(line + 1) * width)
            {
                values[index] = values[opposite::<D>(index, n)];
            }
        }
    }
}

impl<const D: usize> ZoneSearch<D> {
    pub(super) fn grid(
        &self,
        matrix: &DynamicalMatrix<D>,
        points_per_period: usize,
        soft_direction: SVector<f64, D>,
    ) -> Grid<D> {
        // In three dimensions a grid has many more points, in more directions around each well.
        let points_per_period = if D == 3 {
            2 * points_per_period / 3
        } else {
            points_per_period
        };
        // Near the boundary of a zone that is not periodic, the folded grid is less reliable; complex branches occupy small pockets. Both need a
        // finer grid.
        let resolution = if !self.is_periodic {
            points_per_period * matrix.reach().clamp(4, 32)
        } else if matrix.is_hermitian() {
            points_per_period * matrix.effective_reach().clamp(4, 32)
        } else {
            points_per_period * 4 * matrix.effective_reach().clamp(4, 32) / 3
        };
        // With a multiple of six the points M, X and K lie on the grid.
        let resolution = resolution.next_multiple_of(6);
        let resolution = if D == 3 {
            resolution.min(48)
        } else {
            resolution
        };
        let waves = match (self.is_periodic, self.home_is_reference) {
            (true, _) => self.grids.grid(resolution),
            (false, true) => self.grids.folded_grid(resolution),
            (false, false) => self.grids.grid_folded_to(resolution, self.zone()),
        };
        let is_spatial = D == 3 && matrix.is_centrosymmetric() && matrix.sites().len() == 1;
        let wedge = is_spatial.then(|| {
            let symmetries = matrix.symmetries(self.grids.symmetries());
            self.grids.wedge(resolution, symmetries)
        });
        let mut spectrum = match matrix.planar_entries(&waves) {
            None => match &wedge {
                Some(wedge) => GridSpectrum::of_spatial(matrix, &waves, wedge, self.speed_squared),
                None => self.pointwise(matrix, &waves),
            },
            Some(entries) => Arch::new().dispatch(OfPlanar {
                entries: &entries,
                laplacian: waves.laplacian(),
                speed_squared: self.speed_squared,
            }),
        };
        spectrum.mirrored::<D>(resolution);
        // Long waves are represented by their limit.
        spectrum.scaled[0] = f64::INFINITY;
        Grid {
            waves,
            wedge,
            spectrum,
            soft_direction,
            pockets: OnceLock::new(),
            opening: OnceLock::new(),
            edges: OnceLock::new(),
        }
    }

    /// Evaluates the objectives at half of the grid, one matrix at a time.
    fn pointwise(&self, matrix: &DynamicalMatrix<D>, waves: &WaveGrid<D>) -> GridSpectrum {
        let count = waves.count();
        let half = waves.half();
        let mut spectrum = GridSpectrum::zeros(count, half);
        spectrum.slowness = Zeros::new(count);
        for index in 0..half {
            let sample = Sample::of(matrix, waves.wave_vector(index));
            let value = |objective| self.value(matrix, objective, &sample);
            spectrum.slowness[index] = value(Objective::Growth);
            spectrum.scaled[index] = value(Objective::Scaled);
            spectrum.lowest[index] = value(Objective::Lowest);
            spectrum.highest[index] = value(Objective::Highest);
            spectrum.discriminant[index] = value(Objective::Discriminant);
        }
        spectrum
    }
}

impl<const D: usize> Grid<D> {
    /// Smallest value of an objective on the grid, and its wave vector.
    pub(super) fn minimum(&self, objective: Objective) -> Candidate<D> {
        let mut best = (f64::INFINITY, 0);
        for (index, value) in self.spectrum.known(objective).iter().enumerate() {
            if *value < best.0 {
                best = (*value, index);
            }
        }
        (best.0, self.waves.wave_vector(best.1))
    }

    /// Largest `Re omega^2` on the grid.
    pub(super) fn largest(&self) -> f64 {
        let highest = self.spectrum.known(Objective::Highest).iter();
        highest.map(|value| value.abs()).fold(0.0, f64::max)
    }

    /// Distinct local minima of an objective on the grid below `below`, deepest first.
    pub(super) fn wells(&self, objective: Objective, below: f64) -> Vec<Well<D>> {
        self.wells_of(self.spectrum.with_neighbors(objective), below)
    }

    /// Distinct local minima of grid values below `below`, deepest first.
    fn wells_of(&self, values: &[f64], below: f64) -> Vec<Well<D>> {
        let n = self.waves.resolution();
        let lines = values.len() / n;
        let mut wells: Vec<Well<D>> = Vec::new();
        // Only one of `k` and `-k` is taken: the first half of the lines.
        let half = if D == 1 { 1 } else { (n / 2 + 1) * lines / n };
        let mut is_low = vec![false; n];
        for line in 0..half {
            let own = &values[line * n..][..n];
            if !own.iter().any(|value| *value < below) {
                continue;
            }
            let beside: Vec<&[f64]> = lines_beside::<D>(line, n)
                .iter()
                .map(|line| &values[line * n..][..n])
                .collect();
            Arch::new().dispatch(MarkLow {
                line: own,
                beside: &beside,
                below,
                is_low: &mut is_low,
            });
            let low = is_low.iter().enumerate().filter(|(_, low)| **low);
            for j in low.map(|(j, _)| j).filter(|j| line + j > 0) {
                let value = own[j];
                let (left, right) = ((j + n - 1) % n, (j + 1) % n);
                let around = || {
                    let points = beside
                        .iter()
                        .flat_map(|line| [line[left], line[j], line[right]]);
                    points.filter(|other| other.is_finite())
                };
                if value.is_finite() && around().all(|other| other >= value) {
                    wells.push(Well {
                        start: (value, self.waves.wave_vector(line * n + j)),
                        relief: around().fold(value, f64::max) - value,
                    });
                }
            }
        }
        sort_by_value(&mut wells, |well| well.start.0);
        // Wells of equal depth are symmetric images of each other.
        wells.dedup_by(|b, a| (b.start.0 - a.start.0).abs() <= 1e-10 * a.start.0.abs());
        wells
    }

    /// Grid points with the largest growth rates of complex branches, fastest first.
    pub(super) fn fastest_flutter(&self) -> impl Iterator<Item = SVector<f64, D>> {
        let wells = self.wells_of(&self.spectrum.slowness(), 0.0).into_iter();
        wells.map(|well| well.start.1)
    }

    /// Returns true if the antisymmetric parts are known, which bound the imaginary parts.
    pub(super) fn has_asymmetry(&self) -> bool {
        !self.spectrum.asymmetry.is_empty()
    }

    /// Largest growth rate of complex branches at the grid points.
    pub(super) fn largest_growth(&self) -> f64 {
        let slowness = self.spectrum.slowness();
        -slowness[..self.spectrum.half]
            .iter()
            .copied()
            .fold(0.0, f64::min)
    }

    /// Grid points near which two branches may cross, and their spacing in grid steps.
    ///
    /// With a discriminant, these are the points at which it is small compared with its neighbors, one of each symmetry class. Without a
    /// discriminant, these are all points of a moderately fine grid. Points around which no complex pair can grow faster than `rival` are omitted.
    pub(super) fn near_crossings(
        &self,
        has_discriminant: bool,
        rival: f64,
    ) -> (Vec<SVector<f64, D>>, usize) {
        let n = self.waves.resolution();
        let known = self.spectrum.relative_discriminants::<D>();
        let largest = CROSSING_RATIO * known.iter().copied().fold(0.0, f64::max);
        let lowest = self.spectrum.known(Objective::Lowest);
        let asymmetry: &[f64] = &self.spectrum.asymmetry;
        let stride = match has_discriminant || D < 3 {
            true => 1,
            false => n.div_ceil(POCKET_POINTS_PER_AXIS),
        };
        let wedge = self.wedge.as_ref();
        let is_near = |index: &usize| {
            if wedge.is_some_and(|wedge| !wedge.is_first(*index)) {
                return false;
            }
            if !has_discriminant {
                return grid_coordinates::<D>(*index, n)
                    .iter()
                    .all(|c| c % stride == 0);
            }
            // Most points are too distant from a crossing for their neighbors to matter.
            if known[*index] > largest || !is_near_crossing::<D>(&known, *index, n) {
                return false;
            }
            if !self.has_asymmetry() {
                return true;
            }
            let around = neighbors::<D>(*index, n, known.len()).chain([*index]);
            let (least, most) = around.fold((f64::INFINITY, 0.0_f64), |(least, most), other| {
                (least.min(lowest[other]), most.max(asymmetry[other]))
            });
            can_beat(rival, least, most)
        };
        let near = (1..known.len()).filter(is_near);
        let points = near.map(|index| self.waves.wave_vector(index)).collect();
        (points, stride)
    }

    /// Length of a grid step along the first reciprocal vector.
    pub(super) fn step(&self, search: &ZoneSearch<D>) -> f64 {
        search.reference().reciprocal().column(0).norm() / self.waves.resolution() as f64
    }
}

/// Vectorized evaluation for the instruction set of the machine. It is a struct because a closure would not be inlined.
struct OfPlanar<'a> {
    entries: &'a PlanarEntries,
    laplacian: &'a [f64],
    speed_squared: f64,
}

impl NullaryFnOnce for OfPlanar<'_> {
    type Output = GridSpectrum;

    #[inline(always)]
    fn call(self) -> GridSpectrum {
        GridSpectrum::of_planar(self.entries, self.laplacian, self.speed_squared)
    }
}

/// Vectorized marking of low points for the instruction set of the machine.
struct MarkLow<'a> {
    line: &'a [f64],
    beside: &'a [&'a [f64]],
    below: f64,
    is_low: &'a mut [bool],
}

impl NullaryFnOnce for MarkLow<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        mark_low(self.line, self.beside, self.below, self.is_low);
    }
}

/// Marks the points of a line that are no higher than their neighbors on the lines `beside`. The marks at the ends of the line may be wrong.
#[inline(always)]
fn mark_low(line: &[f64], beside: &[&[f64]], below: f64, is_low: &mut [bool]) {
    let n = line.len();
    for (is_low, value) in is_low.iter_mut().zip(line) {
        *is_low = *value < below;
    }
    for other in beside {
        let other = &other[..n];
        let is_low = &mut is_low[..n];
        for j in 1..n - 1 {
            let lowest = other[j - 1].min(other[j]).min(other[j + 1]);
            is_low[j] &= lowest >= line[j];
        }
    }
}

/// Indices of a line of the grid (all coordinates except the last) and of its neighboring lines.
fn lines_beside<const D: usize>(line: usize, n: usize) -> Vec<usize> {
    let mut beside = Vec::with_capacity(3_usize.pow(D as u32 - 1));
    beside.push(0);
    let mut scale = 1;
    let mut rest = line;
    for _ in 1..D {
        let i = rest % n;
        rest /= n;
        let [last, own, next] = [(i + n - 1) % n, i, (i + 1) % n].map(|i| i * scale);
        let known = beside.len();
        for neighbor in [own, next] {
            for place in 0..known {
                beside.push(beside[place] + neighbor);
            }
        }
        beside[..known].iter_mut().for_each(|place| *place += last);
        scale *= n;
    }
    beside
}

/// Largest growth rate among complex eigenvalues.
pub(super) fn complex_growth(omega_squared: &[Complex]) -> f64 {
    omega_squared
        .iter()
        .filter(|value| value.im != 0.0)
        .map(|value| growth_rate(*value))
        .fold(0.0, f64::max)
}
