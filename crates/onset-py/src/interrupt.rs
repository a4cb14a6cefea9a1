//! Computations in separate threads, without the interpreter's lock, which end after Ctrl-C.

use crate::failure::Failure;
use crate::pool;
use onset::cancel::unless;
use pyo3::prelude::*;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// Interval between checks for signals.
const SIGNAL_CHECK_INTERVAL: Duration = Duration::from_millis(20);

/// Longest wait for a computation to save its progress after Ctrl-C.
const SAVING: Duration = Duration::from_millis(100);

/// Longest wait for a computation to end after Ctrl-C. It then continues in the background until its next checkpoint.
const GRACE: Duration = Duration::from_millis(200);

/// Stack size of a thread, equal to the usual stack of the main thread; bytes.
const STACK_BYTES: usize = 8 << 20;

/// Interrupts of a computation by Ctrl-C.
#[derive(Clone, Debug, Default)]
pub struct Interrupt {
    /// Number of interrupts received.
    count: Arc<AtomicU8>,
    /// True if the computation saves its progress before it ends.
    saves: Arc<AtomicBool>,
}

impl Interrupt {
    /// Returns true after an interrupt.
    pub fn is_asked(&self) -> bool {
        self.count.load(Ordering::Relaxed) > 0
    }

    /// Allows the first interrupt to save the progress of the computation; the second interrupt ends it.
    pub fn save_first(&self) {
        self.saves.store(true, Ordering::Relaxed);
    }

    fn is_ended(&self) -> bool {
        self.count.load(Ordering::Relaxed) > u8::from(self.saves.load(Ordering::Relaxed))
    }

    fn ask(&self) {
        // Further requests have no effect.
        let count = self.count.load(Ordering::Relaxed);
        self.count.store((count + 1).min(2), Ordering::Relaxed);
    }

    /// Ends the computation even if its progress has not been saved.
    fn end(&self) {
        self.count.store(2, Ordering::Relaxed);
    }
}

/// Runs a computation that Ctrl-C ends at its next checkpoint.
pub fn answer<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    watched(py, |_| work())
}

/// Like [`answer`], for a computation that may save its progress before it ends.
pub fn watched<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(Interrupt) -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    let interrupt = Interrupt::default();
    let mut answers = begun(interrupt.clone(), work)?;
    let mut interrupted: Option<(PyErr, Instant)> = None;
    loop {
        let answer = received(py, &mut answers);
        match (answer, interrupted.take()) {
            (Some(_), Some((error, _))) => return Err(error),
            (Some(answer), None) => return Ok(answer?),
            (None, Some((error, since))) if since.elapsed() > GRACE => return Err(error),
            (None, waiting) => {
                if waiting
                    .as_ref()
                    .is_some_and(|(_, since)| since.elapsed() > SAVING)
                {
                    interrupt.end();
                }
                interrupted = waiting;
            }
        }
        if let Err(error) = py.check_signals() {
            interrupt.ask();
            interrupted.get_or_insert((error, Instant::now()));
        }
    }
}

/// Starts a computation in a separate thread.
fn begun<T: Send + 'static>(
    interrupt: Interrupt,
    work: impl FnOnce(Interrupt) -> Result<T, Failure> + Send + 'static,
) -> Result<Receiver<Result<T, Failure>>, Failure> {
    let (answered, answers) = channel();
    std::thread::Builder::new()
        .name("onset".to_owned())
        .stack_size(STACK_BYTES)
        .spawn(move || {
            let own = interrupt.clone();
            let work = || unless(move || own.is_ended(), || work(interrupt));
            let answer = catch_unwind(AssertUnwindSafe(|| {
                pool::shared(work, STACK_BYTES)?.unwrap_or(Err(Failure::Ended))
            }));
            // The receiver of a cancelled computation is gone.
            let _ = answered.send(answer.unwrap_or_else(|why| Err(told(&*why))));
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
    let text = why
        .downcast_ref::<String>()
        .map(String::as_str)
        .or_else(|| why.downcast_ref::<&str>().copied())
        .unwrap_or("for an unknown reason");
    Failure::Defect(format!(
        "internal error: {text}\n  hint: please report it with the call that caused it"
    ))
}
