//! Where the internal forces are integrated, and with which volumes.

mod cell;
mod moments;

pub(crate) use cell::gauss_line;
pub use cell::{CellRule, gauss_points, own_points};
pub use moments::second_moments;

use crate::lattice::{BravaisLattice, Fractional, LatticeError, delaunay_centers, voronoi_volumes};
use nalgebra::{SMatrix, SVector};
use thiserror::Error;

/// The set of quadrature points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Quadrature {
    /// At the particles only, equation (41).
    Nodal,
    /// At the particles and at the centers of the Delaunay cells, equation (42).
    StressPoints,
    /// At the centers of the Delaunay cells only (Randles et al.).
    StressPointsOnly,
    /// At the particles, with the strain expanded to first order over their Voronoi cells: naturally stabilized nodal
    /// integration, Hillman and Chen, Int. J. Numer. Meth. Engng 107 (2016) 603. The energy of a cell is
    /// `V w(F) + 1/2 M_jl F_,j : A : F_,l` with the second moments `M` of the cell. Lagrangian kernels only.
    NodalStabilized,
    /// At Gauss points of the cells between the particles: the parallelepipeds that the primitive vectors span.
    Gauss,
    /// At user-defined points with user-defined weights.
    Points,
}

impl Quadrature {
    /// All of them, in the order of the documentation.
    pub const ALL: [Self; 6] = [
        Self::Nodal,
        Self::StressPoints,
        Self::StressPointsOnly,
        Self::NodalStabilized,
        Self::Gauss,
        Self::Points,
    ];
}

/// A quadrature point of the primitive cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadraturePoint<const D: usize> {
    /// Its place, in lattice coordinates.
    pub place: Fractional<D>,
    /// Its reference volume `V_q`; the volumes of a cell add up to `V0`.
    pub volume: f64,
    /// Whether it is a particle, and moves as such.
    pub is_node: bool,
    /// Where strain is expanded over the point's cell: `M_jl`, the integral of `x_j x_l` over it; length^(D+2).
    pub second_moments: Option<SMatrix<f64, D, D>>,
}

impl<const D: usize> QuadraturePoint<D> {
    /// A point that stands for its volume with nothing but its own strain; a particle at the origin of the cell.
    pub fn new(place: Fractional<D>, volume: f64) -> Self {
        Self {
            place,
            volume,
            is_node: place.amax() == 0.0,
            second_moments: None,
        }
    }
}

/// What can be wrong with quadrature points.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum QuadratureError {
    /// The stress points' part of the volume is no proper part.
    #[error(
        "discretization.stress-point-weight is {value:?}; it is the fraction of the cell's volume at the stress points \
         and must be above 0 and below 1"
    )]
    StressPointWeight {
        /// Its value.
        value: f64,
    },
    /// There is no such Gauss rule here.
    #[error("discretization.gauss-points is {value}; it must be from 1 to {most}, per direction")]
    GaussPoints {
        /// The number asked for.
        value: u32,
        /// The largest available.
        most: u32,
    },
    /// A user-defined list is empty or ends within a point.
    #[error(
        "discretization.points has {length} number(s); expected {each} for each point: \
         {dimension} lattice coordinate(s) and a fraction of the cell's volume"
    )]
    PointsLength {
        /// How many numbers it has.
        length: usize,
        /// How many a point needs.
        each: usize,
        /// The dimension.
        dimension: usize,
    },
    /// A coordinate is not finite or a weight not positive.
    #[error(
        "point {number} of discretization.points has {value:?} as its {what}; \
         expected finite lattice coordinates and positive fractions"
    )]
    PointsValue {
        /// Which point, from 1.
        number: usize,
        /// `coordinate` or `weight`.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// The weights do not add up to the cell.
    #[error(
        "the weights of discretization.points add up to {sum:?}; they are fractions of the cell's volume \
         and must add up to 1"
    )]
    PointsSum {
        /// Their sum.
        sum: f64,
    },
    /// The lattice.
    #[error(transparent)]
    Lattice(#[from] LatticeError),
}

impl Quadrature {
    /// The points of one cell, with the volumes of their Voronoi cells, equation (43), unless `rule` says otherwise.
    ///
    /// # Errors
    /// [`QuadratureError`] where the rule is not admissible or Voronoi volumes are not available.
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

/// The same points with a fraction of the volume at the stress points, among which, as among the particles, it is shared as
/// it was.
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
