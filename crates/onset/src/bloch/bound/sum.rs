//! Sums over pairs of particles with the phases of waves, on boxes of wave vectors.

use super::cell::Cell;
use super::jet::{Jet, MatrixJet, bend, parts, slope};
use crate::algebra::{Complex, Each, array_of};
use crate::bloch::{BlochSum, DynamicalMatrix};
use crate::lattice::{Crystal, Particle};
use nalgebra::{DMatrix, SMatrix};

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

/// A Hermitian sum of blocks with phases `exp(i k.R)`.
#[derive(Clone, Debug)]
pub(super) struct PhaseSum<const D: usize> {
    bonds: Vec<Bond<D>>,
    sites: usize,
    /// Of each pair its block times the powers up to the third order of its components: what derivatives by these sum up.
    powers: Vec<f64>,
    /// How much the second derivatives by each component may do.
    bends: [f64; D],
}

/// The components of derivatives of the third order, with the number of their arrangements.
fn thirds<const D: usize>() -> impl Iterator<Item = ([usize; 3], f64)> {
    let ordered = |a: usize, b: usize, c: usize| match (a == b, b == c) {
        (true, true) => 1.0,
        (false, false) => 6.0,
        _ => 3.0,
    };
    (0..D).flat_map(move |a| {
        (0..=a).flat_map(move |b| (0..=b).map(move |c| ([a, b, c], ordered(a, b, c))))
    })
}

/// Derivatives up to the third order.
const fn derivatives<const D: usize>() -> usize {
    parts::<D>() + D * (D + 1) * (D + 2) / 6
}

impl<const D: usize> PhaseSum<D> {
    /// Of the blocks of a sum, over the square roots of masses, in a unit.
    pub(super) fn of_system(
        sum: &BlochSum<D>,
        crystal: &Crystal<D>,
        masses: &[f64],
        unit: f64,
    ) -> Self {
        let reciprocal = crystal.lattice().reciprocal();
        let bond = |(from, to, block): (usize, &Particle<D>, &SMatrix<f64, D, D>)| {
            let vector = crystal.position(to) - crystal.position(&Particle::home(from));
            let block = block / (unit * (masses[from] * masses[to.site]).sqrt());
            Bond {
                from,
                to: to.site,
                along: array_of(|i| reciprocal.column(i).dot(&vector)),
                norm: block.norm(),
                block,
            }
        };
        Self::new(sum.blocks().map(bond), masses.len())
    }

    /// Of the force constants of a periodic matrix, in a unit.
    pub(super) fn of_matrix(matrix: &DynamicalMatrix<D>, unit: f64) -> Option<Self> {
        let constants = matrix.force_constants()?;
        let bonds = constants.iter().map(|(cell, block)| {
            let block = block / unit;
            Bond {
                from: 0,
                to: 0,
                along: cell.each(|n| std::f64::consts::TAU * f64::from(n)),
                norm: block.norm(),
                block,
            }
        });
        Some(Self::new(bonds, 1))
    }

    fn new(bonds: impl Iterator<Item = Bond<D>>, sites: usize) -> Self {
        let bonds: Vec<Bond<D>> = bonds.filter_map(halved).collect();
        let mut powers = Vec::with_capacity(bonds.len() * derivatives::<D>() * D * D);
        let mut bends = [0.0; D];
        for bond in &bonds {
            let r = bond.along;
            let mut factors = vec![1.0];
            factors.extend(r);
            factors.extend((0..D).flat_map(|a| (0..=a).map(move |b| r[a] * r[b])));
            factors.extend(thirds::<D>().map(|([a, b, c], _)| r[a] * r[b] * r[c]));
            for factor in factors {
                powers.extend(bond.block.iter().map(|x| x * factor));
            }
            (0..D).for_each(|a| bends[a] += bond.norm * r[a] * r[a]);
        }
        Self {
            bonds,
            sites,
            powers,
            bends,
        }
    }

    pub(super) fn len(&self) -> usize {
        self.bonds.len()
    }

    /// The sum at `k = 0` and its derivatives there, over `i`, by the components of the wave vector, with the sizes of their terms.
    pub(super) fn moments(&self) -> (DMatrix<f64>, Vec<DMatrix<f64>>, [f64; 2]) {
        let n = D * self.sites;
        let mut sum = DMatrix::<f64>::zeros(n, n);
        let mut moments = vec![sum.clone(); D];
        let mut sizes = [0.0; 2];
        for bond in &self.bonds {
            let add = |matrix: &mut DMatrix<f64>, factor: f64, back: f64| {
                for (i, j) in (0..D).flat_map(|i| (0..D).map(move |j| (i, j))) {
                    let (row, column) = (D * bond.from + i, D * bond.to + j);
                    matrix[(row, column)] += factor * bond.block[(i, j)];
                    matrix[(column, row)] += back * bond.block[(i, j)];
                }
            };
            add(&mut sum, 1.0, 1.0);
            sizes[0] += 2.0 * bond.norm;
            for (moment, along) in moments.iter_mut().zip(bond.along) {
                add(moment, along, -along);
                sizes[1] += 2.0 * bond.norm * along.abs();
            }
        }
        (sum, moments, sizes)
    }

    /// On a box of the zone. What is left of it is below the sizes of the derivatives of the third order in the middle and of
    /// the terms of the fourth.
    pub(super) fn in_zone(&self, cell: &Cell<D>, bends: &mut [f64; D]) -> MatrixJet<D> {
        let (n, entries) = (D * self.sites, D * D);
        let each = derivatives::<D>() * entries;
        let pairs = self.sites * self.sites;
        let [mut cosines, mut sines] = [(); 2].map(|()| vec![0.0; pairs * each]);
        let mut fourth = vec![0.0; self.sites];
        for (bond, powers) in self.bonds.iter().zip(self.powers.chunks_exact(each)) {
            let (mut phase, mut spread) = (0.0, 0.0);
            for a in 0..D {
                phase += cell.middle[a] * bond.along[a];
                spread += cell.half[a] * bond.along[a].abs();
            }
            let (sine, cosine) = phase.sin_cos();
            let start = (bond.from * self.sites + bond.to) * each;
            let own = start..start + each;
            let sums = cosines[own.clone()].iter_mut().zip(&mut sines[own]);
            for ((c, s), power) in sums.zip(powers) {
                *c += cosine * power;
                *s += sine * power;
            }
            let most = bond.norm * (spread * spread) * (spread * spread);
            fourth[bond.from] += most;
            fourth[bond.to] += most;
        }
        let assembled = |part: usize, order: usize| {
            let mut matrix = DMatrix::zeros(n, n);
            for pair in 0..pairs {
                let start = pair * each + part * entries;
                let (row, column) = (D * (pair / self.sites), D * (pair % self.sites));
                for entry in 0..entries {
                    let (c, s) = (cosines[start + entry], sines[start + entry]);
                    // i^order (c + i s).
                    let value = match order {
                        0 => Complex::new(c, s),
                        1 => Complex::new(-s, c),
                        2 => Complex::new(-c, -s),
                        _ => Complex::new(s, -c),
                    };
                    let place = (row + entry % D, column + entry / D);
                    matrix[place] += value;
                    matrix[(place.1, place.0)] += value.conj();
                }
            }
            matrix
        };
        let order = |part: usize| match part {
            0 => 0,
            part if part <= D => 1,
            _ => 2,
        };
        let third: f64 = thirds::<D>()
            .enumerate()
            .map(|(number, (abc, count))| {
                let size = norm_bound(&assembled(parts::<D>() + number, 3));
                count * size * abc.iter().map(|a| cell.half[*a]).product::<f64>()
            })
            .sum();
        for a in 0..D {
            bends[a] += 0.5 * self.bends[a] * cell.half[a] * cell.half[a];
        }
        MatrixJet {
            parts: (0..parts::<D>())
                .map(|part| assembled(part, order(part)))
                .collect(),
            rest: third / 6.0 + fourth.into_iter().fold(0.0, f64::max) / 24.0,
        }
    }

    /// On a box of a cone, as far as they are wanted with what remains of the phases beyond their first `m` terms, over `t^m`.
    pub(super) fn in_cone(
        &self,
        cell: &Cell<D>,
        cone: usize,
        wanted: [bool; 3],
        bends: &mut [f64; D],
    ) -> [MatrixJet<D>; 3] {
        let n = D * self.sites;
        let mut sums = wanted.map(|is_wanted| {
            let size = if is_wanted { n } else { 0 };
            MatrixJet::<D>::zeros(size, size)
        });
        let mut rests = vec![[0.0; 3]; self.sites];
        for bond in &self.bonds {
            let jets = cell.cone_jets(cone, &bond.along, wanted);
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
        sums
    }
}

/// The lattice Laplacian: reciprocal components and weights of its vectors.
#[derive(Clone, Debug)]
pub(super) struct Laplacian<const D: usize>(pub(super) Vec<([f64; D], f64)>);

impl<const D: usize> Laplacian<D> {
    /// `|k|_h^2` on a box of the zone.
    pub(super) fn in_zone(&self, cell: &Cell<D>) -> Jet<D> {
        let mut jet = Jet::ZERO;
        for (along, weight) in &self.0 {
            let (mut phase, mut spread) = (0.0, 0.0);
            for a in 0..D {
                phase += cell.middle[a] * along[a];
                spread += cell.half[a] * along[a].abs();
            }
            // 2 w (1 - cos(k.a)).
            let (sine, cosine) = phase.sin_cos();
            let twice = 2.0 * weight;
            jet.parts[0] += twice * (1.0 - cosine);
            for a in 0..D {
                jet.parts[slope(a)] += twice * sine * along[a];
                for b in 0..=a {
                    jet.parts[bend::<D>(a, b)] += twice * cosine * along[a] * along[b];
                }
            }
            jet.rest += twice * (sine.abs() / 6.0 + spread / 24.0) * spread.powi(3);
        }
        jet
    }

    /// `|k|_h^2` over `t^2`, `t` and one on a box of a cone.
    pub(super) fn in_cone(&self, cell: &Cell<D>, cone: usize) -> [Jet<D>; 3] {
        let mut over_square = Jet::ZERO;
        for (along, weight) in &self.0 {
            // 2 (1 - cos t p) / t^2.
            let [_, _, (jet, rest, _)] = cell.cone_jets(cone, along, [false, false, true]);
            for (part, own) in over_square.parts.iter_mut().zip(jet) {
                *part -= 2.0 * weight * own.re;
            }
            over_square.rest += 2.0 * weight * rest;
        }
        let t = Jet::variable(0, cell.middle[0]);
        let once = over_square.times(&t, &cell.half);
        [over_square, once, once.times(&t, &cell.half)]
    }
}

/// A bound of the norm of a Hermitian matrix.
fn norm_bound(matrix: &DMatrix<Complex>) -> f64 {
    let rows = matrix
        .row_iter()
        .map(|row| row.iter().map(|x| x.norm()).sum());
    matrix.norm().min(rows.fold(0.0, f64::max))
}

/// One of each two blocks that are each other's adjoints; half of those that are their own.
fn halved<const D: usize>(bond: Bond<D>) -> Option<Bond<D>> {
    let leading = bond.along.iter().find(|x| x.abs() > 1e-6);
    let side = match bond.from.cmp(&bond.to) {
        std::cmp::Ordering::Equal => leading.map_or(0.0, |x| x.signum()),
        std::cmp::Ordering::Less => 1.0,
        std::cmp::Ordering::Greater => -1.0,
    };
    match side {
        0.0 => Some(Bond {
            block: bond.block * 0.5,
            norm: bond.norm * 0.5,
            ..bond
        }),
        side => (side > 0.0).then_some(bond),
    }
}

#[cfg(test)]
mod tests {
    use super::{Bond, Laplacian, PhaseSum};
    use crate::algebra::Complex;
    use crate::bloch::bound::cell::{Cell, Chart};
    use crate::bloch::bound::jet::{Jet, MatrixJet, bend, slope};
    use nalgebra::{DMatrix, SMatrix};
    use proptest::prelude::*;

    fn at<const D: usize>(bonds: &[Bond<D>], sites: usize, x: &[f64; D]) -> DMatrix<Complex> {
        let mut sum = DMatrix::zeros(D * sites, D * sites);
        for bond in bonds {
            let phase: f64 = (0..D).map(|a| x[a] * bond.along[a]).sum();
            let phase = Complex::new(0.0, phase).exp();
            for i in 0..D {
                for j in 0..D {
                    let value = phase * bond.block[(i, j)];
                    let place = (D * bond.from + i, D * bond.to + j);
                    sum[place] += value;
                    sum[(place.1, place.0)] += value.conj();
                }
            }
        }
        sum
    }

    /// The polynomial of a box at a point of it.
    fn polynomial<const D: usize>(parts: impl Fn(usize) -> Complex, u: &[f64; D]) -> Complex {
        let mut sum = parts(0);
        for a in 0..D {
            sum += parts(slope(a)) * u[a];
            for b in 0..D {
                sum += parts(bend::<D>(a, b)) * (0.5 * u[a] * u[b]);
            }
        }
        sum
    }

    proptest! {
        #[test]
        fn sums_stay_within_their_rest(
            entries in proptest::collection::vec(-1.0..1.0f64, 6 * 4),
            along in proptest::collection::vec(-12.0..12.0f64, 6 * 2),
            middle in proptest::array::uniform2(-0.5..0.5f64),
            half in proptest::array::uniform2(1e-3..0.06f64),
            place in proptest::array::uniform2(-1.0..1.0f64),
        ) {
            let bonds: Vec<Bond<2>> = (0..6).map(|n| {
                let block = SMatrix::<f64, 2, 2>::from_column_slice(&entries[4 * n..4 * n + 4]);
                let along = [along[2 * n], along[2 * n + 1]];
                // Of pairs of one particle only one side is kept.
                let (from, to) = [(0, 0), (1, 1), (0, 1)][n % 3];
                let along = if along[0] < 0.0 && from == to { along.map(|x| -x) } else { along };
                Bond { from, to, along, norm: block.norm(), block }
            }).collect();
            let sum = PhaseSum::new(bonds.clone().into_iter(), 2);
            let cell = Cell { chart: Chart::Zone, middle, half };
            let MatrixJet { parts, rest } = sum.in_zone(&cell, &mut [0.0; 2]);
            let u = [place[0] * half[0], place[1] * half[1]];
            let exact = at(&bonds, 2, &[middle[0] + u[0], middle[1] + u[1]]);
            let difference = DMatrix::from_fn(4, 4, |i, j| {
                exact[(i, j)] - polynomial(|n| parts[n][(i, j)], &u)
            });
            prop_assert!(difference.norm() <= 2.0 * rest + 1e-12, "{} {rest}", difference.norm());
            let largest = difference.singular_values().max();
            prop_assert!(largest <= rest + 1e-12, "{largest} {rest}");

            let own = Laplacian(vec![([6.0, 1.0], 0.7), ([-2.0, 5.0], 1.3)]);
            let Jet { parts, rest } = own.in_zone(&cell);
            let square = |x: [f64; 2]| -> f64 {
                let terms = own.0.iter().map(|(a, w)| 4.0 * w * (0.5 * (x[0] * a[0] + x[1] * a[1])).sin().powi(2));
                terms.sum()
            };
            let exact = square([middle[0] + u[0], middle[1] + u[1]]);
            let expanded = polynomial(|n| Complex::new(parts[n], 0.0), &u).re;
            prop_assert!((exact - expanded).abs() <= rest + 1e-12);
        }
    }
}
