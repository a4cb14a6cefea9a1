//! Errors in the meshes of finite elements.

use thiserror::Error;

/// Error in the description of a mesh.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum MeshError {
    /// An element has too few or too many nodes.
    #[error("element {element} has {nodes} node(s), not {needed}")]
    NodeCount {
        /// Number of the element in the cell.
        element: usize,
        /// Number of nodes given.
        nodes: usize,
        /// Number of nodes of the element shape.
        needed: usize,
    },
    /// An element has a node at a site that the crystal does not have.
    #[error("element {element} has a node at site {site}; the sites of the cell are 0 to {last}")]
    UnknownSite {
        /// Number of the element in the cell.
        element: usize,
        /// Number of the site given.
        site: usize,
        /// Largest number of a site.
        last: usize,
    },
    /// An element has no volume or is partly inverted.
    #[error(
        "element {element} is flat or inverted; expected corners in the order (-1,-1), (1,-1), (-1,1), (1,1) for quadrilaterals, in the same binary order for bricks"
    )]
    Distorted {
        /// Number of the element in the cell.
        element: usize,
    },
    /// The elements overlap or leave gaps.
    #[error(
        "the elements of a cell have the volume {elements:?}, the cell {cell:?}; expected elements that fill the cell exactly once"
    )]
    Volume {
        /// Sum of the volumes of the elements; length^D.
        elements: f64,
        /// Volume of the cell; length^D.
        cell: f64,
    },
    /// Hourglass control was requested for elements without hourglass modes.
    #[error(
        "hourglass control is not supported with full integration or a mean dilatation, which have no hourglass modes; choose integration = \"one-point\", or set hourglass-stiffness and hourglass-viscosity to 0"
    )]
    NeedlessControl,
    /// A row sum of the mass matrix is negative or zero, as at the corners of quadratic elements.
    #[error(
        "node {site} of a cell has a lumped mass of {share:.4} of the cell (the sum of its row of the mass matrix); lumped masses must be positive: choose mass = \"hrz\" or \"consistent\""
    )]
    Massless {
        /// Number of the node in the cell.
        site: usize,
        /// Lumped mass divided by the mass of the cell; dimensionless.
        share: f64,
    },
}
