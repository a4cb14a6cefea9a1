//! Laws with the constants of other programs, and the settings for the same energies.

use super::marlow::Table;
use super::unread::{Chosen, Keyword, Relaxation};
use super::{READ_AS, Reading, Trouble, Unread};
use crate::settings::relaxation::is_of_relaxation;
use crate::settings::softening::{assignments as softening_assignments, is_of_softening};
use crate::shell::quoted;

/// Law that was read from a block.
#[derive(Debug)]
pub(super) struct ForeignLaw {
    /// Line at which the block begins.
    pub line: usize,
    /// Keywords of the block, and its program.
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
    /// Name of a law whose energy is a table; `None` for other laws.
    pub name: Option<String>,
    /// Shear modulus at zero strain; stress. `None` if it does not follow from the constants.
    pub shear: Option<f64>,
    /// Parts of the text that are not read.
    pub unread: Unread,
}

/// Keywords of the blocks that contain the constants of a law.
#[derive(Debug)]
pub(super) struct Blocks {
    law: Keyword,
    series: Option<Keyword>,
    softening: Option<Keyword>,
}

impl Blocks {
    /// Keyword of the block that contains the constant of an assignment.
    pub fn of(&self, assignment: &str) -> &Keyword {
        let name = assignment.strip_prefix("material.").unwrap_or(assignment);
        let name = name.split('=').next().unwrap_or(name);
        let own = match name {
            _ if is_of_relaxation(name) => self.series.as_ref(),
            _ if is_of_softening(name) => self.softening.as_ref(),
            _ => None,
        };
        own.unwrap_or(&self.law)
    }
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

/// Volumetric part of an energy.
#[derive(Clone, Copy, Debug)]
pub(super) enum Volume<'a> {
    /// `sum_i (J - 1)^(2 i) / D_i` with `kappa = 2/D_1`; zero compressibilities are missing terms.
    Powers(&'a [f64]),
    /// Function of `J` with the bulk modulus `kappa`; incompressible without it.
    Function(&'static str, Option<f64>),
}

/// Volumetric function with the bulk modulus `kappa`: `kappa/2 (J - 1)^2`.
pub(super) const SQUARE: &str = "kappa/2*(J - 1)^2";
/// Volumetric function with the bulk modulus `kappa`: `kappa/2 ((J^2 - 1)/2 - ln J)`.
pub(super) const LOGARITHM: &str = "kappa/2*((J^2 - 1)/2 - ln(J))";
/// Volumetric function with the bulk modulus `kappa`: `kappa (J - 1 - ln J)`.
pub(super) const LINEAR: &str = "kappa*(J - 1 - ln(J))";
/// Volumetric function with the bulk modulus `kappa`: `kappa/2 (ln J)^2`.
pub(super) const HENCKY: &str = "kappa/2*ln(J)^2";

/// Bulk modulus for a shear modulus and Poisson's ratio.
pub(super) fn bulk_modulus(shear: f64, poisson: f64) -> f64 {
    2.0 * shear * (1.0 + poisson) / (3.0 * (1.0 - 2.0 * poisson))
}

impl<'a> Volume<'a> {
    /// `kappa/2 ((J^2 - 1)/2 - ln J)` with `kappa = 2/D`; incompressible for `D = 0`.
    pub fn logarithm(compressibility: f64) -> Self {
        Self::Function(
            LOGARITHM,
            Some(2.0 / compressibility).filter(|bulk| bulk.is_finite()),
        )
    }

    /// Formula with `kappa` and `vol<i> = 1/D_i`.
    pub fn energy(self) -> String {
        let Self::Powers(compressibilities) = self else {
            return self.function().unwrap_or_default().to_owned();
        };
        let higher = compressibilities.iter().enumerate().skip(1);
        let higher = higher
            .filter(|(_, d)| **d != 0.0)
            .map(|(n, _)| format!(" + vol{}*(J - 1)^{}", n + 1, 2 * (n + 1)));
        format!("{SQUARE}{}", higher.collect::<String>())
    }

    /// The function, unless it is a sum of several powers.
    fn function(self) -> Option<&'static str> {
        match self {
            Self::Powers(d) => d.iter().skip(1).all(|d| *d == 0.0).then_some(SQUARE),
            Self::Function(function, _) => Some(function),
        }
    }

    /// Bulk modulus; `None` if the material is incompressible.
    fn bulk(self) -> Option<f64> {
        match self {
            Self::Powers(d) if d.iter().all(|d| *d == 0.0) => None,
            Self::Powers(d) if d[0] == 0.0 => Some(0.0),
            Self::Powers(d) => Some(2.0 / d[0]),
            Self::Function(_, bulk) => bulk,
        }
    }
}

impl ForeignLaw {
    /// Creates a law with the bulk modulus of its volumetric part; `shear` is its shear modulus.
    pub fn new(
        line: usize,
        title: impl Into<String>,
        energy: Energy,
        constants: Vec<(String, f64)>,
        (shear, volume): (f64, Volume<'_>),
    ) -> Self {
        let bulk = volume.bulk();
        let mut law = Self {
            incompressible: bulk.is_none(),
            shear: Some(shear).filter(|shear| *shear != 0.0),
            ..Self::of_constants(line, title, energy, constants)
        };
        let bulk = bulk.unwrap_or(INCOMPRESSIBLE_BULK_RATIO * shear.abs());
        law.constants.push(("kappa".to_owned(), bulk));
        if let Volume::Powers(compressibilities) = volume {
            for (n, d) in compressibilities.iter().enumerate().skip(1) {
                if *d != 0.0 {
                    law.constants.push((format!("vol{}", n + 1), 1.0 / d));
                }
            }
        }
        law
    }

    /// Creates a law whose constants determine the bulk modulus too.
    pub fn of_constants(
        line: usize,
        title: impl Into<String>,
        energy: Energy,
        constants: Vec<(String, f64)>,
    ) -> Self {
        Self {
            line,
            title: title.into(),
            energy,
            constants,
            incompressible: false,
            needed: Vec::new(),
            notes: Vec::new(),
            name: None,
            shear: None,
            unread: Unread::default(),
        }
    }

    /// Creates a law from constants `c_ij` of `sum c_ij (I1bar - 3)^i (I2bar - 3)^j`: a law of the library if it has these terms, otherwise a
    /// user-defined energy.
    pub fn polynomial(
        line: usize,
        title: impl Into<String>,
        constants: &[((usize, usize), f64)],
        volume: Volume<'_>,
    ) -> Self {
        let of = |i: usize, j: usize| {
            let found = constants.iter().find(|(own, _)| *own == (i, j));
            found.map_or(0.0, |(_, value)| *value)
        };
        let shear = 2.0 * (of(1, 0) + of(0, 1));
        let counts = |(_, value): &&((usize, usize), f64)| *value != 0.0;
        let only = |function: &str, admitted: &[(usize, usize)]| {
            volume.function() == Some(function)
                && constants
                    .iter()
                    .filter(counts)
                    .all(|(own, _)| admitted.contains(own))
        };
        let energy = volume.energy();
        let volume = (shear, volume);
        if only(LOGARITHM, &[(1, 0)]) && shear > 0.0 {
            let model = Energy::Model("neo-hooke-isochoric");
            return Self::new(line, title, model, named(&[("mu", shear)]), volume);
        }
        if only(SQUARE, &[(1, 0), (0, 1)]) && of(0, 1) != 0.0 {
            let constants = named(&[("c10", of(1, 0)), ("c01", of(0, 1))]);
            let model = Energy::Model("mooney-rivlin-isochoric");
            return Self::new(line, title, model, constants, volume);
        }
        if only(SQUARE, &[(1, 0), (2, 0), (3, 0)]) && of(1, 0) > 0.0 {
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
        terms.push(energy);
        let mut energy = String::new();
        if has(|(i, _)| *i) {
            energy.push_str("let x = I1bar - 3; ");
        }
        if has(|(_, j)| *j) {
            energy.push_str("let y = I2bar - 3; ");
        }
        energy.push_str(&terms.join(" + "));
        Self::new(line, title, Energy::Formula(energy), own, volume)
    }

    /// Ogden's law with moduli of `sum mu_p/alpha_p (...)`.
    pub fn ogden(
        line: usize,
        title: impl Into<String>,
        terms: &[(f64, f64)],
        volume: Volume<'_>,
    ) -> Self {
        let shear = 0.5 * terms.iter().map(|(mu, alpha)| mu * alpha).sum::<f64>();
        let mut constants = Vec::new();
        for (n, (mu, alpha)) in terms.iter().enumerate() {
            constants.push((format!("mu{}", n + 1), *mu));
            constants.push((format!("alpha{}", n + 1), *alpha));
        }
        if volume.function() == Some(SQUARE) && terms.len() <= 6 {
            // Terms that are not set would otherwise keep their default moduli.
            for n in terms.len()..3 {
                constants.push((format!("mu{}", n + 1), 0.0));
            }
            let model = Energy::Model("ogden");
            return Self::new(line, title, model, constants, (shear, volume));
        }
        let term = |n: usize| {
            format!(
                "mu{n}/alpha{n}*((lambda1^alpha{n} + lambda2^alpha{n} + lambda3^alpha{n})*J^(-alpha{n}/3) - 3)"
            )
        };
        let energy: Vec<String> = (1..=terms.len()).map(term).collect();
        let energy = format!("{} + {}", energy.join(" + "), volume.energy());
        let energy = Energy::Formula(energy);
        Self::new(line, title, energy, constants, (shear, volume))
    }

    /// Law of Arruda and Boyce with five terms of its series.
    pub fn arruda_boyce(
        line: usize,
        title: impl Into<String>,
        (mu, locking): (f64, f64),
        volume: Volume<'_>,
    ) -> Self {
        let constants = named(&[("mu", mu), ("locking", locking)]);
        let energy = match volume.function() == Some(LOGARITHM) {
            true => Energy::Model("arruda-boyce"),
            false => Energy::Formula(format!(
                "let b = 1/locking^2; mu*((I1bar - 3)/2 + b*(I1bar^2 - 9)/20 + 11*b^2*(I1bar^3 - 27)/1050 + 19*b^3*(I1bar^4 - 81)/7000 \
                 + 519*b^4*(I1bar^5 - 243)/673750) + {}",
                volume.energy()
            )),
        };
        Self::new(line, title, energy, constants, (mu, volume))
    }

    /// Gent's law with the shear modulus and the limit of `I1bar - 3`.
    pub fn gent(
        line: usize,
        title: impl Into<String>,
        (mu, limit): (f64, f64),
        volume: Volume<'_>,
    ) -> Self {
        let constants = named(&[("mu", mu), ("jm", limit)]);
        let energy = match volume.function() == Some(LOGARITHM) {
            true => Energy::Model("gent"),
            false => Energy::Formula(format!(
                "-mu*jm/2*ln(1 - (I1bar - 3)/jm) + {}",
                volume.energy()
            )),
        };
        Self::new(line, title, energy, constants, (mu, volume))
    }

    /// Foam with terms `mu`, `alpha`, `beta` of `2 mu/alpha^2 (sum lambda^alpha - 3 + (J^(-alpha beta) - 1)/beta)`.
    pub fn foam(line: usize, title: impl Into<String>, terms: &[[f64; 3]]) -> Self {
        let mut constants = Vec::new();
        for place in 1..=terms.len().max(3) {
            let Some([mu, alpha, beta]) = terms.get(place - 1) else {
                constants.push((format!("mu{place}"), 0.0));
                continue;
            };
            constants.push((format!("mu{place}"), *mu));
            constants.push((format!("alpha{place}"), *alpha));
            if terms.len() <= 3 || *beta != 0.0 {
                constants.push((format!("beta{place}"), *beta));
            }
        }
        let term = |(n, [_, _, beta]): (usize, &[f64; 3])| {
            let n = n + 1;
            let volume = match *beta == 0.0 {
                true => format!("- alpha{n}*ln(J)"),
                false => format!("+ (J^(-alpha{n}*beta{n}) - 1)/beta{n}"),
            };
            format!(
                "2*mu{n}/alpha{n}^2*(lambda1^alpha{n} + lambda2^alpha{n} + lambda3^alpha{n} - 3 {volume})"
            )
        };
        let energy = match terms.len() <= 3 {
            true => Energy::Model("hyperfoam"),
            false => {
                let terms = terms.iter().enumerate().map(term);
                Energy::Formula(terms.collect::<Vec<_>>().join(" + "))
            }
        };
        Self::of_constants(line, title, energy, constants)
    }

    /// Returns the law with a further remark for the reader.
    pub fn noted(mut self, note: Option<String>) -> Self {
        self.notes.extend(note);
        self
    }

    /// Keywords of the blocks of the law.
    pub fn blocks(&self) -> Blocks {
        let series = self.unread.relaxation.as_ref();
        Blocks {
            law: (self.title.clone(), self.line),
            series: series.and_then(|own| own.keyword.clone()),
            softening: self
                .unread
                .softening
                .as_ref()
                .map(|own| own.keyword.clone()),
        }
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
        match &self.energy {
            Energy::Model(model) => assignments.push(format!("material.model={model}")),
            Energy::Formula(energy) => {
                assignments.push("material.model=formula".to_owned());
                assignments.push(format!("material.energy={energy}"));
            }
            Energy::Table(_) => {
                assignments.push("material.model=marlow".to_owned());
                // The final line break distinguishes a text from a file name.
                assignments.push(match std::path::Path::new(place).is_file() {
                    true => format!("material.table={place}"),
                    false => format!("material.table={text}\n"),
                });
            }
        }
        for (name, value) in &self.constants {
            let key = format!("material.{name}");
            if !is_set(&key) {
                assignments.push(format!("{key}={value}"));
            }
        }
        let relaxation = self.unread.relaxation.iter();
        let softening = self.unread.softening.iter();
        let relaxation = relaxation.flat_map(Relaxation::assignments);
        let softening = softening.flat_map(|own| softening_assignments(&own.constants));
        for assignment in relaxation.chain(softening) {
            if !is_set(&key_of(&assignment)) {
                assignments.push(assignment);
            }
        }
        let chosen = self.unread.material.as_ref();
        let own = match &self.energy {
            Energy::Model(model) => model,
            Energy::Formula(_) => "a formula",
            Energy::Table(_) => "marlow",
        };
        let further = self.unread.keywords();
        let further: String = further.map(|own| format!(" and {own}")).collect();
        let mut notes = vec![format!(
            "{READ_AS}{own} from {}{further}{}",
            self.title,
            chosen.map_or_else(String::new, Chosen::told)
        )];
        if self.incompressible && !is_set("material.kappa") {
            notes.push(format!(
                "incompressible in its program: a bulk modulus of {INCOMPRESSIBLE_BULK_RATIO} shear moduli is used. `onset criteria` and `onset card` take --incompressible"
            ));
        }
        notes.extend(self.unread.notes(self.shear));
        notes.extend(self.notes);
        if !matches!(self.energy, Energy::Table(_)) {
            let own = set.iter().filter(|own| own.starts_with("material."));
            let sets = assignments.iter().chain(own);
            let sets: Vec<String> = sets
                .map(|own| format!("--set {}", quoted(own.as_ref())))
                .collect();
            notes.push(format!(
                "the same law in other commands: {}",
                sets.join(" ")
            ));
        }
        Reading {
            assignments,
            notes,
            name: self.name,
        }
    }
}

/// Powers of both invariants up to an order, by their sum, the highest power of the first invariant first.
pub(super) fn powers_to(order: usize) -> Vec<(usize, usize)> {
    (1..=order)
        .flat_map(|sum| (0..=sum).map(move |j| (sum - j, j)))
        .collect()
}

/// Converts names and values to the constants of a law.
pub(super) fn named(constants: &[(&str, f64)]) -> Vec<(String, f64)> {
    let named = constants
        .iter()
        .map(|(name, value)| ((*name).to_owned(), *value));
    named.collect()
}

/// Extended tube model of Kaliske and Heinrich: `gc/2 ((1 - delta^2) x/(1 - delta^2 x) + ln(1 - delta^2 x)) + 2 ge/beta^2 (sum lbar^-beta - 3) + (J -
/// 1)^2/d` with `x = I1bar - 3`.
pub(super) fn extended_tube(
    line: usize,
    title: impl Into<String>,
    [gc, delta, ge, beta]: [f64; 4],
    volume: Volume<'_>,
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
        volume.energy()
    );
    let constants = named(&[("gc", gc), ("delta", delta), ("ge", ge), ("beta", beta)]);
    let shear = gc * (1.0 - 2.0 * delta * delta) + ge;
    Ok(ForeignLaw::new(
        line,
        title,
        Energy::Formula(energy),
        constants,
        (shear, volume),
    ))
}

/// Kilian's energy `mu (-(lm^2 - 3) (ln(1 - h) + h) - 2/3 a ((I - 3)/2)^(3/2))` with `h^2 = (I - 3)/(lm^2 - 3)` and `I = (1 - beta) I1bar + beta
/// I2bar`.
pub(super) fn van_der_waals(
    line: usize,
    title: impl Into<String>,
    [mu, locking, a, beta]: [f64; 4],
    volume: Volume<'_>,
) -> Result<ForeignLaw, Trouble> {
    if locking * locking <= 3.0 {
        return Err(Trouble::new(
            line,
            format!("the locking stretch is {locking}; expected more than the root of 3"),
            "the constants are mu, lambda_m, a, beta",
        ));
    }
    // At `I = 3` the powers 3/2 have no finite derivative; nearby, their contribution is below rounding and is dropped.
    let energy = format!(
        "let x = (1 - beta)*I1bar + beta*I2bar - 3; let m = locking^2 - 3; \
         mu*if(x < 1e-14, x/2, -m*(ln(1 - sqrt(x/m)) + sqrt(x/m)) - 2/3*a*(x/2)^1.5) + {}",
        volume.energy()
    );
    let constants = named(&[("mu", mu), ("locking", locking), ("a", a), ("beta", beta)]);
    Ok(ForeignLaw::new(
        line,
        title,
        Energy::Formula(energy),
        constants,
        (mu, volume),
    ))
}
