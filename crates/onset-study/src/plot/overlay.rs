//! Overlay of several discretizations: their boundaries over the domain of the material.

use super::stored::StoredMap;
use super::{Lines, PlotError, axes, lines};
use crate::answers::{Problem, ProblemError};
use crate::boundary::{BoundaryError, Watch};
use crate::domain::Class;
use crate::figure::{Color, Dash, Figure, Line, Regions, palette};
use crate::settings::Study;
use onset::analysis::probe_material_in;
use onset::cancel::Scope;
use onset::method::MethodError;
use onset::verdict::{Phase, Probe, Verdict};
use rayon::prelude::*;

/// Number of cells of the material's domain along each axis.
const CELLS: usize = 256;
/// Colors and, for greyscale prints, dash patterns of the lines.
const COLORS: [Color; 6] = [
    palette::VERMILION,
    palette::BLUE,
    palette::GREEN,
    palette::PURPLE,
    palette::ORANGE,
    palette::GREY,
];
const DASHES: [Dash; 3] = [Dash::Solid, Dash::Dashed, Dash::Dotted];

/// Figure of several maps with two axes, and whether their boundaries are traced.
pub(super) fn overlay(
    maps: &[StoredMap],
    boundaries: Lines,
    watch: &dyn Watch,
) -> Result<(Figure, bool), PlotError> {
    let first = &maps[0];
    for other in maps {
        if let Some(difference) = first.differs_from(other) {
            return Err(PlotError::NotComparable {
                first: first.path.clone(),
                path: other.path.clone(),
                difference,
            });
        }
    }
    // The panel covers the ranges of all maps.
    let ranges: Vec<(f64, f64)> = (0..2)
        .map(|axis| {
            let ranges = maps.iter().map(|map| map.study.axes[axis].range);
            ranges.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), range| {
                (low.min(range.0), high.max(range.1))
            })
        })
        .collect();
    let study = first.study.clone().with_ranges(&ranges);
    let mut panel = axes(&study, "");
    panel = if first.may_be_evaluated() {
        panel.with(domain(&study)?)
    } else {
        lines::material_of_cells(first, &first.slices(1)[0])?
            .into_iter()
            .fold(panel, |panel, line| panel.with(line))
    };
    let traced = lines::boundaries(maps.iter().map(|map| &map.study), boundaries, watch)?;
    if traced.is_none() && first.may_be_evaluated() {
        let line = lines::material_of_cells(first, &first.slices(1)[0])?;
        panel = line.into_iter().fold(panel, |panel, line| panel.with(line));
    }
    for (n, map) in maps.iter().enumerate() {
        let slice = &map.slices(1)[0];
        let mut name = map.title();
        // Equal titles are distinguished by their folders.
        if maps.iter().filter(|other| other.title() == name).count() > 1 {
            name = format!("{name} ({})", map.path.display());
        }
        let points = if let Some(boundaries) = traced.as_ref().map(|traced| &traced[n]) {
            if n == 0 {
                panel = lines::material(&boundaries.material)
                    .into_iter()
                    .fold(panel, |panel, line| panel.with(line));
            }
            name = lines::honest(&name, &boundaries.discretization);
            lines::joined(&boundaries.discretization)
        } else {
            let (cells, classes) = map.classes(slice)?;
            let stable = lines::stable_for_particles(&classes);
            let [x, y] = map.study.plane();
            lines::edges(&stable, cells, x.range, y.range)
        };
        let mut line = Line::new(points)
            .color(COLORS[n % COLORS.len()])
            .named(name);
        line.dash = DASHES[n % DASHES.len()];
        panel = panel.with(line);
    }
    let figure = Figure::new("Where the discretizations lose stability")
        .columns(1)
        .with(panel);
    Ok((figure, traced.is_some()))
}

/// Domain in which the material is strongly elliptic for in-plane perturbations.
fn domain(study: &Study) -> Result<Regions, PlotError> {
    let shared = if study.varies_settings() {
        None
    } else {
        Some(Problem::new(study.settings.clone()).map_err(BoundaryError::from)?)
    };
    let [first, second] = study.plane();
    let at = |range: (f64, f64), n: usize| {
        range.0 + (range.1 - range.0) * (n as f64 + 0.5) / CELLS as f64
    };
    let class = |index: usize| -> Result<u8, ProblemError> {
        let coordinates = [
            at(first.range, index % CELLS),
            at(second.range, index / CELLS),
        ];
        let f = study.deformation_at(&coordinates)?;
        let asked = |problem: &Problem| -> Result<Probe, ProblemError> {
            let probe = probe_material_in(problem.dimension(), &*problem.material, &f);
            Ok(probe.map_err(MethodError::from)?)
        };
        let (phase, _) = match &shared {
            Some(problem) => asked(problem)?,
            None => asked(&Problem::new(study.settings_at(&coordinates)?)?)?,
        };
        Ok(u8::from(phase != Phase::Stable))
    };
    let scope = Scope::current();
    let classes: Vec<u8> = (0..CELLS * CELLS)
        .into_par_iter()
        .map(|n| scope.run(|| class(n)))
        .collect::<Result<_, _>>()
        .map_err(BoundaryError::from)?;
    let color = |verdict: Verdict| Class::Verdict(verdict).color();
    Ok(Regions::new(
        first.range,
        second.range,
        (CELLS, CELLS),
        classes,
        [
            ("strongly elliptic material", color(Verdict::Stable)),
            ("material not elliptic", color(Verdict::Physical)),
        ],
    ))
}
