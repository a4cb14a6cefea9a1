//! Boundaries as curves, against sets whose boundary is known.

mod analytic;
mod physical;
