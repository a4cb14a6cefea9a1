//! Finite jumps of the deformation gradient that cost less than nothing.

use super::incompressible::cofactor;
use super::{Witness, principal_axes};
use crate::algebra::{Each, array_of, sort_by_value};
use crate::kinematics::DeformationGradient;
use crate::material::{Hyperelastic, Response};
use crate::real::Interval;
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
    /// Whether it leads to the largest stretch of the reach; it is then not the lowest of its valley, and not as accurate.
    pub at_edge: bool,
    /// Whether it leads to as good as no volume: the law has a finite energy there, and the lowest jump of its valley is a limit.
    pub collapses: bool,
}

impl Jump {
    /// Whether it gains energy, beyond what rounding can pretend.
    pub fn gains(&self) -> bool {
        self.excess < -self.rounding
    }

    /// The jump as a witness; `verified` where it was [proved](JumpSearch::proves) to gain energy.
    pub fn witness(&self, verified: bool) -> Witness {
        Witness::Jump {
            amplitude: self.amplitude.into(),
            direction: self.direction.into(),
            at_edge: self.at_edge,
            collapses: self.collapses,
            verified,
        }
    }
}

/// Searches for finite jumps that gain energy.
///
/// Starts: normals and polarizations along the thirteen axes of a cube in the principal frame, with amplitudes in ratio to the stretch along the
/// polarization, both ways; the lowest of them, one for each pair of axes, are followed downhill (quasi-Newton, `BFGS`) in amplitude and normal
/// together. Jumps lead to states with principal stretches up to the reach only, since many laws lack
/// growth at enormous strains; in compression they go as far as they lower the energy, since `J` cannot fall below zero, where laws without growth
/// toward `J = 0` have their lowest jumps. A jump that gains energy disproves rank-one convexity, up to rounding or, where [`JumpSearch::proves`] says so, in
/// exact arithmetic; none found is no proof of it.
///
/// ```
/// use onset::kinematics::DeformationGradient;
/// use onset::material::{Hyperelastic, BlatzKo};
/// use onset::criteria::JumpSearch;
/// let law = BlatzKo::default();
/// let search = JumpSearch::new(&law, 10.0);
/// // In uniaxial strain 3.5 waves travel still (they do up to 3.732), but a large jump gains energy.
/// let f = DeformationGradient::from_stretches([3.5, 1.0, 1.0])?;
/// let state = law.response(&f)?;
/// let jump = search.lowest(&state).ok_or("no jump")?;
/// assert!(jump.excess < 0.0 && search.proves(&state, &jump));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct JumpSearch<'a> {
    material: &'a dyn Hyperelastic,
    reach: f64,
    incompressible: bool,
}

/// Smaller jumps count as infinitesimal: their excess is that of a wave.
const SMALLEST: f64 = 1e-3;
/// How many of the lowest starts are followed.
const FOLLOWED: usize = 16;
/// Steps of a descent.
const STEPS: usize = 80;
/// The volume that jumps leave at the least, by that before them.
const LEAST_VOLUME: f64 = 1e-7;
/// Jumps that leave less volume, by that before them, count as collapse.
const COLLAPSED: f64 = 1e-3;
/// Axes of a cube: normals of its faces, its edges and its corners.
const AXES: [[f64; 3]; 13] = [
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
/// Amplitudes to start from, in ratio to the stretch along the polarization.
const AMPLITUDES: [f64; 8] = [-3.0, -0.85, -0.5, -0.25, 0.3, 0.8, 2.0, 5.0];
/// Amplitudes to start from along a wave that stops.
const ALONG_WAVE: [f64; 6] = [0.01, 0.03, 0.1, 0.3, 0.6, 1.2];

impl<'a> JumpSearch<'a> {
    /// A search in a law among jumps to states with principal stretches up to `reach`.
    pub fn new(material: &'a dyn Hyperelastic, reach: f64) -> Self {
        Self {
            material,
            reach,
            incompressible: false,
        }
    }

    /// The same among jumps that keep the volume, `a . F^-T N = 0`.
    pub fn incompressible(mut self) -> Self {
        self.incompressible = true;
        self
    }

    /// The jump with the lowest scaled excess that was found; `None` where every descent ends in an infinitesimal one.
    pub fn lowest(&self, state: &Response) -> Option<Jump> {
        self.lowest_beside(state, None)
    }

    /// The same, with small jumps along a wave, direction and polarization, among the starts: where a wave stops whose third derivative of the
    /// energy does not vanish, jumps along it have gained energy before.
    pub fn lowest_beside(
        &self,
        state: &Response,
        wave: Option<(Vector3<f64>, Vector3<f64>)>,
    ) -> Option<Jump> {
        let mut starts: Vec<(f64, Vector6<f64>)> = self.starts(state);
        sort_by_value(&mut starts, |item| item.0);
        starts.truncate(FOLLOWED);
        if let Some((n, g)) = wave {
            let scale = stretch_along(state.deformation.matrix(), &g);
            let both = ALONG_WAVE.into_iter().flat_map(|size| [size, -size]);
            let amplitudes = both.map(|size| g * (size * scale));
            starts.extend(
                amplitudes.map(|a| (0.0, Vector6::new(a[0], a[1], a[2], n[0], n[1], n[2]))),
            );
        }
        starts
            .iter()
            .filter_map(|(_, start)| self.descent(state, *start))
            .min_by(|a, b| a.excess.total_cmp(&b.excess))
    }

    /// The lowest start of every pair of normal and polarization, with its excess.
    fn starts(&self, state: &Response) -> Vec<(f64, Vector6<f64>)> {
        let f = state.deformation.matrix();
        let (left, right) = principal_axes(&state.deformation);
        let mut starts = Vec::with_capacity(AXES.len() * AXES.len());
        for normal in AXES {
            let n = (right * Vector3::from(normal)).normalize();
            for axis in AXES {
                let g = (left * Vector3::from(axis)).normalize();
                let scale = stretch_along(f, &g);
                let of_size = |size: f64| {
                    let free = g * (size * scale);
                    let a = self.admitted(state, free, &n);
                    if a.norm() < 0.1 * size.abs() * scale {
                        return None;
                    }
                    let start = Vector6::new(free[0], free[1], free[2], n[0], n[1], n[2]);
                    Some((self.energy_of(state, &a, &n)?.0, start))
                };
                let tried = AMPLITUDES.into_iter().filter_map(of_size);
                starts.extend(tried.min_by(|a, b| a.0.total_cmp(&b.0)));
            }
        }
        starts
    }

    /// The jump at the bottom of the valley that a jump at a state nearby lies in; `None` where it becomes infinitesimal.
    pub fn descend(&self, state: &Response, start: &Jump) -> Option<Jump> {
        let n = start.direction;
        let a = self.free(state, start.amplitude, &n);
        self.descent(state, Vector6::new(a[0], a[1], a[2], n[0], n[1], n[2]))
    }

    /// Whether a jump gains energy in exact arithmetic, by intervals of the law: `W(F + a (x) N) - W(F) - P : (a (x) N)` is below zero for all
    /// numbers within the rounding of the program. Never for a law that knows no intervals, as a user's subroutine, and not for jumps that keep
    /// the volume, which floating-point numbers do to rounding only.
    pub fn proves(&self, state: &Response, jump: &Jump) -> bool {
        if self.incompressible {
            return false;
        }
        let point = |components: &[[f64; 3]; 3]| components.each(|row| row.map(Interval::point));
        let here = point(state.deformation.components());
        let leap: [[Interval; 3]; 3] =
            array_of(|i| array_of(|j| Interval::point(jump.amplitude[i]) * jump.direction[j]));
        let there = array_of(|i| array_of(|j| here[i][j] + leap[i][j]));
        let there = DeformationGradient::from_components(there);
        if there.determinant().low <= 0.0 {
            return false;
        }
        let before = self
            .material
            .enclosure(&DeformationGradient::from_components(here));
        let after = self.material.enclosure(&there);
        let mut gain = after.energy - before.energy;
        for (i, j) in (0..9).map(|n| (n / 3, n % 3)) {
            gain = gain - before.first_piola[i][j] * leap[i][j];
        }
        gain.high < 0.0
    }

    /// `2 (W(F + a (x) N) - W(F) - P : (a (x) N)) / |a|^2` with the change of stress; `None` where the jump leaves the reach or the law.
    fn energy_of(
        &self,
        state: &Response,
        a: &Vector3<f64>,
        n: &Vector3<f64>,
    ) -> Option<(f64, Matrix3<f64>)> {
        let f = state.deformation.matrix() + a * n.transpose();
        if !self.reaches(&f) {
            return None;
        }
        let components = array_of(|i| array_of(|j| f[(i, j)]));
        let f = DeformationGradient::from_components(components);
        let (energy, stress) = self.material.energy_and_stress(&f).ok()?;
        let gain = energy - state.energy - a.dot(&(state.first_piola * n));
        let excess = gain * 2.0 / a.norm_squared();
        excess
            .is_finite()
            .then_some((excess, stress - state.first_piola))
    }

    /// The amplitude of a free vector, after which the volume is positive, or what it was if that is to be kept.
    ///
    /// The jump `b (x) N` changes `J` to `J x`, `x = 1 + b . cof F N / J`, and is changed along `cof F N` so that the volume is `J` times
    /// [`volume_after`] of `x`, or 1.
    fn admitted(&self, state: &Response, b: Vector3<f64>, n: &Vector3<f64>) -> Vector3<f64> {
        let normal = cofactor(&state.deformation.matrix()) * n;
        let jacobian = state.deformation.jacobian();
        let x = 1.0 + normal.dot(&b) / jacobian;
        let wanted = if self.incompressible {
            1.0
        } else {
            volume_after(x).0
        };
        b + normal * (jacobian * (wanted - x) / normal.norm_squared())
    }

    /// A free vector of an amplitude.
    fn free(&self, state: &Response, a: Vector3<f64>, n: &Vector3<f64>) -> Vector3<f64> {
        if self.incompressible {
            return a;
        }
        let normal = cofactor(&state.deformation.matrix()) * n;
        let jacobian = state.deformation.jacobian();
        let volume = 1.0 + normal.dot(&a) / jacobian;
        a + normal * (jacobian * (free_volume(volume) - volume) / normal.norm_squared())
    }

    /// The scaled excess of `a (x) M / |M|` at `(a, M)` with its gradient; `None` where the jump leaves the reach or the law.
    fn excess(&self, state: &Response, variables: &Vector6<f64>) -> Option<(f64, Vector6<f64>)> {
        let free: Vector3<f64> = variables.fixed_rows::<3>(0).into();
        let m: Vector3<f64> = variables.fixed_rows::<3>(3).into();
        let length = m.norm();
        let n = m / length;
        let a = self.admitted(state, free, &n);
        let (excess, change) = self.energy_of(state, &a, &n)?;
        let scale = 2.0 / a.norm_squared();
        let mut by_a = (change * n - a * excess) * scale;
        let mut by_n = change.transpose() * a * scale;
        // a = b + w v, v = cof F N, w = J (y - x) / |v|^2, x = 1 + v . b / J, y the volume after the jump by that before.
        let cofactor = cofactor(&state.deformation.matrix());
        let jacobian = state.deformation.jacobian();
        let v = cofactor * n;
        let square = v.norm_squared();
        let x = 1.0 + v.dot(&free) / jacobian;
        let (volume, slope) = if self.incompressible {
            (1.0, 0.0)
        } else {
            volume_after(x)
        };
        let weight = jacobian * (volume - x) / square;
        let along = v.dot(&by_a) / square;
        let by_v = by_a * weight + (free * (slope - 1.0) - v * (2.0 * weight)) * along;
        by_n += cofactor.transpose() * by_v;
        by_a += v * ((slope - 1.0) * along);
        let by_m = (by_n - n * n.dot(&by_n)) / length;
        Some((
            excess,
            Vector6::new(by_a[0], by_a[1], by_a[2], by_m[0], by_m[1], by_m[2]),
        ))
    }

    /// Whether a deformation has a positive determinant and principal stretches up to the reach.
    fn reaches(&self, f: &Matrix3<f64>) -> bool {
        f.determinant() > 0.0 && largest_square(f) <= self.reach * self.reach
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
            let n: Vector3<f64> = x.fixed_rows::<3>(3).into();
            let amplitude = self.admitted(state, x.fixed_rows::<3>(0).into(), &n.normalize());
            if amplitude.norm() < SMALLEST {
                return None;
            }
            if settled {
                break;
            }
        }
        let m: Vector3<f64> = x.fixed_rows::<3>(3).into();
        let n = m / m.norm();
        let a = self.admitted(state, x.fixed_rows::<3>(0).into(), &n);
        let after = state.deformation.matrix() + a * n.transpose();
        Some(Jump {
            amplitude: a,
            direction: n,
            excess: value,
            rounding: Self::rounding(state, &a, &n),
            at_edge: largest_square(&after).sqrt() > 0.99 * self.reach,
            collapses: after.determinant() < COLLAPSED * state.deformation.jacobian(),
        })
    }

    /// How much of a scaled excess can be rounding: a thousand units in the last place of the energies that it is a difference of.
    fn rounding(state: &Response, a: &Vector3<f64>, n: &Vector3<f64>) -> f64 {
        let work = a.dot(&(state.first_piola * n));
        let energies = 2.0 * state.energy.abs() + 2.0 * work.abs();
        2e3 * f64::EPSILON * energies / a.norm_squared()
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

/// `|F^T g|`, the size of `F` along `g`: a principal stretch where `g` is a principal axis.
fn stretch_along(f: Matrix3<f64>, g: &Vector3<f64>) -> f64 {
    (f.transpose() * g).norm()
}

/// The volume after a jump by that before, from a free number, with its derivative: that number from 1/2 on, below it an exponential that
/// falls to [`LEAST_VOLUME`] without an end.
fn volume_after(x: f64) -> (f64, f64) {
    if x >= 0.5 {
        return (x, 1.0);
    }
    let span = 0.5 - LEAST_VOLUME;
    let slope = ((x - 0.5) / span).exp();
    (LEAST_VOLUME + span * slope, slope)
}

/// The free number of a volume.
fn free_volume(volume: f64) -> f64 {
    if volume >= 0.5 {
        return volume;
    }
    let span = 0.5 - LEAST_VOLUME;
    let part = ((volume - LEAST_VOLUME) / span).max(f64::MIN_POSITIVE);
    0.5 + span * part.ln()
}

/// The largest eigenvalue of `F^T F`: a root of its characteristic polynomial by its angle.
fn largest_square(f: &Matrix3<f64>) -> f64 {
    let c = f.transpose() * f;
    let mean = c.trace() / 3.0;
    let deviator = c - Matrix3::identity() * mean;
    let size = (deviator.norm_squared() / 6.0).sqrt();
    if size <= f64::EPSILON * mean {
        return mean;
    }
    let cosine = (0.5 * (deviator / size).determinant()).clamp(-1.0, 1.0);
    mean + 2.0 * size * (cosine.acos() / 3.0).cos()
}
