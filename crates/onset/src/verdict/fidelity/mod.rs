//! Fidelity of a discretization to its material in a window of two parameters.
//!
//! *False instability* is the region where the material is strongly elliptic and the particles are unstable. *Suppressed instability* is the region
//! where the material is not strongly elliptic and the particles are stable. The distance of the boundaries is measured as the Hausdorff distance
//! and, as in the paper, along rays from the reference state.

mod area;
mod distance;
mod rays;

pub use area::{Areas, areas};
pub use distance::{Distance, directed_distance};
pub use rays::{RayOnset, onset_along};
