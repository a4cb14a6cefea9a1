//! Interrupts: Ctrl-C, and the SIGTERM and SIGHUP of batch systems and closed terminals.
//!
//! By default they end the command immediately, with its child processes and temporary folders. A command may instead handle the first interrupt and
//! finish started work.

use crate::patience;
use crate::printing::tell;
use std::io;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Exit code of an interrupted command for any signal: 128 plus the number of SIGINT.
pub const CODE: u8 = 130;

/// Response to interrupts of a command that finishes started work.
#[derive(Clone, Debug, Default)]
pub struct Answer {
    /// Message if the command is ended immediately, by a second interrupt or because it takes too long; `None` for no message.
    pub at_end: Option<String>,
    /// Longest time from the first interrupt to the end of the command.
    pub patience: Duration,
}

static ANSWER: OnceLock<Answer> = OnceLock::new();
/// Time of the first interrupt.
static SINCE: OnceLock<Instant> = OnceLock::new();
/// Whether the command is about to end by itself.
static IS_ENDING: AtomicBool = AtomicBool::new(false);

/// Handles interrupts until the process ends. A SIGHUP that is ignored, as with `nohup`, stays ignored.
///
/// # Errors
/// The error of the operating system.
#[cfg(unix)]
pub fn listen() -> io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let mut watched = vec![SIGINT, SIGTERM];
    if !is_hangup_ignored() {
        watched.push(SIGHUP);
    }
    let mut signals = signal_hook::iterator::Signals::new(watched)?;
    let listening = std::thread::Builder::new().name("interrupts".to_owned());
    listening.spawn(move || signals.forever().for_each(|_| interrupted()))?;
    Ok(())
}

/// Handles interrupts until the process ends.
///
/// # Errors
/// The error of the operating system.
#[cfg(not(unix))]
pub fn listen() -> io::Result<()> {
    ctrlc::set_handler(interrupted).map_err(io::Error::other)
}

/// Handles the first interrupt as a request to end.
pub fn answer_with(answer: Answer) {
    // A command sets its answer once.
    let _ = ANSWER.set(answer);
}

fn interrupted() {
    match ANSWER.get() {
        Some(answer) if SINCE.set(Instant::now()).is_ok() => {
            let patience = answer.patience;
            let waiting = std::thread::Builder::new().spawn(move || {
                std::thread::sleep(patience);
                if !IS_ENDING.load(Ordering::Relaxed) {
                    end_at_once(Some(answer));
                }
            });
            // A limit of the process may admit no other thread.
            if waiting.is_err() {
                end_at_once(Some(answer));
            }
        }
        answer => end_at_once(answer),
    }
}

/// Time limit for the end of the process, since a message may block on a full pipe.
const END: Duration = Duration::from_millis(200);

fn end_at_once(answer: Option<&Answer>) -> ! {
    onset_umat::end_all();
    onset_study::output::end_all();
    // Without a further thread, a blocked message delays the end.
    let _ = std::thread::Builder::new().spawn(|| {
        std::thread::sleep(END);
        std::process::exit(i32::from(CODE));
    });
    patience::end();
    if let Some(told) = answer.and_then(|answer| answer.at_end.as_ref()) {
        tell(told);
    }
    std::process::exit(i32::from(CODE));
}

/// Returns true if SIGHUP, signal 1, is known to be ignored.
#[cfg(unix)]
fn is_hangup_ignored() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask & 1 == 1)
}

/// Returns true after the first interrupt.
pub fn is_asked() -> bool {
    SINCE.get().is_some()
}

/// Disables the time limit, because the command is about to end by itself.
pub fn is_ending() {
    IS_ENDING.store(true, Ordering::Relaxed);
}
