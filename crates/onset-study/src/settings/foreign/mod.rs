//! Constants of laws from other programs: blocks of finite-element programs, and models of felupe and hyperelastic, converted to settings of the
//! same energy, and back.
//!
//! Programs write the same law with different constants: Ogden's moduli with `mu/alpha` or `2 mu/alpha^2`, compressibility as `D = 2/K`, foams with
//! Poisson's ratio. A block is read with the meaning of its program. A form that is missing in the library becomes a user-defined energy.

mod abaqus;
mod ansys;
mod febio;
mod fields;
mod law;
mod lsdyna;
mod marlow;
mod python;
mod radioss;
mod unread;
mod write;

pub(crate) use abaqus::fields as fields_of_keyword;
use law::Blocks;
pub(in crate::settings) use marlow::Table;
use unread::Unread;
pub use write::{WriteError, Writing, law_written};

use super::{MaterialSettings, Origin, SettingError, did_you_mean, sections};
use onset_frames::{brief, cut};
use std::borrow::Cow;
use std::str::FromStr;

/// A program whose blocks can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Program {
    /// Abaqus: `*HYPERELASTIC`, `*HYPERFOAM` and `*ANISOTROPIC HYPERELASTIC` with their data lines.
    Abaqus,
    /// CalculiX: `*HYPERELASTIC` and `*HYPERFOAM` as in Abaqus, with its compressibilities in place of zeros.
    Calculix,
    /// ANSYS: `TB,HYPER` with `TBDATA`.
    Ansys,
    /// LS-DYNA: `*MAT_HYPERELASTIC_RUBBER`, `*MAT_OGDEN_RUBBER`, `*MAT_MOONEY-RIVLIN_RUBBER` and others, by name or number.
    LsDyna,
    /// Radioss and OpenRadioss: `/MAT/LAW42`, `/MAT/LAW82`, `/MAT/LAW92` and others, by number or name.
    Radioss,
    /// FEBio: `<material type="Ogden">` and others.
    Febio,
    /// Python package felupe: models with their arguments, `fem.Hyperelastic(fem.ogden, mu=[...], alpha=[...])`.
    Felupe,
    /// Python package hyperelastic: `ThirdOrderDeformation(C10=...)`, `Ogden(mu=[...], alpha=[...])`.
    Hyperelastic,
}

impl FromStr for Program {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let own = text.to_ascii_lowercase();
        let plain = own.replace(['-', '_'], "");
        let plain = plain.strip_prefix("open").unwrap_or(&plain);
        let found = Self::ALL
            .into_iter()
            .find(|program| program.name() == plain);
        found.ok_or_else(|| {
            let names = Self::ALL.map(Self::name);
            let (last, others) = names.split_last().unwrap_or((&"", &[]));
            format!(
                "expected {} or {last}{}",
                others.join(", "),
                did_you_mean(&own, names)
            )
        })
    }
}

impl Program {
    /// All programs, in the order in which they are listed.
    pub const ALL: [Self; 8] = [
        Self::Abaqus,
        Self::Ansys,
        Self::Calculix,
        Self::Febio,
        Self::Felupe,
        Self::Hyperelastic,
        Self::LsDyna,
        Self::Radioss,
    ];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Abaqus => "abaqus",
            Self::Calculix => "calculix",
            Self::Ansys => "ansys",
            Self::LsDyna => "lsdyna",
            Self::Radioss => "radioss",
            Self::Febio => "febio",
            Self::Felupe => "felupe",
            Self::Hyperelastic => "hyperelastic",
        }
    }

    /// Name in a sentence.
    pub fn title(self) -> &'static str {
        match self {
            Self::Abaqus => "Abaqus",
            Self::Calculix => "CalculiX",
            Self::Ansys => "ANSYS",
            Self::LsDyna => "LS-DYNA",
            Self::Radioss => "Radioss",
            Self::Febio => "FEBio",
            Self::Felupe => "felupe",
            Self::Hyperelastic => "hyperelastic",
        }
    }

    /// Program of a deck in a sentence, with its article.
    pub fn deck(self) -> String {
        let article = match self {
            Self::Abaqus | Self::Ansys | Self::LsDyna => "an",
            _ => "a",
        };
        format!("{article} {} deck", self.title())
    }

    /// Recognizes the program of a deck by its keywords, material keywords first; `None` for a study, and for a text without keywords. CalculiX
    /// has the keywords of Abaqus, and is recognized as Abaqus.
    pub fn of_deck(text: &str) -> Option<Self> {
        // A comment of a study may mention a program. A study with an error is recognized by its sections.
        let is_section = |line: &str| {
            let sections = [
                "[material",
                "[discretization",
                "[[axes",
                "[body",
                "[[methods",
            ];
            let own = line.trim_start();
            sections.iter().any(|section| own.starts_with(section))
        };
        if text.lines().any(is_section) || toml::from_str::<toml::Table>(text).is_ok() {
            return None;
        }
        let plain: String = text
            .chars()
            .filter(|letter| !letter.is_whitespace())
            .collect();
        let plain = plain.to_ascii_uppercase();
        let begins_line = |program: Self, word: &str| {
            let commands = if program == Self::Ansys {
                usize::MAX
            } else {
                1
            };
            let starts = text
                .lines()
                .flat_map(|line| line.splitn(commands, ansys::SEPARATOR));
            starts.map(str::trim_start).any(|line| {
                let start = line.get(..word.len());
                start.is_some_and(|start| start.eq_ignore_ascii_case(word))
            })
        };
        let lines: [(Self, &[&str]); 3] = [
            (Self::LsDyna, &["*MAT_"]),
            (Self::Radioss, &["/MAT/"]),
            (Self::Febio, &["<febio_spec", "<material"]),
        ];
        let words: [(Self, &[&str]); 4] = [
            (Self::Abaqus, &["*HYPER", "*ANISOTROPICHYPERELASTIC"]),
            (Self::Ansys, &["TB,HYPE"]),
            (Self::Felupe, &["FEM.", "FELUPE"]),
            (
                Self::Hyperelastic,
                &[
                    "ORDERDEFORMATION(",
                    "HYPERELASTIC.MODELS",
                    "HYPERELASTIC.FRAMEWORKS",
                ],
            ),
        ];
        // Decks without a supported law.
        let others: [(Self, &[&str]); 3] = [
            (Self::LsDyna, &["*KEYWORD"]),
            (Self::Radioss, &["#RADIOSS", "/BEGIN"]),
            (Self::Ansys, &["/PREP7", "TB,", "MP,"]),
        ];
        let is_keyword = |line: &str| {
            let name = line.trim_start().strip_prefix('*');
            name.is_some_and(|name| name.starts_with(|first: char| first.is_ascii_alphabetic()))
        };
        let by_line = |lines: &[(Self, &[&str])]| {
            let found = lines
                .iter()
                .find(|(program, words)| words.iter().any(|word| begins_line(*program, word)));
            found.map(|(program, _)| *program)
        };
        let by_word = || {
            let mut words = words.iter();
            let found = words.find(|(_, words)| words.iter().any(|word| plain.contains(word)));
            found.map(|(program, _)| *program)
        };
        by_line(&lines)
            .or_else(by_word)
            .or_else(|| by_line(&others))
            .or_else(|| text.lines().any(is_keyword).then_some(Self::Abaqus))
    }
}

/// Law read from a block of another program.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// Settings of the law as assignments `material.key=value`.
    pub assignments: Vec<String>,
    /// Remarks for the reader.
    pub notes: Vec<String>,
    /// Name of a law whose energy is a table, too long to print; `None` for other laws.
    pub name: Option<String>,
}

impl Reading {
    /// Section `[material]` of a study with the law.
    pub fn section(&self) -> String {
        sections(&self.assignments)
    }

    /// Refuses constants that the law does not admit, with the keyword of the block that contains them. Errors in the user's assignments `set` are found
    /// later.
    fn check(&self, name: &str, blocks: &Blocks, set: &[String]) -> Result<(), SettingError> {
        let own = set.iter().filter(|own| own.starts_with("material."));
        let all: Vec<&String> = self.assignments.iter().chain(own).collect();
        let law = MaterialSettings::of_file("", "", &all);
        let Err(error) = law.and_then(|law| law.check_parameters()) else {
            return Ok(());
        };
        let Origin::CommandLine(argument) = &error.origin else {
            return Ok(());
        };
        let is_at_fault = |own: &&String| argument.strip_prefix("--set ") == Some(own.as_str());
        let Some(assignment) = self.assignments.iter().find(is_at_fault) else {
            return Ok(());
        };
        let (keyword, line) = blocks.of(assignment);
        let hint = match self.name {
            None => format!(
                "the constants of {keyword} are read as {assignment}; correct them in the deck, or override them with --set"
            ),
            Some(_) => format!("correct the data of {keyword} in the deck"),
        };
        let message = format!("{keyword}: {}", error.message);
        Err(SettingError::new(place(name, *line), message).hint(hint))
    }
}

/// Beginnings of the notes on the law of a deck: the law with its keywords, and the keywords that are not read. Short answers contain these notes.
pub(crate) const DECK_NOTES: [&str; 2] = [READ_AS, NOT_READ];
const READ_AS: &str = "read as ";
const NOT_READ: &str = "not read: ";

/// Reads the first block of a hyperelastic law in a text. The user's assignments `set` override the block.
///
/// ```
/// use onset_study::settings::{Program, law_from};
/// // Abaqus writes 2 mu/alpha^2 where this program, as Ogden, writes mu/alpha.
/// let block = "*HYPERELASTIC, OGDEN, N=1\n2.0, 4.0, 0.02";
/// let reading = law_from(Program::Abaqus, "a block", block, &[])?;
/// let expected = ["material.model=ogden", "material.mu1=1", "material.alpha1=4", "material.mu2=0", "material.mu3=0", "material.kappa=100"];
/// assert_eq!(reading.assignments, expected);
/// # Ok::<(), onset_study::settings::SettingError>(())
/// ```
///
/// # Errors
/// [`SettingError`] with the line if the text is not such a block, or does not determine a law.
pub fn law_from(
    program: Program,
    name: &str,
    text: &str,
    set: &[String],
) -> Result<Reading, SettingError> {
    law_of(program, name, text, None, set)
}

/// Reads a block like [`law_from`], for a material given by its name or its number.
///
/// # Errors
/// Fails like [`law_from`], and when no material has this name.
pub fn law_of(
    program: Program,
    name: &str,
    text: &str,
    material: Option<&str>,
    set: &[String],
) -> Result<Reading, SettingError> {
    let law = read(program, text, material).map_err(|trouble| trouble.at(name))?;
    let origin = || place(name, law.line);
    let known: Vec<&str> = set
        .iter()
        .filter_map(|assignment| Some(assignment.split_once('=')?.0.trim()))
        .collect();
    if let Some(key) = law.needed.iter().find(|key| !known.contains(key)) {
        return Err(SettingError::new(
            origin(),
            format!("the block does not give {key}, the angle of the fibers, which the program defines elsewhere"),
        )
        .hint(format!("add --set {key}=DEGREES, from axis 1 to axis 2")));
    }
    if known.contains(&"material.model") {
        return Err(SettingError::new(
            origin(),
            "the block and --set material.model name different laws",
        )
        .hint("omit one of them"));
    }
    let blocks = law.blocks();
    let reading = law.reading(set, name, text);
    reading.check(name, &blocks, set)?;
    Ok(reading)
}

fn read(program: Program, text: &str, material: Option<&str>) -> Result<law::ForeignLaw, Trouble> {
    match program {
        Program::Abaqus | Program::Calculix => abaqus::read(program, text, material),
        Program::LsDyna => lsdyna::read(text, material),
        Program::Radioss => radioss::read(text, material),
        Program::Febio => febio::read(text, material),
        Program::Ansys => ansys::read(text, material),
        Program::Felupe | Program::Hyperelastic => python::read(program, text, material),
    }
}

/// Names or numbers of the materials with a law in a deck, also of laws that are not supported.
pub fn materials_of(program: Program, text: &str) -> Vec<String> {
    // No material has an empty line as its name.
    read(program, text, Some("\n")).map_or_else(|trouble| trouble.materials, |_| Vec::new())
}

/// Reads the table and the bulk modulus of the first material with Marlow's form.
pub(in crate::settings) fn table_from(
    name: &str,
    text: &str,
) -> Result<(Table, f64), SettingError> {
    let law = abaqus::marlow_of(text).map_err(|trouble| trouble.at(name))?;
    let bulk = law.constants.iter().find(|(name, _)| name == "kappa");
    let bulk = bulk.map_or(0.0, |(_, value)| *value);
    match law.energy {
        law::Energy::Table(table) => Ok((table, bulk)),
        _ => Err(
            SettingError::new(place(name, law.line), "the block has no test data")
                .hint("expected *HYPERELASTIC, MARLOW with *UNIAXIAL TEST DATA below it"),
        ),
    }
}

fn place(name: &str, line: usize) -> Origin {
    Origin::File {
        name: name.to_owned(),
        line,
        column: 1,
    }
}

/// Error in a block, with its line.
#[derive(Debug)]
struct Trouble {
    line: usize,
    message: String,
    hint: Cow<'static, str>,
    /// Materials with a law, if the requested material is not one of them.
    materials: Vec<String>,
}

impl Trouble {
    fn new(line: usize, message: impl Into<String>, hint: impl Into<Cow<'static, str>>) -> Self {
        Self {
            line,
            message: message.into(),
            hint: hint.into(),
            materials: Vec::new(),
        }
    }

    /// Returns the error for a deck without a hyperelastic law; `hint` names the expected keywords.
    fn no_law(program: Program, hint: &'static str) -> Self {
        let message = format!(
            "there is no hyperelastic law of {} in this text",
            program.title()
        );
        Self::new(1, message, hint)
    }

    /// Returns the error for a deck whose law is linear elasticity with Young's modulus and Poisson's ratio; `None` for invalid moduli.
    fn linear(line: usize, keyword: &str, [young, poisson]: [f64; 2]) -> Option<Self> {
        let message = format!(
            "{keyword} is linear elasticity of small strains, and the text has no hyperelastic law"
        );
        let hint = format!(
            "in place of the deck, use a law of large strains with these moduli: --set material.model=neo-hooke --set material.young={young} \
             --set material.poisson={poisson}; hypoelastic-jaumann is the rate form in which most programs use the moduli at large strains"
        );
        let is_valid = young > 0.0 && poisson > -1.0 && poisson < 0.5;
        is_valid.then(|| Self::new(line, message, hint))
    }

    /// Returns the error that no material of the requested name has a supported law.
    fn no_such_material(wanted: &str, names: &[impl AsRef<str>]) -> Self {
        let message = format!(
            "no material {} has a hyperelastic law; materials with a law: {}",
            quoted(wanted),
            several(names.iter().map(|name| quoted(name.as_ref())))
        );
        Self {
            materials: names.iter().map(|name| name.as_ref().to_owned()).collect(),
            ..Self::new(1, message, "name one of them with --material")
        }
    }

    fn at(self, name: &str) -> SettingError {
        SettingError::new(place(name, self.line.max(1)), self.message).hint(self.hint)
    }
}

/// Number of foreign names in a message.
const LISTED: usize = 12;

/// First names of a list, and the number of further ones.
fn several(names: impl ExactSizeIterator<Item = String>) -> String {
    let more = names.len().saturating_sub(LISTED);
    let shown: Vec<String> = names.take(LISTED).collect();
    match more {
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}

/// Beginning of the name of a material in a text, quoted if it contains spaces or commas.
fn quoted(name: &str) -> String {
    let name = cut(name);
    match name.contains([' ', ',']) {
        true => format!("\"{name}\""),
        false => name,
    }
}

/// Reads a number as Fortran programs write it, `1.5`, `2E-3` or `2D-3`; an empty field is zero.
fn number(field: &str, line: usize) -> Result<f64, Trouble> {
    let text = field.trim();
    if text.is_empty() {
        return Ok(0.0);
    }
    let plain = text.replace(['d', 'D'], "e");
    let value = plain.parse::<f64>().ok().filter(|value| value.is_finite());
    value.ok_or_else(|| {
        Trouble::new(
            line,
            format!("`{}` is not a number", brief(text)),
            "expected a number, such as 1.5 or 2E-3",
        )
    })
}
