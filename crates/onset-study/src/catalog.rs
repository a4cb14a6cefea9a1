//! What there is to choose from: every word of every choice, with its formula, its parameters and its source.

use crate::settings::{KEYS, Model};
use serde::Serialize;

/// A word that can be chosen.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Entry {
    /// The word.
    pub name: &'static str,
    /// What it stands for, as a formula or in words.
    pub formula: &'static str,
    /// Parameters with their defaults.
    pub parameters: Vec<(&'static str, f64)>,
    /// Where it is from.
    pub source: &'static str,
}

/// The words of one key.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Topic {
    /// The topic, in the plural.
    pub name: &'static str,
    /// The key that takes these words.
    pub key: &'static str,
    /// The words.
    pub entries: Vec<Entry>,
}

/// The paper that sources speak of.
pub const PAPER: &str = "Xiao and Belytschko, Adv. Comput. Math. 23 (2005) 171";

/// Topic, key, and the words with formula and source.
type Row = (
    &'static str,
    &'static str,
    &'static [(&'static str, &'static str, &'static str)],
);

const ROWS: &[Row] = &[
    (
        "materials",
        "material.model",
        &[
            (
                "modified-mooney-rivlin",
                "W = c1/2 I1 + c2/2 I2 - 3/2 c1 I3^(1/3) - 3/2 c2 I3^(2/3) + lambda/4 (ln I3)^2",
                "equation (5) of the paper; constants in MPa",
            ),
            (
                "blatz-ko",
                "W = mu/2 (I2 / J^2 + 2 J - 5)",
                "Blatz and Ko, Trans. Soc. Rheol. 6 (1962) 223; psi",
            ),
        ],
    ),
    (
        "arrangements",
        "discretization.arrangement",
        &[
            ("square", "a1 = h (1, 0), a2 = h (0, 1)", "the paper"),
            (
                "hexagonal",
                "a1 = h (1, 0), a2 = h (1/2, sqrt(3)/2)",
                "the paper",
            ),
            (
                "chain",
                "a1 = h, one dimension",
                "Belytschko and Xiao, Comput. Math. Appl. 43 (2002) 329",
            ),
        ],
    ),
    (
        "kernels",
        "discretization.kernel",
        &[(
            "quartic-spline",
            "W = 1 - 6 q^2 + 8 q^3 - 3 q^4, q = r / R0 < 1",
            "equation (35) of the paper",
        )],
    ),
    (
        "approximations",
        "discretization.approximation",
        &[
            (
                "raw",
                "phi_K = V W_K / integral of W",
                "smoothed particle hydrodynamics",
            ),
            (
                "shepard",
                "phi_K = W_K / sum_L W_L",
                "equation (34) of the paper",
            ),
            (
                "mls",
                "phi_K = alpha . p_K W_K, (sum_L W_L p_L (x) p_L) alpha = e0, p = (1, x_K - x)",
                "moving least squares, linear basis",
            ),
        ],
    ),
    (
        "quadratures",
        "discretization.quadrature",
        &[
            (
                "nodal",
                "points: particles; volumes: Voronoi",
                "equation (41) of the paper",
            ),
            (
                "stress-points",
                "points: particles and centers of the Delaunay cells; volumes: Voronoi",
                "equations (42), (43) of the paper; Dyka et al.",
            ),
            (
                "stress-points-only",
                "points: centers of the Delaunay cells; volumes: Voronoi",
                "Randles et al.",
            ),
        ],
    ),
    (
        "frames",
        "discretization.frame",
        &[
            (
                "lagrangian",
                "W(X - X_K): kernels of material coordinates",
                PAPER,
            ),
            (
                "eulerian",
                "W(x - x_K(t)): kernels of current coordinates",
                PAPER,
            ),
        ],
    ),
    (
        "backgrounds",
        "discretization.background",
        &[
            ("imposed", "F_q = F at every quadrature point", "the paper"),
            (
                "interpolated",
                "F_q = 1 + (F - 1) M_q (Lagrangian), F_q^-1 = 1 - (1 - F^-1) m_q (Eulerian)",
                "equation (33) of the paper",
            ),
        ],
    ),
    (
        "lattices",
        "discretization.lattice",
        &[
            ("convected", "particles at F X", "a simulation"),
            (
                "regular",
                "particles at X, carrying the stress of F",
                "section 6.2 of the paper, a reading",
            ),
        ],
    ),
    (
        "support-sizes",
        "discretization.support-size",
        &[
            (
                "fixed",
                "|x| < R0",
                "a simulation with constant smoothing length",
            ),
            (
                "scaled",
                "|x| < R0 J^(1/D)",
                "a simulation with adapted smoothing length",
            ),
            (
                "convected",
                "|F^-1 x| < R0",
                "the support of the reference, carried along",
            ),
        ],
    ),
    (
        "linearizations",
        "discretization.linearization",
        &[
            (
                "exact",
                "everything moves: the derivative of the discrete forces",
                "derived in the book",
            ),
            (
                "paper",
                "d(phi_I,j) = phi_I,jt (u_q - u_I), stress points move with the plane wave",
                "equation (49) of the paper",
            ),
            (
                "exact-plane-wave",
                "as exact, stress points move with the plane wave",
                "for comparison",
            ),
            (
                "paper-interpolated",
                "as paper, stress points move with sum_K phi_K u_K",
                "for comparison",
            ),
            (
                "frozen-normalization",
                "as paper, with W_,jt / S in place of phi_I,jt",
                "for comparison",
            ),
        ],
    ),
];

/// All topics.
pub fn topics() -> Vec<Topic> {
    let entry = |(name, formula, source): &(&'static str, &'static str, &'static str)| Entry {
        name,
        formula,
        parameters: Model::ALL
            .iter()
            .filter(|model| model.name() == *name)
            .flat_map(|model| model.parameters().to_vec())
            .collect(),
        source,
    };
    let topic = |(name, key, rows): &Row| Topic {
        name,
        key,
        entries: rows.iter().map(entry).collect(),
    };
    ROWS.iter().map(topic).collect()
}

/// The topics with a name; the known names when there is none.
///
/// # Errors
/// The names of all topics, when none is called so.
pub fn topic(name: &str) -> Result<Topic, Vec<&'static str>> {
    let all = topics();
    let names = all.iter().map(|topic| topic.name).collect();
    all.into_iter()
        .find(|topic| topic.name == name)
        .ok_or(names)
}

impl std::fmt::Display for Topic {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let meaning = KEYS
            .iter()
            .find(|key| key.name == self.key)
            .map_or("", |key| key.meaning);
        writeln!(formatter, "{} ({}: {meaning})", self.name, self.key)?;
        for entry in &self.entries {
            writeln!(formatter, "  {:<24} {}", entry.name, entry.formula)?;
            let parameters: Vec<String> = entry
                .parameters
                .iter()
                .map(|(name, value)| format!("{name} = {value}"))
                .collect();
            if !parameters.is_empty() {
                writeln!(
                    formatter,
                    "  {:<24} parameters: {}",
                    "",
                    parameters.join(", ")
                )?;
            }
            writeln!(formatter, "  {:<24} source: {}", "", entry.source)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::topics;
    use crate::settings::KEYS;

    #[test]
    fn the_catalog_has_exactly_the_words_that_the_keys_expect() {
        for topic in topics() {
            let key = KEYS
                .iter()
                .find(|key| key.name == topic.key)
                .expect("a known key");
            let mut expected: Vec<&str> = key.words().to_vec();
            let mut listed: Vec<&str> = topic.entries.iter().map(|entry| entry.name).collect();
            expected.sort_unstable();
            listed.sort_unstable();
            assert_eq!(listed, expected, "{}", topic.name);
        }
        let with_words = KEYS.iter().filter(|key| !key.words().is_empty()).count();
        assert_eq!(
            topics().len(),
            with_words,
            "every key that takes words is a topic"
        );
    }

    #[test]
    fn every_material_lists_its_parameters() {
        let materials = super::topic("materials").expect("a topic");
        assert!(
            materials
                .entries
                .iter()
                .all(|entry| !entry.parameters.is_empty())
        );
    }
}
