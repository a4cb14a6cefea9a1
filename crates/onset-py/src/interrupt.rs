//! Questions are answered in threads of their own, without the interpreter's lock, and end with Ctrl-C.

use crate::failure::Failure;
use crate::pool;
use pyo3::prelude::*;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// How often signals are looked for.
const LOOK: Duration = Duration::from_millis(50);

/// Longest wait for a question to end after Ctrl-C. One that is inside a long computation ends in the background, at the next point at
/// which it can.
const GRACE: Duration = Duration::from_millis(200);

/// As much as the first thread of a program has.
const STACK: usize = 8 << 20;

/// How many times a question was asked to end.
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Arc<AtomicU8>);

/// What unwinds a question that is given up; no panic, and told by no hook.
struct GivenUp;

impl Interrupt {
    /// Whether an end was asked for.
    pub fn is_asked(&self) -> bool {
        self.0.load(Ordering::Relaxed) > 0
    }

    /// Whether an end was asked for twice.
    pub fn is_asked_twice(&self) -> bool {
        self.0.load(Ordering::Relaxed) > 1
    }

    /// Gives the question up where an end was asked for.
    pub fn end_if_asked(&self) {
        self.end_from(1);
    }

    /// Gives the question up where an end was asked for twice: for what finishes at the first what it has begun.
    pub fn end_if_asked_twice(&self) {
        self.end_from(2);
    }

    fn end_from(&self, times: u8) {
        if self.0.load(Ordering::Relaxed) >= times {
            resume_unwind(Box::new(GivenUp));
        }
    }

    fn ask(&self) {
        // A third time says nothing new.
        self.0.store(
            self.0.load(Ordering::Relaxed).saturating_add(1).min(2),
            Ordering::Relaxed,
        );
    }
}

/// Answers a question that cannot be ended from within: with Ctrl-C nobody waits for it any longer.
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

/// Answers a question that looks whether it is to end. After Ctrl-C it has [`GRACE`] to do so.
pub fn ending<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(Interrupt) -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    until(py, Some(GRACE), work)
}

/// Answers a question that writes what it has done when it is asked to end, and has ended when this returns.
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

/// Begins to answer.
fn begun<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, Failure> + Send + 'static,
) -> Result<Receiver<Result<T, Failure>>, Failure> {
    let (answered, answers) = channel();
    std::thread::Builder::new()
        .name("onset".to_owned())
        .stack_size(STACK)
        .spawn(move || {
            let answer = catch_unwind(AssertUnwindSafe(|| pool::shared(work, STACK)?))
                .unwrap_or_else(|why| Err(told(&*why)));
            // Nobody waits for a question that was given up.
            let _ = answered.send(answer);
        })
        .map_err(|error| Failure::machine(format!("cannot start a thread: {error}")))?;
    Ok(answers)
}

/// The answer, if it is there before signals are to be looked for.
fn received<T: Send>(
    py: Python<'_>,
    answers: &mut Receiver<Result<T, Failure>>,
) -> Option<Result<T, Failure>> {
    match py.detach(move || answers.recv_timeout(LOOK)) {
        Ok(answer) => Some(answer),
        Err(RecvTimeoutError::Timeout) => None,
        Err(RecvTimeoutError::Disconnected) => Some(Err(Failure::Ended)),
    }
}

/// Why a question was not answered.
fn told(why: &(dyn Any + Send)) -> Failure {
    if why.is::<GivenUp>() {
        return Failure::Ended;
    }
    let text = why
        .downcast_ref::<String>()
        .map(String::as_str)
        .or_else(|| why.downcast_ref::<&str>().copied())
        .unwrap_or("for a reason that was not told");
    Failure::Defect(format!(
        "this question cannot be answered because of a defect: {text}\n  hint: please report it with what was asked"
    ))
}
