//! Boxes of wave vectors, which together are half of the zone.

use super::jet::{bend, slope};
use super::phase::{derivative_bounds, phases};
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

/// A function of `t` and `p` on a box of a cone: value, slopes and second derivatives, a bound of what is left, and what the second
/// derivatives by each variable may do.
pub(super) type ConeJet<const D: usize> = ([Complex; 10], f64, [f64; D]);

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
        for (variable, n) in others::<D>(cone) {
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
                for (variable, n) in others::<D>(cone) {
                    direction += reciprocal.column(n) * self.middle[variable];
                }
                direction * self.middle[0]
            }
        }
    }

    /// In a cone `f_m(t, p)` of a vector for three `m`, as far as they are wanted.
    pub(super) fn cone_jets(
        &self,
        cone: usize,
        along: &[f64; D],
        orders: [bool; 3],
    ) -> [ConeJet<D>; 3] {
        let t = self.middle[0];
        let (mut p, mut spread) = (along[cone], 0.0);
        let mut rates = [0.0; D];
        for (variable, n) in others::<D>(cone) {
            p += self.middle[variable] * along[n];
            rates[variable] = along[n];
            spread += self.half[variable] * along[n].abs();
        }
        let functions = phases(t, p);
        let (most_t, most_p) = (t + self.half[0], p.abs() + spread);
        array_of(|m| {
            let (mut jet, mut bends) = ([Complex::default(); 10], [0.0; D]);
            if !orders[m] {
                return (jet, 0.0, bends);
            }
            let f = &functions[m];
            jet[0] = f.value;
            jet[slope(0)] = f.slope[0];
            jet[bend::<D>(0, 0)] = f.bend[0];
            for a in 1..D {
                jet[slope(a)] = f.slope[1] * rates[a];
                jet[bend::<D>(a, 0)] = f.bend[1] * rates[a];
                for b in 1..=a {
                    jet[bend::<D>(a, b)] = f.bend[2] * (rates[a] * rates[b]);
                }
            }
            let (second, third) = derivative_bounds(m, most_t, most_p);
            let h = self.half[0];
            bends[0] = 0.5 * second[0] * h * h;
            for a in 1..D {
                bends[a] = 0.5 * second[1] * (rates[a] * self.half[a]).powi(2);
            }
            let rest = (third[0] * h.powi(3)
                + 3.0 * third[1] * h * h * spread
                + 3.0 * third[2] * h * spread * spread
                + third[3] * spread.powi(3))
                / 6.0;
            (jet, rest, bends)
        })
    }
}

/// The reciprocal vectors beside that of a cone, by the number of their variable.
fn others<const D: usize>(cone: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..D)
        .filter(move |n| *n != cone)
        .enumerate()
        .map(|(v, n)| (v + 1, n))
}
