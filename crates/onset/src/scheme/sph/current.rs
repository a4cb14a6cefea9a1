//! How particles with kernels of current coordinates act on each other in pairs, wherever they are.

use super::super::layout::{MovingWeight, Weighed};
use super::super::products::times_vector;
use super::super::stabilization::{Dashpot, Repulsion, Slope, SmoothedMotion, smoothing_share};
use super::updated::{DensityEvolution, MomentumForm};
use crate::algebra::{Each, array_of};
use crate::real::Real;

/// What a force between two particles takes of one of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Laden<R, const D: usize> {
    pub(crate) mass: f64,
    pub(crate) density: R,
    /// `s = P F^T / det F` within the dimensions of the lattice.
    pub(crate) stress: [[R; D]; D],
    /// The part of it that an artificial stress acts against, where there is one.
    pub(crate) tensile: Option<[[R; D]; D]>,
}

/// How particles with kernels of current coordinates act on each other in pairs, whoever sees whom: what bodies of them need to know. Kernels
/// and thresholds are those of a homogeneous state.
#[derive(Clone, Debug)]
pub struct CurrentPairs<const D: usize> {
    /// With the integral one.
    pub(super) weight: MovingWeight<D>,
    pub(super) momentum: MomentumForm,
    pub(super) density_evolution: DensityEvolution,
    pub(super) reference_density: f64,
    pub(super) is_corrected: bool,
    pub(super) repulsion: Option<Repulsion>,
    pub(super) dashpot: Option<Dashpot>,
    /// The coefficient of XSPH.
    pub(super) smoothing: f64,
    pub(super) smoothed_motion: SmoothedMotion,
}

impl<const D: usize> CurrentPairs<D> {
    /// The weight with the integral one at the vector from a particle to another.
    pub(crate) fn weigh<R: Real>(&self, x: &[R; D]) -> Weighed<R, D> {
        self.weight.at(x)
    }

    /// The part of a stress that an artificial stress acts against, where there is one.
    pub(crate) fn tensile<R: Real>(&self, stress: &[[R; D]; D]) -> Option<[[R; D]; D]> {
        self.repulsion.map(|r| r.tensile_part(stress))
    }

    /// Whether the force takes the density of the other particle beside that of the one whose stress it is.
    pub(super) fn takes_both_densities(&self) -> bool {
        match self.momentum {
            MomentumForm::Symmetric => false,
            MomentumForm::Mean | MomentumForm::Difference => true,
        }
    }

    /// `c_IJ s_I grad W_IJ`: what the stress of particle `I` takes from particle `J`, which is given by mass and density, and gives to itself or,
    /// by [`Self::taken`], takes from itself too.
    pub(crate) fn traction<R: Real>(
        &self,
        own: &Laden<R, D>,
        (other_mass, other_density): (f64, R),
        weight: &Weighed<R, D>,
    ) -> [R; D] {
        let other_density = match self.takes_both_densities() {
            false => own.density,
            true => other_density,
        };
        let coefficient = (own.density * other_density).recip() * (own.mass * other_mass);
        // grad W_IJ with respect to x_I is minus that along x_J - x_I.
        let gradient = weight.gradient.each(|slope| -slope * coefficient);
        let traction = times_vector(&own.stress, &gradient);
        let (Some(repulsion), Some(tensile)) = (&self.repulsion, &own.tensile) else {
            return traction;
        };
        let factor = repulsion.factor(weight.value);
        let less = times_vector(tensile, &gradient);
        array_of(|i| traction[i] - less[i] * factor)
    }

    /// The force on particle `I` itself of such a traction.
    pub(crate) fn taken<R: Real>(&self, traction: [R; D]) -> [R; D] {
        match self.momentum {
            MomentumForm::Difference => traction.each(|own| -own),
            MomentumForm::Symmetric | MomentumForm::Mean => traction,
        }
    }

    /// The viscous force on the first of two particles, from the vector to the other one, the difference of their velocities, masses and densities; zero without
    /// viscosity.
    pub(crate) fn viscous_force(
        &self,
        x: &[f64; D],
        v: &[f64; D],
        masses: [f64; 2],
        densities: [f64; 2],
    ) -> [f64; D] {
        self.dashpot.map_or([0.0; D], |dashpot| {
            let factor = dashpot.factor(masses, densities);
            dashpot.on_first(x, v, &Slope::Moving(self.weight), factor)
        })
    }

    /// Whether there is viscosity.
    pub(crate) fn is_viscous(&self) -> bool {
        self.dashpot.is_some()
    }

    /// Whether positions follow smoothed velocities.
    pub(crate) fn is_smoothed(&self) -> bool {
        self.smoothing > 0.0
    }

    /// Whether deformations and densities follow them too.
    pub(crate) fn smooths_everything(&self) -> bool {
        self.is_smoothed() && self.smoothed_motion == SmoothedMotion::Everything
    }

    /// The share of the velocity of another particle in the smoothed one.
    pub(crate) fn smoothing_share(&self, mass: f64, densities: [f64; 2], weight: f64) -> f64 {
        smoothing_share(self.smoothing, mass, densities, weight)
    }

    /// Whether densities are sums over positions.
    pub(crate) fn sums_densities(&self) -> bool {
        self.density_evolution == DensityEvolution::Summation
    }

    /// The reference density.
    pub(crate) fn reference_density(&self) -> f64 {
        self.reference_density
    }

    /// Whether velocity gradients are corrected to be exact for linear fields.
    pub(crate) fn is_corrected(&self) -> bool {
        self.is_corrected
    }

    /// The support radius, of vectors as [`Self::measured`]; length.
    pub(crate) fn radius(&self) -> f64 {
        self.weight.radius()
    }

    /// A place as the kernels measure it.
    pub(crate) fn measured(&self, x: &[f64; D]) -> [f64; D] {
        self.weight.measured(x)
    }
}
