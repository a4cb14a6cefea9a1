//! Studies on top of the `onset` core.

pub mod figure;
