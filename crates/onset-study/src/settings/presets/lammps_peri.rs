use super::Preset;

pub(super) const PRESET: Preset = Preset {
    name: "lammps-peri",
    title: "LAMMPS, package PERI, pair_style peri/pmb",
    version: "22 Jul 2025",
    source: "Parks and others, Comput. Phys. Commun. 179 (2008) 777; pair_peri_pmb.cpp",
    method: "peridynamics",
    keys: &[
        ("discretization.bonds", "bond-based"),
        ("discretization.calibration", "continuum"),
        ("discretization.influence", "constant"),
        ("discretization.partial-volumes", "inside"),
    ],
    note: "bonds do not break; short-range forces are left out",
};
