//! Laws, one file each: formula, parameters, domain, source, and the resulting moduli.

mod arruda_boyce;
mod blatz_ko;
mod crystals;
mod equations_of_state;
mod exponentials;
mod exponentiated_hencky;
mod fung;
mod generalized_blatz_ko;
mod gent;
mod hencky;
mod holzapfel_gasser_ogden;
mod hyperfoam;
mod modified_mooney_rivlin;
mod mooney_rivlin;
mod neo_hooke;
mod ogden;
mod quadratic;
mod reinforced;
mod saint_venant_kirchhoff;
mod saint_venant_orthotropic;
mod volumetric;
mod yeoh;

pub use blatz_ko::BlatzKo;
pub use modified_mooney_rivlin::ModifiedMooneyRivlin;

use super::law::Law;

/// All laws, the default first.
pub(super) static LIBRARY: &[Law] = &[
    modified_mooney_rivlin::LAW,
    blatz_ko::LAW,
    generalized_blatz_ko::LAW,
    neo_hooke::LOGARITHMIC,
    neo_hooke::QUADRATIC,
    neo_hooke::POLYCONVEX,
    neo_hooke::ISOCHORIC,
    mooney_rivlin::COMPRESSIBLE,
    mooney_rivlin::ISOCHORIC,
    yeoh::LAW,
    gent::LAW,
    arruda_boyce::LAW,
    ogden::LAW,
    hyperfoam::LAW,
    saint_venant_kirchhoff::LAW,
    hencky::LAW,
    exponentiated_hencky::LAW,
    equations_of_state::MURNAGHAN,
    equations_of_state::TAIT,
    equations_of_state::MIE_GRUENEISEN,
    fung::ISOTROPIC,
    fung::ORTHOTROPIC,
    holzapfel_gasser_ogden::LAW,
    holzapfel_gasser_ogden::SWITCHED,
    reinforced::LAW,
    saint_venant_orthotropic::LAW,
    crystals::CUBIC,
    crystals::ORTHOTROPIC,
];
