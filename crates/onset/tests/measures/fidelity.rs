//! Fractions of a window of states.

use crate::{method, nodal};
use onset::kinematics::DeformationGradient;
use onset::lattice::LatticeKind;
use onset::material::ModifiedMooneyRivlin;
use onset::measures::{StateWindow, fidelity};
use onset::method::{Frame, KernelMethodChoices};
use onset::quadrature::Quadrature;
use onset::verdict::{Survey, Verdict};

/// Window of states that are elliptic only in part.
const WINDOW: StateWindow = StateWindow {
    stretches: [0.7, 3.1],
    states: 6,
};

#[test]
fn fractions_agree_with_individually_counted_verdicts() {
    let material = ModifiedMooneyRivlin::default();
    for frame in [Frame::Lagrangian, Frame::Eulerian] {
        for quadrature in [Quadrature::Nodal, Quadrature::StressPoints] {
            let method = method::<2>(KernelMethodChoices {
                frame,
                quadrature,
                ..nodal(LatticeKind::Hexagonal)
            });
            let survey = Survey::new(&method, &material).expect("a survey");
            let found = fidelity(&survey, &WINDOW).expect("shares");
            let (mut falsely, mut missed, mut deficient, mut undefined, mut right) =
                (0.0, 0.0, 0.0, 0.0, 0.0);
            for i in 0..6 {
                for j in 0..6 {
                    let stretch = |n: i32| 0.7 + 2.4 * (f64::from(n) + 0.5) / 6.0;
                    let f = DeformationGradient::from_stretches([stretch(i), stretch(j), 1.0]);
                    match survey.state(&f.expect("a state")) {
                        Ok(state) => match (state.verdict, !state.acoustic.ellipticity().is_lost())
                        {
                            (Verdict::Numerical, true) => falsely += 1.0,
                            (Verdict::Suppressed, _) => missed += 1.0,
                            (Verdict::ZeroEnergy, _) => deficient += 1.0,
                            _ => right += 1.0,
                        },
                        Err(_) => undefined += 1.0,
                    }
                }
            }
            let close = |share: f64, count: f64| (share - count / 36.0).abs() < 1e-12;
            assert!(close(found.false_instability, falsely), "{found:?}");
            assert!(close(found.suppressed_instability, missed), "{found:?}");
            assert!(close(found.zero_energy, deficient), "{found:?}");
            assert!(close(found.undefined, undefined), "{found:?}");
            assert!(close(found.agreement(), right), "{found:?}");
            assert!(found.elliptic > 0.0 && found.elliptic < 1.0, "{found:?}");
        }
    }
}

#[test]
fn states_without_neighbors_are_undefined_for_the_method_but_not_for_the_law() {
    // An Eulerian kernel of fixed size loses its neighbors in tension.
    let method = method::<2>(KernelMethodChoices {
        frame: Frame::Eulerian,
        ..nodal(LatticeKind::Square)
    });
    let material = ModifiedMooneyRivlin::default();
    let survey = Survey::new(&method, &material).expect("a survey");
    let window = StateWindow {
        stretches: [2.2, 3.0],
        states: 2,
    };
    let found = fidelity(&survey, &window).expect("shares");
    assert_eq!(found.undefined, 1.0);
    assert_eq!(found.outside_law, 0.0);
    assert_eq!(found.agreement(), 0.0);
}
