//! Figure of a run: the amplitude of its wave over time, with the predicted and the measured rate.

use super::SimulateAnswer;
use super::answer::rate_in_words;
use crate::caption;
use crate::figure::{Axis, Dash, Figure, Line, Panel, Points, palette};
use crate::verify::Rate;
use nalgebra::{Matrix2, Vector2};

/// Largest number of drawn samples.
const MARKS: usize = 40;
/// Number of vertices of a curve.
const VERTICES: usize = 400;
/// Smallest growth over the record that makes the axis of the amplitude logarithmic.
const LARGE_GROWTH: f64 = 3.0;

impl SimulateAnswer {
    /// Amplitude of the wave over time: samples of the run, and motions with the predicted and with the measured rate and the same initial values.
    ///
    /// If the wave grows by a large factor, the axis is logarithmic, so that the rate is a slope.
    pub fn figure(&self) -> Figure {
        let units = self.settings.units();
        let end = self.samples.last().map_or(0.0, |sample| sample[0]);
        let growth = (self.predicted.growth * end).exp();
        let is_log = self.predicted.is_growth() && growth > LARGE_GROWTH;
        let shown = |value: f64| if is_log { value.abs() } else { value };
        let points: Vec<(f64, f64)> = self.samples.iter().map(|[t, y]| (*t, shown(*y))).collect();
        let label = caption::label(units, "amplitude of the wave", "length");
        let y = match is_log {
            true => Axis::log(label, (1e-3, 1.0)),
            false => Axis::linear(label, (-1.0, 1.0)),
        };
        let x = Axis::linear(caption::label(units, "time", "time"), (0.0, 1.0));
        let mut panel = Panel::new(
            "",
            x.covering(points.iter().map(|point| point.0)),
            y.covering(points.iter().map(|point| point.1)),
        );
        // The curves are drawn over the markers, the predicted one wide below the measured one.
        let every = points.len().div_ceil(MARKS).max(1);
        let marks = points.into_iter().step_by(every).collect();
        panel = panel.with(
            Points::new(marks)
                .color(palette::GREY)
                .open()
                .size(6.0)
                .named("run"),
        );
        let rates = [
            (
                "predicted rate",
                Some(self.predicted),
                palette::BLUE,
                3.2,
                Dash::Solid,
            ),
            (
                "measured rate",
                self.measured.map(|own| own.rate),
                palette::VERMILION,
                1.6,
                Dash::Dashed,
            ),
        ];
        for (name, rate, color, width, dash) in rates {
            if let Some(curve) = rate.and_then(|rate| self.motion(rate)) {
                let vertices = (0..=VERTICES).map(|i| end * i as f64 / VERTICES as f64);
                let mut line = Line::new(vertices.map(|t| (t, shown(curve(t)))).collect());
                line.dash = dash;
                panel = panel.with(line.named(name).color(color).width(width));
            }
        }
        let told = |rate: &Rate, share| rate_in_words(rate, share, units);
        let measured = self.measured.map_or("not determined".to_owned(), |own| {
            told(&own.rate, own.uncertainty)
        });
        let state = caption::state(&self.deformation_gradient, self.wave_vector.len());
        Figure::new("Motion of a wave against its prediction")
            .with(panel)
            .caption(format!(
                "State: {state}. Predicted: {}. Measured: {measured}. {}",
                told(&self.predicted, 0.0),
                caption::settings(&self.settings)
            ))
    }

    /// Motion with a rate that is closest to the record; `None` if the record does not determine it.
    fn motion(&self, rate: Rate) -> Option<impl Fn(f64) -> f64 + use<>> {
        let basis = move |t: f64| {
            let (growth, turn) = (rate.growth * t, rate.frequency * t);
            match (rate == Rate::default(), rate.is_growth()) {
                (true, _) => Vector2::new(1.0, t),
                (_, true) => Vector2::new(growth.exp(), (-growth).exp()),
                (_, false) => Vector2::new(turn.cos(), turn.sin()) * growth.exp(),
            }
        };
        let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
        for [t, y] in &self.samples {
            // Squared errors relative to the size of the motion, so that its start and its end have equal weight.
            let weight = (-2.0 * rate.growth.max(0.0) * t).exp();
            normal += basis(*t) * basis(*t).transpose() * weight;
            right += basis(*t) * (y * weight);
        }
        let shares = normal.try_inverse()? * right;
        shares
            .iter()
            .all(|share| share.is_finite())
            .then_some(move |t| basis(t).dot(&shares))
    }
}
