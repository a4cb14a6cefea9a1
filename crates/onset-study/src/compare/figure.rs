//! The table of a comparison as a figure: one line for each method.

use super::table::percent;
use super::{Measured, Table};
use crate::figure::{Axis, Figure, Marker, Panel, Points, Rule, palette};
use onset::measures::{Load, StretchOnset};

/// Numbers of this size and smaller are drawn at it: a logarithmic axis has no zero.
const SMALLEST: f64 = 1e-4;

impl Table {
    /// Onsets against the material's, wrong verdicts, errors of frequencies, and time steps: a line for each method.
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
                "Material {}, {} dimension(s). Verdicts on stretches from {} to {}. Errors of frequencies of the undeformed body over all \
                 directions; those below {} are drawn there.",
                self.material,
                self.dimension,
                self.options.stretches[0],
                self.options.stretches[1],
                percent(SMALLEST)
            ))
    }

    fn measured(&self) -> impl Iterator<Item = (f64, &Measured)> {
        let rows = self.rows.iter().enumerate();
        rows.filter_map(|(n, row)| Some((self.height(n), row.measured.as_ref().ok()?)))
    }

    /// The line of a method: the first one on top.
    fn height(&self, number: usize) -> f64 {
        (self.rows.len() - number) as f64
    }

    /// The axis of the methods.
    fn methods(&self) -> Axis {
        let ticks = self.rows.iter().enumerate();
        let ticks = ticks.map(|(n, row)| (self.height(n), row.name.clone()));
        Axis::linear("", (0.4, self.rows.len() as f64 + 0.6)).ticks(ticks)
    }

    fn onsets(&self) -> Panel {
        let ends = [self.options.compression, self.options.tension];
        let axis = Axis::linear("stretch at onset (−)", (ends[0], ends[1])).covering(ends);
        let mut panel = Panel::new("First instability", axis, self.methods());
        let loads = Load::ALL
            .into_iter()
            .filter(|load| load.is_possible(self.dimension));
        for (load, color) in loads.zip(palette::SERIES) {
            let of = |m: &Measured| m.onsets.iter().find(|pair| pair.load == load).copied();
            let material = self.measured().find_map(|(_, m)| of(m));
            if let Some(StretchOnset::At(stretch)) = material.map(|pair| pair.material) {
                panel = panel.with(
                    Rule::vertical(stretch)
                        .color(color)
                        .dashed()
                        .named(format!("material, {}", load.name())),
                );
            }
            let points = self
                .measured()
                .filter_map(|(height, m)| Some((of(m)?.method.stretch()?, height)));
            let marker = if load.is_tension() {
                Marker::Triangle
            } else {
                Marker::Circle
            };
            let points = Points::new(points.collect()).marker(marker).color(color);
            panel = with_some(panel, points.named(load.name()));
        }
        panel
    }

    fn verdicts(&self) -> Panel {
        let axis =
            Axis::linear("share of the window of states (%)", (0.0, 100.0)).covering([0.0, 100.0]);
        let of = |share: fn(&Measured) -> f64| {
            let points = self
                .measured()
                .map(|(height, m)| (100.0 * share(m), height));
            Points::new(points.filter(|(share, _)| *share > 0.0).collect())
        };
        let series = [
            of(|m| m.fidelity.false_instability)
                .color(palette::ORANGE)
                .named("unstable though the material is elliptic"),
            of(|m| m.fidelity.missed_instability)
                .marker(Marker::Square)
                .color(palette::BLACK)
                .named("stable though the material is not elliptic"),
            of(|m| m.fidelity.rank_deficient)
                .marker(Marker::Triangle)
                .color(palette::PURPLE)
                .named("stable, but with modes without energy"),
            of(|m| m.fidelity.undefined)
                .marker(Marker::Cross)
                .color(palette::BLACK)
                .named("the method is not defined"),
        ];
        let panel = Panel::new("Wrong verdicts", axis, self.methods());
        series.into_iter().fold(panel, with_some)
    }

    fn errors(&self) -> Panel {
        let all = self.measured().flat_map(|(_, m)| &m.dispersion);
        let all = all.map(|error| error.error.max(SMALLEST));
        let axis = Axis::log("error (−)", (SMALLEST, 1.0)).covering(all);
        let mut panel = Panel::new("Frequencies", axis, self.methods());
        let colors = [palette::VERMILION, palette::BLUE, palette::GREEN];
        for (count, color) in super::WAVELENGTHS.into_iter().zip(colors) {
            let points = self
                .measured()
                .map(|(height, m)| (m.dispersion_at(count).max(SMALLEST), height));
            panel = panel.with(
                Points::new(points.collect())
                    .marker(Marker::Square)
                    .color(color)
                    .named(format!("{count:.0} particles a wavelength")),
            );
        }
        panel
    }

    fn cost(&self) -> Panel {
        let numbers = self.measured().map(|(_, m)| m.courant);
        let axis = Axis::linear("c Δt / spacing (−)", (0.0, 2.0)).covering(numbers.chain([0.0]));
        let points = self.measured().map(|(height, m)| (m.courant, height));
        Panel::new("Critical time step", axis, self.methods())
            .with(Points::new(points.collect()).color(palette::BLACK))
    }
}

/// The panel with points, if there are any: the legend names what is there.
fn with_some(panel: Panel, points: Points) -> Panel {
    if points.points.is_empty() {
        panel
    } else {
        panel.with(points)
    }
}
