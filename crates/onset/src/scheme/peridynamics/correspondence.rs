//! Correspondence models: points with nonlocal deformation gradients, one for each family or one for each bond.

use super::ZeroEnergyControl;
use super::family::{Family, balanced};
use crate::algebra::{Each, array_of};
use crate::lattice::{Crystal, Particle};
use crate::material::FourthOrder;
use crate::method::MethodError;
use crate::real::Real;
use crate::scheme::lagrangian::{LagrangianPoint, Stressed, add_gradients_of_bond};
use crate::scheme::moduli::trace;
use crate::scheme::{Interaction, Motion, StrainOperator};
use nalgebra::{SMatrix, SVector};
use std::collections::BTreeMap;

/// Returns the point of a family, with the gradients `w V_J K^-1 X_IJ` (Silling and others 2007).
///
/// Without weighted forces the force is `P K^-1 X_IJ` and lacks the influence function.
pub(super) fn of_family<const D: usize>(
    family: &Family<D>,
    has_weighted_forces: bool,
) -> LagrangianPoint<D> {
    let (gradients, vectors) = family.gradients();
    let point = LagrangianPoint::new(
        family.particles.iter().copied().zip(gradients),
        family.volume,
    );
    if has_weighted_forces {
        return point;
    }
    let volumes = family.neighbors.iter().map(|n| n.volume);
    let others = volumes
        .zip(&vectors[1..])
        .map(|(volume, x)| family.inverse_shape * x * volume);
    point.with_forces_along(balanced(others))
}

/// Returns the points of the bonds of a family. The deformation gradient of a bond is computed from the neighbors that also belong to the family of
/// its other end (Chen 2018).
///
/// The energy of a family is the mean over its bonds, weighted with the volumes of their neighborhoods. Pairwise forces act on the ends of the bond
/// alone.
///
/// # Errors
/// [`MethodError::HorizonTooSmall`] if the neighbors of a bond do not span the space.
pub(super) fn of_bonds<const D: usize>(
    family: &Family<D>,
    horizon: f64,
    is_pairwise: bool,
) -> Result<Vec<LagrangianPoint<D>>, MethodError> {
    let near: Vec<_> = family
        .neighbors
        .iter()
        .map(|end| family.near(&end.vector, horizon))
        .collect::<Result<_, _>>()?;
    let of_family = family.volume_of_neighbors();
    let total: f64 = near.iter().map(Family::volume_of_neighbors).sum();
    let points = family.neighbors.iter().zip(near).map(|(end, near)| {
        let (gradients, _) = near.gradients();
        let seen = near.particles.iter().copied().zip(gradients);
        let share = near.volume_of_neighbors();
        if !is_pairwise {
            return LagrangianPoint::new(seen, family.volume * share / total);
        }
        let pull =
            near.inverse_shape * end.vector * (end.influence * end.volume * share / of_family);
        let others = near
            .neighbors
            .iter()
            .map(|n| match n.particle == end.particle {
                true => pull,
                false => SVector::zeros(),
            });
        let along = balanced(others);
        LagrangianPoint::new(seen, family.volume).with_forces_along(along)
    });
    Ok(points.collect())
}

/// Returns a point for each bond, with the mean deformation gradient of the families at its ends, corrected along the bond (Breitzman and Dayal 2018).
pub(super) fn between_families<const D: usize>(
    families: &[Family<D>],
    crystal: &Crystal<D>,
) -> Vec<LagrangianPoint<D>> {
    let means: Vec<_> = families
        .iter()
        .map(|family| of_family(family, true))
        .collect();
    let weights: Vec<f64> = families
        .iter()
        .map(|family| {
            family
                .neighbors
                .iter()
                .map(|n| n.influence * n.volume)
                .sum()
        })
        .collect();
    let mut points = Vec::new();
    for (site, family) in families.iter().enumerate() {
        for bond in family.bonds(crystal, site).filter(|bond| bond.weight > 0.0) {
            let ends = bond.particles.each_ref().map(|end| (end, &means[end.site]));
            let mut seen = BTreeMap::new();
            add_gradients_of_bond(ends, &bond.vector, 1.0, &mut seen);
            let shares = bond.particles.each(|end| bond.weight / weights[end.site]);
            points.push(LagrangianPoint::new(seen, shares.iter().sum()));
        }
    }
    points
}

/// Strains of bonds with stresses that act: the strain of each bond, times `1 - exp(i k.X_IJ)` for a wave.
///
/// The force of a bond acts on its ends with opposite signs. The forces on a wave that displaces both ends equally cancel, although the wave may
/// strain the bond. The product is the strain of the bond minus the strain of the bond moved by `X_IJ`. This form requires that both ends are
/// equivalent particles; otherwise only the strain is used.
pub(super) fn acting_strains<const D: usize>(points: &[LagrangianPoint<D>]) -> StrainOperator<D> {
    let mut strain = StrainOperator::new();
    for point in points {
        let mut seen: BTreeMap<Particle<D>, SVector<f64, D>> = BTreeMap::new();
        let far_end = point.far_end();
        let shift = far_end.filter(|end| end.site == point.particles()[0].site);
        for (particle, gradient) in point.particles().iter().zip(point.gradients()) {
            *seen.entry(*particle).or_insert_with(SVector::zeros) += gradient;
            if let Some(end) = shift {
                let moved = particle.moved(&end.cell);
                *seen.entry(moved).or_insert_with(SVector::zeros) -= gradient;
            }
        }
        let (particles, gradients): (Vec<_>, Vec<_>) = seen.into_iter().unzip();
        strain.add_strain(&particles, gradients);
    }
    strain
}

/// Forces of a zero-energy control on the bonds of a family, as functions of the nonuniform part `z = Y - F X` of the deformation.
#[derive(Clone)]
pub(super) enum Control<const D: usize> {
    /// Springs `w V S z`, or `V S z` without weights, with a matrix `S` for each family; stress/length^(D+2).
    Springs {
        stiffness: SMatrix<f64, D, D>,
        is_weighted: bool,
    },
    /// Forces `c V (z.e) e / r` along the deformed bond, with the direction `e` and a micromodulus `c`.
    Along(f64),
}

impl<const D: usize> Control<D> {
    /// Returns the control of a family; `None` without a control. The tangent belongs to the reference state, and `ball` returns the integral of the
    /// length over the ball of the horizon.
    pub(super) fn new(
        control: ZeroEnergyControl,
        family: &Family<D>,
        tangent: &FourthOrder,
        ball: impl Fn() -> f64,
        is_weighted: bool,
    ) -> Option<Self> {
        let springs = |stiffness| Self::Springs {
            stiffness,
            is_weighted,
        };
        match control {
            ZeroEnergyControl::None => None,
            ZeroEnergyControl::Penalty { coefficient } => {
                let bulk = trace::<D>(tangent) / (D * D) as f64;
                let spring = coefficient * bulk / family.shape.trace();
                Some(springs(SMatrix::identity() * spring))
            }
            ZeroEnergyControl::StiffnessTensor { coefficient } => {
                let contracted = SMatrix::from_fn(|i, j| {
                    let entries = (0..D).flat_map(|k| (0..D).map(move |l| (k, l)));
                    entries
                        .map(|(k, l)| tangent[(i, j, k, l)] * family.inverse_shape[(k, l)])
                        .sum()
                });
                Some(springs(contracted * coefficient))
            }
            ZeroEnergyControl::Hourglass { coefficient } => Some(Self::Along(
                coefficient * 2.0 * trace::<D>(tangent) / ball(),
            )),
        }
    }
}

/// Control of the zero-energy modes of a family in a homogeneous state.
#[derive(Clone)]
pub(super) struct Controlled<'a, const D: usize> {
    /// Point with the deformation gradient of the family.
    pub(super) stressed: Stressed<'a, D>,
    pub(super) control: Control<D>,
    pub(super) family: &'a Family<D>,
}

impl<const D: usize> Interaction<D> for Controlled<'_, D> {
    fn particles(&self) -> &[Particle<D>] {
        self.stressed.particles()
    }

    fn forces<R: Real>(&self, motion: Motion<'_, R, D>) -> Vec<[R; D]> {
        let family = self.family;
        let own = motion.displacements[0];
        let change = self.stressed.change(motion.displacements);
        let base = self.stressed.base();
        let mut forces = vec![[R::constant(0.0); D]; family.particles.len()];
        for (number, neighbor) in family.neighbors.iter().enumerate() {
            let x = &neighbor.vector;
            let u = motion.displacements[number + 1];
            let apart: [R; D] = array_of(|i| u[i] - own[i]);
            // Nonuniform deformation z = Y - F X = u_J - u_I - (F - F0) X.
            let nonuniform = |i: usize| (0..D).fold(apart[i], |sum, j| sum - change[i][j] * x[j]);
            let z: [R; D] = array_of(nonuniform);
            let zero = R::constant(0.0);
            let pull: [R; D] = match &self.control {
                Control::Springs {
                    stiffness,
                    is_weighted,
                } => {
                    let weight = if *is_weighted {
                        neighbor.influence
                    } else {
                        1.0
                    };
                    let scale = weight * neighbor.volume;
                    array_of(|i| {
                        (0..D).fold(zero, |sum, j| sum + z[j] * (stiffness[(i, j)] * scale))
                    })
                }
                Control::Along(micromodulus) => {
                    let deformed = |i: usize| (0..D).map(|j| base[i][j] * x[j]).sum::<f64>();
                    let y: [R; D] = array_of(|i| apart[i] + deformed(i));
                    let squares = (0..D).fold(zero, |sum, i| sum + y[i] * y[i]);
                    let along = (0..D).fold(zero, |sum, i| sum + y[i] * z[i]);
                    let factor = along / squares * (micromodulus * neighbor.volume / x.norm());
                    y.each(|y| y * factor)
                }
            };
            let force = pull.each(|x| x * family.volume);
            forces[0] = array_of(|i| forces[0][i] + force[i]);
            forces[number + 1] = force.each(|x| -x);
        }
        forces
    }
}

/// Stress of a correspondence model, or its control of zero-energy modes.
#[derive(Clone)]
pub(super) enum Point<'a, const D: usize> {
    Stressed(Stressed<'a, D>),
    Controlled(Controlled<'a, D>),
}

impl<const D: usize> Interaction<D> for Point<'_, D> {
    fn particles(&self) -> &[Particle<D>] {
        match self {
            Self::Stressed(point) => point.particles(),
            Self::Controlled(family) => family.particles(),
        }
    }

    fn forces<R: Real>(&self, motion: Motion<'_, R, D>) -> Vec<[R; D]> {
        match self {
            Self::Stressed(point) => point.forces(motion),
            Self::Controlled(family) => family.forces(motion),
        }
    }
}
