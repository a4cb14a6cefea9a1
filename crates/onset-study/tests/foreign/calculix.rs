//! Blocks of CalculiX, which have the keywords of Abaqus but a different meaning of zeros.

use crate::{agrees, invariants, ogden, read, told};
use onset_study::settings::Program::{Abaqus, Calculix};

/// In the sources of CalculiX zeros are replaced by `D_i = (0.1/mu)^i`.
#[test]
fn zeros_become_compressibilities_that_depend_on_the_units() {
    let block = "*MATERIAL, NAME=EL\n*HYPERELASTIC, POLYNOMIAL, N=2\n0.2, 0.05, 0.01, -0.003, 0.002, 0.1, 0.0\n";
    let isochoric = |f: &_| {
        let (i1, i2, _, _) = invariants(f);
        let (x, y) = (i1 - 3.0, i2 - 3.0);
        0.2 * x + 0.05 * y + 0.01 * x * x - 0.003 * x * y + 0.002 * y * y
    };
    agrees(&*read(Abaqus, block, &[]), |f| {
        isochoric(f) + (invariants(f).2 - 1.0).powi(2) / 0.1
    });
    agrees(&*read(Calculix, block, &[]), |f| {
        let j = invariants(f).2 - 1.0;
        isochoric(f) + j.powi(2) / 0.1 + j.powi(4) / 0.2_f64.powi(2)
    });
    let notes = told(Calculix, block, None);
    assert!(
        notes.contains("CalculiX replaces compressibilities below 1e-10")
            && notes.contains("D2 = 0.04"),
        "{notes}"
    );
    let large = block.replace("0.1, 0.0", "0.1, 1e20");
    agrees(&*read(Calculix, &large, &[]), |f| {
        isochoric(f) + (invariants(f).2 - 1.0).powi(2) / 0.1
    });
    let block = "*HYPERELASTIC, OGDEN, N=1\n0.4, 1.3, 0";
    agrees(&*read(Calculix, block, &[]), |f| {
        ogden(f, &[(0.8 / 1.69, 1.3)]) + (invariants(f).2 - 1.0).powi(2) / 0.25
    });
    let block = "*HYPERELASTIC, ARRUDA-BOYCE\n0.4, 5., 0.1";
    assert!(told(Calculix, block, None).contains("material.model=arruda-boyce"));
}

#[test]
fn forms_that_calculix_lacks_are_refused_with_their_line() {
    for (block, fact) in [
        (
            "*HYPERELASTIC, OGDEN, N=4\n1,1,1,1,1,1,1,1\n1,1,1,1",
            "a deck:1:1: N is `4`; expected an integer from 1 to 3",
        ),
        (
            "**\n*HYPERELASTIC, MARLOW\n*UNIAXIAL TEST DATA\n1,1\n2,2",
            "a deck:2:1: CalculiX has no *HYPERELASTIC, MARLOW",
        ),
        (
            "*ANISOTROPIC HYPERELASTIC, HOLZAPFEL\n1,1,1,1,0.1",
            "a deck:1:1: CalculiX has no *ANISOTROPIC HYPERELASTIC, HOLZAPFEL",
        ),
        ("*ELASTIC\n1,1", "there is no hyperelastic law of CalculiX"),
    ] {
        let error = told(Calculix, block, None);
        assert!(error.contains(fact), "{block}: {error}");
    }
}
