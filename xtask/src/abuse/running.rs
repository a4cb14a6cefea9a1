//! Start, observation and end of programs.

use std::cell::Cell;
use std::fmt;
use std::fs::{self, File};
use std::io;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// Longest time for any program to end, without the time that it waits for a processor: ten seconds, and more on a loaded machine.
pub(crate) fn longest() -> Duration {
    let load = fs::read_to_string("/proc/loadavg").unwrap_or_default();
    let load = load.split(' ').next().and_then(|load| load.parse().ok());
    let cores = std::thread::available_parallelism().map_or(1.0, |cores| cores.get() as f64);
    Duration::from_secs_f64(10.0 * (load.unwrap_or(0.0) / cores).max(1.0))
}

/// Time for which the threads of a process and its children have waited for a processor; zero if the system does not record it.
fn starved(process: u32) -> Duration {
    let tasks = fs::read_dir(format!("/proc/{process}/task"));
    let of = |task: fs::DirEntry| {
        let read = |name| fs::read_to_string(task.path().join(name)).unwrap_or_default();
        let waited = read("schedstat");
        let waited = waited.split(' ').nth(1).and_then(|time| time.parse().ok());
        let children = read("children");
        let children = children.split_whitespace();
        let children = children.filter_map(|child| child.parse().ok());
        waited.map_or(Duration::ZERO, Duration::from_nanos)
            + children.map(starved).sum::<Duration>()
    };
    tasks.into_iter().flatten().flatten().map(of).sum()
}

/// Numbers of signals: Ctrl-C, a closed terminal, the end of a batch job, and a kill, which cannot be handled.
pub(crate) const INTERRUPT: i32 = 2;
pub(crate) const HANGUP: i32 = 1;
pub(crate) const TERMINATE: i32 = 15;
pub(crate) const KILL: i32 = 9;
/// Returns true for a signal that programs started here ignore until they handle it, as below `nohup` and in the background of a script.
pub(crate) fn is_ignored(signal: i32) -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

/// Documented exit codes: done, failed, refused, verdict, interrupted.
const CODES: [i32; 5] = [0, 1, 2, 3, 130];

/// Fault at the end of a program.
pub(crate) enum Fault {
    /// The program did not end in time.
    Hang(String),
    /// The program ended by a panic, an abort, or a signal from outside the test.
    Abort(String),
    /// A file is neither the old nor the new one.
    Torn(String),
    /// A message is too long, or repeats contents of a file.
    Told(String),
}

/// Largest number of characters of a message with its line feed.
const LONGEST_MESSAGE: usize = 2001;

impl fmt::Display for Fault {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (what, why) = match self {
            Self::Hang(why) => ("hangs", why),
            Self::Abort(why) => ("aborts", why),
            Self::Torn(why) => ("torn file", why),
            Self::Told(why) => ("message", why),
        };
        write!(formatter, "{what}: {why}")
    }
}

impl From<io::Error> for Fault {
    fn from(error: io::Error) -> Self {
        Self::Abort(format!("of the harness: {error}"))
    }
}

/// Folder of a case, removed when it ends.
pub(crate) struct Place {
    folder: PathBuf,
    /// Longest time from a signal to the end of a program.
    slowest: Cell<Duration>,
}

impl Place {
    pub(crate) fn new(case: u64) -> Result<Self, Fault> {
        let name = format!("onset-abuse-{}-{case}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        fs::create_dir_all(&folder)?;
        Ok(Self {
            folder,
            slowest: Cell::default(),
        })
    }

    pub(crate) fn path(&self) -> &Path {
        &self.folder
    }

    pub(crate) fn slowest(&self) -> Duration {
        self.slowest.get()
    }

    /// Records the time from a signal to the end of a program.
    ///
    /// # Errors
    /// A hang, if this time is far above the documented 0.3 s.
    pub(crate) fn ended_after(&self, time: Duration, line: &str) -> Result<(), Fault> {
        self.slowest.set(self.slowest.get().max(time));
        if time > longest() / 4 {
            let seconds = time.as_secs_f64();
            return Err(Fault::Hang(format!(
                "{line}\nends {seconds:.1} s after the signal"
            )));
        }
        Ok(())
    }

    pub(crate) fn write(&self, name: &str, text: impl AsRef<[u8]>) -> Result<PathBuf, Fault> {
        let path = self.folder.join(name);
        fs::write(&path, text)?;
        Ok(path)
    }

    /// Starts a command in this folder, with its output in files.
    pub(crate) fn started(&self, mut command: Command) -> Result<Running<'_>, Fault> {
        let line = format!("{command:?}");
        let [out, error] = ["stdout", "stderr"].map(|name| self.folder.join(format!(".{name}")));
        let child = command
            .current_dir(&self.folder)
            .env("TMPDIR", &self.folder)
            .stdin(Stdio::null())
            .stdout(File::create(&out)?)
            .stderr(File::create(&error)?)
            .spawn()?;
        Ok(Running {
            child,
            line,
            out,
            error,
            signals: Vec::new(),
            starved: Duration::ZERO,
            place: self,
        })
    }

    /// Runs a command to its end, and interrupts it after three seconds.
    pub(crate) fn run(&self, command: Command) -> Result<Ended, Fault> {
        self.run_for(Duration::from_secs(3), command)
    }

    /// Runs a command to its end, and interrupts it after the given time.
    pub(crate) fn run_for(&self, time: Duration, command: Command) -> Result<Ended, Fault> {
        let mut running = self.started(command)?;
        if running.ends_within(time)?.is_none() {
            running.signal(INTERRUPT)?;
        }
        running.ended()
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.folder);
    }
}

/// Running program.
pub(crate) struct Running<'a> {
    place: &'a Place,
    child: Child,
    line: String,
    out: PathBuf,
    error: PathBuf,
    /// Signals that were sent, when, and the time waited for a processor until then.
    signals: Vec<(i32, Instant, Duration)>,
    /// Time waited for a processor, at the last check.
    starved: Duration,
}

/// Result of a program.
pub(crate) struct Ended {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
    /// Command line, for the report of a fault.
    pub(crate) line: String,
}

impl Running<'_> {
    /// Sends a signal to the program.
    pub(crate) fn signal(&mut self, signal: i32) -> Result<(), Fault> {
        let starved = starved(self.child.id());
        self.signals.push((signal, Instant::now(), starved));
        let number = self.child.id().to_string();
        Command::new("kill")
            .args([format!("-{signal}"), number])
            .stderr(Stdio::null())
            .status()?;
        Ok(())
    }

    /// Waits for the end for at most the given time.
    pub(crate) fn ends_within(&mut self, time: Duration) -> Result<Option<ExitStatus>, Fault> {
        let end = Instant::now() + time;
        for poll in 0_u64.. {
            if let Some(status) = self.child.try_wait()? {
                return Ok(Some(status));
            }
            if Instant::now() >= end {
                break;
            }
            if poll % 32 == 31 {
                self.starved = starved(self.child.id());
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        Ok(None)
    }

    /// Waits for the end and checks the exit.
    pub(crate) fn ended(mut self) -> Result<Ended, Fault> {
        let read = |path| fs::read(path).map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
        let begun = Instant::now();
        let mut ended = self.ends_within(longest())?;
        while ended.is_none() && begun.elapsed() < longest() + self.starved {
            ended = self.ends_within(Duration::from_secs(1))?;
        }
        let asked = self.signals.first().map(|(_, at, before)| {
            let waited = self.starved.saturating_sub(*before);
            at.elapsed().saturating_sub(waited)
        });
        let Some(status) = ended else {
            self.child.kill()?;
            self.child.wait()?;
            let told = read(&self.error).unwrap_or_default();
            return Err(Fault::Hang(format!("{}\n{told}", self.line)));
        };
        let (stdout, stderr) = (read(&self.out)?, read(&self.error)?);
        let code = status.code();
        let is_documented = code.is_some_and(|code| CODES.contains(&code));
        // A signal ends a program that does not handle signals yet.
        let is_killed = status
            .signal()
            .is_some_and(|signal| self.signals.iter().any(|(sent, ..)| *sent == signal));
        if stderr.contains("panicked")
            || stderr.contains("a defect")
            || !(is_documented || is_killed)
        {
            let told: String = stderr.chars().take(600).collect();
            return Err(Fault::Abort(format!("{status}: {}\n{told}", self.line)));
        }
        let message = stderr.find("error: ").map_or("", |at| &stderr[at..]);
        if message.chars().count() > LONGEST_MESSAGE {
            let told: String = message.chars().take(600).collect();
            return Err(Fault::Told(format!("{}\n{told}", self.line)));
        }
        if let Some(time) = asked {
            self.place.ended_after(time, &self.line)?;
        }
        Ok(Ended {
            code,
            stdout,
            stderr,
            line: self.line.clone(),
        })
    }
}

impl Drop for Running<'_> {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
