//! Few wave vectors among which one lies in the well of the extreme, whatever the tangent.
//!
//! `min lambda(A : H) = min_g min_H w(g) : H` with `w_JL = g_i A_iJkL g_k`: for each polarization `g` a linear function of `H`,
//! which an extreme point of the set of all `H(k)` minimizes. Of those, each region of the zone keeps so many that one of
//! them comes near to the extreme in every direction `w`.

use super::sums::{Polynomial, Sums};
use crate::algebra::Each;
use crate::lattice::{BravaisLattice, BrillouinZone, WaveGrid};
use nalgebra::SVector;
use pulp::{Arch, NullaryFnOnce};
use std::collections::BTreeSet;
use std::f64::consts::TAU;

/// Directions `w`, spread evenly over the sphere.
const EVEN: usize = 3000;
/// Directions `n (x) n + r m (x) m`, `m` normal to `n`: of soft modes, where evenly spread ones are too few.
const TURNS: usize = 48;
const RATIOS: [f64; 6] = [0.0, 1e-3, 1e-2, 0.1, -1e-2, -0.1];
/// A kept point comes this near to the extreme, as a fraction of it,
const NEAR: f64 = 3e-4;
/// and this, as a fraction of the largest moment,
const FIRM: f64 = 1e-6;
/// or this in a valley of nearly zero energy, whose depth is no measure of how far points of a grid lie above its bottom:
const SOFT: f64 = 2e-4;
/// one with values below this fraction of the largest moment.
const VALLEY: f64 = 1e-5;
/// Size of a region as a phase: wells usually are wider.
const REGION: f64 = 0.55;
/// Values that differ by less, relative to the largest moment, belong to images under a symmetry of the lattice.
const IMAGE: f64 = 1e-10;

/// How far above the lowest value a point may lie from which a descent leads lower still; `scale` is the largest value.
pub(super) fn margin(lowest: f64, scale: f64) -> f64 {
    let soft = if lowest.abs() < VALLEY * scale {
        SOFT
    } else {
        FIRM
    };
    NEAR * lowest.abs() + soft * scale
}

/// An upper bound of that margin for all lower values.
pub(super) const WIDEST_MARGIN: [f64; 2] = [NEAR, SOFT];

/// Candidates by regions of the zone.
#[derive(Clone, Debug, Default)]
pub(super) struct Candidates<const D: usize> {
    /// Wave vectors, region by region.
    pub(super) wave_vectors: Vec<SVector<f64, D>>,
    /// `H_11`, `H_12`, `H_22` there, scaled.
    pub(super) moments: Vec<[f64; 3]>,
    /// `k.a_1` and `k.a_2`, from `-pi` to `pi`.
    pub(super) phases: Vec<[f64; 2]>,
    /// `H` near them, scaled or not: without the lattice Laplacian.
    pub(super) polynomials: Vec<Polynomial>,
    /// From there to the equivalent wave vectors.
    pub(super) shifts: Vec<SVector<f64, D>>,
    /// Where the candidates of each region end.
    pub(super) ends: Vec<usize>,
    /// The largest moment.
    pub(super) scale: f64,
}

impl<const D: usize> Candidates<D> {
    /// Of half of a grid with moments that are scaled already, apart from zero. With `mirrored`, of `H_12` only the magnitude
    /// counts and only directions are asked for in which it lowers the value: those of tangents with the coordinate axes
    /// as mirror axes, for which the sign of `H_12` does not matter.
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
                let is_well =
                    is_own[n] && !around[n].iter().any(|m| values[*m] < value - IMAGE * scale);
                let is_near = |m: &usize| distance(&phases[n], &phases[*m]) < REGION;
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
        // Each to the nearest center, so that two regions do not share a well.
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

/// The values of all points in a direction, and those that are no farther above the lowest than the margin, which is returned. Work for the widest
/// vectors of the machine.
struct Low<'a> {
    w: [f64; 3],
    columns: &'a [Vec<f64>; 3],
    scale: f64,
    values: &'a mut [f64],
    low: &'a mut Vec<usize>,
}

/// Values that are compared at a time.
const ABREAST: usize = 8;

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
        // No number is no value.
        let (whole, rest) = values.as_chunks::<ABREAST>();
        let mut least = [f64::INFINITY; ABREAST];
        for chunk in whole {
            for lane in 0..ABREAST {
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
        for (number, chunk) in values.chunks(ABREAST).enumerate() {
            if chunk
                .iter()
                .fold(false, |any, value| any | (*value <= bound))
            {
                let own = (0..chunk.len()).filter(|lane| chunk[*lane] <= bound);
                self.low.extend(own.map(|lane| ABREAST * number + lane));
            }
        }
        margin
    }
}

/// Whether a point has moments of its own, and not those of a point before, of which it is an image under a symmetry of the
/// lattice.
fn own_points(columns: &[Vec<f64>; 3], scale: f64) -> Vec<bool> {
    let mut known = BTreeSet::new();
    (0..columns[0].len())
        .map(|n| {
            let key = [0, 1, 2].each(|e| columns[e][n] / (IMAGE * scale));
            key.iter().all(|x| x.is_finite()) && known.insert(key.each(|x| x.round() as i64))
        })
        .collect()
}

/// The points around one in half of a grid.
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
        // The other half are the opposite wave vectors.
        if i > n / 2 {
            (n - i) * n + (n - j) % n
        } else {
            i * n + j
        }
    })
}

/// The phase between two wave vectors or their opposites, modulo reciprocal vectors.
fn distance(a: &[f64; 2], b: &[f64; 2]) -> f64 {
    let square = |x: f64| (x - TAU * (x / TAU).round()).powi(2);
    let difference = square(a[0] - b[0]) + square(a[1] - b[1]);
    let sum = square(a[0] + b[0]) + square(a[1] + b[1]);
    difference.min(sum).sqrt()
}

/// Unit directions `w_11`, `w_12`, `w_22`, with `w_12 <= 0` only if mirrored.
fn directions(mirrored: bool) -> impl Iterator<Item = [f64; 3]> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    // Along a spiral around the axis of `w_12`; its half is one side.
    let even = move |n: usize| {
        let z = (2.0 * n as f64 + 1.0) / EVEN as f64 - 1.0;
        let (sine, cosine) = (golden * n as f64).sin_cos();
        let radius = (1.0 - z * z).sqrt();
        [radius * cosine, z, radius * sine]
    };
    let soft = |turn: usize, ratio: f64| {
        let (sine, cosine) = (std::f64::consts::PI * turn as f64 / TURNS as f64).sin_cos();
        [
            cosine * cosine + ratio * sine * sine,
            2.0 * (1.0 - ratio) * sine * cosine,
            sine * sine + ratio * cosine * cosine,
        ]
    };
    let special =
        (0..TURNS).flat_map(move |turn| RATIOS.into_iter().map(move |ratio| soft(turn, ratio)));
    special
        .chain((0..EVEN).map(even))
        .filter(move |w| !mirrored || w[1] <= 1e-12)
}
