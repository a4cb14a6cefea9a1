//! Assembly of the dynamical matrix from the linearized discrete forces.

use super::DynamicalMatrix;
use super::dynamical_matrix::{Block, ForceConstants, matrix_of};
use crate::algebra::{Each, array_of};
use crate::approximation::Order;
use crate::cancel::checkpoint;
use crate::continuum::Stiffness;
use crate::kinematics::DeformationGradient;
use crate::material::{Hyperelastic, MaterialError};
use crate::method::{Configuration, ConfiguredPoint, Frame, Linearization, Method, MethodError};
use nalgebra::{SMatrix, SVector};
use pulp::{Arch, NullaryFnOnce};

/// Dynamical matrix of a method and a material at a homogeneous state. Shape `D x D`, unit 1/time^2.
///
/// Lagrangian kernels: `D_ik = 1/m sum_q V_q conj(B_J) A_iJkL B_L`, `B = sum_K grad phi_K exp(i k.(X_K - X_q))`, equations (45), (54). Natural
/// stabilization adds `1/m sum_q M_jl conj(B_J,j) A_iJkL B_L,l`.
///
/// Eulerian kernels: the derivative of `f_I = sum_q v_q sigma(q) grad phi_I(x_q)` with respect to the positions, equations (51), (55), in the chosen
/// linearization.
///
/// ```
/// use nalgebra::Vector2;
/// use onset::bloch::dynamical_matrix;
/// use onset::kinematics::DeformationGradient;
/// use onset::material::ModifiedMooneyRivlin;
/// use onset::method::{KernelMethodChoices, Method};
/// let method = Method::<2>::new(KernelMethodChoices::default())?;
/// let f = DeformationGradient::from_stretches([1.2, 0.9, 1.0])?;
/// let matrix = dynamical_matrix(&method, &ModifiedMooneyRivlin::default(), &f)?;
/// let omega_squared = matrix.omega_squared(&Vector2::new(2.0, 1.1));
/// assert!((omega_squared[0].re - 0.0962355955).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`MethodError`] if the method or the material cannot be evaluated at the state.
pub fn dynamical_matrix<const D: usize>(
    method: &Method<D>,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
) -> Result<DynamicalMatrix<D>, MethodError> {
    assembled(method, f, order(method), |deformation| {
        Local::new(material, deformation)
    })
}

/// Order of the derivatives of the shape functions that the dynamical matrix needs.
fn order<const D: usize>(method: &Method<D>) -> Order {
    let discretization = method.choices();
    match (
        discretization.frame,
        discretization.linearization.is_exact_in_kernel(),
    ) {
        (Frame::Lagrangian, _) => order_of_gradients(method),
        (Frame::Eulerian, false) => Order::Second,
        (Frame::Eulerian, true) => Order::Sensitivities,
    }
}

/// Order of the derivatives of the shape functions that products of strains need.
fn order_of_gradients<const D: usize>(method: &Method<D>) -> Order {
    if method.is_naturally_stabilized() {
        Order::Second
    } else {
        Order::First
    }
}

fn assembled<const D: usize>(
    method: &Method<D>,
    f: &DeformationGradient,
    order: Order,
    respond: impl Fn(&DeformationGradient) -> Result<Local<D>, MaterialError>,
) -> Result<DynamicalMatrix<D>, MethodError> {
    checkpoint();
    let discretization = method.choices();
    let (configuration, is_inverted) = method.configuration_of_halves(f, order)?;
    let mut constants = ForceConstants::new(configuration.basis, reach(&configuration));
    let mut known: Option<(DeformationGradient, Local<D>)> = None;
    for point in &configuration.points {
        // With the imposed background all points have the same deformation.
        let local = match known {
            Some((deformation, local)) if deformation == point.deformation => local,
            _ => respond(&point.deformation)?,
        };
        known = Some((point.deformation, local));
        match discretization.frame {
            Frame::Lagrangian => {
                add_lagrangian(
                    &mut constants,
                    point,
                    &local.tangent,
                    method.particle_mass(),
                );
            }
            Frame::Eulerian => {
                let current = point.deformation.jacobian() * point.volume;
                let factor = current / method.particle_mass();
                let spatial = local.spatial(&point.deformation);
                add_eulerian(
                    &mut constants,
                    point,
                    &spatial,
                    discretization.linearization,
                    factor,
                );
            }
        }
    }
    let matrix = constants.finish(method.lattice(), is_inverted);
    if matrix.is_finite() {
        Ok(matrix)
    } else {
        Err(MethodError::NotFinite)
    }
}

/// Squared norm of the discrete gradient, `sum_q V_q |B_q(k)|^2 / V0`, on the diagonal of a matrix.
///
/// It is the dynamical matrix of a material with the tangent `delta_ik delta_JL` and unit density, and depends on the method alone. A nonzero wave
/// vector with zero norm is a zero-energy mode.
///
/// # Errors
/// [`MethodError`] if the method cannot be evaluated at the state.
pub fn gradient_norm<const D: usize>(
    method: &Method<D>,
    f: &DeformationGradient,
) -> Result<DynamicalMatrix<D>, MethodError> {
    let unit = tangent_from(|i, j, k, l| f64::from(u8::from(i == k && j == l)));
    of_gradients(method, f, &unit, method.lattice().cell_volume())
}

/// Gradient moments `H_JL(k) = 1/m sum_q V_q conj(B_qJ) B_qL` of a Lagrangian method: the dynamical matrix of the tangent `delta_iJ delta_kL`.
pub(super) fn moment_matrix<const D: usize>(
    method: &Method<D>,
    f: &DeformationGradient,
) -> Result<DynamicalMatrix<D>, MethodError> {
    let unit = tangent_from(|i, j, k, l| f64::from(u8::from(i == j && k == l)));
    of_gradients(method, f, &unit, method.particle_mass())
}

/// Matrix `sum_q V_q conj(B_J) T_iJkL B_L + M_jl conj(B_J,j) T_iJkL B_L,l`, divided by a divisor, with a given tangent in place of the material.
fn of_gradients<const D: usize>(
    method: &Method<D>,
    f: &DeformationGradient,
    tangent: &Tangent<D>,
    divisor: f64,
) -> Result<DynamicalMatrix<D>, MethodError> {
    let order = order_of_gradients(method);
    let (configuration, is_inverted) = method.configuration_of_halves(f, order)?;
    let mut constants = ForceConstants::new(configuration.basis, reach(&configuration));
    for point in &configuration.points {
        add_lagrangian(&mut constants, point, tangent, divisor);
    }
    Ok(constants.finish(method.lattice(), is_inverted))
}

/// Largest difference of lattice coordinates of two neighbors of a point, in the short basis.
fn reach<const D: usize>(configuration: &Configuration<D>) -> i32 {
    let inverse = &configuration.basis.inverse;
    let range = |point: &ConfiguredPoint<D>| {
        let along = |i: usize| {
            let coordinate = |cell: &[i32; D]| -> f64 {
                (0..D).map(|j| inverse[(i, j)] * f64::from(cell[j])).sum()
            };
            let coordinates = point.cells.iter().map(coordinate);
            let ends = coordinates.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
                [low.min(x), high.max(x)]
            });
            (ends[1] - ends[0]).max(0.0) as i32
        };
        (0..D).map(along).max().unwrap_or(0)
    };
    configuration.points.iter().map(range).max().unwrap_or(0)
}

/// Components `T_iJkL` of a tangent within the dimensions of a lattice, at `[i][J][k][L]`.
pub(crate) type Tangent<const D: usize> = [[[[f64; D]; D]; D]; D];

fn tangent_from<const D: usize>(
    component: impl Fn(usize, usize, usize, usize) -> f64,
) -> Tangent<D> {
    let component = &component;
    array_of(|i| array_of(|j| array_of(|k| array_of(|l| component(i, j, k, l)))))
}

/// Stress and tangent of a material at a state, within the dimensions of a lattice.
#[derive(Clone, Copy)]
pub(crate) struct Local<const D: usize> {
    /// First Piola-Kirchhoff stress `P_iJ`.
    first_piola: [[f64; D]; D],
    /// Material tangent `A_iJkL = dP_iJ/dF_kL` at the state.
    tangent: Tangent<D>,
}

impl<const D: usize> Local<D> {
    /// Evaluates the material, in two dimensions without the components out of the plane.
    ///
    /// # Errors
    /// [`MaterialError`] if the response over- or underflows.
    pub(crate) fn new(
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
    ) -> Result<Self, MaterialError> {
        if D == 2 {
            let response = material.plane_response(f)?;
            return Ok(Self {
                first_piola: array_of(|i| array_of(|j| response.first_piola[2 * i + j])),
                tangent: tangent_from(|i, j, k, l| response.tangent[2 * i + j][2 * k + l]),
            });
        }
        let response = material.response(f)?;
        Ok(Self {
            first_piola: array_of(|i| array_of(|j| response.first_piola[(i, j)])),
            tangent: tangent_from(|i, j, k, l| response.tangent[(i, j, k, l)]),
        })
    }

    /// First Piola-Kirchhoff stress `P_iJ`.
    pub(crate) fn first_piola(&self) -> &[[f64; D]; D] {
        &self.first_piola
    }

    /// Material tangent `A_iJkL = dP_iJ/dF_kL` at the state.
    pub(crate) fn tangent(&self) -> &Tangent<D> {
        &self.tangent
    }

    /// Tangent as the stiffness of the continuum.
    pub(crate) fn stiffness(&self) -> Stiffness<D> {
        Stiffness::from_fn(|i, j, k, l| self.tangent[i][j][k][l])
    }

    /// Cauchy stress `sigma_ij = P_iJ F_jJ / J` and spatial tangent `a_ijkl = F_jJ F_lL A_iJkL / J` at the state.
    fn spatial(&self, state: &DeformationGradient) -> Spatial<D> {
        let (f, jacobian) = (state.leading::<D>(), state.jacobian());
        let half: Tangent<D> =
            tangent_from(|i, j, k, l| (0..D).map(|m| f[(j, m)] * self.tangent[i][m][k][l]).sum());
        Spatial {
            stress: SMatrix::from_fn(|i, j| {
                (0..D)
                    .map(|m| self.first_piola[i][m] * f[(j, m)])
                    .sum::<f64>()
                    / jacobian
            }),
            tangent: tangent_from(|i, j, k, l| {
                (0..D).map(|m| f[(l, m)] * half[i][j][k][m]).sum::<f64>() / jacobian
            }),
        }
    }
}

/// Cauchy stress and spatial tangent within the dimensions of a lattice.
struct Spatial<const D: usize> {
    stress: SMatrix<f64, D, D>,
    tangent: Tangent<D>,
}

/// Contraction `factor (grad phi_I)_J T_iJkL`: for each `L` a matrix in `i`, `k`.
///
/// With a Cauchy stress, it includes the joint contribution `phi_I,j sigma_il delta_jk phi_K,l` of the changes of volume and stress: `sigma_ij tr(L)
/// + d sigma_ij = (a_ijkl + sigma_il delta_jk) L_kl`.
fn contracted<const D: usize>(
    tangent: &Tangent<D>,
    own: &SVector<f64, D>,
    stress: Option<&SMatrix<f64, D, D>>,
    factor: f64,
) -> [Block<D>; D] {
    let mut contracted = [[[0.0; D]; D]; D];
    for l in 0..D {
        for i in 0..D {
            for k in 0..D {
                let mut sum = 0.0;
                for j in 0..D {
                    sum += own[j] * tangent[i][j][k][l];
                }
                if let Some(sigma) = stress {
                    sum += sigma[(i, l)] * own[k];
                }
                contracted[l][i][k] = factor * sum;
            }
        }
    }
    contracted
}

/// Adds the force constants of a point of a Lagrangian kernel, `V conj(B_J) T_iJkL B_L`, divided by a divisor. With strains expanded over the cell of
/// the point, also `M_jl conj(B_J,j) T_iJkL B_L,l`.
fn add_lagrangian<const D: usize>(
    constants: &mut ForceConstants<D>,
    point: &ConfiguredPoint<D>,
    tangent: &Tangent<D>,
    divisor: f64,
) {
    let expanded = point.second_moments.map_or(0, |_| D * D);
    let mut pairs = Pairs::new(point.cells.len(), D + expanded);
    let factor = point.volume / divisor;
    pairs.add_gradients(point, 0, |own| contracted(tangent, own, None, factor));
    if let Some(moments) = point.second_moments {
        for l in 0..D {
            let first = |i: usize| {
                let moved: SVector<f64, D> = point.shape.hessians[i] * moments.column(l);
                contracted(tangent, &moved, None, divisor.recip())
            };
            let second = |k: usize| point.shape.hessians[k].column(l).into_owned();
            pairs.add_products(D * (1 + l), first, second);
        }
    }
    pairs.sum(&constants.places(&point.cells), constants);
}

/// Adds the force constants of a point of an Eulerian kernel.
///
/// They are the gradient stiffness and `sigma_ij d(phi_I,j)(x_q)`, because the kernel moves with the particles and the quadrature point. In the
/// continuum the second part cancels parts of the first; in the discretization it cancels them only up to the quadrature error, which is the tensile
/// instability.
fn add_eulerian<const D: usize>(
    constants: &mut ForceConstants<D>,
    point: &ConfiguredPoint<D>,
    spatial: &Spatial<D>,
    linearization: Linearization,
    factor: f64,
) {
    let shape = &point.shape;
    let sigma = &spatial.stress;
    let hessians = match linearization {
        Linearization::FrozenNormalization => &shape.frozen_hessians,
        _ => &shape.hessians,
    };
    let is_interpolated = !point.is_node && !linearization.moves_points_with_plane_wave();
    let motion = shape
        .motion()
        .filter(|_| linearization.is_exact_in_kernel());
    let rank = D + usize::from(is_interpolated) + motion.map_or(0, |motion| 2 * motion.basis);
    let mut pairs = Pairs::new(point.cells.len(), rank);
    pairs.add_gradients(point, 0, |own| {
        contracted(&spatial.tangent, own, Some(sigma), factor)
    });
    let mut number = D;
    let turned = |matrix: &SMatrix<f64, D, D>, factor: f64| product(sigma, matrix, factor);
    if is_interpolated {
        // Motion of the quadrature point with the interpolated displacement.
        let of_i = |i: usize| turned(&hessians[i], factor);
        pairs.add(number, of_i, |k| [[shape.values[k]; D]; D]);
        number += 1;
    }
    if let Some(motion) = motion {
        // Motion of the particles.
        for b in 0..motion.basis {
            let at = |i: usize| i * motion.basis + b;
            let of_i = |i: usize| [[factor * motion.terms[at(i)].0; D]; D];
            pairs.add(number, of_i, |k| turned(&motion.shifts[at(k)].1, 1.0));
            let of_i = |i: usize| {
                let gradient = &motion.terms[at(i)].1;
                let mut block = [[0.0; D]; D];
                for row in 0..D {
                    let mut along = 0.0;
                    for j in 0..D {
                        along += sigma[(row, j)] * gradient[j];
                    }
                    block[row] = [-factor * along; D];
                }
                block
            };
            let of_k = |k: usize| {
                let shift = &motion.shifts[at(k)].0;
                let mut row = [0.0; D];
                for t in 0..D {
                    row[t] = shift[t];
                }
                [row; D]
            };
            pairs.add(number + 1, of_i, of_k);
            number += 2;
        }
    }
    let places = constants.places(&point.cells);
    pairs.sum(&places, constants);
    for (i, from) in point.cells.iter().enumerate() {
        let block = turned(&hessians[i], factor);
        if point.is_node {
            constants.add(0_usize.wrapping_sub(places[i]), &block);
        } else if !is_interpolated {
            let fractional = SVector::from_fn(|a, _| point.place[a] - f64::from(from[a]));
            constants.add_loose(fractional, &matrix_of(&block));
        }
        match motion {
            Some(motion) => constants.add(0, &turned(&motion.own[i], factor)),
            None => constants.add(0, &block.each(|row| row.each(|entry| -entry))),
        }
    }
}

/// Product `factor left right` of two matrices.
#[inline]
fn product<const D: usize>(
    left: &SMatrix<f64, D, D>,
    right: &SMatrix<f64, D, D>,
    factor: f64,
) -> Block<D> {
    let mut product = [[0.0; D]; D];
    for i in 0..D {
        for k in 0..D {
            let mut sum = 0.0;
            for j in 0..D {
                sum += left[(i, j)] * right[(j, k)];
            }
            product[i][k] = factor * sum;
        }
    }
    product
}

/// Contribution of a point to the force constants of all pairs of its neighbors. It is a sum of a few entrywise products, each of a factor of the
/// first and a factor of the second neighbor.
struct Pairs<const D: usize> {
    rank: usize,
    /// Factors of both neighbors, at `[neighbor * rank + product]`.
    first: Vec<Block<D>>,
    second: Vec<Block<D>>,
}

impl<const D: usize> Pairs<D> {
    fn new(neighbors: usize, rank: usize) -> Self {
        let zeros = || vec![[[0.0; D]; D]; neighbors * rank];
        Self {
            rank,
            first: zeros(),
            second: zeros(),
        }
    }

    /// Sets the factors of the product with index `number`.
    fn add(
        &mut self,
        number: usize,
        of_i: impl Fn(usize) -> Block<D>,
        of_k: impl Fn(usize) -> Block<D>,
    ) {
        for n in 0..self.first.len() / self.rank {
            self.first[n * self.rank + number] = of_i(n);
            self.second[n * self.rank + number] = of_k(n);
        }
    }

    /// Sets the products with the components of the gradient of `phi_K`, starting at index `number`.
    fn add_gradients(
        &mut self,
        point: &ConfiguredPoint<D>,
        number: usize,
        contracted: impl Fn(&SVector<f64, D>) -> [Block<D>; D],
    ) {
        let gradients = &point.shape.gradients;
        self.add_products(number, |i| contracted(&gradients[i]), |k| gradients[k]);
    }

    /// Sets the products of `D` matrices with the components of a vector, starting at index `number`.
    fn add_products(
        &mut self,
        number: usize,
        of_i: impl Fn(usize) -> [Block<D>; D],
        of_k: impl Fn(usize) -> SVector<f64, D>,
    ) {
        for n in 0..self.first.len() / self.rank {
            let at = n * self.rank + number;
            let (own, components) = (of_i(n), of_k(n));
            for l in 0..D {
                self.first[at + l] = own[l];
                self.second[at + l] = [[components[l]; D]; D];
            }
        }
    }

    /// Adds the products of all pairs to the force constants.
    fn sum(&self, places: &[usize], constants: &mut ForceConstants<D>) {
        Arch::new().dispatch(Summing {
            pairs: self,
            places,
            middle: constants.middle(),
            blocks: constants.blocks_mut(),
        });
    }
}

/// Vectorized summation for the instruction set of the machine. It is a struct because a closure would not be inlined.
struct Summing<'a, const D: usize> {
    pairs: &'a Pairs<D>,
    places: &'a [usize],
    middle: usize,
    blocks: &'a mut [Block<D>],
}

impl<const D: usize> NullaryFnOnce for Summing<'_, D> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let rank = self.pairs.rank;
        for (from, first) in self.places.iter().zip(self.pairs.first.chunks_exact(rank)) {
            let seconds = self.pairs.second.chunks_exact(rank);
            for (to, second) in self.places.iter().zip(seconds) {
                let place = to.wrapping_add(self.middle).wrapping_sub(*from);
                let mut sum = self.blocks[place];
                for (a, b) in first.iter().zip(second) {
                    for i in 0..D {
                        for k in 0..D {
                            sum[i][k] += a[i][k] * b[i][k];
                        }
                    }
                }
                self.blocks[place] = sum;
            }
        }
    }
}
