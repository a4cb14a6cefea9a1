//! What the linearized equations say of a wave, in continuous and in discrete time.

use super::VerifyError;
use crate::answers::Problem;
use nalgebra::{DMatrix, DVector};
use onset::algebra::Complex;
use onset::kinematics::DeformationGradient;
use onset::time_step::Stepping;
use serde::{Deserialize, Serialize};

/// A solution `exp(s t)`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Rate {
    /// `Re s`; 1/time.
    pub growth: f64,
    /// `Im s`; 1/time.
    pub frequency: f64,
}

impl Rate {
    /// Whether it grows or decays without a frequency, rounding apart.
    pub fn is_growth(&self) -> bool {
        self.frequency.abs() <= 1e-9 * self.growth.abs()
    }
}

impl From<Complex> for Rate {
    fn from(s: Complex) -> Self {
        Self {
            growth: s.re,
            frequency: s.im,
        }
    }
}

impl From<Rate> for Complex {
    fn from(rate: Rate) -> Self {
        Self::new(rate.growth, rate.frequency)
    }
}

/// A wave with its rates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Prediction {
    /// `omega^2` of the linearized equations; 1/time^2.
    pub omega_squared: f64,
    /// The direction of the displacements, a unit vector `g`.
    pub polarization: Vec<f64>,
    /// The vector `l`, `l . g = 1`, on which displacements are projected: across those of all other branches. It is `g` where `D` is symmetric.
    pub projection: Vec<f64>,
    /// The rates in discrete time: the growing one or the one with the positive frequency, and the other.
    pub rates: [Rate; 2],
    /// The rates of the other branches, one of each conjugate pair. In discrete time no projection leaves them out quite: what is carried along
    /// follows positions late, each branch in its own way.
    #[serde(default)]
    pub others: Vec<Rate>,
    /// How the code takes a time step.
    pub stepping: Stepping,
}

/// Imaginary parts of what should be real, and `omega^2` of what should be at rest, may be this share of the largest `omega^2` of all waves:
/// rounding.
const ROUNDING: f64 = 1e-10;
/// Solutions that fall by more than this in a step are of the stepping, not of the wave.
const FALL: f64 = 0.5;
/// The discrete rate may differ from that of the equations by this share.
const RESOLVED: f64 = 0.3;

/// `D(k)` as real numbers.
pub(super) fn matrix(
    problem: &Problem,
    f: &DeformationGradient,
    k: &[f64],
) -> Result<DMatrix<f64>, VerifyError> {
    let matrix = problem.analysis.waves(f)?.dynamical_matrix_at(k);
    let largest = matrix.iter().map(|z| z.norm()).fold(0.0, f64::max);
    if matrix.iter().any(|z| z.im.abs() > ROUNDING * largest) {
        return Err(VerifyError::Wave {
            what: "the wave is not standing: its dynamical matrix is complex".to_owned(),
            hint: "verify waves of a lattice with one particle in a cell".to_owned(),
        });
    }
    Ok(matrix.map(|z| z.re))
}

/// The mode with a number, counted from 1 by increasing `omega^2`: `omega^2`, and the polarization. `critical` is the largest stable step,
/// which tells the largest `omega^2`.
pub(super) fn mode(
    problem: &Problem,
    f: &DeformationGradient,
    k: &[f64],
    number: usize,
    critical: f64,
) -> Result<Mode, VerifyError> {
    let matrix = matrix(problem, f, k)?;
    let values = problem.analysis.waves(f)?.omega_squared(k);
    let Some(value) = number.checked_sub(1).and_then(|n| values.get(n)) else {
        return Err(VerifyError::Wave {
            what: format!("there is no branch {number}"),
            hint: format!(
                "branches are counted from 1 to {} by increasing omega^2",
                values.len()
            ),
        });
    };
    let largest = 4.0 / (critical * critical);
    if value.im.abs() > ROUNDING * largest {
        return Err(VerifyError::Wave {
            what: "this wave flutters: its omega^2 is complex".to_owned(),
            hint: "choose another --branch or --wave-vector".to_owned(),
        });
    }
    if value.re.abs() <= ROUNDING * largest {
        return Err(VerifyError::Wave {
            what: "this wave has zero energy: there is no rate to measure".to_owned(),
            hint: "choose another --branch or --wave-vector, or a stabilization other than 0"
                .to_owned(),
        });
    }
    Ok(Mode::of(&matrix, value.re))
}

/// A branch of a wave.
pub(super) struct Mode {
    pub(super) omega_squared: f64,
    /// As those of [`Prediction`].
    pub(super) polarization: Vec<f64>,
    projection: Vec<f64>,
}

impl Mode {
    /// Of an eigenvalue, by the direction that is nearest to an axis: of equal eigenvalues, the projection of an axis onto their space.
    fn of(matrix: &DMatrix<f64>, omega_squared: f64) -> Self {
        let n = matrix.nrows();
        let shifted = matrix - DMatrix::identity(n, n) * omega_squared;
        let limit = 1e-7 * (matrix.amax() + omega_squared.abs());
        let svd = shifted.svd(true, true);
        let limit = limit.max(svd.singular_values.min());
        let sizes = svd.singular_values.iter().enumerate();
        let own: Vec<usize> = sizes
            .filter(|(_, size)| **size <= limit)
            .map(|(i, _)| i)
            .collect();
        let (Some(left), Some(right)) = (svd.u, svd.v_t) else {
            return Self {
                omega_squared,
                polarization: vec![f64::NAN; n],
                projection: vec![f64::NAN; n],
            };
        };
        let (left, right) = (
            left.select_columns(&own),
            right.select_rows(&own).transpose(),
        );
        let onto = &right * right.transpose();
        // The first axis of those that are equally near.
        let mut nearest = 0;
        for axis in 1..n {
            if onto.column(axis).norm() > onto.column(nearest).norm() + 1e-6 {
                nearest = axis;
            }
        }
        let polarization = onto.column(nearest).normalize();
        // The projector onto the space along those of all others is `R (L^T R)^-1 L^T`; without one, branches that are about to flutter are parallel.
        let inverse = (left.transpose() * &right).try_inverse();
        let projector = inverse.map_or(onto, |inverse| right * inverse * left.transpose());
        let projection = projector.transpose() * &polarization;
        let told = |vector: &DVector<f64>| {
            let rounded = |x: &f64| if x.abs() < 1e-12 { 0.0 } else { *x };
            vector.iter().map(rounded).collect()
        };
        Self {
            omega_squared,
            polarization: told(&polarization),
            projection: told(&projection),
        }
    }
}

/// The rates in discrete time.
pub(super) fn predicted(
    problem: &Problem,
    f: &DeformationGradient,
    k: &[f64],
    mode: Mode,
    stepping: Stepping,
    step: f64,
) -> Result<Prediction, VerifyError> {
    let rates = stepping.rates(&problem.analysis.parts(f, k)?, step);
    let root = Complex::new(-mode.omega_squared, 0.0).sqrt();
    let near = |wanted: Complex| {
        let apart = |z: &&Complex| (*z - wanted).norm();
        let nearest = rates.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
        nearest.filter(|z| apart(z) <= RESOLVED * root.norm())
    };
    // Of a growing wave the growing solution goes first, of a traveling one that with the positive frequency.
    match (near(root), near(-root)) {
        (Some(first), Some(second)) => Ok(Prediction {
            omega_squared: mode.omega_squared,
            polarization: mode.polarization,
            projection: mode.projection,
            others: others(&rates, [*first, *second], step),
            rates: [(*first).into(), (*second).into()],
            stepping,
        }),
        _ => Err(VerifyError::Wave {
            what: format!("the time step {step:e} does not resolve the wave"),
            hint: "choose a smaller --time-step".to_owned(),
        }),
    }
}

/// Of all rates those of other branches: neither the branch's own, nor constants, nor solutions that vanish within a few steps.
fn others(rates: &[Complex], own: [Complex; 2], step: f64) -> Vec<Rate> {
    let least = ROUNDING.sqrt() * own[0].norm();
    let is_other = |z: &&Complex| {
        let is_own = own.iter().any(|own| (*z - own).norm() <= least);
        !is_own && z.norm() > least && z.re * step > -FALL
    };
    // Of real rates both are others; what is imaginary of them is rounding.
    let told = |rate: Rate| match rate.is_growth() {
        true => Rate {
            frequency: 0.0,
            ..rate
        },
        false => rate,
    };
    let others = rates.iter().filter(is_other).map(|z| told(Rate::from(*z)));
    others.filter(|rate| rate.frequency >= 0.0).collect()
}

#[cfg(test)]
mod tests {
    use super::others;
    use onset::algebra::Complex;

    #[test]
    fn both_real_rates_of_another_branch_and_one_of_each_conjugate_pair_are_its_own() {
        let rate = Complex::new;
        let own = [rate(-0.01, 1.0), rate(-0.01, -1.0)];
        let rates = [
            own[0],
            own[1],
            rate(0.98, -9e-17),
            rate(-0.99, 9e-17),
            rate(0.0, 2.0),
            rate(0.0, -2.0),
            // A constant, and what the stepping forgets.
            rate(1e-17, 0.0),
            rate(-90.0, 3.0),
        ];
        let told: Vec<Complex> = others(&rates, own, 0.05)
            .into_iter()
            .map(Into::into)
            .collect();
        assert_eq!(told, [rate(0.98, 0.0), rate(-0.99, 0.0), rate(0.0, 2.0)]);
    }
}
