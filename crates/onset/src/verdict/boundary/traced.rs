//! What has been traced: which places are explained by a curve already.

use super::line::Sides;
use super::plane::{Point, cross, distance, distance_to_piece, minus, plus};

/// Bins along each edge of the window.
const BINS: usize = 64;

/// A chord of a curve.
#[derive(Clone, Copy, Debug)]
struct Chord {
    ends: (Point, Point),
    sides: Sides,
    /// Which curve, and the arc length along it.
    curve: usize,
    place: f64,
}

/// The chords of all curves, in bins.
pub(super) struct Traced {
    chords: Vec<Chord>,
    bins: Vec<Vec<u32>>,
    tolerance: f64,
    curves: usize,
    place: f64,
}

impl Traced {
    /// For chords that are at most `chord` from their curve.
    pub(super) fn new(chord: f64) -> Self {
        Self {
            chords: Vec::new(),
            bins: vec![Vec::new(); BINS * BINS],
            tolerance: 6.0 * chord,
            curves: 0,
            place: 0.0,
        }
    }

    /// A new curve begins; its places are counted from zero.
    pub(super) fn begin(&mut self) {
        self.curves += 1;
        self.place = 0.0;
    }

    /// The curve is continued from its first point in the other direction, by places below zero.
    pub(super) fn turn(&mut self) {
        self.place = 0.0;
    }

    /// Adds a chord of the current curve, whose `sides` are those of its direction.
    pub(super) fn add(&mut self, ends: (Point, Point), sides: Sides, is_backward: bool) {
        let step = distance(ends.0, ends.1);
        let place = self.place;
        self.place += if is_backward { -step } else { step };
        let index = self.chords.len() as u32;
        self.chords.push(Chord {
            ends,
            sides,
            curve: self.curves,
            place,
        });
        let reach = |i: usize| {
            let (a, b) = (ends.0[i], ends.1[i]);
            bin(a.min(b) - self.tolerance)..=bin(a.max(b) + self.tolerance)
        };
        for row in reach(1) {
            for column in reach(0) {
                self.bins[row * BINS + column].push(index);
            }
        }
    }

    /// Whether a change of phase lies on a curve: near a chord between the same phases, the same way round.
    pub(super) fn explains(&self, at: Point, along: Point, sides: Sides) -> bool {
        self.near(at, self.tolerance).any(|chord| {
            let direction = minus(chord.ends.1, chord.ends.0);
            let turn = cross(direction, along) / distance(chord.ends.0, chord.ends.1);
            // A line that grazes the curve tells nothing of its direction.
            if turn.abs() < 0.05 {
                chord.sides == sides || chord.sides == sides.swapped()
            } else if turn > 0.0 {
                chord.sides == sides
            } else {
                chord.sides == sides.swapped()
            }
        })
    }

    /// Whether a curve that has come to `at` after a step runs into one that has been traced the same way round, other
    /// than the stretch of its own that it has just left.
    pub(super) fn is_met(&self, at: Point, step: Point, sides: Sides) -> bool {
        let size = step[0].hypot(step[1]);
        let reach = self.tolerance.min(0.05 * size);
        self.near(at, reach).any(|chord| {
            let own = chord.curve == self.curves
                && (chord.place - self.place).abs() < 4.0 * size + 4.0 * self.tolerance;
            let same_way = cross(
                minus(chord.ends.1, chord.ends.0),
                super::plane::left_of(step),
            ) > 0.0;
            let expected = if same_way { sides } else { sides.swapped() };
            !own && chord.sides == expected
        })
    }

    fn near(&self, at: Point, reach: f64) -> impl Iterator<Item = &Chord> {
        let members = &self.bins[bin(at[1]) * BINS + bin(at[0])];
        members
            .iter()
            .map(|index| &self.chords[*index as usize])
            .filter(move |chord| distance_to_piece(at, chord.ends) <= reach)
    }
}

fn bin(x: f64) -> usize {
    ((x * BINS as f64).max(0.0) as usize).min(BINS - 1)
}

/// Removes vertices that crowd, as they do before a corner or an end, keeping the first, the last and those marked.
pub(super) fn thinned<T: Copy>(
    vertices: &[T],
    at: impl Fn(&T) -> Point,
    is_kept: impl Fn(&T) -> bool,
    spacing: f64,
) -> Vec<T> {
    let mut kept: Vec<T> = Vec::with_capacity(vertices.len());
    for (index, vertex) in vertices.iter().enumerate() {
        let is_end = index == 0 || index + 1 == vertices.len();
        if is_end || is_kept(vertex) {
            // The neighbor of a marked vertex gives way to it.
            while kept.len() > 1
                && kept
                    .last()
                    .is_some_and(|last| !is_kept(last) && distance(at(last), at(vertex)) < spacing)
            {
                kept.pop();
            }
            kept.push(*vertex);
        } else if kept
            .last()
            .is_none_or(|last| distance(at(last), at(vertex)) >= spacing)
        {
            kept.push(*vertex);
        }
    }
    kept
}

/// The middle of two points.
pub(super) fn middle(a: Point, b: Point) -> Point {
    plus(a, 0.5, minus(b, a))
}
