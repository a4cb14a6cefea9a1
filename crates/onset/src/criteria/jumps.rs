//! Finite jumps of the deformation gradient that lower the energy.

use super::{Witness, principal_axes};
use crate::algebra::{Each, array_of, sort_by_value};
use crate::kinematics::DeformationGradient;
use crate::material::{Hyperelastic, Response, bulk_modulus_above, cofactor};
use crate::real::Interval;
use nalgebra::{Matrix3, Matrix6, Rotation3, Vector3, Vector6};

/// Jump `a (x) N` of the deformation gradient with its scaled excess of energy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump {
    /// Amplitude `a` of the jump.
    pub amplitude: Vector3<f64>,
    /// Unit normal `N` in the reference configuration.
    pub direction: Vector3<f64>,
    /// Scaled excess `2 (W(F + a (x) N) - W(F) - P : (a (x) N)) / |a|^2`; units of stress. For infinitesimal jumps it tends to `a . Q(N) a / |a|^2`.
    pub excess: f64,
    /// Rounding error of the excess.
    pub rounding: f64,
    /// Whether the jump reaches the largest admitted stretch, so that a larger limit would permit a lower excess.
    pub at_edge: bool,
    /// Whether the jump leads to nearly zero volume. The law has a finite energy there, and the lowest jump of its valley is a limit.
    pub collapses: bool,
}

impl Jump {
    /// Returns true if the jump lowers the energy by more than rounding.
    pub fn gains(&self) -> bool {
        self.excess < -self.rounding
    }

    /// Converts the jump to a witness; `verified` if its decrease of energy is [proved](JumpSearch::proves).
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

/// Search for finite jumps that lower the energy, which disproves rank-one convexity.
///
/// The normals and polarizations of the starts lie along the thirteen axes of a cube in the principal frame. Their amplitudes are multiples of the
/// stretch along the polarization, with both signs. A quasi-Newton descent (`BFGS`) in amplitude and normal together follows the lowest start of each
/// pair of axes.
///
/// Jumps lead only to states with principal stretches up to the reach, since many laws lack growth at enormous strains. A descent that meets this
/// limit continues along it, among jumps whose largest stretch equals the reach. Such jumps along the same axes are also starts, because the lowest
/// of them are oblique. In compression jumps are limited only by the energy, since `J` cannot fall below zero, where laws without growth toward `J =
/// 0` have their lowest jumps. For nearly incompressible laws volume-preserving jumps are also searched for, and followed downhill among all jumps.
///
/// A jump that lowers the energy disproves rank-one convexity, to rounding or, if [`JumpSearch::proves`] returns true, in exact arithmetic. A search
/// without result proves nothing.
///
/// ```
/// use onset::kinematics::DeformationGradient;
/// use onset::material::{Hyperelastic, BlatzKo};
/// use onset::criteria::JumpSearch;
/// let law = BlatzKo::default();
/// let search = JumpSearch::new(&law, 10.0);
/// // At the uniaxial strain 3.5 waves have real speeds (up to 3.732), but a large jump lowers the energy.
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
    isotropic: bool,
    /// Whether volume-preserving jumps are searched for if a descent in all variables finds no jump that lowers the energy.
    is_stiff: bool,
}

/// Smallest ratio of bulk to shear modulus of a nearly incompressible law. The valleys of its energy may be too narrow for a descent in all
/// variables, and volume-preserving jumps are also searched for.
const STIFF: f64 = 3e3;

/// Largest amplitude of an infinitesimal jump, relative to the stretch: the excess of the jump equals the excess of a wave.
const INFINITESIMAL_AMPLITUDE: f64 = 1e-3;
/// Number of halvings of the longest trial jump.
const HALVINGS: i32 = 22;
/// Ratio of the lengths of trial jumps across a step of the energy.
const LENGTHENING: f64 = 1.05;
/// Number of these jumps.
const LENGTHENINGS: i32 = 48;
/// Number of lowest starts that are followed.
const FOLLOWED_STARTS: usize = 16;
/// Number of jumps to the reach that are followed for each normal.
const EDGE_JUMPS_PER_NORMAL: usize = 2;
/// Rotation vector of the axes along which jumps to the reach start.
const AXES_ROTATION: [f64; 3] = [0.11, -0.17, 0.13];
/// Largest number of iterations of a descent.
const DESCENT_ITERATIONS: usize = 80;
/// Smallest relative decrease of a positive excess for which a descent continues.
const DESCENT_DECREASE: f64 = 1e-4;
/// Largest number of times that a descent meets the reach, continues along it and leaves it.
const ROUNDS: usize = 3;
/// Fraction of a jump to the reach at which a shorter jump is tried.
const INWARD_FRACTION: f64 = 0.99;
/// Smallest ratio of the volumes after and before a jump. Rounding of the determinant leaves four digits of it.
const SMALLEST_VOLUME_RATIO: f64 = 1e-12;
/// Decimal powers of the volume ratios of the starts that collapse. An energy without bound below at `J = 0` falls only behind a barrier whose height
/// is of the order of the bulk modulus, and the higher it is the smaller are the volumes behind it.
const COLLAPSES: std::ops::Range<i32> = -11..0;
/// Largest ratio of the volumes after and before a jump that counts as collapse.
const COLLAPSE_VOLUME_RATIO: f64 = 1e-3;
/// Axes of a cube: normals of its faces, its edges and its corners.
pub(super) const AXES: [[f64; 3]; 13] = [
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
/// Principal axes whose direction a reflection reverses.
const REFLECTIONS: [usize; 3] = [0, 1, 2];
/// Amplitudes of the starts, relative to the stretch along the polarization.
const AMPLITUDES: [f64; 8] = [-3.0, -0.85, -0.5, -0.25, 0.3, 0.8, 2.0, 5.0];
/// Amplitudes of the starts along a wave whose speed vanishes.
const ALONG_WAVE: [f64; 6] = [0.01, 0.03, 0.1, 0.3, 0.6, 1.2];

impl<'a> JumpSearch<'a> {
    /// Creates a search among jumps to states with principal stretches up to `reach`.
    pub fn new(material: &'a dyn Hyperelastic, reach: f64) -> Self {
        Self {
            material,
            reach,
            incompressible: false,
            isotropic: false,
            is_stiff: bulk_modulus_above(material, STIFF).is_some(),
        }
    }

    /// Search among volume-preserving jumps, if the law is nearly incompressible.
    fn preserving_volume(&self) -> Option<Self> {
        (self.is_stiff && !self.incompressible).then_some(Self {
            incompressible: true,
            ..*self
        })
    }

    /// Declares the law isotropic: of several jumps that are mirror images in the principal axes only one is tried.
    pub fn isotropic(mut self) -> Self {
        self.isotropic = true;
        self
    }

    /// Normals and polarizations of the starts in the principal frame.
    fn pairs(&self) -> Vec<(Vector3<f64>, Vector3<f64>)> {
        let pairs = AXES.into_iter().flat_map(|n| AXES.map(|g| (n, g)));
        let mut kept: Vec<(Vector3<f64>, Vector3<f64>)> = Vec::new();
        for (n, g) in pairs {
            let [n, g] = [n, g].map(Vector3::from);
            let jump = g * n.transpose();
            let is_image = |flip: &Matrix3<f64>| {
                let image = flip * jump * flip;
                kept.iter().any(|(n, g)| g * n.transpose() == image)
            };
            if !(self.isotropic && REFLECTIONS.map(reflection).iter().any(is_image)) {
                kept.push((n, g));
            }
        }
        kept
    }

    /// Restricts the search to volume-preserving jumps, `a . F^-T N = 0`.
    pub fn incompressible(mut self) -> Self {
        self.incompressible = true;
        self
    }

    /// Returns the jump with the lowest scaled excess found; `None` if every descent ends in an infinitesimal jump.
    pub fn lowest(&self, state: &Response) -> Option<Jump> {
        self.lowest_beside(state, None)
    }

    /// Like [`JumpSearch::lowest`], with small jumps along a wave (direction and polarization) among the starts.
    ///
    /// If the third derivative of the energy along a wave does not vanish, jumps along this wave lower the energy before its speed vanishes.
    pub fn lowest_beside(
        &self,
        state: &Response,
        wave: Option<(Vector3<f64>, Vector3<f64>)>,
    ) -> Option<Jump> {
        let mut starts: Vec<(f64, Vector6<f64>)> = self.starts(state);
        sort_by_value(&mut starts, |item| item.0);
        starts.truncate(FOLLOWED_STARTS);
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
        let all = along_edge.chain(inside);
        let own = all.min_by(|a, b| a.excess.total_cmp(&b.excess));
        self.or_preserving_volume(state, own, |search| search.lowest_beside(state, wave))
    }

    /// Extends the search to volume-preserving jumps if the law is nearly incompressible and the given jump does not lower the energy.
    fn or_preserving_volume(
        &self,
        state: &Response,
        own: Option<Jump>,
        search: impl FnOnce(&Self) -> Option<Jump>,
    ) -> Option<Jump> {
        if own.as_ref().is_some_and(Jump::gains) {
            return own;
        }
        let preserving = self.preserving_volume();
        let found = preserving.and_then(|own| search(&own));
        let relaxed = found.and_then(|jump| self.relaxed(state, jump));
        let both = own.into_iter().chain(relaxed);
        both.min_by(|a, b| a.excess.total_cmp(&b.excess))
    }

    /// Follows a volume-preserving jump to the bottom of its valley among all jumps.
    fn relaxed(&self, state: &Response, jump: Jump) -> Option<Jump> {
        let a = self.free(state, jump.amplitude, &jump.direction);
        let relaxed = self.descent(state, joined(&a, &jump.direction));
        relaxed
            .filter(|relaxed| relaxed.excess < jump.excess)
            .or(Some(jump))
    }

    /// Returns the longest jump along the axes of the search that lowers the energy. Near a step of the energy and before a concave kink every descent
    /// ends in jumps as short as the distance to it.
    pub(super) fn longest(&self, state: &Response) -> Option<Jump> {
        let (left, right) = principal_axes(&state.deformation);
        let pairs = self.pairs().into_iter();
        let pairs: Vec<(Vector3<f64>, Vector3<f64>)> = pairs
            .map(|(n, g)| ((right * n).normalize(), (left * g).normalize()))
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

    /// Returns the shortest jump that lowers the energy among the jumps that lengthen another jump. Near a step of the energy it is the jump that
    /// just crosses the step.
    pub(super) fn across_step(&self, state: &Response, jump: &Jump) -> Option<Jump> {
        let n = jump.direction;
        let of_length = |length: f64| {
            let a = self.admitted(state, jump.amplitude * length, &n);
            self.evaluated(state, a, n).filter(Jump::gains)
        };
        let mut lengths = (0..LENGTHENINGS).map(|n| LENGTHENING.powi(n));
        let (mut long, mut found) =
            lengths.find_map(|length| Some((length, of_length(length)?)))?;
        let mut short = long / LENGTHENING;
        for _ in 0..f64::MANTISSA_DIGITS {
            let middle = 0.5 * (short + long);
            match of_length(middle) {
                Some(shorter) => (long, found) = (middle, shorter),
                None => short = middle,
            }
        }
        Some(found)
    }

    /// Returns the lowest start of every pair of normal and polarization, with its excess.
    fn starts(&self, state: &Response) -> Vec<(f64, Vector6<f64>)> {
        let f = state.deformation.matrix();
        let (left, right) = principal_axes(&state.deformation);
        let lowest = |(n, g): (Vector3<f64>, Vector3<f64>)| {
            let [n, g] = [right * n, left * g].map(|axis| axis.normalize());
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
            tried.min_by(|a, b| a.0.total_cmp(&b.0))
        };
        let pairs = self.pairs();
        let normals = pairs.iter().filter(|(n, g)| n == g);
        let collapses = normals.filter_map(|(n, _)| self.collapse(state, (right * n).normalize()));
        let mut starts: Vec<(f64, Vector6<f64>)> = collapses.collect();
        starts.extend(pairs.into_iter().filter_map(lowest));
        starts
    }

    /// Returns the lowest start among the jumps along `cof F N` to nearly zero volume, with its excess.
    fn collapse(&self, state: &Response, n: Vector3<f64>) -> Option<(f64, Vector6<f64>)> {
        let along = cofactor(&state.deformation.matrix()) * n;
        let closing = along * (state.deformation.jacobian() / along.norm_squared());
        let of_volume = |power: i32| {
            let a = closing * (10.0_f64.powi(power) - 1.0);
            let start = joined(&self.free(state, a, &n), &n);
            Some((self.energy_of(state, &a, &n)?.0, start))
        };
        let tried = COLLAPSES.filter(|_| !self.incompressible);
        tried
            .filter_map(of_volume)
            .min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Returns starts that lead to the reach: for every normal of [`JumpSearch::starts`] the lowest few polarizations. All axes are rotated slightly,
    /// since the excess is stationary along axes of symmetry.
    fn starts_at_edge(&self, state: &Response) -> Vec<Vector6<f64>> {
        let (left, right) = principal_axes(&state.deformation);
        let turn = Rotation3::new(Vector3::from(AXES_ROTATION));
        let mut starts = Vec::with_capacity(EDGE_JUMPS_PER_NORMAL * AXES.len());
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
            starts.extend(
                own.into_iter()
                    .take(EDGE_JUMPS_PER_NORMAL)
                    .map(|(_, jump)| jump),
            );
        }
        starts
    }

    /// Follows a jump of a nearby state to the bottom of its valley; `None` if the jump becomes infinitesimal.
    pub fn descend(&self, state: &Response, start: &Jump) -> Option<Jump> {
        self.descend_from(state, start.amplitude, &start.direction)
    }

    /// Follows a jump, given by amplitude and unit normal, to the bottom of its valley; `None` if the jump becomes infinitesimal.
    pub(super) fn descend_from(
        &self,
        state: &Response,
        amplitude: Vector3<f64>,
        n: &Vector3<f64>,
    ) -> Option<Jump> {
        let own = self.descent(state, joined(&self.free(state, amplitude, n), n));
        self.or_preserving_volume(state, own, |search| {
            let a = search.admitted(state, amplitude, n);
            search.descent(state, joined(&a, n))
        })
    }

    /// Returns true if interval arithmetic proves that a jump lowers the energy.
    ///
    /// The enclosure of `W(F + a (x) N) - W(F) - P : (a (x) N)` must be negative. The result is always false for a law without enclosures, such as a
    /// user subroutine, and for volume-preserving jumps, which floating-point numbers satisfy only to rounding.
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

    /// Scaled excess and change of stress of a jump; `None` if the jump leaves the reach or the domain of the law.
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

    /// Scaled excess and change of stress of a jump, independent of the reach.
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

    /// Amplitude of a jump, computed from its free vector such that the volume after the jump is positive, or unchanged for incompressible response.
    ///
    /// The jump `b (x) N` changes `J` to `J x`, `x = 1 + b . cof F N / J`. It is modified along `cof F N` such that the volume is `J` times
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

    /// Free vector of an amplitude: the inverse of [`JumpSearch::admitted`].
    fn free(&self, state: &Response, a: Vector3<f64>, n: &Vector3<f64>) -> Vector3<f64> {
        if self.incompressible {
            return a;
        }
        let normal = cofactor(&state.deformation.matrix()) * n;
        let jacobian = state.deformation.jacobian();
        let volume = 1.0 + normal.dot(&a) / jacobian;
        a + normal * (jacobian * (free_volume(volume) - volume) / normal.norm_squared())
    }

    /// Scaled excess of `a (x) M / |M|` at `(a, M)` with its gradient; `None` if the jump leaves the reach or the domain of the law.
    fn excess(&self, state: &Response, variables: &Vector6<f64>) -> Option<(f64, Vector6<f64>)> {
        let (a, n) = self.to(state, variables);
        let (excess, change) = self.energy_of(state, &a, &n)?;
        let scale = 2.0 / a.norm_squared();
        let by_a = (change * n - a * excess) * scale;
        let by_n = change.transpose() * a * scale;
        Some((excess, self.pulled_back(state, variables, by_a, by_n)))
    }

    /// Amplitude and normal of the jump that free variables represent.
    fn to(&self, state: &Response, variables: &Vector6<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let (free, m) = parts(variables);
        let n = m.normalize();
        (self.admitted(state, free, &n), n)
    }

    /// Transforms a gradient with respect to amplitude and normal to a gradient with respect to the free variables.
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
        // a = b + w v, v = cof F N, w = J (y - x) / |v|^2, x = 1 + v . b / J, where y is the ratio of the volumes after and before the jump.
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

    /// Scaled excess of the jump along `d (x) M / |M|` to the reach, at `(d, M)`, with its gradient.
    fn excess_at_edge(
        &self,
        state: &Response,
        variables: &Vector6<f64>,
    ) -> Option<(f64, Vector6<f64>)> {
        let (d, n) = self.toward_edge(state, variables);
        let (length, [by_d, by_n]) = self.length_to_edge(state, &d, &n)?;
        let a = d * length;
        let after = state.deformation.matrix() + a * n.transpose();
        if after.determinant() <= SMALLEST_VOLUME_RATIO * state.deformation.jacobian() {
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

    /// Direction of the amplitude of a jump to the reach, and its normal, from free variables.
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

    /// Length of a jump along `d (x) N` to the reach, with its derivatives with respect to `d` and `N`.
    /// `None` if the state already has the largest stretch.
    ///
    /// `F + t d (x) N` has the largest stretch `R` at the smallest `t > 0` with `det(R^2 - (F + t d (x) N) (F + t d (x) N)^T) = 0`. With
    /// `M = (R^2 - F F^T)^-1`, `f = F N`, `p = d . M d`, `q = d . M f` and `r = f . M f` it is `t = 1 / (q + sqrt(p (1 + r)))`.
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

    /// Returns true if a deformation has a positive determinant and principal stretches up to the reach.
    fn reaches(&self, f: &Matrix3<f64>) -> bool {
        f.determinant() > 0.0 && largest_square(f) <= self.reach * self.reach
    }

    /// Minimizes the excess from the free variables of a jump, and along the reach if the descent meets it.
    fn descent(&self, state: &Response, mut start: Vector6<f64>) -> Option<Jump> {
        let is_small = |x: &Vector6<f64>| self.to(state, x).0.norm() < INFINITESIMAL_AMPLITUDE;
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
            let (a, n) = (found.amplitude * INWARD_FRACTION, found.direction);
            let shorter = self.energy_of(state, &a, &n);
            if shorter.is_none_or(|(excess, _)| excess >= found.excess) {
                break;
            }
            start = joined(&self.free(state, a, &n), &n);
        }
        lowest
    }

    /// Minimizes the excess among jumps to the reach, from the direction of a free vector.
    fn along_edge(&self, state: &Response, start: Vector6<f64>) -> Option<Jump> {
        let x = downhill(start, |x| self.excess_at_edge(state, x), |_| false)?;
        let (d, n) = self.toward_edge(state, &x);
        let (length, _) = self.length_to_edge(state, &d, &n)?;
        self.jump(state, d * length, n)
    }

    /// Jump with its excess; `None` if it counts as infinitesimal.
    fn jump(&self, state: &Response, a: Vector3<f64>, n: Vector3<f64>) -> Option<Jump> {
        let is_finite = a.norm() >= INFINITESIMAL_AMPLITUDE;
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
            collapses: after.determinant() < COLLAPSE_VOLUME_RATIO * state.deformation.jacobian(),
        })
    }

    /// Rounding error of a scaled excess: a thousand units in the last place of the energies that are subtracted.
    fn rounding(state: &Response, a: &Vector3<f64>, n: &Vector3<f64>) -> f64 {
        let work = a.dot(&(state.first_piola * n));
        let energies = 2.0 * state.energy.abs() + 2.0 * work.abs();
        2e3 * f64::EPSILON * energies / a.norm_squared()
    }
}

/// Reflection that reverses one axis.
fn reflection(axis: usize) -> Matrix3<f64> {
    let sign = |i: usize| if i == axis { -1.0 } else { 1.0 };
    Matrix3::from_diagonal(&Vector3::from_fn(|i, _| sign(i)))
}

/// Joins amplitude and normal to one vector.
fn joined(a: &Vector3<f64>, n: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(a[0], a[1], a[2], n[0], n[1], n[2])
}

/// Splits a vector into amplitude and normal.
fn parts(variables: &Vector6<f64>) -> (Vector3<f64>, Vector3<f64>) {
    (
        variables.fixed_rows::<3>(0).into(),
        variables.fixed_rows::<3>(3).into(),
    )
}

/// Minimizes a function by a quasi-Newton method (`BFGS`). Returns `None` if the function is not defined at the start, or as soon as `is_over` holds.
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
    for _ in 0..DESCENT_ITERATIONS {
        let mut step = -(inverse * gradient);
        if step.dot(&gradient) >= 0.0 || !step.norm().is_finite() {
            inverse = steepest(&gradient);
            step = -(inverse * gradient);
            fresh = true;
        }
        // A jump that raises the energy need not be computed more accurately.
        if !fresh && value > 0.0 && -step.dot(&gradient) <= DESCENT_DECREASE * value {
            break;
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

/// Fraction of a step that is admissible and decreases the function, with the function value there.
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

/// Stretch `|F^T g|` along `g`, which is a principal stretch if `g` is a principal axis.
fn stretch_along(f: Matrix3<f64>, g: &Vector3<f64>) -> f64 {
    (f.transpose() * g).norm()
}

/// Ratio of the volumes after and before a jump, as a function of a free number, with its derivative: the number itself above 1/2, and below 1/2 an
/// exponential that tends to [`SMALLEST_VOLUME_RATIO`].
fn volume_after(x: f64) -> (f64, f64) {
    if x >= 0.5 {
        return (x, 1.0);
    }
    let span = 0.5 - SMALLEST_VOLUME_RATIO;
    let slope = ((x - 0.5) / span).exp();
    (SMALLEST_VOLUME_RATIO + span * slope, slope)
}

/// Free number of a volume ratio: the inverse of [`volume_after`].
fn free_volume(volume: f64) -> f64 {
    if volume >= 0.5 {
        return volume;
    }
    let span = 0.5 - SMALLEST_VOLUME_RATIO;
    let part = ((volume - SMALLEST_VOLUME_RATIO) / span).max(f64::MIN_POSITIVE);
    0.5 + span * part.ln()
}

/// Largest eigenvalue of `F^T F`, a root of its characteristic polynomial in trigonometric form.
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
