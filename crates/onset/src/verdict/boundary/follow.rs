//! Tracing of a curve step by step from a point on it.

use super::corner;
use super::line::{Field, Found, Sides};
use super::plane::{
    Point, angle_of, curvature, direction, distance, dot, left_of, length, minus, plus, unit,
    wrapped,
};
use super::traced::{Traced, middle, thinned};
use super::{Crossing, Curve, End, Fineness, Vertex};
use crate::verdict::{Phase, Probe};
use std::f64::consts::{PI, TAU};

/// Largest turn of a smooth step beyond the prediction of the curvature, in radians. A larger turn indicates a corner if it persists in steps as
/// short as [`CORNER_STEP`].
const CORNER_TURN: f64 = 2e-3;
const CORNER_STEP: f64 = 1e-5;
/// Number of predictions of a corner within a step, after which the steps are only shortened.
const MAX_PREDICTIONS: usize = 3;
/// Distance from a predicted corner at which a step ends, as a fraction of the distance to the corner.
const CORNER_MARGIN: f64 = 0.02;
/// Largest length of a short step, as after a corner. The length of short steps may grow faster.
const SHORT_STEP: f64 = 1e-3;
/// Largest length of a step that does not determine the curvature.
const SMOOTH_STEP: f64 = 1e-7;
/// Shortest step. An obstacle within it ends the curve.
const SHORTEST_STEP: f64 = 1e-10;
/// Largest turn of the curve on the circle of a step, in radians.
pub(super) const SWEEP: f64 = 2.9;
/// Distance from a corner at which a curve is started.
const CORNER_OFFSET: f64 = 3e-3;
/// Number of directions in which the search for a curve samples the surroundings of its seed.
const RAYS: usize = 24;

/// Vertex in units of the window.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub(super) at: Point,
    pub(super) accuracy: f64,
    pub(super) is_corner: bool,
}

impl Node {
    pub(super) fn regular(at: Point, accuracy: f64) -> Self {
        Self {
            at,
            accuracy,
            is_corner: false,
        }
    }
}

/// Tangent and curvature of the curve at a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Heading {
    pub(super) at: Point,
    /// Angle of the tangent, in radians.
    pub(super) angle: f64,
    /// Curvature, positive for a left turn.
    pub(super) curvature: f64,
}

/// Traces the curve through a crossing in both directions; `None` if no curve leaves it.
pub(super) fn follow<E>(
    field: &Field<'_, E>,
    fineness: &Fineness,
    traced: &mut Traced,
    crossing: &Crossing,
) -> Result<Option<Curve>, E> {
    let Some((crossing, start)) = beginning(field, fineness, traced, crossing)? else {
        return Ok(None);
    };
    traced.begin();
    let seed = Node {
        at: crossing.at,
        accuracy: if start.is_corner {
            start.step
        } else {
            crossing.accuracy
        },
        is_corner: start.is_corner,
    };
    let asked = field.asked();
    let walk = |heading: Option<Heading>, is_backward: bool, traced: &mut Traced| {
        let Some(heading) = heading else {
            return Ok((vec![seed], Some(End::Edge)));
        };
        let mut walker = Walker {
            field,
            fineness,
            sides: if is_backward {
                crossing.sides.swapped()
            } else {
                crossing.sides
            },
            is_backward,
            heading,
            start: heading,
            step: start.step,
            excess: 1e-3,
            traveled: 0.0,
            nodes: vec![seed],
            asked,
            misses: 0,
            onward: None,
        };
        let end = walker.walk(traced)?;
        Ok((walker.nodes, end))
    };
    let (forward, last) = walk(start.forward, false, traced)?;
    let (nodes, ends) = match last {
        None => (forward, None),
        Some(last) => {
            traced.turn();
            let (mut nodes, first) = walk(start.backward, true, traced)?;
            nodes.reverse();
            match first {
                Some(first) => {
                    nodes.extend(forward.into_iter().skip(1));
                    (nodes, Some([first, last]))
                }
                // A curve that closes backward contains the forward part.
                None => (nodes, None),
            }
        }
    };
    Ok((nodes.len() > 1).then(|| curve(field, crossing.sides, &nodes, ends)))
}

/// Start of a curve: the seed, or a point near it if the seed is a corner. The corner is then found like any other corner.
fn beginning<E>(
    field: &Field<'_, E>,
    fineness: &Fineness,
    traced: &Traced,
    crossing: &Crossing,
) -> Result<Option<(Crossing, Start)>, E> {
    let Some(start) = Start::around(field, fineness, crossing)? else {
        return Ok(None);
    };
    let seed = Some((*crossing, start));
    let Some(heading) = start.forward.filter(|_| start.is_corner) else {
        return Ok(seed);
    };
    let circle = |turn: f64| plus(crossing.at, CORNER_OFFSET, direction(heading.angle + turn));
    let reach = (0.0, 1e-3, 1.0);
    let found = field.locate(
        &circle,
        reach,
        crossing.sides,
        fineness.bracket / CORNER_OFFSET,
    )?;
    let Some((turn, accuracy)) = found.place() else {
        return Ok(seed);
    };
    let beside = Crossing {
        at: circle(turn),
        along: left_of(direction(heading.angle)),
        accuracy: accuracy * CORNER_OFFSET,
        ..*crossing
    };
    if traced.explains(beside.at, beside.along, beside.sides) {
        return Ok(seed);
    }
    let start = Start::around(field, fineness, &beside)?;
    Ok(start
        .filter(|start| !start.is_corner)
        .map(|start| (beside, start))
        .or(seed))
}

fn curve<E>(field: &Field<'_, E>, sides: Sides, nodes: &[Node], ends: Option<[End; 2]>) -> Curve {
    let size = field.window.size();
    let vertex = |node: &Node| Vertex {
        point: field.window.point(node.at),
        accuracy: node.accuracy * size[0].max(size[1]),
        is_corner: node.is_corner,
    };
    let kept = thinned(nodes, |node| node.at, |node| node.is_corner, 1e-6);
    let mut vertices: Vec<Vertex> = kept.iter().map(vertex).collect();
    if ends.is_none()
        && let (Some(first), Some(last)) = (vertices.first().copied(), vertices.last_mut())
    {
        *last = first;
    }
    Curve {
        left: sides.left,
        right: sides.right,
        vertices,
        ends,
    }
}

/// Directions in which a curve leaves its seed.
#[derive(Clone, Copy)]
struct Start {
    forward: Option<Heading>,
    backward: Option<Heading>,
    /// Turn of the curve within the circle of the search, and the radius of the circle.
    bend: f64,
    step: f64,
    is_corner: bool,
}

impl Start {
    /// Searches on circles of decreasing radius for a single, nearly straight curve.
    fn around<E>(
        field: &Field<'_, E>,
        fineness: &Fineness,
        crossing: &Crossing,
    ) -> Result<Option<Self>, E> {
        let mut best = None;
        for power in 3..=9 {
            let radius = 10.0_f64.powi(-power);
            let Some(start) = Self::on_circle(field, fineness, crossing, radius)? else {
                continue;
            };
            let is_smooth = start.bend.abs() < CORNER_TURN;
            best = Some(start);
            if is_smooth {
                break;
            }
        }
        Ok(best.map(Self::with_corner))
    }

    /// Marks the seed as a corner if the curve bends even on the smallest circle. The chords are then the tangents.
    fn with_corner(mut self) -> Self {
        self.is_corner = self.bend.abs() >= CORNER_TURN;
        if self.is_corner {
            for (heading, sign) in [(&mut self.forward, 1.0), (&mut self.backward, -1.0)] {
                if let Some(heading) = heading {
                    heading.angle += sign * 0.5 * self.bend;
                    heading.curvature = 0.0;
                }
            }
        }
        self
    }

    /// Searches for the start on one circle.
    fn on_circle<E>(
        field: &Field<'_, E>,
        fineness: &Fineness,
        crossing: &Crossing,
        radius: f64,
    ) -> Result<Option<Self>, E> {
        let (at, sides) = (crossing.at, crossing.sides);
        let line = |angle: f64| plus(at, radius, direction(angle));
        // Rotated slightly, so that no ray is parallel to the grid.
        let angle = |n: usize| angle_of(crossing.along) + 0.1 + TAU * n as f64 / RAYS as f64;
        let around: Vec<Option<Probe>> = (0..RAYS)
            .map(|n| field.at(line(angle(n))))
            .collect::<Result<_, _>>()?;
        let (mut forward, mut backward) = (Vec::new(), Vec::new());
        for n in 0..RAYS {
            let (Some(a), Some(b)) = (around[n], around[(n + 1) % RAYS]) else {
                continue;
            };
            if !sides.holds(a.0) || !sides.holds(b.0) {
                return Ok(None);
            }
            if a.0 == b.0 {
                continue;
            }
            let is_forward = b.0 == sides.left;
            let (a, b) = ((angle(n), a), (angle(n + 1), b));
            let knots = if is_forward { (b, a) } else { (a, b) };
            let Some((angle, _)) = field
                .narrow(&line, knots, fineness.bracket / radius)?
                .place()
            else {
                return Ok(None);
            };
            if is_forward {
                forward.push(angle);
            } else {
                backward.push(angle);
            }
        }
        let is_border = around.iter().any(Option::is_none);
        let is_clear = match (forward.len(), backward.len()) {
            (1, 1) => true,
            (1, 0) | (0, 1) => is_border,
            _ => false,
        };
        if !is_clear {
            return Ok(None);
        }
        let (forward, backward) = (forward.first().copied(), backward.first().copied());
        let (bend, curvature) = match (forward, backward) {
            (Some(f), Some(b)) => {
                let turn = wrapped(f - b - PI);
                let curvature = if radius > 1e-6 { turn / radius } else { 0.0 };
                (turn, curvature)
            }
            _ => (0.0, 0.0),
        };
        // The tangent bisects the angle of the two chords.
        let heading = |angle: f64, sign: f64| Heading {
            at,
            angle: angle - sign * 0.5 * bend,
            curvature: sign * curvature,
        };
        Ok(Some(Self {
            forward: forward.map(|angle| heading(angle, 1.0)),
            backward: backward.map(|angle| heading(angle, -1.0)),
            bend,
            step: radius,
            is_corner: false,
        }))
    }
}

/// Result of a step.
enum Step {
    /// Two further vertices and the heading at the second; the turn beyond the prediction, and the distance of the chord from the curve.
    Taken {
        nodes: [Node; 2],
        heading: Heading,
        excess: f64,
        deviation: f64,
    },
    /// The curve turns by more than its curvature predicts.
    Turns(Node),
    /// The distance of the chord from the curve is too large.
    Bends(f64),
    /// The step meets a third phase, or the edge of the window (`None`).
    Meets(Option<Phase>),
    /// The curve was not found.
    Lost,
}

struct Walker<'a, 'f, E> {
    field: &'a Field<'f, E>,
    fineness: &'a Fineness,
    sides: Sides,
    is_backward: bool,
    heading: Heading,
    start: Heading,
    step: f64,
    /// Turn of the last step beyond the prediction.
    excess: f64,
    traveled: f64,
    nodes: Vec<Node>,
    asked: usize,
    /// Number of successive steps that turned.
    misses: usize,
    /// Length of the next step, if this step ends just before a corner.
    onward: Option<f64>,
}

impl<E> Walker<'_, '_, E> {
    /// Traces the curve to its end; `None` if it is closed.
    fn walk(&mut self, traced: &mut Traced) -> Result<Option<End>, E> {
        let longest = 1.0 / self.fineness.cells.into_iter().max().unwrap_or(2).max(2) as f64;
        loop {
            if self.field.asked() - self.asked > self.fineness.budget {
                return Ok(Some(End::Budget));
            }
            if self.closes(traced)? {
                return Ok(None);
            }
            match self.try_step()? {
                Step::Taken {
                    nodes,
                    heading,
                    excess,
                    deviation,
                } => {
                    let along = minus(heading.at, self.heading.at);
                    let is_met = traced.is_met(heading.at, along, self.sides);
                    self.push(&nodes, traced);
                    let growth = if self.step < SHORT_STEP { 8.0 } else { 2.0 };
                    let factor = (3.0 * self.fineness.chord / deviation)
                        .min(0.7 * CORNER_TURN / excess)
                        .sqrt()
                        .clamp(0.5, growth);
                    let grown = (self.step * factor).min(longest);
                    self.step = self.onward.take().unwrap_or(grown);
                    self.misses = 0;
                    (self.heading, self.excess) = (heading, excess);
                    if is_met {
                        return Ok(Some(End::Meets));
                    }
                }
                Step::Turns(node) if self.step <= CORNER_STEP => self.turn(node, traced)?,
                Step::Turns(node) => self.approach(node.at)?,
                Step::Bends(deviation) => {
                    let factor = (2.0 * self.fineness.chord / deviation).sqrt();
                    self.step *= factor.clamp(0.1, 0.6);
                }
                Step::Meets(None) if self.leaves(traced)? => return Ok(Some(End::Edge)),
                Step::Meets(phase) if self.step < SHORTEST_STEP => {
                    return Ok(Some(phase.map_or_else(|| self.snap_to_edge(), End::Phase)));
                }
                Step::Lost if self.step < SHORTEST_STEP => return Ok(Some(End::Lost)),
                Step::Meets(_) | Step::Lost => self.step *= 0.3,
            }
        }
    }

    /// Shortens the step after an abrupt turn. If the corner can be predicted, the step ends just before it.
    fn approach(&mut self, beyond: Point) -> Result<(), E> {
        let shortest = 0.99 * CORNER_STEP;
        let ahead = if self.misses < MAX_PREDICTIONS {
            corner::ahead(self.field, self.sides, &self.heading, beyond)?
        } else {
            None
        };
        self.misses += 1;
        (self.step, self.onward) = match ahead {
            Some(ahead) => {
                // Larger than the error of the prediction, and small enough to turn around the sharpest tip.
                let margin = (CORNER_MARGIN * ahead).max(0.8 * CORNER_STEP);
                let step = (ahead - margin).min(0.9 * self.step);
                (step.max(shortest), Some(margin * 0.99 / 0.8))
            }
            None => ((0.25 * self.step).max(shortest), None),
        };
        Ok(())
    }

    /// Tries one step of the current length.
    fn try_step(&self) -> Result<Step, E> {
        let Heading {
            at,
            angle,
            curvature: bend,
        } = self.heading;
        let step = self.step;
        let circle = |turn: f64| plus(at, step, direction(angle + turn));
        let guess = (0.5 * bend * step).clamp(-1.0, 1.0);
        let reach = (guess, (2.0 * self.excess).clamp(1e-6, 0.1), SWEEP);
        let found = self
            .field
            .locate(&circle, reach, self.sides, self.fineness.bracket / step)?;
        let (turn, accuracy) = match (found.place(), found) {
            (Some(place), _) => place,
            (None, Found::Other(phase)) => return Ok(Step::Meets(phase)),
            (None, _) => return Ok(Step::Lost),
        };
        let next = Node::regular(circle(turn), accuracy * step);
        let excess = (turn - guess).abs();
        if step > SMOOTH_STEP && excess > CORNER_TURN {
            return Ok(Step::Turns(next));
        }
        let Some((between, deviation)) = self.between(next.at)? else {
            return Ok(Step::Lost);
        };
        let turned = curvature(at, between.at, next.at);
        if step > SMOOTH_STEP && (turned - bend).abs() * step > 2.0 * CORNER_TURN {
            return Ok(Step::Turns(next));
        }
        if step > 1e-6 && deviation > 4.0 * self.fineness.chord {
            return Ok(Step::Bends(deviation));
        }
        let heading = heading_behind(at, between.at, next.at);
        Ok(Step::Taken {
            nodes: [between, next],
            heading: Heading {
                curvature: if step > SMOOTH_STEP { turned } else { bend },
                ..heading
            },
            excess,
            deviation,
        })
    }

    /// Point of the curve across the middle of a chord, with its distance from the chord.
    fn between(&self, to: Point) -> Result<Option<(Node, f64)>, E> {
        let at = self.heading.at;
        let chord = minus(to, at);
        let size = length(chord);
        let (center, across) = (middle(at, to), left_of(unit(chord)));
        let line = |x: f64| plus(center, x, across);
        let sagitta = -self.heading.curvature * size * size / 8.0;
        let reach = (
            sagitta.clamp(-0.4 * size, 0.4 * size),
            1e-4 * size,
            0.5 * size,
        );
        let found = self
            .field
            .locate(&line, reach, self.sides, self.fineness.bracket)?;
        Ok(found
            .place()
            .map(|(x, accuracy)| (Node::regular(line(x), accuracy), x.abs())))
    }

    fn push(&mut self, nodes: &[Node], traced: &mut Traced) {
        for node in nodes {
            if let Some(last) = self.nodes.last() {
                traced.add((last.at, node.at), self.sides, self.is_backward);
                self.traveled += distance(last.at, node.at);
            }
            self.nodes.push(*node);
        }
    }

    /// Closes the curve if its start is within the next step.
    fn closes(&mut self, traced: &mut Traced) -> Result<bool, E> {
        let ahead = minus(self.start.at, self.heading.at);
        let left = length(ahead);
        if self.nodes.len() < 6 || left > 1.3 * self.step || self.traveled < 3.0 * left {
            return Ok(false);
        }
        if left < SHORTEST_STEP {
            self.nodes.pop();
            let end = self.nodes[0];
            self.push(&[end], traced);
            return Ok(true);
        }
        let straight = direction(self.heading.angle);
        let is_onward = self.nodes[0].is_corner || dot(straight, direction(self.start.angle)) > 0.0;
        if dot(straight, ahead) < 0.5 * left || !is_onward {
            return Ok(false);
        }
        let Some((between, deviation)) = self.between(self.start.at)? else {
            return Ok(false);
        };
        let turned = curvature(self.heading.at, between.at, self.start.at);
        let is_smooth = (turned - self.heading.curvature).abs() * left <= 2.0 * CORNER_TURN;
        if left > CORNER_STEP && (deviation > 4.0 * self.fineness.chord || !is_smooth) {
            self.step = self.step.min(0.5 * left);
            return Ok(false);
        }
        let end = self.nodes[0];
        self.push(&[between, end], traced);
        Ok(true)
    }

    /// Ends the curve on the edge of the window if it leaves it within this step.
    fn leaves(&mut self, traced: &mut Traced) -> Result<bool, E> {
        let Heading { at, angle, .. } = self.heading;
        let ahead = direction(angle);
        for axis in 0..2 {
            for edge in [0.0, 1.0] {
                let room = (edge - at[axis]) / ahead[axis];
                // The seed can lie on the edge.
                if at[axis] == edge && (ahead[axis] > 0.0) == (edge > 0.5) && self.nodes.len() == 1
                {
                    return Ok(true);
                }
                if !(0.0..=2.0 * self.step).contains(&room) || ahead[axis].abs() < 1e-3 {
                    continue;
                }
                let mut exit = plus(at, room, ahead);
                exit[axis] = edge;
                let sign = left_of(ahead)[1 - axis].signum();
                let line = |x: f64| {
                    let mut point = exit;
                    point[1 - axis] += sign * x;
                    point
                };
                let reach = (
                    0.0,
                    (1e-3 * room).max(self.fineness.bracket),
                    2.0 * self.step,
                );
                let found = self
                    .field
                    .locate(&line, reach, self.sides, self.fineness.bracket)?;
                let Some((x, accuracy)) = found.place() else {
                    continue;
                };
                let last = Node::regular(line(x), accuracy);
                if distance(at, last.at) <= SHORTEST_STEP {
                    self.push(&[last], traced);
                    return Ok(true);
                }
                if let Some((between, deviation)) = self.between(last.at)?
                    && deviation <= 4.0 * self.fineness.chord
                {
                    self.push(&[between, last], traced);
                    return Ok(true);
                }
            }
        }
        Ok(false)
    }

    /// Moves the last vertex onto the edge, which it has reached to the shortest step.
    fn snap_to_edge(&mut self) -> End {
        if let Some(last) = self.nodes.last_mut() {
            for x in &mut last.at {
                if *x < 10.0 * SHORTEST_STEP {
                    *x = 0.0;
                } else if *x > 1.0 - 10.0 * SHORTEST_STEP {
                    *x = 1.0;
                }
            }
        }
        End::Edge
    }

    /// Passes a corner between the current point and a point that is one short step away.
    fn turn(&mut self, next: Node, traced: &mut Traced) -> Result<(), E> {
        let corner = corner::around(
            self.field,
            self.sides,
            &self.heading,
            next,
            self.fineness.bracket,
        )?;
        let (nodes, heading) = corner.unwrap_or_else(|| {
            // Without two smooth branches the corner is placed where the turn was found.
            let along = minus(next.at, self.heading.at);
            let node = Node {
                accuracy: length(along),
                is_corner: true,
                ..next
            };
            let heading = Heading {
                at: next.at,
                angle: angle_of(along),
                curvature: 0.0,
            };
            (vec![node], heading)
        });
        self.push(&nodes, traced);
        self.heading = heading;
        (self.step, self.excess) = (2.0 * CORNER_STEP, 1e-3);
        Ok(())
    }
}

/// Heading at the last of three points of a curve.
pub(super) fn heading_behind(a: Point, b: Point, c: Point) -> Heading {
    let (first, second) = (angle_of(minus(b, a)), angle_of(minus(c, b)));
    Heading {
        at: c,
        angle: second + 0.5 * wrapped(second - first),
        curvature: curvature(a, b, c),
    }
}
