//! Studies, answers, figures and reports on top of the `onset` core.
//!
//! [`settings`] are what a user sets; an [`answers::Problem`] is made of them; [`answers`] to single questions are
//! serializable structures; [`reproduce`] runs the paper from end to end; [`figure`] draws.

pub mod answers;
pub mod audit;
pub mod boundary;
pub mod catalog;
pub mod domain;
pub mod figure;
pub mod json;
pub mod localization;
pub mod map;
pub mod notions;
pub mod plot;
pub mod reproduce;
pub mod settings;
pub mod store;
