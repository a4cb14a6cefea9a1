//! `onset state --certify` and certified maps: proofs, and their precedence over the search.

use crate::map::{Place, flags, numbers, opened};
use crate::{document, number, onset_line};

/// Eulerian kernels of figure 6 on a regular lattice.
const EULERIAN: &str = "set frame=eulerian set current-lattice=regular";

#[test]
fn a_stable_state_is_certified_by_a_bound_below_the_result_of_the_search() {
    let line = format!("state --stretch 0.9,0.9 --certify {EULERIAN} set support=1.9");
    let state = document(&line);
    assert_eq!(state["verdict"], "stable");
    let proof = &state["certificate"]["discretization"];
    assert_eq!(proof["certainty"], "proved-stable");
    let bound = number(proof, "/bound");
    let found = number(&state, "/discretization/minimum_scaled");
    assert!(0.0 < bound && bound <= found, "{bound} {found}");
    assert_eq!(
        state["certificate"]["material"]["certainty"],
        "proved-stable"
    );
    let text = onset_line(&line).stdout;
    assert!(
        text.contains("proved-stable: the measure is at least"),
        "{text}"
    );
}

#[test]
fn an_unstable_state_is_certified_by_a_growing_wave() {
    let line = "state --stretch 1.2,1.0 --certify --all set frame=eulerian";
    let state = document(line);
    assert_eq!(state["verdict"], "numerical");
    let proof = &state["certificate"]["discretization"];
    assert_eq!(proof["certainty"], "proved-unstable");
    assert!(number(proof, "/witness/measure/1") < 0.0);
    assert!(number(proof, "/witness/growth_rate") > 0.0);
    assert!(
        onset_line(line)
            .stdout
            .contains("grows at a rate of at least")
    );
}

#[test]
fn a_material_that_is_elliptic_only_in_the_plane_is_reported_and_proved_as_such() {
    // The ratio is one between the in-plane stretches, and above 2 + sqrt 3 to the third stretch.
    let line = "state --stretch 0.25,0.25 --set material.model=blatz-ko --certify --all";
    let state = document(line);
    assert_eq!(state["material"]["elliptic"], true);
    let space = &state["material_3d"];
    assert_eq!(space["elliptic"], false);
    let value = number(space, "/minimum_acoustic_eigenvalue");
    let bound = number(space, "/bound");
    assert!(value < 0.0 && bound <= value && bound > 1.001 * value);
    // Neither the normal nor the polarization lies in the plane or normal to it: a band through the thickness.
    for vector in ["direction", "polarization"] {
        let across = number(space, &format!("/{vector}/2")).abs();
        assert!(across > 0.01 && across < 0.9999, "{vector}: {across}");
    }
    let certificate = &state["certificate"];
    assert_eq!(certificate["material"]["certainty"], "proved-stable");
    let proof = &certificate["material_3d"];
    assert_eq!(proof["certainty"], "proved-unstable");
    assert!(number(proof, "/witness/measure/1") < 0.0);
    let polarization = proof["witness"]["polarization"].as_array();
    assert_eq!(polarization.map(Vec::len), Some(3));
    let text = onset_line(line).stdout;
    assert!(
        text.contains("for in-plane perturbations, not for out-of-plane ones"),
        "{text}"
    );
    assert!(
        text.contains("material in 3D        proved-unstable"),
        "{text}"
    );
}

#[test]
fn a_proof_is_attempted_only_on_request() {
    assert!(
        document("state --stretch 1.2,1.0")
            .get("certificate")
            .is_none()
    );
    let answer = onset_line("state --stretch 1.2,1.0 --tolerance 1e-3");
    assert_eq!(answer.code, Some(2), "{}", answer.stderr);
    let answer = onset_line("state --stretch 1.2,1.0 --certify --tolerance 2");
    assert_eq!(answer.code, Some(2), "{}", answer.stderr);
}

#[test]
fn a_pocket_of_flutter_missed_by_the_search_is_proved_and_corrects_the_verdict() {
    let line =
        format!("state --stretch 1.7075,0.5825 {EULERIAN} set support=1.6 set linearization=paper");
    assert_eq!(document(&line)["verdict"], "stable");
    let state = document(&format!("{line} --certify"));
    assert_eq!(state["verdict"], "numerical");
    let certificate = &state["certificate"];
    assert_eq!(certificate["corrects_the_search"], true);
    let proof = &certificate["discretization"];
    assert_eq!(proof["certainty"], "proved-unstable");
    assert!(number(proof, "/witness/measure/0") > 0.0, "flutter");
    assert!(number(proof, "/witness/growth_rate") > 1e-4);

    // A map that contains this state gives the same result.
    let place = Place::new(
        "[discretization]\nframe = 'eulerian'\ncurrent-lattice = 'regular'\nsupport = 1.6\nlinearization = 'paper'\n\
         [[axes]]\nquantity = 'stretch-1'\nrange = [1.7025, 1.7325]\nstates = 3\n\
         [[axes]]\nquantity = 'stretch-2'\nrange = [0.5775, 0.5975]\nstates = 2\n\
         [map]\ncertify = true\n",
    );
    let map = place.document("a.zarr", "");
    let corrected = map["proofs"]["corrected"].as_u64().expect("a count");
    assert!(corrected >= 1, "{map}");
    let store = opened(&place, "a.zarr");
    let (verdicts, stabilities) = (flags(&store, "verdict"), flags(&store, "stability"));
    let marks = flags(&store, "corrected");
    let rates = numbers(&store, "growth_rate");
    // The verdict is numerical, by flutter, and corrected by the proof.
    assert_eq!((verdicts[0], stabilities[0], marks[0]), (3, 1, 1));
    assert!(rates[0] > 0.0);
    // Stored states are counted like computed ones.
    let resumed = place.document("a.zarr", "--resume");
    assert_eq!(resumed["proofs"], map["proofs"]);
}

#[test]
fn a_certified_map_contradicts_neither_its_verdicts_nor_its_numbers() {
    for refined in ["adaptive = false", "adaptive = true\nrefine-from = 8"] {
        let adaptive = refined.starts_with("adaptive = true");
        let place = Place::new(&format!(
            "[discretization]\nframe = 'eulerian'\ncurrent-lattice = 'regular'\nsupport = 1.9\n\
             [[axes]]\nquantity = 'stretch-1'\nrange = [0.2, 2.0]\nstates = 24\n\
             [[axes]]\nquantity = 'stretch-2'\nrange = [0.2, 2.0]\nstates = 20\n\
             [map]\ncertify = true\n{refined}\n"
        ));
        let map = place.document("a.zarr", "");
        let store = opened(&place, "a.zarr");
        let [verdicts, stabilities, evaluated, certainties, materials] = [
            "verdict",
            "stability",
            "evaluated",
            "certainty",
            "certainty_material",
        ]
        .map(|field| flags(&store, field));
        let minima = numbers(&store, "scaled_minimum");
        let bounds = numbers(&store, "proved_bound");
        let mut counts = [0; 5];
        for state in 0..verdicts.len() {
            let certainty = certainties[state];
            counts[certainty as usize] += 1;
            let is_defined = verdicts[state] < 5;
            assert_eq!(certainty == 0, evaluated[state] == 0 || !is_defined);
            match certainty {
                1 => {
                    assert_eq!(stabilities[state], 0);
                    assert!(0.0 < bounds[state] && bounds[state] <= minima[state]);
                }
                2 => {
                    assert!([1, 2].contains(&stabilities[state]));
                    assert!(bounds[state].is_finite());
                }
                _ => {}
            }
            match materials[state] {
                // The verdict is neither `physical` nor `suppressed`.
                1 => assert!(![1, 4].contains(&verdicts[state])),
                // The verdict is neither `stable` nor `zero-energy`.
                2 => assert!(![0, 2].contains(&verdicts[state])),
                _ => {}
            }
        }
        assert!(counts[1] > 20 && counts[2] > 20, "{counts:?}");
        assert_eq!(counts[0] > 0, adaptive, "{counts:?}");
        let names = ["not-asked", "proved-stable", "proved-unstable"];
        for (name, count) in names.into_iter().zip(counts) {
            assert_eq!(map["proofs"]["certainty"][name]["states"], count, "{name}");
        }
    }
}

#[test]
fn lagrangian_nodal_quadrature_is_proved_to_have_zero_energy_modes() {
    let place = Place::new(
        "[discretization]\nquadrature = 'nodal'\n\
         [[axes]]\nquantity = 'stretch-1'\nrange = [0.9, 1.2]\nstates = 3\n\
         [[axes]]\nquantity = 'stretch-2'\nrange = [0.9, 1.2]\nstates = 3\n\
         [map]\ncertify = true\n",
    );
    let answer = place.computed("a.zarr", "");
    assert!(
        answer.stdout.contains("proved-zero-energy"),
        "{}",
        answer.stdout
    );
    let store = opened(&place, "a.zarr");
    assert!(flags(&store, "certainty").iter().all(|flag| *flag == 3));
    assert!(flags(&store, "verdict").iter().all(|flag| *flag == 2));
}

#[test]
fn figures_show_proofs_of_certified_maps_only() {
    let text = "[[axes]]\nquantity = 'stretch-1'\nrange = [0.9, 3.0]\nstates = 4\n\
                [[axes]]\nquantity = 'stretch-2'\nrange = [0.9, 3.0]\nstates = 4\n";
    for certify in [true, false] {
        let place = Place::new(&format!("{text}[map]\ncertify = {certify}\n"));
        place.computed("a.zarr", "");
        let (store, picture) = (place.store("a.zarr"), place.store("a.svg"));
        let line = format!(
            "plot {} --field certainty --no-trace --out {}",
            store.display(),
            picture.display()
        );
        let answer = onset_line(&line);
        assert_eq!(
            answer.code,
            Some(if certify { 0 } else { 2 }),
            "{}",
            answer.stderr
        );
        assert_eq!(picture.is_file(), certify);
    }
}

/// Laws in principal stretches are proved to be elliptic in any axes, also at equal stretches.
#[test]
fn the_hencky_law_is_proved_to_be_elliptic() {
    let law = "--certify --set material.model=hencky --set material.mu=1 --set material.kappa=2";
    for state in [
        "--deformation-gradient=1.4,0.1,0.1,0.9",
        "--stretch 1.3,0.9",
    ] {
        let answer = document(&format!("state {law} {state}"));
        let found = &answer["certificate"]["material"]["certainty"];
        assert_eq!(found, "proved-stable", "{state}");
    }
}
