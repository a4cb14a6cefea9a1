//! Output of answers as text, JSON or CSV, in color if the terminal supports it, or suppressed.

use crate::commands::Failure;
use crate::patience;
use clap::{Args, ValueEnum};
use onset_study::json;
use onset_umat::{message, readable};
use serde::Serialize;
use std::fmt::Display;
use std::io::{ErrorKind, IsTerminal, Write};
use std::process::ExitCode;
use std::sync::OnceLock;
use std::time::Instant;

/// Format of an answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Text with six significant digits.
    #[default]
    Text,
    /// One JSON document, numbers with the digits that read back exactly.
    Json,
    /// Table of the answer, numbers with the digits that read back exactly.
    Csv,
}

/// Use of colors in the output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum When {
    /// Colors on a terminal, unless `NO_COLOR` is set.
    #[default]
    Auto,
    /// Colors in every output, also in files and pipes.
    Always,
    /// Output of plain text without colors.
    Never,
}

/// Options for the output of answers.
#[derive(Clone, Copy, Debug, Default, Args)]
pub struct PrintingArguments {
    /// Form of the answer: text, json (all digits) or csv (a table, all digits).
    #[arg(
        long,
        value_enum,
        value_name = "FORMAT",
        global = true,
        hide_possible_values = true,
        help_heading = "Printing"
    )]
    pub format: Option<Format>,
    /// Short for --format json.
    #[arg(
        long,
        global = true,
        conflicts_with = "format",
        help_heading = "Printing"
    )]
    pub json: bool,
    /// Print only errors and requested JSON or CSV; show no progress.
    #[arg(
        long,
        global = true,
        conflicts_with = "verbose",
        help_heading = "Printing"
    )]
    pub quiet: bool,
    /// Print version, threads and time on standard error.
    #[arg(long, global = true, help_heading = "Printing")]
    pub verbose: bool,
    /// Color the output: auto, always or never.
    #[arg(
        long,
        value_enum,
        value_name = "WHEN",
        default_value = "auto",
        global = true,
        hide_possible_values = true,
        hide_default_value = true,
        help_heading = "Printing"
    )]
    pub color: When,
}

/// Printing arguments and the start time.
static REQUEST: OnceLock<(PrintingArguments, Instant)> = OnceLock::new();

/// Sets the printing arguments, once per process.
pub fn begin(asked: PrintingArguments) {
    let _ = REQUEST.set((asked, Instant::now()));
}

/// Prints the elapsed time if requested.
pub fn end() {
    if let Some((asked, since)) = REQUEST.get()
        && asked.verbose
    {
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        tell(format_args!(
            "onset {}, {threads} cores, {:.3} s",
            env!("CARGO_PKG_VERSION"),
            since.elapsed().as_secs_f64()
        ));
    }
}

fn asked() -> PrintingArguments {
    REQUEST.get().map(|(asked, _)| *asked).unwrap_or_default()
}

/// Returns true if only errors are printed.
pub fn is_quiet() -> bool {
    asked().quiet
}

/// Form of the answer.
pub fn format() -> Format {
    let asked = asked();
    match asked.json {
        true => Format::Json,
        false => asked.format.unwrap_or_default(),
    }
}

/// Refuses formats other than text before any computation.
///
/// # Errors
/// [`Failure`] that describes the output of the command.
pub fn only_text(what: &str) -> Result<(), Failure> {
    match format() {
        Format::Text => Ok(()),
        Format::Json | Format::Csv => Err(Failure::input(format!(
            "this command prints {what} in a single format\n  hint: omit --format and --json"
        ))),
    }
}

/// Prints an answer in the requested form: text, JSON document or CSV table.
///
/// # Errors
/// [`Failure`] if it cannot be printed.
pub fn print<T: Serialize>(
    document: &T,
    text: &str,
    csv: impl FnOnce() -> String,
) -> Result<ExitCode, Failure> {
    match format() {
        Format::Text if is_quiet() => Ok(ExitCode::SUCCESS),
        Format::Text => print_text(text),
        Format::Json => print_text(&json::document(document).map_err(Failure::machine)?),
        Format::Csv => print_text(csv().trim_end()),
    }
}

/// Prints a text; a closed pipe (`| head`) is not an error.
///
/// # Errors
/// [`Failure`] if it cannot be printed.
pub fn print_text(text: &str) -> Result<ExitCode, Failure> {
    patience::end();
    let stdout = std::io::stdout();
    let text = readable(text);
    let is_colored = format() == Format::Text && has_color(stdout.is_terminal());
    let text = if is_colored {
        painted(&text)
    } else {
        text.to_string()
    };
    match writeln!(stdout.lock(), "{text}") {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::machine(format!(
            "cannot print the answer: {error}"
        ))),
        _ => Ok(ExitCode::SUCCESS),
    }
}

/// Prints a message on standard error; a closed pipe is ignored.
pub fn tell(text: impl Display) {
    patience::end();
    let stderr = std::io::stderr();
    // Text from files must not contain control sequences for the terminal.
    let text = message(&text.to_string());
    let text = if has_color(stderr.is_terminal()) {
        painted(&text)
    } else {
        text
    };
    let _ = writeln!(stderr.lock(), "{text}");
}

fn has_color(is_terminal: bool) -> bool {
    let is_set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    let is_dumb = || std::env::var_os("TERM").is_some_and(|term| term == "dumb");
    match asked().color {
        When::Always => true,
        When::Never => false,
        When::Auto => is_terminal && !is_set("NO_COLOR") && !is_dumb(),
    }
}

const RED: &str = "31";
const GREEN: &str = "32";
const YELLOW: &str = "33";
const CYAN: &str = "36";

/// Beginnings of colored lines.
const COLORED_BEGINNINGS: [(&str, &str); 5] = [
    ("error:", RED),
    ("  hint:", CYAN),
    ("note:", YELLOW),
    ("  note:", YELLOW),
    ("warning:", YELLOW),
];

/// Colors a text by the beginnings of its lines, and the verdict.
fn painted(text: &str) -> String {
    let line = |line: &str| {
        let begins = COLORED_BEGINNINGS
            .iter()
            .find(|(start, _)| line.starts_with(start));
        if let Some((start, color)) = begins {
            let rest = &line[start.len()..];
            return format!("\x1b[{color}m{start}\x1b[0m{rest}");
        }
        let verdict = line.strip_prefix("verdict ").map(str::trim_start);
        match verdict.and_then(|word| Some((word, color_of(word)?))) {
            Some((word, color)) => {
                let start = &line[..line.len() - word.len()];
                format!("{start}\x1b[1;{color}m{word}\x1b[0m")
            }
            None => line.to_owned(),
        }
    };
    text.split('\n').map(line).collect::<Vec<_>>().join("\n")
}

/// Color of a verdict: green for stable, yellow for physical instability, red for numerical defects.
fn color_of(verdict: &str) -> Option<&'static str> {
    use onset_study::Verdict;
    let verdict = Verdict::ALL
        .into_iter()
        .find(|known| known.name() == verdict)?;
    Some(match verdict {
        Verdict::Stable => GREEN,
        Verdict::Physical => YELLOW,
        Verdict::ZeroEnergy | Verdict::Numerical | Verdict::Suppressed => RED,
    })
}

#[cfg(test)]
mod tests {
    use super::painted;

    #[test]
    fn lines_are_colored_by_their_kind() {
        for (line, expected) in [
            ("error: no", "\x1b[31merror:\x1b[0m no"),
            ("  hint: this", "\x1b[36m  hint:\x1b[0m this"),
            (
                "verdict      stable",
                "verdict      \x1b[1;32mstable\x1b[0m",
            ),
            ("material     hint: no", "material     hint: no"),
        ] {
            assert_eq!(painted(line), expected);
        }
        assert_eq!(painted("a\nb"), "a\nb");
    }
}
