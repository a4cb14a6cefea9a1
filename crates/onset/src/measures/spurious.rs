//! Spurious modes of a discretization: zero-energy modes and weakly controlled ones.

use super::degenerate::{DEGENERATE, Displacements, most_symmetric};
use super::dispersion::continuum;
use super::zero_energy::{Extent, ZeroMode, ZeroModes};
use crate::algebra::{Complex, Each, is_well, settled, settled_along, sort_by_value};
use crate::bloch::WaveSystem;
use crate::continuum::Stiffness;
use crate::kinematics::DeformationGradient;
use crate::lattice::{BrillouinZone, Particle};
use crate::method::MethodError;
use crate::verdict::Survey;
use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use std::f64::consts::{PI, TAU};

/// Points of the grid of wave vectors along a reciprocal vector: halves, thirds, quarters and their parts are among them, but for the largest cells.
const GRID: [usize; 3] = [96, 24, 12];
/// The fewest of them with several particles in a cell.
const FEWEST: usize = 6;
/// Waves longer than this, in units of the reciprocal vectors, are as good as infinitely long.
const LONG: f64 = 1e-3;
/// A mode counts as a wave if it holds at least this part of what it holds most of.
const HELD: f64 = 0.5;
/// Wave vectors nearer than this, in units of the reciprocal vectors, are the same.
const SAME: f64 = 1e-4;
/// How many of the deepest wells are followed to their bottom, weak or not.
const DEEPEST: usize = 4;
/// Distance from a face, in steps of the grid, at which a descent may be stuck.
const STUCK: f64 = 0.1;
/// Faces that are told from each other there, at most.
const MOST_FACES: usize = 8;
/// What a wave vector may be short of a face of the zone, relative to it, and be on it.
const ON_FACE: f64 = 1e-9;

/// A spurious mode of the reference configuration: one with too little energy.
#[derive(Clone, Debug, PartialEq)]
pub struct SpuriousMode<const D: usize> {
    /// Its wave vector; 1/length.
    pub wave_vector: SVector<f64, D>,
    /// Its frequency over that of the slowest wave of the material with the same wave vector: zero for a zero-energy mode. With several
    /// particles in a cell the wave vector is known up to reciprocal vectors only, and the wave is taken that the mode holds most of.
    pub relative_frequency: f64,
    /// How many independent zero-energy modes there are at this wave vector, translations not counted: displacements that strain no
    /// point, whatever the law.
    pub nullity: usize,
    /// How far zero-energy modes extend from it; a single point for weakly controlled ones.
    pub extent: Extent,
    /// Displacement of each particle of the cell at the origin, of the mode with the lowest frequency. Where several have it, of one that is
    /// as symmetric as the wave vector: along it, if they hold such a wave.
    pub displacements: Vec<SVector<Complex, D>>,
}

impl<const D: usize> SpuriousMode<D> {
    /// Whether it is a zero-energy mode.
    pub fn is_zero(&self) -> bool {
        self.nullity > 0
    }
}

/// The spurious modes of a discretization.
#[derive(Clone, Debug, PartialEq)]
pub struct SpuriousModes<const D: usize> {
    /// Zero-energy modes first, single wave vectors before lines and surfaces; then the weakly controlled ones by their frequency. Of `k` and `-k`
    /// one, of a line or surface one.
    pub modes: Vec<SpuriousMode<D>>,
    /// How far zero-energy modes extend at most; `None` where there are none.
    pub zero_extent: Option<Extent>,
    /// Whether all zero-energy modes have been found: the whole zone has been searched. Not so for large cells that have too many wave
    /// vectors with little strain.
    pub is_complete: bool,
    /// The lowest relative frequency anywhere, long waves included: 0 with zero-energy modes, 1 where no wave is slower than the
    /// material's.
    pub weakest: f64,
}

/// All wave vectors with zero-energy modes, which depend on the discretization alone, and those at which the relative frequency has a
/// minimum below `threshold`; in the reference configuration, over the whole zone.
///
/// # Errors
/// [`MethodError`] when the material or the discretization cannot be evaluated.
pub fn spurious_modes<const D: usize>(
    survey: &Survey<'_, D>,
    threshold: f64,
) -> Result<SpuriousModes<D>, MethodError> {
    let crystal = survey.discretization().crystal();
    let zone = BrillouinZone::new(*crystal.lattice());
    let strain = survey.discretization().strain()?;
    let zero = ZeroModes::new(crystal, &strain, |k| zone.folded(k));
    let position = |site| crystal.position(&Particle::home(site));
    let weak = Weak {
        positions: (0..crystal.sites().len()).map(position).collect(),
        spacing: crystal.nearest_distance(),
        system: survey.reference()?,
        density: survey.discretization().density(),
        zone: &zone,
        faces: faces_of(&zone),
        stiffness: Stiffness::<D>::at(survey.material(), &DeformationGradient::identity())?,
    };
    let (weak_modes, slowest) = weak.modes(threshold, &zero);
    let mut modes: Vec<SpuriousMode<D>> = zero.modes.iter().map(|m| shown(m, &zone)).collect();
    let weakest = if modes.is_empty() {
        slowest.clamp(0.0, 1.0).sqrt()
    } else {
        0.0
    };
    modes.extend(weak_modes);
    Ok(SpuriousModes {
        modes,
        zero_extent: zero.extent(),
        is_complete: zero.is_complete,
        weakest,
    })
}

/// A zero-energy mode with a wave vector of the first zone.
fn shown<const D: usize>(mode: &ZeroMode<D>, zone: &BrillouinZone<D>) -> SpuriousMode<D> {
    SpuriousMode {
        wave_vector: zone.folded(&mode.wave_vector),
        relative_frequency: 0.0,
        nullity: mode.nullity,
        extent: mode.extent,
        displacements: most_symmetric(&mode.span, &zone.folded(&mode.wave_vector)),
    }
}

/// The search for weakly controlled modes.
struct Weak<'a, const D: usize> {
    /// The places of the particles of a cell; length.
    positions: Vec<SVector<f64, D>>,
    /// The distance of the nearest particles; length.
    spacing: f64,
    system: &'a WaveSystem<D>,
    density: f64,
    zone: &'a BrillouinZone<D>,
    /// The reciprocal vectors whose bisectors are faces of the zone, not only touch it.
    faces: Vec<SVector<f64, D>>,
    stiffness: Stiffness<D>,
}

/// The mode of a wave vector with the least ratio.
struct Least<const D: usize> {
    /// Its squared frequency over that of the material.
    ratio: f64,
    /// The number of its branch.
    branch: usize,
    /// Which wave of the material it is.
    wave: SVector<f64, D>,
    /// What leads to it from others that it is as well, and shorter: the normals of planes across which another one is the longest.
    from_others: Vec<SVector<f64, D>>,
}

impl<const D: usize> Least<D> {
    /// Where nothing is compared.
    fn none(wave: SVector<f64, D>) -> Self {
        Self {
            ratio: f64::INFINITY,
            branch: 0,
            wave,
            from_others: Vec::new(),
        }
    }
}

impl<const D: usize> Weak<'_, D> {
    /// The least ratio of a squared frequency to that of the material, and the number of its branch. The modes of a cell with several particles are
    /// compared with the waves of the material that they hold.
    fn least(&self, k: &SVector<f64, D>) -> Least<D> {
        let k = self.zone.folded(k);
        if self.positions.len() > 1 {
            return self.unfolded(&k);
        }
        match self.fractional(&k).amax() < LONG {
            true => Least::none(k),
            false => Least {
                ratio: over(self.system.omega_squared(&k)[0].re, self.longest(&k)),
                branch: 0,
                wave: k,
                from_others: self.faces.clone(),
            },
        }
    }

    /// The same of a cell with several particles: of the waves `k + G` that as many particles can have, a mode is the longest one of which it has at
    /// least half as much as of any.
    fn unfolded(&self, k: &SVector<f64, D>) -> Least<D> {
        let images = self.images(k);
        let exact: Vec<f64> = images.iter().map(|g| self.slowest(&(k + g))).collect();
        let largest = exact.iter().copied().fold(0.0, f64::max);
        let modes = self
            .system
            .modes_of(k, |values| match self.system.is_hermitian() {
                true => (0..values.len()).collect(),
                // Each mode takes as long as all values: the lowest branch, and the lowest one above the longest waves.
                false => vec![0, D],
            });
        let mut least = Least::none(*k);
        for (branch, (value, displacements)) in modes.iter().enumerate() {
            // All others are faster, too fast to be slower beside the material.
            if value.re >= least.ratio * largest {
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
            if ratio < least.ratio && self.fractional(&wave).amax() >= LONG {
                let branch = match self.system.is_hermitian() {
                    true => branch,
                    false => D * branch,
                };
                let apart = others.iter().map(|n| images[*first] - images[*n]);
                least = Least {
                    ratio,
                    branch,
                    wave,
                    from_others: apart.collect(),
                };
            }
        }
        least
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
    fn slowest(&self, k: &SVector<f64, D>) -> f64 {
        continuum(&self.stiffness, self.density, k)[0]
    }

    /// That of the longest wave of a wave vector in the zone. On the boundary there are several with the same length: the fastest of them is taken, for which the
    /// ratio is least.
    fn longest(&self, k: &SVector<f64, D>) -> f64 {
        let on_face = |g: &&SVector<f64, D>| k.dot(g) >= (0.5 - ON_FACE) * g.norm_squared();
        let images = self.zone.bounding_vectors().iter().filter(on_face);
        images
            .map(|g| self.slowest(&(k - g)))
            .fold(self.slowest(k), f64::max)
    }

    fn ratio(&self, k: &SVector<f64, D>) -> f64 {
        self.least(k).ratio
    }

    /// In units of the reciprocal vectors.
    fn fractional(&self, k: &SVector<f64, D>) -> SVector<f64, D> {
        self.zone.lattice().vectors().transpose() * k / TAU
    }

    /// The distance from the nearest reciprocal vector, in units of these.
    fn distance_to_zero(&self, k: &SVector<f64, D>) -> f64 {
        let fractional = self.fractional(k);
        (fractional - fractional.map(f64::round)).amax()
    }

    /// Points of the grid along a reciprocal vector, about as dense with several particles in a cell, whose zone is smaller.
    fn points(&self) -> usize {
        let mut points = GRID[D - 1];
        let mut sites = self.positions.len();
        while points > FEWEST && sites >= 1 << D {
            points /= 2;
            sites >>= D;
        }
        points
    }

    /// The weakly controlled modes, and the lowest ratio anywhere.
    fn modes(&self, threshold: f64, zero: &ZeroModes<D>) -> (Vec<SpuriousMode<D>>, f64) {
        let n = self.points();
        let reciprocal = self.zone.lattice().reciprocal();
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
            reciprocal * fractional
        };
        let values: Vec<f64> = (0..half)
            .map(|index| self.ratio(&wave_vector(index)))
            .collect();
        let steps = reciprocal / n as f64;
        let mut wells: Vec<usize> = (0..half)
            .filter(|index| is_well::<D>(&values, *index, n))
            .filter(|index| !self.is_zero(&wave_vector(*index), zero))
            .collect();
        sort_by_value(&mut wells, |n| values[*n]);
        let limit = threshold * threshold;
        let mut bottoms: Vec<(f64, SVector<f64, D>)> = wells
            .into_iter()
            .enumerate()
            .filter(|(order, index)| *order < DEEPEST || values[*index] < 1.5 * limit)
            .map(|(_, index)| self.bottom((values[index], wave_vector(index)), &steps))
            .collect();
        sort_by_value(&mut bottoms, |item| item.0);
        let lowest = values.iter().chain(bottoms.iter().map(|(ratio, _)| ratio));
        let lowest = lowest.copied().fold(f64::INFINITY, f64::min);

        let mut modes: Vec<SpuriousMode<D>> = Vec::new();
        for (ratio, k) in bottoms {
            let k = self.zone.folded(&k);
            let Least { branch, wave, .. } = self.least(&k);
            // A well at k = 0 is no wave: the stiffness of all long waves is too low.
            let is_long = self.fractional(&wave).amax() < 1.0 / n as f64;
            let is_known = || {
                modes
                    .iter()
                    .any(|known| self.is_same(&known.wave_vector, &k))
            };
            if ratio < limit && !is_long && !self.is_zero(&k, zero) && !is_known() {
                modes.push(self.mode(&k, ratio, branch));
            }
        }
        (modes, lowest)
    }

    /// The bottom of a well in the closed zone. The ratio has kinks where the shortest wave with a wave vector changes: on the faces of
    /// the zone, so that minima lie in it, on its faces, their edges, or at corners, and each of those is searched for itself.
    fn bottom(
        &self,
        start: (f64, SVector<f64, D>),
        steps: &SMatrix<f64, D, D>,
    ) -> (f64, SVector<f64, D>) {
        let at = |k: &SVector<f64, D>| self.ratio(k);
        let size = steps.column_iter().map(|step| step.norm());
        let size = size.fold(0.0, f64::max);
        let inside = settled(&at, start, steps);
        let least = self.least(&inside.1);
        let wave = least.wave;
        let distance = |g: &SVector<f64, D>| 0.5 * g.norm() - wave.dot(g) / g.norm();
        // A descent that is stuck at a kink is on it.
        let is_near = |g: &&SVector<f64, D>| distance(g) < STUCK * size;
        let near = least.from_others.iter().filter(is_near);
        let near: Vec<SVector<f64, D>> = near.take(MOST_FACES).copied().collect();
        let mut best = inside;
        for which in 1_usize..1 << near.len() {
            let chosen: Vec<SVector<f64, D>> = (0..near.len())
                .filter(|i| which >> i & 1 == 1)
                .map(|i| near[i])
                .collect();
            let Some((place, tangents)) = stratum(&wave, &chosen) else {
                continue;
            };
            let tangents: Vec<SVector<f64, D>> = tangents.iter().map(|t| t * size).collect();
            let found = settled_along(&at, (at(&place), place), &tangents);
            if found.0 < best.0 {
                best = found;
            }
        }
        best
    }

    fn mode(&self, k: &SVector<f64, D>, ratio: f64, branch: usize) -> SpuriousMode<D> {
        let modes = &self.system.modes(k)[branch..];
        let size = modes
            .iter()
            .map(|(value, _)| value.norm())
            .fold(0.0, f64::max);
        let first = modes.first().map_or(0.0, |(value, _)| value.re);
        let lowest: Vec<Displacements<D>> = modes
            .iter()
            .filter(|(value, _)| (value.re - first).abs() <= DEGENERATE * size)
            .map(|(_, displacements)| per_particle(displacements))
            .collect();
        SpuriousMode {
            wave_vector: *k,
            relative_frequency: ratio.max(0.0).sqrt(),
            nullity: 0,
            extent: Extent::Point,
            displacements: most_symmetric(&lowest, k),
        }
    }

    /// Whether a wave vector has a zero-energy mode.
    fn is_zero(&self, k: &SVector<f64, D>, zero: &ZeroModes<D>) -> bool {
        zero.has(&self.zone.folded(k), |other| {
            let either = [k - other, k + other];
            let distances = either.each(|way| self.distance_to_zero(&way));
            distances[0].min(distances[1])
        })
    }

    /// Whether two wave vectors are the same, or opposite, up to reciprocal vectors.
    fn is_same(&self, a: &SVector<f64, D>, b: &SVector<f64, D>) -> bool {
        self.distance_to_zero(&(a - b)) < SAME || self.distance_to_zero(&(a + b)) < SAME
    }
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

/// Where several faces of the zone meet, `k.G = |G|^2/2`: the point nearest to a wave vector, and unit tangents. `None` where one
/// of the faces is no further restriction.
fn stratum<const D: usize>(
    k: &SVector<f64, D>,
    faces: &[SVector<f64, D>],
) -> Option<(SVector<f64, D>, Vec<SVector<f64, D>>)> {
    if faces.len() > D {
        return None;
    }
    let normals = DMatrix::from_fn(faces.len(), D, |row, i| faces[row][i] / faces[row].norm());
    let short = DVector::from_fn(faces.len(), |row, _| {
        0.5 * faces[row].norm() - k.dot(&faces[row]) / faces[row].norm()
    });
    // Rows of zeros make the decomposition show the tangents too.
    let square = normals.clone().resize(D, D, 0.0);
    let svd = square.try_svd(true, true, f64::EPSILON, 1000)?;
    let right = svd.v_t.as_ref()?;
    let is_normal = |n: &usize| svd.singular_values[*n] > 1e-6;
    if (0..D).filter(is_normal).count() < faces.len() {
        return None;
    }
    let step = svd.solve(&short.resize_vertically(D, 0.0), 1e-6).ok()?;
    let place = k + SVector::from_fn(|i, _| step[i]);
    let tangents = (0..D)
        .filter(|n| !is_normal(n))
        .map(|n| SVector::from_fn(|i, _| right[(n, i)]));
    Some((place, tangents.collect()))
}

fn per_particle<const D: usize>(displacements: &DVector<Complex>) -> Vec<SVector<Complex, D>> {
    (0..displacements.len() / D)
        .map(|particle| SVector::from_fn(|i, _| displacements[D * particle + i]))
        .collect()
}
