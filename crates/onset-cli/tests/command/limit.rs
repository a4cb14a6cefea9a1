//! `onset limit`.

use super::{Scratch, document, number, onset, onset_line};

/// Bars with lumped masses: `omega_max = 2 c / h`, so that the critical step is `h / c` with `c^2 = (lambda + 2 mu) / rho` at `F = 1`.
const BARS: &str = "set method=finite-elements set mesh=bars";
const LAW: &str = "--set material.model=neo-hooke --set material.mu=1 --set material.lambda=2";

#[test]
fn the_largest_modulus_of_a_chain_of_bars_follows_from_its_wave_speed() {
    // The condition h / c >= dt limits Young's modulus: E (1 - nu) / ((1 + nu) (1 - 2 nu)) <= rho h^2 / dt^2.
    let law = "--set material.model=neo-hooke --set material.young=1 --set material.poisson=0.3";
    let line = format!("limit --all --vary material.young --time-step 0.01 {law} {BARS}");
    let answer = document(&line);
    let young = number(&answer, "/admitted/0/to/value");
    let exact = 1e4 * 1.3 * 0.4 / 0.7;
    assert!((young / exact - 1.0).abs() < 1e-8, "{young} for {exact}");
    assert!(
        young <= exact * (1.0 + 1e-9),
        "what is told admits the step"
    );
    assert_eq!(answer["admitted"][0]["to"]["kind"], "limit");
    assert_eq!(answer["admitted"][0]["from"]["kind"], "range");
    let text = onset_line(&line).stdout;
    assert!(text.contains("neo-hooke: poisson 0.3\n"), "{text}");
    let half = number(
        &document(&format!("{line} --safety 0.5")),
        "/admitted/0/to/value",
    );
    assert!((4.0 * half / young - 1.0).abs() < 1e-8, "{half}");
}

#[test]
fn the_smallest_spacing_and_density_follow_from_the_wave_speed() {
    let line =
        |key: &str| format!("limit --all --vary discretization.{key} --time-step 0.1 {LAW} {BARS}");
    let spacing = number(&document(&line("spacing")), "/admitted/0/from/value");
    assert!((spacing / (0.1 * 2.0) - 1.0).abs() < 1e-8, "{spacing}");
    let density = number(&document(&line("density")), "/admitted/0/from/value");
    assert!((density / (4.0 * 0.01) - 1.0).abs() < 1e-8, "{density}");
    let text = onset_line(&line("spacing")).stdout;
    assert!(
        text.contains(
            "is below the critical one with discretization.spacing from 0.2 up to at least "
        ),
        "{text}"
    );
    assert!(text.contains("Its present value is 1"), "{text}");
}

#[test]
fn the_end_of_a_range_of_stretches_limits_the_lame_constant_that_keeps_it_stable() {
    // Uniaxial strain: A = mu (1 + 1/l^2) + lambda (1 - ln l)/l^2 stays positive up to l = 4 if lambda < mu (l^2 + 1)/(ln l - 1).
    let line =
        format!("limit --all --vary material.lambda --keeps stable --stretches 1,4 {LAW} {BARS}");
    let answer = document(&line);
    let largest = number(&answer, "/admitted/0/to/value");
    let exact = 17.0 / (4.0_f64.ln() - 1.0);
    assert!(
        (largest / exact - 1.0).abs() < 2e-6 && largest <= exact,
        "{largest} for {exact}"
    );
    assert_eq!(answer["admitted"][0]["to"]["kind"], "limit");
    assert_eq!(
        (&answer["states"], &answer["present"]["stable_share"]),
        (&33.into(), &1.0.into())
    );
    // Beyond the limit the state that is lost is the end of the range, and it is lost by the law.
    let tried = answer["tried"].as_array().expect("values");
    let beyond = tried
        .iter()
        .find(|own| own["value"].as_f64() > Some(exact))
        .expect("a value");
    assert_eq!(
        (&beyond["verdict"], &beyond["stretches"][0]),
        (&"physical".into(), &4.0.into())
    );
    let text = onset_line(&line).stdout;
    assert!(text.starts_with("All 33 states with stretches from 1 to 4 along the axes are stable with material.lambda up to 44.0"), "{text}");
}

#[test]
fn a_limit_refers_to_a_time_step_or_to_stability() {
    for (more, told) in [
        ("", "--time-step"),
        ("--keeps stable --time-step 1", "--keeps"),
        ("--keeps stable --stretch 1.2", "--keeps"),
        ("--keeps safe", "stable"),
        ("--time-step 1 --stretches 0.8,1.2", "--stretches"),
        ("--keeps stable --stretches 0,2", "positive stretches"),
    ] {
        let output = onset_line(&format!(
            "limit --all --vary material.mu {more} {LAW} {BARS}"
        ));
        assert_eq!(output.code, Some(2), "{more}");
        assert!(output.stderr.contains(told), "{more}: {}", output.stderr);
    }
}

#[test]
fn the_limit_applies_to_the_given_state() {
    let line = format!(
        "limit --all --vary discretization.spacing --time-step 0.1 {LAW} {BARS} --stretch 1.3"
    );
    let spacing = number(&document(&line), "/admitted/0/from/value");
    let state = |spacing: f64| {
        let line = format!("state --stretch 1.3 {LAW} {BARS} set spacing={spacing}");
        number(&document(&line), "/discretization/critical_time_step")
    };
    assert!(
        (state(spacing) / 0.1 - 1.0).abs() < 1e-8,
        "{}",
        state(spacing)
    );
}

#[test]
fn a_damping_coefficient_is_limited_by_its_integrator() {
    let line = |integrator: &str| {
        format!(
            "limit --all --vary discretization.viscosity --time-step 0.2 --range 0,10 --integrator {integrator} {LAW} \
             set method=total-lagrangian-sph set lattice=chain set viscosity=0.1"
        )
    };
    // The lattice with the largest coefficient. The step of finite bodies is the step of central differences.
    let last = |integrator: &str| {
        let answer = document(&line(integrator));
        let tried = answer["tried"].as_array().expect("values");
        number(tried.last().expect("a value"), "/lattice_time_step")
    };
    let [kick, central] = ["kick-drift-kick", "central-differences"].map(last);
    assert!(kick > 1.01 * central, "{kick} {central}");
}

#[test]
fn the_smallest_density_of_runge_kutta_methods_follows_from_their_stability_on_the_imaginary_axis()
{
    let line = |integrator: &str| {
        format!(
            "limit --all --vary discretization.density --time-step 0.5 --integrator {integrator} {LAW} set method=total-lagrangian-sph set lattice=square"
        )
    };
    let smallest =
        |integrator: &str| number(&document(&line(integrator)), "/admitted/0/from/value");
    // Limits of (omega dt)^2, divided by the limit 4 of leapfrog; omega^2 is inversely proportional to the density.
    let leapfrog = smallest("leapfrog");
    for (name, ratio) in [
        ("rk4", 2.0),
        ("rk3", 0.75),
        ("symplectic-euler", 1.0),
        ("carpenter-kennedy", 2.790_1),
    ] {
        let found = leapfrog / smallest(name);
        assert!((found / ratio - 1.0).abs() < 1e-4, "{name}: {found}");
    }
    for name in ["heun", "forward-euler"] {
        let answer = onset_line(&line(name));
        assert_eq!(answer.code, Some(0), "{}", answer.stderr);
        let told = format!("Waves without damping are unstable for every time step of {name}");
        assert!(answer.stdout.contains(&told), "{}", answer.stdout);
    }
}

#[test]
fn the_answer_about_a_state_has_the_steps_of_implicit_solvers() {
    let sph = "set lattice=square set method";
    let unstable = document("state --stretch 2.9,1");
    let rate = number(&unstable, "/discretization/growth_rate");
    let implicit = &unstable["discretization"]["implicit"];
    assert_eq!(implicit["tangent"], "negative");
    for (pointer, times_rate) in [
        ("/largest_steps/newmark", 2.0),
        ("/largest_steps/backward-euler", 1.0),
        ("/growing_steps/backward-euler", 2.0),
        ("/growing_steps/generalized-alpha", 108.0_f64.sqrt()),
    ] {
        let found = number(implicit, pointer) * rate;
        assert!(
            (found / times_rate - 1.0).abs() < 1e-9,
            "{pointer}: {found}"
        );
    }
    assert!(implicit["growing_steps"]["newmark"].is_null());
    let flutter = document(&format!("state --stretch 1.05,1 {sph}=updated-sph"));
    assert_eq!(flutter["discretization"]["flutter"], true);
    let implicit = &flutter["discretization"]["implicit"];
    let lowest = number(&flutter, "/discretization/minimum_omega_squared/re");
    let definite = number(implicit, "/largest_steps/newmark");
    assert!((definite * (-lowest).sqrt() / 2.0 - 1.0).abs() < 1e-9);
    let rate = number(&flutter, "/discretization/growth_rate");
    let growing = number(implicit, "/growing_steps/backward-euler");
    assert!((growing * rate / 2.0 - 1.0).abs() < 1e-9);
    let tangent = |line: &str| document(line)["discretization"]["implicit"]["tangent"].clone();
    let total = format!("state --stretch 1.05,1 {sph}=total-lagrangian-sph");
    assert_eq!(tangent(&format!("{total} set penalty=0.5")), "positive");
    let rest = format!("state --stretch 1,1 {sph}=total-lagrangian-sph");
    assert_eq!(tangent(&rest), "zero");
    // Stress resists the zero-energy modes of nodal integration in current coordinates.
    let resisted = "state --stretch 0.95,0.95 set frame=eulerian set quadrature=nodal";
    assert_eq!(tangent(resisted), "positive");
    let transfer = "state --stretch 1,1 set method=material-points set unknowns=particles set grid-functions=quadratic-spline set transfer=apic";
    assert!(document(transfer)["discretization"]["implicit"].is_null());
}

#[test]
fn strong_damping_allows_steps_beyond_the_undamped_limit() {
    // The spectral radius of the amplification matrix exceeds one first at k = pi.
    let line = "state --stretch 1,1,1 set method=updated-sph set lattice=chain set support=1.9 set viscosity=2 set viscosity-switch=always";
    let steps = document(line);
    let step = |name: &str| number(&steps, &format!("/discretization/damped_time_steps/{name}"));
    assert!((step("kick-drift-kick") / 0.239_498 - 1.0).abs() < 1e-5);
    for name in ["central-differences", "predictor-corrector"] {
        assert!((step(name) / 0.119_749 - 1.0).abs() < 1e-5);
    }
}

#[test]
fn a_method_that_defines_its_step_is_limited_by_this_step() {
    let method = "set method=material-points set lattice=chain set unknowns=particles set transfer=apic set grid-functions=quadratic-spline";
    let line = format!("limit --all --vary material.mu --time-step 0.1 {LAW} {method}");
    let mu = number(&document(&line), "/admitted/0/to/value");
    let line = format!(
        "state --stretch 1 --set material.model=neo-hooke --set material.lambda=2 --set material.mu={mu} {method}"
    );
    let step = number(
        &document(&line),
        "/discretization/discrete_time/largest_time_step",
    );
    assert!((step / 0.1 - 1.0).abs() < 1e-6, "{step}");
}

#[test]
fn step_and_values_have_the_units_of_the_study() {
    let law = "--set material.model=neo-hooke --set material.poisson=0.3";
    let words = |step: &str| {
        let line = format!("limit --all --vary material.young {law} {BARS}");
        let mut words = super::words(&line);
        words.extend(
            [
                "--set",
                "material.young=1 MPa",
                "--set",
                "discretization.spacing=1 mm",
            ]
            .map(str::to_owned),
        );
        words.extend(["--set", "discretization.density=1000 kg/m^3"].map(str::to_owned));
        words.extend(["--time-step".to_owned(), step.to_owned()]);
        words
    };
    let asked = |step: &str| onset(&words(step).iter().map(String::as_str).collect::<Vec<_>>());
    let [with, without] = ["1 us", "1e-6"].map(asked);
    assert_eq!(with.code, Some(0), "{}", with.stderr);
    assert!(
        with.stdout
            .contains("A time step of 1e-6 s is below the critical one with material.young up to 7.42857e8 Pa."),
        "{}",
        with.stdout
    );
    assert_eq!(with.stdout, without.stdout);
    let wrong = asked("1 mm");
    assert_eq!(wrong.code, Some(2));
    assert!(
        wrong.stderr.contains("a unit of a length"),
        "{}",
        wrong.stderr
    );
}

#[test]
fn ranges_with_no_or_only_allowed_values_are_reported() {
    let line = |range: &str| {
        format!(
            "limit --all --vary discretization.spacing --time-step 0.1 --range {range} {LAW} {BARS}"
        )
    };
    let none = onset_line(&line("0.01,0.1")).stdout;
    assert!(none.contains("is below the critical one with no discretization.spacing from 0.01 to 0.1; the largest critical step is 0.05, at 0.1."), "{none}");
    let all = onset_line(&line("1,2")).stdout;
    assert!(
        all.contains("is below the critical one with every discretization.spacing from 1 to 2."),
        "{all}"
    );
}

#[test]
fn a_limit_is_printed_with_its_notes() {
    let unstable = onset_line(&format!(
        "limit --all --vary material.mu --time-step 0.01 {LAW} {BARS} --stretch 0.05 --set material.model=saint-venant-kirchhoff"
    ));
    assert!(
        unstable
            .stdout
            .contains("The verdict on the state is physical with all of these values"),
        "{}{}",
        unstable.stdout,
        unstable.stderr
    );
    assert!(
        unstable.stdout.contains("which does not limit the step."),
        "{}",
        unstable.stdout
    );
    // The range of Poisson's ratio ends at one half, with a note.
    let law = "--set material.model=neo-hooke --set material.young=2 --set material.poisson=0.3";
    let ratio = onset_line(&format!(
        "limit --all --vary material.poisson --range 0.1,0.9 --time-step 1e-9 {law} {BARS}"
    ));
    assert!(
        ratio.stdout.contains("with material.poisson up to 0.") && ratio.stdout.contains("At 0.5"),
        "{}{}",
        ratio.stdout,
        ratio.stderr
    );
    // The value is in the preceding column.
    assert!(
        !ratio.stdout.contains("material.poisson = "),
        "{}",
        ratio.stdout
    );
    // There is no smallest modulus, although zero itself is not allowed.
    let modulus =
        format!("limit --all --vary material.mu --range 0,1 --time-step 0.01 {LAW} {BARS}");
    let ends = document(&modulus);
    assert_eq!(ends["admitted"][0]["from"]["undefined_at"], 0.0, "{ends}");
    let told = onset_line(&modulus).stdout;
    assert!(
        told.contains("At 0: ") && told.contains("no value between"),
        "{told}"
    );
    // A grid step that is stable for the waves of a body, but not for an isolated material point.
    let fluid = "--energy stiffness*(sqrt(I3)-1-ln(sqrt(I3))) --set material.stiffness=400 set method=mls-mpm set lattice=square set grid=regular set spacing=0.005";
    let alone = onset_line(&format!(
        "limit --all --vary discretization.spacing --time-step 2e-4 {fluid}"
    ));
    assert!(
        alone.stdout.contains("points without neighbors"),
        "{}{}",
        alone.stdout,
        alone.stderr
    );
    let document = document(&format!(
        "limit --all --vary discretization.spacing --time-step 2e-4 {fluid}"
    ));
    assert!(document["integrator"].is_null(), "{document}");
}

#[test]
fn invalid_settings_and_steps_are_refused() {
    for (line, fact) in [
        (
            "limit --all --vary discretization.lattice --time-step 1",
            "cannot be varied",
        ),
        (
            "limit --all --vary material.yuong --time-step 1",
            "material.yuong",
        ),
        (
            "limit --all --vary discretization.spacign --time-step 1",
            "did you mean `discretization.spacing`",
        ),
        (
            "limit --all --vary discretization.penalty --time-step 1",
            "has no effect",
        ),
        (
            "limit --all --vary discretization.spacing --time-step 0",
            "a time step cannot be 0",
        ),
        (
            "limit --all --vary discretization.spacing --time-step -1",
            "a time step cannot be -1",
        ),
        (
            "limit --all --vary discretization.spacing --time-step 1us",
            "the settings have no units",
        ),
        (
            "limit --all --vary discretization.viscosity --time-step 1 set method=tlsph",
            "--range LOW,HIGH",
        ),
        (
            "limit --all --vary discretization.spacing --time-step 1 --integrator x",
            "kick-drift-kick",
        ),
        (
            "limit --all --vary discretization.time-step --time-step 1 set method=mls-mpm set lattice=square",
            "is a time step itself",
        ),
        (
            "tune discretization.time-step set method=mls-mpm set lattice=square",
            "is not a coefficient",
        ),
        (
            "limit --all --vary map.tile --time-step 1",
            "cannot be varied",
        ),
        (
            "limit --all --vary material.young --time-step 1 --set material.model=neo-hooke --set material.young=1 --set material.poisson=0.7",
            "error: --set material.poisson=0.7: material.poisson is 0.7",
        ),
    ] {
        let answer = onset_line(line);
        assert_eq!(answer.code, Some(2), "{line}: {}", answer.stdout);
        assert!(answer.stderr.contains(fact), "{line}: {}", answer.stderr);
    }
}

/// A switch has no effect at a viscosity of zero, but has one at other values.
#[test]
fn a_key_that_takes_effect_through_the_varied_setting_may_be_set() {
    let sph = "set method=updated-sph set viscosity-switch=averaged";
    let answer = document(&format!(
        "limit --all --vary discretization.viscosity --range 0,1 --time-step 0.01 {sph}"
    ));
    assert!(number(&answer, "/admitted/0/to/value") > 0.0, "{answer}");
}

#[test]
fn a_limit_is_drawn_and_listed() {
    let folder = Scratch::new("limit");
    let out = folder.display().to_string();
    let line =
        format!("limit --all --vary discretization.spacing --time-step 0.1 --quiet {LAW} {BARS}");
    let mut words = super::words(&line);
    words.extend(["--out".to_owned(), out]);
    let answer = onset(&words.iter().map(String::as_str).collect::<Vec<_>>());
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    let csv = std::fs::read_to_string(folder.join("limit.csv")).expect("a file");
    assert!(csv.lines().count() > 25, "{csv}");
    for file in ["limit.svg", "limit.png"] {
        assert!(folder.join(file).is_file(), "{file}");
    }
}

#[test]
fn the_figure_shows_the_neighborhood_of_the_limit_with_a_named_axis() {
    let folder = Scratch::new("limit-window");
    let drawn = |more: &str| {
        let line = format!(
            "limit ../../studies/rubber.toml --vary material.young --time-step 1us --quiet {more}"
        );
        let mut words = super::words(&line);
        words.extend([
            "--out".to_owned(),
            folder.join("limit.svg").display().to_string(),
        ]);
        let answer = onset(&words.iter().map(String::as_str).collect::<Vec<_>>());
        assert_eq!(answer.code, Some(0), "{}", answer.stderr);
        std::fs::read_to_string(folder.join("limit.svg")).expect("a file")
    };
    // The present value is 2 MPa and the limit 80 MPa; the values are searched from 2 Pa to 2 TPa.
    let svg = drawn("");
    for text in [
        "Young's modulus (Pa)",
        ">10⁶<",
        ">10⁸<",
        ">limit<",
        ">present value<",
    ] {
        assert!(svg.contains(text), "{text}");
    }
    for text in ["material.young (", ">10³<", ">10¹²<"] {
        assert!(!svg.contains(text), "{text}");
    }
    assert!(drawn("--range 1e3,1e12").contains(">10⁴<"));
}

#[test]
fn a_short_answer_has_the_values_next_to_the_limit() {
    let line = format!("limit --vary material.mu --time-step 0.01 {LAW} {BARS}");
    let short = onset_line(&line).stdout;
    assert!(short.lines().count() <= 12, "{short}");
    assert!(
        short.lines().all(|line| line.chars().count() <= 100),
        "{short}"
    );
    assert!(
        short.contains("step too large") && short.contains("--all"),
        "{short}"
    );
}
