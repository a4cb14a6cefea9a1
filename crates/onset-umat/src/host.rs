//! The process that the routine runs in: reads paths on standard input, which is a socket, and answers there.
//!
//! Standard output and error are the routine's own.

use crate::frame::{self, GREETING, Loaded};
use crate::routine::{LoadError, Routine};
use nalgebra::Matrix3;
use std::io::{self, BufReader, Write};
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;
use std::os::unix::process::parent_id;
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

/// How often the process looks whether anybody still wants it.
const WATCH: Duration = Duration::from_secs(1);

/// Serves until nobody asks any more.
pub fn serve(library: &Path) -> ExitCode {
    end_without_parent();
    match answer(library) {
        // Whoever asked is gone: nothing is left to do.
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}; this command is for onset itself");
            ExitCode::from(2)
        }
    }
}

/// An endless loop in the routine must not outlive the process that waits for it, however that one ended.
fn end_without_parent() {
    let parent = parent_id();
    std::thread::spawn(move || {
        while parent_id() == parent {
            std::thread::sleep(WATCH);
        }
        std::process::exit(0);
    });
}

fn answer(library: &Path) -> io::Result<()> {
    let socket = UnixStream::from(io::stdin().as_fd().try_clone_to_owned()?);
    let mut requests = BufReader::new(socket.try_clone()?);
    let mut replies = socket;
    let properties = frame::take_size(&mut requests)?;
    let variables = frame::take_size(&mut requests)?;
    let properties = frame::take_numbers(&mut requests, properties)?;
    let loaded = Routine::load(library, &properties, variables);
    let (loaded_code, text) = match &loaded {
        Ok(_) => (Loaded::Ready, ""),
        Err(LoadError::Library(message)) => (Loaded::Failed, message.as_str()),
        Err(LoadError::NoRoutine) => (Loaded::NoRoutine, ""),
    };
    let mut greeting = Vec::new();
    frame::put(&mut greeting, GREETING);
    frame::put(&mut greeting, loaded_code.code());
    frame::put(&mut greeting, text.len() as u64);
    greeting.extend_from_slice(text.as_bytes());
    replies.write_all(&greeting)?;
    let Ok(routine) = loaded else {
        return Ok(());
    };
    let mut reply = Vec::new();
    loop {
        let paths = frame::take_size(&mut requests)?;
        let increments = frame::take_size(&mut requests)?;
        // All is read before the first answer, so that neither side waits for the other to read.
        let numbers = frame::take_numbers(&mut requests, 9 * paths * increments)?;
        let states: Vec<Matrix3<f64>> = numbers
            .chunks_exact(9)
            .map(Matrix3::from_column_slice)
            .collect();
        for path in states.chunks_exact(increments.max(1)) {
            reply.clear();
            routine.follow(path).write(&mut reply);
            replies.write_all(&reply)?;
        }
    }
}
