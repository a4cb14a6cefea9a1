//! The answer to: how do waves travel through the particles, and through the continuum?

use super::notes::notes;
use super::problem::{Problem, ProblemError, Strain, numbers};
use super::state::ComplexNumber;
use crate::figure::{Axis, Figure, Line, Panel, Rule, palette};
use crate::number::{told_of, vector};
use crate::settings::Effective;
use onset::algebra::Complex;
use onset::analysis::PlaneWaves;
use onset::bloch::growth_rate;
use onset::kinematics::DeformationGradient;
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
        let waves = at_wave_vector(problem, &strain.0, wave_vector)?;
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
        along_path(problem, &strain.0)
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

fn at_wave_vector(
    problem: &Problem,
    f: &DeformationGradient,
    text: &str,
) -> Result<DispersionAnswer, ProblemError> {
    let components = numbers("--wave-vector", text)?;
    if components.len() != problem.dimension() {
        return Err(ProblemError::Numbers {
            what: "--wave-vector",
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

fn answer(waves: &dyn PlaneWaves, k: &[f64]) -> DispersionAnswer {
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

fn along_path(problem: &Problem, f: &DeformationGradient) -> Result<Diagram, ProblemError> {
    let waves = problem.analysis.waves(f)?;
    let corners = problem.analysis.zone_path(problem.settings.zone());
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
            wave_vector: k.clone(),
            length,
        });
        let Some((_, next)) = corners.get(n + 1) else {
            diagram.samples.push(answer(&*waves, k));
            diagram.lengths.push(length);
            break;
        };
        let leg: Vec<f64> = k.iter().zip(next).map(|(k, next)| next - k).collect();
        let size = leg.iter().map(|x| x * x).sum::<f64>().sqrt();
        for sample in 0..SAMPLES {
            let t = sample as f64 / SAMPLES as f64;
            let place: Vec<f64> = k.iter().zip(&leg).map(|(k, leg)| k + leg * t).collect();
            diagram.samples.push(answer(&*waves, &place));
            diagram.lengths.push(length + t * size);
        }
        length += size;
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
