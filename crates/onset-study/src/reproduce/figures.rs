//! Figures of the paper.

use super::boundary::{material_boundary, onsets, state};
use super::{ReproduceError, StudyResult, study};
use crate::answers::{Problem, ProblemError};
use crate::csv::Table;
use crate::domain::Domain;
use crate::figure::{
    Arrows, Axis, Field, Figure, Label, Line, Marker, Panel, Points, Rule, palette,
};
use crate::settings::{Study, Units};
use nalgebra::{Vector2, vector};
use onset::analysis::{Analysis, acoustic_minimum_in, analysis};
use onset::kinematics::DeformationGradient;
use onset::lattice::LatticeKind;
use onset::material::{BlatzKo, Hyperelastic, ModifiedMooneyRivlin};
use onset::method::{KernelMethodChoices, MethodError};
use onset::quadrature::Quadrature;
use onset::scheme::MethodChoices;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// Figure of the paper with its data.
pub struct Plate {
    /// Drawing of the figure.
    pub figure: Figure,
    /// Data of the figure, as tables by name.
    pub tables: Vec<(String, String)>,
}

/// Recipe for a figure.
pub struct Recipe {
    /// File name without extension.
    pub name: &'static str,
    /// Function that computes the figure.
    pub make: fn() -> Result<Plate, ReproduceError>,
}

/// Recipes of all figures, in the order of the paper.
pub const ALL: [Recipe; 8] = [
    Recipe {
        name: "figure-02",
        make: figure_02,
    },
    Recipe {
        name: "figure-04",
        make: figure_04,
    },
    Recipe {
        name: "figure-05",
        make: figure_05,
    },
    Recipe {
        name: "figure-06",
        make: figure_06,
    },
    Recipe {
        name: "figure-07",
        make: figure_07,
    },
    Recipe {
        name: "figure-08",
        make: figure_08,
    },
    Recipe {
        name: "figure-09",
        make: figure_09,
    },
    Recipe {
        name: "figure-10",
        make: figure_10,
    },
];

fn stretch_panel(study: &Study, title: &str) -> Panel {
    let [first, second] = study.plane();
    let units = study.settings.units();
    Panel::new(
        title,
        Axis::linear(first.label(units), first.range),
        Axis::linear(second.label(units), second.range),
    )
    .equal_aspect()
}

fn spread((low, high): (f64, f64), count: usize) -> Vec<f64> {
    (0..count)
        .map(|n| low + (high - low) * n as f64 / (count - 1) as f64)
        .collect()
}

fn csv(header: &str, rows: impl IntoIterator<Item = Vec<f64>>) -> String {
    let rows: Vec<Vec<f64>> = rows.into_iter().collect();
    let names = header.split(',').enumerate();
    names
        .fold(Table::new(&rows, Units::Own), |table, (n, name)| {
            table.with(name, "1", move |row| row[n])
        })
        .to_string()
}

fn pairs(points: &[(f64, f64)]) -> String {
    csv(
        "stretch_1,stretch_2",
        points.iter().map(|(a, b)| vec![*a, *b]),
    )
}

/// Boundary of strong ellipticity within a window.
fn continuum_boundary(study: &Study, count: usize) -> Result<Vec<(f64, f64)>, ReproduceError> {
    let problem = Problem::new(study.settings.clone())?;
    let [first, second] = study.plane();
    Ok(material_boundary(
        &*problem.material,
        &spread(first.range, count),
        // The range exceeds the window slightly, so that the curve reaches its edge.
        (second.range.0, 1.15 * second.range.1),
    )?)
}

/// Map of the material alone, with the exact verdict on ellipticity.
fn ellipticity_map(study: &Study) -> Result<crate::figure::Regions, ReproduceError> {
    let problem = Problem::new(study.settings.clone())?;
    let [first, second] = study.plane();
    let elliptic = |index: usize| -> Result<&'static str, ProblemError> {
        let f = study.deformation_at(&study.coordinates(index))?;
        let minimum = acoustic_minimum_in(2, &*problem.material, &f).map_err(MethodError::from)?;
        Ok(if minimum.ellipticity().is_elliptic() {
            "stable"
        } else {
            "physical"
        })
    };
    let words: Vec<&str> = (0..study.states())
        .into_par_iter()
        .map(elliptic)
        .collect::<Result<_, _>>()?;
    Ok(crate::figure::Regions::of_words(
        first.range,
        second.range,
        (first.count, second.count),
        words,
    ))
}

/// Analysis of a kernel method with a material.
fn of_kernels(
    choices: KernelMethodChoices,
    material: Arc<dyn Hyperelastic>,
) -> Result<Box<dyn Analysis>, ProblemError> {
    Ok(analysis(
        &MethodChoices::Kernel(Box::new(choices)),
        material,
    )?)
}

fn figure_02() -> Result<Plate, ReproduceError> {
    let study = study!("figure-02")?;
    let boundary = continuum_boundary(&study, 100)?;
    let restored = study.clone().with_ranges(&[(0.5, 16.0), (0.5, 16.0)]);
    let wide = continuum_boundary(&restored, 80)?;
    let upper: Vec<(f64, f64)> = wide.iter().copied().filter(|(a, b)| a * b > 20.0).collect();
    let lower: Vec<(f64, f64)> = wide
        .iter()
        .copied()
        .filter(|(a, b)| a * b <= 20.0)
        .collect();
    let figure = Figure::new("Figure 2. Stable domain of the PDE, material of equation (5)")
        .caption(
            "Left: the window of the paper. Right: the same material over a wider window; the unstable set is a strip: \
             for large J the material is strongly elliptic again, which the paper does not say.",
        )
        .columns(2)
        .with(
            stretch_panel(&study, "window of the paper")
                .with(ellipticity_map(&study)?)
                .with(Line::new(boundary.clone()).named("loss of strong ellipticity")),
        )
        .with(
            stretch_panel(&restored, "wider window")
                .with(ellipticity_map(&restored)?)
                .with(Line::new(lower.clone()))
                .with(Line::new(upper.clone()).dashed().named("return of strong ellipticity")),
        );
    Ok(Plate {
        figure,
        tables: vec![
            ("figure-02-boundary".into(), pairs(&boundary)),
            ("figure-02-boundary-wide".into(), pairs(&wide)),
        ],
    })
}

/// Displacement of a particle in a mode, `cos(k.X)`.
fn displacement(k: &Vector2<f64>, x: &Vector2<f64>) -> f64 {
    k.dot(x).cos()
}

fn figure_04() -> Result<Plate, ReproduceError> {
    let nodal = KernelMethodChoices {
        quadrature: Quadrature::Nodal,
        ..KernelMethodChoices::default()
    };
    let lattice = LatticeKind::Hexagonal.lattice::<2>(1.0);
    let lattice = lattice.map_err(|error| ProblemError::from(MethodError::from(error)))?;
    let lattice = lattice.vectors();
    let waves = of_kernels(nodal, Arc::new(ModifiedMooneyRivlin::default()))?
        .waves(&state(1.1, 0.95)?)
        .map_err(ProblemError::from)?;
    let modes = [
        ("K", vector![4.0 * PI / 3.0, 0.0]),
        ("M", vector![TAU, 0.0]),
    ];
    let mut figure =
        Figure::new("Figure 4. Spurious modes of nodal integration, hexagonal lattice, θ = 0")
            .columns(2);
    let mut table = Vec::new();
    for (name, k) in &modes {
        let omega = waves.omega_squared(k.as_slice());
        let wave = spread((0.0, 8.0), 400)
            .into_iter()
            .map(|x| (x, displacement(k, &vector![x, 0.0])));
        let nodes: Vec<(f64, f64)> = (0..=8)
            .map(|n| (f64::from(n), displacement(k, &vector![f64::from(n), 0.0])))
            .collect();
        table.extend(nodes.iter().map(|(x, u)| vec![k[0], *x, *u]));
        let title = format!(
            "{name}: κ = {:.5}, largest |ω²| = {:.0e}",
            k[0],
            omega[1].norm().max(1e-99)
        );
        let panel = Panel::new(
            title,
            Axis::linear("position X along a row (spacings)", (-0.3, 8.3)),
            Axis::linear("displacement u (amplitudes)", (-1.45, 1.45)),
        );
        figure = figure.with(
            panel
                .with(Rule::horizontal(0.0).color(palette::GREY))
                .with(
                    Line::new(wave.collect::<Vec<_>>())
                        .color(palette::SKY)
                        .named("plane wave"),
                )
                .with(
                    Line::new(nodes.clone())
                        .color(palette::BLUE)
                        .named("displacement between particles"),
                )
                .with(
                    Points::new(nodes)
                        .color(palette::VERMILION)
                        .marker(Marker::Triangle)
                        .named("particles of the row"),
                ),
        );
    }
    for (name, k) in [
        ("K", vector![4.0 * PI / 3.0, 0.0]),
        ("M", vector![0.0, TAU / 3.0_f64.sqrt()]),
    ] {
        let (mut rest, mut moved) = (Vec::new(), Vec::new());
        for j in -1..=4 {
            for i in -3..=6 {
                let x = lattice * vector![f64::from(i), f64::from(j)];
                if (-0.1..=5.1).contains(&x[0]) && (-0.1..=3.6).contains(&x[1]) {
                    rest.push((x[0], x[1]));
                    moved.push((x[0] + 0.35 * displacement(&k, &x), x[1]));
                }
            }
        }
        let panel = Panel::new(
            format!("{name} on the lattice, k = ({:.4}, {:.4})", k[0], k[1]),
            Axis::linear("X (spacings)", (-0.7, 5.7)),
            Axis::linear("Y (spacings)", (-0.6, 4.0)),
        );
        figure = figure.with(
            panel
                .equal_aspect()
                .with(
                    Points::new(rest.clone())
                        .color(palette::GREY)
                        .marker(Marker::Circle)
                        .open()
                        .named("particle, reference position"),
                )
                .with(
                    Arrows::new(rest, moved)
                        .color(palette::VERMILION)
                        .named("displacement of the mode"),
                ),
        );
    }
    let figure = figure.caption(
        "Nodal integration, Lagrangian kernel, D_mx = 2, stretches (1.1, 0.95). The gradient of the mode vanishes at \
         every particle, so that it is a zero-energy mode, in any material and at any state.",
    );
    Ok(Plate {
        figure,
        tables: vec![(
            "figure-04-modes".into(),
            csv("wave_number,x,displacement", table),
        )],
    })
}

fn figure_05() -> Result<Plate, ReproduceError> {
    let studies: [StudyResult; 3] = [
        study!("figure-05-1.6"),
        study!("figure-05-2.0"),
        study!("figure-05-2.5"),
    ];
    let mut figure = Figure::new("Figure 5. Lagrangian kernel with stress points against the PDE, material of equation (5)")
        .columns(3)
        .caption(
            "Hexagonal lattice, Shepard functions. The stable domain of the particles is exactly that of the PDE for \
             every support; crosses are onsets found from the particles alone.",
        );
    let mut tables = Vec::new();
    let boundary = continuum_boundary(&study!("figure-05-2.0")?, 80)?;
    for study in studies {
        let study = study?;
        let problem = Problem::new(study.settings.clone())?;
        let firsts = spread((0.9, 3.9), 9);
        let particle = |&first: &f64| -> Result<Vec<f64>, ProblemError> {
            let [pde, particles] = onsets(
                &*problem.analysis,
                &*problem.material,
                [first, 0.2],
                [first, 3.8],
            )?;
            let second = |s: Option<f64>| s.map_or(f64::NAN, |s| 0.2 + 3.6 * s);
            Ok(vec![first, second(pde), second(particles)])
        };
        let rows: Vec<Vec<f64>> = firsts.par_iter().map(particle).collect::<Result<_, _>>()?;
        let support = study.settings.discretization.support;
        figure = figure.with(
            stretch_panel(&study, &study.title)
                .with(Domain::of(&study)?.smoothed()?.layer())
                .with(Line::new(boundary.clone()).named("PDE"))
                .with(
                    Points::new(rows.iter().map(|row| (row[0], row[2])).collect::<Vec<_>>())
                        .marker(Marker::Cross)
                        .color(palette::VERMILION)
                        .named("onset of the particles"),
                ),
        );
        tables.push((
            format!("figure-05-{support:.1}"),
            csv("stretch_1,stretch_2_pde,stretch_2_particles", rows),
        ));
    }
    Ok(Plate { figure, tables })
}

fn figure_06() -> Result<Plate, ReproduceError> {
    domains(
        [
            study!("figure-06-regular-paper-1.6"),
            study!("figure-06-regular-paper-1.9"),
            study!("figure-06-regular-paper-2.0"),
            study!("figure-06-regular-exact-1.9"),
            study!("figure-06-convected-paper-2.0"),
            study!("figure-06-convected-exact-1.6"),
        ],
        "figure-06",
        Figure::new("Figure 6. Eulerian kernel with stress points, material of equation (5)").columns(3).caption(
            "The paper shows one domain: compression only. Whether that is so depends on the support size and on what is \
             meant by the current configuration, which the paper does not say. Curve: the PDE.",
        ),
    )
}

fn figure_10() -> Result<Plate, ReproduceError> {
    domains(
        [
            study!("figure-10-lagrangian"),
            study!("figure-10-regular-paper-1.6"),
            study!("figure-10-convected-exact-1.6"),
        ],
        "figure-10",
        Figure::new("Figure 10. Lagrangian kernel (left) and Eulerian kernels, Blatz-Ko material").columns(3).caption(
            "D_mx = 1.6, stress points. The Lagrangian kernel has the domain of the PDE; the Eulerian one distorts it, most in tension. \
             Grey: a quadrature point has lost its neighbors.",
        ),
    )
}

/// Title as part of a file name.
fn slug(title: &str) -> String {
    let words = title.split(|c: char| !c.is_ascii_alphanumeric() && c != '.');
    words
        .filter(|word| !word.is_empty() && *word != "s")
        .collect::<Vec<_>>()
        .join("-")
        .to_lowercase()
}

/// Panels of maps with the boundary of the PDE.
fn domains<const N: usize>(
    studies: [StudyResult; N],
    name: &str,
    mut figure: Figure,
) -> Result<Plate, ReproduceError> {
    let mut tables = Vec::new();
    let studies: Vec<Study> = studies.into_iter().collect::<Result<_, _>>()?;
    // All panels show the same material.
    let boundary = continuum_boundary(&studies[0], 80)?;
    let twice = boundary.windows(2).any(|pair| pair[0].0 == pair[1].0);
    let (outer, inner): (Vec<_>, Vec<_>) = boundary.into_iter().partition(|(a, b)| !twice || b > a);
    for study in studies {
        let domain = Domain::of(&study)?;
        figure = figure.with(
            stretch_panel(&study, &study.title)
                .with(domain.smoothed()?.layer())
                .with(Line::new(outer.clone()).named("PDE"))
                .with(Line::new(inner.clone())),
        );
        tables.push((format!("{name}-{}", slug(&study.title)), domain.csv()));
    }
    Ok(Plate { figure, tables })
}

/// Number of cells of a drawn field per computed state along an axis.
const CELLS_PER_STATE: usize = 6;

/// Values on a grid that is finer by a factor, interpolated linearly between the cell centers of the given grid and constant beyond them.
fn interpolated(values: &[f64], (columns, rows): (usize, usize), factor: usize) -> Vec<f64> {
    // Neighbors of a fine cell along an axis, and the weight of the second one.
    let between = |n: usize, count: usize| {
        let last = (count - 1) as f64;
        let place = ((n as f64 + 0.5) / factor as f64 - 0.5).clamp(0.0, last);
        let low = place.floor();
        (low as usize, (low + 1.0).min(last) as usize, place - low)
    };
    let mut finer = Vec::with_capacity(values.len() * factor * factor);
    for y in 0..rows * factor {
        let (lower, upper, up) = between(y, rows);
        for x in 0..columns * factor {
            let (left, right, along) = between(x, columns);
            let of = |row: usize| {
                let [a, b] = [left, right].map(|column| values[row * columns + column]);
                a + along * (b - a)
            };
            finer.push(of(lower) + up * (of(upper) - of(lower)));
        }
    }
    finer
}

fn figure_07() -> Result<Plate, ReproduceError> {
    let study = study!("figure-07")?;
    let problem = Problem::new(study.settings.clone())?;
    let [first, second] = study.plane();
    let extremes = |index: usize| -> Result<Vec<f64>, ProblemError> {
        let coordinates = study.coordinates(index);
        let f = study.deformation_at(&coordinates)?;
        let summary = problem.analysis.spectrum(&f)?;
        Ok(vec![
            coordinates[0],
            coordinates[1],
            summary.lowest.omega_squared.re,
            summary.maximum_omega.powi(2),
        ])
    };
    let rows: Vec<Vec<f64>> = (0..study.states())
        .into_par_iter()
        .map(extremes)
        .collect::<Result<_, _>>()?;
    let column = |c: usize| rows.iter().map(|row| row[c]).collect::<Vec<f64>>();
    let field = |c: usize, label: &str| {
        let size = (first.count, second.count);
        let finer = (
            CELLS_PER_STATE * first.count,
            CELLS_PER_STATE * second.count,
        );
        let values = interpolated(&column(c), size, CELLS_PER_STATE);
        Field::new(first.range, second.range, finer, values, label)
    };
    let lowest = column(2).into_iter().fold(0.0, f64::min);
    let figure = Figure::new("Figure 7. Squares of the frequencies, Eulerian kernel with stress points")
        .columns(2)
        .caption(format!(
            "D_mx = 1.6, regular lattice, paper's linearization, material of equation (5), extremes over the whole Brillouin \
             zone. The largest ω² is positive in every state and decides nothing; the smallest decides: it is zero (the \
             translation) where the state is stable. Computed in {} × {} states, interpolated between them.",
            first.count, second.count
        ))
        .with(stretch_panel(&study, "smallest ω²").with(field(2, "min ω² (1/time²)").diverging().range(lowest, -lowest)))
        .with(stretch_panel(&study, "largest ω²").with(field(3, "max ω² (1/time²)")));
    let table = csv(
        "stretch_1,stretch_2,minimum_omega_squared,maximum_omega_squared",
        rows,
    );
    Ok(Plate {
        figure,
        tables: vec![("figure-07".into(), table)],
    })
}

fn figure_08() -> Result<Plate, ReproduceError> {
    let study = study!("figure-08")?;
    let material = BlatzKo::default();
    let gamma = 2.0 - 3.0_f64.sqrt();
    let (low, high) = study.plane()[0].range;
    // The two-dimensional boundary from the acoustic tensor of plane waves, along circles around the origin.
    let boundary = continuum_boundary(&study, 80)?;
    let (upper, lower): (Vec<_>, Vec<_>) = boundary.iter().copied().partition(|(a, b)| b > a);
    // The three-dimensional boundary by bisection of the smallest eigenvalue over all directions in three dimensions.
    let spatial = |f: &DeformationGradient| -> Result<f64, ProblemError> {
        let minimum = acoustic_minimum_in(3, &material, f).map_err(MethodError::from)?;
        Ok(minimum.eigenvalue.re)
    };
    let along = |&angle: &f64| -> Result<Vec<f64>, ProblemError> {
        let (sine, cosine) = angle.sin_cos();
        // In logarithmic stretches the domain is star-shaped about the reference state.
        let at = |radius: f64| state((radius * cosine).exp(), (radius * sine).exp());
        let (mut inside, mut outside) = (0.0, 4.0);
        while outside - inside > 1e-7 {
            let middle = 0.5 * (inside + outside);
            if spatial(&at(middle)?)? > 0.0 {
                inside = middle
            } else {
                outside = middle
            }
        }
        Ok(vec![(inside * cosine).exp(), (inside * sine).exp()])
    };
    let angles = spread((0.0, TAU), 33);
    let space: Vec<Vec<f64>> = angles.par_iter().map(along).collect::<Result<_, _>>()?;
    let corners = vec![
        (gamma, gamma),
        (1.0, gamma),
        (1.0 / gamma, 1.0),
        (1.0 / gamma, 1.0 / gamma),
        (1.0, 1.0 / gamma),
        (gamma, 1.0),
        (gamma, gamma),
    ];
    let figure = Figure::new("Figure 8. Stable domain of the Blatz-Ko material")
        .caption(
            "Perturbations in the plane (62): γ < λ₁/λ₂ < 1/γ, γ = 2 − √3. Three-dimensional perturbations (60) demand γ < λ_i < 1/γ \
             as well. Curves: closed forms and traced boundary; circles: smallest eigenvalue over all directions in three dimensions.",
        )
        .with(
            stretch_panel(&study, "")
                .with(ellipticity_map(&study)?)
                .with(Line::new(upper.clone()).width(5.0).named("2D perturbation, traced"))
                .with(Line::new(lower.clone()).width(5.0))
                .with(Line::new(vec![(low, low / gamma), (high * gamma, high)]).color(palette::ORANGE).dashed().named("2D, equation (62)"))
                .with(Line::new(vec![(low / gamma, low), (high, high * gamma)]).color(palette::ORANGE).dashed())
                .with(Line::new(corners).color(palette::VERMILION).dashed().named("3D, equation (60)"))
                .with(
                    Points::new(space.iter().map(|row| (row[0], row[1])).collect::<Vec<_>>())
                        .open()
                        .color(palette::VERMILION)
                        .named("3D perturbation, computed"),
                )
                .with(Label::new((0.62 * high, 0.06 * high), "λ₁/λ₂ = 1/γ"))
                .with(Label::new((0.04 * high, 0.9 * high), "λ₁/λ₂ = γ")),
        );
    Ok(Plate {
        figure,
        tables: vec![
            ("figure-08-2d".into(), pairs(&boundary)),
            ("figure-08-3d".into(), csv("stretch_1,stretch_2", space)),
        ],
    })
}

fn figure_09() -> Result<Plate, ReproduceError> {
    let stretches: Vec<f64> = spread((0.5, 5.0), 46);
    let points = [
        ("M", vector![0.0, TAU / 3.0_f64.sqrt()]),
        ("K", vector![4.0 * PI / 3.0, 0.0]),
    ];
    let mut figure = Figure::new("Figure 9. Frequencies at equibiaxial stretches, Blatz-Ko, Lagrangian kernel with stress points")
        .columns(2)
        .caption(
            "Smallest ω² at the corner K and at the middle M of the zone's edge (μ = 32, density and spacing 1). It decays as \
             λ⁻⁴ whatever the method, and with the support, where the mode is weakly controlled.",
        );
    let mut table = Vec::new();
    for (name, k) in points {
        let mut panel = Panel::new(
            format!("{name} point"),
            Axis::linear("stretch λ₁ = λ₂ (−)", (0.5, 5.0)),
            Axis::log("smallest ω² (1/time²)", (1e-6, 1e4)),
        );
        for (support, color) in [1.6, 2.0, 2.5].into_iter().zip(palette::SERIES) {
            let choices = KernelMethodChoices {
                support,
                lattice: LatticeKind::Hexagonal,
                ..KernelMethodChoices::default()
            };
            let method = of_kernels(choices, Arc::new(BlatzKo::default()))?;
            let at = |&stretch: &f64| -> Result<(f64, f64), ProblemError> {
                let waves = method.waves(&state(stretch, stretch)?)?;
                Ok((stretch, waves.omega_squared(k.as_slice())[0].re))
            };
            let line: Vec<(f64, f64)> = stretches.par_iter().map(at).collect::<Result<_, _>>()?;
            table.extend(
                line.iter()
                    .map(|(stretch, omega)| vec![k[0], k[1], support, *stretch, *omega]),
            );
            panel = panel.with(
                Line::new(line)
                    .color(color)
                    .named(format!("D_mx = {support}")),
            );
        }
        figure = figure.with(panel);
    }
    let table = csv(
        "wave_vector_1,wave_vector_2,support,stretch,omega_squared",
        table,
    );
    Ok(Plate {
        figure,
        tables: vec![("figure-09".into(), table)],
    })
}
