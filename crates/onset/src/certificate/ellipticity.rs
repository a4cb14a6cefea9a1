//! Strong ellipticity over all directions of a line or plane.

use super::patch::{MatrixPatch, Patch, is_positive, smallest};
use crate::algebra::{Each, array_of};
use crate::cancel::checkpoint;
use crate::real::{Interval, Real};

/// Components `A_iJkL` of a tangent within the dimensions of the lattice, by entries `ik` in the order `11, 12, 21, 22` and by powers of `s` in the
/// direction `N = (1, s)`.
pub(super) struct Acoustic {
    dimension: usize,
    powers: [[Interval; 4]; 3],
}

/// Proved bounds of the smallest acoustic eigenvalue.
#[derive(Clone, Copy, Debug)]
pub(super) enum Proved {
    /// Lower bound of the eigenvalue in every direction.
    Bounded(f64),
    /// Direction in which the eigenvalue lies within these negative bounds.
    Refuted {
        direction: [f64; 2],
        eigenvalue: Interval,
    },
    /// Undecided; the smallest sampled eigenvalue.
    Open { eigenvalue: f64 },
}

impl Acoustic {
    pub(super) fn new<const D: usize>(tangent: &[[[[Interval; 3]; 3]; 3]; 3]) -> Self {
        let power = |m: usize| -> [Interval; 4] {
            array_of(|e| {
                let (i, k) = (e / 2, e % 2);
                if D == 1 {
                    // In one dimension the single entry is stored in both entries of the diagonal.
                    let is_entry = m == 0 && i == k;
                    return if is_entry {
                        tangent[0][0][0][0]
                    } else {
                        Interval::ZERO
                    };
                }
                match m {
                    0 => tangent[i][0][k][0],
                    1 => tangent[i][0][k][1] + tangent[i][1][k][0],
                    _ => tangent[i][1][k][1],
                }
            })
        };
        Self {
            dimension: D,
            powers: [power(0), power(1), power(2)],
        }
    }

    /// Enclosure of `Q - shift |N|^2` on `|s - center| <= half`.
    fn patch(&self, chart: usize, center: f64, half: f64, shift: f64) -> MatrixPatch {
        array_of(|e| {
            let is_diagonal = e == 0 || e == 3;
            let (mut middle, mut radius) = ([0.0; 3], 0.0);
            for m in 0..3 {
                let entry = self.powers[if chart == 0 { m } else { 2 - m }][e];
                let is_axis = m == 0 || (m == 2 && self.dimension == 2);
                let own = if is_axis && is_diagonal { shift } else { 0.0 };
                middle[m] = entry.midpoint() - own;
                radius += entry.radius() + 8.0 * f64::EPSILON * (entry.magnitude() + own.abs());
            }
            Patch {
                value: middle[0] + center * (middle[1] + center * middle[2]),
                slope: [half * (middle[1] + 2.0 * center * middle[2]), 0.0],
                curvature: [half * half * middle[2], 0.0, 0.0],
                rest: radius,
            }
        })
    }

    /// Enclosure of the smallest eigenvalue in the direction `N`.
    fn eigenvalue(&self, direction: [f64; 2]) -> Interval {
        let [x, y] = direction.map(Interval::point);
        let squared = x.square() + y.square();
        let entry = |e: usize| {
            let [a, b, c] = [0, 1, 2].each(|m| self.powers[m][e]);
            (a * x.square() + b * x * y + c * y.square()) / squared
        };
        let (half, coupling) = ((entry(0) - entry(3)) * 0.5, entry(1) * entry(2));
        let discriminant = half.square() + coupling;
        // The tangent derives from an energy, so the acoustic tensor is symmetric.
        let discriminant = Interval::new(discriminant.low.max(0.0), discriminant.high.max(0.0));
        (entry(0) + entry(3)) * 0.5 - discriminant.sqrt()
    }

    /// Proves or refutes that the smallest eigenvalue is positive. `hint` is a direction in which it may be negative.
    pub(super) fn ellipticity(&self, hint: [f64; 2], budget: usize) -> Proved {
        let all = self.powers.iter().flatten();
        if !all.clone().all(|entry| entry.is_finite()) {
            return Proved::Open {
                eigenvalue: f64::NAN,
            };
        }
        let refuted = |direction: [f64; 2]| {
            let eigenvalue = self.eigenvalue(direction);
            (eigenvalue.high < 0.0).then_some(Proved::Refuted {
                direction,
                eigenvalue,
            })
        };
        if let Some(refuted) = refuted(hint) {
            return refuted;
        }
        let mut seen = self.eigenvalue(hint).midpoint();
        for share in [0.999, 0.9, 0.5, 0.0] {
            let target = share * seen.max(0.0);
            let mut regions: Vec<(usize, f64, f64)> = if self.dimension == 1 {
                vec![(0, 0.0, 0.0)]
            } else {
                (0..16)
                    .map(|n| (n / 8, f64::from(n as u32 % 8) * 0.25 - 0.875, 0.125))
                    .collect()
            };
            let mut boxes = 0;
            let mut is_proved = true;
            while let Some((chart, center, half)) = regions.pop() {
                checkpoint();
                let patch = self.patch(chart, center, half, target);
                if is_positive(&patch, None) {
                    continue;
                }
                let direction = if chart == 0 {
                    [1.0, center]
                } else {
                    [center, 1.0]
                };
                let unshifted = self
                    .patch(chart, center, 0.0, 0.0)
                    .each(|patch| patch.value);
                let value = smallest(&unshifted) / (1.0 + center * center);
                seen = seen.min(value);
                if value < 0.0
                    && let Some(refuted) = refuted(direction)
                {
                    return refuted;
                }
                boxes += 1;
                if boxes > budget || self.dimension == 1 || value < target {
                    is_proved = false;
                    break;
                }
                let half = 0.5 * half;
                regions.extend([(chart, center - half, half), (chart, center + half, half)]);
            }
            if is_proved {
                return Proved::Bounded(target);
            }
        }
        Proved::Open { eigenvalue: seen }
    }
}
