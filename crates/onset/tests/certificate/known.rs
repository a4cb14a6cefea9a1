//! States with a known result.

use nalgebra::Vector2;
use onset::bloch::{Stability, dynamical_matrix, growth_rate};
use onset::certificate::{Certainty, Certifier, GROWTH, Reason, certify};
use onset::kinematics::DeformationGradient;
use onset::lattice::LatticeKind;
use onset::material::{BlatzKo, Hyperelastic, ModifiedMooneyRivlin};
use onset::method::{
    CurrentLattice, Frame, KernelMethodChoices, Linearization, Method, MethodError,
};
use onset::quadrature::{Quadrature, QuadraturePoint};
use onset::verdict::{judge, speed_squared};

fn stretched(first: f64, second: f64) -> DeformationGradient {
    DeformationGradient::from_stretches([first, second, 1.0]).expect("a state")
}

fn planar(discretization: KernelMethodChoices) -> Method<2> {
    Method::new(discretization).expect("a method")
}

/// Eulerian kernels on the regular lattice.
fn eulerian(support: f64, linearization: Linearization) -> KernelMethodChoices {
    KernelMethodChoices {
        frame: Frame::Eulerian,
        current_lattice: CurrentLattice::Regular,
        linearization,
        support,
        ..KernelMethodChoices::default()
    }
}

/// Stretch along (1, s) at which the law (5) loses ellipticity.
const ONSET: f64 = 2.754613297216;

#[test]
fn ellipticity_is_proved_or_refuted_within_a_millionth_of_its_limit() {
    let material = ModifiedMooneyRivlin::default();
    let lagrangian = planar(KernelMethodChoices::default());
    for distance in [1e-6, 1e-9] {
        let before = certify(
            &lagrangian,
            &material,
            &stretched(1.0, ONSET - distance),
            1e-12,
        )
        .expect("a state");
        let after = certify(
            &lagrangian,
            &material,
            &stretched(1.0, ONSET + distance),
            1e-12,
        )
        .expect("a state");
        assert_eq!(
            before.material.name(),
            "proved-stable",
            "{distance:e} before"
        );
        assert_eq!(
            before.discretization.name(),
            "proved-stable",
            "{distance:e} before"
        );
        assert_eq!(
            after.material.name(),
            "proved-unstable",
            "{distance:e} after"
        );
    }
    let after =
        certify(&lagrangian, &material, &stretched(1.0, ONSET + 1e-6), 1e-12).expect("a state");
    let Certainty::Unstable { witness } = after.material else {
        panic!("the witness is a direction");
    };
    assert!(witness.measure.high < 0.0 && witness.growth_rate > 0.0);
    assert!(
        witness.wave_vector[1].abs() < 1e-3,
        "the wave runs across the stretch: {:?}",
        witness.wave_vector
    );
}

#[test]
fn blatz_ko_is_proved_or_refuted_on_both_sides_of_the_knowles_sternberg_ratio() {
    let (material, method) = (BlatzKo::default(), planar(KernelMethodChoices::default()));
    let ratio = 2.0 + 3.0_f64.sqrt();
    for (factor, name) in [
        (1.0 - 1e-9, "proved-stable"),
        (1.0 + 1e-9, "proved-unstable"),
    ] {
        let state = stretched(0.8, 0.8 * ratio * factor);
        assert_eq!(
            certify(&method, &material, &state, 0.0)
                .expect("a state")
                .material
                .name(),
            name
        );
    }
}

#[test]
fn the_proved_bound_is_just_below_the_smallest_acoustic_eigenvalue() {
    let material = ModifiedMooneyRivlin::default();
    let method = planar(KernelMethodChoices::default());
    // In compression the softest wave is a shear wave of stiffness c1 + c2.
    let scale = speed_squared(&method, &material).expect("finite");
    let certificate = certify(&method, &material, &stretched(0.8, 0.7), 0.0).expect("a state");
    let Certainty::Stable { bound } = certificate.material else {
        panic!("the state is elliptic");
    };
    let exact = (0.1256 + 0.01012) / scale;
    assert!(bound < exact && bound > 0.99 * exact, "{bound} of {exact}");
}

#[test]
fn one_dimensional_chains_are_proved_or_refuted() {
    let material = ModifiedMooneyRivlin::default();
    let chain = |frame, quadrature| {
        let discretization = KernelMethodChoices {
            lattice: LatticeKind::Chain,
            frame,
            quadrature,
            ..KernelMethodChoices::default()
        };
        Method::<1>::new(discretization).expect("a method")
    };
    let name = |method: &Method<1>, stretch: f64| {
        let state = DeformationGradient::from_stretches([stretch, 1.0, 1.0]).expect("a state");
        certify(method, &material, &state, 1e-6)
            .expect("a state")
            .discretization
            .name()
    };
    let lagrangian = chain(Frame::Lagrangian, Quadrature::StressPoints);
    assert_eq!(name(&lagrangian, 1.3), "proved-stable");
    let nodal = chain(Frame::Lagrangian, Quadrature::Nodal);
    assert_eq!(name(&nodal, 1.3), "proved-zero-energy");
    // Eulerian kernels: stable in one case and unstable in the other, as in the floating-point search.
    let mut seen = [0, 0];
    for quadrature in [Quadrature::Nodal, Quadrature::StressPoints] {
        let eulerian = chain(Frame::Eulerian, quadrature);
        for step in 0..40 {
            let stretch = 0.6 + 0.03 * f64::from(step);
            let state = DeformationGradient::from_stretches([stretch, 1.0, 1.0]).expect("a state");
            let Ok((_, stability)) = judge(&eulerian, &material, &state) else {
                continue;
            };
            match name(&eulerian, stretch) {
                "proved-stable" => {
                    assert_eq!(stability, Stability::Stable);
                    seen[0] += 1;
                }
                "proved-unstable" => {
                    assert_ne!(stability, Stability::Stable);
                    seen[1] += 1;
                }
                _ => {}
            }
        }
    }
    assert!(seen[0] > 5 && seen[1] > 5, "{seen:?} states are proved");
}

#[test]
fn nodal_integration_of_a_lagrangian_kernel_has_exactly_the_known_zero_energy_modes() {
    let material = ModifiedMooneyRivlin::default();
    for kind in [LatticeKind::Square, LatticeKind::Hexagonal] {
        let discretization = KernelMethodChoices {
            lattice: kind,
            quadrature: Quadrature::Nodal,
            ..KernelMethodChoices::default()
        };
        let method = planar(discretization);
        let state = stretched(1.1, 0.9);
        let certificate = certify(&method, &material, &state, 1e-3).expect("a state");
        let Certainty::ZeroEnergy { wave_vector } = certificate.discretization else {
            panic!("{:?} of {kind:?}", certificate.discretization);
        };
        let matrix = dynamical_matrix(&method, &material, &state).expect("finite");
        let scale = matrix.omega_squared(&Vector2::new(1.0, 0.3))[1].re;
        assert!(matrix.omega_squared(&wave_vector)[1].re.abs() < 1e-12 * scale);
    }
    // The wave (pi, pi) has no strain at square centers either; every wave has strain at the centroids of triangles.
    for (kind, name) in [
        (LatticeKind::Square, "proved-zero-energy"),
        (LatticeKind::Hexagonal, "proved-stable"),
    ] {
        let method = planar(KernelMethodChoices {
            lattice: kind,
            ..KernelMethodChoices::default()
        });
        let certificate = certify(&method, &material, &stretched(1.1, 0.9), 1e-3).expect("a state");
        assert_eq!(certificate.discretization.name(), name, "{kind:?}");
    }
}

#[test]
fn the_cover_finds_flutter_that_a_grid_misses() {
    // Pockets of complex omega^2 near the boundary of the zone, smaller than the spacing of a typical grid.
    let material = ModifiedMooneyRivlin::default();
    for (support, first, second) in [
        (1.9, 0.5375, 1.8425),
        (1.9, 0.6725, 1.4825),
        (1.6, 1.7075, 0.5825),
    ] {
        let method = planar(eulerian(support, Linearization::Paper));
        let state = stretched(first, second);
        let certificate = certify(&method, &material, &state, 1e-3).expect("a state");
        let Certainty::Unstable { witness } = certificate.discretization else {
            panic!("{:?}", certificate.discretization);
        };
        // The floating-point matrix agrees for this wave.
        let matrix = dynamical_matrix(&method, &material, &state).expect("finite");
        let unit = speed_squared(&method, &material).expect("finite").sqrt();
        let growth = matrix
            .omega_squared(&witness.wave_vector)
            .map(growth_rate)
            .into_iter()
            .fold(0.0, f64::max)
            / unit;
        assert!(
            growth > GROWTH && growth >= witness.growth_rate * (1.0 - 1e-6),
            "{growth} of {witness:?}"
        );
        // A grid of 40 points along each reciprocal vector misses them.
        let zone = onset::lattice::BrillouinZone::new(*method.lattice());
        let mut grown = 0;
        for i in 0..40 {
            for j in 0..40 {
                let k = zone
                    .folded(&zone.wave_vector(&(Vector2::new(f64::from(i), f64::from(j)) / 40.0)));
                grown += usize::from(
                    matrix
                        .omega_squared(&k)
                        .iter()
                        .any(|w| growth_rate(*w) > GROWTH * unit),
                );
            }
        }
        assert_eq!(grown, 0, "the pocket lies between the points of the grid");
    }
}

#[test]
fn quadrature_points_without_inversion_symmetry_are_undecided() {
    let material = ModifiedMooneyRivlin::default();
    let method = planar(KernelMethodChoices {
        frame: Frame::Eulerian,
        ..KernelMethodChoices::default()
    });
    let volume = method.lattice().cell_volume();
    let place = Vector2::repeat(1.0 / 3.0);
    let method = method.with_quadrature_points(vec![QuadraturePoint::new(place, volume)]);
    let certificate = certify(&method, &material, &stretched(0.95, 0.95), 1e-3).expect("a state");
    let expected = matches!(
        certificate.discretization,
        Certainty::Undecided {
            reason: Reason::NoInversionCenter,
            ..
        }
    );
    assert!(expected, "{:?}", certificate.discretization);
}

#[test]
fn undecided_states_report_their_reason() {
    let material = ModifiedMooneyRivlin::default();
    let method = planar(eulerian(1.9, Linearization::Exact));
    let state = stretched(0.9, 0.95);
    let reason = |tolerance: f64| {
        let certifier = Certifier::new(&method, &material, tolerance)
            .expect("a method")
            .with_budget(0);
        match certifier.certify(&state).expect("a state").discretization {
            Certainty::Undecided { reason, measure } => (reason, measure),
            decided => panic!("no work, no proof: {decided:?}"),
        }
    };
    let (cut_short, measure) = reason(1e-9);
    assert!(measure > 1e-9 && matches!(cut_short, Reason::Budget | Reason::Growth));
    assert_eq!(reason(2.0 * measure).0, Reason::WithinTolerance);
    let full = certify(&method, &material, &state, 1e-9).expect("a state");
    assert_eq!(full.discretization.name(), "proved-stable");
}

#[test]
fn certificates_at_extreme_stretches_are_never_wrong() {
    let laws: [Box<dyn Hyperelastic>; 2] = [
        Box::new(ModifiedMooneyRivlin::default()),
        Box::new(BlatzKo::default()),
    ];
    let stretches = [1e-6, 1e-3, 0.05, 1.0, 20.0, 1e3, 1e6];
    let mut answered = 0;
    for law in &laws {
        for frame in [Frame::Lagrangian, Frame::Eulerian] {
            let method = planar(KernelMethodChoices {
                frame,
                ..KernelMethodChoices::default()
            });
            let certifier = Certifier::new(&method, &**law, 1e-3)
                .expect("a method")
                .with_budget(200);
            for first in stretches {
                for second in stretches {
                    // Along the axes, and rotated by an angle that makes the components cancel.
                    let (sine, cosine) = 0.7_f64.sin_cos();
                    let turned = [
                        [first * cosine, -second * sine],
                        [first * sine * (1.0 + 1e-13), second * cosine],
                    ];
                    let turned = DeformationGradient::plane_strain(turned, 1.0);
                    for state in [Ok(stretched(first, second)), turned].into_iter().flatten() {
                        match certifier.certify(&state) {
                            Ok(_) => answered += 1,
                            Err(error) => assert!(
                                error.is_about_support()
                                    || matches!(
                                        error,
                                        MethodError::Material(_) | MethodError::NotFinite
                                    ),
                                "{error}"
                            ),
                        }
                    }
                }
            }
        }
    }
    assert!(answered > 100, "{answered} states have an answer");
}
