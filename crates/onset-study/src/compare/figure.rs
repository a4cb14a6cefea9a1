//! Figure of a comparison: one line for each method.

use super::names::Labels;
use super::table::percent;
use super::{Measured, Ranked, Recommendation, Table};
use crate::figure::{Axis, Color, Figure, Marker, Panel, Points, Rule, palette};
use crate::number::counted;
use crate::output::{Files, picture};
use onset::measures::{Load, StretchOnset};

/// Smallest value on the logarithmic axis of errors; smaller values are drawn there.
const SMALLEST_ERROR_SHOWN: f64 = 1e-4;

/// Height of a row in lines of text, and distance of the markers of a row, in rows.
///
/// Markers are 6 pixels wide and a row is 34 pixels high, so the markers of a row never touch.
const ROW_LINES: f64 = 2.0;
const SHIFT: f64 = 0.2;

/// Largest number of characters in names of methods that list the names of varied keys.
const NAME_LENGTH: usize = 24;

/// Vertical offset of the `n`-th of `count` series from the middle of its row; the first series is at the top.
fn shift(n: usize, count: usize) -> f64 {
    ((count - 1) as f64 / 2.0 - n as f64) * SHIFT
}

/// Marker of a loading.
struct Look {
    color: Color,
    marker: Marker,
    filled: bool,
}

/// Markers of [`Load::ALL`]: triangles for tension, solid shapes for compression, in colors for color-blind readers.
const MARKERS: [Look; 4] = [
    Look {
        color: palette::LOADS[0],
        marker: Marker::Triangle,
        filled: true,
    },
    Look {
        color: palette::LOADS[1],
        marker: Marker::Circle,
        filled: true,
    },
    Look {
        color: palette::LOADS[2],
        marker: Marker::Triangle,
        filled: false,
    },
    Look {
        color: palette::LOADS[3],
        marker: Marker::Square,
        filled: true,
    },
];

impl Table {
    /// Figure with onsets, wrong verdicts, frequency errors and time steps, one line for each method.
    pub fn figure(&self) -> Figure {
        let title = if self.title.is_empty() {
            "Methods side by side"
        } else {
            &self.title
        };
        Figure::new(title)
            .columns(2)
            .with(self.onsets())
            .with(self.verdicts())
            .with(self.errors())
            .with(self.cost())
            .caption(format!(
                "Material {}, {}.",
                self.material,
                counted(self.dimension, "dimension")
            ))
    }

    /// Figure with the rows by rank: the recommended methods with their places.
    fn ranked(&self, ranking: &[Ranked]) -> Figure {
        let mut table = self.clone();
        table.rows.clear();
        for (n, ranked) in ranking.iter().enumerate() {
            let mut rows = self.rows.iter();
            let Some(mut row) = rows.find(|row| row.name == ranked.name).cloned() else {
                continue;
            };
            if ranked.excluded.is_none() {
                row.name = format!("{}. {}", n + 1, row.name);
            }
            table.rows.push(row);
        }
        let mut figure = table.figure();
        if self.title.is_empty() {
            "Methods by recommendation".clone_into(&mut figure.title);
        }
        let good = ranking
            .iter()
            .filter(|ranked| ranked.excluded.is_none())
            .count();
        let told = match good {
            0 => "No method is recommended.",
            _ => "Methods with a number are recommended, best first; the others are excluded.",
        };
        figure.caption = format!("{told} {}", figure.caption);
        if 0 < good && good < table.rows.len() {
            let end = (table.rows.len() - good) as f64 + 0.5;
            for panel in &mut figure.panels {
                panel
                    .layers
                    .push(Rule::horizontal(end).color(palette::BLACK).into());
            }
        }
        figure
    }

    fn measured(&self) -> impl Iterator<Item = (f64, &Measured)> {
        let rows = self.rows.iter().enumerate();
        rows.filter_map(|(n, row)| Some((self.height(n), row.measured.as_ref().ok()?)))
    }

    /// Vertical position of a method; the first method is at the top.
    fn height(&self, number: usize) -> f64 {
        (self.rows.len() - number) as f64
    }

    /// Axis of the methods.
    fn methods(&self) -> Axis {
        let names: Vec<&str> = self.rows.iter().map(|row| row.name.as_str()).collect();
        let names = Labels::without_common(&names, NAME_LENGTH).names;
        let ticks = names.into_iter().enumerate();
        let ticks = ticks.map(|(n, name)| (self.height(n), name));
        Axis::linear("", (0.5, self.rows.len() as f64 + 0.5)).ticks(ticks)
    }

    /// Empty panel with a row for each method, and lines between the rows.
    fn panel(&self, title: &str, axis: Axis) -> Panel {
        let rows = self.rows.len();
        let panel = Panel::new(title, axis, self.methods()).lines(ROW_LINES * rows as f64);
        (1..rows).fold(panel, |panel, n| {
            panel.with(Rule::horizontal(self.height(n) + 0.5).color(Color::hex(0xdddddd)))
        })
    }

    /// Panel of onsets: a marker at the onset of instability for each loading, or an arrow out of the window.
    fn onsets(&self) -> Panel {
        let ends = [self.options.compression, self.options.tension];
        let reach = 0.06 * (ends[1] - ends[0]);
        let axis = Axis::linear("stretch at onset (−)", (ends[0], ends[1]));
        let axis = axis.covering([ends[0] - reach, ends[1] + reach]);
        let mut panel = self.panel("First instability", axis);
        let (mut is_any_beyond, mut is_any_undefined) = (false, false);
        let loads = Load::ALL.into_iter().zip(MARKERS);
        let loads: Vec<(Load, Look)> = loads
            .filter(|(load, _)| load.is_possible(self.dimension))
            .collect();
        for (n, (load, look)) in loads.iter().enumerate() {
            let load = *load;
            let of = |m: &Measured| m.onsets.iter().find(|pair| pair.load == load).copied();
            let material = self.measured().find_map(|(_, m)| of(m));
            if let Some(StretchOnset::At(stretch)) = material.map(|pair| pair.material) {
                panel = panel.with(
                    Rule::vertical(stretch)
                        .color(look.color)
                        .dashed()
                        .named(format!("material, {}", load.title(self.dimension))),
                );
            }
            let (mut points, mut beyond, mut undefined) = (Vec::new(), Vec::new(), Vec::new());
            for (height, m) in self.measured() {
                let height = height + shift(n, loads.len());
                match of(m).map(|pair| pair.method) {
                    Some(StretchOnset::NotBefore(end)) => beyond.push((end, height)),
                    Some(StretchOnset::Undefined(stretch)) => undefined.push((stretch, height)),
                    Some(onset) => points.extend(onset.stretch().map(|x| (x, height))),
                    None => {}
                }
            }
            let (out, arrow) = match load.is_tension() {
                true => (0.5 * reach, Marker::Right),
                false => (-0.5 * reach, Marker::Left),
            };
            for place in &mut beyond {
                place.0 += out;
            }
            let marked = |points| Points::new(points).color(look.color);
            let onsets = marked(points)
                .marker(look.marker)
                .named(load.title(self.dimension));
            let onsets = if look.filled { onsets } else { onsets.open() };
            is_any_beyond |= !beyond.is_empty();
            is_any_undefined |= !undefined.is_empty();
            // The color of the arrows identifies a loading without an onset in the range.
            let has_name = onsets.points.is_empty() && !beyond.is_empty();
            let mut arrows = marked(beyond).marker(arrow);
            if has_name {
                arrows = arrows.named(load.title(self.dimension));
            }
            panel = panel.with(arrows);
            panel = panel.with(marked(undefined).marker(Marker::Cross));
            panel = with_some(panel, onsets);
        }
        // Entries of the legend for the symbols of all loadings.
        if is_any_beyond {
            let arrows = Points::new(Vec::new())
                .marker(Marker::Right)
                .color(palette::GREY);
            panel = panel.with(arrows.named("stable beyond the range"));
        }
        if is_any_undefined {
            let crosses = Points::new(Vec::new()).marker(Marker::Cross);
            panel = panel.with(
                crosses
                    .color(palette::GREY)
                    .named("method not defined beyond"),
            );
        }
        panel
    }

    fn verdicts(&self) -> Panel {
        let [least, most] = self.options.stretches;
        let label = format!("share of states, stretches {least} to {most} (%)");
        let axis = Axis::linear(label, (0.0, 100.0)).covering([0.0, 100.0]);
        let of = |n: usize, share: fn(&Measured) -> f64| {
            let points = self
                .measured()
                .map(|(height, m)| (100.0 * share(m), height + shift(n, 4)));
            Points::new(points.filter(|(share, _)| *share > 0.0).collect())
        };
        let series = [
            of(0, |m| m.fidelity.false_instability)
                .color(palette::VERMILION)
                .named("unstable though the material is elliptic"),
            of(1, |m| m.fidelity.suppressed_instability)
                .marker(Marker::Square)
                .color(palette::BLACK)
                .named("stable though the material is not elliptic"),
            of(2, |m| m.fidelity.zero_energy)
                .marker(Marker::Triangle)
                .color(palette::PURPLE)
                .named("stable, but with zero-energy modes"),
            of(3, |m| m.fidelity.undefined)
                .marker(Marker::Cross)
                .color(palette::BLACK)
                .named("the method is not defined"),
        ];
        let panel = self.panel("Wrong verdicts", axis);
        series.into_iter().fold(panel, with_some)
    }

    fn errors(&self) -> Panel {
        let all = self.measured().flat_map(|(_, m)| &m.dispersion);
        let all = all.map(|error| error.error.max(SMALLEST_ERROR_SHOWN));
        let label = format!(
            "error at F = 1, at least {} (−)",
            percent(SMALLEST_ERROR_SHOWN)
        );
        let axis = Axis::log(label, (SMALLEST_ERROR_SHOWN, 1.0)).covering(all);
        let mut panel = self.panel("Frequencies", axis);
        let colors = [palette::VERMILION, palette::BLUE, palette::GREEN];
        for (n, (count, color)) in super::WAVELENGTHS.into_iter().zip(colors).enumerate() {
            let height = |height: f64| height + shift(n, super::WAVELENGTHS.len());
            let error = |m: &Measured| m.dispersion_at(count).max(SMALLEST_ERROR_SHOWN);
            let points = self.measured().map(|(at, m)| (error(m), height(at)));
            panel = panel.with(
                Points::new(points.collect())
                    .marker(Marker::Square)
                    .color(color)
                    .named(format!("{count:.0} points per wavelength")),
            );
        }
        panel
    }

    fn cost(&self) -> Panel {
        let numbers = self.measured().map(|(_, m)| m.courant);
        let axis = Axis::linear("c Δt / spacing (−)", (0.0, 2.0)).covering(numbers.chain([0.0]));
        let points = self.measured().map(|(height, m)| (m.courant, height));
        self.panel("Critical time step", axis)
            .with(Points::new(points.collect()).color(palette::BLACK))
    }
}

impl Recommendation {
    /// Table as `compare.html` and `compare.csv`, and the figure `compare` with the methods by rank.
    pub fn files(&self) -> Files {
        let mut files = self.table.files();
        files.pop();
        files.push(picture("compare", self.table.ranked(&self.ranking)));
        files
    }
}

/// Adds points to a panel. An empty set is not added, so that the legend omits it.
fn with_some(panel: Panel, points: Points) -> Panel {
    if points.points.is_empty() {
        panel
    } else {
        panel.with(points)
    }
}
