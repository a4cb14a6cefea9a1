//! Former names of keys, commands, topics and stored flags are accepted, with a note.

use crate::map::{Place, STUDY};
use crate::onset_line;
use std::fs;

/// Standard output and notes of a command line.
fn noted(line: &str) -> (String, String) {
    let answer = onset_line(line);
    assert_eq!(answer.code, Some(0), "{line}: {}", answer.stderr);
    (answer.stdout, answer.stderr)
}

#[test]
fn former_names_are_accepted_with_a_note() {
    for (earlier, now, note) in [
        (
            "state --stretch 1.1,1 set arrangement=square",
            "state --stretch 1.1,1 set lattice=square",
            "note: `discretization.arrangement` is now called `discretization.lattice`",
        ),
        (
            "state --stretch 1.1,1 set frame=eulerian set lattice=regular",
            "state --stretch 1.1,1 set frame=eulerian set current-lattice=regular",
            "note: `discretization.lattice = regular` is now written `discretization.current-lattice = regular`",
        ),
        (
            "notions --mode hydrostatic --range 0.9,1.1",
            "criteria --mode hydrostatic --range 0.9,1.1",
            "note: `onset notions` is now called `onset criteria`",
        ),
        (
            "list arrangements",
            "list lattices",
            "note: the topic `arrangements` is now called `lattices`",
        ),
    ] {
        let (told, notes) = noted(earlier);
        let (expected, silence) = noted(now);
        assert_eq!(told, expected, "{earlier}");
        assert!(notes.starts_with(note), "{earlier}: {notes}");
        assert_eq!(notes.lines().count(), 1, "{earlier}: {notes}");
        assert_eq!(silence, "", "{now}");
    }
}

#[test]
fn former_and_present_name_of_a_lattice_in_one_study_keep_their_meaning() {
    let place = Place::new(
        "[discretization]\narrangement = \"square\"\nframe = \"eulerian\"\nlattice = \"regular\"\n",
    );
    let study = place.arguments("a.zarr", "")[1].clone();
    let (told, notes) = noted(&format!("state {study} --stretch 1.1,1"));
    assert!(told.contains("lattice square"), "{told}");
    assert!(told.contains("current-lattice regular"), "{told}");
    assert_eq!(notes.lines().count(), 2, "{notes}");
}

/// A store of format 2 becomes a store of the present format by renaming.
#[test]
fn a_store_with_former_names_is_drawn_and_not_resumed() {
    let place = Place::new(STUDY);
    place.computed("a.zarr", "");
    let metadata = place.store("a.zarr").join("zarr.json");
    let mut text = fs::read_to_string(&metadata).expect("a file");
    for (now, earlier) in [
        ("\"onset_format\": 3", "\"onset_format\": 2"),
        (
            "stable physical zero-energy numerical suppressed",
            "stable material rank-deficient kernel missed",
        ),
        (
            "the origin of the first instability",
            "to whom the first instability belongs",
        ),
        ("\\nlattice = ", "\\narrangement = "),
        ("\\ncurrent-lattice = ", "\\nlattice = "),
    ] {
        assert!(text.contains(now), "{now}");
        text = text.replace(now, earlier);
    }
    fs::write(&metadata, text).expect("a file");
    let store = place.store("a.zarr").display().to_string();
    let (_, notes) = noted(&format!("plot {store} --out {store}.png"));
    assert_eq!(notes, "");
    let again = place.map("a.zarr", "--resume");
    assert_eq!(again.code, Some(2), "{}", again.stdout);
    assert!(again.stderr.contains("format 2"), "{}", again.stderr);
}
