use super::Preset;

pub(super) const PRESET: Preset = Preset {
    name: "peridigm-correspondence",
    title: "Peridigm, material model Elastic Correspondence",
    version: "1.6",
    source: "Littlewood 2010; Peridigm_ElasticCorrespondenceMaterial.cpp",
    method: "peridynamics",
    keys: &[
        ("discretization.bonds", "correspondence"),
        ("discretization.influence", "constant"),
        ("discretization.partial-volumes", "whole"),
        ("discretization.control", "hourglass"),
        ("discretization.control-coefficient", "0.02"),
    ],
    note: "discretization.control-coefficient is the Hourglass Coefficient, 0.02 in its examples, where the micromodulus is 18 K / (pi horizon^4)",
};
