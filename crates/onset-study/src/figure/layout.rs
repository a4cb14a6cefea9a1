//! Layout of a figure: measures the panels, aligns them, and draws them with their axes.

use super::axis::{Scale, Tick, labels};
use super::draw::{Frame, LEVELS, field_range, level_color, shown_values};
use super::pen::{CAPITAL, INK, NUMBERS, Pen, crisp, polygon, rectangle, segment};
use super::scene::{Anchor, Paint, Scene};
use super::sheet::{MILLIMETER, Size as Asked, told_omitted};
use super::{Axis, Dash, Field, Figure, Layer, Panel, Sheet, Theme, font, legend};
use tiny_skia::PathBuilder;

/// Font sizes, in pixels.
const TITLE: f64 = 16.0;
const WORDS: f64 = 13.0;
/// Distance between baselines, in font sizes.
const LEADING: f64 = 1.3;
/// White space around the figure, around a bare figure, for which the page has margins, and between the parts.
const PADDING: f64 = 14.0;
const BARE_PADDING: f64 = 2.0;
const GAP: f64 = 18.0;
/// Length of a tick, and its distance from the label.
const TICK: f64 = 5.0;
const TICK_GAP: f64 = 4.0;
/// Distance between the baselines of named ticks, and of the lines of a name.
const NAME: f64 = 17.0;
const NAME_LEADING: f64 = 13.0;
/// Distance between the tick labels and the label of the axis.
const LABEL_GAP: f64 = 8.0;
/// Distance of the color bar from the panel, and its width.
const BAR_GAP: f64 = 12.0;
const BAR: f64 = 13.0;

/// Size of letters in a picture with a width in print, relative to the usual size: numbers have 8 pt instead of 9.
const PRINTED: f64 = 8.0 / 9.0;
/// Smallest width of panels in one row of a printed picture, of panels that share both axes, and of panels that share their named rows. Narrower
/// panels are arranged in fewer columns.
const NARROWEST: f64 = 150.0;
const NARROWEST_ALIKE: f64 = 100.0;
const NARROWEST_OF_ROWS: f64 = 80.0;
/// Smallest width of a panel, and smallest usual height for which the label of the vertical axis has few lines.
const SMALLEST_PANEL: f64 = 40.0;
const LOWEST: f64 = 120.0;
/// Heights in millimeters, and relative to the width, for printed pictures: above the first the panels are lowered, and the second is the largest
/// height, a page of a journal. The last panels are omitted if the lowest ones do not fit.
const HIGH: f64 = 180.0;
const HIGH_FOR_ITS_WIDTH: f64 = 1.6;
const HIGHEST: f64 = 230.0;
/// Heights of panels in a printed picture that is too high, relative to their usual height. Markers of a row touch in lower rows.
const LOWERED: [f64; 4] = [1.0, 0.85, 0.7, 0.55];
const LOWEST_ROWS: f64 = 0.8;
/// Largest share of the width of a printed picture that names of rows take.
const NAMES: f64 = 0.5;

/// Draws the figure on a sheet.
pub(super) fn scene(figure: &Figure, sheet: &Sheet) -> Scene {
    let title = sheet.title_of(figure).to_owned();
    let mut figure = sheet.dressed(figure);
    let width = match sheet.size {
        Some(Asked::Picture(millimeters)) => millimeters * MILLIMETER,
        _ => {
            return Scene {
                title,
                theme: sheet.theme,
                ..drawn(&figure, None, 1.0, 0.0)
            };
        }
    };
    // The panels take the room that margins and gaps leave.
    let available = width / PRINTED;
    shorten_names(&mut figure, NAMES * available);
    let caption = figure.caption.clone();
    let mut omitted = Vec::new();
    let scene = loop {
        let scene = printed(&mut figure, available);
        if height_in_print(&scene, width) <= HIGHEST || figure.panels.len() < 2 {
            break scene;
        }
        let last = figure.panels.pop();
        omitted.splice(0..0, last.map(|panel| panel.title.replace('\n', ", ")));
        if !sheet.bare {
            let told = told_omitted(&omitted).unwrap_or_default();
            figure.caption = format!("{caption} {told}").trim().to_owned();
        }
    };
    Scene {
        title,
        scale: width / scene.width,
        is_printed: true,
        theme: sheet.theme,
        omitted,
        ..scene
    }
}

/// Height in millimeters of a picture with a width in pixels.
fn height_in_print(scene: &Scene, width: f64) -> f64 {
    scene.height * width / scene.width / MILLIMETER
}

/// Divides the names of the ticks of vertical axes that are wider than `widest` into two lines if the rows are high enough, and shortens names that are
/// still wider, but keeps them distinct.
fn shorten_names(figure: &mut Figure, widest: f64) {
    let short = |name: &str| -> String {
        let mut kept: Vec<char> = name.chars().collect();
        let mut own = name.to_owned();
        while font::width(&own, NUMBERS) > widest && kept.len() > 4 {
            kept.pop();
            own = kept.iter().collect::<String>().trim_end().to_owned() + "…";
        }
        own
    };
    for panel in &mut figure.panels {
        let Some(ticks) = &mut panel.y.ticks else {
            continue;
        };
        let row = NAME * LOWEST_ROWS * panel.lines.unwrap_or(0.0) / ticks.len().max(1) as f64;
        let fitted = |name: &str| match font::wrap(name, NUMBERS, widest).as_slice() {
            [first, rest @ ..] if !rest.is_empty() && row >= 2.0 * NAME_LEADING => {
                format!("{}\n{}", short(first), short(&rest.join(" ")))
            }
            _ => short(name),
        };
        let names: Vec<String> = ticks.iter().map(|(_, name)| fitted(name)).collect();
        let others = |n: usize| names[..n].iter().chain(&names[n + 1..]);
        let is_distinct: Vec<bool> = (0..names.len())
            .map(|n| others(n).all(|other| *other != names[n]))
            .collect();
        for (((_, tick), name), is_distinct) in ticks.iter_mut().zip(&names).zip(is_distinct) {
            if is_distinct {
                tick.clone_from(name);
            }
        }
    }
}

/// Draws a figure in a width, with its panels in columns, lowered if they are too high.
fn printed(figure: &mut Figure, available: f64) -> Scene {
    let count = figure.panels.len();
    // Panels with equal rows need the names of the rows only once if they are in one row.
    let all = |is_alike: fn(&Panel, &Panel) -> bool| {
        count > 1
            && figure
                .panels
                .windows(2)
                .all(|pair| is_alike(&pair[0], &pair[1]))
    };
    let (columns, narrowest) = if all(|a, b| a.y.ticks.is_some() && shares_y(a, b)) {
        (count, NARROWEST_OF_ROWS)
    } else if all(|a, b| shares_x(a, b) && shares_y(a, b)) {
        (figure.columns, NARROWEST_ALIKE)
    } else {
        (figure.columns, NARROWEST)
    };
    figure.columns = columns.clamp(1, count.max(1));
    // A narrow panel next to a wide one, such as a density of states, does not need a separate row.
    let widest = figure.panels.iter().filter(|panel| !panel.equal_aspect);
    let widest = widest.map(|panel| panel.width).fold(1.0, f64::max);
    while widest_panel(figure, available, 1.0) * widest < narrowest && figure.columns > 1 {
        figure.columns -= 1;
    }
    let widest = widest_panel(figure, available, 1.0);
    // Labels have more lines at lower panels.
    let at = |lowered| {
        let panel = widest_panel(figure, available, lowered).min(widest);
        drawn(figure, Some(panel), lowered, available)
    };
    let mut scene = at(LOWERED[0]);
    for lowered in &LOWERED[1..] {
        let width = available * PRINTED;
        let high = HIGH.min(HIGH_FOR_ITS_WIDTH * width / MILLIMETER);
        if height_in_print(&scene, width) <= high {
            break;
        }
        scene = at(*lowered);
    }
    scene
}

/// Largest usual panel width for which a picture with panels of a relative height is not wider than available.
fn widest_panel(figure: &Figure, available: f64, lowered: f64) -> f64 {
    let (mut low, mut high) = (
        SMALLEST_PANEL,
        (available / figure.columns as f64).max(SMALLEST_PANEL),
    );
    for _ in 0..12 {
        let middle = 0.5 * (low + high);
        match Grid::of(figure, Some(middle), lowered).width() <= available {
            true => low = middle,
            false => high = middle,
        }
    }
    low
}

/// Returns true if two panels in a row have equal boxes and vertical axes: the second needs no words at its vertical axis.
fn shares_y(a: &Panel, b: &Panel) -> bool {
    a.y == b.y && a.lines == b.lines && has_equal_scales(a, b)
}

/// Returns true if two panels in a column have equal boxes and horizontal axes: the upper one needs no words at its horizontal axis.
fn shares_x(a: &Panel, b: &Panel) -> bool {
    a.x == b.x && a.width == b.width && has_equal_scales(a, b)
}

/// Returns true if two panels both have independent axes, or both have an equal aspect with equal axes.
fn has_equal_scales(a: &Panel, b: &Panel) -> bool {
    a.equal_aspect == b.equal_aspect && (!a.equal_aspect || (&a.x, &a.y) == (&b.x, &b.y))
}

/// Measured panels in rows.
struct Grid<'a> {
    panels: Vec<Measured<'a>>,
    columns: usize,
    /// Left margin, box and right margin of each column.
    widths: Vec<[f64; 3]>,
    /// White space around the panels.
    padding: f64,
}

impl<'a> Grid<'a> {
    /// Measures the panels with boxes of the `usual` width, or of a default width, and of a relative height.
    fn of(figure: &'a Figure, usual: Option<f64>, lowered: f64) -> Self {
        let count = figure.panels.len().max(1);
        // Rows have equal numbers of panels, if possible.
        let rows = count.div_ceil(figure.columns.clamp(1, count));
        let columns = count.div_ceil(rows);
        let usual = usual.unwrap_or(if columns == 1 { 420.0 } else { 300.0 });
        let size = Size::of(figure.panel_size, usual).lowered(lowered);
        let panels: Vec<Measured> = figure
            .panels
            .iter()
            .enumerate()
            .map(|(n, panel)| {
                let all = &figure.panels;
                let has_y = n % columns == 0 || !shares_y(&all[n - 1], panel);
                let below = all.get(n + columns);
                let has_x = below.is_none_or(|below| !shares_x(panel, below));
                Measured::new(panel, size, [has_x, has_y])
            })
            .collect();
        let column = |index: usize, size: fn(&Measured) -> f64| {
            let members = panels.iter().skip(index).step_by(columns);
            members.map(size).fold(0.0, f64::max)
        };
        let widths = (0..columns)
            .map(|i| {
                [
                    column(i, |p| p.left),
                    column(i, |p| p.width),
                    column(i, |p| p.right),
                ]
            })
            .collect();
        Self {
            panels,
            columns,
            widths,
            padding: match figure.is_bare {
                true => BARE_PADDING,
                false => PADDING,
            },
        }
    }

    /// Width of the columns including the gaps between them.
    fn content(&self) -> f64 {
        self.widths.iter().flatten().sum::<f64>() + GAP * (self.columns - 1) as f64
    }

    /// Width of a picture of the panels.
    fn width(&self) -> f64 {
        self.content() + 2.0 * self.padding
    }
}

/// Draws the whole figure with at least the given width, and with panels of a relative height.
fn drawn(figure: &Figure, usual: Option<f64>, lowered: f64, least: f64) -> Scene {
    let grid = Grid::of(figure, usual, lowered);
    let (content, padding) = (grid.content(), grid.padding);
    let Grid {
        panels,
        columns,
        widths,
        ..
    } = grid;
    let row = |index: usize, size: fn(&Measured) -> f64| {
        let members = panels.iter().skip(index * columns).take(columns);
        members.map(size).fold(0.0, f64::max)
    };
    let mut entries = figure.legend_entries();
    if least > 0.0 {
        entries = legend::wrapped(entries, least - 2.0 * padding);
    }
    let widest = entries
        .iter()
        .map(legend::entry_width)
        .fold(260.0, f64::max);
    let width = (content.max(widest) + 2.0 * padding).ceil().max(least);

    let mut pen = Pen::default();
    let mut y = padding;
    for line in font::wrap(&figure.title, TITLE, width - 2.0 * padding) {
        y += TITLE * LEADING;
        pen.words(line, (width / 2.0, y - 0.3 * TITLE), Anchor::Middle, TITLE);
    }
    if !figure.title.trim().is_empty() {
        y += 4.0;
    }
    for index in 0..panels.len().div_ceil(columns) {
        if index > 0 {
            y += GAP;
        }
        // Half pixels, so that thin lines fill whole device pixels.
        let top = (y + row(index, |p| p.top)).round() + 0.5;
        let mut x = (width - content) / 2.0;
        for (panel, [left, slot, right]) in panels.iter().skip(index * columns).zip(&widths) {
            let start = (x + left + (slot - panel.width) / 2.0).round() + 0.5;
            panel.draw(&mut pen, start, top);
            x += left + slot + right + GAP;
        }
        y = top + row(index, |p| p.height) + row(index, |p| p.bottom);
    }
    if !entries.is_empty() {
        y = legend::draw(&mut pen, &entries, (padding, width - padding), y + 10.0);
    }
    let caption = font::wrap(&figure.caption, NUMBERS, width - 2.0 * padding);
    if !caption.is_empty() {
        y += 6.0;
    }
    for line in caption {
        y += NUMBERS * LEADING;
        pen.words(line, (padding, y - 0.3 * NUMBERS), Anchor::Start, NUMBERS);
    }
    Scene {
        width,
        height: (y + padding).ceil(),
        title: figure.title.clone(),
        description: figure.caption.clone(),
        shapes: pen.shapes,
        scale: 1.0,
        is_printed: false,
        theme: Theme::Light,
        omitted: Vec::new(),
    }
}

/// Panel with the sizes of its parts.
struct Measured<'a> {
    panel: &'a Panel,
    /// Size of the box between the axes.
    width: f64,
    height: f64,
    /// Margins around the box, for labels, titles and color bars.
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
    title: Vec<String>,
    x_label: Vec<String>,
    y_label: Vec<String>,
    x_marks: Vec<Tick>,
    y_marks: Vec<Tick>,
    bars: Vec<Bar<'a>>,
}

/// A color bar with its axis.
struct Bar<'a> {
    field: &'a Field,
    axis: Axis,
    marks: Vec<Tick>,
    label: Vec<String>,
    width: f64,
}

impl<'a> Measured<'a> {
    /// Measures a panel, with words at its horizontal and at its vertical axis if `has_words`.
    fn new(panel: &'a Panel, size: Size, has_words: [bool; 2]) -> Self {
        let (width, height) = box_size(panel, size);
        let title = font::wrap(&panel.title, WORDS, width + 30.0);
        let mut x_label = label_lines(&panel.x.label, width + 50.0);
        let mut y_label = label_lines(&panel.y.label, height + 10.0);
        let mut x_marks = spaced_marks(&panel.x, width);
        let mut y_marks = stacked_marks(&panel.y, height);
        let axes = [(&mut x_label, &mut x_marks), (&mut y_label, &mut y_marks)];
        for ((label, marks), _) in axes.into_iter().zip(has_words).filter(|(_, has)| !has) {
            label.clear();
            marks.iter_mut().for_each(|mark| mark.label.clear());
        }
        let below = if has_words[0] {
            TICK_GAP + NUMBERS
        } else {
            0.0
        };
        let bars: Vec<Bar> = panel
            .layers
            .iter()
            .filter_map(|layer| match layer {
                Layer::Field(field) => Some(Bar::new(field, height)),
                _ => None,
            })
            .collect();

        let lines = |lines: &[String]| lines.len() as f64 * WORDS * LEADING;
        let gap = |lines: &[String]| if lines.is_empty() { 0.0 } else { LABEL_GAP };
        // Text centered on the box may be wider than the box.
        let overhang = title
            .iter()
            .chain(&x_label)
            .map(|line| font::width(line, WORDS));
        let overhang = overhang
            .map(|words| (words - width) / 2.0)
            .fold(0.0, f64::max);
        let mark_overhang = |tick: &Tick, at_end: bool| {
            let place = width * panel.x.fraction(tick.at).unwrap_or(0.5);
            let half = font::width(&tick.label, NUMBERS) / 2.0;
            if at_end {
                place + half - width
            } else {
                half - place
            }
        };
        let end = x_marks
            .iter()
            .map(|t| mark_overhang(t, true))
            .fold(0.0, f64::max);
        let start = x_marks
            .iter()
            .map(|t| mark_overhang(t, false))
            .fold(0.0, f64::max);
        let axis = TICK + TICK_GAP + widest(&y_marks) + gap(&y_label) + lines(&y_label);
        let top = if title.is_empty() {
            8.0
        } else {
            lines(&title) + 6.0
        };
        Self {
            panel,
            width,
            height,
            left: axis.max(start).max(overhang),
            right: bars
                .iter()
                .map(|bar| bar.width)
                .sum::<f64>()
                .max(end)
                .max(overhang)
                .max(6.0),
            top,
            bottom: TICK + below + gap(&x_label) / 2.0 + lines(&x_label),
            title,
            x_label,
            y_label,
            x_marks,
            y_marks,
            bars,
        }
    }

    fn draw(&self, pen: &mut Pen, left: f64, top: f64) {
        let frame = Frame {
            panel: self.panel,
            left,
            top,
            width: self.width,
            height: self.height,
        };
        for layer in &self.panel.layers {
            frame.draw(pen, layer);
            pen.rims |= matches!(layer, Layer::Regions(_) | Layer::Field(_));
        }
        pen.rims = false;
        let (right, bottom) = (left + self.width, top + self.height);
        let mut axes = PathBuilder::new();
        rectangle(&mut axes, (left, top), (right, bottom));
        for mark in &self.x_marks {
            let Some(x) = frame.x(mark.at) else { continue };
            let length = if mark.minor { 0.6 * TICK } else { TICK };
            segment(&mut axes, (x, bottom), (x, bottom + length));
            let place = (x, bottom + TICK + TICK_GAP + CAPITAL * NUMBERS);
            pen.words(mark.label.clone(), place, Anchor::Middle, NUMBERS);
        }
        for mark in &self.y_marks {
            let Some(y) = frame.y(mark.at) else { continue };
            let length = if mark.minor { 0.6 * TICK } else { TICK };
            segment(&mut axes, (left - length, y), (left, y));
            let last = mark.label.lines().count().saturating_sub(1) as f64;
            for (n, line) in mark.label.lines().enumerate() {
                let shift = (n as f64 - 0.5 * last) * NAME_LEADING;
                let place = (left - TICK - TICK_GAP, y + 0.5 * CAPITAL * NUMBERS + shift);
                pen.words(line.to_owned(), place, Anchor::End, NUMBERS);
            }
        }
        pen.outline(axes, Paint::stroke(INK, 1.0, Dash::Solid));

        let line = WORDS * LEADING;
        let center = left + self.width / 2.0;
        for (i, words) in self.title.iter().rev().enumerate().rev() {
            let place = (center, top - 9.0 - i as f64 * line);
            pen.words(words.clone(), place, Anchor::Middle, WORDS);
        }
        let below = bottom + TICK + TICK_GAP + NUMBERS + LABEL_GAP / 2.0;
        for (i, words) in self.x_label.iter().enumerate() {
            let place = (center, below + (i as f64 + 0.78) * line);
            pen.words(words.clone(), place, Anchor::Middle, WORDS);
        }
        let before = left - TICK - TICK_GAP - widest(&self.y_marks) - LABEL_GAP;
        for (i, words) in self.y_label.iter().rev().enumerate().rev() {
            let place = (before - (i as f64 + 0.22) * line, top + self.height / 2.0);
            pen.words_upward(words.clone(), place, WORDS);
        }
        let mut start = right;
        for bar in &self.bars {
            bar.draw(pen, (start + BAR_GAP).round() + 0.5, top, self.height);
            start += bar.width;
        }
    }
}

/// Largest box between the axes: width, height for axes of different quantities, and height for an equal aspect.
#[derive(Clone, Copy)]
struct Size {
    width: f64,
    height: f64,
    equal_height: f64,
    /// Height of rows relative to their usual height.
    rows: f64,
}

impl Size {
    /// Size with a relative height.
    fn lowered(self, by: f64) -> Self {
        Self {
            height: (self.height * by).round().max(LOWEST.min(self.height)),
            equal_height: self.equal_height * by,
            rows: by.max(LOWEST_ROWS),
            ..self
        }
    }

    /// Requested size, adjusted so that it can be drawn; the usual size without a request.
    fn of(asked: Option<(f64, f64)>, usual: f64) -> Self {
        let sane = |pixels: f64| {
            if pixels.is_finite() {
                pixels.clamp(40.0, 10_000.0)
            } else {
                usual
            }
        };
        match asked {
            Some((width, height)) => Self {
                width: sane(width),
                height: sane(height),
                equal_height: sane(height),
                rows: 1.0,
            },
            None => Self {
                width: usual,
                height: (0.75 * usual).round().max(LOWEST),
                equal_height: 1.2 * usual,
                rows: 1.0,
            },
        }
    }
}

fn box_size(panel: &Panel, size: Size) -> (f64, f64) {
    let length = |axis: &Axis| {
        let (start, end) = axis.limits();
        (end - start).abs()
    };
    let width = size.width;
    if !panel.equal_aspect || panel.x.scale != panel.y.scale {
        // Named ticks on the vertical axis need one line each.
        let names = panel.y.ticks.as_ref().map_or(0, Vec::len);
        let wider = if panel.width.is_finite() {
            panel.width.clamp(0.1, 10.0)
        } else {
            1.0
        };
        let height = match panel.lines.filter(|lines| lines.is_finite()) {
            Some(lines) => (NAME * lines * size.rows).round().clamp(40.0, 10_000.0),
            None => size.height,
        };
        return ((wider * width).round(), height.max(NAME * names as f64));
    }
    // The aspect ratio is limited to 1 to 8; beyond that the longer side is cut, because a panel would become a line.
    let ratio = (length(&panel.y) / length(&panel.x)).clamp(0.125, 8.0);
    let highest = size.equal_height;
    if ratio * width <= highest {
        (width, ratio * width)
    } else {
        (highest / ratio, highest)
    }
}

fn mark_target(length: f64, spacing: f64) -> usize {
    (length / spacing).floor().clamp(1.0, 9.0) as usize
}

/// Lines of the label of an axis. Its unit, in brackets at its end, stays with the word before it, and brackets are not divided if they fit in a line.
fn label_lines(label: &str, available: f64) -> Vec<String> {
    let joined = match label.rsplit_once(" (").filter(|_| label.ends_with(')')) {
        Some((quantity, unit)) => format!("{quantity}\u{a0}({unit}"),
        None => label.to_owned(),
    };
    let mut depth = 0;
    let undivided = joined.chars().map(|letter| {
        depth += i32::from(letter == '(') - i32::from(letter == ')');
        if letter == ' ' && depth > 0 {
            '\u{a0}'
        } else {
            letter
        }
    });
    let undivided = font::wrap(&undivided.collect::<String>(), WORDS, available);
    let fits = |line: &String| font::width(line, WORDS) <= available;
    let lines = match undivided.iter().all(fits) {
        true => undivided,
        false => font::wrap(&joined, WORDS, available),
    };
    lines
        .into_iter()
        .map(|line| line.replace('\u{a0}', " "))
        .collect()
}

/// Ticks of a vertical axis.
fn stacked_marks(axis: &Axis, height: f64) -> Vec<Tick> {
    let closest = mark_target(height, 22.0);
    let target = match axis.scale {
        Scale::Linear => mark_target(height, 42.0),
        // One tick per decade if there is room.
        Scale::Log10 => closest,
    };
    axis.labeled_marks(target, closest)
}

/// Ticks of a horizontal axis whose labels do not overlap.
fn spaced_marks(axis: &Axis, width: f64) -> Vec<Tick> {
    let clear = |marks: &[Tick]| {
        let mut ends: Vec<(f64, f64)> = marks
            .iter()
            .filter(|mark| !mark.label.is_empty())
            .filter_map(|mark| {
                let half = font::width(&mark.label, NUMBERS) / 2.0;
                let place = width * axis.fraction(mark.at)?;
                Some((place - half, place + half))
            })
            .collect();
        ends.sort_by(|a, b| a.0.total_cmp(&b.0));
        ends.windows(2).all(|pair| pair[0].1 + 6.0 <= pair[1].0)
    };
    let mut target = mark_target(width, 48.0);
    let mut marks = axis.marks(target);
    while target > 1 && !clear(&marks) {
        target -= 1;
        marks = axis.marks(target);
    }
    if axis.ticks.is_none() && labels(&marks) < 3 {
        // Three numbers if they fit, else two, else a single number other than zero.
        let finer: Vec<_> = (target..=target + 8).map(|own| axis.marks(own)).collect();
        let ends = || finer.iter().map(|marks| ends_of(marks));
        let last = || {
            finer
                .iter()
                .map(|marks| last_of(marks))
                .filter(|own| labels(own) == 1)
        };
        let choices = finer.iter().filter(|own| labels(own) > 2).cloned();
        let two = std::iter::once(marks.clone()).chain(ends());
        let two = two.filter(|own| labels(own) == 2);
        if let Some(marks) = choices.chain(two).chain(last()).find(|own| clear(own)) {
            return marks;
        }
    }
    // A smaller target does not thin named ticks, so overlapping labels are dropped while their ticks stay.
    for i in 1..=marks.len() {
        if !clear(&marks[..i]) {
            marks[i - 1].label.clear();
        }
    }
    marks
}

/// Ticks with labels of the first and the last alone. Zero needs no digits next to one other number.
fn ends_of(marks: &[Tick]) -> Vec<Tick> {
    let labeled = |mark: &Tick| !mark.label.is_empty();
    let ends = [
        marks.iter().position(labeled),
        marks.iter().rposition(labeled),
    ];
    labeled_alone(marks, |n| ends.contains(&Some(n)))
}

/// Ticks with the label of the last number that is not zero alone.
fn last_of(marks: &[Tick]) -> Vec<Tick> {
    let last = marks
        .iter()
        .rposition(|mark| !mark.label.is_empty() && mark.at != 0.0);
    labeled_alone(marks, |n| Some(n) == last)
}

fn labeled_alone(marks: &[Tick], is_labeled: impl Fn(usize) -> bool) -> Vec<Tick> {
    let mut marks = marks.to_vec();
    for (n, mark) in marks.iter_mut().enumerate() {
        match is_labeled(n) {
            true if mark.at == 0.0 => mark.label = "0".to_owned(),
            true => {}
            false => mark.label.clear(),
        }
    }
    marks
}

fn widest(marks: &[Tick]) -> f64 {
    let lines = marks.iter().flat_map(|mark| mark.label.lines());
    let widths = lines.map(|line| font::width(line, NUMBERS));
    widths.fold(0.0, f64::max)
}

impl<'a> Bar<'a> {
    fn new(field: &'a Field, height: f64) -> Self {
        let axis = Axis::linear(field.label.clone(), field_range(field));
        let marks = stacked_marks(&axis, height);
        let label = label_lines(&field.label, height + 10.0);
        let lines = label.len() as f64 * WORDS * LEADING;
        let width = BAR_GAP + BAR + TICK + TICK_GAP + widest(&marks) + LABEL_GAP + lines;
        Self {
            field,
            axis,
            marks,
            label,
            width,
        }
    }

    fn draw(&self, pen: &mut Pen, left: f64, top: f64, height: f64) {
        let range = self.axis.limits();
        let (right, bottom) = (left + BAR, top + height);
        let colors = (0..LEVELS).map(|level| level_color(self.field.map, level, range));
        for (level, color) in colors.enumerate() {
            let edge = |level: usize| bottom - height * level as f64 / f64::from(LEVELS);
            let mut patch = PathBuilder::new();
            rectangle(&mut patch, (left, edge(level)), (right, edge(level + 1)));
            pen.outline(patch, crisp(color));
        }
        let mut frame = PathBuilder::new();
        rectangle(&mut frame, (left, top), (right, bottom));
        for mark in &self.marks {
            let Some(fraction) = self.axis.fraction(mark.at) else {
                continue;
            };
            let y = bottom - height * fraction;
            segment(&mut frame, (right, y), (right + TICK, y));
            let place = (right + TICK + TICK_GAP, y + 0.5 * CAPITAL * NUMBERS);
            pen.words(mark.label.clone(), place, Anchor::Start, NUMBERS);
        }
        pen.outline(frame, Paint::stroke(INK, 1.0, Dash::Solid));
        // Arrowheads at the ends show that the data exceed the range of the bar.
        let shown = shown_values(self.field);
        let (low, high) = (range.0.min(range.1), range.0.max(range.1));
        let ends = [
            (shown.clone().any(|v| v > high), top, -9.0, high),
            (shown.clone().any(|v| v < low), bottom, 9.0, low),
        ];
        for (beyond, base, rise, end) in ends {
            if beyond {
                let mut point = PathBuilder::new();
                let corners = [(left, base), (left + BAR / 2.0, base + rise), (right, base)];
                polygon(&mut point, &corners);
                let mut paint = Paint::stroke(INK, 1.0, Dash::Solid);
                paint.fill = Some(self.field.map.color(end, range));
                pen.outline(point, paint);
            }
        }
        let line = WORDS * LEADING;
        let after = right + TICK + TICK_GAP + widest(&self.marks) + LABEL_GAP;
        for (i, words) in self.label.iter().enumerate() {
            let place = (after + (i as f64 + 0.78) * line, top + height / 2.0);
            pen.words_upward(words.clone(), place, WORDS);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Line;
    use super::*;

    #[test]
    fn equal_aspect_gives_equal_scales_on_both_axes() {
        for (x, y) in [
            ((0.0, 1.0), (0.0, 1.0)),
            ((0.0, 1.0), (0.0, 5.0)),
            ((2.0, -2.0), (0.0, 1.0)),
        ] {
            let panel = Panel::new("", Axis::linear("", x), Axis::linear("", y)).equal_aspect();
            let (width, height) = box_size(&panel, Size::of(None, 300.0));
            let (in_x, in_y) = (width / (x.1 - x.0).abs(), height / (y.1 - y.0).abs());
            assert!(
                (in_x - in_y).abs() < 1e-9,
                "{in_x} and {in_y} pixels a unit"
            );
            assert!(width <= 300.0 && height <= 360.0 + 1e-9);
        }
    }

    #[test]
    fn panels_of_a_printed_picture_fill_the_available_width() {
        let label = "frequency ω; below 0: −(growth rate) (1/time)";
        let axis = || Axis::linear(label, (-1.0, 4.0));
        let panel = Panel::new("", Axis::linear("k", (0.0, 1.0)), axis()).wider(1.84);
        let figure = Figure::new("").columns(1).with(panel);
        for available in [250.0, 357.0, 740.0] {
            let grid = Grid::of(&figure, Some(widest_panel(&figure, available, 1.0)), 1.0);
            assert!(grid.width() <= available && grid.width() > available - 40.0);
            assert!(grid.panels[0].height >= LOWEST);
        }
    }

    #[test]
    fn neighboring_panels_share_the_names_of_their_rows() {
        let rows = || Axis::linear("", (0.5, 2.5)).ticks([(1.0, "a long name"), (2.0, "another")]);
        let panel = || Panel::new("", Axis::linear("x (m)", (0.0, 1.0)), rows()).lines(4.0);
        let figure = Figure::new("").columns(2).with(panel()).with(panel());
        let grid = Grid::of(&figure, None, 1.0);
        let has_names = |n: usize| {
            grid.panels[n]
                .y_marks
                .iter()
                .all(|mark| !mark.label.is_empty())
        };
        assert!(has_names(0) && !has_names(1));
        let figure = figure.columns(1);
        let below = Grid::of(&figure, None, 1.0);
        assert!(below.panels.iter().all(|own| own.left > 60.0));
    }

    #[test]
    fn a_printed_picture_is_not_higher_than_a_page_and_names_omitted_panels() {
        let rows =
            || (0..15).map(|n| (f64::from(n), format!("a method with a name of its own {n}")));
        let rows = || Axis::linear("", (-0.5, 14.5)).ticks(rows());
        let panel = |n| {
            Panel::new(
                format!("panel {n}"),
                Axis::linear("x (m)", (0.0, 1.0)),
                rows(),
            )
        };
        let rows = (0..4).map(|n| panel(n).lines(30.0));
        let curve = |n: i32| {
            let y = Axis::linear("a long quantity (unit)", (-0.9, 0.9));
            let line = Line::new(Vec::new()).named("a long name ".repeat(6));
            Panel::new(format!("panel {n}"), Axis::log("x (m)", (0.3, 20.0)), y).with(line)
        };
        for (panels, least) in [
            (rows.collect::<Vec<_>>(), 1),
            ((0..5).map(curve).collect(), 4),
        ] {
            for millimeters in [84.0, 174.0] {
                let mut figure = Figure::new("").columns(2);
                figure.panels.clone_from(&panels);
                let sheet = Sheet {
                    size: Some(Asked::Picture(millimeters)),
                    ..Sheet::default()
                };
                let scene = scene(&figure, &sheet);
                let height = scene.height * scene.scale / MILLIMETER;
                assert!(height <= HIGHEST, "{height} mm at {millimeters} mm");
                assert!(panels.len() - scene.omitted.len() >= least);
                // Letters of 8 pt are not reduced below 7.
                assert!(scene.scale >= PRINTED * 7.0 / 8.0, "{}", scene.scale);
            }
        }
    }

    #[test]
    fn long_names_of_rows_have_two_lines_if_the_rows_are_high_enough() {
        let names = [
            "Lagrangian Shepard, stress points",
            "SPH, smoothed velocities 0.5",
        ];
        for (lines, expected) in [(2.0, true), (1.0, false)] {
            let rows = names
                .into_iter()
                .enumerate()
                .map(|(n, name)| (n as f64, name));
            let rows = Axis::linear("", (-0.5, 1.5)).ticks(rows);
            let panel = Panel::new("", Axis::linear("x (m)", (0.0, 1.0)), rows);
            let mut figure = Figure::new("").with(panel.lines(2.0 * lines));
            shorten_names(&mut figure, 140.0);
            let told: Vec<_> = figure.panels[0].y.ticks.iter().flatten().collect();
            for ((_, told), name) in told.into_iter().zip(names) {
                assert_eq!(told.replace('\n', " ") == name, expected, "{told}");
                assert!(told.lines().all(|line| font::width(line, NUMBERS) <= 140.0));
            }
        }
    }

    #[test]
    fn panels_with_equal_axes_have_their_words_at_the_margin_of_the_picture() {
        let panel = |title: &str| {
            let axis = |label| Axis::linear(label, (0.0, 10.0));
            Panel::new(title, axis("x (m)"), axis("y (m)")).equal_aspect()
        };
        let titles = ["1", "2", "3", "4"];
        let mut figure = titles
            .iter()
            .fold(Figure::new(""), |figure, title| figure.with(panel(title)));
        let has_words = |n: usize, grid: &Grid<'_>| {
            let own = &grid.panels[n];
            [(&own.x_label, &own.x_marks), (&own.y_label, &own.y_marks)].map(|(label, marks)| {
                let is_labeled = marks.iter().any(|mark| !mark.label.is_empty());
                assert_eq!(is_labeled, !label.is_empty());
                is_labeled
            })
        };
        // Four panels of at most three in a row are two rows of two.
        let grid = Grid::of(&figure, None, 1.0);
        assert_eq!(grid.columns, 2);
        let all: Vec<[bool; 2]> = (0..4).map(|n| has_words(n, &grid)).collect();
        assert_eq!(
            all,
            [[false, true], [false, false], [true, true], [true, false]]
        );

        // The last panel of a column has the words, also in a row that is not full.
        figure.panels.push(panel("5"));
        let grid = Grid::of(&figure, None, 1.0);
        assert_eq!(grid.columns, 3);
        assert_eq!(has_words(2, &grid), [true, false]);

        // A panel with a different scale keeps its words.
        figure.panels[3].x.range.1 = 20.0;
        assert_eq!(has_words(0, &Grid::of(&figure, None, 1.0)), [true, true]);
    }

    #[test]
    fn the_unit_of_an_axis_stays_with_its_word() {
        let label = "coefficient of the penalty (1/m)";
        let width = font::width("coefficient of the penalty (", WORDS);
        let expected = ["coefficient of the", "penalty (1/m)"];
        assert_eq!(label_lines(label, width), expected);
        assert_eq!(label_lines(label, 1e3), [label]);
        let label = "min Re ω² / (c² |k|²) (−)";
        let width = font::width("min Re ω² / (c²", WORDS);
        assert_eq!(label_lines(label, width), ["min Re ω² /", "(c² |k|²) (−)"]);
        let label = "stress (unit of the tables)";
        let width = font::width("of the tables)", WORDS) + 1.0;
        assert_eq!(
            label_lines(label, width),
            ["stress (unit", "of the tables)"]
        );
    }

    #[test]
    fn a_bare_figure_has_narrow_margins_and_wider_panels() {
        let axis = || Axis::linear("x (m)", (0.0, 1.0));
        let figure = Figure::new("")
            .columns(1)
            .with(Panel::new("", axis(), axis()));
        let sheet = |bare| Sheet {
            size: Some(Asked::Picture(84.0)),
            bare,
            ..Sheet::default()
        };
        let panel = |bare| widest_panel(&sheet(bare).dressed(&figure), 350.0, 1.0);
        assert!(panel(true) > panel(false) + 20.0);
    }

    #[test]
    fn an_axis_has_two_numbers_at_least() {
        for axis in [
            Axis::linear("", (-0.9, 0.9)),
            Axis::linear("", (0.31, 0.39)),
            Axis::log("", (0.3, 20.0)),
            Axis::log("", (0.04, 1.3)),
            Axis::log("", (2.0, 3.0)),
        ] {
            assert!(labels(&stacked_marks(&axis, 60.0)) > 1, "{axis:?}");
            assert!(labels(&spaced_marks(&axis, 100.0)) > 1, "{axis:?}");
        }
    }

    #[test]
    fn an_axis_of_any_size_has_a_number_other_than_zero() {
        for power in -30..=30 {
            for factor in [1.0, 1.3, 2.9, 7.7] {
                let most = factor * 10f64.powi(power);
                for axis in [
                    Axis::linear("", (0.0, most)),
                    Axis::linear("", (-most, most)),
                ] {
                    for length in [20.0, 30.0, 45.0, 80.0, 200.0] {
                        for marks in [spaced_marks(&axis, length), stacked_marks(&axis, length)] {
                            let told =
                                |mark: &Tick| mark.label.contains(|own| ('1'..='9').contains(&own));
                            let told = |mark: &Tick| mark.at != 0.0 && told(mark);
                            assert!(marks.iter().any(told), "{axis:?} {length}: {marks:?}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn a_higher_axis_has_three_numbers() {
        for high in [0.19, 1.05, 104.0, 2.5] {
            let axis = Axis::linear("", (-0.04 * high, high));
            for height in [90.0, 120.0, 200.0] {
                assert!(
                    labels(&stacked_marks(&axis, height)) > 2,
                    "{axis:?} {height}"
                );
            }
        }
    }

    #[test]
    fn labels_of_a_horizontal_axis_do_not_touch() {
        for range in [(0.0, 1e6), (-1e-7, 1e-7), (1000.001, 1000.009), (-0.5, 2.5)] {
            for width in [60.0, 150.0, 300.0] {
                let axis = Axis::linear("", range);
                let marks = spaced_marks(&axis, width);
                let mut end = f64::NEG_INFINITY;
                for mark in marks.iter().filter(|mark| !mark.label.is_empty()) {
                    let half = font::width(&mark.label, NUMBERS) / 2.0;
                    let place = axis.fraction(mark.at).unwrap() * width;
                    assert!(place - half > end, "{marks:?} at {width}");
                    end = place + half;
                }
            }
        }
    }
}
