//! Stability criteria: each is a quantity with a sign and a witness, under its established name.
//!
//! "Stable" has many meanings. A wave, a dead load, a testing machine and a program that fits laws to tests impose different conditions, and a law
//! can satisfy one and violate another at the same state. A [`Criterion`] names the condition. Its [`Measure`] at a [`State`] is positive where the
//! condition holds, and includes the perturbation that minimizes it. A [`Loading`] leads to states, with traction-free faces solved for, and
//! [`follow`] finds where along it a criterion is violated. [`safe_box`] is the largest box of principal stretches in which a law is strongly
//! elliptic.
//!
//! With `P = dW/dF`, `A = dP/dF`, Kirchhoff stress `tau = P F^T`, the polar decomposition `F = R U`, and principal stretches `lambda_i`:
//!
//! | criterion | demands |
//! |---|---|
//! | [`StrongEllipticity`](Criterion::StrongEllipticity) | `A_iJkL g_i N_J g_k N_L > 0` for all `g`, `N` |
//! | [`PlaneEllipticity`](Criterion::PlaneEllipticity) | `A_iJkL g_i N_J g_k N_L > 0` for `g`, `N` in the plane of the first two axes |
//! | [`RankOneConvexity`](Criterion::RankOneConvexity) | `W(F + a (x) N) > W(F) + P : a (x) N` for finite `a` |
//! | [`BakerEricksen`](Criterion::BakerEricksen) | `(sigma_i - sigma_j)(lambda_i - lambda_j) > 0` |
//! | [`Hill`](Criterion::Hill) | `Fdot : A : Fdot > 0` for all `Fdot` (dead loads; rotations included) |
//! | [`HillRotationFree`](Criterion::HillRotationFree) | `Fdot : A : Fdot > 0` for `Fdot = R S`, `S` symmetric (rotations held) |
//! | [`Drucker`](Criterion::Drucker) | `tau° : D > 0` for all `D`, `tau°` the Jaumann rate of `tau` |
//! | [`DruckerAbaqus`](Criterion::DruckerAbaqus) | `dtau_i dln(lambda_i) > 0` with principal axes held; for incompressible response with `sum dln(lambda_i) = 0` |
//! | [`TrueStressMonotonicity`](Criterion::TrueStressMonotonicity) | `sigma° : D > 0` for all `D`, `sigma°` the Jaumann rate of Cauchy stress |
//! | [`OrderedForces`](Criterion::OrderedForces) | `(T_i - T_j)(lambda_i - lambda_j) > 0`, `T_i = dW/dlambda_i` |
//! | [`LoadMaximum`](Criterion::LoadMaximum) | the load rises along the loading itself |
//! | [`Surface`](Criterion::Surface) | no standing wave at a free face (incompressible response) |
//!
//! The criteria also apply to the incompressible response of an isotropic law ([`LoadingPath::incompressible`]): states with `J = 1`, the pressure
//! from a traction-free face, and in every criterion only volume-preserving increments.
//!
//! Implications: [`RankOneConvexity`](Criterion::RankOneConvexity) at a state implies (not strict) ellipticity there. Strong ellipticity of an
//! isotropic law implies the Baker-Ericksen inequalities. [`Hill`](Criterion::Hill) implies strong ellipticity,
//! [`HillRotationFree`](Criterion::HillRotationFree) and a rising load. [`Drucker`](Criterion::Drucker)'s inequality and strong ellipticity do not
//! imply each other.

mod box_of_stretches;
mod follow;
mod forms;
mod incompressible;
mod isotropy;
mod jumps;
mod kinks;
mod loading;
mod polyconvexity;
mod root;

pub use box_of_stretches::{BoxEnd, Critical, SafeBox, safe_box, widest_safe_box};
pub use follow::{Change, Event, Track, follow, follow_jumps};
pub use isotropy::{has_energy, is_isotropic};
pub use jumps::{Jump, JumpSearch};
pub use kinks::{Discontinuity, Kink, kinks};
pub use loading::{
    Lateral, Loading, LoadingError, LoadingPath, LoadingSection, Mode, PathEnd, PathState, Range,
    RangeError,
};
pub use polyconvexity::{Knowledge, Polyconvexity, polyconvexity};

use crate::algebra::{Each, array_of, directions};
use crate::continuum::{ACOUSTIC_ROUNDING as ZERO, Stiffness};
use crate::kinematics::DeformationGradient;
use crate::material::{Hyperelastic, MaterialError, Response, cofactor};
use forms::QuadraticForm;
use incompressible::{orthogonal_to, stretches_along};
use isotropy::PrincipalTangent;
use kinks::bulk_tangent;
use nalgebra::{Matrix3, Vector3};

/// Stability criterion of a homogeneous state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Criterion {
    /// Strong ellipticity: all wave speeds are real, `A_iJkL g_i N_J g_k N_L > 0` for all directions `N` and polarizations `g`.
    ///
    /// Source: Hadamard, Leçons sur la propagation des ondes (1903). Truesdell and Noll, The non-linear field theories of mechanics (1965), section
    /// 44. When it is lost, a wave speed vanishes, and shear bands and other bands of arbitrary thickness can form.
    ///
    /// For isotropic laws the decision is exact. In principal axes, with `W_ij` the second derivatives of the energy with respect to the stretches,
    /// the form is nonnegative if and only if the shear stiffnesses `A_ijij` are nonnegative and the matrices with `W_ii` on the diagonal and `e_i
    /// e_j (W_ij + A_ijji) + A_ijij` off the diagonal are copositive for all signs `e` (Simpson and Spector, Arch. Ration. Mech. Anal. 84 (1983) 55).
    /// The measure is the smallest value attained in these conditions, a value of the form at unit vectors. For other laws it is the smallest
    /// eigenvalue of all acoustic tensors. Units of stress.
    StrongEllipticity,
    /// Strong ellipticity restricted to waves in the plane of the first two axes, as in a simulation in plane strain.
    ///
    /// The measure is the exact minimum of the smallest eigenvalue of the acoustic tensors in the plane. Units of stress. Source: as for
    /// [`Criterion::StrongEllipticity`].
    PlaneEllipticity,
    /// Rank-one convexity: no laminate with finite jumps has less energy, `W(F + a (x) N) - W(F) - P : (a (x) N) > 0` for all `a`, `N`.
    ///
    /// Source: Ball, Arch. Ration. Mech. Anal. 63 (1977) 337; Morrey (1952). The measure is the smallest
    /// `2 (W(F + a (x) N) - W(F) - P : a (x) N) / |a|^2` found by a [`JumpSearch`]. Units of stress. A negative value is a proof to rounding (or in
    /// interval arithmetic: [`JumpSearch::proves`]). A positive value means that the search found no such jump, so a limit along a loading is an
    /// upper bound: other jumps may lower the energy nearer to the reference configuration. The limit is never later than the loss of ellipticity,
    /// and it is earlier if the third derivative of the energy along the critical wave does not vanish.
    RankOneConvexity,
    /// Baker-Ericksen inequalities: the larger principal stress acts along the larger principal stretch,
    /// `(sigma_i - sigma_j)(lambda_i - lambda_j) > 0`.
    ///
    /// Source: Baker and Ericksen, J. Wash. Acad. Sci. 44 (1954) 33; for isotropic laws. The measure is the smallest
    /// `(tau_i - tau_j) / (lambda_i^2 - lambda_j^2)`, which is the component `A_ijij` of the tangent in principal axes and therefore has its limit at
    /// equibiaxial stretches. Units of stress.
    BakerEricksen,
    /// Hill's criterion for dead loads: `Fdot : A : Fdot > 0` for all `Fdot`.
    ///
    /// Source: Hill, J. Mech. Phys. Solids 5 (1957) 229 and 6 (1958) 236: where it holds everywhere, the rates of a body under dead loads are unique.
    /// All nine rates are admitted, including rotations. For `Fdot = w x F` the form depends on the stress alone, `tr(tau) |w|^2 - w . tau w`. The
    /// condition is therefore neutral without stress and in uniaxial tension (rotation about the load), and never holds where two principal stresses
    /// have a negative sum, for any law. A value that is zero to rounding (3e-14 of the tangent) counts as held, which can shift a limit by 1e-9. The
    /// measure is the smallest eigenvalue of `A` as a 9 x 9 matrix. Units of stress.
    Hill,
    /// Hill's criterion for rotation-free rates under dead loads: `Fdot : A : Fdot > 0` for all `Fdot = R S`, `S` symmetric.
    ///
    /// The energy is convex in the right stretch tensor `U` to second order. Source: Coleman and Noll, Arch. Ration. Mech. Anal. 4 (1959) 97; in
    /// rates Hill, J. Mech. Phys. Solids 16 (1968) 229, with Biot stress and `U` as conjugate measures. The measure is the smallest eigenvalue on
    /// these six rates. Units of stress.
    HillRotationFree,
    /// Drucker stability: positive second-order work `tau° : D > 0` for all rates of deformation `D`, with the Jaumann rate of Kirchhoff stress.
    ///
    /// The work is `(D F) : A : (D F) + tau : D^2`. Source: Hill, J. Mech. Phys. Solids 16 (1968) 229; Leblond, Eur. J. Mech. A 11 (1992) 447, who
    /// shows the equivalence with convexity in the logarithmic strain for isotropic laws. Programs that fit laws call it Drucker stability, after
    /// Drucker, J. Appl. Mech. 26 (1959) 101. The measure is the smallest eigenvalue on symmetric `D`. Units of stress.
    Drucker,
    /// Drucker stability as Abaqus and other fitting codes check it: with principal axes held, `dtau_i dln(lambda_i) > 0`.
    ///
    /// The matrix `dtau_i / dln(lambda_j)` is positive definite. For incompressible response (`D = 0`) increments satisfy `sum dln(lambda_i) = 0`.
    /// The 2 x 2 matrix after elimination of the third strain must then be positive definite. No pressure does work on such increments, so neither
    /// the pressure nor the volumetric part of the law matters. Source: Abaqus Analysis Guide, Hyperelastic behavior of rubberlike materials,
    /// "Material stability" (checked there for stretches 0.1 to 10). The measure is the smallest eigenvalue for logarithmic strain of unit length.
    /// Units of stress.
    DruckerAbaqus,
    /// True stress grows with true strain (TSTS-M++): `sigma° : D > 0` for all rates of deformation `D`, with the Jaumann rate of Cauchy stress.
    ///
    /// The condition is `(tau° : D - (tau : D) tr D) / J > 0`. For isotropic laws the derivative of the Cauchy stress with respect to the logarithmic
    /// strain is positive definite. Source: Jog and Patil, Arch. Appl. Mech. 83 (2013) 661; Wollner, Holzapfel and Neff, arXiv 2509.08597 (2025), who
    /// show that neither this condition nor polyconvexity implies the other. At constant volume it equals Drucker's inequality. The measure is the
    /// smallest eigenvalue on symmetric `D`. Units of stress.
    TrueStressMonotonicity,
    /// Ordered forces: the larger principal force acts along the larger principal stretch, `(T_i - T_j)(lambda_i - lambda_j) > 0`,
    /// `T_i = dW/dlambda_i` (Biot stress).
    ///
    /// Sources: Coleman and Noll, Arch. Ration. Mech. Anal. 4 (1959) 97, and Truesdell and Noll, The non-linear field theories of mechanics (1965),
    /// section 51 (O-F inequalities); for isotropic laws. The measure is the smallest `(T_i - T_j) / (lambda_i - lambda_j)`, which is
    /// `A_ijij + A_ijji` of the tangent in principal axes and therefore has its limit at equibiaxial stretches. Units of stress.
    OrderedForces,
    /// Load maximum: the load rises along the loading, `Pdot : Fdot > 0` along the path itself with its traction-free faces.
    ///
    /// Under a prescribed load the specimen becomes unstable at the maximum (Considère, Ann. Ponts Chaussées 9 (1885) 574, for bars). Under a
    /// prescribed elongation a homogeneous specimen is not affected. For a single loaded direction `Pdot : Fdot` equals `dP/dlambda` times a positive
    /// number. The measure is `Pdot : Fdot` with the rate by the logarithm of the stretch. Units of stress.
    LoadMaximum,
    /// Biot's surface instability: no standing wave at a free face, for incompressible isotropic response.
    ///
    /// For waves along the principal axis `i` at a traction-free face normal to the axis `j`, with the instantaneous moduli `A0` and
    /// `eta = lambda_i / lambda_j`, the condition is `2 eta (beta + gamma) + alpha - gamma > 0`, `alpha = A0_ijij`, `gamma = A0_jiji`,
    /// `2 beta = A0_iiii + A0_jjjj - 2 A0_iijj - 2 A0_ijji`. Source: Biot, Appl. Sci. Res. A 12 (1963) 168; Dowaikh and Ogden, IMA J. Appl. Math. 44
    /// (1990) 261. A neo-Hookean solid wrinkles at `eta^3 + eta^2 + 3 eta = 1`. The measure is the smallest left side over the free faces and the
    /// principal axes in them. Waves oblique to the axes are not considered. Units of stress.
    Surface,
}

/// Value of a criterion at a state; positive where the criterion holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measure {
    /// Smallest value found; units of stress.
    pub value: f64,
    /// Values above `-neutral` count as satisfied. Nonzero only for criteria that are neutral on whole sets of states.
    pub neutral: f64,
    /// Largest value that is zero to rounding and does not count as positive, as for
    /// [`AcousticMinimum::rounding`](crate::continuum::AcousticMinimum).
    pub zero: f64,
    /// Rounding may determine the sign of a value along a loading if its magnitude is smaller.
    pub rounding: f64,
    /// Perturbation with the smallest value.
    pub witness: Witness,
}

impl Measure {
    /// Number with the sign of the criterion: negative if it does not hold.
    pub fn signed(&self) -> f64 {
        self.value + self.neutral
    }

    /// Returns true if the criterion holds beyond rounding.
    pub fn holds(&self) -> bool {
        if self.neutral > 0.0 {
            self.signed() > 0.0
        } else {
            self.value > self.zero
        }
    }
}

/// Perturbation that minimizes a measure.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize),
    serde(tag = "kind", rename_all = "kebab-case")
)]
pub enum Witness {
    /// Plane wave with unit direction `N` (reference) and unit polarization `g`.
    Wave {
        /// Unit direction `N` in the reference configuration.
        direction: [f64; 3],
        /// Unit polarization `g` of the wave.
        polarization: [f64; 3],
    },
    /// Rate of the deformation gradient of unit length, `Fdot_iJ`.
    DeformationRate {
        /// Components `Fdot_iJ` of the rate.
        rate: [[f64; 3]; 3],
    },
    /// Rate of deformation of unit length, `D_ij`.
    StrainRate {
        /// Components `D_ij` of the rate.
        rate: [[f64; 3]; 3],
    },
    /// Standing wave along a free face.
    SurfaceWave {
        /// Unit normal of the face (reference).
        normal: [f64; 3],
        /// Unit direction of the wave in the face (reference).
        direction: [f64; 3],
    },
    /// Finite jump `a (x) N` of the deformation gradient.
    Jump {
        /// Amplitude `a` of the jump.
        amplitude: [f64; 3],
        /// Unit normal `N` in the reference configuration.
        direction: [f64; 3],
        /// Whether the jump reaches the largest stretch of the search. The limit then depends on this stretch and is approximate.
        at_edge: bool,
        /// Whether the jump leads to nearly zero volume, where the law has a finite energy.
        collapses: bool,
        /// Whether interval arithmetic proves that the jump lowers the energy. If false, the jump lowers it to rounding, or the law provides no
        /// enclosures.
        verified: bool,
    },
}

impl Criterion {
    /// All criteria, in the order of tables.
    pub const ALL: [Self; 12] = [
        Self::StrongEllipticity,
        Self::PlaneEllipticity,
        Self::RankOneConvexity,
        Self::BakerEricksen,
        Self::Hill,
        Self::HillRotationFree,
        Self::Drucker,
        Self::DruckerAbaqus,
        Self::TrueStressMonotonicity,
        Self::OrderedForces,
        Self::LoadMaximum,
        Self::Surface,
    ];

    /// Name of the criterion in files and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::StrongEllipticity => "strong-ellipticity",
            Self::PlaneEllipticity => "plane-ellipticity",
            Self::RankOneConvexity => "rank-one-convexity",
            Self::BakerEricksen => "baker-ericksen",
            Self::Hill => "hill",
            Self::HillRotationFree => "hill-rotation-free",
            Self::Drucker => "drucker",
            Self::DruckerAbaqus => "drucker-abaqus",
            Self::TrueStressMonotonicity => "true-stress-monotonicity",
            Self::OrderedForces => "ordered-forces",
            Self::LoadMaximum => "load-maximum",
            Self::Surface => "surface",
        }
    }

    /// Name of the criterion in sentences.
    pub fn title(self) -> &'static str {
        match self {
            Self::StrongEllipticity => "strong ellipticity",
            Self::PlaneEllipticity => "ellipticity in the plane",
            Self::RankOneConvexity => "rank-one convexity",
            Self::BakerEricksen => "the Baker-Ericksen inequality",
            Self::Hill => "Hill's criterion for dead loads",
            Self::HillRotationFree => "Hill's criterion for rotation-free increments",
            Self::Drucker => "Drucker's criterion",
            Self::DruckerAbaqus => "Drucker stability as Abaqus checks it",
            Self::TrueStressMonotonicity => "monotonicity of true stress in true strain",
            Self::OrderedForces => "the order of forces",
            Self::LoadMaximum => "a rising load",
            Self::Surface => "stability of a free surface",
        }
    }

    /// Condition as a formula.
    pub fn definition(self) -> &'static str {
        match self {
            Self::StrongEllipticity => "A_iJkL g_i N_J g_k N_L > 0 for all g, N",
            Self::PlaneEllipticity => "A_iJkL g_i N_J g_k N_L > 0 for all g, N in the plane 1-2",
            Self::RankOneConvexity => "W(F + a (x) N) > W(F) + P : a (x) N for all a, N",
            Self::BakerEricksen => "(sigma_i - sigma_j)(lambda_i - lambda_j) > 0",
            Self::Hill => "Fdot : A : Fdot > 0 for all Fdot",
            Self::HillRotationFree => "Fdot : A : Fdot > 0 for all Fdot = R S, S symmetric",
            Self::Drucker => "tau° : D > 0 for all D, tau° the Jaumann rate of Kirchhoff stress",
            Self::DruckerAbaqus => {
                "dtau_i dln(lambda_i) > 0 with principal axes held; incompressible (D = 0): for sum dln(lambda_i) = 0"
            }
            Self::TrueStressMonotonicity => {
                "sigma° : D > 0 for all D, sigma° the Jaumann rate of Cauchy stress"
            }
            Self::OrderedForces => "(T_i - T_j)(lambda_i - lambda_j) > 0, T_i = dW/dlambda_i",
            Self::LoadMaximum => "Pdot : Fdot > 0 along the loading",
            Self::Surface => {
                "2 eta (beta + gamma) + alpha - gamma > 0 at free faces, eta = lambda_i/lambda_j (incompressible)"
            }
        }
    }

    /// Reference of the criterion.
    pub fn source(self) -> &'static str {
        match self {
            Self::StrongEllipticity | Self::PlaneEllipticity => {
                "Hadamard 1903; Simpson and Spector, Arch. Ration. Mech. Anal. 84 (1983) 55"
            }
            Self::RankOneConvexity => "Ball, Arch. Ration. Mech. Anal. 63 (1977) 337",
            Self::BakerEricksen => "Baker and Ericksen, J. Wash. Acad. Sci. 44 (1954) 33",
            Self::Hill => "Hill, J. Mech. Phys. Solids 6 (1958) 236",
            Self::HillRotationFree => {
                "Coleman and Noll, Arch. Ration. Mech. Anal. 4 (1959) 97; Hill, J. Mech. Phys. Solids 16 (1968) 229"
            }
            Self::Drucker => {
                "Drucker, J. Appl. Mech. 26 (1959) 101; Leblond, Eur. J. Mech. A 11 (1992) 447"
            }
            Self::DruckerAbaqus => "Abaqus Analysis Guide, hyperelasticity, material stability",
            Self::Surface => {
                "Biot, Appl. Sci. Res. A 12 (1963) 168; Dowaikh and Ogden, IMA J. Appl. Math. 44 (1990) 261"
            }
            Self::TrueStressMonotonicity => {
                "Jog and Patil, Arch. Appl. Mech. 83 (2013) 661; Wollner, Holzapfel and Neff, arXiv 2509.08597"
            }
            Self::OrderedForces => {
                "Coleman and Noll, Arch. Ration. Mech. Anal. 4 (1959) 97; Truesdell and Noll 1965, section 51"
            }
            Self::LoadMaximum => "Considère, Ann. Ponts Chaussées 9 (1885) 574",
        }
    }

    /// Returns the criterion with the given name, or `None`.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|criterion| criterion.name() == name)
    }

    /// Returns the measure at a state; `None` if the criterion is not defined there.
    ///
    /// Baker-Ericksen and ordered forces require an isotropic law, the load maximum requires a state with a loading, and the surface criterion
    /// requires incompressible response. Rank-one convexity is always `None`, since its search ([`JumpSearch`]) requires the law.
    ///
    /// ```
    /// use onset::kinematics::DeformationGradient;
    /// use onset::material::BlatzKo;
    /// use onset::criteria::{Criterion, State};
    /// // Uniaxial strain 4 is beyond 2 + sqrt 3: not elliptic, but Drucker-stable.
    /// let f = DeformationGradient::from_stretches([4.0, 1.0, 1.0])?;
    /// let state = State::new(&BlatzKo::default(), &f)?;
    /// assert!(!Criterion::StrongEllipticity.measure(&state).is_some_and(|measure| measure.holds()));
    /// assert!(Criterion::Drucker.measure(&state).is_some_and(|measure| measure.holds()));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn measure(self, state: &State) -> Option<Measure> {
        let state = state.deciding_shape(self).unwrap_or(state);
        match self {
            Self::StrongEllipticity => Some(state.strong_ellipticity(f64::INFINITY)),
            Self::PlaneEllipticity => Some(state.plane_ellipticity()),
            Self::RankOneConvexity => None,
            Self::BakerEricksen => state.isotropic.as_ref().map(|tangent| {
                let (value, wave) = tangent.softest_shear();
                state.of(value, wave)
            }),
            Self::Hill => Some(state.hill()),
            Self::HillRotationFree => Some(state.hill_rotation_free()),
            Self::Drucker => Some(state.drucker()),
            Self::DruckerAbaqus => Some(state.drucker_abaqus()),
            Self::TrueStressMonotonicity => Some(state.true_stress_monotonicity()),
            Self::OrderedForces => state.isotropic.as_ref().map(|tangent| {
                let (value, wave) = tangent.softest_force();
                state.of(value, wave)
            }),
            Self::Surface => state.surface(),
            Self::LoadMaximum => state.rate.map(|rate| state.load_maximum(&rate)),
        }
    }

    /// Returns the perturbation across a concave kink of the energy that violates a criterion on increments; `None` for conditions on the stress
    /// alone, and if no admitted increment leads across the kink. `jump` is the jump of `P` along a loading through the state.
    fn across(self, state: &State, jump: &Matrix3<f64>) -> Option<Witness> {
        match self {
            Self::StrongEllipticity | Self::PlaneEllipticity => {
                let (_, n, a) = state.best_jump_across(jump, self == Self::PlaneEllipticity)?;
                Some(wave(&n, &a.normalize()))
            }
            Self::Hill => {
                let rates = state.admitted(&forms::all_rates());
                state.deformation_across(&rates, jump)
            }
            Self::HillRotationFree => {
                let rates = state.admitted(&state.rotation_free_rates());
                state.deformation_across(&rates, jump)
            }
            Self::Drucker | Self::TrueStressMonotonicity => {
                state.strain_across(&forms::symmetric_rates(), jump)
            }
            Self::DruckerAbaqus => state.strain_across(&state.axial_rates(), jump),
            Self::LoadMaximum => state.rate.map(|rate| deformation(&(rate / rate.norm()))),
            Self::RankOneConvexity | Self::BakerEricksen | Self::OrderedForces | Self::Surface => {
                None
            }
        }
    }
}

/// Smallest component of a jump of the stress along admitted increments that is considered, relative to the jump.
const ACROSS: f64 = 1e-6;
/// Largest number of ascent steps to the best jump across a drop of the stress.
const UPHILL: usize = 60;

/// Rounding error of a form that is zero, relative to the largest component of the tangent.
const NEUTRAL: f64 = 3e-14;
/// Rounding error relative to the largest component of the tangent, for equal stretches. Between axes of different stretch it grows with their ratio,
/// because the small stiffness is computed from numbers of the size of the large stiffness.
const FORM_ROUNDING: f64 = 1e-13;

/// Largest ratio of the principal stretches that leaves the sign of a measure along a loading reliable: beyond it the tangent in principal axes has
/// lost too many digits.
const LARGEST_RATIO: f64 = 1e4;

fn ratio_of_stretches(response: &Response) -> f64 {
    let [largest, _, smallest] = response.deformation.principal_stretches();
    largest / smallest
}

/// State at which criteria are evaluated: the response of a law, its principal axes, and the loading that led to it.
#[derive(Clone, Debug)]
pub struct State {
    response: Response,
    form: QuadraticForm,
    /// Right and left principal axes in columns, `F = sum lambda_i n_i (x) N_i`.
    right: Matrix3<f64>,
    left: Matrix3<f64>,
    isotropic: Option<PrincipalTangent>,
    rate: Option<Matrix3<f64>>,
    /// Whether increments stay in the plane of the first two axes.
    in_plane: bool,
    /// Coordinate axes whose faces are traction-free, if the response is incompressible.
    free_faces: Option<&'static [usize]>,
    /// State of the same shape without change of volume, for a law whose pressure would hide the stiffness of the shape.
    shape: Option<Box<Self>>,
}

impl State {
    /// Computes the state of a law without a loading. Isotropy is tested with [`is_isotropic`].
    ///
    /// # Errors
    /// [`MaterialError`] if the response is not finite.
    pub fn new(
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
    ) -> Result<Self, MaterialError> {
        Ok(Self::of_response(
            material.response(f)?,
            is_isotropic(material),
        ))
    }

    /// Creates a state from a known response.
    pub fn of_response(response: Response, isotropic: bool) -> Self {
        let (left, right) = principal_axes(&response.deformation);
        Self {
            form: QuadraticForm::of(&response.tangent),
            isotropic: isotropic.then(|| PrincipalTangent::of(&response.tangent, &left, &right)),
            response,
            left,
            right,
            rate: None,
            in_plane: false,
            free_faces: None,
            shape: None,
        }
    }

    /// Restricts the state to two dimensions: increments and waves stay in the plane.
    pub fn in_plane(mut self) -> Self {
        self.in_plane = true;
        self
    }

    /// Selects from orthonormal rates, along and across the plane, those within the dimensions of the law.
    fn within(&self, rates: &[Matrix3<f64>]) -> Vec<Matrix3<f64>> {
        let is_within = |rate: &&Matrix3<f64>| {
            !self.in_plane || rate.row(2).amax().max(rate.column(2).amax()) < 1e-9
        };
        rates.iter().filter(is_within).copied().collect()
    }

    /// Declares the response incompressible, with the given free faces.
    fn incompressible(mut self, free_faces: &'static [usize]) -> Self {
        self.free_faces = Some(free_faces);
        self
    }

    /// Adds the [response of the shape](incompressible::of_shape).
    fn with_shape(mut self, response: Response) -> Self {
        let shape = Self::of_response(response, true).incompressible(&[]);
        self.shape = Some(Box::new(shape));
        self
    }

    /// State of the shape, if it decides a criterion: increments that change the volume are stiffer by orders of magnitude.
    fn deciding_shape(&self, criterion: Criterion) -> Option<&Self> {
        let shape = self.shape.as_deref()?;
        let dilation = || [Matrix3::identity() / 3.0_f64.sqrt()];
        let is_stiff = match criterion {
            Criterion::BakerEricksen => true,
            Criterion::StrongEllipticity | Criterion::PlaneEllipticity => {
                bulk_tangent(&self.response) > 0.0
            }
            Criterion::Drucker | Criterion::DruckerAbaqus => self.jaumann(&dilation()).value > 0.0,
            Criterion::TrueStressMonotonicity => self.true_stress_along(&dilation()).value > 0.0,
            _ => false,
        };
        is_stiff.then_some(shape)
    }

    /// Orthonormal rates that the response admits: all of them, or the volume-preserving subspace.
    fn admitted(&self, rates: &[Matrix3<f64>]) -> Vec<Matrix3<f64>> {
        match self.free_faces {
            None => self.within(rates),
            Some(_) => orthogonal_to(rates, &cofactor(&self.response.deformation.matrix())),
        }
    }

    /// Stretches along the principal axes.
    fn stretches(&self) -> Vector3<f64> {
        stretches_along(&self.response.deformation, &self.left, &self.right)
    }

    /// Adds the rate `dF/ds` of the loading that led to the state.
    pub fn with_rate(mut self, rate: Matrix3<f64>) -> Self {
        self.rate = Some(rate);
        self
    }

    /// Energy, stress and tangent of the state.
    pub fn response(&self) -> &Response {
        &self.response
    }

    fn of(&self, value: f64, witness: Witness) -> Measure {
        Measure {
            value,
            neutral: 0.0,
            zero: ZERO * self.form.magnitude(),
            rounding: match ratio_of_stretches(&self.response) {
                ratio if ratio > LARGEST_RATIO => f64::INFINITY,
                ratio => FORM_ROUNDING * self.form.magnitude() * ratio,
            },
            witness,
        }
    }

    /// Smallest value of `g . Q(N) g` if it is below a level, otherwise some value above the level.
    fn strong_ellipticity(&self, below: f64) -> Measure {
        if self.in_plane {
            return self.plane_ellipticity();
        }
        // The closed form assumes a symmetric tangent.
        let isotropic = self.isotropic.as_ref();
        if let Some(tangent) = isotropic.filter(|tangent| tangent.has_major_symmetry()) {
            let (value, wave) = match self.free_faces {
                None => tangent.softest_wave(),
                Some(_) => tangent.softest_isochoric_wave(&self.stretches()),
            };
            return self.of(value, wave);
        }
        let stiffness = Stiffness::<3>::of(&self.response);
        let minimum = stiffness.symmetric_part().minimum_below(below);
        let witness = wave(&minimum.direction, &minimum.polarization);
        self.of(minimum.eigenvalue.re, witness)
    }

    fn plane_ellipticity(&self) -> Measure {
        if let (Some(tangent), Some(_)) = (&self.isotropic, self.free_faces) {
            let (value, wave) = tangent.softest_isochoric_wave_in_plane(&self.stretches());
            return self.of(value, wave);
        }
        let stiffness = Stiffness::<2>::of(&self.response);
        let minimum = stiffness.symmetric_part().minimum();
        let spatial = |v: nalgebra::Vector2<f64>| Vector3::new(v[0], v[1], 0.0);
        let witness = wave(&spatial(minimum.direction), &spatial(minimum.polarization));
        Measure {
            zero: minimum.rounding,
            ..self.of(minimum.eigenvalue.re, witness)
        }
    }

    fn hill(&self) -> Measure {
        let (value, rate) = self.form.smallest(&self.admitted(&forms::all_rates()));
        Measure {
            value,
            neutral: NEUTRAL * self.form.magnitude(),
            ..self.of(value, deformation(&rate))
        }
    }

    fn hill_rotation_free(&self) -> Measure {
        let rates = self.admitted(&self.rotation_free_rates());
        let (value, rate) = self.form.smallest(&rates);
        self.of(value, deformation(&rate))
    }

    /// Orthonormal rates `R S` of the deformation gradient with `S` symmetric.
    fn rotation_free_rates(&self) -> [Matrix3<f64>; 6] {
        let rotation = self.left * self.right.transpose();
        forms::symmetric_rates().each(|s| rotation * s)
    }

    fn drucker(&self) -> Measure {
        self.jaumann(&self.strains(&forms::symmetric_rates()))
    }

    fn drucker_abaqus(&self) -> Measure {
        self.jaumann(&self.strains(&self.axial_rates()))
    }

    /// Orthonormal rates of deformation that the response admits: all of them, or the volume-preserving subspace.
    fn strains(&self, rates: &[Matrix3<f64>]) -> Vec<Matrix3<f64>> {
        match self.free_faces {
            None => rates.to_vec(),
            Some(_) => orthogonal_to(rates, &Matrix3::identity()),
        }
    }

    /// Unit combination of orthonormal rates of the deformation gradient along which a jump of the stress does the largest negative work.
    fn deformation_across(&self, rates: &[Matrix3<f64>], jump: &Matrix3<f64>) -> Option<Witness> {
        largest_along(rates, jump).map(|rate| deformation(&rate))
    }

    /// Unit combination of orthonormal rates of deformation along which a jump of the stress does the largest negative work.
    fn strain_across(&self, rates: &[Matrix3<f64>], jump: &Matrix3<f64>) -> Option<Witness> {
        let rates = self.within(&self.strains(rates));
        let tau = jump * self.response.deformation.matrix().transpose();
        largest_along(&rates, &tau).map(|rate| Witness::StrainRate { rate: rows(&rate) })
    }

    /// Energy gain, normal `N` and amplitude `a` of the jump `a (x) N` that lowers the energy most if the stress jumps by `jump` and the law is
    /// linear on both sides: the maximum of `-[P] : (a (x) N) - a . Q(N) a / 2`. `None` if no admitted jump lowers the energy.
    fn best_jump_across(
        &self,
        jump: &Matrix3<f64>,
        planar: bool,
    ) -> Option<(f64, Vector3<f64>, Vector3<f64>)> {
        let planar = planar || self.in_plane;
        let cofactor = cofactor(&self.response.deformation.matrix());
        let stiffness = Stiffness::<3>::of(&self.response).symmetric_part();
        let best = |n: Vector3<f64>| {
            let (mut q, mut drop) = (stiffness.acoustic_tensor(&n), jump * n);
            if planar {
                q.fill_row(2, 0.0);
                q.fill_column(2, 0.0);
                q[(2, 2)] = 1.0;
                drop[2] = 0.0;
            }
            let inverse = q.cholesky()?.inverse();
            let mut a = -inverse * drop;
            let mut pressure = 0.0;
            if self.free_faces.is_some() {
                let normal = cofactor * n;
                let along = inverse * normal;
                pressure = normal.dot(&a) / normal.dot(&along);
                a -= along * pressure;
            }
            Some((-0.5 * drop.dot(&a), n, a, pressure))
        };
        let axes = jumps::AXES.map(|axis| (self.right * Vector3::from(axis)).normalize());
        let axes = axes.into_iter().filter(|n| !planar || n[2] == 0.0);
        let sampled = match planar {
            true => directions::<2>().into_iter().map(|n| n.push(0.0)).collect(),
            false => directions::<3>(),
        };
        let all = axes.chain(sampled).filter_map(best);
        let mut found = all.max_by(|a, b| a.0.total_cmp(&b.0))?;
        // By the envelope theorem the gain changes with N by -[P]^T a - (a . A a) N, and by the multiplier of constant volume, a . cof F N = 0.
        let mut length = 0.1;
        for _ in 0..UPHILL {
            let (_, n, a, pressure) = found;
            let stress = self.response.tangent.contracted(&(a * n.transpose()));
            let mut slope = -(jump + stress + cofactor * pressure).transpose() * a;
            slope -= n * n.dot(&slope);
            if planar {
                slope[2] = 0.0;
            }
            let Some(step) = slope.try_normalize(1e-9 * found.0) else {
                break;
            };
            match best((n + step * length).normalize()).filter(|next| next.0 > found.0) {
                Some(next) => (found, length) = (next, 1.5 * length),
                None => length *= 0.3,
            }
        }
        let (gain, n, a, _) = found;
        let counts = (jump * n).dot(&a).abs() > ACROSS * jump.norm() * a.norm();
        (gain > 0.0 && counts).then_some((gain, n, a))
    }

    /// Smallest `(tau° : D - (tau : D) tr D) / J` over symmetric `D`.
    fn true_stress_monotonicity(&self) -> Measure {
        self.true_stress_along(&self.strains(&forms::symmetric_rates()))
    }

    fn true_stress_along(&self, rates: &[Matrix3<f64>]) -> Measure {
        let jacobian = self.response.deformation.jacobian();
        let of_volume = |tau: &Matrix3<f64>, a: &Matrix3<f64>, b: &Matrix3<f64>| {
            -0.5 * (tau.dot(a) * b.trace() + tau.dot(b) * a.trace())
        };
        let measure = match self.free_faces {
            None => self.jaumann_with(rates, of_volume),
            Some(_) => self.jaumann(rates),
        };
        Measure {
            value: measure.value / jacobian,
            zero: measure.zero / jacobian,
            rounding: measure.rounding / jacobian,
            ..measure
        }
    }

    /// Rates of deformation along the principal axes.
    fn axial_rates(&self) -> [Matrix3<f64>; 3] {
        [0, 1, 2].each(|i| self.left.column(i) * self.left.column(i).transpose())
    }

    fn surface(&self) -> Option<Measure> {
        let (tangent, faces) = (self.isotropic.as_ref()?, self.free_faces?);
        let (value, witness) = tangent.softest_surface_wave(&self.stretches(), faces)?;
        Some(self.of(value, witness))
    }

    /// Smallest `(D F) : A : (D F) + tau : D^2` over unit combinations of orthonormal rates of deformation.
    fn jaumann(&self, rates: &[Matrix3<f64>]) -> Measure {
        self.jaumann_with(rates, |_, _, _| 0.0)
    }

    /// Smallest value over unit combinations of orthonormal rates of deformation, with `other` as the bilinear form of Kirchhoff stress and two
    /// rates.
    fn jaumann_with(
        &self,
        rates: &[Matrix3<f64>],
        other: impl Fn(&Matrix3<f64>, &Matrix3<f64>, &Matrix3<f64>) -> f64,
    ) -> Measure {
        let rates = &self.within(rates)[..];
        let f = self.response.deformation.matrix();
        let tau = self.response.first_piola * f.transpose();
        let work = |a: &Matrix3<f64>, b: &Matrix3<f64>| {
            (tau * (a * b + b * a)).trace() * 0.5 + other(&tau, a, b)
        };
        let turned: Vec<Matrix3<f64>> = rates.iter().map(|d| d * f).collect();
        let (value, rate) = self.form.smallest_with(&turned, rates, work);
        self.of(value, Witness::StrainRate { rate: rows(&rate) })
    }

    fn load_maximum(&self, rate: &Matrix3<f64>) -> Measure {
        let value = self.form.at(rate, rate);
        self.of(value, deformation(&(rate / rate.norm())))
    }
}

/// Rate of the deformation gradient as a witness.
fn deformation(rate: &Matrix3<f64>) -> Witness {
    Witness::DeformationRate { rate: rows(rate) }
}

/// Unit combination of orthonormal tensors along which a tensor is largest; `None` if it has no part along them.
fn largest_along(basis: &[Matrix3<f64>], tensor: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let part: Matrix3<f64> = basis.iter().map(|own| own * own.dot(tensor)).sum();
    let norm = part.norm();
    (norm > ACROSS * tensor.norm()).then(|| part / norm)
}

/// Left and right principal axes in the columns of two rotations; the coordinate axes if `F` is diagonal.
fn principal_axes(f: &DeformationGradient) -> (Matrix3<f64>, Matrix3<f64>) {
    if f.is_block_diagonal::<1>() && f.components()[1][2] == 0.0 && f.components()[2][1] == 0.0 {
        return (Matrix3::identity(), Matrix3::identity());
    }
    let svd = f.matrix().try_svd(true, true, f64::EPSILON, 200);
    match svd.and_then(|svd| Some((svd.u?, svd.v_t?))) {
        Some((left, right)) => (left, right.transpose()),
        None => (Matrix3::identity(), Matrix3::identity()),
    }
}

fn wave(direction: &Vector3<f64>, polarization: &Vector3<f64>) -> Witness {
    Witness::Wave {
        direction: oriented(direction),
        polarization: oriented(polarization),
    }
}

/// Orients `v` so that its first non-negligible component is positive, and sets negligible components to zero.
fn oriented(v: &Vector3<f64>) -> [f64; 3] {
    let clean = v.map(|x| if x.abs() < 1e-15 { 0.0 } else { x });
    let sign = match clean.iter().find(|x| **x != 0.0) {
        Some(first) if *first < 0.0 => -1.0,
        _ => 1.0,
    };
    [0, 1, 2].each(|i| sign * clean[i] + 0.0)
}

/// Rows of `X`, with the sign for which the first non-negligible component is positive.
fn rows(matrix: &Matrix3<f64>) -> [[f64; 3]; 3] {
    let row_by_row = matrix.transpose();
    let leading = row_by_row.iter().find(|x| x.abs() > 1e-9);
    let sign = leading.map_or(1.0, |x| x.signum());
    array_of(|i| array_of(|j| sign * matrix[(i, j)] + 0.0))
}
