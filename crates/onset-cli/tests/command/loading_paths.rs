//! `onset path` along loadings with free faces.

use super::{Scratch, assert_close, document, number, numbers, onset_line};

const OGDEN: &str = "--set material.model=ogden set method=tlsph set penalty=0.1";

#[test]
fn free_faces_carry_no_traction() {
    let answer = document(&format!("path --mode uniaxial --to 2 {OGDEN}"));
    assert_eq!(answer["loading"]["lateral"], "free");
    let f = numbers(&answer, "/to/0");
    assert_close(f[0], 2.0, 1e-15);
    // Nearly incompressible: the lateral stretches are equal, almost 1/sqrt(2).
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
fn path_and_criteria_agree_on_the_onset_of_a_loading() {
    // Planar perturbations in plane strain: `criteria` evaluates the law, `path` the law and its particles.
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
fn a_path_is_written_as_a_table_and_a_figure() {
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
    // With --format csv the command prints the table.
    let printed = onset_line(&format!(
        "path --mode equibiaxial --to 1.6 {OGDEN} --format csv"
    ));
    assert_eq!(printed.stdout.trim_end(), csv.trim_end());
}

#[test]
fn unknown_loadings_are_refused_with_the_available_loadings() {
    for (line, fact) in [
        (
            "path --mode uniaxial --lateral plane-stress --to 2",
            "supported: free, plane-strain, held",
        ),
        ("path --mode twist --to 2", "expected one of uniaxial"),
        ("path --mode uniaxial --to 2,1", "one imposed stretch"),
        ("path --mode uniaxial --to -2", "a positive number"),
        ("path --mode uniaxial --from 2 --to 2", "are equal"),
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
fn a_loading_that_ends_early_reports_where_and_why() {
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
    // No statement is made about the part that was not followed.
    assert!(!told.contains("along the whole path"), "{told}");
    assert!(told.contains("up to stretch"), "{told}");
}

/// Law with a softening dilatation, so that free faces have limit points.
const SOFTENING: &str = "--energy mu/2*(I1-3)-mu*ln(J)+k*w^2/2*(1-exp(-((J-1)/w)^2)) --set material.mu=1 --set material.k=10 --set material.w=0.1";

#[test]
fn a_path_with_free_faces_is_answered_up_to_its_fold() {
    for (mode, to, fold) in [
        ("equibiaxial", 1.4, 1.20989),
        ("equibiaxial", 0.75, 0.88265),
        ("uniaxial", 2.2, 1.98875),
        ("uniaxial", 0.5, 0.66265),
        ("planar", 1.6, 1.46383),
        ("planar", 0.7, 0.77907),
    ] {
        for from in [1.0, 0.95, 1.05] {
            let line = format!(
                "path --mode {mode} --from {from} --to {to} {SOFTENING} set method=tlsph set lattice=square set penalty=0.5"
            );
            let answer = document(&line);
            assert_close(number(&answer, "/loading/to"), fold, 2e-5);
            assert_close(number(&answer, "/loading/folds/0"), fold, 2e-5);
            let told = onset_line(&line).stdout;
            assert!(
                told.contains("no equilibrium nearby (dynamic jump)"),
                "{told}"
            );
            assert!(told.contains(&format!("only, not to {to}")), "{told}");
        }
        let line = format!(
            "path --mode {mode} --to {to} {SOFTENING} set method=tlsph set lattice=square set penalty=0.5 --format csv"
        );
        let table = onset_line(&line).stdout;
        let column = |name: &str| {
            let place = table
                .lines()
                .next()
                .and_then(|head| head.split(',').position(|one| one == name));
            let place = place.expect("a column");
            let cells = table
                .lines()
                .skip(1)
                .map(|row| row.split(',').nth(place).expect("a cell").parse::<f64>());
            cells.collect::<Result<Vec<_>, _>>().expect("numbers")
        };
        let thickness = column("F33");
        assert!(
            thickness
                .windows(2)
                .all(|pair| (pair[1] - pair[0]).abs() < 0.05),
            "{thickness:?}"
        );
        assert_close(column("abscissa")[96], fold, 2e-5);
    }
    // A path that starts beyond one fold leads to the other fold; beyond both there is no answer.
    let line = format!("path --mode equibiaxial --from 0.8 --to 1.4 {SOFTENING} set method=tlsph");
    let answer = document(&line);
    assert_close(number(&answer, "/loading/from"), 0.88265, 2e-5);
    assert!(answer["loading"]["starts_late"].is_string());
    let line = format!("path --mode equibiaxial --from 1.3 --to 1.4 {SOFTENING} set method=tlsph");
    assert_eq!(onset_line(&line).code, Some(2));
}

#[test]
fn path_and_criteria_report_a_loss_of_ellipticity_at_a_fold() {
    let line = format!(
        "path --mode uniaxial --lateral plane-strain --to 1.6 {SOFTENING} set method=tlsph set penalty=0.5"
    );
    let answer = document(&line);
    assert_close(number(&answer, "/material_onset/stretch/0"), 1.46383, 2e-5);
    assert_eq!(
        numbers(&answer, "/material_onset/direction")
            .iter()
            .map(|x| x.abs().round())
            .collect::<Vec<_>>(),
        [0.0, 1.0]
    );
    let answer = document(&format!(
        "criteria --mode equibiaxial --range 0.7,1.5 {SOFTENING}"
    ));
    let ellipticity = &answer["loadings"][0]["criteria"][0];
    assert_close(
        ellipticity["tension"]["limit"].as_f64().expect("lost"),
        1.20989,
        2e-5,
    );
    let wave = &ellipticity["tension"]["changes"][0]["witness"];
    assert_close(
        wave["direction"][2].as_f64().expect("a number").abs(),
        1.0,
        1e-9,
    );
    assert_eq!(answer["loadings"][0]["tension_end"]["fold"], true);
}

#[test]
fn simple_shear_is_given_by_its_amount() {
    let line = "path --mode simple-shear --lateral plane-strain --to 2 --set material.model=blatz-ko set method=tlsph set penalty=0.4";
    let told = onset_line(line).stdout;
    assert!(told.contains("from amount of shear 0 to 2."), "{told}");
    assert!(told.contains("gamma = 1.41421 (s12 = "), "{told}");
    let answer = document(line);
    assert_close(
        number(&answer, "/material_onset/imposed"),
        2.0_f64.sqrt(),
        1e-9,
    );
    assert_close(numbers(&answer, "/to/0")[1], 2.0, 1e-15);
    let back = document(&line.replace("--to 2", "--from 0.5 --to=-1.2"));
    assert_close(numbers(&back, "/to/0")[1], -1.2, 1e-14);
}

#[test]
fn the_table_covers_the_law_where_the_method_is_undefined() {
    let line = "path --from 1,1 --to 3,1 --set discretization.frame=eulerian --set discretization.support=1.6 --format csv";
    let table = onset_line(line).stdout;
    let rows: Vec<Vec<&str>> = table.lines().map(|row| row.split(',').collect()).collect();
    let place = |name: &str| {
        rows[0]
            .iter()
            .position(|one| *one == name)
            .expect("a column")
    };
    let undefined = rows
        .iter()
        .filter(|row| row[place("verdict")] == "undefined");
    assert!(undefined.count() > 5);
    for row in &rows[1..] {
        for name in ["minimum_acoustic_eigenvalue", "s11", "s12"] {
            assert!(row[place(name)].parse::<f64>().is_ok(), "{name}: {row:?}");
        }
    }
    // The law itself loses ellipticity at 2.7546.
    let last = &rows[97][place("minimum_acoustic_eigenvalue")];
    assert!(last.parse::<f64>().expect("a number") < 0.0);
}

#[test]
fn three_stretches_in_two_dimensions_note_that_waves_are_planar() {
    let told = onset_line("state --stretch 1.2,1,1 set method=tlsph").stdout;
    let note =
        "plane strain, in-plane waves; for 3D: --set discretization.lattice=face-centered-cubic";
    assert!(told.contains(note), "{told}");
    assert!(
        !onset_line("state --stretch 1.2,1 set method=tlsph")
            .stdout
            .contains(note)
    );
    for (method, setting) in [
        ("finite-elements", "mesh=bricks"),
        ("material-points", "lattice=simple-cubic"),
    ] {
        let line = format!("state --stretch 1.2,1,1 --set discretization.method={method}");
        let told = onset_line(&line).stdout;
        assert!(
            told.contains(&format!("for 3D: --set discretization.{setting}")),
            "{told}"
        );
        let answer = onset_line(&format!("{line} --set discretization.{setting}"));
        assert_eq!(answer.code, Some(0), "{}", answer.stderr);
        assert!(!answer.stdout.contains("for 3D"));
    }
}

#[test]
fn planar_tension_of_an_isotropic_law_is_reported_once() {
    let titles = |line: &str| -> Vec<String> {
        let answer = document(line);
        let loadings = answer["loadings"].as_array().expect("loadings").iter();
        loadings
            .map(|one| one["title"].as_str().expect("a title").to_owned())
            .collect()
    };
    let isotropic = titles("card --set material.model=blatz-ko --range 0.5,2");
    assert_eq!(isotropic.len(), 10);
    let own: Vec<&String> = isotropic
        .iter()
        .filter(|title| title.starts_with("planar tension"))
        .collect();
    assert_eq!(own, ["planar tension (pure shear)"]);
    let fibers = titles("card --set material.model=holzapfel-gasser-ogden --range 0.9,1.1");
    assert_eq!(fibers.len(), 11);
}
