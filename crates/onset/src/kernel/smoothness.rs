//! Numbers of continuous derivatives of a kernel over space, and the positions of the jumps.

use super::Kernel;
use crate::algebra::{Each, array_of};
use crate::real::Jet;

/// Number of continuous derivatives over space at the positions where a radial profile can break. `None` means all derivatives, or for a formula at
/// least four.
///
/// Waves with Lagrangian kernels need one continuous derivative; the exact linearization of Eulerian kernels needs two. With fewer continuous
/// derivatives at the rim the dynamical matrix jumps when a neighbor enters or leaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Smoothness {
    /// Number at the origin, where odd derivatives of the profile must vanish; `None` for all.
    pub origin: Option<u32>,
    /// Number at the joints between the pieces of the profile; `None` for all.
    pub inside: Option<u32>,
    /// Number at the rim of the support; `None` for all.
    pub rim: Option<u32>,
}

/// Distance over which the derivatives on both sides of a position are compared; support radii.
const JUMP_DISTANCE: f64 = 1e-9;
/// Smallest change over this distance that counts as a jump, relative to the size of the derivative.
const JUMP: f64 = 1e-4;
/// Number of cells that are searched for jumps.
const CELLS: u32 = 1024;

impl Smoothness {
    /// Smallest number of continuous derivatives at any position; `None` for all.
    pub fn least(self) -> Option<u32> {
        [self.origin, self.inside, self.rim]
            .into_iter()
            .flatten()
            .min()
    }

    /// Smoothness from the derivatives at origin and rim, and the breaks with the order of the derivative that jumps.
    pub(super) fn measured(origin: [f64; 5], breaks: &[(f64, u32)], rim: [f64; 5]) -> Self {
        let scale = |orders: &[f64; 5]| 1e-7 * orders.iter().fold(1.0, |a: f64, b| a.max(b.abs()));
        let (odd, end) = (scale(&origin), scale(&rim));
        let is_more = |x: f64, limit: f64| !x.is_finite() || x.abs() > limit;
        let breaks_at = |n: &usize| is_more(origin[*n], odd);
        let ends_at = |n: &usize| is_more(rim[*n], end);
        Self {
            origin: [1, 3].into_iter().find(breaks_at).map(|n| n as u32 - 1),
            inside: breaks
                .iter()
                .map(|(_, order)| order.saturating_sub(1))
                .min(),
            rim: (0..5).find(ends_at).map(|n| (n as u32).saturating_sub(1)),
        }
    }
}

/// Profile and its first four derivatives.
pub(super) fn orders_at(profile: impl Fn(Jet<1, Jet<1>>) -> Jet<1, Jet<1>>, q: f64) -> [f64; 5] {
    let [inner] = Jet::variables([q]);
    let [outer] = Jet::variables([inner]);
    let jet = profile(outer);
    let second = jet.hessian[0][0];
    [
        jet.value.value,
        jet.gradient[0].value,
        second.value,
        second.gradient[0],
        second.hessian[0][0],
    ]
}

/// Returns the distances within the support at which a derivative up to the fourth jumps, with the lowest order of such a derivative.
///
/// # Errors
/// The distance at which the profile itself or its slope jumps.
pub(super) fn jumps(
    profile: impl Fn(Jet<1, Jet<1>>) -> Jet<1, Jet<1>>,
) -> Result<Vec<(f64, u32)>, f64> {
    let at = |q: f64| orders_at(&profile, q);
    let mut found = Vec::new();
    let samples: Vec<[f64; 5]> = (0..=CELLS)
        .map(|n| at(f64::from(n) / f64::from(CELLS)))
        .collect();
    let size = |order: usize| {
        samples
            .iter()
            .fold(1.0, |size: f64, sample| size.max(sample[order].abs()))
    };
    let sizes: [f64; 5] = array_of(size);
    for cell in 0..CELLS {
        let [low, high] = [cell, cell + 1].each(|n| f64::from(n) / f64::from(CELLS));
        let order = (0..5)
            .find_map(|order| Some((order, jump(|q| at(q)[order], low, high, sizes[order])?)));
        match order {
            Some((0 | 1, q)) => return Err(q),
            Some((order, q)) => found.push((q, order as u32)),
            None => {}
        }
    }
    Ok(found)
}

/// Position within an interval at which a function jumps, by bisection toward the larger change.
fn jump(function: impl Fn(f64) -> f64, mut low: f64, mut high: f64, size: f64) -> Option<f64> {
    let (mut below, mut above) = (function(low), function(high));
    while high - low > JUMP_DISTANCE {
        if (above - below).abs() <= JUMP * size {
            return None;
        }
        let middle = 0.5 * (low + high);
        let value = function(middle);
        if (value - below).abs() > (above - value).abs() {
            (high, above) = (middle, value);
        } else {
            (low, below) = (middle, value);
        }
    }
    ((above - below).abs() > JUMP * size).then_some(0.5 * (low + high))
}

impl Kernel {
    /// Returns the numbers of continuous derivatives over space in `D` dimensions.
    ///
    /// ```
    /// use onset::kernel::Kernel;
    /// assert_eq!(Kernel::WendlandC4.smoothness::<3>().least(), Some(4));
    /// assert_eq!(Kernel::Hyperbolic.smoothness::<3>().least(), Some(0));
    /// ```
    pub fn smoothness<const D: usize>(self) -> Smoothness {
        let of = |origin, inside, rim| Smoothness {
            origin,
            inside,
            rim,
        };
        // The kernel is a power (1 - q)^n at the rim. Wendland's functions have one more factor in three dimensions than in one.
        let extra = u32::from(D > 1);
        match self {
            Self::QuarticSpline => of(Some(2), None, Some(2)),
            Self::CubicSpline => of(Some(2), Some(2), Some(2)),
            Self::QuarticBSpline => of(None, Some(3), Some(3)),
            Self::QuinticSpline => of(Some(4), Some(4), Some(4)),
            Self::WendlandC2 => of(Some(2), None, Some(2 + extra)),
            Self::WendlandC4 => of(Some(4), None, Some(4 + extra)),
            Self::WendlandC6 => of(Some(6), None, Some(6 + extra)),
            Self::Gaussian | Self::LaguerreGauss => of(None, None, Some(2)),
            Self::Hyperbolic => of(Some(0), Some(2), Some(2)),
            Self::Formula(formula) => formula.smoothness(),
        }
    }
}
