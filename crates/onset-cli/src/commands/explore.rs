//! `onset explore`, and `onset state --open`: the page.

use super::Failure;
use crate::arguments::{ExploreArguments, ProblemArguments, StrainArguments};
use crate::explore::{Link, serve};
use crate::printing;
use onset_study::explore::{Question, Stored};
use onset_study::settings::{Trust, Value};
use std::path::Path;
use std::process::ExitCode;

/// Serves the page for a study, a stored map or a problem.
pub fn explore(arguments: &ExploreArguments) -> Result<ExitCode, Failure> {
    printing::only_text("the address of the page")?;
    let trust = arguments.problem.given.trust.trust();
    let port = arguments.port;
    let is_shown = !arguments.no_browser;
    if let Some(map) = arguments
        .problem
        .given
        .file
        .as_deref()
        .filter(|file| file.is_dir())
    {
        if !is_plain(&arguments.problem) {
            return Err(Failure::input(
                "a stored map contains its settings\n  hint: omit --set, --energy and --from",
            ));
        }
        let stored = Stored::open(map).map_err(|error| match error.is_input() {
            true => Failure::input(error),
            false => Failure::machine(error),
        })?;
        stored.question().map_err(Failure::input)?;
        return serve(&Link::Stored, port, is_shown, trust, Some(stored));
    }
    let link = first(&arguments.problem)?;
    serve(&link, port, is_shown, trust, None)
}

/// Returns true if only a study is given.
fn is_plain(problem: &ProblemArguments) -> bool {
    let set = &problem.given.set;
    let is_unset = set.assignments.is_empty() && set.energy.is_none() && set.preset.is_none();
    is_unset && problem.block.from.is_none()
}

/// Initial content: a study with its window, or the assignments.
fn first(problem: &ProblemArguments) -> Result<Link, Failure> {
    let is_plain = is_plain(problem);
    if let Some(link) = problem.given.file.as_deref().and_then(address) {
        return match is_plain {
            true => link.map_err(Failure::input),
            false => Err(Failure::input(
                "the address contains the settings\n  hint: omit --set and --energy, and change them in the page",
            )),
        };
    }
    match (&problem.given.file, is_plain) {
        (None, true) => Ok(Link::Nothing),
        (Some(_), true) => {
            let read = problem.read()?;
            // The page requests the library of the study, and the server refuses it unless the user allows it.
            let question = match read.is_deck {
                true => Question::of_settings(&read.settings(&[], &Trust::default())?),
                false => Question::of_text(&read.text).map_err(Failure::input)?,
            };
            Ok(Link::Question(Box::new(question)))
        }
        (_, false) => {
            let question = Question::of_settings(&problem.settings()?);
            Ok(Link::Question(Box::new(question)))
        }
    }
}

/// Content of a page address given instead of a file; `None` for a file.
fn address(file: &Path) -> Option<Result<Link, String>> {
    file.to_str().and_then(Link::of_address)
}

/// Serves the page at a state.
pub fn at_state(problem: &ProblemArguments, strain: &StrainArguments) -> Result<ExitCode, Failure> {
    printing::only_text("the address of the page")?;
    let settings = problem.settings()?;
    let mut question = Question::of_settings(&settings);
    question.stretch = strain.stretch.clone().unwrap_or_default();
    // A library given on the command line itself is trusted.
    let mut trust = problem.given.trust.clone();
    if let Some(Value::Word(library)) = settings.material.given("library") {
        trust.libraries.push(library.into());
    }
    let link = Link::Question(Box::new(question));
    serve(&link, None, true, trust.trust(), None)
}
