//! Expansions of a sum of cosines at a wave vector and in the limit of long waves along a direction.

use super::patch::{MatrixPatch, Patch};
use super::waves::{Entries, Waves};
use crate::algebra::{Each, array_of};
use crate::real::{Interval, Real};

/// Moments of a sum of cosines that all expansions use.
pub(super) struct Expansion<'a> {
    pub(super) waves: &'a Waves,
    /// Vectors `n` of the terms.
    vectors: Vec<[f64; 2]>,
    /// Bounds `sum |C_n| |n|^m`, the largest of all entries, `m = 0 ..= 6`; with `|n| = |n_1| + |n_2|`.
    sizes: [f64; 7],
    /// Second moments `sum C_n n_1^a n_2^b / 2`, `a + b = 2`, indexed by `b`.
    second: [Entries; 3],
    /// Fourth moments `sum C_n n_1^a n_2^b / 24`, `a + b = 4`, indexed by `b`.
    fourth: [Entries; 5],
    /// Relative rounding error of sums over all vectors.
    rounding: f64,
}

/// Box of wave vectors, in phases or in direction and squared length.
#[derive(Clone, Copy, Debug)]
pub(super) enum Region {
    /// Square `|theta_i - center_i| <= half` of phases.
    Phases { center: [f64; 2], half: f64 },
    /// Sector `theta = r (1, s)` on the first chart, `r (s, 1)` on the second; `r^2` and `s` are given by center and half width.
    Rays {
        chart: usize,
        s: (f64, f64),
        r2: (f64, f64),
    },
}

impl<'a> Expansion<'a> {
    pub(super) fn new(waves: &'a Waves) -> Self {
        let mut sizes = [[0.0_f64; 4]; 7];
        let mut second = [[0.0; 4]; 3];
        let mut fourth = [[0.0; 4]; 5];
        let binomial = [1.0, 4.0, 6.0, 4.0, 1.0];
        for term in &waves.terms {
            let n = vector(waves, term.cell, term.site);
            let length = n[0].abs() + n[1].abs();
            for e in 0..4 {
                let c = term.coefficient[e];
                let mut power = c.abs();
                for size in &mut sizes {
                    size[e] += power;
                    power *= length;
                }
                for b in 0..3 {
                    let weight = [0.5, 1.0, 0.5][b];
                    second[b][e] += c * weight * n[0].powi(2 - b as i32) * n[1].powi(b as i32);
                }
                for b in 0..5 {
                    let weight = binomial[b] / 24.0;
                    fourth[b][e] += c * weight * n[0].powi(4 - b as i32) * n[1].powi(b as i32);
                }
            }
        }
        let vectors = waves
            .terms
            .iter()
            .map(|term| vector(waves, term.cell, term.site));
        Self {
            waves,
            vectors: vectors.collect(),
            sizes: sizes.each(|size| size.into_iter().fold(0.0, f64::max) * (1.0 + 1e-9)),
            second,
            fourth,
            rounding: (16 * waves.reach + waves.terms.len() + 64) as f64 * f64::EPSILON,
        }
    }

    pub(super) fn is_finite(&self) -> bool {
        self.sizes[6].is_finite()
            && self.waves.error.is_finite()
            && self.waves.long_error.is_finite()
    }

    /// Bound of the remainder beyond fourth order for `|theta|_max = r`: `r^6` times this number, or `r^4` times this number in units of `r^2`.
    pub(super) fn sixth(&self) -> f64 {
        self.sizes[6] / 720.0
    }

    /// Enclosure of `D - shift L` on a box, in units of `r^2` for rays; `L = sum_i (1 - cos theta_i)`.
    pub(super) fn patch(&self, region: &Region, shift: f64) -> MatrixPatch {
        match *region {
            Region::Phases { center, half } => self.at_phases(center, half, shift),
            Region::Rays { chart, s, r2 } => self.on_rays(chart, s, r2, shift),
        }
    }

    fn at_phases(&self, center: [f64; 2], w: f64, shift: f64) -> MatrixPatch {
        let waves = self.waves;
        let phases = Phases::new(waves, center);
        let mut sums = [[0.0_f64; 4]; 6];
        let half = 0.5 * w * w;
        for (term, n) in waves.terms.iter().zip(&self.vectors) {
            let (cosine, sine) = phases.of(term.cell, term.site);
            let weights = [
                1.0 - cosine,
                n[0] * sine * w,
                n[1] * sine * w,
                n[0] * n[0] * cosine * half,
                2.0 * n[0] * n[1] * cosine * half,
                n[1] * n[1] * cosine * half,
            ];
            for (sum, weight) in sums.iter_mut().zip(weights) {
                for e in 0..4 {
                    sum[e] += weight * term.coefficient[e];
                }
            }
        }
        let sizes = &self.sizes;
        let mut rest = w * w * w * (sizes[3] + 2.0 * shift) / 6.0
            + 2.0
                * self.rounding
                * (sizes[0] + shift + w * (sizes[1] + shift) + w * w * (sizes[2] + shift))
            + 2.0 * waves.error;
        if let Some(rigid) = &waves.rigid {
            for e in 0..4 {
                sums[0][e] += rigid[e].midpoint();
            }
            rest += rigid.iter().map(|entry| entry.radius()).fold(0.0, f64::max);
        }
        for i in 0..waves.dimension {
            let (sine, cosine) = center[i].sin_cos();
            for e in [0, 3] {
                sums[0][e] -= shift * (1.0 - cosine);
                sums[1 + i][e] -= shift * sine * w;
                sums[3 + 2 * i][e] -= shift * cosine * half;
            }
        }
        array_of(|e| Patch {
            value: sums[0][e],
            slope: [sums[1][e], sums[2][e]],
            curvature: [sums[3][e], sums[4][e], sums[5][e]],
            rest,
        })
    }

    /// Enclosure `D / r^2 = Q2(s) - r^2 Q4(s) + rest`, from `1 - cos x = x^2/2 - x^4/24 + rest`, `|rest| <= x^6/720`.
    fn on_rays(&self, chart: usize, s: (f64, f64), r2: (f64, f64), shift: f64) -> MatrixPatch {
        let far = r2.0 + r2.1;
        let rest = far * far * (self.sixth() + 2.0 * shift / 720.0)
            + self.rounding * (self.sizes[2] + shift + far * (self.sizes[4] + shift))
            + self.waves.long_error;
        array_of(|e| {
            let axes = |order: usize, factor: f64, b: usize| {
                let is_axis = b == 0 || (b == order && self.waves.dimension == 2);
                if is_axis && (e == 0 || e == 3) {
                    shift * factor
                } else {
                    0.0
                }
            };
            let second: [f64; 3] = array_of(|b| {
                let b = if chart == 0 { b } else { 2 - b };
                self.second[b][e] - axes(2, 0.5, b)
            });
            let fourth: [f64; 5] = array_of(|b| {
                let b = if chart == 0 { b } else { 4 - b };
                self.fourth[b][e] - axes(4, 1.0 / 24.0, b)
            });
            let long = taylor(&second, s.0, s.1);
            let next = taylor(&fourth, s.0, s.1);
            let beyond = next[3].abs() + next[4].abs();
            Patch {
                value: long[0] - r2.0 * next[0],
                slope: [long[1] - r2.0 * next[1], -r2.1 * next[0]],
                curvature: [long[2] - r2.0 * next[2], -r2.1 * next[1], 0.0],
                rest: rest + far * beyond + r2.1 * next[2].abs(),
            }
        })
    }

    /// Interval enclosure of `D` at given phases, to confirm a witness.
    pub(super) fn confirmed(&self, phases: [f64; 2]) -> [Interval; 4] {
        let waves = self.waves;
        let mut sums = waves.rigid.unwrap_or([Interval::ZERO; 4]);
        for term in &waves.terms {
            let mut angle = Interval::ZERO;
            for i in 0..2 {
                let n = Interval::around(waves.sites[term.site][i], 4) + f64::from(term.cell[i]);
                angle = angle + n * phases[i];
            }
            // 1 - cos x = 2 sin^2(x / 2) is accurate for long waves too.
            let weight = (angle * 0.5).sin().square() * 2.0;
            for e in 0..4 {
                sums[e] = sums[e] + weight * term.coefficient[e];
            }
        }
        let length = phases[0].abs().max(phases[1].abs());
        let error = (2.0 * waves.error).min(waves.long_error * length * length * (1.0 + 1e-9));
        let error = error.next_up();
        sums.each(|sum| sum + Interval::new(-error, error))
    }
}

fn vector(waves: &Waves, cell: [i32; 2], site: usize) -> [f64; 2] {
    [0, 1].each(|i| waves.sites[site][i] + f64::from(cell[i]))
}

/// Coefficients of a polynomial about a center, for an argument in units of a half width.
fn taylor<const N: usize>(coefficients: &[f64; N], center: f64, half: f64) -> [f64; 5] {
    let mut result = [0.0; 5];
    let mut shifted = *coefficients;
    // Repeated synthetic division.
    let mut scale = 1.0;
    for m in 0..N {
        for i in (m..N - 1).rev() {
            shifted[i] += center * shifted[i + 1];
        }
        result[m] = shifted[m] * scale;
        scale *= half;
    }
    result
}

/// Cosines and sines of `n.theta`, computed from powers of the phases of the axes.
struct Phases {
    powers: [Vec<(f64, f64)>; 2],
    sites: Vec<(f64, f64)>,
}

impl Phases {
    fn new(waves: &Waves, center: [f64; 2]) -> Self {
        let powers = center.map(|angle| {
            let (sine, cosine) = angle.sin_cos();
            let mut powers = Vec::with_capacity(waves.reach + 1);
            powers.push((1.0, 0.0));
            for n in 0..waves.reach {
                powers.push(rotated(powers[n], (cosine, sine)));
            }
            powers
        });
        let site = |site: &[f64; 2]| {
            let (sine, cosine) = (site[0] * center[0] + site[1] * center[1]).sin_cos();
            (cosine, sine)
        };
        Self {
            powers,
            sites: waves.sites.iter().map(site).collect(),
        }
    }

    fn of(&self, cell: [i32; 2], site: usize) -> (f64, f64) {
        let power = |axis: usize| {
            let (cosine, sine) = self.powers[axis][cell[axis].unsigned_abs() as usize];
            (cosine, if cell[axis] < 0 { -sine } else { sine })
        };
        let phase = rotated(power(0), power(1));
        if site == 0 {
            phase
        } else {
            rotated(phase, self.sites[site])
        }
    }
}

fn rotated(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0)
}

#[cfg(test)]
mod tests {
    use super::{Expansion, Region};
    use crate::approximation::Approximation;
    use crate::bloch::dynamical_matrix;
    use crate::certificate::points::points;
    use crate::certificate::waves::{Waves, dynamical_waves};
    use crate::kinematics::DeformationGradient;
    use crate::lattice::LatticeKind;
    use crate::material::ModifiedMooneyRivlin;
    use crate::method::{
        Background, CurrentLattice, Frame, KernelMethodChoices, Linearization, Method, SupportSize,
    };
    use crate::quadrature::Quadrature;
    use crate::real::Interval;
    use nalgebra::Vector2;

    /// Methods in which every option of every choice occurs at least once.
    fn methods() -> Vec<Method<2>> {
        use Linearization::{Exact, ExactPlaneWave, FrozenNormalization, Paper, PaperInterpolated};
        let linearizations = [
            Exact,
            Paper,
            ExactPlaneWave,
            PaperInterpolated,
            FrozenNormalization,
        ];
        let approximations = [
            Approximation::Raw,
            Approximation::Shepard,
            Approximation::Mls,
        ];
        let quadratures = [
            Quadrature::Nodal,
            Quadrature::StressPoints,
            Quadrature::StressPointsOnly,
        ];
        let sizes = [
            SupportSize::Fixed,
            SupportSize::Scaled,
            SupportSize::Convected,
        ];
        let choice = |n: usize| KernelMethodChoices {
            lattice: [LatticeKind::Hexagonal, LatticeKind::Square][n % 2],
            linearization: linearizations[n % 5],
            approximation: approximations[n / 2 % 3],
            quadrature: quadratures[n / 5 % 3],
            support_size: sizes[n / 7 % 3],
            current_lattice: [CurrentLattice::Convected, CurrentLattice::Regular][n / 3 % 2],
            background: [Background::Imposed, Background::Interpolated][n / 4 % 2],
            frame: if n.is_multiple_of(11) {
                Frame::Lagrangian
            } else {
                Frame::Eulerian
            },
            support: 1.8 + 0.05 * (n % 13) as f64,
            ..KernelMethodChoices::default()
        };
        (0..120)
            .map(|n| Method::new(choice(n)).expect("a method"))
            .collect()
    }

    fn state() -> DeformationGradient {
        DeformationGradient::plane_strain([[1.07, 0.12], [-0.03, 0.91]], 1.02).expect("a state")
    }

    fn waves(method: &Method<2>) -> Waves {
        let points = points(method, &state()).expect("inversion symmetry");
        dynamical_waves(method, &ModifiedMooneyRivlin::default(), &points)
    }

    #[test]
    fn intervals_contain_the_floating_point_dynamical_matrix_and_are_tight() {
        for method in methods() {
            let matrix = dynamical_matrix(&method, &ModifiedMooneyRivlin::default(), &state());
            let matrix = matrix.expect("finite");
            let waves = waves(&method);
            let expansion = Expansion::new(&waves);
            let vectors = method.lattice().vectors();
            for k in [
                Vector2::new(0.7, -1.9),
                Vector2::new(3.1, 2.2),
                Vector2::new(1e-3, 2e-3),
            ] {
                let phases = vectors.transpose() * k;
                let d = matrix.at(&k);
                let scale = matrix.at(&Vector2::new(1.0, 2.0)).map(|x| x.norm()).amax();
                for (e, entry) in expansion
                    .confirmed([phases[0], phases[1]])
                    .iter()
                    .enumerate()
                {
                    let value = d[(e / 2, e % 2)];
                    let slack = 1e-11 * scale;
                    let near = Interval::new(entry.low - slack, entry.high + slack);
                    assert!(
                        near.contains(value.re),
                        "{entry:?} of {value}: {:?}",
                        method.choices()
                    );
                    assert!(value.im.abs() < slack, "D is real");
                    assert!(
                        entry.width() < 1e-9 * scale,
                        "{entry:?}: {:?}",
                        method.choices()
                    );
                }
            }
        }
    }

    /// Bounds of a patch at a point of its box, with its remainder.
    fn bounds(patch: &super::Patch, x: [f64; 2]) -> Interval {
        let [a, b, c] = patch.curvature;
        let value = patch.value
            + patch.slope[0] * x[0]
            + patch.slope[1] * x[1]
            + a * x[0] * x[0]
            + b * x[0] * x[1]
            + c * x[1] * x[1];
        Interval::new(value - patch.rest, value + patch.rest)
    }

    #[test]
    fn patches_enclose_the_matrix_on_their_whole_box() {
        let corners = [
            [1.0, 1.0],
            [-1.0, 1.0],
            [0.3, -0.8],
            [1.0, -1.0],
            [-0.6, 0.1],
        ];
        for method in methods().into_iter().step_by(7) {
            let waves = waves(&method);
            let expansion = Expansion::new(&waves);
            let shift = 0.37;
            let exact = |phases: [f64; 2]| {
                let laplacian: f64 = phases.iter().map(|x| 2.0 * (0.5 * x).sin().powi(2)).sum();
                let mut entries = expansion.confirmed(phases).map(Interval::midpoint);
                entries[0] -= shift * laplacian;
                entries[3] -= shift * laplacian;
                entries
            };
            for half in [0.02, 0.1, 0.4] {
                let center = [1.7, -0.9];
                let patch = expansion.patch(&Region::Phases { center, half }, shift);
                for x in corners {
                    let there = exact([center[0] + half * x[0], center[1] + half * x[1]]);
                    for e in 0..4 {
                        assert!(
                            bounds(&patch[e], x).contains(there[e]),
                            "{:?}",
                            method.choices()
                        );
                    }
                }
            }
            if waves.rigid.is_some() {
                continue;
            }
            for (chart, half) in [(0, 0.1), (1, 0.3), (0, 0.5)] {
                let (s, r2) = ((0.25, half), (0.01, 0.008));
                let patch = expansion.patch(&Region::Rays { chart, s, r2 }, shift);
                for x in corners {
                    let (along, squared) = (s.0 + s.1 * x[0], r2.0 + r2.1 * x[1]);
                    let r = squared.sqrt();
                    let phases = if chart == 0 {
                        [r, r * along]
                    } else {
                        [r * along, r]
                    };
                    let there = exact(phases).map(|entry| entry / squared);
                    for e in 0..4 {
                        let slack = 1e-10 * there[0].abs();
                        let held = bounds(&patch[e], x);
                        let near = Interval::new(held.low - slack, held.high + slack);
                        assert!(
                            near.contains(there[e]),
                            "chart {chart}: {:?}",
                            method.choices()
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn enclosures_of_volumes_and_places_contain_the_ideal_values() {
        // Each node has a third of the cell, as each of the two centroids does: the Voronoi cells are hexagons.
        let method = Method::<2>::new(KernelMethodChoices::default()).expect("a method");
        let cell = 0.5 * 3.0_f64.sqrt();
        for point in method.quadrature_points() {
            let volume = Interval::around(point.volume, 64);
            assert!(volume.contains(cell / 3.0), "{volume:?}");
        }
    }
}
