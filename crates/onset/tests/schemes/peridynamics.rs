//! Peridynamics: closed forms of bonds and families, and the response of its models to a material.

use crate::battery::{assert_long_waves_are_those_of_the_material, assert_scheme};
use crate::random::Random;
use crate::states::saint_venant_kirchhoff;
use nalgebra::{SMatrix, SVector};
use onset::bloch::WaveSystem;
use onset::continuum::Stiffness;
use onset::kinematics::DeformationGradient;
use onset::lattice::{BravaisLattice, Crystal, LatticeKind};
use onset::material::{Hyperelastic, ModifiedMooneyRivlin};
use onset::measures::spurious_modes;
use onset::method::MethodError;
use onset::scheme::{
    BondForm, BondModel, Calibration, Discretization, Influence, PartialVolumes, Peridynamics,
    PeridynamicsChoices, ZeroEnergyControl,
};
use onset::verdict::{Survey, WEAK_WAVE_RATIO};
use std::f64::consts::PI;

const BONDS: BondModel = BondModel::BondBased {
    calibration: Calibration::Continuum,
};
const FORM_I: BondModel = BondModel::BondAssociated {
    form: BondForm::One,
};
const FORM_II: BondModel = BondModel::BondAssociated {
    form: BondForm::Two,
};
const CALIBRATED: BondModel = BondModel::BondBased {
    calibration: Calibration::Discrete,
};

fn correspondence(control: ZeroEnergyControl) -> BondModel {
    BondModel::Correspondence { control }
}

fn choices(horizon: f64, model: BondModel) -> PeridynamicsChoices {
    PeridynamicsChoices {
        horizon,
        model,
        ..PeridynamicsChoices::default()
    }
}

/// Chain, square and simple cubic lattices with unit spacing.
fn cubic<const D: usize>() -> Crystal<D> {
    Crystal::of_lattice(BravaisLattice::new(SMatrix::identity()).expect("a lattice"))
}

fn hexagonal() -> Crystal<2> {
    Crystal::of_lattice(LatticeKind::Hexagonal.lattice(1.0).expect("a lattice"))
}

fn body<const D: usize>(crystal: Crystal<D>, choices: PeridynamicsChoices) -> Peridynamics<D> {
    Peridynamics::new(crystal, choices).expect("a discretization")
}

fn state<const D: usize>() -> DeformationGradient {
    let stretched = |d: f64| DeformationGradient::from_stretches([d, 1.0, 1.0]);
    match D {
        1 => stretched(1.15),
        2 => DeformationGradient::plane_strain([[1.1, 0.15], [-0.05, 0.92]], 1.03),
        _ => DeformationGradient::new([[1.1, 0.1, 0.0], [-0.05, 0.95, 0.1], [0.02, 0.0, 1.04]]),
    }
    .expect("a state")
}

fn waves<const D: usize>(body: &Peridynamics<D>, f: &DeformationGradient) -> WaveSystem<D> {
    body.waves(&ModifiedMooneyRivlin::default(), f)
        .expect("an evaluable state")
}

/// Sum `A_iijj` over `D` dimensions in the reference state.
fn trace<const D: usize>() -> f64 {
    let rest = DeformationGradient::identity();
    let response = ModifiedMooneyRivlin::default()
        .response(&rest)
        .expect("a response");
    let entries = (0..D).flat_map(|i| (0..D).map(move |j| (i, i, j, j)));
    entries.map(|entry| response.tangent[entry]).sum()
}

fn half_reciprocal_vectors<const D: usize>(crystal: &Crystal<D>) -> Vec<SVector<f64, D>> {
    (1..1 << D)
        .map(|bits| {
            let half = SVector::from_fn(|i, _| 0.5 * f64::from((bits >> i) & 1));
            crystal.lattice().reciprocal() * half
        })
        .collect()
}

#[test]
fn every_model_passes_the_scheme_checks_in_every_dimension() {
    let penalty = ZeroEnergyControl::Penalty { coefficient: 0.7 };
    let hourglass = ZeroEnergyControl::Hourglass { coefficient: 0.7 };
    let tensor = ZeroEnergyControl::StiffnessTensor { coefficient: 0.3 };
    let models = [
        BONDS,
        CALIBRATED,
        BondModel::Ordinary,
        correspondence(ZeroEnergyControl::None),
        correspondence(penalty),
        correspondence(hourglass),
        correspondence(tensor),
        FORM_I,
        FORM_II,
        BondModel::BondAveraged,
    ];
    fn checked<const D: usize>(crystal: &Crystal<D>, horizon: f64, models: &[BondModel]) {
        let material = ModifiedMooneyRivlin::default();
        for model in models.iter().copied() {
            let choices = PeridynamicsChoices {
                partial_volumes: PartialVolumes::Tapered,
                influence: Influence::Gaussian,
                ..choices(horizon, model)
            };
            assert_scheme(
                &body(crystal.clone(), choices.clone()),
                &material,
                &state::<D>(),
            );
            let unweighted = PeridynamicsChoices {
                weighted_forces: false,
                ..choices
            };
            assert_scheme(&body(crystal.clone(), unweighted), &material, &state::<D>());
        }
    }
    checked(&cubic::<1>(), 2.0, &models);
    checked(&cubic::<2>(), 1.5, &models);
    // The neighbors of a bond span the space.
    checked(&cubic::<3>(), 1.0, &models[..7]);
    checked(&cubic::<3>(), 1.4, &models[7..]);
    checked(&hexagonal(), 1.2, &models);
    // If particles are not centers of inversion, the pair forces of a sheared state are not balanced.
    let honeycomb = Crystal::<2>::of(LatticeKind::Honeycomb, 1.0).expect("a crystal");
    checked(&honeycomb, 1.3, &models[3..]);
}

#[test]
fn the_dispersion_of_a_chain_of_bonds_is_a_sum_over_its_family() {
    let horizon = 3;
    for influence in [Influence::Constant, Influence::Inverse] {
        let choices = PeridynamicsChoices {
            density: 2.0,
            influence,
            ..choices(f64::from(horizon), BONDS)
        };
        let system = waves(
            &body(cubic::<1>(), choices),
            &DeformationGradient::identity(),
        );
        let delta = f64::from(horizon);
        // The micromodulus c is 2 E / delta^2 for w = 1, and E / delta^2 for w = delta / r.
        let (modulus, power) = match influence {
            Influence::Constant => (2.0 * trace::<1>() / delta.powi(2), 1),
            _ => (trace::<1>() / delta, 2),
        };
        for k in [0.2, 1.0, 2.5, PI] {
            let term = |j: i32| 2.0 * (1.0 - (k * f64::from(j)).cos()) / f64::from(j).powi(power);
            let expected = modulus / 2.0 * (1..=horizon).map(term).sum::<f64>();
            let found = system.omega_squared(&SVector::from_element(k))[0].re;
            assert!(
                (found - expected).abs() < 1e-13 * expected,
                "{found} {expected}"
            );
        }
    }
}

#[test]
fn the_micromodulus_of_the_continuum_has_its_textbook_value() {
    let material = ModifiedMooneyRivlin::default();
    let modulus = |found: Result<f64, _>| found.expect("a modulus");
    let delta = 3.0_f64;
    let chain = body(cubic::<1>(), choices(delta, BONDS));
    let found = modulus(chain.micromodulus(&material, Calibration::Continuum));
    assert!((found - 2.0 * trace::<1>() / delta.powi(2)).abs() < 1e-10);
    // Plane strain: 48 E / (5 pi delta^3) for Poisson's ratio 1/4, with E = 5/2 mu and trace 8 mu.
    let plane = body(cubic::<2>(), choices(delta, BONDS));
    let found = modulus(plane.micromodulus(&material, Calibration::Continuum));
    let young = 2.5 * trace::<2>() / 8.0;
    assert!((found - 48.0 * young / (5.0 * PI * delta.powi(3))).abs() < 1e-10);
    // Micromodulus in three dimensions: 18 K / (pi delta^4), where the trace is 9 K.
    let space = body(cubic::<3>(), choices(delta, BONDS));
    let found = modulus(space.micromodulus(&material, Calibration::Continuum));
    assert!((found - 2.0 * trace::<3>() / (PI * delta.powi(4))).abs() < 1e-10);
}

/// `C_1212` and `C_1122` of a body in the reference state, from its long waves.
fn shear_and_coupling<const D: usize>(body: &Peridynamics<D>) -> (f64, f64) {
    let limit = waves(body, &DeformationGradient::identity()).long_wave_stiffness();
    let along = |weights: [f64; 2]| {
        limit.acoustic_tensor(&SVector::from_fn(|i, _| weights.get(i).map_or(0.0, |w| *w)))
    };
    let shear = along([1.0, 0.0])[(1, 1)];
    (shear, along([1.0, 1.0])[(0, 1)] - shear)
}

#[test]
fn bonds_have_equal_lame_constants_for_any_material() {
    // Six-fold symmetry makes the hexagonal lattice isotropic: exactly an eighth of the trace.
    for horizon in [1.0, 2.0, 3.2] {
        let (mu, lambda) = shear_and_coupling(&body(hexagonal(), choices(horizon, CALIBRATED)));
        assert!((mu - trace::<2>() / 8.0).abs() < 1e-12 * mu);
        assert!((lambda - mu).abs() < 1e-12 * mu);
    }
    // The cubic lattices satisfy Cauchy's relation exactly and isotropy approximately.
    let (shear, coupling) = shear_and_coupling(&body(cubic::<3>(), choices(3.0, CALIBRATED)));
    assert!((shear - coupling).abs() < 1e-12 * shear);
    let off = shear / (trace::<3>() / 15.0) - 1.0;
    assert!((off - 0.08623).abs() < 1e-5, "{off}");
}

#[test]
fn the_error_of_the_modulus_of_a_discrete_horizon_depends_on_the_volumes_at_the_rim() {
    fn ratio<const D: usize>(horizon: f64, partial_volumes: PartialVolumes) -> f64 {
        let material = ModifiedMooneyRivlin::default();
        let choices = PeridynamicsChoices {
            partial_volumes,
            ..choices(horizon, BONDS)
        };
        let body = body(cubic::<D>(), choices);
        let modulus = |calibration| {
            body.micromodulus(&material, calibration)
                .expect("a modulus")
        };
        modulus(Calibration::Continuum) / modulus(Calibration::Discrete)
    }
    use PartialVolumes::{Inside, Tapered, Whole};
    // In one dimension the ratio is sum_1^m j h^2 divided by m^2 h^2 / 2: 1 + 1/m with whole volumes, and 1 with half of the last volume.
    for m in [2.0, 3.0, 5.0] {
        assert!((ratio::<1>(m, Whole) - (1.0 + 1.0 / m)).abs() < 1e-12);
        assert!((ratio::<1>(m, Inside) - 1.0).abs() < 1e-12);
        assert!((ratio::<1>(m, Tapered) - 1.0).abs() < 1e-12);
    }
    // In higher dimensions the expected values are sums over the lattice points.
    for (partial, plane, space) in [
        (Whole, 0.04086, 0.12085),
        (Inside, -0.13095, -0.09979),
        (Tapered, 0.02013, 0.06220),
    ] {
        assert!((ratio::<2>(3.0, partial) - 1.0 - plane).abs() < 1e-5);
        assert!((ratio::<3>(3.0, partial) - 1.0 - space).abs() < 1e-5);
    }
}

#[test]
fn families_on_a_lattice_have_zero_energy_modes_at_half_reciprocal_vectors() {
    fn checked<const D: usize>(crystal: &Crystal<D>, horizon: f64) {
        let free = body(
            crystal.clone(),
            choices(horizon, correspondence(ZeroEnergyControl::None)),
        );
        let bonds = body(crystal.clone(), choices(horizon, BONDS));
        for f in [DeformationGradient::identity(), state::<D>()] {
            let (free, bonds) = (waves(&free, &f), waves(&bonds, &f));
            for k in half_reciprocal_vectors(crystal) {
                let zero = 1e-12 * free.stiffness().magnitude();
                assert!(free.omega_squared(&k).iter().all(|z| z.norm() < zero));
                assert!(
                    bonds
                        .omega_squared(&k)
                        .iter()
                        .all(|z| z.norm() > 1e6 * zero)
                );
            }
        }
    }
    checked(&cubic::<1>(), 3.0);
    checked(&cubic::<2>(), 2.0);
    checked(&hexagonal(), 1.0);
    checked(&cubic::<3>(), 1.8);
}

#[test]
fn the_penalty_lifts_the_zero_energy_modes_of_families_in_proportion_to_its_coefficient() {
    let crystal = cubic::<2>();
    for coefficient in [0.1, 0.2, 1.0] {
        let control = ZeroEnergyControl::Penalty { coefficient };
        let body = body(crystal.clone(), choices(2.0, correspondence(control)));
        for f in [DeformationGradient::identity(), state::<2>()] {
            let system = waves(&body, &f);
            for k in half_reciprocal_vectors(&crystal) {
                // Expected: omega^2 = 2/rho sum_J s_J (1 - cos k.X_J) with s_J = coefficient K_2 V / tr(K).
                let (mut moment, mut sum) = (0.0, 0.0);
                for x in -2_i32..=2 {
                    for y in -2_i32..=2 {
                        let bond = SVector::from([f64::from(x), f64::from(y)]);
                        if bond.norm() <= 2.0 {
                            moment += bond.norm_squared();
                            sum += 1.0 - k.dot(&bond).cos();
                        }
                    }
                }
                let expected = 2.0 * coefficient * trace::<2>() / 4.0 * sum / moment;
                for found in system.omega_squared(&k) {
                    assert!(
                        (found.re / expected - 1.0).abs() < 1e-10,
                        "{found} {expected}"
                    );
                }
            }
        }
    }
}

#[test]
fn long_waves_of_correspondence_peridynamics_agree_with_any_material_with_and_without_control() {
    fn checked<const D: usize>(crystal: &Crystal<D>, horizon: f64) {
        for control in [
            ZeroEnergyControl::None,
            ZeroEnergyControl::Penalty { coefficient: 2.0 },
            ZeroEnergyControl::Hourglass { coefficient: 2.0 },
            ZeroEnergyControl::StiffnessTensor { coefficient: 0.5 },
        ] {
            let choices = PeridynamicsChoices {
                influence: Influence::Conical,
                ..choices(horizon, correspondence(control))
            };
            let body = body(crystal.clone(), choices);
            let material = ModifiedMooneyRivlin::default();
            assert_long_waves_are_those_of_the_material(&body, &material, &state::<D>(), 1e-9);
        }
    }
    checked(&cubic::<1>(), 3.0);
    checked(&cubic::<2>(), 3.0);
    checked(&hexagonal(), 2.5);
    checked(&cubic::<3>(), 2.0);
}

#[test]
fn hourglass_forces_lift_the_zero_energy_modes_without_a_potential() {
    let control = ZeroEnergyControl::Hourglass { coefficient: 1.0 };
    let crystal = cubic::<2>();
    let square = body(crystal.clone(), choices(3.0, correspondence(control)));
    let system = waves(&square, &state::<2>());
    for k in half_reciprocal_vectors(&crystal) {
        let lowest = system.omega_squared(&k)[0].re;
        assert!(lowest > 1e-3 * system.stiffness().magnitude(), "{lowest}");
    }
    // With one particle per cell inversion symmetry hides the missing energy.
    assert!(system.is_hermitian());
    let honeycomb = Crystal::<2>::of(LatticeKind::Honeycomb, 1.0).expect("a crystal");
    let honeycomb = body(honeycomb, choices(2.0, correspondence(control)));
    assert!(!waves(&honeycomb, &state::<2>()).is_hermitian());
}

#[test]
fn bonds_are_stable_in_tension_beyond_the_stability_of_the_material() {
    let material = ModifiedMooneyRivlin::default();
    let body = body(hexagonal(), choices(2.0, CALIBRATED));
    let at = |stretch: f64| {
        DeformationGradient::from_stretches([stretch, stretch, 1.0]).expect("a state")
    };
    let lost = [1.5, 2.0, 3.0].map(|stretch| {
        let f = at(stretch);
        let system = waves(&body, &f);
        for i in 1..=10 {
            for j in 0..=10 {
                let fractional = SVector::from([f64::from(i) / 10.0, f64::from(j) / 20.0]);
                let k = system.crystal().lattice().reciprocal() * fractional;
                assert!(system.omega_squared(&k)[0].re > -1e-9, "{stretch} {k}");
            }
        }
        !Stiffness::<2>::at(&material, &f)
            .expect("a tangent")
            .is_strongly_elliptic()
    });
    assert_eq!(lost, [false, true, true]);
}

#[test]
fn planar_bonds_buckle_at_the_equibiaxial_stretch_of_three_quarters() {
    // Transverse long waves: <n^2 t^2> (1 - eta) + <n^2> eta = (1 + 3 eta)/8 with eta = 1 - 1/stretch: zero at 3/4.
    for horizon in [1.0, 2.0, 3.0] {
        let body = body(hexagonal(), choices(horizon, CALIBRATED));
        for (stretch, expected) in [(0.75, 0.0), (0.8, 1.0 / 4.0), (1.0, 1.0)] {
            let f = DeformationGradient::from_stretches([stretch, stretch, 1.0]).expect("a state");
            let limit = waves(&body, &f).long_wave_stiffness();
            let transverse = limit.acoustic_tensor(&SVector::from([1.0, 0.0]))[(1, 1)];
            let mu = trace::<2>() / 8.0;
            assert!(
                (transverse / mu - expected).abs() < 1e-12,
                "{stretch}: {transverse}"
            );
        }
    }
}

#[test]
fn omega_squared_of_a_chain_of_families_is_the_square_of_its_mean_gradient() {
    let choices = PeridynamicsChoices {
        density: 2.0,
        influence: Influence::Inverse,
        ..choices(3.0, correspondence(ZeroEnergyControl::None))
    };
    let f = state::<1>();
    let system = waves(&body(cubic::<1>(), choices), &f);
    let response = ModifiedMooneyRivlin::default().response(&f);
    let tangent = response.expect("a response").tangent[(0, 0, 0, 0)];
    for k in [0.3, 1.4, 3.0] {
        // With w X V = sign X the gradient is the sum of sin(j k) divided by the sum of j.
        let gradient = [1.0, 2.0, 3.0]
            .map(|j: f64| (j * k).sin())
            .iter()
            .sum::<f64>()
            / 6.0;
        let found = system.omega_squared(&SVector::from_element(k))[0].re;
        assert!((found - tangent * gradient.powi(2) / 2.0).abs() < 1e-12 * tangent);
    }
}

#[test]
fn hourglass_forces_equal_bonds_from_both_ends_if_the_gradient_vanishes() {
    let (crystal, coefficient) = (cubic::<2>(), 0.3);
    let control = ZeroEnergyControl::Hourglass { coefficient };
    let of = |model| {
        let body = body(crystal.clone(), choices(3.0, model));
        waves(&body, &DeformationGradient::identity())
    };
    let (controlled, bonds) = (of(correspondence(control)), of(BONDS));
    for k in half_reciprocal_vectors(&crystal) {
        let pairs = controlled
            .omega_squared(&k)
            .into_iter()
            .zip(bonds.omega_squared(&k));
        for (found, bond) in pairs {
            assert!((found.re / (2.0 * coefficient * bond.re) - 1.0).abs() < 1e-10);
        }
    }
}

#[test]
fn rotating_the_state_rotates_the_stiffness() {
    let turn = SMatrix::<f64, 2, 2>::new(0.8, -0.6, 0.6, 0.8);
    let f = state::<2>();
    let turned = f.with_leading(&(turn * f.leading::<2>()));
    let hourglass = ZeroEnergyControl::Hourglass { coefficient: 0.3 };
    for model in [BONDS, correspondence(hourglass)] {
        let body = body(hexagonal(), choices(2.0, model));
        let k = SVector::from([1.3, -0.4]);
        let of = |f: &DeformationGradient| {
            let matrix = waves(&body, f).stiffness().at(&k);
            SMatrix::<f64, 2, 2>::from_fn(|i, j| matrix[(i, j)].re)
        };
        let expected = turn * of(&f) * turn.transpose();
        assert!((of(&turned) - expected).amax() < 1e-11 * expected.amax());
    }
}

#[test]
fn invalid_horizons_controls_and_states_are_rejected() {
    let lattice = SMatrix::<f64, 2, 2>::new(1.0, 0.0, 0.0, 2.0);
    let crystal = Crystal::of_lattice(BravaisLattice::new(lattice).expect("a lattice"));
    let model = correspondence(ZeroEnergyControl::None);
    let error = Peridynamics::new(crystal.clone(), choices(1.5, model)).expect_err("a line");
    assert!(
        matches!(error, MethodError::HorizonTooSmall { bonds: 2, .. }),
        "{error}"
    );
    let error = Peridynamics::new(crystal.clone(), choices(40.0, model)).expect_err("too many");
    assert!(
        matches!(error, MethodError::HorizonTooLarge { .. }),
        "{error}"
    );
    let error =
        Peridynamics::new(crystal.clone(), choices(f64::NAN, BONDS)).expect_err("no number");
    assert!(
        matches!(
            error,
            MethodError::Setting {
                name: "horizon",
                ..
            }
        ),
        "{error}"
    );
    let control = ZeroEnergyControl::Penalty { coefficient: -1.0 };
    let error = Peridynamics::new(crystal, choices(3.0, correspondence(control)));
    assert!(matches!(error, Err(MethodError::Setting { .. })));
    let sheared = DeformationGradient::new([[1.0, 0.0, 0.1], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
        .expect("a state");
    let error = body(cubic::<2>(), choices(3.0, BONDS))
        .waves(&ModifiedMooneyRivlin::default(), &sheared)
        .expect_err("out of plane");
    assert_eq!(error, MethodError::NotPlanar { dimension: 2 });
    assert_eq!(body(cubic::<3>(), choices(1.0, BONDS)).neighbors(), 7.0);
}

/// Law with given Lame constants.
#[test]
fn an_ordinary_solid_with_equal_lame_constants_consists_of_bonds_with_inverse_influence() {
    fn checked<const D: usize>(crystal: &Crystal<D>, horizon: f64, f: &DeformationGradient) {
        let law = saint_venant_kirchhoff(1.3, 1.3);
        let of = |model, influence| {
            let choices = PeridynamicsChoices {
                influence,
                partial_volumes: PartialVolumes::Tapered,
                ..choices(horizon, model)
            };
            let body = body(crystal.clone(), choices);
            body.waves(&*law, f).expect("an evaluable state")
        };
        let solid = of(BondModel::Ordinary, Influence::Inverse);
        let bonds = of(CALIBRATED, Influence::Constant);
        let mut random = Random::new(1);
        for _ in 0..5 {
            let k = SVector::from_fn(|_, _| 3.0 * random.number());
            let (solid, bonds) = (solid.stiffness().at(&k), bonds.stiffness().at(&k));
            assert!((solid - &bonds).norm() < 1e-12 * bonds.norm());
        }
    }
    checked(&cubic::<2>(), 3.0, &state::<2>());
    checked(&hexagonal(), 2.0, &state::<2>());
    checked(&cubic::<3>(), 2.0, &state::<3>());
}

#[test]
fn long_waves_of_an_ordinary_solid_have_both_moduli_of_the_material() {
    let law = saint_venant_kirchhoff(2.0, 0.6);
    let rest = DeformationGradient::identity();
    // Long waves are exact if the bonds are isotropic to fourth order: in a chain and on the hexagonal lattice.
    for horizon in [1.0, 2.0, 3.0] {
        let chain = body(cubic::<1>(), choices(horizon, BondModel::Ordinary));
        assert_long_waves_are_those_of_the_material(&chain, &*law, &rest, 1e-12);
        let plane = body(hexagonal(), choices(horizon, BondModel::Ordinary));
        assert_long_waves_are_those_of_the_material(&plane, &*law, &rest, 1e-12);
    }
    // The bulk modulus is exact on every lattice, because the dilatation of a family equals the trace of the strain.
    let cubic = body(cubic::<3>(), choices(2.0, BondModel::Ordinary));
    let limit = cubic
        .waves(&*law, &rest)
        .expect("an evaluable state")
        .long_wave_stiffness();
    let at = |x: f64, y: f64| limit.acoustic_tensor(&SVector::from([x, y, 0.0]));
    let (along, shear) = (at(1.0, 0.0)[(0, 0)], at(1.0, 0.0)[(1, 1)]);
    let coupling = at(1.0, 1.0)[(0, 1)] - shear;
    assert!(((along + 2.0 * coupling) / (3.0 * 2.0 + 2.0 * 0.6) - 1.0).abs() < 1e-12);
}

#[test]
fn long_waves_of_bond_gradients_with_an_energy_agree_with_the_material() {
    fn checked<const D: usize>(crystal: &Crystal<D>, horizon: f64) {
        let material = ModifiedMooneyRivlin::default();
        for model in [FORM_II, BondModel::BondAveraged] {
            let body = body(crystal.clone(), choices(horizon, model));
            assert_long_waves_are_those_of_the_material(&body, &material, &state::<D>(), 1e-9);
        }
    }
    checked(&cubic::<1>(), 3.0);
    checked(&cubic::<2>(), 2.0);
    checked(&hexagonal(), 2.0);
    checked(&cubic::<3>(), 1.5);
}

#[test]
fn pairwise_forces_of_bond_gradients_reproduce_a_homogeneous_stress_only_approximately() {
    let chain = body(cubic::<1>(), choices(2.0, FORM_I));
    let limit = waves(&chain, &DeformationGradient::identity()).long_wave_stiffness();
    let found = limit.acoustic_tensor(&SVector::from_element(1.0))[(0, 0)] / trace::<1>();
    // The modulus has the factor sum_J (V_b/V_H) X_J^2 V / K_b instead of 1, where K_b is the sum of X^2 over the neighbors of a bond.
    // Among the four neighbors, the bond to 1 has -1, 1 and 2 (K = 6), and the bond to 2 has 1 and 2 (K = 5).
    let expected = 2.0 * (0.75 / 6.0 + 0.5 * 4.0 / 5.0);
    assert!((found - expected).abs() < 1e-12, "{found} {expected}");
}

#[test]
fn bond_gradients_have_no_zero_energy_modes_where_families_have_them() {
    fn zero_energy_modes<const D: usize>(
        crystal: &Crystal<D>,
        choices: PeridynamicsChoices,
    ) -> usize {
        let material = ModifiedMooneyRivlin::default();
        let body = body(crystal.clone(), choices);
        let survey = Survey::new(&body, &material).expect("a survey");
        let found = spurious_modes(&survey, WEAK_WAVE_RATIO).expect("modes");
        found.modes.iter().filter(|mode| mode.is_zero()).count()
    }
    for model in [FORM_II, BondModel::BondAveraged] {
        assert_eq!(
            zero_energy_modes(&cubic::<2>(), choices(2.0, model)),
            0,
            "{model:?}"
        );
        assert_eq!(
            zero_energy_modes(&hexagonal(), choices(2.0, model)),
            0,
            "{model:?}"
        );
        assert_eq!(
            zero_energy_modes(&cubic::<3>(), choices(1.5, model)),
            0,
            "{model:?}"
        );
    }
    let families = correspondence(ZeroEnergyControl::None);
    assert!(zero_energy_modes(&cubic::<2>(), choices(2.0, families)) > 0);
    // Form I: alternating particles strain only bonds whose ends move alike, which exert no force on them.
    assert_eq!(zero_energy_modes(&cubic::<2>(), choices(2.0, FORM_I)), 1);
    let alternating = SVector::from([PI, PI]);
    let system = waves(&body(cubic::<2>(), choices(2.0, FORM_I)), &state::<2>());
    let scale = system.stiffness().magnitude();
    assert!(system.stiffness().at(&alternating).norm() < 1e-12 * scale);
    for horizon in [1.5, 3.0] {
        assert_eq!(
            zero_energy_modes(&cubic::<2>(), choices(horizon, FORM_I)),
            0
        );
        assert_eq!(zero_energy_modes(&hexagonal(), choices(horizon, FORM_I)), 0);
    }
}

#[test]
fn on_cubic_lattices_springs_of_the_stiffness_tensor_are_a_penalty_with_the_squared_dimension() {
    fn checked<const D: usize>(crystal: &Crystal<D>, horizon: f64) {
        let of = |control| {
            let body = body(crystal.clone(), choices(horizon, correspondence(control)));
            waves(&body, &state::<D>())
        };
        let tensor = of(ZeroEnergyControl::StiffnessTensor { coefficient: 0.2 });
        let penalty = of(ZeroEnergyControl::Penalty {
            coefficient: 0.2 * (D * D) as f64,
        });
        let k = SVector::from_fn(|i, _| 1.1 + 0.4 * i as f64);
        let (tensor, penalty) = (tensor.stiffness().at(&k), penalty.stiffness().at(&k));
        assert!((tensor - &penalty).norm() < 1e-12 * penalty.norm());
    }
    checked(&cubic::<1>(), 3.0);
    checked(&hexagonal(), 2.0);
    checked(&cubic::<3>(), 2.0);
}

#[test]
fn forces_without_the_influence_function_differ_if_and_only_if_it_varies() {
    let of = |influence, weighted_forces| {
        let choices = PeridynamicsChoices {
            influence,
            weighted_forces,
            ..choices(3.0, correspondence(ZeroEnergyControl::None))
        };
        waves(&body(cubic::<2>(), choices), &state::<2>())
    };
    let k = SVector::from([0.9, 0.4]);
    let matrix = |influence, weighted| of(influence, weighted).stiffness().at(&k);
    let constant = matrix(Influence::Constant, true);
    assert!((matrix(Influence::Constant, false) - &constant).norm() < 1e-14 * constant.norm());
    // Moduli of long waves are wrong by the ratio of the moments sum X^2 / sum w X^2.
    let [weighted, unweighted] = [true, false].map(|weighted| {
        let limit = of(Influence::Parabolic, weighted).long_wave_stiffness();
        limit.acoustic_tensor(&SVector::from([1.0, 0.0]))[(0, 0)]
    });
    let (mut with, mut without) = (0.0, 0.0);
    for x in -3_i32..=3 {
        for y in -3_i32..=3 {
            let squared = f64::from(x * x + y * y);
            if squared > 0.0 && squared <= 9.0 {
                with += Influence::Parabolic.weight(squared.sqrt() / 3.0) * squared;
                without += squared;
            }
        }
    }
    assert!((unweighted / weighted / (without / with) - 1.0).abs() < 1e-9);
}
