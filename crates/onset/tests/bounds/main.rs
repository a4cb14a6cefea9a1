use nalgebra::SVector;
use onset::kinematics::DeformationGradient;
use onset::lattice::{Arrangement, Crystal};
use onset::material::ModifiedMooneyRivlin;
use onset::scheme::Scheme;
use onset::scheme::element::{
    ElementChoices, ElementMass, ElementMesh, FiniteElements, Formulation, HourglassScale,
    Integration,
};
use onset::scheme::sph::{TotalLagrangianChoices, TotalLagrangianSph};
use onset::verdict::SchemeSurvey;
use std::time::Instant;

fn shown<const D: usize>(name: &str, scheme: &dyn Scheme<D>, f: &DeformationGradient) {
    let material = ModifiedMooneyRivlin::default();
    let survey = SchemeSurvey::new(scheme, &material).unwrap();
    let start = Instant::now();
    let s = survey.spectrum(f).unwrap();
    eprintln!(
        "{name}: {:?} softest {:e} bound {:e} difference {:e} long {:e} max {:e} at {:?}",
        start.elapsed(),
        s.softest.scaled,
        s.bound,
        s.softest.scaled - s.bound,
        s.long_wave.scaled,
        s.maximum_omega,
        s.softest.wave_vector
    );
}

#[test]
fn tried() {
    for stretch in [[1.0, 1.0, 1.0], [1.2, 0.9, 1.0], [1.5, 1.0, 1.0]] {
        let f = DeformationGradient::from_stretches(stretch).unwrap();
        for (name, arrangement) in [
            ("hexagonal", Arrangement::Hexagonal),
            ("honeycomb", Arrangement::Honeycomb),
        ] {
            let crystal = Crystal::<2>::of(arrangement, 1.0).unwrap();
            for penalty in [0.0] {
                let choices = TotalLagrangianChoices {
                    radius: 2.2,
                    penalty,
                    ..TotalLagrangianChoices::default()
                };
                let scheme = TotalLagrangianSph::new(crystal.clone(), choices).unwrap();
                shown(&format!("{name} {penalty} {stretch:?}"), &scheme, &f);
            }
        }
        let places = vec![
            SVector::<f64, 2>::zeros(),
            SVector::<f64, 2>::new(0.45, 0.1),
            SVector::<f64, 2>::new(0.5, 0.6),
        ];
        let lattice = Arrangement::Square.lattice::<2>(1.7).unwrap();
        let crystal = Crystal::new(lattice, places).unwrap();
        let scheme = TotalLagrangianSph::new(
            crystal,
            TotalLagrangianChoices {
                radius: 2.2,
                penalty: 0.0,
                ..TotalLagrangianChoices::default()
            },
        )
        .unwrap();
        shown(&format!("three {stretch:?}"), &scheme, &f);
        for mass in [ElementMass::Lumped, ElementMass::Consistent] {
            for mesh in ElementMesh::ALL[1..6].iter() {
                let choices = ElementChoices {
                    mesh: *mesh,
                    formulation: Formulation {
                        integration: Integration::Full,
                        hourglass_stiffness: 0.0,
                        hourglass_viscosity: 0.0,
                        hourglass_scale: HourglassScale::Gradients,
                        mass,
                    },
                    ..ElementChoices::default()
                };
                let Ok(scheme) = FiniteElements::<2>::new(&choices) else {
                    continue;
                };
                shown(&format!("{mesh:?} {mass:?} {stretch:?}"), &scheme, &f);
            }
        }
    }
}
#[test]
fn tried_in_space() {
    for stretch in [[1.0, 1.0, 1.0], [1.2, 0.9, 1.0]] {
        let f = DeformationGradient::from_stretches(stretch).unwrap();
        for (name, arrangement) in [
            ("sc", Arrangement::SimpleCubic),
            ("fcc", Arrangement::FaceCenteredCubic),
            ("hcp", Arrangement::HexagonalClosePacked),
        ] {
            let crystal = Crystal::<3>::of(arrangement, 1.0).unwrap();
            let choices = TotalLagrangianChoices {
                radius: 1.9,
                penalty: 0.0,
                ..TotalLagrangianChoices::default()
            };
            let scheme = TotalLagrangianSph::new(crystal.clone(), choices).unwrap();
            shown(&format!("{name} {stretch:?}"), &scheme, &f);
        }
    }
}
