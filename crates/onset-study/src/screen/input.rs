//! Runs read from the output files of a code.

use super::records::{Contacts, JUMP_SPACINGS, Records, fault, is_finite, median_jump, told_jumps};
use super::rigid::RigidMotion;
use super::{Frame, Run, ScreenError};
use crate::number::{counted, told};
use onset_frames::{Cells, Frame as Read, Quantity, Reading, Recognized, Series};
use serde::Serialize;
use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

/// Largest distance of particles in a face from a rigid motion that counts as none, as a fraction of a spacing.
const RIGID: f64 = 1e-5;
/// Largest distance of the particles of a separate kind from a rigid motion that counts as none, as a fraction of a spacing.
const RIGID_KIND: f64 = 5e-4;
/// Largest number of rigid motions of the held particles of one kind: two or more grips.
const GRIPS: usize = 6;
/// Largest distance of neighbors in a grip; spacings.
const CONNECTED_SPACINGS: f64 = 1.6;
/// Smallest number of particles in a face that moves rigidly.
const LEAST_FACE: usize = 3;
/// Largest distance from a lattice position, in spacings, at which reference positions are regular.
const REGULAR: f64 = 1e-3;

/// Box of the reference configuration.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    low: Vec<f64>,
    high: Vec<f64>,
}

impl Region {
    /// Refuses a box without particles, which the option or argument `name` gives.
    pub(super) fn check(
        &self,
        name: &str,
        reference: &[[f64; 3]],
        dimension: usize,
    ) -> Result<(), ScreenError> {
        if reference.iter().any(|x| self.contains(x)) {
            return Ok(());
        }
        let corner = |of: fn(f64, f64) -> f64| {
            let side = |i: usize| reference.iter().map(|x| x[i]).reduce(of).unwrap_or(0.0);
            let all: Vec<String> = (0..dimension).map(|i| told(side(i))).collect();
            format!("({})", all.join(", "))
        };
        Err(wrong(
            format!("no particle is in the box {self} of {name}"),
            format!(
                "the body extends from {} to {} in the reference configuration",
                corner(f64::min),
                corner(f64::max)
            ),
        ))
    }

    /// Returns true if a reference position lies in the box.
    pub fn contains(&self, x: &[f64; 3]) -> bool {
        let bounds = self.low.iter().zip(&self.high);
        bounds
            .zip(x)
            .all(|((low, high), x)| (low..=high).contains(&x))
    }
}

impl FromStr for Region {
    type Err = ScreenError;

    fn from_str(text: &str) -> Result<Self, ScreenError> {
        let wrong = || {
            wrong(
                format!("`{}` is not a box", quoted(text)),
                "write its lower and upper corner, for example -1,-1:3,20",
            )
        };
        let corner = |text: &str| -> Option<Vec<f64>> {
            let numbers = text.split(',').map(|x| x.trim().parse::<f64>().ok());
            numbers.map(|x| x.filter(|x| !x.is_nan())).collect()
        };
        let (low, high) = text.split_once(':').ok_or_else(wrong)?;
        let (low, high) = corner(low).zip(corner(high)).ok_or_else(wrong)?;
        if low.len() != high.len() || low.len() > 3 {
            return Err(wrong());
        }
        let mut axes = low.iter().zip(&high).enumerate();
        if let Some((axis, (low, high))) = axes.find(|(_, (low, high))| low > high) {
            return Err(self::wrong(
                format!(
                    "the lower corner of the box `{}` exceeds the upper corner along axis {}: {} > {}",
                    quoted(text),
                    axis + 1,
                    told(*low),
                    told(*high)
                ),
                "write the lower corner first, for example -1,-1:3,20",
            ));
        }
        Ok(Self { low, high })
    }
}

impl fmt::Display for Region {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let corner = |x: &[f64]| x.iter().map(|x| told(*x)).collect::<Vec<_>>().join(",");
        write!(formatter, "{}:{}", corner(&self.low), corner(&self.high))
    }
}

/// Particles whose motion is prescribed.
#[derive(Clone, Debug, PartialEq)]
pub enum Held {
    /// Particles of a kind.
    Kind(i64),
    /// Particles in a box of the reference configuration.
    Box(Region),
    /// All particles move freely.
    No,
}

impl FromStr for Held {
    type Err = ScreenError;

    fn from_str(text: &str) -> Result<Self, ScreenError> {
        let kind = text.strip_prefix("type=").unwrap_or(text);
        match (text, kind.parse::<i64>()) {
            ("none", _) => Ok(Self::No),
            (_, Ok(kind)) => Ok(Self::Kind(kind)),
            _ if text.contains(':') => Ok(Self::Box(text.parse()?)),
            _ => Err(wrong(
                format!("held particles `{}` are unknown", quoted(text)),
                "write a type (2), a box (-1,-1:3,20) or none; a column is named by --columns held=NAME",
            )),
        }
    }
}

/// Reference configuration of the computed deformation gradients.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Reference {
    /// Reference positions or displacements in the files; otherwise the first frame.
    #[default]
    Recorded,
    /// Positions of the first frame.
    First,
    /// Positions of the first frame of another file.
    File(PathBuf),
}

/// Files of a run, with the choices for reading.
#[derive(Clone, Debug, Default)]
pub struct Source {
    /// Output files; wildcards are allowed in the last part of a path.
    pub files: Vec<PathBuf>,
    /// Columns, frames and time step.
    pub reading: Reading,
    /// Reference configuration of the computed deformation gradients.
    pub reference: Reference,
    /// Particles with prescribed motion. Without an entry they are the particles marked in the file; otherwise kinds of the minority, or faces, that
    /// move rigidly.
    pub held: Vec<Held>,
    /// Box that contains the particles to be assessed; `None` for all particles.
    pub region: Option<Region>,
}

/// Properties of the files that were recognized, and checked.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Recording {
    /// Number of files after expansion of wildcards.
    pub files: usize,
    /// Format of the files.
    pub format: String,
    /// Number of frames that were read, without skipped frames.
    pub frames: usize,
    /// Number of frames at the end that are skipped, because a frame lacks particles, has infinite positions, or has damaged records.
    pub skipped: usize,
    /// Times of the first and the last frame.
    pub times: [f64; 2],
    /// Longest interval between successive frames; time.
    pub interval: f64,
    /// Number of particles in the first frame.
    pub particles: usize,
    /// Number of elements; zero if the particles have the states.
    pub elements: usize,
    /// Columns, with the quantities assigned to them.
    pub columns: Vec<String>,
    /// Columns that are not used.
    pub unused: Vec<String>,
    /// Significant digits of the positions; `None` for numbers of 64 bits.
    pub digits: Option<u32>,
    /// Number of held particles.
    pub held: usize,
    /// Rule that recognized the held particles.
    pub held_by: String,
    /// Median distance of nearest neighbors in the reference configuration; length.
    pub spacing: f64,
    /// Assumptions, differences and omitted parts.
    pub notes: Vec<String>,
    #[serde(skip)]
    identity: Option<Vec<u64>>,
    /// Number of frames of the series before the end of the reading.
    #[serde(skip)]
    read: usize,
    /// Frames with damaged records, by their numbers in the series, ascending.
    #[serde(skip)]
    jumped: Vec<usize>,
    /// Whether reference positions are read from the files of the run.
    #[serde(skip)]
    is_relative: bool,
}

fn wrong(what: impl Into<String>, hint: impl Into<String>) -> ScreenError {
    ScreenError::Run {
        what: what.into(),
        hint: hint.into(),
    }
}

/// Message about a particle with several records in a frame.
fn twice(frame: &Read, id: u64) -> String {
    let time = frame
        .time
        .map_or_else(String::new, |time| format!(" at t = {}", told(time)));
    format!(
        "{}: particle {id} occurs twice in the frame{time}",
        frame.source
    )
}

/// Beginning of a word given by the user, quoted.
fn quoted(text: &str) -> String {
    text.chars().take(40).collect()
}

/// Sets components beyond the dimensions to zero.
fn flat(x: &[f64; 3], dimension: usize) -> [f64; 3] {
    std::array::from_fn(|i| if i < dimension { x[i] } else { 0.0 })
}

impl Recording {
    /// Reads all frames once, checks them, and returns the particles in the reference configuration with the series of frames.
    ///
    /// Reading ends, with a note, at a frame that lacks particles, has infinite positions, or has most particles at one position. Frames in which a few
    /// particles jump although their neighbors stay together are skipped, with a note. With `has_elements`
    /// states are evaluated in the elements of the files instead of the particles.
    ///
    /// # Errors
    /// [`ScreenError`] for files that cannot be read, and for frames without times.
    pub fn open(
        source: &Source,
        dimension: usize,
        has_elements: bool,
    ) -> Result<(Self, Run, Series), ScreenError> {
        let mut series = Series::open(&source.files, &source.reading)?;
        let mut own = Self::of(series.recognized());
        own.is_relative = source.reference == Reference::Recorded;
        let mut unwrapped = Unwrapped::new(own.is_relative);
        let mut first: Option<Read> = None;
        let mut last: Option<Read> = None;
        let mut time = f64::NEG_INFINITY;
        let mut has_others = false;
        // Without numbers the order of the rows identifies the particles.
        let mut jump: f64 = 0.0;
        let mut damaged: Option<String> = None;
        let has_step = source.reading.time_step.is_some();
        let mut contacts: Option<Contacts> = None;
        // The first frame with damaged records, in words, and whether several of its records are damaged.
        let mut jumped: Option<String> = None;
        for (number, frame) in series.by_ref().enumerate() {
            onset::cancel::checkpoint();
            let mut frame = frame?;
            let now = time_of(&frame, has_step)?;
            let Some(start) = &first else {
                own.begin(&frame)?;
                unwrapped.take(&mut frame, dimension);
                (own.times[0], time) = (now, now);
                first = Some(frame);
                (own.frames, own.read) = (1, 1);
                continue;
            };
            let written = frame.len();
            let fault = own.ordered(&mut frame).or_else(|| broken(&frame));
            let fault = fault.or_else(|| {
                unwrapped.take(&mut frame, dimension);
                None
            });
            if let Some(fault) = fault {
                own.notes
                    .push(format!("{fault}: this and all later frames are skipped"));
                damaged = Some(fault);
                break;
            }
            if written > frame.len() && !has_others {
                has_others = true;
                own.notes.push(format!(
                    "{}: {} that the first frame lacks, skipped from this frame on",
                    frame.source,
                    counted(written - frame.len(), "particle")
                ));
            }
            if last.is_none() && frame.may_be_wrapped {
                own.check_wrapping(start, dimension);
            }
            own.read = number + 1;
            let contacts = contacts.get_or_insert_with(|| {
                let x: Vec<_> = start.position.iter().map(|x| flat(x, dimension)).collect();
                Contacts::new(&x, dimension)
            });
            let before = last.as_ref().unwrap_or(start);
            let is_after_damage = own.jumped.last().is_some_and(|last| last + 1 == number);
            let (from, to) = (records(before, time), records(&frame, now));
            if let Some(damage) = contacts.damage(from, to, is_after_damage) {
                own.jumped.push(number);
                jumped.get_or_insert_with(|| damage.told(own.number(damage.row)));
                continue;
            }
            unwrapped.keep(&frame);
            own.interval = own.interval.max(now - time);
            time = now;
            own.frames += 1;
            if own.identity.is_none() {
                jump = jump.max(median_jump(&before.position, &frame.position));
            }
            last = Some(frame);
        }
        // Bytes after the last frame can be damaged, too, and a damaged file can end the reading early.
        series.check_rest()?;
        if damaged.is_some() {
            let read = own.frames + own.jumped.len();
            own.skipped = series.times().len().saturating_sub(read);
        }
        // Damaged frames at the end leave its time without an assessment.
        let at_end = own.jumped.iter().rev().zip((0..own.read).rev());
        own.skipped += at_end.take_while(|(jumped, n)| *jumped == n).count();
        if unwrapped.has_crossed {
            own.notes.push("particles cross faces of the periodic box of the file: their positions are unwrapped".to_owned());
        }
        own.times[1] = time;
        if let Some(jumped) = jumped {
            own.notes.push(told_jumps(&jumped, own.jumped.len()));
        }
        let (Some(first), Some(last)) = (first, last) else {
            return Err(ScreenError::TooFewFrames {
                count: own.frames,
                why: damaged,
            });
        };
        let (reference, is_first) = own.reference(source, &first)?;
        let reference: Vec<[f64; 3]> = reference.iter().map(|x| flat(x, dimension)).collect();
        if let Some(n) = reference.iter().position(|x| !is_finite(x)) {
            return Err(wrong(
                format!(
                    "particle {} has no finite reference position",
                    own.number(n)
                ),
                "correct the reference positions, or take the first frame: --reference first",
            ));
        }
        own.spacing = spacing(&reference, dimension);
        if jump > JUMP_SPACINGS * own.spacing {
            return Err(wrong(
                format!(
                    "the file has no numbers of particles, and half of the rows move by more than {} spacings from a frame to the next: the rows are not in the same order in all frames",
                    told((jump / own.spacing).floor())
                ),
                "write the number of each particle (id in LAMMPS), or sort the rows (dump_modify sort id)",
            ));
        }
        let cells = first.cells.as_ref().filter(|_| has_elements);
        let cells = cells.map(|cells| elements(cells, dimension));
        let cells = cells.filter(|cells| !cells.is_empty());
        own.elements = cells.as_ref().map_or(0, Vec::len);
        let largest = reference
            .iter()
            .flatten()
            .fold(0.0_f64, |most, x| most.max(x.abs()));
        // The last digit of the largest position.
        let rounding = match own.digits {
            Some(digits) if largest > 0.0 => {
                10.0_f64.powf(largest.log10().floor() + 1.0 - f64::from(digits))
            }
            _ => 0.0,
        };
        if let Some(region) = &source.region {
            region.check("--region", &reference, dimension)?;
        }
        let motion = Motion {
            first: &first,
            last: &last,
            reference: &reference,
            rounding,
            dimension,
        };
        let held = own.held(&source.held, &motion)?;
        own.held = held.iter().filter(|is| **is).count();
        // Volumes of the first frame belong to its positions.
        let volumes = first.volume.filter(|_| is_first);
        let volumes = volumes.filter(|all| all.iter().all(|volume| *volume > 0.0));
        let run = Run {
            region: source.region.clone(),
            reference,
            volumes,
            held,
            cells,
            rounding,
        };
        Ok((own, run, series))
    }

    fn of(recognized: &Recognized) -> Self {
        let (used, unused): (Vec<_>, Vec<_>) = recognized
            .columns
            .iter()
            .partition(|column| column.quantity.is_some());
        let mut columns: Vec<(Quantity, Vec<&str>)> = Vec::new();
        for column in used {
            let Some(quantity) = column.quantity else {
                continue;
            };
            match columns.iter_mut().find(|(own, _)| *own == quantity) {
                Some((_, names)) => names.push(&column.name),
                None => columns.push((quantity, vec![&column.name])),
            }
        }
        let columns = columns.into_iter();
        Self {
            files: recognized.files.len(),
            format: recognized.format.to_string(),
            columns: columns
                .map(|(quantity, names)| format!("{quantity}={}", names.join(",")))
                .collect(),
            unused: unused.iter().map(|column| column.name.clone()).collect(),
            digits: recognized.digits,
            notes: [&recognized.ignored[..], &recognized.assumed[..]].concat(),
            ..Self::default()
        }
    }

    /// Number of a particle in the file; `None` if the file has no numbers.
    pub(super) fn particle(&self, row: usize) -> Option<u64> {
        self.identity.as_ref()?.get(row).copied()
    }

    /// Number of a particle in the file, otherwise its row.
    fn number(&self, row: usize) -> u64 {
        self.particle(row).unwrap_or(row as u64)
    }

    /// Initializes the particles from the first frame.
    fn begin(&mut self, frame: &Read) -> Result<(), ScreenError> {
        if frame.is_empty() {
            return Err(no_particles(format!("{}: the frame", frame.source)));
        }
        if let Some(fault) = broken(frame) {
            return Err(wrong(
                fault,
                "the first frame must be complete and valid; choose frames with --frames FIRST:END",
            ));
        }
        if let Some(id) = frame.doubled().first() {
            return Err(wrong(
                twice(frame, *id),
                "write each particle once in a frame, with a unique number",
            ));
        }
        self.identity.clone_from(&frame.identity);
        self.particles = frame.len();
        Ok(())
    }

    /// Reference positions, and whether they are the positions of the first frame.
    fn reference(
        &mut self,
        source: &Source,
        first: &Read,
    ) -> Result<(Vec<[f64; 3]>, bool), ScreenError> {
        let path = match &source.reference {
            Reference::File(path) => path,
            Reference::First => return Ok((first.position.clone(), true)),
            Reference::Recorded => {
                return Ok(match first.reference.clone() {
                    Some(reference) => (reference, false),
                    None => {
                        if self.times[0] != 0.0 {
                            self.notes.push(format!(
                                "the files have no reference positions: the first frame, at t = {}, is taken as undeformed; --reference names another file",
                                told(self.times[0])
                            ));
                        }
                        (first.position.clone(), true)
                    }
                });
            }
        };
        let mut other = Series::open(std::slice::from_ref(path), &source.reading)?;
        let mut frame = other.frame(0)?;
        match self.ordered(&mut frame).or_else(|| broken(&frame)) {
            None => Ok((frame.position, false)),
            Some(fault) => Err(wrong(
                fault,
                "the file of --reference has the particles of the first frame, with the same numbers",
            )),
        }
    }

    /// Frames of the run, in the particle order of the first frame.
    pub fn frames<'s>(
        &'s self,
        series: &'s mut Series,
        dimension: usize,
    ) -> impl Iterator<Item = Result<Frame, ScreenError>> + 's {
        series.rewind();
        let mut unwrapped = Unwrapped::new(self.is_relative);
        let all = series.by_ref().take(self.read).enumerate();
        let all = all.filter(|(number, _)| self.jumped.binary_search(number).is_err());
        all.map(move |(_, frame)| {
            let mut frame = frame?;
            if let Some(fault) = self.ordered(&mut frame) {
                return Err(wrong(fault, "the file was changed while it was read"));
            }
            unwrapped.take(&mut frame, dimension);
            unwrapped.keep(&frame);
            let time = time_of(&frame, false)?;
            let positions = frame.position.iter();
            let x = positions.map(|x| flat(x, dimension)).collect();
            let (gradient, stress, stress_given) = match frame.cells.take() {
                Some(cells) if self.elements > 0 => {
                    (cells.gradient, cells.stress, cells.stress_given)
                }
                _ => (frame.gradient, frame.stress, frame.stress_given),
            };
            Ok(Frame {
                time,
                x,
                velocity: frame.velocity,
                gradient,
                stress,
                stress_given,
            })
        })
    }

    fn check_wrapping(&mut self, first: &Read, dimension: usize) {
        let is_periodic =
            |bounds: &onset_frames::Bounds| bounds.periodic[..dimension].contains(&true);
        if first.bounds.as_ref().is_some_and(is_periodic) {
            self.notes.push("the box is periodic and positions may be wrapped: neighbors across its faces are not known".to_owned());
        }
    }

    /// Sorts the particles in the order of the first frame; returns the reason if this is impossible.
    fn ordered(&self, frame: &mut Read) -> Option<String> {
        let place = frame.source.clone();
        if let Some(identity) = &self.identity {
            let order = frame.in_order_of(identity);
            if let Some(id) = order.missing.first() {
                let missing = counted(order.missing.len(), "particle");
                return Some(format!(
                    "{place}: {missing} of the first frame missing, for example {id}"
                ));
            }
            if let Some(id) = order.doubled.first() {
                return Some(twice(frame, *id));
            }
        }
        (frame.len() != self.particles).then(|| {
            let found = counted(frame.len(), "particle");
            format!("{place}: {found} instead of {}", self.particles)
        })
    }

    fn held(&mut self, held: &[Held], motion: &Motion<'_>) -> Result<Vec<bool>, ScreenError> {
        if held.is_empty() {
            return Ok(self.guessed(motion));
        }
        if held.contains(&Held::No) {
            return match held.len() {
                1 => Ok(vec![false; motion.reference.len()]),
                _ => Err(wrong(
                    "--held none contradicts the other values of --held",
                    "omit --held none, or the others",
                )),
            };
        }
        let (mut all, mut by) = (vec![false; motion.reference.len()], Vec::new());
        for own in held {
            let found: Vec<bool> = match own {
                Held::No => continue,
                Held::Kind(kind) => {
                    by.push(format!("type {kind}"));
                    let kinds = motion.kinds(*kind)?;
                    kinds.iter().map(|own| own == kind).collect()
                }
                Held::Box(region) => {
                    region.check("--held", motion.reference, motion.dimension)?;
                    by.push(format!("the box {region}"));
                    let all = motion.reference.iter();
                    all.map(|x| region.contains(x)).collect()
                }
            };
            let both = all.iter_mut().zip(found);
            both.for_each(|(all, own)| *all |= own);
        }
        self.held_by = by.join(", ");
        Ok(all)
    }

    /// Particles marked in the file, otherwise kinds of the minority that move rigidly, otherwise faces that move rigidly.
    fn guessed(&mut self, motion: &Motion<'_>) -> Vec<bool> {
        if let Some(held) = &motion.first.held {
            self.held_by = "the column of the file".to_owned();
            return held.clone();
        }
        let count = motion.reference.len();
        let mut held = vec![false; count];
        let kinds = motion.first.kind.as_deref().unwrap_or_default();
        let mut all = kinds.to_vec();
        all.sort_unstable();
        all.dedup();
        for kind in all {
            let own: Vec<usize> = (0..count).filter(|n| kinds[*n] == kind).collect();
            if 2 * own.len() < count && motion.is_rigid_kind(&own, self.spacing) {
                self.held_by = format!("type {kind}, which moves rigidly");
                own.iter().for_each(|n| held[*n] = true);
            }
        }
        if held.contains(&true) {
            return held;
        }
        let (held, faces) = motion.rigid_faces(self.spacing);
        if !faces.is_empty() {
            self.held_by = format!("faces that move rigidly: {}", faces.join(", "));
        }
        held
    }
}

/// Motion of the particles from the first to the last frame.
struct Motion<'f> {
    first: &'f Read,
    last: &'f Read,
    reference: &'f [[f64; 3]],
    /// Rounding of positions in the file; length.
    rounding: f64,
    dimension: usize,
}

impl Motion<'_> {
    /// Kinds of the particles in the file, among them `kind`.
    fn kinds(&self, kind: i64) -> Result<&[i64], ScreenError> {
        let Some(kinds) = &self.first.kind else {
            return Err(wrong(
                "the file has no kinds of particles",
                "give the held particles by a box: --held LOW1,LOW2:HIGH1,HIGH2",
            ));
        };
        if kinds.contains(&kind) {
            return Ok(kinds);
        }
        let mut all = kinds.clone();
        all.sort_unstable();
        all.dedup();
        let all: Vec<String> = all.iter().take(20).map(i64::to_string).collect();
        Err(wrong(
            format!("no particle has the type {kind}"),
            format!("the types are {}", all.join(", ")),
        ))
    }

    /// Rigid motion of some particles; `None` if one of them is farther from it than a tolerance.
    fn rigid(&self, particles: &[usize], tolerance: f64) -> Option<RigidMotion> {
        let (from, to) = (&self.first.position, &self.last.position);
        let motion = RigidMotion::fitted(particles, from, to, self.dimension)?;
        let is_of = |n: &usize| motion.distance(&from[*n], &to[*n]) <= tolerance;
        particles.iter().all(is_of).then_some(motion)
    }

    /// Returns true if the particles of a kind move as at most [`GRIPS`] rigid bodies, each of neighbors or with one displacement.
    fn is_rigid_kind(&self, own: &[usize], spacing: f64) -> bool {
        // Rounding in the file may split one displacement into several nearly equal ones.
        let tolerance = (RIGID_KIND * spacing).max(2.0 * self.rounding);
        let moved = |n: usize| -> [i64; 3] {
            let (from, to) = (&self.first.position[n], &self.last.position[n]);
            std::array::from_fn(|i| ((to[i] - from[i]) / tolerance).round() as i64)
        };
        let mut displacements: Vec<[i64; 3]> = own.iter().map(|n| moved(*n)).collect();
        displacements.sort_unstable();
        displacements.dedup_by(|a, b| a.iter().zip(b.iter()).all(|(a, b)| a.abs_diff(*b) <= 1));
        let is_few = |count: usize| count <= GRIPS && own.len() > 2 * count;
        if is_few(displacements.len()) {
            return true;
        }
        let places: Vec<[f64; 3]> = own.iter().map(|n| self.reference[*n]).collect();
        let grips = connected(&places, self.dimension, spacing);
        let of_own = |grip: &Vec<usize>| grip.iter().map(|n| own[*n]).collect::<Vec<_>>();
        is_few(grips.len())
            && grips
                .iter()
                .all(|grip| self.rigid(&of_own(grip), tolerance).is_some())
    }

    /// Particles of the outermost faces along an axis that move rigidly, with all other particles that have this motion, and names of the faces.
    fn rigid_faces(&self, spacing: f64) -> (Vec<bool>, Vec<String>) {
        let count = self.reference.len();
        let mut held = vec![false; count];
        let mut faces = Vec::new();
        let tolerance = (RIGID * spacing).max(2.0 * self.rounding);
        for axis in 0..3 {
            for side in [-1.0, 1.0] {
                let height = |x: &[f64; 3]| side * x[axis];
                let all = self.reference.iter().map(height);
                let top = all.fold(f64::NEG_INFINITY, f64::max);
                let is_outer = |n: &usize| top - height(&self.reference[*n]) < 0.25 * spacing;
                let outer: Vec<usize> = (0..count).filter(is_outer).collect();
                if !(LEAST_FACE..count / 2).contains(&outer.len()) {
                    continue;
                }
                let Some(motion) = self.rigid(&outer, tolerance) else {
                    continue;
                };
                let both = self.first.position.iter().zip(&self.last.position);
                for (held, (from, to)) in held.iter_mut().zip(both) {
                    *held |= motion.distance(from, to) <= tolerance;
                }
                let sign = if side < 0.0 { "-" } else { "+" };
                faces.push(format!("{sign}{}", axis + 1));
            }
        }
        // A body that moves as a whole has no grips.
        if 2 * held.iter().filter(|is| **is).count() >= count {
            return (vec![false; count], Vec::new());
        }
        (held, faces)
    }
}

/// Groups of particles that are connected through neighbors, by their rows.
fn connected(x: &[[f64; 3]], dimension: usize, spacing: f64) -> Vec<Vec<usize>> {
    let radius = CONNECTED_SPACINGS * spacing;
    let near = super::neighborhoods::within(x, dimension, radius);
    let mut is_found = vec![false; x.len()];
    let mut groups = Vec::new();
    for start in 0..x.len() {
        if is_found[start] {
            continue;
        }
        is_found[start] = true;
        let (mut group, mut next) = (vec![start], 0);
        while let Some(n) = group.get(next) {
            for other in near[*n].clone() {
                if !std::mem::replace(&mut is_found[other], true) {
                    group.push(other);
                }
            }
            next += 1;
        }
        groups.push(group);
    }
    groups
}

/// Error for a frame or a run without particles.
pub(super) fn no_particles(of: impl std::fmt::Display) -> ScreenError {
    wrong(
        format!("{of} has no particles"),
        "choose frames with particles; the first frame defines the particles of the run",
    )
}

/// Time of a frame. `has_step`: the user has given the time step of the code.
fn time_of(frame: &Read, has_step: bool) -> Result<f64, ScreenError> {
    let others =
        "a column or array (--columns time=NAME), or for VTK a .pvd file or a field TimeValue";
    match (frame.time, has_step) {
        (Some(time), _) if time.is_finite() => Ok(time),
        (Some(time), _) => Err(wrong(
            format!("{}: the time of the frame is {time}", frame.source),
            "correct the times in the file, or choose frames with --frames FIRST:END",
        )),
        (None, true) => Err(wrong(
            format!(
                "{}: the frame has neither a time nor the number of a step",
                frame.source
            ),
            format!("give {others}"),
        )),
        (None, false) => Err(wrong(
            format!("{}: the frame has no time", frame.source),
            format!(
                "give the time step of the code (--time-step) for files that number their steps, {others}"
            ),
        )),
    }
}

/// Reason why a frame is invalid, with its place.
fn broken(frame: &Read) -> Option<String> {
    let number = |row: usize| {
        let identity = frame.identity.as_ref();
        identity.map_or(row as u64, |all| all[row])
    };
    let fault = fault(&frame.position, number)?;
    Some(format!("{}: {fault}", frame.source))
}

fn records(frame: &Read, time: f64) -> Records<'_> {
    Records {
        time,
        x: &frame.position,
        velocity: frame.velocity.as_deref(),
    }
}

/// Positions that are wrapped into a periodic box, unwrapped from frame to frame.
struct Unwrapped {
    /// Whether the first frame is unwrapped relative to the reference positions in it.
    is_relative: bool,
    /// Unwrapped positions of the last sound frame; empty before the first frame, and without a periodic box.
    last: Vec<[f64; 3]>,
    has_crossed: bool,
}

impl Unwrapped {
    fn new(is_relative: bool) -> Self {
        Self {
            is_relative,
            last: Vec::new(),
            has_crossed: false,
        }
    }

    /// Moves particles by vectors of the box, so that no particle moves by more than half of the box from one frame to the next.
    fn take(&mut self, frame: &mut Read, dimension: usize) {
        let Some(bounds) = frame.bounds.filter(|_| frame.may_be_wrapped) else {
            return;
        };
        let is_first = self.last.is_empty();
        let reference = frame.reference.as_ref().filter(|_| self.is_relative);
        let before = match (is_first, reference) {
            (false, _) => &self.last,
            (true, Some(reference)) => reference,
            (true, None) => {
                self.last.clone_from(&frame.position);
                return;
            }
        };
        if before.len() == frame.position.len() {
            for (x, before) in frame.position.iter_mut().zip(before) {
                // A tilted box shifts the axes before.
                for axis in (0..dimension).rev().filter(|axis| bounds.periodic[*axis]) {
                    let mut scaled = [0.0; 3];
                    scaled[axis] = 1.0;
                    let vector = bounds.vector(scaled);
                    let times = ((x[axis] - before[axis]) / vector[axis]).round();
                    if times != 0.0 && times.is_finite() {
                        self.has_crossed = true;
                        (0..3).for_each(|i| x[i] -= times * vector[i]);
                    }
                }
            }
        }
        if is_first {
            self.keep(frame);
        }
    }

    /// Keeps the positions of a sound frame.
    fn keep(&mut self, frame: &Read) {
        if !self.last.is_empty() || (frame.may_be_wrapped && frame.bounds.is_some()) {
            self.last.clone_from(&frame.position);
        }
    }
}

/// Nodes of the elements. Points and lines are not elements.
fn elements(cells: &Cells, dimension: usize) -> Vec<Vec<usize>> {
    // In the numbering of VTK: points, lines and polylines, of any order.
    let is_thin = |shape: u8| matches!(shape, 1..=4 | 21 | 35 | 68);
    let all = (0..cells.len()).filter(|n| dimension == 1 || !is_thin(cells.shapes[*n]));
    all.map(|n| cells.points(n).to_vec())
        .filter(|points| points.len() > dimension)
        .collect()
}

/// Median distance of nearest neighbors; length.
pub(super) fn spacing(reference: &[[f64; 3]], dimension: usize) -> f64 {
    let low: [f64; 3] =
        std::array::from_fn(|i| reference.iter().map(|x| x[i]).fold(f64::INFINITY, f64::min));
    let high: [f64; 3] = std::array::from_fn(|i| {
        reference
            .iter()
            .map(|x| x[i])
            .fold(f64::NEG_INFINITY, f64::max)
    });
    let volume: f64 = (0..dimension)
        .map(|i| (high[i] - low[i]).max(f64::MIN_POSITIVE))
        .product();
    let mut radius = 2.0 * (volume / reference.len() as f64).powf(1.0 / dimension as f64);
    // Particles of a thin or hollow body are closer to each other than on average in their box.
    loop {
        let near = super::neighborhoods::Neighborhoods::new(reference, dimension, radius);
        let mean = (0..near.len()).map(|n| near.count(n)).sum::<usize>() as f64 / near.len() as f64;
        if mean <= 200.0 || radius < 1e-12 {
            let distance = |a: &[f64; 3], b: &[f64; 3]| {
                (0..dimension)
                    .map(|i| (a[i] - b[i]).powi(2))
                    .sum::<f64>()
                    .sqrt()
            };
            let mut nearest: Vec<f64> = (0..near.len())
                .filter(|n| near.count(*n) > 0)
                .map(|n| {
                    let all = near
                        .numbers(n)
                        .map(|other| distance(&reference[n], &reference[other]));
                    all.fold(f64::INFINITY, f64::min)
                })
                .collect();
            nearest.sort_by(f64::total_cmp);
            return nearest.get(nearest.len() / 2).copied().unwrap_or(radius);
        }
        radius *= 0.5;
    }
}

/// Returns true if the distances of nearest neighbors agree with a regular lattice.
pub(super) fn is_spaced(found: f64, spacing: f64) -> bool {
    (found / spacing - 1.0).abs() < REGULAR
}
