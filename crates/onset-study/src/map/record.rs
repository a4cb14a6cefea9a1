//! Results at a state of a map.

use onset::bloch::Stability;
use onset::certificate::{self, Certificate, Reason};
use onset::verdict::{Mechanism, Verdict};

/// Verdict and stability of a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Finding {
    /// Origin of the first instability; `None` if the support holds too few or too many particles for the method.
    pub verdict: Option<Verdict>,
    /// Stability of the particles: stable, flutter or divergence; `None` if the method cannot be evaluated.
    pub stability: Option<Stability>,
}

impl Finding {
    /// Finding at a state where the method cannot be evaluated.
    pub const UNDEFINED: Self = Self {
        verdict: None,
        stability: None,
    };
}

/// Proof status of material or particles at a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Certainty {
    /// No proof was requested, or the method cannot be evaluated.
    NotAsked,
    /// No wave grows, proved over the whole zone or over all directions.
    ProvedStable,
    /// A wave grows, proved by this wave.
    ProvedUnstable,
    /// All `omega^2 >= 0`, and a wave of finite length is a zero-energy mode.
    ProvedZeroEnergy,
    /// Neither stability nor instability could be proved.
    Undecided,
}

impl Certainty {
    /// All certainties, in the order of their flags.
    pub const ALL: [Self; 5] = [
        Self::NotAsked,
        Self::ProvedStable,
        Self::ProvedUnstable,
        Self::ProvedZeroEnergy,
        Self::Undecided,
    ];

    /// Name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::NotAsked => "not-asked",
            Self::ProvedStable => "proved-stable",
            Self::ProvedUnstable => "proved-unstable",
            Self::ProvedZeroEnergy => "proved-zero-energy",
            Self::Undecided => "undecided",
        }
    }
}

impl From<&certificate::Certainty<3>> for Certainty {
    fn from(proved: &certificate::Certainty<3>) -> Self {
        match proved {
            certificate::Certainty::Stable { .. } => Self::ProvedStable,
            certificate::Certainty::Unstable { .. } => Self::ProvedUnstable,
            certificate::Certainty::ZeroEnergy { .. } => Self::ProvedZeroEnergy,
            certificate::Certainty::Undecided { .. } => Self::Undecided,
        }
    }
}

/// Proved facts about a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proof {
    /// Proof status of the strong ellipticity of the material.
    pub material: Certainty,
    /// Bound on the acoustic eigenvalue, divided by `rho0 c^2`: a lower bound if elliptic, an upper bound otherwise.
    pub material_bound: f64,
    /// Certainty for the waves of the particles.
    pub particles: Certainty,
    /// Bound on the scaled minimum: a lower bound if stable, an upper bound if unstable.
    pub bound: f64,
    /// Reason why the particles are undecided; `None` if they are not undecided.
    pub reason: Option<Reason>,
    /// Whether the proof contradicts the verdict or the stability found by the search.
    pub corrects: bool,
}

impl Proof {
    /// Proof of a state without certificate.
    pub const NONE: Self = Self {
        material: Certainty::NotAsked,
        material_bound: f64::NAN,
        particles: Certainty::NotAsked,
        bound: f64::NAN,
        reason: None,
        corrects: false,
    };

    /// Proof from a certificate.
    pub(super) fn of(certificate: &Certificate<3>, corrects: bool) -> Self {
        Self {
            material: (&certificate.material).into(),
            material_bound: bound(&certificate.material),
            particles: (&certificate.discretization).into(),
            bound: bound(&certificate.discretization),
            reason: match certificate.discretization {
                certificate::Certainty::Undecided { reason, .. } => Some(reason),
                _ => None,
            },
            corrects,
        }
    }
}

fn bound(proved: &certificate::Certainty<3>) -> f64 {
    match proved {
        certificate::Certainty::Stable { bound } => *bound,
        certificate::Certainty::Unstable { witness } => witness.measure.high,
        certificate::Certainty::ZeroEnergy { .. } => 0.0,
        certificate::Certainty::Undecided { .. } => f64::NAN,
    }
}

/// All results at a state. Undefined numbers are NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Record {
    /// Verdict and stability of the state.
    pub finding: Finding,
    /// Smallest acoustic eigenvalue of the continuum; stress.
    pub acoustic_minimum: f64,
    /// Reference direction of the wave with the smallest acoustic eigenvalue, a unit vector.
    pub acoustic_direction: [f64; 3],
    /// Scaled minimum `min Re omega^2 / (c^2 |k|_h^2)` over the zone and the long-wave limit.
    pub scaled_minimum: f64,
    /// Reference wave vector of the scaled minimum, 1/length; in the long-wave limit its unit direction.
    pub wave_vector: [f64; 3],
    /// Whether the scaled minimum is attained in the long-wave limit; `None` if it does not exist.
    pub is_long_wave: Option<bool>,
    /// Smallest `Re omega^2` over the zone; 1/time^2.
    pub lowest_omega_squared: f64,
    /// Growth rate of the fastest growing mode, zero if stable; 1/time.
    pub growth_rate: f64,
    /// Critical time step of central differences; time.
    pub critical_time_step: f64,
    /// Signed dimensionless measures whose zeros are the boundaries between verdicts: the smallest acoustic eigenvalue divided by the reference stiffness, the
    /// scaled minimum, and its long-wave limit. NaN if not evaluated.
    pub measures: [f64; 3],
    /// Proved facts about the state.
    pub proof: Proof,
    /// Mechanism of a numerical instability; `None` in maps, which do not store it.
    pub mechanism: Option<Mechanism>,
}

impl Record {
    /// Record of a state where the method cannot be evaluated.
    pub const UNDEFINED: Self = Self {
        finding: Finding::UNDEFINED,
        acoustic_minimum: f64::NAN,
        acoustic_direction: [f64::NAN; 3],
        scaled_minimum: f64::NAN,
        wave_vector: [f64::NAN; 3],
        is_long_wave: None,
        lowest_omega_squared: f64::NAN,
        growth_rate: f64::NAN,
        critical_time_step: f64::NAN,
        measures: [f64::NAN; 3],
        proof: Proof::NONE,
        mechanism: None,
    };
}

/// Results for the states of a tile, the last dimension varying fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcomes {
    /// Verdict and stability of each state.
    pub findings: Vec<Finding>,
    /// Records of the computed states, by increasing number; findings at other states are filled in from their surroundings.
    pub computed: Vec<(usize, Record)>,
}

impl From<Vec<Record>> for Outcomes {
    /// Outcomes of a tile whose states are all computed.
    fn from(records: Vec<Record>) -> Self {
        Self {
            findings: records.iter().map(|record| record.finding).collect(),
            computed: records.into_iter().enumerate().collect(),
        }
    }
}
