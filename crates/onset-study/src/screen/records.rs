//! Tests of the records of successive frames: positions that are not finite, the same for most particles, or jump.

use super::neighborhoods::Neighborhoods;
use super::{Frame, ScreenError};
use crate::number::{counted, told};

/// Smallest median motion between frames, in spacings and without the mean motion, that indicates a changed order of the rows.
pub(super) const JUMP_SPACINGS: f64 = 3.0;
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
/// Largest fraction of the particles of a frame whose records count as damaged, after a frame with damaged records.
const LARGEST_LATER_DAMAGE: f64 = 0.5;
/// Smallest fraction of a jump that the velocities in the file explain.
const EXPLAINED_SHARE: f64 = 0.5;
/// Largest admissible coordinate; fits use its square.
const LARGEST_COORDINATE: f64 = 1e100;

/// Particles whose records jump from one frame to the next, while the particles around them stay together.
pub(super) struct Damage {
    /// Row of the first of these particles that has a neighbor outside of them.
    pub(super) row: usize,
    /// Number of these particles.
    count: usize,
    /// Jump of `row` against its neighbors; spacings.
    jump: f64,
    /// Times of the frames before and after the jump.
    times: [f64; 2],
}

/// Neighbors in the first frame, whose motions are compared in later frames.
pub(super) struct Contacts {
    near: Neighborhoods,
    spacing: f64,
}

/// Positions and velocities of a frame.
#[derive(Clone, Copy)]
pub(super) struct Records<'f> {
    pub(super) time: f64,
    pub(super) x: &'f [[f64; 3]],
    pub(super) velocity: Option<&'f [[f64; 3]]>,
}

impl Contacts {
    pub(super) fn new(x: &[[f64; 3]], dimension: usize) -> Self {
        let spacing = super::input::spacing(x, dimension);
        // Without a spacing there are no neighbors.
        let (x, radius) = match spacing.is_finite() && spacing > 0.0 {
            true => (x, NEIGHBOR_SPACINGS * spacing),
            false => (&x[..0], 1.0),
        };
        Self {
            near: Neighborhoods::new(x, dimension, radius),
            spacing,
        }
    }

    /// Damaged records of a few particles in a frame; `None` if all records are sound.
    ///
    /// Forces act between neighbors. A force that throws a particle out of the body throws its neighbors back, so that they move against each other. A
    /// jump by several spacings is damage if the neighbors stay together, and if velocities in the file do not explain it.
    pub(super) fn damage(
        &self,
        from: Records<'_>,
        to: Records<'_>,
        is_after_damage: bool,
    ) -> Option<Damage> {
        let count = self.near.len();
        if from.x.len() != count || to.x.len() != count {
            return None;
        }
        let length = |x: [f64; 3]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        let moved = |n: usize| -> [f64; 3] { std::array::from_fn(|i| to.x[n][i] - from.x[n][i]) };
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
        // A group is cut off if it has neighbors in a larger group, and moves otherwise than the largest group.
        let outer = |n: usize| {
            let (own, sizes, group) = (sizes[group[n]], &sizes, &group);
            let near = self.near.numbers(n);
            near.filter(move |other| sizes[group[*other]] > own)
        };
        let mut means = vec![[0.0; 3]; sizes.len()];
        for (n, own) in group.iter().enumerate() {
            for (sum, x) in means[*own].iter_mut().zip(moved(n)) {
                *sum += x / sizes[*own] as f64;
            }
        }
        let most = (0..sizes.len()).max_by_key(|own| sizes[*own]).unwrap_or(0);
        let with_most = |own: usize| {
            let apart = std::array::from_fn(|i| means[own][i] - means[most][i]);
            length(apart) <= DAMAGE_SPACINGS * self.spacing
        };
        let mut is_cut = vec![false; sizes.len()];
        for (n, own) in group.iter().enumerate() {
            is_cut[*own] |= outer(n).next().is_some() && !with_most(*own);
        }
        let away: Vec<usize> = (0..count).filter(|n| is_cut[group[*n]]).collect();
        // More particles can follow a group whose jump was damage, such as particles that are wrapped into a box.
        let largest = if is_after_damage {
            LARGEST_LATER_DAMAGE
        } else {
            LARGEST_DAMAGE
        };
        if away.len() as f64 > largest * count as f64 {
            return None;
        }
        let is_quiet = |n: usize| {
            let mut near = self.near.numbers(n);
            let is_together =
                |other: usize| group[other] != group[n] || apart(n, other) <= QUIET_SPACINGS;
            !is_cut[group[n]] && near.all(is_together)
        };
        let is_explained = |n: usize| {
            let speed = |frame: Records<'_>| frame.velocity.map_or(0.0, |all| length(all[n]));
            speed(from).max(speed(to)) * (to.time - from.time) > EXPLAINED_SHARE * length(moved(n))
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
            times: [from.time, to.time],
        })
    }
}

impl Damage {
    /// Clause about the damaged records; `number` is the number of the particle of [`Damage::row`].
    pub(super) fn told(&self, number: u64) -> String {
        let others = match self.count - 1 {
            0 => String::new(),
            count => format!(", like {},", counted(count, "other")),
        };
        format!(
            "particle {number}{others} moves {:.0} spacings between the frames t = {} and t = {} while its neighbors stay together",
            self.jump,
            told(self.times[0]),
            told(self.times[1])
        )
    }
}

/// Note on skipped frames with damaged records: the clause about the first of them, and their number.
pub(super) fn told_jumps(first: &str, count: usize) -> String {
    match count {
        1 => format!("{first}: the frame is skipped as damaged"),
        count => format!("{first}: {count} such frames are skipped as damaged"),
    }
}

/// Median motion of the rows from one frame to the next, without the mean motion; 0 if the particles have moved themselves, as in a run that blew up.
///
/// Rows in another order leave the sorted coordinates unchanged, apart from the motion of the particles.
pub(super) fn median_jump(from: &[[f64; 3]], to: &[[f64; 3]]) -> f64 {
    let count = from.len().min(to.len());
    let mean = |axis: usize| {
        let pairs = from.iter().zip(to);
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
    let pairs = from.iter().zip(to);
    let jump = median(pairs.map(|(a, b)| distance(a, b)).collect());
    let sorted = |frame: &[[f64; 3]], axis: usize| {
        let mut all: Vec<f64> = frame.iter().map(|x| x[axis]).collect();
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

pub(super) fn is_finite(x: &[f64; 3]) -> bool {
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

/// Reason why positions are invalid, as a clause: coordinates that are not finite, or so large that their squares are not, or the same for most particles.
/// `number` is the number of a row.
pub(super) fn fault(x: &[[f64; 3]], number: impl Fn(usize) -> u64) -> Option<String> {
    let Some(n) = x.iter().position(|x| !is_finite(x)) else {
        let [x, y, z] = shared_position(x)?.map(told);
        return Some(format!(
            "more than half of the particles are at the same position, ({x}, {y}, {z})"
        ));
    };
    Some(format!(
        "particle {} has no finite position below {LARGEST_COORDINATE:e}",
        number(n)
    ))
}

/// Frames of arrays. The frames end before a frame with invalid positions, and frames with damaged records are omitted.
pub(super) struct SoundFrames<'f> {
    frames: &'f mut dyn Iterator<Item = Result<Frame, ScreenError>>,
    dimension: usize,
    /// Whether frames are checked; frames of files have been checked when they were opened.
    is_checked: bool,
    contacts: Option<Contacts>,
    /// Last frame with sound records.
    last: Option<Frame>,
    jumped: Option<(String, usize)>,
    /// Whether the frame before had damaged records.
    is_after_damage: bool,
    fault: Option<String>,
}

fn records(frame: &Frame) -> Records<'_> {
    Records {
        time: frame.time,
        x: &frame.x,
        velocity: frame.velocity.as_deref(),
    }
}

impl<'f> SoundFrames<'f> {
    pub(super) fn new(
        frames: &'f mut dyn Iterator<Item = Result<Frame, ScreenError>>,
        dimension: usize,
        is_checked: bool,
    ) -> Self {
        Self {
            frames,
            dimension,
            is_checked,
            contacts: None,
            last: None,
            jumped: None,
            is_after_damage: false,
            fault: None,
        }
    }

    /// Reason for which the frames ended early; `None` if all were read.
    pub(super) fn fault(&self) -> Option<&str> {
        self.fault.as_deref()
    }

    /// Notes on omitted frames.
    pub(super) fn notes(&self) -> Vec<String> {
        let fault = self.fault.iter();
        let fault = fault.map(|fault| format!("{fault}: this and all later frames are skipped"));
        let jumped = self.jumped.iter();
        fault
            .chain(jumped.map(|(first, count)| told_jumps(first, *count)))
            .collect()
    }

    /// Returns true for a frame with sound records.
    fn is_sound(&mut self, frame: &Frame) -> bool {
        let Some(last) = &self.last else {
            self.contacts = Some(Contacts::new(&frame.x, self.dimension));
            return true;
        };
        let contacts = self.contacts.as_ref();
        let damage = contacts
            .and_then(|own| own.damage(records(last), records(frame), self.is_after_damage));
        self.is_after_damage = damage.is_some();
        let Some(damage) = damage else {
            return true;
        };
        let (_, count) = self
            .jumped
            .get_or_insert_with(|| (damage.told(damage.row as u64), 0));
        *count += 1;
        false
    }
}

impl Iterator for SoundFrames<'_> {
    type Item = Result<Frame, ScreenError>;

    fn next(&mut self) -> Option<Self::Item> {
        if !self.is_checked {
            return self.frames.next();
        }
        while self.fault.is_none() {
            let frame = match self.frames.next()? {
                Ok(frame) => frame,
                Err(error) => return Some(Err(error)),
            };
            if let Some(fault) = fault(&frame.x, |row| row as u64) {
                let what = format!("{fault}, at t = {}", told(frame.time));
                if self.last.is_none() {
                    return Some(Err(ScreenError::Run {
                        what,
                        hint: "the first frame must be complete and valid".to_owned(),
                    }));
                }
                self.fault = Some(what);
                break;
            }
            if self.is_sound(&frame) {
                self.last = Some(frame.clone());
                return Some(Ok(frame));
            }
        }
        None
    }
}
