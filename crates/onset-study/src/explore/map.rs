//! Map of a window: first coarse, then refined where its verdicts change.

use super::{Question, Refusal};
use crate::domain::{Class, Domain};
use crate::settings::{Study, Trust};
use serde::Serialize;
use std::sync::{Mutex, PoisonError};

/// Number of states along an axis of the coarsest map, by dimension. A state in 3D is a hundred times slower than a state in 2D.
const COARSEST_STATES: [usize; 3] = [12, 12, 6];
/// Largest number of refinements.
pub(super) const LEVELS: u32 = 3;
/// Number of states along an axis of the finest map in 2D.
pub(super) const FINEST_STATES: usize = COARSEST_STATES[1] << LEVELS;
/// Number of states along an axis between which boundaries are searched for; the curves then have the accuracy of the command.
pub(super) const CURVE_STATES: usize = 32;
/// Number of cached maps.
const CACHED_MAPS: usize = 8;

/// Map as shown by a page.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct ShownMap {
    /// Axes of the map.
    pub(super) axes: [ShownAxis; 2],
    /// Class of each state as an index into the catalog, the first axis running fastest; `null` for states that are not stored.
    pub(super) classes: Vec<Option<u8>>,
    /// Number of refinements from the coarsest level.
    pub(super) level: u32,
    /// Whether this is the finest level.
    pub(super) is_finest: bool,
}

/// Axis as shown by a page.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct ShownAxis {
    name: String,
    label: String,
    range: [f64; 2],
    states: usize,
}

/// Axes of a study, with the given numbers of cells.
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

/// Index of a class in the catalog.
pub(super) fn number(class: Class) -> Option<u8> {
    let place = Class::ALL.iter().position(|other| *other == class);
    place.map(|place| place as u8)
}

/// Cache of recent maps, by the text of their studies.
#[derive(Default)]
pub(super) struct Maps(Mutex<Vec<(String, Domain)>>);

impl Maps {
    /// Map of a question at the requested level.
    pub(super) fn shown(&self, question: &Question, trust: &Trust) -> Result<ShownMap, Refusal> {
        let level = question.level.min(LEVELS);
        let domain = self.domain(question, trust, level)?;
        let [first, second] = domain.study.plane();
        Ok(ShownMap {
            axes: axes(&domain.study, (first.count, second.count)),
            classes: domain.classes.iter().map(|class| number(*class)).collect(),
            level,
            is_finest: level == LEVELS,
        })
    }

    /// Map of a question as a domain, obtained by refinement of the previous level.
    pub(super) fn domain(
        &self,
        question: &Question,
        trust: &Trust,
        level: u32,
    ) -> Result<Domain, Refusal> {
        let dimension = question.settings(trust)?.dimension();
        let study = question.study(trust, COARSEST_STATES[dimension - 1] << level)?;
        let name = study.document();
        if let Some(known) = self.known(&name) {
            return Ok(known);
        }
        let domain = match level {
            0 => Domain::of(&study)?,
            _ => {
                let coarser = self.domain(question, trust, level - 1)?;
                coarser.halved()?
            }
        };
        let mut maps = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        maps.push((name, domain.clone()));
        let extra = maps.len().saturating_sub(CACHED_MAPS);
        maps.drain(..extra);
        Ok(domain)
    }

    fn known(&self, name: &str) -> Option<Domain> {
        let maps = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let found = maps.iter().find(|(own, _)| own == name);
        found.map(|(_, domain)| domain.clone())
    }
}
