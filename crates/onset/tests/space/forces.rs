//! Comparison of `D(k)` with the derivative of the discrete forces on one particle of the infinite body under a plane wave.

use crate::{CUBIC, discretization, state};
use nalgebra::{Matrix3, Vector3};
use onset::bloch::dynamical_matrix;
use onset::lattice::LatticeKind;
use onset::material::{Hyperelastic, ModifiedMooneyRivlin};
use onset::method::{Frame, KernelMethodChoices, Method};
use onset::quadrature::Quadrature;

/// Half step of the differentiation; the error of the five-point formula is of fourth order.
const STEP: f64 = 2e-4;

/// Infinite body: particles in the coordinates of the kernel, with their reference positions.
struct Body {
    method: Method<3>,
    f: Matrix3<f64>,
    radius: f64,
    particles: Vec<(Vector3<f64>, Vector3<f64>)>,
}

/// Quartic spline divided by its value at the particle, and its gradient at `relative` from the particle.
fn weight(relative: &Vector3<f64>, radius: f64) -> Option<(f64, Vector3<f64>)> {
    let q = relative.norm() / radius;
    (q < 1.0).then(|| {
        let value = 1.0 - 6.0 * q * q + 8.0 * q.powi(3) - 3.0 * q.powi(4);
        (
            value,
            relative * (-12.0 * (1.0 - q).powi(2) / (radius * radius)),
        )
    })
}

impl Body {
    fn new(discretization: KernelMethodChoices, f: Matrix3<f64>) -> Self {
        let method = Method::<3>::new(discretization).expect("a method");
        let home = match method.choices().frame {
            Frame::Eulerian => f,
            Frame::Lagrangian => Matrix3::identity(),
        };
        let range = || -7..=7;
        let particles = range()
            .flat_map(|i| range().flat_map(move |j| range().map(move |k| [i, j, k])))
            .map(|cell| method.lattice().vectors() * Vector3::from(cell.map(f64::from)))
            .map(|reference| (home * reference, reference))
            .filter(|(x, _)| x.norm() < 4.5 * method.support_radius())
            .collect();
        Self {
            radius: method.support_radius(),
            method,
            f,
            particles,
        }
    }

    /// Shepard functions at a point among particles displaced by `u`: particle, value, gradient.
    fn shapes(&self, place: &Vector3<f64>, u: &[Vector3<f64>]) -> Vec<(usize, f64, Vector3<f64>)> {
        let seen: Vec<_> = self
            .particles
            .iter()
            .enumerate()
            .filter_map(|(n, (x, _))| Some((n, weight(&(place - x - u[n]), self.radius)?)))
            .collect();
        let sum: f64 = seen.iter().map(|(_, (w, _))| w).sum();
        let slope: Vector3<f64> = seen.iter().map(|(_, (_, g))| g).sum();
        seen.into_iter()
            .map(|(n, (w, g))| (n, w / sum, g / sum - slope * (w / (sum * sum))))
            .collect()
    }

    /// Force on the particle at the origin for particles displaced by a wave `u(X)`.
    fn force(&self, wave: &dyn Fn(&Vector3<f64>) -> Vector3<f64>) -> Vector3<f64> {
        let law = ModifiedMooneyRivlin::default();
        let eulerian = self.method.choices().frame == Frame::Eulerian;
        let u: Vec<Vector3<f64>> = self.particles.iter().map(|(_, x)| wave(x)).collect();
        let still = vec![Vector3::zeros(); u.len()];
        let vectors = self.method.lattice().vectors();
        let home = if eulerian {
            self.f
        } else {
            Matrix3::identity()
        };
        let origin = self
            .particles
            .iter()
            .position(|(_, x)| x.norm() == 0.0)
            .expect("the origin");
        let mut force = Vector3::zeros();
        for (_, cell) in self.particles.iter() {
            for point in self.method.quadrature_points() {
                let place = home * (cell + vectors * point.place);
                if place.norm() > 1.1 * self.radius {
                    continue;
                }
                let rest = self.shapes(&place, &still);
                let gradient: Matrix3<f64> =
                    rest.iter().map(|(n, _, g)| u[*n] * g.transpose()).sum();
                if !eulerian {
                    let piola = law
                        .response(&state(&(self.f + gradient)))
                        .expect("a stress")
                        .first_piola;
                    let own = rest.iter().filter(|(n, _, _)| *n == origin);
                    force += own
                        .map(|(_, _, g)| piola * g * point.volume)
                        .sum::<Vector3<f64>>();
                    continue;
                }
                let f = (Matrix3::identity() + gradient) * self.f;
                let response = law.response(&state(&f)).expect("a stress");
                let tension = response.first_piola * f.transpose();
                let shift = if point.is_node {
                    wave(cell)
                } else {
                    rest.iter().map(|(n, value, _)| u[*n] * *value).sum()
                };
                let moved = self.shapes(&(place + shift), &u);
                let own = moved.iter().filter(|(n, _, _)| *n == origin);
                force += own
                    .map(|(_, _, g)| tension * g * point.volume)
                    .sum::<Vector3<f64>>();
            }
        }
        force
    }

    /// Derivative of the force per mass along a wave.
    fn derivative(&self, wave: &dyn Fn(&Vector3<f64>) -> Vector3<f64>) -> Vector3<f64> {
        let at = |t: f64| self.force(&|x| wave(x) * t);
        let h = STEP;
        let difference = (at(h) - at(-h)) * 8.0 - (at(2.0 * h) - at(-2.0 * h));
        difference / (12.0 * h * self.method.particle_mass())
    }
}

#[track_caller]
fn assert_agrees(discretization: KernelMethodChoices, f: Matrix3<f64>, k: Vector3<f64>) {
    let body = Body::new(discretization.clone(), f);
    let law = ModifiedMooneyRivlin::default();
    let d = dynamical_matrix(&body.method, &law, &state(&f))
        .expect("a state")
        .at(&k);
    let largest = d.iter().map(|entry| entry.norm()).fold(0.0, f64::max);
    for axis in 0..3 {
        let unit = Vector3::from_fn(|i, _| f64::from(u8::from(i == axis)));
        let real = body.derivative(&|x| unit * k.dot(x).cos());
        let imaginary = body.derivative(&|x| unit * k.dot(x).sin());
        for i in 0..3 {
            let entry = d[(i, axis)];
            let deviation = (entry.re - real[i]).hypot(entry.im - imaginary[i]) / largest;
            assert!(
                deviation < 1e-8,
                "{deviation:e} in {i}{axis} of {discretization:?}"
            );
        }
    }
}

fn sheared() -> Matrix3<f64> {
    Matrix3::new(1.1, 0.2, -0.1, -0.05, 0.9, 0.15, 0.1, 0.0, 1.05)
}

#[test]
fn forces_on_displaced_particles_agree_with_the_dynamical_matrix() {
    let k = Vector3::new(1.3, -0.7, 2.1);
    for kind in CUBIC {
        for frame in [Frame::Lagrangian, Frame::Eulerian] {
            assert_agrees(discretization(kind, frame, Quadrature::Nodal), sheared(), k);
        }
    }
}

#[test]
fn forces_with_stress_points_in_the_holes_agree_with_the_dynamical_matrix() {
    let k = Vector3::new(-0.4, 1.9, 0.8);
    for (kind, frame) in [
        (LatticeKind::SimpleCubic, Frame::Eulerian),
        (LatticeKind::FaceCenteredCubic, Frame::Lagrangian),
        (LatticeKind::BodyCenteredCubic, Frame::Lagrangian),
    ] {
        let choices = discretization(kind, frame, Quadrature::StressPoints);
        assert_agrees(
            KernelMethodChoices {
                support: 1.3,
                ..choices
            },
            sheared(),
            k,
        );
    }
}
