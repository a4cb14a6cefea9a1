//! Limits on the number of threads.

use crate::commands::Failure;
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
