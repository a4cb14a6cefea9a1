//! Comparison of methods by the same measures, with one material.
//!
//! A [`Comparison`] is evaluated to a [`Table`] with one [`Row`] per method. The table is written as text, CSV, page and figure. [`recommended`]
//! ranks the rows by [`rules`].

mod figure;
mod names;
mod page;
mod rank;
mod row;
mod short;
mod table;
mod thresholds;

pub(crate) use names::OWN_METHOD;
pub use rank::{Dependence, Ranked, Recommendation, recommended, rules};
pub(crate) use row::outcome;
pub use row::{Measured, Row, WAVELENGTHS};
pub use table::Table;
pub use thresholds::Thresholds;
pub(crate) use thresholds::{TUNING_LIMITS, percent};

use crate::answers::{Evidence, ProblemError, notes_on_law, notes_on_method};
use crate::output::{Files, picture, text};
use crate::settings::{Candidate, Comparison};
use onset::cancel::Scope;
use rayon::prelude::*;
use std::sync::Arc;

/// Names and texts of the built-in comparisons of all methods, by the number of dimensions minus one.
pub const PANELS: [(&str, &str); 3] = [
    (
        "comparisons/methods-1d.toml",
        include_str!("panels/methods-1d.toml"),
    ),
    (
        "comparisons/methods-2d.toml",
        include_str!("panels/methods-2d.toml"),
    ),
    (
        "comparisons/methods-3d.toml",
        include_str!("panels/methods-3d.toml"),
    ),
];

impl Table {
    /// Evaluates all methods of a comparison on all cores; `told` is called with the name of each finished method.
    ///
    /// The row of a method that cannot be evaluated in the reference state holds the reason.
    ///
    /// # Errors
    /// [`ProblemError`] if the material is not admissible.
    pub fn of(comparison: &Comparison, told: impl Fn(&str) + Sync) -> Result<Self, ProblemError> {
        let material = comparison
            .common
            .material
            .law_in(comparison.dimension())
            .map_err(|error| ProblemError::of(&comparison.common, error.into()))?;
        let row = |candidate: &Candidate| {
            let measured = Measured::of(
                &candidate.settings,
                Arc::clone(&material),
                &comparison.options,
            );
            let row = Row {
                name: candidate.name.clone(),
                settings: candidate.settings.effective(),
                notes: notes_on_method(&candidate.settings),
                measured: measured.map_err(|error| error.to_string()),
            };
            told(&candidate.name);
            row
        };
        let scope = Scope::current();
        let candidates = comparison.candidates.par_iter();
        Ok(Self {
            title: comparison.title.clone(),
            notes: notes_on_law(&comparison.common.material, &*material),
            material: comparison.common.material.model.name().to_owned(),
            dimension: comparison.dimension(),
            options: comparison.options.clone(),
            thresholds: Thresholds {
                weak: comparison.options.weak,
                ..Thresholds::default()
            },
            evidence: Evidence::Searched,
            rows: candidates.map(|own| scope.run(|| row(own))).collect(),
        })
    }
}

impl Table {
    /// Reason why no method of the table can be evaluated; `None` if at least one can.
    pub fn failure(&self) -> Option<String> {
        let first = self.rows.first()?;
        let why = first.measured.as_ref().err()?;
        let is_none = self.rows.iter().all(|row| row.measured.is_err());
        is_none.then(|| {
            format!(
                "none of the methods can be evaluated; \"{}\": {why}",
                first.name
            )
        })
    }

    /// Table as `compare.html` and `compare.csv`, and the figure `compare`.
    pub fn files(&self) -> Files {
        vec![
            text("compare.html", self.html()),
            text("compare.csv", self.csv()),
            picture("compare", self.figure()),
        ]
    }
}
