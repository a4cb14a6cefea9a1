//! Libraries compiled from Fortran or C sources, shared by the tests of several crates.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Variable that names the Fortran compiler; `gfortran` by default.
const COMPILER: &str = "ONSET_FORTRAN";

/// Library compiled from sources of this crate; it is recompiled if a source or the compiler is newer.
///
/// Fails the test if there is no compiler: a test that cannot run has not passed.
pub fn library(sources: &[&str]) -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR")).join("../onset-umat");
    let name: String = sources
        .iter()
        .filter_map(|source| Path::new(source).file_stem()?.to_str())
        .collect::<Vec<_>>()
        .join("-");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let library = folder.join(format!("{name}.so"));
    let modified = |path: &Path| path.metadata().and_then(|data| data.modified()).ok();
    let sources: Vec<PathBuf> = sources.iter().map(|source| package.join(source)).collect();
    let newest = sources.iter().filter_map(|source| modified(source)).max();
    if modified(&library).is_some_and(|made| Some(made) > newest) {
        return library;
    }
    // Tests run in parallel: each writes a separate file and renames it.
    let own = folder.join(format!(
        "{name}-{}-{:?}",
        std::process::id(),
        std::thread::current().id()
    ));
    std::fs::create_dir_all(&own).expect("a folder");
    let made = own.join("library.so");
    let compiler = std::env::var_os(COMPILER).unwrap_or_else(|| "gfortran".into());
    let output = Command::new(&compiler)
        .args(["-shared", "-fPIC", "-O2", "-I"])
        .arg(package.join("include"))
        .arg("-o")
        .arg(&made)
        .arg("-J")
        .arg(&own)
        .args(&sources)
        .output();
    match output {
        Ok(output) => assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        ),
        Err(error) => panic!(
            "no Fortran compiler ({}: {error}); `cargo xtask test` installs gfortran where it can, or let {COMPILER} name one",
            compiler.display()
        ),
    }
    std::fs::rename(&made, &library).expect("the library is moved");
    std::fs::remove_dir_all(&own).expect("the folder is removed");
    library
}
