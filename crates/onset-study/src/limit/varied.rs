//! Varied setting of an answer: its values as text, in the rows of the table and on the axis of the figure.

use super::interval::{Admitted, End, EndKind, Trial};
use crate::figure::{Axis, Panel, Points, Rule, palette};
use crate::number::{told, told_above, told_below};
use crate::settings::{Key, Units};

/// Ratio of the range of the figure to the outermost limits and the present value.
const NEIGHBORHOOD: f64 = 10.0;

/// The varied setting of an answer, with all results.
pub(super) struct Varied<'a, T> {
    pub(super) key: &'static str,
    /// Unit of the setting; `None` if values have no units.
    pub(super) unit: Option<&'static str>,
    pub(super) units: Units,
    pub(super) admitted: &'a [Admitted],
    /// Results in increasing order of the values.
    pub(super) tried: &'a [T],
    pub(super) present: Option<&'a T>,
    /// Whether the user gave the range of values.
    pub(super) is_range_given: bool,
}

impl<'a, T: Trial> Varied<'a, T> {
    /// Value as text, with its unit.
    pub(super) fn value(&self, told: String) -> String {
        self.units
            .of(told, self.unit.unwrap_or_default())
            .trim_end()
            .to_owned()
    }

    /// Smallest and largest value tried; NaN without values.
    fn ends(&self) -> [f64; 2] {
        [self.tried.first(), self.tried.last()].map(|one| one.map_or(f64::NAN, T::value))
    }

    /// Smallest and largest value tried, as text.
    pub(super) fn ends_told(&self) -> [String; 2] {
        self.ends().map(|end| self.value(told(end)))
    }

    /// Ends of the admitted intervals.
    fn all_ends(&self) -> impl Iterator<Item = &'a End> + use<'a, T> {
        self.admitted.iter().flat_map(|own| [&own.from, &own.to])
    }

    /// Admitted values as text, rounded inward, so that a printed value is admitted.
    pub(super) fn ranges(&self) -> String {
        let key = self.key;
        let is_open = |end: &End| end.kind == EndKind::Range;
        let from = |own: &Admitted| self.value(told_above(own.from.value));
        let to = |own: &Admitted| self.value(told_below(own.to.value));
        match self.admitted {
            [only] if is_open(&only.from) && is_open(&only.to) => {
                format!("every {key} from {} to {}", from(only), to(only))
            }
            [only] if is_open(&only.from) => format!("{key} up to {}", to(only)),
            [only] if is_open(&only.to) => {
                let [_, last] = self.ends_told();
                format!("{key} from {} up to at least {last}", from(only))
            }
            several => {
                let several = several.iter();
                let all: Vec<String> = several
                    .map(|own| format!("from {} to {}", from(own), to(own)))
                    .collect();
                format!("{key} {}", all.join(", and "))
            }
        }
    }

    /// Sentences on intervals that end because values beyond the end cannot be evaluated.
    pub(super) fn ends_of_domain(&self) -> impl Iterator<Item = String> {
        self.all_ends().filter_map(|end| {
            let note = end.note.as_deref()?.lines().next()?;
            let [from, to] = [end.value, end.undefined_at?].map(|own| self.value(told(own)));
            Some(format!(
                "At {to}: {note}; no value between {from} and {to} was tried."
            ))
        })
    }

    /// Head of the column of values.
    pub(super) fn heading(&self) -> String {
        match self.unit {
            Some(unit) => format!("value ({unit})"),
            None => "value".to_owned(),
        }
    }

    /// Rows of the text: the values of the grid and the ends of the intervals.
    pub(super) fn rows(&self) -> impl Iterator<Item = &'a T> + use<'a, T> {
        let ends: Vec<f64> = self.all_ends().map(|end| end.value).collect();
        let tried = self.tried.iter();
        tried.filter(move |one| !one.is_refined() || ends.contains(&one.value()))
    }

    /// Rows of the short text: at most `most` rows next to the limits and to the present value.
    pub(super) fn rows_near_limits(&self, most: usize) -> Vec<&'a T> {
        let rows: Vec<&T> = self.rows().collect();
        let limits = self.all_ends().filter(|end| end.kind != EndKind::Range);
        let limits: Vec<f64> = limits.map(|end| end.value).collect();
        // Number of rows between a row and a place.
        let apart = |n: usize, place: f64| {
            let below = rows.iter().filter(|row| row.value() < place).count();
            n.abs_diff(below.min(rows.len().saturating_sub(1)))
        };
        // The neighbors of a limit go before the neighbors of the present value.
        let distance = |n: usize| {
            let to_limits = limits.iter().map(|place| 2 * apart(n, *place));
            let to_present = self.present.map(|own| 2 * apart(n, own.value()) + 1);
            to_limits.chain(to_present).min().unwrap_or(n)
        };
        let mut order: Vec<usize> = (0..rows.len()).collect();
        order.sort_by_key(|n| distance(*n));
        order.truncate(most);
        order.sort_unstable();
        order.into_iter().map(|n| rows[n]).collect()
    }

    /// Dimension of the values, for a table.
    pub(super) fn dimension(&self) -> &'static str {
        Key::named(self.key).and_then(Key::unit).unwrap_or("1")
    }

    /// Title of the setting.
    pub(super) fn title(&self) -> &'static str {
        Key::named(self.key).map_or(self.key, Key::title)
    }

    /// Axis over the values of points near the limits and the present value, and the points that it shows.
    pub(super) fn axis(&self, points: &[(f64, f64)]) -> (Axis, Vec<(f64, f64)>) {
        let [low, high] = self.window();
        let shown = points
            .iter()
            .filter(|point| (low..=high).contains(&point.0));
        let shown: Vec<(f64, f64)> = shown.copied().collect();
        let label = Key::named(self.key).map_or_else(String::new, |key| {
            crate::caption::label(self.units, key.title(), key.unit().unwrap_or("1"))
        });
        let axis = match self.ends()[0] > 0.0 {
            true => Axis::log(label, (1e-4, 1.0)),
            false => Axis::linear(label, (0.0, 1.0)),
        };
        (axis.covering(shown.iter().map(|point| point.0)), shown)
    }

    /// Adds the present value at the height of its result, and the limits.
    pub(super) fn marked(&self, mut panel: Panel, height: impl Fn(&T) -> Option<f64>) -> Panel {
        let present = self.present;
        if let Some((value, height)) = present.and_then(|own| Some((own.value(), height(own)?))) {
            let present = Points::new(vec![(value, height)]).color(palette::BLACK);
            panel = panel.with(present.named("present value"));
        }
        let limits = self.all_ends().filter(|end| end.kind == EndKind::Limit);
        for (n, end) in limits.enumerate() {
            let rule = Rule::vertical(end.value).dotted();
            // One entry of the legend for all limits.
            panel = panel.with(match n {
                0 => rule.named("limit"),
                _ => rule,
            });
        }
        panel
    }

    /// Range of the figure: the given range, or the neighborhood of the limits and of the present value, or all values if there is neither.
    fn window(&self) -> [f64; 2] {
        let all = self.ends();
        let places = self
            .all_ends()
            .filter(|end| end.kind != EndKind::Range)
            .map(|end| end.value)
            .chain(self.present.map(T::value));
        let (low, high) = places.fold((f64::INFINITY, 0.0_f64), |(low, high), value| {
            (low.min(value), high.max(value))
        });
        match self.is_range_given || low <= 0.0 || low > high {
            true => all,
            false => [
                (low / NEIGHBORHOOD).max(all[0]),
                (high * NEIGHBORHOOD).min(all[1]),
            ],
        }
    }
}
