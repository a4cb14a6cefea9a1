//! Conversion of results to three dimensions: vectors are padded with zeros.

use crate::bloch::{Mode, SpectrumSummary};
use crate::certificate::Certificate;
use crate::continuum::{AcousticFlutter, AcousticMinimum};
use crate::measures::{SpuriousMode, SpuriousModes};
use crate::verdict::{Assessment, MaterialAssessment, SurveyedState, WeakestMode};
use nalgebra::{SVector, Scalar};

/// Type whose values convert to three dimensions.
pub(super) trait InSpace {
    /// Type of the converted value.
    type Shown;

    /// Converts the value to three dimensions.
    fn in_3d(&self) -> Self::Shown;
}

impl<T: Scalar + Default, const D: usize> InSpace for SVector<T, D> {
    type Shown = SVector<T, 3>;

    fn in_3d(&self) -> SVector<T, 3> {
        SVector::from_fn(|i, _| self.get(i).cloned().unwrap_or_default())
    }
}

impl<const D: usize> InSpace for AcousticMinimum<D> {
    type Shown = AcousticMinimum<3>;

    fn in_3d(&self) -> AcousticMinimum<3> {
        AcousticMinimum {
            eigenvalue: self.eigenvalue,
            direction: self.direction.in_3d(),
            polarization: self.polarization.in_3d(),
            bound: self.bound,
            rounding: self.rounding,
            flutter: self.flutter.map(|flutter| AcousticFlutter {
                eigenvalue: flutter.eigenvalue,
                direction: flutter.direction.in_3d(),
            }),
        }
    }
}

impl<const D: usize> InSpace for Mode<D> {
    type Shown = Mode<3>;

    fn in_3d(&self) -> Mode<3> {
        Mode {
            wave_vector: self.wave_vector.in_3d(),
            is_long_wave: self.is_long_wave,
            omega_squared: self.omega_squared,
            scaled: self.scaled,
            polarization: self.polarization.in_3d(),
        }
    }
}

impl<const D: usize> InSpace for SpectrumSummary<D> {
    type Shown = SpectrumSummary<3>;

    fn in_3d(&self) -> SpectrumSummary<3> {
        SpectrumSummary {
            softest: self.softest.in_3d(),
            long_wave: self.long_wave.in_3d(),
            lowest: self.lowest.in_3d(),
            fastest_growing: self.fastest_growing.in_3d(),
            maximum_omega: self.maximum_omega,
            tolerance: self.tolerance,
            bound: self.bound,
            flutters: self.flutters,
            long_waves_flutter: self.long_waves_flutter,
        }
    }
}

impl<const D: usize> InSpace for Assessment<D> {
    type Shown = Assessment<3>;

    fn in_3d(&self) -> Assessment<3> {
        let material = &self.material;
        Assessment {
            verdict: self.verdict,
            material: MaterialAssessment {
                response: material.response.clone(),
                minimum: material.minimum.in_3d(),
                ellipticity: material.ellipticity,
                mean_stress: material.mean_stress,
            },
            spectrum: self.spectrum.in_3d(),
            zero_energy: self.zero_energy,
            gradient_norm: self.gradient_norm,
        }
    }
}

impl<const D: usize> InSpace for WeakestMode<D> {
    type Shown = WeakestMode<3>;

    fn in_3d(&self) -> WeakestMode<3> {
        WeakestMode {
            wave_vector: self.wave_vector.in_3d(),
            relative_frequency_squared: self.relative_frequency_squared,
        }
    }
}

impl<const D: usize> InSpace for SurveyedState<D> {
    type Shown = SurveyedState<3>;

    fn in_3d(&self) -> SurveyedState<3> {
        SurveyedState {
            verdict: self.verdict,
            stability: self.stability,
            acoustic: self.acoustic.in_3d(),
            scaled_minimum: self.scaled_minimum,
            wave_vector: self.wave_vector.in_3d(),
            is_long_wave: self.is_long_wave,
            long_wave_minimum: self.long_wave_minimum,
            long_waves_grow: self.long_waves_grow,
            lowest_omega_squared: self.lowest_omega_squared,
            growth_rate: self.growth_rate,
            maximum_omega: self.maximum_omega,
        }
    }
}

impl<const D: usize> InSpace for Certificate<D> {
    type Shown = Certificate<3>;

    fn in_3d(&self) -> Certificate<3> {
        Certificate {
            material: self.material.in_dimensions(),
            discretization: self.discretization.in_dimensions(),
        }
    }
}

impl<const D: usize> InSpace for SpuriousModes<D> {
    type Shown = SpuriousModes<3>;

    fn in_3d(&self) -> SpuriousModes<3> {
        let mode = |mode: &SpuriousMode<D>| SpuriousMode {
            wave_vector: mode.wave_vector.in_3d(),
            wave: mode.wave.in_3d(),
            relative_frequency: mode.relative_frequency,
            nullity: mode.nullity,
            extent: mode.extent,
            displacements: mode.displacements.iter().map(InSpace::in_3d).collect(),
        };
        SpuriousModes {
            modes: self.modes.iter().map(mode).collect(),
            zero_extent: self.zero_extent,
            is_complete: self.is_complete,
            weakest: self.weakest,
        }
    }
}
