"""Laws as Python functions of numbers: energy, stress and tangent are given, or follow by automatic differentiation."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
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


def delivered(energy: object, stress: object, tangent: object, parameters: Mapping[str, object]) -> Handed:
    """Returns the law of three functions: ``W``, ``P_iJ`` of shape (3, 3) and ``A_iJkL = dP_iJ/dF_kL`` of shape (3, 3, 3, 3)."""
    given = {"the energy": energy, "the stress": stress, "the tangent": tangent}
    missing = [what for what, function in given.items() if function is None]
    if missing:
        raise InputError(f"{missing[0]} is missing\n  hint: a law of numbers has energy, stress and tangent; with jax the energy alone is sufficient")
    functions = [_Function(function, what) for what, function in given.items()]  # type: ignore[arg-type]
    shapes: list[tuple[int, ...]] = [(), (3, 3), (3, 3, 3, 3)]
    values = _values(functions, parameters)

    def respond(states: bytes, changed: Mapping[str, float]) -> bytes:
        now = {**values, **{name: value for name, value in changed.items() if name in values}}
        numbers = []
        for F in np.frombuffer(states).reshape(-1, 3, 3):
            variables = _variables(F, np)
            numbers += [_shaped(function(variables, now), shape, function.what) for function, shape in zip(functions, shapes, strict=True)]
        return np.concatenate(numbers).tobytes()

    return _tried(Handed(functions[0].function, functions[1].function, functions[2].function, values, respond))


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
