"""Conversion of an energy from a Python function to a formula: the function is called once, with symbols."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
import inspect
import math
import numbers as abstract
import re
from typing import Any

import numpy as np

from ._errors import InputError

#: The components of tensors, in the order of their axes.
_AXES = (1, 2, 3)
#: Tensors that a function can take, of shape (3, 3).
_TENSORS = ("F", "C", "E")
#: Scalar arguments of a function, with their names in a formula.
_SCALARS = ("I1", "I2", "I3", "J", "I1bar", "I2bar", "lambda1", "lambda2", "lambda3", "I4", "I5", "I6", "I7")

#: Names of components in a formula.
_COMPONENT = re.compile(r"[CEF][123][123]\Z")

#: NumPy's functions of one number that a formula has under some name.
_FUNCTIONS = {
    "sqrt": "sqrt",
    "cbrt": "cbrt",
    "exp": "exp",
    "log": "ln",
    "log10": "log10",
    "sin": "sin",
    "cos": "cos",
    "tan": "tan",
    "sinh": "sinh",
    "cosh": "cosh",
    "tanh": "tanh",
    "absolute": "abs",
}
_OPERATORS = {"add": "+", "subtract": "-", "multiply": "*", "divide": "/", "true_divide": "/", "power": "^", "float_power": "^"}
_EXTREMES = {"minimum": "min", "maximum": "max", "fmin": "min", "fmax": "max"}
_COMPARISONS = {"less": "<", "less_equal": "<=", "greater": ">", "greater_equal": ">="}
_JOINED = {"logical_and": "and", "logical_or": "or", "bitwise_and": "and", "bitwise_or": "or"}


class Symbol:
    """Part of a formula: an operator or a function with its operands, or a name or number."""

    __slots__ = ("_operands", "_word")
    #: Operators of this class take precedence over operators of arrays.
    __array_priority__ = 1000

    def __init__(self, word: str, *operands: Symbol) -> None:
        self._word = word
        self._operands = operands

    # Operators.

    def __add__(self, other: object) -> Any:
        return _operation("+", self, other)

    def __radd__(self, other: object) -> Any:
        return _operation("+", other, self)

    def __sub__(self, other: object) -> Any:
        return _operation("-", self, other)

    def __rsub__(self, other: object) -> Any:
        return _operation("-", other, self)

    def __mul__(self, other: object) -> Any:
        return _operation("*", self, other)

    def __rmul__(self, other: object) -> Any:
        return _operation("*", other, self)

    def __truediv__(self, other: object) -> Any:
        return _operation("/", self, other)

    def __rtruediv__(self, other: object) -> Any:
        return _operation("/", other, self)

    def __pow__(self, other: object) -> Any:
        return _operation("^", self, other)

    def __rpow__(self, other: object) -> Any:
        return _operation("^", other, self)

    def __neg__(self) -> Symbol:
        return Symbol("-", self)

    def __pos__(self) -> Symbol:
        return self

    def __abs__(self) -> Symbol:
        return Symbol("abs", self)

    # Conditions.

    def __lt__(self, other: object) -> Any:
        return _operation("<", self, other)

    def __le__(self, other: object) -> Any:
        return _operation("<=", self, other)

    def __gt__(self, other: object) -> Any:
        return _operation(">", self, other)

    def __ge__(self, other: object) -> Any:
        return _operation(">=", self, other)

    def __and__(self, other: object) -> Any:
        return _operation("and", self, other)

    def __or__(self, other: object) -> Any:
        return _operation("or", self, other)

    def __invert__(self) -> Symbol:
        return Symbol("not", self)

    def __eq__(self, other: object) -> bool:
        raise InputError(
            "the function tests a quantity that depends on the state for equality\n"
            "  hint: a case is numpy.where(condition, value, otherwise) with < or >"
        )

    __ne__ = __eq__
    __hash__ = object.__hash__

    def __bool__(self) -> bool:
        raise InputError(
            "the function tests whether a quantity that depends on the state is true\n"
            "  hint: a case is numpy.where(condition, value, otherwise), a limit numpy.minimum or numpy.maximum"
        )

    # Numbers.

    def __float__(self) -> float:
        raise InputError(
            "the function converts a quantity that depends on the state to a plain number\n"
            "  hint: numpy's functions (numpy.log, not math.log) work with symbols"
        )

    __int__ = __index__ = __complex__ = __float__

    # Functions of NumPy, which also accept arrays of symbols.

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: object, **options: object) -> Any:
        if method != "__call__" or options:
            return NotImplemented
        if any(isinstance(own, np.ndarray) and own.ndim > 0 for own in inputs):
            # Each element of the array is traced separately.
            parts = np.broadcast(*(_objects(own) for own in inputs))
            results = [_called(ufunc.__name__, part) for part in parts]
            return np.array(results + [None], dtype=object)[:-1].reshape(parts.shape).view(Tensor)
        return _called(ufunc.__name__, tuple(inputs))

    def __array_function__(self, function: Callable[..., Any], types: object, args: Sequence[Any], options: Mapping[str, Any]) -> Any:
        return _dispatched(function, args, options)

    def __repr__(self) -> str:
        return f"<onset: {written(self)}>"


def _method(name: str) -> Callable[[Symbol], Any]:
    """Returns a method with the name of a NumPy function; NumPy calls it for each item of an array of objects."""

    def method(self: Symbol) -> Any:
        return _called(name, (self,))

    method.__name__ = name
    return method


for _name in (*_FUNCTIONS, "square", "reciprocal", "log1p", "expm1", "log2", "positive", "negative"):
    setattr(Symbol, _name, _method(_name))


class Tensor(np.ndarray[Any, Any]):
    """Array of symbols that supports determinants and inverses."""

    def __array_function__(self, func: Callable[..., Any], types: Any, args: Any, kwargs: Any) -> Any:
        return _dispatched(func, args, kwargs)


def _dispatched(function: Callable[..., Any], args: Sequence[Any], options: Mapping[str, Any]) -> Any:
    own = _ARRAY_FUNCTIONS.get(function)
    if own is not None:
        return own(*args, **options)
    plain = [np.asarray(_objects(arg)) if isinstance(arg, (Symbol, Tensor)) else arg for arg in args]
    result = function(*plain, **options)
    return result.view(Tensor) if isinstance(result, np.ndarray) else result


def _objects(value: object) -> np.ndarray[Any, Any]:
    """An array whose parts are symbols or numbers."""
    if isinstance(value, Symbol):
        array = np.empty((), dtype=object)
        array[()] = value
        return array
    return np.asarray(value, dtype=object)


def _where(condition: Any, value: Any, otherwise: Any) -> Any:
    def chosen(condition: Any, value: Any, otherwise: Any) -> Any:
        if isinstance(condition, Symbol):
            return Symbol("if", condition, _symbol(value), _symbol(otherwise))
        return value if condition else otherwise

    arrays = [_objects(part) for part in (condition, value, otherwise)]
    if all(array.ndim == 0 for array in arrays):
        return chosen(*(array[()] for array in arrays))
    return np.frompyfunc(chosen, 3, 1)(*arrays).view(Tensor)


def _square(tensor: Any) -> np.ndarray[Any, Any]:
    array = np.asarray(_objects(tensor))
    if array.ndim != 2 or array.shape[0] != array.shape[1]:
        raise InputError(f"an array has the shape {array.shape}; expected a square matrix")
    return array


def _determinant(tensor: Any) -> Any:
    array = _square(tensor)
    if array.shape == (1, 1):
        return array[0, 0]
    total = array[0, 0] * _determinant(_minor(array, 0, 0))
    for j in range(1, array.shape[0]):
        minor = array[0, j] * _determinant(_minor(array, 0, j))
        total = total - minor if j % 2 else total + minor
    return total


def _minor(array: np.ndarray[Any, Any], i: int, j: int) -> np.ndarray[Any, Any]:
    return np.delete(np.delete(array, i, axis=0), j, axis=1)


def _inverse(tensor: Any) -> Any:
    array = _square(tensor)
    determinant = _determinant(array)
    inverse = np.empty_like(array)
    for i, j in np.ndindex(array.shape):
        cofactor = _determinant(_minor(array, i, j)) if array.shape[0] > 1 else 1
        inverse[j, i] = (-cofactor if (i + j) % 2 else cofactor) / determinant
    return inverse.view(Tensor)


_ARRAY_FUNCTIONS: dict[Callable[..., Any], Callable[..., Any]] = {
    np.where: _where,
    np.linalg.det: _determinant,
    np.linalg.inv: _inverse,
}


def _symbol(value: object) -> Symbol:
    """Returns a number as a part of a formula."""
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value.item()
    if isinstance(value, Symbol):
        return value
    if isinstance(value, (bool, np.bool_, np.complexfloating)) or not isinstance(value, (abstract.Real, np.number)):
        raise InputError(f"the function computes with {type(value).__name__}, which a formula does not support\n  hint: use numbers and NumPy's functions")
    number = int(value) if isinstance(value, abstract.Integral) else float(value)
    if isinstance(number, int) and abs(number) >= 2**1023 or not math.isfinite(number):
        raise InputError(f"the function computes with the number {number}; expected finite ones")
    text = repr(number)
    return Symbol("-", Symbol(text[1:])) if text.startswith("-") else Symbol(text)


def _operation(word: str, left: object, right: object) -> Any:
    """Applies an operator to two parts, or elementwise to arrays."""
    if isinstance(left, np.ndarray) and left.ndim > 0 or isinstance(right, np.ndarray) and right.ndim > 0:
        return NotImplemented
    return Symbol(word, _symbol(left), _symbol(right))


def _called(name: str, operands: Sequence[object]) -> Any:
    """Applies a NumPy function to parts of a formula."""
    if name in _FUNCTIONS:
        return Symbol(_FUNCTIONS[name], _symbol(operands[0]))
    if name in _EXTREMES:
        return Symbol(_EXTREMES[name], *map(_symbol, operands))
    words = {**_OPERATORS, **_COMPARISONS, **_JOINED}
    if name in words:
        return Symbol(words[name], *map(_symbol, operands))
    x = _symbol(operands[0])
    match name:
        case "negative":
            return -x
        case "positive":
            return x
        case "square":
            return x**2
        case "reciprocal":
            return 1 / x
        case "log1p":
            return Symbol("ln", 1 + x)
        case "expm1":
            return Symbol("exp", x) - 1
        case "log2":
            return Symbol("ln", x) / float(np.log(2.0))
        case "logical_not" | "invert":
            return Symbol("not", x)
        case _:
            known = ", ".join(sorted({*_FUNCTIONS, *_EXTREMES, "square", "where"}))
            raise InputError(f"the function calls numpy.{name}, which a formula does not have\n  hint: it has {known}")


#: Precedence of the operators.
_BINDING = {"or": 1, "and": 2, "not": 3, "<": 4, "<=": 4, ">": 4, ">=": 4, "+": 5, "-": 5, "*": 6, "/": 6, "^": 8}
_NEGATED = 7
_ATOM = 9


def written(symbol: Symbol) -> str:
    """Returns the formula; parts that occur several times are named first."""
    uses: dict[int, int] = {}
    order: list[Symbol] = []

    def count(root: Symbol) -> None:
        # No recursion, because sums may be long.
        stack = [(root, False)]
        while stack:
            part, is_done = stack.pop()
            if is_done:
                order.append(part)
                continue
            uses[id(part)] = uses.get(id(part), 0) + 1
            if uses[id(part)] == 1:
                stack.append((part, True))
                stack.extend((operand, False) for operand in reversed(part._operands))

    count(symbol)
    texts: dict[int, tuple[str, int]] = {}
    helpers: list[str] = []
    names = {part._word for part in order if not part._operands}
    prefix = "part"
    while any(name.startswith(prefix) for name in names):
        prefix += "_"
    for part in order:
        text, binding = _text(part, [texts[id(operand)] for operand in part._operands])
        # A condition is not a number, and has no name.
        is_number = part._word not in _JOINED.values() and part._word not in _COMPARISONS.values() and part._word != "not"
        if part._operands and uses[id(part)] > 1 and is_number:
            name = f"{prefix}{len(helpers) + 1}"
            helpers.append(f"let {name} = {text}; ")
            text, binding = name, _ATOM
        texts[id(part)] = (text, binding)
    return "".join(helpers) + texts[id(symbol)][0]


def _text(part: Symbol, operands: list[tuple[str, int]]) -> tuple[str, int]:
    """A part with how tightly it binds."""
    word = part._word
    if not operands:
        return word, _ATOM
    if word == "-" and len(operands) == 1:
        return f"-{_within(operands[0], _NEGATED)}", _NEGATED
    if word == "not":
        return f"not {_within(operands[0], _ATOM)}", _BINDING[word]
    if word in _BINDING:
        own = _BINDING[word]
        # Equal operators associate to the left, powers to the right. Comparisons are not chained.
        left = own + 1 if word == "^" or own == 4 else own
        space = "" if word in "*/^" else " "
        return f"{_within(operands[0], left)}{space}{word}{space}{_within(operands[1], own + 1)}", own
    return f"{word}({', '.join(text for text, _ in operands)})", _ATOM


def _within(operand: tuple[str, int], least: int) -> str:
    text, binding = operand
    return text if binding >= least else f"({text})"


def _tensor(name: str) -> Tensor:
    parts = [[Symbol(f"{name}{i}{j}") for j in _AXES] for i in _AXES]
    return np.array(parts, dtype=object).view(Tensor)


def formula(energy: Callable[..., Any], parameters: Mapping[str, object]) -> tuple[str, dict[str, object]]:
    """The formula that a function computes, and its parameters with their values.

    Arguments that are called as a formula calls its variables are these (``F``, ``C`` and ``E`` of shape (3, 3)); others are parameters, whose
    values are given or their defaults.
    """
    try:
        arguments = inspect.signature(energy).parameters.values()
    except (TypeError, ValueError) as error:
        raise InputError(f"the arguments of the energy cannot be determined: {error}\n  hint: give a function of F, C, E or invariants, and of parameters") from error
    values = dict(parameters)
    given: dict[str, Any] = {}
    positional: list[Any] = []
    for argument in arguments:
        if argument.kind in (argument.VAR_POSITIONAL, argument.VAR_KEYWORD):
            raise InputError(f"the energy takes *{argument.name}\n  hint: name each argument: variables of a formula, or parameters")
        name = argument.name
        if name in _TENSORS:
            own: Any = _tensor(name)
        elif name in _SCALARS:
            own = Symbol(name)
        else:
            if name not in values and argument.default is not argument.empty:
                values[name] = argument.default
            if name not in values:
                raise InputError(
                    f"the energy takes {name}, which has no value\n  hint: give it, {name}=...; variables are {', '.join((*_TENSORS, *_SCALARS))}"
                )
            if _COMPONENT.match(name):
                raise InputError(f"the parameter {name} is called like a component of a tensor\n  hint: call it otherwise, c{name[1:]} for example; tensors are C, E and F")
            own = Symbol(name.rstrip("_"))
        if argument.kind is argument.POSITIONAL_ONLY:
            positional.append(own)
        else:
            given[name] = own
    try:
        result = energy(*positional, **given)
    except TypeError as error:
        raise InputError(f"the energy cannot be computed with symbols: {error}\n  hint: operators and NumPy's functions of its arguments") from error
    if np.ndim(result) > 0:
        raise InputError(f"the energy has the shape {np.shape(result)}; expected a number")
    return written(_symbol(result)), values
