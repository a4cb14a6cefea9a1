//! User materials, as a user sees them.

use crate::fortran::library;
use crate::{command, onset, onset_line};
use serde_json::Value;
use std::path::Path;
use std::time::Duration;

const HOSTILE: [&str; 1] = ["tests/fortran/hostile.f90"];

/// The assignments that choose a library with properties.
fn set(library: &Path, properties: &str) -> String {
    format!(
        "--set material.model=umat --set material.library={} --set material.properties={properties}",
        library.display()
    )
}

/// Every number of two documents that are built alike, apart from parts that are named.
fn compare(place: &str, a: &Value, b: &Value, check: &mut impl FnMut(&str, f64, f64)) {
    match (a, b) {
        (Value::Object(a), Value::Object(b)) => {
            for (name, value) in a {
                if !["model", "parameters", "settings"].contains(&name.as_str()) {
                    compare(&format!("{place}/{name}"), value, &b[name], check);
                }
            }
        }
        (Value::Array(a), Value::Array(b)) => {
            assert_eq!(a.len(), b.len(), "{place}");
            for (a, b) in a.iter().zip(b) {
                compare(place, a, b, check);
            }
        }
        (Value::Number(a), Value::Number(b)) => {
            let number = |n: &serde_json::Number| n.as_f64().expect("a number");
            check(place, number(a), number(b));
        }
        _ => assert_eq!(a, b, "{place}"),
    }
}

#[test]
fn a_state_is_the_same_with_the_umat_and_with_the_built_in_law_of_the_same_energy() {
    let umat = set(&library(&["fortran/blatz_ko.f90"]), "32");
    let law = "--set material.model=blatz-ko --set material.mu=32";
    for state in [
        "--stretch 1.2,0.9",
        "--deformation-gradient 1.1,0.3,-0.1,0.8",
        "--deformation-gradient 2.4,0.1,0.2,0.6",
    ] {
        let document = |material: &str| crate::document(&format!("state {state} {material}"));
        let (a, b) = (document(law), document(&umat));
        let mut count = 0;
        compare("", &a, &b, &mut |place, a, b| {
            // Where a minimum lies is known to the root of the accuracy of its value only.
            let is_a_place = ["direction", "vector", "polarization", "gradient_norm"]
                .iter()
                .any(|word| place.contains(word));
            let tolerance = if is_a_place { 1e-6 } else { 1e-9 };
            let error = (a - b).abs();
            assert!(
                error <= tolerance * a.abs().max(1.0),
                "{state} {place}: {a} {b}"
            );
            count += 1;
        });
        assert!(count > 100);
    }
}

#[test]
fn a_study_file_takes_a_umat_and_its_map_is_that_of_the_built_in_law() {
    let folder = crate::fresh_place("umat-study");
    std::fs::create_dir_all(&folder).expect("a folder");
    let study = |name: &str, material: &str| {
        let file = folder.join(format!("{name}.toml"));
        let text = format!(
            "[material]\n{material}\n[[axes]]\nquantity = \"stretch-1\"\nrange = [0.5, 3.0]\nstates = 12\n\
             [[axes]]\nquantity = \"stretch-2\"\nrange = [0.5, 3.0]\nstates = 12\n"
        );
        std::fs::write(&file, text).expect("a file");
        let store = folder.join(format!("{name}.zarr"));
        let (file, store) = (file.display().to_string(), store.display().to_string());
        let answer = onset(&["map", &file, "--out", &store, "--json"]);
        assert_eq!(answer.code, Some(0), "{}", answer.stderr);
        let summary: Value = serde_json::from_str(&answer.stdout).expect("JSON");
        summary["verdicts"].clone()
    };
    let library = library(&["fortran/blatz_ko.f90"]);
    let umat = study(
        "umat",
        &format!(
            "model = \"umat\"\nlibrary = \"{}\"\nproperties = [32.0]",
            library.display()
        ),
    );
    let law = study("law", "model = \"blatz-ko\"\nmu = 32.0");
    assert_eq!(umat, law);
    let stable = law["stable"]["states"].as_u64().expect("a number");
    assert!(stable > 0 && stable < 144, "{law:#}");
    std::fs::remove_dir_all(folder).expect("the folder is removed");
}

#[test]
fn what_goes_wrong_in_a_umat_is_told_with_exit_code_2() {
    let hostile = library(&HOSTILE);
    let state = |flaw: u32, more: &str| {
        let material = set(&hostile, &format!("10,4,{flaw}"));
        onset_line(&format!("state --stretch 1.2,0.9 {material} {more}"))
    };
    assert_eq!(state(0, "").code, Some(0));
    for (flaw, more, words) in [
        (1, "", "signal 11"),
        (2, "--set material.time-limit=1", "no answer within 1 s"),
        (3, "", "NaN in STRESS(2)"),
        (5, "", "exit code 0"),
        (6, "", "negative stretch"),
        (7, "", "STATEV"),
        (8, "", "PNEWDT"),
    ] {
        let answer = state(flaw, more);
        assert_eq!(answer.code, Some(2), "flaw {flaw}: {}", answer.stderr);
        assert!(answer.stderr.contains(words), "{}", answer.stderr);
        assert!(answer.stderr.contains("at F = [1"), "{}", answer.stderr);
        assert_eq!(answer.stdout, "");
    }
    let answer = state(4, "");
    assert_eq!(answer.code, Some(0));
    assert!(!answer.stdout.contains("iteration"));
}

#[test]
fn libraries_that_are_none_are_told_with_exit_code_2() {
    let text = crate::fresh_place("text.so");
    std::fs::write(&text, "no library").expect("a file");
    let utilities = library(&["fortran/abaqus_utilities.f90"]);
    for (file, words) in [
        (Path::new("nowhere.so"), "there is no library"),
        (&text, "cannot load"),
        (&utilities, "no routine umat_"),
    ] {
        let answer = onset_line(&format!("state --stretch 1.2,0.9 {}", set(file, "1")));
        assert_eq!(answer.code, Some(2));
        assert!(answer.stderr.contains(words), "{}", answer.stderr);
    }
    std::fs::remove_file(text).expect("the file is removed");
    let answer = onset_line("state --stretch 1.2,0.9 --set material.model=umat");
    assert_eq!(answer.code, Some(2));
    assert!(
        answer.stderr.contains("needs material.library"),
        "{}",
        answer.stderr
    );
}

/// Killed without a chance to clean up, while the routine is in an endless loop.
#[test]
#[cfg(target_os = "linux")]
fn no_process_outlives_a_killed_command() {
    use std::os::unix::ffi::OsStrExt;
    let own = crate::fresh_place("outlives.so");
    std::fs::copy(library(&HOSTILE), &own).expect("a copy");
    let running = || {
        let name = own.as_os_str().as_bytes();
        std::fs::read_dir("/proc")
            .expect("processes")
            .filter_map(|entry| std::fs::read(entry.ok()?.path().join("cmdline")).ok())
            .any(|line| line.split(|byte| *byte == 0).any(|word| word == name))
    };
    let wait_for = |wanted: bool| {
        for _ in 0..200 {
            if running() == wanted {
                return;
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        panic!("still {}", !wanted);
    };
    let words = crate::words(&format!("state --stretch 1.2,0.9 {}", set(&own, "10,4,2")));
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let mut child = command(&words).spawn().expect("the command starts");
    wait_for(true);
    child.kill().expect("killed");
    child.wait().expect("ended");
    wait_for(false);
    std::fs::remove_file(own).expect("the copy is removed");
}

#[test]
fn the_utilities_of_abaqus_are_printed_as_they_are_compiled() {
    let printed = onset(&["umat-utilities"]).stdout;
    for routine in [
        "sinv",
        "sprinc",
        "sprind",
        "rotsig",
        "xit",
        "stdb_abqerr",
        "getoutdir",
    ] {
        assert!(printed.contains(&format!("end subroutine {routine}")));
    }
}
