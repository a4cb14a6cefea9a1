//! Models of felupe that are not among the rubber models with published stresses.

use crate::{STATES, agrees, invariants, read, told};
use onset::kinematics::DeformationGradient;
use onset_study::settings::Program::Felupe;

/// Values of `P11`, `P21`, `P33` at the first state as computed by felupe 11.3.0.
#[test]
fn other_models_have_the_stresses_of_felupe() {
    let volume = "& fem.Volumetric(bulk=50.0)";
    for (text, expected) in [
        (
            format!("fem.Hyperelastic(fem.anssari_benam_bucchi, mu=0.29, N=26.8) {volume}"),
            [7.461703052696782, -0.8471058916518712, 8.591792921342396],
        ),
        (
            format!(
                "fem.Hyperelastic(fem.lopez_pamies, mu=[0.2699, 0.02], alpha=[1.08, 4.4]) {volume}"
            ),
            [7.461104963486842, -0.8468786959336901, 8.59193297064149],
        ),
        (
            "fem.Hyperelastic(fem.blatz_ko, mu=1.0)".to_owned(),
            [0.763457961991042, -0.20034335047248253, 0.29040450572136345],
        ),
        (
            "fem.Hyperelastic(fem.saint_venant_kirchhoff, mu=1.0, lmbda=20.0)".to_owned(),
            [6.513, -1.14275, 5.39925],
        ),
        (
            "fem.NeoHookeCompressible(mu=1.0, lmbda=2.0)".to_owned(),
            [0.6204951172355249, -0.135610568581725, 0.37544405180854745],
        ),
    ] {
        let f = DeformationGradient::new(STATES[0]).expect("a state");
        let stress = read(Felupe, &text, &[])
            .response(&f)
            .expect("finite")
            .first_piola;
        for (place, expected) in [(0, 0), (1, 0), (2, 2)].into_iter().zip(expected) {
            let found = stress[place];
            assert!(
                (found - expected).abs() < 1e-12,
                "{found} is not {expected}: {text}"
            );
        }
    }
}

/// felupe perturbs eigenvalues and the invariant of `van_der_waals`; the energies agree with its documentation.
#[test]
fn hencky_and_van_der_waals_have_the_documented_energies() {
    let text = "fem.Hyperelastic(fem.saint_venant_kirchhoff, mu=1.0, lmbda=20.0, k=0)";
    agrees(&*read(Felupe, text, &[]), |f| {
        let logarithms = f.principal_stretches().map(f64::ln);
        let trace: f64 = logarithms.iter().sum();
        logarithms.iter().map(|h| h * h).sum::<f64>() + 10.0 * trace * trace
    });
    let text = "fem.Hyperelastic(fem.van_der_waals, mu=1.0, beta=0.1, a=0.5, limit=5.0) & fem.Volumetric(bulk=50)";
    agrees(&*read(Felupe, text, &[]), |f| {
        let (i1, i2, j, _) = invariants(f);
        let i = 0.9 * i1 + 0.1 * i2 - 3.0;
        let h = (i / 22.0).sqrt();
        -22.0 * ((1.0 - h).ln() + h) - (i / 2.0).powf(1.5) / 3.0 + 25.0 * (j - 1.0).powi(2)
    });
    assert!(told(Felupe, text, None).contains("adds 1e-4"));
}

#[test]
fn models_without_an_equivalent_energy_are_refused_with_the_reason() {
    for (text, fact) in [
        (
            "\nfem.Hyperelastic(fem.alexander, C1=17, C2=19.85, C3=1, gamma=0.735, k=0.00015)",
            "a deck:2:1: alexander of felupe is not supported: its energy is an integral",
        ),
        (
            "fem.MaterialAD(fem.morph, p=[1])",
            "a deck:1:1: morph of felupe is not supported: its stress depends on the history",
        ),
        (
            "fem.Hyperelastic(fem.miehe_goektepe_lulei, mu=0.1)",
            "an average over the directions of a sphere",
        ),
        (
            "fem.Hyperelastic(fem.saint_venant_kirchhoff, mu=1.0, lmbda=2.0, k=1)",
            "a deck:1:1: k is 1; expected 2",
        ),
        (
            "fem.Hyperelastic(fem.anssari_benam_bucchi, mu=1.0, N=0.5)",
            "a deck:1:1: N is 0.5",
        ),
    ] {
        let error = told(Felupe, text, None);
        assert!(error.contains(fact), "{text}: {error}");
    }
}
