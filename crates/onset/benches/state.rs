//! What one state costs: the response of the material, the dynamical matrix, the search over the zone.

use criterion::{Criterion, criterion_group, criterion_main};
use onset::bloch::dynamical_matrix;
use onset::kinematics::DeformationGradient;
use onset::material::{Hyperelastic, ModifiedMooneyRivlin};
use onset::method::{CurrentLattice, Discretization, Frame, Linearization, Method};
use onset::verdict::{assess, judge, zone_search};
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
        let discretization = Discretization {
            frame,
            lattice,
            linearization,
            ..Discretization::default()
        };
        let method = Method::<2>::new(discretization).expect("a method");
        let matrix = dynamical_matrix(&method, &material, &f).expect("a matrix");
        let search = zone_search(&method, &material, &f).expect("a search");
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

criterion_group!(benches, states);
criterion_main!(benches);
