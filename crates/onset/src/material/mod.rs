//! Materials: a strain energy determines stress and tangent.
//!
//! A law implements [`StrainEnergy`], one generic function. Stress and tangent are computed from it with second-order jets, so the stress of a law is
//! always consistent with its energy. The rest of the program uses only the object-safe [`Hyperelastic`]. A material does not depend on particles.

mod incompressible;
mod invariants;
mod law;
mod laws;
mod linearized;
mod membrane;
mod mullins;
mod plane_stress;
mod principal;
mod state_error;
mod tensors;
mod viscoelastic;

pub(crate) use incompressible::{bulk_modulus_above, huge_bulk_modulus, with_pressure};
pub(crate) use invariants::{InvariantEnergy, given_by_invariants, jet_of_invariants};
pub use law::{Admitted, Law, Parameter, SmallStrainStiffness, Symmetry, library};
pub(crate) use law::{Made, hooke};
pub use laws::{BlatzKo, ModifiedMooneyRivlin};
pub use linearized::Linearized;
pub use membrane::Membrane;
pub use mullins::{MULLINS, OgdenRoxburgh};
pub use plane_stress::PlaneStress;
pub use principal::{PrincipalEnergy, energy_of_stretches};
pub use state_error::{Place, StateError, Trouble};
pub use tensors::FourthOrder;
pub use viscoelastic::{Moduli, PronyTerm, Viscoelastic};

use crate::algebra::{Each, array_of};
use crate::cancel::checkpoint;
use crate::kinematics::DeformationGradient;
use crate::real::{Dual, Even, Interval, Jet, LANES, Lanes, Mirrored, Real, plain};
use nalgebra::Matrix3;
use thiserror::Error;

/// Error of a material or of its response.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum MaterialError {
    /// A parameter is outside its admissible range.
    #[error("material parameter {name} is {}; expected {expected}", plain(format!("{value:.14e}").parse().unwrap_or(*value)))]
    Parameter {
        /// Name of the parameter, as in a study file.
        name: &'static str,
        /// Value of the parameter.
        value: f64,
        /// Description of the admissible range.
        expected: String,
    },
    /// The law has no parameter of this name.
    #[error("{law} has no parameter `{name}`")]
    UnknownParameter {
        /// Name of the law.
        law: &'static str,
        /// Name that was given.
        name: String,
    },
    /// The state is outside the domain of the law.
    #[error("the law is not defined at this deformation: {what} is {}; {expected}", plain(*value))]
    OutsideDomain {
        /// Quantity that is out of bounds.
        what: &'static str,
        /// Value of the quantity.
        value: f64,
        /// Condition of the law on the quantity, including the limit.
        expected: String,
    },
    /// An energy given as a formula is undefined at the state, or has no stress there.
    #[error(transparent)]
    Formula(#[from] Box<StateError>),
    /// A material outside the library cannot be created or evaluated.
    #[error("{message}")]
    External {
        /// Description of the reason and the remedy.
        message: String,
    },
    /// The material in the reference state has no waves, so results cannot be scaled by a wave speed.
    #[error(
        "the material in the reference configuration carries no waves: its largest acoustic eigenvalue is {eigenvalue:e}; expected a positive number"
    )]
    NoWaves {
        /// Largest acoustic eigenvalue of the material.
        eigenvalue: f64,
    },
    /// The wave speed is so large or small that its powers over- or underflow.
    #[error(
        "the squared speed of sound is {stiffness:e} / {density:e}, the largest acoustic eigenvalue of the material in the reference configuration \
         divided by its density; expected a number from {:e} to {:e}: choose other units of stress or density",
        .range[0], .range[1]
    )]
    WaveSpeed {
        /// Largest acoustic eigenvalue of the material.
        stiffness: f64,
        /// Density of the material.
        density: f64,
        /// Admissible range of the squared wave speed.
        range: [f64; 2],
    },
    /// Some strain from the reference state causes no stress, so that Young's modulus is zero or undefined.
    #[error(
        "the law has no stiffness against some strain at F = 1 (a fluid has none against shear), so that Young's modulus, with which the stabilization is scaled, is not positive"
    )]
    NoYoungsModulus,
    /// The material in the reference state has no stiffness against shear.
    #[error(
        "the law has no stiffness against shear at F = 1 (a fluid and a bar in uniaxial stress have none), so that the shear modulus, with which forces between pairs of particles are scaled, is not positive"
    )]
    NoShearModulus,
    /// The law is not applicable to a sheet in plane stress, or to a bar in uniaxial stress.
    #[error("the law has no plane stress: {reason}")]
    NoPlaneStress {
        /// Reason why it is not applicable.
        reason: &'static str,
    },
    /// A Prony series is not admissible, or the law cannot have it.
    #[error("{message}")]
    Prony {
        /// Description of the error.
        message: String,
    },
    /// The branch of plane-stress states that begins in the reference configuration ends before this state.
    #[error(
        "there is no state of plane stress at this deformation: the branch of states with traction-free faces that begins in the reference configuration ends at \
         {reached:.3} of the path, where the through-thickness stretch is {stretch:.6}"
    )]
    PlaneStressEnds {
        /// Fraction of the path to the state that was reached.
        reached: f64,
        /// Stretch `F_33` at the end of the branch.
        stretch: f64,
    },
    /// Energy, stress or tangent over- or underflow at this state.
    #[error(
        "the energy or its derivatives are not finite at this deformation (det F = {jacobian:e})"
    )]
    NotFinite {
        /// Volume ratio of the state.
        jacobian: f64,
    },
}

impl From<StateError> for MaterialError {
    fn from(error: StateError) -> Self {
        Self::Formula(Box::new(error))
    }
}

impl MaterialError {
    /// Returns true if the law has no stress at this state but has one at others.
    pub fn leaves_undefined(&self) -> bool {
        matches!(
            self,
            Self::OutsideDomain { .. } | Self::Formula(_) | Self::PlaneStressEnds { .. }
        )
    }

    /// Returns true if energy or stress of a law given as a formula jumps at the state, with a response on both sides.
    pub(crate) fn is_of_a_jump(&self) -> bool {
        matches!(self, Self::Formula(error) if error.trouble != Trouble::Undefined)
    }

    /// Returns true if the error concerns the state, so that other states may have a response.
    fn is_of_the_state(&self) -> bool {
        self.leaves_undefined() || matches!(self, Self::NotFinite { .. })
    }

    /// Checks that a combination of parameters, named by its formula, is positive and finite.
    fn positive(name: &'static str, value: f64) -> Result<f64, Self> {
        if value > 0.0 && value.is_finite() {
            Ok(value)
        } else {
            Err(Self::Parameter {
                name,
                value,
                expected: "a positive number".to_owned(),
            })
        }
    }
}

/// Largest asymmetry of a tangent that is rounding, relative to the largest component.
const SYMMETRIC: f64 = 1e-12;

/// Hyperelastic law, given by its energy alone.
pub trait StrainEnergy {
    /// Strain energy `W(F)` per reference volume; units of stress.
    ///
    /// Its derivatives are the stress and the tangent, so it must use operations of [`Real`] only.
    fn energy<R: Real>(&self, f: &DeformationGradient<R>) -> R;

    /// Checks that the law is defined at a state and has a stress there. By default it is defined for all `J > 0`.
    ///
    /// # Errors
    /// [`MaterialError::OutsideDomain`] with the quantity that is out of bounds, [`MaterialError::Formula`] with the part that has no value or no
    /// derivative.
    fn admits(&self, _f: &DeformationGradient) -> Result<(), MaterialError> {
        Ok(())
    }

    /// Returns true if the stress is known to be continuous at all states of some intervals.
    ///
    /// Otherwise bounds of derivatives on the two sides do not enclose the derivatives in between.
    fn is_smooth(&self, _f: &DeformationGradient<Interval>) -> bool {
        true
    }

    /// Energy with its first and second derivatives with respect to `F_11`, `F_12`, `F_21`, `F_22`. A law may override it with a faster method.
    fn plane_jet<R: Real>(&self, f: &[[R; 3]; 3]) -> Jet<4, R>
    where
        Self: Sized,
    {
        self.energy(&plane_jets(f))
    }

    /// Second derivatives of [`StrainEnergy::plane_jet`] alone. At diagonal states the mirror symmetry of most laws is used.
    fn plane_hessian<R: Real>(&self, f: &[[R; 3]; 3], is_diagonal: bool) -> [[R; 4]; 4]
    where
        Self: Sized,
    {
        let mirrored = || {
            self.energy(&mirrored([f[0][0], f[1][1], f[2][2]]))
                .hessian()
        };
        let mirrored = is_diagonal.then(mirrored).flatten();
        mirrored.unwrap_or_else(|| self.plane_jet(f).hessian)
    }

    /// Energy and stress of several states, as for [`Hyperelastic::lane_stress`].
    ///
    /// They are computed from derivatives with respect to the components of `F` unless a law overrides this method with a faster method. Lanes may be
    /// wrong if the law requests a single value that differs between the lanes.
    fn lane_stress(&self, states: &DeformationGradient<Lanes>, dimension: usize) -> LaneStress
    where
        Self: Sized,
    {
        LaneStress::of_components(self, states, dimension)
    }
}

/// Tangent within the plane, with `A_iJkL` at `[2 i + J][2 k + L]`.
pub type PlaneTangent = [[f64; 4]; 4];

/// Returns true if `A_iJkL = A_kLiJ` within the plane to rounding, as for a stress that derives from an energy.
pub(crate) fn has_major_symmetry(tangent: &PlaneTangent) -> bool {
    let entries = tangent.as_flattened().iter();
    let scale = SYMMETRIC * entries.fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
    let mut pairs = (0..4).flat_map(|a| (0..a).map(move |b| (a, b)));
    pairs.all(|(a, b)| (tangent[a][b] - tangent[b][a]).abs() <= scale)
}

/// Components of stress and tangent within the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneResponse {
    /// Stress components `P_iJ`, stored at `[2 i + J]`.
    pub first_piola: [f64; 4],
    /// Tangent components `A_iJkL` within the plane.
    pub tangent: PlaneTangent,
}

/// Object-safe interface of a material, used by the rest of the program.
pub trait Hyperelastic: Send + Sync {
    /// Energy, stress and tangent at a state.
    ///
    /// # Errors
    /// [`MaterialError::NotFinite`] if one of them over- or underflows, [`MaterialError::OutsideDomain`] if the law is not defined.
    fn response(&self, f: &DeformationGradient) -> Result<Response, MaterialError>;

    /// Responses at many states. Each result is bitwise independent of the other states.
    fn responses(&self, states: &[DeformationGradient]) -> Vec<Result<Response, MaterialError>> {
        states.iter().map(|f| self.response(f)).collect()
    }

    /// Responses along a ray `U = diag exp(t L)` of logarithms `L` of the stretches, as a function of `t`; `None` if the law is not defined.
    ///
    /// A law that integrates the path to a state may continue from previously evaluated states. The results then differ from
    /// [`Hyperelastic::response`] by the error of integration.
    fn along<'a>(&'a self, logarithms: [f64; 3]) -> Box<dyn FnMut(f64) -> Option<Response> + 'a> {
        Box::new(move |t| {
            let stretches = logarithms.map(|logarithm| (t * logarithm).exp());
            let f = DeformationGradient::from_stretches(stretches).ok()?;
            self.response(&f).ok()
        })
    }

    /// Energy, stress and tangent at a state for volume-preserving increments.
    ///
    /// The tangent is the part `dP/dF` on rates `D F` with `tr D = 0`, and zero on all other rates. If the law is given by a [`StrainEnergy`], the
    /// result is not affected by the rounding of a very large stiffness against changes of volume.
    ///
    /// # Errors
    /// [`MaterialError`] under the conditions of [`Hyperelastic::response`].
    fn isochoric_response(&self, f: &DeformationGradient) -> Result<Response, MaterialError> {
        self.response(f)
    }

    /// Number of dimensions of the states that determine the response: 3, unless the law computes the remaining components of `F` itself.
    ///
    /// [`PlaneStress`] is such a law. [`Response::deformation`] contains the computed components.
    fn dimension(&self) -> usize {
        3
    }

    /// Energy and first Piola-Kirchhoff stress at a state, without the tangent. Units of stress.
    ///
    /// # Errors
    /// [`MaterialError`] under the conditions of [`Hyperelastic::response`].
    fn energy_and_stress(
        &self,
        f: &DeformationGradient,
    ) -> Result<(f64, Matrix3<f64>), MaterialError> {
        let response = self.response(f)?;
        Ok((response.energy, response.first_piola))
    }

    /// Energy and first Piola-Kirchhoff stress at several states. Each result is bitwise independent of the other states. Units of stress.
    ///
    /// Components of states with indices from `dimension` on are fixed: the corresponding stress is zero. The results are NaN if the law is
    /// undefined, and for states with inverted orientation.
    fn lane_stress(&self, states: &DeformationGradient<Lanes>, dimension: usize) -> LaneStress {
        LaneStress::of_each(states, dimension, |f| self.energy_and_stress(f).ok())
    }

    /// Response of the material in the reference state, whose wave speeds scale the results.
    ///
    /// If the law has a kink there and therefore no tangent, the response of one side is returned.
    ///
    /// # Errors
    /// [`MaterialError`] as for [`Hyperelastic::response`], kinks and jumps excepted.
    fn undeformed(&self) -> Result<Response, MaterialError> {
        self.response(&DeformationGradient::identity())
    }

    /// Part of the tangent within the plane, `A_iJkL` at `[2 i + J][2 k + L]` with indices 0 and 1. Units of stress.
    ///
    /// It suffices for waves in the plane and is several times cheaper than the full tangent.
    ///
    /// # Errors
    /// [`MaterialError::NotFinite`] if it over- or underflows.
    fn plane_tangent(&self, f: &DeformationGradient) -> Result<PlaneTangent, MaterialError> {
        Ok(self.response(f)?.tangent.in_plane())
    }

    /// Tangents within the plane ([`Hyperelastic::plane_tangent`]) of many states. Each result is bitwise independent of the other states.
    fn plane_tangents(
        &self,
        states: &[DeformationGradient],
    ) -> Vec<Result<PlaneTangent, MaterialError>> {
        states.iter().map(|f| self.plane_tangent(f)).collect()
    }

    /// Components of stress and tangent within the plane. Units of stress.
    ///
    /// # Errors
    /// [`MaterialError::NotFinite`] if they over- or underflow.
    fn plane_response(&self, f: &DeformationGradient) -> Result<PlaneResponse, MaterialError> {
        let response = self.response(f)?;
        Ok(PlaneResponse {
            first_piola: array_of(|a| response.first_piola[(a / 2, a % 2)]),
            tangent: response.tangent.in_plane(),
        })
    }

    /// Returns true for laws in rate form, such as metals that flow.
    ///
    /// Every state of such a law is reached along a path. The tangent holds for loading that continues from the state; it is not the derivative of
    /// the stress with respect to the state, and need not have major symmetry.
    fn is_path_dependent(&self) -> bool {
        false
    }

    /// Tangent `A_iJkL` of increments that unload, elastically, from a state that flows; `None` if loading and unloading have the same tangent. Units
    /// of stress.
    ///
    /// [`Hyperelastic::response`] has the tangent of loading that continues.
    ///
    /// # Errors
    /// [`MaterialError`] under the conditions of [`Hyperelastic::response`].
    fn unloading_tangent(
        &self,
        _f: &DeformationGradient,
    ) -> Result<Option<FourthOrder>, MaterialError> {
        Ok(None)
    }

    /// Part of the tangent `A_iJkL` from stress that a law in rate form integrates in time; `None` for other laws. Units of stress.
    ///
    /// It is `J F^-1_Jj F^-1_Ll g_ijkl` of the rates `sigma'_ij = g_ijkl L_kl` that are not functions of the positions. The remaining part follows
    /// the positions.
    ///
    /// # Errors
    /// [`MaterialError`] under the conditions of [`Hyperelastic::response`].
    fn integrated_tangent(
        &self,
        _f: &DeformationGradient,
    ) -> Result<Option<FourthOrder>, MaterialError> {
        Ok(None)
    }

    /// Bounds of energy, stress and tangent over all states with components in the given intervals.
    ///
    /// By default a law that is not given by a [`StrainEnergy`] has no bounds.
    fn enclosure(&self, _f: &DeformationGradient<Interval>) -> ResponseEnclosure {
        ResponseEnclosure::ENTIRE
    }
}

/// Energy `W` and first Piola-Kirchhoff stress `P_iJ` of several states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaneStress {
    /// Energy `W` per reference volume; NaN if no stress exists.
    pub energy: Lanes,
    /// Components `P_iJ` of the stress.
    pub first_piola: [[Lanes; 3]; 3],
}

impl LaneStress {
    /// Evaluates the states one by one.
    fn of_each(
        states: &DeformationGradient<Lanes>,
        dimension: usize,
        stress: impl Fn(&DeformationGradient) -> Option<(f64, Matrix3<f64>)>,
    ) -> Self {
        let mut all = Self {
            energy: Lanes([f64::NAN; LANES]),
            first_piola: [[Lanes([0.0; LANES]); 3]; 3],
        };
        for lane in 0..LANES {
            let own = DeformationGradient::new(components_of(states, lane))
                .ok()
                .and_then(|f| stress(&f));
            let Some((energy, first_piola)) = own else {
                continue;
            };
            all.energy.0[lane] = energy;
            for i in 0..dimension {
                for j in 0..dimension {
                    all.first_piola[i][j].0[lane] = first_piola[(i, j)];
                }
            }
        }
        all
    }

    /// Evaluates a law by its energy, with derivatives with respect to the components of `F` that are not fixed.
    pub(crate) fn of_components(
        law: &impl StrainEnergy,
        states: &DeformationGradient<Lanes>,
        dimension: usize,
    ) -> Self {
        match dimension {
            3 => Self::of_law::<3, 9>(law, states),
            _ => Self::of_law::<2, 4>(law, states),
        }
    }

    /// Evaluates a law by its energy, with derivatives with respect to the first `D` rows and columns of `F`, which are `N` numbers.
    fn of_law<const D: usize, const N: usize>(
        law: &impl StrainEnergy,
        states: &DeformationGradient<Lanes>,
    ) -> Self {
        let mut all = Self::of_energy::<D, N>(&law.energy(&plane_duals::<D, N>(states)));
        let volumes = states.determinant();
        for lane in 0..LANES {
            let state = DeformationGradient::from_components(components_of(states, lane));
            let is_defined = volumes.0[lane] > 0.0 && law.admits(&state).is_ok();
            if !is_defined {
                all.energy.0[lane] = f64::NAN;
            }
        }
        all
    }

    /// Converts an energy with its derivatives with respect to the first `D` rows and columns of `F`.
    fn of_energy<const D: usize, const N: usize>(energy: &Dual<N, Lanes>) -> Self {
        let mut all = Self {
            energy: energy.value,
            first_piola: [[Lanes([0.0; LANES]); 3]; 3],
        };
        for i in 0..D {
            for j in 0..D {
                all.first_piola[i][j] = energy.gradient[D * i + j];
            }
        }
        all
    }

    /// Evaluates a law whose stress is computed for one state at a time.
    pub(crate) fn one_by_one(
        law: &(impl StrainEnergy + Send + Sync),
        states: &DeformationGradient<Lanes>,
        dimension: usize,
    ) -> Self {
        Self::of_each(states, dimension, |f| law.energy_and_stress(f).ok())
    }

    /// Returns true if a state has a finite energy and stress.
    pub(crate) fn is_known(&self, lane: usize) -> bool {
        let mut stress = self.first_piola.as_flattened().iter();
        self.energy.0[lane].is_finite() && stress.all(|own| own.0[lane].is_finite())
    }

    /// Copies the result of one state from another result.
    fn take(&mut self, lane: usize, other: &Self) {
        self.energy.0[lane] = other.energy.0[lane];
        let own = self.first_piola.as_flattened_mut().iter_mut();
        for (own, other) in own.zip(other.first_piola.as_flattened()) {
            own.0[lane] = other.0[lane];
        }
    }
}

/// Bounds of energy, first Piola-Kirchhoff stress and tangent. Indices as in [`Response`], units of stress.
///
/// They enclose the exact response of the law with its constants as the program computes them.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseEnclosure {
    /// Energy `W` per reference volume.
    pub energy: Interval,
    /// Bounds of the stress components `P_iJ`.
    pub first_piola: [[Interval; 3]; 3],
    /// Tangent components `A_iJkL`, indexed `[i][J][k][L]`.
    pub tangent: [[[[Interval; 3]; 3]; 3]; 3],
}

impl ResponseEnclosure {
    /// Unbounded enclosure without information.
    pub const ENTIRE: Self = Self {
        energy: Interval::ENTIRE,
        first_piola: [[Interval::ENTIRE; 3]; 3],
        tangent: [[[[Interval::ENTIRE; 3]; 3]; 3]; 3],
    };

    /// Converts an energy with its derivatives.
    fn of_energy(energy: &Jet<9, Interval>) -> Self {
        let mut all = Self {
            energy: energy.value,
            ..Self::ENTIRE
        };
        for p in 0..9 {
            let (i, j) = (p / 3, p % 3);
            all.first_piola[i][j] = energy.gradient[p];
            for q in 0..9 {
                all.tangent[i][j][q / 3][q % 3] = energy.hessian[p][q];
            }
        }
        all
    }
}

/// Energy `W`, first Piola-Kirchhoff stress and tangent at one state.
///
/// Equations: `P_iJ = dW/dF_iJ`, `A_iJkL = dP_iJ/dF_kL` (the paper's nominal stress is the transpose of `P`; its effective tangent (22) is
/// [`Response::effective_tangent`]). Shapes 3 x 3 and 3 x 3 x 3 x 3, units of stress.
///
/// ```
/// use onset::kinematics::DeformationGradient;
/// use onset::material::{Hyperelastic, ModifiedMooneyRivlin};
/// let f = DeformationGradient::from_stretches([1.2, 0.9, 1.0])?;
/// let response = ModifiedMooneyRivlin::default().response(&f)?;
/// assert!((response.cauchy()[(0, 0)] - 1.4910116952).abs() < 1e-10);
/// assert!((response.effective_tangent()[(0, 0, 0, 0)] - 13.1431557983).abs() < 1e-10);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Response {
    /// Deformation gradient of the state.
    pub deformation: DeformationGradient,
    /// Energy `W` per reference volume.
    pub energy: f64,
    /// Stress components `P_iJ`, first index spatial.
    pub first_piola: Matrix3<f64>,
    /// Tangent components `A_iJkL`, all 81 of them.
    pub tangent: FourthOrder,
}

// The following functions do not depend on the type of the law and are compiled once.

/// Components of one of several states.
fn components_of(states: &DeformationGradient<Lanes>, lane: usize) -> [[f64; 3]; 3] {
    states.components().each(|row| row.each(|own| own.0[lane]))
}

/// Copies one state to all lanes.
fn alone(states: &DeformationGradient<Lanes>, lane: usize) -> DeformationGradient<Lanes> {
    let state = components_of(states, lane);
    DeformationGradient::from_components(state.each(|row| row.each(|own| Lanes([own; LANES]))))
}

/// Variables for the first `D` rows and columns of `F`, for several states.
fn plane_duals<const D: usize, const N: usize>(
    states: &DeformationGradient<Lanes>,
) -> DeformationGradient<Dual<N, Lanes>> {
    let mut duals = states.components().each(|row| row.map(Dual::fixed));
    for (i, row) in duals.iter_mut().enumerate().take(D) {
        for (j, own) in row.iter_mut().enumerate().take(D) {
            *own = Dual::variable(own.value, D * i + j);
        }
    }
    DeformationGradient::from_components(duals)
}

/// Variables for all components of `F`, with first derivatives.
fn duals(f: &DeformationGradient) -> DeformationGradient<Dual<9>> {
    let components = f.components();
    let variables = Dual::<9>::variables(array_of(|n| components[n / 3][n % 3]));
    let duals = array_of(|i| array_of(|j| variables[3 * i + j]));
    DeformationGradient::from_components(duals)
}

/// Variables for all components of `F`, up to second derivatives.
fn jets<R: Real>(f: &DeformationGradient<R>) -> DeformationGradient<Jet<9, R>> {
    let components = f.components();
    let variables = Jet::variables(array_of(|n| components[n / 3][n % 3]));
    let jets = array_of(|i| array_of(|j| variables[3 * i + j]));
    DeformationGradient::from_components(jets)
}

/// Matrix of cofactors `cof F = J F^-T`.
pub(crate) fn cofactor(f: &Matrix3<f64>) -> Matrix3<f64> {
    let [a, b, c] = [0, 1, 2].each(|i| f.row(i).transpose());
    Matrix3::from_rows(&[
        b.cross(&c).transpose(),
        c.cross(&a).transpose(),
        a.cross(&b).transpose(),
    ])
}

/// Orthonormal traceless rates `D_a`; the last of nine is zero.
fn isochoric_rates() -> [Matrix3<f64>; 9] {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let unit = |i: usize, j: usize| {
        let mut unit = Matrix3::zeros();
        unit[(i, j)] = half;
        unit
    };
    let shear = |i: usize, j: usize, sign: f64| unit(i, j) + unit(j, i) * sign;
    let axial = |a: f64, b: f64, c: f64| Matrix3::from_diagonal(&[a, b, c].into());
    [
        shear(1, 2, 1.0),
        shear(0, 2, 1.0),
        shear(0, 1, 1.0),
        shear(1, 2, -1.0),
        shear(0, 2, -1.0),
        shear(0, 1, -1.0),
        axial(half, -half, 0.0),
        axial(1.0, 1.0, -2.0) / 6.0_f64.sqrt(),
        Matrix3::zeros(),
    ]
}

/// Deformation gradient `exp(sum x_a D_a) F` as a function of the variables `x_a` at zero; the volume is constant.
fn isochoric_jets(f: &DeformationGradient) -> DeformationGradient<Jet<9>> {
    let (rates, f) = (isochoric_rates(), f.matrix());
    let first = rates.each(|rate| rate * f);
    let second = |a: usize, b: usize| (rates[a] * first[b] + rates[b] * first[a]) * 0.5;
    let second: [[Matrix3<f64>; 9]; 9] = array_of(|a| array_of(|b| second(a, b)));
    let jet = |i: usize, j: usize| Jet {
        value: f[(i, j)],
        gradient: array_of(|a| first[a][(i, j)]),
        hessian: array_of(|a| array_of(|b| second[a][b][(i, j)])),
    };
    DeformationGradient::from_components(array_of(|i| array_of(|j| jet(i, j))))
}

/// Response from the derivatives of [`isochoric_jets`] and the mean stress. With the Kirchhoff stress `tau` the derivatives are `tau : D_a` and
/// `(D_a F) : A : (D_b F) + tau : (D_a D_b + D_b D_a) / 2`.
fn isochoric_response(
    energy: &Jet<9>,
    stress: &Matrix3<f64>,
    f: &DeformationGradient,
) -> Result<Response, MaterialError> {
    let values = [energy.value].into_iter().chain(energy.gradient);
    let all: Vec<f64> = values.chain(energy.hessian.into_iter().flatten()).collect();
    require_finite(all.iter(), f)?;
    let (rates, matrix) = (isochoric_rates(), f.matrix());
    let mean = (stress * matrix.transpose()).trace() / 3.0;
    let parts = rates.iter().zip(energy.gradient);
    let deviator: Matrix3<f64> = parts.map(|(rate, slope)| rate * slope).sum();
    let tau = deviator + Matrix3::from_diagonal_element(mean);
    let jacobian = f.jacobian();
    let inverse = cofactor(&matrix) / jacobian;
    let dual = rates.each(|rate| rate * inverse);
    let mut tangent = [[0.0; 9]; 9];
    for (a, b) in (0..64).map(|n| (n / 8, n % 8)) {
        let products = rates[a] * rates[b] + rates[b] * rates[a];
        let form = energy.hessian[a][b] - 0.5 * tau.dot(&products);
        for (p, q) in (0..81).map(|n| (n / 9, n % 9)) {
            tangent[p][q] += form * dual[a][(p / 3, p % 3)] * dual[b][(q / 3, q % 3)];
        }
    }
    Ok(Response {
        deformation: *f,
        energy: energy.value,
        first_piola: tau * inverse,
        tangent: FourthOrder::from_fn(|i, j, k, l| tangent[3 * i + j][3 * k + l]),
    })
}

/// Variables for the in-plane components of `F`, four instead of nine; the others are constants.
fn plane_jets<R: Real>(components: &[[R; 3]; 3]) -> DeformationGradient<Jet<4, R>> {
    let variables = Jet::<4, R>::variables(array_of(|n| components[n / 2][n % 2]));
    let mut jets = components.each(|row| row.map(Jet::fixed));
    for (n, variable) in variables.into_iter().enumerate() {
        jets[n / 2][n % 2] = variable;
    }
    DeformationGradient::from_components(jets)
}

/// Variables for the in-plane components of a diagonal state, for functions with its mirror symmetry.
fn mirrored<R: Real>(diagonal: [R; 3]) -> DeformationGradient<Mirrored<R>> {
    let [f11, f12, f21, f22] = Mirrored::variables(diagonal[0], diagonal[1]);
    let [_, _, _, f33] = Mirrored::variables(diagonal[0], diagonal[2]);
    // Waves in the plane do not change F_33.
    let f33 = match f33 {
        Mirrored::Even(even) => Mirrored::Even(Even {
            gradient: [R::constant(0.0); 2],
            ..even
        }),
        other => other,
    };
    let zero = Mirrored::Zero;
    DeformationGradient::from_components([[f11, f12, zero], [f21, f22, zero], [zero, zero, f33]])
}

/// Checks that the numbers of a response neither over- nor underflow.
fn require_finite<'a>(
    mut values: impl Iterator<Item = &'a f64>,
    f: &DeformationGradient,
) -> Result<(), MaterialError> {
    match values.all(|value| value.is_finite()) {
        true => Ok(()),
        false => Err(MaterialError::NotFinite {
            jacobian: f.jacobian(),
        }),
    }
}

/// Energy and stress, with a check for over- and underflow.
fn finite_stress(
    energy: &Dual<9>,
    f: &DeformationGradient,
) -> Result<(f64, Matrix3<f64>), MaterialError> {
    require_finite([energy.value].iter().chain(&energy.gradient), f)?;
    let stress = Matrix3::from_fn(|i, j| energy.gradient[3 * i + j]);
    Ok((energy.value, stress))
}

/// Stress and tangent within the plane, with a check for over- and underflow.
fn finite_plane_response(
    energy: &Jet<4>,
    f: &DeformationGradient,
) -> Result<PlaneResponse, MaterialError> {
    let values = energy.gradient.iter().chain(energy.hessian.as_flattened());
    require_finite(values, f)?;
    Ok(PlaneResponse {
        first_piola: energy.gradient,
        tangent: energy.hessian,
    })
}

/// Energy, stress and tangent, with a check for over- and underflow.
fn finite_response(energy: &Jet<9>, f: &DeformationGradient) -> Result<Response, MaterialError> {
    Response {
        deformation: *f,
        energy: energy.value,
        first_piola: Matrix3::from_fn(|i, j| energy.gradient[3 * i + j]),
        tangent: FourthOrder::from_fn(|i, j, k, l| energy.hessian[3 * i + j][3 * k + l]),
    }
    .finite()
}

/// Tangent within the plane, with a check for over- and underflow.
fn finite(tangent: PlaneTangent, f: &DeformationGradient) -> Result<PlaneTangent, MaterialError> {
    require_finite(tangent.as_flattened().iter(), f)?;
    Ok(tangent)
}

/// Packs up to [`LANES`] states; unused lanes repeat one of the states.
fn side_by_side(states: &[DeformationGradient]) -> [[Lanes; 3]; 3] {
    let mut components = [[Lanes([0.0; LANES]); 3]; 3];
    for n in 0..LANES {
        let state = states.get(n).unwrap_or(&states[0]).components();
        for (own, entry) in components
            .as_flattened_mut()
            .iter_mut()
            .zip(state.as_flattened())
        {
            own.0[n] = *entry;
        }
    }
    components
}

/// Tangent of one of several states.
fn tangent_of(lanes: &[[Lanes; 4]; 4], lane: usize) -> PlaneTangent {
    // By reference: a tangent of all lanes is a kilobyte.
    let mut tangent = PlaneTangent::default();
    for (own, entry) in tangent
        .as_flattened_mut()
        .iter_mut()
        .zip(lanes.as_flattened())
    {
        *own = entry.0[lane];
    }
    tangent
}

impl<Law: StrainEnergy + Send + Sync> Hyperelastic for Law {
    fn enclosure(&self, f: &DeformationGradient<Interval>) -> ResponseEnclosure {
        checkpoint();
        if !self.is_smooth(f) {
            return ResponseEnclosure::ENTIRE;
        }
        ResponseEnclosure::of_energy(&self.energy(&jets(f)))
    }

    fn plane_tangent(&self, f: &DeformationGradient) -> Result<PlaneTangent, MaterialError> {
        checkpoint();
        self.admits(f)?;
        finite(self.plane_hessian(f.components(), f.is_diagonal()), f)
    }

    fn plane_response(&self, f: &DeformationGradient) -> Result<PlaneResponse, MaterialError> {
        checkpoint();
        self.admits(f)?;
        finite_plane_response(&StrainEnergy::plane_jet(self, f.components()), f)
    }

    fn plane_tangents(
        &self,
        states: &[DeformationGradient],
    ) -> Vec<Result<PlaneTangent, MaterialError>> {
        let mut tangents = Vec::with_capacity(states.len());
        let runs = states.chunk_by(|a, b| a.is_diagonal() == b.is_diagonal());
        for chunk in runs.flat_map(|run| run.chunks(LANES)) {
            checkpoint();
            let is_diagonal = chunk[0].is_diagonal();
            let lanes = self.plane_hessian(&side_by_side(chunk), is_diagonal);
            for (n, f) in chunk.iter().enumerate() {
                let admitted = self.admits(f);
                // A law may branch on a value that differs between the lanes (NaN there); the state is then evaluated alone.
                let known = || finite(tangent_of(&lanes, n), f).or_else(|_| self.plane_tangent(f));
                tangents.push(admitted.and_then(|()| known()));
            }
        }
        tangents
    }

    fn response(&self, f: &DeformationGradient) -> Result<Response, MaterialError> {
        checkpoint();
        self.admits(f)?;
        finite_response(&self.energy(&jets(f)), f)
    }

    fn isochoric_response(&self, f: &DeformationGradient) -> Result<Response, MaterialError> {
        let (_, stress) = self.energy_and_stress(f)?;
        isochoric_response(&self.energy(&isochoric_jets(f)), &stress, f)
    }

    fn energy_and_stress(
        &self,
        f: &DeformationGradient,
    ) -> Result<(f64, Matrix3<f64>), MaterialError> {
        checkpoint();
        self.admits(f)?;
        finite_stress(&self.energy(&duals(f)), f)
    }

    fn lane_stress(&self, states: &DeformationGradient<Lanes>, dimension: usize) -> LaneStress {
        let mut all = StrainEnergy::lane_stress(self, states, dimension);
        for lane in 0..LANES {
            // A law may branch on a value that differs between the lanes (NaN there); the state is then evaluated alone.
            if !all.is_known(lane) {
                let alone = alone(states, lane);
                all.take(lane, &StrainEnergy::lane_stress(self, &alone, dimension));
            }
        }
        all
    }

    fn undeformed(&self) -> Result<Response, MaterialError> {
        let f = DeformationGradient::identity();
        match self.admits(&f) {
            Err(MaterialError::Formula(error)) if error.trouble != Trouble::Undefined => {}
            other => other?,
        }
        finite_response(&self.energy(&jets(&f)), &f)
    }
}
