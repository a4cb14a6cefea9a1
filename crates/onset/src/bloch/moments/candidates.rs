//! Few wave vectors among which one lies in the well of the extreme, whatever the tangent.
//!
//! `min lambda(A : H) = min_g min_H w(g) : H` with `w_JL = g_i A_iJkL g_k`: for each polarization `g` a linear function of `H`,
//! which an extreme point of the set of all `H(k)` minimizes. Of those, each region of the zone keeps so many that one of
//! them comes near to the extreme in every direction `w`.

use crate::lattice::{BravaisLattice, BrillouinZone, WaveGrid};
use nalgebra::SVector;

/// Directions `w`, spread evenly over the sphere.
const EVEN: usize = 3000;
/// Directions `n (x) n + r m (x) m`, `m` normal to `n`: of soft modes, where evenly spread ones are too few.
const TURNS: usize = 48;
const RATIOS: [f64; 6] = [0.0, 1e-3, 1e-2, 0.1, -1e-2, -0.1];
/// A kept point comes this near to the extreme, as a fraction of it.
pub(super) const NEAR: f64 = 4e-3;
/// The same in a valley of nearly no energy, as a fraction of the largest moment.
pub(super) const SOFT: f64 = 1e-5;
/// Size of a region as a phase: wells usually are wider.
const REGION: f64 = 0.8;
/// Values that differ by less, relative to the largest moment, belong to images under a symmetry of the lattice.
const IMAGE: f64 = 1e-10;

/// Candidates by regions of the zone.
#[derive(Clone, Debug, Default)]
pub(super) struct Candidates<const D: usize> {
    /// Wave vectors, region by region.
    pub(super) wave_vectors: Vec<SVector<f64, D>>,
    /// `H_11`, `H_12`, `H_22` there, scaled.
    pub(super) moments: Vec<[f64; 3]>,
    /// `k.a_1` and `k.a_2`, from `-pi` to `pi`.
    pub(super) phases: Vec<[f64; 2]>,
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
        moments: &[[f64; 3]],
        mirrored: bool,
    ) -> Self {
        let points: Vec<usize> = (1..moments.len())
            .filter(|n| moments[*n].iter().all(|x| x.is_finite()))
            .collect();
        let seen = |n: usize| {
            let [h11, h12, h22] = moments[n];
            [h11, if mirrored { h12.abs() } else { h12 }, h22]
        };
        let scale = points
            .iter()
            .flat_map(|n| moments[*n])
            .fold(0.0, |m: f64, x| m.max(x.abs()));
        let columns: [Vec<f64>; 3] = [0, 1, 2].map(|e| points.iter().map(|n| seen(*n)[e]).collect());
        let along = |w: &[f64; 3], n: usize| (0..3).map(|e| w[e] * seen(n)[e]).sum::<f64>();
        let mut values = vec![0.0; points.len()];
        let mut kept: Vec<usize> = Vec::new();
        let mut regions: Vec<(usize, Vec<usize>)> = Vec::new();
        for w in directions(mirrored) {
            for (n, value) in values.iter_mut().enumerate() {
                *value = w[0] * columns[0][n] + w[1] * columns[1][n] + w[2] * columns[2][n];
            }
            let lowest = values.iter().copied().fold(f64::INFINITY, f64::min);
            // Of images the first, so that one region has them.
            let first = values
                .iter()
                .position(|value| *value <= lowest + IMAGE * scale);
            let Some(extreme) = first.map(|n| points[n]) else {
                continue;
            };
            let k = &grid.wave_vectors()[extreme];
            let is_home = |region: &&mut (usize, Vec<usize>)| {
                distance(lattice, k, &grid.wave_vectors()[region.0]) < REGION
            };
            match regions.iter_mut().find(is_home) {
                Some((_, members)) => {
                    let near = lowest + NEAR * lowest.abs() + SOFT * scale;
                    if members.iter().all(|n| along(&w, *n) > near) {
                        members.push(extreme);
                    }
                }
                None => regions.push((extreme, vec![extreme])),
            }
        }
        let mut ends = Vec::new();
        for (_, mut members) in regions {
            kept.append(&mut members);
            ends.push(kept.len());
        }
        let zone = BrillouinZone::new(*lattice);
        let wave_vectors: Vec<SVector<f64, D>> = kept
            .iter()
            .map(|n| zone.folded(&grid.wave_vectors()[*n]))
            .collect();
        let phases = kept.iter().map(|n| {
            let phases = lattice.vectors().transpose() * grid.wave_vectors()[*n];
            [phases[0], phases[1]]
        });
        let shifts = kept
            .iter()
            .zip(&wave_vectors)
            .map(|(n, k)| k - grid.wave_vectors()[*n]);
        Self {
            moments: kept.iter().map(|n| moments[*n]).collect(),
            phases: phases.collect(),
            shifts: shifts.collect(),
            wave_vectors,
            ends,
            scale,
        }
    }
}

/// The phase between two wave vectors or their opposites, modulo reciprocal vectors.
fn distance<const D: usize>(
    lattice: &BravaisLattice<D>,
    k: &SVector<f64, D>,
    other: &SVector<f64, D>,
) -> f64 {
    // The lattice Laplacian is periodic.
    let square = lattice
        .laplacian(&(k - other))
        .min(lattice.laplacian(&(k + other)));
    square.sqrt() * lattice.vectors().column(0).norm()
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
