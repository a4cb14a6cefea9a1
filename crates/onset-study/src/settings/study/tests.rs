use super::Study;
use crate::settings::{
    Family, KEYS, Key, Kind, MAP_KEYS, MaterialSettings, Model, Need, Quantity, STATE_KEYS,
    Settings, Value, study_keys,
};

/// Prony series of one term.
const PRONY: &str = "0.1, 0.1, 1";
const PLANE: &str = "[[axes]]\nquantity = \"stretch-1\"\nrange = [0.5, 2]\nstates = 10\n\
                     [[axes]]\nquantity = \"stretch-2\"\nrange = [0.5, 2.0]\nstates = 6\n";

fn study(text: &str) -> Study {
    Study::parse("s.toml", text).unwrap_or_else(|error| panic!("{text}\n{error}"))
}

fn error(text: &str) -> String {
    match Study::parse("s.toml", text) {
        Ok(_) => panic!("accepted:\n{text}"),
        Err(error) => error.to_string(),
    }
}

/// Study with two axes; the second axis varies the given quantity.
fn with_axis(before: &str, quantity: &str, range: &str) -> String {
    format!(
        "{before}[[axes]]\nquantity = \"stretch-1\"\nrange = [0.5, 2]\nstates = 4\n\
         [[axes]]\nquantity = \"{quantity}\"\nrange = {range}\nstates = 4\n"
    )
}

#[track_caller]
fn assert_refused(text: &str, facts: &[&str]) {
    let told = error(text);
    assert!(told.starts_with("s.toml:"), "{told}");
    for fact in facts {
        assert!(told.contains(fact), "no `{fact}` in: {told}");
    }
}

#[test]
fn a_study_is_read_with_all_its_parts() {
    let study = study(&format!(
        "title = \"t\"\n[material]\nmodel = \"blatz-ko\"\nmu = 1\n[discretization]\nsupport = 1.9\n\
         [state]\nstretch-3 = 0.9\nshear = 0.1\n{PLANE}[map]\nadaptive = true\ntile = 32\n"
    ));
    assert_eq!(study.title, "t");
    assert_eq!(study.settings.discretization.support, 1.9);
    assert_eq!(study.settings.material.values(), [("mu", 1.0)]);
    assert_eq!((study.state.stretches[2], study.state.shear), (0.9, 0.1));
    assert_eq!((study.shape(), study.states()), (vec![6, 10], 60));
    assert_eq!((study.map.adaptive, study.map.tile), (true, 32));
    assert_eq!(study.axes[0].range, (0.5, 2.0));
}

#[test]
fn the_first_axis_varies_fastest() {
    let study = study(PLANE);
    let second = study.coordinates(1);
    assert_eq!(
        second,
        [study.axes[0].coordinate(1), study.axes[1].coordinate(0)]
    );
    let last = study.coordinates(59);
    assert_eq!(
        last,
        [study.axes[0].coordinate(9), study.axes[1].coordinate(5)]
    );
}

#[test]
fn axes_vary_deformation_and_settings() {
    let study = study(&with_axis("", "discretization.support", "[1.4, 3]"));
    let settings = study.settings_at(&[1.2, 1.7]).expect("settings");
    assert_eq!(settings.discretization.support, 1.7);
    let f = study.deformation_at(&[1.2, 1.7]).expect("a deformation");
    assert_eq!(f.principal_stretches(), [1.2, 1.0, 1.0]);
    assert!(study.varies_settings());
}

#[test]
fn errors_name_file_line_column_and_a_hint() {
    let told = error(&format!("[discretization]\nsuport = 2\n{PLANE}"));
    assert!(
        told.starts_with("s.toml:2:1: unknown key `discretization.suport`"),
        "{told}"
    );
    assert!(
        told.contains("did you mean `discretization.support`?"),
        "{told}"
    );
    assert!(error("[material\n").starts_with("s.toml:1:"));
    assert!(error(&format!("[stat]\nx=1\n{PLANE}")).contains("did you mean `state`?"));
    // The first error of the file is reported, not the first in alphabetical order.
    let two = format!("[map]\ntile = 1\n[discretization]\nsupport = 0\n{PLANE}");
    assert!(
        error(&two).starts_with("s.toml:2:8: `map.tile` cannot be 1"),
        "{}",
        error(&two)
    );
}

#[test]
fn the_error_for_a_study_without_axes_shows_an_example() {
    for text in ["", "title = \"t\"\n", "axes = []\n"] {
        assert_refused(
            text,
            &[
                "s.toml:1:1: ",
                "axes",
                "two or three",
                "    [[axes]]\n    quantity = ",
            ],
        );
    }
    let one = &PLANE[..PLANE.rfind("[[axes]]").expect("two axes")];
    assert_refused(one, &["1 axis", "two or three"]);
    assert_refused(&format!("{PLANE}{PLANE}"), &["4 axes", "two or three"]);
    // The example is a valid study.
    let told = error("");
    let example = told.split_once("for example").expect("an example").1;
    study(example);
}

#[test]
fn incomplete_axes_and_unknown_keys_of_axes_are_refused() {
    for missing in ["quantity", "range", "states"] {
        let text = PLANE.replacen(missing, "wrong", 1);
        assert_refused(&text, &["unknown key `axes.wrong`"]);
        let first = PLANE.lines().position(|line| line.starts_with(missing));
        let without: Vec<&str> = PLANE
            .lines()
            .enumerate()
            .filter(|(number, _)| Some(*number) != first)
            .map(|(_, line)| line)
            .collect();
        assert_refused(
            &without.join("\n"),
            &[&format!("the axis has no `{missing}`"), "s.toml:1:"],
        );
    }
    assert_refused(
        &PLANE.replacen("states", "sates", 1),
        &["did you mean `axes.states`?"],
    );
    assert_refused("axes = 3\n", &["`axes` cannot be 3", "[[axes]]"]);
    assert_refused("axes = [1, 2]\n", &["`axes` cannot be 1"]);
}

#[test]
fn messages_quote_at_most_24_characters_of_a_value_or_a_key() {
    let long = "SECRET".repeat(3000);
    for text in [
        format!("[material]\nmodel = \"{long}\"\n"),
        format!("[material]\nmodel = \"one word, then SECRET {long}\"\n"),
        format!("[discretization]\nsupport = \"{long}\"\n"),
        format!("[discretization]\n{long} = 1\n"),
        format!("axes = \"{long}\"\n"),
    ] {
        let told = error(&(text + PLANE));
        let count = told.matches("SECRET").count();
        assert!(count <= 4 && told.len() < 2000, "{told}");
    }
}

#[test]
fn the_error_for_an_unknown_quantity_names_the_most_similar_one() {
    for (name, fact) in [
        ("strech-2", "did you mean `stretch-2`?"),
        ("support", "did you mean `discretization.support`?"),
        ("c1", "did you mean `material.c1`?"),
        ("discretization.frame", "cannot be an axis"),
        ("zzz", "expected one of stretch-1"),
        ("stretch-4", "there is no quantity `stretch-4`"),
    ] {
        let text = with_axis("", name, "[1.0, 2.0]");
        assert_refused(&text, &["s.toml:6:12: ", fact]);
    }
}

#[test]
fn a_range_must_be_two_admissible_numbers_in_order() {
    for (quantity, range, fact) in [
        ("stretch-2", "[2, 1]", "leads from 2 to 1"),
        ("stretch-2", "[1, 1]", "leads from 1 to 1"),
        ("stretch-2", "[0, 1]", "stretch-2 cannot be 0"),
        ("stretch-2", "[-1, 1]", "stretch-2 cannot be -1"),
        ("stretch-2", "[1, inf]", "stretch-2 cannot be inf"),
        ("stretch-2", "[nan, 1]", "stretch-2 cannot be NaN"),
        ("stretch-2", "[1]", "has 1 number; expected 2"),
        ("stretch-2", "[1, 2, 3]", "has 3 numbers; expected 2"),
        ("stretch-2", "[1, \"2\"]", "cannot be a list"),
        ("stretch-2", "2.0", "cannot be 2"),
        ("stretch-2", "1979-05-27", "cannot be the date"),
        (
            "stretch-2",
            "[1e-9, 1]",
            "a positive number from 1e-6 to 1e6",
        ),
        (
            "stretch-2",
            "[1, 1e9]",
            "a positive number from 1e-6 to 1e6",
        ),
        ("shear", "[0, 1e9]", "a number from -1e6 to 1e6"),
        ("rotation", "[0, 90]", "a number from -2 pi to 2 pi (rad)"),
        ("discretization.support", "[0, 2]", "cannot be 0"),
        ("discretization.density", "[-1, 2]", "cannot be -1"),
        (
            "discretization.spacing",
            "[1e-200, 2]",
            "a positive number from 1e-20 to 1e20 (length)",
        ),
        ("material.c1", "[-1, 2]", "c1 + c2 is"),
    ] {
        assert_refused(&with_axis("", quantity, range), &["s.toml:7:9: ", fact]);
    }
}

#[test]
fn an_axis_has_2_to_65536_states() {
    for states in [
        "1",
        "0",
        "-4",
        "65537",
        "2.5",
        "1e400",
        "nan",
        "\"4\"",
        "true",
        "[4]",
        "2000-01-01",
    ] {
        let text = PLANE.replace("states = 10", &format!("states = {states}"));
        assert_refused(
            &text,
            &["s.toml:4:10: `axes.states` cannot be", "from 2 to 65536"],
        );
    }
    for (states, count) in [("2", 2), ("65536", 65536), ("0x10", 16), ("1_000", 1000)] {
        let text = PLANE.replace("states = 10", &format!("states = {states}"));
        assert_eq!(study(&text).axes[0].count, count);
    }
}

#[test]
fn values_of_a_wrong_kind_are_refused_with_the_expected_kind() {
    for (line, fact) in [
        ("discretization.support = true", "cannot be true"),
        ("discretization.support = 0", "cannot be 0"),
        (
            "discretization.support = -1.5",
            "expected a positive number",
        ),
        ("discretization.support = inf", "cannot be inf"),
        ("discretization.support = nan", "cannot be NaN"),
        (
            "discretization.support = 1979-05-27",
            "cannot be the date 1979-05-27",
        ),
        ("discretization.support = [2]", "cannot be a list"),
        ("discretization.support = { x = 2 }", "cannot be a table"),
        (
            "discretization.frame = \"lagrangan\"",
            "did you mean `lagrangian`?",
        ),
        ("discretization.frame = 2", "lagrangian | eulerian"),
        ("discretization.frame = false", "cannot be false"),
        ("discretization = 3", "`discretization` cannot be 3"),
        ("title = 3", "expected a string in quotes"),
        ("state.stretch-3 = 0", "cannot be 0"),
        ("state.shear = \"much\"", "expected a number"),
        ("map.adaptive = 1", "expected true | false"),
        ("map.tile = 7", "a whole number from 8 to 1024"),
        ("map.tile = 64.5", "a whole number from 8 to 1024"),
        ("map.refine-from = 12", "a power of two from 2 to 1024"),
        ("map.tolerance = 0", "a positive number"),
        ("material.c1 = inf", "cannot be inf"),
    ] {
        assert_refused(&format!("{line}\n{PLANE}"), &["s.toml:1:", fact]);
    }
}

#[test]
fn setting_a_key_twice_is_refused() {
    for (line, quantity, range) in [
        (
            "discretization.support = 2",
            "discretization.support",
            "[1.5, 2]",
        ),
        ("state.stretch-2 = 1", "stretch-2", "[1, 2]"),
        ("state.shear = 0", "shear", "[0, 1]"),
        ("material.c1 = 1", "material.c1", "[1, 2]"),
    ] {
        let text = with_axis(&format!("{line}\n"), quantity, range);
        assert_refused(
            &text,
            &["s.toml:7:12: ", "is set twice, as an axis and at line 1"],
        );
    }
    assert_refused(
        &with_axis("", "stretch-1", "[1, 2]"),
        &[
            "s.toml:6:12: stretch-1 is the quantity of two axes",
            "line 2, column 12",
        ],
    );
    assert_refused(
        &format!("map.tile = 8\nmap.tile = 16\n{PLANE}"),
        &["duplicate key"],
    );
}

#[test]
fn an_axis_without_effect_is_refused() {
    let text = with_axis("", "material.mu", "[1, 2]");
    assert_refused(
        &text,
        &[
            "changes nothing: modified-mooney-rivlin has no parameter `mu`",
            "its parameters are c1, c2, lambda; or set material.model",
        ],
    );
    let turned = |before: &str| {
        format!(
            "{before}[[axes]]\nquantity = \"rotation\"\nrange = [0, 1]\nstates = 4\n\
             [[axes]]\nquantity = \"discretization.support\"\nrange = [1.5, 2]\nstates = 4\n"
        )
    };
    assert_refused(
        &turned(""),
        &["s.toml:2:12: the axis rotation changes nothing"],
    );
    study(&turned("state.stretch-1 = 1.2\n"));
    study(&turned("state.shear = 0.2\n"));
}

#[test]
fn quantities_of_higher_dimensions_are_refused_for_a_chain() {
    let chain = "discretization.lattice = \"chain\"\n";
    study(&with_axis(chain, "discretization.support", "[1.5, 2]"));
    for quantity in ["stretch-2", "stretch-3", "shear", "rotation"] {
        let text = with_axis(chain, quantity, "[0.5, 1]");
        assert_refused(
            &text,
            &["s.toml:7:12: ", "needs two dimensions; a chain has one"],
        );
    }
    let sheared = format!("{chain}state.shear = 0.1\n");
    let text = with_axis(&sheared, "discretization.support", "[1.5, 2]");
    assert_refused(&text, &["s.toml:2:15: state.shear needs two dimensions"]);
}

#[test]
fn foreign_and_inadmissible_parameters_are_refused() {
    assert_refused(
        &format!("material.mu = 3\n{PLANE}"),
        &["has no parameter `mu`"],
    );
    assert_refused(
        &format!("title = \"\"\nmaterial.c1 = -1\n{PLANE}"),
        &["s.toml:2:15: ", "c1 + c2 is"],
    );
    assert_refused(
        &format!("discretization.spacing = 1e-200\n{PLANE}"),
        &["s.toml:1:26: ", "spacing"],
    );
}

#[test]
fn a_refinement_stride_larger_than_a_tile_is_refused() {
    assert_refused(
        &format!("map.tile = 16\nmap.refine-from = 32\nmap.adaptive = true\n{PLANE}"),
        &["s.toml:2:19: ", "more than the 16 states"],
    );
    // By default, `map.refine-from` adapts to the tile.
    assert_eq!(study(&format!("map.tile = 9\n{PLANE}")).map.refine_from, 8);
    assert_eq!(
        study(&format!(
            "map.tile = 9\nmap.refine-from = 4\nmap.adaptive = true\n{PLANE}"
        ))
        .map
        .refine_from,
        4
    );
}

#[test]
fn keys_without_effect_are_refused_with_their_position_and_their_conditions() {
    assert_refused(
        &format!("discretization.current-lattice = \"regular\"\n{PLANE}"),
        &[
            "s.toml:1:34: `discretization.current-lattice` has no effect: discretization.frame is lagrangian",
            "it is used only with discretization.method = kernel and discretization.frame = eulerian",
        ],
    );
    assert_refused(
        &format!("title = \"\"\nmap.tolerance = 1\n{PLANE}"),
        &["s.toml:2:17: `map.tolerance` has no effect: map.certify is false"],
    );
    // A quantity that an axis varies does not have its default value.
    let viscous =
        "discretization.method = \"updated-sph\"\ndiscretization.viscosity-switch = \"always\"\n";
    study(&with_axis(viscous, "discretization.viscosity", "[0, 1]"));
    assert_refused(
        &with_axis(viscous, "discretization.support", "[1.5, 2]"),
        &["s.toml:2:35: ", "discretization.viscosity is 0"],
    );
}

#[test]
fn a_study_provides_one_material_and_one_method_for_single_states() {
    let text = with_axis(
        "[material]\nmodel = \"blatz-ko\"\n[discretization]\nmethod = \"updated-sph\"\n",
        "discretization.support",
        "[1.5, 2]",
    );
    let of = |assignments: &[&str]| Settings::of_file("s.toml", &text, assignments, &[]);
    let told = of(&[]).expect_err("an open support").to_string();
    assert!(
        told.starts_with("s.toml:10:12: discretization.support is an axis"),
        "{told}"
    );
    assert!(told.contains("--set discretization.support=1.5"), "{told}");
    let settings = of(&["discretization.support=1.7", "material.mu=3"]).expect("settings");
    assert_eq!(settings.discretization.support, 1.7);
    assert_eq!(settings.material.values(), [("mu", 3.0)]);
    assert_eq!(settings.method.method, Family::UpdatedSph);
    let refused = of(&[
        "discretization.support=1.7",
        "discretization.bonds=ordinary",
    ]);
    let told = refused.expect_err("a key of another method").to_string();
    assert!(
        told.contains("`discretization.bonds` has no effect"),
        "{told}"
    );
    // The law alone needs no support, and accepts no keys of methods.
    let law = |assignments: &[&str]| MaterialSettings::of_file("s.toml", &text, assignments);
    assert_eq!(law(&[]).expect("a law").model.name(), "blatz-ko");
    let told = law(&["discretization.support=1.7"]).expect_err("no key of a law");
    assert!(
        told.to_string().contains("this command uses only the law"),
        "{told}"
    );
}

#[test]
fn assignments_override_a_study_except_its_axes() {
    let study = study(PLANE);
    let other = study
        .override_with(&[
            "discretization.support=1.6",
            "map.tile = 128",
            "state.shear=0.1",
            "map.certify=true",
        ])
        .expect("valid");
    assert_eq!(other.settings.discretization.support, 1.6);
    assert_eq!(
        (other.map.tile, other.map.certify, other.state.shear),
        (128, true, 0.1)
    );
    assert_eq!(study.override_with::<&str>(&[]), Ok(study.clone()));
    for (assignment, fact) in [
        (
            "stretch-1=1",
            "stretch-1 is an axis of this study, from 0.5 to 2",
        ),
        ("state.stretch-1=1", "stretch-1 is an axis of this study"),
        (
            "discretization.suport=1",
            "did you mean `discretization.support`?",
        ),
        ("discretization.support=0", "expected a positive number"),
        ("discretization.lattice=chain", "needs two dimensions"),
        ("axes.states=3", "in the study file only"),
        ("map.tile", "is not an assignment"),
        ("map.adaptive=yes", "true | false"),
        ("map.refine-from=128", "map.adaptive is false"),
    ] {
        let told = study
            .override_with(&[assignment])
            .expect_err(assignment)
            .to_string();
        assert!(told.contains(fact), "{assignment}: {told}");
    }
}

#[test]
fn the_title_names_overridden_settings() {
    let study = study(&format!(
        "title = 'Mooney and Rivlin in the paper'\n{PLANE}"
    ));
    for (assignments, title) in [
        (&["map.tile=8"][..], "Mooney and Rivlin in the paper"),
        (
            &["discretization.frame=lagrangian"],
            "Mooney and Rivlin in the paper",
        ),
        (
            &[
                "discretization.method=total-lagrangian-sph",
                "discretization.penalty=0.2",
            ],
            "modified-mooney-rivlin in total-lagrangian-sph: penalty 0.2",
        ),
        (
            &["discretization.support=1.6", "state.shear=0.1"],
            "modified-mooney-rivlin in kernel: support 1.6, shear 0.1",
        ),
        (&["material.model=blatz-ko"], "blatz-ko in kernel"),
    ] {
        let other = study.override_with(assignments).expect("valid");
        assert_eq!(other.title, title);
        assert!(other.text.contains(title), "{}", other.text);
    }
}

#[test]
fn writing_a_study_out_in_full_does_not_change_it() {
    let texts = [
        PLANE.to_owned(),
        with_axis(
            "title = 'a \"b\" \\ é'\ndiscretization.frame = 'eulerian'\n",
            "discretization.support",
            "[1.5, 2]",
        ),
        with_axis("material.model = 'blatz-ko'\n", "material.mu", "[1, 1e16]"),
        format!("material.prony = '{PRONY}'\n{PLANE}"),
        format!("material.mullins-r = 2\nmaterial.mullins-m = 0.1\n{PLANE}"),
        format!("map.adaptive = true\nmap.certify = true\nmap.tolerance = 1e-7\n{PLANE}"),
    ];
    for text in &texts {
        let study = study(text);
        let again = Study::parse("again.toml", &study.document()).expect("valid");
        assert_eq!(again.document(), study.document());
        assert_eq!(again.title, study.title);
        assert_eq!(again.axes, study.axes);
        assert_eq!((again.state, again.map), (study.state, study.map));
        assert_eq!(again.settings.discretization, study.settings.discretization);
        assert_eq!(
            again.settings.material.entries(),
            study.settings.material.entries()
        );
    }
    let overridden = study(PLANE).override_with(&["map.tile=8"]).expect("valid");
    assert_eq!(overridden.text, overridden.document());
    assert!(overridden.text.contains("tile = 8"));
}

/// Model that has a key, and a value of the key.
fn setting(key: &Key) -> (String, serde_json::Value) {
    let owner = Model::all().find(|model| model.takes(key.parts().1));
    let model = match (key.parts(), owner) {
        (("material", "model" | "prony" | "moduli" | "loading"), _) => String::new(),
        _ if is_of_softening(key) => String::new(),
        (("material", own), Some(model)) => {
            let needed = ["energy", "library"].map(|name| {
                let is_needed = own != name && model.keys().iter().any(|key| key.parts().1 == name);
                let line = format!("material.{name} = \"I1 \\\" \\\\ \\n\"\n");
                if is_needed { line } else { String::new() }
            });
            format!("material.model = \"{}\"\n{}", model.name(), needed.concat())
        }
        _ => String::new(),
    };
    let value = match key.kind {
        Kind::Text if key.name == "material.energy" => "J +\n\tI1".into(),
        Kind::Text if key.name == "material.prony" => PRONY.into(),
        Kind::Text => "J \" \\ \n".into(),
        Kind::Numbers(..) => vec![1.5, -2.0].into(),
        Kind::Whole(least, _) if key.parts().0 == "material" => least.into(),
        _ if key.is_parameter() || is_of_softening(key) => default_of(key).into(),
        // Some numbers have no default: they are computed unless set.
        _ if key.default_json().is_null() => 0.5.into(),
        _ => key.default_json(),
    };
    (model, value)
}

/// Lines that a key needs to have an effect.
fn needed(key: &Key) -> String {
    if key.name == "discretization.perturbation" {
        return "discretization.cells = 2\n".to_owned();
    }
    if ["material.moduli", "material.loading"].contains(&key.name) {
        return format!("material.prony = \"{PRONY}\"\n");
    }
    if is_of_softening(key) {
        let constants = [("r", 2.0), ("m", 0.1), ("beta", 0.1)];
        let named = constants.map(|(own, value)| (format!("material.mullins-{own}"), value));
        let others = named.iter().filter(|(name, _)| name != key.name);
        return others
            .map(|(name, value)| format!("{name} = {value}\n"))
            .collect();
    }
    let cases = key.all_needs();
    let line = |need: &Need| {
        let known = Key::named(need.key).expect("a key");
        let default = known.default_value();
        let is_default = |written: &&str| match (written.parse::<f64>(), default.parse::<f64>()) {
            (Ok(written), Ok(default)) => written == default,
            _ => *written == default,
        };
        if need.values.iter().any(is_default) == need.one_of || known.name == "discretization.basis"
        {
            return String::new();
        }
        match (need.one_of, known.kind) {
            (true, Kind::Words(_)) => format!("{} = \"{}\"\n", need.key, need.values[0]),
            (true, _) => format!("{} = {}\n", need.key, need.values[0]),
            (false, _) => {
                let further = match known.name {
                    "discretization.perturbation" => "discretization.cells = 2\n",
                    _ => "",
                };
                format!("{further}{} = 0.1\n", need.key)
            }
        }
    };
    let vectors = match key.name {
        "discretization.vectors" => "",
        _ => "discretization.vectors = [1, 0, 0, 1]\n",
    };
    // If a key has several conditions, only the first, the narrowest, is used.
    let mut keys = std::collections::BTreeSet::new();
    let needs = cases.first().into_iter().flatten();
    let needs = needs.filter(|need| keys.insert(need.key));
    let mut lines: String = needs.map(line).collect();
    if lines.contains("\"oblique\"") {
        lines.push_str(vectors);
    }
    lines
}

/// Default of a parameter in the first law that has it.
fn default_of(key: &Key) -> f64 {
    Model::all()
        .flat_map(Model::parameters)
        .chain(&onset::material::MULLINS)
        .find(|parameter| parameter.name == key.parts().1)
        .map_or(f64::NAN, |parameter| parameter.default)
}

/// Returns true for keys of the Mullins effect.
fn is_of_softening(key: &Key) -> bool {
    key.name.starts_with("material.mullins-")
}

/// Returns true for moduli, which are set in pairs and have separate tests.
fn is_modulus(name: &str) -> bool {
    let moduli = ["young", "poisson", "bulk", "shear"];
    let own = name.strip_prefix("material.");
    own.is_some_and(|own| moduli.contains(&own))
}

#[test]
fn every_key_can_be_set_in_a_file_and_is_read_back() {
    assert_eq!(
        study_keys().count(),
        KEYS.len() + STATE_KEYS.len() + MAP_KEYS.len()
    );
    for key in study_keys() {
        let (model, default) = setting(key);
        let axes = with_axis("", "discretization.density", "[1, 2]").replace(
            "stretch-1",
            if key.name == "state.stretch-1" {
                "stretch-2"
            } else {
                "stretch-1"
            },
        );
        // A user material needs its library, and a table its file.
        let is_of_subroutine = model.contains("umat") || model.contains("marlow");
        if key.name == "discretization.density" || is_of_subroutine || is_modulus(key.name) {
            continue;
        }
        let needed = needed(key);
        let default = match key.name {
            "discretization.points" => serde_json::json!([0.0, 0.0, 1.0]),
            "discretization.vectors" => serde_json::json!([1.0, 0.0, 0.0, 1.0]),
            "discretization.control-coefficient" => 0.5.into(),
            _ => default,
        };
        let study = study(&format!("{model}{needed}{} = {default}\n{axes}", key.name));
        let written = match study.value(key.name) {
            Some(Value::Word(word)) => word,
            Some(value) => value.to_string(),
            None => String::new(),
        };
        let expected = default.as_str().map_or_else(
            || {
                default
                    .as_f64()
                    .map_or_else(|| default.to_string(), |number| number.to_string())
            },
            str::to_owned,
        );
        let compact = |text: &str| text.replace(", ", ",");
        assert_eq!(compact(&written), compact(&expected), "{}", key.name);
    }
}

#[test]
fn every_quantity_can_be_an_axis() {
    for quantity in Quantity::all() {
        if is_modulus(quantity.name()) {
            continue;
        }
        let range = |low: f64| format!("[{low:?}, {:?}]", low + 0.01 + 0.02 * low.abs());
        let (before, other, range) = match quantity {
            Quantity::Stretch(1) => (String::new(), "stretch-2", range(1.1)),
            Quantity::Setting(key) if key.is_parameter() || is_of_softening(key) => {
                let before = format!("{}{}", setting(key).0, needed(key));
                (before, "stretch-1", range(default_of(key)))
            }
            Quantity::Setting(key) => {
                // A fraction is at most one.
                let is_admitted = |value: &f64| *value > 0.0 && !key.name.ends_with("share");
                let default = key.default_json().as_f64().filter(is_admitted);
                (needed(key), "stretch-1", range(default.unwrap_or(0.1)))
            }
            _ => (String::new(), "stretch-1", range(1.1)),
        };
        let text = with_axis(&before, quantity.name(), &range).replacen(
            "quantity = \"stretch-1\"",
            &format!("quantity = \"{other}\""),
            1,
        );
        let study = study(&text);
        assert_eq!(study.axes[1].quantity, quantity);
        let (low, high) = (study.coordinates(0), study.coordinates(15));
        let differ = study.settings_at(&low).expect("low")
            != study.settings_at(&high).expect("high")
            || study.deformation_at(&low) != study.deformation_at(&high);
        assert!(differ, "{}", quantity.name());
    }
}
