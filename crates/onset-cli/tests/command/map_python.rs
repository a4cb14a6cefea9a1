//! Stores in Python: xarray opens them without a warning.

use crate::map::{Place, STUDY};
use serde_json::{Value, json};
use std::process::Command;

/// Output of the script for a store; `None` without an interpreter, which `cargo xtask test` provides.
fn opened(place: &Place, store: &str) -> Option<Value> {
    let Some(python) = std::env::var_os("ONSET_PYTHON") else {
        eprintln!(
            "note: ONSET_PYTHON names no interpreter with xarray; nothing was opened. Run `cargo xtask test`."
        );
        return None;
    };
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/python/open_map.py");
    let output = Command::new(python)
        .arg(script)
        .arg(place.store(store))
        .output()
        .expect("the interpreter starts");
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{told}");
    Some(serde_json::from_slice(&output.stdout).expect("one JSON document"))
}

#[test]
fn xarray_opens_a_store_and_reads_the_verdicts_as_flags() {
    let place = Place::new(STUDY);
    let answer = place.document("a.zarr", "");
    let Some(seen) = opened(&place, "a.zarr") else {
        return;
    };
    assert_eq!(
        seen["dimensions"],
        json!({"stretch-2": 34, "stretch-1": 36, "component": 2})
    );
    assert_eq!(seen["order"], json!(["stretch-2", "stretch-1"]));
    assert_eq!(seen["conventions"], "CF-1.11");
    assert_eq!(seen["tolerance"], 1e-3);
    assert!(
        seen["study"]
            .as_str()
            .is_some_and(|text| text.contains("support = 1.9"))
    );
    assert_eq!(seen["units"]["stretch-1"], "1");
    // UDUNITS cannot read the unit, so that a separate attribute gives the dimension.
    assert_eq!(seen["units"]["growth_rate"], "1");
    assert_eq!(seen["unnamed"], json!([]));
    assert_eq!(
        seen["vectors"],
        json!(["acoustic_direction", "wave_vector"])
    );
    assert_eq!(seen["directions are unit vectors"], true);
    assert_eq!(seen["to do"], 0);
    let verdicts = answer["verdicts"].as_object().expect("verdicts");
    for (name, share) in verdicts {
        let states = seen["verdicts"].get(name).cloned().unwrap_or(json!(0));
        assert_eq!(states, share["states"], "{name}");
    }
}

#[test]
fn xarray_opens_an_unfinished_store() {
    let place = Place::new(STUDY);
    place.computed("a.zarr", "--tiles 3..5");
    let Some(seen) = opened(&place, "a.zarr") else {
        return;
    };
    // The finished tiles are a whole tile, and a tile at the edge with four columns.
    assert_eq!(seen["to do"], 34 * 36 - 64 - 32);
    assert_eq!(seen["numbers where nothing was computed"], 0);
}

#[test]
fn xarray_opens_a_map_of_three_axes() {
    let place = Place::new(
        "[[axes]]\nquantity = \"stretch-1\"\nrange = [0.8, 1.4]\nstates = 5\n\
         [[axes]]\nquantity = \"stretch-2\"\nrange = [0.8, 1.4]\nstates = 4\n\
         [[axes]]\nquantity = \"discretization.support\"\nrange = [1.4, 2.4]\nstates = 3\n",
    );
    place.computed("a.zarr", "");
    let Some(seen) = opened(&place, "a.zarr") else {
        return;
    };
    assert_eq!(
        seen["order"],
        json!(["discretization.support", "stretch-2", "stretch-1"])
    );
    assert_eq!(seen["undeformed"], "stable");
}
