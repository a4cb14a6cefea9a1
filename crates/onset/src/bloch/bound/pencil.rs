//! The matrix pencil `P - mu Q`, which is positive definite for all wave vectors if no wave is softer than `mu`.

use super::cell::{Cell, Chart};
use super::images::{Images, exchanges};
use super::jet::{Jet, MatrixJet, Parts, parts};
use super::local::Local;
use super::sum::{Laplacian, PhaseSum};
use crate::algebra::{Complex, hermitian_eigen};
use crate::bloch::{BlochSum, DynamicalMatrix, Mass, WaveSystem};
use crate::lattice::{BravaisLattice, Fractional, Symmetry};
use nalgebra::{DMatrix, DMatrixView, SMatrix, SVector};
use std::f64::consts::TAU;

/// Largest sum that vanishes except for rounding, relative to the magnitudes of its terms.
const VANISHING_SUM_RATIO: f64 = 1e-9;

/// Additional cost of a phase in a cone, in units of [`Pencil::cost`].
const CONE_COST: usize = 3;

/// Measure that is bounded from below.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::bloch) enum Measure {
    /// Scaled measure `omega^2 / (c^2 |k|_h^2)` with the given `c^2`.
    Scaled(f64),
    /// Squared frequency `omega^2` itself.
    Lowest,
    /// Minus the squared frequency, `-omega^2`.
    Highest,
}

impl Measure {
    /// Divisor of the stiffness for this measure.
    fn unit(self) -> f64 {
        match self {
            Self::Scaled(speed_squared) => speed_squared,
            Self::Lowest => 1.0,
            Self::Highest => -1.0,
        }
    }
}

/// The pencil `P(k) - mu Q(k)`, positive definite if no measure is below `mu`.
///
/// For the scaled measure, `P = K / c^2` and `Q = |k|_h^2 M`. Long waves are `k = t (b_a + sum_j s_j b_j)`. There, both are written in a basis of
/// free displacements, which cost no energy at `k = 0` (translations among them), and other displacements; the free displacements are divided by `t`.
/// Both matrices are then smooth up to `t = 0`, where the condition becomes the condition of the long-wave limit, including relaxation.
#[derive(Clone, Debug)]
pub(super) struct Pencil<const D: usize> {
    lattice: BravaisLattice<D>,
    /// Positions of the sites in lattice coordinates.
    places: Vec<Fractional<D>>,
    stiffness: PhaseSum<D>,
    /// Mass matrix, if it depends on the wave vector.
    mass: Option<PhaseSum<D>>,
    /// Lattice Laplacian of the scaled measure.
    laplacian: Option<Laplacian<D>>,
    basis: Basis,
}

/// Orthonormal bases, as columns, of free and of other displacements, in coordinates multiplied by the square roots of the masses.
#[derive(Clone, Debug)]
struct Basis {
    /// `None` if all displacements are free; then the coordinates themselves are the basis.
    free: Option<DMatrix<Complex>>,
    others: DMatrix<Complex>,
}

impl<const D: usize> Pencil<D> {
    /// Builds the pencil of the Hermitian part of a system.
    ///
    /// `None` if velocities are smoothed, or if a translation or a homogeneous strain causes forces, so that the measure has no long-wave limit.
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
        let places = system.crystal().sites();
        Self::new(stiffness, mass, places, &masses, measure, lattice)
    }

    /// Builds the pencil of the Hermitian part of a dynamical matrix; `None` if the matrix is not periodic.
    pub(super) fn of_matrix(
        matrix: &DynamicalMatrix<D>,
        measure: Measure,
        lattice: &BravaisLattice<D>,
    ) -> Option<Self> {
        let stiffness = PhaseSum::of_matrix(matrix, measure.unit())?;
        let places = [Fractional::zeros()];
        Self::new(stiffness, None, &places, &[1.0], measure, lattice)
    }

    fn new(
        stiffness: PhaseSum<D>,
        mass: Option<PhaseSum<D>>,
        places: &[Fractional<D>],
        masses: &[f64],
        measure: Measure,
        lattice: &BravaisLattice<D>,
    ) -> Option<Self> {
        if !masses.iter().all(|mass| mass.is_finite() && *mass > 0.0) {
            return None;
        }
        let (basis, laplacian) = match measure {
            Measure::Scaled(_) => (
                Basis::at_gamma(&stiffness, masses)?,
                Some(Laplacian(lattice.measured_along(lattice.reciprocal()))),
            ),
            _ => (Basis::whole(D * places.len()), None),
        };
        Some(Self {
            lattice: *lattice,
            places: places.to_vec(),
            basis,
            stiffness,
            mass,
            laplacian,
        })
    }

    pub(super) fn reciprocal(&self) -> &SMatrix<f64, D, D> {
        self.lattice.reciprocal()
    }

    /// Number of components of a displacement.
    fn size(&self) -> usize {
        D * self.places.len()
    }

    /// Maps between wave vectors with the same spectrum, from the symmetries of the lattice.
    pub(super) fn images(&self) -> Images<D> {
        let mut group = Symmetry::all(&self.lattice);
        group.retain(|symmetry| self.has(symmetry));
        Images::new(&group)
    }

    /// Returns true if a symmetry of the lattice leaves `P` and `Q` unchanged.
    fn has(&self, symmetry: &Symmetry<D>) -> bool {
        let sums = [Some(&self.stiffness), self.mass.as_ref()];
        let is_kept = |exchanged: &Vec<usize>| {
            let mut sums = sums.iter().flatten();
            sums.all(|sum| sum.has(symmetry, &self.places, exchanged))
        };
        let laplacian = self.laplacian.as_ref();
        laplacian.is_none_or(|laplacian| laplacian.has(symmetry))
            && exchanges(symmetry, &self.places).any(|exchanged| is_kept(&exchanged))
    }

    /// Work for a box of the zone, in units of about 80 ns of one core: blocks in the sum, entries, factorizations.
    pub(super) fn cost(&self) -> usize {
        let size = self.size();
        let in_space = 40 + self.blocks() / 2 + 3 * size * size + size * size * size;
        in_space * (D + 1) / 4
    }

    /// Work for any box. Phases are more expensive in cones, and relaxing particles require three sums.
    pub(super) fn cost_on(&self, cell: &Cell<D>) -> usize {
        let sums = if self.basis.free.is_some() { 3 } else { 1 };
        match cell.chart {
            Chart::Zone => self.cost(),
            Chart::Cone(_) => self.cost() + CONE_COST * sums * self.blocks() * (D + 1) / 4,
        }
    }

    fn blocks(&self) -> usize {
        self.stiffness.len() + self.mass.as_ref().map_or(0, PhaseSum::len)
    }

    /// Long-wave limit of the measure along a direction.
    pub(super) fn limit_along(&self, direction: &SVector<f64, D>) -> f64 {
        self.value(direction, Cell::limit_along)
    }

    /// Measure at a wave vector.
    pub(super) fn at(&self, k: &SVector<f64, D>) -> f64 {
        self.value(k, Cell::point)
    }

    fn value(&self, k: &SVector<f64, D>, cell: impl Fn(&SVector<f64, D>) -> Cell<D>) -> f64 {
        let components = self.lattice.vectors().tr_mul(k) / TAU;
        let value = self.on(&cell(&components)).value();
        if value.is_finite() {
            value
        } else {
            f64::INFINITY
        }
    }

    /// Boxes that together cover half of the zone, for a budget of `most` boxes.
    pub(super) fn boxes(&self, most: usize) -> Vec<Cell<D>> {
        Cell::half_zone(self.laplacian.is_some(), most)
    }

    /// Polynomials of `P` and `Q` on a box.
    pub(super) fn on(&self, cell: &Cell<D>) -> Local<D> {
        match cell.chart {
            Chart::Zone => self.in_zone(cell),
            Chart::Cone(cone) => self.in_cone(cell, cone),
        }
    }

    fn in_zone(&self, cell: &Cell<D>) -> Local<D> {
        let n = self.size();
        let mut bends = [0.0; D];
        let numerator = self.stiffness.in_zone(cell, &mut bends);
        let laplacian = self.laplacian.as_ref();
        let factor = laplacian.map_or(Jet::ONE, |laplacian| laplacian.in_zone(cell));
        let denominator = match &self.mass {
            Some(mass) => mass.in_zone(cell, &mut [0.0; D]).times(&factor, &cell.half),
            None => MatrixJet::multiple(n, &factor),
        };
        Local {
            half: cell.half,
            free: n,
            rest: [[numerator.rest, 0.0], [denominator.rest, 0.0]],
            numerator: numerator.parts,
            denominator: denominator.parts,
            bends,
        }
    }

    /// Polynomials in the basis of free displacements, divided by `t`, and other displacements.
    fn in_cone(&self, cell: &Cell<D>, cone: usize) -> Local<D> {
        let mut bends = [0.0; D];
        let mut sum = |m: usize| self.stiffness.in_cone(cell, cone, m, &mut bends);
        let numerator = match self.basis.free {
            None => Blocks::of_free(sum(2)),
            Some(_) => self.basis.projected([&sum(2), &sum(1), &sum(0)]),
        };
        let laplacian = self.laplacian.as_ref();
        let factors = laplacian.map_or([Jet::ONE; 3], |laplacian| laplacian.in_cone(cell, cone));
        let denominator = match &self.mass {
            Some(mass) => {
                let mass = mass.in_cone(cell, cone, 0, &mut [0.0; D]);
                self.basis.projected([&mass; 3]).times(&factors, &cell.half)
            }
            None => self.basis.multiple(self.size(), &factors),
        };
        Local {
            half: cell.half,
            free: numerator.free.parts.shape().0,
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

    /// Splits displacements into free (zero-energy at `k = 0`) and other displacements.
    ///
    /// `None` if translations change the energy, or if free displacements cause forces on each other that are linear in the wave vector, so that the scaled
    /// measure has no limit.
    fn at_gamma<const D: usize>(bonds: &PhaseSum<D>, masses: &[f64]) -> Option<Self> {
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
            let own = if value.abs() <= VANISHING_SUM_RATIO * size {
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
        let has_limit = moments.iter().all(|moment| {
            (free.transpose() * moment * &free).amax() <= VANISHING_SUM_RATIO * extent
        });
        let complex = |m: &DMatrix<f64>| m.map(|x| Complex::new(x, 0.0));
        (are_free && has_limit).then(|| Self {
            free: (others.ncols() > 0).then(|| complex(&free)),
            others: complex(&others),
        })
    }

    /// Projects three sums on the basis: between free displacements, between free and other, and between other displacements.
    fn projected<const D: usize>(
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

    /// Identity with one factor for free and one for other displacements.
    fn multiple<const D: usize>(&self, size: usize, factors: &[Jet<D>; 3]) -> Blocks<D> {
        let others = self.others.ncols();
        Blocks {
            free: MatrixJet::multiple(size - others, &factors[0]),
            mixed: MatrixJet::zeros(size - others, others),
            others: MatrixJet::multiple(others, &factors[2]),
        }
    }
}

/// A Hermitian matrix in the basis of free and remaining displacements, by blocks.
struct Blocks<const D: usize> {
    free: MatrixJet<D>,
    mixed: MatrixJet<D>,
    others: MatrixJet<D>,
}

impl<const D: usize> Blocks<D> {
    fn of_free(free: MatrixJet<D>) -> Self {
        let size = free.parts.shape().0;
        Self {
            free,
            mixed: MatrixJet::zeros(size, 0),
            others: MatrixJet::zeros(0, 0),
        }
    }

    /// Multiplies the blocks by factors: between free, between free and other, and between other displacements.
    fn times(&self, factors: &[Jet<D>; 3], half: &[f64; D]) -> Self {
        Self {
            free: self.free.times(&factors[0], half),
            mixed: self.mixed.times(&factors[1], half),
            others: self.others.times(&factors[2], half),
        }
    }

    /// Bounds of the remainders for free and other displacements; `|x y| <= (x^2 + y^2) / 2` distributes the remainder of the mixed block.
    fn rests(&self) -> [f64; 2] {
        [
            self.free.rest + self.mixed.rest,
            self.others.rest + self.mixed.rest,
        ]
    }

    fn joined(&self) -> Parts {
        let (free, inner) = self.mixed.parts.shape();
        let mut joined = Parts::zeros(free + inner, free + inner, parts::<D>());
        for n in 0..parts::<D>() {
            let (mut whole, mixed) = (joined.part_mut(n), self.mixed.parts.part(n));
            let mut set = |place, (rows, columns), part: DMatrixView<'_, Complex>| {
                whole.view_mut(place, (rows, columns)).copy_from(&part);
            };
            set((0, 0), (free, free), self.free.parts.part(n));
            set((0, free), (free, inner), mixed);
            set((free, 0), (inner, free), mixed.adjoint().as_view());
            set((free, free), (inner, inner), self.others.parts.part(n));
        }
        joined
    }
}
