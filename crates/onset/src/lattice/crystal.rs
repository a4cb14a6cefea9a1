//! Lattices with several particles in a cell.

use super::{
    Ball, BravaisLattice, Fractional, LatticeError, LatticeKind, Reduced, voronoi_volumes,
};
use crate::algebra::{Each, array_of, uniform};
use nalgebra::{SMatrix, SVector};

/// Particle of a crystal, given by its site and its cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Particle<const D: usize> {
    /// Index of the site, in the order of [`Crystal::sites`].
    pub site: usize,
    /// Lattice coordinates of the cell.
    pub cell: [i32; D],
}

impl<const D: usize> Particle<D> {
    /// Particle of a site in the cell at the origin.
    pub fn home(site: usize) -> Self {
        Self { site, cell: [0; D] }
    }

    /// Translates the particle by a number of cells.
    #[must_use]
    pub fn moved(&self, cells: &[i32; D]) -> Self {
        Self {
            site: self.site,
            cell: array_of(|i| self.cell[i] + cells[i]),
        }
    }
}

/// Bravais lattice with a basis: particles at `X = sum_i (n_i + place_i) a_i`, each with its volume.
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
    /// True for the particles of one cell alone, without the cells around it.
    is_block: bool,
}

impl<const D: usize> Crystal<D> {
    /// Creates a lattice with particles at positions given in lattice coordinates.
    ///
    /// Volumes are the volumes of the Voronoi cells. The spacing is the spacing of the lattice with equal volume per particle.
    ///
    /// # Errors
    /// [`LatticeError::CoincidentPoints`] if two particles coincide, [`LatticeError::NoSites`] if no position is given.
    pub fn new(
        lattice: BravaisLattice<D>,
        sites: Vec<Fractional<D>>,
    ) -> Result<Self, LatticeError> {
        if sites.is_empty() {
            return Err(LatticeError::NoSites);
        }
        // The Voronoi cell of a single particle has the volume of the cell of the lattice.
        let volumes = match sites.len() {
            1 => vec![lattice.cell_volume()],
            _ => voronoi_volumes(&lattice, &sites)?,
        };
        Ok(Self {
            spacing: shortest(&lattice) * per_particle::<D>(sites.len()),
            lattice,
            sites,
            volumes,
            is_block: false,
        })
    }

    /// Creates a lattice with particles of given volumes (length^D) at positions given in lattice coordinates.
    ///
    /// # Errors
    /// [`LatticeError::NoSites`] if no position is given, or if the numbers of volumes and positions differ.
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
            is_block: false,
        })
    }

    /// Creates a lattice without parameters, with the given distance of nearest neighbors.
    ///
    /// # Errors
    /// [`LatticeError`] under the conditions of [`LatticeKind::lattice`].
    pub fn of(kind: LatticeKind, spacing: f64) -> Result<Self, LatticeError> {
        let crystal = Self::new(kind.lattice(spacing)?, kind.sites())?;
        Ok(crystal.with_spacing(spacing))
    }

    /// Creates the crystal of a kind on its Bravais lattice. `others`, in lattice coordinates, replace the standard particles of the cell.
    ///
    /// The spacing is the distance of nearest neighbors. With `others` it is the spacing of the lattice that the particles form, if they form one,
    /// and otherwise a value scaled by the volume per particle.
    ///
    /// # Errors
    /// [`LatticeError`] under the conditions of [`Crystal::new`].
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
        // If the particles form a regular lattice themselves, the spacing follows from them, independent of their cell.
        let primitive = crystal.primitive().unwrap_or_else(|| crystal.clone());
        let natural = primitive.natural_spacing();
        let spacing = natural.unwrap_or_else(|| match own.sites.len() {
            1 => primitive.mean_spacing(),
            sites => spacing * per_particle::<D>(crystal.sites.len()) / per_particle::<D>(sites),
        });
        Ok(crystal.with_spacing(spacing))
    }

    /// Creates a crystal with one particle in each cell of a lattice.
    pub fn of_lattice(lattice: BravaisLattice<D>) -> Self {
        Self {
            spacing: shortest(&lattice),
            sites: vec![SVector::zeros()],
            volumes: vec![lattice.cell_volume()],
            lattice,
            is_block: false,
        }
    }

    /// Replaces the particle spacing; the particles remain unchanged.
    #[must_use]
    pub fn with_spacing(self, spacing: f64) -> Self {
        Self { spacing, ..self }
    }

    /// Lattice of the cells.
    pub fn lattice(&self) -> &BravaisLattice<D> {
        &self.lattice
    }

    /// Positions of the particles of a cell, in lattice coordinates.
    pub fn sites(&self) -> &[Fractional<D>] {
        &self.sites
    }

    /// Volumes of the particles of a cell; length^D.
    pub fn volumes(&self) -> &[f64] {
        &self.volumes
    }

    /// Particle spacing, the unit of horizons, wavelengths and time steps; length.
    ///
    /// It is the distance of nearest neighbors for a Bravais lattice, for a named lattice, and for particles that all have more nearest neighbors
    /// than dimensions, for any choice of the cell. For other particles in the cell of a lattice it is the distance for a lattice of the same shape:
    /// the distance of nearest neighbors times `n^(-1/D)` with `n` particles in the primitive cell. On square and cubic lattices this is the `D`-th
    /// root of the volume of a particle. Displaced particles keep the spacing of their original layout, which differs from the distance of their
    /// nearest neighbors.
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

    /// Position of a particle in lattice coordinates.
    pub fn place(&self, particle: &Particle<D>) -> Fractional<D> {
        self.sites[particle.site] + SVector::from(particle.cell.map(f64::from))
    }

    /// Position of a particle; length.
    pub fn position(&self, particle: &Particle<D>) -> SVector<f64, D> {
        self.lattice.vectors() * self.place(particle)
    }

    /// Particles within a distance of a point (given in lattice coordinates), nearest first.
    ///
    /// The distance is `|metric x|` for the vector `x` from the point to the particle in the reference state. Particles exactly at the distance are
    /// excluded. The result is empty if the metric maps the lattice to a degenerate one.
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

    /// Ball of a given radius, for distances measured as `|metric x|`.
    ///
    /// # Errors
    /// [`LatticeError`] if the image of the lattice under the metric is degenerate, or not resolved in double precision.
    pub(crate) fn ball(
        &self,
        radius: f64,
        metric: &SMatrix<f64, D, D>,
    ) -> Result<Ball<D>, LatticeError> {
        Ball::new(&(metric * self.lattice.vectors()), radius)
    }

    /// Particles in a ball about a point, as for [`Crystal::within`].
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
            let mut check = |cell| {
                let particle = Particle { site, cell };
                let apart = (map * (self.place(&particle) - point)).norm();
                if apart < distance * (1.0 - 1e-12) {
                    found.push((apart, particle));
                }
            };
            match self.is_block {
                true => check([0; D]),
                false => ball.cells(&(point - place)).into_iter().for_each(check),
            }
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found.into_iter().map(|(_, particle)| particle).collect()
    }

    /// Distance of the nearest pair of particles; length.
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

    /// Describes the lattice by a cell with `counts` cells along each primitive vector.
    ///
    /// # Errors
    /// [`LatticeError::NoSites`] if a count is zero.
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
            is_block: false,
        })
    }

    /// Cuts a free block out of the lattice, with `counts` cells along each vector of the canonical basis, which begins at an origin as in
    /// [`reduced`](Self::reduced). [`within`](Self::within) returns only its particles, whose volumes remain as in the lattice.
    ///
    /// # Errors
    /// [`LatticeError::NoSites`] if a count is zero.
    pub(crate) fn block(
        &self,
        counts: [usize; D],
        origin: &Fractional<D>,
    ) -> Result<Self, LatticeError> {
        let block = self.reduced(origin)?.supercell(counts)?;
        Ok(block.isolated())
    }

    /// Restricts the lattice to the particles of one cell: [`within`](Self::within) returns only these.
    pub(crate) fn isolated(self) -> Self {
        Self {
            is_block: true,
            ..self
        }
    }

    /// Returns true if the particles of the cell have no neighbors in other cells.
    pub(crate) fn is_block(&self) -> bool {
        self.is_block
    }

    /// Displaces every particle of a cell at random; the volumes are recomputed from the new Voronoi cells.
    ///
    /// Each Cartesian component changes by a number between `-amplitude` and `amplitude` (a length). The same seed gives the same numbers on every
    /// machine.
    ///
    /// # Errors
    /// [`LatticeError::CoincidentPoints`] if two particles coincide.
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

/// Length of the shortest vector of a lattice.
pub(super) fn shortest<const D: usize>(lattice: &BravaisLattice<D>) -> f64 {
    let short = Reduced::of(lattice.vectors()).map_or(*lattice.vectors(), |basis| basis.vectors);
    let lengths = short.column_iter().map(|vector| vector.norm());
    lengths.fold(f64::INFINITY, f64::min)
}

/// Factor `n^(-1/D)` of lengths when a cell is shared by `n` particles.
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
    use nalgebra::{SMatrix, SVector};

    #[test]
    fn every_particle_of_the_honeycomb_has_three_nearest_and_six_second_neighbors() {
        let honeycomb = Crystal::<2>::of(LatticeKind::Honeycomb, 1.3).expect("a crystal");
        assert!((honeycomb.nearest_distance() - 1.3).abs() < 1e-12);
        for place in honeycomb.sites() {
            let within = |d: f64| honeycomb.within(place, d, &SMatrix::identity()).len();
            assert_eq!((within(1.31), within(1.3 * 1.74)), (4, 10));
        }
    }

    #[test]
    fn a_supercell_has_the_particles_of_its_lattice() {
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
    fn particles_of_a_block_have_no_neighbors_beyond_its_faces() {
        let square = LatticeKind::Square.lattice::<2>(1.0).expect("a lattice");
        let block = Crystal::of_lattice(square)
            .block([3, 3], &SVector::zeros())
            .expect("a crystal");
        let seen = |place| block.within(place, 1.1, &SMatrix::identity()).len();
        let mut seen: Vec<usize> = block.sites().iter().map(seen).collect();
        seen.sort_unstable();
        assert_eq!(seen, [3, 3, 3, 3, 4, 4, 4, 4, 5]);
        assert_eq!(
            Crystal {
                is_block: false,
                ..block
            },
            Crystal::of_lattice(square)
                .supercell([3, 3])
                .expect("a crystal")
        );
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
