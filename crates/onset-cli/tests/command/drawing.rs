//! Options of commands that draw a figure: its place, size, words and colors.

use super::{Scratch, onset_line};

/// Names in a folder, sorted.
fn names(folder: &Scratch) -> Vec<String> {
    let entries = std::fs::read_dir(folder.display().to_string()).expect("a folder");
    let mut names: Vec<String> = entries
        .map(|entry| entry.expect("an entry").file_name().display().to_string())
        .collect();
    names.sort();
    names
}

const LOCALIZE: &str = "localize --model j2 --path plane-strain";

#[test]
fn an_output_name_with_an_extension_writes_only_the_figure() {
    let folder = Scratch::new("drawn-alone");
    let place = folder.display();
    let line =
        format!("{LOCALIZE} --out {place}/band.pdf --size 84mm --bare --title Mine --theme dark");
    let output = onset_line(&line);
    assert_eq!(output.code, Some(0), "{}", output.stderr);
    assert_eq!(
        names(&folder),
        ["band.pdf", "band.png", "band.svg", "band.txt"]
    );
    let svg = std::fs::read_to_string(format!("{place}/band.svg")).expect("an SVG");
    assert!(
        svg.contains("width=\"84mm\"") && svg.contains("#16181c"),
        "{}",
        &svg[..400]
    );
    let words = std::fs::read_to_string(format!("{place}/band.txt")).expect("words");
    assert!(
        words.starts_with("Mine. ") && words.lines().count() == 1,
        "{words}"
    );
    // In a folder the figure is written next to the tables and contains its text.
    let whole = Scratch::new("drawn-in-a-folder");
    let output = onset_line(&format!(
        "{LOCALIZE} --out {} --title Mine",
        whole.display()
    ));
    assert_eq!(output.code, Some(0), "{}", output.stderr);
    let expected = [
        "localize-directions.csv",
        "localize.csv",
        "localize.pdf",
        "localize.png",
        "localize.svg",
    ];
    assert_eq!(names(&whole), expected);
    let svg = std::fs::read_to_string(format!("{}/localize.svg", whole.display()));
    assert!(svg.expect("an SVG").contains(">Mine</text>"));
}

#[test]
fn options_of_a_figure_that_is_not_drawn_are_refused() {
    let folder = Scratch::new("not-drawn");
    let place = folder.display();
    for (line, told) in [
        (
            format!("{LOCALIZE} --size 84mm"),
            "--size has no effect: no figure is drawn",
        ),
        (format!("{LOCALIZE} --theme dark"), "--out localize.pdf"),
        ("simulate --bare".to_owned(), "--bare has no effect"),
        (
            format!("{LOCALIZE} --size 84 --out {place}"),
            "expected a width from 30 to 1000 mm",
        ),
        (
            format!("{LOCALIZE} --theme blue --out {place}"),
            "expected light or dark",
        ),
        (
            format!("{LOCALIZE} --out {place}/band.eps"),
            "figures are written as SVG, PNG and PDF",
        ),
        (
            format!("reproduce --size 84 --out {place}"),
            "expected a width from 30 to 1000 mm",
        ),
    ] {
        let output = onset_line(&line);
        assert_eq!(output.code, Some(2), "{line}: {}", output.stderr);
        assert!(output.stderr.contains(told), "{line}: {}", output.stderr);
    }
    assert!(!folder.exists());
}

#[test]
fn a_simulation_takes_a_fraction_of_the_step_and_a_size_of_its_figure() {
    let folder = Scratch::new("simulated");
    let line = format!(
        "simulate --stretch 1.1,1 --cells 4 --steps 64 --fraction 0.2 --out {} --size 84mm",
        folder.display()
    );
    let output = onset_line(&line);
    assert!(
        output.code.is_some_and(|code| code == 0 || code == 3),
        "{}",
        output.stderr
    );
    let svg = std::fs::read_to_string(format!("{}/simulate.svg", folder.display()));
    assert!(svg.expect("an SVG").contains("width=\"84mm\""));
    // A name with the ending of a figure is the figure alone.
    let alone = Scratch::new("simulated-alone");
    let line = format!(
        "simulate --stretch 1.1,1 --cells 4 --steps 64 --out {}/wave.pdf",
        alone.display()
    );
    let output = onset_line(&line);
    assert!(output.stdout.contains("wave.pdf"), "{}", output.stderr);
    assert_eq!(names(&alone), ["wave.pdf", "wave.png", "wave.svg"]);
    let output = onset_line(&format!("{line} --fields 2"));
    assert_eq!(output.code, Some(2));
    assert!(
        output.stderr.contains("--fields has no effect"),
        "{}",
        output.stderr
    );
}
