//! Dispersion diagrams show every instability, for any lattice, method and state.

use onset_study::answers::{Diagram, Problem, ProblemError, StateAnswer, Strain};
use onset_study::settings::Settings;

/// Pseudorandom numbers from 0 to 1 (Knuth's linear congruential generator).
struct Random(u64);

impl Random {
    fn share(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }

    fn one_of<'a>(&mut self, all: &[&'a str]) -> &'a str {
        all[((self.share() * all.len() as f64) as usize).min(all.len() - 1)]
    }
}

fn problem(assignments: &[String]) -> Result<Problem, ProblemError> {
    Problem::new(Settings::from_assignments(assignments)?)
}

/// Discretizations of several families; settings that affect their instabilities are drawn at random.
fn drawn(random: &mut Random) -> Vec<String> {
    let methods: &[&[&str]] = &[
        &["method=kernel", "frame=lagrangian"],
        &["method=kernel", "frame=eulerian"],
        &["method=kernel", "frame=eulerian", "linearization=paper"],
        &["method=kernel", "frame=eulerian", "current-lattice=regular"],
        &["method=kernel", "frame=eulerian", "quadrature=nodal"],
        &["method=updated-sph"],
        &["method=updated-sph", "momentum=difference"],
        &["method=total-lagrangian-sph"],
        &["method=material-points", "unknowns=updated", "offset=0.08"],
        &["method=peridynamics"],
    ];
    let method = methods[(random.share() * methods.len() as f64) as usize];
    let mut assignments: Vec<String> = method
        .iter()
        .map(|choice| format!("discretization.{choice}"))
        .collect();
    let dimension = random.share();
    let kind = if dimension < 0.1 {
        "chain"
    } else if dimension < 0.85 {
        random.one_of(&["hexagonal", "square", "rectangular", "honeycomb"])
    } else {
        random.one_of(&["simple-cubic", "body-centered-cubic"])
    };
    assignments.push(format!("discretization.lattice={kind}"));
    if kind == "rectangular" {
        assignments.push(format!(
            "discretization.aspect={}",
            random.between(1.0, 1.4)
        ));
    }
    if !method.contains(&"method=peridynamics") && !method.contains(&"method=material-points") {
        assignments.push(format!(
            "discretization.support={}",
            random.between(1.5, 2.3)
        ));
    }
    let material = random.one_of(&["modified-mooney-rivlin", "neo-hooke", "blatz-ko"]);
    assignments.push(format!("material.model={material}"));
    assignments
}

/// A state with stretches, and sometimes a shear.
fn state(random: &mut Random, dimension: usize) -> Result<Strain, ProblemError> {
    let mut stretch = || random.between(0.75, 1.5);
    let stretches = [stretch(), stretch(), stretch()];
    let shear = if random.share() < 0.3 { 0.2 } else { 0.0 };
    let text = match dimension {
        1 => return Strain::of_stretches("--stretch", &stretches[0].to_string(), 1),
        2 => format!("{},{shear},0,{}", stretches[0], stretches[1]),
        _ => format!(
            "{},{shear},0,0,{},0,0,0,{}",
            stretches[0], stretches[1], stretches[2]
        ),
    };
    Strain::of_components("--deformation-gradient", &text, dimension)
}

#[test]
fn the_lowest_point_of_a_diagram_is_the_minimum_over_the_zone() {
    let mut random = Random(20_261_122);
    let (mut unstable, mut fluttering, mut tried) = (0, 0, 0);
    while unstable < 20 {
        tried += 1;
        assert!(tried < 1000, "{unstable} unstable states of {tried}");
        let assignments = drawn(&mut random);
        let Ok(problem) = problem(&assignments) else {
            continue;
        };
        let Ok(strain) = state(&mut random, problem.dimension()) else {
            continue;
        };
        let Ok(answer) = StateAnswer::new(&problem, &strain) else {
            continue;
        };
        if answer.discretization.stable {
            continue;
        }
        unstable += 1;
        fluttering += usize::from(answer.discretization.flutter);
        let rate = answer.discretization.growth_rate;
        let diagram = Diagram::new(&problem, &strain, None).expect("a diagram");
        let told = || format!("{assignments:?} {:?}", answer.deformation_gradient);
        assert!(
            (diagram.lowest() + rate).abs() <= 1e-6 * rate,
            "drawn down to {}, growth rate {rate}: {}",
            diagram.lowest(),
            told()
        );
        assert_eq!(diagram.critical.growth_rate, rate);
        let marked = diagram.critical.length.expect("a place");
        assert!(diagram.lengths.contains(&marked), "{}", told());
        let states = &diagram.density_of_states;
        let steps = states.edges.windows(2).map(|ends| ends[1] - ends[0]);
        let integral: f64 = steps
            .zip(&states.density)
            .map(|(step, own)| step * own)
            .sum();
        assert!((integral - 1.0).abs() < 1e-12, "{integral}");
    }
    assert!(fluttering > 0, "no flutter among them");
}

#[test]
fn typed_paths_are_followed_and_the_critical_wave_is_still_shown() {
    let assignments = ["discretization.frame=eulerian".to_owned()];
    let problem = problem(&assignments).expect("a problem");
    let strain = Strain::of_stretches("--stretch", "1.2,1.0", 2).expect("a state");
    let names = |path: Option<&str>| -> Vec<String> {
        let diagram = Diagram::new(&problem, &strain, path).expect("a diagram");
        diagram
            .corners
            .into_iter()
            .map(|corner| corner.name)
            .collect()
    };
    let usual = names(None);
    assert!(usual.contains(&"M′".to_owned()), "{usual:?}");
    assert_eq!(names(Some("G-M'-K"))[..3], ["Γ", "M′", "K"]);
    assert_eq!(names(Some("0,0; 0.25,0.1; G"))[1], "(0.25,0.1)");
    assert!(names(Some("G-K")).contains(&"k*".to_owned()));
    let refused = Diagram::new(&problem, &strain, Some("G-Q")).expect_err("no Q");
    assert!(refused.to_string().contains("M′"), "{refused}");
}

#[test]
fn growing_and_weakly_controlled_waves_are_marked() {
    let names = |assignments: &[&str], stretches: &str| -> Vec<String> {
        let assignments: Vec<String> = assignments.iter().map(|own| (*own).to_owned()).collect();
        let problem = problem(&assignments).expect("a problem");
        let strain = Strain::of_stretches("--stretch", stretches, 2).expect("a state");
        let diagram = Diagram::new(&problem, &strain, None).expect("a diagram");
        let entries = diagram.figure("").legend_entries();
        entries.into_iter().map(|entry| entry.name).collect()
    };
    let has = |names: &[String], what: &str| names.iter().any(|name| name.starts_with(what));
    let (growing, physical, weak) = ("growing; no wave", "growing; a wave", "weakly controlled");
    // In tension, SPH has a numerical instability of a stable solid.
    let sph = names(
        &[
            "discretization.method=updated-sph",
            "material.model=neo-hooke",
        ],
        "1.2,1.2",
    );
    assert!(has(&sph, growing) && !has(&sph, physical), "{sph:?}");
    // Nodal strains vanish for the shortest waves.
    let nodal = names(
        &[
            "discretization.method=total-lagrangian-sph",
            "material.model=neo-hooke",
        ],
        "1,1",
    );
    assert!(has(&nodal, weak) && !has(&nodal, growing), "{nodal:?}");
    // Blatz-Ko foam loses ellipticity at the ratio 3.73 of stretches, with any Lagrangian kernel.
    let foam = names(
        &["discretization.frame=lagrangian", "material.model=blatz-ko"],
        "4,1",
    );
    assert!(has(&foam, physical) && !has(&foam, growing), "{foam:?}");
}
