//! What is known about a state of a map.

use onset::bloch::Stability;
use onset::certificate::{self, Certificate, Reason};
use onset::verdict::Verdict;

/// What a state is, in words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Finding {
    /// The origin of the first instability; `None` where the method cannot be evaluated, because its support holds too
    /// few or too many particles.
    pub verdict: Option<Verdict>,
    /// How perturbations of the particles develop.
    pub stability: Option<Stability>,
}

impl Finding {
    /// Where the method cannot be evaluated.
    pub const UNDEFINED: Self = Self {
        verdict: None,
        stability: None,
    };
}

/// What has been proved about material or particles at a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Certainty {
    /// No proof was asked for, or there is nothing to prove because the method cannot be evaluated.
    NotAsked,
    /// No wave grows: a proof over the whole zone, or over all directions.
    ProvedStable,
    /// A wave grows: a proof by that wave.
    ProvedUnstable,
    /// All `omega^2 >= 0`, and a wave of finite length is a zero-energy mode.
    ProvedZeroEnergy,
    /// None of them.
    Undecided,
}

impl Certainty {
    /// All of them, in the order of their flags.
    pub const ALL: [Self; 5] = [
        Self::NotAsked,
        Self::ProvedStable,
        Self::ProvedUnstable,
        Self::ProvedZeroEnergy,
        Self::Undecided,
    ];

    /// The word used in files and on the command line.
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

/// What has been proved about a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proof {
    /// Strong ellipticity.
    pub material: Certainty,
    /// The bound of the acoustic eigenvalue over `rho0 c^2`: from below where elliptic, from above where not.
    pub material_bound: f64,
    /// Waves of the particles.
    pub particles: Certainty,
    /// The bound of the scaled minimum: from below where stable, from above where unstable.
    pub bound: f64,
    /// Why the particles are undecided.
    pub reason: Option<Reason>,
    /// Whether the verdict or the stability is another than that of the search.
    pub corrects: bool,
}

impl Proof {
    /// Nothing is proved.
    pub const NONE: Self = Self {
        material: Certainty::NotAsked,
        material_bound: f64::NAN,
        particles: Certainty::NotAsked,
        bound: f64::NAN,
        reason: None,
        corrects: false,
    };

    /// Of a certificate.
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

/// All that is computed at a state. Numbers that do not exist there are NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Record {
    /// What it is.
    pub finding: Finding,
    /// The smallest acoustic eigenvalue of the continuum; stress.
    pub acoustic_minimum: f64,
    /// The reference direction of that wave, a unit vector.
    pub acoustic_direction: [f64; 3],
    /// `min Re omega^2 / (c^2 |k|_h^2)` over the zone and the long-wave limit.
    pub scaled_minimum: f64,
    /// The reference wave vector of that minimum, 1/length; in the limit of long waves its unit direction.
    pub wave_vector: [f64; 3],
    /// Whether that minimum is the limit of long waves; `None` where there is no minimum.
    pub is_long_wave: Option<bool>,
    /// The smallest `Re omega^2` over the zone; 1/time^2.
    pub lowest_omega_squared: f64,
    /// The growth rate of the fastest growing mode, zero when stable; 1/time.
    pub growth_rate: f64,
    /// The critical time step of central differences; time.
    pub critical_time_step: f64,
    /// Signed measures, smooth almost everywhere, whose zeros are the boundaries of the verdicts; without dimension.
    pub measures: [f64; 3],
    /// What has been proved.
    pub proof: Proof,
}

impl Record {
    /// Nothing but that the method cannot be evaluated.
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
    };
}

/// What a map says about the states of a tile, last dimension running fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcomes {
    /// What they are.
    pub findings: Vec<Finding>,
    /// What was computed, with the numbers of the states, increasing; the finding at others follows from the surroundings.
    pub computed: Vec<(usize, Record)>,
}

impl From<Vec<Record>> for Outcomes {
    /// All of them were computed.
    fn from(records: Vec<Record>) -> Self {
        Self {
            findings: records.iter().map(|record| record.finding).collect(),
            computed: records.into_iter().enumerate().collect(),
        }
    }
}
