//! Laws with the constants of other programs, and the settings for the same energies.

use super::marlow::Table;
use super::{Reading, Trouble, Unread};

/// Law that was read from a block.
#[derive(Debug)]
pub(super) struct ForeignLaw {
    /// Line of the block.
    pub line: usize,
    /// Name of the law in the program.
    pub title: String,
    /// Model of the library, or a user-defined energy.
    pub energy: Energy,
    /// Constants by the keys of the library.
    pub constants: Vec<(String, f64)>,
    /// Whether the program takes the material as incompressible, because compressibility is missing or zero.
    pub incompressible: bool,
    /// Keys that the user must set.
    pub needed: Vec<&'static str>,
    /// Remarks for the reader.
    pub notes: Vec<String>,
    /// Name of a law whose energy is a table.
    pub name: Option<String>,
    /// Shear modulus at zero strain, if it follows from the constants.
    pub shear: Option<f64>,
    /// Parts of the text that are not read.
    pub unread: Unread,
}

/// Energy that uses the constants.
#[derive(Debug)]
pub(super) enum Energy {
    /// Law of the library.
    Model(&'static str),
    /// User-defined energy as a formula.
    Formula(String),
    /// Table of a test, for Marlow's form.
    Table(Table),
}

/// Ratio of bulk to shear modulus for materials that the program takes as incompressible.
const INCOMPRESSIBLE_BULK_RATIO: f64 = 1000.0;

impl ForeignLaw {
    /// Creates a law with the bulk modulus `2/D_1` for compressibilities `D_i`; `shear` is its shear modulus.
    pub fn new(
        line: usize,
        title: impl Into<String>,
        energy: Energy,
        constants: Vec<(String, f64)>,
        (shear, compressibilities): (f64, &[f64]),
    ) -> Self {
        let mut law = Self {
            line,
            title: title.into(),
            energy,
            constants,
            incompressible: false,
            needed: Vec::new(),
            notes: Vec::new(),
            name: None,
            shear: Some(shear).filter(|shear| *shear != 0.0),
            unread: Unread::default(),
        };
        let first = compressibilities.first().copied().unwrap_or(0.0);
        law.incompressible = compressibilities.iter().all(|d| *d == 0.0);
        let bulk = match law.incompressible {
            true => INCOMPRESSIBLE_BULK_RATIO * shear.abs(),
            false if first == 0.0 => 0.0,
            false => 2.0 / first,
        };
        law.constants.push(("kappa".to_owned(), bulk));
        for (n, d) in compressibilities.iter().enumerate().skip(1) {
            if *d != 0.0 {
                law.constants.push((format!("vol{}", n + 1), 1.0 / d));
            }
        }
        law
    }

    /// Creates a law from constants `c_ij` of `sum c_ij (I1bar - 3)^i (I2bar - 3)^j`: a law of the library if it has these terms, otherwise a
    /// user-defined energy.
    pub fn polynomial(
        line: usize,
        title: impl Into<String>,
        constants: &[((usize, usize), f64)],
        compressibilities: &[f64],
    ) -> Self {
        let of = |i: usize, j: usize| {
            let found = constants.iter().find(|(own, _)| *own == (i, j));
            found.map_or(0.0, |(_, value)| *value)
        };
        let shear = 2.0 * (of(1, 0) + of(0, 1));
        let counts = |(_, value): &&((usize, usize), f64)| *value != 0.0;
        let plain = compressibilities.iter().skip(1).all(|d| *d == 0.0);
        let only = |admitted: &[(usize, usize)]| {
            plain
                && constants
                    .iter()
                    .filter(counts)
                    .all(|(own, _)| admitted.contains(own))
        };
        let named = |names: &[(&str, f64)]| {
            let named = names
                .iter()
                .map(|(name, value)| ((*name).to_owned(), *value));
            named.collect::<Vec<_>>()
        };
        let volume = (shear, compressibilities);
        if only(&[(1, 0), (0, 1)]) && of(0, 1) != 0.0 {
            let constants = named(&[("c10", of(1, 0)), ("c01", of(0, 1))]);
            let model = Energy::Model("mooney-rivlin-isochoric");
            return Self::new(line, title, model, constants, volume);
        }
        if only(&[(1, 0), (2, 0), (3, 0)]) && of(1, 0) > 0.0 {
            let constants = named(&[("c10", of(1, 0)), ("c20", of(2, 0)), ("c30", of(3, 0))]);
            return Self::new(line, title, Energy::Model("yeoh"), constants, volume);
        }
        let mut terms = Vec::new();
        let mut own = Vec::new();
        for ((i, j), value) in constants.iter().filter(counts) {
            let name = format!("c{i}{j}");
            let powers = [("x", i), ("y", j)].map(|(variable, power)| match power {
                0 => String::new(),
                1 => format!("*{variable}"),
                _ => format!("*{variable}^{power}"),
            });
            terms.push(format!("{name}{}", powers.concat()));
            own.push((name, *value));
        }
        let has = |of: fn(&(usize, usize)) -> usize| {
            let mut counted = constants.iter().filter(counts);
            counted.any(|(powers, _)| of(powers) > 0)
        };
        let mut energy = String::new();
        if has(|(i, _)| *i) {
            energy.push_str("let x = I1bar - 3; ");
        }
        if has(|(_, j)| *j) {
            energy.push_str("let y = I2bar - 3; ");
        }
        terms.push(powers_of_volume(compressibilities));
        energy.push_str(&terms.join(" + "));
        Self::new(line, title, Energy::Formula(energy), own, volume)
    }

    /// Ogden's law with moduli of `sum mu_p/alpha_p (...)`.
    pub fn ogden(
        line: usize,
        title: impl Into<String>,
        terms: &[(f64, f64)],
        compressibilities: &[f64],
    ) -> Self {
        let shear = 0.5 * terms.iter().map(|(mu, alpha)| mu * alpha).sum::<f64>();
        let mut constants = Vec::new();
        for (n, (mu, alpha)) in terms.iter().enumerate() {
            constants.push((format!("mu{}", n + 1), *mu));
            constants.push((format!("alpha{}", n + 1), *alpha));
        }
        let plain = compressibilities.iter().skip(1).all(|d| *d == 0.0);
        let volume = (shear, compressibilities);
        if plain {
            // Terms that are not set would otherwise keep their default moduli.
            for n in terms.len()..3 {
                constants.push((format!("mu{}", n + 1), 0.0));
            }
            return Self::new(line, title, Energy::Model("ogden"), constants, volume);
        }
        let term = |n: usize| {
            format!(
                "mu{n}/alpha{n}*((lambda1^alpha{n} + lambda2^alpha{n} + lambda3^alpha{n})*J^(-alpha{n}/3) - 3)"
            )
        };
        let energy: Vec<String> = (1..=terms.len()).map(term).collect();
        let energy = format!(
            "{} + {}",
            energy.join(" + "),
            powers_of_volume(compressibilities)
        );
        Self::new(line, title, Energy::Formula(energy), constants, volume)
    }

    /// Converts the law to settings, except keys that the user sets. A table is read from the file `place`, or is `text` itself if there is no such
    /// file.
    pub fn reading(self, set: &[String], place: &str, text: &str) -> Reading {
        let key_of = |assignment: &str| {
            assignment
                .split('=')
                .next()
                .unwrap_or_default()
                .trim()
                .to_owned()
        };
        let is_set = |key: &str| set.iter().any(|assignment| key_of(assignment) == key);
        let mut assignments = Vec::new();
        let mut told = Vec::new();
        let mut save = "";
        match &self.energy {
            Energy::Model(model) => assignments.push(format!("material.model={model}")),
            Energy::Formula(energy) => {
                assignments.push("material.model=formula".to_owned());
                assignments.push(format!("material.energy={energy}"));
            }
            Energy::Table(_) => {
                assignments.push("material.model=marlow".to_owned());
                told.clone_from(&assignments);
                let is_file = std::path::Path::new(place).is_file();
                let table = if is_file { place } else { text };
                told.push(format!(
                    "material.table={}",
                    if is_file { place } else { "FILE" }
                ));
                if !is_file {
                    save = " with the block in FILE";
                }
                // The final line break distinguishes a text from a file name.
                assignments.push(format!(
                    "material.table={table}{}",
                    if is_file { "" } else { "\n" }
                ));
            }
        }
        if told.is_empty() {
            told.clone_from(&assignments);
        }
        for (name, value) in &self.constants {
            let key = format!("material.{name}");
            if !is_set(&key) {
                assignments.push(format!("{key}={value}"));
                told.push(format!("{key}={value}"));
            }
        }
        told.extend(
            set.iter()
                .filter(|own| own.starts_with("material."))
                .cloned(),
        );
        let quoted =
            told.iter().map(
                |assignment| match assignment.contains([' ', '*', '(', ';']) {
                    true => format!("--set \"{assignment}\""),
                    false => format!("--set {assignment}"),
                },
            );
        let mut notes = vec![format!(
            "read from {}; the same law in other commands{save}: {}",
            self.title,
            quoted.collect::<Vec<_>>().join(" ")
        )];
        if self.incompressible && !is_set("material.kappa") {
            notes.push(format!(
                "without a compressibility (D = 0, no bulk modulus) the material is incompressible; here the bulk modulus is {INCOMPRESSIBLE_BULK_RATIO} shear moduli, and --incompressible asks the incompressible response"
            ));
        }
        notes.extend(self.unread.notes(self.shear));
        notes.extend(self.notes);
        Reading {
            assignments,
            notes,
            name: self.name,
        }
    }
}

/// Extended tube model of Kaliske and Heinrich: `gc/2 ((1 - delta^2) x/(1 - delta^2 x) + ln(1 - delta^2 x)) + 2 ge/beta^2 (sum lbar^-beta - 3) + (J -
/// 1)^2/d` with `x = I1bar - 3`.
pub(super) fn extended_tube(
    line: usize,
    title: impl Into<String>,
    [gc, delta, ge, beta]: [f64; 4],
    compressibilities: &[f64],
) -> Result<ForeignLaw, Trouble> {
    if beta == 0.0 {
        return Err(Trouble::new(
            line,
            "beta is 0",
            "the constants are Gc, delta, Ge, beta",
        ));
    }
    let energy = format!(
        "let x = I1bar - 3; gc/2*((1 - delta^2)*x/(1 - delta^2*x) + ln(1 - delta^2*x)) \
         + 2*ge/beta^2*((lambda1^(-beta) + lambda2^(-beta) + lambda3^(-beta))*J^(beta/3) - 3) + {}",
        powers_of_volume(compressibilities)
    );
    let constants = [("gc", gc), ("delta", delta), ("ge", ge), ("beta", beta)];
    let constants = constants
        .map(|(name, value)| (name.to_owned(), value))
        .to_vec();
    let shear = gc * (1.0 - 2.0 * delta * delta) + ge;
    Ok(ForeignLaw::new(
        line,
        title,
        Energy::Formula(energy),
        constants,
        (shear, compressibilities),
    ))
}

/// Volumetric part `sum_i (J - 1)^(2 i) / D_i` with `kappa = 2/D_1` and `vol<i> = 1/D_i`.
pub(super) fn powers_of_volume(compressibilities: &[f64]) -> String {
    let higher = compressibilities.iter().enumerate().skip(1);
    let higher = higher
        .filter(|(_, d)| **d != 0.0)
        .map(|(n, _)| format!(" + vol{}*(J - 1)^{}", n + 1, 2 * (n + 1)));
    format!("kappa/2*(J - 1)^2{}", higher.collect::<String>())
}

/// Volumetric part `((J^2 - 1)/2 - ln J) / D` with `kappa = 2/D`.
pub(super) const LOGARITHM_OF_VOLUME: &str = "kappa/2*((J^2 - 1)/2 - ln(J))";
