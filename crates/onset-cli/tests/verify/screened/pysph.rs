//! Runs of PySPH: squares of updated SPH with a prescribed rim.
//!
//! With half the step the waves appear at the same time, and artificial stress of 0.3 delays them to t = 44.9.

use super::{Found, check, in_pairs, screened, sets};
use crate::{Place, program};
use serde_json::Value;
use std::path::Path;
use std::process::Command;

const SCRIPT: &str = include_str!("tension.py");

/// Run of the script.
#[derive(Clone, Copy)]
struct Square {
    rate: f64,
    step: f64,
    time: f64,
    artificial_stress: f64,
    viscosity: f64,
}

const PULLED: Square = Square {
    rate: 0.003,
    step: 0.02,
    time: 30.0,
    artificial_stress: 0.0,
    viscosity: 0.06,
};

impl Square {
    fn screened(&self, python: &Path) -> Value {
        let place = Place::new();
        place.write("tension.py", SCRIPT);
        let numbers = [
            self.rate,
            self.step,
            self.time,
            self.artificial_stress,
            self.viscosity,
        ];
        let run = Command::new(python)
            .args(["tension.py", "run.npz"])
            .args(numbers.map(|number| number.to_string()))
            .current_dir(place.path())
            .output()
            .expect("Python starts");
        let told = String::from_utf8_lossy(&run.stderr);
        assert!(run.status.success(), "{told}");
        let method = format!(
            "method=updated-sph lattice=square kernel=cubic-spline support=2.6 corrected=false viscosity={} artificial-stress={}",
            self.viscosity, self.artificial_stress
        );
        let sets = sets("model=hypoelastic-jaumann young=1 poisson=0.3 n=1", &method);
        let line = format!("--time-step {} --stepping late-acceleration", self.step);
        screened(&place, "run.npz", &sets, &line)
    }
}

fn pysph() -> Option<std::path::PathBuf> {
    program("ONSET_PYSPH", "causes of runs of PySPH")
}

#[test]
fn the_cause_of_pysph_runs_is_identified() {
    let Some(python) = pysph() else { return };
    let variants = [
        (
            "none",
            "square, slowly",
            Square {
                rate: 0.001,
                ..PULLED
            },
        ),
        (
            "none",
            "square, for a short time",
            Square {
                time: 10.0,
                ..PULLED
            },
        ),
        ("numerical", "square", PULLED),
        (
            "numerical",
            "square in half the step",
            Square {
                step: 0.01,
                ..PULLED
            },
        ),
        (
            "numerical",
            "square with viscosity",
            Square {
                viscosity: 0.5,
                ..PULLED
            },
        ),
        (
            "numerical",
            "square, faster",
            Square {
                rate: 0.005,
                time: 24.0,
                ..PULLED
            },
        ),
    ];
    let found = in_pairs(&variants, |(cause, name, square)| Found {
        name: (*name).to_owned(),
        cause,
        answer: square.screened(&python),
    });
    check("PySPH", &found);
}

#[test]
fn a_pysph_run_with_artificial_stress_is_healthy() {
    let Some(python) = pysph() else { return };
    let answer = PULLED.screened(&python);
    let setting = answer["changes"][0]["settings"][0].as_str();
    let stress = setting.and_then(|set| set.strip_prefix("discretization.artificial-stress="));
    let cured = Square {
        artificial_stress: stress.expect("a coefficient").parse().expect("a number"),
        ..PULLED
    };
    let answer = cured.screened(&python);
    assert_eq!(answer["cause"], "none", "{}", answer["sentence"]);
}
