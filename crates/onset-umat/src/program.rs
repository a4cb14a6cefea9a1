//! Choice of the program in which the routine runs.

use crate::error::UmatError;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::OnceLock;

/// Environment variable with a program whose `main` begins with [`serve_if_asked`]; it takes precedence.
pub const HOST_VARIABLE: &str = "ONSET_UMAT_HOST";

/// First argument of a process that runs a routine.
///
/// The second argument makes the name of the library visible in process lists, and the third argument is the copy to load.
pub(crate) const MODE: &str = "umat-host";

/// Running program, if it can act as the host.
static SELF: OnceLock<PathBuf> = OnceLock::new();

/// Runs a UMAT if another process started this program to run it, and returns the exit code.
///
/// Otherwise returns `None` and records that this program can be started to run a UMAT. Must be called first in `main`.
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

/// Program to start: the program named by the variable, the running program, or `onset` in the same folder or on the path.
pub(crate) fn host() -> Result<PathBuf, UmatError> {
    if let Some(named) = std::env::var_os(HOST_VARIABLE) {
        let named = PathBuf::from(named);
        return if named.is_file() {
            Ok(named)
        } else {
            Err(UmatError::NoProcess {
                message: format!(
                    "{HOST_VARIABLE} is {}, which is not a file",
                    named.display()
                ),
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
