//! Strain operator of a discretization: the strains of a displacement of the particles.

use crate::lattice::Particle;
use nalgebra::SVector;

/// Strains at the quadrature points of a cell, and the quantities that a control of zero-energy modes resists, as linear forms of the displacements.
///
/// The forms depend only on the geometry. They determine the forces and the energy in the reference configuration for any law, and a displacement for
/// which all of them vanish is a zero-energy mode.
///
/// ```
/// use nalgebra::Vector1;
/// use onset::lattice::{LatticeKind, Crystal};
/// use onset::scheme::{Discretization, SeenForm};
/// use onset::scheme::sph::{TotalLagrangianChoices, TotalLagrangianSph};
/// let chain = Crystal::of_lattice(LatticeKind::Chain.lattice::<1>(1.0)?);
/// let sph = TotalLagrangianSph::new(chain, TotalLagrangianChoices { radius: 1.5, ..Default::default() })?;
/// // One particle a cell, which sees its gradient.
/// let strain = sph.strain()?;
/// let [point] = strain.points() else { panic!() };
/// assert!(matches!(point.forms[..], [SeenForm::Strain(_)]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StrainOperator<const D: usize> {
    points: Vec<SeenPoint<D>>,
}

/// Linear forms at a quadrature point, all of the displacements of the same particles.
#[derive(Clone, Debug, PartialEq)]
pub struct SeenPoint<const D: usize> {
    /// Particles whose displacements enter the forms.
    pub particles: Vec<Particle<D>>,
    /// Linear forms, each with a vector for every particle.
    pub forms: Vec<SeenForm<D>>,
}

/// Linear form of the displacements `u_K`.
#[derive(Clone, Debug, PartialEq)]
pub enum SeenForm<const D: usize> {
    /// Strain, the symmetric part of `sum_K u_K (x) b_K`.
    Strain(Vec<SVector<f64, D>>),
    /// Scalar `sum_K u_K . b_K` of a control.
    Control(Vec<SVector<f64, D>>),
}

impl<const D: usize> SeenForm<D> {
    /// Vectors `b_K` of the form.
    pub fn vectors(&self) -> &[SVector<f64, D>] {
        match self {
            Self::Strain(vectors) | Self::Control(vectors) => vectors,
        }
    }
}

impl<const D: usize> StrainOperator<D> {
    /// Builds an operator without forms.
    pub fn new() -> Self {
        Self { points: Vec::new() }
    }

    /// Quadrature points of one cell with their forms.
    pub fn points(&self) -> &[SeenPoint<D>] {
        &self.points
    }

    /// Adds the forms of a quadrature point.
    pub fn add(&mut self, particles: Vec<Particle<D>>, forms: Vec<SeenForm<D>>) {
        self.points.push(SeenPoint { particles, forms });
    }

    /// Adds the strain of a quadrature point with gradients `b_K`.
    pub fn add_strain(&mut self, particles: &[Particle<D>], gradients: Vec<SVector<f64, D>>) {
        self.add(particles.to_vec(), vec![SeenForm::Strain(gradients)]);
    }

    /// Adds the nonuniform part of the displacements of a point's particles, `u_J - u_0 - (sum_K u_K (x) b_K) X_J`, or its component along `X_J`. The
    /// particle of the point comes first.
    pub(crate) fn add_nonuniform(
        &mut self,
        particles: &[Particle<D>],
        gradients: &[SVector<f64, D>],
        vectors: &[SVector<f64, D>],
        only_along: bool,
    ) {
        let mut forms = Vec::new();
        for (j, x) in vectors.iter().enumerate().skip(1) {
            let of_particle = |(k, b): (usize, &SVector<f64, D>)| {
                f64::from(u8::from(k == j)) - f64::from(u8::from(k == 0)) - b.dot(x)
            };
            let shares: Vec<f64> = gradients.iter().enumerate().map(of_particle).collect();
            let mut along = |direction: SVector<f64, D>| {
                let vectors = shares.iter().map(|share| direction * *share).collect();
                forms.push(SeenForm::Control(vectors));
            };
            if only_along {
                along(x.normalize());
            } else {
                let unit = |i: usize| SVector::from_fn(|j, _| f64::from(u8::from(i == j)));
                (0..D).for_each(|i| along(unit(i)));
            }
        }
        self.add(particles.to_vec(), forms);
    }
}
