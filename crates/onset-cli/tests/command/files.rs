//! Files that are written, files that cannot be, and readers that stop reading.

use crate::{command, fresh_place, onset};
use serde_json::Value;
use std::fs;
use std::io::Read;
use std::path::Path;
use std::process::Stdio;

fn text(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

/// A folder that cannot be made, for anybody: a file is in the way.
fn unwritable() -> std::path::PathBuf {
    let file = fresh_place("file");
    fs::write(&file, "in the way").expect("a file");
    file.join("figures")
}

#[test]
fn a_diagram_is_written_as_svg_and_png() {
    let folder = fresh_place("diagram").join("inner");
    for arrangement in ["hexagonal", "square", "chain", "simple-cubic"] {
        let stretches = match arrangement {
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
            &format!("discretization.arrangement={arrangement}"),
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
    fs::remove_dir_all(folder.parent().expect("a folder")).expect("removable");
}

#[test]
fn a_diagram_is_also_a_document() {
    let folder = fresh_place("document");
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
    assert_eq!(names, [Some("Γ"), Some("M"), Some("K"), Some("Γ")]);
    let count = |key: &str| diagram[key].as_array().map(Vec::len);
    assert_eq!(count("samples"), count("lengths"));
    fs::remove_dir_all(folder).expect("removable");
}

#[test]
fn folders_that_cannot_be_made_are_named() {
    let folder = unwritable();
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
    fs::remove_file(folder.parent().expect("a file")).expect("removable");
}

#[test]
fn a_reader_that_stops_reading_is_no_error() {
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
