//! What can be wrong with a user material.

use nalgebra::Matrix3;
use onset::material::MaterialError;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// What can be wrong with a user material or its process.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum UmatError {
    /// There is no such file.
    #[error(
        "there is no library {path}\n  hint: make one with: gfortran -shared -fPIC -O2 -o umat.so umat.f",
        path = path.display()
    )]
    NoLibrary {
        /// The file.
        path: PathBuf,
    },
    /// The system cannot load the file.
    #[error("cannot load {path}: {message}{}", load_hint(path, message), path = path.display())]
    Load {
        /// The file.
        path: PathBuf,
        /// The system's words.
        message: String,
    },
    /// The library has no routine of that name.
    #[error(
        "{path} has no routine umat_; expected SUBROUTINE UMAT compiled as Fortran (or umat_ in C)\n  hint: see its names \
         with: nm -D {path}",
        path = path.display()
    )]
    NoRoutine {
        /// The file.
        path: PathBuf,
    },
    /// No increments.
    #[error("a state cannot be reached in {increments} increments; expected 1 or more")]
    Increments {
        /// How many were asked for.
        increments: u32,
    },
    /// There is no program that the routine could run in.
    #[error(
        "the process for the UMAT cannot be started: {message}\n  hint: let the variable ONSET_UMAT_HOST name the onset \
         executable"
    )]
    NoProcess {
        /// Why.
        message: String,
    },
    /// The process ended during a call.
    #[error(
        "the UMAT's process ended during a call ({how}){}{}{}",
        at(state.as_deref()),
        said(output),
        memory_hint(output)
    )]
    Ended {
        /// The signal or the exit code, in words.
        how: String,
        /// The state; none while the library was loaded.
        state: Option<Box<Matrix3<f64>>>,
        /// The last lines that it printed.
        output: String,
    },
    /// No answer within the limit.
    #[error(
        "the UMAT gave no answer within {seconds} s and was ended; is there an endless loop?{}{}",
        at(state.as_deref()),
        said(output)
    )]
    Silent {
        /// The limit.
        seconds: f64,
        /// The state; none while the library was loaded.
        state: Option<Box<Matrix3<f64>>>,
        /// The last lines that it printed.
        output: String,
    },
    /// A result is no number.
    #[error(
        "the UMAT returned {value} in {what}{}\n  hint: does it read more properties than the {properties} that are given, \
         or divide by a strain that is zero?",
        at_state(state)
    )]
    NotFinite {
        /// The array and its index.
        what: String,
        /// The value.
        value: f64,
        /// How many properties were given.
        properties: usize,
        /// The state.
        state: Box<Matrix3<f64>>,
    },
    /// It wrote beyond the ends of an argument.
    #[error(
        "the UMAT wrote beyond the ends of {argument}{}{}\n  hint: {}",
        if *argument == "STATEV" { format!(", which holds {variables} state variables") } else { String::new() },
        at_state(state),
        if *argument == "STATEV" { "set material.state-variables to the number that it needs (*DEPVAR)" }
        else { "are its dimensions those of its arguments NTENS = 6, NDI = 3, NSHR = 3 and NPROPS?" }
    )]
    Overrun {
        /// The argument.
        argument: &'static str,
        /// How many state variables there are.
        variables: usize,
        /// The state.
        state: Box<Matrix3<f64>>,
    },
    /// The library is another than at first.
    #[error(
        "{path} is another library than at first: its SHA-256 was {wanted} and is {found}\n  hint: a library must not be \
         compiled anew while it is used; to resume a map, put the first one back; without it, start afresh",
        path = path.display()
    )]
    Changed {
        /// The file.
        path: PathBuf,
        /// The sum of the first.
        wanted: String,
        /// The sum of what is there.
        found: String,
    },
    /// It asks for a smaller increment.
    #[error(
        "the UMAT asks for a smaller increment (PNEWDT = {factor} in increment {increment} of {increments}){}\n  hint: set \
         material.increments to a larger number",
        at_state(state)
    )]
    SmallerIncrement {
        /// `PNEWDT`.
        factor: f64,
        /// The increment, counted from 1.
        increment: u32,
        /// How many there are.
        increments: u32,
        /// The state.
        state: Box<Matrix3<f64>>,
    },
    /// The state cannot be split into stretch and rotation.
    #[error("increment {increment} has no logarithmic strain{}", at_state(state))]
    Increment {
        /// The increment, counted from 1.
        increment: u32,
        /// The state.
        state: Box<Matrix3<f64>>,
    },
    /// The processes of other systems lack what is needed.
    #[error("UMATs run on Linux and macOS only")]
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

/// Fortran's runtime and C++'s say so when they get no memory.
fn memory_hint(output: &str) -> &'static str {
    if ["allocate memory", "allocating", "bad_alloc"]
        .iter()
        .any(|words| output.contains(words))
    {
        "\n  hint: it may use as much memory as material.memory-limit says, in MiB"
    } else {
        ""
    }
}

fn load_hint(path: &Path, message: &str) -> &'static str {
    let mentions = |words: &[&str]| words.iter().any(|word| message.contains(word));
    // The loader passes over a library of another machine, and then says that there is none.
    let is_passed_over = message.starts_with(&*path.to_string_lossy());
    if mentions(&["undefined symbol", "symbol not found"]) {
        "\n  hint: routines of Abaqus such as SINV, SPRINC, ROTSIG and XIT come with `onset umat-utilities > utilities.f90`; \
         compile that file together with the UMAT"
    } else if mentions(&["No such file"]) && !is_passed_over {
        "\n  hint: a library that the UMAT needs is missing; name its folder in LD_LIBRARY_PATH, or compile with \
         -static-libgfortran"
    } else if mentions(&["failed to map segment"]) {
        "\n  hint: a copy of it is loaded from the folder for temporary files, which may be closed to programs (noexec): let the variable \
         TMPDIR name another one"
    } else if mentions(&["No such file", "ELF", "architecture", "mach-o", "too short"]) {
        "\n  hint: a shared library of this machine's architecture is needed; make it here with: gfortran -shared -fPIC -O2 \
         -o umat.so umat.f"
    } else {
        ""
    }
}
