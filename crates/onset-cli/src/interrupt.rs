//! Interrupts (Ctrl-C, and the SIGTERM and SIGHUP of batch systems and closed terminals). They end a command at once, with all
//! processes and temporary folders that it has; a command that asks for it is told of the first, and finishes what it has begun.

use crate::printing::tell;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// The exit code of an interrupted command, whatever the signal: 128 and the number of SIGINT.
pub const CODE: u8 = 130;

/// How a command that finishes what it has begun answers interrupts.
#[derive(Clone, Debug, Default)]
pub struct Answer {
    /// What is printed at the first.
    pub told: Option<&'static str>,
    /// What is printed where the command is ended at once: by a second one, or because it takes too long.
    pub at_end: Option<String>,
    /// How long after the first it is ended at once, unless it has ended by itself.
    pub patience: Option<Duration>,
}

static ANSWER: OnceLock<Answer> = OnceLock::new();
/// When the first interrupt came.
static SINCE: OnceLock<Instant> = OnceLock::new();
/// Whether the command is about to end by itself.
static IS_ENDING: AtomicBool = AtomicBool::new(false);

/// Listens for interrupts from now on to the end; not where a closed terminal is to be ignored, as with `nohup`, because whoever
/// listens hears that too.
///
/// # Errors
/// What the operating system says against it.
pub fn listen() -> Result<(), ctrlc::Error> {
    if is_hangup_ignored() {
        return Ok(());
    }
    listen_always()
}

/// Lets the first interrupt only ask for an end.
///
/// # Errors
/// What the operating system says against it.
pub fn answer_with(answer: Answer) -> Result<(), ctrlc::Error> {
    // A command asks for this once.
    let _ = ANSWER.set(answer);
    match listen_always() {
        Err(ctrlc::Error::MultipleHandlers) => Ok(()),
        listening => listening,
    }
}

fn listen_always() -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(|| match ANSWER.get() {
        Some(answer) if SINCE.set(Instant::now()).is_ok() => {
            if let Some(told) = answer.told {
                tell(told);
            }
            if let Some(patience) = answer.patience {
                std::thread::spawn(move || {
                    std::thread::sleep(patience);
                    if !IS_ENDING.load(Ordering::Relaxed) {
                        end_at_once(Some(answer));
                    }
                });
            }
        }
        answer => end_at_once(answer),
    })
}

fn end_at_once(answer: Option<&Answer>) -> ! {
    if let Some(told) = answer.and_then(|answer| answer.at_end.as_ref()) {
        tell(told);
    }
    onset_umat::end_all();
    onset_study::output::end_all();
    std::process::exit(i32::from(CODE));
}

/// Whether SIGHUP, signal 1, is ignored, as far as the system tells.
fn is_hangup_ignored() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask & 1 == 1)
}

/// Whether an end has been asked for.
pub fn is_asked() -> bool {
    SINCE.get().is_some()
}

/// How long ago an end was asked for, if it was.
pub fn asked_for() -> Option<Duration> {
    SINCE.get().map(Instant::elapsed)
}

/// From now on the command ends by itself, and has the time that this takes.
pub fn is_ending() {
    IS_ENDING.store(true, Ordering::Relaxed);
}
