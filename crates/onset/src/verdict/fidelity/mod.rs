//! How faithful a discretization is to its material, over a window of two parameters.
//!
//! *False instability* is where the material is strongly elliptic and the particles are not stable; *suppressed instability*
//! where the material is not and the particles are. How far the boundaries are apart is measured as the Hausdorff distance
//! and, as the paper does, along rays from the reference state.

mod area;
mod distance;
mod rays;

pub use area::{Areas, areas};
pub use distance::{Distance, directed_distance};
pub use rays::{RayOnset, onset_along};
