//! Discrete forces of kernel methods for particles displaced from a homogeneous state.

use crate::algebra::array_of;
use crate::approximation::Order;
use crate::kinematics::DeformationGradient;
use crate::lattice::{Particle, determinant};
use crate::material::Hyperelastic;
use crate::method::{ConfiguredPoint, Frame, Linearization, Method, MethodError, support};
use crate::scheme::{NoForce, PatchForces, PeriodicPatch, PointResponse};
use nalgebra::{SMatrix, SVector};

/// Forces of a quadrature point on the particles around it, by their lattice coordinates relative to its cell.
type Share<const D: usize> = Vec<([i32; D], SVector<f64, D>)>;

/// Quadrature points of a method in a homogeneous state, in every cell of a patch.
pub(crate) struct PatchPoints<'a, const D: usize> {
    method: &'a Method<D>,
    f: DeformationGradient,
    patch: PeriodicPatch<D>,
    points: Vec<(ConfiguredPoint<D>, PointResponse<'a, D>)>,
}

impl<const D: usize> Method<D> {
    /// Returns the forces on the particles of a periodic patch displaced from a homogeneous state.
    ///
    /// Lagrangian kernels: `f_I = -sum_q V_q P(F_q) grad phi_I`, `F_q = F + sum_K u_K (x) grad phi_K`. With natural stabilization the
    /// response to the small strain relative to the center of a cell is linear.
    ///
    /// Eulerian kernels: `f_I = -sum_q v_q sigma(F_q) grad phi_I(x_q)` with the shape functions of the moved particles,
    /// `F_q = (1 + sum_K u_K (x) grad phi_K) F` and `v_q = J_q V_q`. Stress points move with the interpolated displacement.
    ///
    /// # Errors
    /// [`MethodError::NotOfForces`] for linearizations other than the exact one; otherwise the errors of the dynamical matrix.
    pub(crate) fn patch_points<'a>(
        &'a self,
        material: &'a dyn Hyperelastic,
        f: &DeformationGradient,
        patch: &PeriodicPatch<D>,
    ) -> Result<PatchPoints<'a, D>, MethodError> {
        let choices = self.choices();
        let is_eulerian = choices.frame == Frame::Eulerian;
        if is_eulerian && choices.linearization != Linearization::Exact {
            return Err(MethodError::NotOfForces {
                linearization: choices.linearization.name(),
            });
        }
        let order = if self.is_naturally_stabilized() {
            Order::Second
        } else {
            Order::First
        };
        let with_response = |point: ConfiguredPoint<D>| {
            let response = PointResponse::new(material, &point.deformation)?;
            Ok((point, response))
        };
        let points = self.configuration(f, order)?.points.into_iter();
        Ok(PatchPoints {
            method: self,
            f: *f,
            patch: *patch,
            points: points
                .map(with_response)
                .collect::<Result<_, MethodError>>()?,
        })
    }

    fn eulerian_share(
        &self,
        point: &ConfiguredPoint<D>,
        f: &DeformationGradient,
        response: &PointResponse<'_, D>,
        moved: &impl Fn(&[i32; D]) -> SVector<f64, D>,
    ) -> Result<Share<D>, MethodError> {
        let kernel = self.choices().kernel;
        let layout = self.layout(f);
        let shift: SVector<f64, D> = if point.is_node {
            moved(&[0; D])
        } else {
            let seen = point.cells.iter().zip(&point.shape.values);
            seen.map(|(cell, value)| moved(cell) * *value).sum()
        };
        // Particles from outside the support may have entered it.
        let (mut cells, mut positions, mut weights) = (Vec::new(), Vec::new(), Vec::new());
        for cell in support(&layout.enlarged(1.2))?.cells(&point.place) {
            let fractional = SVector::<f64, D>::from_fn(|i, _| f64::from(cell[i])) - point.place;
            let position = layout.vectors * fractional + moved(&cell) - shift;
            if let Some(weight) = kernel.weight(&position, layout.radius, &layout.metric) {
                cells.push(cell);
                positions.push(position);
                weights.push(weight);
            }
        }
        let integral = kernel.integral::<D>(layout.radius) / determinant(&layout.metric).abs();
        let shape = self
            .choices()
            .approximation
            .shape_functions(
                &positions,
                &weights,
                determinant(&layout.vectors).abs() / integral,
                layout.radius,
                Order::First,
            )
            .map_err(|source| MethodError::SingularMoment {
                point: if point.is_node {
                    "particle"
                } else {
                    "stress point"
                },
                neighbors: positions.len(),
                source,
            })?;
        let rate = gradient(point, moved) + SMatrix::identity();
        let own = rate * point.deformation.leading::<D>();
        let deformed: [[f64; D]; D] = array_of(|i| array_of(|j| own[(i, j)]));
        let stress = matrix(&response.cauchy(&deformed));
        let volume = point.volume * determinant(&own) * response.transverse();
        let shares = cells.into_iter().zip(&shape.gradients);
        Ok(shares
            .map(|(cell, gradient)| (cell, stress * gradient * -volume))
            .collect())
    }
}

impl<const D: usize> PatchForces<D> for PatchPoints<'_, D> {
    fn at(
        &self,
        displacements: &[SVector<f64, D>],
        _: &[SVector<f64, D>],
    ) -> Result<Vec<SVector<f64, D>>, NoForce> {
        let is_eulerian = self.method.choices().frame == Frame::Eulerian;
        let mut forces = vec![SVector::zeros(); self.patch.len()];
        for (point, response) in &self.points {
            for origin in self.patch.origins() {
                let number = |cell: &[i32; D]| {
                    let own = Particle {
                        site: 0,
                        cell: *cell,
                    };
                    self.patch.number(&own.moved(&origin))
                };
                let moved = |cell: &[i32; D]| displacements[number(cell)];
                let none = |source| NoForce {
                    particle: number(&[0; D]),
                    source,
                };
                let share = match is_eulerian {
                    true => self
                        .method
                        .eulerian_share(point, &self.f, response, &moved)
                        .map_err(|error| none(Some(error)))?,
                    false => lagrangian_share(point, response, &moved),
                };
                for (cell, force) in share {
                    if force.iter().any(|component| !component.is_finite()) {
                        return Err(none(None));
                    }
                    forces[number(&cell)] += force;
                }
            }
        }
        Ok(forces)
    }
}

fn lagrangian_share<const D: usize>(
    point: &ConfiguredPoint<D>,
    response: &PointResponse<'_, D>,
    moved: &impl Fn(&[i32; D]) -> SVector<f64, D>,
) -> Share<D> {
    let own = gradient(point, moved) + point.deformation.leading::<D>();
    let deformed = array_of(|i| array_of(|j| own[(i, j)]));
    let stress = matrix(&response.first_piola(&deformed));
    let tangent = response.base_tangent();
    // sum_l M_jl A : F_,l for each direction j of the expansion.
    let expanded: Vec<SMatrix<f64, D, D>> = point.second_moments.map_or_else(Vec::new, |moments| {
        let slopes: Vec<SMatrix<f64, D, D>> = (0..D)
            .map(|l| {
                let seen = point.cells.iter().zip(&point.shape.hessians);
                seen.map(|(cell, hessian)| moved(cell) * hessian.column(l).transpose())
                    .sum()
            })
            .collect();
        (0..D)
            .map(|j| {
                SMatrix::from_fn(|i, m| {
                    (0..D)
                        .map(|l| moments[(j, l)] * contracted(&tangent[i][m], &slopes[l]))
                        .sum()
                })
            })
            .collect()
    });
    let force = |number: usize| {
        let own = stress * point.shape.gradients[number] * -point.volume;
        expanded.iter().enumerate().fold(own, |sum, (j, stress)| {
            sum - stress * point.shape.hessians[number].column(j)
        })
    };
    let cells = point.cells.iter().enumerate();
    cells.map(|(number, cell)| (*cell, force(number))).collect()
}

/// Displacement gradient `sum_K u_K (x) grad phi_K` at the point.
fn gradient<const D: usize>(
    point: &ConfiguredPoint<D>,
    moved: &impl Fn(&[i32; D]) -> SVector<f64, D>,
) -> SMatrix<f64, D, D> {
    let seen = point.cells.iter().zip(&point.shape.gradients);
    seen.map(|(cell, gradient)| moved(cell) * gradient.transpose())
        .sum()
}

fn contracted<const D: usize>(tangent: &[[f64; D]; D], slope: &SMatrix<f64, D, D>) -> f64 {
    (0..D)
        .flat_map(|k| (0..D).map(move |l| (k, l)))
        .map(|(k, l)| tangent[k][l] * slope[(k, l)])
        .sum()
}

fn matrix<const D: usize>(rows: &[[f64; D]; D]) -> SMatrix<f64, D, D> {
    SMatrix::from_fn(|i, j| rows[i][j])
}
