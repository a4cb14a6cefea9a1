//! Tests of comparisons: tables, ranking, and the comparison files of the program.

use onset::measures::{DispersionError, Extent, Fidelity, Load, OnsetPair, StretchOnset};
use onset_study::brief::Brief;
use onset_study::compare::{Measured, PANELS, Row, Table, Thresholds, WAVELENGTHS, recommended};
use onset_study::figure::Layer;
use onset_study::modes::{Fit, ModesAnswer, ModesQuestion, ShownMode};
use onset_study::settings::{CompareSettings, Comparison, Settings, Units};
use onset_study::tune::TuneQuestion;

/// Measures of a faithful method.
fn good() -> Measured {
    Measured {
        zero_modes: 0,
        zero_extent: None,
        zero_modes_complete: true,
        weak_modes: 0,
        weakest: 0.8,
        dispersion: WAVELENGTHS
            .iter()
            .map(|count| DispersionError {
                particles_per_wavelength: *count,
                error: 1.0 / count,
            })
            .collect(),
        long_wave_error: 0.01,
        onsets: vec![OnsetPair {
            load: Load::UniaxialStrainTension,
            material: StretchOnset::At(2.0),
            method: StretchOnset::At(2.0),
        }],
        fidelity: Fidelity {
            elliptic: 1.0,
            ..Fidelity::default()
        },
        critical_time_step: 0.5,
        critical_time_step_of: onset_study::answers::LATTICE_NOTE,
        body: None,
        courant: 1.0,
        body_courant: None,
        neighbors: 10.0,
    }
}

fn table(rows: Vec<(&str, Result<Measured, String>)>) -> Table {
    Table {
        title: String::new(),
        notes: Vec::new(),
        material: "neo-hooke".to_owned(),
        dimension: 1,
        options: CompareSettings::default(),
        thresholds: Thresholds::default(),
        evidence: onset_study::answers::Evidence::Searched,
        rows: rows
            .into_iter()
            .map(|(name, measured)| Row {
                name: name.to_owned(),
                settings: Settings::default().effective(),
                notes: Vec::new(),
                measured,
            })
            .collect(),
    }
}

/// The rule that excludes a method.
fn rule(measured: Measured) -> Option<usize> {
    let ranked = recommended(&table(vec![("one", Ok(measured))]));
    ranked[0].excluded.as_ref().map(|(rule, _)| *rule)
}

#[test]
fn each_rule_excludes_the_methods_that_it_describes() {
    let with = |change: fn(&mut Measured)| {
        let mut measured = good();
        change(&mut measured);
        rule(measured)
    };
    assert_eq!(rule(good()), None);
    assert_eq!(with(|m| m.onsets[0].method = StretchOnset::AtRest), Some(1));
    assert_eq!(with(|m| m.fidelity.undefined = 0.01), Some(1));
    assert_eq!(with(|m| m.zero_modes = 1), Some(2));
    assert_eq!(with(|m| m.weakest = 0.09), Some(2));
    assert_eq!(with(|m| m.weakest = 0.11), None);
    assert_eq!(with(|m| m.fidelity.false_instability = 0.006), Some(3));
    assert_eq!(with(|m| m.fidelity.suppressed_instability = 0.006), Some(4));
    assert_eq!(with(|m| m.long_wave_error = 0.06), Some(5));
    // The method is not at fault if the law is undefined.
    assert_eq!(with(|m| m.fidelity.outside_law = 0.5), None);
}

#[test]
fn methods_are_ranked_by_error_times_cost_with_excluded_methods_last() {
    let with = |change: fn(&mut Measured)| {
        let mut measured = good();
        change(&mut measured);
        Ok(measured)
    };
    let ranked = recommended(&table(vec![
        ("broken", Err("no neighbors\nand more".to_owned())),
        ("rank deficient", with(|m| m.zero_modes = 3)),
        ("dear", with(|m| m.neighbors = 30.0)),
        ("good", with(|_| {})),
        ("soft", with(|m| m.long_wave_error = 1.0)),
        ("small steps", with(|m| m.courant = 0.5)),
    ]));
    let names: Vec<&str> = ranked.iter().map(|one| one.name.as_str()).collect();
    assert_eq!(
        names,
        [
            "good",
            "small steps",
            "dear",
            "soft",
            "rank deficient",
            "broken"
        ]
    );
    assert_eq!(ranked[0].score, 10.0 / 8.0);
    assert_eq!(ranked[1].score, 20.0 / 8.0);
    let (rule, why) = ranked[5].excluded.as_ref().expect("excluded");
    assert_eq!((*rule, why.as_str()), (1, "no neighbors"));
}

#[test]
fn names_with_commas_and_quotes_stay_one_field_of_the_csv_file() {
    let csv = table(vec![
        ("a, \"b\"", Ok(good())),
        ("c", Err("one\ntwo, three".to_owned())),
    ])
    .csv();
    let lines: Vec<&str> = csv.lines().collect();
    assert_eq!(lines.len(), 3);
    assert!(
        lines[0].starts_with("method,zero_modes,weakest,dispersion_4,"),
        "{csv}"
    );
    assert!(
        lines[0].ends_with(",neighbors,zero_modes_complete,note"),
        "{csv}"
    );
    assert!(lines[1].starts_with("\"a, \"\"b\"\"\",0,"), "{csv}");
    assert!(lines[1].ends_with(",true,"), "{csv}");
    assert!(lines[2].starts_with("c,,,"), "{csv}");
    assert!(lines[2].ends_with(",\"one two, three\""), "{csv}");
    let fields = lines[0].split(',').count();
    assert_eq!(
        lines[1].split(',').count(),
        fields + 1,
        "one comma in quotes"
    );
    assert_eq!(
        lines[2].split(',').count(),
        fields + 1,
        "one comma in quotes"
    );
}

#[test]
fn modes_that_fill_lines_are_marked_in_the_table() {
    let mut filled = good();
    (filled.zero_modes, filled.zero_extent) = (32, Some(Extent::Line));
    let text = table(vec![("filled", Ok(filled)), ("good", Ok(good()))]).to_string();
    assert!(text.contains(" 32* "), "{text}");
    assert_eq!(
        text.matches('*').count(),
        2,
        "in the table and in its legend: {text}"
    );
}

#[test]
fn rational_wave_vectors_are_printed_as_fractions() {
    let at = |fractional: &[f64]| {
        let mode = ShownMode {
            wave_vector: fractional.to_vec(),
            fractional: fractional.to_vec(),
            wave: fractional.to_vec(),
            unfolded: None,
            relative_frequency: 0.25,
            nullity: 0,
            extent: Extent::Point,
            fits: true,
            fit: Fit {
                cells: 1,
                fractional: Vec::new(),
                error: 0.0,
            },
            positions: Vec::new(),
            displacements: Vec::new(),
            quarter: Vec::new(),
        };
        mode.place()
    };
    // Opposite wave vectors are equivalent, and wave vectors that differ by a reciprocal vector.
    assert_eq!(at(&[0.5, -1.0 / 3.0]), "(1/2, 1/3)");
    assert_eq!(at(&[0.0, 1.0, 5.0 / 12.0]), "(0, 1, 5/12)");
    assert_eq!(at(&[0.123456]), "(0.1235)");
    assert_eq!(at(&[-1e-17]), "(0)");
}

#[test]
fn the_values_of_a_coefficient_include_the_ends_of_the_range() {
    let values = |low, high| {
        TuneQuestion::new("discretization.penalty", (low, high), (0.7, 1.5))
            .expect("a question")
            .values()
    };
    for (low, high) in [(0.0, 1.0), (0.1, 0.3), (-1.0, 2.0), (0.0, 7.3), (1e-8, 1e8)] {
        let all = values(low, high);
        assert_eq!((all[0], all[all.len() - 1]), (low, high));
        assert!(all.windows(2).all(|pair| pair[0] < pair[1]), "{all:?}");
    }
    // The values are evenly spaced in the logarithm.
    let all = values(0.0, 1.0);
    assert_eq!(all.len(), 14);
    assert!((all[1] - 1e-4).abs() < 1e-18);
    assert!((all[3] / all[2] - all[9] / all[8]).abs() < 1e-12);
}

#[test]
fn every_method_of_the_built_in_comparisons_can_be_measured() {
    for (dimension, (name, text)) in PANELS.iter().enumerate() {
        // A few states suffice here.
        let comparison =
            Comparison::parse(name, text, &["compare.states=2"]).expect("a comparison");
        assert_eq!(comparison.dimension(), dimension + 1);
        let table = Table::of(&comparison, |_| {}).expect("a table");
        for row in &table.rows {
            assert!(
                row.measured.is_ok(),
                "{name}, {}: {:?}",
                row.name,
                row.measured
            );
        }
        if dimension == 1 {
            assert_eq!(table.rows.len(), 20);
        }
    }
}

#[test]
fn the_material_has_the_same_onset_in_every_row() {
    let (name, text) = PANELS[1];
    let comparison = Comparison::parse(name, text, &["compare.states=2"]).expect("a comparison");
    let table = Table::of(&comparison, |_| {}).expect("a table");
    let rows = || {
        table
            .rows
            .iter()
            .filter_map(|row| row.measured.as_ref().ok())
    };
    let first = rows().next().expect("a row");
    for row in rows() {
        for (own, other) in row.onsets.iter().zip(&first.onsets) {
            assert_eq!(own.material, other.material);
        }
    }
}

#[test]
fn a_mode_is_exported_with_the_requested_amplitude() {
    let settings = Settings::from_assignments(&[
        "discretization.lattice=square",
        "discretization.quadrature=nodal",
        "discretization.spacing=0.5",
    ])
    .expect("settings");
    let question = ModesQuestion {
        amplitude: 0.1,
        cells: 4,
        ..ModesQuestion::default()
    };
    let answer = ModesAnswer::new(&settings, &question).expect("modes");
    assert_eq!(answer.modes.len(), 3);
    for mode in &answer.modes {
        assert_eq!(mode.positions.len(), 16);
        let largest = |all: &[[f64; 3]]| {
            let sizes = all
                .iter()
                .map(|u| u.iter().map(|x| x * x).sum::<f64>().sqrt());
            sizes.fold(0.0, f64::max)
        };
        let size = largest(&mode.displacements);
        assert!((size - 0.05).abs() < 1e-9, "{size}");
        // At the edges of the zone modes are standing waves.
        assert!(largest(&mode.quarter) < 1e-9);
        assert_eq!(mode.csv(Units::Own).lines().count(), 17);
    }
}

#[test]
fn the_courant_number_of_disordered_particles_uses_the_spacing_of_their_lattice() {
    let of = |perturbation: &str| {
        let settings = Settings::from_assignments(&[
            "discretization.method=total-lagrangian-sph",
            "discretization.lattice=chain",
            "discretization.cells=4",
            "discretization.support=1.6",
            "discretization.spacing=0.5",
            perturbation,
        ])
        .expect("settings");
        let material = settings.material.build().expect("a material");
        let options = CompareSettings {
            states: 1,
            ..CompareSettings::default()
        };
        let rest = onset::kinematics::DeformationGradient::identity();
        let modulus = onset::continuum::Stiffness::<1>::at(&*material, &rest)
            .expect("a tangent")
            .maximum_eigenvalue();
        let measured = Measured::of(&settings, material, &options).expect("a row");
        let step = measured.critical_time_step * modulus.sqrt() / 0.5;
        assert!((measured.courant / step - 1.0).abs() < 1e-12);
        measured.neighbors
    };
    assert_eq!(of("discretization.perturbation=0"), 3.0);
    of("discretization.perturbation=0.25");
}

#[test]
fn the_page_states_the_elliptic_range_and_the_figure_shows_onsets_outside_it() {
    use onset_study::figure::{Layer, Marker};
    let pair = |load, material, method| OnsetPair {
        load,
        material,
        method,
    };
    let mut measured = good();
    measured.onsets = vec![
        pair(
            Load::UniaxialStrainTension,
            StretchOnset::NotBefore(3.0),
            StretchOnset::NotBefore(3.0),
        ),
        pair(
            Load::UniaxialStrainCompression,
            StretchOnset::At(0.4),
            StretchOnset::NotBefore(0.3),
        ),
        pair(
            Load::EquibiaxialStrainTension,
            StretchOnset::NotBefore(3.0),
            StretchOnset::At(1.5),
        ),
        pair(
            Load::EquibiaxialStrainCompression,
            StretchOnset::NotBefore(0.3),
            StretchOnset::Undefined(0.5),
        ),
    ];
    let mut table = table(vec![("one", Ok(measured))]);
    table.dimension = 2;
    let page = table.html();
    for told in [
        "loses ellipticity at 0.4000 in compression along axis 1, the other held.",
        "stays elliptic up to 3 in stretch along axis 1, the other held, up to 3 in equibiaxial stretch, up to 0.3 in",
    ] {
        assert!(page.contains(told), "{told}");
    }
    assert!(!page.contains("ellipticity at &gt;") && !page.contains("ellipticity at >"));
    let panel = &table.figure().panels[0];
    let marked = |marker: Marker| -> Vec<f64> {
        let points = panel.layers.iter().filter_map(|layer| match layer {
            Layer::Points(points) if points.marker == marker => Some(&points.points),
            _ => None,
        });
        points.flatten().map(|point| point.0).collect()
    };
    let (low, high) = panel.x.range;
    let [below, above] = [Marker::Left, Marker::Right].map(marked);
    assert!(matches!(above[..], [x] if x > 3.0 && x < high), "{above:?}");
    assert!(matches!(below[..], [x] if x < 0.3 && x > low), "{below:?}");
    assert_eq!(marked(Marker::Cross), [0.5]);
}

#[test]
fn methods_without_names_are_named_after_what_differs() {
    let names = |text: &str| -> Vec<String> {
        let comparison = Comparison::parse("methods", text, &[] as &[&str]).expect("methods");
        let candidates = comparison.candidates.into_iter();
        candidates.map(|own| own.name).collect()
    };
    let sph = "[[methods]]\nmethod = 'total-lagrangian-sph'\nlattice = 'square'\n";
    assert_eq!(
        names(&format!("{sph}penalty = 0.4\n{sph}")),
        ["total-lagrangian-sph, penalty 0.4", "total-lagrangian-sph"]
    );
    let other = "[[methods]]\nmethod = 'updated-sph'\nlattice = 'square'\n";
    assert_eq!(
        names(&format!(
            "{sph}{other}[[methods]]\nname = 'mine'\nlattice = 'square'\n"
        )),
        ["total-lagrangian-sph", "updated-sph", "mine"]
    );
    let varied = Comparison::varied(
        "methods",
        other,
        &[],
        &["discretization.kernel=cubic-spline,wendland-c2"],
    );
    let first = &varied.expect("variants").candidates[0];
    assert_eq!(first.name, "kernel cubic-spline");
}

#[test]
fn markers_of_a_row_do_not_touch_and_every_symbol_is_in_the_legend() {
    let at_rest = |_: Load| StretchOnset::AtRest;
    let beyond = |load: Load| StretchOnset::NotBefore(if load.is_tension() { 3.0 } else { 0.4 });
    let with = |method: &dyn Fn(Load) -> StretchOnset| {
        let mut measured = good();
        measured.onsets = Load::ALL
            .map(|load| OnsetPair {
                load,
                material: StretchOnset::At(2.0),
                method: method(load),
            })
            .to_vec();
        measured.fidelity.false_instability = 0.5;
        measured.fidelity.zero_energy = 0.5;
        Ok(measured)
    };
    let mut own = table(vec![
        ("unstable", with(&at_rest)),
        ("stable", with(&beyond)),
    ]);
    own.dimension = 2;
    let figure = own.figure();
    for panel in &figure.panels {
        let pixels = 17.0 * panel.lines.expect("a height") / own.rows.len() as f64;
        let mut points: Vec<(f64, f64)> = Vec::new();
        for layer in &panel.layers {
            if let Layer::Points(layer) = layer {
                points.extend(&layer.points);
            }
        }
        for (n, one) in points.iter().enumerate() {
            for other in &points[..n] {
                let apart = (one.1 - other.1).abs() * pixels;
                assert!(one.0 != other.0 || apart >= 6.0, "{}: {apart}", panel.title);
            }
        }
    }
    let names: Vec<String> = figure
        .legend_entries()
        .into_iter()
        .map(|own| own.name)
        .collect();
    let arrows = names
        .iter()
        .filter(|name| *name == "stable beyond the range");
    assert_eq!(arrows.count(), 1, "{names:?}");
}

#[test]
fn the_table_has_a_row_for_the_material_and_verdicts_as_text() {
    let mut weak = good();
    weak.weakest = 0.05;
    let own = table(vec![("good", Ok(good())), ("weak", Ok(weak))]);
    let short = own.brief().text(false);
    let row = |name: &str| {
        short
            .lines()
            .find(|line| line.starts_with(name))
            .expect("a row")
            .to_owned()
    };
    assert!(row("the material").contains("2.0000"), "{short}");
    assert!(row("good").ends_with("recommended"), "{short}");
    assert!(row("weak").ends_with("zero-energy"), "{short}");
    assert!(!short.contains("rule 2"), "{short}");
    assert!(own.to_string().contains("\nthe material "), "{own}");
}
