//! Stability of the continuum: the acoustic tensor and strong ellipticity.
//!
//! A homogeneous state is strongly elliptic when every acoustic tensor
//! `Q_ik(N) = A_iJkL N_J N_L` is positive definite (equation (28)). In one and two dimensions the
//! smallest eigenvalue over *all* directions is found algebraically; in three it is searched for, with a lower bound that
//! says how sure the result is. What the sign of that eigenvalue says, where rounding leaves it a sign, is [`Ellipticity`].

mod planar;
pub(crate) mod spherical;

pub(crate) use planar::direction;

use crate::algebra::{Complex, Each, array_of, eigenvalues, eigenvector, moderate_unit};
use crate::kinematics::DeformationGradient;
use crate::material::{FourthOrder, Hyperelastic, MaterialError, PlaneTangent, Response, cofactor};
use nalgebra::{SMatrix, SVector};

/// A stiffness `T_iJkL` in `D` dimensions, the quadratic form in the direction `N` of an acoustic
/// tensor `Q_ik(N) = T_iJkL N_J N_L`.
///
/// It is the tangent of a material, or the long-wave limit of a discretization. The latter need
/// not have the major symmetry `T_iJkL = T_kLiJ`; eigenvalues can then be complex.
#[derive(Clone, Debug, PartialEq)]
pub struct Stiffness<const D: usize>(
    [[SMatrix<f64, D, D>; D]; D],
    /// The largest component as given, the scale of its rounding: parts that cancel in acoustic tensors, such as those of a pressure,
    /// leave theirs.
    f64,
    /// A part `k m_iJ m_kL` that is larger than all others by far: the stiffness against changes of volume, with `m = cof F`.
    Option<(f64, SMatrix<f64, D, D>)>,
);

/// The smallest eigenvalue of the acoustic tensor over all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AcousticMinimum<const D: usize> {
    /// The eigenvalue with the smallest real part; units of the stiffness.
    pub eigenvalue: Complex,
    /// The unit direction `N` in which it occurs.
    pub direction: SVector<f64, D>,
    /// The unit polarization `g`.
    pub polarization: SVector<f64, D>,
    /// No direction has an eigenvalue with a smaller real part than this lower bound: how sure the minimum is the global
    /// one. In one and two dimensions the eigenvalue less rounding, by algebra. In three dimensions the bound is computed, and usually
    /// `1e-10` of the largest component below the eigenvalue; further where the minimum is flat and no bound at once is
    /// attained, or without major symmetry. Units of the stiffness.
    pub bound: f64,
    /// Eigenvalues nearer to zero than this can be rounding: [`ROUNDING`] of the largest component of the stiffness. Units of the
    /// stiffness.
    pub rounding: f64,
    /// Waves whose eigenvalues are complex; see [`Stiffness::flutter`].
    pub flutter: Option<AcousticFlutter<D>>,
}

/// A complex eigenvalue of an acoustic tensor: waves in its direction oscillate and grow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AcousticFlutter<const D: usize> {
    /// The eigenvalue, its imaginary part positive; units of the stiffness.
    pub eigenvalue: Complex,
    /// The unit direction `N`.
    pub direction: SVector<f64, D>,
}

/// How much of the largest component of a stiffness can be rounding: of the law that computed it, and of the eigenvalue found.
///
/// Held against arithmetic with sixty digits in the tests, for laws and constants at random.
pub const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// A stiffness against changes of volume that is this many times the others is told apart in the search for the softest wave.
const STIFF: f64 = 1e8;
/// How many times the others it is in that search.
const ENOUGH: f64 = 1e6;

/// Imaginary parts of acoustic eigenvalues below this part of the largest component are rounding: those of a double eigenvalue are
/// as uncertain as the square root of what it is computed from.
const COMPLEX: f64 = 1.2e-7;

/// What the smallest acoustic eigenvalue says of a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Ellipticity {
    /// It is positive. With major symmetry all wave speeds are then real, and the state is strongly elliptic.
    Elliptic,
    /// It is zero to rounding: not positive as far as the numbers tell, nor negative. So it is for a fluid, which bears no shear.
    Undecided,
    /// It is negative. With major symmetry some plane waves grow.
    Lost,
}

impl Ellipticity {
    /// By an eigenvalue and how much of it can be rounding.
    pub fn of(eigenvalue: f64, rounding: f64) -> Self {
        if eigenvalue > rounding {
            Self::Elliptic
        } else if eigenvalue < -rounding {
            Self::Lost
        } else {
            Self::Undecided
        }
    }

    /// Whether it is positive.
    pub fn is_elliptic(self) -> bool {
        self == Self::Elliptic
    }

    /// Whether it is negative.
    pub fn is_lost(self) -> bool {
        self == Self::Lost
    }

    /// The word used in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Elliptic => "elliptic",
            Self::Undecided => "undecided",
            Self::Lost => "lost",
        }
    }
}

impl<const D: usize> AcousticMinimum<D> {
    /// What it says of the state.
    ///
    /// ```
    /// use onset::continuum::{Ellipticity, Stiffness};
    /// use onset::formula::Formula;
    /// use onset::kinematics::DeformationGradient;
    /// use onset::material::Hyperelastic;
    /// // A fluid: shear waves cost nothing, which is not positive, and not negative.
    /// let fluid = Formula::parse("50*(J - 1)^2")?.with(&[])?;
    /// let f = DeformationGradient::from_stretches([1.2, 0.9, 1.0])?;
    /// let minimum = Stiffness::<2>::of(&fluid.response(&f)?).minimum();
    /// assert_eq!(minimum.ellipticity(), Ellipticity::Undecided);
    /// assert_eq!(minimum.significant(), 0.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn ellipticity(&self) -> Ellipticity {
        Ellipticity::of(self.eigenvalue.re, self.rounding)
    }

    /// Whether some plane waves grow: those of an eigenvalue below zero, or of a complex one.
    pub fn has_growing_waves(&self) -> bool {
        self.ellipticity().is_lost() || self.flutter.is_some()
    }

    /// Whether plane waves grow by flutter, and no others do.
    pub fn only_flutters(&self) -> bool {
        self.flutter.is_some() && !self.ellipticity().is_lost()
    }

    /// The direction of the waves that grow by flutter, where no others do; otherwise that of the smallest eigenvalue.
    pub fn critical_direction(&self) -> SVector<f64, D> {
        let flutter = self.flutter.filter(|_| self.only_flutters());
        flutter.map_or(self.direction, |flutter| flutter.direction)
    }

    /// The real part of the eigenvalue with the sign that [`AcousticMinimum::ellipticity`] says: zero where rounding leaves it none.
    /// Units of the stiffness.
    pub fn significant(&self) -> f64 {
        match self.ellipticity() {
            Ellipticity::Undecided if !self.eigenvalue.re.is_nan() => 0.0,
            _ => self.eigenvalue.re,
        }
    }

    /// The same of a stiffness that is larger by a factor.
    fn scaled(self, scale: f64) -> Self {
        Self {
            eigenvalue: self.eigenvalue * scale,
            bound: self.bound * scale,
            rounding: self.rounding * scale,
            flutter: self.flutter.map(|flutter| AcousticFlutter {
                eigenvalue: flutter.eigenvalue * scale,
                ..flutter
            }),
            ..self
        }
    }
}

impl<const D: usize> Stiffness<D> {
    /// The stiffness with components `component(i, J, k, L)`, made symmetric in `J` and `L`, which
    /// leaves every acoustic tensor as it is.
    pub fn from_fn(component: impl Fn(usize, usize, usize, usize) -> f64) -> Self {
        let mut largest = 0.0_f64;
        let blocks = array_of(|j| {
            array_of(|l| {
                SMatrix::from_fn(|i, k| {
                    let [own, other] = [component(i, j, k, l), component(i, l, k, j)];
                    largest = largest.max(own.abs()).max(other.abs());
                    0.5 * (own + other)
                })
            })
        });
        Self(blocks, largest, None)
    }

    /// The part of a tangent `A_iJkL` that acts within the first `D` dimensions: all of it in 3D,
    /// plane strain in 2D, uniaxial strain in 1D.
    pub fn from_tangent(tangent: &FourthOrder) -> Self {
        Self::from_fn(|i, j, k, l| tangent[(i, j, k, l)])
    }

    /// The stiffness of a material at a state.
    pub fn of(response: &Response) -> Self {
        Self::from_tangent(&response.tangent).with_volume(&response.deformation)
    }

    /// The same with what is known of the state: where the stiffness against changes of volume is larger than all others by [`STIFF`], it is told apart.
    fn with_volume(self, f: &DeformationGradient) -> Self {
        if D < 2 {
            return self;
        }
        let cofactor = cofactor(&f.matrix());
        let m = SMatrix::<f64, D, D>::from_fn(|i, j| cofactor[(i, j)]);
        let along = |j: usize| {
            let c = m.column(j).into_owned();
            let q = &self.0[j][j];
            c.dot(&(q * c)) / c.norm_squared().powi(2)
        };
        let stiffness = (0..D).map(along).fold(f64::INFINITY, f64::min);
        let rest = self.and_volume(-stiffness, &m);
        let is_stiff = stiffness * m.norm_squared() > STIFF * rest.magnitude();
        Self(self.0, self.1, is_stiff.then_some((stiffness, m)))
    }

    /// The same with a part `k m_iJ m_kL` more.
    fn and_volume(&self, stiffness: f64, m: &SMatrix<f64, D, D>) -> Self {
        let blocks = array_of(|j| {
            array_of(|l| {
                let [own, other] = [m.column(j), m.column(l)];
                let part = own * other.transpose() + other * own.transpose();
                self.0[j][l] + part * (0.5 * stiffness)
            })
        });
        Self(blocks, self.1, None)
    }

    /// The stiffness of a material at a state, from no more of its tangent than the dimensions need.
    ///
    /// # Errors
    /// [`MaterialError`] when the tangent over- or underflows.
    pub fn at(material: &dyn Hyperelastic, f: &DeformationGradient) -> Result<Self, MaterialError> {
        if D != 2 {
            return Ok(Self::of(&material.response(f)?));
        }
        Ok(Self::of_plane(&material.plane_tangent(f)?).with_volume(f))
    }

    /// The stiffness with the tangent within the plane, in two dimensions.
    pub(crate) fn of_plane(tangent: &PlaneTangent) -> Self {
        Self::from_fn(|i, j, k, l| tangent[2 * i + j][2 * k + l])
    }

    /// The acoustic tensor `Q_ik(N) = T_iJkL N_J N_L`, equation (27). Shape `D x D`, units of the stiffness.
    pub fn acoustic_tensor(&self, direction: &SVector<f64, D>) -> SMatrix<f64, D, D> {
        let mut q = SMatrix::zeros();
        for j in 0..D {
            for l in 0..D {
                q += self.0[j][l] * (direction[j] * direction[l]);
            }
        }
        q
    }

    /// The stiffness whose acoustic tensor at `n` is this one's at `m n`.
    pub fn with_directions_mapped(&self, m: &SMatrix<f64, D, D>) -> Self {
        let block = |a: usize, b: usize| {
            let mut sum = SMatrix::zeros();
            for j in 0..D {
                for l in 0..D {
                    sum += self.0[j][l] * (m[(j, a)] * m[(l, b)]);
                }
            }
            sum
        };
        let blocks = array_of(|a| array_of(|b| block(a, b)));
        let volume = self.2.map(|(stiffness, own)| (stiffness, own * m));
        Self(blocks, self.1 * m.norm_squared(), volume)
    }

    /// The smallest eigenvalue over all directions, with direction and polarization.
    ///
    /// By the real part, where there is no major symmetry and eigenvalues can be complex. Exact (to rounding) in one and two
    /// dimensions. In three dimensions found by going down from several directions, and compared with a lower bound of
    /// all directions, [`AcousticMinimum::bound`]: by null Lagrangians, which is nearly always attained, or else by branch
    /// and bound over the sphere.
    ///
    /// ```
    /// use onset::continuum::Stiffness;
    /// use onset::kinematics::DeformationGradient;
    /// use onset::material::{Hyperelastic, ModifiedMooneyRivlin};
    /// // In compression the softest wave of this law is a shear wave of stiffness c1 + c2.
    /// let f = DeformationGradient::from_stretches([0.8, 0.7, 1.0])?;
    /// let stiffness = Stiffness::<2>::of(&ModifiedMooneyRivlin::default().response(&f)?);
    /// assert!((stiffness.minimum().eigenvalue.re - 0.13572).abs() < 1e-12);
    /// assert!(stiffness.is_strongly_elliptic());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn minimum(&self) -> AcousticMinimum<D> {
        AcousticMinimum {
            flutter: self.flutter(),
            ..self.minimum_below(f64::INFINITY)
        }
    }

    /// The stiffness whose acoustic tensors are the symmetric parts of these, with the same quadratic forms `g . Q(N) g`: itself, where there is
    /// major symmetry.
    pub fn symmetric_part(&self) -> Self {
        let symmetric = |block: SMatrix<f64, D, D>| (block + block.transpose()) * 0.5;
        Self(self.0.each(|row| row.each(symmetric)), self.1, self.2)
    }

    /// The complex acoustic eigenvalue with the largest imaginary part over all directions, beyond rounding. There is none with major symmetry.
    ///
    /// By algebra in two dimensions; in three found by going down the discriminant from several directions, so that a narrow range of
    /// directions can be missed.
    ///
    /// ```
    /// use nalgebra::Vector2;
    /// use onset::continuum::Stiffness;
    /// // Q(N) = (N.N) (1, -1; 1, 1): eigenvalues 1 +- i in all directions.
    /// let q = [[1.0, -1.0], [1.0, 1.0]];
    /// let stiffness = Stiffness::<2>::from_fn(|i, j, k, l| if j == l { q[i][k] } else { 0.0 });
    /// let flutter = stiffness.flutter().expect("complex eigenvalues");
    /// assert!((flutter.eigenvalue.re - 1.0).abs() + (flutter.eigenvalue.im - 1.0).abs() < 1e-12);
    /// ```
    pub fn flutter(&self) -> Option<AcousticFlutter<D>> {
        let scale = self.magnitude();
        // Imaginary parts are no larger than the antisymmetric part (Bendixson), of which the entries are half of these differences.
        let largest = 0.5 * asymmetry(&self.0) * (D * D) as f64;
        if D == 1 || !scale.is_normal() || largest <= COMPLEX * scale {
            return None;
        }
        let unit = self.divided(scale);
        let direction = match D {
            2 => planar::fluttering_direction(&unit),
            _ => {
                let axes = spherical::fluttering_direction(&unit.0);
                SVector::from_fn(|i, _| axes[i])
            }
        };
        let values = unit.eigenvalues(&direction).into_iter();
        let complex = values.max_by(|a, b| a.im.total_cmp(&b.im))?;
        (complex.im > COMPLEX).then(|| AcousticFlutter {
            eigenvalue: complex * scale,
            direction: oriented(direction),
        })
    }

    /// The smallest eigenvalue where it is below a level; elsewhere one above the level that a descent finds. In three dimensions
    /// that is much cheaper where nearly the same wave goes in many directions.
    pub(crate) fn minimum_below(&self, level: f64) -> AcousticMinimum<D> {
        if let Some((stiffness, m)) = &self.2 {
            // The softest wave keeps the volume but for what the others' stiffness is of that one: as much stiffness does as leaves its search all digits.
            let rest = self.and_volume(-stiffness, m);
            let enough = ENOUGH * rest.magnitude() / m.norm_squared();
            let found = rest.and_volume(enough, m).minimum_below(level);
            let rounding = ROUNDING * self.1;
            return AcousticMinimum {
                bound: found.bound.min(found.eigenvalue.re - rounding),
                rounding,
                ..found
            };
        }
        let scale = self.magnitude();
        if scale != 1.0 && scale.is_normal() {
            // The products of the search must neither over- nor underflow, whatever the units.
            let unit = self.divided(scale);
            return unit.minimum_of_unit(level / scale).scaled(scale);
        }
        self.minimum_of_unit(level)
    }

    fn divided(&self, scale: f64) -> Self {
        let blocks = self.0.each(|row| row.each(|block| block / scale));
        let volume = self.2.map(|(stiffness, own)| (stiffness / scale, own));
        Self(blocks, self.1 / scale, volume)
    }

    /// The same by a descent from the lowest of many directions: several times faster in two and three dimensions, for
    /// stiffnesses that need no certainty, and without a bound.
    pub(crate) fn minimum_by_descent(&self) -> AcousticMinimum<D> {
        let scale = self.magnitude();
        let unit = moderate_unit(scale);
        if unit != 1.0 {
            let minimum = self.divided(unit).minimum_by_descent();
            return AcousticMinimum {
                eigenvalue: minimum.eigenvalue * unit,
                ..minimum
            };
        }
        let direction = match D {
            2 => planar::descended_direction(self),
            3 if scale.is_normal() => {
                let axes = spherical::descended_direction(&self.divided(scale).0);
                SVector::from_fn(|i, _| axes[i])
            }
            _ => return self.minimum(),
        };
        let (eigenvalue, polarization) = self.smallest_eigenpair(&direction);
        AcousticMinimum {
            eigenvalue,
            direction: oriented(direction),
            polarization,
            bound: f64::NEG_INFINITY,
            rounding: ROUNDING * self.1,
            flutter: None,
        }
    }

    /// The largest component.
    fn magnitude(&self) -> f64 {
        self.0
            .iter()
            .flatten()
            .map(|block| block.amax())
            .fold(0.0, f64::max)
    }

    fn minimum_of_unit(&self, below: f64) -> AcousticMinimum<D> {
        let direction = match D {
            1 => SVector::repeat(1.0),
            2 => planar::minimizing_direction(self),
            _ => return self.minimum_on_sphere(below),
        };
        let (eigenvalue, polarization) = self.smallest_eigenpair(&direction);
        AcousticMinimum {
            eigenvalue,
            direction: oriented(direction),
            polarization,
            bound: eigenvalue.re - ROUNDING * self.1,
            rounding: ROUNDING * self.1,
            flutter: None,
        }
    }

    fn minimum_on_sphere(&self, below: f64) -> AcousticMinimum<D> {
        let found = spherical::minimum(&self.0, below);
        let vector = |axes: [f64; 3]| SVector::from_fn(|i, _| axes[i]);
        let direction = vector(found.direction);
        let (eigenvalue, polarization) = match found.eigenpair {
            Some((eigenvalue, polarization)) => (
                Complex::new(eigenvalue, 0.0),
                oriented(vector(polarization)),
            ),
            None => self.smallest_eigenpair(&direction),
        };
        AcousticMinimum {
            eigenvalue,
            direction: oriented(direction),
            polarization,
            bound: found.bound,
            rounding: ROUNDING * self.1,
            flutter: None,
        }
    }

    /// Whether the state is strongly elliptic: what the smallest value of `g . Q(N) g` over all unit vectors `N` and `g` says, equation (28).
    /// That value is an eigenvalue of the symmetric part of `Q`.
    pub fn strong_ellipticity(&self) -> Ellipticity {
        let symmetric = self.symmetric_part();
        symmetric.minimum_below(f64::INFINITY).ellipticity()
    }

    /// Whether the symmetric part of the acoustic tensor is positive definite in every direction, beyond rounding.
    pub fn is_strongly_elliptic(&self) -> bool {
        self.strong_ellipticity().is_elliptic()
    }

    /// Whether there is major symmetry, rounding apart: then all acoustic eigenvalues are real.
    pub fn has_major_symmetry(&self) -> bool {
        asymmetry(&self.0) <= COMPLEX * self.magnitude()
    }

    /// The smallest eigenvalue (by real part) in one direction, and its polarization.
    fn smallest_eigenpair(&self, direction: &SVector<f64, D>) -> (Complex, SVector<f64, D>) {
        let q = self
            .acoustic_tensor(direction)
            .map(|entry| Complex::new(entry, 0.0));
        let eigenvalue = self.eigenvalues(direction)[0];
        let vector = eigenvector(&q, eigenvalue).map(|component| component.re);
        let length = vector.norm();
        (
            eigenvalue,
            if length > 0.0 {
                vector / length
            } else {
                vector
            },
        )
    }

    /// All eigenvalues in one direction, by increasing real part.
    fn eigenvalues(&self, direction: &SVector<f64, D>) -> [Complex; D] {
        let q = self.acoustic_tensor(direction);
        let noise = f64::EPSILON * q.amax();
        eigenvalues(&q.map(|entry| Complex::new(entry, 0.0)), noise)
    }

    /// The largest real part of an eigenvalue over all directions: that of the fastest wave. Units of the stiffness.
    pub fn maximum_eigenvalue(&self) -> f64 {
        // Q -> -Q turns the largest eigenvalue into the smallest.
        let negative = Self(self.0.each(|row| row.each(|block| -block)), self.1, None);
        -negative.minimum_below(f64::INFINITY).eigenvalue.re
    }
}

/// The largest difference `|T_iJkL - T_kJiL|` of blocks: how far a stiffness is from major symmetry.
fn asymmetry<const D: usize>(blocks: &[[SMatrix<f64, D, D>; D]; D]) -> f64 {
    let differences = blocks
        .as_flattened()
        .iter()
        .map(|block| (block - block.transpose()).amax());
    differences.fold(0.0, f64::max)
}

/// The smallest acoustic eigenvalue of a tangent within the plane: what [`Stiffness::minimum`] says, faster where the coordinate axes are its
/// mirror axes.
pub(crate) fn plane_minimum<const D: usize>(tangent: &PlaneTangent) -> AcousticMinimum<D> {
    planar::mirrored_minimum(tangent).unwrap_or_else(|| Stiffness::of_plane(tangent).minimum())
}

/// Of `N` and `-N`, which are the same direction, the one whose first component that is not
/// negligible is positive.
fn oriented<const D: usize>(direction: SVector<f64, D>) -> SVector<f64, D> {
    let cleaned = direction.map(|component| {
        if component.abs() < 1e-15 {
            0.0
        } else {
            component
        }
    });
    match cleaned.iter().find(|component| **component != 0.0) {
        Some(first) if *first < 0.0 => cleaned.map(|component| 0.0 - component),
        _ => cleaned,
    }
}
