use super::Preset;

pub(super) const PRESET: Preset = Preset {
    name: "perilab-correspondence",
    title: "PeriLab, Correspondence with the zero-energy control Global",
    version: "2.2.4",
    source: "Wan and others 2019; Global_Zero_Energy_Control.jl; issue 397",
    method: "peridynamics",
    keys: &[
        ("discretization.bonds", "correspondence"),
        ("discretization.influence", "constant"),
        ("discretization.partial-volumes", "whole"),
        ("discretization.control", "stiffness-tensor"),
        ("discretization.control-coefficient", "1"),
        ("discretization.weighted-forces", "false"),
    ],
    note: "forces lack the influence function, which matters only if it is not constant",
};
