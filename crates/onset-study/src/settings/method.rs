//! Families of methods, and the settings of all families except the kernel methods.

use super::declared::{declared, words};
use super::key::IN_SPACINGS;
use super::needs::{Cases, is, is_not};
use onset::material::Admitted::{Any, Fraction, NotNegative, Positive, Within};
use onset::method::CurrentLattice;
use onset::scheme::conforming::SmoothingDomain;
use onset::scheme::element::{ElementMass, ElementMesh, ElementOrder, HourglassScale, Integration};
use onset::scheme::sph::{DensityEvolution, MomentumForm, ParticleGradient};
use onset::scheme::stabilization::{PenaltyForm, SmoothedMotion, Upwinding, ViscositySwitch};
use onset::scheme::{
    Calibration, GridFunctions, GridGradients, GridMass, Influence, PartialVolumes,
    PointDilatation, PointLayout,
};
use serde::{Deserialize, Serialize};

/// Family of discretization methods.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Family {
    /// Kernel methods: shape functions of particles, with forces integrated at points.
    Kernel,
    /// Smoothed particle hydrodynamics with kernels in material coordinates.
    TotalLagrangianSph,
    /// Smoothed particle hydrodynamics with kernels in current coordinates.
    UpdatedSph,
    /// Finite elements on a periodic mesh.
    FiniteElements,
    /// Stabilized conforming nodal integration.
    Conforming,
    /// Bond-based and correspondence peridynamics.
    Peridynamics,
    /// Material point methods with a background grid.
    MaterialPoints,
}

/// Constitutive model of the bonds of a peridynamic body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Bonds {
    /// Linear springs between particles.
    BondBased,
    /// The linear peridynamic solid, an ordinary state-based model.
    Ordinary,
    /// Stress at the deformation gradient of the family.
    Correspondence,
    /// Stress at the deformation gradient of each bond, acting on its ends.
    BondAssociatedFormI,
    /// Stress at the deformation gradient of each bond, acting on its neighbors.
    #[serde(rename = "bond-associated-form-ii")]
    BondAssociatedFormII,
    /// Stress at the mean deformation gradient of the families at the ends of a bond, corrected along the bond.
    BondAveraged,
}

/// Forces of the shear stress in SPH.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shear {
    /// All stress components act through kernel gradients.
    Stress,
    /// Shear as pairwise forces between particles.
    Pairs,
}

/// Control of the zero-energy modes of correspondence peridynamics.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Control {
    /// No control of zero-energy modes.
    None,
    /// Springs against the nonuniform deformation.
    Penalty,
    /// Hourglass forces along bonds.
    Hourglass,
    /// Springs of the elasticity tensor and the shape tensor.
    StiffnessTensor,
}

/// The unknowns of a material point method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Unknowns {
    /// Displacements of the nodes of a grid in the reference configuration.
    TotalLagrangian,
    /// Displacements of the nodes of the current grid, for one step: the original method.
    Updated,
    /// Displacements of the material points.
    Particles,
}

/// Transfer of the velocities of material points through the grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Velocities {
    /// No transfer: continuous time.
    Continuous,
    /// FLIP: points keep their velocities and add the change of the grid velocities.
    Flip,
    /// PIC: points take the grid velocities.
    Pic,
    /// APIC: points take the grid velocities with affine fields.
    Apic,
    /// XPIC: points keep the part of their velocities that an approximation of the full mass matrix resolves.
    Xpic,
    /// FMPM: an approximation of the full mass matrix replaces the lumped masses.
    Fmpm,
}

impl Velocities {
    /// The word used in files and on the command line.
    pub fn name(self) -> &'static str {
        words::<Self>()
            .get(self as usize)
            .copied()
            .unwrap_or_default()
    }
}

declared! {
    /// Family of methods, and the settings of families other than kernel methods. Lattice, spacing, density, kernel, support, approximation and support
    /// size are settings of the discretization.
    pub struct MethodSettings, METHOD_KEYS of "discretization" {
        /// Family of discretization methods.
        method: Family = Family::Kernel, Words;
        /// SPH: gradients corrected to be exact for linear fields (PySPH: false).
        corrected: bool = true, Switch, SPH;
        /// Total-Lagrangian SPH: deformation gradient of a particle, by the kernel or as a mean over bonds that includes the gradient by the kernel.
        gradient: ParticleGradient = ParticleGradient::Kernel, Words, TOTAL_SPH;
        /// Updated SPH: stresses act along corrected gradients too (LAMMPS' *GRADIENT_CORRECTION); requires discretization.corrected.
        corrected_forces: bool = false, Switch, UPDATED_SPH;
        /// Updated SPH: form of the pair force in terms of the two stresses.
        momentum: MomentumForm = MomentumForm::Symmetric, Words, UPDATED_SPH;
        /// Updated SPH: density from summation or from the continuity equation.
        density_evolution: DensityEvolution = DensityEvolution::Continuity, Words, UPDATED_SPH;
        /// SPH: coefficient of the zero-energy-mode penalty (Ganzenmueller; updated SPH: xi of the generalized non-hourglass formulation of SPHinXsys).
        penalty: f64 = 0.0, Number("1", NotNegative), SPH;
        /// Total-Lagrangian SPH: form of the penalty, published or as in LAMMPS' SMD (regularized denominators; the coefficient is the hourglass amplitude).
        penalty_form: PenaltyForm = PenaltyForm::Published, Words, PENALIZED_TOTAL_SPH;
        /// SPH: shear forces from the particle stresses, or pairwise (the essentially non-hourglass formulations of SPHinXsys).
        shear_forces: Shear = Shear::Stress, Words, SPH;
        /// SPH: coefficient of shear forces between pairs [default: the published one, 1.07, or 0.7 d + 2.1 for updated SPH in d dimensions].
        shear_coefficient: Option<f64> = None, Number("1", Positive), PAIRWISE;
        /// SPH: linear coefficient of artificial viscosity (Monaghan).
        viscosity: f64 = 0.0, Number("1", NotNegative), SPH;
        /// SPH: artificial viscosity at all times, averaged over compression and expansion, or as in LAMMPS' SMD.
        viscosity_switch: ViscositySwitch = ViscositySwitch::Averaged, Words, VISCOUS;
        /// Total-Lagrangian SPH: dissipation of an acoustic Riemann solver on pairs, none, or for velocities constant or linear around each particle.
        upwinding: Upwinding = Upwinding::None, Words, TOTAL_SPH;
        /// Updated SPH: coefficient of artificial stress (Gray, Monaghan, Swift).
        artificial_stress: f64 = 0.0, Number("1", NotNegative), UPDATED_SPH;
        /// Updated SPH: exponent of artificial stress.
        artificial_stress_exponent: f64 = 4.0, Number("1", Within(0.0, 100.0)), ARTIFICIALLY_STRESSED;
        /// SPH: coefficient of smoothed velocities (XSPH).
        velocity_smoothing: f64 = 0.0, Number("1", NotNegative), SPH;
        /// Updated SPH: use of the smoothed velocities, for the whole motion or for positions only, as in PySPH.
        smoothed_motion: SmoothedMotion = SmoothedMotion::Everything, Words, SMOOTHED;
        /// Finite elements: mesh, which replaces the lattice.
        mesh: ElementMesh = ElementMesh::Quadrilaterals, Words, ELEMENTS;
        /// Finite elements: nodes at the corners, or also in the middles of the edges.
        element_order: ElementOrder = ElementOrder::Linear, Words, ELEMENTS;
        /// Finite elements: integration points, with the mean dilatation of the element for nearly incompressible laws.
        integration: Integration = Integration::Full, Words, MULTILINEAR;
        /// Finite elements: coefficient of hourglass stiffness (Flanagan, Belytschko).
        hourglass_stiffness: f64 = 0.0, Number("1", NotNegative), ONE_POINT;
        /// Finite elements: coefficient of hourglass viscosity (Flanagan, Belytschko).
        hourglass_viscosity: f64 = 0.0, Number("1", NotNegative), ONE_POINT;
        /// Finite elements: scale of the hourglass coefficients, gradients or sizes as in Radioss.
        hourglass_scale: HourglassScale = HourglassScale::Gradients, Words, HOURGLASS;
        /// Finite elements: mass matrix; hrz: lumped in proportion to the diagonal of the consistent matrix (Hinton, Rock, Zienkiewicz).
        mass: ElementMass = ElementMass::Lumped, Words, ELEMENTS;
        /// Conforming nodal integration: cells over which gradients are averaged (SCNI, SNNI).
        smoothing_domain: SmoothingDomain = SmoothingDomain::Voronoi, Words, CONFORMING;
        /// Conforming nodal integration: coefficient of the modification (M-SCNI).
        modification: f64 = 0.0, Number("1", Fraction), CONFORMING;
        /// Peridynamics: horizon in particle spacings of the regular lattice.
        horizon: f64 = 3.0, Number("1", IN_SPACINGS), PERIDYNAMICS;
        /// Peridynamics: weights of the bonds.
        influence: Influence = Influence::Constant, Words, PERIDYNAMICS;
        /// Peridynamics: treatment of particle volumes that the horizon cuts.
        partial_volumes: PartialVolumes = PartialVolumes::Whole, Words, PERIDYNAMICS;
        /// Peridynamics: the force between particles.
        bonds: Bonds = Bonds::BondBased, Words, PERIDYNAMICS;
        /// Bond-based peridynamics: calibration of the micromodulus.
        calibration: Calibration = Calibration::Continuum, Words, BONDS;
        /// Correspondence peridynamics: control of zero-energy modes.
        control: Control = Control::None, Words, CORRESPONDENCE;
        /// Correspondence peridynamics: coefficient of the control of zero-energy modes.
        control_coefficient: f64 = 0.0, Number("1", NotNegative), CONTROL;
        /// Correspondence peridynamics: forces contain the influence function (PeriLab up to version 2.2.4: false).
        weighted_forces: bool = true, Switch, CORRESPONDENCE;
        /// Material points along each side of a cell.
        points_per_side: u32 = 2, Whole(1, 8), POINTS;
        /// Material points: positions in their cell.
        layout: PointLayout = PointLayout::Uniform, Words, SEVERAL_POINTS;
        /// Material points: shift of all points along each axis, in spacings.
        offset: f64 = 0.0, Number("1", Any), POINTS;
        /// Material points: shape functions of the grid.
        grid_functions: GridFunctions = GridFunctions::Linear, Words, POINTS;
        /// Material points: gradients in forces and velocity gradients, of the functions or first moments as in MLS-MPM.
        grid_gradients: GridGradients = GridGradients::Functions, Words, SMOOTH_FUNCTIONS;
        /// Material points: dilatation for the stress, of the point itself or the mean of all points in the cell (F-bar), against locking.
        dilatation: PointDilatation = PointDilatation::Point, Words, SEVERAL_POINTS;
        /// Material points: points that carry the unknowns.
        unknowns: Unknowns = Unknowns::Updated, Words, POINTS;
        /// Material points: transfer of velocities through the grid, in continuous time or once per time step.
        transfer: Velocities = Velocities::Continuous, Words, PARTICLE_UNKNOWNS;
        /// Material points: fraction of its velocity that a point keeps in a step, from 0 (PIC) to 1 (FLIP).
        flip_share: f64 = 1.0, Number("1", Fraction), FLIP;
        /// Material points: order k of XPIC(k) or FMPM(k), terms of the inverse of the full mass matrix; 1 for PIC.
        transfer_order: u32 = 2, Whole(1, 100), OF_AN_ORDER;
        /// Material points: time step for growth rates and onset simulate; 0 for half of the largest stable step.
        time_step: f64 = 0.0, Number("time", NotNegative), TRANSFERRED;
        /// Material points: mass matrix of the grid.
        grid_mass: GridMass = GridMass::Lumped, Words, NODES;
        /// Material points: positions of grid and points in the deformed state.
        grid: CurrentLattice = CurrentLattice::Convected, Words, CURRENT;
    }
}

/// Key of the time step for growth rates, which is also the default step of simulations. It affects nothing else.
pub(crate) const STEP_OF_RATES: &str = "discretization.time-step";

impl MethodSettings {
    /// Time step for growth rates of material points with a transfer: as set, or half of the largest stable step; `None` if neither is known.
    pub fn step_of_rates(&self, largest: Option<f64>) -> Option<f64> {
        match self.time_step {
            0.0 => largest.map(|step| 0.5 * step),
            step => Some(step),
        }
    }
}

const METHOD: &str = "discretization.method";
pub(super) const KERNEL_METHOD: Cases = &[&[is(METHOD, &["kernel"])]];
/// Particles on a lattice, or in its cells.
pub(super) const CRYSTAL: Cases = &[&[is_not(METHOD, &["finite-elements", "material-points"])]];
/// Particles on a lattice, or nodes of a mesh.
pub(super) const NODES_OR_PARTICLES: Cases = &[&[is_not(METHOD, &["material-points"])]];
/// Particles on a lattice, or points in the cells of a grid.
pub(super) const LATTICE: Cases = &[&[is_not(METHOD, &["finite-elements"])]];
/// Methods with weight functions of finite support.
pub(super) const WEIGHTED: Cases = &[&[is(
    METHOD,
    &[
        "kernel",
        "total-lagrangian-sph",
        "updated-sph",
        "conforming",
    ],
)]];
pub(super) const APPROXIMATED: Cases = &[&[is(METHOD, &["kernel", "conforming"])]];
const SPH: Cases = &[&[is(METHOD, &["total-lagrangian-sph", "updated-sph"])]];
const VISCOUS: Cases = &[&[is_not("discretization.viscosity", &["0"])]];
const PAIRWISE: Cases = &[&[is("discretization.shear-forces", &["pairs"])]];
const TOTAL_SPH: Cases = &[&[is(METHOD, &["total-lagrangian-sph"])]];
const PENALIZED_TOTAL_SPH: Cases = &[&[
    is(METHOD, &["total-lagrangian-sph"]),
    is_not("discretization.penalty", &["0"]),
]];
const UPDATED_SPH: Cases = &[&[is(METHOD, &["updated-sph"])]];
const ARTIFICIALLY_STRESSED: Cases = &[&[is_not("discretization.artificial-stress", &["0"])]];
const SMOOTHED: Cases = &[&[
    is(METHOD, &["updated-sph"]),
    is_not("discretization.velocity-smoothing", &["0"]),
]];
const ELEMENTS: Cases = &[&[is(METHOD, &["finite-elements"])]];
/// Elements with a varying gradient.
const MULTILINEAR: Cases = &[&[
    is("discretization.mesh", &["quadrilaterals", "bricks"]),
    is("discretization.element-order", &["linear"]),
]];
const ONE_POINT: Cases = &[&[is("discretization.integration", &["one-point"])]];
/// Elements with hourglass control.
const HOURGLASS: Cases = &[
    &[is_not("discretization.hourglass-stiffness", &["0"])],
    &[is_not("discretization.hourglass-viscosity", &["0"])],
];
const CONFORMING: Cases = &[&[is(METHOD, &["conforming"])]];
const PERIDYNAMICS: Cases = &[&[is(METHOD, &["peridynamics"])]];
const BONDS: Cases = &[&[is("discretization.bonds", &["bond-based"])]];
const CORRESPONDENCE: Cases = &[&[is("discretization.bonds", &["correspondence"])]];
const CONTROL: Cases = &[&[is(
    "discretization.control",
    &["penalty", "hourglass", "stiffness-tensor"],
)]];
const POINTS: Cases = &[&[is(METHOD, &["material-points"])]];
const SEVERAL_POINTS: Cases = &[&[is_not("discretization.points-per-side", &["1"])]];
const NODES: Cases = &[&[is(
    "discretization.unknowns",
    &["total-lagrangian", "updated"],
)]];
const SMOOTH_FUNCTIONS: Cases = &[&[is(
    "discretization.grid-functions",
    &["gimp", "quadratic-spline", "cubic-spline"],
)]];
const PARTICLE_UNKNOWNS: Cases = &[&[is("discretization.unknowns", &["particles"])]];
const FLIP: Cases = &[&[is("discretization.transfer", &["flip"])]];
const OF_AN_ORDER: Cases = &[&[is("discretization.transfer", &["xpic", "fmpm"])]];
const TRANSFERRED: Cases = &[&[is(
    "discretization.transfer",
    &["flip", "pic", "apic", "xpic", "fmpm"],
)]];
const CURRENT: Cases = &[&[is("discretization.unknowns", &["updated", "particles"])]];
