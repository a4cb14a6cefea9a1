//! `onset plot`: figures of stored maps.

use super::boundary::Counter;
use super::{Failure, wrote};
use crate::printing::print;
use onset_study::output::Output;
use onset_study::plot::{Plot, plot_allowing as figure};
use onset_study::settings::Trust;
use serde::Serialize;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// What is printed as JSON.
#[derive(Serialize)]
struct Drawn {
    files: Vec<PathBuf>,
}

/// Draws stores and writes the figure.
pub fn plot(
    stores: &[PathBuf],
    field: &str,
    traced: bool,
    trust: &Trust,
    out: &Path,
) -> Result<ExitCode, Failure> {
    let (folder, name) = place(out)?;
    let names = [".svg", ".png"].map(|format| {
        let mut name = name.clone();
        name.push(format);
        name
    });
    let output = Output::at(&folder, &names)?;
    let counter = Counter::new();
    let asked = Plot {
        stores,
        field,
        traced,
    };
    let made = figure(&asked, trust, &counter);
    counter.finish();
    let made = made.map_err(|error| match error.is_input() {
        true => Failure::input(error),
        false => Failure::machine(error),
    })?;
    let files = output.write(&made.files(&name).map_err(Failure::machine)?)?;
    let text = wrote(&files);
    print(&Drawn { files }, &text, None)
}

/// The folder and the name of a figure: those of a file NAME.svg or NAME.png, or `map` in a folder.
fn place(out: &Path) -> Result<(PathBuf, OsString), Failure> {
    let extension = out.extension().and_then(|extension| extension.to_str());
    match (extension, out.file_stem()) {
        (Some("svg" | "png"), Some(stem)) => {
            let folder = out.parent().filter(|folder| !folder.as_os_str().is_empty());
            let folder = folder.unwrap_or(Path::new("."));
            Ok((folder.to_owned(), stem.to_owned()))
        }
        (Some("pdf" | "eps" | "ps" | "jpg" | "jpeg" | "tif" | "tiff" | "gif" | "webp"), _) => {
            Err(Failure::input(format!(
                "cannot draw {}: figures are written as SVG and PNG\n  hint: give a name that ends in .svg or .png; \
                 most programs turn SVG into PDF without loss",
                out.display()
            )))
        }
        _ => Ok((out.to_owned(), "map".into())),
    }
}
