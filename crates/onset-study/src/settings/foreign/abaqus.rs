//! Reader for `*HYPERELASTIC`, `*HYPERFOAM` and `*ANISOTROPIC HYPERELASTIC` with their data lines.
//!
//! The energies follow the Abaqus Theory Guide:
//!
//! - polynomials of `I1bar - 3` and `I2bar - 3` with `(J - 1)^(2i)/D_i`,
//! - Ogden and foams with `2 mu_i/alpha_i^2`,
//! - Arruda-Boyce, Van der Waals and Holzapfel-Gasser-Ogden with `((J^2 - 1)/2 - ln J)/D`.
//!
//! CalculiX reads the same keywords with N to 3, and fills in zero compressibilities.

use super::law::{Energy, ForeignLaw, LOGARITHM, SQUARE, Volume, named, powers_to, van_der_waals};
use super::marlow::{self, Test};
use super::unread::{Chosen, Relaxation, Softening, Unread};
use super::write::{self, Form, Refusal, Sheet, list, order, ordered};
use super::{Program, Trouble, number};
use onset::material::PronyTerm;
use onset_frames::{brief, cut};

/// Number of constants on a data line.
const CONSTANTS_PER_LINE: usize = 8;

/// Keyword line with its data lines.
struct Block<'t> {
    program: Program,
    line: usize,
    keyword: String,
    /// Keyword in the spelling of the file.
    title: String,
    /// Parameters after the keyword, in capitals, with their values.
    parameters: Vec<(String, Option<String>)>,
    data: Vec<(usize, &'t str)>,
}

/// Smallest compressibility that CalculiX keeps.
const CALCULIX_SMALLEST: f64 = 1e-10;

const LAWS: [&str; 3] = ["HYPERELASTIC", "HYPERFOAM", "ANISOTROPICHYPERELASTIC"];

fn is_law(block: &Block<'_>) -> bool {
    LAWS.contains(&block.keyword.as_str())
}

/// Keyword of a block in a message.
fn title(block: &Block<'_>) -> String {
    match is_law(block) {
        true => block.title.clone(),
        false => cut(&block.title),
    }
}

/// Splits the blocks into materials. Blocks before the first `*MATERIAL` form a material without a name.
fn materials<'b, 't>(blocks: &'b [Block<'t>]) -> Vec<(String, &'b [Block<'t>])> {
    let starts = (0..blocks.len()).filter(|at| *at == 0 || blocks[*at].keyword == "MATERIAL");
    let starts: Vec<usize> = starts.collect();
    let ends = starts.iter().skip(1).copied().chain([blocks.len()]);
    let parts = starts.iter().zip(ends).map(|(start, end)| {
        let name = blocks[*start].value("NAME").unwrap_or_default();
        (name.to_owned(), &blocks[*start..end])
    });
    parts.collect()
}

/// Reads the law of the named material, or of the first material with a law.
pub(super) fn read(
    program: Program,
    text: &str,
    material: Option<&str>,
) -> Result<ForeignLaw, Trouble> {
    let blocks = blocks(program, text);
    let mut with_law = materials(&blocks);
    with_law.retain(|(_, blocks)| blocks.iter().any(is_law));
    let names: Vec<String> = with_law.iter().map(|(name, _)| name.clone()).collect();
    let at = match material {
        None => 0,
        Some(wanted) => names
            .iter()
            .position(|name| *name == wanted.trim_matches('"'))
            .or_else(|| {
                names
                    .iter()
                    .position(|name| word(name) == word(&wanted.replace('"', "")))
            })
            .ok_or_else(|| Trouble::no_such_material(wanted, &names))?,
    };
    let Some((name, own)) = with_law.get(at) else {
        return Err(elastic(&blocks).unwrap_or_else(|| {
            Trouble::no_law(
                program,
                "expected *HYPERELASTIC, *HYPERFOAM or *ANISOTROPIC HYPERELASTIC with its data lines, for example `*HYPERELASTIC, OGDEN, N=1` \
                 and `0.4, 1.3, 0.02`",
            )
        }));
    };
    let mut unread = unread(own)?;
    let mut law = law(own, &mut unread)?;
    law.unread = unread;
    law.unread.material = Some(Chosen {
        name: name.clone(),
        place: at,
        all: names,
    });
    Ok(law)
}

/// Error for the first isotropic `*ELASTIC` of a text.
fn elastic(blocks: &[Block<'_>]) -> Option<Trouble> {
    let is_isotropic = |block: &&Block<'_>| {
        let kind = block.value("TYPE").unwrap_or("ISOTROPIC");
        block.keyword == "ELASTIC" && "ISOTROPIC".starts_with(kind)
    };
    let block = blocks.iter().find(is_isotropic)?;
    let (line, data) = block.data.first()?;
    let mut fields = data.split(',').map(|field| number(field, *line).ok());
    let mut next = || fields.next().unwrap_or(Some(0.0));
    Trouble::linear(block.line, &block.title, [next()?, next()?])
}

/// Reads the first law with Marlow's form in a text.
pub(super) fn marlow_of(text: &str) -> Result<ForeignLaw, Trouble> {
    let blocks = blocks(Program::Abaqus, text);
    let all = materials(&blocks);
    let of_table = |block: &Block<'_>| is_law(block) && block.has("MARLOW");
    let own = all.iter().find(|(_, blocks)| blocks.iter().any(of_table));
    own.map_or_else(
        || {
            Err(Trouble::new(
                1,
                "there is no table in this text",
                "expected *HYPERELASTIC, MARLOW with *UNIAXIAL TEST DATA below it",
            ))
        },
        |(_, blocks)| law(blocks, &mut Unread::default()),
    )
}

/// Keywords of a material that are not read, apart from its first law.
fn unread(blocks: &[Block<'_>]) -> Result<Unread, Trouble> {
    let first = blocks.iter().find(|block| is_law(block));
    let line = first.map_or(0, |block| block.line);
    let mut unread = Unread::default();
    let viscous = blocks.iter().find(|block| block.keyword == "VISCOELASTIC");
    let series = viscous
        .filter(|block| block.is_series())
        .map(|block| block.line);
    for block in blocks {
        let is_table = block.keyword.ends_with("TESTDATA");
        let mut add = |name: &str, value: &Option<String>| {
            let value = value.as_ref();
            let value = value.map_or_else(String::new, |value| format!("={}", brief(value)));
            let part = format!("{}{value} of {}", brief(name), title(block));
            unread.parts.push((part, block.line));
        };
        if is_table {
            block
                .parameters
                .iter()
                .for_each(|(name, value)| add(name, value));
        }
        // A law with a Prony series does not soften here.
        if block.is_softening() && !blocks.iter().any(Block::is_series) {
            let constants = block.constants(3, &mut unread)?;
            let constants = constants.try_into().ok();
            unread.softening = constants.map(|constants| Softening {
                constants,
                keyword: (block.title.clone(), block.line),
            });
            continue;
        }
        let is_read_table = is_table && first.is_some_and(|law| law.has("MARLOW"));
        let is_read_series = block.is_series() && Some(block.line) == series;
        if block.keyword == "MATERIAL" || is_read_table || is_read_series {
            continue;
        }
        if block.line != line {
            let part = match is_law(block) {
                true => format!("another {}, because line {line} is read", block.title),
                false => title(block),
            };
            if !unread.parts.iter().any(|(other, _)| *other == part) {
                unread.parts.push((part, block.line));
            }
            continue;
        }
        let moduli = block.value("MODULI");
        for (name, value) in &block.parameters {
            let is_read = match name.as_str() {
                "N" | "TYPE" | "LOCALDIRECTIONS" => true,
                "MODULI" => viscous.is_some(),
                "POISSON" => block.has("MARLOW"),
                "TEMPERATURE" | "DEPENDENCIES" => false,
                _ => value.is_none(),
            };
            if !is_read {
                add(name, value);
            }
        }
        if let Some(viscous) = viscous {
            let is_prony = viscous.is_series();
            let mut terms = Vec::new();
            for (line, text) in viscous.data.iter().filter(|_| is_prony) {
                let mut fields = text.split(',').map(|field| number(field, *line));
                let mut next = || fields.next().unwrap_or(Ok(0.0));
                let [shear, bulk, time] = [next()?, next()?, next()?];
                terms.push(PronyTerm {
                    shear,
                    // Abaqus relaxes both parts of the stress of a foam alike.
                    bulk: if block.keyword == "HYPERFOAM" {
                        shear
                    } else {
                        bulk
                    },
                    time,
                });
            }
            let is_long_term = moduli != Some("INSTANTANEOUS");
            unread.relaxation = Some(Relaxation {
                terms: is_prony.then_some(terms),
                is_long_term,
                by: match (is_long_term, moduli) {
                    (false, _) => "MODULI=INSTANTANEOUS",
                    (true, Some(_)) => "MODULI=LONG TERM",
                    (true, None) => "MODULI=LONG TERM by default",
                },
                keyword: Some((viscous.title.clone(), viscous.line)),
            });
        }
    }
    Ok(unread)
}

/// Reads the law from the blocks of a material.
fn law(blocks: &[Block<'_>], unread: &mut Unread) -> Result<ForeignLaw, Trouble> {
    let block = blocks
        .iter()
        .find(|block| is_law(block))
        .ok_or_else(|| Trouble::new(1, "there is no law", "expected *HYPERELASTIC"))?;
    let foreign = ["MARLOW", "TESTDATAINPUT", "HOLZAPFEL", "FUNG", "USER"];
    let foreign = foreign.into_iter().find(|form| block.has(form));
    if let (Program::Calculix, Some(form)) = (block.program, foreign) {
        return Err(Trouble::new(
            block.line,
            format!("CalculiX has no {}, {form}", block.title),
            "CalculiX has *HYPERELASTIC and *HYPERFOAM with constants; read forms of Abaqus with --from abaqus",
        ));
    }
    if block.keyword == "HYPERELASTIC" && block.has("MARLOW") {
        return marlow(block, blocks, unread);
    }
    if block.has("TESTDATAINPUT") {
        return Err(Trouble::new(
            block.line,
            "the block has test data, and Abaqus fits the constants to them",
            "paste the constants that Abaqus prints in its data file (*.dat), without TEST DATA INPUT",
        ));
    }
    match block.keyword.as_str() {
        "HYPERFOAM" => foam(block, unread),
        "ANISOTROPICHYPERELASTIC" => fibers(block, unread),
        _ => rubber(block, unread),
    }
}

/// Splits a text into blocks. Comments begin with two stars, and a keyword line that ends with a comma continues on the next line.
fn blocks(program: Program, text: &str) -> Vec<Block<'_>> {
    let mut blocks: Vec<Block<'_>> = Vec::new();
    let mut goes_on = false;
    for (n, line) in text.lines().enumerate() {
        let own = line.trim();
        if own.is_empty() || own.starts_with("**") {
            continue;
        }
        let is_keyword = own.starts_with('*');
        if is_keyword || goes_on {
            let mut fields = fields(own.trim_start_matches('*')).map(word);
            if is_keyword {
                blocks.push(Block {
                    program,
                    line: n + 1,
                    keyword: fields.next().unwrap_or_default(),
                    title: own
                        .split(',')
                        .next()
                        .unwrap_or_default()
                        .trim()
                        .to_ascii_uppercase(),
                    parameters: Vec::new(),
                    data: Vec::new(),
                });
            }
            if let Some(block) = blocks.last_mut() {
                block
                    .parameters
                    .extend(fields.filter(|field| !field.is_empty()).map(|field| {
                        match field.split_once('=') {
                            Some((name, value)) => (name.to_owned(), Some(value.to_owned())),
                            None => (field, None),
                        }
                    }));
            }
            goes_on = own.ends_with(',');
        } else if let Some(block) = blocks.last_mut() {
            block.data.push((n + 1, own));
        }
    }
    blocks
}

/// Fields of a keyword line, separated by commas outside of quotation marks.
pub(crate) fn fields(line: &str) -> impl Iterator<Item = &str> {
    let mut is_quoted = false;
    line.split(move |letter: char| {
        is_quoted ^= letter == '"';
        letter == ',' && !is_quoted
    })
}

/// A word in capitals without spaces; Abaqus ignores case and spaces, except between quotation marks, which are removed.
fn word(text: &str) -> String {
    let parts = text.split('"').enumerate().map(|(n, part)| match n % 2 {
        0 => part
            .chars()
            .filter(|letter| !letter.is_whitespace())
            .collect::<String>()
            .to_ascii_uppercase(),
        _ => part.to_owned(),
    });
    parts.collect()
}

impl Block<'_> {
    fn has(&self, parameter: &str) -> bool {
        self.parameters.iter().any(|(name, _)| name == parameter)
    }

    fn value(&self, parameter: &str) -> Option<&str> {
        let found = self.parameters.iter().find(|(name, _)| name == parameter);
        found?.1.as_deref()
    }

    /// Returns true for viscoelasticity with a Prony series.
    fn is_series(&self) -> bool {
        self.keyword == "VISCOELASTIC" && self.value("TIME") == Some("PRONY")
    }

    /// Returns true for the Mullins effect with constants at one temperature.
    fn is_softening(&self) -> bool {
        self.program == Program::Abaqus
            && self.keyword == "MULLINSEFFECT"
            && self.data.len() == 1
            && !["TESTDATAINPUT", "USER"].iter().any(|form| self.has(form))
    }

    /// Value of a parameter that is a small integer; 1 if it is missing.
    fn count(&self, parameter: &str, most: usize) -> Result<usize, Trouble> {
        let found = self.parameters.iter().find(|(name, _)| name == parameter);
        let Some((name, value)) = found else {
            return Ok(1);
        };
        let value = value.as_deref().unwrap_or_default();
        let most = match self.program {
            Program::Calculix => most.min(3),
            _ => most,
        };
        let number = value.parse().ok().filter(|n| (1..=most).contains(n));
        number.ok_or_else(|| {
            Trouble::new(
                self.line,
                format!(
                    "{name} is `{}`; expected an integer from 1 to {most}",
                    brief(value)
                ),
                "write it as N=2",
            )
        })
    }

    /// Compressibilities as the program takes them, with a note if it replaces zeros.
    ///
    /// CalculiX replaces `D_i` below 1e-10 by `(0.1/mu)^i`. A term with a much larger `D_i` than `D_1` vanishes in rounding, so that its decks omit
    /// terms in this way.
    fn filled(&self, shear: f64, compressibilities: &[f64]) -> (Vec<f64>, Option<String>) {
        let mut own = compressibilities.to_vec();
        if self.program != Program::Calculix {
            return (own, None);
        }
        let mut filled = Vec::new();
        for (n, d) in own.iter_mut().enumerate() {
            if d.abs() < CALCULIX_SMALLEST {
                *d = (0.1 / shear).powi(n as i32 + 1);
                filled.push(format!("D{} = {d}", n + 1));
            }
        }
        for n in 1..own.len() {
            if own[n] > 1e16 * own[0] {
                own[n] = 0.0;
            }
        }
        let note = (!filled.is_empty()).then(|| {
            format!(
                "CalculiX replaces compressibilities below 1e-10 by (0.1/mu)^i, which depends on the units: {}",
                filled.join(", ")
            )
        });
        (own, note)
    }

    /// Constants at one temperature; missing fields at the end of a line are zero. The temperature and the field variables after them are not read.
    fn constants(&self, count: usize, unread: &mut Unread) -> Result<Vec<f64>, Trouble> {
        let variables = self.value("DEPENDENCIES");
        let variables = variables.and_then(|own| own.parse().ok()).unwrap_or(0);
        let fields = count + 1 + variables.min(CONSTANTS_PER_LINE);
        let lines = count.div_ceil(CONSTANTS_PER_LINE);
        if self.data.len() < lines {
            return Err(Trouble::new(
                self.line,
                format!(
                    "expected {} data lines with {count} constants, found {}",
                    lines,
                    self.data.len()
                ),
                "constants are on the lines below the keyword, eight on each line",
            ));
        }
        if let Some((line, _)) = self.data.get(fields.div_ceil(CONSTANTS_PER_LINE)) {
            return Err(Trouble::new(
                *line,
                "there are more data lines than this law has constants for one temperature",
                "leave the constants of one temperature, and check N",
            ));
        }
        let mut constants = Vec::with_capacity(count);
        for (n, (line, text)) in self.data.iter().enumerate() {
            let before = n * CONSTANTS_PER_LINE;
            let own = count.saturating_sub(before).min(CONSTANTS_PER_LINE);
            let admitted = (fields - before).min(CONSTANTS_PER_LINE);
            let fields: Vec<&str> = text.trim_end_matches(',').split(',').collect();
            if fields.len() > admitted {
                return Err(Trouble::new(
                    *line,
                    format!(
                        "{} numbers, but this law has {own} constants here",
                        fields.len()
                    ),
                    "check the form of the law and N",
                ));
            }
            for place in 0..own {
                constants.push(number(fields.get(place).copied().unwrap_or(""), *line)?);
            }
            for (place, field) in fields.iter().enumerate().skip(own) {
                unread.condition(before + place - count, field, *line)?;
            }
        }
        Ok(constants)
    }
}

fn rubber(block: &Block<'_>, unread: &mut Unread) -> Result<ForeignLaw, Trouble> {
    const FORMS: [&str; 8] = [
        "NEO HOOKE",
        "MOONEY-RIVLIN",
        "YEOH",
        "REDUCED POLYNOMIAL",
        "POLYNOMIAL",
        "OGDEN",
        "ARRUDA-BOYCE",
        "VAN DER WAALS",
    ];
    let form = FORMS.into_iter().find(|form| block.has(&word(form)));
    let known = ["N", "MODULI", "TYPE", "TEMPERATURE", "DEPENDENCIES"];
    if let Some((other, _)) = block.parameters.iter().find(|(name, _)| {
        !FORMS.iter().any(|form| word(form) == *name) && !known.contains(&name.as_str())
    }) {
        return Err(Trouble::new(
            block.line,
            format!(
                "*HYPERELASTIC has the parameter `{}`, which is not supported",
                brief(other)
            ),
            "supported: NEO HOOKE, MOONEY-RIVLIN, YEOH, REDUCED POLYNOMIAL, POLYNOMIAL, OGDEN, ARRUDA-BOYCE and VAN DER WAALS, with N, and MARLOW with a table",
        ));
    }
    let form = form.unwrap_or("POLYNOMIAL");
    let program = block.program.title();
    let title = |n: usize| format!("*HYPERELASTIC, {form}, N={n} of {program}");
    let one = || format!("*HYPERELASTIC, {form} of {program}");
    let line = block.line;
    let polynomial = |title: String, constants: &[((usize, usize), f64)], d: &[f64]| {
        let shear = constants.iter().filter(|((i, j), _)| i + j == 1);
        let shear = 2.0 * shear.map(|(_, value)| value).sum::<f64>();
        let (d, note) = block.filled(shear, d);
        let law = ForeignLaw::polynomial(line, title, constants, Volume::Powers(&d));
        law.noted(note)
    };
    match form {
        "NEO HOOKE" => {
            let c = block.constants(2, unread)?;
            Ok(polynomial(one(), &[((1, 0), c[0])], &c[1..]))
        }
        "MOONEY-RIVLIN" => {
            let c = block.constants(3, unread)?;
            let constants = [((1, 0), c[0]), ((0, 1), c[1])];
            Ok(polynomial(one(), &constants, &c[2..]))
        }
        "YEOH" | "REDUCED POLYNOMIAL" => {
            let n = if form == "YEOH" {
                3
            } else {
                block.count("N", 6)?
            };
            let c = block.constants(2 * n, unread)?;
            let constants: Vec<_> = (0..n).map(|i| ((i + 1, 0), c[i])).collect();
            Ok(polynomial(title(n), &constants, &c[n..]))
        }
        "POLYNOMIAL" => {
            let n = block.count("N", 6)?;
            let powers = powers_to(n);
            let c = block.constants(powers.len() + n, unread)?;
            let constants: Vec<_> = powers.iter().copied().zip(c.iter().copied()).collect();
            Ok(polynomial(title(n), &constants, &c[powers.len()..]))
        }
        "OGDEN" => {
            let n = block.count("N", 6)?;
            let c = block.constants(3 * n, unread)?;
            let mut terms = Vec::new();
            for pair in c[..2 * n].chunks_exact(2) {
                if pair[1] == 0.0 {
                    return Err(exponent(block));
                }
                // `2 mu/alpha^2` in Abaqus corresponds to `mu/alpha` in the library.
                terms.push((2.0 * pair[0] / pair[1], pair[1]));
            }
            let shear = c[..2 * n].iter().step_by(2).sum();
            let (d, note) = block.filled(shear, &c[2 * n..]);
            Ok(ForeignLaw::ogden(line, title(n), &terms, Volume::Powers(&d)).noted(note))
        }
        "ARRUDA-BOYCE" => {
            let c = block.constants(3, unread)?;
            let (d, note) = block.filled(c[0], &c[2..]);
            let law = ForeignLaw::arruda_boyce(line, one(), (c[0], c[1]), Volume::logarithm(d[0]));
            Ok(law.noted(note))
        }
        _ => {
            let c = block.constants(5, unread)?;
            let (d, note) = block.filled(c[0], &c[4..]);
            let law = van_der_waals(
                line,
                one(),
                [c[0], c[1], c[2], c[3]],
                Volume::logarithm(d[0]),
            )?;
            Ok(law.noted(note))
        }
    }
}

/// Reads Marlow's form with the table of the one test that follows it.
fn marlow(
    block: &Block<'_>,
    blocks: &[Block<'_>],
    unread: &mut Unread,
) -> Result<ForeignLaw, Trouble> {
    let tests: Vec<(Test, &Block<'_>)> = blocks
        .iter()
        .skip_while(|other| other.line <= block.line)
        .map_while(|other| {
            let is_data = other.keyword.ends_with("TESTDATA");
            is_data.then(|| (Test::of_keyword(&other.keyword), other))
        })
        .filter_map(|(test, other)| Some((test?, other)))
        .collect();
    let [(test, table)] = tests[..] else {
        return Err(Trouble::new(
            block.line,
            format!("MARLOW needs the table of one test, {} found", tests.len()),
            "write *UNIAXIAL TEST DATA (or BIAXIAL, PLANAR) below the keyword, with nominal stress, nominal strain on each line",
        ));
    };
    if let Some(volume) = blocks
        .iter()
        .find(|other| other.keyword == "VOLUMETRICTESTDATA")
    {
        return Err(Trouble::new(
            volume.line,
            "a table of volumetric tests is not supported",
            "give Poisson's ratio instead (*HYPERELASTIC, MARLOW, POISSON=0.49), or --set material.kappa",
        ));
    }
    let poisson = block.parameters.iter().find(|(name, _)| name == "POISSON");
    let poisson = poisson
        .map(|(_, value)| number(value.as_deref().unwrap_or_default(), block.line))
        .transpose()?;
    marlow::law(table.line, test, &table.data, poisson, unread)
}

fn exponent(block: &Block<'_>) -> Trouble {
    Trouble::new(
        block.line,
        "an exponent alpha is 0",
        "expected mu1, alpha1, mu2, alpha2, ...; check N",
    )
}

/// Foam energy `2 mu_i/alpha_i^2 (sum lambda^alpha_i - 3 + (J^(-alpha_i beta_i) - 1)/beta_i)` with `beta_i = nu_i/(1 - 2 nu_i)`.
fn foam(block: &Block<'_>, unread: &mut Unread) -> Result<ForeignLaw, Trouble> {
    // Abaqus uses POISSON only in fits: "valid only when testData = ON" (Abaqus Scripting Reference Guide, Hyperfoam object).
    if let Some(nu) = block.value("POISSON") {
        return Err(Trouble::new(
            block.line,
            format!(
                "*HYPERFOAM has POISSON={nu} in addition to constants; Abaqus takes POISSON with TEST DATA INPUT only"
            ),
            "omit POISSON: the Poisson's ratios nu1, nu2, ... are the last constants (after mu1, alpha1, mu2, alpha2, ...), and zero where they are missing",
        ));
    }
    let n = block.count("N", 3)?;
    let c = block.constants(3 * n, unread)?;
    let mut terms = Vec::new();
    for term in 0..n {
        let (mu, alpha, nu) = (c[2 * term], c[2 * term + 1], c[2 * n + term]);
        if alpha == 0.0 {
            return Err(exponent(block));
        }
        if nu >= 0.5 {
            return Err(Trouble::new(
                block.line,
                format!("nu{} is {nu}; expected less than 0.5", term + 1),
                "the constants are mu1, alpha1, mu2, alpha2, ..., nu1, nu2, ...",
            ));
        }
        terms.push([mu, alpha, nu / (1.0 - 2.0 * nu)]);
    }
    let title = format!("*HYPERFOAM, N={n} of {}", block.program.title());
    Ok(ForeignLaw::foam(block.line, title, &terms))
}

/// Holzapfel, Gasser and Ogden with dispersion: `c10 (I1bar - 3) + k1/(2 k2) sum (exp(k2 <E>^2) - 1) + ((J^2 - 1)/2 - ln J)/D` with `E = k (I1bar -
/// 3) + (1 - 3 k) (I4bar - 1)`.
fn fibers(block: &Block<'_>, unread: &mut Unread) -> Result<ForeignLaw, Trouble> {
    if !block.has("HOLZAPFEL") {
        return Err(Trouble::new(
            block.line,
            "this form of *ANISOTROPIC HYPERELASTIC is not supported",
            "supported: HOLZAPFEL with C10, D, k1, k2, kappa",
        ));
    }
    let families = block.count("LOCALDIRECTIONS", 2)?;
    let c = block.constants(5, unread)?;
    let (k2, dispersion) = (c[3], c[4]);
    if !(0.0..=1.0 / 3.0).contains(&dispersion) || k2 <= 0.0 {
        return Err(Trouble::new(
            block.line,
            format!(
                "k2 is {k2} and kappa is {dispersion}; expected k2 above 0 and kappa from 0 to 1/3"
            ),
            "the constants are C10, D, k1, k2, kappa",
        ));
    }
    let strain = |invariant: &str| {
        format!(
            "macaulay(dispersion*(I1bar - 3) + (1 - 3*dispersion)*(J^(-2/3)*{invariant} - 1))^2"
        )
    };
    let mut energy = "c10*(I1bar - 3)".to_owned();
    for invariant in ["I4", "I6"].into_iter().take(families) {
        energy.push_str(&format!(" + k1/(2*k2)*(exp(k2*{}) - 1)", strain(invariant)));
    }
    energy.push_str(&format!(" + {LOGARITHM}"));
    let constants = named(&[
        ("c10", c[0]),
        ("k1", c[2]),
        ("k2", k2),
        ("dispersion", dispersion),
    ]);
    let title =
        format!("*ANISOTROPIC HYPERELASTIC, HOLZAPFEL, LOCAL DIRECTIONS={families} of Abaqus");
    let mut law = ForeignLaw::new(
        block.line,
        title,
        Energy::Formula(energy),
        constants,
        (2.0 * c[0], Volume::logarithm(c[1])),
    );
    law.needed = ["material.fiber1-angle", "material.fiber2-angle"][..families].to_vec();
    Ok(law)
}

/// Writes a law as a block of Abaqus or CalculiX.
pub(super) fn write(program: Program, sheet: &Sheet) -> Result<write::Block, Refusal> {
    let most = if program == Program::Calculix { 3 } else { 6 };
    let compressibilities = |count: usize| compressibilities(program, sheet, count);
    let within = |count: usize, most: usize| match count <= most {
        true => Ok(()),
        false => Err(Refusal::Lacks),
    };
    let (form, mut values, function) = match &sheet.form {
        Form::Polynomial(constants) => {
            let (n, of_first) = order(constants);
            within(n, most)?;
            let first: Vec<(usize, usize)> = (1..=n).map(|i| (i, 0)).collect();
            let (form, powers, count) = match (n, of_first) {
                (1, true) => ("NEO HOOKE".to_owned(), first, 1),
                (1, false) => ("MOONEY-RIVLIN".to_owned(), powers_to(1), 1),
                (2 | 3, true) => ("YEOH".to_owned(), vec![(1, 0), (2, 0), (3, 0)], 3),
                (_, true) => (format!("REDUCED POLYNOMIAL, N={n}"), first, n),
                (_, false) => (format!("POLYNOMIAL, N={n}"), powers_to(n), n),
            };
            let mut values = ordered(constants, &powers)?;
            values.extend(compressibilities(count)?);
            (form, values, Some(SQUARE))
        }
        Form::Ogden(terms) => {
            within(terms.len(), most)?;
            let mut values = Vec::new();
            for (mu, alpha) in terms {
                values.extend([0.5 * mu * alpha, *alpha]);
            }
            values.extend(compressibilities(terms.len())?);
            (format!("OGDEN, N={}", terms.len()), values, Some(SQUARE))
        }
        Form::ArrudaBoyce(mu, locking) => {
            let values = [vec![*mu, *locking], compressibilities(1)?].concat();
            ("ARRUDA-BOYCE".to_owned(), values, Some(LOGARITHM))
        }
        Form::Gent(..) => return Err(Refusal::Lacks),
        Form::Foam(terms) => {
            within(terms.len(), 3)?;
            let mut values = Vec::new();
            for [mu, alpha, _] in terms {
                values.extend([*mu, *alpha]);
            }
            (String::new(), values, None)
        }
    };
    let mut keyword = format!("*HYPERELASTIC, {form}");
    if let Form::Foam(terms) = &sheet.form {
        keyword = format!("*HYPERFOAM, N={}", terms.len());
        for [_, _, beta] in terms {
            values.push(write::ratio(*beta)?);
        }
    }
    let mut lines = vec!["*MATERIAL, NAME=LAW".to_owned(), keyword];
    lines.extend(values.chunks(CONSTANTS_PER_LINE).map(list));
    Ok(write::Block {
        lines,
        function,
        notes: Vec::new(),
    })
}

/// Compressibilities of `count` terms: `2/K` and zeros, or numbers that CalculiX keeps and that remove its other terms.
fn compressibilities(program: Program, sheet: &Sheet, count: usize) -> Result<Vec<f64>, Refusal> {
    let first = match (program, sheet.bulk) {
        (Program::Calculix, _) => 2.0 / sheet.required_bulk()?,
        (_, Some(bulk)) => 2.0 / bulk,
        (_, None) => 0.0,
    };
    let other = match program {
        Program::Calculix if first < CALCULIX_SMALLEST => {
            return Err(Refusal::Constants(format!(
                "D1 = 2/kappa = {first} is below 1e-10, which CalculiX replaces; write the constants in a larger unit of stress"
            )));
        }
        Program::Calculix => first * 1e20,
        _ => 0.0,
    };
    let rest = (1..count).map(|_| other);
    Ok([first].into_iter().chain(rest).collect())
}
