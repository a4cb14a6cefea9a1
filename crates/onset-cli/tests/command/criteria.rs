//! `onset criteria` and `onset card`.

use super::{Scratch, Written, assert_close, document, number, onset};
use serde_json::Value;

const BLATZ_KO: &str = "--set material.model=blatz-ko";

fn criterion<'a>(loading: &'a Value, name: &str) -> &'a Value {
    let criteria = loading["criteria"].as_array().expect("a list");
    let found = criteria.iter().find(|answer| answer["criterion"] == name);
    found.unwrap_or_else(|| panic!("no criterion {name}"))
}

#[test]
fn criteria_of_a_bar_are_printed_with_their_limits_and_waves() {
    let answer = document(&format!("criteria {BLATZ_KO} --mode uniaxial"));
    assert_eq!(answer["loadings"].as_array().expect("a list").len(), 3);
    let bar = &answer["loadings"][0];
    assert_eq!(bar["lateral"], "free");
    let load = number(criterion(bar, "load-maximum"), "/tension/limit");
    assert_close(load, 6.0_f64.powf(0.4), 1e-10);
    let waves = criterion(bar, "strong-ellipticity");
    assert_close(
        number(waves, "/tension/limit"),
        (2.0 + 3.0_f64.sqrt()).powf(0.8),
        1e-10,
    );
    assert_eq!(waves["tension"]["changes"][0]["witness"]["kind"], "wave");
    assert!(criterion(bar, "drucker")["tension"]["limit"].is_null());
    assert_eq!(answer["polyconvexity"]["knowledge"], "not-polyconvex");
    let sentences = answer["disagreements"].to_string();
    assert!(
        sentences.contains("uniaxial, lateral faces free, tension from 2.04767 (waves to 2.86786)"),
        "{sentences}"
    );
    assert!(
        sentences.contains(
            "Drucker's criterion still holds where ellipticity is lost: uniaxial, lateral"
        ),
        "{sentences}"
    );
}

#[test]
fn criteria_draw_a_figure_on_request() {
    let folder = Scratch::new("criteria");
    let place = folder.display().to_string();
    let answer = onset(&[
        "criteria",
        "--set",
        "material.model=blatz-ko",
        "--mode",
        "hydrostatic",
        "--out",
        &place,
    ]);
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    assert!(answer.stdout.contains("criteria.svg"), "{}", answer.stdout);
    let svg = std::fs::read_to_string(folder.join("criteria.svg")).expect("a figure");
    assert!(svg.contains("hydrostatic") && svg.contains("strong ellipticity"));
    assert!(folder.join("criteria.png").is_file());
}

#[test]
fn a_card_is_a_self_contained_page() {
    let folder = Scratch::new("card");
    let place = folder.display().to_string();
    let answer = document(&format!("card {BLATZ_KO} --out {place}"));
    let ratio = 2.0 + 3.0_f64.sqrt();
    assert_close(number(&answer, "/symmetric_box/high"), ratio.sqrt(), 1e-9);
    let widest = number(&answer, "/widest_box/high") / number(&answer, "/widest_box/low");
    assert_close(widest, ratio, 1e-9);
    let page = std::fs::read_to_string(folder.join("card.html")).expect("a page");
    // References within the page start with `#`.
    let outward = page.replace("url(#", "");
    for reference in ["src=", "href=\"http", "@import", "url("] {
        assert!(!outward.contains(reference), "{reference}");
    }
    assert!(page.contains("<svg") && page.contains("1.93185"), "{page}");
    for name in ["card.json", "card.svg", "card.png"] {
        assert!(folder.join(name).is_file(), "{name}");
    }
    let stored = std::fs::read_to_string(folder.join("card.json")).expect("a document");
    let stored: Value = serde_json::from_str(&stored).expect("JSON");
    assert_eq!(stored, answer);
}

#[test]
fn invalid_ranges_modes_and_laws_are_refused() {
    for (arguments, fact) in [
        (
            vec!["criteria", "--range", "2,3"],
            "below 1 and a number above 1",
        ),
        (vec!["criteria", "--range", "2"], "0.1,10"),
        (
            vec!["card", "--range", "0.1,1e9"],
            "below 1 and a number above 1",
        ),
        (vec!["criteria", "--mode", "torsion"], "simple-shear"),
        (
            vec!["criteria", "--set", "material.modl=blatz-ko"],
            "did you mean",
        ),
        (vec!["card", "nowhere.toml"], "cannot read nowhere.toml"),
    ] {
        let answer = onset(&arguments);
        assert_eq!(answer.code, Some(2), "{arguments:?}");
        assert!(
            answer.stderr.contains(fact),
            "{arguments:?}: {}",
            answer.stderr
        );
    }
}

/// Input block in a separate file.
fn block(name: &str, text: &str) -> Written {
    Written::new(&format!("{name}.inp"), text)
}

/// Treloar's rubber with the constants of Abaqus, which are `mu_i alpha_i / 2` in terms of Ogden's constants, equals the default of `ogden`.
#[test]
fn an_ogden_block_of_abaqus_gives_the_ogden_law() {
    let text = "** Treloar\n*MATERIAL, NAME=RUBBER\n*Hyperelastic, n=3, OGDEN\n0.40157, 1.3, 0.0029425, 5.0, 0.009807, -2.0, 0.02, 0.0\n0.0\n*DENSITY\n1e-9\n";
    let file = block("abaqus-ogden", text);
    let read = document(&format!("criteria {file} --from abaqus --mode equibiaxial"));
    let own = document("criteria --set material.model=ogden --mode equibiaxial");
    for (name, value) in [
        ("mu1", 0.6178),
        ("mu2", 0.001_177),
        ("mu3", -0.009_807),
        ("kappa", 100.0),
    ] {
        let found = number(&read, &format!("/material/parameters/{name}"));
        assert!((found / value - 1.0).abs() < 1e-12, "{name} {found}");
    }
    let lost = |answer: &Value| {
        number(
            criterion(&answer["loadings"][0], "drucker-abaqus"),
            "/compression/limit",
        )
    };
    assert_close(lost(&read), lost(&own), 1e-9);
    assert_close(lost(&own), 0.2887, 5e-4);
    let answer = onset(&["criteria", &file, "--from", "abaqus", "--mode", "uniaxial"]);
    assert!(
        answer.stdout.contains("shear modulus 0.4143"),
        "{}",
        answer.stdout
    );
    assert!(
        answer.stdout.contains(
            "note: read as ogden from *HYPERELASTIC, OGDEN, N=3 of Abaqus, material RUBBER"
        ),
        "{}",
        answer.stdout
    );
}

#[test]
fn incompressible_response_has_a_surface_criterion_and_no_volumetric_part() {
    let law = "--set material.model=neo-hooke";
    let answer = document(&format!("criteria {law} --incompressible"));
    assert_eq!(answer["loadings"].as_array().expect("a list").len(), 4);
    let equibiaxial = &answer["loadings"][1];
    let wrinkles = criterion(equibiaxial, "surface");
    // Biot's critical stretch of a surface is 0.666.
    assert_close(
        number(wrinkles, "/compression/limit"),
        0.295_597_742_522_f64.cbrt(),
        1e-9,
    );
    assert_eq!(
        wrinkles["compression"]["changes"][0]["witness"]["kind"],
        "surface-wave"
    );
    assert!(criterion(equibiaxial, "strong-ellipticity")["compression"]["limit"].is_null());
    for (arguments, fact) in [
        (
            "criteria --incompressible --set material.model=cubic-crystal",
            "is not isotropic",
        ),
        (
            "criteria --incompressible --mode hydrostatic",
            "needs a traction-free face",
        ),
    ] {
        let arguments: Vec<&str> = arguments.split(' ').collect();
        let answer = onset(&arguments);
        assert_eq!(answer.code, Some(2), "{arguments:?}");
        assert!(answer.stderr.contains(fact), "{}", answer.stderr);
    }
}

#[test]
fn a_limit_along_jumps_is_reported_as_an_upper_bound() {
    let arguments = [
        "criteria",
        "--set",
        "material.model=neo-hooke",
        "--mode",
        "equibiaxial",
        "--all",
    ];
    let answer = onset(&arguments);
    assert!(answer.stdout.contains(" ≤ 4.24336 "), "{}", answer.stdout);
    assert!(answer.stdout.contains("upper bound"), "{}", answer.stdout);
    let answer_in_json = document("criteria --set material.model=neo-hooke --mode equibiaxial");
    for (name, is_bound) in [("rank-one-convexity", true), ("strong-ellipticity", false)] {
        let found = criterion(&answer_in_json["loadings"][1], name);
        assert_eq!(found["tension"]["upper_bound"], is_bound, "{found}");
        assert_eq!(found["compression"]["upper_bound"], false, "{found}");
    }
    assert!(
        answer
            .stdout
            .contains("lowers the energy, verified in interval arithmetic"),
        "{}",
        answer.stdout
    );
}

#[test]
fn blocks_that_determine_no_law_are_refused_with_the_line_number() {
    for (name, program, text, fact) in [
        ("none", "abaqus", "*DENSITY\n1\n", "expected *HYPERELASTIC"),
        (
            "marlow",
            "abaqus",
            "*HYPERELASTIC, MARLOW\n",
            "table of one test",
        ),
        (
            "marlow-signs",
            "abaqus",
            "*HYPERELASTIC, MARLOW\n*UNIAXIAL TEST DATA\n0.1, 0.1\n-0.2, 0.2\n",
            ":4:",
        ),
        (
            "marlow-both",
            "abaqus",
            "*HYPERELASTIC, MARLOW\n*UNIAXIAL TEST DATA\n0.1, 0.1\n-0.2, -0.2\n",
            "tension and compression",
        ),
        (
            "marlow-volume",
            "abaqus",
            "*HYPERELASTIC, MARLOW\n*UNIAXIAL TEST DATA\n0.1, 0.1\n0.2, 0.2\n*VOLUMETRIC TEST DATA\n1, 0.99\n",
            "material.kappa",
        ),
        (
            "fit",
            "abaqus",
            "*HYPERELASTIC, OGDEN, TEST DATA INPUT\n",
            "test data",
        ),
        (
            "few",
            "abaqus",
            "*HYPERELASTIC, POLYNOMIAL, N=3\n1, 2, 3\n",
            "2 data lines with 12 constants",
        ),
        (
            "many",
            "abaqus",
            "*HYPERELASTIC, NEO HOOKE\n1, 2, 3, 4\n",
            ":2:",
        ),
        (
            "word",
            "abaqus",
            "*HYPERELASTIC, NEO HOOKE\nC10, 2\n",
            "`C10` is not a number",
        ),
        (
            "form",
            "abaqus",
            "*HYPERELASTIC, USER\n1\n",
            "`USER`, which is not supported",
        ),
        (
            "angles",
            "abaqus",
            "*ANISOTROPIC HYPERELASTIC, HOLZAPFEL, LOCAL DIRECTIONS=2\n7.64e-3, 0.02, 0.9966, 524.6, 0.226\n",
            "material.fiber1-angle",
        ),
        ("tb", "ansys", "MP,DENS,1,2\n", "expected TB,HYPER"),
        (
            "user",
            "ansys",
            "TB,HYPER,1,,2,USER\n",
            "`USER` is not supported",
        ),
    ] {
        let file = block(&format!("block-{name}"), text);
        let answer = onset(&["criteria", &file, "--from", program, "--mode", "uniaxial"]);
        assert_eq!(answer.code, Some(2), "{name}: {}", answer.stdout);
        assert!(answer.stderr.contains(fact), "{name}: {}", answer.stderr);
    }
    let answer = onset(&["criteria", "--from", "abaqus"]);
    assert_eq!(answer.code, Some(2));
    let answer = onset(&["criteria", "x.inp", "--from", "comsol"]);
    assert!(
        answer
            .stderr
            .contains("abaqus, ansys, calculix, febio, felupe, hyperelastic, lsdyna or radioss"),
        "{}",
        answer.stderr
    );
}

/// With default settings the command finds this limit or an earlier limit.
#[test]
fn jumps_to_zero_volume_are_followed_for_any_range() {
    for (law, limit) in [("cubic-crystal", 0.969_65), ("fung", 0.952_13)] {
        let answer = document(&format!(
            "criteria --set material.model={law} --mode hydrostatic"
        ));
        let found = criterion(&answer["loadings"][0], "rank-one-convexity");
        assert!(
            number(found, "/compression/limit") > limit - 6e-6,
            "{law}: {found}"
        );
        let witness = &found["compression"]["changes"][0]["witness"];
        assert_eq!(witness["verified"], true, "{law}");
        assert_eq!(witness["at_edge"], false, "{law}");
    }
    let answer = document("criteria --set material.model=saint-venant-orthotropic --mode uniaxial");
    let loadings = answer["loadings"].as_array().expect("a list");
    let held = loadings.iter().find(|loading| loading["lateral"] == "held");
    let found = criterion(held.expect("uniaxial strain"), "rank-one-convexity");
    assert!(
        number(found, "/compression/limit") > 0.981_20 - 6e-6,
        "{found}"
    );
}

#[test]
fn a_card_lists_every_limit_with_nominal_strain_and_stress() {
    let card = document(&format!("card {BLATZ_KO} --mode uniaxial"));
    let bar = &card["loadings"][0];
    let limit = |name: &str| criterion(bar, name);
    let load = limit("load-maximum");
    let stretch = 6.0_f64.powf(0.4);
    assert_close(number(load, "/tension/imposed"), stretch, 1e-9);
    assert_close(number(load, "/tension/nominal_strain"), stretch - 1.0, 1e-9);
    let mu = number(&card, "/material/parameters/mu");
    let stress = mu * (stretch.powf(-0.5) - stretch.powi(-3));
    assert_close(number(load, "/tension/nominal_stress"), stress, 1e-9);
    for name in [
        "strong-ellipticity",
        "drucker-abaqus",
        "hill",
        "hill-rotation-free",
    ] {
        assert_eq!(limit(name)["defined"], true, "{name}");
    }
    let text = onset(&[
        "card",
        "--set",
        "material.model=blatz-ko",
        "--mode",
        "uniaxial",
        "--all",
    ]);
    assert!(text.stdout.contains("nominal stress"), "{}", text.stdout);
    assert!(text.stdout.contains("load-maximum"), "{}", text.stdout);
}

#[test]
fn limits_at_a_bifurcation_of_free_faces_report_the_stress_just_before_it() {
    // Waves along the faces lose stability where a second state with free faces branches off, and the path ends there.
    let card = document(
        "card --set material.model=ogden --set material.mu3=0.8479413870763222 --set material.mu5=0.6401741403941579 \
         --set material.mu6=6.0021899710915445 --set material.alpha6=0.9981311104709767 --set material.kappa=0.7291015901767021 --mode uniaxial",
    );
    let bar = &card["loadings"][0];
    let stress = |name: &str| number(criterion(bar, name), "/tension/nominal_stress");
    assert_close(stress("drucker-abaqus"), stress("strong-ellipticity"), 1e-6);
}

#[test]
fn a_card_of_an_incompressible_law_has_limits_and_no_boxes() {
    let card = document("card --set material.model=ogden --incompressible --mode equibiaxial");
    assert_eq!(card["material"]["incompressible"], true);
    assert!(card["symmetric_box"].is_null() && card["widest_box"].is_null());
    // Ogden's fit of Treloar's rubber passes Drucker's check throughout.
    let drucker = criterion(&card["loadings"][0], "drucker-abaqus");
    assert!(drucker["tension"].is_null() && drucker["compression"].is_null());
}

#[test]
fn the_short_card_has_the_box_the_limits_and_the_ends() {
    let short = |line: &str| {
        let words: Vec<&str> = line.split_whitespace().collect();
        onset(&words).stdout
    };
    let text = short("card --set material.model=blatz-ko");
    // The widest box ends where the ratio of two stretches is 2 + sqrt 3.
    assert!(text.starts_with("blatz-ko (shear modulus 32"), "{text}");
    assert!(text.contains("between 0.517639 and 1.93185."), "{text}");
    // All loadings of a single mode are shown, otherwise the first of each.
    let text = short("card --set material.model=blatz-ko --mode uniaxial");
    let cells: Vec<&str> = text
        .lines()
        .find_map(|line| line.strip_prefix("uniaxial strain"))
        .expect("a line")
        .split_whitespace()
        .collect();
    let document = document("card --set material.model=blatz-ko --mode uniaxial");
    let loadings = document["loadings"].as_array().expect("a list");
    let mut loadings = loadings.iter();
    let strain = loadings.find(|own| own["title"] == "uniaxial strain");
    let strain = strain.expect("uniaxial strain");
    for (cell, name) in cells.iter().zip(["/compression", "/tension"]) {
        let shown: f64 = cell.parse().expect("a number");
        assert_close(shown, number(strain, name), 1e-5);
    }
    let text = short("card --set material.model=generalized-blatz-ko --set material.nu=0.499995");
    assert!(
        text.contains("note: hydrostatic ends at stretch 0.998856"),
        "{text}"
    );
    let text = short("card --set material.model=ogden --incompressible");
    assert!(
        text.starts_with("Limits of strong ellipticity of ogden"),
        "{text}"
    );
}

#[test]
fn kinks_give_a_warning() {
    let energy = "mu/2*(I1bar - 3) + if(I1bar > 3.5, 2*(I1bar - 3.5)^2, 0) + 50*(J - 1)^2";
    let arguments = [
        "card",
        "--energy",
        energy,
        "--set",
        "material.mu=1",
        "--incompressible",
        "--mode",
        "uniaxial",
    ];
    let text = onset(&arguments);
    assert!(
        text.stdout.contains("kink of the stress at stretch"),
        "{}",
        text.stdout
    );
    let json = onset(&[&arguments[..], &["--json"]].concat());
    let card: Value = serde_json::from_str(&json.stdout).expect("JSON");
    let kinks = card["loadings"][0]["kinks"].as_array().expect("a list");
    assert_eq!(kinks.len(), 2, "{kinks:?}");
    for kink in kinks {
        let l = number(kink, "/imposed");
        assert!((l * l + 2.0 / l - 3.5).abs() < 1e-9, "{l}");
    }
}

/// With `W = 10 (I1 - 3 - 2 ln J) + 20 (J - 1)^2 + f(J)` all jumps are at `J = 1.2`.
#[test]
fn jumps_of_a_law_are_classified_in_every_loading() {
    let smooth = "10*(I1-3-2*ln(J)) + 20*(J-1)^2";
    let [held, equal, hydrostatic] = [1.0, 0.5, 1.0 / 3.0].map(|power| 1.2_f64.powf(power));
    let tension = |answer: &Value, title: &str| -> (Value, Option<f64>) {
        let loadings = answer["loadings"].as_array().expect("a list");
        let own = loadings.iter().find(|loading| loading["title"] == title);
        let own = own.expect("the loading");
        let limit = &criterion(own, "rank-one-convexity")["tension"]["limit"];
        (own["kinks"].clone(), limit.as_f64())
    };
    // Crossing a concave kink of size c lowers the energy if (J - J0) < c/(2 q), where q is the stiffness along the jump.
    for (term, kind, size, lost) in [
        ("+ 2*macaulay(J-1.2)", "jump-of-stress", 2.0, None),
        ("- 2*macaulay(J-1.2)", "jump-of-stress", -2.0, Some(true)),
        ("+ 0.3*heaviside(J-1.2)", "step-of-energy", 0.3, Some(false)),
        ("+ 2*macaulay(J-1.2)^2", "kink-of-stress", 4.0, None),
    ] {
        let energy = format!("{smooth} {term}");
        let text = onset(&["criteria", "--json", "--energy", &energy]);
        let answer: Value = serde_json::from_str(&text.stdout).expect("JSON");
        for (title, stretch) in [
            ("uniaxial strain", held),
            ("equibiaxial, plane strain", equal),
            ("hydrostatic", hydrostatic),
        ] {
            let (kinks, limit) = tension(&answer, title);
            let [kink] = &kinks.as_array().expect("a list")[..] else {
                panic!("{term}, {title}: {kinks}");
            };
            assert_eq!(kink["kind"], kind, "{term}, {title}");
            assert_close(number(kink, "/imposed"), stretch, 1e-9);
            let told = match kind {
                "jump-of-stress" => "/mean_stress",
                "step-of-energy" => "/energy",
                _ => "/bulk_tangent",
            };
            assert_close(number(kink, told), size, 1e-6);
            match (lost, limit) {
                (None, None) => {}
                (Some(false), Some(limit)) => assert_close(limit, stretch, 1e-9),
                (Some(true), Some(limit)) => {
                    assert!(
                        limit < stretch && limit > 0.97 * stretch,
                        "{title}: {limit}"
                    );
                }
                _ => panic!("{term}, {title}: {limit:?}"),
            }
        }
        let (kinks, limit) = tension(&answer, "uniaxial, lateral faces free");
        assert_eq!(kinks[0]["kind"], kind, "{term}: {kinks}");
        assert_eq!(limit.is_some(), lost.is_some(), "{term}: {limit:?}");
    }
}

/// Table of one test in an input block of Abaqus.
const TABLE: &str = "*HYPERELASTIC, MARLOW, POISSON=0.49\n*UNIAXIAL TEST DATA\n0.155, 0.1338\n0.2433, 0.2675\n0.4217, 0.3567\n0.6, 0.6242\n";

#[test]
fn a_card_of_a_table_has_a_short_title() {
    let file = block("marlow-title", TABLE);
    let folder = Scratch::new("marlow-card");
    let place = folder.display().to_string();
    let arguments = [
        "card",
        &file,
        "--from",
        "abaqus",
        "--incompressible",
        "--mode",
        "uniaxial",
        "--all",
        "--out",
        &place,
    ];
    let answer = onset(&arguments);
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    let first = answer.stdout.lines().next().unwrap_or_default();
    assert!(
        first.starts_with("Marlow, 4 points of a uniaxial test (kappa = "),
        "{first}"
    );
    let page = std::fs::read_to_string(folder.join("card.html")).expect("a page");
    let title = page.split("<title>").nth(1).unwrap_or_default();
    let title = title.split("</title>").next().unwrap_or_default();
    assert!(title.len() < 200 && title.contains("Marlow"), "{title}");
}

#[test]
fn a_deck_of_another_program_is_recognized_without_naming_the_program() {
    for (name, text, program) in [
        ("marlow", TABLE, "Abaqus"),
        (
            "ansys",
            "TB,HYPER,1,1,2,MOONEY\nTBDATA,1,0.3,0.1,1e-3\n",
            "ANSYS",
        ),
        (
            "felupe",
            "umat = fem.Hyperelastic(fem.neo_hooke, mu=1, bulk=50)\n",
            "felupe",
        ),
    ] {
        let file = block(name, text);
        let answer = onset(&["criteria", &file, "--mode", "uniaxial"]);
        assert_eq!(answer.code, Some(0), "{}", answer.stderr);
        let note = answer.stdout.find("note: read as ").expect("a note");
        assert!(answer.stdout[note..].contains(program), "{}", answer.stdout);
    }
    // An invalid study is reported as a study.
    let study = block("study", "[material]\nmodell = \"ogden\"\n");
    let answer = onset(&["card", &study]);
    assert!(answer.stderr.contains("did you mean"), "{}", answer.stderr);
}

#[test]
fn tables_have_plain_numbers_in_aligned_columns_and_constants_in_order() {
    let card = onset(&[
        "card",
        "--set",
        "material.model=blatz-ko",
        "--mode",
        "uniaxial",
        "--all",
    ]);
    assert_eq!(card.code, Some(0), "{}", card.stderr);
    // The load of a bar is largest at 6^(2/5): 32 (6^(-1/5) - 6^(-6/5)).
    let largest = 32.0 * (6.0_f64.powf(-0.2) - 6.0_f64.powf(-1.2));
    assert!(
        card.stdout.contains(&format!("{largest:.4}")) && card.stdout.contains("2.04767"),
        "{}",
        card.stdout
    );
    assert!(!card.stdout.contains("e0"), "{}", card.stdout);
    let ogden = onset(&[
        "criteria",
        "--set",
        "material.model=ogden",
        "--mode",
        "hydrostatic",
        "--all",
    ]);
    let text = &ogden.stdout;
    let place = |name: &str| text.find(&format!("{name} = ")).expect("a constant");
    assert!(
        place("mu1") < place("alpha1") && place("alpha1") < place("mu2"),
        "{text}"
    );
    assert!(place("alpha3") < place("kappa"), "{text}");
    let column = |start: &str| {
        let line = text
            .lines()
            .find(|line| line.trim_start().starts_with(start));
        let words = ["never", "at once", "at F = 1"];
        let line = line.expect("a line");
        words
            .iter()
            .filter_map(|word| Some(line.find(word)? + word.len()))
            .min()
    };
    let ends: Vec<Option<usize>> = ["strong-ellipticity ", "true-stress-monotonicity "]
        .map(column)
        .to_vec();
    assert!(ends[0].is_some() && ends[0] == ends[1], "{ends:?}: {text}");
}

#[test]
fn limits_of_simple_shear_are_amounts_of_shear() {
    // Plane strain: ellipticity is lost where gamma^2 = 2.
    let line = format!("criteria {BLATZ_KO} --mode simple-shear");
    let text = onset(&[
        "criteria",
        "--set",
        "material.model=blatz-ko",
        "--mode",
        "simple-shear",
    ])
    .stdout;
    for fact in [
        "loses strong ellipticity at gamma = 1.699 and\n-1.699",
        "gamma at the loss of",
        "gamma from -9.9 to 9.9",
    ] {
        assert!(text.contains(fact), "{fact}: {text}");
    }
    assert!(!text.contains("stretch"), "{text}");
    let answer = document(&line);
    let loadings = answer["loadings"].as_array().expect("a list");
    let plane = loadings
        .iter()
        .find(|own| own["title"] == "simple shear, plane strain");
    let plane = plane.expect("the loading");
    let limit = criterion(plane, "strong-ellipticity");
    assert_close(number(limit, "/tension/limit"), 2.0_f64.sqrt(), 1e-9);
    assert_close(
        number(limit, "/compression/changes/0/imposed"),
        -(2.0_f64.sqrt()),
        1e-9,
    );
    assert_close(number(plane, "/tension_end/imposed"), 9.9, 1e-12);
    let card = document(&format!("card {BLATZ_KO} --mode simple-shear"));
    let bar = &card["loadings"][2];
    assert_eq!(bar["mode"], "simple-shear");
    assert_close(number(bar, "/tension"), 2.0_f64.sqrt(), 1e-9);
    assert_close(
        number(bar, "/criteria/0/holds/0/0"),
        -(2.0_f64.sqrt()),
        1e-9,
    );
}

#[test]
fn the_figure_shows_the_chosen_criteria() {
    let folder = Scratch::new("criteria-drawn");
    let out = folder.join("drawn.svg").display().to_string();
    let base = [
        "criteria",
        "--mode",
        "hydrostatic",
        "--set",
        "material.model=blatz-ko",
        "--out",
        &out,
    ];
    let drawn = |criteria: &[&str]| onset(&[&base, criteria].concat());
    let texts = || std::fs::read_to_string(folder.join("drawn.svg")).expect("a file");
    assert_eq!(drawn(&[]).code, Some(0));
    for title in [
        "strong ellipticity",
        "Drucker stability as Abaqus checks it",
    ] {
        assert!(texts().contains(title), "{title}");
    }
    assert_eq!(drawn(&["--criterion", "hill,load-maximum"]).code, Some(0));
    assert!(texts().contains("a rising load") && !texts().contains("strong ellipticity"));
    for (criteria, fact) in [
        ("ellipticity", "expected one of strong-ellipticity"),
        ("surface", "`surface` does not apply to blatz-ko"),
        ("hill,hill", "expected at most 7, each once"),
    ] {
        let refused = drawn(&["--criterion", criteria]);
        assert_eq!(refused.code, Some(2), "{criteria}");
        assert!(
            refused.stderr.contains(fact),
            "{criteria}: {}",
            refused.stderr
        );
    }
}

#[test]
fn finite_jumps_in_the_reference_state_are_answered_for_every_bulk_modulus() {
    for kappa in ["1e5", "1e6"] {
        let answer = crate::document(&format!(
            "criteria --mode uniaxial --set material.model=mooney-rivlin-isochoric \
             --set material.c10=0.6 --set material.c01=-0.1 --set material.kappa={kappa}"
        ));
        let criteria = answer["loadings"][0]["criteria"]
            .as_array()
            .expect("a list");
        let is_own = |own: &&Value| own["criterion"] == "rank-one-convexity";
        let own = criteria.iter().find(is_own).expect("finite jumps");
        assert_eq!(own["holds_in_reference"], false, "{own}");
        assert_eq!(own["tension"]["changes"][0]["witness"]["verified"], true);
    }
}

#[test]
fn a_loss_that_is_regained_is_marked_and_the_mark_is_explained() {
    let short = |law: &[&str]| {
        let law = law.iter().flat_map(|own| ["--set", own]);
        let line = ["criteria", "--incompressible", "--mode", "equibiaxial"];
        onset(&line.into_iter().chain(law).collect::<Vec<_>>()).stdout
    };
    let told = short(&[
        "material.model=ogden",
        "material.mu1=1.05",
        "material.alpha1=1.3",
        "material.mu2=0.00144",
        "material.alpha2=5",
        "material.mu3=0.018",
        "material.alpha3=-2",
    ]);
    assert!(told.contains("* is regained (--all)"), "{told}");
    let mut lines = told.lines();
    assert!(lines.any(|line| line.starts_with("equibiaxial") && line.contains('*')));
    let plain = short(&["material.model=neo-hooke"]);
    assert!(plain.contains("limits") && !plain.contains('*'), "{plain}");
}
