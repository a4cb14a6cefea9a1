//! Maps: what every state of a study is, computed tile by tile into a store.
//!
//! A [`Plan`] is a study made ready: its [layout](Plan::layout) is that of the store, its tiles are computed by
//! [`Plan::run`], on all cores and in any order, always with the same result. What is computed at a state is a [`Record`]; what
//! of it is stored, the table [`fields`].

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
