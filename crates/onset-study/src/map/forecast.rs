//! Forecast of the cost of a map before it is computed.
//!
//! For an adaptive map, states are computed on successively finer grids over the window while time allows. A trial refinement with values
//! interpolated on the finest grid then predicts the states that the map will compute. Some states, spread evenly over the map, are computed as in
//! the map and timed by processor time, which other processes do not affect.

use super::adaptive::refine;
use super::clock::Clock;
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

/// Number of grid points along each axis, for successively finer grids.
const GRID_POINTS: [usize; 6] = [2, 3, 5, 9, 17, 33];
/// Largest number of tiles, chosen evenly, for which the refinement is tried.
const MAX_REHEARSED_TILES: usize = 200;
/// Numbers of timed states: in the first group, in the initial batch, in the largest batch, and in total.
///
/// Batches are large enough to fill the vector lanes, as in a map.
const FIRST_BATCH: usize = 4;
const INITIAL_BATCH: usize = 16;
const LARGEST_BATCH: usize = 128;
const TIMED_STATES: usize = 512;
/// Default time limit: afterwards no finer grid is started and no more states are timed.
pub const PATIENCE: Duration = Duration::from_millis(600);

/// Predicted cost of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forecast {
    /// Number of tiles in the map.
    pub tiles: usize,
    /// Number of states that will be computed; the others are filled in.
    pub evaluations: u64,
    /// Number of set-ups of material and method.
    pub preparations: u64,
    /// Number of states computed for the forecast.
    pub sampled: usize,
    /// Processor time per state, in batches as in the map; seconds.
    pub seconds_per_state: f64,
    /// Processor time per set-up of material and method; seconds.
    pub seconds_per_preparation: f64,
    /// Processor time for the refinement of an adaptive map; seconds.
    pub seconds_of_refinement: f64,
}

impl Forecast {
    /// Creates the forecast for a study. New grids and timings are started until `patience` has elapsed.
    ///
    /// # Errors
    /// [`ProblemError`] if the material or the discretization is not admissible.
    pub fn of(study: &Study, patience: Duration) -> Result<Self, ProblemError> {
        let tiling = tiling(study);
        let clock = Clock::start();
        let shared = match study.varies_settings() {
            true => None,
            false => Some(Evaluator::new(study.settings.clone(), &study.map, true)?),
        };
        let preparing = clock.elapsed();
        let (work, sampled) = match study.map.adaptive {
            true => {
                let sample = sampled(study, &tiling, shared.as_ref(), patience / 2)?;
                (
                    Work::rehearsed(study, &tiling, &sample),
                    sample.records.len(),
                )
            }
            false => (Work::of_all(study, &tiling), 0),
        };
        let timing = Timing::of(study, shared.as_ref(), &work, patience / 2)?;
        let states = timing.states as f64;
        Ok(Self {
            tiles: tiling.tiles(),
            evaluations: work.evaluations,
            preparations: if shared.is_some() {
                1
            } else {
                work.preparations
            },
            sampled: sampled + timing.states,
            seconds_per_state: timing.computing.as_secs_f64() / states,
            seconds_per_preparation: match shared {
                Some(_) => preparing.as_secs_f64(),
                None => timing.preparing.as_secs_f64() / states,
            },
            seconds_of_refinement: work.refining,
        })
    }

    /// Processor time of the whole map; seconds.
    pub fn seconds(&self) -> f64 {
        self.evaluations as f64 * self.seconds_per_state
            + self.preparations as f64 * self.seconds_per_preparation
            + self.seconds_of_refinement
    }
}

/// Work of a map, in states and set-ups.
struct Work {
    /// Number of states along each dimension, slowest first.
    shape: Vec<usize>,
    /// Indices of the states that will be computed, if known; empty for all states.
    states: Vec<usize>,
    /// Number of states that will be computed.
    evaluations: u64,
    /// Number of materials and methods that will be set up for them.
    preparations: u64,
    /// Processor time of the refinement; seconds.
    refining: f64,
}

impl Work {
    /// Work of a map that computes every state.
    fn of_all(study: &Study, tiling: &Tiling) -> Self {
        // The sum of `prepared_in` over all tiles is the product of the sums along the axes.
        let axes = study.axes.iter().rev();
        let along = axes.zip(tiling.shape.iter().zip(tiling.grid()));
        let preparations = along.map(|(axis, (states, tiles))| match axis.quantity {
            Quantity::Setting(_) => *states as u64,
            _ => tiles as u64,
        });
        Self {
            shape: tiling.shape.clone(),
            states: Vec::new(),
            evaluations: tiling.states() as u64,
            preparations: preparations.product(),
            refining: 0.0,
        }
    }

    /// Work of an adaptive map, predicted by a trial refinement.
    fn rehearsed(study: &Study, tiling: &Tiling, sample: &Sample<'_>) -> Self {
        let tiles = tiling.tiles();
        let some = tiles.min(MAX_REHEARSED_TILES);
        let mut states = Vec::new();
        let mut prepared = 0;
        let clock = Clock::start();
        for n in 0..some {
            let tile = tiling.at((2 * n + 1) * tiles / (2 * some));
            let varied: Vec<usize> = prepared_in(study, &tile).collect();
            let computed = std::cell::RefCell::new((&mut states, BTreeSet::new()));
            let likely = |batch: &[usize]| -> Result<Vec<Record>, Infallible> {
                let mut computed = computed.borrow_mut();
                let record = |state: &usize| {
                    let place = unravel(*state, &tile.extent);
                    let along = place.iter().zip(&varied);
                    let along = along.map(|(place, states)| place % states);
                    computed
                        .1
                        .insert(ravel(&along.collect::<Vec<_>>(), &varied));
                    let whole: Vec<usize> =
                        place.iter().zip(&tile.origin).map(|(a, b)| a + b).collect();
                    computed.0.push(ravel(&whole, &tiling.shape));
                    sample.likely(&whole)
                };
                Ok(batch.iter().map(record).collect())
            };
            let Ok(_) = refine(&tile.extent, study.map.refine_from, likely);
            prepared += computed.into_inner().1.len() as u64;
        }
        let share = tiles as f64 / some as f64;
        let scaled = |count: u64| (count as f64 * share).round() as u64;
        Self {
            shape: tiling.shape.clone(),
            evaluations: scaled(states.len() as u64),
            preparations: scaled(prepared),
            refining: clock.elapsed().as_secs_f64() * share,
            states,
        }
    }

    /// Number of the n-th state to be timed.
    fn timed(&self, n: usize) -> usize {
        match self.states.len() {
            0 => ravel(&spread(n, &self.shape), &self.shape),
            count => self.states[spread(n, &[count])[0]],
        }
    }
}

/// The n-th point of an evenly spread sequence in a box, for any number of points.
///
/// Coordinates are multiples of powers of the root of \( x^{d+1} = x + 1 \), the golden ratio in one dimension (Roberts 2018).
fn spread(n: usize, shape: &[usize]) -> Vec<usize> {
    let order = shape.len() as f64 + 1.0;
    let root = (0..64).fold(1.5_f64, |x, _| (1.0 + x).powf(order.recip()));
    let along = |(i, states): (usize, &usize)| {
        let share = (0.5 + n as f64 * root.powi(-(i as i32 + 1))).fract();
        ((share * *states as f64) as usize).min(states - 1)
    };
    shape.iter().enumerate().map(along).collect()
}

/// Processor times of states and set-ups.
#[derive(Default)]
struct Timing {
    states: usize,
    preparing: Duration,
    computing: Duration,
}

impl Timing {
    /// Times states of a map, in growing batches until `patience` has elapsed.
    fn of(
        study: &Study,
        shared: Option<&Evaluator>,
        work: &Work,
        patience: Duration,
    ) -> Result<Self, ProblemError> {
        let most = TIMED_STATES.min(work.evaluations as usize).max(1);
        let batch_at = |first: usize, count: usize| {
            let numbers = (first..first + count).map(|n| work.timed(n));
            let places: Vec<Vec<f64>> = numbers.map(|state| study.coordinates(state)).collect();
            Self::of_states(study, shared, &places)
        };
        // The first states find caches empty and vector lanes half full. They count only if no time remains for more.
        let first = batch_at(0, FIRST_BATCH.min(most))?;
        let (mut timing, mut batch) = (Self::default(), INITIAL_BATCH);
        let one = |timing: &Self| timing.spent() / timing.states.max(1) as u32;
        while timing.states < most {
            let known = if timing.states == 0 { &first } else { &timing };
            if timing.spent() + one(known) * batch as u32 > patience {
                break;
            }
            timing.add(batch_at(FIRST_BATCH + timing.states, batch)?);
            batch = (2 * batch).min(LARGEST_BATCH);
        }
        if timing.states > 0 {
            return Ok(timing);
        }
        timing = first;
        while timing.states < most && timing.spent() < patience {
            timing.add(batch_at(timing.states, 1)?);
        }
        Ok(timing)
    }

    /// Times states at the given coordinates, computed as in the map.
    fn of_states(
        study: &Study,
        shared: Option<&Evaluator>,
        places: &[Vec<f64>],
    ) -> Result<Self, ProblemError> {
        let mut timing = Self {
            states: places.len(),
            ..Self::default()
        };
        let Some(evaluator) = shared else {
            for place in places {
                let f = [study.deformation_at(place)?];
                let clock = Clock::start();
                let evaluator = Evaluator::new(study.settings_at(place)?, &study.map, false)?;
                let _ = evaluator.records(&f);
                let both = clock.elapsed();
                // The first state of a method also fills caches that later states use.
                let clock = Clock::start();
                let _ = evaluator.records(&f);
                let alone = clock.elapsed();
                timing.computing += alone;
                timing.preparing += both.saturating_sub(alone);
            }
            return Ok(timing);
        };
        let clock = Clock::start();
        let states = places.iter().map(|place| study.deformation_at(place));
        let _ = evaluator.records(&states.collect::<Result<Vec<_>, _>>()?);
        timing.computing = clock.elapsed();
        Ok(timing)
    }

    fn add(&mut self, other: Self) {
        self.states += other.states;
        self.preparing += other.preparing;
        self.computing += other.computing;
    }

    fn spent(&self) -> Duration {
        self.preparing + self.computing
    }
}

/// Number of materials and methods in a tile along each dimension: the number of states if a setting varies, one otherwise.
fn prepared_in<'a>(study: &'a Study, tile: &'a Tile) -> impl Iterator<Item = usize> + 'a {
    let axes = study.axes.iter().rev().zip(&tile.extent);
    axes.map(|(axis, states)| match axis.quantity {
        Quantity::Setting(_) => *states,
        _ => 1,
    })
}

/// Sample on the finest grid that can be computed in the given time.
fn sampled<'a>(
    study: &Study,
    tiling: &'a Tiling,
    shared: Option<&Evaluator>,
    patience: Duration,
) -> Result<Sample<'a>, ProblemError> {
    let start = Instant::now();
    let mut sample = Sample::of(study, tiling, shared, GRID_POINTS[0])?;
    for count in &GRID_POINTS[1..] {
        // Halving the grid spacing multiplies the number of states by 2^d.
        let growth = 2_u32.pow(tiling.shape.len() as u32);
        if sample.is_all() || start.elapsed() + growth * sample.time > patience {
            break;
        }
        sample = Sample::of(study, tiling, shared, *count)?;
    }
    Ok(sample)
}

/// Sample of states on a grid over the whole window.
struct Sample<'a> {
    /// Number of states of the map along each dimension, slowest first.
    shape: &'a [usize],
    grid: Vec<usize>,
    records: Vec<Record>,
    /// Processor time of the sample.
    time: Duration,
}

impl<'a> Sample<'a> {
    fn of(
        study: &Study,
        tiling: &'a Tiling,
        shared: Option<&Evaluator>,
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
            time: Duration::ZERO,
            grid,
        };
        let start = Instant::now();
        let places: Vec<Vec<f64>> = (0..sample.grid.iter().product())
            .map(|point| study.coordinates(sample.state(point)))
            .collect();
        let states: Vec<DeformationGradient> = places
            .iter()
            .map(|place| study.deformation_at(place))
            .collect::<Result<_, _>>()?;
        // Errors at states are reported by the map itself.
        let known = |record: Result<Record, ProblemError>| record.unwrap_or(Record::UNDEFINED);
        match shared {
            Some(evaluator) => {
                let records = evaluator.records(&states).into_iter();
                sample.records = records.map(known).collect();
            }
            None => {
                for (place, f) in places.iter().zip(&states) {
                    let evaluator = Evaluator::new(study.settings_at(place)?, &study.map, false)?;
                    let record = evaluator.records(std::slice::from_ref(f)).pop();
                    sample.records.push(record.map_or(Record::UNDEFINED, known));
                }
            }
        }
        sample.time = start.elapsed();
        Ok(sample)
    }

    /// Returns true if every state of the map is a grid point.
    fn is_all(&self) -> bool {
        self.grid == self.shape
    }

    /// Number of the state at a grid point.
    fn state(&self, point: usize) -> usize {
        let place = unravel(point, &self.grid);
        let along = place.iter().zip(&self.grid).zip(self.shape);
        let state = |((point, points), states): ((&usize, &usize), &usize)| {
            point * (states - 1) / (points - 1).max(1)
        };
        ravel(&along.map(state).collect::<Vec<_>>(), self.shape)
    }

    /// Interpolated record at a state.
    ///
    /// Measures are interpolated between the surrounding grid points. The finding is taken from the nearest point whose measures have the same signs.
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

#[cfg(test)]
mod tests {
    use super::*;

    fn study(map: &str) -> Study {
        let text = format!(
            "title = 'a'\n[material]\nmodel = 'blatz-ko'\n\
             [[axes]]\nquantity = 'stretch-1'\nrange = [0.3, 4.0]\nstates = 64\n\
             [[axes]]\nquantity = 'stretch-2'\nrange = [0.3, 4.0]\nstates = 48\n[map]\n{map}"
        );
        Study::parse("study.toml", &text).expect("a study")
    }

    #[test]
    fn timed_states_are_spread_evenly_over_the_map() {
        let study = study("");
        let work = Work::of_all(&study, &tiling(&study));
        let mut blocks = [[0; 4]; 4];
        for n in 0..TIMED_STATES {
            let state = work.timed(n);
            blocks[state / 64 / 12][state % 64 / 16] += 1;
        }
        let mean = TIMED_STATES / 16;
        let near = mean - mean / 4..=mean + mean / 4;
        assert!(
            blocks.iter().flatten().all(|count| near.contains(count)),
            "{blocks:?}"
        );
    }

    #[test]
    fn timed_states_of_an_adaptive_map_are_states_that_it_will_compute() {
        let study = study("adaptive = true\n");
        let tiling = tiling(&study);
        let evaluator = Evaluator::new(study.settings.clone(), &study.map, true).expect("valid");
        let patience = Duration::from_secs(3600);
        let sample = sampled(&study, &tiling, Some(&evaluator), patience).expect("computed");
        let work = Work::rehearsed(&study, &tiling, &sample);
        assert_eq!(work.states.len() as u64, work.evaluations);
        assert!(work.evaluations < study.states() as u64);
        let known: BTreeSet<usize> = work.states.iter().copied().collect();
        assert_eq!(known.len(), work.states.len(), "each state once");
        assert!((0..TIMED_STATES).all(|n| known.contains(&work.timed(n))));
        assert!(work.refining > 0.0);
    }

    #[test]
    fn the_cost_of_a_map_is_the_sum_of_its_work() {
        let forecast = Forecast::of(&study("adaptive = true\n"), PATIENCE).expect("a forecast");
        let sum = forecast.evaluations as f64 * forecast.seconds_per_state
            + forecast.preparations as f64 * forecast.seconds_per_preparation
            + forecast.seconds_of_refinement;
        assert_eq!(forecast.seconds(), sum);
        assert!(forecast.seconds_per_state > 0.0 && forecast.seconds_of_refinement > 0.0);
    }
}
