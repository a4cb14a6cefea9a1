//! `D(k)` where force constants have a mirror line: half as many sums on half of the wave vectors.
//!
//! Where a reflection of the lattice maps `Phi(R)` to itself with the sign of `Phi_12` and `Phi_21` changed, as that of an
//! isotropic body stretched along mirror lines, `D_11` and `D_22` are sums of `cos i u cos j v` and `D_12`, `D_21` of
//! `sin i u sin j v` in the phases `u`, `v` along the lines. That the force constants have the symmetry is read off them;
//! nothing is inferred from lattice, state and law.

use super::dynamical_matrix::{Expansion, Term};
use crate::lattice::{HARMONICS, Mirror};
use nalgebra::Matrix2;
use pulp::{Arch, NullaryFnOnce};

/// Wave vectors whose expansions are computed together.
pub(super) const LANES: usize = 4;
/// Differences of force constants below this fraction of the sum of all are rounding.
const ROUNDING: f64 = 1e-12;

/// The sums of a matrix with a mirror line.
#[derive(Clone, Debug)]
pub(super) struct MirrorSums {
    /// Which of the lattice's mirrors it is.
    pub(super) number: usize,
    pub(super) mirror: Mirror,
    /// Largest `i` and `j`.
    pub(super) reach: [usize; 2],
    /// Factors of `cos i u cos j v` in `D_11`, `D_22` and of `sin i u sin j v` in `D_12`, `D_21`, at `[j][i]`, in the order of
    /// the entries.
    factors: Vec<[f64; 4]>,
}

/// One number a wave vector.
pub(super) type Lanes = [f64; LANES];

/// `D(k)` at several wave vectors with the derivatives by `u`, `v`: value, `u`, `v`, `uu`, `uv`, `vv`.
pub(super) struct LaneExpansions([[Lanes; 4]; 6]);

impl LaneExpansions {
    /// The expansion at one of the wave vectors.
    pub(super) fn of(&self, lane: usize) -> Expansion<f64, 2> {
        let matrix = |n: usize| {
            let [a, b, c, d] = [0, 1, 2, 3].map(|e| self.0[n][e][lane]);
            Matrix2::new(a, b, c, d)
        };
        Expansion {
            value: matrix(0),
            gradient: [matrix(1), matrix(2)],
            hessian: [[matrix(3), matrix(4)], [matrix(4), matrix(5)]],
        }
    }
}

impl MirrorSums {
    /// The sums, if force constants (those of `R` and `-R` together) have one of the mirrors.
    pub(super) fn new<const D: usize>(
        terms: &[Term<D>],
        mirrors: &[Mirror],
        constant: &[f64; 4],
    ) -> Option<Self> {
        if terms.iter().any(|term| term.site > 0) {
            return None;
        }
        let mirrors = mirrors.iter().enumerate();
        mirrors
            .filter_map(|(number, mirror)| Self::with(number, mirror, terms, constant))
            .next()
    }

    fn with<const D: usize>(
        number: usize,
        mirror: &Mirror,
        terms: &[Term<D>],
        constant: &[f64; 4],
    ) -> Option<Self> {
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
        // What reflection would make vanish.
        let mut rest = factors.clone();
        let mut magnitude = 0.0;
        for term in terms {
            let [i, j] = mirror.coordinates_of([term.cell[0], term.cell[1]]);
            let index = j.unsigned_abs() as usize * width + i.unsigned_abs() as usize;
            // cos (i u + j v) = cos i u cos j v - sin i u sin j v.
            let sign = f64::from((i * j).signum());
            let even = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|at| term.even[at]);
            for (e, even) in even.into_iter().enumerate() {
                magnitude += even.abs();
                let (kept, lost) = if e == 0 || e == 3 {
                    (even, sign * even)
                } else {
                    (-sign * even, even)
                };
                factors[index][e] += kept;
                rest[index][e] += lost;
            }
        }
        let is_rest = |x: &f64| x.abs() <= ROUNDING * magnitude;
        if !rest.iter().flatten().all(is_rest) || !is_rest(&constant[1]) || !is_rest(&constant[2]) {
            return None;
        }
        factors[0][0] += constant[0];
        factors[0][3] += constant[3];
        Some(Self {
            number,
            mirror: *mirror,
            reach,
            factors,
        })
    }

    /// The multiples of `u` and of `v` up to which the factors matter to second derivatives, all but a fiftieth: how fast
    /// the matrix varies along the mirror lines.
    pub(super) fn effective_reach(&self) -> [usize; 2] {
        let width = self.reach[0] + 1;
        let mut weights = [vec![0.0; width], vec![0.0; self.reach[1] + 1]];
        for (index, factors) in self.factors.iter().enumerate() {
            let (i, j) = (index % width, index / width);
            let size = factors.iter().fold(0.0, |size, x| f64::max(size, x.abs()));
            weights[0][i] += size * (i * i) as f64;
            weights[1][j] += size * (j * j) as f64;
        }
        weights.map(|weights| {
            let mut allowed = 0.02 * weights.iter().sum::<f64>();
            let last = weights.iter().rposition(|weight| {
                allowed -= weight;
                allowed < 0.0
            });
            last.unwrap_or(1).max(1)
        })
    }

    /// The factors at one `j`, by `i`.
    #[inline(always)]
    fn row(&self, j: usize) -> &[[f64; 4]] {
        let width = self.reach[0] + 1;
        &self.factors[j * width..][..width]
    }

    /// The numbers `i` at which factors with a `j` do not vanish: the first, and the step to the next.
    #[inline(always)]
    fn indices(&self, j: usize) -> std::iter::StepBy<std::ops::RangeInclusive<usize>> {
        if self.mirror.is_centered() {
            (j % 2..=self.reach[0]).step_by(2)
        } else {
            (0..=self.reach[0]).step_by(1)
        }
    }

    /// The entries of `D` along lines of constant `v` as sums of multiples of `cos j v` and `sin j v`: for each `j` the four
    /// factors at all columns.
    #[inline(always)]
    pub(super) fn rows(&self, cosines: &[f64], sines: &[f64], width: usize, rows: &mut [f64]) {
        for j in 0..=self.reach[1] {
            let row = &mut rows[4 * j * width..][..4 * width];
            row.fill(0.0);
            let (d11, rest) = row.split_at_mut(width);
            let (d12, rest) = rest.split_at_mut(width);
            let (d21, d22) = rest.split_at_mut(width);
            let factors = self.row(j);
            for i in self.indices(j) {
                let [f11, f12, f21, f22] = factors[i];
                let (cosines, sines) =
                    (&cosines[i * width..][..width], &sines[i * width..][..width]);
                for n in 0..width {
                    d11[n] += f11 * cosines[n];
                    d22[n] += f22 * cosines[n];
                    d12[n] += f12 * sines[n];
                    d21[n] += f21 * sines[n];
                }
            }
        }
    }

    /// `D` with its derivatives by `u` and `v` at several wave vectors.
    pub(super) fn expansions(&self, u: &Lanes, v: &Lanes) -> LaneExpansions {
        Arch::new().dispatch(ExpansionsAt { sums: self, u, v })
    }

    /// With tables of at least as many multiples as there are.
    #[inline(always)]
    fn expanded<const COUNT: usize>(&self, u: &Lanes, v: &Lanes) -> LaneExpansions {
        let (mut first, mut second) = (Multiples::<COUNT>::none(), Multiples::<COUNT>::none());
        first.fill(u, self.reach[0]);
        second.fill(v, self.reach[1]);
        let mut sums = [[[0.0; LANES]; 4]; 6];
        for j in 0..=self.reach[1] {
            let factors = self.row(j);
            // Sums over i of value, first and second derivatives by u.
            let (mut even, mut odd) = ([[[0.0; LANES]; 2]; 3], [[[0.0; LANES]; 2]; 3]);
            for i in self.indices(j) {
                let [f11, f12, f21, f22] = factors[i];
                let (cosine, sine) = (&first.cosines[i], &first.sines[i]);
                let (n, nn) = (i as f64, (i * i) as f64);
                for l in 0..LANES {
                    let (c, s) = (cosine[l], sine[l]);
                    let (ns, nc, nnc, nns) = (n * s, n * c, nn * c, nn * s);
                    even[0][0][l] += f11 * c;
                    even[0][1][l] += f22 * c;
                    even[1][0][l] -= f11 * ns;
                    even[1][1][l] -= f22 * ns;
                    even[2][0][l] -= f11 * nnc;
                    even[2][1][l] -= f22 * nnc;
                    odd[0][0][l] += f12 * s;
                    odd[0][1][l] += f21 * s;
                    odd[1][0][l] += f12 * nc;
                    odd[1][1][l] += f21 * nc;
                    odd[2][0][l] -= f12 * nns;
                    odd[2][1][l] -= f21 * nns;
                }
            }
            let (cosine, sine) = (&second.cosines[j], &second.sines[j]);
            let (n, nn) = (j as f64, (j * j) as f64);
            for e in 0..2 {
                let (diagonal, mixed) = (3 * e, 1 + e);
                for l in 0..LANES {
                    let (c, s) = (cosine[l], sine[l]);
                    sums[0][diagonal][l] += even[0][e][l] * c;
                    sums[1][diagonal][l] += even[1][e][l] * c;
                    sums[2][diagonal][l] -= even[0][e][l] * (n * s);
                    sums[3][diagonal][l] += even[2][e][l] * c;
                    sums[4][diagonal][l] -= even[1][e][l] * (n * s);
                    sums[5][diagonal][l] -= even[0][e][l] * (nn * c);
                    sums[0][mixed][l] += odd[0][e][l] * s;
                    sums[1][mixed][l] += odd[1][e][l] * s;
                    sums[2][mixed][l] += odd[0][e][l] * (n * c);
                    sums[3][mixed][l] += odd[2][e][l] * s;
                    sums[4][mixed][l] += odd[1][e][l] * (n * c);
                    sums[5][mixed][l] -= odd[0][e][l] * (nn * s);
                }
            }
        }
        LaneExpansions(sums)
    }
}

/// Work for the widest vectors of the machine. (A closure would not be inlined there.)
struct ExpansionsAt<'a> {
    sums: &'a MirrorSums,
    u: &'a Lanes,
    v: &'a Lanes,
}

impl NullaryFnOnce for ExpansionsAt<'_> {
    type Output = LaneExpansions;

    #[inline(always)]
    fn call(self) -> LaneExpansions {
        match self.sums.reach.into_iter().max() {
            Some(0..=7) => self.sums.expanded::<8>(self.u, self.v),
            Some(8..=15) => self.sums.expanded::<16>(self.u, self.v),
            _ => self.sums.expanded::<{ HARMONICS + 1 }>(self.u, self.v),
        }
    }
}

/// `cos n t` and `sin n t`.
struct Multiples<const COUNT: usize> {
    cosines: [Lanes; COUNT],
    sines: [Lanes; COUNT],
}

impl<const COUNT: usize> Multiples<COUNT> {
    #[inline(always)]
    fn none() -> Self {
        Self {
            cosines: [[1.0; LANES]; COUNT],
            sines: [[0.0; LANES]; COUNT],
        }
    }

    #[inline(always)]
    fn fill(&mut self, t: &Lanes, reach: usize) {
        let (mut sine, mut cosine) = ([0.0; LANES], [0.0; LANES]);
        for l in 0..LANES {
            (sine[l], cosine[l]) = t[l].sin_cos();
        }
        for n in 1..=reach {
            let (c, s) = (self.cosines[n - 1], self.sines[n - 1]);
            for l in 0..LANES {
                self.cosines[n][l] = c[l] * cosine[l] - s[l] * sine[l];
                self.sines[n][l] = c[l] * sine[l] + s[l] * cosine[l];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{LANES, MirrorSums};
    use crate::bloch::{DynamicalMatrix, dynamical_matrix};
    use crate::kinematics::DeformationGradient;
    use crate::material::ModifiedMooneyRivlin;
    use crate::method::{Frame, KernelMethodChoices, Method};
    use nalgebra::Vector2;

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
    fn only_states_that_keep_a_mirror_line_have_the_sums() {
        let method = eulerian();
        assert!(at(&method, [[1.2, 0.0], [0.0, 0.9]]).1.is_some());
        // A quarter turn exchanges the axes.
        assert!(at(&method, [[0.0, -0.9], [1.2, 0.0]]).1.is_some());
        assert!(at(&method, [[1.2, 1e-6], [0.0, 0.9]]).1.is_none());
        let (sine, cosine) = 0.4_f64.sin_cos();
        // The lattice turned against the load.
        let turned = [[1.2 * cosine, -1.2 * sine], [0.9 * sine, 0.9 * cosine]];
        assert!(at(&method, turned).1.is_none());
        // By a multiple of 30 degrees it has a mirror again, another one.
        let (sine, cosine) = (std::f64::consts::PI / 6.0).sin_cos();
        let turned = [[1.2 * cosine, -1.2 * sine], [0.9 * sine, 0.9 * cosine]];
        let (first, other) = (
            at(&method, [[1.2, 0.0], [0.0, 0.9]]).1,
            at(&method, turned).1,
        );
        assert_ne!(first.map(|sums| sums.number), other.map(|sums| sums.number));
    }

    #[test]
    fn sums_along_the_mirror_lines_are_the_matrix_with_its_derivatives() {
        let method = eulerian();
        let (d, sums) = at(&method, [[1.2, 0.0], [0.0, 0.7]]);
        let sums = sums.expect("a mirror line");
        let (u, v) = ([0.3, -1.2, 2.0, 0.1], [1.1, 0.4, -0.7, 2.9]);
        let expansions = sums.expansions(&u, &v);
        let exact = |u: f64, v: f64| {
            let phases = Vector2::from(sums.mirror.phases([u, v])) / std::f64::consts::TAU;
            d.at(&(method.lattice().reciprocal() * phases))
                .map(|entry| entry.re)
        };
        let h = 1e-4;
        for lane in 0..LANES {
            let (u, v) = (u[lane], v[lane]);
            let expansion = expansions.of(lane);
            assert!((expansion.value - exact(u, v)).amax() < 1e-12);
            let [ahead, behind] = [h, -h].map(|h| exact(u + h, v));
            assert!((expansion.gradient[0] - (ahead - behind) / (2.0 * h)).amax() < 1e-5);
            let second = (ahead + behind - exact(u, v) * 2.0) / (h * h);
            assert!((expansion.hessian[0][0] - second).amax() < 1e-4);
            let [up, down] = [h, -h].map(|h| exact(u, v + h));
            assert!((expansion.gradient[1] - (up - down) / (2.0 * h)).amax() < 1e-5);
            let second = (up + down - exact(u, v) * 2.0) / (h * h);
            assert!((expansion.hessian[1][1] - second).amax() < 1e-4);
            let corner = |a: f64, b: f64| exact(u + a * h, v + b * h);
            let mixed =
                corner(1.0, 1.0) - corner(1.0, -1.0) - corner(-1.0, 1.0) + corner(-1.0, -1.0);
            assert!((expansion.hessian[0][1] - mixed / (4.0 * h * h)).amax() < 1e-4);
        }
    }
}
