//! `onset simulate` with a body: its files, its resumption, and its errors.

use crate::{Answer, Place, tree};
use serde_json::Value;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Folder with the study of a body.
struct Body(Place);

impl Body {
    fn new(study: &str) -> Self {
        let place = Place::new();
        place.write("study.toml", study);
        Self(place)
    }

    fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_onset"));
        command
            .arg("simulate")
            .arg(self.0.path().join("study.toml"))
            .args(line.split_whitespace());
        command
    }

    /// Command that writes into a folder of this place.
    fn kept(&self, line: &str) -> Command {
        let mut command = self.command(line);
        command.arg("--out").arg(self.out());
        command
    }

    fn out(&self) -> PathBuf {
        self.0.path().join("out")
    }
}

const METHOD: &str = "[material]\nmodel = 'neo-hooke'\n[discretization]\nmethod = 'total-lagrangian-sph'\nlattice = 'square'\nsupport = 2.4\npenalty = 0.5\n";

/// Bar that is pulled at one end.
fn pulled() -> String {
    format!(
        "{METHOD}[body]\nshape = 'bar'\nsize = [20, 6]\n\
         [[grips]]\nfrom = [0, 0]\nto = [2, 6]\nvelocity = [0, 0]\n\
         [[grips]]\nfrom = [18, 0]\nto = [20, 6]\nvelocity = [0.05, 0]\nramp = 5\n"
    )
}

const LINE: &str = "--steps 400 --every 10 --fields 3 --amplitude 1e-4 --checkpoint 20 --quiet";

#[test]
fn a_pulled_bar_writes_all_its_files() {
    let place = Body::new(&pulled());
    let answer = Answer::of(place.kept(&format!("{LINE} --json")));
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    let document: Value = serde_json::from_str(&answer.stdout).expect("a document");
    assert_eq!(document["particles"], 120);
    assert_eq!(document["steps_taken"], 400);
    let drift = document["energy_drift"].as_f64().expect("a number");
    assert!(drift < 0.05, "{drift}");
    let work = document["work_of_grips"].as_f64().expect("a number");
    assert!(work > 0.0);
    let names: Vec<String> = tree(&place.out())
        .into_iter()
        .map(|(name, _)| name)
        .collect();
    let expected = [
        "body.pdf",
        "body.png",
        "body.svg",
        "checkpoint.onset",
        "field-0000.vtu",
        "field-0001.vtu",
        "field-0002.vtu",
        "fields.pvd",
        "history.csv",
    ];
    assert_eq!(names, expected);
    let history = std::fs::read_to_string(place.out().join("history.csv")).expect("a history");
    assert_eq!(history.lines().count(), 42);
    assert!(history.starts_with("step,time,kinetic_energy,strain_energy,energy,work_of_grips,"));
    let field = std::fs::read_to_string(place.out().join("field-0002.vtu")).expect("a field");
    assert!(field.contains("Name=\"volume_ratio\"") && field.contains("NumberOfPoints=\"120\""));
    for name in ["F", "stress"] {
        let array = format!("Name=\"{name}\" NumberOfComponents=\"9\"");
        assert!(field.contains(&array), "no {name}");
    }
    // A complete run has no work left, and resuming it changes nothing.
    let files = tree(&place.out());
    let again = Answer::of(place.kept(&format!("{LINE} --resume")));
    assert_eq!(again.code, Some(0), "{}", again.stderr);
    assert!(tree(&place.out()) == files);
}

/// Kills a run after each of several fractions of its duration, and resumes it: its files equal the files of an undisturbed run.
fn assert_kills_change_nothing(
    study: &str,
    duration: Duration,
    files: &[(String, Vec<u8>)],
    parts: u32,
) {
    let mut resumed = 0;
    for case in 1..parts {
        let place = Body::new(study);
        let mut child = place
            .kept(LINE)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("the command starts");
        std::thread::sleep(duration.mul_f64(f64::from(case) / f64::from(parts)));
        // On a slower machine the last kill still finds a checkpoint.
        let checkpoint = place.out().join("checkpoint.onset");
        while case + 1 == parts
            && !checkpoint.exists()
            && child.try_wait().expect("a status").is_none()
        {
            std::thread::sleep(Duration::from_millis(2));
        }
        child.kill().expect("a process");
        child.wait().expect("an end");
        let is_kept = checkpoint.exists();
        resumed += usize::from(is_kept);
        let more = if is_kept { "--resume" } else { "" };
        let answer = Answer::of(place.kept(&format!("{LINE} {more}")));
        assert_eq!(answer.code, Some(0), "case {case}: {}", answer.stderr);
        assert!(tree(&place.out()) == files, "case {case}: other bytes");
    }
    assert!(resumed > 0, "no kill has left a checkpoint");
}

#[test]
fn a_resumed_run_of_a_killed_body_writes_the_same_bytes() {
    let whole = Body::new(&pulled());
    let start = Instant::now();
    assert_eq!(Answer::of(whole.kept(LINE)).code, Some(0));
    let duration = start.elapsed();
    let files = tree(&whole.out());
    assert_kills_change_nothing(&pulled(), duration, &files, 8);
}

/// Two colliding blocks, with a method that updates neighbors.
fn colliding() -> String {
    let method = METHOD
        .replace("total-lagrangian-sph", "updated-sph")
        .replace("penalty = 0.5", "viscosity = 0.5\nartificial-stress = 0.3");
    format!(
        "{method}[body]\nshape = 'block'\nsize = [6, 6]\nsecond = [9, 0]\n\
         [[grips]]\nfrom = [0, 0]\nto = [6, 6]\nvelocity = [0.2, 0]\nuntil = 0\n\
         [[grips]]\nfrom = [9, 0]\nto = [15, 6]\nvelocity = [-0.2, 0.1]\nuntil = 0\n"
    )
}

#[test]
fn a_body_with_updated_neighbors_writes_all_its_files_and_the_same_bytes_after_resumption() {
    let whole = Body::new(&colliding());
    let start = Instant::now();
    let answer = Answer::of(whole.kept(&format!("{LINE} --json")));
    let duration = start.elapsed();
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    let document: Value = serde_json::from_str(&answer.stdout).expect("a document");
    assert_eq!(document["particles"], 72);
    let files = tree(&whole.out());
    let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
    for name in [
        "body.pdf",
        "body.png",
        "checkpoint.onset",
        "field-0002.vtu",
        "history.csv",
    ] {
        assert!(names.contains(&name), "no {name} in {names:?}");
    }
    let history = std::fs::read_to_string(whole.out().join("history.csv")).expect("a history");
    let lines: Vec<Vec<f64>> = history
        .lines()
        .skip(1)
        .map(|line| {
            line.split(',')
                .map(|own| own.parse().expect("a number"))
                .collect()
        })
        .collect();
    let (first, last) = (&lines[0], &lines[lines.len() - 1]);
    // They have collided; momentum is conserved, and dissipated energy is not recovered.
    assert!(last[2] < 0.9 * first[2], "{} {}", first[2], last[2]);
    for axis in 6..8 {
        assert!((last[axis] - first[axis]).abs() < 1e-11 * 36.0 * 0.1);
    }
    assert_kills_change_nothing(&colliding(), duration, &files, 6);
}

/// Two colliding blocks of total-Lagrangian particles, with a contact.
fn touching() -> String {
    colliding()
        .replace("updated-sph", "total-lagrangian-sph")
        .replace("viscosity = 0.5\nartificial-stress = 0.3", "penalty = 0.5")
        .replace("second = [9, 0]", "second = [9, 0]\ncontact = 0.5")
}

#[test]
fn a_resumed_run_of_blocks_in_contact_writes_the_same_bytes() {
    let whole = Body::new(&touching());
    let start = Instant::now();
    let answer = Answer::of(whole.kept(&format!("{LINE} --json")));
    let duration = start.elapsed();
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    let document: Value = serde_json::from_str(&answer.stdout).expect("a document");
    // They have collided: kinetic energy has become strain energy or sound.
    assert!(document["strain_energy"].as_f64() > Some(0.1), "{document}");
    assert_kills_change_nothing(&touching(), duration, &tree(&whole.out()), 4);
}

/// Result of a study from the book.
fn of_the_book(study: &str, line: &str) -> Value {
    let path = format!(
        "{}/../../studies/bodies/{study}.toml",
        env!("CARGO_MANIFEST_DIR")
    );
    let mut command = Command::new(env!("CARGO_BIN_EXE_onset"));
    command.args(["simulate", &path, "--json"]);
    command.args(line.split_whitespace());
    let answer = Answer::of(command);
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    serde_json::from_str(&answer.stdout).expect("a document")
}

#[test]
fn the_bodies_of_the_book_behave_as_described() {
    let number = |document: &Value, name: &str| document[name].as_f64().expect("a number");
    let total = "--set discretization.method=total-lagrangian-sph --set discretization.penalty=0.5";
    let line = "--time 60 --amplitude 1e-3";
    // The grips of a broken bar carry no load.
    let [broken, whole] = ["", total].map(|more| {
        let document = of_the_book("pulled-bar", &format!("{line} {more}"));
        number(&document, "work_of_grips")
    });
    assert!(broken < 0.2 * whole, "{broken} {whole}");
    // Intact rings are bent and store their kinetic energy.
    let line = "--time 150 --fraction 0.2";
    let [torn, bent] = ["", "--set discretization.artificial-stress=0.3"].map(|more| {
        let document = of_the_book("rings", &format!("{line} {more}"));
        number(&document, "strain_energy")
    });
    assert!(torn < 0.5 * bent, "{torn} {bent}");
    let [meeting, parted] = [150, 400].map(|time| {
        let document = of_the_book("rings-total-lagrangian", &format!("--time {time}"));
        assert!(number(&document, "energy_drift") < 0.05);
        number(&document, "kinetic_energy")
    });
    assert!(parted > 4.0 * meeting, "{parted} {meeting}");
}

#[test]
fn an_isolated_particle_moves_freely_or_is_reported_if_gradients_are_corrected() {
    let thrown = |corrected: bool| {
        pulled()
            .replace("total-lagrangian-sph", "updated-sph")
            .replace("penalty = 0.5", &format!("corrected = {corrected}"))
            .replace("from = [18, 0]", "from = [19, 0]")
            .replace("to = [20, 6]", "to = [20, 1]")
            .replace("velocity = [0.05, 0]\nramp = 5", "velocity = [2, -1]")
    };
    let line = "--steps 200 --fraction 0.2 --quiet";
    let told = told(&Body::new(&thrown(true)), line, 1);
    assert!(told.contains("at particle 19"), "{told}");
    assert!(told.contains("discretization.corrected"), "{told}");
    let flies = Answer::of(Body::new(&thrown(false)).command(&format!("{line} --json")));
    assert_eq!(flies.code, Some(0), "{}", flies.stderr);
    let document: Value = serde_json::from_str(&flies.stdout).expect("a document");
    let largest = document["largest_displacement"].as_f64().expect("a number");
    assert!(largest > 3.0, "{largest}");
}

#[cfg(unix)]
#[test]
fn a_resumed_run_of_an_interrupted_body_writes_the_same_bytes() {
    let whole = Body::new(&pulled());
    let line = "--steps 4000 --every 100 --fields 3 --checkpoint 50";
    assert_eq!(Answer::of(whole.kept(line)).code, Some(0));
    let place = Body::new(&pulled());
    let mut child = place
        .kept(line)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the command starts");
    let start = Instant::now();
    while !place.out().join("checkpoint.onset").exists() {
        assert!(start.elapsed() < Duration::from_secs(60), "no checkpoint");
        std::thread::sleep(Duration::from_millis(1));
    }
    let number = child.id().to_string();
    let sent = Command::new("kill").args(["-INT", &number]).status();
    assert!(sent.expect("kill").success());
    assert_eq!(child.wait().expect("an end").code(), Some(130));
    let answer = Answer::of(place.kept(&format!("{line} --resume")));
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    assert!(tree(&place.out()) == tree(&whole.out()));
}

/// Message of a run of a body that is refused or fails.
fn told(body: &Body, line: &str, code: i32) -> String {
    let answer = Answer::of(body.command(line));
    assert_eq!(
        answer.code,
        Some(code),
        "{line}: {}{}",
        answer.stdout,
        answer.stderr
    );
    answer.stderr
}

#[test]
fn a_body_that_is_torn_apart_reports_its_state_and_keeps_its_files() {
    let study = pulled().replace("velocity = [0.05, 0]", "velocity = [-3, 0]");
    let place = Body::new(&study);
    let answer = Answer::of(place.kept("--steps 4000 --checkpoint 5 --quiet"));
    assert_eq!(answer.code, Some(1), "{}", answer.stderr);
    for word in [
        "the motion ends at time",
        "at particle",
        "inverted",
        "reference position",
        "deformation gradient",
        "hint:",
        "the last checkpoint",
    ] {
        assert!(
            answer.stderr.contains(word),
            "no `{word}` in {}",
            answer.stderr
        );
    }
    // The collection lists exactly the fields that were written until then.
    let files = tree(&place.out());
    let fields = files.iter().filter(|(name, _)| name.ends_with(".vtu"));
    let collection = std::fs::read_to_string(place.out().join("fields.pvd")).expect("a collection");
    assert!(fields.clone().count() > 0);
    assert_eq!(collection.matches("file=").count(), fields.clone().count());
    for (name, _) in fields {
        assert!(collection.contains(name), "{name}: {collection}");
    }
    // The checkpoint is complete: a resumed run ends in the same way.
    let again = Answer::of(place.kept("--steps 4000 --checkpoint 5 --quiet --resume"));
    assert_eq!(again.code, Some(1));
    let ends = |text: &str| text.lines().next().map(str::to_owned);
    assert_eq!(ends(&again.stderr), ends(&answer.stderr));
}

#[test]
fn a_particle_beyond_the_domain_of_its_law_is_reported() {
    // Chains that lock at a small stretch.
    let study = pulled()
        .replace("model = 'neo-hooke'", "model = 'gent'\njm = 0.05")
        .replace("[0.05, 0]", "[0.3, 0]");
    let told = told(&Body::new(&study), "--steps 100000 --quiet", 1);
    for word in [
        "the law is not defined at this deformation",
        "jm",
        "at particle",
    ] {
        assert!(told.contains(word), "no `{word}` in {told}");
    }
}

#[test]
fn steps_above_the_critical_step_are_refused_or_blamed_for_the_failure() {
    let place = Body::new(&pulled());
    let refused = told(&place, "--steps 10 --fraction 1.5", 2);
    assert!(refused.contains("of the largest stable step"), "{refused}");
    let line = "--steps 3000 --fraction 2 --supercritical --amplitude 1e-6 --quiet";
    let failed = told(&place, line, 1);
    assert!(
        failed.contains("the step is above the largest stable step"),
        "{failed}"
    );
}

#[test]
fn impossible_bodies_are_refused() {
    let refused = |study: &str, line: &str| told(&Body::new(study), line, 2);
    let body = |body: &str| format!("{METHOD}[body]\n{body}\n");
    let bar = body("shape = 'bar'\nsize = [20, 6]");
    let grip = "[[grips]]\nfrom = [40, 0]\nto = [50, 6]\nvelocity = [1, 0]\n";
    for (study, line, words) in [
        (
            format!("{bar}{grip}"),
            "--steps 9",
            "grip 1 holds no particle",
        ),
        (bar.clone(), "", "set --steps or --time"),
        (bar.clone(), "--steps 9 --cells 4", "--cells has no effect"),
        (
            bar.clone(),
            "--steps 9 --tolerance 0.1",
            "--tolerance has no effect",
        ),
        (
            bar.clone(),
            "--steps 9 --integrator sixth-order",
            "--integrator has no effect",
        ),
        (
            body("shape = 'bar'\nsize = [20, 1]"),
            "--steps 9",
            "do not determine",
        ),
        (
            body("shape = 'bar'\nsize = [0.2, 0.2]"),
            "--steps 9",
            "no particles",
        ),
        (
            body("shape = 'disk'\nradius = 5\nsize = [4, 4]"),
            "--steps 9",
            "body.size",
        ),
        (
            body("shape = 'file'\nfile = 'none.csv'"),
            "--steps 9",
            "cannot read",
        ),
        (
            bar.replace("total-lagrangian-sph", "kernel")
                .replace("penalty = 0.5\n", ""),
            "--steps 9",
            "does not support bodies",
        ),
        (bar.replace("[body]", "[bodies]"), "--steps 9", "bodies"),
        (format!("{bar}contact = 0"), "--steps 9", "body.contact"),
        (
            format!("{bar}contact = 1"),
            "--steps 9",
            "the particles are one piece",
        ),
        (
            colliding().replace("second", "contact = 1\nsecond"),
            "--steps 9",
            "already repel all others",
        ),
        (
            format!("{bar}second = [30, 0]\ncontact = 1")
                .replace("total-lagrangian-sph", "kernel")
                .replace("penalty = 0.5\n", ""),
            "--steps 9",
            "does not support bodies",
        ),
    ] {
        let told = refused(&study, line);
        assert!(told.contains(words), "no `{words}` in {told}");
        assert!(told.contains("hint:"), "{told}");
    }
}

#[test]
fn particles_from_a_file_are_run_and_errors_are_reported_with_the_line() {
    let study = format!("{METHOD}[body]\nshape = 'file'\nfile = 'particles.csv'\n");
    let place = Body::new(&study);
    let mut table = "x,y,volume\n".to_owned();
    for i in 0..8 {
        for j in 0..5 {
            table += &format!("{i}.0,{j}.25,1.0\n");
        }
    }
    place.0.write("particles.csv", &table);
    let answer = Answer::of(place.command("--steps 20 --amplitude 1e-3 --json --quiet"));
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    let document: Value = serde_json::from_str(&answer.stdout).expect("a document");
    assert_eq!(document["particles"], 40);
    place.0.write(
        "particles.csv",
        &format!("\u{feff}{}", table.replace('\n', "\r\n")),
    );
    let saved_by_a_spreadsheet =
        Answer::of(place.command("--steps 20 --amplitude 1e-3 --json --quiet"));
    assert_eq!(saved_by_a_spreadsheet.stdout, answer.stdout);
    for (from, to, words) in [
        (
            "3.0,2.25,1.0",
            "NaN,2.25,1.0",
            "line 19: a cell is not a finite number",
        ),
        ("3.0,2.25,1.0", "3.0,2.25,-1.0", "line 19: the volume is -1"),
        ("3.0,2.25,1.0", "3.0,2.25", "line 19: 2 cells"),
        ("x,y,volume", "x,y,mass", "line 1: the columns are others"),
        ("3.0,2.25,1.0", "3.0,1.25,1.0", "are both at"),
    ] {
        place.0.write("particles.csv", &table.replacen(from, to, 1));
        let told = told(&place, "--steps 20", 2);
        assert!(told.contains(words), "no `{words}` in {told}");
    }
}

#[test]
fn times_of_grips_have_units_if_the_problem_has_units() {
    let grips = "[[grips]]\nfrom = [0, 0]\nto = [2, 6]\nvelocity = [0.1, 0]\nramp = '2 ms'\n";
    let bar = "[body]\nshape = 'bar'\nsize = [20, 6]\n";
    let told = told(&Body::new(&format!("{METHOD}{bar}{grips}")), "--steps 9", 2);
    assert!(told.contains("`grips.ramp` has a unit"), "{told}");
    let units = METHOD
        .replace("'neo-hooke'", "'neo-hooke'\nmu = '1 MPa'\nlambda = '1 MPa'")
        .replace(
            "support",
            "spacing = '1 mm'\ndensity = '1000 kg/m^3'\nsupport",
        );
    let run = |ramp: &str| {
        let grips = grips.replace("'2 ms'", ramp);
        let answer = Answer::of(Body::new(&format!("{units}{bar}{grips}")).command("--steps 9"));
        assert_eq!(answer.code, Some(0), "{}", answer.stderr);
        answer.stdout
    };
    assert_eq!(run("'2 ms'"), run("0.002"));
    let wrong = Body::new(&format!("{units}{bar}{}", grips.replace("ms", "mm")));
    let answer = Answer::of(wrong.command("--steps 9"));
    assert_eq!(answer.code, Some(2));
    assert!(answer.stderr.contains("time"), "{}", answer.stderr);
}
