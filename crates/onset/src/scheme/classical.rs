//! Implementation of [`Discretization`] for the kernel methods of [`crate::method`].

use super::kernel::{KernelChoices, KernelScheme};
use super::{DirectWaves, Discretization, PatchForces, PeriodicPatch, SeenForm, StrainOperator};
use crate::approximation::Order;
use crate::bloch::{
    BlochBlocks, GradientMoments, Mass, WaveSystem, ZoneSearch, dynamical_matrix, gradient_norm,
};
use crate::kinematics::DeformationGradient;
use crate::lattice::{Crystal, Fractional, Particle};
use crate::material::Hyperelastic;
use crate::method::{Background, CurrentLattice, Frame, Linearization, Method, MethodError};
use nalgebra::SVector;

impl<const D: usize> Discretization<D> for Method<D> {
    fn crystal(&self) -> &Crystal<D> {
        Method::crystal(self)
    }

    fn density(&self) -> f64 {
        self.choices().density
    }

    fn waves(
        &self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
    ) -> Result<WaveSystem<D>, MethodError> {
        let matrix = dynamical_matrix(self, material, f)?;
        let constants = matrix.force_constants().ok_or(MethodError::NotOfForces {
            linearization: self.choices().linearization.name(),
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
                // The energy is the energy of a strain that is linear over the cell.
                let slope = |l: usize| shape.hessians.iter().map(move |h| h.column(l).into());
                forms.extend((0..D).map(|l| SeenForm::Strain(slope(l).collect())));
            }
            strain.add(point.cells.iter().map(particle).collect(), forms);
        }
        Ok(strain)
    }

    fn with_forces(
        &self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
        patch: &PeriodicPatch<D>,
        work: &mut dyn FnMut(&dyn PatchForces<D>),
    ) -> Result<(), MethodError> {
        work(&self.patch_points(material, f, patch)?);
        Ok(())
    }

    fn neighbors(&self) -> f64 {
        // Total number of neighbors of the quadrature points of the cell; NaN if the support is too small.
        let configuration = self.configuration(&DeformationGradient::identity(), Order::First);
        configuration.map_or(f64::NAN, |configuration| {
            let seen = configuration.points.iter().map(|point| point.cells.len());
            seen.sum::<usize>() as f64
        })
    }

    fn direct_waves(
        &self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
        speed_squared: f64,
    ) -> Result<Option<DirectWaves<D>>, MethodError> {
        let search = ZoneSearch::new(self, f, speed_squared).ok_or(MethodError::NotFinite)?;
        let matrix = dynamical_matrix(self, material, f)?;
        Ok(Some(DirectWaves { search, matrix }))
    }

    fn gradient_moments(
        &self,
        speed_squared: f64,
    ) -> Result<Option<GradientMoments<D>>, MethodError> {
        GradientMoments::new(self, speed_squared)
    }

    fn gradient_norms(
        &self,
        f: &DeformationGradient,
        waves: &[(SVector<f64, D>, bool)],
    ) -> Result<Option<Vec<f64>>, MethodError> {
        let norm = gradient_norm(self, f)?;
        let search = ZoneSearch::new(self, f, 1.0).ok_or(MethodError::NotFinite)?;
        let of_wave = |(k, is_long): &(SVector<f64, D>, bool)| {
            let discrete = match is_long {
                true => norm.long_wave_stiffness().acoustic_tensor(k)[(0, 0)],
                false => norm.at(k)[(0, 0)].re,
            };
            discrete / search.kernel_wave_vector(k).norm_squared()
        };
        Ok(Some(waves.iter().map(of_wave).collect()))
    }

    /// The block uses the forces of [`KernelScheme`], which are defined for the imposed background, without expansion of the strain, and not for
    /// undisplaced particles.
    fn on_block(
        &self,
        cells: [usize; D],
        origin: &Fractional<D>,
    ) -> Result<Option<Box<dyn Discretization<D>>>, MethodError> {
        let choices = self.choices();
        let is_exact =
            choices.frame == Frame::Lagrangian || choices.linearization == Linearization::Exact;
        let has_forces = is_exact && choices.background == Background::Imposed;
        if !has_forces || self.is_naturally_stabilized() || self.is_regular() {
            return Ok(None);
        }
        let points = self
            .points()
            .iter()
            .map(|point| (point.place, point.volume));
        let kernel = KernelChoices::of_method(choices);
        let block = KernelScheme::of_block(Method::crystal(self), points, kernel, (cells, origin))?;
        Ok(Some(Box::new(block)))
    }

    fn is_undamped(&self) -> bool {
        true
    }

    fn is_regular(&self) -> bool {
        let choices = self.choices();
        choices.frame == Frame::Eulerian && choices.current_lattice == CurrentLattice::Regular
    }

    fn enclosed(&self) -> Option<&Method<D>> {
        Some(self)
    }
}
