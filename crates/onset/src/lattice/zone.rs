//! The first Brillouin zone: the wave vectors nearer to zero than to any reciprocal vector.

use super::cell::{cell_among, face};
use super::{BravaisLattice, Fractional};
use nalgebra::SVector;

/// The first Brillouin zone of a lattice.
#[derive(Clone, Debug)]
pub struct BrillouinZone<const D: usize> {
    lattice: BravaisLattice<D>,
    /// Short reciprocal vectors `G`; the zone is `k . G <= |G|^2 / 2` for all of them.
    reciprocal: Vec<SVector<f64, D>>,
}

impl<const D: usize> BrillouinZone<D> {
    /// The zone of a lattice.
    pub fn new(lattice: BravaisLattice<D>) -> Self {
        // A strongly sheared or stretched lattice has its shortest reciprocal vectors at larger
        // integer coordinates: |G| <= radius bounds coordinate i by radius |a_i| / (2 pi).
        let radius = lattice
            .reciprocal()
            .column_iter()
            .map(|b| b.norm())
            .sum::<f64>();
        let reach: [i64; D] = std::array::from_fn(|i| {
            let bound = radius * lattice.vectors().column(i).norm() / std::f64::consts::TAU;
            bound.ceil().min(64.0) as i64
        });
        let mut reciprocal = Vec::new();
        let mut cell = reach.map(|r| -r);
        loop {
            let g = lattice.reciprocal() * SVector::<f64, D>::from_fn(|i, _| cell[i] as f64);
            if cell.iter().any(|&n| n != 0) && g.norm() <= radius * (1.0 + 1e-12) {
                reciprocal.push(g);
            }
            let Some(axis) = (0..D).find(|&i| cell[i] < reach[i]) else {
                break;
            };
            for lower in 0..axis {
                cell[lower] = -reach[lower];
            }
            cell[axis] += 1;
        }
        // Only those whose bisector touches the zone bound it.
        let beyond =
            |k: &SVector<f64, D>, g: &SVector<f64, D>| k.dot(g) > (0.5 + 1e-9) * g.norm_squared();
        let bounding =
            |g: &SVector<f64, D>| reciprocal.iter().all(|other| !beyond(&(g * 0.5), other));
        let reciprocal = reciprocal.iter().filter(|g| bounding(g)).copied().collect();
        Self {
            lattice,
            reciprocal,
        }
    }

    /// The lattice whose zone this is.
    pub fn lattice(&self) -> &BravaisLattice<D> {
        &self.lattice
    }

    /// The reciprocal vectors whose bisectors bound the zone.
    pub(crate) fn bounding_vectors(&self) -> &[SVector<f64, D>] {
        &self.reciprocal
    }

    /// The equivalent wave vector in the zone.
    pub fn folded(&self, k: &SVector<f64, D>) -> SVector<f64, D> {
        let cycles = self.lattice.vectors().transpose() * k / std::f64::consts::TAU;
        let mut folded = self.lattice.reciprocal() * cycles.map(|x| x - x.round());
        // Each step shortens the vector; few are needed, and the bound only guards rounding.
        for _ in 0..64 {
            let excess = |g: &SVector<f64, D>| folded.dot(g) - 0.5 * g.norm_squared();
            let farthest = self
                .reciprocal
                .iter()
                .max_by(|a, b| excess(a).total_cmp(&excess(b)));
            match farthest {
                Some(g) if excess(g) > 1e-12 * g.norm_squared() => folded -= g,
                _ => break,
            }
        }
        folded
    }

    /// Whether a wave vector lies in the zone, up to a relative tolerance.
    pub fn contains(&self, k: &SVector<f64, D>, tolerance: f64) -> bool {
        self.reciprocal
            .iter()
            .all(|g| k.dot(g) <= (0.5 + tolerance) * g.norm_squared())
    }

    /// The wave vector with the given coordinates in units of the reciprocal vectors.
    pub fn wave_vector(&self, fractional: &Fractional<D>) -> SVector<f64, D> {
        self.lattice.reciprocal() * fractional
    }

    /// The corners of the zone: in two dimensions counterclockwise, in one dimension its two ends.
    pub fn corners(&self) -> Vec<SVector<f64, D>> {
        cell_among(&self.reciprocal).corners
    }

    /// The faces of the zone in three dimensions, each by its corners in turn; one of each pair of opposite ones. None in
    /// one and two dimensions.
    pub(crate) fn faces(&self) -> Vec<Vec<SVector<f64, D>>> {
        if D != 3 {
            return Vec::new();
        }
        let is_first = |g: &&SVector<f64, D>| {
            g.iter()
                .find(|x| x.abs() > 1e-9 * g.amax())
                .is_some_and(|x| *x > 0.0)
        };
        self.reciprocal
            .iter()
            .filter(is_first)
            .map(|g| face(g, &self.reciprocal))
            .filter(|face| !face.is_empty())
            .collect()
    }
}
