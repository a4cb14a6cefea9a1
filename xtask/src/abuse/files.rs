//! Damaged input files: truncated, changed, or of another format.

use super::running::{Fault, Place};
use super::{Programs, Random};
use std::fs;
use std::path::{Path, PathBuf};

const STUDY: &str = "title = \"a\"\n[material]\nmodel = \"neo-hooke\"\nmu = 1.0\nlambda = 2.0\n[discretization]\nmethod = \"total-lagrangian-sph\"\nlattice = \"square\"\n[body]\nshape = \"file\"\nfile = \"points.csv\"\n[[axes]]\nquantity = \"stretch-1\"\nrange = [0.8, 1.2]\nstates = 6\n[[axes]]\nquantity = \"stretch-2\"\nrange = [0.8, 1.2]\nstates = 6\n";
const DECK: &str = "*MATERIAL, NAME=rubber\n*HYPERELASTIC, N=1, OGDEN\n 1.2, 2.0, 0.01\n*UNIAXIAL TEST DATA\n 0.1, 0.05\n";
const LINES: &[&str] = &[
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

/// Checks that commands answer or refuse damaged files.
pub(super) fn damaged(
    programs: &Programs,
    place: &Place,
    random: &mut Random,
) -> Result<(), Fault> {
    place.write("study.toml", STUDY)?;
    place.write("rubber.inp", DECK)?;
    let points: String = (0..40)
        .map(|n| format!("{},{},1.0\n", n % 8, n / 8))
        .collect();
    place.write("points.csv", format!("x,y,volume\n{points}"))?;
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
    for _ in 0..2 {
        let mut command = programs.onset();
        command.args(random.of(LINES).split(' '));
        place.run(command)?;
    }
    Ok(())
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
