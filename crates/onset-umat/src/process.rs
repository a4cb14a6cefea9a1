//! Our side of the process that the routine runs in.

use crate::error::UmatError;
use crate::frame::{self, GREETING, Loaded, Reply};
use crate::program::{self, MODE};
use crate::umat::UmatSettings;
use nalgebra::Matrix3;
use std::collections::VecDeque;
use std::ffi::OsStr;
use std::io::{self, Read, Write};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{self, Receiver};
use std::time::Duration;

/// How much of what a routine prints is kept: the last bytes.
const KEPT: usize = 2000;

/// How long a process that has closed its socket may take to end.
const PARTING: Duration = Duration::from_secs(2);

/// A running process with a loaded library. Ends with this value.
pub struct Process {
    child: Child,
    socket: UnixStream,
    /// What it has printed, once it has ended.
    output: Receiver<String>,
    limit: Duration,
    variables: usize,
    _folder: Folder,
}

/// A folder for what the routine writes to files without a name (`fort.7`), removed in the end.
struct Folder(PathBuf);

impl Folder {
    fn new() -> io::Result<Self> {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let name = format!("onset-umat-{}-{count}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&folder)?;
        Ok(Self(folder))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // Whatever is left there is worth nothing.
        drop(std::fs::remove_dir_all(&self.0));
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        self.end();
    }
}

impl Process {
    /// Starts a process and loads the library there.
    ///
    /// # Errors
    /// [`UmatError`] when the program cannot be started, or the library cannot be loaded.
    pub fn start(settings: &UmatSettings) -> Result<Self, UmatError> {
        let program = settings.host.clone().map_or_else(program::host, Ok)?;
        let not_started = |error: io::Error| UmatError::NoProcess {
            message: format!("{}: {error}", program.display()),
        };
        let folder = Folder::new().map_err(not_started)?;
        let library = std::path::absolute(&settings.library).map_err(not_started)?;
        let (socket, theirs) = UnixStream::pair().map_err(not_started)?;
        let (reader, writer) = io::pipe().map_err(not_started)?;
        let child = Command::new(&program)
            .args([OsStr::new(MODE), library.as_os_str()])
            .env(
                "ONSET_UMAT_DIRECTORY",
                std::env::current_dir().unwrap_or_default(),
            )
            .current_dir(&folder.0)
            .stdin(Stdio::from(OwnedFd::from(theirs)))
            .stdout(writer.try_clone().map_err(not_started)?)
            .stderr(writer)
            // An interrupt at the terminal is for us; we end it.
            .process_group(0)
            .spawn()
            .map_err(not_started)?;
        let mut process = Self {
            child,
            socket,
            output: last_words(reader),
            limit: settings.time_limit,
            variables: settings.state_variables,
            _folder: folder,
        };
        process.greet(settings)?;
        Ok(process)
    }

    fn greet(&mut self, settings: &UmatSettings) -> Result<(), UmatError> {
        let mut setup = Vec::new();
        frame::put(&mut setup, settings.properties.len() as u64);
        frame::put(&mut setup, settings.state_variables as u64);
        frame::put_numbers(&mut setup, &settings.properties);
        match self.greeting(&setup) {
            Ok((Loaded::Ready, _)) => Ok(()),
            Ok((Loaded::Failed, message)) => Err(UmatError::Load {
                path: std::path::absolute(&settings.library)
                    .unwrap_or_else(|_| settings.library.clone()),
                message,
            }),
            Ok((Loaded::NoRoutine, _)) => Err(UmatError::NoRoutine {
                path: settings.library.clone(),
            }),
            Err(error) if error.kind() == io::ErrorKind::InvalidData => Err(UmatError::NoProcess {
                message: "what was started is not onset".to_owned(),
            }),
            Err(error) => Err(self.obituary(&error, None)),
        }
    }

    fn greeting(&mut self, setup: &[u8]) -> io::Result<(Loaded, String)> {
        self.socket.set_read_timeout(Some(self.limit))?;
        self.socket.set_write_timeout(Some(self.limit))?;
        self.socket.write_all(setup)?;
        if frame::take(&mut self.socket)? != GREETING {
            return Err(frame::nonsense());
        }
        let loaded = Loaded::of_code(frame::take(&mut self.socket)?).ok_or_else(frame::nonsense)?;
        let mut text = Vec::new();
        let length = frame::take(&mut self.socket)?;
        Read::by_ref(&mut self.socket)
            .take(length)
            .read_to_end(&mut text)?;
        Ok((loaded, String::from_utf8_lossy(&text).into_owned()))
    }

    /// The replies at the ends of paths of equal length.
    ///
    /// # Errors
    /// [`UmatError::Ended`] and [`UmatError::Silent`], with the number of replies that came before; the process is then gone.
    pub fn follow(
        &mut self,
        paths: &[Vec<Matrix3<f64>>],
        replies: &mut Vec<Reply>,
    ) -> Result<(), UmatError> {
        let increments = paths.first().map_or(0, Vec::len);
        let mut request = Vec::with_capacity(16 + 72 * paths.len() * increments);
        frame::put(&mut request, paths.len() as u64);
        frame::put(&mut request, increments as u64);
        for state in paths.iter().flatten() {
            frame::put_numbers(&mut request, state.as_slice());
        }
        let state = |replies: &[Reply]| {
            paths
                .get(replies.len())
                .and_then(|path| path.last().copied())
        };
        if let Err(error) = self.socket.write_all(&request) {
            return Err(self.obituary(&error, state(replies)));
        }
        for _ in paths {
            match Reply::read(&mut self.socket, self.variables) {
                Ok(reply) => replies.push(reply),
                Err(error) => return Err(self.obituary(&error, state(replies))),
            }
        }
        Ok(())
    }

    /// Ends the process and says what happened.
    fn obituary(&mut self, error: &io::Error, state: Option<Matrix3<f64>>) -> UmatError {
        let state = state.map(Box::new);
        let is_silent = matches!(
            error.kind(),
            io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut
        );
        let status = if is_silent { None } else { self.parting() };
        self.end();
        let output = self.output.recv_timeout(PARTING).unwrap_or_default();
        match status {
            _ if is_silent => UmatError::Silent {
                seconds: self.limit.as_secs_f64(),
                state,
                output,
            },
            Some(status) => UmatError::Ended {
                how: in_words(status),
                state,
                output,
            },
            None => UmatError::Ended {
                how: format!("it closed its socket: {error}"),
                state,
                output,
            },
        }
    }

    /// How the process ended by itself.
    fn parting(&mut self) -> Option<ExitStatus> {
        let pause = Duration::from_millis(5);
        let mut waited = Duration::ZERO;
        while waited < PARTING {
            match self.child.try_wait() {
                Ok(Some(status)) => return Some(status),
                Ok(None) => std::thread::sleep(pause),
                Err(_) => return None,
            }
            waited += pause;
        }
        None
    }

    fn end(&mut self) {
        // A process that has ended already cannot be killed, but must be waited for.
        drop(self.child.kill());
        drop(self.child.wait());
    }
}

/// Reads what a process prints, so that it never waits for a reader, and tells the last of it when it has ended.
fn last_words(mut reader: impl Read + Send + 'static) -> Receiver<String> {
    let (sender, receiver) = mpsc::channel();
    std::thread::spawn(move || {
        let mut kept = VecDeque::new();
        let mut buffer = [0; 4096];
        loop {
            match reader.read(&mut buffer) {
                Ok(0) => break,
                Ok(count) => {
                    kept.extend(&buffer[..count]);
                    let excess = kept.len().saturating_sub(KEPT);
                    kept.drain(..excess);
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(_) => break,
            }
        }
        let bytes: Vec<u8> = kept.into();
        // Nobody may be interested.
        drop(sender.send(String::from_utf8_lossy(&bytes).into_owned()));
    });
    receiver
}

fn in_words(status: ExitStatus) -> String {
    let signal = match status.signal() {
        Some(4) => Some("signal 4, an illegal instruction".to_owned()),
        Some(6) => Some("signal 6, it aborted".to_owned()),
        Some(8) => Some("signal 8, an arithmetic error".to_owned()),
        Some(9) => Some("signal 9, it was killed; was memory short?".to_owned()),
        Some(7 | 10 | 11) => Some(format!(
            "signal {}, it used memory that is not its own; is an index out of bounds?",
            status.signal().unwrap_or_default()
        )),
        other => other.map(|signal| format!("signal {signal}")),
    };
    signal.unwrap_or_else(|| match status.code() {
        Some(code) => format!("it stopped by itself with exit code {code}, as STOP and XIT do"),
        None => status.to_string(),
    })
}
