//! The book: built with mdBook, with rendered formulas and checked links, and without content from other servers.

use crate::npm::packages;
use crate::python::succeed;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};
use std::process::{Command, Stdio};

/// Folder of the sources, and folder of the built book.
const FOLDER: &str = "book";
const BUILT: &str = "target/book";
/// Version of mdBook, and the folder where it is installed if missing.
const VERSION: &str = "0.5.4";
const TOOLS: &str = "target/tools";
/// Font with the glyphs for formulas that system fonts lack.
const FONT: &str = "node_modules/temml/dist/Temml.woff2";

/// Builds the book into `target/book`, and checks it.
///
/// # Errors
/// Description of the failure.
pub fn run() -> Result<(), String> {
    build(&tools()?)?;
    println!("{BUILT}/index.html");
    Ok(())
}

/// Prepares the tools for building the book: the packages for its formulas, and mdBook.
///
/// The path of mdBook is given by the variable `ONSET_MDBOOK`; otherwise it is found on the path, or installed into `target/tools` without the
/// features `serve` and `watch`.
///
/// # Errors
/// Description of the missing tool.
pub fn tools() -> Result<PathBuf, String> {
    packages(Path::new(FOLDER))?;
    if let Some(named) = std::env::var_os("ONSET_MDBOOK") {
        return Ok(PathBuf::from(named));
    }
    let own = Path::new(TOOLS).join(format!("bin/mdbook{}", std::env::consts::EXE_SUFFIX));
    let own = std::path::absolute(own).map_err(|error| error.to_string())?;
    for program in [PathBuf::from("mdbook"), own.clone()] {
        if version(&program).is_some_and(|found| found.ends_with(VERSION)) {
            return Ok(program);
        }
    }
    eprintln!("== book: cargo install mdbook");
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    succeed(
        Command::new(cargo)
            .args(["install", "mdbook", "--locked", "--no-default-features"])
            .args(["--version", VERSION, "--root", TOOLS])
            // The program builds a single book, so that a short compilation matters more than its speed.
            .env("CARGO_PROFILE_RELEASE_OPT_LEVEL", "0")
            .env("CARGO_PROFILE_RELEASE_LTO", "off")
            .env("CARGO_PROFILE_RELEASE_CODEGEN_UNITS", "16"),
    )?;
    Ok(own)
}

/// Version printed by a program.
fn version(program: &Path) -> Option<String> {
    let output = Command::new(program)
        .arg("--version")
        .stderr(Stdio::null())
        .output()
        .ok()?;
    Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// Builds the book and checks its links.
///
/// # Errors
/// Description of the failure, and all broken links.
pub fn build(mdbook: &Path) -> Result<(), String> {
    eprintln!("== the book: mdbook build");
    // Files of an earlier build must not hide missing files.
    let _ = std::fs::remove_dir_all(BUILT);
    succeed(Command::new(mdbook).args(["build", FOLDER]))?;
    let font = Path::new(BUILT).join(FONT);
    std::fs::copy(Path::new(FOLDER).join(FONT), &font)
        .map_err(|error| format!("{}: {error}", font.display()))?;
    let wrong = wrong_in_book(Path::new(BUILT))?;
    match wrong.is_empty() {
        true => Ok(()),
        false => Err(format!("links that lead nowhere:\n{}", wrong.join("\n"))),
    }
}

/// HTML page: its anchors, its links, and the resources that it loads.
#[derive(Default)]
struct Page {
    places: BTreeSet<String>,
    links: Vec<String>,
    loaded: Vec<String>,
}

impl Page {
    fn read(html: &str) -> Self {
        let mut page = Self::default();
        for tag in tags(html) {
            let name = tag.split_whitespace().next().unwrap_or_default();
            page.places.extend(attribute(tag, "id"));
            match name {
                "a" => page.links.extend(attribute(tag, "href")),
                "link" => page.loaded.extend(attribute(tag, "href")),
                _ => page.loaded.extend(attribute(tag, "src")),
            }
        }
        page
    }
}

/// Tags of a page, without their brackets; the content of scripts is skipped.
fn tags(html: &str) -> impl Iterator<Item = &str> {
    let mut rest = html;
    std::iter::from_fn(move || {
        let start = rest.find('<')? + 1;
        let end = start + rest[start..].find('>')?;
        let tag = &rest[start..end];
        rest = &rest[end..];
        if tag.starts_with("script") {
            rest = rest.find("</script>").map_or("", |end| &rest[end..]);
        }
        Some(tag)
    })
}

/// Value of an attribute of a tag.
fn attribute(tag: &str, name: &str) -> Option<String> {
    let (_, value) = tag.split_once(&format!(" {name}=\""))?;
    let value = value.split('"').next()?;
    Some(value.replace("&amp;", "&"))
}

/// Returns true if an address refers to another server, or to no file.
fn is_elsewhere(address: &str) -> bool {
    ["http:", "https:", "//", "mailto:", "data:"]
        .iter()
        .any(|start| address.starts_with(start))
}

/// Broken links of a built book, and resources on other servers.
fn wrong_in_book(folder: &Path) -> Result<Vec<String>, String> {
    let mut pages = BTreeMap::new();
    for file in files(folder)? {
        if file.extension().is_some_and(|end| end == "html") {
            let html = text(&file)?;
            pages.insert(file, Page::read(&html));
        }
    }
    let mut wrong = Vec::new();
    for (file, page) in &pages {
        let own = file.strip_prefix(folder).unwrap_or(file).display();
        for address in &page.loaded {
            if address.starts_with("http") || address.starts_with("//") {
                wrong.push(format!("{own}: {address} is loaded from another server"));
            }
        }
        // The 404 page has no fixed address, so that its relative links cannot be checked.
        let is_lost = file.ends_with("404.html");
        let all = page.links.iter().chain(&page.loaded);
        for address in all.filter(|address| !is_elsewhere(address) && !is_lost) {
            if let Some(why) = leads_nowhere(file, address, &pages) {
                wrong.push(format!("{own}: {address} {why}"));
            }
        }
    }
    Ok(wrong)
}

/// Reason why a link is broken; `None` for a valid link.
fn leads_nowhere(
    file: &Path,
    address: &str,
    pages: &BTreeMap<PathBuf, Page>,
) -> Option<&'static str> {
    let (path, place) = address.split_once('#').unwrap_or((address, ""));
    let target = match path {
        "" => file.to_owned(),
        path => beside(file, path),
    };
    match (pages.get(&target), place) {
        (Some(_), "") => None,
        (Some(page), place) if page.places.contains(place) => None,
        (Some(_), _) => Some("is not on that page"),
        (None, _) if target.is_file() => None,
        (None, _) => Some("is not there"),
    }
}

/// Path of a file that is referenced in another file.
fn beside(file: &Path, path: &str) -> PathBuf {
    let mut place = file.parent().map(Path::to_owned).unwrap_or_default();
    for part in Path::new(path).components() {
        match part {
            Component::ParentDir => {
                place.pop();
            }
            Component::Normal(name) => place.push(name),
            _ => {}
        }
    }
    place
}

/// All files of a folder and its subfolders.
fn files(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let told = |error: std::io::Error| format!("{}: {error}", folder.display());
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(told)? {
        let path = entry.map_err(told)?.path();
        match path.is_dir() {
            true => found.extend(files(&path)?),
            false => found.push(path),
        }
    }
    Ok(found)
}

fn text(file: &Path) -> Result<String, String> {
    std::fs::read_to_string(file).map_err(|error| format!("{}: {error}", file.display()))
}

#[cfg(test)]
mod tests {
    use super::{Page, wrong_in_book};

    #[test]
    fn broken_links_and_other_servers_are_reported() {
        let folder = std::env::temp_dir().join(format!("onset-book-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("part")).expect("a folder");
        let page = |name: &str, html: &str| {
            std::fs::write(folder.join(name), html).expect("a page");
        };
        page(
            "index.html",
            "<h1 id=\"top\">T</h1><a class=\"x\" href=\"part/one.html#there\">1</a><a href=\"#top\">2</a>\
             <a href=\"part/one.html#gone\">3</a><a href=\"two.html\">4</a><a href=\"https://example.org\">5</a>\
             <script>\"<a href='none'>\"</script><script src=\"https://example.org/a.js\"></script>",
        );
        page(
            "part/one.html",
            "<h2 id=\"there\">O</h2><a href=\"../index.html#top\">1</a><img src=\"../none.svg\">",
        );
        let wrong = wrong_in_book(&folder).expect("read");
        assert_eq!(
            wrong,
            [
                "index.html: https://example.org/a.js is loaded from another server",
                "index.html: part/one.html#gone is not on that page",
                "index.html: two.html is not there",
                "part/one.html: ../none.svg is not there",
            ]
        );
        std::fs::remove_dir_all(folder).expect("removed");
        assert!(Page::read("<p").links.is_empty());
    }
}
