//! The kernel methods of [`crate::method`] among the schemes.

use super::{PeriodicPatch, Scheme, SeenForm, StrainOperator};
use crate::approximation::Order;
use crate::bloch::{BlochBlocks, Mass, WaveSystem, dynamical_matrix};
use crate::kinematics::DeformationGradient;
use crate::lattice::{Crystal, Particle};
use crate::material::Hyperelastic;
use crate::method::{Method, MethodError};
use nalgebra::SVector;

impl<const D: usize> Scheme<D> for Method<D> {
    fn crystal(&self) -> &Crystal<D> {
        Method::crystal(self)
    }

    fn density(&self) -> f64 {
        self.discretization().density
    }

    fn waves(
        &self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
    ) -> Result<WaveSystem<D>, MethodError> {
        let matrix = dynamical_matrix(self, material, f)?;
        let constants = matrix.force_constants().ok_or(MethodError::NotOfForces {
            linearization: self.discretization().linearization.name(),
        })?;
        let mass = self.particle_mass();
        let home = Particle::home(0);
        let mut stiffness = BlochBlocks::new();
        for (cell, block) in constants {
            stiffness.add(&home, &home.moved(&cell), &(block * mass));
        }
        let crystal = Method::crystal(self);
        Ok(WaveSystem::new(
            crystal.clone(),
            stiffness.sum(crystal),
            Mass::Lumped(vec![mass]),
        ))
    }

    fn strain(&self) -> Result<StrainOperator<D>, MethodError> {
        let order = if self.is_naturally_stabilized() {
            Order::Second
        } else {
            Order::First
        };
        let configuration = self.configuration(&DeformationGradient::identity(), order)?;
        let mut strain = StrainOperator::new();
        for point in configuration.points {
            let particle = |cell: &[i32; D]| Particle {
                site: 0,
                cell: *cell,
            };
            let shape = &point.shape;
            let mut forms = vec![SeenForm::Strain(shape.gradients.clone())];
            if point.second_moments.is_some() {
                // The energy is that of a strain which is linear over the cell.
                let slope = |l: usize| shape.hessians.iter().map(move |h| h.column(l).into());
                forms.extend((0..D).map(|l| SeenForm::Strain(slope(l).collect())));
            }
            strain.add(point.cells.iter().map(particle).collect(), forms);
        }
        Ok(strain)
    }

    fn forces(
        &self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
        patch: &PeriodicPatch<D>,
        displacements: &[SVector<f64, D>],
    ) -> Result<Vec<SVector<f64, D>>, MethodError> {
        self.patch_forces(material, f, patch, displacements)
    }

    fn neighbors(&self) -> f64 {
        // What every quadrature point of the cell sees; a support that is too small sees nothing.
        let configuration = self.configuration(&DeformationGradient::identity(), Order::First);
        configuration.map_or(f64::NAN, |configuration| {
            let seen = configuration.points.iter().map(|point| point.cells.len());
            seen.sum::<usize>() as f64
        })
    }
}
