//! Runs of `onset simulate`: patches and bodies.

use super::{Found, check, in_pairs, onset, screened, sets};
use crate::{Place, text};

const NEO_HOOKE: &str = "model=neo-hooke young=1 poisson=0.3";
const SAINT_VENANT: &str = "model=saint-venant-kirchhoff young=1 poisson=0.3";
const BLATZ_KO: &str = "model=blatz-ko mu=1";
const TOTAL: &str = "method=total-lagrangian-sph lattice=square support=2.4 penalty=0.5";
const FREE: &str = "method=total-lagrangian-sph lattice=square support=2.4 penalty=0";
const UPDATED: &str = "method=updated-sph lattice=square support=2.4";
const SMALL: &str = " spacing=0.5";

/// Particles of a run.
enum Shape {
    /// Homogeneously stretched periodic patch with noise.
    Patch(&'static str),
    /// Plate between two grips that move apart: sides, velocity of the right grip, and keys of the shape.
    Plate([u32; 2], [f64; 2], &'static str),
}

use Shape::{Patch, Plate};

/// Run with its true cause.
struct Variant(&'static str, &'static str, String, Shape, &'static str);

impl Variant {
    fn found(&self) -> Found {
        let Self(cause, law, method, shape, line) = self;
        let place = Place::new();
        let sets = sets(law, method);
        let mut arguments = sets.clone();
        let name = match shape {
            Patch(stretch) => {
                let more = format!("--stretch {stretch} --mode noise --cells 12 --fields 31");
                arguments.extend(more.split(' ').map(str::to_owned));
                format!("patch {stretch}")
            }
            Plate([width, height], [x, y], shape) => {
                let grip = |from: u32, sign: f64| {
                    format!(
                        "[[grips]]\nfrom = [{from}, 0]\nto = [{}, {height}]\nvelocity = [{}, {}]\nramp = 20\n",
                        from + 3,
                        sign * x,
                        sign * y
                    )
                };
                let body =
                    format!("[body]\nshape = 'plate'\nsize = [{width}, {height}]\n{shape}\n");
                place.write(
                    "body.toml",
                    &(body + &grip(0, -1.0) + &grip(width - 3, 1.0)),
                );
                arguments.insert(0, text(&place.path().join("body.toml")).to_owned());
                arguments.extend(["--fields", "41"].map(str::to_owned));
                format!("plate {width} x {height} {shape} at ({x}, {y})")
            }
        };
        arguments.extend(line.split(' ').map(str::to_owned));
        arguments.extend(["--json", "--out", text(place.path())].map(str::to_owned));
        let name = format!("{law}, {method}, {name}, {line}");
        let run = onset("simulate", &arguments);
        // The rate of a wave in noise is uncertain.
        assert!(matches!(run.code, Some(0 | 3)), "{name}: {}", run.stderr);
        let step = format!("--time-step {:e}", run.number("time_step"));
        let answer = screened(&place, "fields.pvd", &sets, &step);
        Found {
            name,
            cause,
            answer,
        }
    }
}

/// Bodies and patches at states at which law and method are stable, in steps below the largest stable step.
fn healthy() -> Vec<Variant> {
    let total = |more: &str| TOTAL.to_owned() + more;
    let plate = |law, method, velocity, line| {
        Variant("none", law, method, Plate([24, 12], velocity, ""), line)
    };
    let patch = |law, method: &str, stretch, line| {
        Variant("none", law, method.to_owned(), Patch(stretch), line)
    };
    vec![
        plate(
            NEO_HOOKE,
            total(""),
            [0.01, 0.0],
            "--time 150 --amplitude 1e-3",
        ),
        plate(
            NEO_HOOKE,
            total(""),
            [0.004, 0.0],
            "--time 300 --amplitude 1e-3 --seed 2",
        ),
        plate(
            NEO_HOOKE,
            total(""),
            [0.03, 0.0],
            "--time 60 --amplitude 1e-4 --seed 3",
        ),
        plate(
            NEO_HOOKE,
            total(""),
            [-0.008, 0.0],
            "--time 100 --amplitude 1e-3",
        ),
        plate(
            NEO_HOOKE,
            total(""),
            [0.0, 0.01],
            "--time 150 --amplitude 1e-3",
        ),
        plate(
            NEO_HOOKE,
            total(SMALL),
            [0.01, 0.0],
            "--time 60 --amplitude 1e-3",
        ),
        plate(
            BLATZ_KO,
            total(""),
            [0.03, 0.0],
            "--time 60 --amplitude 1e-3",
        ),
        plate(
            SAINT_VENANT,
            total(""),
            [0.03, 0.0],
            "--time 80 --amplitude 1e-3",
        ),
        plate(
            NEO_HOOKE,
            total(""),
            [0.004, 0.0],
            "--time 150 --amplitude 1e-3 --fraction 0.9",
        ),
        plate(
            NEO_HOOKE,
            total(""),
            [-0.002, 0.0],
            "--time 150 --amplitude 1e-3 --fraction 0.95",
        ),
        // Too short for the waves to show.
        plate(
            NEO_HOOKE,
            UPDATED.to_owned(),
            [0.02, 0.0],
            "--time 12 --amplitude 1e-5",
        ),
        plate(
            NEO_HOOKE,
            format!("{UPDATED} artificial-stress=0.3"),
            [0.02, 0.0],
            "--time 40 --amplitude 1e-4",
        ),
        patch(
            NEO_HOOKE,
            "method=peridynamics",
            "0.9,1",
            "--time 40 --amplitude 1e-4",
        ),
        patch(
            NEO_HOOKE,
            "method=peridynamics",
            "1,1",
            "--fraction 0.9 --steps 60 --amplitude 1e-3",
        ),
        patch(
            NEO_HOOKE,
            "method=finite-elements",
            "1.3,0.9",
            "--time 40 --amplitude 1e-4",
        ),
        patch(
            NEO_HOOKE,
            "method=finite-elements",
            "1,1",
            "--fraction 0.95 --steps 60 --amplitude 1e-3",
        ),
        patch(
            NEO_HOOKE,
            "frame=lagrangian",
            "0.9,0.9",
            "--time 40 --amplitude 1e-4",
        ),
        patch(
            NEO_HOOKE,
            "frame=lagrangian lattice=square approximation=mls support=2.4",
            "1.2,0.9",
            "--time 40 --amplitude 1e-4",
        ),
        patch(
            NEO_HOOKE,
            "method=conforming lattice=square",
            "1.2,0.9",
            "--time 40 --amplitude 1e-4",
        ),
        patch(
            NEO_HOOKE,
            "method=material-points unknowns=total-lagrangian grid-functions=quadratic-spline",
            "1.2,0.9",
            "--time 40 --amplitude 1e-4",
        ),
        // The ratio of the stretches is below 3.73, see `softened`.
        patch(
            BLATZ_KO,
            "method=finite-elements",
            "3.2,0.9",
            "--time 40 --amplitude 1e-4",
        ),
    ]
}

/// Runs with 1.05 to 1.3 times the largest stable step, until shortly before the first particle inverts.
fn too_large_steps() -> Vec<Variant> {
    let plate = |law, method: &str, size, velocity, shape, line| {
        Variant(
            "time-step",
            law,
            method.to_owned(),
            Plate(size, [velocity, 0.0], shape),
            line,
        )
    };
    let patch = |method: &str, stretch, line| {
        Variant(
            "time-step",
            NEO_HOOKE,
            method.to_owned(),
            Patch(stretch),
            line,
        )
    };
    vec![
        plate(
            NEO_HOOKE,
            TOTAL,
            [24, 12],
            0.002,
            "",
            "--time 31 --fraction 1.05 --supercritical --amplitude 1e-5",
        ),
        plate(
            NEO_HOOKE,
            TOTAL,
            [24, 12],
            0.002,
            "",
            "--time 22 --fraction 1.1 --supercritical --amplitude 1e-5",
        ),
        plate(
            NEO_HOOKE,
            TOTAL,
            [24, 12],
            0.002,
            "",
            "--time 15 --fraction 1.3 --supercritical --amplitude 1e-5",
        ),
        plate(
            NEO_HOOKE,
            TOTAL,
            [30, 15],
            -0.002,
            "notch = [5, 2]",
            "--time 17 --fraction 1.2 --supercritical --amplitude 1e-5",
        ),
        plate(
            NEO_HOOKE,
            TOTAL,
            [24, 14],
            -0.002,
            "hole = 2.3",
            "--time 17.5 --fraction 1.15 --supercritical --amplitude 1e-5",
        ),
        plate(
            BLATZ_KO,
            TOTAL,
            [24, 12],
            0.002,
            "",
            "--time 10 --fraction 1.2 --supercritical --amplitude 1e-5",
        ),
        plate(
            NEO_HOOKE,
            UPDATED,
            [24, 14],
            -0.002,
            "",
            "--time 20 --fraction 1.2 --supercritical --amplitude 1e-5",
        ),
        patch(
            "method=finite-elements",
            "1,1",
            "--fraction 1.1 --steps 14 --supercritical --amplitude 1e-5",
        ),
        patch(
            "method=finite-elements mesh=triangles",
            "0.95,1",
            "--fraction 1.05 --steps 21 --supercritical --amplitude 1e-5",
        ),
        patch(
            "frame=lagrangian",
            "1,1",
            "--fraction 1.2 --steps 9 --supercritical --amplitude 1e-5 --seed 2",
        ),
        patch(
            "method=conforming lattice=square",
            "1,1",
            "--fraction 1.1 --steps 14 --supercritical --amplitude 1e-5",
        ),
        patch(
            "method=peridynamics",
            "1,1",
            "--fraction 1.3 --steps 9 --supercritical --amplitude 1e-5",
        ),
    ]
}

/// Methods with current coordinates and material points, under stress, with laws that stay strongly elliptic.
fn tensile() -> Vec<Variant> {
    let plate = |law, more: &str, velocity, line| {
        let method = format!("{UPDATED} {more}");
        Variant(
            "numerical",
            law,
            method,
            Plate([30, 16], [velocity, 0.0], ""),
            line,
        )
    };
    let patch = |law, method: &str, stretch, line| {
        Variant("numerical", law, method.to_owned(), Patch(stretch), line)
    };
    vec![
        plate(NEO_HOOKE, "", 0.05, "--time 50 --amplitude 1e-4"),
        plate(NEO_HOOKE, "", 0.02, "--time 60 --amplitude 1e-5 --seed 2"),
        plate(
            NEO_HOOKE,
            "viscosity=0.1",
            0.03,
            "--time 50 --amplitude 1e-4",
        ),
        plate(
            NEO_HOOKE,
            "corrected=false",
            0.03,
            "--time 50 --amplitude 1e-4",
        ),
        plate(NEO_HOOKE, "spacing=0.5", 0.02, "--time 30 --amplitude 1e-4"),
        plate(BLATZ_KO, "", 0.05, "--time 35 --amplitude 1e-4"),
        // Strain gradients contribute to the measured short waves, which are therefore observed earlier than expected.
        Variant(
            "numerical",
            "model=mooney-rivlin c10=0.15 c01=0.05 lambda=0.6",
            "method=updated-sph support=2.6 spacing=0.5".to_owned(),
            Plate([22, 11], [0.0415, 0.0], ""),
            "--time 22 --amplitude 1e-5",
        ),
        Variant(
            "numerical",
            NEO_HOOKE,
            "method=updated-sph support=3 artificial-stress=0.1".to_owned(),
            Plate([26, 11], [0.0388, 0.0], ""),
            "--time 56 --amplitude 1e-4",
        ),
        patch(
            NEO_HOOKE,
            "method=updated-sph",
            "1.1,1",
            "--time 16 --amplitude 1e-4",
        ),
        patch(
            NEO_HOOKE,
            "method=updated-sph artificial-stress=0.3",
            "1.3,0.9",
            "--time 44 --amplitude 1e-4",
        ),
        patch(
            BLATZ_KO,
            "method=updated-sph",
            "0.9,1",
            "--time 62 --amplitude 1e-4",
        ),
        patch(
            NEO_HOOKE,
            "frame=eulerian lattice=square support=2.4",
            "1.15,1.1",
            "--time 45 --amplitude 1e-4",
        ),
        patch(
            BLATZ_KO,
            "method=material-points grid-functions=quadratic-spline",
            "2,1",
            "--time 55 --amplitude 1e-4",
        ),
    ]
}

/// Total-Lagrangian SPH without a penalty; with it, the same bodies are healthy.
fn without_control() -> Vec<Variant> {
    let plate = |size, velocity, shape, line| {
        Variant(
            "zero-energy",
            NEO_HOOKE,
            FREE.to_owned(),
            Plate(size, velocity, shape),
            line,
        )
    };
    vec![
        plate([24, 12], [0.03, 0.0], "", "--time 100 --amplitude 1e-2"),
        plate([24, 12], [0.02, 0.0], "", "--time 150 --amplitude 3e-3"),
        plate(
            [24, 12],
            [-0.02, 0.0],
            "",
            "--time 150 --amplitude 3e-3 --seed 2",
        ),
        plate([24, 12], [0.0, 0.03], "", "--time 100 --amplitude 1e-2"),
        plate(
            [30, 15],
            [0.1, 0.0],
            "notch = [5, 2]",
            "--time 60 --amplitude 1e-2",
        ),
    ]
}

/// States beyond the loss of ellipticity of the material.
///
/// In plane strain the Blatz-Ko law loses it where the ratio of the stretches is 2 + sqrt(3) (Knowles and Sternberg, J. Elasticity 5 (1975)
/// 341). The law of Saint-Venant and Kirchhoff loses it in transverse waves under uniaxial strain below sqrt(nu / (1 - nu)) = 0.655.
fn softened() -> Vec<Variant> {
    let plate = |law, size, velocity, line| {
        Variant(
            "physical",
            law,
            TOTAL.to_owned(),
            Plate(size, [velocity, 0.0], ""),
            line,
        )
    };
    let patch = |law, method: &str, stretch, line| {
        Variant("physical", law, method.to_owned(), Patch(stretch), line)
    };
    vec![
        plate(BLATZ_KO, [24, 12], 0.2, "--time 85 --amplitude 1e-3"),
        plate(BLATZ_KO, [24, 12], 0.1, "--time 135 --amplitude 1e-3"),
        plate(SAINT_VENANT, [24, 24], -0.1, "--time 44 --amplitude 1e-4"),
        patch(
            BLATZ_KO,
            "method=finite-elements",
            "3.2,0.7",
            "--time 20 --amplitude 1e-4",
        ),
        patch(
            BLATZ_KO,
            "frame=lagrangian",
            "3.2,0.7",
            "--time 20 --amplitude 1e-4",
        ),
        patch(
            BLATZ_KO,
            "method=updated-sph artificial-stress=0.3",
            "3.2,0.7",
            "--time 2.4 --amplitude 1e-4",
        ),
        patch(
            SAINT_VENANT,
            "method=finite-elements",
            "0.6,1",
            "--time 20 --amplitude 1e-4",
        ),
    ]
}

#[test]
fn the_cause_of_simulated_runs_is_identified() {
    let variants = [
        healthy(),
        too_large_steps(),
        tensile(),
        without_control(),
        softened(),
    ];
    let variants: Vec<Variant> = variants.into_iter().flatten().collect();
    let found = in_pairs(&variants, Variant::found);
    for run in &found {
        let [seed, threshold] = ["seed", "threshold"].map(|own| run.answer[own].as_f64());
        assert!(seed < threshold, "{}: {seed:?}", run.name);
    }
    // States of patches are homogeneous, as rates assume.
    let is_patch = |run: &&Found| run.told() == "numerical" && run.name.contains("patch");
    for run in found.iter().filter(is_patch) {
        let times = ["/expected", "/observed/time"].map(|own| run.answer.pointer(own));
        let times = times.map(|time| time.and_then(|time| time.as_f64()));
        let [Some(expected), Some(observed)] = times else {
            panic!("{}: {}", run.name, run.answer["sentence"]);
        };
        let ratio = expected / observed;
        assert!((0.65..1.35).contains(&ratio), "{}: {ratio}", run.name);
    }
    check("`onset simulate`", &found);
}
