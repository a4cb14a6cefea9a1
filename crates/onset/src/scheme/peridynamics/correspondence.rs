//! Correspondence model: the family of a particle as a point with a nonlocal deformation gradient (Silling and others 2007).

use super::ZeroEnergyControl;
use super::family::Family;
use crate::algebra::{Each, array_of};
use crate::lattice::Particle;
use crate::real::Real;
use crate::scheme::{Interaction, Motion, PointResponse};
use nalgebra::SVector;

/// Particle with its family in a homogeneous state.
#[derive(Clone)]
pub(super) struct Point<'a, const D: usize> {
    family: &'a Family<D>,
    response: PointResponse<'a, D>,
    /// Gradients `w V_J K^-1 X_IJ`, with `F = F0 + sum (u_J - u_I) (x) gradient`.
    gradients: Vec<SVector<f64, D>>,
    /// Control with its coefficient multiplied by a modulus: by the bulk modulus for the penalty, by the micromodulus for hourglass forces.
    control: ZeroEnergyControl,
}

impl<'a, const D: usize> Point<'a, D> {
    pub(super) fn new(
        family: &'a Family<D>,
        response: PointResponse<'a, D>,
        control: ZeroEnergyControl,
    ) -> Self {
        let gradient = |n: &super::family::Neighbor<D>| {
            family.inverse_shape * n.vector * (n.influence * n.volume)
        };
        Self {
            gradients: family.neighbors.iter().map(gradient).collect(),
            family,
            response,
            control,
        }
    }

    /// Force of the zero-energy control on a bond, from the relative displacement of its ends and `F - F0`.
    fn controlled<R: Real>(&self, bond: usize, apart: &[R; D], change: &[[R; D]; D]) -> [R; D] {
        let neighbor = &self.family.neighbors[bond];
        let x = &neighbor.vector;
        // z = Y - F X = u_J - u_I - (F - F0) X
        let nonuniform = |i: usize| (0..D).fold(apart[i], |sum, j| sum - change[i][j] * x[j]);
        let z: [R; D] = array_of(nonuniform);
        match self.control {
            ZeroEnergyControl::None => [R::constant(0.0); D],
            ZeroEnergyControl::Penalty { coefficient } => {
                let weight = neighbor.influence * neighbor.volume / self.family.shape.trace();
                z.each(|z| z * (coefficient * weight))
            }
            ZeroEnergyControl::Hourglass { coefficient } => {
                let f = self.response.leading::<f64>();
                let deformed = |i: usize| (0..D).map(|j| f[i][j] * x[j]).sum::<f64>();
                let y: [R; D] = array_of(|i| apart[i] + deformed(i));
                let zero = R::constant(0.0);
                let squares = (0..D).fold(zero, |sum, i| sum + y[i] * y[i]);
                let along = (0..D).fold(zero, |sum, i| sum + y[i] * z[i]);
                let factor = along / squares * (coefficient * neighbor.volume / x.norm());
                y.each(|y| y * factor)
            }
        }
    }
}

impl<const D: usize> Interaction<D> for Point<'_, D> {
    fn particles(&self) -> &[Particle<D>] {
        &self.family.particles
    }

    fn forces<R: Real>(&self, motion: Motion<'_, R, D>) -> Vec<[R; D]> {
        let own = motion.displacements[0];
        let apart: Vec<[R; D]> = motion.displacements[1..]
            .iter()
            .map(|u| array_of(|i| u[i] - own[i]))
            .collect();
        let mut change = [[R::constant(0.0); D]; D];
        for (u, gradient) in apart.iter().zip(&self.gradients) {
            for i in 0..D {
                for j in 0..D {
                    change[i][j] = change[i][j] + u[i] * gradient[j];
                }
            }
        }
        let base = self.response.leading::<f64>();
        let f = array_of(|i| array_of(|j| change[i][j] + base[i][j]));
        let stress = self.response.first_piola(&f);
        let mut forces = vec![[R::constant(0.0); D]; apart.len() + 1];
        for (bond, gradient) in self.gradients.iter().enumerate() {
            let mut pull = self.controlled(bond, &apart[bond], &change);
            for i in 0..D {
                for j in 0..D {
                    pull[i] = pull[i] + stress[i][j] * gradient[j];
                }
                let force = pull[i] * self.family.volume;
                forces[0][i] = forces[0][i] + force;
                forces[bond + 1][i] = forces[bond + 1][i] - force;
            }
        }
        forces
    }
}
