//! Zoo of reported instabilities for a page.

use super::Question;
use crate::zoo::{Case, reports};
use serde::Serialize;

/// Published report of an instability, with the settings that reproduce it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Entry {
    /// Title of the report.
    pub title: String,
    /// Behavior described in the report.
    pub seen: String,
    /// Source of the report.
    #[serde(rename = "where")]
    pub place: String,
    /// Assumptions where the report gives no details.
    pub assumed: String,
    /// Arguments of `onset state` that reproduce the report.
    pub question: Question,
    /// Description of the known remedy.
    pub remedy: String,
    /// Arguments of `onset state` with the remedy; `None` if settings do not express it.
    pub remedy_question: Option<Question>,
}

/// Returns the entries of the zoo as shown on a page.
pub fn entries() -> Vec<Entry> {
    let question = |case: Case| Question {
        set: case.set,
        stretch: case.stretch,
        ..Question::default()
    };
    let entry = |report: crate::zoo::Report| Entry {
        question: question(report.case()),
        remedy_question: report.remedied().map(question),
        title: report.title,
        seen: report.seen,
        place: report.place,
        assumed: report.assumed,
        remedy: report.remedy,
    };
    reports().into_iter().map(entry).collect()
}
