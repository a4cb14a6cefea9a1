//! Energies, momenta and extremes of a body.

use crate::algebra::array_of;

/// Global quantities of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyQuantities {
    /// Kinetic energy `sum m v^2 / 2`; energy (in 2D per unit thickness, in 1D per unit cross-section, as for all quantities below). With XSPH
    /// in all equations it is `sum m v . v_smoothed / 2`.
    pub kinetic: f64,
    /// Strain energy `sum V W(F)` plus the potential of contacts; energy. The penalty has no potential.
    pub strain: f64,
    /// Work of the grips on the body; energy.
    pub work: f64,
    /// Linear momentum `sum m v`; mass length/time.
    pub momentum: [f64; 3],
    /// Angular momentum `sum m x * v` about the origin; mass length^2/time.
    pub angular_momentum: [f64; 3],
    /// Largest displacement of a particle; length.
    pub largest: f64,
    /// Smallest and largest volume ratio of a particle.
    pub volume_ratios: [f64; 2],
}

/// Extends a vector of the body to three components.
pub(super) fn in_space<const D: usize>(x: &[f64; D]) -> [f64; 3] {
    array_of(|i| x.get(i).copied().unwrap_or(0.0))
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    array_of(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j] * b[k] - a[k] * b[j]
    })
}

impl BodyQuantities {
    /// Builds the quantities of a body without particles, with a given strain energy and work of the grips.
    pub(super) fn new(strain: f64, work: f64) -> Self {
        Self {
            kinetic: 0.0,
            strain,
            work,
            momentum: [0.0; 3],
            angular_momentum: [0.0; 3],
            largest: 0.0,
            volume_ratios: [f64::INFINITY, 0.0],
        }
    }

    /// Adds a particle, given by its mass, position, displacement, velocity, the velocity that moves it, and its volume ratio.
    pub(super) fn count<const D: usize>(
        &mut self,
        mass: f64,
        x: &[f64; D],
        u: &[f64; D],
        [v, moving]: [&[f64; D]; 2],
        volume: f64,
    ) {
        let dot = |a: &[f64; D], b: &[f64; D]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        self.kinetic += 0.5 * mass * dot(v, moving);
        self.largest = self.largest.max(dot(u, u).sqrt());
        for (all, v) in self.momentum.iter_mut().zip(v) {
            *all += mass * v;
        }
        let turning = cross(in_space(x), in_space(v));
        for (all, own) in self.angular_momentum.iter_mut().zip(turning) {
            *all += mass * own;
        }
        let [low, high] = self.volume_ratios;
        self.volume_ratios = [low.min(volume), high.max(volume)];
    }
}
