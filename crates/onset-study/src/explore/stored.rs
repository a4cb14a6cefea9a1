//! A stored map that a page shows.

use super::map::{LEVELS, ShownMap, axes, number};
use super::question::of_study;
use super::{Question, Refusal};
use crate::plot::{PlotError, Section};
use serde::Serialize;
use std::path::Path;

/// A stored map: of one with three axes the section in the middle of the third.
pub struct Stored(Section);

/// What is shown of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Shown {
    title: String,
    /// Where on the third axis it is.
    section: Option<String>,
    question: Question,
    map: ShownMap,
}

impl Stored {
    /// Opens a store; no library that it names is loaded.
    ///
    /// # Errors
    /// [`PlotError`] when it is none, or cannot be read.
    pub fn open(path: &Path) -> Result<Self, PlotError> {
        Section::middle(path).map(Self)
    }

    /// The question that it answers.
    ///
    /// # Errors
    /// [`Refusal`] when its axes are not those of a page.
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
