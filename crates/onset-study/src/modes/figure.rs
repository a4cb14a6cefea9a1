//! Figure of modes on the lattice.

use super::view::View;
use super::{ModesAnswer, ShownMode};
use crate::caption;
use crate::figure::{
    Arrows, Axis, Ball, Balls, Color, Figure, Label, Line, Panel, Points, palette,
};

/// Maximum number of modes that are drawn.
const MAX_MODES: usize = 6;

/// Half the edge of the cube of particles that is drawn in 3D, in spacings.
const HALF_SIDE: f64 = 1.6;
/// Radius of a ball, in spacings.
const RADIUS: f64 = 0.15;
/// Largest distance between neighbors that are joined by a line, in spacings.
const JOINING_DISTANCE: f64 = 1.05;
/// Diameter of a particle in one and two dimensions, in spacings.
const DIAMETER: f64 = 0.2;
/// Color of the lines between neighbors.
const PALE: Color = Color::hex(0xc4c4c4);

impl ModesAnswer {
    /// Draws the first modes, each on a patch of particles with their displacements. In 3D the middle of the patch is drawn in perspective.
    pub fn figure(&self) -> Figure {
        let figure = Figure::new("Spurious modes of the reference configuration").columns(3);
        let shown = self.modes.iter().take(MAX_MODES);
        let mut figure = shown.fold(figure, |figure, mode| figure.with(self.panel(mode)));
        // All panels show the same patch at the same scale.
        let ranges = figure
            .panels
            .iter()
            .map(|panel| [panel.x.range, panel.y.range]);
        let whole = ranges.reduce(|a, b| [0, 1].map(|n| (a[n].0.min(b[n].0), a[n].1.max(b[n].1))));
        if let Some([x, y]) = whole {
            for panel in &mut figure.panels {
                (panel.x.range, panel.y.range) = (x, y);
            }
        }
        let mut words = String::new();
        if !self.modes.is_empty() {
            words.push_str("Wave vectors in units of the reciprocal vectors.");
            if self.dimension > 1 {
                words.push_str(" Arrows: twice the displacements.");
            }
        }
        if self
            .modes
            .iter()
            .take(MAX_MODES)
            .any(|mode| mode.nullity == 0)
        {
            words.push_str(" Percentages: frequency relative to the material.");
        }
        match self.modes.len().saturating_sub(MAX_MODES) {
            0 => {}
            1 => words.push_str(" One more mode is listed, but not drawn."),
            rest => words.push_str(&format!(" {rest} more modes are listed, but not drawn.")),
        }
        words.push_str(&format!(" {}", caption::settings(&self.settings)));
        figure.caption(words.trim_start())
    }

    /// Indices of the drawn particles: all of them, in 3D only the middle of the patch.
    pub(super) fn shown(&self, mode: &ShownMode) -> Vec<usize> {
        let all = 0..mode.positions.len();
        if self.dimension < 3 {
            return all.collect();
        }
        let count = mode.positions.len() as f64;
        let center: [f64; 3] =
            std::array::from_fn(|axis| mode.positions.iter().map(|x| x[axis]).sum::<f64>() / count);
        let is_near = |n: &usize| {
            let x = &mode.positions[*n];
            (0..3).all(|axis| (x[axis] - center[axis]).abs() <= HALF_SIDE * self.spacing)
        };
        all.filter(is_near).collect()
    }

    fn panel(&self, mode: &ShownMode) -> Panel {
        let title = format!(
            "k = {}\n{}",
            mode.place().replace('-', "−"),
            mode.title("modes")
        );
        if self.dimension == 3 {
            return self.panel_in_space(mode, &title);
        }
        let (from, to): (Vec<_>, Vec<_>) = self
            .shown(mode)
            .into_iter()
            .map(|n| self.arrow(&mode.positions[n], &mode.displacements[n]))
            .unzip();
        let ends = || from.iter().chain(&to);
        // Displacements along a line are drawn perpendicular to it.
        let second = match self.dimension {
            1 => "displacement u₁",
            _ => "x₂",
        };
        let units = self.settings.units();
        let [x, y] = ["x₁", second]
            .map(|what| Axis::linear(caption::label(units, what, "length"), (0.0, 1.0)));
        let x = x.covering(ends().map(|end: &(f64, f64)| end.0));
        let y = y.covering(ends().map(|end: &(f64, f64)| end.1));
        let panel = Panel::new(title, x, y)
            .with(
                Arrows::new(from.clone(), to)
                    .color(palette::VERMILION)
                    .named("displacements"),
            )
            .with(
                Points::new(from)
                    .extent(DIAMETER * self.spacing)
                    .color(palette::BLUE)
                    .named("particles"),
            );
        if self.dimension == 1 {
            panel
        } else {
            panel.equal_aspect()
        }
    }

    fn arrow(&self, x: &[f64; 3], u: &[f64; 3]) -> ((f64, f64), (f64, f64)) {
        if self.dimension == 1 {
            return ((x[0], 0.0), (x[0], u[0]));
        }
        // Doubled for visibility.
        ((x[0], x[1]), (x[0] + 2.0 * u[0], x[1] + 2.0 * u[1]))
    }

    /// Perspective view: balls that fade with distance, lines between neighbors, and the axes.
    fn panel_in_space(&self, mode: &ShownMode, title: &str) -> Panel {
        let shown = self.shown(mode);
        let places: Vec<[f64; 3]> = shown.iter().map(|n| mode.positions[*n]).collect();
        let view = View::of(&places, self.dimension);
        let mut balls: Vec<Ball> = shown
            .iter()
            .map(|n| {
                let (x, u) = (&mode.positions[*n], &mode.displacements[*n]);
                let seen = view.seen(x);
                let tip = view.seen(&std::array::from_fn(|i| x[i] + 2.0 * u[i]));
                Ball {
                    at: seen.at,
                    radius: RADIUS * self.spacing * seen.scale,
                    fade: seen.farness,
                    tip: Some(tip.at),
                }
            })
            .collect();
        balls.sort_by(|a, b| b.fade.total_cmp(&a.fade));
        let ends: Vec<(f64, f64)> = balls
            .iter()
            .flat_map(|ball| [Some(ball.at), ball.tip])
            .flatten()
            .collect();
        let least = |of: fn(&(f64, f64)) -> f64| ends.iter().map(of).fold(f64::INFINITY, f64::min);
        let (axes, words) = self.triad(&view, (least(|end| end.0), least(|end| end.1)));
        let all = || ends.iter().chain(&axes.from).chain(&axes.to);
        let margin = 0.4 * self.spacing;
        let blank = || Axis::linear("", (0.0, 1.0)).ticks(Vec::<(f64, String)>::new());
        let x = blank().covering(all().flat_map(|end| [end.0 - margin, end.0 + margin]));
        let y = blank().covering(all().flat_map(|end| [end.1 - margin, end.1 + margin]));
        let mut panel = Panel::new(title, x, y)
            .equal_aspect()
            .with(
                Line::new(self.joined(&places, &view))
                    .color(PALE)
                    .width(1.0),
            )
            .with(
                Balls::new(balls)
                    .named("particles")
                    .arrows_named("displacements"),
            )
            .with(axes);
        for word in words {
            panel = panel.with(word);
        }
        panel
    }

    /// Lines between neighbors, with breaks.
    fn joined(&self, places: &[[f64; 3]], view: &View) -> Vec<(f64, f64)> {
        let mut points = Vec::new();
        for (n, a) in places.iter().enumerate() {
            for b in &places[n + 1..] {
                let distance = (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
                if distance < JOINING_DISTANCE * self.spacing {
                    points.extend([view.seen(a).at, view.seen(b).at, (f64::NAN, f64::NAN)]);
                }
            }
        }
        points
    }

    /// Axes as arrows from a corner, with their names.
    fn triad(&self, view: &View, corner: (f64, f64)) -> (Arrows, Vec<Label>) {
        let length = 0.8 * self.spacing;
        let base = (corner.0 - 0.9 * self.spacing, corner.1 - 0.2 * self.spacing);
        let tip = |axis: usize, reach: f64| {
            let (right, up) = view.direction(axis);
            (
                base.0 + reach * length * right,
                base.1 + reach * length * up,
            )
        };
        let words = ["x₁", "x₂", "x₃"];
        let words = (0..3).map(|axis| Label::new(tip(axis, 1.4), words[axis]));
        let to = (0..3).map(|axis| tip(axis, 1.0)).collect();
        (Arrows::new(vec![base; 3], to), words.collect())
    }
}
