//! Runs of PySPH.

use super::lammps::{Row, check};
use super::program;

const ROWS: &[Row<'static>] = &[
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
    Row {
        title: "PySPH, deviator with Jaumann's rate, F = (1.1, 0.95), (pi/2, 0) across",
        line: "--code pysph --stretch 1.1,0.95 --wave-vector 1.5707963267948966,0 --time-step 0.02 --steps 400 --set material.model=hypoelastic-jaumann --set material.young=1 --set material.poisson=0.3 --set material.n=1 --set discretization.support=2.6",
        tolerance: 1e-5,
    },
    Row {
        title: "PySPH, the same, tensile instability, F = (1.1, 1.05), (pi, pi/2)",
        line: "--code pysph --stretch 1.1,1.05 --wave-vector 3.141592653589793,1.5707963267948966 --time-step 0.02 --steps 300 --set material.model=hypoelastic-jaumann --set material.young=1 --set material.poisson=0.3 --set material.n=1 --set discretization.support=2.6",
        tolerance: 1e-5,
    },
];

#[test]
fn predicted_waves_are_measured_in_pysph() {
    if let Some(python) = program("ONSET_PYSPH", "predictions against PySPH") {
        check(ROWS, &python, "ONSET_PYSPH_TABLE");
    }
}
