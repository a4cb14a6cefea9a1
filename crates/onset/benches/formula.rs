//! Evaluation time of an energy entered as a formula, against the built-in law with the same energy, and time to parse the formula.

use criterion::{Criterion, criterion_group, criterion_main};
use onset::formula::{Formula, FormulaLaw};
use onset::kinematics::DeformationGradient;
use onset::material::{BlatzKo, Hyperelastic, ModifiedMooneyRivlin};
use onset::real::Interval;
use std::hint::black_box;

const MOONEY: &str = "c1/2*I1 + c2/2*I2 - 3/2*c1*I3^(1/3) - 3/2*c2*I3^(2/3) + lambda/4*ln(I3)^2";
const BLATZ_KO: &str = "mu/2*(I2/I3 + 2*sqrt(I3) - 5)";

fn law(text: &str, values: &[(&str, f64)]) -> FormulaLaw {
    let formula = Formula::parse(text).expect("a formula");
    formula.with(values).expect("values for all")
}

fn responses(criterion: &mut Criterion) {
    let mooney_values = [("c1", 0.1256), ("c2", 0.01012), ("lambda", 10.12)];
    let laws: [(&str, Box<dyn Hyperelastic>, FormulaLaw); 2] = [
        (
            "equation (5)",
            Box::new(ModifiedMooneyRivlin::default()),
            law(MOONEY, &mooney_values),
        ),
        (
            "Blatz-Ko",
            Box::new(BlatzKo::default()),
            law(BLATZ_KO, &[("mu", 32.0)]),
        ),
    ];
    let f = [[1.1, 0.2, 0.0], [-0.1, 0.9, 0.0], [0.0, 0.0, 1.0]];
    let wide = f.map(|row| row.map(|x| Interval::new(x - 1e-6, x + 1e-6)));
    let wide = DeformationGradient::from_components(wide);
    let f = DeformationGradient::new(f).expect("a state");
    for (name, built_in, typed) in &laws {
        let mut group = criterion.benchmark_group(*name);
        for (kind, law) in [("built-in", built_in.as_ref()), ("typed", typed)] {
            group.bench_function(format!("response, {kind}"), |bencher| {
                bencher.iter(|| law.response(black_box(&f)))
            });
            group.bench_function(format!("plane tangent, {kind}"), |bencher| {
                bencher.iter(|| law.plane_tangent(black_box(&f)))
            });
            group.bench_function(format!("enclosure, {kind}"), |bencher| {
                bencher.iter(|| law.enclosure(black_box(&wide)))
            });
        }
        group.finish();
    }
    criterion.bench_function("read a formula", |bencher| {
        bencher.iter(|| law(black_box(MOONEY), &mooney_values))
    });
}

criterion_group!(benches, responses);
criterion_main!(benches);
