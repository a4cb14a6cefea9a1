//! Tasks of the workspace: `cargo xtask test`, `verify`, `simulate`, `hunt`, `figures`, `readme`, `schema`, `wheel`, `python`, `page`, `book`,
//! `bench` and `timings`.

#[cfg(unix)]
mod abuse;
mod bench;
mod book;
mod deny;
mod english;
mod fortran;
mod hunt;
mod npm;
mod page;
mod python;
mod readme;
mod simulate;
mod timings;
mod verify;
mod wasm;
mod wheel;

use std::path::Path;
use std::process::{Command, ExitCode, Stdio};

/// Step of a task: its purpose, and the arguments of cargo.
type Step = (&'static str, &'static [&'static str]);

/// Checks that must pass before a change is accepted.
const TEST: &[Step] = &[
    ("formatting", &["fmt", "--all", "--check"]),
    (
        "lints",
        &[
            "clippy",
            "--workspace",
            "--all-targets",
            "--all-features",
            "--",
            "--deny",
            "warnings",
        ],
    ),
    (
        "documentation",
        &["doc", "--workspace", "--no-deps", "--all-features"],
    ),
    (
        "tests",
        &["test", "--workspace", "--all-features", "--no-fail-fast"],
    ),
];

const TESTS_WITHOUT_FORTRAN: &[&str] = &[
    "test",
    "--workspace",
    "--all-features",
    "--exclude",
    "onset-umat",
    "--",
    "--skip",
    "umat::",
    "--skip",
    "audit::",
];

/// Figures in README and book.
const FIGURES: &[Step] = &[
    (
        "figures",
        &[
            "run",
            "--release",
            "--",
            "reproduce",
            "--out",
            "target/reproduction",
        ],
    ),
    (
        "comparison",
        &[
            "run",
            "--release",
            "--",
            "compare",
            "comparisons/methods-2d.toml",
            "--out",
            "target/comparison",
        ],
    ),
    (
        "table of methods",
        &[
            "run",
            "--release",
            "--",
            "compare",
            "comparisons/table-2d.toml",
            "--size",
            "174mm",
            "--out",
            "target/table",
        ],
    ),
    (
        "kernels",
        &[
            "run",
            "--release",
            "--",
            "list",
            "kernels",
            "--out",
            "target/kernels.svg",
        ],
    ),
    (
        "map",
        &[
            "run",
            "--release",
            "--",
            "map",
            "studies/foam-material-points.toml",
            "--out",
            "target/foam.zarr",
            "--overwrite",
        ],
    ),
    (
        "figure of the map",
        &[
            "run",
            "--release",
            "--",
            "plot",
            "target/foam.zarr",
            "--trace",
            "--out",
            "target/foam.svg",
        ],
    ),
];

/// Runs of bodies whose last pictures are in the book: name of the picture, study, and options.
const BODIES: &[(&str, &str, &str)] = &[
    (
        "notched-plate-without-penalty",
        "notched-plate",
        "--time 60 --amplitude 0.01 --set discretization.penalty=0",
    ),
    (
        "notched-plate",
        "notched-plate",
        "--time 60 --amplitude 0.01",
    ),
    (
        "shear-bands",
        "shear-band",
        "--stretch 0.25,1 --time 2.5 --amplitude 1e-3",
    ),
    ("pulled-bar", "pulled-bar", "--time 60 --amplitude 1e-3"),
    (
        "pulled-bar-total-lagrangian",
        "pulled-bar",
        "--time 60 --amplitude 1e-3 --set discretization.method=total-lagrangian-sph --set discretization.penalty=0.5",
    ),
    ("rings", "rings", "--time 150 --fraction 0.2"),
    (
        "rings-artificial-stress",
        "rings",
        "--time 150 --fraction 0.2 --set discretization.artificial-stress=0.3",
    ),
    (
        "rings-parted",
        "rings",
        "--time 400 --fraction 0.2 --set discretization.artificial-stress=0.3",
    ),
    (
        "rings-total-lagrangian",
        "rings-total-lagrangian",
        "--time 150",
    ),
    (
        "rings-total-lagrangian-parted",
        "rings-total-lagrangian",
        "--time 400",
    ),
    ("rubber-strip", "rubber-strip", "--time 400"),
];

fn main() -> ExitCode {
    let task = std::env::args().nth(1);
    let done = match task.as_deref() {
        Some("test") => test(),
        Some("hunt") => {
            let arguments: Vec<String> = std::env::args().skip(2).collect();
            reported(hunt::run(&arguments))
        }
        #[cfg(unix)]
        Some("abuse") => {
            let arguments: Vec<String> = std::env::args().skip(2).collect();
            reported(abuse::run(&arguments))
        }
        Some("verify") => reported(verify::run(
            std::env::args().nth(2).as_deref() == Some("--all"),
        )),
        Some("simulate") => reported(simulate::run()),
        Some("wheel") => reported(wheel::run()),
        Some("python") => reported(wheel::test()),
        Some("page") => reported(page::run()),
        Some("book") => reported(book::run()),
        Some("english") => {
            let names: Vec<String> = std::env::args().skip(2).collect();
            reported(english::check(&names))
        }
        Some("schema") => write_schema(),
        Some("readme") => reported(readme::run()),
        Some("figures") => run(FIGURES, &[]) && copy_figures() && reported(draw_bodies()),
        Some("bench") => reported(bench::run(
            std::env::args().nth(2).as_deref() == Some("--quick"),
        )),
        Some("timings") => reported(timings::run()),
        _ => {
            eprintln!(
                "usage: cargo xtask test              formatting, lints, all tests, documentation, the paper\n       cargo xtask verify [--all]    predictions against LAMMPS (with --all PySPH too), and the table of the book\n       cargo xtask simulate          the motion of every method against its prediction, and the table of the book\n       cargo xtask hunt [CHECK] [--seed N] [--cases N] [--minutes N] [--release]   checks on random cases\n       cargo xtask abuse [--minutes N] [--proof] [--seed N] [--command FILE]   kills, signals, damaged files, half requests, odd arrays and terminals, counted\n       cargo xtask figures           the figures of README and book\n       cargo xtask readme            fills in the answers of the commands in README.md and of the published fits\n       cargo xtask wheel             the Python package, target/wheels\n       cargo xtask python            the tests of the Python package\n       cargo xtask page              the page of `onset explore`, built and driven by a browser\n       cargo xtask book              the book, built with its links checked: target/book\n       cargo xtask english [PATH]    prose that a native reader would send back; without PATH also links and spelling\n       cargo xtask schema            the JSON Schema of study files, studies/study.schema.json\n       cargo xtask bench [--quick]   benchmarks, and the same work in NumPy and JAX: bench/README.md\n       cargo xtask timings           build times of the workspace: CONTRIBUTING.md"
            );
            return ExitCode::from(2);
        }
    };
    if done {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

/// Runs all checks, with an interpreter for the tests that open results in Python, a Fortran compiler for the tests of user materials, and LAMMPS for
/// the verification of predicted waves.
fn test() -> bool {
    let requirements = Path::new("crates/onset-cli/tests/python/requirements.txt");
    let interpreter = match python::environment("test", requirements) {
        Ok(interpreter) => interpreter,
        Err(error) => {
            eprintln!("== Python environment: {error}");
            return false;
        }
    };
    let mut tools = vec![("ONSET_PYTHON", interpreter)];
    let lammps = verify::lammps();
    if let Ok(program) = &lammps {
        tools.push(("ONSET_LAMMPS", program.clone()));
    }
    let fortran = fortran::compiler();
    let steps = match &fortran {
        Ok(compiler) => {
            tools.push(("ONSET_FORTRAN", compiler.clone()));
            TEST.to_vec()
        }
        Err(_) => without_fortran(),
    };
    let tools: Vec<(&str, &Path)> = tools.iter().map(|(name, path)| (*name, &**path)).collect();
    let wasm = wasm::tools();
    let deny = deny::tool();
    let advisories = deny.as_ref().ok().and_then(|tool| deny::advisories(tool));
    let (mdbook, browser, done) = std::thread::scope(|scope| {
        // Tools for the last steps are installed while the first steps run.
        let tools_of_last = scope.spawn(|| (book::tools(), page::tools(), wheel::environments()));
        let first = reported(english::check(&[]))
            && deny
                .as_ref()
                .map_or(true, |tool| reported(deny::check(tool)))
            && advisories
                .as_ref()
                .is_none_or(|found| reported(found.clone()))
            && (wasm.is_err() || reported(wasm::check()))
            && run(&steps, &tools);
        let (mdbook, browser, environments) = joined(tools_of_last);
        let done = first
            && mdbook
                .as_ref()
                .map_or(true, |mdbook| reported(book::build(mdbook)))
            && reported(paper())
            && reported(environments.map(|_| ()))
            && python_and_page(browser.is_ok())
            && abused();
        (mdbook, browser, done)
    });
    if let Err(error) = mdbook {
        eprintln!("== NOT TESTED: the built book, its formulas and its links. {error}");
    }
    if let Err(error) = deny {
        eprintln!("== NOT TESTED: licenses and sources of linked crates. {error}");
    }
    if advisories.is_none() {
        eprintln!(
            "== NOT TESTED: advisories on linked crates. The database is missing: cargo deny fetch"
        );
    }
    if let Err(error) = wasm {
        eprintln!("== NOT TESTED: the core in a browser. {error}");
    }
    if let Err(error) = fortran {
        eprintln!("== NOT TESTED: user materials. {error}");
    }
    if let Err(error) = browser {
        eprintln!("== NOT TESTED: the page of `onset explore` in a browser. {error}");
    }
    if let Err(error) = lammps {
        eprintln!("== NOT TESTED: predictions against LAMMPS. {error}");
    }
    done
}

/// Tests the Python package and, if possible, the page in a browser. Each uses mostly a single process, so the two run in parallel.
fn python_and_page(has_browser: bool) -> bool {
    std::thread::scope(|scope| {
        let page = has_browser.then(|| scope.spawn(|| reported(page::test())));
        let package = reported(wheel::test());
        page.is_none_or(joined) && package
    })
}

/// Result of a thread; its panic is propagated.
fn joined<T>(thread: std::thread::ScopedJoinHandle<'_, T>) -> T {
    thread
        .join()
        .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
}

/// Reproduces the paper with the command built by the tests.
///
/// `cargo run` would select other features of the dependencies and build the core a second time.
fn paper() -> Result<(), String> {
    let command = wheel::command()?;
    eprintln!("== the paper: onset reproduce");
    python::succeed(Command::new(command).args(["reproduce", "--out", "target/reproduction"]))
}

#[cfg(unix)]
fn abused() -> bool {
    reported(abuse::test())
}

#[cfg(not(unix))]
fn abused() -> bool {
    true
}

/// Checks for a machine without a Fortran compiler.
fn without_fortran() -> Vec<Step> {
    let step = |(purpose, arguments): &Step| match *purpose {
        "tests" => ("tests without user materials", TESTS_WITHOUT_FORTRAN),
        _ => (*purpose, *arguments),
    };
    TEST.iter().map(step).collect()
}

/// Reports a failure; returns true on success.
fn reported(result: Result<(), String>) -> bool {
    if let Err(message) = &result {
        eprintln!("== {message}");
    }
    result.is_ok()
}

fn run(steps: &[Step], tools: &[(&str, &Path)]) -> bool {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    steps.iter().all(|(purpose, arguments)| {
        eprintln!("== {purpose}: cargo {}", arguments.join(" "));
        let mut command = Command::new(&cargo);
        command
            .args(*arguments)
            .env("RUSTDOCFLAGS", "--deny warnings")
            .envs(tools.iter().copied());
        let status = command.status();
        let done = status.as_ref().is_ok_and(std::process::ExitStatus::success);
        if !done {
            eprintln!("== {purpose}: failed");
        }
        done
    })
}

/// Writes the schema printed by the command.
fn write_schema() -> bool {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let output = Command::new(cargo)
        .args(["run", "--quiet", "--", "schema"])
        .stderr(Stdio::inherit())
        .output();
    output.is_ok_and(|output| {
        output.status.success()
            && std::fs::write("studies/study.schema.json", &output.stdout).is_ok()
    })
}

/// Simulates the bodies of the book, and copies their last pictures into it.
///
/// # Errors
/// Description of the failure.
fn draw_bodies() -> Result<(), String> {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    for (name, study, options) in BODIES {
        eprintln!("== {name}");
        let out = format!("target/bodies/{name}");
        python::succeed(
            Command::new(&cargo)
                .args(["run", "--release", "--", "simulate"])
                .arg(format!("studies/bodies/{study}.toml"))
                .args(options.split(' '))
                .args(["--overwrite", "--out", &out]),
        )?;
        let to = format!("book/src/figures/{name}.svg");
        std::fs::copy(format!("{out}/body.svg"), &to)
            .map_err(|error| format!("{to}: cannot be copied: {error}"))?;
    }
    Ok(())
}

/// Copies the figures of README and book from the reproduction and the comparison.
fn copy_figures() -> bool {
    let reproduced = [
        "figure-02",
        "figure-04",
        "figure-05",
        "figure-06",
        "figure-08",
        "figure-10",
    ];
    let reproduced = reproduced.map(|name| (format!("target/reproduction/{name}.svg"), name));
    let compared = ("target/comparison/compare.svg".to_owned(), "methods-2d");
    let table = ("target/table/compare.svg".to_owned(), "table-2d");
    let kernels = ("target/kernels.svg".to_owned(), "kernels");
    let mapped = ("target/foam.svg".to_owned(), "foam-material-points");
    reproduced
        .into_iter()
        .chain([compared, table, mapped, kernels])
        .all(|(from, name)| {
            let to = format!("book/src/figures/{name}.svg");
            std::fs::create_dir_all("book/src/figures")
                .and_then(|()| std::fs::copy(&from, &to))
                .is_ok()
        })
}
