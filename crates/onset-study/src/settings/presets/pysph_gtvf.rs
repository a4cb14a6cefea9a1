use super::Preset;

pub(super) const PRESET: Preset = Preset {
    name: "pysph-gtvf",
    title: "PySPH, GTVFScheme with its equations for solids",
    version: "1.0",
    source: "Zhang, Hu, Adams, J. Comput. Phys. 337 (2017) 216; pysph/sph/wc/gtvf.py",
    method: "updated-sph",
    keys: &[
        ("discretization.kernel", "wendland-c2"),
        ("discretization.momentum", "symmetric"),
        ("discretization.density-evolution", "summation"),
        ("discretization.corrected", "false"),
        ("discretization.support-size", "fixed"),
    ],
    note: "the corrected density is the summation density if the sum of V W is at least 1, as on lattices with this kernel; the transport velocity is left out, because it vanishes with the time step. Forces of the deviatoric stress have the densities of equation (17) of the paper, which the code omits",
};
