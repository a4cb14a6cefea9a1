//! Computation of a map: tile by tile, on all cores, into a store.

use super::fields::{CERTAINTY, CORRECTED, REASON, VERDICT};
use super::part::Part;
use super::summary::{Summary, Tally};
use super::tile::{Plan, Work};
use crate::answers::ProblemError;
use crate::number::counted;
use crate::store::{Column, ResultStore, StoreError};
use onset::cancel::Scope;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;
use thiserror::Error;

/// Reason why a map cannot be computed.
#[derive(Debug, Error)]
pub enum MapError {
    /// Error in material or discretization.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// Error at a state.
    #[error("at {place}: {source}")]
    State {
        /// Coordinates of the state, as text.
        place: String,
        /// Error of the evaluation at this state.
        source: Box<ProblemError>,
    },
    /// Selection of tiles that the map does not have.
    #[error(
        "the map has {}, numbered from 0; {asked} is outside\n  hint: --tiles 0..{tiles} selects all of them",
        counted(*tiles, "tile")
    )]
    Tiles {
        /// Selection that was requested.
        asked: Part,
        /// Number of tiles in the map.
        tiles: usize,
    },
    /// Error of the store.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// Interruption before a started tile was finished.
    #[error("interrupted")]
    Interrupted,
}

impl MapError {
    /// Returns true for an error in the request, false for a failure of the machine.
    pub fn is_input(&self) -> bool {
        match self {
            Self::Store(error) => error.is_input(),
            _ => true,
        }
    }
}

/// Observer of the computation of a map, which may end it.
pub trait Watch: Sync {
    /// Reports a number of finished states.
    fn advance(&self, states: u64);

    /// Returns true if no further tile should be started.
    fn is_interrupted(&self) -> bool;

    /// Returns true if started tiles should be abandoned.
    fn is_out_of_time(&self) -> bool {
        false
    }
}

/// Observer without output; the caller cancels the run by [`onset::cancel`].
impl Watch for () {
    fn advance(&self, _: u64) {}

    fn is_interrupted(&self) -> bool {
        false
    }
}

/// Smallest number of tiles per core for distributing tiles; with fewer tiles, states are distributed.
const TILES_PER_CORE: usize = 4;
/// Largest number of states in tiles computed simultaneously.
///
/// Results of a tile are kept until it is finished, a few hundred bytes per state; the limit keeps memory independent of the number of cores.
const MAX_STATES_IN_PROGRESS: usize = 1 << 20;

/// Action on a tile, with its counts if it completes.
type Action<'a> = dyn Fn(usize) -> Result<Option<Tally>, MapError> + Sync + 'a;

impl Plan {
    /// Indices of the existing tiles in a part, or of all tiles without a part. The end of a range may exceed the last tile.
    ///
    /// # Errors
    /// [`MapError::Tiles`] if the map has no tile in the part.
    pub fn tiles(&self, asked: Option<Part>) -> Result<Vec<usize>, MapError> {
        let tiles = self.tiling.tiles();
        let Some(asked) = asked else {
            return Ok((0..tiles).collect());
        };
        let own = asked.tiles(tiles);
        match own.is_empty() {
            true => Err(MapError::Tiles { asked, tiles }),
            false => Ok(own),
        }
    }

    /// Computes unfinished tiles among those given, and checks the finished tiles.
    ///
    /// # Errors
    /// [`MapError`] if a state cannot be computed, or the store cannot be read or written. Finished tiles remain in the store.
    pub fn run(
        &self,
        store: &dyn ResultStore,
        tiles: &[usize],
        watch: &dyn Watch,
    ) -> Result<Summary, MapError> {
        let started = Instant::now();
        let mut open = Vec::new();
        let mut done = Vec::new();
        for tile in tiles.iter().copied() {
            if store.is_done(tile)? {
                done.push(tile);
            } else {
                open.push(tile);
            }
        }
        let largest = self.tiling.at(0).states().max(1);
        let at_once = (MAX_STATES_IN_PROGRESS / largest).max(1);
        let each = |tiles: &[usize], action: &Action<'_>| self.each(tiles, at_once, watch, action);
        let found = each(&done, &|tile| self.checked(store, tile, watch).map(Some))?;
        let are_few = |tiles: &[usize]| {
            tiles.len().min(at_once) < TILES_PER_CORE * rayon::current_num_threads()
        };
        // Several processes may share a store. Each first computes the tiles that no other process has started. Tiles started elsewhere but still
        // unfinished are then computed here too, until some process finishes them; no process depends on a slow or stopped one.
        let by_state = are_few(&open);
        let elsewhere = Mutex::new(Vec::new());
        let of_others = || elsewhere.lock().unwrap_or_else(PoisonError::into_inner);
        let own = each(&open, &|tile| {
            if store.is_done(tile)? {
                return self.checked(store, tile, watch).map(Some);
            }
            let taken = store.take(tile)?;
            if taken.is_none() {
                of_others().push(tile);
                return Ok(None);
            }
            self.computed(store, tile, by_state, watch)
        })?;
        let begun = std::mem::take(&mut *of_others());
        let by_state = are_few(&begun);
        let others = each(&begun, &|tile| self.computed(store, tile, by_state, watch))?;
        let mut left = 0;
        for tile in 0..self.tiling.tiles() {
            left += usize::from(!store.is_done(tile)?);
        }
        Ok(Summary::new(
            &self.study,
            found + own + others,
            self.tiling.tiles() - left,
            self.tiling.tiles(),
            started.elapsed(),
        ))
    }

    /// Computes a tile until some process has finished it; `None` if the run is interrupted.
    fn computed(
        &self,
        store: &dyn ResultStore,
        tile: usize,
        by_state: bool,
        watch: &dyn Watch,
    ) -> Result<Option<Tally>, MapError> {
        // Another process may have finished the tile in the meantime.
        if store.is_done(tile)? {
            return self.checked(store, tile, watch).map(Some);
        }
        let race = Race {
            store,
            tile,
            watch,
            left: AtomicU64::new(self.tiling.at(tile).states() as u64),
        };
        let work = Work {
            by_state,
            watch: &race,
        };
        let outcomes = match self.outcomes(&self.tiling.at(tile), work) {
            Err(MapError::Interrupted) if store.is_done(tile)? => {
                return self.checked(store, tile, &race).map(Some);
            }
            Err(MapError::Interrupted) => return Ok(None),
            outcomes => outcomes?,
        };
        store.write(tile, self.columns(&outcomes))?;
        Ok(Some(Tally::computed(&outcomes)))
    }

    /// Applies an action to tiles in groups of `at_once` on all cores, and sums the counts; stops after an interruption.
    fn each(
        &self,
        tiles: &[usize],
        at_once: usize,
        watch: &dyn Watch,
        action: &Action<'_>,
    ) -> Result<Tally, MapError> {
        let scope = Scope::current();
        tiles
            .chunks(at_once)
            .try_fold(Tally::default(), |sum, some| {
                let tally = some
                    .par_iter()
                    .with_max_len(1)
                    .map(|tile| match watch.is_interrupted() {
                        true => Ok(Tally::default()),
                        false => Ok(scope.run(|| action(*tile))?.unwrap_or_default()),
                    })
                    .try_reduce(Tally::default, |a, b| Ok::<_, MapError>(a + b))?;
                Ok(sum + tally)
            })
    }

    /// Reads a finished tile completely, to detect damage before results depend on it.
    fn checked(
        &self,
        store: &dyn ResultStore,
        tile: usize,
        watch: &dyn Watch,
    ) -> Result<Tally, MapError> {
        let mut tally = Tally::default();
        for field in &self.layout().fields {
            let column = store.read(field.name, tile)?;
            match (field.name, column) {
                (VERDICT, Some(Column::Flags(flags))) => tally.count_verdicts(&flags),
                ("evaluated", Some(Column::Flags(flags))) => tally.count_evaluated(&flags),
                (CERTAINTY, Some(Column::Flags(flags))) => tally.proofs.count_certainties(&flags),
                (REASON, Some(Column::Flags(flags))) => tally.proofs.count_reasons(&flags),
                (CORRECTED, Some(Column::Flags(flags))) => tally.proofs.count_corrected(&flags),
                _ => {}
            }
        }
        tally.found = 1;
        watch.advance(self.tiling.at(tile).states() as u64);
        Ok(tally)
    }
}

/// Observer of a tile that another process may also be computing.
struct Race<'a> {
    store: &'a dyn ResultStore,
    tile: usize,
    watch: &'a dyn Watch,
    /// Number of states of the tile not yet reported as finished. Each state is reported once, by any process.
    left: AtomicU64,
}

impl Watch for Race<'_> {
    fn advance(&self, states: u64) {
        let less = |left: u64| Some(left.saturating_sub(states));
        let left = self.left.fetch_update(Relaxed, Relaxed, less);
        self.watch.advance(states.min(left.unwrap_or(0)));
    }

    fn is_interrupted(&self) -> bool {
        self.watch.is_interrupted()
    }

    fn is_out_of_time(&self) -> bool {
        // A read error is reported when the tile is written.
        self.watch.is_out_of_time() || self.store.is_done(self.tile).unwrap_or(false)
    }
}
