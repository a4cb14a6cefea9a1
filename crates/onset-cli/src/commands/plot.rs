//! `onset plot`: figures of stored maps.

use super::boundary::Counter;
use super::{Failure, wrote};
use crate::arguments::PlotArguments;
use crate::printing::print;
use onset_study::output::Output;
use onset_study::plot::{Drawn, Lines, Look, Plot, Unfinished, plot_allowing as draw};
use serde::Serialize;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Document printed as JSON.
#[derive(Serialize)]
struct Document {
    files: Vec<PathBuf>,
    /// Stores with tiles that are still to be computed.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    unfinished: Vec<Unfinished>,
}

/// Draws stores and writes the figure.
pub fn plot(arguments: &PlotArguments) -> Result<ExitCode, Failure> {
    let (folder, name) = place(&arguments.out)?;
    let with = |format: &str| {
        let mut name = name.clone();
        name.push(format);
        name
    };
    let is_pdf = arguments
        .out
        .extension()
        .is_some_and(|extension| extension == "pdf");
    let pdf = is_pdf.then(|| with(".pdf"));
    let names = [with(".svg"), with(".png")].into_iter().chain(pdf.clone());
    let output = Output::at(&folder, &names.collect::<Vec<_>>())?;
    let counter = Counter::new();
    let asked = Plot {
        stores: &arguments.stores,
        field: &arguments.field,
        boundaries: match (arguments.trace, arguments.no_trace) {
            (true, _) => Lines::Traced,
            (_, true) => Lines::OfCells,
            _ => Lines::Best,
        },
        look: Look {
            title: arguments.title.as_deref(),
            size: arguments.size,
            x: arguments.x_limits,
            y: arguments.y_limits,
            range: arguments.limits,
            color_map: arguments.color_map,
        },
    };
    let made = draw(&asked, &arguments.trust.trust(), &counter);
    counter.finish();
    let Drawn { figure, unfinished } = made.map_err(|error| match error.is_input() {
        true => Failure::input(error),
        false => Failure::machine(error),
    })?;
    let mut made = figure.files(&name).map_err(Failure::machine)?;
    made.extend(pdf.map(|name| (name, figure.to_pdf())));
    let files = output.write(&made)?;
    let mut text = wrote(&files);
    for own in &unfinished {
        let store = own.store.display();
        text +=
            &format!("\nnote: {store}: {own}\n  hint: onset map STUDY.toml --out STORE --resume");
    }
    print(&Document { files, unfinished }, &text, None)
}

/// Folder and base name of a figure, from NAME.svg, NAME.png or NAME.pdf, or `map` in a folder.
fn place(out: &Path) -> Result<(PathBuf, OsString), Failure> {
    let extension = out.extension().and_then(|extension| extension.to_str());
    match (extension, out.file_stem()) {
        (Some("svg" | "png" | "pdf"), Some(stem)) => {
            let folder = out.parent().filter(|folder| !folder.as_os_str().is_empty());
            let folder = folder.unwrap_or(Path::new("."));
            Ok((folder.to_owned(), stem.to_owned()))
        }
        (Some("eps" | "ps" | "jpg" | "jpeg" | "tif" | "tiff" | "gif" | "webp"), _) => {
            Err(Failure::input(format!(
                "cannot draw {}: figures are written as SVG, PNG and PDF\n  hint: give a name that ends in .svg, .png or .pdf",
                out.display()
            )))
        }
        _ => Ok((out.to_owned(), "map".into())),
    }
}
