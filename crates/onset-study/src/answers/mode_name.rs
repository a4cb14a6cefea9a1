//! What a mode is called: how its particles move, and at which point of the zone.

use crate::number::{told, told_of, vector};
use crate::settings::{Family, Settings};
use nalgebra::SVector;
use onset::bloch::Mode;

/// Shares of a polarization along the wave from which it is longitudinal, and up to which it is transverse.
const LONGITUDINAL: f64 = 0.95;
const TRANSVERSE: f64 = 0.3;
/// Lengths of wave vectors that agree to this are equal.
const SAME: f64 = 1e-6;

/// A mode in words: `transverse wave at M (particles alternate), frequency 0.41`. The reciprocal vectors are the columns of `reciprocal`,
/// `spatial` is the wave vector in the deformed lattice, or the direction of a long wave there, `fastest` the largest frequency.
pub(super) fn name<const D: usize>(
    settings: &Settings,
    reciprocal: &nalgebra::SMatrix<f64, D, D>,
    mode: &Mode<D>,
    spatial: &SVector<f64, D>,
    fastest: f64,
) -> String {
    let along = spatial.try_normalize(0.0).unwrap_or_else(SVector::zeros);
    let share = (0..D)
        .map(|i| mode.polarization[i] * along[i])
        .fold(onset::algebra::Complex::new(0.0, 0.0), |sum, own| sum + own);
    let size: f64 = mode.polarization.iter().map(|own| own.norm_sqr()).sum();
    let share = (share.norm_sqr() / size.max(f64::MIN_POSITIVE)).sqrt();
    let kind = match share {
        _ if D == 1 => "",
        share if share >= LONGITUDINAL => "longitudinal ",
        share if share <= TRANSVERSE => "transverse ",
        _ => "oblique ",
    };
    if mode.is_long_wave {
        return format!("long {kind}waves along {}", vector(along.as_slice()));
    }
    let omega_squared = mode.omega_squared;
    // What is rounding beside the largest is zero.
    let is_zero = told_of(omega_squared.re, fastest * fastest) == "0";
    let frequency = match omega_squared.re > 0.0 && omega_squared.im == 0.0 && !is_zero {
        true => {
            let omega = told(omega_squared.re.sqrt());
            format!(", frequency {}", settings.units().of(omega, "1/s"))
        }
        false if is_zero => ", without energy".to_owned(),
        false => String::new(),
    };
    let k = &mode.wave_vector;
    let place = match point(settings, reciprocal, k) {
        Some(point) => format!("at {point}"),
        None => format!("along {}", vector(along.as_slice())),
    };
    let doubled = shortest(reciprocal, &(k * 2.0)).0;
    let alternates = doubled <= SAME * reciprocal.norm();
    let pattern = match (alternates, settings.method.method) {
        (true, Family::FiniteElements) => " (hourglass: nodes alternate)",
        (true, _) => " (particles alternate)",
        (false, _) => "",
    };
    format!("{kind}wave {place}{pattern}{frequency}")
}

/// The named point of the zone that a wave vector is equivalent to by the symmetry of the reference lattice: it is as near to a
/// reciprocal lattice point as that, and to as many of them.
fn point<const D: usize>(
    settings: &Settings,
    reciprocal: &nalgebra::SMatrix<f64, D, D>,
    k: &SVector<f64, D>,
) -> Option<&'static str> {
    let own = shortest(reciprocal, k);
    let scale = SAME * reciprocal.norm();
    let points = settings.zone().zone_path::<D>();
    let is_same = |(_, fractional): &(&'static str, SVector<f64, D>)| {
        let other = shortest(reciprocal, &(reciprocal * fractional));
        (other.0 - own.0).abs() <= scale && other.1 == own.1
    };
    points.into_iter().find(is_same).map(|(name, _)| name)
}

/// The length of the shortest wave vectors that are equivalent to one, and how many there are.
fn shortest<const D: usize>(
    reciprocal: &nalgebra::SMatrix<f64, D, D>,
    k: &SVector<f64, D>,
) -> (f64, usize) {
    let sides = 5_i32.pow(D as u32);
    let lengths: Vec<f64> = (0..sides)
        .map(|n| {
            let shift =
                SVector::<f64, D>::from_fn(|i, _| f64::from(n / 5_i32.pow(i as u32) % 5 - 2));
            (k - reciprocal * shift).norm()
        })
        .collect();
    let least = lengths.iter().copied().fold(f64::INFINITY, f64::min);
    let count = lengths
        .iter()
        .filter(|own| **own <= least + SAME * reciprocal.norm())
        .count();
    (least, count)
}

#[cfg(test)]
mod tests {
    use super::{point, shortest};
    use crate::methods::Discretized;
    use crate::settings::Settings;
    use nalgebra::SVector;

    #[test]
    fn equivalent_points_of_the_zone_have_one_name() {
        let settings = Settings::default();
        let method = Discretized::<2>::new(&settings).expect("a method");
        let reciprocal = *method.lattice().reciprocal();
        let name = |a: f64, b: f64| {
            let k = reciprocal * SVector::from([a, b]);
            point(&settings, &reciprocal, &k)
        };
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
        assert_eq!(
            shortest(&reciprocal, &(reciprocal * SVector::from([1.0, 2.0]))).1,
            1
        );
    }
}
