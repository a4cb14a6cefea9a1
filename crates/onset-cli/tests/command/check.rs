//! `onset check` and `onset schema`.

use crate::{Written, onset};
use serde_json::Value;

const STUDY: &str = "title = \"a title\"\n\
    [[axes]]\nquantity = \"stretch-1\"\nrange = [0.8, 1.2]\nstates = 20\n\
    [[axes]]\nquantity = \"discretization.support\"\nrange = [1.4, 1.8]\nstates = 10\n";

/// Study with the given text.
fn written(text: impl AsRef<[u8]>) -> Written {
    Written::new("study.toml", text)
}

fn kept(name: &str) -> String {
    format!("{}/../../studies/{name}.toml", env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn a_valid_study_is_summarized() {
    let file = written(STUDY);
    let answer = onset(&["check", &file]);
    assert_eq!((answer.code, answer.stderr.as_str()), (Some(0), ""));
    for fact in [
        &file,
        "a title",
        "modified-mooney-rivlin (default)",
        "c1 0.1256",
        "kernel (default)",
        "lattice hexagonal",
        "frame lagrangian",
        "stretch-1 from 0.8 to 1.2, 20 states",
        "discretization.support from 1.4 to 1.8, 10 states",
        "200 states in 1 tile of 64 x 64",
        "estimated work",
        "stretch-2 = 1, stretch-3 = 1",
    ] {
        assert!(
            answer.stdout.contains(fact),
            "no `{fact}` in:\n{}",
            answer.stdout
        );
    }
    assert!(!answer.stdout.contains("warning"), "{}", answer.stdout);
}

#[test]
fn the_document_agrees_with_the_text() {
    let file = written(STUDY);
    let answer = onset(&["check", "--json", &file]);
    let entries: Value = serde_json::from_str(&answer.stdout).expect("one JSON document");
    let entry = &entries[0];
    assert_eq!(entry["valid"], true);
    assert_eq!(entry["states"], 200);
    assert_eq!(entry["tiles"], 1);
    assert_eq!(entry["axes"][1]["quantity"], "discretization.support");
    assert_eq!(entry["map"]["tile"], 64);
    assert_eq!(
        (&entry["sampled"], &entry["undefined"]),
        (&81.into(), &0.into())
    );
    assert!(
        entry["seconds_per_state"]
            .as_f64()
            .is_some_and(|seconds| seconds > 0.0)
    );
}

#[test]
fn states_without_support_give_a_warning_and_keys_without_effect_are_refused() {
    // A support of fixed size loses its neighbors in strong tension.
    let study = STUDY.replace("[0.8, 1.2]", "[1.0, 4.0]");
    let file = written(format!("discretization.frame = \"eulerian\"\n{study}"));
    let told = onset(&["check", &file]).stdout;
    assert!(
        told.contains("of 81 sampled states have no verdict"),
        "{told}"
    );
    assert!(told.contains("within the support radius"), "{told}");
    let file = written(format!(
        "discretization.current-lattice = \"regular\"\n{STUDY}"
    ));
    let answer = onset(&["check", &file]);
    let fact =
        ":1:34: `discretization.current-lattice` has no effect: discretization.frame is lagrangian";
    assert_eq!(answer.code, Some(2));
    assert!(answer.stderr.contains(fact), "{}", answer.stderr);
}

#[test]
fn an_invalid_study_ends_with_code_2_and_the_position_of_the_error() {
    let file = written(STUDY.replace("stretch-1", "strech-1"));
    let answer = onset(&["check", &file]);
    assert_eq!((answer.code, answer.stdout.as_str()), (Some(2), ""));
    let place = format!("error: {file}:3:12: ");
    assert!(answer.stderr.starts_with(&place), "{}", answer.stderr);
    assert!(
        answer.stderr.contains("did you mean `stretch-1`?"),
        "{}",
        answer.stderr
    );
}

#[test]
fn files_after_an_invalid_one_are_checked_too() {
    let (wrong, good) = (written(""), written(STUDY));
    let text = onset(&["check", &wrong, &good]);
    assert_eq!(text.code, Some(2));
    assert!(text.stdout.contains(&*good) && !text.stdout.contains(&*wrong));
    assert!(text.stderr.contains("has no axes"), "{}", text.stderr);
    let answer = onset(&["check", "--json", &wrong, &good]);
    assert_eq!(answer.code, Some(2));
    let entries: Value = serde_json::from_str(&answer.stdout).expect("one JSON document");
    assert_eq!(entries[0]["valid"], false);
    assert_eq!(
        (&entries[0]["line"], &entries[0]["column"]),
        (&1.into(), &1.into())
    );
    assert!(
        entries[0]["hint"]
            .as_str()
            .is_some_and(|hint| hint.contains("[[axes]]"))
    );
    assert_eq!(entries[1]["valid"], true);
}

#[test]
fn files_that_cannot_be_read_are_named() {
    for path in ["/nonexistent/study.toml", env!("CARGO_MANIFEST_DIR")] {
        let answer = onset(&["check", path]);
        assert_eq!(answer.code, Some(2));
        assert!(
            answer.stderr.contains(&format!("cannot read {path}")),
            "{}",
            answer.stderr
        );
    }
    let file = written([0xff, 0xfe, 0x00]);
    let answer = onset(&["check", &file]);
    assert_eq!(answer.code, Some(2));
    assert!(answer.stderr.contains("UTF-8"), "{}", answer.stderr);
}

#[test]
fn assignments_are_checked_with_the_study() {
    let file = written(STUDY);
    let answer = onset(&["check", &file, "--set", "map.tile=8"]);
    assert!(
        answer.stdout.contains("200 states in 6 tiles of 8 x 8"),
        "{}",
        answer.stdout
    );
    let answer = onset(&["check", &file, "--set", "discretization.support=2"]);
    assert_eq!(answer.code, Some(2));
    assert!(
        answer.stderr.contains("is an axis of this study"),
        "{}",
        answer.stderr
    );
}

#[test]
fn the_gallery_contains_valid_studies() {
    let names = [
        "support-against-stretch",
        "lattice-rotation",
        "shear-stretch",
        "three-axes",
        "chain",
    ];
    for name in names {
        let answer = onset(&["check", &kept(name)]);
        assert_eq!(answer.code, Some(0), "{}", answer.stderr);
        assert!(
            !answer.stdout.contains("has no effect"),
            "{}",
            answer.stdout
        );
    }
}

#[test]
fn the_printed_schema_agrees_with_the_file() {
    let answer = onset(&["schema"]);
    assert_eq!((answer.code, answer.stderr.as_str()), (Some(0), ""));
    let path = format!(
        "{}/../../studies/study.schema.json",
        env!("CARGO_MANIFEST_DIR")
    );
    let kept = std::fs::read_to_string(path).expect("the schema");
    assert!(
        answer.stdout == kept,
        "regenerate studies/study.schema.json with `cargo xtask schema`"
    );
}
