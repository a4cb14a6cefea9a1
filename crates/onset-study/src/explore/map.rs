//! The map of a window, coarse first, then finer where its verdicts change.

use super::{Question, Refusal};
use crate::domain::{Class, Domain};
use crate::settings::{Study, Trust};
use onset::bloch::IsEnded;
use serde::Serialize;
use std::sync::{Mutex, PoisonError};

/// States along an axis of the coarsest map, by dimension: a state in space takes a hundred times as long as one in the plane.
const COARSEST: [usize; 3] = [12, 12, 6];
/// How often they are halved at most.
pub(super) const LEVELS: u32 = 3;
/// States along an axis of the finest map in the plane.
pub(super) const FINEST: usize = COARSEST[1] << LEVELS;
/// States along an axis between which boundaries are looked for; they are traced from there as exactly as by the command.
pub(super) const OF_CURVES: usize = 32;
/// How many maps are remembered.
const REMEMBERED: usize = 8;

/// A map as a page shows it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct ShownMap {
    /// The axes.
    pub(super) axes: [ShownAxis; 2],
    /// The number of the class of each state among those of the catalog, the first axis running fastest; `null` where none is stored.
    pub(super) classes: Vec<Option<u8>>,
    /// How often its states were halved.
    pub(super) level: u32,
    /// Whether it is the finest.
    pub(super) is_finest: bool,
}

/// An axis as a page shows it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct ShownAxis {
    name: String,
    label: String,
    range: [f64; 2],
    states: usize,
}

/// The axes of a study, in so many cells.
pub(super) fn axes(study: &Study, cells: (usize, usize)) -> [ShownAxis; 2] {
    let [first, second] = study.plane();
    let units = study.settings.units();
    [(first, cells.0), (second, cells.1)].map(|(axis, states)| ShownAxis {
        name: axis.name().to_owned(),
        label: axis.label(units),
        range: [axis.range.0, axis.range.1],
        states,
    })
}

/// The number of a class among all.
pub(super) fn number(class: Class) -> Option<u8> {
    let place = Class::ALL.iter().position(|other| *other == class);
    place.map(|place| place as u8)
}

/// The maps that were asked for last, by the text of their studies.
#[derive(Default)]
pub(super) struct Maps(Mutex<Vec<(String, Domain)>>);

impl Maps {
    /// The map of a question at the fineness that it asks for.
    pub(super) fn shown(
        &self,
        question: &Question,
        trust: &Trust,
        is_ended: IsEnded<'_>,
    ) -> Result<ShownMap, Refusal> {
        let level = question.level.min(LEVELS);
        let domain = self.domain(question, trust, level, is_ended)?;
        let [first, second] = domain.study.plane();
        Ok(ShownMap {
            axes: axes(&domain.study, (first.count, second.count)),
            classes: domain.classes.iter().map(|class| number(*class)).collect(),
            level,
            is_finest: level == LEVELS,
        })
    }

    /// The same as a map: the coarser one, halved.
    pub(super) fn domain(
        &self,
        question: &Question,
        trust: &Trust,
        level: u32,
        is_ended: IsEnded<'_>,
    ) -> Result<Domain, Refusal> {
        let dimension = question.settings(trust)?.dimension();
        let study = question.study(trust, COARSEST[dimension - 1] << level)?;
        let name = study.document();
        if let Some(known) = self.known(&name) {
            return Ok(known);
        }
        let domain = match level {
            0 => Domain::of_unless(&study, is_ended)?,
            _ => {
                let coarser = self.domain(question, trust, level - 1, is_ended)?;
                coarser.halved_unless(is_ended)?
            }
        };
        let mut maps = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        maps.push((name, domain.clone()));
        let extra = maps.len().saturating_sub(REMEMBERED);
        maps.drain(..extra);
        Ok(domain)
    }

    fn known(&self, name: &str) -> Option<Domain> {
        let maps = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let found = maps.iter().find(|(own, _)| own == name);
        found.map(|(_, domain)| domain.clone())
    }
}
