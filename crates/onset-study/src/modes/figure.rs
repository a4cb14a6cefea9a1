//! Modes drawn on the lattice.

use super::{ModesAnswer, ShownMode};
use crate::figure::{Arrows, Axis, Figure, Panel, Points, palette};

/// Modes that are drawn.
const DRAWN: usize = 6;

/// Where the third axis points in the picture.
const THIRD: (f64, f64) = (0.45, 0.3);
/// Half the side of the cube of particles that is drawn in space, in spacings.
const HALF_SIDE: f64 = 2.2;

impl ModesAnswer {
    /// The first modes, each on a patch of particles: where they are, and how they move. Of three dimensions the middle of the patch
    /// is shown, seen obliquely.
    pub fn figure(&self) -> Figure {
        let figure = Figure::new("Spurious modes of the undeformed body").columns(3);
        let shown = self.modes.iter().take(DRAWN);
        let figure = shown.fold(figure, |figure, mode| figure.with(self.panel(mode)));
        let mut caption = String::new();
        if !self.modes.is_empty() {
            caption.push_str("Wave vectors in units of the reciprocal vectors.");
            if self.dimension > 1 {
                caption.push_str(" Arrows: twice the displacements.");
            }
        }
        match self.modes.len().saturating_sub(DRAWN) {
            0 => {}
            1 => caption.push_str(" One more mode is listed, but not drawn."),
            rest => caption.push_str(&format!(" {rest} more modes are listed, but not drawn.")),
        }
        caption.push_str(&format!(" {}", self.settings.caption()));
        figure.caption(caption.trim_start())
    }

    /// A place or a displacement in the picture.
    pub(super) fn seen(&self, x: &[f64; 3]) -> (f64, f64) {
        (x[0] + THIRD.0 * x[2], x[1] + THIRD.1 * x[2])
    }

    /// The particles that are shown: all, in space those in the middle of the patch.
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
        let title = format!("k = {}: {}", mode.place(), mode.kind());
        let (from, to): (Vec<_>, Vec<_>) = self
            .shown(mode)
            .into_iter()
            .map(|n| self.arrow(&mode.positions[n], &mode.displacements[n]))
            .unzip();
        let ends = || from.iter().chain(&to);
        let labels = match self.dimension {
            // Displacements along the line are drawn across it.
            1 => [
                "x₁ (length)".to_owned(),
                "displacement u₁ (length)".to_owned(),
            ],
            2 => ["x₁ (length)".to_owned(), "x₂ (length)".to_owned()],
            _ => [
                format!("x₁ + {} x₃ (length)", THIRD.0),
                format!("x₂ + {} x₃ (length)", THIRD.1),
            ],
        };
        let [x, y] = labels.map(|label| Axis::linear(label, (0.0, 1.0)));
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
                    .size(5.0)
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
        // Twice as long, so that it shows.
        let (from, along) = (self.seen(x), self.seen(u));
        (from, (from.0 + 2.0 * along.0, from.1 + 2.0 * along.1))
    }
}
