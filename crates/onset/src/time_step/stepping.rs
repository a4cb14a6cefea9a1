//! Time steps as particle codes take them, and the rates of waves in discrete time.

use crate::algebra::Complex;
use nalgebra::DMatrix;

/// How a code takes a time step: what follows positions, what follows velocities, and from which time these are.
///
/// The waves of a state obey `dv/dt = -D u`, `D = X + W`: the part `X` of the forces follows the positions `x`, the part `W` what particles
/// carry along (stress or density), whose displacement `w` the code integrates from velocities of its own. In continuous time
/// `w = x + const`, and both are the same; in discrete time they are not, and what was wrong at the start stays as a constant. With velocities
/// `h` at half steps, `a = -X x - W w` and the step `dt`:
///
/// | stepping | a step |
/// |---|---|
/// | velocity Verlet | `h' = h + dt a`, `x' = x + dt h'`; `w = x` |
/// | extrapolated stress | the same, and `w' = w + dt (h' + dt/2 a)` |
/// | late density | the same, `e' = h' + dt/2 a`, and `w' = w + dt e` |
/// | late acceleration | `y* = y + dt/2 f`, `f' = L y*`, `y' = y + dt f'` with `y = (x, v)`, `L = ((0, 1), (-D, 0))` |
///
/// ```
/// use nalgebra::DMatrix;
/// use onset::algebra::Complex;
/// use onset::time_step::Stepping;
/// // A wave of omega = 1 that follows positions alone: omega of velocity Verlet is 2/dt asin(omega dt/2).
/// let [one, none] = [1.0, 0.0].map(|x| DMatrix::from_element(1, 1, Complex::new(x, 0.0)));
/// let rates = Stepping::VelocityVerlet.rates(&one, &none, 0.1);
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
    /// Stress integrated from velocities that are extrapolated to the end of the step, as in LAMMPS' total-Lagrangian SMD: it damps a
    /// wave at the rate `omega^2 dt/4`.
    ExtrapolatedStress,
    /// Density integrated from the extrapolated velocities of the step before, as in LAMMPS' updated SMD: it amplifies a wave at
    /// the rate `omega^2 dt/4`.
    LateDensity,
    /// Predictor with the accelerations of the step before, evaluation, corrector, as in PySPH's `PECIntegrator`: positions,
    /// velocities and densities at half steps are those of the second-order method of Adams and Bashforth.
    LateAcceleration,
}

impl Stepping {
    /// All of them.
    pub const ALL: [Self; 4] = [
        Self::VelocityVerlet,
        Self::ExtrapolatedStress,
        Self::LateDensity,
        Self::LateAcceleration,
    ];

    /// The word used in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::VelocityVerlet => "velocity-verlet",
            Self::ExtrapolatedStress => "extrapolated-stress",
            Self::LateDensity => "late-density",
            Self::LateAcceleration => "late-acceleration",
        }
    }

    /// Whether a code with this stepping follows part of the forces by velocities.
    pub fn carries(self) -> bool {
        matches!(self, Self::ExtrapolatedStress | Self::LateDensity)
    }

    /// The matrix of a step, `y' = G y` with the state `y` of the code: positions first, then what [`Stepping`] lists. `positions` and
    /// `carried` are `X` and `W`, 1/time^2.
    pub fn matrix(
        self,
        positions: &DMatrix<Complex>,
        carried: &DMatrix<Complex>,
        step: f64,
    ) -> DMatrix<Complex> {
        let n = positions.nrows();
        let number = |x: f64| Complex::new(x, 0.0);
        let (dt, half) = (number(step), number(0.5 * step));
        let one = DMatrix::<Complex>::identity(n, n);
        let zero = DMatrix::<Complex>::zeros(n, n);
        // Each quantity after the step as a row of matrices, one for each quantity before it.
        let rows: Vec<Vec<DMatrix<Complex>>> = match self {
            Self::VelocityVerlet => {
                let a = positions + carried;
                vec![
                    vec![&one - &a * (dt * dt), &one * dt],
                    vec![-(&a * dt), one],
                ]
            }
            Self::ExtrapolatedStress => {
                let (x, w) = (positions, carried);
                let later = dt + half;
                vec![
                    vec![&one - x * (dt * dt), -(w * (dt * dt)), &one * dt],
                    vec![-(x * (dt * later)), &one - w * (dt * later), &one * dt],
                    vec![-(x * dt), -(w * dt), one],
                ]
            }
            Self::LateDensity => {
                let (x, w) = (positions, carried);
                let later = dt + half;
                vec![
                    vec![
                        &one - x * (dt * dt),
                        -(w * (dt * dt)),
                        &one * dt,
                        zero.clone(),
                    ],
                    vec![zero.clone(), one.clone(), zero.clone(), &one * dt],
                    vec![-(x * dt), -(w * dt), one.clone(), zero.clone()],
                    vec![-(x * later), -(w * later), one, zero],
                ]
            }
            Self::LateAcceleration => {
                let d = positions + carried;
                // f' = L (y + dt/2 f), by the columns x, v, f_x, f_v.
                let of_x = vec![zero.clone(), one.clone(), zero.clone(), &one * half];
                let of_v = vec![-&d, zero.clone(), -(&d * half), zero.clone()];
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

    /// The rates `s` of all solutions `exp(s t)` at whole steps, `s = ln(z)/dt` with the eigenvalues `z` of the matrix of a step; the
    /// imaginary part is the frequency, the real one the growth. Solutions that vanish after one step are left out; empty where the
    /// eigenvalue iteration fails. 1/time.
    pub fn rates(
        self,
        positions: &DMatrix<Complex>,
        carried: &DMatrix<Complex>,
        step: f64,
    ) -> Vec<Complex> {
        let n = positions.nrows();
        let mut matrix = self.matrix(positions, carried, step);
        // Velocities times the step, accelerations times its square: a similarity that keeps all of the same size.
        let powers: &[i32] = match self {
            Self::VelocityVerlet => &[0, 1],
            Self::ExtrapolatedStress => &[0, 0, 1],
            Self::LateDensity => &[0, 0, 1, 1],
            Self::LateAcceleration => &[0, 1, 1, 2],
        };
        for i in 0..matrix.nrows() {
            for j in 0..matrix.ncols() {
                matrix[(i, j)] *= Complex::new(step.powi(powers[i / n] - powers[j / n]), 0.0);
            }
        }
        let size = matrix.nrows();
        let schur = nalgebra::Schur::try_new(matrix, f64::EPSILON, 400 * size);
        let values = schur.and_then(|schur| schur.eigenvalues());
        let values = values.iter().flat_map(|values| values.iter().copied());
        values
            .filter(|z| z.norm() > f64::EPSILON.sqrt())
            .map(|z| z.ln() / step)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::Stepping;
    use crate::algebra::Complex;
    use nalgebra::DMatrix;

    fn one(x: f64) -> DMatrix<Complex> {
        DMatrix::from_element(1, 1, Complex::new(x, 0.0))
    }

    /// The rate next to a given one.
    fn near(rates: &[Complex], expected: Complex) -> Complex {
        let apart = |z: &Complex| (z - expected).norm();
        let nearest = rates.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
        *nearest.expect("rates")
    }

    #[test]
    fn all_have_the_rates_of_the_equations_in_the_limit_of_short_steps() {
        for (positions, carried) in [(0.7, 0.0), (0.3, 0.5), (-0.9, 0.4), (0.2, -0.8)] {
            let square: f64 = positions + carried;
            let exact = Complex::new(-square, 0.0).sqrt();
            for stepping in Stepping::ALL {
                let error = |step: f64| {
                    let rates = stepping.rates(&one(positions), &one(carried), step);
                    (near(&rates, exact) - exact).norm()
                };
                assert!(error(1e-4) < 1e-4, "{stepping:?}");
            }
        }
    }

    #[test]
    fn stress_from_extrapolated_velocities_damps_and_late_density_amplifies() {
        // To first order in the step by omega^2 dt/4, from the characteristic polynomial by hand.
        let (square, step): (f64, f64) = (0.7102, 0.02);
        let exact = Complex::new(0.0, square.sqrt());
        for (stepping, sign) in [
            (Stepping::ExtrapolatedStress, -1.0),
            (Stepping::LateDensity, 1.0),
        ] {
            let rates = stepping.rates(&one(0.0), &one(square), step);
            let found = near(&rates, exact).re;
            let expected = sign * 0.25 * square * step;
            assert!(
                (found / expected - 1.0).abs() < 1e-3,
                "{stepping:?} {found}"
            );
        }
    }

    #[test]
    fn a_step_by_step_run_has_these_rates() {
        // The code of each stepping, written out once more, without matrices.
        let (positions, carried, step) = (0.31, 0.23, 0.17);
        for stepping in Stepping::ALL {
            let rates = stepping.rates(&one(positions), &one(carried), step);
            let mut x = vec![0.0];
            let (mut h, mut w, mut e, mut f): (f64, f64, f64, (f64, f64)) =
                (1.0, 0.0, 0.4, (0.0, 0.0));
            let mut here: f64 = 0.0;
            for _ in 0..60 {
                let a = match stepping {
                    Stepping::VelocityVerlet => -(positions + carried) * here,
                    _ => -positions * here - carried * w,
                };
                match stepping {
                    Stepping::LateAcceleration => {
                        let (x_half, v_half) = (here + 0.5 * step * f.0, h + 0.5 * step * f.1);
                        f = (v_half, -(positions + carried) * x_half);
                        here += step * f.0;
                        h += step * f.1;
                    }
                    _ => {
                        h += step * a;
                        here += step * h;
                        w += match stepping {
                            Stepping::LateDensity => step * e,
                            _ => step * (h + 0.5 * step * a),
                        };
                        e = h + 0.5 * step * a;
                    }
                }
                x.push(here);
            }
            // Every sequence of the run obeys the recurrence whose roots are those of the step.
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
