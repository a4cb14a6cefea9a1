//! Particles colored by a value.

use super::{ColorMap, Field, Panel, Points};

/// Number of colors of the marks, evenly spaced from the lowest to the highest value.
const CLASSES: usize = 32;

impl Panel {
    /// Adds particles as marks that nearly touch in a panel of the given width (pixels), colored by their values from `low` to `high`, with a color bar.
    #[must_use]
    pub fn with_particles(
        mut self,
        places: &[(f64, f64)],
        values: &[f64],
        (low, high): (f64, f64),
        width: f64,
        label: impl Into<String>,
    ) -> Self {
        let (across, along) = (
            self.x.range.1 - self.x.range.0,
            self.y.range.1 - self.y.range.0,
        );
        // Round marks that nearly touch at the mean distance.
        let area = across * along / places.len() as f64;
        let size = (0.8 * area.sqrt() * width / across).clamp(1.0, 9.0);
        for class in 0..CLASSES {
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
            let middle = low + (high - low) * (class as f64 + 0.5) / CLASSES as f64;
            let color = ColorMap::Viridis.color(middle, (low, high));
            self = self.with(Points::new(own).size(size).color(color));
        }
        // A blank map has the color bar; it is the last layer, because marks over a map have a rim.
        let (x, y) = (self.x.range, self.y.range);
        self.with(Field::new(x, y, (1, 1), vec![f64::NAN], label).range(low, high))
    }
}
