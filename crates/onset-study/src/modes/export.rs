//! Modes as displacement fields of a patch, to seed a simulation.

use super::{ModesAnswer, ShownMode};
use crate::figure::FigureError;
use std::fmt::Write;
use std::path::Path;
use thiserror::Error;

/// Why modes could not be written.
#[derive(Debug, Error)]
pub enum ExportError {
    /// A file.
    #[error("cannot write {path}: {source}")]
    File {
        /// Which one.
        path: String,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// The figure.
    #[error(transparent)]
    Figure(#[from] FigureError),
}

impl ModesAnswer {
    /// Writes the figure (`modes.svg`, `modes.png`), the moving picture (`modes.html`), and for each mode the displacement field of the
    /// patch as `mode-1.csv` and `mode-1.vtk`; the paths.
    ///
    /// # Errors
    /// [`ExportError`] with the path that could not be written.
    pub fn write(&self, folder: &Path) -> Result<Vec<String>, ExportError> {
        let figures = self.figure().write(folder, "modes")?;
        let mut written: Vec<String> = figures
            .iter()
            .map(|path| path.display().to_string())
            .collect();
        let mut files = vec![("modes.html".to_owned(), self.page())];
        for (n, mode) in self.modes.iter().enumerate() {
            files.push((format!("mode-{}.csv", n + 1), mode.csv()));
            files.push((format!("mode-{}.vtk", n + 1), mode.vtk()));
        }
        for (name, text) in files {
            let path = folder.join(name);
            let shown = path.display().to_string();
            std::fs::write(&path, text).map_err(|source| ExportError::File {
                path: shown.clone(),
                source,
            })?;
            written.push(shown);
        }
        Ok(written)
    }
}

impl ShownMode {
    /// Positions and displacements of the particles, a line each.
    pub fn csv(&self) -> String {
        let mut text = String::from("x1,x2,x3,u1,u2,u3\n");
        for (x, u) in self.positions.iter().zip(&self.displacements) {
            let numbers = x.iter().chain(u).map(|number| format!("{number:.16e}"));
            let _ = writeln!(text, "{}", numbers.collect::<Vec<_>>().join(","));
        }
        text
    }

    /// The same as a VTK file (legacy format, text): points with the vectors `displacement`, for ParaView and its kin.
    pub fn vtk(&self) -> String {
        let count = self.positions.len();
        let mut text = format!(
            "# vtk DataFile Version 3.0\nspurious mode, k = {} in units of the reciprocal vectors\nASCII\nDATASET POLYDATA\n\
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
