use super::Preset;

pub(super) const PRESET: Preset = Preset {
    name: "peridigm-lps",
    title: "Peridigm, material model Elastic",
    version: "1.6",
    source: "Peridigm_ElasticMaterial.cpp, Peridigm_InfluenceFunction.hpp",
    method: "peridynamics",
    keys: &[
        ("discretization.bonds", "ordinary"),
        ("discretization.influence", "constant"),
        ("discretization.partial-volumes", "whole"),
    ],
    note: "for the influence function Parabolic Decay set discretization.influence = parabolic",
};
