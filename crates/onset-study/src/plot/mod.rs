//! Figures of stored maps: verdicts with both boundaries, fields of numbers, and several discretizations in one figure.

mod lines;
mod overlay;
mod stored;

use crate::boundary::{Boundaries, BoundaryError, Watch};
use crate::caption;
use crate::domain::{Class, Domain};
use crate::figure::{Axis, ColorMap, Field, Figure, Layer, Panel, Regions, palette};
use crate::number::counted;
use crate::settings::{Effective, Quantity, SettingError, Study, Trust};
use crate::store::StoreError;
use onset::verdict::Verdict;
use serde::Serialize;
use std::fmt;
use std::path::PathBuf;
use stored::{Slice, StoredMap};
use thiserror::Error;

/// Maximum number of panels for a map with three axes.
const SLICES: usize = 6;
/// Name of the field of critical time steps.
const STEP_FIELD: &str = "critical_time_step";
/// Numbers below this fraction of their scale are rounding errors.
const ROUNDING_FRACTION: f64 = 1e-12;
/// Name of the field of verdicts.
const VERDICT: &str = "verdict";
/// Field that marks the states that an adaptive map evaluated.
const EVALUATED: &str = "evaluated";

/// Note on boundaries that are drawn along cells instead of being traced.
const NOT_LOADED: &str =
    "Boundaries are the edges of cells: the library of the material was not loaded.";

/// Stores, field and appearance of a plot.
#[derive(Clone, Copy, Debug)]
pub struct Plot<'a> {
    /// Folders of the stores.
    pub stores: &'a [PathBuf],
    /// `verdict`, `certainty`, `certainty_material`, or the name of a field of numbers.
    pub field: &'a str,
    /// Source of the boundaries.
    pub boundaries: Lines,
    /// Changes to the usual appearance.
    pub look: Look,
}

/// Source of the boundaries in a figure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lines {
    /// Traced curves, or the edges of cells if tracing takes too long or leaves gaps, or if an axis varies the material or the method, so that each
    /// state would need a separate preparation.
    #[default]
    Best,
    /// Traced curves, without a time limit and even with gaps.
    Traced,
    /// Edges of cells, without tracing.
    OfCells,
}

/// Changes to the usual appearance of a figure.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Look {
    /// Ends of the horizontal axis; `None` for the range of the map.
    pub x: Option<(f64, f64)>,
    /// Ends of the vertical axis; `None` for the range of the map.
    pub y: Option<(f64, f64)>,
    /// Values at the ends of the color bar; `None` for the limits of the middle 99 % of the values.
    pub range: Option<(f64, f64)>,
    /// Color map of a field of numbers; `None` for the default of the field.
    pub color_map: Option<ColorMap>,
}

impl Look {
    /// Applies the changes to a figure.
    ///
    /// # Errors
    /// [`PlotError::NoColorBar`] when a change of the color bar has nothing to change.
    fn applied(&self, mut figure: Figure) -> Result<Figure, PlotError> {
        let mut has_color_bar = false;
        for panel in &mut figure.panels {
            panel.x.range = self.x.unwrap_or(panel.x.range);
            panel.y.range = self.y.unwrap_or(panel.y.range);
            let fields = panel.layers.iter_mut().filter_map(|layer| match layer {
                Layer::Field(field) => Some(field),
                _ => None,
            });
            for field in fields {
                has_color_bar = true;
                field.range = self.range.or(field.range);
                field.map = self.color_map.unwrap_or(field.map);
            }
        }
        let without = match (self.range, self.color_map) {
            (Some(_), _) => "--limits",
            (None, Some(_)) => "--color-map",
            (None, None) => return Ok(figure),
        };
        match has_color_bar {
            true => Ok(figure),
            false => Err(PlotError::NoColorBar(without)),
        }
    }
}

/// Reasons why a map cannot be drawn.
#[derive(Debug, Error)]
pub enum PlotError {
    /// A store cannot be read.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The study in the attributes of the store is not valid.
    #[error("{}: the study in its attributes is not valid: {source}", path.display())]
    Study {
        /// Folder of the store.
        path: PathBuf,
        /// Cause of the failure.
        source: SettingError,
    },
    /// The path is not a store of results.
    #[error(
        "{} is not a store of results\n  hint: give the folder of a map, as `onset map STUDY.toml --out map.zarr` writes it", path.display()
    )]
    NotAMap {
        /// Path that was given.
        path: PathBuf,
    },
    /// A boundary cannot be traced.
    #[error(transparent)]
    Boundary(#[from] BoundaryError),
    /// The field cannot be shown as a map.
    #[error(
        "the field `{field}` cannot be shown as a map\n  hint: available fields: {}", known.join(", ")
    )]
    NotShown {
        /// Name of the field.
        field: String,
        /// Names of the fields that can be shown.
        known: Vec<String>,
    },
    /// The figure has no color bar.
    #[error(
        "{0} has no effect: this figure has no color bar\n  hint: choose a field of numbers with --field, or the ends of the axes with --x-limits and --y-limits"
    )]
    NoColorBar(&'static str),
    /// The maps cannot be overlaid.
    #[error("{} does not fit on {}: {difference}\n  hint: overlay maps of one material over the same two axes", path.display(), first.display())]
    NotComparable {
        /// Folder of the first store.
        first: PathBuf,
        /// Folder of the store that does not match.
        path: PathBuf,
        /// Difference between the two stores.
        difference: &'static str,
    },
}

impl PlotError {
    /// Returns true for an error in the input, false for a failure of the machine.
    pub fn is_input(&self) -> bool {
        match self {
            Self::Store(error) => error.is_input(),
            _ => true,
        }
    }
}

/// Figure of stored maps, with a list of incomplete stores.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawn {
    /// Figure of the maps.
    pub figure: Figure,
    /// Stores with tiles that are not yet computed.
    pub unfinished: Vec<Unfinished>,
    /// Whether the boundaries are edges of cells, because they were not traced within the time limit or without gaps.
    pub has_edges: bool,
}

/// Store with tiles that are not yet computed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Unfinished {
    /// Path of the store.
    pub store: PathBuf,
    /// Number of tiles not yet computed.
    pub tiles_left: usize,
    /// Total number of tiles.
    pub tiles: usize,
}

impl fmt::Display for Unfinished {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let tiles = counted(self.tiles, "tile");
        write!(
            formatter,
            "{} of {tiles} remain to be computed",
            self.tiles_left
        )
    }
}

/// Draws one or several stores: verdicts of several stores are overlaid, fields are drawn in adjacent panels.
///
/// No library that a store names is loaded; the boundaries of such a material are the edges of cells.
///
/// # Errors
/// [`PlotError`] when a store cannot be read, lacks the field, or cannot be overlaid on the others.
pub fn plot(plot: &Plot<'_>, watch: &dyn Watch) -> Result<Figure, PlotError> {
    Ok(plot_allowing(plot, &Trust::default(), watch)?.figure)
}

/// Draws like [`plot`], loads the libraries that the user allows, and lists unfinished stores.
///
/// # Errors
/// Fails like [`plot`].
pub fn plot_allowing(
    plot: &Plot<'_>,
    trust: &Trust,
    watch: &dyn Watch,
) -> Result<Drawn, PlotError> {
    let maps: Vec<StoredMap> = plot
        .stores
        .iter()
        .map(|path| StoredMap::open(path, trust))
        .collect::<Result<_, _>>()?;
    let unfinished = maps.iter().map(StoredMap::unfinished);
    let unfinished = unfinished.collect::<Result<Vec<_>, _>>()?;
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
    let (figure, is_traced) = match &maps[..] {
        [map] => single(map, plot, watch)?,
        [] => (Figure::default(), true),
        _ if plot.field == VERDICT => {
            let (figure, is_traced) = overlay::overlay(&maps, plot.boundaries, watch)?;
            let caption = format!("{} {captions}", figure.caption);
            (figure.caption(caption.trim_start()), is_traced)
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
            let (figure, is_traced) = panels(figure, &slices.collect::<Vec<_>>(), plot, watch)?;
            (figure.caption(captions), is_traced)
        }
    };
    let mut figure = plot.look.applied(figure)?;
    for (map, unfinished) in maps.iter().zip(&unfinished).rev() {
        let Some(unfinished) = unfinished else {
            continue;
        };
        let place = match maps.len() {
            1 => "White".to_owned(),
            _ => map.title(),
        };
        figure.caption = format!("{place}: {unfinished}. {}", figure.caption);
    }
    Ok(Drawn {
        figure,
        unfinished: unfinished.into_iter().flatten().collect(),
        has_edges: plot.boundaries == Lines::Best && !is_traced,
    })
}

/// Cells of a stored map: all cells of a map with two axes, or the section in the middle of the third axis.
pub struct Section {
    /// Title of the study, or the name of the folder if the study has no title.
    pub title: String,
    /// Position of the section on the third axis; `None` for a map with two axes.
    pub name: Option<String>,
    /// Study of the section.
    pub study: Study,
    /// Number of cells along both axes; finer maps are thinned to every n-th state.
    pub cells: (usize, usize),
    /// Classes of the cells, the first axis running fastest; `None` for cells not yet computed.
    pub classes: Vec<Option<Class>>,
}

impl Section {
    /// Reads the middle section of a store; no library is loaded.
    ///
    /// # Errors
    /// [`PlotError`] when the store cannot be read.
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

/// Figure of a map that is not stored, with its boundaries if they are known.
pub fn figure_of(map: &Domain, boundaries: Option<&Boundaries>) -> Figure {
    let panel = axes(&map.study, "").with(map.layer());
    let lines = boundaries.map(lines::traced).unwrap_or_default();
    let panel = lines.into_iter().fold(panel, Panel::with);
    Figure::new(map.study.title.clone())
        .columns(1)
        .with(panel)
        .caption(caption::settings(&map.study.effective()))
}

/// Caption with the settings that all maps share, and the remaining settings of each map.
fn captions(maps: &[StoredMap]) -> String {
    let effective: Vec<Effective> = maps.iter().map(|map| map.study.effective()).collect();
    let Some(first) = effective.first() else {
        return String::new();
    };
    let is_common = |name: &str| effective.iter().all(|own| own.get(name) == first.get(name));
    let common = caption::settings(&first.clone().only(&is_common));
    let own = maps.iter().zip(&effective).map(|(map, effective)| {
        match effective.clone().only(&|name| !is_common(name)).told() {
            told if told.is_empty() => String::new(),
            told => format!(" {}: {told}.", map.title()),
        }
    });
    common + &own.collect::<String>()
}

/// Figure of one map, and whether its boundaries are traced.
fn single(
    map: &StoredMap,
    plot: &Plot<'_>,
    watch: &dyn Watch,
) -> Result<(Figure, bool), PlotError> {
    let slices = map.slices(SLICES);
    let figure = Figure::new(map.title()).columns(slices.len().min(3));
    let slices = slices.into_iter().map(|slice| {
        let title = slice.title.clone().unwrap_or_default();
        (map, slice, title)
    });
    let (figure, is_traced) = panels(figure, &slices.collect::<Vec<_>>(), plot, watch)?;
    let mut caption = map.settings();
    if map.study.map.adaptive && plot.field != VERDICT && map.words(plot.field).is_none() {
        caption = format!(
            "States that were not evaluated have the color of the nearest evaluated state. {caption}"
        );
    }
    if !map.may_be_evaluated() {
        caption = format!("{NOT_LOADED} {caption}");
    }
    Ok((figure.caption(caption), is_traced))
}

/// Panel with the two axes of the study.
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

/// Adds one panel with boundaries for each section, and its title; also returns whether the boundaries are traced.
fn panels(
    figure: Figure,
    slices: &[(&StoredMap, Slice, String)],
    plot: &Plot<'_>,
    watch: &dyn Watch,
) -> Result<(Figure, bool), PlotError> {
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
    Ok((figure, traced.is_some()))
}

/// Applies one color scale to the fields of all panels, so that they can be compared.
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

/// Panel of one section: verdicts, proofs or a field of numbers.
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

/// Map of proof results; cells not yet computed are white.
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

/// Scale of the rounding error of each number of a field; zero if it is unknown.
fn sizes(map: &StoredMap, slice: &Slice, name: &str) -> Result<Vec<f64>, PlotError> {
    let (_, values) = map.numbers(slice, name)?;
    Ok(match name {
        "scaled_minimum" => vec![1.0; values.len()],
        // The largest `omega^2` is `(2 / step)^2`.
        "lowest_omega_squared" if map.holds(STEP_FIELD) => {
            let (_, steps) = map.numbers(slice, STEP_FIELD)?;
            steps.iter().map(|step| (2.0 / step).powi(2)).collect()
        }
        _ => vec![0.0; values.len()],
    })
}

/// Gives each state that an adaptive map adopted the value of the nearest evaluated state; states not yet computed and undefined values remain.
fn spread(values: &mut [f64], evaluated: &[f64], columns: usize) {
    let is = |index: usize, flag: f64| evaluated[index] == flag;
    let mut is_known: Vec<bool> = (0..values.len()).map(|index| is(index, 1.0)).collect();
    let mut front: Vec<usize> = (0..values.len()).filter(|index| is_known[*index]).collect();
    while !front.is_empty() {
        let mut next = Vec::new();
        for index in front {
            let column = index % columns;
            let sides = [
                (column > 0).then(|| index - 1),
                (column + 1 < columns).then_some(index + 1),
                index.checked_sub(columns),
                Some(index + columns).filter(|below| *below < values.len()),
            ];
            for side in sides.into_iter().flatten() {
                if !is_known[side] && is(side, 0.0) {
                    is_known[side] = true;
                    values[side] = values[index];
                    next.push(side);
                }
            }
        }
        front = next;
    }
}

/// Field of numbers with a color range from its first to its last percentile.
fn field(map: &StoredMap, slice: &Slice, name: &str) -> Result<Field, PlotError> {
    let label = map.label(name)?;
    let [first, second] = slice.study.plane();
    let (cells, mut values) = map.numbers(slice, name)?;
    for (value, size) in values.iter_mut().zip(sizes(map, slice, name)?) {
        if value.abs() <= ROUNDING_FRACTION * size {
            *value = 0.0;
        }
    }
    if map.holds(EVALUATED) {
        let (_, evaluated) = map.numbers(slice, EVALUATED)?;
        spread(&mut values, &evaluated, cells.0);
    }
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    // The percentiles ignore a few extreme states, which would leave one color to all others.
    let at = |share: f64| sorted.get((share * sorted.len() as f64) as usize).copied();
    let is_signed = sorted.first().is_some_and(|low| *low < 0.0);
    let field = Field::new(first.range, second.range, cells, values, label);
    let field = match (at(0.01), at(0.99)) {
        (Some(low), Some(high)) if low < high => field.range(low, high),
        _ => field,
    };
    Ok(if is_signed { field.diverging() } else { field })
}

/// Returns whether the material is strongly elliptic, or `None` if the verdict does not decide it.
fn is_elliptic(verdict: Verdict) -> Option<bool> {
    match verdict {
        Verdict::Stable | Verdict::ZeroEnergy => Some(true),
        Verdict::Physical | Verdict::Suppressed => Some(false),
        Verdict::Numerical => None,
    }
}

#[cfg(test)]
mod tests {
    use super::spread;

    #[test]
    fn states_that_were_not_evaluated_take_the_nearest_value() {
        let nan = f64::NAN;
        let mut values = vec![1.0, nan, nan, 3.0, nan, nan, nan, nan];
        let evaluated = [1.0, 0.0, 0.0, 1.0, 0.0, 0.0, nan, 1.0];
        spread(&mut values, &evaluated, 4);
        assert_eq!(values[..6], [1.0, 1.0, 3.0, 3.0, 1.0, 1.0]);
        // Neither a state that is not computed yet nor an undefined value changes.
        assert!(values[6].is_nan() && values[7].is_nan());
    }
}
