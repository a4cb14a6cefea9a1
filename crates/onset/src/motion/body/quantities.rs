//! Energies, momenta and extremes of a body.

use crate::algebra::array_of;

/// What a body has as a whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyQuantities {
    /// `sum m v^2 / 2` (with XSPH in all equations `sum m v . v_smoothed / 2`); energy (in one and two dimensions per unit of the dimensions that are left out, as all that follow).
    pub kinetic: f64,
    /// `sum V W(F)`, and the potential of contacts; energy. The penalty has no potential.
    pub strain: f64,
    /// What the grips have done; energy.
    pub work: f64,
    /// `sum m v`; mass length/time.
    pub momentum: [f64; 3],
    /// `sum m x * v` about the origin; mass length^2/time.
    pub angular_momentum: [f64; 3],
    /// The largest displacement of a particle; length.
    pub largest: f64,
    /// The smallest and the largest volume ratio of a particle.
    pub volume_ratios: [f64; 2],
}

/// A vector of the body in space.
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
    /// Those of no particle, with the energy of the strains and the work of the grips.
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

    /// Adds a particle: its mass, where it is, its displacement, its velocity with the one that moves it, and its volume ratio.
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
