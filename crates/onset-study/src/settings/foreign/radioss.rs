//! Reader for the rubbers and foams of Radioss and OpenRadioss, `/MAT/LAW42`, `62`, `82`, `92`, `94` and `100`.
//!
//! The energies follow the Altair Radioss Reference Guide and the sources of OpenRadioss.
//!
//! - `LAW42` (`OGDEN`): `sum mu/alpha (sum lbar^alpha - 3) + K/2 (J - 1)^2`, with `I_form = 2` `K (J - 1 - ln J)`.
//! - `LAW62` (`VISC_HYP`): foam with `2 mu/alpha^2` and Poisson's ratios.
//! - `LAW82`: `sum 2 mu/alpha^2 (sum lbar^alpha - 3) + sum (J - 1)^(2i)/D_i`.
//! - `LAW92`: five terms of Arruda and Boyce with `((J^2 - 1)/2 - ln J)/D`.
//! - `LAW94` (`YEOH`) and `LAW100` (`MNF`): polynomials of the isochoric invariants with `sum (J - 1)^(2i)/D_i`.
//!
//! Poisson's ratio 0 means 0.495. `LAW69` is fitted to a curve by the Starter.

use super::fields::{Card, terms};
use super::law::{ForeignLaw, LINEAR, LOGARITHM, SQUARE, Volume, bulk_modulus};
use super::unread::{Chosen, Relaxation};
use super::write::{self, Form, Refusal, Sheet, columns, order, ordered, ratio};
use super::{Program, Trouble, number};
use onset::material::PronyTerm;
use onset_frames::brief;

/// Laws by number and name, and what reads them.
const LAWS: [(&str, &str, Reader); 7] = [
    ("LAW42", "OGDEN", ogden),
    ("LAW62", "VISC_HYP", foam),
    ("LAW69", "LAW69", fitted),
    ("LAW82", "LAW82", ogden_of_shear_moduli),
    ("LAW92", "LAW92", arruda_boyce),
    ("LAW94", "YEOH", yeoh),
    ("LAW100", "MNF", networks),
];

type Reader = fn(&Block<'_>) -> Result<ForeignLaw, Trouble>;

/// Powers of the polynomial of `LAW100` in the order of its fields.
const POWERS: [(usize, usize); 9] = [
    (1, 0),
    (0, 1),
    (2, 0),
    (1, 1),
    (0, 2),
    (3, 0),
    (2, 1),
    (1, 2),
    (0, 3),
];

/// Largest Poisson's ratio of a term of `LAW62`.
const LARGEST_RATIO: f64 = 0.499;

/// Poisson's ratio used in place of 0.
const POISSON: f64 = 0.495;

/// Material with its data lines after the title.
struct Block<'t> {
    line: usize,
    law: String,
    number: String,
    cards: Vec<Card<'t>>,
}

/// Reads the law of the material with the given number, or the first law.
pub(super) fn read(text: &str, material: Option<&str>) -> Result<ForeignLaw, Trouble> {
    let blocks = blocks(text);
    let with_law: Vec<(&Block<'_>, Reader)> = blocks
        .iter()
        .filter_map(|block| Some((block, block.reader()?)))
        .collect();
    let wanted =
        |(block, _): &(&Block<'_>, Reader)| material.is_none_or(|wanted| block.number == wanted);
    let numbers = || with_law.iter().map(|(block, _)| block.number.clone());
    let Some(at) = with_law.iter().position(wanted) else {
        return Err(match (material, blocks.first()) {
            (Some(wanted), _) if !with_law.is_empty() => {
                Trouble::no_such_material(wanted, &numbers().collect::<Vec<_>>())
            }
            (_, Some(block)) => elastic(block).unwrap_or_else(|| {
                let message = format!("/MAT/{} is not supported", brief(&block.law));
                Trouble::new(block.line, message, HINT)
            }),
            (_, None) => Trouble::no_law(Program::Radioss, HINT),
        });
    };
    let (block, reader) = with_law[at];
    let mut law = reader(block)?;
    law.unread.material = Some(Chosen {
        name: block.number.clone(),
        place: at,
        all: numbers().collect(),
    });
    let options = options(text).into_iter();
    let own = options.filter(|(_, number, _)| *number == block.number);
    law.unread
        .parts
        .extend(own.map(|(option, _, line)| (option, line)));
    let unknown = blocks.iter().filter(|other| other.reader().is_none());
    law.unread.parts.extend(unknown.map(|other| {
        let part = format!(
            "material {}, /MAT/{}",
            brief(&other.number),
            brief(&other.law)
        );
        (part, other.line)
    }));
    Ok(law)
}

const HINT: &str = "supported: /MAT/LAW42 (OGDEN), /MAT/LAW62 (VISC_HYP), /MAT/LAW82, /MAT/LAW92, /MAT/LAW94 (YEOH) and /MAT/LAW100 (MNF)";

/// Error for `/MAT/LAW1` (`ELAST`): the moduli are on the line after the density.
fn elastic(block: &Block<'_>) -> Option<Trouble> {
    if !matches!(block.law.as_str(), "LAW1" | "LAW01" | "ELAST") {
        return None;
    }
    let moduli = block.cards.get(1)?.numbers(20).ok()?;
    Trouble::linear(block.line, &format!("/MAT/{}", block.law), moduli)
}

/// Options of materials, such as `/VISC/PRONY/1`: the keyword, the number of the material and the line.
fn options(text: &str) -> Vec<(String, String, usize)> {
    const OF_MATERIALS: [&str; 7] = [
        "VISC",
        "FAIL",
        "HEAT",
        "THERM_STRESS",
        "EOS",
        "NONLOCAL",
        "CREEP",
    ];
    let option = |(n, line): (usize, &str)| {
        let own = line.trim().to_ascii_uppercase();
        let mut parts = own.strip_prefix('/')?.split('/');
        parts.next().filter(|first| OF_MATERIALS.contains(first))?;
        // A number after the number of the material belongs to the option itself.
        let number = parts.find(|part| part.bytes().all(|letter| letter.is_ascii_digit()))?;
        Some((brief(line.trim()).to_owned(), number.to_owned(), n + 1))
    };
    text.lines().enumerate().filter_map(option).collect()
}

/// Splits a text into materials. `#` begins a comment line, `/` a keyword; the first line of a material is its title.
fn blocks(text: &str) -> Vec<Block<'_>> {
    let mut blocks: Vec<Block<'_>> = Vec::new();
    let mut is_title = false;
    let mut is_open = false;
    for (n, line) in text.lines().enumerate() {
        if line.starts_with(['#', '$']) {
            continue;
        }
        if line.starts_with('/') {
            let own = line.trim().to_ascii_uppercase();
            let mut parts = own.split('/').skip(1);
            is_open = parts.next() == Some("MAT");
            is_title = is_open;
            if is_open {
                blocks.push(Block {
                    line: n + 1,
                    law: parts.next().unwrap_or_default().to_owned(),
                    number: parts.next().unwrap_or_default().to_owned(),
                    cards: Vec::new(),
                });
            }
        } else if is_title {
            is_title = false;
        } else if let Some(block) = blocks.last_mut().filter(|_| is_open) {
            block.cards.push(Card {
                line: n + 1,
                text: line,
            });
        }
    }
    blocks
}

impl Block<'_> {
    fn reader(&self) -> Option<Reader> {
        let own = self.law.as_str();
        let found = LAWS
            .iter()
            .find(|(law, name, _)| own == *law || own == *name);
        found.map(|(_, _, reader)| *reader)
    }

    fn title(&self) -> String {
        format!("/MAT/{} of Radioss", self.law)
    }

    fn card(&self, place: usize, fields: &'static str) -> Result<Card<'_>, Trouble> {
        self.cards.get(place).copied().ok_or_else(|| {
            Trouble::new(
                self.line,
                format!(
                    "/MAT/{} has {} lines after its title; line {} is missing",
                    self.law,
                    self.cards.len(),
                    place + 1
                ),
                fields,
            )
        })
    }

    /// Numbers of 20 columns, five on a line, from the given line on; returns the place of the next line.
    fn list(
        &self,
        place: usize,
        count: usize,
        fields: &'static str,
    ) -> Result<(Vec<f64>, usize), Trouble> {
        let lines = count.div_ceil(5);
        let mut numbers = Vec::new();
        for place in place..place + lines {
            numbers.extend(self.card(place, fields)?.numbers::<5>(20)?);
        }
        numbers.truncate(count);
        Ok((numbers, place + lines))
    }

    /// Number of a function that changes the law, or zero.
    fn without_function(&self, card: Card<'_>, field: &str, name: &str) -> Result<(), Trouble> {
        match number(field, card.line)? {
            0.0 => Ok(()),
            value => Err(Trouble::new(
                card.line,
                format!("{name} = {value}: the law depends on a function, which is not supported"),
                "set it to 0 and give constants",
            )),
        }
    }
}

/// A count of terms in a field, at most `most`.
fn count(field: &str, name: &str, line: usize, most: usize) -> Result<usize, Trouble> {
    let value = number(field, line)?;
    match value.fract() == 0.0 && (0.0..=most as f64).contains(&value) {
        true => Ok(value as usize),
        false => Err(Trouble::new(
            line,
            format!("{name} is {value}; expected an integer from 0 to {most}"),
            "check the columns: numbers have 20, integers 10 columns",
        )),
    }
}

fn poisson(value: f64, line: usize) -> Result<f64, Trouble> {
    match value {
        0.0 => Ok(POISSON),
        value if value > -1.0 && value < 0.5 => Ok(value),
        value => Err(Trouble::new(
            line,
            format!("Nu is {value}; expected Poisson's ratio below 0.5"),
            "for rubber 0.49 to 0.4999 is usual",
        )),
    }
}

fn shear_of(terms: &[(f64, f64)]) -> f64 {
    0.5 * terms.iter().map(|(mu, alpha)| mu * alpha).sum::<f64>()
}

fn ogden(block: &Block<'_>) -> Result<ForeignLaw, Trouble> {
    let second = "expected Nu, sigma_cut, funIDbulk, Fscale_bulk, M, I_form";
    let card = block.card(1, second)?;
    let [nu, cut, _, function, _, viscous, form] = card.fields([20, 20, 10, 10, 20, 10, 10]);
    block.without_function(card, function, "funIDbulk")?;
    let nu = poisson(number(nu, card.line)?, card.line)?;
    let cut = number(cut, card.line)?;
    let viscous = count(viscous, "M", card.line, 100)?;
    let form = number(form, card.line)?;
    let (moduli, _) = block.list(2, 10, "expected Mu_1 to Mu_10 on two lines")?;
    let (exponents, place) = block.list(4, 10, "expected alpha_1 to alpha_10 on two lines")?;
    let terms = terms(block.cards[2].line, &moduli, &exponents)?;
    let shear = shear_of(&terms);
    let function = if form >= 2.0 { LINEAR } else { SQUARE };
    let volume = Volume::Function(function, Some(bulk_modulus(shear, nu)));
    let mut law = ForeignLaw::ogden(block.line, block.title(), &terms, volume);
    if cut != 0.0 {
        law.unread.parts.push(("sigma_cut".to_owned(), card.line));
    }
    if viscous > 0 {
        let (moduli, place) = block.list(place, viscous, "expected the shear moduli of M terms")?;
        let (times, _) = block.list(place, viscous, "expected the relaxation times of M terms")?;
        let terms: Vec<(f64, f64)> = moduli.into_iter().zip(times).collect();
        let by = "Radioss adds the viscous moduli to them";
        law.unread.relaxation = Some(Relaxation::added(shear, &terms, by));
    }
    Ok(law)
}

fn foam(block: &Block<'_>) -> Result<ForeignLaw, Trouble> {
    let card = block.card(1, "expected Nu, N, M, mu_max, Flag_Visc, Flag_Rigi")?;
    let [nu, terms, viscous, _, _, rigid] = card.fields([20, 10, 10, 20, 10, 10]);
    let nu = number(nu, card.line)?;
    let terms = count(terms, "N", card.line, 100)?;
    let viscous = count(viscous, "M", card.line, 100)?;
    let rigid = number(rigid, card.line)?;
    let fields = "expected mu_i and alpha_i, N values each, five on a line";
    let (mut moduli, place) = block.list(2, terms, fields)?;
    let (exponents, place) = block.list(place, terms, fields)?;
    let fields = "expected gamma_i and theta_i, M values each, five on a line";
    let (parts, place) = block.list(place, viscous, fields)?;
    let (times, place) = block.list(place, viscous, fields)?;
    // The line with a ratio for each term may be missing.
    let ratios = match block.cards.get(place) {
        Some(_) => block.list(place, terms, "expected nu_i, N values")?.0,
        None => vec![0.0; terms],
    };
    let has_ratios = ratios.iter().any(|ratio| *ratio != 0.0);
    let relaxing: f64 = parts.iter().sum();
    if rigid == 2.0 {
        moduli.iter_mut().for_each(|mu| *mu /= 1.0 - relaxing);
    }
    let mut own = Vec::new();
    for (n, mu) in moduli.iter().enumerate() {
        // Radioss takes 0.499 in place of larger ratios, and the exponent 1 in place of 0.
        let ratio = if has_ratios { ratios[n] } else { nu }.min(LARGEST_RATIO);
        let exponent = if exponents[n] == 0.0 {
            1.0
        } else {
            exponents[n]
        };
        own.push([*mu, exponent, ratio / (1.0 - 2.0 * ratio)]);
    }
    if own.is_empty() {
        return Err(Trouble::new(
            card.line,
            "N, the number of terms, is 0",
            fields,
        ));
    }
    let mut law = ForeignLaw::foam(block.line, block.title(), &own);
    law.shear = Some(own.iter().map(|[mu, _, _]| mu).sum());
    if viscous > 0 {
        // The foam has no separate deviatoric energy.
        let term = |(part, time): (&f64, f64)| PronyTerm {
            shear: *part,
            bulk: *part,
            time,
        };
        law.unread.relaxation = Some(Relaxation {
            terms: Some(parts.iter().zip(times).map(term).collect()),
            is_long_term: false,
            by: "the convention of LAW62",
            keyword: None,
        });
    }
    Ok(law)
}

fn fitted(block: &Block<'_>) -> Result<ForeignLaw, Trouble> {
    Err(Trouble::new(
        block.line,
        "the Starter fits the constants of /MAT/LAW69 to a curve",
        "write mu_p and alpha_p, which the Starter prints in its listing, as /MAT/LAW42",
    ))
}

fn ogden_of_shear_moduli(block: &Block<'_>) -> Result<ForeignLaw, Trouble> {
    let card = block.card(1, "expected N and Nu, columns 1 to 10 and 21 to 40")?;
    let [terms, _, nu] = card.fields([10, 10, 20]);
    let terms = count(terms, "N", card.line, 100)?;
    let nu = number(nu, card.line)?;
    let fields = "expected mu_i, alpha_i and D_i, N values each, five on a line";
    let (moduli, place) = block.list(2, terms, fields)?;
    let (exponents, place) = block.list(place, terms, fields)?;
    let mut compressibilities = match block.cards.get(place) {
        Some(_) => block.list(place, terms, fields)?.0,
        None => vec![0.0; terms],
    };
    // Radioss ends at the first term without a modulus or an exponent.
    let own = moduli.iter().zip(&exponents);
    let own: Vec<(f64, f64)> = own
        .take_while(|(mu, alpha)| **mu != 0.0 && **alpha != 0.0)
        .map(|(mu, alpha)| (2.0 * mu / alpha, *alpha))
        .collect();
    if own.is_empty() {
        return Err(Trouble::new(
            card.line,
            "mu_i or alpha_i is 0 in every term",
            fields,
        ));
    }
    compressibilities.truncate(own.len());
    let nu = match nu {
        0.0 if compressibilities[0] > 0.0 => None,
        0.5 => Some(POISSON),
        nu => Some(poisson(nu, card.line)?),
    };
    if let Some(nu) = nu {
        compressibilities[0] = 2.0 / bulk_modulus(shear_of(&own), nu);
    }
    let volume = Volume::Powers(&compressibilities);
    Ok(ForeignLaw::ogden(block.line, block.title(), &own, volume))
}

fn arruda_boyce(block: &Block<'_>) -> Result<ForeignLaw, Trouble> {
    let card = block.card(1, "expected mu, D, lambda_m")?;
    let [mu, mut compressibility, mut locking] = card.numbers(20)?;
    if locking == 0.0 {
        locking = 7.0;
    }
    if let Some(card) = block.cards.get(2) {
        let [_, function, nu] = card.fields([10, 10, 20]);
        block.without_function(*card, function, "fct_ID")?;
        if compressibility == 0.0 {
            let nu = poisson(number(nu, card.line)?, card.line)?;
            compressibility = 2.0 / bulk_modulus(shear_of_chains(mu, locking), nu);
        }
    }
    if compressibility == 0.0 {
        compressibility = 2.0 / bulk_modulus(shear_of_chains(mu, locking), POISSON);
    }
    let volume = Volume::logarithm(compressibility);
    let law = ForeignLaw::arruda_boyce(block.line, block.title(), (mu, locking), volume);
    Ok(law.noted(Some(
        "the documented volumetric energy ((J^2 - 1)/2 - ln J)/D is read; OpenRadioss has its pressure divided by J, which is equal at small changes of volume"
            .to_owned(),
    )))
}

/// Shear modulus at small strains of the series of Arruda and Boyce.
fn shear_of_chains(mu: f64, locking: f64) -> f64 {
    let x = locking.powi(-2);
    let series = 1.0 + x * (0.6 + x * (99.0 / 175.0 + x * (513.0 / 875.0 + x * 42039.0 / 67375.0)));
    mu * series
}

/// Compressibilities as Radioss takes them: without `D_1` Poisson's ratio 0.495, and no other terms.
fn filled(shear: f64, compressibilities: [f64; 3]) -> [f64; 3] {
    match compressibilities[0] == 0.0 {
        true => [2.0 / bulk_modulus(shear, POISSON), 0.0, 0.0],
        false => compressibilities,
    }
}

fn yeoh(block: &Block<'_>) -> Result<ForeignLaw, Trouble> {
    let [c10, c20, c30] = block
        .card(2, "expected C10, C20, C30 after a blank line")?
        .numbers(20)?;
    let compressibilities = block.card(3, "expected D1, D2, D3")?.numbers(20)?;
    let constants = [((1, 0), c10), ((2, 0), c20), ((3, 0), c30)];
    let d = filled(2.0 * c10, compressibilities);
    let volume = Volume::Powers(&d);
    Ok(ForeignLaw::polynomial(
        block.line,
        block.title(),
        &constants,
        volume,
    ))
}

fn networks(block: &Block<'_>) -> Result<ForeignLaw, Trouble> {
    let card = block.card(1, "expected N_net, Flag_HE, Flag_Cr")?;
    let [networks, form, creep] = card.numbers(10)?;
    let (powers, lines): (&[(usize, usize)], &[usize]) = match form {
        0.0 | 1.0 => (&POWERS, &[5, 4, 3]),
        3.0 => (&[(1, 0)], &[2]),
        4.0 => (&[(1, 0), (0, 1)], &[3]),
        5.0 => (&[(1, 0), (2, 0), (3, 0)], &[4]),
        _ => {
            return Err(Trouble::new(
                card.line,
                format!("Flag_HE is {form}, which is not supported"),
                "supported: 1 (polynomial), 3 (neo-Hooke), 4 (Mooney-Rivlin) and 5 (Yeoh)",
            ));
        }
    };
    let mut numbers = Vec::new();
    for (n, count) in lines.iter().enumerate() {
        let own = block.card(2 + n, "expected the constants C_ij and D_i of Flag_HE")?;
        numbers.extend_from_slice(&own.numbers::<5>(20)?[..*count]);
    }
    let constants: Vec<_> = powers
        .iter()
        .copied()
        .zip(numbers.iter().copied())
        .collect();
    let mut compressibilities = [0.0; 3];
    for (own, value) in compressibilities.iter_mut().zip(&numbers[powers.len()..]) {
        *own = *value;
    }
    let linear = constants.iter().filter(|((i, j), _)| i + j == 1);
    let shear = 2.0 * linear.map(|(_, value)| value).sum::<f64>();
    let d = filled(shear, compressibilities);
    let volume = Volume::Powers(&d);
    let mut law = ForeignLaw::polynomial(block.line, block.title(), &constants, volume);
    for (name, value) in [("N_net", networks), ("Flag_Cr", creep)] {
        if value != 0.0 {
            law.unread.parts.push((name.to_owned(), card.line));
        }
    }
    Ok(law)
}

/// Writes a law as a material.
pub(super) fn write(sheet: &Sheet) -> Result<write::Block, Refusal> {
    let compressibility = || Ok(vec![2.0 / sheet.required_bulk()?]);
    let (law, lines, function) = match &sheet.form {
        Form::Polynomial(constants) => match order(constants) {
            (1, _) => {
                let values = ordered(constants, &[(1, 0), (0, 1)])?;
                let terms = [(2.0 * values[0], 2.0), (-2.0 * values[1], -2.0)];
                let terms: Vec<_> = terms.into_iter().filter(|(mu, _)| *mu != 0.0).collect();
                ("LAW42", law_42(sheet, &terms)?, Some(SQUARE))
            }
            (2 | 3, true) => {
                let values = ordered(constants, &[(1, 0), (2, 0), (3, 0)])?;
                let lines = vec![
                    String::new(),
                    columns(&values),
                    columns(&compressibility()?),
                ];
                ("LAW94", lines, Some(SQUARE))
            }
            _ => {
                let values = ordered(constants, &POWERS)?;
                let flags = format!("{:>10}{:>10}{:>10}", 0, 1, 0);
                let lines = vec![
                    flags,
                    columns(&values[..5]),
                    columns(&values[5..]),
                    columns(&compressibility()?),
                ];
                ("LAW100", lines, Some(SQUARE))
            }
        },
        Form::Ogden(terms) => ("LAW42", law_42(sheet, terms)?, Some(SQUARE)),
        Form::ArrudaBoyce(mu, locking) => {
            let values = [*mu, compressibility()?[0], *locking];
            (
                "LAW92",
                vec![columns(&values), String::new()],
                Some(LOGARITHM),
            )
        }
        Form::Gent(..) => return Err(Refusal::Lacks),
        Form::Foam(terms) => {
            let mut lines = vec![format!("{:>20}{:>10}{:>10}", 0, terms.len(), 0)];
            let ratios = terms.iter().map(|[_, _, beta]| ratio(*beta));
            let ratios = ratios.collect::<Result<Vec<f64>, Refusal>>()?;
            if ratios.iter().any(|ratio| *ratio > LARGEST_RATIO) {
                return Err(Refusal::Constants(
                    "LAW62 allows Poisson's ratios up to 0.499, which a beta of the law exceeds"
                        .to_owned(),
                ));
            }
            let moduli: Vec<f64> = terms.iter().map(|[mu, _, _]| *mu).collect();
            let exponents: Vec<f64> = terms.iter().map(|[_, alpha, _]| *alpha).collect();
            for values in [moduli, exponents, ratios] {
                lines.extend(values.chunks(5).map(columns));
            }
            ("LAW62", lines, None)
        }
    };
    let head = [format!("/MAT/{law}/1"), "law".to_owned(), columns(&[1.0])];
    Ok(write::Block {
        lines: head.into_iter().chain(lines).collect(),
        function,
        notes: Vec::new(),
    })
}

/// Lines of `LAW42` after the density.
fn law_42(sheet: &Sheet, terms: &[(f64, f64)]) -> Result<Vec<String>, Refusal> {
    if terms.len() > 10 {
        return Err(Refusal::Lacks);
    }
    let (moduli, exponents): (Vec<f64>, Vec<f64>) = terms.iter().copied().unzip();
    let mut lines = vec![columns(&[sheet.poisson()?])];
    for values in [moduli, exponents] {
        for half in 0..2 {
            let own = values.chunks(5).nth(half).unwrap_or_default();
            lines.push(columns(own));
        }
    }
    Ok(lines)
}
