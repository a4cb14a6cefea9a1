//! Bounds over the zone compared with the minimum of a dense grid.

use nalgebra::Vector2;
use onset::bloch::dynamical_matrix;
use onset::certificate::{Certainty, Certifier};
use onset::kinematics::DeformationGradient;
use onset::lattice::BrillouinZone;
use onset::material::ModifiedMooneyRivlin;
use onset::method::{CurrentLattice, Frame, KernelMethodChoices, Linearization, Method};
use onset::verdict::speed_squared;

/// Smallest measure on a grid of the zone and of long waves.
fn sampled(method: &Method<2>, state: &DeformationGradient) -> f64 {
    let material = ModifiedMooneyRivlin::default();
    let matrix = dynamical_matrix(method, &material, state).expect("finite");
    let speed_squared = speed_squared(method, &material).expect("finite");
    let home = method.home_map(state);
    let zone = BrillouinZone::new(method.lattice().mapped(&home).expect("a lattice"));
    let measure = |k: &Vector2<f64>| {
        matrix.omega_squared(k)[0].re / (speed_squared * method.lattice().laplacian(k))
    };
    let mut least = f64::INFINITY;
    for i in 0..120 {
        for j in 0..120 {
            let fractional = Vector2::new(f64::from(i) + 0.5, f64::from(j) + 0.5) / 120.0;
            least = least.min(measure(
                &(home.transpose() * zone.folded(&zone.wave_vector(&fractional))),
            ));
        }
    }
    for n in 0..180 {
        let (sine, cosine) = (std::f64::consts::PI * f64::from(n) / 180.0).sin_cos();
        for length in [1e-3, 1e-2, 0.1] {
            least = least.min(measure(&(Vector2::new(cosine, sine) * length)));
        }
    }
    least
}

#[test]
fn bounds_lie_below_every_sample_and_within_ten_percent_of_the_minimum() {
    use Linearization::{Exact, Paper};
    let material = ModifiedMooneyRivlin::default();
    let mut proved = 0;
    for (lattice, linearization, support) in [
        (CurrentLattice::Regular, Exact, 1.9),
        (CurrentLattice::Regular, Paper, 1.9),
        (CurrentLattice::Convected, Exact, 1.6),
        (CurrentLattice::Convected, Paper, 2.0),
    ] {
        let discretization = KernelMethodChoices {
            frame: Frame::Eulerian,
            current_lattice: lattice,
            linearization,
            support,
            ..KernelMethodChoices::default()
        };
        let method = Method::<2>::new(discretization.clone()).expect("a method");
        let usual = Certifier::new(&method, &material, 1e-3).expect("a method");
        let sharp = Certifier::new(&method, &material, 1e-3)
            .expect("a method")
            .with_share(0.95);
        for stretches in [
            [0.95, 0.9, 1.0],
            [0.8, 0.9, 1.0],
            [0.7, 0.75, 1.0],
            [1.1, 0.8, 1.0],
        ] {
            let state = DeformationGradient::from_stretches(stretches).expect("a state");
            let certainty = [&usual, &sharp]
                .map(|certifier| certifier.certify(&state).expect("a state").discretization);
            let [
                Certainty::Stable { bound: usual },
                Certainty::Stable { bound: sharp },
            ] = certainty
            else {
                continue;
            };
            let least = sampled(&method, &state);
            assert!(
                usual > 0.0 && usual < sharp && sharp < least,
                "{usual:e} < {sharp:e} < {least:e}"
            );
            assert!(
                sharp > 0.9 * least,
                "{sharp:e} of {least:e} at {stretches:?} for {discretization:?}"
            );
            proved += 1;
        }
    }
    assert!(proved >= 8, "{proved} states are proved");
}
