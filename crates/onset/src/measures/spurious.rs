//! Waves that a discretization does not resist: zero-energy modes and weak ones.

use super::dispersion::continuum;
use crate::algebra::{Complex, has_neighbor, is_well, settled};
use crate::continuum::Stiffness;
use crate::kinematics::DeformationGradient;
use crate::method::MethodError;
use crate::verdict::SchemeSurvey;
use nalgebra::SVector;

/// Points of the grid of wave vectors along a reciprocal vector: halves, thirds, quarters and their parts are among them.
const GRID: [usize; 3] = [96, 24, 12];
/// Ratios of squared frequencies below this are zero to rounding.
const ZERO: f64 = 1e-9;
/// How many modes are listed.
const LISTED: usize = 32;

/// A wave of the undeformed body with too little energy.
#[derive(Clone, Debug, PartialEq)]
pub struct SpuriousMode<const D: usize> {
    /// Its wave vector; 1/length.
    pub wave_vector: SVector<f64, D>,
    /// Its frequency over that of the slowest wave of the material with the same wave vector: zero for a zero-energy mode.
    /// Not a number at `k = 0`, where the material has no wave. With several particles in a cell the wave vector is known up to
    /// reciprocal vectors only, and the longest wave is taken: a shorter one is weaker than told.
    pub relative_frequency: f64,
    /// How many independent modes have no energy at this wave vector, translations not counted.
    pub nullity: usize,
    /// Displacement of each particle of the cell at the origin, of the mode with the lowest frequency.
    pub displacements: Vec<SVector<Complex, D>>,
}

impl<const D: usize> SpuriousMode<D> {
    /// Whether it has no energy at all.
    pub fn is_zero(&self) -> bool {
        self.nullity > 0
    }
}

/// The spurious modes of a discretization.
#[derive(Clone, Debug, PartialEq)]
pub struct SpuriousModes<const D: usize> {
    /// Modes without energy first, then the weak ones by their frequency; of `k` and `-k` one.
    pub modes: Vec<SpuriousMode<D>>,
    /// The share of the zone on which modes without energy fill lines, planes, or all of it; zero where they are at single wave
    /// vectors only.
    pub zero_share: f64,
    /// The lowest relative frequency anywhere, long waves included: 1 where no wave is slower than the material's.
    pub weakest: f64,
}

/// All wave vectors at which some mode has no energy, and those at which the relative frequency has a minimum below
/// `threshold`; in the undeformed body, over the whole zone.
///
/// # Errors
/// [`MethodError`] when the material cannot be evaluated.
pub fn spurious_modes<const D: usize>(
    survey: &SchemeSurvey<'_, D>,
    threshold: f64,
) -> Result<SpuriousModes<D>, MethodError> {
    let identity = DeformationGradient::identity();
    let stiffness = Stiffness::<D>::at(survey.material(), &identity)?;
    Ok(Spurious { survey, stiffness }.modes(threshold))
}

struct Spurious<'a, 's, const D: usize> {
    survey: &'a SchemeSurvey<'s, D>,
    stiffness: Stiffness<D>,
}

impl<const D: usize> Spurious<'_, '_, D> {
    /// The lowest squared frequency over that of the continuum.
    fn ratio(&self, k: &SVector<f64, D>) -> f64 {
        let k = self.survey.search().folded(k);
        let exact = continuum(&self.stiffness, self.survey.scheme().density(), &k)[0];
        let found = self.survey.reference().omega_squared(&k)[0].re;
        if exact > 0.0 {
            found / exact
        } else {
            f64::INFINITY
        }
    }

    fn modes(&self, threshold: f64) -> SpuriousModes<D> {
        let n = GRID[D - 1];
        let lattice = self.survey.scheme().crystal().lattice();
        let count = n.pow(D as u32);
        // Of k and -k one is enough.
        let half = (n / 2 + 1) * (count / n);
        let wave_vector = |index: usize| {
            let mut rest = index;
            let mut fractional = SVector::<f64, D>::zeros();
            for i in (0..D).rev() {
                fractional[i] = (rest % n) as f64 / n as f64;
                rest /= n;
            }
            lattice.reciprocal() * fractional
        };
        let values: Vec<f64> = (0..half)
            .map(|index| self.ratio(&wave_vector(index)))
            .collect();
        let known = values.iter().filter(|value| value.is_finite());
        let zeros = (1..half)
            .filter(|index| values[*index] <= ZERO)
            .filter(|index| has_neighbor::<D>(&values, *index, n, |value| value <= ZERO))
            .count();
        let zero_share = zeros as f64 / known.clone().count().max(1) as f64;
        let least = known.fold(f64::INFINITY, |a, b| a.min(*b));

        let mut modes: Vec<SpuriousMode<D>> = self.at_rest().into_iter().collect();
        let steps = lattice.reciprocal() / n as f64;
        let mut bottoms: Vec<(f64, SVector<f64, D>)> = (1..half)
            .filter(|index| values[*index] < threshold * threshold * 1.5)
            .filter(|index| is_well::<D>(&values, *index, n))
            .map(|index| {
                let start = (values[index], wave_vector(index));
                if start.0 <= ZERO {
                    start
                } else {
                    settled(&|k| self.ratio(k), start, &steps)
                }
            })
            .filter(|bottom| bottom.0 < threshold * threshold)
            .collect();
        bottoms.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut weakest = least;
        for (ratio, k) in bottoms {
            weakest = weakest.min(ratio);
            // A well whose bottom is at k = 0 is no wave: the stiffness of all long waves is too low.
            let fractional = lattice.vectors().transpose() * k / std::f64::consts::TAU;
            let from_zero = fractional - fractional.map(f64::round);
            if from_zero.amax() < 1.0 / n as f64 {
                continue;
            }
            let mode = self.mode(&self.survey.search().folded(&k), ratio);
            let is_known = modes.iter().any(|known| self.is_same(known, &mode));
            if !is_known && modes.len() < LISTED {
                modes.push(mode);
            }
        }
        SpuriousModes {
            modes,
            zero_share,
            weakest: weakest.clamp(0.0, 1.0).sqrt(),
        }
    }

    fn mode(&self, k: &SVector<f64, D>, ratio: f64) -> SpuriousMode<D> {
        let exact = continuum(&self.stiffness, self.survey.scheme().density(), k)[0];
        let modes = self.survey.reference().modes(k);
        let nullity = modes
            .iter()
            .filter(|(value, _)| value.re <= ZERO * exact)
            .count();
        SpuriousMode {
            wave_vector: *k,
            relative_frequency: if nullity > 0 {
                0.0
            } else {
                ratio.max(0.0).sqrt()
            },
            nullity,
            displacements: modes
                .first()
                .map(|(_, displacements)| per_particle(displacements))
                .unwrap_or_default(),
        }
    }

    /// Modes at `k = 0` other than the translations, which only cells with several particles have.
    fn at_rest(&self) -> Option<SpuriousMode<D>> {
        let system = self.survey.reference();
        let zero = SVector::zeros();
        let modes = system.modes(&zero);
        // All modes of the cell may be free: the scale is that of the material's waves.
        let spacing = self.survey.scheme().crystal().nearest_distance();
        let scale = self.survey.speed_squared() / (spacing * spacing);
        let free = modes
            .iter()
            .filter(|(value, _)| value.re <= ZERO * scale)
            .count();
        let nullity = free.checked_sub(D).filter(|nullity| *nullity > 0)?;
        // The part of a free mode that is no translation.
        let internal = modes[..free].iter().map(|(_, displacements)| {
            let particles = per_particle::<D>(displacements);
            let mean = particles.iter().sum::<SVector<Complex, D>>()
                / Complex::new(particles.len() as f64, 0.0);
            particles.iter().map(|own| own - mean).collect::<Vec<_>>()
        });
        let size = |particles: &Vec<SVector<Complex, D>>| {
            particles.iter().map(|own| own.norm_squared()).sum::<f64>()
        };
        let displacements = internal.max_by(|a, b| size(a).total_cmp(&size(b)))?;
        Some(SpuriousMode {
            wave_vector: zero,
            relative_frequency: f64::NAN,
            nullity,
            displacements,
        })
    }

    /// Whether two modes have the same wave vector, or opposite ones, up to reciprocal vectors.
    fn is_same(&self, a: &SpuriousMode<D>, b: &SpuriousMode<D>) -> bool {
        let lattice = self.survey.scheme().crystal().lattice();
        let is_zero = |k: SVector<f64, D>| {
            let fractional = lattice.vectors().transpose() * k / std::f64::consts::TAU;
            (fractional - fractional.map(f64::round)).amax() < 1e-4
        };
        is_zero(a.wave_vector - b.wave_vector) || is_zero(a.wave_vector + b.wave_vector)
    }
}

fn per_particle<const D: usize>(
    displacements: &nalgebra::DVector<Complex>,
) -> Vec<SVector<Complex, D>> {
    (0..displacements.len() / D)
        .map(|particle| SVector::from_fn(|i, _| displacements[D * particle + i]))
        .collect()
}
