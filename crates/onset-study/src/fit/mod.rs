//! Laws fitted to test data, subject to stability where they are used: from tables to settings of other commands.
//!
//! The mathematics is in the crate `onset-fit`.

mod answer;
mod figure;
mod input;
mod list;

pub use answer::{ConstantAnswer, FitAnswer, LawAnswer, TestAnswer};
pub use input::{Arrays, Columns, Reading, Source, TableError, Tests};
pub use onset_fit::{Criterion, Mode, Options, Point, Range, Test, Weights};

use crate::number::told_with;
use crate::settings::{SettingError, Settings};
use onset::kinematics::DeformationGradient;
use onset_fit::{Family, Fit, FitError, Fitted, Misfit, Model, fit};
use thiserror::Error;

/// Ratio of bulk to shear modulus of a fitted law if there is no volumetric test.
pub const BULK_RATIO: f64 = 1000.0;

/// Smallest scale of relative errors with equal weights of the tests, as a fraction of the largest stress of the test.
pub const TEST_FLOOR: f64 = 0.02;

/// Reason why no law can be fitted.
#[derive(Debug, Error)]
pub enum FittingError {
    /// A table that cannot be used.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A law that cannot be fitted.
    #[error("the law `{law}` cannot be fitted: {reason}\n  hint: laws that can be fitted: {known}")]
    Law {
        /// Name of the law.
        law: String,
        /// Reason in a sentence.
        reason: String,
        /// Laws that can be fitted.
        known: String,
    },
    /// A choice that does not exist.
    #[error("{0}")]
    Choice(String),
    /// No law could be fitted.
    #[error("{0}")]
    None(String),
    /// No law has constants that are stable in the range.
    #[error("{0}")]
    NotStable(String),
    /// A fitted law that the settings refuse.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// A fitted law that cannot be constructed.
    #[error(transparent)]
    Material(#[from] onset::material::MaterialError),
    /// An answer that cannot be written as JSON.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    /// A file that cannot be written.
    #[error(transparent)]
    Output(#[from] crate::output::OutputError),
}

/// Weights by their name, with the smallest scale of relative errors as a fraction of the largest stress of the test.
///
/// # Errors
/// [`FittingError::Choice`] if there are no such weights.
pub fn weights(name: &str, floor: Option<f64>) -> Result<Weights, FittingError> {
    match name {
        "relative" => Ok(Weights::Relative(floor.unwrap_or(0.0))),
        "by-test" => Ok(Weights::ByTest(floor.unwrap_or(TEST_FLOOR))),
        "absolute" => Ok(Weights::Absolute),
        _ => Err(FittingError::Choice(format!(
            "weights are {name:?}; expected relative, by-test or absolute"
        ))),
    }
}

/// Criteria of the stability constraint, by their name.
///
/// # Errors
/// [`FittingError::Choice`] if there is no such criterion.
pub fn criteria(name: &str) -> Result<Vec<Criterion>, FittingError> {
    match name {
        "drucker" => Ok(vec![Criterion::Drucker]),
        "ellipticity" => Ok(vec![Criterion::StrongEllipticity]),
        "both" => Ok(vec![Criterion::Drucker, Criterion::StrongEllipticity]),
        _ => Err(FittingError::Choice(format!(
            "the criterion is {name:?}; expected drucker, ellipticity or both"
        ))),
    }
}

/// Two positive stretches in ascending order, given as `0.5,3`.
///
/// # Errors
/// A sentence on the expected form, for the argument parser.
pub fn stretches_between(text: &str) -> Result<[f64; 2], String> {
    let numbers = text.split(',').map(|own| own.trim().parse::<f64>().ok());
    match numbers.collect::<Option<Vec<f64>>>().as_deref() {
        Some([low, high]) if 0.0 < *low && low < high && high.is_finite() => Ok([*low, *high]),
        _ => Err("expected two positive stretches LOW,HIGH, for example 0.5,3".to_owned()),
    }
}

/// Range of the stability constraint given as text, for example `box=0.3,4`. The text `none` gives `None`.
///
/// # Errors
/// A sentence on the expected form, for the argument parser.
pub fn stable_range(text: &str) -> Result<Option<Range>, String> {
    let expected = "expected data, data=FACTOR, box=LOW,HIGH, loadings=LOW,HIGH or none, for example box=0.3,4";
    let within = |own: &str| {
        let [low, high] = stretches_between(own)?;
        match low < 1.0 && high > 1.0 {
            true => Ok((low, high)),
            false => Err("expected limits on both sides of 1".to_owned()),
        }
    };
    Ok(match text.split_once('=') {
        None if text == "none" => None,
        None if text == "data" => Some(Range::Data(1.25)),
        Some(("data", factor)) => match factor.parse::<f64>() {
            Ok(factor) if (1.0..100.0).contains(&factor) => Some(Range::Data(factor)),
            _ => return Err("expected a factor from 1 to 100, for example data=1.25".to_owned()),
        },
        Some(("box", own)) => within(own).map(|(low, high)| Some(Range::Box(low, high)))?,
        Some(("loadings", own)) => {
            within(own).map(|(low, high)| Some(Range::Loadings(low, high)))?
        }
        _ => return Err(expected.to_owned()),
    })
}

/// Laws of foam, from few constants to many.
const FOAMS: [&str; 3] = ["hyperfoam-1", "hyperfoam-2", "hyperfoam-3"];

/// Families with the given names of laws. `all` selects all families, or all laws of foam if the volume of the specimens changes. A remark on a
/// change of volume is added to the tests.
///
/// # Errors
/// [`FittingError::Law`] with the reason if a law cannot be fitted.
pub fn families(names: &[String], tests: &mut Tests) -> Result<Vec<Family>, FittingError> {
    let mut all: Vec<Family> = Vec::new();
    let is_all = names.iter().any(|name| name == "all");
    for name in names {
        if name == "all" && tests.is_foam() {
            all.extend(FOAMS.into_iter().filter_map(Family::named));
            continue;
        }
        if name == "all" {
            all.extend(Family::all().filter_map(Family::named));
            continue;
        }
        let family = Family::named(name).ok_or_else(|| {
            let reason = match onset::material::Law::named(name) {
                Some(law) if law.symmetry != onset::material::Symmetry::Isotropic => {
                    "it is anisotropic, and the tests do not contain the directions of the specimens".to_owned()
                }
                Some(_) => "its volumetric and its isochoric part have common constants, which tests at constant volume do not determine".to_owned(),
                None => match crate::settings::Model::named(name) {
                    Some(model) if model.is_in_rate_form() => {
                        "it is not hyperelastic: its stress depends on the path".to_owned()
                    }
                    Some(_) => {
                        "a formula, table or routine of the user defines it, without constants that a fit could vary".to_owned()
                    }
                    None => format!(
                        "there is no law of this name{}",
                        crate::settings::did_you_mean(name, Family::all())
                    ),
                },
            };
            FittingError::Law {
                law: name.clone(),
                reason,
                known: Family::all().collect::<Vec<_>>().join(", "),
            }
        })?;
        all.push(family);
    }
    let mut distinct: Vec<Family> = Vec::new();
    for family in all {
        if distinct.iter().all(|own| own.name() != family.name()) {
            distinct.push(family);
        }
    }
    let has_rubber = distinct.iter().any(|own| !own.is_compressible());
    if let Some((test, change)) = tests.volume_change()
        && (has_rubber || is_all)
    {
        let note = format!(
            "{}: by its lateral stretches the volume changes by {} %; {}",
            test.name,
            told_with(100.0 * change, 2),
            match has_rubber {
                true => "only laws of foam take that into account",
                false => "laws of rubber, which keep the volume, are not tried",
            }
        );
        tests.notes.insert(0, note);
    }
    Ok(distinct)
}

/// Fits laws to tests. `each` is called with the name of each law before its fit.
///
/// # Errors
/// [`FittingError`] if no law can be fitted.
pub fn fitted(
    tables: Tests,
    families: &[Family],
    options: &Options,
    bulk: Option<f64>,
    each: &mut dyn FnMut(&str),
) -> Result<FitAnswer, FittingError> {
    let mut fits: Vec<Fit> = Vec::new();
    let mut refused: Vec<(String, String)> = Vec::new();
    let mut is_unstable = true;
    let several = families.len() > 1;
    for family in families {
        each(family.name());
        // Options for a constant apply only to the laws that have it.
        let mut own = options.clone();
        if several {
            let has = |name: &str| family.constants().iter().any(|own| own.name == name);
            own.fixed.retain(|(name, _)| has(name));
            own.bounds.retain(|(name, _)| has(name));
        }
        match fit(&tables.tests, family, &own) {
            Ok(fit) => fits.push(fit),
            Err(error) => {
                is_unstable &= matches!(
                    error,
                    FitError::NotStable { .. } | FitError::NotFound { .. }
                );
                refused.push((family.name().to_owned(), hinted(&error)));
            }
        }
    }
    if fits.is_empty() {
        let reasons: Vec<String> = refused.iter().map(|(_, reason)| reason.clone()).collect();
        return Err(match is_unstable {
            true => FittingError::NotStable(reasons.join("\n")),
            false => FittingError::None(reasons.join("\n")),
        });
    }
    fits.sort_by(|a, b| {
        let key = |own: &Fit| (own.result().undetermined.len().min(1), own.criterion());
        let ((a_open, a), (b_open, b)) = (key(a), key(b));
        a_open.cmp(&b_open).then(a.total_cmp(&b))
    });
    FitAnswer::new(tables, fits, refused, options, bulk)
}

fn hinted(error: &FitError) -> String {
    let hint = match error {
        FitError::TooFewPoints { .. } => {
            "choose a law with fewer constants, or fix the values of some"
        }
        FitError::Undetermined { .. } => return error.to_string(),
        FitError::Bounds { .. } => "change the fixed values or the bounds of the constants",
        FitError::NoLateralStretch { .. } => {
            "add a column lateral_stretch, or choose a law of rubber"
        }
        FitError::UnknownConstant { .. } => "name one of them",
        FitError::NotFound { .. } => {
            "require stability in a smaller range, for example box=0.5,2, choose another law, or give more first guesses"
        }
        FitError::NotConverged { .. } | FitError::NotStable { .. } => {
            "require stability in a smaller range, for example box=0.5,2, or choose another law"
        }
    };
    format!("{error}\n  hint: {hint}")
}

/// Assignments `material.key=value` of a fitted law, with the bulk modulus.
fn assignments(
    family: &Family,
    fitted: &Fitted,
    tests: &[Test],
    bulk: Option<f64>,
) -> Result<(Vec<String>, Option<f64>), FittingError> {
    let mut sets = match family.model() {
        Model::Library(name) => vec![format!("material.model={name}")],
        Model::Formula(energy) => vec![
            "material.model=formula".to_owned(),
            format!("material.energy={energy}"),
        ],
    };
    let named = family.constants().iter().zip(&fitted.constants);
    sets.extend(named.map(|(own, value)| format!("material.{}={value}", own.name)));
    let unused = family.unused();
    sets.extend(
        unused
            .iter()
            .map(|(name, value)| format!("material.{name}={value}")),
    );
    if family.is_compressible() {
        return Ok((sets, None));
    }
    let shear = fitted.shear_modulus;
    let at = |kappa: f64| {
        let mut own = sets.clone();
        own.push(format!("material.kappa={kappa}"));
        own
    };
    let kappa = match (bulk, volumetric(tests)) {
        (Some(bulk), _) => bulk,
        (None, None) => BULK_RATIO * shear,
        (None, Some(points)) => {
            // The pressure is linear in the bulk modulus.
            let unit = BULK_RATIO * shear;
            let (mut above, mut below) = (0.0, 0.0);
            for (point, pressure) in points.iter().zip(pressures(&points, &at(unit))?) {
                let pressure = pressure / unit;
                above += pressure * point.stress;
                below += pressure * pressure;
            }
            above / below
        }
    };
    Ok((at(kappa), Some(kappa)))
}

/// Pressures of a law at the volumes of points; 0 if the law is not defined there.
fn pressures(points: &[Point], settings: &[String]) -> Result<Vec<f64>, FittingError> {
    let law = Settings::from_assignments(settings)?.material.build()?;
    let pressure = |own: &Point| {
        let state = DeformationGradient::from_stretches([own.stretch.cbrt(); 3]).ok()?;
        Some(-law.response(&state).ok()?.cauchy()[(0, 0)])
    };
    Ok(points
        .iter()
        .map(|own| pressure(own).unwrap_or(0.0))
        .collect())
}

/// Misfit of a volumetric test, which only the bulk modulus determines.
fn volumetric_misfit(test: &Test, settings: &[String]) -> Result<Misfit, FittingError> {
    let stresses = pressures(&test.points, settings)?;
    let mean = |square: &dyn Fn(&Point, f64) -> f64| {
        let pairs = test.points.iter().zip(&stresses);
        let sum: f64 = pairs
            .map(|(point, own)| square(point, own - point.stress))
            .sum();
        (sum / test.points.len().max(1) as f64).sqrt()
    };
    Ok(Misfit {
        test: test.name.clone(),
        relative: mean(&|point, error| (error / point.stress).powi(2)),
        absolute: mean(&|_, error| error * error),
        stresses,
    })
}

/// Points of volumetric tests; `None` without such a test.
fn volumetric(tests: &[Test]) -> Option<Vec<Point>> {
    let own = tests.iter().filter(|test| test.mode == Mode::Volumetric);
    let points: Vec<Point> = own.flat_map(|test| test.points.iter().copied()).collect();
    (!points.is_empty()).then_some(points)
}
