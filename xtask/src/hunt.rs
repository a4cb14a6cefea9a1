//! Randomized tests of any length; this task sets their seed and their number of cases.

use std::process::Command;
use std::time::{Duration, Instant};

/// Randomized test that reads `ONSET_SEED` and `ONSET_CASES`.
struct Subject {
    name: &'static str,
    /// Tested property, as a sentence.
    claim: &'static str,
    package: &'static str,
    /// Test program, and name of the test.
    program: &'static str,
    test: &'static str,
    /// Default number of cases in a round.
    cases: u64,
}

const SUBJECTS: &[Subject] = &[
    Subject {
        name: "spectra",
        claim: "no state of any method grows faster or is softer than the search over the zone says",
        package: "onset",
        program: "hunt",
        test: "no_random_state_of_any_method",
        cases: 200,
    },
    Subject {
        name: "descriptions",
        claim: "every description of a crystal has the same answer",
        package: "onset",
        program: "hunt",
        test: "every_description_of_a_crystal",
        cases: 400,
    },
    Subject {
        name: "formulas",
        claim: "formulas neither panic nor take long nor fill the memory",
        package: "onset",
        program: "formula",
        test: "random_formulas",
        cases: 60_000,
    },
    Subject {
        name: "formulas-agree",
        claim: "numbers, jets, intervals and orders of arguments agree where a formula is defined; no proof is contradicted",
        package: "onset",
        program: "formula",
        test: "equivalent_formulas_have_equal_domains_and_proofs_are_never_contradicted",
        cases: 100_000,
    },
    Subject {
        name: "ellipticity-agrees",
        claim: "word and number of ellipticity agree with a computation in sixty digits",
        package: "onset",
        program: "formula",
        test: "the_verdict_on_ellipticity_agrees_with_sixty_digit_arithmetic",
        cases: 5_000,
    },
    Subject {
        name: "bases",
        claim: "a lattice has the same answers in every basis",
        package: "onset",
        program: "discretization",
        test: "a_lattice_has_the_same_answers",
        cases: 60,
    },
    Subject {
        name: "modes",
        claim: "every zero-energy mode of a random lattice that dense Newton searches find is listed, and nothing else",
        package: "onset",
        program: "measures",
        test: "exactly_the_zero_energy_modes_of_random_lattices_are_listed",
        cases: 120,
    },
    Subject {
        name: "weakest",
        claim: "a dense search of the zone finds no wave weaker than the reported weakest wave",
        package: "onset",
        program: "hunt",
        test: "no_wave_of_any_method_is_weaker",
        cases: 200,
    },
    Subject {
        name: "transfers",
        claim: "no wave of a random transfer of material points grows faster in discrete time, or needs a shorter step, than the search over the zone says",
        package: "onset",
        program: "hunt",
        test: "no_random_transfer",
        cases: 100,
    },
    Subject {
        name: "audits",
        claim: "an audit finds the fault of a routine that is right except at states of one kind",
        package: "onset-cli",
        program: "command",
        test: "planted_faults_are_detected_at_every_kind_of_state",
        cases: 300,
    },
    Subject {
        name: "command-lines",
        claim: "command lines end in time, within their memory, with a documented code",
        package: "onset-cli",
        program: "fuzzed",
        test: "every_command_line",
        cases: 2_000,
    },
    Subject {
        name: "kill-points",
        claim: "a command that is killed at any call that changes files leaves each file old or new",
        package: "onset-cli",
        program: "command",
        test: "commands_disturbed_at_any_point_leave_each_file_old_or_new",
        cases: 1_000_000,
    },
    Subject {
        name: "killed-runs",
        claim: "a simulation that is killed at any time is resumed to the same bytes",
        package: "onset-cli",
        program: "verify",
        test: "a_resumed_run_writes_the_same_bytes_after_a_kill",
        cases: 200,
    },
    Subject {
        name: "damaged-stores",
        claim: "a damaged store is refused, or returns the stored values",
        package: "onset-cli",
        program: "command",
        test: "damaged_stores_are_refused_or_return_the_stored_values",
        cases: 1000,
    },
];

/// Runs one randomized test, or all of them, in rounds with successive seeds.
pub fn run(arguments: &[String]) -> Result<(), String> {
    let hunt = Hunt::new(arguments)?;
    let start = Instant::now();
    for round in 0.. {
        for subject in &hunt.subjects {
            hunt.round(subject, hunt.seed.wrapping_add(round))?;
        }
        if start.elapsed() >= hunt.time {
            break;
        }
    }
    Ok(())
}

struct Hunt {
    subjects: Vec<&'static Subject>,
    seed: u64,
    cases: Option<u64>,
    /// Time after which no further round starts.
    time: Duration,
    /// Whether to compile with full optimization, which saves time after a few minutes.
    release: bool,
}

impl Hunt {
    fn new(arguments: &[String]) -> Result<Self, String> {
        let mut hunt = Self {
            subjects: Vec::new(),
            seed: 1,
            cases: None,
            time: Duration::ZERO,
            release: false,
        };
        let mut rest = arguments.iter();
        while let Some(argument) = rest.next() {
            let mut number = || {
                let value = rest.next().and_then(|value| value.parse::<u64>().ok());
                value.ok_or_else(|| format!("{argument} needs a whole number"))
            };
            match argument.as_str() {
                "--seed" => hunt.seed = number()?,
                "--cases" => hunt.cases = Some(number()?),
                "--release" => hunt.release = true,
                "--minutes" => hunt.time = Duration::from_secs(60 * number()?),
                name => match SUBJECTS.iter().find(|subject| subject.name == name) {
                    Some(subject) => hunt.subjects.push(subject),
                    None => return Err(usage(name)),
                },
            }
        }
        if hunt.subjects.is_empty() {
            hunt.subjects.extend(SUBJECTS);
        }
        Ok(hunt)
    }

    fn round(&self, subject: &Subject, seed: u64) -> Result<(), String> {
        let cases = self.cases.unwrap_or(subject.cases);
        eprintln!(
            "== {}: {cases} cases, seed {seed}: {}",
            subject.name, subject.claim
        );
        let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
        let status = Command::new(cargo)
            .args([
                "test",
                "--quiet",
                "--all-features",
                "--package",
                subject.package,
            ])
            .args(self.release.then_some("--release"))
            .args(["--test", subject.program, subject.test])
            .args(["--", "--nocapture"])
            .env("ONSET_SEED", seed.to_string())
            .env("ONSET_CASES", cases.to_string())
            .status();
        if status.is_ok_and(|status| status.success()) {
            Ok(())
        } else {
            Err(format!(
                "{} failed; repeat with: cargo xtask hunt {} --seed {seed} --cases {cases}{}",
                subject.name,
                subject.name,
                if self.release { " --release" } else { "" }
            ))
        }
    }
}

fn usage(name: &str) -> String {
    let known = SUBJECTS
        .iter()
        .map(|subject| format!("\n  {:<12} {}", subject.name, subject.claim));
    format!(
        "unknown check `{name}`; known are{}",
        known.collect::<String>()
    )
}
