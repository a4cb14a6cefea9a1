//! Invalid input gives errors with a reason; no state and no setting causes a panic.

use nalgebra::{SMatrix, SVector, Vector2};
use onset::approximation::{Approximation, Order};
use onset::bloch::dynamical_matrix;
use onset::kernel::Kernel;
use onset::kinematics::DeformationGradient;
use onset::lattice::{LatticeError, LatticeKind};
use onset::material::{BlatzKo, Hyperelastic, ModifiedMooneyRivlin};
use onset::method::{
    Background, CurrentLattice, Frame, KernelMethodChoices, Linearization, Method, MethodError,
    SupportSize,
};
use onset::quadrature::Quadrature;
use onset::verdict::assess;

fn identity() -> DeformationGradient {
    DeformationGradient::identity()
}

fn evaluated(
    discretization: KernelMethodChoices,
    f: &DeformationGradient,
) -> Result<(), MethodError> {
    Method::<2>::new(discretization)?
        .configuration(f, Order::First)
        .map(|_| ())
}

#[test]
fn a_support_without_neighbors_is_too_small() {
    let discretization = KernelMethodChoices {
        support: 0.9,
        quadrature: Quadrature::Nodal,
        ..KernelMethodChoices::default()
    };
    let error = MethodError::SupportTooSmall {
        point: "particle",
        radius: 0.9,
        neighbors: 1,
        needed: 3,
        dimension: 2,
    };
    assert_eq!(evaluated(discretization, &identity()), Err(error));
}

#[test]
fn a_support_that_holds_thousands_of_particles_is_too_large() {
    let discretization = KernelMethodChoices {
        support: 500.0,
        ..KernelMethodChoices::default()
    };
    let Err(MethodError::SupportTooLarge {
        radius,
        neighbors,
        limit,
    }) = evaluated(discretization, &identity())
    else {
        panic!("a support of 500 spacings is admitted");
    };
    assert_eq!((radius, limit), (500.0, onset::method::MAXIMUM_NEIGHBORS));
    // The expected number is pi R0^2 / V0.
    assert!(
        (neighbors - std::f64::consts::PI * 250_000.0 / 0.75_f64.sqrt()).abs() < 1e-6 * neighbors
    );
    // If the lattice is compressed to a line, any support holds too many particles.
    let crushed = DeformationGradient::from_stretches([1e-6, 1.0, 1.0]).expect("a state");
    let eulerian = KernelMethodChoices {
        frame: Frame::Eulerian,
        ..KernelMethodChoices::default()
    };
    assert!(matches!(
        evaluated(eulerian, &crushed),
        Err(MethodError::SupportTooLarge { .. })
    ));
}

#[test]
fn neighbors_in_a_line_do_not_determine_a_linear_basis() {
    // After a stretch across the rows only the particles of one row remain within the fixed support.
    let apart = DeformationGradient::from_stretches([1.0, 3.0, 1.0]).expect("a state");
    let discretization = KernelMethodChoices {
        lattice: LatticeKind::Square,
        frame: Frame::Eulerian,
        approximation: Approximation::Mls,
        quadrature: Quadrature::Nodal,
        support: 1.6,
        ..KernelMethodChoices::default()
    };
    let error = evaluated(discretization, &apart);
    assert!(
        matches!(
            error,
            Err(MethodError::SingularMoment {
                point: "particle",
                neighbors: 3,
                ..
            })
        ),
        "{error:?}"
    );
    // The shape functions report this error directly, too.
    let positions: Vec<Vector2<f64>> = (-1..=1).map(|n| Vector2::new(f64::from(n), 0.0)).collect();
    let weights: Vec<_> = positions
        .iter()
        .map(|x| {
            Kernel::QuarticSpline
                .weight(x, 1.6, &SMatrix::identity())
                .expect("inside")
        })
        .collect();
    let singular = Approximation::Mls.shape_functions(&positions, &weights, 1.0, 1.6, Order::First);
    assert!(singular.is_err_and(|error| error.condition > 1e12));
    assert!(
        Approximation::Shepard
            .shape_functions(&positions, &weights, 1.0, 1.6, Order::First)
            .is_ok()
    );
}

#[test]
fn settings_that_are_not_positive_are_rejected_by_name() {
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        for (setting, discretization) in [
            (
                "spacing",
                KernelMethodChoices {
                    spacing: bad,
                    ..KernelMethodChoices::default()
                },
            ),
            (
                "density",
                KernelMethodChoices {
                    density: bad,
                    ..KernelMethodChoices::default()
                },
            ),
            (
                "support",
                KernelMethodChoices {
                    support: bad,
                    ..KernelMethodChoices::default()
                },
            ),
        ] {
            let error = Method::<2>::new(discretization).map(|_| ());
            assert!(
                matches!(error, Err(MethodError::Setting { name, .. }) if name == setting),
                "{error:?}"
            );
        }
    }
    for spacing in [-1.0, 0.0, f64::NAN, 1e200, 1e-200] {
        let refused = LatticeKind::Square.lattice::<2>(spacing);
        assert!(
            matches!(refused, Err(LatticeError::Spacing { .. })),
            "{spacing:e}"
        );
    }
}

#[test]
fn lattices_are_rejected_in_other_dimensions() {
    let chain = KernelMethodChoices {
        lattice: LatticeKind::Chain,
        ..KernelMethodChoices::default()
    };
    let error = MethodError::Lattice(LatticeError::Dimension {
        lattice: "chain",
        actual: 1,
        requested: 2,
    });
    assert_eq!(Method::<2>::new(chain).map(|_| ()), Err(error));
    let square = KernelMethodChoices {
        lattice: LatticeKind::Square,
        ..KernelMethodChoices::default()
    };
    assert!(Method::<1>::new(square.clone()).is_err());
    assert!(Method::<3>::new(square).is_err());
}

#[test]
fn states_that_couple_the_plane_to_its_normal_are_rejected() {
    let sheared = DeformationGradient::new([[1.0, 0.0, 0.2], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
        .expect("a state");
    assert_eq!(
        evaluated(KernelMethodChoices::default(), &sheared),
        Err(MethodError::NotPlanar { dimension: 2 })
    );
    let chain = KernelMethodChoices {
        lattice: LatticeKind::Chain,
        ..KernelMethodChoices::default()
    };
    let planar = DeformationGradient::plane_strain([[1.0, 0.1], [0.0, 1.0]], 1.0).expect("a state");
    let refused = Method::<1>::new(chain)
        .expect("a chain")
        .configuration(&planar, Order::First);
    assert!(matches!(
        refused,
        Err(MethodError::NotPlanar { dimension: 1 })
    ));
}

/// Checks only that every call returns a finite result or an error.
#[test]
fn no_method_panics_for_stretches_of_any_magnitude() {
    let current = [
        (
            CurrentLattice::Convected,
            Background::Interpolated,
            Linearization::Exact,
        ),
        (
            CurrentLattice::Regular,
            Background::Imposed,
            Linearization::Paper,
        ),
    ];
    let sizes = [
        SupportSize::Fixed,
        SupportSize::Scaled,
        SupportSize::Convected,
    ];
    let evaluated: usize = std::thread::scope(|scope| {
        let mut running = Vec::new();
        let lagrangian = KernelMethodChoices {
            frame: Frame::Lagrangian,
            support: 1.6,
            ..KernelMethodChoices::default()
        };
        // The other choices apply only to Eulerian kernels.
        for support_size in sizes {
            for (current_lattice, background, linearization) in current {
                let eulerian = KernelMethodChoices {
                    frame: Frame::Eulerian,
                    support_size,
                    current_lattice,
                    background,
                    linearization,
                    ..lagrangian.clone()
                };
                running.push(scope.spawn(move || evaluated_at_all_magnitudes(eulerian)));
            }
        }
        running.push(scope.spawn(move || evaluated_at_all_magnitudes(lagrangian)));
        let count = |own: std::thread::ScopedJoinHandle<'_, usize>| own.join().expect("no panic");
        running.into_iter().map(count).sum()
    });
    assert!(
        evaluated > 100,
        "only {evaluated} states could be evaluated"
    );
}

/// Number of states, over all magnitudes, at which a method can be assessed.
fn evaluated_at_all_magnitudes(choices: KernelMethodChoices) -> usize {
    let materials: [Box<dyn Hyperelastic>; 2] = [
        Box::new(ModifiedMooneyRivlin::default()),
        Box::new(BlatzKo::default()),
    ];
    let method = Method::<2>::new(choices).expect("a method");
    let mut evaluated = 0;
    for exponent in (-300..=300).step_by(20).chain([-3, -1, 1, 3]) {
        let stretch = 10.0_f64.powi(exponent);
        for stretches in [
            [stretch, 1.0, 1.0],
            [stretch, stretch, 1.0],
            [stretch, stretch.recip(), 1.0],
        ] {
            let Ok(f) = DeformationGradient::from_stretches(stretches) else {
                continue;
            };
            for material in &materials {
                if let Ok(d) = dynamical_matrix(&method, &**material, &f) {
                    assert!(d.is_finite());
                }
                if exponent.abs() <= 20
                    && let Ok(assessment) = assess(&method, &**material, &f)
                {
                    assert!(
                        !assessment.spectrum.softest.scaled.is_nan(),
                        "{stretches:?}"
                    );
                    evaluated += 1;
                }
            }
        }
    }
    evaluated
}

#[test]
fn weights_vanish_at_the_rim_and_beyond() {
    let at = |distance: f64| {
        let x = SVector::<f64, 2>::new(distance, 0.0);
        Kernel::QuarticSpline.weight(&x, 2.0, &SMatrix::identity())
    };
    assert!(at(2.0).is_none() && at(2.1).is_none());
    let weight = at(2.0 - 1e-6).expect("inside");
    assert!(weight.value < 1e-17 && weight.gradient.norm() < 1e-11 && weight.hessian.amax() < 1e-4);
}
