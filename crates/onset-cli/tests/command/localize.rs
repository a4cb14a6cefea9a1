//! `onset localize`: onset, files, and refusals.

use crate::fortran::library;
use crate::{Scratch, Written, assert_close, document, number, numbers, onset, onset_line};

#[test]
fn von_mises_in_pure_shear_localizes_at_45_degrees_where_hardening_ends() {
    let line = "localize --model j2 --path pure-shear --set material.hardening-modulus=-1";
    let answer = document(line);
    // The slope -1 + 0.2 15 exp(-15 e) of the flow stress vanishes at e = ln(3)/15, and the slip is sqrt(3) e.
    let slip = 3.0_f64.sqrt() * 3.0_f64.ln() / 15.0;
    assert_close(number(&answer, "/localization/slip"), slip, 1e-10);
    assert!(number(&answer, "/localization/critical_modulus").abs() < 1e-8);
    assert!((number(&answer, "/localization/band/angle_to_major") - 45.0).abs() < 1e-6);
    assert_eq!(answer["localization"]["band"]["kind"], "shear-band");
    assert_eq!(answer["end"], "slip");
    assert_eq!(answer["settings"]["material.model"], "j2");
    assert_eq!(answer["settings"]["material.yield-stress"], 0.4);
    assert!(answer["settings"].get("material.friction").is_none());
}

#[test]
fn the_default_localizes_while_hardening_and_loses_strong_ellipticity_earlier() {
    let answer = document("localize");
    let sentence = answer["sentence"].as_str().expect("a sentence");
    assert!(
        sentence.contains("while it still hardens")
            && sentence.contains("Strong ellipticity is lost before")
    );
    let (strong, onset) = (
        number(&answer, "/strong_ellipticity_lost/slip"),
        number(&answer, "/localization/slip"),
    );
    assert!(strong < onset);
    assert_close(
        number(&answer, "/localization/plastic_modulus"),
        number(&answer, "/localization/critical_modulus"),
        1e-9,
    );
    assert_eq!(numbers(&answer, "/localization/band/normal").len(), 3);
    assert_eq!(answer["directions"].as_array().map(Vec::len), Some(181));
    let text = onset_line("localize").stdout;
    assert!(text.starts_with(sentence));
}

#[test]
fn figure_and_tables_are_written_if_a_folder_is_given() {
    let place = Scratch::new("localize");
    let out = place.display().to_string();
    let answer = onset(&["localize", "--out", &out]);
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    for name in [
        "localize.svg",
        "localize.png",
        "localize.csv",
        "localize-directions.csv",
    ] {
        assert!(answer.stdout.contains(name));
        assert!(std::fs::metadata(place.join(name)).is_ok_and(|file| file.len() > 1000));
    }
    let table = std::fs::read_to_string(place.join("localize.csv")).expect("a table");
    let columns = table.lines().next().map(|names| names.split(',').count());
    assert!(table.lines().skip(1).count() > 100);
    assert!(
        table
            .lines()
            .all(|line| Some(line.split(',').count()) == columns)
    );
}

#[test]
fn invalid_input_is_reported_with_a_hint_and_exit_code_2() {
    for (line, facts) in [
        ("localize --model lade", ["cannot be", "drucker-prager"]),
        (
            "localize --model j2 --set material.friction=1",
            ["j2 has no parameter `friction`", "yield-stress"],
        ),
        (
            "localize --set material.fricton=1",
            ["unknown key", "material.friction"],
        ),
        (
            "localize --set plasticity.hardening=voce",
            ["unknown key", "hint"],
        ),
        (
            "localize --set material.reference-slip=1e-6",
            ["softens too fast", "reference-slip"],
        ),
        (
            "localize --path uniaxial-strain --set material.friction=2",
            ["stays elastic", "friction"],
        ),
        (
            "localize --set plasticity.bands=sheet",
            ["sheet", "uniaxial-stress"],
        ),
        (
            "localize --set plasticity.slip=0",
            ["cannot be 0", "a positive number"],
        ),
        (
            "localize --set material.confinement=-1",
            ["confinement", "a number from 0 to 1e20"],
        ),
        (
            "localize --load sideways",
            ["cannot be", "tension | compression"],
        ),
    ] {
        let answer = onset_line(line);
        assert_eq!(answer.code, Some(2), "{line}: {}", answer.stderr);
        assert_eq!(answer.stdout, "", "{line}");
        assert!(answer.stderr.starts_with("error: "), "{line}");
        for fact in facts {
            assert!(answer.stderr.contains(fact), "{line}: {}", answer.stderr);
        }
        assert!(
            answer.stderr.contains("hint: "),
            "{line}: {}",
            answer.stderr
        );
    }
}

#[test]
fn the_law_of_a_study_is_followed_as_the_law_of_the_options() {
    let text = "[material]\nmodel = 'drucker-prager'\nfriction = 0.7\nmu = 12000\nkappa = 16000\n[discretization]\nlattice = 'square'\n";
    let study = Written::new("rock.toml", text);
    let of_file = document(&format!("localize {} --path plane-strain", &*study));
    let of_options = document(
        "localize --model drucker-prager --path plane-strain --set material.friction=0.7 --set material.mu=12000 --set material.kappa=16000",
    );
    assert_eq!(of_file["localization"], of_options["localization"]);
    assert_eq!(of_file["settings"], of_options["settings"]);
    let changed = document(&format!(
        "localize {} --path plane-strain --set material.friction=0.5",
        &*study
    ));
    assert_ne!(changed["localization"], of_file["localization"]);
    let rubber = Written::new("rubber.toml", "[material]\nmodel = 'neo-hooke'\n");
    let refused = onset_line(&format!("localize {}", &*rubber));
    assert_eq!(refused.code, Some(2));
    assert!(
        refused.stderr.contains("neo-hooke") && refused.stderr.contains("a law that flows"),
        "{}",
        refused.stderr
    );
}

/// The loss of ellipticity on the path of `localize` is the long-wave limit of `state` under the same deformation.
#[test]
fn the_law_of_localize_is_the_law_of_state() {
    let law = "--set material.model=j2 --set material.mu=80GPa --set material.kappa=170GPa --set material.yield-stress=300MPa \
               --set material.saturation-stress=0.1GPa --set material.hardening-modulus=-3GPa";
    let steel = document(&format!(
        "localize --path pure-shear --set plasticity.strains=finite {law}"
    ));
    // Tension of a metal in units of its shear: sqrt(3) times the strength, and three times the modulus.
    let first = 300e6 / 3.0_f64.sqrt();
    assert_close(
        number(&steel, "/first_yield/equivalent_shear") / first,
        1.0,
        1e-2,
    );
    assert_close(number(&steel, "/first_yield/plastic_modulus"), -0.5e9, 1e-9);
    assert_eq!(steel["units"], "SI");
    let law = "--set material.model=j2 --set material.hardening-modulus=-1";
    let metal = document(&format!(
        "localize --path pure-shear --load tension --set plasticity.strains=finite {law}"
    ));
    let strain = number(&metal, "/localization/strain/0");
    let is_elliptic = |part: f64| {
        let stretch = (part * strain).exp();
        let line = format!("state --stretch {stretch},{} {law}", 1.0 / stretch);
        number(&document(&line), "/material/minimum_acoustic_eigenvalue") > 0.0
    };
    assert_eq!([is_elliptic(0.999), is_elliptic(1.001)], [true, false]);
}

#[test]
fn contradictory_laws_are_refused() {
    for (line, fact) in [
        ("--set material.model=neo-hooke", "a law that flows"),
        (
            "--set material.model=gurson --model j2",
            "two values of material.model",
        ),
        (
            "--set material.model=hill-1948 --set material.angle=10",
            "axes of the path",
        ),
        (
            "--set material.model=gurson --set material.plane=stress",
            "in three dimensions",
        ),
    ] {
        let answer = onset_line(&format!("localize {line}"));
        assert_eq!(answer.code, Some(2), "{line}: {}", answer.stdout);
        assert!(answer.stderr.contains(fact), "{line}: {}", answer.stderr);
    }
}

#[test]
fn every_law_localizes_along_its_path_or_reports_why_not() {
    let softens = "--set material.hardening-modulus=-1";
    for line in [
        "--model mohr-coulomb --set material.confinement=50",
        &format!("--model hill-1948 --set material.r0=2 --load tension {softens}"),
        "--model gurson --load tension --set plasticity.slip=2",
        "--model damage --load tension",
        "--model kinematic --load tension",
        &format!("--model deformation-theory {softens}"),
    ] {
        let answer = document(&format!("localize {line}"));
        assert!(answer["localization"].is_object(), "{line}");
    }
    // In pure shear the three reduce to the von Mises law.
    let alike = [
        format!("--model j2 {softens}"),
        format!("--model deformation-theory {softens}"),
        "--model kinematic --set material.kinematic-modulus=0 --set material.yield-stress=0.4 --set material.saturation-stress=0.2 \
         --set material.saturation-rate=15 --set material.mu=80 --set material.kappa=170 --set material.hardening-modulus=-1"
            .to_owned(),
    ];
    let slips = alike.map(|line| {
        let answer = document(&format!("localize --path pure-shear {line}"));
        let band = &answer["localization"]["band"];
        assert_eq!(band["kind"], "shear-band", "{line}");
        number(&answer, "/localization/slip")
    });
    assert_close(slips[1], slips[0], 1e-8);
    assert_close(slips[2], slips[0], 1e-8);
    for soil in [
        "localize --model cam-clay --path triaxial-compression --set material.confinement=60",
        "localize --model cap --set material.confinement=50",
    ] {
        let sentence = document(soil)["sentence"].to_string();
        assert!(sentence.contains("The material"), "{sentence}");
    }
    // Hutchinson and Neale: a power law of deformation theory necks in equibiaxial stretching at the strain (1 + 3 n)/6.
    let sheet = "localize --model deformation-theory --path sheet-stretch --load tension --set plasticity.strain-ratio=1 \
                 --set plasticity.bands=sheet --set plasticity.strains=finite --set material.exponent=0.2 --set material.saturation-stress=0 \
                 --set material.hardening-modulus=0 --set material.reference-strain=1e-6 --set material.yield-stress=0.01 --set plasticity.slip=2";
    let answer = document(sheet);
    let sentence = answer["sentence"].as_str().expect("a sentence");
    assert!(sentence.contains("localized neck forms"), "{sentence}");
    assert_close(number(&answer, "/localization/strain/0"), 1.6 / 6.0, 3e-3);
    for (line, fact) in [
        (
            "localize --model cam-clay --set material.confinement=0",
            "under the confinement 0 alone",
        ),
        (
            "localize --model gurson --set material.friction=1",
            "gurson has no parameter `friction`",
        ),
        (
            "localize --model gurson --set plasticity.confinement=1",
            "only with material.model = umat",
        ),
        (
            "localize --model gurson --set material.voids=0.9",
            "below 1/q1",
        ),
    ] {
        let answer = onset_line(line);
        assert_eq!(answer.code, Some(2), "{line}");
        assert!(answer.stderr.contains(fact), "{line}: {}", answer.stderr);
    }
}

#[test]
fn numbers_are_printed_with_few_digits() {
    for model in ["cam-clay", "cap"] {
        let answer = onset_line(&format!("localize --model {model}"));
        assert_eq!(answer.code, Some(0), "{model}: {}", answer.stderr);
        assert!(!answer.stdout.contains("e0"), "{}", answer.stdout);
    }
}

/// The routine implements the default law of `localize`.
#[test]
fn a_user_material_localizes_like_the_built_in_law() {
    let routine = library(&["fortran/drucker_prager.f90"]);
    let routine = format!(
        "localize --model umat --set material.library={} --set material.state-variables=1 \
         --set material.properties=10000,13333.333333333334,0.6,0.2,20,10,2000,0.05 --set plasticity.slip=0.1",
        routine.display()
    );
    let own = document(&format!("{routine} --set material.increments=60"));
    let law = document(&format!(
        "localize --set plasticity.slip=0.1 --set material.kappa={}",
        40_000.0 / 3.0
    ));
    for (place, tolerance) in [
        ("/first_yield/plastic_modulus", 1e-4),
        ("/first_yield/critical_modulus", 1e-4),
        ("/localization/slip", 0.02),
        ("/localization/band/angle_to_minor", 0.01),
    ] {
        assert_close(number(&own, place), number(&law, place), tolerance);
    }
    assert_eq!(
        own["localization"]["band"]["kind"],
        law["localization"]["band"]["kind"]
    );
    assert_eq!(own["settings"]["material.state-variables"], 1.0);
    let sentence = own["sentence"].as_str().expect("a sentence");
    assert!(
        sentence.contains("With half the number of increments"),
        "{sentence}"
    );
    for (line, fact) in [
        ("localize --model umat", "material.library"),
        (
            "localize --model umat --set material.library=none.so",
            "no library",
        ),
        (
            "localize --set material.library=none.so",
            "drucker-prager has no parameter `library`",
        ),
        (
            "localize --model umat --set material.model=ogden",
            "two values of material.model",
        ),
        (&format!("{routine} --set material.friction=1"), "friction"),
        (
            &format!("{routine} --set material.increments=1"),
            "less than 2",
        ),
        (
            &format!("{routine} --set material.increments=0"),
            "whole number",
        ),
    ] {
        let answer = onset_line(line);
        assert_eq!(answer.code, Some(2), "{line}: {}", answer.stdout);
        assert!(answer.stderr.contains(fact), "{line}: {}", answer.stderr);
    }
}
