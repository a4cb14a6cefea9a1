//! Critical time steps of bodies, compared with `validation/bodies.json`, which was computed independently with NumPy and SciPy.

use super::{block, with};
use nalgebra::SVector;
use onset::analysis::{Analysis, FiniteBodyGround, analysis};
use onset::approximation::Approximation;
use onset::kernel::Kernel;
use onset::kinematics::DeformationGradient;
use onset::lattice::LatticeKind;
use onset::material::{Hyperelastic, Law};
use onset::method::{Frame, KernelMethodChoices};
use onset::motion::{BodyParticles, Grip, Notch, Shape};
use onset::quadrature::Quadrature;
use onset::scheme::conforming::ConformingChoices;
use onset::scheme::element::{ElementChoices, ElementMesh};
use onset::scheme::sph::TotalLagrangianChoices;
use onset::scheme::{
    BondModel, Formulation, GridFunctions, GridMass, MaterialPointChoices, MethodChoices,
    PeridynamicsChoices, ZeroEnergyControl,
};
use onset::time_step::Integrator;
use serde_json::Value;
use std::sync::Arc;

/// Bodies of one method with their critical steps.
fn cases(of: &str) -> Vec<(Value, f64)> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../validation/bodies.json");
    let text = std::fs::read_to_string(path).expect("the reference");
    let all: Vec<Value> = serde_json::from_str(&text).expect("a document");
    let own = all.into_iter().filter(|case| case["method"] == of);
    own.map(|case| {
        let step = number(&case, "step");
        (case, step)
    })
    .collect()
}

fn number(case: &Value, name: &str) -> f64 {
    case[name]
        .as_f64()
        .unwrap_or_else(|| panic!("{name}: {case}"))
}

fn numbers(case: &Value, name: &str) -> Option<Vec<f64>> {
    let all = case[name].as_array()?;
    Some(all.iter().filter_map(Value::as_f64).collect())
}

/// Neo-Hookean law with Young's modulus 1.
fn law(nu: f64) -> Box<dyn Hyperelastic> {
    let law = Law::named("neo-hooke").expect("a law");
    let mu = 0.5 / (1.0 + nu);
    let lambda = 2.0 * mu * nu / (1.0 - 2.0 * nu);
    let material = law.build(&[("mu", mu), ("lambda", lambda)]);
    material.expect("a material")
}

fn made(case: &Value, method: &MethodChoices) -> Box<dyn Analysis> {
    let material = law(number(case, "poisson"));
    analysis(method, Arc::from(material)).expect("a method")
}

fn particles(case: &Value) -> Box<KernelMethodChoices> {
    let lattice = match numbers(case, "size").expect("sides").len() {
        2 => LatticeKind::Square,
        _ => LatticeKind::SimpleCubic,
    };
    Box::new(KernelMethodChoices {
        lattice,
        ..KernelMethodChoices::default()
    })
}

fn sph(case: &Value) -> Box<dyn Analysis> {
    let choices = TotalLagrangianChoices {
        kernel: Kernel::CubicSpline,
        radius: number(case, "support"),
        corrected: case["corrected"] == true,
        penalty: number(case, "penalty"),
        ..TotalLagrangianChoices::default()
    };
    made(
        case,
        &MethodChoices::TotalLagrangianSph(particles(case), choices),
    )
}

/// Stable step for finite bodies, and the reason why it is sufficient.
fn finite(method: &dyn Analysis) -> (f64, FiniteBodyGround) {
    let rest = DeformationGradient::identity();
    let lattice = method.critical_time_step(&rest, Integrator::CentralDifferences);
    let found = method.finite_bodies(&rest).expect("a state");
    let found = found.step(Integrator::CentralDifferences, lattice.expect("a step"));
    let found = found.expect("a bound");
    (found.time_step, found.ground)
}

#[test]
fn the_critical_step_of_a_body_follows_from_its_largest_eigenvalue() {
    for (case, step) in cases("sph") {
        let method = sph(&case);
        let size = numbers(&case, "size").expect("sides");
        let notch = numbers(&case, "notch").map(|own| Notch {
            depth: own[0],
            width: own[1],
        });
        let held = number(&case, "held");
        let mut high = size.clone();
        high[1] = held;
        let grips = match held > 0.0 {
            true => vec![Grip {
                low: vec![0.0; size.len()],
                high,
                velocity: vec![0.0; size.len()],
                ..Grip::default()
            }],
            false => Vec::new(),
        };
        let body = BodyParticles::Cut(Shape::Block {
            size,
            hole: None,
            notch,
        });
        let own = with(&*method, &body, &grips, |body| {
            body.critical_time_step().expect("a step")
        });
        let own = own.expect("a body");
        assert!(own <= step * (1.0 + 1e-9), "{own} above {step}: {case}");
        assert!(own >= step * (1.0 - 1e-6), "{own} below {step}: {case}");
        let (bound, ground) = finite(&*method);
        assert_eq!(ground, FiniteBodyGround::Blocks);
        assert!(
            (0.75 * step..=step * (1.0 + 1e-9)).contains(&bound),
            "{bound} for {step}: {case}"
        );
    }
}

#[test]
fn an_opened_grip_releases_its_particles() {
    let (case, step) = cases("sph").swap_remove(0);
    let method = sph(&case);
    let size = numbers(&case, "size").expect("sides");
    let grip = Grip {
        low: vec![0.0; 2],
        high: vec![size[0], 1.0],
        velocity: vec![0.0; 2],
        until: 1.0,
        ..Grip::default()
    };
    let own = with(&*method, &block(&size), &[grip], |body| {
        body.critical_time_step().expect("a step")
    });
    assert!((own.expect("a body") / step - 1.0).abs() < 1e-6);
}

#[test]
fn single_elements_bound_the_steps_of_all_bodies() {
    for (case, step) in cases("finite-elements") {
        let mut meshes = ElementMesh::ALL.into_iter();
        let mesh = meshes.find(|own| case["mesh"] == own.name());
        let mesh = mesh.expect("a mesh");
        let sides = numbers(&case, "size").expect("sides");
        let choices = ElementChoices {
            mesh,
            ..ElementChoices::default()
        };
        let (bound, ground) = finite(&*made(&case, &MethodChoices::FiniteElements(choices)));
        assert_eq!(ground, FiniteBodyGround::Parts);
        // Nearly incompressible elements in 3D are stiffer alone than in a mesh.
        let share = if sides.len() == 3 { 0.66 } else { 0.75 };
        assert!(
            (share * step..=step * (1.0 + 1e-9)).contains(&bound),
            "{bound} for {step}: {case}"
        );
        let is_one = sides.iter().all(|side| *side == 1.0);
        if is_one && ["quadrilaterals", "bricks"].contains(&mesh.name()) {
            assert!(
                (bound / step - 1.0).abs() < 1e-9,
                "{bound} for {step}: {case}"
            );
        }
    }
}

#[test]
fn the_step_of_the_lattice_bounds_the_steps_of_peridynamic_bodies() {
    for (case, step) in cases("peridynamics") {
        let choices = PeridynamicsChoices {
            horizon: number(&case, "horizon"),
            ..PeridynamicsChoices::default()
        };
        let (bound, ground) = finite(&*made(
            &case,
            &MethodChoices::Peridynamics(particles(&case), choices),
        ));
        assert_eq!(ground, FiniteBodyGround::Lattice);
        assert!(
            (0.75 * step..=step).contains(&bound),
            "{bound} for {step}: {case}"
        );
    }
}

#[test]
fn single_material_points_bound_the_steps_of_all_bodies() {
    for (case, step) in cases("material-points") {
        let choices = MaterialPointChoices {
            per_side: 2,
            functions: match case["functions"].as_str() {
                Some("linear") => GridFunctions::Linear,
                _ => GridFunctions::QuadraticSpline,
            },
            formulation: Formulation::TotalLagrangian {
                mass: GridMass::Lumped,
            },
            ..MaterialPointChoices::default()
        };
        let (bound, ground) = finite(&*made(
            &case,
            &MethodChoices::MaterialPoints(particles(&case), choices),
        ));
        assert_eq!(ground, FiniteBodyGround::Parts);
        // A single point attains the bound. In filled cells points share their nodes.
        assert!(
            (0.67 * step..=step).contains(&bound),
            "{bound} for {step}: {case}"
        );
    }
}

/// Critical step of the particles of a free block, from all eigenvalues of its stiffness.
fn step_of_block<const D: usize>(method: &MethodChoices, nu: f64, cells: [usize; D]) -> f64 {
    let method = method.discretization::<D>().expect("a method");
    let block = method
        .on_block(cells, &SVector::zeros())
        .expect("a state")
        .expect("a block");
    let waves = block.waves(&*law(nu), &DeformationGradient::identity());
    let squares = waves.expect("waves").omega_squared(&SVector::zeros());
    2.0 / squares.last().expect("a mode").re.sqrt()
}

#[test]
fn the_particles_of_a_block_have_the_step_of_the_body() {
    for (case, step) in cases("sph") {
        let size = numbers(&case, "size").expect("sides");
        if case["notch"] != Value::Null || number(&case, "held") > 0.0 || size.len() != 2 {
            continue;
        }
        let cells = [size[0] as usize, size[1] as usize];
        let nu = number(&case, "poisson");
        let choices = TotalLagrangianChoices {
            kernel: Kernel::CubicSpline,
            radius: number(&case, "support"),
            corrected: case["corrected"] == true,
            penalty: number(&case, "penalty"),
            ..TotalLagrangianChoices::default()
        };
        let sph = MethodChoices::TotalLagrangianSph(particles(&case), choices);
        let found = step_of_block(&sph, nu, cells);
        assert!((found / step - 1.0).abs() < 1e-6, "{found}: {case}");
        // Corrected kernel gradients at the particles are the same method, without the penalty.
        if case["corrected"] != true || number(&case, "penalty") > 0.0 {
            continue;
        }
        let kernel = KernelMethodChoices {
            kernel: Kernel::CubicSpline,
            support: number(&case, "support"),
            quadrature: Quadrature::Nodal,
            approximation: Approximation::RandlesLibersky,
            ..*particles(&case)
        };
        let found = step_of_block(&MethodChoices::Kernel(Box::new(kernel)), nu, cells);
        assert!((found / step - 1.0).abs() < 1e-6, "{found}: {case}");
    }
}

#[test]
fn free_blocks_bound_the_steps_of_methods_without_moving_bodies() {
    let square = || {
        Box::new(KernelMethodChoices {
            lattice: LatticeKind::Square,
            support: 2.1,
            ..KernelMethodChoices::default()
        })
    };
    let kernel = |quadrature, approximation, frame| {
        MethodChoices::Kernel(Box::new(KernelMethodChoices {
            quadrature,
            approximation,
            frame,
            ..*square()
        }))
    };
    let correspondence = |control| {
        let choices = PeridynamicsChoices {
            horizon: 2.1,
            model: BondModel::Correspondence { control },
            ..PeridynamicsChoices::default()
        };
        MethodChoices::Peridynamics(square(), choices)
    };
    let conforming = ConformingChoices {
        radius: 2.1,
        ..ConformingChoices::default()
    };
    let methods = [
        kernel(Quadrature::Nodal, Approximation::Shepard, Frame::Lagrangian),
        kernel(
            Quadrature::StressPoints,
            Approximation::Mls,
            Frame::Lagrangian,
        ),
        kernel(Quadrature::Nodal, Approximation::Shepard, Frame::Eulerian),
        correspondence(ZeroEnergyControl::None),
        correspondence(ZeroEnergyControl::Penalty { coefficient: 0.3 }),
        MethodChoices::Conforming(square(), conforming),
    ];
    for method in methods {
        for nu in [0.0, 0.3, 0.45] {
            let own = analysis(&method, Arc::from(law(nu))).expect("a method");
            let (bound, ground) = finite(&*own);
            assert_eq!(ground, FiniteBodyGround::Blocks);
            let blocks = [[8, 8], [3, 10], [6, 4], [3, 3], [5, 3]];
            let steps = blocks.map(|cells| step_of_block(&method, nu, cells));
            let least = steps.into_iter().fold(f64::INFINITY, f64::min);
            assert!(
                (0.75 * least..=least).contains(&bound),
                "{bound} for {steps:?}: {method:?}"
            );
        }
    }
}

#[test]
fn a_mirrored_state_and_a_turned_lattice_have_the_finite_body_step_of_the_original() {
    let material: Arc<dyn Hyperelastic> = Arc::from(law(0.3));
    let hexagonal = |vectors: Vec<f64>| {
        Box::new(KernelMethodChoices {
            lattice: match vectors.is_empty() {
                true => LatticeKind::Hexagonal,
                false => LatticeKind::Oblique,
            },
            vectors,
            ..KernelMethodChoices::default()
        })
    };
    let sph = |vectors| {
        let choices = TotalLagrangianChoices {
            radius: 2.2,
            ..TotalLagrangianChoices::default()
        };
        MethodChoices::TotalLagrangianSph(hexagonal(vectors), choices)
    };
    let correspondence = |vectors| {
        let choices = PeridynamicsChoices {
            horizon: 2.16,
            model: BondModel::Correspondence {
                control: ZeroEnergyControl::None,
            },
            ..PeridynamicsChoices::default()
        };
        MethodChoices::Peridynamics(hexagonal(vectors), choices)
    };
    let step = |method: MethodChoices, f: [[f64; 3]; 3]| {
        let method = analysis(&method, material.clone()).expect("a method");
        let f = DeformationGradient::new(f).expect("a state");
        let found = method.finite_bodies(&f).expect("a state");
        let found = found.step(Integrator::CentralDifferences, f64::INFINITY);
        found.expect("a bound").time_step
    };
    let sheared = |shear: f64| [[1.0, shear, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    // The lattice turned by `angle`, and the state turned with it: `R F R^T`.
    let (sine, cosine) = 0.4_f64.sin_cos();
    let root = 0.75_f64.sqrt();
    let turned = vec![
        cosine,
        sine,
        0.5 * cosine - root * sine,
        0.5 * sine + root * cosine,
    ];
    let rotation = [[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]];
    let conjugated = |f: [[f64; 3]; 3]| -> [[f64; 3]; 3] {
        std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let parts = (0..9).map(|n| (n / 3, n % 3));
                parts
                    .map(|(a, b)| rotation[i][a] * f[a][b] * rotation[j][b])
                    .sum()
            })
        })
    };
    for method in [&sph as &dyn Fn(Vec<f64>) -> MethodChoices, &correspondence] {
        let known = step(method(Vec::new()), sheared(0.2));
        for other in [
            step(method(Vec::new()), sheared(-0.2)),
            step(method(turned.clone()), conjugated(sheared(0.2))),
            step(method(turned.clone()), conjugated(sheared(-0.2))),
        ] {
            assert!((other / known - 1.0).abs() < 1e-6, "{other} {known}");
        }
    }
}

/// The second particle of an oblique cell is described in the shortest basis, in a longer one, and from the other particle.
#[test]
fn the_step_of_free_blocks_does_not_depend_on_the_description_of_the_crystal() {
    let described = |vectors: [f64; 4], basis: [f64; 2]| {
        Box::new(KernelMethodChoices {
            lattice: LatticeKind::Oblique,
            vectors: vectors.to_vec(),
            basis: basis.to_vec(),
            support: 1.9,
            quadrature: Quadrature::Nodal,
            ..KernelMethodChoices::default()
        })
    };
    let (short, second) = ([1.4, 0.0, 0.2, 1.5], [0.4, 0.45]);
    let cells = [
        described(short, second),
        // x a + y b = (x - y) a + y (a + b).
        described([1.4, 0.0, 1.6, 1.5], [second[0] - second[1], second[1]]),
        described(short, second.map(|x| 1.0 - x)),
    ];
    let choices = |radius| TotalLagrangianChoices {
        radius,
        ..TotalLagrangianChoices::default()
    };
    let correspondence = PeridynamicsChoices {
        horizon: 1.9,
        model: BondModel::Correspondence {
            control: ZeroEnergyControl::Penalty { coefficient: 0.3 },
        },
        ..PeridynamicsChoices::default()
    };
    let conforming = ConformingChoices {
        radius: 1.9,
        ..ConformingChoices::default()
    };
    let states = [[1.0, 0.0, 0.0, 1.0], [1.1, 0.15, 0.05, 0.9]];
    for [a, b, c, d] in states {
        let f = DeformationGradient::new([[a, b, 0.0], [c, d, 0.0], [0.0, 0.0, 1.0]]);
        let f = f.expect("a state");
        let steps = cells.each_ref().map(|cell| {
            let methods = [
                MethodChoices::TotalLagrangianSph(cell.clone(), choices(1.9)),
                MethodChoices::Kernel(cell.clone()),
                MethodChoices::Peridynamics(cell.clone(), correspondence.clone()),
                MethodChoices::Conforming(cell.clone(), conforming.clone()),
            ];
            methods.map(|method| {
                let own = analysis(&method, Arc::from(law(0.3))).expect("a method");
                let found = own.finite_bodies(&f).expect("a state");
                let found = found.step(Integrator::CentralDifferences, f64::INFINITY);
                let found = found.expect("a step");
                assert_eq!(found.ground, FiniteBodyGround::Blocks);
                found.time_step
            })
        });
        for n in 0..steps[0].len() {
            let [first, longer, other] = steps.each_ref().map(|own| own[n]);
            let apart = |own: f64| (own / first - 1.0).abs();
            assert!(
                apart(longer).max(apart(other)) < 1e-6,
                "{n}: {first} {longer} {other}"
            );
        }
    }
}
