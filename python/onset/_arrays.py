"""Conversion of arguments to arrays of doubles, and of results to arrays."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
import os
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._errors import InputError, MachineError

#: Array of doubles.
Floats = NDArray[np.float64]
#: Array of complex numbers of two doubles.
Complexes = NDArray[np.complex128]


def unmasked(value: object, what: str) -> None:
    """Refuses masked values, also in the arrays of a list."""
    parts = value if isinstance(value, (list, tuple)) else (value,)
    masked = sum(int(np.ma.getmaskarray(part).sum()) for part in parts if isinstance(part, np.ma.MaskedArray))
    if masked:
        raise InputError(f"{what} has {masked} masked values; select or fill them, for example with compressed() or filled(1.0)")


def numbers(value: ArrayLike, what: str, kinds: str = "fiu") -> Floats:
    """Returns an array of doubles in the order of its indices; `what` is the name of the argument in messages, `kinds` are letters of `dtype.kind`."""
    unmasked(value, what)
    try:
        array = np.asarray(value)
        # NumPy reads texts as numbers, and None as NaN.
        has_texts = array.dtype.kind == "O" and any(isinstance(item, (str, bytes, type(None))) for item in array.flat)
        if array.dtype.kind == "O" and not has_texts:
            array = array.astype(np.float64)
    except TypeError as error:
        raise TypeError(f"{what} cannot be read as numbers: {error}") from error
    except Exception as error:
        raise InputError(f"{what} cannot be read as numbers: {error}") from error
    if has_texts:
        raise TypeError(f"{what} holds texts or None; expected numbers")
    if array.dtype.kind not in kinds:
        raise TypeError(f"{what} holds {array.dtype}; expected numbers")
    # The buffer protocol requires aligned memory.
    return np.require(np.ascontiguousarray(array, dtype=np.float64), requirements="A")


def number(value: object, what: str) -> float:
    """Returns a single number."""
    array = numbers(value, what)  # type: ignore[arg-type]
    if array.size != 1:
        raise InputError(f"{what} has {array.size} numbers; expected one")
    return float(array.reshape(()))


def between(value: object, what: str, low: float, high: float, expected: str) -> float:
    """Returns a number above `low` and at most `high`."""
    single = number(value, what)
    if not low < single <= high:
        raise InputError(f"{what} is {single!r}; expected {expected}")
    return single


def share(value: object, what: str) -> float:
    """Returns a number above 0 and at most 1."""
    return between(value, what, 0.0, 1.0, "a number above 0 and at most 1, for example 0.5")


def positive(value: object, what: str) -> float:
    """Returns a positive finite number."""
    return between(value, what, 0.0, np.finfo(np.float64).max, "a positive number, for example 0.05")


def pair(value: object, what: str) -> tuple[float, float]:
    """Returns two finite numbers, the smaller number first."""
    array = numbers(value, what)  # type: ignore[arg-type]
    if array.shape != (2,) or not np.all(np.isfinite(array)) or not array[0] < array[1]:
        raise InputError(f"{what} expects two numbers, the smaller one first, for example (0.5, 2)")
    return float(array[0]), float(array[1])


def whole(value: object, what: str, low: int, high: int) -> int:
    """Returns an integer between two limits, limits included."""
    single = number(value, what)
    if not (low <= single <= high and single == int(single)):
        raise InputError(f"{what} is {single!r}; expected a whole number from {low} to {high}")
    return int(single)


def alone(value: object) -> object:
    """Returns the item of an array without axes; other values are returned unchanged."""
    return value.item() if isinstance(value, np.ndarray) and value.ndim == 0 else value


def switch(value: object, what: str) -> bool:
    """Returns a truth value; numbers are refused."""
    value = alone(value)
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    raise TypeError(f"{what} is {type(value).__name__}; expected True or False")


def place(value: object, what: str) -> str:
    """Returns the path of a file or a folder."""
    if not isinstance(value, (str, os.PathLike)):
        raise TypeError(f"{what} is {type(value).__name__}; expected a path")
    try:
        path = os.fspath(value)
    except Exception as error:
        raise InputError(f"{what} cannot be read as a path: {error}") from error
    if not isinstance(path, str):
        raise TypeError(f"{what} is a path of {type(path).__name__}; expected a string")
    if "\0" in path:
        raise InputError(f"{what} has the character 0; expected a path")
    return path


def write(text: str, path: object, what: str) -> None:
    """Writes a text into a file."""
    name = place(path, what)
    try:
        with open(name, "w", encoding="utf-8") as file:
            file.write(text)
    except OSError as error:
        raise MachineError(f"cannot write {name}: {error.strerror}\n  hint: expected the name of a file in a folder that exists") from error


def listed(value: object, what: str) -> list[Any]:
    """Returns the items of an iterable as a list."""
    if isinstance(value, (str, bytes)) or not isinstance(value, Iterable):
        raise TypeError(f"{what} is {type(value).__name__}; expected a list")
    try:
        return list(value)
    except Exception as error:
        raise InputError(f"{what} cannot be read as a list: {error}") from error


def names(given: Iterable[str], what: str) -> list[str]:
    """Returns a list of texts; a single text becomes a list."""
    told = [given] if isinstance(given, str) else listed(given, what)
    if not all(isinstance(name, str) for name in told):
        raise TypeError(f"{what} expects texts")
    return told


def typed(array: Floats) -> str:
    """Returns numbers separated by commas, with all digits."""
    return ",".join(repr(float(x)) for x in array.ravel())


def finite(value: ArrayLike, what: str) -> Floats:
    """Returns an array of finite doubles."""
    array = numbers(value, what)
    if not np.all(np.isfinite(array)):
        raise InputError(f"{what} has values that are not finite")
    return array


def deformations(F: ArrayLike | None, stretch: ArrayLike | None, dimension: int) -> tuple[Floats, tuple[int, ...]]:
    """Returns deformation gradients as rows of nine components, and the shape of the states.

    `F` has the shape (..., 3, 3), or (..., D, D) without strain out of the D dimensions. `stretch` has principal stretches along the axes, shape
    (..., D) to (..., 3); missing stretches are 1.
    """
    if (F is None) == (stretch is None):
        raise InputError("a state has `stretch` or `F`; give one of them")
    if F is not None:
        given = finite(F, "F")
        side = given.shape[-1] if given.ndim >= 2 else 0
        if given.ndim < 2 or given.shape[-2] != side or side not in (3, dimension):
            expected = "(..., 3, 3)" if dimension == 3 else f"(..., 3, 3) or (..., {dimension}, {dimension})"
            raise InputError(f"F has the shape {given.shape}; expected {expected}")
        full = np.zeros((*given.shape[:-2], 3, 3))
        full[...] = np.eye(3)
        full[..., :side, :side] = given
        return np.ascontiguousarray(full.reshape(-1, 9)), given.shape[:-2]
    given = finite(stretch if stretch is not None else [], "stretch")
    count = given.shape[-1] if given.ndim else 0
    if not dimension <= count <= 3:
        raise InputError(f"stretch has the shape {given.shape}; expected (..., {dimension}) to (..., 3)")
    full = np.zeros((*given.shape[:-1], 3, 3))
    full[...] = np.eye(3)
    for axis in range(count):
        full[..., axis, axis] = given[..., axis]
    return np.ascontiguousarray(full.reshape(-1, 9)), given.shape[:-1]


def state(F: ArrayLike | None, stretch: ArrayLike | None) -> tuple[str | None, str | None]:
    """Returns one state in the notation of the command line: its stretches, or the components of `F`."""
    if (F is None) == (stretch is None):
        raise InputError("a state has `stretch` or `F`; give one of them")
    if stretch is not None:
        given = numbers(stretch, "stretch")
        if given.ndim > 1:
            raise InputError(f"stretch has the shape {given.shape}; expected one number for each dimension")
        return typed(given), None
    return None, components(F if F is not None else [])


def components(F: ArrayLike) -> str:
    """Returns one deformation gradient in the notation of the command line."""
    given = numbers(F, "F")
    if given.ndim not in (0, 2) or given.ndim == 2 and given.shape[0] != given.shape[1]:
        raise InputError(f"F has the shape {given.shape}; expected (D, D) or (3, 3)")
    return typed(given)


def frames_of(
    x: Any, X: ArrayLike | None, time: ArrayLike | None, velocity: Any, F: Any, stress: Any, dimension: int
) -> tuple[Callable[[int], tuple[float, bytes, bytes | None, bytes | None, bytes | None]], int, Floats, list[bool], int]:
    """Returns a function that gives the fields of a frame, the number of frames, the reference positions, the components of stress that are given, and
    the number of skipped frames, which repeat a time."""

    def series(value: Any, what: str) -> tuple[Any, int]:
        # Slices of memory views with several axes are not defined.
        value = np.asarray(value) if isinstance(value, memoryview) else value
        try:
            if isinstance(value, Mapping) or not hasattr(value, "__getitem__"):
                raise TypeError("it cannot be indexed")
            return value, len(value)
        except TypeError as error:
            raise InputError(f"{what} has no frames; expected an array with an axis of frames, or a list of arrays") from error

    x, count = series(x, "x")
    if count < 2:
        raise InputError(f"x has {count} frame(s); growth needs at least two")

    def fields(value: Any, what: str) -> Any:
        if value is None:
            return None
        value, own = series(value, what)
        if own < count:
            raise InputError(f"{what} has {own} frame(s); expected {count}, one for each frame of x")
        return value

    velocity, F, stress = fields(velocity, "velocity"), fields(F, "F"), fields(stress, "stress")

    def vectors(value: object, what: str, expected: int | None) -> Floats:
        array = numbers(value, what)  # type: ignore[arg-type]
        if array.ndim != 2 or array.shape[1] not in (dimension, 3) or expected not in (None, len(array)):
            wanted = expected or "particles"
            raise InputError(f"{what} has the shape {array.shape}; expected ({wanted}, {dimension}) or ({wanted}, 3)")
        if len(array) == 0:
            raise InputError(f"{what} has no particles")
        full = np.zeros((len(array), 3))
        full[:, :dimension] = array[:, :dimension]
        return full

    given_reference = "x[0]" if X is None else "X"
    reference = vectors(x[0] if X is None else X, given_reference, None)
    # Fits use the squares of positions. NaN is not below the limit either. Later frames are checked like the frames of files.
    if not np.all(np.abs(reference) < 1e100):
        raise InputError(f"{given_reference} has values that are not finite and below 1e100")
    times = np.arange(count, dtype=float) if time is None else numbers(time, "time")
    if times.shape != (count,) or not np.all(np.isfinite(times)):
        raise InputError(f"time has the shape {times.shape}; expected {count} finite numbers, one for each frame")
    if np.any(np.diff(times) < 0):
        late = int(np.argmax(np.diff(times) < 0)) + 1
        raise InputError(f"time[{late}] is {float(times[late])!r}, before {float(times[late - 1])!r}; expected ascending times")
    used = [0, *(np.flatnonzero(np.diff(times) > 0) + 1).tolist()]

    def gradients(value: object, what: str) -> Floats:
        array = numbers(value, what)  # type: ignore[arg-type]
        side = array.shape[-1] if array.ndim else 0
        if array.ndim != 3 or array.shape[1] != side or side not in (dimension, 3):
            raise InputError(f"{what} has the shape {array.shape}; expected (points, {dimension}, {dimension}) or (points, 3, 3)")
        full = np.tile(np.eye(3), (len(array), 1, 1))
        full[:, :side, :side] = array
        return full

    columns = {3: [0, 1, 3], 4: [0, 1, 2, 3], 6: [0, 1, 2, 3, 4, 5]}
    given = [False] * 6

    def stresses(value: object, what: str) -> Floats:
        array = numbers(value, what)  # type: ignore[arg-type]
        if array.ndim != 2 or array.shape[1] not in columns:
            raise InputError(f"{what} has the shape {array.shape}; expected (points, 3) for xx, yy, xy or (points, 6) for xx, yy, zz, xy, xz, yz")
        full = np.zeros((len(array), 6))
        full[:, columns[array.shape[1]]] = array
        return full

    if stress is not None:
        stresses(stress[0], "stress[0]")
        width = np.shape(stress[0])[-1]
        given = [column in columns[width] for column in range(6)]

    def give(position: int) -> tuple[float, bytes, bytes | None, bytes | None, bytes | None]:
        number = used[position]
        return (
            float(times[number]),
            vectors(x[number], f"x[{number}]", len(reference)).tobytes(),
            None if velocity is None else vectors(velocity[number], f"velocity[{number}]", len(reference)).tobytes(),
            None if F is None else gradients(F[number], f"F[{number}]").tobytes(),
            None if stress is None else stresses(stress[number], f"stress[{number}]").tobytes(),
        )

    return give, len(used), reference, given, count - len(used)


def received(data: bytes, shape: Sequence[int]) -> Floats:
    """Returns an array from bytes of the compiled part."""
    return np.frombuffer(data, dtype=np.float64).reshape(tuple(shape))
