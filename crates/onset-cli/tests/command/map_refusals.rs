//! Stores that block the output path, are foreign or damaged, or cannot be written: reported with a hint, and never overwritten.

use crate::Answer;
use crate::map::{Place, STUDY, TILES, tree};
use std::fs;
use std::path::Path;
use std::process::Command;

#[track_caller]
fn assert_refused(answer: &Answer, code: i32, facts: &[&str]) {
    assert_eq!(
        answer.code,
        Some(code),
        "{}{}",
        answer.stdout,
        answer.stderr
    );
    assert_eq!(answer.stdout, "");
    assert!(answer.stderr.starts_with("error: "), "{}", answer.stderr);
    assert!(answer.stderr.contains("hint: "), "{}", answer.stderr);
    for fact in facts {
        assert!(
            answer.stderr.contains(fact),
            "no `{fact}` in: {}",
            answer.stderr
        );
    }
}

/// Runs maps that must be refused and must leave everything unchanged.
#[track_caller]
fn assert_kept(place: &Place, store: &str, runs: &[&str], facts: &[&str]) {
    let before = tree(&place.folder);
    for more in runs {
        assert_refused(&place.map(store, more), 2, facts);
    }
    assert!(tree(&place.folder) == before, "something was changed");
}

#[test]
fn an_existing_store_is_kept_unless_an_option_replaces_it() {
    let place = Place::new(STUDY);
    place.computed("a.zarr", "--tiles 0..3");
    let begun = format!("3 of {TILES} tiles complete");
    assert_kept(
        &place,
        "a.zarr",
        &[""],
        &["exists", &begun, "--resume", "--overwrite"],
    );
    place.computed("a.zarr", "--resume");
    assert_kept(&place, "a.zarr", &[""], &["it is complete", "--overwrite"]);
}

#[test]
fn a_complete_store_has_nothing_to_resume() {
    let place = Place::new(STUDY);
    place.computed("a.zarr", "");
    let before = tree(&place.folder);
    let document = place.document("a.zarr", "--resume");
    assert_eq!(document["tiles_computed"], 0);
    assert_eq!(document["tiles_found"], TILES);
    assert!(
        place
            .computed("a.zarr", "--resume")
            .stdout
            .contains("nothing to compute")
    );
    assert!(tree(&place.folder) == before);
}

#[test]
fn only_stores_are_ever_replaced() {
    let place = Place::new(STUDY);
    fs::create_dir(place.store("folder")).expect("a folder");
    fs::write(place.store("folder").join("notes.txt"), "precious").expect("a file");
    fs::write(place.store("file"), "precious").expect("a file");
    let runs = ["", "--resume", "--overwrite", "--tiles 0..1"];
    for name in ["folder", "file"] {
        assert_kept(
            &place,
            name,
            &runs,
            &[name, "is not a store of results", "--out"],
        );
    }
}

#[test]
fn a_store_written_by_another_program_is_never_replaced() {
    let place = Place::new(STUDY);
    let of_others = [
        (
            "group",
            "zarr.json",
            r#"{"zarr_format": 3, "node_type": "group", "attributes": {"title": "x"}}"#,
        ),
        (
            "array",
            "zarr.json",
            r#"{"zarr_format": 3, "node_type": "array"}"#,
        ),
        ("old", ".zgroup", r#"{"zarr_format": 2}"#),
    ];
    for (name, file, text) in of_others {
        fs::create_dir(place.store(name)).expect("a folder");
        fs::write(place.store(name).join(file), text).expect("a file");
        let runs = ["", "--resume", "--overwrite", "--tiles 0..1"];
        assert_kept(&place, name, &runs, &["that onset did not write", "--out"]);
    }
}

#[test]
fn an_empty_folder_becomes_the_store() {
    let place = Place::new(STUDY);
    fs::create_dir(place.store("a.zarr")).expect("a folder");
    place.computed("a.zarr", "--tiles 0..1");
}

#[test]
fn a_store_of_another_study_is_not_resumed() {
    let place = Place::new(STUDY);
    place.computed("a.zarr", "--tiles 0..1");
    for (assignment, facts) in [
        (
            "discretization.support=1.7",
            ["`support = 1.9` there", "`support = 1.7` here"],
        ),
        ("map.tile=16", ["tile = ", "16"]),
    ] {
        let more = format!("--resume --set {assignment}");
        let facts = [
            &["contains another study", "--overwrite", "--out"],
            &facts[..],
        ]
        .concat();
        assert_kept(&place, "a.zarr", &[&more], &facts);
    }
}

#[test]
fn a_store_can_be_replaced_by_a_store_of_another_study() {
    let place = Place::new(STUDY);
    place.computed("a.zarr", "--set discretization.support=1.7");
    place.computed("a.zarr", "--overwrite");
    place.computed("b.zarr", "");
    assert_eq!(tree(&place.store("a.zarr")), tree(&place.store("b.zarr")));
    assert_eq!(fs::read_dir(&place.folder).expect("a folder").count(), 3);
    for more in ["--overwrite --resume", "--overwrite --tiles 0..1"] {
        let answer = place.map("a.zarr", more);
        assert_eq!(answer.code, Some(2));
        assert!(
            answer.stderr.contains("cannot be used with"),
            "{}",
            answer.stderr
        );
    }
}

#[test]
fn a_store_that_another_process_writes_is_not_replaced() {
    let place = Place::new(STUDY);
    place.computed("a.zarr", "--tiles 0..1");
    let metadata = fs::File::open(place.store("a.zarr").join("zarr.json")).expect("a file");
    metadata.lock_shared().expect("a lock");
    assert_kept(
        &place,
        "a.zarr",
        &["--overwrite"],
        &["written by another process"],
    );
    drop(metadata);
    place.computed("a.zarr", "--overwrite");
}

/// Damages a file, checks that the run is refused with the name of the file, and restores it.
#[track_caller]
fn assert_damage_found(place: &Place, file: &str, damage: impl FnOnce(&Path), facts: &[&str]) {
    let path = place.store("a.zarr").join(file);
    let whole = fs::read(&path).expect("a file");
    damage(&path);
    let before = tree(&place.folder);
    let answer = place.map("a.zarr", "--resume");
    assert_refused(
        &answer,
        1,
        &[&[path.to_str().expect("UTF-8"), "is damaged"], facts].concat(),
    );
    assert!(tree(&place.folder) == before, "something was changed");
    fs::write(path, whole).expect("a file");
}

fn flip(position: usize) -> impl FnOnce(&Path) {
    move |path| {
        let mut bytes = fs::read(path).expect("a file");
        let position = position % bytes.len();
        bytes[position] ^= 0x10;
        fs::write(path, bytes).expect("a file");
    }
}

fn cut(path: &Path) {
    let bytes = fs::read(path).expect("a file");
    fs::write(path, &bytes[..bytes.len() / 2]).expect("a file");
}

#[test]
fn a_damaged_chunk_is_named_and_its_tile_can_be_recomputed() {
    let place = Place::new(STUDY);
    place.computed("a.zarr", "");
    let whole = tree(&place.store("a.zarr"));
    for position in [0, 40, 41, 1_000_003] {
        assert_damage_found(
            &place,
            "acoustic_minimum/c/1/2",
            flip(position),
            &["checksum"],
        );
        assert_damage_found(&place, "wave_vector/c/0/0/0", flip(position), &["checksum"]);
        assert_damage_found(&place, "verdict/c/4/4", flip(position), &["checksum"]);
    }
    assert_damage_found(
        &place,
        "stability/c/0/3",
        cut,
        &["remove the file", "verdict"],
    );
    let empty = |path: &Path| fs::write(path, "").expect("a file");
    assert_damage_found(&place, "growth_rate/c/0/3", empty, &[]);
    let remove = |path: &Path| fs::remove_file(path).expect("a file");
    assert_damage_found(&place, "growth_rate/c/0/3", remove, &["missing"]);
    assert_damage_found(&place, "stretch-1/c/0", flip(5), &["copy"]);

    // As the hint advises, the file of the verdict is removed, and the tile is computed anew.
    flip(7)(&place.store("a.zarr").join("growth_rate/c/0/3"));
    remove(&place.store("a.zarr").join("verdict/c/0/3"));
    assert_eq!(place.document("a.zarr", "--resume")["tiles_computed"], 1);
    assert_eq!(tree(&place.store("a.zarr")), whole);
}

#[test]
fn damaged_metadata_are_named() {
    let place = Place::new(STUDY);
    place.computed("a.zarr", "--tiles 0..2");
    assert_damage_found(&place, "zarr.json", cut, &["copy"]);
    assert_damage_found(&place, "growth_rate/zarr.json", cut, &["copy"]);
    let other = |path: &Path| {
        let text = fs::read_to_string(path).expect("a file");
        fs::write(path, text.replace("1/time", "1/hour")).expect("a file");
    };
    assert_damage_found(&place, "growth_rate/zarr.json", other, &[]);
}

#[test]
fn a_folder_that_cannot_be_written_is_named() {
    let place = Place::new(STUDY);
    fs::write(place.store("file"), "in the way").expect("a file");
    let before = tree(&place.folder);
    let answer = place.map("file/a.zarr", "");
    assert_refused(&answer, 1, &["cannot write", "file/a.zarr", "--out"]);
    assert!(tree(&place.folder) == before);
    // Not even the superuser can write there.
    let place = Place::new(STUDY);
    let answer = place.map("/proc/onset.zarr", "");
    assert_refused(&answer, 1, &["cannot write", "/proc/onset.zarr", "--out"]);
}

#[test]
fn a_full_disk_is_reported_and_finished_tiles_are_kept() {
    let study = STUDY.replace("tile = 8", "tile = 16");
    let place = Place::new(&study);
    place.computed("whole.zarr", "");
    place.computed("a.zarr", "--tiles 0..1");
    // A full disk is simulated: files are limited to one block, less than the chunks of a full tile.
    let arguments = place.arguments("a.zarr", "--resume");
    let limited = "ulimit -f 1; trap '' XFSZ; exec \"$@\"";
    let output = Command::new("sh")
        .args(["-c", limited, "sh", env!("CARGO_BIN_EXE_onset")])
        .args(&arguments)
        .output()
        .expect("a shell");
    let answer = Answer {
        code: output.status.code(),
        stdout: String::from_utf8(output.stdout).expect("UTF-8"),
        stderr: String::from_utf8(output.stderr).expect("UTF-8"),
    };
    assert_refused(
        &answer,
        1,
        &["cannot write", "a.zarr", "make room", "--resume"],
    );
    let document = place.document("a.zarr", "--resume");
    assert!(document["tiles_found"].as_u64() >= Some(1));
    assert_eq!(
        tree(&place.store("a.zarr")),
        tree(&place.store("whole.zarr"))
    );
}

#[test]
fn a_misplaced_chunk_is_detected() {
    let place = Place::new(STUDY);
    place.computed("a.zarr", "");
    place.computed("b.zarr", "--set discretization.support=1.7");
    for (name, of, from) in [
        ("growth_rate/c/0/0", "a.zarr", "growth_rate/c/1/1"),
        ("growth_rate/c/0/0", "a.zarr", "critical_time_step/c/0/0"),
        ("verdict/c/2/1", "a.zarr", "verdict/c/1/2"),
        ("verdict/c/2/1", "b.zarr", "verdict/c/2/1"),
        ("stretch-1/c/0", "b.zarr", "stretch-1/c/0"),
    ] {
        let other = place.store(of).join(from);
        let copy = |path: &Path| {
            fs::copy(&other, path).expect("a copy");
        };
        assert_damage_found(&place, name, copy, &["another"]);
        copy(&place.store("a.zarr").join(name));
        let store = place.store("a.zarr").display().to_string();
        let field = name
            .split('/')
            .next()
            .filter(|name| !name.starts_with("stretch"));
        let out = place.store("a.svg").display().to_string();
        let field = field.unwrap_or("verdict");
        let answer = crate::onset(&[
            "plot",
            &store,
            "--field",
            field,
            "--no-trace",
            "--out",
            &out,
        ]);
        assert_refused(&answer, 1, &["is damaged", "another"]);
        fs::remove_dir_all(&store).expect("removable");
        place.computed("a.zarr", "");
    }
}

/// Changes the attributes of a store.
fn edit(place: &Place, store: &str, from: &str, to: &str) {
    let path = place.store(store).join("zarr.json");
    let text = fs::read_to_string(&path).expect("a file");
    assert!(text.contains(from), "{text}");
    fs::write(path, text.replace(from, to)).expect("a file");
}

#[test]
fn a_store_of_another_version_build_or_processor_is_not_resumed() {
    let place = Place::new(STUDY);
    place.computed("a.zarr", "--tiles 0..1");
    let text = fs::read_to_string(place.store("a.zarr").join("zarr.json")).expect("a file");
    let value = |name: &str| {
        let start = text.find(&format!("\"{name}\": \"")).expect("an attribute");
        text[start..].lines().next().expect("a line").to_owned()
    };
    for (name, words) in [
        ("onset_version", "another version"),
        ("onset_build", "another build"),
        ("onset_lanes", "another vector width"),
    ] {
        let (is, other) = (value(name), format!("\"{name}\": \"other\","));
        let is = format!("{},", is.trim_end_matches(','));
        edit(&place, "a.zarr", &is, &other);
        assert_kept(
            &place,
            "a.zarr",
            &["--resume"],
            &[words, "`other` there", "--overwrite"],
        );
        edit(&place, "a.zarr", &other, &is);
    }
    place.computed("a.zarr", "--resume");
}

#[test]
fn a_store_of_another_format_is_not_read() {
    let place = Place::new(STUDY);
    place.computed("a.zarr", "--tiles 0..1");
    edit(
        &place,
        "a.zarr",
        "\"onset_format\": 3",
        "\"onset_format\": 1",
    );
    assert_kept(
        &place,
        "a.zarr",
        &["", "--resume"],
        &["format 1", "format 3"],
    );
    let store = place.store("a.zarr").display().to_string();
    let answer = crate::onset(&["plot", &store, "--out", &store]);
    assert_refused(&answer, 2, &["format 1"]);
    place.computed("a.zarr", "--overwrite");
}

/// The identity of a store covers its study, so that an exchanged study does not match the stored numbers.
#[test]
fn an_exchanged_study_in_a_store_is_detected() {
    let place = Place::new(STUDY);
    place.computed("a.zarr", "");
    let store = place.store("a.zarr").display().to_string();
    for (from, to) in [
        ("support = 1.9", "support = 1.8"),
        ("states = 36", "states = 37"),
        ("range = [0.2, 2.0]", "range = [0.2, 3.0]"),
        ("36\n", "65536\n"),
    ] {
        edit(&place, "a.zarr", from, to);
        let answer = crate::onset(&["plot", &store, "--no-trace", "--out", &store]);
        assert_refused(&answer, 1, &["is damaged"]);
        edit(&place, "a.zarr", to, from);
    }
}

#[test]
#[cfg(unix)]
fn foreign_files_are_not_replaced_and_links_are_not_followed() {
    use std::os::unix::fs::symlink;
    let place = Place::new(STUDY);
    place.computed("a.zarr", "--tiles 0..1");
    for name in [
        "notes.txt",
        "verdict/notes.txt",
        "verdict/c/0/0.bak",
        "verdict/c/more",
    ] {
        let file = place.store("a.zarr").join(name);
        fs::write(&file, "precious").expect("a file");
        assert_kept(
            &place,
            "a.zarr",
            &["--overwrite"],
            &[name, "not written by onset"],
        );
        fs::remove_file(&file).expect("removable");
        symlink(place.folder.join("study.toml"), &file).expect("a link");
        assert_kept(
            &place,
            "a.zarr",
            &["--overwrite"],
            &[name, "not written by onset"],
        );
        fs::remove_file(file).expect("removable");
    }
    symlink(place.store("a.zarr"), place.store("link.zarr")).expect("a link");
    assert_kept(
        &place,
        "link.zarr",
        &["--overwrite"],
        &["is a link", "a.zarr"],
    );
    place.computed("link.zarr", "--resume");
    place.computed("a.zarr", "--overwrite");
}

/// A link in a store must not redirect the output of a resumed map.
#[test]
#[cfg(unix)]
fn a_map_does_not_write_through_links() {
    let place = Place::new(STUDY);
    place.computed("a.zarr", "--tiles 0..1");
    let elsewhere = place.store("elsewhere");
    fs::rename(place.store("a.zarr").join("growth_rate/c"), &elsewhere).expect("moved");
    std::os::unix::fs::symlink(&elsewhere, place.store("a.zarr").join("growth_rate/c"))
        .expect("a link");
    let before = tree(&elsewhere);
    let answer = place.map("a.zarr", "--resume");
    assert_eq!(answer.code, Some(1), "{}", answer.stderr);
    assert!(
        answer.stderr.contains("a link leads out of the store"),
        "{}",
        answer.stderr
    );
    assert!(tree(&elsewhere) == before);
}

#[test]
fn the_current_folder_cannot_be_replaced_but_may_be_a_store() {
    let place = Place::new(STUDY);
    let file = place.file.display().to_string();
    let map = |folder: &Path, more: &[&str]| {
        let arguments = [&["map", &file, "--quiet", "--out", "."], more].concat();
        let output = crate::command(&arguments).current_dir(folder).output();
        let output = output.expect("the command starts");
        Answer {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).expect("UTF-8"),
            stderr: String::from_utf8(output.stderr).expect("UTF-8"),
        }
    };
    let empty = place.store("empty");
    fs::create_dir(&empty).expect("a folder");
    assert_refused(&map(&empty, &[]), 2, &["current folder", "--out map.zarr"]);
    assert_eq!(fs::read_dir(&empty).expect("a folder").count(), 0);
    assert_refused(&map(&place.folder, &[]), 2, &["is not a store"]);
    place.computed("a.zarr", "--tiles 0..1");
    assert_refused(
        &map(&place.store("a.zarr"), &["--overwrite"]),
        2,
        &["current folder"],
    );
    assert_eq!(map(&place.store("a.zarr"), &["--resume"]).code, Some(0));
    place.computed("b.zarr", "");
    assert!(tree(&place.store("a.zarr")) == tree(&place.store("b.zarr")));
}

#[test]
#[cfg(target_os = "linux")]
fn file_names_may_be_long_and_contain_any_bytes() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let place = Place::new(STUDY);
    let long = "n".repeat(245);
    place.computed(&long, "--tiles 0..1");
    place.computed(&long, "--overwrite");
    let strange = place.folder.join(OsStr::from_bytes(b"a\xff\n$b.zarr"));
    let figure = place.folder.join(OsStr::from_bytes(b"a\xff.svg"));
    let run = |arguments: &[&OsStr]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_onset"));
        command
            .args(arguments)
            .output()
            .expect("the command starts")
    };
    let (map, out, file) = (
        OsStr::new("map"),
        OsStr::new("--out"),
        place.file.as_os_str(),
    );
    for more in ["--quiet", "--resume", "--overwrite"] {
        let output = run(&[
            map,
            file,
            out,
            strange.as_os_str(),
            OsStr::new("--quiet"),
            OsStr::new(more),
        ][..if more == "--quiet" { 5 } else { 6 }]);
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
    }
    let plot = [
        OsStr::new("plot"),
        strange.as_os_str(),
        OsStr::new("--no-trace"),
        out,
        figure.as_os_str(),
    ];
    assert!(run(&plot).status.success());
    assert!(figure.exists() && figure.with_extension("png").exists());
}

#[test]
fn a_foreign_lock_is_reported() {
    let place = Place::new(STUDY);
    place.computed("a.zarr", "--tiles 0..1");
    let metadata = fs::File::open(place.store("a.zarr").join("zarr.json")).expect("a file");
    metadata.lock().expect("a lock");
    let begin = std::time::Instant::now();
    assert_kept(&place, "a.zarr", &["--resume"], &["holds a lock", "lsof"]);
    assert!(begin.elapsed().as_secs() < 30);
    drop(metadata);
    place.computed("a.zarr", "--resume");
}

#[test]
fn tiles_outside_the_map_are_refused() {
    let place = Place::new(STUDY);
    let beyond = format!("--tiles {TILES}..99");
    assert_refused(&place.map("a.zarr", &beyond), 2, &["25 tiles", "0..25"]);
    let none = format!("--tiles {}/99", TILES + 1);
    assert_refused(&place.map("a.zarr", &none), 2, &["25 tiles", "26/99"]);
    for text in ["1..1", "3..1", "a..b", "5", "-1..2", "0/4", "5/4", "1/0"] {
        let answer = place.map("a.zarr", &format!("--tiles={text}"));
        assert_eq!(answer.code, Some(2));
        assert!(
            answer.stderr.contains("for example 0..64"),
            "{}",
            answer.stderr
        );
    }
    assert!(!place.store("a.zarr").exists());
}

#[test]
fn a_study_that_cannot_be_read_or_computed_creates_no_store() {
    let place = Place::new(STUDY);
    fs::remove_file(&place.file).expect("a file");
    let answer = place.map("a.zarr", "");
    assert_eq!(answer.code, Some(2));
    assert!(answer.stderr.contains("cannot read"), "{}", answer.stderr);
    let place = Place::new(&STUDY.replace("1.9", "nan"));
    assert_eq!(place.map("a.zarr", "").code, Some(2));
    let place = Place::new(STUDY);
    assert_eq!(place.map("a.zarr", "--set material.c1=-1").code, Some(2));
    assert!(!place.store("a.zarr").exists());
}
