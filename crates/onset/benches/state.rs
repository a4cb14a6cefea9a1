//! Computation time of one state: response of the material, dynamical matrix, search over the zone, and directions in three dimensions.

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::{Matrix2, Vector2};
use onset::bloch::{ZoneSearch, dynamical_matrix};
use onset::certificate::certify_3d;
use onset::continuum::Stiffness;
use onset::kinematics::DeformationGradient;
use onset::lattice::{BravaisLattice, Crystal};
use onset::material::{BlatzKo, Hyperelastic, ModifiedMooneyRivlin};
use onset::method::{CurrentLattice, Frame, KernelMethodChoices, Linearization, Method};
use onset::scheme::Discretization;
use onset::scheme::kernel::{CrystalQuadrature, KernelChoices, KernelScheme};
use onset::scheme::sph::{
    TotalLagrangianChoices, TotalLagrangianSph, UpdatedSph, UpdatedSphChoices,
};
use onset::verdict::{assess, judge, speed_squared};
use std::hint::black_box;

fn states(criterion: &mut Criterion) {
    let material = ModifiedMooneyRivlin::default();
    let f = DeformationGradient::from_stretches([0.97, 0.93, 1.0]).expect("stretches");
    criterion.bench_function("response", |bencher| {
        bencher.iter(|| material.response(black_box(&f)))
    });
    for (name, frame, lattice, linearization) in [
        (
            "lagrangian",
            Frame::Lagrangian,
            CurrentLattice::Convected,
            Linearization::Exact,
        ),
        (
            "eulerian convected exact",
            Frame::Eulerian,
            CurrentLattice::Convected,
            Linearization::Exact,
        ),
        (
            "eulerian regular paper",
            Frame::Eulerian,
            CurrentLattice::Regular,
            Linearization::Paper,
        ),
    ] {
        let discretization = KernelMethodChoices {
            frame,
            current_lattice: lattice,
            linearization,
            ..KernelMethodChoices::default()
        };
        let method = Method::<2>::new(discretization).expect("a method");
        let matrix = dynamical_matrix(&method, &material, &f).expect("a matrix");
        let speed_squared = speed_squared(&method, &material).expect("a scale");
        let search = ZoneSearch::new(&method, &f, speed_squared).expect("a search");
        let mut group = criterion.benchmark_group(name);
        group.bench_function("dynamical matrix", |bencher| {
            bencher.iter(|| dynamical_matrix(&method, &material, black_box(&f)));
        });
        group.bench_function("stability", |bencher| {
            bencher.iter(|| search.stability(black_box(&matrix)))
        });
        group.bench_function("judge", |bencher| {
            bencher.iter(|| judge(&method, &material, black_box(&f)))
        });
        group.bench_function("assess", |bencher| {
            bencher.iter(|| assess(&method, &material, black_box(&f)))
        });
        group.finish();
    }
}

/// Smallest acoustic eigenvalue over all directions in three dimensions.
fn directions(criterion: &mut Criterion) {
    let laws: [(&str, Box<dyn Hyperelastic>); 2] = [
        ("law (5)", Box::new(ModifiedMooneyRivlin::default())),
        ("Blatz-Ko", Box::new(BlatzKo::new(1.0).expect("a modulus"))),
    ];
    let principal = [[1.3, 0.0, 0.0], [0.0, 0.8, 0.0], [0.0, 0.0, 1.0]];
    let sheared = [[1.3, 0.2, -0.1], [0.1, 0.8, 0.3], [-0.2, 0.1, 1.0]];
    let mut group = criterion.benchmark_group("directions in three dimensions");
    for (name, law) in &laws {
        for (axes, components) in [("principal axes", principal), ("any axes", sheared)] {
            let f = DeformationGradient::new(components).expect("a state");
            let stiffness = Stiffness::<3>::of(&law.response(&f).expect("finite"));
            group.bench_function(format!("minimum, {name}, {axes}"), |bencher| {
                bencher.iter(|| black_box(&stiffness).minimum());
            });
            group.bench_function(format!("ellipticity, {name}, {axes}"), |bencher| {
                bencher.iter(|| black_box(&stiffness).is_strongly_elliptic());
            });
            group.bench_function(format!("proof, {name}, {axes}"), |bencher| {
                bencher.iter(|| certify_3d(&**law, black_box(&f), 1e-6));
            });
        }
    }
    group.finish();
}

/// States of cells with one and with two particles that are primitive.
fn cells(criterion: &mut Criterion) {
    let material = ModifiedMooneyRivlin::default();
    let f = DeformationGradient::from_stretches([0.97, 0.93, 1.0]).expect("stretches");
    let radius = 1.6;
    for sites in [1, 2] {
        let vectors = Matrix2::new(f64::from(sites), 0.0, 0.0, 1.0);
        let lattice = BravaisLattice::new(vectors).expect("a lattice");
        let places = [Vector2::zeros(), Vector2::new(0.48, 0.03)];
        let places = places[..sites as usize].to_vec();
        let crystal = Crystal::new(lattice, places).expect("a crystal");
        let kernel = |frame: Frame| {
            let choices = KernelChoices {
                radius,
                frame,
                ..KernelChoices::default()
            };
            KernelScheme::new(crystal.clone(), CrystalQuadrature::Nodal, choices).expect("a method")
        };
        let total = TotalLagrangianChoices {
            radius,
            ..TotalLagrangianChoices::default()
        };
        let updated = UpdatedSphChoices {
            radius,
            ..UpdatedSphChoices::default()
        };
        let methods: [(&str, Box<dyn Discretization<2>>); 4] = [
            ("Lagrangian kernel", Box::new(kernel(Frame::Lagrangian))),
            ("Eulerian kernel", Box::new(kernel(Frame::Eulerian))),
            (
                "total-Lagrangian SPH",
                Box::new(TotalLagrangianSph::new(crystal.clone(), total).expect("a method")),
            ),
            (
                "updated SPH",
                Box::new(UpdatedSph::new(crystal.clone(), updated).expect("a method")),
            ),
        ];
        let mut group = criterion.benchmark_group(format!("cells of {sites}"));
        for (name, method) in &methods {
            group.bench_function(*name, |bencher| {
                bencher.iter(|| assess(&**method, &material, black_box(&f)))
            });
        }
        group.finish();
    }
}

criterion_group!(benches, states, cells, directions);
criterion_main!(benches);
