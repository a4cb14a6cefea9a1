//! `onset simulate`: every method moves as its linearized equations predict, and an interrupted run is resumed to the same bytes.

use crate::hunt::hunted;
use crate::{Answer, Place, text, tree};
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

fn command(line: &str, others: &[String]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_onset"));
    command
        .arg("simulate")
        .args(line.split_whitespace())
        .args(others);
    command
}

fn simulate(line: &str, others: &[String]) -> Answer {
    Answer::of(command(line, others))
}

fn number(document: &Value, pointer: &str) -> f64 {
    let number = document.pointer(pointer).and_then(Value::as_f64);
    number.unwrap_or_else(|| panic!("no number at {pointer} of {document}"))
}

/// Methods of the comparisons of a dimension: names and assignments.
fn methods(dimension: usize) -> Vec<(String, Vec<String>)> {
    let mut all = methods_of(&format!("methods-{dimension}d"));
    if dimension == 2 {
        for recent in methods_of("recent-2d") {
            if all.iter().all(|(name, _)| *name != recent.0) {
                all.push(recent);
            }
        }
    }
    all
}

/// Methods of a comparison.
fn methods_of(name: &str) -> Vec<(String, Vec<String>)> {
    let path = format!(
        "{}/../../comparisons/{name}.toml",
        env!("CARGO_MANIFEST_DIR")
    );
    let file = std::fs::read_to_string(path).expect("a comparison");
    let file: toml::Table = file.parse().expect("TOML");
    let assigned = |table: &toml::Table, section: &str| -> Vec<String> {
        let keys = table.iter().filter(|(key, _)| *key != "name");
        keys.flat_map(|(key, value)| ["--set".to_owned(), format!("{section}.{key}={value}")])
            .collect()
    };
    let common: Vec<String> = ["material", "discretization"]
        .iter()
        .filter_map(|section| Some(assigned(file.get(*section)?.as_table()?, section)))
        .flatten()
        .collect();
    let own = file["methods"].as_array().expect("methods").iter();
    own.map(|method| {
        let method = method.as_table().expect("a table");
        let mut all = common.clone();
        for assignment in assigned(method, "discretization").chunks(2) {
            let key = assignment[1].split('=').next().expect("a key");
            // Settings of a method replace common settings.
            if let Some(place) = all
                .iter()
                .position(|own| own.split('=').next() == Some(key))
            {
                all[place] = assignment[1].clone();
            } else {
                all.extend_from_slice(assignment);
            }
        }
        (method["name"].as_str().expect("a name").to_owned(), all)
    })
    .collect()
}

/// Method with the smallest patch that separates its waves.
struct Subject {
    dimension: usize,
    name: String,
    set: Vec<String>,
}

/// Measured row of the table.
struct Row {
    what: &'static str,
    state: String,
    answer: Value,
}

impl Subject {
    fn all(dimensions: &[usize]) -> Vec<Self> {
        let of = |dimension: &usize| {
            let dimension = *dimension;
            let new = move |(name, set)| {
                Self {
                    dimension,
                    name,
                    set,
                }
                .without_idle_keys()
            };
            methods(dimension).into_iter().map(new)
        };
        dimensions.iter().flat_map(of).collect()
    }

    /// Material points whose velocities are transferred through the grid in each step.
    fn transfers(dimensions: &[usize]) -> Vec<Self> {
        let transfers: [(&str, &[&str]); 7] = [
            ("material points, FLIP", &["transfer=flip"]),
            (
                "material points, FLIP and PIC",
                &["transfer=flip", "flip-share=0.95"],
            ),
            ("material points, PIC", &["transfer=pic"]),
            ("material points, APIC", &["transfer=apic"]),
            ("material points, XPIC(2)", &["transfer=xpic"]),
            (
                "material points, FMPM(4)",
                &["transfer=fmpm", "transfer-order=4"],
            ),
            (
                "material points, MLS-MPM",
                &["transfer=apic", "grid-gradients=moments"],
            ),
        ];
        let of = |dimension: &usize| {
            let dimension = *dimension;
            let lattice = ["lattice=chain", "lattice=square", "lattice=simple-cubic"];
            let common = [
                "method=material-points",
                "unknowns=particles",
                "grid-functions=quadratic-spline",
                lattice[dimension - 1],
            ];
            let new = move |(name, own): (&str, &[&str])| Self {
                dimension,
                name: name.to_owned(),
                set: common
                    .iter()
                    .chain(own)
                    .flat_map(|own| ["--set".to_owned(), format!("discretization.{own}")])
                    .collect(),
            };
            transfers.map(new)
        };
        dimensions.iter().flat_map(of).collect()
    }

    fn is_transferred(&self) -> bool {
        self.set.iter().any(|own| own.contains(".transfer="))
    }

    /// Common settings apply only to methods that read them, as in `onset compare`.
    fn without_idle_keys(mut self) -> Self {
        loop {
            let answer = self.run(&self.stretch(1.0, 1.0), "--steps 1");
            let told = answer.stderr.strip_prefix("error: --set ");
            let Some(told) = told.filter(|told| told.contains("has no effect")) else {
                return self;
            };
            let key = told.split('=').next();
            let idle = self.set.iter().position(|own| own.split('=').next() == key);
            let idle = idle.unwrap_or_else(|| panic!("{told}"));
            self.set.drain(idle - 1..=idle);
        }
    }

    /// State at which no wave grows.
    ///
    /// An artificial stress has a kink at zero stress. It acts in tension; compressed particles in 2D are unstable with or without it.
    fn stable(&self) -> String {
        match self.name.contains("artificial stress") {
            true => self.stretch(1.02, 1.02),
            false => self.stretch(1.0, 1.0),
        }
    }

    /// Number of cells. In 3D one side is longer: all waves of a patch of two cells alternate, and have no effect at the nodes.
    fn cells(&self) -> &str {
        ["8", "4", "4,2,2"][self.dimension - 1]
    }

    fn stretch(&self, first: f64, others: f64) -> String {
        let mut all = vec![first.to_string()];
        all.resize(self.dimension, others.to_string());
        if self.dimension == 1 {
            // At least two stretches are given.
            all.push("1".to_owned());
        }
        all.join(",")
    }

    fn run(&self, state: &str, line: &str) -> Answer {
        let cells = self.cells();
        let line = format!("--json --stretch {state} --cells {cells} {line}");
        simulate(&line, &self.set)
    }

    /// JSON answer of a run whose measured rate agrees with the prediction.
    fn agrees(&self, state: &str, line: &str) -> Value {
        let answer = self.run(state, line);
        assert_eq!(
            answer.code,
            Some(0),
            "{} at {state}, {line}: {}{}",
            self.name,
            answer.stdout,
            answer.stderr
        );
        answer.document()
    }

    fn is_undefined(answer: &Answer) -> bool {
        answer.code == Some(2)
    }

    /// State near the reference configuration at which a wave of the patch grows.
    fn unstable(&self) -> Option<String> {
        let stretches = [1.1, 0.8, 1.4, 0.6, 2.0];
        let mut states: Vec<String> = stretches
            .iter()
            .flat_map(|own| [self.stretch(*own, 1.0), self.stretch(*own, *own)])
            .collect();
        states.dedup();
        states.into_iter().find(|state| {
            let answer = self.run(state, "--steps 1");
            !Self::is_undefined(&answer)
                && number(&answer.document(), "/omega_squared/0") < -1e-3
                && number(&answer.document(), "/omega_squared/1") == 0.0
        })
    }

    /// A stable, an unstable and a zero-energy mode, if they exist.
    fn rows(&self) -> Vec<Row> {
        let rest = self.stretch(1.0, 1.0);
        let turns = ["1", "1,0", "1,0,0"][self.dimension - 1];
        let line = format!("--turns {turns} --branch {} --steps 400", self.dimension);
        let mut rows = vec![Row {
            what: "stable",
            answer: self.agrees(&self.stable(), &line),
            state: self.stable(),
        }];
        if let Some(state) = self.unstable() {
            rows.push(Row {
                what: "unstable",
                answer: self.agrees(&state, ""),
                state,
            });
        }
        let softest = self.run(&rest, "--steps 1").document();
        if softest["has_zero_energy"].as_bool() == Some(true) {
            rows.push(Row {
                what: "zero energy",
                answer: self.agrees(&rest, "--steps 1000"),
                state: rest,
            });
        }
        rows
    }
}

/// Number of agreeing rows of each kind.
fn agreeing_rows(subjects: Vec<Subject>) -> [usize; 3] {
    let mut kinds = [0; 3];
    for subject in subjects {
        for row in subject.rows() {
            let place = ["stable", "unstable", "zero energy"]
                .iter()
                .position(|own| *own == row.what);
            kinds[place.expect("a kind")] += 1;
            let difference = number(&row.answer, "/measured/difference");
            assert!(
                difference < 1e-6,
                "{}, {}: {difference:e}",
                subject.name,
                row.what
            );
            let is_growth = number(&row.answer, "/omega_squared/0") < 0.0;
            assert_eq!(is_growth && row.what == "unstable", row.what == "unstable");
        }
    }
    kinds
}

#[test]
fn methods_in_1d_move_as_predicted() {
    let kinds = agreeing_rows(Subject::all(&[1]));
    assert!(kinds.iter().all(|count| *count > 0), "{kinds:?}");
}

#[test]
fn methods_in_2d_move_as_predicted() {
    let kinds = agreeing_rows(Subject::all(&[2]));
    assert!(kinds.iter().all(|count| *count > 0), "{kinds:?}");
}

#[test]
fn material_points_with_a_transfer_move_as_predicted() {
    let [stable, unstable, _] = agreeing_rows(Subject::transfers(&[1, 2]));
    assert!(stable == 14 && unstable > 6, "{stable} {unstable}");
}

/// Material points in 1D with linear functions, one in a cell by default.
fn on_a_chain(line: &str) -> Answer {
    let set = [
        "method=material-points",
        "unknowns=particles",
        "lattice=chain",
    ];
    let set = set
        .map(|own| format!("--set discretization.{own}"))
        .join(" ");
    simulate(&format!("--json --stretch 1 {set} {line}"), &[])
}

#[test]
fn waves_that_strain_points_without_moving_them_are_measured_at_small_strains_only() {
    for transfer in ["transfer=flip", "transfer=pic"] {
        let line = format!(
            "--cells 8 --turns 4 --set discretization.{transfer} --set discretization.points-per-side=1"
        );
        let answer = on_a_chain(&line);
        assert_eq!(answer.code, Some(0), "{}{}", answer.stdout, answer.stderr);
        assert!(number(&answer.document(), "/measured/difference") < 1e-6);
        // Beyond small strains the linearized equations do not apply.
        let large = on_a_chain(&format!("{line} --amplitude 0.1"));
        assert_eq!(large.code, Some(3), "{}{}", large.stdout, large.stderr);
    }
}

#[test]
fn points_at_a_node_of_linear_functions_have_the_slope_of_an_affine_field() {
    let energies = ["0.25", "0.2499999999", "0.24"].map(|amplitude| {
        let line = format!(
            "--cells 8 --turns 1 --amplitude {amplitude} --steps 1 --time-step 0.01 --set discretization.transfer=apic"
        );
        let answer = on_a_chain(&line);
        assert_eq!(answer.code, Some(3), "{}{}", answer.stdout, answer.stderr);
        number(&answer.document(), "/energy_drift")
    });
    let [on, beside, away] = energies;
    assert!(
        (on - away).abs() < 0.02 && (beside - away).abs() < 0.02,
        "{energies:?}"
    );
}

#[test]
fn the_sixth_order_integrator_conserves_the_energy_of_conservative_methods() {
    // At large amplitudes; methods with kernels or elements in material coordinates are conservative.
    let conservative = [
        "total-Lagrangian SPH",
        "SCNI, MLS",
        "bars, lumped",
        "bars, consistent",
        "peridynamics, bonds",
    ];
    let mut count = 0;
    for subject in Subject::all(&[1]) {
        if !conservative.contains(&subject.name.as_str()) {
            continue;
        }
        count += 1;
        let rest = subject.stretch(1.0, 1.0);
        let line = "--mode noise --amplitude 1e-3 --integrator sixth-order --fraction 0.02 --steps 1000 --every 1 --tolerance 1";
        let answer = subject.run(&rest, line).document();
        let drift = number(&answer, "/energy_drift");
        assert!(drift < 1e-10, "{}: {drift:e}", subject.name);
    }
    assert_eq!(count, conservative.len());
}

#[test]
fn noise_stays_bounded_below_the_critical_step_and_grows_above() {
    let chain = &Subject::all(&[1])[9..11];
    for subject in chain {
        let rest = subject.stretch(1.0, 1.0);
        let below = subject
            .run(
                &rest,
                "--mode noise --amplitude 1e-8 --fraction 0.999 --steps 20000",
            )
            .document();
        let largest = number(&below, "/largest_displacement");
        assert!(largest < 1e-6, "{}: {largest}", subject.name);
        let refused = subject.run(&rest, "--fraction 1.001 --steps 300");
        assert_eq!(refused.code, Some(2), "{}", refused.stdout);
        assert!(
            refused.stderr.contains("--supercritical"),
            "{}",
            refused.stderr
        );
        let line = "--mode noise --amplitude 1e-8 --fraction 1.001 --steps 150 --supercritical";
        let above = subject.run(&rest, line).document();
        let largest = number(&above, "/largest_displacement");
        assert!(largest > 1e-5, "{}: {largest}", subject.name);
    }
}

/// The table of all methods: `ONSET_MOTION_TABLE` names its file.
#[test]
fn the_table_of_motions_is_computed() {
    let Some(file) = std::env::var_os("ONSET_MOTION_TABLE") else {
        eprintln!(
            "note: NOT TESTED: motions of all methods in all dimensions; `cargo xtask simulate` makes their table"
        );
        return;
    };
    let mut table = String::from(
        "| method | mode | stretches | omega^2 | predicted rate | difference | uncertainty | energy drift | largest displacement at 0.999 | at 1.001 |\n|---|---|---|---|---|---|---|---|---|---|\n",
    );
    let dimensions = [1, 2, 3];
    let transfers = Subject::transfers(&dimensions);
    for subject in Subject::all(&dimensions).into_iter().chain(transfers) {
        for row in subject.rows() {
            let predicted = ["growth", "frequency"]
                .map(|own| number(&row.answer, &format!("/predicted/{own}")));
            let [drift, below, above] = match row.what {
                "stable" => subject.endurance(&row.state),
                _ => ["", "", ""].map(str::to_owned),
            };
            table += &format!(
                "| {}D {} | {} | {} | {:.6e} | {:+.6e} {:+.6e} i | {:.1e} | {:.1e} | {drift} | {below} | {above} |\n",
                subject.dimension,
                subject.name,
                row.what,
                row.state,
                number(&row.answer, "/omega_squared/0"),
                predicted[0],
                predicted[1],
                number(&row.answer, "/measured/difference"),
                number(&row.answer, "/measured/uncertainty"),
            );
        }
    }
    std::fs::write(&file, table).expect("written");
}

impl Subject {
    /// Energy drift of the sixth-order integrator, and the largest displacements from noise of 1e-8 spacings below and above the critical step.
    fn endurance(&self, state: &str) -> [String; 3] {
        // A transfer defines its step, and dissipates energy.
        let line = "--mode noise --amplitude 1e-3 --integrator sixth-order --fraction 0.02 --steps 1000 --every 10 --tolerance 1";
        let drift = match self.is_transferred() {
            true => String::new(),
            false => {
                let energy = self.run(state, line).document();
                format!("{:.1e}", number(&energy, "/energy_drift"))
            }
        };
        let below = self
            .run(
                state,
                "--mode noise --amplitude 1e-8 --fraction 0.999 --steps 100000",
            )
            .document();
        // Above the step of a transfer a single factor leaves the unit circle, slowly; otherwise two coalescing factors leave it with the square root
        // of the excess.
        let (line, least) = match self.is_transferred() {
            true => ("--fraction 1.01 --steps 300", 1e-7),
            false => ("--fraction 1.001 --steps 150", 1e-5),
        };
        let line = format!("--mode noise --amplitude 1e-8 {line} --supercritical");
        let above = self.run(state, &line);
        let bounded = number(&below, "/largest_displacement");
        // Overflow counts as growth.
        let grown = match above.code {
            Some(1) => f64::INFINITY,
            _ => number(&above.document(), "/largest_displacement"),
        };
        assert!(
            bounded < 1e-6 && grown > least,
            "{} at {state}: {bounded:e} below the largest stable step, {grown:e} above",
            self.name
        );
        [drift, format!("{bounded:.1e}"), format!("{grown:.1e}")]
    }
}

/// A run of a few tenths of a second with checkpoints, histories and fields.
const RUN: &str = "--stretch 1.2,0.9 --set discretization.method=total-lagrangian-sph --cells 4 --mode noise --steps 600 --checkpoint 20 --fields 5 --seed 7 --tolerance 1 --quiet";

/// A run of material points with affine velocity fields.
const POINTS: &str = "--stretch 1.2,0.9 --set discretization.method=mls-mpm --cells 4 --mode noise --steps 600 --checkpoint 20 --fields 5 --seed 7 --tolerance 1 --quiet";

fn into(place: &Path) -> [String; 2] {
    ["--out".to_owned(), text(place).to_owned()]
}

fn whole(run: &str) -> (Place, Vec<(String, Vec<u8>)>, Duration) {
    let place = Place::new();
    let start = Instant::now();
    let answer = simulate(run, &into(place.path()));
    assert!(matches!(answer.code, Some(0 | 3)), "{}", answer.stderr);
    let files = tree(place.path());
    let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
    let expected = [
        "checkpoint.onset",
        "field-0000.vtu",
        "field-0001.vtu",
        "field-0002.vtu",
        "field-0003.vtu",
        "field-0004.vtu",
        "fields.pvd",
        "history.csv",
        "simulate.html",
        "simulate.pdf",
        "simulate.png",
        "simulate.svg",
    ];
    assert_eq!(names, expected);
    (place, files, start.elapsed())
}

#[test]
fn a_resumed_run_writes_the_same_bytes_after_a_kill() {
    goes_on_when_killed(RUN);
    goes_on_when_killed(POINTS);
}

fn goes_on_when_killed(run: &str) {
    let (_place, files, duration) = whole(run);
    let (seed, cases) = hunted(6);
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    let mut random = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut resumed = 0;
    for case in 0..cases {
        let place = Place::new();
        let arguments = into(place.path());
        // Killed, resumed, killed and resumed again.
        for again in 0..2 {
            let is_kept = place.path().join("checkpoint.onset").exists();
            let more = if again == 1 && is_kept {
                "--resume"
            } else {
                ""
            };
            let mut child = command(&format!("{run} {more}"), &arguments)
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .spawn()
                .expect("the command starts");
            std::thread::sleep(duration.mul_f64(0.8 * random()));
            child.kill().expect("a process");
            child.wait().expect("an end");
        }
        let is_kept = place.path().join("checkpoint.onset").exists();
        resumed += usize::from(is_kept);
        let more = if is_kept { "--resume" } else { "" };
        let answer = simulate(&format!("{run} {more}"), &arguments);
        assert!(
            matches!(answer.code, Some(0 | 3)),
            "case {case}: {}",
            answer.stderr
        );
        assert!(
            tree(place.path()) == files,
            "case {case}, seed {seed}: other bytes"
        );
    }
    assert!(resumed > 0, "no kill has left a checkpoint");
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_ends_cleanly_and_writes_the_same_bytes_when_resumed() {
    let (_place, files, _) = whole(RUN);
    let place = Place::new();
    let arguments = into(place.path());
    let child = command(RUN, &arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the command starts");
    let start = Instant::now();
    while !place.path().join("checkpoint.onset").exists() {
        assert!(start.elapsed() < Duration::from_secs(60), "no checkpoint");
        std::thread::sleep(Duration::from_millis(1));
    }
    let killed = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(killed.expect("kill").success());
    let output = child.wait_with_output().expect("an end");
    assert_eq!(
        output.status.code(),
        Some(130),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    assert!(tree(place.path()) != files, "it ended before");
    let answer = simulate(&format!("{RUN} --resume"), &arguments);
    assert!(matches!(answer.code, Some(0 | 3)), "{}", answer.stderr);
    assert!(tree(place.path()) == files);
}

#[test]
fn damaged_and_foreign_checkpoints_are_refused() {
    let (place, files, _) = whole(RUN);
    let arguments = into(place.path());
    let path = place.path().join("checkpoint.onset");
    let bytes = std::fs::read(&path).expect("a checkpoint");
    let refused = |line: &str, told: &str| {
        let answer = simulate(line, &arguments);
        assert_eq!(answer.code, Some(2), "{line}: {}", answer.stdout);
        assert!(answer.stderr.contains(told), "{line}: {}", answer.stderr);
        assert!(answer.stderr.contains("hint"), "{}", answer.stderr);
    };
    refused(RUN, "--resume");
    refused(
        &format!("{} --resume", RUN.replace("1.2,0.9", "1.2,0.91")),
        "another run",
    );
    refused(
        &format!("{} --resume", RUN.replace("--seed 7", "--seed 8")),
        "another run",
    );
    std::fs::write(&path, &bytes[..bytes.len() / 2]).expect("written");
    refused(&format!("{RUN} --resume"), "cut off");
    std::fs::write(&path, b"something else").expect("written");
    refused(&format!("{RUN} --resume"), "not a checkpoint");
    // A complete checkpoint is resumed, or started over if the run ended before its first checkpoint.
    for (more, has_checkpoint) in [
        ("--resume", true),
        ("--overwrite", true),
        ("--resume", false),
    ] {
        match has_checkpoint {
            true => std::fs::write(&path, &bytes).expect("written"),
            false => std::fs::remove_file(&path).expect("removed"),
        }
        let answer = simulate(&format!("{RUN} {more}"), &arguments);
        assert!(matches!(answer.code, Some(0 | 3)), "{}", answer.stderr);
        assert!(tree(place.path()) == files, "{more}");
    }
}

#[cfg(unix)]
#[test]
fn a_full_disk_preserves_the_last_checkpoint() {
    // The first checkpoints fit, but longer histories do not.
    let place = Place::new();
    let limited = "ulimit -f 64; trap '' XFSZ; exec \"$@\"";
    let line = RUN
        .replace("--cells 4", "--cells 2 --set discretization.penalty=0.4")
        .replace("--fields 5", "--fields 0");
    let output = Command::new("sh")
        .args(["-c", limited, "sh", env!("CARGO_BIN_EXE_onset"), "simulate"])
        .args(line.split_whitespace())
        .args(["--every", "1"])
        .args(into(place.path()))
        .output()
        .expect("a shell");
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(
        told.contains("cannot write") && told.contains("the last checkpoint"),
        "{told}"
    );
    let mut others = into(place.path()).to_vec();
    others.extend(["--every", "1", "--resume"].map(str::to_owned));
    let answer = simulate(&line, &others);
    assert!(matches!(answer.code, Some(0 | 3)), "{}", answer.stderr);
}

/// All waves of such a patch are rigid translations or alternating displacements, and nodal integration resists neither.
#[test]
fn a_patch_of_zero_energy_modes_has_no_largest_stable_step() {
    let line =
        "--stretch 1,1 --set discretization.method=total-lagrangian-sph --cells 2 --steps 10";
    let answer = simulate(line, &[]);
    assert_eq!(answer.code, Some(2), "{}{}", answer.stdout, answer.stderr);
    assert!(answer.stderr.contains("no wave of the patch oscillates"));
    assert!(answer.stderr.contains("--time-step"));
}

#[test]
fn a_motion_that_breaks_down_is_reported_with_time_particle_and_state() {
    // Noise of half a spacing inverts elements.
    let line = "--stretch 1,1 --set discretization.method=finite-elements --set discretization.mesh=quadrilaterals --cells 4 --mode noise --amplitude 0.9 --steps 2000";
    let answer = simulate(line, &[]);
    assert_eq!(answer.code, Some(1), "{}{}", answer.stdout, answer.stderr);
    for word in [
        "time",
        "particle",
        "displacement",
        "deformation gradient",
        "hint",
    ] {
        assert!(answer.stderr.contains(word), "{word}: {}", answer.stderr);
    }
}

#[test]
fn motions_that_cannot_be_run_are_refused() {
    let cases = [
        ("--stretch 1,1 --cells 0", "--cells"),
        ("--stretch 1,1 --cells 8,8,8", "--cells"),
        ("--stretch 1,1 --cells 100000", "too many particles"),
        ("--stretch 1,1 --wave-vector 1.234,0", "whole numbers"),
        ("--stretch 1,1 --turns 1", "--turns"),
        ("--stretch 1,1 --turns 1,0 --branch 3", "branch"),
        ("--stretch 1,1 --integrator eulerian", "available:"),
        (
            "--stretch 1,1 --integrator euler",
            "unstable for every time step",
        ),
        ("--stretch 1,1 --fraction 2", "largest stable"),
        ("--stretch 1,1 --resume", "--out"),
        (
            "--stretch 1,1 --set discretization.method=total-lagrangian-sph --set discretization.viscosity=1 --integrator sixth-order",
            "backward substeps",
        ),
    ];
    for (line, told) in cases {
        let answer = simulate(line, &[]);
        assert_eq!(answer.code, Some(2), "{line}: {}", answer.stdout);
        assert!(answer.stderr.contains(told), "{line}: {}", answer.stderr);
    }
}

#[test]
fn damped_and_smoothed_waves_have_their_rates_in_discrete_time_with_every_integrator() {
    let method = "--set discretization.lattice=square --set discretization.support=2.01 --stretch 1,1 --cells 4 --turns 1,0 --branch 2 --steps 400 --fraction 0.3 --json";
    for choices in [
        "--set discretization.method=total-lagrangian-sph --set discretization.viscosity=0.5",
        "--set discretization.method=updated-sph --set discretization.velocity-smoothing=0.5",
        "--set discretization.method=updated-sph --set discretization.viscosity=1",
    ] {
        for integrator in ["velocity-verlet", "symplectic-euler", "midpoint"] {
            let answer = simulate(
                &format!("{method} {choices} --integrator {integrator}"),
                &[],
            );
            assert_eq!(
                answer.code,
                Some(0),
                "{choices} {integrator}: {}{}",
                answer.stdout,
                answer.stderr
            );
            let answer = answer.document();
            let [a, b] = ["continuous", "predicted"]
                .map(|own| number(&answer, &format!("/{own}/frequency")));
            // The correction is much larger than the tolerance.
            assert!(
                (a / b - 1.0).abs() > 1e-5,
                "{choices} {integrator}: {a} {b}"
            );
        }
    }
}

#[test]
fn an_answer_prints_material_and_units_with_six_digits() {
    let line = "--stretch 1.1,1 --set material.model=neo-hooke --set material.mu=1MPa --set material.lambda=2MPa \
                --set discretization.density=1000kg/m^3 --set discretization.spacing=1mm --set discretization.method=tlsph \
                --set discretization.penalty=0.2 --cells 4 --turns 1,0";
    let answer = simulate(line, &[]);
    let told = &answer.stdout;
    assert_eq!(answer.code, Some(0), "{told}{}", answer.stderr);
    for fact in [
        "material                neo-hooke",
        "mu 1e6 Pa",
        "discretization          total-lagrangian-sph",
        "stretches (1.1, 1, 1)",
        " rad/s",
        " 1/m, branch 1",
        " 1/s^2",
        // A traveling wave does not grow, to rounding.
        "growth rate 0 1/s",
    ] {
        assert!(told.contains(fact), "no `{fact}` in\n{told}");
    }
    for word in told.split([' ', '(', ')', ',', ';', '\n']) {
        if word.parse::<f64>().is_err() {
            continue;
        }
        let mantissa = word.split('e').next().unwrap_or_default();
        let digits = mantissa
            .trim_start_matches(['-', '+', '0', '.'])
            .replace('.', "");
        assert!(digits.len() <= 6, "{word} in\n{told}");
        let size = word.parse::<f64>().unwrap_or_default().abs();
        assert!(size == 0.0 || size > 1e-15, "{word} in\n{told}");
    }
}
