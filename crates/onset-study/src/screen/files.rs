//! Output files of a screening: a table, a document, a figure, a study of the decisive state, and fields of frames.

use super::{Run, ScreenAnswer, ScreenError, Snapshot};
use crate::output::{Batch, Output};
use crate::vtk::{Grid, pvd};
use std::path::PathBuf;

/// Name of the collection of fields.
const COLLECTION: &str = "screen.pvd";

/// Files that are written while a run is processed. They are moved to their folder together at the end.
#[derive(Debug)]
pub struct ScreenFiles<'r> {
    batch: Batch,
    run: &'r Run,
    /// Largest number of frames with fields.
    most: usize,
    written: Vec<Written>,
    /// Last frame, if its fields are not written.
    skipped: Option<Skipped>,
}

/// Frame whose fields are written.
#[derive(Debug)]
struct Written {
    number: usize,
    time: f64,
    name: String,
}

/// Fields of a frame that are written only if an event follows.
#[derive(Debug)]
struct Skipped {
    x: Vec<[f64; 3]>,
    snapshot: Snapshot<'static>,
}

impl Skipped {
    fn new(own: &Snapshot<'_>) -> Self {
        Self {
            x: own.x.to_vec(),
            snapshot: Snapshot {
                number: own.number,
                time: own.time,
                dimension: own.dimension,
                is_event: own.is_event,
                x: &[],
                of_nodes: own.of_nodes.clone(),
                of_points: own.of_points.clone(),
            },
        }
    }
}

/// Returns true for `count` of `frames` numbers, evenly spaced and with the first and the last.
fn is_regular(number: usize, frames: usize, count: usize) -> bool {
    let intervals = frames.saturating_sub(1).max(1);
    let part = |number: usize| number * (count.min(frames) - 1) / intervals;
    number == 0 || part(number) > part(number - 1)
}

/// File name of the fields of a frame.
fn field_name(number: usize) -> String {
    format!("screen-{number:06}.vtu")
}

/// Fields in a collection of this command.
fn fields_in(collection: &str) -> Vec<String> {
    let names = collection.split("file=\"").skip(1);
    let names = names.filter_map(|rest| rest.split('"').next());
    let is_field = |name: &&str| {
        let number = name
            .strip_prefix("screen-")
            .and_then(|name| name.strip_suffix(".vtu"));
        number.is_some_and(|own| own.len() >= 6 && own.bytes().all(|c| c.is_ascii_digit()))
    };
    names.filter(is_field).map(str::to_owned).collect()
}

impl<'r> ScreenFiles<'r> {
    /// Names of the files that are written once, independent of the number of frames; the figure is not listed.
    pub const NAMES: [&'static str; 5] = [
        COLLECTION,
        "screen.csv",
        "screen.json",
        "first.toml",
        "modes.vtu",
    ];

    /// Begins the output of a screened run. Fields are written for at most `most` frames: evenly spaced frames, and the frames of the first cause and
    /// of the first short waves.
    ///
    /// # Errors
    /// [`ScreenError::Output`] if the folder cannot be written.
    pub fn new(output: Output, run: &'r Run, most: usize) -> Result<Self, ScreenError> {
        Ok(Self {
            batch: output.begin()?,
            run,
            most,
            written: Vec::new(),
            skipped: None,
        })
    }

    /// Writes the fields of a frame if it is one of the evenly spaced frames, or if an event occurs in it. The frame before an event is written, too.
    ///
    /// # Errors
    /// [`ScreenError::Output`] if a file cannot be written.
    pub fn add(&mut self, snapshot: &Snapshot<'_>, frames: usize) -> Result<(), ScreenError> {
        if self.most == 0 {
            return Ok(());
        }
        let skipped = self.skipped.take();
        if !snapshot.is_event && !is_regular(snapshot.number, frames, self.most) {
            self.skipped = Some(Skipped::new(snapshot));
            return Ok(());
        }
        if let Some(Skipped { x, snapshot: own }) = skipped.filter(|_| snapshot.is_event) {
            self.write(&Snapshot { x: &x, ..own })?;
        }
        self.write(snapshot)
    }

    fn write(&mut self, snapshot: &Snapshot<'_>) -> Result<(), ScreenError> {
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
        let name = field_name(snapshot.number);
        let text = grid.vtu();
        self.batch.add(&name, text.as_bytes())?;
        self.written.push(Written {
            number: snapshot.number,
            time: snapshot.time,
            name,
        });
        Ok(())
    }

    /// Removes fields until at most `most` are left. The frames of the first cause and of the first short waves are kept, then frames far from others.
    fn thin_out(&mut self, answer: &ScreenAnswer) {
        let events = [&answer.first, &answer.observed];
        let times: Vec<f64> = events
            .into_iter()
            .flatten()
            .map(|event| event.window[1])
            .take(self.most)
            .collect();
        while self.written.len() > self.most {
            let all = &self.written;
            let distance = |n: usize| {
                let before = n.checked_sub(1).map(|m| all[n].number - all[m].number);
                let after = all.get(n + 1).map(|own| own.number - all[n].number);
                before.zip(after).map_or(usize::MAX, |(a, b)| a + b)
            };
            let removable = (0..all.len()).filter(|n| !times.contains(&all[*n].time));
            let Some(n) = removable.min_by_key(|n| distance(*n)) else {
                return;
            };
            let removed = self.written.remove(n);
            self.batch.remove(&removed.name);
        }
    }

    /// Writes the files that do not depend on frames; returns the paths of all files. Fields of an earlier run in the same folder, which its collection
    /// lists, are removed.
    ///
    /// # Errors
    /// [`ScreenError::Output`] if a figure cannot be drawn or a file not be written.
    pub fn finish(mut self, answer: &ScreenAnswer) -> Result<Vec<PathBuf>, ScreenError> {
        self.thin_out(answer);
        if !self.written.is_empty() {
            let all = self.written.iter();
            let all = all.map(|own| (own.time, own.name.as_str()));
            self.batch.add(COLLECTION, pvd(all).as_bytes())?;
        }
        self.batch.add_all(&answer.files())?;
        let mut old = match self.batch.earlier(COLLECTION) {
            Some(collection) => fields_in(&collection),
            None => Vec::new(),
        };
        if !old.is_empty() {
            old.push(COLLECTION.to_owned());
        }
        Ok(self.batch.finish_without(&old)?)
    }
}

#[cfg(test)]
mod tests {
    use super::{fields_in, is_regular};

    #[test]
    fn the_largest_number_of_frames_is_written_if_there_are_more() {
        for (frames, most, expected) in
            [(52, 50, 50), (52, 3, 3), (10, 50, 10), (7, 1, 1), (1, 5, 1)]
        {
            let all: Vec<usize> = (0..frames)
                .filter(|n| is_regular(*n, frames, most))
                .collect();
            assert_eq!(all.len(), expected, "{all:?}");
            assert!(most == 1 || all.last() == Some(&(frames - 1)), "{all:?}");
        }
    }

    #[test]
    fn only_fields_of_this_command_are_found_in_a_collection() {
        let text = "<DataSet file=\"screen-000012.vtu\"/><DataSet file=\"../screen-000013.vtu\"/><DataSet file=\"screen-x.vtu\"/>";
        assert_eq!(fields_in(text), ["screen-000012.vtu"]);
    }
}
