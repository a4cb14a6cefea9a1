//! Modes drawn on the lattice.

use super::{ModesAnswer, ShownMode};
use crate::figure::{Arrows, Axis, Figure, Panel, Points, palette};

/// Modes that are drawn.
const DRAWN: usize = 6;

impl ModesAnswer {
    /// The first modes, each on a patch of particles: where they are, and how they move. Of three dimensions the first two are
    /// shown.
    pub fn figure(&self) -> Figure {
        let figure = Figure::new("Spurious modes of the undeformed body").columns(3);
        let shown = self.modes.iter().take(DRAWN);
        let figure = shown.fold(figure, |figure, mode| figure.with(self.panel(mode)));
        let rest = self.modes.len().saturating_sub(DRAWN);
        figure.caption(match rest {
            0 => String::new(),
            rest => format!("{rest} more modes are listed, but not drawn."),
        })
    }

    fn panel(&self, mode: &ShownMode) -> Panel {
        let title = format!("k = {}: {}", mode.place(), mode.kind());
        let coordinates = |axis: usize| mode.positions.iter().map(move |x| x[axis]);
        let x = Axis::linear("x₁ (length)", (0.0, 1.0)).covering(coordinates(0));
        let (from, to): (Vec<_>, Vec<_>) = mode
            .positions
            .iter()
            .zip(&mode.displacements)
            .map(|(x, u)| self.arrow(x, u))
            .unzip();
        let y = match self.dimension {
            // Displacements along the line are drawn across it.
            1 => Axis::linear("displacement u₁ (length)", (-1.0, 1.0))
                .covering(to.iter().map(|end: &(f64, f64)| end.1)),
            _ => Axis::linear("x₂ (length)", (0.0, 1.0)).covering(coordinates(1)),
        };
        let panel = Panel::new(title, x, y)
            .with(Arrows::new(from.clone(), to).color(palette::VERMILION))
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
            ((x[0], 0.0), (x[0], u[0]))
        } else {
            // Twice as long, so that it shows.
            ((x[0], x[1]), (x[0] + 2.0 * u[0], x[1] + 2.0 * u[1]))
        }
    }
}
