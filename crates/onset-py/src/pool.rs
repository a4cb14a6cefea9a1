//! Thread pools for parallel computations.
//!
//! A forked process does not inherit the threads of its parent and would wait for them forever; it therefore creates a new pool. While a Python law
//! is being evaluated, all threads of the shared pool may be waiting for it; a computation started by such a law therefore runs in a separate thread.

use crate::failure::Failure;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, TryLockError};
use std::time::Duration;

/// Process that loaded the module, which owns the global pool of rayon.
static LOADED_BY: OnceLock<u32> = OnceLock::new();
/// Pool of a forked process, with the identifier of the process.
static FORKED: Mutex<Owned> = Mutex::new(None);
type Owned = Option<(u32, Arc<ThreadPool>)>;
/// Number of evaluations of Python laws in progress.
static EVALUATIONS: AtomicUsize = AtomicUsize::new(0);

/// Records the process that owns the global pool.
pub fn loaded() {
    LOADED_BY.get_or_init(std::process::id);
}

/// Evaluates a Python law, which may start computations itself.
pub fn evaluating<T>(work: impl FnOnce() -> T) -> T {
    /// Guard that counts down even if the evaluation unwinds.
    struct Evaluation;
    impl Drop for Evaluation {
        fn drop(&mut self) {
            EVALUATIONS.fetch_sub(1, Ordering::Relaxed);
        }
    }
    EVALUATIONS.fetch_add(1, Ordering::Relaxed);
    let _evaluation = Evaluation;
    work()
}

/// Runs work on a pool whose threads exist in this process and do not wait for this work.
///
/// # Errors
/// [`Failure`] if no thread can be started.
pub fn shared<T: Send>(work: impl FnOnce() -> T + Send, stack: usize) -> Result<T, Failure> {
    let made = |threads| {
        ThreadPoolBuilder::new()
            .num_threads(threads)
            .stack_size(stack)
            .build()
            .map_err(|error| Failure::machine(format!("cannot start threads: {error}")))
    };
    if EVALUATIONS.load(Ordering::Relaxed) > 0 {
        return Ok(made(1)?.install(work));
    }
    let process = std::process::id();
    if LOADED_BY
        .get()
        .is_none_or(|loaded_by| *loaded_by == process)
    {
        return Ok(work());
    }
    let pool = match held() {
        // The thread that held the lock at the time of the fork does not exist here.
        None => Arc::new(made(0)?),
        Some(mut held) => match &*held {
            Some((owner, pool)) if *owner == process => Arc::clone(pool),
            _ => {
                let pool = Arc::new(made(0)?);
                // Dropping the pool of another process would wait for its threads.
                std::mem::forget(held.replace((process, Arc::clone(&pool))));
                pool
            }
        },
    };
    Ok(pool.install(work))
}

/// Pool of a forked process, or `None` if its lock is not released within a second.
fn held() -> Option<MutexGuard<'static, Owned>> {
    for _ in 0..100 {
        match FORKED.try_lock() {
            Ok(held) => return Some(held),
            Err(TryLockError::Poisoned(held)) => return Some(held.into_inner()),
            Err(TryLockError::WouldBlock) => std::thread::sleep(Duration::from_millis(10)),
        }
    }
    None
}
