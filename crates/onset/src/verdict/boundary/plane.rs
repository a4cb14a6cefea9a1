//! Vector algebra in the plane, in units of the window.

/// Point, or difference of two points.
pub(super) type Point = [f64; 2];

pub(super) fn plus(a: Point, scale: f64, b: Point) -> Point {
    [a[0] + scale * b[0], a[1] + scale * b[1]]
}

pub(super) fn minus(a: Point, b: Point) -> Point {
    plus(a, -1.0, b)
}

pub(super) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// Third component of `a x b`: positive if `b` points to the left of `a`.
pub(super) fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

pub(super) fn length(a: Point) -> f64 {
    a[0].hypot(a[1])
}

pub(super) fn distance(a: Point, b: Point) -> f64 {
    length(minus(a, b))
}

/// Vector turned to the left by a right angle.
pub(super) fn left_of(a: Point) -> Point {
    [-a[1], a[0]]
}

pub(super) fn unit(a: Point) -> Point {
    let size = length(a);
    [a[0] / size, a[1] / size]
}

pub(super) fn angle_of(a: Point) -> f64 {
    a[1].atan2(a[0])
}

pub(super) fn direction(angle: f64) -> Point {
    let (sine, cosine) = angle.sin_cos();
    [cosine, sine]
}

/// Angle reduced by full turns to `[-pi, pi]`.
pub(super) fn wrapped(angle: f64) -> f64 {
    let turns = (angle / std::f64::consts::TAU).round();
    angle - turns * std::f64::consts::TAU
}

/// Distance of a point from a segment.
pub(super) fn distance_to_piece(p: Point, (a, b): (Point, Point)) -> f64 {
    let along = minus(b, a);
    let square = dot(along, along);
    let t = if square > 0.0 {
        (dot(minus(p, a), along) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    distance(p, plus(a, t, along))
}

/// Signed curvature of the circle through three points, positive for a left turn.
pub(super) fn curvature(a: Point, b: Point, c: Point) -> f64 {
    let product = distance(a, b) * distance(b, c) * distance(a, c);
    if product > 0.0 {
        2.0 * cross(minus(b, a), minus(c, b)) / product
    } else {
        0.0
    }
}
