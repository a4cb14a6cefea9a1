//! Peridynamics: particles interact with all others within a horizon, without spatial derivatives.
//!
//! Bonds carry pair forces (Silling 2000) or form a linear peridynamic solid (Silling and others 2007), both with moduli of the reference state.
//! Correspondence models accept any hyperelastic law: it is evaluated at the nonlocal deformation gradient of a family (Silling and others 2007) or
//! of a bond (Chen 2018; Breitzman and Dayal 2018).
//! All are total Lagrangian: families are determined in the reference configuration. Particles exactly at the horizon belong to a family.

mod bond;
mod correspondence;
mod family;
mod solid;

use super::lagrangian::{GradientProducts, LagrangianPoint, Stressed, response, strains, stressed};
use super::moduli::{Moduli, reference_tangent, trace};
use super::parts::{FiniteBodies, Part};
use super::{
    Assembled, Discretization, Forced, Interaction, PatchForces, PeriodicPatch, PointResponse,
    SeenForm, StrainOperator, linearized, lumped_masses,
};
use crate::bloch::{Mass, WaveSystem};
use crate::kinematics::DeformationGradient;
use crate::lattice::{Crystal, Fractional};
use crate::material::{Hyperelastic, MaterialError};
use crate::method::MethodError;
use bond::Bond;
use correspondence::{Control, Controlled, Point};
use family::Family;
use nalgebra::DMatrix;
use solid::Solid;

/// Influence function: weight of a bond by its reference length `r`, with `q = r / horizon`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Influence {
    /// Constant function of the length, `w = 1`.
    Constant,
    /// Reciprocal of the length, `w = 1/q`.
    Inverse,
    /// Linear decrease, `w = 1 - q` up to the horizon and zero beyond.
    Conical,
    /// Gaussian function of the length, `w = exp(-4 q^2)`.
    Gaussian,
    /// Parabolic decay, `w = 1` up to `q = 1/2` and `4 q (1 - q)` from there to the horizon, as in Peridigm.
    Parabolic,
}

impl Influence {
    /// Returns `q w(q)`, which is finite at zero.
    fn weighted_length(self, q: f64) -> f64 {
        match self {
            Self::Constant => q,
            Self::Inverse => 1.0,
            Self::Conical => q * (1.0 - q).max(0.0),
            Self::Gaussian => q * (-4.0 * q * q).exp(),
            Self::Parabolic => q * (4.0 * q.max(0.5) * (1.0 - q.max(0.5))).max(0.0),
        }
    }

    /// Returns `w` at a length `q > 0` in units of the horizon; dimensionless.
    ///
    /// ```
    /// use onset::scheme::Influence;
    /// assert_eq!(Influence::Inverse.weight(0.5), 2.0);
    /// ```
    pub fn weight(self, q: f64) -> f64 {
        self.weighted_length(q) / q
    }

    /// Returns the integral of `w(q) q` over the unit ball in `D` dimensions, by Simpson's rule.
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

/// Rule for the volumes of particles near the horizon; `h = V^(1/D)` is the size of a particle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum PartialVolumes {
    /// The whole volume of every particle up to the horizon.
    Whole,
    /// The fraction `1/2 + (horizon - r)/h` within `h/2` of the horizon, for particles whose centers lie inside (Parks and others 2008).
    Inside,
    /// The fraction of `Inside` on both sides of the horizon, down to zero at `horizon + h/2` (Hu, Ha and Bobaru 2010).
    Tapered,
}

/// Calibration of the micromodulus of bonds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Calibration {
    /// Integral over the horizon: `2 E / horizon^2` in 1D, `18 K / (pi horizon^4)` in 3D, for constant influence.
    Continuum,
    /// Sum over the particles of the family, which reproduces the bulk modulus of the material exactly.
    Discrete,
}

/// Control of the zero-energy modes, deformations of a family with zero nonlocal deformation gradient.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum ZeroEnergyControl {
    /// No control of zero-energy modes.
    None,
    /// Springs `coefficient K_D w / tr(K) z` against the nonuniform part `z = Y - F X` of the deformation (Silling 2017).
    ///
    /// `K_D` is the bulk modulus in `D` dimensions in the reference state and `K` the shape tensor, which makes the coefficient dimensionless.
    Penalty {
        /// Coefficient of the springs; dimensionless, zero for no control.
        coefficient: f64,
    },
    /// Hourglass forces along the deformed bond, `coefficient c (z.e)/r e` with the micromodulus `c` of bonds with constant influence (Littlewood
    /// 2010).
    ///
    /// They do not derive from an energy, because the reaction on the deformation gradient is omitted.
    Hourglass {
        /// Coefficient of the hourglass forces; dimensionless, zero for no control.
        coefficient: f64,
    },
    /// Springs `coefficient w (C : K^-1) z` with the elasticity tensor `C` of the reference state (Wan and others 2019): the global control of
    /// PeriLab for the coefficient 1.
    ///
    /// If `K` is a multiple of the identity and the material isotropic, the control equals `Penalty` with `D^2` times the coefficient.
    StiffnessTensor {
        /// Coefficient of the springs; dimensionless, zero for no control.
        coefficient: f64,
    },
}

/// Peridynamic force model: bond-based or correspondence.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum BondModel {
    /// Prototype microelastic brittle material without its failure: the force `c w s e` per squared volume, with the stretch `s = (|y| - r)/r` and
    /// the direction `e` of the deformed bond `y`.
    ///
    /// The model uses only the bulk modulus of the material in the reference state. Its Lame constants are equal for any material (Poisson's ratio
    /// 1/4 in three dimensions and in plane strain), and out-of-plane stretches of a chain or plane have no effect.
    /// A homogeneous deformation is an equilibrium of the pair forces if every particle is a center of inversion.
    BondBased {
        /// Calibration of the micromodulus `c`.
        calibration: Calibration,
    },
    /// Linear peridynamic solid, an ordinary state-based model with the energy per volume `kappa theta^2 / 2 + D (D + 2) mu / (2 m) sum_J w V_J e_d^2`
    /// (Silling and others 2007).
    ///
    /// Here `e = |y| - r` is the elongation of a bond, `m = sum w r^2 V`, `theta = D/m sum w r e V` the dilatation and `e_d = e - theta r / D`. The
    /// model uses only the bulk modulus `kappa` in `D` dimensions and the shear modulus `mu` of the material in the reference state; in one dimension
    /// `mu` is the shear modulus in three dimensions. For an anisotropic material both belong to the isotropic tensor with the same `A_iijj` and
    /// `A_ijij`. A homogeneous deformation is an equilibrium if every particle is a center of inversion.
    Ordinary,
    /// Correspondence model with a deformation gradient for each bond, computed from the neighbors within the horizon of both of its ends (Chen 2018).
    BondAssociated {
        /// Forces of a bond.
        form: BondForm,
    },
    /// Correspondence model with the deformation gradient `F + (y - F X) (x) X / |X|^2` of each bond, where `F` is the mean of the families at its ends
    /// (Breitzman and Dayal 2018).
    ///
    /// The energy is `sum_I V_I sum_J w V_J W(F_IJ) / sum_J w V_J`.
    BondAveraged,
    /// Correspondence model with `F_I = (sum_J w (y_J - y_I) (x) X_IJ V_J) K_I^-1`, `K_I = sum_J w X_IJ (x) X_IJ V_J`.
    ///
    /// The force is `w P(F_I) K_I^-1 X_IJ` per squared volume, and the energy is `sum_I V_I W(F_I)`.
    Correspondence {
        /// Control of the zero-energy modes.
        control: ZeroEnergyControl,
    },
}

/// Forces of a bond-associated correspondence model, with the names of their implementation in MOOSE.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum BondForm {
    /// Form I: the stress of a bond acts on its two ends only, with the force `w (V_b/V_H) P_b K_b^-1 X_IJ` per squared volume. `V_b` and `V_H` are the volumes of
    /// the neighbors of the bond and of the whole family.
    ///
    /// The forces do not derive from an energy, and a homogeneous stress is reproduced only approximately.
    One,
    /// Form II: the stress of a bond acts on all of its neighbors, as follows from the energy `sum_b V_b W(F_b) / sum_b V_b` of a family.
    Two,
}

/// Choices that define a peridynamic discretization, apart from the lattice.
///
/// The default is bond-based with the usual horizon of three spacings, whole volumes, and the constants of the continuum.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(rename_all = "kebab-case", default, deny_unknown_fields)
)]
pub struct PeridynamicsChoices {
    /// Reference density; mass per reference volume.
    pub density: f64,
    /// Horizon in units of the particle spacing [`Crystal::spacing`].
    pub horizon: f64,
    /// Weights of the bonds.
    pub influence: Influence,
    /// Rule for the volumes at the horizon.
    pub partial_volumes: PartialVolumes,
    /// Peridynamic force model: bond-based or correspondence.
    pub model: BondModel,
    /// Correspondence model of families: whether the forces `w P K^-1 X` of bonds and the forces of springs contain the influence function, as in
    /// the published models. Without the influence function the forces have no energy.
    pub weighted_forces: bool,
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
            weighted_forces: true,
        }
    }
}

/// Peridynamic discretization of a crystal.
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
    horizon: f64,
    families: Vec<Family<D>>,
    /// Points of correspondence models.
    points: Vec<LagrangianPoint<D>>,
    products: GradientProducts<D>,
}

enum Interactions<'a, const D: usize> {
    Bonds(Vec<Bond<D>>),
    Solids(Vec<Solid<'a, D>>),
    /// Response of all points, and the controls of the families.
    Points(PointResponse<'a, D>, Vec<Controlled<'a, D>>),
}

impl<const D: usize> Peridynamics<D> {
    /// Builds the discretization on a crystal.
    ///
    /// # Errors
    /// [`MethodError`] if a setting is out of range, or if a family is too small and its shape tensor is singular.
    pub fn new(crystal: Crystal<D>, choices: PeridynamicsChoices) -> Result<Self, MethodError> {
        for (name, value) in [("density", choices.density), ("horizon", choices.horizon)] {
            MethodError::positive(name, value)?;
        }
        if let BondModel::Correspondence { control } = choices.model {
            control.check()?;
        }
        let horizon = choices.horizon * crystal.spacing();
        let families: Vec<Family<D>> = (0..crystal.sites().len())
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
        let points = match choices.model {
            BondModel::BondBased { .. } | BondModel::Ordinary => Vec::new(),
            BondModel::Correspondence { .. } => families
                .iter()
                .map(|family| correspondence::of_family(family, choices.weighted_forces))
                .collect(),
            BondModel::BondAssociated { form } => {
                let of_bonds =
                    |family| correspondence::of_bonds(family, horizon, form == BondForm::One);
                let points = families.iter().map(of_bonds);
                points.collect::<Result<Vec<_>, _>>()?.concat()
            }
            BondModel::BondAveraged => correspondence::between_families(&families, &crystal),
        };
        Ok(Self {
            choices,
            crystal,
            horizon,
            families,
            products: GradientProducts::of(&points),
            points,
        })
    }

    /// Choices that define the discretization.
    pub fn choices(&self) -> &PeridynamicsChoices {
        &self.choices
    }

    /// Radius of the families; length.
    pub fn horizon(&self) -> f64 {
        self.horizon
    }

    /// Returns the micromodulus `c` of a material, defined by `1/2 integral of c w r dV = A_iijj` in the reference state, summed over `D` dimensions;
    /// stress/length^(D+1).
    ///
    /// For constant influence it is `2 E / horizon^2` in one dimension and `18 K / (pi horizon^4)` in three.
    ///
    /// # Errors
    /// [`MaterialError`] if the material cannot be evaluated in the reference state.
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
        Ok(2.0 * trace::<D>(&reference_tangent(material)?) / lengths)
    }

    /// Integral of `w r` over the ball of the horizon.
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
            BondModel::Ordinary => {
                let moduli = Moduli::of::<D>(material)?;
                let solid = |family| Solid::new(family, moduli, f);
                Ok(Interactions::Solids(
                    self.families.iter().map(solid).collect(),
                ))
            }
            BondModel::Correspondence { .. }
            | BondModel::BondAssociated { .. }
            | BondModel::BondAveraged => {
                let control = match self.choices.model {
                    BondModel::Correspondence { control } => control,
                    _ => ZeroEnergyControl::None,
                };
                let response = response(material, f)?;
                if control.coefficient() == 0.0 {
                    return Ok(Interactions::Points(response, Vec::new()));
                }
                let reference = reference_tangent(material)?;
                let ball = || self.ball(Influence::Constant);
                let is_weighted = self.choices.weighted_forces;
                let controlled = |(stressed, family): (Stressed<'a, D>, &'a Family<D>)| {
                    let control = Control::new(control, family, &reference, ball, is_weighted)?;
                    Some(Controlled {
                        stressed,
                        control,
                        family,
                    })
                };
                let points = stressed(&self.points, response).into_iter();
                let controls = points.zip(&self.families).filter_map(controlled);
                Ok(Interactions::Points(response, controls.collect()))
            }
        }
    }
}

impl ZeroEnergyControl {
    /// Returns true if only the component of the nonuniform deformation along the bonds is resisted, and false if all components are; `None` without
    /// control.
    fn sees_only_along_bonds(self) -> Option<bool> {
        (self.coefficient() > 0.0).then_some(matches!(self, Self::Hourglass { .. }))
    }

    /// Coefficient of the control; zero without one.
    fn coefficient(self) -> f64 {
        match self {
            Self::Penalty { coefficient }
            | Self::Hourglass { coefficient }
            | Self::StiffnessTensor { coefficient } => coefficient,
            Self::None => 0.0,
        }
    }

    fn check(self) -> Result<(), MethodError> {
        MethodError::not_negative("control-coefficient", self.coefficient())
    }
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
            Interactions::Solids(solids) => linearized(&self.crystal, mass, &solids),
            Interactions::Points(response, controls) => {
                let mut forced = Forced::from(self.products.stiffness(&response));
                controls.iter().for_each(|control| forced.add(control));
                forced.waves(&self.crystal, mass)
            }
        }
    }

    fn strain(&self) -> Result<StrainOperator<D>, MethodError> {
        let is_pairwise = self.choices.model
            == BondModel::BondAssociated {
                form: BondForm::One,
            };
        if is_pairwise {
            return Ok(correspondence::acting_strains(&self.points));
        }
        let mut strain = strains(&self.points);
        match self.choices.model {
            BondModel::BondBased { .. } | BondModel::Ordinary => {
                for (site, family) in self.families.iter().enumerate() {
                    for bond in family.bonds(&self.crystal, site) {
                        let along = bond.vector.normalize();
                        let elongation = SeenForm::Control(vec![-along, along]);
                        strain.add(bond.particles.to_vec(), vec![elongation]);
                    }
                }
            }
            BondModel::Correspondence { control } => {
                if let Some(only_along) = control.sees_only_along_bonds() {
                    for family in &self.families {
                        let (gradients, vectors) = family.gradients();
                        strain.add_nonuniform(&family.particles, &gradients, &vectors, only_along);
                    }
                }
            }
            BondModel::BondAssociated { .. } | BondModel::BondAveraged => {}
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
            Interactions::Solids(solids) => work(&Assembled::new(patch, &solids)),
            Interactions::Points(response, controls) => {
                let points = stressed(&self.points, response);
                let points = points.into_iter().map(Point::Stressed);
                let all = points.chain(controls.into_iter().map(Point::Controlled));
                work(&Assembled::new(patch, &all.collect::<Vec<_>>()));
            }
        }
        Ok(())
    }

    fn on_block(
        &self,
        cells: [usize; D],
        origin: &Fractional<D>,
    ) -> Result<Option<Box<dyn Discretization<D>>>, MethodError> {
        let block = self.crystal.block(cells, origin)?;
        Ok(Some(Box::new(Self::new(block, self.choices.clone())?)))
    }

    fn finite_bodies(
        &self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
    ) -> Result<Option<FiniteBodies>, MethodError> {
        let Interactions::Bonds(bonds) = self.interactions(material, f)? else {
            return Ok(None);
        };
        // Compressed bonds push sideways, so that a body without them may be faster.
        let is_stable = |bond: &Bond<D>| {
            let mut part = Part::new(bond.particles(), DMatrix::zeros(2, 2));
            part.add(bond);
            let [least, most] = part.stiffnesses();
            least >= -1e-12 * most
        };
        Ok(bonds.iter().all(is_stable).then_some(FiniteBodies::Lattice))
    }

    /// Mean size of a family, the particle itself included.
    fn neighbors(&self) -> f64 {
        let sizes: usize = self.families.iter().map(Family::len).sum();
        1.0 + sizes as f64 / self.families.len() as f64
    }
}
