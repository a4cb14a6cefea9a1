//! Tests of the studies in `studies/`, and of the schema next to them.

use onset_study::settings::{
    BODY_KEYS, COMPARISON_KEYS, GRIP_KEYS, Key, Quantity, Study, schema, study_keys,
};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../studies")
}

/// Name and text of every study in the folder.
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

/// Errors that an editor would show in each document, from an independent implementation of JSON Schema in Python, which also validates the schema
/// itself; `None` without an interpreter.
fn complaints(documents: &[&str]) -> Option<Vec<Vec<String>>> {
    let Some(python) = std::env::var_os("ONSET_PYTHON") else {
        eprintln!(
            "note: ONSET_PYTHON names no interpreter with jsonschema. Run `cargo xtask test`."
        );
        return None;
    };
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python/complaints.py");
    let table = |text: &&str| text.parse::<toml::Table>().expect("TOML");
    let documents: Vec<toml::Table> = documents.iter().map(table).collect();
    let mut child = Command::new(python)
        .arg(script)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("an interpreter");
    let question = json!({ "schema": schema(), "documents": documents });
    let input = child.stdin.take().expect("standard input");
    serde_json::to_writer(input, &question).expect("a question");
    let output = child.wait_with_output().expect("an answer");
    assert!(output.status.success(), "the schema is not a schema");
    Some(serde_json::from_slice(&output.stdout).expect("complaints"))
}

#[test]
fn the_schema_in_the_repository_is_current() {
    let kept = std::fs::read_to_string(folder().join("study.schema.json")).unwrap_or_default();
    assert!(
        kept == format!("{:#}\n", schema()),
        "studies/study.schema.json is out of date; regenerate it with `cargo xtask schema`"
    );
}

#[test]
fn every_study_in_the_repository_is_valid_and_names_the_schema() {
    let kept = kept();
    let written_out = kept.iter().map(|(name, text)| {
        assert!(text.starts_with("#:schema ./study.schema.json\n"), "{name}");
        match Study::parse(name, text) {
            Ok(study) => study.document(),
            Err(error) => panic!("{error}"),
        }
    });
    let written_out: Vec<String> = written_out.collect();
    let texts = kept.iter().map(|(_, text)| text).chain(&written_out);
    let texts: Vec<&str> = texts.map(String::as_str).collect();
    for (text, complaints) in texts.iter().zip(complaints(&texts).into_iter().flatten()) {
        assert!(complaints.is_empty(), "{complaints:?}\n{text}");
    }
}

#[test]
fn everything_that_the_schema_refuses_is_refused_by_the_program() {
    let good = "material.model = \"blatz-ko\"\n\
                [[axes]]\nquantity = \"stretch-1\"\nrange = [0.5, 2.0]\nstates = 10\n\
                [[axes]]\nquantity = \"discretization.support\"\nrange = [1.5, 2.0]\nstates = 6\n";
    assert!(Study::parse("good", good).is_ok());
    let changes = [
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
    ];
    let wrong = changes.map(|(from, to)| {
        assert!(good.contains(from), "{from}");
        good.replacen(from, to, 1)
    });
    for wrong in &wrong {
        assert!(Study::parse("wrong", wrong).is_err(), "accepted:\n{wrong}");
    }
    let documents: Vec<&str> = wrong.iter().map(String::as_str).chain([good]).collect();
    if let Some(complaints) = complaints(&documents) {
        for (wrong, complaints) in wrong.iter().zip(&complaints) {
            assert!(!complaints.is_empty(), "the schema accepts:\n{wrong}");
        }
        assert_eq!(
            complaints.last(),
            Some(&Vec::new()),
            "the schema refuses what is right"
        );
    }
}

#[test]
fn the_book_lists_every_key_of_a_study() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../book/src/how-to/study.md");
    let page = std::fs::read_to_string(page).expect("the page on studies");
    // The page on materials lists the parameters of the laws.
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
        ["material", "discretization", "time", "state", "map"]
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
fn the_examples_of_the_book_are_valid_studies() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../book/src/how-to/study.md");
    let page = std::fs::read_to_string(page).expect("the page on studies");
    let examples: Vec<&str> = page
        .split("```toml\n")
        .skip(1)
        .filter_map(|rest| rest.split("```").next())
        .collect();
    assert_eq!(examples.len(), 3);
    for example in &examples {
        if let Err(error) = Study::parse("study.md", example) {
            panic!("{error}\n{example}");
        }
    }
    for complaints in complaints(&examples).into_iter().flatten() {
        assert!(complaints.is_empty(), "{complaints:?}");
    }
}

#[test]
fn the_book_describes_every_law_like_the_library() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../book/src/how-to/materials.md");
    let page = std::fs::read_to_string(page).expect("the page on materials");
    let mut rows = 0;
    let laws = onset::material::library().iter();
    for law in laws.chain(onset::plasticity::library()) {
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
                parameter.expected(),
                parameter.meaning
            );
        }
        block += &format!(
            "\nSymmetry: {}. Domain: {}. Small strains: {}. Source: {}.\n",
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

/// Folders with build products or tools.
fn is_left_out(name: &str) -> bool {
    let is_hidden = name.starts_with('.') && ![".github", ".ci", ".cargo"].contains(&name);
    name == "target" || is_hidden
}

/// Links are lost when files are copied, and are plain text on Windows.
#[test]
fn no_file_of_the_repository_is_a_link() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut open = vec![root];
    let mut files = 0;
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(&folder).expect("a folder") {
            let entry = entry.expect("an entry");
            let (name, kind) = (entry.file_name(), entry.file_type().expect("a kind"));
            if is_left_out(&name.to_string_lossy()) {
                continue;
            }
            assert!(!kind.is_symlink(), "{} is a link", entry.path().display());
            match kind.is_dir() {
                true => open.push(entry.path()),
                false => files += 1,
            }
        }
    }
    assert!(files > 500, "{files} files");
}

/// Files that are compiled in, or that a package needs, are copies of the files in the folders of the repository.
#[test]
fn copies_are_identical_to_their_originals() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let read = |path: PathBuf| {
        std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
    };
    let mut copies = 0;
    for (own, shown) in [
        ("compare/panels", "comparisons"),
        ("reproduce/studies", "studies"),
    ] {
        let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("src").join(own);
        for entry in std::fs::read_dir(&own).expect("a folder") {
            let entry = entry.expect("an entry");
            let copy = root.join(shown).join(entry.file_name());
            assert!(
                read(entry.path()) == read(copy.clone()),
                "{} is not {}",
                copy.display(),
                entry.path().display()
            );
            copies += 1;
        }
    }
    for package in [
        "crates/onset",
        "crates/onset-cli",
        "crates/onset-study",
        "crates/onset-umat",
        "python/licenses",
    ] {
        for license in ["LICENSE-APACHE", "LICENSE-MIT"] {
            let copy = root.join(package).join(license);
            assert!(
                read(copy) == read(root.join(license)),
                "{package}/{license}"
            );
            copies += 1;
        }
    }
    assert_eq!(copies, 28);
}

/// Pages of the book, and README.
fn pages() -> Vec<(PathBuf, String)> {
    let root = folder().join("..");
    let mut folders = vec![root.join("book/src")];
    let mut pages = vec![root.join("README.md")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            match path.extension() {
                None => folders.push(path),
                Some(extension) if extension == "md" => pages.push(path),
                Some(_) => {}
            }
        }
    }
    let text = |path: PathBuf| {
        let text = std::fs::read_to_string(&path).expect("a page");
        (path, text)
    };
    pages.into_iter().map(text).collect()
}

#[test]
fn every_key_that_the_book_names_exists() {
    let keys: Vec<&Key> = study_keys()
        .chain(BODY_KEYS)
        .chain(GRIP_KEYS)
        .chain(COMPARISON_KEYS)
        .collect();
    let files = ["csv", "html", "json", "png", "rs", "svg", "toml"];
    let sections = [
        "material",
        "discretization",
        "state",
        "map",
        "body",
        "grips",
        "compare",
    ];
    let is_key = |name: &str| Key::named(name).is_some() || keys.iter().any(|key| key.name == name);
    let is_part = |name: &str| keys.iter().any(|key| key.parts().1 == name);
    let mut looked_at = 0;
    for (page, text) in pages() {
        let mut is_code = false;
        let lines: Vec<&str> = text.lines().collect();
        for (n, line) in lines.iter().enumerate() {
            is_code ^= line.starts_with("```");
            // The tables of words.md list earlier names, which are no longer keys.
            if is_code || (page.ends_with("words.md") && line.starts_with('|')) {
                continue;
            }
            let place = || format!("{}:{}: {line}", page.display(), n + 1);
            for code in line.split('`').skip(1).step_by(2) {
                let name = code.split([' ', '=']).next().unwrap_or_default();
                let Some((section, own)) = name.split_once('.') else {
                    continue;
                };
                let is_name = own
                    .chars()
                    .all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-');
                if sections.contains(&section)
                    && is_name
                    && !own.is_empty()
                    && !files.contains(&own)
                {
                    assert!(is_key(name), "{}", place());
                    looked_at += 1;
                }
            }
            // A table of the words of a key names the key in its heading.
            let is_heading = lines
                .get(n + 1)
                .is_some_and(|next| next.starts_with("|---"));
            let heading = line
                .strip_prefix("| `")
                .and_then(|rest| rest.split('`').next());
            if let Some(name) = heading.filter(|_| is_heading) {
                assert!(
                    is_part(name.rsplit('.').next().unwrap_or_default()),
                    "{}",
                    place()
                );
                looked_at += 1;
            }
        }
    }
    assert!(looked_at > 200, "{looked_at} keys");
}
