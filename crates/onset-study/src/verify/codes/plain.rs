//! Decks for any other code: input as a table of particles, output as positions in CSV or extended XYZ.
//!
//! `particles.csv` lists number, reference position, position, velocity, mass and volume of each particle. The code writes positions: either
//! `wave.csv` with the columns `time,id,x,y,z` after the line `# onset case MARK`, or `wave.xyz` in extended XYZ with `Time`, `case` and `Properties`
//! in the comment of each frame.

use super::super::{Code, Deck, Program, Projector, Record, Settled, VerifyError};
use crate::answers::Problem;
use crate::output::{Files, text};
use onset::kinematics::DeformationGradient;
use onset::time_step::Stepping;
use std::fmt::Write;
use std::path::Path;

pub(super) struct Plain;

const HINT: &str = "the page `verify` of the book describes the formats";

/// Table of the particles of a deck, one line each.
pub(super) fn particles(deck: &Deck<'_>) -> String {
    let case = deck.case;
    let volume = case.block.volume();
    let jacobian: f64 = case.stretches[..case.block.dimension()].iter().product();
    let mut table = format!(
        "# onset case {}\nid,reference_x,reference_y,reference_z,x,y,z,vx,vy,vz,mass,volume\n",
        case.id
    );
    for index in 0..case.block.particles() {
        let all = [
            case.block.reference(index),
            case.place(index),
            case.seed(index),
        ];
        let numbers = all.iter().flatten().copied();
        let numbers = numbers.chain([volume * case.density, volume * jacobian]);
        let words: Vec<String> = numbers.map(|x| format!("{x:.16e}")).collect();
        let _ = writeln!(table, "{},{}", index + 1, words.join(","));
    }
    table
}

fn protocol(deck: &Deck<'_>) -> String {
    let case = deck.case;
    let lengths: Vec<String> = case.lengths().iter().map(|x| format!("{x:.16e}")).collect();
    format!(
        "onset case {id}\n\n\
         1. Read particles.csv: positions and velocities at time 0, masses, current volumes. The box is periodic with the lengths {lengths}.\n\
         2. Run {steps} time steps of {step:.16e} ({name}).\n\
         3. Every {every} steps write the positions of all particles with 17 digits, as wave.csv:\n\n\
         # onset case {id}\n\
         time,id,x,y,z\n\
         0,1,...\n\n\
         or as wave.xyz, in extended XYZ with the comment\n\n\
         Time=0.1 case={id} Properties=id:I:1:pos:R:3\n\n\
         4. onset verify read wave.csv\n",
        id = case.id,
        lengths = lengths.join(", "),
        steps = case.steps,
        step = case.time_step,
        every = case.every,
        name = case.prediction.stepping.name(),
    )
}

/// Reads a table of positions.
pub(super) fn read_csv(text: &str, mut projector: Projector<'_>) -> Result<Record, VerifyError> {
    let mut columns: Option<[Option<usize>; 5]> = None;
    let mut mark = None;
    let mut current: Option<f64> = None;
    let mut is_cut = false;
    let last = text.lines().count();
    for (index, line) in text.lines().enumerate() {
        let (number, line) = (index + 1, line.trim());
        if let Some(comment) = line.strip_prefix('#') {
            mark = comment
                .trim()
                .strip_prefix("onset case ")
                .map(str::trim)
                .or(mark);
            continue;
        }
        if line.is_empty() {
            continue;
        }
        let words: Vec<&str> = line.split(',').map(str::trim).collect();
        let Some(columns) = &columns else {
            projector.require_mark(number, mark)?;
            columns = Some(header(number, &words, &projector)?);
            continue;
        };
        // An incomplete last line could end within a number.
        if number == last && !text.ends_with('\n') {
            is_cut = true;
            break;
        }
        let mut values = [0.0; 5];
        for (value, column) in values.iter_mut().zip(columns) {
            let Some(column) = column else { continue };
            let word = words.get(*column).copied().unwrap_or_default();
            let parsed = word.parse();
            *value = parsed.map_err(|_| projector.wrong(number, "a cell is not a number", HINT))?;
        }
        let [time, id, x, y, z] = values;
        if current.is_some_and(|current| current != time) {
            end_frame(&mut projector, number, current)?;
        }
        current = Some(time);
        projector.particle(number, id, [x, y, z])?;
    }
    if let Some(time) = current
        && projector.end_frame(time) > 0
    {
        is_cut = true;
    }
    Ok(projector.finish(is_cut))
}

/// Ends a frame that is not the last frame.
fn end_frame(
    projector: &mut Projector<'_>,
    line: usize,
    time: Option<f64>,
) -> Result<(), VerifyError> {
    let time = time.unwrap_or_default();
    match projector.end_frame(time) {
        0 => Ok(()),
        missing => Err(projector.wrong(
            line,
            format!("{missing} particles of the frame at time {time} are missing"),
            "write all particles of a frame",
        )),
    }
}

/// Columns of time, number and coordinates.
fn header(
    line: usize,
    words: &[&str],
    projector: &Projector<'_>,
) -> Result<[Option<usize>; 5], VerifyError> {
    let dimension = projector.case().block.dimension();
    let mut columns = [None; 5];
    for (n, name) in ["time", "id", "x", "y", "z"].into_iter().enumerate() {
        columns[n] = words.iter().position(|word| *word == name);
        if columns[n].is_none() && n < 2 + dimension {
            return Err(projector.wrong(line, format!("there is no column `{name}`"), HINT));
        }
    }
    Ok(columns)
}

/// Reads positions in extended XYZ.
fn read_xyz(text: &str, mut projector: Projector<'_>) -> Result<Record, VerifyError> {
    let lines: Vec<&str> = text.lines().collect();
    let whole = lines.len() - usize::from(!text.ends_with('\n') && !lines.is_empty());
    let mut at = 0;
    while at < lines.len() {
        if lines[at].trim().is_empty() {
            at += 1;
            continue;
        }
        let Ok(count) = lines[at].trim().parse::<usize>() else {
            return Err(projector.wrong(at + 1, "expected the number of particles", HINT));
        };
        if count > whole.saturating_sub(at + 2) {
            return Ok(projector.finish(true));
        }
        let (line, comment) = (at + 2, lines[at + 1]);
        let value = |name: &str| {
            let mut words = comment.split_whitespace();
            words.find_map(|word| word.strip_prefix(name)?.strip_prefix('='))
        };
        projector.require_mark(line, value("case"))?;
        let Some(time) = value("Time").and_then(|time| time.parse::<f64>().ok()) else {
            return Err(projector.wrong(line, "the comment of the frame has no Time=NUMBER", HINT));
        };
        let places = value("Properties").and_then(properties);
        let Some([id, position]) = places else {
            let what = "the comment of the frame has no Properties with id:I:1 and pos:R:3";
            return Err(projector.wrong(line, what, HINT));
        };
        for row in at + 2..at + 2 + count {
            let words: Vec<&str> = lines[row].split_whitespace().collect();
            let mut values = [0.0; 4];
            let columns = [id, position, position + 1, position + 2];
            for (value, column) in values.iter_mut().zip(columns) {
                let word = words.get(column).copied().unwrap_or_default();
                let parsed = word.parse();
                *value =
                    parsed.map_err(|_| projector.wrong(row + 1, "a cell is not a number", HINT))?;
            }
            let [number, x, y, z] = values;
            projector.particle(row + 1, number, [x, y, z])?;
        }
        end_frame(&mut projector, line, Some(time))?;
        at += 2 + count;
    }
    Ok(projector.finish(false))
}

/// Columns of number and position, from triples `name:type:count`.
fn properties(text: &str) -> Option<[usize; 2]> {
    let words: Vec<&str> = text.split(':').collect();
    let (mut id, mut position, mut column) = (None, None, 0);
    for triple in words.chunks(3) {
        let [name, _, count] = triple else {
            return None;
        };
        match *name {
            "id" => id = Some(column),
            "pos" => position = Some(column),
            _ => {}
        }
        column += count.parse::<usize>().ok()?;
    }
    Some([id?, position?])
}

impl Code for Plain {
    fn name(&self) -> &'static str {
        "plain"
    }

    fn title(&self) -> &'static str {
        "any other code: particles in CSV, positions in CSV or extended XYZ"
    }

    fn dialect(&self) -> &'static [Settled] {
        &[]
    }

    fn remarks(&self) -> &'static [&'static str] {
        &[
            "method and choices are taken from the study; --stepping gives the time integration of the code",
        ]
    }

    fn is_periodic(&self) -> bool {
        true
    }

    fn tolerance(&self) -> f64 {
        1e-4
    }

    fn stepping(&self, _: &Problem, _: &DeformationGradient) -> Result<Stepping, VerifyError> {
        Ok(Stepping::VelocityVerlet)
    }

    fn deck(&self, deck: &Deck<'_>) -> Result<Files, VerifyError> {
        Ok(vec![
            text("particles.csv", particles(deck)),
            text("PROTOCOL.txt", protocol(deck)),
        ])
    }

    fn program(&self) -> Option<Program> {
        None
    }

    fn output(&self) -> &'static str {
        "wave.csv"
    }

    fn read(
        &self,
        path: &Path,
        text: &str,
        projector: Projector<'_>,
    ) -> Result<Record, VerifyError> {
        match path.extension().is_some_and(|extension| extension == "xyz") {
            true => read_xyz(text, projector),
            false => read_csv(text, projector),
        }
    }
}
