//! `onset map`: output and stored fields.

use crate::{Answer, Scratch, command, onset};
use onset_study::store::{Column, ResultStore, ZarrStore};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Study of 25 tiles, computed in two thirds of a second.
pub const STUDY: &str = "\
title = \"a study\"
[discretization]
frame = \"eulerian\"
current-lattice = \"regular\"
linearization = \"exact\"
support = 1.9
[[axes]]
quantity = \"stretch-1\"
range = [0.2, 2.0]
states = 36
[[axes]]
quantity = \"stretch-2\"
range = [0.2, 2.0]
states = 34
[map]
tile = 8
";

/// Number of tiles in the study.
pub const TILES: usize = 25;

/// Folder with a study file.
pub struct Place {
    pub folder: Scratch,
    pub file: PathBuf,
}

impl Place {
    pub fn new(study: &str) -> Self {
        let folder = Scratch::new("map");
        fs::create_dir_all(&folder).expect("a folder");
        let file = folder.join("study.toml");
        fs::write(&file, study).expect("a file");
        Self { folder, file }
    }

    pub fn store(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// Arguments of a map into a named store, with further arguments separated by spaces.
    pub fn arguments(&self, store: &str, more: &str) -> Vec<String> {
        let text = |path: &Path| path.to_str().expect("UTF-8").to_owned();
        let first = ["map".to_owned(), text(&self.file)];
        let out = ["--out".to_owned(), text(&self.store(store))];
        let more = more.split_whitespace().map(str::to_owned);
        first.into_iter().chain(out).chain(more).collect()
    }

    pub fn map(&self, store: &str, more: &str) -> Answer {
        let arguments = self.arguments(store, more);
        onset(&arguments.iter().map(String::as_str).collect::<Vec<_>>())
    }

    /// Runs a map that must succeed.
    #[track_caller]
    pub fn computed(&self, store: &str, more: &str) -> Answer {
        let answer = self.map(store, more);
        assert_eq!(answer.code, Some(0), "{}", answer.stderr);
        assert_eq!(answer.stderr, "", "nothing but the answer off a terminal");
        answer
    }

    #[track_caller]
    pub fn document(&self, store: &str, more: &str) -> Value {
        let answer = self.computed(store, &format!("{more} --json"));
        serde_json::from_str(&answer.stdout).expect("one JSON document")
    }
}

/// Content of every file of a folder, and its subfolders.
pub fn tree(folder: &Path) -> BTreeMap<PathBuf, Option<Vec<u8>>> {
    let mut tree = BTreeMap::new();
    let mut open = vec![folder.to_owned()];
    while let Some(current) = open.pop() {
        for entry in fs::read_dir(&current).expect("a folder") {
            let path = entry.expect("an entry").path();
            let name = path.strip_prefix(folder).expect("inside").to_owned();
            if path.is_dir() {
                tree.insert(name, None);
                open.push(path);
            } else {
                tree.insert(name, Some(fs::read(&path).expect("a file")));
            }
        }
    }
    tree
}

/// All values of a field, tile by tile.
fn values(store: &ZarrStore, field: &str) -> Vec<Column> {
    (0..store.tiling().tiles())
        .map(|tile| {
            let column = store.read(field, tile).expect("readable");
            column.expect("done")
        })
        .collect()
}

pub fn flags(store: &ZarrStore, field: &str) -> Vec<i8> {
    let columns = values(store, field);
    columns.iter().flat_map(Column::flags).copied().collect()
}

pub fn numbers(store: &ZarrStore, field: &str) -> Vec<f64> {
    let columns = values(store, field);
    columns.iter().flat_map(Column::numbers).copied().collect()
}

pub fn opened(place: &Place, store: &str) -> ZarrStore {
    ZarrStore::open(&place.store(store)).expect("a store")
}

#[test]
fn a_map_counts_its_states_by_verdict_in_text_and_json() {
    let place = Place::new(STUDY);
    let document = place.document("a.zarr", "");
    let count = |name: &str| document["verdicts"][name]["states"].as_u64();
    assert_eq!(document["states"], 36 * 34);
    assert_eq!(document["evaluated"], 36 * 34);
    assert_eq!(document["tiles_computed"], TILES);
    let stored = flags(&opened(&place, "a.zarr"), "verdict");
    for (flag, name) in ["stable", "physical", "zero-energy", "numerical"]
        .into_iter()
        .enumerate()
    {
        let states = stored.iter().filter(|other| **other == flag as i8).count();
        assert_eq!(count(name), Some(states as u64), "{name}");
    }
    let total: f64 = document["verdicts"]
        .as_object()
        .expect("verdicts")
        .values()
        .map(|share| share["share"].as_f64().expect("a number"))
        .sum();
    assert!((total - 1.0).abs() < 1e-12);

    let text = place.computed("b.zarr", "").stdout;
    let stable = count("stable").expect("a number").to_string();
    assert!(text.starts_with("a study\n"), "{text}");
    assert!(text.contains("stable") && text.contains(&stable), "{text}");
    assert!(
        text.contains("states/s") && text.contains("b.zarr"),
        "{text}"
    );
}

#[test]
fn a_map_agrees_with_the_state_command() {
    let place = Place::new(STUDY);
    place.computed("a.zarr", "");
    let store = opened(&place, "a.zarr");
    // Stretches of the last state of the first tile.
    let center = |n: f64| 0.2 + 1.8 * 7.5 / n;
    let stretch = format!("{:?},{:?}", center(36.0), center(34.0));
    let state = crate::document(&format!(
        "state --stretch {stretch} set frame=eulerian set current-lattice=regular set linearization=exact set support=1.9"
    ));
    let number = |field: &str| numbers(&store, field)[63];
    let answer = |pointer: &str| crate::number(&state, pointer);
    let words = [
        "stable",
        "physical",
        "zero-energy",
        "numerical",
        "suppressed",
    ];
    let verdict = words[flags(&store, "verdict")[63] as usize];
    assert_eq!(state["verdict"], verdict);
    for (field, pointer) in [
        ("acoustic_minimum", "/material/minimum_acoustic_eigenvalue"),
        ("scaled_minimum", "/discretization/minimum_scaled"),
        (
            "lowest_omega_squared",
            "/discretization/minimum_omega_squared/re",
        ),
        ("growth_rate", "/discretization/growth_rate"),
        ("critical_time_step", "/discretization/critical_time_step"),
    ] {
        crate::assert_close(number(field), answer(pointer), 1e-12);
    }
    let vector = &numbers(&store, "acoustic_direction")[2 * 63..2 * 64];
    assert_eq!(vector, crate::numbers(&state, "/material/direction"));
}

#[test]
fn a_quiet_map_prints_nothing_or_only_its_document() {
    let place = Place::new(STUDY);
    assert_eq!(place.computed("a.zarr", "--quiet --tiles 0..1").stdout, "");
    let document = place.document("a.zarr", "--quiet --tiles 1..2");
    assert_eq!(document["tiles_done"], 2);
}

#[test]
fn an_adaptive_map_has_the_verdicts_of_a_regular_map_with_fewer_computed_states() {
    let place = Place::new(&STUDY.replace("tile = 8", "tile = 64"));
    place.computed("regular.zarr", "");
    let document = place.document("adaptive.zarr", "--set map.adaptive=true");
    let (regular, adaptive) = (
        opened(&place, "regular.zarr"),
        opened(&place, "adaptive.zarr"),
    );
    for field in ["verdict", "stability"] {
        assert_eq!(flags(&adaptive, field), flags(&regular, field), "{field}");
    }
    let evaluated = flags(&adaptive, "evaluated");
    let computed = evaluated.iter().filter(|flag| **flag == 1).count();
    assert_eq!(document["evaluated"], computed);
    assert!(computed < evaluated.len(), "{computed} states computed");
    // Computed states have equal numbers; filled-in states have no numbers.
    let (left, right) = (
        numbers(&adaptive, "scaled_minimum"),
        numbers(&regular, "scaled_minimum"),
    );
    for (flag, (left, right)) in evaluated.iter().zip(left.iter().zip(&right)) {
        assert!(if *flag == 1 {
            left == right
        } else {
            left.is_nan()
        });
    }
}

/// Number of states common to a regular map and a finer adaptive map with different verdict or stability.
fn different_states(study: &str, finer: &str) -> (usize, usize) {
    let (regular, adaptive) = (Place::new(study), Place::new(finer));
    let options = "--set map.tile=256";
    regular.computed("regular.zarr", options);
    adaptive.computed(
        "adaptive.zarr",
        &format!("{options} --set map.adaptive=true"),
    );
    let stores = (
        opened(&regular, "regular.zarr"),
        opened(&adaptive, "adaptive.zarr"),
    );
    let (n, m) = (
        stores.0.tiling().shape.clone(),
        stores.1.tiling().shape.clone(),
    );
    let stride = m[0] / n[0];
    let field = |field: &str| (flags(&stores.0, field), flags(&stores.1, field));
    let (verdicts, stabilities) = (field("verdict"), field("stability"));
    let differs = |state: &usize| {
        let finer = (state / n[1]) * stride * m[1] + (state % n[1]) * stride;
        verdicts.0[*state] != verdicts.1[finer] || stabilities.0[*state] != stabilities.1[finer]
    };
    let states = verdicts.0.len();
    ((0..states).filter(differs).count(), states)
}

/// Study of a square window of stretches.
fn square_of(settings: &str, low: f64, high: f64, states: usize) -> String {
    let axis = |name: &str| {
        format!("[[axes]]\nquantity = '{name}'\nrange = [{low:?}, {high:?}]\nstates = {states}\n")
    };
    format!("{settings}\n{}{}", axis("stretch-1"), axis("stretch-2"))
}

#[test]
fn a_finer_adaptive_map_agrees_with_a_regular_map_at_common_states() {
    let settings = "[discretization]\nsupport = 1.9\nframe = 'eulerian'\ncurrent-lattice = 'regular'\nlinearization = 'exact'";
    // Every 8th of 256 states, starting with the first: the coarse window is shifted by 3.5 cells of the finer map.
    let shift = 3.5 * 1.8 / 256.0;
    let finer = square_of(settings, 0.2, 2.0, 256);
    let study = square_of(settings, 0.2 - shift, 2.0 - shift, 32);
    assert_eq!(different_states(&study, &finer), (0, 32 * 32));
}

#[test]
fn an_adaptive_map_of_a_ragged_domain_misses_less_than_a_thousandth_of_its_states() {
    let settings = "[discretization]\nsupport = 1.6\nframe = 'eulerian'\ncurrent-lattice = 'convected'\n\
                    support-size = 'fixed'\nlinearization = 'exact'";
    let study = square_of(settings, 0.2, 2.0, 96);
    let (different, states) = different_states(&study, &study);
    assert!(
        1000 * different < states,
        "{different} of {states} states differ"
    );
}

#[test]
fn a_section_through_a_map_of_three_axes_equals_the_map_of_two_axes() {
    let axes = "[[axes]]\nquantity = \"stretch-1\"\nrange = [0.3, 1.9]\nstates = 9\n\
                [[axes]]\nquantity = \"stretch-2\"\nrange = [0.3, 1.9]\nstates = 6\n";
    let settings = "[discretization]\nframe = \"eulerian\"\ncurrent-lattice = \"regular\"\n";
    let third = "[[axes]]\nquantity = \"discretization.support\"\nrange = [1.0, 2.0]\nstates = 4\n";
    let map = "[map]\ntile = 64\n";
    let space = Place::new(&format!("{settings}{axes}{third}{map}"));
    space.computed("a.zarr", "");
    let store = opened(&space, "a.zarr");
    assert_eq!(store.tiling().shape, [4, 6, 9]);
    for (section, support) in [1.125, 1.375, 1.625, 1.875].into_iter().enumerate() {
        let plane = Place::new(&format!("{settings}support = {support}\n{axes}{map}"));
        plane.computed("b.zarr", "");
        let states = 54 * section..54 * (section + 1);
        let expected = flags(&opened(&plane, "b.zarr"), "verdict");
        assert_eq!(flags(&store, "verdict")[states], expected, "{support}");
    }
}

#[test]
fn an_adaptive_map_of_three_axes_has_the_verdicts_of_a_regular_map() {
    let study = "[[axes]]\nquantity = \"stretch-1\"\nrange = [0.5, 2.5]\nstates = 16\n\
                 [[axes]]\nquantity = \"stretch-2\"\nrange = [0.5, 2.5]\nstates = 15\n\
                 [[axes]]\nquantity = \"stretch-3\"\nrange = [0.8, 1.2]\nstates = 9\n\
                 [map]\ntile = 64\n";
    let place = Place::new(study);
    place.computed("regular.zarr", "");
    let document = place.document(
        "adaptive.zarr",
        "--set map.adaptive=true --set map.refine-from=4",
    );
    let verdicts = |name: &str| flags(&opened(&place, name), "verdict");
    assert_eq!(verdicts("adaptive.zarr"), verdicts("regular.zarr"));
    assert!(document["evaluated"].as_u64() < document["states"].as_u64());
}

#[test]
fn a_store_is_named_after_its_study_by_default() {
    let place = Place::new(STUDY);
    let status = command(&["map", "study.toml", "--tiles", "0..1"])
        .current_dir(&place.folder)
        .output()
        .expect("the command starts");
    assert!(status.status.success());
    assert_eq!(opened(&place, "study.zarr").done().expect("readable"), 1);
}

#[test]
fn a_method_without_neighbors_is_undefined_but_its_continuum_is_computed() {
    let study = "[[axes]]\nquantity = \"stretch-1\"\nrange = [0.9, 1.1]\nstates = 2\n\
                 [[axes]]\nquantity = \"discretization.support\"\nrange = [0.1, 3.1]\nstates = 3\n";
    let place = Place::new(study);
    let document = place.document("a.zarr", "");
    assert_eq!(document["verdicts"]["undefined"]["states"], 2);
    let store = opened(&place, "a.zarr");
    let undefined: Vec<bool> = flags(&store, "verdict")
        .iter()
        .map(|flag| *flag == 5)
        .collect();
    assert_eq!(undefined, [true, true, false, false, false, false]);
    for (value, undefined) in numbers(&store, "scaled_minimum").iter().zip(&undefined) {
        assert_eq!(value.is_nan(), *undefined);
    }
    assert!(
        numbers(&store, "acoustic_minimum")
            .iter()
            .all(|value| *value > 0.0)
    );
}

#[test]
fn a_map_stores_exactly_the_outputs_in_its_study() {
    let text = STUDY.replace("tile = 8", "tile = 32\noutputs = [\"growth_rate\"]");
    let place = Place::new(&text);
    place.computed("few.zarr", "");
    let all = Place::new(STUDY);
    all.computed("all.zarr", "--set map.tile=32");
    let few = tree(&place.store("few.zarr"));
    let whole = tree(&all.store("all.zarr"));
    let arrays = |tree: &BTreeMap<PathBuf, Option<Vec<u8>>>| -> Vec<String> {
        let folders = tree.keys().filter(|path| path.components().count() == 1);
        let names = folders.map(|path| path.display().to_string());
        names.filter(|name| name != "zarr.json").collect()
    };
    let expected = [
        "component",
        "evaluated",
        "growth_rate",
        "stability",
        "stretch-1",
        "stretch-2",
        "verdict",
    ];
    assert_eq!(arrays(&few), expected);
    assert!(arrays(&whole).len() > expected.len());
    for name in ["growth_rate/c/0/0", "verdict/c/1/1"] {
        assert_eq!(few[Path::new(name)], whole[Path::new(name)], "{name}");
    }
    let store = place.store("few.zarr").display().to_string();
    let answer = onset(&["plot", &store, "--field", "scaled_minimum", "--out", &store]);
    assert_eq!(answer.code, Some(2));
    assert!(answer.stderr.contains("growth_rate"), "{}", answer.stderr);
}

#[test]
fn an_unknown_output_is_refused_with_the_available_outputs() {
    let place = Place::new(STUDY);
    let answer = place.map("none.zarr", "--set map.outputs=growth");
    assert_eq!(answer.code, Some(2));
    for fact in ["map.outputs", "growth_rate", "critical_time_step"] {
        assert!(answer.stderr.contains(fact), "{}", answer.stderr);
    }
}

#[test]
fn states_at_which_the_law_is_not_defined_are_undefined_in_a_map() {
    let text = STUDY
        .replace(
            "title = \"a study\"\n",
            "[material]\nmodel = \"gent\"\njm = 2.0\n",
        )
        .replace("tile = 8", "tile = 64")
        .replace("states = 36", "states = 12")
        .replace("states = 34", "states = 12");
    let place = Place::new(&text);
    let document = place.document("gent.zarr", "");
    let count = &document["verdicts"]["undefined"]["states"];
    let undefined = count.as_u64().expect("a count");
    assert!((1..144).contains(&undefined), "{document}");
}

#[test]
fn a_law_that_carries_no_waves_in_the_reference_configuration_is_refused() {
    let energy = "-(I1 - 3)";
    let answer = onset(&["state", "--stretch", "1.1,1", "--energy", energy]);
    assert_eq!(answer.code, Some(2), "{}", answer.stdout);
    assert!(
        answer.stderr.contains("carries no waves"),
        "{}",
        answer.stderr
    );
}

/// Peak memory of a process; KiB.
#[cfg(target_os = "linux")]
fn most_memory(mut child: std::process::Child) -> u64 {
    let path = format!("/proc/{}/status", child.id());
    let mut most = 0;
    loop {
        let status = fs::read_to_string(&path).unwrap_or_default();
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let size = line.and_then(|line| line.split_whitespace().next()?.parse().ok());
        most = size.unwrap_or(0).max(most);
        if let Some(status) = child.try_wait().expect("a child") {
            assert!(status.success());
            return most;
        }
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
}

/// Results of a tile are kept until it is finished: about 300 MB for a million states.
#[test]
#[cfg(target_os = "linux")]
fn the_memory_of_a_map_of_large_tiles_does_not_grow_with_its_threads() {
    let study = "[discretization]\nlattice = 'square'\nsupport = 1.6\nquadrature = 'nodal'\n\
                 [[axes]]\nquantity = 'stretch-1'\nrange = [0.2, 2.0]\nstates = 2048\n\
                 [[axes]]\nquantity = 'stretch-2'\nrange = [0.2, 2.0]\nstates = 1024\n\
                 [map]\nadaptive = true\ntile = 1024\n";
    let place = Place::new(study);
    let with = |threads: &str| {
        let arguments = place.arguments("a.zarr", "--overwrite --quiet");
        let mut command = crate::command(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
        command.env("RAYON_NUM_THREADS", threads);
        most_memory(command.spawn().expect("the command starts"))
    };
    let [one, four] = ["1", "4"].map(with);
    assert!(one > 100_000, "{one} KiB");
    assert!(2 * four < 3 * one, "{one} and {four} KiB");
}
