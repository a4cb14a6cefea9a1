//! Modes of a discretization at rest beside the plane waves of the material: which wave a mode is, and how much slower.

use super::WeakestMode;
use crate::algebra::Complex;
use crate::bloch::WaveSystem;
use crate::continuum::Stiffness;
use crate::kinematics::DeformationGradient;
use crate::lattice::{BrillouinZone, Particle};
use crate::material::Hyperelastic;
use crate::method::MethodError;
use crate::scheme::Discretization;
use nalgebra::{DMatrix, DVector, SVector};
use std::f64::consts::{PI, TAU};

/// Waves longer than this, in units of the reciprocal vectors, are as good as infinitely long.
const LONG: f64 = 1e-3;
/// A mode counts as a wave if it holds at least this part of what it holds most of.
const HELD: f64 = 0.5;
/// What a wave vector may be short of a face of the zone, relative to it, and be on it.
const ON_FACE: f64 = 1e-9;
/// Squared frequencies that differ by less, relative to each other, are the same.
const AS_SLOW: f64 = 1e-6;

/// The modes of a discretization at rest and the plane waves of the material.
pub(crate) struct BesideMaterial<'a, const D: usize> {
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

    /// The mode, of `k` and `-k` the one that points forward; `None` where nothing can be compared.
    pub(super) fn known(&self) -> Option<WeakestMode<D>> {
        let is_turned = |x: &&f64| x.abs() > ON_FACE * self.wave.amax();
        let sign = self.wave.iter().find(is_turned).map_or(1.0, |x| x.signum());
        self.ratio.is_finite().then_some(WeakestMode {
            wave_vector: self.wave * sign,
            relative_frequency_squared: self.ratio,
        })
    }
}

/// The slower one of two modes, if there are any; the first where they are as slow.
pub(super) fn slower<const D: usize>(
    one: Option<WeakestMode<D>>,
    other: Option<WeakestMode<D>>,
) -> Option<WeakestMode<D>> {
    let ratio = |mode: WeakestMode<D>| mode.relative_frequency_squared;
    match (one, other) {
        (Some(a), Some(b)) if ratio(b) >= ratio(a) - AS_SLOW * ratio(a).abs() => one,
        (_, Some(_)) => other,
        (_, None) => one,
    }
}

impl<'a, const D: usize> BesideMaterial<'a, D> {
    /// Those of the linearized system of a discretization and a material at rest.
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

    /// The mode of a wave vector that is slowest beside the material. Those of a cell with several particles are compared with the waves that they hold.
    pub(crate) fn slowest(&self, k: &SVector<f64, D>) -> Slowest<D> {
        let k = self.zone.folded(k);
        if self.positions.len() > 1 {
            return self.unfolded(&k);
        }
        match self.zone.lattice().fractional(&k).amax() < LONG {
            true => Slowest::none(k),
            false => Slowest {
                ratio: over(self.system.omega_squared(&k)[0].re, self.longest(&k)),
                branch: 0,
                wave: k,
                from_others: self.faces.clone(),
            },
        }
    }

    /// The same of a cell with several particles: of the waves `k + G` that as many particles can have, a mode is the longest one of which it has at
    /// least half as much as of any.
    fn unfolded(&self, k: &SVector<f64, D>) -> Slowest<D> {
        let images = self.images(k);
        let exact: Vec<f64> = images.iter().map(|g| self.material(&(k + g))).collect();
        let largest = exact.iter().copied().fold(0.0, f64::max);
        let branches: Vec<usize> = match self.system.is_hermitian() {
            true => (0..self.system.size()).collect(),
            // Each mode takes as long as all values: the lowest branch, and the lowest one above the longest waves.
            false => vec![0, D],
        };
        let modes = self.system.modes_of(k, |_| branches.clone());
        let mut slowest = Slowest::none(*k);
        for (branch, (value, displacements)) in branches.iter().zip(&modes) {
            // All others are faster, too fast to be slower beside the material.
            if value.re >= slowest.ratio * largest {
                break;
            }
            let held = self.held(&images, &per_particle(displacements));
            let [first, others @ ..] = &held[..] else {
                continue;
            };
            let wave = k + images[*first];
            let is_as_long = |n: &&usize| (k + images[**n]).norm() <= wave.norm() * (1.0 + ON_FACE);
            let fastest = held.iter().filter(is_as_long).map(|n| exact[*n]);
            let ratio = over(value.re, fastest.fold(0.0, f64::max));
            let is_long = self.zone.lattice().fractional(&wave).amax() < LONG;
            if ratio < slowest.ratio && !is_long {
                let apart = others.iter().map(|n| images[*first] - images[*n]);
                slowest = Slowest {
                    ratio,
                    branch: *branch,
                    wave,
                    from_others: apart.collect(),
                };
            }
        }
        slowest
    }

    /// Which of some waves a mode is.
    fn held(
        &self,
        images: &[SVector<f64, D>],
        displacements: &[SVector<Complex, D>],
    ) -> Vec<usize> {
        let share = |g: &SVector<f64, D>| -> f64 {
            let terms = self.positions.iter().zip(displacements);
            let held = terms.map(|(x, own)| own * Complex::from_polar(1.0, -g.dot(x)));
            held.sum::<SVector<Complex, D>>().norm_squared()
        };
        let shares: Vec<f64> = images.iter().map(share).collect();
        let most = shares.iter().copied().fold(0.0, f64::max);
        let is_held = |n: &usize| shares[*n] >= HELD * most;
        (0..images.len()).filter(is_held).collect()
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
        images.sort_by(|a, b| (k + a).norm().total_cmp(&(k + b).norm()));
        images
    }

    /// The squared frequency of the material's slowest wave.
    fn material(&self, k: &SVector<f64, D>) -> f64 {
        continuum(&self.stiffness, self.density, k)[0]
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

/// The displacements of the particles of a cell, of those of all of them.
pub(crate) fn per_particle<const D: usize>(
    displacements: &DVector<Complex>,
) -> Vec<SVector<Complex, D>> {
    (0..displacements.len() / D)
        .map(|particle| SVector::from_fn(|i, _| displacements[D * particle + i]))
        .collect()
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
