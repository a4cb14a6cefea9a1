//! Interrupts (Ctrl-C, and the SIGTERM and SIGHUP of batch systems and closed terminals). They end a command at once, with all
//! processes and temporary folders that it has; a command that asks for it is told of the first, and finishes what it has begun.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

/// The exit code of an interrupted command, whatever the signal: 128 and the number of SIGINT.
pub const CODE: u8 = 130;

/// What is printed at the first interrupt by a command that finishes what it has begun.
static ANSWER: OnceLock<Option<&'static str>> = OnceLock::new();
static ASKED: AtomicBool = AtomicBool::new(false);

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

/// Lets the first interrupt only ask for an end; `told` is printed then.
///
/// # Errors
/// What the operating system says against it.
pub fn answer_with(told: Option<&'static str>) -> Result<(), ctrlc::Error> {
    // A command asks for this once.
    let _ = ANSWER.set(told);
    match listen_always() {
        Err(ctrlc::Error::MultipleHandlers) => Ok(()),
        listening => listening,
    }
}

fn listen_always() -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(|| match ANSWER.get() {
        Some(told) if !ASKED.swap(true, Ordering::Relaxed) => {
            if let Some(told) = told {
                crate::printing::tell(told);
            }
        }
        _ => {
            onset_umat::end_all();
            onset_study::output::end_all();
            std::process::exit(i32::from(CODE));
        }
    })
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
    ASKED.load(Ordering::Relaxed)
}
