//! Vocabulary of the language: variables, functions, constants, and common alternatives.

/// Group of related variables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VariableGroup {
    /// Names of the variables.
    pub names: &'static [&'static str],
    /// Abbreviated list of the names.
    pub label: &'static str,
    /// Meaning of the variables.
    pub meaning: &'static str,
    /// Symmetry of a law that uses the words.
    pub kind: VariableKind,
}

/// Symmetry that the use of a variable implies for a law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VariableKind {
    /// The law is invariant under rotations of space and of the material.
    Isotropic,
    /// The law is invariant under rotations of space.
    Objective,
    /// The law need not be objective: the variables change under rotations of space.
    Component,
}

/// All variables of a formula.
pub const VARIABLES: &[VariableGroup] = &[
    VariableGroup {
        names: &["I1", "I2", "I3"],
        label: "I1, I2, I3",
        meaning: "principal invariants of C = F^T F: tr C, (tr(C)^2 - tr(C^2))/2, det C",
        kind: VariableKind::Isotropic,
    },
    VariableGroup {
        names: &["J"],
        label: "J",
        meaning: "volume ratio det F",
        kind: VariableKind::Isotropic,
    },
    VariableGroup {
        names: &["I1bar", "I2bar"],
        label: "I1bar, I2bar",
        meaning: "isochoric invariants J^(-2/3) I1, J^(-4/3) I2",
        kind: VariableKind::Isotropic,
    },
    VariableGroup {
        names: &["lambda1", "lambda2", "lambda3"],
        label: "lambda1, lambda2, lambda3",
        meaning: "principal stretches; the formula must be symmetric in them",
        kind: VariableKind::Isotropic,
    },
    VariableGroup {
        names: &["I4", "I5"],
        label: "I4, I5",
        meaning: "a . C a and a . C^2 a of the fibers a at fiber1-angle (degrees, in the plane)",
        kind: VariableKind::Objective,
    },
    VariableGroup {
        names: &["I6", "I7"],
        label: "I6, I7",
        meaning: "a . C a and a . C^2 a of the fibers a at fiber2-angle (degrees, in the plane)",
        kind: VariableKind::Objective,
    },
    VariableGroup {
        names: &[
            "C11", "C12", "C13", "C21", "C22", "C23", "C31", "C32", "C33",
        ],
        label: "C11..C33",
        meaning: "right Cauchy-Green tensor F^T F",
        kind: VariableKind::Objective,
    },
    VariableGroup {
        names: &[
            "E11", "E12", "E13", "E21", "E22", "E23", "E31", "E32", "E33",
        ],
        label: "E11..E33",
        meaning: "Green-Lagrange strain (C - 1)/2",
        kind: VariableKind::Objective,
    },
    VariableGroup {
        names: &[
            "F11", "F12", "F13", "F21", "F22", "F23", "F31", "F32", "F33",
        ],
        label: "F11..F33",
        meaning: "deformation gradient; a law in these need not be objective",
        kind: VariableKind::Component,
    },
];

/// Parameters for the directions of the two families of fibers, in degrees.
pub const FIBER_ANGLES: [&str; 2] = ["fiber1-angle", "fiber2-angle"];

/// Circle constant, the only named constant.
pub(super) const PI: &str = "pi";

/// Keywords of the grammar.
pub(super) const KEYWORDS: [&str; 4] = ["let", "and", "or", "not"];

/// Number of arguments of a function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Arity {
    One,
    Two,
    TwoOrMore,
    Condition,
}

impl Arity {
    pub(super) fn admits(self, count: usize) -> bool {
        match self {
            Self::One => count == 1,
            Self::Two => count == 2,
            Self::TwoOrMore => count >= 2,
            Self::Condition => count == 3,
        }
    }

    pub(super) fn expected(self) -> &'static str {
        match self {
            Self::One => "one argument",
            Self::Two => "two arguments",
            Self::TwoOrMore => "two or more arguments",
            Self::Condition => "three arguments (condition, value, otherwise)",
        }
    }
}

/// Function of the language.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FunctionWord {
    /// Name of the function.
    pub name: &'static str,
    /// Usage and meaning of the function.
    pub meaning: &'static str,
    pub(super) arity: Arity,
}

const fn word(name: &'static str, meaning: &'static str, arity: Arity) -> FunctionWord {
    FunctionWord {
        name,
        meaning,
        arity,
    }
}

/// All functions of a formula.
pub const FUNCTIONS: &[FunctionWord] = &[
    word(
        "if",
        "if(condition, value, otherwise); conditions: < <= > >=, and, or, not; the side that is not taken may be undefined",
        Arity::Condition,
    ),
    word("sqrt", "square root", Arity::One),
    word("cbrt", "cube root of a positive number", Arity::One),
    word("exp", "exponential function", Arity::One),
    word("ln", "natural logarithm", Arity::One),
    word("log10", "logarithm to base 10", Arity::One),
    word("sin", "sine, of radians", Arity::One),
    word("cos", "cosine, of radians", Arity::One),
    word("tan", "tangent, of radians", Arity::One),
    word("sinh", "hyperbolic sine", Arity::One),
    word("cosh", "hyperbolic cosine", Arity::One),
    word("tanh", "hyperbolic tangent", Arity::One),
    word("abs", "absolute value; at zero a kink", Arity::One),
    word(
        "macaulay",
        "<x>: 0 below zero, x above; at zero a kink",
        Arity::One,
    ),
    word("ramp", "the same as macaulay", Arity::One),
    word(
        "heaviside",
        "0 below zero, 1 above, with a jump at zero",
        Arity::One,
    ),
    word(
        "min",
        "smallest argument; all arguments must be defined",
        Arity::TwoOrMore,
    ),
    word(
        "max",
        "largest argument; all arguments must be defined",
        Arity::TwoOrMore,
    ),
    word("pow", "pow(x, y) = x^y", Arity::Two),
];

/// Function with a given name.
pub(super) fn function(name: &str) -> Option<&'static FunctionWord> {
    FUNCTIONS.iter().find(|function| function.name == name)
}

/// Names of all functions.
pub(super) fn function_names() -> impl Iterator<Item = &'static str> {
    FUNCTIONS.iter().map(|function| function.name)
}

/// Names of all variables in one line.
pub(super) fn variable_names() -> String {
    let labels: Vec<&str> = VARIABLES.iter().map(|group| group.label).collect();
    labels.join(", ")
}

/// Group and name of a variable.
pub(super) fn variable(name: &str) -> Option<(&'static VariableGroup, &'static str)> {
    VARIABLES.iter().find_map(|group| {
        let known = group.names.iter().find(|known| **known == name)?;
        Some((group, *known))
    })
}

/// Meaning of a name in every formula, as part of a sentence; `None` for an unreserved name.
pub(super) fn meaning(name: &str) -> Option<&'static str> {
    if KEYWORDS.contains(&name) {
        Some("a word of the language")
    } else if name == PI {
        Some("a constant")
    } else if function(name).is_some() {
        Some("a function")
    } else if variable(name).is_some() {
        Some("a variable")
    } else {
        None
    }
}

/// Suggested replacement for a character.
pub(super) fn instead_of(character: char) -> &'static str {
    match character {
        '\u{2212}' | '\u{2013}' | '\u{2014}' => "write the minus sign as -",
        '\u{d7}' | '\u{b7}' | '\u{22c5}' => "write products with *",
        '\u{f7}' | ':' => "write quotients with /",
        '\u{b2}' | '\u{b3}' | '\u{b9}' => "write powers with ^, for example J^2",
        '\u{221a}' => "write sqrt(...)",
        '\u{3c0}' => "write pi",
        '\u{2264}' => "write <=",
        '\u{2265}' => "write >=",
        '[' | ']' | '{' | '}' => "group with round parentheses",
        '?' => "write if(condition, value, otherwise)",
        '|' => "write abs(...) for an absolute value, `or` for alternatives",
        '&' => "write and",
        '!' => "write not; numbers are compared with <, <=, > and >=",
        '"' | '\'' => "a formula has no quotation marks",
        '\u{391}'..='\u{3c9}' => "spell Greek letters out: mu, kappa, lambda",
        '_' => "names begin with a letter",
        _ => "a formula has numbers, names, operators + - * / ^, parentheses and commas",
    }
}

/// Suggested replacement for a name that other programs use.
pub(super) fn advice(name: &str) -> Option<&'static str> {
    Some(match name {
        "log" => "write ln (natural) or log10",
        "det" => "write J for det F, I3 for det C",
        "tr" | "trace" => "write I1 for tr C",
        "sqr" | "square" => "write a power: x^2",
        "e" => "write exp(1)",
        "F" | "C" | "E" => "write components: F11, C12, E22; or invariants: I1, I2, I3, J",
        _ => return None,
    })
}

/// Largest length of a word that is compared with others, in letters.
const LONGEST_WORD: usize = 40;

/// Returns the most similar name, if at most a third of the letters differ, or only their case.
pub(super) fn nearest<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let plain = |text: &str| -> Vec<char> {
        let letters = text.chars().filter(|c| *c != '_' && *c != '-');
        letters.map(|c| c.to_ascii_lowercase()).collect()
    };
    let typed = plain(name);
    if typed.len() > LONGEST_WORD {
        return None;
    }
    known
        .filter_map(|candidate| {
            let letters = plain(candidate);
            let is_long = letters.len() > LONGEST_WORD;
            let distance = (!is_long).then(|| edits(&typed, &letters))?;
            let limit = typed.len().max(letters.len()) / 3;
            (distance <= limit).then_some((distance, candidate))
        })
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

/// Edit distance of two words: number of letters changed, added, removed or exchanged with a neighbor.
fn edits(a: &[char], b: &[char]) -> usize {
    let mut table = vec![vec![0; b.len() + 1]; a.len() + 1];
    for i in 0..=a.len() {
        for j in 0..=b.len() {
            table[i][j] = match (i, j) {
                (0, rest) | (rest, 0) => rest,
                _ => {
                    let changed = table[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
                    let mut best = changed.min(table[i - 1][j] + 1).min(table[i][j - 1] + 1);
                    let is_exchange =
                        i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
                    if is_exchange {
                        best = best.min(table[i - 2][j - 2] + 1);
                    }
                    best
                }
            };
        }
    }
    table[a.len()][b.len()]
}
