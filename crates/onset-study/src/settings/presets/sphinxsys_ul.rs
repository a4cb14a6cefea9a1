use super::Preset;

pub(super) const PRESET: Preset = Preset {
    name: "sphinxsys-ul",
    title: "SPHinXsys, continuum with hourglass control (updated Lagrangian)",
    version: "1.0",
    source: "Zhang, Zhang, Hu and others, arXiv 2409.11474; continuum_integration.cpp",
    method: "updated-sph",
    keys: &[
        ("discretization.kernel", "wendland-c2"),
        ("discretization.support", "2.6"),
        ("discretization.corrected", "true"),
        ("discretization.momentum", "mean"),
        ("discretization.density-evolution", "continuity"),
        ("discretization.support-size", "fixed"),
        ("discretization.penalty", "2"),
    ],
    note: "discretization.penalty is xi, 2 in the code and 4 in the paper (in two dimensions). The dissipation of the Riemann solver and the limiter of the penalty in metals are omitted; the density follows the corrected velocity gradient",
};
