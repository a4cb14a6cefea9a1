//! Claims of the paper compared with independent reference numbers.

mod anchors;
mod compression;
mod reference;
