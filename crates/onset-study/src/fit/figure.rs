//! Figure of a fit: a panel for each test, and the plane of the largest and the smallest stretch with data, range and lost states.

use super::FitAnswer;
use crate::figure::{Axis, Figure, Line, Marker, Panel, Points, Regions, palette};
use onset_fit::{Fitted, Mode, Test};

/// Points of a curve.
const CURVE: usize = 200;
/// Cells along an axis of the plane of stretches, and the parts along an axis into which a cell at a border of its class is divided.
const CELLS: usize = 80;
const PARTS: usize = 6;
const FINE_CELLS: usize = CELLS * PARTS;
/// Class of the cells without a state.
const BLANK_CLASS: u8 = 9;
/// Ratio of the largest stretch of a curve to the largest measured stretch.
const EXTENT_RATIO: f64 = 1.1;
/// Margin at the most compressed point, as a fraction of the width of a panel.
const MARGIN: f64 = 0.04;

/// Markers of the tests in the plane of stretches.
const MARKERS: [Marker; 4] = [
    Marker::Circle,
    Marker::Triangle,
    Marker::Square,
    Marker::Cross,
];

/// Number of strokes of a hatching along a diagonal of a panel, and number of points of a stroke.
const STROKES: usize = 40;
const STROKE_POINTS: usize = 240;

/// Diagonal strokes that hatch the part of a panel that belongs to a set. `at` returns the coordinates for fractions of width and height.
fn hatching(at: impl Fn(f64, f64) -> (f64, f64), holds: impl Fn(f64, f64) -> bool) -> Line {
    let mut points = Vec::new();
    for stroke in 0..STROKES {
        let sum = 2.0 * (stroke as f64 + 0.5) / STROKES as f64;
        let (from, to) = ((sum - 1.0).max(0.0), sum.min(1.0));
        let place = |n: usize| {
            let u = from + (to - from) * n as f64 / STROKE_POINTS as f64;
            (u, sum - u)
        };
        let is_inside = |n: usize| {
            let (u, v) = place(n);
            n <= STROKE_POINTS && holds(u, v)
        };
        let mut n = 0;
        while n <= STROKE_POINTS {
            let count = (n..).take_while(|own| is_inside(*own)).count();
            if count > 1 {
                let ends = [n, n + count - 1].map(place);
                points.extend(ends.map(|(u, v)| at(u, v)));
                points.push((f64::NAN, f64::NAN));
            }
            n += count + 1;
        }
    }
    Line::new(points).width(0.6)
}

impl FitAnswer {
    /// Draws the law with the smallest error.
    pub fn figure(&self) -> Figure {
        let best = self.best();
        let mut figure = Figure::new(format!(
            "{} fitted to {}",
            best.law,
            crate::number::counted(self.tests.len(), "test")
        ))
        .caption(self.caption())
        .columns(2);
        for test in self
            .data
            .iter()
            .filter(|test| test.mode != Mode::Volumetric)
        {
            figure = figure.with(self.panel(test));
        }
        if best.fit.family.is_compressible() {
            return figure;
        }
        figure.with(self.plane())
    }

    fn caption(&self) -> String {
        let best = self.best();
        let mut caption = format!(
            "Nominal stress of {} fitted to the tests (line) and measured (circles).",
            best.law
        );
        if !best.needs_no_demand {
            caption += " Dashed: fitted without the stability constraint.";
        }
        if !best.free_losses.is_empty() || !best.losses.is_empty() {
            caption += " Dotted and hatched: a criterion is violated, in grey without the stability constraint.";
        }
        if !best.fit.family.is_compressible() {
            caption += " Plane: states at constant volume, by the largest stretch and the inverse of the smallest one.";
        }
        caption
    }

    fn panel(&self, test: &Test) -> Panel {
        let best = self.best();
        let fit = &best.fit;
        let stretches: Vec<f64> = test.points.iter().map(|point| point.stretch).collect();
        let rest: f64 = if test.mode == Mode::SimpleShear {
            0.0
        } else {
            1.0
        };
        let low = stretches.iter().fold(rest, |a, b| a.min(*b));
        let high = stretches.iter().fold(rest, |a, b| a.max(*b)) * EXTENT_RATIO;
        // Compressed points are not on the frame.
        let low = if low < rest {
            low - MARGIN * (high - low)
        } else {
            low
        };
        let unit = self.unit.as_deref().unwrap_or("unit of the tables");
        // The fitted curve is visible up to the last measured point.
        let fitted = stretches.iter().filter_map(|stretch| {
            fit.family
                .stress(&fit.result().constants, test.mode, *stretch)
        });
        let fitted: Vec<f64> = fitted.collect();
        let stresses = test.points.iter().map(|point| point.stress).chain(fitted);
        let label = match test.mode {
            Mode::SimpleShear => "amount of shear γ (−)",
            _ => "stretch λ (−)",
        };
        let stress = match test.mode {
            Mode::SimpleShear => "shear stress",
            _ => "nominal stress",
        };
        let vertical =
            Axis::linear(format!("{stress} ({unit})"), (0.0, 0.0)).covering(stresses.chain([0.0]));
        let (bottom, top) = vertical.range;
        let mut panel = Panel::new(&test.name, Axis::linear(label, (low, high)), vertical);
        let needs_both = !best.needs_no_demand;
        let mut drawn = vec![(fit.result(), "fitted", palette::BLUE, 2.0)];
        if needs_both {
            drawn.insert(0, (&fit.free, "without the constraint", palette::GREY, 1.5));
        }
        for (fitted, name, color, width) in drawn {
            let is_free = name != "fitted";
            let (mut held, mut lost) = (Vec::new(), Vec::new());
            if fit.family.is_compressible() {
                // The stress depends on the measured lateral stretch too.
                held = self.at_points(test, fitted);
            }
            for n in 0..=CURVE {
                let stretch = low + (high - low) * n as f64 / CURVE as f64;
                let stress = fit.family.stress(&fitted.constants, test.mode, stretch);
                let Some(stress) = stress.filter(|own| own.is_finite()) else {
                    continue;
                };
                let is_held =
                    fit.family
                        .is_stable(&fitted.constants, &self.criteria, test.mode, stretch);
                let point = (stretch, stress);
                let gap = (f64::NAN, f64::NAN);
                held.push(if is_held { point } else { gap });
                lost.push(if is_held { gap } else { point });
            }
            let line = Line::new(held).color(color).width(width).named(name);
            panel = panel.with(if is_free { line.dashed() } else { line });
            if lost.iter().any(|own| own.0.is_finite()) {
                let at = |u: f64, v: f64| (low + (high - low) * u, bottom + (top - bottom) * v);
                let is_lost = |u: f64, _| {
                    let n = (u * CURVE as f64).round() as usize;
                    lost.get(n).is_some_and(|own| own.0.is_finite())
                };
                panel = panel.with(hatching(at, is_lost).color(color));
                let line = Line::new(lost)
                    .color(palette::VERMILION)
                    .width(width)
                    .dotted();
                panel = panel.with(line.named("criterion violated"));
            }
        }
        let points = test
            .points
            .iter()
            .map(|point| (point.stretch, point.stress));
        panel.with(
            Points::new(points.collect())
                .color(palette::BLACK)
                .open()
                .named("measured"),
        )
    }

    /// Fitted stresses at the measured points, by increasing stretch.
    fn at_points(&self, test: &Test, fitted: &Fitted) -> Vec<(f64, f64)> {
        let misfit = fitted.misfits.iter().find(|own| own.test == test.name);
        let stresses = misfit.map_or(&[][..], |own| &own.stresses);
        let points = test.points.iter().zip(stresses);
        let mut points: Vec<(f64, f64)> = points
            .map(|(point, stress)| (point.stretch, *stress))
            .collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points
    }

    /// States of constant volume, by their largest stretch and the inverse of their smallest stretch.
    fn plane(&self) -> Panel {
        let best = self.best();
        let reach = self.stretches.map_or(1.0, |[_, high]| high);
        let tested = self
            .tests
            .iter()
            .filter(|test| test.mode != Mode::Volumetric);
        let tested = tested.fold(1.0_f64, |most, test| {
            most.max(test.stretches[1]).max(test.stretches[0].recip())
        });
        let high = reach.max(tested) * EXTENT_RATIO;
        let end = high.powf(1.5);
        let axis = |label: &str, end: f64| crate::criteria::stretch_axis(label, 1.0, end);
        // Class of a cell, by its column and row in a grid with a number of cells along each axis.
        let class = |column: usize, row: usize, cells: usize| -> u8 {
            let at = |n: usize, end: f64| end.ln() * (n as f64 + 0.5) / cells as f64;
            let (x, y) = (at(column, high), at(row, end));
            if y > 2.0 * x || x > 2.0 * y {
                return BLANK_CLASS;
            }
            let logs = [x, y - x, -y];
            let state = |own: &Fitted| {
                best.fit
                    .family
                    .is_stable_at(&own.constants, &self.criteria, logs)
            };
            let range = self.stretches;
            let inside = range.is_some_and(|[low, high]| x <= high.ln() && -y >= low.ln());
            match (state(best.fit.result()), state(&best.fit.free), inside) {
                (true, true, true) => 0,
                (true, false, _) => 1,
                (true, true, false) => 2,
                (false, _, _) => 3,
            }
        };
        let cells = |count: usize| (0..count * count).map(move |n| (n % count, n / count));
        let coarse: Vec<u8> = cells(CELLS)
            .map(|(column, row)| class(column, row, CELLS))
            .collect();
        let is_uniform = |column: usize, row: usize| {
            let near = |n: usize| n.saturating_sub(1)..(n + 2).min(CELLS);
            let own = coarse[row * CELLS + column];
            near(row).all(|row| near(column).all(|column| coarse[row * CELLS + column] == own))
        };
        let uniform: Vec<bool> = cells(CELLS)
            .map(|(column, row)| is_uniform(column, row))
            .collect();
        let classes: Vec<u8> = cells(FINE_CELLS)
            .map(|(column, row)| {
                let cell = row / PARTS * CELLS + column / PARTS;
                match uniform[cell] {
                    true => coarse[cell],
                    false => class(column, row, FINE_CELLS),
                }
            })
            .collect();
        let key = [
            ("stable, in the range", crate::figure::Color::hex(0xcfe8f3)),
            (
                "violated without the constraint",
                crate::figure::Color::hex(0xf2c07a),
            ),
            (
                "stable, beyond the range",
                crate::figure::Color::hex(0xe6ecf6),
            ),
            ("criterion violated", crate::figure::Color::hex(0xd9895f)),
        ];
        let hatched = [(1, palette::GREY), (3, palette::VERMILION)].map(|(class, color)| {
            let is_own = |u: f64, v: f64| {
                let cell = |t: f64| ((t * FINE_CELLS as f64) as usize).min(FINE_CELLS - 1);
                classes[cell(v) * FINE_CELLS + cell(u)] == class
            };
            hatching(|u, v| (high.powf(u), end.powf(v)), is_own).color(color)
        });
        let regions = Regions {
            x: (1.0, high),
            y: (1.0, end),
            columns: FINE_CELLS,
            rows: FINE_CELLS,
            classes,
            key: key.map(|(name, color)| (name.to_owned(), color)).to_vec(),
        };
        let mut panel = Panel::new(
            "states at constant volume",
            axis("largest stretch λ₁ (−)", high),
            axis("1/λ₃ (−)", end),
        )
        .with(regions);
        for lines in hatched {
            panel = panel.with(lines);
        }
        let tests = self
            .data
            .iter()
            .filter(|test| test.mode != Mode::Volumetric);
        for (n, test) in tests.enumerate() {
            let states = test.points.iter().map(|point| {
                let mut logs = test.mode.logs(point.stretch);
                logs.sort_by(|a, b| b.total_cmp(a));
                (logs[0].exp(), (-logs[2]).exp())
            });
            let points = Points::new(states.collect())
                .color(palette::SERIES[n % palette::SERIES.len()])
                .marker(MARKERS[n % MARKERS.len()])
                .size(5.0)
                .named(&test.name);
            // Markers of further tests are open.
            panel = panel.with(match n / MARKERS.len() % 2 {
                0 => points,
                _ => points.open(),
            });
        }
        panel
    }
}
