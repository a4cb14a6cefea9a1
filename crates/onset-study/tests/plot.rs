//! Tests of the figures of stored maps.

use onset_study::figure::{Layer, Panel, Symbol};
use onset_study::map::{Part, Plan, Watch};
use onset_study::plot::{Lines, Look, Plot, plot};
use onset_study::settings::Study;
use onset_study::store::ZarrStore;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};

struct Quiet;

impl Watch for Quiet {
    fn advance(&self, _: u64) {}

    fn is_interrupted(&self) -> bool {
        false
    }
}

/// A folder that is removed at the end.
struct Place(PathBuf);

impl Place {
    fn new() -> Self {
        static COUNT: AtomicUsize = AtomicUsize::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let name = format!("onset-plot-{}-{count}", std::process::id());
        let place = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&place).expect("a folder");
        Self(place)
    }

    /// Creates the store of a study with its first tiles computed.
    fn store(&self, name: &str, text: &str, tiles: usize) -> PathBuf {
        let study = Study::parse("study.toml", text).expect("a study");
        let plan = Plan::new(&study).expect("a plan");
        let path = self.0.join(format!("{name}.zarr"));
        let store = ZarrStore::create(&path, plan.layout()).expect("a store");
        let tiles = plan.tiles(Some(Part::Range(0..tiles))).expect("tiles");
        plan.run(&store, &tiles, &Quiet).expect("a map");
        path
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn study(title: &str, more: &str) -> String {
    format!(
        "title = '{title}'\n[discretization]\nframe = 'eulerian'\ncurrent-lattice = 'regular'\nsupport = 1.9\n\
         [[axes]]\nquantity = 'stretch-1'\nrange = [0.6, 1.9]\nstates = 12\n\
         [[axes]]\nquantity = 'stretch-2'\nrange = [0.6, 2.0]\nstates = 10\n{more}[map]\ntile = 8\n"
    )
}

fn draw(stores: &[PathBuf], field: &str, traced: bool) -> onset_study::figure::Figure {
    let asked = Plot {
        stores,
        field,
        boundaries: if traced {
            Lines::Traced
        } else {
            Lines::OfCells
        },
        look: Look::default(),
    };
    plot(&asked, &()).expect("a figure")
}

fn names(figure: &onset_study::figure::Figure) -> Vec<String> {
    figure
        .legend_entries()
        .into_iter()
        .map(|entry| entry.name)
        .collect()
}

fn regions(panel: &Panel) -> &onset_study::figure::Regions {
    match &panel.layers[0] {
        Layer::Regions(regions) => regions,
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_figure_of_a_map_names_its_verdicts_and_shows_both_boundaries() {
    let place = Place::new();
    let store = place.store("a", &study("one", ""), 100);
    for traced in [true, false] {
        let figure = draw(std::slice::from_ref(&store), "verdict", traced);
        let names = names(&figure);
        for name in [
            "stable",
            "numerical",
            "boundary of the material",
            "boundary of the discretization",
        ] {
            assert!(names.iter().any(|found| found == name), "{name}: {names:?}");
        }
        assert_eq!(figure.title, "one");
        for fact in ["Material: modified-mooney-rivlin", "frame eulerian"] {
            assert!(figure.caption.contains(fact), "{}", figure.caption);
        }
        assert!(!figure.caption.contains("default"), "{}", figure.caption);
        // The compressed corner is stable, the stretched one is not.
        let map = regions(&figure.panels[0]);
        assert_eq!((map.columns, map.rows), (12, 10));
        assert_eq!(map.key[usize::from(map.classes[0])].0, "stable");
        assert_ne!(map.key[usize::from(map.classes[119])].0, "stable");
        assert!(figure.panels[0].equal_aspect);
    }
}

#[test]
fn missing_tiles_are_blank_and_counted_in_the_caption() {
    let place = Place::new();
    let store = place.store("a", &study("one", ""), 1);
    let figure = draw(std::slice::from_ref(&store), "verdict", false);
    let white = "White: 3 of 4 tiles remain to be computed.";
    assert!(figure.caption.starts_with(white), "{}", figure.caption);
    let whole = place.store("b", &study("two", ""), 100);
    for field in ["verdict", "growth_rate"] {
        let both = draw(&[whole.clone(), store.clone()], field, false);
        let left = "one: 3 of 4 tiles remain to be computed.";
        assert!(both.caption.starts_with(left), "{}", both.caption);
    }
    let map = regions(&figure.panels[0]);
    for (index, class) in map.classes.iter().enumerate() {
        let is_computed = index % 12 < 8 && index / 12 < 8;
        assert_eq!(usize::from(*class) < map.key.len(), is_computed, "{index}");
    }
}

#[test]
fn a_field_has_a_label_with_its_unit() {
    let place = Place::new();
    let store = place.store("a", &study("one", ""), 100);
    for (name, label) in [
        ("scaled_minimum", "min Re ω² / (c² |k|²) (−)"),
        ("growth_rate", "growth rate"),
    ] {
        let figure = draw(std::slice::from_ref(&store), name, false);
        let Layer::Field(field) = &figure.panels[0].layers[0] else {
            panic!("no field");
        };
        assert_eq!(field.label, label);
        assert!(field.values.iter().all(|value| value.is_finite()));
    }
    for name in ["wave_vector", "evaluated", "beauty"] {
        let asked = Plot {
            stores: std::slice::from_ref(&store),
            field: name,
            boundaries: Lines::OfCells,
            look: Look::default(),
        };
        let error = plot(&asked, &()).expect_err("not a field of numbers");
        assert!(
            error.is_input() && error.to_string().contains("growth_rate"),
            "{error}"
        );
    }
}

#[test]
fn a_study_with_units_is_drawn_and_stored_with_its_units() {
    let place = Place::new();
    let text = "[material]\nmodel = 'neo-hooke'\nlambda = '120 GPa'\n\
         [discretization]\nspacing = '1 mm'\ndensity = '7850 kg/m^3'\n\
         [[axes]]\nquantity = 'stretch-1'\nrange = [0.9, 1.1]\nstates = 3\n\
         [[axes]]\nquantity = 'material.mu'\nrange = ['70 GPa', '90 GPa']\nstates = 3\n";
    let store = place.store("a", text, 100);
    for (name, label, unit) in [
        (
            "acoustic_minimum",
            "smallest acoustic eigenvalue (Pa)",
            "Pa",
        ),
        ("growth_rate", "growth rate (1/s)", "1/s"),
        ("critical_time_step", "critical time step (s)", "s"),
        ("lowest_omega_squared", "min Re ω² (1/s²)", "1/s^2"),
    ] {
        let figure = draw(std::slice::from_ref(&store), name, false);
        let panel = &figure.panels[0];
        assert_eq!(panel.x.label, "stretch λ₁ (−)");
        assert_eq!(panel.y.label, "mu (Pa)");
        let Layer::Field(field) = &panel.layers[0] else {
            panic!("no field");
        };
        assert_eq!(field.label, label);
        let array = std::fs::read_to_string(store.join(name).join("zarr.json")).expect("metadata");
        let array: serde_json::Value = serde_json::from_str(&array).expect("JSON");
        assert_eq!(array["attributes"]["units"], unit);
        assert!(array["attributes"].get("dimension").is_none());
    }
}

#[test]
fn adjacent_fields_share_one_color_scale() {
    let place = Place::new();
    let first = place.store("a", &study("one", ""), 100);
    let second = study("two", "").replace("support = 1.9", "support = 1.6");
    let second = place.store("b", &second, 100);
    for name in ["growth_rate", "scaled_minimum"] {
        let look = |stores: &[PathBuf]| -> Vec<_> {
            let figure = draw(stores, name, false);
            let layers = figure
                .panels
                .into_iter()
                .map(|mut panel| panel.layers.remove(0));
            let looks = layers.map(|layer| match layer {
                Layer::Field(field) => (field.range.expect("a range"), field.map),
                other => panic!("{other:?}"),
            });
            looks.collect()
        };
        let both = look(&[first.clone(), second.clone()]);
        assert_eq!(both[0], both[1], "{name}");
        let alone = [
            look(std::slice::from_ref(&first)),
            look(std::slice::from_ref(&second)),
        ];
        let ends = alone.map(|looks| looks[0].0);
        let union = (ends[0].0.min(ends[1].0), ends[0].1.max(ends[1].1));
        assert_eq!(both[0].0, union, "{name}");
        assert_ne!(ends[0], ends[1], "{name}");
    }
}

#[test]
fn rounding_errors_are_drawn_as_zero() {
    let place = Place::new();
    let text = study("deficient", "").replace(
        "frame = 'eulerian'\ncurrent-lattice = 'regular'\nsupport = 1.9\n",
        "method = 'total-lagrangian-sph'\nlattice = 'square'\n",
    );
    let store = place.store("a", &text, 100);
    for name in ["scaled_minimum", "lowest_omega_squared"] {
        let figure = draw(std::slice::from_ref(&store), name, false);
        let Layer::Field(field) = &figure.panels[0].layers[0] else {
            panic!("no field");
        };
        // Where the material is elliptic, the minimum belongs to a zero-energy mode.
        assert!(field.values.contains(&0.0), "{name}");
        let is_noise = |value: &&f64| **value != 0.0 && value.abs() < 1e-11;
        assert_eq!(field.values.iter().filter(is_noise).count(), 0, "{name}");
    }
}

#[test]
fn a_map_with_three_axes_is_drawn_in_sections_with_their_values() {
    let place = Place::new();
    let third = "[[axes]]\nquantity = 'rotation'\nrange = [0.0, 0.5]\nstates = 9\n";
    let text = study("three", third)
        .replace("states = 12", "states = 4")
        .replace("states = 10", "states = 3");
    let store = place.store("a", &text, 100);
    let figure = draw(&[store], "verdict", false);
    let titles: Vec<&str> = figure
        .panels
        .iter()
        .map(|panel| panel.title.as_str())
        .collect();
    assert_eq!(titles.len(), 6);
    assert_eq!(titles[0], "rotation of the lattice θ = 0.02778 rad");
    assert_eq!(titles[5], "rotation of the lattice θ = 0.4722 rad");
    assert!(
        regions(&figure.panels[3])
            .classes
            .iter()
            .all(|class| *class < 7)
    );
}

#[test]
fn several_discretizations_are_overlaid_on_the_domain_of_their_material() {
    let place = Place::new();
    let first = place.store("a", &study("first", ""), 1);
    let second = study("second", "").replace("support = 1.9", "support = 1.6");
    let second = place.store("b", &second, 1);
    let figure = draw(&[first.clone(), second], "verdict", true);
    assert_eq!(
        names(&figure),
        [
            "strongly elliptic material",
            "material not elliptic",
            "boundary of the material",
            "first",
            "second"
        ]
    );
    let lines: Vec<Symbol> = figure.legend_entries()[3..]
        .iter()
        .map(|entry| entry.symbol)
        .collect();
    assert_ne!(lines[0], lines[1]);
    // Shared settings are printed once.
    let caption = &figure.caption;
    assert_eq!(
        caption.matches("Material: modified-mooney-rivlin").count(),
        1,
        "{caption}"
    );
    assert!(
        caption.contains(" first: support 1.9. second: support 1.6."),
        "{caption}"
    );

    let other = study("other", "").replace(
        "[discretization]",
        "[material]\nmodel = 'blatz-ko'\n[discretization]",
    );
    let other = place.store("c", &other, 1);
    let asked = Plot {
        stores: &[first, other],
        field: "verdict",
        boundaries: Lines::Traced,
        look: Look::default(),
    };
    let error = plot(&asked, &()).expect_err("another material");
    assert!(
        error.to_string().contains("they have different materials"),
        "{error}"
    );
}

/// Counts the states that are evaluated.
#[derive(Default)]
struct Asked(std::sync::atomic::AtomicU64);

impl onset_study::boundary::Watch for Asked {
    fn asked(&self, states: u64) {
        self.0.fetch_add(states, Ordering::Relaxed);
    }
}

fn drawn_best(store: PathBuf) -> (onset_study::figure::Figure, u64) {
    let asked = Asked::default();
    let plot_of = Plot {
        stores: &[store],
        field: "verdict",
        boundaries: Lines::Best,
        look: Look::default(),
    };
    let figure = plot(&plot_of, &asked).expect("a figure");
    (figure, asked.0.into_inner())
}

#[test]
fn the_boundaries_of_a_map_that_varies_the_method_are_taken_from_its_cells() {
    let place = Place::new();
    let text = "title = 'a'\n[discretization]\nframe = 'eulerian'\n[state]\nstretch-2 = 1.0\n\
         [[axes]]\nquantity = 'stretch-1'\nrange = [0.7, 1.6]\nstates = 9\n\
         [[axes]]\nquantity = 'discretization.support'\nrange = [1.4, 2.4]\nstates = 10\n";
    let store = place.store("a", text, 10);
    let (figure, asked) = drawn_best(store);
    assert_eq!(asked, 0);
    assert!(
        names(&figure)
            .iter()
            .any(|name| name == "boundary of the discretization")
    );
    // The boundaries of one method over stretches are traced.
    let store = place.store("b", &study("one", ""), 100);
    let (figure, asked) = drawn_best(store.clone());
    assert!(asked > 1000);
    assert_eq!(figure, draw(&[store], "verdict", true));
}

#[test]
fn tracing_ends_at_its_time_limit() {
    use onset::cancel::unless;
    use onset_study::boundary::{Boundaries, Tracing};
    let study = Study::parse("study.toml", &study("one", "")).expect("a study");
    let now = std::time::Instant::now();
    let traced = || Boundaries::of(&study, Tracing::default(), &());
    assert!(unless(move || now.elapsed().as_millis() > 20, traced).is_none());
    assert!(now.elapsed().as_secs() < 2);
}

#[test]
fn ranges_and_colors_of_a_figure_can_be_set() {
    use onset_study::figure::ColorMap;
    let place = Place::new();
    let store = place.store("a", &study("one", ""), 100);
    let look = Look {
        x: Some((0.7, 1.1)),
        y: Some((0.8, 1.2)),
        range: Some((-1.0, 0.25)),
        color_map: Some(ColorMap::Cividis),
    };
    let asked = Plot {
        stores: &[store],
        field: "scaled_minimum",
        boundaries: Lines::OfCells,
        look,
    };
    let figure = plot(&asked, &()).expect("a figure");
    // Verdicts have no color bar.
    let verdicts = Plot {
        field: "verdict",
        ..asked
    };
    let refused = plot(&verdicts, &()).expect_err("a refusal").to_string();
    assert!(refused.starts_with("--limits has no effect"), "{refused}");
    let panel = &figure.panels[0];
    assert_eq!((panel.x.range, panel.y.range), ((0.7, 1.1), (0.8, 1.2)));
    let Layer::Field(field) = &panel.layers[0] else {
        panic!("{:?}", panel.layers[0]);
    };
    assert_eq!(
        (field.range, field.map),
        (Some((-1.0, 0.25)), ColorMap::Cividis)
    );
}
