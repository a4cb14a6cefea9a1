//! Choice of the most symmetric mode among degenerate modes.

use crate::algebra::Complex;
use crate::zero_energy::Displacements;
use nalgebra::SVector;

/// Returns the most symmetric mode in the space spanned by degenerate modes. An eigenvalue solver returns an arbitrary basis of this space.
///
/// The mode is the projection of the simplest wave that retains at least half of its squared norm. The waves are tried in this order: all particles
/// move along the wave vector, particles of a cell move relative to each other along it, and both motions along each axis. If the space is invariant
/// under the symmetries, the projection is as symmetric as the wave. The largest displacement is one.
pub(super) fn most_symmetric<const D: usize>(
    span: &[Displacements<D>],
    k: &SVector<f64, D>,
) -> Displacements<D> {
    let basis = orthonormal(span);
    let Some(sites) = basis.first().map(Vec::len) else {
        return Vec::new();
    };
    let along = (k.norm() > 0.0).then(|| k.normalize());
    let axes = (0..D).map(|axis| SVector::from_fn(|i, _| f64::from(u8::from(i == axis))));
    let waves = along
        .into_iter()
        .chain(axes)
        .flat_map(|direction: SVector<f64, D>| {
            [1.0, -1.0].map(|sign: f64| -> Displacements<D> {
                let part = |site: usize| sign.powi(site as i32);
                (0..sites)
                    .map(|site| direction.map(|x| Complex::new(part(site) * x, 0.0)))
                    .collect()
            })
        });
    let parts: Vec<Displacements<D>> = waves.map(|wave| part_in(&basis, &wave)).collect();
    let share = |part: &Displacements<D>| dot(part, part).re / sites as f64;
    let half = parts.iter().find(|part| share(part) >= 0.5 - 1e-9);
    let most = || parts.iter().max_by(|a, b| share(a).total_cmp(&share(b)));
    let chosen = half.or_else(most).cloned().unwrap_or_default();
    let largest = chosen
        .iter()
        .map(|own| own.norm())
        .fold(f64::MIN_POSITIVE, f64::max);
    chosen
        .into_iter()
        .map(|own| own.map(|x| x / largest))
        .collect()
}

fn dot<const D: usize>(a: &[SVector<Complex, D>], b: &[SVector<Complex, D>]) -> Complex {
    a.iter().zip(b).map(|(a, b)| a.dotc(b)).sum()
}

/// Projection of a wave onto the span of a basis.
fn part_in<const D: usize>(
    basis: &[Displacements<D>],
    wave: &Displacements<D>,
) -> Displacements<D> {
    let mut part = vec![SVector::zeros(); wave.len()];
    for own in basis {
        let share = dot(own, wave);
        for (sum, own) in part.iter_mut().zip(own) {
            *sum += own.map(|x| x * share);
        }
    }
    part
}

/// Orthonormal basis of the span of some modes.
fn orthonormal<const D: usize>(span: &[Displacements<D>]) -> Vec<Displacements<D>> {
    let mut basis: Vec<Displacements<D>> = Vec::new();
    for mode in span {
        let known = part_in(&basis, mode);
        let rest: Displacements<D> = mode.iter().zip(&known).map(|(a, b)| a - b).collect();
        let size = dot(&rest, &rest).re.sqrt();
        if size > 1e-6 * dot(mode, mode).re.sqrt() {
            basis.push(rest.into_iter().map(|own| own.map(|x| x / size)).collect());
        }
    }
    basis
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;

    fn real(x: f64, y: f64) -> SVector<Complex, 2> {
        Vector2::new(Complex::new(x, 0.0), Complex::new(y, 0.0))
    }

    #[test]
    fn the_polarization_along_the_wave_vector_is_chosen_if_polarizations_are_degenerate() {
        // Two oblique directions span the plane.
        let span = [vec![real(0.3, 0.9)], vec![real(-0.8, 0.1)]];
        let chosen = most_symmetric(&span, &Vector2::new(2.0, 2.0));
        let half = 0.5_f64.sqrt();
        assert!((chosen[0] - real(half, half)).norm() < 1e-12);
    }

    #[test]
    fn the_relative_motion_along_the_wave_vector_is_chosen_if_relative_motions_are_degenerate() {
        let parting = |x: f64, y: f64| vec![real(x, y), real(-x, -y)];
        let span = [parting(0.6, 0.8), parting(0.8, -0.6)];
        let chosen = most_symmetric(&span, &Vector2::new(1.0, 0.0));
        assert!((chosen[0] - real(1.0, 0.0)).norm() < 1e-12);
        assert!((chosen[1] + real(1.0, 0.0)).norm() < 1e-12);
    }

    #[test]
    fn a_nondegenerate_mode_is_unchanged() {
        let transverse = vec![real(0.0, 2.0)];
        let chosen = most_symmetric(&[transverse], &Vector2::new(1.0, 0.0));
        assert!((chosen[0] - real(0.0, 1.0)).norm() < 1e-12);
    }
}
