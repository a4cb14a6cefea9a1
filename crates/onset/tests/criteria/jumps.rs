//! Rank-one convexity along finite jumps.

use super::{NeoHooke, path, track, zero};
use nalgebra::Matrix3;
use onset::criteria::{Criterion, JumpSearch, Lateral, Mode, Witness, follow_jumps};
use onset::kinematics::DeformationGradient;
use onset::material::{BlatzKo, Hyperelastic};

const REACH: (f64, f64) = (0.1, 10.0);

fn energy(law: &dyn Hyperelastic, matrix: &Matrix3<f64>) -> f64 {
    let components = std::array::from_fn(|i| std::array::from_fn(|j| matrix[(i, j)]));
    let f = DeformationGradient::new(components).expect("admissible");
    law.response(&f).expect("finite").energy
}

#[test]
fn a_jump_that_is_found_gains_energy() {
    let law = BlatzKo::default();
    let search = JumpSearch::new(&law, REACH);
    let f = DeformationGradient::from_stretches([3.5, 1.0, 1.0]).expect("stretches");
    let response = law.response(&f).expect("finite");
    let jump = search.lowest(&response).expect("a jump");
    let (a, n) = (jump.amplitude, jump.direction);
    let there = energy(&law, &(f.matrix() + a * n.transpose()));
    let gained = there - response.energy - a.dot(&(response.first_piola * n));
    assert!(gained < -1e-3, "{gained}");
    let scaled = 2.0 * gained / a.norm_squared();
    assert!((scaled - jump.excess).abs() < 1e-10);
}

#[test]
fn a_polyconvex_law_has_no_jump_that_gains_energy() {
    // Convex in F and in J.
    struct Polyconvex;
    impl onset::material::StrainEnergy for Polyconvex {
        fn energy<R: onset::real::Real>(&self, f: &DeformationGradient<R>) -> R {
            let i = f.invariants();
            (i.first - 3.0) * 0.5 - i.jacobian.ln() + (i.jacobian - 1.0).powi(2)
        }
    }
    let search = JumpSearch::new(&Polyconvex, REACH);
    for stretches in [
        [1.0, 1.0, 1.0],
        [3.0, 0.4, 1.2],
        [0.3, 0.3, 0.5],
        [4.0, 4.0, 0.2],
    ] {
        let f = DeformationGradient::from_stretches(stretches).expect("stretches");
        let lowest = search.lowest(&Polyconvex.response(&f).expect("finite"));
        assert!(lowest.is_none_or(|jump| jump.excess > 0.0), "{stretches:?}");
    }
}

/// In uniaxial strain the energy along the jump `a (x) e_2`, `a = t e_2`, is `w(1 + t)` with `w(x) = mu/2 x^2 - mu ln x + lambda/2 (L + ln x)^2`,
/// `L = ln lambda_1`. The jump gains energy where the tangent of `w` at 1 cuts `w`; that begins at a common tangent.
#[test]
fn finite_jumps_gain_energy_before_waves_stop() {
    let (mu, lambda) = (1.0, 6.0);
    let law = NeoHooke { mu, lambda };
    let held = path(&law, Mode::Uniaxial, Lateral::Held);
    let elliptic = track(&held, Criterion::StrongEllipticity, true);
    let jumps = follow_jumps(&held, &elliptic, REACH, true);
    let excess = |stretch: f64| {
        let log = stretch.ln();
        let w = |x: f64| 0.5 * mu * x * x - mu * x.ln() + 0.5 * lambda * (log + x.ln()).powi(2);
        let slope = mu - mu + lambda * log;
        (1..4000)
            .map(|n| 1.0 + 9.0 * n as f64 / 4000.0)
            .map(|x| (w(x) - w(1.0) - slope * (x - 1.0)) / (x - 1.0).powi(2))
            .fold(f64::INFINITY, f64::min)
    };
    let along_one_axis = zero(excess, 1.0001, elliptic.limit().expect("lost"));
    let limit = jumps.limit().expect("lost");
    assert!(limit <= along_one_axis + 1e-6, "{limit} {along_one_axis}");
    assert!(limit < elliptic.limit().expect("lost") - 0.05);
    let Some(Witness::Jump {
        amplitude,
        direction,
        ..
    }) = jumps.witness()
    else {
        panic!("a jump is the witness");
    };
    // At the limit the jump breaks even, and small ones cost energy.
    let response = held.at(limit.ln()).expect("a state").response;
    let (a, n) = (
        nalgebra::Vector3::from(*amplitude),
        nalgebra::Vector3::from(*direction),
    );
    let f = response.deformation.matrix();
    let there = energy(&law, &(f + a * n.transpose()));
    let gained = there - response.energy - a.dot(&(response.first_piola * n));
    assert!(gained.abs() < 1e-9 * a.norm_squared(), "{gained}");
}
