//! Information available without a manual.

use crate::onset;

#[test]
fn every_command_has_a_help_text() {
    for command in [
        "state",
        #[cfg(feature = "explore")]
        "explore",
        "dispersion",
        "path",
        "localize",
        "map",
        "list",
        "check",
        "boundary",
        "plot",
        "criteria",
        "card",
        "audit",
        "umat-utilities",
        "law-header",
        "verify",
        "simulate",
        "screen",
        "schema",
        "completions",
        "man",
        "zoo",
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
fn the_help_leads_to_the_list_of_keys() {
    let keys = [
        "material.model",
        "material.<parameter>",
        "onset list materials",
        "material.energy",
        "material.library",
        "discretization.lattice",
        "discretization.spacing",
        "discretization.density",
        "discretization.kernel",
        "discretization.support",
        "discretization.approximation",
        "discretization.quadrature",
        "discretization.frame",
        "discretization.background",
        "discretization.current-lattice",
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
fn help_on_commands_about_a_law_names_no_key_of_a_discretization() {
    for command in ["criteria", "card", "audit"] {
        let help = onset(&[command, "--help"]).stdout;
        assert!(
            help.contains("material.model") && !help.contains("discretization."),
            "{help}"
        );
    }
}

#[test]
fn short_help_is_short_and_has_examples_that_run() {
    let overview = onset(&["-h"]).stdout;
    assert!(overview.lines().count() <= 38, "{overview}");
    for command in [
        "state",
        #[cfg(feature = "explore")]
        "explore",
        "dispersion",
        "path",
        "criteria",
        "card",
        "modes",
        "audit",
        "localize",
        "recommend",
        "compare",
        "tune",
        "limit",
        "simulate",
        "screen",
        "check",
        "map",
        "plot",
        "boundary",
    ] {
        let help = onset(&[command, "-h"]).stdout;
        assert!(!help.contains("Keys of --set"), "{help}");
        assert_eq!(help.matches("\n  onset ").count(), 3, "{help}");
    }
    // Examples of the overview, without shell quotes.
    for line in overview
        .lines()
        .filter_map(|line| line.strip_prefix("  onset "))
    {
        let words: Vec<&str> = line.split(' ').collect();
        if words[0] == "recommend" {
            continue;
        }
        assert_eq!(onset(&words).code, Some(0), "{line}");
    }
}

#[test]
fn a_method_lists_the_keys_that_it_reads() {
    let run = onset(&["list", "method", "tlsph"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(
        run.stdout.contains("discretization.penalty")
            && run.stdout.contains("discretization.support")
    );
    for other in [
        "discretization.quadrature",
        "discretization.mesh",
        "discretization.horizon",
        "discretization.momentum",
    ] {
        assert!(!run.stdout.contains(other), "{other}: {}", run.stdout);
    }
    let elements = onset(&["list", "method", "finite-elements"]).stdout;
    assert!(
        elements.contains("discretization.hourglass-stiffness"),
        "{elements}"
    );
    assert!(
        elements.contains("with discretization.integration = one-point"),
        "{elements}"
    );
    for (name, fact) in [
        ("sph", "`updated-sph`"),
        ("tlpsh", "did you mean `total-lagrangian-sph`?"),
    ] {
        let refused = onset(&["list", "method", name]);
        assert_eq!(refused.code, Some(2));
        assert!(refused.stderr.contains(fact), "{}", refused.stderr);
    }
    assert_eq!(onset(&["list", "kernels", "x"]).code, Some(2));
    assert!(
        onset(&["list", "aliases"])
            .stdout
            .contains("total-lagrangian-sph")
    );
    assert!(onset(&["list", "keys"]).stdout.contains("map.adaptive"));
}

#[test]
fn list_names_every_law_with_formula_parameters_and_source() {
    let run = onset(&["list", "materials"]);
    assert_eq!(run.code, Some(0));
    for fact in [
        "blatz-ko",
        "W = mu/2",
        "mu = 32 (stress): shear modulus; a positive number from 1e-20 to 1e20",
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
