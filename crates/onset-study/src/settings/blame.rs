//! Attribution of errors of a method or law to settings.

use super::{MaterialSettings, Origin, SettingError, Settings};
use crate::methods::{hint, method};
use onset::analysis::check_method;
use onset::lattice::LatticeError;
use onset::material::{MaterialError, library};
use onset::method::MethodError;
use onset::quadrature::QuadratureError;

/// Keys that can cause an error, in order of precedence; empty if only a combination of settings causes it.
fn keys_of(error: &MethodError) -> Vec<String> {
    let keys = |names: &[&str]| {
        let full = names.iter().map(|name| format!("discretization.{name}"));
        full.collect()
    };
    match error {
        MethodError::Setting { name, .. } => keys(&[name]),
        MethodError::Lattice(error) | MethodError::Quadrature(QuadratureError::Lattice(error)) => {
            keys(of_lattice(error))
        }
        MethodError::Quadrature(error) => keys(of_quadrature(error)),
        MethodError::Material(error) => of_material(error),
        // The support determines the number of neighbors, and the lattice their positions.
        MethodError::SupportTooSmall { .. }
        | MethodError::SupportTooLarge { .. }
        | MethodError::SingularMoment { .. } => {
            keys(&["support", "points", "basis", "vectors", "aspect", "lattice"])
        }
        MethodError::HorizonTooSmall { .. } | MethodError::HorizonTooLarge { .. } => keys(&[
            "horizon",
            "perturbation",
            "basis",
            "vectors",
            "aspect",
            "lattice",
        ]),
        MethodError::NotOfForces { .. } => keys(&["linearization"]),
        MethodError::StabilizedEulerian => keys(&["quadrature", "frame"]),
        MethodError::SingularMass { .. } => keys(&["grid-mass", "points"]),
        MethodError::Mesh(_) => keys(&["mesh"]),
        _ => Vec::new(),
    }
}

fn of_lattice(error: &LatticeError) -> &'static [&'static str] {
    match error {
        LatticeError::Aspect { .. } => &["aspect"],
        LatticeError::Vectors { .. } => &["vectors", "lattice"],
        LatticeError::Dependent { .. } => &["vectors"],
        LatticeError::Sheared { .. } | LatticeError::Elongated { .. } => &["vectors", "aspect"],
        LatticeError::Spacing { .. } => &["spacing"],
        LatticeError::NoSites => &["basis"],
        LatticeError::CoincidentPoints { .. } => &["points", "basis"],
        LatticeError::Dimension { .. } | LatticeError::VoronoiDimension { .. } => &["lattice"],
    }
}

fn of_quadrature(error: &QuadratureError) -> &'static [&'static str] {
    match error {
        QuadratureError::StressPointWeight { .. } => &["stress-point-weight"],
        QuadratureError::GaussPoints { .. } => &["gauss-points"],
        _ => &["points"],
    }
}

fn of_material(error: &MaterialError) -> Vec<String> {
    let key = |name: &str| format!("material.{name}");
    match error {
        MaterialError::NoPlaneStress { .. } => vec![key("plane")],
        MaterialError::Prony { .. } => vec![key("prony")],
        // Messages about moduli begin with the key of one of them.
        MaterialError::External { message } if message.starts_with("material.") => {
            message.split(' ').take(1).map(str::to_owned).collect()
        }
        MaterialError::External { .. } => vec![key("energy"), key("model")],
        // Conditions on several parameters contain the names of these parameters.
        MaterialError::Parameter { name, .. } => {
            let is_apart = |c: char| !c.is_alphanumeric() && !['_', '-'].contains(&c);
            let words = name.split(is_apart).filter(|word| !word.is_empty());
            let own = words.flat_map(parameters);
            own.chain([key("model")]).collect()
        }
        _ => Vec::new(),
    }
}

/// Keys of a parameter in a formula, where `mu_p` means `mu1`, `mu2`, ...
fn parameters(word: &str) -> Vec<String> {
    let Some(series) = word.strip_suffix("_p") else {
        return vec![format!("material.{word}")];
    };
    let is_term = |name: &str| {
        let number = name.strip_prefix(series);
        number.is_some_and(|number| number.parse::<usize>().is_ok())
    };
    let all = library().iter().flat_map(|law| law.parameters);
    let mut terms: Vec<String> = all
        .filter(|parameter| is_term(parameter.name))
        .map(|parameter| format!("material.{}", parameter.name))
        .collect();
    terms.sort();
    terms.dedup();
    terms
}

/// Attributes an error to the setting that causes it; `None` if no setting does. `origin` returns the place at which a key was set.
pub(super) fn blamed<'o>(
    error: &MethodError,
    origin: impl Fn(&str) -> Option<&'o Origin>,
) -> Option<SettingError> {
    let keys = keys_of(error);
    let origins = || keys.iter().filter_map(|key| origin(key));
    // Varied settings are not set by the user, and other settings are not at fault for them.
    if origins().any(|origin| *origin == Origin::Combination) {
        return None;
    }
    let message = format!("{error}{}", hint(error));
    Some(SettingError::new(origins().next()?.clone(), message))
}

impl Settings {
    /// Attributes an error of the method or law to the setting that causes it; `None` if no setting does.
    pub(crate) fn blamed(&self, error: &MethodError) -> Option<SettingError> {
        blamed(error, |key| self.origin(key))
    }

    /// Refuses values that no method admits. A support that is too small only for this method is not checked here.
    pub(super) fn check_admitted(&self) -> Result<(), SettingError> {
        let checked = check_method(&method(self));
        let error = checked.err().filter(|error| {
            matches!(
                error,
                MethodError::Setting { .. } | MethodError::Lattice(_) | MethodError::Quadrature(_)
            )
        });
        let blamed = error.and_then(|error| self.blamed(&error));
        blamed.map_or(Ok(()), Err)
    }
}

impl MaterialSettings {
    /// Refuses parameters that the law does not admit. Libraries are not loaded for this check.
    ///
    /// # Errors
    /// [`SettingError`] with the place of the setting that causes the error.
    pub fn check_parameters(&self) -> Result<(), SettingError> {
        if self.is_library() {
            return Ok(());
        }
        let origin = |key: &str| self.origin(key.strip_prefix("material.")?);
        let error = self.build().err();
        let blamed = error.and_then(|error| blamed(&error.into(), origin));
        blamed.map_or(Ok(()), Err)
    }
}
