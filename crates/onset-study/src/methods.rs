//! From settings to a discretization of any kind.

use crate::answers::ProblemError;
use crate::settings::Settings;
use onset::method::Method;
use onset::scheme::Scheme;

/// The discretization that settings describe.
///
/// # Errors
/// [`ProblemError`] when a setting is out of range, or the number of dimensions is not `D`.
pub fn scheme<const D: usize>(settings: &Settings) -> Result<Box<dyn Scheme<D>>, ProblemError> {
    Ok(Box::new(Method::<D>::new(settings.discretization.clone())?))
}
