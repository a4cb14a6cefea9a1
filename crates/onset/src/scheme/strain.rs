//! What a discretization sees of a displacement.

use crate::lattice::Particle;
use nalgebra::SVector;

/// The strains that a discretization sees, and what its control of zero-energy modes sees besides: linear forms of the displacements
/// of a cell's surroundings. They are geometry alone. Forces and energy of the reference configuration are made of them, whatever the law,
/// and a displacement without any of them is a zero-energy mode.
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

/// What is seen at a place: forms of the displacements of the same particles.
#[derive(Clone, Debug, PartialEq)]
pub struct SeenPoint<const D: usize> {
    /// The particles.
    pub particles: Vec<Particle<D>>,
    /// The forms, each with a vector for each of the particles.
    pub forms: Vec<SeenForm<D>>,
}

/// A linear form of displacements `u_K`.
#[derive(Clone, Debug, PartialEq)]
pub enum SeenForm<const D: usize> {
    /// The symmetric part of `sum_K u_K (x) b_K`.
    Strain(Vec<SVector<f64, D>>),
    /// The number `sum_K u_K . b_K`.
    Control(Vec<SVector<f64, D>>),
}

impl<const D: usize> SeenForm<D> {
    /// `b_K`.
    pub fn vectors(&self) -> &[SVector<f64, D>] {
        match self {
            Self::Strain(vectors) | Self::Control(vectors) => vectors,
        }
    }
}

impl<const D: usize> StrainOperator<D> {
    /// Nothing seen.
    pub fn new() -> Self {
        Self { points: Vec::new() }
    }

    /// What is seen, of one cell.
    pub fn points(&self) -> &[SeenPoint<D>] {
        &self.points
    }

    /// Adds what is seen at a place.
    pub fn add(&mut self, particles: Vec<Particle<D>>, forms: Vec<SeenForm<D>>) {
        self.points.push(SeenPoint { particles, forms });
    }

    /// Adds the strain of a point with gradients `b_K`.
    pub fn add_strain(&mut self, particles: &[Particle<D>], gradients: Vec<SVector<f64, D>>) {
        self.add(particles.to_vec(), vec![SeenForm::Strain(gradients)]);
    }

    /// Adds the nonuniform part of the displacements of a point's particles, `u_J - u_0 - (sum_K u_K (x) b_K) X_J`: all of it, or
    /// what of it is along `X_J`. The point's own particle is the first.
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
