//! Growth rates of the states of a run; states that differ by a rotation or by less than the width of a bin share one evaluation.

use crate::answers::Problem;
use nalgebra::Matrix3;
use onset::cancel::{Scope, checkpoint};
use onset::kinematics::DeformationGradient;
use onset::time_step::{Stepping, WaveParts};
use rayon::prelude::*;
use std::collections::HashMap;

/// Wave vectors along each reciprocal vector of the coarse zone, in one to three dimensions.
const WAVES: [usize; 3] = [48, 12, 6];

/// Waves and rates of one state.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct StateRates {
    /// State without its rotation, at the middle of its bin.
    pub(super) f: DeformationGradient,
    /// Smallest acoustic eigenvalue divided by the largest acoustic eigenvalue of the reference state.
    pub(super) acoustic: f64,
    /// Growth rate of the fastest-growing wave in continuous time, viscosity included; 1/time.
    pub(super) growth: f64,
    /// Reference wave vector of the fastest-growing wave in continuous time; 1/length.
    pub(super) wave: Vec<f64>,
    /// Growth rate of the fastest-growing wave in discrete time, with the steps of the scheme; 1/time.
    pub(super) stepped: Option<f64>,
    /// Largest eigenvalue that limits the step of the infinite lattice; 1/time^2.
    pub(crate) squared: f64,
}

/// Rates of the evaluated states of a run.
pub(crate) struct States<'p> {
    problem: &'p Problem,
    waves: Vec<Vec<f64>>,
    stepping: Option<(Stepping, f64)>,
    /// Width of a bin of the components of the stretch tensor.
    bin: f64,
    known: HashMap<[i32; 6], Option<StateRates>>,
}

/// Wave vectors of a grid over half of the zone, without zero. 1/length.
fn coarse_zone(problem: &Problem) -> Vec<Vec<f64>> {
    let reciprocal = problem.analysis.reciprocal();
    let dimension = reciprocal.len();
    let count = WAVES[dimension - 1] as i64;
    let along = |axis: usize| match axis < dimension {
        true => -(count / 2 - 1)..=count / 2,
        false => 0..=0,
    };
    let mut waves = Vec::new();
    for a in along(0) {
        for b in along(1) {
            for c in along(2) {
                // The first nonzero number is positive: `-k` has the rates of `k`.
                if [a, b, c]
                    .into_iter()
                    .find(|n| *n != 0)
                    .is_none_or(|n| n < 0)
                {
                    let is_edge = [a, b, c].iter().all(|n| *n == 0 || *n == count / 2);
                    if !is_edge || [a, b, c] == [0; 3] {
                        continue;
                    }
                }
                let shares = [a, b, c].map(|n| n as f64 / count as f64);
                let sum = reciprocal.iter().zip(shares).map(|(b, share)| b * share);
                let k: nalgebra::Vector3<f64> = sum.sum();
                waves.push(k.iter().take(dimension).copied().collect());
            }
        }
    }
    waves
}

/// Stretch tensor `U` of `F = R U`; `None` unless `det F` is positive.
pub(crate) fn without_rotation(f: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let is_proper = f.determinant() > 0.0;
    if !is_proper {
        return None;
    }
    let eigen = (f.transpose() * f).symmetric_eigen();
    let roots = Matrix3::from_diagonal(&eigen.eigenvalues.map(f64::sqrt));
    Some(eigen.eigenvectors * roots * eigen.eigenvectors.transpose())
}

impl<'p> States<'p> {
    pub(crate) fn new(problem: &'p Problem, stepping: Option<(Stepping, f64)>, bin: f64) -> Self {
        Self {
            problem,
            waves: coarse_zone(problem),
            stepping,
            bin,
            known: HashMap::new(),
        }
    }

    /// Number of states that were evaluated.
    pub(super) fn len(&self) -> usize {
        self.known.len()
    }

    /// Bin of a stretch tensor.
    pub(super) fn key(&self, u: &Matrix3<f64>) -> [i32; 6] {
        let dimension = self.problem.dimension();
        let number = |i: usize, j: usize| {
            let of = if i == j { 1.0 } else { 0.0 };
            match i < dimension && j < dimension {
                true => ((u[(i, j)] - of) / self.bin).round() as i32,
                false => 0,
            }
        };
        [
            number(0, 0),
            number(1, 1),
            number(2, 2),
            number(0, 1),
            number(0, 2),
            number(1, 2),
        ]
    }

    fn middle(&self, key: &[i32; 6]) -> Matrix3<f64> {
        let [xx, yy, zz, xy, xz, yz] = key.map(|n| f64::from(n) * self.bin);
        Matrix3::identity() + Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
    }

    /// Evaluates the states that have not been evaluated yet.
    pub(super) fn ask(&mut self, keys: impl IntoIterator<Item = [i32; 6]>) {
        let mut new: Vec<[i32; 6]> = keys
            .into_iter()
            .filter(|key| !self.known.contains_key(key))
            .collect();
        new.sort_unstable();
        new.dedup();
        let scope = Scope::current();
        let found: Vec<Option<StateRates>> = new
            .par_iter()
            .map(|key| scope.run(|| self.evaluate(&self.middle(key))))
            .collect();
        self.known.extend(new.into_iter().zip(found));
    }

    /// Rates of a bin; `None` if the law or the method is not defined at its state.
    pub(super) fn of(&self, key: &[i32; 6]) -> Option<&StateRates> {
        self.known.get(key)?.as_ref()
    }

    pub(crate) fn evaluate(&self, u: &Matrix3<f64>) -> Option<StateRates> {
        checkpoint();
        let analysis = &self.problem.analysis;
        let components = std::array::from_fn(|i| std::array::from_fn(|j| u[(i, j)]));
        let f = self
            .problem
            .found(&DeformationGradient::new(components).ok()?);
        let density = self.problem.settings.discretization.density;
        let modulus = density * analysis.speed_squared().ok()?;
        let acoustic = analysis.acoustic_minimum(&f).ok()?.eigenvalue.re / modulus;
        let parts = analysis.parts(&f, &self.waves).ok()?;
        let scheme = self
            .stepping
            .map_or(Stepping::VelocityVerlet, |(own, _)| own);
        let mut rates = StateRates {
            f,
            acoustic,
            growth: f64::NEG_INFINITY,
            wave: Vec::new(),
            stepped: None,
            squared: 0.0,
        };
        // In discrete time the fastest wave is the wave that grows fastest in continuous time, or the wave that limits the time step.
        let mut decisive = [None; 2];
        for (wave, parts) in self.waves.iter().zip(&parts) {
            let (growth, squared) = (parts.growth(), parts.limiting(scheme));
            if !growth.is_finite() {
                return None;
            }
            if growth > rates.growth {
                (rates.growth, rates.wave) = (growth, wave.clone());
                decisive[0] = Some(parts);
            }
            if squared > rates.squared {
                rates.squared = squared;
                decisive[1] = Some(parts);
            }
        }
        if let Some((stepping, step)) = self.stepping {
            let of = |parts: &WaveParts| stepping.rates(parts, step).into_iter().map(|s| s.re);
            let all = decisive.into_iter().flatten().flat_map(of);
            rates.stepped = Some(all.fold(f64::NEG_INFINITY, f64::max));
        }
        Some(rates)
    }
}
