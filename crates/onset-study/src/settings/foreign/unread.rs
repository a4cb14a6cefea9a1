//! Parts of a text that are not read, apart from the law.

use super::{Trouble, number};
use crate::number::told;

/// Parts of a text that are not read.
#[derive(Debug, Default)]
pub(super) struct Unread {
    /// Keywords and parameters with their lines.
    pub parts: Vec<(String, usize)>,
    /// Material that is read; `None` for a program without materials.
    pub material: Option<Chosen>,
    /// Viscoelasticity of the law; `None` for an elastic law.
    pub relaxation: Option<Relaxation>,
}

/// Material that is read, of the materials with a law in a deck.
#[derive(Debug)]
pub(super) struct Chosen {
    /// Name or number; empty without one.
    pub name: String,
    /// Place among the materials with a law, from 0.
    pub place: usize,
    /// Number of materials with a law.
    pub count: usize,
}

impl Chosen {
    /// Description of the material, which follows the title of its law.
    pub fn told(&self) -> String {
        let name = match self.name.as_str() {
            "" => String::new(),
            name => format!(", material {}", super::quoted(name)),
        };
        match self.count {
            0 | 1 => name,
            count => format!("{name} ({} of {count}; --material chooses)", self.place + 1),
        }
    }
}

/// Viscoelasticity that belongs to a law.
#[derive(Debug)]
pub(super) struct Relaxation {
    /// Sum of the relaxing fractions of the shear modulus; `None` if the block does not give it.
    pub part: Option<f64>,
    /// Whether the constants are long-term moduli.
    pub is_long_term: bool,
    /// Option or convention of the program that determines whether moduli are long-term, in words.
    pub by: &'static str,
}

impl Unread {
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

    /// Notes on the parts that are not read; `shear` is the shear modulus of the law.
    pub fn notes(&self, shear: Option<f64>) -> Vec<String> {
        let mut notes = Vec::new();
        if !self.parts.is_empty() {
            let parts = self
                .parts
                .iter()
                .map(|(part, line)| format!("{part} (line {line})"));
            notes.push(format!(
                "not read: {}",
                parts.collect::<Vec<_>>().join(", ")
            ));
        }
        if let Some(Relaxation {
            part,
            is_long_term,
            by,
        }) = &self.relaxation
        {
            let (own, other, meant) = match is_long_term {
                true => ("long-term", "instantaneous", "waves and time steps"),
                false => ("instantaneous", "long-term", "slow loading"),
            };
            let part = part.filter(|part| (0.0..1.0).contains(part));
            let value = part.map_or_else(
                || "another one".to_owned(),
                |part| {
                    let factor = match is_long_term {
                        true => 1.0 / (1.0 - part),
                        false => 1.0 - part,
                    };
                    let modulus = shear
                        .map_or_else(String::new, |shear| format!(", {}", told(factor * shear)));
                    format!("{} times as large{modulus}", told(factor))
                },
            );
            notes.push(format!(
                "the constants are {own} moduli ({by}), and viscoelasticity is ignored; the {other} shear modulus, for {meant}, is {value}"
            ));
        }
        notes
    }
}
