//! Random, mostly invalid command lines for every command. Most are cheap, which allows a large number of trials.

use crate::process::{Line, STUDY};
use serde_json::Value;

/// Key with its admissible words, if any.
#[derive(Clone, Debug)]
struct Key {
    section: String,
    name: String,
    words: Vec<String>,
}

/// Law with the names of its parameters.
#[derive(Clone, Debug)]
struct Law {
    name: String,
    parameters: Vec<String>,
}

/// Laws in the schema, except for laws that run programs.
fn laws(schema: &Value) -> Vec<Law> {
    let cases = schema.pointer("/properties/material/allOf");
    let law = |case: &Value| {
        let name = case.pointer("/if/properties/model/const")?.as_str()?;
        let parameters = case.pointer("/then/properties")?.as_object()?;
        Some(Law {
            name: name.to_owned(),
            parameters: parameters.keys().cloned().collect(),
        })
    };
    let mut laws: Vec<Law> = cases
        .and_then(Value::as_array)
        .into_iter()
        .flatten()
        .filter_map(law)
        .collect();
    laws.retain(|law| !["umat", "vumat", "library"].contains(&law.name.as_str()));
    assert!(laws.len() > 20, "{laws:?}");
    laws
}

/// Keys of studies and comparisons in the schema.
fn keys(schema: &Value) -> Vec<Key> {
    let mut keys = Vec::new();
    for section in ["material", "discretization", "state", "map", "compare"] {
        let properties = schema
            .pointer(&format!("/properties/{section}/properties"))
            .and_then(Value::as_object)
            .unwrap_or_else(|| panic!("no keys of {section}"));
        for (name, kind) in properties {
            let mut words = Vec::new();
            collect_words(kind, &mut words);
            keys.push(Key {
                section: section.to_owned(),
                name: name.clone(),
                words,
            });
        }
    }
    assert!(keys.len() > 60, "{keys:?}");
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
    "mu/2*(I1-3) + max(0, sqrt(3-I1))",
    "lambda1^300 + lambda2^300",
];

const PARAMETERS: &[&str] = &["mu", "kappa", "lambda", "alpha2", "k1", "k2", "j_m", "c1"];

/// Compatible choices for a discretization.
const METHODS: &[&[(&str, &str)]] = &[
    &[],
    &[("quadrature", "nodal")],
    &[("frame", "eulerian")],
    &[
        ("frame", "eulerian"),
        ("quadrature", "nodal"),
        ("support", "1.4"),
    ],
    &[
        ("frame", "eulerian"),
        ("lattice", "regular"),
        ("support-size", "fixed"),
        ("linearization", "paper"),
    ],
    &[("lattice", "square")],
    &[("lattice", "square"), ("approximation", "raw")],
    &[("lattice", "chain")],
    &[("lattice", "chain"), ("frame", "eulerian")],
    &[("lattice", "honeycomb")],
    &[
        ("lattice", "simple-cubic"),
        ("quadrature", "nodal"),
        ("support", "1.2"),
    ],
    &[("lattice", "rectangular"), ("aspect", "1.3")],
    &[("lattice", "oblique"), ("vectors", "1,0,0.3,1.1")],
    &[("lattice", "square"), ("method", "total-lagrangian-sph")],
    &[
        ("lattice", "square"),
        ("method", "total-lagrangian-sph"),
        ("penalty", "0.1"),
    ],
    &[("method", "updated-sph")],
    &[("method", "updated-sph"), ("artificial-stress", "0.3")],
    &[("method", "updated-sph"), ("velocity-smoothing", "0.5")],
    &[
        ("method", "updated-sph"),
        ("corrected", "false"),
        ("viscosity", "0.1"),
    ],
    &[("method", "finite-elements")],
    &[
        ("method", "finite-elements"),
        ("integration", "one-point"),
        ("hourglass-stiffness", "0.05"),
    ],
    &[("method", "finite-elements"), ("mesh", "triangles")],
    &[("lattice", "square"), ("method", "conforming")],
    &[
        ("lattice", "square"),
        ("method", "peridynamics"),
        ("horizon", "2.2"),
    ],
    &[
        ("lattice", "square"),
        ("method", "peridynamics"),
        ("bonds", "correspondence"),
        ("control", "penalty"),
        ("control-coefficient", "0.5"),
    ],
    &[("method", "material-points")],
    &[
        ("method", "material-points"),
        ("grid-functions", "quadratic-spline"),
    ],
    &[
        ("cells", "2"),
        ("perturbation", "0.05"),
        ("quadrature", "nodal"),
    ],
];

/// Coefficients that can be tuned, and some that cannot.
const COEFFICIENTS: &[&str] = &[
    "discretization.penalty",
    "discretization.stress-point-weight",
    "discretization.support",
    "discretization.artificial-stress",
    "discretization.hourglass-stiffness",
    "discretization.spacing",
    "discretization.method",
    "material.mu",
    "penalty",
    "",
];

/// Output folders: common, unusual and invalid paths.
const PLACES: &[&str] = &[
    ".",
    ".",
    "new",
    "new/inner/",
    "..//here/x",
    "study.toml",
    "study.toml/x",
    "/dev/null",
    "/dev/full",
    "/dev/stdout",
    "/proc/self/x",
    "",
    "\u{1b}[31mred",
    "-",
    "a b'c",
];

/// Paths of studies.
const FILES: &[&str] = &[
    "study.toml",
    "nowhere.toml",
    ".",
    "",
    "/dev/null",
    "/dev/zero",
    "1.2",
    "../whole.zarr",
    "../whole.zarr/zarr.json",
    "--",
];

/// Uniform random numbers in `(-1, 1)`: SplitMix64.
struct Random(u64);

impl Random {
    fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn number(&mut self) -> f64 {
        (self.word() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// Assignments as section, key and value.
type Assignments = Vec<(String, String, String)>;

/// Generator of command lines.
pub struct Source {
    random: Random,
    keys: Vec<Key>,
    laws: Vec<Law>,
}

impl Source {
    /// Generator of command lines with the keys of a schema.
    pub fn new(schema: &Value) -> Self {
        Self {
            random: Random(0),
            keys: keys(schema),
            laws: laws(schema),
        }
    }

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

    /// Random number, usually a reasonable one.
    fn number(&mut self) -> String {
        match self.below(24) {
            0 => self.of(NUMBERS).to_owned(),
            1 => format!("{:e}", 10_f64.powf(30.0 * self.random.number())),
            2 => format!("{:?}", 8.0 * self.random.number()),
            _ => format!("{:?}", 1.0 + 0.4 * self.random.number()),
        }
    }

    fn numbers(&mut self, usual: usize) -> String {
        let count = if self.chance(94) {
            usual
        } else {
            self.below(10)
        };
        let all: Vec<String> = (0..count).map(|_| self.number()).collect();
        all.join(",")
    }

    /// Two numbers, usually in increasing order.
    fn interval(&mut self) -> String {
        if self.chance(30) {
            return self.numbers(2);
        }
        let [low, width] = [0; 2].map(|_| 0.5 * (self.random.number() + 1.0));
        format!("{:?},{:?}", 0.6 + 0.4 * low, 1.0 + 0.5 * width)
    }

    /// Random value of a key.
    fn value(&mut self, key: &Key) -> String {
        match (key.section.as_str(), key.name.as_str()) {
            // Large cells take long even without a defect.
            ("discretization", "cells") => self.of(&["1", "2", "0", "-1", "1e9", "17"]).to_owned(),
            ("discretization", "support" | "horizon") if self.chance(80) => {
                format!("{:?}", 1.6 + 0.5 * self.random.number())
            }
            ("discretization", "vectors") => {
                let count = [4, 9][self.below(2)];
                self.numbers(count)
            }
            ("discretization", "basis" | "points") => {
                let count = [2, 3, 6, 12][self.below(4)];
                self.numbers(count)
            }
            ("material", "energy") => self.of(FORMULAS).to_owned(),
            ("material", "library") => self
                .of(&["/dev/null", "", "nowhere.so", ".", "study.toml"])
                .to_owned(),
            ("map", "tile") => self
                .of(&["8", "8", "16", "9", "0", "1024", "65536"])
                .to_owned(),
            ("map", "refine-from") => self.of(&["1", "2", "16", "5"]).to_owned(),
            ("map", "adaptive" | "certify") => self.of(&["true", "false", "perhaps"]).to_owned(),
            _ if !key.words.is_empty() && self.chance(92) => {
                key.words[self.below(key.words.len())].clone()
            }
            _ => self.number(),
        }
    }

    /// A few assignments, or none.
    fn changes(&mut self, sections: &[&str], words: &mut Vec<String>) {
        if self.chance(15) {
            self.set(sections, words);
        }
    }

    /// A few assignments in some sections, both compatible and arbitrary choices.
    fn assignments(&mut self, sections: &[&str]) -> Assignments {
        let mut all: Assignments = Vec::new();
        let mut add = |section: &str, name: &str, value: &str| {
            if sections.contains(&section) {
                all.push((section.to_owned(), name.to_owned(), value.to_owned()));
            }
        };
        if self.chance(80) {
            for (name, value) in METHODS[self.below(METHODS.len())] {
                add("discretization", name, value);
            }
        }
        if self.chance(50) {
            let n = self.below(self.laws.len());
            let law = self.laws[n].clone();
            add("material", "model", &law.name);
            if law.name == "formula" {
                add("material", "energy", self.of(FORMULAS));
                let mu = self.number();
                add("material", "mu", &mu);
            }
            for name in &law.parameters {
                if self.chance(30) {
                    let value = self.number();
                    add("material", name, &value);
                }
            }
        }
        if self.chance(2) {
            let (name, value) = (self.of(PARAMETERS), self.number());
            add("material", name, &value);
        }
        let more = [0, 0, 0, 0, 0, 0, 1, 3][self.below(8)];
        for _ in 0..more {
            let n = self.below(self.keys.len());
            let key = self.keys[n].clone();
            // A law has few parameters, and the other laws have many.
            if key.section == "material" && !["energy", "library"].contains(&key.name.as_str()) {
                continue;
            }
            let value = self.value(&key);
            add(&key.section, &key.name, &value);
        }
        all
    }

    fn set(&mut self, sections: &[&str], words: &mut Vec<String>) {
        for (section, name, value) in self.assignments(sections) {
            words.extend(["--set".to_owned(), format!("{section}.{name}={value}")]);
        }
        if self.chance(3) {
            let nonsense = self.of(&[
                "",
                "=",
                "nothing=1",
                "discretization.support",
                "a.b.c=2",
                "material.mu=1=2",
                "\u{3bb}=1",
                "material.mu=\u{1b}[2J",
                "axes.states=2",
            ]);
            words.extend(["--set".to_owned(), nonsense.to_owned()]);
        }
    }

    /// A value in TOML, usually a valid one.
    fn toml(&mut self, value: &str) -> String {
        let is_number =
            |text: &str| text.parse::<f64>().is_ok() && !text.starts_with(['i', 'n', '+']);
        if self.chance(2) {
            return self
                .of(&[
                    "[[1]]",
                    "{ a = 1 }",
                    "2026-01-01",
                    "'",
                    "true",
                    "\"\\u0000\"",
                ])
                .to_owned();
        }
        if is_number(value) || value == "true" || value == "false" {
            return value.to_owned();
        }
        let parts: Vec<&str> = value.split(',').collect();
        if parts.len() > 1 && parts.iter().all(|part| is_number(part)) {
            return format!("[{}]", parts.join(", "));
        }
        format!("{value:?}")
    }

    fn table(&mut self, head: &str, assignments: &Assignments, section: &str) -> String {
        let mut text = format!("{head}\n");
        let own: Vec<_> = assignments
            .iter()
            .filter(|(own, ..)| own == section)
            .collect();
        for (n, (_, name, value)) in own.iter().enumerate() {
            // TOML admits each key once; sometimes a duplicate is written to test its rejection.
            let is_again = own[..n].iter().any(|(_, other, _)| other == name);
            if is_again && !self.chance(2) {
                continue;
            }
            let value = self.toml(value);
            text.push_str(&format!("{name} = {value}\n"));
        }
        text
    }

    /// Study with few states, or with any number of states if they are only counted.
    fn study(&mut self, is_counted: bool) -> String {
        let assignments = self.assignments(&["material", "discretization", "state", "map"]);
        let mut text = String::new();
        for section in ["material", "discretization", "state", "map"] {
            if assignments.iter().any(|(own, ..)| own == section) {
                text.push_str(&self.table(&format!("[{section}]"), &assignments, section));
            }
        }
        let axes = [2, 2, 2, 2, 2, 2, 3, 1, 0, 4][self.below(10)];
        for axis in 0..axes {
            let quantity = match self.below(4) {
                0 => self.of(&[
                    "stretch-3",
                    "shear",
                    "rotation",
                    "discretization.support",
                    "material.mu",
                    "discretization.spacing",
                    "stretch-1",
                    "nothing",
                ]),
                _ => ["stretch-1", "stretch-2", "stretch-3", "shear"][axis],
            };
            let range = self.interval();
            let states = match is_counted {
                true => self.of(&["2", "1000", "1e3", "65536", "0", "-3", "99999999999", "1"]),
                false => self.of(&["1", "2", "2", "2", "2", "3", "3", "2", "2", "0", "x"]),
            };
            text.push_str(&format!(
                "[[axes]]\nquantity = {quantity:?}\nrange = [{range}]\nstates = {states}\n"
            ));
        }
        self.damaged(text)
    }

    /// Comparison of few methods on few states.
    fn comparison(&mut self) -> String {
        let common = self.assignments(&["material"]);
        let few = [
            ("states", "2"),
            ("stretches", "0.9,1.2"),
            ("tension", "1.4"),
            ("compression", "0.8"),
        ];
        let few: Assignments = few
            .into_iter()
            .map(|(name, value)| {
                let is_changed = self.chance(5);
                let value = if is_changed {
                    self.number()
                } else {
                    value.to_owned()
                };
                ("compare".to_owned(), name.to_owned(), value)
            })
            .collect();
        let mut text = self.table("[compare]", &few, "compare");
        text.push_str(&self.table("[material]", &common, "material"));
        for n in 0..[1, 1, 2, 0][self.below(4)] {
            let method = self.assignments(&["discretization"]);
            let head = format!("[[methods]]\nname = 'method {n}'");
            text.push_str(&self.table(&head, &method, "discretization"));
        }
        self.damaged(text)
    }

    /// Text that is sometimes damaged.
    fn damaged(&mut self, mut text: String) -> String {
        if text.is_empty() || !self.chance(12) {
            return text;
        }
        let places: Vec<usize> = text.char_indices().map(|(place, _)| place).collect();
        let place = places[self.below(places.len())];
        match self.below(4) {
            0 => text.truncate(place),
            1 => drop(text.remove(place)),
            2 => text.insert_str(
                place,
                self.of(&[
                    "\u{0}",
                    "\"",
                    "[",
                    "\n\n",
                    "#",
                    "=",
                    "\u{1b}[2J",
                    "\u{202e}",
                    "1e",
                ]),
            ),
            _ => text.insert_str(0, "title = 3\n"),
        }
        text
    }

    /// File of a study, usually standard input.
    fn file(&mut self, line: &mut Line, text: String) {
        if self.chance(92) {
            line.words.push("-".to_owned());
            line.input = text;
        } else {
            line.words.push(self.of(FILES).to_owned());
        }
    }

    fn out(&mut self, words: &mut Vec<String>, percent: usize) {
        if self.chance(percent) {
            words.push(format!("--out={}", self.of(PLACES)));
        }
    }

    fn flag(&mut self, words: &mut Vec<String>, flag: &str, percent: usize) {
        if self.chance(percent) {
            words.push(flag.to_owned());
        }
    }

    fn energy(&mut self, words: &mut Vec<String>) {
        if self.chance(10) {
            words.extend(["--energy".to_owned(), self.of(FORMULAS).to_owned()]);
        }
    }

    fn problem(&mut self, line: &mut Line) {
        if self.chance(5) {
            let text = self.study(false);
            self.file(line, text);
        }
        let words = &mut line.words;
        self.set(&["material", "discretization"], words);
        self.energy(words);
        self.flag(words, "--json", 50);
    }

    fn law(&mut self, line: &mut Line) {
        if self.chance(10) {
            let text = self.study(false);
            self.file(line, text);
        }
        let words = &mut line.words;
        self.set(&["material"], words);
        self.energy(words);
        if self.chance(50) {
            words.push(format!("--range={}", self.interval()));
        }
        self.flag(words, "--json", 50);
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

    /// Command line that is reproducible from a seed and a number.
    pub fn line(&mut self, seed: u64, number: u64) -> Line {
        self.random = Random(
            seed.wrapping_mul(0xD605_BBB5_8C8A_BBFD)
                .wrapping_add(number),
        );
        self.random = Random(self.random.word());
        // Expensive commands are drawn less often.
        let mut drawn = self.below(COMMANDS.iter().map(|(_, share)| share).sum());
        let command = COMMANDS.iter().find(|(_, share)| {
            let is_it = drawn < *share;
            drawn = drawn.saturating_sub(*share);
            is_it
        });
        let command = command.map_or("state", |(command, _)| command);
        let mut line = Line {
            words: vec![command.to_owned()],
            input: String::new(),
        };
        self.arguments(command, &mut line);
        // The words of these commands limit their cost, and are not changed.
        if !["reproduce", "recommend"].contains(&command) {
            self.spoil(&mut line.words);
        }
        line
    }

    fn arguments(&mut self, command: &str, line: &mut Line) {
        match command {
            "state" => {
                self.problem(line);
                self.strain(&mut line.words);
                if self.chance(10) {
                    line.words.push("--certify".to_owned());
                    if self.chance(50) {
                        line.words.push(format!("--tolerance={}", self.number()));
                    }
                }
            }
            "dispersion" => {
                self.problem(line);
                self.strain(&mut line.words);
                if self.chance(70) {
                    let wave_vector = self.numbers(2);
                    line.words.push(format!("--wave-vector={wave_vector}"));
                } else {
                    line.words.push("--path".to_owned());
                    self.out(&mut line.words, 40);
                }
            }
            "path" => {
                self.problem(line);
                let (from, to) = (self.numbers(2), self.numbers(2));
                line.words
                    .extend([format!("--from={from}"), format!("--to={to}")]);
            }
            "modes" => self.modes(line),
            "localize" => self.localize(&mut line.words),
            "audit" => {
                self.problem(line);
                if self.chance(20) {
                    line.words.push(format!("--strain={}", self.number()));
                }
                if self.chance(30) {
                    self.strain(&mut line.words);
                }
                if self.chance(30) {
                    let convention = self.of(&["first-piola", "jaumann-kirchhoff", "spatial", "x"]);
                    line.words.push(format!("--as={convention}"));
                }
                self.flag(&mut line.words, "--strict", 20);
            }
            "list" => {
                let topic = self.of(&["materials", "kernels", "formula", "", "x", "methods"]);
                line.words.push(topic.to_owned());
                self.flag(&mut line.words, "--json", 50);
            }
            "check" => {
                let text = self.study(true);
                self.file(line, text);
                if self.chance(10) {
                    line.words.push(self.of(FILES).to_owned());
                }
                self.changes(
                    &["material", "discretization", "state", "map"],
                    &mut line.words,
                );
                self.flag(&mut line.words, "--json", 50);
            }
            "criteria" => {
                self.law(line);
                let mode = self.of(&[
                    "uniaxial",
                    "equibiaxial",
                    "planar",
                    "simple-shear",
                    "hydrostatic",
                    "x",
                ]);
                line.words.push(format!("--mode={mode}"));
                self.out(&mut line.words, 20);
            }
            "card" => {
                self.law(line);
                self.out(&mut line.words, 40);
            }
            "map" => self.map(line),
            "boundary" => {
                let text = self.study(false);
                self.file(line, text);
                self.changes(&["material", "discretization", "state"], &mut line.words);
                self.flag(&mut line.words, "--flutter", 20);
                self.out(&mut line.words, 30);
                self.flag(&mut line.words, "--json", 50);
            }
            "compare" => {
                let text = match self.chance(90) {
                    true => self.comparison(),
                    false => self.study(false),
                };
                self.file(line, text);
                self.changes(&["material", "compare"], &mut line.words);
                self.out(&mut line.words, 30);
                self.flag(&mut line.words, "--json", 50);
                self.flag(&mut line.words, "--quiet", 30);
            }
            "recommend" => self.recommend(line),
            "tune" => self.tune(line),
            "limit" => self.limit(line),
            "plot" => self.plot(&mut line.words),
            // A complete run takes minutes, so that only arguments that prevent it are drawn.
            "reproduce" => {
                let out = self.of(&["study.toml", "/dev/null", "/proc/self/x", "study.toml/x"]);
                line.words.push(format!("--out={out}"));
                self.flag(&mut line.words, "--json", 50);
            }
            _ => {}
        }
    }

    fn modes(&mut self, line: &mut Line) {
        self.problem(line);
        if self.chance(50) {
            let cells = self.of(&["1", "4", "0", "-3", "255", "513", "1e9", "x"]);
            line.words.push(format!("--cells={cells}"));
        }
        for option in ["weak", "amplitude"] {
            if self.chance(30) {
                line.words.push(format!("--{option}={}", self.number()));
            }
        }
        self.out(&mut line.words, 20);
    }

    fn localize(&mut self, words: &mut Vec<String>) {
        for (option, choices) in [
            ("model", &["drucker-prager", "j2", "", "x"][..]),
            (
                "path",
                &[
                    "plane-strain",
                    "uniaxial-stress",
                    "triaxial-compression",
                    "pure-shear",
                    "x",
                ],
            ),
            ("load", &["tension", "compression", "x"]),
        ] {
            if self.chance(40) {
                words.push(format!("--{option}={}", self.of(choices)));
            }
        }
        for name in [
            "material.strength",
            "material.poisson",
            "material.friction",
            "material.dilatancy",
            "plasticity.slip",
            "plasticity.strain-ratio",
            "material.increments",
            "plasticity.x",
        ] {
            if self.chance(15) {
                let assignment = format!("{name}={}", self.number());
                words.extend(["--set".to_owned(), assignment]);
            }
        }
        self.out(words, 20);
        self.flag(words, "--json", 50);
    }

    fn map(&mut self, line: &mut Line) {
        let text = match self.chance(20) {
            true => STUDY.to_owned(),
            false => self.study(false),
        };
        self.file(line, text);
        self.changes(
            &["material", "discretization", "state", "map"],
            &mut line.words,
        );
        if self.chance(30) {
            let tiles = self.of(&[
                "0..1",
                "1/99",
                "0..9999999999",
                "1..1",
                "1..2",
                "x",
                "3..0",
                "2/1",
            ]);
            line.words.push(format!("--tiles={tiles}"));
        }
        self.out(&mut line.words, 50);
        for (flag, percent) in [
            ("--resume", 20),
            ("--overwrite", 20),
            ("--quiet", 20),
            ("--json", 50),
        ] {
            self.flag(&mut line.words, flag, percent);
        }
    }

    fn recommend(&mut self, line: &mut Line) {
        // The built-in methods take long even without a defect: they are drawn in one and two dimensions, on few states.
        if self.chance(80) {
            let text = self.comparison();
            self.file(line, text);
        } else {
            let dimension = self.of(&["1", "1", "1", "0", "4", "x"]);
            line.words.push(format!("--dimension={dimension}"));
            line.words
                .extend(["--set", "compare.states=2"].map(str::to_owned));
        }
        self.changes(&["material", "compare"], &mut line.words);
        if self.chance(30) {
            let stretches = self.interval();
            line.words.push(format!("--stretches={stretches}"));
        }
        self.energy(&mut line.words);
        self.out(&mut line.words, 20);
        self.flag(&mut line.words, "--json", 50);
    }

    fn tune(&mut self, line: &mut Line) {
        line.words.push(self.of(COEFFICIENTS).to_owned());
        self.problem(line);
        for option in ["range", "stretches"] {
            if self.chance(50) {
                let ends = self.interval();
                line.words.push(format!("--{option}={ends}"));
            }
        }
        self.out(&mut line.words, 20);
        self.flag(&mut line.words, "--quiet", 50);
    }

    fn limit(&mut self, line: &mut Line) {
        let key = self.of(COEFFICIENTS);
        let step = self.of(&["0.1", "1e-3", "1e9", "1 us", "1 m", "-1", "nan", "x"]);
        line.words
            .extend([format!("--vary={key}"), format!("--time-step={step}")]);
        self.problem(line);
        if self.chance(50) {
            self.strain(&mut line.words);
        }
        if self.chance(40) {
            let ends = self.interval();
            line.words.push(format!("--range={ends}"));
        }
        self.out(&mut line.words, 20);
        self.flag(&mut line.words, "--quiet", 50);
    }

    fn plot(&mut self, words: &mut Vec<String>) {
        for _ in 0..1 + self.below(2) {
            words.push(
                self.of(&[
                    "../whole.zarr",
                    "../whole.zarr",
                    "../half.zarr",
                    "../whole.zarr/",
                    "../whole.zarr/verdict",
                    "study.toml",
                    ".",
                    "nowhere.zarr",
                    "",
                ])
                .to_owned(),
            );
        }
        if self.chance(40) {
            let field = self.of(&[
                "verdict",
                "growth_rate",
                "wave_vector",
                "certainty",
                "x",
                "",
            ]);
            words.push(format!("--field={field}"));
        }
        self.flag(words, "--no-trace", 70);
        if self.chance(40) {
            let out = self.of(&[
                "a.svg",
                "b.png",
                "c.pdf",
                "study.toml/d.svg",
                ".svg",
                "x/",
                "\u{7}.svg",
            ]);
            words.push(format!("--out={out}"));
        } else {
            self.out(words, 30);
        }
    }

    /// Omits an argument, or inserts one of another command.
    fn spoil(&mut self, words: &mut Vec<String>) {
        if self.chance(4) {
            let n = self.below(words.len());
            words.remove(n);
        }
        if self.chance(5) {
            let n = self.below(words.len().max(1)).min(words.len());
            let word = self.of(&[
                "--json",
                "--stretch",
                "--out",
                "-",
                "--",
                "--quiet",
                "-9",
                "\u{1b}[2J",
                "--set",
                "--allow-library=/",
                "--help",
            ]);
            words.insert(n, word.to_owned());
        }
    }
}

/// Commands, with their relative frequencies.
const COMMANDS: &[(&str, usize)] = &[
    ("state", 300),
    ("dispersion", 100),
    ("path", 40),
    ("modes", 40),
    ("localize", 60),
    ("audit", 50),
    ("list", 10),
    ("check", 120),
    ("criteria", 30),
    ("card", 15),
    ("map", 100),
    ("boundary", 15),
    ("compare", 30),
    ("recommend", 20),
    ("tune", 20),
    ("limit", 20),
    ("plot", 40),
    ("reproduce", 4),
    ("schema", 2),
    ("umat-utilities", 2),
    ("law-header", 2),
    ("nonsense", 3),
    ("--version", 2),
    ("help", 3),
];
