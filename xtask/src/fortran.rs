//! Fortran compiler for the tests of user materials.

use std::path::PathBuf;
use std::process::{Command, Stdio};

/// Commands that install a compiler, tried in order.
const INSTALLATIONS: &[&[&str]] = &[
    &["apt-get", "install", "--yes", "gfortran"],
    // For machines with missing or outdated package lists.
    &[
        "sh",
        "-c",
        "apt-get update && apt-get install --yes gfortran",
    ],
    // For machines of continuous integration, where no password is needed.
    &["sudo", "-n", "apt-get", "install", "--yes", "gfortran"],
    &["dnf", "install", "--assumeyes", "gcc-gfortran"],
    &["brew", "install", "gcc"],
];

/// Compiler named by the variable `ONSET_FORTRAN` or `FC`, or `gfortran`.
///
/// Installs `gfortran` if it is missing and the installation needs no confirmation.
///
/// # Errors
/// Instructions for the user, if no compiler exists and none can be installed.
pub fn compiler() -> Result<PathBuf, String> {
    let named = ["ONSET_FORTRAN", "FC"]
        .into_iter()
        .find_map(|variable| std::env::var_os(variable).map(|name| (variable, name)));
    if let Some((variable, name)) = named {
        let compiler = PathBuf::from(name);
        return if answers(&compiler) {
            Ok(compiler)
        } else {
            Err(format!(
                "{variable} names {}, which does not answer --version",
                compiler.display()
            ))
        };
    }
    let gfortran = PathBuf::from("gfortran");
    if answers(&gfortran) {
        return Ok(gfortran);
    }
    for installation in INSTALLATIONS {
        eprintln!("== Fortran compiler: {}", installation.join(" "));
        let installed = Command::new(installation[0])
            .args(&installation[1..])
            .env("DEBIAN_FRONTEND", "noninteractive")
            .stdin(Stdio::null())
            .status()
            .is_ok_and(|status| status.success());
        if installed && answers(&gfortran) {
            return Ok(gfortran);
        }
    }
    Err(
        "there is no gfortran and none could be installed; install it (apt-get install gfortran, dnf install gcc-gfortran, brew \
         install gcc), or let ONSET_FORTRAN name a Fortran compiler with gfortran's arguments"
            .to_owned(),
    )
}

/// Returns true if a program starts and prints its version.
fn answers(program: &PathBuf) -> bool {
    Command::new(program)
        .arg("--version")
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success())
}
