//! Surveys of many states, compared with assessments of single states.

use crate::choices::{Case, case, config, planar_state};
use nalgebra::Vector2;
use onset::analysis::analysis;
use onset::approximation::Approximation;
use onset::bloch::dynamical_matrix;
use onset::kinematics::DeformationGradient;
use onset::lattice::LatticeKind;
use onset::material::{BlatzKo, ModifiedMooneyRivlin};
use onset::method::{Frame, KernelMethodChoices, Method};
use onset::scheme::MethodChoices;
use onset::scheme::element::ElementChoices;
use onset::scheme::sph::TotalLagrangianChoices;
use onset::verdict::{Survey, Verdict, assess};
use proptest::prelude::*;
use std::sync::Arc;

/// Compares a survey, prepared for many states or not, with the assessment of a single state.
fn agrees(case: &Case, prepared: bool) -> Result<(), TestCaseError> {
    let (method, material) = (case.method(), case.material());
    let assessment = assess(&method, &*material, &case.state).expect("finite");
    let survey = Survey::new(&method, &*material).expect("finite");
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
    // Valleys with almost zero energy have several minima at a level of 1e-8.
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

/// Replaces the kernel by a Lagrangian kernel with the background required by the gradient moments.
fn lagrangian(case: Case) -> Case {
    Case {
        discretization: KernelMethodChoices {
            frame: Frame::Lagrangian,
            background: onset::method::Background::Imposed,
            ..case.discretization
        },
        ..case
    }
}

/// State stretched along the axes, within the range of maps.
fn stretched_state() -> impl Strategy<Value = DeformationGradient> {
    (0.5..2.5_f64, 0.5..2.5_f64).prop_map(|(first, second)| {
        DeformationGradient::from_stretches([first, second, 1.0]).expect("positive stretches")
    })
}

/// Returns true if a case can be evaluated.
fn has_answer(case: &Case) -> bool {
    let material = case.material();
    Method::<2>::new(case.discretization.clone()).is_ok_and(|method| {
        Survey::new(&method, &*material).is_ok_and(|survey| survey.state(&case.state).is_ok())
    })
}

/// Lagrangian methods that can be evaluated.
fn evaluable() -> impl Strategy<Value = Case> {
    case()
        .prop_map(lagrangian)
        .prop_filter("a support that is large enough", has_answer)
}

/// Smallest scaled measure on a grid of half of the zone.
fn smallest_on_grid(case: &Case, survey: &Survey<'_, 2>, resolution: usize) -> f64 {
    let method = case.method();
    let matrix = dynamical_matrix(&method, &*case.material(), &case.state).expect("finite");
    let lattice = method.lattice();
    let mut smallest = f64::INFINITY;
    for i in 0..=resolution / 2 {
        for j in 0..resolution {
            let fractions = Vector2::new(i as f64, j as f64) / resolution as f64;
            let k = lattice.reciprocal() * fractions;
            let scale = survey.speed_squared() * lattice.laplacian(&k);
            if scale > 0.0 {
                smallest = smallest.min(matrix.omega_squared(&k)[0].re / scale);
            }
        }
    }
    smallest
}

#[test]
fn surveys_and_single_states_select_the_same_wave_among_equally_soft_waves() {
    let mut finite = 0;
    for lattice in [LatticeKind::Square, LatticeKind::Hexagonal] {
        for approximation in [Approximation::Shepard, Approximation::Mls] {
            let method = Method::<2>::new(KernelMethodChoices {
                frame: Frame::Lagrangian,
                lattice,
                approximation,
                ..KernelMethodChoices::default()
            });
            let (method, material) = (method.expect("a method"), ModifiedMooneyRivlin::default());
            let survey = Survey::new(&method, &material).expect("finite");
            let many = survey.clone().for_many_states().expect("finite");
            let size = method.lattice().reciprocal().column(0).norm();
            for stretches in [
                [1.0, 1.0],
                [1.3, 1.3],
                [0.7, 0.7],
                [1.4, 0.8],
                [0.6, 1.1],
                [2.0, 1.0],
            ] {
                let state = DeformationGradient::from_stretches([stretches[0], stretches[1], 1.0]);
                let state = state.expect("positive");
                let softest = survey.assess(&state).expect("finite").spectrum.softest;
                let own = many.state(&state).expect("finite");
                let what =
                    format!("{lattice:?} {approximation:?} {stretches:?}: {own:?} {softest:?}");
                assert_eq!(own.is_long_wave, softest.is_long_wave, "{what}");
                let apart = (own.wave_vector - softest.wave_vector).norm();
                // At the end of a descent a wave vector is known to the root of rounding.
                let scale = if own.is_long_wave { 1.0 } else { size };
                assert!(apart < 1e-5 * scale, "{what}");
                finite += usize::from(!own.is_long_wave);
            }
        }
    }
    assert!(finite > 3, "{finite}");
}

proptest! {
    #![proptest_config(config(120))]

    #[test]
    fn no_grid_point_is_below_the_minimum_of_a_survey(
        case in evaluable(),
        stretched in stretched_state(),
        is_stretched in any::<bool>(),
    ) {
        let state = if is_stretched { stretched } else { case.state };
        let case = Case { state, ..case };
        let (method, material) = (case.method(), case.material());
        let survey = Survey::new(&method, &*material).expect("finite");
        let survey = survey.for_many_states().expect("finite");
        let minimum = survey.state(&state).expect("finite").scaled_minimum;
        let smallest = smallest_on_grid(&case, &survey, 70);
        prop_assert!(
            minimum <= smallest + 1e-12 * smallest.abs().max(1.0),
            "{minimum} above {smallest}"
        );
    }

    #[test]
    fn the_result_for_a_state_does_not_depend_on_other_states_of_a_survey(
        case in evaluable(),
        sheared in prop::collection::vec(planar_state(), 1..4),
        stretched in prop::collection::vec(stretched_state(), 9..30),
    ) {
        let (method, material) = (case.method(), case.material());
        let survey = Survey::new(&method, &*material).expect("finite");
        let survey = survey.for_many_states().expect("finite");
        let states: Vec<_> = stretched.iter().chain(&sheared).chain(&stretched[1..3]).copied().collect();
        for (f, together) in states.iter().zip(survey.states(&states)) {
            prop_assert_eq!(together.expect("finite"), survey.state(f).expect("finite"));
        }
    }
}

proptest! {
    #![proptest_config(config(150))]

    #[test]
    fn a_survey_of_any_method_agrees_with_the_assessment_of_a_state(case in case()) {
        agrees(&case, false)?;
    }

    #[test]
    fn extreme_points_of_the_gradient_moments_agree_with_a_search_over_the_zone(case in case()) {
        let case = lagrangian(case);
        // A support that is sufficient for scaled Eulerian kernels may be too small without scaling.
        if has_answer(&case) {
            agrees(&case, true)?;
        }
    }

    #[test]
    fn surveys_of_axis_aligned_stretches_agree_with_single_assessments(
        case in evaluable(),
        state in stretched_state(),
    ) {
        agrees(&Case { state, ..case }, true)?;
    }
}

/// States around the reference configuration, far enough from it for instabilities of laws and methods.
fn sampled_states() -> Vec<DeformationGradient> {
    let stretches = [0.6, 0.8, 1.0, 1.3, 1.9, 3.0];
    let pairs = stretches
        .iter()
        .flat_map(|a| stretches.map(|b| [*a, b, 1.0]));
    let states = pairs.map(DeformationGradient::from_stretches);
    states
        .collect::<Result<_, _>>()
        .expect("positive stretches")
}

#[test]
fn sampled_waves_bound_the_extremes_of_a_search() {
    let kernel = |frame| {
        MethodChoices::Kernel(Box::new(KernelMethodChoices {
            frame,
            ..KernelMethodChoices::default()
        }))
    };
    let methods = [
        kernel(Frame::Eulerian),
        kernel(Frame::Lagrangian),
        MethodChoices::TotalLagrangianSph(Box::default(), TotalLagrangianChoices::default()),
        MethodChoices::FiniteElements(ElementChoices::default()),
    ];
    let (mut agreeing, mut compared, mut numerical, mut physical) = (0, 0, 0, 0);
    for method in methods {
        let analysis = analysis(&method, Arc::new(BlatzKo::default())).expect("a method");
        let states = sampled_states();
        let searched = analysis.states(&states);
        let coarse = analysis.sampled_states(&states, 6);
        let fine = analysis.sampled_states(&states, 12);
        for ((searched, coarse), fine) in searched.into_iter().zip(coarse).zip(fine) {
            let (Ok(searched), Ok(coarse), Ok(fine)) = (searched, coarse, fine) else {
                continue;
            };
            let tiny = 1e-9 * searched.maximum_omega;
            // The fine grid contains the coarse one.
            for (own, better) in [(&coarse, &fine), (&fine, &searched)] {
                assert!(
                    own.maximum_omega <= better.maximum_omega + tiny,
                    "{method:?}"
                );
                assert!(
                    own.growth_rate <= better.growth_rate + 1e3 * tiny,
                    "{method:?}"
                );
                assert!(
                    own.lowest_omega_squared
                        >= better.lowest_omega_squared - tiny * searched.maximum_omega
                );
                assert!(own.scaled_minimum >= better.scaled_minimum - 1e-8);
            }
            assert_eq!(fine.acoustic, searched.acoustic);
            compared += 1;
            agreeing += usize::from(fine.verdict == searched.verdict);
            numerical += usize::from(fine.verdict == Verdict::Numerical);
            physical += usize::from(fine.verdict == Verdict::Physical);
        }
    }
    assert!(
        numerical > 10 && physical > 10,
        "{numerical} numerical, {physical} physical"
    );
    assert!(
        100 * agreeing >= 95 * compared,
        "{agreeing} of {compared} verdicts agree"
    );
}
