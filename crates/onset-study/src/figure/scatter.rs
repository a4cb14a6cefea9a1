//! Particles colored by a value.

use super::{ColorMap, Panel, Points};

/// Number of color classes.
const CLASSES: usize = 8;

impl Panel {
    /// Adds particles as marks that nearly touch in a panel of the given width (pixels), colored in classes of their values from `low` to `high`.
    ///
    /// `named` gives the name of a class from its lower and upper limit.
    #[must_use]
    pub fn with_particles(
        mut self,
        places: &[(f64, f64)],
        values: &[f64],
        (low, high): (f64, f64),
        width: f64,
        named: impl Fn(f64, f64) -> String,
    ) -> Self {
        let (across, along) = (
            self.x.range.1 - self.x.range.0,
            self.y.range.1 - self.y.range.0,
        );
        // Round marks that nearly touch at the mean distance.
        let area = across * along / places.len() as f64;
        let size = (0.8 * area.sqrt() * width / across).clamp(1.0, 9.0);
        for class in 0..CLASSES {
            let edge = |n: usize| low + (high - low) * n as f64 / CLASSES as f64;
            let is_own = |own: &f64| {
                let place = (own - low) / (high - low) * CLASSES as f64;
                (place as usize).min(CLASSES - 1) == class
            };
            let all = places.iter().zip(values);
            let own = all.filter(|(_, value)| is_own(value));
            let own: Vec<(f64, f64)> = own.map(|(place, _)| *place).collect();
            if own.is_empty() {
                continue;
            }
            let middle = 0.5 * (edge(class) + edge(class + 1));
            let points = Points::new(own)
                .size(size)
                .color(ColorMap::Viridis.color(middle, (low, high)))
                .named(named(edge(class), edge(class + 1)));
            self = self.with(points);
        }
        self
    }
}
