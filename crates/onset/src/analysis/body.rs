//! A discretization and a material in `D` dimensions behind the interface without `D`.

use super::in_space::InSpace;
use super::{
    Analysis, FiniteBodyGround, FiniteBodyOscillations, PatchParticle, PlaneWaves, Relaxing,
    SteppedWaves,
};
use crate::algebra::{Complex, array_of, eigenvalues};
use crate::bloch::{RelaxingWaves, SpectrumSummary, ZoneSearch};
use crate::certificate::{Certificate, Certifier, Foundation};
use crate::continuum::{AcousticMinimum, Stiffness};
use crate::kinematics::{DeformationGradient, DeformationPath};
use crate::lattice::{BravaisLattice, LatticeKind};
use crate::material::{Hyperelastic, MaterialError, Viscoelastic};
use crate::measures::{
    DispersionError, Fidelity, Load, OnsetPair, SpuriousModes, StateWindow, dispersion_errors,
    fidelity, long_wave_error, onset, spurious_modes,
};
use crate::method::{Method, MethodError};
use crate::motion::{
    BodyError, BodyMotion, BodyParticles, Contact, Grip, PatchMotion, oscillation_of_free_blocks,
    with_body, with_motion,
};
use crate::scheme::{Discretization, FiniteBodies, PeriodicPatch};
use crate::time_step::{Integrator, Oscillation, TransferredWaves, WaveParts};
use crate::verdict::{
    Assessment, Ground, Judged, PathError, PathScan, Probe, StateWaves, Survey, SurveyedState,
    WeakestMode, scan_discretization,
};
use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use std::sync::{Arc, OnceLock};

/// Eigenvalues of the acoustic tensor in the given directions, sorted in increasing order.
pub(super) fn acoustic_eigenvalues<const D: usize>(
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
    directions: &[SVector<f64, 3>],
) -> Result<Vec<Vec<f64>>, MaterialError> {
    let stiffness = Stiffness::<D>::at(material, f)?;
    let of = |direction: &SVector<f64, 3>| {
        let tensor = stiffness.acoustic_tensor(&vector::<D>(direction.as_slice()));
        let complex = eigenvalues(&tensor.map(|entry| Complex::new(entry, 0.0)), 0.0);
        let mut real: Vec<f64> = complex.iter().map(|value| value.re).collect();
        real.sort_by(f64::total_cmp);
        real
    };
    Ok(directions.iter().map(of).collect())
}

/// Smallest acoustic eigenvalue of a material.
pub(super) fn acoustic_minimum<const D: usize>(
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
) -> Result<AcousticMinimum<3>, MaterialError> {
    let response = material.response(f)?;
    Ok(Stiffness::<D>::of(&response).minimum().in_3d())
}

/// Discretization and material, with the data shared by their states computed on first use.
pub(super) struct Body<const D: usize> {
    discretization: Box<dyn Discretization<D>>,
    material: Arc<dyn Hyperelastic>,
    ground: OnceLock<Result<Arc<Ground<D>>, MethodError>>,
    foundation: OnceLock<Result<Foundation<D>, MethodError>>,
}

/// Waves of a state and of the continuum.
struct Waves<const D: usize> {
    waves: StateWaves<D>,
    stiffness: Stiffness<D>,
    density: f64,
    is_periodic: bool,
    /// Map from the wave vectors used by `waves` to reference wave vectors.
    to_reference: SMatrix<f64, D, D>,
}

impl<const D: usize> Body<D> {
    pub(super) fn new(
        discretization: Box<dyn Discretization<D>>,
        material: Arc<dyn Hyperelastic>,
    ) -> Self {
        Self {
            discretization,
            material,
            ground: OnceLock::new(),
            foundation: OnceLock::new(),
        }
    }

    fn survey(&self) -> Result<Survey<'_, D>, MethodError> {
        let (discretization, material) = (&*self.discretization, &*self.material);
        let new = || Survey::new(discretization, material).map(|survey| survey.ground());
        let ground = self.ground.get_or_init(new).clone()?;
        Ok(Survey::on(ground, discretization, material))
    }

    fn certifier(&self, tolerance: f64) -> Result<Certifier<'_, D>, MethodError> {
        let (discretization, material) = (&*self.discretization, &*self.material);
        let new = || {
            let certifier = Certifier::new(discretization, material, tolerance);
            certifier.map(|certifier| certifier.foundation())
        };
        let foundation = self.foundation.get_or_init(new).clone()?;
        Ok(Certifier::founded(
            foundation,
            discretization,
            material,
            tolerance,
        ))
    }
}

/// Converts components to a vector of `D` dimensions, truncated or padded with zeros.
fn vector<const D: usize>(components: &[f64]) -> SVector<f64, D> {
    SVector::from_fn(|i, _| components.get(i).copied().unwrap_or(0.0))
}

impl<const D: usize> Analysis for Body<D> {
    fn dimension(&self) -> usize {
        D
    }

    fn spacing(&self) -> f64 {
        self.discretization.crystal().spacing()
    }

    fn sites(&self) -> usize {
        self.discretization.crystal().sites().len()
    }

    fn neighbors(&self) -> f64 {
        self.discretization.neighbors()
    }

    fn is_regular(&self) -> bool {
        self.discretization.is_regular()
    }

    fn speed_squared(&self) -> Result<f64, MethodError> {
        Ok(self.survey()?.speed_squared())
    }

    fn for_many_states(self: Box<Self>) -> Result<Box<dyn Analysis>, MethodError> {
        let ground = self.survey()?.for_many_states()?.ground();
        Ok(Box::new(Self {
            ground: OnceLock::from(Ok(ground)),
            ..*self
        }))
    }

    fn assess(&self, f: &DeformationGradient) -> Result<Assessment<3>, MethodError> {
        Ok(self.survey()?.assess(f)?.in_3d())
    }

    fn judge(
        &self,
        f: &DeformationGradient,
        beside: Option<&[SVector<f64, 3>]>,
    ) -> Result<Judged<3>, MethodError> {
        let own = |k: &SVector<f64, 3>| SVector::from_fn(|i, _| k[i]);
        let beside: Option<Vec<SVector<f64, D>>> =
            beside.map(|waves| waves.iter().map(own).collect());
        let judged = self.survey()?.judge_beside(f, beside.as_deref())?;
        Ok(Judged {
            verdict: judged.verdict,
            stability: judged.stability,
            witness: judged.witness.map(|k| k.in_3d()),
        })
    }

    fn states(&self, states: &[DeformationGradient]) -> Vec<Result<SurveyedState<3>, MethodError>> {
        match self.survey() {
            Ok(survey) => {
                let found = survey.states(states).into_iter();
                found.map(|state| Ok(state?.in_3d())).collect()
            }
            Err(error) => states.iter().map(|_| Err(error.clone())).collect(),
        }
    }

    fn sampled_states(
        &self,
        states: &[DeformationGradient],
        count: usize,
    ) -> Vec<Result<SurveyedState<3>, MethodError>> {
        let sampled = |f: &DeformationGradient| Ok(self.survey()?.sampled(f, count)?.in_3d());
        states.iter().map(sampled).collect()
    }

    fn probe(&self, f: &DeformationGradient) -> Result<Probe, MethodError> {
        self.survey()?.probe(f)
    }

    fn acoustic_minimum(
        &self,
        f: &DeformationGradient,
    ) -> Result<AcousticMinimum<3>, MaterialError> {
        acoustic_minimum::<D>(&*self.material, f)
    }

    fn scan(&self, path: &dyn DeformationPath) -> Result<PathScan, PathError> {
        let survey = self.survey().map_err(|source| PathError::Method {
            parameter: 0.0,
            source,
        })?;
        scan_discretization(&survey, path)
    }

    fn certify(
        &self,
        f: &DeformationGradient,
        tolerance: f64,
    ) -> Result<Certificate<3>, MethodError> {
        Ok(self.certifier(tolerance)?.certify(f)?.in_3d())
    }

    fn spectrum(&self, f: &DeformationGradient) -> Result<SpectrumSummary<3>, MethodError> {
        Ok(self.survey()?.spectrum(f)?.in_3d())
    }

    fn waves(&self, f: &DeformationGradient) -> Result<Box<dyn PlaneWaves>, MethodError> {
        // The waves themselves do not need a scale of wave speeds, which does not exist for a law without waves in the reference configuration.
        let scale = self.speed_squared().unwrap_or(1.0);
        let zone = || ZoneSearch::of_lattice(*self.discretization.crystal().lattice(), scale);
        let waves = StateWaves::of(&*self.discretization, &*self.material, f, scale, zone)?;
        let response = self.material.response(f)?;
        Ok(Box::new(Waves {
            waves,
            stiffness: Stiffness::<D>::of(&response),
            density: self.discretization.density(),
            is_periodic: self
                .discretization
                .enclosed()
                .is_none_or(Method::is_periodic),
            // With a regular lattice the undeformed particles represent deformed ones: the wave vector is spatial, and the reference wave vector is
            // F^T k.
            to_reference: match self.is_regular() {
                true => f.leading::<D>().transpose(),
                false => SMatrix::identity(),
            },
        }))
    }

    fn parts(
        &self,
        f: &DeformationGradient,
        waves: &[Vec<f64>],
    ) -> Result<Vec<WaveParts>, MethodError> {
        let scale = self.speed_squared().unwrap_or(1.0);
        let zone = || ZoneSearch::of_lattice(*self.discretization.crystal().lattice(), scale);
        let whole = StateWaves::of(&*self.discretization, &*self.material, f, scale, zone)?;
        let carried = self.discretization.carried(&*self.material, f)?;
        let at = |k: &Vec<f64>| {
            let k = vector(k);
            let mut parts = WaveParts::of_positions(whole.dynamical_matrix_at(&k));
            if let StateWaves::System(system) = &whole
                && let Some(damping) = system.0.damping_at(&k)
            {
                parts.damping = damping;
            }
            if let Some(carried) = &carried {
                let all = carried.all.dynamical_matrix_at(&k);
                if let Some(density) = &carried.density {
                    parts.density = density.dynamical_matrix_at(&k);
                }
                parts.stress = &all - &parts.density;
                parts.positions -= all;
            }
            parts
        };
        Ok(waves.iter().map(at).collect())
    }

    fn gradient_norm(
        &self,
        f: &DeformationGradient,
        k: &[f64],
    ) -> Result<Option<f64>, MethodError> {
        let norms = self
            .discretization
            .gradient_norms(f, &[(vector(k), false)])?;
        Ok(norms.and_then(|norms| norms.first().copied()))
    }

    fn has_unstrained_wave(&self, f: &DeformationGradient, k: &[f64]) -> Result<bool, MethodError> {
        self.survey()?.has_unstrained_wave(f, &vector(k))
    }

    fn spatial(&self, f: &DeformationGradient, k: &SVector<f64, 3>) -> SVector<f64, 3> {
        if self.is_regular() {
            return *k;
        }
        let map = f.leading::<D>();
        let solved = DMatrix::from_fn(D, D, |i, j| map[(j, i)])
            .lu()
            .solve(&DVector::from_fn(D, |i, _| k[i]));
        solved.map_or(*k, |solved| vector(solved.as_slice()))
    }

    fn reciprocal(&self) -> Vec<SVector<f64, 3>> {
        let reciprocal = self.discretization.crystal().lattice().reciprocal();
        let columns = reciprocal.column_iter();
        columns.map(|b| b.into_owned().in_3d()).collect()
    }

    fn fractional(&self, k: &SVector<f64, 3>) -> Vec<f64> {
        let lattice = self.discretization.crystal().lattice();
        let fractional = lattice.fractional(&vector::<D>(k.as_slice()));
        fractional.iter().copied().collect()
    }

    fn holohedry(&self) -> Vec<SMatrix<f64, 3, 3>> {
        let maps = self.discretization.crystal().lattice().holohedry();
        let in_3d = |map: &SMatrix<f64, D, D>| {
            SMatrix::from_fn(|i, j| map.get((i, j)).copied().unwrap_or(0.0))
        };
        maps.iter().map(in_3d).collect()
    }

    fn zone_path(&self, zone: Option<LatticeKind>) -> Vec<(&'static str, Vec<f64>)> {
        let lattice = self.discretization.crystal().lattice();
        let (zone, basis) = match zone {
            Some(zone) => (zone, *lattice.vectors()),
            None => lattice.shape(),
        };
        let named = BravaisLattice::new(basis).unwrap_or(*lattice);
        let reciprocal = named.reciprocal();
        let corners = zone.zone_path::<D>().into_iter();
        let corner = |(name, place)| {
            let k: SVector<f64, D> = reciprocal * place;
            (name, k.iter().copied().collect())
        };
        corners.map(corner).collect()
    }

    fn is_damped(&self) -> bool {
        self.survey().is_ok_and(|survey| survey.is_damped())
    }

    fn is_transferred(&self) -> bool {
        self.survey().is_ok_and(|survey| survey.is_transferred())
    }

    fn transferred(
        &self,
        f: &DeformationGradient,
    ) -> Result<Option<Box<dyn SteppedWaves>>, MethodError> {
        let waves = self.discretization.transferred(&*self.material, f)?;
        Ok(waves.map(|waves| Box::new(waves) as Box<dyn SteppedWaves>))
    }

    fn relaxing(
        &self,
        f: &DeformationGradient,
        law: &Viscoelastic,
    ) -> Result<Box<dyn Relaxing>, MethodError> {
        let waves = |law: &dyn Hyperelastic| self.discretization.waves(law, f);
        let stiffened = [
            waves(&*law.disturbed([1.0, 0.0]))?,
            waves(&*law.disturbed([0.0, 1.0]))?,
        ];
        let relaxed = waves(&*self.material)?;
        let terms = law.terms().to_vec();
        Ok(Box::new(RelaxingWaves::new(relaxed, stiffened, terms)))
    }

    fn damped_time_steps(
        &self,
        f: &DeformationGradient,
    ) -> Result<Vec<(Integrator, f64)>, MethodError> {
        self.survey()?.damped_time_steps(f)
    }

    fn critical_time_step(
        &self,
        f: &DeformationGradient,
        integrator: Integrator,
    ) -> Result<f64, MethodError> {
        self.survey()?.critical_time_step(f, integrator)
    }

    fn weakest(&self) -> Result<Option<WeakestMode<3>>, MethodError> {
        Ok(self.survey()?.weakest().map(|mode| mode.in_3d()))
    }

    fn spurious_modes(&self, threshold: f64) -> Result<SpuriousModes<3>, MethodError> {
        Ok(spurious_modes(&self.survey()?, threshold)?.in_3d())
    }

    fn masses(&self, f: &DeformationGradient) -> Result<Vec<f64>, MethodError> {
        let system = self.discretization.waves(&*self.material, f)?;
        Ok(system.particle_masses().into_owned())
    }

    fn patch(&self, cells: usize) -> Vec<PatchParticle> {
        let crystal = self.discretization.crystal();
        let particles = PeriodicPatch::new(crystal, [cells; D]).particles();
        let placed = particles.iter().map(|particle| PatchParticle {
            site: particle.site,
            position: crystal.position(particle).in_3d(),
        });
        placed.collect()
    }

    fn with_motion(
        &self,
        f: &DeformationGradient,
        cells: &[usize],
        work: &mut dyn FnMut(&mut dyn PatchMotion),
    ) -> Result<(), MethodError> {
        let cells = array_of(|i| cells.get(i).copied().unwrap_or(1));
        with_motion::<D>(&*self.discretization, &*self.material, f, cells, work)
    }

    fn with_body(
        &self,
        particles: &BodyParticles,
        grips: &[Grip],
        contact: Option<Contact>,
        work: &mut dyn FnMut(&mut dyn BodyMotion),
    ) -> Result<(), BodyError> {
        with_body::<D>(
            &*self.discretization,
            &*self.material,
            particles,
            grips,
            contact,
            work,
        )
    }

    fn finite_bodies(
        &self,
        f: &DeformationGradient,
    ) -> Result<FiniteBodyOscillations, MethodError> {
        let (discretization, material) = (&*self.discretization, &*self.material);
        let (fastest, ground) = match discretization.finite_bodies(material, f)? {
            Some(FiniteBodies::Parts { squared, damping }) => (
                Some(Oscillation { squared, damping }),
                FiniteBodyGround::Parts,
            ),
            Some(FiniteBodies::Lattice) => (None, FiniteBodyGround::Lattice),
            None => (
                oscillation_of_free_blocks(discretization, material, f),
                FiniteBodyGround::Blocks,
            ),
        };
        Ok(FiniteBodyOscillations { fastest, ground })
    }

    fn dispersion_errors(&self, wavelengths: &[f64]) -> Result<Vec<DispersionError>, MethodError> {
        dispersion_errors(&self.survey()?, wavelengths)
    }

    fn long_wave_error(&self) -> Result<f64, MethodError> {
        long_wave_error(&self.survey()?)
    }

    fn onset(&self, load: Load, end: f64) -> Result<OnsetPair, MethodError> {
        onset(&self.survey()?, load, end)
    }

    fn fidelity(&self, window: &StateWindow) -> Result<Fidelity, MethodError> {
        fidelity(&self.survey()?, window)
    }
}

impl<const D: usize> PlaneWaves for Waves<D> {
    fn dynamical_matrix_at(&self, k: &[f64]) -> DMatrix<Complex> {
        self.waves.dynamical_matrix_at(&vector(k))
    }

    fn omega_squared(&self, k: &[f64]) -> Vec<Complex> {
        self.waves.omega_squared(&vector(k))
    }

    fn frequencies(&self, k: &[f64]) -> Vec<Complex> {
        self.waves.frequencies(&vector(k))
    }

    fn folded(&self, k: &[f64]) -> Vec<f64> {
        if self.is_periodic {
            return k[..D.min(k.len())].to_vec();
        }
        let folded = self.waves.search().folded(&vector(k));
        folded.iter().copied().collect()
    }

    fn reach(&self, k: &[f64]) -> f64 {
        self.waves.search().reach(&vector(k))
    }

    fn continuum_omega_squared(&self, k: &[f64]) -> Vec<f64> {
        let k = self.to_reference * vector::<D>(k);
        let tensor = self.stiffness.acoustic_tensor(&k);
        let tensor = tensor.map(|entry| Complex::new(entry / self.density, 0.0));
        let values = eigenvalues(&tensor, 0.0);
        values.iter().map(|value| value.re).collect()
    }
}

impl<const D: usize> Relaxing for RelaxingWaves<D> {
    fn rates(&self, k: &[f64]) -> Vec<Complex> {
        Self::rates(self, &vector(k))
    }

    fn fastest(&self) -> (f64, Vec<f64>) {
        let (rate, k) = Self::fastest(self);
        (rate, k.iter().copied().collect())
    }
}

impl<const D: usize> SteppedWaves for TransferredWaves<D> {
    fn rates(&self, k: &[f64], step: f64) -> Vec<Complex> {
        Self::rates(self, &vector(k), step)
    }

    fn fastest(&self, step: f64) -> (Complex, Vec<f64>) {
        let (rate, k) = Self::fastest(self, step);
        (rate, k.iter().copied().collect())
    }

    fn critical_time_step(&self) -> f64 {
        Self::critical_time_step(self)
    }

    fn isolated_point(&self) -> Option<f64> {
        Self::isolated_point(self)
    }
}
