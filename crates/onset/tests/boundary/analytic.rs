//! Sets with a known boundary, with corners, crossings, islands and edges.

use onset::verdict::boundary::{Boundary, Curve, End, Fineness, Window, trace_boundary};
use onset::verdict::fidelity::{RayOnset, areas, onset_along};
use onset::verdict::{Phase, Probe};
use std::convert::Infallible;
use std::f64::consts::{PI, TAU};

const WINDOW: Window = Window {
    low: [-2.0, -2.0],
    high: [2.0, 2.0],
};

/// Phase that is stable where a measure is positive.
fn signed(measure: f64) -> Probe {
    let phase = if measure > 0.0 {
        Phase::Stable
    } else {
        Phase::Unstable
    };
    (phase, measure)
}

fn trace_in(window: Window, probe: impl Fn(f64, f64) -> Probe + Sync) -> Boundary {
    let probe = |[x, y]: [f64; 2]| Ok::<_, Infallible>(probe(x, y));
    match trace_boundary(window, &Fineness::default(), &probe) {
        Ok(boundary) => boundary,
        Err(never) => match never {},
    }
}

fn trace(probe: impl Fn(f64, f64) -> Probe + Sync) -> Boundary {
    trace_in(WINDOW, probe)
}

/// Checks that every vertex is a zero of the measure to 1e-10, and that the curve starts and ends exactly where it should.
#[track_caller]
fn assert_on(curve: &Curve, zero: impl Fn(f64, f64) -> f64) {
    for vertex in &curve.vertices {
        let [x, y] = vertex.point;
        assert!(zero(x, y).abs() < 1e-10, "{} at ({x}, {y})", zero(x, y));
        assert!(vertex.accuracy < 1e-9);
    }
    if curve.is_closed() {
        let ends = [curve.vertices.first(), curve.vertices.last()];
        assert_eq!(ends[0], ends[1]);
    }
}

/// The signed area that a closed curve encloses, positive when it runs counterclockwise.
fn area(curve: &Curve) -> f64 {
    let points: Vec<[f64; 2]> = curve.points().collect();
    let terms = points
        .windows(2)
        .map(|pair| pair[0][0] * pair[1][1] - pair[0][1] * pair[1][0]);
    0.5 * terms.sum::<f64>()
}

#[test]
fn a_circle_is_one_closed_smooth_curve_with_the_stable_side_on_its_left() {
    let boundary = trace(|x, y| signed(1.0 - x * x - y * y));
    let [curve] = &boundary.curves[..] else {
        panic!("{} curves", boundary.curves.len());
    };
    assert!(boundary.is_complete() && curve.is_closed());
    assert_on(curve, |x, y| x.hypot(y) - 1.0);
    assert_eq!((curve.left, curve.right), (Phase::Stable, Phase::Unstable));
    assert_eq!(curve.corners().count(), 0);
    assert!((area(curve) - PI).abs() < 4e-4, "{}", area(curve));
    assert!((curve.length() - TAU).abs() < 4e-4);
}

#[test]
fn chords_lie_within_the_required_distance_of_the_curve() {
    let boundary = trace(|x, y| signed(1.0 - x * x - y * y));
    for pair in boundary.curves[0].vertices.windows(2) {
        let middle = [0, 1].map(|i| 0.5 * (pair[0].point[i] + pair[1].point[i]));
        assert!((middle[0].hypot(middle[1]) - 1.0).abs() <= 1.05 * 4.0 * 1e-5);
    }
}

#[test]
fn a_boundary_is_followed_by_its_phases_alone() {
    let jump = |x: f64, y: f64| {
        if x * x + y * y < 1.0 {
            (Phase::Flutter, 0.3)
        } else {
            (Phase::Stable, 0.3)
        }
    };
    let boundary = trace(jump);
    assert_eq!(boundary.curves.len(), 1);
    assert_on(&boundary.curves[0], |x, y| x.hypot(y) - 1.0);
    // The curve runs clockwise: the stable side is outside.
    assert!((area(&boundary.curves[0]) + PI).abs() < 4e-4);
}

#[test]
fn the_corners_of_a_rotated_square_are_found_to_1e_9() {
    let (sine, cosine) = 0.3_f64.sin_cos();
    let turned = |x: f64, y: f64| (cosine * x + sine * y, cosine * y - sine * x);
    let measure = |x: f64, y: f64| {
        let (a, b) = turned(x - 0.1, y + 0.05);
        1.0 - a.abs().max(b.abs())
    };
    let boundary = trace(|x, y| signed(measure(x, y)));
    let [curve] = &boundary.curves[..] else {
        panic!("{} curves", boundary.curves.len());
    };
    assert!(curve.is_closed());
    assert_on(curve, measure);
    let corners: Vec<[f64; 2]> = curve.corners().collect();
    assert_eq!(corners.len(), 4, "{corners:?}");
    for [x, y] in corners {
        let (a, b) = turned(x - 0.1, y + 0.05);
        assert!(
            (a.abs() - 1.0).abs() < 1e-9 && (b.abs() - 1.0).abs() < 1e-9,
            "{a} {b}"
        );
    }
    // Between corners the edges are straight: the polygon is the square.
    assert!((area(curve) - 4.0).abs() < 1e-9);
}

#[test]
fn corners_between_curved_branches_are_found_to_1e_9_however_blunt() {
    // The common part of two discs, whose circles meet at an angle.
    for half in [0.9, 0.5, 0.1, 0.01] {
        let measure = |x: f64, y: f64| {
            let disc = |center: f64| 1.0 - (x - center).hypot(y);
            disc(half).min(disc(-half))
        };
        let boundary = trace(|x, y| signed(measure(x, y)));
        let [curve] = &boundary.curves[..] else {
            panic!("{} curves for {half}", boundary.curves.len());
        };
        assert!(curve.is_closed());
        assert_on(curve, measure);
        let mut corners: Vec<[f64; 2]> = curve.corners().collect();
        corners.sort_by(|a, b| a[1].total_cmp(&b[1]));
        assert_eq!(corners.len(), 2, "{half}: {corners:?}");
        let height = (1.0 - half * half).sqrt();
        for ([x, y], sign) in corners.into_iter().zip([-1.0, 1.0]) {
            let off = x.hypot(y - sign * height);
            assert!(off < 1e-9, "half distance {half}: corner off by {off}");
        }
    }
}

#[test]
fn a_sharp_tip_is_rounded() {
    // A wedge of 20 degrees that opens to the left.
    let slope = 10.0_f64.to_radians().tan();
    let measure = |x: f64, y: f64| (0.5 - x) * slope - y.abs();
    let boundary = trace(|x, y| signed(measure(x, y)));
    let [curve] = &boundary.curves[..] else {
        panic!("{} curves", boundary.curves.len());
    };
    assert_eq!(curve.ends, Some([End::Edge; 2]));
    let corners: Vec<[f64; 2]> = curve.corners().collect();
    assert_eq!(corners.len(), 1);
    assert!(
        (corners[0][0] - 0.5).hypot(corners[0][1]) < 1e-8,
        "{corners:?}"
    );
}

#[test]
fn every_component_is_found_exactly_once() {
    let measure = |x: f64, y: f64| {
        let disc = |center: f64, radius: f64| radius - (x - center).hypot(y);
        disc(-1.0, 0.6).max(disc(0.9, 0.8))
    };
    let boundary = trace(|x, y| signed(measure(x, y)));
    let mut areas: Vec<f64> = boundary.curves.iter().map(area).collect();
    areas.sort_by(f64::total_cmp);
    assert_eq!(areas.len(), 2);
    assert!((areas[0] - 0.36 * PI).abs() < 4e-4 && (areas[1] - 0.64 * PI).abs() < 4e-4);
    assert!(boundary.is_complete());
}

#[test]
fn the_two_curves_of_an_annulus_have_opposite_directions() {
    let boundary = trace(|x, y| signed((x.hypot(y) - 0.5) * (1.0 - x.hypot(y))));
    let mut areas: Vec<f64> = boundary.curves.iter().map(area).collect();
    areas.sort_by(f64::total_cmp);
    assert_eq!(areas.len(), 2);
    assert!((areas[0] + 0.25 * PI).abs() < 4e-4 && (areas[1] - PI).abs() < 4e-4);
}

#[test]
fn a_sliver_thinner_than_the_grid_is_found_by_the_dip_of_the_measure() {
    // A stable ring 2e-4 wide, in which no node of the grid lies.
    let boundary = trace(|x, y| signed(1e-4 - (x.hypot(y) - 1.013).abs()));
    let mut areas: Vec<f64> = boundary.curves.iter().map(area).collect();
    areas.sort_by(f64::total_cmp);
    assert_eq!(areas.len(), 2, "{areas:?}");
    assert!((areas[0] + PI * 1.0129_f64.powi(2)).abs() < 1e-3);
    assert!((areas[1] - PI * 1.0131_f64.powi(2)).abs() < 1e-3);
    assert!(boundary.is_complete());
}

#[test]
fn an_island_between_the_nodes_is_found_by_the_dip_of_the_measure() {
    let distance = |x: f64, y: f64| (x - 0.0417).hypot(y - 0.0391);
    let boundary = trace(|x, y| signed(distance(x, y) - 1e-3));
    let [curve] = &boundary.curves[..] else {
        panic!("{} curves", boundary.curves.len());
    };
    assert!(curve.is_closed());
    assert_on(curve, |x, y| distance(x, y) - 1e-3);
    assert!((area(curve) + 1e-6 * PI).abs() < 1e-7, "{}", area(curve));
}

#[test]
fn a_line_ends_exactly_on_the_edges_of_the_window() {
    let boundary = trace(|x, y| signed(y - 0.3 * x - 0.1));
    let [curve] = &boundary.curves[..] else {
        panic!("{} curves", boundary.curves.len());
    };
    assert_eq!(curve.ends, Some([End::Edge; 2]));
    // The stable side is above and on the left, so that the curve runs to the right.
    let ends: Vec<[f64; 2]> = curve.points().collect();
    let (first, last) = (ends[0], ends[ends.len() - 1]);
    assert_eq!((first[0], last[0]), (-2.0, 2.0));
    assert!((first[1] + 0.5).abs() < 1e-11 && (last[1] - 0.7).abs() < 1e-11);
    assert_on(curve, |x, y| y - 0.3 * x - 0.1);
}

#[test]
fn a_circle_that_leaves_the_window_is_cut_into_arcs() {
    let boundary = trace(|x, y| signed(2.2 - x.hypot(y)));
    assert_eq!(boundary.curves.len(), 4);
    for curve in &boundary.curves {
        assert_eq!(curve.ends, Some([End::Edge; 2]));
        assert_on(curve, |x, y| x.hypot(y) - 2.2);
        for [x, y] in [
            curve.vertices[0].point,
            curve.vertices[curve.vertices.len() - 1].point,
        ] {
            assert_eq!(x.abs().max(y.abs()), 2.0);
        }
    }
}

#[test]
fn curves_that_cross_end_or_turn_there_and_are_traced_once() {
    // A figure of eight (lemniscate): four sectors meet at the origin.
    let measure = |x: f64, y: f64| {
        let square = x * x + y * y;
        2.0 * (x * x - y * y) - square * square
    };
    let boundary = trace(|x, y| signed(measure(x, y)));
    let total: f64 = boundary.curves.iter().map(Curve::length).sum();
    // Half width a = sqrt 2: length 2 * 2.62205755... a, area a^2.
    let expected = 2.0 * 2.622_057_554_292_119 * 2.0_f64.sqrt();
    assert!((total - expected).abs() < 2e-3, "{total} is not {expected}");
    for curve in &boundary.curves {
        for [x, y] in curve.points() {
            assert!(measure(x, y).abs() < 1e-9);
        }
    }
    assert!(!boundary.curves.iter().any(|curve| {
        curve
            .ends
            .is_some_and(|ends| ends.contains(&End::Budget) || ends.contains(&End::Lost))
    }));
}

#[test]
fn straight_lines_that_cross_are_traced_once() {
    let boundary = trace(|x, y| signed((y - 0.2 * x) * (x + 0.3 * y - 0.1)));
    let total: f64 = boundary.curves.iter().map(Curve::length).sum();
    let expected = 4.0 * (1.0 + 0.04_f64).sqrt() + 4.0 * (1.0 + 0.09_f64).sqrt();
    // A curve that meets another curve ends within a fraction of a step.
    assert!((total - expected).abs() < 1e-4, "{total} is not {expected}");
}

#[test]
fn a_curve_ends_where_a_third_phase_begins() {
    let probe = |x: f64, y: f64| {
        if x > 0.513 {
            (Phase::Undefined, f64::NAN)
        } else {
            signed(y - 0.1 * x * x)
        }
    };
    let boundary = trace(probe);
    let curves: Vec<&Curve> = boundary.of_stability().collect();
    let [curve] = curves[..] else {
        panic!("{} curves", curves.len());
    };
    assert_eq!(curve.ends, Some([End::Edge, End::Phase(Phase::Undefined)]));
    let last = curve.vertices[curve.vertices.len() - 1].point;
    assert!((last[0] - 0.513).abs() < 1e-8, "{last:?}");
    // The edges of the undefined part are separate curves, which end at the end of the first curve.
    let others: Vec<&Curve> = boundary
        .curves
        .iter()
        .filter(|curve| curve.right == Phase::Undefined)
        .collect();
    assert_eq!(others.len(), 2);
    let total: f64 = others.iter().map(|curve| curve.length()).sum();
    assert!((total - 4.0).abs() < 1e-6, "{total}");
}

#[test]
fn boundaries_do_not_depend_on_the_units_of_the_parameters() {
    let window = Window {
        low: [-2e6, -2e-6],
        high: [2e6, 2e-6],
    };
    let boundary = trace_in(window, |x, y| signed(1.0 - (1e-6 * x).hypot(1e6 * y)));
    assert_eq!(boundary.curves.len(), 1);
    assert!((area(&boundary.curves[0]) - PI).abs() < 4e-4);
}

#[test]
fn a_window_of_one_phase_has_no_boundary() {
    assert_eq!(trace(|_, _| signed(1.0)), Boundary::default());
    assert_eq!(
        trace(|_, _| (Phase::Undefined, f64::NAN)),
        Boundary::default()
    );
}

#[test]
fn tracing_of_noise_ends_within_its_budget() {
    // The phases differ from point to point and form no regions.
    let scrambled = |x: f64, y: f64| {
        let bits = (x.to_bits() ^ y.to_bits().rotate_left(17)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        signed(if bits >> 63 == 0 { 1.0 } else { -1.0 })
    };
    let fineness = Fineness {
        cells: [6, 6],
        budget: 500,
        ..Fineness::default()
    };
    let probe = |[x, y]: [f64; 2]| Ok::<_, Infallible>(scrambled(x, y));
    let boundary = match trace_boundary(WINDOW, &fineness, &probe) {
        Ok(boundary) => boundary,
        Err(never) => match never {},
    };
    assert!(!boundary.is_complete());
}

#[test]
fn an_error_of_the_probe_ends_the_tracing() {
    let probe = |[x, _]: [f64; 2]| if x > 1.0 { Err("far") } else { Ok(signed(x)) };
    assert_eq!(
        trace_boundary(WINDOW, &Fineness::default(), &probe),
        Err("far")
    );
}

/// Chords enclose a slightly smaller area than the curve: between the tips of two sets that nearly coincide, the middle of a strip without chords may
/// still lie in one of them.
#[test]
fn nearly_equal_domains_have_small_area_and_distance() {
    for n in 0..12 {
        let turn = 0.1 * f64::from(n);
        let ellipse = |a: f64| {
            move |x: f64, y: f64| {
                let (u, v) = (
                    x * turn.cos() + y * turn.sin(),
                    y * turn.cos() - x * turn.sin(),
                );
                signed(1.0 - (u / a).powi(2) - (v / 0.7).powi(2))
            }
        };
        let (one, other) = (ellipse(1.3), ellipse(1.3 + 1e-6));
        let boundaries = [trace(one), trace(other)];
        let phases = |[x, y]: [f64; 2]| Ok::<_, Infallible>([one(x, y).0, other(x, y).0]);
        let Ok(areas) = areas(WINDOW, [&boundaries[0], &boundaries[1]], &phases);
        assert!((areas.window - 16.0).abs() < 1e-12);
        let exact = PI * 1.3 * 0.7;
        assert!((areas.elliptic - exact).abs() < 1e-3 * exact, "{areas:?}");
        let differing = areas.false_instability + areas.suppressed_instability;
        assert!(differing < 1e-3, "turned by {turn}: {areas:?}");
    }
}

/// First loss of stability along a ray, with the probe that traced the boundary.
fn along(
    probe: impl Fn(f64, f64) -> Probe + Sync,
    origin: [f64; 2],
    direction: [f64; 2],
) -> RayOnset {
    let boundary = trace(&probe);
    let probe = |[x, y]: [f64; 2]| Ok::<_, Infallible>(probe(x, y));
    match onset_along(WINDOW, &boundary, &probe, (origin, direction)) {
        Ok(onset) => onset,
        Err(never) => match never {},
    }
}

#[test]
fn a_ray_finds_the_exact_boundary_near_the_edge_of_the_window() {
    let radius = 1.9999;
    for n in 0..8 {
        let (sine, cosine) = (0.25 * PI * f64::from(n)).sin_cos();
        let circle = |x: f64, y: f64| signed(radius * radius - x * x - y * y);
        match along(circle, [0.0; 2], [cosine, sine]) {
            RayOnset::At(distance) => assert!((distance - radius).abs() < 1e-11, "{distance}"),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_ray_along_the_edge_of_the_window_meets_the_end_of_a_boundary() {
    for y in [-2.0, 2.0] {
        match along(|x, _| signed(0.3 - x), [-1.5, y], [1.0, 0.0]) {
            RayOnset::At(distance) => assert!((distance - 1.8).abs() < 1e-11, "{distance}"),
            other => panic!("{other:?}"),
        }
    }
}
