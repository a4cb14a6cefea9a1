//! Proofs of stability and of instability.
//!
//! [`judge`](crate::verdict::judge) samples the zone and follows local minima: its verdict is very likely right, but not proved. A [`Certificate`]
//! classifies material and discretization separately as one of:
//!
//! - proved stable, with a lower bound over *all* directions or wave vectors,
//! - proved unstable, with a wave whose growth interval arithmetic confirms,
//! - undecided.
//!
//! A proof concerns the linearized equations of a perfect infinite lattice as this crate defines them, with the state and all constants taken as the
//! exact values of their doubles. It assumes that the processor complies with IEEE 754 and that the elementary functions of the platform are accurate
//! to four units in the last place. The book derives the bounds.

mod cover;
mod ellipticity;
mod expansion;
mod patch;
mod points;
mod space;
mod waves;

pub use space::{SpaceCertificate, certify_3d};

use crate::algebra::Each;
use crate::bloch::{Stability, ZoneSearch, dynamical_matrix};
use crate::continuum::Stiffness;
use crate::kinematics::DeformationGradient;
use crate::lattice::BrillouinZone;
use crate::material::Hyperelastic;
use crate::method::{Background, Frame, Method, MethodError};
use crate::quadrature::QuadraturePoint;
use crate::real::Interval;
use crate::scheme::Discretization;
use crate::verdict::{SurveyedState, Verdict, decided, speed_squared};
use cover::{Finding, GrowingWave, Question, cover};
use ellipticity::{Acoustic, Proved};
use nalgebra::SVector;

/// Largest growth rate of oscillations that does not count as instability, in units of sound speed over spacing, as in [`ZoneSearch`].
///
/// Where two branches cross, the discriminant touches zero, and no computation with rounding can prove that it does not become negative.
pub const GROWTH: f64 = 1e-7;

/// Default fraction of the smallest sampled measure that is proved as a lower bound.
const SHARE: f64 = 0.5;
/// Default number of boxes per cover.
const BUDGET: usize = 100_000;
/// Largest number of intervals of directions per proof of ellipticity.
const DIRECTIONS: usize = 2_000;

/// Proved statements about material and discretization at a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Certificate<const D: usize> {
    /// Strong ellipticity of the material. Measures are acoustic eigenvalues divided by `rho0 c^2`, witnesses are directions `N`.
    pub material: Certainty<D>,
    /// Stability of the waves of the discretization. Measures are `Re omega^2 / (c^2 |k|_h^2)`, witnesses are wave vectors.
    pub discretization: Certainty<D>,
}

/// Three-valued result of a proof, with its evidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Certainty<const D: usize> {
    /// Proved stable: the measure has a positive lower bound, and no oscillation grows faster than [`GROWTH`].
    Stable {
        /// Positive lower bound of the measure over the whole zone, the limit of long waves included.
        bound: f64,
    },
    /// All `omega^2 >= 0`, and a wave of finite length is a zero-energy mode at any state: its strain vanishes at every quadrature point.
    ZeroEnergy {
        /// Reference wave vector of the mode.
        wave_vector: SVector<f64, D>,
    },
    /// Proved unstable: a wave grows.
    Unstable {
        /// Wave whose growth is confirmed.
        witness: Witness<D>,
    },
    /// Neither stability nor instability is proved.
    Undecided {
        /// Smallest sampled measure; NaN if none could be evaluated.
        measure: f64,
        /// Reason why the proof failed.
        reason: Reason,
    },
}

/// Wave that certainly grows, or direction in which ellipticity is certainly lost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Witness<const D: usize> {
    /// Reference wave vector, 1/length; for a material the direction `N`.
    pub wave_vector: SVector<f64, D>,
    /// Exact phases `k.a_i` at which the wave was confirmed; for a material the direction `N`.
    pub phases: SVector<f64, D>,
    /// Bounds of the measure.
    pub measure: Interval,
    /// Lower bound of the growth rate in units of sound speed over spacing. For a material, where waves of any length grow, in units of sound speed
    /// times wave number.
    pub growth_rate: f64,
}

/// Reason why a state is undecided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// The measure is within the stated tolerance of zero.
    WithinTolerance,
    /// The measure is positive, proved or sampled, but oscillations may grow slightly faster than [`GROWTH`].
    Growth,
    /// The limit on the number of boxes was reached although the measure is beyond the tolerance.
    Budget,
    /// The quadrature points have no inversion symmetry, which the proof requires.
    NoInversionCenter,
    /// The lattice is three-dimensional. The proof covers waves in one and two dimensions.
    Dimension,
    /// The enclosures are not finite at this state.
    NotFinite,
    /// No interval enclosure is implemented for the force constants of this method, approximation or quadrature. Its waves are searched, not proved.
    Method,
}

impl Reason {
    /// All reasons, in the order of their flags in files.
    pub const ALL: [Self; 7] = [
        Self::WithinTolerance,
        Self::Growth,
        Self::Budget,
        Self::NoInversionCenter,
        Self::Dimension,
        Self::NotFinite,
        Self::Method,
    ];

    /// Name of the reason in files and legends.
    pub fn name(self) -> &'static str {
        match self {
            Self::WithinTolerance => "within-tolerance",
            Self::Growth => "growth",
            Self::Budget => "budget",
            Self::NoInversionCenter => "no-inversion-center",
            Self::Dimension => "dimension",
            Self::NotFinite => "not-finite",
            Self::Method => "method",
        }
    }
}

impl<const D: usize> Certificate<D> {
    /// Verdict and type of instability, with proved statements taking precedence over the results of a search.
    pub fn corrected(&self, found: &SurveyedState<D>) -> (Verdict, Stability) {
        let material_grows = match self.material {
            Certainty::Stable { .. } => false,
            Certainty::Unstable { .. } => true,
            _ => found.acoustic.has_growing_waves(),
        };
        let searched = found.stability;
        let (stability, has_zero_mode) = match &self.discretization {
            // Even if no wave grows, a zero-energy mode can be stabilized by stress alone.
            Certainty::Stable { .. } => {
                let has_zero_mode = found.verdict == Verdict::ZeroEnergy;
                (Stability::Stable, has_zero_mode)
            }
            Certainty::ZeroEnergy { .. } => (Stability::Stable, true),
            Certainty::Unstable { witness } if searched == Stability::Stable => {
                (witness.stability(), false)
            }
            _ => (searched, found.verdict == Verdict::ZeroEnergy),
        };
        let is_stable = stability == Stability::Stable;
        let verdict = decided(
            material_grows,
            is_stable,
            has_zero_mode,
            found.long_waves_grow,
        );
        (verdict, stability)
    }
}

impl<const D: usize> Witness<D> {
    /// Type of growth: divergence, or flutter if the measure may be positive.
    pub fn stability(&self) -> Stability {
        if self.measure.high < 0.0 {
            Stability::Divergence
        } else {
            Stability::Flutter
        }
    }
}

impl<const D: usize> Certainty<D> {
    /// Name of the result, as used in files and legends.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Stable { .. } => "proved-stable",
            Self::ZeroEnergy { .. } => "proved-zero-energy",
            Self::Unstable { .. } => "proved-unstable",
            Self::Undecided { .. } => "undecided",
        }
    }

    /// Converts to `E` dimensions: vectors are truncated or padded with zeros.
    pub(crate) fn in_dimensions<const E: usize>(&self) -> Certainty<E> {
        let vector = |v: &SVector<f64, D>| SVector::from_fn(|i, _| if i < D { v[i] } else { 0.0 });
        match *self {
            Self::Stable { bound } => Certainty::Stable { bound },
            Self::ZeroEnergy { wave_vector } => Certainty::ZeroEnergy {
                wave_vector: vector(&wave_vector),
            },
            Self::Unstable { witness } => Certainty::Unstable {
                witness: Witness {
                    wave_vector: vector(&witness.wave_vector),
                    phases: vector(&witness.phases),
                    measure: witness.measure,
                    growth_rate: witness.growth_rate,
                },
            },
            Self::Undecided { measure, reason } => Certainty::Undecided { measure, reason },
        }
    }

    /// Returns true if stability or instability is proved.
    pub fn is_decided(&self) -> bool {
        !matches!(self, Self::Undecided { .. })
    }

    /// Undecided result for a reason that is independent of a measure.
    fn unproved(reason: Reason) -> Self {
        Self::Undecided {
            measure: f64::NAN,
            reason,
        }
    }

    fn undecided(measure: f64, tolerance: f64, is_growth: bool) -> Self {
        let reason = if measure.is_nan() {
            Reason::NotFinite
        } else if measure.abs() <= tolerance {
            Reason::WithinTolerance
        } else if is_growth {
            Reason::Growth
        } else {
            Reason::Budget
        };
        Self::Undecided { measure, reason }
    }
}

/// Proves stability or instability of a material and a discretization at a homogeneous state.
///
/// All states are treated with the same effort. For an undecided state the reason distinguishes measures within `tolerance` of zero. For many states
/// of one discretization, [`Certifier`] is faster.
///
/// ```
/// use onset::certificate::{Certainty, certify};
/// use onset::kinematics::DeformationGradient;
/// use onset::material::ModifiedMooneyRivlin;
/// use onset::method::{KernelMethodChoices, Frame, Method};
/// let (material, f) = (
///     ModifiedMooneyRivlin::default(),
///     DeformationGradient::from_stretches([1.2, 1.0, 1.0])?,
/// );
/// let lagrangian = Method::<2>::new(KernelMethodChoices::default())?;
/// let proof = certify(&lagrangian, &material, &f, 1e-3)?;
/// assert!(matches!(proof.discretization, Certainty::Stable { bound } if bound > 0.0));
///
/// let sph = KernelMethodChoices { frame: Frame::Eulerian, ..KernelMethodChoices::default() };
/// let proof = certify(&Method::<2>::new(sph)?, &material, &f, 1e-3)?;
/// assert_eq!(proof.material.name(), "proved-stable");
/// assert_eq!(proof.discretization.name(), "proved-unstable");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`MethodError`] if the method or the material cannot be evaluated at the state.
pub fn certify<const D: usize>(
    discretization: &dyn Discretization<D>,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
    tolerance: f64,
) -> Result<Certificate<D>, MethodError> {
    Certifier::new(discretization, material, tolerance)?.certify(f)
}

/// Certifier of states of one discretization and one material. Proofs that do not depend on the state are computed once.
pub struct Certifier<'a, const D: usize> {
    density: f64,
    /// Method whose force constants are enclosed; `None` if no enclosure exists, so that nothing about the waves is proved.
    method: Option<&'a Method<D>>,
    material: &'a dyn Hyperelastic,
    tolerance: f64,
    share: f64,
    budget: usize,
    /// Squared wave speed `c^2`.
    speed_squared: f64,
    /// Proved bound of the discrete gradient with Lagrangian kernels, which does not depend on the state.
    gradient: Option<Gradient<D>>,
}

/// State-independent proofs of a method and a material.
///
/// These proofs take most of the time of [`Certifier::new`]. They can be stored where a certifier cannot, because it borrows.
#[derive(Clone, Copy, Debug)]
pub struct Foundation<const D: usize> {
    speed_squared: f64,
    gradient: Option<Gradient<D>>,
}

/// Proved property of the discrete gradient of a Lagrangian method.
#[derive(Clone, Copy, Debug)]
enum Gradient<const D: usize> {
    /// Proved `bound` with `sum_q V_q |B_q|^2 / (rho V0) >= bound L`.
    Bounded(f64),
    /// Phases of a wave whose discrete gradient vanishes.
    Vanishes(SVector<f64, D>),
}

impl<'a, const D: usize> Certifier<'a, D> {
    /// Creates a certifier and computes the proofs that do not depend on the state.
    ///
    /// # Errors
    /// [`MethodError`] if the material in the reference state or a Lagrangian method cannot be evaluated.
    pub fn new(
        discretization: &'a dyn Discretization<D>,
        material: &'a dyn Hyperelastic,
        tolerance: f64,
    ) -> Result<Self, MethodError> {
        let ground = Foundation {
            speed_squared: speed_squared(discretization, material)?,
            gradient: None,
        };
        let mut certifier = Self::founded(ground, discretization, material, tolerance);
        if let Some(method) = certifier.method
            && method.choices().frame == Frame::Lagrangian
            && D <= 2
        {
            certifier.gradient = certifier.gradient(method)?;
        }
        Ok(certifier)
    }

    /// State-independent proofs of this certifier.
    pub fn foundation(&self) -> Foundation<D> {
        Foundation {
            speed_squared: self.speed_squared,
            gradient: self.gradient,
        }
    }

    /// Creates a certifier from the state-independent proofs of another certifier, which must have the same discretization and material.
    pub fn founded(
        foundation: Foundation<D>,
        discretization: &'a dyn Discretization<D>,
        material: &'a dyn Hyperelastic,
        tolerance: f64,
    ) -> Self {
        Self {
            density: discretization.density(),
            method: discretization.enclosed(),
            material,
            tolerance,
            share: SHARE,
            budget: BUDGET,
            speed_squared: foundation.speed_squared,
            gradient: foundation.gradient,
        }
    }

    /// Sets the fraction of the true minimum, up to 0.95, to be proved as a lower bound. Fractions near one require more work.
    pub fn with_share(mut self, share: f64) -> Self {
        self.share = share.clamp(0.01, 0.95);
        self
    }

    /// Sets the number of boxes after which a state is undecided.
    pub fn with_budget(mut self, boxes: usize) -> Self {
        self.budget = boxes;
        self
    }

    /// Returns the certificate of a state.
    ///
    /// # Errors
    /// [`MethodError`] if the material, or a method with enclosed force constants, cannot be evaluated there.
    pub fn certify(&self, f: &DeformationGradient) -> Result<Certificate<D>, MethodError> {
        if !f.is_block_diagonal::<D>() {
            return Err(MethodError::NotPlanar { dimension: D });
        }
        let response = self.material.response(f)?;
        if D > 2 {
            return self.in_three_dimensions(f);
        }
        let hint = Stiffness::<D>::of(&response).minimum().direction;
        let exact = DeformationGradient::from_components(
            f.components().each(|row| row.map(Interval::point)),
        );
        let ellipticity = self.ellipticity(&exact, &hint);
        Ok(Certificate {
            material: self.of_material(ellipticity),
            discretization: match self.method {
                Some(method) => self.of_discretization(method, f, &hint, ellipticity)?,
                None => Certainty::unproved(Reason::Method),
            },
        })
    }

    /// Certificate for a three-dimensional lattice: ellipticity is proved for the material, but nothing is proved about the waves.
    fn in_three_dimensions(&self, f: &DeformationGradient) -> Result<Certificate<D>, MethodError> {
        let proof = certify_3d(self.material, f, self.tolerance)?.certainty;
        Ok(Certificate {
            material: proof.in_dimensions(),
            discretization: Certainty::unproved(match self.method {
                Some(_) => Reason::Dimension,
                None => Reason::Method,
            }),
        })
    }

    fn ellipticity(&self, f: &DeformationGradient<Interval>, hint: &SVector<f64, D>) -> Proved {
        let acoustic = Acoustic::new::<D>(&self.material.enclosure(f).tangent);
        acoustic.ellipticity(planar(hint), DIRECTIONS)
    }

    fn of_material(&self, ellipticity: Proved) -> Certainty<D> {
        let scale = self.density * self.speed_squared;
        match ellipticity {
            // The scale is itself a rounded double, so two roundings occur.
            Proved::Bounded(bound) if bound > 0.0 => Certainty::Stable {
                bound: bound / scale * (1.0 - 4.0 * f64::EPSILON),
            },
            Proved::Bounded(bound) => Certainty::undecided(bound, self.tolerance, false),
            Proved::Refuted {
                direction,
                eigenvalue,
            } => {
                let wave_vector = SVector::from_fn(|i, _| direction[i]);
                let measure = eigenvalue / Interval::point(scale);
                Certainty::Unstable {
                    witness: Witness {
                        wave_vector,
                        phases: wave_vector,
                        measure,
                        growth_rate: lower_root(-measure.high),
                    },
                }
            }
            Proved::Open { eigenvalue } => {
                Certainty::undecided(eigenvalue / scale, self.tolerance, false)
            }
        }
    }

    fn of_discretization(
        &self,
        method: &Method<D>,
        f: &DeformationGradient,
        hint: &SVector<f64, D>,
        ellipticity: Proved,
    ) -> Result<Certainty<D>, MethodError> {
        let is_imposed = method.choices().background == Background::Imposed;
        // The tangents at all points are equal and elliptic, so the theorem applies.
        if let (Some(gradient), true, Proved::Bounded(bound)) =
            (self.gradient, is_imposed, ellipticity)
            && bound > 0.0
        {
            return Ok(self.by_theorem(method, gradient, bound));
        }
        let order = crate::approximation::Order::First;
        method.configuration(f, order)?;
        let points = match points::points(method, f) {
            Ok(points) => points,
            Err(reason) => return Ok(Certainty::unproved(reason)),
        };
        if let Some(gradient) = self.gradient {
            // The tangents differ but are all elliptic: the theorem applies with the smallest bound.
            let mut least = f64::INFINITY;
            for point in &points {
                least = match self.ellipticity(&point.deformation, hint) {
                    Proved::Bounded(bound) => least.min(bound),
                    _ => 0.0,
                };
            }
            if least > 0.0 {
                return Ok(self.by_theorem(method, gradient, least));
            }
        }
        let waves = waves::dynamical_waves(method, self.material, &points);
        Ok(self.of_waves(method, f, &waves))
    }

    /// Theorem for strong ellipticity at all points, positive volumes and inversion symmetry: `D >= bound sum_q V_q |B_q|^2`.
    fn by_theorem(&self, method: &Method<D>, gradient: Gradient<D>, bound: f64) -> Certainty<D> {
        match gradient {
            Gradient::Bounded(gradient) => Certainty::Stable {
                bound: self.scaled(method, bound * gradient) * (1.0 - 16.0 * f64::EPSILON),
            },
            Gradient::Vanishes(phases) => Certainty::ZeroEnergy {
                wave_vector: wave_vector(method, &phases),
            },
        }
    }

    fn of_waves(
        &self,
        method: &Method<D>,
        f: &DeformationGradient,
        waves: &waves::Waves,
    ) -> Certainty<D> {
        let (zone, farthest) = zone(method, f);
        let spacing = method.choices().spacing;
        let growth = GROWTH * GROWTH * self.speed_squared / (spacing * spacing);
        let finding = cover(
            waves,
            &Question {
                zone: &zone,
                farthest,
                growth_squared: growth,
                share: self.share,
                budget: self.budget,
            },
            || self.candidates(method, f),
        );
        match finding {
            Finding::Bounded(bound) if bound > 0.0 => Certainty::Stable {
                bound: self.scaled(method, bound) * (1.0 - 16.0 * f64::EPSILON),
            },
            Finding::Bounded(bound) => Certainty::undecided(bound, self.tolerance, false),
            Finding::Grows(wave) => Certainty::Unstable {
                witness: self.witness(method, &wave),
            },
            Finding::Open { measure, is_growth } => {
                Certainty::undecided(self.scaled(method, measure), self.tolerance, is_growth)
            }
        }
    }

    /// Phases of the waves that grow according to the floating-point search.
    fn candidates(&self, method: &Method<D>, f: &DeformationGradient) -> Vec<[f64; 2]> {
        let search = ZoneSearch::new(method, f, self.speed_squared);
        let matrix = dynamical_matrix(method, self.material, f);
        let (Some(search), Ok(matrix)) = (search, matrix) else {
            return Vec::new();
        };
        let summary = search.summary(&matrix);
        let vectors = method.lattice().vectors();
        [summary.softest, summary.lowest, summary.fastest_growing]
            .into_iter()
            .filter(|mode| !mode.is_long_wave)
            .map(|mode| planar(&(vectors.transpose() * mode.wave_vector)))
            .collect()
    }

    fn witness(&self, method: &Method<D>, wave: &GrowingWave) -> Witness<D> {
        let spacing = method.choices().spacing;
        let laplacian = (0..D).fold(Interval::ZERO, |sum, i| {
            use crate::real::Real;
            sum + (Interval::point(wave.phases[i]) * 0.5).sin().square() * 2.0
        });
        let scale = Interval::around(self.scaled(method, 1.0), 4);
        let phases = SVector::from_fn(|i, _| wave.phases[i]);
        Witness {
            wave_vector: wave_vector(method, &phases),
            phases,
            measure: wave.omega_squared / laplacian * scale,
            growth_rate: lower_root(
                wave.growth_squared * spacing * spacing / self.speed_squared
                    * (1.0 - 8.0 * f64::EPSILON),
            ),
        }
    }

    /// Converts `omega^2 / L` to the measure: `c^2 |k|_h^2 = 2 c^2 L / spacing^2`, since all primitive vectors have length `spacing`.
    fn scaled(&self, method: &Method<D>, measure: f64) -> f64 {
        let spacing = method.choices().spacing;
        measure * spacing * spacing / (2.0 * self.speed_squared)
    }

    /// Bounds the discrete gradient of a Lagrangian method over the zone.
    fn gradient(&self, method: &Method<D>) -> Result<Option<Gradient<D>>, MethodError> {
        let identity = DeformationGradient::identity();
        let order = crate::approximation::Order::First;
        method.configuration(&identity, order)?;
        if method.is_naturally_stabilized() {
            return Ok(None);
        }
        let has_volumes = |point: &QuadraturePoint<D>| point.volume > 0.0;
        let all = method.quadrature_points();
        if !all.iter().all(has_volumes) {
            return Ok(None);
        }
        if let Some(phases) = zero_energy_phases(all) {
            return Ok(Some(Gradient::Vanishes(phases)));
        }
        let Ok(points) = points::points(method, &identity) else {
            return Ok(None);
        };
        let waves = waves::gradient_waves(method, &points);
        let finding = cover(
            &waves,
            &Question {
                zone: &[],
                farthest: std::f64::consts::PI,
                growth_squared: 0.0,
                share: 0.9,
                budget: 10 * BUDGET,
            },
            Vec::new,
        );
        Ok(match finding {
            Finding::Bounded(bound) if bound > 0.0 => Some(Gradient::Bounded(bound)),
            _ => None,
        })
    }
}

fn wave_vector<const D: usize>(method: &Method<D>, phases: &SVector<f64, D>) -> SVector<f64, D> {
    method.lattice().reciprocal() * phases / std::f64::consts::TAU
}

/// Half planes of phases that bound the zone, and the largest phase in it.
fn zone<const D: usize>(
    method: &Method<D>,
    f: &DeformationGradient,
) -> (Vec<([f64; 2], f64)>, f64) {
    if method.is_periodic() {
        return (Vec::new(), std::f64::consts::PI);
    }
    let home = method.home_map(f);
    let Some(lattice) = method.lattice().mapped(&home) else {
        return (Vec::new(), f64::INFINITY);
    };
    let zone = BrillouinZone::new(lattice);
    // The zone is bounded by k.G <= |G|^2 / 2 with k = sum_i theta_i b_i / (2 pi).
    let half_plane = |g: &SVector<f64, D>| {
        let normal = planar(&(lattice.reciprocal().transpose() * g));
        (normal, std::f64::consts::PI * g.norm_squared())
    };
    let farthest = zone
        .corners()
        .iter()
        .map(|corner| (lattice.vectors().transpose() * corner).amax())
        .fold(0.0, f64::max);
    let half_planes = zone.bounding_vectors().iter().map(half_plane).collect();
    (half_planes, farthest * (1.0 + 1e-6))
}

/// Phases `pi m` of a wave whose gradient vanishes at every quadrature point. At a point that is an inversion center, with all phases relative to it
/// equal to 0 or pi, the gradients of mirrored neighbors cancel.
fn zero_energy_phases<const D: usize>(points: &[QuadraturePoint<D>]) -> Option<SVector<f64, D>> {
    let is_integer = |x: f64| (x - x.round()).abs() <= 1e-14;
    let are_centers = points
        .iter()
        .all(|point| point.place.iter().all(|&x| is_integer(2.0 * x)));
    let candidates = (1..2_usize.pow(D as u32))
        .map(|bits| SVector::<f64, D>::from_fn(|i, _| ((bits >> i) & 1) as f64));
    let mut silent = candidates
        .filter(|m| are_centers && points.iter().all(|point| is_integer(m.dot(&point.place))));
    silent.next().map(|m| m * std::f64::consts::PI)
}

fn planar<const D: usize>(v: &SVector<f64, D>) -> [f64; 2] {
    [0, 1].each(|i| if i < D { v[i] } else { 0.0 })
}

/// Lower bound of a square root.
fn lower_root(x: f64) -> f64 {
    x.max(0.0).sqrt().next_down().max(0.0)
}
