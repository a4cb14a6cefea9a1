//! The arguments of the command line.

use crate::fail_on::FailOn;
use crate::printing::PrintingArguments;
use clap::{ArgGroup, Args, Parser, Subcommand};
use clap_complete::Shell;
use onset_study::audit::Convention;
use onset_study::brief::Brief;
use onset_study::compare::Thresholds;
use onset_study::criteria::{Lateral, Mode, Range as Stretches};
use onset_study::figure::ColorMap;
use onset_study::limit::Integrator;
use onset_study::localization::PARAMETERS;
use onset_study::map::Part;
use onset_study::settings::Admitted::Positive;
use onset_study::settings::Program;
use onset_study::settings::{BODY_KEYS, COMPARISON_KEYS, GRIP_KEYS, KEYS, Key, did_you_mean};
use onset_study::simulate::Stepper;
use onset_study::verify::Stepping;
use std::path::PathBuf;
use std::str::FromStr;

/// A key with what it expects and means.
fn line(key: &Key) -> String {
    let default = match key.default_value().as_str() {
        "" => String::new(),
        default => format!(" [default: {default}]"),
    };
    let meaning = format!("{}{default}", key.meaning);
    entry(key.name, &meaning, &key.expects())
}

/// Where the meaning of a key begins, and where it is broken at the latest.
const INDENT: usize = 34;
const WIDTH: usize = 100;

/// A name with what it means and expects, in lines of their own below each other.
fn entry(name: &str, meaning: &str, expects: &str) -> String {
    let mut text = format!("  {name:<31}");
    for (n, part) in [meaning, expects].into_iter().enumerate() {
        // The name takes the place of the first indent, and goes on beyond it where it is long.
        let mut column = match n {
            0 => text.chars().count(),
            _ => WIDTH,
        };
        for word in part.split_whitespace() {
            let length = word.chars().count();
            if column + 1 + length > WIDTH {
                text.push_str(&format!("\n{:INDENT$}", ""));
                column = INDENT;
            } else {
                text.push(' ');
                column += 1;
            }
            text.push_str(word);
            column += length;
        }
    }
    text + "\n"
}

/// The keys of laws, from the one table that defines them.
fn law_keys() -> String {
    let (of_laws, others): (Vec<&Key>, Vec<&Key>) = KEYS
        .iter()
        .filter(|key| key.parts().0 == "material")
        .partition(|key| key.is_parameter());
    let (model, others): (Vec<&Key>, Vec<&Key>) = others
        .into_iter()
        .partition(|key| key.name == "material.model");
    let lines = |keys: Vec<&Key>| keys.into_iter().map(line).collect::<String>();
    format!(
        "Keys of --set:\n{}  {:<31} a parameter of the law, one of {}\n{:34}`onset list materials` tells which it has; or two of\n\
         {:34}young, poisson, bulk and shear\n{}",
        lines(model),
        "material.<parameter>",
        of_laws.len(),
        "",
        "",
        lines(others)
    )
}

/// The keys that `--set` takes.
fn keys() -> String {
    let own = KEYS.iter().filter(|key| key.parts().0 == "discretization");
    let own: String = own.map(line).collect();
    format!(
        "{}{own}\n`onset list method NAME` tells which keys a method reads. Values with dimensions may have units, and then all must: \
         material.mu=80GPa, discretization.spacing=1mm, discretization.density=7850kg/m^3. Common names such as tlsph, \
         fem or fcc are read: `onset list aliases`.\n",
        law_keys()
    )
}

/// Examples, and behind them in the long help the keys.
fn with_keys(examples: &str, keys: &str) -> String {
    format!("{examples}\n\n{keys}")
}

const STATE_EXAMPLES: &str = "Examples:
  onset state --stretch 1.15,1 --set discretization.method=tlsph
  onset state --stretch 1.5,1 --energy \"mu/2*(I1 - 3 - 2*ln(J))\" --set material.mu=1
  onset state STUDY.toml --deformation-gradient 1,0.2,0,1 --fail-on numerical,zero-energy";
#[cfg(feature = "explore")]
const EXPLORE_EXAMPLES: &str = "Examples:
  onset explore
  onset explore STUDY.toml --set discretization.method=updated-sph
  onset explore map.zarr --port 8000 --no-browser";
const DISPERSION_EXAMPLES: &str = "Examples:
  onset dispersion --stretch 1.2,0.9 --path --out waves
  onset dispersion --stretch 1.2,0.9 --path --format csv
  onset dispersion --stretch 1,1 --wave-vector 2.0,1.1 --set discretization.frame=eulerian";
const PATH_EXAMPLES: &str = "Examples:
  onset path --mode uniaxial --to 3 --set material.model=ogden --out uniaxial
  onset path --from 1,1 --to 3,1
  onset path --mode simple-shear --lateral plane-strain --to 2 --fail-on any";
const CRITERIA_EXAMPLES: &str = "Examples:
  onset criteria --set material.model=neo-hooke --set material.young=3 --set material.poisson=0.49
  onset criteria --set material.model=ogden --incompressible
  onset criteria --mode uniaxial --range 0.2,5 --out figures";
const CARD_EXAMPLES: &str = "Examples:
  onset card --energy \"mu/2*(I1 - 3 - 2*ln(J))\" --set material.mu=1 --out card
  onset card --set material.model=ogden --incompressible --mode uniaxial
  onset card rubber.inp --from abaqus";
const MODES_EXAMPLES: &str = "Examples:
  onset modes --set discretization.quadrature=nodal --out modes
  onset modes --set discretization.method=tlsph
  onset modes --set discretization.method=fem --set discretization.integration=one-point";
const TUNE_EXAMPLES: &str = "Examples:
  onset tune discretization.penalty --set discretization.method=tlsph
  onset tune discretization.support --range 1.2,3 --out support
  onset tune discretization.penalty --set discretization.method=tlsph --weak 0.2";
const LIMIT_EXAMPLES: &str = "Examples:
  onset limit --time-step 0.01 --vary material.young --set material.young=2 --set material.poisson=0.3
  onset limit --time-step '1 us' --vary discretization.spacing studies/rubber.toml --safety 0.8
  onset limit --time-step 0.1 --vary discretization.penalty --range 0,10 --set discretization.method=tlsph";
const COMPARE_EXAMPLES: &str = "Examples:
  onset compare comparisons/methods-2d.toml --out results
  onset compare STUDY.toml --set compare.states=24
  onset compare comparisons/methods-1d.toml --format csv";
const RECOMMEND_EXAMPLES: &str = "Examples:
  onset recommend --set material.model=blatz-ko --stretches 0.8,1.6
  onset recommend --dimension 3 --weak 0.2
  onset recommend comparisons/methods-2d.toml --out results";
const VERIFY_EXAMPLES: &str = "Examples:
  onset verify deck --code lammps-smd-tlsph --wave-vector 3.141592654,3.141592654 \\
      --set material.young=1 --set material.poisson=0.3 --set discretization.support=2.01 --set discretization.penalty=1 --out deck
  onset verify run deck --program ENVIRONMENT/bin/lmp
  onset verify read deck/wave.dump --json

Exit codes of run and read: 0 agrees, 1 differs, 3 undecided, 2 the input is wrong.";
const SIMULATE_EXAMPLES: &str = "Examples:
  onset simulate --stretch 1.3,1 --set discretization.method=updated-sph --mode critical
  onset simulate STUDY.toml --stretch 1.2,0.9 --cells 16 --mode noise --steps 20000 --out run --resume
  onset simulate studies/bodies/notched-plate.toml --time 60 --amplitude 0.01 --out plate

Exit codes: 0 agrees (or a body has come to its end), 1 differs or the motion breaks down, 3 undecided, 2 the input is wrong, 130 interrupted.";
const AUDIT_EXAMPLES: &str = "Examples:
  onset audit --set material.model=ogden
  onset audit --set material.model=umat --set material.library=./my_umat.so --strict
  onset audit --energy \"mu/2*(I1 - 3 - 2*ln(J))\" --set material.mu=1 --strain 0.3";
const LOCALIZE_EXAMPLES: &str = "Examples:
  onset localize --model drucker-prager --path plane-strain
  onset localize --model mohr-coulomb --set plasticity.confinement=50 --out band
  onset localize --model umat --set material.library=./my_umat.so --set material.properties=200e3,0.3,250,2e3";

const CHECK_EXAMPLES: &str = "Examples:
  onset check studies/rubber.toml
  onset check studies/*.toml
  onset check STUDY.toml --set map.adaptive=true";
const MAP_EXAMPLES: &str = "Examples:
  onset map studies/rubber.toml --out rubber.zarr
  onset map STUDY.toml --out map.zarr --set map.adaptive=true --resume
  onset map STUDY.toml --out map.zarr --fail-on numerical,zero-energy";
const PLOT_EXAMPLES: &str = "Examples:
  onset plot map.zarr --out map.pdf
  onset plot map.zarr --field growth_rate --color-map cividis --out growth.png
  onset plot one.zarr other.zarr --title \"Two supports\" --out both.svg";
const BOUNDARY_EXAMPLES: &str = "Examples:
  onset boundary studies/shear-stretch.toml
  onset boundary STUDY.toml --out traced
  onset boundary STUDY.toml --flutter --json";

/// The keys of comparisons, from the one table that defines them.
fn comparison_keys() -> String {
    format!(
        "Keys of [compare] and --set, beside those of [material] and [discretization]:\n{}\
         A method in [[methods]] has a name and keys of [discretization].\n",
        COMPARISON_KEYS.iter().map(line).collect::<String>()
    )
}

/// The keys of bodies and grips, from the one table that defines them.
fn body_keys() -> String {
    let of = |keys: &[Key]| keys.iter().map(line).collect::<String>();
    format!(
        "\nKeys of [body] in a study:\n{}\nKeys of [[grips]], as many as there are:\n{}",
        of(BODY_KEYS),
        of(GRIP_KEYS)
    )
}

/// The parameters of `onset localize`, from the one table that defines them.
fn plastic_parameters() -> String {
    let line = |parameter: &onset_study::localization::Parameter| {
        let (name, meaning, default) = (parameter.name, parameter.meaning, parameter.default);
        let condition = parameter
            .only_with
            .map_or(String::new(), |(needed, words)| {
                let needed = needed.trim_start_matches("plasticity.");
                format!("; only with {needed} = {}", words.join(" or "))
            });
        entry(
            name,
            &format!("{meaning} [default: {default}]"),
            &format!("{}{condition}", parameter.kind.expects()),
        )
    };
    format!(
        "Keys of --set:\n{}\nStresses may have units, and then all must: plasticity.shear-modulus=80GPa, plasticity.strength=200MPa.\n",
        PARAMETERS.iter().map(line).collect::<String>()
    )
}

/// Where are your material and your discretization stable, and is an instability physical or numerical?
#[derive(Debug, Parser)]
#[command(
    name = "onset",
    version,
    propagate_version = true,
    arg_required_else_help = true
)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// How to print.
    #[command(flatten)]
    pub printing: PrintingArguments,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Is this state stable, and if not, is it physical or numerical?
    #[command(after_help = STATE_EXAMPLES, after_long_help = with_keys(STATE_EXAMPLES, &keys()))]
    State {
        /// The problem.
        #[command(flatten)]
        problem: ProblemArguments,
        /// The state.
        #[command(flatten)]
        strain: StrainArguments,
        /// Prove stability or instability, with a bound or a witness.
        #[arg(long, help_heading = "Proof")]
        certify: bool,
        /// From where the measure of an undecided state counts as away from zero.
        #[arg(
            long,
            value_name = "T",
            default_value_t = 1e-3,
            value_parser = tolerance,
            allow_negative_numbers = true,
            requires = "certify",
            help_heading = "Proof"
        )]
        tolerance: f64,
        /// Limit of weakly controlled waves.
        #[command(flatten)]
        weak: WeakArgument,
        /// How much is printed.
        #[command(flatten)]
        detail: DetailArguments,
        /// Verdicts with which the command fails.
        #[command(flatten)]
        failing: FailingArguments,
        /// Show the state in the page of `onset explore` instead of printing it.
        #[cfg(feature = "explore")]
        #[arg(long, conflicts_with_all = ["certify", "fail_on", "deformation_gradient"])]
        open: bool,
    },
    /// A page in the browser: the map of a method, and what is known of the state that is clicked
    ///
    /// Material and method are chosen with sliders and lists; beside the map stand the sentence, stresses, the acoustic tensor, dispersion and the
    /// moving mode. The page is served on this machine alone, and asks no other server.
    #[cfg(feature = "explore")]
    #[command(after_help = EXPLORE_EXAMPLES)]
    Explore(ExploreArguments),
    /// Frequencies of plane waves: of one wave vector, or along a path
    #[command(group(ArgGroup::new("waves").required(true).args(["wave_vector", "path"])))]
    #[command(after_help = DISPERSION_EXAMPLES, after_long_help = with_keys(DISPERSION_EXAMPLES, &keys()))]
    Dispersion {
        /// The problem.
        #[command(flatten)]
        problem: ProblemArguments,
        /// The state.
        #[command(flatten)]
        strain: StrainArguments,
        /// Reference wave vector, for example 2.0,1.1 (in units of 1/length).
        #[arg(long, value_name = "K1,K2", allow_hyphen_values = true)]
        wave_vector: Option<String>,
        /// Draw a dispersion diagram along the points of high symmetry that the state tells apart, or along a path of your own: their
        /// names (G-M-K-G), or points in units of the reciprocal vectors ("0,0; 0.5,0; K"). The line through the critical wave
        /// vector k* is added.
        #[arg(
            long,
            value_name = "POINTS",
            num_args = 0..=1
        )]
        path: Option<Option<String>>,
        /// Folder for dispersion.svg, dispersion.png, dispersion.csv and density-of-states.csv; nothing is written without it.
        #[arg(long, value_name = "DIR", conflicts_with = "wave_vector")]
        out: Option<PathBuf>,
    },
    /// Where along a path of deformations or a loading is stability lost?
    #[command(after_help = PATH_EXAMPLES, after_long_help = with_keys(PATH_EXAMPLES, &keys()))]
    Path {
        /// The problem.
        #[command(flatten)]
        given: GivenArguments,
        /// The path.
        #[command(flatten)]
        course: CourseArguments,
        /// Folder for path.csv, path.svg and path.png: softest mode and smallest acoustic eigenvalue along the path; nothing is written
        /// without it.
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
        /// Verdicts with which the command fails.
        #[command(flatten)]
        failing: FailingArguments,
    },
    /// Where does a plastic material localize, in which band, at which angle?
    #[command(after_help = LOCALIZE_EXAMPLES, after_long_help = with_keys(LOCALIZE_EXAMPLES, &plastic_parameters()))]
    Localize(LocalizeArguments),
    /// The verdict on every state of a study, into a Zarr store; resumable
    #[command(after_help = MAP_EXAMPLES)]
    Map(MapArguments),
    /// Where along standard loadings is each stability criterion lost?
    ///
    /// Ellipticity, Hill, Drucker, Baker-Ericksen, largest load and others, with traction-free faces solved for.
    #[command(after_help = CRITERIA_EXAMPLES, after_long_help = with_keys(CRITERIA_EXAMPLES, &law_keys()))]
    Criteria(CriteriaArguments),
    /// The safe range of a law: stretches within which it is strongly elliptic
    #[command(after_help = CARD_EXAMPLES, after_long_help = with_keys(CARD_EXAMPLES, &law_keys()))]
    Card(CardArguments),
    /// The available options, with formulas, parameters and sources
    List {
        /// materials, planes, methods, lattices, kernels, approximations, quadratures, frames, backgrounds, current-lattices, support-sizes,
        /// linearizations; criteria of stability; formula for the language of typed laws; aliases for common names; keys, or method with a NAME;
        /// everything when left out.
        topic: Option<String>,
        /// With `method`: the method whose keys are listed, for example total-lagrangian-sph.
        #[arg(requires = "topic")]
        name: Option<String>,
    },
    /// Is a study file valid, what does it ask for, what will it cost?
    #[command(after_help = CHECK_EXAMPLES)]
    Check {
        /// Study files, - for standard input.
        #[arg(value_name = "FILE", required = true)]
        files: Vec<PathBuf>,
        /// Set a key of the study, overriding the file, for example map.tile=128 (may be given several times).
        #[arg(long = "set", value_name = "KEY=VALUE")]
        assignments: Vec<String>,
        /// That FILE is a block.
        #[command(flatten)]
        block: RefusedBlockArguments,
        /// What the file may load.
        #[command(flatten)]
        trust: TrustArguments,
    },
    /// Where in the plane of a study do material and particles lose stability?
    ///
    /// With the distance of the two boundaries, and the areas of false and suppressed instability.
    #[command(after_help = BOUNDARY_EXAMPLES)]
    Boundary {
        /// A study file with two axes, - for standard input.
        file: PathBuf,
        /// Set a key of the study, overriding the file, for example discretization.support=1.6 (may be given several times).
        #[arg(long = "set", value_name = "KEY=VALUE")]
        assignments: Vec<String>,
        /// Tell flutter from divergence: trace the boundary between them too.
        #[arg(long)]
        flutter: bool,
        /// Folder for boundary.geojson and boundary.csv; nothing is written without it.
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
        /// That FILE is a block.
        #[command(flatten)]
        block: RefusedBlockArguments,
        /// What the file may load.
        #[command(flatten)]
        trust: TrustArguments,
    },
    /// Several methods side by side for one material
    ///
    /// Spurious modes, errors of frequencies, onsets, fidelity, time step, cost.
    #[command(after_help = COMPARE_EXAMPLES, after_long_help = with_keys(COMPARE_EXAMPLES, &comparison_keys()))]
    Compare(CompareArguments),
    /// Which method for this material and these stretches?
    ///
    /// Methods ranked by rules that are printed, with what other limits in them would change.
    #[command(after_help = RECOMMEND_EXAMPLES, after_long_help = with_keys(RECOMMEND_EXAMPLES, &comparison_keys()))]
    Recommend(RecommendArguments),
    /// Zero-energy and weakly controlled modes of a method, drawn, animated, exported
    #[command(after_help = MODES_EXAMPLES, after_long_help = with_keys(MODES_EXAMPLES, &keys()))]
    Modes(ModesArguments),
    /// The smallest coefficient of a stabilization that is sufficient
    ///
    /// It removes the spurious modes and does not mask the instability of the material.
    #[command(after_help = TUNE_EXAMPLES, after_long_help = with_keys(TUNE_EXAMPLES, &keys()))]
    Tune(TuneArguments),
    /// Which modulus, spacing or coefficient does a time step admit?
    ///
    /// The values of a setting with which a given time step is below the critical one of a state.
    #[command(after_help = LIMIT_EXAMPLES, after_long_help = with_keys(LIMIT_EXAMPLES, &keys()))]
    Limit(LimitArguments),
    /// Does a particle code do what is predicted?
    ///
    /// A wave is seeded, run and measured: decks, runs and readings for LAMMPS (SMD, PERI), PySPH and any other code.
    #[command(after_help = VERIFY_EXAMPLES)]
    Verify {
        /// What to do.
        #[command(subcommand)]
        task: VerifyTask,
    },
    /// See a prediction in motion: the particles of a periodic patch, step by step
    ///
    /// A patch of cells about a homogeneous state, one wave or noise, the nonlinear forces of the method: the measured rate of a wave beside the
    /// predicted one in discrete time, with histories, fields and checkpoints.
    /// Of a study with a body that body instead, with its grips.
    #[command(after_help = SIMULATE_EXAMPLES, after_long_help = with_keys(SIMULATE_EXAMPLES, &(keys() + &body_keys())))]
    Simulate(Box<SimulateArguments>),
    /// Draw stored maps: verdicts and boundaries, or a field; overlays
    ///
    /// Verdicts with the boundaries of material and particles, or a field; several stores in one overlay.
    #[command(after_help = PLOT_EXAMPLES)]
    Plot(PlotArguments),
    /// Does a law have an energy, and is its tangent consistent?
    #[command(after_help = AUDIT_EXAMPLES, after_long_help = with_keys(AUDIT_EXAMPLES, &law_keys()))]
    Audit(AuditArguments),
    /// Print Abaqus's utility routines in Fortran, to compile with a UMAT
    ///
    /// SINV, SPRINC, ROTSIG, XIT and others, for a UMAT that calls them.
    UmatUtilities,
    /// Print the JSON Schema of study files, for editors and other programs
    Schema,
    /// Print a script that completes commands and options in a shell
    Completions {
        /// bash, zsh, fish, elvish or powershell.
        shell: Shell,
    },
    /// Write manual pages, one for each command
    Man {
        /// Folder for onset.1, onset-state.1, ...
        #[arg(long, value_name = "DIR")]
        out: PathBuf,
    },
    /// Reproduce the paper: figures 2 and 4 to 10, and a verdict on every claim
    Reproduce {
        /// Folder for figures, data and the report.
        #[arg(long, value_name = "DIR", default_value = "reproduction")]
        out: PathBuf,
    },
}

/// A path of deformations.
#[derive(Debug, Args)]
pub struct CourseArguments {
    /// A loading: uniaxial, equibiaxial, planar, simple-shear or hydrostatic; --from and --to are then its imposed stretches, in simple shear the amount of
    /// shear gamma.
    #[arg(long, value_name = "MODE", value_parser = mode, help_heading = "Path")]
    pub mode: Option<Mode>,
    /// What holds the other directions: free (no traction on lateral faces), plane-stress, plane-strain or held [default: the freest that
    /// the mode has].
    #[arg(long, value_name = "WHAT", value_parser = lateral, requires = "mode", help_heading = "Path")]
    pub lateral: Option<Lateral>,
    /// Start: two or three stretches, or the components F11,F12,F21,F22; with --mode one stretch [default: 1], in simple shear gamma [default: 0].
    /// A program (abaqus, ansys, felupe or hyperelastic) says that FILE is a block of it, beside a start (may be given twice).
    #[arg(
        long,
        value_name = "L1,L2",
        allow_hyphen_values = true,
        required_unless_present = "mode",
        help_heading = "Path"
    )]
    pub from: Vec<String>,
    /// The material of FILE where that is a block, by its name in Abaqus, its number in ANSYS [default: the first one with a law].
    #[arg(long, value_name = "NAME", requires = "from", help_heading = "Problem")]
    pub material: Option<String>,
    /// End, likewise.
    #[arg(
        long,
        value_name = "L1,L2",
        allow_hyphen_values = true,
        help_heading = "Path"
    )]
    pub to: String,
}

/// Verdicts with which a command fails.
#[derive(Debug, Args)]
pub struct FailingArguments {
    /// End with exit code 3 when a state has one of these verdicts, for continuous integration: stable, physical, zero-energy, numerical,
    /// suppressed, undefined; or unstable, unfaithful, any.
    #[arg(long, value_name = "VERDICTS", value_parser = FailOn::parse)]
    pub fail_on: Option<FailOn>,
}

/// Limit of weakly controlled waves.
#[derive(Clone, Copy, Debug, Args)]
pub struct WeakArgument {
    /// A wave with less than this share of the frequency of the material's slowest wave is weakly controlled.
    #[arg(id = "weak", long, value_name = "SHARE", default_value_t = Thresholds::default().weak, value_parser = share, help_heading = "Limits")]
    pub share: f64,
}

/// Limits of what counts as wrong.
#[derive(Clone, Copy, Debug, Args)]
pub struct ThresholdArguments {
    /// Limit of weakly controlled waves.
    #[command(flatten)]
    pub weak: WeakArgument,
    /// Verdicts may be wrong on this share of the window of states.
    #[arg(long, value_name = "SHARE", default_value_t = Thresholds::default().wrong, value_parser = share, help_heading = "Limits")]
    pub wrong: f64,
}

/// How much of an answer is printed.
#[derive(Clone, Copy, Debug, Args)]
pub struct DetailArguments {
    /// Print the whole answer; by default at most 12 lines.
    #[arg(long, help_heading = "Printing")]
    pub all: bool,
    /// Print all settings with their defaults after a short answer.
    #[arg(long, conflicts_with = "all", help_heading = "Printing")]
    pub settings: bool,
}

impl DetailArguments {
    /// The text of an answer.
    pub fn text(self, answer: &impl Brief) -> String {
        match self.all {
            true => answer.to_string().trim_end().to_owned(),
            false => answer.brief().text(self.settings),
        }
    }
}

/// Acceptance tests of a particle code.
#[derive(Debug, Subcommand)]
pub enum VerifyTask {
    /// Write a deck: one predicted wave, seeded as velocities
    #[command(after_help = VERIFY_EXAMPLES, after_long_help = with_keys(VERIFY_EXAMPLES, &keys()))]
    Deck(Box<DeckArguments>),
    /// Run a deck where the code is installed, and read it
    Run {
        /// The folder of the deck.
        deck: PathBuf,
        /// The program that runs it [default: lmp, or python3 for PySPH].
        #[arg(long, value_name = "PATH")]
        program: Option<PathBuf>,
    },
    /// Read an output: does the measured rate agree with the predicted one?
    Read {
        /// The output, or the folder of the deck.
        output: PathBuf,
        /// The case of the deck [default: case.json beside the output].
        #[arg(long, value_name = "FILE")]
        case: Option<PathBuf>,
    },
    /// The codes with their dialects: their choices, and how they deviate from the papers
    Codes,
}

/// A deck.
#[derive(Debug, Args)]
pub struct DeckArguments {
    /// The code: lammps-smd-tlsph, lammps-smd-ulsph, lammps-peri, pysph, or plain for any other.
    #[arg(long, value_name = "NAME")]
    pub code: String,
    /// The problem. What the code has settled need not be set.
    #[command(flatten)]
    pub problem: ProblemArguments,
    /// Principal stretches along the axes [default: those of the study].
    #[arg(long, value_name = "L1,L2", allow_hyphen_values = true)]
    pub stretch: Option<String>,
    /// Reference wave vector, for example 3.141592654,0 (in units of 1/length).
    #[arg(long, value_name = "K1,K2", allow_hyphen_values = true)]
    pub wave_vector: String,
    /// Which of its waves, counted from 1 by increasing omega^2.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub branch: usize,
    /// Time step [default: what resolves the wave well].
    #[arg(long, value_name = "DT", value_parser = positive)]
    pub time_step: Option<f64>,
    /// Time steps [default: most of a period, or four e-foldings].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(32..=1_000_000))]
    pub steps: Option<u32>,
    /// The relative difference of rates that counts as agreement [default: what the code has been seen to keep].
    #[arg(long, value_name = "SHARE", value_parser = share, allow_negative_numbers = true)]
    pub tolerance: Option<f64>,
    /// How the code takes a time step, with --code plain: velocity-verlet, extrapolated-stress, late-density or late-acceleration
    /// [default: velocity-verlet].
    #[arg(long, value_name = "NAME", value_parser = stepping)]
    pub stepping: Option<Stepping>,
    /// Folder for the deck and its case.json.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

/// A simulation.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("length").args(["steps", "time"])))]
#[command(group(ArgGroup::new("size").args(["fraction", "time_step"])))]
pub struct SimulateArguments {
    /// The problem.
    #[command(flatten)]
    pub problem: ProblemArguments,
    /// The state; of a body its start.
    #[command(flatten)]
    pub strain: StrainArguments,
    /// Cells of the patch along each primitive vector: one number, or one for each [default: 8].
    #[arg(long, value_name = "N", help_heading = "Patch")]
    pub cells: Option<String>,
    /// What moves at the start: critical, the wave of the patch with the least omega^2, or noise, of which that wave is measured.
    /// [default: critical]
    #[arg(long, value_name = "MODE", value_parser = ["critical", "noise"], help_heading = "Patch")]
    pub mode: Option<String>,
    /// Seed this wave instead, by its reference wave vector (in units of 1/length); it must fit into the patch.
    #[arg(
        long,
        value_name = "K1,K2",
        allow_hyphen_values = true,
        conflicts_with = "mode",
        help_heading = "Patch"
    )]
    pub wave_vector: Option<String>,
    /// Seed this wave instead, by how many times it turns along each side of the patch.
    #[arg(
        long,
        value_name = "N1,N2",
        allow_hyphen_values = true,
        conflicts_with_all = ["mode", "wave_vector"],
        help_heading = "Patch"
    )]
    pub turns: Option<String>,
    /// Which of the waves with this wave vector, counted from 1 by increasing omega^2 [default: 1].
    #[arg(long, value_name = "N", help_heading = "Patch")]
    pub branch: Option<usize>,
    /// The largest displacement at the start, in particle spacings; of a body at random [default: 1e-6, of a body 0].
    #[arg(long, value_name = "A", value_parser = share, allow_negative_numbers = true, help_heading = "Patch")]
    pub amplitude: Option<f64>,
    /// The seed of the noise [default: 1].
    #[arg(long, value_name = "S", help_heading = "Patch")]
    pub seed: Option<u64>,
    /// Steps [default: about a period of the wave, four e-folding times of growth or one of decay; a body must be told].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..), help_heading = "Time")]
    pub steps: Option<u64>,
    /// Time, instead of steps.
    #[arg(long, value_name = "T", value_parser = positive, help_heading = "Time")]
    pub time: Option<f64>,
    /// The step over the largest stable one for the waves of the patch [default: 0.5, less for a wave that grows fast].
    #[arg(long, value_name = "SHARE", value_parser = positive, help_heading = "Time")]
    pub fraction: Option<f64>,
    /// The step itself, instead of that [default of a transfer of material points: discretization.time-step where that is set].
    #[arg(long, value_name = "DT", value_parser = positive, help_heading = "Time")]
    pub time_step: Option<f64>,
    /// Run a step above the largest stable one all the same.
    #[arg(long, help_heading = "Time")]
    pub supercritical: bool,
    /// kick-drift-kick (velocity-verlet), central-differences (leapfrog, symplectic-euler), predictor-corrector (midpoint), sixth-order, a
    /// composition of nine steps of the first, or an explicit Runge-Kutta method: forward-euler, heun, rk3, rk4, carpenter-kennedy, rdpk3-35, rdpk3-49 [default: kick-drift-kick; bodies have central-differences, transfers of material points a step of their own].
    #[arg(long, value_name = "NAME", value_parser = stepper, help_heading = "Time")]
    pub integrator: Option<Stepper>,
    /// The relative difference of rates that counts as agreement [default: 1e-6].
    #[arg(long, value_name = "SHARE", value_parser = share, allow_negative_numbers = true)]
    pub tolerance: Option<f64>,
    /// Folder for history.csv, fields and checkpoints; nothing is written without it.
    #[arg(long, value_name = "DIR", help_heading = "Files")]
    pub out: Option<PathBuf>,
    /// Steps between lines of the history [default: about 400 lines].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..), help_heading = "Files")]
    pub every: Option<u64>,
    /// How many fields are written (field-0000.vtu, ... and fields.pvd), from the start to the end [default: 11].
    #[arg(long, requires = "out", value_name = "N", value_parser = clap::value_parser!(u64).range(0..=10_000), help_heading = "Files")]
    pub fields: Option<u64>,
    /// Steps between checkpoints [default: every five seconds].
    #[arg(long, requires = "out", value_name = "N", value_parser = clap::value_parser!(u64).range(1..), help_heading = "Files")]
    pub checkpoint: Option<u64>,
    /// Go on from the checkpoint in the folder, begin where there is none; the files become those of a run that never ended.
    #[arg(
        long,
        requires = "out",
        conflicts_with = "overwrite",
        help_heading = "Files"
    )]
    pub resume: bool,
    /// Begin anew where there is a checkpoint.
    #[arg(long, requires = "out", help_heading = "Files")]
    pub overwrite: bool,
}

fn stepper(text: &str) -> Result<Stepper, String> {
    Stepper::named(text).ok_or_else(|| expected(text, "available are", &Stepper::names()))
}

/// A time as typed, or a share of one.
fn positive(text: &str) -> Result<f64, String> {
    let number = text.trim().parse::<f64>().ok();
    number
        .filter(|number| Positive.holds(*number, "time"))
        .ok_or_else(|| format!("expected {}, for example 0.05", Positive.expected("time")))
}

fn stepping(text: &str) -> Result<Stepping, String> {
    let known = Stepping::ALL.into_iter().find(|own| own.name() == text);
    known.ok_or_else(|| expected(text, "available are", &Stepping::ALL.map(Stepping::name)))
}

/// What to draw of which stores.
#[derive(Debug, Args)]
pub struct PlotArguments {
    /// Stores that `onset map` has written.
    #[arg(value_name = "STORE", required = true)]
    pub stores: Vec<PathBuf>,
    /// What to show: verdict, or a field of numbers such as scaled_minimum, growth_rate, acoustic_minimum,
    /// critical_time_step or lowest_omega_squared; of a certified map also certainty and certainty_material.
    #[arg(long, value_name = "FIELD", default_value = "verdict")]
    pub field: String,
    /// Trace the boundaries however long it takes, with gaps where they cannot be followed [default: for ten seconds, and only where no
    /// axis varies material or method and they are found without gaps].
    #[arg(long, conflicts_with = "no_trace")]
    pub trace: bool,
    /// Do not trace the boundaries; take them from the cells of the map.
    #[arg(long)]
    pub no_trace: bool,
    /// Title of the figure [default: that of the study].
    #[arg(long, value_name = "TEXT", help_heading = "Look")]
    pub title: Option<String>,
    /// Width and height of a panel in pixels, of which an inch has 96; with stretches on both axes the largest, for example 420,315.
    #[arg(long, value_name = "W,H", value_parser = size, help_heading = "Look")]
    pub size: Option<(f64, f64)>,
    /// Limits of the horizontal axis.
    #[arg(long, value_name = "LOW,HIGH", value_parser = limits, allow_hyphen_values = true, help_heading = "Look")]
    pub x_limits: Option<(f64, f64)>,
    /// Limits of the vertical axis.
    #[arg(long, value_name = "LOW,HIGH", value_parser = limits, allow_hyphen_values = true, help_heading = "Look")]
    pub y_limits: Option<(f64, f64)>,
    /// Numbers at the ends of the color bar of a field; those beyond take the end colors [default: those that all but 1 % lie between].
    #[arg(long, value_name = "LOW,HIGH", value_parser = limits, allow_hyphen_values = true, help_heading = "Look")]
    pub limits: Option<(f64, f64)>,
    /// Colors of a field: viridis, cividis, grey, or red-blue with white at zero [default: red-blue where there are negative numbers,
    /// otherwise viridis].
    #[arg(long, value_name = "NAME", value_parser = color_map, help_heading = "Look")]
    pub color_map: Option<ColorMap>,
    /// Where to write: NAME.svg or NAME.png (both are written), NAME.pdf (all three), or a folder for map.svg and map.png.
    #[arg(long, value_name = "PATH", default_value = ".")]
    pub out: PathBuf,
    /// What the stores may load.
    #[command(flatten)]
    pub trust: TrustArguments,
}

/// Two finite numbers, the first below the second.
fn limits(text: &str) -> Result<(f64, f64), String> {
    match two(text) {
        Some((low, high)) if low < high => Ok((low, high)),
        _ => Err("expected two numbers LOW,HIGH with LOW below HIGH, for example 0.5,2".to_owned()),
    }
}

/// Two numbers of pixels.
fn size(text: &str) -> Result<(f64, f64), String> {
    let is_drawable = |pixels: f64| (40.0..=4000.0).contains(&pixels);
    match two(text) {
        Some((width, height)) if is_drawable(width) && is_drawable(height) => Ok((width, height)),
        _ => Err(
            "expected width and height in pixels from 40 to 4000, for example 420,315".to_owned(),
        ),
    }
}

fn two(text: &str) -> Option<(f64, f64)> {
    let (first, second) = text.split_once(',')?;
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    Some((number(first)?, number(second)?))
}

fn color_map(text: &str) -> Result<ColorMap, String> {
    let known = ColorMap::ALL.into_iter().find(|map| map.name() == text);
    known.ok_or_else(|| expected(text, "available are", &ColorMap::ALL.map(ColorMap::name)))
}

/// What files may load.
#[derive(Clone, Debug, Args)]
pub struct TrustArguments {
    /// Let a file load this library (material.library), or one in this folder: a library is a program, which runs with your rights. The
    /// variable ONSET_ALLOW_LIBRARY does so for good. (May be given several times.)
    #[arg(long = "allow-library", value_name = "PATH")]
    pub libraries: Vec<PathBuf>,
}

/// The page.
#[cfg(feature = "explore")]
#[derive(Debug, Args)]
pub struct ExploreArguments {
    /// What is shown first; the FILE can also be a stored map, or an address that a page of another run has given.
    #[command(flatten)]
    pub problem: ProblemArguments,
    /// Port on the loopback address [default: a new one each time].
    #[arg(long, value_name = "PORT")]
    pub port: Option<u16>,
    /// Print the address, and start no browser.
    #[arg(long)]
    pub no_browser: bool,
}

/// A law, and the stretches of interest.
#[derive(Debug, Args)]
pub struct LawArguments {
    /// The law.
    #[command(flatten)]
    pub problem: ProblemArguments,
    /// The smallest and the largest stretch.
    #[arg(long, value_name = "A,B", default_value = "0.1,10", value_parser = stretches)]
    pub range: Stretches,
    /// Ask the incompressible response of an isotropic law: J = 1, the pressure follows from a free face, the volumetric part does not count.
    #[arg(long)]
    pub incompressible: bool,
    /// Only loadings of this mode: uniaxial, equibiaxial, planar, simple-shear or hydrostatic (may be given several times).
    #[arg(long = "mode", value_name = "MODE", value_parser = mode)]
    pub modes: Vec<Mode>,
}

/// Stability criteria.
#[derive(Debug, Args)]
pub struct CriteriaArguments {
    /// The law.
    #[command(flatten)]
    pub law: LawArguments,
    /// Folder for criteria.svg and criteria.png; no figure when left out.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// How much is printed.
    #[command(flatten)]
    pub detail: DetailArguments,
}

/// A card.
#[derive(Debug, Args)]
pub struct CardArguments {
    /// The law.
    #[command(flatten)]
    pub law: LawArguments,
    /// Folder for card.html, card.json, card.svg and card.png; nothing is written without it.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// A comparison.
#[derive(Debug, Args)]
pub struct CompareArguments {
    /// The comparison: a material and `[[methods]]`; or a study, whose method is compared with those that the program knows;
    /// - for standard input.
    pub file: PathBuf,
    /// Folder for compare.html, compare.csv, compare.svg and compare.png; nothing is written without it.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Set a key of what all methods have in common, for example material.model=blatz-ko (may be given several times).
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub assignments: Vec<String>,
    /// That FILE is a block.
    #[command(flatten)]
    pub block: BlockArguments,
    /// What the file may load.
    #[command(flatten)]
    pub trust: TrustArguments,
    /// How much is printed.
    #[command(flatten)]
    pub detail: DetailArguments,
}

/// A question for spurious modes.
#[derive(Debug, Args)]
pub struct ModesArguments {
    /// The problem.
    #[command(flatten)]
    pub problem: ProblemArguments,
    /// Limit of weakly controlled waves.
    #[command(flatten)]
    pub weak: WeakArgument,
    /// Cells of the patch that is drawn and exported, along each primitive vector.
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u16).range(1..=512))]
    pub cells: u16,
    /// Largest displacement of the exported fields, in particle spacings.
    #[arg(long, value_name = "A", default_value_t = 0.2, value_parser = share, allow_negative_numbers = true)]
    pub amplitude: f64,
    /// Folder for modes.svg, modes.png, modes.html (moving), and mode-1.csv, mode-1.vtk, ...; nothing is written without it.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// A coefficient to tune.
#[derive(Debug, Args)]
pub struct TuneArguments {
    /// The coefficient, a key that takes a number, for example discretization.stress-point-weight.
    pub key: String,
    /// The problem.
    #[command(flatten)]
    pub problem: ProblemArguments,
    /// Smallest and largest value that is looked at.
    #[arg(long, value_name = "LOW,HIGH", default_value = "0,1", value_parser = interval, allow_hyphen_values = true)]
    pub range: (f64, f64),
    /// Smallest and largest stretch of the states on which verdicts are compared.
    #[arg(long, value_name = "LOW,HIGH", default_value = "0.7,1.5", value_parser = window, allow_hyphen_values = true)]
    pub stretches: (f64, f64),
    /// Limits of what counts as sufficient.
    #[command(flatten)]
    pub thresholds: ThresholdArguments,
    /// The instability is masked where the method's onset comes later than the material's by more than this share of its strain.
    #[arg(long, value_name = "SHARE", default_value_t = Thresholds::default().later, value_parser = share, help_heading = "Limits")]
    pub later: f64,
    /// Folder for tune.csv, tune.svg and tune.png; nothing is written without it.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// How much is printed.
    #[command(flatten)]
    pub detail: DetailArguments,
}

/// A setting that a time step limits.
#[derive(Debug, Args)]
pub struct LimitArguments {
    /// The time step that must be stable, with a unit where the settings have units, for example 0.01 or "1 us".
    #[arg(long, value_name = "DT", allow_hyphen_values = true)]
    pub time_step: String,
    /// The setting, a key that takes a number, for example material.young or discretization.spacing.
    #[arg(long, value_name = "KEY")]
    pub vary: String,
    /// The problem.
    #[command(flatten)]
    pub problem: ProblemArguments,
    /// The state [default: F = 1].
    #[command(flatten)]
    pub strain: StrainArguments,
    /// Smallest and largest value that is looked at, in SI where the settings have units [default: 1e-6 to 1e6 times the present value, within the range of the key].
    #[arg(long, value_name = "LOW,HIGH", value_parser = interval, allow_hyphen_values = true)]
    pub range: Option<(f64, f64)>,
    /// The share of the critical step that the step may be.
    #[arg(long, value_name = "SHARE", default_value_t = 1.0, value_parser = share)]
    pub safety: f64,
    /// Integrator: central-differences (leapfrog, symplectic-euler), kick-drift-kick (velocity-verlet), predictor-corrector, forward-euler,
    /// heun, rk3, rk4, carpenter-kennedy, rdpk3-35 or rdpk3-49 (RDPK3SpFSAL35 and 49). The first three differ with damping only.
    #[arg(long, value_name = "NAME", default_value = Integrator::KickDriftKick.name(), value_parser = integrator)]
    pub integrator: Integrator,
    /// Folder for limit.csv, limit.svg and limit.png; nothing is written without it.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// An integrator as typed.
fn integrator(text: &str) -> Result<Integrator, String> {
    Integrator::named(text).ok_or_else(|| expected(text, "available are", &Integrator::NAMES))
}

/// A share as typed.
fn share(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(number) if number > 0.0 && number <= 1.0 => Ok(number),
        _ => Err("expected a number above 0 and at most 1, for example 0.5".to_owned()),
    }
}

/// A wavelength as typed.
fn wavelength(text: &str) -> Result<f64, String> {
    let number = text.trim().parse::<f64>().ok();
    number
        .filter(|number| onset_study::compare::WAVELENGTHS.contains(number))
        .ok_or_else(|| "expected 4, 8 or 16".to_owned())
}

/// An interval as typed.
fn interval(text: &str) -> Result<(f64, f64), String> {
    let ends = text.split_once(',').and_then(|(low, high)| {
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
        Some((number(low)?, number(high)?))
    });
    ends.filter(|(low, high)| low < high)
        .ok_or_else(|| "expected two numbers, the smaller one first, for example 0,1".to_owned())
}

/// A window of stretches as typed.
fn window(text: &str) -> Result<(f64, f64), String> {
    interval(text)
        .ok()
        .filter(|(low, _)| *low > 0.0)
        .ok_or_else(|| {
            "expected two positive stretches, the smaller one first, for example 0.7,1.5".to_owned()
        })
}

/// A question for a method.
#[derive(Debug, Args)]
pub struct RecommendArguments {
    /// The available methods, as for `compare` [default: those that the program knows for the dimension].
    pub file: Option<PathBuf>,
    /// Number of space dimensions, where no study says it [default: 2].
    #[arg(long, value_name = "D", value_parser = clap::value_parser!(u8).range(1..=3))]
    pub dimension: Option<u8>,
    /// Smallest and largest stretch that the simulation will see, for example 0.8,1.6; short for compare.stretches.
    #[arg(long, value_name = "LOW,HIGH", value_parser = window, allow_hyphen_values = true)]
    pub stretches: Option<(f64, f64)>,
    /// Limits in the rules.
    #[command(flatten)]
    pub thresholds: ThresholdArguments,
    /// Long waves may feel a stiffness that is wrong by this share.
    #[arg(long, value_name = "SHARE", default_value_t = Thresholds::default().long_waves, value_parser = share, help_heading = "Limits")]
    pub long_waves: f64,
    /// Wavelength at which frequencies are compared, in particle spacings: 4, 8 or 16.
    #[arg(long, value_name = "N", default_value_t = Thresholds::default().wavelength, value_parser = wavelength, help_heading = "Limits")]
    pub wavelength: f64,
    /// The energy of a user-defined material; short for material.model=formula and material.energy.
    #[arg(long, value_name = "FORMULA", allow_hyphen_values = true)]
    pub energy: Option<String>,
    /// Folder for the whole comparison as compare.html, compare.csv, compare.svg and compare.png; nothing is written without it.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Set a key of what all methods have in common, for example material.model=blatz-ko (may be given several times).
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub assignments: Vec<String>,
    /// That FILE is a block.
    #[command(flatten)]
    pub block: BlockArguments,
    /// What the file may load.
    #[command(flatten)]
    pub trust: TrustArguments,
    /// How much is printed.
    #[command(flatten)]
    pub detail: DetailArguments,
}

/// A map.
#[derive(Debug, Args)]
pub struct MapArguments {
    /// The study, - for standard input.
    pub file: PathBuf,
    /// Folder of the store [default: the name of the study file, with .zarr, in the current folder].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Compute these tiles only: A to B - 1, or share M of N, whose tiles lie evenly among all. Tiles that are done are kept. Processes that run at
    /// the same time need no parts: see --resume.
    #[arg(long, value_name = "A..B | M/N", value_parser = Part::from_str)]
    pub tiles: Option<Part>,
    /// Resume a store of the same study; create it where there is none. Several processes with this option share the work on one store.
    #[arg(long)]
    pub resume: bool,
    /// Verdicts with which the command fails.
    #[command(flatten)]
    pub failing: FailingArguments,
    /// Replace a store of onset, whatever it holds.
    #[arg(long, conflicts_with_all = ["resume", "tiles"])]
    pub overwrite: bool,
    /// Set a key of the study, for example discretization.support=1.6 or map.adaptive=true (may be given several times).
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub assignments: Vec<String>,
    /// That FILE is a block.
    #[command(flatten)]
    pub block: RefusedBlockArguments,
    /// What the file may load.
    #[command(flatten)]
    pub trust: TrustArguments,
}

/// A plastic material and its loading.
#[derive(Debug, Args)]
pub struct LocalizeArguments {
    /// The law: drucker-prager, j2, mohr-coulomb, hill-1948, kinematic, gurson, cam-clay, cap, damage, deformation-theory or umat (with a
    /// material's keys library, properties, state-variables); short for --set plasticity.model=MODEL.
    #[arg(long, value_name = "MODEL")]
    pub model: Option<String>,
    /// uniaxial-stress, uniaxial-strain, plane-strain, pure-shear, triaxial-compression or sheet-stretch; short for
    /// --set plasticity.path=PATH.
    #[arg(long, value_name = "PATH")]
    pub path: Option<String>,
    /// tension or compression; short for --set plasticity.load=LOAD.
    #[arg(long, value_name = "LOAD")]
    pub load: Option<String>,
    /// Set a parameter, for example plasticity.friction=0.7, or material.library=./my_umat.so with --model umat (may be given several times).
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub assignments: Vec<String>,
    /// Folder for localize.svg, localize.png, localize.csv and localize-directions.csv; nothing is written without it.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// A range of stretches as typed.
fn stretches(text: &str) -> Result<Stretches, String> {
    let numbers = text.split_once(',').and_then(|(low, high)| {
        let number = |text: &str| text.trim().parse::<f64>().ok();
        Some((number(low)?, number(high)?))
    });
    match numbers {
        Some((low, high)) => Stretches::new(low, high).map_err(|error| error.to_string()),
        None => Err("expected two numbers around 1, for example 0.1,10".to_owned()),
    }
}

/// What is said of a word that is none of those that there are.
fn expected(typed: &str, what: &str, names: &[&str]) -> String {
    let meant = did_you_mean(typed, names.iter().copied());
    format!("{what} {}{meant}", names.join(", "))
}

/// A mode of loading as typed.
fn mode(text: &str) -> Result<Mode, String> {
    let named = Mode::ALL.into_iter().find(|mode| mode.name() == text);
    named.ok_or_else(|| expected(text, "expected one of", &Mode::ALL.map(Mode::name)))
}

/// An audit.
#[derive(Debug, Args)]
pub struct AuditArguments {
    /// The material.
    #[command(flatten)]
    pub problem: ProblemArguments,
    /// How large the strains of the states are, unless states are given.
    #[arg(
        long,
        value_name = "E",
        default_value_t = 0.1,
        value_parser = strain,
        conflicts_with_all = ["stretch", "deformation_gradient"],
        help_heading = "States"
    )]
    pub strain: f64,
    /// Two or three principal stretches along the axes, for example 1.2,0.9 (may be given several times).
    #[arg(
        long,
        value_name = "L1,L2",
        allow_hyphen_values = true,
        help_heading = "States"
    )]
    pub stretch: Vec<String>,
    /// Deformation gradient F11,F12,F21,F22 or all nine components (may be given several times).
    #[arg(
        long,
        value_name = "F11,F12,F21,F22",
        allow_hyphen_values = true,
        help_heading = "States"
    )]
    pub deformation_gradient: Vec<String>,
    /// The tangent of a law of onset's own, taken as if delivered in this convention [default: first-piola]; a UMAT's is
    /// jaumann-kirchhoff.
    #[arg(long = "as", value_name = "CONVENTION", value_parser = convention)]
    pub convention: Option<Convention>,
    /// End with exit code 1 when a check fails.
    #[arg(long)]
    pub strict: bool,
}

/// What holds the other directions, as typed.
fn lateral(text: &str) -> Result<Lateral, String> {
    let all = [
        Lateral::Free,
        Lateral::PlaneStress,
        Lateral::PlaneStrain,
        Lateral::Held,
    ];
    let named = all.into_iter().find(|lateral| lateral.name() == text);
    named.ok_or_else(|| expected(text, "expected one of", &all.map(Lateral::name)))
}

/// A convention as typed.
fn convention(text: &str) -> Result<Convention, String> {
    Convention::of_name(text).ok_or_else(|| {
        expected(
            text,
            "expected one of",
            &Convention::ALL.map(Convention::name),
        )
    })
}

/// The size of strains as typed.
fn strain(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(number) if number > 0.0 && number <= 0.8 => Ok(number),
        _ => Err("expected a number above 0 and at most 0.8, for example 0.05".to_owned()),
    }
}

/// A tolerance as typed.
fn tolerance(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(number) if number > 0.0 && number < 1.0 => Ok(number),
        _ => Err("expected a number above 0 and below 1, for example 1e-3".to_owned()),
    }
}

/// Material and discretization.
#[derive(Debug, Args)]
pub struct ProblemArguments {
    /// What is set.
    #[command(flatten)]
    pub given: GivenArguments,
    /// That FILE is a block.
    #[command(flatten)]
    pub block: BlockArguments,
}

/// A study, and what is set beside it.
#[derive(Debug, Args)]
pub struct GivenArguments {
    /// A study file whose material and discretization are meant, - for standard input [default: those of --set alone].
    pub file: Option<PathBuf>,
    /// Set a key, for example material.model=blatz-ko (may be given several times).
    #[arg(long = "set", value_name = "KEY=VALUE", help_heading = "Problem")]
    pub assignments: Vec<String>,
    /// The energy of a user-defined material, for example "mu/2*(I1 - 3 - 2*ln(J))"; its parameters are set by
    /// --set material.mu=1. Short for material.model=formula and material.energy.
    #[arg(
        long,
        value_name = "FORMULA",
        allow_hyphen_values = true,
        help_heading = "Problem"
    )]
    pub energy: Option<String>,
    /// What the file may load.
    #[command(flatten)]
    pub trust: TrustArguments,
}

/// A block of another program in the place of a study.
#[derive(Clone, Debug, Default, Args)]
pub struct BlockArguments {
    /// FILE is a block of another program, abaqus (*HYPERELASTIC ...), ansys (TB,HYPER ...), felupe (fem.Hyperelastic(fem.ogden, mu=...))
    /// or hyperelastic (ThirdOrderDeformation(C10=...)), whose constants are read with the meaning that they have there.
    #[arg(
        long,
        value_name = "PROGRAM",
        requires = "file",
        help_heading = "Problem"
    )]
    pub from: Option<Program>,
    /// The material of FILE, by its name in Abaqus, its number in ANSYS [default: the first one with a law].
    #[arg(long, value_name = "NAME", requires = "from", help_heading = "Problem")]
    pub material: Option<String>,
}

/// A block of another program where the axes of a study are needed: refused, with the reason.
#[derive(Clone, Copy, Debug, Args)]
pub struct RefusedBlockArguments {
    /// FILE is a block of another program.
    #[arg(long, value_name = "PROGRAM", hide = true)]
    pub from: Option<Program>,
}

/// The state. That one is given is told by who needs it: a body may start at rest.
#[derive(Debug, Args)]
#[group(required = false, multiple = false)]
pub struct StrainArguments {
    /// Principal stretches along the axes, for example 1.2,0.9 (a third one is the stretch out of plane).
    #[arg(
        long,
        value_name = "L1,L2",
        allow_hyphen_values = true,
        help_heading = "State"
    )]
    pub stretch: Option<String>,
    /// Deformation gradient F11,F12,F21,F22 (or all nine components).
    #[arg(
        long,
        value_name = "F11,F12,F21,F22",
        allow_hyphen_values = true,
        help_heading = "State"
    )]
    pub deformation_gradient: Option<String>,
}
