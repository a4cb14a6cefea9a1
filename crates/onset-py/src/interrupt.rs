//! Computations in separate threads, without the interpreter's lock, which end after Ctrl-C.

use crate::failure::Failure;
use crate::pool;
use pyo3::prelude::*;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// Interval between checks for signals.
const SIGNAL_CHECK_INTERVAL: Duration = Duration::from_millis(50);

/// Longest wait for a computation to end after Ctrl-C. It then continues in the background until its next check.
const GRACE: Duration = Duration::from_millis(200);

/// Stack size of a thread, equal to the usual stack of the main thread; bytes.
const STACK_BYTES: usize = 8 << 20;

/// Number of requests to end a computation.
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Arc<AtomicU8>);

/// Payload that unwinds a cancelled computation; it is not a panic, and no hook reports it.
struct GivenUp;

impl Interrupt {
    /// Returns true after a request to end.
    pub fn is_asked(&self) -> bool {
        self.0.load(Ordering::Relaxed) > 0
    }

    /// Returns true after a second request to end.
    pub fn is_asked_twice(&self) -> bool {
        self.0.load(Ordering::Relaxed) > 1
    }

    /// Cancels the computation after a request to end.
    pub fn end_if_asked(&self) {
        self.end_from(1);
    }

    /// Cancels the computation after a second request to end; for computations that finish started work after the first.
    pub fn end_if_asked_twice(&self) {
        self.end_from(2);
    }

    fn end_from(&self, times: u8) {
        if self.0.load(Ordering::Relaxed) >= times {
            resume_unwind(Box::new(GivenUp));
        }
    }

    fn ask(&self) {
        // Further requests have no effect.
        self.0.store(
            self.0.load(Ordering::Relaxed).saturating_add(1).min(2),
            Ordering::Relaxed,
        );
    }
}

/// Runs a computation without checks for cancellation; after Ctrl-C it continues in the background and its result is dropped.
pub fn answer<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    let mut answers = begun(work)?;
    loop {
        match received(py, &mut answers) {
            Some(answer) => return Ok(answer?),
            None => py.check_signals()?,
        }
    }
}

/// Runs a computation that checks for cancellation. After Ctrl-C it has [`GRACE`] to end.
pub fn ending<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(Interrupt) -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    until(py, Some(GRACE), work)
}

/// Runs a computation that saves its progress after a request to end; it has ended when this function returns.
pub fn finishing<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(Interrupt) -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    until(py, None, work)
}

fn until<T: Send + 'static>(
    py: Python<'_>,
    grace: Option<Duration>,
    work: impl FnOnce(Interrupt) -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    let interrupt = Interrupt::default();
    let within = interrupt.clone();
    let mut answers = begun(move || work(within))?;
    let mut interrupted: Option<(PyErr, Instant)> = None;
    loop {
        let answer = received(py, &mut answers);
        match (answer, interrupted.take()) {
            (Some(_), Some((error, _))) => return Err(error),
            (Some(answer), None) => return Ok(answer?),
            (None, Some((error, since))) if grace.is_some_and(|grace| since.elapsed() > grace) => {
                return Err(error);
            }
            (None, waiting) => interrupted = waiting,
        }
        if let Err(error) = py.check_signals() {
            interrupt.ask();
            interrupted.get_or_insert((error, Instant::now()));
        }
    }
}

/// Starts a computation in a separate thread.
fn begun<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, Failure> + Send + 'static,
) -> Result<Receiver<Result<T, Failure>>, Failure> {
    let (answered, answers) = channel();
    std::thread::Builder::new()
        .name("onset".to_owned())
        .stack_size(STACK_BYTES)
        .spawn(move || {
            let answer = catch_unwind(AssertUnwindSafe(|| pool::shared(work, STACK_BYTES)?))
                .unwrap_or_else(|why| Err(told(&*why)));
            // The receiver of a cancelled computation is gone.
            let _ = answered.send(answer);
        })
        .map_err(|error| Failure::machine(format!("cannot start a thread: {error}")))?;
    Ok(answers)
}

/// Returns the result if it arrives before the next check for signals.
fn received<T: Send>(
    py: Python<'_>,
    answers: &mut Receiver<Result<T, Failure>>,
) -> Option<Result<T, Failure>> {
    match py.detach(move || answers.recv_timeout(SIGNAL_CHECK_INTERVAL)) {
        Ok(answer) => Some(answer),
        Err(RecvTimeoutError::Timeout) => None,
        Err(RecvTimeoutError::Disconnected) => Some(Err(Failure::Ended)),
    }
}

/// Reason why a computation has no result.
fn told(why: &(dyn Any + Send)) -> Failure {
    if why.is::<GivenUp>() {
        return Failure::Ended;
    }
    let text = why
        .downcast_ref::<String>()
        .map(String::as_str)
        .or_else(|| why.downcast_ref::<&str>().copied())
        .unwrap_or("for an unknown reason");
    Failure::Defect(format!(
        "this question cannot be answered because of a defect: {text}\n  hint: please report it with the question"
    ))
}
