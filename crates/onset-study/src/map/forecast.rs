//! What a map will cost, told before it is computed.
//!
//! States on a grid over the whole window are computed as the map computes them, on finer and finer grids while time allows. Of an
//! adaptive map the refinement is then rehearsed with what lies between them, interpolated, in the place of states: that tells how many
//! states it will compute.

use super::adaptive::refine;
use super::evaluate::Evaluator;
use super::layout::tiling;
use super::record::{Finding, Record};
use crate::answers::ProblemError;
use crate::settings::{Quantity, Study};
use crate::store::{Tile, Tiling, ravel, unravel};
use onset::bloch::Stability;
use onset::kinematics::DeformationGradient;
use std::collections::BTreeSet;
use std::convert::Infallible;
use std::time::{Duration, Instant};

/// States of the grid along each axis, one grid after the other.
const GRIDS: [usize; 6] = [2, 3, 5, 9, 17, 33];
/// Tiles of an adaptive map that are rehearsed, evenly chosen.
const REHEARSED: usize = 200;
/// The time after which no finer grid is begun, where nobody says otherwise.
pub const PATIENCE: Duration = Duration::from_millis(600);

/// What a map will cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forecast {
    /// Its tiles.
    pub tiles: usize,
    /// How many states will be computed; others are filled in.
    pub evaluations: u64,
    /// How often material and method will be set up.
    pub preparations: u64,
    /// How many states were computed to tell.
    pub sampled: usize,
    /// Processor time of a state, in the company of others as in the map; seconds.
    pub seconds_per_state: f64,
    /// Processor time of setting up material and method; seconds.
    pub seconds_per_preparation: f64,
}

impl Forecast {
    /// For a study. Finer grids are begun until `patience` is over.
    ///
    /// # Errors
    /// [`ProblemError`] when the material or the discretization is not admissible.
    pub fn of(study: &Study, patience: Duration) -> Result<Self, ProblemError> {
        let tiling = tiling(study);
        let shared = if study.varies_settings() {
            None
        } else {
            let start = Instant::now();
            let evaluator = Evaluator::new(study.settings.clone(), &study.map, true)?;
            Some((evaluator, start.elapsed()))
        };
        let start = Instant::now();
        let mut sample = Sample::of(study, &tiling, shared.as_ref(), GRIDS[0])?;
        for count in &GRIDS[1..] {
            // A grid twice as fine has so many times as many states.
            let growth = 2_u32.pow(tiling.shape.len() as u32);
            if sample.is_all() || start.elapsed() + growth * sample.time() > patience {
                break;
            }
            sample = Sample::of(study, &tiling, shared.as_ref(), *count)?;
        }
        let (evaluations, preparations) = if study.map.adaptive {
            rehearsed(study, &tiling, &sample)
        } else {
            let of_tile = |tile| prepared_in(study, &tiling.at(tile)).product::<usize>() as u64;
            let preparations = (0..tiling.tiles()).map(of_tile).sum();
            (tiling.states() as u64, preparations)
        };
        let states = sample.records.len();
        let per_preparation = match &shared {
            Some((_, time)) => time.as_secs_f64(),
            None => sample.preparing.as_secs_f64() / states as f64,
        };
        Ok(Self {
            tiles: tiling.tiles(),
            evaluations,
            preparations: if shared.is_some() { 1 } else { preparations },
            sampled: states,
            seconds_per_state: sample.computing.as_secs_f64() / states as f64,
            seconds_per_preparation: per_preparation,
        })
    }

    /// Processor time of the whole map; seconds.
    pub fn seconds(&self) -> f64 {
        self.evaluations as f64 * self.seconds_per_state
            + self.preparations as f64 * self.seconds_per_preparation
    }
}

/// Materials and methods in a tile along each of its dimensions: as many as states where a setting varies, otherwise one.
fn prepared_in<'a>(study: &'a Study, tile: &'a Tile) -> impl Iterator<Item = usize> + 'a {
    let axes = study.axes.iter().rev().zip(&tile.extent);
    axes.map(|(axis, states)| match axis.quantity {
        Quantity::Setting(_) => *states,
        _ => 1,
    })
}

/// States on a grid over the whole window.
struct Sample<'a> {
    /// States of the map along each dimension, slowest first, and points of the grid.
    shape: &'a [usize],
    grid: Vec<usize>,
    records: Vec<Record>,
    preparing: Duration,
    computing: Duration,
}

impl<'a> Sample<'a> {
    fn of(
        study: &Study,
        tiling: &'a Tiling,
        shared: Option<&(Evaluator, Duration)>,
        count: usize,
    ) -> Result<Self, ProblemError> {
        let grid: Vec<usize> = tiling
            .shape
            .iter()
            .map(|states| count.min(*states))
            .collect();
        let mut sample = Self {
            shape: &tiling.shape,
            records: Vec::new(),
            preparing: Duration::ZERO,
            computing: Duration::ZERO,
            grid,
        };
        let places: Vec<Vec<f64>> = (0..sample.grid.iter().product())
            .map(|point| study.coordinates(sample.state(point)))
            .collect();
        let states: Vec<DeformationGradient> = places
            .iter()
            .map(|place| study.deformation_at(place))
            .collect::<Result<_, _>>()?;
        // States that cannot be computed are told about elsewhere.
        let known = |record: Result<Record, ProblemError>| record.unwrap_or(Record::UNDEFINED);
        if let Some((evaluator, _)) = shared {
            let start = Instant::now();
            let records = evaluator.records(&states);
            sample.computing = start.elapsed();
            sample.records = records.into_iter().map(known).collect();
            return Ok(sample);
        }
        for (place, f) in places.iter().zip(&states) {
            let start = Instant::now();
            let evaluator = Evaluator::new(study.settings_at(place)?, &study.map, false)?;
            sample.preparing += start.elapsed();
            let start = Instant::now();
            let record = evaluator.records(std::slice::from_ref(f)).pop();
            sample.computing += start.elapsed();
            sample.records.push(record.map_or(Record::UNDEFINED, known));
        }
        Ok(sample)
    }

    fn time(&self) -> Duration {
        self.preparing + self.computing
    }

    /// Whether every state of the map is a point of the grid.
    fn is_all(&self) -> bool {
        self.grid == self.shape
    }

    /// The number of the state at a point of the grid.
    fn state(&self, point: usize) -> usize {
        let place = unravel(point, &self.grid);
        let along = place.iter().zip(&self.grid).zip(self.shape);
        let state = |((point, points), states): ((&usize, &usize), &usize)| {
            point * (states - 1) / (points - 1).max(1)
        };
        ravel(&along.map(state).collect::<Vec<_>>(), self.shape)
    }

    /// What a state is likely to be: measures between those of the points around it, and the finding of the nearest of them that has the
    /// same signs of measures.
    fn likely(&self, place: &[usize]) -> Record {
        let dimensions = self.shape.len();
        let (mut low, mut share) = (vec![0; dimensions], vec![0.0; dimensions]);
        for (i, state) in place.iter().enumerate() {
            let steps = self.grid[i] - 1;
            let x = *state as f64 * steps as f64 / (self.shape[i] - 1).max(1) as f64;
            low[i] = (x as usize).min(steps.saturating_sub(1));
            share[i] = x - low[i] as f64;
        }
        let corners: Vec<(f64, &Record)> = (0..1_usize << dimensions)
            .map(|corner| {
                let is_high = |i: usize| corner >> i & 1 == 1;
                let weight = |i: usize| if is_high(i) { share[i] } else { 1.0 - share[i] };
                let along = |i: usize| (low[i] + usize::from(is_high(i))).min(self.grid[i] - 1);
                let point: Vec<usize> = (0..dimensions).map(along).collect();
                let record = &self.records[ravel(&point, &self.grid)];
                ((0..dimensions).map(weight).product(), record)
            })
            .collect();
        let nearest = |fits: &dyn Fn(&Record) -> bool| {
            let fitting = corners.iter().filter(|(_, record)| fits(record));
            fitting
                .max_by(|a, b| a.0.total_cmp(&b.0))
                .map(|(_, record)| **record)
        };
        let near = nearest(&|_| true).unwrap_or(Record::UNDEFINED);
        let measures: [f64; 3] = std::array::from_fn(|n| {
            let between: f64 = corners
                .iter()
                .map(|(w, record)| w * record.measures[n])
                .sum();
            if between.is_nan() {
                near.measures[n]
            } else {
                between
            }
        });
        let signs = |finding: Finding, measures: [f64; 3]| match finding.stability {
            Some(Stability::Stable) => Some([measures[0] >= 0.0, true]),
            Some(_) => Some([measures[0] >= 0.0, false]),
            None => None,
        };
        let own = near
            .finding
            .stability
            .map(|_| [measures[0] >= 0.0, measures[1] >= 0.0]);
        let alike = nearest(&|record| signs(record.finding, record.measures) == own);
        Record {
            finding: alike.unwrap_or(near).finding,
            measures,
            ..Record::UNDEFINED
        }
    }
}

/// The states that an adaptive map will compute, and the materials and methods that it will set up for them.
fn rehearsed(study: &Study, tiling: &Tiling, sample: &Sample<'_>) -> (u64, u64) {
    let tiles = tiling.tiles();
    let some = tiles.min(REHEARSED);
    let (mut states, mut prepared) = (0, 0);
    for n in 0..some {
        let tile = tiling.at((2 * n + 1) * tiles / (2 * some));
        let varied: Vec<usize> = prepared_in(study, &tile).collect();
        let computed = std::cell::RefCell::new((0_u64, BTreeSet::new()));
        let likely = |batch: &[usize]| -> Result<Vec<Record>, Infallible> {
            let mut computed = computed.borrow_mut();
            computed.0 += batch.len() as u64;
            let record = |state: &usize| {
                let place = unravel(*state, &tile.extent);
                let along = place
                    .iter()
                    .zip(&varied)
                    .map(|(place, states)| place % states);
                computed
                    .1
                    .insert(ravel(&along.collect::<Vec<_>>(), &varied));
                let whole: Vec<usize> =
                    place.iter().zip(&tile.origin).map(|(a, b)| a + b).collect();
                sample.likely(&whole)
            };
            Ok(batch.iter().map(record).collect())
        };
        let Ok(_) = refine(&tile.extent, study.map.refine_from, likely);
        let (own, materials) = computed.into_inner();
        states += own;
        prepared += materials.len() as u64;
    }
    let scaled = |count: u64| (count as f64 * tiles as f64 / some as f64).round() as u64;
    (scaled(states), scaled(prepared))
}
