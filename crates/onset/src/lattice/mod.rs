//! Particle lattices: their kinds, Voronoi volumes, and the first Brillouin zone.
//!
//! A lattice is geometry only, without stress.

mod cell;
mod crystal;
mod delaunay;
mod kind;
mod mirror;
mod numbering;
mod primitive;
mod reduction;
mod shape;
mod symmetry;
mod voronoi;
mod wave_vectors;
mod zone;

pub(crate) use crystal::cells_between;
pub use crystal::{Crystal, Particle};
use crystal::{per_particle, shortest};
pub use delaunay::delaunay_centers;
pub use kind::LatticeKind;
pub(crate) use mirror::{FILL, Group, HARMONICS, Mirror, MirrorWaves};
pub(crate) use numbering::{coordinates as grid_coordinates, opposite};
pub(crate) use primitive::Cell;
pub(crate) use reduction::{Ball, Reduced, inverse_of};
pub(crate) use symmetry::{Equivalence, Symmetry, WAVE_VECTOR_ERROR, Wedge, shorter_first};
pub use voronoi::voronoi_volumes;
pub use wave_vectors::{WaveGrid, WaveGrids};
pub use zone::BrillouinZone;

use crate::algebra::array_of;
use crate::real::plain;
use nalgebra::{SMatrix, SVector};
use thiserror::Error;

/// Point given by its lattice coordinates: `x = sum_i fractional_i a_i`.
pub type Fractional<const D: usize> = SVector<f64, D>;

/// Error of a lattice that is not admissible.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum LatticeError {
    /// The spacing is not a positive finite length.
    #[error(
        "the particle spacing is {value:?}; it must be positive, and its square must neither over- nor underflow"
    )]
    Spacing {
        /// Value of the spacing.
        value: f64,
    },
    /// The lattice does not exist in this dimension.
    #[error("the {lattice} lattice has {actual} dimension(s), not {requested}")]
    Dimension {
        /// Name of the lattice.
        lattice: &'static str,
        /// Dimension of the lattice.
        actual: usize,
        /// Dimension that was requested.
        requested: usize,
    },
    /// The aspect ratio of a rectangle is not a positive finite number.
    #[error("the aspect ratio of the rectangles is {}; it must be a positive finite number", plain(*value))]
    Aspect {
        /// Value of the aspect ratio.
        value: f64,
    },
    /// The primitive vectors have a wrong number of components.
    #[error(
        "the {lattice} lattice needs {expected} numbers for its primitive vectors, one vector after the other \
         in units of the spacing; {given} are given"
    )]
    Vectors {
        /// Name of the lattice.
        lattice: &'static str,
        /// Number of components needed.
        expected: usize,
        /// Number of components given.
        given: usize,
    },
    /// The primitive vectors do not span space.
    #[error(
        "the primitive vectors {vectors:?} do not span space, or only beyond the range of double precision"
    )]
    Dependent {
        /// Components of the primitive vectors, one vector after the other.
        vectors: Vec<f64>,
    },
    /// The primitive vectors, possibly after a deformation, are so oblique that double precision does not resolve the lattice.
    #[error(
        "the primitive vectors of the lattice are too oblique: its shortest vectors are combinations of them with \
         coefficients of {coefficient:.1e}; at most {limit:.0e} are admitted"
    )]
    Sheared {
        /// Largest coefficient in the combinations.
        coefficient: f64,
        /// Largest admissible coefficient in magnitude.
        limit: f64,
    },
    /// The cells are too elongated for all methods.
    #[error(
        "the cells of the lattice have the aspect ratio {ratio:.1e}; at most {limit} is supported"
    )]
    Elongated {
        /// Ratio of length to width.
        ratio: f64,
        /// Largest admissible ratio of length to width.
        limit: f64,
    },
    /// Voronoi cells are computed in one to three dimensions.
    #[error(
        "Voronoi cells of a periodic point set are available in 1 to 3 dimensions, not in {dimension}"
    )]
    VoronoiDimension {
        /// Dimension that was requested.
        dimension: usize,
    },
    /// A cell has no particles.
    #[error("the cell holds no particle; at least one is needed")]
    NoSites,
    /// Two points of the set coincide, so their Voronoi cells are undefined.
    #[error("points {first} and {second} of the cell coincide; expected distinct points")]
    CoincidentPoints {
        /// Index of the first point.
        first: usize,
        /// Index of the second point.
        second: usize,
    },
}

/// Bravais lattice `x = sum_i n_i a_i` with integers `n_i`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BravaisLattice<const D: usize> {
    /// Primitive vectors `a_i` as columns.
    vectors: SMatrix<f64, D, D>,
    /// Reciprocal vectors `b_i` as columns, `a_i . b_j = 2 pi delta_ij`.
    reciprocal: SMatrix<f64, D, D>,
    /// Vectors and weights of the lattice Laplacian.
    measure: Measure<D>,
}

/// Vectors `m_i`, as columns, and weights `w_i` of a lattice Laplacian `sum_i w_i 2 (1 - cos k.m_i)`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Measure<const D: usize> {
    vectors: SMatrix<f64, D, D>,
    weights: [f64; D],
}

impl<const D: usize> Measure<D> {
    /// Uses the short primitive vectors as `m_i`, with `w_i = 1 / |m_i|^2`.
    fn of(vectors: &SMatrix<f64, D, D>) -> Self {
        let short = Reduced::canonical(vectors).map_or(*vectors, |reduced| reduced.vectors);
        Self {
            vectors: short,
            weights: array_of(|i| short.column(i).norm_squared().recip()),
        }
    }
}

impl<const D: usize> BravaisLattice<D> {
    /// Creates the lattice with primitive vectors as columns; `None` if they are linearly dependent.
    pub fn new(vectors: SMatrix<f64, D, D>) -> Option<Self> {
        let reciprocal = inverse_of(&vectors.transpose())? * std::f64::consts::TAU;
        reciprocal
            .iter()
            .all(|value| value.is_finite())
            .then_some(Self {
                vectors,
                reciprocal,
                measure: Measure::of(&vectors),
            })
    }

    /// Primitive vectors `a_i` as columns; length.
    pub fn vectors(&self) -> &SMatrix<f64, D, D> {
        &self.vectors
    }

    /// Reciprocal vectors `b_i` as columns, `a_i . b_j = 2 pi delta_ij`; 1/length.
    pub fn reciprocal(&self) -> &SMatrix<f64, D, D> {
        &self.reciprocal
    }

    /// Coordinates `a_i . k / 2 pi` of a wave vector in units of the reciprocal vectors.
    pub(crate) fn fractional(&self, k: &SVector<f64, D>) -> SVector<f64, D> {
        self.vectors.transpose() * k / std::f64::consts::TAU
    }

    /// Volume `V0` of the primitive cell; length^D.
    pub fn cell_volume(&self) -> f64 {
        determinant(&self.vectors).abs()
    }

    /// Lattice vector to a cell.
    #[inline]
    pub(crate) fn vector_to(&self, cell: &[i32; D]) -> SVector<f64, D> {
        let mut vector = SVector::zeros();
        for n in 0..D {
            let coordinate = f64::from(cell[n]);
            for i in 0..D {
                vector[i] += self.vectors[(i, n)] * coordinate;
            }
        }
        vector
    }

    /// Lattice with every vector mapped by `m`, as by a homogeneous deformation; `None` if the result is degenerate.
    pub fn mapped(&self, m: &SMatrix<f64, D, D>) -> Option<Self> {
        Self::new(m * self.vectors)
    }

    /// Lattice Laplacian `|k|_h^2 = sum_i 2 (1 - cos k.a_i) / |a_i|^2`, the finite-difference analog of `|k|^2`. 1/length^2.
    ///
    /// It is finite over the zone and quadratic for long waves. The `a_i` are the shortest primitive vectors, so it depends only on the lattice, not
    /// on the choice of its basis. Among equally short vectors, those are used whose inclination to the diagonal `(1, 1, 1)` is closest to the
    /// inclination of the axes.
    ///
    /// ```
    /// use nalgebra::{Matrix2, Vector2};
    /// use onset::lattice::BravaisLattice;
    /// let square = BravaisLattice::<2>::new(Matrix2::new(1.0, 0.0, 0.0, 1.0)).ok_or("dependent")?;
    /// let same = BravaisLattice::<2>::new(Matrix2::new(1.0, 300.0, 0.0, 1.0)).ok_or("dependent")?;
    /// let k = Vector2::new(0.3, 1.1);
    /// assert!((square.laplacian(&k) - same.laplacian(&k)).abs() < 1e-12);
    /// # Ok::<(), &str>(())
    /// ```
    pub fn laplacian(&self, k: &SVector<f64, D>) -> f64 {
        self.measured(|a, weight| {
            let sine = (0.5 * k.dot(&a)).sin();
            4.0 * sine * sine * weight
        })
    }

    /// Gradient of [`BravaisLattice::laplacian`] with respect to `k`.
    pub fn laplacian_gradient(&self, k: &SVector<f64, D>) -> SVector<f64, D> {
        self.measured(|a, weight| a * (2.0 * k.dot(&a).sin() * weight))
    }

    /// Second derivatives of [`BravaisLattice::laplacian`].
    pub fn laplacian_hessian(&self, k: &SVector<f64, D>) -> SMatrix<f64, D, D> {
        self.measured(|a, weight| a * a.transpose() * (2.0 * k.dot(&a).cos() * weight))
    }

    /// Metric `G = sum_i a_i (x) a_i / |a_i|^2` with `|k|_h^2 -> k . G k` for long waves.
    pub fn long_wave_metric(&self) -> SMatrix<f64, D, D> {
        self.measured(|a, weight| a * a.transpose() * weight)
    }

    /// Products of the vectors of the lattice Laplacian with given wave vectors (columns), with their weights:
    /// `|k|_h^2 = sum_i 4 w_i sin^2(k.a_i / 2)`.
    pub(crate) fn measured_along(&self, waves: &SMatrix<f64, D, D>) -> Vec<([f64; D], f64)> {
        let Measure { vectors, weights } = &self.measure;
        let along = |i: usize| array_of(|n| waves.column(n).dot(&vectors.column(i)));
        (0..D).map(|i| (along(i), weights[i])).collect()
    }

    /// Sums a term over the vectors and weights of the lattice Laplacian.
    fn measured<T: std::iter::Sum>(&self, term: impl Fn(SVector<f64, D>, f64) -> T) -> T {
        let Measure { vectors, weights } = &self.measure;
        (0..D)
            .map(|i| term(vectors.column(i).into_owned(), weights[i]))
            .sum()
    }

    /// Matrix `M` with `M^T G M = 1` for the long-wave metric `G`, also accurate for nearly singular `G`: `B^-T` of `G = B B^T`.
    fn inverse_root_of_metric(&self) -> Option<SMatrix<f64, D, D>> {
        let Measure { vectors, weights } = &self.measure;
        let root = SMatrix::<f64, D, D>::from_fn(|i, j| vectors[(i, j)] * weights[j].sqrt());
        inverse_of(&root).map(|inverse| inverse.transpose())
    }

    /// Returns true if the lattice Laplacian uses the given primitive vectors.
    pub(crate) fn is_measured_by_own_vectors(&self) -> bool {
        self.measure.vectors == self.vectors
    }

    /// Lattice in other coordinates `x' = map x` and another basis with integer coordinates `change`. With `k' = map^-T k` the lattice Laplacian
    /// keeps its values.
    pub(crate) fn in_coordinates(
        &self,
        map: &SMatrix<f64, D, D>,
        change: &SMatrix<f64, D, D>,
    ) -> Option<Self> {
        let moved = Self::new(map * self.vectors * change)?;
        Some(Self {
            measure: Measure {
                vectors: map * self.measure.vectors,
                weights: self.measure.weights,
            },
            ..moved
        })
    }
}

/// Determinant of a square matrix of dimension up to three.
pub(crate) fn determinant<const D: usize>(m: &SMatrix<f64, D, D>) -> f64 {
    match D {
        1 => m[(0, 0)],
        2 => m[(0, 0)] * m[(1, 1)] - m[(0, 1)] * m[(1, 0)],
        _ => nalgebra::DMatrix::from_fn(D, D, |i, j| m[(i, j)]).determinant(),
    }
}
