//! Marlow's form: an energy of the first invariant that interpolates the table of one test.
//!
//! R. S. Marlow, in *Constitutive Models for Rubber III* (2003) 157. With `x = I1bar - 3` the nominal stress of a test at the stretch `lambda` is `T
//! = 2 w(x) (lambda - lambda^-k)`, `w = dW/dx`, where `k` is 2 in uniaxial, 5 in equibiaxial and 3 in planar tension. The table gives `w` at its
//! points.
//!
//! Between the points `w` is a cubic that is monotone where the points are (F. N. Fritsch and J. Butland, *SIAM J. Sci. Stat. Comput.* 5 (1984) 300).
//! The energy has two continuous derivatives, and reproduces the test exactly at the points. Before the first point and after the last point `w` is
//! extrapolated along its tangent.

use super::law::{Energy, ForeignLaw, Volume};
use super::unread::Unread;
use super::{Trouble, number};
use crate::number::counted;
use onset::kinematics::DeformationGradient;
use onset::material::StrainEnergy;
use onset::real::Real;

/// The test of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Test {
    Uniaxial,
    Biaxial,
    Planar,
}

impl Test {
    /// Returns the test of an Abaqus keyword; `None` for other keywords.
    pub fn of_keyword(keyword: &str) -> Option<Self> {
        match keyword {
            "UNIAXIALTESTDATA" => Some(Self::Uniaxial),
            "BIAXIALTESTDATA" => Some(Self::Biaxial),
            "PLANARTESTDATA" => Some(Self::Planar),
            _ => None,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Uniaxial => "uniaxial",
            Self::Biaxial => "biaxial",
            Self::Planar => "planar",
        }
    }

    /// `I1 - 3` of the test at a stretch, and `2 (lambda - lambda^-k)`.
    fn at(self, stretch: f64) -> (f64, f64) {
        let (l, square) = (stretch, stretch * stretch);
        match self {
            Self::Uniaxial => (square + 2.0 / l - 3.0, 2.0 * (l - l.powi(-2))),
            Self::Biaxial => (2.0 * square + l.powi(-4) - 3.0, 2.0 * (l - l.powi(-5))),
            Self::Planar => (square + l.powi(-2) - 2.0, 2.0 * (l - l.powi(-3))),
        }
    }
}

/// A point of the table: `x`, `w` and `dw/dx`.
#[derive(Clone, Copy, Debug)]
struct Knot {
    x: f64,
    w: f64,
    slope: f64,
}

/// Law for a table with nominal stress and nominal strain on each line. `line` is the line of the block, `poisson` Poisson's ratio at small strains.
pub(super) fn law(
    line: usize,
    test: Test,
    data: &[(usize, &str)],
    poisson: Option<f64>,
    unread: &mut Unread,
) -> Result<ForeignLaw, Trouble> {
    let knots = knots(line, test, data, unread)?;
    let shear = 2.0 * knots[0].w;
    let compressibility = match poisson {
        None => 0.0,
        Some(nu) if nu > -1.0 && nu < 0.5 => 3.0 * (1.0 - 2.0 * nu) / (shear * (1.0 + nu)),
        Some(nu) => {
            return Err(Trouble::new(
                line,
                format!("POISSON is {nu}; expected a number above -1 and below 0.5"),
                "omit POISSON for an incompressible material",
            ));
        }
    };
    let end = knots[knots.len() - 1].x;
    let mut law = ForeignLaw::new(
        line,
        "*HYPERELASTIC, MARLOW of Abaqus",
        Energy::Table(Table(pieces_of(&knots))),
        Vec::new(),
        (shear, Volume::Powers(&[compressibility])),
    );
    law.name = Some(format!(
        "Marlow, {} of a {} test",
        counted(data.len(), "point"),
        test.name()
    ));
    law.notes.push(format!(
        "Marlow's form from {} points, dW/dI1 a monotone cubic between them; beyond I1 - 3 = {end:.4}, past the test data, it is extrapolated along its tangent",
        data.len(),
    ));
    Ok(law)
}

/// The points of the table by `x`, with an additional first point at `x = 0`.
fn knots(
    line: usize,
    test: Test,
    data: &[(usize, &str)],
    unread: &mut Unread,
) -> Result<Vec<Knot>, Trouble> {
    let mut points: Vec<(f64, f64)> = Vec::new();
    let mut sense = 0.0;
    let mut conditions: Option<Vec<f64>> = None;
    for (own, text) in data {
        let fields: Vec<&str> = text.trim_end_matches(',').split(',').collect();
        let stress = number(fields[0], *own)?;
        let strain = number(fields.get(1).copied().unwrap_or(""), *own)?;
        // The temperature and the field variables of the table follow the lateral strain.
        let rest = fields.get(3..).unwrap_or_default();
        let here: Result<Vec<f64>, Trouble> =
            rest.iter().map(|field| number(field, *own)).collect();
        let here = here?;
        match &conditions {
            None => {
                for (place, field) in rest.iter().enumerate() {
                    unread.condition(place, field, *own)?;
                }
                conditions = Some(here);
            }
            Some(first) if *first != here => {
                return Err(Trouble::new(
                    *own,
                    "the table has several temperatures or field variables",
                    "keep the rows of one temperature",
                ));
            }
            Some(_) => {}
        }
        if stress == 0.0 && strain == 0.0 {
            continue;
        }
        if number(fields.get(2).copied().unwrap_or(""), *own)? != 0.0 {
            return Err(Trouble::new(
                *own,
                "the third column is a lateral strain, which determines the change of volume and is not supported",
                "give Poisson's ratio instead (*HYPERELASTIC, MARLOW, POISSON=0.49), or fit a law of foams to the test (`onset fit`)",
            ));
        }
        if stress * strain <= 0.0 || strain <= -1.0 {
            return Err(Trouble::new(
                *own,
                format!("the stress {stress} belongs to the strain {strain}"),
                "expected nominal stress and nominal strain of one sign, the strain above -1",
            ));
        }
        if sense * strain < 0.0 {
            return Err(Trouble::new(
                *own,
                "the table has tension and compression, which determine the same energy twice",
                "omit one of them, because Marlow's form needs a single test",
            ));
        }
        sense = strain.signum();
        let (x, factor) = test.at(1.0 + strain);
        points.push((x, stress / factor));
    }
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    if points.len() < 2 || points.windows(2).any(|pair| pair[1].0 <= pair[0].0) {
        return Err(Trouble::new(
            line,
            "Marlow's form needs a table of at least two different strains",
            "write nominal stress, nominal strain on the lines below *UNIAXIAL TEST DATA",
        ));
    }
    // Extrapolation to zero strain along the first chord, limited to keep the material stiff.
    let chord = (points[1].1 - points[0].1) / (points[1].0 - points[0].0);
    let first = points[0].1 - chord * points[0].0;
    let first = first.clamp(0.5 * points[0].1, 2.0 * points[0].1);
    points.insert(0, (0.0, first));
    Ok(with_slopes(&points))
}

/// Slopes of a monotone cubic: inside the weighted harmonic mean of the chords, zero at turning points, at the ends the chord itself.
fn with_slopes(points: &[(f64, f64)]) -> Vec<Knot> {
    let chord = |n: usize| (points[n + 1].1 - points[n].1) / (points[n + 1].0 - points[n].0);
    let width = |n: usize| points[n + 1].0 - points[n].0;
    let last = points.len() - 1;
    let slope = |n: usize| {
        if n == 0 {
            return chord(0);
        }
        if n == last {
            // After the last point a falling slope would eventually remove all stiffness.
            return chord(last - 1).max(0.0);
        }
        let (before, behind) = (chord(n - 1), chord(n));
        if before * behind <= 0.0 {
            return 0.0;
        }
        let part = (width(n - 1) + 2.0 * width(n)) / (3.0 * (width(n - 1) + width(n)));
        before * behind / (part * behind + (1.0 - part) * before)
    };
    let knots = points.iter().enumerate();
    knots
        .map(|(n, (x, w))| Knot {
            x: *x,
            w: *w,
            slope: slope(n),
        })
        .collect()
}

/// Piece of the energy from `start` on: its value there, and the coefficients of the powers of `x - start` from the first to the fourth.
#[derive(Debug)]
struct Piece {
    start: f64,
    energy: f64,
    powers: [f64; 4],
}

/// Energy between the points, the integral of the cubics.
fn pieces_of(knots: &[Knot]) -> Vec<Piece> {
    let mut energy = 0.0;
    let mut pieces = Vec::with_capacity(knots.len());
    for pair in knots.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let h = b.x - a.x;
        let chord = (b.w - a.w) / h;
        let second = (3.0 * chord - 2.0 * a.slope - b.slope) / h;
        let third = (a.slope + b.slope - 2.0 * chord) / (h * h);
        let powers = [a.w, a.slope / 2.0, second / 3.0, third / 4.0];
        pieces.push(Piece {
            start: a.x,
            energy,
            powers,
        });
        energy += powers.iter().rev().fold(0.0, |sum, c| (sum + c) * h);
    }
    let last = knots[knots.len() - 1];
    pieces.push(Piece {
        start: last.x,
        energy,
        powers: [last.w, last.slope / 2.0, 0.0, 0.0],
    });
    pieces
}

/// Energy of a table as a function of `x = I1bar - 3`.
#[derive(Debug)]
pub(in crate::settings) struct Table(Vec<Piece>);

impl Table {
    /// Adds a volumetric part with a bulk modulus.
    pub(in crate::settings) fn with_bulk(self, bulk: f64) -> TableLaw {
        TableLaw { table: self, bulk }
    }
}

/// Energy `W = w(I1bar - 3) + kappa/2 (J - 1)^2` with `w` from a table.
pub(in crate::settings) struct TableLaw {
    table: Table,
    bulk: f64,
}

impl StrainEnergy for TableLaw {
    fn energy<R: Real>(&self, f: &DeformationGradient<R>) -> R {
        let i = f.invariants();
        let x = i.first * i.jacobian.powf(-2.0 / 3.0) - 3.0;
        let change = i.jacobian - 1.0;
        within(&self.table.0, x) + change * change * (0.5 * self.bulk)
    }
}

/// Evaluates the piece that contains a number, found by bisection; for an interval, the hull of its pieces.
fn within<R: Real>(pieces: &[Piece], x: R) -> R {
    if let [piece] = pieces {
        let off = x - piece.start;
        let [a, b, c, d] = piece.powers;
        return off * (off * (off * (off * d + c) + b) + a) + piece.energy;
    }
    let (below, above) = pieces.split_at(pieces.len() / 2);
    x.switch(above[0].start, || within(below, x), || within(above, x))
}
