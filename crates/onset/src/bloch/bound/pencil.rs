//! When no wave is softer than a number: a Hermitian matrix that is positive definite for all wave vectors.

use super::jet::{Jet, MatrixJet, bend, parts, slope};
use super::phase::{derivative_bounds, phases};
use crate::algebra::{Complex, MAXIMUM_ITERATIONS};
use crate::bloch::{BlochSum, DynamicalMatrix, Mass, WaveSystem};
use crate::lattice::{BravaisLattice, Crystal, Particle, inverse_of};
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

/// The block of a pair of particles, half of it where that is one particle.
#[derive(Clone, Debug)]
struct Bond<const D: usize> {
    from: usize,
    to: usize,
    /// `b_i . R` for the reciprocal vectors.
    along: [f64; D],
    block: SMatrix<f64, D, D>,
    norm: f64,
}

/// `P(k) - mu Q(k)`, positive definite where no measure is below `mu`.
///
/// Wave vectors are `k = t (b_a + sum_j s_j b_j)`: a cone around each reciprocal vector `b_a`, which together are half of the cell
/// of the reciprocal lattice, `t` up to 1/2 and `|s_j|` up to one. For the scaled measure `P = K / c^2`, `Q = |k|_h^2 M` in a basis of
/// free displacements, which cost nothing at `k = 0` (translations among them), and others, with the free ones divided by `t`.
/// Both are smooth up to `t = 0`, where the condition is that of the limit of long waves, relaxation included.
#[derive(Clone, Debug)]
pub(super) struct Pencil<const D: usize> {
    reciprocal: SMatrix<f64, D, D>,
    sites: usize,
    stiffness: Vec<Bond<D>>,
    /// The mass matrix, where it depends on the wave vector.
    mass: Option<Vec<Bond<D>>>,
    /// The scaled measure: reciprocal components and weights of the vectors of the lattice Laplacian.
    laplacian: Option<Vec<([f64; D], f64)>>,
    basis: Basis,
}

/// Orthonormal bases, as columns, of free displacements and the others, in coordinates multiplied with the square roots of masses.
#[derive(Clone, Debug)]
struct Basis {
    /// All displacements, in the coordinates themselves, where that is `None`.
    free: Option<DMatrix<Complex>>,
    others: DMatrix<Complex>,
}

/// Middle and half sides of a box in `(t, s)`, and the number of its cone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell<const D: usize> {
    pub(super) cone: usize,
    pub(super) middle: [f64; D],
    pub(super) half: [f64; D],
}

/// `P` and `Q` on a box.
pub(super) struct Local<const D: usize> {
    half: [f64; D],
    numerator: Vec<DMatrix<Complex>>,
    denominator: Vec<DMatrix<Complex>>,
    /// How many displacements are free.
    free: usize,
    /// Bounds of what the polynomials leave out, for free displacements and others.
    rest: [[f64; 2]; 2],
    /// How much the second derivatives by each variable may do.
    pub(super) bends: [f64; D],
}

/// What is known of `P - mu Q` on a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sign {
    /// Positive definite.
    Positive,
    /// Not, in the middle.
    Lost,
    /// Positive definite in the middle, perhaps not everywhere.
    Open,
}

impl<const D: usize> Cell<D> {
    /// The other reciprocal vectors, by the number of their variable.
    fn others(&self) -> impl Iterator<Item = (usize, usize)> {
        let cone = self.cone;
        (0..D)
            .filter(move |n| *n != cone)
            .enumerate()
            .map(|(v, n)| (v + 1, n))
    }

    /// The wave vector in the middle.
    pub(super) fn wave_vector(&self, reciprocal: &SMatrix<f64, D, D>) -> SVector<f64, D> {
        let mut direction: SVector<f64, D> = reciprocal.column(self.cone).into();
        for (variable, n) in self.others() {
            direction += reciprocal.column(n) * self.middle[variable];
        }
        direction * self.middle[0]
    }

    /// `f_m(t, p)` of a vector in the variables of the box for three `m`, with bounds of what is left, and of what the second
    /// derivatives do.
    fn jets(&self, along: &[f64; D], orders: [bool; 3]) -> [([Complex; 10], f64, [f64; D]); 3] {
        let t = self.middle[0];
        let (mut p, mut spread) = (along[self.cone], 0.0);
        let mut rates = [0.0; D];
        for (variable, n) in self.others() {
            p += self.middle[variable] * along[n];
            rates[variable] = along[n];
            spread += self.half[variable] * along[n].abs();
        }
        let functions = phases(t, p);
        let (most_t, most_p) = (t + self.half[0], p.abs() + spread);
        std::array::from_fn(|m| {
            let (mut jet, mut bends) = ([Complex::default(); 10], [0.0; D]);
            if !orders[m] {
                return (jet, 0.0, bends);
            }
            let f = &functions[m];
            jet[0] = f.value;
            jet[slope(0)] = f.slope[0];
            jet[bend::<D>(0, 0)] = f.bend[0];
            for a in 1..D {
                jet[slope(a)] = f.slope[1] * rates[a];
                jet[bend::<D>(a, 0)] = f.bend[1] * rates[a];
                for b in 1..=a {
                    jet[bend::<D>(a, b)] = f.bend[2] * (rates[a] * rates[b]);
                }
            }
            let (second, third) = derivative_bounds(m, most_t, most_p);
            let h = self.half[0];
            bends[0] = 0.5 * second[0] * h * h;
            for a in 1..D {
                bends[a] = 0.5 * second[1] * (rates[a] * self.half[a]).powi(2);
            }
            let rest = (third[0] * h.powi(3)
                + 3.0 * third[1] * h * h * spread
                + 3.0 * third[2] * h * spread * spread
                + third[3] * spread.powi(3))
                / 6.0;
            (jet, rest, bends)
        })
    }
}

impl<const D: usize> Pencil<D> {
    /// Of a system, for a measure over a lattice; `None` where the equations are not Hermitian, or where a translation or a
    /// homogeneous strain makes forces, so that the measure has no limit of long waves.
    pub(super) fn of_system(
        system: &WaveSystem<D>,
        measure: Measure,
        lattice: &BravaisLattice<D>,
    ) -> Option<Self> {
        if !system.is_hermitian() || system.drift().is_some() {
            return None;
        }
        let masses = system.particle_masses();
        let own = |sum: &BlochSum<D>| bonds(sum, system.crystal(), &masses);
        let mass = match system.mass() {
            Mass::Lumped(_) => None,
            Mass::Consistent(sum) => Some(own(sum)),
        };
        Self::new(own(system.stiffness()), mass, &masses, measure, lattice)
    }

    /// Of a dynamical matrix that is periodic.
    pub(super) fn of_matrix(
        matrix: &DynamicalMatrix<D>,
        measure: Measure,
        lattice: &BravaisLattice<D>,
    ) -> Option<Self> {
        if !matrix.is_hermitian() {
            return None;
        }
        let bond = |cell: &[i32; D], block: SMatrix<f64, D, D>| Bond {
            from: 0,
            to: 0,
            along: cell.map(|n| std::f64::consts::TAU * f64::from(n)),
            norm: block.norm(),
            block,
        };
        let constants = matrix.force_constants()?;
        let bonds = constants
            .iter()
            .map(|(cell, block)| bond(cell, *block))
            .collect();
        Self::new(bonds, None, &[1.0], measure, lattice)
    }

    fn new(
        mut stiffness: Vec<Bond<D>>,
        mass: Option<Vec<Bond<D>>>,
        masses: &[f64],
        measure: Measure,
        lattice: &BravaisLattice<D>,
    ) -> Option<Self> {
        if !masses.iter().all(|mass| mass.is_finite() && *mass > 0.0) {
            return None;
        }
        let reciprocal = lattice.reciprocal();
        let (mut laplacian, mut basis) = (None, Basis::whole(D * masses.len()));
        let unit = match measure {
            Measure::Scaled(speed_squared) => {
                basis = Basis::at_rest(&stiffness, masses)?;
                laplacian = Some(lattice.measured_along(reciprocal));
                speed_squared
            }
            Measure::Lowest => 1.0,
            Measure::Highest => -1.0,
        };
        for bond in &mut stiffness {
            bond.block /= unit;
            bond.norm /= unit.abs();
        }
        Some(Self {
            reciprocal: *reciprocal,
            sites: masses.len(),
            basis,
            stiffness: halved(stiffness),
            mass: mass.map(halved),
            laplacian,
        })
    }

    pub(super) fn reciprocal(&self) -> &SMatrix<f64, D, D> {
        &self.reciprocal
    }

    /// Blocks and entries that a box sums up.
    pub(super) fn cost(&self) -> usize {
        let size = D * self.sites;
        self.stiffness.len() + self.mass.as_ref().map_or(0, Vec::len) + 4 * size * size
    }

    /// The limit of the measure for long waves along a direction.
    pub(super) fn limit_along(&self, direction: &SVector<f64, D>) -> f64 {
        let Some(inverse) = inverse_of(&self.reciprocal) else {
            return f64::NAN;
        };
        let along = inverse * direction;
        let cone = along.iamax();
        let mut cell = Cell {
            cone,
            middle: [0.0; D],
            half: [0.0; D],
        };
        let others: Vec<(usize, usize)> = cell.others().collect();
        for (variable, n) in others {
            cell.middle[variable] = along[n] / along[cone];
        }
        self.on(&cell).value()
    }

    /// The cones that together are half of the zone.
    pub(super) fn cones() -> impl Iterator<Item = Cell<D>> {
        (0..D).map(|cone| Cell {
            cone,
            middle: std::array::from_fn(|a| if a == 0 { 0.25 } else { 0.0 }),
            half: std::array::from_fn(|a| if a == 0 { 0.25 } else { 1.0 }),
        })
    }

    /// `P` and `Q` on a box.
    pub(super) fn on(&self, cell: &Cell<D>) -> Local<D> {
        let orders = if self.laplacian.is_some() {
            [2, 1, 0]
        } else {
            [0; 3]
        };
        let mut bends = [0.0; D];
        let numerator = self.summed(&self.stiffness, cell, orders, &mut bends);
        let mut rest = [numerator.rests(), [0.0; 2]];
        let mut denominator = self.masses(cell);
        if let Some(laplacian) = &self.laplacian {
            let factors = scales(laplacian, cell);
            denominator.multiply(&factors, &cell.half);
        }
        rest[1] = denominator.rests();
        Local {
            half: cell.half,
            free: numerator.free.parts[0].nrows(),
            numerator: numerator.joined(),
            denominator: denominator.joined(),
            rest,
            bends,
        }
    }

    /// The mass matrix in the basis.
    fn masses(&self, cell: &Cell<D>) -> Blocks<D> {
        if let Some(mass) = &self.mass {
            return self.summed(mass, cell, [0; 3], &mut [0.0; D]);
        }
        let unit = |size: usize| {
            let mut jet = MatrixJet::zeros(size, size);
            jet.parts[0].fill_with_identity();
            jet
        };
        let others = self.basis.others.ncols();
        let free = D * self.sites - others;
        Blocks {
            free: unit(free),
            mixed: MatrixJet::zeros(free, others),
            others: unit(others),
        }
    }

    /// A sum of blocks with phases: of the given orders between free displacements, between these and others, and between others.
    fn summed(
        &self,
        bonds: &[Bond<D>],
        cell: &Cell<D>,
        orders: [usize; 3],
        bends: &mut [f64; D],
    ) -> Blocks<D> {
        let n = D * self.sites;
        let used = if self.basis.free.is_some() { 3 } else { 1 };
        let mut wanted = [false; 3];
        orders[..used]
            .iter()
            .for_each(|order| wanted[*order] = true);
        let mut sums = wanted.map(|is_wanted| {
            let size = if is_wanted { n } else { 0 };
            MatrixJet::<D>::zeros(size, size)
        });
        let mut rests = vec![[0.0; 3]; self.sites];
        for bond in bonds {
            let jets = cell.jets(&bond.along, wanted);
            let place = (D * bond.from, D * bond.to);
            for (order, sum) in sums
                .iter_mut()
                .enumerate()
                .filter(|(order, _)| wanted[*order])
            {
                let (jet, rest, bent) = &jets[order];
                sum.add(place, &bond.block, jet);
                rests[bond.from][order] += bond.norm * rest;
                rests[bond.to][order] += bond.norm * rest;
                (0..D).for_each(|a| bends[a] += bond.norm * bent[a]);
            }
        }
        for (order, sum) in sums.iter_mut().enumerate() {
            sum.symmetrize();
            // Of Hermitian matrices the sums over the rows bound the norm.
            sum.rest = rests.iter().map(|rest| rest[order]).fold(0.0, f64::max);
        }
        let [between_free, mixed, between_others] = orders.map(|order| &sums[order]);
        let others = &self.basis.others;
        let Some(free) = &self.basis.free else {
            return Blocks {
                free: between_free.clone(),
                mixed: MatrixJet::zeros(n, 0),
                others: MatrixJet::zeros(0, 0),
            };
        };
        Blocks {
            free: between_free.onto(free).onto_rows(free),
            mixed: mixed.onto(others).onto_rows(free),
            others: between_others.onto(others).onto_rows(others),
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
    fn at_rest<const D: usize>(bonds: &[Bond<D>], masses: &[f64]) -> Option<Self> {
        let n = D * masses.len();
        let mut sum = DMatrix::<f64>::zeros(n, n);
        let mut moments = vec![sum.clone(); D];
        let (mut size, mut extent) = (0.0, 0.0);
        for bond in bonds {
            let place = (D * bond.from, D * bond.to);
            sum.view_mut(place, (D, D))
                .zip_apply(&bond.block, |x, y| *x += y);
            size += bond.norm;
            for (moment, along) in moments.iter_mut().zip(bond.along) {
                moment
                    .view_mut(place, (D, D))
                    .zip_apply(&bond.block, |x, y| *x += along * y);
                extent += bond.norm * along.abs();
            }
        }
        if !size.is_finite() {
            return None;
        }
        let eigen = sum.try_symmetric_eigen(f64::EPSILON, MAXIMUM_ITERATIONS * n)?;
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
}

/// A Hermitian matrix in the basis of free displacements and others.
struct Blocks<const D: usize> {
    free: MatrixJet<D>,
    mixed: MatrixJet<D>,
    others: MatrixJet<D>,
}

impl<const D: usize> Blocks<D> {
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

impl<const D: usize> Local<D> {
    /// What is known of `P - mu Q` on the box.
    ///
    /// In scaled variables `u`, `|u_a| <= 1`, the polynomial is `A + sum_a u_a B_a + sum_{a<b} u_a u_b C_ab + sum_a u_a^2 X_a`. Without
    /// the positive part of `X_a` it is smaller; then its smallest eigenvalue, a minimum of functions that are concave in each
    /// variable alone, is attained in a corner.
    pub(super) fn sign(&self, mu: f64) -> Sign {
        let mut middle = self.part(0, mu);
        if !is_positive_definite(&mut middle.clone()) {
            return Sign::Lost;
        }
        let rest = [0, 1].map(|n| self.rest[0][n] + mu.abs() * self.rest[1][n]);
        for i in 0..middle.nrows() {
            middle[(i, i)] -= Complex::new(rest[usize::from(i >= self.free)], 0.0);
        }
        if !is_positive_definite(&mut middle.clone()) {
            return Sign::Open;
        }
        let half = &self.half;
        let scaled = |a: usize, b: usize, factor: f64| {
            self.part(bend::<D>(a, b), mu) * Complex::new(factor * half[a] * half[b], 0.0)
        };
        let slopes: [DMatrix<Complex>; D] =
            std::array::from_fn(|a| self.part(slope(a), mu) * Complex::new(half[a], 0.0));
        let pairs: Vec<([usize; 2], DMatrix<Complex>)> = (0..D)
            .flat_map(|a| (0..a).map(move |b| [a, b]))
            .map(|[a, b]| ([a, b], scaled(a, b, 1.0)))
            .collect();
        let pure: [DMatrix<Complex>; D] = std::array::from_fn(|a| scaled(a, a, 0.5));
        let most: f64 = pure.iter().map(|x| x.norm()).sum();
        let all_positive = |least: &DMatrix<Complex>| {
            (0..1_usize << D).all(|corner| {
                let sign = |a: usize| if corner >> a & 1 == 0 { 1.0 } else { -1.0 };
                let mut matrix = least.clone();
                for (a, slope) in slopes.iter().enumerate() {
                    add(&mut matrix, slope, sign(a));
                }
                for ([a, b], pair) in &pairs {
                    add(&mut matrix, pair, sign(*a) * sign(*b));
                }
                is_positive_definite(&mut matrix)
            })
        };
        if !all_positive(&middle) {
            return Sign::Open;
        }
        let size = middle.nrows();
        let coarse = &middle - DMatrix::identity(size, size) * Complex::new(most, 0.0);
        if all_positive(&coarse) {
            return Sign::Positive;
        }
        let Some(parts) = pure
            .into_iter()
            .map(negative_part)
            .collect::<Option<Vec<_>>>()
        else {
            return Sign::Open;
        };
        let fine = parts.iter().fold(middle, |sum, part| sum + part);
        if all_positive(&fine) {
            Sign::Positive
        } else {
            Sign::Open
        }
    }

    /// The smallest `mu` for which `P - mu Q` is singular at `t = 0`, where `Q` is that of free displacements alone: the others relax. Not
    /// a number where they cannot.
    fn value(&self) -> f64 {
        let (p, q, free) = (&self.numerator[0], &self.denominator[0], self.free);
        let inner = p.nrows() - free;
        let stiff = p.view((free, free), (inner, inner)).into_owned();
        let mixed = p.view((free, 0), (inner, free)).into_owned();
        let smallest = || {
            let mut own = p.view((0, 0), (free, free)).into_owned();
            if inner > 0 {
                own -= mixed.adjoint() * stiff.lu().solve(&mixed)?;
            }
            let lower = q
                .view((0, 0), (free, free))
                .into_owned()
                .cholesky()?
                .unpack();
            let half = lower.solve_lower_triangular(&own)?;
            let own = lower.solve_lower_triangular(&half.adjoint())?;
            let eigen = own.try_symmetric_eigen(f64::EPSILON, MAXIMUM_ITERATIONS * free)?;
            Some(eigen.eigenvalues.min())
        };
        smallest().unwrap_or(f64::NAN)
    }

    fn part(&self, n: usize, mu: f64) -> DMatrix<Complex> {
        let mut part = self.numerator[n].clone();
        add(&mut part, &self.denominator[n], -mu);
        part
    }
}

fn add(sum: &mut DMatrix<Complex>, other: &DMatrix<Complex>, factor: f64) {
    for (own, other) in sum.iter_mut().zip(other) {
        *own += other * factor;
    }
}

/// The negative part of a Hermitian matrix.
fn negative_part(matrix: DMatrix<Complex>) -> Option<DMatrix<Complex>> {
    let size = matrix.nrows();
    let eigen = matrix.try_symmetric_eigen(f64::EPSILON, MAXIMUM_ITERATIONS * size)?;
    let mut part = DMatrix::zeros(size, size);
    for (value, vector) in eigen
        .eigenvalues
        .iter()
        .zip(eigen.eigenvectors.column_iter())
    {
        if *value < 0.0 {
            part += vector * vector.adjoint() * Complex::new(*value, 0.0);
        }
    }
    Some(part)
}

/// Whether a Hermitian matrix, which is overwritten, has a factor of Cholesky's.
fn is_positive_definite(matrix: &mut DMatrix<Complex>) -> bool {
    let size = matrix.nrows();
    for j in 0..size {
        let mut pivot = matrix[(j, j)].re;
        for k in 0..j {
            pivot -= matrix[(j, k)].norm_sqr();
        }
        if pivot.is_nan() || pivot <= 0.0 {
            return false;
        }
        let root = pivot.sqrt();
        for i in j + 1..size {
            let mut entry = matrix[(i, j)];
            for k in 0..j {
                entry -= matrix[(i, k)] * matrix[(j, k)].conj();
            }
            matrix[(i, j)] = entry / root;
        }
    }
    true
}

/// `|k|_h^2` over `t^2`, `t` and one: the factors of the mass between free displacements, between these and others, and between
/// others.
fn scales<const D: usize>(laplacian: &[([f64; D], f64)], cell: &Cell<D>) -> [Jet<D>; 3] {
    let mut over_square = Jet::ZERO;
    for (along, weight) in laplacian {
        // 2 (1 - cos t p) / t^2.
        let [_, _, (jet, rest, _)] = cell.jets(along, [false, false, true]);
        for (part, own) in over_square.parts.iter_mut().zip(jet) {
            *part -= 2.0 * weight * own.re;
        }
        over_square.rest += 2.0 * weight * rest;
    }
    let t = Jet::variable(0, cell.middle[0]);
    let once = over_square.times(&t, &cell.half);
    [over_square, once, once.times(&t, &cell.half)]
}

/// The blocks of a sum, over the square roots of masses.
fn bonds<const D: usize>(sum: &BlochSum<D>, crystal: &Crystal<D>, masses: &[f64]) -> Vec<Bond<D>> {
    let reciprocal = crystal.lattice().reciprocal();
    let bond = |(from, to, block): (usize, &Particle<D>, &SMatrix<f64, D, D>)| {
        let vector = crystal.position(to) - crystal.position(&Particle::home(from));
        let block = block / (masses[from] * masses[to.site]).sqrt();
        Bond {
            from,
            to: to.site,
            along: std::array::from_fn(|i| reciprocal.column(i).dot(&vector)),
            norm: block.norm(),
            block,
        }
    };
    sum.blocks().map(bond).collect()
}

/// One of each two blocks that are each other's adjoints; half of those that are their own.
fn halved<const D: usize>(bonds: Vec<Bond<D>>) -> Vec<Bond<D>> {
    let side = |bond: &Bond<D>| {
        let leading = bond.along.iter().find(|x| x.abs() > 1e-6);
        match bond.from.cmp(&bond.to) {
            std::cmp::Ordering::Equal => leading.map_or(0.0, |x| x.signum()),
            std::cmp::Ordering::Less => 1.0,
            std::cmp::Ordering::Greater => -1.0,
        }
    };
    let half = |bond: Bond<D>| match side(&bond) {
        0.0 => Some(Bond {
            block: bond.block * 0.5,
            norm: bond.norm * 0.5,
            ..bond
        }),
        side => (side > 0.0).then_some(bond),
    };
    bonds.into_iter().filter_map(half).collect()
}
