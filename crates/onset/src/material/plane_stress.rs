//! Plane stress: a three-dimensional law for a thin sheet or bar with traction-free faces.

use super::{
    FourthOrder, Hyperelastic, MaterialError, Response, ResponseEnclosure, cofactor,
    huge_bulk_modulus, with_pressure,
};
use crate::algebra::{Each, array_of};
use crate::kinematics::DeformationGradient;
use crate::real::{Interval, Real};
use nalgebra::{DMatrix, Matrix3};
use std::sync::Arc;

/// Components of `F` across a sheet, numbered `3 i + J`: its third column.
const ACROSS_SHEET: &[usize] = &[2, 5, 8];
/// Components across a bar: its second and third column without `F_32`, which a rotation about the bar eliminates.
const ACROSS_BAR: &[usize] = &[1, 4, 2, 5, 8];

/// Largest number of Newton steps at one state.
const NEWTON_STEPS: usize = 20;
/// Largest relative change of the stretch across in the first step. Farther from a root the iteration may converge to a different root.
const LARGEST_FIRST_STEP: f64 = 0.5;
/// Contraction required of each further step, which shows that the iteration is close to its root.
const CONTRACTION: f64 = 0.25;
/// Relative size of a step that is a rounding error.
const STEP_ROUNDING: f64 = 1e-15;
/// Largest relative step that counts as rounding if the steps do not contract.
const CONTRACTION_FLOOR: f64 = 1e-7;
/// Smallest step along the branch, as a fraction of the path from the reference configuration to a state. For a stretch of ten thousand it is a small
/// strain.
const SMALLEST_STRIDE: f64 = 1.0 / (1u32 << 26) as f64;
/// Stiffness across the sheet, relative to the largest stiffness, that is a rounding error.
const STIFFNESS_ROUNDING: f64 = 1e-12;
/// Shear traction of faces, relative to the stiffness, that is a rounding error.
const SHEAR_ROUNDING: f64 = 1e-9;
/// Cosine of the largest angle between the branch at a state and the chord to the next state.
const BRANCH_ALIGNMENT_COSINE: f64 = 0.98;
/// Cosine of this angle for a metal, whose branch turns where flow begins.
const FLOW_ALIGNMENT_COSINE: f64 = 0.9;
/// Largest relative change of the state for which the branch may turn by any angle, as at a kink of the stress.
const KINK_STEP: f64 = 1e-6;
/// Relative step of finite differences of the tractions, for a law whose tangent is not the derivative of its stress.
const DIFFERENCE_STEP: f64 = 1e-6;
/// Largest number of times that an interval of the components across is widened until it contains a root for every state.
const WIDENINGS: usize = 8;

/// Three-dimensional law reduced to a sheet in plane stress (two dimensions) or a bar in uniaxial stress (one dimension).
///
/// Traction-free faces, `P_i3 = 0`, minimize the energy over the third column of `F`:
///
/// ```math
/// W_2(F_{11}, F_{12}, F_{21}, F_{22}) = \min_{F_{13}, F_{23}, F_{33}} W(F),
/// \qquad
/// A^{(2)}_{iJkL} = A_{iJkL} - A_{iJm3} \, (Q^{-1})_{mn} \, A_{n3kL},
/// \qquad
/// Q_{mn} = A_{m3n3} .
/// ```
///
/// `Q` is the acoustic tensor of waves across the sheet, so the stationary point is a minimum if these waves have real speeds. For isotropic laws, or
/// if the plane of the sheet is a plane of mirror symmetry, `F_13` and `F_23` are zero and one stretch is computed; otherwise all three components
/// are. A bar has the second column too, up to a rotation about its axis. If several minima exist, the minimum that continues from the reference
/// configuration along `R ((1 - t) 1 + t U)` is used, with the in-plane `F = R U`.
///
/// Components of a state beyond its dimensions are not read: [`Response::deformation`] contains the computed components. Stress and tangent beyond
/// the dimensions are zero; components like `A_3131` are the components `dP_31/dF_31` of the membrane. Units of stress, per reference volume.
///
/// A metal that flows reaches a state, including its thickness, along a proportional path, at whose end the faces are traction-free. Its tangent of
/// continued flow is condensed, since continued flow keeps the faces free. Source: H. Le Dret and A. Raoult, J. Math. Pures Appl. 74 (1995) 549
/// (membranes).
///
/// A sheet whose bulk modulus exceeds 5e7 shear moduli keeps its volume. The thickness follows from it, and the pressure from the free faces, so that
/// rounding of the stiffness against changes of volume does not enter.
///
/// ```
/// use onset::kinematics::DeformationGradient;
/// use onset::material::{Hyperelastic, Law, PlaneStress};
/// let law = Law::named("saint-venant-kirchhoff").ok_or("no such law")?;
/// let sheet = PlaneStress::new(law.build(&[("mu", 1.0), ("lambda", 2.0)])?.into(), 2)?;
/// let response = sheet.response(&DeformationGradient::from_stretches([1.2, 1.0, 1.0])?)?;
/// // E33 = -lambda/(lambda + 2 mu) (E11 + E22)
/// assert!((response.deformation.components()[2][2] - (1.0_f64 - 0.5 * 0.44).sqrt()).abs() < 1e-14);
/// // S11 = E11 4 mu (lambda + mu)/(lambda + 2 mu)
/// assert!((response.first_piola[(0, 0)] - 1.2 * 0.22 * 3.0).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct PlaneStress {
    law: Arc<dyn Hyperelastic>,
    dimension: usize,
    /// Indices `3 i + J` of the components that are computed.
    across: &'static [usize],
    /// Reference state with the computed components across the sheet.
    reference: [[f64; 3]; 3],
    /// Whether the sheet keeps its volume to rounding.
    keeps_volume: bool,
}

impl PlaneStress {
    /// Creates the law of a sheet (`dimension` 2) or a bar (1).
    ///
    /// # Errors
    /// [`MaterialError::NoPlaneStress`] if the law has no out-of-plane stiffness in the reference configuration, like a fluid, if codes integrate its
    /// stress in time, and in three dimensions.
    pub fn new(law: Arc<dyn Hyperelastic>, dimension: usize) -> Result<Self, MaterialError> {
        let refused = |reason| Err(MaterialError::NoPlaneStress { reason });
        let across = match dimension {
            1 => ACROSS_BAR,
            2 => ACROSS_SHEET,
            _ => return refused("a three-dimensional body has no through-thickness direction"),
        };
        if law
            .integrated_tangent(&DeformationGradient::identity())?
            .is_some()
        {
            return refused(
                "its stress is integrated in time, and its faces would have to stay traction-free during the integration",
            );
        }
        let mut sheet = Self {
            law,
            dimension,
            across,
            reference: *DeformationGradient::identity().components(),
            keeps_volume: false,
        };
        sheet.keeps_volume = dimension == 2 && huge_bulk_modulus(&*sheet.law).is_some();
        match sheet.at_rest()? {
            Some(reference) => sheet.reference = reference,
            None => {
                return refused(
                    "near F = 1 no state with traction-free faces is stable against thickness strains, as for a fluid",
                );
            }
        }
        Ok(sheet)
    }

    /// Reference state within the dimensions, with traction-free faces.
    fn at_rest(&self) -> Result<Option<[[f64; 3]; 3]>, MaterialError> {
        // A stress-free state F = 1 is the reference state itself, even for a law with only a one-sided tangent at F = 1.
        if self.keeps_volume
            && self
                .of_constant_volume(&DeformationGradient::identity())
                .is_some()
        {
            return Ok(Some(self.reference));
        }
        let undeformed = self.law.undeformed()?;
        let Some(condensed) = self.condensed(&undeformed) else {
            return Ok(None);
        };
        if condensed.step(&self.reference, self.across) <= CONTRACTION_FLOOR * CONTRACTION_FLOOR {
            return Ok(Some(self.reference));
        }
        match self.settled(self.reference) {
            Ok(settled) => Ok(Some(*settled.response.deformation.components())),
            Err(Unsettled::Law(error)) => Err(error),
            Err(Unsettled::Lost) => Ok(None),
        }
    }

    /// Eliminates the components across the sheet from slopes and stiffness of the law; `None` unless they are at a minimum.
    fn condensed(&self, response: &Response) -> Option<Condensed<f64>> {
        let tangent = &response.tangent;
        let least = STIFFNESS_ROUNDING * tangent.largest();
        Condensed::new(
            self.across,
            |i, j| response.first_piola[(i, j)],
            |i, j, k, l| tangent[(i, j, k, l)],
            |pivot| pivot > least,
        )
    }

    /// Tangent of the remaining components.
    fn tangent(&self, condensed: &Condensed<f64>) -> FourthOrder {
        FourthOrder::from_fn(|i, j, k, l| match self.is_within(j) && self.is_within(l) {
            true => condensed.stiffness[3 * i + j][3 * k + l],
            false => 0.0,
        })
    }

    /// Like [`PlaneStress::condensed`], with finite-difference derivatives of the tractions with respect to the components across.
    fn differenced(&self, response: &Response) -> Result<Option<Condensed<f64>>, MaterialError> {
        let state = response.deformation.components();
        let mut columns = [[0.0; 9]; 9];
        for &m in self.across {
            let mut beside = *state;
            beside[m / 3][m % 3] += DIFFERENCE_STEP;
            let there = self
                .law
                .response(&DeformationGradient::from_components(beside))?;
            for &p in self.across {
                let change = there.first_piola - response.first_piola;
                columns[p][m] = change[(p / 3, p % 3)] / DIFFERENCE_STEP;
            }
        }
        let tangent = &response.tangent;
        let least = STIFFNESS_ROUNDING * tangent.largest();
        let is_across = |n: usize| self.across.contains(&n);
        Ok(Condensed::new(
            self.across,
            |i, j| response.first_piola[(i, j)],
            |i, j, k, l| match is_across(3 * i + j) && is_across(3 * k + l) {
                true => columns[3 * i + j][3 * k + l],
                false => tangent[(i, j, k, l)],
            },
            |pivot| pivot > least,
        ))
    }

    /// Solves for zero tractions across by Newton's method from a state. Returns the root with its response.
    fn settled(&self, mut state: [[f64; 3]; 3]) -> Result<Settled, Unsettled> {
        let mut last = f64::INFINITY;
        for _ in 0..NEWTON_STEPS {
            let f = DeformationGradient::from_components(state);
            if !(f.jacobian() > 0.0 && f.jacobian().is_finite()) {
                return Err(Unsettled::Lost);
            }
            let response = self.law.response(&f)?;
            let newton = match self.law.is_path_dependent() {
                true => self.differenced(&response)?,
                false => self.condensed(&response),
            };
            let newton = newton.ok_or(Unsettled::Lost)?;
            let step = newton.step(&state, self.across);
            if step <= STEP_ROUNDING || (last <= CONTRACTION_FLOOR && step > CONTRACTION * last) {
                let condensed = match self.law.is_path_dependent() {
                    true => self.condensed(&response).ok_or(Unsettled::Lost)?,
                    false => newton,
                };
                return Ok(Settled {
                    response,
                    condensed,
                });
            }
            // A step that is not a number means that the iteration has diverged.
            let admitted = (CONTRACTION * last).min(LARGEST_FIRST_STEP);
            if step.is_nan() || step > admitted {
                return Err(Unsettled::Lost);
            }
            newton.move_across(&mut state, self.across);
            last = step;
        }
        Err(Unsettled::Lost)
    }

    /// State of a sheet of constant volume, whose thickness follows from the deformation in its plane; `None` if its faces would have shear tractions or
    /// no stiffness.
    ///
    /// The pressure makes the normal traction vanish, and increments change the thickness at the rate that preserves the volume.
    fn of_constant_volume(&self, f: &DeformationGradient) -> Option<Settled> {
        let [[a, b, _], [c, d, _], _] = *f.components();
        let thickness = (a * d - b * c).recip();
        let f = DeformationGradient::new([[a, b, 0.0], [c, d, 0.0], [0.0, 0.0, thickness]]);
        let f = f.ok()?;
        let response = self.law.isochoric_response(&f).ok()?;
        let cofactor = cofactor(&f.matrix());
        let pressure = response.first_piola[(2, 2)] / cofactor[(2, 2)];
        let response = with_pressure(response, pressure);
        let shear = response.first_piola[(0, 2)].hypot(response.first_piola[(1, 2)]);
        if shear > SHEAR_ROUNDING * response.first_piola.amax().max(response.tangent.largest()) {
            return None;
        }
        let across = &self.across[..2];
        let least = STIFFNESS_ROUNDING * response.tangent.largest();
        let mut condensed = Condensed::new(
            across,
            |i, j| response.first_piola[(i, j)],
            |i, j, k, l| response.tangent[(i, j, k, l)],
            |pivot| pivot > least,
        )?;
        let thinning: [f64; 9] = array_of(|n| match n == 8 {
            true => 0.0,
            false => cofactor[(n / 3, n % 3)] / cofactor[(2, 2)],
        });
        let (row, slope) = (condensed.stiffness[8], condensed.slope[8]);
        let column: [f64; 9] = array_of(|n| condensed.stiffness[n][8]);
        for (i, j) in (0..81)
            .map(|n| (n / 9, n % 9))
            .filter(|(i, j)| *i != 8 && *j != 8)
        {
            condensed.stiffness[i][j] +=
                thinning[i] * thinning[j] * row[8] - thinning[i] * row[j] - column[i] * thinning[j];
        }
        for (own, thinning) in condensed.slope.iter_mut().zip(thinning) {
            *own -= thinning * slope;
        }
        Some(Settled {
            response,
            condensed,
        })
    }

    /// Plane-stress state that continues from the reference configuration.
    fn found(&self, f: &DeformationGradient) -> Result<Settled, MaterialError> {
        if self.keeps_volume
            && let Some(settled) = self.of_constant_volume(f)
        {
            return Ok(settled);
        }
        let way = Way::to(f, self.dimension);
        let mut state = way.turned(&self.reference);
        // A law with a kink at the reference configuration has no slope there.
        let mut slope = self
            .settled(state)
            .ok()
            .map(|settled| way.slope(&settled.condensed, self.across));
        let (mut reached, mut stride) = (0.0, 1.0_f64);
        loop {
            let next = (reached + stride).min(1.0);
            let found = self.settled(way.at(next, &state)).and_then(|settled| {
                let there = way.slope(&settled.condensed, self.across);
                let chord = chord(&state, settled.response.deformation.components());
                let least = match self.law.is_path_dependent() {
                    true => FLOW_ALIGNMENT_COSINE,
                    false => BRANCH_ALIGNMENT_COSINE,
                };
                let along =
                    |slope: &Slope| dot(&chord, slope) >= least * norm(&chord) * norm(slope);
                let is_short = norm(&chord) < KINK_STEP * (1.0 + norm(&there));
                match is_short || along(&there) && slope.as_ref().is_none_or(along) {
                    true => Ok((settled, there)),
                    false => Err(Unsettled::Lost),
                }
            });
            match found {
                Ok((settled, _)) if next == 1.0 => return Ok(settled),
                Ok((settled, there)) => {
                    state = *settled.response.deformation.components();
                    slope = Some(there);
                    reached = next;
                    stride *= 2.0;
                }
                // Even if a Newton step leaves the domain of a law, a shorter stride may succeed.
                Err(Unsettled::Law(error)) if !error.is_of_the_state() => return Err(error),
                Err(_) if stride > SMALLEST_STRIDE => stride *= 0.5,
                Err(_) => {
                    return Err(MaterialError::PlaneStressEnds {
                        reached,
                        stretch: state[2][2],
                    });
                }
            }
        }
    }

    fn is_within(&self, index: usize) -> bool {
        index < self.dimension
    }

    /// Enclosure of the components across the sheet for all states of some intervals. Each enclosure contains exactly one root, by Krawczyk's
    /// operator about the middle state.
    fn across_of(
        &self,
        f: &DeformationGradient<Interval>,
    ) -> Option<DeformationGradient<Interval>> {
        let middle = f.components().each(|row| row.map(Interval::midpoint));
        let found = self
            .found(&DeformationGradient::from_components(middle))
            .ok()?;
        let center = *found.response.deformation.components();
        let all = self.across.len();
        let place = |n: usize| (self.across[n] / 3, self.across[n] % 3);
        // The tangent of a sheet of constant volume lacks the stiffness against changes of volume.
        let tangent = self.law.response(&found.response.deformation).ok()?.tangent;
        let stiffness = DMatrix::from_fn(all, all, |n, m| {
            let ((i, j), (k, l)) = (place(n), place(m));
            tangent[(i, j, k, l)]
        });
        let inverse = stiffness.try_inverse()?;
        // Entries within the dimensions are the given intervals; entries across them lie in an interval about the center.
        let state = |offsets: &[Interval]| {
            let mut all = center.each(|row| row.map(Interval::point));
            for (i, row) in all.iter_mut().enumerate().take(self.dimension) {
                row[..self.dimension].copy_from_slice(&f.components()[i][..self.dimension]);
            }
            for (n, offset) in offsets.iter().enumerate() {
                let (i, j) = place(n);
                all[i][j] = Interval::point(center[i][j]) + *offset;
            }
            DeformationGradient::from_components(all)
        };
        let tractions = self.law.enclosure(&state(&[])).first_piola;
        let newton: Vec<Interval> = (0..all)
            .map(|n| {
                let terms = (0..all).map(|m| {
                    let (i, j) = place(m);
                    tractions[i][j] * inverse[(n, m)]
                });
                -terms.fold(Interval::ZERO, |sum, term| sum + term)
            })
            .collect();
        let scale = center[2][2].abs();
        let mut radii: Vec<f64> = newton
            .iter()
            .map(|step| 2.0 * step.magnitude() + 4.0 * f64::EPSILON * scale)
            .collect();
        for _ in 0..WIDENINGS {
            let offsets: Vec<Interval> = radii
                .iter()
                .map(|radius| Interval::new(-radius, *radius))
                .collect();
            let tangent = self.law.enclosure(&state(&offsets)).tangent;
            let image: Vec<Interval> = (0..all)
                .map(|n| {
                    (0..all).fold(newton[n], |sum, m| {
                        let (k, l) = place(m);
                        let product = (0..all).fold(Interval::ZERO, |sum, r| {
                            let (i, j) = place(r);
                            sum + tangent[i][j][k][l] * inverse[(n, r)]
                        });
                        let identity = f64::from(u8::from(n == m));
                        sum + (Interval::point(identity) - product) * offsets[m]
                    })
                })
                .collect();
            if image.iter().any(|own| !own.is_finite()) {
                return None;
            }
            let is_inside =
                |(own, radius): (&Interval, &f64)| own.low > -radius && own.high < *radius;
            if image.iter().zip(&radii).all(is_inside) {
                return Some(state(&image));
            }
            for (radius, own) in radii.iter_mut().zip(&image) {
                *radius = radius.max(1.5 * own.magnitude());
            }
        }
        None
    }

    fn enclosed(&self, f: &DeformationGradient<Interval>) -> Option<ResponseEnclosure> {
        let ResponseEnclosure {
            energy,
            first_piola,
            tangent,
        } = self.law.enclosure(&self.across_of(f)?);
        let condensed = Condensed::new(
            self.across,
            |i, j| first_piola[i][j],
            |i, j, k, l| tangent[i][j][k][l],
            |pivot: Interval| pivot.low > 0.0 && pivot.is_finite(),
        )?;
        let within =
            |is_meant: bool, value: Interval| if is_meant { value } else { Interval::ZERO };
        let component = |i: usize, j: usize, k: usize, l: usize| {
            within(
                self.is_within(j) && self.is_within(l),
                condensed.stiffness[3 * i + j][3 * k + l],
            )
        };
        Some(ResponseEnclosure {
            energy,
            // The values at the root are enclosed by the values on the whole interval, without the tractions that occur elsewhere.
            first_piola: array_of(|i| {
                array_of(|j| within(self.is_within(i) && self.is_within(j), first_piola[i][j]))
            }),
            tangent: array_of(|i| array_of(|j| array_of(|k| array_of(|l| component(i, j, k, l))))),
        })
    }
}

impl Hyperelastic for PlaneStress {
    fn dimension(&self) -> usize {
        self.dimension
    }

    fn is_path_dependent(&self) -> bool {
        self.law.is_path_dependent()
    }

    fn response(&self, f: &DeformationGradient) -> Result<Response, MaterialError> {
        let Settled {
            response,
            condensed,
        } = self.found(f)?;
        let is_within = |index: usize| self.is_within(index);
        Response {
            deformation: response.deformation,
            energy: response.energy,
            first_piola: Matrix3::from_fn(|i, j| match is_within(i) && is_within(j) {
                true => condensed.slope[3 * i + j],
                false => 0.0,
            }),
            tangent: self.tangent(&condensed),
        }
        .finite()
    }

    fn unloading_tangent(
        &self,
        f: &DeformationGradient,
    ) -> Result<Option<FourthOrder>, MaterialError> {
        let response = self.found(f)?.response;
        let f = response.deformation;
        let Some(tangent) = self.law.unloading_tangent(&f)? else {
            return Ok(None);
        };
        let condensed = self.condensed(&Response {
            tangent,
            ..response
        });
        let condensed = condensed.ok_or(MaterialError::NotFinite {
            jacobian: f.jacobian(),
        })?;
        Ok(Some(self.tangent(&condensed)))
    }

    fn enclosure(&self, f: &DeformationGradient<Interval>) -> ResponseEnclosure {
        self.enclosed(f).unwrap_or(ResponseEnclosure::ENTIRE)
    }
}

/// State with zero tractions across.
struct Settled {
    /// Response of the three-dimensional law at this state.
    response: Response,
    condensed: Condensed<f64>,
}

/// Reason why no root was found.
enum Unsettled {
    /// The law has no response during the iteration.
    Law(MaterialError),
    /// Newton's method diverges, or the energy has no minimum there.
    Lost,
}

impl From<MaterialError> for Unsettled {
    fn from(error: MaterialError) -> Self {
        Self::Law(error)
    }
}

/// Derivatives of an energy with respect to the nine components of `F`, after elimination of the components with vanishing derivative.
struct Condensed<R> {
    /// First derivatives with respect to the remaining components, including the missing Newton steps to second order.
    slope: [R; 9],
    /// Second derivatives with respect to the remaining components.
    stiffness: [[R; 9]; 9],
}

impl<R: Real> Condensed<R> {
    /// Gauss-Jordan elimination of some components; `None` if a pivot is not positive, so that the energy has no minimum.
    fn new(
        across: &[usize],
        slope: impl Fn(usize, usize) -> R,
        stiffness: impl Fn(usize, usize, usize, usize) -> R,
        is_positive: impl Fn(R) -> bool,
    ) -> Option<Self> {
        let mut slope: [R; 9] = array_of(|n| slope(n / 3, n % 3));
        let mut stiffness: [[R; 9]; 9] =
            array_of(|n| array_of(|m| stiffness(n / 3, n % 3, m / 3, m % 3)));
        for &p in across {
            let (row, own) = (stiffness[p], slope[p]);
            let pivot = row[p];
            if !is_positive(pivot) {
                return None;
            }
            for i in (0..9).filter(|i| *i != p) {
                let factor = stiffness[i][p];
                // Computing the product first preserves major symmetry to the last digit.
                for j in 0..9 {
                    stiffness[i][j] = stiffness[i][j] - factor * row[j] / pivot;
                }
                slope[i] = slope[i] - factor * own / pivot;
            }
        }
        Some(Self { slope, stiffness })
    }
}

impl Condensed<f64> {
    /// Newton step of an eliminated component.
    fn missing(&self, p: usize) -> f64 {
        -self.slope[p] / self.stiffness[p][p]
    }

    /// Largest Newton step relative to the smaller stretch across the sheet.
    fn step(&self, state: &[[f64; 3]; 3], across: &[usize]) -> f64 {
        let on_diagonal = across.iter().filter(|p| *p % 4 == 0);
        let stretch = on_diagonal.fold(f64::INFINITY, |least, p| least.min(state[p / 3][p % 3]));
        let missing = across.iter().map(|p| self.missing(*p).abs());
        // Maximum that propagates NaN.
        missing.fold(
            0.0,
            |largest, own| if own <= largest { largest } else { own },
        ) / stretch
    }

    fn move_across(&self, state: &mut [[f64; 3]; 3], across: &[usize]) {
        for p in across {
            state[p / 3][p % 3] += self.missing(*p);
        }
    }
}

/// Derivatives of the components of `F` along the path.
type Slope = [f64; 9];

/// Change of the components of `F` between two states.
fn chord(from: &[[f64; 3]; 3], to: &[[f64; 3]; 3]) -> Slope {
    array_of(|n| to[n / 3][n % 3] - from[n / 3][n % 3])
}

fn dot(a: &Slope, b: &Slope) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(a: &Slope) -> f64 {
    dot(a, a).sqrt()
}

/// Path from the reference configuration to a state, `R ((1 - t) 1 + t U)` within the dimensions.
struct Way {
    dimension: usize,
    rotation: [[f64; 2]; 2],
    end: [[f64; 3]; 3],
}

impl Way {
    fn to(f: &DeformationGradient, dimension: usize) -> Self {
        let end = *f.components();
        let rotation = match dimension {
            1 => [[1.0, 0.0], [0.0, 1.0]],
            _ => {
                // The rotation R of F = R U in the plane.
                let (cosine, sine) = (end[0][0] + end[1][1], end[1][0] - end[0][1]);
                let size = cosine.hypot(sine);
                let (cosine, sine) = (cosine / size, sine / size);
                [[cosine, -sine], [sine, cosine]]
            }
        };
        Self {
            dimension,
            rotation,
            end,
        }
    }

    /// Derivatives along the path that keep the tractions across zero.
    fn slope(&self, condensed: &Condensed<f64>, across: &[usize]) -> Slope {
        let mut slope = [0.0; 9];
        for (i, j) in (0..4).map(|n| (n / 2, n % 2)) {
            if i < self.dimension && j < self.dimension {
                slope[3 * i + j] = self.end[i][j] - self.rotation[i][j];
            }
        }
        let within = slope;
        for &p in across {
            slope[p] = -dot(&condensed.stiffness[p], &within) / condensed.stiffness[p][p];
        }
        slope
    }

    /// Reference state after a rotation.
    fn turned(&self, state: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
        let mut turned = *state;
        for (i, row) in self.rotation.iter().enumerate() {
            for (j, entry) in turned[i].iter_mut().enumerate() {
                *entry = row[0] * state[0][j] + row[1] * state[1][j];
            }
        }
        turned
    }

    /// State at `t`, with the given components across.
    fn at(&self, t: f64, across: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
        let mut state = *across;
        for i in 0..self.dimension {
            for j in 0..self.dimension {
                // The end point is exact.
                state[i][j] = if t == 1.0 {
                    self.end[i][j]
                } else {
                    (1.0 - t) * self.rotation[i][j] + t * self.end[i][j]
                };
            }
        }
        state
    }
}
