//! Decks answered by synthetic particles that move as another prediction requires.

use super::{Place, deck, read};
use std::fmt::Write;

/// Checkerboard mode of a square lattice under the penalty of SMD, with the default choices of the method.
pub const CHECKERBOARD: &str = "--code plain --wave-vector 3.141592653589793,3.141592653589793 --time-step 0.05 --steps 240 --tolerance 1e-6 \
    --set material.model=saint-venant-kirchhoff --set material.young=1 --set material.poisson=0.3 --set discretization.method=total-lagrangian-sph \
    --set discretization.lattice=square --set discretization.kernel=(1-q)^3";
/// Wave of peridynamics.
const BONDS: &str = "--code plain --stretch 1,1,1 --wave-vector 1.2566370614359172,0,0 --branch 3 --time-step 0.05 --steps 160 --tolerance 1e-8 \
    --set material.model=saint-venant-kirchhoff --set material.young=1.5 --set material.poisson=0.25 --set discretization.method=peridynamics \
    --set discretization.lattice=simple-cubic --set discretization.horizon=3";
/// Tensile instability.
const TENSION: &str = "--code plain --stretch 1.05,1.05 --wave-vector 3.141592653589793,0 --time-step 0.02 --steps 200 --tolerance 1e-6 \
    --set material.model=formula --set material.energy=K*(J-ln(J)) --set material.K=1 --set discretization.method=updated-sph \
    --set discretization.lattice=square --set discretization.kernel=(1-q)^3 --set discretization.momentum=mean --set discretization.support=2.01";

/// Particle of a deck: position and initial velocity.
struct Particle {
    id: usize,
    position: [f64; 3],
    velocity: [f64; 3],
}

fn particles(place: &Place) -> Vec<Particle> {
    let table = place.read("particles.csv");
    let row = |line: &str| {
        let numbers: Vec<f64> = line
            .split(',')
            .map(|word| word.parse().expect("a number"))
            .collect();
        let three = |from: usize| [numbers[from], numbers[from + 1], numbers[from + 2]];
        Particle {
            id: numbers[0] as usize,
            position: three(4),
            velocity: three(7),
        }
    };
    table.lines().skip(2).map(row).collect()
}

/// Displacements of a wave relative to its initial velocity, for each step of velocity Verlet.
fn motion(omega_squared: f64, step: f64, steps: usize) -> Vec<f64> {
    let (mut u, mut v) = (0.0, 1.0);
    let mut all = vec![u];
    for _ in 0..steps {
        v -= step * omega_squared * u;
        u += step * v;
        all.push(u);
    }
    all
}

/// `omega^2` and time step of a deck.
fn prediction(place: &Place) -> (f64, f64, usize, usize) {
    let case = place.case();
    let number = |name: &str| case[name].as_f64().expect("a number");
    (
        case["prediction"]["omega_squared"]
            .as_f64()
            .expect("a number"),
        number("time_step"),
        number("steps") as usize,
        number("every") as usize,
    )
}

/// Output of a run whose waves have the given `omega^2` and time step; `moved` changes positions.
pub fn table(
    place: &Place,
    omega_squared: f64,
    step: f64,
    moved: &mut impl FnMut(f64) -> f64,
) -> String {
    let id = place.case()["id"].as_str().expect("a mark").to_owned();
    let (_, said, steps, every) = prediction(place);
    let particles = particles(place);
    let mut text = format!("# onset case {id}\ntime,id,x,y,z\n");
    for (n, u) in motion(omega_squared, step, steps)
        .into_iter()
        .enumerate()
        .step_by(every)
    {
        for particle in &particles {
            let [x, y, z]: [f64; 3] =
                std::array::from_fn(|i| moved(particle.position[i] + u * particle.velocity[i]));
            let _ = writeln!(
                text,
                "{:e},{},{x:.16e},{y:.16e},{z:.16e}",
                n as f64 * said,
                particle.id
            );
        }
    }
    text
}

/// Output of a run in extended XYZ.
fn frames(place: &Place, table: &str) -> String {
    let id = place.case()["id"].as_str().expect("a mark").to_owned();
    let rows: Vec<Vec<&str>> = table
        .lines()
        .skip(2)
        .map(|line| line.split(',').collect())
        .collect();
    let mut text = String::new();
    for frame in rows.chunk_by(|a, b| a[0] == b[0]) {
        let _ = writeln!(
            text,
            "{}\nTime={} case={id} Properties=species:S:1:pos:R:3:id:I:1",
            frame.len(),
            frame[0][0]
        );
        for row in frame {
            let _ = writeln!(text, "X {} {} {} {}", row[2], row[3], row[4], row[1]);
        }
    }
    text
}

/// `omega^2` predicted for the wave of another study.
fn other(line: &str) -> f64 {
    prediction(&deck(line)).0
}

#[test]
fn a_code_that_moves_as_predicted_agrees() {
    let penalized = format!(
        "{CHECKERBOARD} --set discretization.penalty=0.4 --set discretization.support=2.01"
    );
    for line in [&penalized, BONDS, TENSION] {
        let place = deck(line);
        let (omega_squared, step, ..) = prediction(&place);
        place.write("wave.csv", &table(&place, omega_squared, step, &mut |x| x));
        let answer = read(&place, "wave.csv");
        assert_eq!(
            answer.code,
            Some(0),
            "{line}: {}{}",
            answer.stdout,
            answer.stderr
        );
        assert!(answer.number("difference") < 1e-8, "{}", answer.stdout);
        place.write("wave.xyz", &frames(&place, &place.read("wave.csv")));
        let same = read(&place, "wave.xyz");
        assert_eq!(
            same.document()["difference"],
            answer.document()["difference"]
        );
    }
}

#[test]
fn every_mutant_is_detected() {
    let penalized = |penalty: f64, more: &str| {
        format!("{CHECKERBOARD} --set discretization.penalty={penalty} {more}")
    };
    // A checkerboard strains no particle for any correction, so that another wave is used.
    let quarter = |more: &str| {
        penalized(0.4, more).replacen(
            "3.141592653589793,3.141592653589793",
            "1.5707963267948966,0",
            1,
        )
    };
    let support = "--set discretization.support=2.01";
    let mutants = [
        (penalized(0.4, support), penalized(0.42, support)),
        (
            penalized(0.4, support),
            penalized(0.4, "--set discretization.support=2.0502"),
        ),
        (
            quarter(support),
            quarter(&format!("{support} --set discretization.corrected=false")),
        ),
        (
            penalized(0.4, support),
            penalized(
                0.4,
                &format!("{support} --set discretization.penalty-form=smd"),
            ),
        ),
        (
            BONDS.to_owned(),
            format!("{BONDS} --set discretization.partial-volumes=inside"),
        ),
        (
            BONDS.to_owned(),
            format!("{BONDS} --set discretization.partial-volumes=tapered"),
        ),
        (
            TENSION.to_owned(),
            format!("{TENSION} --set discretization.kernel=cubic-spline"),
        ),
        (
            TENSION.to_owned(),
            TENSION.replace("support=2.01", "support=2.0502"),
        ),
    ];
    for (right, wrong) in &mutants {
        let place = deck(right);
        let step = prediction(&place).1;
        place.write("wave.csv", &table(&place, other(wrong), step, &mut |x| x));
        let answer = read(&place, "wave.csv");
        assert_eq!(
            answer.code,
            Some(1),
            "{wrong}: {}{}",
            answer.stdout,
            answer.stderr
        );
        assert_eq!(answer.document()["outcome"], "differs");
    }
    // The output has another time step than stated.
    for line in [
        penalized(0.4, support),
        BONDS.to_owned(),
        TENSION.to_owned(),
    ] {
        let place = deck(&line);
        let (omega_squared, step, ..) = prediction(&place);
        place.write(
            "wave.csv",
            &table(&place, omega_squared, 1.01 * step, &mut |x| x),
        );
        assert_eq!(read(&place, "wave.csv").code, Some(1), "{line}");
    }
}

#[test]
fn noisy_and_truncated_outputs_are_undecided() {
    let penalized = format!(
        "{CHECKERBOARD} --set discretization.penalty=0.4 --set discretization.support=2.01"
    );
    for line in [penalized.as_str(), BONDS, TENSION] {
        let place = deck(line);
        let (omega_squared, step, ..) = prediction(&place);
        let whole = table(&place, omega_squared, step, &mut |x| x);
        // Noise of a hundredth of the amplitude, independent for all particles and frames.
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        let mut noise = |x: f64| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            x + 2e-8 * ((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5)
        };
        let noisy = table(&place, omega_squared, step, &mut noise);
        let lines: Vec<&str> = whole.lines().collect();
        let particles = particles(&place).len();
        let frames = (lines.len() - 2) / particles;
        let first = |count: usize| lines[..count].join("\n") + "\n";
        let half = 2 + frames / 2 * particles;
        let outputs = [
            ("noise", noisy),
            ("between frames", first(half)),
            ("one frame short", first(lines.len() - particles)),
            ("within a frame", first(half + 7)),
            ("within a number", whole[..whole.len() - 9].to_owned()),
        ];
        for (what, output) in &outputs {
            place.write("wave.csv", output);
            let answer = read(&place, "wave.csv");
            assert_eq!(
                answer.code,
                Some(3),
                "{what}, {line}: {}{}",
                answer.stdout,
                answer.stderr
            );
            assert_ne!(answer.document()["reason"], "", "{what}");
        }
    }
}

#[test]
fn integrators_are_distinguished_by_their_rates() {
    // Velocity Verlet instead of the assumed late density: it does not amplify.
    let line = format!(
        "{} --stepping late-density",
        TENSION
            .replace("1.05,1.05", "1,1 --branch 2")
            .replace("3.141592653589793,0", "1.2566370614359172,0")
    );
    let place = deck(&line);
    let (omega_squared, step, ..) = prediction(&place);
    place.write("wave.csv", &table(&place, omega_squared, step, &mut |x| x));
    let answer = read(&place, "wave.csv");
    assert_eq!(answer.code, Some(1), "{}", answer.stdout);
    let growth = answer.document()["predicted"]["growth"]
        .as_f64()
        .expect("a number");
    assert!(
        (growth / (0.25 * omega_squared * step) - 1.0).abs() < 0.02,
        "{growth}"
    );
}
