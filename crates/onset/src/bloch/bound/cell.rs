//! Boxes of wave vectors, which together are half of the zone.

use super::jet::{FILLED, derivatives, products};
use super::phase;
use crate::algebra::{Complex, array_of};
use nalgebra::{SMatrix, SVector};

/// Components, over the reciprocal vectors, up to which waves are long: there the scaled measure is a quotient of small numbers. In
/// cones less is known of what polynomials leave out, but the rest of the zone begins with more boxes where they are narrow.
const LONG: [f64; 2] = [0.125, 0.25];
/// Boxes to begin with, over those that can be looked at, at most.
const BEGINNING: f64 = 0.05;

/// Which coordinates a box has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Chart {
    /// `(t, s)` of `k = t (b_a + sum_j s_j b_j)`: a cone of long waves around the reciprocal vector `b_a`.
    Cone(usize),
    /// `x` of `k = sum_i x_i b_i`.
    Zone,
}

/// Middle and half sides of a box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell<const D: usize> {
    pub(super) chart: Chart,
    pub(super) middle: [f64; D],
    pub(super) half: [f64; D],
}

impl<const D: usize> Cell<D> {
    /// Half of the zone, where so many boxes can be looked at; the other half has the same spectrum. Long waves lie in cones where that
    /// is asked for.
    pub(super) fn half_zone(has_cones: bool, most: usize) -> Vec<Self> {
        let is_affordable = 0.5 / LONG[0].powi(D as i32) < BEGINNING * most as f64;
        let long = LONG[usize::from(!(has_cones && is_affordable))];
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

    /// The limit of long waves along a direction, given by its components over the reciprocal vectors.
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

    /// A wave vector, given by its components over the reciprocal vectors.
    pub(super) fn point(components: &SVector<f64, D>) -> Self {
        Self {
            chart: Chart::Zone,
            middle: (*components).into(),
            half: [0.0; D],
        }
    }

    /// Whether it reaches the limit of long waves.
    pub(super) fn has_limit(&self) -> bool {
        self.chart != Chart::Zone && self.middle[0] <= self.half[0]
    }

    /// The wave vector in the middle.
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

    /// `p` of a vector in the middle of a cone, its slopes by the variables beside the first (one stands for the first), and how much
    /// it changes.
    fn across(&self, cone: usize, along: &[f64; D]) -> (f64, [f64; D], f64) {
        let (mut p, mut rates, mut spread) = (along[cone], [1.0; D], 0.0);
        for (variable, n) in Self::others(cone) {
            p += self.middle[variable] * along[n];
            rates[variable] = along[n];
            spread += self.half[variable] * along[n].abs();
        }
        (p, rates, spread)
    }

    /// In a cone the derivatives of `f_m(t, p)` of a vector.
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

    /// A bound of what a polynomial of these leaves out, from the fifth order on, and what the second derivatives by each variable may do.
    pub(super) fn cone_rest(&self, cone: usize, m: usize, along: &[f64; D]) -> (f64, [f64; D]) {
        let (p, rates, spread) = self.across(cone, along);
        let half = &self.half;
        let (most_t, most_p) = (self.middle[0] + half[0], p.abs() + spread);
        let [by_t, by_p] = phase::bends(m, most_t, most_p);
        let mut bends = array_of(|a| 0.5 * by_p * (rates[a] * half[a]).powi(2));
        bends[0] = 0.5 * by_t * half[0] * half[0];
        (phase::beyond(m, [most_t, half[0]], [most_p, spread]), bends)
    }

    /// The reciprocal vectors beside that of a cone, by the number of their variable.
    pub(super) fn others(cone: usize) -> impl Iterator<Item = (usize, usize)> {
        (0..D)
            .filter(move |n| *n != cone)
            .enumerate()
            .map(|(v, n)| (v + 1, n))
    }
}
