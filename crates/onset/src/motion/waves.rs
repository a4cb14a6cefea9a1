//! Plane waves of a patch, in continuous and in discrete time.

use super::Stepper;
use crate::algebra::{Complex, Each, any_eigenvalues, array_of};
use crate::bloch::WaveSystem;
use crate::scheme::PeriodicPatch;
use crate::time_step::{Amplification, critical_time_step_at};
use nalgebra::{DMatrix, DVector, SVector};

/// Rounding error of `omega^2` as a fraction of the largest `omega^2`.
const OMEGA_SQUARED_ROUNDING: f64 = 1e-10;
/// Multiple of the rounding error of the sums that also counts as zero, needed because all waves of a small patch can have zero energy.
const NOISE_FACTOR: f64 = 16.0;

/// Plane wave that fits into a patch.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchWave {
    /// Number of wavelengths along each side of the patch.
    pub turns: Vec<usize>,
    /// Reference wave vector; 1/length.
    pub wave_vector: Vec<f64>,
    /// Number of the branch at this wave vector, from 1 by increasing `omega^2`.
    pub branch: usize,
    /// Undamped `omega^2`; 1/time^2.
    pub omega_squared: Complex,
    /// Rate `s` of the solution `exp(s t)`, including damping; 1/time. It belongs to the growing solution, or to the solution with positive
    /// frequency.
    pub rate: Complex,
    /// Whether the wave is a zero-energy mode.
    pub has_zero_energy: bool,
}

impl PatchWave {
    /// Wave vector of the wave; 1/length.
    pub(super) fn vector<const D: usize>(&self) -> SVector<f64, D> {
        SVector::from_fn(|i, _| self.wave_vector[i])
    }
}

/// Wave in discrete time, with its amplification factors and its initial state.
#[derive(Clone, Debug, PartialEq)]
pub struct SteppedWave {
    /// Wave in continuous time.
    pub wave: PatchWave,
    /// Amplification factors per step of the two solutions of the wave.
    pub factors: [Complex; 2],
    /// Whether the second solution decays too fast to be measured, in which case only the first is seeded.
    pub is_alone: bool,
    /// Initial displacements and velocities of the particles of a cell, to be multiplied by `exp(i k.X)`.
    pub(super) seed: [DVector<Complex>; 2],
    /// Projector that measures the amplitude from displacements.
    pub(super) projector: DVector<Complex>,
}

impl SteppedWave {
    /// Returns the rates `s` of the two solutions `exp(s t)`, as sampled once in `every` steps; 1/time. A solution that rotates by more than half a
    /// turn between samples is aliased, as in a record.
    pub fn rates(&self, step: f64, every: u32) -> [Complex; 2] {
        self.factors
            .each(|z| (z.powu(every)).ln() / (step * f64::from(every)))
    }
}

fn rotated(omega_squared: Complex) -> Complex {
    let s = (-omega_squared).sqrt();
    match s.im < 0.0 && s.re.abs() <= s.norm() * f64::EPSILON {
        true => -s,
        false => s,
    }
}

/// Waves of a patch, one of each pair `k`, `-k`, by increasing numbers of wavelengths. The first waves have the wave vector zero.
pub(super) fn waves_of<const D: usize>(
    system: &WaveSystem<D>,
    patch: &PeriodicPatch<D>,
) -> Vec<PatchWave> {
    let cells = patch.cells();
    let reciprocal = system.crystal().lattice().reciprocal();
    let mut waves = Vec::new();
    for index in 0..cells.iter().product() {
        let mut rest = index;
        let turns: [usize; D] = array_of(|i| {
            let own = rest % cells[i];
            rest /= cells[i];
            own
        });
        let opposite: [usize; D] = array_of(|i| (cells[i] - turns[i]) % cells[i]);
        if opposite < turns {
            continue;
        }
        // Among the equivalent wave vectors, the one closest to zero.
        let fractional = SVector::from_fn(|i, _| {
            let turned = turns[i] as f64 / cells[i] as f64;
            if turned > 0.5 { turned - 1.0 } else { turned }
        });
        let k: SVector<f64, D> = reciprocal * fractional;
        let frequencies = system.damping().map(|_| system.frequencies(&k));
        for (branch, omega_squared) in system.omega_squared(&k).into_iter().enumerate() {
            let undamped = rotated(omega_squared);
            let near = |all: &Vec<Complex>| {
                let rates = all.iter().map(|omega| omega * Complex::new(0.0, -1.0));
                let apart = |s: &Complex| (s - undamped).norm();
                rates.min_by(|a, b| apart(a).total_cmp(&apart(b)))
            };
            waves.push(PatchWave {
                turns: turns.to_vec(),
                wave_vector: k.iter().copied().collect(),
                branch: branch + 1,
                omega_squared,
                rate: frequencies.as_ref().and_then(near).unwrap_or(undamped),
                has_zero_energy: false,
            });
        }
    }
    let largest = waves.iter().map(|wave| wave.omega_squared.norm());
    let largest = largest.fold(0.0, f64::max);
    let zero = (OMEGA_SQUARED_ROUNDING * largest).max(NOISE_FACTOR * system.noise());
    for wave in &mut waves {
        wave.has_zero_energy = wave.omega_squared.norm() <= zero;
    }
    waves
}

/// Largest stable step for the waves of a patch; time.
pub(super) fn critical_time_step<const D: usize>(
    system: &WaveSystem<D>,
    waves: &[PatchWave],
    stepper: Stepper,
) -> f64 {
    if system.damping().is_none() {
        let fastest = waves.iter().filter(|wave| !wave.has_zero_energy);
        let fastest = fastest.map(|wave| wave.omega_squared.re);
        let fastest = fastest.fold(0.0, f64::max).sqrt();
        return match fastest > 0.0 {
            true => stepper.bound() / fastest,
            false => f64::INFINITY,
        };
    }
    let each = waves
        .iter()
        .filter(|wave| wave.branch == 1)
        .map(|wave| critical_time_step_at(system, stepper.integrator(), &wave.vector()));
    each.fold(f64::INFINITY, f64::min)
}

/// Returns a wave as advanced by an integrator, or `None` if its eigenvalues do not converge.
pub(super) fn stepped<const D: usize>(
    system: &WaveSystem<D>,
    wave: &PatchWave,
    stepper: Stepper,
    step: f64,
) -> Option<SteppedWave> {
    let k = wave.vector();
    let (factors, seed) = match system.damping() {
        None => undamped(system, &k, wave, stepper, step)?,
        Some(_) => damped(system, &k, wave, stepper, step)?,
    };
    // Scales the largest displacement of a particle of the cell at the origin to one.
    let largest = seed[0]
        .iter()
        .copied()
        .max_by(|a, b| a.norm().total_cmp(&b.norm()))?;
    let place = seed[0].iter().position(|u| *u == largest)?;
    let site = crate::lattice::Particle::home(place / D);
    let phase = Complex::new(0.0, k.dot(&system.crystal().position(&site))).exp();
    let unit = (largest * phase).inv();
    let seed = seed.map(|vector| vector * unit);
    Some(SteppedWave {
        wave: wave.clone(),
        factors,
        is_alone: false,
        projector: system.mass_at(&k) * &seed[0],
        seed,
    })
}

/// Amplification factors, and the displacements and velocities that start a wave.
type Started = ([Complex; 2], [DVector<Complex>; 2]);

/// Treats each wave as an oscillator in the direction of its mode: `u = a T w`, `v = b w` with `M^-1 K T w = omega^2 w`.
fn undamped<const D: usize>(
    system: &WaveSystem<D>,
    k: &SVector<f64, D>,
    wave: &PatchWave,
    stepper: Stepper,
    step: f64,
) -> Option<Started> {
    let (_, mode) = system.modes(k).into_iter().nth(wave.branch - 1)?;
    let moved = match system.drift() {
        Some(drift) => drift.at(k) * &mode,
        None => mode.clone(),
    };
    let oscillator = Amplification::oscillator(wave.omega_squared);
    let matrix = stepper.matrix(&oscillator, step);
    let half_trace = (matrix[(0, 0)] + matrix[(1, 1)]) * 0.5;
    let determinant = matrix[(0, 0)] * matrix[(1, 1)] - matrix[(0, 1)] * matrix[(1, 0)];
    let root = (half_trace * half_trace - determinant).sqrt();
    let mut factors = [half_trace + root, half_trace - root];
    let is_first = |a: Complex, b: Complex| match (a.norm() - b.norm()).abs() > 1e-12 {
        true => a.norm() > b.norm(),
        false => a.im > b.im,
    };
    if is_first(factors[1], factors[0]) {
        factors.swap(0, 1);
    }
    // Velocity for a displacement of one: (G_uu - z) + G_uv b = 0.
    let speed = |z: Complex| (z - matrix[(0, 0)]) / matrix[(0, 1)];
    let travels = wave.omega_squared.re > 0.0 || wave.omega_squared.im != 0.0;
    let b = match (wave.has_zero_energy, travels) {
        (true, _) => Complex::new(0.0, 0.0),
        (false, true) => speed(factors[0]),
        // Seeds growth and decay together, because a short record of one alone does not separate it from the other.
        (false, false) => (speed(factors[0]) + speed(factors[1])) * 0.5,
    };
    Some((factors, [moved, mode * b]))
}

fn damped<const D: usize>(
    system: &WaveSystem<D>,
    k: &SVector<f64, D>,
    wave: &PatchWave,
    stepper: Stepper,
    step: f64,
) -> Option<Started> {
    let n = system.size();
    let mut matrix = stepper.matrix(&Amplification::new(system, k), step);
    // Velocities are scaled by the time step, a similarity transformation that balances both halves.
    let scale = Complex::new(step, 0.0);
    for i in 0..n {
        for j in 0..n {
            matrix[(i, n + j)] /= scale;
            matrix[(n + i, j)] *= scale;
        }
    }
    let values = any_eigenvalues(&matrix)?;
    let near = |rate: Complex| {
        let wanted = (rate * step).exp();
        let apart = |z: &Complex| (z - wanted).norm();
        let nearest = values.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
        nearest.copied()
    };
    let travels = wave.rate.im.abs() > 1e-9 * wave.rate.norm();
    let other = match travels {
        true => wave.rate.conj(),
        false => -wave.rate,
    };
    let factors = [near(wave.rate)?, near(other)?];
    let first = null_vector(&matrix, factors[0])?;
    let whole = match travels || wave.has_zero_energy {
        true => first,
        false => {
            // Both vectors get the same displacement in the direction of the first.
            let second = null_vector(&matrix, factors[1])?;
            let share = first.rows(0, n).dotc(&first.rows(0, n))
                / first.rows(0, n).dotc(&second.rows(0, n));
            first + second * share
        }
    };
    let displacement = whole.rows(0, n).into_owned();
    let velocity = whole.rows(n, n).into_owned() / scale;
    Some((factors, [displacement, velocity]))
}

/// Eigenvector of a matrix for an eigenvalue.
fn null_vector(matrix: &DMatrix<Complex>, value: Complex) -> Option<DVector<Complex>> {
    let n = matrix.nrows();
    let shifted = matrix - DMatrix::identity(n, n) * value;
    let svd = nalgebra::SVD::try_new(shifted, false, true, f64::EPSILON, 1000 * n)?;
    let rows = svd.v_t?;
    let (least, _) = svd.singular_values.argmin();
    Some(rows.row(least).adjoint())
}
