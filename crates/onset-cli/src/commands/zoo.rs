//! `onset zoo`: instabilities that users of particle codes reported.

use super::{Failure, with_files};
use crate::arguments::ZooArguments;
use crate::printing::print;
use onset_study::output::{Output, text};
use onset_study::zoo::{Zoo, report};
use std::path::Path;
use std::process::ExitCode;

/// Lists the reports, or answers one.
pub fn zoo(arguments: &ZooArguments) -> Result<ExitCode, Failure> {
    let Some(name) = &arguments.name else {
        let all = Zoo::default();
        return print(&all, &all.to_string(), || all.csv());
    };
    let report = report(name).map_err(Failure::input)?;
    let written = match &arguments.out {
        Some(file) => {
            let file_name = file.file_name().ok_or_else(|| {
                Failure::input(format!(
                    "--out is `{}`; expected the name of a file, for example {name}.toml",
                    file.display()
                ))
            })?;
            let folder = file.parent().filter(|own| !own.as_os_str().is_empty());
            let output = Output::at(folder.unwrap_or(Path::new(".")), &[file_name])?;
            output.write(&vec![text(file_name, report.study())])?
        }
        None => Vec::new(),
    };
    let answer = report.answer()?;
    print(&answer, &with_files(&answer, &written), || answer.csv())
}
