//! Invalid formulas: the message, the position of the caret and the hint.

use onset::formula::{Formula, FormulaError};

/// Error of a formula when it is read or receives values.
fn refusal(text: &str, values: &[(&str, f64)]) -> FormulaError {
    match Formula::parse(text) {
        Err(error) => error,
        Ok(formula) => formula.with(values).expect_err(text),
    }
}

#[test]
fn an_invalid_formula_is_rejected_with_its_column_and_a_hint() {
    // Formula, column, length of the mark, message, hint.
    let cases: &[(&str, usize, usize, &str, &str)] = &[
        (
            "mu/2*(I1 - 3",
            6,
            1,
            "this parenthesis is not closed",
            "add the missing `)`",
        ),
        ("mu/2*(I1 - 3))", 14, 1, "found `)`", "remove it"),
        (
            "mu/2*(I1 - )",
            12,
            1,
            "expected a number, a name or `(`, found `)`",
            "remove it",
        ),
        ("mu*I1 +", 8, 1, "found the end of the formula", ""),
        ("2mu*I1", 1, 3, "`2mu` is not a number", "2*mu"),
        (
            "1.2.3*I1",
            1,
            5,
            "`1.2.3` is not a number",
            "numbers are written",
        ),
        ("1e999*I1", 1, 5, "`1e999` is not a number", "1.5e-3"),
        ("mu (I1 - 3)", 1, 2, "no function `mu`", "`*`"),
        (
            "2 I1",
            3,
            2,
            "expected an operator or the end of the formula, found `I1`",
            "`*`",
        ),
        (
            "I1(I2 - 3)",
            1,
            2,
            "`I1` is a variable, not a function",
            "I1*(...)",
        ),
        (
            "let a = I1; a(2)",
            13,
            1,
            "`a` is a helper, not a function",
            "a*(...)",
        ),
        ("sqr(I1)", 1, 3, "no function `sqr`", "x^2"),
        (
            "sqrtt(I1)",
            1,
            5,
            "no function `sqrtt`",
            "did you mean `sqrt`",
        ),
        ("log(J)", 1, 3, "no function `log`", "ln"),
        ("I1 + det(C)", 6, 3, "no function `det`", "I3"),
        (
            "sqrt I3",
            1,
            4,
            "`sqrt` is a function and takes one argument",
            "sqrt(...)",
        ),
        (
            "I1 + sqrt(I1, 2)",
            6,
            11,
            "`sqrt` takes one argument, here are 2",
            "commas",
        ),
        (
            "pow(J)",
            1,
            6,
            "`pow` takes two arguments, here are 1",
            "commas",
        ),
        ("if(J < 1, 2)", 1, 12, "three arguments", "commas"),
        (
            "if(J, 1, 2)",
            4,
            1,
            "there is a number where a condition is needed",
            "if(J < 1, a, b)",
        ),
        (
            "J < 1",
            1,
            5,
            "there is a condition where a number is needed",
            "if(condition",
        ),
        (
            "if(1 < J < 2, J, 0)",
            4,
            9,
            "a comparison of a comparison",
            "a < b and b < c",
        ),
        ("if(J == 1, J, 0)", 6, 2, "found `==`", "<="),
        (
            "J < 1 ? J : 0",
            7,
            1,
            "`?` has no meaning",
            "if(condition, value, otherwise)",
        ),
        ("I1**2", 3, 2, "found `**`", "^"),
        ("1,5*I1", 2, 1, "found `,`", "decimals use a point"),
        ("I1 = 3", 4, 1, "found `=`", "let name = "),
        ("a = I1 - 3; a^2", 3, 1, "found `=`", "let name = "),
        (
            "let a = I1 - 3 a^2",
            16,
            1,
            "expected an operator, or `;`",
            "`*`",
        ),
        ("let 2 = I1; J", 5, 1, "expected a name after `let`", ""),
        (
            "let I1 = 3; J",
            5,
            2,
            "`I1` is already a variable",
            "another name",
        ),
        (
            "let exp = J; J",
            5,
            3,
            "`exp` is already a function",
            "another name",
        ),
        (
            "let a = J; let a = 2; a",
            16,
            1,
            "`a` is already the name of a helper",
            "another name",
        ),
        ("let a = J;", 11, 1, "found the end", ""),
        (
            "I1 + let a = J; a",
            6,
            3,
            "found `let`",
            "helpers come first",
        ),
        ("\u{3bc}/2*(I1 - 3)", 1, 1, "`\u{3bc}` has no meaning", "mu"),
        ("I1\u{b2}", 3, 1, "has no meaning", "^"),
        ("I1 \u{2212} 3", 4, 1, "has no meaning", "minus sign as -"),
        ("[I1 - 3]", 1, 1, "`[` has no meaning", "round parentheses"),
        ("|J - 1|", 1, 1, "`|` has no meaning", "abs"),
        ("I1 + $", 6, 1, "`$` has no meaning", ""),
        (
            "mu*(i1 - 3)",
            5,
            2,
            "`i1` has no value",
            "did you mean `I1`",
        ),
        (
            "mu*(I_1 - 3)",
            5,
            3,
            "`I_1` has no value",
            "did you mean `I1`",
        ),
        (
            "mu*I1bra",
            4,
            5,
            "`I1bra` has no value",
            "did you mean `I1bar`",
        ),
        (
            "mu*(F14 - 3)",
            5,
            3,
            "`F14` has no value",
            "did you mean `F",
        ),
        ("mu*I1 + kapa*J", 9, 4, "`kapa` has no value", "kapa = ..."),
        (
            "mu*I1 + 1/(2 - 2)*J",
            9,
            9,
            "inf at every state",
            "division by zero",
        ),
        ("I1 + ln(-2)*J", 6, 6, "NaN at every state", "logarithm"),
        (
            "I1/(mu - 32)",
            1,
            12,
            "NaN at every state",
            "division by zero",
        ),
        ("mu/2 - 3", 1, 8, "does not depend on the deformation", "I1"),
        (
            "mu*(I4 - 1)^2",
            5,
            2,
            "`fiber1-angle` has no value",
            "set fiber1-angle, in degrees",
        ),
        (
            "mu*I7",
            4,
            2,
            "`fiber2-angle` has no value",
            "set fiber2-angle",
        ),
    ];
    for &(text, column, length, message, hint) in cases {
        let values: &[(&str, f64)] = if text.contains("mu") && !text.contains("mu (") {
            &[("mu", 32.0)]
        } else {
            &[]
        };
        let error = refusal(text, values);
        let place = error
            .place
            .as_ref()
            .unwrap_or_else(|| panic!("{text}: no place"));
        assert_eq!(
            (place.column, place.length),
            (column, length),
            "{text}:\n{error}"
        );
        let problem = error.problem.to_string();
        assert!(problem.contains(message), "{text}:\n{error}");
        let proposed = error.problem.hint().unwrap_or_default();
        assert!(proposed.contains(hint), "{text}:\n{error}");
    }
}

#[test]
fn the_whole_message_shows_the_line_and_a_caret() {
    let error = refusal("mu/2*(I2*/I3 - 5)", &[]);
    assert_eq!(
        error.to_string(),
        "energy, column 10: expected a number, a name or `(`, found `/`\n    \
         mu/2*(I2*/I3 - 5)\n             ^"
    );
    let error = refusal("mu*(i1 - 3)", &[("mu", 1.0)]);
    assert_eq!(
        error.to_string(),
        "energy, column 5: `i1` has no value\n    mu*(i1 - 3)\n        ^^\n  \
         hint: did you mean `I1`? Or give the parameter a value: i1 = ..."
    );
}

#[test]
fn the_line_with_the_error_is_shown() {
    let error = refusal("let a = I1 - 3;\n\tlet b = ln(J;\na + b", &[]);
    assert_eq!(
        error.to_string(),
        "energy, line 2, column 12: this parenthesis is not closed\n     let b = ln(J;\n               ^\n  \
         hint: add the missing `)`"
    );
}

#[test]
fn a_long_line_is_cut_around_the_error() {
    let error = refusal(
        &format!("{}$ + {}I1", "J + ".repeat(200), "J + ".repeat(200)),
        &[],
    );
    let text = error.to_string();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(error.place.map(|place| place.column), Some(801));
    assert!(lines[1].len() < 140 && lines[1].contains("...") && lines[1].ends_with("..."));
    let caret = lines[2].find('^').expect("a caret");
    assert_eq!(lines[1].as_bytes()[caret], b'$');
}

#[test]
fn values_without_a_parameter_are_rejected() {
    let formula =
        Formula::parse("let half = mu/2; half*(I1 - 3) + kappa/2*(J - 1)^2").expect("a formula");
    let given = [("mu", 1.0), ("kappa", 2.0)];
    let with = |name, value| {
        let values = [given[0], given[1], (name, value)];
        formula.with(&values).expect_err(name).to_string()
    };
    assert!(formula.with(&given).is_ok());
    let message = with("kapa", 1.0);
    assert!(message.contains("no parameter `kapa`") && message.contains("mu, kappa"));
    assert!(message.contains("did you mean `kappa`"));
    assert!(with("half", 1.0).contains("`half` is a helper of the formula"));
    assert!(with("I1", 1.0).contains("`I1` is a variable"));
    assert!(with("fiber1-angle", 1.0).contains("no parameter `fiber1-angle`"));
    for value in [f64::NAN, f64::INFINITY] {
        let error = formula
            .with(&[("mu", value), ("kappa", 1.0)])
            .expect_err("not finite");
        assert!(error.to_string().contains("parameter mu is"));
    }
}

#[test]
fn an_empty_formula_is_rejected() {
    for text in ["", "   ", "\n\t"] {
        assert!(
            refusal(text, &[])
                .to_string()
                .contains("the formula is empty")
        );
    }
}

#[test]
fn escape_sequences_do_not_reach_the_terminal() {
    for text in ["I1 + \u{1b}[31m", "I1 \u{1b} + foo(", "I1 +\u{7}"] {
        let message = refusal(text, &[]).to_string();
        assert!(
            message.chars().all(|c| !c.is_control() || c == '\n'),
            "{message:?}"
        );
    }
}
