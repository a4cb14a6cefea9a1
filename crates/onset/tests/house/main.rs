//! Order of the modules of the core, as drawn in the book.

use std::fs;
use std::path::{Path, PathBuf};

/// Modules from the top to the bottom of the drawing, and from left to right in a line.
fn rooms() -> Vec<String> {
    let page = fs::read_to_string("../../book/src/house.md").expect("the page of the house");
    let drawn = page
        .lines()
        .filter_map(|line| line.strip_prefix("      |   "));
    let names = drawn.filter_map(|line| line.split_once("  ").map(|(names, _)| names));
    let names = names.flat_map(|names| names.split(", "));
    names
        .filter(|name| module(name).is_some())
        .map(str::to_owned)
        .collect()
}

/// File or folder of a module of the core.
fn module(name: &str) -> Option<PathBuf> {
    let places = [format!("src/{name}.rs"), format!("src/{name}")];
    places.into_iter().map(PathBuf::from).find(|p| p.exists())
}

fn sources(place: &Path) -> Vec<PathBuf> {
    if !place.is_dir() {
        return vec![place.to_owned()];
    }
    let entries = fs::read_dir(place).expect("a folder");
    let entries = entries.map(|entry| entry.expect("an entry").path());
    entries.flat_map(|path| sources(&path)).collect()
}

/// Modules of the crate that a file names, apart from its comments.
fn imports(file: &Path) -> Vec<String> {
    let text = fs::read_to_string(file).expect("a source file");
    let code = text
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"));
    let named = code.flat_map(|line| line.split("crate::").skip(1));
    let module = named.map(|rest| {
        rest.split(|c: char| !c.is_alphanumeric() && c != '_')
            .next()
    });
    module.flatten().map(str::to_owned).collect()
}

#[test]
fn a_module_imports_only_modules_below_it() {
    let rooms = rooms();
    let declared = fs::read_to_string("src/lib.rs").expect("the root of the crate");
    for line in declared.lines().filter(|line| line.ends_with(';')) {
        let name = line.trim_start_matches("pub ").strip_prefix("mod ");
        if let Some(name) = name.map(|name| name.trim_end_matches(';')) {
            assert!(
                rooms.iter().any(|room| room == name),
                "book/src/house.md does not draw {name}"
            );
        }
    }
    let mut climbs = Vec::new();
    for (place, room) in rooms.iter().enumerate() {
        for file in sources(&module(room).expect("a module")) {
            let above = imports(&file)
                .into_iter()
                .filter(|name| rooms[..place].contains(name));
            climbs.extend(above.map(|name| format!("{} imports {name}", file.display())));
        }
    }
    assert!(climbs.is_empty(), "{}", climbs.join("\n"));
}
