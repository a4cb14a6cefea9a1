//! Direct solution of sparse linear systems of bodies: LU factors of dense fronts, in the order of a nested dissection.
//!
//! Separators divide the body into halves, and these recursively. Unknowns of the halves are eliminated before their separators. Each elimination is
//! a dense operation on a front: the unknowns that are eliminated together, with all later unknowns coupled to them. A body of `n` particles in the
//! plane has `n log n` nonzero factors. Pivots are chosen within a front only: the matrix should be positive definite, not necessarily symmetric.
//!
//! Source: George, SIAM J. Numer. Anal. 10 (1973) 345; Duff and Reid, ACM Trans. Math. Softw. 9 (1983) 302.

use crate::cancel::checkpoint;
use nalgebra::{Cholesky, DMatrix, DVector, DVectorView, SMatrix, SVector};

/// Largest number of particles in a part that is not divided.
const LEAF: usize = 48;
/// Largest number of particles that are eliminated together.
const FRONT_SIZE: usize = 48;
/// Largest number of entries of the factors.
const FACTORS: usize = 300_000_000;

/// Square matrix of blocks. The blocks of a row are in ascending order of their columns.
pub(super) struct Rows<const D: usize>(pub(super) Vec<Vec<(u32, SMatrix<f64, D, D>)>>);

/// Reason why a matrix has no factors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum NoFactors {
    /// The symmetric part of the matrix is not positive definite.
    Indefinite,
    /// There are too many factors for the memory.
    TooMany,
}

/// Particles that are eliminated together, with the later particles that are coupled to them.
struct Front {
    own: Vec<u32>,
    beyond: Vec<u32>,
    /// Inverse of the block of the own unknowns.
    inverse: DMatrix<f64>,
    /// Blocks `inverse * A(own, beyond)` and `A(beyond, own)`.
    upper: DMatrix<f64>,
    lower: DMatrix<f64>,
}

/// LU factors of a sparse matrix.
pub(super) struct Factors<const D: usize> {
    fronts: Vec<Front>,
}

/// Own particles of each front and the numbers of the fronts that are eliminated directly before it.
type Order = Vec<(Vec<u32>, Vec<usize>)>;

/// Dissects particles into an order of elimination.
struct Dissection<'d, const D: usize> {
    neighbors: &'d [Vec<u32>],
    positions: &'d [[f64; 3]],
    /// Side of each particle in the current division.
    side: Vec<u32>,
    divisions: u32,
    order: Order,
}

impl<const D: usize> Dissection<'_, D> {
    /// Appends the fronts of some particles, and returns the number of the last front.
    fn dissect(&mut self, particles: Vec<u32>) -> Option<usize> {
        let (parts, rest) = self.divided(particles);
        let mut before: Vec<usize> = parts
            .into_iter()
            .filter_map(|part| self.dissect(part))
            .collect();
        for own in rest.chunks(FRONT_SIZE) {
            self.order.push((own.to_vec(), before));
            before = vec![self.order.len() - 1];
        }
        before.last().copied()
    }

    /// Two parts that are not coupled to each other, and their separator; no parts if there are few particles.
    fn divided(&mut self, mut particles: Vec<u32>) -> (Vec<Vec<u32>>, Vec<u32>) {
        if particles.len() <= LEAF {
            return (Vec::new(), particles);
        }
        let along = |n: &u32, axis: usize| self.positions[*n as usize][axis];
        let extent = |axis: usize| {
            let all = || particles.iter().map(|n| along(n, axis));
            all().fold(f64::NEG_INFINITY, f64::max) - all().fold(f64::INFINITY, f64::min)
        };
        let longest = (0..D).max_by(|a, b| extent(*a).total_cmp(&extent(*b)));
        let axis = longest.unwrap_or(0);
        particles.sort_by(|a, b| along(a, axis).total_cmp(&along(b, axis)).then(a.cmp(b)));
        let upper = particles.split_off(particles.len() / 2);
        self.divisions += 1;
        for n in &particles {
            self.side[*n as usize] = self.divisions;
        }
        let is_lower = |n: &u32| self.side[*n as usize] == self.divisions;
        let (separator, upper): (Vec<u32>, Vec<u32>) = upper
            .into_iter()
            .partition(|n| self.neighbors[*n as usize].iter().any(is_lower));
        (vec![particles, upper], separator)
    }
}

impl<const D: usize> Factors<D> {
    /// Factorizes a matrix minus a multiple of the identity. Particles near each other should have positions near each other.
    pub(super) fn new(
        rows: &Rows<D>,
        positions: &[[f64; 3]],
        shift: f64,
    ) -> Result<Self, NoFactors> {
        let count = rows.0.len();
        let mut neighbors: Vec<Vec<u32>> = vec![Vec::new(); count];
        for (from, row) in rows.0.iter().enumerate() {
            for (to, _) in row {
                neighbors[from].push(*to);
                neighbors[*to as usize].push(from as u32);
            }
        }
        for own in &mut neighbors {
            own.sort_unstable();
            own.dedup();
        }
        let mut dissection = Dissection::<D> {
            neighbors: &neighbors,
            positions,
            side: vec![0; count],
            divisions: 0,
            order: Vec::new(),
        };
        dissection.dissect((0..count as u32).collect());
        let order = dissection.order;
        let mut front_of = vec![0; count];
        for (front, (own, _)) in order.iter().enumerate() {
            for n in own {
                front_of[*n as usize] = front;
            }
        }
        // Later particles that each front is coupled to.
        let mut beyond: Vec<Vec<u32>> = Vec::with_capacity(order.len());
        let mut factors = 0;
        for (front, (own, before)) in order.iter().enumerate() {
            let near = own.iter().flat_map(|n| &neighbors[*n as usize]);
            let passed = before.iter().flat_map(|child| &beyond[*child]);
            let mut all: Vec<u32> = near.chain(passed).copied().collect();
            all.retain(|n| front_of[*n as usize] > front);
            all.sort_unstable();
            all.dedup();
            factors += D * D * own.len() * (own.len() + 2 * all.len());
            beyond.push(all);
        }
        if factors > FACTORS {
            return Err(NoFactors::TooMany);
        }
        let mut fronts = Vec::with_capacity(order.len());
        let mut left: Vec<Option<DMatrix<f64>>> = vec![None; order.len()];
        let mut place = vec![usize::MAX; count];
        for (number, (own, before)) in order.iter().enumerate() {
            checkpoint();
            let all: Vec<u32> = own.iter().chain(&beyond[number]).copied().collect();
            for (at, n) in all.iter().enumerate() {
                place[*n as usize] = at;
            }
            let mut front = DMatrix::<f64>::zeros(D * all.len(), D * all.len());
            let mut add = |from: usize, to: usize, block: &SMatrix<f64, D, D>| {
                let mut view = front.fixed_view_mut::<D, D>(D * from, D * to);
                view += block;
            };
            for n in own {
                let row = place[*n as usize];
                add(row, row, &(SMatrix::identity() * -shift));
                for (to, block) in &rows.0[*n as usize] {
                    if front_of[*to as usize] >= number {
                        add(row, place[*to as usize], block);
                    }
                }
            }
            for n in &beyond[number] {
                for (to, block) in &rows.0[*n as usize] {
                    if front_of[*to as usize] == number {
                        add(place[*n as usize], place[*to as usize], block);
                    }
                }
            }
            for child in before {
                let Some(rest) = left[*child].take() else {
                    continue;
                };
                for (j, to) in beyond[*child].iter().enumerate() {
                    for (i, from) in beyond[*child].iter().enumerate() {
                        let block = rest.fixed_view::<D, D>(D * i, D * j).into_owned();
                        add(place[*from as usize], place[*to as usize], &block);
                    }
                }
            }
            let (eliminated, rest) = eliminated::<D>(own, &beyond[number], &front)?;
            fronts.push(eliminated);
            left[number] = Some(rest);
        }
        Ok(Self { fronts })
    }

    /// Solution of the system for a right-hand side.
    pub(super) fn solved(&self, right: &[f64]) -> Vec<f64> {
        let mut x = right.to_vec();
        let gathered = |x: &[f64], of: &[u32]| {
            let all = of.iter().flat_map(|n| &x[D * *n as usize..][..D]);
            DVector::from_iterator(D * of.len(), all.copied())
        };
        let put = |x: &mut [f64], of: &[u32], values: DVectorView<'_, f64>, sign: f64| {
            for (n, own) in of.iter().zip(values.as_slice().chunks_exact(D)) {
                let at = D * *n as usize;
                let sum = SVector::<f64, D>::from_column_slice(&x[at..at + D])
                    + SVector::<f64, D>::from_column_slice(own) * sign;
                x[at..at + D].copy_from_slice(sum.as_slice());
            }
        };
        for front in &self.fronts {
            let own = gathered(&x, &front.own);
            let solved = &front.inverse * &own;
            put(&mut x, &front.own, (&solved - own).as_view(), 1.0);
            put(
                &mut x,
                &front.beyond,
                (&front.lower * solved).as_view(),
                -1.0,
            );
        }
        for front in self.fronts.iter().rev() {
            let later = gathered(&x, &front.beyond);
            put(&mut x, &front.own, (&front.upper * later).as_view(), -1.0);
        }
        x
    }
}

/// Eliminates the unknowns of a front; also returns the matrix of the later unknowns.
fn eliminated<const D: usize>(
    own: &[u32],
    beyond: &[u32],
    front: &DMatrix<f64>,
) -> Result<(Front, DMatrix<f64>), NoFactors> {
    let (first, later) = (D * own.len(), D * beyond.len());
    let pivot = front.view((0, 0), (first, first)).into_owned();
    if Cholesky::new((&pivot + pivot.transpose()) * 0.5).is_none() {
        return Err(NoFactors::Indefinite);
    }
    let inverse = pivot.try_inverse().ok_or(NoFactors::Indefinite)?;
    let upper = &inverse * front.view((0, first), (first, later));
    let lower = front.view((first, 0), (later, first)).into_owned();
    let mut rest = front.view((first, first), (later, later)).into_owned();
    rest.gemm(-1.0, &lower, &upper, 1.0);
    let front = Front {
        own: own.to_vec(),
        beyond: beyond.to_vec(),
        inverse,
        upper,
        lower,
    };
    Ok((front, rest))
}

#[cfg(test)]
mod tests {
    use super::{Factors, NoFactors, Rows};
    use nalgebra::SMatrix;

    /// Unsymmetric blocks between nearby points of a square lattice.
    fn matrix(side: usize) -> (Rows<2>, Vec<[f64; 3]>) {
        let place = |n: usize| [(n % side) as f64, (n / side) as f64, 0.0];
        let places: Vec<[f64; 3]> = (0..side * side).map(place).collect();
        let row = |n: usize| {
            let apart = |m: usize| (places[n][0] - places[m][0]).hypot(places[n][1] - places[m][1]);
            let near = (0..side * side).filter(|m| apart(*m) < 2.3);
            let block = |m: usize| {
                let own = SMatrix::<f64, 2, 2>::new(1.0, 0.2, -0.3, 1.5) / (1.0 + apart(m));
                match m == n {
                    true => SMatrix::identity() * 30.0 + own,
                    false => -own,
                }
            };
            near.map(|m| (m as u32, block(m))).collect()
        };
        (Rows((0..side * side).map(row).collect()), places)
    }

    #[test]
    fn solutions_satisfy_the_equations() {
        let (rows, places) = matrix(23);
        let factors = Factors::new(&rows, &places, -0.5).expect("factors");
        let right: Vec<f64> = (0..2 * places.len()).map(|n| (n as f64).sin()).collect();
        let x = factors.solved(&right);
        let mut worst = 0.0_f64;
        for (n, row) in rows.0.iter().enumerate() {
            for i in 0..2 {
                let mut sum = 0.5 * x[2 * n + i] - right[2 * n + i];
                for (to, block) in row {
                    for j in 0..2 {
                        sum += block[(i, j)] * x[2 * *to as usize + j];
                    }
                }
                worst = worst.max(sum.abs());
            }
        }
        assert!(worst < 1e-12, "{worst}");
    }

    #[test]
    fn indefinite_matrices_are_recognized() {
        let (rows, places) = matrix(12);
        let none = Factors::new(&rows, &places, 35.0).err();
        assert_eq!(none, Some(NoFactors::Indefinite));
    }
}
