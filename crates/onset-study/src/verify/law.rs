//! Properties of a law that determine its deck: isotropy, rate form, and purely volumetric resistance.

use onset::kinematics::DeformationGradient;
use onset::material::{Hyperelastic, MaterialError};
use onset::plasticity::library;

/// Rounding error of a symmetry, relative to the stiffness.
const SYMMETRY_TOLERANCE: f64 = 1e-9;

/// Lamé constants of an isotropic material that is stress-free in the reference configuration; stress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Isotropic {
    pub(super) lambda: f64,
    pub(super) mu: f64,
}

impl Isotropic {
    /// Lamé constants of a law, or `None` if it is anisotropic or prestressed.
    pub(super) fn of(law: &dyn Hyperelastic) -> Result<Option<Self>, MaterialError> {
        let response = law.response(&DeformationGradient::identity())?;
        let tangent = &response.tangent;
        let own = Self {
            lambda: tangent[(0, 0, 1, 1)],
            mu: tangent[(0, 1, 0, 1)],
        };
        let scale = SYMMETRY_TOLERANCE * tangent.largest();
        let delta = |i: usize, j: usize| f64::from(u8::from(i == j));
        let is_isotropic = indices().all(|[i, j, k, l]| {
            let shear = delta(i, k) * delta(j, l) + delta(i, l) * delta(j, k);
            let expected = own.lambda * delta(i, j) * delta(k, l) + own.mu * shear;
            (tangent[(i, j, k, l)] - expected).abs() <= scale
        });
        let is_free = response.first_piola.amax() <= scale;
        Ok((is_isotropic && is_free).then_some(own))
    }

    /// Bulk modulus of the isotropic law; stress.
    pub(super) fn bulk(&self) -> f64 {
        self.lambda + self.mu / 1.5
    }

    /// Young's modulus; stress.
    pub(super) fn young(&self) -> f64 {
        self.mu * (3.0 * self.lambda + 2.0 * self.mu) / (self.lambda + self.mu)
    }

    /// Poisson's ratio of the isotropic law.
    pub(super) fn poisson(&self) -> f64 {
        0.5 * self.lambda / (self.lambda + self.mu)
    }
}

/// Returns true if stress and tangent at a state agree with the given law in rate form.
///
/// The law in rate form has the moduli of `law` in the reference configuration, and the parameter `n` of the pressure.
pub(super) fn is_in_rate_form(
    law: &dyn Hyperelastic,
    name: &str,
    n: f64,
    f: &DeformationGradient,
) -> Result<bool, MaterialError> {
    let Some(own) = Isotropic::of(law)? else {
        return Ok(false);
    };
    let Some(rates) = library().iter().find(|law| law.name == name) else {
        return Ok(false);
    };
    let given = [("mu", own.mu), ("kappa", own.bulk()), ("n", n)];
    // A fluid has no such law.
    let Ok(rates) = rates.build(&given) else {
        return Ok(false);
    };
    let (expected, response) = (rates.response(f)?, law.response(f)?);
    let scale = SYMMETRY_TOLERANCE * expected.tangent.largest();
    let stress = expected.first_piola - response.first_piola;
    let is_same = |[i, j, k, l]: [usize; 4]| {
        let at = (i, j, k, l);
        (expected.tangent[at] - response.tangent[at]).abs() <= scale
    };
    Ok(stress.amax() <= scale && indices().all(is_same))
}

/// Pressure of a law `W(J)` at a state, and its derivative with respect to the density ratio `rho/rho0 = 1/J`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Volumetric {
    /// The pressure `p = -W'(J)`; stress.
    pub(super) pressure: f64,
    /// The slope `dp/d(1/J) = J^2 W''(J)`; stress.
    pub(super) slope: f64,
}

impl Volumetric {
    /// Pressure and slope of a law, or `None` if it resists other deformations than volume changes at the state.
    ///
    /// `P_iJ = W' J F^-1_Ji` and `A_iJkL = (W'' J^2 + W' J) F^-1_Ji F^-1_Lk - W' J F^-1_Li F^-1_Jk`, for `F` along the axes.
    pub(super) fn of(
        law: &dyn Hyperelastic,
        f: &DeformationGradient,
    ) -> Result<Option<Self>, MaterialError> {
        let response = law.response(f)?;
        let inverse = f.components().iter().enumerate();
        let inverse: Vec<f64> = inverse.map(|(i, row)| row[i].recip()).collect();
        let at = |i: usize, j: usize| if i == j { inverse[i] } else { 0.0 };
        let jacobian = f.jacobian();
        let first = response.first_piola[(0, 0)] / (jacobian * inverse[0]);
        let second = response.tangent[(0, 0, 0, 0)] / (jacobian * inverse[0]).powi(2);
        let scale = SYMMETRY_TOLERANCE * response.tangent.largest();
        let is_volumetric = indices().all(|[i, j, k, l]| {
            let both = (second * jacobian + first) * jacobian * at(j, i) * at(l, k);
            let expected = both - first * jacobian * at(l, i) * at(j, k);
            (response.tangent[(i, j, k, l)] - expected).abs() <= scale
        });
        let is_pressure = (0..3).all(|i| {
            (0..3).all(|j| {
                let expected = first * jacobian * at(j, i);
                (response.first_piola[(i, j)] - expected).abs() <= scale
            })
        });
        Ok((is_volumetric && is_pressure).then_some(Self {
            pressure: -first,
            slope: jacobian * jacobian * second,
        }))
    }
}

/// Pressure, its slope, shear modulus and deviatoric stress of a law whose stress rate at a state is a Jaumann rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct JaumannRates {
    /// Pressure and its slope, as for a purely volumetric law.
    pub(super) volumetric: Volumetric,
    /// Shear modulus of the rate; stress.
    pub(super) shear: f64,
    /// Principal values of the deviator of the Cauchy stress; stress.
    pub(super) deviator: [f64; 3],
}

impl JaumannRates {
    /// Jaumann rates of a law at a state along the axes, from `sigma'_ij = g_ijkl L_kl`; `None` for any other stress rate.
    ///
    /// The Jaumann rate is `kappa tr D 1 + 2 mu dev D + W s - s W`. `factor` multiplies the spin and is 1 for the correct rate.
    pub(super) fn of(
        law: &dyn Hyperelastic,
        f: &DeformationGradient,
        factor: f64,
    ) -> Result<Option<Self>, MaterialError> {
        let response = law.response(f)?;
        let (sigma, g) = (response.cauchy(), response.effective_cauchy_tangent());
        let tension = sigma.trace() / 3.0;
        let deviator = [0, 1, 2].map(|i| sigma[(i, i)] - tension);
        let pairs = (0..9).map(|n| (n / 3, n % 3));
        let bulk = pairs.map(|(i, j)| g[(i, i, j, j)]).sum::<f64>() / 9.0;
        let shear = 0.5 * (g[(0, 1, 0, 1)] + g[(1, 0, 1, 0)]);
        let scale = SYMMETRY_TOLERANCE * g.largest().max(sigma.amax());
        let delta = |i: usize, j: usize| f64::from(u8::from(i == j));
        let is_jaumann = indices().all(|[i, j, k, l]| {
            let strain = delta(i, k) * delta(j, l) + delta(i, l) * delta(j, k);
            // Spin of the velocity gradient L = e_k (x) e_l, between axes of the stress.
            let spin = 0.5 * factor * (delta(i, k) * delta(j, l) - delta(i, l) * delta(j, k));
            let expected = shear * strain
                + (bulk - shear / 1.5) * delta(i, j) * delta(k, l)
                + spin * (deviator[j] - deviator[i]);
            (g[(i, j, k, l)] - expected).abs() <= scale
        });
        let is_along_axes = (0..3).all(|i| (0..i).all(|j| sigma[(i, j)].abs() <= scale));
        Ok((is_jaumann && is_along_axes).then_some(Self {
            volumetric: Volumetric {
                pressure: -tension,
                slope: bulk * f.jacobian(),
            },
            // A fluid has no shear modulus.
            shear: if shear.abs() <= scale { 0.0 } else { shear },
            deviator: deviator.map(|s| if s.abs() <= scale { 0.0 } else { s }),
        }))
    }
}

/// Returns whether a law in rate form also integrates its pressure, at a state along the axes; `None` for any other law.
///
/// The criterion is `sum_ij g_iijj` of the integrated part of the tangent.
pub(super) fn integrates_pressure(
    law: &dyn Hyperelastic,
    f: &DeformationGradient,
) -> Result<Option<bool>, MaterialError> {
    let Some(tangent) = law.integrated_tangent(f)? else {
        return Ok(None);
    };
    let stretch = |i: usize| f.components()[i][i];
    let pairs = (0..9).map(|n| (n / 3, n % 3));
    let bulk = pairs.map(|(i, j)| tangent[(i, i, j, j)] * stretch(i) * stretch(j));
    Ok(Some(
        bulk.sum::<f64>().abs() > SYMMETRY_TOLERANCE * tangent.largest(),
    ))
}

fn indices() -> impl Iterator<Item = [usize; 4]> {
    (0..81).map(|n| [n / 27, n / 9 % 3, n / 3 % 3, n % 3])
}

#[cfg(test)]
mod tests {
    use super::{Isotropic, JaumannRates, Volumetric, integrates_pressure, is_in_rate_form};
    use crate::settings::Settings;
    use onset::kinematics::DeformationGradient;

    const VOLUMETRIC_LAW: [&str; 3] = [
        "material.model=formula",
        "material.energy=K*(J-ln(J))",
        "material.K=2",
    ];

    fn law(assignments: &[&str]) -> std::sync::Arc<dyn onset::material::Hyperelastic> {
        let settings = Settings::from_assignments(assignments).expect("settings");
        settings.material.build().expect("a law")
    }

    #[test]
    fn a_purely_volumetric_law_is_recognized_with_its_pressure() {
        let law = law(&VOLUMETRIC_LAW);
        let f = DeformationGradient::from_stretches([1.2, 0.9, 1.1]).expect("a state");
        let own = Volumetric::of(&*law, &f)
            .expect("a response")
            .expect("volumetric");
        let jacobian = f.jacobian();
        // The pressure is p = K (1/J - 1), with the slope dp/d(1/J) = K.
        assert!((own.pressure - 2.0 * (1.0 / jacobian - 1.0)).abs() < 1e-12);
        assert!((own.slope - 2.0).abs() < 1e-12);
    }

    #[test]
    fn rubber_is_isotropic_and_not_purely_volumetric() {
        let law = law(&[
            "material.model=neo-hooke",
            "material.mu=0.4",
            "material.lambda=2",
        ]);
        let own = Isotropic::of(&*law)
            .expect("a response")
            .expect("isotropic");
        assert!((own.mu - 0.4).abs() < 1e-12 && (own.lambda - 2.0).abs() < 1e-12);
        assert!((own.young() / (2.0 * own.mu * (1.0 + own.poisson())) - 1.0).abs() < 1e-14);
        let f = DeformationGradient::from_stretches([1.2, 0.9, 1.1]).expect("a state");
        assert_eq!(Volumetric::of(&*law, &f).expect("a response"), None);
    }

    #[test]
    fn jaumann_rates_are_distinguished_from_others() {
        let given = ["material.mu=0.4", "material.kappa=2", "material.n=1"];
        let f = DeformationGradient::from_stretches([1.2, 0.9, 1.1]).expect("a state");
        let rate = |name: &str| law(&[&[name], &given[..]].concat());
        let [jaumann, other] = ["jaumann", "green-naghdi"]
            .map(|name| rate(&format!("material.model=hypoelastic-{name}")));
        let own = JaumannRates::of(&*jaumann, &f, 1.0).expect("a response");
        let own = own.expect("Jaumann's rate");
        let jacobian = f.jacobian();
        assert!((own.volumetric.pressure - 2.0 * (1.0 / jacobian - 1.0)).abs() < 1e-14);
        // The pressure is p = kappa (1/J - 1).
        assert!((own.volumetric.slope - 2.0).abs() < 1e-13);
        assert!((own.shear - 0.4).abs() < 1e-14);
        let expected = 0.8 * (1.2_f64.ln() - jacobian.ln() / 3.0);
        assert!((own.deviator[0] - expected).abs() < 1e-14);
        assert_eq!(
            JaumannRates::of(&*other, &f, 1.0).expect("a response"),
            None
        );
        assert_eq!(
            JaumannRates::of(&*jaumann, &f, -1.0).expect("a response"),
            None
        );
        let pressure = |law| integrates_pressure(law, &f).expect("a response");
        assert_eq!(pressure(&*jaumann), Some(false));
        let all = law(&["material.model=hypoelastic-jaumann", "material.mu=0.4"]);
        assert_eq!(pressure(&*all), Some(true));
        assert_eq!(pressure(&*law(&["material.model=neo-hooke"])), None);
        let is_one = |law, name: &str, n| is_in_rate_form(law, name, n, &f).expect("a response");
        assert!(is_one(&*other, "hypoelastic-green-naghdi", 1.0));
        assert!(!is_one(&*other, "hypoelastic-green-naghdi", 0.0));
        assert!(!is_one(&*jaumann, "hypoelastic-green-naghdi", 1.0));
    }

    #[test]
    fn a_purely_volumetric_law_has_jaumann_rates_without_shear() {
        let law = law(&VOLUMETRIC_LAW);
        let f = DeformationGradient::from_stretches([1.2, 0.9, 1.1]).expect("a state");
        let own = JaumannRates::of(&*law, &f, 1.0).expect("a response");
        let own = own.expect("Jaumann's rate");
        assert_eq!((own.shear, own.deviator), (0.0, [0.0; 3]));
        let volumetric = Volumetric::of(&*law, &f).expect("a response");
        let volumetric = volumetric.expect("volumetric");
        assert!((own.volumetric.pressure - volumetric.pressure).abs() < 1e-14);
        assert!((own.volumetric.slope - volumetric.slope).abs() < 1e-13);
    }
}
