//! Which program the routine runs in.

use crate::error::UmatError;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::OnceLock;

/// The variable that names a program whose `main` begins with [`serve_if_asked`]; used before all else.
pub const HOST_VARIABLE: &str = "ONSET_UMAT_HOST";

/// The first argument of a process that is to run a routine; the second says to people which library it is, the third is the copy that
/// is loaded.
pub(crate) const MODE: &str = "umat-host";

/// The running program, when it can serve.
static SELF: OnceLock<PathBuf> = OnceLock::new();

/// Runs a UMAT for another process if this one was started for that, and returns how to end; otherwise notes that this program
/// can be started for that. To be called first in `main`.
pub fn serve_if_asked() -> Option<ExitCode> {
    let mut arguments = std::env::args_os().skip(1);
    if arguments.next().is_some_and(|mode| mode == MODE) {
        let library = PathBuf::from(arguments.nth(1).unwrap_or_default());
        return Some(serve(&library));
    }
    if let Ok(program) = std::env::current_exe() {
        SELF.get_or_init(|| program);
    }
    None
}

#[cfg(unix)]
fn serve(library: &Path) -> ExitCode {
    crate::host::serve(library)
}

#[cfg(not(unix))]
fn serve(_library: &Path) -> ExitCode {
    eprintln!("error: {}", UmatError::Platform);
    ExitCode::from(2)
}

/// The program to start: the one that the variable names, the running one, or `onset` beside it or on the path.
pub(crate) fn host() -> Result<PathBuf, UmatError> {
    if let Some(named) = std::env::var_os(HOST_VARIABLE) {
        let named = PathBuf::from(named);
        return if named.is_file() {
            Ok(named)
        } else {
            Err(UmatError::NoProcess {
                message: format!("{HOST_VARIABLE} is {}, which is no file", named.display()),
            })
        };
    }
    if let Some(program) = SELF.get() {
        return Ok(program.clone());
    }
    let name = format!("onset{}", std::env::consts::EXE_SUFFIX);
    let beside = std::env::current_exe()
        .ok()
        .and_then(|program| program.parent().map(Path::to_path_buf));
    let path = std::env::var_os("PATH").unwrap_or_default();
    beside
        .into_iter()
        .chain(std::env::split_paths(&path))
        .map(|folder| folder.join(&name))
        .find(|program| program.is_file())
        .ok_or_else(|| UmatError::NoProcess {
            message: format!("{name} is not on the path"),
        })
}
