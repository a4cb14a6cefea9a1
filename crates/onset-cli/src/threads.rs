//! How many threads work at once.

use crate::commands::Failure;
use std::thread::available_parallelism;

/// Threads for each core beyond which more only cost memory.
const THREADS_PER_CORE: usize = 8;
const VARIABLE: &str = "RAYON_NUM_THREADS";

/// Refuses a number of threads that the machine has no use for.
pub fn check() -> Result<(), Failure> {
    let cores = available_parallelism().map_or(1, usize::from);
    let Ok(asked) = std::env::var(VARIABLE) else {
        return Ok(());
    };
    match admitted(&asked, cores) {
        Ok(()) => Ok(()),
        Err(most) => Err(Failure::input(format!(
            "{VARIABLE} is {asked}; expected a number of threads up to {most}, {THREADS_PER_CORE} for each of {cores} cores\n  \
             hint: leave it out, and there is one for each core"
        ))),
    }
}

/// Begins anew with few memory arenas where the address space is limited, as batch systems limit it: the GNU allocator reserves 64 MiB for each
/// thread, and spends all time on trying to where it cannot.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub fn fit_into_memory() {
    use rustix::process::{Resource, getrlimit};
    use std::os::unix::process::CommandExt;
    /// Address space for each arena: four times what it reserves, since the rest needs room too.
    const ARENA: u64 = 256 << 20;
    const VARIABLE: &str = "MALLOC_ARENA_MAX";
    let (Some(limit), None) = (getrlimit(Resource::As).current, std::env::var_os(VARIABLE)) else {
        return;
    };
    if let Ok(program) = std::env::current_exe() {
        // It returns only if the program cannot be started again; then it goes on as it is.
        let _ = std::process::Command::new(program)
            .args(std::env::args_os().skip(1))
            .env(VARIABLE, (limit / ARENA).clamp(1, 64).to_string())
            .exec();
    }
}

/// The largest number of threads, where another one was asked for. Zero, and nothing, stand for one for each core.
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
    fn up_to_eight_threads_for_each_core_are_admitted() {
        for asked in ["", "0", "1", "16"] {
            assert_eq!(admitted(asked, 2), Ok(()), "{asked}");
        }
        for asked in ["17", "100000", "-1", "many", "99999999999999999999999"] {
            assert_eq!(admitted(asked, 2), Err(16), "{asked}");
        }
    }
}
