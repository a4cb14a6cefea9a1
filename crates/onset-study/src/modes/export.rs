//! Modes as displacement fields of a patch, for initial conditions of a simulation.

use super::{ModesAnswer, ShownMode};
use crate::csv::Table;
use crate::output::{Files, picture, text};
use crate::settings::Units;
use std::fmt::Write;

impl ModesAnswer {
    /// The modes as CSV, one row for each; `nullity` is 0 for a weakly controlled mode.
    pub fn csv(&self) -> String {
        let dimension = self.dimension;
        Table::new(&self.modes, self.settings.units())
            .each("wave_vector", dimension, "1/length", |own, n| {
                own.wave_vector[n]
            })
            .each("fractional", dimension, "1", |own, n| own.fractional[n])
            .each("wave", dimension, "1/length", |own, n| own.wave[n])
            .with("relative_frequency", "1", |own| own.relative_frequency)
            .with("nullity", "1", |own| own.nullity)
            .with("extent", "1", |own| own.extent.name())
            .with("smallest_patch", "1", |own| own.fit.cells)
            .with("kind", "1", ShownMode::kind)
            .to_string()
    }

    /// Returns the figure (`modes`), the animation (`modes.html`), and for each mode the displacement field of the patch
    /// (`mode-1.csv` and `mode-1.vtk`).
    pub fn files(&self) -> Files {
        let mut files = vec![
            picture("modes", self.figure()),
            text("modes.html", self.page()),
        ];
        let units = self.settings.units();
        for (n, mode) in self.modes.iter().enumerate() {
            files.push(text(format!("mode-{}.csv", n + 1), mode.csv(units)));
            files.push(text(format!("mode-{}.vtk", n + 1), mode.vtk(self.cells)));
        }
        files
    }
}

impl ShownMode {
    /// Positions and displacements as CSV, one line for each particle.
    pub fn csv(&self, units: Units) -> String {
        let particles: Vec<_> = self.positions.iter().zip(&self.displacements).collect();
        Table::new(&particles, units)
            .with("x1", "length", |(x, _)| x[0])
            .with("x2", "length", |(x, _)| x[1])
            .with("x3", "length", |(x, _)| x[2])
            .with("u1", "length", |(_, u)| u[0])
            .with("u2", "length", |(_, u)| u[1])
            .with("u3", "length", |(_, u)| u[2])
            .to_string()
    }

    /// Positions with the vectors `displacement` as a VTK file (legacy format, text), for ParaView and similar programs.
    pub fn vtk(&self, cells: usize) -> String {
        let count = self.positions.len();
        let misfit = match self.fits {
            true => String::new(),
            false => format!("; does not fit {cells} cells: jumps at the periodic boundary"),
        };
        let mut text = format!(
            "# vtk DataFile Version 3.0\nspurious mode, k = {} in units of the reciprocal vectors{misfit}\nASCII\nDATASET POLYDATA\n\
             POINTS {count} double\n",
            self.place()
        );
        let vectors = |text: &mut String, all: &[[f64; 3]]| {
            for [x, y, z] in all {
                let _ = writeln!(text, "{x:.16e} {y:.16e} {z:.16e}");
            }
        };
        vectors(&mut text, &self.positions);
        let _ = writeln!(text, "VERTICES {count} {}", 2 * count);
        for n in 0..count {
            let _ = writeln!(text, "1 {n}");
        }
        let _ = writeln!(text, "POINT_DATA {count}\nVECTORS displacement double");
        vectors(&mut text, &self.displacements);
        text
    }
}
