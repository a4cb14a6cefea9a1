//! How particles with kernels of current coordinates act on each other in pairs, wherever they are.

use super::super::layout::{Measure, Measured, MovingWeight, Weighed};
use super::super::products::times_vector;
use super::super::stabilization::{Dashpot, Repulsion, SmoothedMotion, smoothing_share};
use super::updated::{DensityEvolution, MomentumForm};
use crate::algebra::{Each, array_of};
use crate::real::{LANES, Lanes, Real};

/// What a force between two particles takes of one of them: `f_I = sum_J (r_I T_J +- r_J T_I) grad W_IJ` with `r = m`, `T = m s / rho^2` in the symmetric
/// form and `r = m / rho`, `T = m s / rho` in the others, so that nothing is divided for a pair.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Laden<R, const D: usize> {
    /// `r`.
    pub(crate) reach: R,
    /// `T`, with `s = P F^T / det F` within the dimensions of the lattice.
    pub(crate) tension: [[R; D]; D],
    /// The part of it that an artificial stress acts against, where there is one.
    pub(crate) tensile: Option<[[R; D]; D]>,
}

impl<R: Real, const D: usize> Laden<R, D> {
    /// `T grad W`, less the artificial stress: of one pair over the reach of the other particle, of several with the sums of their slopes times that.
    #[inline(always)]
    pub(crate) fn traction(&self, slopes: &[[R; D]; 2]) -> [R; D] {
        let traction = times_vector(&self.tension, &slopes[0]);
        let Some(tensile) = &self.tensile else {
            return traction;
        };
        let less = times_vector(tensile, &slopes[1]);
        array_of(|i| traction[i] - less[i])
    }
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
    pub(super) corrects_forces: bool,
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

    /// By what weights measure distances.
    pub(crate) fn measure(&self) -> Measure<D> {
        self.weight.measure()
    }

    /// The weight of what has been measured.
    #[inline(always)]
    pub(crate) fn weigh_measured<R: Real>(&self, own: &Measured<R, D>) -> Weighed<R, D> {
        self.weight.weigh(own)
    }

    /// Whether there is an artificial stress.
    pub(crate) fn is_tensile(&self) -> bool {
        self.repulsion.is_some()
    }

    /// The part of a stress that an artificial stress acts against, where there is one.
    pub(crate) fn tensile<R: Real>(&self, stress: &[[R; D]; D]) -> Option<[[R; D]; D]> {
        self.repulsion.map(|r| r.tensile_part(stress))
    }

    /// The same of several stresses: principal axes are found of one at a time.
    pub(crate) fn tensile_of_each(&self, stress: &[[Lanes; D]; D]) -> Option<[[Lanes; D]; D]> {
        let repulsion = self.repulsion.as_ref()?;
        let mut all = *stress;
        for lane in 0..LANES {
            let own = stress.each(|row| row.each(|entry| entry.0[lane]));
            let part = repulsion.tensile_part(&own);
            for i in 0..D {
                for j in 0..D {
                    all[i][j].0[lane] = part[i][j];
                }
            }
        }
        Some(all)
    }

    /// Whether the force takes the density of the other particle beside that of the one whose stress it is.
    pub(super) fn takes_both_densities(&self) -> bool {
        match self.momentum {
            MomentumForm::Symmetric => false,
            MomentumForm::Mean | MomentumForm::Difference => true,
        }
    }

    /// Whether the force of a stress takes the densities of all others: in itself, or in the correction.
    pub(super) fn takes_all_densities(&self) -> bool {
        self.takes_both_densities() || self.corrects_forces
    }

    /// Whether stresses act along corrected gradients.
    pub(crate) fn corrects_forces(&self) -> bool {
        self.corrects_forces
    }

    /// What forces take of a particle of so much mass, with a density and a stress, corrected where forces are, of which a part is [`Self::tensile`].
    pub(crate) fn laden<R: Real>(
        &self,
        mass: R,
        density: R,
        stress: &[[R; D]; D],
        tensile: Option<[[R; D]; D]>,
    ) -> Laden<R, D> {
        let reach = self.reach(mass, density);
        let factor = match self.momentum {
            MomentumForm::Symmetric => mass / (density * density),
            MomentumForm::Mean | MomentumForm::Difference => reach,
        };
        let times = |own: &[[R; D]; D]| own.each(|row| row.each(|entry| entry * factor));
        Laden {
            reach,
            tension: times(stress),
            tensile: tensile.as_ref().map(times),
        }
    }

    /// What a stress takes of another particle: `m`, or `m / rho`.
    pub(super) fn reach<R: Real>(&self, mass: R, density: R) -> R {
        match self.takes_both_densities() {
            false => mass,
            true => mass / density,
        }
    }

    /// `grad W_IJ` with respect to `x_I`, and the same times the factor of the artificial stress.
    #[inline(always)]
    pub(crate) fn slopes<R: Real>(&self, weight: &Weighed<R, D>) -> [[R; D]; 2] {
        // Minus that along x_J - x_I.
        let slope = weight.gradient.each(|slope| -slope);
        let less = match &self.repulsion {
            None => [R::constant(0.0); D],
            Some(repulsion) => {
                let factor = repulsion.factor(weight.value);
                slope.each(|slope| slope * factor)
            }
        };
        [slope, less]
    }

    /// The force on particle `I` itself of such a traction.
    #[inline(always)]
    pub(crate) fn taken<R: Real>(&self, traction: [R; D]) -> [R; D] {
        match self.momentum {
            MomentumForm::Difference => traction.each(|own| -own),
            MomentumForm::Symmetric | MomentumForm::Mean => traction,
        }
    }

    /// The viscous force on the first of two particles, from the vector to the other one, the difference of their velocities, the weight, masses and densities; zero
    /// without viscosity.
    #[inline(always)]
    pub(crate) fn viscous_force<R: Real>(
        &self,
        x: &[R; D],
        v: &[R; D],
        weight: &Weighed<R, D>,
        masses: [R; 2],
        densities: [R; 2],
    ) -> [R; D] {
        self.dashpot.map_or([R::constant(0.0); D], |dashpot| {
            let factor = dashpot.factor(masses, densities);
            let along = dashpot.along(x, v, &weight.gradient);
            along.each(|force| force * factor)
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
    #[inline(always)]
    pub(crate) fn smoothing_share<R: Real>(&self, mass: R, densities: [R; 2], weight: R) -> R {
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
