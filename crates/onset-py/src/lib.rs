//! The compiled part of the Python package `onset` (distribution `onset-mechanics`).
//!
//! Thin: settings are the assignments that the command takes after `--set`, and an answer is the document that it prints with
//! `--json`, with the text and the files that it has beside it. The package around it, in `python/onset`, makes keyword arguments into
//! settings and documents into objects. Arrays come as buffers of doubles and go as bytes, which NumPy wraps without a copy.
//!
//! Every question is answered in a thread of its own while the interpreter's lock is released, and signals are looked for meanwhile.

mod answer;
mod arrays;
mod failure;
mod function;
mod interrupt;
mod law;
mod methods;
mod names;
mod plastic;
mod pool;
mod problem;
mod study;

/// The module `onset._onset`.
#[pyo3::pymodule]
mod _onset {
    #[pymodule_export]
    use crate::answer::Answer;
    #[pymodule_export]
    use crate::function::Function;
    #[pymodule_export]
    use crate::law::{Law, read_law};
    #[pymodule_export]
    use crate::methods::{compare, modes, recommend, tune};
    #[pymodule_export]
    use crate::names::{keys, models, notes, verdict_names, version};
    #[pymodule_export]
    use crate::plastic::localize;
    #[pymodule_export]
    use crate::problem::Problem;
    #[pymodule_export]
    use crate::study::Study;

    #[pymodule_init]
    fn init(_module: &pyo3::Bound<'_, pyo3::types::PyModule>) -> pyo3::PyResult<()> {
        crate::pool::loaded();
        Ok(())
    }
}
