//! Which programs a file may have run.

use std::path::{Path, PathBuf};

/// The variable with libraries, or folders of them, that files may always load; separated as in `PATH`.
pub const TRUST_VARIABLE: &str = "ONSET_ALLOW_LIBRARY";

/// The shared libraries that the user allows files to load. A library is a program, which a file that came from somebody else must
/// not start; one that is named on the command line itself is the user's own word.
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
    /// Some libraries, and all in some folders.
    pub fn of(places: impl IntoIterator<Item = PathBuf>) -> Self {
        Self {
            places: places.into_iter().map(|place| resolved(&place)).collect(),
        }
    }

    /// What the variable [`TRUST_VARIABLE`] names, and some more.
    pub fn of_user(named: &[PathBuf]) -> Self {
        let always = std::env::var_os(TRUST_VARIABLE).unwrap_or_default();
        let always: Vec<PathBuf> = std::env::split_paths(&always)
            .filter(|place| !place.as_os_str().is_empty())
            .collect();
        Self::of(always.into_iter().chain(named.iter().cloned()))
    }

    /// Whether a library may be loaded. Links count as what they lead to.
    pub fn covers(&self, library: &Path) -> bool {
        self.admitted(library).is_some()
    }

    /// The place without links of a library that may be loaded: to be loaded from there, wherever links lead by then.
    pub(crate) fn admitted(&self, library: &Path) -> Option<PathBuf> {
        // Without anything allowed no file is asked for.
        if self.places.is_empty() {
            return None;
        }
        let library = resolved(library);
        let is_covered = self.places.iter().any(|place| library.starts_with(place));
        is_covered.then_some(library)
    }
}

/// A path without links; where nothing is, without `.` at least.
fn resolved(path: &Path) -> PathBuf {
    let absolute = || std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    std::fs::canonicalize(path).unwrap_or_else(|_| absolute())
}
