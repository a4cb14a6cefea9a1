//! Short forms of a comparison and of a recommendation.

use super::names::{Labels, OWN_METHOD};
use super::rank::{EXCLUSIONS, Ranked, recommended};
use super::table::{Column, MATERIAL};
use super::{Recommendation, Table};
use crate::brief::{Brief, Short, WIDTH, cut};
use crate::number::counted;

/// Largest width of the name of a method.
const NAME: usize = 33;

impl Brief for Table {
    fn brief(&self) -> Short {
        let ranking = recommended(self);
        let mut columns = self.columns();
        columns.retain(|column| column.is_in_short);
        // The name leaves room for the cells and the longest verdict.
        let widths = columns.iter().map(|column| column.width(&self.rows) + 2);
        let verdicts = ranking.iter().map(|ranked| ranked.verdict().len() + 2);
        let taken = widths.sum::<usize>() + verdicts.max().unwrap_or(0);
        let width_of_name = NAME.min(WIDTH.saturating_sub(taken));
        let labels = self.labels(width_of_name);
        let shortened = |name: &str| -> String {
            let own = self.rows.iter().position(|row| row.name == name);
            own.map_or_else(|| cut(name, width_of_name), |n| labels.names[n].clone())
        };
        let line = |name: &str, verdict: &str, cell: &dyn Fn(&Column) -> String| {
            let cells = columns.iter().map(|column| {
                let width = column.width(&self.rows);
                format!("  {:>width$}", cell(column))
            });
            let cells: String = cells.collect();
            let name = shortened(name);
            let line = format!("{name:width_of_name$}{cells}  {verdict}");
            line.trim_end().to_owned()
        };
        let head = line("method, best first", "verdict", &|column| {
            column.head.clone()
        });
        let of_material = line(MATERIAL, "", &|column| column.material.clone());
        // The study's method is the first row and is therefore always shown.
        let is_own = |ranked: &&Ranked| ranked.name == OWN_METHOD;
        let shown = ranking.iter().filter(is_own);
        let shown = shown.chain(ranking.iter().filter(|ranked| !is_own(ranked)));
        let lines = shown.map(|ranked| {
            let mut rows = self.rows.iter();
            let row = rows.find(|row| row.name == ranked.name);
            match row.and_then(|row| row.measured.as_ref().ok()) {
                Some(measured) => line(&ranked.name, ranked.verdict(), &|column| {
                    (column.cell)(measured)
                }),
                None => {
                    let why = ranked.excluded.as_ref().map_or("", |(_, why)| why);
                    let name = shortened(&ranked.name);
                    let room = WIDTH - width_of_name - 2;
                    format!("{name:width_of_name$}  {}", cut(why, room))
                }
            }
        });
        let mut short = Short::new(self.summary(&ranking))
            .table([head, of_material].into_iter().chain(lines))
            .row(
                0,
                "verdicts",
                "their rules: onset recommend; columns, compression and other wavelengths: --all",
            )
            .notes(&self.all_notes());
        if let Some(place) = place_of_own(&ranking) {
            short = short.row(0, "own method", place);
        }
        if let Some(keys) = &labels.keys {
            short = short.row(0, "methods", format!("named by {keys}"));
        }
        if let Some(first) = self.rows.first() {
            short = short.settings("material", first.settings.law());
        }
        for row in &self.rows {
            short = short.settings("method", format!("{}: {}", row.name, row.settings.method()));
        }
        short
    }
}

/// Place of the own method of a study in a ranking; `None` if no method has this name.
fn place_of_own(ranking: &[Ranked]) -> Option<String> {
    let at = ranking.iter().position(|own| own.name == OWN_METHOD)?;
    Some(match &ranking[at].excluded {
        None => format!("place {} of {}", at + 1, ranking.len()),
        Some((rule, why)) => format!("excluded, {}: {why}", EXCLUSIONS[rule - 1].1),
    })
}

impl Table {
    /// Distinct names of the methods with at most `width` characters.
    fn labels(&self, width: usize) -> Labels {
        let names: Vec<&str> = self.rows.iter().map(|row| row.name.as_str()).collect();
        Labels::fitting(&names, width)
    }

    /// Sentence on the number of recommended methods and the best of them.
    fn summary(&self, ranking: &[Ranked]) -> String {
        let good = ranking.iter().filter(|ranked| ranked.excluded.is_none());
        let names: Vec<&str> = good.map(|ranked| ranked.name.as_str()).collect();
        let [low, high] = self.options.stretches;
        let (of, all) = (names.len(), counted(self.rows.len(), "method"));
        let what = format!("{} at stretches from {low} to {high}", self.material);
        match names.first() {
            Some(best) => format!("{of} of {all} can be recommended for {what}; best: {best}."),
            None => format!("None of {all} can be recommended for {what}."),
        }
    }
}

impl Brief for Recommendation {
    fn brief(&self) -> Short {
        let good = self
            .ranking
            .iter()
            .filter(|ranked| ranked.excluded.is_none());
        let labels = self.table.labels(NAME);
        let label = |name: &str| {
            let own = self.table.rows.iter().position(|row| row.name == name);
            own.map_or_else(|| cut(name, NAME), |n| labels.names[n].clone())
        };
        let good = good.enumerate().map(|(n, ranked)| {
            let measure = ranked.measure(4);
            format!("{:>2}  {:NAME$}  {measure}", n + 1, label(&ranked.name))
        });
        let mut short = Short::new(self.table.summary(&self.ranking)).table(good);
        if let Some(place) = place_of_own(&self.ranking) {
            short = short.row(0, "own method", place);
        }
        let mut is_first = true;
        for (n, (verdict, rule)) in EXCLUSIONS.into_iter().enumerate() {
            let is_excluded = |ranked: &&Ranked| {
                let mut by = ranked.excluded.iter();
                by.any(|(by, _)| *by == n + 1)
            };
            let names: Vec<&str> = self
                .ranking
                .iter()
                .filter(is_excluded)
                .map(|ranked| ranked.name.as_str())
                .collect();
            if !names.is_empty() {
                let text = match names.len() {
                    1..=2 => names.join(", "),
                    many => format!("{}, {} and {} more", names[0], names[1], many - 2),
                };
                let name = if is_first { "excluded" } else { "" };
                short = short.row(1, name, format!("{verdict} ({rule}): {text}"));
                is_first = false;
            }
        }
        short
            .notes(&self.table.all_notes())
            .settings("material", &self.table.material)
    }
}
