//! Limits for recommending methods and tuning coefficients.

use serde::Serialize;

/// Limits between acceptable and wrong results.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Thresholds {
    /// Smallest acceptable ratio of a wave's frequency to the frequency of the slowest material wave; slower waves are weakly controlled.
    pub weak: f64,
    /// Largest acceptable fraction of states in the window with wrong verdicts.
    pub wrong: f64,
    /// Largest acceptable relative error of the long-wavelength moduli.
    pub long_waves: f64,
    /// Largest acceptable delay of a method's onset, as a fraction of the material's strain at onset.
    pub later: f64,
    /// Wavelength at which frequencies are compared, in particle spacings.
    pub wavelength: f64,
}

impl Default for Thresholds {
    fn default() -> Self {
        Self {
            weak: onset::verdict::WEAK_WAVE_RATIO,
            wrong: 0.005,
            long_waves: 0.05,
            later: 0.02,
            wavelength: 8.0,
        }
    }
}

/// Limit that can be varied: its name as an option, and access to its value.
type Limit = (&'static str, fn(&mut Thresholds) -> &mut f64);

const WEAK_LIMIT: Limit = ("weak", |limits| &mut limits.weak);
const WRONG_LIMIT: Limit = ("wrong", |limits| &mut limits.wrong);
const LONG_WAVES_LIMIT: Limit = ("long-waves", |limits| &mut limits.long_waves);
const LATER_LIMIT: Limit = ("later", |limits| &mut limits.later);

/// Limits that affect recommendations.
pub(super) const RECOMMENDATION_LIMITS: [Limit; 3] = [WEAK_LIMIT, WRONG_LIMIT, LONG_WAVES_LIMIT];
/// Limits that affect tuning.
pub(crate) const TUNING_LIMITS: [Limit; 3] = [WEAK_LIMIT, WRONG_LIMIT, LATER_LIMIT];

impl Thresholds {
    /// Variants with one limit halved or doubled: its name, its new value, and all limits.
    pub(crate) fn varied(&self, limits: &[Limit]) -> Vec<(&'static str, f64, Self)> {
        let with = |(name, limit): &Limit, factor: f64| {
            let mut varied = *self;
            *limit(&mut varied) *= factor;
            (*name, *limit(&mut varied), varied)
        };
        limits
            .iter()
            .flat_map(|limit| [with(limit, 0.5), with(limit, 2.0)])
            .collect()
    }
}

/// Formats a fraction in percent, with the shortest exact digits.
pub(crate) fn percent(share: f64) -> String {
    format!("{} %", crate::number::told(100.0 * share))
}
