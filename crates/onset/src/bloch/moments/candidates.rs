//! Selection of a few wave vectors such that, for any tangent, at least one of them lies in the well of the extreme.
//!
//! With `w_JL = g_i A_iJkL g_k`, `min lambda(A : H) = min_g min_H w(g) : H`. For each polarization `g` this is a linear function of `H`, which is
//! minimized at an extreme point of the set of all `H(k)`. Each region of the zone keeps enough of these points that one of them lies close to the
//! extreme for every sampled direction `w`.

use super::sums::{Polynomial, Sums};
use crate::algebra::Each;
use crate::lattice::{BravaisLattice, BrillouinZone, WaveGrid};
use nalgebra::SVector;
use pulp::{Arch, NullaryFnOnce};
use std::collections::BTreeSet;
use std::f64::consts::TAU;

/// Number of directions `w`, spread evenly over the sphere.
const EVEN_DIRECTIONS: usize = 3000;
/// Number of angles of the directions `n (x) n + r m (x) m`, `m` normal to `n`. They belong to soft modes, which evenly spread directions sample too
/// coarsely.
const SOFT_ANGLES: usize = 48;
/// Ratios `r` of the directions of soft modes.
const SOFT_RATIOS: [f64; 6] = [0.0, 1e-3, 1e-2, 0.1, -1e-2, -0.1];
/// Largest relative distance of a kept point from the extreme.
const EXTREME_TOLERANCE: f64 = 3e-4;
/// Additional distance of a kept point, as a fraction of the largest moment.
const MOMENT_TOLERANCE: f64 = 1e-6;
/// Additional distance in a valley of nearly zero energy, as a fraction of the largest moment. In such a valley the depth is a poor measure of the
/// height of grid points above the bottom.
const VALLEY_MOMENT_TOLERANCE: f64 = 2e-4;
/// Largest value in a valley, as a fraction of the largest moment.
const VALLEY_VALUE_RATIO: f64 = 1e-5;
/// Radius of a region as a phase; wells are usually wider.
const REGION_PHASE: f64 = 0.55;
/// Relative tolerance for symmetric images: smaller differences of values, relative to the largest moment, are rounding errors.
const IMAGE_TOLERANCE: f64 = 1e-10;

/// Largest height of a point above the lowest value at which a descent can still lead lower. `scale` is the largest value.
pub(super) fn margin(lowest: f64, scale: f64) -> f64 {
    let soft = if lowest.abs() < VALLEY_VALUE_RATIO * scale {
        VALLEY_MOMENT_TOLERANCE
    } else {
        MOMENT_TOLERANCE
    };
    EXTREME_TOLERANCE * lowest.abs() + soft * scale
}

/// Upper bound of the margin for all lower values: fraction of the value, and of the largest moment.
pub(super) const WIDEST_MARGIN: [f64; 2] = [EXTREME_TOLERANCE, VALLEY_MOMENT_TOLERANCE];

/// Candidates, sorted by regions of the zone.
#[derive(Clone, Debug, Default)]
pub(super) struct Candidates<const D: usize> {
    /// Wave vectors, sorted by region.
    pub(super) wave_vectors: Vec<SVector<f64, D>>,
    /// Scaled moments `H_11`, `H_12`, `H_22` at the wave vectors.
    pub(super) moments: Vec<[f64; 3]>,
    /// Phases `k.a_1` and `k.a_2`, from `-pi` to `pi`.
    pub(super) phases: Vec<[f64; 2]>,
    /// Expansions of `H` near the wave vectors, without the factor of the lattice Laplacian.
    pub(super) polynomials: Vec<Polynomial>,
    /// Differences to the equivalent wave vectors in the zone.
    pub(super) shifts: Vec<SVector<f64, D>>,
    /// End index of the candidates of each region.
    pub(super) ends: Vec<usize>,
    /// Largest moment of all points.
    pub(super) scale: f64,
}

impl<const D: usize> Candidates<D> {
    /// Selects the candidates from the scaled moments at half of a grid, except `k = 0`.
    ///
    /// With `mirrored`, only the magnitude of `H_12` and only directions in which it lowers the value are used. This suffices for tangents with the
    /// coordinate axes as mirror axes, for which the sign of `H_12` does not matter.
    pub(super) fn new(
        lattice: &BravaisLattice<D>,
        grid: &WaveGrid<D>,
        sums: &Sums,
        moments: &[[f64; 3]],
        mirrored: bool,
    ) -> Self {
        let count = moments.len();
        let scale = (1..count)
            .flat_map(|n| moments[n])
            .filter(|x| x.is_finite())
            .fold(0.0, |m: f64, x| m.max(x.abs()));
        let column = |e: usize| -> Vec<f64> {
            let entry = |h: &[f64; 3]| if mirrored && e == 1 { h[e].abs() } else { h[e] };
            moments.iter().map(entry).collect()
        };
        let columns = [0, 1, 2].map(column);
        let is_own = own_points(&columns, scale);
        let around: Vec<[usize; 8]> = (0..count)
            .map(|n| neighbors(n, grid.resolution()))
            .collect();
        let phases: Vec<[f64; 2]> = grid
            .wave_vectors()
            .take(count)
            .map(|k| {
                let phases = lattice.vectors().transpose() * k;
                [phases[0], phases[1]]
            })
            .collect();
        let (mut values, mut low) = (vec![0.0; count], Vec::new());
        let mut regions: Vec<(usize, Vec<usize>)> = Vec::new();
        for w in directions(mirrored) {
            let margin = Arch::new().dispatch(Low {
                w,
                columns: &columns,
                scale,
                values: &mut values,
                low: &mut low,
            });
            for n in low.iter().copied() {
                let value = values[n];
                let is_well = is_own[n]
                    && !around[n]
                        .iter()
                        .any(|m| values[*m] < value - IMAGE_TOLERANCE * scale);
                let is_near = |m: &usize| distance(&phases[n], &phases[*m]) < REGION_PHASE;
                let mut kept = regions.iter().flat_map(|(_, members)| members);
                if !is_well || kept.any(|m| values[*m] <= value + margin && is_near(m)) {
                    continue;
                }
                match regions.iter_mut().find(|(center, _)| is_near(center)) {
                    Some((_, members)) => members.push(n),
                    None => regions.push((n, vec![n])),
                }
            }
        }
        // Each point joins the nearest center, so that no two regions share a well.
        let centers: Vec<usize> = regions.iter().map(|(center, _)| *center).collect();
        let members: Vec<usize> = regions.drain(..).flat_map(|(_, members)| members).collect();
        let mut regions = vec![Vec::new(); centers.len()];
        for n in members {
            let apart = |region: &usize| distance(&phases[n], &phases[centers[*region]]);
            let nearest = (0..centers.len()).min_by(|a, b| apart(a).total_cmp(&apart(b)));
            regions[nearest.unwrap_or(0)].push(n);
        }
        let mut kept: Vec<usize> = Vec::new();
        let mut ends = Vec::new();
        for mut members in regions {
            kept.append(&mut members);
            ends.push(kept.len());
        }
        let zone = BrillouinZone::new(*lattice);
        let wave_vectors: Vec<SVector<f64, D>> = kept
            .iter()
            .map(|n| zone.folded(&grid.wave_vector(*n)))
            .collect();
        let shifts = kept
            .iter()
            .zip(&wave_vectors)
            .map(|(n, k)| k - grid.wave_vector(*n));
        Self {
            moments: kept.iter().map(|n| moments[*n]).collect(),
            phases: kept.iter().map(|n| phases[*n]).collect(),
            polynomials: kept.iter().map(|n| sums.near(phases[*n])).collect(),
            shifts: shifts.collect(),
            wave_vectors,
            ends,
            scale,
        }
    }
}

/// Computes the values of all points in a direction and lists the points within the margin above the lowest value. Returns the margin. Vectorized for
/// the instruction set of the machine.
struct Low<'a> {
    w: [f64; 3],
    columns: &'a [Vec<f64>; 3],
    scale: f64,
    values: &'a mut [f64],
    low: &'a mut Vec<usize>,
}

/// Number of values that are compared together.
const COMPARED_VALUES: usize = 8;

impl NullaryFnOnce for Low<'_> {
    type Output = f64;

    #[inline(always)]
    fn call(self) -> f64 {
        let Self {
            w, columns, values, ..
        } = self;
        let count = values.len();
        let [first, second, third] = columns;
        let (first, second, third) = (&first[..count], &second[..count], &third[..count]);
        for n in 0..count {
            values[n] = w[0] * first[n] + w[1] * second[n] + w[2] * third[n];
        }
        // NaN values are ignored.
        let (whole, rest) = values.as_chunks::<COMPARED_VALUES>();
        let mut least = [f64::INFINITY; COMPARED_VALUES];
        for chunk in whole {
            for lane in 0..COMPARED_VALUES {
                least[lane] = match chunk[lane] < least[lane] {
                    true => chunk[lane],
                    false => least[lane],
                };
            }
        }
        let lowest = least
            .iter()
            .chain(rest)
            .copied()
            .fold(f64::INFINITY, f64::min);
        let margin = margin(lowest, self.scale);
        let bound = lowest + margin;
        self.low.clear();
        for (number, chunk) in values.chunks(COMPARED_VALUES).enumerate() {
            if chunk
                .iter()
                .fold(false, |any, value| any | (*value <= bound))
            {
                let own = (0..chunk.len()).filter(|lane| chunk[*lane] <= bound);
                self.low
                    .extend(own.map(|lane| COMPARED_VALUES * number + lane));
            }
        }
        margin
    }
}

/// Returns true for each point whose moments differ from the moments of all earlier points. Other points are images under a symmetry of the lattice.
fn own_points(columns: &[Vec<f64>; 3], scale: f64) -> Vec<bool> {
    let mut known = BTreeSet::new();
    (0..columns[0].len())
        .map(|n| {
            let key = [0, 1, 2].each(|e| columns[e][n] / (IMAGE_TOLERANCE * scale));
            key.iter().all(|x| x.is_finite()) && known.insert(key.each(|x| x.round() as i64))
        })
        .collect()
}

/// Neighbors of a point in half of a grid.
fn neighbors(point: usize, resolution: usize) -> [usize; 8] {
    let n = resolution;
    let (i, j) = (point / n, point % n);
    let steps = [
        (0, 1),
        (0, n - 1),
        (1, 0),
        (1, 1),
        (1, n - 1),
        (n - 1, 0),
        (n - 1, 1),
        (n - 1, n - 1),
    ];
    steps.each(|(down, right)| {
        let (i, j) = ((i + down) % n, (j + right) % n);
        // The other half contains the opposite wave vectors.
        if i > n / 2 {
            (n - i) * n + (n - j) % n
        } else {
            i * n + j
        }
    })
}

/// Phase difference of two wave vectors, modulo sign and reciprocal vectors.
fn distance(a: &[f64; 2], b: &[f64; 2]) -> f64 {
    let square = |x: f64| (x - TAU * (x / TAU).round()).powi(2);
    let difference = square(a[0] - b[0]) + square(a[1] - b[1]);
    let sum = square(a[0] + b[0]) + square(a[1] + b[1]);
    difference.min(sum).sqrt()
}

/// Unit directions `w_11`, `w_12`, `w_22`; with `mirrored`, only directions with `w_12 <= 0`.
fn directions(mirrored: bool) -> impl Iterator<Item = [f64; 3]> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    // A spiral around the axis of `w_12`, so that half of it covers one side.
    let even = move |n: usize| {
        let z = (2.0 * n as f64 + 1.0) / EVEN_DIRECTIONS as f64 - 1.0;
        let (sine, cosine) = (golden * n as f64).sin_cos();
        let radius = (1.0 - z * z).sqrt();
        [radius * cosine, z, radius * sine]
    };
    let soft = |turn: usize, ratio: f64| {
        let (sine, cosine) = (std::f64::consts::PI * turn as f64 / SOFT_ANGLES as f64).sin_cos();
        [
            cosine * cosine + ratio * sine * sine,
            2.0 * (1.0 - ratio) * sine * cosine,
            sine * sine + ratio * cosine * cosine,
        ]
    };
    let special = (0..SOFT_ANGLES)
        .flat_map(move |turn| SOFT_RATIOS.into_iter().map(move |ratio| soft(turn, ratio)));
    special
        .chain((0..EVEN_DIRECTIONS).map(even))
        .filter(move |w| !mirrored || w[1] <= 1e-12)
}
