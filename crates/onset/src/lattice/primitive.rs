//! Primitive cell of particles and marked points that are described in a larger cell.

use super::{
    BravaisLattice, Crystal, Fractional, LatticeError, Reduced, inverse_of, per_particle, shortest,
};
use crate::algebra::array_of;
use crate::cancel::checkpoint;
use nalgebra::{SMatrix, SVector};

/// Largest distance, as a fraction of the mean particle distance, and largest relative difference of volumes that are rounding errors.
const PLACE_TOLERANCE: f64 = 1e-9;

/// Largest number of combinations of lattice coordinates that are all origins.
const MOST_ORIGINS: usize = 8;

/// Particles of a cell with the points that repeat with it, each with its volume.
#[derive(Clone, Debug)]
pub(crate) struct Cell<const D: usize> {
    vectors: SMatrix<f64, D, D>,
    particles: Vec<(Fractional<D>, f64)>,
    pub(crate) points: Vec<(Fractional<D>, f64)>,
}

impl<const D: usize> Cell<D> {
    pub(crate) fn new(crystal: &Crystal<D>, points: Vec<(Fractional<D>, f64)>) -> Self {
        let sites = crystal.sites().iter().copied();
        Self {
            vectors: *crystal.lattice().vectors(),
            particles: sites.zip(crystal.volumes().iter().copied()).collect(),
            points,
        }
    }

    /// Primitive cell in the canonical basis; `None` if the cell is already primitive.
    pub(crate) fn primitive(&self) -> Option<Self> {
        let mut smaller = self.divided()?;
        while let Some(divided) = smaller.divided() {
            smaller = divided;
        }
        let reduced = Reduced::unique(&smaller.vectors).ok()?;
        Some(smaller.in_basis(reduced.vectors, &reduced.inverse))
    }

    /// Describes the cell in the canonical basis, about an origin in lattice coordinates of this basis relative to the first particle. Particles and
    /// points lie in the cell at the origin.
    pub(crate) fn reduced(&self, origin: &Fractional<D>) -> Result<Self, LatticeError> {
        let reduced = Reduced::unique(&self.vectors)?;
        let cell = self.in_basis(reduced.vectors, &reduced.inverse);
        Ok(cell.about(origin))
    }

    /// Particles without the points.
    pub(crate) fn crystal(&self) -> Option<Crystal<D>> {
        let (sites, volumes): (Vec<_>, Vec<_>) = self.particles.iter().copied().unzip();
        let lattice = BravaisLattice::new(self.vectors)?;
        Crystal::with_volumes(lattice, sites, volumes).ok()
    }

    /// Divides the cell by a translation that maps its particles and points onto themselves.
    fn divided(&self) -> Option<Self> {
        let first = self.particles.first()?.0;
        let others = self.particles.iter().skip(1);
        let order = others
            .map(|(place, _)| place - first)
            .find(|translation| {
                checkpoint();
                self.is_repeated_by(translation)
            })
            .and_then(|translation| self.multiple(&translation))?;
        let (count, steps) = order;
        let basis = basis_with::<D>(count, steps);
        let inverse = inverse_of(&basis)?;
        Some(self.in_basis(self.vectors * basis, &inverse))
    }

    /// Describes the particles and points in a basis of the same or a finer lattice, without duplicates.
    fn in_basis(&self, vectors: SMatrix<f64, D, D>, to_basis: &SMatrix<f64, D, D>) -> Self {
        let first = self.particles.first();
        let origin = first.map_or_else(SVector::zeros, |own| own.0);
        let moved = |list: &[(Fractional<D>, f64)]| {
            let in_basis = |(place, volume): &(_, _)| (to_basis * (place - origin), *volume);
            list.iter().map(in_basis).collect()
        };
        let cell = Self {
            vectors,
            particles: moved(&self.particles),
            points: moved(&self.points),
        };
        cell.about(&SVector::zeros())
    }

    /// Particles and points in the cell at an origin, relative to it, without duplicates.
    fn about(&self, origin: &Fractional<D>) -> Self {
        let rounding = self.rounding();
        let once = |list: &[(Fractional<D>, f64)]| {
            let mut known: Vec<(Fractional<D>, f64)> = Vec::new();
            for (place, volume) in list {
                let place = place - origin;
                let is_new =
                    |(other, _): &(Fractional<D>, f64)| self.apart(&place, other) > rounding;
                if known.iter().all(is_new) {
                    let folded = place.map(|x| x - (x + PLACE_TOLERANCE).floor());
                    // A position close to the origin is set to the origin exactly.
                    let settled = folded.map(|x| if x.abs() < PLACE_TOLERANCE { 0.0 } else { x });
                    known.push((settled, *volume));
                }
            }
            known
        };
        Self {
            particles: once(&self.particles),
            points: once(&self.points),
            vectors: self.vectors,
        }
    }

    /// Distance of two points, or of their nearest images; length.
    fn apart(&self, a: &Fractional<D>, b: &Fractional<D>) -> f64 {
        let apart = a - b;
        (self.vectors * (apart - apart.map(f64::round))).norm()
    }

    fn rounding(&self) -> f64 {
        let volume: f64 = self.particles.iter().map(|own| own.1).sum();
        PLACE_TOLERANCE * (volume / self.particles.len().max(1) as f64).powf(1.0 / D as f64)
    }

    fn is_repeated_by(&self, translation: &Fractional<D>) -> bool {
        self.is_kept_by(|place| place + translation)
    }

    /// Returns true if a map of places takes the particles and points onto themselves.
    pub(super) fn is_kept_by(&self, image: impl Fn(&Fractional<D>) -> Fractional<D>) -> bool {
        let rounding = self.rounding();
        [&self.particles, &self.points].into_iter().all(|list| {
            list.iter().all(|(place, volume)| {
                let moved = image(place);
                list.iter().any(|(other, own)| {
                    (own - volume).abs() <= PLACE_TOLERANCE * volume.abs()
                        && self.apart(&moved, other) <= rounding
                })
            })
        })
    }

    /// Number of repetitions after which a translation is a lattice vector, and this vector.
    fn multiple(&self, translation: &Fractional<D>) -> Option<(i64, [i64; D])> {
        let zero = SVector::zeros();
        (2..=self.particles.len()).find_map(|count| {
            let whole = translation * count as f64;
            let is_whole = self.apart(&whole, &zero) <= self.rounding() * count as f64;
            is_whole.then(|| (count as i64, array_of(|i| whole[i].round() as i64)))
        })
    }
}

/// Basis, in columns, of the lattice spanned by the integers and the vector `steps / count`. Integer row operations reduce the last row to zero.
fn basis_with<const D: usize>(count: i64, steps: [i64; D]) -> SMatrix<f64, D, D> {
    let unit = |i: usize| array_of::<_, D>(|j| if i == j { count } else { 0 });
    let mut rows: Vec<[i64; D]> = (0..D).map(unit).chain([steps]).collect();
    for column in 0..D {
        // Euclid's algorithm on the entries of a column.
        while let Some(other) = (column + 1..=D).find(|row| rows[*row][column] != 0) {
            let pivot = rows[column][column];
            let factor = match pivot {
                0 => 0,
                pivot => rows[other][column].div_euclid(pivot),
            };
            let rest = array_of(|j| rows[other][j] - factor * rows[column][j]);
            rows[other] = rows[column];
            rows[column] = rest;
            if rows[column][column] == 0 {
                rows.swap(column, other);
            }
        }
    }
    SMatrix::from_fn(|i, j| rows[j][i] as f64 / count as f64)
}

impl<const D: usize> Crystal<D> {
    /// Describes the particles in their primitive cell, in the canonical basis; `None` if the cell is already primitive.
    ///
    /// ```
    /// use onset::lattice::{Crystal, LatticeKind};
    /// let square = Crystal::<2>::of(LatticeKind::Square, 1.0)?;
    /// let primitive = square.supercell([3, 2])?.primitive().ok_or("primitive")?;
    /// assert_eq!(primitive.sites().len(), 1);
    /// assert!((primitive.lattice().cell_volume() - 1.0).abs() < 1e-14);
    /// assert!(primitive.primitive().is_none());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn primitive(&self) -> Option<Self> {
        Cell::new(self, Vec::new()).primitive()?.crystal()
    }

    /// Describes the particles in the canonical basis of their lattice, in the cell at an origin, as [`Cell::reduced`] does.
    pub(crate) fn reduced(&self, origin: &Fractional<D>) -> Result<Self, LatticeError> {
        let cell = Cell::new(self, Vec::new()).reduced(origin)?;
        let crystal = cell.crystal().ok_or(LatticeError::NoSites)?;
        Ok(crystal.with_spacing(self.spacing()))
    }

    /// Origins for which the cell at the origin has different particles on its lower faces: every combination of the lattice coordinates of the
    /// particles, or only the particles themselves if there are many combinations.
    pub(crate) fn origins(&self) -> Vec<Fractional<D>> {
        let along = |i: usize| {
            let mut known: Vec<f64> = Vec::new();
            for x in self.sites().iter().map(|place| place[i]) {
                let is_new = |other: &f64| {
                    let apart = x - other;
                    (apart - apart.round()).abs() > PLACE_TOLERANCE
                };
                if known.iter().all(is_new) {
                    known.push(x);
                }
            }
            known
        };
        let along: [Vec<f64>; D] = std::array::from_fn(along);
        let count: usize = along.iter().map(Vec::len).product();
        if count > MOST_ORIGINS {
            return self.sites().to_vec();
        }
        let combined = |mut n: usize| {
            SVector::from_fn(|i, _| {
                let own = &along[i];
                let x = own[n % own.len()];
                n /= own.len();
                x
            })
        };
        (0..count).map(combined).collect()
    }

    /// Spacing derived only from the particles of a primitive cell; `None` if they have no natural spacing.
    ///
    /// It is the distance of nearest neighbors in a Bravais lattice, and also if every particle has more nearest neighbors than dimensions, as in
    /// honeycombs and closest packings.
    pub(super) fn natural_spacing(&self) -> Option<f64> {
        if self.sites().len() == 1 {
            return Some(shortest(self.lattice()));
        }
        let nearest = self.nearest_distance();
        let rim = nearest * (1.0 + 1e-6);
        // Each particle lies within the radius around itself.
        let neighbors = |place| self.within(place, rim, &SMatrix::identity()).len() - 1;
        self.sites()
            .iter()
            .all(|place| neighbors(place) > D)
            .then_some(nearest)
    }

    /// Distance of nearest neighbors in a lattice of the same shape with one particle per cell.
    pub(super) fn mean_spacing(&self) -> f64 {
        shortest(self.lattice()) * per_particle::<D>(self.sites().len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::LatticeKind;

    /// Supercells by any integer matrix reduce to the primitive cell.
    #[test]
    fn every_supercell_has_the_same_primitive_cell() {
        let rows: [[i64; 2]; 4] = [[2, 0], [1, 1], [3, 1], [-1, 2]];
        for kind in [
            LatticeKind::Square,
            LatticeKind::Hexagonal,
            LatticeKind::Honeycomb,
        ] {
            let crystal = Crystal::<2>::of(kind, 1.3).expect("a crystal");
            for (a, b) in rows.iter().flat_map(|a| rows.iter().map(move |b| (a, b))) {
                let matrix =
                    SMatrix::<f64, 2, 2>::new(a[0] as f64, b[0] as f64, a[1] as f64, b[1] as f64);
                let count = super::super::determinant(&matrix).abs().round() as usize;
                if count < 2 {
                    continue;
                }
                let vectors = crystal.lattice().vectors() * matrix;
                let inverse = inverse_of(&matrix).expect("an inverse");
                let mut sites: Vec<Fractional<2>> = Vec::new();
                for cell in super::super::cells_between(&[-9; 2], &[9; 2]) {
                    for site in crystal.sites() {
                        let place = inverse * (site + SVector::from(cell.map(f64::from)));
                        if place.iter().all(|x| (-1e-9..1.0 - 1e-9).contains(x)) {
                            sites.push(place);
                        }
                    }
                }
                assert_eq!(sites.len(), count * crystal.sites().len());
                let lattice = BravaisLattice::new(vectors).expect("a lattice");
                let large = Crystal::new(lattice, sites).expect("a crystal");
                let small = large.primitive().expect("a smaller cell");
                assert_eq!(
                    small.sites().len(),
                    crystal.sites().len(),
                    "{kind:?} {matrix}"
                );
                let difference = small.lattice().vectors() - crystal.lattice().vectors();
                assert!(difference.amax() < 1e-12, "{kind:?} {matrix} {difference}");
                assert!(small.primitive().is_none());
                assert!((small.natural_spacing().expect("regular") - 1.3).abs() < 1e-12);
                assert!((small.volumes()[0] - crystal.volumes()[0]).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn different_volumes_and_marked_points_prevent_reduction_of_a_cell() {
        let square = LatticeKind::Square.lattice::<2>(1.0).expect("a lattice");
        let two = Crystal::of_lattice(square)
            .supercell([2, 1])
            .expect("a crystal");
        assert_eq!(two.primitive().expect("a smaller cell").sites().len(), 1);
        let unequal = Crystal::with_volumes(*two.lattice(), two.sites().to_vec(), vec![0.9, 1.1]);
        assert!(unequal.expect("a crystal").primitive().is_none());
        let point = |x: f64| (SVector::from([x, 0.5]), 1.0);
        let with = |points| Cell::new(&two, points).primitive();
        assert!(with(vec![point(0.25), point(0.6)]).is_none());
        let smaller = with(vec![point(0.25), point(0.75)]).expect("a smaller cell");
        assert_eq!(smaller.points.len(), 1);
    }
}
