use super::*;
use crate::answers::{Problem, Strain};
use crate::settings::Settings;
use onset::cancel::unless;

fn explorer() -> Explorer {
    Explorer::new(Trust::default(), None)
}

fn question(set: &[&str], stretch: &str) -> Question {
    Question {
        set: set.iter().map(|own| (*own).to_owned()).collect(),
        stretch: stretch.to_owned(),
        ..Question::default()
    }
}

fn asked(name: &str, question: &Question) -> serde_json::Value {
    let answer = explorer().answer(name, question);
    serde_json::from_str(&answer.expect(name)).expect("a document")
}

fn refused(name: &str, question: &Question) -> String {
    let answer = explorer().answer(name, question);
    answer.expect_err(name).to_string()
}

#[test]
fn answers_are_the_documents_of_the_command() {
    let set = [
        "material.model=neo-hooke",
        "discretization.method=updated-sph",
    ];
    let question = question(&set, "1.15,1");
    let problem = Problem::new(Settings::from_assignments(&set).expect("settings"));
    let problem = problem.expect("a problem");
    let strain = Strain::of_stretches("--stretch", "1.15,1", 2).expect("a state");
    let state = StateAnswer::new(&problem, &strain).expect("a state");
    let answer = explorer().answer("state", &question);
    assert_eq!(
        answer.expect("a state"),
        json::document(&state).expect("JSON")
    );
    let waves = Diagram::new(&problem, &strain, None).expect("waves");
    let answer = explorer().answer("dispersion", &question);
    assert_eq!(
        answer.expect("waves"),
        json::document(&waves).expect("JSON")
    );
}

#[test]
fn a_map_has_the_verdicts_of_its_states_and_becomes_finer() {
    let mut question = question(&["discretization.method=updated-sph"], "1,1");
    question.window.ranges = [[0.8, 1.3], [0.8, 1.3]];
    let explorer = explorer();
    let mut last = 0;
    for level in 0..=map::LEVELS {
        question.level = level;
        let answer = explorer.answer("map", &question).expect("a map");
        let map: serde_json::Value = serde_json::from_str(&answer).expect("JSON");
        let classes = map["classes"].as_array().expect("classes");
        let states = map["axes"][0]["states"].as_u64().expect("states") as usize;
        assert_eq!(classes.len(), states * states);
        assert!(states > last);
        last = states;
        assert_eq!(map["is_finest"], level == map::LEVELS);
    }
    // The coarsest level evaluates states one by one, as here.
    question.level = 0;
    let map = asked("map", &question);
    let n = map["axes"][0]["states"].as_u64().expect("states") as usize;
    let mut known = std::collections::BTreeSet::new();
    for m in (0..n * n).step_by(7) {
        let at = |i: usize| 0.8 + 0.5 * (i as f64 + 0.5) / n as f64;
        question.stretch = format!("{},{}", at(m % n), at(m / n));
        let class = map["classes"][m].as_u64().expect("a class") as usize;
        let name = crate::domain::Class::ALL[class].name();
        let state = asked("state", &question);
        let verdict = state["verdict"].as_str().expect("a verdict");
        assert!(name.starts_with(verdict), "{name} {verdict}");
        known.insert(name);
    }
    assert!(known.len() > 1, "{known:?}");
}

#[test]
fn cancelled_requests_are_not_answered() {
    let question = question(&["discretization.method=updated-sph"], "1,1");
    for name in ["state", "mode", "dispersion", "map", "boundary"] {
        let explorer = explorer();
        let end = Instant::now() + Duration::from_millis(1);
        let answer = unless(
            move || Instant::now() > end,
            || explorer.answer(name, &question),
        );
        assert!(answer.is_none_or(|answer| answer.is_err()), "{name}");
    }
}

#[test]
fn a_form_has_the_keys_that_are_read_and_drops_the_others() {
    let set = [
        "material.model=neo-hooke",
        "material.mu=0.5",
        "material.c1=3",
        "discretization.method=total-lagrangian-sph",
        "discretization.frame=eulerian",
        "discretization.penalty=0.3",
    ];
    let form = asked("form", &question(&set, ""));
    let kept: Vec<&str> = form["set"]
        .as_array()
        .expect("a list")
        .iter()
        .filter_map(|own| own.as_str())
        .collect();
    assert_eq!(kept, [set[0], set[1], set[3], set[5]]);
    let fields = form["fields"].as_array().expect("fields");
    let named = |name: &str| fields.iter().find(|field| field["name"] == name);
    assert!(named("discretization.frame").is_none());
    let mu = named("material.mu").expect("mu");
    assert_eq!(
        (&mu["value"], &mu["is_default"]),
        (&0.5.into(), &false.into())
    );
    let [low, high] =
        [&mu["slider"][0], &mu["slider"][1]].map(|end| end.as_f64().expect("a number"));
    assert!(0.0 < low && low < 0.5 && 0.5 < high);
    let words = named("discretization.method").expect("a method")["words"]
        .as_array()
        .expect("words")
        .len();
    assert_eq!(words, 7);
}

#[test]
fn moduli_are_fields_in_place_of_derived_parameters() {
    let set = [
        "material.model=neo-hooke",
        "material.young=1",
        "material.poisson=0.4",
    ];
    let form = asked("form", &question(&set, ""));
    let fields = form["fields"].as_array().expect("fields").iter();
    let names: Vec<&str> = fields.filter_map(|field| field["name"].as_str()).collect();
    assert!(names.contains(&"material.young") && names.contains(&"material.poisson"));
    assert!(!names.contains(&"material.mu"), "{names:?}");
}

#[test]
fn parameters_of_an_energy_without_a_value_are_listed() {
    let set = [
        "material.model=formula",
        "material.energy=mu/2*(I1 - 3 - 2*ln(J)) + c*(J - 1)^2",
        "material.c=1",
    ];
    assert_eq!(
        asked("form", &question(&set, ""))["missing"],
        serde_json::json!(["mu"])
    );
}

#[test]
fn a_wrong_formula_is_shown_with_a_caret() {
    let set = [
        "material.model=formula",
        "material.energy=mu/2*(I1 - 3 -* 2)",
    ];
    let told = refused("state", &question(&set, "1.1,1"));
    assert!(
        told.contains("column 15") && told.contains("\n                  ^"),
        "{told}"
    );
}

#[test]
fn a_request_of_the_page_loads_no_library_and_reads_no_file() {
    let library = "/nowhere/at-all.so";
    for set in [
        vec![
            "material.model=umat".to_owned(),
            format!("material.library={library}"),
        ],
        vec![
            format!("material.library={library}"),
            "material.model=umat".to_owned(),
        ],
        vec![
            format!(" material.library = {library}"),
            "material.model = umat".to_owned(),
        ],
    ] {
        let question = Question {
            set,
            stretch: "1,1".to_owned(),
            form: "toml".to_owned(),
            ..Question::default()
        };
        for name in [
            "form",
            "state",
            "dispersion",
            "directions",
            "mode",
            "map",
            "boundary",
            "export",
        ] {
            let told = refused(name, &question);
            assert!(told.contains("nothing was loaded"), "{name}: {told}");
        }
    }
}

#[test]
fn a_study_is_opened_as_an_equivalent_problem() {
    for text in [
        include_str!("../../../../studies/rubber.toml"),
        "[material]\nmodel = \"neo-hooke\"\n[discretization]\nmethod = \"updated-sph\"\nsupport = 2.2\n",
    ] {
        let mut opening = Question {
            text: text.to_owned(),
            ..Question::default()
        };
        let opened = asked("open", &opening)["question"].clone();
        let question: Question = serde_json::from_value(opened).expect("a question");
        let state = asked("state", &question);
        let settings = Settings::of_file("study", text, &[] as &[&str], &[]).expect("settings");
        let expected = serde_json::to_value(settings.effective()).expect("JSON");
        assert_eq!(state["settings"], expected);
        // Exported as a study and opened again, the question is unchanged.
        opening.form = "toml".to_owned();
        let written = asked(
            "export",
            &Question {
                form: "toml".to_owned(),
                ..question.clone()
            },
        );
        opening.text = written["text"].as_str().expect("a text").to_owned();
        let again = asked("open", &opening)["question"].clone();
        let again: Question = serde_json::from_value(again).expect("a question");
        assert_eq!(asked("state", &again)["settings"], expected);
        assert_eq!(again.window, question.window);
    }
}

#[test]
fn exports_are_equivalent_to_the_problem() {
    let set = [
        "material.model=neo-hooke",
        "material.lambda=3",
        "discretization.method=updated-sph",
        "discretization.artificial-stress=0.2",
    ];
    let mut question = question(&set, "1.1,0.9");
    let mut text = |form: &str| {
        question.form = form.to_owned();
        asked("export", &question)["text"]
            .as_str()
            .expect("a text")
            .to_owned()
    };
    assert_eq!(
        text("command"),
        "onset state --stretch 1.1,0.9 --set material.model=neo-hooke --set material.lambda=3 --set discretization.method=updated-sph --set \
         discretization.artificial-stress=0.2"
    );
    let python = text("python");
    assert!(
        python.contains("onset.Material(\"neo-hooke\", lambda_=3)"),
        "{python}"
    );
    assert!(
        python.contains("onset.Method(\"updated-sph\", artificial_stress=0.2)"),
        "{python}"
    );
    assert!(text("toml").contains("quantity = \"stretch-1\""));
    let told = refused(
        "export",
        &Question {
            form: "poem".to_owned(),
            ..question.clone()
        },
    );
    assert!(told.contains("expected toml, command"), "{told}");
}

#[test]
fn the_page_shows_every_entry_of_the_zoo() {
    let entries = entries();
    assert_eq!(entries.len(), crate::zoo::reports().len());
    for entry in entries {
        asked("form", &entry.question);
    }
}

#[test]
fn a_window_can_vary_a_key() {
    let mut question = question(
        &[
            "discretization.method=updated-sph",
            "discretization.lattice=chain",
        ],
        "1.1",
    );
    question.window.axes[1] = "discretization.support".to_owned();
    question.window.ranges[1] = [1.4, 3.0];
    let map = asked("map", &question);
    assert_eq!(map["axes"][1]["name"], "discretization.support");
    question.window.axes[1] = "rotation".to_owned();
    assert!(refused("map", &question).contains("cannot be rotation"));
}
