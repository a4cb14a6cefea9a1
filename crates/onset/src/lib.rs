//! Stability of a material and of its particle discretization, and whether the first instability is physical or numerical.
//!
//! The crate is organized like the theory: *material → continuum → particles → waves → verdict*.
//!
//! 1. [`real`]: number types in which an energy is evaluated; jets differentiate it exactly.
//! 2. [`kinematics`]: the deformation gradient `F`, its invariants, straight paths.
//! 3. [`material`]: a law is its strain energy `W(F)`; stress `P` and tangent `A` follow.
//! 4. [`continuum`]: the acoustic tensor `Q(N)` and strong ellipticity, without sampling of directions in one and two dimensions.
//! 5. [`criteria`]: other stability criteria, along loadings.
//! 6. [`lattice`], [`kernel`], [`approximation`], [`quadrature`], [`method`]: particles, in that order.
//! 7. [`bloch`]: the dynamical matrix `D(k)` and its extremes over the Brillouin zone.
//! 8. [`scheme`]: discretizations of any other kind, by their forces.
//! 9. [`verdict`]: stable or not, why, and where along a path the verdict changes.
//! 10. [`certificate`]: a proof of the verdict, or the statement that it is undecided.
//! 11. [`time_step`], [`measures`]: stable time steps, and measures that compare methods.
//! 12. [`motion`]: the discrete equations themselves, step by step.
//!
//! [`plasticity`] is separate: rate-independent flow, and where it localizes.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | `F_iJ` | deformation gradient, first index spatial | - |
//! | `P_iJ`, `A_iJkL` | first Piola-Kirchhoff stress `dW/dF`, tangent `dP/dF` | stress |
//! | `sigma_ij` | Cauchy stress | stress |
//! | `Q_ik(N)` | acoustic tensor `A_iJkL N_J N_L` | stress |
//! | `k` | reference wave vector; in the deformed lattice `F^-T k` | 1/length |
//! | `D(k)` | dynamical matrix, `D g = omega^2 g` | 1/time^2 |
//! | `mu` | scaled measure `Re omega^2 / (c^2 \|k\|_h^2)` | - |
//! | `V_q`, `V0`, `m` | volume of a quadrature point, of a cell; particle mass `rho0 V0` | |
//! | `D_mx`, `R0` | support radius in spacings; support radius | -, length |
//!
//! Any consistent system of units can be used: lengths in units of `spacing`, stresses in the units of the material parameters, densities in the
//! units of `density`.

pub mod algebra;
pub mod analysis;
pub mod approximation;
pub mod bloch;
pub mod cancel;
pub mod certificate;
pub mod continuum;
mod cores;
pub mod criteria;
pub mod formula;
pub mod kernel;
pub mod kinematics;
mod lanes;
pub mod lattice;
pub mod material;
pub mod measures;
pub mod method;
pub mod motion;
pub mod plasticity;
pub mod quadrature;
pub mod real;
pub mod scheme;
pub mod time_step;
pub mod verdict;
mod zero_energy;

pub use lanes::lanes;
