//! What a user can find out without a manual.

use crate::onset;

#[test]
fn every_command_explains_itself() {
    for command in [
        "state",
        "dispersion",
        "path",
        "localize",
        "map",
        "list",
        "check",
        "boundary",
        "plot",
        "notions",
        "card",
        "audit",
        "umat-utilities",
        "schema",
        "reproduce",
    ] {
        let help = onset(&[command, "--help"]);
        assert_eq!(help.code, Some(0));
        assert!(help.stdout.contains(&format!("Usage: onset {command}")));
        assert!(onset(&["--help"]).stdout.contains(command));
        let version = onset(&[command, "--version"]);
        assert!(version.stdout.contains(env!("CARGO_PKG_VERSION")));
    }
}

#[test]
fn the_keys_are_known_from_the_help() {
    let keys = [
        "material.model",
        "material.<parameter>",
        "onset list materials",
        "material.energy",
        "material.library",
        "discretization.arrangement",
        "discretization.spacing",
        "discretization.density",
        "discretization.kernel",
        "discretization.support",
        "discretization.approximation",
        "discretization.quadrature",
        "discretization.frame",
        "discretization.background",
        "discretization.lattice",
        "discretization.support-size",
        "discretization.linearization",
    ];
    for command in ["state", "dispersion", "path"] {
        let help = onset(&[command, "--help"]).stdout;
        for key in keys {
            assert!(
                help.contains(key),
                "`onset {command} --help` does not name {key}"
            );
        }
    }
}

#[test]
fn list_names_every_law_with_formula_parameters_and_source() {
    let run = onset(&["list", "materials"]);
    assert_eq!(run.code, Some(0));
    for fact in [
        "blatz-ko",
        "W = mu/2",
        "mu = 32 (stress): shear modulus; a positive finite number",
        "Trans. Soc. Rheol.",
        "c1 = 0.1256",
    ] {
        assert!(run.stdout.contains(fact), "{fact}: {}", run.stdout);
    }
    let everything = onset(&["list", "--json"]);
    let topics: serde_json::Value = serde_json::from_str(&everything.stdout).expect("JSON");
    assert!(topics.as_array().is_some_and(|topics| topics.len() > 5));
    let wrong = onset(&["list", "material"]);
    assert_eq!(wrong.code, Some(2));
    assert!(
        wrong.stderr.contains("topics are materials"),
        "{}",
        wrong.stderr
    );
}
