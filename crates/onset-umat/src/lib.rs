//! User materials in shared libraries as materials of `onset`: Abaqus's `SUBROUTINE UMAT` and `SUBROUTINE VUMAT`, and the C function of
//! [`LAW_HEADER`].
//!
//! A [`Umat`] consists of a shared library, its properties and its number of state variables. It implements
//! [`Hyperelastic`](onset::material::Hyperelastic): a state `F` is reached from the identity in proportional increments ([`proportional_path`]), the
//! Cauchy stress is converted to `P`, and `DDSDDE` to `dP/dF` ([`Delivered::response`]).
//!
//! The routine runs in a separate process, so that a crash, `STOP` or an endless loop results in an error message. The process runs the current
//! program itself, if its `main` begins with [`serve_if_asked`].
//!
//! Conventions follow Abaqus/Standard in three dimensions:
//!
//! - Components have the order 11, 22, 33, 12, 13, 23, and shear strains are engineering strains.
//! - `DDSDDE` is the Jaumann rate of the Kirchhoff stress over `J` per rate of deformation.
//! - Stress and strain are rotated by `DROT` before the call.

mod arguments;
mod conversion;
mod error;
mod fingerprint;
mod folder;
mod frame;
mod increment;
mod interface;
mod program;
mod readable;
mod voigt;

#[cfg(unix)]
mod host;
#[cfg(unix)]
mod process;
#[cfg(unix)]
mod routine;

mod umat;

pub use conversion::{Delivered, jaumann_kirchhoff, tangent_from_jaumann_kirchhoff};
pub use error::UmatError;
pub use fingerprint::fingerprint;
pub use folder::PrivateFolder;
pub use increment::{Increment, proportional_path};
pub use interface::Interface;
pub use program::{HOST_VARIABLE, serve_if_asked};
pub use readable::{message, readable};
pub use umat::{Outcome, Umat, UmatSettings};
pub use voigt::{VOIGT, tensor_of_voigt, voigt_of_tensor};

/// C declaration of the function [`Interface::Law`].
pub const LAW_HEADER: &str = include_str!("../include/onset_law.h");

/// Runs a program to its end, and ends all processes that it leaves running; [`end_all`] also ends the program. Not available on Windows.
///
/// # Errors
/// [`std::io::Error`] if the program cannot be started or waited for.
pub fn run(command: &mut std::process::Command) -> std::io::Result<std::process::ExitStatus> {
    #[cfg(unix)]
    return process::run(command);
    #[cfg(not(unix))]
    command.status()
}

/// Ends all processes of routines and programs with their children, and removes all private folders.
///
/// For a process that ends without dropping its values, as on a signal. Afterwards it can run no routine or program.
pub fn end_all() {
    #[cfg(unix)]
    process::end_all();
    folder::remove_all();
}

/// Fortran source of the routines that Abaqus offers to user subroutines (`SINV`, `SPRINC`, `SPRIND`, `ROTSIG`, `XIT`, ...).
///
/// Written for `onset`, to be compiled together with a UMAT that calls them.
pub const UTILITIES: &str = include_str!("../fortran/abaqus_utilities.f90");
