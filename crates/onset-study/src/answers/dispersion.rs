//! Waves of one wave vector in the discretization and in the continuum.

use super::notes::notes;
use super::problem::{Problem, ProblemError, Strain, numbers};
use super::state::ComplexNumber;
use crate::caption;
use crate::csv::Table;
use crate::number::{told_of, vector};
use crate::settings::{Effective, Units};
use onset::algebra::Complex;
use onset::analysis::PlaneWaves;
use onset::kinematics::DeformationGradient;
use onset::method::MethodError;
use serde::Serialize;

/// Waves of one wave vector.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DispersionAnswer {
    /// Reference wave vector; 1/length.
    pub wave_vector: Vec<f64>,
    /// `omega^2` of the discretization, by increasing real part; 1/time^2.
    pub omega_squared: Vec<ComplexNumber>,
    /// `omega^2` of the continuum, the eigenvalues of `Q(k) / rho0`; 1/time^2.
    pub continuum_omega_squared: Vec<f64>,
    /// Dynamical matrix `D(k)`, by rows; 1/time^2.
    pub dynamical_matrix: Vec<Vec<ComplexNumber>>,
}

/// Waves of one wave vector, with notes and settings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Waves {
    /// Deformation gradient `F` of the state, by rows.
    pub deformation_gradient: [[f64; 3]; 3],
    /// Waves of discretization and continuum.
    #[serde(flatten)]
    pub waves: DispersionAnswer,
    /// Rates `s` of all solutions `exp(s t)` with damping and relaxation, fastest growth first; empty without either. 1/time.
    pub rates: Vec<ComplexNumber>,
    /// Notes on law and method.
    pub notes: Vec<String>,
    /// All settings in effect.
    pub settings: Effective,
}

impl Waves {
    /// Computes the waves of a reference wave vector, given as text.
    ///
    /// # Errors
    /// [`ProblemError`] when the wave vector has a wrong dimension or the state cannot be evaluated.
    pub fn new(
        problem: &Problem,
        strain: &Strain,
        wave_vector: &str,
    ) -> Result<Self, ProblemError> {
        let waves = at_wave_vector(problem, &strain.0, wave_vector)?;
        Ok(Self {
            deformation_gradient: *strain.0.components(),
            rates: rates(problem, &strain.0, &waves.wave_vector)?,
            waves,
            notes: notes(&problem.settings, &*problem.material),
            settings: problem.settings.effective(),
        })
    }
}

impl Waves {
    /// The waves as CSV, one row for each branch of the discretization; the continuum has `D` branches.
    pub fn csv(&self) -> String {
        let waves: Vec<_> = self.waves.omega_squared.iter().enumerate().collect();
        let continuum = &self.waves.continuum_omega_squared;
        Table::new(&waves, self.settings.units())
            .with("branch", "1", |(n, _)| n + 1)
            .with("omega_squared_re", "1/time^2", |(_, own)| own.re)
            .with("omega_squared_im", "1/time^2", |(_, own)| own.im)
            .with("continuum_omega_squared", "1/time^2", |(n, _)| {
                continuum.get(*n).copied()
            })
            .to_string()
    }
}

/// Rates of a wave vector with damping and relaxation; empty without either. In plane stress the thickness follows the disturbance, so that the tangent is
/// not a sum over the terms of the relaxation, which is then left out.
fn rates(
    problem: &Problem,
    f: &DeformationGradient,
    k: &[f64],
) -> Result<Vec<ComplexNumber>, ProblemError> {
    let analysis = &problem.analysis;
    let relaxed = problem.settings.material.relaxed();
    let rates = match relaxed.map_err(MethodError::from)? {
        Some(law) if problem.material.dimension() == 3 => analysis.relaxing(f, &law)?.rates(k),
        _ if analysis.is_damped() => {
            let frequencies = analysis.waves(f)?.frequencies(k).into_iter();
            // exp(-i omega t) = exp(s t).
            let mut rates: Vec<_> = frequencies
                .map(|own| Complex::new(own.im, -own.re))
                .collect();
            rates.sort_by(|a, b| b.re.total_cmp(&a.re).then(b.im.total_cmp(&a.im)));
            rates
        }
        _ => Vec::new(),
    };
    Ok(rates.into_iter().map(ComplexNumber::from).collect())
}

fn at_wave_vector(
    problem: &Problem,
    f: &DeformationGradient,
    text: &str,
) -> Result<DispersionAnswer, ProblemError> {
    let components = numbers("--wave-vector", text)?;
    if components.len() != problem.dimension() {
        return Err(ProblemError::Numbers {
            what: "--wave-vector",
            hint: String::new(),
            given: components.len(),
            expected: problem.dimension().to_string(),
        });
    }
    let largest = components
        .iter()
        .fold(0.0, |most: f64, x| most.max(x.abs()));
    let value = largest * problem.settings.discretization.spacing;
    if value > 1e6 {
        return Err(ProblemError::WaveVector { value });
    }
    Ok(answer(&*problem.analysis.waves(f)?, &components))
}

/// Computes the waves of a reference wave vector.
pub(super) fn answer(waves: &dyn PlaneWaves, k: &[f64]) -> DispersionAnswer {
    let omega_squared = waves.omega_squared(k);
    let matrix = waves.dynamical_matrix_at(k);
    DispersionAnswer {
        wave_vector: k.to_vec(),
        omega_squared: omega_squared.into_iter().map(ComplexNumber::from).collect(),
        continuum_omega_squared: waves.continuum_omega_squared(k),
        dynamical_matrix: matrix
            .row_iter()
            .map(|row| row.iter().map(|entry| (*entry).into()).collect())
            .collect(),
    }
}

impl std::fmt::Display for Waves {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let units = self.settings.units();
        let state =
            caption::configuration(&self.deformation_gradient, self.waves.wave_vector.len());
        writeln!(formatter, "state                  {state}")?;
        self.waves.tell(formatter, units)?;
        let largest = self.rates.iter().map(|own| own.re.hypot(own.im));
        let largest = largest.fold(0.0, f64::max);
        for rate in &self.rates {
            let told = complex(rate, largest);
            writeln!(
                formatter,
                "rate                   {}",
                units.of(told, "1/s")
            )?;
        }
        writeln!(formatter)?;
        for note in &self.notes {
            writeln!(formatter, "note: {note}\n")?;
        }
        write!(formatter, "{}", self.settings.in_continuous_time())
    }
}

/// Text of a complex number, for rounding of the size of the largest one.
fn complex(value: &ComplexNumber, largest: f64) -> String {
    let real = told_of(value.re, largest);
    match told_of(value.im, largest).as_str() {
        "0" => real,
        text => match text.strip_prefix('-') {
            Some(size) => format!("{real} - {size} i"),
            None => format!("{real} + {text} i"),
        },
    }
}

impl DispersionAnswer {
    /// Writes the waves as lines of text.
    fn tell(&self, formatter: &mut std::fmt::Formatter<'_>, units: Units) -> std::fmt::Result {
        writeln!(
            formatter,
            "reference wave vector  {}",
            units.of(vector(&self.wave_vector), "1/m")
        )?;
        // Values within rounding of the largest value are printed as zero.
        let sizes = self
            .omega_squared
            .iter()
            .map(|value| value.re.hypot(value.im));
        let largest = sizes.fold(0.0, f64::max);
        for (n, value) in self.omega_squared.iter().enumerate() {
            let continuum = self.continuum_omega_squared.get(n);
            let beside = continuum.map_or(String::new(), |own| {
                let own = units.of(told_of(*own, largest), "1/s^2");
                format!("   (continuum {own})")
            });
            writeln!(
                formatter,
                "omega^2                {}{beside}",
                units.of(complex(value, largest), "1/s^2")
            )?;
        }
        Ok(())
    }
}
