//! Figures of stored maps: verdicts with both boundaries, fields of numbers, and several discretizations in one.

mod lines;
mod overlay;
mod stored;

use crate::boundary::{Boundaries, BoundaryError, Watch};
use crate::domain::{Class, Domain};
use crate::figure::{Axis, ColorMap, Field, Figure, Layer, Panel, Regions, palette};
use crate::number::counted;
use crate::settings::{Effective, Quantity, SettingError, Study, Trust};
use crate::store::StoreError;
use onset::verdict::Verdict;
use std::path::PathBuf;
use stored::{Slice, StoredMap};
use thiserror::Error;

/// Panels of a map with three axes.
const SLICES: usize = 6;
/// The field of time steps.
const STEP: &str = "critical_time_step";
/// Numbers below this share of what they are made of are rounding.
const ROUNDING: f64 = 1e-12;
/// The field that shows verdicts.
const VERDICT: &str = "verdict";

/// Why boundaries are coarser than they could be.
const NOT_LOADED: &str =
    "Boundaries are the edges of cells: the library of the material was not loaded.";

/// What to draw.
#[derive(Clone, Copy, Debug)]
pub struct Plot<'a> {
    /// The stores.
    pub stores: &'a [PathBuf],
    /// `verdict`, `certainty`, `certainty_material`, or the name of a field of numbers.
    pub field: &'a str,
    /// How the boundaries are found.
    pub boundaries: Lines,
    /// How it looks.
    pub look: Look<'a>,
}

/// How the boundaries in a figure are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lines {
    /// Traced, unless that takes too long or leaves gaps, or an axis varies material or method, of which each costs a preparation; then
    /// as the edges of cells.
    #[default]
    Best,
    /// Traced as far as they can be followed, however long it takes.
    Traced,
    /// The edges of cells.
    OfCells,
}

/// How a figure looks, where not as usual.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Look<'a> {
    /// Its title.
    pub title: Option<&'a str>,
    /// Width and height of a panel in pixels of 1/96 inch.
    pub size: Option<(f64, f64)>,
    /// The ends of the horizontal axis.
    pub x: Option<(f64, f64)>,
    /// The ends of the vertical axis.
    pub y: Option<(f64, f64)>,
    /// The numbers at the ends of the color bar.
    pub range: Option<(f64, f64)>,
    /// The colors of a field of numbers.
    pub color_map: Option<ColorMap>,
}

impl Look<'_> {
    /// A figure with this look.
    fn applied(&self, mut figure: Figure) -> Figure {
        if let Some(title) = self.title {
            title.clone_into(&mut figure.title);
        }
        figure.panel_size = self.size;
        for panel in &mut figure.panels {
            panel.x.range = self.x.unwrap_or(panel.x.range);
            panel.y.range = self.y.unwrap_or(panel.y.range);
            let fields = panel.layers.iter_mut().filter_map(|layer| match layer {
                Layer::Field(field) => Some(field),
                _ => None,
            });
            for field in fields {
                field.range = self.range.or(field.range);
                field.map = self.color_map.unwrap_or(field.map);
            }
        }
        figure
    }
}

/// Why a map cannot be drawn.
#[derive(Debug, Error)]
pub enum PlotError {
    /// The store.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The study in the attributes of the store.
    #[error("{}: the study in its attributes is not valid: {source}", path.display())]
    Study {
        /// The store.
        path: PathBuf,
        /// What is wrong.
        source: SettingError,
    },
    /// Something else than a map.
    #[error(
        "{} is not a store of results\n  hint: give the folder of a map, as `onset map STUDY.toml --out map.zarr` writes it", path.display()
    )]
    NotAMap {
        /// What is there.
        path: PathBuf,
    },
    /// A boundary.
    #[error(transparent)]
    Boundary(#[from] BoundaryError),
    /// A field that cannot be shown.
    #[error(
        "the field `{field}` cannot be shown as a map\n  hint: fields that can are {}", known.join(", ")
    )]
    NotShown {
        /// The field.
        field: String,
        /// Those that can.
        known: Vec<String>,
    },
    /// Maps that do not fit on each other.
    #[error("{} does not fit on {}: {difference}\n  hint: overlay maps of one material over the same two axes", path.display(), first.display())]
    NotComparable {
        /// The first store.
        first: PathBuf,
        /// The other one.
        path: PathBuf,
        /// What differs.
        difference: &'static str,
    },
}

impl PlotError {
    /// Whether what was asked for is wrong, and not the machine.
    pub fn is_input(&self) -> bool {
        match self {
            Self::Store(error) => error.is_input(),
            _ => true,
        }
    }
}

/// The figure of one or several stores: verdicts of several are overlaid, fields stand side by side. No library that a store names
/// is loaded; boundaries of its material are the edges of cells.
///
/// # Errors
/// [`PlotError`] when a store cannot be read, has no such field, or does not fit on the others.
pub fn plot(plot: &Plot<'_>, watch: &dyn Watch) -> Result<Figure, PlotError> {
    plot_allowing(plot, &Trust::default(), watch)
}

/// The same, with the libraries loaded that the user allows.
///
/// # Errors
/// As for [`plot`].
pub fn plot_allowing(
    plot: &Plot<'_>,
    trust: &Trust,
    watch: &dyn Watch,
) -> Result<Figure, PlotError> {
    let maps: Vec<StoredMap> = plot
        .stores
        .iter()
        .map(|path| StoredMap::open(path, trust))
        .collect::<Result<_, _>>()?;
    let captions = captions(&maps);
    let may_trace = maps.iter().all(StoredMap::may_be_evaluated);
    let plot = &Plot {
        boundaries: if may_trace {
            plot.boundaries
        } else {
            Lines::OfCells
        },
        ..*plot
    };
    let figure = match &maps[..] {
        [map] => single(map, plot, watch)?,
        [] => Figure::default(),
        _ if plot.field == VERDICT => {
            let figure = overlay::overlay(&maps, plot.boundaries, watch)?;
            let caption = format!("{} {captions}", figure.caption);
            figure.caption(caption.trim_start())
        }
        _ => {
            let slices = maps.iter().flat_map(|map| {
                let slices = map.slices(SLICES).into_iter();
                slices.map(move |slice| {
                    let title = match &slice.title {
                        Some(value) => format!("{}, {value}", map.title()),
                        None => map.title(),
                    };
                    (map, slice, title)
                })
            });
            let figure = Figure::new("").columns(maps.len().min(3));
            panels(figure, &slices.collect::<Vec<_>>(), plot, watch)?.caption(captions)
        }
    };
    Ok(plot.look.applied(figure))
}

/// A stored map as cells: all of one with two axes, of one with three the section in the middle of the third.
pub struct Section {
    /// The title of its study; the name of the folder when it has none.
    pub title: String,
    /// Where on the third axis it is.
    pub name: Option<String>,
    /// The study of the section.
    pub study: Study,
    /// Cells along both axes; of a finer map every n-th state is one.
    pub cells: (usize, usize),
    /// The classes of the cells, the first axis running fastest; `None` where they are still to be computed.
    pub classes: Vec<Option<Class>>,
}

impl Section {
    /// The section in the middle of a store; no library is loaded.
    ///
    /// # Errors
    /// [`PlotError`] when it cannot be read.
    pub fn middle(path: &std::path::Path) -> Result<Self, PlotError> {
        let map = StoredMap::open(path, &Trust::default())?;
        let slice = map.slices(1).remove(0);
        let (cells, classes) = map.classes(&slice)?;
        Ok(Self {
            title: map.title(),
            name: slice.title,
            study: slice.study,
            cells,
            classes,
        })
    }
}

/// The figure of a map that is not stored, with its boundaries where they are known.
pub fn figure_of(map: &Domain, boundaries: Option<&Boundaries>) -> Figure {
    let panel = axes(&map.study, "").with(map.layer());
    let lines = boundaries.map(lines::traced).unwrap_or_default();
    let panel = lines.into_iter().fold(panel, Panel::with);
    Figure::new(map.study.title.clone())
        .columns(1)
        .with(panel)
        .caption(map.study.effective().caption())
}

/// What maps are of: what they have in common, and what of each is its own.
fn captions(maps: &[StoredMap]) -> String {
    let effective: Vec<Effective> = maps.iter().map(|map| map.study.effective()).collect();
    let Some(first) = effective.first() else {
        return String::new();
    };
    let is_common = |name: &str| effective.iter().all(|own| own.get(name) == first.get(name));
    let common = first.clone().only(&is_common).caption();
    let own = maps.iter().zip(&effective).map(|(map, effective)| {
        match effective.clone().only(&|name| !is_common(name)).told() {
            told if told.is_empty() => String::new(),
            told => format!(" {}: {told}.", map.title()),
        }
    });
    common + &own.collect::<String>()
}

fn single(map: &StoredMap, plot: &Plot<'_>, watch: &dyn Watch) -> Result<Figure, PlotError> {
    let slices = map.slices(SLICES);
    let figure = Figure::new(map.title()).columns(slices.len().min(3));
    let slices = slices.into_iter().map(|slice| {
        let title = slice.title.clone().unwrap_or_default();
        (map, slice, title)
    });
    let figure = panels(figure, &slices.collect::<Vec<_>>(), plot, watch)?;
    let mut caption = map.settings();
    let missing = map.missing()?;
    if missing > 0 {
        caption = format!(
            "White: {} of the map still to be computed. {caption}",
            counted(missing, "tile")
        );
    }
    if !map.may_be_evaluated() {
        caption = format!("{NOT_LOADED} {caption}");
    }
    Ok(figure.caption(caption))
}

/// Axes in the plane of a study.
fn axes(study: &Study, title: &str) -> Panel {
    let [first, second] = study.plane();
    let units = study.settings.units();
    let panel = Panel::new(
        title,
        Axis::linear(first.label(units), first.range),
        Axis::linear(second.label(units), second.range),
    );
    let is_stretch = |quantity: Quantity| matches!(quantity, Quantity::Stretch(_));
    if is_stretch(first.quantity) && is_stretch(second.quantity) {
        panel.equal_aspect()
    } else {
        panel
    }
}

/// A figure with sections of maps, each with a title, and their boundaries.
fn panels(
    figure: Figure,
    slices: &[(&StoredMap, Slice, String)],
    plot: &Plot<'_>,
    watch: &dyn Watch,
) -> Result<Figure, PlotError> {
    let studies = slices.iter().map(|(_, slice, _)| &slice.study);
    let traced = lines::boundaries(studies, plot.boundaries, watch)?;
    let mut figure = figure;
    for (n, (map, slice, title)) in slices.iter().enumerate() {
        let lines = match &traced {
            Some(traced) => lines::traced(&traced[n]),
            None => lines::of_cells(map, slice)?,
        };
        let panel = panel(map, slice, plot, title)?;
        figure = figure.with(lines.into_iter().fold(panel, Panel::with));
    }
    share_colors(&mut figure);
    Ok(figure)
}

/// One scale of colors for the fields of all panels, so that they can be compared.
fn share_colors(figure: &mut Figure) {
    let layers = figure.panels.iter_mut().flat_map(|panel| &mut panel.layers);
    let mut fields: Vec<&mut Field> = layers
        .filter_map(|layer| match layer {
            Layer::Field(field) => Some(field),
            _ => None,
        })
        .collect();
    let ranges = fields.iter().filter_map(|field| field.range);
    let range = ranges.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
    let is_signed = fields.iter().any(|field| field.map == ColorMap::Diverging);
    for field in &mut fields {
        field.range = range.or(field.range);
        if is_signed {
            field.map = ColorMap::Diverging;
        }
    }
}

/// One map.
fn panel(map: &StoredMap, slice: &Slice, plot: &Plot<'_>, title: &str) -> Result<Panel, PlotError> {
    let [first, second] = slice.study.plane();
    let panel = axes(&slice.study, title);
    Ok(if plot.field == VERDICT {
        let (cells, classes) = map.classes(slice)?;
        let index = |class: &Option<Class>| {
            let place = Class::ALL.iter().position(|other| Some(*other) == *class);
            place.map_or(u8::MAX, |place| place as u8)
        };
        let key = Class::ALL.map(|class| (class.title().to_owned(), class.color()));
        panel.with(Regions::new(
            first.range,
            second.range,
            cells,
            classes.iter().map(index).collect(),
            key,
        ))
    } else if let Some(words) = map.words(plot.field) {
        panel.with(proofs(map, slice, plot.field, &words)?)
    } else {
        panel.with(field(map, slice, plot.field)?)
    })
}

/// What is proved, in words; white where it is still to be computed.
fn proofs(
    map: &StoredMap,
    slice: &Slice,
    name: &str,
    words: &[&'static str],
) -> Result<Regions, PlotError> {
    let [first, second] = slice.study.plane();
    let (cells, flags) = map.numbers(slice, name)?;
    let class = |flag: &f64| match *flag {
        flag if flag >= 0.0 => flag as u8,
        _ => u8::MAX,
    };
    let key = words
        .iter()
        .map(|word| (word.replace('-', " "), palette::certainty(word)));
    Ok(Regions::new(
        first.range,
        second.range,
        cells,
        flags.iter().map(class).collect(),
        key,
    ))
}

/// What the numbers of a field are made of: beside it smaller ones are rounding. Zero where that is not known.
fn sizes(map: &StoredMap, slice: &Slice, name: &str) -> Result<Vec<f64>, PlotError> {
    let (_, values) = map.numbers(slice, name)?;
    Ok(match name {
        "scaled_minimum" => vec![1.0; values.len()],
        // The largest omega^2 is (2 / step)^2.
        "lowest_omega_squared" if map.holds(STEP) => {
            let (_, steps) = map.numbers(slice, STEP)?;
            steps.iter().map(|step| (2.0 / step).powi(2)).collect()
        }
        _ => vec![0.0; values.len()],
    })
}

/// A field of numbers over the range of most of them.
fn field(map: &StoredMap, slice: &Slice, name: &str) -> Result<Field, PlotError> {
    let label = map.label(name)?;
    let [first, second] = slice.study.plane();
    let (cells, mut values) = map.numbers(slice, name)?;
    for (value, size) in values.iter_mut().zip(sizes(map, slice, name)?) {
        if value.abs() <= ROUNDING * size {
            *value = 0.0;
        }
    }
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    // A few extreme states would leave one color to all others.
    let at = |share: f64| sorted.get((share * sorted.len() as f64) as usize).copied();
    let is_signed = sorted.first().is_some_and(|low| *low < 0.0);
    let field = Field::new(first.range, second.range, cells, values, label);
    let field = match (at(0.01), at(0.99)) {
        (Some(low), Some(high)) if low < high => field.range(low, high),
        _ => field,
    };
    Ok(if is_signed { field.diverging() } else { field })
}

/// Whether no wave of the material grows, as far as the verdict says.
fn is_elliptic(verdict: Verdict) -> Option<bool> {
    match verdict {
        Verdict::Stable | Verdict::ZeroEnergy => Some(true),
        Verdict::Physical | Verdict::Suppressed => Some(false),
        Verdict::Numerical => None,
    }
}
