use super::Preset;

pub(super) const PRESET: Preset = Preset {
    name: "lammps-smd-ulsph",
    title: "LAMMPS, package MACHDYN, pair_style smd/ulsph",
    version: "22 Jul 2025",
    source: "pair_smd_ulsph.cpp",
    method: "updated-sph",
    keys: &[
        ("discretization.kernel", "(1-q)^3"),
        ("discretization.momentum", "mean"),
        ("discretization.density-evolution", "continuity"),
        ("discretization.corrected", "false"),
        ("discretization.support-size", "fixed"),
    ],
    note: "for *GRADIENT_CORRECTION set discretization.corrected and discretization.corrected-forces",
};
