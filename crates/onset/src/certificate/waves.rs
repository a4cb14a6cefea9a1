//! The dynamical matrix as a sum of cosines with a bounded error.

use super::points::{Neighbor, Point};
use crate::algebra::{Each, array_of};
use crate::material::{Hyperelastic, ResponseEnclosure};
use crate::method::{Frame, Linearization, Method};
use crate::real::Interval;

/// Entries `11, 12, 21, 22` of a matrix. In one dimension the single entry is stored at `11` and `22`.
pub(super) type Entries = [f64; 4];

/// Sum `D = rigid + sum_n C_n (1 - cos n.theta)`, `theta_i = k.a_i`, over half of the vectors `n`.
///
/// The sum is real because inversion maps the set of quadrature points onto itself. The coefficients are taken as exact doubles. The exact dynamical
/// matrix differs from the sum by no more than the stated errors.
pub(super) struct Waves {
    pub(super) terms: Vec<Term>,
    /// Positions of the ends of vectors in their cell, starting with the lattice point.
    pub(super) sites: Vec<[f64; 2]>,
    /// Largest lattice coordinate of a cell.
    pub(super) reach: usize,
    /// Bound of `sum |delta C_n|` in any entry.
    pub(super) error: f64,
    /// Bound of `sum |delta C_n| |n|^2 / 2`, `|n| = |n_1| + |n_2|`.
    pub(super) long_error: f64,
    /// Matrix `D(0)`, unless it vanishes by the partition of unity or by symmetry.
    pub(super) rigid: Option<[Interval; 4]>,
    /// Whether `D` is symmetric, like the second derivative of an energy.
    pub(super) is_symmetric: bool,
    pub(super) dimension: usize,
}

/// Vector `n = cell + site` with its coefficient.
#[derive(Clone, Copy)]
pub(super) struct Term {
    pub(super) cell: [i32; 2],
    pub(super) site: usize,
    pub(super) coefficient: Entries,
}

/// Stress and tangent that multiply gradients at a quadrature point.
struct Stiffness<const D: usize> {
    /// Tangent `a_ijkl`, or `A_iJkL` in the reference frame, times the factor of the point.
    tangent: [[[[Interval; D]; D]; D]; D],
    /// Stress `sigma_ij` times the factor of the point; zero in the reference frame.
    stress: [[Interval; D]; D],
}

/// Channel of the pair interaction: the block between particles `I` and `K` is `sum_c left_c(I) right_c(K)`, entry by entry.
type Channel = [[Interval; 4]; 2];

/// Dynamical matrix of a method and a material.
pub(super) fn dynamical_waves<const D: usize>(
    method: &Method<D>,
    material: &dyn Hyperelastic,
    points: &[Point<D>],
) -> Waves {
    let mut known: Option<(&Point<D>, ResponseEnclosure)> = None;
    let stiffnesses = points.iter().map(|point| {
        let response = match known.take() {
            Some((other, response)) if other.deformation == point.deformation => response,
            _ => material.enclosure(&point.deformation),
        };
        let stiffness = stiffness(method.choices().frame, point, &response);
        known = Some((point, response));
        stiffness
    });
    let stiffnesses: Vec<Stiffness<D>> = stiffnesses.collect();
    assembled(method, points, &stiffnesses, method.choices().frame)
}

/// Squared norm of the discrete gradient, `sum_q V_q |B_q|^2 / (rho V0)`, on the diagonal.
pub(super) fn gradient_waves<const D: usize>(method: &Method<D>, points: &[Point<D>]) -> Waves {
    let zero = Interval::ZERO;
    let stiffness = |point: &Point<D>| {
        let mut tangent = [[[[zero; D]; D]; D]; D];
        for i in 0..D {
            for j in 0..D {
                tangent[i][j][i][j] = point.factor;
            }
        }
        Stiffness {
            tangent,
            stress: [[zero; D]; D],
        }
    };
    let stiffnesses: Vec<Stiffness<D>> = points.iter().map(stiffness).collect();
    assembled(method, points, &stiffnesses, Frame::Lagrangian)
}

fn stiffness<const D: usize>(
    frame: Frame,
    point: &Point<D>,
    response: &ResponseEnclosure,
) -> Stiffness<D> {
    let zero = Interval::ZERO;
    let mut stiffness = Stiffness {
        tangent: [[[[zero; D]; D]; D]; D],
        stress: [[zero; D]; D],
    };
    let f = point.deformation.components();
    let a = &response.tangent;
    // The factor J of v_q = J V_q cancels the 1/J of sigma and a_ijkl.
    for i in 0..D {
        for j in 0..D {
            if frame == Frame::Eulerian {
                for m in 0..D {
                    stiffness.stress[i][j] = stiffness.stress[i][j]
                        + response.first_piola[i][m] * f[j][m] * point.factor;
                }
            }
            for k in 0..D {
                for l in 0..D {
                    let mut entry = zero;
                    if frame == Frame::Lagrangian {
                        entry = a[i][j][k][l];
                    } else {
                        for m in 0..D {
                            for n in 0..D {
                                entry = entry + f[j][m] * f[l][n] * a[i][m][k][n];
                            }
                        }
                    }
                    stiffness.tangent[i][j][k][l] = entry * point.factor;
                }
            }
        }
    }
    stiffness
}

/// Entries of a `D x D` matrix.
fn entries<const D: usize>(entry: impl Fn(usize, usize) -> Interval) -> [Interval; 4] {
    if D == 1 {
        let only = entry(0, 0);
        [only, Interval::ZERO, Interval::ZERO, only]
    } else {
        [entry(0, 0), entry(0, 1), entry(1, 0), entry(1, 1)]
    }
}

/// Channels of a neighbor: as the particle that experiences the force, and as the particle that moves.
fn channels<const D: usize>(
    point: &Point<D>,
    neighbor: &Neighbor<D>,
    stiffness: &Stiffness<D>,
    frame: Frame,
    linearization: Linearization,
) -> Vec<Channel> {
    let Stiffness { tangent, stress } = stiffness;
    let gradient = &neighbor.gradient;
    let mut channels = Vec::with_capacity(D + 7);
    for l in 0..D {
        // grad phi_I . a : grad phi_K, and the term sigma_il delta_jk left by the changes of volume and stress together.
        let left = entries::<D>(|i, k| {
            (0..D).fold(stress[i][l] * gradient[k], |sum, j| {
                sum + gradient[j] * tangent[i][j][k][l]
            })
        });
        channels.push([left, [gradient[l]; 4]]);
    }
    if frame == Frame::Lagrangian {
        return channels;
    }
    if !point.is_node && !linearization.moves_points_with_plane_wave() {
        let moved = kernel_motion(neighbor, stiffness, linearization);
        channels.push([moved, [neighbor.value; 4]]);
    }
    if linearization.is_exact_in_kernel() {
        for b in 0..point.basis {
            let right = entries::<D>(|i, k| {
                (0..D).fold(Interval::ZERO, |sum, j| {
                    sum + stress[i][j] * neighbor.shift1[j][k][b]
                })
            });
            channels.push([[neighbor.a[b]; 4], right]);
            let left = entries::<D>(|i, _| {
                (0..D).fold(Interval::ZERO, |sum, j| {
                    sum - stress[i][j] * neighbor.a1[j][b]
                })
            });
            channels.push([left, entries::<D>(|_, k| neighbor.shift[k][b])]);
        }
    }
    channels
}

/// Effect `sigma_ij phi_I,jk` of the motion of the quadrature point.
fn kernel_motion<const D: usize>(
    neighbor: &Neighbor<D>,
    stiffness: &Stiffness<D>,
    linearization: Linearization,
) -> [Interval; 4] {
    let hessian = if linearization == Linearization::FrozenNormalization {
        &neighbor.frozen_hessian
    } else {
        &neighbor.hessian
    };
    entries::<D>(|i, k| {
        (0..D).fold(Interval::ZERO, |sum, j| {
            sum + stiffness.stress[i][j] * hessian[j][k]
        })
    })
}

/// Magnitudes and radii of one side of a channel, summed over the neighbors, unweighted and weighted with `|n|^2`.
#[derive(Clone, Copy, Default)]
struct Sums {
    size: f64,
    radius: f64,
    long_size: f64,
    long_radius: f64,
}

impl Sums {
    fn add(&mut self, entry: Interval, length_squared: f64) {
        self.size += entry.magnitude();
        self.radius += entry.radius();
        self.long_size += entry.magnitude() * length_squared;
        self.long_radius += entry.radius() * length_squared;
    }
}

struct Assembly {
    reach: i32,
    dimension: usize,
    /// Total number of neighbors of all points.
    neighbors: usize,
    /// Force constants `Phi(R)` at lattice vectors.
    blocks: Vec<Entries>,
    loose: Vec<Term>,
    sites: Vec<[f64; 2]>,
    error: f64,
    long_error: f64,
}

impl Assembly {
    fn index(&self, from: [i32; 2], to: [i32; 2]) -> usize {
        let side = 2 * self.reach + 1;
        let first = to[0] - from[0] + self.reach;
        if self.dimension == 1 {
            first as usize
        } else {
            (first * side + to[1] - from[1] + self.reach) as usize
        }
    }

    /// Adds all pairs of neighbors of a point. Pairs `I = K` are assigned to the zero vector, which has no phase factor.
    fn add_pairs(&mut self, cells: &[[i32; 2]], place: [f64; 2], channels: &[Vec<Channel>]) {
        let count = channels.first().map_or(0, Vec::len);
        let side = |which: usize| -> Vec<Entries> {
            let of = |channels: &Vec<Channel>| -> Vec<Entries> {
                channels
                    .iter()
                    .map(|channel| channel[which].map(Interval::midpoint))
                    .collect()
            };
            channels.iter().flat_map(of).collect()
        };
        let (left, right) = (side(0), side(1));
        for (i, &from) in cells.iter().enumerate() {
            let own = &left[i * count..(i + 1) * count];
            for (k, &to) in cells.iter().enumerate() {
                let other = &right[k * count..(k + 1) * count];
                let mut block = [0.0; 4];
                for (a, b) in own.iter().zip(other) {
                    for e in 0..4 {
                        block[e] += a[e] * b[e];
                    }
                }
                let index = self.index(from, to);
                for e in 0..4 {
                    self.blocks[index][e] += block[e];
                }
            }
        }
        // Each force constant is a sum of at most this many products, in any order.
        let additions = (4 * count + 4 * self.neighbors + 64) as f64;
        let rounding = additions * f64::EPSILON;
        for c in 0..count {
            for e in 0..4 {
                let mut sums = [Sums::default(); 2];
                for (cell, channels) in cells.iter().zip(channels) {
                    let length: f64 = (0..2).map(|i| (f64::from(cell[i]) - place[i]).abs()).sum();
                    for which in 0..2 {
                        sums[which].add(channels[c][which][e], length * length);
                    }
                }
                let [a, b] = sums;
                let (radius, long_radius) = (
                    b.radius + rounding * b.size,
                    b.long_radius + rounding * b.long_size,
                );
                let error = (a.size + a.radius) * radius + a.radius * b.size;
                // |n_I - n_K|^2 <= 2 |n_I|^2 + 2 |n_K|^2, and half of it counts.
                let long = (a.long_size + a.long_radius) * radius
                    + (a.size + a.radius) * long_radius
                    + a.long_radius * b.size
                    + a.radius * b.long_size;
                self.spread(error, long);
            }
        }
    }

    /// Adds the terms of single vectors: the effect of the motion of a quadrature point.
    fn add_motion(&mut self, cell: [i32; 2], site: Option<usize>, motion: &[Interval; 4]) {
        let coefficient = motion.map(Interval::midpoint);
        let place = site.map_or([0.0; 2], |site| self.sites[site]);
        let vector = [0, 1].each(|i| place[i] - f64::from(cell[i]));
        let length = vector[0].abs() + vector[1].abs();
        for entry in motion {
            let error = entry.radius() + 4096.0 * f64::EPSILON * entry.magnitude();
            self.spread(error, 0.5 * length * length * error);
        }
        match site {
            None => {
                let index = self.index(cell, [0; 2]);
                for e in 0..4 {
                    self.blocks[index][e] += coefficient[e];
                }
            }
            Some(site) => self.loose.push(Term {
                cell: cell.each(|n| -n),
                site,
                // The mirror image, which is combined with this point or listed too, turns the phase factor into a cosine.
                coefficient: coefficient.each(|x| -x),
            }),
        }
    }

    /// Adds to the errors: an error of `Phi(R)` contributes at most twice to `C_n`.
    fn spread(&mut self, error: f64, long: f64) {
        self.error += 2.0 * error;
        self.long_error += 2.0 * long;
    }
}

fn planar<const D: usize>(cell: [i32; D]) -> [i32; 2] {
    [0, 1].each(|i| if i < D { cell[i] } else { 0 })
}

fn assembled<const D: usize>(
    method: &Method<D>,
    points: &[Point<D>],
    stiffnesses: &[Stiffness<D>],
    frame: Frame,
) -> Waves {
    let linearization = method.choices().linearization;
    let range = points
        .iter()
        .flat_map(|point| {
            (0..D).map(|i| {
                let along = point.neighbors.iter().map(|neighbor| neighbor.cell[i]);
                let (low, high) = along.fold((0, 0), |(low, high), n| (n.min(low), n.max(high)));
                high - low
            })
        })
        .max()
        .unwrap_or(0);
    let side = (2 * range + 1) as usize;
    let mut assembly = Assembly {
        reach: range,
        dimension: D,
        neighbors: points.iter().map(|point| point.neighbors.len()).sum(),
        blocks: vec![[0.0; 4]; side.pow(D as u32)],
        loose: Vec::new(),
        sites: vec![[0.0; 2]],
        error: 0.0,
        long_error: 0.0,
    };
    let mut rigid: Option<[Interval; 4]> = None;
    for (point, stiffness) in points.iter().zip(stiffnesses) {
        let cells: Vec<[i32; 2]> = point.neighbors.iter().map(|n| planar(n.cell)).collect();
        let place = [0, 1].each(|i| if i < D { point.place[i] } else { 0.0 });
        let of = |neighbor| channels(point, neighbor, stiffness, frame, linearization);
        let channels: Vec<Vec<Channel>> = point.neighbors.iter().map(of).collect();
        assembly.add_pairs(&cells, place, &channels);
        let moves_itself = point.is_node || linearization.moves_points_with_plane_wave();
        if frame == Frame::Eulerian && moves_itself {
            let site = (!point.is_node).then(|| {
                assembly.sites.push(place);
                assembly.sites.len() - 1
            });
            for (neighbor, &cell) in point.neighbors.iter().zip(&cells) {
                let motion = kernel_motion(neighbor, stiffness, linearization);
                assembly.add_motion(cell, site, &motion);
            }
        }
        if let Some(own) = rigid_part(method, point, stiffness, frame) {
            let sum = rigid.unwrap_or([Interval::ZERO; 4]);
            rigid = Some(array_of(|e| sum[e] + own[e]));
        }
    }
    finished(assembly, rigid, frame)
}

/// Force constant of a rigid translation at a point; `None` if the functions are a partition of unity.
fn rigid_part<const D: usize>(
    method: &Method<D>,
    point: &Point<D>,
    stiffness: &Stiffness<D>,
    frame: Frame,
) -> Option<[Interval; 4]> {
    use crate::approximation::Approximation;
    let discretization = method.choices();
    let linearization = discretization.linearization;
    let is_carried =
        frame == Frame::Eulerian && !point.is_node && !linearization.moves_points_with_plane_wave();
    if discretization.approximation != Approximation::Raw
        || (point.has_balanced_gradients && !is_carried)
    {
        return None;
    }
    let total = |of: &dyn Fn(&Neighbor<D>) -> Interval| {
        point
            .neighbors
            .iter()
            .fold(Interval::ZERO, |sum, n| sum + of(n))
    };
    let gradient: [Interval; D] = array_of(|j| {
        if point.has_balanced_gradients {
            Interval::ZERO
        } else {
            total(&|n| n.gradient[j])
        }
    });
    let excess = if is_carried {
        total(&|n| n.value) - 1.0
    } else {
        Interval::ZERO
    };
    Some(entries::<D>(|i, k| {
        let mut sum = Interval::ZERO;
        for l in 0..D {
            for j in 0..D {
                sum = sum + gradient[j] * stiffness.tangent[i][j][k][l] * gradient[l];
            }
            sum = sum + stiffness.stress[i][l] * gradient[k] * gradient[l];
            let hessian = total(&|n| {
                if linearization == Linearization::FrozenNormalization {
                    n.frozen_hessian[l][k]
                } else {
                    n.hessian[l][k]
                }
            });
            sum = sum + stiffness.stress[i][l] * hessian * excess;
        }
        sum
    }))
}

/// Combines `R` and `-R`: `C_n = -(Phi(R) + Phi(-R))`.
fn finished(assembly: Assembly, rigid: Option<[Interval; 4]>, frame: Frame) -> Waves {
    let side = 2 * assembly.reach + 1;
    let middle = assembly.blocks.len() / 2;
    let mut terms = Vec::with_capacity(middle + assembly.loose.len());
    for index in middle + 1..assembly.blocks.len() {
        let opposite = assembly.blocks.len() - 1 - index;
        let (forward, backward) = (assembly.blocks[index], assembly.blocks[opposite]);
        let coefficient: Entries = array_of(|e| -(forward[e] + backward[e]));
        if coefficient.iter().all(|x| *x == 0.0) {
            continue;
        }
        let index = index as i32;
        let cell = if assembly.dimension == 1 {
            [index - assembly.reach, 0]
        } else {
            [index / side - assembly.reach, index % side - assembly.reach]
        };
        terms.push(Term {
            cell,
            site: 0,
            coefficient,
        });
    }
    terms.extend(assembly.loose);
    let reach = terms
        .iter()
        .flat_map(|term| term.cell)
        .map(i32::unsigned_abs)
        .max();
    Waves {
        terms,
        sites: assembly.sites,
        reach: reach.unwrap_or(0) as usize,
        // Rounding of the bound itself.
        error: assembly.error * (1.0 + 1e-9) + f64::MIN_POSITIVE,
        long_error: assembly.long_error * (1.0 + 1e-9) + f64::MIN_POSITIVE,
        rigid,
        is_symmetric: frame == Frame::Lagrangian || assembly.dimension == 1,
        dimension: assembly.dimension,
    }
}
