//! Studies, answers, figures and reports on top of the `onset` core.
//!
//! [`settings`] are the input of the user, and an [`answers::Problem`] is built from them. [`answers`] of single commands are serializable structures.
//! [`compare`] compares methods, [`reproduce`] reproduces the paper from end to end, and [`figure`] draws.

pub mod answers;
pub mod audit;
pub mod boundary;
pub mod brief;
mod caption;
pub mod catalog;
pub mod compare;
pub mod criteria;
pub mod csv;
pub mod domain;
pub mod explore;
pub mod figure;
pub mod fit;
mod html;
pub mod input;
pub mod json;
pub mod kernels;
pub mod limit;
pub mod localization;
pub mod map;
pub mod methods;
pub mod modes;
pub mod number;
pub mod output;
pub mod plot;
pub mod range;
pub mod reproduce;
pub mod screen;
pub mod settings;
pub mod shell;
pub mod simulate;
pub mod store;
pub mod tune;
pub mod verify;
mod vtk;
pub mod zoo;

pub use onset::cancel::unless;
pub use onset::verdict::Verdict;
