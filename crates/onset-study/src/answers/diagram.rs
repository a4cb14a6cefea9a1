//! Dispersion diagram: frequencies and growth rates along a path through the zone, with the critical wave and the density of states.

use super::dispersion::{DispersionAnswer, answer};
use super::mode::{critical_mode, finite_wave_vector};
use super::notes::notes;
use super::problem::{Problem, ProblemError, Strain};
use super::state::{ComplexNumber, list};
use super::zone_path::{CRITICAL, SymmetryPoints, ZonePath};
use crate::caption;
use crate::compare::percent;
use crate::csv::Table;
use crate::figure::{Axis, Color, Figure, Line, Panel, Points, Rule, palette};
use crate::number::{told, told_of, vector};
use crate::output::{Files, picture, text};
use crate::settings::Effective;
use nalgebra::Vector3;
use onset::algebra::Complex;
use onset::analysis::Analysis;
use onset::bloch::growth_rate;
use onset::cancel::Scope;
use onset::kinematics::DeformationGradient;
use onset::verdict::{Assessment, WEAK_WAVE_RATIO};
use rayon::prelude::*;
use serde::Serialize;

/// Number of samples on each leg of a path.
const SAMPLES: usize = 120;
/// Number of wave vectors for the density of states along each reciprocal vector, by dimension. The grid avoids the points of high symmetry, where
/// branches are flat.
const GRID: [usize; 3] = [4096, 160, 28];
/// Number of frequency intervals of the density of states.
const BINS: usize = 80;
/// Growth rates below this fraction of the largest frequency are rounding errors.
const RATE_ROUNDING: f64 = 1e-7;

/// Frequencies along a path through the zone.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Diagram {
    /// Notes on law and method.
    pub notes: Vec<String>,
    /// All settings in effect.
    pub settings: Effective,
    /// Deformation gradient of the state.
    #[serde(skip)]
    pub deformation_gradient: [[f64; 3]; 3],
    /// Corners of the path: name, reference wave vector, and position along the path.
    pub corners: Vec<Corner>,
    /// Samples along the path. If the dynamical matrix is not periodic, they are taken at the equivalent wave vectors of the first zone.
    pub samples: Vec<DispersionAnswer>,
    /// Length of the path up to each sample, 1/length; two samples at the same position mark a jump.
    pub lengths: Vec<f64>,
    /// Plotted values of each sample.
    pub heights: Vec<Heights>,
    /// The fastest growing or softest wave.
    pub critical: CriticalWave,
    /// Density of states over the whole zone.
    pub density_of_states: DensityOfStates,
    /// Largest frequency of waves that the figure marks as weakly controlled, relative to the slowest wave of the continuum.
    pub weak: f64,
}

/// Plotted values of one wave vector: frequencies upward, growth rates downward. 1/time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Heights {
    /// Frequency of each wave of the discretization, `Re omega`; for waves that do not oscillate, the negative growth rate.
    pub particles: Vec<f64>,
    /// Frequency of each wave of the continuum, with the same sign convention.
    pub continuum: Vec<f64>,
    /// Negative of the largest growth rate of the oscillating waves; `null` if all growth rates are zero to rounding.
    pub flutter: Option<f64>,
}

/// Corner of a path through the zone.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Corner {
    /// Name of the point. Images of one point that the state distinguishes have primes.
    pub name: String,
    /// Reference wave vector of the corner; 1/length.
    pub wave_vector: Vec<f64>,
    /// Length of the path up to the corner; 1/length.
    pub length: f64,
}

/// The fastest growing wave of the zone, or the softest wave if the state is stable.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CriticalWave {
    /// Whether no wave grows.
    pub stable: bool,
    /// `omega^2` of the wave; 1/time^2.
    pub omega_squared: ComplexNumber,
    /// Growth rate, zero if stable; 1/time.
    pub growth_rate: f64,
    /// Plotted value: the negative growth rate, or the frequency if stable. 1/time.
    pub height: f64,
    /// Reference wave vector, zero in the limit of long waves; 1/length.
    pub wave_vector: Vec<f64>,
    /// Wave vector in the deformed lattice, `F^-T k`; 1/length.
    pub spatial_wave_vector: Vec<f64>,
    /// Name of the wave vector; `None` unless it is a point of high symmetry.
    pub point: Option<String>,
    /// Length of the path up to the wave, 1/length; `None` in the limit of long waves.
    pub length: Option<f64>,
}

/// Density of states, normalized to an integral of one.
///
/// The density is the fraction of all waves of the zone in an interval of frequency, divided by its width. Waves that grow without oscillating count
/// at their negative growth rate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DensityOfStates {
    /// The ends of the intervals; 1/time.
    pub edges: Vec<f64>,
    /// The density in each interval; time.
    pub density: Vec<f64>,
    /// Number of waves that were counted.
    pub waves: usize,
}

impl Diagram {
    /// Computes the diagram along the points of high symmetry that the state distinguishes, or along a given path, and along the line through the
    /// critical wave vector.
    ///
    /// # Errors
    /// [`ProblemError`] when the state cannot be evaluated, or the path is invalid.
    pub fn new(
        problem: &Problem,
        strain: &Strain,
        path: Option<&str>,
    ) -> Result<Self, ProblemError> {
        let assessment = problem.analysis.assess(&strain.0)?;
        Self::of(problem, strain, &assessment, path)
    }

    /// Computes the diagram of an assessed state.
    ///
    /// # Errors
    /// Fails like [`Diagram::new`].
    pub fn of(
        problem: &Problem,
        strain: &Strain,
        assessment: &Assessment<3>,
        path: Option<&str>,
    ) -> Result<Self, ProblemError> {
        diagram(problem, &strain.0, assessment, path)
    }

    /// Marks waves as weakly controlled below this fraction of the slowest wave of the continuum.
    pub fn weak_below(self, weak: f64) -> Self {
        Self { weak, ..self }
    }

    /// Text output: critical wave, notes and settings.
    pub fn told(&self) -> String {
        let notes = self.notes.iter().map(|note| format!("note: {note}\n\n"));
        format!(
            "{}\n{}{}",
            self.critical_lines(),
            notes.collect::<String>(),
            self.settings.in_continuous_time()
        )
    }

    fn critical_lines(&self) -> String {
        let wave = &self.critical;
        let mut text = String::new();
        let mut line = |name: &str, value: String| text.push_str(&format!("{name:<24}{value}\n"));
        let corners: Vec<&str> = self
            .corners
            .iter()
            .map(|corner| corner.name.as_str())
            .collect();
        line("state", self.state());
        line("path", corners.join(" "));
        let size = largest(&self.samples).powi(2);
        let imaginary = match told_of(wave.omega_squared.im, size).as_str() {
            "0" => String::new(),
            im => format!(
                " {} {} i",
                if im.starts_with('-') { '-' } else { '+' },
                im.trim_start_matches('-')
            ),
        };
        let units = self.settings.units();
        let omega_squared = format!("{}{imaginary}", told_of(wave.omega_squared.re, size));
        let omega_squared = units.of(omega_squared, "1/s^2");
        let is_long = wave.length.is_none();
        let place = match &wave.point {
            Some(point) => format!(", {point}"),
            None => String::new(),
        };
        let at = format!(
            "{} (reference), {} (deformed){place}",
            units.of(vector(&wave.wave_vector), "1/m"),
            units.of(vector(&wave.spatial_wave_vector), "1/m")
        );
        match (wave.stable, is_long) {
            (false, _) => {
                line("critical wave vector k*", at);
                line("  its omega^2", omega_squared);
                line("  growth rate", units.of(told(wave.growth_rate), "1/s"));
            }
            (true, false) => {
                line("softest wave vector k*", at);
                line("  its omega^2", omega_squared);
            }
            (true, true) => line(
                "softest waves",
                "long waves: no wave vector is marked".to_owned(),
            ),
        }
        text
    }

    /// Lowest plotted value: the negative of the largest growth rate, or the lowest frequency; 1/time.
    pub fn lowest(&self) -> f64 {
        let drawn = self.heights.iter().flat_map(|heights| {
            let particles = heights.particles.iter().copied();
            particles.chain(heights.flutter)
        });
        drawn.fold(f64::INFINITY, f64::min)
    }

    /// The samples as CSV: position along the path, wave vector, `omega^2` of discretization and continuum.
    pub fn csv(&self) -> String {
        let dimension = self
            .samples
            .first()
            .map_or(0, |sample| sample.wave_vector.len());
        let branches = self.branches();
        let samples: Vec<_> = self.lengths.iter().zip(&self.samples).collect();
        Table::new(&samples, self.settings.units())
            .with("length", "1/length", |(length, _)| **length)
            .each("wave_vector", dimension, "1/length", |(_, own), n| {
                own.wave_vector[n]
            })
            .each("omega_squared_re", branches, "1/time^2", |(_, own), n| {
                own.omega_squared[n].re
            })
            .each("omega_squared_im", branches, "1/time^2", |(_, own), n| {
                own.omega_squared[n].im
            })
            .each(
                "continuum_omega_squared",
                dimension,
                "1/time^2",
                |(_, own), n| own.continuum_omega_squared[n],
            )
            .to_string()
    }

    /// The density of states as CSV: the ends of each interval, and the density in it.
    pub fn density_csv(&self) -> String {
        let DensityOfStates { edges, density, .. } = &self.density_of_states;
        let intervals: Vec<_> = edges.windows(2).zip(density).collect();
        Table::new(&intervals, self.settings.units())
            .with("from", "1/time", |(ends, _)| ends[0])
            .with("to", "1/time", |(ends, _)| ends[1])
            .with("density", "time", |(_, density)| **density)
            .to_string()
    }

    fn branches(&self) -> usize {
        let first = self.samples.first();
        first.map_or(0, |sample| sample.omega_squared.len())
    }

    /// Curve along the path, interrupted at jumps.
    fn curve(&self, value: impl Fn(&Heights) -> f64) -> Vec<(f64, f64)> {
        let mut points: Vec<(f64, f64)> = Vec::new();
        for (x, heights) in self.lengths.iter().zip(&self.heights) {
            if points.last().is_some_and(|last| last.0 == *x) {
                points.push((f64::NAN, f64::NAN));
            }
            points.push((*x, value(heights)));
        }
        points
    }

    /// The figure `dispersion`, and the files `dispersion.csv` and `density-of-states.csv`.
    pub fn files(&self) -> Files {
        vec![
            picture(
                "dispersion",
                self.figure("Dispersion of particles and continuum"),
            ),
            text("dispersion.csv", self.csv()),
            text("density-of-states.csv", self.density_csv()),
        ]
    }

    /// The state as text.
    fn state(&self) -> String {
        let first = self.samples.first();
        let dimension = first.map_or(3, |sample| sample.wave_vector.len());
        caption::configuration(&self.deformation_gradient, dimension)
    }

    /// Draws frequencies upward and growth rates downward, with the density of states in a second panel.
    pub fn figure(&self, title: &str) -> Figure {
        let (mut of_continuum, mut of_particles) = (Vec::new(), Vec::new());
        for n in 0..self.branches() {
            // Cells with several particles have more branches than the continuum.
            of_continuum.push(self.curve(|own| own.continuum.get(n).copied().unwrap_or(f64::NAN)));
            of_particles.push(self.curve(|own| own.particles[n]));
        }
        let flutters = self.curve(|own| own.flutter.unwrap_or(f64::NAN));
        // The range of the discretization determines the axis; branches of the continuum may leave the panel.
        let heights = of_particles
            .iter()
            .flatten()
            .chain(&flutters)
            .map(|point| point.1);
        let (low, high) = heights
            .filter(|y| y.is_finite())
            .fold((0.0_f64, 0.0_f64), |(low, high), y| {
                (low.min(y), high.max(y))
            });
        let margin = if high > low { 0.1 * (high - low) } else { 1.0 };
        // In a stable state values below zero are rounding errors.
        let grows = low < 0.0 && !self.critical.stable;
        let range = (if grows { low - margin } else { 0.0 }, high + margin);
        let units = self.settings.units();
        let y = match grows {
            true => caption::label(units, "frequency ω or −(growth\u{a0}rate)", "1/time"),
            false => caption::label(units, "frequency ω", "1/time"),
        };
        let y = Axis::linear(y, range);
        let end = self.lengths.last().copied().unwrap_or(1.0);
        let x = Axis::linear("reference wave vector k", (0.0, end)).ticks(self.ticks());
        let mut panel = Panel::new("", x, y.clone()).wider(1.0 + 0.12 * self.corners.len() as f64);
        for (length, _) in self.ticks() {
            panel = panel.with(Rule::vertical(length).color(palette::GREY).dotted());
        }
        panel = panel.with(Rule::horizontal(0.0).color(palette::BLACK));
        let named = |lines: Vec<Vec<(f64, f64)>>, style: &dyn Fn(Line) -> Line, name: &str| {
            let line = |(n, points)| match n {
                0 => style(Line::new(points)).named(name),
                _ => style(Line::new(points)),
            };
            lines.into_iter().enumerate().map(line).collect::<Vec<_>>()
        };
        let grey = |line: Line| line.color(palette::GREY).dashed();
        let blue = |line: Line| line.color(palette::BLUE);
        let lines = named(of_continuum, &grey, "continuum, √(eig Q(k)/ρ₀)");
        for line in lines
            .into_iter()
            .chain(named(of_particles, &blue, "particles"))
        {
            panel = panel.with(line);
        }
        for (kind, name, color) in self.kinds() {
            let lines = (0..self.branches()).map(|n| self.branch(n, kind));
            let lines = lines.filter(|points| points.iter().any(|point| point.1.is_finite()));
            for line in lines {
                panel = panel.with(Line::new(line).width(4.0).color(color).named(&name));
            }
        }
        if flutters.iter().any(|point| point.1.is_finite()) {
            let line = Line::new(flutters).color(numerical()).dashed();
            panel = panel.with(line.named("growth rate of oscillating waves (flutter)"));
        }
        if let Some(marked) = self.marked() {
            panel = panel.with(marked);
        }
        Figure::new(title)
            .columns(2)
            .with(panel)
            .with(self.density_panel(y))
            .caption(format!(
                "State: {}. {}",
                self.state(),
                caption::settings(&self.settings)
            ))
    }

    /// Marked kinds of waves, with their names and colors.
    fn kinds(&self) -> [(Kind, String, Color); 3] {
        let physical = palette::verdict("physical").unwrap_or(palette::BLACK);
        let weak = palette::verdict("zero-energy").unwrap_or(palette::PURPLE);
        let share = percent(self.weak);
        [
            (
                Kind::Weak,
                format!("weakly controlled: below {share} of the slowest wave of the continuum"),
                weak,
            ),
            (
                Kind::Physical,
                "growing; a wave of the continuum grows too".to_owned(),
                physical,
            ),
            (
                Kind::Numerical,
                "growing; no wave of the continuum grows".to_owned(),
                numerical(),
            ),
        ]
    }

    /// Parts of a branch with waves of one kind.
    fn branch(&self, n: usize, kind: Kind) -> Vec<(f64, f64)> {
        let noise = RATE_ROUNDING * largest(&self.samples);
        self.curve(
            |own| match Kind::of(own, n, self.weak, noise) == Some(kind) {
                true => own.particles[n],
                false => f64::NAN,
            },
        )
    }

    /// Names of the corners; at a jump one tick carries both names.
    fn ticks(&self) -> Vec<(f64, String)> {
        let mut ticks: Vec<(f64, String)> = Vec::new();
        for corner in &self.corners {
            match ticks.last_mut().filter(|last| last.0 == corner.length) {
                Some(last) => last.1 = format!("{}|{}", last.1, corner.name),
                None => ticks.push((corner.length, corner.name.clone())),
            }
        }
        ticks
    }

    /// Marker of the critical wave, with its position.
    fn marked(&self) -> Option<Points> {
        let wave = &self.critical;
        let at = wave.length?;
        let units = self.settings.units();
        let k = units.of(vector(&wave.wave_vector), "1/m");
        let name = match wave.stable {
            true => format!("softest wave, k* = {k}"),
            false => {
                let rate = units.of(told(wave.growth_rate), "1/s");
                format!("fastest growing wave, k* = {k}: growth rate {rate}")
            }
        };
        let marker = Points::new(vec![(at, wave.height)]).color(palette::VERMILION);
        Some(marker.size(9.0).named(name))
    }

    fn density_panel(&self, y: Axis) -> Panel {
        let DensityOfStates { edges, density, .. } = &self.density_of_states;
        let mut outline = Vec::with_capacity(2 * density.len() + 2);
        for (ends, value) in edges.windows(2).zip(density) {
            outline.push((*value, ends[0]));
            outline.push((*value, ends[1]));
        }
        let most = density.iter().copied().fold(0.0, f64::max);
        let label = caption::label(self.settings.units(), "density of states", "time");
        let x = Axis::linear(label, (0.0, 1.08 * most));
        Panel::new("", x, y)
            .wider(0.35)
            .with(Rule::horizontal(0.0).color(palette::BLACK))
            .with(Line::new(outline).color(palette::BLUE))
    }
}

/// Color of waves that grow only in the discretization.
fn numerical() -> Color {
    palette::verdict("numerical").unwrap_or(palette::ORANGE)
}

/// Kind of a wave of the discretization that the figure marks.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// Its frequency is a small fraction of the slowest wave of the continuum.
    Weak,
    /// The wave grows, and so does a wave of the continuum with the same wave vector.
    Physical,
    /// The wave grows, but no wave of the continuum with the same wave vector does.
    Numerical,
}

impl Kind {
    /// Kind of the `n`-th wave of a sample; `None` for waves that are not marked. Weakly controlled waves are below the fraction `weak` of the slowest
    /// wave. Values up to `noise` are rounding errors.
    fn of(heights: &Heights, n: usize, weak: f64, noise: f64) -> Option<Self> {
        let slowest = heights
            .continuum
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min);
        match heights.particles[n] {
            height if height < -noise && slowest < -noise => Some(Self::Physical),
            height if height < -noise => Some(Self::Numerical),
            height if slowest > noise && height < weak * slowest => Some(Self::Weak),
            _ => None,
        }
    }
}

/// Frequency of a wave; for a wave that does not oscillate, the negative growth rate.
fn frequency(omega_squared: ComplexNumber) -> f64 {
    let value = Complex::new(omega_squared.re, omega_squared.im);
    let (oscillation, growth) = (value.sqrt().re.abs(), growth_rate(value));
    if growth > oscillation {
        -growth
    } else {
        oscillation
    }
}

/// Growth rate of a wave that also oscillates; zero for other waves.
fn flutter(omega_squared: ComplexNumber) -> f64 {
    let value = Complex::new(omega_squared.re, omega_squared.im);
    let growth = growth_rate(value);
    match growth <= value.sqrt().re.abs() {
        true => growth,
        false => 0.0,
    }
}

/// Largest frequency of the samples; growth rates count as frequencies.
fn largest(samples: &[DispersionAnswer]) -> f64 {
    let values = samples.iter().flat_map(|sample| &sample.omega_squared);
    values
        .map(|value| value.re.hypot(value.im))
        .fold(0.0, f64::max)
        .sqrt()
}

fn heights(samples: &[DispersionAnswer]) -> Vec<Heights> {
    let noise = RATE_ROUNDING * largest(samples);
    let of_sample = |sample: &DispersionAnswer| {
        let waves = &sample.omega_squared;
        let fastest = waves.iter().map(|own| flutter(*own)).fold(0.0, f64::max);
        let of_continuum = |own: &f64| frequency(ComplexNumber { re: *own, im: 0.0 });
        Heights {
            particles: waves.iter().map(|own| frequency(*own)).collect(),
            continuum: sample
                .continuum_omega_squared
                .iter()
                .map(of_continuum)
                .collect(),
            flutter: (fastest > noise).then_some(-fastest),
        }
    };
    samples.iter().map(of_sample).collect()
}

fn diagram(
    problem: &Problem,
    f: &DeformationGradient,
    assessment: &Assessment<3>,
    typed: Option<&str>,
) -> Result<Diagram, ProblemError> {
    let analysis = &*problem.analysis;
    let dimension = analysis.dimension();
    let waves = analysis.waves(f)?;
    let omega_squared = |k: &Vector3<f64>| waves.omega_squared(&waves.folded(k.as_slice()));
    let symmetry = SymmetryPoints::new(analysis, problem.settings.named_zone(), omega_squared);
    let mut path = match typed {
        Some(text) => symmetry.typed(text)?,
        None => symmetry.path(),
    };
    let mode = critical_mode(assessment);
    let critical = finite_wave_vector(mode);
    if critical.norm() > 0.0 {
        path.through(&critical, waves.reach(critical.as_slice()));
    }
    let at = |k: &Vector3<f64>| answer(&*waves, &waves.folded(k.as_slice()));
    let Sampled {
        corners,
        samples,
        lengths,
    } = sampled(dimension, &path, at);
    let growth = assessment.spectrum.growth_rate();
    let place = corners.iter().rev().find(|corner| corner.name == CRITICAL);
    // A translation that strains the body grows at `k = 0`, which is on every path.
    let at_zero = corners
        .iter()
        .find(|corner| growth > 0.0 && corner.wave_vector.iter().all(|x| *x == 0.0));
    Ok(Diagram {
        notes: notes(&problem.settings, &*problem.material),
        settings: problem.settings.effective(),
        deformation_gradient: *f.components(),
        critical: CriticalWave {
            stable: assessment.spectrum.is_stable(),
            omega_squared: mode.omega_squared.into(),
            growth_rate: growth,
            height: match assessment.spectrum.is_stable() {
                true => frequency(mode.omega_squared.into()),
                false => -growth,
            },
            wave_vector: list(dimension, &critical),
            spatial_wave_vector: list(dimension, &analysis.spatial(f, &critical)),
            point: symmetry
                .name(&critical)
                .filter(|_| critical.norm() > 0.0)
                .map(str::to_owned),
            length: place.or(at_zero).map(|corner| corner.length),
        },
        density_of_states: density_of_states(analysis, omega_squared),
        corners,
        heights: heights(&samples),
        samples,
        lengths,
        weak: WEAK_WAVE_RATIO,
    })
}

struct Sampled {
    corners: Vec<Corner>,
    samples: Vec<DispersionAnswer>,
    lengths: Vec<f64>,
}

/// Samples the legs of a path; returns them with the corners and their positions.
fn sampled(
    dimension: usize,
    path: &ZonePath,
    waves: impl Fn(&Vector3<f64>) -> DispersionAnswer,
) -> Sampled {
    let (mut corners, mut samples, mut lengths) = (Vec::new(), Vec::new(), Vec::new());
    let mut length = 0.0;
    for chain in &path.0 {
        for (n, stop) in chain.iter().enumerate() {
            let k = stop.wave_vector;
            corners.push(Corner {
                name: stop.name.clone(),
                wave_vector: list(dimension, &k),
                length,
            });
            let step = chain
                .get(n + 1)
                .map_or_else(Vector3::zeros, |next| next.wave_vector - k);
            // The end of a chain is an additional sample.
            let count = if n + 1 < chain.len() { SAMPLES } else { 1 };
            for sample in 0..count {
                let t = sample as f64 / count as f64;
                samples.push(waves(&(k + step * t)));
                lengths.push(length + t * step.norm());
            }
            length += step.norm();
        }
    }
    Sampled {
        corners,
        samples,
        lengths,
    }
}

fn density_of_states(
    analysis: &dyn Analysis,
    omega_squared: impl Fn(&Vector3<f64>) -> Vec<Complex> + Sync,
) -> DensityOfStates {
    let reciprocal = analysis.reciprocal();
    let n = GRID[reciprocal.len() - 1];
    // Half of the grid suffices, because `k` and `-k` have the same waves.
    let count = n.pow(reciprocal.len() as u32) / 2;
    let scope = Scope::current();
    let heights: Vec<f64> = (0..count)
        .into_par_iter()
        .flat_map_iter(|index| {
            let mut rest = index;
            let mut k = Vector3::zeros();
            for b in reciprocal.iter().rev() {
                k += b * (((rest % n) as f64 + 0.5) / n as f64);
                rest /= n;
            }
            let values = scope.run(|| omega_squared(&k)).into_iter();
            values
                .map(|value| frequency(value.into()))
                .collect::<Vec<_>>()
        })
        .collect();
    let (low, high) = heights
        .iter()
        .fold((0.0_f64, f64::MIN_POSITIVE), |(low, high), y| {
            (low.min(*y), high.max(*y))
        });
    let width = (high - low) / BINS as f64;
    let mut counts = vec![0_usize; BINS];
    for height in &heights {
        counts[(((height - low) / width) as usize).min(BINS - 1)] += 1;
    }
    let unit = heights.len() as f64 * width;
    DensityOfStates {
        edges: (0..=BINS).map(|n| low + width * n as f64).collect(),
        density: counts
            .into_iter()
            .map(|count| count as f64 / unit)
            .collect(),
        waves: heights.len(),
    }
}
