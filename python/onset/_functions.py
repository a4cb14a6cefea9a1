"""Laws as Python functions of numbers: energy, stress and tangent are given, or follow by automatic differentiation."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
import importlib
import importlib.util
import inspect
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._arrays import Floats, number
from ._errors import InputError

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
    #: Whether the stress is the Cauchy stress.
    is_cauchy: bool
    #: Parameters with their values, given or default.
    parameters: Mapping[str, float] = field(compare=False)
    respond: Respond = field(compare=False, repr=False)

    @property
    def name(self) -> str:
        """Name of the energy function."""
        return str(getattr(self.energy, "__name__", type(self.energy).__name__))


def _volume(F: Any) -> Any:
    return (
        F[0, 0] * (F[1, 1] * F[2, 2] - F[1, 2] * F[2, 1])
        - F[0, 1] * (F[1, 0] * F[2, 2] - F[1, 2] * F[2, 0])
        + F[0, 2] * (F[1, 0] * F[2, 1] - F[1, 1] * F[2, 0])
    )


def _first(F: Any) -> Any:
    return (F * F).sum()


def _second(F: Any) -> Any:
    C = F.T @ F
    return 0.5 * (C.trace() ** 2 - (C * C).sum())


#: Variables of a function at a deformation gradient, in NumPy or in another array library.
_VARIABLES: Mapping[str, Callable[[Any], Any]] = {
    "F": lambda F: F,
    "C": lambda F: F.T @ F,
    "E": lambda F: 0.5 * (F.T @ F - np.eye(3)),
    "I1": _first,
    "I2": _second,
    "I3": lambda F: _volume(F) ** 2,
    "J": _volume,
    "I1bar": lambda F: _first(F) * _volume(F) ** (-2.0 / 3.0),
    "I2bar": lambda F: _second(F) * _volume(F) ** (-4.0 / 3.0),
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
                raise InputError(f"{what} takes {argument}\n  hint: name each argument: {', '.join(_VARIABLES)}, or parameters")
        self.function, self.what = function, what
        self.variables = [argument.name for argument in arguments if argument.name in _VARIABLES]
        self.parameters = {argument.name: argument.default for argument in arguments if argument.name not in _VARIABLES}

    def __call__(self, F: Any, values: Mapping[str, Any]) -> Any:
        given = {name: _VARIABLES[name](F) for name in self.variables}
        return self.function(**given, **{name: values[name.rstrip("_")] for name in self.parameters})


def _values(functions: list[_Function], parameters: Mapping[str, object]) -> dict[str, float]:
    """Returns the values of all parameters, given or default."""
    values: dict[str, float] = {}
    for function in functions:
        for name, default in function.parameters.items():
            value = next((given for own, given in parameters.items() if own.rstrip("_") == name.rstrip("_")), default)
            if value is inspect.Parameter.empty:
                known = ", ".join(_VARIABLES)
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

#: Points and weights on [0, 1] of the integral that gives an energy, and its relative tolerance.
_POINTS, _WEIGHTS = (0.5 * (np.polynomial.legendre.leggauss(8)[0] + 1.0), 0.5 * np.polynomial.legendre.leggauss(8)[1])
_WORK_TOLERANCE = 1e-10
#: Most halvings of an interval of this integral, at a kink of the stress.
_HALVINGS = 24
#: Largest strain at which differences of the work are rounding.
_SMALL_STRAIN = 1e-4


#: Function from deformation gradients to first Piola-Kirchhoff stresses, each of shape (n, 3, 3).
_Stress = Callable[[Floats], Floats]


def _slope(stress: _Stress, F: Floats) -> Floats:
    """Returns ``A_iJkL = dP_iJ/dF_kL`` at states of shape (n, 3, 3) from central differences of the stress; shape (n, 81)."""
    steps = np.multiply.outer([1.0, -1.0, 2.0, -2.0], _STEP * np.eye(9).reshape(9, 3, 3))
    moved = stress((F[:, None, None] + steps).reshape(-1, 3, 3)).reshape(len(F), 4, 9, 9)
    near, far = moved[:, 0] - moved[:, 1], moved[:, 2] - moved[:, 3]
    slope: Floats = ((8.0 * near - far) / (12.0 * _STEP)).swapaxes(1, 2).reshape(len(F), 81)
    return slope


def _work(stress: _Stress, F: Floats) -> Floats:
    """Returns the work of the stress from the reference state to ``F = R U`` along ``U^t``, by adaptive quadrature; shape (n, 1).

    No rotation changes it, and states of equal volume are reached at that volume.
    """
    _, stretches, axes = np.linalg.svd(F)
    logarithms = np.log(stretches)

    def part(state: NDArray[np.intp], start: Floats, length: Floats) -> Floats:
        t = start[:, None] + np.multiply.outer(length, _POINTS)
        frames = axes[state][:, None]
        turned = frames.swapaxes(-1, -2)
        powers = np.exp(t[..., None] * logarithms[state][:, None])
        on_the_way = (turned * powers[..., None, :]) @ frames
        rates = (turned * (powers * logarithms[state][:, None])[..., None, :]) @ frames
        power = np.einsum("ntij,ntij->nt", stress(on_the_way.reshape(-1, 3, 3)).reshape(rates.shape), rates)
        works: Floats = length * (power @ _WEIGHTS)
        return works

    works = np.zeros(len(F))
    state, start, length = np.arange(len(F)), np.zeros(len(F)), np.ones(len(F))
    whole = part(state, start, length)
    for halving in range(_HALVINGS + 1):
        half = 0.5 * length
        halves = part(np.repeat(state, 2), np.stack([start, start + half], axis=1).reshape(-1), np.repeat(half, 2)).reshape(-1, 2)
        sums = halves.sum(axis=1)
        scale = np.abs(sums) + np.abs(works[state])
        is_open = np.abs(sums - whole) > _WORK_TOLERANCE * scale
        # At small strains, and in more intervals than kinks could have, such differences are rounding.
        is_open &= np.abs(logarithms[state]).max(axis=1) > _SMALL_STRAIN
        is_open &= halving < _HALVINGS and np.count_nonzero(is_open) <= 16 + 4 * len(F)
        np.add.at(works, state[~is_open], sums[~is_open])
        if not is_open.any():
            break
        state, start = np.repeat(state[is_open], 2), np.stack([start, start + half], axis=1)[is_open].reshape(-1)
        length, whole = np.repeat(half[is_open], 2), halves[is_open].reshape(-1)
    return works[:, None]


def delivered(energy: object, stress: object, cauchy: object, tangent: object, parameters: Mapping[str, object]) -> Handed:
    """Returns the law of functions: ``W``, ``P_iJ`` or the Cauchy stress of shape (3, 3), and ``A_iJkL = dP_iJ/dF_kL`` of shape (3, 3, 3, 3).

    Without an energy it is the work of the stress, and without a tangent it consists of differences of the stress.
    """
    if (stress is None) == (cauchy is None):
        what = "the stress is missing" if stress is None else "a material has one stress"
        raise InputError(f"{what}\n  hint: give `stress`, the first Piola-Kirchhoff stress P(F), or `cauchy`, the Cauchy stress sigma(F)")
    given = {"the energy": energy, "the stress": stress or cauchy, "the tangent": tangent}
    functions = {what: _Function(function, what) for what, function in given.items() if function is not None}  # type: ignore[arg-type]
    values = _values(list(functions.values()), parameters)

    def asked(what: str, shape: tuple[int, ...], F: Floats, now: Mapping[str, float]) -> Floats:
        return np.stack([_shaped(functions[what](one, now), shape, what) for one in F])

    def first_piola(F: Floats, now: Mapping[str, float]) -> Floats:
        numbers = asked("the stress", (3, 3), F, now).reshape(-1, 3, 3)
        return numbers if cauchy is None else np.linalg.det(F)[:, None, None] * numbers @ np.linalg.inv(F).swapaxes(1, 2)

    def respond(states: bytes, changed: Mapping[str, float]) -> bytes:
        now = {**values, **{name: value for name, value in changed.items() if name in values}}
        F = np.frombuffer(states).reshape(-1, 3, 3)
        stress_of = partial(first_piola, now=now)
        parts = [
            _work(stress_of, F) if energy is None else asked("the energy", (), F, now),
            stress_of(F).reshape(-1, 9),
            _slope(stress_of, F) if tangent is None else asked("the tangent", (3, 3, 3, 3), F, now),
        ]
        return np.concatenate(parts, axis=1).tobytes()

    named = {what: function.function for what, function in functions.items()}
    return _tried(Handed(named.get("the energy", named["the stress"]), named["the stress"], named.get("the tangent"), cauchy is not None, values, respond))


def is_felupe(model: object) -> bool:
    """Returns true for a material of FElupe or matADi: an object with ``gradient`` and ``hessian``."""
    return not isinstance(model, type) and all(callable(getattr(model, name, None)) for name in ("gradient", "hessian"))


def of_felupe(model: Any) -> Handed:
    """Returns the law of a material of FElupe or matADi, whose functions take ``[F, state variables]`` with ``F`` of shape (3, 3, n, 1).

    Raises
    ------
    InputError
        If the material has state variables.
    """
    inputs = getattr(model, "x", [None, np.zeros(0)])
    if any(np.size(part) for part in inputs[1:]):
        raise InputError(
            f"{type(model).__name__} takes more than the deformation gradient: state variables or further fields\n"
            "  hint: a law from Python is elastic and depends on F alone; give its long-term or instantaneous response"
        )

    def asked(what: str, size: int, F: Floats) -> Floats:
        rest = [np.zeros((*np.shape(part), len(F), 1)) for part in inputs[1:]]
        first = np.asarray(getattr(model, what)([np.moveaxis(F, 0, -1)[..., None], *rest])[0], dtype=np.float64)
        if first.size % size or first.ndim < 2 or first.shape[-1] != 1:
            raise InputError(f"{what} of {type(model).__name__} has the shape {first.shape}; expected {'(3, 3, n, 1)' if size == 9 else f'{size} components'}")
        # Constant results have a single point.
        return np.broadcast_to(np.moveaxis(first[..., 0], -1, 0).reshape(-1, size), (len(F), size))

    def stress(F: Floats) -> Floats:
        return asked("gradient", 9, F).reshape(-1, 3, 3)

    has_energy = callable(getattr(model, "function", None))

    def respond(states: bytes, changed: Mapping[str, float]) -> bytes:
        F = np.frombuffer(states).reshape(-1, 3, 3)
        energy = asked("function", 1, F) if has_energy else _work(stress, F)
        return np.concatenate([energy, stress(F).reshape(-1, 9), asked("hessian", 81, F)], axis=1).tobytes()

    return _tried(Handed(model, None, None, False, {}, respond))


def has_jax() -> bool:
    """Returns true if jax is installed for automatic differentiation."""
    return importlib.util.find_spec("jax") is not None


def differentiated(energy: Callable[..., Any], parameters: Mapping[str, object]) -> Handed:
    """Returns the law of an energy that jax differentiates; states are evaluated in batches."""
    jax = importlib.import_module("jax")
    own = _Function(energy, "the energy")
    values = _values([own], parameters)

    def total(F: Any, now: Mapping[str, Any]) -> Any:
        return own(F, now)

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

    return _tried(Handed(energy, None, None, False, values, respond))


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
