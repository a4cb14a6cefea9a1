//! Maps that are killed, interrupted, or computed by several processes: their stores equal the store of an uninterrupted run.

use crate::command;
use crate::map::{Place, STUDY, TILES, tree};
use onset_study::store::{ResultStore, ZarrStore};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

fn started(place: &Place, store: &str, more: &str) -> Child {
    let arguments = place.arguments(store, more);
    command(&arguments.iter().map(String::as_str).collect::<Vec<_>>())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the command starts")
}

/// Numbers between 0 and 1, equal in every run.
fn random() -> impl FnMut() -> f64 {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Number of finished tiles of a store, zero if it does not exist.
fn done(place: &Place, store: &str) -> usize {
    ZarrStore::open(&place.store(store)).map_or(0, |store| store.done().expect("readable"))
}

#[test]
fn a_map_resumed_after_a_kill_has_the_same_bytes() {
    let place = Place::new(STUDY);
    let begin = Instant::now();
    place.computed("whole.zarr", "");
    let duration = begin.elapsed();
    let whole = tree(&place.store("whole.zarr"));
    let mut random = random();
    let mut halves = 0;
    for run in 0..20 {
        let store = format!("killed-{run}.zarr");
        let mut child = started(&place, &store, "");
        std::thread::sleep(duration.mul_f64(random()));
        child.kill().expect("a process");
        child.wait().expect("an end");
        halves += usize::from((1..TILES).contains(&done(&place, &store)));
        place.computed(&store, "--resume");
        assert_eq!(tree(&place.store(&store)), whole, "run {run}");
        std::fs::remove_dir_all(place.store(&store)).expect("removable");
    }
    assert!(halves > 0, "no kill has struck a store in the making");
    let left: Vec<_> = std::fs::read_dir(&place.folder)
        .expect("a folder")
        .map(|entry| entry.expect("an entry").file_name())
        .filter(|name| name != "study.toml" && name != "whole.zarr")
        .collect();
    assert!(left.is_empty(), "{left:?} are left");
}

#[test]
fn an_interrupt_keeps_the_tiles_that_are_stored_and_a_resumed_map_has_the_same_bytes() {
    stopped_by("-INT");
}

#[test]
fn the_end_of_a_batch_job_is_an_interrupt() {
    stopped_by("-TERM");
}

fn stopped_by(name: &str) {
    let place = Place::new(STUDY);
    place.computed("whole.zarr", "");
    let child = started(&place, "interrupted.zarr", "");
    // The map is interrupted as soon as its first tile is finished.
    while done(&place, "interrupted.zarr") == 0 {
        std::thread::sleep(Duration::from_millis(1));
    }
    signal(&child, name);
    let output = child.wait_with_output().expect("an end");
    let told = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(130), "{told}");
    let again = format!(
        "--out {} --resume",
        place.store("interrupted.zarr").display()
    );
    assert!(told.contains(&again), "{told}");
    let tiles = done(&place, "interrupted.zarr");
    assert!((1..TILES).contains(&tiles), "{tiles} tiles are done");
    let said = String::from_utf8(output.stdout).expect("UTF-8");
    let left = format!("{} of {TILES} tiles remain to be computed", TILES - tiles);
    // The command does not wait for a state that exceeds the time limit, and then prints no summary.
    assert!(said.is_empty() || said.contains(&left), "{said}");

    let document = place.document("interrupted.zarr", "--resume");
    assert_eq!(document["tiles_found"], tiles);
    assert_eq!(document["tiles_computed"], TILES - tiles);
    assert_eq!(
        tree(&place.store("interrupted.zarr")),
        tree(&place.store("whole.zarr"))
    );
}

/// One tile, with several particles per cell at each state.
fn slow(cells: usize, states: usize) -> String {
    format!(
        "[discretization]\nlattice = \"face-centered-cubic\"\nquadrature = \"nodal\"\nsupport = 1.65\ncells = {cells}\nperturbation = 0.05\n\
         [[axes]]\nquantity = \"stretch-1\"\nrange = [0.9, 1.1]\nstates = {states}\n\
         [[axes]]\nquantity = \"stretch-2\"\nrange = [0.95, 1.05]\nstates = 4\n"
    )
}

fn signal(child: &Child, signal: &str) {
    let id = child.id().to_string();
    let status = Command::new("kill").args([signal, &id]).status();
    assert!(status.expect("kill").success());
}

/// Running map whose store exists and whose tile has been started.
fn begun(place: &Place) -> Child {
    let child = started(place, "slow.zarr", "");
    while !place.store("slow.zarr").is_dir() {
        std::thread::sleep(Duration::from_millis(1));
    }
    std::thread::sleep(Duration::from_millis(50));
    child
}

#[test]
fn an_interrupt_abandons_a_tile_of_slow_states_and_a_resumed_map_has_the_same_bytes() {
    let place = Place::new(&slow(2, 6));
    let child = begun(&place);
    signal(&child, "-INT");
    let output = child.wait_with_output().expect("an end");
    let told = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(130), "{told}");
    assert!(told.contains("--resume"), "{told}");
    assert_eq!(done(&place, "slow.zarr"), 0);
    place.computed("slow.zarr", "--resume");
    place.computed("whole.zarr", "");
    assert_eq!(
        tree(&place.store("slow.zarr")),
        tree(&place.store("whole.zarr"))
    );
}

#[test]
fn a_slow_state_or_a_second_interrupt_ends_a_map_immediately_with_a_hint_to_resume() {
    for times in [1, 2] {
        let place = Place::new(&slow(3, 64));
        let child = begun(&place);
        let begin = Instant::now();
        for _ in 0..times {
            signal(&child, "-INT");
            std::thread::sleep(Duration::from_millis(200));
        }
        let output = child.wait_with_output().expect("an end");
        let told = String::from_utf8(output.stderr).expect("UTF-8");
        assert_eq!(output.status.code(), Some(130), "{told}");
        let again = format!("--out {} --resume", place.store("slow.zarr").display());
        assert!(told.contains(&again), "{told}");
        assert!(begin.elapsed() < Duration::from_secs(2));
    }
}

/// The printed command, given to a shell, resumes the map.
#[test]
fn the_printed_command_that_resumes_works_in_a_shell() {
    let place = Place::new(STUDY);
    let folder = place.store("it's a $HOME; map");
    std::fs::create_dir(&folder).expect("a folder");
    std::fs::copy(&place.file, folder.join("-study (1).toml")).expect("a copy");
    let set = "discretization.support = 1.9";
    let child = command(&[
        "map",
        "--out",
        "a b.zarr",
        "--set",
        set,
        "--",
        "-study (1).toml",
    ])
    .current_dir(&folder)
    .stdout(Stdio::null())
    .stderr(Stdio::piped())
    .spawn()
    .expect("the command starts");
    let store = folder.join("a b.zarr");
    let done = || ZarrStore::open(&store).map_or(0, |store| store.done().expect("readable"));
    while done() == 0 {
        std::thread::sleep(Duration::from_millis(1));
    }
    signal(&child, "-INT");
    let told = String::from_utf8(child.wait_with_output().expect("an end").stderr).expect("UTF-8");
    let line = told
        .lines()
        .find(|line| line.contains("onset map"))
        .expect("a line")
        .trim();
    let line = line.replacen("onset", env!("CARGO_BIN_EXE_onset"), 1);
    let output = Command::new("bash")
        .args(["-c", &line])
        .current_dir(&folder)
        .output();
    let output = output.expect("a shell");
    assert!(
        output.status.success(),
        "{line}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    assert_eq!(done(), TILES);
}

/// Runs maps into one store simultaneously; all must succeed.
fn together(place: &Place, store: &str, parts: &[&str]) {
    let children: Vec<Child> = parts
        .iter()
        .map(|part| started(place, store, part))
        .collect();
    for child in children {
        let output = child.wait_with_output().expect("an end");
        let told = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{told}");
    }
}

#[test]
fn a_store_written_by_four_processes_is_identical_to_a_store_of_a_single_process() {
    let place = Place::new(STUDY);
    place.computed("whole.zarr", "");
    let whole = tree(&place.store("whole.zarr"));
    let parts = ["0..7", "7..13", "13..19", "19..99"].map(|part| format!("--tiles {part}"));
    let parts = parts.each_ref().map(String::as_str);
    together(&place, "disjoint.zarr", &parts);
    assert_eq!(tree(&place.store("disjoint.zarr")), whole, "disjoint tiles");
    let parts = ["1/4", "2/4", "3/4", "4/4"].map(|part| format!("--tiles {part}"));
    let parts = parts.each_ref().map(String::as_str);
    together(&place, "shares.zarr", &parts);
    assert_eq!(tree(&place.store("shares.zarr")), whole, "shares");
    let parts = [
        "--tiles 0..15",
        "--tiles 5..20",
        "--tiles 10..25",
        "--resume",
    ];
    together(&place, "shared.zarr", &parts);
    assert_eq!(tree(&place.store("shared.zarr")), whole, "the same tiles");
    together(&place, "same.zarr", &["--resume"; 4]);
    assert_eq!(tree(&place.store("same.zarr")), whole, "one command");
}

/// The tile is the first tile, which would be computed first if it were free.
#[test]
fn a_tile_reserved_by_another_process_is_computed_last() {
    let place = Place::new(STUDY);
    place.computed("taken.zarr", "--tiles 20..21");
    let store = place.store("taken.zarr");
    let taken = ZarrStore::open(&store).expect("a store").take(0);
    let taken = taken.expect("a lock").expect("a free tile");
    let again = ZarrStore::open(&store).expect("a store").take(0);
    assert!(again.expect("a lock").is_none(), "it is taken");
    let document = place.document("taken.zarr", "--resume");
    assert_eq!(document["tiles_done"], TILES);
    assert_eq!(document["tiles_computed"], TILES - 1);
    let written = |tile: [usize; 2]| {
        let [row, column] = tile;
        let chunk = store.join(format!("verdict/c/{row}/{column}"));
        let found = std::fs::metadata(chunk).expect("a chunk");
        found.modified().expect("a time")
    };
    let others = (1..TILES).map(|tile| written([tile / 5, tile % 5]));
    assert!(others.into_iter().all(|time| time <= written([0, 0])));
    drop(taken);
    let again = ZarrStore::open(&store).expect("a store").take(0);
    assert!(again.expect("a lock").is_some(), "it is free");
}

/// A process that is stopped within a tile does not prevent the others from finishing; when it continues, it finds the tile finished.
#[test]
fn a_stopped_process_does_not_block_the_others() {
    let place = Place::new(&slow(2, 6));
    let stopped = begun(&place);
    signal(&stopped, "-STOP");
    assert_eq!(done(&place, "slow.zarr"), 0, "it has begun its tile");
    place.computed("slow.zarr", "--resume");
    assert_eq!(done(&place, "slow.zarr"), 1);
    signal(&stopped, "-CONT");
    let output = stopped.wait_with_output().expect("an end");
    let told = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{told}");
    assert!(told.contains("1 were done already"), "{told}");
    place.computed("whole.zarr", "");
    assert_eq!(
        tree(&place.store("slow.zarr")),
        tree(&place.store("whole.zarr"))
    );
}

#[test]
fn processes_with_two_studies_for_one_store_leave_a_store_of_one_study() {
    let place = Place::new(STUDY);
    let others = "--tiles 0..2 --set discretization.support=1.7";
    for race in 0..5 {
        let store = format!("race-{race}.zarr");
        let children = ["--tiles 0..2", others, "--tiles 0..2", others]
            .map(|part| started(&place, &store, part));
        let outputs = children.map(|child| child.wait_with_output().expect("an end"));
        let codes = outputs.each_ref().map(|output| output.status.code());
        let (first, second) = ((codes[0], codes[2]), (codes[1], codes[3]));
        let ends = [(Some(0), Some(0)), (Some(2), Some(2))];
        assert!(
            first != second && ends.contains(&first) && ends.contains(&second),
            "{codes:?}"
        );
        for output in outputs
            .iter()
            .filter(|output| output.status.code() == Some(2))
        {
            let told = String::from_utf8_lossy(&output.stderr);
            assert!(told.contains("contains another study"), "{told}");
        }
        assert_eq!(done(&place, &store), 2);
    }
}

#[test]
fn a_map_does_not_depend_on_the_number_of_threads() {
    let place = Place::new(STUDY);
    for (threads, adaptive) in [("1", "false"), ("3", "false"), ("1", "true"), ("3", "true")] {
        let more = format!("--quiet --set map.adaptive={adaptive}");
        let arguments = place.arguments(&format!("{adaptive}-{threads}.zarr"), &more);
        let status = command(&arguments.iter().map(String::as_str).collect::<Vec<_>>())
            .env("RAYON_NUM_THREADS", threads)
            .status();
        assert!(status.expect("the command starts").success());
    }
    for adaptive in ["false", "true"] {
        let of = |threads| tree(&place.store(&format!("{adaptive}-{threads}.zarr")));
        assert_eq!(of(1), of(3), "adaptive = {adaptive}");
    }
}
