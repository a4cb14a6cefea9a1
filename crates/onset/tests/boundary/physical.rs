//! Boundaries of the laws and of their discretizations.

use onset::kinematics::DeformationGradient;
use onset::material::{BlatzKo, Hyperelastic, ModifiedMooneyRivlin};
use onset::method::{CurrentLattice, Frame, KernelMethodChoices, Linearization, Method};
use onset::verdict::boundary::{Boundary, Curve, End, Fineness, Window, trace_boundary};
use onset::verdict::fidelity::{RayOnset, areas, directed_distance, onset_along};
use onset::verdict::{Phase, Probe, Survey, judge, probe_material};
use std::sync::atomic::{AtomicUsize, Ordering};

type Asked = Result<Probe, String>;

fn state([a, b]: [f64; 2]) -> Result<DeformationGradient, String> {
    DeformationGradient::from_stretches([a, b, 1.0]).map_err(|error| error.to_string())
}

fn square(low: f64, high: f64) -> Window {
    Window {
        low: [low; 2],
        high: [high; 2],
    }
}

fn of_material(material: &(dyn Hyperelastic + Sync)) -> impl Fn([f64; 2]) -> Asked + Sync + '_ {
    move |at| probe_material::<2>(material, &state(at)?).map_err(|error| error.to_string())
}

/// Phase that distinguishes only stable and unstable particles, not the kind of instability.
fn of_particles<'a>(probe: &'a Survey<'a, 2>) -> impl Fn([f64; 2]) -> Asked + Sync + 'a {
    move |at| {
        let (phase, measure) = probe
            .probe(&state(at)?)
            .map_err(|error| error.to_string())?;
        Ok(match phase {
            Phase::Flutter => (Phase::Unstable, f64::NAN),
            other => (other, measure),
        })
    }
}

fn trace(window: Window, cells: usize, probe: &(dyn Fn([f64; 2]) -> Asked + Sync)) -> Boundary {
    let fineness = Fineness {
        cells: [cells; 2],
        ..Fineness::default()
    };
    trace_boundary(window, &fineness, probe).expect("every state can be evaluated")
}

/// Checks that the exact condition changes within a distance of each vertex, across the curve on both sides.
#[track_caller]
fn assert_sharp(curve: &Curve, within: f64, probe: &dyn Fn([f64; 2]) -> Asked) {
    let points: Vec<[f64; 2]> = curve.points().collect();
    for n in 1..points.len() - 1 {
        let (a, b) = (points[n - 1], points[n + 1]);
        let size = (b[0] - a[0]).hypot(b[1] - a[1]);
        let left = [-(b[1] - a[1]) / size, (b[0] - a[0]) / size];
        let beside = |off: f64| {
            let at = [points[n][0] + off * left[0], points[n][1] + off * left[1]];
            probe(at).expect("a state").0
        };
        assert_eq!((beside(within), beside(-within)), (curve.left, curve.right));
    }
}

/// Intersections of curves with the line of equibiaxial stretches.
fn equal_stretches(
    boundary: &Boundary,
    probe: &(dyn Fn([f64; 2]) -> Asked + Sync),
    window: Window,
) -> Vec<f64> {
    let mut found = Vec::new();
    for curve in &boundary.curves {
        let points: Vec<[f64; 2]> = curve.points().collect();
        for pair in points.windows(2) {
            let off = |p: [f64; 2]| p[0] - p[1];
            if off(pair[0]) * off(pair[1]) < 0.0 || off(pair[0]) == 0.0 {
                let near = 0.5 * (pair[0][0] + pair[0][1]);
                let at = onset::verdict::boundary::located_between(
                    window,
                    probe,
                    [near - 0.1; 2],
                    [near + 0.1; 2],
                );
                found.extend(at.expect("states").map(|point| point[0]));
            }
        }
    }
    found.sort_by(f64::total_cmp);
    found
}

#[test]
fn ellipticity_is_lost_and_regained_on_two_curves_in_a_wide_window() {
    let material = ModifiedMooneyRivlin::default();
    let (window, probe) = (square(0.5, 16.0), of_material(&material));
    let boundary = trace(window, 96, &probe);
    assert!(boundary.is_complete(), "{:?}", boundary.unresolved);
    assert_eq!(boundary.curves.len(), 2);
    for curve in &boundary.curves {
        assert_eq!(curve.ends, Some([End::Edge; 2]));
        assert!(curve.accuracy() < 1e-10);
        assert_sharp(curve, 1e-10, &probe);
    }
    let crossings = equal_stretches(&boundary, &probe, window);
    assert_eq!(crossings.len(), 2, "{crossings:?}");
    assert!((crossings[0] - 1.669_770_460_567_403_3).abs() < 1e-10);
    assert!((crossings[1] - 8.720_585_647_956_307).abs() < 1e-10);
}

#[test]
fn the_boundary_of_blatz_and_ko_is_two_straight_lines() {
    let material = BlatzKo::default();
    let boundary = trace(square(0.2, 4.0), 96, &of_material(&material));
    assert_eq!(boundary.curves.len(), 2);
    let gamma = 2.0 - 3.0_f64.sqrt();
    for curve in &boundary.curves {
        for [a, b] in curve.points() {
            let off = (b - gamma * a).abs().min((a - gamma * b).abs());
            assert!(off < 1e-10, "({a}, {b}) is off by {off}");
        }
        assert_eq!(curve.corners().count(), 0);
    }
}

#[test]
fn the_boundary_of_a_lagrangian_kernel_is_the_boundary_of_the_material() {
    let material = ModifiedMooneyRivlin::default();
    let method = Method::<2>::new(KernelMethodChoices::default()).expect("a method");
    let window = square(0.6, 2.4);
    let probe = Survey::new(&method, &material).expect("finite");
    let (exact, computed) = (of_material(&material), of_particles(&probe));
    let [of_material, of_particles] = [trace(window, 32, &exact), trace(window, 32, &computed)];
    assert_eq!(of_material.curves.len(), of_particles.curves.len());
    // Every vertex of the computed boundary lies on the exact boundary to 1e-9, and every vertex of the exact boundary on the computed one.
    for (curves, probe) in [
        (&of_particles.curves, &exact as &dyn Fn([f64; 2]) -> Asked),
        (&of_material.curves, &computed),
    ] {
        for curve in curves {
            assert_sharp(curve, 1e-9, probe);
        }
    }
    let lines = |boundary: &Boundary| -> Vec<Vec<[f64; 2]>> {
        boundary
            .curves
            .iter()
            .map(|curve| curve.points().collect())
            .collect()
    };
    let apart = directed_distance(&lines(&of_material), &lines(&of_particles), 1e-9);
    assert!(apart.expect("both").distance < 1e-4);
    let phases = |at| Ok::<_, String>([exact(at)?.0, computed(at)?.0]);
    let areas = areas(window, [&of_material, &of_particles], &phases).expect("states");
    assert!(
        areas.false_share() < 1e-4 && areas.suppressed_share() < 1e-4,
        "{areas:?}"
    );
    for n in 0..40 {
        let (sine, cosine) = (0.157 * f64::from(n)).sin_cos();
        let ray = ([1.0, 1.0], [cosine, sine]);
        let exact = onset_along(window, &of_material, &exact, ray).expect("states");
        let computed = onset_along(window, &of_particles, &computed, ray).expect("states");
        match (exact, computed) {
            (RayOnset::At(a), RayOnset::At(b)) => assert!((a - b).abs() < 1e-9, "{a} and {b}"),
            (a, b) => assert_eq!(a, b),
        }
    }
}

#[test]
fn the_areas_of_an_eulerian_kernel_agree_with_a_dense_map() {
    let material = ModifiedMooneyRivlin::default();
    let method = Method::<2>::new(KernelMethodChoices {
        frame: Frame::Eulerian,
        support: 1.9,
        current_lattice: CurrentLattice::Regular,
        linearization: Linearization::Exact,
        ..KernelMethodChoices::default()
    })
    .expect("a method");
    let window = square(0.5, 2.0);
    let probe = Survey::new(&method, &material).expect("finite");
    let (exact, computed) = (of_material(&material), of_particles(&probe));
    let boundaries = [trace(window, 32, &exact), trace(window, 32, &computed)];
    for boundary in &boundaries {
        assert!(boundary.is_complete(), "{:?}", boundary.unresolved);
    }
    let phases = |at| Ok::<_, String>([exact(at)?.0, computed(at)?.0]);
    let areas = areas(window, [&boundaries[0], &boundaries[1]], &phases).expect("states");
    assert!((areas.window - 2.25).abs() < 1e-12);
    let n = 60;
    let (mut elliptic, mut wrong) = (0.0, 0.0);
    for index in 0..n * n {
        let at = |i: usize| 0.5 + 1.5 * (i as f64 + 0.5) / n as f64;
        let f = state([at(index % n), at(index / n)]).expect("a state");
        let (verdict, _) = judge(&method, &material, &f).expect("a verdict");
        let response = material.response(&f).expect("finite");
        let is_elliptic = onset::continuum::Stiffness::<2>::of(&response).is_strongly_elliptic();
        elliptic += f64::from(u8::from(is_elliptic));
        wrong += f64::from(u8::from(
            is_elliptic && verdict == onset::verdict::Verdict::Numerical,
        ));
    }
    let cell = 2.25 / (n * n) as f64;
    // The error of counting cells is about their number along the boundary.
    assert!(
        (areas.elliptic - cell * elliptic).abs() < 0.01,
        "{} {}",
        areas.elliptic,
        cell * elliptic
    );
    assert!(
        (areas.false_instability - cell * wrong).abs() < 0.01,
        "{} {}",
        areas.false_instability,
        cell * wrong
    );
    assert!(areas.false_share() > 0.2);
}

#[test]
fn tracing_of_a_ragged_boundary_stops_with_a_note() {
    // A convected lattice with a support of fixed size: neighbors enter and leave it, and the boundary has many teeth.
    let material = ModifiedMooneyRivlin::default();
    let discretization = KernelMethodChoices {
        frame: Frame::Eulerian,
        current_lattice: CurrentLattice::Convected,
        linearization: Linearization::Exact,
        support: 1.6,
        ..KernelMethodChoices::default()
    };
    let method = Method::<2>::new(discretization).expect("a method");
    let probe = Survey::new(&method, &material).expect("finite");
    let asked = AtomicUsize::new(0);
    let particles = of_particles(&probe);
    let counted = |at: [f64; 2]| {
        asked.fetch_add(1, Ordering::Relaxed);
        particles(at)
    };
    let fineness = Fineness {
        cells: [16; 2],
        budget: 800,
        ..Fineness::default()
    };
    let boundary = trace_boundary(square(0.6, 1.4), &fineness, &counted).expect("states");
    assert!(!boundary.is_complete() && !boundary.unresolved.is_empty());
    let states = asked.into_inner();
    assert!(states < 15_000, "{states} states evaluated");
    // The vertices of the traced curves and the unresolved points lie on the boundary.
    let is_off = |[x, y]: [f64; 2]| {
        let around = |n: usize| {
            let (sine, cosine) = (0.1 + 0.785 * n as f64).sin_cos();
            particles([x + 1e-10 * cosine, y + 1e-10 * sine])
                .expect("a state")
                .0
        };
        let first = around(0);
        (1..8).all(|n| around(n) == first)
    };
    let regular = boundary.curves.iter().flat_map(|curve| &curve.vertices);
    let sharp = regular
        .filter(|vertex| !vertex.is_corner)
        .map(|vertex| vertex.point);
    assert_eq!(sharp.filter(|point| is_off(*point)).count(), 0);
    assert_eq!(
        boundary
            .unresolved
            .iter()
            .filter(|point| is_off(**point))
            .count(),
        0
    );
}
