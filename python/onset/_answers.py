"""Answers: the documents that the command prints with ``--json``, as objects with named attributes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
import html
import json
import os
from typing import TYPE_CHECKING, Any, Self, cast

import numpy as np
from numpy.typing import NDArray

from . import _onset
from ._arrays import Complexes, Floats, place, received, whole, write
from ._errors import InputError, asks
from ._exports import Cell, Mode, band_yaml

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class Record(Mapping[str, Any]):
    """A part of an answer, frozen: ``part.growth_rate`` is ``part["growth_rate"]``.

    Lists of numbers are arrays, complex numbers complex, lists of parts tuples. Numbers that do not exist are NaN in arrays and ``None`` alone. Names with
    hyphens or dots are attributes with underscores; those that Python has taken get one behind (``crossing.from_``). A name that is not there is an
    `AttributeError` that tells those that are.
    """

    __slots__ = ("_fields",)
    _fields: Mapping[str, Any]

    def __init__(self, fields: Mapping[str, Any]) -> None:
        object.__setattr__(self, "_fields", fields)

    def __getitem__(self, name: str) -> Any:
        return _value(self._fields[name])

    def __iter__(self) -> Iterator[str]:
        return iter(self._fields)

    def __len__(self) -> int:
        return len(self._fields)

    def __getattr__(self, name: str) -> Any:
        # What notebooks and copies look for is none of the document.
        if name.startswith("_"):
            raise AttributeError(name)
        fields = self._fields
        if name in fields:
            return _value(fields[name])
        for own, value in fields.items():
            if _attribute(own) == name.rstrip("_"):
                return _value(value)
        raise AttributeError(f"this answer has no {name!r}; it has {', '.join(_attribute(own) for own in fields)}")

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError("answers are frozen")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *(_attribute(name) for name in self._fields)]

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and other._fields == self._fields

    def __hash__(self) -> int:
        return hash(json.dumps(self._fields, sort_keys=True))

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(_attribute(name) for name in self._fields)})"

    def __reduce__(self) -> tuple[type[Record], tuple[Mapping[str, Any]]]:
        return Record, (self._fields,)

    def to_dict(self) -> dict[str, Any]:
        """The same as plain dictionaries, lists and numbers, as in the document."""
        return cast("dict[str, Any]", json.loads(json.dumps(self._fields)))


def _attribute(name: str) -> str:
    return name.replace("-", "_").replace(".", "_")


def _is_complex(value: object) -> bool:
    return isinstance(value, dict) and value.keys() == {"re", "im"}


def _value(value: Any) -> Any:
    """A value of a document: arrays of numbers, complex numbers, parts."""
    if isinstance(value, dict):
        return complex(value["re"], value["im"]) if _is_complex(value) else Record(value)
    if isinstance(value, list):
        array = _array(value)
        return tuple(_value(item) for item in value) if array is None else array
    return value


def _array(items: list[Any]) -> Any:
    """An array where all items are numbers, or lists of one length of them; otherwise nothing."""
    flat: list[Any] = items
    shape = [len(items)]
    while flat and all(isinstance(item, list) for item in flat):
        lengths = {len(item) for item in flat}
        if len(lengths) != 1:
            return None
        shape.append(lengths.pop())
        flat = [inner for item in flat for inner in item]
    is_number = [isinstance(item, (int, float)) and not isinstance(item, bool) for item in flat]
    if any(is_number) and all(known or item is None for known, item in zip(is_number, flat, strict=True)):
        return np.array([np.nan if item is None else item for item in flat]).reshape(shape)
    if flat and all(_is_complex(item) for item in flat):
        return np.array([complex(item["re"], item["im"]) for item in flat]).reshape(shape)
    return None


class Answer(Record):
    """An answer of a command.

    ``str(answer)`` is the text that the command prints, ``answer.json`` its document of ``--json`` to the last byte, ``answer.csv`` its
    table; ``answer.save(folder)`` writes the files of ``--out``.
    """

    __slots__ = ("_answer", "_files")
    _answer: _onset.Answer
    _files: dict[str, bytes] | None

    def __init__(self, answer: _onset.Answer) -> None:
        if not isinstance(answer, _onset.Answer):
            raise TypeError(
                f"{type(self).__name__} is what a question answers, as onset.state(...) does; "
                "a deformation is an argument of the question, stretch=(1.2, 0.9) or F=[[1, 0.1], [0, 1]]"
            )
        super().__init__(json.loads(answer.json))
        object.__setattr__(self, "_answer", answer)
        object.__setattr__(self, "_files", None)

    def __copy__(self) -> Answer:
        return self

    def __deepcopy__(self, _: object) -> Answer:
        return self

    @property
    def json(self) -> str:
        """The document that the command prints with ``--json``."""
        return self._answer.json

    @property
    def csv(self) -> str:
        """The table that the command prints with ``--format csv``."""
        return self._answer.csv

    def __str__(self) -> str:
        return self._answer.text

    def __repr__(self) -> str:
        return f"<onset.{type(self).__name__}: {self._answer.text.partition(chr(10))[0]}>"

    @asks
    def files(self) -> dict[str, bytes]:
        """The files that the command writes with ``--out``, their contents by name; made once."""
        if self._files is None:
            object.__setattr__(self, "_files", self._answer.files())
        return dict(self._files or {})

    @asks
    def save(self, folder: str | os.PathLike[str]) -> list[str]:
        """Writes the files of ``--out`` into a folder, and returns their paths. A `MachineError` where they cannot be written."""
        return self._answer.save(place(folder, "folder"))

    def _picture(self) -> str | None:
        """The figure as SVG, where there is one that can be drawn."""
        try:
            files = self.files()
        except Exception:
            return None
        pictures = [data for name, data in files.items() if name.endswith(".svg")]
        return pictures[0].decode() if pictures else None

    def _repr_html_(self) -> str:
        first, _, rest = self._answer.text.partition("\n")
        picture = self._picture() or ""
        return (
            f"<div><p><strong>{html.escape(first)}</strong></p>{picture}"
            f"<details{'' if picture else ' open'}><summary>all of it</summary><pre>{html.escape(rest.strip())}</pre></details></div>"
        )

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws the figure of the answer; into `ax`, where it is given. An answer without one is an `OnsetError`."""
        from . import _plots

        return _plots.picture(self.files(), ax)


class _Moving(Answer):
    """An answer with waves, which move particles."""

    __slots__ = ("_cell",)
    #: The particles that the waves move.
    _cell: Callable[[], Cell]

    def _of(self, cell: Callable[[], Cell]) -> Self:
        object.__setattr__(self, "_cell", cell)
        return self

    def _mode(self, k: Floats, matrix: Complexes, branch: int, cells: int | Sequence[int] | None, amplitude: float) -> Mode:
        """A branch of a dynamical matrix; the first is 1."""
        cell = self._cell()
        values, vectors = cell.waves(matrix)
        own = whole(branch, "branch", 1, len(values)) - 1
        return Mode(cell, k, values[own], vectors[:, own], cells, amplitude)


class State(_Moving):
    """The verdict on a state with its evidence, in the parts ``material``, ``material_3d`` (not in plane stress) and ``discretization``."""

    __slots__ = ("_spectrum",)
    _spectrum: Callable[[Floats], tuple[Complexes, Floats]]

    @property
    def verdict(self) -> str:
        """``stable``, ``physical``, ``numerical``, ``zero-energy`` or ``suppressed``."""
        return cast(str, self._fields["verdict"])

    @property
    def mechanism(self) -> str | None:
        """Of a numerical instability: ``tensile``, ``compressive``, ``flutter`` or ``long-wave``; otherwise ``None``."""
        return cast("str | None", self._fields["mechanism"])

    @property
    def sentence(self) -> str:
        """The verdict in plain English."""
        return cast(str, self._fields["sentence"])

    @property
    def stable(self) -> bool:
        """Whether no wave of the particles grows: all ``omega^2`` are real and nonnegative."""
        return cast(bool, self._fields["discretization"]["stable"])

    @property
    def growth_rate(self) -> float:
        """That of the fastest growing wave, ``max |Im omega|``, 0 where none grows; 1/time."""
        return cast(float, self._fields["discretization"]["growth_rate"])

    @property
    def wave_vector(self) -> Floats:
        """The reference wave vector of the softest or fastest growing wave, shape (D,); 1/length."""
        return np.array(self._fields["discretization"]["wave_vector"], dtype=np.float64)

    @property
    def critical_time_step(self) -> float | None:
        """The largest stable time step of central differences, ``2/omega_max``, or of a transfer of material points, of the infinite lattice: free faces and distorted cells need less; time. ``None`` where nothing oscillates."""
        return cast("float | None", self._fields["discretization"]["critical_time_step"])

    @property
    def finite_bodies(self) -> dict[str, Any] | None:
        """A ``time_step`` for finite bodies of the lattice, whether it is ``proved``, and its ``ground``; ``None`` where nothing is known of them."""
        return cast("dict[str, Any] | None", self._fields["discretization"]["finite_bodies"])

    @property
    def cauchy(self) -> Floats:
        """The Cauchy stress ``P F^T / det F``, shape (3, 3); stress."""
        return np.array(self._fields["material"]["cauchy"], dtype=np.float64)

    @property
    def minimum_acoustic_eigenvalue(self) -> float:
        """The smallest eigenvalue of the acoustic tensor ``Q_ik = A_iJkL N_J N_L`` over all directions ``N`` in the dimensions of the lattice; stress."""
        return cast(float, self._fields["material"]["minimum_acoustic_eigenvalue"])

    @property
    def elliptic(self) -> bool:
        """Whether the material is strongly elliptic for waves in the dimensions of the lattice."""
        return cast(bool, self._fields["material"]["elliptic"])

    @asks
    def mode(self, *, cells: int | Sequence[int] | None = None, amplitude: float = 0.1) -> Mode:
        """The fastest growing wave, or the softest of a stable state, on a patch of particles: see `Mode`, and `Waves.mode` for the arguments.

        An ``InputError`` where it is the limit of long waves, which has no one wavelength.
        """
        cell, k = self._cell(), self.wave_vector
        values, vectors = cell.waves(cell.dynamical_matrix(k))
        growth = np.abs(np.sqrt(values).imag)
        own = 0 if self.stable else int(np.argmax(growth))
        if not np.any(k) and (self.stable or growth[own] < 1e-6 * self._fields["discretization"]["maximum_omega"]):
            raise InputError(
                "the mode is the limit of long waves, which has no one wavelength\n"
                "  hint: onset.waves(material, method, wave_vector=..., stretch=...).mode() is that of a wave vector"
            )
        return Mode(cell, k, values[own], vectors[:, own], cells, amplitude)

    def _with_spectrum(self, spectrum: Callable[[Floats], tuple[Complexes, Floats]]) -> State:
        object.__setattr__(self, "_spectrum", spectrum)
        return self

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws ``omega^2`` (1/time^2) of particles and continuum along the wave vector of the softest wave, and beyond it."""
        from . import _plots

        return _plots.along_wave(self.wave_vector, self._spectrum, ax)


class Waves(_Moving):
    """The waves with one wave vector."""

    __slots__ = ()

    @asks
    def mode(self, branch: int = 1, *, cells: int | Sequence[int] | None = None, amplitude: float = 0.1) -> Mode:
        """A wave on a patch of particles, to be exported: see `Mode`.

        `branch` counts from 1 by increasing real part of ``omega^2``. `cells` of the patch along each primitive vector, one number or D; by default the fewest, of 4 to 24,
        that hold whole wavelengths, and 12 where none of them do. `amplitude` is the largest displacement, in particle spacings, above 0 and at most 1. An ``InputError``
        for arguments that cannot be.
        """
        return self._mode(np.array(self._fields["wave_vector"], dtype=np.float64), self.dynamical_matrix, branch, cells, amplitude)

    @property
    def omega_squared(self) -> Complexes:
        """``omega^2`` of the particles, ``omega^2 g = D(k) g``, by increasing real part, shape (branches,); 1/time^2."""
        return np.asarray(_value(self._fields["omega_squared"]), dtype=np.complex128)

    @property
    def continuum_omega_squared(self) -> Floats:
        """``omega^2`` of the continuum, ``rho_0 omega^2 g = Q(k) g``, shape (D,); 1/time^2."""
        return np.array(self._fields["continuum_omega_squared"], dtype=np.float64)

    @property
    def dynamical_matrix(self) -> Complexes:
        """The dynamical matrix ``D(k)``, shape (branches, branches); 1/time^2."""
        return np.asarray(_value(self._fields["dynamical_matrix"]), dtype=np.complex128)

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws ``omega^2`` of the particles beside those of the continuum."""
        from . import _plots

        return _plots.levels(self.omega_squared, self.continuum_omega_squared, ax)


class Bands(_Moving):
    """The dispersion relation at ``n`` samples along a path through the zone; ``critical`` is the critical wave, ``density_of_states`` the density of states."""

    __slots__ = ()

    @asks
    def mode(self, at: int | str, branch: int = 1, *, cells: int | Sequence[int] | None = None, amplitude: float = 0.1) -> Mode:
        """A wave of the path on a patch of particles: of the sample with the index `at`, or of the first corner of that name. Other arguments as of `Waves.mode`."""
        if isinstance(at, str):
            at = {"G": "Γ", "Gamma": "Γ"}.get(at, at.replace("'", "′"))
            if at not in self.labels:
                raise InputError(f"the path has no corner {at!r}\n  hint: it has {', '.join(self.labels)}")
            index = int(np.searchsorted(self.lengths, self.corners[self.labels.index(at)]))
        else:
            index = whole(at, "at", -len(self.lengths), len(self.lengths) - 1)
        return self._mode(self.k[index], self.dynamical_matrices[index], branch, cells, amplitude)

    @asks
    def to_yaml(self, path: str | os.PathLike[str] | None = None, *, symbol: str = "X") -> str:
        """The bands in the layout of phonopy's ``band.yaml``, as a text; written into a file where `path` is given.

        ``frequency`` is ``sign(omega^2) sqrt(|omega^2|) / (2 pi)`` in 1/time: below zero stands a wave that grows without oscillating, by its growth
        rate over ``2 pi``. Flutter has no place in the layout: an ``InputError`` where an ``omega^2`` is complex beyond rounding. ``eigenvector`` has
        real and imaginary parts of ``e = sqrt(m) u`` of length 1, three for each particle of the cell, zero beyond the dimensions of the lattice;
        particles move by ``Re(e exp(i k.X)) / sqrt(m)``. There are as many bands as branches. ``lattice``, ``reciprocal_lattice`` (without ``2 pi``) and
        ``distance`` are those of the current configuration, with a vector as long as the particle spacing in each direction without waves; ``q-position`` is in
        units of the reciprocal vectors, where reference and current configuration agree. Each segment has both of its ends. ``mass`` is per unit of the
        dimensions that are left out. All particles have one chemical `symbol`, by default that of no element. A ``MachineError`` where the file cannot be written.
        """
        text = band_yaml(self, self._cell(), symbol)
        if path is not None:
            write(text, path, "path")
        return text

    @property
    def k(self) -> Floats:
        """The reference wave vectors of the samples, shape (n, D); 1/length."""
        return np.array([sample["wave_vector"] for sample in self._fields["samples"]], dtype=np.float64)

    @property
    def lengths(self) -> Floats:
        """Length along the path of each sample, shape (n,); 1/length."""
        return np.array(self._fields["lengths"], dtype=np.float64)

    @property
    def omega_squared(self) -> Complexes:
        """``omega^2`` of the particles by increasing real part, shape (n, branches); 1/time^2."""
        return np.asarray(_value([sample["omega_squared"] for sample in self._fields["samples"]]), dtype=np.complex128)

    @property
    def continuum_omega_squared(self) -> Floats:
        """``omega^2`` of the continuum, shape (n, D); 1/time^2."""
        return np.array([sample["continuum_omega_squared"] for sample in self._fields["samples"]], dtype=np.float64)

    @property
    def dynamical_matrices(self) -> Complexes:
        """``D(k)`` of the samples, shape (n, branches, branches); 1/time^2."""
        return np.asarray(_value([sample["dynamical_matrix"] for sample in self._fields["samples"]]), dtype=np.complex128)

    @property
    def labels(self) -> tuple[str, ...]:
        """The names of the corners, as they stand below a diagram."""
        return tuple(corner["name"] for corner in self._fields["corners"])

    @property
    def corners(self) -> Floats:
        """The lengths of the corners along the path, shape (corners,); 1/length."""
        return np.array([corner["length"] for corner in self._fields["corners"]], dtype=np.float64)

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws frequencies along the path; waves that grow stand below zero, by their growth rate."""
        from . import _plots

        return _plots.bands(self, ax)


class Path(Answer):
    """Where along a path stability is lost and regained.

    ``material_onset`` and ``discretization_onset`` are the first losses, ``None`` where there is none: parameter, deformation gradient, Cauchy stress and wave.
    ``material_crossings`` and ``discretization_crossings`` are all changes.
    """

    __slots__ = ()

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws the softest mode of the particles and the smallest acoustic eigenvalue of the material along the path, side by side in the place of `ax`.

        Dashed lines are the changes between stable and unstable. The first of the two axes is returned."""
        from . import _plots

        return _plots.path(self.files()["path.csv"].decode(), self, ax)


class Boundary(Answer):
    """Where in the plane of a study material and particles lose stability, and how far apart the two boundaries are: ``fidelity``."""

    __slots__ = ()

    def geojson(self) -> dict[str, Any]:
        """The curves in the coordinates of the axes, as a FeatureCollection: the file ``boundary.geojson``."""
        return cast("dict[str, Any]", json.loads(self.files()["boundary.geojson"]))

    def curves(self) -> list[tuple[str, Floats]]:
        """Whose boundary each curve is, ``material`` or ``discretization``, and its points, shape (n, 2), in the units of the axes."""
        told = []
        for feature in self.geojson()["features"]:
            points = feature["geometry"]["coordinates"]
            points = points[0] if feature["geometry"]["type"] == "Polygon" else points
            told.append((cast(str, feature["properties"]["of"]), np.array(points, dtype=np.float64)))
        return told

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws the curves over the axes of the study."""
        from . import _plots

        return _plots.curves(self, ax)


class Modes(_Moving):
    """The zero-energy and weakly controlled modes of a method: ``modes``, each with ``wave_vector`` (1/length), ``fractional`` (in units of the reciprocal
    vectors) and ``relative_frequency``, whether it ``fits`` the patch that is drawn, and in ``fit`` the patch that it fits; ``complete`` is whether none can have been missed.
    """

    __slots__ = ()

    @asks
    def mode(self, number: int = 1, branch: int = 1, *, cells: int | Sequence[int] | None = None, amplitude: float = 0.1) -> Mode:
        """A mode in the reference configuration on a patch of particles: that with a `number` in the list, which counts from 1.

        `branch` counts the waves of its wave vector by increasing ``|omega^2|``: of a mode with the nullity n the first n have no energy. Other arguments as of
        `Waves.mode`.
        """
        listed = self._fields["modes"]
        if not listed:
            raise InputError("there are no spurious modes")
        k = np.array(listed[whole(number, "number", 1, len(listed)) - 1]["wave_vector"], dtype=np.float64)
        cell = self._cell()
        # Uniform displacements have no energy either.
        is_uniform = float(np.linalg.norm(k)) * cell.spacing < 1e-9
        # A mode without energy is told from others by them.
        size = float(np.max(np.abs(cell.dynamical_matrix(k + 0.5 / cell.spacing))))
        values, vectors = cell.waves(cell.dynamical_matrix(k), size=size, without_translations=is_uniform)
        own = int(np.argsort(np.abs(values), kind="stable")[whole(branch, "branch", 1, len(values)) - 1])
        return Mode(cell, k, values[own], vectors[:, own], cells, amplitude)


class Criteria(Answer):
    """Where along ``loadings`` each stability criterion is lost, and where the criteria disagree: ``disagreements``."""

    __slots__ = ()


class Card(Answer):
    """The safe range of a law: ``symmetric_box`` and ``widest_box`` of principal stretches, ``None`` where there is none, and limits along ``loadings``."""

    __slots__ = ()


class Localization(Answer):
    """Where along a loading a plastic material localizes, in which band: ``first_yield``, ``strong_ellipticity_lost`` and ``localization``, ``None`` where it does
    not come to it; moduli and stresses in the unit of stress, angles in degrees.
    """

    __slots__ = ()


class Comparison(Answer):
    """Methods side by side: ``rows``, each with what was ``measured``, or a ``note`` why it could not be."""

    __slots__ = ()


class Recommendation(Answer):
    """Methods ranked by ``rules``: ``ranking``, the recommended ones first and best first; the others have ``excluded``."""

    __slots__ = ()


class Tuning(Answer):
    """The smallest coefficient that is sufficient, and all values that were ``tried``."""

    __slots__ = ()

    @property
    def recommended(self) -> float | None:
        """The smallest value found that removes the spurious modes and masks nothing, in the unit of the key; ``None`` where none does."""
        return cast("float | None", self._fields["recommended"])


class Limit(Answer):
    """The values of a setting that admit a time step, ``admitted``, and all values that were ``tried``, each with its ``critical_time_step`` and ``verdict``."""

    __slots__ = ()

    @property
    def intervals(self) -> list[tuple[float, float]]:
        """The values that admit the step, each interval as its smallest and largest one, in the unit of the key."""
        return [(own["from"]["value"], own["to"]["value"]) for own in self.to_dict()["admitted"]]


class Audit(Answer):
    """Whether a law has an energy, and a consistent tangent: ``checks``, each with ``name``, ``outcome``, relative ``error`` and ``finding``."""

    __slots__ = ()

    @property
    def consistent(self) -> bool:
        """Whether no check fails."""
        return cast(bool, self._fields["consistent"])

    def raise_for_error(self) -> Audit:
        """The audit itself; an `InputError` with its text where a check fails."""
        if not self.consistent:
            raise InputError(str(self))
        return self

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws the error of each check on a logarithmic axis."""
        from . import _plots

        return _plots.checks(self, ax)


class Simulation(Answer):
    """A patch of particles in motion beside its prediction: ``outcome`` is ``agrees``, ``differs`` or ``undecided``; rates, ``predicted`` and ``measured``, in
    1/time.
    """

    __slots__ = ()

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws the measured rate beside the predicted one."""
        from . import _plots

        return _plots.rates(self, ax)


class Mapped(Answer):
    """What came of a map: numbers and shares of the ``verdicts``, and the store."""

    __slots__ = ()

    @property
    def store(self) -> str:
        """The folder of the store, as it was given."""
        return cast(str, self._fields["store"])

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws how many states of the map have which verdict."""
        from . import _plots

        return _plots.shares(self, ax)


class Verdicts:
    """Verdicts on many states: arrays of the shape (...) of the states, vectors with one more index. Numbers that do not exist are NaN."""

    #: The words of the verdicts, of which `codes` are the places.
    names: tuple[str, ...] = tuple(_onset.verdict_names())

    def __init__(self, columns: Mapping[str, bytes], shape: tuple[int, ...], dimension: int) -> None:
        def of(name: str) -> Floats:
            return received(columns[name], shape)

        #: The places of the verdicts in `names`, shape (...).
        self.codes: NDArray[np.int8] = of("verdict").astype(np.int8)
        #: The smallest ``Re omega^2 / (c^2 |k|_h^2)`` over the zone, shape (...); without dimension.
        self.scaled_minimum: Floats = of("scaled_minimum")
        #: The smallest ``Re omega^2`` over the zone, shape (...); 1/time^2.
        self.lowest_omega_squared: Floats = of("lowest_omega_squared")
        #: That of the fastest growing wave, zero where none grows, shape (...); 1/time.
        self.growth_rate: Floats = of("growth_rate")
        #: The largest stable time step of central differences, ``2/omega_max``, of the infinite lattice: free faces and distorted cells need less; shape (...); time.
        self.critical_time_step: Floats = of("critical_time_step")
        #: The smallest acoustic eigenvalue of the continuum, shape (...); stress.
        self.acoustic_minimum: Floats = of("acoustic_minimum")
        #: The reference wave vector of `scaled_minimum`, shape (..., D); 1/length.
        self.wave_vector: Floats = received(columns["wave_vector"], (*shape, dimension))
        #: The reference direction of `acoustic_minimum`, a unit vector, shape (..., D).
        self.acoustic_direction: Floats = received(columns["acoustic_direction"], (*shape, dimension))

    @property
    def verdict(self) -> NDArray[np.str_]:
        """The verdicts in words, shape (...)."""
        return np.array(self.names)[self.codes]

    def count(self) -> dict[str, int]:
        """How many states have which verdict."""
        counts = np.bincount(self.codes.ravel(), minlength=len(self.names))
        return {name: int(count) for name, count in zip(self.names, counts, strict=True)}

    def __len__(self) -> int:
        return self.codes.size

    def __repr__(self) -> str:
        told = ", ".join(f"{count} {name}" for name, count in self.count().items() if count)
        return f"<onset.Verdicts on {self.codes.size} states: {told}>"

    def _repr_html_(self) -> str:
        rows = "".join(f"<tr><td>{html.escape(name)}</td><td>{count}</td></tr>" for name, count in self.count().items())
        return f"<table>{rows}</table>"

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws how many states have which verdict."""
        from . import _plots

        return _plots.bars(list(self.count()), list(self.count().values()), "states", ax)


class Dispersion:
    """Waves of one state with many wave vectors."""

    def __init__(self, k: Floats, omega_squared: Complexes, continuum: Floats) -> None:
        #: The reference wave vectors, shape (..., D); 1/length.
        self.k: Floats = k
        #: ``omega^2`` of the particles by increasing real part, shape (..., branches); 1/time^2.
        self.omega_squared: Complexes = omega_squared
        #: ``omega^2`` of the continuum, shape (..., D); 1/time^2.
        self.continuum_omega_squared: Floats = continuum

    @property
    def frequencies(self) -> Floats:
        """``Re omega``, shape (..., branches); 1/time."""
        return np.asarray(np.sqrt(self.omega_squared).real, dtype=np.float64)

    @property
    def growth_rates(self) -> Floats:
        """How fast waves grow, ``|Im omega|``, zero where they do not, shape (..., branches); 1/time."""
        return np.asarray(np.abs(np.sqrt(self.omega_squared).imag), dtype=np.float64)

    def __repr__(self) -> str:
        return f"<onset.Dispersion of {self.k[..., 0].size} wave vectors, {self.omega_squared.shape[-1]} branches>"

    def _repr_html_(self) -> str:
        return f"<p>{html.escape(repr(self))}</p>"

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws ``omega^2`` (1/time^2) against the length of the wave vector (1/length)."""
        from . import _plots

        return _plots.scatter(self, ax)
