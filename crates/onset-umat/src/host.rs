//! Process in which the routine runs.
//!
//! It reads paths from standard input, which is a socket, and replies on this socket. Standard output and standard error belong to the routine.

use crate::frame::{self, GREETING, Loaded};
use crate::interface::Interface;
use crate::process::FOLDER;
use crate::routine::{LoadError, Routine, Setup};
use nalgebra::Matrix3;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{
    Resource, Rlimit, Signal, getpgrp, getpid, getrlimit, kill_process_group, setrlimit,
};
use rustix::time::{ClockId, clock_gettime};
use std::io::{self, BufReader, Write};
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;
use std::os::unix::process::parent_id;
use std::path::Path;
use std::process::ExitCode;

/// Interval at which the process checks for its parent, in case the closed socket is not reported.
const WATCH_INTERVAL: Timespec = Timespec {
    tv_sec: 1,
    tv_nsec: 0,
};

/// Serves until the parent process closes the connection.
pub fn serve(library: &Path) -> ExitCode {
    if let Err(error) = end_without_parent() {
        eprintln!("error: {error}; this command is for onset itself");
        return ExitCode::from(2);
    }
    match answer(library) {
        // The parent process has ended, and the host ends normally.
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}; this command is for onset itself");
            ExitCode::from(2)
        }
    }
}

/// Ends the process group and removes its folder once the parent process has ended.
///
/// An endless loop in the routine, or a process that it has started, must not outlive the parent.
fn end_without_parent() -> io::Result<()> {
    let parent = parent_id();
    let socket = io::stdin().as_fd().try_clone_to_owned()?;
    let folder = std::env::current_dir()?;
    std::thread::spawn(move || {
        let is_closed = || {
            // Waits only for the other end to be closed.
            let mut watched = [PollFd::new(&socket, PollFlags::empty())];
            poll(&mut watched, Some(&WATCH_INTERVAL)).is_ok_and(|ready| ready > 0)
        };
        while !is_closed() && parent_id() == parent {}
        let name = folder.file_name().unwrap_or_default();
        if name.as_encoded_bytes().starts_with(FOLDER.as_bytes()) {
            // A failure is ignored: the content has no further use.
            drop(std::fs::remove_dir_all(&folder));
        }
        if getpgrp() == getpid() {
            let _ = kill_process_group(getpid(), Signal::KILL);
        }
        std::process::exit(0);
    });
    Ok(())
}

/// Limits the memory of the routine to the given number of bytes.
fn limit_memory(bytes: u64) -> io::Result<()> {
    let hard = getrlimit(Resource::As).maximum;
    let limit = Rlimit {
        current: Some(hard.map_or(bytes, |hard| hard.min(bytes))),
        maximum: hard,
    };
    Ok(setrlimit(Resource::As, limit)?)
}

/// Limits the additional processor time of the routine, and of each process that it starts, to the given number of seconds.
fn limit_time(seconds: u64) -> io::Result<()> {
    let used = clock_gettime(ClockId::ProcessCPUTime).tv_sec.unsigned_abs();
    let hard = getrlimit(Resource::Cpu).maximum;
    // The used time is rounded down.
    let until = used.saturating_add(seconds).saturating_add(1);
    let limit = Rlimit {
        current: Some(hard.map_or(until, |hard| hard.min(until))),
        maximum: hard,
    };
    Ok(setrlimit(Resource::Cpu, limit)?)
}

fn answer(library: &Path) -> io::Result<()> {
    let socket = UnixStream::from(io::stdin().as_fd().try_clone_to_owned()?);
    let mut requests = BufReader::new(socket.try_clone()?);
    let mut replies = socket;
    let interface = frame::take(&mut requests)?;
    let interface = Interface::of_code(interface).ok_or_else(frame::nonsense)?;
    let properties = frame::take_size(&mut requests)?;
    let variables = frame::take_size(&mut requests)?;
    let memory = frame::take(&mut requests)?;
    let seconds = frame::take(&mut requests)?;
    let properties = frame::take_numbers(&mut requests, properties)?;
    let behavior = Some(frame::take_text(&mut requests)?).filter(|name| !name.is_empty());
    limit_memory(memory)?;
    limit_time(seconds)?;
    let setup = Setup {
        interface,
        behavior,
        properties,
        variables,
    };
    let loaded = Routine::load(library, setup);
    let (loaded_code, text) = match &loaded {
        Ok(_) => (Loaded::Ready, ""),
        Err(LoadError::Library(message)) => (Loaded::Failed, message.as_str()),
        Err(LoadError::NoRoutine) => (Loaded::NoRoutine, ""),
        Err(LoadError::Unsuitable(message)) => (Loaded::Unsuitable, message.as_str()),
    };
    let mut greeting = Vec::new();
    frame::put(&mut greeting, GREETING);
    frame::put(&mut greeting, loaded_code.code());
    frame::put_text(&mut greeting, text);
    let variables = loaded.as_ref().map_or(0, Routine::variables);
    frame::put(&mut greeting, variables as u64);
    replies.write_all(&greeting)?;
    let Ok(routine) = loaded else {
        return Ok(());
    };
    let mut reply = Vec::new();
    loop {
        let paths = frame::take_size(&mut requests)?;
        let increments = frame::take_size(&mut requests)?;
        // All input is read before the first reply, so that the two sides never wait for each other.
        let numbers = frame::take_numbers(&mut requests, 9 * paths * increments)?;
        let states: Vec<Matrix3<f64>> = numbers
            .chunks_exact(9)
            .map(Matrix3::from_column_slice)
            .collect();
        for path in states.chunks_exact(increments.max(1)) {
            reply.clear();
            limit_time(seconds)?;
            routine.follow(path).write(&mut reply);
            replies.write_all(&reply)?;
        }
    }
}
