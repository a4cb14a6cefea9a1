//! Kernels given as formulas by the user.

use onset::kernel::{FormulaKernel, Kernel, KernelError};

fn refused(text: &str) -> KernelError {
    text.parse::<Kernel>().expect_err("no kernel")
}

#[test]
fn a_formula_reproduces_the_named_kernel() {
    for (text, kernel) in [
        ("(1 - q)^3*(1 + 3*q)", Kernel::QuarticSpline),
        ("(1 - q)^8*(1 + 8*q + 25*q^2 + 32*q^3)", Kernel::WendlandC6),
        (
            "if(q < 1/2, 1 - 6*q^2 + 6*q^3, 2*(1 - q)^3)",
            Kernel::CubicSpline,
        ),
        (
            "let s = 2*q; if(s < 1, s^3 - 6*s + 6, (2 - s)^3)",
            Kernel::Hyperbolic,
        ),
    ] {
        let typed: Kernel = text.parse().expect("a kernel");
        for n in 0..=300 {
            let q = f64::from(n) / 300.0;
            let (own, built_in) = (typed.profile::<3, f64>(q), kernel.profile::<3, f64>(q));
            let close = |a: f64, b: f64| {
                assert!(
                    (a - b).abs() < 1e-8 * (1.0 + b.abs()),
                    "{text} {q}: {a} {b}"
                )
            };
            close(own.value, built_in.value);
            close(own.slope_over_q, built_in.slope_over_q);
            // At a break the two kernels may use different sides.
            if n != 150 {
                close(own.curvature_over_q, built_in.curvature_over_q);
            }
        }
        assert!((typed.integral::<3>(1.0) / kernel.integral::<3>(1.0) - 1.0).abs() < 1e-9);
        let (told, known) = (typed.smoothness::<3>(), kernel.smoothness::<3>());
        assert_eq!(
            told.origin,
            known.origin.filter(|order| *order < 4),
            "{text}"
        );
        assert_eq!(told.inside, known.inside, "{text}");
        assert_eq!(told.rim, known.rim.filter(|order| *order < 4), "{text}");
    }
}

#[test]
fn formulas_are_accurate_near_the_origin() {
    let typed: Kernel = "(1 - q)^3*(1 + 3*q)".parse().expect("a kernel");
    for q in [0.0, 1e-14, 1e-9, 1e-7, 9.9e-7, 1.1e-6, 1e-4] {
        let (own, known) = (
            typed.profile::<2, f64>(q),
            Kernel::QuarticSpline.profile::<2, f64>(q),
        );
        assert!((own.slope_over_q - known.slope_over_q).abs() < 1e-9, "{q}");
        assert!(
            (own.curvature_over_q - known.curvature_over_q).abs() < 1e-3,
            "{q}"
        );
    }
}

#[test]
fn equal_formulas_give_equal_kernels() {
    let [a, b, c] =
        ["1 - q", " 1 - q ", "1-q"].map(|text| FormulaKernel::parse(text).expect("a kernel"));
    assert_eq!(a, b);
    assert_ne!(a, c);
    assert_eq!(a.text(), "1 - q");
}

#[test]
fn names_are_read_and_written() {
    for kernel in Kernel::ALL {
        assert_eq!(kernel.name().parse::<Kernel>(), Ok(kernel));
        assert!(!kernel.formula().is_empty() && !kernel.source().is_empty());
    }
}

#[test]
fn invalid_kernels_are_rejected_with_the_reason() {
    assert!(matches!(refused("cubic"), KernelError::UnknownName { .. }));
    assert!(matches!(refused("3"), KernelError::UnknownName { .. }));
    assert!(matches!(
        refused("exp(-9*q^2)"),
        KernelError::NotZeroAtRim { .. }
    ));
    assert!(matches!(
        refused("q*(1 - q)"),
        KernelError::NotPositive { .. }
    ));
    assert!(matches!(refused("1/q - 1"), KernelError::NotFinite { q } if q == 0.0));
    assert!(matches!(
        refused("(1 - q)^2*(1 - 8*q)"),
        KernelError::IntegralNotPositive { .. }
    ));
    let jump = refused("if(q < 0.3, 1, 1 - q)");
    assert!(
        matches!(jump, KernelError::Jump { q } if (q - 0.3).abs() < 1e-6),
        "{jump}"
    );
    let kink = refused("if(q < 0.3, 1 - q, 2/2*(1 - q)^2*0.7/0.49)");
    assert!(
        matches!(kink, KernelError::Jump { q } if (q - 0.3).abs() < 1e-6),
        "{kink}"
    );
    for (text, facts) in [
        ("(1 - r)^3", ["column 6", "the variable is `q`"]),
        ("(1 - q)^3*J", ["column 11", "`J` has no meaning here"]),
        ("(1 - q^3", ["column 1", "not closed"]),
        ("", ["empty", "(1 - q)^4*(1 + 4*q)"]),
    ] {
        let message = refused(text).to_string();
        assert!(facts.iter().all(|fact| message.contains(fact)), "{message}");
    }
}
