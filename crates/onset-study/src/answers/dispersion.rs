//! The answer to: how does a wave travel through the particles, and through the continuum?

use super::in_dimension_of;
use super::notes::notes;
use super::problem::{Problem, ProblemError, Strain, numbers};
use super::state::ComplexNumber;
use crate::methods::Discretized;
use crate::number::{told_of, vector};
use crate::settings::Effective;
use nalgebra::{DMatrix, SMatrix, SVector};
use onset::algebra::{Complex, eigenvalues};
use onset::bloch::{DynamicalMatrix, WaveSystem, dynamical_matrix};
use onset::continuum::Stiffness;
use onset::kinematics::DeformationGradient;
use onset::material::Hyperelastic;
use onset::method::{CurrentLattice, Discretization, Frame, MethodError};
use serde::Serialize;

/// The waves of one wave vector.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DispersionAnswer {
    /// Reference wave vector.
    pub wave_vector: Vec<f64>,
    /// `omega^2` of the discretization, by increasing real part.
    pub omega_squared: Vec<ComplexNumber>,
    /// `omega^2` of the continuum, the eigenvalues of `Q(k) / rho0`.
    pub continuum_omega_squared: Vec<f64>,
    /// `D(k)`.
    pub dynamical_matrix: Vec<Vec<ComplexNumber>>,
}

/// The waves of one wave vector, with what they are waves of.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Waves {
    /// The waves.
    #[serde(flatten)]
    pub waves: DispersionAnswer,
    /// What a reader must know of law and method.
    pub notes: Vec<String>,
    /// Every choice in effect.
    pub settings: Effective,
}

impl Waves {
    /// The waves of one reference wave vector, given as text.
    ///
    /// # Errors
    /// [`ProblemError`] when it has another dimension or the state cannot be evaluated.
    pub fn new(
        problem: &Problem,
        strain: &Strain,
        wave_vector: &str,
    ) -> Result<Self, ProblemError> {
        let waves = in_dimension_of!(problem, at_wave_vector(problem, &strain.0, wave_vector))?;
        Ok(Self {
            waves,
            notes: notes(&problem.settings, &*problem.material),
            settings: problem.settings.effective(),
        })
    }
}

fn at_wave_vector<const D: usize>(
    problem: &Problem,
    f: &DeformationGradient,
    text: &str,
) -> Result<DispersionAnswer, ProblemError> {
    let components = numbers("--wave-vector", text)?;
    if components.len() != D {
        return Err(ProblemError::Numbers {
            what: "--wave-vector",
            given: components.len(),
            expected: D.to_string(),
        });
    }
    let k = SVector::<f64, D>::from_fn(|i, _| components[i]);
    let value = k.amax() * problem.settings.discretization.spacing;
    if value > 1e6 {
        return Err(ProblemError::WaveVector { value });
    }
    Ok(waves::<D>(problem, f)?(&k))
}

/// The dynamical matrix of any discretization.
pub(super) enum Matrix<const D: usize> {
    Kernel(Box<DynamicalMatrix<D>>),
    Scheme(Box<WaveSystem<D>>),
}

impl<const D: usize> Matrix<D> {
    pub(super) fn new(
        method: &Discretized<D>,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
    ) -> Result<Self, MethodError> {
        Ok(match method {
            Discretized::Kernel(method) => {
                Self::Kernel(Box::new(dynamical_matrix(method, material, f)?))
            }
            Discretized::Scheme(scheme) => Self::Scheme(Box::new(scheme.waves(material, f)?)),
        })
    }

    /// `D(k)` and its eigenvalues.
    pub(super) fn at(&self, k: &SVector<f64, D>) -> (DMatrix<Complex>, Vec<Complex>) {
        match self {
            Self::Kernel(matrix) => {
                let d = matrix.at(k);
                let dynamic = DMatrix::from_fn(D, D, |i, j| d[(i, j)]);
                (dynamic, matrix.omega_squared(k).to_vec())
            }
            Self::Scheme(system) => (system.dynamical_matrix_at(k), system.omega_squared(k)),
        }
    }
}

/// The waves of a state at any wave vector.
pub(super) fn waves<const D: usize>(
    problem: &Problem,
    f: &DeformationGradient,
) -> Result<impl Fn(&SVector<f64, D>) -> DispersionAnswer, ProblemError> {
    let method = Discretized::<D>::new(&problem.settings)?;
    let matrix = Matrix::new(&method, &*problem.material, f)?;
    let response = problem.material.response(f).map_err(MethodError::from)?;
    let stiffness = Stiffness::<D>::of(&response);
    let Discretization {
        density,
        frame,
        lattice,
        ..
    } = problem.settings.discretization;
    let is_kernel = method.kernel().is_some();
    // On the regular arrangement particles that have not moved stand for deformed ones: there the wave vector is spatial,
    // and that of the reference F^T k.
    let to_reference = match (frame, lattice) {
        (Frame::Eulerian, CurrentLattice::Regular) if is_kernel => f.leading::<D>().transpose(),
        _ => SMatrix::identity(),
    };
    Ok(move |k: &SVector<f64, D>| {
        let (d, omega_squared) = matrix.at(k);
        let continuum = stiffness
            .acoustic_tensor(&(to_reference * k))
            .map(|entry| Complex::new(entry / density, 0.0));
        DispersionAnswer {
            wave_vector: k.iter().copied().collect(),
            omega_squared: omega_squared.into_iter().map(ComplexNumber::from).collect(),
            continuum_omega_squared: eigenvalues(&continuum, 0.0)
                .iter()
                .map(|value| value.re)
                .collect(),
            dynamical_matrix: d
                .row_iter()
                .map(|row| row.iter().map(|entry| (*entry).into()).collect())
                .collect(),
        }
    })
}

impl std::fmt::Display for Waves {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(formatter, "{}", self.waves)?;
        for note in &self.notes {
            writeln!(formatter, "note: {note}\n")?;
        }
        write!(formatter, "{}", self.settings)
    }
}

impl std::fmt::Display for DispersionAnswer {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(
            formatter,
            "reference wave vector  {}",
            vector(&self.wave_vector)
        )?;
        // What is rounding beside the largest is zero.
        let sizes = self
            .omega_squared
            .iter()
            .map(|value| value.re.hypot(value.im));
        let largest = sizes.fold(0.0, f64::max);
        for (n, value) in self.omega_squared.iter().enumerate() {
            let imaginary = match told_of(value.im, largest).as_str() {
                "0" => String::new(),
                text => match text.strip_prefix('-') {
                    Some(size) => format!(" - {size} i"),
                    None => format!(" + {text} i"),
                },
            };
            let continuum = self.continuum_omega_squared.get(n);
            let beside = continuum.map_or(String::new(), |own| {
                format!("   (continuum {})", told_of(*own, largest))
            });
            writeln!(
                formatter,
                "omega^2                {}{imaginary}{beside}",
                told_of(value.re, largest)
            )?;
        }
        Ok(())
    }
}
