//! Index of traced curves, to recognize points that lie on one of them.

use super::line::Sides;
use super::plane::{Point, cross, distance, distance_to_piece, minus, plus};

/// Bins along each edge of the window.
const BINS: usize = 64;

/// Chord of a traced curve.
#[derive(Clone, Copy, Debug)]
struct Chord {
    ends: (Point, Point),
    sides: Sides,
    /// Number of the curve, and the arc length along it.
    curve: usize,
    place: f64,
}

/// Chords of all curves, sorted into bins.
pub(super) struct Traced {
    chords: Vec<Chord>,
    bins: Vec<Vec<u32>>,
    tolerance: f64,
    curves: usize,
    place: f64,
}

impl Traced {
    /// Creates an empty index for chords within a distance `chord` of their curve.
    pub(super) fn new(chord: f64) -> Self {
        Self {
            chords: Vec::new(),
            bins: vec![Vec::new(); BINS * BINS],
            tolerance: 6.0 * chord,
            curves: 0,
            place: 0.0,
        }
    }

    /// Begins a new curve; arc length is measured from its first point.
    pub(super) fn begin(&mut self) {
        self.curves += 1;
        self.place = 0.0;
    }

    /// Continues the curve from its first point in the other direction, with negative arc lengths.
    pub(super) fn turn(&mut self) {
        self.place = 0.0;
    }

    /// Adds a chord of the current curve. `sides` are the phases left and right of its direction.
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

    /// Returns true if a change of phase lies on a traced curve: near a chord between the two phases, with each on the same side.
    pub(super) fn explains(&self, at: Point, along: Point, sides: Sides) -> bool {
        self.near(at, self.tolerance).any(|chord| {
            let direction = minus(chord.ends.1, chord.ends.0);
            let turn = cross(direction, along) / distance(chord.ends.0, chord.ends.1);
            // A line nearly parallel to the chord does not define its sides.
            if turn.abs() < 0.05 {
                chord.sides == sides || chord.sides == sides.swapped()
            } else if turn > 0.0 {
                chord.sides == sides
            } else {
                chord.sides == sides.swapped()
            }
        })
    }

    /// Returns true if a step of the current curve to `at` meets a traced curve with the same phases on the same sides. The segment that the curve
    /// has just left is excluded.
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

/// Removes crowded vertices, as before a corner or an end. The first, the last and the marked vertices are kept.
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
            // Neighbors too close to a marked vertex are removed.
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

pub(super) fn middle(a: Point, b: Point) -> Point {
    plus(a, 0.5, minus(b, a))
}
