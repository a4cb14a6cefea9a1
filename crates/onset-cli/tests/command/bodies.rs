//! Time steps of finite bodies, and studies with a body.

use super::{Scratch, Written, assert_close, document, number, onset, onset_line};

/// A free block of corrected total-Lagrangian SPH. Its critical step is in `validation/bodies.json`.
const BLOCK: &str = "[material]\nmodel = 'neo-hooke'\nyoung = 1.0\npoisson = 0.45\n\
                     [discretization]\nmethod = 'total-lagrangian-sph'\nlattice = 'square'\nkernel = 'cubic-spline'\n\
                     support = 2.6\ncorrected = true\npenalty = 0.1\n[body]\nshape = 'block'\nsize = [20, 20]\n";
const STEP: f64 = 0.6718397769;
const LATTICE: &str = "infinite lattice; free faces and distorted cells need less";

/// Inside a large body the waves of the lattice travel.
#[test]
fn no_step_of_finite_bodies_exceeds_the_step_of_the_lattice() {
    for line in [
        "state --stretch 1.2,.9",
        "state --stretch 1,1 --set discretization.method=total-lagrangian-sph --set discretization.lattice=square --set discretization.corrected=false \
         --set discretization.support=1.3 --set material.model=neo-hooke",
        "state --stretch 1.3,.85 --set discretization.quadrature=nodal --set discretization.support=2.6 --set material.model=neo-hooke",
    ] {
        let answer = document(line);
        let own = &answer["discretization"];
        let lattice = number(own, "/critical_time_step");
        assert!(
            number(own, "/finite_bodies/time_step") <= lattice,
            "{line}: {own}"
        );
    }
}

#[test]
fn a_state_reports_the_steps_of_the_lattice_of_finite_bodies_and_of_the_body() {
    let file = Written::new("block.toml", BLOCK);
    let answer = document(&format!("state {} --stretch 1,1", &*file));
    let own = &answer["discretization"];
    assert_close(number(own, "/critical_time_step"), 1.25763, 1e-5);
    assert_eq!(own["critical_time_step_of"], LATTICE);
    assert_close(number(own, "/body/time_step"), STEP, 1e-6);
    assert_eq!(own["body"]["particles"], 400);
    let finite = number(own, "/finite_bodies/time_step");
    assert!((0.75 * STEP..STEP).contains(&finite), "{finite}");
    assert_eq!(own["finite_bodies"]["proved"], false);
    let text = onset_line(&format!("state {} --stretch 1,1 --all", &*file)).stdout;
    for fact in [
        LATTICE,
        "400 particles: stable below 0.671839",
        "three particles thick",
    ] {
        assert!(text.contains(fact), "no `{fact}` in: {text}");
    }
}

#[test]
fn a_rotation_of_the_state_does_not_change_the_step_of_finite_bodies() {
    // Raw gradients are not exact at faces: half a turn inverts the particles there.
    let step = |f: &str| {
        let line = format!(
            "state --deformation-gradient={f} set method=total-lagrangian-sph set lattice=square set corrected=false --set material.model=neo-hooke"
        );
        number(&document(&line), "/discretization/finite_bodies/time_step")
    };
    for [plain, turned] in [
        ["1,0,0,1", "-1,0,0,-1"],
        ["1.1,0,0,0.9", "-1.1,0,0,-0.9"],
        ["1.1,0,0,0.9", "0,-0.9,1.1,0"],
    ] {
        assert_close(step(turned), step(plain), 1e-6);
    }
}

#[test]
fn a_body_has_no_step_of_an_integrator_that_is_unstable_without_damping() {
    let file = Written::new("small.toml", BLOCK.replace("[20, 20]", "[6, 6]"));
    let line = format!("state {} --stretch 1,1 --set time.integrator=heun", &*file);
    assert_eq!(document(&line)["discretization"]["body"]["time_step"], 0.0);
    let short = onset(&line.split_whitespace().collect::<Vec<_>>()).stdout;
    let told = "none (this body of 36 particles)";
    assert!(short.contains(told), "{short}");
    let whole = onset_line(&line).stdout;
    assert!(whole.contains("36 particles: no step is stable"), "{whole}");
    // Damping shifts the frequencies, so that the reach on the imaginary axis gives no step.
    let damped = document(&format!(
        "state {} --stretch 1,1 set method=updated-sph set penalty=0 set viscosity=1 --set time.integrator=rk4",
        &*file
    ));
    assert!(damped["discretization"]["body"].is_null());
    assert!(damped["discretization"]["finite_bodies"].is_null());
}

/// The smaller of the steps of lattice and finite bodies decides. `state` computes the step of finite bodies with each limit by itself; in space it is
/// interpolated in the search.
#[test]
fn the_limit_admits_the_step_of_finite_bodies() {
    let law = "--set material.model=neo-hooke --set material.mu=1 --set material.lambda=1";
    let sph = "set method=total-lagrangian-sph set support=1.6 set lattice";
    for (method, stretch, key, range) in [
        (
            format!("{sph}=square"),
            "1.1,0.95",
            "material.lambda",
            "0.1,100",
        ),
        (
            format!("{sph}=simple-cubic"),
            "1.1,0.95,1",
            "material.lambda",
            "0.1,100",
        ),
        (format!("{sph}=square"), "1,1", "material.mu", "1e-6,1e6"),
    ] {
        let line = format!("--stretch {stretch} {law} {method}");
        let limit = format!("limit --time-step 0.15 --vary {key} --range {range} {line}");
        let answer = document(&limit);
        let value = number(&answer, "/admitted/0/to/value");
        assert_eq!(answer["admitted"][0]["to"]["kind"], "limit");
        let state = document(&format!("state {line} --set {key}={value}"));
        let finite = number(&state, "/discretization/finite_bodies/time_step");
        assert_close(finite, 0.15, 1e-6);
        assert!(number(&state, "/discretization/critical_time_step") > finite);
        let present = &answer["present"];
        assert_close(
            number(present, "/finite_body_time_step"),
            number(&answer, "/finite_bodies/time_step"),
            1e-12,
        );
        assert_eq!(
            present["critical_time_step"],
            present["finite_body_time_step"]
        );
        let text = onset_line(&limit).stdout.replace('\n', " ");
        let text: Vec<&str> = text.split_whitespace().collect();
        let told = "finite bodies; the infinite lattice has";
        assert!(text.join(" ").contains(told), "{text:?}");
    }
}

#[test]
fn the_element_step_bounds_the_steps_of_finite_element_bodies() {
    // One square with full integration: omega^2 = c^2/h^2 * 4/(1 - nu), attained by a body of one element.
    for nu in [0.3_f64, 0.45, 0.49] {
        let line = format!(
            "state --stretch 1,1 set method=fem set mesh=quadrilaterals --set material.model=neo-hooke --set material.young=1 --set material.poisson={nu}"
        );
        let answer = document(&line);
        let own = &answer["discretization"];
        let expected = number(own, "/critical_time_step") * (1.0 - nu).sqrt();
        assert_close(number(own, "/finite_bodies/time_step"), expected, 1e-9);
        assert_eq!(own["finite_bodies"]["proved"], true);
    }
}

#[test]
fn the_limit_accounts_for_the_body() {
    let file = Written::new("block.toml", BLOCK);
    let line = format!("limit {} --time-step 1 --vary material.young", &*file);
    let answer = document(&line);
    assert_close(number(&answer, "/admitted/0/to/value"), STEP * STEP, 2e-6);
    assert_eq!(answer["present"]["body"]["particles"], 400);
    let of = answer["critical_time_step_of"].as_str().expect("a text");
    assert!(of.starts_with("body of 400 particles"), "{of}");
    let text = onset_line(&format!("{line} --all")).stdout;
    assert!(text.contains("up to 0.45136"), "{text}");
    assert!(
        text.contains("critical steps: body of 400 particles"),
        "{text}"
    );
}

#[test]
fn run_and_check_use_the_step_of_the_state() {
    let file = Written::new("block.toml", BLOCK);
    let run = document(&format!("simulate {} --steps 1", &*file));
    let step = number(&run, "/critical_time_step");
    assert_close(step, STEP, 1e-6);
    assert!(step <= STEP * (1.0 + 1e-9));
    let answer = onset(&["check", "--json", &file]);
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    let entries: serde_json::Value = serde_json::from_str(&answer.stdout).expect("a document");
    assert_close(number(&entries[0], "/body/time_step"), STEP, 1e-6);
    let text = onset(&["check", &file]).stdout;
    assert!(
        text.contains("400 particles; central differences need a time step below 0.671839"),
        "{text}"
    );
}

#[test]
fn a_study_without_axes_can_be_compared() {
    let file = Written::new("block.toml", BLOCK);
    for command in ["compare", "recommend"] {
        let answer = document(&format!("{command} {} --set compare.states=2", &*file));
        let rows = answer.pointer("/table/rows").unwrap_or(&answer["rows"]);
        let own = &rows[0];
        assert_eq!(own["name"], "the study's own method");
        let text = own.to_string();
        assert!(text.contains(LATTICE), "{text}");
        assert!(text.contains("\"particles\":400"), "{text}");
    }
}

#[test]
fn a_body_is_refused_by_every_command_for_methods_without_bodies() {
    let text =
        "[discretization]\nmethod = 'peridynamics'\n[body]\nshape = 'block'\nsize = [9, 9]\n";
    let file = Written::new("block.toml", text);
    for line in [
        "state FILE --stretch 1,1",
        "check FILE",
        "simulate FILE --steps 1",
        "limit FILE --vary discretization.spacing --time-step 0.1",
    ] {
        let answer = onset_line(&line.replace("FILE", &file));
        assert_eq!(answer.code, Some(2), "{line}: {}", answer.stdout);
        assert!(
            answer
                .stderr
                .contains("this method does not support bodies"),
            "{line}: {}",
            answer.stderr
        );
    }
}

#[test]
fn the_spacing_of_material_points_is_the_cell_size() {
    let line = "state --stretch 1,1 set method=mpm set spacing=0.5";
    let answer = document(line);
    let own = &answer["discretization"];
    assert_close(number(own, "/grid_cell"), 0.5, 1e-15);
    assert_close(number(own, "/point_spacing"), 0.25, 1e-15);
    let text = onset_line(&format!("{line} --all")).stdout;
    assert!(
        text.contains("grid cells of 0.5, points 0.25 apart"),
        "{text}"
    );
    let keys = onset_line("list method material-points").stdout;
    assert!(keys.contains("side of a grid cell"), "{keys}");
}

#[test]
fn a_map_of_a_study_with_a_body_reports_which_time_steps_are_stored() {
    let axis =
        |name: &str| format!("[[axes]]\nquantity = '{name}'\nrange = [0.9, 1.1]\nstates = 2\n");
    let text = format!(
        "[discretization]\nmethod = 'total-lagrangian-sph'\nlattice = 'square'\npenalty = 0.1\n[body]\nshape = 'block'\nsize = [5, 5]\n{}{}",
        axis("stretch-1"),
        axis("stretch-2")
    );
    let (file, store) = (Written::new("body.toml", &text), Scratch::new("body.zarr"));
    let note = "time steps of the map are those of the infinite lattice";
    let map = |more: &str| {
        onset_line(&format!(
            "map {file} --out {} --overwrite {more}",
            store.display()
        ))
    };
    for answer in [map(""), map("--json"), onset_line(&format!("check {file}"))] {
        assert_eq!(answer.code, Some(0), "{}", answer.stderr);
        assert!(answer.stdout.contains(note), "{}", answer.stdout);
    }
    let without = map("--set map.outputs=growth_rate");
    assert_eq!(without.code, Some(0), "{}", without.stderr);
    assert!(!without.stdout.contains(note), "{}", without.stdout);
}
