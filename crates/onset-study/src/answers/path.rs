//! States of a path at which stability is lost and regained.

use super::course::{Course, LoadingOfPath};
use super::evidence::Evidence;
use super::mode::{critical_mode, finite_wave_vector};
use super::notes::{is_fluid, notes, zero_energy};
use super::problem::{Problem, ProblemError, Strain};
use super::state::{ComplexNumber, list, rows};
use crate::brief::{Brief, Short};
use crate::number::{told, told_of, vector};
use crate::settings::{Effective, Units};
use nalgebra::SVector;
use onset::analysis::scan_material_in;
use onset::continuum::{Ellipticity, Stiffness};
use onset::criteria::Mode;
use onset::kinematics::{DeformationGradient, DeformationPath};
use onset::method::MethodError;
use onset::verdict::{Crossing, Onset, PathScan, Phase, Verdict};
use serde::Serialize;

/// Answer of `onset path` for a path of deformations.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PathAnswer {
    /// Parts of the path in which material and discretization are defined.
    #[serde(skip)]
    defined: [Defined; 2],
    /// Number of space dimensions of the particles.
    #[serde(skip)]
    pub dimension: usize,
    /// Whether the smallest acoustic eigenvalue of the material is zero to rounding at an end.
    #[serde(skip)]
    pub is_marginal: bool,
    /// Whether the law is a fluid, which is never strongly elliptic.
    #[serde(skip)]
    pub is_fluid: bool,
    /// Whether tangents have major symmetry at both ends.
    #[serde(skip)]
    pub is_symmetric: bool,
    /// Notes on law and method.
    pub notes: Vec<String>,
    /// Evidence that stability is not lost between the sampled states: `searched`.
    pub evidence: Evidence,
    /// All settings in effect.
    pub settings: Effective,
    /// Label of the coordinate along the path, as in the figure: the imposed stretch, a stretch along an axis, or the path parameter.
    pub abscissa: &'static str,
    /// Loading along the path; `null` for a straight path between two states.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub loading: Option<LoadingOfPath>,
    /// `F_iJ` at the start.
    pub from: [[f64; 3]; 3],
    /// `F_iJ` at the end.
    pub to: [[f64; 3]; 3],
    /// First loss of strong ellipticity; `null` if it is kept.
    pub material_onset: Option<MaterialOnset>,
    /// First instability of the discretization; `null` if it stays stable.
    pub discretization_onset: Option<DiscretizationOnset>,
    /// Every loss and recovery of strong ellipticity.
    pub material_crossings: Vec<CrossingAnswer>,
    /// Every loss and recovery of the stability of the discretization.
    pub discretization_crossings: Vec<CrossingAnswer>,
}

/// Change between stable and unstable.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CrossingAnswer {
    /// Path parameter, 0 at the start, 1 at the end.
    pub parameter: f64,
    /// Stretches along the axes; principal stretches, largest first, if `F` is not diagonal.
    pub stretch: Vec<f64>,
    /// Imposed stretch, or amount of shear, of a loading; `null` for a path between two states.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub imposed: Option<f64>,
    /// Phase before the change.
    pub from: Phase,
    /// Phase after the change.
    pub to: Phase,
    /// Half of the length of the bracket of `parameter`.
    pub tolerance: f64,
}

/// First loss of strong ellipticity.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MaterialOnset {
    /// State of the loss; the start of the path if the material is not elliptic there.
    #[serde(flatten)]
    pub place: Place,
    /// Phase after the loss: `flutter` or `unstable`.
    pub phase: Phase,
    /// Reference direction of the critical wave.
    pub direction: Vec<f64>,
    /// Polarization of the critical wave; empty for flutter, whose polarization is complex.
    pub polarization: Vec<f64>,
}

/// First instability of the discretization.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DiscretizationOnset {
    /// State of the onset; the start of the path if the discretization is unstable there.
    #[serde(flatten)]
    pub place: Place,
    /// Phase after the onset: `flutter` or `unstable`.
    pub phase: Phase,
    /// Whether the critical wave is infinitely long.
    pub long_wave: bool,
    /// Reference wave vector of the critical mode, zero in the limit of long waves; 1/length.
    pub wave_vector: Vec<f64>,
    /// Wave vector of the critical mode in the deformed lattice; 1/length.
    pub spatial_wave_vector: Vec<f64>,
    /// Reference direction of the critical wave.
    pub direction: Vec<f64>,
    /// Polarization of the critical mode, real part.
    pub polarization: Vec<f64>,
    /// `omega^2` of the critical mode: zero, unless the instability is flutter or the start is unstable. 1/time^2.
    pub omega_squared: ComplexNumber,
}

/// State on a path.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Place {
    /// Path parameter, 0 at the start, 1 at the end.
    pub parameter: f64,
    /// Stretches along the axes; principal stretches, largest first, if `F` is not diagonal.
    pub stretch: Vec<f64>,
    /// Imposed stretch, or amount of shear, of a loading; `null` for a path between two states.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub imposed: Option<f64>,
    /// Deformation gradient `F_iJ`, by rows.
    pub deformation_gradient: [[f64; 3]; 3],
    /// Cauchy stress `sigma_ij`. Units of stress.
    pub cauchy: [[f64; 3]; 3],
    /// Half the width of the bracket of `parameter`; zero at the start.
    pub tolerance: f64,
    /// Modulus of the law, which sets the scale of rounding errors in stresses; stress.
    #[serde(skip)]
    pub stiffness: f64,
}

impl PathAnswer {
    /// Follows the straight path between two states.
    ///
    /// # Errors
    /// [`ProblemError`] when the ends coincide or a state on the path cannot be evaluated.
    pub fn new(problem: &Problem, from: &Strain, to: &Strain) -> Result<Self, ProblemError> {
        Self::along(problem, &Course::Straight(*from, *to))
    }

    /// Follows a straight path or a loading.
    ///
    /// # Errors
    /// Fails like [`PathAnswer::new`], or if a loading cannot be followed.
    pub fn along(problem: &Problem, course: &Course) -> Result<Self, ProblemError> {
        course.follow(problem, |path, loading| {
            let abscissa = course.abscissa(0.0).0;
            answer(problem, path, loading, abscissa)
        })
    }
}

fn answer(
    problem: &Problem,
    path: &dyn DeformationPath,
    loading: Option<LoadingOfPath>,
    abscissa: &'static str,
) -> Result<PathAnswer, ProblemError> {
    let imposed = |s: f64| loading.as_ref().map(|loading| loading.imposed(s));
    let (from, to) = (&path.at(0.0)?, &path.at(1.0)?);
    let analysis = &*problem.analysis;
    let dimension = analysis.dimension();
    let list = |vector: &SVector<f64, 3>| list(dimension, vector);
    // A state that the discretization cannot represent is an error, not an undefined path. A state without stress, as at a kink of the law, is valid.
    let mut notes = notes(&problem.settings, &*problem.material);
    match analysis.assess(from) {
        Err(error) if error.is_outside_domain() => {}
        other => {
            if other?.verdict == Verdict::ZeroEnergy {
                notes.push(zero_energy(
                    "at the start the particles have",
                    "along a path",
                ));
            }
        }
    }
    let is_marginal = |f: &DeformationGradient| {
        let minimum = analysis.acoustic_minimum(f);
        minimum.is_ok_and(|minimum| minimum.ellipticity() == Ellipticity::Undecided)
    };
    let is_symmetric = |f: &DeformationGradient| {
        let response = problem.material.response(f);
        response.map_or(true, |response| {
            Stiffness::<3>::of(&response).has_major_symmetry()
        })
    };
    let continuum = scan_material_in(dimension, &*problem.material, path)?;
    let particles = analysis.scan(path)?;

    // At a fold a free face loses its stiffness, possibly together with a wave. The sign then changes only on the branch beyond the fold.
    let of_fold = || {
        let ends_in_fold = loading.as_ref().is_some_and(LoadingOfPath::ends_in_fold);
        (ends_in_fold && is_marginal(to)).then_some((1.0, 1.0, 0.0, Phase::Unstable))
    };
    let material_onset = match onset(&continuum).or_else(of_fold) {
        Some((parameter, witness, tolerance, phase)) => {
            let critical = analysis.acoustic_minimum(&path.at(witness)?);
            let critical = critical.map_err(MethodError::from)?;
            let polarization = match critical.only_flutters() {
                true => Vec::new(),
                false => list(&critical.polarization),
            };
            Some(MaterialOnset {
                place: Place::at(problem, path, parameter, tolerance, imposed(parameter))?,
                phase,
                direction: list(&critical.critical_direction()),
                polarization,
            })
        }
        None => None,
    };
    let discretization_onset = match onset(&particles) {
        Some((parameter, witness, tolerance, phase)) => {
            let f = path.at(witness)?;
            let assessment = analysis.assess(&f)?;
            let spectrum = &assessment.spectrum;
            // Just after the onset no wave grows measurably, so the softest mode is the critical one.
            let mode = if spectrum.flutters || witness == 0.0 {
                critical_mode(&assessment)
            } else {
                &spectrum.softest
            };
            let wave_vector = finite_wave_vector(mode);
            Some(DiscretizationOnset {
                place: Place::at(problem, path, parameter, tolerance, imposed(parameter))?,
                phase,
                long_wave: mode.is_long_wave,
                wave_vector: list(&wave_vector),
                spatial_wave_vector: list(&analysis.spatial(&f, &wave_vector)),
                direction: list(
                    &mode
                        .wave_vector
                        .try_normalize(0.0)
                        .unwrap_or(mode.wave_vector),
                ),
                polarization: list(&mode.polarization.map(|component| component.re)),
                omega_squared: mode.omega_squared.into(),
            })
        }
        None => None,
    };
    Ok(PathAnswer {
        dimension,
        defined: [&continuum, &particles].map(Defined::of),
        is_marginal: is_marginal(from) || is_marginal(to),
        is_fluid: is_fluid(&*problem.material) && is_marginal(from) && is_marginal(to),
        is_symmetric: is_symmetric(from) && is_symmetric(to),
        notes,
        evidence: Evidence::Searched,
        settings: problem.settings.effective(),
        abscissa,
        from: *problem.found(from).components(),
        to: *problem.found(to).components(),
        material_onset,
        discretization_onset,
        material_crossings: crossings(dimension, path, &continuum, imposed)?,
        discretization_crossings: crossings(dimension, path, &particles, imposed)?,
        loading,
    })
}

/// Part of a path in which a quantity is defined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Defined {
    Everywhere,
    Somewhere,
    Nowhere,
}

impl Defined {
    fn of(scan: &PathScan) -> Self {
        let behind = scan.crossings.iter().map(|crossing| crossing.to);
        let phases: Vec<Phase> = std::iter::once(scan.start).chain(behind).collect();
        let undefined = phases.iter().filter(|phase| **phase == Phase::Undefined);
        match undefined.count() {
            0 => Self::Everywhere,
            count if count == phases.len() => Self::Nowhere,
            _ => Self::Somewhere,
        }
    }

    /// Restriction that is added to statements about the whole path.
    fn limits(self) -> &'static str {
        match self {
            Self::Somewhere => ", where it is defined",
            Self::Everywhere | Self::Nowhere => "",
        }
    }
}

/// Parameter, witness and tolerance of the first instability, and the phase after it.
fn onset(scan: &PathScan) -> Option<(f64, f64, f64, Phase)> {
    scan.onset().map(|onset| {
        let phase = scan.phase_behind(&onset);
        match onset {
            Onset::AtStart => (0.0, 0.0, 0.0, phase),
            Onset::At(crossing) => (
                crossing.parameter(),
                crossing.witness(),
                tolerance(&crossing),
                phase,
            ),
        }
    })
}

fn tolerance(crossing: &Crossing) -> f64 {
    0.5 * (crossing.behind - crossing.before)
}

fn stretch(dimension: usize, f: &DeformationGradient) -> Vec<f64> {
    let components = f.components();
    let diagonal = (0..3).all(|i| (0..3).all(|j| i == j || components[i][j] == 0.0));
    if diagonal {
        return (0..dimension).map(|i| components[i][i]).collect();
    }
    // Stretches in the dimensions of the lattice: the principal stretches of the leading block, which are the largest once all other components are
    // zero.
    let is_leading = |i: usize, j: usize| i < dimension && j < dimension;
    let leading = DeformationGradient::from_components(std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            if is_leading(i, j) {
                components[i][j]
            } else {
                0.0
            }
        })
    }));
    leading.principal_stretches()[..dimension].to_vec()
}

impl Place {
    fn at(
        problem: &Problem,
        path: &dyn DeformationPath,
        parameter: f64,
        tolerance: f64,
        imposed: Option<f64>,
    ) -> Result<Self, ProblemError> {
        let f = path.at(parameter)?;
        let response = problem.material.response(&f).map_err(MethodError::from)?;
        Ok(Self {
            parameter,
            stretch: stretch(problem.dimension(), &f),
            imposed,
            deformation_gradient: *response.deformation.components(),
            cauchy: rows(&response.cauchy()),
            tolerance,
            stiffness: problem.analysis.speed_squared()? * problem.settings.discretization.density,
        })
    }
}

fn crossings(
    dimension: usize,
    path: &dyn DeformationPath,
    scan: &PathScan,
    imposed: impl Fn(f64) -> Option<f64>,
) -> Result<Vec<CrossingAnswer>, ProblemError> {
    let answer = |crossing: &Crossing| {
        Ok(CrossingAnswer {
            parameter: crossing.parameter(),
            stretch: stretch(dimension, &path.at(crossing.parameter())?),
            imposed: imposed(crossing.parameter()),
            from: crossing.from,
            to: crossing.to,
            tolerance: tolerance(crossing),
        })
    };
    scan.crossings.iter().map(answer).collect()
}

impl PathAnswer {
    /// Sentences on the onsets of material and discretization.
    fn sentences(&self) -> [String; 2] {
        let units = self.settings.units();
        let [law, discretization] = self.defined;
        // Nothing is known of the part of a path that was not followed.
        let early = self.loading.as_ref();
        let sheared = self.is_sheared();
        let at = |place: &Place| at(place, sheared, units);
        let way = match early.filter(|loading| loading.ends_early.is_some()) {
            Some(loading) => format!(
                "up to {} {}, where the path ends",
                loading.imposes,
                told(loading.to)
            ),
            None => "along the whole path".to_owned(),
        };
        let material = match &self.material_onset {
            None if law == Defined::Nowhere => {
                "The law is not defined at any state of the path.".to_owned()
            }
            Some(onset) if onset.phase == Phase::Flutter => format!(
                "The material begins to flutter at {}: acoustic eigenvalues are complex for waves along N = {}.",
                at(&onset.place),
                vector(&onset.direction)
            ),
            Some(onset) => format!(
                "The material loses ellipticity at {} for waves along N = {}.",
                at(&onset.place),
                vector(&onset.direction)
            ),
            None if self.is_fluid => {
                "The material is a fluid, which is not strongly elliptic in any state: there is no loss of ellipticity along the path."
                    .to_owned()
            }
            None if self.is_marginal => format!(
                "Ellipticity is not lost {way}, but at an end of the path the smallest acoustic eigenvalue of the material is zero to rounding."
            ),
            None => format!(
                "{} {way}{}{}.",
                match self.is_symmetric {
                    true => "The material stays strongly elliptic",
                    false => "No plane wave of the material grows",
                },
                match self.dimension {
                    1 => ", for waves along the chain of particles",
                    2 => ", for in-plane perturbations",
                    _ => "",
                },
                law.limits()
            ),
        };
        let method = match &self.discretization_onset {
            Some(onset) if onset.long_wave => format!(
                "The discretization becomes unstable at {} for long waves along {}.",
                at(&onset.place),
                vector(&onset.direction)
            ),
            Some(onset) => format!(
                "The discretization {} at {} with the wave vector {} (reference).",
                if onset.phase == Phase::Flutter {
                    "begins to flutter"
                } else {
                    "becomes unstable"
                },
                at(&onset.place),
                units.of(vector(&onset.wave_vector), "1/m")
            ),
            None if discretization == Defined::Nowhere => {
                "The discretization cannot be evaluated at any state of the path.".to_owned()
            }
            None => format!(
                "The discretization is stable {way}{}.",
                discretization.limits()
            ),
        };
        [material, method]
    }

    fn is_sheared(&self) -> bool {
        let loading = self.loading.as_ref();
        loading.is_some_and(|loading| loading.mode == Mode::SimpleShear)
    }

    /// Changes of stability along the path, one line for each.
    fn crossings(&self) -> Vec<String> {
        let sheared = self.is_sheared();
        let line = |name: &str, crossing: &CrossingAnswer| {
            format!(
                "  {name:<14} {:<9} -> {:<9} at {} (s = {})",
                phase(crossing.from),
                phase(crossing.to),
                match crossing.imposed.filter(|_| sheared) {
                    Some(gamma) => format!("gamma = {}", told(gamma)),
                    None => vector(&crossing.stretch),
                },
                told(crossing.parameter)
            )
        };
        let of = |name: &'static str, crossings: &[CrossingAnswer]| -> Vec<String> {
            crossings.iter().map(|own| line(name, own)).collect()
        };
        let mut lines = of("material", &self.material_crossings);
        lines.extend(of("discretization", &self.discretization_crossings));
        lines
    }
}

impl Brief for PathAnswer {
    fn brief(&self) -> Short {
        let loading = self.loading.iter().map(|loading| format!("{loading} "));
        let (law, law_defaults) = crate::caption::law(&self.settings);
        let (method, method_defaults) = self.settings.discretization();
        Short::new(loading.collect::<String>() + &self.sentences().join(" "))
            .table(self.crossings())
            .row(0, "evidence", self.evidence.words())
            .row(1, "material", law)
            .row(1, "method", method)
            .notes(&self.notes)
            .settings("material", law_defaults)
            .settings("method", method_defaults)
    }
}

impl std::fmt::Display for PathAnswer {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if let Some(loading) = &self.loading {
            writeln!(formatter, "{loading}\n")?;
        }
        for line in self.sentences().iter().chain(&self.crossings()) {
            writeln!(formatter, "{line}")?;
        }
        for note in &self.notes {
            writeln!(formatter, "\nnote: {note}")?;
        }
        write!(
            formatter,
            "\n{}\n{}",
            self.evidence,
            self.settings.in_continuous_time()
        )
    }
}

fn phase(phase: Phase) -> &'static str {
    match phase {
        Phase::Stable => "stable",
        Phase::Flutter => "flutter",
        Phase::Unstable => "unstable",
        Phase::Undefined => "undefined",
    }
}

/// Description of a state; for simple shear with the amount of shear.
fn at(place: &Place, sheared: bool, units: Units) -> String {
    let start = if place.parameter == 0.0 {
        ", the start,"
    } else {
        ""
    };
    let stress = |(i, j): (usize, usize)| {
        let value = units.of(told_of(place.cauchy[i][j], place.stiffness), "Pa");
        format!("s{}{} = {value}", i + 1, j + 1)
    };
    match place.imposed.filter(|_| sheared) {
        Some(gamma) => format!("gamma = {}{start} ({})", told(gamma), stress((0, 1))),
        None => {
            // Stresses in the plane; in 3D all normal stresses.
            let axes = 0..place.stretch.len().max(2);
            let stresses: Vec<String> = axes.map(|i| stress((i, i))).collect();
            format!(
                "stretch {}{start} ({})",
                vector(&place.stretch),
                stresses.join(", ")
            )
        }
    }
}
