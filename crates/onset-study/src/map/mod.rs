//! Maps: the states of a study, computed tile by tile into a store.
//!
//! A [`Plan`] is a prepared study. Its [layout](Plan::layout) is the layout of the store; [`Plan::run`] computes its tiles on all cores. The result
//! does not depend on the order of the tiles. A [`Record`] holds the results at a state, and [`fields`] lists the part that is stored.

mod adaptive;
mod clock;
mod evaluate;
mod fields;
mod forecast;
mod layout;
mod part;
mod proved;
mod record;
mod run;
mod summary;
mod tile;

pub use evaluate::Evaluator;
pub use fields::{CERTAINTY, CERTAINTY_MATERIAL, VERDICT, fields};
pub use forecast::{Forecast, PATIENCE};
pub(crate) use layout::{edge, stored_layout, tiling};
pub use part::Part;
pub use record::{Certainty, Finding, Outcomes, Proof, Record};
pub use run::{MapError, Watch};
pub use summary::{Proved, Share, Summary};
pub use tile::Plan;
