//! Rank-one convexity along finite jumps.

use super::{NeoHooke, path, track, zero};
use nalgebra::Matrix3;
use onset::criteria::{
    Criterion, JumpSearch, Lateral, Loading, LoadingPath, Mode, Range, Witness, follow_jumps,
    is_isotropic,
};
use onset::kinematics::DeformationGradient;
use onset::material::{BlatzKo, Hyperelastic, Law};

const REACH: f64 = 10.0;

fn energy(law: &dyn Hyperelastic, matrix: &Matrix3<f64>) -> f64 {
    let components = std::array::from_fn(|i| std::array::from_fn(|j| matrix[(i, j)]));
    let f = DeformationGradient::new(components).expect("admissible");
    law.response(&f).expect("finite").energy
}

#[test]
fn reported_jumps_lower_the_energy() {
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
fn a_polyconvex_law_has_no_jump_that_lowers_the_energy() {
    // The energy is the sum of a convex function of F and a convex function of J.
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
/// `L = ln lambda_1`. The jump lowers the energy if the tangent of `w` at 1 intersects `w`, starting at a common tangent.
#[test]
fn finite_jumps_lower_the_energy_before_ellipticity_is_lost_in_uniaxial_strain() {
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
    // At the limit the jump does not change the energy, and small jumps raise it.
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

/// Stretches at which a jump lowers the energy, computed by other means (a search in five variables from random starts, closed forms), with the later
/// loss of ellipticity. The limit must be at least as near to the reference configuration, to the five known digits, and interval arithmetic must
/// prove the decrease of energy.
#[test]
fn jumps_that_lower_the_energy_before_ellipticity_is_lost_are_found() {
    use Lateral::{Held, PlaneStrain};
    use Mode::{Equibiaxial, Hydrostatic, Planar, Uniaxial};
    for (name, mode, lateral, tension, bound, ellipticity) in [
        (
            "neo-hooke",
            Equibiaxial,
            PlaneStrain,
            true,
            4.243_364_41_f64,
            4.481_689_07,
        ),
        ("neo-hooke", Uniaxial, Held, true, 18.006_14, 20.0855),
        (
            "saint-venant-orthotropic",
            Uniaxial,
            Held,
            false,
            0.981_20,
            0.964_42,
        ),
        (
            "cubic-crystal",
            Hydrostatic,
            Held,
            false,
            0.969_65,
            0.947_33,
        ),
        ("fung", Hydrostatic, Held, false, 0.952_13, 0.930_95),
        (
            "generalized-blatz-ko",
            Planar,
            PlaneStrain,
            true,
            2.554_975,
            2.576_556,
        ),
    ] {
        let law = library_law(name);
        let range = Range::new(0.1, 30.0).expect("a range");
        let path = LoadingPath::new(
            &*law,
            is_isotropic(&*law),
            Loading { mode, lateral },
            &range,
        )
        .expect("a reference");
        let elliptic = track(&path, Criterion::StrongEllipticity, tension);
        let waves = elliptic.limit().expect("lost");
        let jumps = follow_jumps(&path, &elliptic, REACH.max(range.high()), tension);
        let own = jumps.limit().expect("lost");
        assert!((waves / ellipticity - 1.0).abs() < 1e-5, "{name}: {waves}");
        assert!(own.ln().abs() <= bound.ln().abs() + 6e-6, "{name}: {own}");
        let Some(Witness::Jump { verified: true, .. }) = jumps.witness() else {
            panic!("{name}: {:?}", jumps.witness());
        };
    }
}

/// With `w(x) = (x^2 - 1)/2 - ln x + (L + ln x)^2 / 2`, `mu = lambda = 1`, `L = ln J`, the third stretch jumps from 1 to the point of contact of the
/// tangent of `w` at 1: at `L = 2.8907129`, `x = 0.4826649`.
#[test]
fn the_third_stretch_of_neo_hooke_jumps_at_the_common_tangent() {
    let law = library_law("neo-hooke");
    let held = path(&*law, Mode::Equibiaxial, Lateral::PlaneStrain);
    let elliptic = track(&held, Criterion::StrongEllipticity, true);
    let jumps = follow_jumps(&held, &elliptic, REACH, true);
    // The tangent of the energy at stretch 1 touches its graph at x: w(x) - w(1) = w'(1) (x - 1), and w'(x) = w'(1) = L.
    let slope = |x: f64, log: f64| x - 1.0 / x + (log + x.ln()) / x;
    let log_of = |x: f64| (x - 1.0 / x + x.ln() / x) / (1.0 - 1.0 / x);
    let w = |x: f64, log: f64| 0.5 * (x * x - 1.0) - x.ln() + 0.5 * (log + x.ln()).powi(2);
    let gap = |x: f64| w(x, log_of(x)) - w(1.0, log_of(x)) - log_of(x) * (x - 1.0);
    let x = super::zero(gap, 0.3, 0.7);
    assert!((slope(x, log_of(x)) - log_of(x)).abs() < 1e-12);
    assert!((x - 0.482_665).abs() < 1e-6 && (log_of(x) - 2.890_712_71).abs() < 3e-7);
    let limit = jumps.limit().expect("lost");
    assert!((2.0 * limit.ln() - log_of(x)).abs() < 1e-9, "{limit}");
    let Some(Witness::Jump {
        amplitude,
        direction,
        verified,
        at_edge,
        ..
    }) = jumps.witness()
    else {
        panic!("a jump is the witness");
    };
    assert!(*verified && !at_edge);
    assert!(
        (amplitude[2] * direction[2] - (x - 1.0)).abs() < 1e-4,
        "{amplitude:?}"
    );
}

/// The lowest jumps of Hencky's law lead obliquely to the largest stretch of the range. The bounds come from a search from 50,000 random jumps,
/// refined by the simplex method, with energies from eigenvalues of `C` alone.
#[test]
fn oblique_jumps_to_the_largest_stretch_of_the_range_are_found() {
    let hencky = Law::named("hencky").expect("a law");
    let law = hencky.build(&[("kappa", 2.0)]).expect("admissible");
    let range = Range::new(0.2, 5.0).expect("a range");
    let loading = Loading {
        mode: Mode::Uniaxial,
        lateral: Lateral::Held,
    };
    let path = LoadingPath::new(&*law, true, loading, &range).expect("a reference");
    let elliptic = track(&path, Criterion::StrongEllipticity, false);
    let jumps = follow_jumps(&path, &elliptic, range.high(), false);
    let own = jumps.limit().expect("lost");
    assert!(own >= 0.279_08, "{own}");
    let event = &jumps.events[0];
    assert!(event.is_upper_bound && event.tolerance > 1e-14 && event.tolerance < 1e-9);
}

/// At this state the jump lowers the energy by 12.65, much more than rounding.
#[test]
fn a_published_jump_is_proved_to_lower_the_energy() {
    let law = library_law("generalized-blatz-ko");
    let held = path(&*law, Mode::Planar, Lateral::PlaneStrain);
    let state = held.at(2.554_975_f64.ln()).expect("a state").response;
    let search = JumpSearch::new(&*law, REACH);
    let lowest = search.lowest(&state).expect("a jump");
    assert!(
        lowest.gains() && search.proves(&state, &lowest),
        "{lowest:?}"
    );
    let turned = onset::criteria::Jump {
        excess: -1.0,
        amplitude: -lowest.amplitude * 1e-3,
        ..lowest
    };
    assert!(!search.proves(&state, &turned));
}

/// No limit is later than the limit of a brute-force search, which refines random jumps coordinate by coordinate and uses only energies.
#[test]
fn random_jumps_do_not_lower_the_energy_before_the_limit() {
    let laws = [
        ("neo-hooke", Mode::Equibiaxial, Lateral::PlaneStrain, true),
        (
            "saint-venant-kirchhoff",
            Mode::Hydrostatic,
            Lateral::Held,
            false,
        ),
        ("hencky", Mode::Planar, Lateral::PlaneStress, true),
        (
            "saint-venant-orthotropic",
            Mode::Uniaxial,
            Lateral::Held,
            false,
        ),
    ];
    let assert_no_gain = |(name, mode, lateral, tension)| {
        let law = library_law(name);
        let loading = Loading { mode, lateral };
        let path = LoadingPath::new(&*law, is_isotropic(&*law), loading, &Range::default())
            .expect("a reference");
        let elliptic = track(&path, Criterion::StrongEllipticity, tension);
        let limit = follow_jumps(&path, &elliptic, REACH, tension)
            .limit()
            .expect("lost");
        for part in [0.6, 0.95, 0.995] {
            let state = path.at(limit.ln() * part).expect("a state").response;
            let gain = brute_force(&*law, &state);
            assert!(gain > -1e-9, "{name} at {part} of {limit}: {gain}");
        }
    };
    std::thread::scope(|scope| {
        for law in laws {
            scope.spawn(move || assert_no_gain(law));
        }
    });
}

/// Lowest `W(F + a (x) N) - W(F) - P : a (x) N` among random jumps and small changes of the best ones.
fn brute_force(law: &dyn Hyperelastic, state: &onset::material::Response) -> f64 {
    let f = state.deformation.matrix();
    let gain = |x: &[f64; 6]| -> f64 {
        let a = nalgebra::Vector3::new(x[0], x[1], x[2]);
        let n = nalgebra::Vector3::new(x[3], x[4], x[5]).normalize();
        let to = f + a * n.transpose();
        let components = std::array::from_fn(|i| std::array::from_fn(|j| to[(i, j)]));
        let Ok(to) = DeformationGradient::new(components) else {
            return f64::INFINITY;
        };
        let [largest, _, smallest] = to.principal_stretches();
        if smallest < 0.1 || largest > REACH {
            return f64::INFINITY;
        }
        let energy = law
            .energy_and_stress(&to)
            .map_or(f64::INFINITY, |(energy, _)| energy);
        energy - state.energy - a.dot(&(state.first_piola * n))
    };
    let mut seed = 88_172_645_463_325_252_u64;
    let mut random = || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed >> 11) as f64 / (1_u64 << 53) as f64 * 2.0 - 1.0
    };
    let mut tried: Vec<(f64, [f64; 6])> = (0..2_000)
        .map(|_| {
            let size = 4.0_f64.powf(2.0 * random() - 0.5);
            let x = [0; 6].map(|_: i32| random());
            let x = [x[0] * size, x[1] * size, x[2] * size, x[3], x[4], x[5]];
            (gain(&x), x)
        })
        .collect();
    tried.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut lowest = f64::INFINITY;
    for (mut value, mut x) in tried.into_iter().take(6) {
        let mut step = 0.3;
        while step > 1e-4 {
            let before = value;
            for n in 0..12 {
                let mut next = x;
                next[n / 2] += if n % 2 == 0 { step } else { -step };
                let own = gain(&next);
                if own < value {
                    (value, x) = (own, next);
                }
            }
            if value == before {
                step *= 0.5;
            }
        }
        lowest = lowest.min(value);
    }
    lowest
}

fn library_law(name: &str) -> Box<dyn Hyperelastic> {
    Law::named(name)
        .expect("a law")
        .build(&[])
        .expect("defaults")
}

/// With `c01 < 0` the energy `c01 J^(-4/3) I2` has no lower bound at `J = 0`: jumps to small enough volumes lower the energy at any bulk modulus, behind a
/// barrier of half the bulk modulus. With positive constants no jump lowers it.
#[test]
fn an_energy_without_lower_bound_at_zero_volume_is_never_rank_one_convex() {
    use Lateral::{Free, Held, PlaneStrain};
    for kappa in (3..=12).map(|power| 10.0_f64.powi(power)) {
        // Energy of the jump from the reference configuration to `diag(j, 1, 1)`.
        let energy = |j: f64| {
            0.6 * (j.powf(-2.0 / 3.0) * (2.0 + j * j) - 3.0)
                - 0.1 * (j.powf(-4.0 / 3.0) * (1.0 + 2.0 * j * j) - 3.0)
                + 0.5 * kappa * (j - 1.0).powi(2)
        };
        assert!(energy(1e-11) < 0.0 && energy(0.5) > 0.0);
        for (c01, expected) in [(-0.1, Some(1.0)), (0.1, None)] {
            let law = Law::named("mooney-rivlin-isochoric").expect("a law");
            let law = law
                .build(&[("c10", 0.6), ("c01", c01), ("kappa", kappa)])
                .expect("parameters");
            for (mode, lateral) in [
                (Mode::Uniaxial, Free),
                (Mode::Uniaxial, Held),
                (Mode::Planar, PlaneStrain),
                (Mode::Hydrostatic, Held),
            ] {
                let path = path(&*law, mode, lateral);
                for tension in [true, false] {
                    let elliptic = track(&path, Criterion::StrongEllipticity, tension);
                    let found = follow_jumps(&path, &elliptic, REACH, tension).limit();
                    let what = format!("{kappa:e} {c01} {mode:?} {lateral:?} {tension}");
                    assert_eq!(found, expected, "{what}");
                }
            }
        }
    }
}
