//! Damaged input files: truncated, changed, or of another format.

use super::running::{Fault, Place};
use super::{Programs, Random};
use std::fs;
use std::path::{Path, PathBuf};

const STUDY: &str = "title = \"a\"\n[material]\nmodel = \"neo-hooke\"\nmu = 1.0\nlambda = 2.0\n[discretization]\nmethod = \"total-lagrangian-sph\"\nlattice = \"square\"\n[body]\nshape = \"file\"\nfile = \"points.csv\"\n[[axes]]\nquantity = \"stretch-1\"\nrange = [0.8, 1.2]\nstates = 6\n[[axes]]\nquantity = \"stretch-2\"\nrange = [0.8, 1.2]\nstates = 6\n";
const DECK: &str = "*MATERIAL, NAME=rubber\n*HYPERELASTIC, N=1, OGDEN\n 1.2, 2.0, 0.01\n*UNIAXIAL TEST DATA\n 0.1, 0.05\n";
/// Test data of a material.
pub(super) const TESTS: &str = "# mode: uniaxial\nstretch,nominal_stress [MPa]\n1.1,0.12\n1.3,0.3\n1.6,0.48\n2.0,0.65\n2.5,0.85\n3,1.05\n";
/// Text that a stranger's file may contain; a message may quote the beginning of one word.
const PRIVATE: &str = "PRIVATEabcdefghijklmnopqrstuvwxyz0123 private-second private-third";
const LINES: &[&str] = &[
    "fit tests.csv --law yeoh",
    "fit --uniaxial tests.csv --unit MPa --law neo-hooke-isochoric",
    "screen run.csv study.toml",
    "screen run.dump study.toml --time-step 0.1",
    "screen run.xyz study.toml --check",
    "audit study.toml",
    "audit rubber.inp",
    "path study.toml --from 1,1 --to 1.2,1",
    "limit study.toml --vary material.mu --time-step 0.1 --stretch 1,1",
    "recommend study.toml --stretches 0.95,1.05",
    "zoo study.toml",
    "localize study.toml --path pure-shear",
    "check study.toml",
    "state study.toml --stretch 1.1,0.9",
    "simulate study.toml --steps 3",
    "map study.toml --out map.zarr --resume",
    "plot map.zarr --no-trace --out figure.svg",
    "compare study.toml",
    "card rubber.inp",
    "criteria rubber.inp",
    "verify read deck",
    "boundary study.toml",
];

/// Number of particles along each side of a run; in a smaller run all are too near the held boundary to be assessed.
const SIDE: usize = 12;

/// Positions of particles in the frames of a run.
fn frames() -> impl Iterator<Item = (usize, Vec<[f64; 2]>)> {
    (0..3).map(|frame| {
        let stretch = 1.0 + 0.02 * frame as f64;
        let place = |n: usize| [(n % SIDE) as f64 * stretch, (n / SIDE) as f64];
        (frame, (0..SIDE * SIDE).map(place).collect())
    })
}

/// Run as a table.
pub(super) fn run_as_table() -> String {
    let rows = frames().flat_map(|(time, all)| {
        let rows = all.into_iter().enumerate();
        rows.map(move |(n, [x, y])| format!("{time},{n},{x},{y}\n"))
    });
    format!("time,id,x,y\n{}", rows.collect::<String>())
}

/// Run as a dump of LAMMPS, and in extended XYZ.
fn run_as_blocks() -> [String; 2] {
    let mut texts = [String::new(), String::new()];
    let count = SIDE * SIDE;
    for (step, all) in frames() {
        texts[0] += &format!(
            "ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{count}\nITEM: BOX BOUNDS ff ff pp\n0 20\n0 20\n-0.5 0.5\nITEM: ATOMS id type x y z\n"
        );
        texts[1] += &format!("{count}\nProperties=id:I:1:pos:R:3 Time={step}\n");
        for (n, [x, y]) in all.into_iter().enumerate() {
            texts[0] += &format!("{n} 1 {x} {y} 0\n");
            texts[1] += &format!("{n} {x} {y} 0\n");
        }
    }
    texts
}

/// Checks that commands answer or refuse damaged files, and repeat no contents of them.
pub(super) fn damaged(
    programs: &Programs,
    place: &Place,
    random: &mut Random,
) -> Result<u64, Fault> {
    place.write("study.toml", STUDY)?;
    place.write("rubber.inp", DECK)?;
    let points: String = (0..40)
        .map(|n| format!("{},{},1.0\n", n % 8, n / 8))
        .collect();
    place.write("points.csv", format!("x,y,volume\n{points}"))?;
    let [dump, blocks] = run_as_blocks();
    let texts = [
        place.write("tests.csv", TESTS)?,
        place.write("run.csv", run_as_table())?,
        place.write("run.dump", dump)?,
        place.write("run.xyz", blocks)?,
        place.path().join("study.toml"),
        place.path().join("rubber.inp"),
        place.path().join("points.csv"),
    ];
    let mut made = programs.onset();
    made.args(["map", "study.toml", "--quiet", "--out", "map.zarr"]);
    place.run(made)?;
    let mut all = below(place.path())?;
    // The recorded output of commands is not damaged.
    all.retain(|path| !path.ends_with(".stdout") && !path.ends_with(".stderr"));
    for _ in 0..1 + random.below(3) {
        let path = &all[random.below(all.len())];
        damage(path, random)?;
    }
    let text = &texts[random.below(texts.len())];
    if random.below(2) == 0 && text.is_file() {
        hide(text, random)?;
    }
    for _ in 0..2 {
        let mut command = programs.onset();
        command.args(random.of(LINES).split(' '));
        let ended = place.run(command)?;
        let told = ended.stderr.to_lowercase();
        let is_told = |part: &str| told.contains(&part.to_lowercase());
        if PRIVATE.split(' ').any(is_told) {
            return Err(Fault::Told(format!("{}\n{}", ended.line, ended.stderr)));
        }
    }
    Ok(1)
}

/// Writes a private text into a file: as a line, or as a value.
fn hide(path: &Path, random: &mut Random) -> Result<(), Fault> {
    let mut bytes = fs::read(path)?;
    let is_mark = |byte: u8| matches!(byte, b'\n' | b',' | b'=' | b' ');
    let places: Vec<usize> = (0..bytes.len()).filter(|n| is_mark(bytes[*n])).collect();
    let place = places.get(random.below(places.len())).map_or(0, |n| n + 1);
    let end = match random.below(2) {
        0 => place,
        _ => places.iter().find(|n| **n > place).map_or(place, |n| *n),
    };
    bytes.splice(place..end, PRIVATE.bytes()).for_each(drop);
    Ok(fs::write(path, bytes)?)
}

fn below(folder: &Path) -> Result<Vec<PathBuf>, Fault> {
    let mut all = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(next) = open.pop() {
        for entry in fs::read_dir(&next)? {
            let path = entry?.path();
            match path.is_dir() {
                true => open.push(path),
                false => all.push(path),
            }
        }
    }
    all.sort();
    Ok(all)
}

fn damage(path: &Path, random: &mut Random) -> Result<(), Fault> {
    if path.is_dir() {
        return Ok(());
    }
    let mut bytes = fs::read(path)?;
    let place = random.below(bytes.len());
    match random.below(8) {
        0 => bytes.truncate(place),
        1 => bytes.clear(),
        2 => bytes
            .iter_mut()
            .skip(place)
            .take(1)
            .for_each(|byte| *byte ^= 1 << (place % 8)),
        3 => bytes
            .splice(place..place, [0, 255, 10, 34].repeat(1 + place % 9))
            .for_each(drop),
        4 => bytes = [&[0xff, 0xfe][..], &bytes].concat(),
        5 => bytes = bytes.repeat(3),
        6 => bytes = b"\x89PNG\r\n\x1a\n".repeat(100),
        _ => {
            fs::remove_file(path)?;
            return Ok(fs::create_dir(path)?);
        }
    }
    Ok(fs::write(path, bytes)?)
}
