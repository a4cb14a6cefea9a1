//! The dynamical matrix from the linearized discrete forces.

use super::DynamicalMatrix;
use super::dynamical_matrix::ForceConstants;
use crate::approximation::Order;
use crate::kinematics::DeformationGradient;
use crate::material::{FourthOrder, Hyperelastic, Response};
use crate::method::{Configuration, ConfiguredPoint, Frame, Linearization, Method, MethodError};
use nalgebra::{SMatrix, SVector};

/// The dynamical matrix of a method and a material at a homogeneous state.
///
/// Lagrangian kernels: `D_ik = 1/m sum_q V_q conj(B_J) A_iJkL B_L`, `B = sum_K grad phi_K exp(i k.(X_K - X_q))`,
/// equations (45), (54). Eulerian kernels: the derivative of `f_I = sum_q v_q sigma(q) grad phi_I(x_q)`
/// by the positions, equations (51), (55), in the chosen linearization. Shape `D x D`, units 1/time^2.
///
/// ```
/// use nalgebra::Vector2;
/// use onset::bloch::dynamical_matrix;
/// use onset::kinematics::DeformationGradient;
/// use onset::material::ModifiedMooneyRivlin;
/// use onset::method::{Discretization, Method};
/// let method = Method::<2>::new(Discretization::default())?;
/// let f = DeformationGradient::from_stretches([1.2, 0.9, 1.0])?;
/// let matrix = dynamical_matrix(&method, &ModifiedMooneyRivlin::default(), &f)?;
/// let omega_squared = matrix.omega_squared(&Vector2::new(2.0, 1.1));
/// assert!((omega_squared[0].re - 0.0962355955).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`MethodError`] when the method or the material cannot be evaluated at the state.
pub fn dynamical_matrix<const D: usize>(
    method: &Method<D>,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
) -> Result<DynamicalMatrix<D>, MethodError> {
    let discretization = method.discretization();
    let order = match (
        discretization.frame,
        discretization.linearization.is_exact_in_kernel(),
    ) {
        (Frame::Lagrangian, _) => Order::First,
        (Frame::Eulerian, false) => Order::Second,
        (Frame::Eulerian, true) => Order::Sensitivities,
    };
    let configuration = method.configuration(f, order)?;
    let mut constants = ForceConstants::new(reach(&configuration));
    let mut known: Option<Response> = None;
    for point in &configuration.points {
        // With the imposed background all points carry the same deformation.
        let response = match known.take() {
            Some(response) if response.deformation == point.deformation => response,
            _ => material.response(&point.deformation)?,
        };
        match discretization.frame {
            Frame::Lagrangian => {
                let factor = point.volume / method.particle_mass();
                add_gradient_stiffness(&mut constants, point, &response.tangent, None, factor);
            }
            Frame::Eulerian => {
                let current = point.deformation.jacobian() * point.volume;
                let factor = current / method.particle_mass();
                let cauchy = response.cauchy();
                let sigma = SMatrix::from_fn(|i, j| cauchy[(i, j)]);
                let tangent = response.spatial_tangent();
                add_gradient_stiffness(&mut constants, point, &tangent, Some(&sigma), factor);
                add_kernel_motion(
                    &mut constants,
                    point,
                    &sigma,
                    discretization.linearization,
                    factor,
                );
            }
        }
        known = Some(response);
    }
    let matrix = constants.finish(method.lattice());
    if matrix.is_finite() {
        Ok(matrix)
    } else {
        Err(MethodError::NotFinite)
    }
}

/// The squared norm of the discrete gradient, `sum_q V_q |B_q(k)|^2 / V0`, on the diagonal of a matrix:
/// the dynamical matrix of a material with the tangent `delta_ik delta_JL` and unit density. It knows
/// of the method alone. A wave vector other than zero at which it vanishes is a zero-energy mode.
///
/// # Errors
/// [`MethodError`] when the method cannot be evaluated at the state.
pub fn gradient_norm<const D: usize>(
    method: &Method<D>,
    f: &DeformationGradient,
) -> Result<DynamicalMatrix<D>, MethodError> {
    let unit = FourthOrder::from_fn(|i, j, k, l| f64::from(u8::from(i == k && j == l)));
    of_gradients(method, f, &unit, method.lattice().cell_volume())
}

/// The gradient moments `H_JL(k) = 1/m sum_q V_q conj(B_qJ) B_qL` of a Lagrangian method: the dynamical matrix of the
/// tangent `delta_iJ delta_kL`.
pub(super) fn moment_matrix<const D: usize>(
    method: &Method<D>,
    f: &DeformationGradient,
) -> Result<DynamicalMatrix<D>, MethodError> {
    let unit = FourthOrder::from_fn(|i, j, k, l| f64::from(u8::from(i == j && k == l)));
    of_gradients(method, f, &unit, method.particle_mass())
}

/// `sum_q V_q conj(B_J) T_iJkL B_L` over a divisor, with a tangent that is no material's.
fn of_gradients<const D: usize>(
    method: &Method<D>,
    f: &DeformationGradient,
    tangent: &FourthOrder,
    divisor: f64,
) -> Result<DynamicalMatrix<D>, MethodError> {
    let configuration = method.configuration(f, Order::First)?;
    let mut constants = ForceConstants::new(reach(&configuration));
    for point in &configuration.points {
        add_gradient_stiffness(&mut constants, point, tangent, None, point.volume / divisor);
    }
    Ok(constants.finish(method.lattice()))
}

fn reach<const D: usize>(configuration: &Configuration<D>) -> i32 {
    let range = |point: &ConfiguredPoint<D>| {
        (0..D)
            .map(|i| {
                let coordinates = point.cells.iter().map(|cell| cell[i]);
                coordinates.clone().max().unwrap_or(0) - coordinates.min().unwrap_or(0)
            })
            .max()
            .unwrap_or(0)
    };
    configuration.points.iter().map(range).max().unwrap_or(0)
}

/// `phi_I,J T_iJkL phi_K,L` for all pairs of neighbors; with a Cauchy stress also the part
/// `phi_I,j sigma_il delta_jk phi_K,l` that volume change and stress change leave together:
/// `sigma_ij tr(L) + d sigma_ij = (a_ijkl + sigma_il delta_jk) L_kl`.
fn add_gradient_stiffness<const D: usize>(
    constants: &mut ForceConstants<D>,
    point: &ConfiguredPoint<D>,
    tangent: &FourthOrder,
    stress: Option<&SMatrix<f64, D, D>>,
    factor: f64,
) {
    // (grad phi_I)_J T_iJkL, once a neighbor I.
    for (from, own) in point.cells.iter().zip(&point.shape.gradients) {
        let contracted: [SMatrix<f64, D, D>; D] = std::array::from_fn(|l| {
            SMatrix::from_fn(|i, k| {
                let elastic: f64 = (0..D).map(|j| own[j] * tangent[(i, j, k, l)]).sum();
                factor * (elastic + stress.map_or(0.0, |sigma| sigma[(i, l)] * own[k]))
            })
        });
        for (to, other) in point.cells.iter().zip(&point.shape.gradients) {
            let block = (0..D).map(|l| contracted[l] * other[l]).sum();
            constants.add(from, to, &block);
        }
    }
}

/// `sigma_ij d(phi_I,j)(x_q)`: the kernel moves with the particles and the quadrature point. In the
/// continuum this cancels against parts of the gradient stiffness; here it does so only to
/// quadrature error, which is the tensile instability.
fn add_kernel_motion<const D: usize>(
    constants: &mut ForceConstants<D>,
    point: &ConfiguredPoint<D>,
    sigma: &SMatrix<f64, D, D>,
    linearization: Linearization,
    factor: f64,
) {
    let shape = &point.shape;
    let hessians = match linearization {
        Linearization::FrozenNormalization => &shape.frozen_hessians,
        _ => &shape.hessians,
    };
    let interpolated = !linearization.moves_points_with_plane_wave();
    for (i, from) in point.cells.iter().enumerate() {
        // The motion of the quadrature point.
        let block = sigma * hessians[i] * factor;
        if point.is_node {
            constants.add(from, &[0; D], &block);
        } else if interpolated {
            for (k, to) in point.cells.iter().enumerate() {
                constants.add(from, to, &(block * shape.values[k]));
            }
        } else {
            let fractional = SVector::from_fn(|a, _| point.place[a] - f64::from(from[a]));
            constants.add_loose(fractional, &block);
        }
        // The motion of the particles.
        if linearization.is_exact_in_kernel() {
            for (k, to) in point.cells.iter().enumerate() {
                constants.add(from, to, &(sigma * shape.sensitivity(i, k) * factor));
            }
        } else {
            constants.add(from, from, &-block);
        }
    }
}
