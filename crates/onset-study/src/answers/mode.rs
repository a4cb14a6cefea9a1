//! The mode that an answer reports, and its wave vector.

use nalgebra::SVector;
use onset::bloch::Mode;
use onset::verdict::Assessment;

/// Mode that an answer reports: the fastest growing one, or the softest one if the state is stable.
pub(super) fn critical_mode(assessment: &Assessment<3>) -> &Mode<3> {
    let spectrum = &assessment.spectrum;
    let grows = spectrum.fastest_growing.omega_squared.re < 0.0 || spectrum.flutters;
    if grows && !spectrum.is_stable() {
        &spectrum.fastest_growing
    } else {
        &spectrum.softest
    }
}

/// The wave vector, zero for the limit of long waves.
pub(super) fn finite_wave_vector(mode: &Mode<3>) -> SVector<f64, 3> {
    if mode.is_long_wave {
        SVector::zeros()
    } else {
        mode.wave_vector
    }
}
