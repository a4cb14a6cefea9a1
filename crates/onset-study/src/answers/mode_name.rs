//! Name of a mode: the motion of the particles, and the point of the zone.

use super::problem::Problem;
use crate::number::{told, vector};
use crate::settings::Family;
use nalgebra::SVector;
use onset::bloch::Mode;
use onset::verdict::ZERO_FREQUENCY_FRACTION;

/// Component of the polarization along the wave, as a fraction: waves are longitudinal above the first value and transverse below the second.
const LONGITUDINAL: f64 = 0.95;
const TRANSVERSE: f64 = 0.3;
/// Relative tolerance for the lengths of wave vectors.
const LENGTH_TOLERANCE: f64 = 1e-6;

/// Describes a mode: `transverse wave at M (particles alternate), frequency 0.41`.
///
/// `spatial` is its wave vector in the deformed lattice (for a long wave, the direction), `fastest` the largest frequency.
pub(super) fn name(
    problem: &Problem,
    mode: &Mode<3>,
    spatial: &SVector<f64, 3>,
    fastest: f64,
) -> String {
    let (settings, dimension) = (&problem.settings, problem.analysis.dimension());
    let reciprocal = problem.analysis.reciprocal();
    let along = spatial.try_normalize(0.0).unwrap_or_else(SVector::zeros);
    let share = (0..dimension)
        .map(|i| mode.polarization[i] * along[i])
        .fold(onset::algebra::Complex::new(0.0, 0.0), |sum, own| sum + own);
    let size: f64 = mode.polarization.iter().map(|own| own.norm_sqr()).sum();
    let share = (share.norm_sqr() / size.max(f64::MIN_POSITIVE)).sqrt();
    let kind = match share {
        _ if dimension == 1 => "",
        share if share >= LONGITUDINAL => "longitudinal ",
        share if share <= TRANSVERSE => "transverse ",
        _ => "oblique ",
    };
    if mode.is_long_wave {
        return format!(
            "long {kind}waves along {}",
            vector(&along.as_slice()[..dimension])
        );
    }
    let omega_squared = mode.omega_squared;
    let is_zero = omega_squared.re.abs() <= ZERO_FREQUENCY_FRACTION * fastest * fastest;
    let frequency = match omega_squared.re > 0.0 && omega_squared.im == 0.0 && !is_zero {
        true => {
            let omega = told(omega_squared.re.sqrt());
            format!(", frequency {}", settings.units().of(omega, "1/s"))
        }
        false if is_zero => ", frequency zero to rounding".to_owned(),
        false => String::new(),
    };
    let k = &mode.wave_vector;
    let place = match point(problem, &reciprocal, k) {
        Some(point) => format!("at {point}"),
        None => format!("along {}", vector(&along.as_slice()[..dimension])),
    };
    let doubled = shortest(&reciprocal, &(k * 2.0)).0;
    let alternates = doubled <= LENGTH_TOLERANCE * longest(&reciprocal);
    let pattern = match (alternates, settings.method.method) {
        (true, Family::FiniteElements) => " (hourglass: nodes alternate)",
        (true, _) => " (particles alternate)",
        (false, _) => "",
    };
    format!("{kind}wave {place}{pattern}{frequency}")
}

/// Named point of the zone that is equivalent to a wave vector by the symmetry of the reference lattice.
///
/// Equivalent points have the same distance from the nearest reciprocal lattice points, and the same number of these.
fn point(
    problem: &Problem,
    reciprocal: &[SVector<f64, 3>],
    k: &SVector<f64, 3>,
) -> Option<&'static str> {
    let own = shortest(reciprocal, k);
    let scale = LENGTH_TOLERANCE * longest(reciprocal);
    let points = problem.analysis.zone_path(problem.settings.named_zone());
    let is_same = |(_, place): &(&'static str, Vec<f64>)| {
        let place = SVector::from_fn(|i, _| place.get(i).copied().unwrap_or(0.0));
        let other = shortest(reciprocal, &place);
        (other.0 - own.0).abs() <= scale && other.1 == own.1
    };
    points.into_iter().find(is_same).map(|(name, _)| name)
}

fn longest(reciprocal: &[SVector<f64, 3>]) -> f64 {
    reciprocal.iter().map(|b| b.norm()).fold(0.0, f64::max)
}

/// Length of the shortest equivalent wave vectors, and their number.
fn shortest(reciprocal: &[SVector<f64, 3>], k: &SVector<f64, 3>) -> (f64, usize) {
    let shifted = |n: i32| {
        let steps = reciprocal.iter().enumerate();
        let shift =
            |(i, b): (usize, &SVector<f64, 3>)| b * f64::from(n / 5_i32.pow(i as u32) % 5 - 2);
        (k - steps.map(shift).sum::<SVector<f64, 3>>()).norm()
    };
    let lengths: Vec<f64> = (0..5_i32.pow(reciprocal.len() as u32))
        .map(shifted)
        .collect();
    let least = lengths.iter().copied().fold(f64::INFINITY, f64::min);
    let is_least = |own: &&f64| **own <= least + LENGTH_TOLERANCE * longest(reciprocal);
    (least, lengths.iter().filter(is_least).count())
}

#[cfg(test)]
mod tests {
    use super::{point, shortest};
    use crate::answers::Problem;
    use crate::settings::Settings;

    #[test]
    fn equivalent_points_of_the_zone_have_one_name() {
        let problem = Problem::new(Settings::default()).expect("a problem");
        let reciprocal = problem.analysis.reciprocal();
        let at = |a: f64, b: f64| reciprocal[0] * a + reciprocal[1] * b;
        let name = |a: f64, b: f64| point(&problem, &reciprocal, &at(a, b));
        for [a, b] in [[0.5, 0.0], [0.0, 0.5], [0.5, 0.5], [-0.5, 0.0], [1.5, 1.0]] {
            assert_eq!(name(a, b), Some("M"), "{a} {b}");
        }
        for [a, b] in [
            [2.0 / 3.0, 1.0 / 3.0],
            [1.0 / 3.0, 2.0 / 3.0],
            [1.0 / 3.0, -1.0 / 3.0],
        ] {
            assert_eq!(name(a, b), Some("K"), "{a} {b}");
        }
        assert_eq!(name(0.2, 0.1), None);
        assert_eq!(shortest(&reciprocal, &at(1.0, 2.0)).1, 1);
    }
}
