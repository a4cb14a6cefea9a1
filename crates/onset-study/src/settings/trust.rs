//! Permissions of files to run programs.

use std::path::{Path, PathBuf};

/// Environment variable with libraries, or folders of libraries, that files may always load; separated as in `PATH`.
pub const TRUST_VARIABLE: &str = "ONSET_ALLOW_LIBRARY";

/// Shared libraries that the user allows files to load.
///
/// A library is a program, which a file from another person must not start. A library that is named on the command line is the user's decision.
///
/// ```
/// use onset_study::settings::Trust;
/// assert!(!Trust::default().covers("umat.so".as_ref()));
/// assert!(Trust::of(["umat.so".into()]).covers("./umat.so".as_ref()));
/// assert!(Trust::of(["laws".into()]).covers("laws/umat.so".as_ref()));
/// ```
#[derive(Clone, Debug, Default)]
pub struct Trust {
    places: Vec<PathBuf>,
}

impl Trust {
    /// Allows some libraries, and all libraries in some folders.
    pub fn of(places: impl IntoIterator<Item = PathBuf>) -> Self {
        Self {
            places: places.into_iter().map(|place| resolved(&place)).collect(),
        }
    }

    /// Allows the libraries of the variable [`TRUST_VARIABLE`], and some more.
    pub fn of_user(named: &[PathBuf]) -> Self {
        let always = std::env::var_os(TRUST_VARIABLE).unwrap_or_default();
        let always: Vec<PathBuf> = std::env::split_paths(&always)
            .filter(|place| !place.as_os_str().is_empty())
            .collect();
        Self::of(always.into_iter().chain(named.iter().cloned()))
    }

    /// Returns true if a library may be loaded. Links are resolved.
    pub fn covers(&self, library: &Path) -> bool {
        self.admitted(library).is_some()
    }

    /// Resolved path of a library that may be loaded. Loading from this path is safe even if links change afterwards.
    pub(crate) fn admitted(&self, library: &Path) -> Option<PathBuf> {
        // If nothing is allowed, the file system is not accessed.
        if self.places.is_empty() {
            return None;
        }
        let library = resolved(library);
        let is_covered = self.places.iter().any(|place| library.starts_with(place));
        is_covered.then_some(library)
    }
}

/// A path with links resolved, or at least without `.` if the file does not exist.
fn resolved(path: &Path) -> PathBuf {
    let absolute = || std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    std::fs::canonicalize(path).unwrap_or_else(|_| absolute())
}
