//! Linear and quadratic finite elements, total Lagrangian: bars, triangles, quadrilaterals, tetrahedra, bricks.
//!
//! An element with the shape functions `N_a` has the energy `sum_q V_q W(F_q)`, `F_q = F + sum_a u_a (x) dN_a/dX(X_q)`. Multilinear elements are
//! integrated fully (two Gauss points along each axis), with a mean dilatation, or with one point, which uses the mean gradients over the element.
//! One-point integration leaves zero-energy hourglass modes, which hourglass control resists.

mod dilatation;
mod hourglass;
mod mesh;
mod pattern;
mod shape;

pub use crate::method::MeshError;
pub use mesh::Mesh;
pub use pattern::ElementMesh;
pub use shape::ElementShape;

use super::lagrangian::{GradientProducts, LagrangianPoint, mean_neighbors, response, strains};
use super::parts::{FiniteBodies, Part};
use super::patch::Both;
use super::{Assembled, Discretization, Forced, PatchForces, PeriodicPatch, StrainOperator};
use crate::bloch::{BlochBlocks, Mass, WaveSystem};
use crate::continuum::Stiffness;
use crate::kinematics::DeformationGradient;
use crate::lattice::{Crystal, LatticeError, Particle};
use crate::material::Hyperelastic;
use crate::method::MethodError;
use dilatation::{Integrated, add_strains, integrated};
use hourglass::{HourglassMode, Resisted, hourglass_modes};
use nalgebra::{DMatrix, SMatrix, SVector};
use shape::Sample;

/// Largest mass of a node that counts as zero, as a fraction of the mass of a cell.
const MASSLESS: f64 = 1e-9;

/// Integration rule of the elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Integration {
    /// Two Gauss points along each axis of quadrilaterals and bricks; one point in simplices, where the gradient is constant.
    Full,
    /// The points of full integration with the mean dilatation of the element, `sum_q V_q W((theta / J_q)^(1/D) F_q)`, `theta = sum_q V_q J_q / V`
    /// (Simo, Taylor and Pister 1985; at small strains B-bar, Hughes 1980), for nearly incompressible laws. For simplices it equals full integration.
    MeanDilatation,
    /// One point with the mean gradient of the element (uniform strain).
    OnePoint,
}

/// Mass matrix of the elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum ElementMass {
    /// Lumped masses, `int rho N_a dV` at each node: the row sums of the consistent mass matrix.
    Lumped,
    /// Lumped masses in proportion to the diagonal of the consistent mass matrix, `m_a = rho V m_aa / sum_b m_bb` (Hinton, Rock and Zienkiewicz 1976).
    Hrz,
    /// Consistent mass matrix, `int rho N_a N_b dV`.
    Consistent,
}

/// Degree of the shape functions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum ElementOrder {
    /// Nodes at the corners.
    #[default]
    Linear,
    /// Nodes at the corners and in the middles of the edges.
    Quadratic,
}

/// Scaling of hourglass stiffness and viscosity, with `gamma_a` as in [`Formulation`] and `V` the volume of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum HourglassScale {
    /// Scales with the gradients of the element: stiffness `kappa M V b^2`, viscosity `epsilon rho c V b`.
    Gradients,
    /// Scales with the size of the element, as in production codes.
    /// Bricks have the stiffness `0.038 kappa M V^(1/3)` and the viscosity `epsilon/4 rho c V^(2/3)`.
    /// Quadrilaterals have the viscosity `epsilon/2 rho c V^(1/2)` and no stiffness. `gamma_a` is replaced by `2^D gamma_a`.
    ///
    /// Source: OpenRadioss, `shvis3.F`, `s_hg5.F`, `qhvis2.F`. LS-DYNA's theory manual has the same viscosity of bricks, `Q rho c V^(2/3) / 4`.
    Radioss,
}

/// Formulation of the elements; by default full integration with lumped masses.
///
/// Hourglass control resists each mode `q = sum_a gamma_a u_a` of a one-point element with the force
/// `gamma_a (kappa M V b^2 q + epsilon rho c V b dq/dt)`, or with the force of another [`HourglassScale`].
/// `M = rho c^2` is the modulus of the fastest wave in the material in the reference state, and `b^2 = sum_a |b_a|^2` with the mean gradients `b_a`.
/// Both parts are objective: `q` vanishes for every linear field, and rotates with the element.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(rename_all = "kebab-case", default, deny_unknown_fields)
)]
pub struct Formulation {
    /// Integration rule, full or one-point.
    pub integration: Integration,
    /// Stiffness coefficient `kappa` of one-point elements; dimensionless. For squares with lumped masses the hourglass modes have
    /// `omega^2 = 2 kappa M / (rho h^2)`.
    pub hourglass_stiffness: f64,
    /// Viscosity coefficient `epsilon` of one-point elements; dimensionless.
    pub hourglass_viscosity: f64,
    /// Scaling of both coefficients with modulus and size.
    pub hourglass_scale: HourglassScale,
    /// Mass matrix, lumped or consistent.
    pub mass: ElementMass,
}

impl Default for Formulation {
    fn default() -> Self {
        Self {
            integration: Integration::Full,
            hourglass_stiffness: 0.0,
            hourglass_viscosity: 0.0,
            hourglass_scale: HourglassScale::Gradients,
            mass: ElementMass::Lumped,
        }
    }
}

/// Choices that define a finite element method on a lattice; by default quadrilaterals.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(rename_all = "kebab-case", default, deny_unknown_fields)
)]
pub struct ElementChoices {
    /// Mesh of the elements.
    pub mesh: ElementMesh,
    /// Degree of the shape functions.
    pub order: ElementOrder,
    /// Distance between neighboring nodes; length.
    pub spacing: f64,
    /// Images of the unit vectors under the linear map that shears or stretches the mesh, one vector after the other; empty for the named mesh.
    pub vectors: Vec<f64>,
    /// Number of cells along each primitive vector whose nodes are displaced independently.
    pub cells: u32,
    /// Largest random displacement of a node along each axis, in spacings.
    pub perturbation: f64,
    /// Seed of the random displacements.
    pub seed: u32,
    /// Reference density; mass per reference volume.
    pub density: f64,
    /// Integration, hourglass control and masses.
    pub formulation: Formulation,
}

impl Default for ElementChoices {
    fn default() -> Self {
        Self {
            mesh: ElementMesh::Quadrilaterals,
            order: ElementOrder::Linear,
            spacing: 1.0,
            vectors: Vec::new(),
            cells: 1,
            perturbation: 0.0,
            seed: 0,
            density: 1.0,
            formulation: Formulation::default(),
        }
    }
}

impl ElementChoices {
    /// Returns the mesh with its nodes. Nodes that are displaced independently of each other need a cell with more than one of them.
    ///
    /// # Errors
    /// [`MethodError`] if the spacing is not positive, if `D` is not the dimension of the mesh, if the vectors do not span space, or if an element is
    /// inverted.
    pub fn built_mesh<const D: usize>(&self) -> Result<Mesh<D>, MethodError> {
        let side = match self.order {
            ElementOrder::Linear => self.spacing,
            ElementOrder::Quadratic => 2.0 * self.spacing,
        };
        let mut mesh = self.mesh.mesh(side)?;
        if !self.vectors.is_empty() {
            if self.vectors.len() != D * D {
                return Err(MethodError::Lattice(LatticeError::Vectors {
                    lattice: self.mesh.name(),
                    expected: D * D,
                    given: self.vectors.len(),
                }));
            }
            mesh = mesh.mapped(&SMatrix::from_fn(|i, j| self.vectors[D * j + i]))?;
        }
        // Undisplaced nodes make the cell of the mesh itself.
        if self.perturbation != 0.0 {
            mesh = mesh.supercell([self.cells.max(1) as usize; D])?;
            MethodError::require(
                mesh.crystal().sites().len() > 1,
                "perturbation",
                self.perturbation,
                "0 with one node in a cell: set discretization.cells to 2 or more",
            )?;
            mesh = mesh.perturbed(self.perturbation * self.spacing, u64::from(self.seed))?;
        }
        match self.order {
            ElementOrder::Linear => Ok(mesh),
            ElementOrder::Quadratic => mesh.quadratic(),
        }
    }
}

/// Discretization by finite elements.
///
/// ```
/// use nalgebra::Vector1;
/// use onset::kinematics::DeformationGradient;
/// use onset::material::Law;
/// use onset::scheme::Discretization;
/// use onset::scheme::element::{ElementChoices, ElementMesh, FiniteElements};
/// // Bars with lumped masses: at most omega = 2 c / h, here with lambda + 2 mu = 3.
/// let law = Law::named("saint-venant-kirchhoff").expect("a law of the library");
/// let material = law.build(&[("lambda", 1.0), ("mu", 1.0)])?;
/// let choices = ElementChoices { mesh: ElementMesh::Bars, ..ElementChoices::default() };
/// let bars = FiniteElements::<1>::new(&choices)?;
/// let waves = bars.waves(&*material, &DeformationGradient::identity())?;
/// let highest = waves.omega_squared(&Vector1::new(std::f64::consts::PI))[0].re;
/// assert!((highest - 4.0 * 3.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct FiniteElements<const D: usize> {
    mesh: Mesh<D>,
    density: f64,
    formulation: Formulation,
    points: Vec<LagrangianPoint<D>>,
    products: GradientProducts<D>,
    modes: Vec<HourglassMode<D>>,
    mass: Mass<D>,
}

impl<const D: usize> FiniteElements<D> {
    /// Builds the method on a named mesh.
    ///
    /// # Errors
    /// [`MethodError`] if a number is not positive, or if the mesh does not have `D` dimensions.
    pub fn new(choices: &ElementChoices) -> Result<Self, MethodError> {
        Self::on(choices.built_mesh()?, choices.density, choices.formulation)
    }

    /// Builds the method on any mesh.
    ///
    /// # Errors
    /// [`MethodError`] if the density is not positive, if a coefficient of hourglass control is negative, if the elements have no hourglass modes to
    /// control, if quadratic elements have one integration point, or if a lumped mass is not positive.
    pub fn on(mesh: Mesh<D>, density: f64, formulation: Formulation) -> Result<Self, MethodError> {
        MethodError::positive("density", density)?;
        let control = [
            ("hourglass-stiffness", formulation.hourglass_stiffness),
            ("hourglass-viscosity", formulation.hourglass_viscosity),
        ];
        for (name, value) in control {
            MethodError::not_negative(name, value)?;
            if value > 0.0 && formulation.integration != Integration::OnePoint {
                return Err(MeshError::NeedlessControl.into());
            }
        }
        let scale = formulation.hourglass_scale;
        if scale == HourglassScale::Radioss && D < 3 && formulation.hourglass_stiffness > 0.0 {
            return Err(MethodError::Incompatible {
                choice: "hourglass-scale \"radioss\" with an hourglass-stiffness",
                other: "quadrilaterals, whose control in this code is purely viscous",
                hint: "set hourglass-viscosity, or choose hourglass-scale = \"gradients\"",
            });
        }
        let is_quadratic = matches!(
            mesh.shape(),
            ElementShape::QuadraticSimplex | ElementShape::Serendipity
        );
        if is_quadratic && formulation.integration != Integration::Full {
            return Err(MethodError::Incompatible {
                choice: "quadratic elements",
                other: "an integration rule of linear elements",
                hint: "set integration = \"full\", or choose element-order = \"linear\"",
            });
        }
        let (mut points, mut modes) = (Vec::new(), Vec::new());
        for nodes in mesh.elements() {
            let samples = mesh.samples(nodes);
            let seen = |gradients: &[SVector<f64, D>], volume: f64| {
                let seen = nodes.iter().copied().zip(gradients.iter().copied());
                LagrangianPoint::new(seen, volume)
            };
            match formulation.integration {
                Integration::Full | Integration::MeanDilatation => points.extend(
                    samples
                        .iter()
                        .map(|sample| seen(&sample.gradients, sample.volume.abs())),
                ),
                Integration::OnePoint => {
                    let (gradients, volume) = mean_gradients(&samples, nodes.len());
                    points.push(seen(&gradients, volume));
                    if mesh.shape() == ElementShape::Multilinear {
                        let positions = nodes.iter().map(|node| mesh.crystal().position(node));
                        let positions: Vec<SVector<f64, D>> = positions.collect();
                        modes.extend(hourglass_modes(
                            nodes, &positions, &gradients, volume, scale,
                        ));
                    }
                }
            }
        }
        let mass = mass_of(&mesh, density, formulation.mass)?;
        Ok(Self {
            mesh,
            density,
            formulation,
            products: GradientProducts::of(&points),
            points,
            modes,
            mass,
        })
    }

    /// Mesh of the elements.
    pub fn mesh(&self) -> &Mesh<D> {
        &self.mesh
    }

    /// Integration points of the elements of a cell.
    pub fn points(&self) -> &[LagrangianPoint<D>] {
        &self.points
    }

    /// Number of integration points of an element with a mean dilatation; `None` without.
    fn points_of_mean(&self) -> Option<usize> {
        let own = self.points.len() / self.mesh.elements().len();
        (self.formulation.integration == Integration::MeanDilatation && own > 1).then_some(own)
    }

    fn integrated<'a>(
        &'a self,
        material: &'a dyn Hyperelastic,
        f: &DeformationGradient,
    ) -> Result<Vec<Integrated<'a, D>>, MethodError> {
        integrated(&self.points, self.points_of_mean(), material, f)
    }

    /// Hourglass modes with their springs and dashpots; empty if both coefficients are zero.
    fn resisted(&self, material: &dyn Hyperelastic) -> Result<Vec<Resisted<'_, D>>, MethodError> {
        let formulation = self.formulation;
        let (kappa, epsilon) = (
            formulation.hourglass_stiffness,
            formulation.hourglass_viscosity,
        );
        if (kappa == 0.0 && epsilon == 0.0) || self.modes.is_empty() {
            return Ok(Vec::new());
        }
        let undeformed = Stiffness::<D>::at(material, &DeformationGradient::identity())?;
        let modulus = undeformed.maximum_eigenvalue();
        let impedance = (self.density * modulus).sqrt();
        let modes = self.modes.iter();
        let resisted = modes.map(|mode| Resisted {
            mode,
            stiffness: kappa * modulus * mode.stiffness,
            viscosity: epsilon * impedance * mode.viscosity,
        });
        Ok(resisted.collect())
    }
}

impl<const D: usize> Discretization<D> for FiniteElements<D> {
    fn crystal(&self) -> &Crystal<D> {
        self.mesh.crystal()
    }

    fn density(&self) -> f64 {
        self.density
    }

    fn waves(
        &self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
    ) -> Result<WaveSystem<D>, MethodError> {
        let mut forced = Forced::default();
        match self.points_of_mean() {
            None => forced.stiffness = self.products.stiffness(&response(material, f)?),
            Some(_) => {
                let elements = self.integrated(material, f)?;
                elements.iter().for_each(|own| forced.add(own));
            }
        }
        for mode in &self.resisted(material)? {
            forced.add(mode);
        }
        forced.waves(self.crystal(), self.mass.clone())
    }

    fn strain(&self) -> Result<StrainOperator<D>, MethodError> {
        if let Some(count) = self.points_of_mean() {
            let mut strain = StrainOperator::new();
            add_strains(&self.points, count, &mut strain);
            return Ok(strain);
        }
        let mut strain = strains(&self.points);
        if self.formulation.hourglass_stiffness > 0.0 {
            for mode in &self.modes {
                mode.seen_by(&mut strain);
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
        let points = self.integrated(material, f)?;
        let modes = self.resisted(material)?;
        work(&Both(
            Assembled::new(patch, &points),
            Assembled::new(patch, &modes),
        ));
        Ok(())
    }

    fn masses(&self) -> Vec<f64> {
        self.mass.of_particles().into_owned()
    }

    fn finite_bodies(
        &self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
    ) -> Result<Option<FiniteBodies>, MethodError> {
        let points = self.integrated(material, f)?;
        let modes = self.resisted(material)?;
        let elements = self.mesh.elements();
        let (own_points, own_modes) = (points.len() / elements.len(), modes.len() / elements.len());
        let part = |(n, nodes): (usize, &Vec<Particle<D>>)| {
            let consistent = self.mesh.products(nodes) * self.density;
            let mut part = Part::new(nodes, of_element(consistent, self.formulation.mass));
            points[n * own_points..][..own_points]
                .iter()
                .for_each(|point| part.add(point));
            modes[n * own_modes..][..own_modes]
                .iter()
                .for_each(|mode| part.add(mode));
            part
        };
        Ok(Part::bound(elements.iter().enumerate().map(part)))
    }

    /// Mean number of nodes that share an element with a node.
    fn neighbors(&self) -> f64 {
        mean_neighbors(&self.points, self.crystal())
    }
}

/// Mean gradients of the shape functions over an element, and the volume of the element.
fn mean_gradients<const D: usize>(
    samples: &[Sample<D>],
    nodes: usize,
) -> (Vec<SVector<f64, D>>, f64) {
    let volume: f64 = samples.iter().map(|sample| sample.volume.abs()).sum();
    let mean = |a: usize| {
        let weighted = |s: &Sample<D>| s.gradients[a] * (s.volume.abs() / volume);
        samples.iter().map(weighted).sum()
    };
    ((0..nodes).map(mean).collect(), volume)
}

/// Mass matrix of an element from the consistent one.
fn of_element(consistent: DMatrix<f64>, mass: ElementMass) -> DMatrix<f64> {
    match mass {
        ElementMass::Consistent => consistent,
        ElementMass::Lumped => DMatrix::from_diagonal(&consistent.column_sum()),
        ElementMass::Hrz => {
            let diagonal = consistent.diagonal();
            DMatrix::from_diagonal(&(&diagonal * (consistent.sum() / diagonal.sum())))
        }
    }
}

fn mass_of<const D: usize>(
    mesh: &Mesh<D>,
    density: f64,
    mass: ElementMass,
) -> Result<Mass<D>, MethodError> {
    let crystal = mesh.crystal();
    let mut lumped = vec![0.0; crystal.sites().len()];
    let mut consistent = BlochBlocks::new();
    for nodes in mesh.elements() {
        let products = of_element(mesh.products(nodes) * density, mass);
        for (a, from) in nodes.iter().enumerate() {
            lumped[from.site] += products.row(a).sum();
            for (b, to) in nodes.iter().enumerate() {
                consistent.add(from, to, &(SMatrix::identity() * products[(a, b)]));
            }
        }
    }
    if mass == ElementMass::Consistent {
        return Ok(Mass::Consistent(consistent.sum(crystal)));
    }
    let least = MASSLESS * density * crystal.lattice().cell_volume();
    match lumped.iter().position(|own| *own <= least) {
        Some(site) => Err(MeshError::Massless {
            site,
            share: lumped[site] / (density * crystal.lattice().cell_volume()),
        }
        .into()),
        None => Ok(Mass::Lumped(lumped)),
    }
}
