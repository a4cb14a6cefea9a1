//! Figure of a localization: moduli along the path, and critical moduli by direction.

use super::LocalizationAnswer;
use crate::caption;
use crate::figure::{Axis, Figure, Line, Panel, Points, Rule, palette};
use crate::output::{Files, picture, text};

impl LocalizationAnswer {
    /// The figure `localize`, and the files `localize.csv` and `localize-directions.csv`.
    pub fn files(&self) -> Files {
        vec![
            picture("localize", self.figure("Where the material localizes")),
            text("localize.csv", self.csv()),
            text("localize-directions.csv", self.directions_csv()),
        ]
    }

    /// Draws plastic and critical moduli against plastic shear strain, and critical moduli by direction at the state closest to localization.
    pub fn figure(&self, title: impl Into<String>) -> Figure {
        Figure::new(title)
            .columns(2)
            .caption(format!("{} Parameters: {}.", self.sentence, self.told))
            .with(self.along_the_path())
            .with(self.by_direction())
    }

    fn along_the_path(&self) -> Panel {
        let curve = |value: fn(&super::PointAnswer) -> f64| -> Vec<(f64, f64)> {
            self.path
                .iter()
                .map(|point| (point.slip, value(point)))
                .collect()
        };
        let modulus = curve(|point| point.plastic_modulus);
        let critical = curve(|point| point.critical_modulus);
        let strong = curve(|point| point.strong_critical_modulus);
        let heights = [&modulus, &critical, &strong]
            .into_iter()
            .flatten()
            .map(|point| point.1)
            .chain([0.0]);
        let end = self.path.last().map_or(1.0, |point| point.slip);
        let x = Axis::linear("plastic shear strain γ (−)", (0.0, end));
        let y = Axis::linear(caption::label(self.units, "modulus", "stress"), (0.0, 1.0))
            .covering(heights);
        let mut panel = Panel::new("along the path", x, y)
            .with(Rule::horizontal(0.0))
            .with(
                Line::new(modulus)
                    .named("plastic modulus h")
                    .color(palette::BLUE),
            )
            .with(
                Line::new(critical)
                    .named("critical modulus, ellipticity")
                    .color(palette::VERMILION),
            )
            // Drawn last, because it may coincide with the line of ellipticity.
            .with(
                Line::new(strong)
                    .named("critical modulus, strong ellipticity")
                    .color(palette::BLACK)
                    .dashed(),
            );
        if let Some(onset) = &self.localization {
            let place = (onset.slip, onset.critical_modulus);
            panel = panel.with(Rule::vertical(onset.slip).dotted()).with(
                Points::new(vec![place])
                    .named("localization")
                    .color(palette::BLACK),
            );
        }
        panel
    }

    fn by_direction(&self) -> Panel {
        let curve = |value: fn(&super::DirectionAnswer) -> f64| -> Vec<(f64, f64)> {
            self.directions
                .iter()
                .map(|direction| (direction.angle, value(direction)))
                .collect()
        };
        let critical = curve(|direction| direction.critical_modulus);
        let strong = curve(|direction| direction.strong_critical_modulus);
        let modulus = self.closest.plastic_modulus;
        let heights = [&critical, &strong]
            .into_iter()
            .flatten()
            .map(|point| point.1)
            .chain([modulus]);
        let x = Axis::linear("normal to axis of smallest stress (°)", (0.0, 90.0));
        let y = Axis::linear(
            caption::label(self.units, "critical modulus", "stress"),
            (0.0, 1.0),
        )
        .covering(heights);
        let title = if self.localization.is_some() {
            "by direction, at localization"
        } else {
            "by direction, closest to localization"
        };
        Panel::new(title, x, y)
            .with(Rule::horizontal(modulus).color(palette::BLUE))
            .with(Rule::vertical(self.closest.band.angle_to_minor).dotted())
            .with(Line::new(critical).color(palette::VERMILION))
            .with(Line::new(strong).color(palette::BLACK).dashed())
    }
}
