//! View of particles: parallel projection of a line or a plane, perspective in 3D.

/// Direction of the eye in 3D, in degrees: azimuth about axis 3 from axis 1, and elevation above the plane of axes 1 and 2.
const AZIMUTH: f64 = -62.0;
const ELEVATION: f64 = 22.0;
/// Distance of the eye from the center, in radii of the set of particles.
const DISTANCE: f64 = 5.0;

/// Projection of points around a center.
pub(super) struct View {
    center: [f64; 3],
    /// Unit vectors that point right, up, and toward the eye.
    right: [f64; 3],
    up: [f64; 3],
    toward: [f64; 3],
    /// Distance of the eye; infinite for a parallel projection.
    distance: f64,
    /// Half the extent along the line of sight.
    depth: f64,
}

/// Point in the picture plane, with its magnification and distance.
#[derive(Clone, Copy)]
pub(super) struct Seen {
    /// Position in the picture.
    pub(super) at: (f64, f64),
    /// Magnification relative to the center.
    pub(super) scale: f64,
    /// Relative distance from the eye, from 0 (nearest) to 1 (farthest).
    pub(super) farness: f64,
}

impl View {
    /// Creates a view of points in the given number of dimensions.
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

    /// Projects a point into the picture plane.
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

    /// Projection of a coordinate axis at the center.
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
    fn nearer_points_are_magnified_and_the_axes_of_a_view_are_orthonormal() {
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
        // The third axis points upward, and a plane is shown without distortion.
        assert!(view.direction(2).1 > 0.9 && view.direction(2).0.abs() < 1e-15);
        let flat = View::of(&cube, 2);
        assert_eq!(flat.seen(&[0.25, 0.75, 0.0]).at, (0.25, 0.75));
    }
}
