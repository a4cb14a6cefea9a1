//! Finite jumps of the deformation gradient that cost less than nothing.

use super::{Witness, principal_axes};
use crate::algebra::{Each, array_of, sort_by_value};
use crate::kinematics::DeformationGradient;
use crate::material::{Hyperelastic, Response, cofactor};
use crate::real::Interval;
use nalgebra::{Matrix3, Matrix6, Rotation3, Vector3, Vector6};

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
    /// Whether it leads to the largest stretch of the reach, so that a larger reach would allow a lower one.
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
/// growth at enormous strains. Where a descent meets the reach it goes on along it, among jumps whose largest stretch is the reach, and such jumps along the
/// same axes are starts too: the lowest of them are oblique. In compression jumps go as far as they lower the energy, since `J` cannot fall below
/// zero, where laws without growth toward `J = 0` have their lowest jumps. A jump that gains energy disproves rank-one convexity, up to rounding or, where [`JumpSearch::proves`] says so, in
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
/// How often the longest jump tried is halved.
const HALVINGS: i32 = 22;
/// How many of the lowest starts are followed.
const FOLLOWED: usize = 16;
/// How many jumps to the reach are followed for each normal.
const AT_EDGE: usize = 2;
/// The vector of the rotation of the axes along which jumps to the reach start.
const TURN: [f64; 3] = [0.11, -0.17, 0.13];
/// Steps of a descent.
const STEPS: usize = 80;
/// How often a descent goes along the reach and leaves it again.
const ROUNDS: usize = 3;
/// The part of a jump to the reach at which a shorter one is tried.
const INWARD: f64 = 0.99;
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
        let at_edge = self.starts_at_edge(state).into_iter();
        let along_edge = at_edge.filter_map(|start| self.along_edge(state, start));
        if let Some((n, g)) = wave {
            let scale = stretch_along(state.deformation.matrix(), &g);
            let both = ALONG_WAVE.into_iter().flat_map(|size| [size, -size]);
            let amplitudes = both.map(|size| g * (size * scale));
            starts.extend(amplitudes.map(|a| (0.0, joined(&a, &n))));
        }
        let inside = starts.iter();
        let inside = inside.filter_map(|(_, start)| self.descent(state, *start));
        along_edge
            .chain(inside)
            .min_by(|a, b| a.excess.total_cmp(&b.excess))
    }

    /// Of jumps along the axes from which the search starts the longest one that gains energy. Beside a step of the energy and before a concave kink every
    /// descent ends in jumps as short as the distance to it.
    pub(super) fn longest(&self, state: &Response) -> Option<Jump> {
        let (left, right) = principal_axes(&state.deformation);
        let pairs = AXES.into_iter().flat_map(|n| AXES.map(|g| (n, g)));
        let pairs: Vec<(Vector3<f64>, Vector3<f64>)> = pairs
            .map(|(n, g)| {
                let [n, g] = [right * Vector3::from(n), left * Vector3::from(g)];
                (n.normalize(), g.normalize())
            })
            .collect();
        (0..HALVINGS).find_map(|halvings| {
            let size = 0.5_f64.powi(halvings);
            let jumps = pairs.iter().flat_map(|(n, g)| {
                let scale = size * stretch_along(state.deformation.matrix(), g);
                [scale, -scale].map(|scale| (self.admitted(state, g * scale, n), *n))
            });
            let jumps = jumps.filter_map(|(a, n)| self.evaluated(state, a, n));
            jumps
                .filter(Jump::gains)
                .min_by(|a, b| a.excess.total_cmp(&b.excess))
        })
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
                    let start = joined(&free, &n);
                    Some((self.energy_of(state, &a, &n)?.0, start))
                };
                let tried = AMPLITUDES.into_iter().filter_map(of_size);
                starts.extend(tried.min_by(|a, b| a.0.total_cmp(&b.0)));
            }
        }
        starts
    }

    /// Jumps to the reach: of every normal of [`JumpSearch::starts`] the lowest with some polarizations along and against its axes. All axes are turned a little, since
    /// jumps along axes of symmetry have no slope toward lower ones beside them.
    fn starts_at_edge(&self, state: &Response) -> Vec<Vector6<f64>> {
        let (left, right) = principal_axes(&state.deformation);
        let turn = Rotation3::new(Vector3::from(TURN));
        let mut starts = Vec::with_capacity(AT_EDGE * AXES.len());
        for normal in AXES {
            let n = right * (turn * Vector3::from(normal));
            let polarizations = AXES
                .into_iter()
                .flat_map(|axis| [(axis, 1.0), (axis, -1.0)]);
            let jumps = polarizations.map(|(axis, sign)| {
                joined(&(left * (turn.inverse() * Vector3::from(axis)) * sign), &n)
            });
            let excesses =
                jumps.filter_map(|jump| Some((self.excess_at_edge(state, &jump)?.0, jump)));
            let mut own: Vec<(f64, Vector6<f64>)> = excesses.collect();
            sort_by_value(&mut own, |item| item.0);
            starts.extend(own.into_iter().take(AT_EDGE).map(|(_, jump)| jump));
        }
        starts
    }

    /// The jump at the bottom of the valley that a jump at a state nearby lies in; `None` where it becomes infinitesimal.
    pub fn descend(&self, state: &Response, start: &Jump) -> Option<Jump> {
        let n = start.direction;
        let a = self.free(state, start.amplitude, &n);
        self.descent(state, joined(&a, &n))
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
        self.reaches(&f)
            .then(|| self.energy_at(state, a, n))
            .flatten()
    }

    /// The same whatever the reach.
    fn energy_at(
        &self,
        state: &Response,
        a: &Vector3<f64>,
        n: &Vector3<f64>,
    ) -> Option<(f64, Matrix3<f64>)> {
        let f = state.deformation.matrix() + a * n.transpose();
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
        let (a, n) = self.to(state, variables);
        let (excess, change) = self.energy_of(state, &a, &n)?;
        let scale = 2.0 / a.norm_squared();
        let by_a = (change * n - a * excess) * scale;
        let by_n = change.transpose() * a * scale;
        Some((excess, self.pulled_back(state, variables, by_a, by_n)))
    }

    /// The jump that free variables stand for.
    fn to(&self, state: &Response, variables: &Vector6<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let (free, m) = parts(variables);
        let n = m.normalize();
        (self.admitted(state, free, &n), n)
    }

    /// A gradient by amplitude and normal of a jump as one by its free variables.
    fn pulled_back(
        &self,
        state: &Response,
        variables: &Vector6<f64>,
        mut by_a: Vector3<f64>,
        mut by_n: Vector3<f64>,
    ) -> Vector6<f64> {
        let (free, m) = parts(variables);
        let length = m.norm();
        let n = m / length;
        // a = b + w v, v = cof F N, w = J (y - x) / |v|^2, x = 1 + v . b / J, y the volume after the jump by that before.
        let cofactor = cofactor(&state.deformation.matrix());
        let jacobian = state.deformation.jacobian();
        let v = cofactor * n;
        let square = v.norm_squared();
        let x = 1.0 + v.dot(&free) / jacobian;
        let (volume, slope) = match self.incompressible {
            true => (1.0, 0.0),
            false => volume_after(x),
        };
        let weight = jacobian * (volume - x) / square;
        let along = v.dot(&by_a) / square;
        let by_v = by_a * weight + (free * (slope - 1.0) - v * (2.0 * weight)) * along;
        by_n += cofactor.transpose() * by_v;
        by_a += v * ((slope - 1.0) * along);
        joined(&by_a, &((by_n - n * n.dot(&by_n)) / length))
    }

    /// The scaled excess of the jump along `d (x) M / |M|` to the reach, at `(d, M)`, with its gradient.
    fn excess_at_edge(
        &self,
        state: &Response,
        variables: &Vector6<f64>,
    ) -> Option<(f64, Vector6<f64>)> {
        let (d, n) = self.toward_edge(state, variables);
        let (length, [by_d, by_n]) = self.length_to_edge(state, &d, &n)?;
        let a = d * length;
        let after = state.deformation.matrix() + a * n.transpose();
        if after.determinant() <= LEAST_VOLUME * state.deformation.jacobian() {
            return None;
        }
        let (excess, change) = self.energy_at(state, &a, &n)?;
        let scale = 2.0 / a.norm_squared();
        let by_a = (change * n - a * excess) * scale;
        let by_d = by_a * length + by_d * by_a.dot(&d);
        let by_n = change.transpose() * a * scale + by_n * by_a.dot(&d);
        let gradient = match self.incompressible {
            true => self.pulled_back(state, variables, by_d, by_n),
            false => {
                let m: Vector3<f64> = variables.fixed_rows::<3>(3).into();
                joined(&by_d, &((by_n - n * n.dot(&by_n)) / m.norm()))
            }
        };
        let is_finite = gradient.iter().all(|x| x.is_finite());
        is_finite.then_some((excess, gradient))
    }

    /// The direction of the amplitude of a jump to the reach, and the normal, from free variables.
    fn toward_edge(
        &self,
        state: &Response,
        variables: &Vector6<f64>,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let (free, m) = parts(variables);
        let n = m.normalize();
        match self.incompressible {
            true => (self.admitted(state, free, &n), n),
            false => (free, n),
        }
    }

    /// How long a jump along `d (x) N` to the reach is, with its derivatives by `d` and `N`; `None` where the state is there already.
    ///
    /// `F + t d (x) N` has the largest stretch `R` at the smallest `t > 0` with `det(R^2 - (F + t d (x) N) (F + t d (x) N)^T) = 0`: with `M = (R^2 - F
    /// F^T)^-1`, `f = F N`, `p = d . M d`, `q = d . M f` and `r = f . M f` at `t = 1 / (q + sqrt(p (1 + r)))`.
    fn length_to_edge(
        &self,
        state: &Response,
        d: &Vector3<f64>,
        n: &Vector3<f64>,
    ) -> Option<(f64, [Vector3<f64>; 2])> {
        let f = state.deformation.matrix();
        let left = Matrix3::identity() * self.reach.powi(2) - f * f.transpose();
        let inverse = left.cholesky()?.inverse();
        let along = f * n;
        let (md, mf) = (inverse * d, inverse * along);
        let (p, r) = (d.dot(&md), along.dot(&mf));
        let root = (p * (1.0 + r)).sqrt();
        let length = 1.0 / (d.dot(&mf) + root);
        let scale = -length * length;
        let by_d = (mf + md * ((1.0 + r) / root)) * scale;
        let by_n = f.transpose() * (md + mf * (p / root)) * scale;
        (length > 0.0 && length.is_finite()).then_some((length, [by_d, by_n]))
    }

    /// Whether a deformation has a positive determinant and principal stretches up to the reach.
    fn reaches(&self, f: &Matrix3<f64>) -> bool {
        f.determinant() > 0.0 && largest_square(f) <= self.reach * self.reach
    }

    /// The bottom of the valley of a jump, given by its free variables; along the reach where it lies there.
    fn descent(&self, state: &Response, mut start: Vector6<f64>) -> Option<Jump> {
        let is_small = |x: &Vector6<f64>| self.to(state, x).0.norm() < SMALLEST;
        let mut lowest: Option<Jump> = None;
        for _ in 0..ROUNDS {
            let x = downhill(start, |x| self.excess(state, x), is_small)?;
            let (a, n) = self.to(state, &x);
            let inside = self.jump(state, a, n)?;
            if !inside.at_edge {
                return Some(inside);
            }
            let along = self.along_edge(state, joined(&a, &n));
            let found = along.filter(|edge| edge.excess < inside.excess);
            let found = found.unwrap_or(inside);
            if lowest.is_some_and(|lowest| found.excess >= lowest.excess) {
                break;
            }
            lowest = Some(found);
            let (a, n) = (found.amplitude * INWARD, found.direction);
            let shorter = self.energy_of(state, &a, &n);
            if shorter.is_none_or(|(excess, _)| excess >= found.excess) {
                break;
            }
            start = joined(&self.free(state, a, &n), &n);
        }
        lowest
    }

    /// The lowest jump to the reach downhill of one along the direction of free variables.
    fn along_edge(&self, state: &Response, start: Vector6<f64>) -> Option<Jump> {
        let x = downhill(start, |x| self.excess_at_edge(state, x), |_| false)?;
        let (d, n) = self.toward_edge(state, &x);
        let (length, _) = self.length_to_edge(state, &d, &n)?;
        self.jump(state, d * length, n)
    }

    /// A jump with its excess; `None` of one that counts as infinitesimal.
    fn jump(&self, state: &Response, a: Vector3<f64>, n: Vector3<f64>) -> Option<Jump> {
        let is_finite = a.norm() >= SMALLEST;
        is_finite.then(|| self.evaluated(state, a, n)).flatten()
    }

    fn evaluated(&self, state: &Response, a: Vector3<f64>, n: Vector3<f64>) -> Option<Jump> {
        let after = state.deformation.matrix() + a * n.transpose();
        Some(Jump {
            amplitude: a,
            direction: n,
            excess: self.energy_at(state, &a, &n)?.0,
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
}

/// Amplitude and normal as one vector.
fn joined(a: &Vector3<f64>, n: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(a[0], a[1], a[2], n[0], n[1], n[2])
}

/// The halves of a vector.
fn parts(variables: &Vector6<f64>) -> (Vector3<f64>, Vector3<f64>) {
    (
        variables.fixed_rows::<3>(0).into(),
        variables.fixed_rows::<3>(3).into(),
    )
}

/// The bottom of a valley of a function with its gradient, by a quasi-Newton method (`BFGS`); `None` where the function has no value at the start, and
/// where the way down is over.
fn downhill(
    start: Vector6<f64>,
    function: impl Fn(&Vector6<f64>) -> Option<(f64, Vector6<f64>)>,
    is_over: impl Fn(&Vector6<f64>) -> bool,
) -> Option<Vector6<f64>> {
    let (mut x, (mut value, mut gradient)) = (start, function(&start)?);
    let steepest =
        |gradient: &Vector6<f64>| Matrix6::identity() * (0.1 / gradient.norm().max(1e-300));
    let mut inverse = steepest(&gradient);
    let mut fresh = true;
    for _ in 0..STEPS {
        let mut step = -(inverse * gradient);
        if step.dot(&gradient) >= 0.0 || !step.norm().is_finite() {
            inverse = steepest(&gradient);
            step = -(inverse * gradient);
            fresh = true;
        }
        let Some((length, next)) = shorter(&function, &x, value, &step, &gradient) else {
            if fresh {
                break;
            }
            inverse = steepest(&gradient);
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
        (value, gradient) = next;
        if is_over(&x) {
            return None;
        }
        if moved.norm() <= 1e-13 * x.norm() {
            break;
        }
    }
    Some(x)
}

/// The part of a step that is admitted and leads down, with the function there.
fn shorter(
    function: impl Fn(&Vector6<f64>) -> Option<(f64, Vector6<f64>)>,
    x: &Vector6<f64>,
    value: f64,
    step: &Vector6<f64>,
    gradient: &Vector6<f64>,
) -> Option<(f64, (f64, Vector6<f64>))> {
    let slope = step.dot(gradient);
    let mut length = 1.0;
    for _ in 0..40 {
        if let Some(next) = function(&(x + step * length))
            && next.0 < value + 1e-4 * length * slope
        {
            return Some((length, next));
        }
        length *= 0.5;
    }
    None
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
