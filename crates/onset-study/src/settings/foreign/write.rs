//! Writers of laws as blocks of other programs, in the convention of the program.

use super::law::{LOGARITHM, SQUARE};
use super::{Program, abaqus, ansys, febio, lsdyna, python, radioss};
use crate::settings::did_you_mean;
use thiserror::Error;

/// Law written as a block of another program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Writing {
    /// Block with comment lines.
    pub text: String,
    /// Remarks, which are also in the comment lines; empty if the program has the same law.
    pub notes: Vec<String>,
}

/// Reasons why a law cannot be written as a block.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum WriteError {
    /// The name belongs to no law that can be written.
    #[error("{law} cannot be written for other programs; laws that can: {}{}", NAMES.join(", "), did_you_mean(law, NAMES))]
    Law {
        /// Name of the law in the call.
        law: String,
    },
    /// A parameter is missing, unknown or outside of its range.
    #[error("{law}: {message}")]
    Parameter {
        /// Name of the law.
        law: &'static str,
        /// Description of the error.
        message: String,
    },
    /// The program lacks the law.
    #[error("{} has no {law} of this form; {}", program.title(), having(others))]
    Lacks {
        /// Program of the block.
        program: Program,
        /// Name of the law.
        law: &'static str,
        /// Programs that have it.
        others: Vec<Program>,
    },
    /// The program has the law, but not with these constants.
    #[error("{}: {message}", program.title())]
    Constants {
        /// Program of the block.
        program: Program,
        /// Description of the error.
        message: String,
    },
}

fn having(others: &[Program]) -> String {
    let names: Vec<&str> = others.iter().map(|program| program.title()).collect();
    match names.is_empty() {
        true => "no program has it".to_owned(),
        false => format!("programs that have it: {}", names.join(", ")),
    }
}

/// Laws that can be written.
const NAMES: [&str; 8] = [
    "neo-hooke-isochoric",
    "mooney-rivlin-isochoric",
    "yeoh",
    "polynomial",
    "ogden",
    "arruda-boyce",
    "gent",
    "hyperfoam",
];

/// Law in the form that the writers of all programs take.
pub(super) struct Sheet {
    pub form: Form,
    /// Bulk modulus; `None` for an incompressible material. Units of stress.
    pub bulk: Option<f64>,
    /// Volumetric function of the law.
    pub function: &'static str,
}

/// Energy at constant volume, or of the whole deformation for foams.
pub(super) enum Form {
    /// Constants of the polynomial `sum c_ij (I1bar - 3)^i (I2bar - 3)^j`.
    Polynomial(Vec<((usize, usize), f64)>),
    /// Moduli and exponents of Ogden's terms `mu/alpha (sum lbar^alpha - 3)`.
    Ogden(Vec<(f64, f64)>),
    /// Five terms of the series with modulus and locking stretch.
    ArrudaBoyce(f64, f64),
    /// Shear modulus and limit of `I1bar - 3`.
    Gent(f64, f64),
    /// Terms `mu`, `alpha`, `beta` of `2 mu/alpha^2 (sum lambda^alpha - 3 + (J^(-alpha beta) - 1)/beta)`.
    Foam(Vec<[f64; 3]>),
}

/// Lines of a block, with the volumetric function of the program unless the constants determine it.
pub(super) struct Block {
    pub lines: Vec<String>,
    pub function: Option<&'static str>,
    /// Remarks for the reader of the block.
    pub notes: Vec<String>,
}

/// Reason why a program has no block for a law.
pub(super) enum Refusal {
    /// The program lacks the law.
    Lacks,
    /// The program has the law, but not with these constants.
    Constants(String),
}

/// Writes a law as a block of another program.
///
/// The parameters have the names of the library; without `kappa` the material is incompressible. `polynomial` has the constants `c10`, `c01`, `c20`,
/// ... of `sum c_ij (I1bar - 3)^i (I2bar - 3)^j` and `kappa` of `kappa/2 (J - 1)^2`. Terms without a modulus are not part of the law.
///
/// If the program has another volumetric energy, the block has the same bulk modulus and the same energy at constant volume, and a note says so.
///
/// ```
/// use onset_study::settings::{Program, law_written};
/// let parameters = [("mu1", 0.6), ("alpha1", 1.3), ("kappa", 50.0)];
/// let written = law_written(Program::Abaqus, "ogden", &parameters)?;
/// assert!(written.text.ends_with("*HYPERELASTIC, OGDEN, N=1\n0.39, 1.3, 0.04\n"));
/// # Ok::<(), onset_study::settings::WriteError>(())
/// ```
///
/// # Errors
/// [`WriteError`] if the law is unknown, its parameters are incomplete, or the program lacks it.
pub fn law_written(
    program: Program,
    law: &str,
    parameters: &[(&str, f64)],
) -> Result<Writing, WriteError> {
    let name = NAMES.into_iter().find(|name| *name == law);
    let law = name.ok_or_else(|| WriteError::Law {
        law: law.to_owned(),
    })?;
    let sheet = sheet(law, parameters).map_err(|message| WriteError::Parameter { law, message })?;
    let block = block(program, &sheet).map_err(|refusal| match refusal {
        Refusal::Constants(message) => WriteError::Constants { program, message },
        Refusal::Lacks => WriteError::Lacks {
            program,
            law,
            others: Program::ALL
                .into_iter()
                .filter(|other| !matches!(block(*other, &sheet), Err(Refusal::Lacks)))
                .collect(),
        },
    })?;
    let mut notes = block.notes;
    if let Some(own) = block.function.filter(|own| *own != sheet.function) {
        notes.push(format!(
            "volumetric energy: {} has {own}, {law} has {}. The bulk modulus and the energy at constant volume are equal",
            program.title(),
            sheet.function
        ));
    }
    let density = match program {
        Program::LsDyna | Program::Radioss | Program::Febio => "; the density 1 is a placeholder",
        _ => "",
    };
    let head = format!("law {law}; stresses in the units of the input{density}");
    let comments = [head].into_iter().chain(notes.iter().cloned());
    let lines = comments.map(|line| comment(program, &line));
    let lines: Vec<String> = lines.chain(block.lines).collect();
    Ok(Writing {
        text: lines.join("\n") + "\n",
        notes,
    })
}

fn block(program: Program, sheet: &Sheet) -> Result<Block, Refusal> {
    match program {
        Program::Abaqus | Program::Calculix => abaqus::write(program, sheet),
        Program::Ansys => ansys::write(sheet),
        Program::LsDyna => lsdyna::write(sheet),
        Program::Radioss => radioss::write(sheet),
        Program::Febio => febio::write(sheet),
        Program::Felupe | Program::Hyperelastic => python::write(program, sheet),
    }
}

fn comment(program: Program, text: &str) -> String {
    match program {
        Program::Abaqus | Program::Calculix => format!("** {text}"),
        Program::Ansys => format!("! {text}"),
        Program::LsDyna => format!("$ {text}"),
        Program::Febio => format!("<!-- {text} -->"),
        Program::Radioss | Program::Felupe | Program::Hyperelastic => format!("# {text}"),
    }
}

/// Parameters that were given, each taken once.
struct Given<'p> {
    rest: Vec<(&'p str, f64)>,
}

impl Given<'_> {
    fn take(&mut self, name: &str) -> Option<f64> {
        let place = self.rest.iter().position(|(own, _)| *own == name)?;
        Some(self.rest.swap_remove(place).1)
    }

    fn required(&mut self, name: &str) -> Result<f64, String> {
        self.take(name).ok_or_else(|| format!("{name} is missing"))
    }

    /// Numbered terms with nonzero moduli; the last name with a number is the last term.
    fn terms<const N: usize>(&mut self, names: [&str; N]) -> Result<Vec<[f64; N]>, String> {
        let mut terms = Vec::new();
        for n in 1..=6 {
            let own = names.map(|name| format!("{name}{n}"));
            let Some(modulus) = self.take(&own[0]) else {
                continue;
            };
            let mut term = [modulus; N];
            for (value, name) in term.iter_mut().zip(&own).skip(1) {
                *value = match modulus == 0.0 {
                    true => self.take(name).unwrap_or(1.0),
                    false => self.required(name)?,
                };
            }
            if modulus != 0.0 {
                terms.push(term);
            }
        }
        match terms.iter().any(|term| term[1] == 0.0) {
            true => Err("an exponent alpha is 0".to_owned()),
            false if terms.is_empty() => Err("all moduli are zero".to_owned()),
            false => Ok(terms),
        }
    }
}

fn sheet(law: &str, parameters: &[(&str, f64)]) -> Result<Sheet, String> {
    if let Some((name, value)) = parameters.iter().find(|(_, value)| !value.is_finite()) {
        return Err(format!("{name} is {value}; expected a finite number"));
    }
    let mut given = Given {
        rest: parameters.to_vec(),
    };
    let bulk = given.take("kappa");
    if let Some(bulk) = bulk.filter(|bulk| *bulk <= 0.0) {
        return Err(format!("kappa is {bulk}; expected a positive bulk modulus"));
    }
    let (form, function) = match law {
        "neo-hooke-isochoric" => (
            Form::Polynomial(vec![((1, 0), 0.5 * given.required("mu")?)]),
            LOGARITHM,
        ),
        "mooney-rivlin-isochoric" => (given.polynomial(&["c10", "c01"])?, SQUARE),
        "yeoh" => (given.polynomial(&["c10", "c20", "c30"])?, SQUARE),
        "polynomial" => {
            let names: Vec<&str> = given.rest.iter().map(|(name, _)| *name).collect();
            (given.polynomial(&names)?, SQUARE)
        }
        "ogden" => {
            let terms = given.terms(["mu", "alpha"])?;
            let terms = terms.into_iter().map(|[mu, alpha]| (mu, alpha));
            (Form::Ogden(terms.collect()), SQUARE)
        }
        "arruda-boyce" => (
            Form::ArrudaBoyce(given.required("mu")?, given.required("locking")?),
            LOGARITHM,
        ),
        "gent" => (
            Form::Gent(given.required("mu")?, given.required("jm")?),
            LOGARITHM,
        ),
        _ => (Form::Foam(given.terms(["mu", "alpha", "beta"])?), SQUARE),
    };
    if let Some((name, _)) = given.rest.first() {
        return Err(format!("there is no parameter `{name}`"));
    }
    let sheet = Sheet {
        form,
        bulk,
        function,
    };
    match sheet.shear() > 0.0 {
        true => Ok(sheet),
        false => Err(format!(
            "the shear modulus is {}; expected a positive number",
            sheet.shear()
        )),
    }
}

impl Given<'_> {
    /// Constants `c_ij` by their names.
    fn polynomial(&mut self, names: &[&str]) -> Result<Form, String> {
        let mut constants = Vec::new();
        for name in names {
            let mut digits = name.strip_prefix('c').unwrap_or("").chars();
            let powers = [digits.next(), digits.next()].map(|digit| digit?.to_digit(10));
            let ([Some(i), Some(j)], None) = (powers, digits.next()) else {
                return Err(format!(
                    "there is no parameter `{name}`; expected c10, c01, c20, ..."
                ));
            };
            let value = self.required(name)?;
            match (i, j) {
                (0, 0) => return Err("c00 is not a part of the energy".to_owned()),
                _ if value == 0.0 => {}
                _ => constants.push(((i as usize, j as usize), value)),
            }
        }
        Ok(Form::Polynomial(constants))
    }
}

impl Sheet {
    /// Shear modulus at small strains, in units of stress; for Arruda-Boyce and Gent the modulus of the chains.
    pub fn shear(&self) -> f64 {
        match &self.form {
            Form::Polynomial(constants) => {
                let linear = constants.iter().filter(|((i, j), _)| i + j == 1);
                2.0 * linear.map(|(_, value)| value).sum::<f64>()
            }
            Form::Ogden(terms) => 0.5 * terms.iter().map(|(mu, alpha)| mu * alpha).sum::<f64>(),
            Form::ArrudaBoyce(mu, _) | Form::Gent(mu, _) => *mu,
            Form::Foam(terms) => terms.iter().map(|[mu, _, _]| mu).sum(),
        }
    }

    /// Bulk modulus, in units of stress, for programs that need one.
    pub fn required_bulk(&self) -> Result<f64, Refusal> {
        self.bulk.ok_or_else(|| {
            Refusal::Constants(
                "a block needs the bulk modulus; add kappa, for example 1000 shear moduli"
                    .to_owned(),
            )
        })
    }

    /// Poisson's ratio at small strains.
    pub fn poisson(&self) -> Result<f64, Refusal> {
        let (shear, bulk) = (self.shear(), self.required_bulk()?);
        let poisson = (3.0 * bulk - 2.0 * shear) / (2.0 * (3.0 * bulk + shear));
        match poisson < 0.5 && poisson != 0.0 {
            true => Ok(poisson),
            false => Err(Refusal::Constants(format!(
                "the bulk modulus {bulk} corresponds to no Poisson's ratio between 0 and 0.5 in double precision"
            ))),
        }
    }
}

/// Constants of a polynomial in the given order. Refuses the law if it has other constants.
pub(super) fn ordered(
    constants: &[((usize, usize), f64)],
    powers: &[(usize, usize)],
) -> Result<Vec<f64>, Refusal> {
    match constants.iter().all(|(own, _)| powers.contains(own)) {
        false => Err(Refusal::Lacks),
        true => Ok(powers
            .iter()
            .map(|own| {
                let found = constants.iter().find(|(other, _)| other == own);
                found.map_or(0.0, |(_, value)| *value)
            })
            .collect()),
    }
}

/// Largest sum of the powers, and whether the energy depends on the first invariant only.
pub(super) fn order(constants: &[((usize, usize), f64)]) -> (usize, bool) {
    let powers = constants.iter().map(|(powers, _)| *powers);
    let order = powers.clone().map(|(i, j)| i + j).max().unwrap_or(1);
    (order, powers.clone().all(|(_, j)| j == 0))
}

/// Number in at most 20 columns, the width of a field in most programs.
pub(super) fn digits(value: f64) -> String {
    let shortest = format!("{value:?}");
    let forms = [shortest, format!("{value:.13e}"), format!("{value:.12e}")];
    let fitting = forms.into_iter().find(|form| form.len() <= 20);
    fitting.unwrap_or_else(|| format!("{value:.11e}"))
}

/// Numbers in fields of 20 columns.
pub(super) fn columns(values: &[f64]) -> String {
    let fields = values.iter().map(|value| format!("{:>20}", digits(*value)));
    fields.collect()
}

/// Numbers with commas between them.
pub(super) fn list(values: &[f64]) -> String {
    let fields: Vec<String> = values.iter().map(|value| digits(*value)).collect();
    fields.join(", ")
}

/// Poisson's ratio `nu` of a foam's term with `beta = nu/(1 - 2 nu)`.
pub(super) fn ratio(beta: f64) -> Result<f64, Refusal> {
    let ratio = beta / (1.0 + 2.0 * beta);
    match ratio.is_finite() && ratio < 0.5 {
        true => Ok(ratio),
        false => Err(Refusal::Constants(format!(
            "beta = {beta} corresponds to no Poisson's ratio below 0.5"
        ))),
    }
}
