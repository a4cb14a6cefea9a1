//! `cargo xtask readme`: updates the console blocks of README.md and of the page of published fits with the present output of their commands.
//!
//! A console is a block that begins with three backticks and `console`. Lines after `$ ` are run in the root of the repository; a line that ends with
//! a backslash is continued. The output below a command is replaced. If its last line was `...`, the number of lines is kept.

use std::path::Path;
use std::process::Command;

/// Pages whose consoles are updated.
const PAGES: [&str; 2] = ["README.md", "book/src/how-to/fits.md"];

const BEGIN: &str = "```console\n";
const END: &str = "\n```";

/// Updates the consoles of all pages.
///
/// # Errors
/// Description of the failure.
pub fn run() -> Result<(), String> {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let built = Command::new(cargo).args(["build", "--release"]).status();
    if !built.is_ok_and(|status| status.success()) {
        return Err("the command cannot be built".to_owned());
    }
    let folder = Path::new("target/readme");
    // Commands write files next to their input files.
    std::fs::create_dir_all(folder).map_err(|error| format!("target/readme: {error}"))?;
    let copied = Command::new("cp")
        .args(["-rL", "studies", "comparisons", "target/readme"])
        .status();
    if !copied.is_ok_and(|status| status.success()) {
        return Err("studies and comparisons cannot be copied to target/readme".to_owned());
    }
    PAGES.iter().try_for_each(|page| fill(page, folder))
}

/// Updates the consoles of a page.
fn fill(page: &str, folder: &Path) -> Result<(), String> {
    let failed = |error: std::io::Error| format!("{page}: {error}");
    let text = std::fs::read_to_string(page).map_err(failed)?;
    let mut filled = String::new();
    let mut rest = text.as_str();
    while let Some(begin) = rest.find(BEGIN) {
        let (before, after) = rest.split_at(begin + BEGIN.len());
        let end = after
            .find(END)
            .ok_or_else(|| format!("{page}: a console does not end"))?;
        filled.push_str(before);
        filled.push_str(&console(&after[..end], folder)?);
        rest = &after[end..];
    }
    filled.push_str(rest);
    std::fs::write(page, filled).map_err(failed)
}

/// Console with the present output of its commands.
fn console(block: &str, folder: &Path) -> Result<String, String> {
    let mut commands: Vec<(String, Vec<&str>)> = Vec::new();
    let mut lines = block.lines();
    while let Some(line) = lines.next() {
        if let Some(first) = line.strip_prefix("$ ") {
            let mut command = first.to_owned();
            while command.ends_with('\\') {
                command.push('\n');
                command.push_str(lines.next().ok_or("a command does not end")?);
            }
            commands.push((command, Vec::new()));
        } else if let Some((_, shown)) = commands.last_mut() {
            shown.push(line);
        }
    }
    let filled: Result<Vec<String>, String> = commands
        .iter()
        .map(|(command, shown)| {
            let printed = printed(command, folder)?;
            let kept = shown.iter().rposition(|line| *line == "...");
            let below = match kept {
                Some(count) => {
                    let first: Vec<&str> = printed.lines().take(count.max(1)).collect();
                    format!("{}\n...", first.join("\n"))
                }
                None => printed,
            };
            Ok(format!("$ {command}\n{below}"))
        })
        .collect();
    Ok(filled?.join("\n\n"))
}

/// Output of a command, with errors after the answer.
fn printed(command: &str, folder: &Path) -> Result<String, String> {
    let root = std::env::current_dir().map_err(|error| error.to_string())?;
    let path = std::env::var("PATH").unwrap_or_default();
    let run = Command::new("bash")
        .args(["-c", command])
        .env(
            "PATH",
            format!("{}:{path}", root.join("target/release").display()),
        )
        .current_dir(folder)
        .output()
        .map_err(|error| format!("{command}: {error}"))?;
    let text =
        String::from_utf8_lossy(&run.stdout).into_owned() + &String::from_utf8_lossy(&run.stderr);
    Ok(text.trim_end().to_owned())
}
