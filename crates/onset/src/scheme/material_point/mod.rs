//! The material point method on a background grid.
//!
//! Material points carry mass, stress and deformation; forces and accelerations are computed at the nodes of a grid (Sulsky, Chen and Schreyer 1994).
//! Every cell of the grid contains the points in the same layout. The degrees of freedom and the moving masses depend on the [`Formulation`].

mod functions;
mod point;
mod step;
mod transfer;

pub use functions::{GridFunctions, GridGradients};
pub use transfer::Transfer;

use super::parts::{FiniteBodies, Part};
use super::{Assembled, Discretization, Forced, PatchForces, PeriodicPatch, StrainOperator};
use crate::algebra::{Each, array_of};
use crate::bloch::{BlochBlocks, BlochSum, Mass, TransferredWaves, VelocityFilter, WaveSystem};
use crate::kinematics::DeformationGradient;
use crate::lattice::{BravaisLattice, Crystal, Fractional, LatticeError, Particle};
use crate::material::Hyperelastic;
use crate::method::{CurrentLattice, MethodError};
use crate::quadrature::gauss_line;
use functions::Profile;
use nalgebra::{DMatrix, SMatrix, SVector};
use point::{Cell, Point, State};
use std::collections::BTreeMap;
use step::Step;

/// Largest admissible number of material points along each side of a cell.
const MAXIMUM_PER_SIDE: usize = 8;
/// Stresses of the reference state below this fraction of the stiffness are rounding errors.
const UNSTRESSED: f64 = 1e-9;
/// Largest distance from a face of a cell, in units of the grid spacing, of points that are on the face.
const FACE: f64 = 1e-9;

/// Layout of the material points in a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum PointLayout {
    /// Centers of equal parts of the cell, with the volumes of the parts.
    Uniform,
    /// Gauss-Legendre points with their weights as volumes; up to three along each side.
    Gauss,
}

/// Dilatation that determines the stress of a material point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum PointDilatation {
    /// The volume ratio of the point.
    #[default]
    Point,
    /// The mean volume ratio of the points in the cell, `Fbar = (J' / J)^(1/D) F`, against locking of nearly incompressible laws (Coombs and others, Comput.
    /// Methods Appl. Mech. Eng. 333 (2018) 1). The forces do not derive from an energy.
    Cell,
}

/// Mass matrix that relates the forces on the nodes to accelerations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum GridMass {
    /// Lumped masses, `m_i = sum_p m_p N_ip`, as in nearly all codes.
    Lumped,
    /// Consistent mass matrix, `m_ij = sum_p m_p N_ip N_jp`; singular if waves vanish at all points.
    Consistent,
}

/// Degrees of freedom of the method and the masses that move with them.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Formulation {
    /// Nodes of a grid in the reference configuration, `f_i = -sum_p V_p P(F_p) grad N_i(X_p)`, `F_p = F + sum_j u_j (x) grad N_j(X_p)`.
    /// The points never leave their cells: the method is a finite element method with the points as quadrature.
    TotalLagrangian {
        /// Mass matrix of the nodes.
        mass: GridMass,
    },
    /// Nodes of the current grid, displaced by one step: `f_i = -sum_p v_p sigma_p grad N_i(x_p)`. The points move with the functions, `x_p = x_p^0 +
    /// sum_j N_j u_j`, `F_p = (1 + sum_j u_j (x) grad N_j) F`, and the grid is reset.
    Updated {
        /// Mass matrix of the nodes.
        mass: GridMass,
        /// Positions of the grid and the points in a state: both at `F X`, or undeformed with the stress of `F`.
        grid: CurrentLattice,
    },
    /// The points themselves, whose velocities change by the accelerations of the grid, `dv_p/dt = sum_i N_ip f_i / m_i`: the limit of small steps of
    /// the fluid-implicit-particle transfer.
    ///
    /// Points and deformation follow the velocities `v_i = sum_q m_q N_iq v_q / m_i` of the grid, `dx_p/dt = sum_i N_ip v_i`, `dF_p/dt = sum_i v_i
    /// (x) grad N_ip F_p`. The forces are computed as in `Updated`. The unknown of a wave is the time integral of the velocity of the point, not its
    /// displacement: components that vanish on the grid cause neither displacements nor forces.
    ///
    /// A [`Transfer`] that filters velocities once per step removes the components that vanish on the grid.
    /// The unknowns are then the nodes, the equations of motion are those of the updated form, and the decay of waves follows from the step; see
    /// [`Discretization::transferred`].
    Particles {
        /// Positions of the grid and the points, as for `Updated`.
        grid: CurrentLattice,
        /// Transfer of the point velocities through the grid in a step.
        #[cfg_attr(feature = "serde", serde(default))]
        transfer: Transfer,
    },
}

/// Choices that define a material point method on a chain, a square or a simple cubic grid.
///
/// By default one point at the center of each cell, linear functions, and the nodes as unknowns of the updated form.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(rename_all = "kebab-case", default, deny_unknown_fields)
)]
pub struct MaterialPointChoices {
    /// Distance between the nodes of the grid in the reference configuration; length.
    pub spacing: f64,
    /// Reference density; mass per reference volume.
    pub density: f64,
    /// Number `n` of material points along each side of a cell, for `n^D` points per cell.
    pub per_side: usize,
    /// Layout of the points in a cell.
    pub layout: PointLayout,
    /// Shift of all points along the axes, in units of the grid spacing.
    pub offset: [f64; 3],
    /// Functions of the grid nodes.
    pub functions: GridFunctions,
    /// Gradients used in forces and velocity gradients.
    pub gradients: GridGradients,
    /// Dilatation that determines the stress of a point.
    pub dilatation: PointDilatation,
    /// Degrees of freedom and masses.
    pub formulation: Formulation,
}

impl Default for MaterialPointChoices {
    fn default() -> Self {
        Self {
            spacing: 1.0,
            density: 1.0,
            per_side: 1,
            layout: PointLayout::Uniform,
            offset: [0.0; 3],
            functions: GridFunctions::Linear,
            gradients: GridGradients::Functions,
            dilatation: PointDilatation::Point,
            formulation: Formulation::Updated {
                mass: GridMass::Lumped,
                grid: CurrentLattice::Convected,
            },
        }
    }
}

/// Material point method on its grid. [`Discretization::crystal`] returns the crystal of the unknowns, which are the nodes or the points.
///
/// ```
/// use onset::kinematics::DeformationGradient;
/// use onset::material::ModifiedMooneyRivlin;
/// use onset::scheme::{MaterialPointChoices, MaterialPoints, Discretization};
/// use nalgebra::Vector2;
/// let points = MaterialPoints::<2>::new(MaterialPointChoices::default())?;
/// let waves = points.waves(&ModifiedMooneyRivlin::default(), &DeformationGradient::identity())?;
/// // Alternating nodes do not strain a single point in the middle of the cell.
/// let corner = Vector2::repeat(std::f64::consts::PI);
/// assert!(waves.omega_squared(&corner)[1].norm() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct MaterialPoints<const D: usize> {
    choices: MaterialPointChoices,
    grid: Crystal<D>,
    /// Points of a cell by lattice coordinates and volumes.
    points: Vec<(Fractional<D>, f64)>,
    crystal: Crystal<D>,
    profile: Profile,
}

impl<const D: usize> MaterialPoints<D> {
    /// Builds the method on its grid.
    ///
    /// # Errors
    /// [`MethodError`] if a setting is out of range, or if points lie where linear functions have no gradient.
    pub fn new(choices: MaterialPointChoices) -> Result<Self, MethodError> {
        let (spacing, density) = (choices.spacing, choices.density);
        for (name, value) in [("spacing", spacing), ("density", density)] {
            MethodError::positive(name, value)?;
        }
        check_domains(&choices)?;
        let lattice = BravaisLattice::new(SMatrix::<f64, D, D>::identity() * spacing)
            .filter(|lattice| lattice.cell_volume().is_normal())
            .ok_or(LatticeError::Spacing { value: spacing })?;
        let grid = Crystal::of_lattice(lattice);
        let points = laid_out::<D>(&choices, lattice.cell_volume())?;
        let crystal = match choices.formulation {
            Formulation::Particles { transfer, .. } if transfer.keeps_the_unseen() => {
                let (places, volumes) = points.iter().copied().unzip();
                Crystal::with_volumes(lattice, places, volumes)?
            }
            _ => grid.clone(),
        };
        if let Formulation::Particles { transfer, .. } = choices.formulation {
            transfer.check()?;
        }
        Ok(Self {
            profile: choices
                .functions
                .profile(0.5 / choices.per_side as f64, choices.gradients),
            choices,
            grid,
            points,
            crystal,
        })
    }

    /// Choices that define the method.
    pub fn choices(&self) -> &MaterialPointChoices {
        &self.choices
    }

    /// Positions of the material points of a cell, relative to a node and in units of the grid spacing, with their reference volumes.
    pub fn points(&self) -> &[(Fractional<D>, f64)] {
        &self.points
    }

    /// State of the grid for a homogeneous deformation.
    fn state<'a>(
        &self,
        material: &'a dyn Hyperelastic,
        f: &DeformationGradient,
    ) -> Result<State<'a, D>, MethodError> {
        if !f.is_block_diagonal::<D>() {
            return Err(MethodError::NotPlanar { dimension: D });
        }
        let reference = self.grid.lattice().vectors();
        let current = match self.choices.formulation {
            Formulation::TotalLagrangian { .. } => None,
            Formulation::Updated { grid, .. } | Formulation::Particles { grid, .. } => Some(grid),
        };
        let vectors = match current {
            Some(CurrentLattice::Convected) => f.leading::<D>() * reference,
            Some(CurrentLattice::Regular) | None => *reference,
        };
        State::new(material, f, &vectors, current.is_some())
    }

    /// Returns true if the unknowns are the points instead of the nodes.
    fn moves_points(&self) -> bool {
        match self.choices.formulation {
            Formulation::Particles { transfer, .. } => transfer.keeps_the_unseen(),
            _ => false,
        }
    }

    /// Returns the transfer that filters velocities once per step, if any, with its filter.
    fn transfer_of_a_step(&self) -> Option<(Transfer, VelocityFilter)> {
        match self.choices.formulation {
            Formulation::Particles { transfer, .. } => {
                transfer.filter().map(|filter| (transfer, filter))
            }
            _ => None,
        }
    }

    /// Linearized forces between nodes in a state.
    fn between_nodes(
        &self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
    ) -> Result<Forced<D>, MethodError> {
        let state = self.state(material, f)?;
        let mut forced = Forced::default();
        for cell in self.cells(state) {
            forced.add(&cell);
        }
        Ok(forced)
    }

    /// Returns true if the points of a cell share the mean of their dilatations.
    fn shares_dilatation(&self) -> bool {
        self.choices.dilatation == PointDilatation::Cell && self.points.len() > 1
    }

    /// Points of a cell that share a mean dilatation, or each point alone.
    fn cells<'a>(&'a self, state: State<'a, D>) -> Vec<Cell<'a, D>> {
        let point = |(place, volume): &(_, _)| Point::new(state, &self.profile, *place, *volume);
        let points = self.points.iter().map(point);
        match self.shares_dilatation() {
            true => vec![Cell::new(points.collect())],
            false => points.map(|point| Cell::new(vec![point])).collect(),
        }
    }

    /// Mass of the points of a cell, equal to the mass of a node.
    fn nodal_mass(&self) -> f64 {
        self.choices.density * self.grid.lattice().cell_volume()
    }

    fn mass(&self, mass: GridMass) -> Mass<D> {
        match mass {
            GridMass::Lumped => Mass::Lumped(vec![self.nodal_mass()]),
            GridMass::Consistent => Mass::Consistent(self.consistent_mass()),
        }
    }

    /// Consistent mass matrix `sum_p m_p N_ip N_jp`.
    fn consistent_mass(&self) -> BlochSum<D> {
        self.weighted_by_mass(|_, _, _| 1.0)
    }

    /// Map of the nodal velocities that are transferred to the points and back, `T_ij = sum_p m_p N_ip N_jp / m_i`; dimensionless.
    ///
    /// With affine fields the term of each pair of nodes is multiplied by `1 + (x_i - x_p) D_p^-1 (x_j - x_p)`.
    fn kept(&self, is_affine: bool) -> BlochSum<D> {
        let mass = self.nodal_mass();
        self.weighted_by_mass(|place, from, to| {
            let moment = |axis: usize| {
                let [own, other] = [from, to].each(|node| f64::from(node[axis]) - place[axis]);
                own * other / self.profile.second_moment(place[axis])
            };
            let affine = if is_affine {
                (0..D).map(moment).sum()
            } else {
                0.0
            };
            (1.0 + affine) / mass
        })
    }

    /// Largest stable step of an isolated material point in the unstressed reference state, the minimum over the positions of the points; time.
    /// `None` if the reference state is stressed.
    ///
    /// With the tangent `A` and `G = sum_i g_i (x) g_i / N_i` for the gradients `g_i`, the displacement gradient `l` and the affine field `C` of the
    /// point obey
    /// `l' = l + dt (C - dt (A : l) G / rho)`, `C' = C - dt (A : l) D^-1 / rho`; without affine fields `C = 0`. An amplification factor is -1 at
    /// `4 / dt^2 = max eig (A : l) (2 G - D^-1) / rho`, or at `max eig 2 (A : l) G / rho` without affine fields. FMPM(k) adds the accelerations of the
    /// nodes `k` times, because they vanish at the point: `max eig 2 k (A : l) G / rho`.
    fn step_of_an_isolated_point(
        &self,
        material: &dyn Hyperelastic,
        transfer: Transfer,
    ) -> Result<Option<f64>, MethodError> {
        let times = match transfer {
            Transfer::FullMass { order } => f64::from(order),
            _ => 1.0,
        };
        let response = material.undeformed()?;
        let stress = response.first_piola.amax();
        if stress > UNSTRESSED * response.tangent.largest() {
            return Ok(None);
        }
        let square_of = |place: &Fractional<D>| {
            let weights = self.stretch_of_an_isolated_point(place, transfer == Transfer::Affine);
            let root = |i: usize| weights[i].sqrt();
            let entry = |row: usize, column: usize| {
                let (i, j) = (row / D, row % D);
                let (k, l) = (column / D, column % D);
                response.tangent[(i, j, k, l)] * root(j) * root(l) / self.choices.density
            };
            let matrix = DMatrix::from_fn(D * D, D * D, entry);
            matrix.symmetric_eigenvalues().max()
        };
        let squares = self.points.iter().map(|(place, _)| square_of(place));
        let largest = times * squares.fold(0.0, f64::max);
        Ok((largest > 0.0).then(|| 2.0 / largest.sqrt()))
    }

    /// Diagonal of `2 G - D^-1`, or of `2 G` without affine fields; 1/length^2. Both are diagonal because the functions are products.
    fn stretch_of_an_isolated_point(&self, place: &Fractional<D>, is_affine: bool) -> [f64; D] {
        let squared = self.choices.spacing.powi(2);
        array_of(|i| {
            let moment = self.profile.second_moment(place[i]);
            let kept = if is_affine { 1.0 / moment } else { 0.0 };
            (2.0 * self.profile.squared_gradients(place[i]) - kept) / squared
        })
    }

    /// Sum `sum_p m_p N_ip N_jp w_ijp` with a weight that depends on the position of a point and the cells of two nodes.
    fn weighted_by_mass(
        &self,
        weight: impl Fn(&Fractional<D>, &[i32; D], &[i32; D]) -> f64,
    ) -> BlochSum<D> {
        let mut blocks = BlochBlocks::new();
        for (place, volume) in &self.points {
            let nodes = self.transfer(place);
            for (from, own) in &nodes {
                for (to, other) in &nodes {
                    let entry = self.choices.density * volume * own * other;
                    let weight = weight(place, &from.cell, &to.cell);
                    blocks.add(from, to, &(SMatrix::identity() * (entry * weight)));
                }
            }
        }
        blocks.sum(&self.grid)
    }

    /// Functions of the nodes at a position.
    fn transfer(&self, place: &Fractional<D>) -> Vec<(Particle<D>, f64)> {
        let at: [f64; D] = (*place).into();
        let node = |cell| {
            let value = self.profile.shape(&at, &cell).value;
            (Particle { site: 0, cell }, value)
        };
        self.profile.nodes(&at).into_iter().map(node).collect()
    }

    /// Contributions of the points to a sum over nodes with the velocities `v_i = sum_q m_q N_iq v_q / m_i`.
    fn through_nodes(
        &self,
        nodes: impl Iterator<Item = (Particle<D>, SVector<f64, D>)>,
    ) -> BTreeMap<Particle<D>, SVector<f64, D>> {
        let mut sums = BTreeMap::new();
        for (node, vector) in nodes {
            for (site, (place, volume)) in self.points.iter().enumerate() {
                let share = self.choices.density * volume / self.nodal_mass();
                for (seen, value) in self.transfer(place) {
                    // Cell of the translated point that reaches this node as the original point reaches `seen`.
                    let cell = array_of(|i| node.cell[i] - seen.cell[i]);
                    let sum = sums.entry(Particle { site, cell });
                    *sum.or_insert_with(SVector::zeros) += vector * (share * value);
                }
            }
        }
        sums
    }

    /// Stiffness between points from the stiffness between nodes, `K_pq = sum_ij (m_p N_ip / m_i) K_ij (m_q N_jq / m_j)`. No force acts in the
    /// homogeneous state, so that changes of the transfer itself do not contribute.
    fn between_points(&self, nodal: &BlochSum<D>) -> BlochBlocks<D> {
        let shares: Vec<Vec<(Particle<D>, f64)>> = self
            .points
            .iter()
            .map(|(place, volume)| {
                let share = self.choices.density * volume / self.nodal_mass();
                let nodes = self.transfer(place).into_iter();
                nodes.map(|(node, value)| (node, share * value)).collect()
            })
            .collect();
        // From the node at the origin to points, then from points to points.
        let mut half: BTreeMap<Particle<D>, SMatrix<f64, D, D>> = BTreeMap::new();
        for (_, node, block) in nodal.blocks() {
            for (site, nodes) in shares.iter().enumerate() {
                for (seen, share) in nodes {
                    let cell = array_of(|i| node.cell[i] - seen.cell[i]);
                    let entry = half.entry(Particle { site, cell });
                    *entry.or_insert_with(SMatrix::zeros) += block * *share;
                }
            }
        }
        let mut blocks = BlochBlocks::new();
        for (site, nodes) in shares.iter().enumerate() {
            let from = Particle::home(site);
            for (node, share) in nodes {
                for (to, block) in &half {
                    blocks.add(&from, &to.moved(&node.cell), &(block * *share));
                }
            }
        }
        blocks
    }

    /// Equations of motion for the velocities of the grid.
    ///
    /// `M^-1 K` between points is `A B` with `A_pi = N_ip / m_i`, `B_iq = sum_j K_ij N_jq m_q / m_j`. Its nonzero `omega^2` are the eigenvalues of
    /// `B A = K S / m`, `S_jk = sum_q m_q N_jq N_kq / m`.
    /// With one node per cell `S(k)` is a real number, and `K S` is as Hermitian as `K`.
    fn on_the_grid(&self, nodal: &BlochSum<D>) -> WaveSystem<D> {
        let mass = self.nodal_mass();
        let mut blocks = BlochBlocks::new();
        let consistent = self.consistent_mass();
        for (site, node, block) in nodal.blocks() {
            for (_, beyond, share) in consistent.blocks() {
                let to = beyond.moved(&node.cell);
                blocks.add(&Particle::home(site), &to, &(block * share / mass));
            }
        }
        let stiffness = blocks.sum(&self.grid);
        WaveSystem::new(self.grid.clone(), stiffness, Mass::Lumped(vec![mass]))
    }
}

/// Refuses moments of functions that depend on the deformation of a particle.
fn check_domains(choices: &MaterialPointChoices) -> Result<(), MethodError> {
    let is_affine = matches!(
        choices.formulation,
        Formulation::Particles {
            transfer: Transfer::Affine,
            ..
        }
    );
    let uses_moments = is_affine || choices.gradients == GridGradients::Moments;
    match choices.functions == GridFunctions::Cpdi && uses_moments {
        true => Err(MethodError::Incompatible {
            choice: "grid-functions = cpdi",
            other: "affine fields or gradients from moments",
            hint: "the moments of its functions change with the deformation of a particle; set discretization.transfer to flip, pic, xpic or fmpm, or grid-functions = gimp",
        }),
        false => Ok(()),
    }
}

fn laid_out<const D: usize>(
    choices: &MaterialPointChoices,
    cell_volume: f64,
) -> Result<Vec<(Fractional<D>, f64)>, MethodError> {
    let n = choices.per_side;
    let setting = |name, value, expected| MethodError::Setting {
        name,
        value,
        expected,
    };
    let along: Vec<(f64, f64)> = match choices.layout {
        PointLayout::Uniform if (1..=MAXIMUM_PER_SIDE).contains(&n) => (0..n)
            .map(|i| ((i as f64 + 0.5) / n as f64, 1.0 / n as f64))
            .collect(),
        PointLayout::Uniform => {
            return Err(setting(
                "points-per-side",
                n as f64,
                "a whole number from 1 to 8",
            ));
        }
        PointLayout::Gauss => {
            let refused = || setting("points-per-side", n as f64, "1, 2 or 3 with Gauss points");
            let line = (1..=3).contains(&n).then(|| gauss_line(n as u32)).flatten();
            line.ok_or_else(refused)?
        }
    };
    let mut points = vec![(Fractional::<D>::zeros(), cell_volume)];
    for axis in 0..D {
        let shift = choices.offset[axis];
        if !shift.is_finite() {
            return Err(setting("offset", shift, "finite numbers"));
        }
        let place = |x: f64| {
            let inside = (x + shift).rem_euclid(1.0);
            (inside, inside.min(1.0 - inside) < FACE)
        };
        let is_on_face = along.iter().any(|(x, _)| place(*x).1);
        if is_on_face && choices.functions == GridFunctions::Linear {
            let expected = "a shift that puts no point on a face of a cell, where linear functions have no gradient";
            return Err(setting("offset", shift, expected));
        }
        let extended = points.iter().flat_map(|(base, volume)| {
            along.iter().map(move |(x, weight)| {
                let mut moved = *base;
                moved[axis] = place(*x).0;
                (moved, volume * weight)
            })
        });
        points = extended.collect();
    }
    Ok(points)
}

impl<const D: usize> Discretization<D> for MaterialPoints<D> {
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
        let mut forced = self.between_nodes(material, f)?;
        match self.choices.formulation {
            Formulation::TotalLagrangian { mass } | Formulation::Updated { mass, .. } => {
                forced.waves(&self.grid, self.mass(mass))
            }
            Formulation::Particles { .. } if !self.moves_points() => {
                forced.waves(&self.grid, self.mass(GridMass::Lumped))
            }
            Formulation::Particles { .. } => {
                let nodal = std::mem::take(&mut forced.stiffness).sum(&self.grid);
                forced.stiffness = self.between_points(&nodal);
                let mass = super::lumped_masses(&self.crystal, self.choices.density);
                let system = forced.waves(&self.crystal, Mass::Lumped(mass))?;
                // With one point per node the transfer has no null space.
                Ok(match self.points.len() {
                    1 => system,
                    _ => system.with_reduced(self.on_the_grid(&nodal)),
                })
            }
        }
    }

    fn strain(&self) -> Result<StrainOperator<D>, MethodError> {
        let inverse = self.grid.lattice().reciprocal() / std::f64::consts::TAU;
        let mut strain = StrainOperator::new();
        let mut points: Vec<(f64, BTreeMap<Particle<D>, SVector<f64, D>>)> = Vec::new();
        for (place, volume) in &self.points {
            let at: [f64; D] = (*place).into();
            let nodes = self.profile.nodes(&at).into_iter().map(|cell| {
                let slope: SVector<f64, D> = self.profile.shape(&at, &cell).slope.into();
                (Particle { site: 0, cell }, inverse * slope)
            });
            let gradients: BTreeMap<_, _> = match self.moves_points() {
                true => self.through_nodes(nodes),
                false => nodes.collect(),
            };
            points.push((*volume, gradients));
        }
        if !self.shares_dilatation() {
            for (_, gradients) in points {
                let (particles, gradients): (Vec<_>, Vec<_>) = gradients.into_iter().unzip();
                strain.add_strain(&particles, gradients);
            }
            return Ok(strain);
        }
        let mut particles: Vec<Particle<D>> = points
            .iter()
            .flat_map(|(_, own)| own.keys().copied())
            .collect();
        particles.sort_unstable();
        particles.dedup();
        let of_all = |own: &BTreeMap<Particle<D>, SVector<f64, D>>| {
            let gradient = |particle| own.get(particle).copied().unwrap_or_else(SVector::zeros);
            particles.iter().map(gradient).collect::<Vec<_>>()
        };
        let points: Vec<_> = points
            .iter()
            .map(|(volume, own)| (*volume, of_all(own)))
            .collect();
        strain.add_with_mean_dilatation(&particles, &points);
        Ok(strain)
    }

    fn with_forces(
        &self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
        patch: &PeriodicPatch<D>,
        work: &mut dyn FnMut(&dyn PatchForces<D>),
    ) -> Result<(), MethodError> {
        let state = self.state(material, f)?;
        if let Formulation::TotalLagrangian { .. } = self.choices.formulation {
            work(&Assembled::new(patch, &self.cells(state)));
            return Ok(());
        }
        work(&Step::new(state, self, patch.cells()));
        Ok(())
    }

    fn transferred(
        &self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
    ) -> Result<Option<TransferredWaves<D>>, MethodError> {
        let Some((transfer, filter)) = self.transfer_of_a_step() else {
            return Ok(None);
        };
        let forced = self.between_nodes(material, f)?;
        let system = forced.waves(&self.grid, self.mass(GridMass::Lumped))?;
        let kept = self.kept(transfer == Transfer::Affine);
        let alone = self.step_of_an_isolated_point(material, transfer)?;
        let waves = TransferredWaves::new(system, &kept, filter);
        Ok(Some(waves.with_isolated_point(alone)))
    }

    fn finite_bodies(
        &self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
    ) -> Result<Option<FiniteBodies>, MethodError> {
        let is_lumped = match self.choices.formulation {
            Formulation::TotalLagrangian { mass } | Formulation::Updated { mass, .. } => {
                mass == GridMass::Lumped
            }
            // With a transfer an isolated point limits the step: [`TransferredWaves::isolated_point`].
            Formulation::Particles { .. } => {
                !self.moves_points() && self.transfer_of_a_step().is_none()
            }
        };
        // The mean dilatation of a cell depends on the points that it holds.
        if !is_lumped || self.shares_dilatation() {
            return Ok(None);
        }
        let state = self.state(material, f)?;
        let part = |(place, volume): &(Fractional<D>, f64)| {
            let point = Point::new(state, &self.profile, *place, *volume);
            let shares = self.transfer(place).into_iter();
            let (nodes, masses): (Vec<_>, Vec<f64>) = shares
                .map(|(node, share)| (node, self.choices.density * volume * share))
                .unzip();
            let mut part = Part::new(&nodes, DMatrix::from_diagonal(&masses.into()));
            part.add(&point);
            part
        };
        Ok(Part::bound(self.points.iter().map(part)))
    }

    /// Number of pairs of a point and a node in its support, for each unknown node or point.
    fn neighbors(&self) -> f64 {
        let seen = |(place, _): &(Fractional<D>, f64)| {
            let nodes = self.transfer(place).into_iter();
            nodes.filter(|(_, value)| *value > FACE).count()
        };
        let pairs: usize = self.points.iter().map(seen).sum();
        pairs as f64 / self.crystal.sites().len() as f64
    }
}
