//! `onset screen`: checks, files and refusals.

use super::{Scratch, Written, number, onset, onset_line};
use serde_json::Value;
use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Stdio};

/// Arguments of the run of a notched plate.
fn notched<'a>(more: &[&'a str]) -> Vec<&'a str> {
    let file = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../runs/notched-plate.dump.gz"
    );
    let study = concat!(env!("CARGO_MANIFEST_DIR"), "/../../runs/notched-plate.toml");
    let mut words = vec!["screen", file, study];
    words.extend(more);
    words
}

const STEP: [&str; 4] = ["--time-step", "0.72", "--stepping", "extrapolated-stress"];

#[test]
fn a_run_is_checked_before_it_is_screened() {
    let answer = onset(&notched(&[&STEP[..], &["--check"]].concat()));
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    for fact in [
        "LAMMPS dump",
        "634 particles",
        "x=x,y",
        "F=c_F[1]",
        "type 2, which moves rigidly",
    ] {
        assert!(
            answer.stdout.contains(fact),
            "no `{fact}` in {}",
            answer.stdout
        );
    }
}

#[test]
fn files_and_exit_code_follow_the_cause() {
    let folder = Scratch::new("screened");
    let out = folder.to_str().expect("UTF-8");
    let more = [
        "--frames",
        "0:12",
        "--out",
        out,
        "--fail-on",
        "numerical,time-step",
        "--actual",
        "21",
    ];
    let answer = onset(&notched(&[&STEP[..], &more].concat()));
    assert_eq!(answer.code, Some(3), "{}", answer.stderr);
    assert!(
        answer.stdout.starts_with("First cause: the time step."),
        "{}",
        answer.stdout
    );
    // Notes on the files follow the answer.
    let is_answer = |line: &&str| !line.starts_with("note:") && !line.starts_with("      ");
    let lines = answer.stdout.lines().filter(is_answer);
    assert!(lines.count() <= 15, "{}", answer.stdout);
    for name in [
        "screen.pvd",
        "screen-000000.vtu",
        "screen.json",
        "screen.csv",
        "screen.svg",
        "screen.png",
        "first.toml",
        "modes.vtu",
    ] {
        assert!(folder.join(name).exists(), "{name}");
    }
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).expect("a file");
    let modes = read("modes.vtu");
    assert!(modes.contains("Name=\"mode_1\" NumberOfComponents=\"3\""));
    let document: Value = serde_json::from_str(&read("screen.json")).expect("a document");
    let actual = &document["actual"];
    assert_eq!(number(&document, "/actual/asked"), 21.0);
    assert_eq!(actual["modes"].as_array().map(Vec::len), Some(6));
    assert!(
        answer.stdout.contains("the frame nearest to 21"),
        "{}",
        answer.stdout
    );
    // The fields can be read again, as a run.
    let fields = folder.join("screen.pvd");
    let study = concat!(env!("CARGO_MANIFEST_DIR"), "/../../runs/notched-plate.toml");
    let again = onset(&["screen", fields.to_str().expect("UTF-8"), study, "--check"]);
    assert!(
        again.stdout.contains("634 particles"),
        "{} {}",
        again.stdout,
        again.stderr
    );
}

#[test]
fn faults_are_refused_with_a_hint() {
    for (more, expected) in [
        (vec![], "--time-step"),
        (
            vec!["--time-step", "0.72", "--held", "grip"],
            "held particles `grip` are unknown",
        ),
        (
            vec!["--time-step", "0.72", "--held", "7"],
            "the types are 1, 2",
        ),
        (
            vec!["--time-step", "0.72", "--region", "0,0:-1,1"],
            "exceeds the upper corner along axis 1: 0 > -1",
        ),
        (
            vec!["--time-step", "0.72", "--region", ""],
            "`` is not a box",
        ),
        (
            vec!["--time-step", "0.72", "--region", "90,90:91,91", "--check"],
            "no particle is in the box 90,90:91,91 of --region",
        ),
        (
            vec!["--time-step", "0.72", "--held", "2", "--held", "none"],
            "omit --held none",
        ),
        (
            vec!["--time-step", "0.72", "--frames", "3:4"],
            "growth needs at least two",
        ),
        (
            vec!["--time-step", "0.72", "--columns", "x=a,b"],
            "no column a",
        ),
        (
            vec!["--time-step", "0.72", "--columns", "x=q9"],
            "columns, among them `id`, `type`",
        ),
        (
            vec!["--time-step", "0.72", "--set", "discretization.spacing=3"],
            "set discretization.spacing=1",
        ),
        (
            vec!["--time-step", "0.72", "--stepping", "euler"],
            "velocity-verlet",
        ),
        (
            vec!["--time-step", "0.72", "--fail-on", "breakage"],
            "causes:",
        ),
        (
            vec!["--time-step", "0.72", "--reference", "missing.dump"],
            "missing.dump",
        ),
    ] {
        let answer = onset(&notched(&more));
        assert_eq!(answer.code, Some(2), "{more:?}: {}", answer.stdout);
        assert!(
            answer.stderr.contains(expected),
            "{more:?}: {}",
            answer.stderr
        );
    }
}

/// A table with a frame of 64 particles at each time, and a second record of particle 5 at some of them.
fn table(frames: &[(f64, bool)]) -> String {
    let mut text = "time,id,x,y\n".to_owned();
    for (time, is_doubled) in frames {
        for n in (0..64).chain(is_doubled.then_some(5)) {
            let stretch = 1.0 + 0.01 * time;
            text += &format!("{time},{n},{},{}\n", f64::from(n / 8) * stretch, n % 8);
        }
    }
    text
}

#[test]
fn frames_that_are_sorted_and_records_that_are_repeated_are_named() {
    for (frames, expected) in [
        (
            vec![(0.0, true), (1.0, false)],
            "line 2: particle 5 occurs twice in the frame at t = 0\n  hint: write each",
        ),
        (
            vec![(0.0, false), (1.0, true), (2.0, false)],
            "the run has 1 frame; growth needs at least two.",
        ),
        (
            vec![(0.0, false), (1.0, true), (2.0, false)],
            "particle 5 occurs twice in the frame at t = 1\n  hint: correct the frame",
        ),
        (
            vec![(0.0, false), (2.0, false), (1.0, false)],
            "the frames are not in order of time, which decreases once: they are sorted",
        ),
    ] {
        let file = Written::new("records.csv", table(&frames));
        let method = "--set discretization.method=tlsph --set discretization.lattice=square";
        let line = format!("screen {file} {method} --held none");
        let answer = onset_line(&line);
        let told = format!("{}{}", answer.stdout, answer.stderr);
        assert!(told.contains(expected), "{frames:?}: {told}");
    }
}

/// Text with single blanks instead of line breaks.
fn unwrapped(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn a_run_with_skipped_frames_is_not_called_stable_without_its_limit() {
    let frames = [0.0, 1.0, 2.0, 3.0].map(|time| (time, false));
    let text = table(&frames).replace("\n2,5,0,5\n", "\n2,5,nan,5\n");
    let file = Written::new("damaged.csv", text);
    let method = "--set discretization.method=tlsph --set discretization.lattice=square";
    let answer = onset_line(&format!("screen {file} {method} --held none"));
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    let told = unwrapped(&answer.stdout);
    assert!(told.starts_with("No instability until t = 1: "), "{told}");
    let limit = "Only the first 2 of 4 frames are assessed; the others are skipped";
    assert!(told.contains(limit), "{told}");
}

#[test]
fn an_archive_with_a_wrong_checksum_is_refused_before_its_last_frame_is_read() {
    let run = concat!(env!("CARGO_MANIFEST_DIR"), "/../../runs/tension");
    let mut bytes = std::fs::read(format!("{run}.npz")).expect("a run");
    // The list of members has the checksum 30 bytes before the name.
    let member = b"position.npy";
    let place = bytes.windows(member.len()).rposition(|own| own == member);
    bytes[place.expect("a member") - 30] ^= 1;
    let file = Written::new("damaged.npz", bytes);
    for frames in ["0:4", "0:20"] {
        let answer = onset_line(&format!("screen {file} {run}.toml --frames {frames}"));
        assert_eq!(answer.code, Some(2), "{frames}: {}", answer.stdout);
        let told = unwrapped(&answer.stderr);
        assert!(told.contains("the checksum of an array is wrong"), "{told}");
    }
}

/// Times and names of the files in a collection, and the names of all fields in its folder.
fn fields(folder: &Scratch) -> (Vec<(f64, String)>, Vec<String>) {
    let collection = std::fs::read_to_string(folder.join("screen.pvd")).expect("a collection");
    let between = |text: &str, start: &str| -> String {
        let (_, rest) = text.split_once(start).expect("an attribute");
        rest.split('"').next().expect("its value").to_owned()
    };
    let listed = collection.lines().filter(|line| line.contains("<DataSet"));
    let listed = listed.map(|line| {
        let time = between(line, "timestep=\"").parse().expect("a time");
        (time, between(line, "file=\""))
    });
    let files = std::fs::read_dir(&**folder).expect("a folder");
    let names = files.map(|file| {
        file.expect("a file")
            .file_name()
            .into_string()
            .expect("UTF-8")
    });
    let mut names: Vec<String> = names.filter(|name| name.starts_with("screen-")).collect();
    names.sort();
    (listed.collect(), names)
}

#[test]
fn fields_contain_the_decisive_frames_and_replace_the_fields_of_an_earlier_run() {
    let folder = Scratch::new("fields");
    let out = folder.to_str().expect("UTF-8");
    for (most, expected) in [("20", 20), ("3", 3), ("2", 2)] {
        let answer = onset(&notched(
            &[&STEP[..], &["--out", out, "--fields", most]].concat(),
        ));
        assert_eq!(answer.code, Some(0), "{}", answer.stderr);
        let (listed, names) = fields(&folder);
        assert_eq!(listed.len(), expected, "{listed:?}");
        let text = std::fs::read_to_string(folder.join("screen.json")).expect("a document");
        let document: Value = serde_json::from_str(&text).expect("a document");
        for event in ["/first/window/1", "/observed/window/1"] {
            let time = number(&document, event);
            assert!(
                listed.iter().any(|(own, _)| (own - time).abs() < 1e-9),
                "{event}: no {time} in {listed:?}"
            );
        }
        let listed: Vec<String> = listed.into_iter().map(|(_, name)| name).collect();
        assert_eq!(listed, names, "files of an earlier run");
    }
}

#[test]
fn gradients_and_stresses_of_simulated_patches_and_bodies_are_read() {
    let body = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../studies/bodies/rubber-strip.toml"
    );
    let patch = "--set discretization.method=tlsph --set discretization.lattice=square";
    for (name, study, run) in [
        (
            "patch",
            patch,
            "--stretch 1.1,1 --cells 8 --mode noise --tolerance 1",
        ),
        ("body", body, "--time-step 0.1"),
    ] {
        let folder = Scratch::new(name);
        let out = folder.to_str().expect("UTF-8");
        let run = format!("simulate {study} {run} --steps 20 --fields 3 --quiet --out {out}");
        let answer = onset_line(&run);
        assert!(matches!(answer.code, Some(0 | 3)), "{}", answer.stderr);
        let files = folder.join("fields.pvd");
        let files = files.to_str().expect("UTF-8");
        let answer = onset_line(&format!("screen {files} {study} --check"));
        let told = unwrapped(&answer.stdout);
        for column in ["F=F", "stress=stress", "X=reference"] {
            assert!(
                told.contains(column),
                "{name}: no {column} in {told} {}",
                answer.stderr
            );
        }
    }
}

#[test]
fn a_growing_file_is_screened_until_a_cause_ends_the_command() {
    let folder = Scratch::new("watched");
    std::fs::create_dir(&*folder).expect("a folder");
    let file = folder.join("run.dump");
    let packed = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../runs/notched-plate.dump.gz"
    );
    let mut text = String::new();
    let packed = std::fs::File::open(packed).expect("a run");
    flate2::read::GzDecoder::new(packed)
        .read_to_string(&mut text)
        .expect("a text");
    let frames: Vec<&str> = text.split("ITEM: TIMESTEP\n").skip(1).collect();
    let write = |count: usize| {
        let all = frames[..count].iter();
        let text: String = all.map(|own| format!("ITEM: TIMESTEP\n{own}")).collect();
        std::fs::write(&file, text).expect("written");
    };
    write(4);
    let study = concat!(env!("CARGO_MANIFEST_DIR"), "/../../runs/notched-plate.toml");
    let mut command = Command::new(env!("CARGO_BIN_EXE_onset"));
    command.arg("screen").arg(&file).arg(study);
    command.args(["--time-step", "0.72", "--stepping", "extrapolated-stress"]);
    command.args(["--watch", "--fail-on", "time-step"]);
    let mut child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("a process");
    let mut printed = BufReader::new(child.stdout.take().expect("a pipe"));
    let mut line = String::new();
    printed.read_line(&mut line).expect("the first answer");
    assert!(!line.contains("time step."), "{line}");
    write(frames.len());
    let mut rest = String::new();
    printed.read_to_string(&mut rest).expect("the last answer");
    assert_eq!(
        child.wait().expect("an end").code(),
        Some(3),
        "{line}{rest}"
    );
    assert!(rest.contains("First cause: the time step."), "{rest}");
}

/// The commands in the comments of a study of the decisive state.
fn commands(folder: &Scratch) -> (String, Vec<String>) {
    let text = std::fs::read_to_string(folder.join("first.toml")).expect("a study");
    let commands = text
        .lines()
        .filter_map(|line| line.strip_prefix("# onset "));
    let place = folder.join("first.toml");
    let place = place.to_str().expect("UTF-8");
    let commands = commands
        .map(|own| own.replace("first.toml", place))
        .collect();
    (text, commands)
}

#[test]
fn the_study_of_the_decisive_state_agrees_with_the_answer() {
    let folder = Scratch::new("decisive");
    let out = folder.to_str().expect("UTF-8");
    let answer = onset(&notched(
        &[&STEP[..], &["--out", out, "--fields", "0"]].concat(),
    ));
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    let (text, own) = commands(&folder);
    for fact in [
        "The step of the run is the cause: in continuous time the state is stable.",
        "Settings of the run: --time-step 0.72 --stepping extrapolated-stress",
        "Largest stable step of the body 0.7006, of the infinite lattice 1.1",
    ] {
        assert!(text.contains(fact), "{fact}: {text}");
    }
    assert_eq!(own.len(), 1, "{own:?}");
    let state = onset_line(&own[0]);
    assert!(
        unwrapped(&state.stdout).starts_with("The time step 0.72 of the run is too large"),
        "{}",
        state.stdout
    );
    // The wave of a numerical cause has a deck, viscosity included.
    let run = concat!(env!("CARGO_MANIFEST_DIR"), "/../../runs/tension");
    let folder = Scratch::new("wave");
    let out = folder.to_str().expect("UTF-8");
    let scheme = "--time-step 0.02 --stepping late-acceleration --fields 0";
    let answer = onset_line(&format!("screen {run}.npz {run}.toml {scheme} --out {out}"));
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    let (text, own) = commands(&folder);
    let state = onset_line(&own[0]);
    let is_verdict = |line: &str| line.starts_with("verdict ") && line.contains(" numerical (");
    assert!(state.stdout.lines().any(is_verdict), "{}", state.stdout);
    let deck = own
        .iter()
        .find(|own| own.starts_with("verify deck"))
        .expect("a deck");
    let deck = deck.replace("--out deck", &format!("--out {out}/deck"));
    let answer = onset_line(&deck);
    assert_eq!(answer.code, Some(0), "{deck}: {}", answer.stderr);
    assert!(
        answer.stdout.contains("predicted    growth rates 0.6265"),
        "{}",
        answer.stdout
    );
    assert!(
        text.contains("add --set discretization.viscosity=0"),
        "{text}"
    );
}

#[test]
fn a_run_without_law_and_method_is_refused_and_can_be_checked() {
    let frames = [0.0, 1.0, 2.0].map(|time| (time, false));
    let file = Written::new("plain.csv", table(&frames));
    let answer = onset_line(&format!("screen {file} --held none"));
    assert_eq!(answer.code, Some(2), "{}", answer.stdout);
    assert!(
        answer.stderr.contains("neither the law nor the method"),
        "{}",
        answer.stderr
    );
    let answer = onset_line(&format!("screen {file} --held none --check"));
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    assert!(
        answer
            .stdout
            .contains("missing     law: set material.model"),
        "{}",
        answer.stdout
    );
    let method = "--set discretization.method=tlsph --set discretization.lattice=square";
    let answer = onset_line(&format!("screen {file} --held none {method}"));
    let told = unwrapped(&answer.stdout);
    assert!(
        told.contains("note: the law of the run is not given"),
        "{told}"
    );
}
