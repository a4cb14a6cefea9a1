//! Runs read from the output files of a code.

use super::{Frame, Run, ScreenError};
use crate::number::{counted, told};
use onset_frames::{Cells, Frame as Read, Quantity, Reading, Recognized, Series};
use serde::Serialize;
use std::path::PathBuf;
use std::str::FromStr;

/// Largest difference between displacements of held particles that count as equal, as a fraction of a spacing.
const RIGID: f64 = 1e-5;
/// Largest number of distinct displacements of the held particles of one kind: two or more grips.
const GRIPS: usize = 6;
/// Smallest median motion between frames, in spacings and without the mean motion, that indicates a changed order of the rows.
const JUMP_SPACINGS: f64 = 3.0;
/// Smallest median motion of sorted coordinates, as a fraction of the median motion of the rows, of particles that have moved themselves.
const OWN_MOTION_SHARE: f64 = 0.25;
/// Smallest jump of a particle against its neighbors between two frames that can be a damaged record; spacings.
const DAMAGE_SPACINGS: f64 = 3.0;
/// Largest motion of neighbors against each other between two frames, in spacings, at which no force has thrown a particle out of them: they would recoil.
const QUIET_SPACINGS: f64 = 0.5;
/// Largest distance of neighbors whose motions are compared; spacings.
const NEIGHBOR_SPACINGS: f64 = 1.6;
/// Largest fraction of the particles of a frame whose records count as damaged.
const LARGEST_DAMAGE: f64 = 0.25;
/// Smallest fraction of a jump that the velocities in the file explain.
const EXPLAINED_SHARE: f64 = 0.5;
/// Smallest number of particles in a face that moves rigidly.
const LEAST_FACE: usize = 3;
/// Largest distance from a lattice position, in spacings, at which reference positions are regular.
const REGULAR: f64 = 1e-3;

/// Largest admissible coordinate; fits use its square.
const LARGEST_COORDINATE: f64 = 1e100;

/// Box of the reference configuration.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    low: Vec<f64>,
    high: Vec<f64>,
}

impl Region {
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
            numbers.collect()
        };
        let (low, high) = text.split_once(':').ok_or_else(wrong)?;
        let (low, high) = corner(low).zip(corner(high)).ok_or_else(wrong)?;
        let is_box = low.len() == high.len()
            && low.len() <= 3
            && low.iter().zip(&high).all(|(low, high)| low <= high);
        is_box.then_some(Self { low, high }).ok_or_else(wrong)
    }
}

/// Particles whose motion is prescribed.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Held {
    /// Particles marked in the file; otherwise a minority kind, or faces that move rigidly.
    #[default]
    Guessed,
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
    /// Particles with prescribed motion.
    pub held: Held,
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
    /// Number of later frames that are skipped, because a frame lacks particles or has infinite positions.
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
}

/// Particles whose records jump from one frame to the next, while the particles around them stay together.
struct Damage {
    /// Row of the first of these particles that has a neighbor outside of them.
    row: usize,
    /// Number of these particles.
    count: usize,
    /// Jump of `row` against its neighbors; spacings.
    jump: f64,
}

/// Neighbors in the first frame, whose motions are compared in later frames.
struct Contacts {
    near: super::neighborhoods::Neighborhoods,
    spacing: f64,
}

impl Contacts {
    fn new(first: &Read, dimension: usize) -> Self {
        let x: Vec<[f64; 3]> = first.position.iter().map(|x| flat(x, dimension)).collect();
        let spacing = spacing(&x, dimension);
        // Without a spacing there are no neighbors.
        let (x, radius) = match spacing.is_finite() && spacing > 0.0 {
            true => (&x[..], NEIGHBOR_SPACINGS * spacing),
            false => (&x[..0], 1.0),
        };
        Self {
            near: super::neighborhoods::Neighborhoods::new(x, dimension, radius),
            spacing,
        }
    }

    /// Damaged records of a few particles in a frame; `None` if all records are sound.
    ///
    /// Forces act between neighbors. A force that throws a particle out of the body throws its neighbors back, so that they move against each other. A
    /// jump by several spacings is damage if the neighbors stay together, and if velocities in the file do not explain it.
    fn damage(&self, from: &Read, to: &Read, interval: f64) -> Option<Damage> {
        let count = self.near.len();
        if from.len() != count || to.len() != count {
            return None;
        }
        let length = |x: [f64; 3]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        let moved = |n: usize| -> [f64; 3] {
            std::array::from_fn(|i| to.position[n][i] - from.position[n][i])
        };
        let apart = |a: usize, b: usize| {
            let (a, b) = (moved(a), moved(b));
            length(std::array::from_fn(|i| a[i] - b[i])) / self.spacing
        };
        let jumps = |a: usize, b: usize| apart(a, b) > DAMAGE_SPACINGS;
        if !(0..count).any(|n| self.near.numbers(n).any(|other| jumps(n, other))) {
            return None;
        }
        // Groups of particles that move together.
        let mut group = vec![usize::MAX; count];
        let mut sizes = Vec::new();
        for start in 0..count {
            if group[start] != usize::MAX {
                continue;
            }
            let own = sizes.len();
            group[start] = own;
            let (mut open, mut size) = (vec![start], 0);
            while let Some(n) = open.pop() {
                size += 1;
                for other in self.near.numbers(n) {
                    if group[other] == usize::MAX && !jumps(n, other) {
                        group[other] = own;
                        open.push(other);
                    }
                }
            }
            sizes.push(size);
        }
        // A group is cut off if it has neighbors in a larger group.
        let outer = |n: usize| {
            let (own, sizes, group) = (sizes[group[n]], &sizes, &group);
            let near = self.near.numbers(n);
            near.filter(move |other| sizes[group[*other]] > own)
        };
        let mut is_cut = vec![false; sizes.len()];
        for (n, own) in group.iter().enumerate() {
            is_cut[*own] |= outer(n).next().is_some();
        }
        let away: Vec<usize> = (0..count).filter(|n| is_cut[group[*n]]).collect();
        if away.len() as f64 > LARGEST_DAMAGE * count as f64 {
            return None;
        }
        let is_quiet = |n: usize| {
            let mut near = self.near.numbers(n);
            let is_together =
                |other: usize| group[other] != group[n] || apart(n, other) <= QUIET_SPACINGS;
            !is_cut[group[n]] && near.all(is_together)
        };
        let is_explained = |n: usize| {
            let speed = |frame: &Read| frame.velocity.as_ref().map_or(0.0, |all| length(all[n]));
            speed(from).max(speed(to)) * interval > EXPLAINED_SHARE * length(moved(n))
        };
        let is_damaged = |n: &usize| !is_explained(*n) && outer(*n).all(is_quiet);
        if !away.iter().all(is_damaged) {
            return None;
        }
        let row = away.iter().copied().find(|n| outer(*n).next().is_some())?;
        let jump = outer(row).map(|other| apart(row, other));
        Some(Damage {
            row,
            count: away.len(),
            jump: jump.fold(f64::INFINITY, f64::min),
        })
    }
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

/// Median motion of the rows from one frame to the next, without the mean motion; 0 if the particles have moved themselves, as in a run that blew up.
///
/// Rows in another order leave the sorted coordinates unchanged, apart from the motion of the particles.
fn median_jump(from: &Read, to: &Read) -> f64 {
    let count = from.len().min(to.len());
    let mean = |axis: usize| {
        let pairs = from.position.iter().zip(&to.position);
        pairs.map(|(a, b)| b[axis] - a[axis]).sum::<f64>() / count.max(1) as f64
    };
    let mean = [mean(0), mean(1), mean(2)];
    let median = |mut sizes: Vec<f64>| {
        sizes.sort_by(f64::total_cmp);
        sizes.get(sizes.len() / 2).copied().unwrap_or(0.0)
    };
    let distance = |a: &[f64; 3], b: &[f64; 3]| {
        let parts = (0..3).map(|i| (b[i] - a[i] - mean[i]).powi(2));
        parts.sum::<f64>().sqrt()
    };
    let pairs = from.position.iter().zip(&to.position);
    let jump = median(pairs.map(|(a, b)| distance(a, b)).collect());
    let sorted = |frame: &Read, axis: usize| {
        let mut all: Vec<f64> = frame.position.iter().map(|x| x[axis]).collect();
        all.sort_by(f64::total_cmp);
        all
    };
    let moved = |axis: usize| {
        let (from, to) = (sorted(from, axis), sorted(to, axis));
        let pairs = from.iter().zip(&to);
        median(pairs.map(|(a, b)| (b - a - mean[axis]).abs()).collect())
    };
    match (0..3).any(|axis| moved(axis) > OWN_MOTION_SHARE * jump) {
        true => 0.0,
        false => jump,
    }
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
                (own.times[0], time) = (now, now);
                first = Some(frame);
                (own.frames, own.read) = (1, 1);
                continue;
            };
            let written = frame.len();
            let fault = own.ordered(&mut frame).or_else(|| broken(&frame));
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
            let contacts = contacts.get_or_insert_with(|| Contacts::new(start, dimension));
            // Wrapped positions have a separate error.
            let is_wrapped = start.may_be_wrapped && wraps(start, &frame, dimension);
            let damage = contacts.damage(last.as_ref().unwrap_or(start), &frame, now - time);
            if let Some(damage) = damage.filter(|_| !is_wrapped) {
                own.jumped.push(number);
                jumped.get_or_insert_with(|| own.told_damage(&damage, [time, now]));
                continue;
            }
            own.interval = own.interval.max(now - time);
            time = now;
            own.frames += 1;
            if own.identity.is_none() {
                jump = jump.max(median_jump(last.as_ref().unwrap_or(start), &frame));
            }
            last = Some(frame);
        }
        // Bytes after the last frame can be damaged, too, and a damaged file can end the reading early.
        series.check_rest()?;
        if damaged.is_some() {
            let read = own.frames + own.jumped.len();
            own.skipped = series.times().len().saturating_sub(read);
        }
        own.times[1] = time;
        if let Some(jumped) = jumped {
            own.notes.push(match own.jumped.len() {
                1 => format!("{jumped}: the frame is skipped as damaged"),
                count => format!("{jumped}: {count} such frames are skipped as damaged"),
            });
        }
        let (Some(first), Some(last)) = (first, last) else {
            return Err(ScreenError::TooFewFrames {
                count: own.frames,
                why: damaged,
            });
        };
        if first.may_be_wrapped && wraps(&first, &last, dimension) {
            return Err(wrong(
                "particles jump from one side of the periodic box to the other",
                "write positions that are not wrapped (xu yu zu in LAMMPS)",
            ));
        }
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
        let held = own.held(&source.held, &first, &last, &reference)?;
        own.held = held.iter().filter(|is| **is).count();
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

    /// Clause about the first damaged records.
    fn told_damage(&self, damage: &Damage, times: [f64; 2]) -> String {
        let others = match damage.count - 1 {
            0 => String::new(),
            count => format!(", like {},", counted(count, "other")),
        };
        format!(
            "particle {}{others} moves {:.0} spacings between the frames t = {} and t = {} while its neighbors stay together",
            self.number(damage.row),
            damage.jump,
            told(times[0]),
            told(times[1])
        )
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
        let all = series.by_ref().take(self.read).enumerate();
        let all = all.filter(|(number, _)| self.jumped.binary_search(number).is_err());
        all.map(move |(_, frame)| {
            let mut frame = frame?;
            if let Some(fault) = self.ordered(&mut frame) {
                return Err(wrong(fault, "the file was changed while it was read"));
            }
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

    fn held(
        &mut self,
        held: &Held,
        first: &Read,
        last: &Read,
        reference: &[[f64; 3]],
    ) -> Result<Vec<bool>, ScreenError> {
        let count = reference.len();
        match held {
            Held::No => Ok(vec![false; count]),
            Held::Kind(kind) => {
                let Some(kinds) = &first.kind else {
                    return Err(wrong(
                        "the file has no kinds of particles",
                        "give the held particles by a box: --held LOW1,LOW2:HIGH1,HIGH2",
                    ));
                };
                if !kinds.contains(kind) {
                    let mut all = kinds.clone();
                    all.sort_unstable();
                    all.dedup();
                    let all: Vec<String> = all.iter().take(20).map(i64::to_string).collect();
                    return Err(wrong(
                        format!("no particle has the type {kind}"),
                        format!("the types are {}", all.join(", ")),
                    ));
                }
                self.held_by = format!("type {kind}");
                Ok(kinds.iter().map(|own| own == kind).collect())
            }
            Held::Box(region) => {
                self.held_by = "a box".to_owned();
                Ok(reference.iter().map(|x| region.contains(x)).collect())
            }
            Held::Guessed => {
                if let Some(held) = &first.held {
                    self.held_by = "the column of the file".to_owned();
                    return Ok(held.clone());
                }
                let Some(kinds) = &first.kind else {
                    return Ok(self.rigid_faces(first, last, reference));
                };
                let mut held = vec![false; count];
                let mut all = kinds.clone();
                all.sort_unstable();
                all.dedup();
                for kind in all {
                    let own: Vec<usize> = (0..count).filter(|n| kinds[*n] == kind).collect();
                    let mut moved: Vec<[i64; 3]> =
                        own.iter().map(|n| self.moved(first, last, *n)).collect();
                    moved.sort_unstable();
                    // Rounding in the file may split one displacement into several nearly equal ones.
                    moved
                        .dedup_by(|a, b| a.iter().zip(b.iter()).all(|(a, b)| a.abs_diff(*b) <= 50));
                    if 2 * own.len() < count && moved.len() <= GRIPS && own.len() > 2 * moved.len()
                    {
                        self.held_by = format!("type {kind}, which moves rigidly");
                        own.iter().for_each(|n| held[*n] = true);
                    }
                }
                match held.contains(&true) {
                    true => Ok(held),
                    false => Ok(self.rigid_faces(first, last, reference)),
                }
            }
        }
    }

    /// Displacement of a particle in the run, rounded to a small fraction of the spacing.
    fn moved(&self, first: &Read, last: &Read, n: usize) -> [i64; 3] {
        let (from, to) = (&first.position[n], &last.position[n]);
        let unit = RIGID * self.spacing;
        std::array::from_fn(|i| ((to[i] - from[i]) / unit).round() as i64)
    }

    /// Particles of the outermost faces along an axis that share one displacement, with all other particles that have it.
    fn rigid_faces(&mut self, first: &Read, last: &Read, reference: &[[f64; 3]]) -> Vec<bool> {
        let mut held = vec![false; reference.len()];
        let mut faces = Vec::new();
        for axis in 0..3 {
            for side in [-1.0, 1.0] {
                let height = |x: &[f64; 3]| side * x[axis];
                let top = reference
                    .iter()
                    .map(height)
                    .fold(f64::NEG_INFINITY, f64::max);
                let is_outer = |n: &usize| top - height(&reference[*n]) < 0.25 * self.spacing;
                let outer: Vec<usize> = (0..reference.len()).filter(is_outer).collect();
                let Some(own) = outer.first().map(|n| self.moved(first, last, *n)) else {
                    continue;
                };
                let is_rigid = |n: usize| self.moved(first, last, n) == own;
                let is_face = (LEAST_FACE..reference.len() / 2).contains(&outer.len());
                if is_face && outer.iter().all(|n| is_rigid(*n)) {
                    let all = (0..reference.len()).filter(|n| is_rigid(*n));
                    all.for_each(|n| held[n] = true);
                    faces.push(format!(
                        "{}{}",
                        if side < 0.0 { "-" } else { "+" },
                        axis + 1
                    ));
                }
            }
        }
        let count = held.iter().filter(|is| **is).count();
        if faces.is_empty() || 2 * count >= held.len() {
            return vec![false; held.len()];
        }
        self.held_by = format!("faces that move rigidly: {}", faces.join(", "));
        held
    }
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

fn is_finite(x: &[f64; 3]) -> bool {
    x.iter().all(|x| x.abs() < LARGEST_COORDINATE)
}

/// Position of more than half of the particles; `None` if there is no such position.
fn shared_position(x: &[[f64; 3]]) -> Option<[f64; 3]> {
    // Majority vote: only the last candidate can have more than half of the votes.
    let mut candidate = *x.first()?;
    let mut votes = 0_usize;
    for own in x {
        match (*own == candidate, votes) {
            (true, _) => votes += 1,
            (false, 0) => (candidate, votes) = (*own, 1),
            (false, _) => votes -= 1,
        }
    }
    let count = x.iter().filter(|own| **own == candidate).count();
    (count > 1 && 2 * count > x.len()).then_some(candidate)
}

/// Reason why a frame is invalid: coordinates that are not finite, or so large that their squares are not, or the same for most particles.
fn broken(frame: &Read) -> Option<String> {
    let Some(n) = frame.position.iter().position(|x| !is_finite(x)) else {
        let [x, y, z] = shared_position(&frame.position)?.map(told);
        return Some(format!(
            "{}: more than half of the particles are at the same position, ({x}, {y}, {z})",
            frame.source
        ));
    };
    let number = frame.identity.as_ref().map_or(n as u64, |all| all[n]);
    Some(format!(
        "{}: particle {number} has no finite position below {LARGEST_COORDINATE:e}",
        frame.source
    ))
}

/// Returns true if a particle moves by more than half of a periodic box.
fn wraps(first: &Read, last: &Read, dimension: usize) -> bool {
    let Some(bounds) = &first.bounds else {
        return false;
    };
    let jumps = |a: &[f64; 3], b: &[f64; 3]| {
        (0..dimension).any(|i| {
            let side = bounds.high[i] - bounds.low[i];
            bounds.periodic[i] && (a[i] - b[i]).abs() > 0.5 * side
        })
    };
    let mut both = first.position.iter().zip(&last.position);
    both.any(|(a, b)| jumps(a, b))
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
