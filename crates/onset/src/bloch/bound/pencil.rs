//! When no wave is softer than a number: a Hermitian matrix that is positive definite for all wave vectors.

use super::cell::{Cell, Chart};
use super::jet::{Jet, MatrixJet, parts};
use super::local::Local;
use super::sum::{Laplacian, PhaseSum};
use crate::algebra::{Complex, hermitian_eigen};
use crate::bloch::{BlochSum, DynamicalMatrix, Mass, WaveSystem};
use crate::lattice::{BravaisLattice, inverse_of};
use nalgebra::{DMatrix, SMatrix, SVector};

/// Sums that vanish, but for rounding, over the sizes of their terms.
const ZERO: f64 = 1e-9;

/// What is bounded from below.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::bloch) enum Measure {
    /// `omega^2 / (c^2 |k|_h^2)`, with this `c^2`.
    Scaled(f64),
    /// `omega^2`.
    Lowest,
    /// `-omega^2`.
    Highest,
}

impl Measure {
    /// The unit of the stiffness.
    fn unit(self) -> f64 {
        match self {
            Self::Scaled(speed_squared) => speed_squared,
            Self::Lowest => 1.0,
            Self::Highest => -1.0,
        }
    }
}

/// `P(k) - mu Q(k)`, positive definite where no measure is below `mu`.
///
/// For the scaled measure `P = K / c^2`, `Q = |k|_h^2 M`. Long waves are `k = t (b_a + sum_j s_j b_j)`: there both are told in a basis of
/// free displacements, which cost nothing at `k = 0` (translations among them), and others, with the free ones divided by `t`.
/// They are smooth up to `t = 0`, where the condition is that of the limit of long waves, relaxation included.
#[derive(Clone, Debug)]
pub(super) struct Pencil<const D: usize> {
    reciprocal: SMatrix<f64, D, D>,
    sites: usize,
    stiffness: PhaseSum<D>,
    /// The mass matrix, where it depends on the wave vector.
    mass: Option<PhaseSum<D>>,
    /// Of the scaled measure.
    laplacian: Option<Laplacian<D>>,
    basis: Basis,
}

/// Orthonormal bases, as columns, of free displacements and the others, in coordinates multiplied with the square roots of masses.
#[derive(Clone, Debug)]
struct Basis {
    /// All displacements, in the coordinates themselves, where that is `None`.
    free: Option<DMatrix<Complex>>,
    others: DMatrix<Complex>,
}

impl<const D: usize> Pencil<D> {
    /// Of the Hermitian part of a system, for a measure over a lattice; `None` where particles drift, or where a translation or a
    /// homogeneous strain makes forces, so that the measure has no limit of long waves.
    pub(super) fn of_system(
        system: &WaveSystem<D>,
        measure: Measure,
        lattice: &BravaisLattice<D>,
    ) -> Option<Self> {
        if system.drift().is_some() {
            return None;
        }
        let masses = system.particle_masses();
        let own = |sum: &BlochSum<D>, unit: f64| {
            PhaseSum::of_system(sum, system.crystal(), &masses, unit)
        };
        let mass = match system.mass() {
            Mass::Lumped(_) => None,
            Mass::Consistent(sum) => Some(own(sum, 1.0)),
        };
        let stiffness = own(system.stiffness(), measure.unit());
        Self::new(stiffness, mass, &masses, measure, lattice)
    }

    /// Of the Hermitian part of a dynamical matrix that is periodic.
    pub(super) fn of_matrix(
        matrix: &DynamicalMatrix<D>,
        measure: Measure,
        lattice: &BravaisLattice<D>,
    ) -> Option<Self> {
        let stiffness = PhaseSum::of_matrix(matrix, measure.unit())?;
        Self::new(stiffness, None, &[1.0], measure, lattice)
    }

    fn new(
        stiffness: PhaseSum<D>,
        mass: Option<PhaseSum<D>>,
        masses: &[f64],
        measure: Measure,
        lattice: &BravaisLattice<D>,
    ) -> Option<Self> {
        if !masses.iter().all(|mass| mass.is_finite() && *mass > 0.0) {
            return None;
        }
        let (reciprocal, sites) = (lattice.reciprocal(), masses.len());
        let (basis, laplacian) = match measure {
            Measure::Scaled(_) => (
                Basis::at_rest(&stiffness, masses)?,
                Some(Laplacian(lattice.measured_along(reciprocal))),
            ),
            _ => (Basis::whole(D * sites), None),
        };
        Some(Self {
            reciprocal: *reciprocal,
            sites,
            basis,
            stiffness,
            mass,
            laplacian,
        })
    }

    pub(super) fn reciprocal(&self) -> &SMatrix<f64, D, D> {
        &self.reciprocal
    }

    /// Work for a box, in units of some 80 ns of one core: blocks that are summed up, entries, factorizations.
    pub(super) fn cost(&self) -> usize {
        let size = D * self.sites;
        let blocks = self.stiffness.len() + self.mass.as_ref().map_or(0, PhaseSum::len);
        let in_space = 60 + blocks / 2 + 4 * size * size + size * size * size;
        in_space * (D + 1) / 4
    }

    /// The limit of the measure for long waves along a direction.
    pub(super) fn limit_along(&self, direction: &SVector<f64, D>) -> f64 {
        self.value(direction, Cell::limit_along)
    }

    /// The measure at a wave vector.
    pub(super) fn at(&self, k: &SVector<f64, D>) -> f64 {
        self.value(k, Cell::point)
    }

    fn value(&self, k: &SVector<f64, D>, cell: impl Fn(&SVector<f64, D>) -> Cell<D>) -> f64 {
        let inverse = inverse_of(&self.reciprocal);
        let value = inverse.map(|inverse| self.on(&cell(&(inverse * k))).value());
        value
            .filter(|value| value.is_finite())
            .unwrap_or(f64::INFINITY)
    }

    /// Boxes that together are half of the zone, where so many can be looked at.
    pub(super) fn boxes(&self, most: usize) -> Vec<Cell<D>> {
        Cell::half_zone(self.laplacian.is_some(), most)
    }

    /// `P` and `Q` on a box.
    pub(super) fn on(&self, cell: &Cell<D>) -> Local<D> {
        match cell.chart {
            Chart::Zone => self.in_zone(cell),
            Chart::Cone(cone) => self.in_cone(cell, cone),
        }
    }

    fn in_zone(&self, cell: &Cell<D>) -> Local<D> {
        let n = D * self.sites;
        let mut bends = [0.0; D];
        let numerator = self.stiffness.in_zone(cell, &mut bends);
        let mut denominator = match &self.mass {
            Some(mass) => mass.in_zone(cell, &mut [0.0; D]),
            None => MatrixJet::identity(n),
        };
        if let Some(laplacian) = &self.laplacian {
            denominator = denominator.times(&laplacian.in_zone(cell), &cell.half);
        }
        Local {
            half: cell.half,
            free: n,
            rest: [[numerator.rest, 0.0], [denominator.rest, 0.0]],
            numerator: numerator.parts,
            denominator: denominator.parts,
            bends,
        }
    }

    /// In the basis of free displacements, over `t`, and others.
    fn in_cone(&self, cell: &Cell<D>, cone: usize) -> Local<D> {
        let mut bends = [0.0; D];
        let wanted = [self.basis.free.is_some(), self.basis.free.is_some(), true];
        let sums = self.stiffness.in_cone(cell, cone, wanted, &mut bends);
        let numerator = self.basis.seen([&sums[2], &sums[1], &sums[0]]);
        let mut denominator = match &self.mass {
            Some(mass) => {
                let wanted = [true, false, false];
                let [mass, ..] = mass.in_cone(cell, cone, wanted, &mut [0.0; D]);
                self.basis.seen([&mass; 3])
            }
            None => self.basis.identity(D * self.sites),
        };
        if let Some(laplacian) = &self.laplacian {
            denominator.multiply(&laplacian.in_cone(cell, cone), &cell.half);
        }
        Local {
            half: cell.half,
            free: numerator.free.parts[0].nrows(),
            rest: [numerator.rests(), denominator.rests()],
            numerator: numerator.joined(),
            denominator: denominator.joined(),
            bends,
        }
    }
}

impl Basis {
    fn whole(size: usize) -> Self {
        Self {
            free: None,
            others: DMatrix::zeros(size, 0),
        }
    }

    /// Of what costs nothing at `k = 0`; `None` unless translations do not, or where free displacements make forces on each other that
    /// are linear in the wave vector, so that the scaled measure has no limit.
    fn at_rest<const D: usize>(bonds: &PhaseSum<D>, masses: &[f64]) -> Option<Self> {
        let n = D * masses.len();
        let (sum, moments, [size, extent]) = bonds.moments();
        if !size.is_finite() {
            return None;
        }
        let eigen = hermitian_eigen(sum)?;
        let [mut free, mut others] = [Vec::new(), Vec::new()];
        for (value, vector) in eigen
            .eigenvalues
            .iter()
            .zip(eigen.eigenvectors.column_iter())
        {
            let own = if value.abs() <= ZERO * size {
                &mut free
            } else {
                &mut others
            };
            own.push(vector.into_owned());
        }
        let of = |columns: &[nalgebra::DVector<f64>]| {
            DMatrix::from_fn(n, columns.len(), |i, j| columns[j][i])
        };
        let (free, others) = (of(&free), of(&others));
        let total: f64 = masses.iter().sum();
        let translations = DMatrix::from_fn(n, D, |i, j| {
            if i % D == j {
                (masses[i / D] / total).sqrt()
            } else {
                0.0
            }
        });
        let are_free = (others.transpose() * translations).amax() <= 1e-6;
        let has_limit = moments
            .iter()
            .all(|moment| (free.transpose() * moment * &free).amax() <= ZERO * extent);
        let complex = |m: &DMatrix<f64>| m.map(|x| Complex::new(x, 0.0));
        (are_free && has_limit).then(|| Self {
            free: (others.ncols() > 0).then(|| complex(&free)),
            others: complex(&others),
        })
    }

    /// Sums between free displacements, between these and others, and between others.
    fn seen<const D: usize>(
        &self,
        [between_free, mixed, between_others]: [&MatrixJet<D>; 3],
    ) -> Blocks<D> {
        let others = &self.others;
        match &self.free {
            None => Blocks::of_free(between_free.clone()),
            Some(free) => Blocks {
                free: between_free.onto(free).onto_rows(free),
                mixed: mixed.onto(others).onto_rows(free),
                others: between_others.onto(others).onto_rows(others),
            },
        }
    }

    fn identity<const D: usize>(&self, size: usize) -> Blocks<D> {
        let others = self.others.ncols();
        Blocks {
            free: MatrixJet::identity(size - others),
            mixed: MatrixJet::zeros(size - others, others),
            others: MatrixJet::identity(others),
        }
    }
}

/// A Hermitian matrix in the basis of free displacements and others.
struct Blocks<const D: usize> {
    free: MatrixJet<D>,
    mixed: MatrixJet<D>,
    others: MatrixJet<D>,
}

impl<const D: usize> Blocks<D> {
    fn of_free(free: MatrixJet<D>) -> Self {
        let size = free.parts[0].nrows();
        Self {
            free,
            mixed: MatrixJet::zeros(size, 0),
            others: MatrixJet::zeros(0, 0),
        }
    }

    fn multiply(&mut self, factors: &[Jet<D>; 3], half: &[f64; D]) {
        self.free = self.free.times(&factors[0], half);
        if self.others.parts[0].nrows() > 0 {
            self.mixed = self.mixed.times(&factors[1], half);
            self.others = self.others.times(&factors[2], half);
        }
    }

    /// Bounds of what the polynomials leave out: with `|x y| <= (x^2 + y^2) / 2` for the mixed block.
    fn rests(&self) -> [f64; 2] {
        [
            self.free.rest + self.mixed.rest,
            self.others.rest + self.mixed.rest,
        ]
    }

    fn joined(&self) -> Vec<DMatrix<Complex>> {
        let (free, inner) = (self.free.parts[0].nrows(), self.others.parts[0].nrows());
        let joined = |n: usize| {
            let mut whole = DMatrix::zeros(free + inner, free + inner);
            whole
                .view_mut((0, 0), (free, free))
                .copy_from(&self.free.parts[n]);
            if inner > 0 {
                let mixed = &self.mixed.parts[n];
                whole.view_mut((0, free), (free, inner)).copy_from(mixed);
                whole
                    .view_mut((free, 0), (inner, free))
                    .copy_from(&mixed.adjoint());
                whole
                    .view_mut((free, free), (inner, inner))
                    .copy_from(&self.others.parts[n]);
            }
            whole
        };
        (0..parts::<D>()).map(joined).collect()
    }
}
