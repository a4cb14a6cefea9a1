//! Checks of a material: energy, symmetry, objectivity, continuity and others.

use super::convention::{Convention, StressChange};
use super::difference::{derivative, limit, steps};
use super::reading::{Delivery, ratio, relative_to};
use super::states::State;
use super::subject::{Sample, Subject, deformation};
use super::{AuditError, DISTINCTION_UNCERTAINTY, TOLERANCE};
use crate::number::told_of;
use nalgebra::{Matrix3, Matrix6, Rotation3};
use onset::kinematics::DeformationGradient;
use onset::material::FourthOrder;
use onset_umat::{UmatSettings, VOIGT};
use serde::Serialize;
use std::f64::consts::{SQRT_2, TAU};

/// Outcome of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// The material meets the requirement.
    Passed,
    /// The material violates the requirement.
    Failed,
    /// The differences of the stress are too inaccurate for a decision, as near a kink.
    Undetermined,
    /// Remark that is neither a success nor a failure.
    Noted,
}

/// A check with its result.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// Name of the check.
    pub name: &'static str,
    /// Outcome of the check.
    pub outcome: Outcome,
    /// Largest relative error, or `None` for checks without an error measure.
    pub error: Option<f64>,
    /// State of the largest error, unless the check passed.
    pub state: Option<State>,
    /// Description of the finding.
    pub finding: String,
}

impl Outcome {
    /// Name of the outcome in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Passed => "passed",
            Self::Failed => "failed",
            Self::Undetermined => "undetermined",
            Self::Noted => "noted",
        }
    }
}

impl Check {
    fn new(name: &'static str, error: f64, holds: &str, fails: &str) -> Self {
        let passed = error <= TOLERANCE;
        Self {
            name,
            outcome: if passed {
                Outcome::Passed
            } else {
                Outcome::Failed
            },
            error: Some(error),
            state: None,
            finding: if passed { holds } else { fails }.to_owned(),
        }
    }

    /// Check with one error for each state. The largest error decides, and the finding names its state.
    fn at_states(
        name: &'static str,
        measured: &[Measured],
        errors: &[f64],
        holds: &str,
        fails: &str,
    ) -> Self {
        let error = largest(errors.iter().copied());
        let mut check = Self::new(name, error, holds, fails);
        if check.outcome == Outcome::Failed {
            let worst = errors.iter().position(|at| *at == error || at.is_nan());
            check.state = worst.map(|at| measured[at].state());
            if let Some(state) = &check.state {
                check.finding = format!("{fails}: {}", state.sentence());
            }
        }
        check
    }

    /// Like [`Check::at_states`], for errors of finite differences: states at which these are too inaccurate cannot fail.
    fn by_differences(
        name: &'static str,
        measured: &[Measured],
        errors: &[f64],
        holds: &str,
        fails: &str,
    ) -> Self {
        let known = |(state, error): (&Measured, &f64)| if state.is_known() { *error } else { 0.0 };
        let of_known: Vec<f64> = measured.iter().zip(errors).map(known).collect();
        let check = Self::at_states(name, measured, &of_known, holds, fails);
        match check.outcome {
            Outcome::Passed => Self::at_states(name, measured, errors, holds, fails)
                .unless_unknown(uncertainty(measured)),
            _ => check,
        }
    }

    fn noted(name: &'static str, error: Option<f64>, finding: impl Into<String>) -> Self {
        Self {
            name,
            outcome: Outcome::Noted,
            error,
            state: None,
            finding: finding.into(),
        }
    }

    /// Changes a failure to `Undetermined` if the uncertainty of the differences is too large.
    fn unless_unknown(mut self, uncertainty: f64) -> Self {
        if uncertainty > DISTINCTION_UNCERTAINTY && self.outcome == Outcome::Failed {
            self.outcome = Outcome::Undetermined;
            self.finding = format!(
                "the stress is not smooth enough at these states: its differences are accurate only to {uncertainty:.0e}"
            );
        }
        self
    }

    /// Changes a failure to a remark for materials with a history, which may dissipate.
    fn excused(mut self, is_excused: bool) -> Self {
        if is_excused && self.outcome == Outcome::Failed {
            self.outcome = Outcome::Noted;
        }
        self
    }
}

/// State with the derivatives of stress and energy.
#[derive(Clone, Debug)]
pub struct Measured {
    pub sample: Sample,
    pub change: StressChange,
    /// `dW/dl_kl`, with the energy per reference volume, for `F' = (1 + l) F`.
    energy_gradient: Matrix3<f64>,
    /// Like `energy_gradient`, with the reported energy read as per reference instead of per current volume.
    reference_energy_gradient: Matrix3<f64>,
    /// Relative uncertainty of the derivative of the stress.
    pub uncertainty: f64,
    /// Relative half difference of the one-sided derivatives of the stress.
    kink: f64,
    /// Distance of stress and energy from their limits at the state, relative to the stress and energy of a small strain.
    jump: f64,
    /// Whether the material reports an energy here or nearby; at a stress-free state the energy may be zero.
    reports_energy: bool,
}

/// Strain whose stress is the smallest scale for relative errors. At a stress-free state, differences are pure rounding.
const SMALL_STRAIN: f64 = 1e-3;

impl Measured {
    /// Measures stress, energy and their derivatives at a state.
    ///
    /// # Errors
    /// [`AuditError`] when the material fails at the state or nearby.
    pub fn new(subject: &Subject<'_>, f: &DeformationGradient) -> Result<Self, AuditError> {
        // One batch of states: the state itself, then for each direction the steps forward and backward.
        let mut states = vec![*f];
        for direction in 0..9 {
            for sign in [1.0, -1.0] {
                for step in steps() {
                    let mut moved: Matrix3<f64> = Matrix3::identity();
                    moved[(direction / 3, direction % 3)] += sign * step;
                    states.push(deformation(&(moved * f.matrix()))?);
                }
            }
        }
        let samples = subject.samples_near(f, &states)?;
        let reports_energy = samples.iter().any(|sample| sample.energy != 0.0);
        let values: Vec<Vec<f64>> = samples
            .iter()
            .map(|sample| {
                let mut values: Vec<f64> = sample.cauchy.iter().copied().collect();
                values.push(sample.energy);
                values.push(sample.energy / sample.deformation.jacobian());
                values
            })
            .collect();
        let count = steps().count();
        let sides: Vec<_> = values[1..]
            .chunks_exact(2 * count)
            .map(|chunk| chunk.split_at(count))
            .collect();
        let derivatives: Vec<_> = sides
            .iter()
            .map(|(plus, minus)| derivative(plus, minus))
            .collect();
        // Matrices are stored by columns: component (i, j) is at 3 j + i.
        let gradient = FourthOrder::from_fn(|i, j, k, l| derivatives[3 * k + l].values[3 * j + i]);
        let size = derivatives
            .iter()
            .flat_map(|derivative| &derivative.values[..9])
            .fold(0.0, |largest: f64, value| largest.max(value.abs()));
        let of_size = |value: f64| if size > 0.0 { value / size } else { 0.0 };
        let uncertainty = derivatives
            .iter()
            .map(|derivative| derivative.uncertainty)
            .fold(0.0, f64::max);
        // A jump of the derivative is the difference between the mean of both sides and their common limit, divided by the step.
        let (mut kink, mut jump): (f64, f64) = (0.0, 0.0);
        let nearest = steps().last().unwrap_or_default();
        for (plus, minus) in &sides {
            let here = limit(plus, minus);
            let mean = |(plus, minus): (&Vec<f64>, &Vec<f64>)| -> Vec<f64> {
                let off = (0..10).map(|n| 0.5 * (plus[n] + minus[n]) - here.values[n]);
                off.collect()
            };
            let bends: Vec<Vec<f64>> = plus.iter().zip(*minus).map(mean).collect();
            let none = vec![vec![0.0; 10]; bends.len()];
            // Twice the central difference, applied to one side only.
            let bend = derivative(&bends, &none);
            let small = SMALL_STRAIN * size;
            for n in 0..10 {
                let slope = 2.0 * bend.values[n].abs();
                // A kink closer than the smallest step is not a jump.
                let off = (here.values[n] - values[0][n]).abs()
                    - 10.0 * here.uncertainty
                    - 2.0 * nearest * slope;
                let least = if n < 9 { small } else { SMALL_STRAIN * small };
                jump = largest([jump, ratio(off.max(0.0), least.max(values[0][n].abs()))]);
                if n < 9 {
                    kink = kink.max(slope - 20.0 * bend.uncertainty);
                }
            }
        }
        let of_energy = |n: usize| Matrix3::from_fn(|k, l| derivatives[3 * k + l].values[n]);
        let sample =
            samples
                .into_iter()
                .next()
                .ok_or(onset::material::MaterialError::NotFinite {
                    jacobian: f.jacobian(),
                })?;
        Ok(Self {
            change: StressChange {
                deformation: *f,
                increment: subject.last_increment(f)?,
                cauchy: sample.cauchy,
                gradient,
            },
            energy_gradient: of_energy(9),
            reference_energy_gradient: of_energy(10),
            uncertainty: of_size(uncertainty),
            kink: of_size(kink),
            jump,
            sample,
            reports_energy,
        })
    }

    /// Returns the description of the state.
    pub fn state(&self) -> State {
        State::new(&self.sample.deformation)
    }

    /// Returns true if the derivative of the stress is accurate enough and has no kink.
    pub fn is_known(&self) -> bool {
        self.uncertainty <= DISTINCTION_UNCERTAINTY && self.kink <= TOLERANCE
    }

    /// Largest relative error between a tangent and the differences that is accepted.
    pub fn tolerance(&self) -> f64 {
        TOLERANCE.max(10.0 * self.uncertainty)
    }

    /// Tolerance at a kink of the stress, where every tangent between the two one-sided derivatives is right. Zero if the differences are too
    /// inaccurate.
    pub fn tolerance_of_kink(&self) -> f64 {
        match self.uncertainty > DISTINCTION_UNCERTAINTY {
            true => 0.0,
            // Each of the nine directions may fall on either side of the kink.
            false => self.tolerance() + 3.0 * self.kink,
        }
    }

    fn small_stress(&self) -> f64 {
        SMALL_STRAIN * modulus(self)
    }

    /// Relative error of a Cauchy stress against the expected stress.
    pub fn stress_error(&self, stress: &Matrix3<f64>, expected: &Matrix3<f64>) -> f64 {
        relative_to(stress.as_slice(), expected.as_slice(), self.small_stress())
    }

    /// Relative error of an energy against the energy of this state.
    fn energy_error(&self, energy: f64) -> f64 {
        let small = SMALL_STRAIN * self.small_stress();
        relative_to(&[energy], &[self.sample.energy], small)
    }
}

/// Runs all checks except the identification of the tangent.
pub fn all(
    subject: &Subject<'_>,
    reference: &Measured,
    measured: &[Measured],
    is_small_strain_update: bool,
) -> Result<Vec<Check>, AuditError> {
    // The stress of a small-strain update has no energy, with or without state variables.
    let may_dissipate = is_small_strain_update || has_history(subject);
    let energy = energy(subject, measured, may_dissipate);
    let is_derivative = energy.outcome == Outcome::Passed;
    let mut checks = vec![
        reference_stress(reference),
        moduli(reference),
        stress_symmetry(measured),
        objectivity(subject, measured)?,
        energy,
        continuity(measured),
        closed_loops(subject, is_derivative, may_dissipate)?,
        material_symmetry(subject, measured)?,
        stress_tangent_symmetry(may_dissipate, measured),
        delivered_symmetry(subject, measured),
    ];
    if let Subject::User(umat) = subject {
        checks.push(memory(subject, measured)?);
        checks.push(increments(umat.settings(), measured)?);
    }
    Ok(checks)
}

fn size(matrix: &Matrix3<f64>) -> f64 {
    matrix.norm()
}

fn largest(errors: impl IntoIterator<Item = f64>) -> f64 {
    errors.into_iter().fold(0.0, |largest, error| {
        if error.is_nan() {
            f64::INFINITY
        } else {
            largest.max(error)
        }
    })
}

/// Returns true for materials with a history, whose dissipation is not an error.
fn has_history(subject: &Subject<'_>) -> bool {
    matches!(subject, Subject::User(umat) if umat.settings().state_variables > 0)
}

/// Stiffness of a state: the norm of the derivative of the stress.
fn modulus(state: &Measured) -> f64 {
    let gradient = &state.change.gradient;
    let mut sum = 0.0;
    for (i, j) in VOIGT {
        for (k, l) in VOIGT {
            sum += gradient[(i, j, k, l)].powi(2);
        }
    }
    sum.sqrt()
}

fn reference_stress(reference: &Measured) -> Check {
    let error = ratio(size(&reference.sample.cauchy), modulus(reference));
    Check::new(
        "reference stress",
        if error.is_nan() { f64::INFINITY } else { error },
        "the reference state is free of stress",
        "the reference state is not free of stress",
    )
}

/// Rounding error of a vanishing modulus, relative to the largest modulus.
const ROUNDING_OF_MODULI: f64 = 1e-11;

/// Eigenvalues of the elasticity of the reference configuration in an orthonormal basis of symmetric tensors, and their meaning.
fn moduli(reference: &Measured) -> Check {
    let c = Convention::JaumannKirchhoff.tangent(&reference.change, &reference.change.gradient);
    let weight = |a: usize| if a < 3 { 1.0 } else { SQRT_2 };
    let matrix = Matrix6::from_fn(|a, b| {
        let ((i, j), (k, l)) = (VOIGT[a], VOIGT[b]);
        0.5 * weight(a) * weight(b) * (c[(i, j, k, l)] + c[(k, l, i, j)])
    });
    let [least, largest] = nalgebra::SymmetricEigen::try_new(matrix, f64::EPSILON, 1000)
        .map_or([f64::NAN; 2], |eigen| {
            [eigen.eigenvalues.min(), eigen.eigenvalues.amax()]
        });
    let rounding = ROUNDING_OF_MODULI * largest;
    let (mut volumetric, mut whole) = (0.0, 0.0);
    for i in 0..3 {
        for j in 0..3 {
            volumetric += c[(i, i, j, j)];
            whole += c[(i, j, i, j)];
        }
    }
    let bulk = volumetric / 9.0;
    let shear = (whole - volumetric / 3.0) / 10.0;
    let young = 9.0 * bulk * shear / (3.0 * bulk + shear);
    let poisson = (3.0 * bulk - 2.0 * shear) / (2.0 * (3.0 * bulk + shear));
    let values = format!(
        "bulk modulus {}, shear modulus {}, Young's modulus {}, Poisson's ratio {} (averages over directions)",
        told_of(bulk, largest),
        told_of(shear, largest),
        told_of(young, largest),
        told_of(poisson, 1.0)
    );
    // Noise of the stress may exceed rounding; then the sign of the smallest eigenvalue is undecided.
    let noise = 10.0 * reference.uncertainty * largest;
    let (outcome, finding) = match least {
        _ if least.abs() > rounding && least.abs() <= noise && noise.is_finite() => (
            Outcome::Undetermined,
            format!(
                "{values}; positive definiteness is undecided: smallest eigenvalue {least:.3e}, accurate to {noise:.0e}"
            ),
        ),
        _ if least > rounding => (Outcome::Passed, values),
        _ if least < -rounding => (
            Outcome::Failed,
            format!("{values}; not positive definite: smallest eigenvalue {least:.3e}"),
        ),
        _ if shear.abs() <= rounding && bulk > rounding => (
            Outcome::Noted,
            format!("{values}; the shear modulus is zero to rounding, as in a fluid"),
        ),
        _ => (
            Outcome::Failed,
            format!("{values}; semidefinite: the smallest eigenvalue is zero to rounding"),
        ),
    };
    Check {
        name: "moduli",
        outcome,
        error: None,
        state: None,
        finding,
    }
    .unless_unknown(reference.uncertainty)
}

fn stress_symmetry(measured: &[Measured]) -> Check {
    let error = |state: &Measured| {
        let stress = &state.sample.cauchy;
        state.stress_error(stress, &stress.transpose())
    };
    Check::at_states(
        "symmetry of the stress",
        measured,
        &measured.iter().map(error).collect::<Vec<_>>(),
        "the Cauchy stress is symmetric",
        "the Cauchy stress is not symmetric: moments are not balanced",
    )
}

fn rotations() -> [Matrix3<f64>; 3] {
    [(0.9, -0.3, 0.4), (-1.7, 0.6, 2.2), (0.1, 1.2, -0.8)]
        .map(|(roll, pitch, yaw)| *Rotation3::from_euler_angles(roll, pitch, yaw).matrix())
}

fn objectivity(subject: &Subject<'_>, measured: &[Measured]) -> Result<Check, AuditError> {
    let mut errors = vec![0.0; measured.len()];
    for rotation in rotations() {
        let states = measured
            .iter()
            .map(|state| deformation(&(rotation * state.sample.deformation.matrix())))
            .collect::<Result<Vec<_>, _>>()?;
        for ((turned, state), error) in subject
            .samples(&states)?
            .iter()
            .zip(measured)
            .zip(&mut errors)
        {
            let expected = rotation * state.sample.cauchy * rotation.transpose();
            *error = largest([
                *error,
                state.stress_error(&turned.cauchy, &expected),
                state.energy_error(turned.energy),
            ]);
        }
    }
    Ok(Check::at_states(
        "objectivity",
        measured,
        &errors,
        "a rotated state has the rotated stress and the same energy",
        "the law depends on the observer: a rotated state has another stress or another energy",
    ))
}

fn energy(subject: &Subject<'_>, measured: &[Measured], may_dissipate: bool) -> Check {
    let name = "energy";
    if measured.iter().all(|state| !state.reports_energy) {
        return Check::noted(name, None, "no energy is reported (it is zero)");
    }
    // Power per reference volume: `P : F' = J sigma : l`.
    let errors = |of: fn(&Measured) -> &Matrix3<f64>| -> Vec<f64> {
        let error = |state: &Measured| {
            let kirchhoff = state.sample.deformation.jacobian() * state.sample.cauchy;
            state.stress_error(of(state), &kirchhoff)
        };
        measured.iter().map(error).collect()
    };
    let right = errors(|state| &state.energy_gradient);
    // Routines report SSE per current volume, as Abaqus expects it, or per reference volume; both readings are tried.
    let other = match subject {
        _ if subject.is_umat() => errors(|state| &state.reference_energy_gradient),
        _ => vec![f64::INFINITY; measured.len()],
    };
    let fits = |errors: &[f64]| errors.iter().filter(|error| **error <= TOLERANCE).count();
    let all = |errors: &[f64]| fits(errors) == measured.len();
    let holds = match (subject.is_umat(), all(&right), all(&other)) {
        (false, ..) => "the stress is the derivative of the energy",
        (_, true, true) => {
            "the stress is the derivative of the energy; at these states SSE per current and per reference volume cannot be distinguished"
        }
        (_, false, true) => {
            "the stress is the derivative of the energy; SSE is per reference volume (Abaqus takes it per current volume: its energy output requires SSE divided by J)"
        }
        _ => {
            "the stress is the derivative of the energy; SSE is per current volume, as Abaqus takes it"
        }
    };
    let likelier = if fits(&other) > fits(&right) {
        other
    } else {
        right
    };
    Check::by_differences(
        name,
        measured,
        &likelier,
        holds,
        "the stress is not the derivative of the reported energy",
    )
    .excused(may_dissipate)
}

/// Work along closed loops of deformation.
///
/// The trapezoidal rule is accurate to all orders on a smooth closed curve. It is not if the curve crosses a kink of the stress, although a stress
/// that is the derivative of an energy does no work along this loop either.
fn closed_loops(
    subject: &Subject<'_>,
    is_derivative: bool,
    may_dissipate: bool,
) -> Result<Check, AuditError> {
    const POINTS: usize = 64;
    const RADIUS: f64 = 0.1;
    let planes: [(usize, usize); 3] = [(0, 4), (1, 8), (2, 3)];
    // One scale for all loops, because in some planes a law may have no stress.
    let (mut left, mut moved): (f64, f64) = (0.0, 0.0);
    for (first, second) in planes {
        let unit = |n: usize| {
            let mut unit: Matrix3<f64> = Matrix3::zeros();
            unit[(n / 3, n % 3)] = RADIUS;
            unit
        };
        let angle = |n: usize| TAU * n as f64 / POINTS as f64;
        let states = (0..POINTS)
            .map(|n| {
                let (sine, cosine) = angle(n).sin_cos();
                // The loops avoid the reference configuration, where an error of second order would not show.
                let center = Matrix3::identity() + 0.5 * (unit(first) + unit(second));
                deformation(&(center + cosine * unit(first) + sine * unit(second)))
            })
            .collect::<Result<Vec<_>, _>>()?;
        let (mut work, mut turnover) = (0.0, 0.0);
        for (n, sample) in subject.samples(&states)?.iter().enumerate() {
            let (sine, cosine) = angle(n).sin_cos();
            let rate = cosine * unit(second) - sine * unit(first);
            let f = &sample.deformation;
            let inverse = f.matrix().try_inverse().unwrap_or_else(Matrix3::zeros);
            let piola = f.jacobian() * sample.cauchy * inverse.transpose();
            work += piola.dot(&rate);
            turnover += piola.dot(&rate).abs();
        }
        left = largest([left, work.abs()]);
        moved = moved.max(turnover);
    }
    let error = ratio(left, moved);
    if error > TOLERANCE && is_derivative {
        return Ok(Check::noted(
            "closed loops",
            Some(error),
            "closed loops of deformation seem to do net work although the stress is the derivative of the energy: quadrature across a kink",
        ));
    }
    Ok(Check::new(
        "closed loops",
        error,
        "closed loops of deformation do no net work",
        "closed loops of deformation do net work: no strain energy exists",
    )
    .excused(may_dissipate))
}

fn continuity(measured: &[Measured]) -> Check {
    Check::at_states(
        "continuity",
        measured,
        &measured.iter().map(|state| state.jump).collect::<Vec<_>>(),
        "stress and energy are continuous at the sampled states",
        "the stress or the energy jumps at a state: it is not the limit of its values nearby",
    )
}

fn material_symmetry(subject: &Subject<'_>, measured: &[Measured]) -> Result<Check, AuditError> {
    let mut error: f64 = 0.0;
    for rotation in rotations() {
        let states = measured
            .iter()
            .map(|state| deformation(&(state.sample.deformation.matrix() * rotation)))
            .collect::<Result<Vec<_>, _>>()?;
        for (turned, state) in subject.samples(&states)?.iter().zip(measured) {
            error = largest([
                error,
                state.stress_error(&turned.cauchy, &state.sample.cauchy),
            ]);
        }
    }
    let finding = match error <= TOLERANCE {
        true => "isotropic",
        false => "not isotropic",
    };
    Ok(Check::noted("material symmetry", Some(error), finding))
}

/// Largest uncertainty of the differences over the states.
pub(super) fn uncertainty(measured: &[Measured]) -> f64 {
    largest(measured.iter().map(|state| state.uncertainty))
}

/// Major symmetry of `dP/dF`, computed from the stress.
fn stress_tangent_symmetry(may_dissipate: bool, measured: &[Measured]) -> Check {
    let error = |state: &Measured| {
        let piola = Convention::FirstPiola.tangent(&state.change, &state.change.gradient);
        Delivery::Tensor(Box::new(piola)).asymmetry() - state.kink
    };
    Check::by_differences(
        "symmetry of dP/dF",
        measured,
        &measured.iter().map(error).collect::<Vec<_>>(),
        "differences of the stress have a symmetric dP/dF, as a strain energy requires",
        "no strain energy exists: differences of the stress have no symmetric dP/dF",
    )
    .excused(may_dissipate)
}

fn delivered_symmetry(subject: &Subject<'_>, measured: &[Measured]) -> Check {
    let error = largest(
        measured
            .iter()
            .map(|state| state.sample.delivery.asymmetry()),
    );
    let name = subject.tangent_name();
    let finding = match error <= TOLERANCE {
        true => format!("{name} has major symmetry"),
        false => format!("{name} has no major symmetry"),
    };
    Check::noted("symmetry of the tangent", Some(error), finding)
}

/// Checks that the stress does not depend on the states evaluated before.
fn memory(subject: &Subject<'_>, measured: &[Measured]) -> Result<Check, AuditError> {
    let states: Vec<DeformationGradient> = measured
        .iter()
        .rev()
        .map(|state| state.sample.deformation)
        .collect();
    let again = subject.samples(&states)?;
    let errors: Vec<f64> = again
        .iter()
        .rev()
        .zip(measured)
        .map(|(again, state)| state.stress_error(&again.cauchy, &state.sample.cauchy))
        .collect();
    Ok(Check::at_states(
        "memory",
        measured,
        &errors,
        "the stress does not depend on earlier calls",
        "the stress depends on earlier calls: data are kept outside the state variables (in Fortran: SAVE, COMMON)",
    ))
}

/// Reports how much the stress depends on the number of increments.
fn increments(settings: &UmatSettings, measured: &[Measured]) -> Result<Check, AuditError> {
    let more = UmatSettings {
        increments: 2 * settings.increments,
        ..settings.clone()
    };
    let umat = onset_umat::Umat::new(more).map_err(onset::material::MaterialError::from)?;
    let states: Vec<DeformationGradient> = measured
        .iter()
        .map(|state| state.sample.deformation)
        .collect();
    let finer = Subject::User(&umat).samples(&states)?;
    let error = largest(
        finer
            .iter()
            .zip(measured)
            .map(|(finer, state)| state.stress_error(&state.sample.cauchy, &finer.cauchy)),
    );
    let finding = match error <= TOLERANCE {
        true => "the stress does not depend on the number of increments".to_owned(),
        false => format!(
            "the stress changes by {error:.1e} with {} increments instead of {}: it is integrated along the path",
            2 * settings.increments,
            settings.increments
        ),
    };
    Ok(Check::noted("increments", Some(error), finding))
}
