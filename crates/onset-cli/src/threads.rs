//! Limits on the number of threads.

use crate::commands::Failure;
#[cfg(unix)]
use std::sync::{Arc, Mutex};
use std::thread::available_parallelism;

/// Largest useful number of threads per core; more threads only need more memory.
const THREADS_PER_CORE: usize = 8;
const VARIABLE: &str = "RAYON_NUM_THREADS";

/// Refuses an unreasonable number of threads.
pub fn check() -> Result<(), Failure> {
    let cores = available_parallelism().map_or(1, usize::from);
    let Ok(asked) = std::env::var(VARIABLE) else {
        return Ok(());
    };
    match admitted(&asked, cores) {
        Ok(()) => Ok(()),
        Err(most) => Err(Failure::input(format!(
            "{VARIABLE} is {asked}; expected a number of threads up to {most}, {THREADS_PER_CORE} for each of {cores} cores\n  \
             hint: unset {VARIABLE} for one thread per core"
        ))),
    }
}

/// Starts the threads of computations, fewer if a limit of the process admits no more. Without such limits they are started when they are needed.
///
/// # Errors
/// [`Failure`] if no thread can be started.
#[cfg(unix)]
pub fn start() -> Result<(), Failure> {
    use rustix::process::{Resource, getrlimit};
    /// Address space per thread: its stack, and room for its data.
    const SPACE: u64 = 16 << 20;
    /// Number of processes and threads of a user that limits nothing in practice.
    const MANY: u64 = 2048;
    let space = getrlimit(Resource::As).current;
    let processes = getrlimit(Resource::Nproc).current;
    if space.is_none() && processes.is_none_or(|most| most > MANY) {
        return Ok(());
    }
    let cores = available_parallelism().map_or(1, usize::from);
    let asked = std::env::var(VARIABLE).ok();
    let asked = asked.and_then(|asked| asked.parse().ok());
    let asked = asked.filter(|threads| *threads > 0).unwrap_or(cores);
    let admitted = space.map_or(asked, |space| (space / SPACE).max(1) as usize);
    let wanted = asked.min(admitted);
    let threads = match startable(wanted) {
        all if all == wanted => all,
        // Room for other data.
        some => (some / 2).max(some.min(1)),
    };
    let refused = || {
        Failure::input(
            "no thread can be started under the limits of this process
  hint: raise the limit of address space (ulimit -v, h_vmem) or of processes (ulimit -u)",
        )
    };
    if threads == 0 {
        return Err(refused());
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .stack_size(STACK);
    pool.build_global().map_err(|_| refused())
}

/// Stack size of a thread, the default of the standard library; bytes.
#[cfg(unix)]
const STACK: usize = 2 << 20;

/// Number of threads, up to a number, that can exist at the same time.
#[cfg(unix)]
fn startable(count: usize) -> usize {
    let gate = Arc::new(Mutex::new(()));
    let closed = gate.lock();
    let start = |_| {
        let gate = Arc::clone(&gate);
        let wait = move || drop(gate.lock());
        std::thread::Builder::new()
            .stack_size(STACK)
            .spawn(wait)
            .ok()
    };
    let threads: Vec<_> = (0..count).map_while(start).collect();
    let started = threads.len();
    drop(closed);
    for thread in threads {
        let _ = thread.join();
    }
    started
}

/// Restarts the program with few memory arenas if the address space is limited, as in batch systems.
///
/// The GNU allocator reserves 64 MiB for each thread. If it cannot, it loses time in failed attempts.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub fn fit_into_memory() {
    use rustix::process::{Resource, getrlimit};
    use std::os::unix::process::CommandExt;
    /// Address space per arena: four times its reservation, to leave room for other data.
    const ARENA: u64 = 256 << 20;
    const VARIABLE: &str = "MALLOC_ARENA_MAX";
    let (Some(limit), None) = (getrlimit(Resource::As).current, std::env::var_os(VARIABLE)) else {
        return;
    };
    if let Ok(program) = std::env::current_exe() {
        // Returns only if the program cannot be restarted; it then continues unchanged.
        let _ = std::process::Command::new(program)
            .args(std::env::args_os().skip(1))
            .env(VARIABLE, (limit / ARENA).clamp(1, 64).to_string())
            .exec();
    }
}

/// Returns the largest number of threads as an error if the requested number exceeds it. Zero or an empty text request one per core.
fn admitted(asked: &str, cores: usize) -> Result<(), usize> {
    let most = THREADS_PER_CORE * cores;
    if asked.is_empty() {
        return Ok(());
    }
    match asked.parse::<usize>() {
        Ok(threads) if threads <= most => Ok(()),
        _ => Err(most),
    }
}

#[cfg(test)]
mod tests {
    use super::admitted;

    #[test]
    fn up_to_eight_threads_per_core_are_accepted() {
        for asked in ["", "0", "1", "16"] {
            assert_eq!(admitted(asked, 2), Ok(()), "{asked}");
        }
        for asked in ["17", "100000", "-1", "many", "99999999999999999999999"] {
            assert_eq!(admitted(asked, 2), Err(16), "{asked}");
        }
    }
}
