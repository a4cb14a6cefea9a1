//! Short forms of the criteria of a law, four criteria with one line per loading, and of its card.

use super::card::{BoxAnswer, CardAnswer, Limits};
use super::sentence::{Side, cell, heading, moduli};
use super::{
    CriteriaAnswer, CriterionAnswer, EndAnswer, LawAnswer, LoadingAnswer, Mode, imposed, kink,
    told_place,
};
use crate::brief::{Brief, Short};
use crate::number::{told, told_above, told_below};
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
/// Significant digits of a limit, which leave room for the symbols that mark bounds.
const DIGITS: usize = 4;
/// Significant digits of an amount of shear, which also leave room for its sign.
const SIGNED_DIGITS: usize = 3;

impl Brief for CriteriaAnswer {
    fn brief(&self) -> Short {
        let [low, high] = self.range;
        let head = SHORT_COLUMNS
            .map(|(_, head)| format!("{head:>CELL$}"))
            .concat();
        let table = self.of_each_mode().map(line);
        let has = |is_shear: bool| {
            self.of_each_mode()
                .any(|own| (own.mode == Mode::SimpleShear) == is_shear)
        };
        let what = match (has(false), has(true)) {
            (true, true) => "stretch, gamma at loss of",
            (false, true) => "gamma at the loss of",
            _ => "stretch at the loss of",
        };
        let shear = self
            .range_of_shear()
            .map(|[low, high]| format!("gamma from {low} to {high}"));
        let searched = match (has(false), shear) {
            (false, Some(shear)) => shear,
            (_, None) => format!("in compression and in tension from {low} to {high}"),
            (true, Some(shear)) => {
                format!("in compression and in tension from {low} to {high}; {shear}")
            }
        };
        let table: Vec<String> = table.collect();
        let again = match table.iter().any(|line| line.contains('*')) {
            true => "; * is regained (--all)",
            false => "",
        };
        Short::new(self.summary())
            .table(std::iter::once(format!("{what:TITLE$}{head}")).chain(table))
            .row(0, "limits", format!("{searched}; - is never{again}"))
            .row(
                1,
                "see also",
                "all criteria, loadings and perturbations: --all; figure: --out DIR",
            )
            .notes(&self.material.notes)
            .notes(&self.early_ends())
            .settings("material", heading(&self.material))
    }
}

impl CriteriaAnswer {
    /// Amounts of simple shear that are searched, as they are printed; `None` without simple shear.
    pub(super) fn range_of_shear(&self) -> Option<[String; 2]> {
        let has_shear = self
            .loadings
            .iter()
            .any(|own| own.mode == Mode::SimpleShear);
        let ends = self.range.map(|end| imposed(Mode::SimpleShear, end));
        has_shear.then(|| ends.map(crate::number::told))
    }

    /// Loadings that the short form lists.
    fn of_each_mode(&self) -> impl Iterator<Item = &LoadingAnswer> {
        of_each_mode(&self.loadings, |own| own.mode)
    }

    /// Sentences on the listed loadings whose path ends within the searched range.
    fn early_ends(&self) -> Vec<String> {
        let of = |own: &LoadingAnswer| {
            let ends = [&own.compression_end, &own.tension_end];
            early_ends(own.mode, own.title, ends, self.range)
        };
        self.of_each_mode().filter_map(of).collect()
    }

    /// Sentence on the law and its first loss of strong ellipticity.
    fn summary(&self) -> String {
        let lost = |loading: &LoadingAnswer| -> Option<String> {
            let own = answer(loading, Criterion::StrongEllipticity)?;
            let sides = [(Side::Above, "tension"), (Side::Below, "compression")];
            let lost = sides
                .into_iter()
                .filter(|(side, _)| side.of(own).limit.is_some());
            let told = lost.map(|(side, name)| {
                let place = cell(loading, own, side, DIGITS);
                match loading.mode {
                    Mode::SimpleShear => place,
                    _ => format!("{place} in {name}"),
                }
            });
            let told: Vec<String> = told.collect();
            let what = match loading.mode {
                _ if !own.holds_in_reference => {
                    return Some(
                        "is not strongly elliptic in the reference configuration".to_owned(),
                    );
                }
                Mode::SimpleShear => "gamma =",
                _ => "a stretch of",
            };
            (!told.is_empty()).then(|| {
                let (places, title) = (told.join(" and "), loading.title);
                format!("loses strong ellipticity at {what} {places} ({title})")
            })
        };
        let law = named(&self.material);
        let [low, high] = self.range;
        match self.of_each_mode().find_map(lost) {
            Some(lost) => format!("{law} {lost}."),
            None if self.early_ends().is_empty() => format!(
                "{law} is strongly elliptic along the loadings below from stretch {low} to {high}."
            ),
            None => format!(
                "{law} is strongly elliptic along the loadings below to their ends, which the notes give."
            ),
        }
    }
}

/// Name of a law with its moduli.
fn named(law: &LawAnswer) -> String {
    let name = law.name.as_ref().unwrap_or(&law.model);
    match moduli(law) {
        Some(moduli) => format!("{name} ({moduli})"),
        None => name.clone(),
    }
}

/// Loadings to list: the first loading of each mode, which has free faces, or all loadings if there is only one mode.
fn of_each_mode<T>(loadings: &[T], mode: impl Fn(&T) -> Mode) -> impl Iterator<Item = &T> {
    let is_single = loadings
        .iter()
        .all(|own| Some(mode(own)) == loadings.first().map(&mode));
    loadings.iter().enumerate().filter_map(move |(n, own)| {
        let is_first = loadings[..n].iter().all(|before| mode(before) != mode(own));
        (is_single || is_first).then_some(own)
    })
}

/// Ends of a loading within the searched range, with their reasons.
fn early_ends(mode: Mode, title: &str, ends: [&EndAnswer; 2], range: [f64; 2]) -> Option<String> {
    let ends = ends.into_iter().zip(range).filter_map(|(end, limit)| {
        let reason = end.reason.as_ref()?;
        // A failure needs its cause.
        let reason = match reason.strip_prefix("the law ends there") {
            Some(_) => "the law ends there",
            None => reason,
        };
        let told = |place| told_place(mode, place);
        let is_early = told(end.imposed) != told(imposed(mode, limit));
        is_early.then(|| (told(end.imposed), reason))
    });
    let ends: Vec<_> = ends.collect();
    let told = match &ends[..] {
        [] => return None,
        [(low, reason), (high, other)] if reason == other => {
            format!("{low} and {high} ({reason})")
        }
        _ => {
            let ends = ends.iter();
            let ends = ends.map(|(place, reason)| format!("{place} ({reason})"));
            ends.collect::<Vec<_>>().join(" and ")
        }
    };
    Some(format!("{title} ends at {told}"))
}

impl Brief for CardAnswer {
    fn brief(&self) -> Short {
        let law = named(&self.material);
        let boxes = self.boxes();
        let sentence = match boxes.last() {
            Some((_, found)) => {
                let between = |own: &BoxAnswer| {
                    format!(
                        "between {} and {}",
                        told_above(own.low),
                        told_below(own.high)
                    )
                };
                // The widest box may begin or end at the reference configuration.
                let symmetric = boxes.first().map(|(_, own)| *own);
                let symmetric =
                    symmetric.filter(|own| own.high > found.high || own.low < found.low);
                format!(
                    "{law} is strongly elliptic while all principal stretches lie {}{}{}.",
                    between(found),
                    symmetric.map_or_else(String::new, |own| format!(", or all {}", between(own))),
                    match self.material.isotropic {
                        true => "",
                        false => ", with principal axes along the coordinates",
                    }
                )
            }
            None if self.material.has_boxes() => {
                format!("{law} is not elliptic in the reference configuration.")
            }
            None => format!("Limits of strong ellipticity of {law} along loadings."),
        };
        let head = format!("{:TITLE$}{:>CELL$}{:>CELL$}", "", "compression", "tension");
        let shown = || of_each_mode(&self.loadings, |own| own.mode);
        let line = |own: &Limits| {
            let [below, above] = [own.compression, own.tension]
                .map(|limit| limit.map_or_else(|| "-".to_owned(), told));
            format!("{:TITLE$}{below:>CELL$}{above:>CELL$}", own.title)
        };
        let ends = shown().filter_map(|own| {
            let ends = [&own.compression_end, &own.tension_end];
            early_ends(own.mode, own.title, ends, self.range)
        });
        let kinks = shown().flat_map(|own| {
            let told = |found| format!("{}: {}", own.title, kink(found, own.mode));
            own.kinks.iter().map(told)
        });
        let [low, high] = self.range;
        let mut short = Short::new(sentence).table(std::iter::once(head).chain(shown().map(line)));
        if let Some((_, found)) = boxes.last() {
            short = short.row(1, "limited by", found.ends());
        }
        short
            .row(
                0,
                "limits",
                format!("stretch (simple shear: gamma) at the loss of strong ellipticity, {low} to {high}; - is never"),
            )
            .row(
                2,
                "see also",
                "all loadings, Hill, Drucker, load limits and stresses: --all; a page to print: --out DIR",
            )
            .notes(&self.material.notes)
            .notes(&kinks.collect::<Vec<_>>())
            .notes(&ends.collect::<Vec<_>>())
            .settings("material", heading(&self.material))
    }
}

fn answer(loading: &LoadingAnswer, criterion: Criterion) -> Option<&CriterionAnswer> {
    let mut own = loading.criteria.iter();
    own.find(|answer| answer.criterion == criterion)
}

/// Limits of a loading in one line.
fn line(loading: &LoadingAnswer) -> String {
    let digits = match loading.mode {
        Mode::SimpleShear => SIGNED_DIGITS,
        _ => DIGITS,
    };
    let cells = SHORT_COLUMNS.map(|(criterion, _)| {
        let text = match answer(loading, criterion) {
            Some(own) if own.defined => [Side::Below, Side::Above]
                .map(|side| {
                    let text = match side.of(own).limit {
                        None => "-".to_owned(),
                        Some(_) => cell(loading, own, side, digits),
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
