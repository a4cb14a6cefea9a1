//! Periodic patch of particles with its nonlinear internal forces.

use crate::law::Law;
use nalgebra::{Complex, DMatrix, Matrix3, SMatrix, SVector};
use num_dual::{DualNum, HyperDual64};
use onset::approximation::Approximation;
use onset::bloch::dynamical_matrix;
use onset::kinematics::DeformationGradient;
use onset::lattice::LatticeKind;
use onset::method::{
    Background, CurrentLattice, Frame, KernelMethodChoices, Linearization, Method, SupportSize,
};
use onset::quadrature::{Quadrature, QuadraturePoint};
use std::f64::consts::{PI, TAU};

/// Number of cells of the patch along each primitive vector; a multiple of six includes the wave vectors M, X and K.
const SIDE: usize = 6;
/// Half step of the differentiation, in units of the spacing; the error of the five-point formula is of fourth order.
const STEP: f64 = 2e-4;

/// One shape function at a point.
#[derive(Clone, Copy)]
pub struct Shape<const D: usize> {
    particle: usize,
    /// Vector `x_K - x` to the image in the support.
    relative: SVector<f64, D>,
    value: f64,
    gradient: SVector<f64, D>,
}

struct Point<const D: usize> {
    /// Position in the coordinates of the kernel, before displacements.
    place: SVector<f64, D>,
    /// Position in the reference configuration.
    reference: SVector<f64, D>,
    /// Number of the particle, unless the point is a stress point.
    particle: Option<usize>,
    volume: f64,
    /// Deformation gradient of the homogeneous state.
    deformation: Matrix3<f64>,
    /// Shape functions in the homogeneous state.
    shapes: Vec<Shape<D>>,
    /// Second derivatives `phi_I,jt` in the homogeneous state, in the order of `shapes`. They are needed only for linearizations that freeze a
    /// quantity, and if strain is expanded over the cell of a point.
    hessians: Vec<SMatrix<f64, D, D>>,
    /// Second moments of this cell, a multiple of the identity.
    second_moment: Option<f64>,
}

pub struct Patch<const D: usize> {
    choices: KernelMethodChoices,
    law: Law,
    reference_vectors: SMatrix<f64, D, D>,
    /// Particles in the coordinates of the kernel, before displacements.
    particles: Vec<SVector<f64, D>>,
    undeformed: Vec<SVector<f64, D>>,
    /// Translations to the patch itself and to the images around it.
    images: Vec<SVector<f64, D>>,
    points: Vec<Point<D>>,
    radius: f64,
    metric: SMatrix<f64, D, D>,
    raw_factor: f64,
    mass: f64,
    only_up: bool,
}

fn determinant<const D: usize>(m: &SMatrix<f64, D, D>) -> f64 {
    if D == 1 {
        m[(0, 0)]
    } else {
        m[(0, 0)] * m[(1, 1)] - m[(0, 1)] * m[(1, 0)]
    }
}

fn inverse<const D: usize>(m: &SMatrix<f64, D, D>) -> SMatrix<f64, D, D> {
    if D == 1 {
        return SMatrix::repeat(1.0 / m[(0, 0)]);
    }
    let adjugate = |i: usize, j: usize| {
        if i == j {
            m[(1 - i, 1 - i)]
        } else {
            -m[(i, j)]
        }
    };
    SMatrix::from_fn(adjugate) / determinant(m)
}

fn counter<const D: usize>(index: usize, side: usize) -> SVector<f64, D> {
    SVector::from_fn(|i, _| (if i == 0 { index % side } else { index / side }) as f64)
}

/// Positions in the cell, with particles at the origin, and fractions of its volume.
fn rule(choices: &KernelMethodChoices, only_up: bool) -> Vec<([f64; 2], f64)> {
    let equal = |places: &[f64]| -> Vec<([f64; 2], f64)> {
        places
            .iter()
            .map(|&x| ([x, x], 1.0 / places.len() as f64))
            .collect()
    };
    let centers: &[f64] = match choices.lattice {
        LatticeKind::Hexagonal if only_up => &[1.0 / 3.0],
        LatticeKind::Hexagonal => &[1.0 / 3.0, 2.0 / 3.0],
        _ => &[0.5],
    };
    let both = [&[0.0], centers].concat();
    let line: &[(f64, f64)] = match choices.gauss_points {
        1 => &[(0.5, 1.0)],
        2 => &[
            (0.211_324_865_405_187_1, 0.5),
            (0.788_675_134_594_812_9, 0.5),
        ],
        3 => &[
            (0.112_701_665_379_258_3, 5.0 / 18.0),
            (0.5, 4.0 / 9.0),
            (0.887_298_334_620_741_7, 5.0 / 18.0),
        ],
        _ => &[
            (0.069_431_844_202_973_7, 0.173_927_422_568_726_9),
            (0.330_009_478_207_571_9, 0.326_072_577_431_273_1),
            (0.669_990_521_792_428_1, 0.326_072_577_431_273_1),
            (0.930_568_155_797_026_3, 0.173_927_422_568_726_9),
        ],
    };
    let is_line = choices.lattice == LatticeKind::Chain;
    match (choices.quadrature, choices.stress_point_weight) {
        (Quadrature::Nodal | Quadrature::NodalStabilized, _) => equal(&[0.0]),
        // All Voronoi cells are congruent: the union of the points is a Bravais lattice or a honeycomb.
        (Quadrature::StressPoints, None) => equal(&both),
        (Quadrature::StressPoints, Some(weight)) => both
            .iter()
            .map(|&x| match x {
                0.0 => ([0.0; 2], 1.0 - weight),
                x => ([x, x], weight / centers.len() as f64),
            })
            .collect(),
        (Quadrature::StressPointsOnly, _) => equal(centers),
        (Quadrature::Gauss, _) if is_line => line.iter().map(|&(x, w)| ([x, 0.0], w)).collect(),
        (Quadrature::Gauss, _) => line
            .iter()
            .flat_map(|&(x, w)| line.iter().map(move |&(y, v)| ([x, y], w * v)))
            .collect(),
        (Quadrature::Points, _) if is_line => {
            let points = choices.points.chunks(2);
            points.map(|p| ([p[0], 0.0], p[1])).collect()
        }
        (Quadrature::Points, _) => {
            let points = choices.points.chunks(3);
            points.map(|p| ([p[0], p[1]], p[2])).collect()
        }
    }
}

impl<const D: usize> Patch<D> {
    pub fn new(choices: KernelMethodChoices, law: Law, f: &DeformationGradient) -> Self {
        Self::with_triangles(choices, law, f, false)
    }

    /// Like `new`; for hexagonal stress points `only_up` keeps the points in triangles that point up, with the volume of both triangles.
    pub fn with_triangles(
        choices: KernelMethodChoices,
        law: Law,
        f: &DeformationGradient,
        only_up: bool,
    ) -> Self {
        let h = choices.spacing;
        let reference_vectors: SMatrix<f64, D, D> = match choices.lattice {
            LatticeKind::Chain | LatticeKind::Square => SMatrix::identity() * h,
            LatticeKind::Hexagonal => {
                SMatrix::from_fn(|i, j| [[1.0, 0.5], [0.0, 0.75_f64.sqrt()]][i][j] * h)
            }
            other => panic!("the patch has no lattice {other:?}"),
        };
        let leading: SMatrix<f64, D, D> = SMatrix::from_fn(|i, j| f.components()[i][j]);
        let eulerian = choices.frame == Frame::Eulerian;
        let moved = eulerian && choices.current_lattice == CurrentLattice::Convected;
        let home = if moved { leading } else { SMatrix::identity() };
        let vectors = home * reference_vectors;

        let (mut radius, mut metric) = (choices.support * h, SMatrix::identity());
        match choices.support_size {
            SupportSize::Scaled if eulerian => radius *= determinant(&leading).powf(1.0 / D as f64),
            SupportSize::Convected if eulerian => metric = inverse(&home),
            _ => {}
        }
        let integral = if D == 1 {
            0.8 * radius
        } else {
            PI / 5.0 * radius * radius
        };
        let raw_factor = determinant(&vectors) * determinant(&metric) / integral;

        let count = SIDE.pow(D as u32);
        let cells: Vec<SVector<f64, D>> = (0..count).map(|n| counter(n, SIDE)).collect();
        let images = (0..3_usize.pow(D as u32))
            .map(|n| vectors * counter::<D>(n, 3).map(|x| (x - 1.0) * SIDE as f64))
            .collect();
        let cell_volume = determinant(&reference_vectors);
        let mut patch = Self {
            choices: choices.clone(),
            law,
            reference_vectors,
            particles: cells.iter().map(|cell| vectors * cell).collect(),
            undeformed: cells.iter().map(|cell| reference_vectors * cell).collect(),
            images,
            points: Vec::new(),
            radius,
            metric,
            raw_factor,
            mass: choices.density * cell_volume,
            only_up,
        };

        let rule = rule(&choices, only_up);
        let second_moment = (choices.quadrature == Quadrature::NodalStabilized).then(|| {
            let volume = cell_volume;
            match choices.lattice {
                LatticeKind::Chain => volume.powi(3) / 12.0,
                LatticeKind::Square => volume * volume / 12.0,
                LatticeKind::Hexagonal => volume * volume * 5.0 / (36.0 * 3.0_f64.sqrt()),
                other => panic!("the patch has no lattice {other:?}"),
            }
        });
        for (n, cell) in cells.iter().enumerate() {
            for &(along, fraction) in &rule {
                let particle = (along == [0.0; 2]).then_some(n);
                let fractional = cell + SVector::from_fn(|i, _| along[i]);
                let place = vectors * fractional;
                let shapes = patch.shapes(&patch.particles, &place, particle);
                let deformation = patch.carried(f, &shapes);
                let hessians = patch.hessians(&place, particle);
                let reference = reference_vectors * fractional;
                let point = Point {
                    place,
                    reference,
                    particle,
                    volume: fraction * cell_volume,
                    deformation,
                    shapes,
                    hessians,
                    second_moment,
                };
                patch.points.push(point);
            }
        }
        patch
    }

    /// Deformation gradient of a point with these shape functions in the homogeneous state.
    fn carried(&self, f: &DeformationGradient, shapes: &[Shape<D>]) -> Matrix3<f64> {
        let mut carried = Matrix3::from_fn(|i, j| f.components()[i][j]);
        if self.choices.background == Background::Imposed {
            return carried;
        }
        let leading: SMatrix<f64, D, D> = SMatrix::from_fn(|i, j| carried[(i, j)]);
        // Interpolated displacement gradient of `x_K - X_K = a x_K`.
        let interpolated = |a: SMatrix<f64, D, D>| {
            shapes
                .iter()
                .map(|s| a * s.relative * s.gradient.transpose())
                .sum::<SMatrix<f64, D, D>>()
        };
        let one = SMatrix::<f64, D, D>::identity();
        let seen = match self.choices.frame {
            // F = 1 + grad_X u with u = (F - 1) X.
            Frame::Lagrangian => one + interpolated(leading - one),
            // F^-1 = 1 - grad_x u with u = (1 - F^-1) x.
            Frame::Eulerian => inverse(&(one - interpolated(one - inverse(&leading)))),
        };
        for i in 0..D {
            for j in 0..D {
                carried[(i, j)] = seen[(i, j)];
            }
        }
        carried
    }

    // ---- shape functions, by hyper-dual numbers in two components of the evaluation point ----------

    /// `phi_K` with its derivatives along the axes `j` and `t` of the evaluation point; `frozen` holds the normalization constant.
    fn hyperdual(
        &self,
        particles: &[SVector<f64, D>],
        x: &SVector<f64, D>,
        (j, t): (usize, usize),
        frozen: bool,
    ) -> Vec<(usize, SVector<f64, D>, HyperDual64)> {
        let mut seen = Vec::new();
        for (n, particle) in particles.iter().enumerate() {
            for image in &self.images {
                let relative = particle + image - x;
                let s = (self.metric * relative / self.radius).norm_squared();
                if s < (1.0 - 1e-12) * (1.0 - 1e-12) {
                    seen.push((n, relative));
                }
            }
        }
        let xi: Vec<[HyperDual64; D]> = seen
            .iter()
            .map(|(_, relative)| {
                std::array::from_fn(|i| {
                    let along = |axis| if i == axis { -1.0 } else { 0.0 };
                    HyperDual64::new(relative[i], along(j), along(t), 0.0)
                })
            })
            .collect();
        let weights: Vec<HyperDual64> = xi.iter().map(|xi| self.weight(xi)).collect();
        let one = HyperDual64::from(1.0);
        // The basis p(xi) and the coefficients alpha with (sum W p (x) p) alpha = e0.
        let degree = match self.choices.approximation {
            Approximation::Mls => 1,
            Approximation::Mls2 => 2,
            Approximation::Mls3 => 3,
            _ => 0,
        };
        let exponents: Vec<(i32, i32)> = (0..=degree)
            .flat_map(|of_y| (0..=degree - of_y).map(move |of_x| (of_x, of_y)))
            .filter(|(_, of_y)| D > 1 || *of_y == 0)
            .collect();
        let size = exponents.len();
        let basis = |k: usize, b: usize| {
            let power = |axis: usize, n: i32| {
                (0..n).fold(one, |product, _| product * xi[k][axis] / self.radius)
            };
            power(0, exponents[b].0) * power(D - 1, exponents[b].1)
        };
        let alpha = if self.choices.approximation == Approximation::Raw {
            vec![HyperDual64::from(self.raw_factor)]
        } else {
            let moment = |a: usize, b: usize| {
                (0..seen.len())
                    .map(|k| basis(k, a) * basis(k, b) * weights[k])
                    .fold(HyperDual64::from(0.0), |sum, term| sum + term)
            };
            solved(
                (0..size)
                    .map(|a| (0..size).map(|b| moment(a, b)).collect())
                    .collect(),
            )
        };
        let alpha: Vec<_> = alpha
            .into_iter()
            .map(|a| if frozen { HyperDual64::from(a.re) } else { a })
            .collect();
        let value = |k: usize| {
            (0..size)
                .map(|b| alpha[b] * basis(k, b))
                .fold(HyperDual64::from(0.0), |sum, a| sum + a)
                * weights[k]
        };
        (0..seen.len())
            .map(|k| (seen[k].0, seen[k].1, value(k)))
            .collect()
    }

    /// Equation (35) as printed, as a function of the squared distance, in which it is smooth at the particle.
    fn weight(&self, xi: &[HyperDual64; D]) -> HyperDual64 {
        let mut square = HyperDual64::from(0.0);
        for a in 0..D {
            let mut y = HyperDual64::from(0.0);
            for b in 0..D {
                y += xi[b] * (self.metric[(a, b)] / self.radius);
            }
            square += y * y;
        }
        // The second derivative of q^3 at zero is zero.
        let cube = if square.re == 0.0 {
            HyperDual64::from(0.0)
        } else {
            square * square.sqrt()
        };
        HyperDual64::from(1.0) - square * 6.0 + cube * 8.0 - square * square * 3.0
    }

    fn shapes(
        &self,
        particles: &[SVector<f64, D>],
        x: &SVector<f64, D>,
        own: Option<usize>,
    ) -> Vec<Shape<D>> {
        let shape = |(particle, relative, phi): (usize, SVector<f64, D>, HyperDual64)| Shape {
            particle,
            relative,
            value: phi.re,
            gradient: SVector::from_fn(|i, _| if i == 0 { phi.eps1 } else { phi.eps2 }),
        };
        let mut shapes: Vec<Shape<D>> = self
            .hyperdual(particles, x, (0, D - 1), false)
            .into_iter()
            .map(shape)
            .collect();
        let own = match self.choices.approximation {
            Approximation::RandlesLibersky => own,
            Approximation::KrongauzBelytschko => None,
            _ => return shapes,
        };
        // The gradient of a field f is C^T sum_K (f_K - f_0) g_K; here for the field that is one at I and zero elsewhere.
        let slopes: Vec<SVector<f64, D>> = shapes.iter().map(|s| self.slope(s)).collect();
        let at_point = |k: usize| match own {
            Some(own) => f64::from(u8::from(
                own == shapes[k].particle && shapes[k].relative.norm() < 0.1 * self.choices.spacing,
            )),
            None => shapes[k].value,
        };
        let gradient = |field: &dyn Fn(usize) -> f64| -> SVector<f64, D> {
            let center: f64 = (0..shapes.len()).map(|k| at_point(k) * field(k)).sum();
            (0..shapes.len())
                .map(|k| slopes[k] * (field(k) - center))
                .sum()
        };
        let mut seen = SMatrix::<f64, D, D>::zeros();
        for axis in 0..D {
            let of_coordinate = gradient(&|k| shapes[k].relative[axis]);
            seen.set_row(axis, &of_coordinate.transpose());
        }
        let correction = inverse(&seen).transpose();
        let gradients: Vec<SVector<f64, D>> = (0..shapes.len())
            .map(|i| correction * gradient(&|k| if k == i { 1.0 } else { 0.0 }))
            .collect();
        for (shape, gradient) in shapes.iter_mut().zip(gradients) {
            shape.gradient = gradient;
        }
        shapes
    }

    /// Gradient of a weight with respect to the evaluation point.
    fn slope(&self, shape: &Shape<D>) -> SVector<f64, D> {
        let xi: [HyperDual64; D] = std::array::from_fn(|i| {
            let along = |axis: usize| if i == axis { -1.0 } else { 0.0 };
            HyperDual64::new(shape.relative[i], along(0), along(D - 1), 0.0)
        });
        let weight = self.weight(&xi);
        SVector::from_fn(|i, _| if i == 0 { weight.eps1 } else { weight.eps2 })
    }

    fn hessians(&self, x: &SVector<f64, D>, own: Option<usize>) -> Vec<SMatrix<f64, D, D>> {
        use Approximation::{KrongauzBelytschko, RandlesLibersky};
        if let RandlesLibersky | KrongauzBelytschko = self.choices.approximation {
            return self.differences(x, own);
        }
        let frozen = self.choices.linearization == Linearization::FrozenNormalization;
        let component = |j: usize, t: usize| self.hyperdual(&self.particles, x, (j, t), frozen);
        let components: Vec<_> = (0..D * D).map(|n| component(n / D, n % D)).collect();
        (0..components[0].len())
            .map(|k| SMatrix::from_fn(|j, t| components[j * D + t][k].2.eps1eps2))
            .collect()
    }

    /// Derivatives of corrected gradients by finite differences.
    fn differences(&self, x: &SVector<f64, D>, own: Option<usize>) -> Vec<SMatrix<f64, D, D>> {
        // The second derivative of the weight of a particle has a kink at the particle: the formula is exact for x, x|x| and x^3.
        let h = 1e-4 * self.choices.spacing;
        let mut hessians =
            vec![SMatrix::<f64, D, D>::zeros(); self.shapes(&self.particles, x, own).len()];
        let ahead = [(1.0, 9.0), (2.0, -4.5), (3.0, 1.0)];
        let behind = ahead.map(|(steps, factor)| (-steps, -factor));
        for t in 0..D {
            for (steps, factor) in ahead.into_iter().chain(behind) {
                let mut moved = *x;
                moved[t] += steps * h;
                let shapes = self.shapes(&self.particles, &moved, own);
                for (hessian, shape) in hessians.iter_mut().zip(shapes) {
                    let column = hessian.column(t) + shape.gradient * (factor / (6.0 * h));
                    hessian.set_column(t, &column);
                }
            }
        }
        hessians
    }

    // ---- forces --------------------------------------------------------------------------------

    /// Returns the internal forces for the displacements `u` of the particles and the displacement `wave` of free stress points, if the linearization
    /// moves them with the plane wave.
    fn forces(
        &self,
        u: &[SVector<f64, D>],
        wave: &dyn Fn(&SVector<f64, D>) -> SVector<f64, D>,
    ) -> Vec<SVector<f64, D>> {
        use Linearization::{Exact, ExactPlaneWave, FrozenNormalization, Paper, PaperInterpolated};
        let mut forces = vec![SVector::zeros(); u.len()];
        let moved: Vec<SVector<f64, D>> =
            self.particles.iter().zip(u).map(|(x, u)| x + u).collect();
        for point in &self.points {
            let strain: SMatrix<f64, D, D> = point
                .shapes
                .iter()
                .map(|s| u[s.particle] * s.gradient.transpose())
                .sum();
            if self.choices.frame == Frame::Lagrangian {
                // The kernel is in material coordinates: F = F0 + sum u_K (x) grad phi_K.
                let mut f = point.deformation;
                f.fixed_view_mut::<D, D>(0, 0)
                    .zip_apply(&strain, |f, s| *f += s);
                let stress = self.law.first_piola(&f);
                for s in &point.shapes {
                    forces[s.particle] += leading(&stress) * s.gradient * point.volume;
                }
                if let Some(moment) = point.second_moment {
                    self.add_stress_gradients(point, moment, &f, u, &mut forces);
                }
                continue;
            }
            // Fdot = L F with L in the homogeneous state: to first order every update of F has this form.
            let mut update = Matrix3::<f64>::identity();
            update
                .fixed_view_mut::<D, D>(0, 0)
                .zip_apply(&strain, |one, s| *one += s);
            let f = update * point.deformation;
            let sigma = leading::<D>(&self.law.cauchy(&f)) * (f.determinant() * point.volume);
            let interpolated: SVector<f64, D> =
                point.shapes.iter().map(|s| u[s.particle] * s.value).sum();
            let shift = match (point.particle, self.choices.linearization) {
                (Some(particle), _) => u[particle],
                (None, Exact | PaperInterpolated) => interpolated,
                (None, Paper | ExactPlaneWave | FrozenNormalization) => wave(&point.reference),
            };
            match self.choices.linearization {
                Exact | ExactPlaneWave => {
                    for s in self.shapes(&moved, &(point.place + shift), point.particle) {
                        forces[s.particle] += sigma * s.gradient;
                    }
                }
                // Equation (49): d(phi_I,j) = phi_I,jt (u_q - u_I).
                Paper | PaperInterpolated | FrozenNormalization => {
                    for (s, hessian) in point.shapes.iter().zip(&point.hessians) {
                        forces[s.particle] +=
                            sigma * (s.gradient + hessian * (shift - u[s.particle]));
                    }
                }
            }
        }
        forces
    }

    /// Forces of the second moments of a cell, `M P_,l : grad phi_I,l` with `P_,l = A : F_,l`, which is linear in the strain gradient to second
    /// order.
    fn add_stress_gradients(
        &self,
        point: &Point<D>,
        moment: f64,
        f: &Matrix3<f64>,
        u: &[SVector<f64, D>],
        forces: &mut [SVector<f64, D>],
    ) {
        for l in 0..D {
            let mut slope = Matrix3::zeros();
            for (s, hessian) in point.shapes.iter().zip(&point.hessians) {
                let part = u[s.particle] * hessian.column(l).transpose();
                slope
                    .fixed_view_mut::<D, D>(0, 0)
                    .zip_apply(&part, |a, b| *a += b);
            }
            let stress =
                (self.law.first_piola(&(f + slope)) - self.law.first_piola(&(f - slope))) * 0.5;
            for (s, hessian) in point.shapes.iter().zip(&point.hessians) {
                forces[s.particle] += leading(&stress) * hessian.column(l) * moment;
            }
        }
    }

    /// Derivative of the forces per mass along a displacement, by central differences of fourth order.
    fn derivative(
        &self,
        u: &[SVector<f64, D>],
        wave: &dyn Fn(&SVector<f64, D>) -> SVector<f64, D>,
    ) -> Vec<SVector<f64, D>> {
        let h = STEP * self.choices.spacing;
        let at = |t: f64| {
            let displaced: Vec<SVector<f64, D>> = u.iter().map(|u| u * t).collect();
            self.forces(&displaced, &|x| wave(x) * t)
        };
        let (near, far) = ([at(h), at(-h)], [at(2.0 * h), at(-2.0 * h)]);
        (0..u.len())
            .map(|i| {
                ((near[0][i] - near[1][i]) * 8.0 - (far[0][i] - far[1][i])) / (12.0 * h * self.mass)
            })
            .collect()
    }

    /// Stiffness of the patch per mass, particle by particle.
    pub fn stiffness(&self) -> DMatrix<f64> {
        let count = self.particles.len();
        let mut stiffness = DMatrix::zeros(D * count, D * count);
        for column in 0..D * count {
            let mut u = vec![SVector::zeros(); count];
            u[column / D][column % D] = 1.0;
            let still = |_: &SVector<f64, D>| SVector::zeros();
            for (i, force) in self.derivative(&u, &still).into_iter().enumerate() {
                for a in 0..D {
                    stiffness[(D * i + a, column)] = force[a];
                }
            }
        }
        stiffness
    }

    /// Wave vectors that fit into the patch.
    pub fn commensurate(&self) -> Vec<SVector<f64, D>> {
        let reciprocal = inverse(&self.reference_vectors).transpose() * TAU;
        (0..SIDE.pow(D as u32))
            .map(|n| reciprocal * counter::<D>(n, SIDE) / SIDE as f64)
            .collect()
    }

    /// Dynamical matrix of the crate.
    pub fn dynamical_matrix(
        &self,
        f: &DeformationGradient,
        k: &SVector<f64, D>,
    ) -> SMatrix<Complex<f64>, D, D> {
        let mut method = Method::<D>::new(self.choices.clone()).expect("an admissible method");
        if self.only_up {
            let volume = determinant(&self.reference_vectors);
            let place = SVector::repeat(1.0 / 3.0);
            let points = vec![QuadraturePoint::new(place, volume)];
            method = method.with_quadrature_points(points);
        }
        dynamical_matrix(&method, &*self.law.material(), f)
            .expect("an admissible state")
            .at(k)
    }

    /// Returns the largest deviation, over all particles, commensurate waves and polarizations, of the forces of a
    /// wave on the patch from `D(k) g exp(i k.X)`, relative to the largest entry of any `D(k)`. Because the
    /// residual vanishes at *every* particle, the projection on waves is complete.
    pub fn deviation(&self, f: &DeformationGradient) -> f64 {
        let stiffness = self.stiffness();
        let count = self.particles.len();
        let (mut deviation, mut largest) = (0.0_f64, 0.0_f64);
        for k in self.commensurate() {
            let d = self.dynamical_matrix(f, &k);
            largest = largest.max(d.iter().map(|entry| entry.norm()).fold(0.0, f64::max));
            for i in 0..count {
                let mut sum = SMatrix::<Complex<f64>, D, D>::zeros();
                for j in 0..count {
                    let phase = Complex::cis(k.dot(&(self.undeformed[j] - self.undeformed[i])));
                    for a in 0..D {
                        for b in 0..D {
                            sum[(a, b)] += phase * stiffness[(D * i + a, D * j + b)];
                        }
                    }
                }
                deviation = (sum - d)
                    .iter()
                    .map(|entry| entry.norm())
                    .fold(deviation, f64::max);
            }
        }
        deviation / largest
    }

    /// Like `deviation`, wave by wave with separate real and imaginary parts, for linearizations in which stress points move with the wave; also for
    /// wave vectors beyond the first zone.
    pub fn deviation_of_waves(&self, f: &DeformationGradient, waves: &[SVector<f64, D>]) -> f64 {
        let (mut deviation, mut largest) = (0.0_f64, 0.0_f64);
        for k in waves {
            let d = self.dynamical_matrix(f, k);
            largest = largest.max(d.iter().map(|entry| entry.norm()).fold(0.0, f64::max));
            for b in 0..D {
                let part = |phase: fn(f64) -> f64| {
                    let wave = |x: &SVector<f64, D>| {
                        SVector::from_fn(|i, _| if i == b { phase(k.dot(x)) } else { 0.0 })
                    };
                    let u: Vec<SVector<f64, D>> = self.undeformed.iter().map(wave).collect();
                    self.derivative(&u, &wave)
                };
                let (real, imaginary) = (part(f64::cos), part(f64::sin));
                for (i, x) in self.undeformed.iter().enumerate() {
                    for a in 0..D {
                        let force = Complex::new(real[i][a], imaginary[i][a]);
                        let expected = d[(a, b)] * Complex::cis(k.dot(x));
                        deviation = deviation.max((force - expected).norm());
                    }
                }
            }
        }
        deviation / largest
    }
}

fn leading<const D: usize>(m: &Matrix3<f64>) -> SMatrix<f64, D, D> {
    SMatrix::from_fn(|i, j| m[(i, j)])
}

/// Solution of `M x = e0` by elimination; `M` is positive definite.
fn solved(mut m: Vec<Vec<HyperDual64>>) -> Vec<HyperDual64> {
    let size = m.len();
    let mut x: Vec<HyperDual64> = (0..size)
        .map(|i| HyperDual64::from(if i == 0 { 1.0 } else { 0.0 }))
        .collect();
    for pivot in 0..size {
        for row in pivot + 1..size {
            let factor = m[row][pivot] / m[pivot][pivot];
            for column in pivot..size {
                m[row][column] = m[row][column] - factor * m[pivot][column];
            }
            x[row] = x[row] - factor * x[pivot];
        }
    }
    for row in (0..size).rev() {
        for column in row + 1..size {
            x[row] = x[row] - m[row][column] * x[column];
        }
        x[row] /= m[row][row];
    }
    x
}

/// Checks that patch and dynamical matrix agree; the tolerance covers the error of the differences.
#[track_caller]
pub fn assert_agrees<const D: usize>(
    choices: KernelMethodChoices,
    law: Law,
    f: &DeformationGradient,
) {
    let deviation = Patch::<D>::new(choices.clone(), law, f).deviation(f);
    assert!(
        deviation < 2e-9,
        "relative deviation {deviation:e} for {choices:?}, {law:?}, {f:?}"
    );
}

pub fn state(f: [[f64; 2]; 2], out_of_plane: f64) -> DeformationGradient {
    DeformationGradient::plane_strain(f, out_of_plane).expect("an admissible state")
}
