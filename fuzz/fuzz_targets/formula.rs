//! Fuzzing of formulas: any text is parsed, given parameter values, and evaluated with floating point, jets and intervals.
//!
//! Nothing may panic, and the value must lie within its enclosure.
//!
//! `cargo +nightly fuzz run formula` starts from `fuzz/corpus/formula` and uses the dictionary `fuzz/formula.dict`.

#![no_main]

use libfuzzer_sys::fuzz_target;
use onset::formula::Formula;
use onset::kinematics::DeformationGradient;
use onset::material::{Hyperelastic, StrainEnergy};
use onset::real::Interval;

fuzz_target!(|text: &str| {
    let formula = match Formula::parse(text) {
        Ok(formula) => formula,
        Err(error) => {
            assert!(!error.to_string().is_empty());
            return;
        }
    };
    let names: Vec<String> = formula.parameters().map(str::to_owned).collect();
    let values: Vec<(&str, f64)> = names.iter().map(|name| (name.as_str(), 0.7)).collect();
    let law = match formula.with(&values) {
        Ok(law) => law,
        Err(error) => {
            assert!(!error.to_string().is_empty());
            return;
        }
    };
    let components = [[1.1, 0.2, 0.0], [-0.1, 0.9, 0.1], [0.0, 0.3, 1.2]];
    let f = DeformationGradient::from_components(components);
    let point = DeformationGradient::from_components(components.map(|row| row.map(Interval::point)));
    let energy = law.energy(&f);
    let _ = law.response(&f);
    let _ = law.plane_tangent(&f);
    let bounds = law.enclosure(&point);
    assert!(bounds.energy.low <= bounds.energy.high);
    // The bounds contain the exact value, but not necessarily the rounded one.
    if let Ok(response) = law.response(&f) {
        assert_eq!(response.energy.is_nan(), energy.is_nan());
    }
});
