//! Spectrum of a three-dimensional lattice with inversion centers, where `D(k)` is real, on a grid over the zone.
//!
//! The sum over lattice vectors `l a_1 + m a_2 + n a_3` factors, because `exp(i k.R) = exp(i l t_1) exp(i m t_2) exp(i n t_3)` with `t_i = k.a_i`.
//! Summed over `n`, `m` and `l` in this order, it costs a few operations for each wave vector and entry. Eigenvalues follow in closed form.

use super::DynamicalMatrix;
use super::dynamical_matrix::Term;
use crate::algebra::{Deviator, Each, Zeros, array_of, symmetric_eigen};
use crate::lattice::{WaveGrid, Wedge};
use nalgebra::SMatrix;
use pulp::{Arch, NullaryFnOnce};

/// Smallest ratio of the discriminant to `a^3` at which the closed form keeps enough digits. The ratio is about seven times the squared difference of two
/// eigenvalues, divided by the square of the third.
const SEPARATION_RATIO: f64 = 1e-9;
/// Largest squared antisymmetric part of a matrix that is symmetric to rounding, relative to its squared deviator.
const ASYMMETRY_TOLERANCE: f64 = 1e-28;

/// Entries of a matrix, by rows.
pub(super) type Entries = [f64; 9];

/// Extreme eigenvalues of a real matrix with three rows, and its complex pair.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SpatialSpectrum {
    /// Smallest and largest real part.
    pub(super) lowest: f64,
    pub(super) highest: f64,
    /// Discriminant `a^3 - h^2`, negative if two eigenvalues are complex. A polynomial of degree six in the entries.
    pub(super) discriminant: f64,
    /// Squared imaginary part of the complex pair; zero if all eigenvalues are real.
    pub(super) imaginary_squared: f64,
    /// Real part of the complex pair of eigenvalues.
    pub(super) pair: f64,
    /// Squared norm of the antisymmetric part, an upper bound of all imaginary parts (Bendixson).
    pub(super) asymmetry: f64,
}

impl SpatialSpectrum {
    /// Computes the eigenvalues of a matrix. If eigenvalues of a matrix that is not symmetric are nearly equal, the error is of the order of the square
    /// root of rounding.
    #[inline(always)]
    pub(super) fn of(entries: &Entries) -> Self {
        let deviator = Deviator::of(entries);
        let Deviator { mean, a, h } = deviator;
        let discriminant = deviator.discriminant();
        let axial = [[1, 3], [2, 6], [5, 7]].each(|[i, j]| 0.5 * (entries[i] - entries[j]));
        let asymmetry = axial.iter().map(|x| x * x).sum();
        let is_close = discriminant.abs() <= SEPARATION_RATIO * a.powi(3);
        let outer = if is_close && asymmetry <= ASYMMETRY_TOLERANCE * a {
            let ([lowest, _, highest], _) = symmetric_eigen(&rows(entries));
            Some([lowest, highest])
        } else {
            (discriminant >= 0.0).then(|| deviator.outer())
        };
        if let Some([lowest, highest]) = outer {
            return Self {
                lowest,
                highest,
                discriminant,
                imaginary_squared: 0.0,
                pair: mean,
                asymmetry,
            };
        }
        let cube = h + h.signum() * (-discriminant).sqrt();
        let part = cube.cbrt();
        let real = part + a / part;
        Self {
            lowest: mean + real.min(-0.5 * real),
            highest: mean + real.max(-0.5 * real),
            discriminant,
            imaginary_squared: (3.0 * (0.25 * real * real - a)).max(0.0),
            pair: mean - 0.5 * real,
            asymmetry,
        }
    }
}

/// Force constants `even(R)` of vectors with the same first two lattice coordinates.
struct Row {
    l: i32,
    m: i32,
    terms: Vec<(i32, Entries)>,
}

/// Force constants by rows, and `D(0) - sum even(R)`.
struct Rows {
    rows: Vec<Row>,
    constant: Entries,
}

impl Rows {
    fn new<const D: usize>(terms: &[Term<D>], rigid: &SMatrix<f64, D, D>) -> Self {
        let mut constant = entries_of(rigid);
        let mut rows: Vec<Row> = Vec::new();
        for term in terms {
            let (l, m, n) = (term.cell[0], term.cell[1], term.cell[2]);
            let even = entries_of(&term.even);
            (0..9).for_each(|e| constant[e] -= even[e]);
            // Terms are sorted by their cells.
            match rows.last_mut() {
                Some(row) if row.l == l && row.m == m => row.terms.push((n, even)),
                _ => rows.push(Row {
                    l,
                    m,
                    terms: vec![(n, even)],
                }),
            }
        }
        Self { rows, constant }
    }

    /// Sums over `n` and `m` for each distinct `l`, at `[line of t_2][entry, real and imaginary part][t_3]`.
    #[inline(always)]
    fn planes<const D: usize>(&self, grid: &WaveGrid<D>) -> Vec<(i32, Zeros)> {
        let n = grid.resolution();
        let mut planes: Vec<(i32, Zeros)> = Vec::new();
        let mut sums = vec![0.0; 18 * n];
        for row in &self.rows {
            sums.fill(0.0);
            for (multiple, even) in &row.terms {
                let (cosines, sines) = grid.turned(*multiple);
                let (cosines, sines) = (&cosines[..n], &sines[..n]);
                for (e, even) in even.iter().enumerate() {
                    let (real, imaginary) = sums[2 * e * n..][..2 * n].split_at_mut(n);
                    for j in 0..n {
                        real[j] += even * cosines[j];
                        imaginary[j] += even * sines[j];
                    }
                }
            }
            if planes.last().is_none_or(|(l, _)| *l != row.l) {
                planes.push((row.l, Zeros::new(18 * n * n)));
            }
            let Some((_, plane)) = planes.last_mut() else {
                continue;
            };
            for (i, line) in plane.chunks_exact_mut(18 * n).enumerate() {
                let (cosine, sine) = grid.on_circle(i64::from(row.m) * i as i64);
                for e in 0..9 {
                    let (real, imaginary) = line[2 * e * n..][..2 * n].split_at_mut(n);
                    let (re, im) = sums[2 * e * n..][..2 * n].split_at(n);
                    for j in 0..n {
                        real[j] += re[j] * cosine - im[j] * sine;
                        imaginary[j] += re[j] * sine + im[j] * cosine;
                    }
                }
            }
        }
        planes
    }

    /// Computes one spectrum for each class of symmetric points, at its first point, and at some others.
    #[inline(always)]
    fn on_grid<const D: usize>(&self, grid: &WaveGrid<D>, wedge: &Wedge, found: Found<'_>) {
        let n = grid.resolution();
        let planes = self.planes(grid);
        let mut entries = vec![0.0; 9 * n];
        for (number, own) in wedge.lines.iter().enumerate() {
            let (first, second) = (number / n, number % n);
            let count = own.len();
            for (e, entry) in entries.chunks_exact_mut(n).enumerate() {
                let entry = &mut entry[..count];
                entry.fill(self.constant[e]);
                for (l, plane) in &planes {
                    let (cosine, sine) = grid.on_circle(i64::from(*l) * first as i64);
                    let line = &plane[(18 * second + 2 * e) * n..][..2 * n];
                    let (real, imaginary) = line.split_at(n);
                    let (real, imaginary) = (&real[own.clone()], &imaginary[own.clone()]);
                    for j in 0..count {
                        entry[j] += real[j] * cosine - imaginary[j] * sine;
                    }
                }
            }
            let of = |j: usize| -> Entries { array_of(|e| entries[e * n + j]) };
            for j in 0..count {
                found(number * n + own.start + j, SpatialSpectrum::of(&of(j)));
            }
        }
    }
}

impl<const D: usize> DynamicalMatrix<D> {
    /// Spectra of a real and periodic matrix in three dimensions on a grid.
    ///
    /// The spectra are computed at the points with a first index up to `n / 2` that are not symmetric images of earlier points, and at some others.
    /// The remaining spectra follow from these and from `D(-k) = D(k)`.
    pub(super) fn spatial_spectra(&self, grid: &WaveGrid<D>, wedge: &Wedge, found: Found<'_>) {
        let rows = &Rows::new(self.terms(), self.rigid_translation());
        Arch::new().dispatch(OnGrid {
            rows,
            grid,
            wedge,
            found,
        });
    }
}

/// Callback that receives the spectrum of a point.
type Found<'a> = &'a mut dyn FnMut(usize, SpatialSpectrum);

/// Vectorized evaluation for the instruction set of the machine. It is a struct because a closure would not be inlined.
struct OnGrid<'a, const D: usize> {
    rows: &'a Rows,
    grid: &'a WaveGrid<D>,
    wedge: &'a Wedge,
    found: Found<'a>,
}

impl<const D: usize> NullaryFnOnce for OnGrid<'_, D> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.rows.on_grid(self.grid, self.wedge, self.found);
    }
}

/// Rows of a matrix.
fn rows(entries: &Entries) -> [[f64; 3]; 3] {
    array_of(|i| array_of(|j| entries[3 * i + j]))
}

/// Entries of a matrix with three rows.
fn entries_of<const D: usize>(matrix: &SMatrix<f64, D, D>) -> Entries {
    array_of(|e| matrix[(e / 3, e % 3)])
}

#[cfg(test)]
mod tests {
    use super::SpatialSpectrum;
    use crate::algebra::eigenvalues;
    use crate::bloch::dynamical_matrix::ForceConstants;
    use crate::lattice::{LatticeKind, Reduced, WaveGrids};
    use nalgebra::{Matrix3, Rotation3, Vector3};

    /// Bonds of a simple cubic lattice, and a term that assigns energy to translations, with their common symmetry.
    #[test]
    fn shared_spectra_of_symmetric_waves_agree_with_the_spectrum_of_each_wave() {
        let lattice = LatticeKind::SimpleCubic
            .lattice::<3>(1.0)
            .expect("a lattice");
        let grids = WaveGrids::new(lattice);
        let (n, grid) = (8, grids.grid(8));
        let own = |a: f64, b: f64, c: f64| Matrix3::from_diagonal(&Vector3::new(a, b, c));
        let skew = Matrix3::new(0.0, 0.7, 0.0, -0.4, 0.0, 0.2, 0.3, 0.0, 0.0);
        let turned = Matrix3::new(0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0);
        for (bonds, at_rest, symmetries) in [
            ([own(2.0, 0.3, 0.3); 3], own(0.0, 0.0, 0.0), 48),
            ([own(2.0, 0.3, 0.3); 3], own(0.4, 0.4, 0.4), 48),
            ([own(2.0, 0.3, 0.3); 3], own(0.4, 0.4, 0.5), 16),
            ([own(2.0, 0.3, 0.3); 3], own(0.4, 0.5, 0.6), 8),
            (
                [1.0, 1.1, 1.3].map(|x| own(2.0, 0.3, 0.3) * x),
                own(0.4, 0.4, 0.4),
                8,
            ),
            ([own(2.0, 0.3, 0.3) + skew; 3], own(0.4, 0.4, 0.4), 6),
            ([own(2.0, 0.3, 0.3); 3], own(0.4, 0.4, 0.4) + skew, 2),
        ] {
            let basis = Reduced::of(lattice.vectors()).expect("a basis");
            let mut constants = ForceConstants::new(basis, 1);
            let mut turn = Matrix3::identity();
            for (axis, bond) in bonds.iter().enumerate() {
                let block = -(turn * bond * turn.transpose());
                for sign in [-1, 1] {
                    let mut cell = [0; 3];
                    cell[axis] = sign;
                    constants.add_to(&cell, &block);
                    constants.add_to(&[0; 3], &-block);
                }
                turn = turned * turn;
            }
            constants.add_to(&[0; 3], &at_rest);
            let matrix = constants.finish(&lattice, false);
            let own = matrix.symmetries(grids.symmetries());
            assert_eq!(own.count_ones(), symmetries);
            let wedge = grids.wedge(n, own);
            let mut outer = [0, 1].map(|_| vec![f64::NAN; (n / 2 + 1) * n * n]);
            matrix.spatial_spectra(&grid, &wedge, &mut |point, spectrum| {
                (outer[0][point], outer[1][point]) = (spectrum.lowest, spectrum.highest);
            });
            for values in &mut outer {
                wedge.spread(values);
            }
            assert_eq!(outer[0].len(), grid.half());
            for (point, k) in grid.wave_vectors().take(grid.half()).enumerate() {
                let exact = eigenvalues(&matrix.at(&k), 1e-16).map(|value| value.re);
                // If eigenvalues are equal, the error is of the order of the square root of rounding.
                for (values, exact) in outer.iter().zip([exact[0], exact[2]]) {
                    assert!((values[point] - exact).abs() < 1e-6, "{symmetries} {k}");
                }
            }
        }
    }

    /// Softest waves of nearly incompressible laws: two eigenvalues are small, and their ratio to the third is a ratio of moduli.
    #[test]
    fn nearly_equal_eigenvalues_of_symmetric_matrices_keep_their_digits() {
        let axes = Rotation3::new(Vector3::new(0.3, -0.8, 0.5));
        for soft in [1e-3, 1e-6, 1e-9, 1e-12] {
            for values in [
                [soft, 2.0 * soft, 1.0],
                [soft, soft, 1.0],
                [-1.0, 1.0, 1.0 + soft],
            ] {
                let diagonal = Matrix3::from_diagonal(&Vector3::from(values));
                let matrix = axes.matrix() * diagonal * axes.matrix().transpose();
                let spectrum = SpatialSpectrum::of(&std::array::from_fn(|e| {
                    0.5 * (matrix[(e / 3, e % 3)] + matrix[(e % 3, e / 3)])
                }));
                for (own, exact) in [(spectrum.lowest, values[0]), (spectrum.highest, values[2])] {
                    let error = (own - exact).abs();
                    assert!(error < 4e-15 + 1e-9 * soft, "{values:?}: {error:e}");
                }
            }
        }
    }

    #[test]
    fn closed_forms_agree_with_eigenvalues_including_complex_pairs() {
        let mut state = 7_u64;
        let mut random = || {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        let mut pairs = 0;
        for _ in 0..500 {
            let entries: [f64; 9] = std::array::from_fn(|_| random());
            let mut values = Matrix3::from_row_slice(&entries).complex_eigenvalues();
            values
                .as_mut_slice()
                .sort_by(|a, b| a.re.total_cmp(&b.re).then(a.im.total_cmp(&b.im)));
            let spectrum = SpatialSpectrum::of(&entries);
            assert!((spectrum.lowest - values[0].re).abs() < 1e-7);
            assert!((spectrum.highest - values[2].re).abs() < 1e-7);
            let pair = values.iter().find(|value| value.im > 0.0);
            assert_eq!(spectrum.discriminant < 0.0, pair.is_some());
            if let Some(pair) = pair {
                pairs += 1;
                assert!((spectrum.imaginary_squared.sqrt() - pair.im).abs() < 1e-7);
                assert!((spectrum.pair - pair.re).abs() < 1e-7);
            }
        }
        assert!((100..400).contains(&pairs));
    }
}
