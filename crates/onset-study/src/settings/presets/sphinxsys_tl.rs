use super::Preset;

pub(super) const PRESET: Preset = Preset {
    name: "sphinxsys-tl",
    title: "SPHinXsys, elastic solids",
    version: "1.0",
    source: "Zhang and others, Comput. Phys. Commun. 267 (2021) 108066; elastic_dynamics.cpp",
    method: "total-lagrangian-sph",
    keys: &[
        ("discretization.kernel", "wendland-c2"),
        ("discretization.support", "2.6"),
        ("discretization.corrected", "true"),
    ],
    note: "the support of 2.6 spacings is twice the smoothing length; the pairwise numerical damping is left out: it changes growth rates and time steps, but no verdict",
};
