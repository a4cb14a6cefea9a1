//! How good a discretization is: the same questions, asked of any of them.
//!
//! | measure | question |
//! |---|---|
//! | [`spurious_modes`] | which modes have zero energy, or are weakly controlled, in the reference configuration? |
//! | [`dispersion_errors`] | how large is the error of the frequencies at so many points per wavelength? |
//! | [`long_wave_error`] | how large is the consistency error: how far are the long-wavelength moduli from those of the material? |
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
