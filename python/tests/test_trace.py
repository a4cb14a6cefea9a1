"""Energies given as Python functions that are traced to a formula."""

from collections.abc import Callable
import math
from typing import Any

import numpy as np
import pytest

import onset
from onset import InputError, Material

STATES = np.eye(3) + 0.15 * np.random.default_rng(5).normal(size=(40, 3, 3))
PARAMETERS: dict[str, Any] = {"mu": 0.4, "lambda_": 2.0}


def neo_hooke(I1, J, mu, lambda_):  # type: ignore[no-untyped-def]
    return mu / 2 * (I1 - 3 - 2 * np.log(J)) + lambda_ / 2 * np.log(J) ** 2


def assert_same(one: Material, other: Material, digits: float) -> None:
    for quantity in ("energy", "stress", "tangent"):
        a, b = (getattr(material, quantity)(STATES) for material in (one, other))
        assert np.max(np.abs(a - b)) <= digits * np.max(np.abs(b)), quantity


def test_a_traced_function_gives_its_formula() -> None:
    own = Material(neo_hooke, **PARAMETERS)
    assert "material.energy=mu/2*(I1 - 3 - 2*ln(J)) + lambda/2*ln(J)^2" in own.assignments
    assert_same(own, Material("mu/2*(I1 - 3 - 2*ln(J)) + lambda/2*ln(J)^2", **PARAMETERS), 0.0)
    assert_same(own, Material("neo-hooke", **PARAMETERS), 1e-15)
    assert own == Material(energy=neo_hooke, **PARAMETERS) == Material("formula", energy=neo_hooke, **PARAMETERS)


def test_a_traced_function_agrees_with_the_built_in_law() -> None:
    method = onset.Method("tlsph", penalty=0.1)
    own, known = (onset.state(material, method, stretch=(1.3, 0.8)) for material in (Material(neo_hooke, **PARAMETERS), Material("neo-hooke", **PARAMETERS)))
    assert own.verdict == known.verdict
    assert own.discretization.minimum_scaled == pytest.approx(known.discretization.minimum_scaled, rel=1e-12)


@pytest.mark.parametrize(
    ("energy", "formula"),
    [
        (lambda E, mu: mu * np.trace(E @ E) + np.trace(E) ** 2, "mu*(E11^2 + E22^2 + E33^2 + 2*(E12^2 + E13^2 + E23^2)) + (E11 + E22 + E33)^2"),
        (lambda F, mu: mu / 2 * (np.sum(F**2) / np.cbrt(np.linalg.det(F) ** 2) - 3) + (np.linalg.det(F) - 1) ** 2, "mu/2*(I1bar - 3) + (J - 1)^2"),
        (lambda C, mu: mu * np.trace(np.linalg.inv(C)) + np.linalg.det(C), "mu*I2/I3 + I3"),
        (lambda C, mu: mu * np.einsum("ij,ji", C, C), "mu*(I1^2 - 2*I2)"),
        (lambda C, J, mu: np.where((C[0, 0] > 1) & ~(J < 0), mu * (C[0, 0] - 1) ** 2, 0) + (J - 1) ** 2, "mu*macaulay(C11 - 1)^2 + (J - 1)^2"),
        (lambda I1, J, mu: mu * np.maximum(I1 - 3, 0) ** 2 + np.square(J - 1), "mu*macaulay(I1 - 3)^2 + (J - 1)^2"),
        (lambda J, mu: -((J - 1) ** -2) - -(J - (2 - J)) / (J / (J * 2)) - mu * 2.0**-J, "mu*-2^(-J) + 4*(J - 1) - 1/(J - 1)^2"),
        (lambda J, mu: mu * (J - 1) ** 2 * 2**70 - 0.0 + -1e-30 * J, "mu*(J - 1)^2*1180591620717411303424 - 1e-30*J"),
        (lambda J, mu: mu * (np.log1p(J) + np.expm1(J) + np.log2(J) + np.reciprocal(J)), "mu*(ln(1 + J) + exp(J) - 1 + ln(J)/ln(2) + 1/J)"),
        (lambda lambda1, lambda2, lambda3, mu: mu * (lambda1**1.5 + lambda2**1.5 + lambda3**1.5), "mu*(lambda1^1.5 + lambda2^1.5 + lambda3^1.5)"),
    ],
)
def test_traced_functions_of_tensors_and_invariants_agree_with_formulas(energy: Callable[..., object], formula: str) -> None:
    assert_same(Material(energy, mu=0.7), Material(formula, mu=0.7), 1e-13)


def test_common_subexpressions_are_written_once() -> None:
    def nested(J, depth=12):  # type: ignore[no-untyped-def]
        for _ in range(30):
            J = J + J * J
        return J - depth

    text = Material(nested).assignments[1]
    assert len(text) < 2000 and text.count("let ") == 29


def test_names_of_subexpressions_do_not_collide_with_arguments() -> None:
    def energy(I1, part1=2.0):  # type: ignore[no-untyped-def]
        part = I1 - 3
        return part * part + part1

    assert Material(energy).energy(np.diag([1.0, 1.0, 2.0])) == 11.0


def test_defaults_of_arguments_become_values_of_parameters() -> None:
    def energy(I1, J, mu=0.25):  # type: ignore[no-untyped-def]
        return mu * (I1 - 3 - 2 * np.log(J))

    assert "material.mu=0.25" in Material(energy).assignments
    assert "material.mu=0.5" in Material(energy, mu=0.5).assignments


def raises(J):  # type: ignore[no-untyped-def]
    raise KeyError("mine")


@pytest.mark.parametrize(
    ("energy", "message"),
    [
        (lambda J: math.log(J), "numpy.log, not math.log"),
        (lambda J: 1 if J > 1 else 2, "numpy.where"),
        (lambda J: 1 if J == 1 else 2, "numpy.where"),
        (lambda J, k: k * J, "takes k, which has no value"),
        (lambda *all: 1, "name each argument"),
        (lambda J: np.arctan(J), "numpy.arctan"),
        (lambda J: "J", "expected a number|computes with str"),
        (lambda F: F, r"shape \(3, 3\)"),
        (lambda J: None, "NoneType"),
        (lambda J: np.inf * J, "expected finite ones"),
        (lambda J: J + 1j, "complex"),
        (lambda J: np.complex128(1 + 2j) * J, "complex128"),
        (lambda J: 10**400 * J, "expected finite ones"),
        (lambda J, C11=1.0: C11 * float(J), "component of a tensor"),
        (lambda C: np.linalg.det(C[:2]), "square matrix"),
    ],
)
def test_unsupported_expressions_are_refused_with_a_message(energy: Callable[..., object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Material(energy)


def test_exceptions_of_the_function_are_propagated() -> None:
    with pytest.raises(KeyError, match="mine"):
        Material(raises)
