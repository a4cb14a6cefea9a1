//! What a step of a body costs: a free cube of particles that shakes, total-Lagrangian SPH with a penalty, or updated SPH.
//!
//! `bodies SIDE STEPS` runs so many steps of a cube with so many particles along each side, and prints what it kept for a particle; `bodies updated SIDE STEPS`
//! those of updated SPH. Time and memory are measured from outside, in turns with other programs: `bench/bodies.py`. `bodies bandwidth` prints what the memory
//! delivers to all cores.

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

/// Bytes a second that all cores together read and write in `a = b + 3 c` (the triad of STREAM), the best of some turns.
fn bandwidth() -> f64 {
    /// Numbers of an array of one core: 64 MiB, beyond all caches.
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

/// Total-Lagrangian SPH with a penalty.
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

/// The updated SPH that LAMMPS has too.
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
    // Cargo adds options of its own.
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
