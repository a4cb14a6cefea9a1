//! Interaction of the nodes around a material point.

use super::functions::{Profile, Stretch};
use crate::algebra::array_of;
use crate::kinematics::DeformationGradient;
use crate::lattice::Particle;
use crate::material::Hyperelastic;
use crate::method::MethodError;
use crate::real::Real;
use crate::scheme::{Interaction, Motion, PointResponse, determinant};
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

    /// Energy density `W` of `b F` at the displacement gradient `L` on the grid; energy/volume. NaN if the law is not defined there.
    pub(super) fn energy(&self, l: &[[f64; D]; D], ratio: f64) -> f64 {
        let f = self.deformed(l);
        self.response
            .energy(&array_of(|i| array_of(|j| f[i][j] * ratio)))
    }

    /// Deformation gradient at the displacement gradient `L` on the grid, `F0 + L`, or `(1 + L) F0` if the grid is updated.
    pub(super) fn deformed<R: Real>(&self, l: &[[R; D]; D]) -> [[R; D]; D] {
        let base = self.response.leading::<f64>();
        match self.is_updated {
            true => moved(l, &base),
            false => array_of(|i| array_of(|j| l[i][j] + base[i][j])),
        }
    }

    /// Stress that is multiplied by the volume, at the displacement gradient `L` on the grid.
    ///
    /// Total-Lagrangian: `P` at `F = F0 + L`. Updated: `J sigma = P F^T` at `F = (1 + L) F0`. With a ratio `b` of the mean dilatation, the stress of `b F` acts
    /// on the geometry of `F`, and `P(b F) b^(1-D)` replaces `P`.
    pub(super) fn stress<R: Real>(&self, l: &[[R; D]; D], ratio: Option<R>) -> [[R; D]; D] {
        let zero = R::constant(0.0);
        let f = self.deformed(l);
        let mut stress = match ratio {
            Some(b) => self
                .response
                .first_piola(&array_of(|i| array_of(|j| f[i][j] * b))),
            None => self.response.first_piola(&f),
        };
        if let Some(b) = ratio {
            let factor = (1..D).fold(R::constant(1.0), |product, _| product / b);
            stress = array_of(|i| array_of(|j| stress[i][j] * factor));
        }
        if !self.is_updated {
            return stress;
        }
        let product = |i: usize, j: usize| (0..D).fold(zero, |sum, m| sum + stress[i][m] * f[j][m]);
        array_of(|i| array_of(|j| product(i, j)))
    }

    /// Ratios `b = (J' / J)^(1/D)` of points with the volumes `V` and the displacement gradients `L` that share the mean `J' = sum V J / sum V` of their volume
    /// ratios.
    pub(super) fn ratios<R: Real>(&self, points: &[(f64, [[R; D]; D])]) -> Vec<R> {
        let volume_ratio = |(_, l): &(f64, [[R; D]; D])| determinant(&self.deformed(l));
        let own: Vec<R> = points.iter().map(volume_ratio).collect();
        let whole: f64 = points.iter().map(|(volume, _)| volume).sum();
        let Some(first) = own.first().copied() else {
            return own;
        };
        // Equal volume ratios have this mean exactly.
        let both = points.iter().zip(&own);
        let mean = both.fold(first, |sum, ((volume, _), j)| {
            sum + (*j - first) * (volume / whole)
        });
        own.iter()
            .map(|j| (mean / *j).powf(1.0 / D as f64))
            .collect()
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

impl<const D: usize> Point<'_, D> {
    /// Displacement gradient on the grid.
    fn displacement_gradient<R: Real>(&self, displacements: &[[R; D]]) -> [[R; D]; D] {
        let mut l = [[R::constant(0.0); D]; D];
        for (u, (_, gradient)) in displacements.iter().zip(&self.shapes) {
            l = array_of(|i| array_of(|j| l[i][j] + u[i] * gradient[j]));
        }
        l
    }

    /// Forces on the nodes; `ratio` as in [`State::stress`].
    fn forces_with<R: Real>(
        &self,
        displacements: &[[R; D]],
        l: &[[R; D]; D],
        ratio: Option<R>,
    ) -> Vec<[R; D]> {
        let stress = self.state.stress(l, ratio);
        let gradients = match self.state.is_updated {
            true => self.moved_gradients(displacements, l),
            false => {
                let fixed = |(_, gradient): &(f64, [f64; D])| gradient.map(R::constant);
                self.shapes.iter().map(fixed).collect()
            }
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

impl<const D: usize> Interaction<D> for Point<'_, D> {
    fn particles(&self) -> &[Particle<D>] {
        &self.nodes
    }

    fn forces<R: Real>(&self, motion: Motion<'_, R, D>) -> Vec<[R; D]> {
        let l = self.displacement_gradient(motion.displacements);
        self.forces_with(motion.displacements, &l, None)
    }
}

/// Material points of a cell, with the mean of their dilatations if there are several.
pub(super) struct Cell<'a, const D: usize> {
    points: Vec<Point<'a, D>>,
    nodes: Vec<Particle<D>>,
    /// Places of the nodes of each point among all nodes.
    places: Vec<Vec<usize>>,
}

impl<'a, const D: usize> Cell<'a, D> {
    pub(super) fn new(points: Vec<Point<'a, D>>) -> Self {
        let mut nodes: Vec<Particle<D>> = points.iter().flat_map(|own| own.nodes.clone()).collect();
        if points.len() > 1 {
            nodes.sort_unstable();
            nodes.dedup();
        }
        let place = |node: &Particle<D>| nodes.iter().position(|own| own == node).unwrap_or(0);
        Self {
            places: points
                .iter()
                .map(|point| point.nodes.iter().map(place).collect())
                .collect(),
            nodes,
            points,
        }
    }
}

impl<const D: usize> Interaction<D> for Cell<'_, D> {
    fn particles(&self) -> &[Particle<D>] {
        &self.nodes
    }

    fn forces<R: Real>(&self, motion: Motion<'_, R, D>) -> Vec<[R; D]> {
        if let [point] = &self.points[..] {
            return point.forces(motion);
        }
        let of_point = |places: &Vec<usize>| -> Vec<[R; D]> {
            places.iter().map(|n| motion.displacements[*n]).collect()
        };
        let displacements: Vec<Vec<[R; D]>> = self.places.iter().map(of_point).collect();
        let both = self.points.iter().zip(&displacements);
        let gradients: Vec<(f64, [[R; D]; D])> = both
            .map(|(point, own)| (point.volume, point.displacement_gradient(own)))
            .collect();
        let ratios = self.points[0].state.ratios(&gradients);
        let mut forces = vec![[R::constant(0.0); D]; self.nodes.len()];
        for (n, point) in self.points.iter().enumerate() {
            let own = point.forces_with(&displacements[n], &gradients[n].1, Some(ratios[n]));
            for (place, force) in self.places[n].iter().zip(own) {
                forces[*place] = array_of(|i| forces[*place][i] + force[i]);
            }
        }
        forces
    }
}
