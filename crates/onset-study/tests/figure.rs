//! Tests of figure files: the text of the SVG, the pixels of the PNG, and values that must never appear.

use onset_study::figure::{
    Arrows, Axis, Field, Figure, FigureError, Label, LegendEntry, Line, Marker, Panel, Points,
    Regions, Rule, Sheet, Size, Symbol, Theme, palette,
};
use onset_study::output::{Output, picture};
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
        .filter(|node| node.has_tag_name("text"));
    labels
        .filter_map(|node| node.text())
        .map(str::to_string)
        .collect()
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
    let number = |name| {
        root.attribute(name)
            .unwrap()
            .trim_end_matches("mm")
            .parse::<f64>()
            .unwrap()
    };
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
fn a_wide_line_that_ends_at_the_frame_does_not_cross_it() {
    let panel = |points| unit_panel("").with(Line::new(points).width(12.0).color(palette::BLUE));
    let ending = vec![(0.0, 0.3), (0.5, 0.5)];
    let figure = |points| Figure::new("").columns(1).with(panel(points));
    let svg = figure(ending.clone()).to_svg();
    assert_eq!(svg.matches("<clipPath").count(), 1);
    assert!(
        !figure(vec![(0.2, 0.3), (0.5, 0.5)])
            .to_svg()
            .contains("<clipPath")
    );
    let left = svg
        .split_once("<rect x=\"")
        .and_then(|(_, rest)| rest.split('"').next());
    let left: f64 = left.and_then(|left| left.parse().ok()).expect("a window");
    let image = decode(&figure(ending).to_png().expect("a PNG"));
    let wanted = [palette::BLUE.red, palette::BLUE.green, palette::BLUE.blue];
    let pixels = image.rgb.chunks_exact(3).enumerate();
    let columns = pixels
        .filter(|(_, pixel)| *pixel == wanted)
        .map(|(n, _)| n as u32 % image.width);
    let first = columns.min().expect("a line");
    assert!(
        (2.0 * left - 1.0..2.0 * left + 9.0).contains(&f64::from(first)),
        "{first} {left}"
    );
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
fn a_figure_is_written_in_three_formats_into_a_new_directory() {
    let root = std::env::temp_dir().join(format!("onset-figure-{}", std::process::id()));
    let directory = root.join("a/b");
    let figure = Figure::new("files").with(unit_panel(""));
    let files = Output::at::<&str>(&directory, &[])
        .and_then(|output| output.write(&vec![picture("figure-0.5", figure.clone())]))
        .expect("files");
    let names = ["figure-0.5.svg", "figure-0.5.png", "figure-0.5.pdf"];
    assert_eq!(files, names.map(|name| directory.join(name)));
    let read = files
        .iter()
        .map(|file| std::fs::read(file).unwrap())
        .collect::<Vec<_>>();
    assert_eq!(
        read,
        [
            figure.to_svg().into_bytes(),
            figure.to_png().unwrap(),
            figure.to_pdf()
        ]
    );
    std::fs::remove_dir_all(root).unwrap();
}

#[test]
fn a_directory_that_cannot_be_written_is_named_in_the_error() {
    let file = std::env::temp_dir().join(format!("onset-figure-file-{}", std::process::id()));
    std::fs::write(&file, "in the way").unwrap();
    let directory = file.join("figures");
    let figure = Figure::new("").with(unit_panel(""));
    let error = Output::at::<&str>(&directory, &[])
        .and_then(|output| output.write(&vec![picture("figure", figure)]))
        .unwrap_err();
    std::fs::remove_file(&file).unwrap();
    assert_eq!(error.path, directory);
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

/// Decompressed streams of a PDF.
fn streams(pdf: &[u8]) -> Vec<Vec<u8>> {
    use std::io::Read;
    let place = |needle: &[u8], from: usize| {
        let found = pdf[from..]
            .windows(needle.len())
            .position(|own| own == needle);
        found.map(|at| from + at)
    };
    let mut all = Vec::new();
    let mut from = 0;
    while let Some(start) = place(b"stream\n", from) {
        let start = start + b"stream\n".len();
        let end = place(b"endstream", start).expect("the end of a stream");
        let mut content = Vec::new();
        flate2::read::ZlibDecoder::new(&pdf[start..end])
            .read_to_end(&mut content)
            .expect("a compressed stream");
        all.push(content);
        from = end + b"endstream\n".len();
    }
    all
}

#[test]
fn a_pdf_holds_outlines_and_text_in_an_embedded_font() {
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
    .with(Label::new((0.5, 0.5), "λ₁"))
    .with(
        Line::new(vec![(0.0, 0.0), (1.0, 1.0)])
            .dashed()
            .named("a line"),
    );
    let figure = Figure::new("Title").with(panel).caption("A caption.");
    let pdf = figure.to_pdf();
    assert!(pdf.starts_with(b"%PDF-") && pdf.trim_ascii_end().ends_with(b"%%EOF"));
    let streams = streams(&pdf);
    let holding = |needle: &[u8]| {
        let mut all = streams.iter();
        let found = all.find(|own| own.windows(needle.len()).any(|window| window == needle));
        found.expect("a stream")
    };
    let content = String::from_utf8_lossy(holding(b" cm\n"));
    let count = |operator: &str| {
        content
            .lines()
            .filter(|line| line.ends_with(operator))
            .count()
    };
    // One upright page, filled and stroked areas, and a dashed line.
    assert_eq!(count(" cm"), 1);
    assert!(count("B") >= 3, "areas of three verdicts");
    assert!(count("S") >= 2, "axes and the line");
    assert!(
        count("] 0 d") > 0 && content.contains("[6.4 4] 0 d"),
        "dashes"
    );
    assert!(!content.contains("NaN") && !content.contains("inf"));
    // Each line of text of the SVG is a line of text here; a label on a map has a rim, too.
    let texts = texts(&figure.to_svg());
    assert_eq!(count("Tj"), texts.len() + 1);
    // PDF viewers need the ToUnicode map to search and copy text.
    let characters = String::from_utf8_lossy(holding(b"beginbfchar"));
    for letter in texts.concat().chars() {
        assert!(
            characters.contains(&format!("<{:04X}>", letter as u32)),
            "{letter}"
        );
    }
    // The font has the letters used, and no others.
    let font = holding(b"glyf");
    let face = ttf_parser::Face::parse(font, 0).expect("a font");
    let used = texts.concat().chars().collect::<HashSet<_>>().len();
    // Some letters are composed of others.
    let kept = usize::from(face.number_of_glyphs());
    assert!((used + 1..used + 6).contains(&kept), "{kept} for {used}");
    // The page is as wide as the SVG; an inch has 72 points and 96 pixels.
    let (width, _) = size_of(&figure.to_svg());
    let told = format!("/MediaBox [0 0 {}", 0.75 * width);
    assert!(String::from_utf8_lossy(&pdf).contains(&told), "{told}");
}

#[test]
fn a_picture_for_print_has_its_width_and_letters_of_8_points() {
    let figure = Figure::new("print")
        .columns(3)
        .with(unit_panel("a"))
        .with(unit_panel("b"))
        .with(unit_panel("c"));
    for (width, rows) in [(84.0, 3), (174.0, 1)] {
        let sheet = Sheet {
            size: Some(Size::Picture(width)),
            ..Sheet::default()
        };
        let files = figure.files("print", &sheet).expect("files");
        let svg = String::from_utf8(files[0].1.clone()).expect("text");
        assert_eq!(size_of(&svg).0, width);
        let document = roxmltree::Document::parse(&svg).expect("well-formed XML");
        let view = document.root_element().attribute("viewBox").expect("a box");
        let across: f64 = view.split(' ').nth(2).unwrap().parse().unwrap();
        let points = 12.0 * width / across * 72.0 / 25.4;
        assert!((points - 8.0).abs() < 0.05, "{points} pt at {width} mm");
        let image = decode(&files[1].1);
        assert_eq!(f64::from(image.width), (width / 25.4 * 300.0).ceil());
        // Narrow pictures have their panels below each other.
        assert_eq!(image.height > image.width, rows == 3);
        let told = format!("/MediaBox [0 0 {}", (width / 25.4 * 72.0) as f32);
        let pdf = String::from_utf8_lossy(&files[2].1);
        assert!(pdf.contains(&told[..16]), "{told}");
    }
}

#[test]
fn the_words_of_a_bare_picture_are_in_a_text_file_and_a_dark_picture_has_a_dark_background() {
    let figure = Figure::new("A title")
        .caption("A caption.")
        .with(unit_panel("a"));
    let sheet = Sheet {
        bare: true,
        theme: Theme::Dark,
        ..Sheet::default()
    };
    let files = figure.files("bare", &sheet).expect("files");
    let names: Vec<_> = files
        .iter()
        .map(|(name, _)| name.to_str().unwrap())
        .collect();
    assert_eq!(names, ["bare.svg", "bare.png", "bare.pdf", "bare.txt"]);
    assert_eq!(files[3].1, b"A title. A caption.\n");
    let svg = String::from_utf8(files[0].1.clone()).expect("text");
    let texts = texts(&svg);
    assert!(texts.contains(&"x (m)".into()) && !texts.contains(&"A title".into()));
    assert_eq!(decode(&files[1].1).count(palette::WHITE), 0);
    // The title of a bare picture remains its name for other programs.
    assert!(svg.contains("<title>A title</title>"));
    // A replaced title is drawn in the picture, and no text file is written.
    let sheet = Sheet {
        title: Some("Mine".into()),
        ..Sheet::default()
    };
    let files = figure.files("titled", &sheet).expect("files");
    let svg = String::from_utf8(files[0].1.clone()).expect("text");
    assert!(self::texts(&svg).contains(&"Mine".into()) && files.len() == 3);
}

#[test]
fn other_programs_get_limits_legend_and_colors_of_a_figure() {
    let panel = unit_panel("a")
        .with(Field::new(UNIT, UNIT, (2, 1), vec![-1.0, 3.0], "f (Pa)").diverging())
        .with(
            Line::new(vec![UNIT, (f64::NAN, 1.0)])
                .named("a line")
                .dotted(),
        );
    let figure = Figure::new("told").with(panel);
    let told = serde_json::to_value(figure.description()).expect("JSON");
    assert_eq!(
        told["panels"][0]["x"]["range"],
        serde_json::json!([0.0, 1.0])
    );
    let [field, line] = [0, 1].map(|i| &told["panels"][0]["layers"][i]);
    assert_eq!(field["field"]["range"], serde_json::json!([-3.0, 3.0]));
    assert_eq!(field["field"]["map"], "red-blue");
    assert_eq!(line["line"]["color"], "#000000");
    assert_eq!(line["line"]["points"][1], serde_json::json!([null, 1.0]));
    assert_eq!(told["legend"][0]["name"], "a line");
    assert_eq!(told["legend"][0]["symbol"]["line"]["dash"], "dotted");
}
