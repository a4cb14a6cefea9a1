//! The matrix `D(k)` for force constants with a mirror line: half of the sums at half of the wave vectors.
//!
//! The reflection maps `Phi(R)` to itself except for the signs of `Phi_12` and `Phi_21`, as for an isotropic body stretched along mirror lines of the
//! lattice. Then `D_11` and `D_22` are sums of `cos i u cos j v`, and `D_12` and `D_21` are sums of `sin i u sin j v`, in the phases `u`, `v` along
//! the lines. The symmetry is tested on the force constants themselves, not inferred from lattice, state and material.

use super::dynamical_matrix::{NEGLECTED_CURVATURE, Term};
use crate::algebra::{LARGEST_LANES, Pack};
use crate::lattice::{FILL, Group, HARMONICS, Mirror};
use pulp::Simd;

/// Maximum number of wave vectors that are evaluated simultaneously.
pub(super) const LANES: usize = LARGEST_LANES;
/// Rounding error of force constants, relative to the sum of their magnitudes.
const FORCE_ROUNDING: f64 = 1e-12;

/// Sums of a matrix with a mirror line.
#[derive(Clone, Debug)]
pub(super) struct MirrorSums {
    /// Index of the mirror among the mirrors of the lattice.
    pub(super) number: usize,
    pub(super) mirror: Mirror,
    /// Largest `i` and `j`.
    pub(super) reach: [usize; 2],
    /// Largest `i` for each `j`; it varies because the range of the forces is a circle.
    ends: Vec<usize>,
    /// Factors of `cos i u cos j v` in `D_11`, `D_22` and of `sin i u sin j v` in `D_12`, `D_21`, at `[j][i]` in the order of the entries: plain,
    /// multiplied by `i`, and by `i^2`.
    factors: Vec<[[f64; 4]; 3]>,
}

/// One number for each wave vector.
pub(super) type Lanes = [f64; LANES];

impl MirrorSums {
    /// Computes the sums if the force constants (of `R` and `-R` together) have one of the mirrors and translations are free; otherwise `None`.
    pub(super) fn new<const D: usize>(terms: &[Term<D>], mirrors: &[Mirror]) -> Option<Self> {
        if D != 2 || terms.iter().any(|term| term.site > 0) {
            return None;
        }
        let mut mirrors = mirrors.iter().enumerate();
        mirrors.find_map(|(number, mirror)| Self::with(number, mirror, terms))
    }

    fn with<const D: usize>(number: usize, mirror: &Mirror, terms: &[Term<D>]) -> Option<Self> {
        let mut reach = [0; 2];
        for term in terms {
            let coordinates = mirror.coordinates_of([term.cell[0], term.cell[1]]);
            for axis in 0..2 {
                reach[axis] = reach[axis].max(coordinates[axis].unsigned_abs() as usize);
            }
        }
        if reach[0] > HARMONICS || reach[1] > HARMONICS {
            return None;
        }
        let width = reach[0] + 1;
        let mut factors = vec![[0.0; 4]; width * (reach[1] + 1)];
        // Terms that vanish under reflection.
        let mut rest = factors.clone();
        let mut magnitude = 0.0;
        let mut total = [0.0; 4];
        for term in terms {
            let [i, j] = mirror.coordinates_of([term.cell[0], term.cell[1]]);
            let index = j.unsigned_abs() as usize * width + i.unsigned_abs() as usize;
            // `cos (i u + j v) = cos i u cos j v - sin i u sin j v`.
            let sign = f64::from((i * j).signum());
            for e in 0..4 {
                let even = term.even[(e / 2, e % 2)];
                magnitude += even.abs();
                total[e] += even;
                let is_diagonal = e == 0 || e == 3;
                factors[index][e] += if is_diagonal { even } else { -sign * even };
                rest[index][e] += if is_diagonal { sign * even } else { even };
            }
        }
        let is_rest = |x: &f64| x.abs() <= FORCE_ROUNDING * magnitude;
        let is_symmetric = rest.as_flattened().iter().all(is_rest);
        if !is_symmetric || !is_rest(&total[1]) || !is_rest(&total[2]) {
            return None;
        }
        // Translations are free: `D(0) = 0`.
        factors[0][0] -= total[0];
        factors[0][3] -= total[3];
        let matters = |factor: &f64| factor.abs() > 1e-3 * f64::EPSILON * magnitude;
        let end = |row: &[[f64; 4]]| row.iter().rposition(|own| own.iter().any(matters));
        let ends = factors.chunks(width).map(|row| end(row).unwrap_or(0));
        Some(Self {
            number,
            mirror: *mirror,
            reach,
            ends: ends.collect(),
            factors: factors
                .iter()
                .enumerate()
                .map(|(index, own)| {
                    let i = (index % width) as f64;
                    [1.0, i, i * i].map(|power| own.map(|factor| power * factor))
                })
                .collect(),
        })
    }

    /// Largest multiples of `u` and of `v` that matter: they determine how fast the matrix varies along the mirror lines.
    ///
    /// Larger multiples contribute only a small part of the second derivatives.
    pub(super) fn effective_reach(&self) -> [usize; 2] {
        let width = self.reach[0] + 1;
        let mut weights = [vec![0.0; width], vec![0.0; self.reach[1] + 1]];
        for (index, factors) in self.factors.iter().enumerate() {
            let (i, j) = (index % width, index / width);
            let size = factors[0]
                .iter()
                .fold(0.0, |size, x| f64::max(size, x.abs()));
            weights[0][i] += size * (i * i) as f64;
            weights[1][j] += size * (j * j) as f64;
        }
        weights.map(|weights| {
            let mut allowed = NEGLECTED_CURVATURE * weights.iter().sum::<f64>();
            let last = weights.iter().rposition(|weight| {
                allowed -= weight;
                allowed < 0.0
            });
            last.unwrap_or(1).max(1)
        })
    }

    /// Factors for one `j`, indexed by `i`.
    #[inline(always)]
    fn row(&self, j: usize) -> &[[[f64; 4]; 3]] {
        let width = self.reach[0] + 1;
        &self.factors[j * width..][..width]
    }

    /// Indices `i` of the nonzero factors at `j`.
    #[inline(always)]
    fn indices(&self, j: usize) -> Indices {
        let is_centered = self.mirror.is_centered();
        Indices {
            next: if is_centered { j % 2 } else { 0 },
            step: if is_centered { 2 } else { 1 },
            last: self.ends[j],
        }
    }

    /// Entries of `D` along lines of constant `v`, as sums of multiples of `cos j v` and `sin j v`. Writes the four factors for each `j` and each
    /// group of columns.
    #[inline(always)]
    pub(super) fn rows<S: Simd>(
        &self,
        simd: S,
        [cosines, sines]: [&[Group]; 2],
        rows: &mut [[Group; 4]],
    ) {
        let groups = rows.len() / (self.reach[1] + 1);
        for j in 0..=self.reach[1] {
            let factors = self.row(j);
            for group in 0..groups {
                for part in 0..FILL / S::F64_LANES {
                    let mut sum = [Pack::splat(simd, 0.0); 4];
                    for i in self.indices(j) {
                        let cosine = Pack::of(simd, &cosines[i * groups + group], part);
                        let sine = Pack::of(simd, &sines[i * groups + group], part);
                        let [f11, f12, f21, f22] = &factors[i][0];
                        sum[0] = cosine.times_plus(cosine.constant(*f11), sum[0]);
                        sum[1] = sine.times_plus(sine.constant(*f12), sum[1]);
                        sum[2] = sine.times_plus(sine.constant(*f21), sum[2]);
                        sum[3] = cosine.times_plus(cosine.constant(*f22), sum[3]);
                    }
                    for e in 0..4 {
                        sum[e].write(&mut rows[j * groups + group][e], part);
                    }
                }
            }
        }
    }

    /// `D` with its derivatives with respect to `u` and `v`, at `[derivative][entry]`, from the multiples of both phases.
    #[inline(always)]
    pub(super) fn entries<S: Simd, const COUNT: usize>(
        &self,
        first: &Multiples<S, COUNT>,
        second: &Multiples<S, COUNT>,
    ) -> [[Pack<S>; 4]; 6] {
        let zero = first.sines[0];
        let mut sums = [[zero; 4]; 6];
        for j in 0..=self.reach[1] {
            let factors = self.row(j);
            // Sums over `i` of the value and of the first and second derivative with respect to `u`; common signs are applied at the end.
            let (mut even, mut odd) = ([[zero; 2]; 3], [[zero; 2]; 3]);
            for i in self.indices(j) {
                let (cosine, sine) = (first.cosines[i], first.sines[i]);
                for n in 0..3 {
                    let (c, s) = match n {
                        1 => (sine, cosine),
                        _ => (cosine, sine),
                    };
                    let [f11, f12, f21, f22] = factors[i][n];
                    even[n][0] = c.times_plus(zero.constant(f11), even[n][0]);
                    even[n][1] = c.times_plus(zero.constant(f22), even[n][1]);
                    odd[n][0] = s.times_plus(zero.constant(f12), odd[n][0]);
                    odd[n][1] = s.times_plus(zero.constant(f21), odd[n][1]);
                }
            }
            let (c, s) = (weighted(second.cosines[j], j), weighted(second.sines[j], j));
            for e in 0..2 {
                let diagonal = [
                    (0, c[0]),
                    (1, c[0]),
                    (0, s[1]),
                    (2, c[0]),
                    (1, s[1]),
                    (0, c[2]),
                ];
                let mixed = [
                    (0, s[0]),
                    (1, s[0]),
                    (0, c[1]),
                    (2, s[0]),
                    (1, c[1]),
                    (0, s[2]),
                ];
                for n in 0..6 {
                    let (own, factor) = diagonal[n];
                    sums[n][3 * e] = even[own][e].times_plus(factor, sums[n][3 * e]);
                    let (own, factor) = mixed[n];
                    sums[n][1 + e] = odd[own][e].times_plus(factor, sums[n][1 + e]);
                }
            }
        }
        // Signs of a cosine differentiated once or twice, and of a sine differentiated twice.
        for n in [1, 2, 3, 5] {
            sums[n][0] = -sums[n][0];
            sums[n][3] = -sums[n][3];
        }
        for n in [3, 5] {
            sums[n][1] = -sums[n][1];
            sums[n][2] = -sums[n][2];
        }
        sums
    }
}

/// Products of a number with the zeroth, first and second power of an integer.
#[inline(always)]
fn weighted<S: Simd>(x: Pack<S>, n: usize) -> [Pack<S>; 3] {
    let n = x.constant(n as f64);
    let first = n * x;
    [x, first, n * first]
}

/// Integers in equal steps; used because the iterators of the standard library are not always inlined.
struct Indices {
    next: usize,
    step: usize,
    last: usize,
}

impl Iterator for Indices {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let own = self.next;
        self.next += self.step;
        (own <= self.last).then_some(own)
    }
}

/// Tables of `cos n t` and `sin n t`.
pub(super) struct Multiples<S: Simd, const COUNT: usize> {
    pub(super) cosines: [Pack<S>; COUNT],
    pub(super) sines: [Pack<S>; COUNT],
}

impl<S: Simd, const COUNT: usize> Multiples<S, COUNT> {
    /// Computes the multiples up to `reach` from the sine and cosine of `t`.
    #[inline(always)]
    pub(super) fn of(sine: Pack<S>, cosine: Pack<S>, reach: usize) -> Self {
        let mut multiples = Self {
            cosines: [cosine.constant(1.0); COUNT],
            sines: [sine.constant(0.0); COUNT],
        };
        for n in 1..=reach {
            let (c, s) = (multiples.cosines[n - 1], multiples.sines[n - 1]);
            multiples.cosines[n] = c.times_plus(cosine, -(s * sine));
            multiples.sines[n] = c.times_plus(sine, s * cosine);
        }
        multiples
    }

    /// Computes the multiples for a group of lanes.
    #[inline(always)]
    pub(super) fn of_group(
        simd: S,
        (sines, cosines): &(Lanes, Lanes),
        group: usize,
        reach: usize,
    ) -> Self {
        let sine = Pack::of(simd, sines, group);
        Self::of(sine, Pack::of(simd, cosines, group), reach)
    }

    /// `sin n t` and `cos n t`, also for negative `n`.
    #[inline(always)]
    pub(super) fn turn(&self, n: i32) -> (Pack<S>, Pack<S>) {
        let magnitude = n.unsigned_abs() as usize;
        let (sine, cosine) = (self.sines[magnitude], self.cosines[magnitude]);
        (if n < 0 { -sine } else { sine }, cosine)
    }
}

#[cfg(test)]
mod tests {
    use super::MirrorSums;
    use crate::bloch::{DynamicalMatrix, dynamical_matrix};
    use crate::kinematics::DeformationGradient;
    use crate::material::ModifiedMooneyRivlin;
    use crate::method::{Frame, KernelMethodChoices, Method};

    fn eulerian() -> Method<2> {
        Method::new(KernelMethodChoices {
            frame: Frame::Eulerian,
            ..KernelMethodChoices::default()
        })
        .expect("an admissible method")
    }

    fn at(method: &Method<2>, f: [[f64; 2]; 2]) -> (DynamicalMatrix<2>, Option<MirrorSums>) {
        let state = DeformationGradient::plane_strain(f, 1.0).expect("positive");
        let d = dynamical_matrix(method, &ModifiedMooneyRivlin::default(), &state).expect("finite");
        let sums = d.mirror_sums(method.wave_grids().mirrors());
        (d, sums)
    }

    #[test]
    fn only_states_with_a_mirror_line_have_mirror_sums() {
        let method = eulerian();
        assert!(at(&method, [[1.2, 0.0], [0.0, 0.9]]).1.is_some());
        // A quarter turn exchanges the axes.
        assert!(at(&method, [[0.0, -0.9], [1.2, 0.0]]).1.is_some());
        assert!(at(&method, [[1.2, 1e-6], [0.0, 0.9]]).1.is_none());
        let (sine, cosine) = 0.4_f64.sin_cos();
        // Rotation of the lattice relative to the load.
        let turned = [[1.2 * cosine, -1.2 * sine], [0.9 * sine, 0.9 * cosine]];
        assert!(at(&method, turned).1.is_none());
        // A rotation by a multiple of 30 degrees has a different mirror.
        let (sine, cosine) = (std::f64::consts::PI / 6.0).sin_cos();
        let turned = [[1.2 * cosine, -1.2 * sine], [0.9 * sine, 0.9 * cosine]];
        let (first, other) = (
            at(&method, [[1.2, 0.0], [0.0, 0.9]]).1,
            at(&method, turned).1,
        );
        assert_ne!(first.map(|sums| sums.number), other.map(|sums| sums.number));
    }
}
