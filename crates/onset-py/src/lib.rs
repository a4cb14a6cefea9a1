//! Compiled part of the Python package `onset` (distribution `onset-mechanics`).
//!
//! It is a thin layer. Settings are assignments, as for `--set`, and an answer consists of the document printed by `--json` with its text and files.
//! The package in `python/onset` converts keyword arguments to settings, and documents to objects. Arrays are passed in as buffers of doubles and out
//! as bytes, which NumPy wraps without a copy.
//!
//! Every computation runs in a separate thread without the interpreter's lock, while the calling thread checks for signals.

mod answer;
mod arrays;
mod failure;
mod fit;
mod function;
mod interrupt;
mod law;
mod methods;
mod names;
mod plastic;
mod pool;
mod problem;
mod screen;
mod study;
mod zoo;

/// Compiled part of the package `onset`.
#[pyo3::pymodule]
mod _onset {
    #[pymodule_export]
    use crate::answer::Answer;
    #[pymodule_export]
    use crate::fit::fit;
    #[pymodule_export]
    use crate::function::Function;
    #[pymodule_export]
    use crate::law::{Law, read_law};
    #[pymodule_export]
    use crate::methods::{compare, modes, recommend, tune};
    #[pymodule_export]
    use crate::names::{check, keys, mechanism_names, models, notes, verdict_names, version};
    #[pymodule_export]
    use crate::plastic::localize;
    #[pymodule_export]
    use crate::problem::Problem;
    #[pymodule_export]
    use crate::screen::screen;
    #[pymodule_export]
    use crate::study::Study;
    #[pymodule_export]
    use crate::zoo::zoo;

    #[pymodule_init]
    fn init(_module: &pyo3::Bound<'_, pyo3::types::PyModule>) -> pyo3::PyResult<()> {
        crate::pool::loaded();
        Ok(())
    }
}
