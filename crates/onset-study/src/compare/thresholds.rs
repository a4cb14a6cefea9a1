//! The limits by which methods are recommended and coefficients tuned.

use serde::Serialize;

/// Limits of what counts as wrong.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Thresholds {
    /// The frequency of a wave over that of the material's slowest wave, below which the wave is too weak.
    pub weak: f64,
    /// Share of the window of states on which verdicts may be wrong.
    pub wrong: f64,
    /// Relative error of the stiffness of long waves.
    pub long_waves: f64,
    /// Share of the material's strain at onset by which the method's onset may come later.
    pub later: f64,
    /// Wavelength at which frequencies are compared, in particle spacings.
    pub wavelength: f64,
}

impl Default for Thresholds {
    fn default() -> Self {
        Self {
            weak: 0.1,
            wrong: 0.005,
            long_waves: 0.05,
            later: 0.02,
            wavelength: 8.0,
        }
    }
}

/// A limit that can be varied: its name as an option, and where it stands.
type Limit = (&'static str, fn(&mut Thresholds) -> &mut f64);

const WEAK: Limit = ("weak", |limits| &mut limits.weak);
const WRONG: Limit = ("wrong", |limits| &mut limits.wrong);
const LONG_WAVES: Limit = ("long-waves", |limits| &mut limits.long_waves);
const LATER: Limit = ("later", |limits| &mut limits.later);

/// The limits that recommendations depend on.
pub(super) const OF_RECOMMENDATIONS: [Limit; 3] = [WEAK, WRONG, LONG_WAVES];
/// The limits that tuning depends on.
pub(crate) const OF_TUNING: [Limit; 3] = [WEAK, WRONG, LATER];

impl Thresholds {
    /// The same with each of some limits halved, and doubled: its name, its value then, and all limits then.
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

/// A share in percent, as short as it can be told.
pub(crate) fn percent(share: f64) -> String {
    format!("{} %", crate::number::told(100.0 * share))
}
