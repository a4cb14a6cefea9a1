//! Runs of PySPH.

use super::lammps::{Row, check};
use super::program;

const ROWS: &[Row] = &[
    Row {
        title: "PySPH, F = 1.05, (pi, 0)",
        line: "--code pysph --stretch 1.05,1.05 --wave-vector 3.141592653589793,0 --time-step 0.02 --steps 200 --energy K*(J-ln(J)) --set material.K=1 --set discretization.support=2.6",
        tolerance: 1e-5,
    },
    Row {
        title: "PySPH, F = 1.05, (pi, 0), artificial stress 0.3",
        line: "--code pysph --stretch 1.05,1.05 --wave-vector 3.141592653589793,0 --time-step 0.02 --steps 400 --branch 2 --energy K*(J-ln(J)) --set material.K=1 --set discretization.support=2.6 --set discretization.artificial-stress=0.3",
        tolerance: 1e-5,
    },
];

#[test]
fn predicted_waves_are_seen_in_pysph() {
    if let Some(python) = program("ONSET_PYSPH", "predictions against PySPH") {
        check(ROWS, &python, "ONSET_PYSPH_TABLE");
    }
}
