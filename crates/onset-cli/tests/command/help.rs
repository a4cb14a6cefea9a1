//! What a user can find out without a manual.

use crate::onset;

#[test]
fn every_command_explains_itself() {
    for command in ["state", "dispersion", "path", "reproduce"] {
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
        "material.c1",
        "material.c2",
        "material.lambda",
        "material.mu",
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
