//! Running a deck with an installed code.

use super::{CASE_FILE, Case, Judgment, VerifyError, named, read};
use std::fs::File;
use std::io::ErrorKind;
use std::path::Path;
use std::process::{Command, Stdio};

/// Name of the file with the output of the program.
const LOG: &str = "run.log";
/// Number of lines shown of a failed run.
const TAIL: usize = 8;

/// Runs the deck in a folder and compares its output with the prediction; `program` replaces the usual executable.
///
/// # Errors
/// [`VerifyError`] if the program cannot be started or fails, and as for [`read`].
pub fn run(folder: &Path, program: Option<&Path>) -> Result<Judgment, VerifyError> {
    let case = Case::of_file(&folder.join(CASE_FILE))?;
    let code = named(&case.code)?;
    let Some(usual) = code.program() else {
        return Err(VerifyError::Refused {
            code: code.name(),
            what: "onset cannot start this code".to_owned(),
            hint: format!(
                "run it, and read its {} with `onset verify read`",
                code.output()
            ),
        });
    };
    // The child runs in the folder, so a relative path must be made absolute first.
    let program = match program {
        Some(path) if path.components().count() > 1 => {
            std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
        }
        Some(name) => name.to_owned(),
        None => usual.name.into(),
    };
    let log = folder.join(LOG);
    let unwritable = |source| VerifyError::Unreadable {
        path: log.clone(),
        source,
    };
    let printed = File::create(&log).map_err(unwritable)?;
    let errors = printed.try_clone().map_err(unwritable)?;
    // Output of an earlier run must not be mistaken for the output of this one.
    match std::fs::remove_file(folder.join(code.output())) {
        Err(error) if error.kind() != ErrorKind::NotFound => return Err(unwritable(error)),
        _ => {}
    }
    let mut command = Command::new(&program);
    command
        .args(usual.arguments)
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(printed)
        .stderr(errors);
    let status = onset_umat::run(&mut command).map_err(|source| VerifyError::NotInstalled {
        program: program.display().to_string(),
        source,
        hint: usual.install,
    })?;
    if !status.success() {
        let printed = std::fs::read(&log).unwrap_or_default();
        let printed = String::from_utf8_lossy(&printed).into_owned();
        let lines: Vec<&str> = printed.lines().collect();
        let tail = lines[lines.len().saturating_sub(TAIL)..].iter();
        return Err(VerifyError::Failed {
            program: program.display().to_string(),
            status: status.to_string(),
            tail: tail
                .map(|line| format!("    {line}\n"))
                .collect::<String>()
                .trim_end()
                .to_owned(),
            log,
        });
    }
    read(folder, None)
}
