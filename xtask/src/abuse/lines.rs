//! Random command lines and formulas, and unusual terminals.

use super::running::{Fault, Place};
use super::{Programs, Random};
use std::process::Command;

const COMMANDS: &[&str] = &[
    "state",
    "dispersion",
    "path",
    "localize",
    "map",
    "criteria",
    "card",
    "list",
    "audit",
    "check",
    "boundary",
    "compare",
    "modes",
    "tune",
    "limit",
    "recommend",
    "plot",
    "simulate",
    "fit",
    "screen",
    "zoo",
    "verify deck",
    "verify read",
    "schema",
    "completions",
    "nothing",
];
const OPTIONS: &[&str] = &[
    "--stretch",
    "--set",
    "--out",
    "--json",
    "--quiet",
    "--format",
    "--energy",
    "--wave-vector",
    "--range",
    "--mode",
    "--to",
    "--from",
    "--steps",
    "--cells",
    "--deformation-gradient",
    "--time-step",
    "--vary",
    "--tiles",
    "--integrator",
    "--certify",
    "--fail-on",
    "--law",
    "--uniaxial",
    "--unit",
    "--columns",
    "--frames",
    "--held",
    "--model",
    "--material",
    "--",
];
const WORDS: &[&str] = &[
    "1.1,0.9",
    "1,1",
    "0,0",
    "-1,2",
    "nan,inf",
    "1e308,1e-308",
    "",
    ",",
    "text",
    "csv",
    "json",
    "uniaxial",
    "3.14159,0",
    "0.5,2",
    "neo-hooke",
    "material.model=neo-hooke",
    "discretization.method=updated-sph",
    "discretization.method=tlsph",
    "discretization.cells=3",
    "discretization.perturbation=0.1",
    "discretization.support=1e9",
    "material.mu=1e400",
    "material.model=formula",
    "a.b.c",
    "=",
    "\u{1b}[2J",
    "\u{202e}",
    "/dev/null",
    "/dev/full",
    ".",
    "out",
    "study.toml",
    "tests.csv",
    "run.csv",
    "yeoh",
    "MPa",
    "x=a,b",
    "- ",
    "99999999999999999999",
    "0x10",
    "mu/2*(I1-3)",
    "j2",
    "--help",
];
const STUDY: &str = "[discretization]\nmethod = \"updated-sph\"\n[[axes]]\nquantity = \"stretch-1\"\nrange = [0.8, 1.2]\nstates = 4\n[[axes]]\nquantity = \"stretch-2\"\nrange = [0.8, 1.2]\nstates = 4\n";

/// Checks that a random command line ends with a documented exit code.
pub(super) fn command_line(
    programs: &Programs,
    place: &Place,
    random: &mut Random,
) -> Result<u64, Fault> {
    place.write("study.toml", STUDY)?;
    place.write("tests.csv", super::files::TESTS)?;
    place.write("run.csv", super::files::run_as_table())?;
    let mut command = programs.onset();
    command.args(random.of(COMMANDS).split(' '));
    for _ in 0..random.below(8) {
        let pool = if random.below(2) == 0 { OPTIONS } else { WORDS };
        command.arg(random.of(pool));
    }
    place.run_for(random.pause(1500), command)?;
    Ok(1)
}

const TOKENS: &[&str] = &[
    "I1", "I2", "J", "F11", "lambda1", "mu", "kappa", "1", "2.5", "1e308", "1e-320", "+", "-", "*",
    "/", "^", "(", ")", ",", "ln(", "exp(", "sqrt(", "max(", "if(", "<", "let a = ", ";", "tr(",
    "det(", "\u{3bb}", " ", "0/0", "..", "pow(", "((((((((", "1^1^1^1^",
];

/// Checks that an energy of random tokens is evaluated or refused.
pub(super) fn formula(
    programs: &Programs,
    place: &Place,
    random: &mut Random,
) -> Result<u64, Fault> {
    let mut energy = String::new();
    let length = [4, 12, 40, 4000][random.below(4)];
    for _ in 0..random.below(length) {
        energy.push_str(random.of(TOKENS));
    }
    let mut command = programs.onset();
    command.args([
        "state",
        "--stretch",
        random.of(&["1.2,0.9", "1,1", "0.01,50"]),
    ]);
    command.args(["--set", "material.mu=1", "--set", "material.kappa=3"]);
    command.args(["--energy", &energy]);
    place.run(command)?;
    Ok(1)
}

/// Checks commands at terminals that are narrow, dumb or gone.
pub(super) fn terminal(
    programs: &Programs,
    place: &Place,
    random: &mut Random,
) -> Result<u64, Fault> {
    let line = random.of(&[
        "state --stretch 1.1,0.9",
        "list materials",
        "--help",
        "map --help",
        "compare --help",
        "modes --set discretization.quadrature=nodal",
        "state --stretch nothing",
        "limit --time-step 1e-3 --vary material.young --set material.young=1 --set material.poisson=0.3",
    ]);
    let program = programs.onset.display();
    let shell = match random.below(8) {
        0 => format!("exec '{program}' {line} >&-"),
        1 => format!("exec '{program}' {line} 2>&- <&-"),
        2 => format!("exec '{program}' {line} >&- 2>&- <&-"),
        3 => format!("exec '{program}' {line} >/dev/full"),
        4 => format!("exec '{program}' {line} 2>/dev/full >/dev/full"),
        5 => format!("'{program}' {line} | true"),
        _ => {
            let width = [1, 2, 7, 20, 1000, 0][random.below(6)];
            let inner = format!(
                "stty cols {width} rows {}; exec '{program}' {line}",
                random.below(3)
            );
            format!("exec script --quiet --return --command \"{inner}\" /dev/null")
        }
    };
    let mut command = Command::new("sh");
    command.args(["-c", &shell]);
    for name in ["NO_COLOR", "COLUMNS", "LANG", "TERM", "HOME"] {
        if random.below(3) == 0 {
            command.env(name, random.of(&["", "1", "dumb", "C", "\u{1b}", "-5"]));
        }
    }
    place.run(command)?;
    Ok(1)
}
