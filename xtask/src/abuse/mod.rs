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

/// Kind of abuse; each case runs in a separate folder, and returns the number of counted events.
struct Kind {
    name: &'static str,
    case: fn(&Programs, &Place, &mut Random) -> Result<u64, Fault>,
    /// Number of events in a run with `--proof`.
    proof: u64,
}

impl Kind {
    const fn new(
        name: &'static str,
        proof: u64,
        case: fn(&Programs, &Place, &mut Random) -> Result<u64, Fault>,
    ) -> Self {
        Self { name, case, proof }
    }
}

const KINDS: &[Kind] = &[
    Kind::new("command lines", 100_000, lines::command_line),
    Kind::new("formulas", 10_000, lines::formula),
    Kind::new("terminals", 1_000, lines::terminal),
    Kind::new("interrupts", 500, stores::interrupted),
    Kind::new("kills", 2_000, stores::killed),
    Kind::new("damaged files", 2_000, files::damaged),
    Kind::new("half requests", 200, talk::half_requests),
];

const PYTHON: &[Kind] = &[
    Kind::new("arrays", 10_000, talk::arrays),
    Kind::new("forks", 1_000, talk::forks),
    Kind::new("interrupts of calls", 500, talk::interrupts),
    Kind::new("formulas of one process", 1_000_000, talk::formulas),
];

/// Time between two tables of interim results.
const BETWEEN_TABLES: Duration = Duration::from_secs(300);

/// Results of one kind of abuse.
#[derive(Default)]
struct Tally {
    events: AtomicU64,
    faults: Mutex<Vec<Fault>>,
    /// Longest time from a signal to the end of a program; milliseconds.
    slowest: AtomicU64,
}

/// End of a run, at the earlier of two.
#[derive(Clone, Copy, Default)]
struct Until {
    time: Option<Duration>,
    /// Whether each kind ends at its number of events for a proof.
    is_proof: bool,
}

/// Abuses the programs, with the tests' build of the command and the package of the last `cargo xtask python`.
///
/// # Errors
/// Description of the failures.
pub fn run(arguments: &[String]) -> Result<(), String> {
    let (mut until, mut seed, mut only) = (Until::default(), 1, Vec::new());
    let mut command = None;
    let usage = || {
        let names: Vec<&str> = KINDS.iter().chain(PYTHON).map(|kind| kind.name).collect();
        format!(
            "usage: cargo xtask abuse [--minutes N] [--proof] [--seed N] [--command EXECUTABLE] [--kind NAME]...; kinds: {}",
            names.join(", ")
        )
    };
    let mut rest = arguments.iter();
    while let Some(argument) = rest.next() {
        if argument == "--proof" {
            until.is_proof = true;
            continue;
        }
        let value = rest.next().ok_or_else(usage)?;
        match (argument.as_str(), value.parse::<f64>()) {
            ("--minutes", Ok(minutes)) if minutes > 0.0 && minutes < 1e6 => {
                until.time = Some(Duration::from_secs_f64(60.0 * minutes));
            }
            ("--seed", Ok(number)) => seed = number as u64,
            ("--command", _) => command = Some(value),
            ("--kind", _) => {
                let mut kinds = KINDS.iter().chain(PYTHON);
                only.push(kinds.find(|kind| kind.name == value).ok_or_else(usage)?);
            }
            _ => return Err(usage()),
        }
    }
    if !until.is_proof {
        until.time.get_or_insert(Duration::from_secs(180));
    }
    let onset = match command {
        Some(path) => std::path::absolute(path).map_err(|error| error.to_string())?,
        None => wheel::command()?,
    };
    abused(onset, until, seed, &only)
}

/// Abuses the programs for less than a minute, as part of the tests.
///
/// # Errors
/// Description of the failures.
pub fn test() -> Result<(), String> {
    let until = Until {
        time: Some(Duration::from_secs(45)),
        is_proof: false,
    };
    abused(wheel::command()?, until, 1, &[])
}

/// Abuses the programs in the given ways, or in all ways by default.
fn abused(onset: PathBuf, until: Until, seed: u64, only: &[&Kind]) -> Result<(), String> {
    let interpreter = python::interpreter("python");
    let has_package = |python: &PathBuf| {
        let import = Command::new(python).args(["-c", "import onset"]).output();
        import.is_ok_and(|output| output.status.success())
    };
    let programs = Programs {
        onset,
        python: interpreter.filter(has_package),
    };
    let mut kinds: Vec<&Kind> = match only {
        [] => KINDS.iter().chain(PYTHON).collect(),
        only => only.to_vec(),
    };
    if programs.python.is_none() {
        kinds.retain(|kind| PYTHON.iter().all(|own| own.name != kind.name));
        eprintln!(
            "== NOT TESTED: arrays, forks and interrupts in Python. The package has not been built: cargo xtask python"
        );
    }
    let time = until.time.map(|time| format!("{} s, ", time.as_secs()));
    let proof = if until.is_proof {
        "up to the numbers of a proof, "
    } else {
        ""
    };
    eprintln!("== abuse: {}{proof}seed {seed}", time.unwrap_or_default());
    let tallies: Vec<Tally> = kinds.iter().map(|_| Tally::default()).collect();
    let (begun, next) = (Instant::now(), AtomicU64::new(0));
    let is_open = |place: usize| {
        let events = tallies[place].events.load(Ordering::Relaxed);
        until.time.is_none_or(|time| begun.elapsed() < time)
            && !(until.is_proof && events >= kinds[place].proof)
    };
    let work = || {
        while (0..kinds.len()).any(is_open) {
            let number = next.fetch_add(1, Ordering::Relaxed);
            let place = number as usize % kinds.len();
            if is_open(place) {
                let random = Random::new(seed, number);
                worked(&programs, kinds[place], &tallies[place], number, random);
            }
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        let mut told = Instant::now();
        while workers.iter().any(|worker| !worker.is_finished()) {
            std::thread::sleep(Duration::from_millis(50));
            if told.elapsed() > BETWEEN_TABLES {
                told = Instant::now();
                println!("after {} min", begun.elapsed().as_secs() / 60);
                table(&kinds, &tallies);
            }
        }
    });
    match table(&kinds, &tallies) {
        0 => Ok(()),
        faults => Err(format!(
            "{faults} faults; repeat with: cargo xtask abuse --seed {seed}"
        )),
    }
}

/// Prints the events, the faults and the slowest end of each kind, and returns the number of faults.
fn table(kinds: &[&Kind], tallies: &[Tally]) -> u64 {
    println!(
        "{:<24} {:>7}  hangs  aborts  torn files  messages  slowest end",
        "", "events"
    );
    let mut all = [0; 6];
    for (kind, tally) in kinds.iter().zip(tallies) {
        let faults = tally.faults.lock().unwrap_or_else(|held| held.into_inner());
        let of =
            |what: fn(&Fault) -> bool| faults.iter().filter(|fault| what(fault)).count() as u64;
        let counts = [
            tally.events.load(Ordering::Relaxed),
            of(|fault| matches!(fault, Fault::Hang(_))),
            of(|fault| matches!(fault, Fault::Abort(_))),
            of(|fault| matches!(fault, Fault::Torn(_))),
            of(|fault| matches!(fault, Fault::Told(_))),
            tally.slowest.load(Ordering::Relaxed),
        ];
        row(kind.name, counts);
        for (sum, count) in all.iter_mut().zip(counts).take(5) {
            *sum += count;
        }
        all[5] = all[5].max(counts[5]);
    }
    row("all", all);
    all[1..5].iter().sum()
}

/// Runs a case and counts its events and faults.
fn worked(programs: &Programs, kind: &Kind, tally: &Tally, number: u64, mut random: Random) {
    let counted = Place::new(number).and_then(|folder| {
        let outcome = (kind.case)(programs, &folder, &mut random);
        let slowest = folder.slowest().as_millis() as u64;
        tally.slowest.fetch_max(slowest, Ordering::Relaxed);
        outcome
    });
    let events = match counted {
        Ok(events) => events,
        Err(fault) => {
            eprintln!("== {}, case {number}: {fault}", kind.name);
            let faults = tally.faults.lock();
            faults.unwrap_or_else(|held| held.into_inner()).push(fault);
            1
        }
    };
    tally.events.fetch_add(events, Ordering::Relaxed);
}

fn row(name: &str, [events, hangs, aborts, torn, told, slowest]: [u64; 6]) {
    let slowest = match slowest {
        0 => "-".to_owned(),
        slowest => format!("{:.2} s", slowest as f64 / 1000.0),
    };
    println!(
        "{name:<24} {events:>7}  {hangs:>5}  {aborts:>6}  {torn:>10}  {told:>8}  {slowest:>11}"
    );
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
