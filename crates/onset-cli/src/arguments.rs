//! The arguments of the command line.

use crate::drawing::{DrawingArguments, LookArguments};
use crate::fail_on::FailOn;
use crate::printing::PrintingArguments;
use clap::{ArgGroup, Args, Parser, Subcommand};
use clap_complete::Shell;
use onset_study::audit::Convention;
use onset_study::brief::Brief;
use onset_study::compare::Thresholds;
use onset_study::criteria::{Criterion, Lateral, Mode, Range as Stretches, criterion_named};
use onset_study::figure::ColorMap;
use onset_study::localization::PARAMETERS;
use onset_study::map::Part;
use onset_study::screen::{
    BIN, Cause, FrameRange, Held, Reference, Region, THRESHOLD, stepping_named,
};
use onset_study::settings::Admitted::Positive;
use onset_study::settings::Program;
use onset_study::settings::{BODY_KEYS, COMPARISON_KEYS, GRIP_KEYS, KEYS, Key, did_you_mean};
use onset_study::simulate::Stepper;
use onset_study::verify::Stepping;
use std::path::PathBuf;
use std::str::FromStr;

/// Help entry of a key: its meaning with the default, and the expected values.
fn line(key: &Key) -> String {
    let default = match key.default_value().as_str() {
        "" => String::new(),
        default => format!(" [default: {default}]"),
    };
    let meaning = format!("{}{default}", key.meaning);
    entry(key.name, &meaning, &key.expects())
}

/// First column of the text of an entry, and its last column.
const INDENT: usize = 34;
const WIDTH: usize = 100;

/// Help entry: the name, then its meaning, then the expected values, each on separate lines.
fn entry(name: &str, meaning: &str, expects: &str) -> String {
    let mut text = format!("  {name:<31}");
    for (n, part) in [meaning, expects].into_iter().enumerate() {
        // The name replaces the first indent; a long name extends beyond it.
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
        "Keys of --set:\n{}  {:<31} a parameter of the law, one of {}\n{:34}`onset list materials` lists the parameters of each law; or two of\n\
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
        "{}{own}\n`onset list method NAME` lists the keys of a method. If one value has a unit, all values with dimensions need one: \
         material.mu=80GPa, discretization.spacing=1mm, discretization.density=7850kg/m^3. Common names such as tlsph, \
         fem or fcc are accepted: `onset list aliases`.\n",
        law_keys()
    )
}

/// Examples followed by the keys, for the long help.
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
  onset criteria --range 0.2,5 --criterion hill,load-maximum --out figures";
const CARD_EXAMPLES: &str = "Examples:
  onset card --energy \"mu/2*(I1 - 3 - 2*ln(J))\" --set material.mu=1 --out card
  onset card --set material.model=ogden --incompressible --mode uniaxial
  onset card rubber.inp --incompressible";
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
  onset limit --keeps stable --stretches 0.8,1.3 --vary discretization.penalty --range 0,2 --set discretization.method=tlsph";
const COMPARE_EXAMPLES: &str = "Examples:
  onset compare comparisons/methods-2d.toml --out results
  onset compare --set discretization.method=tlsph --vary discretization.penalty=0,0.1,0.5,1
  onset compare STUDY.toml --set compare.states=24 --format csv";
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
const SCREEN_EXAMPLES: &str = "Examples:
  onset screen run.dump.gz STUDY.toml --time-step 0.05 --check
  onset screen run.dump.gz STUDY.toml --time-step 0.05 --stepping extrapolated-stress --out screened
  onset screen 'plate_*.vtp' --set discretization.method=tlsph --columns F=DefGrad --fail-on numerical,time-step";
const FIT_EXAMPLES: &str = "Examples:
  onset fit rubber/treloar-*.csv --law ogden-3,yeoh
  onset fit --uniaxial pull.csv --planar shear.csv --law polynomial-2 --stable box=0.3,4 --out fitted
  onset fit rubber.inp --law all --weights absolute --bulk 2000";
const SIMULATE_EXAMPLES: &str = "Examples:
  onset simulate --stretch 1.3,1 --set discretization.method=updated-sph --mode critical
  onset simulate STUDY.toml --stretch 1.2,0.9 --cells 16 --mode noise --steps 20000 --out run --resume
  onset simulate studies/bodies/notched-plate.toml --time 60 --amplitude 0.01 --out plate

Exit codes: 0 agrees (or the run of a body is complete), 1 differs or the motion breaks down, 3 undecided, 2 the input is wrong, 130 interrupted.";
const ZOO_EXAMPLES: &str = "Examples:
  onset zoo
  onset zoo trixi-371-cubic
  onset zoo trixi-371-cubic --out beam.toml";
const AUDIT_EXAMPLES: &str = "Examples:
  onset audit --set material.model=ogden
  onset audit --set material.model=umat --set material.library=./my_umat.so --strict
  onset audit --energy \"mu/2*(I1 - 3 - 2*ln(J))\" --set material.mu=1 --strain 0.3";
const LOCALIZE_EXAMPLES: &str = "Examples:
  onset localize --model drucker-prager --path plane-strain
  onset localize --model mohr-coulomb --set material.confinement=50 --out band
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
        "Keys of [compare] and --set, in addition to the keys of [material] and [discretization]:\n{}\
         A method in [[methods]] has a name and keys of [discretization].\n",
        COMPARISON_KEYS.iter().map(line).collect::<String>()
    )
}

/// The keys of bodies and grips, from the one table that defines them.
fn body_keys() -> String {
    let of = |keys: &[Key]| keys.iter().map(line).collect::<String>();
    format!(
        "\nKeys of [body] in a study:\n{}\nKeys of each [[grips]]:\n{}",
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
                format!("; only with {needed} = {}", words.join(" or "))
            });
        entry(
            name,
            &format!("{meaning} [default: {default}]"),
            &format!("{}{condition}", parameter.kind.expects()),
        )
    };
    format!(
        "Keys of --set: the parameters of the law (`onset list materials`), and\n{}\nIf one stress has a unit, all stresses need one: material.mu=80GPa, material.yield-stress=300MPa.\n",
        PARAMETERS.iter().map(line).collect::<String>()
    )
}

/// Finds where materials and particle methods are stable, and whether instabilities are numerical
#[derive(Debug, Parser)]
#[command(
    name = "onset",
    version,
    propagate_version = true,
    arg_required_else_help = true
)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Command,
    /// Format and amount of the output.
    #[command(flatten)]
    pub printing: PrintingArguments,
}

/// Commands of the program `onset`.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Classify one state: stable, or unstable for a physical or a numerical reason
    #[command(after_help = STATE_EXAMPLES, after_long_help = with_keys(STATE_EXAMPLES, &keys()))]
    State {
        /// Material and discretization of the problem.
        #[command(flatten)]
        problem: ProblemArguments,
        /// Homogeneous state of deformation.
        #[command(flatten)]
        strain: StrainArguments,
        /// Prove stability or instability, with a bound or a witness.
        #[arg(long, help_heading = "Proof")]
        certify: bool,
        /// Smallest measure of an undecided state that counts as different from zero.
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
        /// Largest relative frequency of weakly controlled waves.
        #[command(flatten)]
        weak: WeakArgument,
        /// Length of the printed answer.
        #[command(flatten)]
        detail: DetailArguments,
        /// Verdicts that end the command with exit code 3.
        #[command(flatten)]
        failing: FailingArguments,
        /// Show the state on the page of `onset explore` instead of printing it.
        #[cfg(feature = "explore")]
        #[arg(long, conflicts_with_all = ["certify", "fail_on", "deformation_gradient"])]
        open: bool,
    },
    /// Explore the map of a method, and any state on it, in the browser
    ///
    /// Sliders and lists select the material and the method. For the state that is clicked, the page shows the verdict in a sentence, the stresses,
    /// the acoustic tensor, the dispersion and the moving mode. The page is served on this machine only and contacts no other server.
    #[cfg(feature = "explore")]
    #[command(after_help = EXPLORE_EXAMPLES)]
    Explore(ExploreArguments),
    /// Compute frequencies of plane waves for one wave vector or along a path
    ///
    /// Without a state the reference configuration is used.
    #[command(group(ArgGroup::new("waves").required(true).args(["wave_vector", "path"])))]
    #[command(after_help = DISPERSION_EXAMPLES, after_long_help = with_keys(DISPERSION_EXAMPLES, &keys()))]
    Dispersion {
        /// Material and discretization of the problem.
        #[command(flatten)]
        problem: ProblemArguments,
        /// Homogeneous state of deformation.
        #[command(flatten)]
        strain: StrainArguments,
        /// Reference wave vector, for example 2.0,1.1 (in units of 1/length).
        #[arg(long, value_name = "K1,K2", allow_hyphen_values = true)]
        wave_vector: Option<String>,
        /// Draw a dispersion diagram. Its path connects the inequivalent points of high symmetry, or the given points: names (G-M-K-G), or
        /// coordinates in units of the reciprocal vectors ("0,0; 0.5,0; K"). The line through the critical wave vector k* is added.
        #[arg(
            long,
            value_name = "POINTS",
            num_args = 0..=1
        )]
        path: Option<Option<String>>,
        /// Folder for the figure (dispersion.svg, .png, .pdf), dispersion.csv and density-of-states.csv, or NAME.svg, NAME.png or NAME.pdf for the figure
        /// alone; nothing is written without it.
        #[arg(long, value_name = "DIR", conflicts_with = "wave_vector")]
        out: Option<PathBuf>,
        /// Limit of the waves that the diagram marks as weakly controlled.
        #[command(flatten)]
        weak: WeakArgument,
        /// Options of the figure.
        #[command(flatten)]
        drawing: DrawingArguments,
    },
    /// Find where stability is lost along a path of deformations or a loading
    #[command(after_help = PATH_EXAMPLES, after_long_help = with_keys(PATH_EXAMPLES, &keys()))]
    Path {
        /// Material and discretization of the problem.
        #[command(flatten)]
        given: GivenArguments,
        /// Path of deformations or loading.
        #[command(flatten)]
        course: CourseArguments,
        /// Folder for path.csv and the figure (path.svg, .png, .pdf), softest mode and smallest acoustic eigenvalue along the path, or NAME.svg, NAME.png or
        /// NAME.pdf for the figure alone; nothing is written without it.
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
        /// Options of the figure.
        #[command(flatten)]
        drawing: DrawingArguments,
        /// Verdicts that end the command with exit code 3.
        #[command(flatten)]
        failing: FailingArguments,
        /// Length of the printed answer.
        #[command(flatten)]
        detail: DetailArguments,
    },
    /// Find where a plastic material localizes, with the band and its angle
    #[command(after_help = LOCALIZE_EXAMPLES, after_long_help = with_keys(LOCALIZE_EXAMPLES, &plastic_parameters()))]
    Localize(LocalizeArguments),
    /// Compute the verdicts on all states of a study into a Zarr store; resumable
    #[command(after_help = MAP_EXAMPLES)]
    Map(MapArguments),
    /// Find where each stability criterion is violated along standard loadings
    ///
    /// The criteria are ellipticity, Hill, Drucker, Baker-Ericksen, the largest load and others. The stretches of traction-free faces are solved for.
    #[command(after_help = CRITERIA_EXAMPLES, after_long_help = with_keys(CRITERIA_EXAMPLES, &law_keys()))]
    Criteria(CriteriaArguments),
    /// Compute the safe range of a law: the stretches at which it is strongly elliptic
    #[command(after_help = CARD_EXAMPLES, after_long_help = with_keys(CARD_EXAMPLES, &law_keys()))]
    Card(CardArguments),
    /// List the available options with formulas, parameters and sources
    List {
        /// Topic: materials, planes, moduli, loadings, methods, lattices, kernels, approximations, quadratures, frames, backgrounds, current-lattices,
        /// support-sizes, linearizations, criteria (of stability), formula (the language of typed laws), aliases (common names), keys, or method with a NAME
        /// [default: all topics].
        topic: Option<String>,
        /// For the topic method: the method whose keys are listed, for example total-lagrangian-sph.
        #[arg(requires = "topic")]
        name: Option<String>,
        /// Folder for the figure of all kernels (kernels.svg, .png, .pdf), or NAME.svg, NAME.png or NAME.pdf; for the topic kernels only.
        #[arg(long, value_name = "PATH", requires = "topic")]
        out: Option<PathBuf>,
        /// Options of the figure.
        #[command(flatten)]
        drawing: DrawingArguments,
    },
    /// Check that study files are valid, and estimate their cost
    #[command(after_help = CHECK_EXAMPLES)]
    Check {
        /// Study files, or decks of other programs with a law; - for standard input.
        #[arg(id = "file", value_name = "FILE", required = true)]
        files: Vec<PathBuf>,
        /// Set a key of the study, overriding the file, for example map.tile=128 (may be given several times).
        #[arg(long = "set", value_name = "KEY=VALUE")]
        assignments: Vec<String>,
        /// Deck of another program in FILE.
        #[command(flatten)]
        block: BlockArguments,
        /// Libraries that the file may load.
        #[command(flatten)]
        trust: TrustArguments,
    },
    /// Trace the stability boundaries of material and particles in the plane of a study
    ///
    /// Also computes the distance between the two boundaries, and the areas of false and suppressed instability.
    #[command(after_help = BOUNDARY_EXAMPLES)]
    Boundary {
        /// A study file with two axes, - for standard input.
        file: PathBuf,
        /// Set a key of the study, overriding the file, for example discretization.support=1.6 (may be given several times).
        #[arg(long = "set", value_name = "KEY=VALUE")]
        assignments: Vec<String>,
        /// Trace the boundary between flutter and divergence, too.
        #[arg(long)]
        flutter: bool,
        /// Folder for boundary.geojson and boundary.csv; nothing is written without it.
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
        /// Deck of another program in FILE.
        #[command(flatten)]
        block: RefusedBlockArguments,
        /// Libraries that the file may load.
        #[command(flatten)]
        trust: TrustArguments,
    },
    /// Compare several methods for one material
    ///
    /// Lists the spurious modes, errors of frequencies, onsets of instability, fidelity, time step and cost of each method.
    #[command(after_help = COMPARE_EXAMPLES, after_long_help = with_keys(COMPARE_EXAMPLES, &comparison_keys()))]
    Compare(CompareArguments),
    /// Recommend a method for a material and a range of stretches
    ///
    /// Ranks the methods by rules, which are printed, and shows how other limits in the rules would change the ranking.
    #[command(after_help = RECOMMEND_EXAMPLES, after_long_help = with_keys(RECOMMEND_EXAMPLES, &comparison_keys()))]
    Recommend(RecommendArguments),
    /// Find zero-energy and weakly controlled modes of a method; draw, animate and export them
    #[command(after_help = MODES_EXAMPLES, after_long_help = with_keys(MODES_EXAMPLES, &keys()))]
    Modes(ModesArguments),
    /// Find the smallest sufficient coefficient of a stabilization
    ///
    /// A sufficient stabilization removes the spurious modes and does not mask the instability of the material.
    #[command(after_help = TUNE_EXAMPLES, after_long_help = with_keys(TUNE_EXAMPLES, &keys()))]
    Tune(TuneArguments),
    /// Find the modulus, spacing or coefficient that a time step admits
    ///
    /// Computes the values of a setting for which the given time step is below the critical time step of a state.
    #[command(after_help = LIMIT_EXAMPLES, after_long_help = with_keys(LIMIT_EXAMPLES, &keys()))]
    Limit(LimitArguments),
    /// Test a particle code against the prediction for one wave
    ///
    /// Writes a deck that seeds the wave, runs it, and measures the rate of the wave: for LAMMPS (SMD, PERI), PySPH and any other code.
    #[command(after_help = VERIFY_EXAMPLES)]
    Verify {
        #[command(subcommand)]
        task: VerifyTask,
    },
    /// Find what went wrong first in a run of your own code: particle, time, cause and remedy
    ///
    /// Reads the output files of a run, the law and the method, and follows all particles through time. The cause is the material (physical), the
    /// discretization (numerical, zero-energy), the time step, or a forced motion. Formats: LAMMPS text dumps, VTU, VTP and PVD, NumPy arrays,
    /// extended XYZ, CSV.
    #[command(after_help = SCREEN_EXAMPLES, after_long_help = with_keys(SCREEN_EXAMPLES, &keys()))]
    Screen(Box<ScreenArguments>),
    /// Fit laws of rubber and foam to test data, stable in the range where they are used
    ///
    /// Reads tables of tests (CSV with a header, test data in decks of Abaqus) and finds the constants with the least squared errors for which the law
    /// is stable at all states of a range. The answer ranks the laws. It gives the cost of the stability constraint, and the states at which
    /// the best fit without it would become unstable.
    #[command(after_help = FIT_EXAMPLES)]
    Fit(Box<FitArguments>),
    /// Simulate the particles of a periodic patch or of a body, step by step
    ///
    /// A patch of cells moves about a homogeneous state under the nonlinear forces of the method, and starts with one wave or with noise. The
    /// measured rate of the wave is compared with the rate predicted in discrete time. Histories, fields and checkpoints are written. For a study
    /// with a body, the body and its grips are simulated instead.
    #[command(after_help = SIMULATE_EXAMPLES, after_long_help = with_keys(SIMULATE_EXAMPLES, &(keys() + &body_keys())))]
    Simulate(Box<SimulateArguments>),
    /// Show instabilities that users of particle codes reported, with cause and remedy
    ///
    /// Lists the reports, or answers one: the observation with its source, the verdict on its state, a remedy, and the study with its settings.
    #[command(after_help = ZOO_EXAMPLES)]
    Zoo(ZooArguments),
    /// Draw stored maps: verdicts and boundaries, a field, or an overlay
    ///
    /// Draws the verdicts with the boundaries of material and particles, or one field. Several stores are drawn as one overlay.
    #[command(after_help = PLOT_EXAMPLES)]
    Plot(PlotArguments),
    /// Check that a law has an energy and a consistent tangent
    #[command(after_help = AUDIT_EXAMPLES, after_long_help = with_keys(AUDIT_EXAMPLES, &law_keys()))]
    Audit(AuditArguments),
    /// Print Abaqus's utility routines in Fortran, to compile with a UMAT
    ///
    /// The routines are SINV, SPRINC, ROTSIG, XIT and others, for a UMAT that calls them.
    UmatUtilities,
    /// Print the C header of a law of your own, for material.model=library
    LawHeader,
    /// Print the JSON Schema of study files, for editors and other programs
    Schema,
    /// Print a script that completes commands and options in a shell
    Completions {
        /// Shell: bash, zsh, fish, elvish or powershell.
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
        /// Options of the figures.
        #[command(flatten)]
        look: LookArguments,
    },
}

/// Path of deformations, or a loading.
#[derive(Debug, Args)]
pub struct CourseArguments {
    /// Loading: uniaxial, equibiaxial, planar, simple-shear or hydrostatic. With a loading, --from and --to are its imposed stretches, or the amount
    /// of shear gamma in simple shear.
    #[arg(long, value_name = "MODE", value_parser = mode, help_heading = "Path")]
    pub mode: Option<Mode>,
    /// Condition on the other directions: free (no traction on lateral faces), plane-stress, plane-strain or held [default: the least constrained
    /// condition of the loading].
    #[arg(long, value_name = "WHAT", value_parser = lateral, requires = "mode", help_heading = "Path")]
    pub lateral: Option<Lateral>,
    /// Start: two or three stretches, or the components F11,F12,F21,F22; with --mode one stretch [default: 1], or gamma in simple shear [default: 0].
    #[arg(
        long,
        value_name = "L1,L2",
        allow_hyphen_values = true,
        required_unless_present = "mode",
        help_heading = "Path"
    )]
    pub from: Option<String>,
    /// FILE is a deck of this program, as --from in other commands; needed if the program is not recognized, or is calculix.
    #[arg(
        long,
        value_name = "PROGRAM",
        requires = "file",
        help_heading = "Problem"
    )]
    pub read_as: Option<Program>,
    /// Material in FILE, if FILE is a deck: its name or its number [default: the first material with a law].
    #[arg(long, value_name = "NAME", requires = "file", help_heading = "Problem")]
    pub material: Option<String>,
    /// End of the path, in the same form as the start.
    #[arg(
        long,
        value_name = "L1,L2",
        allow_hyphen_values = true,
        help_heading = "Path"
    )]
    pub to: String,
}

/// Verdicts that end a command with exit code 3.
#[derive(Debug, Args)]
pub struct FailingArguments {
    /// Exit with code 3 if a state has one of these verdicts, for continuous integration: stable, physical, zero-energy, numerical, suppressed,
    /// undefined; or a group of them: unstable, unfaithful, any.
    #[arg(long, value_name = "VERDICTS", value_parser = FailOn::parse)]
    pub fail_on: Option<FailOn>,
}

/// Option for the largest relative frequency of weakly controlled waves.
#[derive(Clone, Copy, Debug, Args)]
pub struct WeakArgument {
    /// Limit of weakly controlled waves: largest ratio of their frequency to the frequency of the slowest material wave.
    #[arg(id = "weak", long, value_name = "SHARE", default_value_t = Thresholds::default().weak, value_parser = share, help_heading = "Limits")]
    pub share: f64,
}

/// Limits between acceptable and wrong results.
#[derive(Clone, Copy, Debug, Args)]
pub struct ThresholdArguments {
    /// Limit of weak control: largest frequency relative to the slowest material wave.
    #[command(flatten)]
    pub weak: WeakArgument,
    /// Largest accepted fraction of states with a wrong verdict.
    #[arg(long, value_name = "SHARE", default_value_t = Thresholds::default().wrong, value_parser = share, help_heading = "Limits")]
    pub wrong: f64,
}

/// Length of a printed answer.
#[derive(Clone, Copy, Debug, Args)]
pub struct DetailArguments {
    /// Print the whole answer instead of at most 12 lines.
    #[arg(long, help_heading = "Printing")]
    pub all: bool,
    /// Print all settings with their defaults after a short answer.
    #[arg(long, conflicts_with = "all", help_heading = "Printing")]
    pub settings: bool,
}

impl DetailArguments {
    /// Returns the text of an answer.
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
    /// Run a deck with the installed code, and read the output
    Run {
        /// Folder of the deck.
        deck: PathBuf,
        /// Program that runs the deck [default: lmp, or python3 for PySPH].
        #[arg(long, value_name = "PATH")]
        program: Option<PathBuf>,
    },
    /// Read an output, and compare the measured with the predicted rate
    Read {
        /// Output file, or folder of the deck.
        output: PathBuf,
        /// Case file of the deck [default: case.json in the folder of the output].
        #[arg(long, value_name = "FILE")]
        case: Option<PathBuf>,
    },
    /// List the supported codes: their choices, and how they deviate from the papers
    Codes,
}

/// Command-line arguments of `onset verify deck`.
#[derive(Debug, Args)]
pub struct DeckArguments {
    /// Code: lammps-smd-tlsph, lammps-smd-ulsph, lammps-peri, pysph, or plain for any other code.
    #[arg(long, value_name = "NAME")]
    pub code: String,
    /// Material and discretization of the problem. The code fixes some settings, which can be omitted.
    #[command(flatten)]
    pub problem: ProblemArguments,
    /// Principal stretches along the axes [default: the stretches of the study].
    #[arg(long, value_name = "L1,L2", allow_hyphen_values = true)]
    pub stretch: Option<String>,
    /// Reference wave vector, for example 3.141592654,0 (in units of 1/length).
    #[arg(long, value_name = "K1,K2", allow_hyphen_values = true)]
    pub wave_vector: String,
    /// Number of the wave with this wave vector, counted from 1 by increasing omega^2.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub branch: usize,
    /// Time step [default: a step that resolves the wave well].
    #[arg(long, value_name = "DT", value_parser = positive)]
    pub time_step: Option<f64>,
    /// Number of time steps [default: most of a period, or four e-folding times].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(32..=1_000_000))]
    pub steps: Option<u32>,
    /// Largest relative difference between the rates that counts as agreement [default: the accuracy known for the code].
    #[arg(long, value_name = "SHARE", value_parser = share, allow_negative_numbers = true)]
    pub tolerance: Option<f64>,
    /// Time stepping of the code, with --code plain: velocity-verlet, extrapolated-stress, late-density or late-acceleration [default:
    /// velocity-verlet].
    #[arg(long, value_name = "NAME", value_parser = stepping)]
    pub stepping: Option<Stepping>,
    /// Folder for the deck and its case.json.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

/// Command-line arguments of `onset screen`.
#[derive(Debug, Args)]
pub struct ScreenArguments {
    /// Output files of the run, and a study file (.toml) with its law and method; wildcards may be quoted.
    #[arg(value_name = "FILE", required = true)]
    pub files: Vec<PathBuf>,
    /// Settings on the command line.
    #[command(flatten)]
    pub set: SetArguments,
    /// Libraries that the file may load.
    #[command(flatten)]
    pub trust: TrustArguments,
    /// Time step of the code; converts step numbers into times for formats without times.
    #[arg(long, value_name = "DT", value_parser = positive, help_heading = "Time")]
    pub time_step: Option<f64>,
    /// Time stepping of the code: velocity-verlet (also leapfrog, central-differences), extrapolated-stress (LAMMPS smd/tlsph), late-density
    /// (smd/ulsph) or late-acceleration (PySPH).
    #[arg(long, value_name = "NAME", value_parser = stepping, default_value = "velocity-verlet", help_heading = "Time")]
    pub stepping: Stepping,
    /// Frames to read, as a slice: FIRST:END or FIRST:END:EVERY.
    #[arg(long, value_name = "A:B:N", value_parser = FrameRange::from_str, default_value = ":", hide_default_value = true, allow_hyphen_values = true, help_heading = "Reading")]
    pub frames: FrameRange,
    /// Columns of quantities, for example "x=xu,yu F=c_F id=tag": x, X (reference), u, v, F, stress, density, id, type, held, time, volume, mass.
    #[arg(long, value_name = "LIST", help_heading = "Reading")]
    pub columns: Option<String>,
    /// Reference configuration: `first` for the positions of the first frame, or a file [default: reference positions or displacements in the
    /// files, or else the first frame].
    #[arg(long, value_name = "FILE", value_parser = reference, default_value = "recorded", hide_default_value = true, help_heading = "Reading")]
    pub reference: Reference,
    /// Held particles: a type (2), a box of reference positions (-1,-1:3,20) or none; may be given several times [default: a column `held`, or a type or
    /// faces that move rigidly, rotations included].
    #[arg(long, value_name = "WHICH", value_parser = Held::from_str, allow_hyphen_values = true, help_heading = "Reading")]
    pub held: Vec<Held>,
    /// Judge only the particles in a box of reference positions, for example 0,0:10,5.
    #[arg(long, value_name = "BOX", value_parser = Region::from_str, allow_hyphen_values = true, help_heading = "Reading")]
    pub region: Option<Region>,
    /// Screen again whenever the files of a running simulation have grown, until a cause of --fail-on or an interrupt ends the command.
    #[arg(long, conflicts_with_all = ["check", "out"], help_heading = "Reading")]
    pub watch: bool,
    /// Print format, columns, spacing and held particles of the files, and stop.
    #[arg(long, help_heading = "Reading")]
    pub check: bool,
    /// Smallest amplitude of short waves in the particle positions that counts as observed, in particle spacings.
    #[arg(long, value_name = "A", value_parser = share, allow_negative_numbers = true, default_value_t = THRESHOLD)]
    pub threshold: f64,
    /// Amplitude of the waves when growth begins, in spacings [default: the short waves in the files].
    #[arg(long, value_name = "A", value_parser = share, allow_negative_numbers = true)]
    pub seed: Option<f64>,
    /// Width of the bins of stretch in which particles share a state. The expected time is also computed with twice the width.
    #[arg(long, value_name = "WIDTH", value_parser = share, allow_negative_numbers = true, default_value_t = BIN)]
    pub bin: f64,
    /// Find the lowest modes of the body, with the tangent of all forces, in the frame nearest to this time: structural, localized, or short waves.
    #[arg(long, value_name = "TIME", value_parser = time, allow_negative_numbers = true)]
    pub actual: Option<f64>,
    /// Limit of weak control: weaker waves explain short waves that do not grow.
    #[command(flatten)]
    pub weak: WeakArgument,
    /// Exit with code 3 if the first cause is one of these: physical, numerical, time-step, zero-energy, forced.
    #[arg(
        long,
        value_name = "CAUSES",
        value_parser = cause,
        value_delimiter = ','
    )]
    pub fail_on: Vec<Cause>,
    /// Folder for screen.pvd with fields, screen.json, screen.csv, the figure (screen.svg, .png, .pdf), first.toml and modes.vtu, or NAME.svg, NAME.png or
    /// NAME.pdf for the figure alone; nothing is written without it.
    #[arg(long, value_name = "DIR", help_heading = "Files")]
    pub out: Option<PathBuf>,
    /// Options of the figure.
    #[command(flatten)]
    pub drawing: DrawingArguments,
    /// Largest number of frames whose fields are written.
    #[arg(
        long,
        requires = "out",
        value_name = "N",
        default_value_t = 50,
        help_heading = "Files"
    )]
    pub fields: usize,
    /// Length of the printed answer.
    #[command(flatten)]
    pub detail: DetailArguments,
}

/// Command-line arguments of `onset fit`.
#[derive(Debug, Args)]
pub struct FitArguments {
    /// Tables of tests, a list of tests (TOML), or decks of Abaqus or Ansys with test data. A comment `# mode: planar` or the name of the file gives the loading of a table.
    #[arg(value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Table of a uniaxial test.
    #[arg(long, value_name = "FILE", help_heading = "Tests")]
    pub uniaxial: Vec<PathBuf>,
    /// Table of an equibiaxial test.
    #[arg(long, value_name = "FILE", help_heading = "Tests")]
    pub equibiaxial: Vec<PathBuf>,
    /// Table of a planar test (pure shear).
    #[arg(long, value_name = "FILE", help_heading = "Tests")]
    pub planar: Vec<PathBuf>,
    /// Table of a simple shear test.
    #[arg(long, value_name = "FILE", help_heading = "Tests")]
    pub simple_shear: Vec<PathBuf>,
    /// Table of a volumetric test.
    #[arg(long, value_name = "FILE", help_heading = "Tests")]
    pub volumetric: Vec<PathBuf>,
    /// Material whose tests are read from a deck with several materials: its name (Abaqus) or its number (Ansys).
    #[arg(long, value_name = "NAME", help_heading = "Tests")]
    pub material: Option<String>,
    /// Unit of stress of tables without a unit, for example MPa.
    #[arg(long, value_name = "UNIT", help_heading = "Tests")]
    pub unit: Option<String>,
    /// Area of the undeformed cross-section, which turns forces into nominal stresses.
    #[arg(long, value_name = "A", value_parser = positive, allow_negative_numbers = true, help_heading = "Tests")]
    pub area: Option<f64>,
    /// Use only points with stretches between two limits.
    #[arg(long, value_name = "LOW,HIGH", value_parser = onset_study::fit::stretches_between, help_heading = "Tests")]
    pub range: Option<[f64; 2]>,
    /// Laws to fit: names separated by commas, or all.
    #[arg(
        long,
        value_name = "LAWS",
        value_delimiter = ',',
        default_value = "all",
        help_heading = "Fit"
    )]
    pub law: Vec<String>,
    /// Weights of the points: relative (errors divided by the measured stress), by-test (relative, with the same weight for each test) or absolute.
    #[arg(long, value_name = "KIND", value_parser = ["relative", "by-test", "absolute"], default_value = "relative", help_heading = "Fit")]
    pub weights: String,
    /// Weight of the squared errors of a test, by its loading, for example equibiaxial=3 (may be given several times) [default: 1].
    #[arg(long, value_name = "TEST=NUMBER", value_parser = weight, allow_hyphen_values = true, help_heading = "Fit")]
    pub weight: Vec<(String, f64)>,
    /// Smallest stress in the denominator of relative errors, as a fraction of the largest stress of the test [default: 0, and 0.02 with by-test].
    #[arg(long, value_name = "PART", value_parser = share, allow_negative_numbers = true, help_heading = "Fit")]
    pub floor: Option<f64>,
    /// Fix a constant, for example alpha1=2 (may be given several times).
    #[arg(long, value_name = "NAME=VALUE", value_parser = constant, allow_hyphen_values = true, help_heading = "Fit")]
    pub fix: Vec<(String, f64)>,
    /// Bound a constant, for example alpha1=-5,10 (may be given several times).
    #[arg(long, value_name = "NAME=LOW,HIGH", value_parser = bound, allow_hyphen_values = true, help_heading = "Fit")]
    pub bound: Vec<(String, [f64; 2])>,
    /// Bulk modulus of the fitted law [default: from a volumetric test, or 1000 shear moduli].
    #[arg(long, value_name = "KAPPA", value_parser = positive, allow_negative_numbers = true, help_heading = "Fit")]
    pub bulk: Option<f64>,
    /// Number of initial guesses for constants in which a law is nonlinear.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=10_000), default_value_t = 64, help_heading = "Fit")]
    pub starts: u16,
    /// Range in which the law must be stable: data (up to 1.25 times the largest stretch of the tests), data=FACTOR, box=LOW,HIGH (all principal
    /// stretches), loadings=LOW,HIGH (uniaxial, equibiaxial and planar), or none.
    #[arg(long, value_name = "RANGE", value_parser = stable_range, default_value = "data", help_heading = "Stability")]
    pub stable: StableRange,
    /// Criterion that must hold: drucker, ellipticity or both.
    #[arg(long, value_name = "NAME", value_parser = ["drucker", "ellipticity", "both"], default_value = "both", help_heading = "Stability")]
    pub criterion: String,
    /// Smallest value of a criterion, as a fraction of its value in the reference configuration.
    #[arg(long, value_name = "PART", value_parser = share, allow_negative_numbers = true, default_value_t = 1e-6, help_heading = "Stability")]
    pub margin: f64,
    /// Exit with code 3 if no fitted law is stable: unstable.
    #[arg(long, value_name = "WHAT", value_parser = ["unstable"], help_heading = "Stability")]
    pub fail_on: Option<String>,
    /// Folder for fit.toml, fit.json, fit.csv, the figure (fit.svg, .png, .pdf) and blocks for other programs, or NAME.svg, NAME.png or NAME.pdf for the
    /// figure alone; nothing is written without it.
    #[arg(long, value_name = "DIR", help_heading = "Files")]
    pub out: Option<PathBuf>,
    /// Options of the figure.
    #[command(flatten)]
    pub drawing: DrawingArguments,
    /// Length of the printed answer.
    #[command(flatten)]
    pub detail: DetailArguments,
}

/// Range of `--stable`; `None` for a free fit.
#[derive(Clone, Copy, Debug)]
pub struct StableRange(pub Option<onset_study::fit::Range>);

fn stable_range(text: &str) -> Result<StableRange, String> {
    onset_study::fit::stable_range(text).map(StableRange)
}

fn constant(text: &str) -> Result<(String, f64), String> {
    let pair = text.split_once('=').and_then(|(name, value)| {
        let value = value
            .trim()
            .parse::<f64>()
            .ok()
            .filter(|own| own.is_finite())?;
        Some((name.trim().to_owned(), value))
    });
    pair.ok_or_else(|| "expected NAME=VALUE, for example alpha1=2".to_owned())
}

fn weight(text: &str) -> Result<(String, f64), String> {
    let found = constant(text).ok().filter(|own| own.1 > 0.0);
    found.ok_or_else(|| {
        "expected TEST=NUMBER with a positive number, for example equibiaxial=3".to_owned()
    })
}

fn bound(text: &str) -> Result<(String, [f64; 2]), String> {
    let found = text.split_once('=').and_then(|(name, values)| {
        let (low, high) = values.split_once(',')?;
        let low = low.trim().parse::<f64>().ok()?;
        let high = high.trim().parse::<f64>().ok()?;
        (low < high).then(|| (name.trim().to_owned(), [low, high]))
    });
    found.ok_or_else(|| "expected NAME=LOW,HIGH, for example alpha1=-5,10".to_owned())
}

fn reference(text: &str) -> Result<Reference, String> {
    Ok(match text {
        "recorded" => Reference::Recorded,
        "first" => Reference::First,
        file => Reference::File(file.into()),
    })
}

fn cause(text: &str) -> Result<Cause, String> {
    let name = text.trim();
    let known = Cause::ALL.into_iter().find(|own| own.name() == name);
    known.ok_or_else(|| expected(text, "causes:", &Cause::ALL.map(Cause::name)))
}

/// Command-line arguments of `onset simulate`.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("length").args(["steps", "time"])))]
#[command(group(ArgGroup::new("step-size").args(["fraction", "time_step"])))]
pub struct SimulateArguments {
    /// Material and discretization of the problem.
    #[command(flatten)]
    pub problem: ProblemArguments,
    /// Homogeneous state of deformation, or the initial state of a body.
    #[command(flatten)]
    pub strain: StrainArguments,
    /// Number of cells of the patch along the primitive vectors: one number for all, or one for each [default: 8].
    #[arg(long, value_name = "N", help_heading = "Patch")]
    pub cells: Option<String>,
    /// Initial motion: critical, the wave of the patch with the smallest omega^2; or noise, in which the same wave is measured [default: critical].
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
    /// Seed this wave instead, by its number of wavelengths along each side of the patch.
    #[arg(
        long,
        value_name = "N1,N2",
        allow_hyphen_values = true,
        conflicts_with_all = ["mode", "wave_vector"],
        help_heading = "Patch"
    )]
    pub turns: Option<String>,
    /// Number of the wave with this wave vector, counted from 1 by increasing omega^2 [default: 1].
    #[arg(long, value_name = "N", help_heading = "Patch")]
    pub branch: Option<usize>,
    /// Largest initial displacement, in particle spacings; random displacements for a body [default: 1e-6, or 0 for a body].
    #[arg(long, value_name = "A", value_parser = share, allow_negative_numbers = true, help_heading = "Patch")]
    pub amplitude: Option<f64>,
    /// Seed of the random noise [default: 1].
    #[arg(long, value_name = "S", help_heading = "Patch")]
    pub seed: Option<u64>,
    /// Number of time steps [default: about a period of the wave, four e-folding times of growth or one of decay; no default for a body].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..), help_heading = "Time")]
    pub steps: Option<u64>,
    /// Duration, instead of a number of steps.
    #[arg(long, value_name = "T", value_parser = positive, help_heading = "Time")]
    pub time: Option<f64>,
    /// Ratio of the time step to the largest stable step for the waves of the patch [default: 0.5, less for a wave that grows fast].
    #[arg(long, value_name = "SHARE", value_parser = positive, help_heading = "Time")]
    pub fraction: Option<f64>,
    /// Time step, instead of --fraction [default for a transfer of material points: discretization.time-step, if set].
    #[arg(long, value_name = "DT", value_parser = positive, help_heading = "Time")]
    pub time_step: Option<f64>,
    /// Allow a time step above the largest stable step.
    #[arg(long, help_heading = "Time")]
    pub supercritical: bool,
    /// Integrator: kick-drift-kick (velocity-verlet), central-differences (leapfrog, symplectic-euler), predictor-corrector (midpoint), sixth-order
    /// (nine steps of kick-drift-kick), or an explicit Runge-Kutta method: forward-euler, heun, rk3, rk4, carpenter-kennedy, rdpk3-35, rdpk3-49
    /// [default: time.integrator, or kick-drift-kick; central-differences for bodies; a transfer of material points defines its step].
    #[arg(long, value_name = "NAME", value_parser = stepper, help_heading = "Time")]
    pub integrator: Option<Stepper>,
    /// Largest relative difference between the rates that counts as agreement [default: 1e-6].
    #[arg(long, value_name = "SHARE", value_parser = share, allow_negative_numbers = true)]
    pub tolerance: Option<f64>,
    /// Folder for history.csv, the figure (simulate.svg, .png, .pdf), fields and checkpoints, or NAME.svg, NAME.png or NAME.pdf for the figure of a patch
    /// alone; nothing is written without it.
    #[arg(long, value_name = "DIR", help_heading = "Files")]
    pub out: Option<PathBuf>,
    /// Options of the figure.
    #[command(flatten)]
    pub drawing: DrawingArguments,
    /// Steps between lines of the history [default: about 400 lines].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..), help_heading = "Files")]
    pub every: Option<u64>,
    /// Number of fields written from start to end (field-0000.vtu, ... and fields.pvd) [default: 11].
    #[arg(long, requires = "out", value_name = "N", value_parser = clap::value_parser!(u64).range(0..=10_000), help_heading = "Files")]
    pub fields: Option<u64>,
    /// Steps between checkpoints [default: a checkpoint every five seconds].
    #[arg(long, requires = "out", value_name = "N", value_parser = clap::value_parser!(u64).range(1..), help_heading = "Files")]
    pub checkpoint: Option<u64>,
    /// Resume from the checkpoint in the folder, or start a new run without a checkpoint. The files are identical to the files of an uninterrupted
    /// run.
    #[arg(
        long,
        requires = "out",
        conflicts_with = "overwrite",
        help_heading = "Files"
    )]
    pub resume: bool,
    /// Start a new run even if the folder has a checkpoint.
    #[arg(long, requires = "out", help_heading = "Files")]
    pub overwrite: bool,
}

fn stepper(text: &str) -> Result<Stepper, String> {
    Stepper::named(text).ok_or_else(|| expected(text, "available:", &Stepper::names()))
}

/// Parses a positive time, or a ratio of times.
fn positive(text: &str) -> Result<f64, String> {
    let number = text.trim().parse::<f64>().ok();
    number
        .filter(|number| Positive.holds(*number, "time"))
        .ok_or_else(|| format!("expected {}, for example 0.05", Positive.expected("time")))
}

fn time(text: &str) -> Result<f64, String> {
    let number = text.trim().parse::<f64>().ok();
    number
        .filter(|number| number.is_finite())
        .ok_or_else(|| "expected a time, for example 190".to_owned())
}

fn stepping(text: &str) -> Result<Stepping, String> {
    stepping_named(text)
        .ok_or_else(|| expected(text, "available:", &Stepping::ALL.map(Stepping::name)))
}

/// Command-line arguments of `onset plot`.
#[derive(Debug, Args)]
pub struct PlotArguments {
    /// Stores written by `onset map`.
    #[arg(value_name = "STORE", required = true)]
    pub stores: Vec<PathBuf>,
    /// Quantity to draw: verdict, or a numerical field such as scaled_minimum, growth_rate, acoustic_minimum, critical_time_step or
    /// lowest_omega_squared; for a certified map also certainty and certainty_material.
    #[arg(long, value_name = "FIELD", default_value = "verdict")]
    pub field: String,
    /// Trace the boundaries without a time limit, with gaps where they cannot be followed [default: trace for ten seconds, only if no axis varies the
    /// material or the method, and use the result only if it has no gaps].
    #[arg(long, conflicts_with = "no_trace")]
    pub trace: bool,
    /// Do not trace the boundaries; take them from the cells of the map.
    #[arg(long)]
    pub no_trace: bool,
    /// Options of the figure.
    #[command(flatten)]
    pub drawing: DrawingArguments,
    /// Limits of the horizontal axis.
    #[arg(long, value_name = "LOW,HIGH", value_parser = limits, allow_hyphen_values = true, help_heading = "Look")]
    pub x_limits: Option<(f64, f64)>,
    /// Limits of the vertical axis.
    #[arg(long, value_name = "LOW,HIGH", value_parser = limits, allow_hyphen_values = true, help_heading = "Look")]
    pub y_limits: Option<(f64, f64)>,
    /// Values at the ends of the color bar of a field; values beyond have the end colors [default: the limits of the middle 99 % of the values].
    #[arg(long, value_name = "LOW,HIGH", value_parser = limits, allow_hyphen_values = true, help_heading = "Look")]
    pub limits: Option<(f64, f64)>,
    /// Colors of a field: viridis, cividis, grey, or red-blue with white at zero [default: red-blue if values are negative, otherwise viridis].
    #[arg(long, value_name = "NAME", value_parser = color_map, help_heading = "Look")]
    pub color_map: Option<ColorMap>,
    /// Output file, NAME.svg, NAME.png or NAME.pdf (all three are written), or a folder for map.svg, map.png and map.pdf.
    #[arg(long, value_name = "PATH", default_value = ".")]
    pub out: PathBuf,
    /// Libraries that the stores may load.
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
fn two(text: &str) -> Option<(f64, f64)> {
    let (first, second) = text.split_once(',')?;
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    Some((number(first)?, number(second)?))
}

fn color_map(text: &str) -> Result<ColorMap, String> {
    let known = ColorMap::ALL.into_iter().find(|map| map.name() == text);
    known.ok_or_else(|| expected(text, "available:", &ColorMap::ALL.map(ColorMap::name)))
}

/// Libraries that files may load.
#[derive(Clone, Debug, Args)]
pub struct TrustArguments {
    /// Allow files to load this library (material.library), or any library in this folder (may be given several times). A library is a program that
    /// runs with your permissions. The environment variable ONSET_ALLOW_LIBRARY allows it permanently.
    #[arg(long = "allow-library", value_name = "PATH")]
    pub libraries: Vec<PathBuf>,
}

/// Command-line arguments of `onset explore`.
#[cfg(feature = "explore")]
#[derive(Debug, Args)]
pub struct ExploreArguments {
    /// Problem shown first; FILE can also be a stored map, or an address from the page of another run.
    #[command(flatten)]
    pub problem: ProblemArguments,
    /// Port on the loopback address [default: any free port].
    #[arg(long, value_name = "PORT")]
    pub port: Option<u16>,
    /// Print the address without starting a browser.
    #[arg(long)]
    pub no_browser: bool,
}

/// Material law, and the stretches of interest.
#[derive(Debug, Args)]
pub struct LawArguments {
    /// Material law and its parameters.
    #[command(flatten)]
    pub problem: ProblemArguments,
    /// Smallest and largest stretch.
    #[arg(long, value_name = "A,B", default_value = "0.1,10", value_parser = stretches)]
    pub range: Stretches,
    /// Use the incompressible response of an isotropic law: J = 1, the pressure follows from a free face, and the volumetric part is ignored.
    #[arg(long)]
    pub incompressible: bool,
    /// Include only loadings of this mode: uniaxial, equibiaxial, planar, simple-shear or hydrostatic (may be given several times).
    #[arg(long = "mode", value_name = "MODE", value_parser = mode)]
    pub modes: Vec<Mode>,
}

/// Command-line arguments of `onset criteria`.
#[derive(Debug, Args)]
pub struct CriteriaArguments {
    /// Material law and its parameters.
    #[command(flatten)]
    pub law: LawArguments,
    /// Folder for the figure (criteria.svg, .png, .pdf), or NAME.svg, NAME.png or NAME.pdf; no figure is drawn without it.
    #[arg(long, value_name = "PATH")]
    pub out: Option<PathBuf>,
    /// Criteria that the figure shows, at most seven of `onset list criteria`, with commas between them [default: strong-ellipticity,drucker-abaqus].
    #[arg(long = "criterion", value_name = "NAMES", value_delimiter = ',', value_parser = criterion, requires = "out")]
    pub drawn: Vec<Criterion>,
    /// Options of the figure.
    #[command(flatten)]
    pub drawing: DrawingArguments,
    /// Length of the printed answer.
    #[command(flatten)]
    pub detail: DetailArguments,
}

/// Command-line arguments of `onset card`.
#[derive(Debug, Args)]
pub struct CardArguments {
    /// Material law and its parameters.
    #[command(flatten)]
    pub law: LawArguments,
    /// Folder for card.html, card.json and the figure (card.svg, .png, .pdf), or NAME.svg, NAME.png or NAME.pdf for the figure alone; nothing is written
    /// without it.
    #[arg(long, value_name = "PATH")]
    pub out: Option<PathBuf>,
    /// Options of the figure.
    #[command(flatten)]
    pub drawing: DrawingArguments,
    /// Length of the printed answer.
    #[command(flatten)]
    pub detail: DetailArguments,
}

/// Command-line arguments of `onset compare`.
#[derive(Debug, Args)]
pub struct CompareArguments {
    /// Comparison file with a material and `[[methods]]`, or a study whose method is compared with the built-in methods; - for standard input.
    pub file: Option<PathBuf>,
    /// Compare variants of a method: a key of the discretization with its values, separated by commas (lists of numbers by semicolons), or a key alone
    /// for all its words, such as discretization.kernel. Given several times, the values are combined. Without FILE, --set defines the method.
    #[arg(long = "vary", value_name = "KEY=VALUES")]
    pub variations: Vec<String>,
    /// Folder for compare.html, compare.csv and the figure (compare.svg, .png, .pdf), or NAME.svg, NAME.png or NAME.pdf for the figure alone; nothing is
    /// written without it.
    #[arg(long, value_name = "PATH")]
    pub out: Option<PathBuf>,
    /// Options of the figure.
    #[command(flatten)]
    pub drawing: DrawingArguments,
    /// Set a key for all methods, for example material.model=blatz-ko (may be given several times).
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub assignments: Vec<String>,
    /// Deck of another program in FILE.
    #[command(flatten)]
    pub block: BlockArguments,
    /// Libraries that the file may load.
    #[command(flatten)]
    pub trust: TrustArguments,
    /// Limit of weak control: largest frequency relative to the slowest material wave.
    #[command(flatten)]
    pub weak: WeakArgument,
    /// Length of the printed answer.
    #[command(flatten)]
    pub detail: DetailArguments,
}

/// Command-line arguments of `onset modes`.
#[derive(Debug, Args)]
pub struct ModesArguments {
    /// Material and discretization of the problem.
    #[command(flatten)]
    pub problem: ProblemArguments,
    /// Limit of weak control: largest frequency relative to the slowest material wave.
    #[command(flatten)]
    pub weak: WeakArgument,
    /// Number of cells along each primitive vector of the patch that is drawn and exported.
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u16).range(1..=512))]
    pub cells: u16,
    /// Largest displacement of the exported fields, in particle spacings.
    #[arg(long, value_name = "A", default_value_t = 0.2, value_parser = share, allow_negative_numbers = true)]
    pub amplitude: f64,
    /// Folder for the figure (modes.svg, .png, .pdf), modes.html (moving), and mode-1.csv, mode-1.vtk, ..., or NAME.svg, NAME.png or NAME.pdf for the
    /// figure alone; nothing is written without it.
    #[arg(long, value_name = "PATH")]
    pub out: Option<PathBuf>,
    /// Options of the figure.
    #[command(flatten)]
    pub drawing: DrawingArguments,
    /// Length of the printed answer.
    #[command(flatten)]
    pub detail: DetailArguments,
}

/// Command-line arguments of `onset tune`.
#[derive(Debug, Args)]
pub struct TuneArguments {
    /// Coefficient to tune: a key with a numerical value, for example discretization.stress-point-weight.
    pub key: String,
    /// Material and discretization of the problem.
    #[command(flatten)]
    pub problem: ProblemArguments,
    /// Smallest and largest value in the search.
    #[arg(long, value_name = "LOW,HIGH", default_value = "0,1", value_parser = interval, allow_hyphen_values = true)]
    pub range: (f64, f64),
    /// Smallest and largest stretch of the states where verdicts are compared.
    #[arg(long, value_name = "LOW,HIGH", default_value = "0.7,1.5", value_parser = window, allow_hyphen_values = true)]
    pub stretches: (f64, f64),
    /// Limits for a sufficient stabilization.
    #[command(flatten)]
    pub thresholds: ThresholdArguments,
    /// Largest accepted delay of the onset, relative to the strain at the onset of the material; a later onset is masked.
    #[arg(long, value_name = "SHARE", default_value_t = Thresholds::default().later, value_parser = share, help_heading = "Limits")]
    pub later: f64,
    /// Folder for tune.csv and the figure (tune.svg, .png, .pdf), or NAME.svg, NAME.png or NAME.pdf for the figure alone; nothing is written without it.
    #[arg(long, value_name = "PATH")]
    pub out: Option<PathBuf>,
    /// Options of the figure.
    #[command(flatten)]
    pub drawing: DrawingArguments,
    /// Length of the printed answer.
    #[command(flatten)]
    pub detail: DetailArguments,
}

/// Command-line arguments of `onset limit`.
#[derive(Debug, Args)]
pub struct LimitArguments {
    /// Time step that must be stable, with a unit if the settings have units, for example 0.01 or "1 us".
    #[arg(
        long,
        value_name = "DT",
        allow_hyphen_values = true,
        required_unless_present = "keeps"
    )]
    pub time_step: Option<String>,
    /// Find the values that keep all states of a window of stretches stable, instead of the values for a time step; the only choice is stable.
    #[arg(long, value_name = "WORD", value_parser = ["stable"], conflicts_with_all = ["time_step", "stretch", "deformation_gradient", "safety", "integrator"])]
    pub keeps: Option<String>,
    /// With --keeps: smallest and largest stretch along the axes [default: 0.7,1.5].
    #[arg(long, value_name = "LOW,HIGH", value_parser = window, allow_hyphen_values = true, requires = "keeps", conflicts_with = "time_step")]
    pub stretches: Option<(f64, f64)>,
    /// Setting to vary: a key with a numerical value, for example material.young or discretization.spacing.
    #[arg(long, value_name = "KEY")]
    pub vary: String,
    /// Material and discretization of the problem.
    #[command(flatten)]
    pub problem: ProblemArguments,
    /// Homogeneous state of deformation [default: F = 1].
    #[command(flatten)]
    pub strain: StrainArguments,
    /// Smallest and largest value in the search, in SI units if the settings have units [default: 1e-6 to 1e6 times the present value, within the
    /// range of the key].
    #[arg(long, value_name = "LOW,HIGH", value_parser = interval, allow_hyphen_values = true)]
    pub range: Option<(f64, f64)>,
    /// Safety factor: largest accepted ratio of the time step to the critical time step.
    #[arg(long, value_name = "SHARE", default_value_t = 1.0, value_parser = share)]
    pub safety: f64,
    /// Integrator: central-differences (leapfrog, symplectic-euler), kick-drift-kick (velocity-verlet), predictor-corrector, forward-euler,
    /// heun, rk3, rk4, carpenter-kennedy, rdpk3-35 or rdpk3-49 (RDPK3SpFSAL35 and 49). The first three differ with damping only [default:
    /// time.integrator, or kick-drift-kick].
    #[arg(long, value_name = "NAME")]
    pub integrator: Option<String>,
    /// Folder for limit.csv and the figure (limit.svg, .png, .pdf), or NAME.svg, NAME.png or NAME.pdf for the figure alone; nothing is written without it.
    #[arg(long, value_name = "PATH")]
    pub out: Option<PathBuf>,
    /// Options of the figure.
    #[command(flatten)]
    pub drawing: DrawingArguments,
    /// Length of the printed answer.
    #[command(flatten)]
    pub detail: DetailArguments,
}

/// Parses a share: a number above 0 and at most 1.
fn share(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(number) if number > 0.0 && number <= 1.0 => Ok(number),
        _ => Err("expected a number above 0 and at most 1, for example 0.5".to_owned()),
    }
}

/// Parses a wavelength in particle spacings.
fn wavelength(text: &str) -> Result<f64, String> {
    let number = text.trim().parse::<f64>().ok();
    number
        .filter(|number| onset_study::compare::WAVELENGTHS.contains(number))
        .ok_or_else(|| "expected 4, 8 or 16".to_owned())
}

/// Parses an interval of two finite numbers.
fn interval(text: &str) -> Result<(f64, f64), String> {
    let ends = text.split_once(',').and_then(|(low, high)| {
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
        Some((number(low)?, number(high)?))
    });
    ends.filter(|(low, high)| low < high)
        .ok_or_else(|| "expected two numbers, the smaller one first, for example 0,1".to_owned())
}

/// Parses an interval of positive stretches.
fn window(text: &str) -> Result<(f64, f64), String> {
    interval(text)
        .ok()
        .filter(|(low, _)| *low > 0.0)
        .ok_or_else(|| {
            "expected two positive stretches, the smaller one first, for example 0.7,1.5".to_owned()
        })
}

/// Command-line arguments of `onset recommend`.
#[derive(Debug, Args)]
pub struct RecommendArguments {
    /// File of the available methods, as for `onset compare` [default: the built-in methods for the dimension].
    pub file: Option<PathBuf>,
    /// Number of space dimensions, unless a study sets it [default: 2].
    #[arg(long, value_name = "D", value_parser = clap::value_parser!(u8).range(1..=3))]
    pub dimension: Option<u8>,
    /// Smallest and largest stretch expected in the simulation, for example 0.8,1.6; short for compare.stretches.
    #[arg(long, value_name = "LOW,HIGH", value_parser = window, allow_hyphen_values = true)]
    pub stretches: Option<(f64, f64)>,
    /// Limits in the rules of the ranking.
    #[command(flatten)]
    pub thresholds: ThresholdArguments,
    /// Largest accepted relative error of the stiffness of long waves.
    #[arg(long, value_name = "SHARE", default_value_t = Thresholds::default().long_waves, value_parser = share, help_heading = "Limits")]
    pub long_waves: f64,
    /// Wavelength at which frequencies are compared, in particle spacings: 4, 8 or 16.
    #[arg(long, value_name = "N", default_value_t = Thresholds::default().wavelength, value_parser = wavelength, help_heading = "Limits")]
    pub wavelength: f64,
    /// The energy of a user-defined material; short for material.model=formula and material.energy.
    #[arg(long, value_name = "FORMULA", allow_hyphen_values = true)]
    pub energy: Option<String>,
    /// Folder for the whole comparison as compare.html, compare.csv and the figure (compare.svg, .png, .pdf), or NAME.svg, NAME.png or NAME.pdf for the
    /// figure alone; nothing is written without it.
    #[arg(long, value_name = "PATH")]
    pub out: Option<PathBuf>,
    /// Options of the figure.
    #[command(flatten)]
    pub drawing: DrawingArguments,
    /// Set a key for all methods, for example material.model=blatz-ko (may be given several times).
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub assignments: Vec<String>,
    /// Deck of another program in FILE.
    #[command(flatten)]
    pub block: BlockArguments,
    /// Libraries that the file may load.
    #[command(flatten)]
    pub trust: TrustArguments,
    /// Length of the printed answer.
    #[command(flatten)]
    pub detail: DetailArguments,
}

/// Command-line arguments of `onset zoo`.
#[derive(Debug, Args)]
pub struct ZooArguments {
    /// Name of a report [default: all reports are listed].
    pub name: Option<String>,
    /// Write the study with the settings of the report to this file.
    #[arg(long, value_name = "FILE", requires = "name")]
    pub out: Option<PathBuf>,
}

/// Command-line arguments of `onset map`.
#[derive(Debug, Args)]
pub struct MapArguments {
    /// Study file, - for standard input.
    pub file: PathBuf,
    /// Folder of the store [default: the name of the study file, with .zarr, in the current folder].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Compute only these tiles: A to B - 1, or share M of N, whose tiles are spread evenly over the map. Finished tiles are kept. Concurrent
    /// processes can share the work without this option: see --resume.
    #[arg(long, value_name = "A..B | M/N", value_parser = Part::from_str)]
    pub tiles: Option<Part>,
    /// Resume a store of the same study, or create it. Several processes with this option share the work on one store.
    #[arg(long)]
    pub resume: bool,
    /// Verdicts that end the command with exit code 3.
    #[command(flatten)]
    pub failing: FailingArguments,
    /// Overwrite a store of onset, even of another study.
    #[arg(long, conflicts_with_all = ["resume", "tiles"])]
    pub overwrite: bool,
    /// Set a key of the study, for example discretization.support=1.6 or map.adaptive=true (may be given several times).
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub assignments: Vec<String>,
    /// Deck of another program in FILE.
    #[command(flatten)]
    pub block: RefusedBlockArguments,
    /// Libraries that the file may load.
    #[command(flatten)]
    pub trust: TrustArguments,
}

/// Command-line arguments of `onset localize`.
#[derive(Debug, Args)]
pub struct LocalizeArguments {
    /// Study with a plastic law; - for standard input. The loading is set by the options below, not in the study.
    #[arg(conflicts_with = "model")]
    pub file: Option<PathBuf>,
    /// Deck of another program in FILE.
    #[command(flatten)]
    pub block: BlockArguments,
    /// Plastic law: j2, hill-1948, drucker-prager, mohr-coulomb, cap, cam-clay, gurson, kinematic, damage, deformation-theory, umat or library; short for
    /// --set material.model=MODEL [default: drucker-prager].
    #[arg(long, value_name = "MODEL")]
    pub model: Option<String>,
    /// Loading: uniaxial-stress, uniaxial-strain, plane-strain, pure-shear, triaxial-compression or sheet-stretch; short for --set
    /// plasticity.path=PATH.
    #[arg(long, value_name = "PATH")]
    pub path: Option<String>,
    /// Sense of the loading: tension or compression; short for --set plasticity.load=LOAD.
    #[arg(long, value_name = "LOAD")]
    pub load: Option<String>,
    /// Set a key of the law or of the path, for example material.friction=0.7 or plasticity.slip=0.1 (may be given several times).
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub assignments: Vec<String>,
    /// Libraries that the study may load.
    #[command(flatten)]
    pub trust: TrustArguments,
    /// Folder for the figure (localize.svg, .png, .pdf), localize.csv and localize-directions.csv, or NAME.svg, NAME.png or NAME.pdf for the figure alone;
    /// nothing is written without it.
    #[arg(long, value_name = "PATH")]
    pub out: Option<PathBuf>,
    /// Options of the figure.
    #[command(flatten)]
    pub drawing: DrawingArguments,
    /// Length of the printed answer.
    #[command(flatten)]
    pub detail: DetailArguments,
}

/// Parses a range of stretches that contains 1.
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

/// Error for an unknown word: the available names, and the most similar name.
fn expected(typed: &str, what: &str, names: &[&str]) -> String {
    let meant = did_you_mean(typed, names.iter().copied());
    format!("{what} {}{meant}", names.join(", "))
}

/// Parses the name of a loading.
fn mode(text: &str) -> Result<Mode, String> {
    let named = Mode::ALL.into_iter().find(|mode| mode.name() == text);
    named.ok_or_else(|| expected(text, "expected one of", &Mode::ALL.map(Mode::name)))
}

fn criterion(text: &str) -> Result<Criterion, String> {
    let names = Criterion::ALL.map(Criterion::name);
    criterion_named(text).ok_or_else(|| expected(text, "expected one of", &names))
}

/// Command-line arguments of `onset audit`.
#[derive(Debug, Args)]
pub struct AuditArguments {
    /// Material law and its parameters.
    #[command(flatten)]
    pub problem: ProblemArguments,
    /// Magnitude of the strains of the states, unless states are given.
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
    /// Convention in which the tangent of a built-in law is checked [default: first-piola]; the tangent of a UMAT is always jaumann-kirchhoff.
    #[arg(long = "as", value_name = "CONVENTION", value_parser = convention)]
    pub convention: Option<Convention>,
    /// Exit with code 1 if a check fails.
    #[arg(long)]
    pub strict: bool,
}

/// Conditions on the other directions of a loading.
pub const LATERALS: [Lateral; 4] = [
    Lateral::Free,
    Lateral::PlaneStress,
    Lateral::PlaneStrain,
    Lateral::Held,
];

/// Parses the condition on the other directions.
fn lateral(text: &str) -> Result<Lateral, String> {
    let named = LATERALS.into_iter().find(|lateral| lateral.name() == text);
    named.ok_or_else(|| expected(text, "expected one of", &LATERALS.map(Lateral::name)))
}

/// Parses the name of a tangent convention.
fn convention(text: &str) -> Result<Convention, String> {
    Convention::of_name(text).ok_or_else(|| {
        expected(
            text,
            "expected one of",
            &Convention::ALL.map(Convention::name),
        )
    })
}

/// Parses a magnitude of strains.
fn strain(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(number) if number > 0.0 && number <= 0.8 => Ok(number),
        _ => Err("expected a number above 0 and at most 0.8, for example 0.05".to_owned()),
    }
}

/// Parses a tolerance between 0 and 1.
fn tolerance(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(number) if number > 0.0 && number < 1.0 => Ok(number),
        _ => Err("expected a number above 0 and below 1, for example 1e-3".to_owned()),
    }
}

/// Material and discretization of a problem.
#[derive(Debug, Args)]
pub struct ProblemArguments {
    /// Study file and settings of the problem.
    #[command(flatten)]
    pub given: GivenArguments,
    /// Deck of another program in FILE.
    #[command(flatten)]
    pub block: BlockArguments,
}

/// Study file and additional settings.
#[derive(Debug, Args)]
pub struct GivenArguments {
    /// Study file with the material and the discretization, or a deck of another program with the law; - for standard input [default: settings of --set
    /// only].
    pub file: Option<PathBuf>,
    /// Settings on the command line.
    #[command(flatten)]
    pub set: SetArguments,
    /// Libraries that the file may load.
    #[command(flatten)]
    pub trust: TrustArguments,
}

/// Settings on the command line, which override a study file.
#[derive(Clone, Debug, Args)]
pub struct SetArguments {
    /// Set a key, for example material.model=blatz-ko (may be given several times).
    #[arg(long = "set", value_name = "KEY=VALUE", help_heading = "Problem")]
    pub assignments: Vec<String>,
    /// Method of a particle code with its defaults, for example lammps-smd-tlsph; onset list presets has all.
    #[arg(long, value_name = "CODE", help_heading = "Problem")]
    pub preset: Option<String>,
    /// The energy of a user-defined material, for example "mu/2*(I1 - 3 - 2*ln(J))"; its parameters are set by
    /// --set material.mu=1. Short for material.model=formula and material.energy.
    #[arg(
        long,
        value_name = "FORMULA",
        allow_hyphen_values = true,
        help_heading = "Problem"
    )]
    pub energy: Option<String>,
}

/// Arguments for a deck of another program in place of a study.
#[derive(Clone, Debug, Default, Args)]
pub struct BlockArguments {
    /// FILE is a deck of this program; for decks that are not recognized, and for calculix, which has the keywords of abaqus. Programs: abaqus
    /// (*HYPERELASTIC ...), ansys (TB,HYPER ...), calculix, febio (material type="Ogden"), felupe (fem.Hyperelastic(...)), hyperelastic
    /// (ThirdOrderDeformation(C10=...)), lsdyna (*MAT_OGDEN_RUBBER ...) or radioss (/MAT/LAW42 ...).
    #[arg(
        long,
        visible_alias = "read-as",
        value_name = "PROGRAM",
        requires = "file",
        help_heading = "Problem"
    )]
    pub from: Option<Program>,
    /// Material in FILE, if FILE is a deck: its name in Abaqus, CalculiX and FEBio, its number in ANSYS, LS-DYNA and Radioss [default: the first
    /// material with a law].
    #[arg(long, value_name = "NAME", requires = "file", help_heading = "Problem")]
    pub material: Option<String>,
}

/// Deck of another program, given to a command that needs the axes of a study: the error shows the study to write.
#[derive(Clone, Copy, Debug, Args)]
pub struct RefusedBlockArguments {
    /// FILE is a deck of another program.
    #[arg(long, value_name = "PROGRAM", hide = true)]
    pub from: Option<Program>,
}

/// Homogeneous state of deformation. Optional here, because a body may start undeformed; commands that need a state check for it.
#[derive(Debug, Args)]
#[group(required = false, multiple = false)]
pub struct StrainArguments {
    /// Principal stretches along the axes, for example 1.2,0.9 (a third number is the out-of-plane stretch).
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
