//! Output files of a screening: a table, a document, a figure, a study of the decisive state, and fields of frames.

use super::{Run, ScreenAnswer, ScreenError, Snapshot};
use crate::output::{Batch, Output};
use crate::vtk::{Grid, pvd};
use std::path::PathBuf;

/// Files that are written while a run is processed. They are moved to their folder together at the end.
#[derive(Debug)]
pub struct ScreenFiles<'r> {
    batch: Batch,
    run: &'r Run,
    /// Largest number of frames with fields.
    most: usize,
    written: Vec<(f64, String)>,
}

impl<'r> ScreenFiles<'r> {
    /// Names of the files that are written once, independent of the number of frames; the figure is not listed.
    pub const NAMES: [&'static str; 5] = [
        "screen.pvd",
        "screen.csv",
        "screen.json",
        "first.toml",
        "modes.vtu",
    ];

    /// Begins the output of a screened run. Fields are written for at most `most` frames, evenly spaced.
    ///
    /// # Errors
    /// [`ScreenError::Output`] if the folder cannot be written.
    pub fn new(output: Output, run: &'r Run, most: usize) -> Result<Self, ScreenError> {
        Ok(Self {
            batch: output.begin()?,
            run,
            most,
            written: Vec::new(),
        })
    }

    /// Writes the fields of a frame. Frames are skipped evenly if there are more than the largest number.
    ///
    /// # Errors
    /// [`ScreenError::Output`] if a file cannot be written.
    pub fn add(&mut self, snapshot: &Snapshot<'_>, frames: usize) -> Result<(), ScreenError> {
        let every = frames.div_ceil(self.most.max(1));
        if self.most == 0 || !snapshot.number.is_multiple_of(every) {
            return Ok(());
        }
        let run = self.run;
        let dimension = snapshot.dimension;
        let both = snapshot.x.iter().zip(&run.reference);
        let displacement = both
            .map(|(x, from)| std::array::from_fn(|i| x[i] - from[i]))
            .collect();
        let held: Vec<f64> = run.held.iter().map(|is| f64::from(u8::from(*is))).collect();
        let mut grid = Grid {
            points: snapshot.x,
            vectors: vec![
                ("displacement", displacement),
                ("reference", run.reference.clone()),
            ],
            ..Grid::default()
        };
        grid.scalars = snapshot
            .of_nodes
            .iter()
            .map(|(name, all)| (*name, all.as_slice()))
            .collect();
        grid.scalars.push(("held", &held));
        let of_points = snapshot
            .of_points
            .iter()
            .map(|(name, all)| (*name, all.as_slice()));
        match &run.cells {
            Some(cells) => {
                grid.elements = Some((dimension, cells));
                grid.of_elements = of_points.collect();
            }
            None => grid.scalars.extend(of_points),
        }
        let name = format!("screen-{:06}.vtu", snapshot.number);
        let text = grid.vtu();
        self.batch.add(&name, text.as_bytes())?;
        self.written.push((snapshot.time, name));
        Ok(())
    }

    /// Writes the files that do not depend on frames; returns the paths of all files.
    ///
    /// # Errors
    /// [`ScreenError::Output`] if a figure cannot be drawn or a file not be written.
    pub fn finish(mut self, answer: &ScreenAnswer) -> Result<Vec<PathBuf>, ScreenError> {
        if !self.written.is_empty() {
            let all = self.written.iter();
            let all = all.map(|(time, name)| (*time, name.as_str()));
            self.batch.add("screen.pvd", pvd(all).as_bytes())?;
        }
        self.batch.add_all(&answer.files())?;
        Ok(self.batch.finish()?)
    }
}
