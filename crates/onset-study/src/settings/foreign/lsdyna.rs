//! Reader for the rubbers and foams of LS-DYNA, `*MAT_006`, `*MAT_027`, `*MAT_077_H`, `*MAT_077_O`, `*MAT_127` and `*MAT_177`.
//!
//! The energies follow the LS-DYNA Keyword User's Manual, volume II, and its Theory Manual.
//!
//! - `*MAT_027`: `A (I1 - 3) + B (I2 - 3) + C (I3^-2 - 1) + D (I3 - 1)^2` of the whole deformation, with `C = A/2 + B` and `D` from Poisson's ratio.
//! - `*MAT_077_H`: polynomial of the isochoric invariants with `K/2 (J - 1)^2` (the hydrostatic work of Sussman and Bathe, which the manual cites).
//! - `*MAT_077_O`: `sum mu/alpha (sum lbar^alpha - 3) + K (J - 1 - ln J)`.
//! - `*MAT_127`: five terms of Arruda and Boyce with the number of links, and `K/2 (J - 1)^2`.
//! - `*MAT_177`: `sum C/b (sum lambda^b - 3 + (J^(-n b) - 1)/n)`.

use super::fields::{Card, terms};
use super::law::{Energy, ForeignLaw, LINEAR, SQUARE, Volume, bulk_modulus, named};
use super::unread::{Chosen, Relaxation, Unread};
use super::write::{self, Form, Refusal, Sheet, columns, ordered};
use super::{Program, Trouble, number};
use onset_frames::brief;

/// Laws by name and by number, and what reads them.
const LAWS: [(&str, &str, Reader); 6] = [
    ("VISCOELASTIC", "006", viscoelastic),
    ("HYPERELASTIC_RUBBER", "077_H", polynomial),
    ("OGDEN_RUBBER", "077_O", ogden),
    ("MOONEY-RIVLIN_RUBBER", "027", mooney_rivlin),
    ("ARRUDA_BOYCE_RUBBER", "127", arruda_boyce),
    ("HILL_FOAM", "177", hill),
];

/// Powers of the constants of `*MAT_077_H` in the order of its fields.
const POWERS: [(usize, usize); 6] = [(1, 0), (0, 1), (1, 1), (2, 0), (0, 2), (3, 0)];

type Reader = fn(&Block<'_>) -> Result<ForeignLaw, Trouble>;

/// Keyword with its data lines.
struct Block<'t> {
    line: usize,
    /// Keyword in capitals, without options and without a suffix for the width of fields.
    keyword: String,
    width: usize,
    cards: Vec<Card<'t>>,
}

/// Reads the law of the material with the given number, or the first law.
pub(super) fn read(text: &str, material: Option<&str>) -> Result<ForeignLaw, Trouble> {
    let blocks = blocks(text);
    let with_law: Vec<(&Block<'_>, Reader)> = blocks
        .iter()
        .filter_map(|block| Some((block, block.reader()?)))
        .collect();
    let numbers: Vec<&str> = with_law.iter().map(|(block, _)| block.number()).collect();
    let at = match material {
        None => 0,
        Some(wanted) => numbers
            .iter()
            .position(|number| *number == wanted)
            .ok_or_else(|| Trouble::no_such_material(wanted, &numbers))?,
    };
    let Some((block, reader)) = with_law.get(at) else {
        return Err(no_law(&blocks));
    };
    let mut law = reader(block)?;
    law.unread.material = Some(Chosen {
        name: block.number().to_owned(),
        place: at,
        all: numbers.iter().map(|own| (*own).to_owned()).collect(),
    });
    let added = blocks
        .iter()
        .filter(|other| other.keyword.starts_with("MAT_ADD") && other.number() == block.number());
    let added = added.map(|other| (format!("*{}", brief(&other.keyword)), other.line));
    law.unread.parts.extend(added);
    let unknown = blocks.iter().filter(|other| {
        let is_law = other.keyword.starts_with("MAT_") && !other.keyword.starts_with("MAT_ADD");
        is_law && other.reader().is_none()
    });
    let unknown = unknown.map(|other| {
        let number = brief(other.number());
        (
            format!("material {number}, *{}", brief(&other.keyword)),
            other.line,
        )
    });
    law.unread.parts.extend(unknown);
    Ok(law)
}

/// Error for a text without a supported law.
fn no_law(blocks: &[Block<'_>]) -> Trouble {
    const HINT: &str = "supported: *MAT_HYPERELASTIC_RUBBER (*MAT_077_H), *MAT_OGDEN_RUBBER (*MAT_077_O), *MAT_MOONEY-RIVLIN_RUBBER (*MAT_027), \
                        *MAT_ARRUDA_BOYCE_RUBBER (*MAT_127), *MAT_HILL_FOAM (*MAT_177) and *MAT_VISCOELASTIC (*MAT_006)";
    let other = blocks
        .iter()
        .find(|block| block.keyword.starts_with("MAT_") && !block.keyword.starts_with("MAT_ADD"));
    match other {
        Some(block) if is_simplified(&block.keyword) => Trouble::new(
            block.line,
            format!(
                "*{} is a table of tests and not a law with constants",
                brief(&block.keyword)
            ),
            "fit a law with constants to the table",
        ),
        Some(block) => elastic(block).unwrap_or_else(|| {
            let message = format!("*{} is not supported", brief(&block.keyword));
            Trouble::new(block.line, message, HINT)
        }),
        None => Trouble::no_law(Program::LsDyna, HINT),
    }
}

/// Error for `*MAT_ELASTIC`, whose moduli are not a law of large strains.
fn elastic(block: &Block<'_>) -> Option<Trouble> {
    if !matches!(block.keyword.as_str(), "MAT_ELASTIC" | "MAT_001" | "MAT_1") {
        return None;
    }
    let [_, _, young, poisson] = block.cards.first()?.numbers(block.width).ok()?;
    Trouble::linear(block.line, &format!("*{}", block.keyword), [young, poisson])
}

fn is_simplified(keyword: &str) -> bool {
    keyword.starts_with("MAT_SIMPLIFIED_RUBBER") || keyword.starts_with("MAT_181")
}

/// Splits a text into keywords with their data lines. `$` begins a comment line; a title line belongs to the option `_TITLE`.
fn blocks(text: &str) -> Vec<Block<'_>> {
    let mut blocks: Vec<Block<'_>> = Vec::new();
    let mut usual_width = 10;
    let mut is_title = false;
    for (n, line) in text.lines().enumerate() {
        if line.starts_with('$') {
            continue;
        }
        if let Some(keyword) = line.strip_prefix('*') {
            let own = keyword.to_ascii_uppercase();
            let plain: String = own.split_whitespace().collect();
            if plain.starts_with("KEYWORD") && plain.contains("LONG=Y") {
                usual_width = 20;
            }
            let own = own.split_whitespace().next().unwrap_or_default();
            let width = match own.chars().last() {
                Some('+') => 20,
                Some('-' | '%') => 10,
                _ => usual_width,
            };
            let own = own.trim_end_matches(['+', '-', '%']);
            is_title = own.ends_with("_TITLE");
            blocks.push(Block {
                line: n + 1,
                keyword: own.trim_end_matches("_TITLE").to_owned(),
                width,
                cards: Vec::new(),
            });
        } else if is_title {
            is_title = false;
        } else if let Some(block) = blocks.last_mut() {
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
        let own = self.keyword.strip_prefix("MAT_")?;
        let is_own = |name: &str, number: &str| {
            own == name || own == number || own == number.trim_start_matches('0')
        };
        let found = LAWS.iter().find(|(name, number, _)| is_own(name, number));
        found.map(|(_, _, reader)| *reader)
    }

    fn title(&self) -> String {
        format!("*{} of LS-DYNA", self.keyword)
    }

    /// Number of the material.
    fn number(&self) -> &str {
        let first = self.cards.first();
        first.map_or("", |card| card.fields([self.width; 1])[0])
    }

    fn card(&self, place: usize, fields: &'static str) -> Result<Card<'_>, Trouble> {
        self.cards.get(place).copied().ok_or_else(|| {
            Trouble::new(
                self.line,
                format!(
                    "*{} has {} data lines; line {} is missing",
                    self.keyword,
                    self.cards.len(),
                    place + 1
                ),
                fields,
            )
        })
    }

    fn numbers<const N: usize>(
        &self,
        place: usize,
        fields: &'static str,
    ) -> Result<[f64; N], Trouble> {
        self.card(place, fields)?.numbers(self.width)
    }

    /// Shear relaxation moduli and decay constants after the given line, which add to the constants of the law.
    fn relaxation(&self, from: usize, shear: f64) -> Result<Option<Relaxation>, Trouble> {
        let mut terms = Vec::new();
        for card in self.cards.iter().skip(from) {
            let [modulus, decay] = card.numbers(self.width)?;
            if modulus != 0.0 {
                terms.push((modulus, decay.recip()));
            }
        }
        let by = "LS-DYNA adds G1, G2, ... to them";
        Ok((!terms.is_empty()).then(|| Relaxation::added(shear, &terms, by)))
    }

    /// Numbers of a fit, which LS-DYNA makes while it reads.
    fn fitted(&self, line: usize, field: &str) -> Trouble {
        Trouble::new(
            line,
            format!(
                "{field}: LS-DYNA fits the constants of *{} to a curve",
                self.keyword
            ),
            "paste the constants that LS-DYNA prints in d3hsp, with N = 0 (without a curve)",
        )
    }
}

/// Note on the volumetric energy, which keyword decks do not show.
fn note_on(function: &str) -> Option<String> {
    Some(format!(
        "the volumetric energy of LS-DYNA is taken as {function}; with another function of the same bulk modulus, only states with a change of volume differ"
    ))
}

const FIRST_OF_77: &str = "expected MID, RO, PR, N, NV, G, SIGF, REF";

/// First lines of both forms of `*MAT_077`: Poisson's ratio, the place of the constants, and unread parts.
fn head(block: &Block<'_>) -> Result<(f64, usize, Unread), Trouble> {
    let card = block.card(0, FIRST_OF_77)?;
    let fields = card.fields([block.width; 8]);
    let [poisson, fit, friction, limit] =
        [fields[2], fields[3], fields[5], fields[6]].map(|field| number(field, card.line));
    let (poisson, fit) = (poisson?, fit?);
    if fields[2].is_empty() {
        return Err(Trouble::new(
            card.line,
            "PR, Poisson's ratio, is missing",
            FIRST_OF_77,
        ));
    }
    if fit > 0.0 {
        return Err(block.fitted(card.line, &format!("N = {fit}")));
    }
    if fit < 0.0 {
        return Err(Trouble::new(
            card.line,
            format!("N = {fit}: the constants are curves of the temperature"),
            "give the constants at one temperature, with N = 0",
        ));
    }
    let mut unread = Unread::default();
    if friction? != 0.0 || limit? != 0.0 {
        unread.parts.push(("G and SIGF".to_owned(), card.line));
    }
    let mut place = 1;
    if poisson < 0.0 {
        let card = block.card(place, "expected TBHYS, LCBI, LCPL, WBI, WPL, D1, D2, D3")?;
        let [table, _, _, _, _, compressibilities @ ..] = card.numbers::<8>(block.width)?;
        if compressibilities.iter().any(|d| *d != 0.0) {
            return Err(Trouble::new(
                card.line,
                "D1, D2 or D3 is set, whose energy the manual does not give",
                "give Poisson's ratio PR instead",
            ));
        }
        if table != 0.0 {
            unread.parts.push(("TBHYS".to_owned(), card.line));
        }
        place = 2;
    }
    Ok((poisson.abs(), place, unread))
}

/// Volumetric part with a function of `J`; Poisson's ratio 0.5 means incompressible.
fn volume(
    line: usize,
    function: &'static str,
    shear: f64,
    poisson: f64,
) -> Result<Volume<'static>, Trouble> {
    if poisson > 0.5 {
        return Err(Trouble::new(
            line,
            format!("PR is {poisson}; expected Poisson's ratio up to 0.5"),
            "for rubber 0.49 to 0.4999 is usual",
        ));
    }
    let bulk = (poisson < 0.5).then(|| bulk_modulus(shear, poisson));
    Ok(Volume::Function(function, bulk))
}

fn polynomial(block: &Block<'_>) -> Result<ForeignLaw, Trouble> {
    let (poisson, place, unread) = head(block)?;
    let fields = "expected C10, C01, C11, C20, C02, C30";
    let values = block.numbers::<6>(place, fields)?;
    let line = block.cards[place].line;
    let shear = 2.0 * (values[0] + values[1]);
    if shear == 0.0 {
        return Err(Trouble::new(line, "C10 + C01 is 0", fields));
    }
    let constants: Vec<_> = POWERS.into_iter().zip(values).collect();
    let volume = volume(block.cards[0].line, SQUARE, shear, poisson)?;
    let law = ForeignLaw::polynomial(block.line, block.title(), &constants, volume);
    let mut law = law.noted(note_on(SQUARE));
    law.unread = unread;
    law.unread.relaxation = block.relaxation(place + 1, shear)?;
    Ok(law)
}

fn ogden(block: &Block<'_>) -> Result<ForeignLaw, Trouble> {
    let (poisson, place, unread) = head(block)?;
    let moduli = block.numbers::<8>(place, "expected MU1, MU2, ..., MU8")?;
    let exponents = block.numbers::<8>(place + 1, "expected ALPHA1, ALPHA2, ..., ALPHA8")?;
    let terms = terms(block.cards[place].line, &moduli, &exponents)?;
    let shear = 0.5 * terms.iter().map(|(mu, alpha)| mu * alpha).sum::<f64>();
    let volume = volume(block.cards[0].line, LINEAR, shear, poisson)?;
    let law = ForeignLaw::ogden(block.line, block.title(), &terms, volume);
    let mut law = law.noted(note_on(LINEAR));
    law.unread = unread;
    law.unread.relaxation = block.relaxation(place + 2, shear)?;
    Ok(law)
}

fn mooney_rivlin(block: &Block<'_>) -> Result<ForeignLaw, Trouble> {
    let fields = "expected MID, RO, PR, A, B, REF";
    let [_, _, poisson, a, b] = block.numbers(0, fields)?;
    let line = block.cards[0].line;
    if a == 0.0 && b == 0.0 {
        return Err(block.fitted(line, "A = B = 0"));
    }
    let shear = 2.0 * (a + b);
    let incompressible = volume(line, SQUARE, shear, poisson)?;
    if poisson == 0.5 {
        let constants = [((1, 0), a), ((0, 1), b)];
        return Ok(ForeignLaw::polynomial(
            block.line,
            block.title(),
            &constants,
            incompressible,
        ));
    }
    let d = (a * (5.0 * poisson - 2.0) + b * (11.0 * poisson - 5.0)) / (2.0 - 4.0 * poisson);
    let mut law = ForeignLaw::of_constants(
        block.line,
        block.title(),
        Energy::Formula(
            "a*(I1 - 3) + b*(I2 - 3) + (a/2 + b)*(I3^(-2) - 1) + d*(I3 - 1)^2".to_owned(),
        ),
        named(&[("a", a), ("b", b), ("d", d)]),
    );
    law.shear = Some(shear);
    Ok(law)
}

fn arruda_boyce(block: &Block<'_>) -> Result<ForeignLaw, Trouble> {
    let fields = "expected MID, RO, K, G, N";
    let [_, _, bulk, shear, links] = block.numbers(0, fields)?;
    let line = block.cards[0].line;
    if bulk <= 0.0 || shear <= 0.0 || links <= 0.0 {
        return Err(Trouble::new(
            line,
            format!("K is {bulk}, G is {shear} and N is {links}; expected positive numbers"),
            fields,
        ));
    }
    let volume = Volume::Function(SQUARE, Some(bulk));
    let constants = (shear, links.sqrt());
    let law = ForeignLaw::arruda_boyce(block.line, block.title(), constants, volume);
    let mut law = law.noted(note_on(SQUARE));
    if let Some(card) = block.cards.get(1)
        && card.numbers::<1>(block.width)?[0] != 0.0
    {
        law.unread.parts.push(("LCID".to_owned(), card.line));
    }
    law.unread.relaxation = block.relaxation(2, shear)?;
    Ok(law)
}

/// Linear viscoelasticity in rate form: `G(t) = GI + (G0 - GI) exp(-BETA t)`, elastic in volume.
fn viscoelastic(block: &Block<'_>) -> Result<ForeignLaw, Trouble> {
    let fields = "expected MID, RO, BULK, G0, GI, BETA";
    let [_, _, bulk, short, long, decay] = block.numbers(0, fields)?;
    let line = block.cards[0].line;
    if !(bulk > 0.0 && long > 0.0 && short >= long && decay > 0.0) {
        return Err(Trouble::new(
            line,
            format!(
                "BULK is {bulk}, G0 is {short}, GI is {long} and BETA is {decay}; expected positive numbers with G0 at least GI"
            ),
            "a law with GI = 0 relaxes completely, as a fluid",
        ));
    }
    let mut law = ForeignLaw::of_constants(
        block.line,
        block.title(),
        Energy::Model("hypoelastic-jaumann"),
        named(&[("mu", long), ("kappa", bulk)]),
    );
    law.shear = Some(long);
    let terms = [(short - long, decay.recip())];
    law.unread.relaxation = Some(Relaxation::added(
        long,
        &terms,
        "GI is the modulus after relaxation",
    ));
    Ok(law)
}

fn hill(block: &Block<'_>) -> Result<ForeignLaw, Trouble> {
    let [_, _, _, exponent, _, curve] = block.numbers(0, "expected MID, RO, K, N, MU, LCID")?;
    let line = block.cards[0].line;
    if curve != 0.0 {
        return Err(block.fitted(line, &format!("LCID = {curve}")));
    }
    let constants = block.numbers::<8>(1, "expected C1, C2, ..., C8")?;
    let exponents = block.numbers::<8>(2, "expected B1, B2, ..., B8")?;
    let terms = terms(block.cards[1].line, &constants, &exponents)?;
    let terms: Vec<[f64; 3]> = terms
        .iter()
        .map(|(c, b)| [0.5 * c * b, *b, exponent])
        .collect();
    let mut law = ForeignLaw::foam(block.line, block.title(), &terms);
    if let Some(card) = block.cards.get(3)
        && card
            .numbers::<2>(block.width)?
            .iter()
            .any(|value| *value != 0.0)
    {
        law.unread.parts.push(("R and M".to_owned(), card.line));
    }
    Ok(law)
}

/// Writes a law as a keyword with fields of 20 columns.
pub(super) fn write(sheet: &Sheet) -> Result<write::Block, Refusal> {
    let (keyword, cards, function) = match &sheet.form {
        Form::Polynomial(constants) => {
            let values = ordered(constants, &POWERS)?;
            let head = vec![1.0, sheet.poisson()?, 0.0];
            ("HYPERELASTIC_RUBBER", vec![head, values], Some(SQUARE))
        }
        Form::Ogden(terms) if terms.len() > 8 => return Err(Refusal::Lacks),
        Form::Ogden(terms) => {
            let (moduli, exponents) = terms.iter().copied().unzip();
            let head = vec![1.0, sheet.poisson()?, 0.0];
            ("OGDEN_RUBBER", vec![head, moduli, exponents], Some(LINEAR))
        }
        Form::ArrudaBoyce(mu, locking) => {
            let head = vec![1.0, sheet.required_bulk()?, *mu, locking * locking];
            ("ARRUDA_BOYCE_RUBBER", vec![head, vec![0.0]], Some(SQUARE))
        }
        Form::Gent(..) => return Err(Refusal::Lacks),
        Form::Foam(terms) => {
            let exponent = terms[0][2];
            if terms.iter().any(|[_, _, beta]| *beta != exponent) {
                return Err(Refusal::Constants(
                    "*MAT_HILL_FOAM has one volumetric exponent, and beta differs between the terms".to_owned(),
                ));
            }
            let bulk = terms
                .iter()
                .map(|[mu, _, beta]| 2.0 * mu * (1.0 / 3.0 + beta));
            let head = vec![1.0, bulk.sum(), exponent];
            let constants = terms
                .iter()
                .map(|[mu, alpha, _]| 2.0 * mu / alpha)
                .collect();
            let exponents = terms.iter().map(|[_, alpha, _]| *alpha).collect();
            ("HILL_FOAM", vec![head, constants, exponents], None)
        }
    };
    let mut lines = vec![format!("*MAT_{keyword}+")];
    for (n, card) in cards.iter().enumerate() {
        let number = if n == 0 {
            format!("{:>20}", 1)
        } else {
            String::new()
        };
        lines.push(number + &columns(card));
    }
    Ok(write::Block {
        lines,
        function,
        notes: Vec::new(),
    })
}
