//! Finite-element meshes whose nodes are the particles of a crystal.

use super::shape::{ElementShape, Sample};
use crate::algebra::array_of;
use crate::lattice::{BravaisLattice, Crystal, LatticeError, Particle};
use crate::method::{MeshError, MethodError};
use nalgebra::{DMatrix, SMatrix, SVector};

/// Largest distance of node positions, in lattice coordinates, that count as equal.
const NODE_DISTANCE_TOLERANCE: f64 = 1e-6;

/// Periodic mesh of elements of one shape: a crystal of nodes and the elements of one cell, which the lattice repeats.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh<const D: usize> {
    crystal: Crystal<D>,
    shape: ElementShape,
    elements: Vec<Vec<Particle<D>>>,
}

impl<const D: usize> Mesh<D> {
    /// Builds a mesh from the nodes of each element of a cell, in the order defined by [`ElementShape`].
    ///
    /// # Errors
    /// [`MeshError`] if an element does not have the given shape, or if the elements do not fill the cell exactly once.
    pub fn new(
        crystal: Crystal<D>,
        shape: ElementShape,
        elements: Vec<Vec<Particle<D>>>,
    ) -> Result<Self, MeshError> {
        let cell = crystal.lattice().cell_volume();
        let (mesh, sum) = Self::free(crystal, shape, elements)?;
        if (sum - cell).abs() > 1e-9 * cell {
            return Err(MeshError::Volume {
                elements: sum,
                cell,
            });
        }
        Ok(mesh)
    }

    /// Builds a mesh that need not fill the cell, and returns it with the total volume of its elements.
    ///
    /// # Errors
    /// [`MeshError`] if an element does not have the given shape.
    pub(crate) fn free(
        crystal: Crystal<D>,
        shape: ElementShape,
        elements: Vec<Vec<Particle<D>>>,
    ) -> Result<(Self, f64), MeshError> {
        let mesh = Self {
            crystal,
            shape,
            elements,
        };
        let sum = mesh.check()?;
        Ok((mesh, sum))
    }

    /// Mesh with one element per cell, the parallelepiped spanned by the primitive vectors: bars, quadrilaterals or bricks.
    ///
    /// ```
    /// use onset::lattice::LatticeKind;
    /// use onset::scheme::element::Mesh;
    /// let squares = Mesh::parallelepipeds(LatticeKind::Square.lattice::<2>(1.0)?);
    /// assert_eq!(squares.elements().len(), 1);
    /// # Ok::<(), onset::lattice::LatticeError>(())
    /// ```
    pub fn parallelepipeds(lattice: BravaisLattice<D>) -> Self {
        let node = |n: usize| Particle {
            site: 0,
            cell: array_of(|i| (n >> i & 1) as i32),
        };
        Self {
            crystal: Crystal::of_lattice(lattice),
            shape: ElementShape::Multilinear,
            elements: vec![(0..1 << D).map(node).collect()],
        }
    }

    /// Mesh of the parallelepipeds split into `D!` simplices along the diagonal `a_1 + ... + a_D` (Kuhn).
    ///
    /// Each simplex runs from the origin to the opposite corner along the primitive vectors, in one of their orders. The faces of neighboring
    /// simplices match.
    pub fn simplices(lattice: BravaisLattice<D>) -> Self {
        let path = |order: &[usize]| {
            let mut cell = [0; D];
            let mut nodes = vec![Particle::home(0)];
            for axis in order {
                cell[*axis] += 1;
                nodes.push(Particle { site: 0, cell });
            }
            nodes
        };
        Self {
            crystal: Crystal::of_lattice(lattice),
            shape: ElementShape::Simplex,
            elements: orders(D).iter().map(|order| path(order)).collect(),
        }
    }

    /// Mesh of simplices given by their corners in lattice coordinates. Every corner must be a particle.
    pub(super) fn of_corners(
        crystal: Crystal<D>,
        elements: &[Vec<SVector<f64, D>>],
    ) -> Result<Self, MethodError> {
        let node = |corner: &SVector<f64, D>| {
            let cell_of = |site: &SVector<f64, D>| (corner - site).map(f64::round);
            let apart = |site: &SVector<f64, D>| (corner - site - cell_of(site)).amax();
            let sites = crystal.sites().iter().enumerate();
            let (site, place) = sites.min_by(|a, b| apart(a.1).total_cmp(&apart(b.1)))?;
            let cell = cell_of(place);
            Some(Particle {
                site,
                cell: array_of(|i| cell[i] as i32),
            })
        };
        let nodes = |corners: &Vec<SVector<f64, D>>| corners.iter().filter_map(node).collect();
        let elements = elements.iter().map(nodes).collect();
        Ok(Self::new(crystal, ElementShape::Simplex, elements)?)
    }

    /// Returns this mesh of linear elements with further nodes in the middles of the edges, as a mesh of quadratic elements.
    ///
    /// # Errors
    /// [`MethodError::Lattice`] if the nodes do not make a crystal, [`MethodError::Mesh`] if the elements are quadratic already.
    pub fn quadratic(&self) -> Result<Self, MethodError> {
        let shape = match self.shape {
            ElementShape::Simplex => ElementShape::QuadraticSimplex,
            ElementShape::Multilinear => ElementShape::Serendipity,
            other => other,
        };
        let mut sites = self.crystal.sites().to_vec();
        let place = |node: &Particle<D>| {
            self.crystal.sites()[node.site] + SVector::from(node.cell.map(f64::from))
        };
        let mut elements = self.elements.clone();
        for nodes in &mut elements {
            for [a, b] in self.shape.edges::<D>() {
                let middle = (place(&nodes[a]) + place(&nodes[b])) * 0.5;
                let cell_of = |site: &SVector<f64, D>| (middle - site).map(f64::round);
                let is_there = |site: &SVector<f64, D>| {
                    (middle - site - cell_of(site)).amax() < NODE_DISTANCE_TOLERANCE
                };
                let site = sites.iter().position(is_there).unwrap_or_else(|| {
                    let inside = middle.map(|x| x - (x + NODE_DISTANCE_TOLERANCE).floor());
                    sites.push(inside);
                    sites.len() - 1
                });
                let cell = cell_of(&sites[site]);
                nodes.push(Particle {
                    site,
                    cell: array_of(|i| cell[i] as i32),
                });
            }
        }
        let crystal = Crystal::new(*self.crystal.lattice(), sites)?;
        let crystal = crystal.with_spacing(0.5 * self.crystal.spacing());
        Ok(Self::new(crystal, shape, elements)?)
    }

    /// Integrals `int N_a N_b dV` over an element; length^D.
    pub(super) fn products(&self, nodes: &[Particle<D>]) -> DMatrix<f64> {
        self.shape
            .products(&self.positions(nodes), &self.samples(nodes))
    }

    fn positions(&self, nodes: &[Particle<D>]) -> Vec<SVector<f64, D>> {
        let positions = nodes.iter().map(|node| self.crystal.position(node));
        positions.collect()
    }

    /// Crystal of the nodes.
    pub fn crystal(&self) -> &Crystal<D> {
        &self.crystal
    }

    /// Shape of the elements.
    pub fn shape(&self) -> ElementShape {
        self.shape
    }

    /// Elements of a cell, each as a list of nodes.
    pub fn elements(&self) -> &[Vec<Particle<D>>] {
        &self.elements
    }

    /// Returns this mesh in a supercell of `counts` cells along each primitive vector.
    ///
    /// # Errors
    /// [`MethodError::Lattice`] if a count is zero.
    pub fn supercell(&self, counts: [usize; D]) -> Result<Self, MethodError> {
        let crystal = self.crystal.supercell(counts)?;
        let sites = self.crystal.sites().len();
        // Sites of the supercell are numbered cell by cell, the first coordinate varying fastest.
        let renamed = |node: &Particle<D>| {
            let of = |i: usize| (node.cell[i], counts[i] as i32);
            let small = (0..D).rev().fold(0, |sum, i| {
                let (n, count) = of(i);
                sum * counts[i] + n.rem_euclid(count) as usize
            });
            Particle {
                site: small * sites + node.site,
                cell: array_of(|i| of(i).0.div_euclid(of(i).1)),
            }
        };
        let high = counts.map(|count| count as i32 - 1);
        let mut elements = Vec::new();
        for origin in crate::lattice::cells_between(&[0; D], &high) {
            for nodes in &self.elements {
                let moved = nodes.iter().map(|node| renamed(&node.moved(&origin)));
                elements.push(moved.collect());
            }
        }
        Ok(Self {
            crystal,
            shape: self.shape,
            elements,
        })
    }

    /// Returns the image of this mesh under a linear map of space, for example a shear.
    ///
    /// # Errors
    /// [`MethodError::Lattice`] if the map is singular.
    pub fn mapped(&self, map: &SMatrix<f64, D, D>) -> Result<Self, MethodError> {
        let vectors = map * self.crystal.lattice().vectors();
        let lattice = BravaisLattice::new(vectors).ok_or_else(|| LatticeError::Dependent {
            vectors: map.iter().copied().collect(),
        })?;
        let crystal = Crystal::new(lattice, self.crystal.sites().to_vec())?;
        let crystal = crystal.with_spacing(self.crystal.spacing());
        Ok(Self::new(crystal, self.shape, self.elements.clone())?)
    }

    /// Returns this mesh with every node of a cell displaced at random; see [`Crystal::perturbed`].
    ///
    /// # Errors
    /// [`MethodError::Lattice`] if two nodes coincide, [`MethodError::Mesh`] if an element is inverted.
    pub fn perturbed(&self, amplitude: f64, seed: u64) -> Result<Self, MethodError> {
        let crystal = self.crystal.perturbed(amplitude, seed)?;
        Ok(Self::new(crystal, self.shape, self.elements.clone())?)
    }

    /// Integration points of an element; empty if the element is flat.
    pub(super) fn samples(&self, nodes: &[Particle<D>]) -> Vec<Sample<D>> {
        self.shape
            .samples(&self.positions(nodes))
            .unwrap_or_default()
    }

    /// Checks the elements, and returns their volume.
    fn check(&self) -> Result<f64, MeshError> {
        let needed = self.shape.nodes::<D>();
        let sites = self.crystal.sites().len();
        let mut sum = 0.0;
        for (element, nodes) in self.elements.iter().enumerate() {
            if nodes.len() != needed {
                let nodes = nodes.len();
                return Err(MeshError::NodeCount {
                    element,
                    nodes,
                    needed,
                });
            }
            if let Some(node) = nodes.iter().find(|node| node.site >= sites) {
                return Err(MeshError::UnknownSite {
                    element,
                    site: node.site,
                    last: sites - 1,
                });
            }
            let volumes = self.samples(nodes).into_iter().map(|sample| sample.volume);
            let volumes: Vec<f64> = volumes.collect();
            let least = 1e-9 * self.crystal.lattice().cell_volume() / sites as f64;
            let is_sound = |sign: f64| volumes.iter().all(|volume| sign * volume > least);
            if volumes.is_empty() || !(is_sound(1.0) || is_sound(-1.0)) {
                return Err(MeshError::Distorted { element });
            }
            sum += volumes.iter().map(|volume| volume.abs()).sum::<f64>();
        }
        Ok(sum)
    }
}

/// All permutations of the first `count` numbers.
fn orders(count: usize) -> Vec<Vec<usize>> {
    let Some(last) = count.checked_sub(1) else {
        return vec![Vec::new()];
    };
    let with_last = |order: Vec<usize>| {
        (0..=order.len()).map(move |at| {
            let mut longer = order.clone();
            longer.insert(at, last);
            longer
        })
    };
    orders(last).into_iter().flat_map(with_last).collect()
}
