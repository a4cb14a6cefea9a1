//! Units in values, and answers in SI.

use super::{Scratch, assert_close, document, number, onset, onset_line};

const STEEL: &str = "--set material.model=neo-hooke --set material.mu=80GPa --set material.lambda=120GPa set density=7850kg/m^3 set spacing=1mm";
const PLAIN: &str = "--set material.model=neo-hooke --set material.mu=80e9 --set material.lambda=120e9 set density=7850 set spacing=1e-3";

#[test]
fn values_with_units_give_the_same_numbers_in_si() {
    let state = |what: &str| document(&format!("state --stretch 1.02,0.99 {what}"));
    let (with, without) = (state(STEEL), state(PLAIN));
    // Words contain units, and numbers agree.
    let numbers = |state: &serde_json::Value| {
        let mut numbers = state["discretization"].clone();
        numbers["mode"].take();
        numbers
    };
    assert_eq!(numbers(&with), numbers(&without));
    assert_eq!(with["material"]["cauchy"], without["material"]["cauchy"]);
    assert_eq!(with["settings"]["material.mu"]["unit"], "Pa");
    assert!(without["settings"]["material.mu"].get("unit").is_none());
    let moduli = "--set material.model=neo-hooke --set material.young=210GPa --set material.poisson=0.3 set density=7.85g/cm^3 set spacing=1mm";
    assert_close(
        number(&state(moduli), "/settings/material.mu/value"),
        210e9 / 2.6,
        1e-14,
    );
}

#[test]
fn texts_show_si_units_only_if_values_have_units() {
    let line = |what: &str| onset_line(&format!("state --stretch 1.02,0.99 {what}"));
    let text = line(STEEL).stdout;
    for fact in [
        "mu 8e10 Pa",
        "spacing 0.001 m",
        "density 7850 kg/m^3",
        " s (infinite lattice",
        " 1/s",
        " 1/m",
        "(Pa)",
    ] {
        assert!(text.contains(fact), "{fact}: {text}");
    }
    let text = line(PLAIN).stdout;
    for fact in [" Pa", " s (infinite lattice", "kg/m"] {
        assert!(!text.contains(fact), "{fact}: {text}");
    }
    // The next command repeats the units.
    let text = line(&format!("{STEEL} set quadrature=nodal")).stdout;
    assert!(text.contains("--set material.mu=80000000000Pa"), "{text}");
}

#[test]
fn units_in_only_some_values_are_refused_with_the_values_without_units() {
    for (line, facts) in [
        (
            "state --stretch 1,1 --set material.model=neo-hooke --set material.mu=80GPa",
            vec![
                "material.lambda = 1 (the default)",
                "discretization.spacing = 1 (the default)",
                "have none",
            ],
        ),
        (
            "criteria --set material.model=neo-hooke --set material.mu=80GPa --set material.lambda=3",
            vec!["material.lambda = 3 has none"],
        ),
        (
            "state --stretch 1,1 set support=2mm",
            vec!["has no dimension"],
        ),
        (
            "state --stretch 1,1 set spacing=2GPa",
            vec!["is a length; `GPa` is a unit of a stress"],
        ),
        (
            "state --stretch 1,1 set spacing=2parsec",
            vec!["`parsec` is not a known unit"],
        ),
        ("state --stretch 1,1 set spacing=-2mm", vec!["spacing"]),
    ] {
        let answer = onset_line(line);
        assert_eq!(answer.code, Some(2), "{line}: {}", answer.stdout);
        for fact in facts {
            assert!(answer.stderr.contains(fact), "{line}: {}", answer.stderr);
        }
    }
    // A command about the law alone has no spacing.
    let law =
        "card --set material.model=neo-hooke --set material.mu=80GPa --set material.lambda=120GPa";
    assert_eq!(onset_line(law).code, Some(0));
}

#[test]
fn laws_waves_and_bands_are_printed_and_drawn_with_units() {
    let plain = "localize --path pure-shear --set material.friction=0 --set material.dilatancy=0";
    let with = "--set material.mu=10GPa --set material.kappa=13GPa --set material.strength=20MPa --set material.hardening-modulus=2GPa \
                --set material.residual=10MPa";
    let words: Vec<String> = format!("{plain} {with}")
        .split_whitespace()
        .map(str::to_owned)
        .collect();
    let place = Scratch::new("localize");
    let out = place.display().to_string();
    let mut words: Vec<&str> = words.iter().map(String::as_str).collect();
    words.extend(["--out", &out, "--all"]);
    let answer = onset(&words);
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    for fact in ["2e7 Pa", "plastic modulus h       1.8e9 Pa", "mu 1e10 Pa"] {
        assert!(answer.stdout.contains(fact), "{fact}: {}", answer.stdout);
    }
    // A modulus that is zero to rounding is printed as zero.
    let onset_of_band = answer
        .stdout
        .split("\nlocalization\n")
        .nth(1)
        .expect("an onset");
    assert!(
        onset_of_band.contains("plastic modulus h       0 Pa"),
        "{onset_of_band}"
    );
    let figure = std::fs::read_to_string(place.join("localize.svg")).expect("a figure");
    assert!(figure.contains("critical modulus (Pa)"));
    assert!(!onset_line(plain).stdout.contains("Pa"));
    // One stress without a unit among others with units is refused, with an example.
    let some = onset_line(&format!("{plain} --set material.strength=20MPa"));
    assert_eq!(some.code, Some(2));
    assert!(
        some.stderr.contains("material.mu = 10000 (the default)"),
        "{}",
        some.stderr
    );

    let law = "--set material.model=neo-hooke --set material.mu=80GPa --set material.lambda=120GPa";
    for command in ["card", "criteria --mode uniaxial"] {
        let text = onset_line(&format!("{command} {law}")).stdout;
        assert!(
            text.starts_with("neo-hooke (mu = 8e10 Pa, lambda = 1.2e11 Pa), isotropic."),
            "{text}"
        );
        let told = document(&format!("{command} {law}"));
        assert_eq!(told["material"]["units"]["mu"], "Pa");
    }

    let place = Scratch::new("waves");
    let out = place.display().to_string();
    let text = onset_line(&format!(
        "dispersion --stretch 1.2,0.9 --path --out {out} {STEEL}"
    ));
    assert!(
        text.stdout.contains(" 1/m (reference)") && text.stdout.contains(" 1/s^2"),
        "{}",
        text.stdout
    );
    let figure = std::fs::read_to_string(place.join("dispersion.svg")).expect("a figure");
    for label in ["frequency ω (1/s)", "density of states (s)"] {
        assert!(figure.contains(label), "{label}");
    }
    // A stable state has no growth rate.
    assert!(!figure.contains("growth rate"));
    let wave = format!("dispersion --stretch 1.2,0.9 --wave-vector 1000,0 {STEEL}");
    assert!(
        onset_line(&wave)
            .stdout
            .contains("reference wave vector  (1000, 0) 1/m")
    );
    let place = Scratch::new("modes");
    let out = place.display().to_string();
    onset_line(&format!("modes --out {out} {STEEL} set quadrature=nodal"));
    let figure = std::fs::read_to_string(place.join("modes.svg")).expect("a figure");
    assert!(figure.contains("x₁ (m)"));
}

#[test]
fn a_study_with_units_is_written_and_read_back_with_its_units() {
    let place = Scratch::new("study.toml");
    let text = "[material]\nmodel = \"neo-hooke\"\nlambda = \"120 GPa\"\n[discretization]\nspacing = \"1 mm\"\ndensity = \"7850 kg/m^3\"\n\
                [[axes]]\nquantity = \"stretch-1\"\nrange = [0.9, 1.1]\nstates = 3\n\
                [[axes]]\nquantity = \"material.mu\"\nrange = [\"70 GPa\", \"90 GPa\"]\nstates = 3\n";
    std::fs::write(&place, text).expect("a file");
    let file = place.display().to_string();
    let checked = document(&format!("check {file}"));
    assert_eq!(checked[0]["axes"][1]["range"][1], 90e9);
    // An override writes the complete study, and a resumed map reads it back.
    let store = Scratch::new("map.zarr");
    let map = format!("map {file} --out {} set support=1.9", store.display());
    let first = document(&map);
    assert_eq!(number(&first, "/tiles_computed"), 1.0);
    let again = document(&format!("{map} --resume"));
    assert_eq!(number(&again, "/tiles_found"), 1.0);
    std::fs::write(&place, text.replace("\"1 mm\"", "1e-3")).expect("a file");
    let refused = onset_line(&format!("check {file}"));
    assert_eq!(refused.code, Some(2));
    assert!(
        refused
            .stderr
            .contains("discretization.spacing = 0.001 has none"),
        "{}",
        refused.stderr
    );
}

/// Steel with a spacing of a meter, a millimeter and a micrometer, in cells of several particles: all numbers scale with the spacing.
#[test]
fn cells_of_several_particles_have_one_verdict_in_all_units() {
    let steel = "--set material.young=210GPa --set material.poisson=0.3 set density=7850kg/m^3";
    let perturbed = "set lattice=square set cells=2 set perturbation=0.1 set corrected=false";
    let ordinary =
        "set method=peridynamics set lattice=honeycomb set bonds=ordinary set horizon=2.5";
    for (stretch, law, method) in [
        ("0.7,0.8", "neo-hooke", ordinary.to_owned()),
        ("0.8,0.7", "saint-venant-kirchhoff", ordinary.to_owned()),
        (
            "0.8,1.1",
            "hencky",
            format!("set method=total-lagrangian-sph {perturbed}"),
        ),
        (
            "0.9,0.8",
            "neo-hooke",
            format!("set method=updated-sph {perturbed}"),
        ),
    ] {
        let of = |spacing: &str| {
            document(&format!(
                "state --stretch {stretch} --set material.model={law} {steel} {method} set spacing={spacing}"
            ))
        };
        let meter = of("1m");
        for (spacing, unit) in [("1mm", 1e-3), ("1um", 1e-6)] {
            let other = of(spacing);
            for name in ["verdict", "mechanism"] {
                assert_eq!(other[name], meter[name], "{law} {method} {spacing}");
            }
            for (pointer, power) in [
                ("/discretization/growth_rate", -1),
                ("/discretization/maximum_omega", -1),
                ("/discretization/minimum_scaled", 0),
                ("/discretization/long_wave_minimum_scaled", 0),
            ] {
                let [own, expected] = [&other, &meter].map(|own| number(own, pointer));
                let expected = expected * f64::powi(unit, power);
                assert!(
                    (own - expected).abs() <= 1e-6 * expected.abs(),
                    "{law} {method} {spacing} {pointer}: {own} is not {expected}"
                );
            }
        }
    }
}
