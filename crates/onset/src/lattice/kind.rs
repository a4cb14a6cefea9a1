//! Named lattices and their geometry.

use super::reduction::ELONGATION_RATIO;
use super::{BravaisLattice, Fractional, LatticeError, Reduced};
use nalgebra::{SMatrix, SVector};

/// Kind of lattice of the particles: a Bravais lattice with one or two particles in each cell.
///
/// The centers of the Delaunay cells ([`super::delaunay_centers`]) are possible positions of stress points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum LatticeKind {
    /// One dimension: equally spaced particles.
    Chain,
    /// Two dimensions: squares with sides along the axes.
    Square,
    /// Two dimensions: rectangles with sides along the axes, with a given aspect ratio.
    Rectangular,
    /// Two dimensions: equilateral triangles with rows along the first axis.
    Hexagonal,
    /// Two dimensions: hexagons with a particle at each corner, two in a cell.
    Honeycomb,
    /// Two dimensions: arbitrary primitive vectors.
    Oblique,
    /// Three dimensions: cubes with edges along the axes.
    SimpleCubic,
    /// Three dimensions: cubes with edges along the axes and an additional particle in the center of each.
    BodyCenteredCubic,
    /// Three dimensions: cubes with edges along the axes and an additional particle in the center of each face; a closest packing.
    FaceCenteredCubic,
    /// Three dimensions: triangular layers, with every second layer at the same positions, two particles in a cell; the second closest packing.
    HexagonalClosePacked,
    /// Three dimensions: every particle at the center of four neighbors, two in a cell.
    Diamond,
    /// Three dimensions: arbitrary primitive vectors.
    Triclinic,
}

/// Corners of a path through the zone: names, and wave vectors in units of the reciprocal vectors.
type Corners = &'static [(&'static str, [f64; 3])];

impl LatticeKind {
    /// All kinds of lattices, sorted by dimension.
    pub const ALL: [Self; 12] = [
        Self::Chain,
        Self::Square,
        Self::Rectangular,
        Self::Hexagonal,
        Self::Honeycomb,
        Self::Oblique,
        Self::SimpleCubic,
        Self::BodyCenteredCubic,
        Self::FaceCenteredCubic,
        Self::HexagonalClosePacked,
        Self::Diamond,
        Self::Triclinic,
    ];

    /// Number of space dimensions.
    pub fn dimension(self) -> usize {
        match self {
            Self::Chain => 1,
            Self::Square
            | Self::Rectangular
            | Self::Hexagonal
            | Self::Honeycomb
            | Self::Oblique => 2,
            Self::SimpleCubic
            | Self::BodyCenteredCubic
            | Self::FaceCenteredCubic
            | Self::HexagonalClosePacked
            | Self::Diamond
            | Self::Triclinic => 3,
        }
    }

    /// Name used in study files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Chain => "chain",
            Self::Square => "square",
            Self::Rectangular => "rectangular",
            Self::Hexagonal => "hexagonal",
            Self::Honeycomb => "honeycomb",
            Self::Oblique => "oblique",
            Self::SimpleCubic => "simple-cubic",
            Self::BodyCenteredCubic => "body-centered-cubic",
            Self::FaceCenteredCubic => "face-centered-cubic",
            Self::HexagonalClosePacked => "hexagonal-close-packed",
            Self::Diamond => "diamond",
            Self::Triclinic => "triclinic",
        }
    }

    /// Positions of the particles of a cell, in lattice coordinates.
    pub fn sites<const D: usize>(self) -> Vec<Fractional<D>> {
        let second: Option<[f64; 3]> = match self {
            Self::Honeycomb => Some([1.0 / 3.0, 1.0 / 3.0, 0.0]),
            Self::HexagonalClosePacked => Some([1.0 / 3.0, 1.0 / 3.0, 0.5]),
            Self::Diamond => Some([0.25; 3]),
            _ => None,
        };
        let places = std::iter::once([0.0; 3]).chain(second);
        places
            .map(|place| SVector::from_fn(|i, _| place[i]))
            .collect()
    }

    /// Returns true if the primitive vectors must be given.
    pub fn takes_vectors(self) -> bool {
        matches!(self, Self::Oblique | Self::Triclinic)
    }

    /// Bravais lattice of a kind without parameters, with the given distance of nearest neighbors.
    ///
    /// ```
    /// use onset::lattice::LatticeKind;
    /// // Closest packing: a ball in each cell of spacing^3 / sqrt(2).
    /// let lattice = LatticeKind::FaceCenteredCubic.lattice::<3>(2.0)?;
    /// assert!((lattice.cell_volume() - 32.0_f64.sqrt()).abs() < 1e-14);
    /// # Ok::<(), onset::lattice::LatticeError>(())
    /// ```
    ///
    /// # Errors
    /// [`LatticeError`] if the spacing is not positive and finite, if `D` is not the dimension of the lattice, or if primitive vectors must be given.
    pub fn lattice<const D: usize>(self, spacing: f64) -> Result<BravaisLattice<D>, LatticeError> {
        self.lattice_with(spacing, 1.0, &[])
    }

    /// Lattice with the given distance of nearest neighbors and the parameters of its kind.
    ///
    /// Rectangles have the sides `spacing` and `aspect spacing`. `vectors` contains the components of the primitive vectors of
    /// [`LatticeKind::Oblique`] and [`LatticeKind::Triclinic`] in units of the spacing, one vector after the other. Parameters that a kind does not
    /// use are ignored.
    ///
    /// # Errors
    /// [`LatticeError`] if spacing or aspect ratio are not positive and finite, if `D` is not the dimension of the lattice, or if the primitive
    /// vectors have a wrong number of components or do not span space.
    pub fn lattice_with<const D: usize>(
        self,
        spacing: f64,
        aspect: f64,
        vectors: &[f64],
    ) -> Result<BravaisLattice<D>, LatticeError> {
        let lattice = self.name();
        if self.dimension() != D {
            return Err(LatticeError::Dimension {
                lattice,
                actual: self.dimension(),
                requested: D,
            });
        }
        if self == Self::Rectangular && !(aspect > 0.0 && aspect.is_finite()) {
            return Err(LatticeError::Aspect { value: aspect });
        }
        let dependent = || LatticeError::Dependent {
            vectors: vectors.to_vec(),
        };
        if self.takes_vectors() {
            if vectors.len() != D * D {
                return Err(LatticeError::Vectors {
                    lattice,
                    expected: D * D,
                    given: vectors.len(),
                });
            }
            // Ratio of the volume of a cell of short vectors to the volume of a box with equal edges.
            let unit = SMatrix::<f64, D, D>::from_fn(|i, j| vectors[D * j + i]);
            let flatness = |m: &SMatrix<f64, D, D>| {
                let edges: f64 = m.column_iter().map(|a| a.norm()).product();
                super::determinant(m).abs() / edges
            };
            let short = match Reduced::of(&unit) {
                // For parallel vectors rounding produces ever shorter vectors.
                Err(_) if flatness(&unit) < 1e-15 => return Err(dependent()),
                other => other?.vectors,
            };
            if flatness(&short).is_nan() || flatness(&short) <= 1e-9 {
                return Err(dependent());
            }
        }
        let columns = SMatrix::<f64, D, D>::from_fn(|i, j| {
            spacing * self.component(i, j, aspect, vectors, D)
        });
        let short = Reduced::of(&columns)?.vectors;
        let lengths = short.column_iter().map(|a| a.norm());
        let ratio = lengths.clone().fold(0.0, f64::max) / lengths.fold(f64::INFINITY, f64::min);
        if ratio > ELONGATION_RATIO {
            return Err(LatticeError::Elongated {
                ratio,
                limit: ELONGATION_RATIO,
            });
        }
        // A spacing whose powers overflow or underflow is as invalid as a negative one.
        (spacing > 0.0 && spacing.is_finite())
            .then(|| BravaisLattice::new(columns))
            .flatten()
            .filter(|lattice| lattice.cell_volume().is_normal())
            .ok_or(LatticeError::Spacing { value: spacing })
    }

    /// Component `i` of primitive vector `j` in units of the spacing.
    fn component(self, i: usize, j: usize, aspect: f64, vectors: &[f64], dimension: usize) -> f64 {
        let diagonal = f64::from(u8::from(i == j));
        match self {
            Self::Chain | Self::Square | Self::SimpleCubic => diagonal,
            Self::Rectangular if j == 1 => aspect * diagonal,
            Self::Rectangular => diagonal,
            Self::Hexagonal => match (i, j) {
                (0, 1) => 0.5,
                (1, 1) => 0.5 * 3.0_f64.sqrt(),
                _ => diagonal,
            },
            // Vectors between hexagons have length sqrt(3) in units of the side.
            Self::Honeycomb => match (i, j) {
                (0, 0) => 3.0_f64.sqrt(),
                (0, 1) => 0.5 * 3.0_f64.sqrt(),
                (1, 1) => 1.5,
                _ => 0.0,
            },
            // c/a = sqrt(8/3), for which all twelve neighbors have equal distance.
            Self::HexagonalClosePacked => match (i, j) {
                (0, 1) => 0.5,
                (1, 1) => 0.5 * 3.0_f64.sqrt(),
                (2, 2) => (8.0_f64 / 3.0).sqrt(),
                _ => diagonal,
            },
            // As face-centered cubic, with neighbors at a quarter of the cube's diagonal.
            Self::Diamond => 2.0 * (1.0 - diagonal) / 3.0_f64.sqrt(),
            // Half of the cube diagonals nearest to the axes; the edge is 2 / sqrt(3).
            Self::BodyCenteredCubic => (1.0 - 2.0 * diagonal) / 3.0_f64.sqrt(),
            // Half of the diagonals of the faces; the edge is sqrt(2).
            Self::FaceCenteredCubic => (1.0 - diagonal) / 2.0_f64.sqrt(),
            Self::Oblique | Self::Triclinic => vectors[dimension * j + i],
        }
    }

    /// Named points of the boundary of the zone, in the order of the standard path for dispersion diagrams, as wave vectors in units of the
    /// reciprocal vectors.
    ///
    /// Names in three dimensions follow Setyawan and Curtarolo, Comput. Mater. Sci. 49 (2010) 299.
    pub fn zone_path<const D: usize>(self) -> Vec<(&'static str, Fractional<D>)> {
        let points: Corners = match self {
            Self::Chain => &[("Γ", [0.0; 3]), ("X", [0.5, 0.0, 0.0])],
            Self::Square => &[
                ("Γ", [0.0; 3]),
                ("X", [0.5, 0.0, 0.0]),
                ("M", [0.5, 0.5, 0.0]),
                ("Γ", [0.0; 3]),
            ],
            Self::Rectangular => &[
                ("Γ", [0.0; 3]),
                ("X", [0.5, 0.0, 0.0]),
                ("S", [0.5, 0.5, 0.0]),
                ("Y", [0.0, 0.5, 0.0]),
                ("Γ", [0.0; 3]),
                ("S", [0.5, 0.5, 0.0]),
            ],
            Self::Hexagonal | Self::Honeycomb => &[
                ("Γ", [0.0; 3]),
                ("M", [0.5, 0.0, 0.0]),
                ("K", [2.0 / 3.0, 1.0 / 3.0, 0.0]),
                ("Γ", [0.0; 3]),
            ],
            Self::Oblique => &[
                ("Γ", [0.0; 3]),
                ("X", [0.5, 0.0, 0.0]),
                ("M", [0.5, 0.5, 0.0]),
                ("Y", [0.0, 0.5, 0.0]),
                ("Γ", [0.0; 3]),
                ("M", [0.5, 0.5, 0.0]),
            ],
            Self::SimpleCubic => &[
                ("Γ", [0.0; 3]),
                ("X", [0.0, 0.5, 0.0]),
                ("M", [0.5, 0.5, 0.0]),
                ("Γ", [0.0; 3]),
                ("R", [0.5; 3]),
                ("X", [0.0, 0.5, 0.0]),
            ],
            Self::BodyCenteredCubic => &[
                ("Γ", [0.0; 3]),
                ("H", [0.5, -0.5, 0.5]),
                ("N", [0.0, 0.0, 0.5]),
                ("Γ", [0.0; 3]),
                ("P", [0.25; 3]),
                ("H", [0.5, -0.5, 0.5]),
            ],
            Self::FaceCenteredCubic | Self::Diamond => &[
                ("Γ", [0.0; 3]),
                ("X", [0.5, 0.0, 0.5]),
                ("W", [0.5, 0.25, 0.75]),
                ("L", [0.5; 3]),
                ("Γ", [0.0; 3]),
                ("K", [0.375, 0.375, 0.75]),
            ],
            Self::HexagonalClosePacked => &[
                ("Γ", [0.0; 3]),
                ("M", [0.5, 0.0, 0.0]),
                ("K", [2.0 / 3.0, 1.0 / 3.0, 0.0]),
                ("Γ", [0.0; 3]),
                ("A", [0.0, 0.0, 0.5]),
                ("L", [0.5, 0.0, 0.5]),
                ("H", [2.0 / 3.0, 1.0 / 3.0, 0.5]),
                ("A", [0.0, 0.0, 0.5]),
            ],
            Self::Triclinic => &[
                ("X", [0.5, 0.0, 0.0]),
                ("Γ", [0.0; 3]),
                ("Y", [0.0, 0.5, 0.0]),
                ("L", [0.5, 0.5, 0.0]),
                ("Γ", [0.0; 3]),
                ("Z", [0.0, 0.0, 0.5]),
                ("N", [0.5, 0.0, 0.5]),
                ("Γ", [0.0; 3]),
                ("M", [0.0, 0.5, 0.5]),
                ("R", [0.5; 3]),
                ("Γ", [0.0; 3]),
            ],
        };
        points
            .iter()
            .map(|(name, k)| (*name, SVector::from_fn(|i, _| k[i])))
            .collect()
    }
}
