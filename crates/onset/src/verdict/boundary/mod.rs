//! Boundaries between phases as curves in a window of two parameters, followed from point to point.
//!
//! 1. `seeds` looks at the nodes of a grid, follows dips of the measure between them, and lists pieces of lines on which
//!    the phase changes.
//! 2. Each change that no curve explains yet starts one: `follow` steps along it on circles, on which the change of phase
//!    is bracketed, and checks the middle of every chord. A step is as long as the chord stays near the curve and the
//!    curve turns as its curvature foretells.
//! 3. Where it turns at once, however short the step, there is a `corner`: two smooth branches are extended to where they
//!    meet.
//!
//! Only phases decide, so that boundaries at which the measure jumps are followed too; the measure makes it fast.

mod corner;
mod follow;
mod line;
mod plane;
mod seeds;
mod traced;

pub use seeds::grid_points;

use super::{Phase, Probe};
use crate::algebra::Each;
use line::{Field, Sides};
use plane::{Point, distance};
use traced::Traced;

/// How many curves may use up their budgets.
const BUDGETS: usize = 4;

/// A rectangle of two parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// The smallest values of the two.
    pub low: [f64; 2],
    /// The largest values of the two.
    pub high: [f64; 2],
}

impl Window {
    /// The parameters at a point in units of the window, `[0, 1]^2`; its edges are met exactly.
    pub fn point(&self, unit: [f64; 2]) -> [f64; 2] {
        [0, 1].each(|i| {
            if unit[i] == 1.0 {
                self.high[i]
            } else {
                self.low[i] + unit[i] * (self.high[i] - self.low[i])
            }
        })
    }

    /// The lengths of its edges.
    pub fn size(&self) -> [f64; 2] {
        [self.high[0] - self.low[0], self.high[1] - self.low[1]]
    }

    /// Its area, in the product of the units of the two parameters.
    pub fn area(&self) -> f64 {
        let [width, height] = self.size();
        width * height
    }
}

/// How finely a boundary is traced. Lengths are in units of the window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fineness {
    /// Cells of the grid of seeds along the two parameters.
    pub cells: [usize; 2],
    /// How far a chord may be from the curve.
    pub chord: f64,
    /// How narrow the bracket of a vertex is.
    pub bracket: f64,
    /// How many states may be asked for one curve; a curve that needs more ends with [`End::Budget`]. For all curves
    /// together four times as many; what is found later stays unresolved.
    pub budget: usize,
}

impl Default for Fineness {
    fn default() -> Self {
        Self {
            cells: [48, 48],
            chord: 1e-5,
            bracket: 1e-13,
            budget: 10_000,
        }
    }
}

/// A point of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// The two parameters.
    pub point: [f64; 2],
    /// Half of the length of its bracket, in the larger of the two parameters' units.
    pub accuracy: f64,
    /// Whether two smooth branches meet here.
    pub is_corner: bool,
}

/// Why an open curve ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// At the edge of the window.
    Edge,
    /// A third phase begins.
    Phase(Phase),
    /// It runs into a curve that has been traced, or into itself.
    Meets,
    /// The curve could not be followed any further.
    Lost,
    /// It took more states than admitted.
    Budget,
}

/// A boundary between two phases.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// The phase to the left of the direction in which the vertices run, the more stable one.
    pub left: Phase,
    /// The phase to the right.
    pub right: Phase,
    /// The vertices; the last one of a closed curve is its first.
    pub vertices: Vec<Vertex>,
    /// Why it starts and ends where it does; `None` when it is closed.
    pub ends: Option<[End; 2]>,
}

impl Curve {
    /// Whether it ends where it starts.
    pub fn is_closed(&self) -> bool {
        self.ends.is_none()
    }

    /// The points alone.
    pub fn points(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        self.vertices.iter().map(|vertex| vertex.point)
    }

    /// The arc length of the polygon, in the parameters as they are.
    pub fn length(&self) -> f64 {
        let pairs = self.vertices.windows(2);
        pairs
            .map(|pair| distance(pair[0].point, pair[1].point))
            .sum()
    }

    /// The points at which smooth branches meet.
    pub fn corners(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        let inner = if self.is_closed() { 1 } else { 0 };
        let vertices = self.vertices.iter().skip(inner);
        vertices
            .filter(|vertex| vertex.is_corner)
            .map(|vertex| vertex.point)
    }

    /// The largest half bracket of its vertices.
    pub fn accuracy(&self) -> f64 {
        let accuracies = self.vertices.iter().map(|vertex| vertex.accuracy);
        accuracies.fold(0.0, f64::max)
    }
}

/// All boundaries in a window.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Boundary {
    /// The curves.
    pub curves: Vec<Curve>,
    /// Points at which the phase changes, but from which no curve could be followed.
    pub unresolved: Vec<[f64; 2]>,
}

impl Boundary {
    /// Whether every change of phase that was seen lies on a curve that was followed to its end.
    pub fn is_complete(&self) -> bool {
        let ends = self.curves.iter().filter_map(|curve| curve.ends).flatten();
        self.unresolved.is_empty()
            && !ends
                .into_iter()
                .any(|end| matches!(end, End::Lost | End::Budget))
    }

    /// The curves between two defined phases: where stability is lost or regained.
    pub fn of_stability(&self) -> impl Iterator<Item = &Curve> {
        self.curves.iter().filter(|curve| {
            curve.left != Phase::Undefined
                && curve.right != Phase::Undefined
                && curve.left.is_unstable() != curve.right.is_unstable()
        })
    }
}

/// All curves in a window along which the phase changes.
///
/// Components are found that a node of the grid tells from its neighbor, or of which the measure shows a dip between
/// them. Corners that turn by less than 2e-3 radians are not marked.
///
/// ```
/// use onset::verdict::Phase;
/// use onset::verdict::boundary::{Fineness, Window, trace_boundary};
/// let window = Window { low: [-2.0, -2.0], high: [2.0, 2.0] };
/// let circle = |[x, y]: [f64; 2]| -> Result<_, std::convert::Infallible> {
///     let measure = 1.0 - x * x - y * y;
///     Ok((if measure > 0.0 { Phase::Stable } else { Phase::Unstable }, measure))
/// };
/// let boundary = trace_boundary(window, &Fineness::default(), &circle)?;
/// assert_eq!(boundary.curves.len(), 1);
/// let curve = &boundary.curves[0];
/// assert!(curve.is_closed() && (curve.length() - std::f64::consts::TAU).abs() < 2e-4);
/// assert!(curve.points().all(|[x, y]| (x.hypot(y) - 1.0).abs() < 1e-11));
/// # Ok::<(), std::convert::Infallible>(())
/// ```
///
/// # Errors
/// What the probe reports.
pub fn trace_boundary<E>(
    window: Window,
    fineness: &Fineness,
    probe: &(dyn Fn([f64; 2]) -> Result<Probe, E> + Sync),
) -> Result<Boundary, E> {
    let grid: Vec<Probe> = grid_points(window, fineness)
        .into_iter()
        .map(probe)
        .collect::<Result<_, _>>()?;
    trace_boundary_from(window, fineness, &grid, probe)
}

/// The same from probes at [`grid_points`], which can be taken in parallel.
///
/// # Errors
/// What the probe reports.
pub fn trace_boundary_from<E>(
    window: Window,
    fineness: &Fineness,
    grid: &[Probe],
    probe: &(dyn Fn([f64; 2]) -> Result<Probe, E> + Sync),
) -> Result<Boundary, E> {
    let field = Field::new(window, probe);
    let mut traced = Traced::new(fineness.chord);
    let mut boundary = Boundary::default();
    let seeds = seeds::seeds(&field, fineness, grid)?;
    let asked_for_seeds = field.asked();
    for seed in seeds {
        for crossing in seeds::crossings(&field, fineness, seed)? {
            if traced.explains(crossing.at, crossing.along, crossing.sides) {
                continue;
            }
            if field.asked() - asked_for_seeds > BUDGETS * fineness.budget {
                boundary.unresolved.push(window.point(crossing.at));
                continue;
            }
            match follow::follow(&field, fineness, &mut traced, &crossing)? {
                Some(curve) => boundary.curves.push(curve),
                None => boundary.unresolved.push(window.point(crossing.at)),
            }
        }
    }
    Ok(boundary)
}

/// The first change of phase found between two points, bracketed to `1e-13` of the window; `None` when both are of one
/// phase, or one is outside.
///
/// # Errors
/// What the probe reports.
pub fn located_between<E>(
    window: Window,
    probe: &(dyn Fn([f64; 2]) -> Result<Probe, E> + Sync),
    from: [f64; 2],
    to: [f64; 2],
) -> Result<Option<[f64; 2]>, E> {
    let field = Field::new(window, probe);
    let size = window.size();
    let unit = |point: [f64; 2]| [0, 1].map(|i| (point[i] - window.low[i]) / size[i]);
    let ends = [unit(from), unit(to)];
    let (Some(a), Some(b)) = (field.at(ends[0])?, field.at(ends[1])?) else {
        return Ok(None);
    };
    let seed = ((ends[0], a), (ends[1], b));
    let found = seeds::crossings(&field, &Fineness::default(), seed)?;
    let nearest = found
        .iter()
        .min_by(|a, b| distance(a.at, ends[0]).total_cmp(&distance(b.at, ends[0])));
    Ok(nearest.map(|crossing| window.point(crossing.at)))
}

/// A change of phase on a piece of a line, in units of the window.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    at: Point,
    /// The unit direction of the line, towards the left phase.
    along: Point,
    sides: Sides,
    accuracy: f64,
}

/// The order of phases: the more stable one is to the left.
fn rank(phase: Phase) -> u8 {
    match phase {
        Phase::Stable => 0,
        Phase::Flutter => 1,
        Phase::Unstable => 2,
        Phase::Undefined => 3,
    }
}
