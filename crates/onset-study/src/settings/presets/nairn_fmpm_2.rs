use super::Preset;

pub(super) const PRESET: Preset = Preset {
    name: "nairn-fmpm-2",
    title: "NairnMPM / OSParticulas, FMPM(2) with uniform GIMP functions",
    version: "as published",
    source: "Nairn and Hammerquist, Comput. Methods Appl. Mech. Eng. 386 (2021) 114075",
    method: "material-points",
    keys: &[
        ("discretization.unknowns", "particles"),
        ("discretization.transfer", "fmpm"),
        ("discretization.transfer-order", "2"),
        ("discretization.grid-functions", "gimp"),
    ],
    note: "discretization.transfer-order is the order k of FMPM(k), applied in every time step",
};
