//! Amplification matrices and the largest stable step.

use super::{Integrator, runge_kutta};
use crate::algebra::{Complex, any_eigenvalues, factorize, hermitian_eigen};
use crate::bloch::{BlochSum, Mass, WaveSystem, ZERO_FREQUENCY_NOISE_FACTOR, ZoneSearch};
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
}

/// Returns true if stiffness and damping are Hermitian and velocities move particles unsmoothed.
fn is_symmetric<const D: usize>(system: &WaveSystem<D>) -> bool {
    let is_hermitian = |sum: &BlochSum<D>| sum.is_hermitian();
    let is_lumped = matches!(system.mass(), Mass::Lumped(_));
    let is_conservative = system.is_hermitian() && system.drift().is_none();
    is_conservative && is_lumped && system.damping().is_none_or(is_hermitian)
}

/// Wave with a positive semidefinite stiffness and damping, in the eigenvectors of the damping. Both are divided by the masses.
///
/// An amplification factor `z` of a solution `u` obeys a quadratic equation with the real coefficients `u.C u` and `u.K u`. Factors that are not real lie
/// inside the unit circle or, for undamped solutions, on it. Stability is lost at `z = -1`, where a Hermitian matrix is singular, or at `z = 1`.
struct Dissipative {
    damping: Vec<f64>,
    stiffness: DMatrix<Complex>,
}

impl Dissipative {
    /// Returns the wave with Hermitian matrices at a wave vector; `None` if the damping has a negative eigenvalue.
    fn new<const D: usize>(system: &WaveSystem<D>, k: &SVector<f64, D>) -> Option<Self> {
        let masses = system.mass().of_particles();
        let over_mass = |sum: &BlochSum<D>| {
            let scaled = |i: usize, j: usize, z| z / (masses[i / D] * masses[j / D]).sqrt();
            sum.at(k).map_with_location(scaled)
        };
        let damping = hermitian_eigen(over_mass(system.damping()?))?;
        let values = &damping.eigenvalues;
        let vectors = &damping.eigenvectors;
        let is_positive = values.min() >= -POLYNOMIAL_TOLERANCE * values.max();
        is_positive.then(|| Self {
            damping: values.iter().copied().collect(),
            stiffness: vectors.adjoint() * over_mass(system.stiffness()) * vectors,
        })
    }

    /// Returns true if no solution grows in a step.
    ///
    /// With `h = dt / 2` the matrix is `1 - h C - h^2 K` for central differences. For kick-drift-kick it is `2 / (2 - h C) - h C - h^2 K`, and `z = 1` requires
    /// `h C = 2`.
    fn is_stable(&self, scheme: Symmetric, step: f64) -> bool {
        let h = 0.5 * step;
        let mut matrix = &self.stiffness * Complex::from(-h * h);
        for (i, damping) in self.damping.iter().enumerate() {
            let damped = h * damping;
            if damped >= 2.0 {
                return false;
            }
            matrix[(i, i)] += match scheme {
                Symmetric::CentralDifferences => 1.0 - damped,
                Symmetric::KickDriftKick => 2.0 / (2.0 - damped) - damped,
            };
        }
        factorize(&mut matrix)
    }
}

/// Integrators whose stable steps a Hermitian matrix decides.
#[derive(Clone, Copy)]
enum Symmetric {
    CentralDifferences,
    KickDriftKick,
}

impl Integrator {
    /// Returns the integrator if a Hermitian matrix decides its stable steps.
    fn symmetric(self) -> Option<Symmetric> {
        match self {
            Self::CentralDifferences => Some(Symmetric::CentralDifferences),
            Self::KickDriftKick => Some(Symmetric::KickDriftKick),
            _ => None,
        }
    }
}

/// Source of the amplification factors of a step.
enum Factors {
    /// Eigenvalues of the amplification matrix.
    Matrix(Amplification, Integrator),
    /// Stability polynomial `P(lambda dt)` of the method.
    Polynomial(Vec<f64>),
    /// None: a Hermitian matrix decides stability.
    Hermitian(Dissipative, Symmetric),
}

impl DampedWave {
    /// Solutions with a wave vector, in a state whose fastest wave grows at a given rate.
    ///
    /// Waves with wave vectors near a growing wave decay very slowly, and an integrator of second order makes some of them grow at any step. This
    /// growth counts if it is not small compared with the growth of the state.
    fn new<const D: usize>(
        system: &WaveSystem<D>,
        integrator: Integrator,
        k: &SVector<f64, D>,
        is_symmetric: bool,
        growth: f64,
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
        let grows = growth > 0.0 || rates.iter().any(|rate| rate.re > 0.0);
        let symmetric = integrator.symmetric().filter(|_| is_symmetric && !grows);
        let dissipative = symmetric.zip(symmetric.and_then(|_| Dissipative::new(system, k)));
        Self {
            factors: match (integrator.stages(), dissipative) {
                (Some(stages), _) => Factors::Polynomial(stages.polynomial()),
                (None, Some((scheme, wave))) => Factors::Hermitian(wave, scheme),
                (None, None) => Factors::Matrix(Amplification::new(system, k), integrator),
            },
            rates,
            bound: 2.0 / fastest,
            slack: SLACK * growth,
        }
    }

    /// Returns true if no more solutions grow in a step than in continuous time.
    fn is_stable(&self, step: f64) -> bool {
        let rounding = self.rounding();
        let limit = 1.0 + rounding + self.slack * step;
        // A discrete solution may grow slightly faster than the continuous one.
        let grows = |rate: &&Complex| rate.re * step > 0.5 * rounding;
        match &self.factors {
            Factors::Hermitian(wave, scheme) => wave.is_stable(*scheme, step),
            Factors::Polynomial(polynomial) => {
                let mut bounded = self.rates.iter().filter(|rate| !grows(rate));
                bounded.all(|rate| runge_kutta::value(polynomial, rate * step).norm() <= limit)
            }
            Factors::Matrix(wave, integrator) => match wave.moduli(*integrator, step) {
                Some(mut moduli) => {
                    moduli.sort_by(|a, b| b.total_cmp(a));
                    let growing = self.rates.iter().filter(grows).count();
                    moduli.get(growing).is_none_or(|modulus| *modulus <= limit)
                }
                None => false,
            },
        }
    }

    /// Distance of a factor outside the unit circle that counts as rounding.
    fn rounding(&self) -> f64 {
        match self.factors {
            Factors::Polynomial(_) => POLYNOMIAL_TOLERANCE,
            // Near a double eigenvalue rounding shifts both by its square root.
            _ => MODULUS_TOLERANCE.sqrt() * 1e-2,
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
            _ => self.first_loss(1.02 * self.bound),
        }
    }

    /// Step at which stability is first lost: equally spaced steps up to a bound are evaluated, then a geometric series of longer steps. Infinite if
    /// it is never lost.
    fn first_loss(&self, bound: f64) -> f64 {
        if !bound.is_finite() {
            return f64::INFINITY;
        }
        let below = (1..=STEPS_TO_BOUND).map(|n| bound * n as f64 / STEPS_TO_BOUND as f64);
        let beyond =
            std::iter::successors(Some(STEP_GROWTH * bound), |step| Some(STEP_GROWTH * step));
        let beyond = beyond.take_while(|step| *step < MAX_RAY_LENGTH * bound);
        let mut low = 0.0;
        let Some(mut high) = below.chain(beyond).find(|step| {
            let is_lost = !self.is_stable(*step);
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
            match self.is_stable(middle) {
                true => low = middle,
                false => high = middle,
            }
            tried += 1;
            accurate += usize::from(low > 0.0);
        }
        low
    }
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
    DampedWave::new(system, integrator, k, is_symmetric(system), 0.0).critical_step()
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
        DampedWave::new(system, integrator, k, is_symmetric, growth).critical_step()
    };
    search.least_of(system, &at).0
}
