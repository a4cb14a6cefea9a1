//! Checks of every named kernel and of formulas.

mod certificates;
mod constants;
mod formulas;
mod profiles;
mod transforms;

use onset::kernel::Kernel;

/// All named kernels and some formulas: smooth, cusped, piecewise, and with a rim at which only the slope vanishes.
fn kernels() -> Vec<Kernel> {
    let typed = [
        "(1 - q)^4*(1 + 4*q)",
        "let s = 2*q; if(s < 1, 1 - 1.5*s^2 + 0.75*s^3, (2 - s)^3/4)",
        "(1 - q)^3",
        "cos(pi*q/2)^2",
        "2*(1 - q^2)^2",
    ];
    let formulas = typed.map(|text| text.parse().expect("a kernel"));
    Kernel::ALL.into_iter().chain(formulas).collect()
}
