//! How particles are seen: those of a line or a plane as they lie, those of space in perspective.

/// Where the eye is, in space: turned so far around the third axis from the first, and so far above the plane of the first two; degrees.
const AZIMUTH: f64 = -62.0;
const ELEVATION: f64 = 22.0;
/// Distance of the eye from the center, in radii of what is seen.
const DISTANCE: f64 = 5.0;

/// A view of places around a center.
pub(super) struct View {
    center: [f64; 3],
    /// Directions in three dimensions that point rightward, upward, and to the eye.
    right: [f64; 3],
    up: [f64; 3],
    toward: [f64; 3],
    /// The distance of the eye; infinite where nothing is shortened.
    distance: f64,
    /// Half the extent along the line of sight.
    depth: f64,
}

/// A place as it is seen.
#[derive(Clone, Copy)]
pub(super) struct Seen {
    /// Its place in the picture.
    pub(super) at: (f64, f64),
    /// How much larger than in the middle things look there.
    pub(super) scale: f64,
    /// From 0, the nearest, to 1, the farthest.
    pub(super) farness: f64,
}

impl View {
    /// A view of places in some dimensions.
    pub(super) fn of(places: &[[f64; 3]], dimension: usize) -> Self {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        if dimension < 3 || places.is_empty() {
            return Self {
                center: [0.0; 3],
                right: axes[0],
                up: axes[1],
                toward: axes[2],
                distance: f64::INFINITY,
                depth: 1.0,
            };
        }
        let count = places.len() as f64;
        let center = std::array::from_fn(|i| places.iter().map(|x| x[i]).sum::<f64>() / count);
        let radius = places
            .iter()
            .map(|x| norm(&less(x, &center)))
            .fold(0.0, f64::max);
        let radius = radius.max(f64::MIN_POSITIVE);
        let ((sa, ca), (se, ce)) = (
            AZIMUTH.to_radians().sin_cos(),
            ELEVATION.to_radians().sin_cos(),
        );
        Self {
            center,
            right: [-sa, ca, 0.0],
            up: [-ca * se, -sa * se, ce],
            toward: [ca * ce, sa * ce, se],
            distance: DISTANCE * radius,
            depth: radius,
        }
    }

    /// A place as it is seen.
    pub(super) fn seen(&self, x: &[f64; 3]) -> Seen {
        let x = less(x, &self.center);
        let near = dot(&x, &self.toward);
        let scale = if self.distance.is_finite() {
            self.distance / (self.distance - near)
        } else {
            1.0
        };
        Seen {
            at: (scale * dot(&x, &self.right), scale * dot(&x, &self.up)),
            scale,
            farness: (0.5 * (1.0 - near / self.depth)).clamp(0.0, 1.0),
        }
    }

    /// A direction as it is seen in the middle.
    pub(super) fn direction(&self, axis: usize) -> (f64, f64) {
        (self.right[axis], self.up[axis])
    }
}

fn less(x: &[f64; 3], y: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| x[i] - y[i])
}

fn dot(x: &[f64; 3], y: &[f64; 3]) -> f64 {
    (0..3).map(|i| x[i] * y[i]).sum()
}

fn norm(x: &[f64; 3]) -> f64 {
    dot(x, x).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_nearer_looks_larger_and_the_directions_of_a_view_are_orthonormal() {
        let cube: Vec<[f64; 3]> = (0..8)
            .map(|n| [0, 1, 2].map(|axis| f64::from(n >> axis & 1)))
            .collect();
        let view = View::of(&cube, 3);
        for (a, b, expected) in [
            (&view.right, &view.up, 0.0),
            (&view.right, &view.toward, 0.0),
            (&view.up, &view.toward, 0.0),
            (&view.up, &view.up, 1.0),
        ] {
            assert!((dot(a, b) - expected).abs() < 1e-15);
        }
        let seen: Vec<Seen> = cube.iter().map(|x| view.seen(x)).collect();
        for a in &seen {
            for b in &seen {
                assert_eq!(a.farness < b.farness, a.scale > b.scale);
            }
        }
        // The third axis points upward, and the plane is seen as it is.
        assert!(view.direction(2).1 > 0.9 && view.direction(2).0.abs() < 1e-15);
        let flat = View::of(&cube, 2);
        assert_eq!(flat.seen(&[0.25, 0.75, 0.0]).at, (0.25, 0.75));
    }
}
