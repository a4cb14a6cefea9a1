//! Abuse of the programs: kills, signals, forks, damaged files, unusual arrays, incomplete requests and unusual terminals.
//!
//! Each program must end in time, without a panic or an abort, and leave complete files.

mod files;
mod lines;
mod running;
mod stores;
mod talk;

use crate::{python, wheel};
use running::{Fault, Place};
use std::path::PathBuf;
use std::process::Command;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// The programs under test.
pub(crate) struct Programs {
    /// Executable of the command.
    onset: PathBuf,
    /// Interpreter with the package, or `None` if there is no such interpreter.
    python: Option<PathBuf>,
}

impl Programs {
    pub(crate) fn onset(&self) -> Command {
        Command::new(&self.onset)
    }
}

/// Kind of abuse; each case runs in a separate folder.
struct Kind {
    name: &'static str,
    case: fn(&Programs, &Place, &mut Random) -> Result<(), Fault>,
    /// Number of counted cases in a run.
    count: u64,
}

const KINDS: &[Kind] = &[
    Kind {
        name: "command lines",
        case: lines::command_line,
        count: 1,
    },
    Kind {
        name: "formulas",
        case: lines::formula,
        count: 1,
    },
    Kind {
        name: "terminals",
        case: lines::terminal,
        count: 1,
    },
    Kind {
        name: "interrupts",
        case: stores::interrupted,
        count: 1,
    },
    Kind {
        name: "kills",
        case: stores::killed,
        count: 1,
    },
    Kind {
        name: "damaged files",
        case: files::damaged,
        count: 1,
    },
    Kind {
        name: "half requests",
        case: talk::half_requests,
        count: 1,
    },
];

const PYTHON: &[Kind] = &[
    Kind {
        name: "arrays and forks",
        case: talk::arrays,
        count: 1,
    },
    Kind {
        name: "formulas in one process",
        case: talk::formulas,
        count: talk::FORMULAS,
    },
];

/// Results of one kind of abuse.
#[derive(Default)]
struct Tally {
    cases: AtomicU64,
    faults: Mutex<Vec<Fault>>,
}

/// Abuses the programs for some minutes, with the tests' build of the command and the package of the last `cargo xtask python`.
///
/// # Errors
/// Description of the failures.
pub fn run(arguments: &[String]) -> Result<(), String> {
    let (mut time, mut seed, mut only) = (Duration::from_secs(180), 1, Vec::new());
    let usage = || {
        let names: Vec<&str> = KINDS.iter().chain(PYTHON).map(|kind| kind.name).collect();
        format!(
            "usage: cargo xtask abuse [--minutes N] [--seed N] [--kind NAME]...; kinds: {}",
            names.join(", ")
        )
    };
    let mut rest = arguments.iter();
    while let Some(argument) = rest.next() {
        let value = rest.next().ok_or_else(usage)?;
        match (argument.as_str(), value.parse::<f64>()) {
            ("--minutes", Ok(minutes)) if minutes > 0.0 && minutes < 1e6 => {
                time = Duration::from_secs_f64(60.0 * minutes);
            }
            ("--seed", Ok(number)) => seed = number as u64,
            ("--kind", _) => {
                let mut kinds = KINDS.iter().chain(PYTHON);
                only.push(kinds.find(|kind| kind.name == value).ok_or_else(usage)?);
            }
            _ => return Err(usage()),
        }
    }
    abused(time, seed, &only)
}

/// Abuses the programs for less than a minute, as part of the tests.
///
/// # Errors
/// Description of the failures.
pub fn test() -> Result<(), String> {
    abused(Duration::from_secs(45), 1, &[])
}

/// Abuses the programs in the given ways, or in all ways by default.
fn abused(time: Duration, seed: u64, only: &[&Kind]) -> Result<(), String> {
    let interpreter = python::interpreter("python");
    let has_package = |python: &PathBuf| {
        let import = Command::new(python).args(["-c", "import onset"]).output();
        import.is_ok_and(|output| output.status.success())
    };
    let programs = Programs {
        onset: wheel::command()?,
        python: interpreter.filter(has_package),
    };
    let mut kinds: Vec<&Kind> = match only {
        [] => KINDS.iter().chain(PYTHON).collect(),
        only => only.to_vec(),
    };
    if programs.python.is_none() {
        kinds.retain(|kind| PYTHON.iter().all(|own| own.name != kind.name));
        eprintln!(
            "== NOT TESTED: arrays and forks in Python. The package has not been built: cargo xtask python"
        );
    }
    eprintln!("== abuse: {} s, seed {seed}", time.as_secs());
    let tallies: Vec<Tally> = kinds.iter().map(|_| Tally::default()).collect();
    let (end, next) = (Instant::now() + time, AtomicU64::new(0));
    let work = || {
        while Instant::now() < end {
            let number = next.fetch_add(1, Ordering::Relaxed);
            let place = number as usize % kinds.len();
            let mut random = Random::new(seed, number);
            let outcome = Place::new(number)
                .and_then(|folder| (kinds[place].case)(&programs, &folder, &mut random));
            tallies[place]
                .cases
                .fetch_add(kinds[place].count, Ordering::Relaxed);
            if let Err(fault) = outcome {
                eprintln!("== {}, case {number}: {fault}", kinds[place].name);
                let mut faults = tallies[place]
                    .faults
                    .lock()
                    .unwrap_or_else(|held| held.into_inner());
                faults.push(fault);
            }
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| (0..threads).for_each(|_| drop(scope.spawn(work))));
    println!("{:<24} cases  hangs  aborts  torn files  messages", "");
    let mut all = [0; 5];
    for (kind, tally) in kinds.iter().zip(&tallies) {
        let faults = tally.faults.lock().unwrap_or_else(|held| held.into_inner());
        let of =
            |what: fn(&Fault) -> bool| faults.iter().filter(|fault| what(fault)).count() as u64;
        let counts = [
            tally.cases.load(Ordering::Relaxed),
            of(|fault| matches!(fault, Fault::Hang(_))),
            of(|fault| matches!(fault, Fault::Abort(_))),
            of(|fault| matches!(fault, Fault::Torn(_))),
            of(|fault| matches!(fault, Fault::Told(_))),
        ];
        row(kind.name, counts);
        for (sum, count) in all.iter_mut().zip(counts) {
            *sum += count;
        }
    }
    row("all", all);
    match all[1..].iter().sum::<u64>() {
        0 => Ok(()),
        faults => Err(format!(
            "{faults} faults; repeat with: cargo xtask abuse --seed {seed}"
        )),
    }
}

fn row(name: &str, [cases, hangs, aborts, torn, told]: [u64; 5]) {
    println!("{name:<24} {cases:>5}  {hangs:>5}  {aborts:>6}  {torn:>10}  {told:>8}");
}

/// Random numbers of a case: SplitMix64.
pub(crate) struct Random(u64);

impl Random {
    fn new(seed: u64, case: u64) -> Self {
        Self(seed.wrapping_mul(0x2545_F491_4F6C_DD1D) ^ case.wrapping_mul(0x9E37_79B9_7F4A_7C15))
    }

    pub(crate) fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub(crate) fn below(&mut self, bound: usize) -> usize {
        (self.word() % bound.max(1) as u64) as usize
    }

    pub(crate) fn of<'a, T: ?Sized>(&mut self, all: &[&'a T]) -> &'a T {
        all[self.below(all.len())]
    }

    /// Random time below the given number of milliseconds.
    pub(crate) fn pause(&mut self, most: usize) -> Duration {
        Duration::from_millis(self.below(most) as u64)
    }
}
