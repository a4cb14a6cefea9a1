//! `onset plot`: figures of stored maps.

use super::boundary::Counter;
use super::{Failure, wrote};
use crate::arguments::PlotArguments;
use crate::printing::print;
use onset_study::csv::of_files;
use onset_study::output::picture;
use onset_study::plot::{Drawn, Lines, Look, Plot, Unfinished, plot_allowing as draw};
use serde::Serialize;
use std::path::PathBuf;
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
    let output = arguments.drawing.output(Some(&arguments.out), "map", &[])?;
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
            x: arguments.x_limits,
            y: arguments.y_limits,
            range: arguments.limits,
            color_map: arguments.color_map,
        },
    };
    let made = draw(&asked, &arguments.trust.trust(), &counter);
    counter.finish();
    let Drawn {
        figure,
        unfinished,
        has_edges,
    } = made.map_err(|error| match error.is_input() {
        true => Failure::input(error),
        false => Failure::machine(error),
    })?;
    let files = match output {
        Some(output) => output.write(&vec![picture("map", figure)])?,
        None => Vec::new(),
    };
    let mut text = wrote(&files);
    for own in &unfinished {
        let store = own.store.display();
        text +=
            &format!("\nnote: {store}: {own}\n  hint: onset map STUDY.toml --out STORE --resume");
    }
    if has_edges {
        text += "\nnote: the boundaries are the edges of the map's cells\n  hint: --trace follows them, without a time limit";
    }
    let document = Document { files, unfinished };
    print(&document, &text, || of_files(&document.files))
}
