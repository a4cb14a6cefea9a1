//! Interrupts and kills at any time: written files are complete, and a resumed command produces the same bytes.

use super::running::{Fault, HANGUP, INTERRUPT, KILL, Place, TERMINATE, is_ignored};
use super::{Programs, Random};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

const STUDY: &str = "[discretization]\nsupport = 1.6\n[[axes]]\nquantity = \"stretch-1\"\nrange = [0.8, 1.6]\nstates = 40\n[[axes]]\nquantity = \"stretch-2\"\nrange = [0.8, 1.6]\nstates = 36\n[map]\ntile = 8\n";
const COMPARISON: &str = "[compare]\nstretches = [0.95, 1.05]\nstates = 4\ntension = 1.1\ncompression = 0.9\n[[methods]]\nname = \"nodes\"\nlattice = \"square\"\nquadrature = \"nodal\"\n[[methods]]\nname = \"sph\"\nmethod = \"updated-sph\"\n";
const IRREGULAR: &str = "[compare]\nstretches = [0.9, 1.1]\nstates = 6\n[[methods]]\nname = \"irregular\"\nmethod = \"updated-sph\"\ncells = 6\nperturbation = 0.1\n";

/// Command lines that take longer than a test.
const SLOW_COMMANDS: &[&str] = &[
    "state --stretch 1.1,0.9 --set discretization.method=updated-sph --set discretization.cells=12 --set discretization.perturbation=0.1",
    "modes --set discretization.method=updated-sph --set discretization.cells=8 --set discretization.perturbation=0.1 --out out",
    "dispersion --stretch 1.1,0.9 --path --set discretization.method=updated-sph --set discretization.cells=8 --set discretization.perturbation=0.1 --out out",
    "tune discretization.penalty --set discretization.method=tlsph --set discretization.cells=5 --set discretization.perturbation=0.1 --out out",
    "compare irregular.toml --out out",
    "boundary study.toml --set discretization.method=updated-sph --set discretization.cells=4 --set discretization.perturbation=0.1 --out out",
    "map study.toml --set discretization.method=updated-sph --set discretization.cells=8 --set discretization.perturbation=0.1 --out out",
    "card --set material.model=ogden --out out",
    "criteria --set material.model=ogden --out out",
    "simulate body.toml --steps 50 --out out",
    "simulate --stretch 1.1,1 --set discretization.method=updated-sph --cells 60,60 --steps 2000 --out out",
    "explore --no-browser",
    "fit tests.csv --starts 10000 --out out",
    "screen run.csv study.toml --out out",
    "path --mode uniaxial --to 3 --set discretization.method=updated-sph --set discretization.cells=6 --set discretization.perturbation=0.1 --out out",
    "limit --time-step 1e-3 --vary material.c1 --set discretization.method=updated-sph --set discretization.cells=6 --set discretization.perturbation=0.1 --stretch 1.1,1",
    "recommend --stretches 0.3,3",
    "audit --set material.model=ogden",
    "localize --model gurson",
    "zoo",
];

/// Checks that a signal at any time ends a command soon, without incomplete files.
pub(super) fn interrupted(
    programs: &Programs,
    place: &Place,
    random: &mut Random,
) -> Result<u64, Fault> {
    place.write("study.toml", STUDY)?;
    place.write("irregular.toml", IRREGULAR)?;
    place.write("tests.csv", super::files::TESTS)?;
    place.write("run.csv", super::files::run_as_table())?;
    place.write(
        "body.toml",
        "[discretization]\nmethod = \"total-lagrangian-sph\"\nlattice = \"square\"\n[body]\nshape = \"bar\"\nsize = [300, 300]\n",
    )?;
    let mut running = place.started(words(programs, random.of(SLOW_COMMANDS)))?;
    if running.ends_within(random.pause(1500))?.is_some() {
        return running.ended().map(|_| 0);
    }
    let mut signals = vec![INTERRUPT, TERMINATE, HANGUP];
    signals.retain(|signal| !is_ignored(*signal));
    running.signal(signals[random.below(signals.len())])?;
    running.ended()?;
    no_rest(place.path())?;
    Ok(1)
}

/// Commands that write files, each with the command that resumes it.
const KILLED: &[(&str, &str)] = &[
    (
        "map study.toml --out out",
        "map study.toml --out out --resume",
    ),
    (
        "compare compare.toml --quiet --out out",
        "compare compare.toml --quiet --out out",
    ),
    (
        "simulate --stretch 1.1,1 --set discretization.method=updated-sph --cells 10,10 --steps 3000 --checkpoint 100 --out out",
        "simulate --stretch 1.1,1 --set discretization.method=updated-sph --cells 10,10 --steps 3000 --checkpoint 100 --out out --resume",
    ),
];

/// Undisturbed run of a command.
struct Whole {
    code: Option<i32>,
    files: BTreeMap<String, Vec<u8>>,
    time: Duration,
}

/// Undisturbed runs of the commands that are killed, each made once.
static UNDISTURBED_RUNS: Mutex<BTreeMap<usize, Arc<Whole>>> = Mutex::new(BTreeMap::new());

fn whole(programs: &Programs, number: usize, random: &mut Random) -> Result<Arc<Whole>, Fault> {
    let mut all = UNDISTURBED_RUNS
        .lock()
        .unwrap_or_else(PoisonError::into_inner);
    if let Some(made) = all.get(&number) {
        return Ok(Arc::clone(made));
    }
    let place = Place::new(random.word())?;
    killable(&place)?;
    let begun = Instant::now();
    let ended = place.started(words(programs, KILLED[number].0))?.ended()?;
    let made = Arc::new(Whole {
        code: ended.code,
        files: tree(&place.path().join("out"))?,
        time: begun.elapsed(),
    });
    all.insert(number, Arc::clone(&made));
    Ok(made)
}

/// Writes the studies of the commands that are killed.
fn killable(place: &Place) -> Result<(), Fault> {
    place.write("study.toml", STUDY)?;
    place.write("compare.toml", COMPARISON)?;
    Ok(())
}

/// Checks that a command killed repeatedly at any time is resumed to the bytes of an undisturbed run; counts the kills.
pub(super) fn killed(
    programs: &Programs,
    place: &Place,
    random: &mut Random,
) -> Result<u64, Fault> {
    let number = random.below(KILLED.len());
    let (line, again) = KILLED[number];
    let complete = whole(programs, number, random)?;
    killable(place)?;
    let out = place.path().join("out");
    let mut kills = 0;
    for _ in 0..4 {
        let started = if out.exists() { again } else { line };
        let mut running = place.started(words(programs, started))?;
        if running
            .ends_within(random.pause(1 + complete.time.as_millis() as usize))?
            .is_none()
        {
            running.signal(KILL)?;
        }
        match running.ended()?.code {
            None => kills += 1,
            Some(_) => break,
        }
    }
    let again = if out.exists() { again } else { line };
    let rest = place.started(words(programs, again))?.ended()?;
    if rest.code != complete.code {
        return Err(Fault::Torn(format!(
            "exit code {:?} after a kill: {}",
            rest.code, rest.line
        )));
    }
    let (own, expected) = (tree(&out)?, &complete.files);
    match own
        .iter()
        .find(|(name, bytes)| expected.get(*name) != Some(bytes))
    {
        Some((name, _)) => Err(Fault::Torn(format!("{name} of {line}"))),
        None if own.len() < expected.len() => {
            Err(Fault::Torn(format!("a file of {line} is missing")))
        }
        None => no_rest(place.path()).map(|()| kills),
    }
}

fn words(programs: &Programs, line: &str) -> Command {
    let mut command = programs.onset();
    command.args(line.split(' '));
    command
}

/// All files below a folder.
fn tree(folder: &Path) -> Result<BTreeMap<String, Vec<u8>>, Fault> {
    let mut all = BTreeMap::new();
    let mut open = vec![folder.to_owned()];
    while let Some(next) = open.pop() {
        for entry in fs::read_dir(&next)? {
            let path = entry?.path();
            match path.is_dir() {
                true => open.push(path),
                false => {
                    let name = path
                        .strip_prefix(folder)
                        .unwrap_or(&path)
                        .display()
                        .to_string();
                    all.insert(name, fs::read(&path)?);
                }
            }
        }
    }
    Ok(all)
}

/// Checks that no temporary files are left next to the output.
fn no_rest(folder: &Path) -> Result<(), Fault> {
    let left = fs::read_dir(folder)?.flatten();
    let mut left = left.map(|entry| entry.file_name().to_string_lossy().into_owned());
    match left.find(|name| name.starts_with(".onset")) {
        Some(name) => Err(Fault::Torn(format!("{name} is left"))),
        None => Ok(()),
    }
}
