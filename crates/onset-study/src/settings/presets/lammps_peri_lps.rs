use super::Preset;

pub(super) const PRESET: Preset = Preset {
    name: "lammps-peri-lps",
    title: "LAMMPS, package PERI, pair_style peri/lps",
    version: "22 Jul 2025",
    source: "Silling and others, J. Elasticity 88 (2007) 151; pair_peri_lps.cpp",
    method: "peridynamics",
    keys: &[
        ("discretization.bonds", "ordinary"),
        ("discretization.influence", "inverse"),
        ("discretization.partial-volumes", "inside"),
    ],
    note: "bonds do not break, and short-range forces are left out; fix PERI_NEIGH of this version measures bonds across a periodic boundary wrongly, and the forces there are too small",
};
