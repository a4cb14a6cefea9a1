"""Exceptions of the package, with the texts and hints of the command."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from threading import local
from typing import ParamSpec, TypeVar
import warnings

from . import _onset

P = ParamSpec("P")
T = TypeVar("T")

#: File, line and column of a setting.
Place = tuple[str, int, int]


class OnsetError(Exception):
    """Base class of all exceptions of the package. ``str`` returns the text that the command prints after ``error:``."""

    #: Description of the error, without hint and notes.
    message: str
    #: Remedy, or ``None``.
    hint: str | None
    #: Additional information.
    notes: tuple[str, ...]

    def __init__(self, text: str, key: str | None = None, place: Place | None = None) -> None:
        super().__init__(text, key, place)
        told: list[str] = []
        hints: list[str] = []
        notes: list[str] = []
        for line in text.split("\n"):
            if line.startswith("  hint: "):
                hints.append(line.removeprefix("  hint: "))
            elif line.startswith("  note: "):
                notes.append(line.removeprefix("  note: "))
            elif hints:
                hints.append(line)
            else:
                told.append(line)
        self.message = "\n".join(told)
        self.hint = "\n".join(hints) or None
        self.notes = tuple(notes)

    def __str__(self) -> str:
        return str(self.args[0])


class InputError(OnsetError, ValueError):
    """Invalid input: exit code 2 of the command. Also a `ValueError`."""


class SettingError(InputError):
    """Invalid setting: a key, a value, or a line of a file."""

    #: Key, for example ``discretization.support``; ``None`` if unknown.
    key: str | None
    #: File, line and column of the setting; ``None`` for an argument.
    place: Place | None

    def __init__(self, text: str, key: str | None = None, place: Place | None = None) -> None:
        super().__init__(text, key, place)
        self.key = key
        self.place = place


class MachineError(OnsetError, RuntimeError):
    """Failure with valid input: a file, a store, or a motion that breaks down; exit code 1 of the command. Also a `RuntimeError`."""


class _Asked(local):
    """Number of nested calls of public functions in a thread."""

    depth = 0


_asked = _Asked()


def asks(function: Callable[P, T]) -> Callable[P, T]:
    """Decorator of public functions: converts errors in arguments to exceptions of the package, and reports obsolete names as warnings.

    An exception carries the reports on obsolete names as notes.
    """

    @wraps(function)
    def asking(*arguments: P.args, **named: P.kwargs) -> T:
        is_outermost = _asked.depth == 0
        _asked.depth += 1
        try:
            answer = _told(function, *arguments, **named)
        except BaseException as error:
            for note in _onset.notes() if is_outermost else ():
                error.add_note(note)
            raise
        finally:
            _asked.depth -= 1
        for note in _onset.notes() if is_outermost else ():
            warnings.warn(note, UserWarning, stacklevel=2)
        return answer

    return asking


def _told(function: Callable[P, T], *arguments: P.args, **named: P.kwargs) -> T:
    """Calls a function, and converts errors in arguments to exceptions of the package."""
    try:
        return function(*arguments, **named)
    except OverflowError as error:
        raise InputError(f"a number is out of range: {error}") from error
    except UnicodeError as error:
        raise InputError(f"a text cannot be read: {error}") from error
