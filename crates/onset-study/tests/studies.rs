//! The studies that are kept in `studies/`, and the schema beside them.

use onset_study::settings::{Quantity, Study, schema, study_keys};
use serde_json::Value;
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../studies")
}

/// Every kept study: its name and its text.
fn kept() -> Vec<(String, String)> {
    let entries = std::fs::read_dir(folder()).expect("studies/");
    let mut studies: Vec<(String, String)> = entries
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "toml")
        })
        .map(|path| {
            let text = std::fs::read_to_string(&path).expect("a text");
            (path.display().to_string(), text)
        })
        .collect();
    studies.sort();
    assert!(studies.len() > 15, "{} studies", studies.len());
    studies
}

/// The document that an editor checks against the schema.
fn json(text: &str) -> Value {
    let table: toml::Table = text.parse().expect("TOML");
    serde_json::to_value(table).expect("JSON")
}

fn is_valid_under_schema(text: &str) -> bool {
    let validator = jsonschema::draft202012::new(&schema()).expect("a schema");
    validator.is_valid(&json(text))
}

#[test]
fn the_kept_schema_is_current() {
    let kept = std::fs::read_to_string(folder().join("study.schema.json")).unwrap_or_default();
    assert!(
        kept == format!("{:#}\n", schema()),
        "studies/study.schema.json is out of date; renew it with `cargo xtask schema`"
    );
}

#[test]
fn the_schema_is_a_schema() {
    jsonschema::draft202012::meta::validate(&schema()).expect("a schema of draft 2020-12");
}

#[test]
fn every_kept_study_is_valid_and_names_the_schema() {
    for (name, text) in kept() {
        assert!(text.starts_with("#:schema ./study.schema.json\n"), "{name}");
        if let Err(error) = Study::parse(&name, &text) {
            panic!("{error}");
        }
        let validator = jsonschema::draft202012::new(&schema()).expect("a schema");
        let complaints: Vec<String> = validator
            .iter_errors(&json(&text))
            .map(|error| format!("{}: {error}", error.instance_path()))
            .collect();
        assert!(complaints.is_empty(), "{name}: {complaints:?}");
    }
}

#[test]
fn studies_that_are_written_out_in_full_are_valid_under_the_schema() {
    for (name, text) in kept() {
        let document = Study::parse(&name, &text).expect("valid").document();
        assert!(is_valid_under_schema(&document), "{name}:\n{document}");
    }
}

#[test]
fn what_the_schema_refuses_is_refused_by_the_program_too() {
    let good = "material.model = \"blatz-ko\"\n\
                [[axes]]\nquantity = \"stretch-1\"\nrange = [0.5, 2.0]\nstates = 10\n\
                [[axes]]\nquantity = \"discretization.support\"\nrange = [1.5, 2.0]\nstates = 6\n";
    assert!(is_valid_under_schema(good) && Study::parse("good", good).is_ok());
    for (from, to) in [
        ("material.model", "material.modell"),
        ("material.model", "unknown = 1\nmaterial.model"),
        ("material.model", "material.c1 = 1\nmaterial.model"),
        ("material.model = \"blatz-ko\"", "material.mu = 1"),
        ("blatz-ko", "blatzko"),
        ("material.model", "title = 1\nmaterial.model"),
        ("material.model", "state.stretch-2 = 0\nmaterial.model"),
        ("material.model", "state.strech-2 = 1\nmaterial.model"),
        ("material.model", "map.tile = 2000\nmaterial.model"),
        ("material.model", "map.refine-from = 3\nmaterial.model"),
        ("material.model", "map.certify = \"yes\"\nmaterial.model"),
        (
            "material.model",
            "discretization.frame = \"euler\"\nmaterial.model",
        ),
        ("states = 10", "states = 10\nunknown = 1"),
        ("states = 10\n", ""),
        ("states = 10", "states = 1"),
        ("states = 10", "states = 70000"),
        ("states = 10", "states = 2.5"),
        ("stretch-1", "stretch-4"),
        ("[0.5, 2.0]", "[0.0, 2.0]"),
        ("[0.5, 2.0]", "[0.5, 2.0, 3.0]"),
        ("[1.5, 2.0]", "[-1.5, 2.0]"),
        (
            "\"stretch-1\"\nrange = [0.5, 2.0]",
            "\"rotation\"\nrange = [0.0, 90.0]",
        ),
    ] {
        assert!(good.contains(from), "{from}");
        let wrong = good.replacen(from, to, 1);
        assert!(
            !is_valid_under_schema(&wrong),
            "the schema accepts:\n{wrong}"
        );
        assert!(Study::parse("wrong", &wrong).is_err(), "accepted:\n{wrong}");
    }
}

#[test]
fn the_book_has_every_key_of_a_study() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../book/src/how-to/study.md");
    let page = std::fs::read_to_string(page).expect("the page on studies");
    // The page on materials has the parameters of the laws.
    let keys_of_page = || study_keys().filter(|key| !key.is_parameter());
    for key in keys_of_page() {
        let expects = match key.name {
            "material.model" => {
                "a law of [the library](materials.md), or one of your own".to_owned()
            }
            _ => key.expects().replace(" | ", ", "),
        };
        let row = format!(
            "| `{}` | {expects} | {} | {} |",
            key.name,
            key.default_value(),
            key.meaning
        );
        assert!(page.contains(&row), "the page lacks this row:\n{row}");
    }
    let keys = page.split("## Keys").nth(1).unwrap_or_default();
    let rows = keys.lines().filter(|line| {
        ["material", "discretization", "state", "map"]
            .iter()
            .any(|section| line.starts_with(&format!("| `{section}.")))
    });
    assert_eq!(
        rows.count(),
        keys_of_page().count(),
        "the page has a row too many"
    );
    let of_state = Quantity::OF_STATE.into_iter();
    let of_discretization =
        Quantity::all().filter(|quantity| quantity.name().starts_with("discretization."));
    for quantity in of_state.chain(of_discretization) {
        assert!(
            page.contains(&format!("`{}`", quantity.name())),
            "{}",
            quantity.name()
        );
    }
}

#[test]
fn the_examples_of_the_book_are_studies() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../book/src/how-to/study.md");
    let page = std::fs::read_to_string(page).expect("the page on studies");
    let examples: Vec<&str> = page
        .split("```toml\n")
        .skip(1)
        .filter_map(|rest| rest.split("```").next())
        .collect();
    assert_eq!(examples.len(), 3);
    for example in examples {
        if let Err(error) = Study::parse("study.md", example) {
            panic!("{error}\n{example}");
        }
        assert!(is_valid_under_schema(example), "{example}");
    }
}

#[test]
fn the_book_has_every_law_as_the_library_describes_it() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../book/src/how-to/materials.md");
    let page = std::fs::read_to_string(page).expect("the page on materials");
    let mut rows = 0;
    for law in onset::material::library() {
        let mut block = format!(
            "### {}\n\n```text\n{}\n```\n\n| parameter | unit | default | expects | meaning |\n|---|---|---|---|---|\n",
            law.name, law.formula
        );
        for parameter in law.parameters {
            block += &format!(
                "| `{}` | {} | {} | {} | {} |\n",
                parameter.name,
                parameter.unit,
                parameter.default,
                parameter.admitted,
                parameter.meaning
            );
        }
        block += &format!(
            "\nSymmetry: {}. Holds: {}. Small strains: {}. Source: {}.\n",
            law.symmetry.name(),
            law.domain,
            law.small_strains,
            law.source
        );
        assert!(page.contains(&block), "the page lacks this:\n{block}");
        rows += law.parameters.len();
    }
    let of_page = page.lines().filter(|line| line.starts_with("| `"));
    assert_eq!(of_page.count(), rows, "the page has a row too many");
}
