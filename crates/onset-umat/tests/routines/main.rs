//! Routines written in Fortran, in separate processes.

mod crystal;
mod failures;
mod fortran;
mod interface;
mod interfaces;
mod laws;
mod localization;
mod mfront;
mod utilities;

use fortran::library;
use onset::kinematics::DeformationGradient;
use onset_umat::{Umat, UmatSettings};
use std::time::Duration;

fn settings(sources: &[&str], properties: &[f64]) -> UmatSettings {
    UmatSettings {
        time_limit: Duration::from_secs(60),
        host: Some(env!("CARGO_BIN_EXE_onset-umat-host").into()),
        ..UmatSettings::new(library(sources), properties)
    }
}

fn blatz_ko() -> Umat {
    Umat::new(settings(&["fortran/blatz_ko.f90"], &[32.0])).expect("a UMAT")
}

fn state(components: [[f64; 3]; 3]) -> DeformationGradient {
    DeformationGradient::new(components).expect("admissible")
}

/// State with stretch, shear and rotation in all directions.
fn general() -> DeformationGradient {
    state([[1.2, 0.3, -0.1], [-0.2, 0.9, 0.15], [0.05, -0.25, 1.1]])
}
