//! Calls of a UMAT per second, one by one and in batches: `cargo run --release -p onset-umat --example calls -- LIBRARY [PROPS]`.

use onset::kinematics::DeformationGradient;
use onset::material::Hyperelastic;
use onset_umat::{Umat, UmatSettings, serve_if_asked};
use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    if let Some(code) = serve_if_asked() {
        return Ok(code);
    }
    let mut arguments = std::env::args().skip(1);
    let library = arguments.next().ok_or("name a library")?;
    let properties: Vec<f64> = arguments
        .map(|text| text.parse())
        .collect::<Result<_, _>>()?;
    let umat = Umat::new(UmatSettings::new(library, &properties))?;
    let states: Vec<DeformationGradient> = (0..20_000)
        .map(|n| DeformationGradient::from_stretches([1.0 + 1e-5 * f64::from(n), 0.9, 1.0]))
        .collect::<Result<_, _>>()?;
    let start = Instant::now();
    for f in &states {
        umat.response(f)?;
    }
    let single = states.len() as f64 / start.elapsed().as_secs_f64();
    let paths = states
        .iter()
        .map(|f| umat.path(f))
        .collect::<Result<Vec<_>, _>>()?;
    let start = Instant::now();
    for outcome in umat.along_all(&paths) {
        outcome?;
    }
    let batched = states.len() as f64 / start.elapsed().as_secs_f64();
    println!("{single:.0} calls per second one by one, {batched:.0} in batches");
    Ok(ExitCode::SUCCESS)
}
