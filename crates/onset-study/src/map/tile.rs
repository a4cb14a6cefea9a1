//! Preparation of a study, and computation of one tile.

use super::adaptive::refine;
use super::evaluate::Evaluator;
use super::fields::Table;
use super::layout::layout;
use super::record::{Outcomes, Record};
use super::run::{MapError, Watch};
use crate::answers::ProblemError;
use crate::settings::{Quantity, Study};
use crate::store::{Column, Layout, Tile, Tiling, ravel, unravel};
use onset::cancel::Scope;
use onset::kinematics::DeformationGradient;
use onset::method::MethodError;
use rayon::prelude::*;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Largest number of states in a batch: large enough to share set-up costs, small enough to distribute batches among cores.
const BATCH_STATES: usize = 512;

/// Study prepared for computation.
pub struct Plan {
    pub(super) study: Study,
    pub(super) tiling: Tiling,
    layout: Layout,
    table: Table,
    /// Evaluator for all states, if no axis varies material or discretization.
    evaluator: Option<Evaluator>,
}

/// Options for the computation of a tile.
#[derive(Clone, Copy)]
pub(super) struct Work<'a> {
    /// Whether the states of a tile are distributed among the cores.
    pub(super) by_state: bool,
    /// Observer of the computation.
    pub(super) watch: &'a dyn Watch,
}

impl Plan {
    /// Prepares a study for the computation of its map.
    ///
    /// # Errors
    /// [`MapError`] if its material or discretization is not admissible.
    pub fn new(study: &Study) -> Result<Self, MapError> {
        // All processes of this run, and all that resume its store, must use the same library.
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

    /// Layout of the store of the map.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Division of the states into tiles.
    pub fn tiling(&self) -> &Tiling {
        &self.tiling
    }

    /// Results for all states of a tile, the last dimension varying fastest.
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
                // Small numbers of slow states are distributed too.
                let shares = 4 * rayon::current_num_threads();
                let part = batch.len().div_ceil(shares).clamp(1, BATCH_STATES);
                let scope = Scope::current();
                let some = |part| scope.run(|| some(part));
                batch.par_chunks(part).map(some).collect()
            } else {
                batch.chunks(BATCH_STATES).map(&some).collect()
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

    /// Columns of a tile, in the order of the layout.
    pub(super) fn columns(&self, outcomes: &Outcomes) -> Vec<Column> {
        self.table.columns(outcomes, self.layout.components)
    }
}

/// Number of states computed between two checks for cancellation: initially one, then adapted to the time per state.
///
/// The results do not depend on this number.
struct Pace(AtomicUsize);

impl Default for Pace {
    fn default() -> Self {
        Self(AtomicUsize::new(1))
    }
}

impl Pace {
    /// After a batch shorter than this duration a larger batch follows, and after a batch longer than `LONG_BATCH` a smaller batch.
    const SHORT_BATCH: Duration = Duration::from_millis(50);
    const LONG_BATCH: Duration = Duration::from_millis(250);

    fn states(&self) -> usize {
        self.0.load(Ordering::Relaxed)
    }

    fn took(&self, states: usize, time: Duration) {
        if time < Self::SHORT_BATCH {
            self.0
                .fetch_max((4 * states).min(BATCH_STATES), Ordering::Relaxed);
        } else if time > Self::LONG_BATCH {
            self.0.store((states / 4).max(1), Ordering::Relaxed);
        }
    }
}

/// States of a tile.
struct States<'a> {
    plan: &'a Plan,
    tile: &'a Tile,
    /// Extent of the tile along dimensions that vary material or discretization; one along the others.
    varied: Vec<usize>,
    /// Evaluators, one for each material and discretization in the tile, created on first use.
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

    /// Computes the states with the given numbers in the tile.
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

    /// Computes a state with its material and discretization.
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
