use super::Preset;

pub(super) const PRESET: Preset = Preset {
    name: "taichi-mpm88",
    title: "Taichi, mpm88: the material point method with moving least squares",
    version: "1.7",
    source: "Hu and others, ACM Trans. Graph. 37 (2018) 150; mpm88.py",
    method: "material-points",
    keys: &[
        ("discretization.unknowns", "particles"),
        ("discretization.transfer", "apic"),
        ("discretization.grid-functions", "quadratic-spline"),
        ("discretization.grid-gradients", "moments"),
    ],
    note: "points are laid out regularly here, at random in mpm88.py",
};
