//! Command lines that nobody means well: each ends in time, within its memory, with a documented exit code, and what it calls
//! JSON is that.

#![cfg(unix)]

#[path = "../../../onset/tests/shared/hunt.rs"]
mod hunt;

use hunt::hunted;
use serde_json::Value;
use std::os::unix::process::ExitStatusExt;
use std::process::{Command, Output};

/// Seconds of processor time, and kibibytes of address space: a gibibyte, and what threads and the program itself reserve.
const SECONDS: u64 = 10;
const KIBIBYTES: u64 = 1_310_720;

/// Runs a command within the limits of the operating system.
fn limited(words: &[String]) -> Output {
    let script = format!("ulimit -t {SECONDS}; ulimit -v {KIBIBYTES}; exec \"$@\"");
    Command::new("sh")
        .args(["-c", &script, "sh", env!("CARGO_BIN_EXE_onset")])
        .args(words)
        .env("RAYON_NUM_THREADS", "1")
        .current_dir(env!("CARGO_TARGET_TMPDIR"))
        .output()
        .expect("the command starts")
}

/// A key with the words that it admits, if it admits words.
type Key = (String, Vec<String>);

/// The keys of material, discretization and method, from the schema that the program writes itself.
fn keys() -> Vec<Key> {
    let output = limited(&["schema".to_owned()]);
    let schema: Value = serde_json::from_slice(&output.stdout).expect("a schema");
    let mut keys = Vec::new();
    for section in ["material", "discretization"] {
        let properties = schema
            .pointer(&format!("/properties/{section}/properties"))
            .and_then(Value::as_object)
            .unwrap_or_else(|| panic!("no keys of {section}"));
        for (name, kind) in properties {
            let mut words = Vec::new();
            collect_words(kind, &mut words);
            keys.push((format!("{section}.{name}"), words));
        }
    }
    assert!(keys.len() > 40, "{keys:?}");
    // A library of one's own is another matter.
    keys.retain(|(name, _)| name != "material.library");
    keys
}

fn collect_words(kind: &Value, words: &mut Vec<String>) {
    match kind {
        Value::Object(entries) => {
            for (name, value) in entries {
                match (name.as_str(), value.as_array()) {
                    ("enum", Some(all)) => {
                        words.extend(all.iter().filter_map(Value::as_str).map(str::to_owned));
                    }
                    _ => collect_words(value, words),
                }
            }
        }
        Value::Array(all) => all.iter().for_each(|value| collect_words(value, words)),
        _ => {}
    }
}

const NUMBERS: &[&str] = &[
    "0",
    "-1",
    "1",
    "2",
    "3",
    "0.5",
    "1e-3",
    "1e-160",
    "1e160",
    "1e300",
    "-1e300",
    "5e-324",
    "1e999",
    "nan",
    "inf",
    "-inf",
    "",
    " ",
    "one",
    "0x10",
    "1_000",
    "1,2",
    "99999999999999999999",
    "0.1",
    "1.05",
    "1e5",
    "1e-9",
    "27.9",
    "0.0038",
    "-0.0",
];

const FORMULAS: &[&str] = &[
    "mu/2*(I1-3-2*ln(J))",
    "mu*J^2",
    "E33^E33",
    "0",
    "1/0",
    "sqrt(3-I1)",
    "1 - q",
    "exp(1e3*J)",
    "J",
    ")",
    "if(J<1, 0, mu*I1)",
    "let a = J; a*a",
];

const LAWS: &[&str] = &["mu", "kappa", "lambda", "alpha2", "k1", "k2", "j_m", "c1"];

/// Numbers spread evenly over `(-1, 1)`: SplitMix64.
struct Random(u64);

impl Random {
    fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// A source of choices.
struct Source {
    random: Random,
    keys: Vec<Key>,
}

impl Source {
    fn below(&mut self, bound: usize) -> usize {
        let unit = 0.5 * (self.random.number() + 1.0);
        ((unit * bound as f64) as usize).min(bound - 1)
    }

    fn chance(&mut self, percent: usize) -> bool {
        self.below(100) < percent
    }

    fn of<'a>(&mut self, words: &[&'a str]) -> &'a str {
        words[self.below(words.len())]
    }

    /// Usually one that makes sense.
    fn number(&mut self) -> String {
        match self.below(10) {
            0 => self.of(NUMBERS).to_owned(),
            1 => format!("{:e}", 10_f64.powf(30.0 * self.random.number())),
            2 => format!("{:?}", 8.0 * self.random.number()),
            _ => format!("{:?}", 1.0 + 0.4 * self.random.number()),
        }
    }

    fn numbers(&mut self, usual: usize) -> String {
        let count = if self.chance(92) {
            usual
        } else {
            self.below(10)
        };
        let all: Vec<String> = (0..count).map(|_| self.number()).collect();
        all.join(",")
    }

    fn assignment(&mut self) -> String {
        let n = self.below(self.keys.len());
        let (name, words) = self.keys[n].clone();
        if self.chance(3) {
            return self
                .of(&[
                    "",
                    "=",
                    "nothing=1",
                    "discretization.support",
                    "a.b.c=2",
                    "material.mu=1=2",
                    "\u{3bb}=1",
                ])
                .to_owned();
        }
        let value = match name.as_str() {
            // Large cells take their time, rightly.
            "discretization.cells" => self.of(&["1", "2", "0", "-1", "1e9", "17"]).to_owned(),
            "discretization.vectors" => {
                let count = [4, 9][self.below(2)];
                self.numbers(count)
            }
            "discretization.basis" | "discretization.points" => {
                let count = [2, 3, 6, 12][self.below(4)];
                self.numbers(count)
            }
            "material.energy" => self.of(FORMULAS).to_owned(),
            _ if !words.is_empty() && self.chance(92) => words[self.below(words.len())].clone(),
            _ => self.number(),
        };
        format!("{name}={value}")
    }

    fn problem(&mut self, words: &mut Vec<String>) {
        for _ in 0..self.below(6) {
            let assignment = self.assignment();
            words.extend(["--set".to_owned(), assignment]);
        }
        if self.chance(25) {
            let law = format!("material.{}={}", self.of(LAWS), self.number());
            words.extend(["--set".to_owned(), law]);
        }
        if self.chance(10) {
            words.extend(["--energy".to_owned(), self.of(FORMULAS).to_owned()]);
        }
        if self.chance(50) {
            words.push("--json".to_owned());
        }
    }

    fn strain(&mut self, words: &mut Vec<String>) {
        if self.chance(70) {
            let count = 2 + self.below(2);
            let stretches = self.numbers(count);
            words.push(format!("--stretch={stretches}"));
        } else {
            let count = [4, 9, 1][self.below(3)];
            let components = self.numbers(count);
            words.push(format!("--deformation-gradient={components}"));
        }
    }

    /// A command line.
    fn line(&mut self) -> Vec<String> {
        let command = self.of(&[
            "state",
            "state",
            "state",
            "state",
            "state",
            "dispersion",
            "path",
            "modes",
            "list",
            "check",
            "localize",
            "audit",
            "nonsense",
            "--version",
            "help",
        ]);
        let mut words = vec![command.to_owned()];
        match command {
            "state" => {
                self.problem(&mut words);
                self.strain(&mut words);
                if self.chance(10) {
                    words.push("--certify".to_owned());
                    if self.chance(50) {
                        words.push(format!("--tolerance={}", self.number()));
                    }
                }
            }
            "dispersion" => {
                self.problem(&mut words);
                self.strain(&mut words);
                let wave_vector = self.numbers(2);
                words.push(format!("--wave-vector={wave_vector}"));
            }
            "path" => {
                self.problem(&mut words);
                let (from, to) = (self.numbers(2), self.numbers(2));
                words.extend([format!("--from={from}"), format!("--to={to}")]);
            }
            "modes" => {
                self.problem(&mut words);
                if self.chance(50) {
                    words.push(format!(
                        "--cells={}",
                        self.of(&["1", "4", "0", "-3", "255", "256", "1e9", "x"])
                    ));
                }
                if self.chance(30) {
                    words.push(format!("--weak={}", self.number()));
                }
            }
            "localize" => {
                if self.chance(50) {
                    words.push(format!(
                        "--model={}",
                        self.of(&["drucker-prager", "mises", "", "x", "rudnicki-rice"])
                    ));
                }
                for name in ["hardening", "nu", "friction"] {
                    if self.chance(30) {
                        let assignment = format!("plasticity.{name}={}", self.number());
                        words.extend(["--set".to_owned(), assignment]);
                    }
                }
            }
            "list" => words.push(
                self.of(&["materials", "kernels", "formula", "", "x", "--json"])
                    .to_owned(),
            ),
            "check" => words.push(
                self.of(&["/dev/null", "", "no-such-file", "/", "--json"])
                    .to_owned(),
            ),
            "audit" => self.problem(&mut words),
            _ => {}
        }
        // Something left out, twice, or of another command.
        if self.chance(5) {
            let n = self.below(words.len());
            words.remove(n);
        }
        if self.chance(5) {
            let n = self.below(words.len().max(1)).min(words.len());
            words.insert(
                n,
                self.of(&[
                    "--json",
                    "--stretch",
                    "--out",
                    "-",
                    "--",
                    "--quiet",
                    "-9",
                    "\u{1b}[2J",
                    "--set",
                ])
                .to_owned(),
            );
        }
        words
    }
}

/// What is wrong with how a command ended.
fn fault(words: &[String], output: &Output) -> Option<String> {
    let stderr = String::from_utf8_lossy(&output.stderr);
    let told = |what: String| {
        let last: String = stderr.chars().take(600).collect();
        Some(format!("{what}: onset {}\n{last}", words.join(" ")))
    };
    if let Some(signal) = output.status.signal() {
        return told(format!("ended by signal {signal}"));
    }
    let code = output.status.code().unwrap_or(-1);
    if !(0..=2).contains(&code) || stderr.contains("panicked") {
        return told(format!("exit code {code}"));
    }
    if code == 2 && stderr.trim().is_empty() {
        return told("refused without a word".to_owned());
    }
    let help = ["help", "--version", "--help"]
        .iter()
        .any(|word| words.iter().any(|own| own == word));
    if code == 0
        && !help
        && words.iter().any(|word| word == "--json")
        && serde_json::from_slice::<Value>(&output.stdout).is_err()
    {
        return told("no JSON".to_owned());
    }
    None
}

#[test]
fn every_command_line_ends_in_time_within_its_memory_and_with_a_documented_code() {
    let (seed, cases) = hunted(2_000);
    let workers = 2;
    let known = keys();
    let faults: Vec<String> = std::thread::scope(|scope| {
        let worker = |number: usize| {
            let mut source = Source {
                random: Random(seed.wrapping_mul(1_000).wrapping_add(number as u64)),
                keys: known.clone(),
            };
            move || {
                let mut faults = Vec::new();
                for _ in (number..cases).step_by(workers) {
                    let words = source.line();
                    faults.extend(fault(&words, &limited(&words)));
                }
                faults
            }
        };
        let running: Vec<_> = (0..workers)
            .map(|number| scope.spawn(worker(number)))
            .collect();
        running
            .into_iter()
            .flat_map(|worker| worker.join().expect("a worker"))
            .collect()
    });
    assert!(
        faults.is_empty(),
        "{} of {cases} with seed {seed}:\n{}",
        faults.len(),
        faults.join("\n")
    );
}

fn answered(line: &str) -> Value {
    let words: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
    let output = limited(&words);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success(),
        "{line}: {:?} {stderr}",
        output.status
    );
    serde_json::from_slice(&output.stdout).expect("JSON")
}

#[test]
fn a_large_shear_of_kernels_of_current_coordinates_is_answered_within_the_limits() {
    for shear in ["1000", "-5000", "1000.5"] {
        let answer = answered(&format!(
            "state --json --deformation-gradient=1,{shear},0,1 --set discretization.frame=eulerian"
        ));
        assert!(answer["verdict"].is_string());
    }
}

#[test]
fn work_that_would_not_end_is_refused_or_given_up() {
    let oblique = "--set discretization.arrangement=oblique --set discretization.vectors=";
    for line in [
        format!("state --stretch 1.1,1 {oblique}6986.29,1e5,3,1e100"),
        format!(
            "state --stretch 27.9,0.0038 {oblique}1e5,-2,2,1.5 --set material.model=saint-venant-kirchhoff --set discretization.method=conforming"
        ),
        format!(
            "state --deformation-gradient=1,1e9,0,1 {oblique}1,0,0,1 --set discretization.frame=eulerian"
        ),
        "modes --set discretization.arrangement=simple-cubic --set discretization.cells=16"
            .to_owned(),
    ] {
        let words: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
        let output = limited(&words);
        assert_eq!(output.status.code(), Some(2), "{line}");
        assert!(!output.stderr.is_empty(), "{line}");
    }
    let steep = "notions --json --mode simple-shear --set material.model=ogden --set material.alpha2=3579.3 --set material.kappa=1e-3";
    let answer = answered(steep);
    let reasons: Vec<String> = answer["loadings"]
        .as_array()
        .expect("loadings")
        .iter()
        .flat_map(|loading| {
            ["compression_end", "tension_end"].map(|end| loading[end]["reason"].to_string())
        })
        .collect();
    assert!(
        reasons.iter().any(|reason| reason.contains("given up")),
        "{reasons:?}"
    );
}

#[test]
fn the_basis_and_the_units_of_a_problem_change_no_verdict() {
    let number =
        |answer: &Value, name: &str| answer["discretization"][name].as_f64().expect("a number");
    let oblique = |vectors: &str| {
        answered(&format!(
            "state --json --stretch 1.05,0.98 --set discretization.arrangement=oblique --set discretization.support=1.7 \
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
    for (arrangement, stretch) in [("hexagonal", "1.15,1"), ("simple-cubic", "1.1,1,0.95")] {
        let line = |mu: &str, density: &str| {
            answered(&format!(
                "state --json --stretch {stretch} --set discretization.frame=eulerian --set discretization.arrangement={arrangement} \
                 --set discretization.density={density} {law}{mu}"
            ))
        };
        let plain = line("1", "1");
        for (mu, density) in [
            ("1", "1e-160"),
            ("1e80", "1"),
            ("1e-80", "1"),
            ("1e155", "1"),
            ("1e-100", "1e60"),
        ] {
            let other = line(mu, density);
            assert_eq!(other["verdict"], plain["verdict"], "{mu} {density}");
            let [a, b] = [&other, &plain].map(|answer| number(answer, "minimum_scaled"));
            assert!(
                (a - b).abs() < 1e-9 * b.abs(),
                "{arrangement} {mu} {density}: {a} {b}"
            );
            let unit = (mu.parse::<f64>().expect("a number")
                / density.parse::<f64>().expect("a number"))
            .sqrt();
            for name in ["maximum_omega", "growth_rate"] {
                let [a, b] = [number(&other, name), number(&plain, name) * unit];
                assert!(
                    (a - b).abs() <= 1e-9 * b.abs(),
                    "{arrangement} {mu} {density} {name}: {a} {b}"
                );
            }
        }
    }
}

#[test]
fn more_threads_than_cores_have_use_for_are_refused() {
    for (threads, code) in [("1", 0), ("100000", 2), ("many", 2)] {
        let output = Command::new(env!("CARGO_BIN_EXE_onset"))
            .args(["list", "kernels"])
            .env("RAYON_NUM_THREADS", threads)
            .output()
            .expect("the command starts");
        assert_eq!(output.status.code(), Some(code), "{threads}");
    }
}
