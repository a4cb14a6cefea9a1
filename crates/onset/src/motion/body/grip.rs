//! Grips: groups of particles with prescribed motion.

use super::BodyError;
use super::vectors::{Field, put};
use crate::algebra::array_of;

/// Particles in a box with a prescribed velocity that rises smoothly from zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Grip {
    /// Lower corner of the box in the reference configuration; length.
    pub low: Vec<f64>,
    /// Upper corner of the box; length.
    pub high: Vec<f64>,
    /// Velocity at the end of the ramp; length/time.
    pub velocity: Vec<f64>,
    /// Duration of the ramp; time. Zero for the full velocity from the start.
    pub ramp: f64,
    /// Time at which the grip releases its particles, which keep their velocity. Zero for particles that only start with a velocity, infinity for a
    /// permanent grip.
    pub until: f64,
}

impl Default for Grip {
    fn default() -> Self {
        Self {
            low: Vec::new(),
            high: Vec::new(),
            velocity: Vec::new(),
            ramp: 0.0,
            until: f64::INFINITY,
        }
    }
}

impl Grip {
    /// Returns the fraction of the velocity at a time: `3 s^2 - 2 s^3` with `s = t / ramp` during the ramp, then one.
    ///
    /// ```
    /// use onset::motion::Grip;
    /// let grip = Grip { low: vec![0.0], high: vec![1.0], velocity: vec![2.0], ramp: 4.0, ..Grip::default() };
    /// assert_eq!([-1.0, 0.0, 2.0, 4.0, 9.0].map(|t| grip.share(t)), [0.0, 0.0, 0.5, 1.0, 1.0]);
    /// ```
    pub fn share(&self, time: f64) -> f64 {
        let s = match self.ramp > 0.0 {
            true => (time / self.ramp).clamp(0.0, 1.0),
            false => 1.0,
        };
        s * s * (3.0 - 2.0 * s)
    }

    /// Velocity of the grip at a time.
    pub(super) fn velocity_at<const D: usize>(&self, time: f64) -> [f64; D] {
        let share = self.share(time);
        array_of(|i| share * self.velocity.get(i).copied().unwrap_or(0.0))
    }

    /// Returns true if the grip holds its particles at a time.
    pub(super) fn is_closed(&self, time: f64) -> bool {
        time < self.until
    }

    /// Returns true if a reference position lies in the box or on its faces.
    pub(super) fn holds(&self, position: &[f64]) -> bool {
        let sides = position.iter().zip(self.low.iter().zip(&self.high));
        sides
            .into_iter()
            .all(|(x, (low, high))| low <= x && x <= high)
    }
}

/// Gripped particles with the numbers of their grips.
pub(super) fn held<const D: usize>(
    positions: &[[f64; D]],
    grips: &[Grip],
) -> Result<Vec<(u32, u32)>, BodyError> {
    let mut held: Vec<(u32, u32)> = Vec::new();
    for (number, position) in positions.iter().enumerate() {
        let mut own = (0..grips.len()).filter(|grip| grips[*grip].holds(position));
        let Some(first) = own.next() else {
            continue;
        };
        if let Some(second) = own.next() {
            return Err(BodyError::HeldTwice {
                particle: number,
                position: position.to_vec(),
                first: first + 1,
                second: second + 1,
            });
        }
        held.push((number as u32, first as u32));
    }
    for (grip, own) in grips.iter().enumerate() {
        if held.iter().all(|(_, of)| *of as usize != grip) {
            return Err(BodyError::EmptyGrip {
                grip: grip + 1,
                low: own.low.clone(),
                high: own.high.clone(),
            });
        }
    }
    Ok(held)
}

/// Sets a field to zero for the particles of permanent grips.
pub(super) fn hold<const D: usize>(field: &mut Field<D>, held: &[(u32, u32)], grips: &[Grip]) {
    for (particle, grip) in held {
        if grips[*grip as usize].until == f64::INFINITY {
            put(field, *particle as usize, &[0.0; D]);
        }
    }
}

/// Work of a grip on a particle in a step: impulse times mean velocity. The impulse changes the velocity due to the forces alone to the prescribed
/// velocity.
pub(super) fn work_of<const D: usize>(
    mass: f64,
    before: &[f64; D],
    free: &[f64; D],
    next: &[f64; D],
) -> f64 {
    (0..D)
        .map(|i| mass * (next[i] - free[i]) * 0.5 * (before[i] + next[i]))
        .sum()
}
