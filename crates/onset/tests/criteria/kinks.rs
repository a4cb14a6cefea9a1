//! Kinks of laws along loadings.

use onset::criteria::{Lateral, Loading, LoadingPath, Mode, Range, is_isotropic, kinks};
use onset::material::Law;

fn found(name: &str, mode: Mode, lateral: Lateral) -> Vec<f64> {
    let law = Law::named(name)
        .expect("a law")
        .build(&[])
        .expect("defaults");
    let range = Range::new(0.5, 2.0).expect("a range");
    let loading = Loading { mode, lateral };
    let path = LoadingPath::new(&*law, is_isotropic(&*law), loading, &range).expect("a path");
    kinks(&path).iter().map(|kink| kink.stretch).collect()
}

#[test]
fn smooth_laws_have_no_kinks() {
    for name in [
        "blatz-ko",
        "ogden",
        "holzapfel-gasser-ogden",
        "gent",
        "hencky",
        "cubic-crystal",
    ] {
        for (mode, lateral) in [
            (Mode::Uniaxial, Lateral::Held),
            (Mode::Equibiaxial, Lateral::PlaneStrain),
            (Mode::Hydrostatic, Lateral::Held),
        ] {
            assert_eq!(found(name, mode, lateral), [], "{name} {mode:?}");
        }
    }
}

/// Tension-only fibers switch on where their isochoric stretch is 1: in the reference configuration, and in uniaxial strain where
/// `J^(-2/3) (lambda^2 cos^2 + sin^2) = 1` is satisfied a second time, if the angle permits.
#[test]
fn tension_only_fibers_have_kinks_where_they_switch() {
    let stretches = found(
        "holzapfel-gasser-ogden-switch",
        Mode::Uniaxial,
        Lateral::Held,
    );
    assert!(stretches.contains(&1.0), "{stretches:?}");
    let cosine = 29.0_f64.to_radians().cos().powi(2);
    for l in stretches {
        let strain = l.powf(-2.0 / 3.0) * (l * l * cosine + 1.0 - cosine) - 1.0;
        assert!(strain.abs() < 1e-9, "{l}: {strain}");
    }
}
