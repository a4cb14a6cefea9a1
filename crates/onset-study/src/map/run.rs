//! The computation of a map: tile by tile, on all cores, into a store.

use super::fields::{CERTAINTY, CORRECTED, REASON, VERDICT};
use super::part::Part;
use super::summary::{Summary, Tally};
use super::tile::{Plan, Work};
use crate::answers::ProblemError;
use crate::number::counted;
use crate::store::{Column, ResultStore, StoreError};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;
use thiserror::Error;

/// Why a map cannot be computed.
#[derive(Debug, Error)]
pub enum MapError {
    /// Its material or discretization.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// A state.
    #[error("at {place}: {source}")]
    State {
        /// Its coordinates.
        place: String,
        /// What is wrong.
        source: Box<ProblemError>,
    },
    /// Tiles that the map does not have.
    #[error(
        "the map has {}, numbered from 0; {asked} are none of them\n  hint: --tiles 0..{tiles} are all",
        counted(*tiles, "tile")
    )]
    Tiles {
        /// What was asked for.
        asked: Part,
        /// How many there are.
        tiles: usize,
    },
    /// The store.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// Who watches has no time left for a tile that has begun.
    #[error("interrupted")]
    Interrupted,
}

impl MapError {
    /// Whether what was asked for is wrong, and not the machine.
    pub fn is_input(&self) -> bool {
        match self {
            Self::Store(error) => error.is_input(),
            _ => true,
        }
    }
}

/// Who watches a map being computed, and may end it.
pub trait Watch: Sync {
    /// Some states are done.
    fn advance(&self, states: u64);

    /// Whether no further tile is to be begun.
    fn is_interrupted(&self) -> bool;

    /// Whether tiles that have begun are to be given up.
    fn is_out_of_time(&self) -> bool {
        false
    }
}

/// Below this many tiles for each core, states are shared out instead of tiles.
const TILES_PER_CORE: usize = 4;
/// States of the tiles that are computed at once: what is known of them is kept until their tile is done, a few hundred bytes each,
/// so that memory does not grow with the number of cores.
const STATES_AT_ONCE: usize = 1 << 20;

/// What is done with a tile, and what comes of it, if anything.
type Action<'a> = dyn Fn(usize) -> Result<Option<Tally>, MapError> + Sync + 'a;

impl Plan {
    /// The tiles of a part that the map has; all when none is given. The end of a range may lie beyond the last.
    ///
    /// # Errors
    /// [`MapError::Tiles`] when none of them exists.
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

    /// Computes those of some tiles that are not done, and checks those that are.
    ///
    /// # Errors
    /// [`MapError`] when a state cannot be computed, or the store not be read or written. Tiles that are done stay so.
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
        let at_once = (STATES_AT_ONCE / largest).max(1);
        let each = |tiles: &[usize], action: &Action<'_>| self.each(tiles, at_once, watch, action);
        let found = each(&done, &|tile| self.checked(store, tile, watch).map(Some))?;
        let are_few = |tiles: &[usize]| {
            tiles.len().min(at_once) < TILES_PER_CORE * rayon::current_num_threads()
        };
        // Of several who work on a store, each computes first what nobody else does. What others have begun and not done in the end is computed here
        // too, until it is done anywhere: nobody waits for one who is slow, stopped or gone.
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

    /// Computes a tile, until it is done anywhere; `None` where the run is interrupted.
    fn computed(
        &self,
        store: &dyn ResultStore,
        tile: usize,
        by_state: bool,
        watch: &dyn Watch,
    ) -> Result<Option<Tally>, MapError> {
        // Another process may have been faster.
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

    /// Does something with some tiles, so many at once, on all cores, and adds up what comes of it; no more once the run is interrupted.
    fn each(
        &self,
        tiles: &[usize],
        at_once: usize,
        watch: &dyn Watch,
        action: &Action<'_>,
    ) -> Result<Tally, MapError> {
        tiles
            .chunks(at_once)
            .try_fold(Tally::default(), |sum, some| {
                let tally = some
                    .par_iter()
                    .with_max_len(1)
                    .map(|tile| match watch.is_interrupted() {
                        true => Ok(Tally::default()),
                        false => Ok(action(*tile)?.unwrap_or_default()),
                    })
                    .try_reduce(Tally::default, |a, b| Ok::<_, MapError>(a + b))?;
                Ok(sum + tally)
            })
    }

    /// Reads all of a tile that is done, so that damage is found where it would be built upon.
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

/// Watches a tile that another process may compute too.
struct Race<'a> {
    store: &'a dyn ResultStore,
    tile: usize,
    watch: &'a dyn Watch,
    /// States of the tile that have not been told of as done: each is told of once, whoever computes it.
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
        // What cannot be read is told where the tile is written.
        self.watch.is_out_of_time() || self.store.is_done(self.tile).unwrap_or(false)
    }
}
