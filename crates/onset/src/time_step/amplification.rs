//! Amplification matrices and the largest stable step.

use super::Integrator;
use super::zone::least_over_zone;
use crate::algebra::{Complex, any_eigenvalues};
use crate::bloch::{IsEnded, WaveSystem, ZoneSearch};
use nalgebra::{DMatrix, SVector};

/// Eigenvalues may leave the unit circle by this much: rounding.
const ROUNDING: f64 = 1e-9;
/// Steps, in units of the bound `2 / omega_max` without damping, that are looked at before the first loss is refined.
const STEPS: usize = 24;
/// Halvings of the interval in which a step is lost.
const HALVINGS: usize = 40;

/// The matrices of one wave: `dv/dt = -K u - C v`, `du/dt = T v`, divided by the masses.
#[derive(Clone, Debug)]
pub struct Amplification {
    stiffness: DMatrix<Complex>,
    damping: DMatrix<Complex>,
    drift: DMatrix<Complex>,
}

impl Amplification {
    /// The wave with a wave vector.
    pub fn new<const D: usize>(system: &WaveSystem<D>, k: &SVector<f64, D>) -> Self {
        let n = system.size();
        let inverse = system.mass_at(k).try_inverse();
        let inverse = inverse.unwrap_or_else(|| DMatrix::repeat(n, n, Complex::new(f64::NAN, 0.0)));
        Self {
            stiffness: &inverse * system.stiffness().at(k),
            damping: system
                .damping()
                .map_or_else(|| DMatrix::zeros(n, n), |damping| &inverse * damping.at(k)),
            drift: system
                .drift()
                .map_or_else(|| DMatrix::identity(n, n), |drift| drift.at(k)),
        }
    }

    /// An oscillator without damping, `d^2 u / dt^2 = -omega^2 u`: one wave of many, in the direction of its own mode.
    pub fn oscillator(omega_squared: Complex) -> Self {
        let one = |x| DMatrix::from_element(1, 1, x);
        Self {
            stiffness: one(omega_squared),
            damping: one(Complex::new(0.0, 0.0)),
            drift: one(Complex::new(1.0, 0.0)),
        }
    }

    /// `G(dt)` with `(u, v)' = G (u, v)`; shape `2 n x 2 n`.
    pub fn matrix(&self, integrator: Integrator, step: f64) -> DMatrix<Complex> {
        let n = self.stiffness.nrows();
        let one = DMatrix::<Complex>::identity(n, n);
        let number = |x: f64| Complex::new(x, 0.0);
        let (dt, half) = (number(step), number(0.5 * step));
        let (k, c, t) = (&self.stiffness, &self.damping, &self.drift);
        // Each quantity as a pair of matrices: its dependence on the old u and the old v.
        type Pair = [DMatrix<Complex>; 2];
        let acceleration =
            |u: &Pair, v: &Pair| -> Pair { [0, 1].map(|i| -(k * &u[i]) - c * &v[i]) };
        let sum = |a: &Pair, factor: Complex, b: &Pair| -> Pair {
            [0, 1].map(|i| &a[i] + &b[i] * factor)
        };
        let moved = |v: &Pair| -> Pair { [0, 1].map(|i| t * &v[i]) };
        let u: Pair = [one.clone(), DMatrix::zeros(n, n)];
        let v: Pair = [DMatrix::zeros(n, n), one];
        let (new_u, new_v) = match integrator {
            Integrator::CentralDifferences => {
                let after = sum(&v, dt, &acceleration(&u, &v));
                (sum(&u, dt, &moved(&after)), after)
            }
            Integrator::KickDriftKick => {
                let between = sum(&v, half, &acceleration(&u, &v));
                let new_u = sum(&u, dt, &moved(&between));
                let new_v = sum(&between, half, &acceleration(&new_u, &between));
                (new_u, new_v)
            }
            Integrator::PredictorCorrector => {
                let predicted_v = sum(&v, half, &acceleration(&u, &v));
                let predicted_u = sum(&u, half, &moved(&v));
                let change = acceleration(&predicted_u, &predicted_v);
                let middle = sum(&v, half, &change);
                (sum(&u, dt, &moved(&middle)), sum(&v, dt, &change))
            }
        };
        let mut matrix = DMatrix::zeros(2 * n, 2 * n);
        for (row, pair) in [new_u, new_v].iter().enumerate() {
            for (column, block) in pair.iter().enumerate() {
                matrix
                    .view_mut((row * n, column * n), (n, n))
                    .copy_from(block);
            }
        }
        matrix
    }

    /// The largest modulus of an eigenvalue of `G(dt)`; infinite where the eigenvalue iteration fails.
    pub fn spectral_radius(&self, integrator: Integrator, step: f64) -> f64 {
        let moduli = self.moduli(integrator, step);
        moduli.map_or(f64::INFINITY, |moduli| {
            moduli.into_iter().fold(0.0, f64::max)
        })
    }

    /// The moduli of the eigenvalues of `G(dt)`; `None` where that is not finite.
    fn moduli(&self, integrator: Integrator, step: f64) -> Option<Vec<f64>> {
        // Velocities times the step: a similarity that keeps both halves of the same size.
        let n = self.stiffness.nrows();
        let mut matrix = self.matrix(integrator, step);
        let scale = Complex::new(step, 0.0);
        for i in 0..n {
            for j in 0..n {
                matrix[(i, n + j)] /= scale;
                matrix[(n + i, j)] *= scale;
            }
        }
        let values = any_eigenvalues(&matrix)?.into_iter();
        Some(values.map(|z| z.norm()).collect())
    }

    /// Whether no more solutions of the integrator grow than the linearized equations themselves have, of which the growth rates
    /// are given: a solution that grows anyway bounds no step, one that does not must not.
    fn is_stable(&self, integrator: Integrator, step: f64, growth_rates: &[f64]) -> bool {
        let Some(moduli) = self.moduli(integrator, step) else {
            return false;
        };
        // Near a double eigenvalue rounding moves both by its square root.
        let rounding = ROUNDING.sqrt() * 1e-2;
        let growing = moduli.iter().filter(|modulus| **modulus > 1.0 + rounding);
        // A solution of the integrator may grow somewhat faster than the one that it stands for.
        let grows = |rate: &&f64| **rate * step > 0.5 * rounding;
        growing.count() <= growth_rates.iter().filter(grows).count()
    }
}

/// The largest stable step of an integrator for the waves with one wave vector: the first step at which more eigenvalues of the
/// amplification matrix are outside of the unit circle than solutions of the equations of motion grow. So waves that grow by
/// themselves do not bound it. Infinite for waves that do not oscillate. Time.
pub fn critical_time_step_at<const D: usize>(
    system: &WaveSystem<D>,
    integrator: Integrator,
    k: &SVector<f64, D>,
) -> f64 {
    let undamped = system.omega_squared(k);
    if system.damping().is_none() {
        // All three are stable up to two over the frequency. Waves with a complex omega^2 grow anyway.
        let fastest = undamped.last().map_or(0.0, |z| z.re);
        return 2.0 / fastest.max(0.0).sqrt();
    }
    let frequencies = system.frequencies(k);
    let oscillating = undamped.iter().filter(|z| z.re > 0.0);
    let decaying = frequencies.iter().filter(|omega| omega.im < 0.0);
    // Where nothing oscillates something may still decay too fast for a step.
    let fastest = match oscillating.map(|z| z.norm()).fold(0.0, f64::max) {
        0.0 => decaying.map(|omega| omega.norm()).fold(0.0, f64::max),
        largest => largest.sqrt(),
    };
    let bound = 2.0 / fastest;
    if !bound.is_finite() {
        return f64::INFINITY;
    }
    let wave = Amplification::new(system, k);
    let growth_rates: Vec<f64> = frequencies.iter().map(|omega| omega.im).collect();
    let stable = |step: f64| wave.is_stable(integrator, step, &growth_rates);
    let (mut low, mut high) = (0.0, f64::INFINITY);
    for n in 1..=STEPS {
        let step = 1.02 * bound * n as f64 / STEPS as f64;
        if !stable(step) {
            high = step;
            break;
        }
        low = step;
    }
    if high.is_infinite() {
        return low;
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if stable(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// The largest stable step of an integrator at a state: the least over the zone. Time. Of a state that is unstable itself it is
/// that of the waves that do not grow.
///
/// Without damping it is `2 / omega_max`, which the search over the zone finds; otherwise the least over a grid of wave vectors,
/// refined around the worst one.
pub fn critical_time_step<const D: usize>(
    system: &WaveSystem<D>,
    integrator: Integrator,
    search: &ZoneSearch<D>,
) -> f64 {
    critical_time_step_unless(system, integrator, search, &|| false)
}

/// The same, given up as soon as nobody waits for it any more.
pub fn critical_time_step_unless<const D: usize>(
    system: &WaveSystem<D>,
    integrator: Integrator,
    search: &ZoneSearch<D>,
    is_ended: IsEnded<'_>,
) -> f64 {
    if system.damping().is_none() {
        return search.summary_of(system).critical_time_step();
    }
    // Over the zone of a lattice in which forces reach far and obliquely, a grid sees little.
    let short_ranged = search.short_ranged_waves(system);
    let system = short_ranged.as_ref().unwrap_or(system);
    let lattice = system.crystal().lattice();
    let at = |fractional: &SVector<f64, D>| {
        critical_time_step_at(system, integrator, &(lattice.reciprocal() * fractional))
    };
    least_over_zone(at, is_ended).0
}
