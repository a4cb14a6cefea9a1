//! Rotations and reflections that map a lattice onto itself, and the orbits of grid points of wave vectors under them.

use super::numbering::{coordinates, index};
use super::reduction::combinations;
use super::{BravaisLattice, BrillouinZone, Cell, Crystal, Fractional, Reduced, inverse_of};
use crate::algebra::{Each, array_of, sort_by_value};
use nalgebra::{SMatrix, SVector};
use std::cmp::Ordering;
use std::ops::Range;

/// Difference of lengths and angles that counts as rounding, relative to the longest vector squared.
const LENGTH_TOLERANCE: f64 = 1e-9;

/// Relative error of the components of a wave vector at the end of a descent.
pub(crate) const WAVE_VECTOR_ERROR: f64 = 1e-5;

/// Orthogonal map of a lattice onto itself.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Symmetry<const D: usize> {
    pub(crate) map: SMatrix<f64, D, D>,
    /// Effect on lattice coordinates: the integers `A^-1 R A`, by rows.
    of_cells: [[i32; D]; D],
}

impl<const D: usize> Symmetry<D> {
    /// All symmetries of a lattice.
    pub(crate) fn all(lattice: &BravaisLattice<D>) -> Vec<Self> {
        let Some(inverse) = inverse_of(lattice.vectors()) else {
            return Vec::new();
        };
        let of_map = |map: SMatrix<f64, D, D>| {
            let cells = inverse * map * lattice.vectors();
            let row = |i: usize| array_of(|j| cells[(i, j)].round() as i32);
            Self {
                map,
                of_cells: array_of(row),
            }
        };
        lattice.holohedry().into_iter().map(of_map).collect()
    }

    /// Image of a lattice vector under the symmetry.
    pub(crate) fn of_cell(&self, cell: &[i32; D]) -> [i32; D] {
        self.of_cells
            .each(|row| row.iter().zip(cell).map(|(n, c)| n * c).sum())
    }

    /// Effect of the inverse on the components of a wave vector in units of the reciprocal vectors, by rows.
    pub(crate) fn of_components(&self) -> [[f64; D]; D] {
        array_of(|j| array_of(|i| f64::from(self.of_cells[i][j])))
    }

    /// Image of lattice coordinates under the symmetry.
    pub(crate) fn of_place(&self, place: &Fractional<D>) -> Fractional<D> {
        SVector::from_fn(|i, _| {
            (0..D)
                .map(|j| f64::from(self.of_cells[i][j]) * place[j])
                .sum()
        })
    }

    /// Image of a wave vector with given coordinates under the inverse: `k.(R a) = (R^-1 k).a`.
    fn of_wave(&self, coordinates: &[usize; D], resolution: usize) -> [usize; D] {
        array_of(|j| {
            let sum: i64 = (0..D)
                .map(|i| i64::from(self.of_cells[i][j]) * coordinates[i] as i64)
                .sum();
            sum.rem_euclid(resolution as i64) as usize
        })
    }
}

/// Orbits of the points of a grid of wave vectors, restricted to first indices up to half of the resolution.
#[derive(Debug)]
pub(crate) struct Wedge {
    /// First point of the orbit of each point.
    pub(crate) first: Vec<u32>,
    /// Range along each line (all indices except the last) of the points that are the first of their orbit.
    pub(crate) lines: Vec<Range<usize>>,
}

impl Wedge {
    /// Computes the orbits of a group that contains inversion.
    pub(crate) fn new<const D: usize>(group: &[Symmetry<D>], resolution: usize) -> Self {
        let half = (resolution / 2 + 1) * resolution.pow(D as u32 - 1);
        let first = |number: usize| {
            let own = coordinates::<D>(number, resolution);
            let image =
                |symmetry: &Symmetry<D>| index(symmetry.of_wave(&own, resolution), resolution);
            group.iter().map(image).fold(number, usize::min) as u32
        };
        let first: Vec<u32> = (0..half).map(first).collect();
        let line = |(number, line): (usize, &[u32])| {
            let is_first = |j: &usize| line[*j] as usize == number * resolution + j;
            let begin = (0..resolution).find(is_first).unwrap_or(0);
            let end = (begin..resolution).rfind(is_first).map_or(begin, |j| j + 1);
            begin..end
        };
        Self {
            lines: first
                .chunks_exact(resolution)
                .enumerate()
                .map(line)
                .collect(),
            first,
        }
    }

    /// Copies values from the first point of each orbit to all its points.
    ///
    /// Points are processed in order. Even if rounding removes some symmetries of a group, the first point therefore already has a value.
    pub(crate) fn spread(&self, values: &mut [f64]) {
        for (index, first) in self.first.iter().enumerate() {
            values[index] = values[*first as usize];
        }
    }

    /// Returns true if a point is the first of its orbit.
    pub(crate) fn is_first(&self, index: usize) -> bool {
        self.first[index] as usize == index
    }
}

impl<const D: usize> BravaisLattice<D> {
    /// Halves of the reciprocal vectors, without duplicates. In these waves neighbors move in opposite directions, and operators that are symmetric
    /// about the particles give zero. 1/length.
    pub(crate) fn alternating(&self) -> impl Iterator<Item = SVector<f64, D>> {
        let reciprocal = *self.reciprocal();
        (1..1_usize << D).map(move |bits| {
            reciprocal * SVector::from_fn(|i, _| 0.5 * f64::from(u8::from(bits >> i & 1 == 1)))
        })
    }

    /// Holohedry of the lattice: all orthogonal maps `R` of lattice vectors to lattice vectors, the identity first.
    ///
    /// These maps also map the reciprocal lattice onto itself, so `R k` is defined for wave vectors. Between Minkowski-reduced bases all coordinates
    /// are -1, 0 or 1 in up to three dimensions, so the number of possible maps is finite.
    ///
    /// ```
    /// use onset::lattice::LatticeKind;
    /// assert_eq!(LatticeKind::Square.lattice::<2>(1.0)?.holohedry().len(), 8);
    /// assert_eq!(LatticeKind::Hexagonal.lattice::<2>(1.0)?.holohedry().len(), 12);
    /// assert_eq!(LatticeKind::FaceCenteredCubic.lattice::<3>(1.0)?.holohedry().len(), 48);
    /// # Ok::<(), onset::lattice::LatticeError>(())
    /// ```
    pub fn holohedry(&self) -> Vec<SMatrix<f64, D, D>> {
        let identity = SMatrix::identity();
        let short = Reduced::of(self.vectors()).map_or(*self.vectors(), |reduced| reduced.vectors);
        let Some(inverse) = inverse_of(&short) else {
            return vec![identity];
        };
        let images = bases_with(&short, &(short.transpose() * short));
        let mut maps: Vec<SMatrix<f64, D, D>> =
            images.into_iter().map(|image| image * inverse).collect();
        sort_by_value(&mut maps, |map| (map - identity).norm());
        maps
    }
}

impl<const D: usize> Crystal<D> {
    /// Orthogonal maps `Q` for which `Q` or `-Q` maps the particles onto themselves, up to a translation.
    pub(crate) fn maps(&self) -> Vec<SMatrix<f64, D, D>> {
        let cell = Cell::new(self, Vec::new());
        let is_kept = |image: &dyn Fn(&Fractional<D>) -> Fractional<D>| {
            let first = image(&self.sites()[0]);
            let mut sites = self.sites().iter();
            sites.any(|site| cell.is_kept_by(|place| image(place) + site - first))
        };
        let all = Symmetry::all(self.lattice()).into_iter();
        let kept = all.filter(|own| {
            is_kept(&|place| own.of_place(place)) || is_kept(&|place| -own.of_place(place))
        });
        kept.map(|own| own.map).collect()
    }
}

/// Wave vectors of a lattice that are equivalent by symmetry, used to choose the wave that is reported.
#[derive(Clone, Debug)]
pub(crate) struct Equivalence<const D: usize> {
    pub(crate) zone: BrillouinZone<D>,
    /// Halves of reciprocal vectors, in the zone; 1/length.
    pub(crate) halves: Vec<SVector<f64, D>>,
    /// Holohedry of the lattice, one of each pair of opposite maps.
    pub(crate) maps: Vec<SMatrix<f64, D, D>>,
    /// Images of the short primitive vectors under these maps, as unit vectors.
    pub(crate) directions: Vec<SVector<f64, D>>,
    /// Projections onto the lines along short lattice vectors, and onto the planes across short reciprocal vectors.
    projections: Vec<SMatrix<f64, D, D>>,
}

impl<const D: usize> Equivalence<D> {
    pub(crate) fn of(lattice: &BravaisLattice<D>) -> Self {
        let zone = BrillouinZone::new(*lattice);
        let mut maps: Vec<SMatrix<f64, D, D>> = Vec::new();
        for map in lattice.holohedry() {
            if maps
                .iter()
                .all(|other| (other + map).amax() > LENGTH_TOLERANCE)
            {
                maps.push(map);
            }
        }
        let own = lattice.vectors();
        let short = Reduced::canonical(own).map_or(*own, |reduced| reduced.vectors);
        let images = |a: SVector<f64, D>| maps.iter().map(move |map| (map * a).normalize());
        Self {
            halves: lattice.alternating().map(|k| zone.folded(&k)).collect(),
            directions: short
                .column_iter()
                .flat_map(|a| images(a.into_owned()))
                .collect(),
            projections: projections(&short, &zone),
            zone,
            maps,
        }
    }

    /// Shorter wave vectors with the same measure as a wave vector, if neighbors along one direction or in one plane alone determine the measure.
    ///
    /// The measure is then constant on lines or planes of wave vectors.
    pub(crate) fn shorter(
        &self,
        k: &SVector<f64, D>,
        is_equal: impl Fn(&SVector<f64, D>) -> bool,
    ) -> Vec<SVector<f64, D>> {
        let mut shorter = Vec::new();
        for projection in &self.projections {
            let way = projection * k - k;
            // The measure must be constant along the way.
            let is_short = way.norm() <= WAVE_VECTOR_ERROR * k.norm();
            if is_short
                || ![0.1, 0.37]
                    .iter()
                    .all(|share| is_equal(&(k + way * *share)))
            {
                continue;
            }
            let images = self.zone.bounding_vectors().iter().map(|g| k - g);
            let all = images.chain([*k]).map(|image| projection * image);
            shorter.extend(all.filter(|k| is_equal(k)));
        }
        shorter
    }
}

/// Projections onto the lines along the short vectors of a lattice, and in three dimensions onto the planes across short reciprocal vectors.
fn projections<const D: usize>(
    short: &SMatrix<f64, D, D>,
    zone: &BrillouinZone<D>,
) -> Vec<SMatrix<f64, D, D>> {
    let onto = |v: SVector<f64, D>| v * v.transpose() / v.norm_squared();
    let forward = |v: &SVector<f64, D>| v.iter().find(|x| **x != 0.0).is_some_and(|x| *x > 0.0);
    let lines = combinations::<D>().filter(forward).map(|n| onto(short * n));
    let planes = zone
        .bounding_vectors()
        .iter()
        .filter(|g| D == 3 && forward(g));
    let planes = planes.map(|g| SMatrix::identity() - onto(*g));
    lines.filter(|_| D > 1).chain(planes).collect()
}

/// Order of the wave vectors that can represent equal waves: shorter ones come first, then larger first components. Differences up to `rounding` are
/// ignored.
pub(crate) fn shorter_first<const D: usize>(
    a: &SVector<f64, D>,
    b: &SVector<f64, D>,
    rounding: f64,
) -> Ordering {
    let [length, other] = [a, b].each(|k| k.norm());
    if (length - other).abs() > rounding {
        return length.total_cmp(&other);
    }
    let mut apart = a.iter().zip(b).filter(|(a, b)| (*a - *b).abs() > rounding);
    apart
        .next()
        .map_or(Ordering::Equal, |(a, b)| b.total_cmp(a))
}

/// Bases of short vectors with the lengths and angles `metric_ij = a_i . a_j`, for a lattice given by its reduced vectors.
pub(super) fn bases_with<const D: usize>(
    reduced: &SMatrix<f64, D, D>,
    metric: &SMatrix<f64, D, D>,
) -> Vec<SMatrix<f64, D, D>> {
    let equal = |a: f64, b: f64| (a - b).abs() <= LENGTH_TOLERANCE * metric.amax();
    // Add one vector at a time.
    let mut bases: Vec<Vec<SVector<f64, D>>> = vec![Vec::new()];
    for column in 0..D {
        let candidates: Vec<SVector<f64, D>> = combinations()
            .map(|factors| reduced * factors)
            .filter(|vector| equal(vector.norm_squared(), metric[(column, column)]))
            .collect();
        bases = bases
            .iter()
            .flat_map(|known| {
                let fits = |vector: &&SVector<f64, D>| {
                    let mut before = known.iter().enumerate();
                    before.all(|(n, other)| equal(vector.dot(other), metric[(n, column)]))
                };
                let longer = |vector: &SVector<f64, D>| {
                    known.iter().chain([vector]).copied().collect::<Vec<_>>()
                };
                candidates
                    .iter()
                    .filter(fits)
                    .map(longer)
                    .collect::<Vec<_>>()
            })
            .collect();
    }
    let matrix = |basis: Vec<SVector<f64, D>>| SMatrix::from_fn(|i, j| basis[j][i]);
    bases.into_iter().map(matrix).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::{BrillouinZone, LatticeKind, WaveGrids};

    fn is_group<const D: usize>(lattice: &BravaisLattice<D>, order: usize) {
        let maps = lattice.holohedry();
        assert_eq!(maps.len(), order);
        let is_in = |m: &SMatrix<f64, D, D>| maps.iter().any(|other| (other - m).amax() < 1e-9);
        for a in &maps {
            assert!((a.transpose() * a - SMatrix::identity()).amax() < 1e-9);
            assert!(maps.iter().all(|b| is_in(&(a * b))), "not closed");
            // Lattice vectors are mapped to lattice vectors.
            let moved = lattice.reciprocal().transpose() * a * lattice.vectors();
            let coordinates = moved / std::f64::consts::TAU;
            assert!((coordinates - coordinates.map(f64::round)).amax() < 1e-9);
        }
    }

    #[test]
    fn the_holohedry_of_each_lattice_is_a_group_of_the_known_order() {
        is_group(&LatticeKind::Chain.lattice::<1>(1.0).unwrap(), 2);
        for (kind, order) in [
            (LatticeKind::Square, 8),
            (LatticeKind::Hexagonal, 12),
            (LatticeKind::Honeycomb, 12),
        ] {
            is_group(&kind.lattice::<2>(0.7).unwrap(), order);
        }
        let rectangles = LatticeKind::Rectangular.lattice_with::<2>(1.0, 1.3, &[]);
        is_group(&rectangles.unwrap(), 4);
        let oblique = LatticeKind::Oblique.lattice_with::<2>(1.0, 1.0, &[1.0, 0.0, 2.3, 1.1]);
        is_group(&oblique.unwrap(), 2);
        for (kind, order) in [
            (LatticeKind::SimpleCubic, 48),
            (LatticeKind::BodyCenteredCubic, 48),
            (LatticeKind::FaceCenteredCubic, 48),
            (LatticeKind::Diamond, 48),
            (LatticeKind::HexagonalClosePacked, 24),
        ] {
            is_group(&kind.lattice::<3>(1.0).unwrap(), order);
        }
        let skewed = [1.0, 0.0, 0.0, 0.2, 1.1, 0.0, 0.3, 0.4, 0.9];
        let triclinic = LatticeKind::Triclinic.lattice_with::<3>(1.0, 1.0, &skewed);
        is_group(&triclinic.unwrap(), 2);
    }

    /// Points of an orbit have the same number of steps along equivalent reciprocal vectors, and the group maps them to no other points.
    #[test]
    fn a_wedge_has_one_point_of_each_orbit() {
        let lattice = LatticeKind::FaceCenteredCubic.lattice::<3>(1.0).unwrap();
        let grid = WaveGrids::new(lattice).grid(12);
        let all = Symmetry::all(&lattice);
        let zone = BrillouinZone::new(lattice);
        // Symmetries of the cube, and of a cube that is stretched along its edges.
        let of_bricks = |symmetry: &Symmetry<3>| {
            symmetry.map.iter().all(|x| (x * x - x.abs()).abs() < 1e-9) && {
                let d = symmetry.map.diagonal();
                d.iter().all(|x| x.abs() > 0.5)
            }
        };
        let bricks: Vec<_> = all.iter().copied().filter(of_bricks).collect();
        assert_eq!([all.len(), bricks.len()], [48, 8]);
        for group in [all, bricks] {
            let wedge = Wedge::new(&group, 12);
            let mut of_orbits = std::collections::BTreeMap::new();
            for (index, first) in wedge.first.iter().enumerate() {
                let [own, other] = [index, *first as usize].map(|i| grid.wave_vector(i));
                let is_image = |symmetry: &Symmetry<3>| {
                    let apart = lattice.vectors().transpose() * (symmetry.map * own - other)
                        / std::f64::consts::TAU;
                    (apart - apart.map(f64::round)).amax() < 1e-9
                };
                assert!(group.iter().any(is_image), "{index} {first}");
                *of_orbits.entry(*first).or_insert(0) += 1;
                let (line, place) = (index / 12, index % 12);
                assert!(!wedge.is_first(index) || wedge.lines[line].contains(&place));
                // Images have equal distances from zero.
                let [own, other] = [own, other].map(|k| zone.folded(&k).norm());
                assert!((own - other).abs() < 1e-9);
            }
            assert!(
                of_orbits
                    .keys()
                    .all(|first| wedge.is_first(*first as usize))
            );
            let most = of_orbits.values().max().unwrap();
            assert!(of_orbits.len() * group.len() >= wedge.first.len() && *most <= group.len());
        }
    }

    #[test]
    fn a_basis_of_long_vectors_describes_the_same_symmetry() {
        let square = BravaisLattice::<2>::new(SMatrix::from_row_slice(&[1.0, 7.0, 0.0, 1.0]));
        is_group(&square.unwrap(), 8);
    }
}
