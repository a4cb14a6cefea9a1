//! Help: an overview on one screen, shell completions, and manual pages.

use crate::arguments::Arguments;
use crate::commands::{Failure, wrote};
use crate::complete;
use crate::printing::{only_text, print, print_text};
use clap::error::ErrorKind;
use clap::{ColorChoice, Command, CommandFactory, FromArgMatches};
use clap_complete::Shell;
use onset_study::csv::of_files;
use onset_study::output::{Output, text};
use onset_study::settings::renamed_command;
use onset_umat::message;
use std::ffi::OsString;
use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

/// Commands in groups by topic, the most common first; the short overview lists the last group on a single line.
const GROUPS: [(&str, &[&str]); 5] = [
    (
        "A state, a path, a run",
        &[
            "state",
            #[cfg(feature = "explore")]
            "explore",
            "path",
            "dispersion",
            "modes",
            "simulate",
            "screen",
        ],
    ),
    (
        "A method",
        &["recommend", "compare", "tune", "limit", "verify"],
    ),
    ("A law", &["fit", "criteria", "card", "audit", "localize"]),
    ("A study", &["check", "map", "plot", "boundary"]),
    (
        "Help and more",
        &[
            "list",
            "zoo",
            "schema",
            "umat-utilities",
            "law-header",
            "completions",
            "man",
            "reproduce",
        ],
    ),
];

const EXAMPLES: &str = "Examples:
  onset state --stretch 1.15,1 --set discretization.method=tlsph
  onset path --mode uniaxial --to 3 --set material.model=ogden
  onset recommend --set material.model=blatz-ko --stretches 0.8,1.6";

const MORE: &str = "Exit codes: 0 done; 1 a strict audit has findings, a claim of the paper is not as recorded, a particle code or a motion differs, or a file
cannot be written; 2 the input is wrong; 3 a verdict is one of --fail-on, or whether a code or a motion agrees is undecided; 130 interrupted.
What can be set: `onset list keys`, `onset list method NAME`, `onset list materials`, `onset list aliases`.";

/// Command-line definition with the overview.
pub fn command(is_long: bool) -> Command {
    let command = Arguments::command();
    let about = |name: &str| {
        let known = command.find_subcommand(name).and_then(Command::get_about);
        known.map_or_else(String::new, ToString::to_string)
    };
    let mut overview = String::new();
    for (n, (title, names)) in GROUPS.iter().enumerate() {
        overview.push_str(&format!("{title}:\n"));
        let has_lines = is_long || n + 1 < GROUPS.len();
        for name in names.iter().filter(|_| has_lines) {
            let about = about(name);
            overview.push_str(&format!("  {name:<15} {}\n", about.trim_end_matches('.')));
        }
        if !has_lines {
            overview.push_str(&format!("  {}\n", names.join(", ")));
        }
    }
    let (options, end) = match is_long {
        true => ("\n{options}\n", format!("{EXAMPLES}\n\n{MORE}")),
        false => (
            "\n",
            format!(
                "{EXAMPLES}\n\n`onset COMMAND -h` explains a command, `onset --help` lists the options of all commands."
            ),
        ),
    };
    let template =
        format!("{{about}}\n\n{{usage-heading}} {{usage}}\n\n{overview}{options}{end}\n");
    command.help_template(template)
}

/// Parses the command line; exits after help or an invalid argument.
pub fn parse() -> Arguments {
    complete::answer(|| command(false));
    let typed = words();
    let is_long = typed
        .get(1)
        .is_some_and(|first| first == "--help" || first == "help");
    let command = command(is_long).color(color(&typed));
    let matches = command.try_get_matches_from(typed);
    let parsed = matches.and_then(|matches| Arguments::from_arg_matches(&matches));
    parsed.unwrap_or_else(|error| refuse(&error))
}

/// Prints help, or an error that may repeat arguments of any length and content, and exits.
fn refuse(error: &clap::Error) -> ! {
    let whole = error.render().to_string();
    let told = message(&whole);
    let is_help = error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand;
    if is_help || !error.use_stderr() || told == whole {
        error.exit();
    }
    let _ = writeln!(std::io::stderr(), "{}", told.trim_end());
    std::process::exit(error.exit_code())
}

/// Words of the command line, with a former name of a command replaced by its current name.
fn words() -> Vec<OsString> {
    let mut words: Vec<OsString> = std::env::args_os().collect();
    if let Some(command) = words.get_mut(1)
        && let Some(now) = command.to_str().and_then(renamed_command)
    {
        *command = now.into();
    }
    words
}

/// Color choice for help and argument errors: `--color`, or otherwise the terminal's capability.
fn color(typed: &[OsString]) -> ColorChoice {
    let typed: Vec<&str> = typed.iter().filter_map(|word| word.to_str()).collect();
    let of_pair = typed
        .windows(2)
        .find(|pair| pair[0] == "--color")
        .map(|pair| pair[1]);
    let said = of_pair.or_else(|| typed.iter().find_map(|word| word.strip_prefix("--color=")));
    match said {
        Some("always") => ColorChoice::Always,
        Some("never") => ColorChoice::Never,
        _ => ColorChoice::Auto,
    }
}

/// Prints the completion script of a shell.
pub fn completions(shell: Shell) -> Result<ExitCode, Failure> {
    only_text("a script for a shell")?;
    let script = complete::script(&shell.to_string()).map_err(Failure::machine)?;
    print_text(String::from_utf8_lossy(&script).trim_end())
}

/// Writes the manual pages.
pub fn manual(out: &Path) -> Result<ExitCode, Failure> {
    let mut command = Arguments::command();
    command.build();
    let page = |command: &Command, name: String| {
        let mut page = Vec::new();
        let manual = clap_mangen::Man::new(command.clone());
        manual.render(&mut page).map_err(Failure::machine)?;
        Ok::<_, Failure>(text(format!("{name}.1"), page))
    };
    let mut pages = vec![page(&command, "onset".to_owned())?];
    for own in command
        .get_subcommands()
        .filter(|own| own.get_name() != "help")
    {
        pages.push(page(own, format!("onset-{}", own.get_name()))?);
    }
    let names: Vec<OsString> = pages.iter().map(|(name, _)| name.clone()).collect();
    let files = Output::at(out, &names)?.write(&pages)?;
    let told = wrote(&files);
    print(&files, &told, || of_files(&files))
}

#[cfg(test)]
mod tests {
    use super::{GROUPS, command};
    use std::collections::BTreeSet;

    #[test]
    fn every_command_is_in_the_overview_once() {
        let listed = GROUPS.iter().flat_map(|(_, names)| names.iter());
        let listed: Vec<&str> = listed.copied().collect();
        let once: BTreeSet<&str> = listed.iter().copied().collect();
        assert_eq!(once.len(), listed.len());
        let command = command(true);
        let known: BTreeSet<&str> = command
            .get_subcommands()
            .map(|own| own.get_name())
            .filter(|name| *name != "help")
            .collect();
        assert_eq!(once, known);
    }

    #[test]
    fn the_short_overview_fits_on_a_screen() {
        let text = command(false).render_help().to_string();
        assert!(text.lines().count() <= 38, "{text}");
        assert!(
            text.lines().all(|line| line.chars().count() <= 110),
            "{text}"
        );
        assert_eq!(text.matches("\n  onset ").count(), 3);
        // Every command is listed in the overview.
        let words: BTreeSet<&str> = text
            .split(|letter: char| letter.is_whitespace() || letter == ',')
            .collect();
        for name in GROUPS.iter().flat_map(|(_, names)| names.iter()) {
            assert!(words.contains(name), "{name}: {text}");
        }
    }
}
