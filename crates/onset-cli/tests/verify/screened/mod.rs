//! Causes that `onset screen` finds in runs whose cause follows from their construction.
//!
//! Each module runs one code and counts the true and the detected causes. The page of the book includes these counts; `ONSET_SCREEN_TABLE` names a
//! file in which the rows of a code are replaced.

mod lammps;
mod made;
mod pysph;

use crate::{Answer, Place, text};
use serde_json::Value;
use std::path::Path;
use std::process::Command;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Causes of `onset screen`, in the order of the table.
const CAUSES: [&str; 6] = [
    "none",
    "forced",
    "numerical",
    "time-step",
    "zero-energy",
    "physical",
];

/// Table that a page of the book includes.
const TABLE: &str = "book/src/how-to/screen-table.md";
const HEAD: &str = "| runs of | true cause | none | forced | numerical | time step | zero-energy | physical |\n|---|---|---|---|---|---|---|---|\n";

/// Settings as arguments: `model=...` of the law, then keys of the discretization.
fn sets(law: &str, method: &str) -> Vec<String> {
    let of = |section: &'static str, words: &str| {
        let words = words.split_whitespace();
        let sets = words.flat_map(|set| ["--set".to_owned(), format!("{section}.{set}")]);
        sets.collect::<Vec<_>>()
    };
    [of("material", law), of("discretization", method)].concat()
}

fn onset(command: &str, arguments: &[String]) -> Answer {
    let mut onset = Command::new(env!("CARGO_BIN_EXE_onset"));
    onset.arg(command).args(arguments);
    Answer::of(onset)
}

/// Answer of `onset screen` to a file of a folder.
fn screened(place: &Place, file: &str, sets: &[String], line: &str) -> Value {
    let mut arguments = vec![text(&place.path().join(file)).to_owned()];
    arguments.extend(line.split_whitespace().map(str::to_owned));
    arguments.extend_from_slice(sets);
    arguments.push("--json".to_owned());
    let answer = onset("screen", &arguments);
    assert_eq!(answer.code, Some(0), "{arguments:?}: {}", answer.stderr);
    answer.document()
}

/// Result of a run: its name, its true cause, and the answer.
struct Found {
    name: String,
    cause: &'static str,
    answer: Value,
}

impl Found {
    fn told(&self) -> &str {
        self.answer["cause"].as_str().expect("a cause")
    }

    fn is_right(&self) -> bool {
        self.told() == self.cause
    }
}

/// Applies a function to all items, two at a time, and returns the results in the order of the items.
fn in_pairs<T: Sync, R: Send>(items: &[T], function: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let next = AtomicUsize::new(0);
    let results = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some((number, item)) = {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    items.get(number).map(|item| (number, item))
                } {
                    let result = function(item);
                    results.lock().expect("results").push((number, result));
                }
            });
        }
    });
    let mut results = results.into_inner().expect("results");
    results.sort_by_key(|(number, _)| *number);
    results.into_iter().map(|(_, result)| result).collect()
}

/// Rows of the table: how often each cause was found for each true cause.
fn rows(code: &str, found: &[Found]) -> String {
    let row = |cause: &&str| {
        let own = || found.iter().filter(|run| run.cause == *cause);
        let count = |told: &str| own().filter(|run| run.told() == told).count();
        let numbers = CAUSES.map(|told| match count(told) {
            0 => String::new(),
            count => count.to_string(),
        });
        let row = format!("| {code} | {cause} | {} |\n", numbers.join(" | "));
        (own().count() > 0).then_some(row)
    };
    CAUSES.iter().filter_map(row).collect()
}

/// Requires that nine of ten causes are right, that no healthy run raises a false alarm, and that the table of the book has these counts.
fn check(code: &str, found: &[Found]) {
    let rows = rows(code, found);
    let told = |run: &Found| format!("{}: {}\n", run.name, run.answer["sentence"]);
    let wrong: String = found
        .iter()
        .filter(|run| !run.is_right())
        .map(told)
        .collect();
    let told = format!("{HEAD}{rows}\n{wrong}");
    eprintln!("{told}");
    let right = found.iter().filter(|run| run.is_right()).count();
    assert!(10 * right >= 9 * found.len(), "{told}");
    let is_alarm = |run: &Found| run.cause == "none" && !run.is_right();
    assert!(!found.iter().any(is_alarm), "{told}");
    let page = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .join(TABLE);
    let text = std::fs::read_to_string(&page).unwrap_or_default();
    let of = |line: &&str| line.starts_with(&format!("| {code} |"));
    let lines = || text.lines().skip(2);
    match std::env::var_os("ONSET_SCREEN_TABLE") {
        Some(file) => {
            let others = lines().filter(|line| !of(line));
            let mut all: Vec<String> = others.map(str::to_owned).collect();
            all.extend(rows.lines().map(str::to_owned));
            all.sort_by_key(|line| line.split('|').nth(1).map(str::to_owned));
            std::fs::write(file, format!("{HEAD}{}\n", all.join("\n"))).expect("written");
        }
        None => {
            let own: String = lines().filter(of).map(|line| format!("{line}\n")).collect();
            assert_eq!(own, rows, "{TABLE} has other counts");
        }
    }
}
