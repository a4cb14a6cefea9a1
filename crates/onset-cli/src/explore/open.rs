//! Open connections. Any user of the machine can open connections, so an idle one is closed to admit a new one.

use std::io;
use std::net::{Shutdown, TcpStream};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// Largest number of connections; a browser opens six.
const MAX_CONNECTIONS: usize = 64;

/// All open connections of the server.
#[derive(Default)]
pub struct Connections(Mutex<Vec<Entry>>);

struct Entry {
    number: u64,
    stream: TcpStream,
    /// End of the last exchange.
    since: Instant,
    is_computing: bool,
}

impl Connections {
    /// Admits a connection. If there are too many, the longest idle one is closed; numbers are never reused.
    ///
    /// # Errors
    /// [`io::Error`] if all others are computing an answer, or if the system refuses a second handle.
    pub fn admit(&self, stream: &TcpStream) -> io::Result<Admitted<'_>> {
        let mut open = self.entries();
        if open.len() >= MAX_CONNECTIONS {
            let waiting = open
                .iter()
                .enumerate()
                .filter(|(_, entry)| !entry.is_computing);
            let oldest = waiting
                .min_by_key(|(_, entry)| entry.since)
                .map(|(place, _)| place);
            let oldest = oldest.ok_or_else(|| io::Error::other("all connections are in use"))?;
            // Closing the connection also ends the thread that reads from it.
            let _ = open.remove(oldest).stream.shutdown(Shutdown::Both);
        }
        let number = open.iter().map(|entry| entry.number + 1).max().unwrap_or(0);
        open.push(Entry {
            number,
            stream: stream.try_clone()?,
            since: Instant::now(),
            is_computing: false,
        });
        Ok(Admitted { all: self, number })
    }

    fn entries(&self) -> MutexGuard<'_, Vec<Entry>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Open connection, closed when this value is dropped.
pub struct Admitted<'a> {
    all: &'a Connections,
    number: u64,
}

impl Admitted<'_> {
    /// Runs a computation during which the connection is not closed in favor of others.
    pub fn computing<T>(&self, work: impl FnOnce() -> T) -> T {
        self.mark(true);
        let done = work();
        self.mark(false);
        done
    }

    /// Records the beginning or the end of an exchange, and whether the connection is computing.
    pub fn mark(&self, is_computing: bool) {
        let mut open = self.all.entries();
        if let Some(entry) = open.iter_mut().find(|entry| entry.number == self.number) {
            entry.since = Instant::now();
            entry.is_computing = is_computing;
        }
    }
}

impl Drop for Admitted<'_> {
    fn drop(&mut self) {
        self.all
            .entries()
            .retain(|entry| entry.number != self.number);
    }
}
