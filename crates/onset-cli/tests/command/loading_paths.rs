//! `onset path` along loadings with free faces.

use super::{Scratch, assert_close, document, number, numbers, onset_line};

const OGDEN: &str = "--set material.model=ogden set method=tlsph set penalty=0.1";

#[test]
fn free_faces_carry_no_traction() {
    let answer = document(&format!("path --mode uniaxial --to 2 {OGDEN}"));
    assert_eq!(answer["loading"]["lateral"], "free");
    let f = numbers(&answer, "/to/0");
    assert_close(f[0], 2.0, 1e-15);
    // Nearly incompressible: the lateral stretches are equal, 1/sqrt(2) almost.
    let (second, third) = (numbers(&answer, "/to/1")[1], numbers(&answer, "/to/2")[2]);
    assert_close(second, third, 1e-12);
    assert_close(second, 0.5_f64.sqrt(), 0.02);
    let state = document(&format!(
        "state --deformation-gradient 2,0,0,0,{second},0,0,0,{third} {OGDEN}"
    ));
    let stress = |i: usize| number(&state, &format!("/material/cauchy/{i}/{i}"));
    assert!(stress(1).abs() < 1e-9 * stress(0) && stress(2).abs() < 1e-9 * stress(0));
}

#[test]
fn the_onset_of_a_loading_is_where_the_criteria_have_it() {
    // Planar perturbations along a loading in plane strain: `criteria` asks the law, `path` the same law and particles.
    let law = "--set material.model=neo-hooke --set material.mu=1 --set material.lambda=1";
    let criteria = document(&format!("criteria --mode uniaxial {law}"));
    let loadings = criteria["loadings"].as_array().expect("loadings");
    let loading = loadings
        .iter()
        .find(|one| one["lateral"] == "plane-strain")
        .expect("a loading");
    let of_plane = loading["criteria"].as_array().expect("criteria");
    let of_plane = of_plane
        .iter()
        .find(|one| one["criterion"] == "plane-ellipticity")
        .expect("a criterion");
    for (side, to) in [("compression", 0.12), ("tension", 8.0)] {
        let limit = of_plane[side]["limit"].as_f64();
        let path = document(&format!(
            "path --mode uniaxial --lateral plane-strain --to {to} {law}"
        ));
        let onset = path["material_onset"]["stretch"][0].as_f64();
        match (limit, onset) {
            (Some(limit), Some(onset)) => assert_close(onset, limit, 1e-8),
            (None, None) => {}
            other => panic!("{side}: {other:?}"),
        }
    }
}

#[test]
fn a_path_is_written_as_table_and_figure() {
    let place = Scratch::new("path");
    let out = place.display().to_string();
    let line = format!("path --mode equibiaxial --to 1.6 {OGDEN} --out {out}");
    let answer = onset_line(&line);
    assert_eq!(answer.code, Some(0), "{}", answer.stderr);
    assert!(
        answer.stdout.contains("equibiaxial, plane stress"),
        "{}",
        answer.stdout
    );
    let csv = std::fs::read_to_string(place.join("path.csv")).expect("a file");
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows[0][1], "abscissa");
    assert_eq!(rows.len(), 98);
    assert!(rows.iter().all(|row| row.len() == rows[0].len()));
    let stretch: Vec<f64> = rows[1..]
        .iter()
        .map(|row| row[1].parse().expect("a number"))
        .collect();
    assert_eq!((stretch[0], stretch[96]), (1.0, 1.6));
    for file in ["path.svg", "path.png"] {
        assert!(place.join(file).is_file(), "{file}");
    }
    // The same table on standard output.
    let printed = onset_line(&format!(
        "path --mode equibiaxial --to 1.6 {OGDEN} --format csv"
    ));
    assert_eq!(printed.stdout.trim_end(), csv.trim_end());
}

#[test]
fn loadings_that_do_not_exist_are_refused_with_those_that_do() {
    for (line, fact) in [
        (
            "path --mode uniaxial --lateral plane-stress --to 2",
            "it has free, plane-strain, held",
        ),
        ("path --mode twist --to 2", "expected one of uniaxial"),
        ("path --mode uniaxial --to 2,1", "one imposed stretch"),
        ("path --mode uniaxial --to -2", "a positive number"),
        (
            "path --mode uniaxial --from 2 --to 2",
            "from a state to itself",
        ),
        ("path --to 2,1", "--from"),
        ("path --lateral free --from 1,1 --to 2,1", "--mode"),
        ("path --mode uniaxial --to 1e6", "between 0.001 and 1000"),
    ] {
        let answer = onset_line(line);
        assert_eq!(answer.code, Some(2), "{line}: {}", answer.stdout);
        assert!(answer.stderr.contains(fact), "{line}: {}", answer.stderr);
    }
}

#[test]
fn a_loading_that_ends_early_says_where_and_why() {
    // Gent's chains lock where lambda^2 + 1/lambda^2 = 2 + jm.
    let line = "path --mode planar --lateral plane-strain --to 40 --set material.model=gent --set material.jm=10 \
                set method=finite-elements";
    let answer = document(line);
    let end = number(&answer, "/loading/to");
    let locked = (6.0 + 35.0_f64.sqrt()).sqrt();
    assert!(end > 0.99 * locked && end <= locked, "{end}, {locked}");
    assert!(answer["loading"]["ends_early"].is_string());
    let told = onset_line(line).stdout;
    let first = told.lines().next().unwrap_or_default();
    assert!(first.contains("only, not to 40"), "{told}");
    // Nothing is claimed of the part that was not followed.
    assert!(!told.contains("along the whole path"), "{told}");
    assert!(told.contains("up to stretch"), "{told}");
}
