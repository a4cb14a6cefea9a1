//! The arguments of the command line.

use clap::{Args, Parser, Subcommand};
use onset_study::audit::Convention;
use onset_study::figure::ColorMap;
use onset_study::localization::PARAMETERS;
use onset_study::notions::{Mode, Range as Stretches};
use onset_study::settings::{COMPARISON_KEYS, KEYS, Key};
use std::ops::Range;
use std::path::PathBuf;

/// The keys that `--set` takes, from the one table that defines them.
fn keys() -> String {
    let line = |key: &Key| {
        let default = match key.default_value().as_str() {
            "" => String::new(),
            default => format!(" [default: {default}]"),
        };
        let meaning = key.meaning;
        format!(
            "  {:<31} {meaning}{default}\n{:34}{}\n",
            key.name,
            "",
            key.expects()
        )
    };
    let (of_laws, others): (Vec<&Key>, Vec<&Key>) = KEYS.iter().partition(|key| key.is_parameter());
    let (model, others): (Vec<&Key>, Vec<&Key>) = others
        .into_iter()
        .partition(|key| key.name == "material.model");
    let lines = |keys: Vec<&Key>| keys.into_iter().map(line).collect::<String>();
    format!(
        "Keys of --set:\n{}  {:<31} a parameter of the law, one of {}\n{:34}`onset list materials` tells which it has\n{}",
        lines(model),
        "material.<parameter>",
        of_laws.len(),
        "",
        lines(others)
    )
}

/// The keys of comparisons, from the one table that defines them.
fn comparison_keys() -> String {
    let line = |key: &Key| {
        format!(
            "  {:<31} {}\n{:34}{}\n",
            key.name,
            key.meaning,
            "",
            key.expects()
        )
    };
    format!(
        "Keys of [compare] and --set, beside those of [material] and [discretization]:\n{}\
         A method in [[methods]] has a name and keys of [discretization].\n",
        COMPARISON_KEYS.iter().map(line).collect::<String>()
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
        format!(
            "  {name:<31} {meaning} [default: {default}]\n{:34}{}{condition}\n",
            "",
            parameter.kind.expects()
        )
    };
    format!(
        "Keys of --set:\n{}",
        PARAMETERS.iter().map(line).collect::<String>()
    )
}

/// Tells where your material and your particle discretization are stable, and whether the first instability
/// belongs to the material or to the method.
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
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Is this state stable, and if not, whose instability is it?
    #[command(after_help = keys())]
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
            requires = "certify",
            help_heading = "Proof"
        )]
        tolerance: f64,
    },
    /// Frequencies of plane waves: of one wave vector, or along a path through the Brillouin zone.
    #[command(after_help = keys())]
    Dispersion {
        /// The problem.
        #[command(flatten)]
        problem: ProblemArguments,
        /// The state.
        #[command(flatten)]
        strain: StrainArguments,
        /// Reference wave vector, for example 2.0,1.1 (in units of 1/length).
        #[arg(
            long,
            value_name = "K1,K2",
            allow_hyphen_values = true,
            required_unless_present = "path"
        )]
        wave_vector: Option<String>,
        /// Draw a dispersion diagram along the points of high symmetry that the state tells apart, or along a path of your own: their
        /// names (G-M-K-G), or points in units of the reciprocal vectors ("0,0; 0.5,0; K"). The line through the critical wave
        /// vector k* is added.
        #[arg(
            long,
            value_name = "POINTS",
            num_args = 0..=1,
            conflicts_with = "wave_vector"
        )]
        path: Option<Option<String>>,
        /// Folder for dispersion.svg, dispersion.png, dispersion.csv and density-of-states.csv.
        #[arg(
            long,
            value_name = "DIR",
            default_value = ".",
            conflicts_with = "wave_vector"
        )]
        out: PathBuf,
    },
    /// Where along a straight path of deformations is stability lost, and regained?
    #[command(after_help = keys())]
    Path {
        /// The problem.
        #[command(flatten)]
        problem: ProblemArguments,
        /// Start: two or three stretches, or the components F11,F12,F21,F22.
        #[arg(long, value_name = "L1,L2", allow_hyphen_values = true)]
        from: String,
        /// End, likewise.
        #[arg(long, value_name = "L1,L2", allow_hyphen_values = true)]
        to: String,
    },
    /// Where along a loading path does a plastic material localize, in which kind of band, and at which angle?
    #[command(after_help = plastic_parameters())]
    Localize(LocalizeArguments),
    /// The verdict on every state of a study, with numbers, into a Zarr store that can be interrupted and gone on with.
    Map(MapArguments),
    /// Along standard loadings, where does each notion of stability end: ellipticity, Hill, Drucker, Baker-Ericksen, largest load, ...?
    #[command(after_help = keys())]
    Notions(NotionsArguments),
    /// The safe range of a law on one page: the stretches within which it is strongly elliptic.
    #[command(after_help = keys())]
    Card(CardArguments),
    /// What there is to choose from, with formulas, parameters and sources.
    List {
        /// materials, methods, arrangements, kernels, approximations, quadratures, frames, backgrounds, lattices, support-sizes,
        /// linearizations, or formula for the language of typed laws; everything when left out.
        topic: Option<String>,
        /// Print one JSON document.
        #[arg(long)]
        json: bool,
    },
    /// Is a study file valid, what does it ask for, and what about it deserves attention?
    Check {
        /// Study files, - for standard input.
        #[arg(value_name = "FILE", required = true)]
        files: Vec<PathBuf>,
        /// Set a key of the study otherwise, for example map.tile=128 (may be given several times).
        #[arg(long = "set", value_name = "KEY=VALUE")]
        assignments: Vec<String>,
        /// Print one JSON document: a list with an entry for each file.
        #[arg(long)]
        json: bool,
        /// What the file may load.
        #[command(flatten)]
        trust: TrustArguments,
    },
    /// Where in the plane of a study do material and particles lose stability, and how far are the two apart?
    Boundary {
        /// A study file with two axes, - for standard input.
        file: PathBuf,
        /// Set a key of the study otherwise, for example discretization.support=1.6 (may be given several times).
        #[arg(long = "set", value_name = "KEY=VALUE")]
        assignments: Vec<String>,
        /// Tell flutter from divergence: trace the boundary between them too.
        #[arg(long)]
        flutter: bool,
        /// Folder for boundary.geojson and boundary.csv.
        #[arg(long, value_name = "DIR", default_value = ".")]
        out: PathBuf,
        /// Print one JSON document, numbers with 17 significant digits.
        #[arg(long)]
        json: bool,
        /// What the file may load.
        #[command(flatten)]
        trust: TrustArguments,
    },
    /// Several methods side by side for one material: spurious modes, errors of frequencies, onsets, fidelity, time step, cost.
    #[command(after_help = comparison_keys())]
    Compare(CompareArguments),
    /// Which method for this material and these stretches? Methods ranked by rules that are printed.
    #[command(after_help = comparison_keys())]
    Recommend(RecommendArguments),
    /// Which waves of the undeformed body does a method not resist? Zero-energy modes and weak ones, drawn, animated, exported.
    #[command(after_help = keys())]
    Modes(ModesArguments),
    /// The smallest coefficient of a stabilization that removes the spurious modes and does not hide the material's instability.
    #[command(after_help = keys())]
    Tune(TuneArguments),
    /// Draw stored maps: verdicts with the boundaries of material and particles, or a field; several stores in one overlay.
    Plot(PlotArguments),
    /// Is a material what its author believes: does its stress follow from an energy, and which tangent is its tangent?
    #[command(after_help = keys())]
    Audit(AuditArguments),
    /// Print the Fortran source of Abaqus's utility routines (SINV, SPRINC, ROTSIG, XIT, ...), to compile with a UMAT that calls
    /// them.
    UmatUtilities,
    /// Print the JSON Schema of study files, for editors and other programs.
    Schema,
    /// Reproduce the paper: every figure, and a table with a verdict on every claim.
    Reproduce {
        /// Folder for figures, data and the report.
        #[arg(long, value_name = "DIR", default_value = "reproduction")]
        out: PathBuf,
        /// Print one JSON document instead of the table.
        #[arg(long)]
        json: bool,
    },
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
    known.ok_or_else(|| {
        let names = ColorMap::ALL.map(ColorMap::name);
        format!("available are {}", names.join(", "))
    })
}

/// What files may load.
#[derive(Clone, Debug, Args)]
pub struct TrustArguments {
    /// Let a file load this library (material.library), or one in this folder: a library is a program, which runs with your rights. The
    /// variable ONSET_ALLOW_LIBRARY does so for good. (May be given several times.)
    #[arg(long = "allow-library", value_name = "PATH")]
    pub libraries: Vec<PathBuf>,
}

/// A law, and the stretches of interest.
#[derive(Debug, Args)]
pub struct LawArguments {
    /// A study file whose law is meant, - for standard input [default: the law of --set alone].
    pub file: Option<PathBuf>,
    /// Set a key, for example material.model=blatz-ko (may be given several times).
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub assignments: Vec<String>,
    /// The energy of a law of one's own, for example "mu/2*(I1 - 3 - 2*ln(J))"; its parameters are set by
    /// --set material.mu=1. Short for material.model=formula and material.energy.
    #[arg(long, value_name = "FORMULA", allow_hyphen_values = true)]
    pub energy: Option<String>,
    /// The smallest and the largest stretch.
    #[arg(long, value_name = "A,B", default_value = "0.1,10", value_parser = stretches)]
    pub range: Stretches,
    /// Print one JSON document, numbers with 17 significant digits.
    #[arg(long)]
    pub json: bool,
    /// What the file may load.
    #[command(flatten)]
    pub trust: TrustArguments,
}

/// Notions of stability.
#[derive(Debug, Args)]
pub struct NotionsArguments {
    /// The law.
    #[command(flatten)]
    pub law: LawArguments,
    /// Only loadings of this mode: uniaxial, equibiaxial, planar, simple-shear or hydrostatic (may be given several times).
    #[arg(long = "mode", value_name = "MODE", value_parser = mode)]
    pub modes: Vec<Mode>,
    /// Folder for notions.svg and notions.png; no figure when left out.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// A card.
#[derive(Debug, Args)]
pub struct CardArguments {
    /// The law.
    #[command(flatten)]
    pub law: LawArguments,
    /// Folder for card.html, card.json, card.svg and card.png.
    #[arg(long, value_name = "DIR", default_value = ".")]
    pub out: PathBuf,
}

/// A comparison.
#[derive(Debug, Args)]
pub struct CompareArguments {
    /// The comparison: a material and `[[methods]]`; or a study, whose method is compared with those that the program knows;
    /// - for standard input.
    pub file: PathBuf,
    /// Folder for compare.html, compare.csv, compare.svg and compare.png.
    #[arg(long, value_name = "DIR", default_value = ".")]
    pub out: PathBuf,
    /// Show no progress, print nothing but errors.
    #[arg(long)]
    pub quiet: bool,
    /// Print one JSON document, numbers with 17 significant digits.
    #[arg(long)]
    pub json: bool,
    /// Set a key of what all methods have in common, for example material.model=blatz-ko (may be given several times).
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub assignments: Vec<String>,
    /// What the file may load.
    #[command(flatten)]
    pub trust: TrustArguments,
}

/// A question for spurious modes.
#[derive(Debug, Args)]
pub struct ModesArguments {
    /// The problem.
    #[command(flatten)]
    pub problem: ProblemArguments,
    /// List waves slower than this share of the material's slowest wave.
    #[arg(long, value_name = "SHARE", default_value_t = 0.5, value_parser = share)]
    pub weak: f64,
    /// Cells of the patch that is drawn and exported, along each primitive vector.
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u16).range(1..=512))]
    pub cells: u16,
    /// Largest displacement of the exported fields, in spacings of the particles.
    #[arg(long, value_name = "A", default_value_t = 0.2, value_parser = share)]
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
    /// Folder for tune.csv, tune.svg and tune.png; nothing is written without it.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Show no progress.
    #[arg(long)]
    pub quiet: bool,
}

/// A share as typed.
fn share(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(number) if number > 0.0 && number <= 1.0 => Ok(number),
        _ => Err("expected a number above 0 and at most 1, for example 0.5".to_owned()),
    }
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
    /// The methods to choose from, as for `compare` [default: those that the program knows for the dimension].
    pub file: Option<PathBuf>,
    /// Number of space dimensions, where no file says it.
    #[arg(long, value_name = "D", default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=3), conflicts_with = "file")]
    pub dimension: u8,
    /// Smallest and largest stretch that the simulation will see, for example 0.8,1.6; short for compare.stretches.
    #[arg(long, value_name = "LOW,HIGH", value_parser = window, allow_hyphen_values = true)]
    pub stretches: Option<(f64, f64)>,
    /// The energy of a law of one's own; short for material.model=formula and material.energy.
    #[arg(long, value_name = "FORMULA", allow_hyphen_values = true)]
    pub energy: Option<String>,
    /// Folder for the whole comparison as compare.html, compare.csv, compare.svg and compare.png; nothing is written without it.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Show no progress.
    #[arg(long)]
    pub quiet: bool,
    /// Print one JSON document, numbers with 17 significant digits.
    #[arg(long)]
    pub json: bool,
    /// Set a key of what all methods have in common, for example material.model=blatz-ko (may be given several times).
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub assignments: Vec<String>,
    /// What the file may load.
    #[command(flatten)]
    pub trust: TrustArguments,
}

/// A map.
#[derive(Debug, Args)]
pub struct MapArguments {
    /// The study, - for standard input.
    pub file: PathBuf,
    /// Folder of the store [default: the name of the study file, with .zarr, in the current folder].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Compute these tiles only, A to B - 1; several processes may do parts of one store at the same time. Tiles that are done
    /// are kept.
    #[arg(long, value_name = "A..B", value_parser = tiles)]
    pub tiles: Option<Range<usize>>,
    /// Go on with a store of the same study; make it where there is none.
    #[arg(long)]
    pub resume: bool,
    /// Replace a store of onset, whatever it holds.
    #[arg(long, conflicts_with_all = ["resume", "tiles"])]
    pub overwrite: bool,
    /// Print nothing but errors.
    #[arg(long)]
    pub quiet: bool,
    /// Print one JSON document, numbers with 17 significant digits.
    #[arg(long)]
    pub json: bool,
    /// Set a key of the study, for example discretization.support=1.6 or map.adaptive=true (may be given several times).
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub assignments: Vec<String>,
    /// What the file may load.
    #[command(flatten)]
    pub trust: TrustArguments,
}

/// A plastic material and its loading.
#[derive(Debug, Args)]
pub struct LocalizeArguments {
    /// Yield surface and flow rule: drucker-prager or j2; short for --set plasticity.model=MODEL.
    #[arg(long, value_name = "MODEL")]
    pub model: Option<String>,
    /// uniaxial-stress, uniaxial-strain, plane-strain, pure-shear or triaxial-compression; short for
    /// --set plasticity.path=PATH.
    #[arg(long, value_name = "PATH")]
    pub path: Option<String>,
    /// tension or compression; short for --set plasticity.load=LOAD.
    #[arg(long, value_name = "LOAD")]
    pub load: Option<String>,
    /// Set a parameter, for example plasticity.friction=0.7 (may be given several times).
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub assignments: Vec<String>,
    /// Folder for localize.svg, localize.png, localize.csv and localize-directions.csv; nothing is written without it.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print one JSON document, numbers with 17 significant digits.
    #[arg(long)]
    pub json: bool,
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

/// A mode of loading as typed.
fn mode(text: &str) -> Result<Mode, String> {
    let named = Mode::ALL.into_iter().find(|mode| mode.name() == text);
    named.ok_or_else(|| {
        let names = Mode::ALL.map(Mode::name);
        format!("expected one of {}", names.join(", "))
    })
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

/// A convention as typed.
fn convention(text: &str) -> Result<Convention, String> {
    Convention::of_name(text).ok_or_else(|| {
        let names = Convention::ALL.map(Convention::name);
        format!("expected one of {}", names.join(", "))
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

/// A range of tiles as typed.
fn tiles(text: &str) -> Result<Range<usize>, String> {
    let range = text.split_once("..").and_then(|(start, end)| {
        let number = |text: &str| text.trim().parse::<usize>().ok();
        Some(number(start)?..number(end)?)
    });
    match range {
        Some(range) if range.start < range.end => Ok(range),
        _ => {
            Err("expected the first tile and the one after the last, for example 0..64".to_owned())
        }
    }
}

/// Material and discretization.
#[derive(Debug, Args)]
pub struct ProblemArguments {
    /// A study file whose material and discretization are meant, - for standard input [default: those of --set alone].
    pub file: Option<PathBuf>,
    /// Set a key, for example discretization.support=1.6 (may be given several times).
    #[arg(long = "set", value_name = "KEY=VALUE", help_heading = "Problem")]
    pub assignments: Vec<String>,
    /// The energy of a law of one's own, for example "mu/2*(I1 - 3 - 2*ln(J))"; its parameters are set by
    /// --set material.mu=1. Short for material.model=formula and material.energy.
    #[arg(
        long,
        value_name = "FORMULA",
        allow_hyphen_values = true,
        help_heading = "Problem"
    )]
    pub energy: Option<String>,
    /// Print one JSON document, numbers with 17 significant digits.
    #[arg(long)]
    pub json: bool,
    /// What the file may load.
    #[command(flatten)]
    pub trust: TrustArguments,
}

/// The state.
#[derive(Debug, Args)]
#[group(required = true, multiple = false)]
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
