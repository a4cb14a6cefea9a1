//! Completion of the command line in shells: commands, options, and the words of their values.
//!
//! The script of a shell calls this program with the typed words. Candidates come from the tables that also check the arguments.

use crate::arguments::LATERALS;
use crate::fail_on;
use clap::{Arg, Command};
use clap_complete::engine::{ArgValueCompleter, CompletionCandidate, complete};
use clap_complete::env::{CompleteEnv, Elvish, EnvCompleter, Fish, Powershell, Shells, Zsh};
use onset_study::audit::Convention;
use onset_study::catalog;
use onset_study::criteria::{Criterion, Lateral, Mode};
use onset_study::figure::{ColorMap, Theme};
use onset_study::fit::{Tests, families};
use onset_study::input;
use onset_study::limit::Integrator;
use onset_study::localization::{self, PARAMETERS};
use onset_study::map;
use onset_study::screen::Cause;
use onset_study::settings::{
    COMPARISON_KEYS, Key, Kind, MapSettings, Program, materials_of, preset_names, study_keys,
};
use onset_study::simulate::Stepper;
use onset_study::verify::{CODES, Stepping};
use onset_study::zoo;
use std::ffi::{OsStr, OsString};
use std::io::{Result, Write};
use std::path::Path;

/// Environment variable that names the shell in which a line is completed.
const VARIABLE: &str = "ONSET_COMPLETE";

/// The shells with a completion.
const SHELLS: &[&dyn EnvCompleter] = &[&Bash, &Elvish, &Fish, &Powershell, &Zsh];

/// Answers a request of a shell for completions and exits; returns without such a request.
pub fn answer(command: fn() -> Command) {
    let with_words = move || with_words(command());
    CompleteEnv::with_factory(with_words)
        .var(VARIABLE)
        .shells(Shells(SHELLS))
        .complete();
}

/// Script that registers the completion in a shell.
pub fn script(shell: &str) -> Result<Vec<u8>> {
    let mut script = Vec::new();
    match SHELLS.iter().find(|own| own.is(shell)) {
        Some(own) => own.write_registration(VARIABLE, "onset", "onset", "onset", &mut script)?,
        None => return Err(std::io::Error::other(format!("no completion for {shell}"))),
    }
    Ok(script)
}

/// Candidates with their meanings, for a typed text.
type Words = fn(&str) -> Vec<(String, String)>;

/// Command with the words of its options and arguments.
fn with_words(command: Command) -> Command {
    let name = command.get_name().to_owned();
    command
        .mut_args(|own: Arg| match words(&name, own.get_id().as_str()) {
            Some(words) => own.add(ArgValueCompleter::new(move |typed: &OsStr| {
                typed
                    .to_str()
                    .map_or_else(Vec::new, |typed| candidates(words, typed))
            })),
            None => own,
        })
        .mut_subcommands(with_words)
}

/// Candidates that begin with the typed text.
fn candidates(words: Words, typed: &str) -> Vec<CompletionCandidate> {
    let own = words(typed).into_iter();
    let own = own.filter(|(word, _)| word.starts_with(typed));
    own.map(|(word, meaning)| {
        let help = (!meaning.is_empty()).then(|| meaning.into());
        CompletionCandidate::new(word).help(help)
    })
    .collect()
}

/// Words of an argument of a command; `None` for other values, and for files.
fn words(command: &str, argument: &str) -> Option<Words> {
    Some(match (command, argument) {
        ("map" | "boundary", "assignments") => |typed| assignments(study_keys(), typed),
        ("compare" | "recommend", "assignments") => {
            |typed| assignments(of_problem("").chain(COMPARISON_KEYS), typed)
        }
        ("localize", "assignments") => plastic_assignments,
        ("criteria" | "card" | "audit", "assignments") => {
            |typed| assignments(of_problem("material"), typed)
        }
        (_, "assignments") => |typed| assignments(of_problem(""), typed),
        ("compare", "variations") => variations,
        ("limit", "vary") => |_| keys(of_problem("").filter(|key| key.unit().is_some())),
        ("tune", "key") => {
            |_| keys(of_problem("discretization").filter(|key| key.unit().is_some()))
        }
        ("path" | "criteria" | "card", "mode" | "modes") => |_| plain(Mode::ALL.map(Mode::name)),
        (_, "lateral") => |_| plain(LATERALS.map(Lateral::name)),
        ("path", "from") => return None,
        (_, "from" | "read_as") => |_| plain(Program::ALL.map(Program::name)),
        ("fit", "material") => return None,
        (_, "material") => |_| plain(materials().iter().map(String::as_str)),
        (_, "preset") => |_| plain(preset_names()),
        ("list", "topic") => topics,
        ("list", "name") => |_| methods(),
        ("zoo", "name") => |_| {
            let reports = zoo::reports().into_iter();
            reports.map(|report| (report.name, report.title)).collect()
        },
        ("deck", "code") => |_| plain(CODES.map(|code| code.name())),
        (_, "stepping") => |_| plain(Stepping::ALL.map(Stepping::name)),
        ("limit", "integrator") => |_| plain(Integrator::NAMES),
        ("simulate", "integrator") => |_| plain(Stepper::names()),
        ("audit", "convention") => |_| plain(Convention::ALL.map(Convention::name)),
        ("plot", "field") => |_| {
            plain(
                map::fields(&MapSettings::default())
                    .iter()
                    .map(|field| field.name),
            )
        },
        (_, "theme") => |_| plain(Theme::ALL.map(Theme::name)),
        ("criteria", "drawn") => |typed| after_commas(typed, Criterion::ALL.map(Criterion::name)),
        ("plot", "color_map") => |_| plain(ColorMap::ALL.map(ColorMap::name)),
        ("screen", "fail_on") => |_| plain(Cause::ALL.map(Cause::name)),
        ("fit", "law") => |_| {
            let all = families(&["all".to_owned()], &mut Tests::default()).unwrap_or_default();
            plain(all.iter().map(|family| family.name()))
        },
        ("fit", _) => return None,
        (_, "fail_on") => |typed| after_commas(typed, fail_on::names()),
        ("localize", "model" | "path" | "load") => return plastic_words(argument),
        _ => return None,
    })
}

fn plain<'a>(names: impl IntoIterator<Item = &'a str>) -> Vec<(String, String)> {
    let names = names.into_iter();
    names.map(|name| (name.to_owned(), String::new())).collect()
}

/// Keys of a section of a problem; of both sections for an empty name.
fn of_problem(section: &'static str) -> impl Iterator<Item = &'static Key> {
    study_keys().filter(move |key| {
        let own = key.parts().0;
        matches!(own, "material" | "discretization") && (section.is_empty() || own == section)
    })
}

fn keys(keys: impl Iterator<Item = &'static Key>) -> Vec<(String, String)> {
    keys.map(|key| (key.name.to_owned(), key.meaning.to_owned()))
        .collect()
}

/// Keys with an equals sign, or the values of the key that was typed before the equals sign.
fn assignments(keys: impl Iterator<Item = &'static Key>, typed: &str) -> Vec<(String, String)> {
    match typed.split_once('=') {
        Some((name, _)) => values(name),
        None => keys
            .map(|key| (format!("{}=", key.name), key.meaning.to_owned()))
            .collect(),
    }
}

/// Assignments of each word that a key accepts.
fn values(name: &str) -> Vec<(String, String)> {
    let Some(key) = Key::named(name) else {
        return Vec::new();
    };
    let words = of_kind(key.kind);
    let word = |word: &&str| (format!("{name}={word}"), String::new());
    words.iter().map(word).collect()
}

fn of_kind(kind: Kind) -> &'static [&'static str] {
    match kind {
        Kind::Words(words) | Kind::WordsOr(words, _) | Kind::Subset(words) => words,
        Kind::Switch => &["true", "false"],
        _ => &[],
    }
}

/// Keys of a method that can be varied, or the words of the key typed after the last comma.
fn variations(typed: &str) -> Vec<(String, String)> {
    match typed.split_once('=') {
        Some((name, list)) => {
            let words = Key::named(name).map_or(&[] as &[&str], |key| of_kind(key.kind));
            let all = after_commas(list, words.iter().copied()).into_iter();
            all.map(|(word, meaning)| (format!("{name}={word}"), meaning))
                .collect()
        }
        None => assignments(of_problem("discretization"), typed),
    }
}

/// Words after the last comma of a list.
fn after_commas<'a>(
    typed: &str,
    words: impl IntoIterator<Item = &'a str>,
) -> Vec<(String, String)> {
    let before = typed.rfind(',').map_or("", |at| &typed[..=at]);
    let words = words.into_iter();
    words
        .map(|word| (format!("{before}{word}"), String::new()))
        .collect()
}

fn plastic_assignments(typed: &str) -> Vec<(String, String)> {
    let mut all = assignments(of_problem("material"), typed);
    match typed.split_once('=') {
        Some((name, _)) => {
            let words = plastic_words_of(name).into_iter();
            all.extend(words.map(|(word, meaning)| (format!("{name}={word}"), meaning)));
        }
        None => {
            let own = PARAMETERS.iter();
            all.extend(own.map(|own| (format!("{}=", own.name), own.meaning.to_owned())));
        }
    }
    all
}

/// Words of a key of the path of `onset localize`.
fn plastic_words_of(name: &str) -> Vec<(String, String)> {
    let mut own = PARAMETERS.iter().filter(|own| own.name == name);
    let words = own.next().map_or(&[] as &[&str], |own| of_kind(own.kind));
    plain(words.iter().copied())
}

/// Words of `--model`, `--path` or `--load` of `onset localize`.
fn plastic_words(argument: &str) -> Option<Words> {
    Some(match argument {
        "model" => |_| plain(localization::models()),
        "path" => |_| plastic_words_of("plasticity.path"),
        _ => |_| plastic_words_of("plasticity.load"),
    })
}

/// Materials of the decks in the typed line.
fn materials() -> Vec<String> {
    // The typed line follows `--` and begins with the name of this program.
    let typed = std::env::args_os().skip_while(|word| word != "--").skip(2);
    let texts = typed.filter_map(|word| input::text(Path::new(&word), input::MOST_TEXT).ok());
    let decks = texts.filter_map(|text| Some((Program::of_deck(&text)?, text)));
    decks
        .flat_map(|(program, text)| materials_of(program, &text))
        .filter(|name| !name.is_empty())
        .collect()
}

fn topics(_: &str) -> Vec<(String, String)> {
    let topics = catalog::topics();
    plain(
        topics
            .iter()
            .map(|topic| topic.name)
            .chain(["keys", "method"]),
    )
}

fn methods() -> Vec<(String, String)> {
    let topics = catalog::topics();
    let own = topics.iter().find(|topic| topic.name == "methods");
    let entries = own.into_iter().flat_map(|topic| &topic.entries);
    entries
        .map(|entry| (entry.name.to_owned(), String::new()))
        .collect()
}

/// Bash, which splits words at equals signs.
struct Bash;

/// Completion function of bash: joins the words that bash splits at equals signs, and removes the part before the last equals sign from the
/// candidates.
const BASH: &str = r#"_onset() {
    local word words=() n=0
    for word in "${COMP_WORDS[@]:0:COMP_CWORD+1}"; do
        if ((n > 0)) && [[ $word == =* || ${words[n-1]} == *= ]]; then
            words[n-1]+=$word
        else
            words[n++]=$word
        fi
    done
    local IFS=$'\n' typed=${words[n-1]}
    COMPREPLY=($(VARIABLE=bash "COMPLETER" -- "${words[@]}"))
    if [[ $typed == *=* && $COMP_WORDBREAKS == *=* ]]; then
        COMPREPLY=("${COMPREPLY[@]#"${typed%=*}="}")
    fi
    if [[ ${#COMPREPLY[@]} == 1 && ${COMPREPLY[0]} == *[=/] ]]; then
        compopt -o nospace
    fi
}
complete -o bashdefault -F _onset BIN
"#;

impl EnvCompleter for Bash {
    fn name(&self) -> &'static str {
        "bash"
    }

    fn is(&self, name: &str) -> bool {
        name == "bash"
    }

    fn write_registration(
        &self,
        variable: &str,
        _: &str,
        bin: &str,
        completer: &str,
        buffer: &mut dyn Write,
    ) -> Result<()> {
        let script = BASH.replace("VARIABLE", variable).replace("BIN", bin);
        buffer.write_all(script.replace("COMPLETER", completer).as_bytes())
    }

    fn write_complete(
        &self,
        command: &mut Command,
        words: Vec<OsString>,
        folder: Option<&Path>,
        buffer: &mut dyn Write,
    ) -> Result<()> {
        let last = words.len().saturating_sub(1);
        for candidate in complete(command, words, last, folder)? {
            writeln!(buffer, "{}", candidate.get_value().to_string_lossy())?;
        }
        Ok(())
    }
}
