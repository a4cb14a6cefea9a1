//! Contraction `D = A : H` for many tangents simultaneously.

use crate::algebra::{LARGEST_LANES, Pack};
use crate::material::PlaneTangent;
use pulp::Simd;

/// Coefficients of `(D_11 + D_22) / 2`, `(D_11 - D_22) / 2` and `D_12` as linear functions of `H_11`, `H_12`, `H_22`, for many tangents.
///
/// One column for each coefficient, padded with zeros to a multiple of [`LARGEST_LANES`].
#[derive(Clone, Debug, Default)]
pub(super) struct Columns {
    coefficients: [[Vec<f64>; 3]; 3],
}

/// Coefficients of one tangent.
pub(super) type Coefficients = [[f64; 3]; 3];

/// Coefficients of a tangent times a factor.
pub(super) fn coefficients(a: &PlaneTangent, factor: f64) -> Coefficients {
    let entry = |i: usize, k: usize| {
        [
            factor * a[2 * i][2 * k],
            factor * a[2 * i][2 * k + 1] + factor * a[2 * i + 1][2 * k],
            factor * a[2 * i + 1][2 * k + 1],
        ]
    };
    let (d11, d12, d22) = (entry(0, 0), entry(0, 1), entry(1, 1));
    let mut result = [[0.0; 3]; 3];
    for e in 0..3 {
        result[0][e] = 0.5 * (d11[e] + d22[e]);
        result[1][e] = 0.5 * (d11[e] - d22[e]);
        result[2][e] = d12[e];
    }
    result
}

/// Returns true if the coordinate axes are mirror axes of the tangent; `D` then depends on `H_12` only through its square.
pub(super) fn is_mirrored([mean, half, mixed]: &Coefficients) -> bool {
    mean[1] == 0.0 && half[1] == 0.0 && mixed[0] == 0.0 && mixed[2] == 0.0
}

impl Columns {
    pub(super) fn new(rows: &[Coefficients]) -> Self {
        let length = rows.len().next_multiple_of(LARGEST_LANES);
        let mut columns = Self::default();
        for (q, triple) in columns.coefficients.iter_mut().enumerate() {
            for (e, column) in triple.iter_mut().enumerate() {
                column.reserve_exact(length);
                column.extend(rows.iter().map(|row| row[q][e]));
                column.resize(length, 0.0);
            }
        }
        columns
    }

    /// Length of a column.
    pub(super) fn length(&self) -> usize {
        self.coefficients[0][0].len()
    }
}

/// Coefficients of one tangent for each lane of a register.
#[derive(Clone, Copy)]
pub(super) struct Contraction<S: Simd, const MIRRORED: bool>([[Pack<S>; 3]; 3]);

impl<S: Simd, const MIRRORED: bool> Contraction<S, MIRRORED> {
    #[inline(always)]
    pub(super) fn of(simd: S, columns: &Columns, group: usize) -> Self {
        let mut packs = [[Pack::splat(simd, 0.0); 3]; 3];
        for q in 0..3 {
            for e in 0..3 {
                packs[q][e] = Pack::of(simd, &columns.coefficients[q][e], group);
            }
        }
        Self(packs)
    }

    /// Components `(D_11 + D_22) / 2`, `(D_11 - D_22) / 2` and `D_12`.
    #[inline(always)]
    pub(super) fn parts(&self, h: [Pack<S>; 3]) -> [Pack<S>; 3] {
        let [mean, half, mixed] = &self.0;
        if MIRRORED {
            return [
                mean[0].times_plus(h[0], mean[2] * h[2]),
                half[0].times_plus(h[0], half[2] * h[2]),
                mixed[1] * h[1],
            ];
        }
        let mut parts = [h[0]; 3];
        for q in 0..3 {
            let c = &self.0[q];
            parts[q] = c[0].times_plus(h[0], c[1].times_plus(h[1], c[2] * h[2]));
        }
        parts
    }

    /// Smaller eigenvalue, or the negative of the larger eigenvalue: `sign * (D_11 + D_22) / 2 - root`.
    #[inline(always)]
    pub(super) fn branch(&self, h: [Pack<S>; 3], sign: Pack<S>) -> Pack<S> {
        let [mean, half, mixed] = self.parts(h);
        let root = half.times_plus(half, mixed * mixed).sqrt();
        mean * sign - root
    }
}
