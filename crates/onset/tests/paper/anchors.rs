//! Comparison of the program with the independently computed reference numbers whose names define them completely, section by section.

use crate::reference::{
    anchors, assert_meets, lagrangian, material, method, number, numbers, stretched, with_frame,
};
use nalgebra::{Vector2, vector};
use onset::algebra::Complex;
use onset::approximation::Order;
use onset::bloch::{ZoneSearch, dynamical_matrix, gradient_norm};
use onset::kinematics::{DeformationGradient, StraightPath};
use onset::lattice::BrillouinZone;
use onset::method::{Background, KernelMethodChoices};
use onset::quadrature::QuadraturePoint;
use onset::verdict::{Phase, Survey, assess, scan_discretization, scan_material, speed_squared};
use std::f64::consts::{PI, TAU};

/// Search over the zone of a method at a state.
fn search_of(
    method: &onset::method::Method<2>,
    material: &dyn onset::material::Hyperelastic,
    f: &DeformationGradient,
) -> ZoneSearch<2> {
    let speed_squared = speed_squared(method, material).expect("a scale");
    ZoneSearch::new(method, f, speed_squared).expect("a search")
}

#[test]
fn stresses_and_effective_tangents_agree_with_the_reference() {
    let anchors = anchors();
    for (key, name) in [
        ("material_F_1.2_0.9_mooney", "mooney"),
        ("material_F_1.2_0.9_blatzko_mu1", "blatzko1"),
    ] {
        let response = material(name)
            .response(&stretched(1.2, 0.9))
            .expect("finite");
        let (s, sigma) = (response.second_piola(), response.cauchy());
        let (nominal, spatial) = (
            response.effective_tangent(),
            response.effective_cauchy_tangent(),
        );
        let entries = anchors[key].as_object().expect("a table");
        assert_eq!(entries.len(), 16);
        for (component, reference) in entries {
            let digits: Vec<usize> = component
                .chars()
                .filter_map(|c| c.to_digit(10))
                .map(|d| d as usize - 1)
                .collect();
            let computed = match (component.trim_end_matches(char::is_numeric), &digits[..]) {
                ("S", &[i, j]) => s[(i, j)],
                ("sig", &[i, j]) => sigma[(i, j)],
                ("Cb", &[j, i, k, l]) => nominal[(j, i, k, l)],
                ("CE", &[i, j, k, l]) => spatial[(i, j, k, l)],
                _ => panic!("unknown component {component}"),
            };
            assert_meets(component, computed, number(reference), 1e-9);
        }
    }
}

fn crossings(from: [f64; 2], to: [f64; 2]) -> Vec<f64> {
    let path =
        StraightPath::new(stretched(from[0], from[1]), stretched(to[0], to[1])).expect("a path");
    let scan = scan_material::<2>(&*material("mooney"), &path).expect("a scan");
    scan.crossings
        .iter()
        .map(|crossing| crossing.parameter())
        .collect()
}

#[test]
fn the_boundary_of_strong_ellipticity_agrees_with_the_reference() {
    let anchors = anchors();
    for (l1, reference) in anchors["pde_boundary_mooney_lambda2_of_lambda1"]
        .as_object()
        .expect("a table")
    {
        let (l1, l2) = (l1.parse::<f64>().expect("a stretch"), number(reference));
        let (low, high) = (0.5 * l2, 1.5 * l2);
        let s = crossings([l1, low], [l1, high]);
        assert_meets(
            &format!("lambda1 = {l1}"),
            low + s[0] * (high - low),
            l2,
            1e-10,
        );
    }
    let s = crossings([1.0, 1.0], [12.0, 12.0]);
    assert_meets(
        "equibiaxial onset",
        1.0 + 11.0 * s[0],
        number(&anchors["pde_equibiaxial_mooney"]),
        1e-10,
    );
    let restored = number(&anchors["pde_equibiaxial_restab_mooney"]);
    assert_meets("equibiaxial return", 1.0 + 11.0 * s[1], restored, 1e-10);
    assert_eq!(s.len(), 2);
    // The volume ratio J0 with g''(J0) = 0, which uniaxial states of large lambda1 approach; closed form of the book.
    let (c1, c2, lambda) = (0.1256, 0.01012, 10.12);
    let j0 = number(&anchors["pde_J0_mooney"]);
    let g2 = c2 + c1 / 3.0 * f64::powf(j0, -4.0 / 3.0) - 2.0 / 3.0 * c2 * f64::powf(j0, -2.0 / 3.0)
        + 2.0 * lambda * (1.0 - f64::ln(j0)) / (j0 * j0);
    assert!(g2.abs() < 1e-12);
    let onset = |l1: f64| crossings([l1, 0.5 * j0 / l1], [l1, 1.5 * j0 / l1])[0];
    let distance = |l1: f64| (0.5 * j0 + onset(l1) * j0 - j0).abs();
    assert!(
        distance(100.0) < 1e-4 && distance(1000.0) < 1e-6,
        "{} {}",
        distance(100.0),
        distance(1000.0)
    );
}

#[test]
fn kernel_sums_and_completeness_errors_agree_with_the_reference() {
    for (key, reference) in anchors()["kernel"].as_object().expect("a table") {
        let (kind, support) = key.split_once('_').expect("lattice_support");
        let support: f64 = support.parse().expect("a support");
        let method = method(lagrangian(kind, "sp", support));
        let configuration = method
            .configuration(&DeformationGradient::identity(), Order::First)
            .expect("a configuration");
        for (point, suffix) in [
            (&configuration.points[0], "node"),
            (&configuration.points[1], "sp"),
        ] {
            let positions: Vec<Vector2<f64>> = point
                .cells
                .iter()
                .map(|cell| {
                    method.lattice().vectors()
                        * (vector![f64::from(cell[0]), f64::from(cell[1])] - point.place)
                })
                .collect();
            assert_eq!(
                point.cells.len() as f64,
                number(&reference[&format!("n{suffix}")]),
                "{key} {suffix}"
            );
            let alpha: f64 = positions
                .iter()
                .zip(&point.shape.gradients)
                .map(|(x, gradient)| x[0] * gradient[0])
                .sum();
            assert_meets(
                "alpha",
                alpha,
                number(&reference[&format!("alpha_{suffix}")]),
                1e-9,
            );
            // The sum S of the weights follows from phi = W / S at any neighbor.
            let q = positions[0].norm() / support;
            let weight = (1.0 - q).powi(3) * (1.0 + 3.0 * q);
            let sum = weight / point.shape.values[0];
            assert_meets("S", sum, number(&reference[&format!("S_{suffix}")]), 1e-9);
        }
    }
}

/// Both real values of `omega^2` at a reference wave vector.
fn omega_squared(
    discretization: KernelMethodChoices,
    name: &str,
    f: &DeformationGradient,
    k: Vector2<f64>,
) -> [Complex; 2] {
    let matrix =
        dynamical_matrix(&method(discretization), &*material(name), f).expect("a dynamical matrix");
    matrix.omega_squared(&k)
}

fn assert_spectrum(key: &str, computed: [Complex; 2], reference: &[f64], tolerance: f64) {
    for (value, reference) in computed.iter().zip(reference) {
        assert_meets(key, value.re, *reference, tolerance);
        assert!(value.im.abs() < 1e-9, "{key}: {value}");
    }
}

#[test]
fn zero_energy_modes_of_lagrangian_kernels_agree_with_the_reference() {
    for (key, reference) in anchors()["rank_F_1.1_0.95_mooney"]
        .as_object()
        .expect("a table")
    {
        let k = match key
            .split_once('_')
            .and_then(|(_, rest)| rest.split_once('_'))
            .expect("a point")
            .1
        {
            "M1 (0, 2pi/sqrt3)" => vector![0.0, TAU / 3.0_f64.sqrt()],
            "M2 (pi, pi/sqrt3)" => vector![PI, PI / 3.0_f64.sqrt()],
            "K (4pi/3, 0) theta=0" => vector![4.0 * PI / 3.0, 0.0],
            "(2pi,0)=M theta=0" => vector![TAU, 0.0],
            "X (pi,0)" => vector![PI, 0.0],
            "M (pi,pi) theta=pi/4" => vector![PI, PI],
            point => panic!("unknown point {point}"),
        };
        let mut parts = key.split('_');
        let kind = parts.next().expect("a lattice");
        let support: f64 = parts
            .next()
            .and_then(|s| s.parse().ok())
            .expect("a support");
        for quadrature in ["nodal", "sp"] {
            let discretization = lagrangian(kind, quadrature, support);
            let computed = omega_squared(discretization, "mooney", &stretched(1.1, 0.95), k);
            assert_spectrum(key, computed, &numbers(&reference[quadrature]), 1e-9);
        }
    }
}

#[test]
fn spectra_of_all_methods_at_one_state_agree_with_the_reference() {
    let anchors = anchors();
    let table = anchors["omega2_F_1.2_0.9_k_2.0_1.1"]
        .as_object()
        .expect("a table");
    assert_eq!(table.len(), 256);
    let k = vector![2.0, 1.1];
    let f = stretched(1.2, 0.9);
    for (key, reference) in table {
        let parts: Vec<&str> = key.split('|').collect();
        let base = lagrangian(parts[1], parts[2], parts[3].parse().expect("a support"));
        let (geometry, linearization) = (parts.get(5).unwrap_or(&""), parts.get(6).unwrap_or(&""));
        let discretization = with_frame(base, parts[4], geometry, linearization);
        // The reference gives spatial wave vectors for Eulerian kernels on the convected lattice.
        let k = if geometry.ends_with("stretched") {
            f.leading::<2>().transpose() * k
        } else {
            k
        };
        let computed = omega_squared(discretization, parts[0], &f, k);
        assert_spectrum(key, computed, &numbers(reference), 1e-9);
    }
}

#[test]
fn quadrature_without_an_inversion_center_needs_the_complex_matrix() {
    let base = method(lagrangian("hex", "sp", 2.0));
    let points = base.quadrature_points();
    let up_only = vec![
        points[0],
        QuadraturePoint {
            volume: 2.0 * points[1].volume,
            ..points[1]
        },
    ];
    let method = base.clone().with_quadrature_points(up_only);
    let f = stretched(1.2, 0.9);
    let matrix = dynamical_matrix(&method, &*material("mooney"), &f).expect("a dynamical matrix");
    assert!(!matrix.is_centrosymmetric());
    let k = vector![2.0, 1.1];
    let reference = anchors()["no_inversion"]["up_only_hex_2.0_F_1.2_0.9"].clone();
    assert_spectrum(
        "up only",
        matrix.omega_squared(&k),
        &numbers(&reference["exact"]),
        1e-9,
    );
    let cosines = matrix.at(&k).map(|entry| Complex::new(entry.re, 0.0));
    let cosines = onset::algebra::eigenvalues(&cosines, matrix.noise());
    assert_spectrum("cosines only", cosines, &numbers(&reference["cos"]), 1e-9);
}

#[test]
fn eulerian_spectra_at_zero_energy_modes_agree_with_the_reference() {
    let anchors = anchors();
    let table = anchors["euler_at_spurious"].as_object().expect("a table");
    assert_eq!(table.len(), 288);
    for (key, reference) in table {
        let parts: Vec<&str> = key.split('|').collect();
        let k = match (parts[0], parts[4]) {
            ("hex", "M1") => vector![0.0, TAU / 3.0_f64.sqrt()],
            ("hex", "K") => vector![4.0 * PI / 3.0, 0.0],
            ("square", "X") => vector![PI, 0.0],
            ("square", "M") => vector![PI, PI],
            point => panic!("unknown point {point:?}"),
        };
        let stretch: f64 = parts[3].parse().expect("a stretch");
        let base = lagrangian(parts[0], parts[1], parts[2].parse().expect("a support"));
        let discretization = with_frame(base, "euler", parts[5], parts[6]);
        let computed = omega_squared(discretization, "mooney", &stretched(stretch, stretch), k);
        let reference = numbers(reference);
        if (reference[0] - reference[1]).abs() < 1e-6 * reference[0].abs() {
            // A double eigenvalue: the reference contains the square root of rounding, its mean does not.
            let mean = 0.5 * (reference[0] + reference[1]);
            assert_meets(key, 0.5 * (computed[0].re + computed[1].re), mean, 1e-9);
            assert_meets(key, computed[1].re - computed[0].re + 1.0, 1.0, 1e-6);
        } else {
            assert_spectrum(key, computed, &reference, 1e-9);
        }
    }
}

#[test]
fn the_long_wave_shear_stiffness_of_eulerian_kernels_agrees_with_the_reference() {
    let anchors = anchors();
    let table = anchors["euler_longwave_shear_w2_over_k2"]
        .as_object()
        .expect("a table");
    assert_eq!(table.len(), 180);
    for (key, reference) in table {
        let parts: Vec<&str> = key.split('|').collect();
        let base = lagrangian("hex", parts[0], parts[3].parse().expect("a support"));
        let discretization = with_frame(base, "euler", "regular", parts[1]);
        let stretch: f64 = parts[2].parse().expect("a stretch");
        let f = stretched(stretch, stretch);
        let matrix =
            dynamical_matrix(&method(discretization), &*material("mooney"), &f).expect("a matrix");
        let shear = matrix
            .long_wave_stiffness()
            .acoustic_tensor(&vector![1.0, 0.0])[(1, 1)];
        // The reference took the limit at a small finite wave number.
        assert!(
            (shear - number(reference)).abs() < 1e-6 * shear.abs().max(0.1),
            "{key}: {shear} {reference}"
        );
    }
}

#[test]
fn the_equibiaxial_onset_with_the_interpolated_background_agrees_with_the_reference() {
    for (support, reference) in anchors()["pointwiseF_equibiaxial"]
        .as_object()
        .expect("a table")
    {
        let (support, reference) = (
            support.parse::<f64>().expect("a support"),
            number(reference),
        );
        let base = lagrangian("hex", "sp", support);
        let method = method(KernelMethodChoices {
            background: Background::Interpolated,
            ..base
        });
        let material = material("mooney");
        // The reference is the onset for long waves, whose measure vanishes there.
        let measure = |stretch: f64| {
            let f = stretched(stretch, stretch);
            let matrix = dynamical_matrix(&method, &*material, &f).expect("a matrix");
            search_of(&method, &*material, &f)
                .long_wave_limit(&matrix)
                .scaled
        };
        let slope = (measure(reference + 1e-4) - measure(reference - 1e-4)) / 2e-4;
        assert!(
            (measure(reference) / slope).abs() < 1e-9 * reference,
            "D_mx {support}"
        );

        let path = StraightPath::new(stretched(1.5, 1.5), stretched(1.8, 1.8)).expect("a path");
        let scan = {
            let survey = Survey::new(&method, &*material).expect("a survey");
            scan_discretization(&survey, &path).expect("a scan")
        };
        let onset = 1.5 + 0.3 * scan.crossings[0].parameter();
        // Shorter waves can be unstable earlier: if the stress points carry a larger stretch than the nodes, they reach the limit of the material
        // first, and at K the nodes have no stiffness.
        let alpha = |place: &str| number(&anchors()["kernel"][format!("hex_{support:.1}")][place]);
        let witness = if alpha("alpha_sp") > alpha("alpha_node") {
            1.0 + (number(&anchors()["pde_equibiaxial_mooney"]) - 1.0) / alpha("alpha_sp")
        } else {
            reference
        };
        assert_meets(&format!("D_mx {support}"), onset, witness, 1e-9);
    }
}

#[test]
fn rank_gap_and_deficient_supports_of_stress_points_agree_with_the_reference() {
    let anchors = anchors();
    let reference_state = DeformationGradient::identity();
    for (support, reference) in anchors["rank_gap_hex_sp"].as_object().expect("a table") {
        let method = method(lagrangian("hex", "sp", support.parse().expect("a support")));
        let norm = gradient_norm(&method, &reference_state).expect("a configuration");
        // Like the reference, divide by |k|^2 and search a refined grid.
        let zone = BrillouinZone::new(*method.lattice());
        let measure = |k: &Vector2<f64>| norm.at(k)[(0, 0)].re / k.norm_squared();
        let mut best = (f64::INFINITY, Vector2::zeros());
        for index in 1..96 * 96 {
            let k = zone.folded(&zone.wave_vector(&vector![
                f64::from(index / 96) / 96.0,
                f64::from(index % 96) / 96.0
            ]));
            if measure(&k) < best.0 {
                best = (measure(&k), k);
            }
        }
        let mut step = 0.05;
        while step > 1e-9 {
            let trial = [
                vector![step, 0.0],
                vector![-step, 0.0],
                vector![0.0, step],
                vector![0.0, -step],
            ]
            .map(|shift| best.1 + shift)
            .into_iter()
            .filter(|k| zone.contains(k, 1e-12))
            .map(|k| (measure(&k), k))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .expect("four trials");
            if trial.0 < best.0 {
                best = trial
            } else {
                step *= 0.5
            }
        }
        assert_meets(
            &format!("gap at D_mx {support}"),
            best.0,
            number(reference),
            1e-6,
        );
    }
    for support in numbers(&anchors["hex_sp_K_deficient_Dmx"]) {
        let norm = gradient_norm(&method(lagrangian("hex", "sp", support)), &reference_state)
            .expect("a norm");
        let at_k = norm.at(&vector![4.0 * PI / 3.0, 0.0])[(0, 0)].re;
        assert!(at_k.abs() < 1e-15, "D_mx {support}: {at_k:e}");
    }
}

#[test]
fn blatz_ko_frequencies_of_equibiaxial_states_agree_with_the_reference() {
    let material = material("blatzko1");
    for (support, reference) in anchors()["fig9_coefficients_mu1"]
        .as_object()
        .expect("a table")
    {
        let method = method(lagrangian("hex", "sp", support.parse().expect("a support")));
        for (point, k) in [
            ("M", vector![0.0, TAU / 3.0_f64.sqrt()]),
            ("K", vector![4.0 * PI / 3.0, 0.0]),
            ("pi,0", vector![PI, 0.0]),
            ("pi/2,0", vector![PI / 2.0, 0.0]),
        ] {
            let stretch = 1.7;
            let matrix = dynamical_matrix(&method, &*material, &stretched(stretch, stretch))
                .expect("a matrix");
            let reference = numbers(&reference[point]);
            for (value, reference) in matrix.omega_squared(&k).iter().zip(&reference) {
                // At K the eigenvalue is double and the reference contains the square root of rounding.
                let tolerance = if point == "K" { 1e-7 } else { 1e-9 };
                assert_meets(point, value.re * stretch.powi(4), *reference, tolerance);
            }
        }
        let identity = DeformationGradient::identity();
        let matrix = dynamical_matrix(&method, &*material, &identity).expect("a matrix");
        let search = search_of(&method, &*material, &identity);
        let maximum = search.summary(&matrix).maximum_omega.powi(2);
        // The reference is the maximum over a 96 x 96 grid: slightly below the computed maximum.
        let sampled = number(&reference["max over zone"]);
        assert!(
            maximum >= sampled * (1.0 - 1e-12) && maximum < sampled * 1.002,
            "{maximum} {sampled}"
        );
    }
}

#[test]
fn minima_over_the_zone_are_at_most_the_reference() {
    let anchors = anchors();
    let table = anchors["min_omega2_full_zone"]
        .as_object()
        .expect("a table");
    assert_eq!(table.len(), 45);
    let material = material("mooney");
    for (key, reference) in table {
        let parts: Vec<&str> = key.split('|').collect();
        let base = lagrangian("hex", "sp", parts[1].parse().expect("a support"));
        let discretization = if parts[0] == "euler" {
            with_frame(base, "euler", parts[2], parts[3])
        } else {
            base
        };
        let state = parts.last().expect("a state").trim_matches(['(', ')']);
        let (l1, l2) = state.split_once(", ").expect("two stretches");
        let f = stretched(
            l1.parse().expect("a stretch"),
            l2.parse().expect("a stretch"),
        );
        let method = method(discretization);
        let matrix = dynamical_matrix(&method, &*material, &f).expect("a matrix");
        let search = search_of(&method, &*material, &f);
        let lowest = search.summary(&matrix).lowest;
        let reference = number(&reference["w2"]);
        // Below 1e-13 the reference is the zero of k = 0: the state is stable.
        let reference = if reference.abs() < 1e-13 {
            0.0
        } else {
            reference
        };
        assert_meets(key, lowest.omega_squared.re, reference, 1e-6);
        assert!(
            lowest.omega_squared.re <= reference + 1e-9 * reference.abs(),
            "{key}: not the minimum"
        );
    }
}

/// Compares onsets from the reference state: the first divergence must agree with the reference, which searched for `Re omega^2 < 0`, or be nearer to
/// the reference state with a growing mode. Flutter may occur earlier. Returns the numbers of equal and of earlier onsets.
fn eulerian_onsets(name: &str) -> [usize; 2] {
    let anchors = anchors();
    let (mut met, mut earlier) = (0, Vec::new());
    for (key, reference) in anchors["euler_critical"].as_object().expect("a table") {
        let parts: Vec<&str> = key.split('|').collect();
        if parts[0] != name {
            continue;
        }
        let quadrature = if parts[3] == "True" { "sp" } else { "nodal" };
        let base = lagrangian(parts[1], quadrature, parts[2].parse().expect("a support"));
        let discretization = with_frame(base, "euler", parts[5], parts[6]);
        let (material, method) = (material(name), method(discretization));
        let (far, uniaxial) = match parts[7] {
            "biax+" => (3.0, false),
            "uni-x+" => (3.0, true),
            "biax-" => (0.2, false),
            "uni-x-" => (0.2, true),
            path => panic!("unknown path {path}"),
        };
        let state = |stretch: f64| stretched(stretch, if uniaxial { 1.0 } else { stretch });
        let path = StraightPath::new(state(1.0), state(far)).expect("a path");
        let scan = {
            let survey = Survey::new(&method, &*material).expect("a survey");
            scan_discretization(&survey, &path).expect("a scan")
        };
        let divergence = scan
            .crossings
            .iter()
            .find(|crossing| crossing.to == Phase::Unstable);
        let Some(onset) = divergence.map(|crossing| 1.0 + (far - 1.0) * crossing.parameter())
        else {
            assert!(reference.is_null(), "{key}: no onset");
            met += 1;
            continue;
        };
        if reference
            .as_f64()
            .is_some_and(|reference| (onset - reference).abs() <= 1e-9 * reference)
        {
            met += 1;
            continue;
        }
        let distance = |stretch: f64| (stretch - 1.0).abs();
        assert!(
            reference.is_null() || distance(onset) < distance(number(reference)),
            "{key}: {onset}"
        );
        let f = state(1.0 + (onset - 1.0) * (1.0 + 1e-6));
        let mode = assess(&method, &*material, &f)
            .expect("an assessment")
            .spectrum
            .lowest;
        let matrix = dynamical_matrix(&method, &*material, &f).expect("a matrix");
        let residual = matrix.at(&mode.wave_vector) * mode.polarization
            - mode.polarization * mode.omega_squared;
        assert!(
            mode.omega_squared.re < 0.0 && residual.norm() < 1e-9,
            "{key}: no witness"
        );
        earlier.push(format!("{key}: {onset:.10} (reference {reference})"));
    }
    println!("{}", earlier.join("\n"));
    [met, earlier.len()]
}

#[test]
fn eulerian_onsets_of_the_modified_mooney_rivlin_law_agree_with_the_reference() {
    assert_eq!(eulerian_onsets("mooney"), [40, 0]);
}

#[test]
fn eulerian_onsets_of_the_blatz_ko_law_agree_with_the_reference() {
    assert_eq!(eulerian_onsets("blatzko1"), [37, 3]);
}
