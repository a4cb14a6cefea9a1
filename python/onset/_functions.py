"""Laws as Python functions of numbers: energy, stress and tangent are given, or follow by automatic differentiation."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
import importlib
import importlib.util
import inspect
from typing import Any

import numpy as np

from ._arrays import Floats, number
from ._errors import InputError

#: Variables of a function that describe the deformation.
VARIABLES = ("F", "C", "E", "I1", "I2", "I3", "J", "I1bar", "I2bar")

#: Number of values of a state: energy, stress and tangent.
_NUMBERS = 1 + 9 + 81

#: Function from states (nine components each) and parameters to 91 numbers for each state; states and numbers are bytes of doubles.
Respond = Callable[[bytes, Mapping[str, float]], bytes]


@dataclass(frozen=True)
class Handed:
    """Law that consists of Python functions."""

    energy: Callable[..., Any]
    stress: Callable[..., Any] | None
    tangent: Callable[..., Any] | None
    #: Parameters with their values, given or default.
    parameters: Mapping[str, float] = field(compare=False)
    respond: Respond = field(compare=False, repr=False)

    @property
    def name(self) -> str:
        """Name of the energy function."""
        return str(getattr(self.energy, "__name__", type(self.energy).__name__))


def _variables(F: Any, xp: Any) -> dict[str, Any]:
    """Returns all variables of a function at a deformation gradient, in NumPy or in another array library."""
    C = F.T @ F
    I1, I2 = C[0, 0] + C[1, 1] + C[2, 2], 0.5 * (xp.trace(C) ** 2 - xp.sum(C * C))
    J = (
        F[0, 0] * (F[1, 1] * F[2, 2] - F[1, 2] * F[2, 1])
        - F[0, 1] * (F[1, 0] * F[2, 2] - F[1, 2] * F[2, 0])
        + F[0, 2] * (F[1, 0] * F[2, 1] - F[1, 1] * F[2, 0])
    )
    return {
        "F": F,
        "C": C,
        "E": 0.5 * (C - xp.eye(3)),
        "I1": I1,
        "I2": I2,
        "I3": J * J,
        "J": J,
        "I1bar": I1 * J ** (-2.0 / 3.0),
        "I2bar": I2 * J ** (-4.0 / 3.0),
    }


class _Function:
    """Function with its variables and parameters."""

    def __init__(self, function: Callable[..., Any], what: str) -> None:
        if not callable(function):
            raise TypeError(f"{what} is {type(function).__name__}; expected a function of F and of parameters")
        try:
            arguments = inspect.signature(function).parameters.values()
        except (TypeError, ValueError) as error:
            raise InputError(f"the arguments of {what} cannot be determined: {error}\n  hint: give a function of F and of parameters") from error
        for argument in arguments:
            if argument.kind in (argument.VAR_POSITIONAL, argument.VAR_KEYWORD, argument.POSITIONAL_ONLY):
                raise InputError(f"{what} takes {argument}\n  hint: name each argument: {', '.join(VARIABLES)}, or parameters")
        self.function, self.what = function, what
        self.variables = [argument.name for argument in arguments if argument.name in VARIABLES]
        self.parameters = {argument.name: argument.default for argument in arguments if argument.name not in VARIABLES}

    def __call__(self, variables: Mapping[str, Any], values: Mapping[str, Any]) -> Any:
        given = {name: variables[name] for name in self.variables}
        return self.function(**given, **{name: values[name.rstrip("_")] for name in self.parameters})


def _values(functions: list[_Function], parameters: Mapping[str, object]) -> dict[str, float]:
    """Returns the values of all parameters, given or default."""
    values: dict[str, float] = {}
    for function in functions:
        for name, default in function.parameters.items():
            value = next((given for own, given in parameters.items() if own.rstrip("_") == name.rstrip("_")), default)
            if value is inspect.Parameter.empty:
                known = ", ".join(VARIABLES)
                raise InputError(f"{function.what} takes {name}, which has no value\n  hint: give it, {name}=...; variables are {known}")
            values[name.rstrip("_")] = number(value, name)
    stray = sorted({name.rstrip("_") for name in parameters} - set(values))
    if stray:
        raise InputError(f"no function of the material takes {stray[0]}\n  hint: its parameters are {', '.join(values) or 'none'}")
    return values


def _shaped(result: Any, shape: tuple[int, ...], what: str) -> Floats:
    if np.iscomplexobj(result):
        raise TypeError(f"{what} is complex; expected real numbers")
    array = np.asarray(result, dtype=np.float64)
    if array.shape != shape:
        raise TypeError(f"{what} has the shape {array.shape}; expected {shape or 'a number'}")
    return array.reshape(-1)


#: Step of the differences that give a tangent, 2^-16: they are of fourth order, with errors of about 1e-10 of the tangent, from rounding.
_STEP = 2.0**-16

#: Points and weights on [0, 1] of the integral that gives an energy.
_POINTS, _WEIGHTS = (0.5 * (np.polynomial.legendre.leggauss(12)[0] + 1.0), 0.5 * np.polynomial.legendre.leggauss(12)[1])


def _slope(stress: Callable[[Floats], Floats], F: Floats) -> Floats:
    """Returns ``A_iJkL = dP_iJ/dF_kL`` from central differences of the stress; shape (9, 9)."""
    columns = []
    for component in np.eye(9).reshape(9, 3, 3) * _STEP:
        near, far = (stress(F + part * component) - stress(F - part * component) for part in (1.0, 2.0))
        columns.append((8.0 * near - far) / (12.0 * _STEP))
    return np.stack(columns, axis=-1)


def _work(stress: Callable[[Floats], Floats], F: Floats) -> Floats:
    """Returns the work of the stress from the reference state to ``F = R U`` along ``1 + t (U - 1)``, which no rotation changes; shape (1,)."""
    _, values, axes = np.linalg.svd(F)
    change = (axes.T * values) @ axes - np.eye(3)
    works = [float(stress(np.eye(3) + t * change) @ change.reshape(-1)) for t in _POINTS]
    return np.array([_WEIGHTS @ works])


def delivered(energy: object, stress: object, cauchy: object, tangent: object, parameters: Mapping[str, object]) -> Handed:
    """Returns the law of functions: ``W``, ``P_iJ`` or the Cauchy stress of shape (3, 3), and ``A_iJkL = dP_iJ/dF_kL`` of shape (3, 3, 3, 3).

    Without an energy it is the work of the stress, and without a tangent it consists of differences of the stress.
    """
    if (stress is None) == (cauchy is None):
        what = "the stress is missing" if stress is None else "a material has one stress"
        raise InputError(f"{what}\n  hint: give `stress`, the first Piola-Kirchhoff stress P(F), or `cauchy`, the Cauchy stress sigma(F)")
    given = {"the energy": energy, "the stress": cauchy if stress is None else stress, "the tangent": tangent}
    functions = {what: _Function(function, what) for what, function in given.items() if function is not None}  # type: ignore[arg-type]
    values = _values(list(functions.values()), parameters)

    def asked(what: str, shape: tuple[int, ...], F: Floats, now: Mapping[str, float]) -> Floats:
        return _shaped(functions[what](_variables(F, np), now), shape, what)

    def first_piola(F: Floats, now: Mapping[str, float]) -> Floats:
        numbers = asked("the stress", (3, 3), F, now)
        if cauchy is None:
            return numbers
        piola: Floats = (np.linalg.det(F) * numbers.reshape(3, 3) @ np.linalg.inv(F).T).reshape(-1)
        return piola

    def respond(states: bytes, changed: Mapping[str, float]) -> bytes:
        now = {**values, **{name: value for name, value in changed.items() if name in values}}
        numbers = []
        for F in np.frombuffer(states).reshape(-1, 3, 3):
            own = partial(first_piola, now=now)
            numbers.append(asked("the energy", (), F, now) if energy is not None else _work(own, F))
            numbers.append(own(F))
            numbers.append(asked("the tangent", (3, 3, 3, 3), F, now) if tangent is not None else _slope(own, F).reshape(-1))
        return np.concatenate(numbers).tobytes()

    named = {what: function.function for what, function in functions.items()}
    return _tried(Handed(named.get("the energy", named["the stress"]), named["the stress"], named.get("the tangent"), values, respond))


def is_felupe(model: object) -> bool:
    """Returns true for a material of FElupe or matADi: an object with ``gradient`` and ``hessian``."""
    return all(callable(getattr(model, name, None)) for name in ("gradient", "hessian"))


def of_felupe(model: Any) -> Handed:
    """Returns the law of a material of FElupe or matADi, ``gradient([F, state variables])``, with ``F`` of shape (3, 3, 1, 1).

    Raises
    ------
    InputError
        If the material has state variables.
    """
    inputs = getattr(model, "x", [None, np.zeros(0)])
    rest = [np.zeros((*np.shape(part), 1, 1)) for part in inputs[1:]]
    if any(part.size for part in rest):
        raise InputError(f"{type(model).__name__} has state variables\n  hint: laws from Python are elastic; give its long-term or its instantaneous response")

    def numbers(what: str, F: Floats) -> Floats:
        answer = getattr(model, what)([F[:, :, None, None], *rest])
        return np.asarray(answer[0], dtype=np.float64)[..., 0, 0]

    def energy(F: Floats) -> Floats:
        return numbers("function", F)

    def stress(F: Floats) -> Floats:
        return numbers("gradient", F)

    def tangent(F: Floats) -> Floats:
        return numbers("hessian", F)

    has_energy = callable(getattr(model, "function", None))
    law = delivered(energy if has_energy else None, stress, None, tangent, {})
    return replace(law, energy=model)


def has_jax() -> bool:
    """Returns true if jax is installed for automatic differentiation."""
    return importlib.util.find_spec("jax") is not None


def differentiated(energy: Callable[..., Any], parameters: Mapping[str, object]) -> Handed:
    """Returns the law of an energy that jax differentiates; states are evaluated in batches."""
    jax = importlib.import_module("jax")
    own = _Function(energy, "the energy")
    values = _values([own], parameters)

    def total(F: Any, now: Mapping[str, Any]) -> Any:
        return own(_variables(F, jax.numpy), now)

    def numbers(F: Any, now: Mapping[str, Any]) -> Any:
        stress = jax.grad(total)
        parts = (total(F, now), stress(F, now), jax.jacfwd(stress)(F, now))
        return jax.numpy.concatenate([jax.numpy.ravel(part) for part in parts])

    together = jax.jit(jax.vmap(numbers, in_axes=(0, None)))

    def respond(states: bytes, changed: Mapping[str, float]) -> bytes:
        now = {**values, **{name: value for name, value in changed.items() if name in values}}
        F = np.frombuffer(states).reshape(-1, 3, 3)
        # Each number of states requires a compilation, so the number is padded to a power of two with copies of the last state.
        count = 1 << (len(F) - 1).bit_length()
        padded = np.concatenate([F, np.broadcast_to(F[-1], (count - len(F), 3, 3))])
        with _doubles(jax):
            response = np.asarray(together(padded, now), dtype=np.float64)
        return np.ascontiguousarray(response[: len(F)]).tobytes()

    return _tried(Handed(energy, None, None, values, respond))


def _doubles(jax: Any) -> Any:
    """Returns a context in which jax computes in double precision, independent of its configuration."""
    enable = jax.enable_x64 if hasattr(jax, "enable_x64") else jax.experimental.enable_x64
    return enable(True)


def _tried(law: Handed) -> Handed:
    """Returns the law after evaluating it in the reference state."""
    try:
        numbers = np.frombuffer(law.respond(np.eye(3).tobytes(), {}))
    except Exception as error:
        raise InputError(f"the material cannot be computed at F = 1: {type(error).__name__}: {error}") from error
    if numbers.shape != (_NUMBERS,) or not np.all(np.isfinite(numbers)):
        what = ("energy", "stress", "tangent")[int(np.searchsorted([1, 10], np.argmin(np.isfinite(numbers)), side="right"))]
        raise InputError(f"the {what} of the material is not finite at F = 1\n  hint: the reference state has energy, stress and tangent")
    return law
