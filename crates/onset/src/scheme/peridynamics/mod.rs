//! Peridynamics: particles that act on all others within a horizon, without derivatives.
//!
//! Bond-based (Silling 2000), a pair force along the deformed bond, and the correspondence model (Silling and others 2007), whose
//! nonlocal deformation gradient takes any hyperelastic law. Both are total-Lagrangian: families are those of the reference state.
//! A family holds the particles at the horizon itself.

mod bond;
mod correspondence;
mod family;

use super::parts::{FiniteBodies, Part};
use super::{
    Assembled, Discretization, Interaction, PatchForces, PeriodicPatch, SeenForm, StrainOperator,
    linearized, lumped_masses,
};
use crate::bloch::{Mass, WaveSystem};
use crate::kinematics::DeformationGradient;
use crate::lattice::Crystal;
use crate::material::{Hyperelastic, MaterialError};
use crate::method::MethodError;
use bond::Bond;
use correspondence::Point;
use family::Family;
use nalgebra::DMatrix;

/// How the weight of a bond depends on its length `r` in the reference state, `q = r / horizon`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Influence {
    /// `w = 1`.
    Constant,
    /// `w = 1/q`.
    Inverse,
    /// `w = 1 - q` up to the horizon, zero beyond.
    Conical,
    /// `w = exp(-4 q^2)`.
    Gaussian,
}

impl Influence {
    /// `q w(q)`, which is finite at zero.
    fn weighted_length(self, q: f64) -> f64 {
        match self {
            Self::Constant => q,
            Self::Inverse => 1.0,
            Self::Conical => q * (1.0 - q).max(0.0),
            Self::Gaussian => q * (-4.0 * q * q).exp(),
        }
    }

    /// `w` at a length in units of the horizon, `0 < q`; dimensionless.
    ///
    /// ```
    /// use onset::scheme::Influence;
    /// assert_eq!(Influence::Inverse.weight(0.5), 2.0);
    /// ```
    pub fn weight(self, q: f64) -> f64 {
        self.weighted_length(q) / q
    }

    /// The integral of `w(q) q` over the unit ball in `D` dimensions, by Simpson's rule.
    fn mean_length<const D: usize>(self) -> f64 {
        let surface = [2.0, std::f64::consts::TAU, 2.0 * std::f64::consts::TAU][D - 1];
        let intervals = 200;
        let at = |n: i32| {
            let q = f64::from(n) / f64::from(intervals);
            self.weighted_length(q) * q.powi(D as i32 - 1)
        };
        let weight = |n: i32| match n {
            0 => 1.0,
            n if n == intervals => 1.0,
            n if n % 2 == 1 => 4.0,
            _ => 2.0,
        };
        let sum: f64 = (0..=intervals).map(|n| weight(n) * at(n)).sum();
        surface * sum / (3.0 * f64::from(intervals))
    }
}

/// How much of a particle's volume counts near the horizon; `h` is the size of a particle, `V^(1/D)`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum PartialVolumes {
    /// All of it, up to the horizon.
    Whole,
    /// The fraction `1/2 + (horizon - r)/h` within `h/2` of the horizon, for particles whose centers are within it (Parks and
    /// others 2008).
    Inside,
    /// The same fraction on both sides of the horizon, down to zero at `horizon + h/2` (Hu, Ha and Bobaru 2010).
    Tapered,
}

/// From what the micromodulus of bonds is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Calibration {
    /// The integral over the horizon: `2 E / horizon^2` in one dimension, `18 K / (pi horizon^4)` in three.
    Continuum,
    /// The sum over the particles that are there, which gives the body exactly the bulk modulus of the material.
    Discrete,
}

/// What resists the deformations of a family that its deformation gradient does not see.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum ZeroEnergyControl {
    /// Nothing.
    None,
    /// Springs `coefficient K_D w / tr(K) z` against the nonuniform part `z = Y - F X` of the deformation (Silling 2017), `K_D` the
    /// bulk modulus in the reference state in `D` dimensions and `K` the shape tensor, which makes the coefficient a pure number.
    Penalty {
        /// A pure number; zero is no control.
        coefficient: f64,
    },
    /// Hourglass forces along the deformed bond, `coefficient c (z.e)/r e` with the micromodulus `c` of bonds of constant
    /// influence (Littlewood 2010). They do not derive from an energy: the reaction on the deformation gradient is left out.
    Hourglass {
        /// A pure number; zero is no control.
        coefficient: f64,
    },
}

/// The force between particles.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum BondModel {
    /// The prototype microelastic brittle material without its failure: `c w s e` per squared volume, with the stretch
    /// `s = (|y| - r)/r` and the direction `e` of the deformed bond `y`. Of the material it takes the bulk modulus in the reference state; its
    /// Lame constants are equal whatever the material's are (Poisson's ratio 1/4 in three dimensions and in plane strain), and it
    /// does not feel a stretch in the directions that a chain or a plane leaves out. A homogeneous deformation is an equilibrium
    /// of the pair forces where every particle is a center of inversion.
    BondBased {
        /// From what `c` is computed.
        calibration: Calibration,
    },
    /// `F_I = (sum_J w (y_J - y_I) (x) X_IJ V_J) K_I^-1`, `K_I = sum_J w X_IJ (x) X_IJ V_J`, and the force `w P(F_I) K_I^-1 X_IJ` per
    /// squared volume, with which the energy is `sum_I V_I W(F_I)`.
    Correspondence {
        /// Control of zero-energy modes.
        control: ZeroEnergyControl,
    },
}

/// Every choice that defines a peridynamic discretization, apart from the lattice. The default is bond-based with the
/// horizon of three spacings that is usual, whole volumes, and the constants of the continuum.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(rename_all = "kebab-case", default, deny_unknown_fields)
)]
pub struct PeridynamicsChoices {
    /// Reference density; mass per reference volume.
    pub density: f64,
    /// The horizon in units of the particle spacing, [`Crystal::spacing`].
    pub horizon: f64,
    /// Weights of the bonds.
    pub influence: Influence,
    /// Volumes at the horizon.
    pub partial_volumes: PartialVolumes,
    /// The force between particles.
    pub model: BondModel,
}

impl Default for PeridynamicsChoices {
    fn default() -> Self {
        Self {
            density: 1.0,
            horizon: 3.0,
            influence: Influence::Constant,
            partial_volumes: PartialVolumes::Whole,
            model: BondModel::BondBased {
                calibration: Calibration::Continuum,
            },
        }
    }
}

/// A peridynamic discretization of a crystal.
///
/// ```
/// use onset::kinematics::DeformationGradient;
/// use onset::lattice::{LatticeKind, Crystal};
/// use onset::material::ModifiedMooneyRivlin;
/// use onset::scheme::{Peridynamics, PeridynamicsChoices, Discretization};
/// let square = Crystal::of_lattice(LatticeKind::Square.lattice::<2>(1.0)?);
/// let body = Peridynamics::new(square, PeridynamicsChoices::default())?;
/// assert_eq!(body.neighbors(), 29.0);
/// let waves = body.waves(&ModifiedMooneyRivlin::default(), &DeformationGradient::identity())?;
/// assert!(waves.is_hermitian());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Peridynamics<const D: usize> {
    choices: PeridynamicsChoices,
    crystal: Crystal<D>,
    /// The horizon; length.
    horizon: f64,
    families: Vec<Family<D>>,
}

/// The interactions of one cell at a state.
enum Interactions<'a, const D: usize> {
    Bonds(Vec<Bond<D>>),
    Points(Vec<Point<'a, D>>),
}

impl<const D: usize> Peridynamics<D> {
    /// Sets up a discretization.
    ///
    /// # Errors
    /// [`MethodError`] when a setting is out of range, or when a family is so small that its shape tensor is singular.
    pub fn new(crystal: Crystal<D>, choices: PeridynamicsChoices) -> Result<Self, MethodError> {
        for (name, value) in [("density", choices.density), ("horizon", choices.horizon)] {
            MethodError::positive(name, value)?;
        }
        if let BondModel::Correspondence { control } = choices.model {
            control.check()?;
        }
        let horizon = choices.horizon * crystal.spacing();
        let families = (0..crystal.sites().len())
            .map(|site| {
                Family::new(
                    &crystal,
                    site,
                    horizon,
                    choices.influence,
                    choices.partial_volumes,
                )
            })
            .collect::<Result<_, _>>()?;
        Ok(Self {
            choices,
            crystal,
            horizon,
            families,
        })
    }

    /// The choices that define it.
    pub fn choices(&self) -> &PeridynamicsChoices {
        &self.choices
    }

    /// The radius of the families; length.
    pub fn horizon(&self) -> f64 {
        self.horizon
    }

    /// The micromodulus `c` of a material: `1/2 integral of c w r dV = A_iijj` in the reference state, summed over `D` dimensions.
    /// In one dimension with constant influence `2 E / horizon^2`, in three `18 K / (pi horizon^4)`. Units stress/length^(D+1).
    ///
    /// # Errors
    /// [`MaterialError`] when the material cannot be evaluated in the reference state.
    pub fn micromodulus(
        &self,
        material: &dyn Hyperelastic,
        calibration: Calibration,
    ) -> Result<f64, MaterialError> {
        let lengths = match calibration {
            Calibration::Continuum => self.ball(self.choices.influence),
            Calibration::Discrete => {
                let volumes = self.crystal.volumes();
                let sum: f64 = self
                    .families
                    .iter()
                    .zip(volumes)
                    .map(|(family, volume)| volume * family.mean_length())
                    .sum();
                sum / volumes.iter().sum::<f64>()
            }
        };
        Ok(2.0 * trace::<D>(material)? / lengths)
    }

    /// The integral of `w r` over the ball of the horizon.
    fn ball(&self, influence: Influence) -> f64 {
        influence.mean_length::<D>() * self.horizon.powi(D as i32 + 1)
    }

    fn interactions<'a>(
        &'a self,
        material: &'a dyn Hyperelastic,
        f: &DeformationGradient,
    ) -> Result<Interactions<'a, D>, MethodError> {
        if !f.is_block_diagonal::<D>() {
            return Err(MethodError::NotPlanar { dimension: D });
        }
        match self.choices.model {
            BondModel::BondBased { calibration } => {
                let modulus = self.micromodulus(material, calibration)?;
                let bonds = |site: usize| self.families[site].bonds(&self.crystal, site);
                let all = (0..self.families.len()).flat_map(bonds);
                let deformed = all.map(|bond| Bond::new(bond, modulus, f));
                Ok(Interactions::Bonds(deformed.collect()))
            }
            BondModel::Correspondence { control } => {
                let springs = match control {
                    ZeroEnergyControl::None => ZeroEnergyControl::None,
                    ZeroEnergyControl::Penalty { coefficient } => ZeroEnergyControl::Penalty {
                        coefficient: coefficient * trace::<D>(material)? / (D * D) as f64,
                    },
                    ZeroEnergyControl::Hourglass { coefficient } => ZeroEnergyControl::Hourglass {
                        coefficient: coefficient * 2.0 * trace::<D>(material)?
                            / self.ball(Influence::Constant),
                    },
                };
                let response = super::PointResponse::new(material, f)?;
                let point = |site| Point::new(&self.families[site], response, springs);
                let points = (0..self.families.len()).map(point);
                Ok(Interactions::Points(points.collect()))
            }
        }
    }
}

impl ZeroEnergyControl {
    /// Whether of the nonuniform part of the deformation only what is along the bonds is resisted; `None` where nothing is.
    fn sees_only_along_bonds(self) -> Option<bool> {
        match self {
            Self::Penalty { coefficient } if coefficient > 0.0 => Some(false),
            Self::Hourglass { coefficient } if coefficient > 0.0 => Some(true),
            _ => None,
        }
    }

    fn check(self) -> Result<(), MethodError> {
        match self {
            Self::Penalty { coefficient } | Self::Hourglass { coefficient } => {
                MethodError::not_negative("control-coefficient", coefficient)
            }
            _ => Ok(()),
        }
    }
}

/// `A_iijj` in the reference state, summed over `D` dimensions: `D^2` times the bulk modulus in them.
fn trace<const D: usize>(material: &dyn Hyperelastic) -> Result<f64, MaterialError> {
    let tangent = material.response(&DeformationGradient::identity())?.tangent;
    let entries = (0..D).flat_map(|i| (0..D).map(move |j| (i, i, j, j)));
    Ok(entries.map(|entry| tangent[entry]).sum())
}

impl<const D: usize> Discretization<D> for Peridynamics<D> {
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
        let mass = Mass::Lumped(lumped_masses(&self.crystal, self.choices.density));
        match self.interactions(material, f)? {
            Interactions::Bonds(bonds) => linearized(&self.crystal, mass, &bonds),
            Interactions::Points(points) => linearized(&self.crystal, mass, &points),
        }
    }

    fn strain(&self) -> Result<StrainOperator<D>, MethodError> {
        let mut strain = StrainOperator::new();
        match self.choices.model {
            BondModel::BondBased { .. } => {
                for (site, family) in self.families.iter().enumerate() {
                    for bond in family.bonds(&self.crystal, site) {
                        let along = bond.vector.normalize();
                        let elongation = SeenForm::Control(vec![-along, along]);
                        strain.add(bond.particles.to_vec(), vec![elongation]);
                    }
                }
            }
            BondModel::Correspondence { control } => {
                for family in &self.families {
                    let (gradients, vectors) = family.gradients();
                    strain.add_strain(&family.particles, gradients.clone());
                    if let Some(only_along) = control.sees_only_along_bonds() {
                        strain.add_nonuniform(&family.particles, &gradients, &vectors, only_along);
                    }
                }
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
        match self.interactions(material, f)? {
            Interactions::Bonds(bonds) => work(&Assembled::new(patch, &bonds)),
            Interactions::Points(points) => work(&Assembled::new(patch, &points)),
        }
        Ok(())
    }

    fn finite_bodies(
        &self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
    ) -> Result<Option<FiniteBodies>, MethodError> {
        let Interactions::Bonds(bonds) = self.interactions(material, f)? else {
            return Ok(None);
        };
        // Compressed bonds push sideways: without them a body may be faster.
        let is_stable = |bond: &Bond<D>| {
            let mut part = Part::new(bond.particles(), DMatrix::zeros(2, 2));
            part.add(bond);
            let [least, most] = part.stiffnesses();
            least >= -1e-12 * most
        };
        Ok(bonds.iter().all(is_stable).then_some(FiniteBodies::Lattice))
    }

    /// The size of a family, the particle included.
    fn neighbors(&self) -> f64 {
        let sizes: usize = self.families.iter().map(Family::len).sum();
        1.0 + sizes as f64 / self.families.len() as f64
    }
}
