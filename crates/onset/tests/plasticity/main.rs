//! Plasticity and its localization compared with differentiation, closed forms and independent solutions.

mod coaxial;
mod critical;
mod finite;
mod hypoelastic;
mod laws;
mod metal;
mod paths;
mod return_mapping;
mod rudnicki_rice;

use nalgebra::{Matrix3, Rotation3, Vector3};
use onset::plasticity::{DruckerPrager, Hardening};

/// One strength for each hardening law.
const STRENGTHS: [Hardening; 6] = [
    Hardening::linear(1.0, 8.0),
    Hardening::linear(1.0, -5.0),
    Hardening::voce(1.0, 1.6, 0.02),
    Hardening::voce(1.0, 0.4, 0.03),
    Hardening::power(1.0, 0.01, 0.2),
    Hardening::Peak {
        initial: 1.0,
        residual: 0.5,
        modulus: 60.0,
        reference: 0.02,
    },
];

fn law(friction: f64, dilatancy: f64, strength: Hardening) -> DruckerPrager {
    DruckerPrager::new(100.0, 0.25, friction, dilatancy, strength).expect("a law")
}

/// Irregular numbers in `(-1, 1)`, reproducible in every run.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn matrix(&mut self) -> Matrix3<f64> {
        Matrix3::from_fn(|_, _| self.next())
    }

    fn symmetric(&mut self) -> Matrix3<f64> {
        let matrix = self.matrix();
        (matrix + matrix.transpose()) * 0.5
    }

    fn rotation(&mut self) -> Matrix3<f64> {
        let axis = Vector3::from_fn(|_, _| 3.0 * self.next());
        *Rotation3::new(axis).matrix()
    }
}

/// Strain without symmetry for which every law of [`STRENGTHS`] flows.
fn flowing(numbers: &mut Numbers) -> Matrix3<f64> {
    let base = Matrix3::from_diagonal(&Vector3::new(0.018, -0.006, -0.026));
    let turn = numbers.rotation();
    turn * base * turn.transpose() + numbers.symmetric() * 0.006
}

/// Directions spread evenly over the half sphere.
fn directions(count: usize) -> impl Iterator<Item = Vector3<f64>> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    (0..count).map(move |n| {
        let height = (n as f64 + 0.5) / count as f64;
        let radius = (1.0 - height * height).sqrt();
        let angle = golden * n as f64;
        Vector3::new(radius * angle.cos(), radius * angle.sin(), height)
    })
}
