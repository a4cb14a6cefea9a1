//! First Brillouin zone: the wave vectors nearer to zero than to any other reciprocal lattice vector.

use super::cell::{cell_among, face};
use super::reduction::combinations;
use super::{BravaisLattice, Fractional, Reduced};
use crate::algebra::array_of;
use nalgebra::{SMatrix, SVector};

/// First Brillouin zone of a lattice.
#[derive(Clone, Debug)]
pub struct BrillouinZone<const D: usize> {
    lattice: BravaisLattice<D>,
    /// Primitive vectors whose reciprocal vectors are short.
    dual: SMatrix<f64, D, D>,
    /// Basis of short reciprocal vectors.
    short: Reduced<D>,
    /// Short reciprocal vectors `G`; the zone is `k . G <= |G|^2 / 2` for all of them.
    reciprocal: Vec<SVector<f64, D>>,
    /// Coordinates of these vectors in the basis.
    factors: Vec<SVector<f64, D>>,
    /// Offsets `|G|^2 / 2` of the bisectors.
    bisectors: Vec<f64>,
}

impl<const D: usize> BrillouinZone<D> {
    /// Computes the zone of a lattice.
    pub fn new(lattice: BravaisLattice<D>) -> Self {
        // If no short basis is found, the zone of the given basis is used.
        let short = Reduced::of(lattice.reciprocal())
            .unwrap_or_else(|_| Reduced::given(lattice.reciprocal()));
        let dual = lattice.vectors() * short.inverse.transpose();
        let reciprocal: Vec<SVector<f64, D>> = combinations()
            .map(|factors| short.vectors * factors)
            .collect();
        // The zone is bounded only by vectors whose bisector touches it.
        let beyond =
            |k: &SVector<f64, D>, g: &SVector<f64, D>| k.dot(g) > (0.5 + 1e-9) * g.norm_squared();
        let bounding =
            |g: &SVector<f64, D>| reciprocal.iter().all(|other| !beyond(&(g * 0.5), other));
        let (factors, reciprocal): (Vec<_>, Vec<SVector<f64, D>>) = combinations()
            .zip(&reciprocal)
            .filter(|(_, g)| bounding(g))
            .unzip();
        Self {
            lattice,
            dual,
            short,
            bisectors: reciprocal.iter().map(|g| 0.5 * g.norm_squared()).collect(),
            reciprocal,
            factors,
        }
    }

    /// Lattice of the zone.
    pub fn lattice(&self) -> &BravaisLattice<D> {
        &self.lattice
    }

    /// Reciprocal vectors whose bisectors bound the zone.
    pub(crate) fn bounding_vectors(&self) -> &[SVector<f64, D>] {
        &self.reciprocal
    }

    /// Equivalent wave vector in the zone.
    pub fn folded(&self, k: &SVector<f64, D>) -> SVector<f64, D> {
        self.folded_with_shift(&(self.dual.transpose() * k / std::f64::consts::TAU))
            .0
    }

    /// Equivalent wave vectors that are as short as the wave vector in the zone, including it.
    pub(crate) fn as_short(&self, k: &SVector<f64, D>) -> Vec<SVector<f64, D>> {
        let on_face = |g: &&SVector<f64, D>| k.dot(g) >= (0.5 - 1e-6) * g.norm_squared();
        let others = self.reciprocal.iter().filter(on_face).map(|g| k - g);
        std::iter::once(*k).chain(others).collect()
    }

    /// Multiples of the reciprocal vectors to subtract from a wave vector, given in units of these vectors, to fold it into the zone.
    ///
    /// Wave vectors with equal multiples fill a convex set, an image of the zone.
    pub(crate) fn shift(&self, fractional: &Fractional<D>) -> [i32; D] {
        let (_, shift) = self.folded_with_shift(&(self.short.inverse * fractional));
        let shift = self.short.change * shift;
        array_of(|n| shift[n].round() as i32)
    }

    /// Equivalent wave vector in the zone of a wave vector in units of the short basis, and the multiples of this basis that were subtracted.
    fn folded_with_shift(&self, cycles: &SVector<f64, D>) -> (SVector<f64, D>, SVector<f64, D>) {
        let mut shift = cycles.map(f64::round);
        let mut folded = self.short.vectors * (cycles - shift);
        // Each step shortens the vector. Few steps are needed; the limit only guards against rounding.
        for _ in 0..64 {
            let mut farthest = (0, f64::NEG_INFINITY);
            for (n, (g, half)) in self.reciprocal.iter().zip(&self.bisectors).enumerate() {
                let excess = folded.dot(g) - half;
                if excess >= farthest.1 {
                    farthest = (n, excess);
                }
            }
            let (n, excess) = farthest;
            match self.bisectors.get(n) {
                Some(half) if excess > 2e-12 * half => {
                    folded -= self.reciprocal[n];
                    shift += self.factors[n];
                }
                _ => break,
            }
        }
        (folded, shift)
    }

    /// Returns true if a wave vector lies in the zone, up to a relative tolerance.
    pub fn contains(&self, k: &SVector<f64, D>, tolerance: f64) -> bool {
        self.reciprocal
            .iter()
            .all(|g| k.dot(g) <= (0.5 + tolerance) * g.norm_squared())
    }

    /// Factor `t` that moves a wave vector to the boundary of the zone; infinite for zero.
    ///
    /// ```
    /// use nalgebra::Vector2;
    /// use onset::lattice::{LatticeKind, BrillouinZone};
    /// let zone = BrillouinZone::new(LatticeKind::Square.lattice::<2>(1.0)?);
    /// let reach = zone.reach(&Vector2::new(0.5, 0.25));
    /// assert!((reach - std::f64::consts::TAU).abs() < 1e-14);
    /// # Ok::<(), onset::lattice::LatticeError>(())
    /// ```
    pub fn reach(&self, k: &SVector<f64, D>) -> f64 {
        let ahead = self.reciprocal.iter().filter(|g| k.dot(g) > 0.0);
        ahead
            .map(|g| 0.5 * g.norm_squared() / k.dot(g))
            .fold(f64::INFINITY, f64::min)
    }

    /// Wave vector with the given coordinates in units of the reciprocal vectors.
    pub fn wave_vector(&self, fractional: &Fractional<D>) -> SVector<f64, D> {
        self.lattice.reciprocal() * fractional
    }

    /// Corners of the zone: in two dimensions counterclockwise, in one dimension its two ends.
    pub fn corners(&self) -> Vec<SVector<f64, D>> {
        cell_among(&self.reciprocal).corners
    }

    /// Faces of the zone in three dimensions, given by their corners in cyclic order, one of each opposite pair. Empty in one and two dimensions.
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
