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

    /// Adds the strains of points with volumes and gradients at the same particles, with the mean of their dilatations, `sym grad u + (mean div u - div u) / D`,
    /// as scalars whose squares add up to the squared norm.
    pub(crate) fn add_with_mean_dilatation(
        &mut self,
        particles: &[Particle<D>],
        points: &[(f64, Vec<SVector<f64, D>>)],
    ) {
        let whole: f64 = points.iter().map(|(volume, _)| volume).sum();
        let mean = |a: usize| -> SVector<f64, D> {
            let own = points
                .iter()
                .map(|(volume, gradients)| gradients[a] * *volume);
            own.sum::<SVector<f64, D>>() / whole
        };
        for (volume, gradients) in points {
            let share = (volume / whole).sqrt();
            let component = |i: usize, j: usize| {
                let of_node = |(a, b): (usize, &SVector<f64, D>)| match i == j {
                    true => {
                        let unit = SVector::from_fn(|m, _| if m == i { b[i] } else { 0.0 });
                        (unit + (mean(a) - b) / D as f64) * share
                    }
                    false => {
                        let half = 0.5_f64.sqrt() * share;
                        SVector::from_fn(|m, _| match m {
                            _ if m == i => half * b[j],
                            _ if m == j => half * b[i],
                            _ => 0.0,
                        })
                    }
                };
                SeenForm::Control(gradients.iter().enumerate().map(of_node).collect())
            };
            let pairs = (0..D).flat_map(|i| (i..D).map(move |j| (i, j)));
            let forms = pairs.map(|(i, j)| component(i, j)).collect();
            self.add(particles.to_vec(), forms);
        }
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
