//! Recognized contents of a run: its files, its particles, and the parts of the study that are missing.

use super::input::is_spaced;
use super::neighborhoods::{Neighborhoods, within};
use super::{Recording, Run};
use crate::answers::Problem;
use crate::csv::Table;
use crate::number::{counted, told, told_with};
use crate::settings::{Family, KEYS, Settings, Units};
use serde::Serialize;
use std::fmt;

/// Smallest fraction of the vectors between nearest particles that are vectors of the lattice if the particles are on it; the others are at faces.
const ON_LATTICE: f64 = 0.9;
/// Largest distance of nearest particles, in spacings.
const NEIGHBOR_DISTANCE: f64 = 1.1;
/// Largest deviation of lattice coordinates of particles on the lattice.
const LATTICE_COORDINATE_TOLERANCE: f64 = 0.05;
/// Largest relative spread of the distances of nearest particles on a lattice.
const LATTICE_SPREAD: f64 = 5e-3;

/// Part of the study of a run that is not given, so that a default applies.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Missing {
    /// Name of the part in a sentence: law or method.
    pub part: &'static str,
    /// Key that gives the part.
    pub key: &'static str,
    /// Value that applies by default.
    pub default: String,
}

impl Missing {
    /// Note for the reader.
    pub(super) fn told(&self) -> String {
        format!(
            "the {} of the run is not given, and the default {} is assumed: set {}",
            self.part, self.default, self.key
        )
    }
}

/// Parts of the study that are not given: the law, the method, or both.
pub fn missing(settings: &Settings) -> Vec<Missing> {
    let is_set = |name: &str| settings.origin(name).is_some();
    let of_law = || KEYS.iter().filter(|key| key.parts().0 == "material");
    let has_law = settings.material.is_handed() || of_law().any(|key| is_set(key.name));
    let method = "discretization.method";
    let parts = [
        ("law", "material.model", has_law),
        ("method", method, is_set(method)),
    ];
    let default = |key: &str| {
        settings
            .value(key)
            .map_or_else(String::new, |own| own.to_string())
    };
    let missing = parts.into_iter().filter(|(_, _, is_given)| !is_given);
    missing
        .map(|(part, key, _)| Missing {
            part,
            key,
            default: default(key),
        })
        .collect()
}

/// Recognized contents of the files of a run, without an analysis.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScreenChecks {
    /// Files, frames, particles and columns.
    pub recording: Recording,
    /// Particle spacing of the settings; length.
    pub spacing: f64,
    /// Arrangement of the particles in the reference configuration.
    pub particles: String,
    /// Rounding of the positions in the file; spacings. Smaller short waves cannot be observed.
    pub rounding: f64,
    /// Parts of the study that are not given.
    pub missing: Vec<Missing>,
}

impl ScreenChecks {
    /// Describes the files of a run, and compares its particles with the study.
    pub fn new(problem: &Problem, recording: Recording, run: &Run) -> Self {
        let layout = layout(run, problem.dimension(), recording.spacing);
        Self {
            spacing: problem.analysis.spacing(),
            particles: match is_on_lattice(problem, run, recording.spacing) {
                true => layout,
                false => format!(
                    "{layout}; not on the lattice of the settings: set discretization.lattice"
                ),
            },
            rounding: run.rounding / recording.spacing,
            missing: missing(&problem.settings),
            recording,
        }
    }

    /// The recording as CSV, in one row.
    pub fn csv(&self) -> String {
        Table::new(std::slice::from_ref(self), Units::Own)
            .with("format", "1", |own| own.recording.format.as_str())
            .with("files", "1", |own| own.recording.files)
            .with("frames", "1", |own| own.recording.frames)
            .with("first_time", "time", |own| own.recording.times[0])
            .with("last_time", "time", |own| own.recording.times[1])
            .with("longest_interval", "time", |own| own.recording.interval)
            .with("particles", "1", |own| own.recording.particles)
            .with("elements", "1", |own| own.recording.elements)
            .with("held", "1", |own| own.recording.held)
            .with("spacing", "length", |own| own.spacing)
            .to_string()
    }
}

/// Description of the files and of the particles, by lines without the notes.
pub(super) fn recognized(own: &Recording, spacing: f64, particles: &str) -> String {
    let elements = match own.elements {
        0 => String::new(),
        cells => format!(", {}", counted(cells, "element")),
    };
    let held_by = match own.held_by.as_str() {
        "" => String::new(),
        by => format!(" ({by})"),
    };
    format!(
        "{}, {}: {} from t = {} to {}, {}{elements}\n\
         columns     {}\n\
         spacing     {} in the file, {} in the settings\n\
         particles   {particles}\n\
         held        {}{held_by}",
        own.format,
        counted(own.files, "file"),
        counted(own.frames, "frame"),
        told(own.times[0]),
        told(own.times[1]),
        counted(own.particles, "particle"),
        own.columns.join("; "),
        told(own.spacing),
        told(spacing),
        counted(own.held, "particle")
    )
}

impl fmt::Display for ScreenChecks {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let own = &self.recording;
        let facts = recognized(own, self.spacing, &self.particles);
        let digits = match own.digits {
            Some(digits) => format!(
                "{}: positions are rounded to {} spacings, and smaller short waves cannot be observed",
                counted(digits as usize, "digit"),
                told_with(self.rounding, 2)
            ),
            None => "numbers of 64 bits".to_owned(),
        };
        write!(formatter, "{facts}\ndigits      {digits}")?;
        for (n, missing) in self.missing.iter().enumerate() {
            let title = if n == 0 { "missing" } else { "" };
            write!(
                formatter,
                "\n{title:<12}{}: set {} (by default {})",
                missing.part, missing.key, missing.default
            )?;
        }
        let mut notes = own.notes.iter();
        notes.try_for_each(|note| write!(formatter, "\n\nnote: {note}"))
    }
}

/// Arrangement of the particles in the reference configuration, from the distances and the number of nearest particles.
pub(super) fn layout(run: &Run, dimension: usize, spacing: f64) -> String {
    if run.cells.is_some() {
        return "nodes of elements".to_owned();
    }
    let near = within(&run.reference, dimension, NEIGHBOR_DISTANCE * spacing);
    let distance = |a: &[f64; 3], b: &[f64; 3]| {
        let parts = (0..3).map(|i| (a[i] - b[i]).powi(2));
        parts.sum::<f64>().sqrt() / spacing
    };
    let mut distances = Vec::new();
    for (x, near) in run.reference.iter().zip(&near) {
        distances.extend(near.iter().map(|other| distance(x, &run.reference[*other])));
    }
    let count = distances.len().max(1) as f64;
    let spread = (distances.iter().map(|own| (own - 1.0).powi(2)).sum::<f64>() / count).sqrt();
    let mut counts: Vec<usize> = near.iter().map(Vec::len).collect();
    counts.sort_unstable();
    // Particles at faces have fewer neighbors than the others.
    let inside = counts.get(counts.len() * 3 / 4).copied().unwrap_or(0);
    let lattice = match (dimension, inside) {
        _ if spread > LATTICE_SPREAD => {
            return format!(
                "disordered: distances of nearest particles vary by {} spacings",
                told_with(spread, 2)
            );
        }
        (1, 2) => "chain",
        (2, 4) => "square",
        (2, 6) => "hexagonal",
        (2, 3) => "honeycomb",
        (3, 6) => "simple cubic",
        (3, 8) => "body-centered cubic",
        (3, 12) => "face-centered cubic or hexagonal close-packed",
        _ => return format!("regular, with {inside} nearest particles"),
    };
    format!("{lattice} lattice, with {inside} nearest particles")
}

/// Number of particles along the side of a grid cell of material points, whose files can have points or nodes; one for other methods.
pub(super) fn points_per_side(problem: &Problem) -> f64 {
    let method = &problem.settings.method;
    match method.method {
        Family::MaterialPoints => f64::from(method.points_per_side.max(1)),
        _ => 1.0,
    }
}

/// Returns true if the vectors between nearest particles of a regular run are vectors of the lattice of the settings, or if this is not known.
pub(super) fn is_on_lattice(problem: &Problem, run: &Run, spacing: f64) -> bool {
    let has_lattice = problem.analysis.sites() == 1 && run.cells.is_none();
    if !has_lattice
        || problem.settings.method.method == Family::MaterialPoints
        || !is_spaced(spacing, problem.analysis.spacing())
    {
        return true;
    }
    let reciprocal = problem.analysis.reciprocal();
    let near = Neighborhoods::new(
        &run.reference,
        problem.dimension(),
        NEIGHBOR_DISTANCE * spacing,
    );
    let mut counts = [0_usize; 2];
    for n in 0..near.len() {
        for other in near.numbers(n) {
            let apart: [f64; 3] =
                std::array::from_fn(|i| run.reference[other][i] - run.reference[n][i]);
            let is_vector = reciprocal.iter().all(|b| {
                let coordinate =
                    (0..3).map(|i| b[i] * apart[i]).sum::<f64>() / std::f64::consts::TAU;
                (coordinate - coordinate.round()).abs() < LATTICE_COORDINATE_TOLERANCE
            });
            counts[usize::from(is_vector)] += 1;
        }
    }
    counts[1] as f64 >= ON_LATTICE * (counts[0] + counts[1]) as f64
}
