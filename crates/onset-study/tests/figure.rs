//! Tests of figure files: the text of the SVG, the pixels of the PNG, and values that must never appear.

use onset_study::figure::{
    Arrows, Axis, Field, Figure, FigureError, Label, LegendEntry, Line, Marker, Panel, Points,
    Regions, Rule, Symbol, palette,
};
use std::collections::HashSet;

const UNIT: (f64, f64) = (0.0, 1.0);

fn unit_panel(title: &str) -> Panel {
    Panel::new(
        title,
        Axis::linear("x (m)", UNIT),
        Axis::linear("y (m)", UNIT),
    )
}

fn square(values: impl Fn(f64, f64) -> f64, cells: usize) -> Vec<f64> {
    let at = |i: usize| (i as f64 + 0.5) / cells as f64;
    let cell = |i: usize| values(at(i % cells), at(i / cells));
    (0..cells * cells).map(cell).collect()
}

/// The lines of text of a well-formed SVG; fails on malformed XML and on dangling references.
fn texts(svg: &str) -> Vec<String> {
    let document = roxmltree::Document::parse(svg).expect("well-formed XML");
    let ids: HashSet<_> = document
        .descendants()
        .filter_map(|node| node.attribute("id"))
        .collect();
    let xlink = "http://www.w3.org/1999/xlink";
    for node in document.descendants() {
        if let Some(target) = node.attribute((xlink, "href")) {
            assert!(ids.contains(&target[1..]), "{target} is not defined");
        }
    }
    let labels = document
        .descendants()
        .filter_map(|node| node.attribute("aria-label"));
    labels.map(str::to_string).collect()
}

struct Image {
    width: u32,
    height: u32,
    rgb: Vec<u8>,
}

fn decode(png: &[u8]) -> Image {
    let mut reader = png::Decoder::new(std::io::Cursor::new(png))
        .read_info()
        .expect("a PNG");
    let mut rgb = vec![0; reader.output_buffer_size().expect("a size")];
    let info = reader.next_frame(&mut rgb).expect("a whole PNG");
    assert_eq!(info.color_type, png::ColorType::Rgb);
    Image {
        width: info.width,
        height: info.height,
        rgb,
    }
}

impl Image {
    fn count(&self, color: onset_study::figure::Color) -> usize {
        let wanted = [color.red, color.green, color.blue];
        self.rgb
            .chunks_exact(3)
            .filter(|pixel| *pixel == wanted)
            .count()
    }
}

fn size_of(svg: &str) -> (f64, f64) {
    let document = roxmltree::Document::parse(svg).expect("well-formed XML");
    let root = document.root_element();
    let number = |name| root.attribute(name).unwrap().parse::<f64>().unwrap();
    (number("width"), number("height"))
}

/// Checks that the SVG contains no number that is not finite.
fn assert_finite(svg: &str) {
    for word in ["NaN", "inf", "Infinity"] {
        assert!(!svg.contains(word), "the SVG contains {word}");
    }
}

#[test]
fn the_svg_contains_every_word_with_reserved_characters_escaped() {
    let figure = Figure::new("shear & stretch")
        .caption("where \"det Q\" < 0\u{1}")
        .with(unit_panel("J > 0").with(Line::new(vec![UNIT, (1.0, 0.0)]).named("λ₁ < λ₂ & μ")))
        .with(
            Panel::new(
                "",
                Axis::log("ω² (1/s²)", (1.0, 1e3)),
                Axis::linear("θ (π rad)", UNIT),
            )
            .with(Label::new((10.0, 0.5), "σ·ρ⁴")),
        );
    let svg = figure.to_svg();
    let texts = texts(&svg);
    for word in [
        "shear & stretch",
        "where \"det Q\" < 0\u{fffd}",
        "J > 0",
        "x (m)",
        "y (m)",
        "ω² (1/s²)",
        "θ (π rad)",
        "σ·ρ⁴",
        "λ₁ < λ₂ & μ",
        "10²",
        "0.6",
    ] {
        assert!(
            texts.iter().any(|text| text == word),
            "{word} is missing in {texts:?}"
        );
    }
    assert!(svg.contains("J &gt; 0") && !svg.contains("J > 0"));
}

#[test]
fn numbers_that_are_not_finite_are_never_drawn() {
    let wild = [
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        1e308,
        -1e308,
        0.0,
        -1.0,
        0.5,
    ];
    let points: Vec<_> = wild.iter().flat_map(|&x| wild.map(|y| (x, y))).collect();
    let turned: Vec<_> = points.iter().rev().copied().collect();
    for range in [
        UNIT,
        (f64::NAN, 1.0),
        (1e-308, 1e308),
        (f64::NEG_INFINITY, 0.0),
        (2.0, 2.0),
    ] {
        for (x, y) in [
            (Axis::linear("x", range), Axis::linear("y", range)),
            (Axis::log("x", range), Axis::log("y", range)),
        ] {
            let mut panel = Panel::new("wild", x, y)
                .equal_aspect()
                .with(Line::new(points.clone()).width(f64::NAN).dashed())
                .with(Points::new(points.clone()).size(f64::INFINITY))
                .with(Arrows::new(points.clone(), turned.clone()));
            for value in wild {
                let map = Field::new(
                    (value, 1.0),
                    (0.0, value),
                    (8, 8),
                    square(|_, _| value, 8),
                    "v",
                );
                panel = panel
                    .with(Rule::vertical(value))
                    .with(Rule::horizontal(value))
                    .with(Label::new((value, value), "here"))
                    .with(map.clone())
                    .with(map.diverging().range(value, value))
                    .with(Regions::of_words((value, 1.0), UNIT, (1, 1), ["numerical"]));
            }
            let figure = Figure::new("").with(panel);
            let svg = figure.to_svg();
            texts(&svg);
            assert_finite(&svg);
            figure.to_png().expect("a PNG");
        }
    }
}

#[test]
fn a_nan_breaks_a_line() {
    let moves = |middle: (f64, f64)| {
        let line = vec![(0.1, 0.1), (0.2, 0.3), middle, (0.4, 0.1), (0.5, 0.3)];
        let svg = Figure::new("")
            .with(unit_panel("").with(Line::new(line).width(7.0)))
            .to_svg();
        let document = roxmltree::Document::parse(&svg).unwrap();
        let is_line = |node: &roxmltree::Node| node.attribute("stroke-width") == Some("7");
        let line = document.descendants().find(is_line).expect("the line");
        line.attribute("d").unwrap().matches('M').count()
    };
    assert_eq!(moves((0.3, 0.2)), 1);
    assert_eq!(moves((0.3, f64::NAN)), 2);
    // A detour outside the panel is clipped.
    assert_eq!(moves((0.3, 9.0)), 2);
}

#[test]
fn empty_figures_panels_and_layers_can_be_drawn() {
    let empty = unit_panel("")
        .with(Regions::default())
        .with(Field::default())
        .with(Line::new(Vec::new()).named("nothing"))
        .with(Points::new(Vec::new()))
        .with(Arrows::new(Vec::new(), Vec::new()))
        .with(Label::new((0.5, 0.5), ""))
        // Fewer and more cells than the grid has.
        .with(Regions::of_words(UNIT, UNIT, (3, 3), ["stable"; 4]))
        .with(Regions::of_words(UNIT, UNIT, (1, 1), ["stable"; 4]))
        .with(Field::new(UNIT, UNIT, (0, 5), vec![1.0; 3], "v"));
    for figure in [
        Figure::default(),
        Figure::new("").columns(0).with(unit_panel("")),
        Figure::new("no layers").with(empty.clone()).with(empty),
    ] {
        let svg = figure.to_svg();
        texts(&svg);
        assert_finite(&svg);
        assert!(decode(&figure.to_png().unwrap()).width > 100);
    }
}

#[test]
fn a_constant_field_has_a_color_bar_around_its_value() {
    for value in [0.0, 3.0, -2e9, 1e-12] {
        let field = Field::new(UNIT, UNIT, (4, 4), vec![value; 16], "pressure (Pa)");
        for field in [field.clone(), field.diverging()] {
            let figure = Figure::new("").with(unit_panel("").with(field));
            let texts = texts(&figure.to_svg());
            assert!(texts.contains(&"pressure (Pa)".to_string()));
            figure.to_png().unwrap();
        }
    }
}

#[test]
fn the_png_has_twice_the_pixels_of_the_svg() {
    let figure = Figure::new("size")
        .columns(2)
        .with(unit_panel("a"))
        .with(unit_panel("b"));
    let (width, height) = size_of(&figure.to_svg());
    let image = decode(&figure.to_png().unwrap());
    assert_eq!(
        (f64::from(image.width), f64::from(image.height)),
        (2.0 * width, 2.0 * height)
    );
    // White paper with a little ink.
    let (white, all) = (image.count(palette::WHITE), image.rgb.len() / 3);
    assert!(
        white > all * 9 / 10 && white < all,
        "{white} of {all} pixels are white"
    );
}

#[test]
fn a_map_fills_its_share_of_the_panel_without_seams() {
    let words = (0..10_000).map(|i| if i % 100 < 25 { "numerical" } else { "stable" });
    let panel =
        unit_panel("")
            .equal_aspect()
            .with(Regions::of_words(UNIT, UNIT, (100, 100), words));
    let figure = Figure::new("").with(panel).with(unit_panel(""));
    let legend = figure.legend_entries();
    assert_eq!(legend.len(), 2, "only classes that occur: {legend:?}");
    let image = decode(&figure.to_png().unwrap());
    let count = |word| image.count(palette::verdict(word).unwrap()) as f64;
    // The panel has 300 pixels at twice the resolution, less its frame; the legend adds two patches.
    assert!(
        (count("numerical") / (150.0 * 600.0) - 1.0).abs() < 0.02,
        "{}",
        count("numerical")
    );
    assert!(
        (count("stable") / (450.0 * 600.0) - 1.0).abs() < 0.02,
        "{}",
        count("stable")
    );
}

#[test]
fn equal_neighbors_are_merged_so_that_the_svg_stays_small() {
    let disc = (0..10_000i32).map(|i| {
        let inside = (i % 100 - 50).pow(2) + (i / 100 - 50).pow(2) < 1600;
        if inside { "stable" } else { "physical" }
    });
    let map = Regions::of_words(UNIT, UNIT, (100, 100), disc);
    let empty = Figure::new("").with(unit_panel(""));
    let full = Figure::new("").with(unit_panel("").with(map));
    let added = full.to_svg().len() - empty.to_svg().len();
    assert!(added < 20_000, "10000 cells take {added} bytes");
}

#[test]
fn the_legend_names_each_layer_once_and_can_be_replaced() {
    let line = Line::new(vec![UNIT]).named("PDE").dashed();
    let points = Points::new(vec![UNIT])
        .marker(Marker::Triangle)
        .open()
        .named("particles");
    let panel = unit_panel("").with(line).with(points);
    let mut figure = Figure::new("").with(panel.clone()).with(panel);
    let names = |figure: &Figure| -> Vec<String> {
        figure
            .legend_entries()
            .into_iter()
            .map(|entry| entry.name)
            .collect()
    };
    assert_eq!(names(&figure), ["PDE", "particles"]);
    figure.legend = vec![LegendEntry {
        name: "by hand".into(),
        symbol: Symbol::Patch(palette::SKY),
    }];
    assert_eq!(names(&figure), ["by hand"]);
    let texts = texts(&figure.to_svg());
    assert!(texts.contains(&"by hand".into()) && !texts.contains(&"PDE".into()));
}

#[test]
fn svg_and_png_are_written_into_a_new_directory() {
    let root = std::env::temp_dir().join(format!("onset-figure-{}", std::process::id()));
    let directory = root.join("a/b");
    let figure = Figure::new("files").with(unit_panel(""));
    let [svg, png] = figure.write(&directory, "figure-0.5").expect("two files");
    assert_eq!(svg, directory.join("figure-0.5.svg"));
    assert_eq!(png, directory.join("figure-0.5.png"));
    assert_eq!(std::fs::read_to_string(svg).unwrap(), figure.to_svg());
    assert_eq!(std::fs::read(png).unwrap(), figure.to_png().unwrap());
    std::fs::remove_dir_all(root).unwrap();
}

#[test]
fn a_directory_that_cannot_be_written_is_named_in_the_error() {
    let file = std::env::temp_dir().join(format!("onset-figure-file-{}", std::process::id()));
    std::fs::write(&file, "in the way").unwrap();
    let directory = file.join("figures");
    let error = Figure::new("")
        .with(unit_panel(""))
        .write(&directory, "figure")
        .unwrap_err();
    std::fs::remove_file(&file).unwrap();
    assert!(matches!(&error, FigureError::Write { path, .. } if *path == directory));
    assert!(
        error.to_string().contains(&directory.display().to_string()),
        "{error}"
    );
}

#[test]
fn a_picture_too_large_for_memory_is_an_error() {
    let mut figure = Figure::new("").columns(1_000);
    figure.panels = vec![unit_panel(""); 1_000];
    assert!(matches!(figure.to_png(), Err(FigureError::Size { .. })));
}

#[test]
fn a_pdf_holds_the_outlines_of_the_svg() {
    use std::io::Read;
    let panel = Panel::new(
        "A (title)",
        Axis::linear("x", (0.0, 1.0)),
        Axis::linear("y", (0.0, 1.0)),
    )
    .with(Regions::of_words(
        (0.0, 1.0),
        (0.0, 1.0),
        (2, 2),
        ["stable", "numerical", "stable", "physical"],
    ))
    .with(
        Line::new(vec![(0.0, 0.0), (1.0, 1.0)])
            .dashed()
            .named("a line"),
    );
    let figure = Figure::new("Title").with(panel).caption("A caption.");
    let pdf = figure.to_pdf();
    assert!(pdf.starts_with(b"%PDF-") && pdf.trim_ascii_end().ends_with(b"%%EOF"));
    let place = |needle: &[u8]| {
        pdf.windows(needle.len())
            .position(|window| window == needle)
    };
    let start = place(b"stream\n").expect("a stream") + b"stream\n".len();
    let end = place(b"endstream").expect("its end");
    let mut content = String::new();
    flate2::read::ZlibDecoder::new(&pdf[start..end])
        .read_to_string(&mut content)
        .expect("operators");
    let count = |operator: &str| {
        content
            .lines()
            .filter(|line| line.ends_with(operator))
            .count()
    };
    // One upright page, filled and stroked areas, a dashed line, and letters as curves.
    assert_eq!(count(" cm"), 1);
    assert!(count("f") > 10, "letters and patches");
    assert!(count("B") >= 3, "areas of three verdicts");
    assert!(count("S") >= 2, "axes and the line");
    assert!(count(" c") > 100, "curves of letters");
    assert!(
        count("] 0 d") > 0 && content.contains("[6.4 4] 0 d"),
        "dashes"
    );
    assert!(!content.contains("NaN") && !content.contains("inf"));
    // The page is as wide as the SVG; an inch has 72 points and 96 pixels.
    let svg = figure.to_svg();
    let width = svg
        .split("width=\"")
        .nth(1)
        .and_then(|rest| rest.split('"').next());
    let width: f64 = width.and_then(|text| text.parse().ok()).expect("a width");
    let told = format!("/MediaBox [0 0 {}", 0.75 * width);
    assert!(place(told.as_bytes()).is_some(), "{told}");
}
