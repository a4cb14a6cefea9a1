"""What goes wrong: one family of exceptions, with the texts and hints of the command."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from threading import local
from typing import ParamSpec, TypeVar
import warnings

from . import _onset

P = ParamSpec("P")
T = TypeVar("T")

#: The file, line and column where a setting was made.
Place = tuple[str, int, int]


class OnsetError(Exception):
    """Why there is no answer: the family of all of them. ``str`` gives what the command prints after ``error:``."""

    #: What is wrong, without hint and notes.
    message: str
    #: What to do; ``None`` where nothing is known.
    hint: str | None
    #: What is known beside it.
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
    """What was asked cannot be answered: exit code 2 of the command. Also a `ValueError`."""


class SettingError(InputError):
    """A setting that cannot be accepted: a key, a value, or a line of a file."""

    #: The key, where it is known: ``discretization.support``.
    key: str | None
    #: The file, line and column where it was made; ``None`` where it was an argument.
    place: Place | None

    def __init__(self, text: str, key: str | None = None, place: Place | None = None) -> None:
        super().__init__(text, key, place)
        self.key = key
        self.place = place


class MachineError(OnsetError, RuntimeError):
    """What was asked is right, and could not be done: a file, a store, a motion that breaks down; exit code 1 of the command. Also a `RuntimeError`."""


class _Asked(local):
    """How many of our functions a thread is in."""

    depth = 0


_asked = _Asked()


def asks(function: Callable[P, T]) -> Callable[P, T]:
    """Makes everything that an argument can be wrong with one of our exceptions, and earlier names warnings where we were asked.

    Where an exception passes, what there is to know of earlier names goes with it.
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
    """What a function answers; what an argument is wrong with is one of our exceptions."""
    try:
        return function(*arguments, **named)
    except OverflowError as error:
        raise InputError(f"a number is out of range: {error}") from error
    except UnicodeError as error:
        raise InputError(f"a text cannot be read: {error}") from error
