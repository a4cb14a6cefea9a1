//! Stiffness of the forces of a stress by the chain rule.
//!
//! A traction between a particle and a neighbor depends on the displacements of all particles around them, but only through a few numbers. These are
//! the deformation gradient and density of the particle, the moment `K` of corrected forces, and the position and density of the neighbor. The
//! traction is differentiated with respect to these numbers once for each neighbor. Their derivatives with respect to the displacements are in closed
//! form, in the homogeneous state. Direct differentiation with respect to each displacement would increase the cost by a factor equal to the number
//! of particles.

use super::stress::StressOf;
use crate::algebra::array_of;
use crate::bloch::BlochBlocks;
use crate::real::{Dual, Real};
use nalgebra::{SMatrix, SVector};

/// Number of derivatives computed in one pass.
const LANES: usize = 8;
type Number = Dual<LANES>;

/// Derivatives of a number with respect to the displacements of all particles.
type Row<const D: usize> = Vec<SVector<f64, D>>;

/// Order of the numbers that determine tractions: `F` by rows, the density, `K` by rows, the vector to the neighbor, the density of the neighbor.
///
/// `K` is present only for corrected forces, the density of the neighbor only if the force depends on it.
#[derive(Clone, Copy)]
struct Order {
    density: usize,
    moment: usize,
    vector: usize,
    other_density: usize,
    count: usize,
}

impl Order {
    fn new(dimension: usize, is_corrected: bool, takes_both_densities: bool) -> Self {
        let density = dimension * dimension;
        let moment = density + 1;
        let vector = moment + usize::from(is_corrected) * dimension * dimension;
        let other_density = vector + dimension;
        Self {
            density,
            moment,
            vector,
            other_density,
            count: other_density + usize::from(takes_both_densities),
        }
    }
}

/// Homogeneous state with the derivatives with respect to the displacements of the particles.
pub(super) struct Chain<'a, const D: usize> {
    stress: &'a StressOf<'a, D>,
    order: Order,
    f: [[f64; D]; D],
    /// The moment `K`, if forces are corrected.
    moment: Option<[[f64; D]; D]>,
    /// Particles whose displacements move each particle, with their weights.
    shifts: Vec<Vec<(usize, f64)>>,
    /// The relevant densities with their derivatives, starting with the density of the particle itself.
    densities: Vec<(f64, Row<D>)>,
}

impl<'a, const D: usize> Chain<'a, D> {
    pub(super) fn new(stress: &'a StressOf<'a, D>) -> Self {
        let pairs = stress.surroundings.pairs;
        let rest = stress.at_rest();
        let mut chain = Self {
            stress,
            order: Order::new(D, pairs.corrects_forces(), pairs.takes_both_densities()),
            f: stress.response(0).leading(),
            moment: stress.moment(&rest),
            shifts: (0..stress.particles.len())
                .map(|n| stress.shares(n).collect())
                .collect(),
            densities: Vec::new(),
        };
        let densities = (0..stress.circles.len()).map(|n| {
            let density = stress.density(n, &rest);
            (density, chain.density_row(n, density))
        });
        chain.densities = densities.collect();
        chain
    }

    /// A row without derivatives.
    fn row(&self) -> Row<D> {
        vec![SVector::zeros(); self.stress.particles.len()]
    }

    /// Adds the contribution of the vector between two particles, given the derivative with respect to this vector.
    fn add_vector(&self, row: &mut Row<D>, [from, to]: [usize; 2], slope: &SVector<f64, D>) {
        for (n, share) in &self.shifts[to] {
            row[*n] += slope * *share;
        }
        for (n, share) in &self.shifts[from] {
            row[*n] -= slope * *share;
        }
    }

    /// Derivatives of a density: from the gradients of the weights for summation, and `-rho div u` for continuity.
    fn density_row(&self, number: usize, density: f64) -> Row<D> {
        let StressOf {
            surroundings,
            masses,
            circles,
            ..
        } = self.stress;
        let pairs = surroundings.pairs;
        let members = &circles[number].members;
        let mut row = self.row();
        if pairs.sums_densities() {
            for member in members {
                let x = self.stress.vector(number, *member);
                let slope = SVector::from(pairs.weigh(&x).gradient) * masses[*member];
                self.add_vector(&mut row, [number, *member], &slope);
            }
            return row;
        }
        for (member, gradient) in members.iter().zip(&circles[number].gradients) {
            row[*member] -= SVector::from(*gradient) * density;
        }
        row
    }

    /// Rows of the numbers that belong to the particle itself.
    fn own_rows(&self) -> Vec<Row<D>> {
        let circle = &self.stress.circles[0];
        let mut rows = vec![self.row(); self.order.vector];
        // Derivative of (1 + sum u_J (x) g_J) F.
        for (member, gradient) in circle.members.iter().zip(&circle.gradients) {
            for j in 0..D {
                let slope: f64 = (0..D).map(|m| gradient[m] * self.f[m][j]).sum();
                for i in 0..D {
                    rows[i * D + j][*member][i] += slope;
                }
            }
        }
        rows[self.order.density].clone_from(&self.densities[0].1);
        if self.moment.is_some() {
            for other in circle.members[1..].iter().copied() {
                self.add_to_moment(other, &mut rows[self.order.moment..]);
            }
        }
        rows
    }

    /// Adds the contribution of a neighbor to the moment.
    fn add_to_moment(&self, other: usize, rows: &mut [Row<D>]) {
        let x = self.stress.vector(0, other);
        let x: [Number; D] = array_of(|i| Number::variable(x[i], i));
        let (density, density_row) = &self.densities[other];
        let part = self
            .stress
            .part_of_moment(other, &x, Number::variable(*density, D));
        for (entry, row) in part.as_flattened().iter().zip(rows) {
            let slope = SVector::from_fn(|i, _| entry.gradient[i]);
            self.add_vector(row, [0, other], &slope);
            for (own, change) in row.iter_mut().zip(density_row) {
                *own += change * entry.gradient[D];
            }
        }
    }

    /// Derivatives of the tractions of all neighbors with respect to the numbers in [`Order`].
    fn tractions(&self) -> Vec<Vec<SVector<f64, D>>> {
        let Order {
            density,
            moment,
            vector,
            other_density,
            count,
        } = self.order;
        let others = &self.stress.circles[0].members[1..];
        let mut tractions = vec![Vec::with_capacity(count); others.len()];
        for start in (0..count).step_by(LANES) {
            let lanes = LANES.min(count - start);
            let number = |place: usize, value: f64| match place.checked_sub(start) {
                Some(lane) if lane < lanes => Number::variable(value, lane),
                _ => Number::constant(value),
            };
            let matrix = |first: usize, values: &[[f64; D]; D]| -> [[Number; D]; D] {
                array_of(|i| array_of(|j| number(first + i * D + j, values[i][j])))
            };
            let own_moment = self.moment.as_ref().map(|values| matrix(moment, values));
            let own_density = number(density, self.densities[0].0);
            let own = self
                .stress
                .laden(&matrix(0, &self.f), own_density, own_moment.as_ref());
            for (other, derivatives) in others.iter().zip(&mut tractions) {
                let x = self.stress.vector(0, *other);
                let x: [Number; D] = array_of(|i| number(vector + i, x[i]));
                let known = self.densities.get(*other);
                let there = known.map_or(own_density, |known| number(other_density, known.0));
                let traction = self.stress.traction(&own, *other, &x, there);
                let derivative = |lane| SVector::from_fn(|i, _| traction[i].gradient[lane]);
                derivatives.extend((0..lanes).map(derivative));
            }
        }
        tractions
    }

    /// Adds the negative derivatives of the forces with respect to the displacements.
    pub(super) fn add_stiffness(&self, blocks: &mut BlochBlocks<D>) {
        let pairs = self.stress.surroundings.pairs;
        let mut sums = blocks.between(&self.stress.particles);
        let rows = self.own_rows();
        let count = self.stress.particles.len();
        let mut of_all = vec![SMatrix::<f64, D, D>::zeros(); count];
        let mut own = of_all.clone();
        let others = &self.stress.circles[0].members[1..];
        for (other, traction) in others.iter().copied().zip(self.tractions()) {
            own.fill(SMatrix::zeros());
            let mut add_row = |derivative: &SVector<f64, D>, row: &Row<D>| {
                for (block, change) in own.iter_mut().zip(row) {
                    *block += derivative * change.transpose();
                }
            };
            for (derivative, row) in traction.iter().zip(&rows) {
                add_row(derivative, row);
            }
            if let Some(derivative) = traction.get(self.order.other_density) {
                add_row(derivative, &self.densities[other].1);
            }
            let along = SMatrix::from_columns(&traction[self.order.vector..][..D]);
            for (n, share) in &self.shifts[other] {
                own[*n] += along * *share;
            }
            for (n, share) in &self.shifts[0] {
                own[*n] -= along * *share;
            }
            // The force on the neighbor is minus the traction.
            for (n, block) in own.iter().enumerate() {
                sums.add(other, n, block);
                of_all[n] += block;
            }
        }
        for (n, block) in of_all.iter().enumerate() {
            let taken: [_; D] = array_of(|c| SVector::from(pairs.taken(block.column(c).into())));
            sums.add(0, n, &-SMatrix::from_columns(&taken));
        }
        sums.finish();
    }
}
