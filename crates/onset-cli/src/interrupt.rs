//! Interrupts (Ctrl-C, and the SIGTERM and SIGHUP of batch systems and closed terminals): the first asks for an end, the second
//! ends at once.

use std::sync::atomic::{AtomicBool, Ordering};

/// The exit code of an interrupted command, whatever the signal: 128 and the number of SIGINT.
pub const CODE: u8 = 130;

static ASKED: AtomicBool = AtomicBool::new(false);

/// Listens for interrupts; `told` is printed at the first.
///
/// # Errors
/// What the operating system says against it.
pub fn listen(told: Option<&'static str>) -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(move || {
        if ASKED.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(CODE));
        }
        if let Some(told) = told {
            crate::commands::tell(told);
        }
    })
}

/// Whether an end has been asked for.
pub fn is_asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}
