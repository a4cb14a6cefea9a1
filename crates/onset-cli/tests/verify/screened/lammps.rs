//! Runs of LAMMPS: plates of `smd/tlsph` between grips, and squares of `smd/ulsph` with a prescribed rim.
//!
//! The causes are known from variants in the code itself: a plate of 28 x 14 particles stays quiet with steps up to 0.76 but not with 0.79, a notched
//! plate with 0.70 but not with 0.71. The other runs stay healthy with hourglass control and half the step.

use super::{Found, check, in_pairs, onset, screened, sets};
use crate::{Place, program};
use serde_json::Value;
use std::fmt::Write;
use std::path::Path;
use std::process::Command;

/// Deck of a run.
#[derive(Clone, Copy)]
struct Deck {
    /// Number of particles along each side.
    size: [usize; 2],
    spacing: f64,
    /// Returns true for reference positions, in spacings, without a particle.
    is_cut: fn(f64, f64) -> bool,
    /// Root mean square of the components of the initial velocities of free particles.
    noise: f64,
    viscosity: f64,
    step: f64,
    time: f64,
    held: Held,
    style: Style,
}

/// Particles with prescribed velocities.
#[derive(Clone, Copy)]
enum Held {
    /// Two columns at each side, and the velocity of the right columns.
    Grips([f64; 2]),
    /// Three rows around a square, with these rates of stretching.
    Rim([f64; 2]),
}

#[derive(Clone, Copy)]
enum Style {
    /// `smd/tlsph` with an hourglass amplitude.
    Total(f64),
    /// `smd/ulsph`.
    Updated,
}

/// Support radius in spacings.
const SUPPORT: f64 = 2.01;

const PLATE: Deck = Deck {
    size: [28, 14],
    spacing: 1.0,
    is_cut: |_, _| false,
    noise: 1e-6,
    viscosity: 0.06,
    step: 0.3,
    time: 250.0,
    held: Held::Grips([0.02, 0.0]),
    style: Style::Total(10.0),
};
const NOTCHED: Deck = Deck {
    size: [36, 18],
    is_cut: |x, y| x > 15.5 && x < 19.5 && y < 5.0,
    viscosity: 0.0,
    step: 0.72,
    time: 100.0,
    held: Held::Grips([-0.002, 0.0]),
    ..PLATE
};
const SQUARE: Deck = Deck {
    size: [20, 20],
    noise: 1e-5,
    step: 0.05,
    time: 40.0,
    held: Held::Rim([0.003, 0.003]),
    style: Style::Updated,
    ..PLATE
};

impl Deck {
    fn positions(&self) -> Vec<[f64; 2]> {
        let [columns, rows] = self.size;
        let all = (0..columns).flat_map(|i| (0..rows).map(move |j| [i as f64, j as f64]));
        all.filter(|[x, y]| !(self.is_cut)(*x, *y)).collect()
    }

    /// Box of the free particles, in spacings.
    fn inside(&self) -> [[f64; 2]; 2] {
        let [columns, rows] = self.size.map(|count| count as f64);
        match self.held {
            Held::Grips(_) => [[1.5, columns - 2.5], [-1.0, rows]],
            Held::Rim(_) => [[2.5, columns - 3.5], [2.5, rows - 3.5]],
        }
    }

    /// Particles with their initial velocities.
    fn data(&self) -> String {
        let [columns, rows] = self.size.map(|count| count as f64);
        let h = self.spacing;
        let positions = self.positions();
        let mut state = 1_u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 53) as f64 * 2.0 - 1.0
        };
        let mut text = format!(
            "particles\n\n{} atoms\n1 atom types\n\n{} {} xlo xhi\n{} {} ylo yhi\n-0.5 0.5 zlo zhi\n\nAtoms # smd\n\n",
            positions.len(),
            -9.0 * h,
            (columns + 9.0) * h,
            -9.0 * h,
            (rows + 9.0) * h
        );
        let mut velocities = "\nVelocities\n\n".to_owned();
        for (n, [x, y]) in positions.iter().enumerate() {
            let (id, area, radius) = (n + 1, h * h, 0.5 * SUPPORT * h);
            let (u, v) = (x * h, y * h);
            let _ = writeln!(
                text,
                "{id} 1 1 {area} {area} {radius} {radius} {u} {v} 0 {u} {v} 0"
            );
            let mut velocity = match self.held {
                Held::Grips(_) => [0.0, 0.0],
                Held::Rim([a, b]) => [
                    a * (x - 0.5 * (columns - 1.0)),
                    b * (y - 0.5 * (rows - 1.0)),
                ],
            };
            let [[left, right], [lower, upper]] = self.inside();
            if *x > left && *x < right && *y > lower && *y < upper {
                velocity = velocity.map(|own| own + 3.0_f64.sqrt() * self.noise * random());
            }
            let _ = writeln!(velocities, "{id} {} {} 0", velocity[0], velocity[1]);
        }
        text + &velocities
    }

    fn input(&self) -> String {
        let (h, viscosity) = (self.spacing, self.viscosity);
        let steps = (self.time * h / self.step).round();
        let [[left, right], [lower, upper]] = self.inside().map(|bounds| bounds.map(|x| x * h));
        let hold = match self.held {
            Held::Grips([x, y]) => format!(
                "region left block INF {left} INF INF INF INF\ngroup left region left\ngroup right subtract held left\n\
                 fix left left smd/setvel 0 0 0\nfix right right smd/setvel {x} {y} 0\n"
            ),
            Held::Rim(_) => "fix held held setforce 0 0 0\n".to_owned(),
        };
        let (name, pair) = match self.style {
            Style::Total(hourglass) => (
                "tlsph",
                format!(
                    "neighbor {} bin\npair_style smd/tlsph\n\
                     pair_coeff 1 1 *COMMON 1.0 1.0 0.3 {viscosity} 0.0 {hourglass} 1.0 *STRENGTH_LINEAR *EOS_LINEAR *END\n",
                    SUPPORT * h
                ),
            ),
            Style::Updated => {
                // Young's modulus 1 and Poisson's ratio 0.3.
                let (bulk, shear): (f64, f64) = (1.0 / 1.2, 1.0 / 2.6);
                let sound = bulk.sqrt();
                (
                    "ulsph",
                    format!(
                        "neighbor {} bin\npair_style smd/ulsph *DENSITY_CONTINUITY *VELOCITY_GRADIENT *NO_GRADIENT_CORRECTION\n\
                         pair_coeff 1 1 *COMMON 1.0 {sound} {viscosity} 1.0 0.0 *EOS_TAIT 1.0 *STRENGTH_LINEAR {shear} *END\n",
                        0.5 * h
                    ),
                )
            }
        };
        format!(
            "dimension 2\nunits si\nboundary sm sm p\natom_style smd\natom_modify map array sort 0 0\ncomm_modify vel yes\n\
             neigh_modify every 10 delay 0 check yes\nnewton off\nread_data particles.data\ngroup {name} type 1\n\
             region inside block {left} {right} {lower} {upper} INF INF\ngroup inside region inside\ngroup held subtract all inside\n\
             {pair}fix integration all smd/integrate_{name}\n{hold}\
             timestep {}\nvariable held atom gmask(held)\ncompute S all smd/{name}/stress\n\
             dump 1 all custom {} run.dump id x y z vx vy vz v_held c_S[1] c_S[2] c_S[3] c_S[4]\n\
             dump_modify 1 sort id format float %.10g\nthermo 100000\nrun {steps}\n",
            self.step,
            (steps / 40.0).floor().max(1.0)
        )
    }

    fn sets(&self) -> Vec<String> {
        let mut method = format!(
            "lattice=square kernel=(1-q)^3 support={SUPPORT} spacing={}",
            self.spacing
        );
        if self.viscosity > 0.0 {
            let _ = write!(method, " viscosity={} viscosity-switch=smd", self.viscosity);
        }
        let law = match self.style {
            Style::Total(hourglass) => {
                method += " method=total-lagrangian-sph";
                if hourglass > 0.0 {
                    let _ = write!(method, " penalty={hourglass} penalty-form=smd");
                }
                "model=hypoelastic-green-naghdi young=1 poisson=0.3"
            }
            Style::Updated => {
                method += " method=updated-sph momentum=mean density-evolution=continuity corrected=false";
                // The code rotates the deviator against the spin.
                "model=hypoelastic-jaumann young=1 poisson=0.3 n=1 spin=-1"
            }
        };
        sets(law, &method)
    }

    /// Runs the deck and screens its dump.
    fn screened(&self, program: &Path) -> Value {
        let place = Place::new();
        place.write("particles.data", &self.data());
        place.write("in.lammps", &self.input());
        let run = Command::new(program)
            .args(["-in", "in.lammps", "-log", "log.lammps"])
            .args(["-screen", "none", "-nocite"])
            .current_dir(place.path())
            .output()
            .expect("LAMMPS starts");
        assert!(run.status.success(), "{}", place.read("log.lammps"));
        let stepping = match self.style {
            Style::Total(_) => "extrapolated-stress",
            Style::Updated => "late-density",
        };
        let line = format!(
            "--time-step {} --stepping {stepping} --columns held=v_held",
            self.step
        );
        screened(&place, "run.dump", &self.sets(), &line)
    }
}

fn lammps() -> Option<std::path::PathBuf> {
    program("ONSET_LAMMPS", "causes of runs of LAMMPS")
}

const LOOSE: Deck = Deck {
    noise: 1e-3,
    style: Style::Total(0.0),
    ..PLATE
};

#[test]
fn the_cause_of_lammps_runs_is_identified() {
    let Some(program) = lammps() else { return };
    let plate = |x, y| Deck {
        held: Held::Grips([x, y]),
        ..PLATE
    };
    let square = |a, b, time| Deck {
        held: Held::Rim([a, b]),
        time,
        ..SQUARE
    };
    let stepped = |step| Deck {
        viscosity: 0.0,
        time: 300.0,
        step,
        ..plate(-0.002, 0.0)
    };
    let variants = [
        ("none", "plate, pulled", PLATE),
        (
            "none",
            "plate, pressed",
            Deck {
                time: 200.0,
                ..plate(-0.01, 0.0)
            },
        ),
        ("none", "plate, sheared", plate(0.0, 0.02)),
        (
            "none",
            "plate of small spacing",
            Deck {
                spacing: 0.5,
                step: 0.15,
                ..PLATE
            },
        ),
        ("none", "plate, step 0.7", stepped(0.7)),
        (
            "none",
            "square, for a short time",
            square(0.003, 0.003, 8.0),
        ),
        ("time-step", "plate, step 0.815", stepped(0.815)),
        ("time-step", "plate, step 0.93", stepped(0.93)),
        ("time-step", "notched plate, step 0.72", NOTCHED),
        ("zero-energy", "plate without hourglass control", LOOSE),
        (
            "zero-energy",
            "the same with less noise",
            Deck {
                noise: 1e-5,
                ..LOOSE
            },
        ),
        ("numerical", "square", SQUARE),
        (
            "numerical",
            "square in half the step",
            Deck {
                step: 0.025,
                ..SQUARE
            },
        ),
        (
            "numerical",
            "square along one side",
            square(0.005, 0.0, 50.0),
        ),
        (
            "numerical",
            "square with viscosity",
            Deck {
                viscosity: 0.5,
                ..SQUARE
            },
        ),
        ("numerical", "square, pressed", square(-0.003, -0.003, 60.0)),
    ];
    let found = in_pairs(&variants, |(cause, name, deck)| Found {
        name: (*name).to_owned(),
        cause,
        answer: deck.screened(&program),
    });
    check("LAMMPS", &found);
}

#[test]
fn lammps_runs_with_the_remedies_are_healthy() {
    let Some(program) = lammps() else { return };
    let remedy = |answer: &Value, beginning: &str| -> String {
        let all = answer["remedy"].as_array().expect("remedies");
        let mut all = all.iter().filter_map(Value::as_str);
        let found = all.find_map(|text| text.strip_prefix(beginning));
        found.unwrap_or_else(|| panic!("{answer}")).to_owned()
    };
    let is_healthy = |deck: Deck| {
        let answer = deck.screened(&program);
        assert_eq!(answer["cause"], "none", "{}", answer["sentence"]);
    };
    let step = remedy(&NOTCHED.screened(&program), "a time step of ");
    is_healthy(Deck {
        step: step.parse().expect("a step"),
        ..NOTCHED
    });
    // The penalty that `onset tune` finds, as hourglass amplitude.
    let command = remedy(&LOOSE.screened(&program), "onset tune ").replace('\'', "");
    let mut words: Vec<String> = command.split(' ').map(str::to_owned).collect();
    words.push("--json".to_owned());
    let tuned = onset("tune", &words);
    assert_eq!(tuned.code, Some(0), "{}", tuned.stderr);
    is_healthy(Deck {
        style: Style::Total(tuned.number("recommended")),
        ..LOOSE
    });
    // Tensile instability of updated SPH: the total-Lagrangian method instead.
    let answer = SQUARE.screened(&program);
    let changes = answer["changes"].as_array().expect("changes");
    let lasting = changes.iter().find(|change| change["expected"].is_null());
    let settings = &lasting.expect("a change")["settings"];
    assert_eq!(settings[0], "discretization.method=total-lagrangian-sph");
    let penalty = settings[1].as_str().expect("a setting");
    let penalty = penalty.strip_prefix("discretization.penalty=");
    is_healthy(Deck {
        style: Style::Total(penalty.expect("a penalty").parse().expect("a number")),
        ..SQUARE
    });
}
