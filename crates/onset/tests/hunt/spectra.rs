//! The search over the zone compared with a dense search, for random states.

use crate::dense::Waves;
use crate::hunt::{hunted, seeds};
use crate::methods::{Drawn, material, method, state};
use crate::random::Random;
use onset::bloch::{SpectrumSummary, Stability, dynamical_matrix};
use onset::kinematics::DeformationGradient;
use onset::material::Hyperelastic;
use onset::verdict::{Phase, Survey, assess};
use std::time::{Duration, Instant};

/// Seeds of states for which an earlier search was wrong: a narrow sector of growth that deepens beyond the first grid step.
const MENDED: &[u64] = &[229];
/// Smallest growth rate that is compared, as a fraction of sound speed over spacing. In the dense search, smaller rates are rounding errors.
const GROWTH: f64 = 1e-5;
/// Smallest relative difference that is reported.
const DIFFERENCE: f64 = 1e-6;
/// Rounding error of a triple `omega^2` with nearly dependent eigenvectors, relative to the scale.
const DEFECTIVE: f64 = 1e-6;
/// Longest admitted time of an answer; longer times are reported.
const SLOW_ANSWER: Duration = Duration::from_secs(2);

/// Beginnings of complaints about verdicts.
const SAID_STABLE: &str = "said to be stable";
const SAID_TO_GROW: &str = "said to grow";

/// Number of points of the dense search along a reciprocal vector.
fn points<const D: usize>() -> usize {
    let asked = std::env::var("ONSET_DENSE").ok();
    let asked = asked.and_then(|points| points.parse().ok());
    asked.unwrap_or([256, 64, 14][D - 1])
}

#[test]
fn no_random_state_of_any_method_grows_faster_or_is_softer_than_the_search_reports() {
    let seeds = seeds(12, MENDED);
    let mut wrong = Vec::new();
    let mut counts = [0; 3];
    let mut bounded = [[0; 3]; 2];
    let mut time = Duration::ZERO;
    for seed in &seeds {
        let mut random = Random::new(*seed);
        let dimension = random.one_of(&[1, 2, 2, 2, 2, 3]);
        let complaints = match dimension {
            1 => checked::<1>(&mut random),
            2 => checked::<2>(&mut random),
            _ => checked::<3>(&mut random),
        };
        let Some((name, is_stable, took, complaints, gap, is_hermitian)) = complaints else {
            continue;
        };
        if gap > 1e-6 && std::env::var("ONSET_DEBUG").is_ok() {
            eprintln!("seed {seed}: gap {gap:e} {took:?}, Hermitian {is_hermitian}: {name}");
        }
        time += took;
        if took > SLOW_ANSWER {
            eprintln!("seed {seed}: took {took:?}: {name}");
        }
        counts[if is_stable { 0 } else { 1 }] += 1;
        let own = &mut bounded[usize::from(is_hermitian)];
        for (count, most) in own.iter_mut().zip([f64::INFINITY, 1e-3, 1e-6]) {
            *count += usize::from(gap < most);
        }
        for complaint in complaints {
            let text = format!("seed {seed}: {complaint}\n    {name}");
            eprintln!("{text}");
            wrong.push(text);
        }
    }
    for (kind, [all, roughly, closely]) in ["others", "Hermitian"].into_iter().zip(bounded) {
        eprintln!("{kind}: {all} bounded, {roughly} to 1e-3 and {closely} to 1e-6 of the scale");
    }
    counts[2] = seeds.len() - counts[0] - counts[1];
    let verdicts = wrong.iter().filter(|text| is_wrong_verdict(text)).count();
    eprintln!("{verdicts} wrong verdicts");
    eprintln!(
        "{time:?} in the search: {} stable, {} unstable, {} without an answer; {} complaints",
        counts[0],
        counts[1],
        counts[2],
        wrong.len()
    );
    assert!(wrong.is_empty(), "{} complaints", wrong.len());
}

/// Maps omit flutter that grows more slowly than divergence, and a verdict alone stops at the first witness, which can come from a neighboring state.
/// The results must be the same.
#[test]
fn states_of_a_map_and_single_states_have_the_same_verdict_and_growth_rate() {
    let (seed, cases) = hunted(150);
    let mut compared = 0;
    for case in 0..cases as u64 {
        let mut random = Random::new(seed + case);
        compared += usize::from(match random.happens(0.8) {
            true => assert_same_in_a_map::<2>(&mut random, seed + case),
            false => assert_same_in_a_map::<1>(&mut random, seed + case),
        });
    }
    assert!(3 * compared > cases, "{compared} of {cases}");
}

/// Compares a state with the same state in a map; returns true if it has an answer that can be compared.
fn assert_same_in_a_map<const D: usize>(random: &mut Random, seed: u64) -> bool {
    let drawn = method::<D>(random);
    let (law, material) = material(random);
    let f = state::<D>(random);
    let Some((name, Drawn::Scheme(scheme))) = drawn else {
        return false;
    };
    let Ok(survey) = Survey::new(&*scheme, &*material) else {
        return false;
    };
    let (Ok(alone), Ok(many)) = (survey.assess(&f), survey.for_many_states()) else {
        return false;
    };
    let Some(Ok(of_map)) = many.states(&[f]).pop() else {
        panic!("seed {seed}: no state of a map: {name}");
    };
    let what = format!("seed {seed}: {law} at {:?}: {name}", f.leading::<D>());
    assert_eq!(of_map.verdict, alone.verdict, "{what}");
    let beside = f.with_leading(&(f.leading::<D>() * 1.01));
    let witness = many.judge_beside(&beside, None);
    let witness: Vec<_> = witness
        .ok()
        .and_then(|own| own.witness)
        .into_iter()
        .collect();
    for known in [None, Some(&*witness)] {
        let judged = many.judge_beside(&f, known).expect("a verdict");
        let expected = (alone.verdict, alone.spectrum.stability());
        assert_eq!((judged.verdict, judged.stability), expected, "{what}");
    }
    let (told, expected) = (of_map.growth_rate, alone.spectrum.growth_rate());
    let least = GROWTH * many.speed_squared().sqrt();
    assert!(
        (told - expected).abs() <= 1e-6 * expected + least,
        "{what}: grows with {told:e}, alone with {expected:e}"
    );
    true
}

/// Returns true for complaints about a verdict; other complaints concern numbers.
fn is_wrong_verdict(complaint: &str) -> bool {
    complaint.contains(SAID_STABLE) || complaint.contains(SAID_TO_GROW)
}

/// Name, timing and complaints for one random state; `None` if it has no answer.
#[allow(clippy::type_complexity)]
fn checked<const D: usize>(
    random: &mut Random,
) -> Option<(String, bool, Duration, Vec<String>, f64, bool)> {
    let (name, drawn) = method::<D>(random)?;
    let (law, material) = material(random);
    let f = state::<D>(random);
    let name = format!("{law} at {:?}: {name}", f.leading::<D>());
    let start = Instant::now();
    let (spectrum, speed, waves) = answered(&drawn, &*material, &f)?;
    let took = start.elapsed();
    let complaints = compared(&spectrum, speed, &waves);
    let softest = spectrum.softest.scaled;
    let gap = (softest - spectrum.bound) / softest.abs().max(1.0);
    let is_stable = spectrum.is_stable();
    Some((name, is_stable, took, complaints, gap, waves.is_hermitian))
}

fn answered<const D: usize>(
    drawn: &Drawn<D>,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
) -> Option<(SpectrumSummary<D>, f64, Waves<D>)> {
    match drawn {
        Drawn::Kernel(method) => {
            // Beyond the first zone of the current lattice, these waves are not distinct.
            if !method.is_periodic() {
                return None;
            }
            let spectrum = assess(&**method, material, f).ok()?.spectrum;
            let speed = onset::verdict::speed_squared(&**method, material)
                .ok()?
                .sqrt();
            let matrix = dynamical_matrix(method, material, f).ok()?;
            Some((spectrum, speed, Waves::of_matrix(*method.lattice(), matrix)))
        }
        Drawn::Scheme(scheme) => {
            let survey = Survey::new(&**scheme, material).ok()?;
            let spectrum = survey.assess(f).ok()?.spectrum;
            let system = scheme.waves(material, f).ok()?;
            let speed = survey.speed_squared().sqrt();
            Some((spectrum, speed, Waves::of_system(&system)))
        }
    }
}

fn compared<const D: usize>(
    spectrum: &SpectrumSummary<D>,
    speed: f64,
    waves: &Waves<D>,
) -> Vec<String> {
    let found = waves.searched(points::<D>(), [20, 20, 6][D - 1]);
    let mut wrong = Vec::new();
    let (rate, k) = found.growth;
    let said = spectrum.growth_rate();
    if rate > GROWTH * speed {
        if spectrum.is_stable() {
            wrong.push(format!("{SAID_STABLE}, grows with {rate:e} at {k:?}"));
        } else if said < rate * (1.0 - 1e-4) - GROWTH * speed {
            wrong.push(format!("grows with {rate:e} at {k:?}, said {said:e}"));
        }
    }
    // A mode that is reported to grow must grow.
    let mode = &spectrum.fastest_growing;
    if !spectrum.is_stable() && mode.wave_vector.norm() > 0.0 {
        let own = waves.growth_with_rounding(&mode.wave_vector);
        if own < 0.9 * said {
            let k = mode.wave_vector;
            wrong.push(format!(
                "{SAID_TO_GROW} with {said:e}, grows with {own:e} at {k:?}"
            ));
        }
    }
    if !spectrum.is_stable() && said < 1e-7 * speed && rate < 1e-7 * speed {
        let softest = spectrum.softest;
        wrong.push(format!(
            "{SAID_TO_GROW} with {said:e}, found {rate:e}; softest {softest:?}"
        ));
    }
    let (lowest, k) = found.lowest;
    let told = spectrum.lowest.omega_squared.re;
    if lowest < -(GROWTH * speed).powi(2)
        && told > lowest + DIFFERENCE * lowest.abs() + DEFECTIVE * waves.scale
    {
        wrong.push(format!("omega^2 = {lowest:e} at {k:?}, said {told:e}"));
    }
    let (scaled, k) = found.scaled;
    let (scaled, told) = (scaled / (speed * speed), spectrum.softest.scaled);
    if spectrum.bound > scaled.min(told) + 1e-9 * scaled.abs().max(1.0) {
        let bound = spectrum.bound;
        wrong.push(format!(
            "bounded by {bound:e}, but {scaled:e} at {k:?}, said {told:e}"
        ));
    }
    // The scaled measure has no minimum if modes grow at `k = 0`.
    let at_rest = waves.omega_squared(&nalgebra::SVector::zeros());
    let at_rest = at_rest.iter().map(|z| z.re).fold(0.0, f64::min);
    let has_minimum = at_rest > -1e-13 * waves.scale;
    // The bound states the accuracy of the minimum.
    let stated = (told - spectrum.bound) / told.abs().max(1.0) < DIFFERENCE;
    if has_minimum && !stated && told > scaled + DIFFERENCE * (scaled.abs() + 1e-3) {
        wrong.push(format!("scaled minimum {scaled} at {k:?}, said {told}"));
    }
    let (highest, k) = found.highest;
    let (highest, told) = (-highest, spectrum.maximum_omega.powi(2));
    if told < highest * (1.0 - DIFFERENCE) - DEFECTIVE * waves.scale {
        wrong.push(format!("largest omega^2 {highest} at {k:?}, said {told}"));
    }
    if let Some(last) = wrong.last_mut() {
        *last += &format!("\n    scale {:e}, c {speed}, {spectrum:?}", waves.scale);
    }
    wrong
}

/// A probe stops at the first witness; the full search continues.
#[test]
fn a_probe_and_the_full_search_give_the_same_stability() {
    let (seed, cases) = hunted(24);
    for case in 0..cases as u64 {
        let mut random = Random::new(seed + case);
        let (probed, searched) = match random.one_of(&[1, 2, 2, 3]) {
            1 => phases::<1>(&mut random),
            2 => phases::<2>(&mut random),
            _ => phases::<3>(&mut random),
        }
        .unzip();
        assert_eq!(probed, searched, "seed {}", seed + case);
    }
}

fn phases<const D: usize>(random: &mut Random) -> Option<(Phase, Phase)> {
    let Some((_, Drawn::Scheme(scheme))) = method::<D>(random) else {
        return None;
    };
    let (_, material) = material(random);
    let f = state::<D>(random);
    let survey = Survey::new(&*scheme, &*material).ok()?;
    let searched = match survey.spectrum(&f).ok()?.stability() {
        Stability::Stable => Phase::Stable,
        Stability::Flutter => Phase::Flutter,
        Stability::Divergence => Phase::Unstable,
    };
    Some((survey.probe(&f).ok()?.0, searched))
}
