//! What there is to choose from: every word of every choice, with its formula, its parameters and its source.

use crate::settings::{KEYS, Model};
use onset::formula::{FUNCTIONS, VARIABLES};
use onset::kernel::Kernel;
use onset::material::{Law, Parameter};
use serde::Serialize;

/// A word that can be chosen.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Entry {
    /// The word.
    pub name: &'static str,
    /// What it stands for, as a formula or in words.
    pub formula: &'static str,
    /// Where it is from.
    pub source: &'static str,
    /// What there is to know about a law, where it is one.
    #[serde(flatten)]
    pub law: Option<LawEntry>,
    /// What there is to know about a kernel, where it is one.
    #[serde(flatten)]
    pub kernel: Option<KernelEntry>,
}

/// What there is to know about a kernel; numbers in one, two and three dimensions.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct KernelEntry {
    /// The integral of `W` over space for a support radius of one.
    pub integral: [f64; 3],
    /// The support radius over the smoothing length `h = 2 sigma`.
    pub support_over_smoothing_length: [f64; 3],
    /// How many derivatives over space are continuous everywhere.
    pub smoothness: [Option<u32>; 3],
}

impl From<Kernel> for KernelEntry {
    fn from(kernel: Kernel) -> Self {
        Self {
            integral: [
                kernel.integral::<1>(1.0),
                kernel.integral::<2>(1.0),
                kernel.integral::<3>(1.0),
            ],
            support_over_smoothing_length: [
                kernel.support_over_smoothing_length::<1>(),
                kernel.support_over_smoothing_length::<2>(),
                kernel.support_over_smoothing_length::<3>(),
            ],
            smoothness: [
                kernel.smoothness::<1>().least(),
                kernel.smoothness::<2>().least(),
                kernel.smoothness::<3>().least(),
            ],
        }
    }
}

impl From<Kernel> for Entry {
    fn from(kernel: Kernel) -> Self {
        Self {
            name: kernel.name(),
            formula: kernel.formula(),
            source: kernel.source(),
            law: None,
            kernel: Some(kernel.into()),
        }
    }
}

/// What there is to know about a law.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LawEntry {
    /// Its parameters.
    pub parameters: Vec<ParameterEntry>,
    /// Where it holds.
    pub domain: &'static str,
    /// Which rotations of the reference change nothing.
    pub symmetry: &'static str,
    /// The moduli at small strains, in words.
    pub small_strains: &'static str,
    /// Why there is stress in the reference, where there is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stressed_reference: Option<&'static str>,
}

/// A parameter of a law.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParameterEntry {
    /// Its name.
    pub name: &'static str,
    /// Its unit; `1` without dimension.
    pub unit: &'static str,
    /// Its default.
    pub default: f64,
    /// What it may be.
    pub expected: String,
    /// What it means.
    pub meaning: &'static str,
}

impl From<&Parameter> for ParameterEntry {
    fn from(parameter: &Parameter) -> Self {
        Self {
            name: parameter.name,
            unit: parameter.unit,
            default: parameter.default,
            expected: parameter.admitted.to_string(),
            meaning: parameter.meaning,
        }
    }
}

impl From<&Law> for LawEntry {
    fn from(law: &Law) -> Self {
        Self {
            parameters: law.parameters.iter().map(ParameterEntry::from).collect(),
            domain: law.domain,
            symmetry: law.symmetry.name(),
            small_strains: law.small_strains,
            stressed_reference: law.stressed_reference,
        }
    }
}

impl From<Model> for Entry {
    fn from(model: Model) -> Self {
        match model {
            Model::Law(law) => Self {
                name: law.name,
                formula: law.formula,
                source: law.source,
                law: Some(law.into()),
                kernel: None,
            },
            Model::Own(own) => Self {
                name: own.name,
                formula: own.formula,
                source: own.source,
                law: None,
                kernel: None,
            },
        }
    }
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
        "methods",
        "discretization.method",
        &[
            (
                "kernel",
                "f_I = -sum_q V_q P(F_q) grad phi_I(X_q), or of current coordinates; see approximations, quadratures, frames",
                "the paper, equations (41) to (49)",
            ),
            (
                "total-lagrangian-sph",
                "f_I = sum_J V_I V_J (P_I K_I^-T + P_J K_J^-T) grad W_IJ, F_I = 1 + sum_J V_J (u_J - u_I) (x) grad W_IJ K_I^-1",
                "Vignjevic, Reveles, Campbell 2006",
            ),
            (
                "updated-sph",
                "f_I = m_I sum_J m_J (sigma_I/rho_I^2 + sigma_J/rho_J^2) grad W_IJ, or another momentum form",
                "Gray, Monaghan, Swift 2001",
            ),
            (
                "finite-elements",
                "f_a = -int P(F) grad N_a dV; full or one-point integration, with hourglass control",
                "Flanagan, Belytschko 1981",
            ),
            (
                "conforming",
                "nodal integration with gradients averaged over Voronoi cells or boxes (SCNI, SNNI, M-SCNI)",
                "Chen, Wu, Yoon, You 2001",
            ),
            (
                "peridynamics",
                "bonds with the force c s, or families with the deformation gradient sum w y (x) X V K^-1",
                "Silling 2000; Silling and others 2007",
            ),
            (
                "material-points",
                "f_i = -sum_p v_p sigma_p grad N_i(x_p) on a square or cubic grid, whatever the arrangement",
                "Sulsky, Chen, Schreyer 1994",
            ),
        ],
    ),
    (
        "arrangements",
        "discretization.arrangement",
        &[
            (
                "chain",
                "1D: a1 = h; 2 neighbors, cell h",
                "Belytschko and Xiao, Comput. Math. Appl. 43 (2002) 329",
            ),
            (
                "square",
                "2D: a1 = h (1, 0), a2 = h (0, 1); 4 neighbors, cell h^2",
                "the paper",
            ),
            (
                "rectangular",
                "2D: a1 = h (1, 0), a2 = h (0, discretization.aspect); 2 neighbors, cell aspect h^2",
                "a Bravais lattice",
            ),
            (
                "hexagonal",
                "2D: a1 = h (1, 0), a2 = h (1/2, sqrt(3)/2); 6 neighbors, cell sqrt(3)/2 h^2",
                "the paper",
            ),
            (
                "honeycomb",
                "2D: a1 = h (sqrt(3), 0), a2 = h/2 (sqrt(3), 3), second particle at (a1 + a2)/3; 3 neighbors, \
                 cell sqrt(27)/2 h^2",
                "hexagons; two particles in a cell",
            ),
            (
                "oblique",
                "2D: a1, a2 = h times the four numbers of discretization.vectors",
                "a Bravais lattice",
            ),
            (
                "simple-cubic",
                "3D: a1 = h (1, 0, 0), a2 = h (0, 1, 0), a3 = h (0, 0, 1); 6 neighbors, cell h^3",
                "a Bravais lattice",
            ),
            (
                "body-centered-cubic",
                "3D: a1 = h/sqrt(3) (-1, 1, 1), a2 = h/sqrt(3) (1, -1, 1), a3 = h/sqrt(3) (1, 1, -1); 8 neighbors, \
                 cell 4/sqrt(27) h^3",
                "a Bravais lattice",
            ),
            (
                "face-centered-cubic",
                "3D: a1 = h/sqrt(2) (0, 1, 1), a2 = h/sqrt(2) (1, 0, 1), a3 = h/sqrt(2) (1, 1, 0); 12 neighbors, \
                 cell h^3/sqrt(2)",
                "a Bravais lattice, the closest packing",
            ),
            (
                "hexagonal-close-packed",
                "3D: a1 = h (1, 0, 0), a2 = h (1/2, sqrt(3)/2, 0), a3 = h (0, 0, sqrt(8/3)), second particle at \
                 (a1 + a2)/3 + a3/2; 12 neighbors, cell sqrt(2) h^3",
                "a closest packing; two particles in a cell",
            ),
            (
                "diamond",
                "3D: a1 = 2h/sqrt(3) (0, 1, 1), a2 = 2h/sqrt(3) (1, 0, 1), a3 = 2h/sqrt(3) (1, 1, 0), second particle at \
                 (a1 + a2 + a3)/4; 4 neighbors, cell 16/sqrt(27) h^3",
                "carbon's; two particles in a cell",
            ),
            (
                "triclinic",
                "3D: a1, a2, a3 = h times the nine numbers of discretization.vectors",
                "a Bravais lattice",
            ),
        ],
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
            (
                "mls-2",
                "as mls, p = all monomials of x_K - x up to degree 2",
                "moving least squares; Liu, Jun and Zhang, Int. J. Numer. Meth. Fluids 20 (1995) 1081",
            ),
            (
                "mls-3",
                "as mls, p = all monomials of x_K - x up to degree 3",
                "moving least squares; Liu, Jun and Zhang, Int. J. Numer. Meth. Fluids 20 (1995) 1081",
            ),
            (
                "randles-libersky",
                "grad f = C^T sum_K (f_K - f_I) grad W_K, C = (sum_K (x_K - x_I) (x) grad W_K)^-1; values: shepard",
                "Randles and Libersky, Comput. Methods Appl. Mech. Engrg. 139 (1996) 375",
            ),
            (
                "krongauz-belytschko",
                "grad f = C^T sum_K f_K grad phi_K, C = (sum_K x_K (x) grad phi_K)^-1; values phi: shepard",
                "Krongauz and Belytschko, Comput. Methods Appl. Mech. Engrg. 146 (1997) 371",
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
            (
                "nodal-stabilized",
                "nodal, V w(F) + 1/2 M_jl F_,j : A : F_,l with the second moments M of the Voronoi cell; lagrangian only",
                "Hillman and Chen, Int. J. Numer. Meth. Engng 107 (2016) 603",
            ),
            (
                "gauss",
                "points: Gauss-Legendre in the parallelepiped of the primitive vectors, gauss-points per direction",
                "background cells; Belytschko, Lu and Gu, Int. J. Numer. Meth. Engng 37 (1994) 229",
            ),
            (
                "points",
                "points and weights: discretization.points = [u1, u2, weight, ...]",
                "one's own",
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
        source,
        law: None,
        kernel: None,
    };
    let topic = |(name, key, rows): &Row| Topic {
        name,
        key,
        entries: rows.iter().map(entry).collect(),
    };
    let materials = Topic {
        name: "materials",
        key: "material.model",
        entries: Model::all().map(Entry::from).collect(),
    };
    let kernels = Topic {
        name: "kernels",
        key: "discretization.kernel",
        entries: Kernel::ALL.into_iter().map(Entry::from).collect(),
    };
    [materials, kernels]
        .into_iter()
        .chain(ROWS.iter().map(topic))
        .chain(std::iter::once(language()))
        .collect()
}

/// The language of typed laws.
fn language() -> Topic {
    let entry = |name, formula| Entry {
        name,
        formula,
        source: "",
        law: None,
        kernel: None,
    };
    let grammar = [
        (
            "name",
            "any other name is a parameter: set material.name, or vary it along an axis",
        ),
        (
            "+ - * / ^",
            "-x^2 is -(x^2), 2^3^2 is 2^(3^2); products need their *",
        ),
        (
            "let name = ...;",
            "names a part; helpers come first: let a = I1 - 3; c1*a + c2*a^2",
        ),
        ("pi", "3.14159..."),
    ];
    let variables = VARIABLES.iter().map(|group| (group.label, group.meaning));
    let functions = FUNCTIONS
        .iter()
        .map(|function| (function.name, function.meaning));
    Topic {
        name: "formula",
        key: "material.energy",
        entries: variables
            .chain(functions)
            .chain(grammar)
            .map(|(name, meaning)| entry(name, meaning))
            .collect(),
    }
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
            if let Some(law) = &entry.law {
                law.write(formatter)?;
            }
            if let Some(kernel) = &entry.kernel {
                kernel.write(formatter)?;
            }
            if !entry.source.is_empty() {
                writeln!(formatter, "  {:<24} source: {}", "", entry.source)?;
            }
        }
        Ok(())
    }
}

impl KernelEntry {
    fn write(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let numbers = |all: [f64; 3]| all.map(|x| format!("{x:.6}")).join(", ");
        let smoothness = self.smoothness.map(|order| match order {
            Some(order) => format!("C{order}"),
            None => "smooth".to_owned(),
        });
        let mut line = |what: &str, text: String| {
            writeln!(formatter, "  {:<24} {what} in 1D, 2D, 3D: {text}", "")
        };
        line("smoothness over space", smoothness.join(", "))?;
        line(
            "support radius over smoothing length 2 sigma",
            numbers(self.support_over_smoothing_length),
        )?;
        line("integral over R0^D", numbers(self.integral))
    }
}

impl LawEntry {
    fn write(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut line = |what: &str, text: &str| writeln!(formatter, "  {:<24} {what}{text}", "");
        for parameter in &self.parameters {
            let ParameterEntry {
                name,
                unit,
                default,
                expected,
                meaning,
            } = parameter;
            let unit = match *unit {
                "1" => String::new(),
                unit => format!(" ({unit})"),
            };
            line(
                "",
                &format!("{name} = {default}{unit}: {meaning}; {expected}"),
            )?;
        }
        line("holds: ", self.domain)?;
        line("symmetry: ", self.symmetry)?;
        line("small strains: ", self.small_strains)?;
        match self.stressed_reference {
            Some(reason) => line("stressed in the reference: ", reason),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::topics;
    use crate::settings::{KEYS, Key, Kind, MethodSettings};

    #[test]
    fn the_catalog_has_exactly_the_words_that_the_keys_expect() {
        let mut of_words = 0;
        for topic in topics() {
            let key = KEYS
                .iter()
                .find(|key| key.name == topic.key)
                .expect("a known key");
            if key.kind == Kind::Text {
                continue;
            }
            of_words += 1;
            let mut expected: Vec<&str> = key.words().to_vec();
            let mut listed: Vec<&str> = topic.entries.iter().map(|entry| entry.name).collect();
            expected.sort_unstable();
            listed.sort_unstable();
            assert_eq!(listed, expected, "{}", topic.name);
        }
        // The words of one family of methods alone are told with their keys.
        let own = serde_json::to_value(MethodSettings::default()).expect("serializable");
        let is_of_family = |key: &&Key| {
            let name = key.parts().1;
            name != "method" && key.parts().0 == "discretization" && own.get(name).is_some()
        };
        let with_words = KEYS
            .iter()
            .filter(|key| !key.words().is_empty() && !is_of_family(key))
            .count();
        assert_eq!(
            of_words, with_words,
            "every key that takes words is a topic"
        );
    }
}
