//! Failures of user code: each failure gives an error with its reason, and leaves no files or processes behind.

use crate::{blatz_ko, general, library, settings};
use nalgebra::Matrix3;
use onset::kinematics::DeformationGradient;
use onset::material::{Hyperelastic, MaterialError};
use onset_umat::{Outcome, Umat, UmatError, UmatSettings};
use std::path::{Path, PathBuf};
use std::time::Duration;

const HOSTILE: [&str; 1] = ["tests/fortran/hostile.f90"];

/// UMAT with a flaw; 0 means no flaw.
fn hostile(flaw: u32) -> Umat {
    Umat::new(flawed(flaw)).expect("a UMAT")
}

fn flawed(flaw: u32) -> UmatSettings {
    settings(&HOSTILE, &[10.0, 4.0, f64::from(flaw)])
}

fn asked(umat: &Umat) -> Result<Outcome, UmatError> {
    umat.along(umat.path(&general()).expect("a path"))
}

#[track_caller]
fn ended(umat: &Umat) -> (String, String) {
    match asked(umat) {
        Err(UmatError::Ended { how, output, state }) => {
            assert_eq!(state.as_deref(), Some(&general().matrix()));
            (how, output)
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_crash_is_reported_with_signal_and_state_and_the_material_remains_usable() {
    let umat = hostile(1);
    for _ in 0..2 {
        let (how, _) = ended(&umat);
        assert!(how.contains("signal 11"), "{how}");
    }
    let message = umat.response(&general()).expect_err("a crash").to_string();
    assert!(
        message.contains("at F = [1.2, 0.3, -0.1; -0.2,"),
        "{message}"
    );
}

#[test]
fn an_endless_loop_ends_at_the_limit() {
    let limit = Duration::from_millis(300);
    let umat = Umat::new(UmatSettings {
        time_limit: limit,
        ..flawed(2)
    })
    .expect("a UMAT");
    match asked(&umat) {
        Err(UmatError::Silent { seconds, state, .. }) => {
            assert_eq!(seconds, limit.as_secs_f64());
            assert_eq!(state.as_deref(), Some(&general().matrix()));
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn stop_is_reported_with_its_output() {
    let (how, _) = ended(&hostile(5));
    assert!(how.contains("exit code 0"), "{how}");
    let (how, output) = ended(&hostile(6));
    assert!(how.contains("exit code 1"), "{how}");
    assert!(output.contains("negative stretch"), "{output}");
}

#[test]
fn a_result_that_is_not_a_number_is_reported_with_its_position() {
    match asked(&hostile(3)) {
        Err(UmatError::NotFinite { what, .. }) => assert!(what.contains("STRESS(2)"), "{what}"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn reading_a_missing_property_is_detected() {
    match asked(&hostile(10)) {
        Err(UmatError::NotFinite { properties, .. }) => assert_eq!(properties, 3),
        other => panic!("{other:?}"),
    }
}

#[test]
fn writing_beyond_the_state_variables_is_detected() {
    let overrun = |result| matches!(result, Err(UmatError::Overrun { variables: 0, .. }));
    assert!(overrun(asked(&hostile(7))));
    let wide_enough = Umat::new(UmatSettings {
        state_variables: 1,
        ..flawed(0)
    });
    assert!(asked(&wide_enough.expect("a UMAT")).is_ok());
}

#[test]
fn writing_beyond_the_ends_of_an_argument_is_reported_with_its_name() {
    for (flaw, expected) in [
        (14, "STRESS"),
        (15, "DDSDDE"),
        (16, "STRESS"),
        (17, "DDSDDT"),
    ] {
        let umat = hostile(flaw);
        for _ in 0..2 {
            match asked(&umat) {
                Err(UmatError::Overrun { argument, .. }) => assert_eq!(argument, expected),
                other => panic!("{other:?}"),
            }
        }
        let message = umat
            .response(&general())
            .expect_err("an overrun")
            .to_string();
        assert!(
            message.contains(&format!("ends of {expected}")),
            "{message}"
        );
    }
}

#[test]
fn changes_of_input_arguments_do_not_persist_to_the_next_call() {
    let umat = hostile(21);
    let quiet = hostile(0);
    for _ in 0..3 {
        assert_eq!(asked(&umat), asked(&quiet));
    }
}

#[test]
#[cfg(target_os = "linux")]
fn memory_is_limited() {
    let with = |hundred_millions: f64, memory_limit: u64| {
        let umat = Umat::new(UmatSettings {
            properties: vec![10.0, 4.0, 18.0, hundred_millions],
            memory_limit,
            ..flawed(18)
        });
        asked(&umat.expect("a UMAT"))
    };
    // The routine uses 0.8 GB.
    assert!(with(1.0, 2 << 30).is_ok());
    for result in [with(1.0, 1 << 29), with(100.0, 2 << 30)] {
        match &result {
            Err(UmatError::Ended { .. }) => {
                let message = result.expect_err("an end").to_string();
                assert!(message.contains("material.memory-limit"), "{message}");
            }
            other => panic!("{other:?}"),
        }
    }
}

/// A process may wait for its children without using processor time, so that the system must end a child in an endless loop.
#[test]
#[cfg(target_os = "linux")]
fn processes_started_by_a_umat_end_with_the_umat() {
    let own = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("forks.so");
    std::fs::copy(library(&HOSTILE), &own).expect("a copy");
    let umat = Umat::new(UmatSettings {
        library: own.clone(),
        ..flawed(19)
    })
    .expect("a UMAT");
    for started in 2..5 {
        assert!(asked(&umat).is_ok());
        assert_eq!(processes(&own), started);
    }
    drop(umat);
    // Killed orphans exist until the system has reaped them.
    for _ in 0..200 {
        if processes(&own) == 0 {
            return;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("{} processes are left", processes(&own));
}

#[test]
fn output_of_a_umat_cannot_control_a_terminal() {
    let (_, output) = ended(&hostile(20));
    assert!(output.starts_with("red\n"), "{output:?}");
    assert!(
        output
            .chars()
            .all(|letter| letter == '\n' || !letter.is_control()),
        "{output:?}"
    );
}

#[test]
fn a_library_that_is_recompiled_while_in_use_is_refused() {
    let own = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("anew.so");
    std::fs::copy(library(&HOSTILE), &own).expect("a copy");
    let umat = Umat::new(UmatSettings {
        library: own.clone(),
        ..flawed(11)
    })
    .expect("a UMAT");
    let first = onset_umat::fingerprint(&own).expect("a sum");
    assert_eq!(umat.settings().fingerprint, Some(first.clone()));
    // A new file replaces the library, as when a linker writes it; the process that has loaded the first file continues with it.
    std::fs::remove_file(&own).expect("removed");
    std::fs::copy(library(&["fortran/blatz_ko.f90"]), &own).expect("a copy");
    let stretched = |stretch| vec![Matrix3::from_diagonal_element(stretch)];
    assert!(umat.along(stretched(1.1)).is_ok());
    assert!(umat.along(stretched(3.0)).is_err(), "its process has ended");
    match umat.along(stretched(1.1)) {
        Err(UmatError::Changed { wanted, found, .. }) => {
            assert_eq!(wanted, first);
            assert_ne!(found, first);
        }
        other => panic!("{other:?}"),
    }
}

/// Library that records in a file that it was loaded.
fn telling(trace: &Path) -> PathBuf {
    let file = |name: &str| PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let (source, library) = (file("telling.c"), file("telling.so"));
    let text = "#include <stdio.h>\n\
                void umat_(void) {}\n\
                __attribute__((constructor)) static void loaded(void) { fclose(fopen(TRACE, \"w\")); }\n";
    std::fs::write(&source, text).expect("a file");
    let status = std::process::Command::new("cc")
        .args(["-shared", "-fPIC", "-o"])
        .args([&library, &source])
        .arg(format!("-DTRACE=\"{}\"", trace.display()))
        .status();
    assert!(status.expect("a C compiler").success());
    library
}

#[test]
fn no_code_of_an_exchanged_library_runs() {
    let file = |name: &str| PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let (trace, link) = (file("telling.trace"), file("turned.so"));
    let _ = std::fs::remove_file(&trace);
    let other = telling(&trace);
    let with = |fingerprint: Option<String>| {
        Umat::new(UmatSettings {
            library: link.clone(),
            fingerprint,
            ..flawed(0)
        })
    };
    let turn = |target: &Path| {
        let _ = std::fs::remove_file(&link);
        std::os::unix::fs::symlink(target, &link).expect("a link");
    };
    turn(&library(&HOSTILE));
    let first = onset_umat::fingerprint(&link).expect("a sum");
    assert!(with(Some(first.clone())).is_ok());
    turn(&other);
    let refused = with(Some(first)).err();
    assert!(
        matches!(refused, Some(UmatError::Changed { .. })),
        "{refused:?}"
    );
    assert!(!trace.exists(), "the other library was loaded");
    assert!(with(None).is_ok());
    assert!(trace.exists(), "this library tells that it is loaded");
}

#[test]
fn a_library_overwritten_while_in_use_continues_unchanged() {
    let own = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("over.so");
    std::fs::copy(library(&HOSTILE), &own).expect("a copy");
    let umat = Umat::new(UmatSettings {
        library: own.clone(),
        ..flawed(0)
    })
    .expect("a UMAT");
    // The file is overwritten in place, as by `cp`: pages that are not yet in memory are lost.
    std::fs::write(&own, "no library").expect("a file");
    assert_eq!(asked(&umat), asked(&hostile(0)));
}

#[test]
fn a_pipe_in_place_of_a_library_is_refused_without_blocking() {
    let pipe = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("pipe.so");
    let _ = std::fs::remove_file(&pipe);
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    assert!(made.expect("mkfifo").success());
    assert!(onset_umat::fingerprint(&pipe).is_err());
    let refused = Umat::new(UmatSettings {
        library: pipe,
        ..flawed(0)
    });
    assert!(refused.is_err());
}

#[test]
fn a_library_larger_than_the_memory_limit_is_not_copied() {
    let large = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("large.so");
    let file = std::fs::File::create(&large).expect("a file");
    // A sparse file, which takes no space until it is copied.
    file.set_len(1 << 40).expect("a hole");
    let refused = Umat::new(UmatSettings {
        library: large.clone(),
        ..flawed(0)
    });
    std::fs::remove_file(large).expect("removable");
    let told = refused.err().expect("a refusal").to_string();
    assert!(told.contains("material.memory-limit"), "{told}");
}

#[test]
fn a_request_for_smaller_increments_is_reported() {
    match asked(&hostile(8)) {
        Err(UmatError::SmallerIncrement {
            factor, increment, ..
        }) => assert_eq!((factor, increment), (0.25, 1)),
        other => panic!("{other:?}"),
    }
}

#[test]
fn output_of_a_umat_and_its_unnamed_files_have_no_side_effects() {
    for flaw in [4, 13] {
        let umat = hostile(flaw);
        let quiet = hostile(0);
        for _ in 0..3 {
            assert_eq!(asked(&umat), asked(&quiet));
        }
    }
    assert!(!Path::new("fort.7").exists());
}

#[test]
fn after_a_failure_in_a_batch_the_other_states_are_computed() {
    let umat = hostile(11);
    let paths: Vec<_> = [0.1, 0.7, 0.2, 0.8, 0.3]
        .into_iter()
        .map(|strain: f64| {
            let f = DeformationGradient::from_stretches([strain.exp(), 1.0, 1.0]);
            umat.path(&f.expect("admissible")).expect("a path")
        })
        .collect();
    let answered: Vec<bool> = umat.along_all(&paths).iter().map(Result::is_ok).collect();
    assert_eq!(answered, [true, false, true, false, true]);
}

#[test]
fn files_that_are_not_libraries_are_refused_with_the_reason() {
    let refusal = |settings: UmatSettings| Umat::new(settings).err().expect("a refusal");
    let file = |name: &str| PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let at = |library: PathBuf| UmatSettings {
        library,
        ..flawed(0)
    };

    let error = refusal(at(file("nowhere.so")));
    assert!(matches!(error, UmatError::NoLibrary { .. }), "{error}");

    let text = file("text.so");
    std::fs::write(&text, "subroutine umat\nend\n".repeat(100)).expect("a file");
    let error = refusal(at(text));
    assert!(matches!(error, UmatError::Load { .. }), "{error}");
    assert!(error.to_string().contains("gfortran -shared"), "{error}");

    // The same library, marked for a machine that does not exist.
    let mut bytes = std::fs::read(library(&HOSTILE)).expect("the library");
    bytes[18..20].copy_from_slice(&[0xf7, 0x00]);
    let foreign = file("foreign.so");
    std::fs::write(&foreign, bytes).expect("a file");
    let error = refusal(at(foreign));
    assert!(matches!(error, UmatError::Load { .. }), "{error}");
    if cfg!(target_os = "linux") {
        assert!(error.to_string().contains("architecture"), "{error}");
    }

    let error = refusal(at(library(&["fortran/abaqus_utilities.f90"])));
    assert!(matches!(error, UmatError::NoRoutine { .. }), "{error}");

    let error = refusal(UmatSettings {
        increments: 0,
        ..flawed(0)
    });
    assert_eq!(error, UmatError::Increments { increments: 0 });
}

#[test]
fn a_program_other_than_onset_is_refused_as_a_host() {
    for host in ["/bin/cat", "/bin/true", "/nowhere"] {
        let error = Umat::new(UmatSettings {
            host: Some(host.into()),
            time_limit: Duration::from_millis(500),
            ..flawed(0)
        })
        .err()
        .expect("an error");
        assert!(
            !matches!(error, UmatError::Load { .. } | UmatError::NoRoutine { .. }),
            "{error}"
        );
    }
}

/// Processes that run a library, found by its name on their command line.
#[cfg(target_os = "linux")]
fn processes(library: &Path) -> usize {
    use std::os::unix::ffi::OsStrExt;
    let name = library.as_os_str().as_bytes();
    std::fs::read_dir("/proc")
        .expect("processes")
        .filter_map(|entry| std::fs::read(entry.ok()?.path().join("cmdline")).ok())
        .filter(|line| line.split(|byte| *byte == 0).any(|word| word == name))
        .count()
}

#[test]
#[cfg(target_os = "linux")]
fn no_process_is_left_behind() {
    let own = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("no-process-stays.so");
    std::fs::copy(library(&HOSTILE), &own).expect("a copy");
    for flaw in [0, 1, 2, 3, 5, 7] {
        let umat = Umat::new(UmatSettings {
            library: own.clone(),
            time_limit: Duration::from_millis(300),
            ..flawed(flaw)
        })
        .expect("a UMAT");
        assert_eq!(processes(&own), 1, "flaw {flaw}");
        assert_eq!(asked(&umat).is_ok(), flaw == 0);
        drop(umat);
        assert_eq!(processes(&own), 0, "flaw {flaw}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn no_state_is_computed_after_a_failure_if_all_are_needed() {
    let own = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("asked-once.so");
    std::fs::copy(library(&HOSTILE), &own).expect("a copy");
    let umat = Umat::new(UmatSettings {
        library: own.clone(),
        ..flawed(11)
    })
    .expect("a UMAT");
    let paths: Vec<_> = [1.1, 3.0, 1.2]
        .map(|stretch| vec![Matrix3::from_diagonal_element(stretch)])
        .to_vec();
    let outcome = umat.along_every(&paths);
    assert!(
        matches!(outcome, Err(UmatError::Ended { .. })),
        "{outcome:?}"
    );
    // The state after the failure starts no process.
    assert_eq!(processes(&own), 0);
    assert_eq!(umat.along_all(&paths).len(), 3);
    assert_eq!(processes(&own), 1);
    assert_eq!(
        umat.along_every(&paths[..1]),
        Ok(vec![umat.along(paths[0].clone()).expect("an outcome")])
    );
}

#[test]
fn errors_of_the_users_code_are_errors_of_the_material() {
    let error = hostile(3).response(&general());
    assert!(matches!(error, Err(MaterialError::External { .. })));
    assert!(blatz_ko().response(&general()).is_ok());
}
