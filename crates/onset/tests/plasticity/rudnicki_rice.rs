//! J. W. Rudnicki and J. R. Rice, *J. Mech. Phys. Solids* 23 (1975) 371: critical modulus and band angle in closed form.

use crate::Numbers;
use nalgebra::{Matrix3, Vector3};
use onset::plasticity::{BandKind, Criterion, Critical, DruckerPrager, Hardening};

/// State with intermediate deviatoric stress `N tau`, `tau = 1`, largest first.
fn deviatoric(n: f64) -> [f64; 3] {
    let half = (1.0 - 0.75 * n * n).max(0.0).sqrt();
    [-0.5 * n + half, n, -0.5 * n - half]
}

/// Critical modulus `h_cr/G` of the paper.
fn formula(nu: f64, beta: f64, mu: f64, n: f64) -> f64 {
    (1.0 + nu) / (9.0 * (1.0 - nu)) * (beta - mu).powi(2)
        - 0.5 * (1.0 + nu) * (n + (beta + mu) / 3.0).powi(2)
}

/// Variable `xi` of the paper: the deviatoric stress on the band divided by `tau`.
fn xi(nu: f64, beta: f64, mu: f64, n: f64) -> f64 {
    (1.0 + nu) * (beta + mu) / 3.0 - n * (1.0 - nu)
}

fn critical(nu: f64, beta: f64, mu: f64, n: f64, frame: &Matrix3<f64>) -> Critical {
    let strength = Hardening::linear(1.0, 0.0);
    let law = DruckerPrager::new(2.0, nu, mu, beta, strength).expect("a law");
    let principal = Vector3::from(deviatoric(n)).add_scalar(-0.7);
    let stress = frame * Matrix3::from_diagonal(&principal) * frame.transpose();
    law.rate_moduli(&stress, 0.0)
        .and_then(|moduli| moduli.critical(Criterion::Ellipticity))
        .expect("a critical state")
}

fn grid(mut call: impl FnMut(f64, f64, f64, f64)) {
    for nu in [-0.3, 0.0, 0.1, 0.2, 0.3, 0.4, 0.49] {
        for beta in [-0.8, -0.3, 0.0, 0.2, 0.5, 0.9] {
            for mu in [0.0, 0.2, 0.4, 0.6, 0.9, 1.4] {
                // The bulk modulus must not make the law snap back.
                if 1.0 + mu * beta * 2.0 * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu)) <= 0.1 {
                    continue;
                }
                for step in -6..=6 {
                    let n = f64::from(step) / 6.0 / 3.0_f64.sqrt();
                    call(nu, beta, mu, n);
                }
            }
        }
    }
}

#[test]
fn critical_modulus_and_angle_match_the_paper_if_its_angle_exists() {
    let mut numbers = Numbers(1);
    let mut count = 0;
    grid(|nu, beta, mu, n| {
        let [major, _, minor] = deviatoric(n);
        let xi = xi(nu, beta, mu, n);
        if !(minor..=major).contains(&xi) {
            return;
        }
        count += 1;
        let critical = critical(nu, beta, mu, n, &numbers.rotation());
        let expected = formula(nu, beta, mu, n);
        let found = critical.modulus / 2.0;
        assert!(
            (found - expected).abs() < 1e-12,
            "{nu} {beta} {mu} {n}: {found} {expected}"
        );
        assert!(critical.bound / 2.0 - found < 1e-9);
        let angle = ((xi - minor) / (major - xi)).sqrt().atan().to_degrees();
        assert!(
            (critical.band.angle_to_minor - angle).abs() < 1e-5,
            "{nu} {beta} {mu} {n}: {} {angle}",
            critical.band.angle_to_minor
        );
    });
    assert!(count > 1500, "{count}");
}

#[test]
fn beyond_the_range_of_its_angle_the_band_is_normal_to_a_principal_stress_and_the_formula_too_large()
 {
    let mut count = 0;
    grid(|nu, beta, mu, n| {
        let [major, _, minor] = deviatoric(n);
        let xi = xi(nu, beta, mu, n);
        if (minor - 1e-6..=major + 1e-6).contains(&xi) {
            return;
        }
        count += 1;
        let critical = critical(nu, beta, mu, n, &Matrix3::identity());
        assert!(critical.modulus / 2.0 < formula(nu, beta, mu, n));
        let (kind, angle) = if xi > major {
            (BandKind::DilationBand, 90.0)
        } else {
            (BandKind::CompactionBand, 0.0)
        };
        assert_eq!(critical.band.kind, kind, "{nu} {beta} {mu} {n}");
        assert!((critical.band.angle_to_minor - angle).abs() < 1e-9);
    });
    assert!(count > 50, "{count}");
}

#[test]
fn von_mises_in_pure_shear_localizes_at_zero_hardening_at_45_degrees() {
    for nu in [0.0, 0.2, 0.3, 0.45] {
        let critical = critical(nu, 0.0, 0.0, 0.0, &Matrix3::identity());
        assert!(critical.modulus.abs() < 1e-13, "{}", critical.modulus);
        assert!((critical.band.angle_to_major - 45.0).abs() < 1e-6);
        assert_eq!(critical.band.kind, BandKind::ShearBand);
    }
}

#[test]
fn the_example_of_the_paper_favors_extension_over_compression() {
    // nu = 0.3, mu = 0.6, beta = 0.3: localization during hardening in plane strain only.
    let at = |n: f64| critical(0.3, 0.3, 0.6, n, &Matrix3::identity()).modulus / 2.0;
    let end = 1.0 / 3.0_f64.sqrt();
    assert!(
        at(end) < at(-end),
        "axisymmetric compression needs more softening than extension"
    );
    let best = critical(0.3, 0.3, 0.6, -0.3, &Matrix3::identity());
    let expected = 1.3 / 6.3 * 0.09;
    assert!(
        (best.modulus / 2.0 - expected).abs() < 1e-14,
        "the maximum over N is at -(beta + mu)/3"
    );
}

#[test]
fn thin_sheets_neck_in_the_direction_of_hill() {
    // R. Hill, J. Mech. Phys. Solids 1 (1952) 19: 54.7 degrees between neck and tension, where the neck does not stretch.
    let strength = Hardening::linear(1.0, 0.0);
    for nu in [0.0, 0.3, 0.45] {
        let metal = DruckerPrager::von_mises(100.0, nu, strength).expect("a law");
        let tension = Matrix3::from_diagonal(&Vector3::new(3.0_f64.sqrt(), 0.0, 0.0));
        let neck = metal
            .rate_moduli(&tension, 0.0)
            .map(|moduli| moduli.in_sheet())
            .and_then(|moduli| moduli.critical(Criterion::Ellipticity))
            .expect("a neck");
        assert!(neck.modulus.abs() < 1e-11, "{}", neck.modulus);
        let inclination = 90.0 - neck.band.angle_to_major;
        let expected = 2.0_f64.sqrt().atan().to_degrees();
        assert!((inclination - expected).abs() < 1e-6, "{inclination}");
    }
}
