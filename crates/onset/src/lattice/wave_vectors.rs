//! Grids of wave vectors over a cell of the reciprocal lattice, and what of them no state changes.

use super::BravaisLattice;
use super::mirror::{Mirror, MirrorWaves};
use super::numbering::{coordinates, opposite};
use super::symmetry::{Symmetry, Wedge};
use crate::algebra::{Complex, array_of};
use nalgebra::{DMatrix, SMatrix, SVector};
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// The wave vectors `k = sum_i (j_i / n) b_i`, `j_i = 0 .. n`, first index slowest, with the phases of the lattice
/// vectors and the lattice Laplacian.
///
/// Indices beyond `n / 2` stand for negative ones, so that the vectors surround zero.
#[derive(Debug)]
pub struct WaveGrid<const D: usize> {
    resolution: usize,
    wave_vectors: Vec<SVector<f64, D>>,
    laplacian: Arc<Vec<f64>>,
    /// `cos` and `sin` of `2 pi m j / n`, `j = 0 .. n`, for each `m` from `-n / 2` to `n / 2`.
    turned: Arc<Vec<(Vec<f64>, Vec<f64>)>>,
    lattice: BravaisLattice<D>,
    /// What has been taken off wave vectors that were folded.
    shifts: Option<Shifts<D>>,
    site_phases: Mutex<SitePhases<D>>,
}

/// What folding takes off wave vectors: few different ones for many wave vectors.
#[derive(Debug, Default)]
struct Shifts<const D: usize> {
    distinct: Vec<SVector<f64, D>>,
    /// The place of the shift of each wave vector among these.
    of_wave: Vec<u32>,
}

/// Sites with the cosine and the sine of `k.site` at all wave vectors.
type SitePhases<const D: usize> = Vec<(SVector<f64, D>, Arc<(Vec<f64>, Vec<f64>)>)>;

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
            wave_vectors,
            turned: Arc::new((-(n / 2)..=n / 2).map(turned).collect()),
            lattice: *lattice,
            shifts: None,
            site_phases: Mutex::new(Vec::new()),
        }
    }

    /// The same with each wave vector replaced by an equivalent one, of `k` and `-k` by opposite ones.
    fn folded(&self, folded: impl Fn(&SVector<f64, D>) -> SVector<f64, D>) -> Self {
        let mut wave_vectors = self.wave_vectors.clone();
        let mut shifts = Shifts::default();
        let mut known: Vec<[i32; D]> = Vec::new();
        // How many of each reciprocal vector a wave vector is.
        let cycles = self.lattice.vectors().transpose() / TAU;
        for index in 0..wave_vectors.len() {
            let opposite = opposite::<D>(index, self.resolution);
            let own = if opposite < index {
                -wave_vectors[opposite]
            } else {
                folded(&wave_vectors[index])
            };
            let shift = wave_vectors[index] - own;
            let steps = array_of(|d| (cycles.row(d) * shift)[0].round() as i32);
            let place = known.iter().position(|other| *other == steps);
            shifts.of_wave.push(place.unwrap_or(known.len()) as u32);
            if place.is_none() {
                known.push(steps);
                shifts.distinct.push(shift);
            }
            wave_vectors[index] = own;
        }
        Self {
            resolution: self.resolution,
            laplacian: Arc::clone(&self.laplacian),
            wave_vectors,
            turned: Arc::clone(&self.turned),
            lattice: self.lattice,
            shifts: Some(shifts),
            site_phases: Mutex::new(Vec::new()),
        }
    }

    /// Points along each reciprocal vector.
    pub fn resolution(&self) -> usize {
        self.resolution
    }

    /// The wave vectors; 1/length.
    pub fn wave_vectors(&self) -> &[SVector<f64, D>] {
        &self.wave_vectors
    }

    /// The lattice Laplacian `|k|_h^2` of each; 1/length^2.
    pub fn laplacian(&self) -> &[f64] {
        &self.laplacian
    }

    /// `cos` and `sin` of `2 pi m / n`.
    pub(crate) fn on_circle(&self, m: i64) -> (f64, f64) {
        let unit = &self.turned[self.resolution / 2 + 1];
        let m = m.rem_euclid(self.resolution as i64) as usize;
        (unit.0[m], unit.1[m])
    }

    /// `cos` and `sin` of `2 pi m j / n` for all `j`. `m` of either sign is taken modulo `n`.
    pub(crate) fn turned(&self, m: i32) -> (&[f64], &[f64]) {
        let n = self.resolution as i64;
        let nearest = (i64::from(m) + n / 2).rem_euclid(n);
        let (cosines, sines) = &self.turned[nearest as usize];
        (cosines, sines)
    }

    /// `cos k.site` and `sin k.site` at all wave vectors, computed once a site.
    pub(crate) fn site_phases(&self, site: &SVector<f64, D>) -> Arc<(Vec<f64>, Vec<f64>)> {
        let mut known = self
            .site_phases
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        if let Some((_, phases)) = known.iter().find(|(other, _)| other == site) {
            return Arc::clone(phases);
        }
        let phases: Arc<(Vec<f64>, Vec<f64>)> =
            Arc::new(self.phases_of(site).iter().map(|p| (p.re, p.im)).unzip());
        known.push((*site, Arc::clone(&phases)));
        phases
    }

    /// `exp(i k.site)`: a product of those along the reciprocal vectors, and of that of the shift, with far fewer sines than wave vectors.
    fn phases_of(&self, site: &SVector<f64, D>) -> Vec<Complex> {
        let turned = |angle: f64| Complex::from_polar(1.0, angle);
        let mut phases = vec![Complex::new(1.0, 0.0)];
        for axis in self.lattice.reciprocal().column_iter() {
            let along = axis.dot(site);
            let line: Vec<Complex> = (0..self.resolution)
                .map(|j| turned(centered(j, self.resolution) * along))
                .collect();
            let next = phases
                .iter()
                .flat_map(|phase| line.iter().map(move |own| phase * own));
            phases = next.collect();
        }
        if let Some(shifts) = &self.shifts {
            let distinct: Vec<Complex> = shifts
                .distinct
                .iter()
                .map(|shift| turned(-shift.dot(site)))
                .collect();
            for (phase, place) in phases.iter_mut().zip(&shifts.of_wave) {
                *phase *= distinct[*place as usize];
            }
        }
        phases
    }
}

/// A number of a grid along an axis as a part of the reciprocal vector; beyond the middle it stands for a negative one.
fn centered(j: usize, resolution: usize) -> f64 {
    let (j, n) = (j as f64, resolution as f64);
    (if 2.0 * j > n { j - n } else { j }) / n
}

/// The grids of one lattice, each made when it is first asked for.
#[derive(Debug)]
pub struct WaveGrids<const D: usize> {
    lattice: BravaisLattice<D>,
    long_wave_map: SMatrix<f64, D, D>,
    made: Mutex<BTreeMap<(usize, bool), Arc<WaveGrid<D>>>>,
    mirrors: Vec<Mirror>,
    mirrored: Mutex<MirroredGrids>,
    symmetries: OnceLock<Vec<Symmetry<D>>>,
    /// By resolution, and the numbers of the symmetries as bits.
    wedges: Mutex<BTreeMap<(usize, u64), Arc<Wedge>>>,
}

/// The part of grids that a mirror leaves, by the mirror's number and the steps along its lines.
type MirroredGrids = BTreeMap<(usize, [usize; 2]), Arc<MirrorWaves>>;

impl<const D: usize> WaveGrids<D> {
    /// For a lattice.
    pub fn new(lattice: BravaisLattice<D>) -> Self {
        // The sums along mirror lines know the lattice Laplacian by the phases of the primitive vectors.
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
            wedges: Mutex::new(BTreeMap::new()),
        }
    }

    /// The symmetries of the lattice.
    pub(crate) fn symmetries(&self) -> &[Symmetry<D>] {
        self.symmetries.get_or_init(|| Symmetry::all(&self.lattice))
    }

    /// Which points of a grid are mapped to each other by those symmetries whose bits are set.
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

    /// The mirrors of the lattice.
    pub(crate) fn mirrors(&self) -> &[Mirror] {
        &self.mirrors
    }

    /// The part of a grid that the mirror with a number leaves, with at least the given steps along its lines.
    pub(crate) fn mirrored(&self, number: usize, steps: [usize; 2]) -> Arc<MirrorWaves> {
        // Lines are filled up anyway.
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

    /// The lattice.
    pub fn lattice(&self) -> &BravaisLattice<D> {
        &self.lattice
    }

    /// `G^-1/2` of the long-wave metric: with `k = G^-1/2 m` the scale `|k|_h^2 -> k.G k` becomes `|m|^2`.
    pub fn long_wave_map(&self) -> &SMatrix<f64, D, D> {
        &self.long_wave_map
    }

    /// The grid with `resolution` points along each reciprocal vector.
    pub fn grid(&self, resolution: usize) -> Arc<WaveGrid<D>> {
        self.cached((resolution, false), || {
            WaveGrid::new(&self.lattice, resolution)
        })
    }

    /// The same with each wave vector replaced by its equivalent in the first Brillouin zone of the lattice.
    pub fn folded_grid(&self, resolution: usize) -> Arc<WaveGrid<D>> {
        let plain = self.grid(resolution);
        self.cached((resolution, true), || {
            let zone = super::BrillouinZone::new(self.lattice);
            plain.folded(|k| zone.folded(k))
        })
    }

    /// A grid with wave vectors replaced by equivalent ones that depend on the state; not kept.
    pub fn grid_folded_by(
        &self,
        resolution: usize,
        folded: impl Fn(&SVector<f64, D>) -> SVector<f64, D>,
    ) -> Arc<WaveGrid<D>> {
        Arc::new(self.grid(resolution).folded(folded))
    }

    fn cached(&self, key: (usize, bool), make: impl FnOnce() -> WaveGrid<D>) -> Arc<WaveGrid<D>> {
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        Arc::clone(made.entry(key).or_insert_with(|| Arc::new(make())))
    }
}

/// `m^-1/2` of a symmetric positive definite matrix; NaN where its decomposition does not converge, which needs
/// entries that are not finite.
fn inverse_square_root<const D: usize>(m: &SMatrix<f64, D, D>) -> SMatrix<f64, D, D> {
    let matrix = DMatrix::from_fn(D, D, |i, j| m[(i, j)]);
    let Some(eigen) = matrix.try_symmetric_eigen(f64::EPSILON, 200) else {
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

    /// Also on the lines between `k` and `-k`, and where a zone that is not that of the grid takes other vectors off.
    #[test]
    fn phases_of_sites_are_those_of_folded_wave_vectors() {
        let lattice = LatticeKind::Hexagonal.lattice::<2>(1.0).expect("a lattice");
        let grids = WaveGrids::new(lattice);
        let stretch = Matrix2::new(1.3, 0.2, 0.0, 0.6);
        let zone = BrillouinZone::new(lattice.mapped(&stretch).expect("a lattice"));
        let folded = |k: &Vector2<f64>| {
            stretch.transpose()
                * zone.folded(&(stretch.transpose().try_inverse().expect("a map") * k))
        };
        for grid in [
            grids.grid(12),
            grids.folded_grid(12),
            grids.grid_folded_by(12, folded),
        ] {
            for site in [Vector2::new(0.5, 0.0), Vector2::new(0.31, -0.77)] {
                let phases = grid.site_phases(&site);
                for (n, k) in grid.wave_vectors().iter().enumerate() {
                    let (sine, cosine) = k.dot(&site).sin_cos();
                    assert!((phases.0[n] - cosine).abs() < 1e-14, "{k} {site}");
                    assert!((phases.1[n] - sine).abs() < 1e-14, "{k} {site}");
                }
            }
        }
    }

    #[test]
    fn phases_of_sites_in_space_are_those_of_the_wave_vectors() {
        let lattice = LatticeKind::FaceCenteredCubic
            .lattice::<3>(1.0)
            .expect("a lattice");
        let grids = WaveGrids::new(lattice);
        let site = Vector3::new(0.31, -0.77, 0.13);
        for grid in [grids.grid(6), grids.folded_grid(6)] {
            let phases = grid.site_phases(&site);
            for (n, k) in grid.wave_vectors().iter().enumerate() {
                let (sine, cosine) = k.dot(&site).sin_cos();
                assert!((phases.0[n] - cosine).abs() < 1e-13, "{k}");
                assert!((phases.1[n] - sine).abs() < 1e-13, "{k}");
            }
        }
    }
}
