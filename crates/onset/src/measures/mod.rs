//! How good a discretization is: the same questions, asked of any of them.
//!
//! | measure | question |
//! |---|---|
//! | [`spurious_modes`] | which waves have no energy, or too little, in the reference configuration? |
//! | [`dispersion_errors`] | how wrong are frequencies at so many points per wavelength? |
//! | [`long_wave_error`] | how far is the acoustic tensor of long waves from that of the material? |
//! | [`onset`] | at which stretch is stability lost first, and at which does the material lose it? |
//! | [`fidelity`] | on which share of a window of states is the method falsely unstable, or stable where the material is not? |

mod degenerate;
mod dispersion;
mod fidelity;
mod onset;
mod spurious;
mod zero_energy;

pub use dispersion::{DispersionError, dispersion_errors, long_wave_error};
pub use fidelity::{Fidelity, StateWindow, fidelity};
pub use onset::{Load, OnsetPair, StretchOnset, onset};
pub use spurious::{SpuriousMode, SpuriousModes, spurious_modes};
pub use zero_energy::Extent;
