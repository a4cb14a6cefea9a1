//! Quadrature points and volumes for the integration of internal forces.

mod cell;
mod moments;

pub(crate) use cell::gauss_line;
pub use cell::{CellRule, gauss_points, own_points};
pub use moments::second_moments;

use crate::lattice::{BravaisLattice, Fractional, LatticeError, delaunay_centers, voronoi_volumes};
use nalgebra::{SMatrix, SVector};
use thiserror::Error;

/// Set of quadrature points in a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Quadrature {
    /// The particles alone, equation (41).
    Nodal,
    /// The particles and the centers of the Delaunay cells, equation (42).
    StressPoints,
    /// The centers of the Delaunay cells alone (Randles et al.).
    StressPointsOnly,
    /// The particles, with the strain expanded to first order over their Voronoi cells: naturally stabilized nodal
    /// integration, Hillman and Chen, Int. J. Numer. Meth. Engng 107 (2016) 603.
    ///
    /// The energy of a cell is `V w(F) + 1/2 M_jl F_,j : A : F_,l` with the second moments `M` of the cell. Lagrangian kernels only.
    NodalStabilized,
    /// Gauss points of the parallelepipeds spanned by the primitive vectors, with the particles at the corners.
    Gauss,
    /// User-defined points with user-defined weights.
    Points,
}

impl Quadrature {
    /// All quadratures, in the order of the documentation.
    pub const ALL: [Self; 6] = [
        Self::Nodal,
        Self::StressPoints,
        Self::StressPointsOnly,
        Self::NodalStabilized,
        Self::Gauss,
        Self::Points,
    ];
}

/// Quadrature point of the primitive cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadraturePoint<const D: usize> {
    /// Position in lattice coordinates.
    pub place: Fractional<D>,
    /// Reference volume `V_q`; length^D. The volumes of a cell add up to `V0`.
    pub volume: f64,
    /// Whether the point is a particle and moves with it.
    pub is_node: bool,
    /// Integral `M_jl` of `x_j x_l` over the cell of the point, if the strain is expanded over this cell; length^(D+2).
    pub second_moments: Option<SMatrix<f64, D, D>>,
}

impl<const D: usize> QuadraturePoint<D> {
    /// Builds a point that integrates only the strain at its position. A point at the origin of the cell is a particle.
    pub fn new(place: Fractional<D>, volume: f64) -> Self {
        Self {
            place,
            volume,
            is_node: place.amax() == 0.0,
            second_moments: None,
        }
    }
}

/// Error in the quadrature points.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum QuadratureError {
    /// The fraction of the volume at the stress points is not between 0 and 1.
    #[error(
        "discretization.stress-point-weight is {value:?}; it is the fraction of the cell's volume at the stress points \
         and must be above 0 and below 1"
    )]
    StressPointWeight {
        /// Fraction given by the user.
        value: f64,
    },
    /// The number of Gauss points is not available.
    #[error("discretization.gauss-points is {value}; it must be from 1 to {most}, per direction")]
    GaussPoints {
        /// Number of Gauss points given.
        value: u32,
        /// Largest available number of points.
        most: u32,
    },
    /// A user-defined list is empty or ends within a point.
    #[error(
        "discretization.points has {length} number(s); expected {each} for each point: \
         {dimension} lattice coordinate(s) and a fraction of the cell's volume"
    )]
    PointsLength {
        /// Number of values in the list.
        length: usize,
        /// Number of values for each point.
        each: usize,
        /// Number of space dimensions.
        dimension: usize,
    },
    /// A coordinate is not finite, or a weight is not positive.
    #[error(
        "point {number} of discretization.points has {value:?} as its {what}; \
         expected finite lattice coordinates and positive fractions"
    )]
    PointsValue {
        /// Number of the point, from 1.
        number: usize,
        /// Kind of value, `coordinate` or `weight`.
        what: &'static str,
        /// Value given by the user.
        value: f64,
    },
    /// The weights do not add up to the volume of the cell.
    #[error(
        "the weights of discretization.points add up to {sum:?}; they are fractions of the cell's volume \
         and must add up to 1"
    )]
    PointsSum {
        /// Sum of the weights given.
        sum: f64,
    },
    /// The lattice has no Voronoi volumes.
    #[error(transparent)]
    Lattice(#[from] LatticeError),
}

impl Quadrature {
    /// Returns the points of one cell, with the volumes of their Voronoi cells, equation (43), unless `rule` overrides them.
    ///
    /// # Errors
    /// [`QuadratureError`] if the rule is not admissible, or if Voronoi volumes are not available.
    pub fn points<const D: usize>(
        self,
        lattice: &BravaisLattice<D>,
        rule: &CellRule,
    ) -> Result<Vec<QuadraturePoint<D>>, QuadratureError> {
        let node = SVector::zeros();
        let volume = lattice.cell_volume();
        match self {
            Self::Nodal => Ok(vec![QuadraturePoint::new(node, volume)]),
            Self::NodalStabilized => Ok(vec![QuadraturePoint {
                second_moments: Some(second_moments(lattice)),
                ..QuadraturePoint::new(node, volume)
            }]),
            Self::StressPointsOnly => of_voronoi(lattice, delaunay_centers(lattice, &[node])?),
            Self::StressPoints => {
                let nodes = std::iter::once(node);
                let places = nodes.chain(delaunay_centers(lattice, &[node])?).collect();
                let points = of_voronoi(lattice, places)?;
                match rule.stress_point_weight {
                    Some(weight) => weighted(points, volume, weight),
                    None => Ok(points),
                }
            }
            Self::Gauss => gauss_points(lattice, rule.gauss_points),
            Self::Points => own_points(lattice, &rule.points),
        }
    }
}

fn of_voronoi<const D: usize>(
    lattice: &BravaisLattice<D>,
    places: Vec<Fractional<D>>,
) -> Result<Vec<QuadraturePoint<D>>, QuadratureError> {
    let volumes = voronoi_volumes(lattice, &places)?;
    let points = places.into_iter().zip(volumes);
    Ok(points
        .map(|(place, volume)| QuadraturePoint::new(place, volume))
        .collect())
}

/// Scales the volumes so that the stress points have a given fraction of the volume. Proportions among the stress points and among the particles do
/// not change.
fn weighted<const D: usize>(
    mut points: Vec<QuadraturePoint<D>>,
    volume: f64,
    weight: f64,
) -> Result<Vec<QuadraturePoint<D>>, QuadratureError> {
    if !(weight > 0.0 && weight < 1.0) {
        return Err(QuadratureError::StressPointWeight { value: weight });
    }
    let of_nodes: f64 = points.iter().filter(|p| p.is_node).map(|p| p.volume).sum();
    let of_others: f64 = points.iter().filter(|p| !p.is_node).map(|p| p.volume).sum();
    for point in &mut points {
        point.volume *= match point.is_node {
            true => (1.0 - weight) * volume / of_nodes,
            false => weight * volume / of_others,
        };
    }
    Ok(points)
}
