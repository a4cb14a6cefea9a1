//! The forecast cost of a map is close to its actual cost.

use onset_study::map::{Forecast, Plan, Watch};
use onset_study::settings::Study;
use onset_study::store::ZarrStore;
use std::path::PathBuf;
use std::time::Duration;

struct Quiet;

impl Watch for Quiet {
    fn advance(&self, _: u64) {}

    fn is_interrupted(&self) -> bool {
        false
    }
}

/// Time limit that suffices for the finest grid, so that the forecast does not depend on the machine.
const PATIENCE: Duration = Duration::from_secs(3600);

fn study(text: &str) -> Study {
    Study::parse("study.toml", text).expect("a study")
}

/// Number of states that a map computes.
fn counted(study: &Study, name: &str) -> u64 {
    let plan = Plan::new(study).expect("a plan");
    let path: PathBuf =
        std::env::temp_dir().join(format!("onset-forecast-{}-{name}.zarr", std::process::id()));
    let store = ZarrStore::create(&path, plan.layout()).expect("a store");
    let tiles = plan.tiles(None).expect("tiles");
    let summary = plan.run(&store, &tiles, &Quiet).expect("a map");
    std::fs::remove_dir_all(&path).expect("removable");
    summary.evaluated
}

#[test]
fn the_forecast_counts_the_tiles_of_the_map_for_any_axes() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../studies");
    let mut three = 0;
    for entry in std::fs::read_dir(folder).expect("studies") {
        let path = entry.expect("a file").path();
        if path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        let study = study(&std::fs::read_to_string(&path).expect("text"));
        three += usize::from(study.axes.len() == 3);
        let summary = onset_study::answers::StudySummary::new("a", &study).expect("a summary");
        let plan = Plan::new(&study).expect("a plan");
        assert_eq!(summary.tiles, plan.tiling().tiles(), "{}", path.display());
    }
    assert!(three > 0);
}

#[test]
fn the_forecast_states_of_an_adaptive_map_are_accurate_within_a_factor_of_one_and_a_half() {
    let axes = |first: (f64, f64), second: (f64, f64), states: usize| {
        format!(
            "[[axes]]\nquantity = 'stretch-1'\nrange = [{}, {}]\nstates = {states}\n\
             [[axes]]\nquantity = 'stretch-2'\nrange = [{}, {}]\nstates = {states}\n\
             [map]\nadaptive = true\n",
            first.0, first.1, second.0, second.1
        )
    };
    let wide = axes((0.5, 3.0), (0.5, 3.0), 256);
    let cases = [
        ("lagrangian", format!("title = 'a'\n{wide}")),
        (
            "blatz-ko",
            format!(
                "title = 'a'\n[material]\nmodel = 'blatz-ko'\n{}",
                axes((0.3, 4.0), (0.3, 4.0), 300)
            ),
        ),
        (
            "sph",
            format!(
                "title = 'a'\n[discretization]\nmethod = 'updated-sph'\n{}",
                axes((0.8, 1.3), (0.8, 1.3), 128)
            ),
        ),
        (
            "support",
            "title = 'a'\n[discretization]\nframe = 'eulerian'\n[state]\nstretch-2 = 1.0\n\
             [[axes]]\nquantity = 'stretch-1'\nrange = [0.7, 1.6]\nstates = 64\n\
             [[axes]]\nquantity = 'discretization.support'\nrange = [1.4, 2.4]\nstates = 64\n\
             [map]\nadaptive = true\n"
                .to_owned(),
        ),
    ];
    for (name, text) in cases {
        let study = study(&text);
        let forecast = Forecast::of(&study, PATIENCE).expect("a forecast");
        let counted = counted(&study, name);
        let ratio = forecast.evaluations as f64 / counted as f64;
        assert!(
            (1.0 / 1.5..=1.5).contains(&ratio),
            "{name}: {} foretold, {counted} computed",
            forecast.evaluations
        );
        // Some states must be filled in, or the forecast would be trivial.
        assert!(
            counted < study.states() as u64 * 9 / 10,
            "{name}: {counted}"
        );
    }
}

#[test]
fn the_forecast_of_a_full_map_counts_every_state_and_each_preparation_once_per_tile() {
    let text = "title = 'a'\n[discretization]\nframe = 'eulerian'\n\
         [[axes]]\nquantity = 'stretch-1'\nrange = [0.9, 1.1]\nstates = 20\n\
         [[axes]]\nquantity = 'discretization.support'\nrange = [1.5, 1.9]\nstates = 10\n\
         [map]\ntile = 8\n";
    let study = study(text);
    let forecast = Forecast::of(&study, Duration::ZERO).expect("a forecast");
    assert_eq!(forecast.evaluations, counted(&study, "all"));
    // Three tiles along the stretches, each with ten supports.
    assert_eq!((forecast.tiles, forecast.preparations), (6, 30));
    let whole = forecast.seconds();
    assert!(whole > 0.0 && whole.is_finite());
}
