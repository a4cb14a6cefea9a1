//! Stores that are randomly damaged or maliciously forged: only content written by onset is accepted, within limits of memory and time.

use crate::hunt::hunted;
use crate::map::{Place, STUDY};
use crate::{Answer, Random};
use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Entry of a folder.
#[derive(Clone, PartialEq)]
enum Entry {
    File(Vec<u8>),
    Link(PathBuf),
    Folder,
    Other,
}

/// Entries below a folder; links are not followed, and special files not opened.
fn snapshot(folder: &Path) -> BTreeMap<PathBuf, Entry> {
    let mut found = BTreeMap::new();
    let mut open = vec![folder.to_owned()];
    while let Some(current) = open.pop() {
        for entry in fs::read_dir(&current).expect("a folder") {
            let entry = entry.expect("an entry");
            let (path, kind) = (entry.path(), entry.file_type().expect("a kind"));
            let name = path.strip_prefix(folder).expect("inside").to_owned();
            let what = if kind.is_dir() {
                open.push(path);
                Entry::Folder
            } else if kind.is_symlink() {
                Entry::Link(fs::read_link(path).expect("a link"))
            } else if kind.is_file() {
                Entry::File(fs::read(path).expect("a file"))
            } else {
                Entry::Other
            };
            found.insert(name, what);
        }
    }
    found
}

fn restore(folder: &Path, entries: &BTreeMap<PathBuf, Entry>) {
    let _ = fs::remove_dir_all(folder);
    fs::create_dir_all(folder).expect("a folder");
    for (name, entry) in entries {
        let path = folder.join(name);
        match entry {
            Entry::File(bytes) => fs::write(path, bytes).expect("a file"),
            Entry::Folder => fs::create_dir_all(path).expect("a folder"),
            Entry::Link(target) => symlink(target, path).expect("a link"),
            Entry::Other => {}
        }
    }
}

/// Runs the command with at most 2 GB of address space and 20 s of processor time.
fn limited(arguments: &[&str]) -> Answer {
    let output = Command::new("sh")
        .args([
            "-c",
            "ulimit -v 2000000 -t 20; exec \"$@\"",
            "sh",
            env!("CARGO_BIN_EXE_onset"),
        ])
        .args(arguments)
        .env("RAYON_NUM_THREADS", "2")
        .output()
        .expect("a shell");
    Answer {
        code: output.status.code(),
        stdout: String::from_utf8(output.stdout).expect("UTF-8"),
        stderr: String::from_utf8(output.stderr).expect("UTF-8"),
    }
}

/// Damages a store in some way, and returns a description of the damage.
fn damage(store: &Path, other: &Path, random: &mut Random) -> String {
    let files: Vec<PathBuf> = snapshot(store)
        .into_iter()
        .filter(|(_, entry)| matches!(entry, Entry::File(_)))
        .map(|(name, _)| name)
        .collect();
    let chunks: Vec<&PathBuf> = files
        .iter()
        .filter(|name| !name.ends_with("zarr.json"))
        .collect();
    let name = files[random.below(files.len())].clone();
    let path = store.join(&name);
    let bytes = fs::read(&path).expect("a file");
    let write = |bytes: &[u8]| fs::write(&path, bytes).expect("a file");
    let remove = || fs::remove_file(&path).expect("removable");
    let shown = name.display();
    match random.below(14) {
        0 => {
            let mut bytes = bytes;
            let place = random.below(bytes.len());
            bytes[place] ^= 1 << random.below(8);
            write(&bytes);
            format!("a bit of byte {place} of {shown} is flipped")
        }
        1 => {
            let length = random.below(bytes.len());
            write(&bytes[..length]);
            format!("{shown} is cut to {length} bytes")
        }
        2 => {
            remove();
            format!("{shown} is removed")
        }
        3 | 4 => {
            let [a, b] = [0; 2].map(|_| chunks[random.below(chunks.len())]);
            let [at_a, at_b] = [a, b].map(|name| store.join(name));
            let [of_a, of_b] = [&at_a, &at_b].map(|path| fs::read(path).expect("a file"));
            fs::write(at_a, of_b).expect("a file");
            fs::write(at_b, of_a).expect("a file");
            format!("{} and {} are swapped", a.display(), b.display())
        }
        5 => {
            let [from, to] = [0; 2].map(|_| chunks[random.below(chunks.len())]);
            fs::copy(store.join(from), store.join(to)).expect("a copy");
            format!("{} is copied to {}", from.display(), to.display())
        }
        6 => {
            let chunk = chunks[random.below(chunks.len())];
            fs::copy(other.join(chunk), store.join(chunk)).expect("a copy");
            format!("{} belongs to another map", chunk.display())
        }
        7 => {
            remove();
            fs::create_dir(&path).expect("a folder");
            format!("{shown} is a folder")
        }
        8 => {
            remove();
            let targets = ["/dev/zero", "/nowhere", "zarr.json", "."];
            let target = targets[random.below(targets.len())];
            symlink(target, &path).expect("a link");
            format!("{shown} is a link to {target}")
        }
        9 => {
            remove();
            assert!(
                Command::new("mkfifo")
                    .arg(&path)
                    .status()
                    .expect("mkfifo")
                    .success()
            );
            format!("{shown} is a pipe")
        }
        10 => {
            let more: Vec<u8> = (0..1 + random.below(5000))
                .map(|_| random.below(256) as u8)
                .collect();
            write(&[bytes, more].concat());
            format!("{shown} has more bytes")
        }
        11 | 12 => {
            let path = store.join("zarr.json");
            let text = fs::read_to_string(&path).expect("a file");
            let changed = mutated(&text, random);
            fs::write(&path, &changed.0).expect("a file");
            format!("in zarr.json {}", changed.1)
        }
        _ => {
            write(b"");
            format!("{shown} is empty")
        }
    }
}

/// Changes one number or word in a JSON text.
fn mutated(text: &str, random: &mut Random) -> (String, String) {
    let bytes = text.as_bytes();
    let mut starts = Vec::new();
    for n in 1..bytes.len() {
        let inside = |byte: u8| byte.is_ascii_alphanumeric();
        if inside(bytes[n]) && !inside(bytes[n - 1]) {
            starts.push(n);
        }
    }
    let start = starts[random.below(starts.len())];
    let length = text[start..].find(|letter: char| !letter.is_ascii_alphanumeric());
    let end = length.map_or(text.len(), |length| start + length);
    let words = [
        "0",
        "1",
        "2",
        "-1",
        "3",
        "65536",
        "4294967296",
        "18446744073709551615",
        "1e300",
        "null",
        "stable",
        "gzip",
        "a/../../b",
        "..",
        "float64",
        "int8",
        "",
    ];
    let word = words[random.below(words.len())];
    let told = format!("`{}` at {start} is `{word}`", &text[start..end]);
    (format!("{}{word}{}", &text[..start], &text[end..]), told)
}

#[test]
fn damaged_stores_are_refused_or_return_the_stored_values() {
    let (seed, cases) = hunted(25);
    let mut random = Random::new(seed);
    let place = Place::new(&STUDY.replace("tile = 8", "tile = 16"));
    place.computed("whole.zarr", "");
    place.computed("other.zarr", "--set discretization.support=1.8");
    let text = |name: &str| place.store(name).to_str().expect("UTF-8").to_owned();
    let (store, other) = (place.store("a.zarr"), place.store("other.zarr"));
    let whole = snapshot(&place.store("whole.zarr"));
    restore(&store, &whole);
    let figure = |answer: &Answer| {
        let path = place.store("a.svg");
        let drawn = (answer.code == Some(0)).then(|| fs::read_to_string(&path).expect("a figure"));
        let _ = fs::remove_file(path);
        drawn
    };
    let (path, image, study) = (text("a.zarr"), text("a.svg"), text("study.toml"));
    let plot = ["plot", &*path, "--no-trace", "--out", &*image];
    let expected = figure(&limited(&plot)).expect("a figure");
    for case in 0..cases {
        restore(&store, &whole);
        let what = damage(&store, &other, &mut random);
        let what = format!("seed {seed}, case {case}: {what}");
        let damaged = snapshot(&store);
        let answer = limited(&plot);
        assert!(
            matches!(answer.code, Some(0..=2)),
            "{what}: {:?} {}",
            answer.code,
            answer.stderr
        );
        assert!(
            !answer.stderr.contains("panicked"),
            "{what}: {}",
            answer.stderr
        );
        if let Some(drawn) = figure(&answer) {
            let is_missing = damaged
                .keys()
                .filter(|name| name.starts_with("verdict/c"))
                .count()
                < whole
                    .keys()
                    .filter(|name| name.starts_with("verdict/c"))
                    .count()
                || damaged.iter().any(|(name, entry)| {
                    name.starts_with("verdict/c") && matches!(entry, Entry::Link(_))
                });
            assert!(drawn == expected || is_missing, "{what}: another figure");
        }
        assert!(
            snapshot(&store) == damaged,
            "{what}: a figure changes its store"
        );
        let answer = limited(&["map", &study, "--out", &path, "--resume", "--quiet"]);
        assert!(
            matches!(answer.code, Some(0..=2)),
            "{what}: {:?} {}",
            answer.code,
            answer.stderr
        );
        assert!(
            !answer.stderr.contains("panicked"),
            "{what}: {}",
            answer.stderr
        );
        let after = snapshot(&store);
        if answer.code == Some(0) {
            assert!(after == whole, "{what}: another map");
        } else {
            assert!(answer.stderr.contains(&path), "{what}: {}", answer.stderr);
            assert!(after == damaged, "{what}: something was changed");
        }
    }
}
