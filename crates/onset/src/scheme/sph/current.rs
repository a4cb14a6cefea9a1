//! Pair forces of SPH with kernels in current coordinates, for particles at any positions.

use super::super::layout::{Measure, Measured, MovingWeight, Weighed};
use super::super::products::times_vector;
use super::super::stabilization::{Dashpot, Repulsion, SmoothedMotion, smoothing_share};
use super::updated::{DensityEvolution, MomentumForm};
use crate::algebra::{Each, array_of};
use crate::real::{LANES, Lanes, Real};

/// Contribution of one particle to a pair force, `f_I = sum_J (r_I T_J +- r_J T_I) grad W_IJ`.
///
/// Here `r = m`, `T = m s / rho^2` in the symmetric form and `r = m / rho`, `T = m s / rho` in the other forms, so that no division is needed per
/// pair.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Laden<R, const D: usize> {
    /// Factor `r` of the force.
    pub(crate) reach: R,
    /// Tensor `T`, with `s = P F^T / det F` within the dimensions of the lattice.
    pub(crate) tension: [[R; D]; D],
    /// Part of `T` that is reduced by an artificial stress, if any.
    pub(crate) tensile: Option<[[R; D]; D]>,
}

impl<R: Real, const D: usize> Laden<R, D> {
    /// Returns `T grad W` minus the artificial stress. For one pair this is the force divided by the factor `r` of the other particle; for several
    /// pairs the slopes are sums weighted by `r`.
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

/// Pair forces of particles with kernels in current coordinates and changing neighbors, as needed for finite bodies. Kernels and thresholds are
/// taken from a homogeneous state.
#[derive(Clone, Debug)]
pub struct CurrentPairs<const D: usize> {
    /// Kernel with unit integral.
    pub(super) weight: MovingWeight<D>,
    pub(super) momentum: MomentumForm,
    pub(super) density_evolution: DensityEvolution,
    pub(super) reference_density: f64,
    pub(super) is_corrected: bool,
    pub(super) corrects_forces: bool,
    pub(super) repulsion: Option<Repulsion>,
    pub(super) dashpot: Option<Dashpot>,
    /// Coefficient of XSPH, the velocity smoothing.
    pub(super) smoothing: f64,
    pub(super) smoothed_motion: SmoothedMotion,
}

impl<const D: usize> CurrentPairs<D> {
    /// Weight with unit integral at the vector from one particle to another.
    pub(crate) fn weigh<R: Real>(&self, x: &[R; D]) -> Weighed<R, D> {
        self.weight.at(x)
    }

    /// Metric tensor of the weights.
    pub(crate) fn measure(&self) -> Measure<D> {
        self.weight.measure()
    }

    /// Returns the weight of measured vectors.
    #[inline(always)]
    pub(crate) fn weigh_measured<R: Real>(&self, own: &Measured<R, D>) -> Weighed<R, D> {
        self.weight.weigh(own)
    }

    /// Returns true if there is an artificial stress.
    pub(crate) fn is_tensile(&self) -> bool {
        self.repulsion.is_some()
    }

    /// Returns the part of a stress that an artificial stress reduces, if there is an artificial stress.
    pub(crate) fn tensile<R: Real>(&self, stress: &[[R; D]; D]) -> Option<[[R; D]; D]> {
        self.repulsion.map(|r| r.tensile_part(stress))
    }

    /// Like [`Self::tensile`] for several stresses in lanes. Principal axes are computed for one stress at a time.
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

    /// Returns true if the force of a stress depends on the densities of both particles.
    pub(super) fn takes_both_densities(&self) -> bool {
        match self.momentum {
            MomentumForm::Symmetric => false,
            MomentumForm::Mean | MomentumForm::Difference => true,
        }
    }

    /// Returns true if the force of a stress depends on the densities of all neighbors, directly or through the correction.
    pub(super) fn takes_all_densities(&self) -> bool {
        self.takes_both_densities() || self.corrects_forces
    }

    /// Returns true if stresses act along corrected gradients.
    pub(crate) fn corrects_forces(&self) -> bool {
        self.corrects_forces
    }

    /// Contribution of a particle to pair forces, from its mass, density, stress and the tensile part of the stress ([`Self::tensile`]). If forces
    /// are corrected, the stress is already multiplied by the correction.
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

    /// Factor of the other particle in the force of a stress: `m`, or `m / rho`.
    pub(super) fn reach<R: Real>(&self, mass: R, density: R) -> R {
        match self.takes_both_densities() {
            false => mass,
            true => mass / density,
        }
    }

    /// Gradient `grad W_IJ` with respect to `x_I`, and this gradient times the factor of the artificial stress.
    #[inline(always)]
    pub(crate) fn slopes<R: Real>(&self, weight: &Weighed<R, D>) -> [[R; D]; 2] {
        // Negative gradient along x_J - x_I.
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

    /// Force on particle `I` due to a traction of its stress, with the sign of the form.
    #[inline(always)]
    pub(crate) fn taken<R: Real>(&self, traction: [R; D]) -> [R; D] {
        match self.momentum {
            MomentumForm::Difference => traction.each(|own| -own),
            MomentumForm::Symmetric | MomentumForm::Mean => traction,
        }
    }

    /// Viscous force on the first of two particles; zero without viscosity.
    ///
    /// The arguments are the vector to the other particle, the difference of the velocities, the weight, the masses and the densities.
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

    /// Returns true if there is viscosity.
    pub(crate) fn is_viscous(&self) -> bool {
        self.dashpot.is_some()
    }

    /// Returns true if positions follow smoothed velocities.
    pub(crate) fn is_smoothed(&self) -> bool {
        self.smoothing > 0.0
    }

    /// Returns true if deformations and densities also follow smoothed velocities.
    pub(crate) fn smooths_everything(&self) -> bool {
        self.is_smoothed() && self.smoothed_motion == SmoothedMotion::Everything
    }

    /// Weight of the velocity of another particle in the smoothed velocity.
    #[inline(always)]
    pub(crate) fn smoothing_share<R: Real>(&self, mass: R, densities: [R; 2], weight: R) -> R {
        smoothing_share(self.smoothing, mass, densities, weight)
    }

    /// Returns true if densities are sums over positions.
    pub(crate) fn sums_densities(&self) -> bool {
        self.density_evolution == DensityEvolution::Summation
    }

    pub(crate) fn reference_density(&self) -> f64 {
        self.reference_density
    }

    /// Returns true if velocity gradients are corrected to be exact for linear fields.
    pub(crate) fn is_corrected(&self) -> bool {
        self.is_corrected
    }

    /// Support radius of vectors as given by [`Self::measured`]; length.
    pub(crate) fn radius(&self) -> f64 {
        self.weight.radius()
    }

    /// Maps a position to the coordinates of the kernels.
    pub(crate) fn measured(&self, x: &[f64; D]) -> [f64; D] {
        self.weight.measured(x)
    }
}
