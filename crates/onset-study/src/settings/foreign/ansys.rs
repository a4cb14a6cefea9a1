//! Reader for `TB,HYPER` with `TBDATA`. As in ANSYS, four letters of a name suffice.
//!
//! The energies follow the Mechanical APDL Theory Reference. With `d = 2/K` the volumetric part is `(J - 1)^(2i)/d_i`, except for Arruda-Boyce and
//! Gent with `((J^2 - 1)/2 - ln J)/d`. Ogden's moduli enter as `mu/alpha`.

use super::law::{Energy, ForeignLaw, LOGARITHM, SQUARE, Volume, extended_tube, powers_to};
use super::unread::{Chosen, Relaxation, Softening, Unread};
use super::write::{Block, Form, Refusal, Sheet, list, order, ordered};
use super::{Program, Trouble, number};
use onset::material::PronyTerm;
use onset_frames::brief;

/// Character between two commands of a line.
pub(super) const SEPARATOR: char = '$';

/// Table of constants with its form.
struct Table {
    line: usize,
    form: String,
    /// `NPTS`; `None` if it is missing.
    terms: Option<usize>,
    constants: Vec<f64>,
}

/// Reads the first law of a text.
pub(super) fn read(text: &str, material: Option<&str>) -> Result<ForeignLaw, Trouble> {
    let (table, unread) = table(text, material)?;
    let mut law = law(&table)?;
    law.unread = unread;
    Ok(law)
}

fn law(table: &Table) -> Result<ForeignLaw, Trouble> {
    let line = table.line;
    let title = format!("TB,HYPER with {} of ANSYS", table.form);
    match table.form.as_str() {
        "NEO" => {
            let c = table.constants(2)?;
            Ok(ForeignLaw::polynomial(
                line,
                title,
                &[((1, 0), 0.5 * c[0])],
                Volume::Powers(&c[1..]),
            ))
        }
        "" | "MOONEY" => mooney(table, title),
        "POLY" => polynomial(table, title),
        "YEOH" => {
            let n = table.count(6)?;
            let c = table.constants(2 * n)?;
            let constants: Vec<_> = (0..n).map(|i| ((i + 1, 0), c[i])).collect();
            Ok(ForeignLaw::polynomial(
                line,
                title,
                &constants,
                Volume::Powers(&c[n..]),
            ))
        }
        "OGDEN" => {
            let n = table.count(6)?;
            let c = table.constants(3 * n)?;
            let terms: Vec<(f64, f64)> = c[..2 * n].chunks_exact(2).map(|p| (p[0], p[1])).collect();
            table.no_zero(&terms)?;
            Ok(ForeignLaw::ogden(
                line,
                title,
                &terms,
                Volume::Powers(&c[2 * n..]),
            ))
        }
        "BOYCE" | "GENT" => {
            let c = table.constants(3)?;
            let (constants, volume) = ((c[0], c[1]), Volume::logarithm(c[2]));
            Ok(match table.form.as_str() {
                "BOYCE" => ForeignLaw::arruda_boyce(line, title, constants, volume),
                _ => ForeignLaw::gent(line, title, constants, volume),
            })
        }
        "BLATZ" => {
            let c = table.constants(1)?;
            let constants = vec![("mu".to_owned(), c[0])];
            Ok(ForeignLaw::of_constants(
                line,
                title,
                Energy::Model("blatz-ko"),
                constants,
            ))
        }
        "FOAM" => foam(table, title),
        "ETUBE" => tube(table, title),
        other => Err(Trouble::new(
            line,
            format!("TB,HYPER with `{}` is not supported", brief(other)),
            "supported: NEO, MOONEY, POLY, YEOH, OGDEN, BOYCE, GENT, BLATZ, FOAM and ETUBE",
        )),
    }
}

/// The known name that a field abbreviates to four or more letters; other fields unchanged.
fn name(field: &str) -> &str {
    const NAMES: [&str; 12] = [
        "HYPER",
        "PRONY",
        "ELASTIC",
        "TBDATA",
        "TBTEMP",
        "SHEAR",
        "MOONEY",
        "OGDEN",
        "BOYCE",
        "BLATZ",
        "ETUBE",
        "ISOTROPIC",
    ];
    let known = NAMES
        .into_iter()
        .find(|known| known.get(..4) == field.get(..4));
    known.unwrap_or(field)
}

/// Commands of a text with their line numbers, fields in capitals. `$` separates the commands of a line, and `!` begins a comment.
fn commands(text: &str) -> impl Iterator<Item = (usize, Vec<String>)> {
    (1..).zip(text.lines()).flat_map(|(number, line)| {
        let own = line.split('!').next().unwrap_or_default();
        own.split(SEPARATOR).map(move |command| {
            let fields = command
                .split(',')
                .map(|field| field.trim().to_ascii_uppercase());
            (
                number,
                fields.map(|field| name(&field).to_owned()).collect(),
            )
        })
    })
}

/// Error for linear elasticity by `MP,EX` or `TB,ELASTIC`: the first material with a modulus.
fn elastic(text: &str) -> Option<Trouble> {
    let commands: Vec<(usize, Vec<String>)> = commands(text).collect();
    let field = |place: usize| {
        move |own: &(usize, Vec<String>)| own.1.get(place).cloned().unwrap_or_default()
    };
    let [command, label, material] = [0, 1, 2].map(field);
    let at = commands.iter().position(|own| {
        let (command, label) = (command(own), label(own));
        matches!(
            (command.as_str(), label.as_str()),
            ("MP", "EX") | ("TB", "ELASTIC")
        )
    })?;
    let first = &commands[at];
    let value = |own: &(usize, Vec<String>), place: usize| {
        number(own.1.get(place).map_or("", String::as_str), own.0).ok()
    };
    let title = format!("{},{}", command(first), label(first));
    let moduli = match command(first).as_str() {
        "MP" => {
            let ratio = commands.iter().find(|own| {
                command(own) == "MP"
                    && ["PRXY", "NUXY"].contains(&label(own).as_str())
                    && material(own) == material(first)
            });
            let ratio = ratio.map_or(Some(0.3), |own| value(own, 3));
            [value(first, 3)?, ratio?]
        }
        _ => {
            let data = commands[at..].iter().find(|own| command(own) == "TBDATA")?;
            [value(data, 2)?, value(data, 3)?]
        }
    };
    Trouble::linear(first.0, &title, moduli)
}

/// Command for the Mullins effect.
const MULLINS: &str = "TB,CDM with PSE2";

/// Finds the table of the named material, or of the first material with a law, and the commands that are not read.
fn table(text: &str, material: Option<&str>) -> Result<(Table, Unread), Trouble> {
    let mut found: Option<Table> = None;
    let mut unread = Unread::default();
    let mut own_material = String::new();
    // Numbers of the materials with a law, and the place of the chosen one among them.
    let mut with_law: Vec<String> = Vec::new();
    let mut at = 0;
    let mut is_open = false;
    // Part of the stress, shear or bulk, whose table of relaxation is open.
    let mut relaxing: Option<&str> = None;
    // Line and constants of the Mullins effect, and whether their table is open.
    let mut softening: Option<(usize, [f64; 3])> = None;
    let mut is_softening = false;
    for (line, fields) in commands(text) {
        let field = |place: usize| fields.get(place).map_or("", String::as_str);
        let is_of_own = |own: &str| field(2) == own || field(2).is_empty();
        if field(0) == "TB" {
            is_open = field(1) == "HYPER"
                && found.is_none()
                && material.is_none_or(|wanted| field(2) == wanted);
            relaxing = None;
            is_softening = false;
            if field(1) == "HYPER" {
                if is_open {
                    at = with_law.len();
                }
                with_law.push(field(2).to_owned());
            }
            if !is_open {
                unread
                    .parts
                    .push((format!("TB,{},{}", brief(field(1)), brief(field(2))), line));
            }
            if field(1) == "PRONY"
                && found.is_some()
                && is_of_own(&own_material)
                && matches!(field(5), "SHEAR" | "BULK" | "")
            {
                relaxing = Some(if field(5) == "BULK" { "BULK" } else { "SHEAR" });
                unread.parts.pop();
                unread.relaxation.get_or_insert(Relaxation {
                    terms: Some(Vec::new()),
                    is_long_term: false,
                    by: "the convention of ANSYS",
                    keyword: Some(("TB,PRONY".to_owned(), line)),
                });
            }
            let has_form = |table: &Table| !["BLATZ", "FOAM"].contains(&table.form.as_str());
            if field(1) == "CDM"
                && field(5) == "PSE2"
                && found.as_ref().is_some_and(has_form)
                && is_of_own(&own_material)
                && softening.is_none()
            {
                is_softening = true;
                softening = Some((line, [0.0; 3]));
                unread.parts.pop();
            }
        } else if let (true, "TBDATA", Some((_, constants))) =
            (is_softening, field(0), &mut softening)
        {
            let start = field(1).parse().unwrap_or(1_usize).max(1) - 1;
            for (place, text) in fields.iter().skip(2).enumerate() {
                if let Some(own) = constants.get_mut(start.saturating_add(place)) {
                    *own = number(text, line)?;
                }
            }
            continue;
        } else if field(0) == "TBDATA" && !is_open {
            if let (Some(part), Some(relaxation)) = (relaxing, &mut unread.relaxation) {
                let pairs = fields.get(2..).unwrap_or_default().chunks(2);
                for pair in pairs {
                    let [own, time] = [0, 1].map(|n| pair.get(n).map_or("", String::as_str));
                    let [own, time] = [number(own, line)?, number(time, line)?];
                    let [shear, bulk] = if part == "BULK" {
                        [0.0, own]
                    } else {
                        [own, 0.0]
                    };
                    relaxation
                        .terms
                        .get_or_insert_default()
                        .push(PronyTerm { shear, bulk, time });
                }
            }
            continue;
        } else if field(0) == "TBTEMP" {
            // The constants that follow belong to another temperature.
            if let Some(table) = found
                .as_ref()
                .filter(|table| is_open && !table.constants.is_empty())
            {
                return Err(Trouble::new(
                    line,
                    format!(
                        "the law has constants for several temperatures, the first ones for the table of line {}",
                        table.line
                    ),
                    "keep the constants of one temperature",
                ));
            }
            if is_open {
                unread
                    .parts
                    .push((format!("TBTEMP,{}", brief(field(1))), line));
            }
            continue;
        } else if !field(0).is_empty() && field(0) != "TBDATA" && !field(0).starts_with(['/', '*'])
        {
            unread
                .parts
                .push((format!("{},{}", brief(field(0)), brief(field(1))), line));
        }
        match (field(0), &mut found) {
            ("TB", None) if is_open => {
                field(2).clone_into(&mut own_material);
                found = Some(Table {
                    line,
                    form: field(5).to_owned(),
                    terms: match field(4) {
                        "" => None,
                        text => Some(text.parse().map_err(|_| {
                            Trouble::new(
                                line,
                                format!("NPTS is `{}`", brief(text)),
                                "expected TB,HYPER,MAT,NTEMP,NPTS,TBOPT, for example TB,HYPER,1,,3,OGDEN",
                            )
                        })?),
                    },
                    constants: Vec::new(),
                });
            }
            ("TBDATA", Some(table)) => {
                let start = match field(1) {
                    "" => table.constants.len() + 1,
                    text => text
                        .parse()
                        .ok()
                        .filter(|start| (1..=64).contains(start))
                        .ok_or_else(|| {
                            Trouble::new(
                                line,
                                format!("TBDATA begins at `{}`", brief(text)),
                                "expected TBDATA,1,C1,C2,...",
                            )
                        })?,
                };
                for (place, text) in fields.iter().skip(2).enumerate() {
                    let place = start - 1 + place;
                    if table.constants.len() <= place {
                        table.constants.resize(place + 1, 0.0);
                    }
                    table.constants[place] = number(text, line)?;
                }
            }
            _ => {}
        }
    }
    match softening {
        // A law with a Prony series does not soften here.
        Some((line, _)) if unread.relaxation.is_some() => {
            unread.parts.push((MULLINS.to_owned(), line));
        }
        other => {
            unread.softening = other.map(|(line, constants)| Softening {
                constants,
                keyword: (MULLINS.to_owned(), line),
            });
        }
    }
    unread.material = Some(Chosen {
        name: own_material,
        place: at,
        all: with_law.iter().map(|own| (*own).to_string()).collect(),
    });
    found.map(|table| (table, unread)).ok_or_else(|| match material {
        Some(wanted) if !with_law.is_empty() => Trouble::no_such_material(wanted, &with_law),
        _ => elastic(text).unwrap_or_else(|| {
            Trouble::no_law(
                Program::Ansys,
                "expected TB,HYPER and TBDATA, for example `TB,HYPER,1,,1,OGDEN` and `TBDATA,1,0.6,1.3,0.02`",
            )
        }),
    })
}

impl Table {
    /// `NPTS`, or 1 if it is missing.
    fn count(&self, most: usize) -> Result<usize, Trouble> {
        let n = self.terms.unwrap_or(1);
        match (1..=most).contains(&n) {
            true => Ok(n),
            false => Err(Trouble::new(
                self.line,
                format!("NPTS is {n}; expected an integer from 1 to {most}"),
                "the number of terms is the fifth field, TB,HYPER,1,,3,OGDEN",
            )),
        }
    }

    /// Constants, with zeros for missing constants as in ANSYS.
    fn constants(&self, count: usize) -> Result<Vec<f64>, Trouble> {
        if self.constants.is_empty() {
            return Err(Trouble::new(
                self.line,
                "TB,HYPER has no constants",
                "write them below it, for example `TBDATA,1,0.6,1.3,0.02`",
            ));
        }
        if self.constants.len() > count {
            return Err(Trouble::new(
                self.line,
                format!(
                    "{} constants, but this law has {count}",
                    self.constants.len()
                ),
                "check the form of the law and NPTS",
            ));
        }
        let mut constants = self.constants.clone();
        constants.resize(count, 0.0);
        Ok(constants)
    }

    fn no_zero(&self, terms: &[(f64, f64)]) -> Result<(), Trouble> {
        match terms.iter().any(|(_, alpha)| *alpha == 0.0) {
            true => Err(Trouble::new(
                self.line,
                "an exponent alpha is 0",
                "expected mu1, alpha1, mu2, alpha2, ...; check NPTS",
            )),
            false => Ok(()),
        }
    }
}

fn mooney(table: &Table, title: String) -> Result<ForeignLaw, Trouble> {
    let powers: &[(usize, usize)] = match table.terms {
        None | Some(2) => &[(1, 0), (0, 1)],
        Some(3) => &[(1, 0), (0, 1), (1, 1)],
        Some(5) => &[(1, 0), (0, 1), (2, 0), (1, 1), (0, 2)],
        Some(9) => &[
            (1, 0),
            (0, 1),
            (2, 0),
            (1, 1),
            (0, 2),
            (3, 0),
            (2, 1),
            (1, 2),
            (0, 3),
        ],
        Some(n) => {
            return Err(Trouble::new(
                table.line,
                format!("MOONEY with NPTS = {n}; expected 2, 3, 5 or 9"),
                "the number of constants is the fifth field, TB,HYPER,1,,2,MOONEY",
            ));
        }
    };
    of_powers(table, title, powers, 1)
}

fn polynomial(table: &Table, title: String) -> Result<ForeignLaw, Trouble> {
    let n = table.count(6)?;
    of_powers(table, title, &powers_to(n), n)
}

fn of_powers(
    table: &Table,
    title: String,
    powers: &[(usize, usize)],
    volumes: usize,
) -> Result<ForeignLaw, Trouble> {
    let c = table.constants(powers.len() + volumes)?;
    let constants: Vec<_> = powers.iter().copied().zip(c.iter().copied()).collect();
    Ok(ForeignLaw::polynomial(
        table.line,
        title,
        &constants,
        Volume::Powers(&c[powers.len()..]),
    ))
}

/// Energy of ANSYS for foams: `sum mu_i/alpha_i (sum lambda^alpha_i - 3) + mu_i/(alpha_i beta_i) (J^(-alpha_i beta_i) - 1)`.
fn foam(table: &Table, title: String) -> Result<ForeignLaw, Trouble> {
    let n = table.count(3)?;
    let c = table.constants(3 * n)?;
    let terms: Vec<(f64, f64)> = c[..2 * n].chunks_exact(2).map(|p| (p[0], p[1])).collect();
    table.no_zero(&terms)?;
    let terms: Vec<[f64; 3]> = terms
        .iter()
        .zip(&c[2 * n..])
        .map(|((mu, alpha), beta)| [0.5 * mu * alpha, *alpha, *beta])
        .collect();
    Ok(ForeignLaw::foam(table.line, title, &terms))
}

fn tube(table: &Table, title: String) -> Result<ForeignLaw, Trouble> {
    let c = table.constants(5)?;
    extended_tube(
        table.line,
        title,
        [c[0], c[1], c[2], c[3]],
        Volume::Powers(&c[4..]),
    )
}

/// Writes a law as a table of ANSYS.
pub(super) fn write(sheet: &Sheet) -> Result<Block, Refusal> {
    // d = 0 is incompressible.
    let compressibility = sheet.bulk.map_or(0.0, |bulk| 2.0 / bulk);
    let volumes = |count: usize| {
        let rest = (1..count).map(|_| 0.0);
        [compressibility].into_iter().chain(rest)
    };
    let mut function = Some(SQUARE);
    let (form, count, values) = match &sheet.form {
        Form::Polynomial(constants) => {
            let (n, of_first) = order(constants);
            let first: Vec<(usize, usize)> = (1..=n).map(|i| (i, 0)).collect();
            let (form, count, powers, terms) = match (n, of_first) {
                (7.., _) => return Err(Refusal::Lacks),
                (1, true) => ("NEO", None, first, 1),
                (1, false) => ("MOONEY", Some(2), powers_to(1), 1),
                (_, true) => ("YEOH", Some(n), first, n),
                (_, false) => ("POLY", Some(n), powers_to(n), n),
            };
            let mut values = ordered(constants, &powers)?;
            if form == "NEO" {
                values[0] *= 2.0;
            }
            values.extend(volumes(terms));
            (form, count, values)
        }
        Form::Ogden(terms) => {
            let values = terms.iter().flat_map(|(mu, alpha)| [*mu, *alpha]);
            let values = values.chain(volumes(terms.len())).collect();
            ("OGDEN", Some(terms.len()), values)
        }
        Form::ArrudaBoyce(mu, second) | Form::Gent(mu, second) => {
            function = Some(LOGARITHM);
            let is_gent = matches!(sheet.form, Form::Gent(..));
            let form = if is_gent { "GENT" } else { "BOYCE" };
            (form, None, vec![*mu, *second, compressibility])
        }
        Form::Foam(terms) if terms.len() > 3 => return Err(Refusal::Lacks),
        Form::Foam(terms) => {
            function = None;
            let values = terms
                .iter()
                .flat_map(|[mu, alpha, _]| [2.0 * mu / alpha, *alpha]);
            let values = values.chain(terms.iter().map(|[_, _, beta]| *beta));
            ("FOAM", Some(terms.len()), values.collect::<Vec<f64>>())
        }
    };
    let count = count.map_or(String::new(), |count| count.to_string());
    let mut lines = vec![format!("TB,HYPER,1,,{count},{form}")];
    for (n, values) in values.chunks(6).enumerate() {
        lines.push(format!("TBDATA,{},{}", 6 * n + 1, list(values)));
    }
    Ok(Block {
        lines,
        function,
        notes: Vec::new(),
    })
}
