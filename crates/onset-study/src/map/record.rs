//! What is known about a state of a map.

use onset::bloch::Stability;
use onset::verdict::Verdict;

/// What a state is, in words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Finding {
    /// To whom the first instability belongs; `None` where the method cannot be evaluated, because its support holds too
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

/// What has been proved about a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Certainty {
    /// No proof was asked for.
    NotAsked,
    /// No mode grows: a proof over the whole zone.
    ProvedStable,
    /// A mode grows: a proof by that mode.
    ProvedUnstable,
    /// Neither.
    Undecided,
}

impl Certainty {
    /// All of them, in the order of their flags.
    pub const ALL: [Self; 4] = [
        Self::NotAsked,
        Self::ProvedStable,
        Self::ProvedUnstable,
        Self::Undecided,
    ];

    /// The word used in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::NotAsked => "not-asked",
            Self::ProvedStable => "proved-stable",
            Self::ProvedUnstable => "proved-unstable",
            Self::Undecided => "undecided",
        }
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
    pub certainty: Certainty,
    /// The proved bound of the scaled minimum: from below where stable, from above where unstable.
    pub proved_bound: f64,
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
        certainty: Certainty::NotAsked,
        proved_bound: f64::NAN,
    };
}

/// What a map says about a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// What it is.
    pub finding: Finding,
    /// What was computed; `None` where the finding follows from the surroundings.
    pub record: Option<Record>,
}

impl From<Record> for Outcome {
    fn from(record: Record) -> Self {
        Self {
            finding: record.finding,
            record: Some(record),
        }
    }
}
