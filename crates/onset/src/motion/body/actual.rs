//! Lowest modes of a body in an actual state, in which particles have different deformations.
//!
//! The tangent `K` is the negative exact derivative of the forces on all particles at their actual positions. The modes satisfy `K u = omega^2 M u`,
//! with the held particles fixed. With `A = M^-1/2 K M^-1/2` and a shift `s` below the spectrum, `(A - s)^-1` has the eigenvalues `1 / (omega^2 -
//! s)`. They are largest for the lowest modes, so that a block Krylov method converges to these first. The shift is below the spectrum if all pivots
//! of `A - s` are positive (the law of inertia); for an unsymmetric tangent the pivots of its symmetric part are used.

use super::factor::{Factors, NoFactors, Rows};
use super::operator::isolated;
use super::stability::{Space, dot, unit};
use super::{BodyError, PlacedParticle};
use crate::algebra::{Complex, any_eigenvalues, array_of, uniform};
use crate::kinematics::DeformationGradient;
use crate::lattice::Particle;
use crate::material::Hyperelastic;
use crate::method::{Frame, MethodError};
use crate::scheme::element::{ElementOrder, ElementShape, FiniteElements, Mesh};
use crate::scheme::{Afresh, Discretization, MethodChoices, PeriodicPatch, updated};
use nalgebra::{DMatrix, DVector, SMatrix, SVector, SymmetricEigen};
use std::collections::BTreeMap;

/// Smallest shift relative to the largest entry of the matrix, and ratio of successive shifts.
const SHIFTS: (f64, f64) = (1e-6, 10.0);
/// Largest number of shifts.
const TRIALS: i32 = 12;
/// Number of vectors that are added to the Krylov space at a time; it exceeds one because modes occur in pairs and triples.
const BLOCK_SIZE: usize = 6;
/// Largest number of vectors of the Krylov space.
const VECTORS: usize = 160;
/// Largest number of Krylov spaces.
const SPACES: usize = 12;
/// Ratio of residual to eigenvalue of `(A - s)^-1` at which a mode has converged.
const RESIDUAL: f64 = 1e-8;
/// Largest relative difference of mirrored entries of a symmetric tangent, and largest relative force on a free rigid motion.
const SYMMETRIC: f64 = 1e-9;
/// Largest number of particles; the time of the neighbor search is proportional to its square.
const PARTICLES: usize = 50_000;
/// Smallest fraction of rigid motions in a mode that counts as a rigid motion.
const RIGID: f64 = 0.99;

/// Body in an actual state.
#[derive(Clone, Copy, Debug)]
pub struct ActualBody<'b> {
    /// Particles in the reference configuration.
    pub particles: &'b [PlacedParticle],
    /// Current positions of the particles; length.
    pub positions: &'b [[f64; 3]],
    /// Deformation gradients carried by particles with kernels in current coordinates; `None` if they are unknown.
    pub deformations: &'b [Option<DeformationGradient>],
    /// Nodes of the elements, in the order of VTK; empty for methods without elements.
    pub elements: &'b [Vec<usize>],
    /// Whether each particle is held, without displacements in the modes.
    pub held: &'b [bool],
}

/// Mode of a body, `u exp(s t)` with `s^2 = -omega^2`.
#[derive(Clone, Debug, PartialEq)]
pub struct ActualMode {
    /// Squared frequency `omega^2`, without viscosity; complex only for unsymmetric tangents. 1/time^2.
    pub squared: Complex,
    /// Displacements of all particles, normalized so that the largest has unit length.
    pub displacements: Vec<[f64; 3]>,
}

impl ActualMode {
    /// Growth rate without viscosity, the larger real part of `s`; zero for oscillations. 1/time.
    pub fn growth(&self) -> f64 {
        (-self.squared).sqrt().re.abs()
    }
}

/// Lowest modes of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct ActualModes {
    /// Modes in ascending order of the real part of `omega^2`, without rigid motions.
    pub modes: Vec<ActualMode>,
    /// Number of rigid motions among the lowest modes.
    pub rigid: usize,
    /// Number of components of the displacements of free particles.
    pub unknowns: usize,
    /// Whether the tangent is symmetric: forces have a potential.
    pub is_symmetric: bool,
    /// Largest entry of the tangent divided by masses; 1/time^2.
    pub scale: f64,
}

/// Tangent of the forces of all particles, with their masses.
struct Tangent<const D: usize> {
    rows: Vec<BTreeMap<u32, SMatrix<f64, D, D>>>,
    masses: Vec<f64>,
}

fn tangent<const D: usize>(
    choices: &MethodChoices,
    material: &dyn Hyperelastic,
    body: &ActualBody<'_>,
) -> Result<Tangent<D>, BodyError> {
    let count = body.particles.len();
    let spacing = choices.discretization::<D>()?.crystal().spacing();
    let crystal = |particles: &[PlacedParticle]| isolated::<D>(particles, 10.0 * spacing, spacing);
    let mut rows = vec![BTreeMap::new(); count];
    let mut add = |from: usize, to: usize, block: &SMatrix<f64, D, D>| {
        *rows[from].entry(to as u32).or_insert_with(SMatrix::zeros) += block;
    };
    let fixed: Box<dyn Discretization<D>> = match choices {
        MethodChoices::UpdatedSph(_, choices) => {
            let both = body.particles.iter().zip(body.positions);
            let moved = both.map(|(own, x)| PlacedParticle {
                position: *x,
                ..*own
            });
            let sph = updated(crystal(&moved.collect::<Vec<_>>())?, choices)?;
            let known = body.deformations.iter().enumerate();
            let known = known.map(|(particle, f)| f.ok_or_else(|| lost(body, particle)));
            let known = known.collect::<Result<Vec<_>, _>>()?;
            let sum = sph.tangent(material, &known)?.ok_or(BodyError::NoTangent)?;
            for (from, to, block) in sum.blocks() {
                add(from, to.site, block);
            }
            let masses = sph.masses();
            return Ok(Tangent { rows, masses });
        }
        // Codes number the nodes in the middles of edges in different orders.
        MethodChoices::FiniteElements(choices) if choices.order == ElementOrder::Quadratic => {
            return Err(BodyError::NoTangent);
        }
        MethodChoices::FiniteElements(choices) => {
            let shape = choices.built_mesh::<D>()?.shape();
            let needed = shape.nodes::<D>();
            if let Some((element, nodes)) = first_of_other_shape(body.elements, needed) {
                return Err(BodyError::OtherElement {
                    element,
                    nodes,
                    needed,
                });
            }
            // Nodes 2 and 3 of a quadrilateral, and 6 and 7 of a brick, are exchanged.
            let own_order = |n: usize| match shape {
                ElementShape::Multilinear => n ^ (n >> 1 & 1),
                _ => n,
            };
            let nodes = |element: &Vec<usize>| -> Vec<Particle<D>> {
                let all = (0..needed).map(|n| Particle::home(element[own_order(n)]));
                all.collect()
            };
            let elements = body.elements.iter().map(nodes).collect();
            let mesh = Mesh::free(crystal(body.particles)?, shape, elements);
            let mesh = mesh.map_err(MethodError::from)?.0;
            Box::new(FiniteElements::on(
                mesh,
                choices.density,
                choices.formulation,
            )?)
        }
        // Neighbors of Eulerian kernels change with the positions.
        MethodChoices::Kernel(choices) if choices.frame == Frame::Eulerian => {
            return Err(BodyError::NoTangent);
        }
        other => other
            .of_particles(crystal(body.particles)?)?
            .ok_or(BodyError::NoTangent)?,
    };
    let moved = body.positions.iter().zip(body.particles);
    let moved: Vec<SVector<f64, D>> = moved
        .map(|(x, from)| SVector::from_fn(|i, _| x[i] - from.position[i]))
        .collect();
    let patch = PeriodicPatch::new(fixed.crystal(), [1; D]);
    let undeformed = DeformationGradient::identity();
    let mut is_known = false;
    fixed.with_forces(&Afresh(material), &undeformed, &patch, &mut |forces| {
        is_known = forces.tangent(&moved, &mut add);
    })?;
    match is_known {
        true => Ok(Tangent {
            rows,
            masses: fixed.masses(),
        }),
        false => Err(BodyError::NoTangent),
    }
}

fn first_of_other_shape(elements: &[Vec<usize>], needed: usize) -> Option<(usize, usize)> {
    let counts = elements.iter().map(Vec::len);
    // If there are no elements, the first element is reported as missing.
    let counts = counts.chain(elements.is_empty().then_some(0));
    counts.enumerate().find(|(_, nodes)| *nodes != needed)
}

fn lost(body: &ActualBody<'_>, particle: usize) -> BodyError {
    BodyError::NoStress {
        particle,
        position: body.positions[particle].to_vec(),
    }
}

/// Returns the `count` lowest modes of a body in an actual state, without rigid motions.
///
/// # Errors
/// [`BodyError`] if method or law have no tangent there, or if the body is too large.
pub(crate) fn lowest_modes<const D: usize>(
    choices: &MethodChoices,
    material: &dyn Hyperelastic,
    body: &ActualBody<'_>,
    count: usize,
) -> Result<ActualModes, BodyError> {
    let particles = body.particles.len();
    match particles {
        0 => return Err(BodyError::Empty),
        1..=PARTICLES => {}
        _ => return Err(BodyError::TooLarge { particles }),
    }
    let Tangent { rows, masses } = tangent::<D>(choices, material, body)?;
    let is_known = |row: &BTreeMap<u32, SMatrix<f64, D, D>>| {
        row.values()
            .all(|block| block.iter().all(|x| x.is_finite()))
    };
    if let Some(particle) = rows.iter().position(|row| !is_known(row)) {
        return Err(lost(body, particle));
    }
    // Nodes that belong to no element have no mass.
    let is_free = |n: &usize| !body.held[*n] && masses[*n] > 0.0;
    let free: Vec<usize> = (0..rows.len()).filter(is_free).collect();
    let mut number = vec![None; rows.len()];
    for (own, n) in free.iter().enumerate() {
        number[*n] = Some(own as u32);
    }
    let row = |from: &usize| {
        let blocks = rows[*from].iter().filter_map(|(to, block)| {
            let mass = (masses[*from] * masses[*to as usize]).sqrt();
            Some((number[*to as usize]?, block / mass))
        });
        blocks.collect()
    };
    let matrix = Rows(free.iter().map(row).collect());
    let unknowns = D * free.len();
    let places: Vec<[f64; 3]> = free.iter().map(|n| body.particles[*n].position).collect();
    let scale = largest(&matrix);
    if unknowns == 0 || scale == 0.0 {
        return Err(BodyError::NoTangent);
    }
    let is_symmetric = asymmetry(&matrix) <= SYMMETRIC * scale;
    let (shift, factors) = below_the_spectrum(&matrix, &places, scale)?;
    let rigid = rigid_motions::<D>(body, &free, &masses);
    let free_motions = without_force(&matrix, &rigid, scale);
    let wanted = count + rigid.len() - free_motions.len();
    let found = largest_of_inverse(&factors, &free_motions, unknowns, wanted, is_symmetric);
    let mut all = ActualModes {
        modes: Vec::new(),
        rigid: free_motions.len(),
        unknowns,
        is_symmetric,
        scale,
    };
    for (inverse, vector) in found.ok_or(BodyError::NotConverged)? {
        let share: f64 = rigid.iter().map(|own| dot(own, &vector).powi(2)).sum();
        if share > RIGID {
            all.rigid += 1;
            continue;
        }
        let mut displacements = vec![[0.0; 3]; rows.len()];
        for (own, n) in free.iter().enumerate() {
            for i in 0..D {
                displacements[*n][i] = vector[D * own + i] / masses[*n].sqrt();
            }
        }
        let length = |u: &[f64; 3]| u.iter().map(|x| x * x).sum::<f64>().sqrt();
        let most = displacements.iter().map(length).fold(0.0, f64::max);
        displacements.iter_mut().flatten().for_each(|x| *x /= most);
        all.modes.push(ActualMode {
            squared: inverse.inv() + shift,
            displacements,
        });
    }
    all.modes
        .sort_by(|a, b| a.squared.re.total_cmp(&b.squared.re));
    all.modes.truncate(count);
    Ok(all)
}

fn largest<const D: usize>(matrix: &Rows<D>) -> f64 {
    let all = matrix.0.iter().flatten();
    all.map(|(_, block)| block.amax()).fold(0.0, f64::max)
}

/// Largest difference between an entry and its mirror image.
fn asymmetry<const D: usize>(matrix: &Rows<D>) -> f64 {
    let mirrored = |from: usize, to: u32| {
        let row = &matrix.0[to as usize];
        let at = row.binary_search_by_key(&(from as u32), |(n, _)| *n);
        at.map_or_else(|_| SMatrix::zeros(), |at| row[at].1.transpose())
    };
    let mut most = 0.0_f64;
    for (from, row) in matrix.0.iter().enumerate() {
        for (to, block) in row {
            most = most.max((block - mirrored(from, *to)).amax());
        }
    }
    most
}

/// Shift below all eigenvalues, with the factors for this shift.
fn below_the_spectrum<const D: usize>(
    matrix: &Rows<D>,
    places: &[[f64; 3]],
    scale: f64,
) -> Result<(f64, Factors<D>), BodyError> {
    for trial in 0..TRIALS {
        let shift = -scale * SHIFTS.0 * SHIFTS.1.powi(trial);
        match Factors::new(matrix, places, shift) {
            Ok(factors) => return Ok((shift, factors)),
            Err(NoFactors::Indefinite) => {}
            Err(NoFactors::TooMany) => {
                return Err(BodyError::TooLarge {
                    particles: places.len(),
                });
            }
        }
    }
    Err(BodyError::NotConverged)
}

/// Orthonormal rigid motions of the free particles, times the roots of their masses.
fn rigid_motions<const D: usize>(
    body: &ActualBody<'_>,
    free: &[usize],
    masses: &[f64],
) -> Vec<Vec<f64>> {
    let motion = |at: &dyn Fn(&[f64; 3]) -> [f64; D]| -> Vec<f64> {
        let own = free.iter().map(|n| {
            let root = masses[*n].sqrt();
            at(&body.positions[*n]).map(|x| x * root)
        });
        own.flatten().collect()
    };
    let mut space = Space::default();
    let mut add = |vector: Vec<f64>| {
        if let Some(own) = space.beyond(&vector) {
            space.vectors.push(own);
        }
    };
    for axis in 0..D {
        add(motion(&|_| array_of(|i| f64::from(u8::from(i == axis)))));
        for other in 0..axis {
            add(motion(&|x| {
                array_of(|i| match i {
                    _ if i == axis => x[other],
                    _ if i == other => -x[axis],
                    _ => 0.0,
                })
            }));
        }
    }
    space.vectors
}

/// Orthonormal combinations of vectors that a matrix maps to zero.
fn without_force<const D: usize>(
    matrix: &Rows<D>,
    vectors: &[Vec<f64>],
    scale: f64,
) -> Vec<Vec<f64>> {
    let image = |vector: &Vec<f64>| -> Vec<f64> {
        let of_row = |row: &Vec<(u32, SMatrix<f64, D, D>)>| {
            let terms = row.iter().map(|(to, block)| {
                block * SVector::<f64, D>::from_column_slice(&vector[D * *to as usize..][..D])
            });
            let sum: SVector<f64, D> = terms.sum();
            array_of::<_, D>(|i| sum[i])
        };
        matrix.0.iter().flat_map(of_row).collect()
    };
    let images: Vec<Vec<f64>> = vectors.iter().map(image).collect();
    let images = DMatrix::from_fn(D * matrix.0.len(), vectors.len(), |i, j| images[j][i]);
    let parts = images.svd(false, true);
    let Some(shares) = parts.v_t else {
        return Vec::new();
    };
    let is_null = |n: &usize| parts.singular_values[*n] <= SYMMETRIC * scale;
    let combined = |n: usize| Space::combined(vectors, shares.row(n).transpose().as_slice());
    (0..parts.singular_values.len())
        .filter(is_null)
        .map(combined)
        .collect()
}

/// Eigenvalues of the inverse that belong to the lowest modes, with unit vectors orthogonal to given modes; `None` if they do not converge.
fn largest_of_inverse<const D: usize>(
    factors: &Factors<D>,
    known: &[Vec<f64>],
    unknowns: usize,
    wanted: usize,
    is_symmetric: bool,
) -> Option<Vec<(Complex, Vec<f64>)>> {
    let mut random = 1;
    let mut start: Vec<Vec<f64>> = (0..BLOCK_SIZE)
        .map(|_| {
            (0..unknowns)
                .map(|_| 2.0 * uniform(&mut random) - 1.0)
                .collect()
        })
        .collect();
    let all = unknowns - known.len();
    let wanted = wanted.min(all);
    if wanted == 0 {
        return Some(Vec::new());
    }
    let most = VECTORS.max(4 * wanted).min(all);
    let without_known = |mut vector: Vec<f64>| {
        for own in known {
            let share = dot(own, &vector);
            let both = vector.iter_mut().zip(own);
            both.for_each(|(x, own)| *x -= share * own);
        }
        vector
    };
    for _ in 0..SPACES {
        let mut space = Space::default();
        let mut next = std::mem::take(&mut start);
        let mut checked = 2 * wanted;
        let found = loop {
            let mut images = Vec::new();
            for vector in next {
                crate::cancel::checkpoint();
                let own = space.beyond(&without_known(vector));
                let Some(own) = own.filter(|_| space.vectors.len() < most) else {
                    continue;
                };
                let image = without_known(factors.solved(&own));
                space.add(own, image.clone());
                images.push(image);
            }
            let is_full = images.is_empty() || space.vectors.len() >= most;
            if is_full || space.vectors.len() >= checked {
                checked = space.vectors.len() + 4 * BLOCK_SIZE;
                let found = space.largest_pairs(wanted, is_symmetric)?;
                let has_all = found.len() == wanted;
                let is_exact = space.vectors.len() == all;
                if has_all && (is_exact || found.iter().all(|own| own.missed <= RESIDUAL)) {
                    return Some(
                        found
                            .into_iter()
                            .map(|own| (own.value, own.vector))
                            .collect(),
                    );
                }
                if is_full {
                    break found;
                }
            }
            next = images;
        };
        start = found.into_iter().map(|own| own.vector).collect();
    }
    None
}

/// Approximate eigenvalue with its vector.
struct Ritz {
    value: Complex,
    vector: Vec<f64>,
    /// Residual divided by the eigenvalue.
    missed: f64,
}

impl Space {
    /// Eigenvalues and vectors of the symmetric projection, largest first.
    fn symmetric_pairs(&self) -> Vec<(Complex, DVector<Complex>)> {
        let own = SymmetricEigen::new((&self.within + self.within.transpose()) * 0.5);
        let mut order: Vec<usize> = (0..own.eigenvalues.len()).collect();
        order.sort_by(|a, b| own.eigenvalues[*b].total_cmp(&own.eigenvalues[*a]));
        let pair = |n: usize| {
            let vector = own.eigenvectors.column(n).map(|x| Complex::new(x, 0.0));
            (Complex::new(own.eigenvalues[n], 0.0), vector)
        };
        order.into_iter().map(pair).collect()
    }

    /// Eigenvalues of the projection, largest first, with their vectors. The largest component of a vector is real. One of each complex pair is returned.
    fn any_pairs(&self, wanted: usize) -> Option<Vec<(Complex, DVector<Complex>)>> {
        let within = self.within.map(|x| Complex::new(x, 0.0));
        let (count, size) = (within.nrows(), self.within.amax());
        let mut values = any_eigenvalues(&within)?;
        values.retain(|value| value.im >= -1e-13 * size);
        values.sort_by(|a, b| b.norm().total_cmp(&a.norm()));
        let mut random = 2;
        let mut pair = |value: &Complex| {
            // Inverse iteration; other starts give other vectors of equal eigenvalues.
            let shift = value + Complex::new(1e-13 * size, 0.0);
            let solver = (&within - DMatrix::from_diagonal_element(count, count, shift)).lu();
            let start = |_, _| Complex::new(uniform(&mut random) - 0.5, 0.0);
            let mut vector = DVector::from_fn(count, start);
            for _ in 0..3 {
                vector = solver.solve(&vector)?;
                vector /= Complex::new(vector.norm(), 0.0);
            }
            let largest = vector.iter().max_by(|a, b| a.norm().total_cmp(&b.norm()))?;
            let phase = largest.conj() / largest.norm();
            Some((*value, vector * phase))
        };
        values.iter().take(wanted).map(&mut pair).collect()
    }

    /// Largest Ritz values, with the real parts of their vectors.
    fn largest_pairs(&self, wanted: usize, is_symmetric: bool) -> Option<Vec<Ritz>> {
        let all = match is_symmetric {
            true => self.symmetric_pairs(),
            false => self.any_pairs(wanted)?,
        };
        let ritz = |(value, shares): (Complex, DVector<Complex>)| {
            let parts = [shares.map(|x| x.re), shares.map(|x| x.im)];
            let [re, im] = parts.each_ref().map(|own| {
                [&self.vectors, &self.images].map(|of| Self::combined(of, own.as_slice()))
            });
            // Squared norm of the residual (A - value) (re + i im).
            let missed = (0..re[0].len()).map(|n| {
                let x = Complex::new(re[0][n], im[0][n]);
                (Complex::new(re[1][n], im[1][n]) - value * x).norm_sqr()
            });
            let missed = missed.sum::<f64>().sqrt() / value.norm();
            Some(Ritz {
                value,
                vector: unit(re.into_iter().next()?)?,
                missed,
            })
        };
        let mut found: Vec<Ritz> = all.into_iter().take(wanted).filter_map(ritz).collect();
        found.sort_by(|a, b| b.value.re.total_cmp(&a.value.re));
        Some(found)
    }
}
