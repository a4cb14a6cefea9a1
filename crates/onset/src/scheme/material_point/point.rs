//! Interaction of the nodes around a material point.

use super::functions::{Profile, Stretch};
use crate::algebra::array_of;
use crate::kinematics::DeformationGradient;
use crate::lattice::Particle;
use crate::material::Hyperelastic;
use crate::method::MethodError;
use crate::real::Real;
use crate::scheme::{Interaction, Motion, PointResponse};
use nalgebra::{DMatrix, SMatrix, SVector};

/// Grid in a homogeneous state of a material.
#[derive(Clone, Copy)]
pub(super) struct State<'a, const D: usize> {
    pub(super) response: PointResponse<'a, D>,
    /// Maps vectors in the current configuration to lattice coordinates of the grid.
    pub(super) to_grid: SMatrix<f64, D, D>,
    /// Primitive vectors of the grid in this state.
    vectors: SMatrix<f64, D, D>,
    /// Whether points and functions move with the nodes, and the grid is reset at each step.
    pub(super) is_updated: bool,
}

impl<'a, const D: usize> State<'a, D> {
    /// Builds the state. `vectors` are the primitive vectors of the grid in this state.
    pub(super) fn new(
        material: &'a dyn Hyperelastic,
        f: &DeformationGradient,
        vectors: &SMatrix<f64, D, D>,
        is_updated: bool,
    ) -> Result<Self, MethodError> {
        let inverse = DMatrix::from_fn(D, D, |i, j| vectors[(i, j)])
            .try_inverse()
            .ok_or(MethodError::NotFinite)?;
        Ok(Self {
            response: PointResponse::new(material, f)?,
            to_grid: SMatrix::from_fn(|i, j| inverse[(i, j)]),
            vectors: *vectors,
            is_updated,
        })
    }

    /// Converts slopes with respect to lattice coordinates to a gradient in the current configuration.
    pub(super) fn gradient<R: Real>(&self, slope: &[R; D]) -> [R; D] {
        let zero = R::constant(0.0);
        let along = |i: usize| (0..D).fold(zero, |sum, j| sum + slope[j] * self.to_grid[(j, i)]);
        array_of(along)
    }

    /// Deformation `G (1 + L) G^-1` in lattice coordinates of the grid for a displacement gradient `L`.
    pub(super) fn stretch<R: Real>(&self, l: &[[R; D]; D]) -> Stretch<R, D> {
        let (to_grid, vectors) = (&self.to_grid, &self.vectors);
        let entry = |i: usize, j: usize| {
            let mut sum = R::constant(f64::from(u8::from(i == j)));
            for m in 0..D {
                for n in 0..D {
                    sum = sum + l[m][n] * (to_grid[(i, m)] * vectors[(n, j)]);
                }
            }
            sum
        };
        array_of(|i| array_of(|j| entry(i, j)))
    }

    /// Energy density `W` at the displacement gradient `L` on the grid, `F = (1 + L) F0`; energy/volume. NaN if the law is not defined there.
    pub(super) fn energy(&self, l: &[[f64; D]; D]) -> f64 {
        self.response.energy(&moved(l, &self.response.leading()))
    }

    /// Stress that is multiplied by the volume, at the displacement gradient `L` on the grid.
    ///
    /// Total-Lagrangian: `P` at `F = F0 + L`. Updated: `J sigma = P F^T` at `F = (1 + L) F0`.
    pub(super) fn stress<R: Real>(&self, l: &[[R; D]; D]) -> [[R; D]; D] {
        let base = self.response.leading::<f64>();
        let zero = R::constant(0.0);
        if !self.is_updated {
            let f = array_of(|i| array_of(|j| l[i][j] + base[i][j]));
            return self.response.first_piola(&f);
        }
        let f = moved(l, &base);
        let stress = self.response.first_piola(&f);
        let product = |i: usize, j: usize| (0..D).fold(zero, |sum, m| sum + stress[i][m] * f[j][m]);
        array_of(|i| array_of(|j| product(i, j)))
    }
}

/// Returns the deformation gradient `(1 + L) F0`.
fn moved<R: Real, const D: usize>(l: &[[R; D]; D], base: &[[f64; D]; D]) -> [[R; D]; D] {
    let entry = |i: usize, j: usize| {
        (0..D).fold(R::constant(base[i][j]), |sum, m| sum + l[i][m] * base[m][j])
    };
    array_of(|i| array_of(|j| entry(i, j)))
}

/// Material point of the cell at the origin with its nodes.
#[derive(Clone)]
pub(super) struct Point<'a, const D: usize> {
    state: State<'a, D>,
    profile: &'a Profile,
    /// Position of the point in lattice coordinates of the grid.
    place: SVector<f64, D>,
    volume: f64,
    nodes: Vec<Particle<D>>,
    /// Functions and gradients in the homogeneous state.
    shapes: Vec<(f64, [f64; D])>,
}

impl<'a, const D: usize> Point<'a, D> {
    pub(super) fn new(
        state: State<'a, D>,
        profile: &'a Profile,
        place: SVector<f64, D>,
        volume: f64,
    ) -> Self {
        let at: [f64; D] = place.into();
        let nodes = profile.nodes(&at);
        let shape = |node: &[i32; D]| {
            let shape = profile.shape(&at, node);
            (shape.value, state.gradient(&shape.slope))
        };
        Self {
            shapes: nodes.iter().map(shape).collect(),
            nodes: nodes
                .iter()
                .map(|cell| Particle {
                    site: 0,
                    cell: *cell,
                })
                .collect(),
            state,
            profile,
            place,
            volume,
        }
    }

    /// Gradients of the functions at the displaced point, whose particle has the displacement gradient `L`.
    fn moved_gradients<R: Real>(&self, displacements: &[[R; D]], l: &[[R; D]; D]) -> Vec<[R; D]> {
        let mut moved = [R::constant(0.0); D];
        for (u, (value, _)) in displacements.iter().zip(&self.shapes) {
            moved = array_of(|i| moved[i] + u[i] * *value);
        }
        let start: [f64; D] = self.place.into();
        let along = |i: usize| {
            let base = R::constant(start[i]);
            (0..D).fold(base, |sum, j| sum + moved[j] * self.state.to_grid[(i, j)])
        };
        let place: [R; D] = array_of(along);
        let stretch = self.state.stretch(l);
        let gradient = |node: &Particle<D>| {
            let shape = self.profile.shape_of(&place, &node.cell, &stretch);
            self.state.gradient(&shape.slope)
        };
        self.nodes.iter().map(gradient).collect()
    }
}

impl<const D: usize> Interaction<D> for Point<'_, D> {
    fn particles(&self) -> &[Particle<D>] {
        &self.nodes
    }

    fn forces<R: Real>(&self, motion: Motion<'_, R, D>) -> Vec<[R; D]> {
        let displacements = motion.displacements;
        let fixed = |(_, gradient): &(f64, [f64; D])| gradient.map(R::constant);
        let resting: Vec<[R; D]> = self.shapes.iter().map(fixed).collect();
        let mut l = [[R::constant(0.0); D]; D];
        for (u, gradient) in displacements.iter().zip(&resting) {
            l = array_of(|i| array_of(|j| l[i][j] + u[i] * gradient[j]));
        }
        let stress = self.state.stress(&l);
        let gradients = if self.state.is_updated {
            self.moved_gradients(displacements, &l)
        } else {
            resting
        };
        let zero = R::constant(0.0);
        let force = |gradient: &[R; D]| -> [R; D] {
            array_of(|i| {
                let sum = (0..D).fold(zero, |sum, j| sum + stress[i][j] * gradient[j]);
                sum * -self.volume
            })
        };
        gradients.iter().map(force).collect()
    }
}
