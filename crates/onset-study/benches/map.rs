//! States per second of a map on all cores, as one JSON document. `cargo xtask bench` compares it with other programs.
//!
//! `cargo bench -p onset-study --bench map -- [lagrangian|eulerian] [--states N] [--seed S] [--repetitions N] [--out FILE]`:
//! `--out` also writes the extremes of each state, one line per state.

use nalgebra::Vector3;
use onset::analysis::{Analysis, analysis};
use onset::kinematics::DeformationGradient;
use onset::material::ModifiedMooneyRivlin;
use onset::method::{Frame, KernelMethodChoices};
use onset::scheme::MethodChoices;
use onset::verdict::SurveyedState;
use rayon::prelude::*;
use std::error::Error;
use std::sync::Arc;
use std::time::Instant;

/// Range of both stretches.
const RANGE: (f64, f64) = (0.5, 2.5);

/// Number of states in a batch.
const PART: usize = 512;

/// Command-line arguments of the benchmark.
struct Arguments {
    frame: Frame,
    states: usize,
    seed: u64,
    repetitions: usize,
    out: Option<String>,
}

/// Extremes of the spectrum of a state over the zone.
struct Extremes {
    /// Smallest scaled measure `Re omega^2 / (c^2 |k|_h^2)`.
    minimum: f64,
    /// Wave vector of the smallest scaled measure; its direction in the long-wave limit.
    wave_vector: Vector3<f64>,
    /// Largest `Re omega^2`.
    largest: f64,
    /// Largest growth rate.
    growth_rate: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse()?;
    let method = MethodChoices::Kernel(Box::new(KernelMethodChoices {
        frame: arguments.frame,
        ..KernelMethodChoices::default()
    }));
    let material = Arc::new(ModifiedMooneyRivlin::default());
    let survey = analysis(&method, material)?.for_many_states()?;
    let states = states(arguments.states, arguments.seed);
    let mut rates = Vec::new();
    let mut found = Vec::new();
    for _ in 0..arguments.repetitions {
        let start = Instant::now();
        found = map(&*survey, &states);
        rates.push(states.len() as f64 / start.elapsed().as_secs_f64());
    }
    if let Some(path) = &arguments.out {
        std::fs::write(path, table(&found))?;
    }
    let mut sorted = rates.clone();
    sorted.sort_by(f64::total_cmp);
    let document = serde_json::json!({
        "states": states.len(),
        "lost": found.iter().filter(|extremes| extremes.is_none()).count(),
        "threads": rayon::current_num_threads(),
        "states_per_second": sorted[sorted.len() / 2],
        "repetitions": rates,
    });
    println!("{document}");
    Ok(())
}

/// Extremes of all states; `None` if the support is lost.
fn map(survey: &dyn Analysis, states: &[[f64; 2]]) -> Vec<Option<Extremes>> {
    let extremes = |part: &[[f64; 2]]| -> Vec<Option<Extremes>> {
        let deformations = part
            .iter()
            .map(|[first, second]| DeformationGradient::from_stretches([*first, *second, 1.0]))
            .collect::<Result<Vec<_>, _>>();
        let found = survey.states(&deformations.unwrap_or_default());
        found
            .into_iter()
            .map(|state| state.ok().map(|state| Extremes::of(&state)))
            .collect()
    };
    let parts: Vec<Vec<Option<Extremes>>> = states.par_chunks(PART).map(extremes).collect();
    parts.into_iter().flatten().collect()
}

impl Extremes {
    fn of(state: &SurveyedState<3>) -> Self {
        Self {
            minimum: state.scaled_minimum,
            wave_vector: state.wave_vector,
            largest: state.maximum_omega.powi(2),
            growth_rate: state.growth_rate,
        }
    }
}

/// One line per state: minimum, wave vector, largest `omega^2`, growth rate; `nan` if the support is lost.
fn table(found: &[Option<Extremes>]) -> String {
    let line = |extremes: &Option<Extremes>| match extremes {
        Some(e) => format!(
            "{:.17e} {:.17e} {:.17e} {:.17e} {:.17e}\n",
            e.minimum, e.wave_vector.x, e.wave_vector.y, e.largest, e.growth_rate
        ),
        None => "nan nan nan nan nan\n".to_owned(),
    };
    found.iter().map(line).collect()
}

/// Pseudo-random pairs of stretches by splitmix64, in the sequence of `bench/peers/states.py`.
fn states(count: usize, seed: u64) -> Vec<[f64; 2]> {
    let uniform = |n: u64| {
        let mut z = seed.wrapping_add(n.wrapping_mul(0x9E37_79B9_7F4A_7C15));
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^= z >> 31;
        RANGE.0 + (RANGE.1 - RANGE.0) * ((z >> 11) as f64 * (-53.0_f64).exp2())
    };
    (0..count as u64)
        .map(|n| [uniform(2 * n + 1), uniform(2 * n + 2)])
        .collect()
}

impl Arguments {
    fn parse() -> Result<Self, Box<dyn Error>> {
        let mut result = Self {
            frame: Frame::Lagrangian,
            states: 512,
            seed: 1,
            repetitions: 3,
            out: None,
        };
        let mut words = std::env::args().skip(1);
        while let Some(word) = words.next() {
            let mut value = || words.next().ok_or(format!("{word} needs a value"));
            match word.as_str() {
                "lagrangian" => result.frame = Frame::Lagrangian,
                "eulerian" => result.frame = Frame::Eulerian,
                "--states" => result.states = value()?.parse()?,
                "--seed" => result.seed = value()?.parse()?,
                "--repetitions" => result.repetitions = value()?.parse::<usize>()?.max(1),
                "--out" => result.out = Some(value()?),
                // Argument that cargo adds.
                "--bench" => {}
                _ => return Err(format!("unknown argument {word}").into()),
            }
        }
        Ok(result)
    }
}
