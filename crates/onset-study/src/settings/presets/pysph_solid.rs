use super::Preset;

pub(super) const PRESET: Preset = Preset {
    name: "pysph-solid",
    title: "PySPH, ElasticSolidsScheme",
    version: "1.0",
    source: "Gray, Monaghan, Swift 2001; pysph/sph/scheme.py",
    method: "updated-sph",
    keys: &[
        ("discretization.kernel", "cubic-spline"),
        ("discretization.momentum", "symmetric"),
        ("discretization.density-evolution", "continuity"),
        ("discretization.corrected", "false"),
        ("discretization.support-size", "fixed"),
        ("discretization.artificial-stress", "0.3"),
        ("discretization.viscosity", "1"),
        ("discretization.velocity-smoothing", "0.5"),
        ("discretization.smoothed-motion", "positions"),
    ],
    note: "discretization.artificial-stress, viscosity and velocity-smoothing are artificial_stress_eps, alpha and xsph_eps; the quadratic part of the viscosity has no linear form",
};
