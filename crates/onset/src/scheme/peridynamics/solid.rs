//! The linear peridynamic solid, an ordinary state-based model (Silling and others 2007).

use super::family::{Family, Neighbor};
use crate::algebra::{Each, array_of};
use crate::bloch::BlochBlocks;
use crate::kinematics::DeformationGradient;
use crate::lattice::Particle;
use crate::real::Real;
use crate::scheme::moduli::Moduli;
use crate::scheme::{Interaction, Motion};
use nalgebra::{SMatrix, SVector};

/// Family of a particle in a homogeneous state, with the energy `V_I (kappa theta^2 / 2 + D (D + 2) mu / (2 m) sum w V e_d^2)`.
///
/// Here `e = |y| - r` is the elongation of a bond, `m = sum w r^2 V`, `theta = D/m sum w r e V` the dilatation and `e_d = e - theta r / D`.
#[derive(Clone, Debug)]
pub(super) struct Solid<'a, const D: usize> {
    family: &'a Family<D>,
    /// Deformed bonds `F X_IJ`; length.
    deformed: Vec<SVector<f64, D>>,
    moduli: Moduli,
}

impl<'a, const D: usize> Solid<'a, D> {
    pub(super) fn new(family: &'a Family<D>, moduli: Moduli, f: &DeformationGradient) -> Self {
        let f = f.leading::<D>();
        Self {
            deformed: family.neighbors.iter().map(|n| f * n.vector).collect(),
            family,
            moduli,
        }
    }
}

impl<const D: usize> Solid<'_, D> {
    /// Weighted volume `m = sum w r^2 V` of the family; length^(D+2).
    fn weighted_volume(&self) -> f64 {
        self.family.shape.trace()
    }

    /// Dilatation of the family with the given lengths of its bonds.
    fn dilatation<R: Real>(&self, lengths: impl Iterator<Item = R>) -> R {
        let factor = D as f64 / self.weighted_volume();
        let bonds = lengths.zip(&self.family.neighbors);
        bonds.fold(R::constant(0.0), |sum, (length, n)| {
            let r = n.vector.norm();
            sum + (length - r) * (factor * n.influence * n.volume * r)
        })
    }

    /// Tension of a bond, to be multiplied by [`Self::scale`].
    fn tension<R: Real>(&self, n: &Neighbor<D>, length: R, dilatation: R) -> R {
        let (d, r) = (D as f64, n.vector.norm());
        let deviatoric = length - r - dilatation * (r / d);
        dilatation * (d * self.moduli.bulk * r) + deviatoric * self.stiffness()
    }

    /// Derivative of the tension of a bond with respect to its length, at constant dilatation.
    fn stiffness(&self) -> f64 {
        (D * (D + 2)) as f64 * self.moduli.shear
    }

    /// Weight `w V_I V_J / m` of a bond.
    fn scale(&self, n: &Neighbor<D>) -> f64 {
        self.family.volume * n.volume * n.influence / self.weighted_volume()
    }
}

impl<const D: usize> Interaction<D> for Solid<'_, D> {
    fn particles(&self) -> &[Particle<D>] {
        &self.family.particles
    }

    fn forces<R: Real>(&self, motion: Motion<'_, R, D>) -> Vec<[R; D]> {
        let own = motion.displacements[0];
        let bonds: Vec<([R; D], R)> = motion.displacements[1..]
            .iter()
            .zip(&self.deformed)
            .map(|(u, deformed)| {
                let y: [R; D] = array_of(|i| u[i] - own[i] + deformed[i]);
                let squares = y.iter().fold(R::constant(0.0), |sum, x| sum + *x * *x);
                (y, squares.sqrt())
            })
            .collect();
        let dilatation = self.dilatation(bonds.iter().map(|bond| bond.1));
        let mut forces = vec![[R::constant(0.0); D]; bonds.len() + 1];
        for (number, ((y, length), n)) in bonds.iter().zip(&self.family.neighbors).enumerate() {
            let tension = self.tension(n, *length, dilatation);
            let pull = y.each(|x| x * tension / *length * self.scale(n));
            forces[number + 1] = pull.each(|x| -x);
            forces[0] = array_of(|i| forces[0][i] + pull[i]);
        }
        forces
    }

    /// Adds springs along and across the bonds, and the coupling of all bonds by the dilatation.
    fn add_stiffness(&self, blocks: &mut BlochBlocks<D>) {
        let (d, mut sums) = (D as f64, blocks.between(&self.family.particles));
        let lengths = self.deformed.iter().map(SVector::norm);
        let dilatation = self.dilatation(lengths);
        // Gradient of the dilatation with respect to the particles, times `V_I / d`.
        let mut gradients = vec![SVector::zeros(); self.family.particles.len()];
        for (number, (y, n)) in self.deformed.iter().zip(&self.family.neighbors).enumerate() {
            let (length, scale, other) = (y.norm(), self.scale(n), number + 1);
            let direction = y / length;
            let across = scale * self.tension(n, length, dilatation) / length;
            let along = scale * self.stiffness() - across;
            let spring = SMatrix::identity() * across + direction * direction.transpose() * along;
            for (from, to, sign) in [
                (0, 0, 1.0),
                (0, other, -1.0),
                (other, 0, -1.0),
                (other, other, 1.0),
            ] {
                sums.add(from, to, &(spring * sign));
            }
            let gradient = direction * (scale * n.vector.norm());
            gradients[other] += gradient;
            gradients[0] -= gradient;
        }
        // Derivative of the tension with respect to the dilatation, over the length of the bond.
        let coupling = d * self.moduli.bulk - self.stiffness() / d;
        for (from, a) in gradients.iter().enumerate() {
            let a = a * (coupling * d / self.family.volume);
            for (to, b) in gradients.iter().enumerate() {
                sums.add(from, to, &(a * b.transpose()));
            }
        }
        sums.finish();
    }
}
