//! Total-Lagrangian SPH with kernels in material coordinates.

use super::super::lagrangian::{GradientProducts, LagrangianPoint, response, strains, stressed};
use super::super::layout::{Layout, MovingWeight, assert_positive};
use super::super::moduli::Moduli;
use super::super::response::PartOf;
use super::super::stabilization::{
    ArtificialViscosity, BondPenalty, Compliance, Dashpot, PenaltyForm, RiemannPairs, Slope,
    Upwinding, ViscousBond, ViscousScales, assert_coefficients, smoothed_velocities, viscous_bonds,
};
use super::super::{
    Assembled, Bond, CarriedWaves, Discretization, Forced, PairLaw, PatchForces, PeriodicPatch,
    PointResponse, StrainOperator, lumped_masses,
};
use super::bonds::{ParticleGradient, smoothed};
use super::interaction::SphInteraction;
use super::neighborhood::{Neighborhood, mean_size, neighborhoods};
use super::pairwise::PairwiseShear;
use crate::algebra::Each;
use crate::bloch::{Mass, WaveSystem};
use crate::kernel::Kernel;
use crate::kinematics::DeformationGradient;
use crate::lattice::{Crystal, Fractional};
use crate::material::Hyperelastic;
use crate::method::MethodError;
use nalgebra::SVector;

/// Forces of the shear stress in SPH.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum ShearForces {
    /// The whole stress of a particle acts along the gradients of its neighbors.
    Stress,
    /// Shear acts between pairs of particles: the essentially non-hourglass formulations of SPHinXsys. The forces have no potential. `mu` is the shear modulus
    /// of the reference state.
    ///
    /// In total-Lagrangian SPH the part `zeta mu J^(-2/D) F` of the stress (`D`: number of dimensions) is replaced by a discrete Laplacian of the current
    /// positions, and the remaining stress acts along uncorrected gradients (Wu and others 2023, for neo-Hookean laws).
    ///
    /// In updated SPH the particles carry the mean stress of the law alone, and accelerations accumulate with the velocities,
    /// `da_I/dt = 2 zeta mu / rho_I sum_J V_J (e . v_IJ) e W'(r) / r`, `e = x_IJ / r` (Zhang, Zhang, Rezavand and Hu, J. Comput. Phys. 2024, doi
    /// 10.1016/j.jcp.2024.113072). A chain has no shear.
    Pairs {
        /// Coefficient `zeta`; the published ones belong to the choices of the two methods.
        coefficient: f64,
    },
}

/// Choices that define total-Lagrangian SPH.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(rename_all = "kebab-case", default, deny_unknown_fields)
)]
pub struct TotalLagrangianChoices {
    /// Reference density; mass per reference volume.
    pub density: f64,
    /// Weight function of the particles.
    pub kernel: Kernel,
    /// Support radius in the reference configuration; length.
    pub radius: f64,
    /// Whether gradients are corrected to be exact for linear fields.
    pub corrected: bool,
    /// Deformation gradient of a particle.
    pub gradient: ParticleGradient,
    /// Coefficient `alpha` of the penalty against zero-energy modes; zero for no penalty.
    pub penalty: f64,
    /// Form of the penalty, which fixes its denominators.
    pub penalty_form: PenaltyForm,
    /// Artificial viscosity; `None` for no viscosity.
    pub viscosity: Option<ArtificialViscosity>,
    /// Dissipation of an acoustic Riemann solver between pairs.
    pub upwinding: Upwinding,
    /// Coefficient `epsilon` of XSPH; zero for no velocity smoothing.
    pub velocity_smoothing: f64,
    /// Forces of the shear stress.
    pub shear: ShearForces,
}

impl TotalLagrangianChoices {
    /// Published coefficient `zeta` of shear forces between pairs, of Wu and others (2023).
    pub const PUBLISHED_SHEAR_COEFFICIENT: f64 = 1.07;
}

impl Default for TotalLagrangianChoices {
    fn default() -> Self {
        Self {
            density: 1.0,
            kernel: Kernel::QuarticSpline,
            radius: 2.0,
            corrected: true,
            gradient: ParticleGradient::Kernel,
            penalty: 0.0,
            penalty_form: PenaltyForm::Published,
            viscosity: None,
            upwinding: Upwinding::None,
            velocity_smoothing: 0.0,
            shear: ShearForces::Stress,
        }
    }
}

/// SPH with kernels in material coordinates.
///
/// The deformation gradient is `F_I = sum_J V_J (u_J - u_I) (x) grad W_IJ K_I^-1 + 1` and the force is `f_I = sum_J V_I V_J (P_I K_I^-T + P_J K_J^-T)
/// grad W_IJ`, with `K_I = sum_J V_J X_IJ (x) grad W_IJ` or, uncorrected, `K = 1`. The forces are the negative derivatives of the energy `sum_I V_I
/// W(F_I)`. The state is imposed: every particle has the deformation gradient `F`. [`ParticleGradient::Bonds`] replaces `F_I` by a mean over bonds.
///
/// Source: Vignjevic, Reveles, Campbell, CMES 14 (2006) 181; Bonet and Lok, Comput. Methods Appl. Mech. Engrg. 180 (1999) 97.
///
/// ```
/// use onset::kinematics::DeformationGradient;
/// use onset::lattice::{LatticeKind, Crystal};
/// use onset::material::ModifiedMooneyRivlin;
/// use onset::scheme::{Discretization, sph::{TotalLagrangianChoices, TotalLagrangianSph}};
/// let square = Crystal::of_lattice(LatticeKind::Square.lattice::<2>(1.0)?);
/// let sph = TotalLagrangianSph::new(square, TotalLagrangianChoices::default())?;
/// let waves = sph.waves(&ModifiedMooneyRivlin::default(), &DeformationGradient::identity())?;
/// // Nodes that alternate strain no particle.
/// let pi = std::f64::consts::PI;
/// assert!(waves.omega_squared(&[pi, pi].into())[1].re.abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct TotalLagrangianSph<const D: usize> {
    crystal: Crystal<D>,
    choices: TotalLagrangianChoices,
    /// Particles that strain each particle of the cell.
    neighborhoods: Vec<Neighborhood<D>>,
    /// Particles of the cell as quadrature points.
    points: Vec<LagrangianPoint<D>>,
    /// Products of the gradients along which the whole stress acts; empty for shear forces between pairs.
    products: GradientProducts<D>,
    /// Uncorrected gradients of the particles, for shear forces between pairs.
    uncorrected: Vec<Vec<SVector<f64, D>>>,
}

impl<const D: usize> TotalLagrangianSph<D> {
    /// Builds the method on a crystal.
    ///
    /// # Errors
    /// [`MethodError`] if a number is out of range, or if a particle has too few or too many neighbors.
    pub fn new(crystal: Crystal<D>, choices: TotalLagrangianChoices) -> Result<Self, MethodError> {
        assert_positive(&[("density", choices.density), ("support", choices.radius)])?;
        assert_coefficients(&[
            ("penalty", choices.penalty),
            ("velocity-smoothing", choices.velocity_smoothing),
        ])?;
        choices
            .viscosity
            .iter()
            .try_for_each(|v| v.assert_admissible())?;
        let layout = Layout::reference(choices.kernel, choices.radius);
        let neighborhoods = neighborhoods(&crystal, &layout)?;
        let point = |(neighborhood, volume): (&Neighborhood<D>, &f64)| {
            let gradients = neighborhood.gradients(crystal.volumes(), choices.corrected)?;
            let gradients = gradients.into_iter().map(SVector::from);
            let seen = neighborhood.particles.iter().copied().zip(gradients);
            Ok(LagrangianPoint::new(seen, *volume))
        };
        let particles = neighborhoods.iter().zip(crystal.volumes());
        let points = particles.map(point).collect::<Result<_, MethodError>>()?;
        let (neighborhoods, points) = match choices.gradient {
            ParticleGradient::Kernel => (neighborhoods, points),
            ParticleGradient::Bonds => smoothed(&crystal, &layout, neighborhoods, points),
        };
        let (products, uncorrected) = match choices.shear {
            ShearForces::Stress => (GradientProducts::of(&points), Vec::new()),
            ShearForces::Pairs { coefficient } => {
                MethodError::positive("shear-coefficient", coefficient)?;
                let plain = |neighborhood: &Neighborhood<D>| {
                    let gradients = neighborhood.gradients(crystal.volumes(), false)?;
                    Ok(gradients.into_iter().map(SVector::from).collect())
                };
                let plain = neighborhoods.iter().map(plain);
                let plain = plain.collect::<Result<_, MethodError>>()?;
                (GradientProducts::of(&[]), plain)
            }
        };
        Ok(Self {
            crystal,
            choices,
            neighborhoods,
            points,
            products,
            uncorrected,
        })
    }

    /// Choices that define the method.
    pub fn choices(&self) -> &TotalLagrangianChoices {
        &self.choices
    }

    /// Interactions of a state, without stresses that act along the gradients.
    fn other_interactions<'a>(
        &'a self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
        response: &'a PointResponse<'a, D>,
    ) -> Result<Vec<SphInteraction<'a, D>>, MethodError> {
        let mut interactions: Vec<_> = match self.choices.shear {
            ShearForces::Stress => Vec::new(),
            ShearForces::Pairs { coefficient } => {
                let moduli = Moduli::of::<D>(material)?;
                let particles = self.points.iter().zip(&self.uncorrected);
                let pairwise = particles
                    .zip(&self.neighborhoods)
                    .map(|((point, along), n)| {
                        PairwiseShear::new(point, along, n, *response, moduli, coefficient)
                    });
                pairwise.map(SphInteraction::Pairwise).collect()
            }
        };
        if self.choices.penalty > 0.0 {
            let compliance = Compliance::of(material)?;
            let penalties = self.penalties(&compliance, response);
            interactions.extend(penalties.into_iter().map(SphInteraction::Penalty));
        }
        if let Some(viscosity) = &self.choices.viscosity {
            let bonds = self.viscous_bonds(viscosity, material, f)?;
            interactions.extend(bonds.into_iter().map(SphInteraction::Viscous));
        }
        for (point, neighborhood) in self.points.iter().zip(&self.neighborhoods) {
            let (upwinding, density) = (self.choices.upwinding, self.choices.density);
            let vectors = &neighborhood.vectors;
            let pairs = RiemannPairs::new(upwinding, point, vectors, density, material, f)?;
            interactions.extend(pairs.map(SphInteraction::Riemann));
        }
        Ok(interactions)
    }

    fn penalties<'a>(
        &'a self,
        compliance: &Compliance,
        response: &'a PointResponse<'a, D>,
    ) -> Vec<BondPenalty<'a, D>> {
        let volumes = self.crystal.volumes();
        let penalty = |(neighborhood, point): (&Neighborhood<D>, &LagrangianPoint<D>)| {
            let form = self.choices.penalty_form;
            let factor = 0.5 * form.coefficient(self.choices.penalty) * point.volume();
            let bonds = neighborhood.particles.iter().zip(&neighborhood.vectors);
            let weights = bonds
                .zip(&neighborhood.weights)
                .map(|((j, along), weight)| {
                    factor * compliance.young_modulus(along) * volumes[j.site] * weight.value
                });
            BondPenalty::new(
                neighborhood.particles.clone(),
                neighborhood.vectors.clone(),
                point.gradients().iter().map(|b| (*b).into()).collect(),
                weights.collect(),
                form.offsets(self.choices.radius),
                response,
            )
        };
        let particles = self.neighborhoods.iter().zip(&self.points);
        particles.map(penalty).collect()
    }

    fn viscous_bonds(
        &self,
        viscosity: &ArtificialViscosity,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
    ) -> Result<Vec<ViscousBond<D>>, MethodError> {
        let masses = lumped_masses(&self.crystal, self.choices.density);
        let densities = vec![self.choices.density; masses.len()];
        let map = f.leading::<D>();
        let bonds = self.neighborhoods.iter().flat_map(|neighborhood| {
            neighborhood.bonds().map(|(other, vector, weight)| {
                let reference = SVector::from(*vector);
                // Slope of the weight along the bond.
                let slope = SVector::from(weight.gradient).dot(&reference) / reference.norm();
                let current: SVector<f64, D> = map * reference;
                let ends = [neighborhood.particles[0], *other];
                (ends, current.into(), Slope::Fixed(slope))
            })
        });
        let scales = ViscousScales {
            density: self.choices.density,
            kernel: self.choices.kernel,
            radius: self.choices.radius,
        };
        let dashpot = Dashpot::new::<D>(viscosity, material, &scales)?;
        Ok(viscous_bonds(dashpot, &masses, &densities, bonds))
    }
}

/// Pair forces of total-Lagrangian SPH, for particles at any positions.
struct TotalLagrangianPairs<const D: usize> {
    weight: MovingWeight<D>,
    /// Compliance of the material, for the penalty.
    compliance: Option<Compliance>,
    choices: TotalLagrangianChoices,
}

impl<const D: usize> PairLaw<D> for TotalLagrangianPairs<D> {
    fn radius(&self) -> f64 {
        self.choices.radius
    }

    fn bond(&self, x: &[f64; D]) -> Bond<D> {
        let weight = self.weight.at(x);
        let form = self.choices.penalty_form;
        let stiffness = self.compliance.as_ref().map_or(0.0, |compliance| {
            let squared: f64 = x.iter().map(|x| x * x).sum();
            let factor = 0.5 * form.coefficient(self.choices.penalty);
            factor * compliance.young_modulus(x) * weight.value
                / form.offsets(self.choices.radius).denominator(squared)
        });
        Bond {
            gradient: weight.gradient.each(|slope| -slope),
            stiffness,
        }
    }

    fn is_corrected(&self) -> bool {
        self.choices.corrected
    }

    fn penalty_offsets(&self) -> Option<[f64; 2]> {
        let form = self.choices.penalty_form;
        let offsets = form.offsets(self.choices.radius).current();
        self.compliance.as_ref().map(|_| offsets)
    }

    fn density(&self) -> f64 {
        self.choices.density
    }
}

impl<const D: usize> Discretization<D> for TotalLagrangianSph<D> {
    fn crystal(&self) -> &Crystal<D> {
        &self.crystal
    }

    fn density(&self) -> f64 {
        self.choices.density
    }

    fn waves(
        &self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
    ) -> Result<WaveSystem<D>, MethodError> {
        let response = response(material, f)?;
        let mut forced = Forced::from(self.products.stiffness(&response));
        for interaction in &self.other_interactions(material, f, &response)? {
            forced.add(interaction);
        }
        let masses = lumped_masses(&self.crystal, self.choices.density);
        let system = forced.waves(&self.crystal, Mass::Lumped(masses.clone()))?;
        let epsilon = self.choices.velocity_smoothing;
        if epsilon == 0.0 {
            return Ok(system);
        }
        let densities = vec![self.choices.density; masses.len()];
        let weights = self.neighborhoods.iter().flat_map(Neighborhood::pairs);
        Ok(system.with_drift(smoothed_velocities(
            &self.crystal,
            epsilon,
            &masses,
            &densities,
            weights,
        )))
    }

    fn carried(
        &self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
    ) -> Result<Option<CarriedWaves<D>>, MethodError> {
        if self.choices.shear != ShearForces::Stress {
            return Ok(None);
        }
        // Kernels and bonds in material coordinates do not move. The stress follows the deformation gradients; the penalty, which measures distances,
        // follows the positions. In a law in rate form only the integrated part of the stress is carried along.
        let material = PartOf {
            law: material,
            is_integrated: true,
        };
        let forced = Forced::from(self.products.stiffness(&response(&material, f)?));
        let masses = lumped_masses(&self.crystal, self.choices.density);
        let stress = forced.waves(&self.crystal, Mass::Lumped(masses))?;
        Ok(Some(CarriedWaves {
            all: stress,
            density: None,
        }))
    }

    fn strain(&self) -> Result<StrainOperator<D>, MethodError> {
        let mut strain = strains(&self.points);
        let has_pairs = self.choices.shear != ShearForces::Stress;
        if self.choices.penalty > 0.0 || has_pairs {
            for (neighborhood, point) in self.neighborhoods.iter().zip(&self.points) {
                let bonds = neighborhood.vectors.iter().zip(&neighborhood.weights);
                let bonds = bonds.take_while(|(_, weight)| weight.value > 0.0);
                let vectors: Vec<SVector<f64, D>> = bonds.map(|(x, _)| (*x).into()).collect();
                strain.add_nonuniform(point.particles(), point.gradients(), &vectors, !has_pairs);
            }
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
        let response = response(material, f)?;
        let mut interactions = self.other_interactions(material, f, &response)?;
        if self.choices.shear == ShearForces::Stress {
            let points = stressed(&self.points, response).into_iter();
            interactions.extend(points.map(SphInteraction::Fixed));
        }
        work(&Assembled::new(patch, &interactions));
        Ok(())
    }

    fn pairs(
        &self,
        material: &dyn Hyperelastic,
    ) -> Result<Option<Box<dyn PairLaw<D>>>, MethodError> {
        if self.choices.viscosity.is_some()
            || self.choices.upwinding != Upwinding::None
            || self.choices.velocity_smoothing != 0.0
            || self.choices.shear != ShearForces::Stress
            || self.choices.gradient != ParticleGradient::Kernel
        {
            return Ok(None);
        }
        let compliance = match self.choices.penalty > 0.0 {
            true => Some(Compliance::of(material)?),
            false => None,
        };
        let layout = Layout::reference(self.choices.kernel, self.choices.radius);
        Ok(Some(Box::new(TotalLagrangianPairs {
            weight: layout.weight().normalized(),
            compliance,
            choices: self.choices.clone(),
        })))
    }

    fn on_block(
        &self,
        cells: [usize; D],
        origin: &Fractional<D>,
    ) -> Result<Option<Box<dyn Discretization<D>>>, MethodError> {
        let block = self.crystal.block(cells, origin)?;
        Ok(Some(Box::new(Self::new(block, self.choices.clone())?)))
    }

    fn neighbors(&self) -> f64 {
        mean_size(&self.neighborhoods)
    }
}
