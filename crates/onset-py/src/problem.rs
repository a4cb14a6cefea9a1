//! Material with a method: states, waves and paths.

use crate::answer::Answer;
use crate::arrays::{bytes, deformations, numbers};
use crate::failure::Failure;
use crate::function::{Assigned, Setting};
use crate::interrupt::{self, Interrupt};
use onset::analysis::PlaneWaves;
use onset::cancel::Scope;
use onset::kinematics::DeformationGradient;
use onset::verdict::Mechanism;
use onset_study::Verdict;
use onset_study::answers::{
    self, Course, Diagram, PathAnswer, PathSamples, ProblemError, StateAnswer, StateQuestion,
    Strain, Waves,
};
use onset_study::criteria::{Lateral, Mode};
use onset_study::figure::Sheet;
use onset_study::limit::{KeepsAnswer, LimitAnswer, LimitQuestion, USUAL_STRETCHES};
use onset_study::map::{Evaluator, Record};
use onset_study::output::{picture, text as file};
use onset_study::settings::{MapSettings, MaterialSettings, Settings, Trust};
use onset_study::simulate::{self, Duration, Pace, Place, Question, Seeded, Stepper};
use pyo3::buffer::PyBuffer;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;

/// Number of states in a batch, as in a map.
const BATCH_STATES: usize = 512;
/// Smallest number of states that justifies a more expensive preparation.
const MANY_STATES: usize = 64;
/// Largest number of values in an array answer.
const MAX_VALUES: usize = 1 << 28;
/// Largest phase that double precision resolves.
const MAX_PHASE: f64 = 1e6;

/// Positions, masses, spacing, and components of the deformation of the lattice.
type Cell = (Vec<Vec<f64>>, Vec<f64>, f64, Vec<f64>);

/// Name and text of a study.
pub type Source = (String, String);

/// Settings of a study, or defaults, with assignments applied; `open` lists keys that will be varied.
///
/// # Errors
/// [`Failure`] for an invalid setting, or a library that the file may not load.
pub fn settings(
    file: Option<&Source>,
    assigned: &Assigned,
    libraries: &[PathBuf],
    open: &[&str],
) -> Result<Settings, Failure> {
    let (name, text) = file.map_or(("", ""), |(name, text)| (name, text));
    let mut settings = Settings::of_file(name, text, &assigned.texts, open)?;
    if let Some(law) = assigned.law() {
        settings.material.take(law);
    }
    trusted(&mut settings.material, libraries)?;
    Ok(settings)
}

/// Allows a file to load the libraries that the caller names, and no others.
///
/// # Errors
/// [`Failure`] for a library that the file names and the caller does not.
pub fn trusted(material: &mut MaterialSettings, libraries: &[PathBuf]) -> Result<(), Failure> {
    material.allow(&Trust::of_user(libraries));
    Ok(material.permitted()?)
}

/// Material law with a discretization.
#[pyclass(frozen, module = "onset._onset")]
pub struct Problem(pub(crate) Arc<answers::Problem>);

/// States from nine components each; the thickness stretch in plane stress must not be given.
fn states(
    problem: &answers::Problem,
    components: &[f64],
) -> Result<Vec<DeformationGradient>, Failure> {
    let given = deformations(components, 0)?.into_iter();
    Ok(given.map(|f| problem.given(f)).collect::<Result<_, _>>()?)
}

/// State from stretches, or components of `F`, as numbers separated by commas.
fn strain(
    problem: &answers::Problem,
    stretch: Option<&str>,
    components: Option<&str>,
) -> Result<Strain, Failure> {
    let extent = problem.extent();
    Ok(match (stretch, components) {
        (Some(text), None) => Strain::of_stretches("stretch", text, extent)?,
        (None, Some(text)) => Strain::of_components("F", text, extent)?,
        _ => {
            return Err(Failure::input(
                "a state has `stretch` or `F`; give one of them",
            ));
        }
    })
}

#[pymethods]
impl Problem {
    #[new]
    fn new(
        py: Python<'_>,
        given: Vec<Setting>,
        file: Option<Source>,
        libraries: Vec<PathBuf>,
    ) -> PyResult<Self> {
        let assigned = Assigned::from(given);
        let problem = interrupt::answer(py, move || {
            let settings = settings(file.as_ref(), &assigned, &libraries, &[])?;
            Ok(answers::Problem::new(settings)?)
        })?;
        Ok(Self(Arc::new(problem)))
    }

    /// Number of space dimensions.
    #[getter]
    fn dimension(&self) -> usize {
        self.0.dimension()
    }

    /// Reciprocal vectors of the reference lattice, one for each dimension; 1/length.
    #[getter]
    fn reciprocal(&self) -> Vec<Vec<f64>> {
        let dimension = self.0.dimension();
        let vectors = self.0.analysis.reciprocal();
        vectors
            .iter()
            .map(|vector| vector.iter().take(dimension).copied().collect())
            .collect()
    }

    /// Returns a cell of particles at a state.
    ///
    /// The parts are the reference positions (length), the masses, the spacing (length), and the nine components of the map from the reference
    /// lattice to the particles. This map is `F`, or the identity if particles at their reference positions represent the deformed material.
    fn cell(
        &self,
        py: Python<'_>,
        stretch: Option<String>,
        components: Option<String>,
    ) -> PyResult<Cell> {
        let problem = Arc::clone(&self.0);
        interrupt::answer(py, move || {
            let f = strain(&problem, stretch.as_deref(), components.as_deref())?.0;
            let (analysis, dimension) = (&problem.analysis, problem.dimension());
            let place = |particle: onset::analysis::PatchParticle| {
                particle.position.iter().take(dimension).copied().collect()
            };
            let masses = analysis.masses(&f).map_err(ProblemError::from)?;
            let identity = DeformationGradient::identity();
            let moved = if analysis.is_regular() { identity } else { f };
            Ok((
                analysis.patch(1).into_iter().map(place).collect(),
                masses,
                analysis.spacing(),
                moved.components().iter().flatten().copied().collect(),
            ))
        })
    }

    fn state(
        &self,
        py: Python<'_>,
        stretch: Option<String>,
        components: Option<String>,
        certify: Option<f64>,
        weak: f64,
    ) -> PyResult<Answer> {
        let problem = Arc::clone(&self.0);
        interrupt::answer(py, move || {
            let strain = strain(&problem, stretch.as_deref(), components.as_deref())?;
            let question = StateQuestion {
                certified: certify,
                weak,
            };
            let answer = StateAnswer::asked(&problem, &strain, &question)?;
            Answer::of(&answer, &answer, answer.csv())
        })
    }

    /// Finds the values of a setting that keep a window of states stable.
    fn keeps(
        &self,
        py: Python<'_>,
        key: String,
        stretches: Option<(f64, f64)>,
        range: Option<(f64, f64)>,
    ) -> PyResult<Answer> {
        let problem = Arc::clone(&self.0);
        interrupt::answer(py, move || {
            let question = LimitQuestion::new(&key)?.between(range);
            let (low, high) = stretches.unwrap_or(USUAL_STRETCHES);
            let kept = KeepsAnswer::new(&problem.settings, &question, [low, high], &|_| ())?;
            let answer = Answer::of(&kept, &kept, kept.csv())?;
            Ok(answer.with_files(move || Ok(kept.files())))
        })
    }

    /// Finds the values of a setting that admit a time step.
    fn limit(
        &self,
        py: Python<'_>,
        key: String,
        time_step: String,
        state: (Option<String>, Option<String>),
        range: Option<(f64, f64)>,
        safety: f64,
        integrator: Option<String>,
    ) -> PyResult<Answer> {
        let problem = Arc::clone(&self.0);
        interrupt::answer(py, move || {
            let strain = match (state.0.as_deref(), state.1.as_deref()) {
                (None, None) => Strain::reference(),
                (stretch, components) => strain(&problem, stretch, components)?,
            };
            let mut settings = problem.settings.clone();
            if let Some(name) = &integrator {
                settings = settings.with_integrator(name)?;
            }
            let question = LimitQuestion::new(&key)?.between(range).with_safety(safety);
            let limit = LimitAnswer::new(&settings, &strain, &question, &time_step, &|_| ())?;
            let answer = Answer::of(&limit, &limit, limit.csv())?;
            Ok(answer.with_files(move || Ok(limit.files())))
        })
    }

    fn waves(
        &self,
        py: Python<'_>,
        stretch: Option<String>,
        components: Option<String>,
        wave_vector: String,
    ) -> PyResult<Answer> {
        let problem = Arc::clone(&self.0);
        interrupt::answer(py, move || {
            let strain = strain(&problem, stretch.as_deref(), components.as_deref())?;
            let waves = Waves::new(&problem, &strain, &wave_vector)?;
            Answer::of(&waves, &waves, waves.csv())
        })
    }

    fn bands(
        &self,
        py: Python<'_>,
        stretch: Option<String>,
        components: Option<String>,
        path: Option<String>,
    ) -> PyResult<Answer> {
        let problem = Arc::clone(&self.0);
        interrupt::answer(py, move || {
            let strain = strain(&problem, stretch.as_deref(), components.as_deref())?;
            let diagram = Diagram::new(&problem, &strain, path.as_deref())?;
            let answer = Answer::of(&diagram, diagram.told(), diagram.csv())?;
            Ok(answer.with_files(move || Ok(diagram.files())))
        })
    }

    /// Finds the loss of stability along a straight path between two states in the notation of the command line.
    fn straight_path(&self, py: Python<'_>, from: String, to: String) -> PyResult<Answer> {
        let problem = Arc::clone(&self.0);
        interrupt::answer(py, move || {
            let extent = problem.extent();
            let from = Strain::of_either("from_", &from, extent)?;
            let to = Strain::of_either("to", &to, extent)?;
            along(problem, Course::Straight(from, to))
        })
    }

    /// Finds the loss of stability along a loading between two imposed stretches.
    fn loading_path(
        &self,
        py: Python<'_>,
        mode: &str,
        lateral: Option<&str>,
        from: f64,
        to: f64,
    ) -> PyResult<Answer> {
        let mode = mode_named(mode)?;
        let lateral = lateral.map(lateral_named).transpose()?;
        let expected = match mode {
            Mode::SimpleShear => "one finite number, the amount of shear",
            _ => "one imposed stretch, a positive number",
        };
        for (name, imposed) in [("from_", from), ("to", to)] {
            if !(imposed.is_finite() && mode.parameter(imposed).is_finite()) {
                return Err(Failure::Input(format!(
                    "{name} is {imposed}; with mode expected {expected}"
                ))
                .into());
            }
        }
        let course = Course::of_mode(mode, lateral, from, to).map_err(|known| {
            Failure::Input(format!(
                "lateral=\"{}\" is not supported with {} loading\n  hint: supported: {known}",
                lateral.map_or("", Lateral::name),
                mode.name()
            ))
        })?;
        let problem = Arc::clone(&self.0);
        interrupt::answer(py, move || along(problem, course))
    }

    /// Verdicts on states of nine components each, computed as in a map or from `waves` wave vectors along each reciprocal vector: one column of bytes
    /// for each quantity. The time steps of damped waves are NaN.
    fn verdicts<'py>(
        &self,
        py: Python<'py>,
        components: PyBuffer<f64>,
        waves: Option<usize>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let components = numbers(py, &components)?;
        let problem = Arc::clone(&self.0);
        let records = interrupt::answer(py, move || {
            records(&problem, &components, |evaluator| {
                let evaluator = evaluator.for_verdicts();
                match waves {
                    Some(count) => evaluator.sampled(count),
                    None => evaluator,
                }
            })
        })?;
        let columns = PyDict::new(py);
        let number = |take: fn(&Record) -> f64| -> Vec<f64> { records.iter().map(take).collect() };
        let verdicts = number(|own| code(&Verdict::ALL, own.finding.verdict));
        let mechanisms = number(|own| code(&Mechanism::ALL, own.mechanism));
        columns.set_item("verdict", bytes(py, &verdicts)?)?;
        columns.set_item("mechanism", bytes(py, &mechanisms)?)?;
        for (name, take) in NUMBERS {
            columns.set_item(name, bytes(py, &number(*take))?)?;
        }
        let dimension = self.0.dimension();
        for (name, take) in VECTORS {
            let vectors: Vec<f64> = records
                .iter()
                .flat_map(|record| take(record).into_iter().take(dimension))
                .collect();
            columns.set_item(name, bytes(py, &vectors)?)?;
        }
        Ok(columns)
    }

    /// Critical time steps of states of nine components each, as in a map.
    fn critical_time_steps<'py>(
        &self,
        py: Python<'py>,
        components: PyBuffer<f64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let components = numbers(py, &components)?;
        let problem = Arc::clone(&self.0);
        let records = interrupt::answer(py, move || records(&problem, &components, |own| own))?;
        let steps: Vec<f64> = records.iter().map(|own| own.critical_time_step).collect();
        Ok(bytes(py, &steps)?.into_any())
    }

    /// Returns true if waves are damped, so that the critical time steps need a separate search.
    #[getter]
    fn is_damped(&self) -> bool {
        self.0.analysis.is_damped()
    }

    /// Squared frequencies of the particles, real and imaginary parts, for each state, each reference wave vector and each branch; 1/time^2.
    fn omega_squared<'py>(
        &self,
        py: Python<'py>,
        components: PyBuffer<f64>,
        wave_vectors: PyBuffer<f64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.spectra(
            py,
            &components,
            &wave_vectors,
            self.branches() * 2,
            |waves, k, out| {
                for (place, omega_squared) in out.chunks_exact_mut(2).zip(waves.omega_squared(k)) {
                    place.copy_from_slice(&[omega_squared.re, omega_squared.im]);
                }
            },
        )
    }

    /// Squared frequencies of the continuum, for each state, each reference wave vector and each branch; 1/time^2.
    fn continuum_omega_squared<'py>(
        &self,
        py: Python<'py>,
        components: PyBuffer<f64>,
        wave_vectors: PyBuffer<f64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        self.spectra(
            py,
            &components,
            &wave_vectors,
            self.0.dimension(),
            |waves, k, out| {
                out.copy_from_slice(&waves.continuum_omega_squared(k));
            },
        )
    }

    /// Dynamical matrices, real and imaginary parts, row by row, for each state and each reference wave vector; 1/time^2.
    fn dynamical_matrices<'py>(
        &self,
        py: Python<'py>,
        components: PyBuffer<f64>,
        wave_vectors: PyBuffer<f64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let branches = self.branches();
        self.spectra(
            py,
            &components,
            &wave_vectors,
            2 * branches * branches,
            move |waves, k, out| {
                let matrix = waves.dynamical_matrix_at(k);
                for (n, place) in out.chunks_exact_mut(2).enumerate() {
                    let entry = matrix[(n / branches, n % branches)];
                    place.copy_from_slice(&[entry.re, entry.im]);
                }
            },
        )
    }

    /// Number of waves with one wave vector.
    #[getter]
    fn branches(&self) -> usize {
        self.0.analysis.sites() * self.0.dimension()
    }

    /// Simulates the particles of a patch, step by step.
    #[pyo3(signature = (stretch, components, cells, mode, wave_vector, turns, branch, amplitude, seed, steps, time, fraction, time_step,
        supercritical, integrator, tolerance, out, every, fields, checkpoint, resume, overwrite))]
    fn simulate(
        &self,
        py: Python<'_>,
        stretch: Option<String>,
        components: Option<String>,
        cells: Vec<usize>,
        mode: &str,
        wave_vector: Option<Vec<f64>>,
        turns: Option<Vec<i64>>,
        branch: usize,
        amplitude: f64,
        seed: u64,
        steps: Option<u64>,
        time: Option<f64>,
        fraction: Option<f64>,
        time_step: Option<f64>,
        supercritical: bool,
        integrator: Option<&str>,
        tolerance: f64,
        out: Option<PathBuf>,
        every: Option<u64>,
        fields: u64,
        checkpoint: Option<u64>,
        resume: bool,
        overwrite: bool,
    ) -> PyResult<Answer> {
        let seeded = match (wave_vector, turns, mode) {
            (None, None, "noise") => Seeded::Noise,
            (Some(_), _, "noise") | (_, Some(_), "noise") => {
                return Err(Failure::input(
                    "mode \"noise\" has no wave: leave `wave_vector` and `turns` out",
                )
                .into());
            }
            (None, None, "critical") => Seeded::Critical,
            (Some(wave_vector), None, "critical") => Seeded::Wave(wave_vector),
            (None, Some(turns), "critical") => Seeded::Turns(turns),
            (_, _, other) if other != "critical" => {
                return Err(unknown("mode", other, ["critical", "noise"]).into());
            }
            _ => {
                return Err(Failure::input("a wave has `wave_vector` or `turns`, not both").into());
            }
        };
        let duration = match (steps, time) {
            (Some(steps), None) => Duration::Steps(steps),
            (None, Some(time)) => Duration::Time(time),
            (None, None) => Duration::Natural,
            _ => return Err(Failure::input("a run has `steps` or `time`, not both").into()),
        };
        let named = |name| {
            let unknown = || unknown("integrator", name, Stepper::names());
            Stepper::named(name).ok_or_else(unknown)
        };
        let stepper = integrator.map(named).transpose()?;
        let place = out.map(|folder| Place {
            folder,
            is_resumed: resume,
            is_overwritten: overwrite,
            checkpoint,
            sheet: Sheet::default(),
        });
        let problem = Arc::clone(&self.0);
        interrupt::watched(py, move |interrupt| {
            let strain = strain(&problem, stretch.as_deref(), components.as_deref())?;
            let question = Question {
                f: strain.0,
                cells,
                seeded,
                branch,
                amplitude,
                seed,
                pace: Pace {
                    duration,
                    fraction,
                    time_step,
                    is_supercritical: supercritical,
                    every,
                    fields,
                },
                stepper,
                tolerance,
            };
            let watch = Watch {
                interrupt,
                is_kept: place.is_some(),
            };
            let run = simulate::simulate(&problem, &question, place.as_ref(), &watch)?;
            let answer = Answer::of(&run, &run, run.csv())?;
            Ok(answer.with_files(move || {
                Ok(vec![
                    file("amplitude.csv", run.amplitude_csv()),
                    picture("simulate", run.figure()),
                ])
            }))
        })
    }
}

/// Monitors a run, which is saved at an interrupt if it has an output folder.
struct Watch {
    interrupt: Interrupt,
    is_kept: bool,
}

impl simulate::Watch for Watch {
    fn advance(&self, _done: u64, _all: u64) {
        if self.is_kept {
            self.interrupt.save_first();
        }
    }

    fn is_interrupted(&self) -> bool {
        self.interrupt.is_asked()
    }
}

impl Problem {
    /// Spectral values on all cores, `width` for each wave vector of each state, as bytes.
    fn spectra<'py>(
        &self,
        py: Python<'py>,
        components: &PyBuffer<f64>,
        wave_vectors: &PyBuffer<f64>,
        width: usize,
        take: impl Fn(&dyn PlaneWaves, &[f64], &mut [f64]) + Send + Sync + 'static,
    ) -> PyResult<Bound<'py, PyAny>> {
        let components = numbers(py, components)?;
        let wave_vectors = numbers(py, wave_vectors)?;
        let problem = Arc::clone(&self.0);
        let spectra = interrupt::answer(py, move || {
            let states = states(&problem, &components)?;
            let dimension = problem.dimension();
            check(&wave_vectors, problem.settings.discretization.spacing)?;
            let vectors = wave_vectors.len() / dimension;
            let count = states.len().checked_mul(vectors * width);
            if count.is_none_or(|count| count > MAX_VALUES) {
                return Err(Failure::Input(format!(
                    "{} states and {vectors} wave vectors are too many for one call\n  hint: split them into several calls",
                    states.len()
                )));
            }
            let mut all = vec![0.0; states.len() * vectors * width];
            if all.is_empty() {
                return Ok(all);
            }
            let scope = Scope::current();
            for (f, out) in states.iter().zip(all.chunks_exact_mut(vectors * width)) {
                let waves = problem
                    .analysis
                    .waves(f)
                    .map_err(answers::ProblemError::from)?;
                out.par_chunks_exact_mut(width)
                    .zip(wave_vectors.par_chunks_exact(dimension))
                    .with_min_len(BATCH_STATES)
                    .for_each(|(out, k)| scope.run(|| take(&*waves, k, out)));
            }
            Ok(all)
        })?;
        Ok(bytes(py, &spectra)?.into_any())
    }
}

/// Checks that the phases of wave vectors are resolved in double precision.
fn check(wave_vectors: &[f64], spacing: f64) -> Result<(), Failure> {
    if let Some(value) = wave_vectors.iter().find(|value| !value.is_finite()) {
        return Err(Failure::Input(format!(
            "k contains {value}; all its numbers must be finite"
        )));
    }
    let largest = wave_vectors
        .iter()
        .fold(0.0, |most: f64, x| most.max(x.abs()));
    let value = largest * spacing;
    if value > MAX_PHASE {
        return Err(answers::ProblemError::WaveVector { value }.into());
    }
    Ok(())
}

/// Name of a stored number, and its value in a record.
type Taken<T> = (&'static str, fn(&Record) -> T);

const NUMBERS: &[Taken<f64>] = &[
    ("scaled_minimum", |record| record.scaled_minimum),
    ("lowest_omega_squared", |record| record.lowest_omega_squared),
    ("growth_rate", |record| record.growth_rate),
    ("critical_time_step", |record| record.critical_time_step),
    ("acoustic_minimum", |record| record.acoustic_minimum),
];

const VECTORS: &[Taken<[f64; 3]>] = &[
    ("wave_vector", |record| record.wave_vector),
    ("acoustic_direction", |record| record.acoustic_direction),
];

/// Place of a value in a list, or the length of the list without a value.
fn code<T: PartialEq>(all: &[T], value: Option<T>) -> f64 {
    let place = value.and_then(|value| all.iter().position(|other| *other == value));
    place.unwrap_or(all.len()) as f64
}

/// Records of states as computed by a map, on all cores.
fn records(
    problem: &answers::Problem,
    components: &[f64],
    prepared: impl FnOnce(Evaluator) -> Evaluator,
) -> Result<Vec<Record>, Failure> {
    let states = states(problem, components)?;
    let map = MapSettings::default();
    let evaluator = Evaluator::new(problem.settings.clone(), &map, states.len() >= MANY_STATES)?;
    let evaluator = prepared(evaluator);
    let shares = 4 * rayon::current_num_threads();
    let part = states.len().div_ceil(shares).clamp(1, BATCH_STATES);
    let scope = Scope::current();
    let of_part = |(n, states): (usize, &[DeformationGradient])| {
        let records = scope.run(|| evaluator.records(states));
        let records = records.into_iter().enumerate();
        records
            .map(|(i, record)| {
                let at = |error| Failure::Input(format!("state {}: {error}", n * part + i));
                record.map_err(at)
            })
            .collect::<Result<Vec<_>, _>>()
    };
    let parts: Result<Vec<Vec<Record>>, Failure> =
        states.par_chunks(part).enumerate().map(of_part).collect();
    Ok(parts?.concat())
}

/// Answer along a path.
fn along(problem: Arc<answers::Problem>, course: Course) -> Result<Answer, Failure> {
    let path = PathAnswer::along(&problem, &course)?;
    let sampled = Arc::new(move || PathSamples::new(&problem, &course));
    let own = Arc::clone(&sampled);
    let answer = Answer::with_table(&path, &path, move || Ok(own()?.csv()))?;
    Ok(answer.with_files(move || Ok(sampled()?.files(&path))))
}

/// Loading mode with the given name.
///
/// # Errors
/// [`Failure`] with all names.
pub fn mode_named(name: &str) -> Result<Mode, Failure> {
    let named = Mode::ALL.into_iter().find(|mode| mode.name() == name);
    named.ok_or_else(|| unknown("mode", name, Mode::ALL.map(Mode::name)))
}

/// Lateral condition with the given name.
fn lateral_named(name: &str) -> Result<Lateral, Failure> {
    let all = [
        Lateral::Free,
        Lateral::PlaneStress,
        Lateral::PlaneStrain,
        Lateral::Held,
    ];
    let named = all.into_iter().find(|lateral| lateral.name() == name);
    named.ok_or_else(|| unknown("lateral", name, all.map(Lateral::name)))
}

/// Error for an invalid word of an argument.
pub fn unknown(argument: &str, word: &str, known: impl AsRef<[&'static str]>) -> Failure {
    Failure::Input(format!(
        "{argument} cannot be \"{word}\"\n  hint: expected one of {}",
        known.as_ref().join(", ")
    ))
}
