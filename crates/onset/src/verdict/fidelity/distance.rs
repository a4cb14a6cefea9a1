//! Hausdorff distance of polygons.

use crate::algebra::Each;

type Point = [f64; 2];
type Piece = (Point, Point);

/// Distance of one set of curves from another, and the point where it is attained.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// Largest distance of a point of the first set from the nearest point of the second.
    pub distance: f64,
    /// Point of the first set at this distance.
    pub at: [f64; 2],
}

/// Largest distance of a point on the polygons `from` to the polygons `to`, `sup_a inf_b |a - b|`, with an error of at most `tolerance`.
///
/// The Hausdorff distance is the larger of the two directed distances. Each chord is bisected until the distances of its ends bound the distances of
/// all its points: the distance from one segment is largest at an end. `None` if one set is empty.
///
/// ```
/// use onset::verdict::fidelity::directed_distance;
/// let roof = [vec![[0.0, 0.0], [1.0, 1.0], [2.0, 0.0]]];
/// let floor = [vec![[0.0, 0.0], [2.0, 0.0]]];
/// let up = directed_distance(&floor, &roof, 1e-12).unwrap();
/// assert!((up.distance - 0.5_f64.sqrt()).abs() < 1e-12 && (up.at[0] - 1.0).abs() < 1e-6);
/// assert_eq!(directed_distance(&roof, &floor, 1e-12).unwrap().distance, 1.0);
/// ```
pub fn directed_distance(
    from: &[Vec<[f64; 2]>],
    to: &[Vec<[f64; 2]>],
    tolerance: f64,
) -> Option<Distance> {
    let targets: Vec<Piece> = pieces(to);
    let mut best: Option<Distance> = None;
    let raise = |best: &mut Option<Distance>, distance: f64, at: Point| {
        if best.is_none_or(|found| distance > found.distance) {
            *best = Some(Distance { distance, at });
        }
    };
    if targets.is_empty() {
        return None;
    }
    for piece in pieces(from) {
        let mut open = vec![(
            piece,
            nearest(piece.0, &targets),
            nearest(piece.1, &targets),
        )];
        while let Some((piece, first, last)) = open.pop() {
            raise(&mut best, first.1, piece.0);
            raise(&mut best, last.1, piece.1);
            let bound = |target: usize| {
                let target = targets[target];
                distance(piece.0, target).max(distance(piece.1, target))
            };
            let reached = best.map_or(0.0, |found| found.distance);
            if bound(first.0).min(bound(last.0)) <= reached + tolerance {
                continue;
            }
            let middle = [0, 1].each(|i| 0.5 * (piece.0[i] + piece.1[i]));
            let between = nearest(middle, &targets);
            open.push(((piece.0, middle), first, between));
            open.push(((middle, piece.1), between, last));
        }
    }
    best
}

fn pieces(polygons: &[Vec<Point>]) -> Vec<Piece> {
    let of_one = |points: &Vec<Point>| {
        let pairs: Vec<Piece> = points.windows(2).map(|pair| (pair[0], pair[1])).collect();
        pairs
    };
    polygons.iter().flat_map(of_one).collect()
}

/// Nearest segment and its distance.
fn nearest(p: Point, targets: &[Piece]) -> (usize, f64) {
    let distances = targets.iter().map(|target| distance(p, *target));
    distances
        .enumerate()
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap_or((0, f64::INFINITY))
}

fn distance(p: Point, (a, b): Piece) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let off = [p[0] - a[0], p[1] - a[1]];
    let square = along[0] * along[0] + along[1] * along[1];
    let t = if square > 0.0 {
        ((off[0] * along[0] + off[1] * along[1]) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (off[0] - t * along[0]).hypot(off[1] - t * along[1])
}
