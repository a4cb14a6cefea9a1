//! Verdicts from a coarse grid of wave vectors, without a search between its points.

use super::{StateWaves, Survey, SurveyedState, ZERO_FREQUENCY_FRACTION};
use crate::algebra::{Complex, Each};
use crate::bloch::{Mode, Stability, growth_rate, is_shown_reversed};
use crate::cancel::checkpoint;
use crate::continuum::Stiffness;
use crate::kinematics::DeformationGradient;
use crate::lattice::grid_coordinates;
use crate::method::MethodError;
use crate::verdict::decided;
use nalgebra::SVector;

/// Smallest growth rate of complex `omega^2` that counts as flutter, relative to the largest frequency: a pair of equal `omega^2` is split by rounding.
const FLUTTER_FRACTION: f64 = 1e-7;
/// Relative difference of measures that count as equal; the first wave of the grid with the smallest measure is reported.
const EQUAL_MEASURES: f64 = 1e-9;

/// Wave of a grid: wave vector, all `omega^2` by increasing real part, and `|k|_h^2`.
type Wave<const D: usize> = (SVector<f64, D>, Vec<Complex>, f64);

impl<const D: usize> Survey<'_, D> {
    /// Like [`Survey::state`], from a grid with `count` wave vectors along each reciprocal vector and without a search between its points.
    ///
    /// The wave vectors are `k = sum_i (n_i / count) b_i` with whole numbers `n_i`; a multiple of 6 includes the points of high symmetry of all
    /// lattices. The material is assessed as in [`Survey::state`], and long waves are tested if the material or a wave of the grid grows. An
    /// instability between the points is missed: growth rate and largest frequency are lower bounds, and `scaled_minimum` and
    /// `lowest_omega_squared` upper bounds. `long_wave_minimum` is not computed and NaN.
    ///
    /// ```
    /// use onset::kinematics::DeformationGradient;
    /// use onset::material::ModifiedMooneyRivlin;
    /// use onset::method::{Frame, KernelMethodChoices, Method};
    /// use onset::verdict::{Survey, Verdict};
    /// let choices = KernelMethodChoices { frame: Frame::Eulerian, ..KernelMethodChoices::default() };
    /// let (method, material) = (Method::<2>::new(choices)?, ModifiedMooneyRivlin::default());
    /// let survey = Survey::new(&method, &material)?;
    /// let f = DeformationGradient::from_stretches([1.2, 1.0, 1.0])?;
    /// let (sampled, searched) = (survey.sampled(&f, 6)?, survey.state(&f)?);
    /// assert_eq!(sampled.verdict, Verdict::Numerical);
    /// assert!(0.0 < sampled.growth_rate && sampled.growth_rate <= searched.growth_rate);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`MethodError`] when discretization or material cannot be evaluated there, or when frequencies over- or underflow.
    pub fn sampled(
        &self,
        f: &DeformationGradient,
        count: usize,
    ) -> Result<SurveyedState<D>, MethodError> {
        let acoustic = Stiffness::<D>::at(self.material, f)?.minimum();
        let waves = self.waves(f)?;
        if let StateWaves::System(system) = &waves {
            system.0.check_mass()?;
        }
        let grid = self.grid(&waves, count);
        let values = || grid.iter().flat_map(|(_, values, _)| values);
        let highest = values().map(|value| value.re).fold(0.0, f64::max);
        let largest = values().map(|value| value.norm()).fold(0.0, f64::max);
        if !values().all(|value| value.is_finite()) || largest == 0.0 {
            return Err(MethodError::NotFinite);
        }
        let (noise, slow) = (
            ZERO_FREQUENCY_FRACTION * largest,
            FLUTTER_FRACTION * largest.sqrt(),
        );
        let lowest = values().map(|value| value.re).fold(0.0, f64::min);
        let fastest = values()
            .map(|value| growth_rate(*value))
            .fold(0.0, f64::max);
        let mut stability = if lowest < -noise {
            Stability::Divergence
        } else if values().any(|value| value.im.abs() > noise && growth_rate(*value) > slow) {
            Stability::Flutter
        } else {
            Stability::Stable
        };
        let material_grows = acoustic.has_growing_waves();
        let is_tested = material_grows || stability != Stability::Stable;
        let of_long_waves = match (stability, acoustic.only_flutters()) {
            (Stability::Stable, true) => Stability::Flutter,
            (Stability::Stable, false) => Stability::Divergence,
            (known, _) => known,
        };
        let long_waves_grow = is_tested && waves.long_waves_grow(of_long_waves, &acoustic);
        if long_waves_grow {
            stability = of_long_waves;
        }
        let is_stable = stability == Stability::Stable;
        let softest = self.softest_of(&grid, noise);
        let has_zero_mode =
            is_stable && !material_grows && self.has_zero_mode(f, Some(&softest))?;
        Ok(SurveyedState {
            verdict: decided(material_grows, is_stable, has_zero_mode, long_waves_grow),
            stability,
            acoustic,
            scaled_minimum: softest.scaled,
            wave_vector: softest.wave_vector,
            is_long_wave: false,
            long_wave_minimum: f64::NAN,
            long_waves_grow,
            lowest_omega_squared: lowest,
            growth_rate: if is_stable { 0.0 } else { fastest },
            maximum_omega: highest.sqrt(),
        })
    }

    /// Waves of the grid, one of each pair `k`, `-k`, in the searched zone.
    fn grid(&self, waves: &StateWaves<D>, count: usize) -> Vec<Wave<D>> {
        let lattice = self.discretization.crystal().lattice();
        let points = (0..count.pow(D as u32)).map(|index| grid_coordinates::<D>(index, count));
        let half = points.filter(|at| *at <= at.each(|n| (count - n) % count));
        let wave = |at: [usize; D]| {
            checkpoint();
            let fractions = SVector::from(at.each(|n| n as f64 / count as f64));
            let folded = waves.search().folded(&(lattice.reciprocal() * fractions));
            let k = match is_shown_reversed(&folded) {
                true => -folded,
                false => folded,
            };
            (k, waves.omega_squared(&k), lattice.laplacian(&k))
        };
        half.map(wave).collect()
    }

    /// Softest mode of a grid. A mode that grows at `k = 0` is scaled with the largest `|k|_h^2`.
    fn softest_of(&self, grid: &[Wave<D>], noise: f64) -> Mode<D> {
        let longest = grid.iter().map(|wave| wave.2).fold(0.0, f64::max);
        let measured = grid.iter().filter_map(|(k, values, laplacian)| {
            let lowest = values.first()?;
            let scale = match laplacian / longest > f64::EPSILON {
                true => *laplacian,
                false if lowest.re < -noise => longest,
                false => return None,
            };
            Some((lowest.re / (self.speed_squared() * scale), *k, *lowest))
        });
        let softest = measured.reduce(|least, own| {
            let margin = EQUAL_MEASURES * least.0.abs();
            if own.0 < least.0 - margin { own } else { least }
        });
        let (scaled, wave_vector, omega_squared) =
            softest.unwrap_or((f64::NAN, SVector::zeros(), Complex::new(0.0, 0.0)));
        Mode {
            wave_vector,
            is_long_wave: false,
            omega_squared,
            scaled,
            polarization: SVector::zeros(),
        }
    }
}
