//! Quality measures of a discretization, comparable among all methods.
//!
//! | measure | result |
//! |---|---|
//! | [`spurious_modes`] | zero-energy modes and weakly controlled modes in the reference configuration |
//! | [`dispersion_errors`] | errors of the frequencies for given numbers of points per wavelength |
//! | [`long_wave_error`] | consistency error: difference of the long-wavelength moduli from the moduli of the material |
//! | [`onset`] | stretches at which the method and the material first lose stability |
//! | [`fidelity`] | fractions of false and suppressed instability in a window of states |

mod degenerate;
mod dispersion;
mod fidelity;
mod onset;
mod spurious;

pub use crate::zero_energy::Extent;
pub use dispersion::{DispersionError, dispersion_errors, long_wave_error};
pub use fidelity::{Fidelity, StateWindow, fidelity};
pub use onset::{Load, OnsetPair, StretchOnset, onset};
pub use spurious::{SpuriousMode, SpuriousModes, spurious_modes};
