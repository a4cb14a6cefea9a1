//! `onset boundary`.

use super::{Answer, Scratch, number, onset};
use serde_json::Value;
use std::path::Path;

const LAGRANGIAN: &str = "title = 'test'\n[[axes]]\nquantity = 'stretch-1'\nrange = [0.6, 2.4]\nstates = 8\n\
                          [[axes]]\nquantity = 'stretch-2'\nrange = [0.6, 2.4]\nstates = 8\n";

fn traced(text: &str, more: &[&str]) -> (Answer, Scratch) {
    let folder = Scratch::new("boundary");
    std::fs::create_dir_all(&folder).expect("a folder");
    let study = folder.join("study.toml");
    std::fs::write(&study, text).expect("a file");
    let (study, out) = (study.display().to_string(), folder.display().to_string());
    let mut arguments = vec!["boundary", study.as_str(), "--out", out.as_str()];
    arguments.extend(more);
    (onset(&arguments), folder)
}

fn document(path: &Path) -> Value {
    let text = std::fs::read_to_string(path).expect("a file");
    serde_json::from_str(&text).expect("JSON")
}

#[test]
fn a_long_smooth_boundary_is_traced_to_its_ends() {
    let study = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../studies/shear-stretch.toml"
    );
    let answer = onset(&["boundary", study, "--json"]);
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    let summary: Value = serde_json::from_str(&answer.stdout).expect("one JSON document");
    assert_eq!(summary["is_complete"], true);
    // The boundary of a Lagrangian kernel agrees with the material's.
    assert_eq!(summary["curves"].as_array().map(Vec::len), Some(2));
    assert!(number(&summary, "/fidelity/hausdorff/distance") < 1e-4);
    let text = onset(&["boundary", study]).stdout;
    assert!(
        text.contains("open, from the edge of the window to the edge of the window"),
        "{text}"
    );
}

#[test]
fn a_window_without_boundaries_reports_its_phases() {
    // Kernels with a fixed support lose all neighbors.
    let wide = LAGRANGIAN.replace("[0.6, 2.4]", "[3.0, 3.2]");
    let lost = "--set=discretization.frame=eulerian";
    let (answer, _folder) = traced(&wide, &[lost]);
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    for line in [
        "material       no boundary found: unstable throughout the window",
        "discretization no boundary found: undefined throughout the window",
    ] {
        assert!(answer.stdout.contains(line), "{}", answer.stdout);
    }
    let (answer, _folder) = traced(&wide.replace("3.0, 3.2", "1.0, 1.1"), &["--json"]);
    let summary: Value = serde_json::from_str(&answer.stdout).expect("one JSON document");
    let stable = serde_json::json!({ "material": "stable", "discretization": "stable" });
    assert_eq!(summary["throughout"], stable);
    assert_eq!(summary["notes"], serde_json::json!([]));
    // The phase `stable` does not exclude zero-energy modes.
    let nodal = "--set=discretization.quadrature=nodal";
    let (answer, _folder) = traced(LAGRANGIAN, &[nodal]);
    assert!(
        answer
            .stdout
            .contains("note: in the reference configuration the particles have zero-energy modes"),
        "{}",
        answer.stdout
    );
    let fluid = ["--set=material.model=tait", "--set=material.mu=0"];
    let narrow = wide.replace("3.0, 3.2", "1.0, 1.1");
    let (answer, _folder) = traced(&narrow, &fluid);
    assert!(
        answer.stdout.contains("no stiffness against shear"),
        "{}",
        answer.stdout
    );
}

#[test]
fn a_lagrangian_kernel_is_faithful_to_the_accuracy_of_bracketing() {
    let (answer, folder) = traced(LAGRANGIAN, &["--json"]);
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    assert_eq!(answer.stderr, "");
    let summary: Value = serde_json::from_str(&answer.stdout).expect("one JSON document");
    assert_eq!(summary["is_complete"], true);
    assert!(number(&summary, "/fidelity/false_instability_share") < 1e-4);
    assert!(number(&summary, "/fidelity/suppressed_instability_share") < 1e-4);
    assert!(number(&summary, "/fidelity/rays/worst/relative") < 1e-9);
    assert!(number(&summary, "/fidelity/rays/worst_stress/relative") < 1e-8);
    assert_eq!(summary["fidelity"]["rays"]["only_material"], 0);
    assert_eq!(summary["fidelity"]["rays"]["only_discretization"], 0);

    let collection = document(&folder.join("boundary.geojson"));
    assert_eq!(collection["type"], "FeatureCollection");
    let features = collection["features"].as_array().expect("features");
    let of: Vec<&str> = features
        .iter()
        .filter_map(|feature| feature["properties"]["of"].as_str())
        .collect();
    assert_eq!(of, ["material", "discretization"]);
    for feature in features {
        assert_eq!(feature["geometry"]["type"], "LineString");
        assert_eq!(feature["properties"]["left"], "stable");
        let line = feature["geometry"]["coordinates"]
            .as_array()
            .expect("points");
        // The curve connects the right edge of the window with its upper edge, in either direction.
        let ends = [&line[0], &line[line.len() - 1]];
        assert!(ends.iter().all(|end| end[0] == 2.4 || end[1] == 2.4));
    }
    // The traced study can be read back.
    let study = collection["study"].as_str().expect("the study");
    assert!(study.contains("quantity = \"stretch-1\""));

    let table = std::fs::read_to_string(folder.join("boundary.csv")).expect("a table");
    assert!(table.starts_with(
        "curve,of,left,right,stretch_1,stretch_2,accuracy,corner\n0,material,stable,unstable,"
    ));
    let vertices: usize = features
        .iter()
        .map(|feature| {
            feature["geometry"]["coordinates"]
                .as_array()
                .expect("points")
                .len()
        })
        .sum();
    assert_eq!(table.lines().count(), vertices + 1);
}

#[test]
fn boundaries_are_traced_for_any_two_axes() {
    let text = "[discretization]\nframe = 'eulerian'\ncurrent-lattice = 'regular'\n[state]\nstretch-2 = 0.9\n\
                [[axes]]\nquantity = 'stretch-1'\nrange = [0.8, 1.2]\nstates = 8\n\
                [[axes]]\nquantity = 'discretization.support'\nrange = [1.7, 2.1]\nstates = 8\n";
    let (answer, folder) = traced(text, &[]);
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    assert!(
        answer.stdout.contains("False instability"),
        "{}",
        answer.stdout
    );
    let collection = document(&folder.join("boundary.geojson"));
    assert_eq!(collection["axes"][1]["name"], "discretization.support");
    // The axes are not both stretches, so that there are no rays.
    assert_eq!(collection["fidelity"]["rays"], Value::Null);
}

#[test]
fn studies_that_cannot_be_traced_are_refused_with_a_hint() {
    let three =
        format!("{LAGRANGIAN}[[axes]]\nquantity = 'shear'\nrange = [0.0, 1.0]\nstates = 4\n");
    let (answer, _) = traced(&three, &[]);
    assert_eq!(answer.code, Some(2));
    assert!(answer.stderr.contains("the study has 3 axes") && answer.stderr.contains("hint:"));
    let answer = onset(&["boundary", "nowhere.toml"]);
    assert_eq!(answer.code, Some(2));
    assert!(answer.stderr.contains("cannot read nowhere.toml"));
}

#[test]
fn an_unwritable_folder_is_a_failure_of_the_machine() {
    let folder = Scratch::new("boundary-file");
    std::fs::write(&folder, "a file").expect("a file");
    let study = Scratch::new("boundary-study");
    std::fs::write(&study, LAGRANGIAN).expect("a file");
    let answer = onset(&[
        "boundary",
        &study.display().to_string(),
        "--out",
        &folder.join("under").display().to_string(),
    ]);
    assert_eq!(answer.code, Some(1), "{}", answer.stderr);
    assert!(answer.stderr.contains("cannot write"));
}

#[test]
fn a_file_in_place_of_the_folder_is_reported_before_any_curve_is_traced() {
    let folder = Scratch::new("boundary-file");
    std::fs::create_dir_all(&folder).expect("a folder");
    let file = folder.join("taken");
    std::fs::write(&file, "mine").expect("a file");
    let study = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../studies/figure-06-convected-exact-1.6.toml"
    );
    let answer = onset(&["boundary", study, "--out", &file.display().to_string()]);
    assert_eq!(answer.code, Some(1));
    assert!(answer.stderr.contains("cannot write"), "{}", answer.stderr);
    assert_eq!(std::fs::read_to_string(&file).expect("the file"), "mine");
}

/// Stability in `onset state` for the particles [`FLUTTERING`].
fn stability(state: [f64; 2]) -> &'static str {
    let stretch = format!("{:?},{:?}", state[0], state[1]);
    let mut arguments = vec!["state", "--json", "--stretch", &stretch];
    for assignment in FLUTTERING {
        arguments.extend(["--set", assignment]);
    }
    let answer = onset(&arguments);
    let document: Value = serde_json::from_str(&answer.stdout).expect("one JSON document");
    let is_stable = document["discretization"]["stable"]
        .as_bool()
        .expect("a fact");
    match is_stable {
        true => "stable",
        false if number(&document, "/discretization/minimum_omega_squared/re") < 0.0 => {
            "divergence"
        }
        false => "flutter",
    }
}

const FLUTTERING: [&str; 4] = [
    "discretization.frame=eulerian",
    "discretization.support=1.9",
    "discretization.current-lattice=regular",
    "discretization.linearization=paper",
];

#[test]
fn flutter_is_distinguished_from_divergence_on_both_sides_of_its_boundaries() {
    let text = "[[axes]]\nquantity = 'stretch-1'\nrange = [0.7, 1.15]\nstates = 8\n\
                [[axes]]\nquantity = 'stretch-2'\nrange = [0.7, 1.15]\nstates = 8\n";
    let mut more = vec!["--flutter"];
    for assignment in FLUTTERING {
        more.extend(["--set", assignment]);
    }
    let (answer, folder) = traced(text, &more);
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    let collection = document(&folder.join("boundary.geojson"));
    let mut told = 0;
    for feature in collection["features"].as_array().expect("features") {
        if feature["properties"]["of"] != "discretization" {
            continue;
        }
        let line = feature["geometry"]["coordinates"]
            .as_array()
            .expect("points");
        let point = |n: usize| [0, 1].map(|axis| line[n][axis].as_f64().expect("a number"));
        // States at the middle of the curve, slightly to its left and to its right.
        let (from, to) = (point(line.len() / 2), point(line.len() / 2 + 1));
        let along = [to[0] - from[0], to[1] - from[1]];
        let length = along[0].hypot(along[1]);
        let beside = |step: f64| {
            let middle = [0, 1].map(|axis| 0.5 * (from[axis] + to[axis]));
            let (x, y) = (along[0] / length, along[1] / length);
            stability([middle[0] - step * y, middle[1] + step * x])
        };
        let words = ["left", "right"].map(|side| match feature["properties"][side].as_str() {
            Some("unstable") => "divergence",
            other => other.expect("a word"),
        });
        assert_eq!([beside(1e-5), beside(-1e-5)], words);
        told += usize::from(words == ["flutter", "divergence"]);
    }
    assert!(told > 0, "no boundary between flutter and divergence");
}
