use super::Preset;

pub(super) const PRESET: Preset = Preset {
    name: "moose-nospd",
    title: "MOOSE, peridynamics module, NONORDINARY_STATE with the stabilization BOND_HORIZON_II",
    version: "2024",
    source: "Chen, Mech. Res. Commun. 90 (2018) 34; HorizonStabilizedFormIIFiniteStrainMechanicsNOSPD.C",
    method: "peridynamics",
    keys: &[
        ("discretization.bonds", "bond-associated-form-ii"),
        ("discretization.influence", "inverse"),
        ("discretization.partial-volumes", "whole"),
    ],
    note: "for BOND_HORIZON_I set discretization.bonds = bond-associated-form-i",
};
