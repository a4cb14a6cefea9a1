//! Questions sent by a page.

use super::{Refusal, map};
use crate::answers::{Problem, Strain, assigned, numbers};
use crate::settings::{Axis, MaterialSettings, Quantity, Settings, Study, Trust};
use serde::{Deserialize, Serialize};

/// Question of a page: the arguments of a command, and a window of states.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Question {
    /// Assignments, as for `--set`.
    pub set: Vec<String>,
    /// Principal stretches, as for `--stretch`.
    pub stretch: String,
    /// Window of the map.
    pub window: Window,
    /// Number of refinements of the map.
    pub level: u32,
    /// Path of a diagram through the zone, as for `--path`; empty for the default path.
    pub path: String,
    /// Form of an exported question.
    pub form: String,
    /// Text of a study to open.
    pub text: String,
}

/// Window of states: two axes of a study and their ranges.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Window {
    /// Quantities of the axes: `stretch-1` to `stretch-3`, or a key with a numeric value.
    pub axes: [String; 2],
    /// Ranges of the axes.
    pub ranges: [[f64; 2]; 2],
}

/// Largest number of displacements in a cell, to keep answers fast.
const MAX_UNKNOWNS: usize = 96;

impl Default for Window {
    fn default() -> Self {
        Self {
            axes: ["stretch-1".to_owned(), "stretch-2".to_owned()],
            ranges: [[0.5, 2.0]; 2],
        }
    }
}

impl Question {
    /// Parses a question sent by a page.
    ///
    /// # Errors
    /// [`Refusal`] if the text is not a valid question.
    pub fn parse(text: &str) -> Result<Self, Refusal> {
        serde_json::from_str(text)
            .map_err(|error| Refusal::Input(format!("the request cannot be read: {error}")))
    }

    /// Material and discretization; a library is loaded only if the user allows it.
    pub(super) fn settings(&self, trust: &Trust) -> Result<Settings, Refusal> {
        let mut settings = Settings::of_file("", "", &self.set, &[])?;
        permit(&mut settings.material, trust)?;
        Ok(settings)
    }

    /// Problem of the question.
    pub(super) fn problem(&self, trust: &Trust) -> Result<Problem, Refusal> {
        let problem = Problem::new(self.settings(trust)?)?;
        let unknowns = problem.dimension() * problem.analysis.sites();
        if unknowns > MAX_UNKNOWNS {
            return Err(Refusal::Input(format!(
                "the cell has {unknowns} displacements; a page supports at most {MAX_UNKNOWNS}\n  hint: choose fewer discretization.cells here, or use the command"
            )));
        }
        Ok(problem)
    }

    /// Strain state of the question.
    pub(super) fn strain(&self, problem: &Problem) -> Result<Strain, Refusal> {
        Ok(Strain::of_stretches(
            "--stretch",
            &self.stretch,
            problem.extent(),
        )?)
    }

    /// Study of the window, with the given number of states along each axis.
    pub(super) fn study(&self, trust: &Trust, states: usize) -> Result<Study, Refusal> {
        let mut text = String::from("title = \"\"\n");
        let state = self.held()?;
        if !state.is_empty() {
            text.push_str("[state]\n");
        }
        for (name, value) in state {
            text.push_str(&format!("{name} = {value:?}\n"));
        }
        for (name, [low, high]) in self.window.axes.iter().zip(self.window.ranges) {
            let quantity = explored(name)?;
            text.push_str(&format!(
                "[[axes]]\nquantity = \"{}\"\nrange = [{low:?}, {high:?}]\nstates = {states}\n",
                quantity.name()
            ));
        }
        // The key of an axis may be valid only together with other assignments, so that both are read in one step.
        let is_varied = |assignment: &&String| {
            let name = assignment.split('=').next().unwrap_or_default().trim();
            self.window.axes.iter().any(|axis| axis == name)
        };
        let set: Vec<&String> = self.set.iter().filter(|own| !is_varied(own)).collect();
        let mut study = Study::parse_with("the window", &text, &set)?;
        permit(&mut study.settings.material, trust)?;
        Ok(study)
    }

    /// Stretches that no axis varies, unless they are 1.
    fn held(&self) -> Result<Vec<(&'static str, f64)>, Refusal> {
        let stretches = numbers("--stretch", &self.stretch)?;
        let names = ["stretch-1", "stretch-2", "stretch-3"];
        let held = names.into_iter().zip(stretches);
        let is_free = |name: &str| self.window.axes.iter().any(|axis| axis == name);
        Ok(held
            .filter(|(name, value)| !is_free(name) && *value != 1.0)
            .collect())
    }
}

/// Quantity varied by an axis of a window.
fn explored(name: &str) -> Result<Quantity, Refusal> {
    match Quantity::of_name(name) {
        Some(quantity @ (Quantity::Stretch(_) | Quantity::Setting(_))) => Ok(quantity),
        _ => Err(Refusal::Input(format!(
            "an axis of a window cannot be {name}\n  hint: expected stretch-1, stretch-2, stretch-3, or a key that takes a number"
        ))),
    }
}

/// Refuses a library that the user has not allowed, before it is accessed: the author of a link is not trusted.
pub(super) fn permit(material: &mut MaterialSettings, trust: &Trust) -> Result<(), Refusal> {
    material.of_question();
    material.allow(trust);
    Ok(material.permitted()?)
}

/// Study as a question.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Opened {
    /// Title of the study.
    title: String,
    /// Question at the center of the window.
    question: Question,
}

/// Opens a study as a question, without loading or computing anything.
pub(super) fn opened(text: &str) -> Result<Opened, Refusal> {
    if !text.contains("[[axes]]") {
        let settings = Settings::of_file("study", text, &[] as &[&str], &[])?;
        return Ok(Opened {
            title: String::new(),
            question: of_settings(&settings),
        });
    }
    let study = Study::parse("study", text)?;
    Ok(Opened {
        title: study.title.clone(),
        question: of_study(&study)?,
    })
}

impl Question {
    /// Problem of the page in the reference configuration with the given settings.
    pub fn of_settings(settings: &Settings) -> Self {
        of_settings(settings)
    }

    /// Question about the center of a study's window, without loading anything.
    ///
    /// # Errors
    /// [`Refusal`] for an invalid study, or one whose states the page cannot show.
    pub fn of_text(text: &str) -> Result<Self, Refusal> {
        Ok(opened(text)?.question)
    }
}

fn of_settings(settings: &Settings) -> Question {
    Question {
        set: assigned(settings, None),
        stretch: vec!["1"; settings.dimension()].join(","),
        ..Question::default()
    }
}

/// Question about a study: its first two axes form the window. The state is at the center of the window and of a third axis.
pub(super) fn of_study(study: &Study) -> Result<Question, Refusal> {
    let middle = |axis: &Axis| 0.5 * (axis.range.0 + axis.range.1);
    let coordinates: Vec<f64> = study.axes.iter().map(middle).collect();
    let settings = study.settings_at(&coordinates)?;
    for axis in &study.axes {
        explored(axis.name())?;
    }
    if study.state.shear != 0.0 || study.state.rotation != 0.0 {
        return Err(Refusal::Input(
            "the page shows states of principal stretches along the axes; [state] has a shear or a rotation\n  hint: `onset plot` and \
             `onset boundary` show such studies"
                .to_owned(),
        ));
    }
    let mut stretches = study.state.stretches;
    for (axis, value) in study.axes.iter().zip(&coordinates) {
        if let Quantity::Stretch(number) = axis.quantity {
            stretches[number - 1] = *value;
        }
    }
    let dimension = settings.dimension();
    let told = (dimension..=3).find(|count| stretches[*count..].iter().all(|one| *one == 1.0));
    let stretches = stretches[..told.unwrap_or(3)].iter().map(f64::to_string);
    let [first, second] = study.plane();
    Ok(Question {
        stretch: stretches.collect::<Vec<_>>().join(","),
        window: Window {
            axes: [first, second].map(|axis| axis.name().to_owned()),
            ranges: [first, second].map(|axis| [axis.range.0, axis.range.1]),
        },
        level: map::LEVELS,
        ..of_settings(&settings)
    })
}
