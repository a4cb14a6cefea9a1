//! Contents of a page apart from answers: the options of `onset list`, the classes of maps with their colors, and the zoo of reported instabilities.

use super::zoo::{Entry, entries};
use crate::catalog::{Topic, topics};
use crate::domain::Class;
use serde::Serialize;

/// Options, classes and zoo.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Catalog {
    version: &'static str,
    topics: Vec<Topic>,
    classes: [ShownClass; 7],
    zoo: Vec<Entry>,
}

/// Class of a state in a map.
#[derive(Clone, Debug, Serialize)]
struct ShownClass {
    name: &'static str,
    title: &'static str,
    color: String,
}

pub(super) fn catalog() -> Catalog {
    Catalog {
        version: env!("CARGO_PKG_VERSION"),
        topics: topics(),
        classes: Class::ALL.map(|class| ShownClass {
            name: class.name(),
            title: class.title(),
            color: class.color().to_string(),
        }),
        zoo: entries(),
    }
}
