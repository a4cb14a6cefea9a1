//! Alternative words and moduli as users type them.

use super::{Scratch, assert_close, document, number, onset, onset_line};

/// Verdict and all numbers of an answer, without its settings.
fn numbers_of(line: &str) -> serde_json::Value {
    document(line)["discretization"].clone()
}

#[test]
fn aliases_give_the_same_answers_as_the_names() {
    for (typed, own) in [
        ("set method=tlsph", "set method=total-lagrangian-sph"),
        ("set method=TLSPH", "set method=total-lagrangian-sph"),
        ("set method=ulsph", "set method=updated-sph"),
        ("set method=mpm", "set method=material-points"),
        ("set method=fem", "set method=finite-elements"),
        ("set method=rkpm", "set approximation=mls"),
        ("set dx=0.5", "set spacing=0.5"),
        ("set kernel=cubic", "set kernel=cubic-spline"),
        (
            "set method=total_lagrangian_sph",
            "set method=total-lagrangian-sph",
        ),
    ] {
        let line = |what: &str| format!("state --stretch 1.05,0.98 {what}");
        assert_eq!(numbers_of(&line(typed)), numbers_of(&line(own)), "{typed}");
    }
    for (typed, own) in [
        ("fcc", "face-centered-cubic"),
        ("bcc", "body-centered-cubic"),
        ("hcp", "hexagonal-close-packed"),
        ("cubic", "simple-cubic"),
    ] {
        let line = format!(
            "dispersion --stretch 1,1,1 --wave-vector 0.1,0.2,0.3 set method=tlsph set lattice={typed}"
        );
        let settings = &document(&line)["settings"];
        assert_eq!(settings["discretization.lattice"]["value"], own);
        assert_eq!(
            settings["discretization.method"]["value"],
            "total-lagrangian-sph"
        );
    }
}

#[test]
fn settings_in_effect_are_listed_under_their_names() {
    let text = onset_line("state --stretch 1.05,0.98 set method=tlsph").stdout;
    assert!(
        text.contains("total-lagrangian-sph") && !text.contains("tlsph"),
        "{text}"
    );
    let text = onset_line(
        "state --stretch 1.05,0.98 --all set smoothing-length=1.3 set kernel=cubic-spline",
    )
    .stdout;
    assert!(text.contains("support 2.6"), "{text}");
}

#[test]
fn ambiguous_words_list_their_meanings_and_typos_the_nearest_name() {
    for (line, facts) in [
        (
            "set method=sph",
            vec![
                "can be `total-lagrangian-sph`",
                "or `updated-sph`",
                "say which",
            ],
        ),
        (
            "set kernel=wendland",
            vec!["`wendland-c2`", "`wendland-c4`", "`wendland-c6`"],
        ),
        (
            "set method=tlpsh",
            vec!["did you mean `total-lagrangian-sph`?"],
        ),
        ("set lattice=hexgonal", vec!["did you mean `hexagonal`?"]),
        (
            "set metod=fem",
            vec!["did you mean `discretization.method`?"],
        ),
        (
            "--set material.model=neohook",
            vec!["did you mean `neo-hooke`?"],
        ),
        (
            "--set material.youngs-modulus=3",
            vec!["did you mean `material.young`?"],
        ),
        ("--set young=3", vec!["did you mean `material.young`?"]),
        (
            "--set material.type=blatz-ko",
            vec!["did you mean `material.model`?"],
        ),
    ] {
        let answer = onset_line(&format!("state --stretch 1,1 {line}"));
        assert_eq!(answer.code, Some(2), "{line}");
        for fact in facts {
            assert!(answer.stderr.contains(fact), "{line}: {}", answer.stderr);
        }
    }
}

#[test]
fn files_and_comparisons_accept_the_same_aliases() {
    let place = Scratch::new("methods.toml");
    let text = "[material]\nmodel = \"neo-hookean\"\nyoung = 2.5\npoisson = 0.25\n[discretization]\nlattice = \"square\"\n\
                smoothing-length = 1.2\n[compare]\nstates = 2\n[[methods]]\nname = \"a\"\nmethod = \"tlsph\"\n\
                [[methods]]\nname = \"b\"\nmethod = \"fem\"\n";
    std::fs::write(&place, text).expect("a file");
    let table = document(&format!("compare {} --quiet", place.display()));
    let rows = table["rows"].as_array().expect("rows");
    let method = |n: usize| rows[n]["settings"]["discretization.method"]["value"].clone();
    assert_eq!(
        (method(0), method(1)),
        ("total-lagrangian-sph".into(), "finite-elements".into())
    );
    assert_close(
        number(&rows[0]["settings"], "/discretization.support/value"),
        2.4,
        1e-15,
    );
    assert_close(
        number(&rows[0]["settings"], "/material.mu/value"),
        1.0,
        1e-14,
    );
    std::fs::write(&place, text.replace("\"tlsph\"", "\"sph\"")).expect("a file");
    let refused = onset(&["compare", &place.display().to_string()]);
    assert_eq!(refused.code, Some(2));
    assert!(refused.stderr.contains(":12:10: "), "{}", refused.stderr);
}

#[test]
fn the_smoothing_length_follows_the_kernel_and_is_set_once() {
    let support = |line: &str| {
        let settings = document(&format!("modes {line}"))["settings"].clone();
        number(&settings, "/discretization.support/value")
    };
    assert_close(support("set smoothing-length=1.2"), 2.4, 1e-15);
    // The quintic spline ends at 3 h, for either order of the two settings.
    assert_close(
        support("set smoothing-length=1.2 set kernel=quintic-spline"),
        3.6,
        1e-15,
    );
    assert_close(
        support("set kernel=quintic-spline set smoothing-length=1.2"),
        3.6,
        1e-15,
    );
    let twice = onset_line("modes set smoothing-length=1.2 set support=2");
    assert_eq!(twice.code, Some(2));
    assert!(twice.stderr.contains("not both"), "{}", twice.stderr);
    let unread = onset_line("modes set method=fem set smoothing-length=1.2");
    assert_eq!(unread.code, Some(2));
    assert!(unread.stderr.contains("has no effect"), "{}", unread.stderr);
    let wrong = onset_line("modes set smoothing-length=-1");
    assert!(
        wrong.stderr.contains("a positive number"),
        "{}",
        wrong.stderr
    );
}

#[test]
fn moduli_determine_a_law_and_are_listed_in_its_state() {
    let line = "state --stretch 1,1 --set material.model=neo-hooke --set material.young=210 --set material.poisson=0.3";
    let answer = document(line);
    assert_close(
        number(&answer, "/material/parameters/mu"),
        210.0 / 2.6,
        1e-14,
    );
    assert_close(
        number(&answer, "/material/parameters/lambda"),
        210.0 * 0.3 / (1.3 * 0.4),
        1e-13,
    );
    // Moduli C1212 and C1111 at F = 1.
    assert_close(
        number(&answer, "/material/tangent/0/1/0/1"),
        210.0 / 2.6,
        1e-12,
    );
    let c1111 = 210.0 * 0.7 / (1.3 * 0.4);
    assert_close(number(&answer, "/material/tangent/0/0/0/0"), c1111, 1e-12);
    for (more, fact) in [
        (
            "--set material.mu=3",
            "material.mu is set, but also follows from the moduli",
        ),
        ("--set material.bulk=3", "two of material.young"),
    ] {
        let refused = onset_line(&format!("{line} {more}"));
        assert_eq!(refused.code, Some(2));
        assert!(refused.stderr.contains(fact), "{}", refused.stderr);
    }
    let alone = onset_line("criteria --set material.model=neo-hooke --set material.young=3");
    assert_eq!(alone.code, Some(2));
    assert!(
        alone.stderr.contains("material.young alone"),
        "{}",
        alone.stderr
    );
}

#[test]
fn poissons_ratio_can_be_an_axis() {
    let place = Scratch::new("study.toml");
    let text = "[material]\nmodel = \"neo-hooke\"\nyoung = 1.0\n[discretization]\nmethod = \"fem\"\n\
                [[axes]]\nquantity = \"stretch-1\"\nrange = [0.9, 1.1]\nstates = 3\n\
                [[axes]]\nquantity = \"material.poisson\"\nrange = [0.1, 0.4]\nstates = 3\n";
    std::fs::write(&place, text).expect("a file");
    let file = place.display().to_string();
    let checked = document(&format!("check {file}"));
    assert_eq!(checked[0]["valid"], true, "{checked}");
    let store = Scratch::new("map.zarr");
    let mapped = document(&format!("map {file} --out {}", store.display()));
    assert_eq!(number(&mapped, "/verdicts/stable/states"), 9.0);
}
