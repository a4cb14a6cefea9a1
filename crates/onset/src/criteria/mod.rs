//! Stability criteria side by side: each a quantity with a sign and a witness, by its own name.
//!
//! "Stable" means many things. A wave, a dead load, a machine that stretches a specimen, a code that fits a law to tests: each
//! asks another question, and a law can pass one and fail the next at the same state. A [`Criterion`] names the question; its
//! [`Measure`] at a [`State`] is positive where the answer is yes, and comes with the perturbation that makes it smallest.
//! [`Loading`] leads to states, with traction-free faces solved for; [`follow`] tells where along it a criterion is lost.
//! [`safe_box`] is the largest box of principal stretches in which a law is strongly elliptic.
//!
//! With `P = dW/dF`, `A = dP/dF`, Kirchhoff stress `tau = P F^T`, the polar decomposition `F = R U`, and principal stretches
//! `lambda_i`:
//!
//! | criterion | demands |
//! |---|---|
//! | [`StrongEllipticity`](Criterion::StrongEllipticity) | `A_iJkL g_i N_J g_k N_L > 0` for all `g`, `N` |
//! | [`PlaneEllipticity`](Criterion::PlaneEllipticity) | the same for `g`, `N` in the plane of the first two axes |
//! | [`RankOneConvexity`](Criterion::RankOneConvexity) | `W(F + a (x) N) > W(F) + P : a (x) N` for finite `a` |
//! | [`BakerEricksen`](Criterion::BakerEricksen) | `(sigma_i - sigma_j)(lambda_i - lambda_j) > 0` |
//! | [`Hill`](Criterion::Hill) | `Fdot : A : Fdot > 0` for all `Fdot` (dead loads; rotations included) |
//! | [`HillRotationFree`](Criterion::HillRotationFree) | the same for `Fdot = R S`, `S` symmetric (rotations held) |
//! | [`Drucker`](Criterion::Drucker) | `tau° : D > 0` for all `D`, `tau°` the Jaumann rate of `tau` |
//! | [`DruckerAbaqus`](Criterion::DruckerAbaqus) | `dtau_i dln(lambda_i) > 0` with principal axes held, of incompressible response for `sum dln(lambda_i) = 0` |
//! | [`TrueStressMonotonicity`](Criterion::TrueStressMonotonicity) | `sigma° : D > 0` for all `D`, `sigma°` the Jaumann rate of Cauchy stress |
//! | [`OrderedForces`](Criterion::OrderedForces) | `(T_i - T_j)(lambda_i - lambda_j) > 0`, `T_i = dW/dlambda_i` |
//! | [`LoadMaximum`](Criterion::LoadMaximum) | the load rises along the loading itself |
//! | [`Surface`](Criterion::Surface) | no wave at a free face stands still (incompressible response) |
//!
//! Of an isotropic law its incompressible response can be asked ([`LoadingPath::incompressible`]): states with `J = 1`, the pressure from a face
//! without traction, and in every criterion only increments that keep the volume.
//!
//! What follows from what: [`RankOneConvexity`](Criterion::RankOneConvexity) at a state implies ellipticity (not strict) there; strong
//! ellipticity of an isotropic law implies the Baker-Ericksen inequalities; [`Hill`](Criterion::Hill) implies strong ellipticity,
//! [`HillRotationFree`](Criterion::HillRotationFree) and that the load rises. [`Drucker`](Criterion::Drucker)'s inequality and strong ellipticity
//! imply nothing for each other.

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

use crate::algebra::{Each, array_of};
use crate::continuum::{ROUNDING as ZERO, Stiffness};
use crate::kinematics::DeformationGradient;
use crate::material::{Hyperelastic, MaterialError, Response, cofactor};
use forms::QuadraticForm;
use incompressible::{orthogonal_to, stretches_along};
use isotropy::PrincipalTangent;
use nalgebra::{Matrix3, Vector3};

/// A stability criterion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Criterion {
    /// All wave speeds are real: `A_iJkL g_i N_J g_k N_L > 0` for all directions `N` and polarizations `g`.
    ///
    /// Source: Hadamard, Leçons sur la propagation des ondes (1903); Truesdell and Noll, The non-linear field theories of mechanics (1965),
    /// section 44. Its loss is that of the waves' speed: shear bands and other bands of any thickness can form.
    ///
    /// For isotropic laws decided exactly: in principal axes, with `W_ij` the second derivatives of the energy by the
    /// stretches, the form is nowhere negative if and only if the shear stiffnesses `A_ijij` are not negative and the matrices with
    /// `W_ii` on the diagonal and `e_i e_j (W_ij + A_ijji) + A_ijij` beside it are copositive for all signs `e` (Simpson and Spector,
    /// Arch. Ration. Mech. Anal. 84 (1983) 55). The measure is the smallest value that these conditions attain, a value of the form
    /// at unit vectors; for other laws it is the smallest eigenvalue of all acoustic tensors. Units of stress.
    StrongEllipticity,
    /// All waves in the plane of the first two axes have real speeds: what a simulation in plane strain can see.
    ///
    /// The measure is the smallest eigenvalue of the acoustic tensors in the plane, exact. Units of stress. Source: as
    /// [`Criterion::StrongEllipticity`].
    PlaneEllipticity,
    /// No layering with finite jumps costs less energy: `W(F + a (x) N) - W(F) - P : (a (x) N) > 0` for all `a`, `N`.
    ///
    /// Source: Ball, Arch. Ration. Mech. Anal. 63 (1977) 337; Morrey (1952). The measure is the smallest `2 (W(F + a (x) N) - W(F) -
    /// P : a (x) N) / |a|^2` that a search finds; see [`JumpSearch`]. Units of stress. A negative value is a proof up to rounding (or in
    /// intervals: [`JumpSearch::proves`]), a positive one says that none was found: a limit along a loading is an upper bound, jumps that were
    /// not found may gain energy nearer to the reference. It is never later than the loss of ellipticity, and earlier wherever the third
    /// derivative of the energy along the critical wave does not vanish.
    RankOneConvexity,
    /// The larger principal stress acts along the larger principal stretch: `(sigma_i - sigma_j)(lambda_i - lambda_j) > 0`.
    ///
    /// Source: Baker and Ericksen, J. Wash. Acad. Sci. 44 (1954) 33; for isotropic laws. The measure is the smallest
    /// `(tau_i - tau_j) / (lambda_i^2 - lambda_j^2)`, which is the component `A_ijij` of the tangent in principal axes and so has its
    /// limit at equibiaxial stretches. Units of stress.
    BakerEricksen,
    /// No rate gains energy under dead loads: `Fdot : A : Fdot > 0` for all `Fdot`.
    ///
    /// Source: Hill, J. Mech. Phys. Solids 5 (1957) 229 and 6 (1958) 236: where it holds everywhere, the rates of a body under dead loads
    /// are unique. All nine rates are admitted, rotations too: for `Fdot = w x F` the form is that of the stress alone,
    /// `tr(tau) |w|^2 - w . tau w`, so the condition is neutral without stress and in uniaxial tension (rotation about the load), and never holds
    /// where two principal stresses have a negative sum, whatever the law. A value that is zero to rounding (3e-14 of the tangent) counts as held, which can move a limit by 1e-9. The measure is the smallest
    /// eigenvalue of `A` as a matrix of nine rows. Units of stress.
    Hill,
    /// No rate without rotation gains energy under dead loads: `Fdot : A : Fdot > 0` for all `Fdot = R S`, `S` symmetric.
    ///
    /// The energy is convex in the right stretch tensor `U` to second order. Source: Coleman and Noll, Arch. Ration. Mech. Anal. 4
    /// (1959) 97; in rates Hill, J. Mech. Phys. Solids 16 (1968) 229, with Biot stress and `U` as conjugate measures. The measure is the
    /// smallest eigenvalue on these six rates. Units of stress.
    HillRotationFree,
    /// Stress work of second order is positive: `tau° : D > 0` for all rates of deformation `D`, with the Jaumann rate of Kirchhoff
    /// stress.
    ///
    /// It is `(D F) : A : (D F) + tau : D^2 > 0`. Source: Hill, J. Mech. Phys. Solids 16 (1968) 229; Leblond, Eur. J. Mech. A 11 (1992) 447: for isotropic
    /// laws the same as convexity in the logarithmic strain. Programs that fit laws call it Drucker's stability, after Drucker, J. Appl.
    /// Mech. 26 (1959) 101. The measure is the smallest eigenvalue on symmetric `D`. Units of stress.
    Drucker,
    /// Drucker stability as Abaqus and other fitting codes check it: with principal axes held, `dtau_i dln(lambda_i) > 0`; of incompressible response for
    /// `sum dln(lambda_i) = 0`.
    ///
    /// The matrix `dtau_i / dln(lambda_j)` is positive definite; without compressibility (`D = 0`) the matrix with two rows that is left when the third strain
    /// is eliminated: no pressure does work on such increments, so that neither it nor the volumetric part of the law counts. Source: Abaqus Analysis Guide,
    /// Hyperelastic behavior of rubberlike materials, "Material stability" (checked there for stretches 0.1 to 10). The measure is the smallest eigenvalue, in
    /// logarithmic strain of unit length. Units of stress.
    DruckerAbaqus,
    /// True stress grows with true strain (TSTS-M++): `sigma° : D > 0` for all rates of deformation `D`, with the Jaumann rate of Cauchy stress.
    ///
    /// It is `(tau° : D - (tau : D) tr D) / J > 0`: of isotropic laws the derivative of the Cauchy stress by the logarithmic strain is positive
    /// definite. Source: Jog and Patil, Arch. Appl. Mech. 83 (2013) 661; Wollner, Holzapfel and Neff, arXiv 2509.08597 (2025), who show that neither
    /// it nor polyconvexity implies the other. Where the volume is kept it is Drucker's inequality. The measure is the smallest eigenvalue on
    /// symmetric `D`. Units of stress.
    TrueStressMonotonicity,
    /// The larger principal force acts along the larger principal stretch: `(T_i - T_j)(lambda_i - lambda_j) > 0`, `T_i = dW/dlambda_i` (Biot stress).
    ///
    /// Source: Coleman and Noll, Arch. Ration. Mech. Anal. 4 (1959) 97; Truesdell and Noll, The non-linear field theories of mechanics (1965),
    /// section 51 (O-F inequalities); for isotropic laws. The measure is the smallest `(T_i - T_j) / (lambda_i - lambda_j)`, which is `A_ijij +
    /// A_ijji` of the tangent in principal axes and so has its limit at equibiaxial stretches. Units of stress.
    OrderedForces,
    /// The load rises along the loading: `Pdot : Fdot > 0` along the path itself, with its traction-free faces.
    ///
    /// Under a prescribed load the specimen runs away where this ends (Considère, Ann. Ponts Chaussées 9 (1885) 574, for bars); under a
    /// prescribed elongation a homogeneous specimen does not notice. For a single loaded direction `Pdot : Fdot = dP/dlambda` times a
    /// positive number. The measure is `Pdot : Fdot` with the rate by the logarithm of the stretch. Units of stress.
    LoadMaximum,
    /// No wave at a free face stands still: Biot's surface instability, of incompressible isotropic response.
    ///
    /// For waves along the principal axis `i` at a face normal to the axis `j` without traction, with the instantaneous moduli `A0` and
    /// `eta = lambda_i / lambda_j`, it is `2 eta (beta + gamma) + alpha - gamma > 0`, `alpha = A0_ijij`, `gamma = A0_jiji`,
    /// `2 beta = A0_iiii + A0_jjjj - 2 A0_iijj - 2 A0_ijji`. Source: Biot, Appl. Sci. Res. A 12 (1963) 168; Dowaikh and Ogden, IMA J. Appl. Math. 44
    /// (1990) 261. Neo-Hooke's rubber wrinkles where `eta^3 + eta^2 + 3 eta = 1`. The measure is the smallest left side over free faces and axes in
    /// them; waves at an angle to the axes are not looked at. Units of stress.
    Surface,
}

/// The value of a criterion at a state; positive where it holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measure {
    /// The smallest value found; units of stress.
    pub value: f64,
    /// Values above `-neutral` count as held; zero but for criteria that are neutral at whole sets of states.
    pub neutral: f64,
    /// Values up to this are zero to rounding, which is not positive; as of [`AcousticMinimum::rounding`](crate::continuum::AcousticMinimum).
    pub zero: f64,
    /// Along a loading, values nearer to zero than this can be rounding: their sign says nothing.
    pub rounding: f64,
    /// The perturbation with this value.
    pub witness: Witness,
}

impl Measure {
    /// A number with the sign of the criterion: negative where it does not hold.
    pub fn signed(&self) -> f64 {
        self.value + self.neutral
    }

    /// Whether the criterion holds, beyond rounding.
    pub fn holds(&self) -> bool {
        if self.neutral > 0.0 {
            self.signed() > 0.0
        } else {
            self.value > self.zero
        }
    }
}

/// The perturbation that makes a measure smallest.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize),
    serde(tag = "kind", rename_all = "kebab-case")
)]
pub enum Witness {
    /// A plane wave: unit direction `N` (reference) and unit polarization `g`.
    Wave {
        /// `N`.
        direction: [f64; 3],
        /// `g`.
        polarization: [f64; 3],
    },
    /// A rate of the deformation gradient of unit length, `Fdot_iJ`.
    DeformationRate {
        /// `Fdot_iJ`.
        rate: [[f64; 3]; 3],
    },
    /// A rate of deformation of unit length, `D_ij`.
    StrainRate {
        /// `D_ij`.
        rate: [[f64; 3]; 3],
    },
    /// A wave along a free face that stands still.
    SurfaceWave {
        /// The unit normal of the face (reference).
        normal: [f64; 3],
        /// The unit direction of the wave in the face (reference).
        direction: [f64; 3],
    },
    /// A finite jump `a (x) N` of the deformation gradient.
    Jump {
        /// `a`.
        amplitude: [f64; 3],
        /// `N`, of unit length.
        direction: [f64; 3],
        /// Whether the jump leads to the largest stretch that was looked at; the limit then depends on that, and is rough.
        at_edge: bool,
        /// Whether the jump leads to as good as no volume, where the law has a finite energy.
        collapses: bool,
        /// Whether interval arithmetic proves that the jump gains energy; to rounding only where it does not, or where the law knows no
        /// intervals.
        verified: bool,
    },
}

impl Criterion {
    /// All of them, in the order of tables.
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

    /// The word used in files and tables.
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

    /// What it is called in sentences.
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

    /// What it demands, as a formula.
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

    /// Where it is from.
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

    /// The criterion with a name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|criterion| criterion.name() == name)
    }

    /// The measure at a state. `None` where the criterion is not defined: Baker-Ericksen and ordered forces for laws that are not isotropic, the load maximum
    /// at a state without a loading, the surface at a state that is not incompressible, and rank-one convexity always, since its search needs the
    /// law: see [`JumpSearch`].
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
}

/// How far below zero, in units of the largest component of the tangent, rounding can leave a form that is zero.
const NEUTRAL: f64 = 3e-14;
/// How much of the largest component of the tangent can be rounding where stretches are equal. Between axes of a different stretch
/// it grows with their ratio: the small stiffness of the one is found beside the large stiffness of the other.
const ROUNDING: f64 = 1e-13;

/// Where the ratio of the principal stretches is larger, the sign of a measure counts as rounding along a loading: the tangent in principal
/// axes has lost too many digits.
const LARGEST_RATIO: f64 = 1e4;

fn ratio_of_stretches(response: &Response) -> f64 {
    let [largest, _, smallest] = response.deformation.principal_stretches();
    largest / smallest
}

/// A state at which criteria are asked: the response of a law, its principal axes, and the loading that led there.
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
    /// Where the response is incompressible: coordinate axes whose faces are free of traction.
    free_faces: Option<&'static [usize]>,
}

impl State {
    /// A state of a law, without a loading. Whether the law is isotropic is found out ([`is_isotropic`]).
    ///
    /// # Errors
    /// [`MaterialError`] when the response is not finite.
    pub fn new(
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
    ) -> Result<Self, MaterialError> {
        Ok(Self::of_response(
            material.response(f)?,
            is_isotropic(material),
        ))
    }

    /// A state with a known response.
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
        }
    }

    /// The state of a law of the plane: increments and waves stay in it.
    pub fn in_plane(mut self) -> Self {
        self.in_plane = true;
        self
    }

    /// Of orthonormal rates or strains along and across the plane those within the dimensions of the law.
    fn within(&self, rates: &[Matrix3<f64>]) -> Vec<Matrix3<f64>> {
        let is_within = |rate: &&Matrix3<f64>| {
            !self.in_plane || rate.row(2).amax().max(rate.column(2).amax()) < 1e-9
        };
        rates.iter().filter(is_within).copied().collect()
    }

    /// The state as one of incompressible response, with free faces.
    fn incompressible(mut self, free_faces: &'static [usize]) -> Self {
        self.free_faces = Some(free_faces);
        self
    }

    /// Of orthonormal rates those that the response admits: all, or those that keep the volume.
    fn admitted(&self, rates: &[Matrix3<f64>]) -> Vec<Matrix3<f64>> {
        match self.free_faces {
            None => self.within(rates),
            Some(_) => orthogonal_to(rates, &cofactor(&self.response.deformation.matrix())),
        }
    }

    /// The stretches along principal axes.
    fn stretches(&self) -> Vector3<f64> {
        stretches_along(&self.response.deformation, &self.left, &self.right)
    }

    /// The state with the rate `dF/ds` of the loading that led to it.
    pub fn with_rate(mut self, rate: Matrix3<f64>) -> Self {
        self.rate = Some(rate);
        self
    }

    /// Energy, stress and tangent.
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
                ratio => ROUNDING * self.form.magnitude() * ratio,
            },
            witness,
        }
    }

    /// The smallest value of `g . Q(N) g` where it is below a level; elsewhere one above the level.
    fn strong_ellipticity(&self, below: f64) -> Measure {
        if self.in_plane {
            return self.plane_ellipticity();
        }
        // The closed form takes the tangent for symmetric.
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
            ..self.of(value, Witness::DeformationRate { rate: rows(&rate) })
        }
    }

    fn hill_rotation_free(&self) -> Measure {
        let rotation = self.left * self.right.transpose();
        let rates = forms::symmetric_rates().each(|s| rotation * s);
        let (value, rate) = self.form.smallest(&self.admitted(&rates));
        self.of(value, Witness::DeformationRate { rate: rows(&rate) })
    }

    fn drucker(&self) -> Measure {
        match self.free_faces {
            None => self.jaumann(&forms::symmetric_rates()),
            Some(_) => self.jaumann(&orthogonal_to(
                &forms::symmetric_rates(),
                &Matrix3::identity(),
            )),
        }
    }

    fn drucker_abaqus(&self) -> Measure {
        let rates = self.axial_rates();
        match self.free_faces {
            None => self.jaumann(&rates),
            Some(_) => self.jaumann(&orthogonal_to(&rates, &Matrix3::identity())),
        }
    }

    /// The smallest `(tau° : D - (tau : D) tr D) / J` over symmetric `D`.
    fn true_stress_monotonicity(&self) -> Measure {
        let jacobian = self.response.deformation.jacobian();
        let of_volume = |tau: &Matrix3<f64>, a: &Matrix3<f64>, b: &Matrix3<f64>| {
            -0.5 * (tau.dot(a) * b.trace() + tau.dot(b) * a.trace())
        };
        let rates = forms::symmetric_rates();
        let measure = match self.free_faces {
            None => self.jaumann_with(&rates, of_volume),
            Some(_) => self.jaumann(&orthogonal_to(&rates, &Matrix3::identity())),
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

    /// The smallest `(D F) : A : (D F) + tau : D^2` over combinations of some orthonormal rates of deformation.
    fn jaumann(&self, rates: &[Matrix3<f64>]) -> Measure {
        self.jaumann_with(rates, |_, _, _| 0.0)
    }

    /// The same with another bilinear form of the Kirchhoff stress and two rates.
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
        let unit = rate / rate.norm();
        self.of(value, Witness::DeformationRate { rate: rows(&unit) })
    }
}

/// Left and right principal axes in the columns of two rotations; the coordinate axes where `F` is diagonal.
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

/// Of `v` and `-v` the one whose first component that is not negligible is positive, without negligible components.
fn oriented(v: &Vector3<f64>) -> [f64; 3] {
    let clean = v.map(|x| if x.abs() < 1e-15 { 0.0 } else { x });
    let sign = match clean.iter().find(|x| **x != 0.0) {
        Some(first) if *first < 0.0 => -1.0,
        _ => 1.0,
    };
    [0, 1, 2].each(|i| sign * clean[i] + 0.0)
}

/// The rows of `X` or `-X`: the one whose first component that is not negligible is positive.
fn rows(matrix: &Matrix3<f64>) -> [[f64; 3]; 3] {
    let row_by_row = matrix.transpose();
    let leading = row_by_row.iter().find(|x| x.abs() > 1e-9);
    let sign = leading.map_or(1.0, |x| x.signum());
    array_of(|i| array_of(|j| sign * matrix[(i, j)] + 0.0))
}
