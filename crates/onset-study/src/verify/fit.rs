//! Rates of a record, fitted by variable projection.
//!
//! The record `y(t)` of a wave is `c0 + a C(t) + b S(t)` with `C = exp(m t) cosh(sqrt(d) t)` and `S = exp(m t) sinh(sqrt(d) t) / sqrt(d)`. These
//! combine the two solutions `exp(s t)`, `s = m +- sqrt(d)`, which travel if `d < 0` and grow or decay if `d > 0`, without a singularity in between.
//! The constant occurs in codes that integrate stress or density. For given `(m, d)` the three amplitudes follow from linear least squares, and the
//! residual is a function of two numbers only. Levenberg-Marquardt iterations with Kaufman's Jacobian minimize it from several starts. If one of the
//! two solutions decays too early to be measured, `d = 0` and `S` is omitted.
//!
//! The projection retains traces of other branches, of the order of the time step; their rates are predicted. If these traces are a small part of the
//! record, the solutions of the other branches are fitted together with the wave, so that they do not bias its rate.
//!
//! Sources: Golub, Pereyra, SIAM J. Numer. Anal. 10 (1973) 413; Kaufman, BIT 15 (1975) 49.

use nalgebra::{DMatrix, DVector, Matrix2, Vector2};
use onset::algebra::Complex;
use thiserror::Error;

/// Rate fitted to a record, with its uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Rate of the growing solution, or of the solution with positive frequency; 1/time.
    pub rate: Complex,
    /// Uncertainty in the plane of complex rates; 1/time.
    ///
    /// The larger of four standard deviations, and of the change of the rate if the last three tenths of the record are omitted.
    pub uncertainty: f64,
    /// Root mean square of the residual, divided by the largest amplitude of the record.
    pub residual: f64,
}

/// Reason why no rate can be fitted.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum FitError {
    /// Record with too few samples.
    #[error(
        "the record has {count} frame(s); at least {needed} are needed\n  hint: run the whole deck"
    )]
    Short {
        /// Number of samples in the record.
        count: usize,
        /// Smallest number of samples for a fit.
        needed: usize,
    },
    /// Times that do not increase.
    #[error(
        "time {time:e} follows {before:e}: times must increase\n  hint: write the frames of a single run in order"
    )]
    Order {
        /// Time of the earlier frame.
        before: f64,
        /// Time of the frame that should be later.
        time: f64,
    },
    /// Record in which no particle moves.
    #[error("no particle moves\n  hint: were the velocities of the deck set?")]
    Still,
}

/// Smallest number of samples in a record.
const MIN_SAMPLES: usize = 16;
/// Number of starts of a scan that are refined.
const REFINED_STARTS: usize = 3;
/// Largest number of iterations in a refinement.
const MAX_ITERATIONS: usize = 200;
/// Number of standard deviations in the uncertainty.
const UNCERTAINTY_DEVIATIONS: f64 = 4.0;
/// Leading fraction of the record whose rate must agree with the rate of the whole record.
const PARTIAL_RECORD_FRACTION: f64 = 0.7;
/// Largest fraction of a record that counts as a trace of other branches.
const MAX_TRACE_FRACTION: f64 = 1e-2;
/// Smallest relative phase (or growth) of another branch and the wave over the record: for a reliable separation, and for any separation.
const SEPARABLE_PHASES: [f64; 2] = [3.0, 0.3];

/// Fits the rates of a record.
///
/// The expected rates provide one of the starts. `others` are the rates of other branches, one of each conjugate pair, whose traces the record may
/// contain.
///
/// # Errors
/// [`FitError`] for a record that is too short, out of order, or zero.
pub fn fitted(
    samples: &[(f64, f64)],
    expected: [Complex; 2],
    others: &[Complex],
) -> Result<Fit, FitError> {
    fit(samples, expected, others, false)
}

/// Fits the rate of a single solution that grows or decays; the expected rate provides one of the starts.
///
/// # Errors
/// Fails like [`fitted`].
pub fn fitted_alone(samples: &[(f64, f64)], expected: f64) -> Result<Fit, FitError> {
    fit(samples, [Complex::new(expected, 0.0); 2], &[], true)
}

fn fit(
    samples: &[(f64, f64)],
    expected: [Complex; 2],
    others: &[Complex],
    is_alone: bool,
) -> Result<Fit, FitError> {
    if samples.len() < MIN_SAMPLES {
        return Err(FitError::Short {
            count: samples.len(),
            needed: MIN_SAMPLES,
        });
    }
    if let Some(pair) = samples.windows(2).find(|pair| pair[1].0 <= pair[0].0) {
        return Err(FitError::Order {
            before: pair[0].0,
            time: pair[1].0,
        });
    }
    let whole = Series::new(samples, is_alone)?;
    let best = whole.best(expected);
    let count = (PARTIAL_RECORD_FRACTION * samples.len() as f64).ceil() as usize;
    let part = Series::new(&samples[..count.max(MIN_SAMPLES)], is_alone)?;
    let beside = |rates: &[Complex]| match whole.with_traces(rates, &best) {
        Some((traced, point)) => traced.told(&part.with(rates), &point),
        None => whole.told(&part, &best),
    };
    let [apart, nearly] =
        SEPARABLE_PHASES.map(|apart| whole.told_apart(others, whole.rate(&best), apart));
    let far = beside(&apart);
    if nearly.len() == apart.len() {
        return Ok(far);
    }
    // A trace with nearly the rate of the wave makes the fitted rate uncertain. It is included if it shifts the rate by more than this uncertainty.
    let near = beside(&nearly);
    Ok(match (near.rate - far.rate).norm() > near.uncertainty {
        true => near,
        false => far,
    })
}

/// Record scaled to times from 0 to 1 and amplitudes up to 1.
#[derive(Clone)]
struct Series {
    times: Vec<f64>,
    values: DVector<f64>,
    duration: f64,
    /// Whether one solution is fitted instead of two.
    is_alone: bool,
    /// Solutions of other branches, one column each.
    traces: Vec<DVector<f64>>,
}

/// Parameters `m` and `d`, and the residual of the record.
#[derive(Clone, Copy, Debug)]
struct Point {
    place: Vector2<f64>,
    residual: f64,
}

/// `cosh(sqrt(d) t)` and `sinh(sqrt(d) t) / sqrt(d)`, analytic in `d`.
fn pair(d: f64, t: f64) -> [f64; 2] {
    let z = d * t * t;
    if z.abs() < 1e-6 {
        return [
            1.0 + z / 2.0 * (1.0 + z / 12.0),
            t * (1.0 + z / 6.0 * (1.0 + z / 20.0)),
        ];
    }
    let root = z.abs().sqrt();
    match z > 0.0 {
        true => [root.cosh(), t * root.sinh() / root],
        false => [root.cos(), t * root.sin() / root],
    }
}

/// Derivatives of the functions of `pair` with respect to `d`: `t S / 2`, and `(t C - S) / (2 d)`.
fn slopes(d: f64, t: f64) -> [f64; 2] {
    let z = d * t * t;
    let [c, s] = pair(d, t);
    let second = if z.abs() < 1e-4 {
        t * t * t / 6.0 * (1.0 + z / 10.0 * (1.0 + z / 28.0))
    } else {
        (t * c - s) / (2.0 * d)
    };
    [0.5 * t * s, second]
}

impl Series {
    fn new(samples: &[(f64, f64)], is_alone: bool) -> Result<Self, FitError> {
        let start = samples[0].0;
        let duration = samples[samples.len() - 1].0 - start;
        let largest = samples
            .iter()
            .fold(0.0_f64, |most, (_, y)| most.max(y.abs()));
        if largest == 0.0 {
            return Err(FitError::Still);
        }
        let times = samples.iter().map(|(t, _)| (t - start) / duration);
        Ok(Self {
            times: times.collect(),
            values: DVector::from_iterator(samples.len(), samples.iter().map(|(_, y)| y / largest)),
            duration,
            is_alone,
            traces: Vec::new(),
        })
    }

    /// Number of solutions of the wave, without other branches.
    fn own(&self) -> usize {
        if self.is_alone { 1 } else { 2 }
    }

    /// Rates of other branches that the record can separate from the rate of the wave.
    fn told_apart(&self, others: &[Complex], rate: Complex, apart: f64) -> Vec<Complex> {
        let is_apart = |z: &Complex| {
            let nearest = (z - rate).norm().min((z - rate.conj()).norm());
            nearest * self.duration > apart
        };
        others.iter().copied().filter(is_apart).collect()
    }

    /// Solutions with the given rates, scaled to a magnitude of at most one.
    fn solutions(&self, rates: &[Complex]) -> Vec<DVector<f64>> {
        let solution = |z: &Complex| {
            let z = z * self.duration;
            let at = |t: f64| Complex::from_polar((z.re * t - z.re.max(0.0)).exp(), z.im * t);
            let column = |of: fn(Complex) -> f64| {
                DVector::from_iterator(self.times.len(), self.times.iter().map(|t| of(at(*t))))
            };
            let sine = (z.im != 0.0).then(|| column(|z| z.im));
            [column(|z| z.re)].into_iter().chain(sine)
        };
        rates.iter().flat_map(solution).collect()
    }

    /// Series with solutions of other branches as traces.
    fn with(&self, others: &[Complex]) -> Self {
        Self {
            traces: self.solutions(others),
            ..self.clone()
        }
    }

    /// Rate of the whole record, with its deviation from the rate of a part.
    fn told(&self, part: &Self, best: &Point) -> Fit {
        let shorter = part.duration / self.duration;
        let shorter = part.refined(Vector2::new(
            best.place[0] * shorter,
            best.place[1] * shorter * shorter,
        ));
        let rate = self.rate(best);
        let moved = (part.rate(&shorter) - rate).norm();
        Fit {
            rate,
            uncertainty: moved.max(UNCERTAINTY_DEVIATIONS * self.deviation(best)),
            residual: best.residual,
        }
    }

    /// Series and fit with traces of other branches, or `None` if their contributions are too large for traces.
    fn with_traces(&self, others: &[Complex], best: &Point) -> Option<(Self, Point)> {
        let traced = self.with(others);
        let parameters = self.own() + 1 + traced.traces.len() + 2;
        if traced.traces.is_empty() || self.times.len() < MIN_SAMPLES.max(2 * parameters) {
            return None;
        }
        let point = traced.refined(best.place);
        let (q, r, _) = traced.projected(&point.place);
        let amplitudes = r.solve_upper_triangular(&(q.transpose() * &traced.values))?;
        let after = self.own() + 1;
        let part = traced.traces.iter().zip(amplitudes.iter().skip(after));
        let largest = part.map(|(trace, a)| (trace * *a).amax()).sum::<f64>();
        (largest < MAX_TRACE_FRACTION && point.residual.is_finite()).then_some((traced, point))
    }

    /// Orthogonalized functions at the given parameters, and the residual of the record.
    fn projected(&self, place: &Vector2<f64>) -> (DMatrix<f64>, DMatrix<f64>, DVector<f64>) {
        let (m, d) = (place[0], place[1]);
        let own = self.own();
        let columns = own + 1 + self.traces.len();
        let functions = DMatrix::from_fn(self.times.len(), columns, |row, column| {
            let t = self.times[row];
            match column.checked_sub(own) {
                None => (m * t).exp() * pair(d, t)[column],
                Some(0) => 1.0,
                Some(n) => self.traces[n - 1][row],
            }
        });
        let decomposition = functions.qr();
        let (q, r) = (decomposition.q(), decomposition.r());
        let left = &self.values - &q * (q.transpose() * &self.values);
        (q, r, left)
    }

    fn point(&self, place: Vector2<f64>) -> Point {
        let (_, _, left) = self.projected(&place);
        let residual = left.norm() / (self.times.len() as f64).sqrt();
        Point {
            place,
            residual: if residual.is_finite() {
                residual
            } else {
                f64::INFINITY
            },
        }
    }

    /// Residual and its Jacobian after Kaufman: the negative component of `dPhi c` orthogonal to the functions.
    fn jacobian(&self, place: &Vector2<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let (q, r, left) = self.projected(place);
        let amplitudes = r.solve_upper_triangular(&(q.transpose() * &self.values));
        let amplitudes = amplitudes.unwrap_or_else(|| DVector::zeros(q.ncols()));
        let (m, d) = (place[0], place[1]);
        let change = DMatrix::from_fn(self.times.len(), 2, |row, column| {
            let t = self.times[row];
            if self.is_alone {
                return [t * (m * t).exp() * amplitudes[0], 0.0][column];
            }
            let own = match column {
                0 => pair(d, t).map(|f| f * t),
                _ => slopes(d, t),
            };
            (m * t).exp() * (own[0] * amplitudes[0] + own[1] * amplitudes[1])
        });
        let jacobian = &q * (q.transpose() * &change) - change;
        (left, jacobian)
    }

    /// Matrix `J^T J`; a fixed parameter has one on the diagonal and remains unchanged.
    fn normal(&self, jacobian: &DMatrix<f64>) -> Matrix2<f64> {
        let mut normal: Matrix2<f64> = (jacobian.transpose() * jacobian)
            .fixed_view::<2, 2>(0, 0)
            .into();
        if self.is_alone {
            normal[(1, 1)] = 1.0;
        }
        normal
    }

    /// Levenberg-Marquardt iteration from a start.
    fn refined(&self, start: Vector2<f64>) -> Point {
        let mut point = self.point(start);
        let mut damping = 1e-3;
        for _ in 0..MAX_ITERATIONS {
            let (left, jacobian) = self.jacobian(&point.place);
            let normal = self.normal(&jacobian);
            let gradient: Vector2<f64> = (jacobian.transpose() * left)
                .fixed_view::<2, 1>(0, 0)
                .into();
            let mut improved = false;
            while damping < 1e12 {
                let damped = normal + Matrix2::from_diagonal(&normal.diagonal()) * damping;
                let Some(step) = damped.try_inverse().map(|inverse| inverse * gradient) else {
                    break;
                };
                let tried = self.point(point.place - step);
                if tried.residual < point.residual {
                    point = tried;
                    damping = (damping * 0.1).max(1e-15);
                    improved = true;
                    break;
                }
                damping *= 10.0;
            }
            if !improved {
                break;
            }
        }
        point
    }

    /// Best of the refinements from the expected rates, and from the best starts of scans over traveling and growing waves.
    ///
    /// Both scans are needed: growing waves resemble slowly traveling waves, but a long valley of the residual separates them.
    fn best(&self, expected: [Complex; 2]) -> Point {
        let [first, second] = expected.map(|rate| rate * self.duration);
        let half = (first - second) * 0.5;
        let expected = Vector2::new(0.5 * (first + second).re, (half * half).re);
        let mut best = self.refined(expected);
        let families = match self.is_alone {
            true => [Self::alone(), Vec::new()],
            false => [self.traveling(), Self::growing()],
        };
        for family in families {
            let mut points: Vec<Point> =
                family.into_iter().map(|start| self.point(start)).collect();
            points.sort_by(|a, b| a.residual.total_cmp(&b.residual));
            for point in points.iter().take(REFINED_STARTS) {
                let refined = self.refined(point.place);
                if refined.residual < best.residual {
                    best = refined;
                }
            }
        }
        best
    }

    /// Starts at all frequencies that the samples resolve.
    fn traveling(&self) -> Vec<Vector2<f64>> {
        let fastest = 0.5 * std::f64::consts::PI * self.times.len() as f64;
        let mut starts = Vec::new();
        let mut frequency = 0.25;
        while frequency < fastest {
            starts.push(Vector2::new(0.0, -frequency * frequency));
            // A start must lie within the valley around the true frequency; its width corresponds to one turn over the record.
            frequency += 0.5_f64.max(0.02 * frequency);
        }
        starts
    }

    /// Starts at growth and decay of a single solution, up to a factor of 10^5.
    fn alone() -> Vec<Vector2<f64>> {
        (-24..=24)
            .map(|growth| Vector2::new(f64::from(growth) / 2.0, 0.0))
            .collect()
    }

    /// Starts at growth up to a factor of 10^5.
    fn growing() -> Vec<Vector2<f64>> {
        (1..=24)
            .map(|growth| Vector2::new(0.0, f64::from(growth * growth) / 4.0))
            .collect()
    }

    fn rate(&self, point: &Point) -> Complex {
        let (m, d) = (point.place[0], point.place[1]);
        (Complex::new(m, 0.0) + Complex::new(d, 0.0).sqrt()) / self.duration
    }

    /// Standard deviation of the rate, from the residual of the record.
    fn deviation(&self, point: &Point) -> f64 {
        let (left, jacobian) = self.jacobian(&point.place);
        let Some(inverse) = self.normal(&jacobian).try_inverse() else {
            return f64::INFINITY;
        };
        let variance = left.norm_squared() / (self.times.len() - 5 - self.traces.len()) as f64;
        let covariance = inverse * variance;
        if self.is_alone {
            return covariance[(0, 0)].max(0.0).sqrt() / self.duration;
        }
        // The rate is `s = m + sqrt(d)`; its variance follows from the covariance of `m` and `d`.
        let by_d = Complex::new(0.5, 0.0) / Complex::new(point.place[1], 0.0).sqrt();
        let own = covariance[(0, 0)]
            + 2.0 * by_d.re * covariance[(0, 1)]
            + by_d.norm_sqr() * covariance[(1, 1)];
        match own.is_finite() {
            true => own.max(0.0).sqrt() / self.duration,
            false => f64::INFINITY,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{FitError, fitted, fitted_alone};
    use onset::algebra::Complex;

    fn traveling(frequency: f64) -> [Complex; 2] {
        [1.0, -1.0].map(|sign| Complex::new(0.0, sign * frequency))
    }

    fn record(count: usize, step: f64, y: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        (0..count)
            .map(|n| n as f64 * step)
            .map(|t| (t, y(t)))
            .collect()
    }

    #[test]
    fn the_rate_of_a_single_solution_is_found_for_any_expected_rate() {
        for rate in [-3.0_f64, -0.4, 0.7] {
            let samples = record(60, 0.05, |t| 0.2 - (rate * t).exp());
            for expected in [-1.0, rate, 2.0] {
                let fit = fitted_alone(&samples, expected).expect("a fit");
                let error = (fit.rate - rate).norm();
                assert!(error < 1e-9 * rate.abs(), "{rate} {expected}: {error}");
                assert!(fit.uncertainty < 1e-8 && fit.rate.im == 0.0);
            }
        }
    }

    #[test]
    fn rates_are_found_for_any_expected_rates() {
        for (growth, frequency) in [(0.0_f64, 0.4_f64), (-0.01, 1.3), (0.02, 6.0)] {
            let y = |t: f64| 0.3 + (growth * t).exp() * (frequency * t + 0.2).sin();
            let samples = record(240, 0.05, y);
            for factor in [1.0, 0.5, 1.7] {
                let expected = traveling(factor * frequency);
                let fit = fitted(&samples, expected, &[]).expect("a fit");
                let true_rate = Complex::new(growth, frequency);
                assert!((fit.rate - true_rate).norm() < 1e-9, "{fit:?} {true_rate}");
                assert!(fit.uncertainty < 1e-8, "{fit:?}");
            }
        }
    }

    #[test]
    fn growth_is_distinguished_from_oscillation() {
        let samples = record(200, 0.02, |t| {
            1e-3 + (0.7 * t).exp() - 0.9 * (-0.71 * t).exp()
        });
        let fit = fitted(&samples, traveling(0.7), &[]).expect("a fit");
        assert!((fit.rate - Complex::new(0.7, 0.0)).norm() < 1e-7, "{fit:?}");
        // Far into growth the decaying part and the constant are small.
        let samples = record(400, 0.02, |t| 1e-9 * (0.856 * t).sinh());
        let fit = fitted(&samples, traveling(0.8), &[]).expect("a fit");
        assert!(
            (fit.rate - Complex::new(0.856, 0.0)).norm() < 1e-7,
            "{fit:?}"
        );
        let still = record(60, 0.1, |t| 2.0 + t);
        let fit = fitted(&still, traveling(0.5), &[]).expect("a fit");
        assert!(fit.rate.norm() < 1e-3, "a double root at zero: {fit:?}");
    }

    #[test]
    fn traces_of_other_branches_do_not_bias_the_rate() {
        let traced = |t: f64| {
            (-0.01 * t).exp() * (1.3 * t).sin() + 2e-4 * (0.9 * t).cos() - 1e-9 * (0.6 * t).exp()
        };
        let samples = record(240, 0.1, traced);
        let truth = Complex::new(-0.01, 1.3);
        let fit = |others: &[Complex]| fitted(&samples, traveling(1.3), others).expect("a fit");
        let error = |others: &[Complex]| (fit(others).rate - truth).norm();
        let others = [Complex::new(0.0, 0.9), Complex::new(0.6, 0.0)];
        assert!(error(&[]) > 1e-6, "{}", error(&[]));
        assert!(error(&others) < 1e-9, "{}", error(&others));
        // The wave itself is not treated as a trace, even if it is listed as another branch.
        let mistaken = fit(&[truth, Complex::new(0.0, 1.31)]);
        assert!((mistaken.rate - truth).norm() < 1e-3 && mistaken.uncertainty.is_finite());
        // A branch as large as the wave is not a trace either.
        let mixed = record(240, 0.1, |t| traced(t) + 0.5 * (2.1 * t).sin());
        let two = fitted(&mixed, traveling(1.3), &[Complex::new(0.0, 2.1)]).expect("a fit");
        assert!(two.residual > 0.1, "{two:?}");
    }

    #[test]
    fn noise_makes_rates_uncertain_and_the_uncertainty_covers_the_error() {
        let mut covered = 0;
        for seed in 0..40_u64 {
            let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
            let mut noise = || {
                state ^= state << 13;
                state ^= state >> 7;
                state ^= state << 17;
                (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
            };
            let mut samples = record(200, 0.05, |t| (1.1 * t).sin());
            samples.iter_mut().for_each(|(_, y)| *y += 1e-3 * noise());
            let fit = fitted(&samples, traveling(1.1), &[]).expect("a fit");
            let error = (fit.rate - Complex::new(0.0, 1.1)).norm();
            assert!(fit.uncertainty > 1e-6, "{fit:?}");
            covered += usize::from(error <= fit.uncertainty);
        }
        assert!(covered >= 39, "{covered} of 40");
    }

    #[test]
    fn records_without_a_wave_are_refused() {
        let expected = traveling(1.0);
        let short = fitted(&record(8, 0.1, f64::sin), expected, &[]);
        assert!(matches!(short, Err(FitError::Short { count: 8, .. })));
        assert_eq!(
            fitted(&record(40, 0.1, |_| 0.0), expected, &[]),
            Err(FitError::Still)
        );
        let mut samples = record(40, 0.1, f64::sin);
        samples.swap(3, 4);
        assert!(matches!(
            fitted(&samples, expected, &[]),
            Err(FitError::Order { .. })
        ));
    }
}
