//! What is known about polyconvexity: facts about laws, not about states.

/// What is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize),
    serde(rename_all = "kebab-case")
)]
pub enum Knowledge {
    /// The law is polyconvex with these parameters.
    Polyconvex,
    /// It is not.
    NotPolyconvex,
    /// Nothing is known here.
    Unknown,
}

/// What is known about the polyconvexity of a law with some parameters: that `W(F)` is a convex function of `F`, `cof F` and `det F`.
///
/// With growth it gives existence of equilibrium states (Ball, Arch. Ration. Mech. Anal. 63 (1977) 337), and it implies rank-one convexity and so
/// ellipticity (not strict) at all states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Polyconvexity {
    /// What is known.
    pub knowledge: Knowledge,
    /// Why, with the condition on the parameters.
    pub reason: &'static str,
    /// Where it is proved.
    pub source: &'static str,
}

const BALL: &str = "Ball, Arch. Ration. Mech. Anal. 63 (1977) 337";
const HARTMANN_NEFF: &str = "Hartmann and Neff, Int. J. Solids Struct. 40 (2003) 2767";
const SCHROEDER_NEFF: &str = "Schröder and Neff, Int. J. Solids Struct. 40 (2003) 401";
const KNOWLES_STERNBERG: &str = "Knowles and Sternberg, J. Elasticity 5 (1975) 341";
const BRUHNS: &str = "Bruhns, Xiao and Meyers, Proc. R. Soc. Lond. A 457 (2001) 2207";
const RAOULT: &str = "Raoult, Aplikace Matematiky 31 (1986) 417";
const NEFF: &str = "Neff, Ghiba and Lankeit, J. Elasticity 121 (2015) 143";

fn no(reason: &'static str, source: &'static str) -> Polyconvexity {
    Polyconvexity {
        knowledge: Knowledge::NotPolyconvex,
        reason,
        source,
    }
}

fn yes(reason: &'static str, source: &'static str) -> Polyconvexity {
    Polyconvexity {
        knowledge: Knowledge::Polyconvex,
        reason,
        source,
    }
}

const UNKNOWN: Polyconvexity = Polyconvexity {
    knowledge: Knowledge::Unknown,
    reason: "no statement about this law with these parameters is recorded",
    source: "",
};

/// What is known about a law by its name, with its parameters by name; unknown where nothing is recorded.
///
/// ```
/// use onset::notions::{Knowledge, polyconvexity};
/// assert_eq!(polyconvexity("blatz-ko", &[("mu", 32.0)]).knowledge, Knowledge::NotPolyconvex);
/// assert_eq!(polyconvexity("my-own", &[]).knowledge, Knowledge::Unknown);
/// ```
pub fn polyconvexity(law: &str, parameters: &[(&str, f64)]) -> Polyconvexity {
    let value = |name: &str| {
        let found = parameters.iter().find(|(known, _)| *known == name);
        found.map_or(f64::NAN, |(_, value)| *value)
    };
    match law {
        "blatz-ko" => no(
            "it loses ellipticity where a ratio of principal stretches reaches 2 + sqrt 3",
            KNOWLES_STERNBERG,
        ),
        "hencky" => no("it is not elliptic at all states", BRUHNS),
        "exponentiated-hencky" => no(
            "in three dimensions it is not rank-one convex at all states",
            NEFF,
        ),
        "saint-venant-kirchhoff" | "st-venant-kirchhoff" => {
            no("it softens in compression and loses ellipticity", RAOULT)
        }
        "modified-mooney-rivlin" if value("lambda") > 0.0 => no(
            "with lambda > 0 its part lambda (ln J)^2 is concave for large J, and ellipticity is lost there",
            BALL,
        ),
        _ => UNKNOWN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_statement_has_a_source() {
        for law in ["blatz-ko", "hencky", "modified-mooney-rivlin"] {
            let known = polyconvexity(law, &[("lambda", 1.0)]);
            assert!(known.knowledge != Knowledge::Unknown && !known.source.is_empty());
        }
        assert!(yes("", HARTMANN_NEFF).source != SCHROEDER_NEFF);
    }
}
