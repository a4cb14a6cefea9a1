//! A periodic patch of particles with its nonlinear internal forces.

use crate::law::Law;
use nalgebra::{Complex, DMatrix, Matrix3, SMatrix, SVector};
use num_dual::{DualNum, HyperDual64};
use onset::approximation::Approximation;
use onset::bloch::dynamical_matrix;
use onset::kinematics::DeformationGradient;
use onset::lattice::Arrangement;
use onset::method::{
    Background, CurrentLattice, Discretization, Frame, Linearization, Method, SupportSize,
};
use onset::quadrature::{Quadrature, QuadraturePoint};
use std::f64::consts::{PI, TAU};

/// Cells of the patch along each primitive vector: a multiple of six has the wave vectors M, X and K.
const SIDE: usize = 6;
/// Half step of the differentiation, in units of the spacing; the five-point formula is exact to its fourth power.
const STEP: f64 = 2e-4;

/// One shape function at a point.
#[derive(Clone, Copy)]
pub struct Shape<const D: usize> {
    particle: usize,
    /// `x_K - x` of the image that is seen.
    relative: SVector<f64, D>,
    value: f64,
    gradient: SVector<f64, D>,
}

struct Point<const D: usize> {
    /// In the coordinates of the kernel, at rest.
    place: SVector<f64, D>,
    /// In the undeformed body.
    reference: SVector<f64, D>,
    /// The particle that it is, unless it is a stress point.
    particle: Option<usize>,
    volume: f64,
    /// The deformation gradient that it carries at rest.
    deformation: Matrix3<f64>,
    /// Shape functions at rest.
    shapes: Vec<Shape<D>>,
    /// `phi_I,jt` at rest, beside `shapes`; only for the linearizations that freeze something.
    hessians: Vec<SMatrix<f64, D, D>>,
}

pub struct Patch<const D: usize> {
    choices: Discretization,
    law: Law,
    reference_vectors: SMatrix<f64, D, D>,
    /// Particles in the coordinates of the kernel, at rest.
    particles: Vec<SVector<f64, D>>,
    undeformed: Vec<SVector<f64, D>>,
    /// Translations to the patch's own image and those around it.
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

impl<const D: usize> Patch<D> {
    pub fn new(choices: Discretization, law: Law, f: &DeformationGradient) -> Self {
        Self::with_triangles(choices, law, f, false)
    }

    /// As `new`; of the hexagonal stress points, `only_up` keeps those in triangles that point up, with the
    /// volume of both.
    pub fn with_triangles(
        choices: Discretization,
        law: Law,
        f: &DeformationGradient,
        only_up: bool,
    ) -> Self {
        let h = choices.spacing;
        let reference_vectors: SMatrix<f64, D, D> = match choices.arrangement {
            Arrangement::Chain | Arrangement::Square => SMatrix::identity() * h,
            Arrangement::Hexagonal => {
                SMatrix::from_fn(|i, j| [[1.0, 0.5], [0.0, 0.75_f64.sqrt()]][i][j] * h)
            }
        };
        let leading: SMatrix<f64, D, D> = SMatrix::from_fn(|i, j| f.components()[i][j]);
        let eulerian = choices.frame == Frame::Eulerian;
        let moved = eulerian && choices.lattice == CurrentLattice::Convected;
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

        let centers: &[f64] = match choices.arrangement {
            Arrangement::Hexagonal if only_up => &[1.0 / 3.0],
            Arrangement::Hexagonal => &[1.0 / 3.0, 2.0 / 3.0],
            _ => &[0.5],
        };
        let (nodes, centers): (&[f64], &[f64]) = match choices.quadrature {
            Quadrature::Nodal => (&[0.0], &[]),
            Quadrature::StressPoints => (&[0.0], centers),
            Quadrature::StressPointsOnly => (&[], centers),
        };
        // All Voronoi cells are congruent: the union of the points is a Bravais lattice or a honeycomb.
        let volume = cell_volume / (nodes.len() + centers.len()) as f64;
        for (n, cell) in cells.iter().enumerate() {
            for (particle, &along) in nodes
                .iter()
                .map(|x| (Some(n), x))
                .chain(centers.iter().map(|x| (None, x)))
            {
                let fractional = cell.map(|x| x + along);
                let place = vectors * fractional;
                let shapes = patch.shapes(&patch.particles, &place);
                let deformation = patch.carried(f, &shapes);
                let hessians = patch.hessians(&place);
                let reference = reference_vectors * fractional;
                let point = Point {
                    place,
                    reference,
                    particle,
                    volume,
                    deformation,
                    shapes,
                    hessians,
                };
                patch.points.push(point);
            }
        }
        patch
    }

    /// The deformation gradient that a point with these shape functions carries in the homogeneous state.
    fn carried(&self, f: &DeformationGradient, shapes: &[Shape<D>]) -> Matrix3<f64> {
        let mut carried = Matrix3::from_fn(|i, j| f.components()[i][j]);
        if self.choices.background == Background::Imposed {
            return carried;
        }
        let leading: SMatrix<f64, D, D> = SMatrix::from_fn(|i, j| carried[(i, j)]);
        // The displacement gradient that the shape functions make of `x_K - X_K = a x_K`.
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

    /// `phi_K` with its derivatives along the axes `j` and `t` of the evaluation point; `frozen` holds the
    /// normalization at its value.
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
        let size = if self.choices.approximation == Approximation::Mls {
            D + 1
        } else {
            1
        };
        let basis = |k: usize, b: usize| if b == 0 { one } else { xi[k][b - 1] };
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

    /// Equation (35) as printed, in the square of the distance, in which it is smooth at the particle.
    fn weight(&self, xi: &[HyperDual64; D]) -> HyperDual64 {
        let mut square = HyperDual64::from(0.0);
        for a in 0..D {
            let mut y = HyperDual64::from(0.0);
            for b in 0..D {
                y += xi[b] * (self.metric[(a, b)] / self.radius);
            }
            square += y * y;
        }
        // q^3 has no second derivative at zero other than zero.
        let cube = if square.re == 0.0 {
            HyperDual64::from(0.0)
        } else {
            square * square.sqrt()
        };
        HyperDual64::from(1.0) - square * 6.0 + cube * 8.0 - square * square * 3.0
    }

    fn shapes(&self, particles: &[SVector<f64, D>], x: &SVector<f64, D>) -> Vec<Shape<D>> {
        let shape = |(particle, relative, phi): (usize, SVector<f64, D>, HyperDual64)| Shape {
            particle,
            relative,
            value: phi.re,
            gradient: SVector::from_fn(|i, _| if i == 0 { phi.eps1 } else { phi.eps2 }),
        };
        self.hyperdual(particles, x, (0, D - 1), false)
            .into_iter()
            .map(shape)
            .collect()
    }

    fn hessians(&self, x: &SVector<f64, D>) -> Vec<SMatrix<f64, D, D>> {
        let frozen = self.choices.linearization == Linearization::FrozenNormalization;
        let component = |j: usize, t: usize| self.hyperdual(&self.particles, x, (j, t), frozen);
        let components: Vec<_> = (0..D * D).map(|n| component(n / D, n % D)).collect();
        (0..components[0].len())
            .map(|k| SMatrix::from_fn(|j, t| components[j * D + t][k].2.eps1eps2))
            .collect()
    }

    // ---- forces --------------------------------------------------------------------------------

    /// The internal forces when the particles are displaced by `u` and free stress points (where the
    /// linearization moves them with the plane wave) by `wave`.
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
                // The kernel is one of material coordinates: F = F0 + sum u_K (x) grad phi_K.
                let mut f = point.deformation;
                f.fixed_view_mut::<D, D>(0, 0)
                    .zip_apply(&strain, |f, s| *f += s);
                let stress = self.law.first_piola(&f);
                for s in &point.shapes {
                    forces[s.particle] += leading(&stress) * s.gradient * point.volume;
                }
                continue;
            }
            // Fdot = L F with L at rest: to first order every update of F is this one.
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
                    for s in self.shapes(&moved, &(point.place + shift)) {
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

    /// The derivative of the forces per mass along a displacement, by central differences of fourth order.
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

    /// The stiffness of the patch per mass, particle by particle.
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

    /// The wave vectors that fit into the patch.
    pub fn commensurate(&self) -> Vec<SVector<f64, D>> {
        let reciprocal = inverse(&self.reference_vectors).transpose() * TAU;
        (0..SIDE.pow(D as u32))
            .map(|n| reciprocal * counter::<D>(n, SIDE) / SIDE as f64)
            .collect()
    }

    /// The crate's answer.
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

    /// The largest deviation, over all particles, commensurate waves and polarizations, of the forces of a
    /// wave on the patch from `D(k) g exp(i k.X)`, relative to the largest entry of any `D(k)`. That the
    /// residual vanishes at *every* particle makes the projection on waves complete.
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

    /// As `deviation`, wave by wave with real and imaginary part apart, for linearizations in which stress
    /// points move with the wave; also for wave vectors beyond the first zone.
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

/// The solution of `M x = e0` by elimination; `M` is positive definite.
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

/// Asserts that patch and dynamical matrix agree; the tolerance leaves the error of the differences.
#[track_caller]
pub fn assert_agrees<const D: usize>(choices: Discretization, law: Law, f: &DeformationGradient) {
    let deviation = Patch::<D>::new(choices.clone(), law, f).deviation(f);
    assert!(
        deviation < 2e-9,
        "relative deviation {deviation:e} for {choices:?}, {law:?}, {f:?}"
    );
}

pub fn state(f: [[f64; 2]; 2], out_of_plane: f64) -> DeformationGradient {
    DeformationGradient::plane_strain(f, out_of_plane).expect("an admissible state")
}
