//! Output of answers: formats, quiet and verbose, color, exit codes by verdict, files.

use super::{Scratch, command, document, onset, onset_line};

const STATE: &str = "state --stretch 1.1,0.95";

#[test]
fn short_answers_have_at_most_twelve_lines_of_a_hundred_characters() {
    for line in [
        "state --stretch 1.1,0.95",
        "state --stretch 1.1,1 --certify",
        "state --stretch 1.2,1 --set discretization.frame=eulerian",
        "criteria --set material.model=blatz-ko",
        "recommend --dimension 1 --set compare.states=2",
        "tune discretization.penalty --set discretization.method=tlsph --set discretization.lattice=chain",
    ] {
        let words: Vec<&str> = line.split_whitespace().collect();
        let short = onset(&words).stdout;
        assert!(short.lines().count() <= 12, "{line}: {short}");
        let width = |text: &str| text.lines().map(|line| line.chars().count()).max();
        assert!(width(&short) <= Some(100), "{line}: {short}");
        assert!(short.contains("--all: all numbers"), "{line}: {short}");
        let all = onset(&[&words[..], &["--all"]].concat()).stdout;
        assert!(all.lines().count() > 12, "{line}: {all}");
        let settings = onset(&[&words[..], &["--settings"]].concat()).stdout;
        assert!(settings.starts_with(short.trim_end()), "{line}: {settings}");
        assert!(settings.lines().count() > short.lines().count(), "{line}");
    }
}

#[test]
fn json_has_a_short_name_and_csv_holds_the_same_numbers() {
    let json = onset_line(&format!("{STATE} --format json"));
    assert_eq!(json.stdout, onset_line(&format!("{STATE} --json")).stdout);
    let document = document(STATE);
    let csv = onset_line(&format!("{STATE} --format csv"));
    assert!(csv.stdout.starts_with("name,value\n"), "{}", csv.stdout);
    let row = |name: &str| {
        let start = format!("{name},");
        let line = csv.stdout.lines().find(|line| line.starts_with(&start));
        line.unwrap_or_else(|| panic!("no {name}"))[start.len()..].to_owned()
    };
    assert_eq!(
        row("verdict"),
        document["verdict"].as_str().expect("a word")
    );
    let frequency: f64 = row("discretization.maximum_omega")
        .parse()
        .expect("a number");
    assert_eq!(
        Some(frequency),
        document["discretization"]["maximum_omega"].as_f64()
    );
    let table = onset_line("dispersion --stretch 1.1,0.95 --path --format csv");
    assert!(
        table.stdout.starts_with("length,wave_vector_1"),
        "{}",
        table.stdout
    );
    for line in [
        "schema --json",
        "umat-utilities --format csv",
        "completions bash --json",
    ] {
        assert_eq!(onset_line(line).code, Some(2), "{line}");
    }
    assert_eq!(
        onset_line(&format!("{STATE} --json --format csv")).code,
        Some(2)
    );
}

#[test]
fn names_in_documents_have_one_spelling() {
    fn names(value: &serde_json::Value, found: &mut Vec<String>) {
        match value {
            serde_json::Value::Object(fields) => {
                for (name, value) in fields {
                    found.push(name.clone());
                    // Keys of settings have separate names, and the kinds of onset are words.
                    if !["settings", "map", "onsets"].contains(&name.as_str()) {
                        names(value, found);
                    }
                }
            }
            serde_json::Value::Array(items) => items.iter().for_each(|item| names(item, found)),
            _ => {}
        }
    }
    for line in [
        STATE,
        "path --from 1,1 --to 1.1,1",
        "modes set quadrature=nodal",
        "tune discretization.penalty set method=tlsph set lattice=square --quiet",
        "recommend --dimension 1 --set compare.states=2 --quiet",
        "list kernels",
        "dispersion --stretch 1,1 --wave-vector 1,1",
    ] {
        let mut found = Vec::new();
        names(&document(line), &mut found);
        let hyphens: Vec<&String> = found.iter().filter(|name| name.contains('-')).collect();
        assert!(hyphens.is_empty(), "{line}: {hyphens:?}");
    }
}

#[test]
fn quiet_prints_only_requested_documents() {
    let quiet = onset_line(&format!("{STATE} --quiet"));
    assert_eq!(
        (quiet.code, quiet.stdout.as_str(), quiet.stderr.as_str()),
        (Some(0), "", "")
    );
    let json = onset_line(&format!("{STATE} --quiet --json"));
    assert!(json.stdout.starts_with('{'));
    let wrong = onset_line("state --stretch 1 --quiet");
    assert!(wrong.stderr.contains("error:"));
    let verbose = onset_line(&format!("{STATE} --verbose"));
    assert!(
        verbose.stderr.contains(env!("CARGO_PKG_VERSION")) && verbose.stderr.contains(" s\n"),
        "{}",
        verbose.stderr
    );
    assert_eq!(verbose.stdout, onset_line(STATE).stdout);
    assert_eq!(
        onset_line(&format!("{STATE} --quiet --verbose")).code,
        Some(2)
    );
}

#[test]
fn color_follows_the_options_and_documents_are_plain() {
    let colored = onset_line(&format!("{STATE} --color always")).stdout;
    assert!(colored.contains("\u{1b}[1;3"), "{colored}");
    for more in [
        "",
        "--color auto",
        "--color never",
        "--color always --json",
        "--color always --format csv",
    ] {
        let plain = onset_line(&format!("{STATE} {more}")).stdout;
        assert!(!plain.contains('\u{1b}'), "{more}");
    }
    let error = onset_line("state --stretch 1 --color always").stderr;
    assert!(error.starts_with("\u{1b}[31merror:"), "{error}");
    let said = command(&["state", "--stretch", "1,1", "--color", "always"])
        .env("NO_COLOR", "1")
        .output()
        .expect("the command starts");
    // An option of the command takes precedence over the environment.
    assert!(said.stdout.contains(&0x1b));
}

#[test]
fn verdicts_set_the_exit_code_on_request() {
    let tensile = "state --stretch 1.15,1.0 set frame=eulerian set support=1.6";
    assert_eq!(onset_line(tensile).code, Some(0));
    for (names, code) in [
        ("numerical", 3),
        ("kernel", 3),
        ("numerical,zero-energy", 3),
        ("unstable", 3),
        ("unfaithful", 3),
        ("any", 3),
        ("physical", 0),
        ("stable", 0),
        ("missed,undefined", 0),
    ] {
        let answer = onset_line(&format!("{tensile} --fail-on {names}"));
        assert_eq!(answer.code, Some(code), "{names}");
        assert_eq!(
            answer.stderr.contains("exit code 3"),
            code == 3,
            "{}",
            answer.stderr
        );
    }
    let wrong = onset_line(&format!("{tensile} --fail-on broken"));
    assert_eq!(wrong.code, Some(2));
    assert!(wrong.stderr.contains("zero-energy"), "{}", wrong.stderr);
    let path = "path --from 1,1 --to 1.15,1 set frame=eulerian set support=1.6";
    assert_eq!(
        onset_line(&format!("{path} --fail-on numerical")).code,
        Some(3)
    );
    assert_eq!(
        onset_line(&format!("{path} --fail-on physical")).code,
        Some(0)
    );
    let place = Scratch::new("study.toml");
    let study = "[discretization]\nframe = \"eulerian\"\nsupport = 1.6\n\
                 [[axes]]\nquantity = \"stretch-1\"\nrange = [0.9, 1.2]\nstates = 4\n\
                 [[axes]]\nquantity = \"stretch-2\"\nrange = [0.9, 1.2]\nstates = 4\n";
    std::fs::write(&place, study).expect("a file");
    let store = Scratch::new("map.zarr");
    let map = format!("map {} --out {} --quiet", place.display(), store.display());
    assert_eq!(
        onset_line(&format!("{map} --fail-on numerical")).code,
        Some(3)
    );
    assert_eq!(
        onset_line(&format!("{map} --resume --fail-on zero-energy")).code,
        Some(0)
    );
}

#[test]
fn no_file_is_written_without_a_folder() {
    let place = Scratch::new("here");
    std::fs::create_dir_all(&place).expect("a folder");
    let study = place.join("study.toml");
    std::fs::write(
        &study,
        "[[axes]]\nquantity = \"stretch-1\"\nrange = [0.9, 1.1]\nstates = 4\n\
         [[axes]]\nquantity = \"stretch-2\"\nrange = [0.9, 1.1]\nstates = 4\n\
         [compare]\nstates = 2\n[[methods]]\nname = \"a\"\n",
    )
    .expect("a file");
    for line in [
        "dispersion --stretch 1.1,1 --path",
        "boundary study.toml",
        "card",
        "compare study.toml",
        "modes",
        "path --mode uniaxial --to 1.1",
        "localize",
    ] {
        let words: Vec<&str> = line.split(' ').collect();
        let run = command(&words)
            .current_dir(&place)
            .output()
            .expect("the command starts");
        assert!(
            run.status.success(),
            "{line}: {}",
            String::from_utf8_lossy(&run.stderr)
        );
        let files = std::fs::read_dir(&place).expect("a folder").count();
        assert_eq!(files, 1, "{line}");
    }
}

#[test]
fn completions_and_manual_pages_are_written() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = onset(&["completions", shell]);
        assert_eq!(script.code, Some(0));
        let call = ["ONSET_COMPLETE", "onset"];
        assert!(
            call.iter().all(|word| script.stdout.contains(word)),
            "{shell}: {}",
            script.stdout
        );
    }
    let place = Scratch::new("man");
    let out = place.display().to_string();
    let answer = onset(&["man", "--out", &out]);
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    let page = std::fs::read_to_string(place.join("onset-state.1")).expect("a page");
    assert!(
        page.contains(".TH onset-state 1") && page.contains("\\-\\-stretch"),
        "{page}"
    );
    assert!(place.join("onset.1").is_file());
}
