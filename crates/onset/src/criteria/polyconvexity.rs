//! Known results on polyconvexity, which concern laws and not states.

/// Status of the polyconvexity of a law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize),
    serde(rename_all = "kebab-case")
)]
pub enum Knowledge {
    /// The law is polyconvex with these parameters.
    Polyconvex,
    /// The law is not polyconvex with these parameters.
    NotPolyconvex,
    /// No result is recorded.
    Unknown,
}

/// Known result on the polyconvexity of a law with given parameters: `W(F)` is a convex function of `F`, `cof F` and `det F`.
///
/// With a growth condition polyconvexity implies the existence of equilibrium states (Ball, Arch. Ration. Mech. Anal. 63 (1977) 337). It implies
/// rank-one convexity and thus (not strict) ellipticity at all states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Polyconvexity {
    /// Whether the law is polyconvex, if known.
    pub knowledge: Knowledge,
    /// Reason, with the condition on the parameters.
    pub reason: &'static str,
    /// Reference of the proof.
    pub source: &'static str,
}

const BALL: &str = "Ball, Arch. Ration. Mech. Anal. 63 (1977) 337";
const CHARRIER: &str = "Charrier, Dacorogna, Hanouzet and Laborde, SIAM J. Math. Anal. 19 (1988) 70; Hartmann and Neff, Int. J. Solids Struct. 40 (2003) 2767";
const SCHROEDER_NEFF: &str = "Schröder and Neff, Int. J. Solids Struct. 40 (2003) 401; Balzani, Neff, Schröder and Holzapfel, Int. J. Solids Struct. 43 (2006) 6052";
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

/// Returns the recorded result on the polyconvexity of a law, given the names of the law and its parameters; unknown without a record.
///
/// ```
/// use onset::criteria::{Knowledge, polyconvexity};
/// assert_eq!(polyconvexity("blatz-ko", &[("mu", 32.0)]).knowledge, Knowledge::NotPolyconvex);
/// assert_eq!(polyconvexity("my-own", &[]).knowledge, Knowledge::Unknown);
/// ```
pub fn polyconvexity(law: &str, parameters: &[(&str, f64)]) -> Polyconvexity {
    let value = |name: &str| {
        let found = parameters.iter().find(|(known, _)| *known == name);
        found.map_or(f64::NAN, |(_, value)| *value)
    };
    let all_not_negative = |names: &[&str]| names.iter().all(|name| value(name) >= 0.0);
    match law {
        "blatz-ko" => no(
            "it loses ellipticity where a ratio of principal stretches reaches 2 + sqrt 3",
            KNOWLES_STERNBERG,
        ),
        "generalized-blatz-ko" if value("f") == 1.0 => {
            yes("I1 and a convex function of J, since f = 1", BALL)
        }
        "hencky" => no("it is not elliptic at all states", BRUHNS),
        "exponentiated-hencky" => no(
            "in three dimensions it is not rank-one convex at all states",
            NEFF,
        ),
        "saint-venant-kirchhoff" => no("its energy is not polyconvex for any constants", RAOULT),
        // W depends on |F|^2, |cof F|^2 and h(J). Under F = diag(a, J/(a s), s) with large a and s, wave speeds vanish where h'' < 0.
        "modified-mooney-rivlin" if value("c2") > 0.0 => no(
            "with c2 > 0 its function of J is concave at large J, where ellipticity is lost at large stretches, which polyconvexity excludes",
            BALL,
        ),
        "modified-mooney-rivlin" if value("lambda") > 0.0 => {
            // J^2 h''(J) = c1 J^(2/3) / 3 + 2 lambda (1 - ln J) is smallest at J^(2/3) = 9 lambda / c1.
            if 9.0 * value("lambda") <= value("c1") * (5.0_f64 / 3.0).exp() {
                yes(
                    "I1 and a convex function of J, since c2 = 0 and lambda/c1 <= exp(5/3)/9",
                    BALL,
                )
            } else {
                no(
                    "with c2 = 0 and lambda/c1 > exp(5/3)/9 its function of J is not convex, and ellipticity is lost at large stretches, \
                     which polyconvexity excludes",
                    BALL,
                )
            }
        }
        "neo-hooke" if value("lambda") > 0.0 => no(
            "with lambda > 0 ellipticity is lost at J = exp(1 + 2 mu/lambda) in uniaxial strain, which polyconvexity excludes",
            BALL,
        ),
        "neo-hooke" if value("lambda") == 0.0 => yes("I1 and -ln J", BALL),
        "neo-hooke-quadratic" | "neo-hooke-polyconvex" if value("lambda") >= 0.0 => {
            yes("I1 and a convex function of J, since lambda >= 0", BALL)
        }
        "mooney-rivlin" if all_not_negative(&["c10", "c01"]) && value("lambda") == 0.0 => yes(
            "I1, I2 and -ln J with constants that are not negative",
            BALL,
        ),
        "mooney-rivlin-isochoric" if value("c10") >= 0.0 && value("c01") == 0.0 => yes(
            "J^(-2/3) I1 and a convex function of J, since c01 = 0",
            CHARRIER,
        ),
        "neo-hooke-isochoric" | "gent" | "arruda-boyce" | "fung-isotropic" => yes(
            "a convex, increasing function of J^(-2/3) I1, and a convex function of J",
            CHARRIER,
        ),
        "murnaghan" | "tait" => yes(
            "J^(-2/3) I1 and a convex function of J, since the pressure falls with the volume",
            CHARRIER,
        ),
        "mie-grueneisen" if value("mu") == 0.0 => no(
            "without a deviator it is a function of J alone, and its pressure is not monotonic in tension",
            BALL,
        ),
        "yeoh" if all_not_negative(&["c10", "c20", "c30"]) => yes(
            "a convex, increasing function of J^(-2/3) I1, because no constant is negative, and a convex function of J",
            CHARRIER,
        ),
        "holzapfel-gasser-ogden-switch" => yes(
            "convex, increasing functions of J^(-2/3) I1 and of the stretch of fibers in tension, and a convex function of J",
            SCHROEDER_NEFF,
        ),
        _ => UNKNOWN,
    }
}
