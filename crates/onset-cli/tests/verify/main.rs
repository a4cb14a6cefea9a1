//! `onset verify`: results for runs that are correct, wrong, noisy, truncated, or of another study.
//!
//! `motion` tests `onset simulate`, and `bodies` tests it with bodies. `made` answers decks with synthetic particles and needs no installed code.
//! `lammps` and `pysph` run the codes themselves, if the variables ONSET_LAMMPS and ONSET_PYSPH name the program and the interpreter; `cargo xtask
//! test` and `cargo xtask verify --all` install them. `screened` screens runs of these codes and of `onset simulate` whose cause is known.

mod bodies;
mod lammps;
mod made;
mod motion;
mod pysph;
mod refusals;
mod screened;
mod zoo;

#[path = "../../../onset/tests/shared/hunt.rs"]
mod hunt;

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Folder of a test, removed when it ends.
struct Place(PathBuf);

impl Place {
    fn new() -> Self {
        static COUNT: AtomicUsize = AtomicUsize::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let name = format!("onset-verify-{}-{number}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&folder).expect("a folder");
        Self(folder)
    }

    fn path(&self) -> &Path {
        &self.0
    }

    fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.0.join(name)).expect("a file of the deck")
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.0.join(name), text).expect("written");
    }

    /// Case file of the deck.
    fn case(&self) -> Value {
        serde_json::from_str(&self.read("case.json")).expect("a document")
    }

    /// Changes a file of the deck; the change must have an effect.
    fn edit(&self, name: &str, change: impl Fn(&str) -> String) {
        let (before, after) = (self.read(name), change(&self.read(name)));
        assert_ne!(before, after, "{name} has not changed");
        self.write(name, &after);
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Result of a command.
struct Answer {
    code: Option<i32>,
    stdout: String,
    stderr: String,
}

impl Answer {
    fn of(mut command: Command) -> Self {
        let output = command.output().expect("the command starts");
        Self {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).expect("UTF-8"),
            stderr: String::from_utf8(output.stderr).expect("UTF-8"),
        }
    }

    fn document(&self) -> Value {
        serde_json::from_str(&self.stdout).unwrap_or_else(|_| panic!("{}", self.stderr))
    }

    fn number(&self, name: &str) -> f64 {
        self.document()[name].as_f64().expect("a number")
    }
}

/// `onset verify` with arguments separated by blanks, and further arguments.
fn verify(line: &str, others: &[&str]) -> Answer {
    let mut command = Command::new(env!("CARGO_BIN_EXE_onset"));
    command
        .arg("verify")
        .args(line.split_whitespace())
        .args(others);
    Answer::of(command)
}

/// Files of a folder with their contents.
fn tree(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let mut files: Vec<(String, Vec<u8>)> = entries
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.is_file())
        .map(|path| {
            let name = path.file_name().expect("a name").to_string_lossy();
            (name.into_owned(), std::fs::read(&path).expect("a file"))
        })
        .collect();
    files.sort();
    files
}

fn text(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

/// Deck in a separate folder.
fn deck(line: &str) -> Place {
    let place = Place::new();
    let answer = verify(&format!("deck {line}"), &["--out", text(place.path())]);
    assert_eq!(answer.code, Some(0), "{line}: {}", answer.stderr);
    place
}

/// Result for an output of a deck.
fn read(place: &Place, output: &str) -> Answer {
    verify("read --json", &[text(&place.path().join(output))])
}

/// Runs a deck.
fn run(place: &Place, program: &Path) -> Answer {
    verify(
        "run --json",
        &[text(place.path()), "--program", text(program)],
    )
}

/// Program named by a variable; without it, `None` with a message about the skipped tests.
fn program(variable: &str, what: &str) -> Option<PathBuf> {
    let named = std::env::var_os(variable).map(PathBuf::from);
    if named.is_none() {
        eprintln!("note: NOT TESTED: {what}. {variable} names no program");
    }
    named
}
