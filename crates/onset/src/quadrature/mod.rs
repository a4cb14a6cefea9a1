//! Where the internal forces are integrated, and with which volumes.

use crate::lattice::{BravaisLattice, Fractional, LatticeError, delaunay_centers, voronoi_volumes};
use nalgebra::SVector;

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
}

impl Quadrature {
    /// The points of one cell with the volumes of their Voronoi cells, equation (43).
    ///
    /// # Errors
    /// [`LatticeError`] where Voronoi volumes are not available.
    pub fn points<const D: usize>(
        self,
        lattice: &BravaisLattice<D>,
    ) -> Result<Vec<QuadraturePoint<D>>, LatticeError> {
        let nodes = (self != Self::StressPointsOnly)
            .then(SVector::zeros)
            .into_iter();
        let centers = match self {
            Self::Nodal => Vec::new(),
            Self::StressPoints | Self::StressPointsOnly => {
                delaunay_centers(lattice, &[SVector::zeros()])?
            }
        };
        let places: Vec<Fractional<D>> = nodes.chain(centers).collect();
        let volumes = voronoi_volumes(lattice, &places)?;
        let point = |(place, volume): (Fractional<D>, f64)| QuadraturePoint {
            place,
            volume,
            is_node: place.amax() == 0.0,
        };
        Ok(places.into_iter().zip(volumes).map(point).collect())
    }
}
