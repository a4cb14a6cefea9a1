//! The matrix `D(k)` of a planar lattice with inversion centers, where it is real: on a grid over the zone, and with derivatives.
//!
//! The sum over lattice vectors `m a_1 + n a_2` factors, because `exp(i k.R) = exp(i m t_1) exp(i n t_2)` with `t_i = k.a_i`. Summation over `n`
//! first leaves one row for each `m`. The innermost loops run over the four entries, or along a line of the grid, in vector registers.

use super::DynamicalMatrix;
use super::dynamical_matrix::{Expansion, Term};
use crate::algebra::{Each, array_of};
use crate::lattice::WaveGrid;
use nalgebra::{SMatrix, SVector};
use pulp::{Arch, NullaryFnOnce};

/// Entries `D_11`, `D_12`, `D_21`, `D_22` at the points of a [`WaveGrid`] with a first index up to `n / 2`. The others follow from `D(-k) = D(k)`.
pub(super) type PlanarEntries = [Vec<f64>; 4];

/// Force constants `even(R)`, sorted by rows.
#[derive(Clone, Debug)]
pub(super) struct PlanarRows {
    rows: Vec<Row>,
    /// Constant part `D(0) - sum even(R)` of the matrix.
    constant: [f64; 4],
    /// Largest `|n|` of a term.
    reach: usize,
    /// Positions of the sites in lattice coordinates.
    sites: Vec<[f64; 2]>,
    /// Primitive vectors of the lattice.
    vectors: [[f64; 2]; 2],
}

/// Vectors `R` of one site with the same first lattice coordinate.
#[derive(Clone, Debug)]
struct Row {
    site: usize,
    m: i32,
    terms: Vec<(i32, [f64; 4])>,
}

/// Number of multiples of a phase that are tabulated on the stack; longer-ranged matrices are summed without rows.
const TABULATED_MULTIPLES: usize = 32;

impl PlanarRows {
    /// Sorts the terms of a planar, real matrix; `None` for other matrices, and for ranges beyond the tables.
    pub(super) fn new<const D: usize>(
        terms: &[Term<D>],
        sites: &[SVector<f64, D>],
        vectors: &SMatrix<f64, D, D>,
        rigid: &SMatrix<f64, D, D>,
    ) -> Option<Self> {
        if D != 2 {
            return None;
        }
        let mut rows: Vec<Row> = Vec::new();
        let evens = terms.iter().map(|term| term.even);
        let constant = rigid - evens.sum::<SMatrix<f64, D, D>>();
        let mut reach = 0;
        for term in terms {
            let (m, n) = (term.cell[0], term.cell[1]);
            reach = reach.max(m.unsigned_abs()).max(n.unsigned_abs());
            let known = rows
                .iter()
                .rposition(|row| row.site == term.site && row.m == m);
            let row = known.unwrap_or_else(|| {
                rows.push(Row {
                    site: term.site,
                    m,
                    terms: Vec::new(),
                });
                rows.len() - 1
            });
            rows[row].terms.push((n, entries_of(&term.even)));
        }
        let reach = reach as usize;
        (reach < TABULATED_MULTIPLES).then(|| Self {
            rows,
            constant: entries_of(&constant),
            reach,
            sites: sites.iter().map(|site| [site[0], site[1]]).collect(),
            vectors: [0, 1].each(|i| [vectors[(0, i)], vectors[(1, i)]]),
        })
    }

    #[inline(always)]
    fn on_grid<const D: usize>(
        &self,
        grid: &WaveGrid<D>,
        site_vectors: &[SVector<f64, D>],
    ) -> PlanarEntries {
        let n = grid.resolution();
        let lines = n / 2 + 1;
        let mut entries = self.constant.map(|entry| vec![entry; lines * n]);
        let mut sums = vec![0.0; 8 * n];
        let (mut cosines, mut sines) = (vec![0.0; n], vec![0.0; n]);
        for row in &self.rows {
            row.sum_along(grid, &mut sums);
            let phases = (row.site > 0).then(|| grid.site_phases(&site_vectors[row.site]));
            for i in 0..lines {
                let (cosine, sine) = grid.on_circle(i64::from(row.m) * i as i64);
                match &phases {
                    None => {
                        cosines.fill(cosine);
                        sines.fill(sine);
                    }
                    Some(phases) => {
                        let (c, s) = (&phases.0[i * n..][..n], &phases.1[i * n..][..n]);
                        for j in 0..n {
                            cosines[j] = c[j] * cosine - s[j] * sine;
                            sines[j] = c[j] * sine + s[j] * cosine;
                        }
                    }
                }
                for (e, entry) in entries.iter_mut().enumerate() {
                    let line = &mut entry[i * n..][..n];
                    let (real, imaginary) =
                        (&sums[2 * e * n..][..n], &sums[(2 * e + 1) * n..][..n]);
                    let (cosines, sines) = (&cosines[..n], &sines[..n]);
                    for j in 0..n {
                        line[j] += real[j] * cosines[j] - imaginary[j] * sines[j];
                    }
                }
            }
        }
        entries
    }

    /// Value and derivatives, first with respect to `t_1`, `t_2`, then with respect to `k`.
    #[inline(always)]
    fn expansion<const D: usize>(&self, k: &SVector<f64, D>) -> Expansion<f64, D> {
        let [a, b] = self.vectors;
        let t = [a, b].each(|vector| vector[0] * k[0] + vector[1] * k[1]);
        let (first, second) = (turns(t[0], self.reach), turns(t[1], self.reach));
        let turn = |turns: &[[f64; 2]; TABULATED_MULTIPLES], n: i32| {
            let [cosine, sine] = turns[n.unsigned_abs() as usize];
            (cosine, if n < 0 { -sine } else { sine })
        };
        let mut value = self.constant;
        let mut slopes = [[0.0; 4]; 2];
        let mut curvatures = [[0.0; 4]; 3];
        for row in &self.rows {
            let place = self.sites[row.site];
            // Sum `even exp(i n t_2)` and its moments with `n`.
            let (mut re, mut im) = ([[0.0; 4]; 3], [[0.0; 4]; 3]);
            for (n, even) in &row.terms {
                let (cosine, sine) = turn(&second, *n);
                let y = f64::from(*n) + place[1];
                let weights = [1.0, y, y * y];
                for p in 0..3 {
                    let (c, s) = (weights[p] * cosine, weights[p] * sine);
                    for e in 0..4 {
                        re[p][e] += even[e] * c;
                        im[p][e] += even[e] * s;
                    }
                }
            }
            let (mut cosine, mut sine) = turn(&first, row.m);
            if row.site > 0 {
                let (s, c) = (t[0] * place[0] + t[1] * place[1]).sin_cos();
                (cosine, sine) = (cosine * c - sine * s, sine * c + cosine * s);
            }
            let x = f64::from(row.m) + place[0];
            for e in 0..4 {
                let real = |p: usize| re[p][e] * cosine - im[p][e] * sine;
                let imaginary = |p: usize| re[p][e] * sine + im[p][e] * cosine;
                value[e] += real(0);
                slopes[0][e] -= x * imaginary(0);
                slopes[1][e] -= imaginary(1);
                curvatures[0][e] -= x * x * real(0);
                curvatures[1][e] -= x * real(1);
                curvatures[2][e] -= real(2);
            }
        }
        let matrix = |entry: &dyn Fn(usize) -> f64| SMatrix::from_fn(|i, j| entry(2 * i + j));
        Expansion {
            value: matrix(&|e| value[e]),
            gradient: array_of(|p| matrix(&|e| a[p] * slopes[0][e] + b[p] * slopes[1][e])),
            hessian: array_of(|p| {
                array_of(|q| {
                    matrix(&|e| {
                        a[p] * a[q] * curvatures[0][e]
                            + (a[p] * b[q] + b[p] * a[q]) * curvatures[1][e]
                            + b[p] * b[q] * curvatures[2][e]
                    })
                })
            }),
        }
    }
}

impl Row {
    /// Sum `sum_n even exp(i n t_2)` along a line of the grid: real and imaginary parts of the four entries.
    #[inline(always)]
    fn sum_along<const D: usize>(&self, grid: &WaveGrid<D>, sums: &mut [f64]) {
        let length = grid.resolution();
        sums.fill(0.0);
        for (n, even) in &self.terms {
            let (cosines, sines) = grid.turned(*n);
            let (cosines, sines) = (&cosines[..length], &sines[..length]);
            for (e, even) in even.iter().enumerate() {
                let (real, imaginary) = sums[2 * e * length..][..2 * length].split_at_mut(length);
                for j in 0..length {
                    real[j] += even * cosines[j];
                    imaginary[j] += even * sines[j];
                }
            }
        }
    }
}

impl<const D: usize> DynamicalMatrix<D> {
    /// Entries on a grid; `None` unless the matrix is planar and real.
    pub(super) fn planar_entries(&self, grid: &WaveGrid<D>) -> Option<PlanarEntries> {
        let rows = self.planar_rows()?;
        let sites: Vec<SVector<f64, D>> = self
            .sites()
            .iter()
            .map(|site| self.vectors() * site)
            .collect();
        Some(Arch::new().dispatch(OnGrid {
            rows,
            grid,
            sites: &sites,
        }))
    }

    /// `D(k)` with its derivatives; `None` unless the matrix is planar and real.
    ///
    /// Faster than [`DynamicalMatrix::at`], but without its relative accuracy for long waves.
    pub(super) fn planar_expansion(&self, k: &SVector<f64, D>) -> Option<Expansion<f64, D>> {
        let rows = self.planar_rows()?;
        Some(Arch::new().dispatch(ExpansionAt { rows, k }))
    }
}

/// Vectorized evaluation on a grid for the instruction set of the machine. A closure would not be inlined there.
struct OnGrid<'a, const D: usize> {
    rows: &'a PlanarRows,
    grid: &'a WaveGrid<D>,
    sites: &'a [SVector<f64, D>],
}

impl<const D: usize> NullaryFnOnce for OnGrid<'_, D> {
    type Output = PlanarEntries;

    #[inline(always)]
    fn call(self) -> PlanarEntries {
        self.rows.on_grid(self.grid, self.sites)
    }
}

/// Vectorized expansion for the instruction set of the machine.
struct ExpansionAt<'a, const D: usize> {
    rows: &'a PlanarRows,
    k: &'a SVector<f64, D>,
}

impl<const D: usize> NullaryFnOnce for ExpansionAt<'_, D> {
    type Output = Expansion<f64, D>;

    #[inline(always)]
    fn call(self) -> Expansion<f64, D> {
        self.rows.expansion(self.k)
    }
}

/// Table of `cos n t` and `sin n t` for `n` up to the reach.
#[inline(always)]
fn turns(t: f64, reach: usize) -> [[f64; 2]; TABULATED_MULTIPLES] {
    let (sine, cosine) = t.sin_cos();
    let mut turns = [[1.0, 0.0]; TABULATED_MULTIPLES];
    for n in 1..=reach {
        let [c, s] = turns[n - 1];
        turns[n] = [c * cosine - s * sine, c * sine + s * cosine];
    }
    turns
}

/// Entries of a matrix with two rows.
fn entries_of<const D: usize>(matrix: &SMatrix<f64, D, D>) -> [f64; 4] {
    array_of(|e| matrix[(e / 2, e % 2)])
}
