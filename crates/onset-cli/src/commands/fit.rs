//! `onset fit`: laws fitted to test data, stable in the range where they are used.

use super::{Failure, wrote};
use crate::arguments::FitArguments;
use crate::fail_on;
use crate::patience::{self, bar};
use crate::printing::{is_quiet, print, tell};
use onset_study::fit::{
    FitAnswer, FittingError, Mode, Options, Reading, Source, Tests, criteria, families, fitted,
    weights,
};
use std::io::IsTerminal;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Time between two messages on the progress in captured output.
const QUIET_TIME: Duration = Duration::from_secs(2);

impl From<FittingError> for Failure {
    fn from(error: FittingError) -> Self {
        match error {
            FittingError::Output(error) => Self::machine(error),
            error => Self::input(error),
        }
    }
}

/// Fits the laws and prints them in the order of their errors.
pub fn fit(arguments: &FitArguments) -> Result<ExitCode, Failure> {
    let named = [
        (&arguments.uniaxial, Mode::Uniaxial),
        (&arguments.equibiaxial, Mode::Equibiaxial),
        (&arguments.planar, Mode::Planar),
        (&arguments.simple_shear, Mode::SimpleShear),
        (&arguments.volumetric, Mode::Volumetric),
    ];
    let named = named.into_iter().flat_map(|(files, mode)| {
        files
            .iter()
            .map(move |file| Source::File(file.clone(), Some(mode)))
    });
    let files: Vec<_> = arguments
        .files
        .iter()
        .map(|file| Source::File(file.clone(), None))
        .chain(named)
        .collect();
    if files.is_empty() {
        return Err(Failure::input(
            "no table of a test is given\n  hint: for example onset fit uniaxial.csv planar.csv, or --uniaxial FILE",
        ));
    }
    let reading = Reading {
        unit: arguments.unit.clone(),
        area: arguments.area,
        range: arguments.range,
        material: arguments.material.clone(),
        weights: arguments.weight.clone(),
    };
    if arguments.fail_on.is_some() && arguments.stable.0.is_none() {
        return Err(Failure::input(
            "--fail-on unstable needs a range, but --stable is none\n  hint: give a range, for example --stable data",
        ));
    }
    for (n, (name, value)) in arguments.fix.iter().enumerate() {
        let mut before = arguments.fix[..n].iter();
        if let Some((_, other)) = before.find(|own| own.0 == *name && own.1 != *value) {
            return Err(Failure::input(format!(
                "--fix gives {name} two values: {other} and {value}\n  hint: give one value for each constant"
            )));
        }
    }
    let mut tests = Tests::read(&files, &reading).map_err(FittingError::Table)?;
    let families = families(&arguments.law, &mut tests)?;
    let place = arguments.out.as_deref();
    let output = arguments
        .drawing
        .output(place, "fit", &FitAnswer::names())?;
    let options = Options {
        weights: weights(&arguments.weights, arguments.floor)?,
        range: arguments.stable.0,
        criteria: criteria(&arguments.criterion)?,
        margin: arguments.margin,
        starts: usize::from(arguments.starts),
        fixed: arguments.fix.clone(),
        bounds: arguments.bound.clone(),
    };
    patience::end();
    let progress = bar(families.len() as u64, "{bar:32} law {pos} of {len}: {msg}");
    let mut last = Instant::now();
    let mut count = 0;
    let is_captured = !std::io::stderr().is_terminal() && !is_quiet();
    let answer = fitted(tests, &families, &options, arguments.bulk, &mut |law| {
        count += 1;
        if is_captured && last.elapsed() > QUIET_TIME {
            last = Instant::now();
            tell(format_args!(
                "law {count} of {}: {law} (Ctrl-C ends the fit)",
                families.len()
            ));
        }
        progress.inc(1);
        progress.set_message(law.to_owned());
    });
    progress.finish_and_clear();
    let answer = match answer {
        Err(FittingError::NotStable(reasons)) if arguments.fail_on.is_some() => {
            tell(format_args!(
                "{reasons}\nfails by --fail-on: no fitted law is stable in the range (exit code {})",
                fail_on::CODE
            ));
            return Ok(ExitCode::from(fail_on::CODE));
        }
        answer => answer?,
    };
    let text = arguments.detail.text(&answer);
    let shown = match output {
        Some(output) => {
            let written = output.write(&answer.files()?)?;
            let missing = answer.missing_blocks().filter(|_| written.len() > 1);
            let missing = missing.map_or(String::new(), |own| format!("\n{own}"));
            format!("{text}\n\n{}{missing}", wrote(&written))
        }
        None => text,
    };
    print(&answer, &shown, || answer.csv())
}
