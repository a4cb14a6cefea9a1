//! Grids of wave vectors over a cell of the reciprocal lattice, with their state-independent data.

use super::mirror::{Mirror, MirrorWaves};
use super::numbering::{coordinates, opposite};
use super::symmetry::{Equivalence, Symmetry, Wedge};
use super::{BravaisLattice, BrillouinZone, Fractional};
use crate::algebra::{Complex, hermitian_eigen};
use nalgebra::{DMatrix, SMatrix, SVector, SVectorView};
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Grid of wave vectors `k = sum_i (j_i / n) b_i`, `j_i = 0 .. n`, with the phases of lattice vectors and the lattice Laplacian.
///
/// The first index varies slowest. Indices beyond `n / 2` represent negative values, so that the vectors surround zero.
#[derive(Debug)]
pub struct WaveGrid<const D: usize> {
    resolution: usize,
    wave_vectors: Arc<Vec<SVector<f64, D>>>,
    laplacian: Arc<Vec<f64>>,
    /// Tables of `cos` and `sin` of `2 pi m j / n`, `j = 0 .. n`, for each `m` from `-n / 2` to `n / 2`.
    turned: Arc<Vec<(Vec<f64>, Vec<f64>)>>,
    lattice: BravaisLattice<D>,
    /// Reciprocal vectors to subtract from folded wave vectors.
    shifts: Option<Shifts<D>>,
    site_phases: Mutex<SitePhases<D>>,
}

/// Reciprocal vectors subtracted by folding; there are few distinct vectors for many points.
#[derive(Debug)]
struct Shifts<const D: usize> {
    distinct: Vec<SVector<f64, D>>,
    /// Index of the shift of each point of half of the grid.
    of_point: Vec<u32>,
}

/// Cosines and sines at half of the points.
type Phases = (Vec<f64>, Vec<f64>);

/// Sites with the cosines and sines of `k.site`.
type SitePhases<const D: usize> = Vec<(SVector<f64, D>, Arc<Phases>)>;

impl<const D: usize> WaveGrid<D> {
    fn new(lattice: &BravaisLattice<D>, resolution: usize) -> Self {
        let n = resolution as i64;
        let wave_vectors: Vec<SVector<f64, D>> = (0..resolution.pow(D as u32))
            .map(|index| {
                let fractional =
                    coordinates::<D>(index, resolution).map(|j| centered(j, resolution));
                lattice.reciprocal() * SVector::from(fractional)
            })
            .collect();
        let circle: Vec<(f64, f64)> = (0..n)
            .map(|m| TAU * m as f64 / n as f64)
            .map(|angle| (angle.cos(), angle.sin()))
            .collect();
        let turned = |m: i64| {
            (0..n)
                .map(|j| circle[(m * j).rem_euclid(n) as usize])
                .unzip()
        };
        let laplacian = wave_vectors.iter().map(|k| lattice.laplacian(k)).collect();
        Self {
            resolution,
            laplacian: Arc::new(laplacian),
            wave_vectors: Arc::new(wave_vectors),
            turned: Arc::new((-(n / 2)..=n / 2).map(turned).collect()),
            lattice: *lattice,
            shifts: None,
            site_phases: Mutex::new(Vec::new()),
        }
    }

    /// Replaces each wave vector by its equivalent in a zone. `shift` returns the multiples of the reciprocal vectors to subtract from a wave vector
    /// in units of these vectors.
    fn folded(&self, shift: impl Fn(&Fractional<D>) -> [i32; D]) -> Self {
        Self {
            resolution: self.resolution,
            wave_vectors: Arc::clone(&self.wave_vectors),
            laplacian: Arc::clone(&self.laplacian),
            turned: Arc::clone(&self.turned),
            lattice: self.lattice,
            shifts: Some(Shifts::new(self.resolution, &self.lattice, shift)),
            site_phases: Mutex::new(Vec::new()),
        }
    }

    /// Number of points along each reciprocal vector.
    pub fn resolution(&self) -> usize {
        self.resolution
    }

    /// Number of grid points.
    pub fn count(&self) -> usize {
        self.wave_vectors.len()
    }

    /// Number of points with a first index up to `n / 2`. They come first, and every other point is opposite to one of them.
    pub(crate) fn half(&self) -> usize {
        half::<D>(self.resolution)
    }

    /// Wave vector of a point; 1/length.
    pub fn wave_vector(&self, point: usize) -> SVector<f64, D> {
        let Some(shifts) = &self.shifts else {
            return self.wave_vectors[point];
        };
        match shifts.of_point.get(point) {
            Some(shift) => self.wave_vectors[point] - shifts.distinct[*shift as usize],
            None => -self.wave_vector(opposite::<D>(point, self.resolution)),
        }
    }

    /// Wave vectors of all points; 1/length.
    pub fn wave_vectors(&self) -> impl Iterator<Item = SVector<f64, D>> {
        (0..self.count()).map(|point| self.wave_vector(point))
    }

    /// Lattice Laplacian `|k|_h^2` of each point; 1/length^2.
    pub fn laplacian(&self) -> &[f64] {
        &self.laplacian
    }

    /// Values `cos` and `sin` of `2 pi m / n`.
    pub(crate) fn on_circle(&self, m: i64) -> (f64, f64) {
        let unit = &self.turned[self.resolution / 2 + 1];
        let m = m.rem_euclid(self.resolution as i64) as usize;
        (unit.0[m], unit.1[m])
    }

    /// Tables of `cos` and `sin` of `2 pi m j / n` for all `j`, with `m` of either sign taken modulo `n`.
    pub(crate) fn turned(&self, m: i32) -> (&[f64], &[f64]) {
        let n = self.resolution as i64;
        let nearest = (i64::from(m) + n / 2).rem_euclid(n);
        let (cosines, sines) = &self.turned[nearest as usize];
        (cosines, sines)
    }

    /// Tables of `cos k.site` and `sin k.site` at the wave vectors of half of the points, computed once per site.
    pub(crate) fn site_phases(&self, site: &SVector<f64, D>) -> Arc<Phases> {
        let mut known = self
            .site_phases
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        if let Some((_, phases)) = known.iter().find(|(other, _)| other == site) {
            return Arc::clone(phases);
        }
        let phases = Arc::new(self.phases_of(site));
        known.push((*site, Arc::clone(&phases)));
        phases
    }

    /// Phases `exp(i k.site)` as products of the phases along the reciprocal vectors and of the shift, with far fewer sines than wave vectors.
    fn phases_of(&self, site: &SVector<f64, D>) -> Phases {
        let n = self.resolution;
        let turned = |angle: f64| Complex::from_polar(1.0, angle);
        let axis = |b: SVectorView<'_, f64, D>| -> Vec<Complex> {
            let along = b.dot(site);
            (0..n).map(|j| turned(centered(j, n) * along)).collect()
        };
        let axes: Vec<_> = self.lattice.reciprocal().column_iter().map(axis).collect();
        let (mut cosines, mut sines) = (vec![0.0; self.half()], vec![0.0; self.half()]);
        let lines = cosines.chunks_mut(n).zip(sines.chunks_mut(n));
        for (number, (cosines, sines)) in lines.enumerate() {
            let mut first = Complex::new(1.0, 0.0);
            let mut rest = number;
            for axis in axes[..D - 1].iter().rev() {
                first *= axis[rest % n];
                rest /= n;
            }
            for ((cosine, sine), own) in cosines.iter_mut().zip(sines).zip(&axes[D - 1]) {
                let phase = first * own;
                (*cosine, *sine) = (phase.re, phase.im);
            }
        }
        if let Some(shifts) = &self.shifts {
            let distinct: Vec<Complex> = shifts
                .distinct
                .iter()
                .map(|shift| turned(-shift.dot(site)))
                .collect();
            for (point, shift) in shifts.of_point.iter().enumerate() {
                let by = distinct[*shift as usize];
                let (cosine, sine) = (cosines[point], sines[point]);
                cosines[point] = cosine * by.re - sine * by.im;
                sines[point] = cosine * by.im + sine * by.re;
            }
        }
        (cosines, sines)
    }
}

/// Number of points of a grid with a first index up to half of the resolution.
fn half<const D: usize>(resolution: usize) -> usize {
    (resolution / 2 + 1) * resolution.pow(D as u32 - 1)
}

impl<const D: usize> Shifts<D> {
    /// Computes the shifts for half of the points of a grid.
    fn new(
        resolution: usize,
        lattice: &BravaisLattice<D>,
        shift: impl Fn(&Fractional<D>) -> [i32; D],
    ) -> Self {
        let n = resolution;
        let mut known: Vec<[i32; D]> = Vec::new();
        let mut at = |point: usize| {
            let place = coordinates::<D>(point, n).map(|j| centered(j, n));
            let own = shift(&SVector::from(place));
            let number = known.iter().position(|other| *other == own);
            number.unwrap_or_else(|| {
                known.push(own);
                known.len() - 1
            }) as u32
        };
        let mut of_point = vec![0; half::<D>(n)];
        for (start, line) in of_point.chunks_mut(n).enumerate() {
            let start = start * n;
            // Shifts change abruptly in the middle of a line.
            let (near, far) = line.split_at_mut(n / 2 + 1);
            fill_convex(near, &mut |j| at(start + j));
            fill_convex(far, &mut |j| at(start + n / 2 + 1 + j));
        }
        let vector = |shift: [i32; D]| lattice.reciprocal() * SVector::from(shift.map(f64::from));
        Self {
            distinct: known.into_iter().map(vector).collect(),
            of_point,
        }
    }
}

/// Fills a line with a function that is constant between any two points of equal value.
fn fill_convex(line: &mut [u32], at: &mut impl FnMut(usize) -> u32) {
    let Some(last) = line.len().checked_sub(1) else {
        return;
    };
    let mut open = vec![[(0, at(0)), (last, at(last))]];
    while let Some([low, high]) = open.pop() {
        if low.1 == high.1 {
            line[low.0..=high.0].fill(low.1);
        } else if high.0 - low.0 == 1 {
            (line[low.0], line[high.0]) = (low.1, high.1);
        } else {
            let middle = low.0.midpoint(high.0);
            let middle = (middle, at(middle));
            open.extend([[low, middle], [middle, high]]);
        }
    }
}

/// Grid index along an axis as a fraction of the reciprocal vector; indices beyond the middle represent negative values.
fn centered(j: usize, resolution: usize) -> f64 {
    let (j, n) = (j as f64, resolution as f64);
    (if 2.0 * j > n { j - n } else { j }) / n
}

/// Grids of one lattice, each created on first use.
#[derive(Debug)]
pub struct WaveGrids<const D: usize> {
    lattice: BravaisLattice<D>,
    long_wave_map: SMatrix<f64, D, D>,
    made: Mutex<BTreeMap<(usize, bool), Arc<WaveGrid<D>>>>,
    mirrors: Vec<Mirror>,
    mirrored: Mutex<MirroredGrids>,
    symmetries: OnceLock<Vec<Symmetry<D>>>,
    equivalence: OnceLock<Equivalence<D>>,
    /// Wedges by resolution and by the indices of the symmetries as bits.
    wedges: Mutex<BTreeMap<(usize, u64), Arc<Wedge>>>,
}

/// Grids reduced by a mirror, by the index of the mirror and the steps along its lines.
type MirroredGrids = BTreeMap<(usize, [usize; 2]), Arc<MirrorWaves>>;

impl<const D: usize> WaveGrids<D> {
    /// Creates the collection for a lattice.
    pub fn new(lattice: BravaisLattice<D>) -> Self {
        // The sums along mirror lines use the lattice Laplacian in terms of the phases of the primitive vectors.
        let is_own = lattice.is_measured_by_own_vectors();
        let mirrors = if is_own {
            Mirror::all(&lattice)
        } else {
            Vec::new()
        };
        let other = lattice.inverse_root_of_metric().filter(|_| !is_own);
        Self {
            lattice,
            long_wave_map: other
                .unwrap_or_else(|| inverse_square_root(&lattice.long_wave_metric())),
            made: Mutex::new(BTreeMap::new()),
            mirrors,
            mirrored: Mutex::new(BTreeMap::new()),
            symmetries: OnceLock::new(),
            equivalence: OnceLock::new(),
            wedges: Mutex::new(BTreeMap::new()),
        }
    }

    /// Symmetries of the lattice.
    pub(crate) fn symmetries(&self) -> &[Symmetry<D>] {
        self.symmetries.get_or_init(|| Symmetry::all(&self.lattice))
    }

    /// Wave vectors that the symmetries make equivalent.
    pub(crate) fn equivalence(&self) -> &Equivalence<D> {
        self.equivalence
            .get_or_init(|| Equivalence::of(&self.lattice))
    }

    /// Orbits of the points of a grid under the symmetries whose bits are set.
    pub(crate) fn wedge(&self, resolution: usize, symmetries: u64) -> Arc<Wedge> {
        let mut made = self.wedges.lock().unwrap_or_else(PoisonError::into_inner);
        let make = || {
            let all = self.symmetries().iter().enumerate();
            let group: Vec<Symmetry<D>> = all
                .filter(|(n, _)| symmetries >> n & 1 == 1)
                .map(|(_, symmetry)| *symmetry)
                .collect();
            Arc::new(Wedge::new(&group, resolution))
        };
        Arc::clone(made.entry((resolution, symmetries)).or_insert_with(make))
    }

    /// Mirrors of the lattice.
    pub(crate) fn mirrors(&self) -> &[Mirror] {
        &self.mirrors
    }

    /// Part of a grid that remains after mirror symmetry, with at least the given steps along the lines of the mirror `number`.
    pub(crate) fn mirrored(&self, number: usize, steps: [usize; 2]) -> Arc<MirrorWaves> {
        // Round up to full lines.
        let filled = (steps[0] + 3).next_multiple_of(super::FILL) - 3;
        let intervals = [filled, steps[1].next_multiple_of(3)];
        let mut made = self.mirrored.lock().unwrap_or_else(PoisonError::into_inner);
        let made = made.entry((number, intervals));
        let make = || {
            Arc::new(MirrorWaves::new(
                &self.lattice,
                self.mirrors[number],
                intervals,
            ))
        };
        Arc::clone(made.or_insert_with(make))
    }

    /// Lattice of the grids.
    pub fn lattice(&self) -> &BravaisLattice<D> {
        &self.lattice
    }

    /// Matrix `G^-1/2` of the long-wave metric: with `k = G^-1/2 m` the limit `|k|_h^2 -> k.G k` becomes `|m|^2`.
    pub fn long_wave_map(&self) -> &SMatrix<f64, D, D> {
        &self.long_wave_map
    }

    /// Grid with `resolution` points along each reciprocal vector.
    pub fn grid(&self, resolution: usize) -> Arc<WaveGrid<D>> {
        self.cached((resolution, false), || {
            WaveGrid::new(&self.lattice, resolution)
        })
    }

    /// Grid with each wave vector replaced by its equivalent in the first Brillouin zone of the lattice.
    pub fn folded_grid(&self, resolution: usize) -> Arc<WaveGrid<D>> {
        let plain = self.grid(resolution);
        self.cached((resolution, true), || {
            let zone = BrillouinZone::new(self.lattice);
            plain.folded(|place| zone.shift(place))
        })
    }

    /// Grid for a state, with each wave vector replaced by its equivalent whose image lies in the zone of the deformed lattice. It is not cached.
    pub(crate) fn grid_folded_to(
        &self,
        resolution: usize,
        zone: &BrillouinZone<D>,
    ) -> Arc<WaveGrid<D>> {
        // In units of the reciprocal vectors a wave vector equals its image.
        Arc::new(self.grid(resolution).folded(|place| zone.shift(place)))
    }

    fn cached(&self, key: (usize, bool), make: impl FnOnce() -> WaveGrid<D>) -> Arc<WaveGrid<D>> {
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        Arc::clone(made.entry(key).or_insert_with(|| Arc::new(make())))
    }
}

/// Matrix `m^-1/2` of a symmetric positive definite matrix; NaN if its decomposition does not converge, which requires entries that are not finite.
fn inverse_square_root<const D: usize>(m: &SMatrix<f64, D, D>) -> SMatrix<f64, D, D> {
    let matrix = DMatrix::from_fn(D, D, |i, j| m[(i, j)]);
    let Some(eigen) = hermitian_eigen(matrix) else {
        return SMatrix::repeat(f64::NAN);
    };
    SMatrix::from_fn(|i, j| {
        (0..D)
            .map(|n| {
                let vector = eigen.eigenvectors.column(n);
                vector[i] * vector[j] / eigen.eigenvalues[n].sqrt()
            })
            .sum()
    })
}

#[cfg(test)]
mod tests {
    use super::WaveGrids;
    use crate::lattice::{BrillouinZone, LatticeKind};
    use nalgebra::{Matrix2, Vector2, Vector3};

    /// Includes the lines between `k` and `-k`, and a zone that differs from the zone of the grid and subtracts other vectors.
    #[test]
    fn phases_of_sites_belong_to_the_folded_wave_vectors() {
        let lattice = LatticeKind::Hexagonal.lattice::<2>(1.0).expect("a lattice");
        let grids = WaveGrids::new(lattice);
        let stretch = Matrix2::new(1.3, 0.2, 0.0, 0.6);
        let zone = BrillouinZone::new(lattice.mapped(&stretch).expect("a lattice"));
        for grid in [
            grids.grid(12),
            grids.folded_grid(12),
            grids.grid_folded_to(12, &zone),
        ] {
            for site in [Vector2::new(0.5, 0.0), Vector2::new(0.31, -0.77)] {
                let phases = grid.site_phases(&site);
                for (n, k) in grid.wave_vectors().enumerate().take(grid.half()) {
                    let (sine, cosine) = k.dot(&site).sin_cos();
                    assert!((phases.0[n] - cosine).abs() < 1e-14, "{k} {site}");
                    assert!((phases.1[n] - sine).abs() < 1e-14, "{k} {site}");
                }
            }
        }
    }

    /// Each point is equivalent to the point of the original grid. No equivalent point is closer to zero in the metric of the zone.
    #[test]
    fn folded_wave_vectors_are_equivalent_and_in_the_zone() {
        for (kind, stretch) in [
            (LatticeKind::Hexagonal, Matrix2::new(1.3, 0.2, 0.0, 0.6)),
            (LatticeKind::Hexagonal, Matrix2::new(2.0, 0.0, 0.0, 0.2)),
            (LatticeKind::Square, Matrix2::new(0.4, 1.7, 0.0, 1.0)),
        ] {
            let lattice = kind.lattice::<2>(1.0).expect("a lattice");
            let zone = BrillouinZone::new(lattice.mapped(&stretch).expect("a lattice"));
            let grids = WaveGrids::new(lattice);
            let (plain, folded) = (grids.grid(30), grids.grid_folded_to(30, &zone));
            let back = stretch.transpose().try_inverse().expect("a map");
            let mut moved = 0;
            for (k, own) in plain.wave_vectors().zip(folded.wave_vectors()) {
                let apart = lattice.vectors().transpose() * (k - own) / std::f64::consts::TAU;
                assert!((apart - apart.map(f64::round)).amax() < 1e-12, "{k} {own}");
                assert!(zone.contains(&(back * own), 1e-9), "{k} {own}");
                moved += usize::from(apart.amax() > 0.5);
            }
            assert!(moved > 10, "{moved}");
        }
    }

    #[test]
    fn phases_of_sites_in_three_dimensions_belong_to_the_wave_vectors() {
        let lattice = LatticeKind::FaceCenteredCubic
            .lattice::<3>(1.0)
            .expect("a lattice");
        let grids = WaveGrids::new(lattice);
        let site = Vector3::new(0.31, -0.77, 0.13);
        for grid in [grids.grid(6), grids.folded_grid(6)] {
            let phases = grid.site_phases(&site);
            for (n, k) in grid.wave_vectors().enumerate().take(grid.half()) {
                let (sine, cosine) = k.dot(&site).sin_cos();
                assert!((phases.0[n] - cosine).abs() < 1e-13, "{k}");
                assert!((phases.1[n] - sine).abs() < 1e-13, "{k}");
            }
        }
    }
}
