//! `onset plot`: figures of stored maps.

use super::boundary::Counter;
use super::{Failure, print_text};
use onset_study::plot::{Plot, plot as figure};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Draws stores and writes the figure.
pub fn plot(
    stores: &[PathBuf],
    field: &str,
    traced: bool,
    out: &Path,
) -> Result<ExitCode, Failure> {
    let counter = Counter::new();
    let asked = Plot {
        stores,
        field,
        traced,
    };
    let made = figure(&asked, &counter);
    counter.finish();
    let made = made.map_err(|error| match error.is_input() {
        true => Failure::input(error),
        false => Failure::machine(error),
    })?;
    let (folder, name) = place(out);
    let files = made.write(&folder, &name).map_err(Failure::machine)?;
    let [first, second] = files.map(|file| file.display().to_string());
    print_text(&format!("wrote {first} and {second}"))
}

/// The folder and the name of a figure: those of a file NAME.svg or NAME.png, or `map` in a folder.
fn place(out: &Path) -> (PathBuf, String) {
    let is_picture = out
        .extension()
        .is_some_and(|extension| extension == "svg" || extension == "png");
    match out.file_stem().filter(|_| is_picture) {
        Some(stem) => {
            let folder = out.parent().filter(|folder| !folder.as_os_str().is_empty());
            let folder = folder.unwrap_or(Path::new("."));
            (folder.to_owned(), stem.to_string_lossy().into_owned())
        }
        None => (out.to_owned(), "map".to_owned()),
    }
}
