//! Modes of a discretization at rest beside the plane waves of the material: which wave a mode is, and how much slower than that of the material.

use super::WeakestMode;
use crate::algebra::{Complex, Each, array_of};
use crate::bloch::WaveSystem;
use crate::continuum::Stiffness;
use crate::kinematics::DeformationGradient;
use crate::lattice::{BrillouinZone, Particle};
use crate::material::Hyperelastic;
use crate::method::MethodError;
use crate::scheme::Discretization;
use nalgebra::{DMatrix, DVector, SVector};
use std::cmp::Ordering;
use std::f64::consts::{PI, TAU};
use std::ops::Range;

/// Waves longer than this, in units of the reciprocal vectors, are as good as infinitely long.
const LONG: f64 = 1e-3;
/// Modes count as a wave if they hold at least this part of what they hold most of.
const HELD: f64 = 0.5;
/// What a wave vector may be short of a face of the zone, relative to it, and be on it.
const ON_FACE: f64 = 1e-9;
/// To what wave vectors are rounded before they are put in order, over the largest.
const ROUNDED: f64 = 1e-7;
/// Relative error of the components of a wave vector at the end of a descent.
const TIED: f64 = 1e-5;
/// Squared frequencies that differ by less from the next, relative to the largest, are equal: where forces have an energy, and where they have none, as
/// vectors of closer ones are not told apart there.
const DEGENERATE: [f64; 2] = [1e-12, 1e-9];
/// The part of unit displacements that is more than a translation.
const REST: f64 = 0.5;
/// Ratios of squared frequencies that differ by less, relative to each other or beside one, are the same.
const AS_SLOW: [f64; 2] = [1e-6, 1e-12];
/// Waves of the material whose squared frequency is smaller, beside that of its fastest wave along the same vector, have no energy to be compared with.
const WITHOUT_ENERGY: f64 = 1e-12;
/// Where each mode takes as long as all values: how many of the lowest are asked, and up to which share of the largest squared frequency of the waves that they can be.
const LOWEST: (usize, f64) = (24, 0.25);

/// The modes of a discretization at rest, each beside the plane wave of the material that it is. Those of a cell with several particles are known up
/// to reciprocal vectors: they are unfolded.
pub(crate) struct Unfolding<'a, const D: usize> {
    /// The places of the particles of a cell; length.
    positions: Vec<SVector<f64, D>>,
    /// The distance of the nearest particles; length.
    spacing: f64,
    system: &'a WaveSystem<D>,
    density: f64,
    zone: BrillouinZone<D>,
    /// The reciprocal vectors whose bisectors are faces of the zone, not only touch it.
    faces: Vec<SVector<f64, D>>,
    stiffness: Stiffness<D>,
}

/// The mode of a wave vector that is slowest beside the wave of the material that it is.
pub(crate) struct Slowest<const D: usize> {
    /// Its squared frequency over that of the material; infinite where nothing can be compared.
    pub(crate) ratio: f64,
    /// The number of its branch.
    pub(crate) branch: usize,
    /// Which wave of the material it is; 1/length.
    pub(crate) wave: SVector<f64, D>,
    /// What leads to it from others that it is as well, and shorter: the normals of planes across which another one is the longest.
    pub(crate) from_others: Vec<SVector<f64, D>>,
}

impl<const D: usize> Slowest<D> {
    /// Where nothing is compared.
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
        let is_there = |x: &&f64| x.abs() > ON_FACE * self.wave.amax();
        let sign = self.wave.iter().find(is_there).map_or(1.0, |x| x.signum());
        // Adding zero turns -0 into 0.
        self.wave.map(|x| sign * x + 0.0)
    }
}

/// Returns the slower mode. Ties are broken by the longer wave, then by the larger first component of the wave vector.
pub(super) fn slower<const D: usize>(a: WeakestMode<D>, b: WeakestMode<D>) -> WeakestMode<D> {
    let [ratio, other_ratio] = [a, b].each(|mode| mode.relative_frequency_squared);
    let [relative, absolute] = AS_SLOW;
    let apart = relative * ratio.abs().max(other_ratio.abs()) + absolute;
    let is_slower = match other_ratio - ratio {
        difference if difference.abs() > apart => difference > 0.0,
        _ => is_first(&a.wave_vector, &b.wave_vector).is_ge(),
    };
    if is_slower { a } else { b }
}

/// Order of wave vectors: shorter ones are greater, then those with a larger first component.
pub(crate) fn is_first<const D: usize>(a: &SVector<f64, D>, b: &SVector<f64, D>) -> Ordering {
    let [long, other] = [a, b].each(|k| k.norm());
    match (long - other).abs() > TIED * long.max(other) {
        true => other.total_cmp(&long),
        false => is_ahead(a, b),
    }
}

/// Which one of two wave vectors is farther along the first axis along which they differ.
fn is_ahead<const D: usize>(a: &SVector<f64, D>, b: &SVector<f64, D>) -> Ordering {
    let rounding = TIED * a.amax().max(b.amax());
    let mut apart = a.iter().zip(b).filter(|(a, b)| (*a - *b).abs() > rounding);
    apart
        .next()
        .map_or(Ordering::Equal, |(a, b)| a.total_cmp(b))
}

impl<'a, const D: usize> Unfolding<'a, D> {
    /// Of the linearized system of a discretization and a material at rest.
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

    /// The mode of a wave vector that is slowest beside the material.
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

    /// Displacements of the modes of equal frequency that a branch belongs to.
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
        let is_as_long = |other: &SVector<f64, D>| other.norm() <= k.norm() * (1.0 + ON_FACE);
        let images = images.filter(is_as_long).chain([*k]);
        let both = images.flat_map(|image| [image, -image]);
        both.max_by(is_ahead).unwrap_or(*k)
    }

    /// The same of a cell with several particles: of the waves `k + G` that as many particles can have, modes are the longest one of which they have at
    /// least half as much as of any. Modes of equal frequency are asked together, as what an eigenvalue problem makes of them is left to chance.
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
            // All others are faster, too fast to be slower beside the material.
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
            let is_as_long = |n: &&usize| (k + images[**n]).norm() <= wave.norm() * (1.0 + ON_FACE);
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

    /// Largest difference of equal squared frequencies, relative to the largest.
    fn degenerate(&self) -> f64 {
        DEGENERATE[usize::from(!self.system.is_hermitian())]
    }

    /// Which modes have equal frequencies, with the largest squared one. They are sorted by it.
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

    /// The branches that are asked: all where forces have an energy. Elsewhere each mode takes as long as all values, and of large cells the lowest ones are
    /// asked, and the lowest one above the longest waves.
    fn branches(&self, k: &SVector<f64, D>, largest: f64) -> Vec<usize> {
        let (most, share) = LOWEST;
        let size = self.system.size();
        if self.system.is_hermitian() || size <= most {
            return (0..size).collect();
        }
        let values = self.system.omega_squared(k);
        let is_asked = |n: usize| [0, D].contains(&n) || n < most && values[n].re < share * largest;
        // Modes of equal frequency are taken together.
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

    /// Which of some waves modes of equal frequency are.
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
        let is_held = |n: &usize| shares[*n] >= HELD * most;
        (0..images.len()).filter(is_held).collect()
    }

    fn is_long(&self, k: &SVector<f64, D>) -> bool {
        self.zone.lattice().fractional(k).amax() < LONG
    }

    /// The reciprocal vectors that lead from a wave vector to the waves that particles so far apart can have, those to the longest waves first: the zone of
    /// a lattice with a nearest distance `h` lies within `pi sqrt(D) / h`, that of squares and cubes with its corners.
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
        images.retain(|g| (k + g).norm() <= shortest * (1.0 + ON_FACE) || g.norm() == 0.0);
        // Of those as long the one that is farther along the first axis comes first.
        let rounded = |x: f64| (x / (ROUNDED * shortest)).round() as i64;
        images.sort_by_key(|g| {
            let wave = k + g;
            let ahead: [i64; D] = array_of(|i| -rounded(wave[i]));
            (rounded(wave.norm()), ahead)
        });
        images
    }

    /// The squared frequency of the material's slowest wave; zero where it has no energy, as the shear waves of a fluid.
    fn material(&self, k: &SVector<f64, D>) -> f64 {
        let values = continuum(&self.stiffness, self.density, k);
        let is_resisted = values[0] > WITHOUT_ENERGY * values[D - 1];
        if is_resisted { values[0] } else { 0.0 }
    }

    /// That of the longest wave of a wave vector in the zone. On the boundary there are several with the same length: the fastest of them is taken, for which the
    /// ratio is least.
    fn longest(&self, k: &SVector<f64, D>) -> f64 {
        let on_face = |g: &&SVector<f64, D>| k.dot(g) >= (0.5 - ON_FACE) * g.norm_squared();
        let images = self.zone.bounding_vectors().iter().filter(on_face);
        images
            .map(|g| self.material(&(k - g)))
            .fold(self.material(k), f64::max)
    }
}

/// The squared frequencies of the continuum at a wave vector, in increasing order; 1/time^2.
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

/// The displacements of the particles of a cell in a mode.
pub(crate) type Displacements<const D: usize> = Vec<SVector<Complex, D>>;

/// Those of the particles, of the components of all of them.
fn per_particle<const D: usize>(displacements: &DVector<Complex>) -> Displacements<D> {
    (0..displacements.len() / D)
        .map(|particle| SVector::from_fn(|i, _| displacements[D * particle + i]))
        .collect()
}

/// Takes translations from modes of a cell, which are long waves; whether something is left.
fn without_translations<const D: usize>(modes: &mut [Displacements<D>]) -> bool {
    let size = |mode: &Displacements<D>| -> f64 { mode.iter().map(|own| own.norm_squared()).sum() };
    let mut rest = 0.0;
    for mode in modes {
        let whole = size(mode);
        let mean = mode.iter().sum::<SVector<Complex, D>>() / Complex::from(mode.len() as f64);
        mode.iter_mut().for_each(|own| *own -= mean);
        rest += size(mode) / whole;
    }
    rest >= REST
}

/// A squared frequency over that of the material, where that has one.
fn over(found: f64, exact: f64) -> f64 {
    match exact > 0.0 {
        true => found / exact,
        false => f64::INFINITY,
    }
}

/// The reciprocal vectors of the faces: half of each is nearer to zero than to any other reciprocal vector.
fn faces_of<const D: usize>(zone: &BrillouinZone<D>) -> Vec<SVector<f64, D>> {
    let all = zone.bounding_vectors();
    let is_face = |g: &&SVector<f64, D>| {
        let mut others = all.iter().filter(|other| *other != *g);
        others.all(|other| 0.5 * g.dot(other) < (0.5 - ON_FACE) * other.norm_squared())
    };
    all.iter().filter(is_face).copied().collect()
}
