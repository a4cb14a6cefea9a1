//! Named meshes of finite elements.

use super::mesh::Mesh;
use crate::lattice::{BravaisLattice, Crystal, LatticeError};
use crate::method::MethodError;
use nalgebra::{SMatrix, SVector};

/// Named pattern of elements. `spacing` is the distance between neighboring nodes.
///
/// The spacing is the side of the squares, cubes or triangles of the pattern, or half of a diagonal if a node lies at the center.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum ElementMesh {
    /// In one dimension: bars of two nodes.
    Bars,
    /// In two dimensions: squares of four nodes (Q4).
    Quadrilaterals,
    /// Squares split in two along the same diagonal (T3).
    Triangles,
    /// Squares split in two along alternating diagonals, as on a chessboard; two nodes per cell.
    TrianglesAlternating,
    /// Squares split in four by both diagonals, with a node at their intersection; two nodes per cell.
    TrianglesCrossed,
    /// Equilateral triangles on the hexagonal lattice.
    TrianglesEquilateral,
    /// In three dimensions: cubes of eight nodes (H8).
    Bricks,
    /// Cubes split in six along the same diagonal (Kuhn).
    Tetrahedra,
    /// Cubes split in five, alternately in one way and in its mirror image; two nodes per cell.
    TetrahedraAlternating,
    /// Tetrahedra of two long and four short edges on the body-centered cubic lattice.
    TetrahedraBodyCentered,
}

impl ElementMesh {
    /// All named meshes, by dimension.
    pub const ALL: [Self; 10] = [
        Self::Bars,
        Self::Quadrilaterals,
        Self::Triangles,
        Self::TrianglesAlternating,
        Self::TrianglesCrossed,
        Self::TrianglesEquilateral,
        Self::Bricks,
        Self::Tetrahedra,
        Self::TetrahedraAlternating,
        Self::TetrahedraBodyCentered,
    ];

    /// Number of space dimensions.
    pub fn dimension(self) -> usize {
        match self {
            Self::Bars => 1,
            Self::Quadrilaterals
            | Self::Triangles
            | Self::TrianglesAlternating
            | Self::TrianglesCrossed
            | Self::TrianglesEquilateral => 2,
            Self::Bricks
            | Self::Tetrahedra
            | Self::TetrahedraAlternating
            | Self::TetrahedraBodyCentered => 3,
        }
    }

    /// Name in study files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bars => "bars",
            Self::Quadrilaterals => "quadrilaterals",
            Self::Triangles => "triangles",
            Self::TrianglesAlternating => "triangles-alternating",
            Self::TrianglesCrossed => "triangles-crossed",
            Self::TrianglesEquilateral => "triangles-equilateral",
            Self::Bricks => "bricks",
            Self::Tetrahedra => "tetrahedra",
            Self::TetrahedraAlternating => "tetrahedra-alternating",
            Self::TetrahedraBodyCentered => "tetrahedra-body-centered",
        }
    }

    /// Returns the mesh with the given spacing.
    ///
    /// # Errors
    /// [`MethodError::Lattice`] if the spacing is not positive and finite, or if `D` is not the dimension of the mesh.
    pub fn mesh<const D: usize>(self, spacing: f64) -> Result<Mesh<D>, MethodError> {
        if self.dimension() != D {
            return Err(MethodError::Lattice(LatticeError::Dimension {
                lattice: self.name(),
                actual: self.dimension(),
                requested: D,
            }));
        }
        let lattice = self.lattice::<D>(spacing)?;
        match self {
            Self::Bars | Self::Quadrilaterals | Self::Bricks => Ok(Mesh::parallelepipeds(lattice)),
            Self::Triangles
            | Self::TrianglesEquilateral
            | Self::Tetrahedra
            | Self::TetrahedraBodyCentered => Ok(Mesh::simplices(lattice)),
            Self::TrianglesCrossed => {
                let sites = [0.0, 0.5].map(SVector::repeat).to_vec();
                let crystal = Crystal::new(lattice, sites)?;
                let corner =
                    |n: usize| SVector::from_fn(|i, _| f64::from([0, 1, 3, 2][n % 4] >> i & 1));
                let triangle = |n: usize| vec![corner(n), corner(n + 1), SVector::repeat(0.5)];
                Mesh::of_corners(crystal, &(0..4).map(triangle).collect::<Vec<_>>())
            }
            Self::TrianglesAlternating | Self::TetrahedraAlternating => {
                alternating(lattice, spacing)
            }
        }
    }

    fn lattice<const D: usize>(self, spacing: f64) -> Result<BravaisLattice<D>, MethodError> {
        let half = 0.5 * 3.0_f64.sqrt();
        let third = 1.0_f64 / 3.0;
        let entry = |i: usize, j: usize| match (self, i, j) {
            // The second vector is at 120 degrees, so that the sum of both is the short diagonal.
            (Self::TrianglesEquilateral, 0, 1) => -0.5,
            (Self::TrianglesEquilateral, 1, 1) => half,
            // Half of the space diagonals of a cube.
            (Self::TetrahedraBodyCentered, i, j) if i == j => -third.sqrt(),
            (Self::TetrahedraBodyCentered, ..) => third.sqrt(),
            (Self::TrianglesCrossed, i, j) => 2.0_f64.sqrt() * f64::from(u8::from(i == j)),
            // One step along the first axis for each step along another: every vector except the first preserves the color of the chessboard.
            (Self::TrianglesAlternating | Self::TetrahedraAlternating, 0, _) => 1.0,
            (_, i, j) => f64::from(u8::from(i == j)),
        };
        let vectors = SMatrix::from_fn(|i, j| spacing * entry(i, j));
        (spacing > 0.0 && spacing.is_finite())
            .then(|| BravaisLattice::new(vectors))
            .flatten()
            .filter(|lattice| lattice.cell_volume().is_normal())
            .ok_or(MethodError::Lattice(LatticeError::Spacing {
                value: spacing,
            }))
    }
}

/// Cubes of two colors: the simplex (in 2D, the diagonal) between their white corners, and one simplex at each black corner. `lattice` is cubic.
fn alternating<const D: usize>(
    lattice: BravaisLattice<D>,
    spacing: f64,
) -> Result<Mesh<D>, MethodError> {
    let mut counts = [1; D];
    counts[0] = 2;
    let crystal = Crystal::of_lattice(lattice).supercell(counts)?;
    let is_white = |corner: &SVector<f64, D>| corner.sum().rem_euclid(2.0) < 0.5;
    let mut elements = Vec::new();
    for color in 0..2 {
        let corner = |n: usize| {
            let origin = |i: usize| if i == 0 { color } else { 0 };
            SVector::<f64, D>::from_fn(|i, _| (origin(i) + (n >> i & 1)) as f64)
        };
        let (white, black): (Vec<usize>, Vec<usize>) =
            (0..1 << D).partition(|n| is_white(&corner(*n)));
        if white.len() == D + 1 {
            elements.push(white.iter().map(|n| corner(*n)).collect());
        }
        for n in black {
            let beside = (0..D).map(|i| corner(n ^ (1 << i)));
            elements.push(std::iter::once(corner(n)).chain(beside).collect());
        }
    }
    let to_fractional = crystal.lattice().reciprocal().transpose() / std::f64::consts::TAU;
    let in_cell = |corner: &SVector<f64, D>| to_fractional * corner * spacing;
    let elements: Vec<Vec<SVector<f64, D>>> = elements
        .iter()
        .map(|corners: &Vec<SVector<f64, D>>| corners.iter().map(in_cell).collect())
        .collect();
    Mesh::of_corners(crystal, &elements)
}
