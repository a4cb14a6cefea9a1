//! Viscoelastic laws in the commands.

use crate::{document, number, onset, onset_line};

const RUBBER: &str =
    "--set material.model=mooney-rivlin-isochoric --set material.prony=0.3,0,0.01;0.2,0,1";
const METHOD: &str = "set method=total-lagrangian-sph set penalty=0.1";

/// At `F = 1` there is no stress, so that fast disturbances meet the law with instantaneous moduli.
#[test]
fn time_steps_follow_the_instantaneous_moduli() {
    let step = |rest: &str| {
        let state = document(&format!("state --stretch 1,1 {METHOD} {rest}"));
        let limit = document(&format!(
            "limit --vary discretization.spacing --time-step 0.01 {METHOD} {rest}"
        ));
        [
            number(&state, "/discretization/critical_time_step"),
            number(&state, "/discretization/finite_bodies/time_step"),
            number(&limit, "/admitted/0/from/value"),
        ]
    };
    let slow = step(RUBBER);
    let fast = step(&format!("{RUBBER} --set material.loading=fast"));
    let long_term = step("--set material.model=mooney-rivlin-isochoric");
    for ((slow, fast), long_term) in slow.into_iter().zip(fast).zip(long_term) {
        // The stabilization of the relaxed state is scaled by the relaxed modulus.
        assert!((slow / fast - 1.0).abs() < 0.05, "{slow} {fast}");
        assert!((slow / long_term - 1.0).abs() > 1e-4, "{slow} {long_term}");
    }
}

/// The instantaneous moduli of constants that are long-term moduli are larger by `1/(1 - 0.5)`.
#[test]
fn constants_are_long_term_moduli_unless_they_are_set_as_instantaneous() {
    let stress = |rest: &str| {
        let answer = document(&format!("state --stretch 1.2,0.9 {METHOD} {rest}"));
        let shear = |i: usize| number(&answer, &format!("/material/cauchy/{i}/{i}"));
        shear(0) - shear(1)
    };
    let long_term = stress("--set material.model=mooney-rivlin-isochoric");
    let own = stress(RUBBER);
    let instantaneous = stress(&format!("{RUBBER} --set material.moduli=instantaneous"));
    let fast = stress(&format!("{RUBBER} --set material.loading=fast"));
    assert!((own / long_term - 1.0).abs() < 1e-12);
    assert!((instantaneous / long_term - 0.5).abs() < 1e-12);
    assert!((fast / long_term - 2.0).abs() < 1e-12);
}

/// Compression destabilizes a relaxed bar. Fast disturbances meet a larger stiffness under the same stress.
#[test]
fn a_wave_that_grows_only_as_the_stress_relaxes_has_its_delayed_rate() {
    let law = "--set material.model=saint-venant-kirchhoff --set material.prony=0.8,0.8,50";
    let state = format!("state --stretch 0.5,1 set method=fem {law}");
    let answer = document(&state);
    assert_eq!(answer["verdict"], "physical", "{answer}");
    let relaxation = &answer["relaxation"];
    assert_eq!(relaxation["fast"]["verdict"], "stable", "{relaxation}");
    let delayed = number(&answer, "/relaxation/growth_rate");
    let elastic = number(&answer, "/discretization/growth_rate");
    assert!(
        delayed > 0.0 && delayed < 0.1 * elastic,
        "{delayed} {elastic}"
    );
    let text = onset_line(&state).stdout;
    for words in [
        "before relaxation stable; a wave grows only as stress relaxes",
        "without the delay by relaxation",
    ] {
        assert!(text.contains(words), "{text}");
    }
    let fast = document(&format!("{state} --set material.loading=fast"));
    assert!(fast["relaxation"].is_null(), "{fast}");
}

/// The rate of a sheet tends to the rate of the relaxed law for fast relaxation, and is inversely proportional to the relaxation time for slow
/// relaxation.
#[test]
fn a_wave_of_a_sheet_grows_as_its_stress_relaxes() {
    let sheet = |time: &str| {
        document(&format!(
            "state --stretch 0.5,1 set method=fem --set material.model=saint-venant-kirchhoff --set material.plane=stress --set material.prony=0.8,0.8,{time}"
        ))
    };
    let fast = sheet("1e-7");
    let elastic = number(&fast, "/discretization/growth_rate");
    let rate = number(&fast, "/relaxation/growth_rate");
    assert!((rate / elastic - 1.0).abs() < 1e-5, "{rate} {elastic}");
    let [slow, slower] = ["1e4", "1e6"].map(sheet);
    let [slow, slower] = [slow, slower].map(|own| {
        assert_eq!(own["relaxation"]["fast"]["verdict"], "stable", "{own}");
        number(&own, "/relaxation/growth_rate")
    });
    assert!(slow > 0.0 && slow < 1e-2 * elastic, "{slow} {elastic}");
    assert!(
        (slow / slower / 100.0 - 1.0).abs() < 1e-3,
        "{slow} {slower}"
    );
}

#[test]
fn series_without_meaning_are_refused() {
    let state = "state --stretch 1.1,1";
    for (rest, words) in [
        (
            "--set material.model=j2 --set material.prony=0.1,0,1",
            "j2 flows",
        ),
        (
            "--set material.loading=fast",
            "no effect without `material.prony`",
        ),
        (
            "--set material.prony=0.1,0",
            "has 2 numbers; expected g, k, tau",
        ),
        ("--set material.prony=0.1,x,1", "`x` is not a number"),
        (
            "--set material.prony=0.1,0.1,1MPa",
            "`MPa` is not a unit of time",
        ),
        (
            "--set material.model=blatz-ko --set material.prony=0.1,0,1",
            "expected g = k",
        ),
        (
            "--set material.model=ogden --set material.prony=1.1,0,1",
            "a fraction g is 1.1",
        ),
        (
            "--set material.model=neo-hooke-isochoric --set material.mu=1MPa --set material.kappa=9MPa set spacing=1mm set density=1000kg/m^3 --set material.prony=0.1,0,1",
            "material.prony = 1 has none",
        ),
        (
            "--set material.model=neo-hooke-isochoric --set material.prony=0.1,0,1ms",
            "`material.prony` has a unit",
        ),
        (
            "--set material.model=neo-hooke-isochoric --set material.plane=membrane --set material.prony=0.1,0.1,1",
            "a two-dimensional law",
        ),
    ] {
        let answer = onset_line(&format!("{state} {rest}"));
        assert_eq!(
            answer.code,
            Some(2),
            "{rest}: {}{}",
            answer.stdout,
            answer.stderr
        );
        assert!(answer.stderr.contains(words), "{rest}: {}", answer.stderr);
    }
    let moved = onset_line(&format!("simulate --stretch 1.1,1 {RUBBER}"));
    assert_eq!(moved.code, Some(2));
    assert!(
        moved.stderr.contains("material.loading=fast"),
        "{}",
        moved.stderr
    );
    let listed = onset(&["list", "materials"]).stdout;
    assert!(!listed.contains("prony"), "{listed}");
}

#[test]
fn criteria_and_card_say_which_moduli_they_use() {
    for command in ["criteria --mode uniaxial", "card"] {
        let slow = onset_line(&format!("{command} {RUBBER}")).stdout;
        assert!(slow.contains("long-term moduli"), "{slow}");
        let fast = onset_line(&format!("{command} {RUBBER} --set material.loading=fast"));
        assert!(!fast.stdout.contains("long-term moduli"), "{}", fast.stdout);
    }
}
