//! `H(k)` and its derivatives at several wave vectors simultaneously, from the exact sums.

use crate::algebra::{Each, LARGEST_LANES, Pack};
use crate::bloch::DynamicalMatrix;
use crate::lattice::BravaisLattice;
use pulp::Simd;

/// Largest multiple of a primitive vector in the tables of phases.
const TABULATED_REACH: usize = 16;
/// Number of table entries, for multiples of both signs and zero.
const TABLE_ENTRIES: usize = 2 * TABULATED_REACH + 1;

/// Sum over pairs of opposite lattice vectors, `H(k) = H(0) + sum even (cos k.R - 1)`.
#[derive(Clone, Debug)]
pub(super) struct Sums {
    terms: Vec<Term>,
    reach: usize,
    /// `H(0)`: zero if translations are free.
    rigid: [f64; 3],
    /// `H(0) - sum even`, the constant part.
    constant: [f64; 3],
    /// Weights `1 / |a_i|^2` of the lattice Laplacian.
    laplacian: [f64; 2],
}

/// Moments of the vectors `R = m a_1 + n a_2` and `-R`.
#[derive(Clone, Debug)]
struct Term {
    /// Indices in the tables of phases.
    places: [usize; 2],
    /// Moments `H_11`, `H_12`, `H_22`.
    even: [f64; 3],
    /// Moments times `m` and `n`.
    slopes: [[f64; 3]; 2],
    /// Moments times `m^2`, `m n` and `n^2`.
    curvatures: [[f64; 3]; 3],
}

/// Cosine and sine of multiples of a phase, starting at the negative end.
type Phases<S> = [[Pack<S>; 2]; TABLE_ENTRIES];

/// Workspace for the phases of both primitive vectors.
pub(super) struct Workspace<S: Simd>([Phases<S>; 2]);

impl<S: Simd> Workspace<S> {
    #[inline(always)]
    pub(super) fn new(simd: S) -> Self {
        Self([[[Pack::splat(simd, 0.0); 2]; TABLE_ENTRIES]; 2])
    }
}

/// A function of the two phases with its first and its second derivatives `11`, `12`, `22`.
#[derive(Clone, Copy)]
pub(super) struct Local<T> {
    pub(super) value: T,
    pub(super) slope: [T; 2],
    pub(super) curvature: [T; 3],
}

/// Degree of a [`Polynomial`].
const DEGREE: usize = 4;
/// Number of coefficients of a [`Polynomial`].
pub(super) const COEFFICIENTS: usize = (DEGREE + 1) * (DEGREE + 2) / 2;

/// Polynomials of fourth order of `H_11`, `H_12`, `H_22` near some phases: coefficients of `d_1^m d_2^n` in the differences, by `n` and then by `m`.
pub(super) type Polynomial = [[f64; COEFFICIENTS]; 3];

/// Polynomials at several points.
pub(super) struct Near<S: Simd> {
    coefficients: [[Pack<S>; COEFFICIENTS]; 3],
    phases: [Pack<S>; 2],
}

impl<S: Simd> Near<S> {
    /// Collects the polynomials of one point for each lane of a register.
    #[inline(always)]
    pub(super) fn of(
        simd: S,
        polynomials: &[Polynomial],
        places: &[usize],
        phases: [Pack<S>; 2],
    ) -> Self {
        let mut coefficients = [[Pack::splat(simd, 0.0); COEFFICIENTS]; 3];
        let is_one = places.iter().all(|place| *place == places[0]);
        for e in 0..3 {
            for n in 0..COEFFICIENTS {
                coefficients[e][n] = if is_one {
                    Pack::splat(simd, polynomials[places[0]][e][n])
                } else {
                    let mut column = [0.0; LARGEST_LANES];
                    for (lane, place) in places.iter().enumerate() {
                        column[lane] = polynomials[*place][e][n];
                    }
                    Pack::of(simd, &column, 0)
                };
            }
        }
        Self {
            coefficients,
            phases,
        }
    }

    /// Moments `H_11`, `H_12`, `H_22` with their derivatives at the points themselves.
    #[inline(always)]
    pub(super) fn local(&self) -> [Local<Pack<S>>; 3] {
        let two = self.phases[0].constant(2.0);
        let mut local = [Local {
            value: two,
            slope: [two; 2],
            curvature: [two; 3],
        }; 3];
        for e in 0..3 {
            let c = &self.coefficients[e];
            // Five coefficients without the second difference, four with its first power, three with its square.
            local[e] = Local {
                value: c[0],
                slope: [c[1], c[DEGREE + 1]],
                curvature: [c[2] * two, c[DEGREE + 2], c[2 * DEGREE + 1] * two],
            };
        }
        local
    }

    /// `H_11`, `H_12`, `H_22` with their derivatives at other phases, by Horner's scheme.
    #[inline(always)]
    pub(super) fn local_at(&self, phases: [Pack<S>; 2]) -> [Local<Pack<S>>; 3] {
        let zero = phases[0].constant(0.0);
        let two = phases[0].constant(2.0);
        let (x, y) = (phases[0] - self.phases[0], phases[1] - self.phases[1]);
        let mut local = [Local {
            value: zero,
            slope: [zero; 2],
            curvature: [zero; 3],
        }; 3];
        for e in 0..3 {
            let Local {
                value,
                slope: [by_x, by_y],
                curvature: [xx, xy, yy],
            } = &mut local[e];
            let mut place = COEFFICIENTS;
            for n in (0..=DEGREE).rev() {
                let (mut row, mut slope, mut curvature) = (zero, zero, zero);
                for _ in 0..=DEGREE - n {
                    place -= 1;
                    curvature = curvature.times_plus(x, slope);
                    slope = slope.times_plus(x, row);
                    row = row.times_plus(x, self.coefficients[e][place]);
                }
                *yy = yy.times_plus(y, *by_y);
                *by_y = by_y.times_plus(y, *value);
                *value = value.times_plus(y, row);
                *xy = xy.times_plus(y, *by_x);
                *by_x = by_x.times_plus(y, slope);
                *xx = xx.times_plus(y, curvature);
            }
            *xx = *xx * two;
            *yy = *yy * two;
        }
        local
    }
}

impl Sums {
    /// Polynomial of fourth order near the given phases.
    pub(super) fn near(&self, phases: [f64; 2]) -> Polynomial {
        let mut polynomial = [[0.0; COEFFICIENTS]; 3];
        for (entry, constant) in polynomial.iter_mut().zip(self.constant) {
            entry[0] = constant;
        }
        for term in &self.terms {
            let [m, n] = term
                .places
                .each(|place| place as f64 - TABULATED_REACH as f64);
            let (sine, cosine) = (m * phases[0] + n * phases[1]).sin_cos();
            let mut place = 0;
            let mut along_second = 1.0;
            for b in 0..=DEGREE {
                let mut factor = along_second;
                for a in 0..=DEGREE - b {
                    let turned = [cosine, -sine, -cosine, sine][(a + b) % 4];
                    for e in 0..3 {
                        polynomial[e][place] += term.even[e] * turned * factor;
                    }
                    factor *= m / (a + 1) as f64;
                    place += 1;
                }
                along_second *= n / (b + 1) as f64;
            }
        }
        polynomial
    }

    /// Lattice Laplacian with its derivatives, at half phases.
    #[inline(always)]
    pub(super) fn laplacian_at<S: Simd>(&self, simd: S, half: [Pack<S>; 2]) -> Local<Pack<S>> {
        self.laplacian_of(simd, doubled(sin_cos(half[0])), doubled(sin_cos(half[1])))
    }

    /// Lattice Laplacian from cosine and sine of both phases.
    #[inline(always)]
    fn laplacian_of<S: Simd>(
        &self,
        simd: S,
        first: [Pack<S>; 2],
        second: [Pack<S>; 2],
    ) -> Local<Pack<S>> {
        let weight = [
            Pack::splat(simd, 2.0 * self.laplacian[0]),
            Pack::splat(simd, 2.0 * self.laplacian[1]),
        ];
        let one = Pack::splat(simd, 1.0);
        Local {
            value: (one - first[0]).times_plus(weight[0], (one - second[0]) * weight[1]),
            slope: [first[1] * weight[0], second[1] * weight[1]],
            curvature: [
                first[0] * weight[0],
                Pack::splat(simd, 0.0),
                second[0] * weight[1],
            ],
        }
    }

    /// Sorts the terms of a matrix of moments.
    ///
    /// `None` unless it is planar and real, its vectors end at lattice points, and its range fits into the tables.
    pub(super) fn new<const D: usize>(
        matrix: &DynamicalMatrix<D>,
        lattice: &BravaisLattice<D>,
    ) -> Option<Self> {
        if D != 2
            || !matrix.is_centrosymmetric()
            || matrix.sites().len() > 1
            || matrix.reach() > TABULATED_REACH
        {
            return None;
        }
        let entries = |m: &nalgebra::SMatrix<f64, D, D>| {
            [m[(0, 0)], 0.5 * (m[(0, 1)] + m[(1, 0)]), m[(1, 1)]]
        };
        let mut constant = entries(matrix.rigid_translation());
        let mut terms = Vec::new();
        for term in matrix.terms() {
            let even = entries(&term.even);
            let cell = [term.cell[0], term.cell[1]];
            let [m, n] = cell.map(f64::from);
            for e in 0..3 {
                constant[e] -= even[e];
            }
            terms.push(Term {
                places: cell.each(|n| (n + TABULATED_REACH as i32) as usize),
                even,
                slopes: [m, n].each(|x| even.each(|value| x * value)),
                curvatures: [m * m, m * n, n * n].each(|x| even.each(|value| x * value)),
            });
        }
        Some(Self {
            terms,
            reach: matrix.reach(),
            rigid: entries(matrix.rigid_translation()),
            constant,
            laplacian: [0, 1].each(|i| 1.0 / lattice.vectors().column(i).norm_squared()),
        })
    }

    /// `H_11`, `H_12`, `H_22` and the lattice Laplacian at half phases `k.a_i / 2`, with full relative accuracy also for long waves.
    #[inline(always)]
    pub(super) fn at<S: Simd>(
        &self,
        simd: S,
        half: [Pack<S>; 2],
        workspace: &mut Workspace<S>,
    ) -> ([Pack<S>; 3], Pack<S>) {
        let (first, second) = (sin_cos(half[0]), sin_cos(half[1]));
        fill(&mut workspace.0[0], first, self.reach);
        fill(&mut workspace.0[1], second, self.reach);
        let mut sums = [Pack::splat(simd, 0.0); 3];
        for term in &self.terms {
            let [c1, s1] = workspace.0[0][term.places[0]];
            let [c2, s2] = workspace.0[1][term.places[1]];
            let sine = s1.times_plus(c2, c1 * s2);
            let square = sine * sine;
            for e in 0..3 {
                sums[e] = square.times_plus(Pack::splat(simd, term.even[e]), sums[e]);
            }
        }
        let two = Pack::splat(simd, -2.0);
        for e in 0..3 {
            sums[e] = sums[e].times_plus(two, Pack::splat(simd, self.rigid[e]));
        }
        let weight = [
            Pack::splat(simd, 4.0 * self.laplacian[0]),
            Pack::splat(simd, 4.0 * self.laplacian[1]),
        ];
        let laplacian =
            (first[1] * first[1]).times_plus(weight[0], second[1] * second[1] * weight[1]);
        (sums, laplacian)
    }

    /// `H_11`, `H_12`, `H_22` and the lattice Laplacian at half phases `k.a_i / 2`, with derivatives with respect to the phases.
    #[inline(always)]
    pub(super) fn local_at<S: Simd>(
        &self,
        simd: S,
        half: [Pack<S>; 2],
        workspace: &mut Workspace<S>,
    ) -> ([Local<Pack<S>>; 3], Local<Pack<S>>) {
        let zero = Pack::splat(simd, 0.0);
        let (first, second) = (doubled(sin_cos(half[0])), doubled(sin_cos(half[1])));
        fill(&mut workspace.0[0], first, self.reach);
        fill(&mut workspace.0[1], second, self.reach);
        let mut sums = [Local {
            value: zero,
            slope: [zero; 2],
            curvature: [zero; 3],
        }; 3];
        for e in 0..3 {
            sums[e].value = Pack::splat(simd, self.constant[e]);
        }
        for term in &self.terms {
            let [c1, s1] = workspace.0[0][term.places[0]];
            let [c2, s2] = workspace.0[1][term.places[1]];
            let cosine = c1.times_plus(c2, -(s1 * s2));
            let sine = s1.times_plus(c2, c1 * s2);
            for e in 0..3 {
                let sum = &mut sums[e];
                sum.value = cosine.times_plus(Pack::splat(simd, term.even[e]), sum.value);
                for a in 0..2 {
                    sum.slope[a] =
                        sine.times_plus(Pack::splat(simd, -term.slopes[a][e]), sum.slope[a]);
                }
                for a in 0..3 {
                    sum.curvature[a] = cosine
                        .times_plus(Pack::splat(simd, -term.curvatures[a][e]), sum.curvature[a]);
                }
            }
        }
        (sums, self.laplacian_of(simd, first, second))
    }
}

/// Cosine and sine of the doubled angle.
#[inline(always)]
fn doubled<S: Simd>([cosine, sine]: [Pack<S>; 2]) -> [Pack<S>; 2] {
    let twice = sine + sine;
    [
        (-twice).times_plus(sine, sine.constant(1.0)),
        twice * cosine,
    ]
}

/// Cosines and sines of all multiples up to `reach`.
#[inline(always)]
fn fill<S: Simd>(phases: &mut Phases<S>, [cosine, sine]: [Pack<S>; 2], reach: usize) {
    let (mut c, mut s) = (cosine.constant(1.0), cosine.constant(0.0));
    phases[TABULATED_REACH] = [c, s];
    for n in 1..=reach {
        (c, s) = (
            c.times_plus(cosine, -(s * sine)),
            s.times_plus(cosine, c * sine),
        );
        phases[TABULATED_REACH + n] = [c, s];
        phases[TABULATED_REACH - n] = [c, -s];
    }
}

/// Largest half phase for the power series of sine and cosine.
pub(super) const LARGEST_HALF_PHASE: f64 = 2.2;

/// `cos x` and `sin x` by power series, for `x` up to the largest half phase. The first omitted term is below rounding.
#[inline(always)]
fn sin_cos<S: Simd>(x: Pack<S>) -> [Pack<S>; 2] {
    let square = x * x;
    let (mut cosine, mut sine) = (x.constant(0.0), x.constant(0.0));
    for n in (0..SERIES_TERMS).rev() {
        cosine = cosine.times_plus(square, x.constant(COSINE[n]));
        sine = sine.times_plus(square, x.constant(SINE[n]));
    }
    [cosine, sine * x]
}

/// Number of terms of the power series.
const SERIES_TERMS: usize = 13;
const COSINE: [f64; SERIES_TERMS] = series(0);
const SINE: [f64; SERIES_TERMS] = series(1);

/// Coefficients `(-1)^n / (2 n + odd)!` of the power series.
const fn series(odd: usize) -> [f64; SERIES_TERMS] {
    let mut coefficients = [1.0; SERIES_TERMS];
    let mut n = 1;
    while n < SERIES_TERMS {
        let last = 2 * n + odd;
        coefficients[n] = -coefficients[n - 1] / ((last * (last - 1)) as f64);
        n += 1;
    }
    coefficients
}
