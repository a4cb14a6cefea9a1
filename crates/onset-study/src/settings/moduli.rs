//! Moduli that can replace the parameters of any isotropic law: two of Young's modulus, Poisson's ratio, bulk and shear modulus.
//!
//! The stiffness of a law at small strains is linear in its parameters with the dimension of a stress. The parameters in the shear modulus are
//! multiplied by one factor, so that they keep their default ratios. The remaining parameters in the bulk modulus are multiplied by another factor.

use onset::material::{Admitted, Law, Symmetry};

/// The names, in the order of the documentation.
pub(super) const MODULI: [(&str, &str, Admitted, &str); 4] = [
    (
        "young",
        "stress",
        Admitted::Positive,
        "Young's modulus, at small strains, together with one of poisson, bulk or shear, instead of the law's parameters",
    ),
    (
        "poisson",
        "1",
        Admitted::Between(-1.0, 0.5),
        "Poisson's ratio, at small strains, together with one of young, bulk or shear",
    ),
    (
        "bulk",
        "stress",
        Admitted::Positive,
        "bulk modulus, at small strains, together with one of young, poisson or shear",
    ),
    (
        "shear",
        "stress",
        Admitted::Positive,
        "shear modulus, at small strains, together with one of young, poisson or bulk",
    ),
];

/// Returns true if a key of the material, without its section, is one of the moduli.
pub(super) fn is_modulus(name: &str) -> bool {
    MODULI.iter().any(|(modulus, ..)| *modulus == name)
}

/// Contributions to a modulus below this fraction are rounding errors.
const CONTRIBUTION_ROUNDING: f64 = 1e-12;
/// Relative tolerance for moduli that a law prescribes.
const MODULUS_TOLERANCE: f64 = 1e-9;

/// Shear and bulk modulus from two of the moduli, `mu = E / (2 (1 + nu))`, `K = E / (3 (1 - 2 nu))`.
///
/// # Errors
/// Description of the error.
fn shear_and_bulk(given: &[(&str, f64)]) -> Result<(f64, f64), String> {
    let of = |name: &str| {
        given
            .iter()
            .find(|(own, _)| *own == name)
            .map(|(_, value)| *value)
    };
    for (name, unit, admitted, _) in MODULI {
        if let Some(value) = of(name).filter(|value| !admitted.holds(*value, unit)) {
            return Err(format!(
                "material.{name} is {value:?}; expected {}",
                admitted.expected(unit)
            ));
        }
    }
    let bulk_of = |mu: f64, nu: f64| 2.0 * mu * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu));
    let (mu, kappa) = match (of("young"), of("poisson"), of("bulk"), of("shear")) {
        (Some(e), Some(nu), None, None) => (e / (2.0 * (1.0 + nu)), e / (3.0 * (1.0 - 2.0 * nu))),
        (Some(e), None, Some(k), None) => (3.0 * k * e / (9.0 * k - e), k),
        (Some(e), None, None, Some(mu)) => (mu, e * mu / (3.0 * (3.0 * mu - e))),
        (None, Some(nu), Some(k), None) => (3.0 * k * (1.0 - 2.0 * nu) / (2.0 * (1.0 + nu)), k),
        (None, Some(nu), None, Some(mu)) => (mu, bulk_of(mu, nu)),
        (None, None, Some(k), Some(mu)) => (mu, k),
        _ => {
            let names: Vec<String> = given
                .iter()
                .map(|(name, _)| format!("material.{name}"))
                .collect();
            return Err(format!(
                "{} given; two of material.young, material.poisson, material.bulk and material.shear determine an isotropic law",
                match names.len() {
                    1 => format!("{} alone is", names[0]),
                    _ => format!("{} are", names.join(", ")),
                }
            ));
        }
    };
    match mu > 0.0 && kappa > 0.0 && mu.is_finite() && kappa.is_finite() {
        true => Ok((mu, kappa)),
        false => Err(format!(
            "these moduli do not correspond to positive shear and bulk moduli: mu = {mu}, K = {kappa}"
        )),
    }
}

/// Parameters of a law that follow from moduli, by name; `set` are the parameters of the law that the user set as well.
///
/// Description of the error: moduli that do not determine the law, a law that is anisotropic or has no such moduli, or a parameter that both
/// determine.
pub(super) fn parameters(
    law: &Law,
    set: &[(&'static str, f64)],
    given: &[(&str, f64)],
) -> Result<Vec<(&'static str, f64)>, String> {
    let names: Vec<&str> = law
        .parameters
        .iter()
        .map(|parameter| parameter.name)
        .collect();
    if law.symmetry != Symmetry::Isotropic {
        return Err(format!(
            "{} is {}: {} do not determine it; its parameters are {}",
            law.name,
            law.symmetry.name(),
            "young, poisson, bulk and shear",
            names.join(", ")
        ));
    }
    let (mu, kappa) = shear_and_bulk(given)?;
    let moduli = |values: &[(&str, f64)]| {
        let stiffness = law
            .small_strain_stiffness(values)
            .map_err(|error| error.to_string())?;
        Ok::<_, String>((stiffness[3][3], stiffness[0][1] + stiffness[3][3] / 1.5))
    };
    let was_set = |name: &str| set.iter().any(|(own, _)| *own == name);
    let start: Vec<(&'static str, f64)> = law
        .parameters
        .iter()
        .map(|parameter| {
            let own = set.iter().find(|(name, _)| *name == parameter.name);
            (
                parameter.name,
                own.map_or(parameter.default, |(_, value)| *value),
            )
        })
        .collect();
    let (mu_now, kappa_now) = moduli(&start)?;
    // Contribution to the moduli of each parameter with the dimension of a stress.
    let mut shares = Vec::new();
    for (n, parameter) in law.parameters.iter().enumerate() {
        if parameter.unit != "stress" || start[n].1 == 0.0 {
            continue;
        }
        let mut doubled = start.clone();
        doubled[n].1 *= 2.0;
        let (mu_then, kappa_then) = moduli(&doubled)?;
        shares.push((n, mu_then - mu_now, kappa_then - kappa_now));
    }
    let is_of_shear = |share: f64| share.abs() > CONTRIBUTION_ROUNDING * mu_now.abs();
    let is_of_bulk = |share: f64| share.abs() > CONTRIBUTION_ROUNDING * kappa_now.abs();
    let factor = mu / mu_now;
    let (of_shear, rest): (Vec<_>, Vec<_>) = shares
        .into_iter()
        .partition(|(_, share, _)| is_of_shear(*share));
    let (of_bulk, others): (Vec<_>, Vec<_>) = rest
        .into_iter()
        .partition(|(_, _, share)| is_of_bulk(*share));
    if let Some((n, ..)) = of_shear
        .iter()
        .chain(&of_bulk)
        .find(|(n, ..)| was_set(start[*n].0))
    {
        return Err(format!(
            "material.{} is set, but also follows from the moduli ({})",
            start[*n].0,
            given
                .iter()
                .map(|(name, _)| *name)
                .collect::<Vec<_>>()
                .join(", ")
        ));
    }
    let mut found = Vec::new();
    let mut add = |n: usize, factor: f64| found.push((start[n].0, start[n].1 * factor));
    of_shear.iter().for_each(|(n, ..)| add(*n, factor));
    // Constants of higher powers are scaled with the shear modulus, unless they are set.
    let follows = |n: &usize| !was_set(start[*n].0);
    others
        .iter()
        .map(|(n, ..)| *n)
        .filter(follows)
        .for_each(|n| add(n, factor));
    let by_shear = factor * of_shear.iter().map(|(.., share)| share).sum::<f64>();
    let by_bulk: f64 = of_bulk.iter().map(|(.., share)| share).sum();
    if of_bulk.is_empty() {
        found.extend(of_ratio(law, mu, kappa));
    } else {
        of_bulk
            .iter()
            .for_each(|(n, ..)| add(*n, (kappa - by_shear) / by_bulk));
    }
    let mut all = start;
    for (name, value) in &mut all {
        if let Some((_, own)) = found.iter().find(|(own, _)| own == name) {
            *value = *own;
        }
    }
    let (mu_then, kappa_then) = moduli(&all)?;
    let agrees = |a: f64, b: f64| (a - b).abs() <= MODULUS_TOLERANCE * b.abs();
    match agrees(mu_then, mu) && agrees(kappa_then, kappa) {
        true => Ok(found),
        false => Err(format!(
            "{} cannot have these moduli (shear modulus {mu}, bulk modulus {kappa}); at small strains it has: {}",
            law.name, law.small_strains
        )),
    }
}

/// Dimensionless parameters that are determined by Poisson's ratio, if no parameter determines the bulk modulus separately.
fn of_ratio(law: &Law, mu: f64, kappa: f64) -> Vec<(&'static str, f64)> {
    let ratio = (3.0 * kappa - 2.0 * mu) / (2.0 * (3.0 * kappa + mu));
    let of = |name: &'static str, value: f64| law.parameter(name).map(|_| (name, value));
    match law.name {
        "generalized-blatz-ko" => of("nu", ratio).into_iter().collect(),
        "hyperfoam" => ["beta1", "beta2", "beta3"]
            .into_iter()
            .filter_map(|name| of(name, ratio / (1.0 - 2.0 * ratio)))
            .collect(),
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::parameters;
    use onset::material::{Law, Symmetry, library};

    const STEEL: [(&str, f64); 2] = [("young", 210.0), ("poisson", 0.3)];

    #[test]
    fn every_isotropic_law_attains_the_requested_moduli() {
        let mut count = 0;
        for law in library()
            .iter()
            .chain(onset::plasticity::library())
            .filter(|law| law.symmetry == Symmetry::Isotropic)
        {
            // The foam of Blatz and Ko always has Poisson's ratio 1/4.
            if law.name == "blatz-ko" {
                assert!(parameters(law, &[], &STEEL).is_err());
                continue;
            }
            let found =
                parameters(law, &[], &STEEL).unwrap_or_else(|told| panic!("{}: {told}", law.name));
            let stiffness = law.small_strain_stiffness(&found).expect("admissible");
            let (mu, lambda) = (stiffness[3][3], stiffness[0][1]);
            let young = mu * (3.0 * lambda + 2.0 * mu) / (lambda + mu);
            assert!((young / 210.0 - 1.0).abs() < 1e-9, "{}: {young}", law.name);
            assert!(
                (lambda / (2.0 * (lambda + mu)) / 0.3 - 1.0).abs() < 1e-9,
                "{}",
                law.name
            );
            assert!(law.build(&found).is_ok(), "{}", law.name);
            count += 1;
        }
        assert!(count > 10, "{count}");
    }

    #[test]
    fn all_pairs_of_moduli_give_the_same_parameters() {
        let law = Law::named("neo-hooke").expect("a law");
        let (mu, kappa) = (210.0 / 2.6, 175.0);
        let pairs = [
            STEEL,
            [("young", 210.0), ("bulk", kappa)],
            [("young", 210.0), ("shear", mu)],
            [("poisson", 0.3), ("bulk", kappa)],
            [("poisson", 0.3), ("shear", mu)],
            [("bulk", kappa), ("shear", mu)],
        ];
        for pair in pairs {
            let found = parameters(law, &[], &pair).expect("moduli");
            for (name, value) in [("mu", mu), ("lambda", kappa - mu / 1.5)] {
                let own = found
                    .iter()
                    .find(|(own, _)| *own == name)
                    .expect("a parameter")
                    .1;
                assert!(
                    (own / value - 1.0).abs() < 1e-12,
                    "{pair:?}: {name} = {own}"
                );
            }
        }
    }

    #[test]
    fn too_many_too_few_and_impossible_moduli_are_refused() {
        for (law, set, given, fact) in [
            (
                "neo-hooke",
                vec![],
                vec![("young", 1.0)],
                "material.young alone is given",
            ),
            (
                "neo-hooke",
                vec![],
                vec![("young", 1.0), ("poisson", 0.3), ("bulk", 1.0)],
                "two of material.young",
            ),
            (
                "neo-hooke",
                vec![("mu", 1.0)],
                STEEL.to_vec(),
                "material.mu is set, but also follows",
            ),
            (
                "neo-hooke",
                vec![],
                vec![("young", 1.0), ("poisson", 0.5)],
                "above -1 and below 0.5",
            ),
            (
                "neo-hooke",
                vec![],
                vec![("young", -1.0), ("poisson", 0.2)],
                "a positive number",
            ),
            (
                "neo-hooke",
                vec![],
                vec![("young", 9.0), ("bulk", 1.0)],
                "positive shear and bulk moduli",
            ),
            ("blatz-ko", vec![], STEEL.to_vec(), "Poisson's ratio 1/4"),
            ("cubic", vec![], STEEL.to_vec(), "is cubic"),
        ] {
            let law = library()
                .iter()
                .find(|own| own.name.starts_with(law))
                .or_else(|| library().iter().find(|own| own.name.contains(law)))
                .unwrap_or_else(|| panic!("no law {law}"));
            let told = parameters(law, &set, &given).expect_err("refused");
            assert!(told.contains(fact), "{told}");
        }
        let soft = Law::named("blatz-ko").expect("a law");
        let found = parameters(soft, &[], &[("shear", 7.0), ("poisson", 0.25)]).expect("its ratio");
        assert_eq!(found, [("mu", 7.0)]);
    }
}
