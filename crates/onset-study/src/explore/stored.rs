//! Stored map shown by a page.

use super::map::{LEVELS, ShownMap, axes, number};
use super::question::of_study;
use super::{Question, Refusal};
use crate::plot::{PlotError, Section};
use serde::Serialize;
use std::path::Path;

/// Stored map with two axes, or the section of a map with three axes at the middle of the third axis.
pub struct Stored(Section);

/// Content of a stored map for a page.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Shown {
    title: String,
    /// Position of the section on the third axis.
    section: Option<String>,
    question: Question,
    map: ShownMap,
}

impl Stored {
    /// Opens a store, without loading the library that it names.
    ///
    /// # Errors
    /// [`PlotError`] if it is not a store, or cannot be read.
    pub fn open(path: &Path) -> Result<Self, PlotError> {
        Section::middle(path).map(Self)
    }

    /// Question about the stored map.
    ///
    /// # Errors
    /// [`Refusal`] if a page cannot show its axes.
    pub fn question(&self) -> Result<Question, Refusal> {
        of_study(&self.0.study)
    }

    pub(super) fn shown(&self) -> Result<Shown, Refusal> {
        let Section {
            title,
            name,
            study,
            cells,
            classes,
        } = &self.0;
        Ok(Shown {
            title: title.clone(),
            section: name.clone(),
            question: self.question()?,
            map: ShownMap {
                axes: axes(study, *cells),
                classes: classes.iter().map(|class| number((*class)?)).collect(),
                level: LEVELS,
                is_finest: true,
            },
        })
    }
}
