//! The paper and its independent reference numbers, claim by claim.

mod anchors;
mod compression;
mod reference;
