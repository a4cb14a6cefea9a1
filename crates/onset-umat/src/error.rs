//! Errors of a user material or its process.

use crate::arguments::is_state;
use crate::interface::Interface;
use nalgebra::Matrix3;
use onset::material::MaterialError;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Error of a user material or its process.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum UmatError {
    /// Library that does not exist.
    #[error(
        "there is no library {path}\n  hint: compile it with: gfortran -shared -fPIC -O2 -o umat.so umat.f",
        path = path.display()
    )]
    NoLibrary {
        /// Path of the library.
        path: PathBuf,
    },
    /// Library that the system cannot load.
    #[error("cannot load {path}: {message}{}", load_hint(path, message), path = path.display())]
    Load {
        /// Path of the library.
        path: PathBuf,
        /// Message of the system.
        message: String,
    },
    /// Library without the routine.
    #[error(
        "{path} has no routine {name}; expected {expected}\n  hint: list its names with: nm -D {path}",
        path = path.display(),
        name = interface.symbols()[0],
        expected = interface.expected()
    )]
    NoRoutine {
        /// Path of the library.
        path: PathBuf,
        /// Interface of the routine that the library must contain.
        interface: Interface,
    },
    /// Library whose routine cannot be used.
    #[error("{path} cannot be used: {message}", path = path.display())]
    Unsuitable {
        /// Path of the library.
        path: PathBuf,
        /// Reason, with a hint.
        message: String,
    },
    /// Invalid number of increments.
    #[error("a state cannot be reached in {increments} increments; expected 1 or more")]
    Increments {
        /// Requested number of increments.
        increments: u32,
    },
    /// Failure to start the process of the routine.
    #[error(
        "the process for the routine cannot be started: {message}\n  hint: set the environment variable ONSET_UMAT_HOST to \
         the onset executable"
    )]
    NoProcess {
        /// Reason for the failure.
        message: String,
    },
    /// Process that ended during a call.
    #[error(
        "the routine's process ended during a call ({how}){}{}{}",
        at(state.as_deref()),
        said(output),
        memory_hint(output)
    )]
    Ended {
        /// Description of the signal or exit code.
        how: String,
        /// Deformation gradient of the call; `None` during loading.
        state: Option<Box<Matrix3<f64>>>,
        /// Last lines of the process's output.
        output: String,
    },
    /// Call without a result within the time limit.
    #[error(
        "the routine gave no answer within {seconds} s and was ended; is there an endless loop?{}{}",
        at(state.as_deref()),
        said(output)
    )]
    Silent {
        /// Time limit of a call; seconds.
        seconds: f64,
        /// Deformation gradient of the call; `None` during loading.
        state: Option<Box<Matrix3<f64>>>,
        /// Last lines of the process's output.
        output: String,
    },
    /// Result that is not a finite number.
    #[error(
        "the routine returned {value} in {what}{}\n  hint: does it read more than the {properties} properties and {variables} state variables \
         that are given, or divide by a strain that is zero?{}",
        at_state(state),
        match interface {
            Interface::Vumat => " Is it compiled in double precision (VABA_PARAM.INC with REAL*8)?",
            _ => "",
        }
    )]
    NotFinite {
        /// Name and index of the array element.
        what: String,
        /// Value of the element.
        value: f64,
        /// Interface of the routine.
        interface: Interface,
        /// Number of properties passed to the routine.
        properties: usize,
        /// Number of state variables.
        variables: usize,
        /// Deformation gradient of the call.
        state: Box<Matrix3<f64>>,
    },
    /// Argument that was written beyond its ends.
    #[error(
        "the routine wrote beyond the ends of {argument}{}{}\n  hint: {}",
        if is_state(argument) { format!(", which holds {variables} state variables") } else { String::new() },
        at_state(state),
        if is_state(argument) { "set material.state-variables to the number that it needs (*DEPVAR in Abaqus)" }
        else { "does the routine take three-dimensional tensors, and the number of properties that are given?" }
    )]
    Overrun {
        /// Name of the argument.
        argument: &'static str,
        /// Number of state variables.
        variables: usize,
        /// Deformation gradient of the call.
        state: Box<Matrix3<f64>>,
    },
    /// Library that has changed since it was first loaded.
    #[error(
        "{path} has changed since it was first loaded: its SHA-256 was {wanted} and is {found}\n  hint: a library must not be \
         recompiled while it is used; to resume a map, restore the first version; otherwise start afresh",
        path = path.display()
    )]
    Changed {
        /// Path of the library.
        path: PathBuf,
        /// Checksum of the first library.
        wanted: String,
        /// Checksum of the present library.
        found: String,
    },
    /// Request of the routine for a smaller increment.
    #[error(
        "the routine requests a smaller increment ({factor} times increment {increment} of {increments}){}\n  hint: set \
         material.increments to a larger number",
        at_state(state)
    )]
    SmallerIncrement {
        /// Requested ratio of increments: `PNEWDT`, or `rdt` of MFront.
        factor: f64,
        /// Number of the increment, from 1.
        increment: u32,
        /// Number of increments on the path.
        increments: u32,
        /// Deformation gradient of the call.
        state: Box<Matrix3<f64>>,
    },
    /// Response without balance of angular momentum.
    #[error(
        "the stress or tangent of the routine violates the balance of angular momentum (P F^T is not symmetric){}\n  hint: \
         components are stored row by row, P[3*i + J] and A[27*i + 9*J + 3*k + L] = dP_iJ/dF_kL, with the index of the \
         current configuration first; an array of Fortran is the transpose, and single precision is not enough",
        at_state(state)
    )]
    Skew {
        /// Deformation gradient of the state.
        state: Box<Matrix3<f64>>,
    },
    /// State that cannot be decomposed into stretch and rotation.
    #[error(
        "the logarithmic strain of increment {increment} cannot be computed{}\n  hint: check the deformation gradient, or set material.increments to a larger number",
        at_state(state)
    )]
    Increment {
        /// Number of the increment, from 1.
        increment: u32,
        /// Deformation gradient of the state.
        state: Box<Matrix3<f64>>,
    },
    /// Operating system without support for the process of the routine.
    #[error("routines in shared libraries run on Linux and macOS only")]
    Platform,
}

impl From<UmatError> for MaterialError {
    fn from(error: UmatError) -> Self {
        Self::External {
            message: error.to_string(),
        }
    }
}

fn at(state: Option<&Matrix3<f64>>) -> String {
    state.map_or_else(|| "\n  while the library was loaded".to_owned(), at_state)
}

fn at_state(f: &Matrix3<f64>) -> String {
    let row = |i: usize| format!("{:?}, {:?}, {:?}", f[(i, 0)], f[(i, 1)], f[(i, 2)]);
    format!("\n  at F = [{}; {}; {}]", row(0), row(1), row(2))
}

fn said(output: &str) -> String {
    match output.trim_end() {
        "" => String::new(),
        text => format!("\n  it printed: {}", text.replace('\n', "\n              ")),
    }
}

/// Hint for output of the Fortran or C++ runtime about a failed memory allocation.
fn memory_hint(output: &str) -> &'static str {
    if ["allocate memory", "allocating", "bad_alloc"]
        .iter()
        .any(|words| output.contains(words))
    {
        "\n  hint: material.memory-limit sets its memory, in MiB"
    } else {
        ""
    }
}

fn load_hint(path: &Path, message: &str) -> &'static str {
    let mentions = |words: &[&str]| words.iter().any(|word| message.contains(word));
    // The loader skips a library for another machine, and then reports it as missing.
    let is_passed_over = message.starts_with(&*path.to_string_lossy());
    if mentions(&["undefined symbol", "symbol not found"]) {
        "\n  hint: routines of Abaqus such as SINV, SPRINC, ROTSIG and XIT come with `onset umat-utilities > utilities.f90`; \
         compile that file together with the UMAT"
    } else if mentions(&["No such file"]) && !is_passed_over {
        "\n  hint: a library that the routine needs is missing; name its folder in LD_LIBRARY_PATH, or compile with \
         -static-libgfortran"
    } else if mentions(&["failed to map segment"]) {
        "\n  hint: a copy of it is loaded from the folder for temporary files, which may be mounted without execution (noexec): set the \
         environment variable TMPDIR to another folder"
    } else if mentions(&["No such file", "ELF", "architecture", "mach-o", "too short"]) {
        "\n  hint: a shared library of this machine's architecture is needed; compile it here with: gfortran -shared -fPIC -O2 \
         -o umat.so umat.f"
    } else {
        ""
    }
}
