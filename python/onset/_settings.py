"""Materials, methods and studies: keyword arguments that are the keys of settings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from copy import copy
from functools import lru_cache
import numbers as abstract
import os
from pathlib import Path
import re
from typing import Self, cast
import warnings

import numpy as np
from numpy.typing import ArrayLike

from . import _onset
from ._arrays import Floats, alone, listed, names, number, numbers, place, received, unmasked, write
from ._errors import InputError, SettingError, asks
from ._functions import Handed, delivered, differentiated, has_jax, is_felupe, of_felupe
from ._trace import formula

#: Value of a key. A text may have a unit: ``"1 mm"``.
Value = str | float | int | bool | Sequence[float] | Sequence[str] | os.PathLike[str]


@lru_cache(maxsize=1)
def _keys() -> Mapping[str, str]:
    """Returns the expected values of each key."""
    return {name: expects for name, expects, _ in _onset.keys()}


def _key(section: str, name: str) -> str:
    """Returns the key for a keyword: ``lambda_`` is ``lambda``, ``artificial_stress`` is ``artificial-stress``.

    Parameters defined by a formula keep their underscores.
    """
    if not isinstance(name, str):
        raise TypeError(f"a key of [{section}] is {type(name).__name__}; expected its name")
    bare = name.rstrip("_")
    hyphened = f"{section}.{bare.replace('_', '-')}"
    if section != "material" or hyphened in _keys():
        return hyphened
    return f"{section}.{bare}"


def _shown(value: object) -> str:
    """Returns a value as Python writes it, with plain numbers instead of scalars of NumPy."""
    if isinstance(value, (list, tuple)):
        items = [item.item() if isinstance(item, np.generic) else item for item in value]
        value = tuple(items) if isinstance(value, tuple) else items
    return repr(value.item() if isinstance(value, np.generic) else value)


def _typed(value: object, key: str) -> str:
    """Returns a value in the notation of ``--set key=``."""
    unmasked(value, key)
    value = alone(value)
    if isinstance(value, str):
        return value
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, abstract.Real):
        try:
            return str(int(value)) if isinstance(value, abstract.Integral) else repr(float(value))
        except Exception as error:
            raise InputError(f"{key} cannot be read as a number: {error}") from error
    if isinstance(value, os.PathLike):
        return place(value, key)
    if isinstance(value, np.ndarray) or isinstance(value, Sequence) and not isinstance(value, (bytes, bytearray)):
        items = [alone(item) for item in listed(value, key)]
        if not any(isinstance(item, (Sequence, np.ndarray)) and not isinstance(item, str) for item in items):
            return ",".join(_typed(item, key) for item in items)
    raise TypeError(f"{key} is {type(value).__name__}; expected a number, a string, True or False, or a list of numbers")


_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?\Z")

#: Largest number of digits of an integer in a study; larger integers may overflow in the file.
_DIGITS = 18


def _bare(text: str) -> str | None:
    """Returns a number or a truth value in the notation of a study; ``None`` for other texts."""
    if text in ("true", "false", "inf", "-inf", "nan"):
        return text
    if _NUMBER.match(text) is None:
        return None
    digits = text.lstrip("+-")
    return str(int(text)) if digits.isdecimal() and len(digits) <= _DIGITS else repr(float(text))


def _number_or_text(text: str) -> float | str:
    """Returns the number that a text is, or the text."""
    if _NUMBER.match(text) is None:
        return text
    return int(text) if text.lstrip("+-").isdecimal() else float(text)


def quoted(text: object, key: str) -> str:
    """Returns a text in the notation of a study."""
    escaped = "".join(
        f"\\u{ord(letter):04x}" if ord(letter) < 32 or ord(letter) == 127 else letter
        for letter in _typed(text, key).replace("\\", "\\\\").replace('"', '\\"')
    )
    return f'"{escaped}"'


def toml(value: object, key: str) -> str:
    """Returns a value in the notation of a study; texts are read as after ``--set``."""
    value = alone(value)
    text = _typed(value, key)
    expects = _keys().get(key, "")
    if isinstance(value, os.PathLike) or expects == "a string":
        return quoted(text, key)
    is_list = expects.startswith("a list")
    if isinstance(value, (Sequence, np.ndarray)) and not isinstance(value, str) and (is_list or not expects):
        items = [_typed(item, key) for item in value]
    elif is_list:
        items = [item.strip().strip('"') for item in text.strip().removeprefix("[").removesuffix("]").split(",")]
    else:
        return _bare(text.strip()) or quoted(text, key)
    return "[" + ", ".join(_bare(item.strip()) or quoted(item, key) for item in items if item) + "]"


#: Ending of the name of a study or of a deck of another program.
_FILE = re.compile(r"\.(inp|feb|k|key|dyn|rad|dat|ans|cdb|mac|toml|py|txt)\Z", re.IGNORECASE)


class _Settings:
    """Immutable settings of one section."""

    _section = ""
    _set: Mapping[str, object]

    def _put(self, settings: Mapping[str, object]) -> None:
        """Sets keywords, overriding earlier settings."""
        earlier = getattr(self, "_set", {})
        keys = {**earlier, **{_key(self._section, name): value for name, value in settings.items()}}
        object.__setattr__(self, "_set", keys)
        object.__setattr__(self, "assignments", tuple(f"{key}={_typed(value, key)}" for key, value in keys.items()))
        self._check()

    def _check(self) -> None:
        """Checks names and values, which need no other settings, files or libraries."""
        _onset.check(list(self.assignments))

    #: Assignments ``KEY=VALUE``, as after ``--set`` of the command.
    assignments: tuple[str, ...]

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"{type(self).__name__} is immutable; `replace` returns a changed copy")

    def _meant(self) -> tuple[tuple[str, str | float], ...]:
        """Returns the settings in a form in which 1, 1.0 and "1" are equal."""
        pairs = (assignment.partition("=") for assignment in self.assignments)
        return tuple((key, float(text) if _NUMBER.match(text) else text) for key, _, text in pairs)

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and other._meant() == self._meant()

    def __hash__(self) -> int:
        return hash((type(self).__name__, self._meant()))

    def __repr__(self) -> str:
        named = (f"{key.partition('.')[2].replace('-', '_')}={_shown(value)}" for key, value in self._set.items())
        return f"{type(self).__name__}({', '.join(named)})"

    @asks
    def replace(self, **settings: Value) -> Self:
        """Returns a copy with other parameters or choices; all other settings are kept."""
        other = copy(self)
        other._put(settings)
        return other

    def _section_text(self) -> str:
        """Returns the settings as keys of a section of a study."""
        return "".join(f"{key.partition('.')[2]} = {toml(value, key)}\n" for key, value in self._set.items())


#: Function of the deformation and of parameters that returns an energy per reference volume, a stress or a tangent; stress.
Energy = Callable[..., object]

#: Number of states between two checks for signals.
_BATCH = 32768

_WORD = re.compile(r"[A-Za-z][A-Za-z0-9-]*\Z")


class Material(_Settings):
    """Material law with its parameters.

    - ``Material("neo-hooke", mu=0.4, lambda_=2)`` is a built-in law; ``onset.models`` lists the names.
    - ``Material("mu/2*(I1 - 3 - 2*ln(J))", mu=0.4)`` is a user-defined energy per reference volume, as a formula.
    - ``Material(lambda I1, J, mu: mu/2*(I1 - 3 - 2*np.log(J)), mu=0.4)`` is an energy as a Python function of ``F``, ``C`` or ``E`` of shape (3, 3),
      of ``J`` and the other variables of a formula, and of parameters. The function is called once with symbols, and the result is the formula.
    - A function that cannot be evaluated with symbols is differentiated by ``jax`` if installed (written with ``jax.numpy``), or is given with
      `stress` or `cauchy`, and `tangent`. These functions return the first Piola-Kirchhoff stress ``P_iJ = dW/dF_iJ`` or the Cauchy stress of shape
      (3, 3), and ``A_iJkL = dP_iJ/dF_kL`` of shape (3, 3, 3, 3); ``onset.audit`` checks that they are consistent. A law with only a stress,
      ``Material(stress=P)``, is complete: its tangent consists of central differences of the stress, with an error of about 1e-10 of the tangent, and
      its energy is the work of the stress from the reference state. The variables of such a law are ``F``, ``C``, ``E``, ``J``, ``I1``, ``I2``,
      ``I3``, ``I1bar`` and ``I2bar``. An `ArithmeticError` or `ValueError`, or a result that is not finite, means that the law is not defined at
      the state.
    - ``Material(felupe.NeoHooke(mu=1, bulk=2))`` is an elastic material of FElupe or matADi: any object with ``gradient`` and ``hessian``.
    - ``Material("umat", library="./my_umat.so", ...)`` is a user material of Abaqus/Standard, ``"vumat"`` is a user material of Abaqus/Explicit,
      ``"mfront"`` is a behavior of MFront, and ``"library"`` is the function of ``onset law-header``.

    Two of `young`, `poisson`, `bulk` and `shear` replace the parameters of laws with two moduli. Stresses are in any consistent unit, or all values
    have a unit: ``Material("neo-hooke", young="2 MPa", poisson=0.49)``.

    Without arguments it is the default law of the command. The name of the law, and the names and kinds of its parameters are checked here, as is a
    function. Checked at the first use are the range of the values, the text of a formula, and files and libraries, which may appear later.

    Raises
    ------
    SettingError
        If the law does not exist, or has no parameter of that name.
    InputError
        If a function cannot be converted to a law.

    Examples
    --------
    >>> onset.Material("neo-hooke", young=2.0, poisson=0.49)
    Material(model='neo-hooke', young=2.0, poisson=0.49)
    """

    _section = "material"

    @asks
    def __init__(
        self,
        model: str | Energy | object | None = None,
        *,
        energy: str | Energy | None = None,
        stress: Energy | None = None,
        cauchy: Energy | None = None,
        tangent: Energy | None = None,
        **parameters: Value,
    ) -> None:
        settings: dict[str, object] = {}
        is_felupe_material = is_felupe(model) and not isinstance(model, Material)
        if model is not None and (isinstance(model, type) or not (isinstance(model, str) or callable(model) or is_felupe_material)):
            raise TypeError(f"model is {type(model).__name__}; expected the name of a law, a formula, a function, or a material of FElupe")
        if model is not None and energy is not None and model != "formula":
            raise InputError("a material has one energy\n  hint: omit the model or `energy`")
        if isinstance(model, str) and model not in _onset.models() and (_FILE.search(model) or _is_file(model)):
            kind = "Study" if model.lower().endswith(".toml") else "Material"
            raise InputError(f"{model!r} is a file, not a law\n  hint: onset.{kind}.read({model!r}) reads it")
        if isinstance(model, str) and (model in _onset.models() or _WORD.match(model) is not None):
            settings["model"] = model
        elif model is not None:
            energy = cast("Energy", model)
        given: dict[str, object] = dict(parameters)
        has_functions = stress is not None or cauchy is not None or tangent is not None
        if has_functions and (is_felupe_material or "model" in settings):
            raise InputError("a material has one law\n  hint: omit the model, or `stress`, `cauchy` and `tangent`")
        if is_felupe_material:
            self._hand(of_felupe(model))
            self._put(given)
        elif has_functions:
            self._hand(delivered(energy, stress, cauchy, tangent, given))
        elif energy is not None and callable(energy):
            self._differentiate(energy, given)
        else:
            if energy is not None:
                settings |= {"model": "formula", "energy": energy}
            self._put(settings | given)

    #: Functions of the law; ``None`` for a built-in law or a formula.
    _handed: Handed | None = None

    def _hand(self, law: Handed) -> None:
        """Uses Python functions as the law."""
        object.__setattr__(self, "_handed", law)
        self._put(law.parameters)

    def _differentiate(self, energy: Energy, given: dict[str, object]) -> None:
        """Uses an energy as the law: as a formula if it can be evaluated with symbols, otherwise by automatic differentiation."""
        try:
            text, values = formula(energy, given)
        except Exception as untold:
            if not has_jax():
                raise InputError(f"{str(untold).splitlines()[0]}\n  hint: write the energy with jax.numpy and install jax, or give a stress: Material(stress=P)") from untold
            try:
                self._hand(differentiated(energy, given))
            except Exception as error:
                untold.add_note(f"jax cannot differentiate it either: {str(error).splitlines()[0]}")
                raise untold from error
        else:
            self._put({"model": "formula", "energy": text} | values)

    def _put(self, settings: Mapping[str, object]) -> None:
        law = self._handed
        if law is not None:
            bare = {name.rstrip("_"): number(value, name) for name, value in settings.items()}
            stray = sorted(set(bare) - set(law.parameters))
            if stray:
                raise InputError(f"no function of the material takes {stray[0]}\n  hint: its parameters are {', '.join(law.parameters) or 'none'}")
            settings = bare
        super()._put(settings)

    def _check(self) -> None:
        # The parameters of Python functions have been compared with their arguments.
        if self._handed is None:
            super()._check()

    def _assigned(self) -> list[str | _onset.Function]:
        """Returns the law as an argument of the compiled part."""
        if self._handed is None:
            return list(self.assignments)
        names = self._handed.parameters
        values = {key.partition(".")[2]: float(value) for key, _, value in (pair.partition("=") for pair in self.assignments)}
        return [_onset.Function(self._handed.respond, [(name, values[name]) for name in names])]

    def __eq__(self, other: object) -> bool:
        return super().__eq__(other) and isinstance(other, Material) and other._handed == self._handed

    def __hash__(self) -> int:
        return hash((super().__hash__(), self._handed))

    def __repr__(self) -> str:
        if self._handed is None:
            return super().__repr__()
        named = "".join(f", {name}={_shown(value)}" for name, value in ((key.partition(".")[2], value) for key, value in self._set.items()))
        return f"Material({self._handed.name}{named})"

    def _section_text(self) -> str:
        if self._handed is not None:
            raise InputError(
                "a study is a file, which cannot contain a Python function\n"
                "  hint: use onset.verdicts(material, method, F), or write the law as a formula"
            )
        return super()._section_text()

    @classmethod
    @asks
    def read(cls, block: str | os.PathLike[str], program: str | None = None, *, material: str | None = None) -> Material:
        """Reads the law from a deck of another program, as the commands do.

        Parameters
        ----------
        block
            Text of the block, or the path of a file. A text that is the path of an existing file is read as this path.
        program
            ``abaqus``, ``ansys``, ``calculix``, ``febio``, ``felupe``, ``hyperelastic``, ``lsdyna`` or ``radioss``; recognized by its keywords if omitted.
        material
            Name or number of one of several materials.

        Returns
        -------
        Material
            Law with `notes` on its constants, which ``onset.criteria`` and ``onset.card`` also print. A `UserWarning` names the parts of the block
            that are not read.

        Raises
        ------
        SettingError
            If the block has no law; with line and column.
        """
        is_text = isinstance(block, str) and any(mark in block for mark in "\n(*") and not _is_file(block)
        name, text = ("the block", str(block)) if is_text else source(block, "a block")
        assignments, notes = _onset.read_law(program, name, text, material, [])
        read = law_of(assignments)
        object.__setattr__(read, "notes", tuple(notes))
        for note in notes:
            if note.startswith("not read: "):
                # Above this function is the decorator.
                warnings.warn(note, UserWarning, stacklevel=4)
        return read

    #: Notes on the constants of a law that was read from a block of another program.
    notes: tuple[str, ...] = ()

    def _law(self) -> _onset.Law:
        return _onset.Law(self._assigned(), None, [], list(self.notes))

    def _responses(self, F: ArrayLike, part: slice) -> tuple[Floats, tuple[int, ...]]:
        given = numbers(F, "F")
        if given.shape[-2:] != (3, 3):
            raise InputError(f"F has the shape {given.shape}; expected (..., 3, 3)")
        states = given.reshape(-1, 9)
        found = np.empty((len(states), part.stop - part.start))
        law = self._law()
        # An interrupt is answered between batches, and only one batch has all 91 numbers.
        for first in range(0, max(len(states), 1), _BATCH):
            batch = states[first : first + _BATCH]
            found[first : first + _BATCH] = received(law.responses(batch, first), (-1, 91))[:, part]
        return found, given.shape[:-2]

    @asks
    def energy(self, F: ArrayLike) -> Floats:
        """Energy per reference volume ``W(F)``, shape (...); stress.

        Parameters
        ----------
        F
            Deformation gradients, shape (..., 3, 3).

        Raises
        ------
        InputError
            If the law is not defined at a state.
        """
        responses, shape = self._responses(F, slice(0, 1))
        return responses.reshape(shape)

    @asks
    def stress(self, F: ArrayLike) -> Floats:
        """First Piola-Kirchhoff stress ``P_iJ = dW/dF_iJ``, shape (..., 3, 3); stress.

        Parameters
        ----------
        F
            Deformation gradients, shape (..., 3, 3).

        Raises
        ------
        InputError
            If the law is not defined at a state.
        """
        responses, shape = self._responses(F, slice(1, 10))
        return responses.reshape(*shape, 3, 3)

    @asks
    def tangent(self, F: ArrayLike) -> Floats:
        """Tangent ``A_iJkL = dP_iJ/dF_kL``, shape (..., 3, 3, 3, 3); stress.

        Parameters
        ----------
        F
            Deformation gradients, shape (..., 3, 3).

        Raises
        ------
        InputError
            If the law is not defined at a state.
        """
        responses, shape = self._responses(F, slice(10, 91))
        return responses.reshape(*shape, 3, 3, 3, 3)

    @asks
    def gradient(self, x: Sequence[ArrayLike]) -> list[Floats | None]:
        """Stress ``P_iJ`` in the layout of FElupe materials, ``[P, None]`` with ``P`` of shape (3, 3, ...); stress.

        `x` is ``[F, state variables]`` with ``F`` of shape (3, 3, ...).
        """
        return [np.moveaxis(self.stress(_leading(x)), (-2, -1), (0, 1)), None]

    @asks
    def hessian(self, x: Sequence[ArrayLike]) -> list[Floats]:
        """Tangent ``A_iJkL`` in the layout of FElupe materials, ``[A]`` with ``A`` of shape (3, 3, 3, 3, ...); stress.

        `x` is ``[F, state variables]`` with ``F`` of shape (3, 3, ...).
        """
        return [np.moveaxis(self.tangent(_leading(x)), (-4, -3, -2, -1), (0, 1, 2, 3))]


def _is_file(text: str) -> bool:
    """Returns true if a text names an existing file."""
    try:
        return Path(text).is_file()
    except (OSError, ValueError):
        return False


def law_of(assignments: Iterable[str]) -> Material:
    """Returns the law with assignments ``material.key=value``."""
    law = Material()
    pairs = (assignment.partition("=") for assignment in assignments)
    law._put({key.removeprefix("material."): _number_or_text(text) for key, _, text in pairs})
    return law


def _leading(x: Sequence[ArrayLike]) -> Floats:
    """Returns the deformation gradients with the trailing axes first."""
    given = listed(x, "x")
    F = numbers(given[0] if given else [], "F")
    if F.ndim < 2:
        raise InputError(f"F has the shape {F.shape}; expected (3, 3, ...)")
    return np.moveaxis(F, (0, 1), (-2, -1))


class Method(_Settings):
    """Discretization: a family of methods with its choices.

    ``Method("updated-sph", lattice="square", kernel="cubic-spline", support=2.6)``. Keywords are the keys of ``[discretization]`` with underscores;
    ``onset.keys("discretization")`` lists them. `integrator` is ``time.integrator``. ``spacing`` is a length, ``density`` is mass/length^3, and ``support`` is in particle spacings.
    Without arguments it is the default method of the command. The names and kinds of choices are checked here; whether they fit each other and the
    material, at the first use.

    Raises
    ------
    SettingError
        If the family does not exist, a value is not one of the expected values, or the family never uses a key.

    Examples
    --------
    >>> onset.Method("updated-sph", lattice="square", kernel="cubic-spline", support=2.6)
    Method(method='updated-sph', lattice='square', kernel='cubic-spline', support=2.6)
    """

    _section = "discretization"

    @asks
    def __init__(self, method: str | None = None, **choices: Value) -> None:
        if method is not None and not isinstance(method, str):
            raise TypeError(f"method is {type(method).__name__}; expected the name of a family of methods")
        named: dict[str, object] = {} if method is None else {"method": method}
        self._put(named | choices)


#: Material, name of a law, or formula; ``None`` for the default law of the command.
MaterialLike = Material | str | None
#: Method, or name of a family of methods; ``None`` for the default method of the command.
MethodLike = Method | str | None


def material_of(material: MaterialLike) -> Material:
    """Returns a material from a material, a name or a formula."""
    if material is None or isinstance(material, str):
        return Material(material)
    if isinstance(material, Material):
        return material
    raise TypeError(
        f"material is {type(material).__name__}; expected an onset.Material, or the name of a law (a deformation is F=... or stretch=...)"
    )


def method_of(method: MethodLike) -> Method:
    """Returns a method from a method or the name of a family."""
    if method is None or isinstance(method, str):
        return Method(method)
    if isinstance(method, Method):
        return method
    raise TypeError(f"method is {type(method).__name__}; expected an onset.Method, or the name of a family")


@lru_cache(maxsize=64)
def _made(assignments: tuple[str, ...]) -> _onset.Problem:
    return _onset.Problem(list(assignments), None, [])


def problem_of(material: MaterialLike, method: MethodLike) -> _onset.Problem:
    """Returns material and method in compiled form. The result is cached unless it depends on a library or a Python function, which may change."""
    law, assignments = material_of(material), material_of(material).assignments + method_of(method).assignments
    if law._handed is not None:
        return _onset.Problem([*law._assigned(), *method_of(method).assignments], None, [])
    if any(assignment.startswith("material.library=") for assignment in assignments):
        return _onset.Problem(list(assignments), None, [])
    return _made(assignments)


#: Axis of a study: lowest and highest value in the unit of the quantity, and number of states, which lie in the middle of equal cells.
Axis = tuple[float | str, float | str, int]


class Study:
    """Material, method, fixed quantities and axes: the input of maps and boundaries.

    ``Study(text)`` reads the text of a study file, and ``Study.read("study.toml")`` reads the file. ``Study.of(material, method, axes={"stretch-1":
    (0.5, 2.0, 64), "stretch-2": (0.5, 2.0, 64)})`` writes a study. `name` is the name of the text in messages, `set` are assignments as after
    ``--set``, and `allow_library` lists the libraries of user materials that may be loaded.

    A study that cannot be read is a `SettingError` with line and column.
    """

    _study: _onset.Study

    @asks
    def __init__(
        self,
        text: str,
        *,
        name: str = "study",
        set: Iterable[str] = (),
        allow_library: Iterable[str | os.PathLike[str]] = (),
    ) -> None:
        if not isinstance(text, str):
            raise TypeError(f"a study is {type(text).__name__}; expected its text, see Study.read and Study.of")
        self._libraries = [place(path, "allow_library") for path in listed(allow_library, "allow_library")]
        self._study = _onset.Study((name, text), names(set, "set"), self._libraries)

    @classmethod
    @asks
    def read(cls, path: str | os.PathLike[str], *, set: Iterable[str] = (), allow_library: Iterable[str | os.PathLike[str]] = ()) -> Study:
        """Reads a study file.

        Parameters
        ----------
        path
            Path of the file.
        set
            Assignments as after ``--set``.
        allow_library
            Libraries that the file may load; no others are loaded.

        Raises
        ------
        InputError
            If the file cannot be read.
        """
        name, text = source(path)
        return cls(text, name=name, set=set, allow_library=allow_library)

    @classmethod
    @asks
    def of(
        cls,
        material: MaterialLike,
        method: MethodLike,
        axes: Mapping[str, Axis],
        *,
        title: str = "",
        state: Mapping[str, Value] | None = None,
        map: Mapping[str, Value] | None = None,
    ) -> Study:
        """Creates a study from objects.

        Parameters
        ----------
        material, method
            Material law and discretization; ``None`` for the defaults of the command.
        axes
            Two or three quantities (``stretch-1``, ``shear``, ``rotation`` or a key with a numerical value), each with ``(lowest, highest, states)``
            in the unit of the quantity.
        title
            Title of the study.
        state
            Keys of the fixed part of the deformation.
        map
            Keys for the computation of a map.

        Raises
        ------
        InputError
            If the law consists of Python functions that are not a formula, because a file cannot contain it.
        """
        if not isinstance(axes, Mapping):
            raise TypeError(f"axes is {type(axes).__name__}; expected quantities with (lowest, highest, states)")
        if not isinstance(title, str):
            raise TypeError(f"title is {type(title).__name__}; expected a string")
        text = f"title = {quoted(title, 'title')}\n" if title else ""
        text += f"\n[material]\n{material_of(material)._section_text()}"
        text += f"\n[discretization]\n{method_of(method)._section_text()}"
        for section, settings in (("state", state), ("map", map)):
            if settings is not None and not isinstance(settings, Mapping):
                raise TypeError(f"{section} is {type(settings).__name__}; expected keys with values")
            if settings:
                text += f"\n[{section}]\n"
                keys = {_key(section, name): value for name, value in settings.items()}
                text += "".join(f"{key.partition('.')[2]} = {toml(value, key)}\n" for key, value in keys.items())
        for quantity, axis in axes.items():
            if not isinstance(axis, Sequence) or isinstance(axis, str) or len(axis) != 3:
                raise TypeError(f"the axis {quantity} expects (lowest, highest, states): states lie in the middle of equal cells")
            low, high, count = axis
            name = quantity.replace("_", "-") if isinstance(quantity, str) else quantity
            text += f"\n[[axes]]\nquantity = {quoted(name, 'quantity')}\nrange = [{toml(low, name)}, {toml(high, name)}]\nstates = {_states(count)}\n"
        return cls(text)

    @property
    def text(self) -> str:
        """Study as the text of a file."""
        return self._study.text

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of states along each axis, slowest axis first."""
        return tuple(self._study.shape)

    @asks
    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the study file, for ``onset map`` and all other commands.

        Raises
        ------
        MachineError
            If the file cannot be written.
        """
        write(self.text, path, "a study")

    def __reduce__(self) -> tuple[Callable[[str, list[str]], Study], tuple[str, list[str]]]:
        return _restored, (self.text, self._libraries)

    def __repr__(self) -> str:
        return f"<onset.Study of {' x '.join(map(str, self.shape))} states>"


def _restored(text: str, libraries: list[str]) -> Study:
    """Returns a study that was pickled in another process."""
    return Study(text, allow_library=libraries)


def _states(count: object) -> str:
    count = alone(count)
    if isinstance(count, (int, np.integer)) and not isinstance(count, bool):
        return str(int(count))
    raise TypeError(f"the number of states is {type(count).__name__}; expected a whole number")


def source(path: str | os.PathLike[str], what: str = "a study") -> tuple[str, str]:
    """Returns the name and the text of a file."""
    name = place(path, what)
    try:
        return name, Path(name).read_text(encoding="utf-8-sig")
    except (OSError, ValueError) as error:
        raise InputError(f"cannot read {name}: {error}\n  hint: expected {what} in a file") from error


def study_of(study: Study | str | os.PathLike[str]) -> Study:
    """Returns a study from a study or a file."""
    return study if isinstance(study, Study) else Study.read(study)


__all__ = ["Axis", "Material", "MaterialLike", "Method", "MethodLike", "SettingError", "Study", "Value"]
