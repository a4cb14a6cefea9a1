//! Particles in three dimensions, and on lattices from vectors.

use crate::map::{Place, numbers as stored, opened};
use crate::{assert_close, document, number, numbers, onset_line};

const CLOSEST: &str = "lattice=face-centered-cubic set support=1.65 set quadrature=nodal";

#[test]
fn a_state_in_3d_has_vectors_with_three_components() {
    let answer = document(&format!(
        "state --stretch 1.1,0.95,1 set {CLOSEST} set frame=eulerian"
    ));
    assert_eq!(numbers(&answer, "/discretization/wave_vector").len(), 3);
    assert_eq!(numbers(&answer, "/material/direction").len(), 3);
    let by_components = document(&format!(
        "state --deformation-gradient 1.1,0,0,0,0.95,0,0,0,1 set {CLOSEST} set frame=eulerian"
    ));
    assert_eq!(answer["discretization"], by_components["discretization"]);
}

#[test]
fn stretches_along_the_edges_of_a_cube_can_be_permuted() {
    let softest = ["1.1,0.95,1", "1,1.1,0.95", "0.95,1,1.1"].map(|stretches| {
        let answer = document(&format!(
            "state --stretch {stretches} set {CLOSEST} set frame=eulerian"
        ));
        number(&answer, "/discretization/minimum_omega_squared/re")
    });
    assert!(softest[0] < 0.0);
    assert_close(softest[1], softest[0], 1e-8);
    assert_close(softest[2], softest[0], 1e-8);
}

#[test]
fn a_map_in_3d_agrees_with_the_state_command() {
    let place = Place::new(
        "[discretization]\nlattice = \"face-centered-cubic\"\nquadrature = \"nodal\"\nsupport = 1.65\nframe = \"eulerian\"\n\
         [[axes]]\nquantity = \"stretch-3\"\nrange = [0.8, 1.2]\nstates = 3\n\
         [[axes]]\nquantity = \"stretch-1\"\nrange = [0.9, 1.1]\nstates = 2\n",
    );
    place.computed("map.zarr", "");
    let store = opened(&place, "map.zarr");
    let minima = stored(&store, "scaled_minimum");
    assert_eq!(minima.len(), 6);
    // The first state: stretch-1 = 0.95, stretch-3 = 0.8 + 0.4 / 6.
    let answer = document(&format!(
        "state --stretch 0.95,1,{} set {CLOSEST} set frame=eulerian",
        0.8 + 0.4 / 6.0
    ));
    assert_close(
        minima[0],
        number(&answer, "/discretization/minimum_scaled"),
        1e-9,
    );
}

#[test]
fn primitive_vectors_reproduce_the_named_lattice() {
    let named = document("state --stretch 1.1,0.9 set lattice=hexagonal");
    let vectors = format!("vectors=1,0,0.5,{}", 0.75_f64.sqrt());
    let given = document(&format!(
        "state --stretch 1.1,0.9 set lattice=oblique set {vectors}"
    ));
    let omega = "/discretization/maximum_omega";
    assert_close(number(&given, omega), number(&named, omega), 1e-10);
}

#[test]
fn invalid_lattices_are_refused_with_a_hint() {
    for (line, told) in [
        (
            "state --stretch 1.1,1,1 set lattice=triclinic",
            "needs 9 numbers",
        ),
        (
            "state --stretch 1.1,1 set lattice=oblique set vectors=1,2,2,4",
            "linearly independent",
        ),
        (
            "state --stretch 1.1,1 set lattice=rectangular set aspect=-1",
            "a positive number from 0.001 to 1000",
        ),
        (
            "state --stretch 1.1,1 set lattice=simple-cubic",
            "one for each dimension",
        ),
    ] {
        let answer = onset_line(line);
        assert_eq!(answer.code, Some(2), "{line}: {}", answer.stderr);
        assert!(answer.stderr.contains(told), "{line}: {}", answer.stderr);
    }
}

#[test]
fn a_certificate_in_3d_states_that_waves_are_not_covered() {
    let answer = document(&format!("state --stretch 1,1,1 --certify set {CLOSEST}"));
    let certificate = answer["certificate"].to_string();
    assert!(certificate.contains("undecided"), "{certificate}");
}
