//! Lagrangian kernels: what of the dynamical matrix no state changes.
//!
//! Where all quadrature points carry the same deformation, `D(k) = A : H(k)` with the gradient moments
//! `H_JL(k) = 1/m sum_q V_q conj(B_qJ) B_qL`, which know neither material nor state. In the plane, and real, they are a
//! point in three dimensions. The smallest eigenvalue of `A : H` is concave and the largest one convex in `H`, so that
//! only extreme points of the set of all `H(k)` decide either; few points of a grid remain, and Newton's method leads from
//! the best of them to the extreme itself.

use super::branches::Taylor;
use super::dynamical_matrix::Expansion;
use super::search::Objective;
use super::{DynamicalMatrix, ZoneSearch, moment_matrix};
use crate::algebra::Complex;
use crate::continuum::direction;
use crate::kinematics::DeformationGradient;
use crate::lattice::WaveGrid;
use crate::material::PlaneTangent;
use crate::method::{Background, Frame, Method, MethodError};
use nalgebra::{SMatrix, SVector};
use pulp::{Arch, NullaryFnOnce};

/// Grid points per period of the fastest phase.
const DENSITY: usize = 12;
/// Directions in which extreme points are looked for.
const DIRECTIONS: usize = 3000;
/// Directions of long waves in which their minimum is first looked for.
const RAYS: usize = 32;
/// Steps of Newton's method to the minimum over directions.
const TURNS: usize = 12;
/// Candidates this fraction above the best bottom are descended from too.
const RIVAL: f64 = 0.05;
/// The same in a valley of nearly no energy, as a fraction of the stiffness of long waves.
const SOFT: f64 = 1e-4;
/// Descents at most from different candidates.
const DESCENTS: usize = 4;
/// Below this a scaled moment counts as that of a mode without energy.
const ZERO_ENERGY: f64 = 1e-10;

/// The gradient moments of a planar Lagrangian method over the zone.
#[derive(Clone, Debug)]
pub struct GradientMoments<const D: usize> {
    matrix: DynamicalMatrix<D>,
    search: ZoneSearch<D>,
    /// Extreme points of `H(k) / |k|_h^2`.
    scaled: Candidates<D>,
    /// Extreme points of `H(k)`.
    plain: Candidates<D>,
    /// `H(k) / |k|_h^2` for long waves, `h0 + hc cos t + hs sin t` in the doubled angle `t` of `G^1/2 k`.
    long: [[f64; 3]; 3],
    /// Rounding error to expect in the scaled moments of long waves.
    long_noise: f64,
}

/// Wave vectors with the moments `H_11`, `H_12`, `H_22` there.
#[derive(Clone, Debug)]
struct Candidates<const D: usize> {
    wave_vectors: Vec<SVector<f64, D>>,
    moments: [Vec<f64>; 3],
}

/// The extremes of `D(k) = A : H(k)` over the zone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MomentExtremes<const D: usize> {
    /// The smallest `omega^2 / (c^2 |k|_h^2)`, long waves included.
    pub scaled_minimum: f64,
    /// Its wave vector; the unit direction for long waves.
    pub wave_vector: SVector<f64, D>,
    /// Whether it is the limit of long waves.
    pub is_long_wave: bool,
    /// Whether the softest mode has no energy at any state.
    pub has_zero_mode: bool,
    /// The smallest limit of long waves.
    pub long_wave_minimum: f64,
    /// The smallest `omega^2`, zero where none is below. 1/time^2.
    pub lowest: f64,
    /// The largest `omega^2`. 1/time^2.
    pub highest: f64,
    /// Scaled measures of smaller magnitude are zero to rounding.
    pub tolerance: f64,
}

/// The entries `D_11`, `D_12`, `D_22` as linear functions of `H_11`, `H_12`, `H_22`.
#[derive(Clone, Copy)]
struct Contraction([[f64; 3]; 3]);

impl Contraction {
    fn new(a: &PlaneTangent) -> Self {
        let entry = |i: usize, k: usize| {
            [
                a[2 * i][2 * k],
                a[2 * i][2 * k + 1] + a[2 * i + 1][2 * k],
                a[2 * i + 1][2 * k + 1],
            ]
        };
        Self([entry(0, 0), entry(0, 1), entry(1, 1)])
    }

    #[inline(always)]
    fn of(&self, h: [f64; 3]) -> [f64; 3] {
        self.0.map(|c| c[0] * h[0] + c[1] * h[1] + c[2] * h[2])
    }

    fn magnitude(&self) -> f64 {
        self.0
            .iter()
            .flatten()
            .fold(0.0, |m, c| f64::max(m, c.abs()))
    }

    /// The smaller (`sign` -1) or larger eigenvalue.
    #[inline(always)]
    fn eigenvalue(&self, h: [f64; 3], sign: f64) -> f64 {
        let [d11, d12, d22] = self.of(h);
        let half = 0.5 * (d11 - d22);
        0.5 * (d11 + d22) + sign * (half * half + d12 * d12).sqrt()
    }

    /// `D(k)` from `H(k)`.
    fn contracted<const D: usize>(&self, h: &Expansion<f64, D>) -> Expansion<f64, D> {
        let map = |h: &SMatrix<f64, D, D>| {
            let [d11, d12, d22] = self.of([h[(0, 0)], 0.5 * (h[(0, 1)] + h[(1, 0)]), h[(1, 1)]]);
            SMatrix::from_fn(|i, k| [d11, d12, d22][i + k])
        };
        Expansion {
            value: map(&h.value),
            gradient: std::array::from_fn(|a| map(&h.gradient[a])),
            hessian: std::array::from_fn(|a| std::array::from_fn(|b| map(&h.hessian[a][b]))),
        }
    }
}

impl<const D: usize> GradientMoments<D> {
    /// The moments of a method; `None` where `D(k)` is no contraction with one tangent, or not planar and real: Eulerian
    /// kernels, an interpolated background, quadrature points without an inversion center. `speed_squared` is the `c^2`
    /// of the scaled measure.
    ///
    /// # Errors
    /// [`MethodError`] when the method cannot be evaluated.
    pub fn new(method: &Method<D>, speed_squared: f64) -> Result<Option<Self>, MethodError> {
        let discretization = method.discretization();
        if D != 2
            || discretization.frame != Frame::Lagrangian
            || discretization.background != Background::Imposed
        {
            return Ok(None);
        }
        let rest = DeformationGradient::identity();
        let matrix = moment_matrix(method, &rest)?;
        let search = ZoneSearch::new(method, &rest, speed_squared).ok_or(MethodError::NotFinite)?;
        let grid = method
            .wave_grids()
            .grid((DENSITY * matrix.effective_reach().clamp(4, 16)).next_multiple_of(6));
        let Some(entries) = matrix.planar_entries(&grid) else {
            return Ok(None);
        };
        let [h11, h12, _, h22] = &entries;
        let plain = Candidates::extreme(&grid, [h11, h12, h22].map(Vec::clone), |_| 1.0);
        let laplacian = grid.laplacian();
        let scaled = Candidates::extreme(&grid, [h11, h12, h22].map(Vec::clone), |n| {
            1.0 / laplacian[n]
        });
        let stiffness = matrix
            .long_wave_stiffness()
            .with_directions_mapped(method.wave_grids().long_wave_map());
        let along = |t: f64| {
            let direction = direction(t);
            let h = stiffness.acoustic_tensor(&direction);
            [h[(0, 0)], 0.5 * (h[(0, 1)] + h[(1, 0)]), h[(1, 1)]]
        };
        let (east, north, west) = (
            along(0.0),
            along(0.5 * std::f64::consts::PI),
            along(std::f64::consts::PI),
        );
        let long = std::array::from_fn(|e| {
            let mean = 0.5 * (east[e] + west[e]);
            [mean, 0.5 * (east[e] - west[e]), north[e] - mean]
        });
        let long_noise = matrix.long_wave_noise();
        Ok(Some(Self {
            matrix,
            search,
            scaled,
            plain,
            long,
            long_noise,
        }))
    }

    /// The extremes for a material with the given tangent in the plane.
    pub fn extremes(&self, tangent: &PlaneTangent) -> MomentExtremes<D> {
        let contraction = Contraction::new(tangent);
        let speed_squared = self.search.speed_squared();
        let tolerance = 16.0 * contraction.magnitude() * self.long_noise / speed_squared;
        let (t, long) = self.long_wave_minimum(&contraction);
        let long = long / speed_squared;
        let finite = self.finite_minimum(&contraction);
        let highest = -self
            .extreme(&contraction, &self.plain, Objective::Highest)
            .0;
        let (scaled_minimum, wave_vector, is_long_wave) = match finite {
            (value, k) if value < long => (value, k, false),
            _ => {
                let m = direction(t);
                (long, (self.search.long_wave_map() * m).normalize(), true)
            }
        };
        let lowest = if scaled_minimum < -tolerance {
            self.extreme(&contraction, &self.plain, Objective::Lowest)
                .0
                .min(0.0)
        } else {
            0.0
        };
        let has_zero_mode = !is_long_wave && scaled_minimum.abs() <= tolerance && {
            let h = self.matrix.at(&wave_vector);
            let trace =
                (h[(0, 0)] + h[(1, 1)]).re / self.search.reference().laplacian(&wave_vector);
            trace <= ZERO_ENERGY * self.long.iter().map(|h| h[0].abs()).sum::<f64>()
        };
        MomentExtremes {
            scaled_minimum,
            wave_vector,
            is_long_wave,
            has_zero_mode,
            long_wave_minimum: long,
            lowest,
            highest,
            tolerance,
        }
    }

    /// The smallest scaled measure of waves of finite length.
    fn finite_minimum(&self, contraction: &Contraction) -> (f64, SVector<f64, D>) {
        let (value, k) = self.extreme(contraction, &self.scaled, Objective::Scaled);
        (value, self.search.folded(&k))
    }

    /// The best bottom reached from the best candidates.
    fn extreme(
        &self,
        contraction: &Contraction,
        candidates: &Candidates<D>,
        objective: Objective,
    ) -> (f64, SVector<f64, D>) {
        let highest = objective == Objective::Highest;
        let mut values = vec![0.0; candidates.wave_vectors.len()];
        Arch::new().dispatch(Eigenvalues {
            candidates,
            contraction,
            sign: if highest { 1.0 } else { -1.0 },
            values: &mut values,
        });
        let scale = match objective {
            Objective::Highest => -1.0,
            Objective::Scaled => 1.0 / self.search.speed_squared(),
            _ => 1.0,
        };
        let expansion = |k: &SVector<f64, D>| self.expansion(contraction, objective, k);
        let soft = if objective == Objective::Scaled {
            SOFT * contraction.magnitude() * self.long[0][0].abs() * scale
        } else {
            0.0
        };
        let mut best = (f64::INFINITY, SVector::zeros());
        let mut tried: Vec<(f64, SVector<f64, D>)> = Vec::with_capacity(DESCENTS);
        for _ in 0..DESCENTS {
            // A rival that is far above the best will not come below it within its cell of the grid.
            let mut start = (best.0 + RIVAL * best.0.abs() + soft, usize::MAX);
            for (n, value) in values.iter().enumerate() {
                let value = value * scale;
                let is_new = || {
                    let k = &candidates.wave_vectors[n];
                    // Equal values belong to images under the symmetry of the lattice and the state.
                    tried.iter().all(|(other_value, other)| {
                        (value - other_value).abs() > 1e-9 * value.abs() && self.are_apart(k, other)
                    })
                };
                if value < start.0 && is_new() {
                    start = (value, n);
                }
            }
            if start.1 == usize::MAX {
                break;
            }
            let from = candidates.wave_vectors[start.1];
            tried.push((start.0, from));
            let ((value, k), _) = self
                .search
                .newton(&expansion, (start.0, from), f64::INFINITY);
            if value < best.0 {
                best = (value, k);
            }
        }
        (self.exact(contraction, objective, &best.1), best.1)
    }

    fn expansion(
        &self,
        contraction: &Contraction,
        objective: Objective,
        k: &SVector<f64, D>,
    ) -> Option<Taylor<f64, D>> {
        if !self.search.is_sought(objective, k) {
            return None;
        }
        let d = contraction.contracted(&self.matrix.planar_expansion(k)?);
        Some(match objective {
            Objective::Highest => d.branch(1.0).map(|x| -x),
            Objective::Scaled => self.search.scaled(&d.branch(-1.0), k),
            _ => d.branch(-1.0),
        })
    }

    /// The objective with full relative accuracy also for long waves.
    fn exact(&self, contraction: &Contraction, objective: Objective, k: &SVector<f64, D>) -> f64 {
        let h = self.matrix.at(k).map(|entry: Complex| entry.re);
        let h = [h[(0, 0)], 0.5 * (h[(0, 1)] + h[(1, 0)]), h[(1, 1)]];
        match objective {
            Objective::Highest => -contraction.eigenvalue(h, 1.0),
            Objective::Scaled => {
                contraction.eigenvalue(h, -1.0)
                    / (self.search.speed_squared() * self.search.reference().laplacian(k))
            }
            _ => contraction.eigenvalue(h, -1.0),
        }
    }

    /// Whether two wave vectors, and their opposites, are further apart than wells usually are wide.
    fn are_apart(&self, k: &SVector<f64, D>, other: &SVector<f64, D>) -> bool {
        let lattice = self.search.reference();
        let apart = |difference: SVector<f64, D>| {
            // The lattice Laplacian is periodic.
            lattice.laplacian(&difference) * lattice.vectors().column(0).norm_squared() > 0.3
        };
        apart(k - other) && apart(k + other)
    }

    /// The smallest scaled limit of long waves times `c^2`, and the doubled angle of its direction.
    fn long_wave_minimum(&self, contraction: &Contraction) -> (f64, f64) {
        let d = [0, 1, 2].map(|p| contraction.of(self.long.map(|h| h[p])));
        let at = |t: f64| {
            let (sine, cosine) = t.sin_cos();
            let value = |e: usize| d[0][e] + d[1][e] * cosine + d[2][e] * sine;
            let slope = |e: usize| -d[1][e] * sine + d[2][e] * cosine;
            let (x, xs) = ([0, 1, 2].map(value), [0, 1, 2].map(slope));
            let (half, half1) = (0.5 * (x[0] - x[2]), 0.5 * (xs[0] - xs[2]));
            let root = (half * half + x[1] * x[1]).sqrt();
            // Derivatives of h - sqrt(p); each entry obeys f'' = -(f - f0).
            let half2 = 0.5 * (d[0][0] - d[0][2]) - half;
            let mixed2 = d[0][1] - x[1];
            let trace2 = 0.5 * (d[0][0] + d[0][2]) - 0.5 * (x[0] + x[2]);
            let p1 = half * half1 + x[1] * xs[1];
            let p2 = half1 * half1 + half * half2 + xs[1] * xs[1] + x[1] * mixed2;
            let first = 0.5 * (xs[0] + xs[2]) - p1 / root;
            let second = trace2 - p2 / root + p1 * p1 / (root * root * root);
            (0.5 * (x[0] + x[2]) - root, first, second)
        };
        let step = std::f64::consts::TAU / RAYS as f64;
        let sampled: [f64; RAYS] = std::array::from_fn(|n| at(n as f64 * step).0);
        let mut best = (0.0, f64::INFINITY);
        for n in 0..RAYS {
            let (left, right) = (sampled[(n + RAYS - 1) % RAYS], sampled[(n + 1) % RAYS]);
            if sampled[n] > left || sampled[n] > right {
                continue;
            }
            let mut t = n as f64 * step;
            let mut value = sampled[n];
            for _ in 0..TURNS {
                let (_, first, second) = at(t);
                let next = t - first / second;
                let there = at(next).0;
                if !(second > 0.0 && there < value) {
                    break;
                }
                (t, value) = (next, there);
            }
            if value < best.1 {
                best = (t, value);
            }
        }
        best
    }
}

/// Work for the widest vectors of the machine. (A closure would not be inlined there.)
struct Eigenvalues<'a, const D: usize> {
    candidates: &'a Candidates<D>,
    contraction: &'a Contraction,
    sign: f64,
    values: &'a mut [f64],
}

impl<const D: usize> NullaryFnOnce for Eigenvalues<'_, D> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.candidates
            .eigenvalues(self.contraction, self.sign, self.values);
    }
}

impl<const D: usize> Candidates<D> {
    /// The points of half of a grid that are extreme in one of many directions, after scaling each by a factor; and all
    /// the weakest, which lie so close together that directions do not tell them apart.
    fn extreme(
        grid: &WaveGrid<D>,
        mut moments: [Vec<f64>; 3],
        factor: impl Fn(usize) -> f64,
    ) -> Self {
        let count = moments[0].len();
        for (n, factor) in (0..count).map(|n| (n, factor(n))) {
            for moment in &mut moments {
                moment[n] *= factor;
            }
        }
        let mut is_extreme = vec![false; count];
        let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
        for n in 0..DIRECTIONS {
            // Directions on the sphere along a spiral.
            let z = 1.0 - (2.0 * n as f64 + 1.0) / DIRECTIONS as f64;
            let (sine, cosine) = (golden * n as f64).sin_cos();
            let radius = (1.0 - z * z).sqrt();
            let direction = [radius * cosine, radius * sine, z];
            let along = |n: usize| (0..3).map(|e| direction[e] * moments[e][n]).sum::<f64>();
            // At zero there is no wave.
            let farthest = (1..count)
                .map(|n| (along(n), n))
                .filter(|(x, _)| x.is_finite());
            if let Some((_, n)) = farthest.min_by(|a, b| a.0.total_cmp(&b.0)) {
                is_extreme[n] = true;
            }
        }
        let trace = |n: usize| moments[0][n] + moments[2][n];
        let mut by_trace: Vec<usize> = (1..count).filter(|n| trace(*n).is_finite()).collect();
        by_trace.sort_by(|a, b| trace(*a).total_cmp(&trace(*b)));
        for n in by_trace.iter().take(count / 16) {
            is_extreme[*n] = true;
        }
        let kept: Vec<usize> = (1..count).filter(|n| is_extreme[*n]).collect();
        Self {
            wave_vectors: kept.iter().map(|n| grid.wave_vectors()[*n]).collect(),
            moments: moments.map(|moment| kept.iter().map(|n| moment[*n]).collect()),
        }
    }

    #[inline(always)]
    fn eigenvalues(&self, contraction: &Contraction, sign: f64, values: &mut [f64]) {
        let count = values.len();
        let [h11, h12, h22] = &self.moments;
        let (h11, h12, h22) = (&h11[..count], &h12[..count], &h22[..count]);
        for n in 0..count {
            values[n] = contraction.eigenvalue([h11[n], h12[n], h22[n]], sign);
        }
    }
}
