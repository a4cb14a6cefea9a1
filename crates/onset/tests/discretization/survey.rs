//! Many states at once against one at a time.

use crate::choices::{Case, case, config};
use onset::method::{Discretization, Frame, Method};
use onset::verdict::{Survey, assess};
use proptest::prelude::*;

/// Compares a survey, prepared for many states or not, with the assessment of the state alone.
fn agrees(case: &Case, prepared: bool) -> Result<(), TestCaseError> {
    let (method, material) = (case.method(), case.material());
    let assessment = assess(&method, &*material, &case.state).expect("finite");
    let survey = Survey::new(method, case.material()).expect("finite");
    let survey = if prepared {
        survey.for_many_states().expect("finite")
    } else {
        survey
    };
    let finding = survey.state(&case.state).expect("finite");
    let spectrum = &assessment.spectrum;
    let (mu, omega) = (spectrum.softest.scaled, spectrum.maximum_omega);
    if mu.abs() > 100.0 * spectrum.tolerance {
        prop_assert_eq!(finding.verdict, assessment.verdict);
        prop_assert_eq!(finding.stability, spectrum.stability());
    }
    // Valleys of nearly no energy have several bottoms at a level of 1e-8.
    let margin = 1e-9 * mu.abs() + 1e-8 + 10.0 * spectrum.tolerance;
    prop_assert!(
        finding.scaled_minimum <= mu + margin,
        "{} above {mu}",
        finding.scaled_minimum
    );
    prop_assert!(finding.maximum_omega >= omega * (1.0 - 1e-9));
    prop_assert!(finding.growth_rate >= spectrum.growth_rate() * (1.0 - 1e-7) - 1e-7 * omega);
    let acoustic = assessment.material.minimum.eigenvalue.re;
    prop_assert!(
        (finding.acoustic.eigenvalue.re - acoustic).abs() <= 1e-12 * acoustic.abs().max(1.0)
    );
    Ok(())
}

/// The same case with a Lagrangian kernel and the background that the gradient moments need.
fn lagrangian(case: Case) -> Case {
    Case {
        discretization: Discretization {
            frame: Frame::Lagrangian,
            background: onset::method::Background::Imposed,
            ..case.discretization
        },
        ..case
    }
}

proptest! {
    #![proptest_config(config(300))]

    #[test]
    fn a_survey_of_any_method_agrees_with_the_assessment_of_a_state(case in case()) {
        agrees(&case, false)?;
    }

    #[test]
    fn extreme_points_of_the_gradient_moments_find_what_a_search_of_the_zone_finds(case in case()) {
        let case = lagrangian(case);
        // A support that Eulerian kernels scale may be too small without.
        if Method::<2>::new(case.discretization)
            .is_ok_and(|method| assess(&method, &*case.material(), &case.state).is_ok())
        {
            agrees(&case, true)?;
        }
    }
}
