//! Commands disturbed at any call that changes files: killed, on a full disk, or on a failing disk. Each file is the old or the new one, and the next
//! run gives the result of an undisturbed run.

use crate::hunt::hunted;
use crate::{Random, Scratch, command};
use std::collections::BTreeMap;
use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

/// Disturbances of a call.
const MODES: [&str; 6] = ["before", "after", "cut", "full", "once", "error"];

/// Small study with four tiles.
const STUDY: &str = "\
[discretization]
support = 1.6
[[axes]]
quantity = 'stretch-1'
range = [0.8, 1.6]
states = 10
[[axes]]
quantity = 'stretch-2'
range = [0.8, 1.6]
states = 9
[map]
tile = 8
";

const COMPARISON: &str = "\
[compare]
stretches = [0.95, 1.05]
states = 2
tension = 1.1
compression = 0.9
[[methods]]
name = 'nodes'
lattice = 'square'
quadrature = 'nodal'
";

/// Commands that write files, each with a command that creates earlier files with the same names.
const COMMANDS: [(&str, &str); 11] = [
    (
        "dispersion --stretch 1.2,0.9 --path --out out",
        "dispersion --stretch 1.1,0.9 --path --out out",
    ),
    (
        "modes --set discretization.quadrature=nodal --cells 4 --out out",
        "modes --set discretization.quadrature=nodal --cells 3 --out out",
    ),
    (
        "compare compare.toml --quiet --out out",
        "compare compare.toml --quiet --out out --set material.c1=2e5",
    ),
    (
        "criteria --mode hydrostatic --range 0.5,2 --out out",
        "criteria --mode hydrostatic --range 0.4,2 --out out",
    ),
    (
        "localize --model j2 --path uniaxial-stress --out out",
        "localize --model j2 --path plane-strain --out out",
    ),
    (
        "plot old.zarr --no-trace --out out/map.svg",
        "plot other.zarr --no-trace --out out/map.svg",
    ),
    (
        "recommend compare.toml --quiet --out out",
        "recommend compare.toml --quiet --out out --set material.c1=2e5",
    ),
    (
        "tune discretization.support --range 1.6,1.7 --set discretization.lattice=chain --quiet --out out",
        "tune discretization.support --range 1.6,1.8 --set discretization.lattice=chain --quiet --out out",
    ),
    (
        "limit --vary discretization.spacing --time-step 0.1 --quiet --out out",
        "limit --vary discretization.spacing --time-step 0.2 --quiet --out out",
    ),
    (
        "boundary study.toml --out out",
        "boundary study.toml --out out --set discretization.support=1.7",
    ),
    (
        "card --range 0.95,1.05 --out out",
        "card --range 0.95,1.1 --out out",
    ),
];

/// Library that intercepts system calls of the process.
fn interposer() -> &'static Path {
    static LIBRARY: OnceLock<Scratch> = OnceLock::new();
    LIBRARY.get_or_init(|| {
        let source = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/interpose/interpose.c");
        let library = Scratch::new("interpose.so");
        let compiler = std::env::var_os("CC").unwrap_or_else(|| "cc".into());
        let output = Command::new(compiler)
            .args(["-shared", "-fPIC", "-O1", "-o"])
            .args([library.as_os_str(), source.as_ref(), "-ldl".as_ref()])
            .output()
            .expect("a C compiler, which Rust links with");
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        library
    })
}

/// Content of every file below a folder.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut open = vec![folder.to_owned()];
    while let Some(current) = open.pop() {
        for entry in fs::read_dir(&current).into_iter().flatten() {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                open.push(path);
            } else {
                let name = path.strip_prefix(folder).expect("inside").to_owned();
                files.insert(name, fs::read(&path).expect("a file"));
            }
        }
    }
    files
}

/// Folder in which commands run.
struct Place(Scratch);

impl Place {
    fn new() -> Self {
        let place = Scratch::new("kill");
        fs::create_dir_all(&place).expect("a folder");
        fs::write(place.join("study.toml"), STUDY).expect("a file");
        fs::write(place.join("compare.toml"), COMPARISON).expect("a file");
        let place = Self(place);
        place.succeed("map study.toml --quiet --out old.zarr");
        place.succeed("map study.toml --quiet --out other.zarr --set discretization.support=1.7");
        place
    }

    fn run(&self, line: &str, point: Option<(usize, &str)>, count: Option<&Path>) -> Output {
        let words: Vec<&str> = line.split(' ').collect();
        let mut command = command(&words);
        command.current_dir(&self.0).env("RAYON_NUM_THREADS", "1");
        if let Some((point, mode)) = point {
            command
                .env("ONSET_POINT", point.to_string())
                .env("ONSET_MODE", mode);
        }
        if let Some(count) = count {
            command.env("ONSET_COUNT", count);
        }
        if point.is_some() || count.is_some() {
            command.env("LD_PRELOAD", interposer());
        }
        command.output().expect("the command starts")
    }

    #[track_caller]
    fn succeed(&self, line: &str) {
        let output = self.run(line, None, None);
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{line}: {told}");
    }

    /// Number of calls of a command that change files.
    fn points(&self, line: &str) -> usize {
        let count = self.0.join("count");
        assert!(
            self.run(line, None, Some(&count)).status.success(),
            "{line}"
        );
        let points = fs::read_to_string(&count).expect("a count");
        fs::remove_file(count).expect("removable");
        points.parse().expect("a number")
    }

    /// Names in the folder, including unfinished work.
    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.0).expect("a folder");
        let mut names: Vec<String> = entries
            .map(|entry| {
                entry
                    .expect("one")
                    .file_name()
                    .into_string()
                    .expect("UTF-8")
            })
            .collect();
        names.sort();
        names
    }
}

/// Command, disturbance, and number of the disturbed call.
type Case<'a> = (&'a Subject, &'static str, usize);

/// Command with its initial and final files.
struct Subject {
    line: &'static str,
    /// Files of the written store or folder, before and after.
    old: BTreeMap<PathBuf, Vec<u8>>,
    new: BTreeMap<PathBuf, Vec<u8>>,
    points: usize,
}

/// Restores the files of a folder.
fn put(folder: &Path, files: &BTreeMap<PathBuf, Vec<u8>>) {
    let _ = fs::remove_dir_all(folder);
    for (name, bytes) in files {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        fs::write(path, bytes).expect("a file");
    }
}

/// Checks how a disturbed command ended; returns true if it was killed.
fn assert_ended(output: &Output, mode: &str, what: &str) -> bool {
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(!told.contains("panicked"), "{what}: {told}");
    let is_killed = ["before", "after", "cut"].contains(&mode);
    if is_killed {
        assert_eq!(output.status.signal(), Some(9), "{what}: {told}");
    } else if !output.status.success() {
        // The last calls may clean up after the work is done, and their failure is not an error.
        assert_eq!(output.status.code(), Some(1), "{what}: {told}");
        assert!(told.contains("cannot write"), "{what}: {told}");
        assert!(
            mode != "full" || told.contains("make room"),
            "{what}: {told}"
        );
    }
    is_killed
}

fn is_unfinished(name: &Path) -> bool {
    name.to_string_lossy().starts_with(".onset-unfinished-")
}

/// Disturbs a command that writes a folder of files.
fn disturb_files(place: &Place, (subject, mode, point): Case<'_>) {
    let what = format!("{} {mode} {point}", subject.line);
    let out = place.0.join("out");
    put(&out, &subject.old);
    let names = place.names();
    let output = place.run(subject.line, Some((point, mode)), None);
    let is_killed = assert_ended(&output, mode, &what);
    let found = files(&out);
    for (name, bytes) in found.iter().filter(|(name, _)| !is_unfinished(name)) {
        let is_known = subject.old.get(name) == Some(bytes) || subject.new.get(name) == Some(bytes);
        assert!(
            is_known,
            "{what}: {} is neither old nor new",
            name.display()
        );
    }
    for name in subject.old.keys() {
        assert!(
            found.contains_key(name),
            "{what}: {} is lost",
            name.display()
        );
    }
    let finished: BTreeMap<&PathBuf, &Vec<u8>> = found
        .iter()
        .filter(|(name, _)| !is_unfinished(name))
        .collect();
    if output.status.success() {
        assert!(finished.into_iter().eq(&subject.new), "{what}: not new");
    } else if !is_killed && mode != "error" {
        // If files can no longer be written or renamed, none can be restored.
        assert!(finished.into_iter().eq(&subject.old), "{what}: not old");
    }
    assert!(
        mode != "full" || !found.keys().any(|name| is_unfinished(name)),
        "{what}: something unfinished is left"
    );
    place.succeed(subject.line);
    assert!(
        files(&out) == subject.new,
        "{what}: another result afterwards"
    );
    assert_eq!(place.names(), names, "{what}");
}

/// Disturbs a map that creates or replaces a store.
fn disturb_map(place: &Place, (subject, mode, point): Case<'_>) {
    let what = format!("{} {mode} {point}", subject.line);
    let store = place.0.join("map.zarr");
    let replaces = subject.line.contains("--overwrite");
    let _ = fs::remove_dir_all(&store);
    if replaces {
        put(&store, &subject.old);
    }
    let output = place.run(subject.line, Some((point, mode)), None);
    assert_ended(&output, mode, &what);
    let found = files(&store);
    let is_old = replaces && found == subject.old;
    for (name, bytes) in &found {
        let is_partial = name.starts_with(".partial");
        assert!(
            is_old || is_partial || subject.new.get(name) == Some(bytes),
            "{what}: {} is not of one store",
            name.display()
        );
    }
    assert!(!replaces || !found.is_empty(), "{what}: there is no store");
    let resumed = if is_old {
        subject.line.to_owned()
    } else {
        RESUME.to_owned()
    };
    place.succeed(&resumed);
    assert!(
        files(&store) == subject.new,
        "{what}: another result afterwards"
    );
    let left = place.names();
    assert!(
        left.iter().all(|name| !name.starts_with(".onset")),
        "{what}: {left:?}"
    );
}

const RESUME: &str = "map study.toml --quiet --out map.zarr --resume";
const MAPS: [&str; 3] = [
    "map study.toml --quiet --out map.zarr",
    "map study.toml --quiet --out map.zarr --overwrite",
    RESUME,
];

#[test]
fn commands_disturbed_at_any_point_leave_each_file_old_or_new() {
    let (seed, cases) = hunted(20);
    let mut random = Random::new(seed);
    let place = Place::new();
    // With few cases, only one command and maps are tested.
    let every = cases >= 1000;
    let first = random.below(COMMANDS.len());
    let chosen = (0..COMMANDS.len()).map(|n| (n + first) % COMMANDS.len());
    let chosen = chosen.take(if every { COMMANDS.len() } else { 1 });
    let (out, store) = (place.0.join("out"), place.0.join("map.zarr"));
    let mut subjects: Vec<Subject> = chosen
        .map(|n| {
            let (line, before) = COMMANDS[n];
            let _ = fs::remove_dir_all(&out);
            place.succeed(before);
            let old = files(&out);
            let points = place.points(line);
            let new = files(&out);
            assert!(
                old.keys().eq(new.keys()) && old != new && points > 6,
                "{line}"
            );
            Subject {
                line,
                old,
                new,
                points,
            }
        })
        .collect();
    for line in MAPS {
        let _ = fs::remove_dir_all(&store);
        place.succeed("map study.toml --quiet --out map.zarr --set discretization.support=1.7");
        let old = files(&store);
        if !line.contains("--overwrite") {
            fs::remove_dir_all(&store).expect("removable");
        }
        let points = place.points(line);
        let new = files(&store);
        assert!(old != new && points > 40, "{line}");
        subjects.push(Subject {
            line,
            old,
            new,
            points,
        });
    }
    let all: Vec<Case<'_>> = subjects
        .iter()
        .flat_map(|subject| {
            let points = move |mode| (1..=subject.points).map(move |point| (subject, mode, point));
            MODES.into_iter().flat_map(points)
        })
        .collect();
    let picked: Vec<Case<'_>> = if cases >= all.len() {
        all
    } else {
        (0..cases).map(|_| all[random.below(all.len())]).collect()
    };
    for case in picked {
        if cases >= 1000 && case.2 == 1 {
            // A long test prints its progress.
            eprintln!("{} {}: {} points", case.0.line, case.1, case.0.points);
        }
        if MAPS.contains(&case.0.line) {
            disturb_map(&place, case);
        } else {
            disturb_files(&place, case);
        }
    }
}
