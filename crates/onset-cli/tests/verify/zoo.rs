//! Zoo of reported instabilities, with their verdicts.

use super::{deck, program, run};
use std::path::PathBuf;
use std::process::Command;

/// Entry of the zoo.
struct Entry {
    name: String,
    table: toml::Table,
}

impl Entry {
    fn text(&self, key: &str) -> &str {
        let value = self.table.get(key).and_then(toml::Value::as_str);
        value.unwrap_or_else(|| panic!("{}: `{key}` is no text", self.name))
    }

    fn words(&self, key: &str) -> Option<Vec<&str>> {
        let words = self.table.get(key)?.as_array().expect("a list");
        Some(
            words
                .iter()
                .map(|word| word.as_str().expect("a text"))
                .collect(),
        )
    }

    /// Answer of `onset state`.
    fn state(&self, key: &str) -> Option<serde_json::Value> {
        Some(self.document(["state", "--json"], self.words(key)?))
    }

    /// Answer of `onset limit` for the entry.
    fn limit(&self) -> Option<serde_json::Value> {
        let words = [self.words("limit")?, self.words("question")?].concat();
        Some(self.document(["limit", "--json"], words))
    }

    fn document(&self, command: [&str; 2], words: Vec<&str>) -> serde_json::Value {
        let output = Command::new(env!("CARGO_BIN_EXE_onset"))
            .args(command)
            .args(words)
            .output()
            .expect("the command starts");
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{}: {told}", self.name);
        serde_json::from_slice(&output.stdout).expect("a document")
    }
}

fn zoo() -> Vec<Entry> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../zoo");
    let files = std::fs::read_dir(folder)
        .expect("the zoo")
        .map(|file| file.expect("a file").path());
    let mut files: Vec<PathBuf> = files
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "toml")
        })
        .collect();
    files.sort();
    let entry = |path: PathBuf| Entry {
        name: path.display().to_string(),
        table: std::fs::read_to_string(&path)
            .expect("a text")
            .parse()
            .expect("a table"),
    };
    files.into_iter().map(entry).collect()
}

#[test]
fn each_entry_of_the_zoo_has_the_recorded_verdict_and_remedy() {
    let zoo = zoo();
    assert!(zoo.len() >= 15, "{} entries", zoo.len());
    let known = [
        "confirmed by a run",
        "linear theory only",
        "cause elsewhere",
    ];
    for entry in &zoo {
        assert!(
            entry.text("where").starts_with("https://"),
            "{}",
            entry.name
        );
        for key in ["title", "seen", "assumed", "remedy"] {
            assert!(!entry.text(key).is_empty(), "{}: {key}", entry.name);
        }
        let status = entry.text("status");
        assert!(known.contains(&status), "{}: {status}", entry.name);
        assert_eq!(
            status == known[0],
            entry.words("verify").is_some(),
            "{}",
            entry.name
        );
        let answer = entry.state("question").expect("a question");
        assert_eq!(answer["verdict"], entry.text("verdict"), "{}", entry.name);
        if let Some(step) = entry.table.get("time-step") {
            let critical = answer["discretization"]["critical_time_step"].as_f64();
            let alone = &answer["discretization"]["discrete_time"]["isolated_point_time_step"];
            let least = critical
                .expect("a number")
                .min(alone.as_f64().unwrap_or(f64::INFINITY));
            let taken = step.as_float().expect("a number");
            assert!(least < taken, "{}: {least}", entry.name);
        }
        if let Some(answer) = entry.limit() {
            let found = answer["admitted"][0]["to"]["value"].as_f64();
            let known = entry.table["limit-value"].as_float().expect("a number");
            let ratio = found.expect("a number") / known;
            assert!((ratio - 1.0).abs() < 0.02, "{}: {ratio}", entry.name);
        }
        if let Some(cured) = entry.state("remedy-question") {
            assert_eq!(
                cured["verdict"],
                entry.text("remedy-verdict"),
                "{}",
                entry.name
            );
        }
    }
}

#[test]
fn confirmed_entries_of_the_zoo_agree_with_a_run() {
    let Some(lammps) = program("ONSET_LAMMPS", "the confirmed entries of the zoo") else {
        return;
    };
    let zoo = zoo();
    let confirmed: Vec<&Entry> = zoo
        .iter()
        .filter(|entry| entry.words("verify").is_some())
        .collect();
    assert!(confirmed.len() >= 5, "{} are confirmed", confirmed.len());
    for entry in confirmed {
        let words = entry.words("verify").expect("a deck");
        let answer = run(&deck(&words.join(" ")), &lammps);
        assert_eq!(
            answer.code,
            Some(0),
            "{}: {}{}",
            entry.name,
            answer.stdout,
            answer.stderr
        );
    }
}
