//! Lattices with several particles in a cell.

use super::{
    Ball, BravaisLattice, Fractional, LatticeError, LatticeKind, Reduced, voronoi_volumes,
};
use crate::algebra::{Each, array_of, uniform};
use nalgebra::{SMatrix, SVector};

/// A particle of a crystal: which of its cell, and which cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Particle<const D: usize> {
    /// The number of its site, in the order of [`Crystal::sites`].
    pub site: usize,
    /// Lattice coordinates of its cell.
    pub cell: [i32; D],
}

impl<const D: usize> Particle<D> {
    /// The particle of a site in the cell at the origin.
    pub fn home(site: usize) -> Self {
        Self { site, cell: [0; D] }
    }

    /// The same particle some cells further on.
    #[must_use]
    pub fn moved(&self, cells: &[i32; D]) -> Self {
        Self {
            site: self.site,
            cell: array_of(|i| self.cell[i] + cells[i]),
        }
    }
}

/// A Bravais lattice with a basis: particles at `X = sum_i (n_i + place_i) a_i`, each with its volume.
///
/// ```
/// use onset::lattice::{LatticeKind, Crystal};
/// let honeycomb = Crystal::<2>::of(LatticeKind::Honeycomb, 1.0)?;
/// assert_eq!(honeycomb.sites().len(), 2);
/// assert!((honeycomb.volumes()[0] - 0.75 * 3.0_f64.sqrt()).abs() < 1e-12);
/// # Ok::<(), onset::lattice::LatticeError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Crystal<const D: usize> {
    lattice: BravaisLattice<D>,
    sites: Vec<Fractional<D>>,
    volumes: Vec<f64>,
    spacing: f64,
}

impl<const D: usize> Crystal<D> {
    /// A lattice with particles at places given in lattice coordinates. Their volumes are those of their Voronoi cells, their
    /// spacing is that of the lattice with as many particles to the volume.
    ///
    /// # Errors
    /// [`LatticeError::CoincidentPoints`] when two particles are at the same place, [`LatticeError::NoSites`] when there is none.
    pub fn new(
        lattice: BravaisLattice<D>,
        sites: Vec<Fractional<D>>,
    ) -> Result<Self, LatticeError> {
        if sites.is_empty() {
            return Err(LatticeError::NoSites);
        }
        // The Voronoi cell of the only particle is a cell of the lattice.
        let volumes = match sites.len() {
            1 => vec![lattice.cell_volume()],
            _ => voronoi_volumes(&lattice, &sites)?,
        };
        Ok(Self {
            spacing: shortest(&lattice) * per_particle::<D>(sites.len()),
            lattice,
            sites,
            volumes,
        })
    }

    /// A lattice with particles of given volumes (length^D) at places given in lattice coordinates.
    ///
    /// # Errors
    /// [`LatticeError::NoSites`] when there is none, or not as many volumes as places.
    pub fn with_volumes(
        lattice: BravaisLattice<D>,
        sites: Vec<Fractional<D>>,
        volumes: Vec<f64>,
    ) -> Result<Self, LatticeError> {
        if sites.is_empty() || sites.len() != volumes.len() {
            return Err(LatticeError::NoSites);
        }
        Ok(Self {
            spacing: shortest(&lattice) * per_particle::<D>(sites.len()),
            lattice,
            sites,
            volumes,
        })
    }

    /// A lattice without parameters, with the given distance between nearest particles.
    ///
    /// # Errors
    /// [`LatticeError`] as for [`LatticeKind::lattice`].
    pub fn of(kind: LatticeKind, spacing: f64) -> Result<Self, LatticeError> {
        let crystal = Self::new(kind.lattice(spacing)?, kind.sites())?;
        Ok(crystal.with_spacing(spacing))
    }

    /// The particles of a kind of lattice on its Bravais lattice, or others in their place. The spacing is the distance of nearest neighbors in the
    /// lattice, scaled with the volume of a particle where others take the place of its own.
    ///
    /// # Errors
    /// [`LatticeError`] as for [`Crystal::new`].
    pub fn arranged(
        kind: LatticeKind,
        lattice: BravaisLattice<D>,
        others: Option<Vec<Fractional<D>>>,
    ) -> Result<Self, LatticeError> {
        let own = Self::new(lattice, kind.sites())?;
        let spacing = match own.sites.len() {
            1 => own.spacing,
            _ => own.nearest_distance(),
        };
        let Some(others) = others else {
            return Ok(own.with_spacing(spacing));
        };
        let crystal = Self::new(lattice, others)?;
        // Of particles that are a regular lattice themselves the spacing follows from them, whichever cell they are given in.
        let primitive = crystal.primitive().unwrap_or_else(|| crystal.clone());
        let natural = primitive.natural_spacing();
        let spacing = natural.unwrap_or_else(|| match own.sites.len() {
            1 => primitive.mean_spacing(),
            sites => spacing * per_particle::<D>(crystal.sites.len()) / per_particle::<D>(sites),
        });
        Ok(crystal.with_spacing(spacing))
    }

    /// One particle in each cell of a lattice.
    pub fn of_lattice(lattice: BravaisLattice<D>) -> Self {
        Self {
            spacing: shortest(&lattice),
            sites: vec![SVector::zeros()],
            volumes: vec![lattice.cell_volume()],
            lattice,
        }
    }

    /// The same particles with another length as their spacing.
    #[must_use]
    pub fn with_spacing(self, spacing: f64) -> Self {
        Self { spacing, ..self }
    }

    /// The lattice of the cells.
    pub fn lattice(&self) -> &BravaisLattice<D> {
        &self.lattice
    }

    /// The places of the particles of a cell, in lattice coordinates.
    pub fn sites(&self) -> &[Fractional<D>] {
        &self.sites
    }

    /// The volumes of the particles of a cell; length^D.
    pub fn volumes(&self) -> &[f64] {
        &self.volumes
    }

    /// The particle spacing, in which horizons, wavelengths and time steps are measured; length.
    ///
    /// Of a Bravais lattice, of a lattice with a name, and of particles that all have more nearest neighbors than there are dimensions, the distance
    /// of nearest neighbors, whichever cell describes them. Of other particles in the cell of a lattice the
    /// length that this would be if they were a lattice of the same shape: the distance of nearest neighbors times `n^(-1/D)` with `n`
    /// particles in the primitive cell, on square and cubic lattices the `D`-th root of the volume of a particle. Particles that are moved
    /// keep that of the layout that they are moved from, which the distance of the nearest of them is not.
    ///
    /// ```
    /// use onset::lattice::{LatticeKind, Crystal};
    /// let square = Crystal::of_lattice(LatticeKind::Square.lattice::<2>(0.5)?).supercell([4, 4])?;
    /// let disordered = square.perturbed(0.1, 1)?;
    /// assert_eq!(disordered.spacing(), 0.5);
    /// assert!(disordered.nearest_distance() < 0.45);
    /// # Ok::<(), onset::lattice::LatticeError>(())
    /// ```
    pub fn spacing(&self) -> f64 {
        self.spacing
    }

    /// The place of a particle in lattice coordinates.
    pub fn place(&self, particle: &Particle<D>) -> Fractional<D> {
        self.sites[particle.site] + SVector::from(particle.cell.map(f64::from))
    }

    /// The position of a particle; length.
    pub fn position(&self, particle: &Particle<D>) -> SVector<f64, D> {
        self.lattice.vectors() * self.place(particle)
    }

    /// The particles within a distance of a point (given in lattice coordinates), the distance being measured as
    /// `|metric x|` of the vector `x` from the point to the particle in the reference state; nearest first. None where the
    /// metric leaves no lattice.
    ///
    /// The rim does not count: a particle at the distance itself is left out.
    pub fn within(
        &self,
        point: &Fractional<D>,
        distance: f64,
        metric: &SMatrix<f64, D, D>,
    ) -> Vec<Particle<D>> {
        let ball = self.ball(distance, metric);
        ball.map_or_else(
            |_| Vec::new(),
            |ball| self.within_ball(point, distance, metric, &ball),
        )
    }

    /// A ball of a radius, for distances measured as `|metric x|`.
    ///
    /// # Errors
    /// [`LatticeError`] where the metric leaves no lattice, or one that double precision does not tell.
    pub(crate) fn ball(
        &self,
        radius: f64,
        metric: &SMatrix<f64, D, D>,
    ) -> Result<Ball<D>, LatticeError> {
        Ball::new(&(metric * self.lattice.vectors()), radius)
    }

    /// The particles in a ball about a point, as [`Crystal::within`].
    pub(crate) fn within_ball(
        &self,
        point: &Fractional<D>,
        distance: f64,
        metric: &SMatrix<f64, D, D>,
        ball: &Ball<D>,
    ) -> Vec<Particle<D>> {
        let map = metric * self.lattice.vectors();
        let mut found = Vec::new();
        for (site, place) in self.sites.iter().enumerate() {
            for cell in ball.cells(&(point - place)) {
                let particle = Particle { site, cell };
                let apart = (map * (self.place(&particle) - point)).norm();
                if apart < distance * (1.0 - 1e-12) {
                    found.push((apart, particle));
                }
            }
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found.into_iter().map(|(_, particle)| particle).collect()
    }

    /// The distance of the nearest pair of particles; length.
    pub fn nearest_distance(&self) -> f64 {
        let short =
            Reduced::of(self.lattice.vectors()).map_or(*self.lattice.vectors(), |r| r.vectors);
        let longest = short.column_iter().map(|a| a.norm());
        let distance = 1.001 * longest.fold(0.0, f64::max);
        let of_site = |place: &Fractional<D>| {
            let near = self.within(place, distance, &SMatrix::identity());
            let second = near.get(1).map(|particle| self.place(particle) - place);
            second.map_or(distance, |apart| (self.lattice.vectors() * apart).norm())
        };
        self.sites.iter().map(of_site).fold(f64::INFINITY, f64::min)
    }

    /// The same lattice with a cell that holds `counts` cells along each primitive vector.
    ///
    /// # Errors
    /// [`LatticeError::NoSites`] when a count is zero.
    pub fn supercell(&self, counts: [usize; D]) -> Result<Self, LatticeError> {
        if counts.contains(&0) {
            return Err(LatticeError::NoSites);
        }
        let vectors = SMatrix::from_fn(|i, j| self.lattice.vectors()[(i, j)] * counts[j] as f64);
        let lattice = BravaisLattice::new(vectors).ok_or(LatticeError::NoSites)?;
        let high = counts.each(|count| count as i32 - 1);
        let (mut sites, mut volumes) = (Vec::new(), Vec::new());
        for cell in cells_between(&[0; D], &high) {
            for (place, volume) in self.sites.iter().zip(&self.volumes) {
                let moved = place + SVector::from(cell.map(f64::from));
                sites.push(SVector::from_fn(|i, _| moved[i] / counts[i] as f64));
                volumes.push(*volume);
            }
        }
        Ok(Self {
            lattice,
            sites,
            volumes,
            spacing: self.spacing,
        })
    }

    /// The same lattice with every particle of a cell moved at random: each Cartesian component by a number between
    /// `-amplitude` and `amplitude` (a length), the same numbers for the same seed on every machine. Volumes are those of the
    /// new Voronoi cells.
    ///
    /// # Errors
    /// [`LatticeError::CoincidentPoints`] when two particles meet.
    pub fn perturbed(&self, amplitude: f64, seed: u64) -> Result<Self, LatticeError> {
        let mut state = seed;
        let to_fractional = self.lattice.reciprocal().transpose() / std::f64::consts::TAU;
        let sites = self.sites.iter().map(|place| {
            let offset = SVector::from_fn(|_, _| amplitude * (2.0 * uniform(&mut state) - 1.0));
            place + to_fractional * offset
        });
        let moved = Self::new(self.lattice, sites.collect())?;
        Ok(moved.with_spacing(self.spacing))
    }
}

/// The length of the shortest vector of a lattice.
pub(super) fn shortest<const D: usize>(lattice: &BravaisLattice<D>) -> f64 {
    let short = Reduced::of(lattice.vectors()).map_or(*lattice.vectors(), |basis| basis.vectors);
    let lengths = short.column_iter().map(|vector| vector.norm());
    lengths.fold(f64::INFINITY, f64::min)
}

/// By how much shorter lengths are when a cell is shared by particles: `n^(-1/D)`.
pub(super) fn per_particle<const D: usize>(particles: usize) -> f64 {
    (particles as f64).powf(-1.0 / D as f64)
}

/// All cells between two corners, both included.
pub(crate) fn cells_between<const D: usize>(low: &[i32; D], high: &[i32; D]) -> Vec<[i32; D]> {
    let mut count = 1_usize;
    for i in 0..D {
        count = count.saturating_mul((i64::from(high[i]) - i64::from(low[i]) + 1).max(1) as usize);
    }
    let mut cells = Vec::with_capacity(count);
    let mut cell = *low;
    loop {
        cells.push(cell);
        let Some(axis) = (0..D).find(|&i| cell[i] < high[i]) else {
            return cells;
        };
        cell[..axis].copy_from_slice(&low[..axis]);
        cell[axis] += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::{Crystal, Particle};
    use crate::lattice::LatticeKind;
    use nalgebra::SMatrix;

    #[test]
    fn every_particle_of_the_honeycomb_has_three_nearest_neighbors_and_six_next_ones() {
        let honeycomb = Crystal::<2>::of(LatticeKind::Honeycomb, 1.3).expect("a crystal");
        assert!((honeycomb.nearest_distance() - 1.3).abs() < 1e-12);
        for place in honeycomb.sites() {
            let within = |d: f64| honeycomb.within(place, d, &SMatrix::identity()).len();
            assert_eq!((within(1.31), within(1.3 * 1.74)), (4, 10));
        }
    }

    #[test]
    fn a_supercell_is_the_same_lattice() {
        let square = LatticeKind::Square.lattice::<2>(1.0).expect("a lattice");
        let crystal = Crystal::of_lattice(square);
        let large = crystal.supercell([3, 2]).expect("a crystal");
        assert_eq!(large.sites().len(), 6);
        assert!((large.volumes().iter().sum::<f64>() - 6.0).abs() < 1e-14);
        for place in large.sites() {
            let near = large.within(place, 2.1, &SMatrix::identity());
            assert_eq!(near.len(), 13);
            assert!((large.place(&near[0]) - place).amax() < 1e-14);
        }
    }

    #[test]
    fn a_seed_always_gives_the_same_offsets_within_the_amplitude() {
        let square = LatticeKind::Square.lattice::<2>(1.0).expect("a lattice");
        let crystal = Crystal::of_lattice(square)
            .supercell([4, 4])
            .expect("a crystal");
        let moved = |seed: u64| crystal.perturbed(0.2, seed).expect("a crystal");
        assert_eq!(moved(7), moved(7));
        assert_ne!(moved(7), moved(8));
        let moved = moved(7);
        assert!((moved.volumes().iter().sum::<f64>() - 16.0).abs() < 1e-10);
        for site in 0..16 {
            let particle = Particle::home(site);
            let offset = moved.position(&particle) - crystal.position(&particle);
            assert!(offset.amax() <= 0.2 && offset.amax() > 0.0);
        }
    }
}
