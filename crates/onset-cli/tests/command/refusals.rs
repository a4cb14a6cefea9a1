//! Checks that invalid input ends with exit code 2, no standard output, and a message with the reason.

use crate::{Written, onset, onset_line};

#[track_caller]
fn assert_refused(arguments: &[&str], facts: &[&str]) {
    let answer = onset(arguments);
    let told = &answer.stderr;
    assert_eq!(answer.code, Some(2), "{arguments:?}: {told}");
    assert_eq!(answer.stdout, "", "{arguments:?}");
    assert!(told.starts_with("error: "), "{arguments:?}: {told}");
    assert!(!told.contains("panicked"), "{arguments:?}: {told}");
    for fact in facts {
        assert!(told.contains(fact), "{arguments:?}: no `{fact}` in: {told}");
    }
}

#[track_caller]
fn assert_line_refused(line: &str, facts: &[&str]) {
    let words = crate::words(line);
    assert_refused(&words.iter().map(String::as_str).collect::<Vec<_>>(), facts);
}

/// `onset state` at a valid state, with assignments.
#[track_caller]
fn assert_assignment_refused(assignments: &[&str], facts: &[&str]) {
    let mut arguments = vec!["state", "--stretch", "1.2,0.9"];
    for assignment in assignments {
        arguments.extend(["--set", assignment]);
    }
    assert_refused(&arguments, facts);
}

#[test]
fn refused_numbers_are_printed_as_they_are_written() {
    let five = [
        "discretization.method=material-points",
        "discretization.points-per-side=5",
        "discretization.layout=gauss",
    ];
    assert_assignment_refused(&five, &["points-per-side is 5; expected"]);
    assert_line_refused("state --stretch 1,-1", &["stretch 2 is -1; a stretch"]);
}

#[test]
fn unknown_keys_get_the_nearest_known_key_as_a_hint() {
    for (assignment, nearest) in [
        ("discretization.suport=2", "`discretization.support`"),
        ("discretisation.support=2", "`discretization.support`"),
        ("discretization.frme=eulerian", "`discretization.frame`"),
        ("material.modell=blatz-ko", "`material.model`"),
        ("material.c3=1", "`material.c2`"),
        (
            "discretization.per-side=5",
            "`discretization.points-per-side`",
        ),
    ] {
        assert_assignment_refused(&[assignment], &["unknown key", "did you mean", nearest]);
    }
    assert_assignment_refused(&["zzz=1"], &["known keys", "discretization"]);
    assert_assignment_refused(&["=1"], &["unknown key"]);
}

#[test]
fn unsupported_combinations_are_refused_with_the_supported_combinations() {
    assert_assignment_refused(
        &[
            "discretization.method=updated-sph",
            "discretization.artificial-stress=0.3",
            "discretization.momentum=difference",
        ],
        &["an artificial stress", "choose the form \"symmetric\""],
    );
    assert_assignment_refused(
        &["discretization.kernel=(1-q)^3#"],
        &[
            "`#` has no meaning in a formula",
            "hint: a formula has numbers",
        ],
    );
}

#[test]
fn unknown_words_are_refused_with_the_known_words() {
    for (assignment, expected) in [
        (
            "discretization.frame=lagrangan",
            "did you mean `lagrangian`",
        ),
        ("discretization.frame=3", "lagrangian | eulerian"),
        ("discretization.frame=", "lagrangian | eulerian"),
        ("discretization.kernel=cubics", "quartic-spline"),
        ("discretization.quadrature=gaus", "did you mean `gauss`"),
        ("discretization.quadrature=3", "nodal | stress-points"),
        ("discretization.approximation=mls-4", "`mls-3`"),
        ("discretization.support-size=scale", "`scaled`"),
        ("discretization.linearization=papr", "`paper`"),
        ("material.model=blatzko", "`blatz-ko`"),
        ("discretization.support=two", "expected a positive number"),
        ("discretization.support=2,5", "expected a positive number"),
        ("discretization.support=", "expected a positive number"),
    ] {
        assert_assignment_refused(&[assignment], &["hint: expected", expected]);
    }
}

#[test]
fn a_formula_that_is_not_a_kernel_is_refused_with_the_position_of_the_error() {
    assert_assignment_refused(
        &["discretization.kernel=(1 - r)^3"],
        &["column 6", "the variable is `q`", "hint"],
    );
    assert_assignment_refused(
        &["discretization.kernel=exp(-9*q^2)"],
        &["must vanish there", "hint: multiply by (1 - q)^3"],
    );
}

#[test]
fn parameters_of_another_model_are_refused() {
    let facts = ["has no parameter `mu`", "c1, c2, lambda", "material.model"];
    assert_assignment_refused(&["material.mu=3"], &facts);
    assert_assignment_refused(
        &["material.model=blatz-ko", "material.c1=3"],
        &["blatz-ko has no parameter `c1`", "mu"],
    );
}

#[test]
fn assignments_without_a_value_show_how_to_write_one() {
    for text in ["discretization.support", "x", ""] {
        assert_assignment_refused(
            &[text],
            &["is not an assignment", "--set discretization.support=1.6"],
        );
    }
}

#[test]
fn the_right_number_of_positive_finite_stretches_is_required() {
    for (text, fact) in [
        ("-1,1", "stretch 1 is -1"),
        ("0,1", "stretch 1 is 0"),
        ("1,-0.5", "stretch 2 is -0.5"),
        ("1,1,0", "stretch 3 is 0"),
        ("nan,1", "must be finite"),
        ("inf,1", "must be finite"),
        ("1,-inf", "must be finite"),
        ("1e400,1", "must be finite"),
        ("", "is not a number"),
        ("1,", "is not a number"),
        (",", "is not a number"),
        ("a,b", "`a` is not a number"),
        ("1;2", "`1;2` is not a number"),
        ("1 2", "`1 2` is not a number"),
        ("--", "`--` is not a number"),
        ("0x1,1", "`0x1` is not a number"),
        ("1", "has 1 number; expected 2"),
        ("1,1,1,1", "has 4 numbers"),
        ("1e-160,1e-160", "too extreme"),
        ("1e-320,1", "too extreme"),
        ("1e150,1e150", "too extreme"),
        ("1e-160,1", "too extreme"),
        ("1e-320,1e308", "too extreme"),
    ] {
        assert_refused(&["state", &format!("--stretch={text}")], &[fact]);
        assert_refused(&["state", "--json", &format!("--stretch={text}")], &[fact]);
        let path = ["path", "--from=1,1.1", &format!("--to={text}")];
        assert_refused(&path, &[]);
    }
    assert_line_refused("state --stretch -1,1", &["stretch 1 is -1"]);
}

#[test]
fn a_chain_takes_one_to_three_stretches_and_no_more() {
    for stretches in ["1.2", "1.2,0.9", "1.2,0.9,1.1"] {
        let line = format!("state --stretch {stretches} set lattice=chain");
        assert_eq!(onset_line(&line).code, Some(0), "{line}");
    }
    assert_line_refused(
        "state --stretch 1.2,1,1,1 set lattice=chain",
        &["has 4 numbers; expected 1"],
    );
    assert_line_refused(
        "state --deformation-gradient 1,0,0,1 set lattice=chain",
        &["has 4 numbers; expected 1 or 9"],
    );
}

#[test]
fn deformation_gradients_must_be_orientation_preserving_and_planar() {
    for (text, fact) in [
        ("1,0,0,-1", "det F = -1; it must be positive"),
        ("0,1,1,0", "det F = -1; it must be positive"),
        ("1,1,1,1", "det F = 0; it must be positive"),
        ("1,0,0,0,1,0,0,0,-1", "det F = -1"),
        ("1,0", "has 2 numbers; expected 4"),
        ("1,0,0", "has 3 numbers; expected 4"),
        ("1,0,0,1,1", "has 5 numbers; expected 4"),
        ("1,0,0,0,1,0,0,0", "has 8 numbers; expected 4"),
        ("", "is not a number"),
        ("a,0,0,1", "`a` is not a number"),
        ("nan,0,0,1", "must be finite"),
        ("1,inf,0,1", "must be finite"),
        ("1e-200,0,0,1e-200", "too extreme"),
        ("1,0,0.5,0,1,0,0,0,1", "plane strain"),
    ] {
        assert_refused(
            &["state", &format!("--deformation-gradient={text}")],
            &[fact],
        );
    }
}

#[test]
fn supports_that_hold_too_few_or_too_many_particles_are_refused() {
    let too_few = [
        "1 particle(s) within the support radius",
        "at least 3",
        "hint: enlarge",
    ];
    for support in ["0.9", "1"] {
        assert_assignment_refused(&[&format!("discretization.support={support}")], &too_few);
    }
    for support in ["1e3", "1e4"] {
        assert_assignment_refused(
            &[&format!("discretization.support={support}")],
            &["allowed", "hint: reduce"],
        );
    }
}

#[test]
fn shape_functions_without_enough_neighbors_are_refused() {
    for frame in ["lagrangian", "eulerian"] {
        assert_line_refused(
            &format!(
                "state --stretch 1.2,0.9 set approximation=mls set support=0.9 set frame={frame}"
            ),
            &["at least 3", "hint: enlarge"],
        );
    }
    assert_line_refused(
        "state --stretch 3,1 set approximation=mls set support=1.6 set frame=eulerian",
        &["at least 3", "support-size=scaled"],
    );
    assert_line_refused(
        "state --stretch 2.1,0.9 set approximation=mls set frame=eulerian set lattice=square set quadrature=nodal",
        &["do not determine its shape functions", "hint: enlarge"],
    );
}

#[test]
fn numbers_of_the_discretization_must_be_positive_and_finite() {
    for key in ["support", "spacing", "density"] {
        for value in ["0", "-0.0", "-1", "nan", "inf", "-inf", "1e400"] {
            assert_assignment_refused(
                &[&format!("discretization.{key}={value}")],
                &[
                    &format!("discretization.{key}"),
                    "cannot be",
                    match key {
                        "support" => "expected a positive number from 0.001 to 10000",
                        _ => "expected a positive number from 1e-20 to 1e20",
                    },
                ],
            );
        }
    }
    for value in ["1e-200", "1e200", "1e-320"] {
        assert_assignment_refused(&[&format!("discretization.spacing={value}")], &["spacing"]);
    }
}

#[test]
fn parameters_of_the_material_must_be_admissible() {
    for (assignment, fact) in [
        ("material.c1=-1", "c1 + c2 is"),
        ("material.c1=-0.01012", "c1 + c2 is 0"),
        ("material.c2=-0.2", "c1 + c2 is"),
        ("material.c1=1e21", "c1 is 1e21"),
    ] {
        assert_assignment_refused(&[assignment], &["material parameter", fact, "expected"]);
    }
    for mu in ["-1", "0", "1e-21", "1e21"] {
        assert_assignment_refused(
            &["material.model=blatz-ko", &format!("material.mu={mu}")],
            &[
                "material parameter mu",
                "expected a positive number from 1e-20 to 1e20",
            ],
        );
    }
    for (assignment, fact) in [
        ("material.c1=nan", "`material.c1` cannot be NaN"),
        ("material.c2=inf", "`material.c2` cannot be inf"),
        ("material.lambda=1e400", "`material.lambda` cannot be inf"),
    ] {
        assert_assignment_refused(
            &[assignment],
            &[fact, "expected a number from -1e20 to 1e20 (stress)"],
        );
    }
}

#[test]
fn wave_vectors_must_have_the_dimension_of_the_lattice() {
    for (text, fact) in [
        ("1", "has 1 number; expected 2"),
        ("1,1,1", "has 3 numbers; expected 2"),
        ("nan,1", "must be finite"),
        ("inf,0", "must be finite"),
        ("1e400,0", "must be finite"),
        ("a,b", "`a` is not a number"),
        ("", "is not a number"),
    ] {
        let wave_vector = format!("--wave-vector={text}");
        assert_refused(
            &["dispersion", "--stretch", "1.2,0.9", &wave_vector],
            &["--wave-vector", fact],
        );
    }
    assert_line_refused(
        "dispersion --stretch 1.2 --wave-vector 1,1 set lattice=chain",
        &["has 2 numbers; expected 1"],
    );
    assert_line_refused("dispersion --stretch 1,1", &["--wave-vector", "--path"]);
    assert_line_refused(
        "dispersion --stretch 1,1 --path --wave-vector 1,1",
        &["--path"],
    );
}

#[test]
fn paths_require_different_ends_and_admissible_deformations_between_them() {
    for line in [
        "path --from 1,1 --to 1,1",
        "path --from 1,1 --to 1,1,1",
        "path --from 1.5,1 --to 1.5,0,0,1",
    ] {
        assert_line_refused(line, &["are equal"]);
    }
    let through_zero = ["leaves the admissible deformations at s = 0.5", "det F"];
    assert_line_refused("path --from 1,0,0,1 --to -1,0,0,-1", &through_zero);
    assert_line_refused("path --from=-1,0,0,-1 --to=1,0,0,1", &through_zero);
    for (line, fact) in [
        ("path --from 1 --to 1,2", "has 1 number"),
        ("path --from 1,1 --to 1,0,0,1,1", "has 5 numbers"),
        ("path --from 1,1 --to 1,nan", "must be finite"),
        ("path --from 1,1 --to b,1", "`b` is not a number"),
        ("path --from 1,1 --to -1,1", "stretch 1 is -1"),
        ("path --from 1,0,0,1 --to 0,1,1,0", "det F = -1"),
        ("path --from 1,1", "--to"),
        ("path --to 1,1", "--from"),
    ] {
        assert_line_refused(line, &[fact]);
    }
}

#[test]
fn exactly_one_state_is_required() {
    assert_line_refused("state", &["--stretch", "--deformation-gradient"]);
    assert_line_refused(
        "state --stretch 1,1 --deformation-gradient 1,0,0,1",
        &["cannot be used with"],
    );
    assert_line_refused("state --stretch 1,1 --stretch 1,2", &["multiple times"]);
    assert_line_refused(
        "state --stretch 1.2 0.9",
        &[
            "cannot read 0.9",
            "commas between them, for example 1.2,0.9",
        ],
    );
}

#[test]
fn unknown_commands_and_options_get_the_nearest_known_name_as_a_hint() {
    assert_line_refused("stat", &["unrecognized subcommand 'stat'", "'state'"]);
    assert_line_refused("state --strech 1,1", &["--strech", "'--stretch'"]);
    assert_line_refused("reproduce --set a=b", &["unexpected argument '--set'"]);
    let nothing = onset(&[]);
    assert_eq!(nothing.code, Some(2));
    assert!(nothing.stderr.contains("Usage: onset [OPTIONS] <COMMAND>"));
}

#[test]
fn a_folder_for_figures_needs_a_figure() {
    assert_line_refused(
        "dispersion --stretch 1,1 --wave-vector 1,1 --out figures",
        &["cannot be used with '--out <DIR>'"],
    );
}

#[test]
fn hints_on_parameters_do_not_blame_the_deformation() {
    for assignments in [
        &["material.c1=-1"][..],
        &["material.c1=nan"],
        &["material.model=blatz-ko", "material.mu=0"],
    ] {
        let mut arguments = vec!["state", "--stretch", "1.2,0.9"];
        for assignment in assignments {
            arguments.extend(["--set", assignment]);
        }
        let answer = onset(&arguments);
        assert_eq!(answer.code, Some(2));
        assert!(
            !answer.stderr.contains("extreme deformation"),
            "{}",
            answer.stderr
        );
    }
}

#[test]
fn a_support_overfilled_by_compression_gets_a_hint_to_follow_the_particles() {
    assert_line_refused(
        "state --stretch 0.01,0.01 set frame=eulerian",
        &["allowed", "support-size=scaled"],
    );
}

#[test]
fn messages_print_extreme_numbers_with_an_exponent() {
    for assignment in [
        "discretization.spacing=1e-200",
        "discretization.spacing=1e200",
        "discretization.support=1e300",
    ] {
        let answer = onset(&["state", "--stretch", "1.2,0.9", "--set", assignment]);
        assert_eq!(answer.code, Some(2));
        let zeros = "0".repeat(20);
        assert!(!answer.stderr.contains(&zeros), "{}", answer.stderr);
    }
}

#[test]
fn wave_vectors_beyond_double_precision_are_refused() {
    assert_line_refused(
        "dispersion --stretch 1.2,0.9 --wave-vector 1e300,1",
        &["the wave vector is too large"],
    );
}

#[test]
fn deformations_beyond_double_precision_are_refused() {
    for stretches in ["1e150,1", "1e150,1e-150", "1,1,1e150"] {
        assert_line_refused(&format!("state --stretch {stretches}"), &["too extreme"]);
    }
}

#[test]
fn unknown_quadratures_are_refused() {
    for (assignments, fact) in [
        (
            ["quadrature=points", "points=[0,0,0.5,0.5,0.5,0.4]"],
            "must add up to 1",
        ),
        (
            ["quadrature=points", "points=[0,0]"],
            "2 lattice coordinate(s)",
        ),
        (["quadrature=points", "points=[]"], "has 0 number(s)"),
        (
            ["quadrature=points", "points=[0,0,1.5,0.5,0.5,-0.5]"],
            "point 2 of discretization.points has -0.5 as its weight",
        ),
        (
            ["quadrature=points", "points=half"],
            "expected a list of numbers",
        ),
        (["quadrature=gauss", "gauss-points=5"], "from 1 to 4"),
        (["quadrature=gauss", "gauss-points=1.5"], "from 1 to 4"),
        (
            ["quadrature=stress-points", "stress-point-weight=1.5"],
            "above 0 and below 1",
        ),
        (
            ["quadrature=nodal-stabilized", "frame=eulerian"],
            "needs discretization.frame = \"lagrangian\"",
        ),
    ] {
        let assignments = assignments.map(|assignment| format!("discretization.{assignment}"));
        let assignments = assignments.each_ref().map(String::as_str);
        assert_assignment_refused(&assignments, &[fact]);
    }
}

#[test]
fn a_range_without_any_method_gets_a_hint_to_choose_another() {
    let facts = ["from 0 to 1", "--range LOW,HIGH"];
    assert_line_refused("tune discretization.support --quiet", &facts);
}

#[test]
fn misspelled_words_get_the_right_words_as_a_hint() {
    for (line, meant) in [
        ("path --mode uniaxal --to 2", "uniaxial"),
        (
            "path --mode uniaxial --lateral plane-stran --to 2",
            "plane-strain",
        ),
        ("card block.inp --from abacus", "abaqus"),
        ("list materails", "materials"),
        ("state --stretch 1,1 --fail-on numeric", "numerical"),
        (
            "simulate --stretch 1,1 --integrator kick-drift",
            "kick-drift-kick",
        ),
        (
            "verify deck --code lammps-smd-tlsf --wave-vector 1,0 --out deck",
            "lammps-smd-tlsph",
        ),
    ] {
        assert_line_refused(line, &[&format!("did you mean `{meant}`?")]);
    }
}

#[test]
fn single_stretches_and_decimal_commas_get_a_hint() {
    for (line, fact) in [
        (
            "state --stretch 1.2",
            "hint: --stretch 1.2,1 stretches along axis 1",
        ),
        (
            "state --stretch 1.2 set lattice=face-centered-cubic",
            "hint: --stretch 1.2,1,1 stretches along axis 1",
        ),
        (
            "state --stretch 1,2,0,9",
            "commas between numbers: --stretch 1.2,0.9",
        ),
        (
            "state --deformation-gradient 1,1,0,2,0,0,0,9",
            "--deformation-gradient 1.1,0.2,0.0,0.9",
        ),
        ("path --from 1 --to 1.2,1", "--from 1,1"),
    ] {
        assert_line_refused(line, &[fact]);
    }
    let other = onset_line("state --stretch 1.2,1,1,1");
    assert!(!other.stderr.contains("hint"), "{}", other.stderr);
}

#[test]
fn an_invalid_modulus_is_reported_where_it_is_set() {
    assert_line_refused(
        "state --stretch 1,1 --set material.model=neo-hooke --set material.young=-2 --set material.poisson=0.3",
        &["--set material.young=-2: material.young is -2"],
    );
}

#[test]
fn errors_of_a_law_are_reported_with_their_position() {
    let negative = "--set material.model=neo-hooke --set material.mu=-1";
    for command in ["criteria", "card", "audit"] {
        assert_line_refused(&format!("{command} {negative}"), &["--set material.mu=-1"]);
    }
    let study = Written::new("law.toml", "[material]\nmodel = \"neo-hooke\"\nmu = -1\n");
    assert_line_refused(&format!("criteria {}", &*study), &["law.toml:3:"]);
    let line = "limit --vary material.c1 --time-step 0.1 --set material.model=neo-hooke";
    assert_line_refused(line, &["neo-hooke has no parameter `c1`"]);
}

#[test]
fn a_value_that_no_method_allows_is_not_compared() {
    let text = "[[methods]]\nname = \"one\"\nmethod = \"total-lagrangian-sph\"\npenalty = -1\n";
    let study = Written::new("methods.toml", text);
    assert_line_refused(
        &format!("compare {}", &*study),
        &[
            "methods.toml:4:",
            "`discretization.penalty` cannot be -1; expected a number from 0",
        ],
    );
}

#[test]
fn an_option_without_effect_is_refused() {
    let patch = "simulate --stretch 1.2,0.9 --cells 4 --steps 10";
    assert_line_refused(
        &format!("{patch} --seed 3"),
        &["--seed has no effect", "--mode noise"],
    );
    assert_line_refused(&format!("{patch} --fields 3"), &["--out"]);
    assert_line_refused(
        "localize --model j2 --set material.model=gurson",
        &["two values of material.model"],
    );
    assert_line_refused(
        "localize --path triaxial-compression --load tension",
        &["plasticity.load"],
    );
    // Tests have no standard input.
    assert_line_refused(
        "state --stretch 1.1,1 -",
        &["standard input is empty", "expected a study"],
    );
}

/// Maps show a word for undefined states, and commands fail on this word consistently.
#[test]
fn an_undefined_state_fails_on_request() {
    let line = "state --stretch 4,4 --set discretization.frame=eulerian";
    assert_line_refused(line, &["within the support radius"]);
    let failed = onset_line(&format!("{line} --fail-on undefined"));
    assert_eq!(failed.code, Some(3), "{}", failed.stderr);
    assert!(
        failed.stderr.contains("1 state is undefined"),
        "{}",
        failed.stderr
    );
}

/// A study for maps contains a state that other commands do not read.
#[test]
fn a_state_without_effect_is_reported() {
    let study = Written::new("study.toml", "[state]\nstretch-3 = 1.3\n");
    for line in [
        "state --stretch 1.1,1",
        "path --mode equibiaxial --to 1.1",
        "dispersion --stretch 1.1,1 --wave-vector 1,1",
    ] {
        let answer = onset_line(&format!("{line} {}", &*study));
        assert_eq!(answer.code, Some(0), "{}", answer.stderr);
        assert!(
            answer.stderr.contains("study.toml:2:") && answer.stderr.contains("`state.stretch-3`"),
            "{line}: {}",
            answer.stderr
        );
    }
}

/// An undefined state is not stable.
#[test]
fn an_undefined_path_is_not_reported_as_stable() {
    let law = "--set material.model=gent --set material.jm=1 set method=tlsph set lattice=square set penalty=0.5";
    let told = onset_line(&format!("path --from 2.6,2.6 --to 3,3 {law}")).stdout;
    for fact in [
        "The law is not defined at any state of the path.",
        "The discretization cannot be evaluated at any state of the path.",
    ] {
        assert!(told.contains(fact), "{told}");
    }
    let partly = onset_line(&format!("path --from 1,1 --to 3,3 {law}")).stdout;
    assert!(
        partly.contains("stable along the whole path, where it is defined."),
        "{partly}"
    );
}

#[test]
fn errors_of_long_arguments_have_at_most_2000_characters() {
    let long = "S".repeat(90_000);
    for arguments in [
        &[long.as_str()][..],
        &["state", "--format", &long],
        &["path", "--mode", &long, "--to", "2"],
        &["map", "rubber.toml", "--fail-on", &long],
        &["state", &format!("--{long}")],
        &["state", "--stretch", &long],
        &["state", "--set", &long],
        &["state", "--format", "\u{1b}[2J"],
    ] {
        let answer = onset(arguments);
        let told = answer.stderr;
        assert_eq!(answer.code, Some(2), "{told}");
        assert!(told.starts_with("error: "), "{told}");
        assert!(
            told.chars().count() <= 2001 && !told.contains('\u{1b}'),
            "{told}"
        );
    }
}
