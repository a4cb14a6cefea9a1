//! Zero-energy modes are reported for any method, frame and stress.

use onset::verdict::Verdict;
use onset_study::answers::{Problem, StateAnswer, Strain};
use onset_study::settings::Settings;

fn answer(assignments: &str, stretches: &str) -> StateAnswer {
    let words: Vec<String> = assignments
        .split_whitespace()
        .map(|word| match word.starts_with("material.") {
            true => word.to_owned(),
            false => format!("discretization.{word}"),
        })
        .collect();
    let settings = Settings::from_assignments(&words).expect("settings");
    let problem = Problem::new(settings).expect("a problem");
    let strain =
        Strain::of_stretches("--stretch", stretches, problem.dimension()).expect("a state");
    StateAnswer::new(&problem, &strain).expect("an answer")
}

/// Methods that lack control of their zero-energy modes.
const DEFICIENT: [&str; 8] = [
    "method=kernel frame=lagrangian quadrature=nodal",
    "method=kernel frame=eulerian quadrature=nodal lattice=square",
    "method=peridynamics bonds=correspondence control=none horizon=2 lattice=square",
    "method=total-lagrangian-sph lattice=square support=1.6",
    "method=finite-elements mesh=quadrilaterals integration=one-point",
    "method=updated-sph lattice=square support=2",
    "method=kernel frame=eulerian quadrature=nodal support=2",
    "method=updated-sph support=2",
];

#[test]
fn methods_without_control_have_zero_energy_modes_for_any_law() {
    for method in DEFICIENT {
        for material in ["neo-hooke", "blatz-ko", "hencky"] {
            let answer = answer(&format!("{method} material.model={material}"), "1,1");
            assert_eq!(
                answer.verdict,
                Verdict::ZeroEnergy,
                "{method} {material}: {}",
                answer.sentence
            );
            assert!(
                answer.sentence.contains("zero-energy modes"),
                "{}",
                answer.sentence
            );
        }
    }
}

#[test]
fn a_state_whose_softest_wave_has_no_strain_is_not_called_stable() {
    for method in DEFICIENT {
        for stretches in ["0.9,0.9", "0.95,1", "0.97,0.93", "1.03,1.02", "1,0.99"] {
            let answer = answer(&format!("{method} material.model=neo-hooke"), stretches);
            assert_not_stable_without_gradient(&answer, &format!("{method} {stretches}"));
        }
    }
}

/// Checks that a stable state is not called stable if its softest mode has no strain at any quadrature point.
fn assert_not_stable_without_gradient(answer: &StateAnswer, what: &str) {
    let d = &answer.discretization;
    let is_finite = d.minimum_scaled_wave_vector.iter().any(|x| *x != 0.0);
    if d.stable
        && answer.material.elliptic
        && is_finite
        && d.gradient_norm.is_some_and(|norm| norm < 1e-10)
    {
        assert_eq!(
            answer.verdict,
            Verdict::ZeroEnergy,
            "{what}: {}",
            answer.sentence
        );
    }
    assert!(
        !answer.sentence.contains("has 0 %"),
        "{what}: {}",
        answer.sentence
    );
}

#[test]
fn controlled_methods_keep_their_verdict() {
    for method in [
        "method=kernel frame=lagrangian quadrature=stress-points",
        "method=peridynamics bonds=correspondence control=penalty control-coefficient=0.5 horizon=2 lattice=square",
        "method=updated-sph support=2 penalty=4",
        "method=updated-sph support=2 shear-forces=pairs",
        "method=finite-elements mesh=quadrilaterals integration=full",
        "method=finite-elements mesh=quadrilaterals integration=one-point hourglass-stiffness=0.05",
    ] {
        let answer = answer(&format!("{method} material.model=neo-hooke"), "1,1");
        assert_eq!(
            answer.verdict,
            Verdict::Stable,
            "{method}: {}",
            answer.sentence
        );
    }
}

#[test]
fn surveys_and_single_answers_give_the_same_verdict() {
    use onset::kinematics::DeformationGradient;
    use onset_study::map::Evaluator;
    use onset_study::settings::MapSettings;
    for method in DEFICIENT {
        let words: Vec<String> = method
            .split_whitespace()
            .map(|word| format!("discretization.{word}"))
            .chain(["material.model=neo-hooke".to_owned()])
            .collect();
        let settings = Settings::from_assignments(&words).expect("settings");
        let evaluator = Evaluator::new(settings, &MapSettings::default(), true).expect("ready");
        for stretches in [[1.0, 1.0], [0.95, 1.0], [0.97, 0.93], [1.03, 1.02]] {
            let f = DeformationGradient::from_stretches([stretches[0], stretches[1], 1.0]);
            let records = evaluator.records(&[f.expect("a state")]);
            let record = records.into_iter().next().expect("one").expect("a record");
            let single = answer(
                &format!("{method} material.model=neo-hooke"),
                &format!("{},{}", stretches[0], stretches[1]),
            );
            assert_eq!(
                record.finding.verdict,
                Some(single.verdict),
                "{method} {stretches:?}"
            );
        }
    }
}
