//! README and the page of published fits show the output of their commands.

use super::Scratch;
use std::path::Path;
use std::process::Command;

/// Command of the README, with the output shown below it.
struct Shown {
    command: String,
    lines: Vec<String>,
}

fn shown(text: &str) -> Vec<Shown> {
    let mut all: Vec<Shown> = Vec::new();
    for block in text.split("```console\n").skip(1) {
        let block = block.split("\n```").next().expect("a block");
        let mut lines = block.lines();
        while let Some(line) = lines.next() {
            match line.strip_prefix("$ ") {
                Some(start) => {
                    let mut command = start.to_owned();
                    while command.ends_with('\\') {
                        command.push('\n');
                        command.push_str(lines.next().expect("a line that goes on"));
                    }
                    all.push(Shown {
                        command,
                        lines: Vec::new(),
                    });
                }
                None => all
                    .last_mut()
                    .expect("a command")
                    .lines
                    .push(line.to_owned()),
            }
        }
    }
    all
}

#[test]
fn consoles_in_the_readme_show_the_output_of_their_commands() {
    consoles_of("README.md", "readme", 5);
}

#[test]
fn cards_of_published_fits_show_the_output_of_their_commands() {
    consoles_of("book/src/how-to/fits.md", "fits", 5);
}

fn consoles_of(page: &str, name: &str, least: usize) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let text = std::fs::read_to_string(root.join(page)).expect("a page");
    let place = Scratch::new(name);
    std::fs::create_dir_all(&place).expect("a folder");
    for folder in ["studies", "comparisons"] {
        let there = root.join(folder).canonicalize().expect("a folder");
        std::os::unix::fs::symlink(there, place.join(folder)).expect("a link");
    }
    let own = Path::new(env!("CARGO_BIN_EXE_onset"))
        .parent()
        .expect("a folder");
    let path = format!(
        "{}:{}",
        own.display(),
        std::env::var("PATH").unwrap_or_default()
    );
    let all = shown(&text);
    assert!(all.len() >= least, "{} commands", all.len());
    for Shown { command, lines } in all {
        let run = Command::new("bash")
            .args(["-c", &command])
            .env("PATH", &path)
            .current_dir(&place)
            .output()
            .expect("a shell");
        let printed = String::from_utf8_lossy(&run.stdout).into_owned()
            + &String::from_utf8_lossy(&run.stderr);
        let printed: Vec<&str> = printed.trim_end().lines().collect();
        let mut lines: Vec<&str> = lines.iter().map(String::as_str).collect();
        while lines.last().is_some_and(|line| line.is_empty()) {
            lines.pop();
        }
        match lines.split_last() {
            Some((&"...", first)) => assert_eq!(
                &printed[..first.len().min(printed.len())],
                first,
                "{command}"
            ),
            _ => assert_eq!(printed, lines, "{command}"),
        }
    }
}
