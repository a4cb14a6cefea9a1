//! Law whose energy, stress and tangent are computed by a Python function.

use crate::arrays::bytes;
use crate::pool::evaluating;
use nalgebra::Matrix3;
use onset::cancel::checkpoint;
use onset::kinematics::DeformationGradient;
use onset::material::{FourthOrder, Hyperelastic, MaterialError, PlaneTangent, Response};
use onset_study::settings::{HandedLaw, MaterialSettings};
use onset_umat::readable;
use pyo3::exceptions::{PyArithmeticError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::sync::Arc;

/// Number of values per state: energy `W`, stress `P_iJ` and tangent `A_iJkL`.
pub const NUMBERS: usize = 91;

/// Python function of a law with the values of its parameters. It maps states (`F`, nine doubles each) to energy, stress `P` and tangent
/// `dP/dF` (1 + 9 + 81 doubles per state), as bytes.
#[pyclass(frozen, module = "onset._onset")]
pub struct Function {
    respond: Arc<Py<PyAny>>,
    parameters: Vec<(String, f64)>,
}

#[pymethods]
impl Function {
    #[new]
    fn new(respond: Py<PyAny>, parameters: Vec<(String, f64)>) -> Self {
        Self {
            respond: Arc::new(respond),
            parameters,
        }
    }
}

impl Function {
    /// Material settings of the law with its parameters.
    fn settings(&self) -> MaterialSettings {
        let respond = Arc::clone(&self.respond);
        let law = HandedLaw::new(move |parameters| {
            Ok(Box::new(FunctionLaw {
                respond: Arc::clone(&respond),
                parameters: parameters.to_vec(),
            }))
        });
        let parameters = self.parameters.iter();
        let parameters = parameters.map(|(name, value)| (name.as_str(), *value));
        MaterialSettings::handed(law, &parameters.collect::<Vec<_>>())
    }
}

/// Setting passed by the package.
#[derive(FromPyObject)]
pub enum Setting {
    /// Assignment, as for `--set`.
    Assignment(String),
    /// Law defined by a Python function instead of a name.
    Law(Py<Function>),
}

/// Settings passed by the package.
pub struct Assigned {
    /// Assignments, as for `--set`.
    pub texts: Vec<String>,
    law: Option<MaterialSettings>,
}

impl From<Vec<Setting>> for Assigned {
    fn from(settings: Vec<Setting>) -> Self {
        let mut assigned = Self {
            texts: Vec::new(),
            law: None,
        };
        for setting in settings {
            match setting {
                Setting::Assignment(text) => assigned.texts.push(text),
                Setting::Law(function) => assigned.law = Some(function.get().settings()),
            }
        }
        assigned
    }
}

impl Assigned {
    /// Law given by a Python function, if any.
    pub fn law(&self) -> Option<&MaterialSettings> {
        self.law.as_ref()
    }
}

/// Law evaluated by a Python function.
struct FunctionLaw {
    respond: Arc<Py<PyAny>>,
    parameters: Vec<(&'static str, f64)>,
}

impl FunctionLaw {
    /// Values of all states.
    fn numbers(&self, states: &[DeformationGradient]) -> Result<Vec<f64>, MaterialError> {
        checkpoint();
        // Without an interpreter the program is ending, and the answer is no longer needed.
        Python::try_attach(|py| {
            self.asked(py, states)
                .map_err(|error| undefined(py, &error))
        })
        .unwrap_or_else(|| Err(external("the interpreter ends".to_owned())))
    }

    fn asked(&self, py: Python<'_>, states: &[DeformationGradient]) -> PyResult<Vec<f64>> {
        let components: Vec<f64> = states
            .iter()
            .flat_map(|f| f.components().as_flattened().to_vec())
            .collect();
        let parameters = PyDict::new(py);
        for (name, value) in &self.parameters {
            parameters.set_item(name, value)?;
        }
        let arguments = (bytes(py, &components)?, parameters);
        let answer = evaluating(|| self.respond.call1(py, arguments))?;
        let answer = answer.bind(py).cast::<PyBytes>()?;
        let (numbers, _) = answer.as_bytes().as_chunks();
        if numbers.len() != states.len() * NUMBERS {
            let wanted = states.len() * NUMBERS;
            return Err(PyValueError::new_err(format!(
                "{} numbers instead of {wanted}",
                numbers.len()
            )));
        }
        Ok(numbers.iter().copied().map(f64::from_ne_bytes).collect())
    }
}

/// Converts an exception of the function: an arithmetic error means that the law is undefined at the state, any other is a programming error.
fn undefined(py: Python<'_>, error: &PyErr) -> MaterialError {
    let class = error.get_type(py);
    let class = class
        .name()
        .map_or_else(|_| "an exception".to_owned(), |name| name.to_string());
    let text = readable(&format!("{class}: {}", error.value(py)));
    let is_of_state =
        error.is_instance_of::<PyArithmeticError>(py) || error.is_instance_of::<PyValueError>(py);
    match is_of_state {
        true => MaterialError::OutsideDomain {
            what: "the function of the material",
            value: f64::NAN,
            expected: format!("it raises {text}"),
        },
        false => external(format!("the function of the material raises {text}")),
    }
}

fn external(message: String) -> MaterialError {
    MaterialError::External { message }
}

/// Response from the values of a state.
fn response(f: &DeformationGradient, numbers: &[f64]) -> Result<Response, MaterialError> {
    if let Some(n) = numbers.iter().position(|number| !number.is_finite()) {
        let what = match n {
            0 => "the energy of the function",
            1..10 => "the stress of the function",
            _ => "the tangent of the function",
        };
        return Err(MaterialError::OutsideDomain {
            what,
            value: numbers[n],
            expected: format!("expected finite numbers (J is {})", f.jacobian()),
        });
    }
    Ok(Response {
        deformation: *f,
        energy: numbers[0],
        first_piola: Matrix3::from_row_slice(&numbers[1..10]),
        tangent: FourthOrder::from_fn(|i, j, k, l| numbers[10 + 27 * i + 9 * j + 3 * k + l]),
    })
}

impl Hyperelastic for FunctionLaw {
    fn response(&self, f: &DeformationGradient) -> Result<Response, MaterialError> {
        let numbers = self.numbers(std::slice::from_ref(f))?;
        response(f, &numbers)
    }

    fn responses(&self, states: &[DeformationGradient]) -> Vec<Result<Response, MaterialError>> {
        match self.numbers(states) {
            Ok(numbers) => states
                .iter()
                .zip(numbers.chunks_exact(NUMBERS))
                .map(|(f, numbers)| response(f, numbers))
                .collect(),
            // Single evaluations show which of the states failed.
            Err(_) if states.len() > 1 => states.iter().map(|f| self.response(f)).collect(),
            Err(error) => vec![Err(error)],
        }
    }

    fn plane_tangents(
        &self,
        states: &[DeformationGradient],
    ) -> Vec<Result<PlaneTangent, MaterialError>> {
        let responses = self.responses(states).into_iter();
        responses
            .map(|response| Ok(response?.tangent.in_plane()))
            .collect()
    }
}
