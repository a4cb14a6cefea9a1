//! Boundaries as curves, compared with sets whose boundary is known.

mod analytic;
mod physical;
