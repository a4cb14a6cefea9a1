//! Benchmarks of this program, and of the same work in user-level Python.

use crate::python;
use crate::verify::lammps;
use std::path::Path;
use std::process::Command;

/// Runs the criterion benches, checks the peers against the command, and compares states per second and minima.
///
/// A full run writes `bench/README.md`, `bench/waiting.md`, `bench/methods.md` and `bench/bodies.md`; a quick run writes preliminary tables to `target/bench/`.
///
/// # Errors
/// Description of the failure.
pub fn run(quick: bool) -> Result<(), String> {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let interpreter = python::environment("peers", Path::new("bench/requirements.txt"))?;
    if !quick {
        step(
            "criterion benches",
            Command::new(&cargo).args(["bench", "--package", "onset"]),
        )?;
    }
    step(
        "the command",
        Command::new(&cargo).args(["build", "--release", "--package", "onset-cli"]),
    )?;
    let target = std::env::var("CARGO_TARGET_DIR").unwrap_or_else(|_| "target".to_owned());
    let current = std::env::current_dir()
        .map_err(|error| format!("cannot determine the current folder: {error}"))?;
    let onset = current.join(target).join("release/onset");
    measured(
        "how long people wait",
        "waiting",
        &interpreter,
        &onset,
        quick,
    )?;
    // Maps of newer methods and of their nearest relatives.
    measured(
        "maps of newer methods",
        "methods",
        &interpreter,
        &onset,
        quick,
    )?;
    bodies(&cargo, &interpreter, quick)?;
    // The program is compiled before it is timed.
    step(
        "the map",
        Command::new(&cargo).args([
            "bench",
            "--package",
            "onset-study",
            "--bench",
            "map",
            "--no-run",
        ]),
    )?;
    let states = if quick { "10" } else { "40" };
    step(
        "the peers against the command",
        Command::new(&interpreter)
            .current_dir("bench")
            .args(["-m", "peers.check", "--states", states, "--onset"])
            .arg(onset),
    )?;
    let mut compare = Command::new(&interpreter);
    compare.arg("bench/compare.py");
    step(
        "the peers against the map",
        into(&mut compare, quick, "README.md")?,
    )
}

/// Adds the path of the output table: in `bench/`, or in `target/bench/` for a quick run.
fn into<'a>(compare: &'a mut Command, quick: bool, table: &str) -> Result<&'a mut Command, String> {
    let folder = Path::new(if quick { "target/bench" } else { "bench" });
    std::fs::create_dir_all(folder)
        .map_err(|error| format!("cannot make {}: {error}", folder.display()))?;
    compare.arg("--out").arg(folder.join(table));
    Ok(if quick {
        compare.arg("--quick")
    } else {
        compare
    })
}

/// Runs a script of `bench/` that measures the command and writes a table of the same name.
fn measured(
    title: &str,
    script: &str,
    interpreter: &Path,
    onset: &Path,
    quick: bool,
) -> Result<(), String> {
    let mut command = Command::new(interpreter);
    command
        .arg(format!("bench/{script}.py"))
        .arg("--onset")
        .arg(onset);
    step(title, into(&mut command, quick, &format!("{script}.md"))?)
}

/// Compares time steps of a body with LAMMPS, if it is available.
fn bodies(cargo: &str, interpreter: &Path, quick: bool) -> Result<(), String> {
    let lammps = match lammps() {
        Ok(program) => program,
        Err(error) => {
            eprintln!("== NOT MEASURED: bodies against LAMMPS: {error}");
            return Ok(());
        }
    };
    let built = Command::new(cargo)
        .args(["bench", "--package", "onset", "--features", "rayon"])
        .args(["--bench", "bodies", "--no-run", "--message-format", "json"])
        .output()
        .map_err(|error| format!("bodies: cannot run: {error}"))?;
    let told = String::from_utf8_lossy(&built.stdout);
    let program = told.lines().rev().find_map(|line| {
        let (_, rest) = line.split_once("\"executable\":\"")?;
        rest.split('"').next()
    });
    let program = program.ok_or("bodies: the bench was not built")?;
    let mut compare = Command::new(interpreter);
    compare.arg("bench/bodies.py").args(["--onset", program]);
    compare.arg("--lammps").arg(lammps);
    step(
        "bodies against LAMMPS",
        into(&mut compare, quick, "bodies.md")?,
    )
}

fn step(purpose: &str, command: &mut Command) -> Result<(), String> {
    eprintln!("== {purpose}");
    let status = command
        .status()
        .map_err(|error| format!("{purpose}: cannot run: {error}"))?;
    if status.success() {
        Ok(())
    } else {
        Err(format!("{purpose}: failed"))
    }
}
