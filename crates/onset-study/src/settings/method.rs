//! Families of methods, and the settings of all families except the kernel methods.

use super::Value;
use super::key::{IN_SPACINGS, Key, Kind, key};
use super::needs::{Cases, is, is_not};
use onset::material::Admitted::{Any, Fraction, NotNegative, Positive, Within};
use onset::method::CurrentLattice;
use onset::scheme::conforming::SmoothingDomain;
use onset::scheme::element::{ElementMass, ElementMesh, ElementOrder, HourglassScale, Integration};
use onset::scheme::sph::{DensityEvolution, MomentumForm};
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

impl Family {
    /// Values of `discretization.method`, in the order of the variants.
    pub const WORDS: &'static [&'static str] = &[
        "kernel",
        "total-lagrangian-sph",
        "updated-sph",
        "finite-elements",
        "conforming",
        "peridynamics",
        "material-points",
    ];
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
        match self {
            Self::Continuous => "continuous",
            Self::Flip => "flip",
            Self::Pic => "pic",
            Self::Apic => "apic",
            Self::Xpic => "xpic",
            Self::Fmpm => "fmpm",
        }
    }
}

/// Family of methods, and the settings of families other than kernel methods. Lattice, spacing, density, kernel, support, approximation and support
/// size are settings of the discretization.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub struct MethodSettings {
    /// Family that the method belongs to.
    pub method: Family,
    /// SPH: whether gradients are exact for linear fields.
    pub corrected: bool,
    /// SPH with corrected gradients: whether the forces use them too.
    pub corrected_forces: bool,
    /// Updated SPH: form of the forces.
    pub momentum: MomentumForm,
    /// Updated SPH: density from summation or from the continuity equation.
    pub density_evolution: DensityEvolution,
    /// SPH: coefficient of the zero-energy-mode penalty.
    pub penalty: f64,
    /// Total-Lagrangian SPH: form of the penalty.
    pub penalty_form: PenaltyForm,
    /// SPH: forces of the shear stress.
    pub shear_forces: Shear,
    /// SPH: coefficient of shear forces between pairs; `None` for the published one.
    pub shear_coefficient: Option<f64>,
    /// SPH: linear coefficient of artificial viscosity, or zero.
    pub viscosity: f64,
    /// SPH: condition and lengths of artificial viscosity.
    pub viscosity_switch: ViscositySwitch,
    /// Total-Lagrangian SPH: dissipation of a Riemann solver between pairs.
    pub upwinding: Upwinding,
    /// Updated SPH: coefficient of artificial stress, or zero.
    pub artificial_stress: f64,
    /// Updated SPH: exponent of artificial stress.
    pub artificial_stress_exponent: f64,
    /// SPH: coefficient of XSPH velocity smoothing.
    pub velocity_smoothing: f64,
    /// Updated SPH: fields that follow the smoothed velocities.
    pub smoothed_motion: SmoothedMotion,
    /// Finite elements: the mesh.
    pub mesh: ElementMesh,
    /// Finite elements: degree of the shape functions.
    pub element_order: ElementOrder,
    /// Finite elements: integration points.
    pub integration: Integration,
    /// Finite elements: coefficient of hourglass stiffness.
    pub hourglass_stiffness: f64,
    /// Finite elements: coefficient of hourglass viscosity.
    pub hourglass_viscosity: f64,
    /// Finite elements: scale of both hourglass coefficients.
    pub hourglass_scale: HourglassScale,
    /// Finite elements: mass matrix.
    pub mass: ElementMass,
    /// Conforming nodal integration: domains of strain smoothing.
    pub smoothing_domain: SmoothingDomain,
    /// Conforming nodal integration: coefficient of the modification.
    pub modification: f64,
    /// Peridynamics: the horizon in spacings.
    pub horizon: f64,
    /// Peridynamics: weights of the bonds.
    pub influence: Influence,
    /// Peridynamics: treatment of volumes at the horizon.
    pub partial_volumes: PartialVolumes,
    /// Peridynamics: the force between particles.
    pub bonds: Bonds,
    /// Bond-based peridynamics: calibration of the micromodulus.
    pub calibration: Calibration,
    /// Correspondence peridynamics: control of zero-energy modes.
    pub control: Control,
    /// Correspondence peridynamics: coefficient of this control.
    pub control_coefficient: f64,
    /// Correspondence peridynamics: whether forces contain the influence function.
    pub weighted_forces: bool,
    /// Material points: number of points along each side of a cell.
    pub points_per_side: u32,
    /// Material points: positions of the points in their cell.
    pub layout: PointLayout,
    /// Material points: shift of all points along each axis, in spacings.
    pub offset: f64,
    /// Material points: shape functions of the grid.
    pub grid_functions: GridFunctions,
    /// Material points: gradients in forces and velocity gradients.
    pub grid_gradients: GridGradients,
    /// Dilatation that determines the stress of a material point.
    pub dilatation: PointDilatation,
    /// Material points: unknowns of the method.
    pub unknowns: Unknowns,
    /// Material points: transfer of velocities through the grid.
    pub transfer: Velocities,
    /// Material points: fraction of its velocity that a point keeps in a step (FLIP).
    pub flip_share: f64,
    /// Material points: order of the approximation of the full mass matrix (XPIC, FMPM).
    pub transfer_order: u32,
    /// Material points: time step for growth rates; zero selects half of the largest stable step.
    pub time_step: f64,
    /// Material points: masses of the nodes.
    pub grid_mass: GridMass,
    /// Material points: configuration of grid and points at a state.
    pub grid: CurrentLattice,
}

impl Default for MethodSettings {
    fn default() -> Self {
        Self {
            method: Family::Kernel,
            corrected: true,
            corrected_forces: false,
            momentum: MomentumForm::Symmetric,
            density_evolution: DensityEvolution::Continuity,
            penalty: 0.0,
            penalty_form: PenaltyForm::Published,
            shear_forces: Shear::Stress,
            shear_coefficient: None,
            viscosity: 0.0,
            viscosity_switch: ViscositySwitch::Averaged,
            upwinding: Upwinding::None,
            artificial_stress: 0.0,
            artificial_stress_exponent: 4.0,
            velocity_smoothing: 0.0,
            smoothed_motion: SmoothedMotion::Everything,
            mesh: ElementMesh::Quadrilaterals,
            element_order: ElementOrder::Linear,
            integration: Integration::Full,
            hourglass_stiffness: 0.0,
            hourglass_viscosity: 0.0,
            hourglass_scale: HourglassScale::Gradients,
            mass: ElementMass::Lumped,
            smoothing_domain: SmoothingDomain::Voronoi,
            modification: 0.0,
            horizon: 3.0,
            influence: Influence::Constant,
            partial_volumes: PartialVolumes::Whole,
            bonds: Bonds::BondBased,
            calibration: Calibration::Continuum,
            control: Control::None,
            control_coefficient: 0.0,
            weighted_forces: true,
            points_per_side: 2,
            layout: PointLayout::Uniform,
            offset: 0.0,
            grid_functions: GridFunctions::Linear,
            grid_gradients: GridGradients::Functions,
            dilatation: PointDilatation::Point,
            unknowns: Unknowns::Updated,
            transfer: Velocities::Continuous,
            flip_share: 1.0,
            transfer_order: 2,
            time_step: 0.0,
            grid_mass: GridMass::Lumped,
            grid: CurrentLattice::Convected,
        }
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

    /// Sets a value by its name; returns false if the name is unknown or the value is of a wrong kind.
    pub(super) fn set(&mut self, name: &str, value: &Value) -> bool {
        let Ok(serde_json::Value::Object(mut fields)) = serde_json::to_value(&*self) else {
            return false;
        };
        let Some(field) = fields.get_mut(name) else {
            return false;
        };
        *field = match value {
            Value::Number(number) if field.is_u64() => (*number as u64).into(),
            Value::Number(number) => (*number).into(),
            Value::Word(word) => word.as_str().into(),
            Value::Switch(on) => (*on).into(),
            Value::Numbers(_) | Value::Words(_) => return false,
        };
        match serde_json::from_value(serde_json::Value::Object(fields)) {
            Ok(changed) => {
                *self = changed;
                true
            }
            Err(_) => false,
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

/// Keys of the families of methods, in the order of the documentation.
pub(super) const METHOD_KEYS: &[Key] = &[
    key(
        "discretization.method",
        Kind::Words(Family::WORDS),
        "family of methods",
    ),
    key(
        "discretization.corrected",
        Kind::Switch,
        "SPH: gradients corrected to be exact for linear fields (PySPH: false)",
    )
    .only_with(SPH),
    key(
        "discretization.corrected-forces",
        Kind::Switch,
        "updated SPH: stresses act along corrected gradients too (LAMMPS' *GRADIENT_CORRECTION); requires discretization.corrected",
    )
    .only_with(UPDATED_SPH),
    key(
        "discretization.momentum",
        Kind::Words(&["symmetric", "mean", "difference"]),
        "updated SPH: form of the pair force in terms of the two stresses",
    )
    .only_with(UPDATED_SPH),
    key(
        "discretization.density-evolution",
        Kind::Words(&["summation", "continuity"]),
        "updated SPH: density from summation or from the continuity equation",
    )
    .only_with(UPDATED_SPH),
    key(
        "discretization.penalty",
        Kind::Number("1", NotNegative),
        "SPH: coefficient of the zero-energy-mode penalty (Ganzenmueller; updated SPH: xi of the generalized non-hourglass formulation of SPHinXsys)",
    )
    .only_with(SPH),
    key(
        "discretization.penalty-form",
        Kind::Words(&["published", "smd"]),
        "total-Lagrangian SPH: form of the penalty, published or as in LAMMPS' SMD (regularized denominators; the coefficient is the hourglass amplitude)",
    )
    .only_with(PENALIZED_TOTAL_SPH),
    key(
        "discretization.shear-forces",
        Kind::Words(&["stress", "pairs"]),
        "SPH: shear forces from the particle stresses, or pairwise (the essentially non-hourglass formulations of SPHinXsys)",
    )
    .only_with(SPH),
    key(
        "discretization.shear-coefficient",
        Kind::Number("1", Positive),
        "SPH: coefficient of shear forces between pairs [default: the published one, 1.07, or 0.7 d + 2.1 for updated SPH in d dimensions]",
    )
    .only_with(PAIRWISE),
    key(
        "discretization.viscosity",
        Kind::Number("1", NotNegative),
        "SPH: linear coefficient of artificial viscosity (Monaghan)",
    )
    .only_with(SPH),
    key(
        "discretization.viscosity-switch",
        Kind::Words(&["always", "averaged", "smd"]),
        "SPH: artificial viscosity at all times, averaged over compression and expansion, or as in LAMMPS' SMD",
    )
    .only_with(VISCOUS),
    key(
        "discretization.upwinding",
        Kind::Words(&["none", "constant", "linear"]),
        "total-Lagrangian SPH: dissipation of an acoustic Riemann solver on pairs, none, or for velocities constant or linear around each particle",
    )
    .only_with(TOTAL_SPH),
    key(
        "discretization.artificial-stress",
        Kind::Number("1", NotNegative),
        "updated SPH: coefficient of artificial stress (Gray, Monaghan, Swift)",
    )
    .only_with(UPDATED_SPH),
    key(
        "discretization.artificial-stress-exponent",
        Kind::Number("1", Within(0.0, 100.0)),
        "updated SPH: exponent of artificial stress",
    )
    .only_with(ARTIFICIALLY_STRESSED),
    key(
        "discretization.velocity-smoothing",
        Kind::Number("1", NotNegative),
        "SPH: coefficient of smoothed velocities (XSPH)",
    )
    .only_with(SPH),
    key(
        "discretization.smoothed-motion",
        Kind::Words(&["everything", "positions"]),
        "updated SPH: use of the smoothed velocities, for the whole motion or for positions only, as in PySPH",
    )
    .only_with(SMOOTHED),
    key(
        "discretization.mesh",
        Kind::Words(&[
            "bars",
            "quadrilaterals",
            "triangles",
            "triangles-alternating",
            "triangles-crossed",
            "triangles-equilateral",
            "bricks",
            "tetrahedra",
            "tetrahedra-alternating",
            "tetrahedra-body-centered",
        ]),
        "finite elements: mesh, which replaces the lattice",
    )
    .only_with(ELEMENTS),
    key(
        "discretization.element-order",
        Kind::Words(&["linear", "quadratic"]),
        "finite elements: nodes at the corners, or also in the middles of the edges",
    )
    .only_with(ELEMENTS),
    key(
        "discretization.integration",
        Kind::Words(&["full", "mean-dilatation", "one-point"]),
        "finite elements: integration points, with the mean dilatation of the element for nearly incompressible laws",
    )
    .only_with(MULTILINEAR),
    key(
        "discretization.hourglass-stiffness",
        Kind::Number("1", NotNegative),
        "finite elements: coefficient of hourglass stiffness (Flanagan, Belytschko)",
    )
    .only_with(ONE_POINT),
    key(
        "discretization.hourglass-viscosity",
        Kind::Number("1", NotNegative),
        "finite elements: coefficient of hourglass viscosity (Flanagan, Belytschko)",
    )
    .only_with(ONE_POINT),
    key(
        "discretization.hourglass-scale",
        Kind::Words(&["gradients", "radioss"]),
        "finite elements: scale of the hourglass coefficients, gradients or sizes as in Radioss",
    )
    .only_with(HOURGLASS),
    key(
        "discretization.mass",
        Kind::Words(&["lumped", "hrz", "consistent"]),
        "finite elements: mass matrix; hrz: lumped in proportion to the diagonal of the consistent matrix (Hinton, Rock, Zienkiewicz)",
    )
    .only_with(ELEMENTS),
    key(
        "discretization.smoothing-domain",
        Kind::Words(&["voronoi", "boxes"]),
        "conforming nodal integration: cells over which gradients are averaged (SCNI, SNNI)",
    )
    .only_with(CONFORMING),
    key(
        "discretization.modification",
        Kind::Number("1", Fraction),
        "conforming nodal integration: coefficient of the modification (M-SCNI)",
    )
    .only_with(CONFORMING),
    key(
        "discretization.horizon",
        Kind::Number("1", IN_SPACINGS),
        "peridynamics: horizon in particle spacings of the regular lattice",
    )
    .only_with(PERIDYNAMICS),
    key(
        "discretization.influence",
        Kind::Words(&["constant", "inverse", "conical", "gaussian", "parabolic"]),
        "peridynamics: weights of the bonds",
    )
    .only_with(PERIDYNAMICS),
    key(
        "discretization.partial-volumes",
        Kind::Words(&["whole", "inside", "tapered"]),
        "peridynamics: treatment of particle volumes that the horizon cuts",
    )
    .only_with(PERIDYNAMICS),
    key(
        "discretization.bonds",
        Kind::Words(&[
            "bond-based",
            "ordinary",
            "correspondence",
            "bond-associated-form-i",
            "bond-associated-form-ii",
            "bond-averaged",
        ]),
        "peridynamics: the force between particles",
    )
    .only_with(PERIDYNAMICS),
    key(
        "discretization.calibration",
        Kind::Words(&["continuum", "discrete"]),
        "bond-based peridynamics: calibration of the micromodulus",
    )
    .only_with(BONDS),
    key(
        "discretization.control",
        Kind::Words(&["none", "penalty", "hourglass", "stiffness-tensor"]),
        "correspondence peridynamics: control of zero-energy modes",
    )
    .only_with(CORRESPONDENCE),
    key(
        "discretization.control-coefficient",
        Kind::Number("1", NotNegative),
        "correspondence peridynamics: coefficient of the control of zero-energy modes",
    )
    .only_with(CONTROL),
    key(
        "discretization.weighted-forces",
        Kind::Switch,
        "correspondence peridynamics: forces contain the influence function (PeriLab up to version 2.2.4: false)",
    )
    .only_with(CORRESPONDENCE),
    key(
        "discretization.points-per-side",
        Kind::Whole(1, 8),
        "material points along each side of a cell",
    )
    .only_with(POINTS),
    key(
        "discretization.layout",
        Kind::Words(&["uniform", "gauss"]),
        "material points: positions in their cell",
    )
    .only_with(SEVERAL_POINTS),
    key(
        "discretization.offset",
        Kind::Number("1", Any),
        "material points: shift of all points along each axis, in spacings",
    )
    .only_with(POINTS),
    key(
        "discretization.grid-functions",
        Kind::Words(&["linear", "gimp", "cpdi", "quadratic-spline", "cubic-spline"]),
        "material points: shape functions of the grid",
    )
    .only_with(POINTS),
    key(
        "discretization.grid-gradients",
        Kind::Words(&["functions", "moments"]),
        "material points: gradients in forces and velocity gradients, of the functions or first moments as in MLS-MPM",
    )
    .only_with(SMOOTH_FUNCTIONS),
    key(
        "discretization.dilatation",
        Kind::Words(&["point", "cell"]),
        "material points: dilatation for the stress, of the point itself or the mean of all points in the cell (F-bar), against locking",
    )
    .only_with(SEVERAL_POINTS),
    key(
        "discretization.unknowns",
        Kind::Words(&["total-lagrangian", "updated", "particles"]),
        "material points: points that carry the unknowns",
    )
    .only_with(POINTS),
    key(
        "discretization.transfer",
        Kind::Words(&["continuous", "flip", "pic", "apic", "xpic", "fmpm"]),
        "material points: transfer of velocities through the grid, in continuous time or once per time step",
    )
    .only_with(PARTICLE_UNKNOWNS),
    key(
        "discretization.flip-share",
        Kind::Number("1", Fraction),
        "material points: fraction of its velocity that a point keeps in a step, from 0 (PIC) to 1 (FLIP)",
    )
    .only_with(FLIP),
    key(
        "discretization.transfer-order",
        Kind::Whole(1, 100),
        "material points: order k of XPIC(k) or FMPM(k), terms of the inverse of the full mass matrix; 1 for PIC",
    )
    .only_with(OF_AN_ORDER),
    key(
        "discretization.time-step",
        Kind::Number("time", NotNegative),
        "material points: time step for growth rates and onset simulate; 0 for half of the largest stable step",
    )
    .only_with(TRANSFERRED),
    key(
        "discretization.grid-mass",
        Kind::Words(&["lumped", "consistent"]),
        "material points: mass matrix of the grid",
    )
    .only_with(NODES),
    key(
        "discretization.grid",
        Kind::Words(&["convected", "regular"]),
        "material points: positions of grid and points in the deformed state",
    )
    .only_with(CURRENT),
];
