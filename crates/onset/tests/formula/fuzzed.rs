//! Random formulas, from arbitrary words to realistic laws: read, evaluated, differentiated and enclosed without a panic, in bounded time and memory.

use crate::hunt::hunted;
use crate::random::Random;
use onset::formula::Formula;
use onset::kinematics::DeformationGradient;
use onset::material::Hyperelastic;
use onset::real::Interval;
use std::time::{Duration, Instant};

/// Largest admitted time for one formula.
const LONGEST: Duration = Duration::from_secs(10);
/// Largest admitted memory of the whole program in kibibytes.
const MEMORY: u64 = 1 << 20;

/// Mostly state-dependent terms that can be added.
const NAMES: &[&str] = &[
    "I1", "I1", "I2", "I3", "J", "J", "I1bar", "I2bar", "C11", "C12", "C33", "E11", "E23", "F11",
    "F12", "F33", "mu", "kappa", "k1", "pi", "I4", "lambda1", "foo",
];
/// Additional words for unordered texts.
const OTHERS: &[&str] = &[
    "I7", "lambda2", "C14", "F", "q", "a", "let", "gamma", "sign",
];
const NUMBERS: &[&str] = &[
    "0", "1", "2", "0.5", "3", "1/3", "1e-3", "1e3", "1e-300", "1e300", ".5", "2.", "100",
];
const FUNCTIONS: &[&str] = &[
    "sqrt",
    "cbrt",
    "exp",
    "ln",
    "log10",
    "sin",
    "cos",
    "tan",
    "tanh",
    "sinh",
    "cosh",
    "abs",
    "macaulay",
    "ramp",
    "heaviside",
];
const PAIRS: &[&str] = &["min", "max", "pow"];
const OPERATORS: &[&str] = &["+", "-", "*", "/", "^"];
const COMPARISONS: &[&str] = &["<", "<=", ">", ">="];
const DEBRIS: &[&str] = &[
    "(", ")", ",", ";", "=", "let", "and", "or", "not", "if", "if(", " ", "\n", "\t", "$",
    "\u{3bb}", "\u{b2}", "\u{0}", "let a =", "^^", "--", "1.2.3", "1e999", "1e", "0x1", "**", "==",
    "!=", "2mu", "\u{202e}",
];

struct Source(Random);

impl Source {
    fn below(&mut self, bound: usize) -> usize {
        let unit = 0.5 * (self.0.number() + 1.0);
        ((unit * bound as f64) as usize).min(bound - 1)
    }

    fn of(&mut self, words: &'static [&'static str]) -> &'static str {
        words[self.below(words.len())]
    }

    /// Expression of a given depth.
    fn expression(&mut self, depth: usize) -> String {
        if depth == 0 {
            return match self.below(3) {
                0 => self.of(NUMBERS).to_owned(),
                _ => self.of(NAMES).to_owned(),
            };
        }
        let one = |source: &mut Self| source.expression(depth - 1);
        match self.below(12) {
            0..5 => format!("{}{}{}", one(self), self.of(OPERATORS), one(self)),
            5 => format!("({})", one(self)),
            6 => format!("-{}", one(self)),
            7 | 8 => format!("{}({})", self.of(FUNCTIONS), one(self)),
            9 => format!("{}({}, {})", self.of(PAIRS), one(self), one(self)),
            10 => format!(
                "if({} {} {}, {}, {})",
                one(self),
                self.of(COMPARISONS),
                one(self),
                one(self),
                one(self)
            ),
            _ => format!("({})^({})", one(self), one(self)),
        }
    }

    /// Text of words in random order.
    fn soup(&mut self) -> String {
        let count = self.below(30);
        let word = |source: &mut Self| match source.below(7) {
            0 => source.of(NAMES),
            6 => source.of(OTHERS),
            1 => source.of(NUMBERS),
            2 => source.of(FUNCTIONS),
            3 => source.of(OPERATORS),
            4 => source.of(COMPARISONS),
            _ => source.of(DEBRIS),
        };
        let words: Vec<&str> = (0..count).map(|_| word(self)).collect();
        let between = if self.below(2) == 0 { "" } else { " " };
        words.join(between)
    }

    fn formula(&mut self) -> String {
        match self.below(10) {
            0..2 => self.soup(),
            2 => {
                // A formula with a part removed or inserted.
                let mut text = self.expression(3);
                let places: Vec<usize> = text.char_indices().map(|(place, _)| place).collect();
                let place = places[self.below(places.len())];
                match self.below(2) {
                    0 => text.truncate(place),
                    _ => text.insert_str(place, self.of(DEBRIS)),
                }
                text
            }
            3 => {
                let (helper, rest) = (self.expression(2), self.expression(2));
                format!("let a = {helper}; {rest} + a*a")
            }
            _ => {
                let depth = 1 + self.below(4);
                self.expression(depth)
            }
        }
    }
}

/// Reads a formula and evaluates it in every way. Results matter only where they must agree.
fn ask(text: &str, states: &[DeformationGradient]) -> bool {
    let formula = match Formula::parse(text) {
        Err(error) => {
            assert!(!error.to_string().is_empty(), "{text:?}");
            return false;
        }
        Ok(formula) => formula,
    };
    let names: Vec<String> = formula.parameters().map(str::to_owned).collect();
    let values: Vec<(&str, f64)> = names.iter().map(|name| (name.as_str(), 0.7)).collect();
    let Ok(law) = formula.with(&values) else {
        return false;
    };
    for f in states {
        let response = law.response(f);
        let _ = law.plane_tangent(f);
        let _ = law.plane_response(f);
        if let Ok(response) = &response {
            assert!(response.energy.is_finite(), "{text:?}");
            assert!(response.tangent.is_finite(), "{text:?}");
        }
    }
    let box_of = |x: f64| Interval::new(x - 1e-3, x + 1e-3);
    let around = states[0].components().map(|row| row.map(box_of));
    let bounds = law.enclosure(&DeformationGradient::from_components(around));
    let is_empty = bounds.energy.low > bounds.energy.high;
    assert!(!is_empty, "{text:?}: {:?}", bounds.energy);
    true
}

/// Peak memory of the program in kibibytes, if the system reports it.
fn largest_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse().ok()
}

#[test]
fn random_formulas_stay_within_time_and_memory_without_panic() {
    let (seed, cases) = hunted(60_000);
    let mut source = Source(Random::new(seed));
    let states = [
        [[1.1, 0.2, 0.0], [-0.1, 0.9, 0.1], [0.0, 0.3, 1.2]],
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        [[1.3, 0.0, 0.0], [0.0, 0.6, 0.0], [0.0, 0.0, 1.0]],
    ]
    .map(|rows| DeformationGradient::new(rows).expect("a state"));
    let mut read = 0;
    for case in 0..cases {
        let text = source.formula();
        let start = Instant::now();
        let before = format!("case {case} of seed {seed}: {text:?}");
        let asked = std::panic::catch_unwind(|| ask(&text, &states));
        assert!(asked.is_ok(), "{before}");
        assert!(start.elapsed() < LONGEST, "{before}: {:?}", start.elapsed());
        read += usize::from(asked.is_ok_and(|is_read| is_read));
    }
    // If few cases were formulas, little more than the parser would be tested.
    assert!(read * 5 > cases, "{read} of {cases} were formulas");
    if let Some(memory) = largest_memory() {
        assert!(memory < MEMORY, "{memory} KiB");
    }
}
