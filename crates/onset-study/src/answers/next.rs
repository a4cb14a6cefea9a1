//! Suggested commands after a verdict, with the current settings.

use crate::settings::{Choice, Family, Key, Settings, Shear, Value};
use crate::shell::quoted;
use onset::verdict::Verdict;

/// Suggested commands after a verdict. Empty for a law that the calling program defines, because no command can name it.
pub(super) fn next(settings: &Settings, verdict: Verdict, has_one_particle: bool) -> Vec<String> {
    if settings.material.is_handed() {
        return Vec::new();
    }
    let method = &settings.method;
    let coefficient = match (verdict, method.method) {
        // Artificial stress resists no wave of a body without stress.
        (Verdict::ZeroEnergy, Family::UpdatedSph) if method.shear_forces == Shear::Stress => {
            Some("discretization.penalty")
        }
        _ => stabilization(settings, has_one_particle),
    };
    let modes = format!("onset modes{}", assignments(settings, None));
    let tune =
        coefficient.map(|key| format!("onset tune {key}{}", assignments(settings, Some(key))));
    let criteria = format!("onset criteria{}", of_law(settings));
    match verdict {
        Verdict::ZeroEnergy => [modes].into_iter().chain(tune).collect(),
        Verdict::Numerical | Verdict::Suppressed => tune.into_iter().chain([modes]).collect(),
        Verdict::Physical => vec![criteria],
        Verdict::Stable => Vec::new(),
    }
}

/// Stabilization coefficient that the method uses.
pub(crate) fn stabilization(settings: &Settings, has_one_particle: bool) -> Option<&'static str> {
    let candidates = match settings.method.method {
        Family::TotalLagrangianSph => ["discretization.penalty"].as_slice(),
        Family::UpdatedSph if settings.method.penalty > 0.0 => &["discretization.penalty"],
        Family::UpdatedSph => &["discretization.artificial-stress"],
        Family::FiniteElements => &["discretization.hourglass-stiffness"],
        Family::Conforming => &["discretization.modification"],
        Family::Peridynamics => &["discretization.control-coefficient"],
        Family::Kernel => &["discretization.stress-point-weight"],
        Family::MaterialPoints => &[],
    };
    // In cells with several particles the weight of stress points is fixed.
    if settings.method.method == Family::Kernel && !has_one_particle {
        return None;
    }
    let is_read = |name: &&&str| Key::named(name).is_some_and(|key| settings.unmet(key).is_none());
    candidates.iter().find(is_read).copied()
}

/// `--set` options for all settings that are not defaults, except one key.
fn assignments(settings: &Settings, without: Option<&str>) -> String {
    let set = |assignment: &String| format!(" --set {}", quoted(assignment.as_ref()));
    assigned(settings, without).iter().map(set).collect()
}

/// Assignments that turn the defaults into these settings, except one key: first the model, then moduli as they were set.
pub(crate) fn assigned(settings: &Settings, without: Option<&str>) -> Vec<String> {
    let told = |name: &str, choice: &Choice| {
        let unit = choice.unit.unwrap_or_default();
        let text = match &choice.value {
            Value::Word(word) => word.clone(),
            Value::Numbers(numbers) => numbers
                .iter()
                .map(f64::to_string)
                .collect::<Vec<_>>()
                .join(","),
            other => format!("{other}{unit}"),
        };
        format!("{name}={text}")
    };
    let effective = settings.effective();
    // Moduli as they were set, not the parameters that follow from them.
    let (moduli, follows) = settings.moduli();
    let chosen = effective
        .chosen()
        .filter(|(name, _)| Some(*name) != without && !follows.iter().any(|own| own == name));
    let (model, others): (Vec<_>, Vec<_>) = chosen.partition(|(name, _)| *name == "material.model");
    let told_moduli = moduli.iter().map(|(name, choice)| told(name, choice));
    let first = model.into_iter().map(|(name, choice)| told(name, choice));
    let last = others.into_iter().map(|(name, choice)| told(name, choice));
    first.chain(told_moduli).chain(last).collect()
}

/// `--set` options for the law alone, in 3D.
fn of_law(settings: &Settings) -> String {
    let mut law = Settings::default();
    law.material = settings.material.clone().in_space();
    assignments(&law, None)
}
