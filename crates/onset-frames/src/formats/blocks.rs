//! Text files whose frames consist of a head with the number of particles, and a row for each particle.

use super::{Opened, Source, Stamp};
use crate::columns::{Available, Dialect, Plan};
use crate::error::{FrameError, Place};
use crate::frame::Frame;
use crate::reading::{Quantity, Reading};
use crate::text::{Digits, Lines, Mark, Rows, words};
use std::path::PathBuf;

/// Head of a frame.
pub(super) trait Head: Sized + Send + 'static {
    /// Names of columns follow the rules of this program.
    const DIALECT: Dialect;
    /// Hint for files that do not follow the format.
    const HINT: &'static str;

    /// Reads a head, or returns `None` at the end of the file; the number of the frame is used in messages.
    fn read(lines: &mut Lines, number: usize) -> Result<Option<Self>, FrameError>;

    /// Number of rows, one for each particle.
    fn count(&self) -> u64;

    /// Names of the columns.
    fn names(&self) -> &[String];

    /// Time and number of the step.
    fn stamp(&self) -> Stamp;

    /// Additional columns that [`finish`](Self::finish) needs.
    fn extra(&self) -> Vec<usize> {
        Vec::new()
    }

    /// Completes a frame with the contents of the head, the columns of the positions, and the values of all used columns.
    fn finish(
        &self,
        frame: &mut Frame,
        columns: &[usize],
        values: &[Vec<f64>],
    ) -> Result<(), FrameError>;
}

struct Blocks<H> {
    reading: Reading,
    paths: Vec<PathBuf>,
    /// File, position and number of each frame in its file.
    frames: Vec<(usize, Mark, usize)>,
    open: Option<(usize, Lines)>,
    plan: Plan,
    is_shuffled: bool,
    head: std::marker::PhantomData<H>,
}

fn planned<H: Head>(head: &H, reading: &Reading, place: &Place) -> Result<Plan, FrameError> {
    let available = head.names().iter().map(Available::scalar).collect();
    Plan::of(available, reading, H::DIALECT, place)
}

fn too_many(place: Place, count: u64, reading: &Reading) -> FrameError {
    let most = reading.limits.particles;
    FrameError::refused(
        place,
        format!("{count} particles; the limit is {most}"),
        "give a smaller region of the simulation",
    )
}

/// Opens files, and locates their complete frames.
pub(super) fn open<H: Head>(paths: &[PathBuf], reading: &Reading) -> Result<Opened, FrameError> {
    let (mut frames, mut stamps, mut ignored) = (Vec::new(), Vec::new(), Vec::new());
    let mut plan: Option<Plan> = None;
    let mut digits = Digits::default();
    for (file, path) in paths.iter().enumerate() {
        let mut lines = Lines::open(path, reading.limits)?;
        let cut = |number| format!("{} is cut off in the frame", Place::frame(path, number));
        for number in 0.. {
            let mark = lines.mark();
            let Some(head) = H::read(&mut lines, number)? else {
                if lines.mark() != mark {
                    ignored.push(cut(number));
                }
                break;
            };
            let count = head.count();
            if count > reading.limits.particles as u64 {
                return Err(too_many(lines.place(), count, reading));
            }
            if plan.is_none() {
                let own = planned(&head, reading, &lines.place())?;
                digits.columns = own.columns_of(Quantity::Position);
                plan = Some(own);
            }
            // Sample rows throughout the frame, because neighboring rows often have equal coordinates.
            let stride = count / Digits::ROWS + 1;
            let mut rest = count;
            let mut is_complete = true;
            while is_complete && rest > 0 {
                is_complete = lines.next_whole()?;
                digits.read(words(lines.line()));
                let skipped = (stride - 1).min(rest - 1);
                is_complete = is_complete && lines.skip(skipped)?;
                rest -= 1 + skipped;
            }
            if !is_complete {
                ignored.push(cut(number));
                break;
            }
            if frames.len() >= reading.limits.frames {
                return Err(FrameError::refused(
                    lines.place(),
                    format!("more than {} frames", reading.limits.frames),
                    "split the file, or write fewer frames",
                ));
            }
            frames.push((file, mark, number));
            let Stamp { time, step } = head.stamp();
            let of_step = || Some(step? as f64 * reading.time_step?);
            let time = time.or_else(of_step);
            stamps.push(Stamp { time, step });
        }
    }
    let Some(plan) = plan else {
        return Err(FrameError::wrong(
            Place::file(&paths[0]),
            "at least one complete frame",
            H::HINT,
        ));
    };
    let source = Blocks::<H> {
        reading: reading.clone(),
        paths: paths.to_vec(),
        frames,
        open: None,
        plan: plan.clone(),
        is_shuffled: false,
        head: std::marker::PhantomData,
    };
    Ok(Opened {
        source: Box::new(source),
        stamps,
        plan,
        digits: Some(digits.most).filter(|digits| *digits > 0),
        ignored,
    })
}

impl<H> Blocks<H> {
    fn lines(&mut self, file: usize) -> Result<&mut Lines, FrameError> {
        if self.open.as_ref().is_none_or(|(own, _)| *own != file) {
            let mut lines = Lines::open(&self.paths[file], self.reading.limits)?;
            if self.is_shuffled {
                lines.unpack()?;
            }
            self.open = Some((file, lines));
        }
        match &mut self.open {
            Some((_, lines)) => Ok(lines),
            None => unreachable!("opened above"),
        }
    }
}

impl<H: Head> Source for Blocks<H> {
    fn shuffle(&mut self) -> Result<(), FrameError> {
        self.is_shuffled = true;
        self.open = None;
        Ok(())
    }

    fn read(&mut self, frame: usize) -> Result<Frame, FrameError> {
        let (file, mark, number) = self.frames[frame];
        let changed = |place| {
            FrameError::refused(
                place,
                "the file has changed since it was opened",
                "wait until the simulation has ended",
            )
        };
        let lines = self.lines(file)?;
        lines.go_to(mark)?;
        let start = Place {
            line: Some(mark.lines + 1),
            ..Place::frame(lines.path(), number)
        };
        let Some(head) = H::read(lines, number)? else {
            return Err(changed(start));
        };
        let place = lines.place();
        if !self.plan.is_for_names(head.names()) {
            self.plan = planned(&head, &self.reading, &place)?;
        }
        if head.count() > self.reading.limits.particles as u64 {
            return Err(too_many(place, head.count(), &self.reading));
        }
        let mut rows = Rows::new(self.plan.wanted());
        head.extra()
            .into_iter()
            .for_each(|column| rows.want(column));
        let lines = self.lines(file)?;
        for _ in 0..head.count() {
            if !lines.next_whole()? {
                return Err(changed(start));
            }
            rows.push(words(lines.line()), || lines.place())?;
        }
        let mut own = self
            .plan
            .frame(&rows.values, head.count() as usize, None)
            .map_err(|expected| FrameError::wrong(start.clone(), expected, H::HINT))?;
        own.source = start;
        let columns = self.plan.columns_of(Quantity::Position);
        head.finish(&mut own, &columns, &rows.values)?;
        let Stamp { time, step } = head.stamp();
        own.time = time.or(own.time);
        own.step = step;
        Ok(own)
    }
}
