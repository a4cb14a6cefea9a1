//! Rigid motions of groups of particles.

use nalgebra::{Matrix3, Vector3};

/// Rigid motion of a group of particles, `x = R (X - a) + b`.
pub(super) struct RigidMotion {
    rotation: Matrix3<f64>,
    from: Vector3<f64>,
    to: Vector3<f64>,
}

fn mean(particles: &[usize], x: &[[f64; 3]]) -> Vector3<f64> {
    let sum: Vector3<f64> = particles.iter().map(|n| Vector3::from(x[*n])).sum();
    sum / particles.len().max(1) as f64
}

impl RigidMotion {
    /// Motion that fits some particles best, in the sense of least squares (Kabsch, Acta Cryst. A 32 (1976) 922).
    pub(super) fn fitted(
        particles: &[usize],
        from: &[[f64; 3]],
        to: &[[f64; 3]],
        dimension: usize,
    ) -> Option<Self> {
        let (start, end) = (mean(particles, from), mean(particles, to));
        let mut moment = Matrix3::zeros();
        for n in particles {
            let (from, to) = (Vector3::from(from[*n]) - start, Vector3::from(to[*n]) - end);
            moment += to * from.transpose();
        }
        // In the plane the rotation leaves the third axis unchanged.
        let scale = moment.norm().max(f64::MIN_POSITIVE);
        for axis in dimension..3 {
            moment[(axis, axis)] = scale;
        }
        let parts = moment.svd(true, true);
        let (u, v) = (parts.u?, parts.v_t?);
        let sign = (u * v).determinant().signum();
        let least = parts.singular_values.imin();
        let mut signs = Vector3::repeat(1.0);
        signs[least] = sign;
        Some(Self {
            rotation: u * Matrix3::from_diagonal(&signs) * v,
            from: start,
            to: end,
        })
    }

    /// Distance of the moved position of a particle from its position after the motion.
    pub(super) fn distance(&self, from: &[f64; 3], to: &[f64; 3]) -> f64 {
        let moved = self.rotation * (Vector3::from(*from) - self.from) + self.to;
        (Vector3::from(*to) - moved).norm()
    }
}

#[cfg(test)]
mod tests {
    use super::RigidMotion;

    #[test]
    fn rotations_are_found_from_a_row_of_particles_and_hold_for_all_others() {
        let (sine, cosine) = 2.0_f64.sin_cos();
        let from: Vec<[f64; 3]> = (0..20)
            .map(|n| [f64::from(n / 5), f64::from(n % 5), 0.0])
            .collect();
        let to: Vec<[f64; 3]> = from
            .iter()
            .map(|[x, y, _]| {
                [
                    cosine * x - sine * y + 3.0,
                    sine * x + cosine * y - 7.0,
                    0.0,
                ]
            })
            .collect();
        let row: Vec<usize> = (0..5).collect();
        let motion = RigidMotion::fitted(&row, &from, &to, 2).expect("a motion");
        assert!((0..20).all(|n| motion.distance(&from[n], &to[n]) < 1e-12));
        let mirrored: Vec<[f64; 3]> = from.iter().map(|[x, y, _]| [*y, *x, 0.0]).collect();
        let motion = RigidMotion::fitted(&row, &from, &mirrored, 2).expect("a motion");
        assert!(motion.distance(&from[19], &mirrored[19]) > 1.0);
    }
}
