//! Output on a terminal during a long computation. The terminal is emulated by `script` (util-linux).

use crate::Scratch;
use std::fs;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// A computation of several minutes on any machine, without a progress bar, for cells of 64 disordered particles; and a folder for its files.
const SLOW: &str = "modes --set discretization.method=updated-sph --set discretization.lattice=simple-cubic \
     --set discretization.cells=4 --set discretization.perturbation=0.05 --out new/inner";
/// Time limit for any step on a loaded machine.
const PATIENCE: Duration = Duration::from_secs(120);
const CTRL_C: &[u8] = b"\x03";

/// Command at a separate terminal, in a separate folder.
struct Terminal {
    place: Scratch,
    child: Child,
    begin: Instant,
    shown: Receiver<Vec<u8>>,
    text: String,
}

impl Terminal {
    fn with(line: &str) -> Self {
        let place = Scratch::new("terminal");
        fs::create_dir_all(place.join("tmp")).expect("folders");
        fs::create_dir(place.join("here")).expect("a folder");
        let mut child = Command::new("script")
            .args(["--quiet", "--return", "--command", line, "/dev/null"])
            .current_dir(place.join("here"))
            .env("TMPDIR", place.join("tmp"))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("script, of util-linux");
        let mut output = child.stdout.take().expect("a pipe");
        let (sender, shown) = channel();
        std::thread::spawn(move || {
            let mut buffer = [0; 4096];
            while let Ok(count @ 1..) = output.read(&mut buffer) {
                if sender.send(buffer[..count].to_vec()).is_err() {
                    break;
                }
            }
        });
        Self {
            place,
            child,
            begin: Instant::now(),
            shown,
            text: String::new(),
        }
    }

    /// Waits until a text is shown, and returns the time since the start.
    fn wait_for(&mut self, words: &str) -> Duration {
        while !self.text.contains(words) {
            match self.shown.recv_timeout(PATIENCE) {
                Ok(bytes) => self.text.push_str(&String::from_utf8_lossy(&bytes)),
                Err(error) => panic!("{error}, but no `{words}`: {}", self.text),
            }
        }
        self.begin.elapsed()
    }

    fn press(&mut self, key: &[u8]) {
        let keyboard = self.child.stdin.as_mut().expect("a pipe");
        keyboard.write_all(key).expect("pressed");
        keyboard.flush().expect("pressed");
    }

    /// Exit code and complete output.
    fn ended(&mut self) -> (Option<i32>, String) {
        loop {
            match self.shown.recv_timeout(PATIENCE) {
                Ok(bytes) => self.text.push_str(&String::from_utf8_lossy(&bytes)),
                Err(RecvTimeoutError::Disconnected) => break,
                Err(RecvTimeoutError::Timeout) => panic!("no end: {}", self.text),
            }
        }
        let code = self.child.wait().expect("an end").code();
        (code, self.text.clone())
    }

    /// Files left in the folder of the command, and in the folder of temporary files.
    fn left(&self) -> Vec<PathBuf> {
        let all = |folder: &Path| {
            let entries = fs::read_dir(folder).expect("a folder");
            entries.map(|entry| entry.expect("one").path()).collect()
        };
        ["here", "tmp"]
            .map(|name| self.place.join(name))
            .iter()
            .flat_map(|folder| -> Vec<PathBuf> { all(folder) })
            .collect()
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn onset(line: &str) -> String {
    format!("{} {line}", env!("CARGO_BIN_EXE_onset"))
}

#[test]
fn progress_is_shown_after_two_seconds_and_ctrl_c_leaves_no_files() {
    let mut terminal = Terminal::with(&onset(SLOW));
    let shown = terminal.wait_for("Ctrl-C ends it");
    assert!(shown >= Duration::from_secs(2), "{shown:?}");
    terminal.press(CTRL_C);
    let (code, text) = terminal.ended();
    assert_eq!(code, Some(130), "{text}");
    assert!(!text.contains("panicked"), "{text}");
    assert!(terminal.left().is_empty(), "{text}");
}

#[test]
fn a_quick_answer_shows_no_progress() {
    let mut terminal = Terminal::with(&onset("list kernels"));
    let (code, text) = terminal.ended();
    assert_eq!(code, Some(0), "{text}");
    assert!(!text.contains("Ctrl-C"), "{text}");
}

#[test]
fn ctrl_c_ends_a_command_under_nohup() {
    let mut terminal = Terminal::with(&format!("nohup {}", onset(SLOW)));
    terminal.wait_for("nohup");
    // The computation has started once its folder exists.
    let folder = terminal.place.join("here/new/inner");
    while !folder.is_dir() && terminal.begin.elapsed() < PATIENCE {
        std::thread::sleep(Duration::from_millis(10));
    }
    terminal.press(CTRL_C);
    let (code, text) = terminal.ended();
    assert_eq!(code, Some(130), "{text}");
    let left = terminal.left();
    assert!(
        left.iter().all(|one| one.ends_with("nohup.out")),
        "{left:?}"
    );
}

#[test]
fn a_hangup_stays_ignored_under_nohup_and_a_termination_ends_the_command() {
    let place = Scratch::new("nohup");
    fs::create_dir_all(place.join("here")).expect("a folder");
    let mut child = Command::new("nohup")
        .arg(env!("CARGO_BIN_EXE_onset"))
        .args(SLOW.split_whitespace())
        .current_dir(place.join("here"))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("nohup");
    let begin = Instant::now();
    while !place.join("here/new/inner").is_dir() && begin.elapsed() < PATIENCE {
        std::thread::sleep(Duration::from_millis(10));
    }
    let send = |signal: &str, to: u32| {
        let sent = Command::new("kill")
            .args([signal, &to.to_string()])
            .status();
        assert!(sent.expect("kill").success(), "{signal}");
    };
    send("-HUP", child.id());
    std::thread::sleep(Duration::from_millis(500));
    assert!(child.try_wait().expect("a state").is_none(), "ended by HUP");
    send("-TERM", child.id());
    assert_eq!(child.wait().expect("an end").code(), Some(130));
}

/// Body whose step takes longer than an interrupt may, because it has many particles.
const LARGE: &str = "[material]\nmodel = \"neo-hooke\"\nmu = 1.0\nlambda = 2.0\n\
     [discretization]\nmethod = \"total-lagrangian-sph\"\nlattice = \"square\"\n\
     [body]\nshape = \"bar\"\nsize = [200, 200]\n";

#[test]
fn an_interrupt_abandons_a_long_step_of_a_run_with_checkpoints() {
    let place = Scratch::new("steps");
    fs::create_dir_all(&place).expect("a folder");
    fs::write(place.join("study.toml"), LARGE).expect("written");
    let mut child = Command::new(env!("CARGO_BIN_EXE_onset"))
        .args(
            "simulate study.toml --amplitude 1e-6 --steps 1000000 --out run --checkpoint 1"
                .split(' '),
        )
        .current_dir(place.join("."))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the command starts");
    let begin = Instant::now();
    let checkpoint = place.join("run/checkpoint.onset");
    while !checkpoint.exists() && begin.elapsed() < PATIENCE {
        std::thread::sleep(Duration::from_millis(10));
    }
    let pressed = Instant::now();
    let sent = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(sent.expect("kill").success());
    assert_eq!(child.wait().expect("an end").code(), Some(130));
    assert!(
        pressed.elapsed() < Duration::from_secs(2),
        "{:?}",
        pressed.elapsed()
    );
    assert!(checkpoint.exists(), "the last checkpoint is lost");
}

/// Under any limit of address space a command answers, or ends with a message; it neither panics nor aborts.
#[test]
#[cfg(target_os = "linux")]
fn a_limit_of_address_space_causes_no_panic_and_no_abort() {
    let place = Scratch::new("address-space");
    fs::create_dir(&*place).expect("a folder");
    let body = "[discretization]\nmethod = \"total-lagrangian-sph\"\nlattice = \"square\"\n[body]\nshape = \"bar\"\nsize = [3000, 3000]\n";
    fs::write(place.join("body.toml"), body).expect("a study");
    let asked = |limit: u32, question: &str| {
        let line = format!(
            "ulimit -v {limit}; exec {} {question}",
            env!("CARGO_BIN_EXE_onset")
        );
        let answer = Command::new("sh")
            .args(["-c", &line])
            .current_dir(&*place)
            .output()
            .expect("sh");
        let told = String::from_utf8_lossy(&answer.stderr).into_owned();
        (answer.status.code(), told)
    };
    for limit in [30_000, 38_000, 45_000, 60_000, 150_000] {
        let (_, told) = asked(limit, "state");
        assert!(!told.contains("panicked"), "{limit}: {told}");
    }
    let (code, told) = asked(200_000, "simulate body.toml --steps 1");
    assert_eq!(code, Some(2), "{told}");
    assert!(told.contains("the system refuses"), "{told}");
    assert!(!told.contains("backtrace"), "{told}");
}
