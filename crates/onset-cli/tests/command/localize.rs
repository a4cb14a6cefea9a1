//! `onset localize`: onset, files, and refusals.

use crate::fortran::library;
use crate::{Scratch, Written, assert_close, document, number, numbers, onset, onset_line};

#[test]
fn von_mises_in_pure_shear_localizes_at_45_degrees_where_hardening_ends() {
    let answer = document("localize --model j2 --path pure-shear");
    // The plastic modulus h vanishes at gamma = r - (k0 - kr)/m = 0.05 - 10/2000.
    assert_close(number(&answer, "/localization/slip"), 0.045, 1e-10);
    assert!(number(&answer, "/localization/critical_modulus").abs() < 1e-8);
    assert!((number(&answer, "/localization/band/angle_to_major") - 45.0).abs() < 1e-6);
    assert_eq!(answer["localization"]["band"]["kind"], "shear-band");
    assert_eq!(answer["end"], "slip");
    assert_eq!(answer["settings"]["plasticity.model"], "j2");
    assert!(answer["settings"].get("plasticity.friction").is_none());
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
        (
            "localize --model lade",
            ["cannot be", "drucker-prager | j2"],
        ),
        (
            "localize --model j2 --set plasticity.friction=1",
            ["no effect", "drucker-prager"],
        ),
        (
            "localize --set plasticity.fricton=1",
            ["unknown key", "plasticity.friction"],
        ),
        (
            "localize --set plasticity.poisson-ratio=0.5",
            ["poisson-ratio` cannot be 0.5", "below 0.5"],
        ),
        (
            "localize --set plasticity.reference-slip=1e-6",
            ["softens too fast", "reference-slip"],
        ),
        (
            "localize --path uniaxial-strain --set plasticity.friction=2",
            ["stays elastic", "friction"],
        ),
        (
            "localize --set plasticity.bands=sheet",
            ["sheet", "uniaxial-stress"],
        ),
        (
            "localize --set plasticity.slip=0",
            ["cannot be 0", "positive number"],
        ),
        (
            "localize --set plasticity.confinement=-1",
            ["confinement", "a number from 0 to 1e20 (stress)"],
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
    let poisson = (3.0 * 16000.0 - 2.0 * 12000.0) / (2.0 * (3.0 * 16000.0 + 12000.0));
    let of_options = document(&format!(
        "localize --model drucker-prager --path plane-strain --set plasticity.friction=0.7 --set plasticity.shear-modulus=12000 \
         --set plasticity.poisson-ratio={poisson}"
    ));
    assert_eq!(of_file["localization"], of_options["localization"]);
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

#[test]
fn the_keys_of_a_material_give_the_law_as_for_other_commands() {
    let of = |line: &str| document(&format!("localize {line}"));
    let poisson = (3.0 * 16000.0 - 2.0 * 12000.0) / (2.0 * (3.0 * 16000.0 + 12000.0));
    let constants = "--set material.voids=0.02 --set material.mu=12000 --set material.kappa=16000 --set material.strength=20 --set material.residual=10 \
                     --set material.hardening-modulus=2000 --set material.reference-slip=0.05";
    let own = of(&format!(
        "--set material.model=gurson {constants} --load tension"
    ));
    let same = of(&format!(
        "--model gurson --set plasticity.voids=0.02 --set plasticity.shear-modulus=12000 --set plasticity.poisson-ratio={poisson} --load tension"
    ));
    for place in ["plastic_modulus", "critical_modulus", "band/angle_to_minor"] {
        let [own, same] = [&own, &same].map(|all| number(all, &format!("/first_yield/{place}")));
        assert_close(own, same, 1e-9);
    }
    // Tension of a metal in units of its shear: sqrt(3) times the strength, and three times the modulus.
    let metal = "--path pure-shear --set plasticity.slip=0.01 --set material.model=j2 --set material.saturation-stress=0 --set material.yield-stress=300MPa \
                 --set material.mu=80GPa --set material.kappa=170GPa --set material.hardening-modulus=-3GPa";
    let steel = of(metal);
    assert_close(
        number(&steel, "/first_yield/equivalent_shear"),
        300e6 / 3.0_f64.sqrt(),
        1e-9,
    );
    assert_close(number(&steel, "/first_yield/plastic_modulus"), -1e9, 1e-9);
    assert_eq!(steel["units"], "SI");
    let saturating = of(
        "--path pure-shear --set material.model=j2 --set material.hardening-modulus=0 --set material.saturation-stress=-0.1",
    );
    assert_close(
        number(&saturating, "/first_yield/plastic_modulus"),
        -0.1 * 15.0 / 3.0,
        1e-9,
    );
    for (line, fact) in [
        ("--set material.model=neo-hooke", "a law that flows"),
        ("--set material.model=gurson --model j2", "are two laws"),
        ("--set material.model=j2", "material.saturation-stress=0"),
        (
            "--set material.model=hill-1948 --set material.angle=10",
            "material.angle=0",
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
    for line in [
        "--model mohr-coulomb --set plasticity.confinement=50",
        "--model hill-1948 --set plasticity.r0=2 --load tension",
        "--model gurson --load tension",
        "--model damage --load tension",
    ] {
        let answer = document(&format!("localize {line}"));
        assert!(answer["localization"].is_object(), "{line}");
    }
    // In pure shear both reduce to the von Mises law.
    for line in [
        "--model kinematic --set plasticity.kinematic-modulus=0 --path pure-shear",
        "--model deformation-theory --path pure-shear",
    ] {
        let answer = document(&format!("localize {line}"));
        assert_close(number(&answer, "/localization/slip"), 0.045, 1e-8);
        assert_eq!(
            answer["localization"]["band"]["kind"], "shear-band",
            "{line}"
        );
    }
    for line in [
        "localize --model cam-clay --path triaxial-compression --set plasticity.confinement=60",
        "localize --model cap --set plasticity.confinement=50",
    ] {
        let answer = document(line);
        assert!(
            answer["sentence"]
                .as_str()
                .is_some_and(|text| text.starts_with("The material"))
        );
        assert!(
            answer["settings"].get("plasticity.hardening").is_none(),
            "{line}"
        );
    }
    let sheet = "localize --model deformation-theory --path sheet-stretch --load tension --set plasticity.strain-ratio=1 \
                 --set plasticity.bands=sheet --set plasticity.strains=finite --set plasticity.hardening=power \
                 --set plasticity.exponent=0.2 --set plasticity.slip=2";
    let answer = document(sheet);
    let sentence = answer["sentence"].as_str().expect("a sentence");
    assert!(sentence.contains("localized neck forms"), "{sentence}");
    for (line, fact) in [
        (
            "localize --model cam-clay --set plasticity.confinement=0",
            "under the confinement 0 alone",
        ),
        (
            "localize --model gurson --set plasticity.friction=1",
            "only with plasticity.model = drucker-prager",
        ),
        (
            "localize --model cap --set plasticity.exponent=1",
            "no effect",
        ),
        (
            "localize --model gurson --set plasticity.voids=0.9",
            "below 1/q1",
        ),
    ] {
        let answer = onset_line(line);
        assert_eq!(answer.code, Some(2), "{line}");
        assert!(answer.stderr.contains(fact), "{line}: {}", answer.stderr);
    }
}

#[test]
fn every_model_localizes_with_default_settings() {
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
    let own = document(&format!("{routine} --set plasticity.increments=60"));
    let law = document("localize --set plasticity.slip=0.1");
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
            "only with plasticity.model = umat",
        ),
        (
            "localize --model umat --set material.model=ogden",
            "a law that flows",
        ),
        (
            &format!("{routine} --set plasticity.friction=1"),
            "no effect",
        ),
        (
            &format!("{routine} --set material.increments=10"),
            "plasticity.increments is the number",
        ),
        (
            &format!("{routine} --set plasticity.increments=0"),
            "whole number",
        ),
    ] {
        let answer = onset_line(line);
        assert_eq!(answer.code, Some(2), "{line}: {}", answer.stdout);
        assert!(answer.stderr.contains(fact), "{line}: {}", answer.stderr);
    }
}
