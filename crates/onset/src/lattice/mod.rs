//! Particles on a lattice: its kinds, Voronoi volumes, the first Brillouin zone.
//!
//! A lattice knows nothing of stress.

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
pub(crate) use symmetry::{Symmetry, Wedge};
pub use voronoi::voronoi_volumes;
pub use wave_vectors::{WaveGrid, WaveGrids};
pub use zone::BrillouinZone;

use crate::algebra::array_of;
use nalgebra::{SMatrix, SVector};
use thiserror::Error;

/// A point by its lattice coordinates: `x = sum_i fractional_i a_i`.
pub type Fractional<const D: usize> = SVector<f64, D>;

/// What can be wrong with a lattice.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum LatticeError {
    /// The spacing is not a positive finite length.
    #[error(
        "the particle spacing is {value:?}; it must be positive, and its square neither over- nor underflow"
    )]
    Spacing {
        /// Its value.
        value: f64,
    },
    /// The lattice does not exist in this dimension.
    #[error("the {lattice} lattice has {actual} dimension(s), not {requested}")]
    Dimension {
        /// Its name.
        lattice: &'static str,
        /// Its dimension.
        actual: usize,
        /// The dimension asked for.
        requested: usize,
    },
    /// The ratio of the sides of a rectangle is not a positive finite number.
    #[error("the aspect ratio of the rectangles is {value:?}; it must be a positive finite number")]
    Aspect {
        /// Its value.
        value: f64,
    },
    /// The primitive vectors are not as many numbers as the lattice needs.
    #[error(
        "the {lattice} lattice needs {expected} numbers for its primitive vectors, one vector after the other \
         in units of the spacing; {given} are given"
    )]
    Vectors {
        /// The lattice's name.
        lattice: &'static str,
        /// How many are needed.
        expected: usize,
        /// How many there are.
        given: usize,
    },
    /// The primitive vectors do not span space.
    #[error(
        "the primitive vectors {vectors:?} do not span space, or not within the range of numbers"
    )]
    Dependent {
        /// Their components, one vector after the other.
        vectors: Vec<f64>,
    },
    /// The primitive vectors, or those that a deformation makes of them, are so oblique that double precision does not tell
    /// the lattice.
    #[error(
        "the primitive vectors of the lattice are too oblique: its shortest vectors are combinations of them with \
         coefficients of {coefficient:.1e}; at most {limit:.0e} are admitted"
    )]
    Sheared {
        /// The largest coefficient.
        coefficient: f64,
        /// What is admitted.
        limit: f64,
    },
    /// The cells are so long that no method treats them.
    #[error(
        "the cells of the lattice are {ratio:.1e} times as long as they are wide; at most {limit} times are admitted"
    )]
    Elongated {
        /// Length over width.
        ratio: f64,
        /// What is admitted.
        limit: f64,
    },
    /// Voronoi cells are computed in one to three dimensions.
    #[error(
        "Voronoi cells of a periodic point set are available in 1 to 3 dimensions, not in {dimension}"
    )]
    VoronoiDimension {
        /// The dimension asked for.
        dimension: usize,
    },
    /// A cell without particles.
    #[error("the cell holds no particle; at least one is needed")]
    NoSites,
    /// Two points of the set coincide, so that their Voronoi cells are not defined.
    #[error(
        "points {first} and {second} of the cell coincide; expected points apart from each other"
    )]
    CoincidentPoints {
        /// One of them.
        first: usize,
        /// The other.
        second: usize,
    },
}

/// A Bravais lattice `x = sum_i n_i a_i`, `n_i` integer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BravaisLattice<const D: usize> {
    /// Primitive vectors `a_i` as columns.
    vectors: SMatrix<f64, D, D>,
    /// Reciprocal vectors `b_i` as columns, `a_i . b_j = 2 pi delta_ij`.
    reciprocal: SMatrix<f64, D, D>,
    /// What the lattice Laplacian is made of.
    measure: Measure<D>,
}

/// Vectors `m_i`, as columns, and weights `w_i` of a lattice Laplacian `sum_i w_i 2 (1 - cos k.m_i)`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Measure<const D: usize> {
    vectors: SMatrix<f64, D, D>,
    weights: [f64; D],
}

impl<const D: usize> Measure<D> {
    /// `m_i` the short primitive vectors, `w_i = 1 / |m_i|^2`.
    fn of(vectors: &SMatrix<f64, D, D>) -> Self {
        let short = Reduced::canonical(vectors).map_or(*vectors, |reduced| reduced.vectors);
        Self {
            vectors: short,
            weights: array_of(|i| short.column(i).norm_squared().recip()),
        }
    }
}

impl<const D: usize> BravaisLattice<D> {
    /// The lattice with primitive vectors as columns; `None` when they are linearly dependent.
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

    /// A wave vector in units of the reciprocal vectors, `a_i . k / 2 pi`.
    pub(crate) fn fractional(&self, k: &SVector<f64, D>) -> SVector<f64, D> {
        self.vectors.transpose() * k / std::f64::consts::TAU
    }

    /// The volume of the primitive cell, `V0`; length^D.
    pub fn cell_volume(&self) -> f64 {
        determinant(&self.vectors).abs()
    }

    /// The vector to a cell.
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

    /// The lattice with every vector mapped by `m`, as a homogeneous deformation does.
    pub fn mapped(&self, m: &SMatrix<f64, D, D>) -> Option<Self> {
        Self::new(m * self.vectors)
    }

    /// The lattice Laplacian `|k|_h^2 = sum_i 2 (1 - cos k.a_i) / |a_i|^2`, which is `|k|^2` of a
    /// finite-difference grid: finite over the zone, quadratic for long waves. 1/length^2.
    ///
    /// `a_i` are the shortest primitive vectors, so that it depends on the lattice, not on the basis that describes it. Where
    /// several are equally short, those are taken that are inclined to the diagonal `(1, 1, 1)` most as the axes are.
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

    /// The gradient of [`BravaisLattice::laplacian`] with respect to `k`.
    pub fn laplacian_gradient(&self, k: &SVector<f64, D>) -> SVector<f64, D> {
        self.measured(|a, weight| a * (2.0 * k.dot(&a).sin() * weight))
    }

    /// The second derivatives of [`BravaisLattice::laplacian`].
    pub fn laplacian_hessian(&self, k: &SVector<f64, D>) -> SMatrix<f64, D, D> {
        self.measured(|a, weight| a * a.transpose() * (2.0 * k.dot(&a).cos() * weight))
    }

    /// The metric `G` with `|k|_h^2 -> k . G k` for long waves, `G = sum_i a_i (x) a_i / |a_i|^2`.
    pub fn long_wave_metric(&self) -> SMatrix<f64, D, D> {
        self.measured(|a, weight| a * a.transpose() * weight)
    }

    /// The vectors of the lattice Laplacian by their products with given wave vectors (columns), with their weights: `|k|_h^2 =
    /// sum_i 4 w_i sin^2(k.a_i / 2)`.
    pub(crate) fn measured_along(&self, waves: &SMatrix<f64, D, D>) -> Vec<([f64; D], f64)> {
        let Measure { vectors, weights } = &self.measure;
        let along = |i: usize| array_of(|n| waves.column(n).dot(&vectors.column(i)));
        (0..D).map(|i| (along(i), weights[i])).collect()
    }

    /// A sum over the vectors and weights of the lattice Laplacian.
    fn measured<T: std::iter::Sum>(&self, term: impl Fn(SVector<f64, D>, f64) -> T) -> T {
        let Measure { vectors, weights } = &self.measure;
        (0..D)
            .map(|i| term(vectors.column(i).into_owned(), weights[i]))
            .sum()
    }

    /// A matrix `M` with `M^T G M = 1` for the long-wave metric `G`, accurate also where `G` is nearly singular: `B^-T` of `G =
    /// B B^T`.
    fn inverse_root_of_metric(&self) -> Option<SMatrix<f64, D, D>> {
        let Measure { vectors, weights } = &self.measure;
        let root = SMatrix::<f64, D, D>::from_fn(|i, j| vectors[(i, j)] * weights[j].sqrt());
        inverse_of(&root).map(|inverse| inverse.transpose())
    }

    /// Whether the lattice Laplacian is made of the primitive vectors themselves.
    pub(crate) fn is_measured_by_own_vectors(&self) -> bool {
        self.measure.vectors == self.vectors
    }

    /// The same particles in other coordinates `x' = map x`, in another basis of integer coordinates `change`: with `k' =
    /// map^-T k` the lattice Laplacian keeps its values.
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

/// The determinant of a square matrix of any dimension up to three.
pub(crate) fn determinant<const D: usize>(m: &SMatrix<f64, D, D>) -> f64 {
    match D {
        1 => m[(0, 0)],
        2 => m[(0, 0)] * m[(1, 1)] - m[(0, 1)] * m[(1, 0)],
        _ => nalgebra::DMatrix::from_fn(D, D, |i, j| m[(i, j)]).determinant(),
    }
}
