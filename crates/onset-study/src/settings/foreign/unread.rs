//! Parts of a text that are not read, apart from the law.

use super::{NOT_READ, Trouble, number};
use crate::number::{counted, told};
use crate::settings::relaxation::text_of;
use onset::material::PronyTerm;

/// Parts of a text that are not read.
#[derive(Debug, Default)]
pub(super) struct Unread {
    /// Keywords and parameters with their lines.
    pub parts: Vec<(String, usize)>,
    /// Material that is read; `None` for a program without materials.
    pub material: Option<Chosen>,
    /// Viscoelasticity of the law, which is read if it is a Prony series; `None` for an elastic law.
    pub relaxation: Option<Relaxation>,
    /// Mullins effect; `None` for a law without it.
    pub softening: Option<Softening>,
}

/// Keyword of a deck, with its line.
pub(super) type Keyword = (String, usize);

/// Mullins effect that belongs to a law.
#[derive(Debug)]
pub(super) struct Softening {
    /// Constants `[r, m, beta]` of the energy of Ogden and Roxburgh.
    pub constants: [f64; 3],
    /// Keyword with the constants.
    pub keyword: Keyword,
}

/// Material that is read, of the materials with a law in a deck.
#[derive(Debug)]
pub(super) struct Chosen {
    /// Name or number; empty without one.
    pub name: String,
    /// Place among the materials with a law, from 0.
    pub place: usize,
    /// Names or numbers of the materials with a law.
    pub all: Vec<String>,
}

/// Number of other materials that a note names.
const NAMED_MATERIALS: usize = 3;

impl Chosen {
    /// Description of the material, which follows the title of its law.
    pub fn told(&self) -> String {
        let name = match self.name.as_str() {
            "" => String::new(),
            name => format!(", material {}", super::quoted(name)),
        };
        let all = self.all.iter().enumerate();
        let others = all.filter(|(place, _)| *place != self.place);
        let mut others: Vec<String> = others.map(|(_, other)| super::quoted(other)).collect();
        if others.is_empty() {
            return name;
        }
        let (place, count) = (self.place + 1, self.all.len());
        if others.len() > NAMED_MATERIALS {
            others.truncate(NAMED_MATERIALS);
            others.push("...".to_owned());
        }
        format!(
            "{name} ({place} of {count}; --material {})",
            others.join(", ")
        )
    }
}

/// Viscoelasticity that belongs to a law.
#[derive(Debug)]
pub(super) struct Relaxation {
    /// Terms of the Prony series; `None` if the block has no series of a supported form.
    pub terms: Option<Vec<PronyTerm>>,
    /// Whether the constants are long-term moduli.
    pub is_long_term: bool,
    /// Option or convention of the program that determines whether moduli are long-term, in words.
    pub by: &'static str,
    /// Keyword with the series; `None` if it belongs to the block of the law.
    pub keyword: Option<Keyword>,
}

impl Relaxation {
    /// Series of absolute moduli that a program adds to the constants of a law with the given long-term shear modulus.
    pub fn added(shear: f64, moduli: &[(f64, f64)], by: &'static str) -> Self {
        let whole = shear + moduli.iter().map(|(modulus, _)| modulus).sum::<f64>();
        let term = |(modulus, time): &(f64, f64)| PronyTerm {
            shear: modulus / whole,
            bulk: 0.0,
            time: *time,
        };
        Self {
            terms: Some(moduli.iter().map(term).collect()),
            is_long_term: true,
            by,
            keyword: None,
        }
    }

    /// Assignments of the series.
    pub fn assignments(&self) -> Vec<String> {
        let Some(terms) = &self.terms else {
            return Vec::new();
        };
        let moduli = if self.is_long_term {
            "long-term"
        } else {
            "instantaneous"
        };
        vec![
            format!("material.prony={}", text_of(terms)),
            format!("material.moduli={moduli}"),
        ]
    }
}

impl Unread {
    /// Keywords of the Prony series and of the Mullins effect, if they are read.
    pub fn keywords(&self) -> impl Iterator<Item = &str> {
        let series = self.relaxation.as_ref();
        let series = series.filter(|own| own.terms.is_some());
        let series = series.and_then(|own| own.keyword.as_ref());
        let softening = self.softening.as_ref().map(|own| &own.keyword);
        series
            .into_iter()
            .chain(softening)
            .map(|(title, _)| title.as_str())
    }

    /// Adds the temperature (place 0) or a field variable at which constants are given, unless its field is empty.
    pub fn condition(&mut self, place: usize, field: &str, line: usize) -> Result<(), Trouble> {
        if field.trim().is_empty() {
            return Ok(());
        }
        let value = told(number(field, line)?);
        let name = match place {
            0 => format!("temperature {value}"),
            _ => format!("field variable {place} = {value}"),
        };
        self.parts.push((name, line));
        Ok(())
    }

    /// Notes on the parts that are not read and on viscoelasticity; `shear` is the shear modulus of the law.
    pub fn notes(&self, shear: Option<f64>) -> Vec<String> {
        let mut notes = Vec::new();
        if !self.parts.is_empty() {
            let parts = self
                .parts
                .iter()
                .map(|(part, line)| format!("{part} (line {line})"));
            notes.push(format!("{NOT_READ}{}", super::several(parts)));
        }
        if let Some(Relaxation {
            terms,
            is_long_term,
            by,
            ..
        }) = &self.relaxation
        {
            let (own, other, meant) = match is_long_term {
                true => ("long-term", "instantaneous", "waves and time steps"),
                false => ("instantaneous", "long-term", "slow loading"),
            };
            let read = match terms {
                Some(terms) => format!("with a Prony series of {}", counted(terms.len(), "term")),
                None => "and viscoelasticity is ignored".to_owned(),
            };
            let value = terms.as_ref().map_or_else(
                || "not known".to_owned(),
                |terms| {
                    let remaining = 1.0 - terms.iter().map(|term| term.shear).sum::<f64>();
                    let factor = if *is_long_term {
                        remaining.recip()
                    } else {
                        remaining
                    };
                    let modulus = shear
                        .map_or_else(String::new, |shear| format!(", {}", told(factor * shear)));
                    format!("{} times as large{modulus}", told(factor))
                },
            );
            notes.push(format!(
                "the constants are {own} moduli {read}. Reason: {by}. The {other} shear modulus, for {meant}, is {value}"
            ));
        }
        notes
    }
}
