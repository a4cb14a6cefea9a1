//! Elasticity tensors of sections 3 and 5, compared with the stress rates that define them.

use crate::table::{Random, delta, differentiated, laws, of, quadruples};
use nalgebra::Matrix3;
use onset::kinematics::DeformationGradient;
use onset::material::{FourthOrder, Response};

fn contracted(tensor: &FourthOrder, m: &Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| {
        quadruples()
            .filter(|n| (n.0, n.1) == (i, j))
            .map(|n| tensor[n] * m[(n.2, n.3)])
            .sum()
    })
}

/// Rate of a matrix along a path of states.
fn rate(path: impl Fn(f64) -> Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| differentiated(1e-3, |t| path(t)[(i, j)]))
}

/// Response, `L`, and response along the motion, for random states and velocity gradients of every law.
fn for_motions(
    seed: u64,
    check: impl Fn(&str, &Response, &Matrix3<f64>, &dyn Fn(f64) -> Response, f64),
) {
    for entry in laws() {
        let mut random = Random::new(seed);
        for _ in 0..20 {
            let (f, l) = (random.state(), random.matrix());
            let response = entry.law.response(&f).expect("finite");
            let along = |t: f64| {
                let moved: DeformationGradient = of(&((Matrix3::identity() + l * t) * f.matrix()));
                entry.law.response(&moved).expect("finite")
            };
            let scale = quadruples()
                .map(|n| response.tangent[n].abs())
                .fold(0.0, f64::max);
            check(entry.name, &response, &l, &along, scale);
        }
    }
}

#[track_caller]
fn assert_equal(name: &str, computed: Matrix3<f64>, defined: Matrix3<f64>, scale: f64) {
    let error = (computed - defined).amax();
    // The error of the differences grows with the fifth derivative of the stress.
    assert!(
        error < 1e-7 * scale,
        "{name}: off by {error:e} of {scale:e}"
    );
}

fn rate_of_deformation(l: &Matrix3<f64>) -> Matrix3<f64> {
    (l + l.transpose()) * 0.5
}

#[test]
fn the_fourth_elasticity_tensor_gives_the_convected_rate_of_kirchhoff_stress() {
    for_motions(11, |name, response, l, along, scale| {
        let kirchhoff = |r: &Response| r.cauchy() * r.deformation.jacobian();
        let tau = kirchhoff(response);
        let convected = rate(|t| kirchhoff(&along(t))) - l * tau - tau * l.transpose();
        let computed = contracted(&response.fourth_elasticity(), &rate_of_deformation(l));
        assert_equal(name, computed, convected, scale);
    });
}

#[test]
fn the_truesdell_tangent_gives_the_truesdell_rate_of_cauchy_stress() {
    for_motions(12, |name, response, l, along, scale| {
        let sigma = response.cauchy();
        let truesdell =
            rate(|t| along(t).cauchy()) + sigma * l.trace() - l * sigma - sigma * l.transpose();
        let computed = contracted(&response.truesdell_tangent(), &rate_of_deformation(l));
        assert_equal(name, computed, truesdell, scale);
    });
}

#[test]
fn equation_22_gives_the_rate_of_nominal_stress() {
    for_motions(13, |name, response, l, along, scale| {
        let rate_of_f = l * response.deformation.matrix();
        let nominal = rate(|t| along(t).first_piola.transpose());
        assert_equal(
            name,
            contracted(&response.effective_tangent(), &rate_of_f),
            nominal,
            scale,
        );
        // The published form, with the second elasticity tensor, agrees.
        let (c, s, f) = (
            response.second_elasticity(),
            response.second_piola(),
            response.deformation.matrix(),
        );
        let printed = FourthOrder::from_fn(|i, j, k, l| {
            let mut sum = s[(i, l)] * delta(j, k);
            for r in 0..3 {
                for a in 0..3 {
                    sum += c[(i, r, a, l)] * f[(j, r)] * f[(k, a)];
                }
            }
            sum
        });
        assert_equal(name, contracted(&printed, &rate_of_f), nominal, scale);
    });
}

#[test]
fn equation_50_gives_the_rate_of_cauchy_stress() {
    for_motions(14, |name, response, l, along, scale| {
        let computed = contracted(&response.effective_cauchy_tangent(), l);
        assert_equal(name, computed, rate(|t| along(t).cauchy()), scale);
    });
}

#[test]
fn the_spatial_tangent_is_the_push_forward_of_the_tangent() {
    for_motions(15, |name, response, l, along, scale| {
        let f = response.deformation.matrix();
        let pushed =
            rate(|t| along(t).first_piola) * f.transpose() / response.deformation.jacobian();
        assert_equal(
            name,
            contracted(&response.spatial_tangent(), l),
            pushed,
            scale,
        );
        // The acoustic tensor of the spatial tangent is Q(N) of the reference configuration for n = F^-T N, per current volume.
        let reference = nalgebra::Vector3::new(0.3, -0.8, 0.52);
        let spatial = f.try_inverse().expect("invertible").transpose() * reference;
        let acoustic = |tensor: &FourthOrder, n: &nalgebra::Vector3<f64>| {
            Matrix3::from_fn(|i, k| {
                (0..9)
                    .map(|m| tensor[(i, m / 3, k, m % 3)] * n[m / 3] * n[m % 3])
                    .sum::<f64>()
            })
        };
        let expected = acoustic(&response.tangent, &reference) / response.deformation.jacobian();
        assert!(
            (acoustic(&response.spatial_tangent(), &spatial) - expected).amax() < 1e-11 * scale
        );
    });
}
