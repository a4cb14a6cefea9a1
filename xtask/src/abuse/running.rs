//! Start, observation and end of programs.

use std::fmt;
use std::fs::{self, File};
use std::io;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// Longest time for any program to end: ten seconds, and more on a loaded machine.
pub(crate) fn longest() -> Duration {
    let load = fs::read_to_string("/proc/loadavg").unwrap_or_default();
    let load = load.split(' ').next().and_then(|load| load.parse().ok());
    let cores = std::thread::available_parallelism().map_or(1.0, |cores| cores.get() as f64);
    Duration::from_secs_f64(10.0 * (load.unwrap_or(0.0) / cores).max(1.0))
}

/// Numbers of signals: Ctrl-C, a closed terminal, the end of a batch job, and a kill, which cannot be handled.
pub(crate) const INTERRUPT: i32 = 2;
pub(crate) const HANGUP: i32 = 1;
pub(crate) const TERMINATE: i32 = 15;
pub(crate) const KILL: i32 = 9;
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
pub(crate) struct Place(PathBuf);

impl Place {
    pub(crate) fn new(case: u64) -> Result<Self, Fault> {
        let name = format!("onset-abuse-{}-{case}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        fs::create_dir_all(&folder)?;
        Ok(Self(folder))
    }

    pub(crate) fn path(&self) -> &Path {
        &self.0
    }

    pub(crate) fn write(&self, name: &str, text: impl AsRef<[u8]>) -> Result<PathBuf, Fault> {
        let path = self.0.join(name);
        fs::write(&path, text)?;
        Ok(path)
    }

    /// Starts a command in this folder, with its output in files.
    pub(crate) fn started(&self, mut command: Command) -> Result<Running, Fault> {
        let line = format!("{command:?}");
        let [out, error] = ["stdout", "stderr"].map(|name| self.0.join(format!(".{name}")));
        let child = command
            .current_dir(&self.0)
            .env("TMPDIR", &self.0)
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
        })
    }

    /// Runs a command to its end, and interrupts a slow one.
    pub(crate) fn run(&self, command: Command) -> Result<Ended, Fault> {
        let mut running = self.started(command)?;
        if running.ends_within(Duration::from_secs(3))?.is_none() {
            running.signal(INTERRUPT)?;
        }
        running.ended()
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Running program.
pub(crate) struct Running {
    child: Child,
    line: String,
    out: PathBuf,
    error: PathBuf,
    signals: Vec<i32>,
}

/// Result of a program.
pub(crate) struct Ended {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
    /// Command line, for the report of a fault.
    pub(crate) line: String,
}

impl Running {
    /// Sends a signal to the program.
    pub(crate) fn signal(&mut self, signal: i32) -> Result<(), Fault> {
        self.signals.push(signal);
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
        loop {
            if let Some(status) = self.child.try_wait()? {
                return Ok(Some(status));
            }
            if Instant::now() >= end {
                return Ok(None);
            }
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// Waits for the end and checks the exit.
    pub(crate) fn ended(mut self) -> Result<Ended, Fault> {
        let read = |path| fs::read(path).map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
        let Some(status) = self.ends_within(longest())? else {
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
            .is_some_and(|signal| self.signals.contains(&signal));
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
        Ok(Ended {
            code,
            stdout,
            stderr,
            line: self.line.clone(),
        })
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
