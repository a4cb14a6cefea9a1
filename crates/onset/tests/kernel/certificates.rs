//! Complete methods with every kernel: proofs agree with searches.

use super::kernels;
use onset::bloch::Stability;
use onset::certificate::{Certainty, certify};
use onset::kernel::Kernel;
use onset::kinematics::DeformationGradient;
use onset::material::ModifiedMooneyRivlin;
use onset::method::{CurrentLattice, Frame, KernelMethodChoices, Method};
use onset::verdict::judge;

fn stretched(first: f64, second: f64) -> DeformationGradient {
    DeformationGradient::from_stretches([first, second, 1.0]).expect("a state")
}

#[test]
fn proofs_for_every_kernel_agree_with_the_search() {
    let material = ModifiedMooneyRivlin::default();
    let mut decided = 0;
    for kernel in kernels() {
        for (frame, first, second) in [
            (Frame::Lagrangian, 1.1, 0.95),
            (Frame::Eulerian, 0.9, 0.93),
            (Frame::Eulerian, 1.3, 1.2),
        ] {
            let method = Method::<2>::new(KernelMethodChoices {
                kernel,
                frame,
                current_lattice: CurrentLattice::Regular,
                support: 1.8,
                ..KernelMethodChoices::default()
            })
            .expect("a method");
            let f = stretched(first, second);
            let proved = certify(&method, &material, &f, 1e-3).expect("a state");
            let (_, stability) = judge(&method, &material, &f).expect("a state");
            let is_stable = stability == Stability::Stable;
            match proved.discretization {
                Certainty::Stable { .. } => assert!(is_stable, "{kernel} {frame:?}"),
                Certainty::Unstable { .. } => assert!(!is_stable, "{kernel} {frame:?}"),
                _ => continue,
            }
            decided += 1;
        }
    }
    assert!(decided >= 35, "{decided} of 45");
}

#[test]
fn no_proof_is_given_where_the_matrix_jumps() {
    // With a support of two spacings six particles lie on the rim, where the curvature of the kernel is 8 inside and zero outside.
    let proved_at = |kernel: Kernel, support: f64| {
        let method = Method::<2>::new(KernelMethodChoices {
            kernel,
            frame: Frame::Eulerian,
            current_lattice: CurrentLattice::Regular,
            support,
            ..KernelMethodChoices::default()
        })
        .expect("a method");
        let material = ModifiedMooneyRivlin::default();
        let proved = certify(&method, &material, &stretched(0.9, 0.93), 1e-3);
        proved.expect("a state").discretization.name()
    };
    let jumping = "(1 - q^2)^2".parse().expect("a kernel");
    let proved = [1.99, 2.0, 2.01].map(|support| proved_at(jumping, support));
    assert_eq!(proved, ["proved-unstable", "undecided", "proved-unstable"]);
    let smooth = [1.99, 2.0, 2.01].map(|support| proved_at(Kernel::QuarticSpline, support));
    assert_eq!(smooth, ["proved-unstable"; 3]);
}
