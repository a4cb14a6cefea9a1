//! Particles on a Bravais lattice: arrangements, Voronoi volumes, the first Brillouin zone.
//!
//! A lattice knows nothing of stress.

mod crystal;
mod mirror;
mod voronoi;
mod wave_vectors;
mod zone;

pub(crate) use crystal::cells_between;
pub use crystal::{Crystal, Particle};
pub(crate) use mirror::{FILL, HARMONICS, Mirror, MirrorWaves};
pub use voronoi::voronoi_volumes;
pub(crate) use wave_vectors::coordinates as grid_coordinates;
pub(crate) use wave_vectors::opposite;
pub use wave_vectors::{WaveGrid, WaveGrids};
pub use zone::BrillouinZone;

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
    /// The arrangement does not exist in this dimension.
    #[error("the {arrangement} arrangement has {actual} dimension(s), not {requested}")]
    Dimension {
        /// Its name.
        arrangement: &'static str,
        /// Its dimension.
        actual: usize,
        /// The dimension asked for.
        requested: usize,
    },
    /// Voronoi volumes are computed in one and two dimensions.
    #[error(
        "Voronoi volumes of a periodic point set are available in 1 and 2 dimensions, not in {dimension}"
    )]
    VoronoiDimension {
        /// The dimension asked for.
        dimension: usize,
    },
    /// A cell without particles.
    #[error("the cell holds no particle; at least one is needed")]
    NoSites,
    /// Two points of the set coincide, so that their Voronoi cells are not defined.
    #[error("points {first} and {second} of the cell coincide")]
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
}

impl<const D: usize> BravaisLattice<D> {
    /// The lattice with primitive vectors as columns; `None` when they are linearly dependent.
    pub fn new(vectors: SMatrix<f64, D, D>) -> Option<Self> {
        // Solved through the generic LU: `try_inverse` needs a fixed dimension.
        let dynamic = nalgebra::DMatrix::from_fn(D, D, |i, j| vectors[(j, i)]);
        let inverse = dynamic.try_inverse()?;
        let reciprocal: SMatrix<f64, D, D> =
            SMatrix::from_fn(|i, j| std::f64::consts::TAU * inverse[(i, j)]);
        reciprocal
            .iter()
            .all(|value| value.is_finite())
            .then_some(Self {
                vectors,
                reciprocal,
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

    /// The volume of the primitive cell, `V0`; length^D.
    pub fn cell_volume(&self) -> f64 {
        determinant(&self.vectors).abs()
    }

    /// The lattice with every vector mapped by `m`, as a homogeneous deformation does.
    pub fn mapped(&self, m: &SMatrix<f64, D, D>) -> Option<Self> {
        Self::new(m * self.vectors)
    }

    /// The lattice Laplacian `|k|_h^2 = sum_i 2 (1 - cos k.a_i) / |a_i|^2`, which is `|k|^2` of a
    /// finite-difference grid: finite over the zone, quadratic for long waves. 1/length^2.
    pub fn laplacian(&self, k: &SVector<f64, D>) -> f64 {
        let term = |a: SVector<f64, D>| {
            let sine = (0.5 * k.dot(&a)).sin();
            4.0 * sine * sine / a.norm_squared()
        };
        (0..D)
            .map(|i| term(self.vectors.column(i).into_owned()))
            .sum()
    }

    /// The gradient of [`BravaisLattice::laplacian`] with respect to `k`.
    pub fn laplacian_gradient(&self, k: &SVector<f64, D>) -> SVector<f64, D> {
        let term = |a: SVector<f64, D>| a * (2.0 * k.dot(&a).sin() / a.norm_squared());
        (0..D)
            .map(|i| term(self.vectors.column(i).into_owned()))
            .sum()
    }

    /// The second derivatives of [`BravaisLattice::laplacian`].
    pub fn laplacian_hessian(&self, k: &SVector<f64, D>) -> SMatrix<f64, D, D> {
        let term =
            |a: SVector<f64, D>| a * a.transpose() * (2.0 * k.dot(&a).cos() / a.norm_squared());
        (0..D)
            .map(|i| term(self.vectors.column(i).into_owned()))
            .sum()
    }

    /// The metric `G` with `|k|_h^2 -> k . G k` for long waves, `G = sum_i a_i (x) a_i / |a_i|^2`.
    pub fn long_wave_metric(&self) -> SMatrix<f64, D, D> {
        let term = |a: SVector<f64, D>| a * a.transpose() / a.norm_squared();
        (0..D)
            .map(|i| term(self.vectors.column(i).into_owned()))
            .sum()
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

/// How the particles are arranged: one at each point of a Bravais lattice. The centers of the
/// Delaunay cells are the basis on which stress points may sit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Arrangement {
    /// One dimension: particles at equal distances.
    Chain,
    /// Two dimensions: squares with sides along the axes.
    Square,
    /// Two dimensions: equilateral triangles with rows along the first axis.
    Hexagonal,
}

impl Arrangement {
    /// The number of space dimensions.
    pub fn dimension(self) -> usize {
        match self {
            Self::Chain => 1,
            Self::Square | Self::Hexagonal => 2,
        }
    }

    /// The name used in study files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Chain => "chain",
            Self::Square => "square",
            Self::Hexagonal => "hexagonal",
        }
    }

    /// The lattice with the given distance between nearest particles.
    ///
    /// # Errors
    /// [`LatticeError`] when the spacing is not positive and finite or `D` is not the arrangement's.
    pub fn lattice<const D: usize>(self, spacing: f64) -> Result<BravaisLattice<D>, LatticeError> {
        if self.dimension() != D {
            return Err(LatticeError::Dimension {
                arrangement: self.name(),
                actual: self.dimension(),
                requested: D,
            });
        }
        let vectors = SMatrix::from_fn(|i, j| match (self, i, j) {
            (Self::Hexagonal, 0, 1) => 0.5 * spacing,
            (Self::Hexagonal, 1, 1) => 0.5 * 3.0_f64.sqrt() * spacing,
            _ if i == j => spacing,
            _ => 0.0,
        });
        // A spacing whose powers leave the range of numbers is as useless as a negative one.
        (spacing > 0.0 && spacing.is_finite())
            .then(|| BravaisLattice::new(vectors))
            .flatten()
            .filter(|lattice| lattice.cell_volume().is_normal())
            .ok_or(LatticeError::Spacing { value: spacing })
    }

    /// The centers of the Delaunay cells, in lattice coordinates: midpoints, square centers,
    /// centroids of the triangles.
    pub fn cell_centers<const D: usize>(self) -> Vec<Fractional<D>> {
        let along: &[f64] = match self {
            Self::Chain | Self::Square => &[0.5],
            Self::Hexagonal => &[1.0 / 3.0, 2.0 / 3.0],
        };
        along.iter().map(|&t| SVector::repeat(t)).collect()
    }

    /// Named points of the zone's boundary and the path through them that is usual for
    /// dispersion diagrams, as wave vectors in units of the reciprocal vectors.
    pub fn zone_path<const D: usize>(self) -> Vec<(&'static str, Fractional<D>)> {
        let points: &[(&str, [f64; 2])] = match self {
            Self::Chain => &[("Γ", [0.0, 0.0]), ("X", [0.5, 0.0])],
            Self::Square => &[
                ("Γ", [0.0, 0.0]),
                ("X", [0.5, 0.0]),
                ("M", [0.5, 0.5]),
                ("Γ", [0.0, 0.0]),
            ],
            Self::Hexagonal => &[
                ("Γ", [0.0, 0.0]),
                ("M", [0.5, 0.0]),
                ("K", [2.0 / 3.0, 1.0 / 3.0]),
                ("Γ", [0.0, 0.0]),
            ],
        };
        points
            .iter()
            .map(|(name, k)| (*name, SVector::from_fn(|i, _| k[i])))
            .collect()
    }
}
