//! Output of answers: formats, quiet and verbose, color, exit codes by verdict, files.

use super::{Scratch, Written, assert_close, command, document, onset, onset_line};

const STATE: &str = "state --stretch 1.1,0.95";

#[test]
fn short_answers_have_at_most_twelve_lines_of_a_hundred_characters() {
    // The law of the deck has four notes.
    let deck = Written::new(
        "noted.inp",
        "*MATERIAL, NAME=RUBBER_A\n*HYPERELASTIC, NEO HOOKE\n0.5, 0.02\n*VISCOELASTIC, TIME=PRONY\n0.2, 0., 0.1\n*MULLINS EFFECT\n1.5, 0.1, 0.1\n\
         *DENSITY\n1.1e-9\n*MATERIAL, NAME=RUBBER_B\n*HYPERELASTIC, MOONEY-RIVLIN\n0.4, 0.1, 0.02\n",
    );
    for line in [
        &format!("state {deck} --stretch 1.1,0.95"),
        &format!("criteria {deck}"),
        &format!("card {deck}"),
        &format!("limit {deck} --time-step 0.1 --vary discretization.spacing"),
        &format!("recommend {deck} --dimension 1 --set compare.states=2"),
        &format!(
            "tune discretization.penalty {deck} --set discretization.method=tlsph --set discretization.lattice=chain"
        ),
        "state --stretch 1.1,1 --set material.model=hypoelastic-jaumann --set discretization.method=peridynamics --set discretization.bonds=bond-based",
        "compare --vary discretization.bonds=bond-based,ordinary --set discretization.method=peridynamics --set compare.states=2",
        "state --stretch 1.1,0.95",
        "state --stretch 1.1,1 --certify",
        "state --stretch 1.2,1 --set discretization.frame=eulerian",
        "criteria --set material.model=blatz-ko",
        "card --set material.model=blatz-ko",
        "card --set material.model=generalized-blatz-ko --set material.nu=0.499995",
        "localize",
        "limit --time-step 0.1 --vary discretization.spacing",
        "compare --vary discretization.kernel --vary discretization.smoothing-length=1.2,1.5 --set discretization.method=updated-sph --set compare.states=2",
        "recommend --dimension 1 --set compare.states=2",
        "tune discretization.penalty --set discretization.method=tlsph --set discretization.lattice=chain",
    ] {
        let words: Vec<&str> = line.split_whitespace().collect();
        let short = onset(&words).stdout;
        assert!(short.lines().count() <= 12, "{line}: {short}");
        // Only notes on single methods may be omitted.
        let is_of_methods = line.starts_with("recommend") || line.starts_with("compare");
        assert!(
            is_of_methods || !short.contains(" more: --all\n"),
            "{line}: {short}"
        );
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

/// Cells of a CSV table by row, with quotes removed.
fn cells(table: &str) -> Vec<Vec<String>> {
    let row = |line: &str| {
        let (mut cells, mut is_quoted) = (vec![String::new()], false);
        for letter in line.chars() {
            match (letter, is_quoted) {
                ('"', _) => is_quoted = !is_quoted,
                (',', false) => cells.push(String::new()),
                _ => cells.last_mut().expect("a cell").push(letter),
            }
        }
        cells
    };
    table.lines().map(row).collect()
}

/// Cells of the only row of the table of a command, by the names of the columns.
fn only_row(line: &str) -> impl Fn(&str) -> String + use<> {
    let rows = cells(&onset_line(&format!("{line} --format csv")).stdout);
    assert_eq!(rows.len(), 2, "{rows:?}");
    move |name: &str| {
        let place = rows[0].iter().position(|own| own == name);
        let place = place.unwrap_or_else(|| panic!("no {name} in {:?}", rows[0]));
        rows[1][place].clone()
    }
}

#[test]
fn json_has_a_short_name_and_the_table_of_a_state_has_one_row_with_the_same_numbers() {
    let json = onset_line(&format!("{STATE} --format json"));
    assert_eq!(json.stdout, onset_line(&format!("{STATE} --json")).stdout);
    let document = document(STATE);
    let cell = only_row(STATE);
    assert_eq!(
        cell("verdict"),
        document["verdict"].as_str().expect("a word")
    );
    assert_eq!(
        [cell("F11"), cell("F12"), cell("F22")],
        ["1.1", "0", "0.95"]
    );
    let frequency = cell("maximum_omega").parse().ok();
    let expected = document["discretization"]["maximum_omega"].as_f64();
    assert_eq!(frequency, expected);
}

#[test]
fn columns_have_units_where_the_settings_have_units() {
    let measured =
        "--set material.young=2MPa --set material.poisson=0.4 set spacing=1mm set density=1g/cm^3";
    let cell = only_row(&format!("{STATE} {measured}"));
    assert!(cell("s11 [Pa]").parse::<f64>().is_ok());
    for name in [
        "growth_rate [1/s]",
        "critical_time_step [s]",
        "wave_vector_1 [1/m]",
    ] {
        cell(name);
    }
    assert_eq!(cell("F11"), "1.1");
}

#[test]
fn every_command_prints_a_table_with_complete_rows() {
    let study = "studies/rubber.toml";
    for (line, head, rows) in [
        (
            "criteria --mode uniaxial --set material.model=blatz-ko",
            "mode,lateral,loading,criterion,",
            33,
        ),
        (
            "card --set material.model=blatz-ko",
            "mode,lateral,loading,strong_ellipticity_compression,",
            10,
        ),
        (
            "modes set quadrature=nodal",
            "wave_vector_1,wave_vector_2,fractional_1,",
            0,
        ),
        (
            "audit --set material.model=blatz-ko",
            "check,outcome,error,finding",
            0,
        ),
        (
            "dispersion --stretch 1.1,1 --wave-vector 1,0",
            "branch,omega_squared_re,",
            2,
        ),
        (
            "dispersion --stretch 1.1,0.95 --path",
            "length,wave_vector_1,",
            0,
        ),
        ("list materials", "topic,key,name,formula,source", 0),
        ("list keys", "key,meaning,expects,default,read_with", 0),
        ("verify codes", "name,title,is_periodic", 0),
        (
            &format!("check {study}"),
            "file,valid,title,model,states,line,column,message",
            1,
        ),
        (
            "simulate --stretch 1,1 --cells 4 --turns 1,0 set method=tlsph set lattice=square",
            "outcome,particles,F11,",
            1,
        ),
        (
            "localize --model j2 --path plane-strain",
            "plastic_shear_strain,strain_1,",
            0,
        ),
    ] {
        let table = onset_line(&format!("{line} --format csv"));
        assert!(
            table.stdout.starts_with(head),
            "{line}: {}{}",
            table.stdout,
            table.stderr
        );
        let found = cells(&table.stdout);
        assert!(
            found.iter().all(|row| row.len() == found[0].len()),
            "{line}: {}",
            table.stdout
        );
        assert!(
            found.len() > 1 && (rows == 0 || found.len() == rows + 1),
            "{line}: {} rows",
            found.len() - 1
        );
        assert!(
            !table.stdout.contains("0000000000000000"),
            "{line}: {}",
            table.stdout
        );
    }
}

#[test]
fn the_table_of_criteria_has_the_limits_of_the_document_and_shear_as_an_amount() {
    let line = "criteria --mode simple-shear --mode uniaxial --set material.model=blatz-ko";
    let rows = cells(&onset_line(&format!("{line} --format csv")).stdout);
    let place = |name: &str| {
        rows[0]
            .iter()
            .position(|own| own == name)
            .expect("a column")
    };
    let limit = |title: &str| {
        let row = rows.iter().find(|row| {
            row[place("loading")] == title && row[place("criterion")] == "strong-ellipticity"
        });
        row.expect("a row")[place("tension_lost")]
            .parse::<f64>()
            .expect("a number")
    };
    assert_close(limit("simple shear, plane strain"), 2.0_f64.sqrt(), 1e-9);
    let loadings = document(line)["loadings"].clone();
    let uniaxial = loadings.as_array().expect("loadings").iter();
    let own = uniaxial
        .clone()
        .find(|one| one["title"] == "uniaxial, lateral faces free");
    let own = &own.expect("a loading")["criteria"][0]["tension"]["limit"];
    assert_eq!(own.as_f64(), Some(limit("uniaxial, lateral faces free")));
}

#[test]
fn the_spacing_of_a_lattice_is_written_as_it_was_set() {
    let modes = onset_line("modes --json").stdout;
    assert!(modes.contains("\"spacing\": 1.0,"), "{modes}");
}

#[test]
fn commands_that_print_scripts_have_no_other_format() {
    for line in [
        "schema --json",
        "umat-utilities --format csv",
        "law-header --json",
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
                    // Keys of settings have separate names; the kinds of onset and the names of integrators are words.
                    if !["settings", "map", "onsets", "accuracy"].contains(&name.as_str()) {
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
