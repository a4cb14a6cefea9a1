//! Areas in which the stability of material and discretization differs, computed from the traced boundaries of both.

use crate::algebra::sort_by_value;
use crate::verdict::Phase;
use crate::verdict::boundary::{Boundary, Window};

/// Areas in a window, in the product of the units of the two parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Areas {
    /// Area of the window.
    pub window: f64,
    /// Area in which the material is strongly elliptic.
    pub elliptic: f64,
    /// Area of false instability: the material is strongly elliptic, and the particles are unstable.
    pub false_instability: f64,
    /// Area of suppressed instability: the material is not strongly elliptic, and the particles are stable.
    pub suppressed_instability: f64,
    /// Area in which the discretization is not defined.
    pub undefined: f64,
}

impl Areas {
    /// Area of false instability as a fraction of the elliptic area; NaN if the elliptic area is zero.
    pub fn false_share(&self) -> f64 {
        self.false_instability / self.elliptic
    }

    /// Area of suppressed instability as a fraction of the elliptic area; NaN if the elliptic area is zero.
    pub fn suppressed_share(&self) -> f64 {
        self.suppressed_instability / self.elliptic
    }

    fn add(&mut self, area: f64, [material, particles]: [Phase; 2]) {
        self.window += area;
        if material == Phase::Stable {
            self.elliptic += area;
        }
        match (material, particles) {
            (_, Phase::Undefined) => self.undefined += area,
            (Phase::Stable, other) if other.is_unstable() => self.false_instability += area,
            (Phase::Unstable | Phase::Flutter, Phase::Stable) => {
                self.suppressed_instability += area
            }
            _ => {}
        }
    }
}

/// Chord directed towards increasing first parameter, with the phases below and above it.
#[derive(Clone, Copy)]
struct Piece {
    from: [f64; 2],
    to: [f64; 2],
    /// Boundary of the chord: 0 for the material, 1 for the particles.
    of: usize,
    below: Phase,
    above: Phase,
}

impl Piece {
    fn height(&self, x: f64) -> f64 {
        let t = (x - self.from[0]) / (self.to[0] - self.from[0]);
        self.from[1] + t * (self.to[1] - self.from[1])
    }

    /// First parameter of the intersection with another chord, if they intersect.
    fn crossing(&self, other: &Self) -> Option<f64> {
        let (low, high) = (self.from[0].max(other.from[0]), self.to[0].min(other.to[0]));
        let (a, b) = (
            self.height(low) - other.height(low),
            self.height(high) - other.height(high),
        );
        (a * b < 0.0).then(|| low + (high - low) * a / (a - b))
    }
}

/// Computes the areas, exactly for the polygons of two boundaries in the same window.
///
/// `phases` returns the phases of material and particles at a point. It is called where no curve determines them, or where two curves contradict each
/// other.
///
/// ```
/// use onset::verdict::Phase;
/// use onset::verdict::boundary::{Fineness, Window, trace_boundary};
/// use onset::verdict::fidelity::areas;
/// let window = Window { low: [-2.0, -2.0], high: [2.0, 2.0] };
/// let disc = |radius: f64| move |[x, y]: [f64; 2]| {
///     let measure = radius - x.hypot(y);
///     let phase = if measure > 0.0 { Phase::Stable } else { Phase::Unstable };
///     Ok::<_, std::convert::Infallible>((phase, measure))
/// };
/// let (material, particles) = (disc(1.5), disc(1.0));
/// let fineness = Fineness::default();
/// let boundaries = [
///     trace_boundary(window, &fineness, &material)?,
///     trace_boundary(window, &fineness, &particles)?,
/// ];
/// let phases = |at| Ok::<_, std::convert::Infallible>([material(at)?.0, particles(at)?.0]);
/// let areas = areas(window, [&boundaries[0], &boundaries[1]], &phases)?;
/// assert!((areas.false_share() - 1.25 / 2.25).abs() < 1e-4);
/// assert_eq!(areas.suppressed_instability, 0.0);
/// # Ok::<(), std::convert::Infallible>(())
/// ```
///
/// # Errors
/// Errors of `phases`.
pub fn areas<E>(
    window: Window,
    boundaries: [&Boundary; 2],
    phases: &dyn Fn([f64; 2]) -> Result<[Phase; 2], E>,
) -> Result<Areas, E> {
    let pieces = pieces(boundaries);
    let breaks = breaks(window, &pieces);
    let uncrossed = [0, 1].map(|of| uncrossed(window, &pieces, of));
    let middle = 0.5 * (window.low[1] + window.high[1]);
    let mut known: [Vec<Phase>; 2] = Default::default();
    for of in 0..2 {
        for [start, end] in &uncrossed[of] {
            known[of].push(phases([0.5 * (start + end), middle])?[of]);
        }
    }
    let alone = |x: f64, of: usize| {
        let strip = uncrossed[of]
            .iter()
            .position(|[start, end]| *start < x && x < *end);
        strip.map(|strip| known[of][strip])
    };
    let mut areas = Areas::default();
    let mut active: Vec<Piece> = Vec::new();
    let mut waiting = pieces.into_iter().peekable();
    for pair in breaks.windows(2) {
        let (start, end) = (pair[0], pair[1]);
        active.retain(|piece| piece.to[0] > start);
        while let Some(piece) = waiting.next_if(|piece| piece.from[0] <= start) {
            if piece.to[0] > start {
                active.push(piece);
            }
        }
        let center = 0.5 * (start + end);
        let mut crossed: Vec<(f64, Piece)> = active
            .iter()
            .map(|piece| (piece.height(center), *piece))
            .collect();
        sort_by_value(&mut crossed, |item| item.0);
        for n in 0..=crossed.len() {
            let low = n.checked_sub(1).map_or(window.low[1], |n| crossed[n].0);
            let high = crossed.get(n).map_or(window.high[1], |(y, _)| *y);
            let area = (high - low) * (end - start);
            if area <= 0.0 {
                continue;
            }
            let known = [0, 1].map(|of| alone(center, of).or_else(|| between(&crossed, n, of)));
            let here = match known {
                [Some(material), Some(particles)] => [material, particles],
                _ => {
                    let asked = phases([center, 0.5 * (low + high)])?;
                    [0, 1].map(|of| known[of].unwrap_or(asked[of]))
                }
            };
            areas.add(area, here);
        }
    }
    Ok(areas)
}

/// Strips that no chord of one boundary crosses. Their phase is evaluated in the middle, far from the chords, which enclose a slightly smaller area
/// than the curve.
fn uncrossed(window: Window, pieces: &[Piece], of: usize) -> Vec<[f64; 2]> {
    let (mut strips, mut reached) = (Vec::new(), window.low[0]);
    for piece in pieces.iter().filter(|piece| piece.of == of) {
        if piece.from[0] > reached {
            strips.push([reached, piece.from[0]]);
        }
        reached = reached.max(piece.to[0]);
    }
    if reached < window.high[0] {
        strips.push([reached, window.high[0]]);
    }
    strips
}

/// Phase below the `n`-th intersection, from the curves of one boundary on both sides; `None` if they contradict each other.
fn between(crossed: &[(f64, Piece)], n: usize, of: usize) -> Option<Phase> {
    let is_of = |(_, piece): &&(f64, Piece)| piece.of == of;
    let below = crossed[..n].iter().rev().find(is_of).map(|c| c.1.above);
    let above = crossed[n..].iter().find(is_of).map(|c| c.1.below);
    match (below, above) {
        (Some(below), Some(above)) => (below == above).then_some(below),
        (below, above) => below.or(above),
    }
}

/// Chords of both boundaries, sorted by the smaller first parameter.
fn pieces(boundaries: [&Boundary; 2]) -> Vec<Piece> {
    let mut pieces = Vec::new();
    for (of, boundary) in boundaries.into_iter().enumerate() {
        for curve in &boundary.curves {
            for pair in curve.vertices.windows(2) {
                let (a, b) = (pair[0].point, pair[1].point);
                let ends = if a[0] < b[0] {
                    (a, b, curve.right, curve.left)
                } else {
                    (b, a, curve.left, curve.right)
                };
                let (from, to, below, above) = ends;
                if from[0] < to[0] {
                    pieces.push(Piece {
                        from,
                        to,
                        of,
                        below,
                        above,
                    });
                }
            }
        }
    }
    sort_by_value(&mut pieces, |piece| piece.from[0]);
    pieces
}

/// First parameters at which a chord begins, ends or crosses another chord.
fn breaks(window: Window, pieces: &[Piece]) -> Vec<f64> {
    let mut breaks = vec![window.low[0], window.high[0]];
    let mut active: Vec<&Piece> = Vec::new();
    for piece in pieces {
        breaks.extend([piece.from[0], piece.to[0]]);
        active.retain(|other| other.to[0] > piece.from[0]);
        breaks.extend(active.iter().filter_map(|other| piece.crossing(other)));
        active.push(piece);
    }
    breaks.retain(|x| (window.low[0]..=window.high[0]).contains(x));
    breaks.sort_by(f64::total_cmp);
    breaks.dedup();
    breaks
}
