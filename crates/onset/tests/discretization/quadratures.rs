//! Quadratures: their points and volumes, and their zero-energy waves.

use nalgebra::{Matrix2, SMatrix, Vector1, Vector2, vector};
use onset::approximation::Approximation;
use onset::bloch::{dynamical_matrix, gradient_norm};
use onset::certificate::{Certainty, Reason, certify};
use onset::kinematics::DeformationGradient;
use onset::lattice::{BravaisLattice, LatticeKind};
use onset::material::{Hyperelastic, ModifiedMooneyRivlin};
use onset::method::{Background, Frame, KernelMethodChoices, Method, MethodError};
use onset::quadrature::{Quadrature, QuadratureError, gauss_points, own_points, second_moments};

fn method(kind: LatticeKind, quadrature: Quadrature) -> KernelMethodChoices {
    KernelMethodChoices {
        lattice: kind,
        quadrature,
        support: 2.2,
        ..KernelMethodChoices::default()
    }
}

fn error_of(discretization: KernelMethodChoices) -> MethodError {
    Method::<2>::new(discretization).expect_err("not admissible")
}

/// Gauss rules integrate monomials in lattice coordinates exactly up to the degree `2 n - 1`, but not of degree `2 n`.
#[test]
fn gauss_points_integrate_polynomials_up_to_their_degree() {
    let vectors = SMatrix::<f64, 3, 3>::new(1.0, 0.3, 0.2, 0.0, 0.9, -0.4, 0.1, 0.0, 1.2);
    let lattice = BravaisLattice::new(vectors).expect("a lattice");
    for n in 1..=4_u32 {
        let points = gauss_points(&lattice, n).expect("a rule");
        assert_eq!(points.len(), n.pow(3) as usize);
        for (degree, is_exact) in [(2 * n - 1, true), (2 * n, false)] {
            let degree = degree as i32;
            let sum: f64 = points
                .iter()
                .map(|p| p.volume * p.place[0].powi(degree) * p.place[1].powi(degree) * p.place[2])
                .sum();
            let exact = lattice.cell_volume() / f64::from((degree + 1) * (degree + 1) * 2);
            assert_eq!(
                (sum / exact - 1.0).abs() < 1e-13,
                is_exact,
                "{n} points, degree {degree}"
            );
        }
    }
    let error = gauss_points(&lattice, 5).expect_err("no such rule");
    assert_eq!(error, QuadratureError::GaussPoints { value: 5, most: 4 });
}

#[test]
fn volumes_of_every_quadrature_add_up_to_the_cell() {
    for quadrature in Quadrature::ALL {
        for kind in [LatticeKind::Square, LatticeKind::Hexagonal] {
            let discretization = KernelMethodChoices {
                spacing: 1.7,
                points: vec![0.0, 0.0, 0.25, 0.3, 0.55, 0.75],
                ..method(kind, quadrature)
            };
            let method = Method::<2>::new(discretization).expect("a method");
            let sum: f64 = method.quadrature_points().iter().map(|p| p.volume).sum();
            assert!((sum / method.lattice().cell_volume() - 1.0).abs() < 1e-14);
        }
    }
}

#[test]
fn the_stress_point_weight_is_their_fraction_of_the_volume() {
    let of = |weight| KernelMethodChoices {
        stress_point_weight: weight,
        ..method(LatticeKind::Hexagonal, Quadrature::StressPoints)
    };
    let weighted = Method::<2>::new(of(Some(0.3))).expect("a method");
    let part: f64 = weighted
        .quadrature_points()
        .iter()
        .filter(|point| !point.is_node)
        .map(|point| point.volume)
        .sum();
    assert!((part / weighted.lattice().cell_volume() - 0.3).abs() < 1e-14);
    // Two of three Voronoi cells belong to stress points.
    let matrix = |weight| {
        let method = Method::<2>::new(of(weight)).expect("a method");
        dynamical_matrix(&method, &ModifiedMooneyRivlin::default(), &state())
            .expect("finite")
            .at(&vector![2.0, 1.1])
    };
    let difference = matrix(Some(2.0 / 3.0)) - matrix(None);
    assert!(difference.iter().all(|entry| entry.norm() < 1e-13));
    for value in [0.0, 1.0, -0.2, f64::NAN] {
        let error = error_of(of(Some(value)));
        assert!(matches!(
            error,
            MethodError::Quadrature(QuadratureError::StressPointWeight { .. })
        ));
    }
}

#[test]
fn lists_of_points_that_are_not_a_quadrature_are_rejected() {
    let lattice = LatticeKind::Square.lattice::<2>(1.0).expect("a lattice");
    let error = |list: &[f64]| own_points(&lattice, list).expect_err("not admissible");
    assert!(matches!(
        error(&[]),
        QuadratureError::PointsLength {
            length: 0,
            each: 3,
            ..
        }
    ));
    assert!(matches!(
        error(&[0.0, 0.0]),
        QuadratureError::PointsLength { length: 2, .. }
    ));
    assert_eq!(
        error(&[0.0, 0.0, 0.5, 0.5, 0.5, 0.4]),
        QuadratureError::PointsSum { sum: 0.9 }
    );
    assert!(matches!(
        error(&[0.0, 0.0, 1.2, 0.5, 0.5, -0.2]),
        QuadratureError::PointsValue {
            number: 2,
            what: "weight",
            ..
        }
    ));
    assert!(matches!(
        error(&[f64::NAN, 0.0, 1.0]),
        QuadratureError::PointsValue {
            number: 1,
            what: "coordinate",
            ..
        }
    ));
}

#[test]
fn user_defined_points_can_reproduce_a_named_quadrature() {
    let named = method(LatticeKind::Square, Quadrature::StressPoints);
    let own = KernelMethodChoices {
        quadrature: Quadrature::Points,
        points: vec![1.0, -3.0, 0.5, 2.5, 0.5, 0.5],
        ..named.clone()
    };
    for frame in [Frame::Lagrangian, Frame::Eulerian] {
        let [a, b] = [&named, &own].map(|choices| {
            let method = Method::<2>::new(KernelMethodChoices {
                frame,
                ..choices.clone()
            })
            .expect("a method");
            dynamical_matrix(&method, &ModifiedMooneyRivlin::default(), &state())
                .expect("finite")
                .at(&vector![2.0, 1.1])
        });
        assert!((a - b).iter().all(|entry| entry.norm() < 1e-12));
    }
}

fn state() -> DeformationGradient {
    DeformationGradient::plane_strain([[1.1, 0.2], [-0.1, 0.95]], 1.0).expect("a state")
}

/// Waves at half of a reciprocal vector, whose gradients vanish at the particles.
fn halves(method: &Method<2>) -> Vec<Vector2<f64>> {
    let b = method.lattice().reciprocal();
    let of = |x: f64, y: f64| b * vector![x, y];
    vec![of(0.5, 0.0), of(0.0, 0.5), of(0.5, 0.5)]
}

#[test]
fn natural_stabilization_and_gauss_points_remove_the_zero_energy_modes_of_nodal_integration() {
    for kind in [LatticeKind::Square, LatticeKind::Hexagonal] {
        for approximation in Approximation::ALL {
            let norms = |quadrature| -> Vec<f64> {
                let method = Method::<2>::new(KernelMethodChoices {
                    approximation,
                    support: 3.2,
                    ..method(kind, quadrature)
                })
                .expect("a method");
                let norm =
                    gradient_norm(&method, &DeformationGradient::identity()).expect("a norm");
                halves(&method)
                    .iter()
                    .map(|k| norm.at(k)[(0, 0)].re)
                    .collect()
            };
            assert!(
                norms(Quadrature::Nodal)
                    .iter()
                    .all(|norm| norm.abs() < 1e-12),
                "{approximation:?}"
            );
            for quadrature in [Quadrature::NodalStabilized, Quadrature::Gauss] {
                let lifted = norms(quadrature);
                // The norms are small for wide supports, but far above rounding errors.
                assert!(
                    lifted.iter().all(|norm| *norm > 1e-7),
                    "{kind:?}, {approximation:?}, {quadrature:?}: {lifted:?}"
                );
            }
        }
    }
}

/// Chain in closed form: `B = 0` and `B_,X = sum_K phi_K'' (-1)^K` for the wave of two spacings.
#[test]
fn the_stabilized_chain_agrees_with_its_closed_form() {
    let chain = Method::<1>::new(KernelMethodChoices {
        support: 1.5,
        ..method(LatticeKind::Chain, Quadrature::NodalStabilized)
    })
    .expect("a chain");
    // Shepard's function of neighbors at 0 and +-1: phi_0 = W(x) / S, with S' = 0 at x = 0.
    let q = 1.0 / 1.5;
    let w = |q: f64| (1.0 - q).powi(3) * (1.0 + 3.0 * q);
    let curvature = |q: f64| (-12.0 + 48.0 * q - 36.0 * q * q) / (1.5 * 1.5);
    let slope = -12.0 * q * (1.0 - q) * (1.0 - q) / 1.5;
    let sum = w(0.0) + 2.0 * w(q);
    let sum2 = curvature(0.0) + 2.0 * curvature(q);
    let phi2 = |q: f64| curvature(q) / sum - w(q) * sum2 / (sum * sum);
    // S' = 0 at the particle, so that the slopes do not contribute.
    assert!(slope < 0.0);
    let expected = (phi2(0.0) - 2.0 * phi2(q)).powi(2) / 12.0;
    let norm = gradient_norm(&chain, &DeformationGradient::identity()).expect("a norm");
    let computed = norm.at(&Vector1::new(std::f64::consts::PI))[(0, 0)].re;
    assert!(
        (computed / expected - 1.0).abs() < 1e-12,
        "{computed} against {expected}"
    );
    let at = second_moments(chain.lattice())[(0, 0)];
    assert!((at - 1.0 / 12.0).abs() < 1e-15);
}

/// If gradients of linear fields are exact, the homogeneous state is consistent, and long waves have the acoustic tensor of the material.
/// Stabilization and every quadrature preserve this.
#[test]
fn long_waves_of_consistent_methods_agree_with_the_material() {
    let material = ModifiedMooneyRivlin::default();
    let tangent = material.response(&state()).expect("finite").tangent;
    for approximation in Approximation::ALL {
        for quadrature in Quadrature::ALL {
            let method = Method::<2>::new(KernelMethodChoices {
                approximation,
                support: 3.2,
                points: vec![0.0, 0.0, 0.25, 0.3, 0.55, 0.75],
                background: Background::Interpolated,
                ..method(LatticeKind::Hexagonal, quadrature)
            });
            let is_without_symmetry = matches!(quadrature, Quadrature::Gauss | Quadrature::Points);
            if approximation == Approximation::Raw && is_without_symmetry {
                // A translation strains such points, and the state F X is not homogeneous.
                let error = method.expect_err("no homogeneous state");
                assert!(matches!(error, MethodError::Incompatible { .. }), "{error}");
                continue;
            }
            let method = method.expect("a method");
            let matrix = dynamical_matrix(&method, &material, &state()).expect("finite");
            let n = vector![0.6, 0.8];
            let acoustic = matrix.long_wave_stiffness().acoustic_tensor(&n);
            let exact = Matrix2::from_fn(|i, k| {
                (0..4)
                    .map(|m| tangent[(i, m / 2, k, m % 2)] * n[m / 2] * n[m % 2])
                    .sum()
            });
            let error = (acoustic - exact).amax() / exact.amax();
            match approximation.degree_of_gradients() {
                Some(1..) => assert!(error < 1e-9, "{approximation:?}, {quadrature:?}: {error:e}"),
                _ => assert!(
                    error > 1e-9,
                    "{approximation:?}, {quadrature:?} promise nothing: {error:e}"
                ),
            }
        }
    }
}

#[test]
fn gradients_exact_for_linear_fields_have_the_identity_as_moment() {
    use onset::approximation::Order;
    for approximation in Approximation::ALL {
        for frame in [Frame::Lagrangian, Frame::Eulerian] {
            let method = Method::<2>::new(KernelMethodChoices {
                approximation,
                frame,
                support: 3.2,
                background: Background::Interpolated,
                ..method(LatticeKind::Hexagonal, Quadrature::StressPoints)
            })
            .expect("a method");
            let configuration = method
                .configuration(&state(), Order::First)
                .expect("a configuration");
            let strayed = configuration
                .points
                .iter()
                .map(|point| (point.deformation.leading::<2>() - state().leading::<2>()).amax());
            let strayed = strayed.fold(0.0, f64::max);
            match approximation.degree_of_gradients() {
                Some(1..) => assert!(strayed < 1e-12, "{approximation:?}, {frame:?}: {strayed:e}"),
                _ => assert!(strayed > 1e-9, "{approximation:?}, {frame:?}: {strayed:e}"),
            }
        }
    }
}

#[test]
fn natural_stabilization_is_rejected_for_eulerian_kernels() {
    let error = error_of(KernelMethodChoices {
        frame: Frame::Eulerian,
        ..method(LatticeKind::Square, Quadrature::NodalStabilized)
    });
    assert_eq!(error, MethodError::StabilizedEulerian);
}

#[test]
fn certificates_prove_nothing_for_functions_and_points_without_enclosures() {
    let material = ModifiedMooneyRivlin::default();
    let f = DeformationGradient::from_stretches([1.05, 1.0, 1.0]).expect("a state");
    for (approximation, quadrature) in [
        (Approximation::Mls2, Quadrature::StressPoints),
        (Approximation::KrongauzBelytschko, Quadrature::StressPoints),
        (Approximation::RandlesLibersky, Quadrature::Gauss),
        (Approximation::Shepard, Quadrature::NodalStabilized),
    ] {
        let method = Method::<2>::new(KernelMethodChoices {
            approximation,
            ..method(LatticeKind::Hexagonal, quadrature)
        })
        .expect("a method");
        let certificate = certify(&method, &material, &f, 1e-3).expect("a state");
        assert!(
            matches!(
                certificate.discretization,
                Certainty::Undecided {
                    reason: Reason::Method,
                    ..
                }
            ),
            "{approximation:?}, {quadrature:?}: {certificate:?}"
        );
    }
}

#[test]
fn a_quadratic_basis_needs_more_neighbors() {
    let error = Method::<2>::new(KernelMethodChoices {
        approximation: Approximation::Mls2,
        support: 1.2,
        ..method(LatticeKind::Square, Quadrature::Nodal)
    })
    .expect("a method")
    .configuration(
        &DeformationGradient::identity(),
        onset::approximation::Order::First,
    )
    .expect_err("five neighbors are too few");
    assert!(
        matches!(
            error,
            MethodError::SupportTooSmall {
                neighbors: 5,
                needed: 6,
                ..
            }
        ),
        "{error}"
    );
}

/// For `u_K = (F - 1) (X_K - X_0)` the interpolated background `F_q = 1 + sum_K u_K (x) grad phi_K(X_q)` does not depend on the origin `X_0`.
#[test]
fn an_interpolated_background_does_not_depend_on_the_origin_of_displacements() {
    use onset::approximation::Order;
    for approximation in Approximation::ALL {
        for quadrature in Quadrature::ALL {
            for kind in [LatticeKind::Hexagonal, LatticeKind::Oblique] {
                let Ok(method) = Method::<2>::new(KernelMethodChoices {
                    approximation,
                    support: 3.2,
                    points: vec![0.0, 0.0, 0.25, 0.3, 0.55, 0.75],
                    vectors: vec![1.0, 0.1, 0.3, 0.9],
                    background: Background::Interpolated,
                    ..method(kind, quadrature)
                }) else {
                    // Only raw weights are rejected, because they are not exact for constants.
                    assert_eq!(approximation, Approximation::Raw, "{quadrature:?}");
                    continue;
                };
                let configuration = method
                    .configuration(&state(), Order::First)
                    .expect("a configuration");
                let gradient = state().leading::<2>() - Matrix2::identity();
                for point in &configuration.points {
                    for origin in [vector![0.0, 0.0], vector![2.3, -1.7]] {
                        let seen: Matrix2<f64> = point
                            .cells
                            .iter()
                            .zip(&point.shape.gradients)
                            .map(|(cell, slope)| {
                                let place = vector![f64::from(cell[0]), f64::from(cell[1])];
                                let x = method.lattice().vectors() * place - origin;
                                gradient * x * slope.transpose()
                            })
                            .sum();
                        let carried = point.deformation.leading::<2>();
                        let strayed = (Matrix2::identity() + seen - carried).amax();
                        assert!(
                            strayed < 1e-9,
                            "{approximation:?}, {quadrature:?}: {strayed:e}"
                        );
                    }
                }
            }
        }
    }
}
