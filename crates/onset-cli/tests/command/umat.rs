//! Commands with user materials.

use crate::fortran::library;
use crate::{Scratch, command, onset, onset_line};
use serde_json::Value;
use std::path::Path;
use std::time::Duration;

const HOSTILE: [&str; 1] = ["tests/fortran/hostile.f90"];

/// Assignments that select a library with properties.
fn set(library: &Path, properties: &str) -> String {
    routine("umat", library, properties)
}

/// Assignments that select a library with an interface and properties.
fn routine(model: &str, library: &Path, properties: &str) -> String {
    format!(
        "--set material.model={model} --set material.library={} --set material.properties={properties}",
        library.display()
    )
}

/// Compares every number of two documents with the same structure, except for the named parts.
fn compare(place: &str, a: &Value, b: &Value, check: &mut impl FnMut(&str, f64, f64)) {
    match (a, b) {
        (Value::Object(a), Value::Object(b)) => {
            for (name, value) in a {
                if !["model", "parameters", "settings", "next"].contains(&name.as_str()) {
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
fn a_state_with_a_umat_equals_the_state_with_the_built_in_law_of_the_same_energy() {
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
            // The position of a minimum is accurate only to the square root of the accuracy of its value.
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
fn a_vumat_and_a_function_in_c_are_answered_and_audited_like_the_built_in_law() {
    let law = crate::document(
        "state --stretch 1.2,0.9 --set material.model=blatz-ko --set material.mu=32",
    );
    let sources = [
        (
            "vumat",
            "fortran/blatz_ko_vumat.f90",
            "The tangent, from differences of the stress, is dP/dF",
        ),
        ("library", "c/blatz_ko_law.c", "A is dP/dF"),
        ("mfront", "tests/c/mfront_one.c", "K is dP/dF"),
    ];
    for (model, source, words) in sources {
        let material = routine(model, &library(&[source]), "32");
        let own = crate::document(&format!("state --stretch 1.2,0.9 {material}"));
        for part in ["verdict", "mechanism"] {
            assert_eq!(own[part], law[part], "{model}");
        }
        let omega = |answer: &Value| {
            answer["discretization"]["maximum_omega"]
                .as_f64()
                .expect("a frequency")
        };
        let (a, b) = (omega(&own), omega(&law));
        assert!((a - b).abs() < 1e-7 * b, "{model}: {a} {b}");
        let audit = onset_line(&format!("audit {material}"));
        assert_eq!(audit.code, Some(0), "{}", audit.stderr);
        assert!(audit.stdout.contains("Consistent"), "{}", audit.stdout);
        assert!(audit.stdout.contains(words), "{}", audit.stdout);
        assert!(!audit.stdout.contains("SSE"), "{}", audit.stdout);
    }
    let wrong = routine("vumat", &library(&["c/blatz_ko_law.c"]), "32");
    let refused = onset_line(&format!("state --stretch 1.2,0.9 {wrong}"));
    assert_eq!(refused.code, Some(2));
    assert!(refused.stderr.contains("has no routine vumat_"));
    let without = onset_line(&format!(
        "state --stretch 1.2,0.9 {}",
        routine("library", &library(&["c/blatz_ko_law.c"]), "1,2")
    ));
    assert!(
        without.stderr.contains("expected one property"),
        "{}",
        without.stderr
    );
}

#[test]
fn a_map_with_a_umat_equals_the_map_with_the_built_in_law() {
    let folder = Scratch::new("umat-study");
    std::fs::create_dir_all(&folder).expect("a folder");
    let library = library(&["fortran/blatz_ko.f90"]);
    let study = |name: &str, material: &str| {
        let file = folder.join(format!("{name}.toml"));
        let text = format!(
            "[material]\n{material}\n[[axes]]\nquantity = \"stretch-1\"\nrange = [0.5, 3.0]\nstates = 12\n\
             [[axes]]\nquantity = \"stretch-2\"\nrange = [0.5, 3.0]\nstates = 12\n"
        );
        std::fs::write(&file, text).expect("a file");
        let store = folder.join(format!("{name}.zarr"));
        let (file, store) = (file.display().to_string(), store.display().to_string());
        let library = library.display().to_string();
        let answer = onset(&[
            "map",
            &file,
            "--out",
            &store,
            "--json",
            "--allow-library",
            &library,
        ]);
        assert_eq!(answer.code, Some(0), "{}", answer.stderr);
        let summary: Value = serde_json::from_str(&answer.stdout).expect("JSON");
        summary["verdicts"].clone()
    };
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
}

#[test]
fn failures_of_a_umat_are_reported_with_exit_code_2() {
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
        (8, "", "requests a smaller increment"),
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
fn invalid_libraries_are_reported_with_exit_code_2() {
    let text = Scratch::new("text.so");
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
    let answer = onset_line("state --stretch 1.2,0.9 --set material.model=umat");
    assert_eq!(answer.code, Some(2));
    assert!(
        answer.stderr.contains("needs material.library"),
        "{}",
        answer.stderr
    );
}

/// Folder with a user-defined library and files that name it.
struct Strange {
    folder: Scratch,
    library: String,
}

impl Strange {
    fn new(name: &str) -> Self {
        let folder = Scratch::new(name);
        std::fs::create_dir_all(&folder).expect("a folder");
        let own = folder.join("own.so");
        std::fs::copy(library(&["fortran/blatz_ko.f90"]), &own).expect("a copy");
        let material = "[material]\nmodel = \"umat\"\nlibrary = \"own.so\"\nproperties = [32.0]\n";
        let axes = "[[axes]]\nquantity = \"stretch-1\"\nrange = [0.9, 1.2]\nstates = 9\n\
                    [[axes]]\nquantity = \"stretch-2\"\nrange = [0.9, 1.2]\nstates = 9\n[map]\ntile = 8\n";
        let methods = "[[methods]]\nname = \"nodes\"\nquadrature = \"nodal\"\n";
        std::fs::write(folder.join("study.toml"), format!("{material}{axes}")).expect("a file");
        std::fs::write(folder.join("compare.toml"), format!("{material}{methods}"))
            .expect("a file");
        Self {
            library: own.display().to_string(),
            folder,
        }
    }

    fn run(&self, line: &str) -> crate::Answer {
        self.run_with(line, |_| {})
    }

    fn run_with(&self, line: &str, change: impl Fn(&mut std::process::Command)) -> crate::Answer {
        let words: Vec<&str> = line.split_whitespace().collect();
        let mut command = command(&words);
        command
            .current_dir(&self.folder)
            .env_remove("ONSET_ALLOW_LIBRARY");
        change(&mut command);
        let output = command.output().expect("the command starts");
        crate::Answer {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).expect("UTF-8"),
            stderr: String::from_utf8(output.stderr).expect("UTF-8"),
        }
    }

    /// Returns true if a command loads the library, which requires a process.
    fn loads(&self, line: &str) -> bool {
        // Program that only records its start.
        let trace = self.folder.join("trace");
        let host = self.folder.join("host.sh");
        std::fs::write(&host, format!("#!/bin/sh\ntouch {}\n", trace.display())).expect("a file");
        std::process::Command::new("chmod")
            .args(["+x".as_ref(), host.as_os_str()])
            .status()
            .expect("chmod");
        let _ = std::fs::remove_file(&trace);
        self.run_with(line, |command| {
            command.env("ONSET_UMAT_HOST", &host);
        });
        trace.exists()
    }
}

#[test]
fn a_file_loads_a_library_only_if_the_user_allows_it() {
    let place = Strange::new("strange");
    let commands = [
        "map study.toml --out a.zarr",
        "boundary study.toml",
        "card study.toml",
        "criteria study.toml",
        "compare compare.toml",
        "recommend compare.toml",
        // The model alone does not imply that the user trusts the library.
        "map study.toml --out a.zarr --set material.model=umat",
    ];
    for line in commands {
        let answer = place.run(line);
        assert_eq!(answer.code, Some(2), "{line}: {}", answer.stderr);
        for fact in ["toml:3:", "--allow-library own.so", "ONSET_ALLOW_LIBRARY"] {
            assert!(answer.stderr.contains(fact), "{line}: {}", answer.stderr);
        }
        assert!(!place.loads(line), "{line}");
        let others = format!("{line} --allow-library other.so");
        assert!(!place.loads(&others), "{others}");
        for allowed in ["own.so", "./own.so", "."] {
            let line = format!("{line} --allow-library {allowed}");
            assert!(place.loads(&line), "{line}");
        }
    }
    assert!(
        place.loads("map study.toml --out b.zarr --set material.library=own.so"),
        "the user's word"
    );
    let by_variable = place.run_with("map study.toml --quiet --out c.zarr", |command| {
        command.env("ONSET_ALLOW_LIBRARY", format!("/nowhere:{}", place.library));
    });
    assert_eq!(by_variable.code, Some(0), "{}", by_variable.stderr);
}

#[test]
fn a_study_is_checked_and_a_map_is_drawn_without_loading_its_library() {
    let place = Strange::new("drawn");
    let answer = place.run("check study.toml");
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    assert!(
        answer.stdout.contains("nothing was loaded"),
        "{}",
        answer.stdout
    );
    assert!(!place.loads("check study.toml"));
    assert!(place.loads("check study.toml --allow-library own.so"));
    for out in ["a.zarr", "b.zarr"] {
        let answer = place.run(&format!(
            "map study.toml --quiet --out {out} --allow-library own.so"
        ));
        assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    }
    for line in [
        "plot a.zarr",
        "plot a.zarr --no-trace",
        "plot a.zarr b.zarr",
        "plot a.zarr --field growth_rate",
    ] {
        let answer = place.run(line);
        assert_eq!(answer.code, Some(0), "{line}: {}", answer.stderr);
        assert!(!place.loads(line), "{line}");
    }
    let drawn = || std::fs::read_to_string(place.folder.join("map.svg")).expect("a figure");
    place.run("plot a.zarr");
    assert!(drawn().contains("library of the material was not loaded"));
    assert!(place.loads("plot a.zarr --allow-library own.so"));
    assert_eq!(
        place.run("plot a.zarr --allow-library own.so").code,
        Some(0)
    );
    assert!(!drawn().contains("was not loaded"));
}

#[test]
fn a_map_is_not_resumed_with_another_library() {
    let place = Strange::new("identity");
    let own = place.folder.join("own.so");
    let first = std::fs::read(&own).expect("a library");
    let map = |more: &str| {
        place.run(&format!(
            "map study.toml --quiet --out a.zarr --allow-library own.so {more}"
        ))
    };
    assert_eq!(map("--tiles 0..1").code, Some(0));
    // The library is recompiled: another file takes its place, whose additional bytes the loader ignores.
    std::fs::write(&own, [&first[..], b"anew"].concat()).expect("a file");
    for more in ["--resume", "--tiles 1..2"] {
        let answer = map(more);
        assert_eq!(answer.code, Some(2), "{}", answer.stderr);
        for fact in [
            "library of its material has another",
            "SHA-256",
            "recompiled",
        ] {
            assert!(answer.stderr.contains(fact), "{}", answer.stderr);
        }
    }
    let sum = onset_umat::fingerprint(&own).expect("a sum");
    assert!(map("--resume").stderr.contains(&sum));
    std::fs::write(&own, first).expect("a file");
    assert_eq!(map("--resume").code, Some(0));
}

#[test]
#[cfg(target_os = "linux")]
fn no_folder_is_left_behind_and_foreign_folders_are_not_used() {
    use std::os::unix::fs::symlink;
    let place = Scratch::new("temporary");
    std::fs::create_dir_all(place.join("tmp")).expect("a folder");
    std::fs::write(place.join("victim"), "precious").expect("a file");
    // Folders planted by an attacker who guesses names are not used.
    for process in 0..50 {
        symlink(
            place.join("victim"),
            place.join(format!("tmp/onset-umat-{process}-0")),
        )
        .expect("a link");
    }
    let own = place.join("own.so");
    std::fs::copy(library(&HOSTILE), &own).expect("a copy");
    let folders = || {
        let entries = std::fs::read_dir(place.join("tmp")).expect("a folder");
        let kinds = entries.map(|entry| entry.expect("one").file_type().expect("a kind"));
        kinds.filter(|kind| kind.is_dir()).count()
    };
    let started = |flaw: u32| {
        let line = format!(
            "state --stretch 1.2,0.9 {}",
            set(&own, &format!("10,4,{flaw}"))
        );
        let words = crate::words(&line);
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let mut command = command(&words);
        command.env("TMPDIR", place.join("tmp"));
        command
            .stdout(std::process::Stdio::null())
            .stderr(std::process::Stdio::null());
        command.spawn().expect("the command starts")
    };
    for (signal, code) in [("-TERM", Some(130)), ("-INT", Some(130)), ("-KILL", None)] {
        let mut child = started(2);
        while folders() == 0 {
            std::thread::sleep(Duration::from_millis(10));
        }
        std::process::Command::new("kill")
            .args([signal, &child.id().to_string()])
            .status()
            .expect("kill");
        assert_eq!(child.wait().expect("an end").code(), code, "{signal}");
        if code.is_some() {
            assert_eq!(folders(), 0, "{signal}");
        }
    }
    // After a kill the other process cleans up; if it was killed too, the next command does.
    std::fs::create_dir(place.join("tmp/onset-umat-left")).expect("a folder");
    assert!(started(4).wait().expect("an end").success());
    for _ in 0..100 {
        if folders() == 0 {
            break;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    assert_eq!(folders(), 0);
    assert_eq!(
        std::fs::read_to_string(place.join("victim")).expect("a file"),
        "precious"
    );
}

/// The command is killed without a chance to clean up while the routine is in an endless loop.
#[test]
#[cfg(target_os = "linux")]
fn no_process_outlives_a_killed_command() {
    use std::os::unix::ffi::OsStrExt;
    let own = Scratch::new("outlives.so");
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
}

#[test]
fn every_utility_routine_of_abaqus_is_printed() {
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
