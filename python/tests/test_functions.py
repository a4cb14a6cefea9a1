"""Laws given as Python functions that cannot be traced to a formula."""

from __future__ import annotations

from collections.abc import Callable
import math
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import onset
import pytest

MU, LAMBDA = 0.4, 2.0
BUILT_IN = onset.Material("neo-hooke", mu=MU, lambda_=LAMBDA)
SPH = onset.Method("updated-sph", lattice="square", kernel="cubic-spline", support=2.6)
TOTAL = onset.Method("total-lagrangian-sph", lattice="square", support=2.6)


def energy(F: Any, mu: float, lambda_: float) -> Any:
    J = np.linalg.det(F)
    # `math.log` accepts only plain numbers, so that the function cannot be traced.
    return mu / 2 * (np.sum(F * F) - 3 - 2 * math.log(J)) + lambda_ / 2 * math.log(J) ** 2


def stress(F: Any, J: Any, mu: float, lambda_: float) -> Any:
    G = np.linalg.inv(F).T
    return mu * (F - G) + lambda_ * np.log(J) * G


def tangent(F: Any, J: Any, mu: float, lambda_: float) -> Any:
    G = np.linalg.inv(F)
    each = np.einsum("ik,JL->iJkL", np.eye(3), np.eye(3))
    return mu * each + lambda_ * np.einsum("Ji,Lk->iJkL", G, G) + (mu - lambda_ * np.log(J)) * np.einsum("Li,Jk->iJkL", G, G)


def differentiable(I1: Any, J: Any, mu: Any, lambda_: Any) -> Any:
    return mu / 2 * (I1 - 3 - 2 * jnp.log(J)) + lambda_ / 2 * jnp.log(J) ** 2


DELIVERED = onset.Material(energy, stress=stress, tangent=tangent, mu=MU, lambda_=LAMBDA)
DIFFERENTIATED = onset.Material(differentiable, mu=MU, lambda_=LAMBDA)


def deformations(count: int, dimension: int) -> Any:
    return np.eye(dimension) + np.random.default_rng(7).uniform(-0.2, 0.2, (count, dimension, dimension))


@pytest.mark.parametrize("law", [DELIVERED, DIFFERENTIATED])
def test_python_functions_agree_with_the_built_in_law(law: onset.Material) -> None:
    F = deformations(20, 3)
    for ours, theirs in ((law.energy, BUILT_IN.energy), (law.stress, BUILT_IN.stress), (law.tangent, BUILT_IN.tangent)):
        np.testing.assert_allclose(ours(F), theirs(F), rtol=1e-12, atol=1e-12)
    for stretch in ((1.1, 1.0), (0.9, 1.05)):
        own, known = onset.state(law, SPH, stretch=stretch), onset.state(BUILT_IN, SPH, stretch=stretch)
        assert own.verdict == known.verdict
        assert own.growth_rate == pytest.approx(known.growth_rate, rel=1e-10)
        assert own.next == ()  # no command accepts a function
    onsets = [onset.path(one, SPH, from_=(0.9, 1), to=(1.2, 1)).discretization_onset for one in (law, BUILT_IN)]
    assert onsets[0].parameter == pytest.approx(onsets[1].parameter, abs=1e-12)
    many, known_many = (onset.verdicts(one, TOTAL, deformations(300, 2)) for one in (law, BUILT_IN))
    assert many.count() == known_many.count()
    np.testing.assert_allclose(many.growth_rate, known_many.growth_rate, rtol=1e-9, atol=1e-9)


class Felupe:
    """Neo-Hookean material with the interface of FElupe 10: components first, then the axes of points."""

    def __init__(self, states: int = 0) -> None:
        self.x = [np.eye(3), np.zeros(states)]

    def gradient(self, x: list[Any]) -> list[Any]:
        assert x[0].shape == (3, 3, x[1].shape[1], 1)
        F = np.moveaxis(x[0][..., 0], -1, 0)
        return [np.stack([stress(one, np.linalg.det(one), MU, LAMBDA) for one in F], axis=-1)[..., None], x[1]]

    def hessian(self, x: list[Any]) -> list[Any]:
        F = np.moveaxis(x[0][..., 0], -1, 0)
        return [np.stack([tangent(one, np.linalg.det(one), MU, LAMBDA) for one in F], axis=-1)[..., None]]


def cauchy(F: Any, J: Any, mu: float, lambda_: float) -> Any:
    return stress(F, J, mu, lambda_) @ F.T / J


@pytest.mark.parametrize(
    "law",
    [
        onset.Material(stress=stress, mu=MU, lambda_=LAMBDA),
        onset.Material(energy, cauchy=cauchy, mu=MU, lambda_=LAMBDA),
        onset.Material(stress=stress, tangent=tangent, mu=MU, lambda_=LAMBDA),
        onset.Material(Felupe()),
    ],
)
def test_missing_parts_of_a_law_follow_from_its_stress(law: onset.Material) -> None:
    F = deformations(20, 3)
    np.testing.assert_allclose(law.energy(F), BUILT_IN.energy(F), rtol=1e-9, atol=1e-11)
    np.testing.assert_allclose(law.stress(F), BUILT_IN.stress(F), rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(law.tangent(F), BUILT_IN.tangent(F), atol=1e-8 * np.abs(BUILT_IN.tangent(F)).max())
    own, known = (onset.state(one, TOTAL, stretch=(1.1, 0.9)) for one in (law, BUILT_IN))
    assert (own.verdict, own.mechanism) == (known.verdict, known.mechanism)
    assert own.growth_rate == pytest.approx(known.growth_rate, rel=1e-7, abs=1e-7)
    assert onset.audit(law).consistent


def test_work_is_integrated_across_a_kink_and_at_constant_volume() -> None:
    def kinked(F: Any, I1: Any, J: Any) -> Any:
        return stress(F, J, MU, LAMBDA) + 2.0 * max(I1 - 3.3, 0.0) * F

    law = onset.Material(stress=kinked)
    F = np.diag([1.6, 0.9, 0.8])
    I1 = np.trace(F.T @ F)
    assert law.energy(F) == pytest.approx(BUILT_IN.energy(F) + 0.5 * (I1 - 3.3) ** 2, rel=1e-8)
    long = np.diag([4.0, 0.5, 0.5])
    assert onset.Material(stress=stress, mu=MU, lambda_=1e4).energy(long) == pytest.approx(onset.Material("neo-hooke", mu=MU, lambda_=1e4).energy(long), rel=1e-9)


def test_a_cauchy_stress_is_not_a_first_piola_stress() -> None:
    assert onset.Material(stress=stress, mu=MU, lambda_=LAMBDA) != onset.Material(cauchy=stress, mu=MU, lambda_=LAMBDA)


def test_a_stress_without_energy_is_found_by_the_audit() -> None:
    spun = onset.Material(stress=lambda F, C, J: stress(F, J, MU, LAMBDA) + 0.3 * F @ C @ np.diag([1.0, 0.0, 0.0]) @ C)
    assert not onset.audit(spun).consistent


def test_a_function_that_calls_a_built_in_law_returns_identical_numbers() -> None:
    """A law whose function calls a built-in law gives identical numbers, and does not deadlock."""
    same = onset.Material(BUILT_IN.energy, stress=BUILT_IN.stress, tangent=BUILT_IN.tangent)
    for one in (onset.Material("ogden"), onset.Material("gent")):
        own = onset.Material(one.energy, stress=one.stress, tangent=one.tangent)
        F = deformations(10, 3)
        assert np.array_equal(own.tangent(F), one.tangent(F))
    assert onset.state(same, SPH, stretch=(1.1, 1.0)).growth_rate == onset.state(BUILT_IN, SPH, stretch=(1.1, 1.0)).growth_rate
    assert onset.verdicts(same, SPH, deformations(700, 2)).count() == onset.verdicts(BUILT_IN, SPH, deformations(700, 2)).count()


@pytest.mark.parametrize("law", [DELIVERED, DIFFERENTIATED])
def test_all_functions_without_a_study_file_accept_python_laws(law: onset.Material) -> None:
    assert "material.model=function" in law_settings(law)
    own, known = (onset.modes(TOTAL, one).to_dict() for one in (law, BUILT_IN))
    assert [mode["wave_vector"] for mode in own["modes"]] == [mode["wave_vector"] for mode in known["modes"]]
    methods = {"updated": SPH, "total": TOTAL}
    rows, known_rows = (str(onset.compare(methods, one, states=4)).splitlines()[2:6] for one in (law, BUILT_IN))
    assert rows == known_rows
    ranking, known_ranking = (onset.recommend(one, methods=methods, stretches=(0.9, 1.1)).to_dict()["ranking"] for one in (law, BUILT_IN))
    assert [entry["name"] for entry in ranking] == [entry["name"] for entry in known_ranking]
    penalty = onset.Method("total-lagrangian-sph", lattice="square")
    sufficient, known_sufficient = (onset.tune(penalty, "penalty", material=one).recommended for one in (law, BUILT_IN))
    assert sufficient == pytest.approx(known_sufficient, rel=1e-6)
    bodies, known_bodies = (onset.state(one, TOTAL, stretch=(1.1, 0.95)).finite_bodies for one in (law, BUILT_IN))
    assert bodies is not None and known_bodies is not None
    assert bodies["time_step"] == pytest.approx(known_bodies["time_step"], rel=1e-6)
    assert onset.simulate(law, TOTAL, stretch=(1, 1), turns=(1, 0), cells=4, steps=20).steps == 20
    with pytest.raises(onset.InputError, match="cannot contain a Python function"):
        onset.Study.of(law, SPH, {"stretch-1": (0.8, 1.2, 4), "stretch-2": (0.8, 1.2, 4)})


def test_criteria_of_python_and_built_in_laws_agree() -> None:
    def limits(law: onset.Material) -> list[float]:
        """Limits of each criterion in compression and in tension; 0 if it is not violated."""
        criteria = onset.criteria(law, modes=["hydrostatic"], range=(0.95, 1.05)).to_dict()["loadings"][0]["criteria"]
        return [criterion[side]["limit"] or 0.0 for criterion in criteria for side in ("compression", "tension") if criterion["defined"]]

    assert any(limits(BUILT_IN))
    assert limits(DELIVERED) == pytest.approx(limits(BUILT_IN), abs=1e-9)


def law_settings(law: onset.Material) -> list[str]:
    """Settings that are reported in an answer."""
    settings = onset.state(law, SPH, stretch=(1.1, 1.0)).to_dict()["settings"]
    return [f"{key}={choice['value']}" for key, choice in settings.items()]


def test_the_audit_detects_a_tangent_that_is_not_the_derivative_of_the_stress() -> None:
    assert onset.audit(DELIVERED).consistent
    assert onset.audit(DIFFERENTIATED).consistent
    wrong = onset.Material(energy, stress=stress, tangent=lambda F, J, mu, lambda_: 1.1 * tangent(F, J, mu, lambda_), mu=MU, lambda_=LAMBDA)
    assert not onset.audit(wrong).consistent
    no_energy = onset.Material(lambda F, mu, lambda_: 2 * energy(F, mu, lambda_), stress=stress, tangent=tangent, mu=MU, lambda_=LAMBDA)
    assert not onset.audit(no_energy).consistent


def test_jax_uses_doubles_only_while_a_law_is_evaluated() -> None:
    DIFFERENTIATED.energy(np.eye(3))
    assert jnp.ones(1).dtype == jnp.float32
    assert jax.numpy.asarray(1.0).dtype == jnp.float32


def test_laws_with_different_parameters_are_unequal() -> None:
    stiffer = DELIVERED.replace(mu=0.8)
    built_in = BUILT_IN.replace(mu=0.8)
    F = deformations(3, 3)
    np.testing.assert_allclose(stiffer.stress(F), built_in.stress(F), rtol=1e-12, atol=1e-12)
    assert DELIVERED == DELIVERED.replace(mu=MU) != stiffer
    assert hash(DELIVERED) == hash(DELIVERED.replace(mu=MU))
    assert onset.Material(energy, stress=stress, tangent=lambda F: tangent(F, 1.0, MU, LAMBDA), mu=MU, lambda_=LAMBDA) != DELIVERED
    assert repr(stiffer) == "Material(energy, mu=0.8, lambda=2.0)"


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: onset.Material(energy, tangent=tangent, mu=1, lambda_=1), "the stress is missing"),
        (lambda: onset.Material(stress=stress, cauchy=stress, mu=1, lambda_=1), "a material has one stress"),
        (lambda: onset.Material(cauchy=lambda F: F[0]), r"the stress has the shape \(3,\); expected \(3, 3\)"),
        (lambda: onset.Material(Felupe(states=2)), "Felupe takes more than the deformation gradient"),
        (lambda: onset.Material("neo-hooke", stress=stress, mu=1, lambda_=1), "a material has one law"),
        (lambda: onset.Material(Felupe(), cauchy=cauchy, mu=1, lambda_=1), "a material has one law"),
        (lambda: onset.Material(Felupe), "expected the name of a law"),
        (lambda: onset.Material(Felupe(), mu=1), "no function of the material takes mu"),
        (lambda: onset.Material(BUILT_IN), "expected the name of a law"),  # type: ignore[arg-type]
        (lambda: onset.Material(energy, stress=stress, tangent=tangent, mu=1), "takes lambda_, which has no value"),
        (lambda: onset.Material(energy, stress=stress, tangent=tangent, mu=1, lambda_=1, nu=2), "no function of the material takes nu"),
        (lambda: onset.Material(energy, stress=stress, tangent=tangent, mu="stiff", lambda_=1), "mu cannot be read as numbers|mu holds"),
        (lambda: DELIVERED.replace(nu=2), "no function of the material takes nu"),
        (lambda: onset.Material(energy, stress=stress, tangent=lambda F: F, mu=1, lambda_=1), r"has the shape \(3, 3\); expected \(3, 3, 3, 3\)"),
        (lambda: onset.Material(lambda F: F, stress=stress, tangent=tangent, mu=1, lambda_=1), r"has the shape \(3, 3\); expected a number"),
        (lambda: onset.Material(lambda F: "much", stress=stress, tangent=tangent, mu=1, lambda_=1), "cannot be computed at F = 1"),
        (lambda: onset.Material(lambda *F: 1.0, stress=stress, tangent=tangent, mu=1, lambda_=1), "name each argument"),
        (lambda: onset.Material(lambda F: math.nan, stress=stress, tangent=tangent, mu=1, lambda_=1), "the energy of the material is not finite"),
        (lambda: onset.Material(energy, stress=stress, tangent=lambda F: np.full((3,) * 4, np.inf), mu=1, lambda_=1), "the tangent of the material is not"),
        (lambda: onset.Material(energy, mu=1, lambda_=1), "plain number"),
        (lambda: onset.Material(energy, stress=lambda F: F * 1j, tangent=tangent, mu=1, lambda_=1), "the stress is complex"),
    ],
)
def test_invalid_laws_are_refused_with_a_message(make: Callable[[], object], message: str) -> None:
    with pytest.raises((onset.InputError, TypeError), match=message):
        make()


def test_errors_of_a_function_name_the_state() -> None:
    def fails(F: Any, J: Any, kind: float) -> Any:
        if J > 1.05:
            match int(kind):
                case 0:
                    return math.nan
                case 1:
                    return 1 / 0
                case 2:
                    raise KeyError("a table that ends\x1b[31m")
                case 3:
                    raise KeyboardInterrupt
        return energy(F, MU, LAMBDA)

    def law(kind: int) -> onset.Material:
        return onset.Material(fails, stress=lambda F, J: stress(F, J, MU, LAMBDA), tangent=lambda F, J: tangent(F, J, MU, LAMBDA), kind=kind)

    for kind, message in ((0, "energy of the function is NaN"), (1, "ZeroDivisionError: division by zero")):
        with pytest.raises(onset.InputError, match=message):
            onset.state(law(kind), TOTAL, stretch=(1.1, 1.1))
        # A map continues past states at which the law is undefined.
        verdicts = onset.verdicts(law(kind), TOTAL, stretch=[(1.1, 1.1), (1.0, 1.0)])
        assert verdicts.count()["undefined"] == 1
    for kind, message in ((2, "KeyError"), (3, "KeyboardInterrupt")):
        with pytest.raises(onset.InputError, match=message) as caught:
            onset.verdicts(law(kind), TOTAL, stretch=[(1.0, 1.0), (1.1, 1.1)])
        assert "state 1" in str(caught.value) and "\x1b" not in str(caught.value)
