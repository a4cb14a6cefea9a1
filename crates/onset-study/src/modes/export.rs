//! Modes as displacement fields of a patch, for initial conditions of a simulation.

use super::{ModesAnswer, ShownMode};
use crate::output::{Files, picture, text};
use std::fmt::Write;

impl ModesAnswer {
    /// Returns the figure (`modes`), the animation (`modes.html`), and for each mode the displacement field of the patch
    /// (`mode-1.csv` and `mode-1.vtk`).
    pub fn files(&self) -> Files {
        let mut files = vec![
            picture("modes", self.figure()),
            text("modes.html", self.page()),
        ];
        for (n, mode) in self.modes.iter().enumerate() {
            files.push(text(format!("mode-{}.csv", n + 1), mode.csv()));
            files.push(text(format!("mode-{}.vtk", n + 1), mode.vtk(self.cells)));
        }
        files
    }
}

impl ShownMode {
    /// Positions and displacements as CSV, one line for each particle.
    pub fn csv(&self) -> String {
        let mut text = String::from("x1,x2,x3,u1,u2,u3\n");
        for (x, u) in self.positions.iter().zip(&self.displacements) {
            let numbers = x.iter().chain(u).map(|number| format!("{number:.16e}"));
            let _ = writeln!(text, "{}", numbers.collect::<Vec<_>>().join(","));
        }
        text
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
