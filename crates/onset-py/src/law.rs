//! Material law without a method: criteria, card, audit, stress and tangent.

use crate::answer::Answer;
use crate::arrays::{bytes, deformations, numbers};
use crate::failure::Failure;
use crate::function::{Assigned, NUMBERS, Setting};
use crate::interrupt;
use crate::problem::{Source, mode_named, trusted, unknown};
use onset::cancel::Scope;
use onset::kinematics::DeformationGradient;
use onset::material::Hyperelastic;
use onset_study::answers::Strain;
use onset_study::audit::{Audit, Convention, states};
use onset_study::criteria::{DEFAULT_CRITERIA, Question, Range};
use onset_study::output::picture;
use onset_study::settings::{MaterialSettings, Program, law_of};
use pyo3::buffer::PyBuffer;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use rayon::prelude::*;
use std::path::PathBuf;

/// Number of states in a batch of a thread.
const BATCH_STATES: usize = 256;

/// Material law with its settings.
#[pyclass(frozen, module = "onset._onset")]
pub struct Law {
    settings: MaterialSettings,
}

/// Reads a law from a block of another program: returns the assignments, and notes on its constants.
#[pyfunction]
pub fn read_law(
    program: Option<&str>,
    name: &str,
    text: &str,
    material: Option<String>,
    assignments: Vec<String>,
) -> PyResult<(Vec<String>, Vec<String>)> {
    let program = match program {
        Some(program) => program.parse().map_err(Failure::Input)?,
        None => Program::of_deck(text).ok_or_else(|| {
            Failure::Input(format!(
                "{name} is not recognized as a deck of a program\n  hint: give the program, one of {}",
                Program::ALL.map(Program::name).join(", ")
            ))
        })?,
    };
    let wanted = material.as_deref();
    let read = law_of(program, name, text, wanted, &assignments).map_err(Failure::from)?;
    Ok((read.assignments, read.notes))
}

#[pymethods]
impl Law {
    #[new]
    fn new(
        py: Python<'_>,
        settings: Vec<Setting>,
        file: Option<Source>,
        libraries: Vec<PathBuf>,
        notes: Vec<String>,
    ) -> PyResult<Self> {
        let assigned = Assigned::from(settings);
        interrupt::answer(py, move || {
            let (name, text) = file.unwrap_or_default();
            let mut settings = MaterialSettings::of_file(&name, &text, &assigned.texts)?;
            if let Some(law) = assigned.law() {
                settings.take(law);
            }
            trusted(&mut settings, &libraries)?;
            Ok(Self {
                settings: settings.read_with(notes, None),
            })
        })
    }

    fn criteria(
        &self,
        py: Python<'_>,
        range: (f64, f64),
        modes: Vec<String>,
        incompressible: bool,
    ) -> PyResult<Answer> {
        let question = self.question(py, range, &modes, incompressible)?;
        interrupt::answer(py, move || {
            let criteria = question.answer().map_err(Failure::input)?;
            let answer = Answer::of(&criteria, &criteria, criteria.csv())?;
            Ok(answer.with_files(move || {
                Ok(vec![picture(
                    "criteria",
                    criteria.figure(&DEFAULT_CRITERIA),
                )])
            }))
        })
    }

    fn card(
        &self,
        py: Python<'_>,
        range: (f64, f64),
        modes: Vec<String>,
        incompressible: bool,
    ) -> PyResult<Answer> {
        let question = self.question(py, range, &modes, incompressible)?;
        interrupt::answer(py, move || {
            let card = question.card().map_err(Failure::input)?;
            let answer = Answer::of(&card, &card, card.csv())?;
            Ok(answer.with_files(move || card.files().map_err(Failure::machine)))
        })
    }

    /// Checks the energy and the tangent. States are stretches and components of `F` in the notation of the command line.
    fn audit(
        &self,
        py: Python<'_>,
        strain: f64,
        stretches: Vec<String>,
        components: Vec<String>,
        convention: Option<&str>,
    ) -> PyResult<Answer> {
        let convention = convention.map(convention_named).transpose()?;
        let material = self.settings.clone();
        interrupt::answer(py, move || {
            let mut deformations = Vec::new();
            for stretches in &stretches {
                deformations.push(Strain::of_stretches("stretch", stretches, 2)?.0);
            }
            for components in &components {
                let strain = Strain::of_components("F", components, 2)?;
                deformations.push(strain.0);
            }
            if deformations.is_empty() {
                deformations = states(strain).map_err(Failure::input)?;
            }
            let audit = Audit::of_material(&material, convention, &deformations);
            let audit = audit.map_err(Failure::input)?;
            Answer::of(&audit, &audit, audit.csv())
        })
    }

    /// Energy, first Piola-Kirchhoff stress and tangent at states of nine components each: 91 numbers for each state. `first` is the number of the first
    /// state in messages.
    fn responses<'py>(
        &self,
        py: Python<'py>,
        components: PyBuffer<f64>,
        first: usize,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let components = numbers(py, &components)?;
        let settings = self.settings.clone();
        let responses = interrupt::answer(py, move || {
            let law = settings.build().map_err(Failure::input)?;
            let states = deformations(&components, first)?;
            let mut all = vec![0.0; states.len() * NUMBERS];
            let scope = Scope::current();
            let part = |(n, (out, states)): (usize, (&mut [f64], &[DeformationGradient]))| {
                for (i, (out, f)) in out.chunks_exact_mut(NUMBERS).zip(states).enumerate() {
                    let state = first + n * BATCH_STATES + i;
                    respond(&*law, f, out)
                        .map_err(|error| Failure::Input(format!("state {state}: {error}")))?;
                }
                Ok::<(), Failure>(())
            };
            if states.len() <= BATCH_STATES {
                // Computed by this thread, because all others may be waiting for a Python law that called this function.
                part((0, (&mut all, &states)))?;
                return Ok(all);
            }
            all.par_chunks_mut(NUMBERS * BATCH_STATES)
                .zip(states.par_chunks(BATCH_STATES))
                .enumerate()
                .try_for_each(|own| scope.run(|| part(own)))?;
            Ok(all)
        })?;
        bytes(py, &responses)
    }
}

impl Law {
    fn question(
        &self,
        py: Python<'_>,
        (low, high): (f64, f64),
        modes: &[String],
        incompressible: bool,
    ) -> PyResult<Question> {
        let range = Range::new(low, high).map_err(Failure::input)?;
        let modes = modes.iter().map(|name| mode_named(name));
        let modes = modes.collect::<Result<Vec<_>, _>>()?;
        let material = self.settings.clone();
        interrupt::answer(py, move || {
            let question = Question::new(&material, range, &modes).map_err(Failure::input)?;
            match incompressible {
                true => question.incompressible().map_err(Failure::input),
                false => Ok(question),
            }
        })
    }
}

/// Writes `W`, `P_iJ` and `A_iJkL` in the order of their indices.
fn respond(
    law: &dyn Hyperelastic,
    f: &DeformationGradient,
    out: &mut [f64],
) -> Result<(), onset::material::MaterialError> {
    let response = law.response(f)?.finite()?;
    out[0] = response.energy;
    for (n, place) in out[1..10].iter_mut().enumerate() {
        *place = response.first_piola[(n / 3, n % 3)];
    }
    for (n, place) in out[10..].iter_mut().enumerate() {
        *place = response.tangent[(n / 27, n / 9 % 3, n / 3 % 3, n % 3)];
    }
    Ok(())
}

fn convention_named(name: &str) -> Result<Convention, Failure> {
    Convention::of_name(name)
        .ok_or_else(|| unknown("convention", name, Convention::ALL.map(Convention::name)))
}
