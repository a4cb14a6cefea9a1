//! A command line as a process with little memory and time, in a folder of its own; and what can be wrong with how it ended.

use serde_json::Value;
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus};
use std::time::{Duration, Instant};

/// Seconds of processor time, without all optimization.
const SECONDS: u64 = 30;
/// Seconds after which a command that shows that it works is interrupted.
const ENOUGH: u64 = 10;
/// Seconds after which a process that needs no processor time waits for something that never comes.
const WAITING: Duration = Duration::from_secs(300);
/// Commands that ask thousands of states, or try method after method, and show that they work: where these take longer than [`ENOUGH`] they are
/// interrupted, and must end at once.
const LONG: [&str; 5] = ["path", "boundary", "tune", "recommend", "compare"];
/// Exit code of a command that was interrupted.
const INTERRUPTED: i32 = 130;
/// Kibibytes of address space: a gibibyte, and what threads and the program itself reserve.
const KIBIBYTES: u64 = 1_310_720;
/// Blocks of 512 bytes that a file may have.
const BLOCKS: u64 = 200_000;

/// A command line, with what is on its standard input.
#[derive(Clone, Debug, Default)]
pub struct Line {
    pub words: Vec<String>,
    pub input: String,
}

impl Line {
    /// Of words with blanks between them.
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

/// To be typed again in a shell.
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

/// How a command ended.
pub struct Ending {
    pub status: ExitStatus,
    /// Whether it took long, and was asked to end.
    is_interrupted: bool,
    pub stdout: Vec<u8>,
    pub stderr: String,
    pub elapsed: Duration,
    /// What it left in its folder.
    left: BTreeSet<String>,
}

/// A place where commands run one after the other: each in a folder `here` with a study in it, beside stores that are there for all.
pub struct Place(PathBuf);

/// A study of four states.
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
    /// A place with a name that is used for nothing else.
    pub fn new(name: &str) -> Self {
        let place = Path::new(env!("CARGO_TARGET_TMPDIR"))
            .join(format!("fuzzed-{}-{name}", std::process::id()));
        fs::create_dir_all(&place).expect("a folder");
        Self(place)
    }

    /// Makes stores of the study, whole and half done, to be read.
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

    /// Runs a command within the limits of the operating system.
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

    /// The document that a command prints.
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

/// Words of which a refusal has one: what was expected, or what to do.
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

/// Letters that a terminal may obey.
fn commands_a_terminal(text: &str) -> bool {
    text.chars()
        .any(|letter| letter.is_control() && !"\n\t".contains(letter))
}

impl Ending {
    /// What is wrong with how a command ended.
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
        // The tiles of a map that are done are kept.
        let is_map = line.has("map");
        if code != 0 && !is_map && !self.left.is_empty() {
            return Some(format!("refused, with {:?} written", self.left));
        }
        let is_help = ["help", "--version", "-V", "--help", "-h"]
            .iter()
            .any(|word| line.has(word));
        // After two dashes nothing is an option.
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
