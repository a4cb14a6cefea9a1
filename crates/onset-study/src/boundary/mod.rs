//! Boundaries of a study: the curves where its material and its discretization lose stability, and how well they agree.

mod fidelity;
mod files;
mod probes;

pub use fidelity::{Apart, Fidelity, Rays, WorstRay, WorstStress};
pub use files::{csv, files, geojson};

use crate::answers::ProblemError;
use crate::number::{counted, told};
use crate::settings::{Axis, Study};
use fidelity::Ask;
use onset::cancel::Scope;
use onset::verdict::boundary::{
    Boundary, Curve, Fineness, Window, grid_points, trace_boundary_from,
};
use onset::verdict::{Phase, Probe};
use rayon::prelude::*;
use serde::Serialize;
use thiserror::Error;

/// Smallest and largest number of seed cells along an axis; in between, the number of states in the study.
const SEEDS_OF_MATERIAL: (usize, usize) = (96, 192);
const SEEDS_OF_PARTICLES: (usize, usize) = (32, 96);
/// Largest number of states evaluated for one curve. The material takes about a hundredth of the time of its discretization.
const MATERIAL_BUDGET: usize = 200_000;
const PARTICLES_BUDGET: usize = 10_000;

/// Reason why the boundaries of a study cannot be traced.
#[derive(Debug, Error)]
pub enum BoundaryError {
    /// Study without exactly two axes; boundaries are curves in a plane.
    #[error(
        "the study has {axes} axes; a boundary is traced in a plane of two\n  hint: hold one of {names} fixed under [state], [material] or [discretization] and remove its axis"
    )]
    NotAPlane {
        /// Number of axes in the study.
        axes: usize,
        /// Names of the axes.
        names: String,
    },
    /// Error of material or discretization.
    #[error(transparent)]
    Problem(#[from] ProblemError),
}

/// Owner of a boundary.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Owner {
    /// The material: boundary of strong ellipticity.
    Material,
    /// The discretization: boundary of the stability of the particles.
    Discretization,
}

impl Owner {
    /// Name of the owner in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Material => "material",
            Self::Discretization => "discretization",
        }
    }
}

/// Options for tracing boundaries.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tracing {
    /// Whether to distinguish flutter from divergence.
    pub flutter: bool,
    /// Whether to compute the fidelity of the discretization.
    pub fidelity: bool,
}

/// Observer of the progress, which may cancel the computation.
pub trait Watch: Sync {
    /// Reports an additional number of evaluated states.
    fn asked(&self, states: u64);
}

/// Observer that ignores the progress and never cancels.
impl Watch for () {
    fn asked(&self, _: u64) {}
}

/// Boundaries of a study.
#[derive(Clone, Debug)]
pub struct Boundaries {
    /// Study whose boundaries are traced.
    pub study: Study,
    /// Window of the two axes.
    pub window: Window,
    /// Boundary where strong ellipticity is lost or regained.
    pub material: Boundary,
    /// Boundary where the stability of the particles, or the definition of the method, is lost or regained.
    pub discretization: Boundary,
    /// Phases of a window without boundaries.
    pub throughout: Throughout,
    /// Fidelity of the discretization; `null` if it was not requested.
    pub fidelity: Option<Fidelity>,
    /// Notes on law and method.
    pub notes: Vec<String>,
}

impl Boundaries {
    /// Traces the boundaries of a study with two axes.
    ///
    /// # Errors
    /// [`BoundaryError`] if the study does not have two axes, or a state cannot be evaluated for any reason other than the support.
    pub fn of(study: &Study, tracing: Tracing, watch: &dyn Watch) -> Result<Self, BoundaryError> {
        let [first, second] = plane(study)?;
        let window = Window {
            low: [first.range.0, second.range.0],
            high: [first.range.1, second.range.1],
        };
        Ok(Self::traced(study, window, tracing, watch)?)
    }

    fn traced(
        study: &Study,
        window: Window,
        tracing: Tracing,
        watch: &dyn Watch,
    ) -> Result<Self, ProblemError> {
        let probes = probes::Probes::new(study)?;
        let cells = |(least, most): (usize, usize)| {
            [0, 1].map(|axis: usize| study.axes[axis].count.clamp(least, most))
        };
        let material = |at: [f64; 2]| {
            watch.asked(1);
            probes.material(at)
        };
        let seen = |probe: Probe| match tracing.flutter {
            true => probe,
            false => merged(probe),
        };
        let particles = |at: [f64; 2]| {
            watch.asked(1);
            Ok(seen(probes.discretization(at)?))
        };
        let scope = Scope::current();
        let traced =
            |cells, budget, probe: Ask<'_>| scope.run(|| trace(window, cells, budget, probe));
        let (of_material, of_particles) = rayon::join(
            || traced(cells(SEEDS_OF_MATERIAL), MATERIAL_BUDGET, &material),
            || traced(cells(SEEDS_OF_PARTICLES), PARTICLES_BUDGET, &particles),
        );
        let (of_material, of_particles) = (of_material?, of_particles?);
        let merged_particles = |at: [f64; 2]| Ok(merged(particles(at)?));
        let throughout = Throughout {
            material: filling(&of_material, || probes.material(window.low))?,
            discretization: filling(&of_particles, || {
                Ok(seen(probes.discretization(window.low)?))
            })?,
        };
        let boundaries = [&of_material, &of_particles];
        let measure = || {
            let traced = fidelity::Traced {
                study,
                window,
                boundaries,
            };
            let probes_of_both: [Ask<'_>; 2] = [&material, &merged_particles];
            Fidelity::of(&traced, probes_of_both, &|at| probes.cauchy(at))
        };
        let fidelity = tracing.fidelity.then(measure).transpose()?;
        Ok(Self {
            study: study.clone(),
            window,
            material: of_material,
            discretization: of_particles,
            throughout,
            fidelity,
            notes: probes.notes(),
        })
    }

    /// All curves with their owners.
    pub fn curves(&self) -> impl Iterator<Item = (Owner, &Curve)> {
        let material = self.material.curves.iter();
        let discretization = self.discretization.curves.iter();
        material
            .map(|curve| (Owner::Material, curve))
            .chain(discretization.map(|curve| (Owner::Discretization, curve)))
    }

    /// Summary of the boundaries, without vertices.
    pub fn summary(&self) -> Summary {
        Summary {
            title: self.study.title.clone(),
            axes: self.study.plane().map(|axis| axis.name().to_owned()),
            curves: self
                .curves()
                .map(|(of, curve)| CurveSummary::new(of, curve))
                .collect(),
            throughout: self.throughout,
            is_complete: self.material.is_complete() && self.discretization.is_complete(),
            unresolved: [&self.material, &self.discretization]
                .into_iter()
                .flat_map(|boundary| boundary.unresolved.clone())
                .collect(),
            fidelity: self.fidelity.clone(),
            notes: self.notes.clone(),
        }
    }
}

fn plane(study: &Study) -> Result<[Axis; 2], BoundaryError> {
    if study.axes.len() == 2 {
        return Ok(study.plane());
    }
    let names: Vec<&str> = study.axes.iter().map(Axis::name).collect();
    Err(BoundaryError::NotAPlane {
        axes: names.len(),
        names: names.join(", "),
    })
}

/// Phase of a window without a boundary.
fn filling(
    boundary: &Boundary,
    probe: impl Fn() -> Result<Probe, ProblemError>,
) -> Result<Option<Phase>, ProblemError> {
    let is_one_phase = boundary.curves.is_empty() && boundary.unresolved.is_empty();
    is_one_phase.then(|| Ok(probe()?.0)).transpose()
}

/// Probe that does not distinguish kinds of instability.
fn merged((phase, measure): Probe) -> Probe {
    match phase {
        // The measure of flutter does not vanish on the merged boundary.
        Phase::Flutter => (Phase::Unstable, f64::NAN),
        other => (other, measure),
    }
}

fn trace(
    window: Window,
    cells: [usize; 2],
    budget: usize,
    probe: Ask<'_>,
) -> Result<Boundary, ProblemError> {
    let fineness = Fineness {
        cells,
        budget,
        ..Fineness::default()
    };
    let scope = Scope::current();
    let grid: Vec<Probe> = grid_points(window, &fineness)
        .into_par_iter()
        .map(|at| scope.run(|| probe(at)))
        .collect::<Result<_, _>>()?;
    trace_boundary_from(window, &fineness, &grid, probe)
}

/// Traced boundaries of a study, with the fidelity of the discretization.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Title of the study.
    pub title: String,
    /// Names of the two axes.
    pub axes: [String; 2],
    /// Summaries of the curves.
    pub curves: Vec<CurveSummary>,
    /// Phases of a window without boundaries.
    pub throughout: Throughout,
    /// Whether every detected change of phase lies on a completely traced curve.
    pub is_complete: bool,
    /// Points where the phase changes, but no curve could be traced.
    pub unresolved: Vec<[f64; 2]>,
    /// Fidelity of the discretization; `null` if it was not requested.
    pub fidelity: Option<Fidelity>,
    /// Notes on law and method.
    pub notes: Vec<String>,
}

/// Phases of a window without boundaries; a phase is `null` if a change of phase was detected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Throughout {
    /// Phase of the material.
    pub material: Option<Phase>,
    /// Phase of the discretization.
    pub discretization: Option<Phase>,
}

/// Curve without its vertices.
#[derive(Clone, Debug, Serialize)]
pub struct CurveSummary {
    /// Owner of the boundary.
    pub of: Owner,
    /// Phase to the left of the curve's direction.
    pub left: Phase,
    /// Phase to the right of the curve's direction.
    pub right: Phase,
    /// Whether the curve is closed.
    pub closed: bool,
    /// Reasons why an open curve starts and ends: `edge` (edge of the window), `phase` (a third phase begins), `meets` (another curve or itself), `lost`
    /// (no continuation found), `budget` (too many states); `null` for a closed curve.
    pub ends: Option<[&'static str; 2]>,
    /// Arc length in the coordinates of the axes.
    pub length: f64,
    /// Number of vertices on the curve.
    pub vertices: usize,
    /// Points at which smooth branches meet.
    pub corners: Vec<[f64; 2]>,
    /// Largest half width of a bracket that contains a vertex.
    pub accuracy: f64,
}

impl CurveSummary {
    fn new(of: Owner, curve: &Curve) -> Self {
        Self {
            of,
            left: curve.left,
            right: curve.right,
            closed: curve.is_closed(),
            ends: curve.ends.map(|ends| ends.map(files::word)),
            length: curve.length(),
            vertices: curve.vertices.len(),
            corners: curve.corners().collect(),
            accuracy: curve.accuracy(),
        }
    }
}

/// Describes where and why a curve ends.
fn place(end: &str) -> &str {
    match end {
        "edge" => "the edge of the window",
        "budget" => "the point at which the search ended",
        "lost" => "the point at which tracing failed",
        "meets" => "another curve",
        "phase" => "a third phase",
        other => other,
    }
}

impl std::fmt::Display for Summary {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for curve in &self.curves {
            let closing = match curve.ends {
                None => "closed".to_owned(),
                Some([start, end]) => format!("open, from {} to {}", place(start), place(end)),
            };
            writeln!(
                formatter,
                "{:<14} {} | {}: {closing}; length {}, {} vertices accurate to {:.0e}, {}",
                curve.of.name(),
                curve.left.name(),
                curve.right.name(),
                told(curve.length),
                curve.vertices,
                curve.accuracy,
                counted(curve.corners.len(), "corner"),
            )?;
        }
        let throughout = [
            (Owner::Material, self.throughout.material),
            (Owner::Discretization, self.throughout.discretization),
        ];
        for (of, phase) in throughout {
            if let Some(phase) = phase {
                let (of, phase) = (of.name(), phase.name());
                writeln!(
                    formatter,
                    "{of:<14} no boundary found: {phase} throughout the window"
                )?;
            }
        }
        if !self.is_complete {
            let is_cut = |curve: &&CurveSummary| {
                let mut ends = curve.ends.into_iter().flatten();
                ends.any(|end| end == "budget" || end == "lost")
            };
            writeln!(
                formatter,
                "The boundary is incomplete: {} cut short, {} of changing phase unresolved. Areas are those within the curves that were followed. A ragged boundary is resolved in a smaller \
                 window.",
                counted(self.curves.iter().filter(is_cut).count(), "curve"),
                counted(self.unresolved.len(), "place")
            )?;
        }
        if let Some(fidelity) = &self.fidelity {
            write!(formatter, "{fidelity}")?;
        }
        for note in &self.notes {
            writeln!(formatter, "\nnote: {note}")?;
        }
        Ok(())
    }
}
