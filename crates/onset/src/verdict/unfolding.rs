//! Unfolding of the modes of a discretization in the reference configuration.
//!
//! Each mode is assigned to a plane wave of the material, and their frequencies are compared. Modes of a cell with several particles determine their
//! wave vectors only up to reciprocal vectors.

use super::WeakestMode;
use crate::algebra::{Complex, Each, array_of};
use crate::bloch::WaveSystem;
use crate::continuum::Stiffness;
use crate::kinematics::DeformationGradient;
use crate::lattice::{BrillouinZone, Particle, WAVE_VECTOR_ERROR, shorter_first};
use crate::material::Hyperelastic;
use crate::method::MethodError;
use crate::scheme::Discretization;
use crate::zero_energy::Displacements;
use nalgebra::{DMatrix, DVector, SVector};
use std::f64::consts::{PI, TAU};
use std::ops::Range;

/// Largest component of the wave vector of a long wave, in units of the reciprocal vectors. Long waves are not compared.
const LONG_WAVE_LIMIT: f64 = 1e-3;
/// Smallest squared amplitude of a wave that is assigned to a group of modes, relative to the largest squared amplitude.
const AMPLITUDE_FRACTION: f64 = 0.5;
/// Relative tolerance for wave vectors on a face of the zone.
const FACE_TOLERANCE: f64 = 1e-9;
/// Rounding of wave numbers before sorting, relative to the largest.
const SORT_ROUNDING: f64 = 1e-7;
/// Largest difference of degenerate squared frequencies, relative to the largest: for symmetric, then for nonsymmetric forces. Eigenvectors of
/// nonsymmetric matrices do not separate closer eigenvalues.
const DEGENERACY_TOLERANCES: [f64; 2] = [1e-12, 1e-9];
/// Smallest sum of squared displacements of normalized modes after the translations are subtracted; smaller remainders are zero.
const REMAINDER_LIMIT: f64 = 0.5;
/// Relative and absolute tolerance for equal ratios of squared frequencies.
const RATIO_TOLERANCES: [f64; 2] = [1e-6, 1e-12];
/// Largest squared frequency of a material wave that counts as zero, relative to the squared frequency of the fastest wave with the same wave
/// vector.
const ZERO_ENERGY_FRACTION: f64 = 1e-12;
/// Number of branches computed, and the largest squared frequency of additional branches as a fraction of the largest of the material waves. For
/// nonsymmetric matrices a single eigenvector is as expensive as all eigenvalues.
const COMPUTED_BRANCHES: (usize, f64) = (24, 0.25);

/// Unfolding of the modes of a discretization in the reference configuration.
///
/// Assigns each mode to a plane wave of the material. The wave vectors of modes of cells with several particles are known up to reciprocal vectors.
pub(crate) struct Unfolding<'a, const D: usize> {
    /// Positions of the particles of a cell; length.
    positions: Vec<SVector<f64, D>>,
    /// Distance of nearest particles; length.
    spacing: f64,
    system: &'a WaveSystem<D>,
    density: f64,
    zone: BrillouinZone<D>,
    /// Reciprocal vectors whose bisectors contain faces of the zone; the bisectors of other vectors only touch it.
    faces: Vec<SVector<f64, D>>,
    stiffness: Stiffness<D>,
}

/// Slowest mode of a wave vector, relative to the wave of the material.
pub(crate) struct Slowest<const D: usize> {
    /// Squared frequency divided by the squared frequency of the material; infinite if no mode can be compared.
    pub(crate) ratio: f64,
    /// Branch of the mode.
    pub(crate) branch: usize,
    /// Wave vector of the material wave; 1/length.
    pub(crate) wave: SVector<f64, D>,
    /// Differences of `wave` to the shorter material waves that the mode also contains: normals of planes across which another wave becomes the
    /// longest.
    pub(crate) from_others: Vec<SVector<f64, D>>,
}

impl<const D: usize> Slowest<D> {
    /// Result if no mode can be compared.
    fn none(wave: SVector<f64, D>) -> Self {
        Self {
            ratio: f64::INFINITY,
            branch: 0,
            wave,
            from_others: Vec::new(),
        }
    }

    /// Wave vector with a positive first nonzero component; `k` and `-k` are equivalent.
    pub(super) fn forward(&self) -> SVector<f64, D> {
        let is_there = |x: &&f64| x.abs() > FACE_TOLERANCE * self.wave.amax();
        let sign = self.wave.iter().find(is_there).map_or(1.0, |x| x.signum());
        // Adding zero turns -0 into 0.
        self.wave.map(|x| sign * x + 0.0)
    }
}

/// Returns the slower mode. Ties are broken by the longer wave, then by the larger first component of the wave vector.
pub(super) fn slower<const D: usize>(a: WeakestMode<D>, b: WeakestMode<D>) -> WeakestMode<D> {
    let [ratio, other_ratio] = [a, b].each(|mode| mode.relative_frequency_squared);
    let [relative, absolute] = RATIO_TOLERANCES;
    let apart = relative * ratio.abs().max(other_ratio.abs()) + absolute;
    let is_slower = match other_ratio - ratio {
        difference if difference.abs() > apart => difference > 0.0,
        _ => {
            let rounding = WAVE_VECTOR_ERROR * a.wave_vector.norm();
            shorter_first(&a.wave_vector, &b.wave_vector, rounding).is_le()
        }
    };
    if is_slower { a } else { b }
}

impl<'a, const D: usize> Unfolding<'a, D> {
    /// Creates the unfolding from the linearized equations of motion in the reference configuration.
    ///
    /// # Errors
    /// [`MethodError`] when the material cannot be evaluated.
    pub(crate) fn new(
        discretization: &dyn Discretization<D>,
        material: &dyn Hyperelastic,
        system: &'a WaveSystem<D>,
    ) -> Result<Self, MethodError> {
        let crystal = discretization.crystal();
        let zone = BrillouinZone::new(*crystal.lattice());
        let position = |site| crystal.position(&Particle::home(site));
        Ok(Self {
            positions: (0..crystal.sites().len()).map(position).collect(),
            spacing: crystal.nearest_distance(),
            system,
            density: discretization.density(),
            faces: faces_of(&zone),
            zone,
            stiffness: Stiffness::<D>::at(material, &DeformationGradient::identity())?,
        })
    }

    /// Returns the slowest mode of a wave vector, relative to the material.
    pub(crate) fn slowest(&self, k: &SVector<f64, D>) -> Slowest<D> {
        let k = self.zone.folded(k);
        if self.positions.len() > 1 {
            return self.unfolded(&k);
        }
        match self.is_long(&k) {
            true => Slowest::none(k),
            false => Slowest {
                ratio: over(self.system.omega_squared(&k)[0].re, self.longest(&k)),
                branch: 0,
                wave: k,
                from_others: self.faces.clone(),
            },
        }
    }

    /// Number of particles in a cell.
    pub(super) fn sites(&self) -> usize {
        self.positions.len()
    }

    /// Displacements of all modes with the frequency of the given branch.
    pub(crate) fn modes_with(&self, k: &SVector<f64, D>, branch: usize) -> Vec<Displacements<D>> {
        let modes = self.system.modes(k);
        let groups = self.groups(&modes).into_iter();
        let own = groups
            .map(|(numbers, _)| numbers)
            .find(|numbers| numbers.contains(&branch));
        let numbers = own.unwrap_or(branch..branch + 1);
        modes[numbers]
            .iter()
            .map(|(_, mode)| per_particle(mode))
            .collect()
    }

    /// Longest plane wave among the images of `k` that contributes to the given modes; translations at `k = 0` are excluded.
    pub(crate) fn wave_of(
        &self,
        k: &SVector<f64, D>,
        modes: &[Displacements<D>],
    ) -> SVector<f64, D> {
        if self.positions.len() == 1 {
            return self.first_image(k);
        }
        let mut images = self.images(k);
        images.retain(|g| !self.is_long(&(k + g)));
        let held = self.held(&images, modes);
        held.first().map_or(*k, |n| k + images[*n])
    }

    /// Among the images of `k` and `-k` of the same length, the wave vector with the largest first component.
    pub(super) fn first_image(&self, k: &SVector<f64, D>) -> SVector<f64, D> {
        let images = self.zone.bounding_vectors().iter().map(|g| k - g);
        let is_as_long =
            |other: &SVector<f64, D>| other.norm() <= k.norm() * (1.0 + FACE_TOLERANCE);
        let images = images.filter(is_as_long).chain([*k]);
        let both = images.flat_map(|image| [image, -image]);
        let rounding = WAVE_VECTOR_ERROR * k.norm();
        both.min_by(|a, b| shorter_first(a, b, rounding))
            .unwrap_or(*k)
    }

    /// Slowest mode of a cell with several particles.
    ///
    /// A group of modes is assigned to the longest of the waves `k + G` whose squared amplitude is at least [`AMPLITUDE_FRACTION`] times the largest. Modes of
    /// equal frequency form one group, because an eigenvalue solver returns an arbitrary basis of their space.
    fn unfolded(&self, k: &SVector<f64, D>) -> Slowest<D> {
        let is_long = self.is_long(k);
        let mut images = self.images(k);
        images.retain(|g| !self.is_long(&(k + g)));
        let exact: Vec<f64> = images.iter().map(|g| self.material(&(k + g))).collect();
        let largest = exact.iter().copied().fold(0.0, f64::max);
        let branches = self.branches(k, largest);
        let modes = self.system.modes_of(k, |_| branches.clone());
        let mut slowest = Slowest::none(*k);
        for (numbers, value) in self.groups(&modes) {
            // All remaining modes are too fast to have a smaller ratio.
            if value >= slowest.ratio.max(0.0) * largest {
                break;
            }
            let group = modes[numbers.clone()].iter();
            let mut group: Vec<Displacements<D>> =
                group.map(|(_, mode)| per_particle(mode)).collect();
            if is_long && !without_translations(&mut group) {
                continue;
            }
            let held = self.held(&images, &group);
            let [longest, others @ ..] = &held[..] else {
                continue;
            };
            let wave = k + images[*longest];
            let is_as_long =
                |n: &&usize| (k + images[**n]).norm() <= wave.norm() * (1.0 + FACE_TOLERANCE);
            let fastest = held.iter().filter(is_as_long).map(|n| exact[*n]);
            let ratio = over(value, fastest.fold(0.0, f64::max));
            if ratio < slowest.ratio {
                let apart = others.iter().map(|n| images[*longest] - images[*n]);
                slowest = Slowest {
                    ratio,
                    branch: branches[numbers.start],
                    wave,
                    from_others: apart.collect(),
                };
            }
        }
        slowest
    }

    /// Largest difference of squared frequencies that count as equal, relative to the largest.
    fn degenerate(&self) -> f64 {
        DEGENERACY_TOLERANCES[usize::from(!self.system.is_hermitian())]
    }

    /// Ranges of modes with equal frequencies, each with its largest squared frequency. `modes` are sorted by squared frequency.
    fn groups(&self, modes: &[(Complex, DVector<Complex>)]) -> Vec<(Range<usize>, f64)> {
        let sizes = modes.iter().map(|(value, _)| value.norm());
        let apart = self.degenerate() * sizes.fold(0.0, f64::max);
        let mut groups: Vec<(Range<usize>, f64)> = Vec::new();
        for (n, (value, _)) in modes.iter().enumerate() {
            match groups.last_mut() {
                Some((numbers, last)) if (modes[n - 1].0 - value).norm() <= apart => {
                    numbers.end = n + 1;
                    *last = value.re;
                }
                _ => groups.push((n..n + 1, value.re)),
            }
        }
        groups
    }

    /// Branches whose modes are computed: all for symmetric forces and small cells.
    ///
    /// For other large cells, each mode is as expensive as all frequencies. The lowest branches are computed, and the first branch above the longest
    /// waves.
    fn branches(&self, k: &SVector<f64, D>, largest: f64) -> Vec<usize> {
        let (most, share) = COMPUTED_BRANCHES;
        let size = self.system.size();
        if self.system.is_hermitian() || size <= most {
            return (0..size).collect();
        }
        let values = self.system.omega_squared(k);
        let is_asked = |n: usize| [0, D].contains(&n) || n < most && values[n].re < share * largest;
        // Degenerate modes are computed together.
        let sizes = values.iter().map(|value| value.norm());
        let apart = self.degenerate() * sizes.fold(0.0, f64::max);
        let mut groups: Vec<Range<usize>> = Vec::new();
        for n in 0..size {
            match groups.last_mut() {
                Some(own) if (values[n - 1] - values[n]).norm() <= apart => own.end = n + 1,
                _ => groups.push(n..n + 1),
            }
        }
        let asked = groups.into_iter().filter(|own| own.clone().any(is_asked));
        asked.flatten().collect()
    }

    /// Indices of the waves `k + G` that a group of modes of equal frequency contains with a large amplitude.
    fn held(&self, images: &[SVector<f64, D>], modes: &[Displacements<D>]) -> Vec<usize> {
        let share = |g: &SVector<f64, D>| -> f64 {
            let phases = self
                .positions
                .iter()
                .map(|x| Complex::from_polar(1.0, -g.dot(x)));
            let phases: Vec<Complex> = phases.collect();
            let of_one = |mode: &Displacements<D>| {
                let terms = phases.iter().zip(mode).map(|(phase, own)| own * *phase);
                terms.sum::<SVector<Complex, D>>().norm_squared()
            };
            modes.iter().map(of_one).sum()
        };
        let shares: Vec<f64> = images.iter().map(share).collect();
        let most = shares.iter().copied().fold(0.0, f64::max);
        let is_held = |n: &usize| shares[*n] >= AMPLITUDE_FRACTION * most;
        (0..images.len()).filter(is_held).collect()
    }

    fn is_long(&self, k: &SVector<f64, D>) -> bool {
        self.zone.lattice().fractional(k).amax() < LONG_WAVE_LIMIT
    }

    /// Reciprocal vectors `G` of all waves `k + G` that the particle spacing can resolve, longest waves first.
    ///
    /// The zone of a lattice with nearest distance `h` lies within `pi sqrt(D) / h`. Corners of square and cubic zones are at this distance.
    fn images(&self, k: &SVector<f64, D>) -> Vec<SVector<f64, D>> {
        let lattice = self.zone.lattice();
        let shortest = PI * (D as f64).sqrt() / self.spacing;
        // Along a lattice vector `a` a reciprocal vector has the coordinate `a.G / 2 pi`.
        let reach =
            |i: usize| (lattice.vectors().column(i).norm() * 2.0 * shortest / TAU) as i64 + 1;
        let mut images = vec![SVector::zeros()];
        for i in 0..D {
            let b = lattice.reciprocal().column(i).into_owned();
            let along = |g: SVector<f64, D>| (-reach(i)..=reach(i)).map(move |n| g + b * n as f64);
            images = images.into_iter().flat_map(along).collect();
        }
        images.retain(|g| (k + g).norm() <= shortest * (1.0 + FACE_TOLERANCE) || g.norm() == 0.0);
        // Waves of equal length are sorted by decreasing components.
        let rounded = |x: f64| (x / (SORT_ROUNDING * shortest)).round() as i64;
        images.sort_by_key(|g| {
            let wave = k + g;
            let ahead: [i64; D] = array_of(|i| -rounded(wave[i]));
            (rounded(wave.norm()), ahead)
        });
        images
    }

    /// Squared frequency of the slowest wave of the material; zero for shear waves of fluids.
    fn material(&self, k: &SVector<f64, D>) -> f64 {
        let values = continuum(&self.stiffness, self.density, k);
        let is_resisted = values[0] > ZERO_ENERGY_FRACTION * values[D - 1];
        if is_resisted { values[0] } else { 0.0 }
    }

    /// Squared frequency of the material for the shortest equivalent of a wave vector in the zone.
    ///
    /// On the boundary several equivalents have the same length. The fastest of them is used, which gives the smallest ratio.
    fn longest(&self, k: &SVector<f64, D>) -> f64 {
        let on_face = |g: &&SVector<f64, D>| k.dot(g) >= (0.5 - FACE_TOLERANCE) * g.norm_squared();
        let images = self.zone.bounding_vectors().iter().filter(on_face);
        images
            .map(|g| self.material(&(k - g)))
            .fold(self.material(k), f64::max)
    }
}

/// Squared frequencies of the continuum at a wave vector, in increasing order; 1/time^2.
pub(crate) fn continuum<const D: usize>(
    stiffness: &Stiffness<D>,
    density: f64,
    k: &SVector<f64, D>,
) -> Vec<f64> {
    let tensor = stiffness.acoustic_tensor(k) / density;
    let symmetric = DMatrix::from_fn(D, D, |i, j| 0.5 * (tensor[(i, j)] + tensor[(j, i)]));
    let mut values: Vec<f64> = symmetric.symmetric_eigenvalues().iter().copied().collect();
    values.sort_by(f64::total_cmp);
    values
}

/// Splits a mode into the displacements of the particles.
fn per_particle<const D: usize>(displacements: &DVector<Complex>) -> Displacements<D> {
    (0..displacements.len() / D)
        .map(|particle| SVector::from_fn(|i, _| displacements[D * particle + i]))
        .collect()
}

/// Subtracts translations from modes of a cell. Returns true if displacements remain.
fn without_translations<const D: usize>(modes: &mut [Displacements<D>]) -> bool {
    let size = |mode: &Displacements<D>| -> f64 { mode.iter().map(|own| own.norm_squared()).sum() };
    let mut rest = 0.0;
    for mode in modes {
        let whole = size(mode);
        let mean = mode.iter().sum::<SVector<Complex, D>>() / Complex::from(mode.len() as f64);
        mode.iter_mut().for_each(|own| *own -= mean);
        rest += size(mode) / whole;
    }
    rest >= REMAINDER_LIMIT
}

/// Ratio of a squared frequency to the exact squared frequency; infinite if the latter is zero.
fn over(found: f64, exact: f64) -> f64 {
    match exact > 0.0 {
        true => found / exact,
        false => f64::INFINITY,
    }
}

/// Reciprocal vectors of the faces: half of each vector is closer to zero than to any other reciprocal vector.
fn faces_of<const D: usize>(zone: &BrillouinZone<D>) -> Vec<SVector<f64, D>> {
    let all = zone.bounding_vectors();
    let is_face = |g: &&SVector<f64, D>| {
        let mut others = all.iter().filter(|other| *other != *g);
        others.all(|other| 0.5 * g.dot(other) < (0.5 - FACE_TOLERANCE) * other.norm_squared())
    };
    all.iter().filter(is_face).copied().collect()
}
