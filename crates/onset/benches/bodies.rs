//! Time and memory per step of a body: a free, vibrating cube of particles, with total-Lagrangian SPH and a penalty or with updated SPH.
//!
//! `bodies SIDE STEPS` runs `STEPS` steps of a cube with `SIDE` particles along each edge and prints the memory per particle.
//! `bodies updated SIDE STEPS` runs updated SPH. `bench/bodies.py` measures time and memory from outside, alternating with other programs. `bodies
//! bandwidth` prints the memory bandwidth of all cores.

use onset::analysis::analysis;
use onset::kernel::Kernel;
use onset::kinematics::DeformationGradient;
use onset::lattice::LatticeKind;
use onset::material::Law;
use onset::method::KernelMethodChoices;
use onset::motion::{BodyMotion, BodyParticles, Shape, Start};
use onset::scheme::MethodChoices;
use onset::scheme::sph::{MomentumForm, TotalLagrangianChoices, UpdatedSphChoices};
use onset::scheme::stabilization::PenaltyForm;
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

fn shaken(body: &mut dyn BodyMotion, steps: u64) {
    // About a fifth of the critical time step; the largest frequency is not computed here.
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

/// Memory bandwidth of all cores in `a = b + 3 c` (the triad of STREAM), bytes per second read and written; the best of several runs.
fn bandwidth() -> f64 {
    /// Length of the array of one core: 64 MiB, larger than all caches.
    const COUNT: usize = 1 << 23;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let mut arrays: Vec<[Vec<f64>; 3]> = (0..cores)
        .map(|_| [0.0, 1.0, 2.0].map(|value| vec![value; COUNT]))
        .collect();
    let mut turn = || {
        let start = Instant::now();
        std::thread::scope(|scope| {
            for [a, b, c] in &mut arrays {
                scope.spawn(move || {
                    for ((a, b), c) in a.iter_mut().zip(&*b).zip(&*c) {
                        *a = b + 3.0 * c;
                    }
                    black_box(a);
                });
            }
        });
        (3 * COUNT * size_of::<f64>() * cores) as f64 / start.elapsed().as_secs_f64()
    };
    (0..10).map(|_| turn()).fold(0.0, f64::max)
}

fn lagrangian(particles: Box<KernelMethodChoices>) -> MethodChoices {
    let choices = TotalLagrangianChoices {
        kernel: Kernel::CubicSpline,
        radius: 2.01,
        penalty: 10.0,
        penalty_form: PenaltyForm::Smd,
        ..TotalLagrangianChoices::default()
    };
    MethodChoices::TotalLagrangianSph(particles, choices)
}

/// Updated SPH as in LAMMPS.
fn updated(particles: Box<KernelMethodChoices>) -> MethodChoices {
    let choices = UpdatedSphChoices {
        kernel: Kernel::CubicSpline,
        radius: 2.01,
        momentum: MomentumForm::Mean,
        ..UpdatedSphChoices::default()
    };
    MethodChoices::UpdatedSph(particles, choices)
}

fn main() {
    let is_asked = |word: &str| std::env::args().any(|own| own == word);
    if is_asked("bandwidth") {
        println!("{{\"bytes_per_second\": {:e}}}", bandwidth());
        return;
    }
    // Cargo adds its options to the arguments.
    let numbers: Vec<u64> = std::env::args()
        .filter_map(|own| own.parse().ok())
        .collect();
    let [side, steps] = numbers[..] else {
        eprintln!("expected the particles along a side of the cube, and steps: 40 100");
        return;
    };
    let particles = Box::new(KernelMethodChoices {
        lattice: LatticeKind::SimpleCubic,
        ..KernelMethodChoices::default()
    });
    let method = match is_asked("updated") {
        true => updated(particles),
        false => lagrangian(particles),
    };
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
