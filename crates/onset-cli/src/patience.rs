//! Progress display on a terminal for answers that take longer than expected.

use crate::printing::is_quiet;
use indicatif::{ProgressBar, ProgressFinish, ProgressStyle};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// Delay before the display appears.
const DISPLAY_DELAY: Duration = Duration::from_secs(2);

static DISPLAYED: Mutex<Option<Patience>> = Mutex::new(None);

/// Starts a progress display that appears after two seconds, on a terminal only.
pub fn begin(doing: &'static str) {
    let shown = Patience::with(doing);
    DISPLAYED
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .replace(shown);
}

/// Clears display and bar; required before other output.
pub fn end() {
    drop(
        DISPLAYED
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take(),
    );
    if let Some(bar) = BAR.lock().unwrap_or_else(PoisonError::into_inner).take() {
        bar.finish_and_clear();
    }
}

/// Time between two updates of a bar.
const TICK: Duration = Duration::from_millis(200);

static BAR: Mutex<Option<ProgressBar>> = Mutex::new(None);

/// Progress bar for a number of steps, on a terminal only; it is cleared at its end.
pub fn bar(steps: u64, template: &str) -> ProgressBar {
    if is_quiet() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template(template);
    let bar = ProgressBar::new(steps)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        .with_finish(ProgressFinish::AndClear);
    bar.enable_steady_tick(TICK);
    BAR.lock()
        .unwrap_or_else(PoisonError::into_inner)
        .replace(bar.clone());
    bar
}

/// Progress display, shown until dropped.
struct Patience {
    done: Option<Sender<()>>,
    shown: Option<JoinHandle<()>>,
}

impl Patience {
    /// Display for an activity.
    fn with(doing: &'static str) -> Self {
        let (done, waiting) = channel::<()>();
        let shown = std::thread::Builder::new().spawn(move || {
            if waiting.recv_timeout(DISPLAY_DELAY) != Err(RecvTimeoutError::Timeout) {
                return;
            }
            let bar = ProgressBar::new_spinner().with_elapsed(DISPLAY_DELAY);
            let style = ProgressStyle::with_template("{spinner} {msg}: {elapsed} (Ctrl-C ends it)");
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()));
            bar.set_message(doing);
            bar.enable_steady_tick(TICK);
            // Waits until the sender is dropped.
            let _ = waiting.recv();
            bar.finish_and_clear();
        });
        Self {
            done: Some(done),
            shown: shown.ok(),
        }
    }
}

impl Drop for Patience {
    fn drop(&mut self) {
        self.done.take();
        // The line is cleared before the answer is printed.
        if let Some(shown) = self.shown.take() {
            let _ = shown.join();
        }
    }
}
