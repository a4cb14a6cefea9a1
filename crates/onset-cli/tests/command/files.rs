//! Output files, obstacles to them, and readers that close the pipe.

use crate::{Scratch, command, onset};
use serde_json::Value;
use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::Stdio;

fn text(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

#[test]
fn a_diagram_is_written_as_svg_and_png() {
    let place = Scratch::new("diagram");
    let folder = place.join("inner");
    for kind in ["hexagonal", "square", "chain", "simple-cubic"] {
        let stretches = match kind {
            "chain" => "1.2",
            "simple-cubic" => "1.2,0.9,1",
            _ => "1.2,0.9",
        };
        let answer = onset(&[
            "dispersion",
            "--stretch",
            stretches,
            "--path",
            "--out",
            text(&folder),
            "--set",
            &format!("discretization.lattice={kind}"),
        ]);
        assert_eq!(answer.code, Some(0), "{}", answer.stderr);
        for name in ["dispersion.svg", "dispersion.png"] {
            assert!(answer.stdout.contains(text(&folder.join(name))));
        }
        let table = fs::read_to_string(folder.join("dispersion.csv")).expect("a table");
        assert!(table.starts_with("length,wave_vector_1,"), "{table}");
        assert!(table.lines().count() > 100);
        let svg = fs::read_to_string(folder.join("dispersion.svg")).expect("SVG");
        assert!(svg.contains("<svg") && svg.trim_end().ends_with("</svg>"));
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
        let png = fs::read(folder.join("dispersion.png")).expect("PNG");
        assert!(png.starts_with(b"\x89PNG\r\n\x1a\n"));
    }
}

#[test]
fn a_diagram_is_also_available_as_json() {
    let folder = Scratch::new("document");
    let answer = onset(&[
        "dispersion",
        "--stretch",
        "1.2,0.9",
        "--path",
        "--json",
        "--out",
        text(&folder),
    ]);
    let diagram: Value = serde_json::from_str(&answer.stdout).expect("one JSON document");
    let corners = diagram["corners"].as_array().expect("corners");
    let names: Vec<_> = corners
        .iter()
        .map(|corner| corner["name"].as_str())
        .collect();
    // In this state the edge midpoints M and M′ of the zone are not equivalent; the last segment passes through the critical wave vector k*.
    let expected = ["Γ", "M", "K", "Γ", "M′", "Γ", "k*"].map(Some);
    assert_eq!(names[..expected.len()], expected);
    let count = |key: &str| diagram[key].as_array().map(Vec::len);
    assert_eq!(count("samples"), count("lengths"));
}

#[test]
fn folders_that_cannot_be_created_are_named() {
    // The parent of the folder is a file, so that no user can create the folder.
    let file = Scratch::new("file");
    fs::write(&file, "in the way").expect("a file");
    let folder = file.join("figures");
    for arguments in [
        &["dispersion", "--stretch", "1.2,0.9", "--path", "--out"][..],
        &["reproduce", "--out"],
        &["reproduce", "--json", "--out"],
    ] {
        let answer = onset(&[arguments, &[text(&folder)]].concat());
        assert_eq!(answer.code, Some(1), "{arguments:?}: {}", answer.stderr);
        assert_eq!(answer.stdout, "");
        assert!(
            answer.stderr.contains("error: cannot write"),
            "{}",
            answer.stderr
        );
        assert!(answer.stderr.contains(text(&folder)), "{}", answer.stderr);
        assert!(!answer.stderr.contains("panicked"));
    }
}

/// Commands that write files, each with its files.
const WRITERS: [(&str, &[&str]); 4] = [
    (
        "dispersion --stretch 1.2,0.9 --path --out",
        &[
            "dispersion.svg",
            "dispersion.png",
            "dispersion.csv",
            "density-of-states.csv",
        ],
    ),
    (
        "modes --set discretization.quadrature=nodal --cells 4 --out",
        &["modes.svg", "modes.png", "modes.html"],
    ),
    (
        "criteria --mode hydrostatic --range 0.5,2 --out",
        &["criteria.svg", "criteria.png"],
    ),
    (
        "localize --model j2 --path uniaxial-stress --out",
        &["localize.svg", "localize.png", "localize.csv"],
    ),
];

#[test]
fn an_obstacle_to_a_file_is_reported_before_the_work_and_other_files_stay_unchanged() {
    for (line, files) in WRITERS {
        let folder = Scratch::new("in-the-way");
        let last = folder.join(files[files.len() - 1]);
        fs::create_dir_all(&last).expect("a folder");
        fs::write(folder.join(files[0]), "old").expect("a file");
        let words: Vec<&str> = line.split(' ').chain([text(&folder)]).collect();
        let answer = onset(&words);
        assert_eq!(answer.code, Some(1), "{line}: {}", answer.stderr);
        assert!(answer.stderr.contains("cannot write"), "{}", answer.stderr);
        assert!(answer.stderr.contains(text(&last)), "{}", answer.stderr);
        assert_eq!(
            fs::read_to_string(folder.join(files[0])).expect("a file"),
            "old"
        );
        assert_eq!(fs::read_dir(&folder).expect("a folder").count(), 2);
        fs::remove_dir_all(folder).expect("removable");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn files_are_written_and_reported_in_folders_with_long_names_or_names_that_are_not_utf8() {
    use std::ffi::OsString;
    use std::os::unix::ffi::OsStringExt;
    let place = Scratch::new("names");
    fs::create_dir_all(&place).expect("a folder");
    let study = "[[axes]]\nquantity = 'stretch-1'\nrange = [0.8, 1.6]\nstates = 8\n\
                 [[axes]]\nquantity = 'stretch-2'\nrange = [0.8, 1.6]\nstates = 8\n";
    fs::write(place.join("study.toml"), study).expect("a file");
    for name in [vec![0xff, b'a', 0x80], vec![b'n'; 255]] {
        let name = OsString::from_vec(name);
        let writers = WRITERS.iter().map(|(line, files)| (*line, files[0]));
        for (line, file) in writers.chain([("boundary study.toml --out", "boundary.csv")]) {
            let words: Vec<&str> = line.split(' ').collect();
            let output = command(&words)
                .arg(&name)
                .arg("--json")
                .current_dir(&place)
                .output()
                .expect("the command starts");
            let told = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(0), "{line}: {told}");
            assert!(serde_json::from_slice::<Value>(&output.stdout).is_ok());
            assert!(place.join(&name).join(file).is_file(), "{line}");
        }
    }
}

/// A full disk is simulated: files are limited to one block.
#[test]
#[cfg(unix)]
fn a_full_disk_leaves_existing_files_unchanged_and_gives_a_hint() {
    for (line, files) in WRITERS {
        let folder = Scratch::new("full");
        fs::create_dir_all(&folder).expect("a folder");
        for file in files {
            fs::write(folder.join(file), "old").expect("a file");
        }
        let limited = "ulimit -f 1; trap '' XFSZ; exec \"$@\"";
        let output = std::process::Command::new("sh")
            .args(["-c", limited, "sh", env!("CARGO_BIN_EXE_onset")])
            .args(line.split(' '))
            .arg(&folder)
            .output()
            .expect("a shell");
        let told = String::from_utf8(output.stderr).expect("UTF-8");
        assert_eq!(output.status.code(), Some(1), "{line}: {told}");
        for fact in ["cannot write", "make room", "existing files are unchanged"] {
            assert!(told.contains(fact), "{line}: {told}");
        }
        for file in files {
            assert_eq!(
                fs::read_to_string(folder.join(file)).expect("a file"),
                "old"
            );
        }
        assert_eq!(
            fs::read_dir(&folder).expect("a folder").count(),
            files.len()
        );
        fs::remove_dir_all(folder).expect("removable");
    }
}

#[test]
#[cfg(unix)]
fn an_endless_study_is_refused_and_invalid_text_is_reported_with_its_line() {
    let place = Scratch::new("no-study");
    fs::write(&place, b"title = 'a'\n# \xff\n").expect("a file");
    let (pipe, wide) = (Scratch::new("no-study-pipe"), Scratch::new("no-study-wide"));
    let made = std::process::Command::new("mkfifo")
        .arg(text(&pipe))
        .status();
    assert!(made.expect("mkfifo").success());
    fs::write(&wide, b"\xff\xfet\0").expect("a file");
    for (file, facts) in [
        (
            "/dev/zero",
            ["not a regular file", "hint: expected a study"],
        ),
        (
            text(&pipe),
            ["not a regular file", "hint: expected a study"],
        ),
        (text(&wide), ["it is UTF-16", "hint: expected a study"]),
        (text(&place), ["line 2", "UTF-8"]),
        ("/", ["cannot read /", "hint: expected a study file"]),
        (
            "map.tile=8",
            ["cannot read map.tile=8", "hint: a key is set by --set"],
        ),
    ] {
        for command in ["check", "map", "state"] {
            let mut words = vec![command, file];
            if command == "state" {
                words.extend(["--stretch", "1,1"]);
            }
            let answer = onset(&words);
            assert_eq!(answer.code, Some(2), "{words:?}: {}", answer.stderr);
            for fact in facts {
                assert!(answer.stderr.contains(fact), "{words:?}: {}", answer.stderr);
            }
        }
    }
}

#[test]
#[cfg(target_os = "linux")]
fn an_answer_that_cannot_be_printed_is_an_error() {
    let full = fs::OpenOptions::new()
        .write(true)
        .open("/dev/full")
        .expect("a device");
    let output = command(&["state", "--stretch", "1.2,0.9"])
        .stdout(full)
        .stderr(Stdio::piped())
        .spawn();
    let output = output
        .and_then(std::process::Child::wait_with_output)
        .expect("an end");
    let told = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(told.contains("cannot print the answer"), "{told}");
}

#[test]
fn a_closed_pipe_is_not_an_error() {
    for arguments in [
        &["state", "--stretch", "1.2,0.9", "--json"][..],
        &["dispersion", "--stretch", "1.2,0.9", "--wave-vector", "1,1"],
        &["path", "--from", "1,1", "--to", "3,3"],
        &["--help"],
    ] {
        let mut child = command(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the command starts");
        drop(child.stdout.take());
        let mut told = String::new();
        let mut stderr = child.stderr.take().expect("a pipe");
        stderr.read_to_string(&mut told).expect("UTF-8");
        let code = child.wait().expect("an end").code();
        assert_eq!((code, told.as_str()), (Some(0), ""), "{arguments:?}");
    }
}
