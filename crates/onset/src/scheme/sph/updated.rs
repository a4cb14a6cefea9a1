//! SPH with kernels in current coordinates.

use super::super::layout::{Layout, assert_planar, assert_positive};
use super::super::moduli::shear_modulus;
use super::super::response::{MeanStress, PartOf};
use super::super::stabilization::{
    ArtificialStress, ArtificialViscosity, Dashpot, Repulsion, Slope, SmoothedMotion, ViscousBond,
    ViscousScales, assert_coefficients, smoothed_velocities, smoothing_share, viscous_bonds,
};
use super::super::{
    Assembled, CarriedWaves, Discretization, Interaction, PatchForces, PeriodicPatch,
    PointResponse, SeenForm, StrainOperator, linearized, lumped_masses,
};
use super::current::CurrentPairs;
use super::interaction::SphInteraction;
use super::neighborhood::{Neighborhood, mean_size, neighborhoods};
use super::springs::PairSprings;
use super::stress::{Circle, Responses, StressOf, Surroundings};
use super::total::ShearForces;
use crate::algebra::Each;
use crate::bloch::{BlochBlocks, BlochSum, Mass, WaveSystem};
use crate::cancel::checkpoint;
use crate::kernel::Kernel;
use crate::kinematics::DeformationGradient;
use crate::lattice::{Crystal, Particle, determinant};
use crate::material::Hyperelastic;
use crate::method::{MethodError, SupportSize};
use nalgebra::SVector;
use std::collections::BTreeMap;

/// Form of the pair force from the stresses of two particles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum MomentumForm {
    /// Symmetric form, `m_I sum_J m_J (sigma_I / rho_I^2 + sigma_J / rho_J^2) grad W_IJ`: conserves momentum.
    Symmetric,
    /// Mean form, `m_I sum_J m_J (sigma_I + sigma_J) / (rho_I rho_J) grad W_IJ`: conserves momentum.
    Mean,
    /// Difference form, `m_I sum_J m_J (sigma_J - sigma_I) / (rho_I rho_J) grad W_IJ`: a constant stress exerts no force for any positions of the
    /// particles, but momentum is not conserved.
    Difference,
}

/// Evolution of the density of a particle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum DensityEvolution {
    /// Summation over positions, `rho_I = sum_J m_J W_IJ`, the particle itself included.
    Summation,
    /// Continuity equation, `rho_I = rho_0 / det F_I`: `d rho = -rho div u` with the discrete divergence.
    Continuity,
}

/// Choices that define SPH with kernels in current coordinates.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(rename_all = "kebab-case", default, deny_unknown_fields)
)]
pub struct UpdatedSphChoices {
    /// Reference density; mass per reference volume.
    pub density: f64,
    /// Weight function of the particles.
    pub kernel: Kernel,
    /// Support radius in the reference configuration; length.
    pub radius: f64,
    /// Size of the support in a deformed state.
    pub support_size: SupportSize,
    /// Form of the pair forces.
    pub momentum: MomentumForm,
    /// Evolution of the densities.
    pub density_evolution: DensityEvolution,
    /// Whether the velocity gradient is corrected to be exact for linear fields.
    pub corrected: bool,
    /// Whether stresses also act along corrected gradients; requires a corrected velocity gradient.
    pub corrected_forces: bool,
    /// Coefficient `xi` of the penalty against zero-energy modes; zero for no penalty.
    pub penalty: f64,
    /// Forces of the shear stress.
    pub shear: ShearForces,
    /// Artificial stress, for the forms that conserve momentum; `None` for no artificial stress.
    pub artificial_stress: Option<ArtificialStress>,
    /// Artificial viscosity; `None` for no viscosity.
    pub viscosity: Option<ArtificialViscosity>,
    /// Coefficient `epsilon` of XSPH; zero for no velocity smoothing.
    pub velocity_smoothing: f64,
    /// Quantities that follow the smoothed velocities of XSPH.
    pub smoothed_motion: SmoothedMotion,
}

impl Default for UpdatedSphChoices {
    fn default() -> Self {
        Self {
            density: 1.0,
            kernel: Kernel::QuarticSpline,
            radius: 2.0,
            support_size: SupportSize::Fixed,
            momentum: MomentumForm::Symmetric,
            density_evolution: DensityEvolution::Continuity,
            corrected: false,
            corrected_forces: false,
            penalty: 0.0,
            shear: ShearForces::Stress,
            artificial_stress: None,
            viscosity: None,
            velocity_smoothing: 0.0,
            smoothed_motion: SmoothedMotion::Everything,
        }
    }
}

impl UpdatedSphChoices {
    /// Published coefficient `zeta = 0.7 D + 2.1` of shear forces between pairs in `D` dimensions.
    pub fn published_shear_coefficient(dimension: usize) -> f64 {
        0.7 * dimension as f64 + 2.1
    }
}

/// Quantities that follow a displacement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Varied {
    /// Positions and all quantities that particles carry along.
    Everything,
    /// Quantities that particles carry along, with positions held.
    Carried,
    /// Carried quantities that follow the density.
    Density,
}

/// SPH with kernels in current coordinates, with particles at `F X` in the homogeneous state.
///
/// The law gives the stress at the deformation gradient that a particle carries along, `Fdot = L F` with
/// `L_I = sum_J m_J/rho_J (v_J - v_I) (x) grad W_IJ K_I^-1`, `K_I = sum_J m_J/rho_J x_IJ (x) grad W_IJ` or, uncorrected, `K = 1`.
/// The [`MomentumForm`] gives the forces; corrected forces use the stresses `sigma_I K_I^-T`. The linearization is exact: kernels, densities and
/// volumes move.
/// The penalty adds accelerations along pairs that accumulate with the part of the velocities that `L` does not predict,
/// `da_I/dt = xi G / rho_I sum_J V_J [(v_IJ - (L_I + L_J)/2 x_IJ) . e] e W'(r) / r`, `v_IJ = v_I - v_J`, `x_IJ = x_I - x_J = r e`, with the shear modulus `G` of the
/// reference state. The published limiter of `xi` in a flowing metal has no linear form and is left out.
/// If only positions follow the smoothed velocities of XSPH, displacements are integrals of the unsmoothed velocity, and the positions move by the
/// smoothed displacements.
///
/// Source: Gray, Monaghan, Swift, Comput. Methods Appl. Mech. Engrg. 190 (2001) 6641; Randles and Libersky, Comput. Methods Appl.
/// Mech. Engrg. 139 (1996) 375; for the penalty Zhang, Zhang, Hu and others, arXiv 2409.11474 (2024).
///
/// ```
/// use onset::kinematics::DeformationGradient;
/// use onset::lattice::{LatticeKind, Crystal};
/// use onset::material::ModifiedMooneyRivlin;
/// use onset::scheme::{Discretization, sph::{UpdatedSph, UpdatedSphChoices}};
/// let chain = Crystal::of_lattice(LatticeKind::Chain.lattice::<1>(1.0)?);
/// let sph = UpdatedSph::new(chain, UpdatedSphChoices { radius: 1.5, ..UpdatedSphChoices::default() })?;
/// // Beyond the inflection of the kernel tension is unstable.
/// let stretched = DeformationGradient::from_stretches([1.05, 1.0, 1.0])?;
/// let waves = sph.waves(&ModifiedMooneyRivlin::default(), &stretched)?;
/// assert!(waves.omega_squared(&[std::f64::consts::PI].into())[0].re < 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct UpdatedSph<const D: usize> {
    crystal: Crystal<D>,
    choices: UpdatedSphChoices,
    masses: Vec<f64>,
    neighbors: f64,
}

struct State<const D: usize> {
    layout: Layout<D>,
    neighborhoods: Vec<Neighborhood<D>>,
    densities: Vec<f64>,
    gradients: Vec<Vec<[f64; D]>>,
}

/// Particles numbered in the order of their first appearance.
#[derive(Default)]
struct Numbered<const D: usize> {
    particles: Vec<Particle<D>>,
    numbers: BTreeMap<Particle<D>, usize>,
}

impl<const D: usize> Numbered<D> {
    fn number(&mut self, particle: Particle<D>) -> usize {
        *self.numbers.entry(particle).or_insert_with(|| {
            self.particles.push(particle);
            self.particles.len() - 1
        })
    }
}

impl<const D: usize> UpdatedSph<D> {
    /// Builds the method on a crystal.
    ///
    /// # Errors
    /// [`MethodError`] if a number is out of range, if a particle has too few or too many neighbors in the reference configuration,
    /// or if choices are combined that exclude each other.
    pub fn new(crystal: Crystal<D>, choices: UpdatedSphChoices) -> Result<Self, MethodError> {
        assert_positive(&[("density", choices.density), ("support", choices.radius)])?;
        // The forces are divided by the square of the density, their derivatives by its cube.
        MethodError::require(
            (1e-90..=1e90).contains(&choices.density),
            "density",
            choices.density,
            "a number from 1e-90 to 1e90: choose another unit of mass",
        )?;
        assert_coefficients(&[
            ("penalty", choices.penalty),
            ("velocity-smoothing", choices.velocity_smoothing),
        ])?;
        choices
            .viscosity
            .iter()
            .try_for_each(|v| v.assert_admissible())?;
        if choices.corrected_forces && !choices.corrected {
            return Err(MethodError::Incompatible {
                choice: "a correction of forces",
                other: "uncorrected velocity gradients",
                hint: "correct both (corrected = true) or neither",
            });
        }
        if let ShearForces::Pairs { coefficient } = choices.shear {
            MethodError::positive("shear-coefficient", coefficient)?;
            if D == 1 {
                return Err(MethodError::Incompatible {
                    choice: "shear between pairs",
                    other: "a chain, which has no shear",
                    hint: "choose shear-forces = \"stress\", or a lattice of the plane or space",
                });
            }
            if choices.penalty > 0.0 {
                return Err(MethodError::Incompatible {
                    choice: "a penalty",
                    other: "shear between pairs, which resists zero-energy modes itself",
                    hint: "choose penalty = 0, or shear-forces = \"stress\"",
                });
            }
        }
        if let Some(artificial_stress) = &choices.artificial_stress {
            artificial_stress.assert_admissible()?;
            if choices.momentum == MomentumForm::Difference {
                return Err(MethodError::Incompatible {
                    choice: "an artificial stress",
                    other: "the momentum form \"difference\"",
                    hint: "choose the form \"symmetric\" or \"mean\"; only these have a tensile instability",
                });
            }
        }
        let layout = Layout::reference(choices.kernel, choices.radius);
        let neighbors = mean_size(&neighborhoods(&crystal, &layout)?);
        Ok(Self {
            masses: lumped_masses(&crystal, choices.density),
            crystal,
            choices,
            neighbors,
        })
    }

    /// Choices that define the method.
    pub fn choices(&self) -> &UpdatedSphChoices {
        &self.choices
    }

    /// Neighborhoods and densities with the kernels of a homogeneous state, and the volume ratios of the sites.
    fn state(
        &self,
        f: &DeformationGradient,
        ratio: impl Fn(usize) -> f64,
    ) -> Result<State<D>, MethodError> {
        assert_planar::<D>(f)?;
        let UpdatedSphChoices {
            kernel,
            radius,
            support_size,
            ..
        } = self.choices;
        let layout = Layout::current(kernel, radius, support_size, f)?;
        let neighborhoods = neighborhoods(&self.crystal, &layout)?;
        let density = |neighborhood: &Neighborhood<D>| match self.choices.density_evolution {
            DensityEvolution::Summation => neighborhood.summed_density(&self.masses),
            DensityEvolution::Continuity => {
                self.choices.density / ratio(neighborhood.particles[0].site)
            }
        };
        let densities: Vec<f64> = neighborhoods.iter().map(density).collect();
        let shares = self.masses.iter().zip(&densities);
        let volumes: Vec<f64> = shares.map(|(mass, density)| mass / density).collect();
        let gradients = neighborhoods
            .iter()
            .map(|n| n.gradients(&volumes, self.choices.corrected))
            .collect::<Result<_, _>>()?;
        Ok(State {
            layout,
            neighborhoods,
            densities,
            gradients,
        })
    }

    /// Returns true if shear acts between pairs.
    fn has_pairs(&self) -> bool {
        self.choices.shear != ShearForces::Stress
    }

    /// Calls `work` with the interactions of a state.
    fn with_interactions<T>(
        &self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
        varied: Varied,
        work: impl FnOnce(&State<D>, &[SphInteraction<'_, D>]) -> T,
    ) -> Result<T, MethodError> {
        let volume = determinant(&f.leading::<D>());
        let state = self.state(f, |_| volume)?;
        let springs = self.springs(material, f, &state)?;
        let mean = MeanStress(material);
        let law = match self.choices.shear {
            ShearForces::Stress => material,
            ShearForces::Pairs { .. } => &mean,
        };
        // Jaumann's rate does not integrate the pressure, which follows the density just as the sums in the forces do. The rate of Green and Naghdi
        // also excludes the rotation, which follows neither.
        let rest = PartOf {
            law,
            is_integrated: false,
        };
        let response = match varied {
            Varied::Everything | Varied::Carried => PointResponse::new(law, f)?,
            Varied::Density => PointResponse::new(&rest, f)?,
        };
        let pairs = self.pairs_of(&state.layout, material, &response)?;
        let surroundings = Surroundings {
            responses: &Responses::Equal(response),
            pairs: &pairs,
            holds_positions: varied != Varied::Everything,
        };
        let mut interactions: Vec<SphInteraction<'_, D>> =
            self.stresses(&state, &surroundings).collect();
        if let Some(dashpot) = pairs.dashpot {
            let bonds = Self::viscous_bonds(dashpot, &self.masses, &state);
            interactions.extend(bonds.into_iter().map(SphInteraction::Viscous));
        }
        if varied != Varied::Density {
            interactions.extend(springs.into_iter().map(SphInteraction::Springs));
        }
        Ok(work(&state, &interactions))
    }

    /// Accumulated forces along pairs: of the penalty, or of shear between pairs.
    fn springs(
        &self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
        state: &State<D>,
    ) -> Result<Vec<PairSprings<D>>, MethodError> {
        let (factor, is_predicted) = match self.choices.shear {
            ShearForces::Stress => (self.choices.penalty, true),
            ShearForces::Pairs { coefficient } => (2.0 * coefficient, false),
        };
        if factor == 0.0 {
            return Ok(Vec::new());
        }
        if !is_predicted
            && material.is_path_dependent()
            && material.integrated_tangent(f)?.is_none()
        {
            return Err(MethodError::Incompatible {
                choice: "shear between pairs",
                other: "a law whose shear stress depends on the path, as of metals that flow: the pairs are elastic",
                hint: "choose shear-forces = \"stress\" with a penalty",
            });
        }
        let factor = factor * shear_modulus::<D>(material)?;
        let shares = self.masses.iter().zip(&state.densities);
        let volumes: Vec<f64> = shares.map(|(mass, density)| mass / density).collect();
        let both = state.neighborhoods.iter().zip(&state.gradients);
        let of_site = |(neighborhood, gradients): (&Neighborhood<D>, &Vec<[f64; D]>)| {
            let gradients = match is_predicted {
                true => gradients.clone(),
                false => Vec::new(),
            };
            PairSprings::new(neighborhood, factor, &volumes, gradients)
        };
        Ok(both.map(of_site).collect())
    }

    fn stresses<'a>(
        &'a self,
        state: &'a State<D>,
        surroundings: &'a Surroundings<'a, D>,
    ) -> impl Iterator<Item = SphInteraction<'a, D>> {
        let sites = 0..self.crystal.sites().len();
        sites.map(move |site| SphInteraction::Moving(self.stress_of(site, state, surroundings)))
    }

    /// Minus the derivatives of the forces with respect to the displacements, if the particles of the crystal are at their current positions and carry the
    /// given deformation gradients, and have accumulated no penalty. `None` for supports whose size depends on the deformation, and for shear between pairs,
    /// which the deformation gradients do not determine.
    ///
    /// # Errors
    /// [`MethodError`] if the discretization or the material cannot be evaluated there.
    pub(crate) fn tangent(
        &self,
        material: &dyn Hyperelastic,
        deformations: &[DeformationGradient],
    ) -> Result<Option<BlochSum<D>>, MethodError> {
        if self.choices.support_size != SupportSize::Fixed || self.has_pairs() {
            return Ok(None);
        }
        let undeformed = DeformationGradient::identity();
        let state = self.state(&undeformed, |site| {
            determinant(&deformations[site].leading::<D>())
        })?;
        let response = PointResponse::new(material, &undeformed)?;
        let pairs = self.pairs_of(&state.layout, material, &response)?;
        let responses = deformations.iter().map(|f| PointResponse::new(material, f));
        let surroundings = Surroundings {
            responses: &Responses::OfSites(responses.collect::<Result<_, _>>()?),
            pairs: &pairs,
            holds_positions: false,
        };
        let mut blocks = BlochBlocks::new();
        for interaction in self.stresses(&state, &surroundings) {
            checkpoint();
            interaction.add_stiffness(&mut blocks);
        }
        for springs in self.springs(material, &undeformed, &state)? {
            springs.add_stiffness(&mut blocks);
        }
        Ok(Some(blocks.sum(&self.crystal)))
    }

    /// Pair forces with the kernels of a homogeneous state.
    fn pairs_of(
        &self,
        layout: &Layout<D>,
        material: &dyn Hyperelastic,
        response: &PointResponse<'_, D>,
    ) -> Result<CurrentPairs<D>, MethodError> {
        let scales = ViscousScales {
            density: self.choices.density,
            kernel: self.choices.kernel,
            radius: self.choices.radius,
        };
        let viscosity = self.choices.viscosity.as_ref();
        let dashpot = viscosity.map(|own| Dashpot::new::<D>(own, material, &scales));
        Ok(CurrentPairs {
            weight: layout.weight().normalized(),
            momentum: self.choices.momentum,
            density_evolution: self.choices.density_evolution,
            reference_density: self.choices.density,
            is_corrected: self.choices.corrected,
            corrects_forces: self.choices.corrected_forces,
            repulsion: self.repulsion(layout, response),
            dashpot: dashpot.transpose()?,
            smoothing: self.choices.velocity_smoothing,
            smoothed_motion: self.choices.smoothed_motion,
        })
    }

    fn repulsion(&self, layout: &Layout<D>, response: &PointResponse<'_, D>) -> Option<Repulsion> {
        let choice = self.choices.artificial_stress.as_ref()?;
        let mut apart = [0.0; D];
        apart[0] = choice.spacing;
        let tangent = response.base_tangent().as_flattened().as_flattened();
        let stiffest = tangent
            .as_flattened()
            .iter()
            .fold(0.0, |most: f64, a| most.max(a.abs()));
        let reference = Layout::reference(self.choices.kernel, layout.weight().radius());
        Some(Repulsion {
            epsilon: choice.epsilon,
            exponent: choice.exponent,
            weight_at_spacing: reference.weight().normalized().at(&apart).value,
            threshold: STRESS_ROUNDING * stiffest,
        })
    }

    /// Forces of the stress of a particle of the cell.
    fn stress_of<'a>(
        &self,
        site: usize,
        state: &State<D>,
        surroundings: &'a Surroundings<'a, D>,
    ) -> StressOf<'a, D> {
        let own = &state.neighborhoods[site].particles;
        // Particles whose densities enter the forces.
        let seeing = match surroundings.pairs.takes_all_densities() {
            false => &own[..1],
            true => &own[..],
        };
        let mut members = Numbered::default();
        own.iter()
            .for_each(|particle| _ = members.number(*particle));
        let circles = seeing
            .iter()
            .map(|center| Circle {
                members: state.neighborhoods[center.site]
                    .particles
                    .iter()
                    .map(|particle| members.number(particle.moved(&center.cell)))
                    .collect(),
                gradients: state.gradients[center.site].clone(),
            })
            .collect();
        let smoothing = self.smoothing(own.len(), &mut members, state);
        let particles = members.particles;
        let place = &self.crystal.sites()[site];
        let vector = |particle| state.layout.vector(&self.crystal, place, particle);
        StressOf {
            surroundings,
            positions: particles.iter().map(vector).collect(),
            masses: particles.iter().map(|p| self.masses[p.site]).collect(),
            particles,
            circles,
            smoothing,
        }
    }

    /// Weights of neighbors in the displacement of positions, if only positions follow smoothed velocities.
    ///
    /// They are computed for a particle and its neighbors, or for all particles if densities are sums over positions.
    fn smoothing(
        &self,
        nearest: usize,
        members: &mut Numbered<D>,
        state: &State<D>,
    ) -> Vec<Vec<(usize, f64)>> {
        let epsilon = self.choices.velocity_smoothing;
        if epsilon == 0.0 || self.choices.smoothed_motion == SmoothedMotion::Everything {
            return Vec::new();
        }
        let positioned = match self.choices.density_evolution {
            DensityEvolution::Continuity => nearest,
            DensityEvolution::Summation => members.particles.len(),
        };
        let shares = |number: usize| {
            let own = members.particles[number];
            let neighborhood = &state.neighborhoods[own.site];
            let share = |([_, other], weight): ([Particle<D>; 2], f64)| {
                let densities = [own, other].each(|particle| state.densities[particle.site]);
                let mass = self.masses[other.site];
                let share = smoothing_share(epsilon, mass, densities, weight);
                (members.number(other.moved(&own.cell)), share)
            };
            neighborhood.pairs().map(share).collect()
        };
        (0..positioned).map(shares).collect()
    }

    fn viscous_bonds(dashpot: Dashpot, masses: &[f64], state: &State<D>) -> Vec<ViscousBond<D>> {
        let slope = Slope::Moving(state.layout.weight().normalized());
        let bonds = state.neighborhoods.iter().flat_map(|neighborhood| {
            let others = neighborhood.particles.iter().zip(&neighborhood.vectors);
            let own = neighborhood.particles[0];
            others
                .skip(1)
                .map(move |(other, vector)| ([own, *other], *vector, slope))
        });
        viscous_bonds(dashpot, masses, &state.densities, bonds)
    }
}

/// Principal stresses below this fraction of the stiffness are rounding errors.
const STRESS_ROUNDING: f64 = 1e-12;

impl<const D: usize> Discretization<D> for UpdatedSph<D> {
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
        let epsilon = self.choices.velocity_smoothing;
        self.with_interactions(material, f, Varied::Everything, |state, interactions| {
            let mass = Mass::Lumped(self.masses.clone());
            let system = linearized(&self.crystal, mass, interactions)?;
            // If only positions follow smoothed velocities, they are shifted where the forces are computed.
            let is_everything = self.choices.smoothed_motion == SmoothedMotion::Everything;
            if epsilon == 0.0 || !is_everything {
                return Ok(system);
            }
            let pairs = state.neighborhoods.iter().flat_map(Neighborhood::pairs);
            let (masses, densities) = (&self.masses, &state.densities);
            let drift = smoothed_velocities(&self.crystal, epsilon, masses, densities, pairs);
            Ok(system.with_drift(drift))
        })?
    }

    fn carried(
        &self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
    ) -> Result<Option<CarriedWaves<D>>, MethodError> {
        let waves = |varied| {
            self.with_interactions(material, f, varied, |_, interactions| {
                linearized(
                    &self.crystal,
                    Mass::Lumped(self.masses.clone()),
                    interactions,
                )
            })?
        };
        Ok(Some(CarriedWaves {
            all: waves(Varied::Carried)?,
            density: Some(waves(Varied::Density)?),
        }))
    }

    fn strain(&self) -> Result<StrainOperator<D>, MethodError> {
        let state = self.state(&DeformationGradient::identity(), |_| 1.0)?;
        let mut strain = StrainOperator::new();
        for (neighborhood, gradients) in state.neighborhoods.iter().zip(&state.gradients) {
            let gradients: Vec<SVector<f64, D>> = gradients.iter().map(|b| (*b).into()).collect();
            let vectors: Vec<SVector<f64, D>> =
                neighborhood.vectors.iter().map(|x| (*x).into()).collect();
            let particles = &neighborhood.particles;
            if self.has_pairs() {
                // The mean stress resists changes of volume alone.
                strain.add(particles.clone(), vec![SeenForm::Control(gradients)]);
                let unpredicted = vec![SVector::zeros(); particles.len()];
                strain.add_nonuniform(particles, &unpredicted, &vectors, true);
                continue;
            }
            if self.choices.penalty > 0.0 {
                strain.add_nonuniform(particles, &gradients, &vectors, true);
            }
            strain.add_strain(particles, gradients);
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
        self.with_interactions(material, f, Varied::Everything, |_, interactions| {
            work(&Assembled::new(patch, interactions));
        })
    }

    fn neighbors(&self) -> f64 {
        self.neighbors
    }

    fn current_pairs(
        &self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
    ) -> Result<Option<CurrentPairs<D>>, MethodError> {
        // Bodies do not accumulate accelerations.
        if self.choices.penalty > 0.0 || self.has_pairs() {
            return Ok(None);
        }
        let UpdatedSphChoices {
            kernel,
            radius,
            support_size,
            ..
        } = self.choices;
        let layout = Layout::current(kernel, radius, support_size, f)?;
        let response = PointResponse::new(material, f)?;
        self.pairs_of(&layout, material, &response).map(Some)
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::linearized::differentiated;
    use super::*;
    use crate::bloch::{BlochBlocks, BlochSum};
    use crate::lattice::LatticeKind;
    use crate::material::ModifiedMooneyRivlin;
    use crate::scheme::Interaction;
    use nalgebra::SMatrix;

    /// All forms of the forces with every optional term.
    fn choices(radius: f64, is_plane: bool) -> Vec<UpdatedSphChoices> {
        let mut all = Vec::new();
        for momentum in [
            MomentumForm::Symmetric,
            MomentumForm::Mean,
            MomentumForm::Difference,
        ] {
            for density_evolution in [DensityEvolution::Summation, DensityEvolution::Continuity] {
                for (corrected, corrected_forces) in [(false, false), (true, false), (true, true)] {
                    let has_pairs = is_plane && momentum == MomentumForm::Mean;
                    let repels = momentum != MomentumForm::Difference;
                    all.push(UpdatedSphChoices {
                        radius,
                        momentum,
                        density_evolution,
                        corrected,
                        corrected_forces,
                        penalty: if has_pairs { 0.0 } else { 4.0 },
                        shear: match has_pairs {
                            true => ShearForces::Pairs { coefficient: 3.5 },
                            false => ShearForces::Stress,
                        },
                        artificial_stress: repels.then(ArtificialStress::default),
                        velocity_smoothing: if corrected { 0.0 } else { 0.4 },
                        smoothed_motion: SmoothedMotion::Positions,
                        ..UpdatedSphChoices::default()
                    });
                }
            }
        }
        all
    }

    /// Largest difference of two sums, relative to the largest entry of the first.
    fn difference<const D: usize>(sums: [&BlochSum<D>; 2]) -> f64 {
        let [blocks, others] = sums.map(|sum| {
            let blocks = sum.blocks().map(|(from, to, block)| ((from, *to), *block));
            blocks.collect::<BTreeMap<_, _>>()
        });
        let largest = blocks.values().map(|b| b.amax()).fold(0.0, f64::max);
        let keys = blocks.keys().chain(others.keys());
        let of = |key| {
            [&blocks, &others].map(|all| all.get(key).copied().unwrap_or_else(SMatrix::zeros))
        };
        let differences = keys.map(|key| {
            let [block, other] = of(key);
            (block - other).amax()
        });
        differences.fold(0.0, f64::max) / largest
    }

    fn assert_derivatives<const D: usize>(kind: LatticeKind, cells: [usize; D], radius: f64) {
        let lattice = Crystal::of(kind, 1.0).expect("a crystal");
        let disordered = lattice.supercell(cells).expect("a crystal");
        let disordered = disordered.perturbed(0.08, 3).expect("a crystal");
        let mut sheared = [[1.1, 0.2, 0.0], [0.05, 1.2, 0.0], [0.0, 0.0, 0.95]];
        if D == 1 {
            sheared = [[1.1, 0.0, 0.0], [0.0, 1.2, 0.0], [0.0, 0.0, 0.95]];
        }
        let stretched = DeformationGradient::from_stretches([1.1, 1.1, 1.0]);
        assert_derivatives_at(&lattice, &stretched.expect("a deformation"), radius);
        let sheared = DeformationGradient::new(sheared);
        assert_derivatives_at(&disordered, &sheared.expect("a deformation"), radius);
    }

    fn assert_derivatives_at<const D: usize>(
        crystal: &Crystal<D>,
        f: &DeformationGradient,
        radius: f64,
    ) {
        let law = ModifiedMooneyRivlin::default();
        for choices in choices(radius, D > 1) {
            let sph = UpdatedSph::new(crystal.clone(), choices.clone()).expect("a method");
            for varied in [Varied::Everything, Varied::Carried, Varied::Density] {
                let found = sph.with_interactions(&law, f, varied, |_, interactions| {
                    let [mut by_chain, mut by_each] = [BlochBlocks::new(), BlochBlocks::new()];
                    for interaction in interactions {
                        interaction.add_stiffness(&mut by_chain);
                        differentiated(interaction, false, &mut by_each);
                    }
                    difference([&by_each.sum(crystal), &by_chain.sum(crystal)])
                });
                let found = found.expect("a state");
                assert!(found < 1e-13, "{found}: {choices:?}, {varied:?}");
            }
        }
    }

    #[test]
    fn chain_rule_derivatives_equal_derivatives_of_the_forces() {
        assert_derivatives(LatticeKind::Chain, [3], 2.2);
        assert_derivatives(LatticeKind::Square, [2, 1], 2.01);
        assert_derivatives(LatticeKind::Hexagonal, [2, 1], 2.0);
        assert_derivatives(LatticeKind::SimpleCubic, [2, 1, 1], 1.6);
    }
}
