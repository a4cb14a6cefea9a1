//! Every command with every method of `comparisons/methods-*.toml` and `comparisons/recent-2d.toml`.

use super::{Scratch, document, number, onset, onset_line};
use serde_json::Value;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Comparisons in one, two and three dimensions.
const METHODS_1D: &str = include_str!("../../../../comparisons/methods-1d.toml");
const METHODS_2D: &str = include_str!("../../../../comparisons/methods-2d.toml");
const METHODS_3D: &str = include_str!("../../../../comparisons/methods-3d.toml");
const RECENT_2D: &str = include_str!("../../../../comparisons/recent-2d.toml");

/// Tested command lines. `STUDY`, `STORE` and `OUT` are replaced by files; `F`, `FROM`, `TO` and `K` by stretches and a wave vector with the
/// dimension of the method.
const COMMANDS: [&str; 8] = [
    "state STUDY --stretch F --certify --json",
    "dispersion STUDY --stretch F --wave-vector K --json",
    "path STUDY --from FROM --to TO --json",
    "modes STUDY --cells 3 --out OUT --json",
    "map STUDY --out STORE --json",
    "plot STORE --out OUT/traced.svg",
    "plot STORE --no-trace --out OUT/cells.svg",
    "boundary STUDY --out OUT --json",
];

/// Method, with its comparison.
struct Method {
    name: String,
    dimension: usize,
    /// Keys of `[discretization]`.
    keys: Vec<(String, String)>,
}

/// Methods of a comparison, each with the common keys.
fn methods(dimension: usize, text: &str) -> Vec<Method> {
    let (mut section, mut common, mut methods) = (String::new(), Vec::new(), Vec::<Method>::new());
    for line in text.lines().map(str::trim) {
        if line.starts_with('[') {
            section = line.trim_matches(['[', ']']).to_owned();
            if section == "methods" {
                methods.push(Method {
                    name: String::new(),
                    dimension,
                    keys: Vec::clone(&common),
                });
            }
            continue;
        }
        let Some((key, value)) = line.split_once(" = ").filter(|_| !line.starts_with('#')) else {
            continue;
        };
        let entry = (key.to_owned(), value.to_owned());
        match (section.as_str(), methods.last_mut()) {
            ("discretization", _) => common.push(entry),
            ("methods", Some(method)) if key == "name" => method.name = value.to_owned(),
            ("methods", Some(method)) => {
                method.keys.retain(|(own, _)| own != key);
                method.keys.push(entry);
            }
            _ => {}
        }
    }
    methods
}

impl Method {
    /// Value of a key.
    fn value(&self, key: &str) -> &str {
        let mut own = self.keys.iter().filter(|(name, _)| name == key);
        own.next().map_or("", |(_, value)| value.trim_matches('"'))
    }

    /// Returns true if the method reads a common key of its comparison.
    fn reads(&self, key: &str) -> bool {
        match self.value("method") {
            "finite-elements" => !matches!(key, "lattice" | "support"),
            "peridynamics" | "material-points" => key != "support",
            _ => true,
        }
    }

    /// Study with few states.
    fn study(&self) -> String {
        let keys = self.keys.iter().filter(|(key, _)| self.reads(key));
        let lines = keys.map(|(key, value)| format!("{key} = {value}\n"));
        let axis = |quantity: &str| {
            format!("[[axes]]\nquantity = \"{quantity}\"\nrange = [0.97, 1.03]\nstates = 2\n")
        };
        // A chain has one stretch.
        let second = match self.dimension {
            1 => "discretization.density",
            _ => "stretch-2",
        };
        format!(
            "[discretization]\n{}{}{}[map]\ncertify = true\n",
            lines.collect::<String>(),
            axis("stretch-1"),
            axis(second)
        )
    }

    /// Returns true if the command is tested with this method.
    ///
    /// Tracing requires the same work for a figure and for a table, so it is tested for few methods. In 3D, commands with many states or waves take a
    /// minute for most methods; they are tested with elements only.
    fn is_asked(&self, line: &str) -> bool {
        let long = ["path", "boundary", "modes"];
        let is_long = line.contains("traced") || long.iter().any(|word| line.starts_with(word));
        let is_element = self.value("method") == "finite-elements";
        match self.dimension {
            3 => !is_long || is_element,
            2 => !line.contains("traced") || is_element,
            _ => true,
        }
    }

    /// Runs all command lines and returns the failures.
    fn asked(&self) -> Vec<String> {
        let folder = Scratch::new("methods");
        std::fs::create_dir_all(&folder).expect("a folder");
        let study = folder.join("study.toml");
        std::fs::write(&study, self.study()).expect("a file");
        let numbers = |all: [&str; 3]| all[..self.dimension].join(",");
        let words = [
            ("STUDY", study.display().to_string()),
            ("STORE", folder.join("map.zarr").display().to_string()),
            ("OUT", folder.display().to_string()),
            ("F", numbers(["1.02", "0.99", "1.01"])),
            ("FROM", numbers(["1.0", "1.0", "1.0"])),
            ("TO", numbers(["1.1", "1.0", "1.0"])),
            ("K", numbers(["0.7", "0.4", "0.2"])),
        ];
        let mut unanswered = Vec::new();
        for line in COMMANDS.into_iter().filter(|line| self.is_asked(line)) {
            let word = |word: &str| {
                let stands_for = |(name, text): &(&str, String)| match word.strip_prefix(name) {
                    Some("") => Some(text.clone()),
                    Some(rest) if rest.starts_with('/') => Some(format!("{text}{rest}")),
                    _ => None,
                };
                words.iter().find_map(stands_for).unwrap_or(word.to_owned())
            };
            let arguments: Vec<String> = line.split(' ').map(word).collect();
            let mut arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
            let is_of_one_state = ["state", "dispersion", "path", "modes"].contains(&arguments[0]);
            if self.dimension == 1 && is_of_one_state {
                // The second axis of the study varies the density, which these commands need as a value.
                arguments.extend(["--set", "discretization.density=1"]);
            }
            let answer = onset(&arguments);
            let complaint = match answer.code {
                Some(0) if line.contains("--json") => wrong(line, &answer.stdout, self.dimension),
                Some(0) => None,
                _ => Some(answer.stderr),
            };
            if let Some(complaint) = complaint {
                unanswered.push(format!(
                    "{}D {}: {line}: {complaint}",
                    self.dimension, self.name
                ));
            }
        }
        // A folder that cannot be removed does not affect the test.
        let _ = std::fs::remove_dir_all(&folder);
        unanswered
    }
}

/// Reason why an answer is wrong, or `None`.
fn wrong(line: &str, text: &str, dimension: usize) -> Option<String> {
    let Ok(answer) = serde_json::from_str::<Value>(text) else {
        return Some(format!("no document: {text}"));
    };
    let length = |pointer: &str| {
        answer
            .pointer(pointer)
            .and_then(Value::as_array)
            .map(Vec::len)
    };
    let is_right = match line.split(' ').next() {
        Some("state") => {
            let step = answer.pointer("/discretization/critical_time_step");
            let proof = answer.pointer("/certificate/material/certainty");
            let waves = answer.pointer("/certificate/discretization/certainty");
            let is_proved =
                proof.and_then(Value::as_str) == Some("proved-stable") && waves.is_some();
            length("/discretization/wave_vector") == Some(dimension)
                && step.is_some_and(|step| step.as_f64().is_some_and(|step| step > 0.0))
                && (!line.contains("--certify") || is_proved)
        }
        Some("dispersion") => length("/omega_squared").is_some_and(|count| count >= dimension),
        Some("path") => answer["discretization_crossings"].is_array(),
        Some("modes") => answer["modes"].is_array(),
        Some("boundary") => answer["curves"].is_array() && answer["fidelity"].is_object(),
        _ => true,
    };
    (!is_right).then(|| text.to_owned())
}

/// Tests every command for every method of a comparison.
fn assert_answered(all: &[Method], count: usize) {
    assert_eq!(all.len(), count);
    let (next, unanswered) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some(method) = all.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let found = method.asked();
                    unanswered.lock().expect("a list").extend(found);
                }
            });
        }
    });
    let unanswered = unanswered.into_inner().expect("a list");
    assert!(unanswered.is_empty(), "{}", unanswered.join("\n"));
}

#[test]
fn every_command_supports_every_method_in_1d() {
    assert_answered(&methods(1, METHODS_1D), 18);
}

#[test]
fn every_command_supports_every_method_in_2d() {
    assert_answered(&methods(2, METHODS_2D), 20);
}

#[test]
fn every_command_supports_every_recent_method() {
    let known = methods(2, METHODS_2D);
    let mut recent = methods(2, RECENT_2D);
    recent.retain(|own| known.iter().all(|other| other.name != own.name));
    assert_answered(&recent, 9);
}

#[test]
fn every_command_supports_every_method_in_3d() {
    assert_answered(&methods(3, METHODS_3D), 12);
}

#[test]
fn waves_in_continuous_time_note_that_the_transfer_is_omitted() {
    let points = "set method=material-points set lattice=chain set unknowns=particles";
    for line in [
        "dispersion --stretch 1.05 --wave-vector 1",
        "dispersion --stretch 1.05 --path",
        "path --from 1 --to 1.1",
        "modes",
    ] {
        let told = |transfer: &str| {
            let answer = onset_line(&format!("{line} {points} {transfer}"));
            assert_eq!(answer.code, Some(0), "{}", answer.stderr);
            answer.stdout.contains("onset state gives the damping")
        };
        assert!(told("set transfer=apic") && !told(""), "{line}");
    }
}

#[test]
fn elements_take_a_sheared_and_a_distorted_mesh() {
    let state = |more: &str| {
        document(&format!(
            "state --stretch 1.05,0.98 set method=finite-elements {more}"
        ))
    };
    let step = |own: &Value| number(own, "/discretization/critical_time_step");
    let plain = step(&state(""));
    // A mesh that is stretched by 2 along both axes has twice the step.
    let twice = step(&state("set vectors=2,0,0,2"));
    assert!((twice / plain - 2.0).abs() < 1e-9, "{twice} {plain}");
    let sheared = state("set vectors=1,0,0.4,1");
    assert!(sheared["discretization"]["stable"].as_bool() == Some(true));
    let distorted = state("set cells=2 set perturbation=0.1");
    assert!(step(&distorted) < plain);
    // A cell of several undisplaced nodes is the cell of the mesh.
    assert_eq!(step(&state("set cells=2")), plain);
    for (more, fact) in [
        ("set vectors=1,0,0", "vectors"),
        ("set perturbation=0.1", "discretization.cells"),
    ] {
        let answer = onset_line(&format!(
            "state --stretch 1,1 set method=finite-elements {more}"
        ));
        assert_eq!(answer.code, Some(2), "{more}: {}", answer.stdout);
        assert!(answer.stderr.contains(fact), "{more}: {}", answer.stderr);
    }
}

#[test]
fn points_at_knots_and_transfers_with_other_frequencies_are_noted() {
    let notes = |more: &str| {
        let answer = document(&format!(
            "state --stretch 1.02,0.99 set method=material-points set lattice=square {more}"
        ));
        answer["notes"].to_string()
    };
    let gimp = "set grid-functions=gimp";
    assert!(notes(gimp).contains("discretization.offset = 0.05"));
    assert!(!notes(&format!("{gimp} set offset=0.05")).contains("knots"));
    assert!(!notes("set grid-functions=quadratic-spline").contains("knots"));
    let one = "set grid-functions=quadratic-spline set points-per-side=1";
    assert!(notes(one).contains("knots"));
    let fmpm = "set grid-functions=quadratic-spline set unknowns=particles set transfer=fmpm";
    assert!(notes(fmpm).contains("frequencies belong to lumped masses"));
}

#[test]
fn upwinding_damps_waves_and_changes_no_verdict() {
    let state = |more: &str| {
        document(&format!(
            "state --stretch 1.05,0.98 set method=total-lagrangian-sph set penalty=0.3 set lattice=square {more}"
        ))
    };
    let (plain, damped) = (state(""), state("set upwinding=constant"));
    for part in [
        "/discretization/minimum_scaled",
        "/discretization/maximum_omega",
    ] {
        assert_eq!(number(&plain, part), number(&damped, part));
    }
    let steps = &damped["discretization"]["damped_time_steps"];
    let central = number(steps, "/central-differences");
    assert!(central < number(&plain, "/discretization/critical_time_step"));
    let linear = state("set upwinding=linear");
    let linear = number(
        &linear,
        "/discretization/damped_time_steps/central-differences",
    );
    assert!(linear > 0.0);
    let rates = document(
        "dispersion --stretch 1.05,0.98 --wave-vector 2,1 set method=total-lagrangian-sph set upwinding=constant set lattice=square",
    );
    let rates = rates["rates"].as_array().expect("rates");
    assert_eq!(rates.len(), 4);
    assert!(rates.iter().all(|rate| number(rate, "/re") < 0.0));
}
