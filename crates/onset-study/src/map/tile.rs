//! A study made ready to be computed, and the computation of one tile.

use super::adaptive::refine;
use super::evaluate::Evaluator;
use super::fields::Table;
use super::layout::layout;
use super::record::{Outcomes, Record};
use super::run::{MapError, Watch};
use crate::answers::ProblemError;
use crate::settings::{Quantity, Study};
use crate::store::{Column, Layout, Tile, Tiling, ravel, unravel};
use onset::kinematics::DeformationGradient;
use onset::method::MethodError;
use rayon::prelude::*;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// States that are computed together: enough that what is shared among them costs little, and few enough to be shared out
/// among cores.
const PART: usize = 512;

/// A study made ready.
pub struct Plan {
    pub(super) study: Study,
    pub(super) tiling: Tiling,
    layout: Layout,
    table: Table,
    /// For all states, where no axis varies material or discretization.
    evaluator: Option<Evaluator>,
}

/// How the work on a tile is done.
#[derive(Clone, Copy)]
pub(super) struct Work<'a> {
    /// Whether the states of a tile are shared out among the cores.
    pub(super) by_state: bool,
    /// Who watches.
    pub(super) watch: &'a dyn Watch,
}

impl Plan {
    /// Makes a study ready.
    ///
    /// # Errors
    /// [`MapError`] when its material or discretization is not admissible.
    pub fn new(study: &Study) -> Result<Self, MapError> {
        // All processes of this run, and all that go on with its store, compute with the same library.
        let mut study = study.clone();
        study
            .settings
            .material
            .pin()
            .map_err(|error| ProblemError::from(MethodError::from(error)))?;
        let study = &study;
        let evaluator = if study.varies_settings() {
            None
        } else {
            Some(Evaluator::new(study.settings.clone(), &study.map, true)?)
        };
        let layout = layout(study);
        Ok(Self {
            study: study.clone(),
            tiling: layout.tiling(),
            table: Table::of(&study.map),
            layout,
            evaluator,
        })
    }

    /// What a store of the map holds.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// How the states are cut into tiles.
    pub fn tiling(&self) -> &Tiling {
        &self.tiling
    }

    /// What is known about every state of a tile, last dimension running fastest.
    pub(super) fn outcomes(&self, tile: &Tile, work: Work<'_>) -> Result<Outcomes, MapError> {
        let states = States::new(self, tile);
        let pace = Pace::default();
        let some = |part: &[usize]| {
            let mut records = Vec::with_capacity(part.len());
            while let Some(rest) = part.get(records.len()..).filter(|rest| !rest.is_empty()) {
                if work.watch.is_out_of_time() {
                    return Err(MapError::Interrupted);
                }
                let begun = Instant::now();
                let now = &rest[..pace.states().min(rest.len())];
                records.extend(states.records(now)?);
                pace.took(now.len(), begun.elapsed());
                if !self.study.map.adaptive {
                    work.watch.advance(now.len() as u64);
                }
            }
            Ok(records)
        };
        let evaluate = |batch: &[usize]| -> Result<Vec<Record>, MapError> {
            let parts: Result<Vec<Vec<Record>>, MapError> = if work.by_state {
                // Few states that take long each are shared out too.
                let shares = 4 * rayon::current_num_threads();
                let part = batch.len().div_ceil(shares).clamp(1, PART);
                batch.par_chunks(part).map(&some).collect()
            } else {
                batch.chunks(PART).map(&some).collect()
            };
            Ok(parts?.concat())
        };
        if self.study.map.adaptive {
            let outcomes = refine(&tile.extent, self.study.map.refine_from, evaluate)?;
            work.watch.advance(tile.states() as u64);
            return Ok(outcomes);
        }
        let all: Vec<usize> = (0..tile.states()).collect();
        Ok(evaluate(&all)?.into())
    }

    /// The columns of a tile in the order of the layout.
    pub(super) fn columns(&self, outcomes: &Outcomes) -> Vec<Column> {
        self.table.columns(outcomes, self.layout.components)
    }
}

/// How many states are computed between two looks at whether the tile is given up: one at first, then as many as are soon done. What is found does
/// not depend on it.
struct Pace(AtomicUsize);

impl Default for Pace {
    fn default() -> Self {
        Self(AtomicUsize::new(1))
    }
}

impl Pace {
    /// States that take less are followed by more at once, states that take longer by fewer.
    const SOON: Duration = Duration::from_millis(50);
    const LONG: Duration = Duration::from_millis(250);

    fn states(&self) -> usize {
        self.0.load(Ordering::Relaxed)
    }

    fn took(&self, states: usize, time: Duration) {
        if time < Self::SOON {
            self.0.fetch_max((4 * states).min(PART), Ordering::Relaxed);
        } else if time > Self::LONG {
            self.0.store((states / 4).max(1), Ordering::Relaxed);
        }
    }
}

/// The states of a tile.
struct States<'a> {
    plan: &'a Plan,
    tile: &'a Tile,
    /// The extent of the tile along dimensions that vary material or discretization, one along the others.
    varied: Vec<usize>,
    /// Evaluators, one for each material and discretization in the tile, made when first needed.
    evaluators: Vec<OnceLock<Evaluator>>,
}

impl<'a> States<'a> {
    fn new(plan: &'a Plan, tile: &'a Tile) -> Self {
        let axes = plan.study.axes.iter().rev();
        let varied: Vec<usize> = axes
            .zip(&tile.extent)
            .map(|(axis, states)| match axis.quantity {
                Quantity::Setting(_) => *states,
                _ => 1,
            })
            .collect();
        let count = if plan.evaluator.is_some() {
            0
        } else {
            varied.iter().product()
        };
        Self {
            plan,
            tile,
            varied,
            evaluators: (0..count).map(|_| OnceLock::new()).collect(),
        }
    }

    /// Computes the states with some numbers in the tile.
    fn records(&self, states: &[usize]) -> Result<Vec<Record>, MapError> {
        let deformations = states
            .iter()
            .map(|state| {
                let coordinates = self.coordinates(*state);
                let f = self.plan.study.deformation_at(&coordinates);
                f.map_err(|error| self.at(&coordinates, error.into()))
            })
            .collect::<Result<Vec<_>, _>>()?;
        let Some(evaluator) = &self.plan.evaluator else {
            return states
                .iter()
                .zip(&deformations)
                .map(|(state, f)| self.varied_record(*state, f))
                .collect();
        };
        let records = evaluator.records(&deformations);
        states
            .iter()
            .zip(records)
            .map(|(state, record)| {
                record.map_err(|error| self.at(&self.coordinates(*state), error))
            })
            .collect()
    }

    /// Computes a state with the material and the discretization that it has.
    fn varied_record(&self, state: usize, f: &DeformationGradient) -> Result<Record, MapError> {
        let place = unravel(state, &self.tile.extent);
        let coordinates = self.coordinates(state);
        let evaluator = self
            .evaluator(&place, &coordinates)
            .map_err(|error| self.at(&coordinates, error))?;
        let mut records = evaluator.records(std::slice::from_ref(f));
        let record = records.pop().unwrap_or(Ok(Record::UNDEFINED));
        record.map_err(|error| self.at(&coordinates, error))
    }

    fn coordinates(&self, state: usize) -> Vec<f64> {
        let place = unravel(state, &self.tile.extent);
        let number = self.tile.state(&place, &self.plan.tiling.shape);
        self.plan.study.coordinates(number)
    }

    fn at(&self, coordinates: &[f64], source: ProblemError) -> MapError {
        let axes = self.plan.study.axes.iter().zip(coordinates);
        MapError::State {
            place: axes
                .map(|(axis, value)| format!("{} = {value}", axis.name()))
                .collect::<Vec<_>>()
                .join(", "),
            source: Box::new(source),
        }
    }

    fn evaluator(&self, place: &[usize], coordinates: &[f64]) -> Result<&Evaluator, ProblemError> {
        let along = |(place, states): (&usize, &usize)| place % states;
        let varied: Vec<usize> = place.iter().zip(&self.varied).map(along).collect();
        let slot = &self.evaluators[ravel(&varied, &self.varied)];
        if let Some(evaluator) = slot.get() {
            return Ok(evaluator);
        }
        let study = &self.plan.study;
        let made = Evaluator::new(study.settings_at(coordinates)?, &study.map, false)?;
        Ok(slot.get_or_init(|| made))
    }
}
