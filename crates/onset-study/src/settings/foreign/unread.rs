//! Parts of a text that are not read, apart from the law.

use crate::number::told;

/// Parts of a text that are not read.
#[derive(Debug, Default)]
pub(super) struct Unread {
    /// Keywords and parameters with their lines.
    pub parts: Vec<(String, usize)>,
    /// Material that is read, and the names of the other materials with a law; `None` if there are no others.
    pub materials: Option<(String, Vec<String>)>,
    /// Viscoelasticity of the law; `None` for an elastic law.
    pub relaxation: Option<Relaxation>,
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
    /// Notes on the parts that are not read; `shear` is the shear modulus of the law.
    pub fn notes(&self, shear: Option<f64>) -> Vec<String> {
        let mut notes = Vec::new();
        if let Some((own, others)) = self
            .materials
            .as_ref()
            .filter(|(_, others)| !others.is_empty())
        {
            notes.push(format!(
                "this is material {own}; select another with --material: {}",
                others.join(", ")
            ));
        }
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
            let (own, other, when) = match is_long_term {
                true => (
                    "long-term",
                    "instantaneous",
                    "which governs waves and time steps",
                ),
                false => ("instantaneous", "long-term", "which governs slow loading"),
            };
            let value =
                part.filter(|part| (0.0..1.0).contains(part))
                    .map_or_else(String::new, |part| {
                        let factor = if *is_long_term {
                            1.0 / (1.0 - part)
                        } else {
                            1.0 - part
                        };
                        let modulus = shear.map_or_else(String::new, |shear| {
                            format!(", {}", told(factor * shear))
                        });
                        format!(" is {} times that of the law{modulus}", told(factor))
                    });
            notes.push(format!(
                "the constants are {own} moduli ({by}), and viscoelasticity is ignored: the {other} shear modulus, {when},{}",
                if value.is_empty() { " differs" } else { &value }
            ));
        }
        notes
    }
}
