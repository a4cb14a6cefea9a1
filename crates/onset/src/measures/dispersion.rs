//! Errors of frequencies, and of the moduli in the long-wave limit.

use crate::algebra::{Complex, directions};
use crate::bloch::WaveSystem;
use crate::continuum::Stiffness;
use crate::kinematics::DeformationGradient;
use crate::method::MethodError;
use crate::verdict::{Survey, continuum};
use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use std::f64::consts::TAU;

/// Largest error of the frequencies at a wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct DispersionError {
    /// Wavelength in particle spacings, the number of points per wavelength.
    pub particles_per_wavelength: f64,
    /// Largest `|omega / omega_exact - 1|` over directions and acoustic branches, in the reference configuration.
    pub error: f64,
}

/// Computes the frequency errors in the reference configuration at wavelengths given in particle spacings, [`crate::lattice::Crystal::spacing`].
pub fn dispersion_errors<const D: usize>(
    survey: &Survey<'_, D>,
    particles_per_wavelength: &[f64],
) -> Result<Vec<DispersionError>, MethodError> {
    let spacing = survey.discretization().crystal().spacing();
    let stiffness = at_rest(survey)?;
    let system = survey.reference()?;
    let density = survey.discretization().density();
    let of_wavelength = |count: &f64| {
        let length = TAU / (count * spacing);
        let error = directions::<D>()
            .iter()
            .map(|direction| frequency_error(system, &stiffness, density, &(direction * length)))
            .fold(0.0, f64::max);
        DispersionError {
            particles_per_wavelength: *count,
            error,
        }
    };
    Ok(particles_per_wavelength.iter().map(of_wavelength).collect())
}

/// Relative error of the long-wavelength moduli in the reference configuration.
///
/// It is the largest component of the difference between the long-wave stiffness of discretization and material (both symmetrized as they act on
/// waves), divided by the largest component of the material stiffness.
///
/// # Errors
/// [`MethodError`] when the material cannot be evaluated.
pub fn long_wave_error<const D: usize>(survey: &Survey<'_, D>) -> Result<f64, MethodError> {
    let exact = at_rest(survey)?;
    let discrete = survey.reference()?.long_wave_stiffness();
    let density = survey.discretization().density();
    let (mut difference, mut scale) = (0.0_f64, 0.0_f64);
    for j in 0..D {
        for l in 0..=j {
            // Sum over J, L = j, l and l, j, from differences of a quadratic form.
            let mixed = |stiffness: &Stiffness<D>| -> SMatrix<f64, D, D> {
                let unit = |i: usize| SVector::from_fn(|n, _| f64::from(u8::from(n == i)));
                let sum: SVector<f64, D> = unit(j) + unit(l);
                let apart: SVector<f64, D> = unit(j) - unit(l);
                (stiffness.acoustic_tensor(&sum) - stiffness.acoustic_tensor(&apart)) * 0.25
            };
            let exact = mixed(&exact) / density;
            difference = difference.max((mixed(&discrete) - exact).amax());
            scale = scale.max(exact.amax());
        }
    }
    Ok(difference / scale)
}

fn at_rest<const D: usize>(survey: &Survey<'_, D>) -> Result<Stiffness<D>, MethodError> {
    Ok(Stiffness::at(
        survey.material(),
        &DeformationGradient::identity(),
    )?)
}

fn frequency_error<const D: usize>(
    system: &WaveSystem<D>,
    stiffness: &Stiffness<D>,
    density: f64,
    k: &SVector<f64, D>,
) -> f64 {
    let error = |found: f64, exact: f64| ((found.max(0.0) / exact).sqrt() - 1.0).abs();
    if system.size() == D {
        let found = system.omega_squared(k);
        let exact = continuum(stiffness, density, k);
        let pairs = found.iter().zip(&exact);
        return pairs
            .map(|(found, exact)| error(found.re, *exact))
            .fold(0.0, f64::max);
    }
    // With several particles in a cell the zone is folded. The branch of a wave is the mode that resembles it most.
    let tensor = stiffness.acoustic_tensor(k) / density;
    let symmetric = DMatrix::from_fn(D, D, |i, j| 0.5 * (tensor[(i, j)] + tensor[(j, i)]));
    let exact = symmetric.symmetric_eigen();
    let modes = system.modes(k);
    let likeness = |displacements: &DVector<Complex>, wave: usize| {
        let along = |(row, z): (usize, &Complex)| z * exact.eigenvectors[(row % D, wave)];
        displacements
            .iter()
            .enumerate()
            .map(along)
            .sum::<Complex>()
            .norm()
    };
    (0..D)
        .map(|wave| {
            let alike = modes
                .iter()
                .max_by(|a, b| likeness(&a.1, wave).total_cmp(&likeness(&b.1, wave)));
            alike.map_or(f64::NAN, |(found, _)| {
                error(found.re, exact.eigenvalues[wave])
            })
        })
        .fold(0.0, f64::max)
}
