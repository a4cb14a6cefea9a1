//! Time-stepping schemes of particle codes, and the rates of waves in discrete time.

use crate::algebra::{Complex, any_eigenvalues};
use nalgebra::DMatrix;

/// Time-stepping scheme of a particle code: the quantities that follow positions or velocities, and the times at which these are evaluated.
///
/// The waves of a state satisfy `dv/dt = -D u - C v`, `D = X + S + R`. The part `X` of the forces follows the positions `x`. The parts `S` and `R`
/// follow stress and density, which particles carry and whose displacements `s` and `r` the code integrates from separate velocities. In continuous
/// time both equal `x + const`. In discrete time they do not, and an initial difference persists as a constant. With velocities `h` at half steps, `a
/// = -X x - S s - R r - C h` and the step `dt`:
///
/// | stepping | a step |
/// |---|---|
/// | velocity Verlet | `h' = h + dt a`, `x' = x + dt h'`; `s = r = x` |
/// | extrapolated stress | as velocity Verlet, and `s' = s + dt (h' + dt/2 a)`; `r = s` |
/// | late density | as velocity Verlet, `e' = h' + dt/2 a`, `s' = s + dt e'` and `r' = r + dt e` |
/// | late acceleration | `y* = y + dt/2 f`, `f' = L y*`, `y' = y + dt f'` with `y = (x, v)`, `L = ((0, 1), (-D, -C))` |
///
/// ```
/// use nalgebra::DMatrix;
/// use onset::algebra::Complex;
/// use onset::time_step::{WaveParts, Stepping};
/// // A wave of omega = 1 that follows positions alone: omega of velocity Verlet is 2/dt asin(omega dt/2).
/// let parts = WaveParts::of_positions(DMatrix::from_element(1, 1, Complex::new(1.0, 0.0)));
/// let rates = Stepping::VelocityVerlet.rates(&parts, 0.1);
/// assert!((rates[0].im.abs() - 20.0 * 0.05_f64.asin()).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Stepping {
    /// Forces from positions: velocity Verlet, leapfrog, central differences.
    VelocityVerlet,
    /// Stress integrated from velocities extrapolated to the end of the step, as in LAMMPS' total-Lagrangian SMD. It damps a wave at the rate
    /// `omega^2 dt/4`.
    ExtrapolatedStress,
    /// Density integrated from the extrapolated velocities of the previous step, as in LAMMPS' updated SMD. It amplifies a wave at the rate
    /// `omega^2 dt/4`. Stress is integrated from the velocities of the current step.
    LateDensity,
    /// Predictor with the accelerations of the previous step, evaluation, corrector, as in PySPH's `PECIntegrator`. Positions, velocities and
    /// densities at half steps follow the second-order Adams-Bashforth method.
    LateAcceleration,
}

/// Parts of `D(k)` due to positions, stress and density, and the damping.
#[derive(Clone, Debug, PartialEq)]
pub struct WaveParts {
    /// Part `X` of `D(k)`, which the positions determine; 1/time^2.
    pub positions: DMatrix<Complex>,
    /// Part `S` of `D(k)`, which the stress integrated in time determines; 1/time^2.
    pub stress: DMatrix<Complex>,
    /// Part `R` of `D(k)`, which the density integrated in time determines; 1/time^2.
    pub density: DMatrix<Complex>,
    /// Damping `C(k)` by viscous forces, divided by the masses; 1/time.
    pub damping: DMatrix<Complex>,
}

impl WaveParts {
    /// Assigns all of `D(k)` to the positions, without damping.
    pub fn of_positions(positions: DMatrix<Complex>) -> Self {
        let none = DMatrix::zeros(positions.nrows(), positions.ncols());
        Self {
            positions,
            stress: none.clone(),
            density: none.clone(),
            damping: none,
        }
    }

    /// Largest real part of the eigenvalues of the sum of the parts with the [weights](Stepping::weights) of a scheme; 1/time^2.
    ///
    /// The result is NaN if the parts are not finite.
    pub fn limiting(&self, stepping: Stepping) -> f64 {
        let [x, s, r] = stepping.weights().map(|weight| Complex::new(weight, 0.0));
        let sum = &self.positions * x + &self.stress * s + &self.density * r;
        any_eigenvalues(&sum).map_or(f64::NAN, |values| {
            values
                .iter()
                .map(|value| value.re)
                .fold(f64::NEG_INFINITY, f64::max)
        })
    }

    /// Growth rate `Re s` of the fastest-growing solution `exp(s t)` of `s^2 + s C + D = 0` in continuous time; 1/time.
    ///
    /// The result is NaN if the parts are not finite.
    pub fn growth(&self) -> f64 {
        let n = self.positions.nrows();
        let whole = &self.positions + &self.stress + &self.density;
        let largest = |rates: Vec<f64>| rates.into_iter().fold(f64::NEG_INFINITY, f64::max);
        if self
            .damping
            .iter()
            .all(|entry| *entry == Complex::default())
        {
            let squares = any_eigenvalues(&whole);
            return squares.map_or(f64::NAN, |squares| {
                largest(
                    squares
                        .iter()
                        .map(|square| (-square).sqrt().re.abs())
                        .collect(),
                )
            });
        }
        let mut matrix = DMatrix::zeros(2 * n, 2 * n);
        // Velocities in units of the frequency balance the two halves.
        let unit = Complex::new(whole.camax().sqrt().max(f64::MIN_POSITIVE), 0.0);
        matrix.view_mut((0, n), (n, n)).fill_diagonal(unit);
        matrix.view_mut((n, 0), (n, n)).copy_from(&(-whole / unit));
        matrix.view_mut((n, n), (n, n)).copy_from(&-&self.damping);
        any_eigenvalues(&matrix).map_or(f64::NAN, |rates| {
            largest(rates.iter().map(|s| s.re).collect())
        })
    }
}

impl Stepping {
    /// All time-stepping schemes.
    pub const ALL: [Self; 4] = [
        Self::VelocityVerlet,
        Self::ExtrapolatedStress,
        Self::LateDensity,
        Self::LateAcceleration,
    ];

    /// Name used in files and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::VelocityVerlet => "velocity-verlet",
            Self::ExtrapolatedStress => "extrapolated-stress",
            Self::LateDensity => "late-density",
            Self::LateAcceleration => "late-acceleration",
        }
    }

    /// Weights of the parts `X`, `S` and `R` of [`WaveParts`] in the matrix whose largest eigenvalue `w^2` limits the step: at `w^2 dt^2 = 4` a
    /// solution alternates from step to step (`z = -1`).
    ///
    /// With `h' = -h`, `a = -2 h/dt` and `x = dt h/2` the table of [`Stepping`] gives `s = dt h` for velocities extrapolated to the end of the step,
    /// and `r = -dt h` for velocities of the previous step. A late acceleration has no such solution. It amplifies every oscillation.
    pub fn weights(self) -> [f64; 3] {
        match self {
            Self::VelocityVerlet | Self::LateAcceleration => [1.0, 1.0, 1.0],
            Self::ExtrapolatedStress => [1.0, 2.0, 2.0],
            Self::LateDensity => [1.0, 2.0, -2.0],
        }
    }

    /// Largest stable step for the largest eigenvalue `squared` of the matrix with these [weights](Self::weights) (1/time^2) and damping (1/time);
    /// time.
    ///
    /// For a late acceleration it is the step at which a wave grows by one percent of its frequency, `(omega dt)^3 = 0.04`.
    pub fn critical_step(self, squared: f64, damping: f64) -> f64 {
        match self {
            Self::LateAcceleration => 0.04_f64.cbrt() / squared.sqrt(),
            _ => 4.0 / (damping + (damping * damping + 4.0 * squared).sqrt()),
        }
    }

    /// Matrix `G` of a step, `y' = G y`, where the state `y` of the code starts with the positions, followed by the quantities listed at
    /// [`Stepping`].
    pub fn matrix(self, parts: &WaveParts, step: f64) -> DMatrix<Complex> {
        let (x, s, r, c) = (
            &parts.positions,
            &parts.stress,
            &parts.density,
            &parts.damping,
        );
        let n = x.nrows();
        let number = |x: f64| Complex::new(x, 0.0);
        let (dt, half) = (number(step), number(0.5 * step));
        let one = DMatrix::<Complex>::identity(n, n);
        let zero = DMatrix::<Complex>::zeros(n, n);
        // Each quantity after the step is a row of matrices, one for each quantity before it.
        let rows: Vec<Vec<DMatrix<Complex>>> = match self {
            Self::VelocityVerlet => {
                let a = x + s + r;
                vec![
                    vec![&one - &a * (dt * dt), (&one - c * dt) * dt],
                    vec![-(&a * dt), one - c * dt],
                ]
            }
            Self::ExtrapolatedStress => {
                let w = &(s + r);
                let later = dt + half;
                vec![
                    vec![&one - x * (dt * dt), -(w * (dt * dt)), (&one - c * dt) * dt],
                    vec![
                        -(x * (dt * later)),
                        &one - w * (dt * later),
                        (&one - c * later) * dt,
                    ],
                    vec![-(x * dt), -(w * dt), one - c * dt],
                ]
            }
            Self::LateDensity => {
                let later = dt + half;
                // Negative acceleration times a factor, by the columns x, s, r.
                let pushed = |factor: Complex| [x, s, r].map(|part| -(part * factor));
                let [x_h, s_h, r_h] = pushed(dt);
                let [x_e, s_e, r_e] = pushed(later);
                let [x_x, s_x, r_x] = pushed(dt * dt);
                let [x_s, s_s, r_s] = pushed(dt * later);
                vec![
                    vec![&one + x_x, s_x, r_x, (&one - c * dt) * dt, zero.clone()],
                    vec![x_s, &one + s_s, r_s, (&one - c * later) * dt, zero.clone()],
                    vec![
                        zero.clone(),
                        zero.clone(),
                        one.clone(),
                        zero.clone(),
                        &one * dt,
                    ],
                    vec![x_h, s_h, r_h, &one - c * dt, zero.clone()],
                    vec![x_e, s_e, r_e, one - c * later, zero],
                ]
            }
            Self::LateAcceleration => {
                let d = x + s + r;
                // f' = L (y + dt/2 f), by the columns x, v, f_x, f_v.
                let of_x = vec![zero.clone(), one.clone(), zero.clone(), &one * half];
                let of_v = vec![-&d, -c, -(&d * half), -(c * half)];
                let moved = |column: usize, change: &[DMatrix<Complex>]| {
                    let mut row: Vec<_> = change.iter().map(|block| block * dt).collect();
                    row[column] += &one;
                    row
                };
                vec![moved(0, &of_x), moved(1, &of_v), of_x, of_v]
            }
        };
        let size = n * rows.len();
        let mut matrix = DMatrix::zeros(size, size);
        for (i, row) in rows.iter().enumerate() {
            for (j, block) in row.iter().enumerate() {
                matrix.view_mut((i * n, j * n), (n, n)).copy_from(block);
            }
        }
        matrix
    }

    /// Returns the rates `s = ln(z)/dt` of all solutions `exp(s t)` at whole steps, with the eigenvalues `z` of the matrix of a step. 1/time.
    ///
    /// The imaginary part is the frequency and the real part the growth rate. Solutions that vanish after one step are omitted. The result is empty
    /// if the parts are not finite.
    pub fn rates(self, parts: &WaveParts, step: f64) -> Vec<Complex> {
        let n = parts.positions.nrows();
        let mut matrix = self.matrix(parts, step);
        // Scale velocities by the step and accelerations by its square: a similarity that balances all quantities.
        let powers: &[i32] = match self {
            Self::VelocityVerlet => &[0, 1],
            Self::ExtrapolatedStress => &[0, 0, 1],
            Self::LateDensity => &[0, 0, 0, 1, 1],
            Self::LateAcceleration => &[0, 1, 1, 2],
        };
        for i in 0..matrix.nrows() {
            for j in 0..matrix.ncols() {
                matrix[(i, j)] *= Complex::new(step.powi(powers[i / n] - powers[j / n]), 0.0);
            }
        }
        let values = any_eigenvalues(&matrix).unwrap_or_default().into_iter();
        values
            .filter(|z| z.norm() > f64::EPSILON.sqrt())
            .map(|z| z.ln() / step)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::{Stepping, WaveParts};
    use crate::algebra::Complex;
    use nalgebra::DMatrix;

    fn parts(positions: f64, stress: f64, density: f64, damping: f64) -> WaveParts {
        let one = |x: f64| DMatrix::from_element(1, 1, Complex::new(x, 0.0));
        WaveParts {
            positions: one(positions),
            stress: one(stress),
            density: one(density),
            damping: one(damping),
        }
    }

    /// Rate closest to a given rate.
    fn near(rates: &[Complex], expected: Complex) -> Complex {
        let apart = |z: &Complex| (z - expected).norm();
        let nearest = rates.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
        *nearest.expect("rates")
    }

    #[test]
    fn all_schemes_have_the_exact_rates_in_the_limit_of_short_steps() {
        for [x, s, r, c] in [
            [0.7, 0.0, 0.0, 0.0],
            [0.3, 0.2, 0.3, 0.4],
            [-0.9, 0.4, 0.0, 0.2],
            [0.2, 0.1, -0.9, 0.7],
        ] {
            let square: f64 = x + s + r;
            let half = Complex::new(0.5 * c, 0.0);
            let exact = (half * half - square).sqrt() - half;
            assert!((parts(x, s, r, c).growth() - exact.re).abs() < 1e-12);
            for stepping in Stepping::ALL {
                let error = |step: f64| {
                    let rates = stepping.rates(&parts(x, s, r, c), step);
                    (near(&rates, exact) - exact).norm()
                };
                assert!(error(1e-4) < 1e-4, "{stepping:?}");
            }
        }
    }

    #[test]
    fn stress_from_extrapolated_velocities_damps_and_late_density_amplifies() {
        // Relative change omega^2 dt/4 to first order in the step, derived by hand from the characteristic polynomial.
        let (square, step): (f64, f64) = (0.7102, 0.02);
        let exact = Complex::new(0.0, square.sqrt());
        for (stepping, stress, density, sign) in [
            (Stepping::ExtrapolatedStress, square, 0.0, -1.0),
            (Stepping::LateDensity, square, 0.0, -1.0),
            (Stepping::LateDensity, 0.0, square, 1.0),
        ] {
            let rates = stepping.rates(&parts(0.0, stress, density, 0.0), step);
            let found = near(&rates, exact).re;
            let expected = sign * 0.25 * square * step;
            assert!(
                (found / expected - 1.0).abs() < 1e-3,
                "{stepping:?} {found}"
            );
        }
    }

    #[test]
    fn a_solution_alternates_at_the_critical_step() {
        for stepping in [
            Stepping::VelocityVerlet,
            Stepping::ExtrapolatedStress,
            Stepping::LateDensity,
        ] {
            let (x, s, r, c) = (0.7, 0.4, 0.1, 0.3);
            let [of_x, of_s, of_r] = stepping.weights();
            let critical = stepping.critical_step(of_x * x + of_s * s + of_r * r, c);
            let growth = |step: f64| {
                let rates = stepping.rates(&parts(x, s, r, c), step).into_iter();
                let alternating =
                    rates.filter(|z| (z.im.abs() * step - std::f64::consts::PI).abs() < 1e-6);
                alternating.map(|z| z.re).fold(f64::NEG_INFINITY, f64::max)
            };
            assert!(growth(critical).abs() < 1e-9, "{stepping:?}");
            assert!(growth(1.01 * critical) > 1e-3, "{stepping:?}");
        }
        let growth = |step: f64| {
            let rates = Stepping::LateAcceleration.rates(&parts(1.0, 0.0, 0.0, 0.0), step);
            rates.iter().map(|z| z.re).fold(f64::NEG_INFINITY, f64::max)
        };
        let critical = Stepping::LateAcceleration.critical_step(1.0, 0.0);
        assert!(
            (growth(critical) - 0.01).abs() < 4e-3,
            "{}",
            growth(critical)
        );
    }

    #[test]
    fn a_direct_simulation_has_the_computed_rates() {
        // Independent implementation of each stepping scheme, without matrices.
        let (positions, stress, density, damping, step) = (0.31, 0.14, 0.09, 0.23, 0.17);
        for stepping in Stepping::ALL {
            let rates = stepping.rates(&parts(positions, stress, density, damping), step);
            let mut x = vec![0.0];
            let (mut h, mut w, mut r, mut e) = (1.0_f64, 0.0_f64, 0.0_f64, 0.4_f64);
            let mut f: (f64, f64) = (0.0, 0.0);
            let mut here: f64 = 0.0;
            for _ in 0..60 {
                let a = match stepping {
                    Stepping::VelocityVerlet => -(positions + stress + density) * here,
                    Stepping::ExtrapolatedStress => -positions * here - (stress + density) * w,
                    _ => -positions * here - stress * w - density * r,
                } - damping * h;
                match stepping {
                    Stepping::LateAcceleration => {
                        let (x_half, v_half) = (here + 0.5 * step * f.0, h + 0.5 * step * f.1);
                        f = (
                            v_half,
                            -(positions + stress + density) * x_half - damping * v_half,
                        );
                        here += step * f.0;
                        h += step * f.1;
                    }
                    _ => {
                        h += step * a;
                        here += step * h;
                        r += step * e;
                        e = h + 0.5 * step * a;
                        w += step * e;
                    }
                }
                x.push(here);
            }
            // Every sequence of the run satisfies the recurrence whose roots are the eigenvalues of a step.
            let mut polynomial = vec![Complex::new(1.0, 0.0)];
            for rate in &rates {
                let z = (rate * step).exp();
                let mut next = vec![Complex::new(0.0, 0.0); polynomial.len() + 1];
                for (power, coefficient) in polynomial.iter().enumerate() {
                    next[power + 1] += coefficient;
                    next[power] -= coefficient * z;
                }
                polynomial = next;
            }
            for start in 5..40 {
                let terms = polynomial.iter().enumerate();
                let sum: Complex = terms.map(|(power, c)| c * x[start + power]).sum();
                assert!(sum.norm() < 1e-12, "{stepping:?}: {sum}");
            }
        }
    }
}
