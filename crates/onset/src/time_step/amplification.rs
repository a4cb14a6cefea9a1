//! Amplification matrices and the largest stable step.

use super::{Integrator, runge_kutta};
use crate::algebra::{Complex, any_eigenvalues, hermitian_eigenvalues};
use crate::bloch::{BlochSum, WaveSystem, ZERO_FREQUENCY_NOISE_FACTOR, ZoneSearch};
use nalgebra::{DMatrix, SVector};

/// Distance outside the unit circle that an eigenvalue can have by rounding.
const MODULUS_TOLERANCE: f64 = 1e-9;
/// Rounding tolerance for the factors of Runge-Kutta methods, which need no eigenvalues of `G`, and for relative damping.
const POLYNOMIAL_TOLERANCE: f64 = 1e-9;
const UNDAMPED_TOLERANCE: f64 = 1e-10;
/// Number of steps up to the undamped limit that are evaluated before the first loss is refined. Longer steps grow by the factor `STEP_GROWTH`, up to
/// `MAX_RAY_LENGTH` times the limit.
const STEPS_TO_BOUND: usize = 24;
const STEP_GROWTH: f64 = 1.05;
const MAX_RAY_LENGTH: f64 = 1e4;
/// Growth rate that an integrator may add to a wave, as a fraction of the fastest growth in the state.
const SLACK: f64 = 0.01;
/// Number of halvings of the interval that contains the loss of stability, and number of halvings within which a first stable step must be found.
const HALVINGS: usize = 28;
const MAX_STEP_HALVINGS: usize = 40;

/// Matrices of one wave: `dv/dt = -K u - C v`, `du/dt = T v`, divided by the masses.
#[derive(Clone, Debug)]
pub struct Amplification {
    stiffness: DMatrix<Complex>,
    damping: DMatrix<Complex>,
    drift: DMatrix<Complex>,
}

impl Amplification {
    /// Computes the matrices of the wave with a given wave vector.
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

    /// Undamped oscillator, `d^2 u / dt^2 = -omega^2 u`: a single mode of a wave.
    pub fn oscillator(omega_squared: Complex) -> Self {
        let one = |x| DMatrix::from_element(1, 1, x);
        Self {
            stiffness: one(omega_squared),
            damping: one(Complex::new(0.0, 0.0)),
            drift: one(Complex::new(1.0, 0.0)),
        }
    }

    /// Smallest step of central differences with the factor `-1`, a solution of `(4 - 2 dt C - dt^2 K) u = 0`; infinite if there is none.
    ///
    /// The reciprocal steps are eigenvalues of a companion matrix. They are real if `K` and `C` are Hermitian and `K` is positive semidefinite.
    fn alternating_step(&self) -> f64 {
        let n = self.stiffness.nrows();
        let mut matrix = DMatrix::zeros(2 * n, 2 * n);
        let [half, quarter] = [0.5, 0.25].map(Complex::from);
        matrix
            .view_mut((0, 0), (n, n))
            .copy_from(&(&self.damping * half));
        matrix
            .view_mut((0, n), (n, n))
            .copy_from(&(&self.stiffness * quarter));
        matrix.view_mut((n, 0), (n, n)).fill_with_identity();
        let values = any_eigenvalues(&matrix).unwrap_or_default().into_iter();
        values.map(|z| z.re).fold(0.0, f64::max).recip()
    }

    /// Amplification matrix `G(dt)` with `(u, v)' = G (u, v)`; shape `2 n x 2 n`.
    pub fn matrix(&self, integrator: Integrator, step: f64) -> DMatrix<Complex> {
        let n = self.stiffness.nrows();
        let one = DMatrix::<Complex>::identity(n, n);
        let number = |x: f64| Complex::new(x, 0.0);
        let (dt, half) = (number(step), number(0.5 * step));
        let (k, c, t) = (&self.stiffness, &self.damping, &self.drift);
        // Each quantity is a pair of matrices: its dependence on the old u and on the old v.
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
            _ => {
                let (mut stage, mut rates) = ((u.clone(), v.clone()), Vec::<[Pair; 2]>::new());
                for row in integrator.tableau().unwrap_or_default() {
                    stage = (u.clone(), v.clone());
                    for (factor, [of_u, of_v]) in row.iter().zip(&rates) {
                        let change = number(factor * step);
                        stage = (sum(&stage.0, change, of_u), sum(&stage.1, change, of_v));
                    }
                    rates.push([moved(&stage.1), acceleration(&stage.0, &stage.1)]);
                }
                stage
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

    /// Largest modulus of an eigenvalue of `G(dt)`; infinite if the eigenvalue iteration fails.
    pub fn spectral_radius(&self, integrator: Integrator, step: f64) -> f64 {
        let moduli = self.moduli(integrator, step);
        moduli.map_or(f64::INFINITY, |moduli| {
            moduli.into_iter().fold(0.0, f64::max)
        })
    }

    /// Moduli of the eigenvalues of `G(dt)`; `None` if the matrix is not finite.
    fn moduli(&self, integrator: Integrator, step: f64) -> Option<Vec<f64>> {
        // Scale velocities by the step: a similarity that balances the two halves.
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
}

/// Solutions of one damped wave, and their amplification by an integrator.
struct DampedWave {
    factors: Factors,
    /// Rates `lambda` of the solutions `exp(lambda t)` in continuous time.
    rates: Vec<Complex>,
    /// Scale of steps: the largest step without damping, or the fastest decay if nothing oscillates.
    bound: f64,
    /// Rate of growth that an integrator may add, zero in stable states; 1/time.
    slack: f64,
    /// True if no solution grows, the stiffness is Hermitian, and the damping Hermitian and positive semidefinite.
    is_dissipative: bool,
}

/// Returns true if stiffness and damping are Hermitian and velocities move particles unsmoothed.
fn is_symmetric<const D: usize>(system: &WaveSystem<D>) -> bool {
    let damping = system.damping();
    system.is_hermitian() && system.drift().is_none() && damping.is_none_or(BlochSum::is_hermitian)
}

/// Source of the amplification factors of a step.
enum Factors {
    /// Eigenvalues of the amplification matrix.
    Matrix(Amplification, Integrator),
    /// Stability polynomial `P(lambda dt)` of the method.
    Polynomial(Vec<f64>),
}

impl DampedWave {
    fn new<const D: usize>(
        system: &WaveSystem<D>,
        integrator: Integrator,
        k: &SVector<f64, D>,
        is_symmetric: bool,
    ) -> Self {
        // Zero-energy modes neither oscillate nor limit a step by the rounding of their frequencies.
        let noise = ZERO_FREQUENCY_NOISE_FACTOR * system.noise();
        let undamped = system.omega_squared(k);
        let turned = |omega: Complex| omega * Complex::new(0.0, -1.0);
        let mut rates: Vec<Complex> = system.frequencies(k).into_iter().map(turned).collect();
        let largest = rates.iter().map(|rate| rate.norm()).fold(0.0, f64::max);
        for rate in &mut rates {
            if rate.norm_sqr() <= noise || rate.norm() <= UNDAMPED_TOLERANCE * largest {
                *rate = Complex::new(0.0, 0.0);
            } else if rate.re.abs() <= UNDAMPED_TOLERANCE * largest {
                rate.re = 0.0;
            }
        }
        let oscillating = undamped.iter().filter(|z| z.re > noise).map(|z| z.norm());
        let decaying = rates.iter().filter(|rate| rate.re < 0.0);
        let fastest = match oscillating.fold(0.0, f64::max) {
            0.0 => decaying.map(|rate| rate.norm()).fold(0.0, f64::max),
            largest => largest.sqrt(),
        };
        Self {
            factors: match integrator.stages() {
                Some(stages) => Factors::Polynomial(stages.polynomial()),
                None => Factors::Matrix(Amplification::new(system, k), integrator),
            },
            bound: 2.0 / fastest,
            slack: 0.0,
            is_dissipative: is_symmetric
                && rates.iter().all(|rate| rate.re <= 0.0)
                && system.damping().is_some_and(|own| is_positive(own.at(k))),
            rates,
        }
    }

    /// The wave in a state whose fastest wave grows at a given rate.
    ///
    /// Waves with wave vectors near a growing wave decay very slowly, and an integrator of second order makes some of them grow at any step. This
    /// growth counts if it is not small compared with the growth of the state.
    fn beside(self, growth: f64) -> Self {
        Self {
            slack: SLACK * growth,
            ..self
        }
    }

    /// Excess over one of the largest modulus that must be bounded; each growing solution of the linearized equations permits one larger modulus.
    /// [`DampedWave::rounding`] is subtracted, so that zero is the limit.
    fn excess(&self, step: f64) -> f64 {
        let rounding = self.rounding();
        // A discrete solution may grow slightly faster than the continuous one.
        let grows = |rate: &&Complex| rate.re * step > 0.5 * rounding;
        let modulus = match &self.factors {
            Factors::Polynomial(polynomial) => {
                let bounded = self.rates.iter().filter(|rate| !grows(rate));
                let moduli = bounded.map(|rate| runge_kutta::value(polynomial, rate * step).norm());
                moduli.fold(0.0, f64::max)
            }
            Factors::Matrix(wave, integrator) => match wave.moduli(*integrator, step) {
                Some(mut moduli) => {
                    moduli.sort_by(|a, b| b.total_cmp(a));
                    let growing = self.rates.iter().filter(grows).count();
                    moduli.get(growing).copied().unwrap_or(0.0)
                }
                None => f64::INFINITY,
            },
        };
        modulus - 1.0 - rounding - self.slack * step
    }

    fn rounding(&self) -> f64 {
        match self.factors {
            Factors::Polynomial(_) => POLYNOMIAL_TOLERANCE,
            // Near a double eigenvalue rounding shifts both by its square root.
            Factors::Matrix(..) => MODULUS_TOLERANCE.sqrt() * 1e-2,
        }
    }

    /// Largest stable step of the wave.
    fn critical_step(&self) -> f64 {
        match &self.factors {
            Factors::Polynomial(polynomial) if self.slack == 0.0 => {
                let bounded = self.rates.iter().filter(|rate| rate.re <= 0.0);
                let oscillating = bounded
                    .map(|rate| (rate, rate.norm()))
                    .filter(|own| own.1 > 0.0);
                let steps = oscillating
                    .map(|(rate, size)| runge_kutta::reach(polynomial, rate / size) / size);
                steps.fold(f64::INFINITY, f64::min)
            }
            // A factor leaves the unit circle at -1 alone: for a unit vector `u` the quadratic equation of the factors has real coefficients, and the
            // product of its solutions is 1 - dt u.C u.
            Factors::Matrix(wave, Integrator::CentralDifferences)
                if self.is_dissipative && self.slack == 0.0 && self.bound.is_finite() =>
            {
                wave.alternating_step()
            }
            _ => self.first_loss(1.02 * self.bound),
        }
    }

    /// Step at which stability is first lost: equally spaced steps up to a bound are evaluated, then a geometric series of longer steps. Infinite if
    /// it is never lost.
    fn first_loss(&self, bound: f64) -> f64 {
        if !bound.is_finite() {
            return f64::INFINITY;
        }
        let stable = |step: f64| self.excess(step) <= 0.0;
        let below = (1..=STEPS_TO_BOUND).map(|n| bound * n as f64 / STEPS_TO_BOUND as f64);
        let beyond =
            std::iter::successors(Some(STEP_GROWTH * bound), |step| Some(STEP_GROWTH * step));
        let beyond = beyond.take_while(|step| *step < MAX_RAY_LENGTH * bound);
        let mut low = 0.0;
        let Some(mut high) = below.chain(beyond).find(|step| {
            let is_lost = !stable(*step);
            if !is_lost {
                low = *step;
            }
            is_lost
        }) else {
            return f64::INFINITY;
        };
        // The limit of a strongly damped wave can be far below the undamped one: the halvings for its accuracy begin at a stable step.
        let (mut accurate, mut tried) = (0, 0);
        while accurate < HALVINGS && tried < HALVINGS + MAX_STEP_HALVINGS {
            let middle = 0.5 * (low + high);
            match stable(middle) {
                true => low = middle,
                false => high = middle,
            }
            tried += 1;
            accurate += usize::from(low > 0.0);
        }
        low
    }
}

/// Returns true if a Hermitian matrix has no negative eigenvalue, apart from rounding.
fn is_positive(matrix: DMatrix<Complex>) -> bool {
    let values = hermitian_eigenvalues(matrix);
    let magnitudes = values.iter().map(|value| value.norm());
    let rounding = POLYNOMIAL_TOLERANCE * magnitudes.fold(0.0, f64::max);
    values.iter().all(|value| value.re >= -rounding)
}

/// Returns the largest stable step of an integrator for the waves with one wave vector. Time.
///
/// It is the first step at which more amplification factors lie outside the unit circle than solutions of the equations of motion grow, so physically
/// growing waves do not limit it. The result is infinite for waves that do not oscillate, and zero if no step is stable.
pub fn critical_time_step_at<const D: usize>(
    system: &WaveSystem<D>,
    integrator: Integrator,
    k: &SVector<f64, D>,
) -> f64 {
    if system.damping().is_none() {
        // Waves with complex omega^2 grow for any step.
        let fastest = system.omega_squared(k).last().map_or(0.0, |z| z.re);
        return undamped_time_step(integrator, fastest.max(0.0).sqrt());
    }
    DampedWave::new(system, integrator, k, is_symmetric(system)).critical_step()
}

/// Returns the largest stable step without damping for a given largest frequency. Time.
///
/// The result is infinite if nothing oscillates, and zero if no step is stable.
pub fn undamped_time_step(integrator: Integrator, largest_frequency: f64) -> f64 {
    match largest_frequency > 0.0 {
        true => integrator.undamped_reach() / largest_frequency,
        false => f64::INFINITY,
    }
}

/// Returns the largest stable step of an integrator at a state: the minimum over the zone. Time.
///
/// In an unstable state only the waves that do not grow are considered; with damping the integrator may let them grow at 1 % of the rate of the fastest
/// wave. The result is infinite if nothing oscillates, and zero if no step is stable. Without damping the largest frequency over the zone determines the
/// step. With damping the search minimizes the step over all waves.
pub fn critical_time_step<const D: usize>(
    system: &WaveSystem<D>,
    integrator: Integrator,
    search: &ZoneSearch<D>,
) -> f64 {
    let summary = search.summary_of(system);
    if system.damping().is_none() {
        return undamped_time_step(integrator, summary.maximum_omega);
    }
    let growth = summary.growth_rate();
    let is_symmetric = is_symmetric(system);
    let at = |k: &SVector<f64, D>| {
        let wave = DampedWave::new(system, integrator, k, is_symmetric);
        wave.beside(growth).critical_step()
    };
    search.least_of(system, &at).0
}
