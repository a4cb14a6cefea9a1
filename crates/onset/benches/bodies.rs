//! What a step of a body costs: a free cube of particles that shakes, total-Lagrangian SPH with a penalty.
//!
//! `bodies SIDE STEPS` runs so many steps of a cube with so many particles along each side, and prints what it kept for a particle. Its time and memory
//! are measured from outside, in turns with other programs: `bench/bodies.py`.

use onset::analysis::analysis;
use onset::kernel::Kernel;
use onset::kinematics::DeformationGradient;
use onset::lattice::LatticeKind;
use onset::material::Law;
use onset::method::KernelMethodChoices;
use onset::motion::{BodyMotion, BodyParticles, Shape, Start};
use onset::scheme::MethodChoices;
use onset::scheme::sph::TotalLagrangianChoices;
use onset::scheme::stabilization::PenaltyForm;
use std::sync::Arc;

fn shaken(body: &mut dyn BodyMotion, steps: u64) {
    // A fifth of what is stable: the largest frequency is not sought here.
    let step = 0.1;
    let start = Start {
        f: DeformationGradient::identity(),
        noise: 1e-4,
        seed: 1,
    };
    body.start(&start, step).expect("forces");
    for _ in 0..steps {
        body.advance(step).expect("a step");
    }
    println!(
        "{{\"particles\": {}, \"bytes_per_particle\": {}}}",
        body.positions().len(),
        body.bytes_per_particle()
    );
}

fn main() {
    // Cargo adds options of its own.
    let numbers: Vec<u64> = std::env::args()
        .filter_map(|own| own.parse().ok())
        .collect();
    let [side, steps] = numbers[..] else {
        eprintln!("expected the particles along a side of the cube, and steps: 40 100");
        return;
    };
    let particles = KernelMethodChoices {
        lattice: LatticeKind::SimpleCubic,
        ..KernelMethodChoices::default()
    };
    let choices = TotalLagrangianChoices {
        kernel: Kernel::CubicSpline,
        radius: 2.01,
        penalty: 10.0,
        penalty_form: PenaltyForm::Smd,
        ..TotalLagrangianChoices::default()
    };
    let method = MethodChoices::TotalLagrangianSph(Box::new(particles), choices);
    let law = Law::named("neo-hooke").expect("a law");
    let material = Arc::from(law.build(&[]).expect("a material"));
    let method = analysis(&method, material).expect("a method");
    let cube = BodyParticles::Cut(Shape::Block {
        size: vec![side as f64; 3],
        hole: None,
        notch: None,
    });
    method
        .with_body(&cube, &[], None, &mut |body| shaken(body, steps))
        .expect("a body");
}
