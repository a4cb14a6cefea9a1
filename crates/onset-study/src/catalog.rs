//! The available options: every word of every choice, with its formula, its parameters and its source.

use crate::criteria::OTHER_NAMES;
use crate::csv::Table;
use crate::settings::presets::{METHOD, PRESETS, Preset};
use crate::settings::{
    KEYS, Key, Model, Origin, SettingError, Settings, Units, Value, aliases, study_keys,
};
use onset::criteria::Criterion;
use onset::formula::{FUNCTIONS, VARIABLES};
use onset::kernel::Kernel;
use onset::material::{Law, Parameter};
use serde::Serialize;
use std::sync::LazyLock;

/// Available option with its description.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Entry {
    /// Name of the option.
    pub name: &'static str,
    /// Meaning of the option, as a formula or a description.
    pub formula: &'static str,
    /// Source of the formula.
    pub source: &'static str,
    /// Details of a law; `None` for other words.
    #[serde(flatten)]
    pub law: Option<LawEntry>,
    /// Details of a kernel; `None` for other words.
    #[serde(flatten)]
    pub kernel: Option<KernelEntry>,
}

/// Details of a kernel. Arrays are for one, two and three dimensions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct KernelEntry {
    /// The integral of `W` over space for a support radius of one.
    pub integral: [f64; 3],
    /// The ratio of the support radius to the smoothing length `h = 2 sigma`.
    pub support_over_smoothing_length: [f64; 3],
    /// The ratio of the support radius to the smoothing length `h` as papers and codes with this kernel define it; this `h` enters artificial viscosity.
    pub support_over_nominal_smoothing_length: f64,
    /// Number of spatial derivatives that are continuous everywhere.
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
            support_over_nominal_smoothing_length: kernel.nominal_smoothing_length(1.0).recip(),
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

/// Details of a law.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LawEntry {
    /// Parameters of the law.
    pub parameters: Vec<ParameterEntry>,
    /// Domain in which the law is defined.
    pub domain: &'static str,
    /// Rotations of the reference configuration that leave the law unchanged.
    pub symmetry: &'static str,
    /// Description of the moduli at small strains.
    pub small_strains: &'static str,
    /// Reason for the stress in the reference configuration; `None` without stress.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stressed_reference: Option<&'static str>,
}

/// Parameter of a law.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParameterEntry {
    /// Name of the parameter.
    pub name: &'static str,
    /// Unit or dimension; `1` if dimensionless.
    pub unit: &'static str,
    /// Default value of the parameter.
    pub default: f64,
    /// Description of the admissible values.
    pub expected: String,
    /// Meaning of the parameter.
    pub meaning: &'static str,
}

impl From<&Parameter> for ParameterEntry {
    fn from(parameter: &Parameter) -> Self {
        Self {
            name: parameter.name,
            unit: parameter.unit,
            default: parameter.default,
            expected: parameter.expected(),
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

/// Key with its expected value and its conditions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct KeyEntry {
    /// Dotted name of the key.
    pub name: &'static str,
    /// Meaning of the key.
    pub meaning: &'static str,
    /// Description of the expected value.
    pub expects: String,
    /// Default value; empty without a default.
    pub default: String,
    /// Description of the conditions under which the key has an effect; empty if it always has.
    pub read_with: String,
}

/// Keys of studies and of `--set`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct KeyList {
    /// Method of the list; `None` for the list of all keys.
    pub method: Option<String>,
    /// Keys in the order of the documentation.
    pub keys: Vec<KeyEntry>,
}

impl KeyList {
    /// The keys as CSV, one row for each.
    pub fn csv(&self) -> String {
        Table::new(&self.keys, Units::Own)
            .with("key", "1", |own| own.name)
            .with("meaning", "1", |own| own.meaning)
            .with("expects", "1", |own| own.expects.as_str())
            .with("default", "1", |own| own.default.as_str())
            .with("read_with", "1", |own| own.read_with.as_str())
            .to_string()
    }

    /// Lists every key of studies and `--set`.
    pub fn all() -> Self {
        Self {
            method: None,
            keys: listed(study_keys()).map(KeyEntry::of).collect(),
        }
    }

    /// Lists the keys of the discretization that a method uses; the method may also be given by another common name.
    ///
    /// # Errors
    /// [`SettingError`] when the method is unknown.
    pub fn of_method(name: &str) -> Result<Self, SettingError> {
        const METHOD: &str = "discretization.method";
        let mut settings = Settings::default();
        let origin = Origin::CommandLine(format!("onset list method {name}"));
        let set = settings.set(METHOD, &Value::Word(name.to_owned()), origin);
        // The user requested a list, so the hint names this command instead of the key.
        set.map_err(|error| error.with_words_of_hint(&format!("{METHOD}="), "onset list method "))?;
        let entry = |key: &'static Key| {
            let lacking = key.lacking(METHOD, &|name| settings.value(name))?;
            let told: Vec<String> = lacking.iter().map(ToString::to_string).collect();
            Some(KeyEntry {
                // Default value with this method and no other settings.
                default: match settings.value(key.name) {
                    own if own == Settings::default().value(key.name) => key.default_value(),
                    Some(Value::Word(word)) => word,
                    own => own.map(|own| own.to_string()).unwrap_or_default(),
                },
                ..KeyEntry::new(key, told.join(" and "))
            })
        };
        let own = KEYS
            .iter()
            .filter(|key| key.parts().0 == "discretization" && key.name != METHOD);
        Ok(Self {
            method: match settings.value(METHOD) {
                Some(Value::Word(word)) => Some(word),
                _ => None,
            },
            keys: listed(own).filter_map(entry).collect(),
        })
    }
}

/// Keys in lists: the smoothing length follows the support, because it can set the support.
fn listed(keys: impl Iterator<Item = &'static Key>) -> impl Iterator<Item = &'static Key> {
    keys.flat_map(|key| {
        let sets_support = key.name == "discretization.support";
        let beside = sets_support.then(|| Key::named("discretization.smoothing-length"));
        std::iter::once(key).chain(beside.flatten())
    })
}

impl KeyEntry {
    /// Describes a key for a list.
    pub(crate) fn of(key: &'static Key) -> Self {
        Self::new(key, key.readers())
    }

    fn new(key: &'static Key, read_with: String) -> Self {
        Self {
            name: key.name,
            meaning: key.meaning,
            expects: key.expects(),
            default: key.default_value(),
            read_with,
        }
    }
}

impl std::fmt::Display for KeyList {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if let Some(method) = &self.method {
            writeln!(
                formatter,
                "keys that discretization.method = {method} reads\n"
            )?;
        }
        for key in &self.keys {
            let default = match key.default.as_str() {
                "" => String::new(),
                default => format!(" [default: {default}]"),
            };
            writeln!(formatter, "{}{default}", key.name)?;
            writeln!(formatter, "    {}", key.meaning)?;
            writeln!(formatter, "    {}", key.expects)?;
            if !key.read_with.is_empty() {
                writeln!(formatter, "    with {}", key.read_with)?;
            }
        }
        Ok(())
    }
}

/// Key with all of its options.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Topic {
    /// The topic, in the plural.
    pub name: &'static str,
    /// Key that accepts these options.
    pub key: &'static str,
    /// Options of the key, with their descriptions.
    pub entries: Vec<Entry>,
}

/// Options of topics as CSV, one row for each.
pub fn csv(topics: &[Topic]) -> String {
    let words: Vec<_> = topics
        .iter()
        .flat_map(|topic| topic.entries.iter().map(move |entry| (topic, entry)))
        .collect();
    Table::new(&words, Units::Own)
        .with("topic", "1", |(topic, _)| topic.name)
        .with("key", "1", |(topic, _)| topic.key)
        .with("name", "1", |(_, entry)| entry.name)
        .with("formula", "1", |(_, entry)| entry.formula)
        .with("source", "1", |(_, entry)| entry.source)
        .to_string()
}

/// The paper that sources refer to.
pub const PAPER: &str = "Xiao and Belytschko, Adv. Comput. Math. 23 (2005) 171";

/// Topic, key, and the options with formula and source.
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
                "f_I = -sum_q V_q P(F_q) grad phi_I(X_q), or with functions of current coordinates; see approximations, quadratures, frames",
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
                "f_i = -sum_p v_p sigma_p grad N_i(x_p) on a square or cubic grid, for any lattice",
                "Sulsky, Chen, Schreyer 1994",
            ),
        ],
    ),
    (
        "lattices",
        "discretization.lattice",
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
                "structure of diamond; two particles per cell",
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
                "points: the particles; volumes: Voronoi cells of the points",
                "equation (41) of the paper",
            ),
            (
                "stress-points",
                "points: the particles and the centers of the Delaunay cells; volumes: Voronoi cells of the points",
                "equations (42), (43) of the paper; Dyka et al.",
            ),
            (
                "stress-points-only",
                "points: the centers of the Delaunay cells; volumes: Voronoi cells of the points",
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
                "user-defined",
            ),
        ],
    ),
    (
        "planes",
        "material.plane",
        &[
            (
                "membrane",
                "a two-dimensional law: invariants of the two-by-two F, in-plane increments",
                "Naghdi and Tang, Phil. Trans. R. Soc. A 287 (1977) 145",
            ),
            (
                "strain",
                "the out-of-plane stretch is prescribed: plane strain, or uniaxial strain of a chain",
                "the paper",
            ),
            (
                "stress",
                "P_i3 = 0, the out-of-plane stretch is computed: plane stress of a thin sheet, or uniaxial stress of a chain",
                "Le Dret and Raoult, J. Math. Pures Appl. 74 (1995) 549",
            ),
        ],
    ),
    (
        "moduli",
        "material.moduli",
        &[
            (
                "long-term",
                "the constants of a law with a Prony series are moduli after complete relaxation",
                "the default of Abaqus",
            ),
            (
                "instantaneous",
                "the constants of a law with a Prony series are moduli before any relaxation",
                "ANSYS",
            ),
        ],
    ),
    (
        "loadings",
        "material.loading",
        &[
            (
                "slow",
                "the stress of a state has relaxed to the long-term stress",
                "Simo, Comput. Methods Appl. Mech. Eng. 60 (1987) 153",
            ),
            (
                "fast",
                "the stress of a state is the instantaneous stress",
                "Simo, Comput. Methods Appl. Mech. Eng. 60 (1987) 153",
            ),
        ],
    ),
    (
        "frames",
        "discretization.frame",
        &[
            (
                "lagrangian",
                "W(X - X_K): kernels in material coordinates",
                PAPER,
            ),
            (
                "eulerian",
                "W(x - x_K(t)): kernels in current coordinates",
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
        "current-lattices",
        "discretization.current-lattice",
        &[
            ("convected", "particles at F X", "a simulation"),
            (
                "regular",
                "particles at X, carrying the stress of F",
                "an interpretation of section 6.2 of the paper",
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
                "the support of the reference configuration, convected with the deformation",
            ),
        ],
    ),
    (
        "linearizations",
        "discretization.linearization",
        &[
            (
                "exact",
                "all quantities vary: the exact derivative of the discrete forces",
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
    (
        "penalty-forms",
        "discretization.penalty-form",
        &[
            (
                "published",
                "force along each bond: -alpha/2 E V_I V_J W_IJ / X_IJ^2 (delta_I + delta_J), delta_I = (F_I X_IJ - x_IJ).x_IJ / |x_IJ|",
                "Ganzenmueller, Comput. Methods Appl. Mech. Engrg. 286 (2015) 87",
            ),
            (
                "smd",
                "the published penalty with alpha(r) = hg/2 R^2/(R^2 + 0.01 h^2) r/(r + 0.1 h) r/(r + 0.01 h), R and r the reference and the current length of \
                 the bond, h = R0; the coefficient is the hourglass amplitude hg",
                "LAMMPS, pair_smd_tlsph.cpp",
            ),
        ],
    ),
    (
        "gradients",
        "discretization.gradient",
        &[
            (
                "kernel",
                "F_I = F + sum_J V_J (u_J - u_I) (x) grad W_IJ K_I^-1",
                "all forms of total-Lagrangian SPH",
            ),
            (
                "bonds",
                "sum_J V_J W_IJ F_IJ / sum_J V_J W_IJ with F_II = F_I, F_IJ = F + (x - F X) (x) X / |X|^2, F = (F_I + F_J) / 2",
                "derived from the abstract of Wiragunarsa and others, arXiv 2407.04021",
            ),
        ],
    ),
    (
        "shear-forces",
        "discretization.shear-forces",
        &[
            (
                "stress",
                "the stress of a particle acts along the gradients of its neighbors",
                "all forms of SPH",
            ),
            (
                "pairs",
                "zeta mu J^(-2/D) F of the stress as a Laplacian of positions over pairs; updated SPH: the mean stress, and \
                 da_I/dt = 2 zeta G / rho_I sum_J V_J (e.v_IJ) e W' / r",
                "Wu and others 2023; updated SPH: Zhang, Zhang, Rezavand and Hu, J. Comput. Phys. 2024",
            ),
        ],
    ),
    (
        "viscosities",
        "discretization.viscosity-switch",
        &[
            (
                "always",
                "Pi = -alpha c mu / rho, mu = h v.x / (x^2 + 0.01 h^2), h the kernel's smoothing length, in approach and separation",
                "Monaghan and Gingold, J. Comput. Phys. 52 (1983) 374, without its switch",
            ),
            (
                "averaged",
                "half of `always`: the mean over an oscillation of a viscosity that acts in approach only",
                "Monaghan and Gingold 1983",
            ),
            (
                "smd",
                "mu = h v.x / (|x| + 0.1 h)^2, h = R0 the whole support radius, in approach and separation; bonds of material \
                 coordinates along x / (|x| + 0.01 h)",
                "LAMMPS, pair_smd_tlsph.cpp and pair_smd_ulsph.cpp; Ganzenmueller 2015",
            ),
        ],
    ),
    (
        "upwinding",
        "discretization.upwinding",
        &[
            ("none", "no dissipation", "the forces of the method alone"),
            (
                "constant",
                "f_I = sum_J |A_IJ|/2 rho (c_p n (x) n + c_s (1 - n (x) n)) (v_J - v_I), n along F^-T A_IJ",
                "acoustic Riemann solver of first order",
            ),
            (
                "linear",
                "as constant, with the jump v_J - v_I - (L_I + L_J) X_IJ / 2 of linear velocities",
                "Lee, Gil, Ghavamian and Bonet, Comput. Methods Appl. Mech. Engrg. 344 (2019) 209",
            ),
        ],
    ),
    (
        "smoothed-motions",
        "discretization.smoothed-motion",
        &[
            (
                "everything",
                "x, F and rho follow T v, T v_I = v_I + epsilon sum_J m_J/rho_IJ (v_J - v_I) W_IJ: K T instead of K",
                "Monaghan, J. Comput. Phys. 82 (1989) 1",
            ),
            (
                "positions",
                "x follows T v; F and rho follow v: K_x T + K_F instead of K = K_x + K_F",
                "PySPH, XSPHCorrection with SolidMechStep or WCSPHStep; Monaghan 1992",
            ),
        ],
    ),
    (
        "integrations",
        "discretization.integration",
        &[
            (
                "full",
                "f_a = -sum_q V_q P(F_q) grad N_a(X_q), two Gauss points along each axis",
                "finite elements",
            ),
            (
                "mean-dilatation",
                "E = sum_q V_q W((theta/J_q)^(1/D) F_q), theta = sum_q V_q J_q / V, J in the dimensions of the mesh: B-bar at small strains",
                "Simo, Taylor and Pister, Comput. Methods Appl. Mech. Eng. 51 (1985) 177",
            ),
            (
                "one-point",
                "f_a = -V P(F) b_a with the mean gradients b_a of the element",
                "Flanagan and Belytschko, Int. J. Numer. Meth. Engng. 17 (1981) 679",
            ),
        ],
    ),
    (
        "transfers",
        "discretization.transfer",
        &[
            (
                "continuous",
                "dv_p/dt = sum_i N_ip f_i/m_i: the limit of flip for short steps",
                "Brackbill and Ruppel, J. Comput. Phys. 65 (1986) 314",
            ),
            (
                "flip",
                "v_p' = sum_i N_ip v_i' + alpha (v_p - sum_i N_ip v_i), alpha = flip-share",
                "Brackbill and Ruppel, J. Comput. Phys. 65 (1986) 314",
            ),
            ("pic", "v_p' = sum_i N_ip v_i'", "Harlow 1964"),
            (
                "apic",
                "v_p' = sum_i N_ip v_i', C_p' = sum_i N_ip v_i' (x) (x_i - x_p) D_p^-1",
                "Jiang, Schroeder, Selle, Teran and Stomakhin 2015",
            ),
            (
                "xpic",
                "v_p' = sum_i N_ip (v_i^k + v_i' - v_i), v^k = (1 + A + ... + A^(k-1)) v, A = 1 - S+ S, k = transfer-order",
                "Hammerquist and Nairn, Comput. Methods Appl. Mech. Eng. 318 (2017) 724",
            ),
            (
                "fmpm",
                "as pic, with v'^k = (1 + A + ... + A^(k-1)) v' in place of v' for velocities, positions and strains",
                "Nairn and Hammerquist, Comput. Methods Appl. Mech. Eng. 386 (2021) 114075",
            ),
        ],
    ),
    (
        "hourglass-scales",
        "discretization.hourglass-scale",
        &[
            (
                "gradients",
                "f_a = -gamma_a (kappa M V b^2 q + epsilon rho c V b dq/dt), q = sum_a gamma_a u_a, b^2 = sum_a |b_a|^2",
                "after Flanagan and Belytschko, Int. J. Numer. Meth. Engng. 17 (1981) 679",
            ),
            (
                "radioss",
                "bricks: 0.038 kappa M V^(1/3) and epsilon/4 rho c V^(2/3); quadrilaterals: epsilon/2 rho c V^(1/2); with 2^D gamma_a",
                "OpenRadioss, shvis3.F, s_hg5.F, qhvis2.F; LS-DYNA theory manual: Q rho c V^(2/3) / 4 of bricks",
            ),
        ],
    ),
];

/// Returns all topics of `onset list`.
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
        .chain([presets(), criteria(), language(), typed_words()])
        .collect()
}

/// Methods of particle codes, as option `--preset` names them.
fn presets() -> Topic {
    static PRESET_LINES: LazyLock<Vec<(&Preset, String, String)>> = LazyLock::new(|| {
        let told = |own: &'static Preset| {
            let keys: Vec<String> = own
                .keys
                .iter()
                .map(|(key, value)| {
                    format!("{} = {value}", key.trim_start_matches("discretization."))
                })
                .collect();
            let formula = format!(
                "{}: {}, {}; {}",
                own.title,
                own.method,
                keys.join(", "),
                own.note
            );
            (
                own,
                formula,
                format!("version {}; {}", own.version, own.source),
            )
        };
        PRESETS.iter().map(told).collect()
    });
    let entry = |(own, formula, source): &'static (&Preset, String, String)| Entry {
        name: own.name,
        formula,
        source,
        law: None,
        kernel: None,
    };
    Topic {
        name: "presets",
        key: METHOD,
        entries: PRESET_LINES.iter().map(entry).collect(),
    }
}

/// Criteria of stability, as `onset criteria` names them.
fn criteria() -> Topic {
    static DEFINITIONS: LazyLock<Vec<(Criterion, String)>> = LazyLock::new(|| {
        let told = |own: Criterion| {
            let others = OTHER_NAMES
                .iter()
                .filter(|(_, criterion)| *criterion == own);
            let others: String = others.map(|(name, _)| format!("; also {name}")).collect();
            (
                own,
                format!("{}: {}{others}", own.title(), own.definition()),
            )
        };
        Criterion::ALL.into_iter().map(told).collect()
    });
    let entry = |(criterion, definition): &'static (Criterion, String)| Entry {
        name: criterion.name(),
        formula: definition,
        source: criterion.source(),
        law: None,
        kernel: None,
    };
    Topic {
        name: "criteria",
        key: "of onset criteria and card",
        entries: DEFINITIONS.iter().map(entry).collect(),
    }
}

/// Alternative names of options, and their meaning.
fn typed_words() -> Topic {
    static WORDS: LazyLock<Vec<(&str, &str, String)>> = LazyLock::new(|| aliases().collect());
    let entry = |(key, typed, stands_for): &'static (&'static str, &'static str, String)| Entry {
        name: typed,
        formula: stands_for,
        source: key,
        law: None,
        kernel: None,
    };
    Topic {
        name: "aliases",
        key: "other names of words",
        entries: WORDS.iter().map(entry).collect(),
    }
}

/// The language of user-defined laws.
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
            "-x^2 is -(x^2), 2^3^2 is 2^(3^2); products need an explicit *",
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

/// Returns the topic with a name.
///
/// # Errors
/// The names of all topics if the name is unknown.
pub fn topic(name: &str) -> Result<Topic, Vec<&'static str>> {
    let name = crate::settings::renamed_topic(name);
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
        let what = [self.key, meaning];
        let what: Vec<&str> = what.into_iter().filter(|text| !text.is_empty()).collect();
        writeln!(formatter, "{} ({})", self.name, what.join(": "))?;
        for entry in &self.entries {
            writeln!(formatter, "  {:<24} {}", entry.name, entry.formula)?;
            if let Some(law) = &entry.law {
                law.write(formatter)?;
            }
            if let Some(kernel) = &entry.kernel {
                kernel.write(formatter)?;
            }
            match entry.source {
                "" => {}
                key if self.name == "aliases" => writeln!(formatter, "  {:<24} for {key}", "")?,
                source => writeln!(formatter, "  {:<24} source: {source}", "")?,
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
            "support radius divided by the smoothing length 2 sigma",
            numbers(self.support_over_smoothing_length),
        )?;
        line("integral over R0^D", numbers(self.integral))?;
        let radii = self.support_over_nominal_smoothing_length;
        writeln!(
            formatter,
            "  {:<24} smoothing length of codes, in artificial viscosity: R0 / {radii}",
            ""
        )
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
        line("domain: ", self.domain)?;
        line("symmetry: ", self.symmetry)?;
        line("small strains: ", self.small_strains)?;
        match self.stressed_reference {
            Some(reason) => line("reference stress: ", reason),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{KeyList, topics};
    use crate::settings::{KEYS, Key, Kind, Settings, Value, aliases};

    /// Returns true if only some families of methods use a key.
    fn is_of_family(key: &Key) -> bool {
        let leads_there = |name: &str| {
            let above = KEYS.iter().find(|other| other.name == name);
            name == "discretization.method" || above.is_some_and(is_of_family)
        };
        let mut cases = key.read_with.iter();
        !key.read_with.is_empty() && cases.all(|case| case.iter().any(|need| leads_there(need.key)))
    }

    #[test]
    fn every_listed_default_is_the_value_in_effect() {
        let methods = KEYS.iter().find(|key| key.name == "discretization.method");
        let words = methods.expect("a key").words().iter().copied();
        for method in words.chain(aliases().map(|(_, alias, _)| alias)) {
            let Ok(list) = KeyList::of_method(method) else {
                continue;
            };
            let set = format!("discretization.method={method}");
            let settings =
                Settings::from_assignments(std::slice::from_ref(&set)).expect("a method");
            for entry in list.keys {
                let used = settings.value(entry.name);
                if entry.default.is_empty() {
                    let is_empty =
                        matches!(&used, Some(Value::Numbers(numbers)) if numbers.is_empty());
                    assert!(is_empty || used.is_none(), "{method}: {}", entry.name);
                    continue;
                }
                let mut told = settings.clone();
                told.assign(&format!("{}={}", entry.name, entry.default))
                    .expect("a value");
                assert_eq!(told.value(entry.name), used, "{method}: {}", entry.name);
            }
        }
    }

    // Words that only some families of methods use are listed with their keys; dialects of codes are listed separately.
    #[test]
    fn the_catalog_has_exactly_the_words_that_the_keys_expect() {
        let mut of_words = 0;
        // Presets are further words of the key of the method, which the topic of the methods lists.
        for topic in topics().iter().filter(|topic| topic.name != "presets") {
            let Some(key) = KEYS.iter().find(|key| key.name == topic.key) else {
                // Aliases belong to several keys; criteria are words of answers, not of a key.
                assert!(["aliases", "criteria"].contains(&topic.name));
                continue;
            };
            if key.kind == Kind::Text {
                continue;
            }
            of_words += usize::from(!is_of_family(key));
            let mut expected: Vec<&str> = key.words().to_vec();
            let mut listed: Vec<&str> = topic.entries.iter().map(|entry| entry.name).collect();
            expected.sort_unstable();
            listed.sort_unstable();
            assert_eq!(listed, expected, "{}", topic.name);
        }
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
