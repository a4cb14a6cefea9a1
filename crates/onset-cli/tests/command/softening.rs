//! Laws that soften by previous loading, in the commands.

use crate::{Value, Written, document, number, onset_line};

const RUBBER: &str = "--set material.model=yeoh --set material.mullins-r=1.5 --set material.mullins-m=0.05 --set material.mullins-beta=0.1";
const METHOD: &str = "set method=total-lagrangian-sph set penalty=0.1";

/// Difference of the Cauchy stresses along the two axes.
fn shear_of(answer: &Value) -> f64 {
    let [first, second] = [0, 1].map(|i| number(answer, &format!("/material/cauchy/{i}/{i}")));
    first - second
}

fn shear(line: &str) -> f64 {
    shear_of(&document(line))
}

#[test]
fn primary_loading_and_unloading_have_different_tangents() {
    let state = format!("state --stretch 1.5,0.8 {METHOD}");
    let virgin = document(&format!("{state} --set material.model=yeoh"));
    let primary = document(&format!("{state} {RUBBER}"));
    assert_eq!(primary["material"]["cauchy"], virgin["material"]["cauchy"]);
    let least = [&primary, &virgin].map(|own| number(own, "/discretization/minimum_scaled"));
    assert!((least[0] / least[1] - 1.0).abs() < 1e-9, "{least:?}");
    assert!(virgin["unloading"].is_null(), "{virgin}");
    // Unloading is stiffer, and its waves limit the time step.
    let own = number(&virgin, "/discretization/critical_time_step");
    let unloading = number(&primary, "/unloading/critical_time_step");
    let step = number(&primary, "/discretization/critical_time_step");
    assert!(unloading < 0.99 * own, "{unloading} {own}");
    assert!((step / unloading - 1.0).abs() < 1e-12, "{step} {unloading}");
    let text = onset_line(&format!("{state} {RUBBER} --all")).stdout;
    let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    for note in ["every state is reached by primary loading", "eta = 1"] {
        assert!(words.contains(note), "{text}");
    }
}

#[test]
fn a_state_below_the_largest_energy_is_softer() {
    let state = format!("state --stretch 1.5,0.8 {METHOD}");
    let law = format!("{RUBBER} --set material.mullins-energy=2");
    let reloaded = document(&format!("{state} {law}"));
    assert!(reloaded["unloading"].is_null(), "{reloaded}");
    let (virgin, own) = (
        shear(&format!("{state} {RUBBER}")),
        shear(&format!("{state} {law}")),
    );
    assert!(own < 0.9 * virgin, "{own} {virgin}");
    // More energy than the largest one of the past: primary loading.
    let beyond = document(&format!(
        "{state} {RUBBER} --set material.mullins-energy=1e-3"
    ));
    assert_eq!(shear_of(&beyond), virgin);
    assert!(!beyond["unloading"].is_null(), "{beyond}");
}

#[test]
fn commands_read_a_law_that_softens() {
    let law = format!("{RUBBER} --set material.mullins-energy=0.5");
    for line in [
        format!("path --mode uniaxial --to 1.4 {RUBBER} {METHOD}"),
        format!("limit --vary discretization.spacing --time-step 0.01 {RUBBER} {METHOD}"),
        format!("modes {RUBBER} {METHOD} set lattice=chain"),
        format!("simulate --stretch 1.1,1 --cells 4 --steps 32 --quiet {law} {METHOD}"),
        format!("state --stretch 1.2,1 {law} {METHOD} --set material.plane=stress"),
        format!("state --stretch 1.2,1 {RUBBER} {METHOD} --set material.plane=stress"),
        format!("criteria --mode uniaxial {law}"),
        format!("card --mode uniaxial {law}"),
        format!("audit {law}"),
    ] {
        let answer = onset_line(&line);
        assert!(
            answer.code.is_some_and(|code| code != 2),
            "{line}: {}{}",
            answer.stdout,
            answer.stderr
        );
    }
    // The largest step follows the stiffer tangent.
    let spacing = |law: &str| {
        let line = format!(
            "limit --vary discretization.spacing --time-step 0.01 --stretch 1.5,0.8 {METHOD} {law}"
        );
        number(&document(&line), "/admitted/0/from/value")
    };
    let [virgin, primary] = ["--set material.model=yeoh", RUBBER].map(spacing);
    assert!(primary > 1.003 * virgin, "{primary} {virgin}");
}

#[test]
fn a_deck_with_the_mullins_effect_is_read() {
    let deck = "*MATERIAL, NAME=RUBBER\n*HYPERELASTIC, YEOH\n0.5, -0.01, 0.001, 0.02\n*MULLINS EFFECT\n1.5, 0.05, 0.1\n";
    let file = Written::new("softening.inp", deck);
    let state = format!("--stretch 1.5,0.8 {METHOD}");
    let read = document(&format!("state {file} {state}"));
    let set = document(&format!("state {RUBBER} {state}"));
    assert_eq!(read["material"], set["material"]);
    assert_eq!(read["unloading"], set["unloading"]);
}

#[test]
fn softening_without_meaning_is_refused() {
    for (rest, words) in [
        (
            "--set material.mullins-r=1 --set material.mullins-m=1",
            "mullins-r is 1;",
        ),
        (
            "--set material.mullins-r=2",
            "mullins-m + mullins-beta is 0;",
        ),
        (
            "--set material.mullins-r=2 --set material.mullins-m=-1",
            "mullins-m is -1;",
        ),
        (
            "--set material.mullins-m=1",
            "no effect without `material.mullins-r`",
        ),
        (
            "--set material.model=j2 --set material.mullins-r=2 --set material.mullins-m=1",
            "j2 is not a hyperelastic law",
        ),
        (
            "--set material.prony=0.1,0.1,1 --set material.mullins-r=2 --set material.mullins-m=1",
            "Prony series",
        ),
        (
            "--set material.plane=membrane --set material.mullins-r=2 --set material.mullins-m=1",
            "membrane",
        ),
        (
            "--set material.model=yeoh --set material.c10=1MPa --set material.c20=0 --set material.c30=0 --set material.kappa=9MPa set spacing=1mm \
             set density=1000kg/m^3 --set material.mullins-r=2 --set material.mullins-m=1",
            "material.mullins-m = 1 has none",
        ),
    ] {
        let answer = onset_line(&format!("state --stretch 1.1,1 {rest}"));
        assert_eq!(
            answer.code,
            Some(2),
            "{rest}: {}{}",
            answer.stdout,
            answer.stderr
        );
        assert!(answer.stderr.contains(words), "{rest}: {}", answer.stderr);
    }
}
