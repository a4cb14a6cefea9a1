//! Short form of the criteria of a law: four criteria, one line per loading.

use super::sentence::{cell, heading, moduli};
use super::{CriteriaAnswer, CriterionAnswer, LoadingAnswer};
use crate::brief::{Brief, Short};
use onset::criteria::Criterion;

/// Criteria of the short form with their heads.
const SHORT_COLUMNS: [(Criterion, &str); 4] = [
    (Criterion::StrongEllipticity, "ellipticity"),
    (Criterion::RankOneConvexity, "rank-one"),
    (Criterion::DruckerAbaqus, "Drucker (Abaqus)"),
    (Criterion::LoadMaximum, "load maximum"),
];
/// Width of the titles of loadings.
const TITLE: usize = 28;
/// Width of a cell with the gap before it: two limits.
const CELL: usize = 18;
/// Significant digits of a limit, which leave room for the marks of bounds.
const DIGITS: usize = 4;

impl Brief for CriteriaAnswer {
    fn brief(&self) -> Short {
        let [low, high] = self.range;
        let head = SHORT_COLUMNS
            .map(|(_, head)| format!("{head:>CELL$}"))
            .concat();
        let table = self.of_each_mode().map(line);
        Short::new(self.summary())
            .table(
                std::iter::once(format!("{:TITLE$}{head}", "stretch at the loss of")).chain(table),
            )
            .row(
                0,
                "limits",
                format!("in compression and in tension from {low} to {high}; - is never"),
            )
            .row(
                1,
                "see also",
                "all criteria, loadings and perturbations: --all; figure: --out DIR",
            )
            .notes(&self.material.notes)
            .settings("material", heading(&self.material))
    }
}

impl CriteriaAnswer {
    /// The first loading of each mode, whose faces are free, if there are several modes; all loadings of a single mode.
    fn of_each_mode(&self) -> impl Iterator<Item = &LoadingAnswer> {
        let first = self.loadings.first().map(|loading| loading.mode);
        let is_single = self.loadings.iter().all(|own| Some(own.mode) == first);
        self.loadings
            .iter()
            .enumerate()
            .filter_map(move |(n, own)| {
                let is_first = self.loadings[..n]
                    .iter()
                    .all(|before| before.mode != own.mode);
                (is_single || is_first).then_some(own)
            })
    }

    /// The law, and where it loses strong ellipticity first.
    fn summary(&self) -> String {
        let lost = |loading: &LoadingAnswer| -> Option<String> {
            let own = answer(loading, Criterion::StrongEllipticity)?;
            let sides = [(&own.tension, "tension"), (&own.compression, "compression")];
            let sides = sides.into_iter().filter(|(side, _)| side.limit.is_some());
            let sides: Vec<String> = sides
                .map(|(side, name)| format!("{} in {name}", cell(own, side, DIGITS)))
                .collect();
            (!sides.is_empty()).then(|| format!("{} ({})", sides.join(" and "), loading.title))
        };
        let name = self.material.name.as_ref().unwrap_or(&self.material.model);
        let law = match moduli(&self.material) {
            Some(moduli) => format!("{name} ({moduli})"),
            None => name.clone(),
        };
        let [low, high] = self.range;
        match self.of_each_mode().find_map(lost) {
            Some(lost) => format!("{law} loses strong ellipticity at a stretch of {lost}."),
            None => format!(
                "{law} is strongly elliptic along the loadings below from stretch {low} to {high}."
            ),
        }
    }
}

fn answer(loading: &LoadingAnswer, criterion: Criterion) -> Option<&CriterionAnswer> {
    let mut own = loading.criteria.iter();
    own.find(|answer| answer.criterion == criterion)
}

/// The limits of a loading in a line.
fn line(loading: &LoadingAnswer) -> String {
    let cells = SHORT_COLUMNS.map(|(criterion, _)| {
        let text = match answer(loading, criterion) {
            Some(own) if own.defined => [&own.compression, &own.tension]
                .map(|side| {
                    let text = match side.limit {
                        None => "-".to_owned(),
                        Some(_) => cell(own, side, DIGITS),
                    };
                    format!("{text:>9}")
                })
                .concat(),
            _ => "not defined".to_owned(),
        };
        format!("{text:>CELL$}")
    });
    format!("{:TITLE$}{}", loading.title, cells.concat())
}
