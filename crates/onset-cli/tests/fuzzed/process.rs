//! Process with limited memory and time in a separate folder, and checks of its exit.

use serde_json::Value;
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus};
use std::time::{Duration, Instant};

/// Limit of processor time without full optimization; seconds.
const SECONDS: u64 = 30;
/// Time after which a command with a progress display is interrupted; seconds.
const ENOUGH: u64 = 10;
/// Time after which a process without processor time is considered blocked.
const WAITING: Duration = Duration::from_secs(300);
/// Commands that compute thousands of states, or many methods, with a progress display: after [`ENOUGH`] seconds they are interrupted, and must end
/// immediately.
const LONG: [&str; 5] = ["path", "boundary", "tune", "recommend", "compare"];
/// Exit code of an interrupted command.
const INTERRUPTED: i32 = 130;
/// Limit of the address space in kibibytes: one gibibyte, plus the reservations of threads and the program.
const KIBIBYTES: u64 = 1_310_720;
/// Limit of the size of a file, in blocks of 512 bytes.
const BLOCKS: u64 = 200_000;

/// Command line with its standard input.
#[derive(Clone, Debug, Default)]
pub struct Line {
    pub words: Vec<String>,
    pub input: String,
}

impl Line {
    /// Line of words separated by blanks.
    pub fn of(words: &str) -> Self {
        Self {
            words: words.split_whitespace().map(str::to_owned).collect(),
            input: String::new(),
        }
    }

    fn has(&self, word: &str) -> bool {
        self.words.iter().any(|own| own == word)
    }
}

/// Prints the line for use in a shell.
impl std::fmt::Display for Line {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let words: Vec<String> = self.words.iter().map(|word| format!("{word:?}")).collect();
        write!(f, "onset {}", words.join(" "))?;
        if !self.input.is_empty() {
            write!(f, " <<'END'\n{}\nEND", self.input)?;
        }
        Ok(())
    }
}

/// Result of a command.
pub struct Ending {
    pub status: ExitStatus,
    /// Whether it was interrupted because it took long.
    is_interrupted: bool,
    pub stdout: Vec<u8>,
    pub stderr: String,
    pub elapsed: Duration,
    /// Files left in its folder.
    left: BTreeSet<String>,
}

/// Folder in which commands run sequentially: each in a subfolder `here` with a study, next to common stores.
pub struct Place(PathBuf);

/// Study of four states.
pub const STUDY: &str = "\
[discretization]
support = 1.6
[[axes]]
quantity = 'stretch-1'
range = [0.8, 1.6]
states = 2
[[axes]]
quantity = 'stretch-2'
range = [0.8, 1.6]
states = 2
";

impl Place {
    /// Place with a unique name.
    pub fn new(name: &str) -> Self {
        let place = Path::new(env!("CARGO_TARGET_TMPDIR"))
            .join(format!("fuzzed-{}-{name}", std::process::id()));
        fs::create_dir_all(&place).expect("a folder");
        Self(place)
    }

    /// Creates stores of the study, complete and incomplete, which the commands read.
    pub fn with_stores(self) -> Self {
        let wide = STUDY.replacen("states = 2", "states = 9", 1);
        for (line, input) in [
            ("map - --quiet --out ../whole.zarr", STUDY),
            (
                "map - --quiet --out ../half.zarr --set map.tile=8 --tiles 0..1",
                &wide,
            ),
        ] {
            let line = Line {
                input: input.to_owned(),
                ..Line::of(line)
            };
            let ending = self.run(&line);
            assert!(ending.status.success(), "{}", ending.stderr);
        }
        self
    }

    /// Runs a command within limits of the operating system.
    pub fn run(&self, line: &Line) -> Ending {
        let here = self.0.join("here");
        let _ = fs::remove_dir_all(&here);
        fs::create_dir(&here).expect("a folder");
        fs::write(here.join("study.toml"), STUDY).expect("a file");
        let [input, stdout, stderr] = ["input", "stdout", "stderr"].map(|name| self.0.join(name));
        fs::write(&input, &line.input).expect("a file");
        let created = |path: &Path| File::create(path).expect("a file");
        let is_long = line
            .words
            .first()
            .is_some_and(|word| LONG.contains(&word.as_str()));
        // An interrupted command has a second to end.
        let seconds = if is_long { ENOUGH + 1 } else { SECONDS };
        let script =
            format!("ulimit -t {seconds}; ulimit -v {KIBIBYTES}; ulimit -f {BLOCKS}; exec \"$@\"");
        let begin = Instant::now();
        let mut child = Command::new("sh")
            .args(["-c", &script, "sh", env!("CARGO_BIN_EXE_onset")])
            .args(&line.words)
            .env("RAYON_NUM_THREADS", "1")
            .current_dir(&here)
            .stdin(File::open(&input).expect("a file"))
            .stdout(created(&stdout))
            .stderr(created(&stderr))
            .spawn()
            .expect("the command starts");
        let mut is_interrupted = false;
        let status = loop {
            if let Some(status) = child.try_wait().expect("a child") {
                break status;
            }
            if is_long && !is_interrupted && begin.elapsed() > Duration::from_secs(ENOUGH) {
                is_interrupted = true;
                let words = ["-TERM".to_owned(), child.id().to_string()];
                let _ = Command::new("kill").args(words).status();
            }
            if begin.elapsed() > WAITING {
                let _ = child.kill();
            }
            std::thread::sleep(Duration::from_millis(1));
        };
        let entries = fs::read_dir(&here).expect("a folder").flatten();
        Ending {
            status,
            is_interrupted,
            stdout: fs::read(&stdout).expect("a file"),
            stderr: String::from_utf8_lossy(&fs::read(&stderr).expect("a file")).into_owned(),
            elapsed: begin.elapsed(),
            left: entries
                .map(|entry| entry.file_name().to_string_lossy().into_owned())
                .filter(|name| name != "study.toml")
                .collect(),
        }
    }

    /// Document printed by a command.
    pub fn answered(&self, line: &str) -> Value {
        let ending = self.run(&Line::of(line));
        assert!(
            ending.status.success(),
            "{line}: {:?} {}",
            ending.status,
            ending.stderr
        );
        serde_json::from_slice(&ending.stdout).expect("JSON")
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Words that explain a refusal: each message must contain at least one.
const HELP: [&str; 12] = [
    "hint: ",
    "; set ",
    "expected",
    "must be",
    "admitted",
    "choose",
    "needs",
    "answer for all",
    "is answered for",
    "is not defined at",
    "Usage: onset",
    "try '--help'",
];

/// Returns true if a text contains control sequences for terminals.
fn commands_a_terminal(text: &str) -> bool {
    text.chars()
        .any(|letter| letter.is_control() && !"\n\t".contains(letter))
}

impl Ending {
    /// Reason why the result of a command is wrong, or `None`.
    pub fn fault(&self, line: &Line) -> Option<String> {
        let what = self.what_is_wrong(line)?;
        let told: String = self.stderr.chars().take(800).collect();
        Some(format!("{what}: {line}\n{told}"))
    }

    fn what_is_wrong(&self, line: &Line) -> Option<String> {
        if let Some(signal) = self.status.signal() {
            return Some(format!("ended by signal {signal}"));
        }
        let code = self.status.code().unwrap_or(-1);
        if self.is_interrupted && code == INTERRUPTED {
            return (!self.left.is_empty())
                .then(|| format!("interrupted, with {:?} written", self.left));
        }
        if !(0..=2).contains(&code) || self.stderr.contains("panicked") {
            return Some(format!("exit code {code}"));
        }
        let stdout = String::from_utf8_lossy(&self.stdout);
        if commands_a_terminal(&stdout) || commands_a_terminal(&self.stderr) {
            return Some("commands of a terminal".to_owned());
        }
        if code == 2 && !HELP.iter().any(|word| self.stderr.contains(word)) {
            return Some("refused without a hint".to_owned());
        }
        // A strict audit with findings is an answer.
        if code == 1 && self.stderr.trim().is_empty() && !line.has("--strict") {
            return Some("failed without a word".to_owned());
        }
        if let Some(name) = self.left.iter().find(|name| name.starts_with(".onset")) {
            return Some(format!("{name} is left"));
        }
        // Finished tiles of a map are kept.
        let is_map = line.has("map");
        if code != 0 && !is_map && !self.left.is_empty() {
            return Some(format!("refused, with {:?} written", self.left));
        }
        let is_help = ["help", "--version", "-V", "--help", "-h"]
            .iter()
            .any(|word| line.has(word));
        // After two dashes no argument is an option.
        let options = line.words.iter().take_while(|word| *word != "--");
        let asks_json = options.clone().any(|word| word == "--json");
        let has_printed = code == 0 || !self.stdout.is_empty();
        if has_printed && !is_help && asks_json {
            if serde_json::from_slice::<Value>(&self.stdout).is_err() {
                return Some("no JSON".to_owned());
            }
        } else if stdout
            .split_whitespace()
            .any(|word| word.trim_matches(',') == "NaN")
        {
            return Some("a number that is none".to_owned());
        }
        None
    }
}
