//! Elements with a mean dilatation, after Simo, Taylor and Pister, Comput. Methods Appl. Mech. Eng. 51 (1985) 177.

use crate::algebra::array_of;
use crate::kinematics::DeformationGradient;
use crate::lattice::Particle;
use crate::material::Hyperelastic;
use crate::method::MethodError;
use crate::real::Real;
use crate::scheme::lagrangian::{LagrangianPoint, Stressed, response, stressed};
use crate::scheme::response::{determinant, inverse};
use crate::scheme::{Interaction, Motion, PointResponse, StrainOperator};

/// Integration point of an element, or all points of an element with a mean dilatation.
pub(super) enum Integrated<'a, const D: usize> {
    Point(Stressed<'a, D>),
    Dilated(Dilated<'a, D>),
}

/// Element with the energy `sum_q V_q W(Fbar_q)`, `Fbar_q = (theta / J_q)^(1/D) F_q`, and the mean dilatation `theta = sum_q V_q J_q / sum_q V_q`.
///
/// `J_q` is the determinant in the dimensions of the mesh: stretches beyond it stay constant. With `tau = P Fbar^T` at `Fbar` the forces are
///
/// `f_a = -sum_q V_q [(theta / J_q)^(1/D) P_q b_qa + tr(tau_q) / D (theta_a / theta - F_q^-T b_qa)]`, `theta_a = sum_q V_q J_q F_q^-T b_qa / sum_q V_q`.
pub(super) struct Dilated<'a, const D: usize> {
    /// Integration points of the element, all with the same nodes.
    points: &'a [LagrangianPoint<D>],
    response: PointResponse<'a, D>,
}

/// Returns the integrals of elements in a homogeneous state: one for each point, or for each element of `points_of_mean` points with a mean dilatation.
pub(super) fn integrated<'a, const D: usize>(
    points: &'a [LagrangianPoint<D>],
    points_of_mean: Option<usize>,
    material: &'a dyn Hyperelastic,
    f: &DeformationGradient,
) -> Result<Vec<Integrated<'a, D>>, MethodError> {
    let Some(count) = points_of_mean else {
        let points = stressed(points, response(material, f)?);
        return Ok(points.into_iter().map(Integrated::Point).collect());
    };
    let response = response(material, f)?;
    let element = |points| Integrated::Dilated(Dilated { points, response });
    Ok(points.chunks(count).map(element).collect())
}

/// Adds the strains of elements with a mean dilatation.
pub(super) fn add_strains<const D: usize>(
    points: &[LagrangianPoint<D>],
    count: usize,
    strain: &mut StrainOperator<D>,
) {
    for element in points.chunks(count) {
        let own = |point: &LagrangianPoint<D>| (point.volume(), point.gradients().to_vec());
        let points: Vec<_> = element.iter().map(own).collect();
        strain.add_with_mean_dilatation(element[0].particles(), &points);
    }
}

impl<const D: usize> Interaction<D> for Integrated<'_, D> {
    fn particles(&self) -> &[Particle<D>] {
        match self {
            Self::Point(point) => point.particles(),
            Self::Dilated(element) => element.particles(),
        }
    }

    fn forces<R: Real>(&self, motion: Motion<'_, R, D>) -> Vec<[R; D]> {
        match self {
            Self::Point(point) => point.forces(motion),
            Self::Dilated(element) => element.forces(motion),
        }
    }
}

impl<const D: usize> Interaction<D> for Dilated<'_, D> {
    fn particles(&self) -> &[Particle<D>] {
        self.points[0].particles()
    }

    fn forces<R: Real>(&self, motion: Motion<'_, R, D>) -> Vec<[R; D]> {
        let zero = R::constant(0.0);
        let volume: f64 = self.points.iter().map(LagrangianPoint::volume).sum();
        let base = self.response.leading();
        let deformation = |point: &LagrangianPoint<D>| {
            let f = point.deformed(&base, motion.displacements);
            (f, determinant(&f))
        };
        let deformations: Vec<([[R; D]; D], R)> = self.points.iter().map(deformation).collect();
        let both = self.points.iter().zip(&deformations);
        let theta = both.fold(zero, |sum, (q, (_, j))| sum + *j * (q.volume() / volume));
        let mut forces = vec![[zero; D]; self.particles().len()];
        let mut pressures = zero;
        // Gradients of J at the points, `J F^-T b`, weighted with the volumes.
        let mut dilatations = forces.clone();
        for (point, (f, j)) in self.points.iter().zip(&deformations) {
            let stretch = (theta / *j).powf(1.0 / D as f64);
            let bar = array_of(|i| array_of(|m| f[i][m] * stretch));
            let stress = self.response.first_piola(&bar);
            let pairs = (0..D).flat_map(|i| (0..D).map(move |m| (i, m)));
            let trace = pairs.fold(zero, |sum, (i, m)| sum + stress[i][m] * bar[i][m]);
            let pressure = trace * (point.volume() / D as f64);
            pressures = pressures + pressure;
            let inverse = inverse(f);
            for (a, b) in point.gradients().iter().enumerate() {
                for i in 0..D {
                    let (mut force, mut spatial) = (zero, zero);
                    for m in 0..D {
                        force = force + stress[i][m] * (point.volume() * b[m]);
                        spatial = spatial + inverse[m][i] * b[m];
                    }
                    forces[a][i] = forces[a][i] - force * stretch + pressure * spatial;
                    dilatations[a][i] =
                        dilatations[a][i] + *j * spatial * (point.volume() / volume);
                }
            }
        }
        let pressure = pressures / theta;
        for (force, dilatation) in forces.iter_mut().zip(&dilatations) {
            *force = array_of(|i| force[i] - pressure * dilatation[i]);
        }
        forces
    }
}
