//! Boundaries between phases as curves in a window of two parameters.
//!
//! 1. `seeds` evaluates the nodes of a grid, searches for local minima of the measure between them, and lists segments on which the phase
//!    changes.
//! 2. `follow` traces a curve from each change of phase that lies on no known curve. Each step brackets the change of phase on a
//!    circle and checks the middle of the chord. The step is short enough for the chord to stay near the curve, and for the turn
//!    to agree with the curvature.
//! 3. `corner` extends two smooth branches to their intersection if the curve turns abruptly within arbitrarily short steps.
//!
//! Only phases are decisive, so that boundaries at which the measure jumps are also traced. The measure accelerates the search.

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

/// Number of curve budgets available to all curves together.
const BUDGETS: usize = 4;

/// Rectangle in the plane of two parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Smallest values of the two parameters.
    pub low: [f64; 2],
    /// Largest values of the two parameters.
    pub high: [f64; 2],
}

impl Window {
    /// Parameters at a point in units of the window, `[0, 1]^2`. The edges are mapped exactly.
    pub fn point(&self, unit: [f64; 2]) -> [f64; 2] {
        [0, 1].each(|i| {
            if unit[i] == 1.0 {
                self.high[i]
            } else {
                self.low[i] + unit[i] * (self.high[i] - self.low[i])
            }
        })
    }

    /// Lengths of the edges of the window.
    pub fn size(&self) -> [f64; 2] {
        [self.high[0] - self.low[0], self.high[1] - self.low[1]]
    }

    /// Area of the window, in the product of the units of the two parameters.
    pub fn area(&self) -> f64 {
        let [width, height] = self.size();
        width * height
    }
}

/// Resolution of a traced boundary. Lengths are in units of the window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fineness {
    /// Number of grid cells along each parameter.
    pub cells: [usize; 2],
    /// Largest distance of a chord from the curve.
    pub chord: f64,
    /// Length of the bracket of a vertex.
    pub bracket: f64,
    /// Largest number of states evaluated for one curve; a curve that needs more ends with [`End::Budget`].
    ///
    /// All curves together may use four times this number. Changes of phase found later remain unresolved.
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

/// Point of a boundary curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Values of the two parameters.
    pub point: [f64; 2],
    /// Half width of the bracket that contains the vertex, as a fraction of the window, times the larger side of the window.
    pub accuracy: f64,
    /// Whether two smooth branches meet here.
    pub is_corner: bool,
}

/// Reason for the end of an open curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The curve leaves the window.
    Edge,
    /// A third phase begins.
    Phase(Phase),
    /// The curve meets a traced curve or itself.
    Meets,
    /// The continuation of the curve was not found.
    Lost,
    /// The curve exceeded its budget of states.
    Budget,
}

/// Boundary curve between two phases.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Phase to the left of the direction of the vertices; it is the more stable of the two phases.
    pub left: Phase,
    /// Phase to the right of the direction of the vertices.
    pub right: Phase,
    /// Vertices along the curve. The last vertex of a closed curve equals its first.
    pub vertices: Vec<Vertex>,
    /// Reasons for the two ends of the curve; `None` if it is closed.
    pub ends: Option<[End; 2]>,
}

impl Curve {
    /// Returns true if the curve is closed.
    pub fn is_closed(&self) -> bool {
        self.ends.is_none()
    }

    /// Positions of the vertices, in the units of the parameters.
    pub fn points(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        self.vertices.iter().map(|vertex| vertex.point)
    }

    /// Length of the polygon of the vertices, in the units of the parameters.
    pub fn length(&self) -> f64 {
        let pairs = self.vertices.windows(2);
        pairs
            .map(|pair| distance(pair[0].point, pair[1].point))
            .sum()
    }

    /// Points at which two smooth branches meet.
    pub fn corners(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        let inner = if self.is_closed() { 1 } else { 0 };
        let vertices = self.vertices.iter().skip(inner);
        vertices
            .filter(|vertex| vertex.is_corner)
            .map(|vertex| vertex.point)
    }

    /// Largest half bracket of the vertices.
    pub fn accuracy(&self) -> f64 {
        let accuracies = self.vertices.iter().map(|vertex| vertex.accuracy);
        accuracies.fold(0.0, f64::max)
    }
}

/// All boundary curves in a window.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Boundary {
    /// Boundary curves, in the order of their seeds.
    pub curves: Vec<Curve>,
    /// Changes of phase without a traced curve.
    pub unresolved: Vec<[f64; 2]>,
}

impl Boundary {
    /// Returns true if every change of phase that was found lies on a curve that was traced to its end.
    pub fn is_complete(&self) -> bool {
        let ends = self.curves.iter().filter_map(|curve| curve.ends).flatten();
        self.unresolved.is_empty()
            && !ends
                .into_iter()
                .any(|end| matches!(end, End::Lost | End::Budget))
    }

    /// Boundaries between stable and unstable phases. Boundaries of the undefined phase are excluded.
    pub fn of_stability(&self) -> impl Iterator<Item = &Curve> {
        self.curves.iter().filter(|curve| {
            curve.left != Phase::Undefined
                && curve.right != Phase::Undefined
                && curve.left.is_unstable() != curve.right.is_unstable()
        })
    }
}

/// Traces all curves in a window along which the phase changes.
///
/// A component is found if neighboring nodes of the grid lie on different sides of it, or if the measure has a local minimum between nodes. Corners that
/// turn by less than 2e-3 radians are not marked.
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
/// Errors of the probe.
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

/// Like [`trace_boundary`], with known probes at the [`grid_points`], which can be evaluated in parallel.
///
/// # Errors
/// Errors of the probe.
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

/// Returns a change of phase between two points, bracketed to `1e-13` of the window.
///
/// If several are found, the change nearest to `from` is returned; `None` if both points are in the same phase, or if a point is outside the window.
///
/// # Errors
/// Errors of the probe.
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

/// Change of phase on a segment, in units of the window.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    at: Point,
    /// Unit direction of the line, towards the left phase.
    along: Point,
    sides: Sides,
    accuracy: f64,
}

/// Order of phases, most stable first; the more stable of two phases is on the left of a curve.
fn rank(phase: Phase) -> u8 {
    match phase {
        Phase::Stable => 0,
        Phase::Flutter => 1,
        Phase::Unstable => 2,
        Phase::Undefined => 3,
    }
}
