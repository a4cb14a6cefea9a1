//! Answers and refusals of the command run in a separate process.

mod aliases;
mod audit;
mod blocks;
mod bodies;
mod boundary;
mod certify;
mod check;
mod compare;
#[cfg(unix)]
mod completion;
mod criteria;
#[cfg(target_os = "linux")]
mod damaged_stores;
mod documents;
mod drawing;
#[cfg(feature = "explore")]
mod explore;
mod files;
mod fit;
mod formula;
mod grid;
mod help;
#[path = "../../../onset/tests/shared/hunt.rs"]
mod hunt;
mod integrators;
#[cfg(target_os = "linux")]
mod kill_points;
mod limit;
mod loading_paths;
mod localize;
mod map;
mod map_python;
mod map_refusals;
#[cfg(unix)]
mod map_survival;
mod metals;
mod methods;
mod modes;
mod numbers;
mod plane_stress;
mod plot;
mod printing;
#[cfg(unix)]
mod readme;
mod refusals;
mod relaxation;
mod renamed;
mod screen;
mod settings;
mod softening;
mod space;
#[cfg(target_os = "linux")]
mod terminal;
mod thresholds;
mod tune;
#[cfg(unix)]
mod umat;
mod units;
mod zoo;

#[cfg(unix)]
#[path = "../../../onset-umat/tests/routines/fortran.rs"]
mod fortran;

use serde_json::Value;
use std::ffi::OsStr;
use std::fmt;
use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Random numbers, reproducible for a given seed.
struct Random(u64);

impl Random {
    fn new(seed: u64) -> Self {
        // No seed becomes zero, and neighboring seeds are far apart.
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    /// Random whole number below `end`.
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 11) as usize) % end.max(1)
    }
}

/// Result of a command.
struct Answer {
    code: Option<i32>,
    stdout: String,
    stderr: String,
}

fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_onset"));
    command.args(arguments);
    command
}

fn onset(arguments: &[&str]) -> Answer {
    let Output {
        status,
        stdout,
        stderr,
    } = command(arguments).output().expect("the command starts");
    Answer {
        code: status.code(),
        stdout: String::from_utf8(stdout).expect("UTF-8"),
        stderr: String::from_utf8(stderr).expect("UTF-8"),
    }
}

/// Arguments of `line`, separated by spaces; `set a=b` abbreviates `--set discretization.a=b`.
fn words(line: &str) -> Vec<String> {
    let mut words = Vec::new();
    let mut items = line.split_whitespace();
    while let Some(item) = items.next() {
        if item == "set" {
            words.push("--set".to_owned());
            words.push(format!(
                "discretization.{}",
                items.next().expect("an assignment")
            ));
        } else {
            words.push(item.to_owned());
        }
    }
    words
}

/// Commands that print a short answer without `--all`.
const IN_SHORT: [&str; 10] = [
    "state",
    "path",
    "modes",
    "criteria",
    "card",
    "localize",
    "notions",
    "compare",
    "recommend",
    "tune",
];

/// Answer to a line, in full.
fn onset_line(line: &str) -> Answer {
    let mut words = words(line);
    let is_short = words
        .iter()
        .any(|word| ["--all", "--settings"].contains(&word.as_str()));
    if IN_SHORT.contains(&words[0].as_str()) && !is_short {
        words.insert(1, "--all".to_owned());
    }
    onset(&words.iter().map(String::as_str).collect::<Vec<_>>())
}

/// Output of `line --json`: exactly one document, and nothing else.
fn document(line: &str) -> Value {
    let answer = onset_line(&format!("{line} --json"));
    assert_eq!(answer.code, Some(0), "{line}: {}", answer.stderr);
    assert_eq!(answer.stderr, "", "{line}");
    serde_json::from_str(&answer.stdout).expect("one JSON document")
}

/// Number at a JSON pointer.
fn number(document: &Value, pointer: &str) -> f64 {
    document
        .pointer(pointer)
        .and_then(Value::as_f64)
        .unwrap_or_else(|| panic!("no number at {pointer}"))
}

fn numbers(document: &Value, pointer: &str) -> Vec<f64> {
    let list = document.pointer(pointer).and_then(Value::as_array);
    list.unwrap_or_else(|| panic!("no list at {pointer}"))
        .iter()
        .map(|value| value.as_f64().expect("a number"))
        .collect()
}

#[track_caller]
fn assert_close(computed: f64, expected: f64, relative: f64) {
    assert!(
        (computed - expected).abs() <= relative * expected.abs(),
        "{computed} is not {expected}"
    );
}

/// Unique path for files of one test, initially unused and finally removed.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        static COUNT: AtomicUsize = AtomicUsize::new(0);
        loop {
            let count = COUNT.fetch_add(1, Ordering::Relaxed);
            let place = format!("onset-{}-{count}-{name}", std::process::id());
            let place = std::env::temp_dir().join(place);
            // A killed process with the same number may have left such a folder: numbers repeat within minutes if many processes are started.
            if !place.exists() {
                return Self(place);
            }
        }
    }
}

impl Deref for Scratch {
    type Target = PathBuf;

    fn deref(&self) -> &PathBuf {
        &self.0
    }
}

impl AsRef<Path> for Scratch {
    fn as_ref(&self) -> &Path {
        &self.0
    }
}

impl AsRef<OsStr> for Scratch {
    fn as_ref(&self) -> &OsStr {
        self.0.as_os_str()
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // The test may not have created the path, or may have removed it.
        let _ = match self.0.is_dir() {
            true => std::fs::remove_dir_all(&self.0),
            false => std::fs::remove_file(&self.0),
        };
    }
}

/// File with a name and a text, for one test.
struct Written(Scratch);

impl Written {
    fn new(name: &str, text: impl AsRef<[u8]>) -> Self {
        let place = Scratch::new(name);
        std::fs::write(&place, text).expect("a file");
        Self(place)
    }
}

impl Deref for Written {
    type Target = str;

    fn deref(&self) -> &str {
        self.0.to_str().expect("UTF-8")
    }
}

impl fmt::Display for Written {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self)
    }
}
