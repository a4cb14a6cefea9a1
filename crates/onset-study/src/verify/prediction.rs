//! Linearized prediction of a wave, in continuous and in discrete time.

use super::VerifyError;
use crate::answers::Problem;
use nalgebra::{DMatrix, DVector, SVector};
use onset::algebra::Complex;
use onset::kinematics::DeformationGradient;
use onset::time_step::Stepping;
use serde::{Deserialize, Serialize};

/// Rate `s` of a solution `exp(s t)`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Rate {
    /// Growth rate `Re s`; 1/time.
    pub growth: f64,
    /// Angular frequency `Im s`; 1/time.
    pub frequency: f64,
}

impl Rate {
    /// Returns true if the solution grows or decays without oscillation, to rounding.
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

/// Wave with its predicted rates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Prediction {
    /// `omega^2` of the linearized equations; 1/time^2.
    pub omega_squared: f64,
    /// Direction of the displacements, a unit vector `g`.
    pub polarization: Vec<f64>,
    /// Projection vector `l` of the displacements, with `l . g = 1`, orthogonal to all other branches. It equals `g` if `D` is symmetric.
    pub projection: Vec<f64>,
    /// Rates in discrete time, with the growing rate or the rate with positive frequency first.
    pub rates: [Rate; 2],
    /// Rates of the other branches, one of each conjugate pair.
    ///
    /// In discrete time no projection removes these branches completely: integrated variables lag behind positions by an amount that depends on the
    /// branch.
    #[serde(default)]
    pub others: Vec<Rate>,
    /// Time integration of the code.
    pub stepping: Stepping,
}

/// Rounding error of `D(k)`, relative to the largest `omega^2` of all waves: for imaginary parts of real entries, and `omega^2` of neutral modes.
const MATRIX_TOLERANCE: f64 = 1e-10;
/// Largest decay per step of a solution that belongs to the wave; faster decay is an artifact of the integrator.
const MAX_DECAY_PER_STEP: f64 = 0.5;
/// Largest relative difference between the discrete rate and the rate in continuous time.
const MAX_RATE_DIFFERENCE: f64 = 0.3;

/// `D(k)` as a real matrix.
pub(super) fn matrix(
    problem: &Problem,
    f: &DeformationGradient,
    k: &[f64],
) -> Result<DMatrix<f64>, VerifyError> {
    let matrix = problem.analysis.waves(f)?.dynamical_matrix_at(k);
    let largest = matrix.iter().map(|z| z.norm()).fold(0.0, f64::max);
    if matrix
        .iter()
        .any(|z| z.im.abs() > MATRIX_TOLERANCE * largest)
    {
        return Err(VerifyError::Wave {
            what: "the wave is not standing: its dynamical matrix is complex".to_owned(),
            hint: "verify waves of a lattice with one particle in a cell".to_owned(),
        });
    }
    Ok(matrix.map(|z| z.re))
}

/// Branch with the given number, counted from 1 by increasing `omega^2`.
///
/// `critical` is the largest stable time step, which determines the largest `omega^2`.
pub(super) fn mode(
    problem: &Problem,
    f: &DeformationGradient,
    k: &[f64],
    number: usize,
    critical: f64,
) -> Result<Mode, VerifyError> {
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
    if value.im.abs() > MATRIX_TOLERANCE * largest {
        return Err(VerifyError::Wave {
            what: "this wave flutters: its omega^2 is complex".to_owned(),
            hint: "choose another --branch or --wave-vector".to_owned(),
        });
    }
    if value.re.abs() <= MATRIX_TOLERANCE * largest {
        return Err(without_rate(
            problem,
            f,
            k,
            number,
            MATRIX_TOLERANCE * largest,
        )?);
    }
    // A matrix that is zero to rounding is neither real nor complex.
    Ok(Mode::of(&matrix(problem, f, k)?, value.re))
}

/// Returns the reason why a wave has `omega^2 = 0` to rounding.
fn without_rate(
    problem: &Problem,
    f: &DeformationGradient,
    k: &[f64],
    number: usize,
    rounding: f64,
) -> Result<VerifyError, VerifyError> {
    let waves = problem.analysis.waves(f)?;
    let of_continuum = waves.continuum_omega_squared(k);
    let vector = SVector::from_fn(|i, _| k.get(i).copied().unwrap_or(0.0));
    let fractional = problem.analysis.fractional(&vector).into_iter();
    let is_translation = fractional
        .map(|x| (x - x.round()).abs())
        .all(|distance| distance <= MATRIX_TOLERANCE);
    let (why, hint) = if is_translation {
        (
            "its wave vector is zero or a reciprocal vector: all particles move by the same displacement",
            "choose another --wave-vector",
        )
    } else if problem.analysis.has_unstrained_wave(f, k)? {
        (
            "its strain is zero at every quadrature point",
            "choose another --branch or --wave-vector, or a stabilization other than 0",
        )
    } else if of_continuum
        .get(number - 1)
        .is_some_and(|own| own.abs() <= rounding)
    {
        (
            "the material does not resist it at this state, as a fluid does not resist shear",
            "choose another --branch, or a law that resists this wave",
        )
    } else {
        (
            "its stiffness passes through zero at this state",
            "choose another --stretch, --branch or --wave-vector",
        )
    };
    Ok(VerifyError::Wave {
        what: format!("this wave has zero energy, and no rate to measure: {why}"),
        hint: hint.to_owned(),
    })
}

/// Branch of a wave: `omega^2`, polarization and projection.
pub(super) struct Mode {
    pub(super) omega_squared: f64,
    /// Polarization and projection, as in [`Prediction`].
    pub(super) polarization: Vec<f64>,
    projection: Vec<f64>,
}

impl Mode {
    /// Mode of an eigenvalue.
    ///
    /// For equal eigenvalues the polarization is the projection of a coordinate axis onto the eigenspace, for the axis nearest to the eigenspace.
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
        // The first of several equally near axes.
        let mut nearest = 0;
        for axis in 1..n {
            if onto.column(axis).norm() > onto.column(nearest).norm() + 1e-6 {
                nearest = axis;
            }
        }
        let polarization = onto.column(nearest).normalize();
        // The projector onto this eigenspace along all others is `R (L^T R)^-1 L^T`. It does not exist at the onset of flutter, where branches
        // coalesce.
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

/// Rates of a mode in discrete time.
pub(super) fn predicted(
    problem: &Problem,
    f: &DeformationGradient,
    k: &[f64],
    mode: Mode,
    stepping: Stepping,
    step: f64,
) -> Result<Prediction, VerifyError> {
    let parts = problem.analysis.parts(f, &[k.to_vec()])?;
    let rates = stepping.rates(&parts[0], step);
    let root = Complex::new(-mode.omega_squared, 0.0).sqrt();
    let near = |wanted: Complex| {
        let apart = |z: &&Complex| (*z - wanted).norm();
        let nearest = rates.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
        nearest.filter(|z| apart(z) <= MAX_RATE_DIFFERENCE * root.norm())
    };
    // A growing wave lists the growing solution first, a traveling wave the one with positive frequency.
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

/// Rates of other branches: without the wave's two rates, constants, and solutions that vanish within a few steps.
fn others(rates: &[Complex], own: [Complex; 2], step: f64) -> Vec<Rate> {
    let least = MATRIX_TOLERANCE.sqrt() * own[0].norm();
    let is_other = |z: &&Complex| {
        let is_own = own.iter().any(|own| (*z - own).norm() <= least);
        !is_own && z.norm() > least && z.re * step > -MAX_DECAY_PER_STEP
    };
    // Both of two real rates belong to the other branch; their imaginary parts are rounding.
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
    fn other_branches_contribute_both_real_rates_or_one_of_a_conjugate_pair() {
        let rate = Complex::new;
        let own = [rate(-0.01, 1.0), rate(-0.01, -1.0)];
        let rates = [
            own[0],
            own[1],
            rate(0.98, -9e-17),
            rate(-0.99, 9e-17),
            rate(0.0, 2.0),
            rate(0.0, -2.0),
            // The last two rates belong to a constant, and to a solution that decays within a step.
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
