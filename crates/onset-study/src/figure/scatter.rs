//! Particles colored by a value.

use super::{ColorMap, Field, Panel, Points};

/// Number of colors of the marks, evenly spaced from the lowest to the highest value.
const CLASSES: usize = 32;

/// Largest diameter of a mark relative to the width of the panel, for few particles.
const LARGEST_MARK: f64 = 0.03;

impl Panel {
    /// Adds particles as round marks that nearly touch, colored by their values from `low` to `high`, with a color bar. The ranges of the axes are
    /// extended so that the marks lie inside the panel.
    #[must_use]
    pub fn with_particles(
        mut self,
        places: &[(f64, f64)],
        values: &[f64],
        (low, high): (f64, f64),
        label: impl Into<String>,
    ) -> Self {
        let length = |(start, end): (f64, f64)| end - start;
        let (across, along) = (length(self.x.range), length(self.y.range));
        // The mean distance of the particles.
        let distance = (across * along / places.len() as f64).sqrt();
        let extent = (0.8 * distance).min(LARGEST_MARK * across);
        for range in [&mut self.x.range, &mut self.y.range] {
            *range = (range.0 - 0.5 * extent, range.1 + 0.5 * extent);
        }
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
            self = self.with(Points::new(own).extent(extent).color(color));
        }
        // A blank map has the color bar; it is the last layer, because marks over a map have a rim.
        let (x, y) = (self.x.range, self.y.range);
        self.with(Field::new(x, y, (1, 1), vec![f64::NAN], label).range(low, high))
    }
}
