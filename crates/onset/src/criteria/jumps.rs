//! Finite jumps of the deformation gradient that cost less than nothing.

use super::Witness;
use crate::kinematics::DeformationGradient;
use crate::material::{Hyperelastic, Response};
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

/// A jump `a (x) N` of the deformation gradient with its scaled excess of energy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump {
    /// `a`.
    pub amplitude: Vector3<f64>,
    /// `N`, of unit length.
    pub direction: Vector3<f64>,
    /// `2 (W(F + a (x) N) - W(F) - P : (a (x) N)) / |a|^2`; units of stress. In the limit of small jumps `a . Q(N) a / |a|^2`.
    pub excess: f64,
    /// How much of the excess can be rounding.
    pub rounding: f64,
    /// Whether it leads to the edge of the reach; it is then not the lowest of its valley, and not as accurate.
    pub at_edge: bool,
}

impl Jump {
    /// Whether it gains energy, beyond what rounding can pretend.
    pub fn gains(&self) -> bool {
        self.excess < -self.rounding
    }

    /// The jump as a witness.
    pub fn witness(&self) -> Witness {
        Witness::Jump {
            amplitude: self.amplitude.into(),
            direction: self.direction.into(),
            at_edge: self.at_edge,
        }
    }
}

/// Searches for finite jumps that gain energy.
///
/// Starts: thirteen normals with jumps of several sizes along the axes, both ways; the lowest of them are followed downhill (quasi-Newton,
/// `BFGS`) in amplitude and normal together. Jumps lead to states with principal stretches within the reach only, since many laws lack
/// growth at enormous strains. A jump that gains energy disproves rank-one convexity (up to rounding); none found is no proof of it.
///
/// ```
/// use onset::kinematics::DeformationGradient;
/// use onset::material::{Hyperelastic, BlatzKo};
/// use onset::criteria::JumpSearch;
/// let law = BlatzKo::default();
/// let search = JumpSearch::new(&law, (0.1, 10.0));
/// // In uniaxial strain 3.5 waves travel still (they do up to 3.732), but a large jump gains energy.
/// let f = DeformationGradient::from_stretches([3.5, 1.0, 1.0])?;
/// let jump = search.lowest(&law.response(&f)?).ok_or("no jump")?;
/// assert!(jump.excess < 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct JumpSearch<'a> {
    material: &'a dyn Hyperelastic,
    reach: (f64, f64),
}

/// Smaller jumps count as infinitesimal: their excess is that of a wave.
const SMALLEST: f64 = 1e-3;
/// How many of the lowest starts are followed.
const FOLLOWED: usize = 8;
/// Steps of a descent.
const STEPS: usize = 60;

impl<'a> JumpSearch<'a> {
    /// A search in a law among jumps to states with principal stretches within `reach`.
    pub fn new(material: &'a dyn Hyperelastic, reach: (f64, f64)) -> Self {
        Self { material, reach }
    }

    /// The jump with the lowest scaled excess that was found; `None` where every descent ends in an infinitesimal one.
    pub fn lowest(&self, state: &Response) -> Option<Jump> {
        let mut starts: Vec<(f64, Vector6<f64>)> = starts()
            .filter_map(|start| Some((self.excess(state, &start)?.0, start)))
            .collect();
        starts.sort_by(|a, b| a.0.total_cmp(&b.0));
        starts
            .iter()
            .take(FOLLOWED)
            .filter_map(|(_, start)| self.descent(state, *start))
            .min_by(|a, b| a.excess.total_cmp(&b.excess))
    }

    /// The jump at the bottom of the valley that a jump at a state nearby lies in; `None` where it becomes infinitesimal.
    pub fn descend(&self, state: &Response, start: &Jump) -> Option<Jump> {
        let (a, n) = (start.amplitude, start.direction);
        self.descent(state, Vector6::new(a[0], a[1], a[2], n[0], n[1], n[2]))
    }

    /// The scaled excess of `a (x) M / |M|` at `(a, M)` with its gradient; `None` where the jump leaves the reach or the law.
    fn excess(&self, state: &Response, variables: &Vector6<f64>) -> Option<(f64, Vector6<f64>)> {
        let a: Vector3<f64> = variables.fixed_rows::<3>(0).into();
        let m: Vector3<f64> = variables.fixed_rows::<3>(3).into();
        let (length, size) = (m.norm(), a.norm());
        let n = m / length;
        let f = state.deformation.matrix() + a * n.transpose();
        let components = std::array::from_fn(|i| std::array::from_fn(|j| f[(i, j)]));
        let f = DeformationGradient::new(components).ok()?;
        let [largest, _, smallest] = f.principal_stretches();
        if smallest < self.reach.0 || largest > self.reach.1 {
            return None;
        }
        let there = self.material.response(&f).ok()?;
        let change = there.first_piola - state.first_piola;
        let energy = there.energy - state.energy - a.dot(&(state.first_piola * n));
        let scale = 2.0 / (size * size);
        let excess = energy * scale;
        let by_a = change * n * scale - a * (2.0 * excess / (size * size));
        let by_n = change.transpose() * a * scale;
        let by_m = (by_n - n * n.dot(&by_n)) / length;
        let gradient = Vector6::new(by_a[0], by_a[1], by_a[2], by_m[0], by_m[1], by_m[2]);
        excess.is_finite().then_some((excess, gradient))
    }

    fn descent(&self, state: &Response, start: Vector6<f64>) -> Option<Jump> {
        let (mut x, (mut value, mut gradient)) = (start, self.excess(state, &start)?);
        let mut inverse = Matrix6::identity() * (0.1 / gradient.norm().max(1e-300));
        let mut fresh = true;
        for _ in 0..STEPS {
            let mut step = -(inverse * gradient);
            if step.dot(&gradient) >= 0.0 || !step.norm().is_finite() {
                inverse = Matrix6::identity() * (0.1 / gradient.norm().max(1e-300));
                step = -(inverse * gradient);
                fresh = true;
            }
            let Some((length, next)) = self.shorter(state, &x, value, &step, &gradient) else {
                if fresh {
                    break;
                }
                inverse = Matrix6::identity() * (0.1 / gradient.norm().max(1e-300));
                fresh = true;
                continue;
            };
            let moved = step * length;
            let turned = next.1 - gradient;
            let curvature = moved.dot(&turned);
            if curvature > 0.0 {
                if fresh {
                    inverse = Matrix6::identity() * (curvature / turned.norm_squared());
                }
                let identity = Matrix6::identity();
                let left = identity - moved * turned.transpose() / curvature;
                inverse = left * inverse * left.transpose() + moved * moved.transpose() / curvature;
                fresh = false;
            }
            x += moved;
            let settled = moved.norm() <= 1e-13 * x.norm();
            (value, gradient) = next;
            let amplitude = x.fixed_rows::<3>(0).norm();
            if amplitude < SMALLEST {
                return None;
            }
            if settled {
                break;
            }
        }
        let a: Vector3<f64> = x.fixed_rows::<3>(0).into();
        let m: Vector3<f64> = x.fixed_rows::<3>(3).into();
        Some(Jump {
            amplitude: a,
            direction: m / m.norm(),
            excess: value,
            rounding: self.rounding(state, &x),
            at_edge: self.is_at_edge(&(state.deformation.matrix() + a * m.transpose() / m.norm())),
        })
    }

    /// How much of a scaled excess can be rounding: a thousand units in the last place of the energies that it is a difference of.
    fn rounding(&self, state: &Response, variables: &Vector6<f64>) -> f64 {
        let a: Vector3<f64> = variables.fixed_rows::<3>(0).into();
        let m: Vector3<f64> = variables.fixed_rows::<3>(3).into();
        let work = a.dot(&(state.first_piola * m)) / m.norm();
        let energies = 2.0 * state.energy.abs() + 2.0 * work.abs();
        2e3 * f64::EPSILON * energies / a.norm_squared()
    }

    /// Whether a state has a principal stretch within a hundredth of an end of the reach.
    fn is_at_edge(&self, f: &Matrix3<f64>) -> bool {
        let squares = (f.transpose() * f).symmetric_eigenvalues();
        let (smallest, largest) = (squares.min().max(0.0).sqrt(), squares.max().sqrt());
        smallest < 1.01 * self.reach.0 || largest > 0.99 * self.reach.1
    }

    /// The part of a step that is admitted and leads down, with the excess there.
    fn shorter(
        &self,
        state: &Response,
        x: &Vector6<f64>,
        value: f64,
        step: &Vector6<f64>,
        gradient: &Vector6<f64>,
    ) -> Option<(f64, (f64, Vector6<f64>))> {
        let slope = step.dot(gradient);
        let mut length = 1.0;
        for _ in 0..40 {
            if let Some(next) = self.excess(state, &(x + step * length))
                && next.0 < value + 1e-4 * length * slope
            {
                return Some((length, next));
            }
            length *= 0.5;
        }
        None
    }
}

/// Amplitudes and normals to start from.
fn starts() -> impl Iterator<Item = Vector6<f64>> {
    let normals = [
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [1.0, 1.0, 0.0],
        [1.0, -1.0, 0.0],
        [1.0, 0.0, 1.0],
        [1.0, 0.0, -1.0],
        [0.0, 1.0, 1.0],
        [0.0, 1.0, -1.0],
        [1.0, 1.0, 1.0],
        [1.0, 1.0, -1.0],
        [1.0, -1.0, 1.0],
        [-1.0, 1.0, 1.0],
    ];
    let amplitudes = [-2.5, -0.8, -0.4, 0.5, 1.2, 3.0, 6.0];
    normals.into_iter().flat_map(move |n| {
        (0..3).flat_map(move |axis| {
            amplitudes.into_iter().map(move |amplitude| {
                let mut start = Vector6::new(0.0, 0.0, 0.0, n[0], n[1], n[2]);
                start[axis] = amplitude;
                start
            })
        })
    })
}
