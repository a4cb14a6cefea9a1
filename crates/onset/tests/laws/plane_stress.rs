//! Plane stress: laws of sheets and bars compared with closed forms, compliances and finite differences.

use crate::table::{Random, delta, differentiated, of};
use nalgebra::{DMatrix, Matrix3, SMatrix, Vector2};
use onset::analysis::{acoustic_minimum_in, analysis};
use onset::certificate::Certainty;
use onset::criteria::{Lateral, Loading, LoadingPath, Mode, Range};
use onset::kinematics::DeformationGradient;
use onset::lattice::LatticeKind;
use onset::material::{
    Hyperelastic, Law, MaterialError, PlaneStress, ResponseEnclosure, SmallStrainStiffness,
    StrainEnergy, library,
};
use onset::method::KernelMethodChoices;
use onset::real::{Interval, Real};
use onset::scheme::{MethodChoices, sph::TotalLagrangianChoices};
use std::sync::Arc;

fn law(name: &str, given: &[(&str, f64)]) -> Arc<dyn Hyperelastic> {
    let law = Law::named(name).expect("a law");
    law.build(given).expect("admissible").into()
}

fn sheet(name: &str, given: &[(&str, f64)]) -> PlaneStress {
    PlaneStress::new(law(name, given), 2).expect("a sheet")
}

fn planar(f: [[f64; 2]; 2]) -> DeformationGradient {
    DeformationGradient::plane_strain(f, 1.0).expect("a state")
}

/// Neo-Hookean law with out-of-plane fibers, so that in-plane strains cause shears across the sheet.
struct Tilted;

impl StrainEnergy for Tilted {
    fn energy<R: Real>(&self, f: &DeformationGradient<R>) -> R {
        let c = f.right_cauchy_green();
        let a = [0.7, 0.3, (1.0_f64 - 0.58).sqrt()];
        let fourth = (0..9).fold(R::constant(0.0), |sum, n| {
            sum + c[n / 3][n % 3] * (a[n / 3] * a[n % 3])
        });
        let invariants = f.invariants();
        let volume = invariants.jacobian.ln();
        let stretched = fourth - 1.0;
        (invariants.first - 3.0) * 0.5 - volume
            + volume * volume * 0.75
            + stretched * stretched * 0.4
    }
}

/// Law that resists only changes of volume.
struct Fluid;

impl StrainEnergy for Fluid {
    fn energy<R: Real>(&self, f: &DeformationGradient<R>) -> R {
        let jacobian = f.invariants().jacobian;
        jacobian - jacobian.ln()
    }
}

/// All library laws that can describe a sheet, and the law with tilted fibers.
fn sheets() -> Vec<(&'static str, Arc<dyn Hyperelastic>, PlaneStress)> {
    let of_library = library().iter().filter_map(|own| {
        let law = law(own.name, &[]);
        let sheet = PlaneStress::new(Arc::clone(&law), 2).ok()?;
        Some((own.name, law, sheet))
    });
    let tilted: Arc<dyn Hyperelastic> = Arc::new(Tilted);
    let sheet = PlaneStress::new(Arc::clone(&tilted), 2).expect("a sheet");
    of_library.chain([("tilted", tilted, sheet)]).collect()
}

/// State with one in-plane component changed.
fn moved(f: &DeformationGradient, k: usize, l: usize, by: f64) -> DeformationGradient {
    of(&(f.matrix() + Matrix3::from_fn(|a, b| delta(a, k) * delta(b, l)) * by))
}

const PLANE: [(usize, usize); 4] = [(0, 0), (0, 1), (1, 0), (1, 1)];

#[test]
fn the_thickness_of_a_neo_hookean_sheet_is_the_root_of_its_scalar_equation() {
    let (mu, lambda) = (1.3, 4.1);
    let sheet = sheet("neo-hooke", &[("mu", mu), ("lambda", lambda)]);
    for f in [
        [[1.4, 0.0], [0.0, 0.8]],
        [[0.5, 0.0], [0.0, 0.6]],
        [[3.0, 0.4], [-0.2, 2.0]],
        [[1.0, 1.7], [0.0, 1.0]],
    ] {
        let area = f[0][0] * f[1][1] - f[0][1] * f[1][0];
        // Traction times t, P33 t with P33 = mu (t - 1/t) + lambda ln(J)/t; it increases with t.
        let traction = |t: f64| mu * (t * t - 1.0) + lambda * (area * t).ln();
        let (mut low, mut high) = (1e-6, 1e3);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            *(if traction(middle) < 0.0 {
                &mut low
            } else {
                &mut high
            }) = middle;
        }
        let response = sheet.response(&planar(f)).expect("a state");
        let found = response.deformation.components()[2][2];
        assert!((found - low).abs() < 1e-13 * low, "{found} {low}");
        // In-plane components of P = mu (F - F^-T) + lambda ln J F^-T.
        let inverse = [[f[1][1], -f[1][0]], [-f[0][1], f[0][0]]];
        for (i, j) in PLANE {
            let own = mu * f[i][j] + (lambda * (area * low).ln() - mu) * inverse[i][j] / area;
            assert!((response.first_piola[(i, j)] - own).abs() < 1e-12);
        }
    }
}

/// Stiffness with zero stress in all strains except some: the inverse of the corresponding part of the compliance.
fn condensed<const N: usize>(
    stiffness: &SmallStrainStiffness,
    kept: [usize; N],
) -> SMatrix<f64, N, N> {
    let whole = DMatrix::from_fn(6, 6, |a, b| stiffness[a][b]);
    let compliance = whole.try_inverse().expect("a stiffness");
    let own = SMatrix::<f64, N, N>::from_fn(|a, b| compliance[(kept[a], kept[b])]);
    own.try_inverse().expect("a compliance")
}

#[test]
fn small_strain_stiffness_of_a_sheet_inverts_its_part_of_the_compliance() {
    let mut asked = 0;
    for own in library()
        .iter()
        .filter(|law| law.stressed_reference.is_none())
    {
        let Ok(sheet) = PlaneStress::new(law(own.name, &[]), 2) else {
            continue;
        };
        let stiffness = own.small_strain_stiffness(&[]).expect("admissible");
        let expected = condensed(&stiffness, [0, 1, 5]);
        let tangent = sheet.undeformed().expect("a reference").tangent;
        let place = |a: usize| [(0, 0), (1, 1), (0, 1)][a];
        for (a, b) in (0..9).map(|n| (n / 3, n % 3)) {
            let ((i, j), (k, l)) = (place(a), place(b));
            let error = tangent[(i, j, k, l)] - expected[(a, b)];
            assert!(
                error.abs() < 1e-11 * expected.amax(),
                "{}: {error:e}",
                own.name
            );
        }
        let bar = PlaneStress::new(law(own.name, &[]), 1).expect("a bar");
        let young = condensed(&stiffness, [0])[(0, 0)];
        let tangent = bar.undeformed().expect("a reference").tangent;
        assert!(
            (tangent[(0, 0, 0, 0)] - young).abs() < 1e-11 * young,
            "{}",
            own.name
        );
        asked += 1;
    }
    assert!(asked > 20, "{asked}");
    // Expected moduli: E/(1 - nu^2), nu E/(1 - nu^2) and E/(2 (1 + nu)) of a sheet, and E of a bar.
    let (young, poisson) = (3.0, 0.3);
    let mu = young / (2.0 * (1.0 + poisson));
    let lambda = 2.0 * mu * poisson / (1.0 - 2.0 * poisson);
    let given = [("mu", mu), ("lambda", lambda)];
    let tangent = sheet("neo-hooke", &given)
        .undeformed()
        .expect("a reference")
        .tangent;
    let plane = young / (1.0 - poisson * poisson);
    assert!((tangent[(0, 0, 0, 0)] - plane).abs() < 1e-14);
    assert!((tangent[(0, 0, 1, 1)] - poisson * plane).abs() < 1e-14);
    assert!((tangent[(0, 1, 0, 1)] - mu).abs() < 1e-14);
    let bar = PlaneStress::new(law("neo-hooke", &given), 1).expect("a bar");
    let tangent = bar.undeformed().expect("a reference").tangent;
    assert!((tangent[(0, 0, 0, 0)] - young).abs() < 1e-14);
}

#[test]
fn stress_and_tangent_of_every_sheet_are_derivatives_of_its_energy() {
    for (name, law, sheet) in sheets() {
        let mut random = Random::new(5);
        for _ in 0..4 {
            let f = random.planar_state(1.15);
            let response = sheet.response(&f).expect("a state");
            let scale = response.tangent.largest();
            // No traction on the faces, in the three-dimensional law at the computed state.
            let found = law.response(&response.deformation).expect("a state");
            for i in 0..3 {
                assert!(
                    found.first_piola[(i, 2)].abs() < 1e-13 * found.tangent.largest(),
                    "{name}"
                );
            }
            for (k, l) in PLANE {
                let at = |t: f64| sheet.response(&moved(&f, k, l, t)).expect("a state");
                let slope = differentiated(1e-3, |t| at(t).energy);
                let error = response.first_piola[(k, l)] - slope;
                assert!(
                    error.abs() < 1e-8 * scale,
                    "{name}: P{k}{l} is off by {error:e}"
                );
                for (i, j) in PLANE {
                    let slope = differentiated(1e-3, |t| at(t).first_piola[(i, j)]);
                    let error = response.tangent[(i, j, k, l)] - slope;
                    assert!(
                        error.abs() < 1e-7 * scale,
                        "{name}: A{i}{j}{k}{l} is off by {error:e}"
                    );
                }
            }
        }
    }
}

#[test]
fn out_of_plane_fibers_shear_a_sheet_across_its_plane() {
    let sheet = PlaneStress::new(Arc::new(Tilted), 2).expect("a sheet");
    let response = sheet
        .response(&planar([[1.3, 0.1], [0.0, 0.9]]))
        .expect("a state");
    let found = response.deformation.components();
    assert!(
        found[0][2].abs() > 0.01 && found[1][2].abs() > 0.001,
        "{found:?}"
    );
    // Traction-free faces have no Cauchy stress either, on all sides of the tensor.
    let cauchy = Tilted
        .response(&response.deformation)
        .expect("a state")
        .cauchy();
    assert!(cauchy.column(2).amax() < 1e-13 && cauchy.row(2).amax() < 1e-13);
}

#[test]
fn rotating_a_sheet_rotates_its_stress_and_keeps_its_thickness() {
    for (name, _, sheet) in sheets() {
        let mut random = Random::new(6);
        let (f, r) = (random.planar_state(1.15), random.planar_rotation());
        let own = sheet.response(&f).expect("a state");
        let turned = sheet.response(&of(&(r * f.matrix()))).expect("a state");
        let scale = own.tangent.largest();
        let error = (turned.first_piola - r * own.first_piola).amax();
        assert!(error < 1e-12 * scale, "{name}: {error:e}");
        let thickness =
            |response: &onset::material::Response| response.deformation.components()[2][2];
        assert!(
            (thickness(&own) - thickness(&turned)).abs() < 1e-12,
            "{name}"
        );
        for (i, j) in PLANE {
            for (k, l) in PLANE {
                let expected: f64 = PLANE
                    .iter()
                    .map(|(m, n)| r[(i, *m)] * r[(k, *n)] * own.tangent[(*m, j, *n, l)])
                    .sum();
                let error = turned.tangent[(i, j, k, l)] - expected;
                assert!(error.abs() < 1e-11 * scale, "{name}: {error:e}");
            }
        }
    }
}

#[test]
fn plane_stress_states_equal_loadings_with_a_free_third_face() {
    for name in ["neo-hooke", "blatz-ko", "saint-venant-kirchhoff", "yeoh"] {
        let (law, sheet) = (law(name, &[]), sheet(name, &[]));
        let range = Range::new(0.8, 1.5).expect("a range");
        for (mode, lateral) in [
            (Mode::Equibiaxial, Lateral::PlaneStress),
            (Mode::Planar, Lateral::PlaneStress),
            (Mode::SimpleShear, Lateral::PlaneStress),
            (Mode::Uniaxial, Lateral::Free),
            (Mode::SimpleShear, Lateral::Free),
        ] {
            let loading = Loading { mode, lateral };
            let of_space = LoadingPath::new(&*law, true, loading, &range).expect("a path");
            let of_sheet = LoadingPath::new(&sheet, false, loading, &range).expect("a path");
            for stretch in [0.85_f64, 1.2, 1.45] {
                let expected = of_space.at(stretch.ln()).expect("a state").response;
                let own = of_sheet.at(stretch.ln()).expect("a state").response;
                let error = (own.deformation.matrix() - expected.deformation.matrix()).amax();
                assert!(error < 1e-11, "{name} {loading:?} {stretch}: {error:e}");
                let error = (own.first_piola - expected.first_piola).amax();
                assert!(
                    error < 1e-10 * own.tangent.largest(),
                    "{name} {loading:?}: {error:e}"
                );
                let given = expected.deformation.given_in(2);
                let asked = sheet.response(&given).expect("a state");
                assert!(
                    (asked.cauchy() - expected.cauchy()).amax() < 1e-10 * own.tangent.largest()
                );
            }
        }
    }
}

/// Saint-Venant-Kirchhoff law with Poisson's ratio 0.49 and Young's modulus 1.
fn nearly_incompressible() -> (f64, f64) {
    let (young, poisson) = (1.0, 0.49);
    let mu = young / (2.0 * (1.0 + poisson));
    (mu, 2.0 * mu * poisson / (1.0 - 2.0 * poisson))
}

/// Loss of strong ellipticity of a law that is `lambda/2 (tr E)^2 + mu E:E` within the plane, compressed along one axis and held along the other, in
/// closed form: `sqrt(A1111 A2222) + sqrt(A1212 A2121) = A1122 + A1221`.
fn held_compression(lambda: f64, mu: f64) -> f64 {
    let margin = |stretch: f64| {
        let strain = 0.5 * (stretch * stretch - 1.0);
        let (first, second) = ((lambda + 2.0 * mu) * strain, lambda * strain);
        let a1111 = (lambda + 2.0 * mu) * stretch * stretch + first;
        let a2222 = lambda + 2.0 * mu + second;
        let (a1212, a2121) = (mu * stretch * stretch + second, mu + first);
        let cross = (lambda + mu) * stretch;
        if a1111.min(a2222).min(a1212).min(a2121) <= 0.0 {
            return -1.0;
        }
        (a1111 * a2222).sqrt() + (a1212 * a2121).sqrt() - cross
    };
    let (mut low, mut high) = (0.5, 1.0);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        *(if margin(middle) > 0.0 {
            &mut high
        } else {
            &mut low
        }) = middle;
    }
    high
}

#[test]
fn a_nearly_incompressible_sheet_stays_elliptic_where_plane_strain_loses_ellipticity() {
    let (mu, lambda) = nearly_incompressible();
    // First constant of the sheet: E33 = -lambda/(lambda + 2 mu) (E11 + E22).
    let of_sheet = 2.0 * lambda * mu / (lambda + 2.0 * mu);
    let given = [("mu", mu), ("lambda", lambda)];
    let (law, sheet) = (
        law("saint-venant-kirchhoff", &given),
        sheet("saint-venant-kirchhoff", &given),
    );
    let onset = |material: &dyn Hyperelastic, expected: f64| {
        let minimum = |stretch: f64| {
            let f = planar([[stretch, 0.0], [0.0, 1.0]]);
            acoustic_minimum_in(2, material, &f)
                .expect("a state")
                .eigenvalue
                .re
        };
        assert!(
            minimum(expected + 1e-6) > 0.0,
            "{}",
            minimum(expected + 1e-6)
        );
        assert!(
            minimum(expected - 1e-6) < 0.0,
            "{}",
            minimum(expected - 1e-6)
        );
    };
    let (strain, stress) = (held_compression(lambda, mu), held_compression(of_sheet, mu));
    assert!(strain > 0.95, "{strain}");
    assert!((stress - 0.7338).abs() < 5e-5, "{stress}");
    onset(&*law, strain);
    onset(&sheet, stress);
}

#[test]
fn a_sheet_has_no_state_beyond_zero_thickness() {
    let (mu, lambda) = (1.0, 3.0);
    let sheet = sheet("saint-venant-kirchhoff", &[("mu", mu), ("lambda", lambda)]);
    // C33 = 1 - lambda/(lambda + 2 mu) (C11 + C22 - 2) vanishes at C11 + C22 = 2 + 5/3.
    let limit = (1.0 + 5.0_f64 / 6.0).sqrt();
    let at = |stretch: f64| sheet.response(&planar([[stretch, 0.0], [0.0, stretch]]));
    let response = at(limit - 1e-3).expect("a thin sheet");
    let expected = (1.0 - 0.6 * 2.0 * ((limit - 1e-3).powi(2) - 1.0)).sqrt();
    assert!((response.deformation.components()[2][2] - expected).abs() < 1e-10);
    let error = at(limit + 1e-3).expect_err("no sheet");
    assert!(error.leaves_undefined(), "{error}");
    let MaterialError::PlaneStressEnds { reached, .. } = error else {
        panic!("{error}");
    };
    assert!(
        (reached - (limit - 1.0) / (limit + 1e-3 - 1.0)).abs() < 2e-3,
        "{reached}"
    );
}

#[test]
fn fluids_and_three_dimensions_have_no_plane_stress() {
    let refused = |law, dimension| match PlaneStress::new(law, dimension) {
        Err(MaterialError::NoPlaneStress { reason }) => reason,
        other => panic!("{:?}", other.err()),
    };
    assert!(refused(Arc::new(Fluid), 2).contains("as for a fluid"));
    assert!(refused(law("neo-hooke", &[]), 3).contains("three-dimensional"));
}

/// Returns true if a number is within bounds.
fn holds(bounds: Interval, value: f64) -> bool {
    // Stresses of the search are rounded, stresses of a proof are not.
    let slack = 1e-12 * (1.0 + value.abs());
    bounds.low - slack <= value && value <= bounds.high + slack
}

#[test]
fn enclosures_contain_stress_and_tangent_of_all_states_of_a_box() {
    let mut bounded = 0;
    for (name, law, sheet) in sheets() {
        let mut random = Random::new(7);
        for width in [0.0, 1e-9, 1e-4] {
            let f = random.planar_state(1.15);
            let bounds = DeformationGradient::from_components(std::array::from_fn(|i| {
                std::array::from_fn(|j| {
                    let value = f.components()[i][j];
                    Interval::new(value - width, value + width)
                })
            }));
            let enclosure = sheet.enclosure(&bounds);
            bounded += usize::from(enclosure != ResponseEnclosure::ENTIRE);
            for _ in 0..3 {
                let mut offset = Matrix3::zeros();
                PLANE
                    .iter()
                    .for_each(|place| offset[*place] = random.number() * width);
                let inside = f.matrix() + offset;
                let response = sheet.response(&of(&inside)).expect("a state");
                assert!(holds(enclosure.energy, response.energy), "{name}");
                for (i, j) in PLANE {
                    assert!(
                        holds(enclosure.first_piola[i][j], response.first_piola[(i, j)]),
                        "{name}"
                    );
                    for (k, l) in PLANE {
                        let value = response.tangent[(i, j, k, l)];
                        let own = enclosure.tangent[i][j][k][l];
                        assert!(holds(own, value), "{name}: {own:?} {value}");
                        if width < 1e-8 && own.is_finite() {
                            assert!(
                                own.width()
                                    < 1e-1 * law.response(&f).expect("a state").tangent.largest(),
                                "{name}: {own:?}"
                            );
                        }
                    }
                }
            }
        }
    }
    assert!(bounded > 60, "{bounded}");
}

fn sph() -> MethodChoices {
    let particles = KernelMethodChoices {
        lattice: LatticeKind::Square,
        ..KernelMethodChoices::default()
    };
    MethodChoices::TotalLagrangianSph(Box::new(particles), TotalLagrangianChoices::default())
}

#[test]
fn the_ellipticity_of_a_sheet_is_proved_on_both_sides_of_its_loss() {
    let (mu, lambda) = nearly_incompressible();
    let sheet = sheet("saint-venant-kirchhoff", &[("mu", mu), ("lambda", lambda)]);
    let analysis = analysis(&sph(), Arc::new(sheet)).expect("a method");
    let proof = |stretch: f64| {
        let f = planar([[stretch, 0.0], [0.0, 1.0]]);
        analysis.certify(&f, 1e-6).expect("a proof").material
    };
    assert!(matches!(proof(0.735), Certainty::Stable { bound } if bound > 0.0));
    assert!(matches!(proof(0.732), Certainty::Unstable { .. }));
}

#[test]
fn long_waves_of_particles_have_the_moduli_of_the_sheet() {
    let sheet: Arc<dyn Hyperelastic> =
        Arc::new(sheet("neo-hooke", &[("mu", 1.0), ("lambda", 8.0)]));
    let analysis = analysis(&sph(), Arc::clone(&sheet)).expect("a method");
    let f = planar([[1.2, 0.1], [0.0, 0.9]]);
    let waves = analysis.waves(&f).expect("waves");
    let tangent = sheet.response(&f).expect("a state").tangent;
    for angle in [0.0_f64, 0.7, 1.9] {
        let k = Vector2::new(angle.cos(), angle.sin()) * 1e-3;
        let q = SMatrix::<f64, 2, 2>::from_fn(|i, m| {
            let all = PLANE.iter();
            all.map(|(j, l)| tangent[(i, *j, m, *l)] * k[*j] * k[*l])
                .sum()
        });
        let mut expected: Vec<f64> = q.symmetric_eigenvalues().iter().copied().collect();
        expected.sort_by(f64::total_cmp);
        let found = waves.omega_squared(k.as_slice());
        for (found, expected) in found.iter().zip(expected) {
            // With corrected gradients the error is of second order in k h.
            assert!(
                (found.re - expected).abs() < 1e-5 * expected,
                "{found:?} {expected}"
            );
        }
    }
}

/// The sheet of an isochoric neo-Hookean law: `P_ij = mu (F_ij - F^-T_ij / J^2)` with the area ratio `J` of the plane, at any bulk modulus.
#[test]
fn a_sheet_of_an_isochoric_law_has_the_same_response_at_every_bulk_modulus() {
    let states = [
        [[1.3, 0.0], [0.0, 0.8]],
        [[2.5, 0.4], [-0.1, 1.4]],
        [[0.4, 0.1], [0.0, 0.7]],
    ];
    for decade in 6..=12 {
        let kappa = 10.0_f64.powi(decade);
        let sheet = sheet("neo-hooke-isochoric", &[("mu", 1.5), ("kappa", kappa)]);
        for [[a, b], [c, d]] in states {
            let stress = |[[a, b], [c, d]]: [[f64; 2]; 2]| {
                let area = a * d - b * c;
                let inverse = [[d / area, -c / area], [-b / area, a / area]];
                let own = [[a, b], [c, d]];
                let at = |i: usize, j: usize| 1.5 * (own[i][j] - inverse[i][j] / (area * area));
                [[at(0, 0), at(0, 1)], [at(1, 0), at(1, 1)]]
            };
            let response = sheet.response(&planar([[a, b], [c, d]]));
            let response = response.expect("a response");
            // A sheet with a smaller bulk modulus changes its volume.
            let tolerance = if kappa < 5e7 { 100.0 / kappa } else { 1e-9 };
            let expected = stress([[a, b], [c, d]]);
            for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                let apart = response.first_piola[(i, j)] - expected[i][j];
                let largest = tolerance * (1.0 + expected[i][j].abs());
                assert!(apart.abs() < largest, "{kappa} {i}{j} {apart}");
                // Central differences of the closed form.
                let step = 1e-5;
                for (k, l) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    let moved = |way: f64| {
                        let mut own = [[a, b], [c, d]];
                        own[k][l] += way;
                        stress(own)[i][j]
                    };
                    let slope = (moved(step) - moved(-step)) / (2.0 * step);
                    let apart = response.tangent[(i, j, k, l)] - slope;
                    let largest = (1e-6 + 10.0 * tolerance) * (1.0 + slope.abs());
                    assert!(apart.abs() < largest, "{kappa} {i}{j}{k}{l} {apart}");
                }
            }
        }
    }
}
