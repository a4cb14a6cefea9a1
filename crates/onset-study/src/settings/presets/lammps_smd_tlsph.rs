use super::Preset;

pub(super) const PRESET: Preset = Preset {
    name: "lammps-smd-tlsph",
    title: "LAMMPS, package MACHDYN, pair_style smd/tlsph",
    version: "22 Jul 2025",
    source: "pair_smd_tlsph.cpp; Ganzenmueller, Comput. Methods Appl. Mech. Eng. 286 (2015) 87",
    method: "total-lagrangian-sph",
    keys: &[
        ("discretization.kernel", "(1-q)^3"),
        ("discretization.corrected", "true"),
        ("discretization.penalty-form", "smd"),
    ],
    note: "discretization.penalty is the hourglass amplitude of *HOURGLASS_CONTROL; 0 unless set",
};
