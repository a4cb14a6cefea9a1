//! Stability of the continuum: the acoustic tensor and strong ellipticity.
//!
//! A homogeneous state is strongly elliptic if every acoustic tensor `Q_ik(N) = A_iJkL N_J N_L` is positive definite (equation (28)). In one and two
//! dimensions the smallest eigenvalue over *all* directions is computed algebraically. In three dimensions it is found by a search, and a lower bound
//! shows how far it can be from the minimum. The sign of that eigenvalue, if it exceeds rounding, is its [`Ellipticity`].

mod planar;
pub(crate) mod spherical;

pub(crate) use planar::direction;

use crate::algebra::{Complex, Each, array_of, eigenvalues, eigenvector, moderate_unit};
use crate::kinematics::DeformationGradient;
use crate::material::{FourthOrder, Hyperelastic, MaterialError, PlaneTangent, Response, cofactor};
use nalgebra::{SMatrix, SVector};

/// Stiffness `T_iJkL` in `D` dimensions, which defines the acoustic tensors `Q_ik(N) = T_iJkL N_J N_L`.
///
/// It is the tangent of a material or the long-wave limit of a discretization. The latter need not have the major symmetry `T_iJkL = T_kLiJ`, and its
/// eigenvalues can be complex.
#[derive(Clone, Debug, PartialEq)]
pub struct Stiffness<const D: usize>(
    [[SMatrix<f64, D, D>; D]; D],
    /// Largest component before the separation, which determines the rounding error: terms that cancel in acoustic tensors, for example from a
    /// pressure, contribute to it.
    f64,
    /// Volumetric part `k m_iJ m_kL` with `m = cof F`, separated if it is much larger than all other parts.
    Option<(f64, SMatrix<f64, D, D>)>,
);

/// Smallest eigenvalue of the acoustic tensor over all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AcousticMinimum<const D: usize> {
    /// Eigenvalue with the smallest real part; units of the stiffness.
    pub eigenvalue: Complex,
    /// Unit direction `N` of the wave.
    pub direction: SVector<f64, D>,
    /// Unit polarization `g` of the wave.
    pub polarization: SVector<f64, D>,
    /// Lower bound of the real parts of all eigenvalues in all directions, which shows whether the minimum is global.
    ///
    /// In one and two dimensions it is the eigenvalue in closed form minus rounding. In three dimensions the bound is computed and is usually `1e-10` of
    /// the largest component below the eigenvalue. The gap is larger where the minimum is flat and no bound for all directions together is attained,
    /// or without major symmetry. Units of the stiffness.
    pub bound: f64,
    /// Eigenvalues smaller than this in magnitude can be rounding: [`ACOUSTIC_ROUNDING`] of the largest component of the stiffness. Units of the stiffness.
    pub rounding: f64,
    /// Waves with complex eigenvalues, from [`Stiffness::flutter`]; `None` if all eigenvalues are real.
    pub flutter: Option<AcousticFlutter<D>>,
}

/// Complex eigenvalue of an acoustic tensor: waves in its direction oscillate with growing amplitude.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AcousticFlutter<const D: usize> {
    /// Eigenvalue with positive imaginary part; units of the stiffness.
    pub eigenvalue: Complex,
    /// Unit direction `N` of the wave.
    pub direction: SVector<f64, D>,
}

/// Rounding error of an acoustic eigenvalue relative to the largest component of the stiffness, including the error of the law.
///
/// The tests compare it with sixty-digit arithmetic for random laws and constants.
pub const ACOUSTIC_ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Stiffness ratio of volume changes to all others; above this ratio the search for the softest wave treats the volumetric part separately.
const STIFF_RATIO: f64 = 1e8;
/// Reduced stiffness ratio of the volumetric part in that search.
const REDUCED_STIFFNESS_RATIO: f64 = 1e6;

/// Largest imaginary part of an acoustic eigenvalue that is a rounding error, as a fraction of the largest component; the error of a double
/// eigenvalue is the square root of the error of the stiffness.
const COMPLEX: f64 = 1.2e-7;

/// Sign of the smallest acoustic eigenvalue of a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Ellipticity {
    /// The eigenvalue is positive. With major symmetry all wave speeds are then real, and the state is strongly elliptic.
    Elliptic,
    /// The eigenvalue is zero to rounding, neither positive nor negative. A fluid, which has no shear stiffness, is an example.
    Undecided,
    /// The eigenvalue is negative. With major symmetry some plane waves grow.
    Lost,
}

impl Ellipticity {
    /// Classifies an eigenvalue, given its rounding error.
    pub fn of(eigenvalue: f64, rounding: f64) -> Self {
        if eigenvalue > rounding {
            Self::Elliptic
        } else if eigenvalue < -rounding {
            Self::Lost
        } else {
            Self::Undecided
        }
    }

    /// Returns true if the eigenvalue is positive.
    pub fn is_elliptic(self) -> bool {
        self == Self::Elliptic
    }

    /// Returns true if the eigenvalue is negative.
    pub fn is_lost(self) -> bool {
        self == Self::Lost
    }

    /// Name of the value in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Elliptic => "elliptic",
            Self::Undecided => "undecided",
            Self::Lost => "lost",
        }
    }
}

impl<const D: usize> AcousticMinimum<D> {
    /// Ellipticity of the state according to this eigenvalue.
    ///
    /// ```
    /// use onset::continuum::{Ellipticity, Stiffness};
    /// use onset::formula::Formula;
    /// use onset::kinematics::DeformationGradient;
    /// use onset::material::Hyperelastic;
    /// // A fluid: the eigenvalue of shear waves is zero, neither positive nor negative.
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

    /// Returns true if some plane waves grow: an eigenvalue is negative or complex.
    pub fn has_growing_waves(&self) -> bool {
        self.ellipticity().is_lost() || self.flutter.is_some()
    }

    /// Returns true if some plane waves grow by flutter and none by divergence.
    pub fn only_flutters(&self) -> bool {
        self.flutter.is_some() && !self.ellipticity().is_lost()
    }

    /// Direction of the waves that grow by flutter if no others grow, otherwise the direction of the smallest eigenvalue.
    pub fn critical_direction(&self) -> SVector<f64, D> {
        let flutter = self.flutter.filter(|_| self.only_flutters());
        flutter.map_or(self.direction, |flutter| flutter.direction)
    }

    /// Real part of the eigenvalue, or zero if it is below rounding ([`AcousticMinimum::ellipticity`]). Units of the stiffness.
    pub fn significant(&self) -> f64 {
        match self.ellipticity() {
            Ellipticity::Undecided if !self.eigenvalue.re.is_nan() => 0.0,
            _ => self.eigenvalue.re,
        }
    }

    /// Minimum of the stiffness multiplied by a factor.
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
    /// Creates a stiffness from its components `component(i, J, k, L)`. They are symmetrized in `J` and `L`, which does not change any acoustic
    /// tensor.
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

    /// Part of a tangent `A_iJkL` that acts within the first `D` dimensions: all of it in 3D, plane strain in 2D, uniaxial strain in 1D.
    pub fn from_tangent(tangent: &FourthOrder) -> Self {
        Self::from_fn(|i, j, k, l| tangent[(i, j, k, l)])
    }

    /// Stiffness of a material at a state.
    pub fn of(response: &Response) -> Self {
        Self::from_tangent(&response.tangent).with_volume(&response.deformation)
    }

    /// Separates the volumetric part if it exceeds all other parts by the factor [`STIFF_RATIO`].
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
        let is_stiff = stiffness * m.norm_squared() > STIFF_RATIO * rest.magnitude();
        Self(self.0, self.1, is_stiff.then_some((stiffness, m)))
    }

    /// Adds a part `k m_iJ m_kL` to the stiffness.
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

    /// Stiffness of a material at a state, computed only from the required part of its tangent.
    ///
    /// # Errors
    /// [`MaterialError`] if the tangent over- or underflows.
    pub fn at(material: &dyn Hyperelastic, f: &DeformationGradient) -> Result<Self, MaterialError> {
        if D != 2 {
            return Ok(Self::of(&material.response(f)?));
        }
        Ok(Self::of_plane(&material.plane_tangent(f)?).with_volume(f))
    }

    /// Stiffness of the in-plane tangent, in two dimensions.
    pub(crate) fn of_plane(tangent: &PlaneTangent) -> Self {
        Self::from_fn(|i, j, k, l| tangent[2 * i + j][2 * k + l])
    }

    /// Acoustic tensor `Q_ik(N) = T_iJkL N_J N_L`, equation (27). Shape `D x D`, units of the stiffness.
    pub fn acoustic_tensor(&self, direction: &SVector<f64, D>) -> SMatrix<f64, D, D> {
        let mut q = SMatrix::zeros();
        for j in 0..D {
            for l in 0..D {
                q += self.0[j][l] * (direction[j] * direction[l]);
            }
        }
        q
    }

    /// Stiffness whose acoustic tensor at `n` equals the acoustic tensor of `self` at `m n`.
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

    /// Returns the smallest eigenvalue over all directions, with direction and polarization.
    ///
    /// Without major symmetry, where eigenvalues can be complex, the real part is minimized. The result is exact (to rounding) in one and two
    /// dimensions. In three dimensions it is found by descents from several directions and compared with a lower bound for all directions,
    /// [`AcousticMinimum::bound`]. The bound uses null Lagrangians, which nearly always attain it, and otherwise branch and bound over the sphere.
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

    /// Stiffness whose acoustic tensors are the symmetric parts of the acoustic tensors of `self`, with equal quadratic forms `g . Q(N) g`. With major symmetry it is
    /// unchanged.
    pub fn symmetric_part(&self) -> Self {
        let symmetric = |block: SMatrix<f64, D, D>| (block + block.transpose()) * 0.5;
        Self(self.0.each(|row| row.each(symmetric)), self.1, self.2)
    }

    /// Complex acoustic eigenvalue with the largest imaginary part over all directions; `None` if none exceeds rounding, which is always the case
    /// with major symmetry.
    ///
    /// It is computed algebraically in two dimensions. In three dimensions the discriminant is minimized from several directions, so a narrow range
    /// of directions can be missed.
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
        // Imaginary parts do not exceed the antisymmetric part (Bendixson), whose entries are half of these differences.
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

    /// Smallest eigenvalue if it is below a level, otherwise some eigenvalue above the level. In three dimensions this is much cheaper than the
    /// minimum if nearly equal waves exist in many directions.
    pub(crate) fn minimum_below(&self, level: f64) -> AcousticMinimum<D> {
        if let Some((stiffness, m)) = &self.2 {
            // The softest wave preserves the volume up to the ratio of the other stiffnesses to the volumetric one. The reduced volumetric stiffness
            // does not change it and leaves all digits to the search.
            let rest = self.and_volume(-stiffness, m);
            let enough = REDUCED_STIFFNESS_RATIO * rest.magnitude() / m.norm_squared();
            let found = rest.and_volume(enough, m).minimum_below(level);
            let rounding = ACOUSTIC_ROUNDING * self.1;
            return AcousticMinimum {
                bound: found.bound.min(found.eigenvalue.re - rounding),
                rounding,
                ..found
            };
        }
        let scale = self.magnitude();
        if scale != 1.0 && scale.is_normal() {
            // Normalize, so that the products of the search neither over- nor underflow in any units.
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

    /// Like [`Stiffness::minimum`], without flutter. In two dimensions it is several times faster, by a descent from many directions and without a
    /// bound.
    pub(crate) fn smallest(&self) -> AcousticMinimum<D> {
        if D != 2 {
            return self.minimum_below(f64::INFINITY);
        }
        let unit = moderate_unit(self.magnitude());
        if unit != 1.0 {
            let minimum = self.divided(unit).smallest();
            return AcousticMinimum {
                eigenvalue: minimum.eigenvalue * unit,
                ..minimum
            };
        }
        let direction = planar::descended_direction(self);
        let (eigenvalue, polarization) = self.smallest_eigenpair(&direction);
        AcousticMinimum {
            eigenvalue,
            direction: oriented(direction),
            polarization,
            bound: f64::NEG_INFINITY,
            rounding: ACOUSTIC_ROUNDING * self.1,
            flutter: None,
        }
    }

    /// Largest component in magnitude.
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
            bound: eigenvalue.re - ACOUSTIC_ROUNDING * self.1,
            rounding: ACOUSTIC_ROUNDING * self.1,
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
            rounding: ACOUSTIC_ROUNDING * self.1,
            flutter: None,
        }
    }

    /// Ellipticity of the state by the smallest value of `g . Q(N) g` over all unit vectors `N` and `g`, equation (28).
    ///
    /// That value is an eigenvalue of the symmetric part of `Q`.
    pub fn strong_ellipticity(&self) -> Ellipticity {
        let symmetric = self.symmetric_part();
        symmetric.minimum_below(f64::INFINITY).ellipticity()
    }

    /// Returns true if the symmetric part of the acoustic tensor is positive definite in every direction, beyond rounding.
    pub fn is_strongly_elliptic(&self) -> bool {
        self.strong_ellipticity().is_elliptic()
    }

    /// Returns true if the stiffness has major symmetry to rounding. All acoustic eigenvalues are then real.
    pub fn has_major_symmetry(&self) -> bool {
        asymmetry(&self.0) <= COMPLEX * self.magnitude()
    }

    /// Smallest eigenvalue (by real part) in one direction, with its polarization.
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

    /// All eigenvalues in one direction, sorted by real part.
    fn eigenvalues(&self, direction: &SVector<f64, D>) -> [Complex; D] {
        let q = self.acoustic_tensor(direction);
        let noise = f64::EPSILON * q.amax();
        eigenvalues(&q.map(|entry| Complex::new(entry, 0.0)), noise)
    }

    /// Largest real part of an eigenvalue over all directions, which belongs to the fastest wave. Units of the stiffness.
    pub fn maximum_eigenvalue(&self) -> f64 {
        // The transformation Q -> -Q exchanges the largest and the smallest eigenvalue.
        let negative = Self(self.0.each(|row| row.each(|block| -block)), self.1, None);
        -negative.minimum_below(f64::INFINITY).eigenvalue.re
    }
}

/// Largest difference `|T_iJkL - T_kJiL|` of blocks: the deviation from major symmetry.
fn asymmetry<const D: usize>(blocks: &[[SMatrix<f64, D, D>; D]; D]) -> f64 {
    let differences = blocks
        .as_flattened()
        .iter()
        .map(|block| (block - block.transpose()).amax());
    differences.fold(0.0, f64::max)
}

/// Smallest acoustic eigenvalue of an in-plane tangent. Faster than [`Stiffness::minimum`] if the coordinate axes are mirror axes.
pub(crate) fn plane_minimum<const D: usize>(tangent: &PlaneTangent) -> AcousticMinimum<D> {
    planar::mirrored_minimum(tangent).unwrap_or_else(|| Stiffness::of_plane(tangent).minimum())
}

/// Orients a direction so that its first non-negligible component is positive; `N` and `-N` are equivalent.
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
