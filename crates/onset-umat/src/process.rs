//! Parent side of the process in which the routine runs.

use crate::error::UmatError;
use crate::fingerprint::copied;
use crate::folder::PrivateFolder;
use crate::frame::{self, GREETING, Loaded, Reply};
use crate::program::{self, MODE};
use crate::readable::readable;
use crate::umat::UmatSettings;
use nalgebra::Matrix3;
use rustix::process::{Pid, Signal, WaitId, WaitIdOptions, kill_process_group, waitid};
use std::collections::VecDeque;
use std::ffi::OsStr;
use std::io::{self, Read, Write};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Number of bytes kept from the end of the routine's output.
const KEPT_OUTPUT_BYTES: usize = 2000;

/// Time allowed for a process to end after it has closed its socket.
const MAX_EXIT_TIME: Duration = Duration::from_secs(2);

/// Running process with a loaded library, ended when this value is dropped.
pub struct Process {
    /// Process that started it; a forked process must not use or end it.
    starter: u32,
    child: Child,
    socket: UnixStream,
    /// Output of the process, available after its end.
    output: Receiver<String>,
    limit: Duration,
    variables: usize,
    has_ended: bool,
    fingerprint: String,
    /// Folder for the copy of the library, and for files that the routine writes without a name (`fort.7`).
    folder: PrivateFolder,
}

/// Prefix of the folders in which routines run.
pub const FOLDER: &str = "onset-umat-";

/// Name of the copied library in this folder.
const COPY: &str = "library.so";

/// Copies the library and returns the checksum of the copy; an error if another library was expected.
fn checked_copy(settings: &UmatSettings, copy: &Path) -> Result<String, UmatError> {
    let path = &settings.library;
    let found = copied(path, copy, settings.memory_limit).map_err(|error| UmatError::Load {
        path: path.clone(),
        message: error.to_string(),
    })?;
    match &settings.fingerprint {
        Some(wanted) if *wanted != found => Err(UmatError::Changed {
            path: path.clone(),
            wanted: wanted.clone(),
            found,
        }),
        _ => Ok(found),
    }
}

/// Process groups of all routines and programs, each with the process that started it. The first process of each group still exists.
static GROUPS: Mutex<Vec<(u32, Pid)>> = Mutex::new(Vec::new());

fn groups() -> MutexGuard<'static, Vec<(u32, Pid)>> {
    GROUPS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Starts a command in a process group. An interrupt at the terminal reaches only this process, which then ends the group.
fn started(command: &mut Command) -> io::Result<Child> {
    // The lock is held meanwhile, so that `end_all` misses no child.
    let mut groups = groups();
    let child = command.process_group(0).spawn()?;
    groups.push((std::process::id(), Pid::from_child(&child)));
    Ok(child)
}

/// Runs a program to its end, and ends all processes that it leaves running.
pub fn run(command: &mut Command) -> io::Result<ExitStatus> {
    let mut child = started(command)?;
    let group = Pid::from_child(&child);
    // The child is reaped last, so that its number remains reserved for the group.
    let options = WaitIdOptions::EXITED | WaitIdOptions::NOWAIT;
    while let Err(error) = waitid(WaitId::Pid(group), options) {
        if error != rustix::io::Errno::INTR {
            break;
        }
    }
    let _ = kill_process_group(group, Signal::KILL);
    groups().retain(|(_, other)| *other != group);
    child.wait()
}

/// Ends the processes of all routines and programs with their children. None can be started afterwards.
pub fn end_all() {
    let groups = groups();
    let own = std::process::id();
    for (_, group) in groups.iter().filter(|(starter, _)| *starter == own) {
        let _ = kill_process_group(*group, Signal::KILL);
    }
    std::mem::forget(groups);
}

impl Drop for Process {
    fn drop(&mut self) {
        self.end();
    }
}

impl Process {
    /// Starts a process and loads the library in it.
    ///
    /// The process loads a copy in its private folder. The checksum belongs to this copy, even if the original file changes.
    ///
    /// # Errors
    /// [`UmatError`] if the program cannot be started, or the library cannot be loaded.
    pub fn start(settings: &UmatSettings) -> Result<Self, UmatError> {
        let program = settings.host.clone().map_or_else(program::host, Ok)?;
        let not_started = |error: io::Error| UmatError::NoProcess {
            message: format!("{}: {error}", program.display()),
        };
        let folder = PrivateFolder::new(&std::env::temp_dir(), FOLDER).map_err(not_started)?;
        let library = std::path::absolute(&settings.library).map_err(not_started)?;
        let copy = folder.path().join(COPY);
        let fingerprint = checked_copy(settings, &copy)?;
        let (socket, theirs) = UnixStream::pair().map_err(not_started)?;
        let (reader, writer) = io::pipe().map_err(not_started)?;
        let mut command = Command::new(&program);
        command
            .args([OsStr::new(MODE), library.as_os_str(), copy.as_os_str()])
            .env(
                "ONSET_UMAT_DIRECTORY",
                std::env::current_dir().unwrap_or_default(),
            )
            .current_dir(folder.path())
            .stdin(Stdio::from(OwnedFd::from(theirs)))
            .stdout(writer.try_clone().map_err(not_started)?)
            .stderr(writer);
        let child = started(&mut command).map_err(not_started)?;
        // The ends of the pipe that belong to the child.
        drop(command);
        let mut process = Self {
            starter: std::process::id(),
            child,
            socket,
            output: last_words(reader),
            limit: settings.time_limit,
            variables: settings.state_variables,
            has_ended: false,
            fingerprint,
            folder,
        };
        process.greet(settings)?;
        Ok(process)
    }

    fn greet(&mut self, settings: &UmatSettings) -> Result<(), UmatError> {
        let mut setup = Vec::new();
        frame::put(&mut setup, settings.interface.code());
        frame::put(&mut setup, settings.properties.len() as u64);
        frame::put(&mut setup, settings.state_variables as u64);
        frame::put(&mut setup, settings.memory_limit);
        frame::put(&mut setup, settings.time_limit.as_secs_f64().ceil() as u64);
        frame::put_numbers(&mut setup, &settings.properties);
        frame::put_text(&mut setup, settings.behavior.as_deref().unwrap_or_default());
        match self.greeting(&setup) {
            Ok((Loaded::Ready, _, variables)) => {
                self.variables = variables;
                Ok(())
            }
            Ok((Loaded::Failed, message, _)) => Err(self.not_loaded(settings, &message)),
            Ok((Loaded::Unsuitable, message, _)) => Err(UmatError::Unsuitable {
                path: settings.library.clone(),
                message,
            }),
            Ok((Loaded::NoRoutine, ..)) => Err(UmatError::NoRoutine {
                path: settings.library.clone(),
                interface: settings.interface,
            }),
            Err(error) if error.kind() == io::ErrorKind::InvalidData => Err(UmatError::NoProcess {
                message: "the started program is not onset".to_owned(),
            }),
            Err(error) => Err(self.obituary(&error, None)),
        }
    }

    /// Reason why the library cannot be loaded, from the system's message with the original path instead of the copy's.
    fn not_loaded(&self, settings: &UmatSettings, message: &str) -> UmatError {
        let path = std::path::absolute(&settings.library);
        let path = path.unwrap_or_else(|_| settings.library.clone());
        let copy = self.folder.path().join(COPY);
        let message = message.replace(&*copy.to_string_lossy(), &path.to_string_lossy());
        UmatError::Load { path, message }
    }

    /// Returns false in a fork of the process that started it.
    pub fn is_ours(&self) -> bool {
        self.starter == std::process::id()
    }

    /// Number of state variables of the routine.
    pub fn variables(&self) -> usize {
        self.variables
    }

    /// Checksum of the library.
    pub fn fingerprint(&self) -> &str {
        &self.fingerprint
    }

    fn greeting(&mut self, setup: &[u8]) -> io::Result<(Loaded, String, usize)> {
        self.socket.set_read_timeout(Some(self.limit))?;
        self.socket.set_write_timeout(Some(self.limit))?;
        self.socket.write_all(setup)?;
        if frame::take(&mut self.socket)? != GREETING {
            return Err(frame::nonsense());
        }
        let loaded = Loaded::of_code(frame::take(&mut self.socket)?).ok_or_else(frame::nonsense)?;
        let text = frame::take_text(&mut self.socket)?;
        let variables = frame::take_size(&mut self.socket)?;
        Ok((loaded, readable(&text), variables))
    }

    /// Computes the replies at the ends of paths of equal length.
    ///
    /// # Errors
    /// [`UmatError::Ended`] and [`UmatError::Silent`]; `replies` then holds the earlier replies, and the process is gone.
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

    /// Ends the process and returns the reason for its failure.
    fn obituary(&mut self, error: &io::Error, state: Option<Matrix3<f64>>) -> UmatError {
        let state = state.map(Box::new);
        let is_silent = matches!(
            error.kind(),
            io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut
        );
        let by_itself = !is_silent && self.parted();
        let status = self.end().filter(|_| by_itself);
        let output = self.output.recv_timeout(MAX_EXIT_TIME).unwrap_or_default();
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

    /// Returns true if the process ends by itself. The process is not reaped yet, so that its number remains reserved for the group.
    fn parted(&self) -> bool {
        let pause = Duration::from_millis(5);
        let mut waited = Duration::ZERO;
        let options = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
        while waited < MAX_EXIT_TIME {
            match waitid(WaitId::Pid(Pid::from_child(&self.child)), options) {
                Ok(Some(_)) => return true,
                Ok(None) => std::thread::sleep(pause),
                Err(_) => return false,
            }
            waited += pause;
        }
        false
    }

    /// Ends the process with its children and returns its exit status; `None` in a second call, or in a fork.
    fn end(&mut self) -> Option<ExitStatus> {
        if std::mem::replace(&mut self.has_ended, true) || !self.is_ours() {
            return None;
        }
        let group = Pid::from_child(&self.child);
        // Processes that have already ended cannot be killed, but must be reaped.
        let _ = kill_process_group(group, Signal::KILL);
        groups().retain(|(_, other)| *other != group);
        self.child.wait().ok()
    }
}

/// Reads the output of a process continuously, so that it never blocks, and sends the last part after its end.
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
                    let excess = kept.len().saturating_sub(KEPT_OUTPUT_BYTES);
                    kept.drain(..excess);
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(_) => break,
            }
        }
        let bytes: Vec<u8> = kept.into();
        // The receiver may be gone.
        drop(sender.send(readable(&String::from_utf8_lossy(&bytes))));
    });
    receiver
}

fn in_words(status: ExitStatus) -> String {
    let signal = match status.signal() {
        Some(4) => Some("signal 4, an illegal instruction".to_owned()),
        Some(6) => Some("signal 6, it aborted".to_owned()),
        Some(8) => Some("signal 8, an arithmetic error".to_owned()),
        Some(24) => {
            Some("signal 24: it used more processor time than material.time-limit".to_owned())
        }
        Some(9) => Some("signal 9: it was killed; was memory short?".to_owned()),
        Some(7 | 10 | 11) => Some(format!(
            "signal {}: it accessed memory outside its bounds; is an index out of range?",
            status.signal().unwrap_or_default()
        )),
        other => other.map(|signal| format!("signal {signal}")),
    };
    signal.unwrap_or_else(|| match status.code() {
        Some(code) => format!("it stopped by itself with exit code {code}, as STOP and XIT do"),
        None => status.to_string(),
    })
}
