//! Boxes of wave vectors that together cover half of the zone.

use super::jet::{FILLED, derivatives, products};
use super::phase;
use crate::algebra::{Complex, array_of};
use nalgebra::{SMatrix, SVector};

/// Side lengths of the region of long waves, in reciprocal vectors, where the scaled measure is a quotient of small numbers.
///
/// In cones the remainders of the polynomials are larger, but narrow cones require more initial boxes in the rest of the zone.
const CONE_LENGTHS: [f64; 2] = [0.125, 0.25];
/// Largest fraction of the box budget that the initial boxes may use.
const INITIAL_BOX_SHARE: f64 = 0.05;

/// Coordinates of a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Chart {
    /// Coordinates `(t, s)` with `k = t (b_a + sum_j s_j b_j)`: a cone of long waves around the reciprocal vector `b_a`.
    Cone(usize),
    /// Coordinates `x` with `k = sum_i x_i b_i`.
    Zone,
}

/// Center and half sides of a box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell<const D: usize> {
    pub(super) chart: Chart,
    pub(super) middle: [f64; D],
    pub(super) half: [f64; D],
}

impl<const D: usize> Cell<D> {
    /// Initial boxes of half of the zone, for a budget of `most` boxes; the other half has the same spectrum. With `has_cones`, long waves lie in
    /// cones.
    pub(super) fn half_zone(has_cones: bool, most: usize) -> Vec<Self> {
        let is_affordable = 0.5 / CONE_LENGTHS[0].powi(D as i32) < INITIAL_BOX_SHARE * most as f64;
        let long = CONE_LENGTHS[usize::from(!(has_cones && is_affordable))];
        let side = |a: usize| if a == 0 { 0.5 } else { 1.0 } / long;
        let counts: [usize; D] = array_of(|a| side(a) as usize);
        let boxes = (0..counts.iter().product()).map(|number: usize| {
            let mut rest = number;
            let middle = array_of(|a| {
                let place = rest % counts[a];
                rest /= counts[a];
                let start = if a == 0 { 0.0 } else { -0.5 };
                start + (place as f64 + 0.5) * long
            });
            Self {
                chart: Chart::Zone,
                middle,
                half: [0.5 * long; D],
            }
        });
        let is_long = |cell: &Self| cell.middle.iter().all(|x| x.abs() < long);
        let cones = (0..D).map(|cone| Self {
            chart: Chart::Cone(cone),
            middle: array_of(|a| if a == 0 { 0.5 * long } else { 0.0 }),
            half: array_of(|a| if a == 0 { 0.5 * long } else { 1.0 }),
        });
        let short = boxes.filter(|cell| !has_cones || !is_long(cell));
        short.chain(cones.filter(|_| has_cones)).collect()
    }

    /// Long-wave limit along a direction, given by its components in reciprocal vectors.
    pub(super) fn limit_along(components: &SVector<f64, D>) -> Self {
        let cone = components.iamax();
        let mut cell = Self {
            chart: Chart::Cone(cone),
            middle: [0.0; D],
            half: [0.0; D],
        };
        for (variable, n) in Self::others(cone) {
            cell.middle[variable] = components[n] / components[cone];
        }
        cell
    }

    /// Wave vector, given by its components in reciprocal vectors.
    pub(super) fn point(components: &SVector<f64, D>) -> Self {
        Self {
            chart: Chart::Zone,
            middle: (*components).into(),
            half: [0.0; D],
        }
    }

    /// Returns true if the box contains a long-wave limit.
    pub(super) fn has_limit(&self) -> bool {
        self.chart != Chart::Zone && self.middle[0] <= self.half[0]
    }

    /// Wave vector at the center.
    pub(super) fn wave_vector(&self, reciprocal: &SMatrix<f64, D, D>) -> SVector<f64, D> {
        match self.chart {
            Chart::Zone => reciprocal * SVector::from(self.middle),
            Chart::Cone(cone) => {
                let mut direction: SVector<f64, D> = reciprocal.column(cone).into();
                for (variable, n) in Self::others(cone) {
                    direction += reciprocal.column(n) * self.middle[variable];
                }
                direction * self.middle[0]
            }
        }
    }

    /// Phase rate `p` of a vector at the center of a cone, its derivatives with respect to the variables after the first (1 for the first), and its
    /// change over the box.
    fn across(&self, cone: usize, along: &[f64; D]) -> (f64, [f64; D], f64) {
        let (mut p, mut rates, mut spread) = (along[cone], [1.0; D], 0.0);
        for (variable, n) in Self::others(cone) {
            p += self.middle[variable] * along[n];
            rates[variable] = along[n];
            spread += self.half[variable] * along[n].abs();
        }
        (p, rates, spread)
    }

    /// Derivatives of `f_m(t, p)` of a vector in a cone.
    #[inline(always)]
    pub(super) fn cone_derivatives(
        &self,
        cone: usize,
        m: usize,
        along: &[f64; D],
    ) -> [Complex; FILLED] {
        let (p, rates, _) = self.across(cone, along);
        let own = phase::derivatives(m, self.middle[0], p);
        let products = products(&rates);
        let mut phases = [Complex::default(); FILLED];
        for (n, kind) in const { derivatives::<D>() }.iter().enumerate() {
            phases[n] = own[kind.by_first][kind.order - kind.by_first] * products[n];
        }
        phases
    }

    /// Bound of the remainder of these derivatives, starting with the fifth order, and the contribution of the second derivatives with respect to
    /// each variable.
    pub(super) fn cone_rest(&self, cone: usize, m: usize, along: &[f64; D]) -> (f64, [f64; D]) {
        let (p, rates, spread) = self.across(cone, along);
        let half = &self.half;
        let (most_t, most_p) = (self.middle[0] + half[0], p.abs() + spread);
        let [by_t, by_p] = phase::bends(m, most_t, most_p);
        let mut bends = array_of(|a| 0.5 * by_p * (rates[a] * half[a]).powi(2));
        bends[0] = 0.5 * by_t * half[0] * half[0];
        (phase::beyond(m, [most_t, half[0]], [most_p, spread]), bends)
    }

    /// Reciprocal vectors other than the axis of a cone, each with the index of its variable.
    pub(super) fn others(cone: usize) -> impl Iterator<Item = (usize, usize)> {
        (0..D)
            .filter(move |n| *n != cone)
            .enumerate()
            .map(|(v, n)| (v + 1, n))
    }
}
