//! The answer to: how do waves travel through the particles, and through the continuum?

use super::in_dimension_of;
use super::notes::notes;
use super::problem::{Problem, ProblemError, Strain, numbers};
use super::state::ComplexNumber;
use crate::figure::{Axis, Figure, Line, Panel, Rule, palette};
use crate::methods::Discretized;
use crate::number::{told_of, vector};
use crate::settings::Effective;
use nalgebra::{DMatrix, SMatrix, SVector};
use onset::algebra::{Complex, eigenvalues};
use onset::bloch::{DynamicalMatrix, WaveSystem, dynamical_matrix, growth_rate};
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

/// Frequencies along a path through the zone.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Diagram {
    /// What a reader must know of law and method.
    pub notes: Vec<String>,
    /// Every choice in effect.
    pub settings: Effective,
    /// The corners of the path: name, reference wave vector, and place along the path.
    pub corners: Vec<Corner>,
    /// The samples.
    pub samples: Vec<DispersionAnswer>,
    /// Length along the path of each sample.
    pub lengths: Vec<f64>,
}

/// A corner of a path through the zone.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Corner {
    /// Its name.
    pub name: &'static str,
    /// Its reference wave vector.
    pub wave_vector: Vec<f64>,
    /// Its place along the path.
    pub length: f64,
}

/// Samples on each leg of a path.
const SAMPLES: usize = 120;

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

impl Diagram {
    /// The usual path through the zone of the arrangement.
    ///
    /// # Errors
    /// [`ProblemError`] when the state cannot be evaluated.
    pub fn new(problem: &Problem, strain: &Strain) -> Result<Self, ProblemError> {
        in_dimension_of!(problem, along_path(problem, &strain.0))
    }

    /// What the diagram is of, with what a reader must know.
    pub fn told(&self) -> String {
        let notes = self.notes.iter().map(|note| format!("note: {note}\n\n"));
        format!("{}{}", notes.collect::<String>(), self.settings)
    }

    /// The samples as a table: length along the path, wave vector, `omega^2` of particles and continuum.
    pub fn csv(&self) -> String {
        let columns = |name: &str, count: usize| {
            (1..=count)
                .map(|n| format!("{name}_{n}"))
                .collect::<Vec<_>>()
        };
        let dimension = self
            .samples
            .first()
            .map_or(0, |sample| sample.wave_vector.len());
        let mut header = vec!["length".to_owned()];
        header.extend(columns("wave_vector", dimension));
        let branches = self
            .samples
            .first()
            .map_or(0, |sample| sample.omega_squared.len());
        header.extend(columns("omega_squared_re", branches));
        header.extend(columns("omega_squared_im", branches));
        header.extend(columns("continuum_omega_squared", dimension));
        let row = |(length, sample): (&f64, &DispersionAnswer)| {
            let particles = &sample.omega_squared;
            let numbers = std::iter::once(*length)
                .chain(sample.wave_vector.iter().copied())
                .chain(particles.iter().map(|value| value.re))
                .chain(particles.iter().map(|value| value.im))
                .chain(sample.continuum_omega_squared.iter().copied());
            numbers
                .map(|number| format!("{number:.16e}"))
                .collect::<Vec<_>>()
                .join(",")
        };
        let rows: Vec<String> = self.lengths.iter().zip(&self.samples).map(row).collect();
        format!("{}\n{}\n", header.join(","), rows.join("\n"))
    }

    /// The diagram as a figure: frequencies upward, growth rates downward.
    pub fn figure(&self, title: &str) -> Figure {
        let end = self.lengths.last().copied().unwrap_or(1.0);
        let branches = self
            .samples
            .first()
            .map_or(0, |sample| sample.omega_squared.len());
        let line = |value: &dyn Fn(&DispersionAnswer) -> f64| -> Vec<(f64, f64)> {
            self.lengths
                .iter()
                .zip(&self.samples)
                .map(|(x, sample)| (*x, value(sample)))
                .collect()
        };
        let mut lines = Vec::new();
        for n in 0..branches {
            // Cells with several particles have more branches than the continuum.
            let continuum = Line::new(line(&|sample| {
                let own = sample.continuum_omega_squared.get(n);
                own.map_or(f64::NAN, |own| signed_frequency(Complex::new(*own, 0.0)))
            }))
            .color(palette::GREY)
            .dashed();
            let particles = Line::new(line(&|sample| {
                let value = sample.omega_squared[n];
                signed_frequency(Complex::new(value.re, value.im))
            }))
            .color(palette::BLUE);
            lines.push(if n == 0 {
                continuum.named("continuum, √(eig Q(k)/ρ₀)")
            } else {
                continuum
            });
            lines.push(if n == 0 {
                particles.named("particles")
            } else {
                particles
            });
        }
        // The continuum's branches leave the picture: the particles' range decides.
        let heights = lines
            .iter()
            .skip(1)
            .step_by(2)
            .flat_map(|line| line.points.iter().map(|point| point.1));
        let (low, high) = heights.fold((0.0_f64, 0.0_f64), |(low, high), y| {
            (low.min(y), high.max(y))
        });
        let margin = if high > low { 0.15 * (high - low) } else { 1.0 };
        let y = Axis::linear(
            "frequency ω; below 0: growth rate (1/time)",
            (if low < 0.0 { low - margin } else { 0.0 }, high + margin),
        );
        let x = Axis::linear("reference wave vector k", (0.0, end)).ticks(
            self.corners
                .iter()
                .map(|corner| (corner.length, corner.name)),
        );
        let mut panel = Panel::new("", x, y);
        for corner in &self.corners {
            panel = panel.with(Rule::vertical(corner.length).color(palette::GREY).dotted());
        }
        panel = panel.with(Rule::horizontal(0.0).color(palette::BLACK));
        for line in lines {
            panel = panel.with(line);
        }
        Figure::new(title)
            .with(panel)
            .caption(self.settings.caption())
    }
}

/// `omega` of a wave, with the growth rate of an unstable one as a negative number.
fn signed_frequency(omega_squared: Complex) -> f64 {
    let growth = growth_rate(omega_squared);
    if omega_squared.re < 0.0 || growth > omega_squared.sqrt().re {
        -growth
    } else {
        omega_squared.sqrt().re
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
enum Matrix<const D: usize> {
    Kernel(Box<DynamicalMatrix<D>>),
    Scheme(Box<WaveSystem<D>>),
}

impl<const D: usize> Matrix<D> {
    fn new(
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
    fn at(&self, k: &SVector<f64, D>) -> (DMatrix<Complex>, Vec<Complex>) {
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

fn waves<const D: usize>(
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

fn along_path<const D: usize>(
    problem: &Problem,
    f: &DeformationGradient,
) -> Result<Diagram, ProblemError> {
    let method = Discretized::<D>::new(&problem.settings)?;
    let waves = waves::<D>(problem, f)?;
    let corners: Vec<(&'static str, SVector<f64, D>)> = problem
        .settings
        .zone()
        .zone_path::<D>()
        .into_iter()
        .map(|(name, fractional)| (name, method.lattice().reciprocal() * fractional))
        .collect();
    let mut diagram = Diagram {
        notes: notes(&problem.settings, &*problem.material),
        settings: problem.settings.effective(),
        corners: Vec::new(),
        samples: Vec::new(),
        lengths: Vec::new(),
    };
    let mut length = 0.0;
    for (n, (name, k)) in corners.iter().enumerate() {
        diagram.corners.push(Corner {
            name,
            wave_vector: k.iter().copied().collect(),
            length,
        });
        let Some((_, next)) = corners.get(n + 1) else {
            diagram.samples.push(waves(k));
            diagram.lengths.push(length);
            break;
        };
        for sample in 0..SAMPLES {
            let t = sample as f64 / SAMPLES as f64;
            diagram.samples.push(waves(&(k + (next - k) * t)));
            diagram.lengths.push(length + t * (next - k).norm());
        }
        length += (next - k).norm();
    }
    Ok(diagram)
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
