//! Reflections that map a planar lattice onto itself.

use super::BravaisLattice;
use crate::algebra::Each;
use nalgebra::SVector;
use std::f64::consts::PI;

/// Pair of orthogonal mirror lines of a planar lattice, with coordinates along them.
///
/// Every lattice vector is `R = (i P + j Q) / d` with primitive vectors `P` and `Q` along the lines and integers `i`, `j`. If the rectangle of `P`
/// and `Q` is centered (`d = 2`), both integers are even or both are odd. A reflection changes the sign of one of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Mirror {
    /// Coordinates `i` and `j` of the primitive vectors: `[axis][vector]`.
    coordinates: [[i32; 2]; 2],
    /// Divisor `d` of the coordinates.
    divisor: i32,
}

/// Largest multiple of a phase along a mirror line whose cosines and sines are tabulated.
pub(crate) const HARMONICS: usize = 48;
/// Lines are padded to a multiple of this number of columns, a full vector register.
pub(crate) const FILL: usize = 8;
/// Columns of a line that form one group.
pub(crate) type Group = [f64; FILL];

impl Mirror {
    /// Largest lattice coordinate in the search for primitive vectors along mirror lines; for reduced bases they are smaller.
    pub(crate) const LARGEST_LINE_COORDINATE: i32 = 2;

    /// Mirrors of a lattice; empty unless it is planar.
    pub(super) fn all<const D: usize>(lattice: &BravaisLattice<D>) -> Vec<Self> {
        if D != 2 {
            return Vec::new();
        }
        let place =
            |cell: [i32; 2]| lattice.vectors() * SVector::from_fn(|i, _| f64::from(cell[i]));
        let range = || -Self::LARGEST_LINE_COORDINATE..=Self::LARGEST_LINE_COORDINATE;
        let cells = || {
            range()
                .flat_map(|m| range().map(move |n| [m, n]))
                .filter(is_primitive)
        };
        let mut mirrors = Vec::new();
        for p in cells().filter(|p| *p > [0, 0]) {
            for q in cells() {
                let determinant = p[0] * q[1] - p[1] * q[0];
                let (along, across) = (place(p), place(q));
                let is_right = along.dot(&across).abs() <= 1e-12 * along.norm() * across.norm();
                if is_right && matches!(determinant, 1 | 2) {
                    // d times the inverse of the matrix with the columns p and q.
                    let coordinates = [[q[1], -q[0]], [-p[1], p[0]]];
                    mirrors.push(Self {
                        coordinates,
                        divisor: determinant,
                    });
                }
            }
        }
        // Remove pairs that differ only in the order of their lines.
        let mut distinct: Vec<Self> = Vec::new();
        for mirror in mirrors {
            if !distinct.iter().any(|known| known.has_lines_of(&mirror)) {
                distinct.push(mirror);
            }
        }
        distinct
    }

    fn has_lines_of(&self, other: &Self) -> bool {
        let [a, b] = other.coordinates;
        let opposite = |row: [i32; 2]| row.each(|x| -x);
        [[a, b], [b, a]].iter().any(|[a, b]| {
            let [c, d] = self.coordinates;
            (c == *a || c == opposite(*a)) && (d == *b || d == opposite(*b))
        })
    }

    /// Coordinates `i` and `j` of a lattice vector.
    pub(crate) fn coordinates_of(&self, cell: [i32; 2]) -> [i32; 2] {
        self.coordinates
            .each(|row| row[0] * cell[0] + row[1] * cell[1])
    }

    /// Returns true if `i + j` is even for all lattice vectors.
    pub(crate) fn is_centered(&self) -> bool {
        self.divisor == 2
    }

    /// Coordinates `i` and `j` of a primitive vector, at most [`Mirror::LARGEST_LINE_COORDINATE`].
    pub(crate) fn multiples(&self, vector: usize) -> [i32; 2] {
        self.coordinates.each(|row| row[vector])
    }

    /// Phases `k.a_1`, `k.a_2` of the primitive vectors for given phases `u = k.P / d`, `v = k.Q / d`.
    pub(crate) fn phases(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let [i, j] = self.coordinates.each(|row| row.map(f64::from));
        [0, 1].each(|n| i[n] * u + j[n] * v)
    }

    /// Phases `u`, `v` for given phases of the primitive vectors.
    pub(crate) fn along(&self, [t1, t2]: [f64; 2]) -> [f64; 2] {
        let [i, j] = self.coordinates.each(|row| row.map(f64::from));
        let determinant = i[0] * j[1] - i[1] * j[0];
        [
            (j[1] * t1 - j[0] * t2) / determinant,
            (i[0] * t2 - i[1] * t1) / determinant,
        ]
    }
}

/// Part of a grid over the zone that remains after mirror symmetry, with its state-independent data.
#[derive(Debug)]
pub(crate) struct MirrorWaves {
    pub(crate) mirror: Mirror,
    /// Numbers of steps along `u` and `v` and their length.
    pub(crate) intervals: [usize; 2],
    pub(crate) steps: [f64; 2],
    /// Columns of a line. The first column and the columns beyond the intervals overlap with symmetric images.
    pub(crate) width: usize,
    /// Tables of `cos i u`, `sin i u` at `[i][group of columns]`, `cos j v`, `sin j v` at `[j][line]`.
    pub(crate) along: [Vec<Group>; 2],
    pub(crate) across: [Vec<f64>; 2],
    /// Values `1 / |k|_h^2` at `[line][group of columns]`, at `(u, v)` and at `(u, -v)`.
    pub(crate) inverse_laplacian: [Vec<Group>; 2],
}

impl MirrorWaves {
    /// Creates the grid with at least the given steps along the lines of a mirror.
    pub(super) fn new<const D: usize>(
        lattice: &BravaisLattice<D>,
        mirror: Mirror,
        intervals: [usize; 2],
    ) -> Self {
        // For a centered rectangle (u, v) and (pi - u, pi - v) are equivalent.
        let end = if mirror.is_centered() { 0.5 * PI } else { PI };
        let steps = [end / intervals[0] as f64, PI / intervals[1] as f64];
        let width = (intervals[0] + 3).next_multiple_of(FILL);
        let lines = intervals[1] + 3;
        let phases = |count: usize, step: f64| -> Vec<f64> {
            (0..count).map(|n| (n as f64 - 1.0) * step).collect()
        };
        let (u, v) = (phases(width, steps[0]), phases(lines, steps[1]));
        let table = |phases: &[f64], of: fn(f64) -> f64| -> Vec<f64> {
            (0..=HARMONICS)
                .flat_map(|n| phases.iter().map(move |t| of(n as f64 * t)))
                .collect()
        };
        let weights = [0, 1].each(|n| 4.0 / lattice.vectors().column(n).norm_squared());
        let inverse_laplacian = [1.0, -1.0].map(|sign| {
            let inverse = |u: f64, v: f64| {
                let t = mirror.phases([u, sign * v]);
                1.0 / (0..2)
                    .map(|n| weights[n] * (0.5 * t[n]).sin().powi(2))
                    .sum::<f64>()
            };
            let lines = v.iter();
            let all: Vec<f64> = lines
                .flat_map(|v| u.iter().map(|u| inverse(*u, *v)).collect::<Vec<_>>())
                .collect();
            all.as_chunks().0.to_vec()
        });
        Self {
            mirror,
            intervals,
            steps,
            width,
            along: [f64::cos, f64::sin].map(|of| table(&u, of).as_chunks().0.to_vec()),
            across: [table(&v, f64::cos), table(&v, f64::sin)],
            inverse_laplacian,
        }
    }

    /// Number of groups of columns of a line.
    pub(crate) fn groups(&self) -> usize {
        self.width / FILL
    }

    /// Number of lines. The first and last lines overlap with symmetric images.
    pub(crate) fn lines(&self) -> usize {
        self.intervals[1] + 3
    }
}

fn is_primitive([m, n]: &[i32; 2]) -> bool {
    let (mut a, mut b) = (m.abs(), n.abs());
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a == 1
}

#[cfg(test)]
mod tests {
    use super::Mirror;
    use crate::lattice::{BravaisLattice, LatticeKind};
    use nalgebra::Matrix2;

    #[test]
    fn hexagons_have_three_pairs_of_mirrors_and_squares_two() {
        let count =
            |kind: LatticeKind| Mirror::all(&kind.lattice::<2>(0.7).expect("a lattice")).len();
        assert_eq!(count(LatticeKind::Hexagonal), 3);
        assert_eq!(count(LatticeKind::Square), 2);
        let oblique = BravaisLattice::new(Matrix2::new(1.0, 0.3, 0.0, 1.1)).expect("a lattice");
        assert!(Mirror::all(&oblique).is_empty());
        let rhombic = BravaisLattice::new(Matrix2::new(1.0, 1.0, 0.3, -0.3)).expect("a lattice");
        assert_eq!(Mirror::all(&rhombic).len(), 1);
    }

    #[test]
    fn phases_along_mirror_lines_and_along_primitive_vectors_are_the_same_wave() {
        for mirror in Mirror::all(&LatticeKind::Hexagonal.lattice::<2>(1.0).expect("a lattice")) {
            let (u, v) = (0.3, -1.1);
            let t = mirror.phases([u, v]);
            for cell in [[1, 0], [-2, 3], [4, 1]] {
                let [i, j] = mirror.coordinates_of(cell).map(f64::from);
                let phase = t[0] * f64::from(cell[0]) + t[1] * f64::from(cell[1]);
                assert!((i * u + j * v - phase).abs() < 1e-14);
            }
            let back = mirror.along(t);
            assert!((back[0] - u).abs() + (back[1] - v).abs() < 1e-14);
        }
    }
}
