//! Cancellation of computations from outside.
//!
//! A caller starts a computation with [`unless`] and a condition. Long loops, in this crate and in crates that build on it, call [`checkpoint`]: once
//! the condition holds, it unwinds to the caller without a message. Without a condition a checkpoint costs a few nanoseconds.
//!
//! Threads that share the work do not inherit the condition; a [`Scope`] passes it to them.
//!
//! ```
//! use onset::cancel::{checkpoint, unless};
//! use std::time::{Duration, Instant};
//! let end = Instant::now() + Duration::from_millis(10);
//! let endless = || loop {
//!     checkpoint();
//! };
//! assert_eq!(unless(move || Instant::now() > end, endless), None::<()>);
//! assert_eq!(unless(|| false, || 1), Some(1));
//! ```

use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;

/// Returns true once the computation must end. All threads poll it often.
type Condition = Arc<dyn Fn() -> bool + Send + Sync>;

thread_local! {
    static CURRENT: RefCell<Option<Condition>> = const { RefCell::new(None) };
}

/// Payload of the unwinding.
struct Cancelled;

/// Runs a computation until the condition holds; returns `None` if it was ended. Conditions can be nested: a computation ends if any of them holds.
pub fn unless<T>(
    is_ended: impl Fn() -> bool + Send + Sync + 'static,
    work: impl FnOnce() -> T,
) -> Option<T> {
    let condition: Condition = match Scope::current().0 {
        Some(outer) => Arc::new(move || outer() || is_ended()),
        None => Arc::new(is_ended),
    };
    let scope = Scope(Some(condition));
    match catch_unwind(AssertUnwindSafe(|| scope.run(work))) {
        Ok(done) => Some(done),
        Err(why) if why.is::<Cancelled>() => None,
        Err(why) => resume_unwind(why),
    }
}

/// Ends the current computation if its condition holds.
#[inline]
pub fn checkpoint() {
    let is_ended = CURRENT.with_borrow(|current| current.as_ref().is_some_and(|own| own()));
    // Destructors that run while another panic unwinds must not unwind.
    if is_ended && !std::thread::panicking() {
        resume_unwind(Box::new(Cancelled));
    }
}

/// Condition of a computation, which can be passed to other threads.
#[derive(Clone, Default)]
pub struct Scope(Option<Condition>);

impl Scope {
    /// Returns the scope of the current thread.
    pub fn current() -> Self {
        Self(CURRENT.with_borrow(Clone::clone))
    }

    /// Runs a part of the computation on this thread.
    pub fn run<T>(&self, work: impl FnOnce() -> T) -> T {
        /// Guard that restores the previous condition of the thread, even if the work unwinds.
        struct Before(Option<Condition>);
        impl Drop for Before {
            fn drop(&mut self) {
                CURRENT.set(self.0.take());
            }
        }
        let _before = Before(CURRENT.replace(self.0.clone()));
        checkpoint();
        work()
    }
}

#[cfg(test)]
mod tests {
    use super::{Scope, checkpoint, unless};
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};

    #[test]
    fn canceling_a_computation_ends_its_work_on_other_threads_and_no_other_work() {
        let is_ended = Arc::new(AtomicBool::new(false));
        let condition = Arc::clone(&is_ended);
        let ended = unless(
            move || condition.load(Ordering::Relaxed),
            || {
                let scope = Scope::current();
                let helper = std::thread::spawn(move || {
                    scope.run(|| {
                        loop {
                            checkpoint();
                            std::thread::yield_now();
                        }
                    })
                });
                assert_eq!(unless(|| false, || 2), Some(2));
                is_ended.store(true, Ordering::Relaxed);
                assert!(helper.join().is_err());
                // Another computation, on a thread of the canceled one, is not canceled.
                Scope::default().run(checkpoint);
                checkpoint();
            },
        );
        assert_eq!(ended, None);
        checkpoint();
    }

    #[test]
    fn other_panics_are_propagated() {
        let work = || unless(|| false, || std::panic::resume_unwind(Box::new("other")));
        let why = std::panic::catch_unwind(work).expect_err("a panic");
        assert_eq!(why.downcast_ref(), Some(&"other"));
    }
}
