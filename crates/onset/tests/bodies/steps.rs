//! Critical time steps of bodies against `validation/bodies.json`, computed independently with NumPy and SciPy.

use super::{block, with};
use onset::analysis::{Analysis, FiniteBodyGround, analysis};
use onset::kernel::Kernel;
use onset::kinematics::DeformationGradient;
use onset::lattice::LatticeKind;
use onset::material::Law;
use onset::method::KernelMethodChoices;
use onset::motion::{BodyParticles, Grip, Notch, Shape};
use onset::scheme::element::{ElementChoices, ElementMesh};
use onset::scheme::sph::TotalLagrangianChoices;
use onset::scheme::{
    Formulation, GridFunctions, GridMass, MaterialPointChoices, MethodChoices, PeridynamicsChoices,
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

fn made(case: &Value, method: &MethodChoices) -> Box<dyn Analysis> {
    let law = Law::named("neo-hooke").expect("a law");
    let nu = number(case, "poisson");
    let mu = 0.5 / (1.0 + nu);
    let lambda = 2.0 * mu * nu / (1.0 - 2.0 * nu);
    let material = law.build(&[("mu", mu), ("lambda", lambda)]);
    analysis(method, Arc::from(material.expect("a material"))).expect("a method")
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
    let found = method.finite_bodies(&rest, lattice.expect("a step"));
    let found = found.expect("a state").expect("a bound");
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
