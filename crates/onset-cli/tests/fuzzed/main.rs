//! Random, mostly invalid command lines: each ends within limits of time and memory, with a documented exit code, and its JSON output is valid.

#![cfg(unix)]

#[path = "../../../onset/tests/shared/hunt.rs"]
mod hunt;
mod lines;
mod process;

use hunt::hunted;
use lines::Source;
use process::{Line, Place};
use serde_json::Value;
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

/// Statistics of command lines.
#[derive(Default)]
struct Tally {
    answered: usize,
    refused: usize,
    failed: usize,
    /// Slowest command line.
    slowest: (Duration, String),
    faults: Vec<String>,
}

impl Tally {
    fn add(&mut self, line: &Line, ending: &process::Ending) {
        match ending.status.code() {
            Some(0) => self.answered += 1,
            Some(2) => self.refused += 1,
            _ => self.failed += 1,
        }
        if ending.elapsed > self.slowest.0 {
            self.slowest = (ending.elapsed, line.to_string());
        }
        self.faults.extend(ending.fault(line));
    }

    fn and(mut self, other: Self) -> Self {
        self.answered += other.answered;
        self.refused += other.refused;
        self.failed += other.failed;
        self.slowest = self.slowest.max(other.slowest);
        self.faults.extend(other.faults);
        self
    }
}

#[test]
fn every_command_line_ends_in_time_within_its_memory_and_with_a_documented_code() {
    let (seed, cases) = hunted(1_200);
    let next = AtomicUsize::new(0);
    let schema: Value = {
        let ending = Place::new("schema").run(&Line::of("schema"));
        serde_json::from_slice(&ending.stdout).expect("a schema")
    };
    let worker = |name: &str| {
        let place = Place::new(name).with_stores();
        let mut source = Source::new(&schema);
        let mut tally = Tally::default();
        loop {
            let case = next.fetch_add(1, Ordering::Relaxed);
            if case >= cases {
                return tally;
            }
            let line = source.line(seed, case as u64);
            let ending = place.run(&line);
            if let Some(fault) = ending.fault(&line) {
                // A long test reports failures immediately.
                eprintln!("case {case} of seed {seed}: {fault}");
            }
            tally.add(&line, &ending);
        }
    };
    let tally = std::thread::scope(|scope| {
        let running = ["one", "two"].map(|name| scope.spawn(move || worker(name)));
        running
            .into_iter()
            .map(|worker| worker.join().expect("a worker"))
            .fold(Tally::default(), Tally::and)
    });
    eprintln!(
        "{cases} command lines: {} answered, {} refused, {} failed; the slowest, {:.1} s: {}",
        tally.answered,
        tally.refused,
        tally.failed,
        tally.slowest.0.as_secs_f64(),
        tally.slowest.1
    );
    assert!(
        tally.faults.is_empty(),
        "{} of {cases} with seed {seed}:\n{}",
        tally.faults.len(),
        tally.faults.join("\n")
    );
    // Lines that are all refused would test little.
    let few = cases / 6;
    assert!(tally.answered >= few && tally.refused >= few);
}

#[test]
fn a_large_shear_of_kernels_in_current_coordinates_is_answered_within_the_limits() {
    let place = Place::new("shear");
    for shear in ["1000", "-5000", "1000.5"] {
        let answer = place.answered(&format!(
            "state --json --deformation-gradient=1,{shear},0,1 --set discretization.frame=eulerian"
        ));
        assert!(answer["verdict"].is_string());
    }
}

#[test]
fn endless_work_is_refused_or_cancelled() {
    let place = Place::new("endless");
    let oblique = "--set discretization.lattice=oblique --set discretization.vectors=";
    for line in [
        format!("state --stretch 1.1,1 {oblique}6986.29,1e5,3,1e100"),
        format!(
            "state --stretch 27.9,0.0038 {oblique}1e5,-2,2,1.5 --set material.model=saint-venant-kirchhoff --set discretization.method=conforming"
        ),
        format!(
            "state --deformation-gradient=1,1e9,0,1 {oblique}1,0,0,1 --set discretization.frame=eulerian"
        ),
        "modes --set discretization.lattice=simple-cubic --set discretization.cells=16".to_owned(),
    ] {
        let line = Line::of(&line);
        let ending = place.run(&line);
        assert_eq!(ending.status.code(), Some(2), "{line}");
        assert_eq!(ending.fault(&line), None);
    }
    let steep = "criteria --json --mode simple-shear --set material.model=ogden --set material.alpha2=3579.3 --set material.kappa=1e-3";
    let answer = place.answered(steep);
    for loading in answer["loadings"].as_array().expect("loadings") {
        for end in ["compression_end", "tension_end"] {
            let reason = loading[end]["reason"].to_string();
            assert!(reason.contains("the law ends there"), "{reason}");
        }
    }
}

#[test]
fn the_basis_and_the_units_of_a_problem_change_no_verdict() {
    let place = Place::new("units");
    let number =
        |answer: &Value, name: &str| answer["discretization"][name].as_f64().expect("a number");
    let oblique = |vectors: &str| {
        place.answered(&format!(
            "state --json --stretch 1.05,0.98 --set discretization.lattice=oblique --set discretization.support=1.7 \
             --set discretization.vectors={vectors}"
        ))
    };
    let short = oblique("1,0,0,1");
    for vectors in ["1,0,300,1", "7,1,-8,-1", "0,1,1,0"] {
        let other = oblique(vectors);
        assert_eq!(other["verdict"], short["verdict"], "{vectors}");
        for name in ["minimum_scaled", "maximum_omega"] {
            let [a, b] = [&other, &short].map(|answer| number(answer, name));
            assert!(
                (a - b).abs() < 1e-9 * (1.0 + b.abs()),
                "{vectors} {name}: {a} {b}"
            );
        }
    }
    let law = "--set material.model=blatz-ko --set material.mu=";
    for (kind, stretch) in [("hexagonal", "1.15,1"), ("simple-cubic", "1.1,1,0.95")] {
        let line = |mu: &str, density: &str| {
            place.answered(&format!(
                "state --json --stretch {stretch} --set discretization.frame=eulerian --set discretization.lattice={kind} \
                 --set discretization.density={density} {law}{mu}"
            ))
        };
        let plain = line("1", "1");
        for (mu, density) in [
            ("1", "1e-20"),
            ("1e20", "1"),
            ("1e-20", "1"),
            ("1e20", "1e-20"),
            ("1e-20", "1e20"),
        ] {
            let other = line(mu, density);
            assert_eq!(other["verdict"], plain["verdict"], "{mu} {density}");
            let [a, b] = [&other, &plain].map(|answer| number(answer, "minimum_scaled"));
            assert!(
                (a - b).abs() < 1e-9 * b.abs(),
                "{kind} {mu} {density}: {a} {b}"
            );
            let unit = (mu.parse::<f64>().expect("a number")
                / density.parse::<f64>().expect("a number"))
            .sqrt();
            for name in ["maximum_omega", "growth_rate"] {
                let [a, b] = [number(&other, name), number(&plain, name) * unit];
                assert!(
                    (a - b).abs() <= 1e-9 * b.abs(),
                    "{kind} {mu} {density} {name}: {a} {b}"
                );
            }
        }
    }
}

/// Methods other than the kernel methods.
const OTHERS: [&str; 9] = [
    "method=total-lagrangian-sph lattice=square penalty=0.1",
    "method=updated-sph artificial-stress=0.3 velocity-smoothing=0.5",
    "method=updated-sph corrected=false viscosity=0.1",
    "method=finite-elements integration=one-point hourglass-stiffness=0.05",
    "method=conforming lattice=square",
    "method=peridynamics lattice=square horizon=2.2",
    "method=peridynamics lattice=square bonds=correspondence control=penalty control-coefficient=0.5",
    "method=material-points",
    "method=material-points unknowns=updated grid-functions=quadratic-spline",
];

#[test]
fn answers_of_every_method_do_not_depend_on_units_within_their_bounds() {
    let place = Place::new("methods");
    let number =
        |answer: &Value, name: &str| answer["discretization"][name].as_f64().expect("a number");
    for method in OTHERS {
        let set: Vec<String> = method
            .split(' ')
            .map(|choice| format!("--set discretization.{choice}"))
            .collect();
        let line = |mu: &str, density: &str, spacing: &str| {
            format!(
                "state --json --stretch 1.15,0.9 --set material.model=blatz-ko --set material.mu={mu} \
                 --set discretization.density={density} --set discretization.spacing={spacing} {}",
                set.join(" ")
            )
        };
        let plain = place.answered(&line("1", "1", "1"));
        for (mu, density, spacing) in [
            ("1e20", "1", "1"),
            ("1e-20", "1", "1"),
            ("1", "1e20", "1e20"),
            ("1e20", "1e-20", "1e-20"),
            ("1e-20", "1e20", "1e-20"),
        ] {
            let what = format!("{method}: {mu} {density} {spacing}");
            let other = place.answered(&line(mu, density, spacing));
            assert_eq!(other["verdict"], plain["verdict"], "{what}");
            let [a, b] = [&other, &plain].map(|answer| number(answer, "minimum_scaled"));
            // Zeros agree to the rounding of the largest number.
            assert!((a - b).abs() < 1e-9 * b.abs() + 1e-13, "{what}: {a} {b}");
            let [mu, density, spacing] =
                [mu, density, spacing].map(|text| text.parse::<f64>().expect("a number"));
            let unit = mu.sqrt() / density.sqrt() / spacing;
            for name in ["maximum_omega", "growth_rate"] {
                let [a, b] = [number(&other, name), number(&plain, name) * unit];
                assert!((a - b).abs() <= 1e-9 * b.abs(), "{what} {name}: {a} {b}");
            }
        }
        for (mu, density, spacing) in [
            ("1", "1", "1e21"),
            ("1", "1", "1e-30"),
            ("1", "1e-40", "1"),
            ("1e300", "1", "1"),
        ] {
            let line = Line::of(&line(mu, density, spacing));
            let ending = place.run(&line);
            assert_eq!(ending.status.code(), Some(2), "{line}: {}", ending.stderr);
            assert!(ending.stderr.contains("to 1e20"), "{}", ending.stderr);
        }
    }
}

#[test]
fn an_excessive_number_of_threads_is_refused() {
    for (threads, code) in [("1", 0), ("100000", 2), ("many", 2)] {
        let output = Command::new(env!("CARGO_BIN_EXE_onset"))
            .args(["list", "kernels"])
            .env("RAYON_NUM_THREADS", threads)
            .output()
            .expect("the command starts");
        assert_eq!(output.status.code(), Some(code), "{threads}");
    }
}
